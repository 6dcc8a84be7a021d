//! A motor that is turned, one sample at a time.

mod counts;
mod given;
mod known;
mod orders;
mod staged;

pub use counts::Counts;

use known::{Aim, Click};
use std::sync::Arc;

use super::ahead::Ahead;
use super::hanging::Hanging;
use super::law::{Follow, Seek};
use super::order::{After, Agenda, Pieces, Switch};
use super::setup::{Setup, Shaping, Stage};
use super::track::Track;
use super::warmth::Warmth;
use crate::actuator::fault::Fault;
use crate::actuator::link::carrier::Rectifier;
use crate::actuator::link::diodes::Diodes;
use crate::actuator::link::effective::Effective;
use crate::actuator::motor::{Level, Motor, Plan};
use crate::actuator::protect::budget::Bears;
use crate::actuator::protect::counts::Counts as HeldBack;

/// Of a level backward, what is no wish: the corners of envelopes swing about their ends by as much.
const NOTHING: f64 = 0.02;

/// Share of the full speed by which it may fall short of what is played and is not said to.
const ALIKE: f64 = 0.01;

/// Share of the limit by which a voltage behind diodes must be above what the motor makes itself.
const OPENS: f64 = 1e-3;

/// Seconds after which what is to begin at rest begins without it: a mass that nothing holds swings for long.
const PATIENCE: f64 = 0.25;

/// Turns a motor: levels and orders in, volts or amperes out.
///
/// It neither allocates nor locks, and what it does for a sample is bounded. What comes out is no more than the limit, whatever comes in. It
/// is as late as [`Turner::late`] says, levels and orders alike.
#[derive(Debug, Clone)]
pub struct Turner {
    setup: Setup,
    ahead: Ahead,
    follow: Follow,
    seek: Seek,
    /// The model; none where nothing needs it.
    motor: Option<Box<Motor>>,
    /// What stands before it, where that lets current in alone.
    diodes: Diodes,
    /// The model as it was before the last sample, where less may arrive than is sent.
    before: Option<Box<Motor>>,
    /// Whether the last sample moved the model.
    moved: bool,
    /// Whether something of the click that is under way did not arrive, or was not sent.
    cut: bool,
    /// What keeps it as cool as it must be; nothing where nothing is known of that.
    warmth: Option<Box<Warmth>>,
    agenda: Agenda,
    /// Envelopes that may be ordered.
    tracks: Vec<Arc<Track>>,
    mode: Mode,
    /// Whose order is under way.
    voice: Option<u64>,
    /// Whether the motor is elsewhere than where levels have it.
    away: bool,
    /// Whether it is to stand, whatever is ordered and played, and whether nothing is sent to that end.
    halts: bool,
    rests: bool,
    /// Which way a switching drive goes.
    forward: bool,
    /// Where the mass hangs, since it was home; `None`: that is not known.
    hangs: Option<Hanging>,
    /// What the click that is under way is for.
    aim: Aim,
    /// The way home that was ordered last.
    way: Pieces,
    /// Samples of rest so far.
    rested: u64,
    /// Of levels that switch: which way it is on, 1 or -1, or 0; and whether a motor that is faster than it is to be was let go.
    on: f64,
    rolls: bool,
    /// What it made itself by turning, on average over the last sample, V.
    emf: f64,
    /// The speed that was wished for in the last sample, rad/s.
    wished: f64,
    clock: u64,
    counts: Counts,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// As levels say.
    Level,
    /// To a speed; and at rest, a click. Since when.
    Speed(f64, Option<Click>, u64),
    /// A click: the piece that is under way, and when it ends, in samples.
    Click(Pieces, usize, f64),
    /// A drive.
    On(Switch),
    /// What follows a drive, until it stands or levels call.
    Roll(After),
    /// A speed, as levels are shaped.
    Keep(f64, Shaping),
    /// An envelope that is known as a whole.
    Swell(Swell),
}

/// An envelope that is under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Swell {
    number: u32,
    root: f64,
    /// In samples.
    begin: f64,
    shaping: Shaping,
}

impl Turner {
    /// At rest, at least so many samples late.
    ///
    /// # Errors
    /// A number beyond its limits.
    pub fn new(setup: &Setup, late: usize) -> Result<Self, Fault> {
        setup.check()?;
        let setup = &setup.on_average();
        let tracks = setup.ordered
            || setup.one_way
            || matches!(setup.shaping, Shaping::Overdrive | Shaping::Switching | Shaping::OnOff)
            || setup.stage != Stage::default();
        let loses = setup.shaping == Shaping::Clicks;
        let model = || model(setup);
        Ok(Self {
            setup: *setup,
            ahead: Ahead::new(setup, late),
            follow: Follow::new(setup),
            seek: Seek::new(setup),
            motor: if tracks { Some(model()?) } else { None },
            diodes: Diodes::new(Rectifier { full_wave: true, drop: setup.diode_drop }, setup.rate),
            before: if tracks && loses { Some(model()?) } else { None },
            moved: false,
            cut: false,
            warmth: None,
            agenda: Agenda::default(),
            tracks: Vec::new(),
            mode: Mode::Level,
            voice: None,
            away: false,
            halts: false,
            rests: false,
            forward: true,
            hangs: None,
            aim: Aim::Pieces,
            way: Pieces::default(),
            rested: 0,
            on: 0.0,
            rolls: false,
            emf: 0.0,
            wished: 0.0,
            clock: 0,
            counts: Counts::default(),
        })
    }

    /// The same, of a motor that bears no more than that for long, when its drives amount to this.
    ///
    /// # Errors
    /// A number beyond its limits.
    pub fn bearing(mut self, bears: &Bears, effective: Effective) -> Result<Self, Fault> {
        self.warmth = Some(Box::new(Warmth::new(&self.setup, bears, effective)?));
        if self.motor.is_none() {
            self.motor = Some(model(&self.setup)?);
        }
        Ok(self)
    }

    /// Begins at this sample of the clock by which orders are given, not at 0. Before its first step.
    pub fn begin_at(&mut self, clock: u64) {
        self.clock = clock;
    }

    /// As warm as another motor was on the same output; what was counted there counts on here.
    pub fn warm_as(&mut self, other: &mut Self) {
        self.counts = std::mem::take(&mut other.counts);
        if let (Some(own), Some(other)) = (&mut self.warmth, &other.warmth) {
            own.warm_as(other);
        }
    }

    /// The same, of which these envelopes may be ordered, by their places.
    pub fn knowing(mut self, tracks: Vec<Arc<Track>>) -> Self {
        self.tracks = tracks;
        self
    }

    /// What was held back so that the motor bears it; `None` where nothing would be. Samples are those of the device.
    pub fn held_back(&self) -> Option<HeldBack> {
        self.warmth.as_ref().map(|warmth| warmth.counts())
    }

    /// The motor's winding, kelvins above the air; `None` where its heat is not watched.
    pub fn temperature(&self) -> Option<f64> {
        self.warmth.as_ref()?.temperature()
    }

    /// What it turns, and how.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// By how many samples what comes out is later than what is played.
    pub fn late(&self) -> usize {
        self.ahead.late()
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        Counts { dropped: self.agenda.dropped(), ..self.counts }
    }

    /// The motor's model, where there is one.
    pub fn motor(&self) -> Option<&Motor> {
        self.motor.as_deref()
    }

    /// What the motor made itself by turning, on average over the last sample, V; where there is no model, 0.
    pub fn emf(&self) -> f64 {
        self.emf
    }

    /// The speed that was wished for in the sample that was taken last, rad/s, as late as what is sent: that of the level that is played, or of what is
    /// ordered in its place. Of a click, a brake and a drive that is switched on, 0.
    pub fn wished(&self) -> f64 {
        self.wished
    }

    /// Whether nothing is sent, nothing waits and the motor stands.
    pub fn is_idle(&self) -> bool {
        self.agenda.is_empty() && self.rests() && !self.waits_to_park()
    }

    /// Whether nothing is sent and the motor stands, whatever waits.
    pub fn rests(&self) -> bool {
        self.mode == Mode::Level && self.ahead.is_still() && self.stands()
    }

    /// Takes the level of this sample, and gives what is sent: its mean over each of so many equal parts of the sample. Of a motor that turns
    /// one way it is what is sent beyond [`Turner::emf`], R i on average, and 0 where nothing is to flow.
    pub fn step(&mut self, level: f64, parts: &mut [f64]) {
        if let Some(warmth) = &mut self.warmth {
            warmth.pass(parts.len());
        }
        self.counts.masked += u64::from(!level.is_finite());
        let level = if level.is_finite() { level } else { 0.0 };
        let backward = self.setup.one_way && level < -NOTHING;
        self.counts.backward += u64::from(backward);
        let level = if self.setup.one_way { level.max(0.0) } else { level };
        (self.emf, self.wished) = (0.0, 0.0);
        let clicks_alone = self.setup.shaping == Shaping::Clicks;
        self.counts.unplayed += u64::from(clicks_alone && level.abs() > NOTHING);
        let level = if clicks_alone { 0.0 } else { level };
        let speeds = self.ahead.step(self.setup.speed_of(level));
        // Orders that are not due yet change nothing: they may come early or late, with the blocks of the caller.
        if speeds == [0.0; 3] && self.due().is_none() && self.rests() {
            self.park();
        }
        if speeds == [0.0; 3] && self.due().is_none() && self.rests() {
            self.on = 0.0;
            parts.fill(0.0);
            self.clock += 1;
            self.moved = false;
            return;
        }
        let level_wish = self.ahead.short()[0].abs().max(speeds[0].abs()).copysign(speeds[0]);
        let [played, short] = self.ahead.short().map(|speed| speed / self.setup.full_speed());
        let limited = self.counts.limited;
        if let (Some(before), Some(motor)) = (&mut self.before, &self.motor) {
            **before = (**motor).clone();
            self.moved = true;
        }
        parts.fill(0.0);
        let (begin, mut done) = (self.clock as f64, 0.0);
        // Each turn ends the sample, an order or a piece of a click.
        while done < 1.0 {
            while let Some(entry) = self.agenda.pop_before(begin + done + f64::EPSILON * begin.max(1.0)) {
                self.carry_out(entry);
            }
            self.arrive(begin + done, &speeds);
            let given = self.given(&speeds, done == 0.0);
            let given = self.held(given);
            let mut until = 1.0;
            self.foresee(begin + done, given, 1.0 - done);
            if let Mode::Click(_, _, ends) = self.mode {
                until = (ends - begin).min(until);
            }
            if let Some(due) = self.due() {
                until = (due - begin).min(until);
            }
            // Never so short that it would stand still.
            let until = until.clamp((done + 1e-9).min(1.0), 1.0);
            let given = self.move_model(given, until - done);
            spread(parts, done, until, given);
            done = until;
        }
        self.come_home();
        self.wished = self.wish(level_wish);
        if self.mode == Mode::Level && played > 0.0 {
            self.counts.played += played;
            self.counts.missed += short;
            self.counts.limited = self.counts.limited.max(limited + u64::from(short > ALIKE));
        }
        self.clock += 1;
    }

    /// What of the sample that was taken last reached the terminals, in equal parts, where that is not what was sent: the model moves by that
    /// instead. A click that lost some of its beginning ends with what it still has of speed braked away, and is not driven backward for as long as it was meant to be.
    /// Of a motor that is there for clicks alone.
    pub fn arrived(&mut self, parts: &[f64]) {
        let (Some(before), Some(motor)) = (&self.before, &mut self.motor) else { return };
        if self.moved {
            **motor = (**before).clone();
        }
        for part in parts {
            motor.drive(self.setup.drive(*part));
            motor.part(1.0 / parts.len() as f64);
        }
        if matches!(self.mode, Mode::Click(..)) && !self.cut {
            self.cut = true;
            self.counts.cut += 1;
        }
    }

    /// What of the sample that was taken last flows, of a current, in equal parts: where that may be something else than what was sent. The model does not
    /// move by it.
    pub fn flowed(&mut self, parts: &[f64]) {
        if let Some(warmth) = &mut self.warmth {
            warmth.flowed(parts);
        }
    }

    /// What of that the motor bears.
    fn held(&mut self, given: f64) -> f64 {
        let Some(warmth) = &mut self.warmth else { return given };
        if !matches!(self.mode, Mode::Click(..) | Mode::Speed(0.0, ..)) {
            warmth.no_click();
        }
        let held = warmth.hold(given);
        // The inverse knows nothing of it, and would take the motor to be where it should be.
        self.away |= held != given && matches!(self.mode, Mode::Level | Mode::Swell(_));
        if held != given && matches!(self.aim, Aim::Home(_)) {
            self.aim = Aim::Pieces;
        }
        held
    }
}

/// What is known of how it moves.
fn model(setup: &Setup) -> Result<Box<Motor>, Fault> {
    let gravity = setup.parameters.gravity > 0.0;
    let plan = Plan { casing: false, gravity, ..Plan::whole(Level::Default) };
    Motor::new(&setup.parameters, &plan, setup.rate).map(Box::new)
}

/// Adds what holds between two shares of a sample to the means over its parts.
fn spread(parts: &mut [f64], from: f64, to: f64, value: f64) {
    if from == 0.0 && to == 1.0 {
        return parts.fill(value);
    }
    let count = parts.len() as f64;
    let (from, to) = (from * count, to * count);
    for (n, part) in parts.iter_mut().enumerate() {
        let begin = n as f64;
        let overlap = to.min(begin + 1.0) - from.max(begin);
        if overlap > 0.0 {
            *part += overlap * value;
        }
    }
}
