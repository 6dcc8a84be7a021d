//! Which controller or OSC address somebody moves, so that it can be bound to a control.
//!
//! A [`Learner`] listens; each time it is asked it says what somebody has moved since. Knobs that are noisy, wheels that spring back and keys
//! that are let go are not mistaken for one that is moved ([`crate::midi::moved`]). What it finds is a [`Source`], which makes a
//! [`Bind`].
#![cfg_attr(feature = "edit", doc = "[`crate::edit::bindings`] writes that into a patch.")]
//!
//! ```
//! use pacinian::io::learn::{Heard, Learner};
//! use pacinian::io::osc::endpoint::Endpoint;
//! use rosc::{OscMessage, OscPacket, OscType, encoder::encode};
//!
//! let mut learner = Learner::default();
//! let at = learner.hear_osc("127.0.0.1:0".parse::<Endpoint>()?)?;
//! // Somebody moves a fader.
//! let fader = std::net::UdpSocket::bind("127.0.0.1:0")?;
//! for step in 0..=50 {
//!     let args = vec![OscType::Float(0.02 * step as f32)];
//!     fader.send_to(&encode(&OscPacket::Message(OscMessage { addr: "/fader/3".into(), args }))?, at)?;
//! }
//! let source = loop {
//!     if let Some(Heard::Source(source)) = learner.hear() {
//!         break source;
//!     }
//! };
//! assert_eq!(source.bind("strength").from.to_string(), "osc./fader/3");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod osc;
mod source;

use std::collections::HashSet;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Instant;

use self::osc::Ear;
pub use self::source::Source;
use super::midi_in::{MidiPorts, Newsreader, Word};
use super::osc::endpoint::{BindError, Endpoint};
use crate::midi::moved::{Control, Recogniser, Seen, Useless};
use crate::midi::reach::{Reach, Reaches};
use crate::midi::{Channel, Message};
#[cfg(doc)]
use crate::patch::Bind;

/// Messages that may wait: of a flood, a part tells as much as all.
const WAITING: usize = 1 << 12;

/// What somebody does.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// This is moved.
    Source(Source),
    /// This is used, and cannot be bound. It is said once.
    Unfit(Unfit),
}

/// What cannot be bound.
#[derive(Debug, Clone, PartialEq)]
pub enum Unfit {
    /// Something of MIDI.
    Midi(Useless),
    /// An OSC address, and why it cannot.
    Osc(String, Misfit),
}

/// Why an OSC address cannot be bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Misfit {
    /// It is one of those that sessions have themselves.
    Own,
    /// A blank is in it.
    Blank,
    /// It is longer than [`LONGEST`](crate::io::osc::address::LONGEST) bytes.
    Long,
    /// It says this, and a binding takes positions from 0 to 1.
    Value(f64),
}

/// What was heard of and is not enough.
#[derive(Debug, Clone, PartialEq)]
pub enum Short {
    /// This went furthest: what, from where to where, and how many others went less far.
    Moved(Candidate, Reach, usize),
    /// Messages came, and none of them says where something stands.
    Nothing,
}

/// What may be moved.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Candidate {
    /// A controller on a channel.
    Midi(Channel, Control),
    /// An OSC address.
    Osc(String),
}

/// Listens for what somebody moves, until it is dropped.
#[derive(Default)]
pub struct Learner {
    midi: Option<Midi>,
    osc: Option<Ear>,
    recogniser: Recogniser,
    said: HashSet<Useless>,
    /// Whether anything came that says no position.
    others: bool,
}

struct Midi {
    messages: Receiver<(f64, u16, Arc<str>, Message)>,
    _ports: MidiPorts,
}

impl Learner {
    /// Listens to the ports of MIDI whose names contain `wanted`, or to all, as they come and go; `news` hears of that in a thread of its own.
    ///
    /// # Errors
    /// A system that has no thread left. One without MIDI is told as news.
    pub fn hear_midi(&mut self, wanted: Option<String>, news: Newsreader) -> std::io::Result<()> {
        let (send, messages) = sync_channel(WAITING);
        let begin = Instant::now();
        let ear = move |number: u16, name: &Arc<str>, word: Word, at: Instant| {
            if let Word::Message(message) = word {
                let seconds = at.saturating_duration_since(begin).as_secs_f64();
                let _ = send.try_send((seconds, number, Arc::clone(name), message));
            }
        };
        let _ports = MidiPorts::hear(Arc::new(ear), None, wanted, news)?;
        self.midi = Some(Midi { messages, _ports });
        Ok(())
    }

    /// Listens for OSC, and says where.
    ///
    /// # Errors
    /// A port that cannot be had.
    pub fn hear_osc(&mut self, at: Endpoint) -> Result<SocketAddr, BindError> {
        let (ear, address) = Ear::open(at)?;
        self.osc = Some(ear);
        Ok(address)
    }

    /// What somebody has moved since this was asked last; whatever else waits is heard the next time. Ask some 100 times a second.
    pub fn hear(&mut self) -> Option<Heard> {
        while let Some((seconds, port, name, message)) =
            self.midi.as_ref().and_then(|midi| midi.messages.try_recv().ok())
        {
            self.others |= !matches!(message, Message::Clock | Message::ActiveSensing);
            match self.recogniser.message(seconds, port, message) {
                Some(Seen::Moved(moved)) => return Some(Heard::Source(Source::Midi { moved, port: name })),
                Some(Seen::Useless(useless)) if self.said.insert(useless) => {
                    return Some(Heard::Unfit(Unfit::Midi(useless)));
                }
                _ => {}
            }
        }
        self.osc.as_mut().and_then(Ear::hear)
    }

    /// Another control is asked for: what was heard and was not enough is over.
    pub fn forget(&mut self) {
        self.recogniser.forget();
        self.others = false;
        if let Some(osc) = &mut self.osc {
            osc.forget();
        }
    }

    /// Whether anything was heard that was not enough.
    pub fn has_heard(&self) -> bool {
        let of_osc = self.osc.as_ref().map_or(0, |osc| osc.heard.count());
        self.others || self.recogniser.heard().count() + of_osc > 0
    }

    /// What was heard of and is not enough; `None` where that is nothing, or was said to be unfit.
    pub fn short(&self) -> Option<Short> {
        let (midi, osc) = (self.recogniser.heard(), self.osc.as_ref().map(|osc| &osc.heard));
        let of_midi =
            midi.most().map(|((_, channel, control), reach)| (Candidate::Midi(*channel, *control), reach));
        let of_osc =
            osc.and_then(Reaches::most).map(|(address, reach)| (Candidate::Osc(address.clone()), reach));
        let way = |(_, reach): &(Candidate, Reach)| reach.most - reach.least;
        let furthest = of_midi.into_iter().chain(of_osc).max_by(|a, b| way(a).total_cmp(&way(b)));
        let count = midi.count() + osc.map_or(0, Reaches::count);
        match furthest {
            Some((mover, reach)) => Some(Short::Moved(mover, reach, count - 1)),
            None => (self.others && self.said.is_empty()).then_some(Short::Nothing),
        }
    }
}
