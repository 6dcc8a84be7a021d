//! What is moved, as a binding names it and as people do.

use pacinian::midi::moved::{Control, Moved, Useless};
use pacinian::text::problem::escaped;

/// What moves a control from now on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// As `from` of a binding says it.
    pub from: String,
    /// The MIDI channel, where it has one.
    pub channel: Option<u8>,
    /// Whether it comes back to its rest or jumps by its nature, so that a pick-up would be in its way.
    pub springs: bool,
    /// For people.
    pub shown: String,
}

impl Source {
    /// Of MIDI, through the port of that name.
    pub fn midi(moved: Moved, port: &str) -> Self {
        let Moved { channel, control, fine, switch, .. } = moved;
        let (from, what) = match control {
            Control::Controller(number) => {
                let bits = if fine { 14 } else { 7 };
                let kind = if switch { "a button, ".into() } else { format!("{bits} bits, ") };
                (format!("midi.controller {number}"), format!("controller {number}, {kind}"))
            }
            Control::Bend => ("midi.bend".into(), "the pitch wheel, 14 bits, ".into()),
            Control::Pressure => ("midi.pressure".into(), "pressure, 7 bits, ".to_string()),
        };
        Self {
            from,
            channel: Some(channel.number()),
            springs: switch || !matches!(control, Control::Controller(_)),
            shown: format!("{what}on channel {} of {}", channel.number(), escaped(port)),
        }
    }

    /// An OSC address; `switch` where it says two positions and no others.
    pub fn osc(address: &str, switch: bool) -> Self {
        Self {
            from: format!("osc.{address}"),
            channel: None,
            springs: switch,
            shown: format!("OSC {}", escaped(address)),
        }
    }
}

/// Why something that was used is no source.
pub fn why(useless: Useless) -> String {
    match useless {
        Useless::Note => "keys play voices: a [[trigger]] with on = \"midi.note\" does that".into(),
        Useless::Program => {
            "a program is chosen, not moved: a [[trigger]] with on = \"midi.program N\" hears it".into()
        }
        Useless::Parameter => {
            "that is a numbered parameter (NRPN), which cannot be bound: set it to a controller in its editor"
                .into()
        }
        Useless::Pedal(number) => format!(
            "controller {number} is a pedal that holds voices: a [[bind]] or a [[trigger]] that names midi.controller {number} makes it something else"
        ),
        Useless::Steps(number) => format!(
            "controller {number} says the same again and again, as endless knobs do that tell steps: set it to tell positions in its editor"
        ),
    }
}
