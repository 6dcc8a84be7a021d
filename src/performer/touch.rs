//! What the hand that holds a voice does while it sounds.

use super::{Happening, Outlet, Performer, When, full, in_time};
use crate::engine::event::{Event, Move, Source};
use crate::graph::plan::Plan;
use crate::midi::{Channel, Expression, What};
use crate::node::motion::Motion;
use crate::text::Problem;

/// Moves a voice that sounds, apart from all others. Its nodes read it as `touch.bend`, `touch.pressure` and `touch.timbre`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Touch {
    /// Bends its frequency by so many semitones, 120 at most either way; 0 at rest.
    Bend(f64),
    /// Presses it so hard, 0, at rest, to 1.
    Pressure(f64),
    /// Holds it there across the key, 0 to 1; 64/127 at rest.
    Timbre(f64),
}

impl Touch {
    /// A part of what MIDI says of a note.
    pub fn of(what: What, value: f64) -> Self {
        match what {
            What::Bend => Self::Bend(value),
            What::Pressure => Self::Pressure(value),
            What::Timbre => Self::Timbre(value),
        }
    }

    /// All that MIDI says of a note.
    pub(super) fn all(of: Expression) -> [Self; 3] {
        [Self::Bend(of.bend), Self::Pressure(of.pressure), Self::Timbre(of.timbre)]
    }

    /// As nodes hear it, within what they may.
    pub fn motion(self) -> (Motion, f64) {
        let (motion, value) = match self {
            Self::Bend(semitones) => (Motion::Detune, Motion::detune(semitones.clamp(-120.0, 120.0))),
            Self::Pressure(value) => (Motion::Pressure, value),
            Self::Timbre(value) => (Motion::Timbre, value),
        };
        (motion, motion.within(value).unwrap_or(motion.rest()))
    }

    fn value(self) -> f64 {
        let (Self::Bend(value) | Self::Pressure(value) | Self::Timbre(value)) = self;
        value
    }
}

/// Which motions each instrument of a plan hears.
pub(super) fn heard(plan: &Plan) -> Vec<[bool; 3]> {
    plan.instruments.iter().map(crate::graph::plan::Instrument::hears).collect()
}

/// Seconds between two moves of one kind that a key sends to one voice: shorter than voices take to follow.
const SPACING: f64 = 0.001;

/// Events for which a key's moves leave room, so that notes still find it.
pub(super) const RESERVED: usize = 512;

/// A voice that a key has started and that is down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    /// The key, and its channel.
    pub key: u32,
    pub channel: Channel,
    /// The voice's id.
    pub voice: u64,
    /// Whether it sounds for as long as the key is down.
    pub holds: bool,
    /// Its instrument, and what that hears.
    pub instrument: u32,
    hears: [bool; 3],
    moves: [Moved; 3],
}

/// How far it was moved in one way.
#[derive(Debug, Clone, Copy)]
struct Moved {
    value: f64,
    /// Whether its voice does not know yet.
    waits: bool,
    /// From when on it may be told, in seconds.
    free: f64,
}

impl Held {
    /// With what was known at its onset, of which the voice does not know yet.
    pub fn new(
        (key, channel): (u32, Channel),
        voice: u64,
        holds: bool,
        instrument: u32,
        hears: [bool; 3],
        expression: Expression,
    ) -> Self {
        let moves = Touch::all(expression).map(|touch| {
            let (motion, value) = touch.motion();
            Moved { value, waits: hears[motion.number()] && value != motion.rest(), free: f64::NEG_INFINITY }
        });
        Self { key, channel, voice, holds, instrument, hears, moves }
    }

    /// Its key moves.
    pub fn moved(&mut self, touch: Touch) {
        let (motion, value) = touch.motion();
        let moved = &mut self.moves[motion.number()];
        moved.waits |= self.hears[motion.number()] && moved.value != value;
        moved.value = value;
    }

    /// Its instrument has become another, which hears other motions.
    pub fn become_of(&mut self, instrument: u32, hears: [bool; 3]) {
        for motion in Motion::ALL {
            let (number, moved) = (motion.number(), &mut self.moves[motion.number()]);
            let new = hears[number] && !self.hears[number] && moved.value != motion.rest();
            moved.waits = hears[number] && (moved.waits || new);
        }
        (self.instrument, self.hears) = (instrument, hears);
    }

    /// When it may be told what it does not know yet, and of which motion that is.
    fn due(&self) -> Option<(f64, Motion)> {
        let waits = Motion::ALL.into_iter().filter(|motion| self.moves[motion.number()].waits);
        let due = waits.map(|motion| (self.moves[motion.number()].free, motion));
        due.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Performer {
    /// Moves the hand that holds a voice. Where no node hears that, nothing happens.
    ///
    /// # Errors
    /// A value that is not finite, a time before the beginning or past [`crate::score::HORIZON`], or no room at the outlet.
    pub fn touch(&mut self, at: When, id: u64, touch: Touch, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        in_time(at)?;
        if !touch.value().is_finite() {
            let what = format!("a voice cannot be touched so: {touch:?}");
            return Err(Problem::of_file(what).help("give a finite number".to_string()));
        }
        let (motion, value) = touch.motion();
        if !self.hears.iter().any(|hears| hears[motion.number()]) {
            return Ok(());
        }
        if self.send_move(at, Move { id, motion, value }, outlet) { Ok(()) } else { Err(full()) }
    }

    fn send_move(&mut self, at: When, to: Move, outlet: &mut dyn Outlet) -> bool {
        let sent =
            self.order(at, Event::Touch(to), Some(to.id), Happening::Touch(to.motion, to.value), outlet);
        if let Some(moves) = self.moves.as_mut().filter(|_| sent) {
            moves.push((at.seconds, to));
        }
        sent
    }

    /// How voices that keys hold were moved since [`Performer::record`], and those that the program moved.
    pub fn recorded_moves(&self) -> &[(f64, Move)] {
        self.moves.as_deref().unwrap_or_default()
    }

    /// When a voice may be told next how its key has moved; `None` where all know.
    pub(super) fn next_move(&self) -> Option<f64> {
        let held = self.hands.iter().flat_map(|hands| &hands.held);
        held.filter_map(|held| held.due().map(|(at, _)| at)).min_by(f64::total_cmp)
    }

    /// Tells the voices of a port how their keys have moved, as far as they may be told `at` and there is room; what is due
    /// earlier is told as of now.
    pub(super) fn tell_moves(&mut self, at: When, port: usize, outlet: &mut dyn Outlet) {
        let Some(hands) = self.hands.get_mut(port) else { return };
        let mut held = std::mem::take(&mut hands.held);
        for voice in &mut held {
            self.tell_voice(at, voice, false, outlet);
        }
        self.hands[port].held = held;
    }

    /// The same for one voice; with `all`, what may be told only later too.
    pub(super) fn tell_voice(&mut self, at: When, voice: &mut Held, all: bool, outlet: &mut dyn Outlet) {
        while let Some((free, motion)) = voice.due() {
            if (free > at.seconds && !all) || outlet.room(Source::Program) <= RESERVED {
                return;
            }
            let value = voice.moves[motion.number()].value;
            if !self.send_move(at, Move { id: voice.voice, motion, value }, outlet) {
                return;
            }
            let moved = &mut voice.moves[motion.number()];
            (moved.waits, moved.free) = (false, at.seconds + SPACING);
        }
    }
}
