//! A motor that is turned, one sample at a time.

use super::ahead::Ahead;
use super::law::{Follow, Seek};
use super::order::{Agenda, Entry, Order, PIECES, Pieces};
use super::setup::{Setup, Shaping};
use super::warmth::{Before, Warmth};
use crate::actuator::fault::Fault;
use crate::actuator::link::carrier::Rectifier;
use crate::actuator::link::diodes::Diodes;
use crate::actuator::link::effective::Effective;
use crate::actuator::motor::{Level, Motor, Plan};
use crate::actuator::protect::budget::Bears;
use crate::actuator::protect::counts;

/// Share of the full speed below which a motor counts as standing.
const STANDS: f64 = 1e-4;

/// Of a level backward, what is no wish: the corners of envelopes swing about their ends by as much.
const NOTHING: f64 = 0.02;

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
    mode: Mode,
    /// Whose order is under way.
    voice: Option<u64>,
    /// Whether the motor is elsewhere than where levels have it.
    away: bool,
    /// Which way a switching drive goes.
    forward: bool,
    /// What it made itself by turning, on average over the last sample, V.
    emf: f64,
    clock: u64,
    counts: Counts,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// As levels say.
    Level,
    /// To a speed; and at rest, a click. Since when.
    Speed(f64, Option<Pieces>, u64),
    /// A click: the piece that is under way, and when it ends, in samples.
    Click(Pieces, usize, f64),
    /// A drive.
    On(f64),
    /// Nothing, until it stands or levels call.
    Roll,
}

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples in which the limit kept the motor from what was played.
    pub limited: u64,
    /// Levels that were no numbers, and counted as 0.
    pub masked: u64,
    /// Orders that found no room.
    pub dropped: u64,
    /// Samples (of a level beyond 0.02) and orders that were for the way that diodes do not let, and are nothing.
    pub backward: u64,
    /// Of a motor that is there for clicks alone: samples of levels and orders that were none.
    pub unplayed: u64,
    /// Clicks of which some did not arrive, and which so turn the mass less far.
    pub cut: u64,
    /// Clicks that began weaker than they were ordered, as the motor had become warm, and so turn the mass less far.
    pub weakened: u64,
    /// Clicks that were not begun, as the motor was too warm for what would turn it.
    pub refused: u64,
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
            || matches!(setup.shaping, Shaping::Overdrive | Shaping::Switching);
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
            mode: Mode::Level,
            voice: None,
            away: false,
            forward: true,
            emf: 0.0,
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

    /// What was held back so that the motor bears it; `None` where nothing would be. Samples are those of the device.
    pub fn held_back(&self) -> Option<counts::Counts> {
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

    /// Whether nothing is sent, nothing waits and the motor stands.
    pub fn is_idle(&self) -> bool {
        self.agenda.is_empty() && self.rests()
    }

    /// Whether nothing is sent and the motor stands, whatever waits.
    pub fn rests(&self) -> bool {
        self.mode == Mode::Level && self.ahead.is_still() && self.stands()
    }

    /// An order of a voice at an instant: samples since the beginning, the same in which levels are counted. The release of a voice that has
    /// no order here is nothing.
    pub fn order(&mut self, at: f64, voice: u64, order: Order) {
        if order == Order::Release && self.voice != Some(voice) && !self.agenda.has(voice) {
            return;
        }
        let at = if at.is_finite() { at.max(0.0) } else { self.clock as f64 } + self.late() as f64;
        self.agenda.push(Entry { at, voice, order });
    }

    /// Forgets what waits, and brakes.
    pub fn brake(&mut self) {
        self.agenda.clear();
        self.carry_out(Entry { at: self.clock as f64, voice: u64::MAX, order: Order::Brake });
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
        self.emf = 0.0;
        let clicks_alone = self.setup.shaping == Shaping::Clicks;
        self.counts.unplayed += u64::from(clicks_alone && level.abs() > NOTHING);
        let level = if clicks_alone { 0.0 } else { level };
        let speeds = self.ahead.step(self.setup.speed_of(level));
        // Orders that are not due yet change nothing: they may come early or late, with the blocks of the caller.
        if speeds == [0.0; 3] && self.due().is_none() && self.rests() {
            parts.fill(0.0);
            self.clock += 1;
            self.moved = false;
            return;
        }
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

    /// When the next order is due, in samples, if it is in this one. Releases of voices whose orders hold no longer are nothing, and are
    /// forgotten: they must not part a sample either.
    fn due(&mut self) -> Option<f64> {
        let end = (self.clock + 1) as f64;
        while let Some(first) = self.agenda.first().filter(|first| first.at < end) {
            if self.heeds(first) {
                return Some(first.at);
            }
            self.agenda.pop_before(end);
        }
        None
    }

    fn heeds(&self, entry: &Entry) -> bool {
        entry.order != Order::Release || self.voice == Some(entry.voice)
    }

    fn carry_out(&mut self, entry: Entry) {
        if !self.heeds(&entry) {
            return;
        }
        let Entry { voice, order, .. } = entry;
        if self.setup.one_way && order.is_backward() {
            self.counts.backward += 1;
            return;
        }
        if self.setup.shaping == Shaping::Clicks && matches!(order, Order::Spin(_) | Order::On(_)) {
            self.counts.unplayed += 1;
            return;
        }
        match order.sane(self.setup.full_speed(), self.setup.limit) {
            Order::Click(pieces) => {
                // At rest it begins at once.
                self.mode = Mode::Speed(0.0, Some(pieces), self.clock);
                self.voice = None;
            }
            Order::Spin(speed) => {
                self.mode = Mode::Speed(speed, None, self.clock);
                self.voice = Some(voice);
            }
            Order::On(drive) => {
                self.mode = Mode::On(drive);
                self.voice = Some(voice);
            }
            Order::Release => {
                self.voice = None;
                self.mode = match self.mode {
                    Mode::On(_) => Mode::Roll,
                    _ => Mode::Speed(0.0, None, self.clock),
                };
            }
            Order::Brake => {
                self.voice = None;
                self.mode = Mode::Speed(0.0, None, self.clock);
            }
        }
        self.away = true;
    }

    /// Goes on to what comes behind what has been reached, at this instant (samples).
    fn arrive(&mut self, now: f64, speeds: &[f64; 3]) {
        if self.mode == Mode::Roll && (*speeds != [0.0; 3] || self.stands()) {
            self.mode = Mode::Level;
        }
        if let Mode::Speed(0.0, click, since) = self.mode {
            let waited = (self.clock - since) as f64 > PATIENCE * self.setup.rate;
            if self.voice.is_none() && (self.stands() || waited) {
                self.mode = match click {
                    Some(pieces) if self.begins(&pieces) => {
                        Mode::Click(pieces, 0, now + pieces.list[0].0 * self.setup.rate)
                    }
                    _ => Mode::Level,
                };
            }
        }
        while let Mode::Click(pieces, piece, ends) = self.mode {
            if ends > now {
                break;
            }
            self.mode = match pieces.list.get(piece + 1) {
                _ if self.cut => Mode::Speed(0.0, None, self.clock),
                Some((seconds, _)) if piece + 1 < PIECES => {
                    Mode::Click(pieces, piece + 1, ends + seconds * self.setup.rate)
                }
                _ => Mode::Level,
            };
        }
    }

    /// Whether a click is begun. One that is weaker than it was ordered is slower than its pieces have it: it ends as one of which some did not arrive.
    fn begins(&mut self, click: &Pieces) -> bool {
        self.cut = false;
        let Some(warmth) = &mut self.warmth else { return true };
        let share = warmth.click(click);
        self.cut = share < 1.0;
        self.counts.weakened += u64::from(share > 0.0 && share < 1.0);
        self.counts.refused += u64::from(share == 0.0);
        share > 0.0
    }

    /// What of that the motor bears.
    fn held(&mut self, given: f64) -> f64 {
        let Some(warmth) = &mut self.warmth else { return given };
        if !matches!(self.mode, Mode::Click(..) | Mode::Speed(0.0, ..)) {
            warmth.no_click();
        }
        let held = warmth.hold(given);
        // The inverse knows nothing of it, and would take the motor to be where it should be.
        self.away |= held != given && self.mode == Mode::Level;
        held
    }

    /// What is sent from now on; `whole`: at the beginning of a sample.
    fn given(&mut self, speeds: &[f64; 3], whole: bool) -> f64 {
        let (speed, current) =
            self.motor.as_ref().map_or((0.0, 0.0), |motor| (motor.speed(), motor.current()));
        let (least, limit) = (self.setup.least(), self.setup.limit);
        match self.mode {
            Mode::Speed(wished, ..) => self.seek.step(speed, current, wished),
            Mode::Click(pieces, piece, _) => pieces.list.get(piece).map_or(0.0, |piece| piece.1),
            Mode::On(drive) => drive,
            Mode::Roll => 0.0,
            Mode::Level => match self.setup.shaping {
                Shaping::Plain => self.setup.held_by(speeds[0]).clamp(least, limit),
                Shaping::Overdrive => self.seek.step(speed, current, speeds[1]),
                Shaping::Switching => self.switched(speed, current, speeds[1]),
                Shaping::Clicks => self.seek.step(speed, current, 0.0),
                _ if self.away && *speeds == [0.0; 3] && self.stands() => 0.0,
                Shaping::Inverse if self.away => {
                    // Also the current must have died away: the inverse would take it, and what it is still to do, at once.
                    let off = self.seek.off(speed, current, speeds[0]).abs();
                    let left = (speed - speeds[0]).abs();
                    if off.max(left) < STANDS * self.setup.full_speed() && whole {
                        self.away = false;
                        self.follow.restart(current);
                        return self.followed(speeds);
                    }
                    self.seek.step(speed, current, speeds[1])
                }
                Shaping::Inverse => self.followed(speeds),
            },
        }
    }

    fn followed(&mut self, speeds: &[f64; 3]) -> f64 {
        let (given, limited) = self.follow.step(*speeds);
        self.counts.limited += u64::from(limited);
        given
    }

    fn switched(&mut self, speed: f64, current: f64, wished: f64) -> f64 {
        let off = wished - speed;
        // What is to stand is not kept swinging about rest.
        if wished == 0.0 && off.abs() <= self.seek.most() {
            return self.seek.step(speed, current, wished);
        }
        if off != 0.0 {
            self.forward = off > 0.0;
        }
        if self.forward { self.setup.limit } else { self.setup.least() }
    }

    fn stands(&self) -> bool {
        let Some(motor) = &self.motor else { return true };
        motor.is_stuck()
            && motor.current().abs() * self.setup.parameters.gain <= self.setup.parameters.stiction
            || self.seek.off(motor.speed(), motor.current(), 0.0).abs() < STANDS * self.setup.full_speed()
                && motor.speed().abs() < STANDS * self.setup.full_speed()
    }

    /// Moves the model on, and says what is sent meanwhile.
    fn move_model(&mut self, given: f64, share: f64) -> f64 {
        let Some(motor) = &mut self.motor else { return given };
        let (gain, before, was) = (self.setup.parameters.gain, motor.speed(), Before::of(motor));
        // So close above what the motor makes itself, what flows is nothing, and the carrier for it would be all but none.
        let blocked = self.setup.one_way && given <= gain * before.max(0.0) + OPENS * self.setup.limit;
        if blocked {
            // What the coil still holds goes on through the diodes.
            self.diodes.part(motor, 0.0, share, |_, _, _| {});
        } else {
            motor.drive(self.setup.drive(given));
            if share == 1.0 { motor.step() } else { motor.part(share) }
        }
        let emf = 0.5 * gain * (before + motor.speed());
        self.emf += share * emf;
        if let Some(warmth) = &mut self.warmth {
            warmth.note(given, share, was, motor, blocked);
        }
        match self.setup.one_way {
            true if blocked => 0.0,
            true => (given - emf).max(0.0),
            false => given,
        }
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
