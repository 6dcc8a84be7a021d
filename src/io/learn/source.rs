//! What is moved, as a binding names it.

use std::sync::Arc;

use crate::midi::Encoder;
use crate::midi::moved::{Control, Moved};
use crate::patch::{Bind, Mover};

/// What may move a control from now on.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A controller, a wheel or pressure, on the port of that name.
    Midi {
        /// What was moved.
        moved: Moved,
        /// The port.
        port: Arc<str>,
    },
    /// An OSC address.
    Osc {
        /// The address.
        address: String,
        /// Which of its numbers, from 1.
        argument: usize,
        /// Whether it says two positions and no others.
        switch: bool,
    },
}

impl Source {
    /// What a binding is moved `from`.
    pub fn mover(&self) -> Mover {
        match self {
            Self::Midi { moved, .. } => match moved.control {
                Control::Controller(number) => Mover::Controller(number),
                Control::Bend => Mover::Bend,
                Control::Pressure => Mover::Pressure,
            },
            Self::Osc { address, argument, .. } => {
                Mover::Osc { address: address.clone(), argument: *argument }
            }
        }
    }

    /// The MIDI channel, from 1, where it has one.
    pub fn channel(&self) -> Option<u8> {
        match self {
            Self::Midi { moved, .. } => Some(moved.channel.number()),
            Self::Osc { .. } => None,
        }
    }

    /// Of an endless knob, how it says its steps.
    pub fn encoder(&self) -> Option<Encoder> {
        match self {
            Self::Midi { moved, .. } => moved.encoder,
            Self::Osc { .. } => None,
        }
    }

    /// Whether it comes back to its rest or jumps by its nature, so that a pick-up would be in its way.
    pub fn springs(&self) -> bool {
        match self {
            Self::Midi { moved, .. } => moved.switch || !matches!(moved.control, Control::Controller(_)),
            Self::Osc { switch, .. } => *switch,
        }
    }

    /// The binding that lets it move a control.
    pub fn bind(&self, control: &str) -> Bind {
        Bind {
            channel: self.channel(),
            pickup: !self.springs(),
            encoder: self.encoder(),
            ..Bind::new(self.mover(), control)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Control, Moved, Mover, Source};
    use crate::midi::Channel;

    #[test]
    fn a_binding_is_that_of_what_was_moved() {
        let of = |control, switch| {
            let moved = Moved {
                port: 0,
                channel: Channel::new(4).unwrap(),
                control,
                fine: false,
                switch,
                encoder: None,
            };
            let bind = Source::Midi { moved, port: "Keys".into() }.bind("depth");
            assert_eq!((bind.control.as_str(), bind.range, bind.curve), ("depth", None, None));
            (bind.from, bind.channel, bind.pickup)
        };
        let number = Channel::new(4).unwrap().number();
        assert_eq!(of(Control::Controller(21), false), (Mover::Controller(21), Some(number), true));
        assert_eq!(of(Control::Controller(21), true), (Mover::Controller(21), Some(number), false));
        assert_eq!(of(Control::Bend, false), (Mover::Bend, Some(number), false));
        assert_eq!(of(Control::Pressure, false), (Mover::Pressure, Some(number), false));
        for switch in [false, true] {
            let bind = Source::Osc { address: "/a/b".into(), argument: 2, switch }.bind("depth");
            let from = Mover::parse("osc./a/b 2").unwrap();
            assert_eq!((bind.from, bind.channel, bind.pickup), (from, None, !switch));
        }
    }
}
