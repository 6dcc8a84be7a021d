//! Endless knobs that tell by how many steps they were turned, in place of where they stand.
//!
//! The MIDI standard has no such controllers; makers of controllers and of what they control have settled on three ways to say a number
//! of steps, up or down, in seven bits.

/// How an endless knob says by how many steps it was turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Encoder {
    /// 1 to 63 are steps up, 127 down to 64 steps down.
    TwosComplement,
    /// Counted from 64: 65 is a step up, 63 one down.
    BinaryOffset,
    /// 1 to 63 are steps up, 65 to 127 steps down, from 64 on.
    SignedBit,
}

/// Steps at a time that a hand does: more is said by other controllers.
const FEW: i8 = 16;

impl Encoder {
    /// All, in the order of their names.
    pub const ALL: [Self; 3] = [Self::TwosComplement, Self::BinaryOffset, Self::SignedBit];

    /// Steps up, or down where they are below 0, that a value from 0 to 127 says.
    pub fn steps(self, value: u8) -> i8 {
        let value = (value & 127) as i8;
        match self {
            Self::TwosComplement if value >= 64 => (i16::from(value) - 128) as i8,
            Self::BinaryOffset => value - 64,
            Self::SignedBit if value >= 64 => 64 - value,
            Self::TwosComplement | Self::SignedBit => value,
        }
    }

    /// As a patch names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::TwosComplement => "twos-complement",
            Self::BinaryOffset => "binary-offset",
            Self::SignedBit => "signed-bit",
        }
    }
}

/// What a controller has said, to tell whether it is such a knob.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Said {
    last: Option<u8>,
    /// How often it said the same as before: what stands somewhere does not say so again.
    again: u32,
    /// Which ways of saying it can be, a bit each; all that has been said is a few steps in them.
    not: u8,
    /// In which of them it was turned up, and down.
    up: u8,
    down: u8,
}

/// What a controller is that says the same again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turns {
    /// No such knob, as far as it has been heard.
    No,
    /// It may be one, but not which: it was turned one way alone, or not far enough.
    Perhaps,
    /// It is one.
    Yes(Encoder),
}

/// Repetitions that make it seem one, and that make it one.
const SEEMS: u32 = 3;
const IS: u32 = 6;

impl Said {
    /// It says a value.
    pub fn says(&mut self, value: u8) -> Turns {
        self.again += u32::from(self.last.replace(value) == Some(value));
        for (n, encoder) in Encoder::ALL.into_iter().enumerate() {
            let steps = encoder.steps(value);
            let bit = 1 << n;
            if steps == 0 || steps.unsigned_abs() > FEW.unsigned_abs() {
                self.not |= bit;
            }
            *if steps > 0 { &mut self.up } else { &mut self.down } |= bit;
        }
        let may = (0..3_u8).filter(|n| self.not & 1 << n == 0);
        let both = may.clone().find(|n| self.up & self.down & 1 << n != 0);
        match both.and_then(|n| Encoder::ALL.get(usize::from(n))) {
            Some(encoder) if self.again >= IS => Turns::Yes(*encoder),
            _ if may.count() > 0 && self.again >= SEEMS => Turns::Perhaps,
            _ => Turns::No,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Encoder, Said, Turns};

    /// The tables that makers print: up by one and by the most, down by one and by the most, and none.
    #[test]
    fn values_are_steps() {
        let steps = |encoder: Encoder, values: [u8; 4]| values.map(|value| encoder.steps(value));
        assert_eq!(steps(Encoder::TwosComplement, [1, 63, 127, 64]), [1, 63, -1, -64]);
        assert_eq!(steps(Encoder::BinaryOffset, [65, 127, 63, 0]), [1, 63, -1, -64]);
        assert_eq!(steps(Encoder::SignedBit, [1, 63, 65, 127]), [1, 63, -1, -63]);
        assert_eq!(
            [
                Encoder::TwosComplement.steps(0),
                Encoder::BinaryOffset.steps(64),
                Encoder::SignedBit.steps(0),
                Encoder::SignedBit.steps(64)
            ],
            [0; 4]
        );
    }

    fn said(values: impl IntoIterator<Item = u8>) -> Turns {
        let mut said = Said::default();
        values.into_iter().map(|value| said.says(value)).last().unwrap_or(Turns::No)
    }

    #[test]
    fn a_knob_that_was_turned_both_ways_is_known() {
        let up = [1, 1, 1, 2, 2, 1, 1, 1];
        for (encoder, down) in [(Encoder::TwosComplement, [127; 3]), (Encoder::SignedBit, [65; 3])] {
            assert_eq!(said(up), Turns::Perhaps, "up alone is in both");
            assert_eq!(said(up.into_iter().chain(down)), Turns::Yes(encoder));
        }
        assert_eq!(said([65, 65, 65, 66, 65, 65, 65, 63, 63, 63]), Turns::Yes(Encoder::BinaryOffset));
        // The other way first.
        assert_eq!(said([127, 127, 127, 126, 127, 127, 127, 1, 1, 1]), Turns::Yes(Encoder::TwosComplement));
    }

    #[test]
    fn what_stands_somewhere_is_none() {
        // A fader that is noisy where it rests.
        assert_eq!(said([64; 20]), Turns::No);
        assert_eq!(said([3; 20].into_iter().chain(3..40)), Turns::No);
        // A fader that passes the middle, a knob all the way round, a button.
        for values in [(50..80).collect::<Vec<u8>>(), (0..=127).collect(), [127, 0].repeat(10)] {
            assert_eq!(said(values.clone()), Turns::No, "{values:?}");
        }
        // A button that says no more than that it was pressed goes one way alone.
        assert_eq!(said([127; 20]), Turns::Perhaps);
    }
}
