//! What a player tells of the events that it gives the engine.

use crate::midi::Message;
use crate::node::motion::Motion;
use crate::schedule::Instant;

/// Hears of every event as it is given to the engine: those of the patterns in order of their time, those of the program
/// in between; and of voices that signals have set off, a little after they began.
pub type Listener = Box<dyn FnMut(&Heard<'_>) + Send>;

/// An event that was given to the engine, or arose in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard<'a> {
    /// Seconds from the beginning, as the patterns have it.
    pub at: f64,
    /// The same on the engine's clock.
    pub instant: Instant,
    /// The pattern it comes from, or the signal that set it off; `None` for what any other trigger or the program plays.
    pub origin: Option<Origin<'a>>,
    /// The id of the voice, the serial number of the marker in its score, or the number of a message, which is the cause of what follows from it; `None` for
    /// what has none.
    pub id: Option<u64>,
    /// What it is.
    pub what: Happening<'a>,
}

/// Where in the patterns an event stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin<'a> {
    /// The pattern; of what a signal has set off, what did so, `node.breath rises 0.3`, and `event` counts how often.
    pub pattern: &'a str,
    /// Which of its events, from 0, in the order of the file; in a shuffled pattern, the one that landed here.
    pub event: u64,
    /// Which of the alternatives of a `choose` was drawn, from 0.
    pub drawn: Option<u32>,
}

/// What an event does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Happening<'a> {
    /// A voice sounds.
    Voice {
        /// Its name.
        name: &'a str,
        /// The output that it sounds on.
        place: &'a str,
        /// Level, with the gains of all patterns around it.
        level: f64,
        /// Decibels above the threshold that a level of 1 is felt like; `None`: by its level alone.
        felt: Option<f64>,
        /// Seconds until its release; infinite for one that is held.
        duration: f64,
        /// Names of its own fields, `frequency` among them.
        fields: &'a [(String, f64)],
        /// Their values.
        own: &'a [f64],
        /// Whether its nodes read the frequency.
        pitched: bool,
    },
    /// A pattern begins that a signal or the knob has set off.
    Start(&'a str),
    /// A marker.
    Marker(&'a str),
    /// A message of a song is played. It is told before what follows from it.
    Message(Message),
    /// A control is sent to a value.
    Control(&'a str, f64),
    /// A fader or controller that is bound to a control has moved, and moves that only when it has come to where it stands.
    Waits {
        /// The control.
        control: &'a str,
        /// Where the fader is, from 0 to 1.
        position: f64,
        /// Where it would have to be.
        stands: f64,
    },
    /// The voice of that id is moved, so far.
    Touch(Motion, f64),
    /// The voice of that id is released.
    Release,
    /// All voices are released.
    ReleaseAll,
    /// All voices fall silent at once whose ids agree with this one but for so many of their lowest bits: what a MIDI channel or port
    /// has started.
    Silence(u8),
    /// Voices and markers that were told of, and that begin at this instant or later, do not, if their ids agree with this one but for so
    /// many of their lowest bits: their pattern was stopped.
    Cancel(u8),
}
