//! What reaches the engine: plain copies of a fixed size.

use crate::graph::answer::Voiced;
use crate::graph::places::Strength;
use crate::graph::start::{FIELDS, Fields};
use crate::node::motion::Motion;
use crate::space::spot::Spot;

/// A voice is to sound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Play {
    /// The instrument, by its place in the plan.
    pub instrument: u32,
    /// Where: a row of [`crate::graph::plan::Plan::places`], or a point that tactors share.
    pub place: Spot,
    /// 1 for a full one.
    pub level: f64,
    /// Decibels above the threshold that a level of 1 is to be felt like, on every tactor; `None`: as loud as it comes.
    pub felt: Option<f64>,
    /// Seconds until its release; infinite for one that is held.
    pub duration: f64,
    /// The instrument's own fields, in the order in which it declares them.
    pub own: [f64; FIELDS],
    /// Names the voice, for its release and for its random numbers.
    pub id: u64,
}

impl Play {
    /// What is set off, under an id.
    pub(crate) fn of(voiced: &Voiced, id: u64) -> Self {
        let &Voiced { instrument, place, level, felt, duration, own } = voiced;
        Self { instrument, place, level, felt, duration, own, id }
    }

    /// Whether its id agrees with `id` but for so many of the lowest bits.
    pub(crate) fn is_of(&self, id: u64, bits: u8) -> bool {
        is_of(self.id, id, bits)
    }

    /// How strong it is.
    pub(crate) fn strength(&self) -> Strength {
        Strength { level: self.level, felt: self.felt, frequency: self.own[0] }
    }

    /// What start programs read of it.
    pub(crate) fn fields(&self) -> Fields {
        Fields { level: self.level, duration: self.duration, own: self.own }
    }
}

/// Whether two ids agree but for so many of the lowest bits.
pub fn is_of(a: u64, b: u64, bits: u8) -> bool {
    (a ^ b).checked_shr(u32::from(bits)).unwrap_or(0) == 0
}

/// The hand that holds voices moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Which voices: those of that id.
    pub id: u64,
    /// In which way.
    pub motion: Motion,
    /// How far.
    pub value: f64,
}

/// What is due at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Start a voice.
    Play(Play),
    /// Release the voices of that id that still sound.
    Release(u64),
    /// Move voices that still sound. At the instant of its onset a voice begins there; later it goes there in the time that its
    /// nodes say. What is no number is ignored.
    Touch(Move),
    /// Move a control, by its place in the plan, to a value.
    Control(u32, f64),
    /// Move a control, by its place in the plan, to a value within so many seconds, whatever its smoothing is.
    Glide(u32, f64, f64),
    /// Release everything.
    ReleaseAll,
    /// Let all voices fall silent at once, whatever their envelopes say, whose ids agree with this one but for so many of their lowest
    /// bits; those of them that are still to begin do not. Where no other voice
    /// sounds, all but the pulses of markers is exact zero 2 ms later (what turns motors 4 ms, in which they are braked), until one does.
    Silence(u64, u8),
    /// Call off voices and markers that are still to begin and whose ids agree with this one but for so many of their lowest bits, and release
    /// those voices of them that sound: their pattern stops here.
    Cancel(u64, u8),
    /// Put a pulse on the trigger outputs that listen to this marker, by its place in
    /// [`crate::graph::plan::Plan::markers`]; to one that is not there only outputs for all markers listen. Behind it the id by
    /// which it can be called off.
    Marker(u32, u64),
    /// Let the periodic tasks above this rank rest, and the others run: 255 for all.
    Shed(u8),
    /// Let a hand push the simulated knob with so many newton metres from here on.
    Push(f64),
    /// Let torque of the knob rise from 0, after a fault as well, or let it go at once.
    Arm(bool),
    /// Whether readings and torques of a knob that is there keep to the time that its governor was told of; where they do not, torque falls.
    Deadline(bool),
}

impl Event {
    /// Whether it is a voice or a marker that is to begin, and its id agrees with this one but for so many of the lowest bits.
    pub(crate) fn begins_of(&self, id: u64, bits: u8) -> bool {
        match self {
            Self::Play(play) => play.is_of(id, bits),
            Self::Marker(_, of) => is_of(*of, id, bits),
            _ => false,
        }
    }

    /// Whether it lets go of something that would go on without it. It names no part of a plan, so that it means the same in every one.
    pub fn lets_go(&self) -> bool {
        matches!(
            self,
            Self::Release(_) | Self::ReleaseAll | Self::Silence(..) | Self::Cancel(..) | Self::Arm(false)
        )
    }
}

/// Where events come from: ties in time go in this order, after the ends of voices that have sounded their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u16)]
pub enum Source {
    /// Stops of patterns: what is to begin at the same instant does not.
    Stop = 0,
    /// Patterns.
    Pattern = 1,
    /// The program.
    Program = 2,
    /// The knob.
    Knob = 3,
}
