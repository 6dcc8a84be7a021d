//! Numbered parameters, registered (RPN) and not (NRPN): a number is chosen with two controllers, then its value moves with others.
//!
//! MIDI 1.0 Detailed Specification, "Registered and Non-Registered Parameter Numbers"; 96 and 97 as in RP-018.

/// Data entry, upper and lower seven bits.
const ENTRY: [u8; 2] = [6, 38];
const INCREMENT: u8 = 96;
const DECREMENT: u8 = 97;
/// The number that stands for none: 127 twice.
const NULL: u16 = 16_383;

/// Whether a controller chooses or moves a numbered parameter, and so is no ordinary one.
pub(super) fn concerns(controller: u8) -> bool {
    ENTRY.contains(&controller) || (INCREMENT..=101).contains(&controller)
}

/// The parameter that is chosen on a channel, and what is known of its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Selection {
    registered: bool,
    upper: Option<u8>,
    lower: Option<u8>,
    /// Since it was chosen.
    value: Option<u16>,
}

/// A parameter's value moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub registered: bool,
    pub number: u16,
    pub change: Change,
    /// The value after it, 14 bits; `None` where steps were taken from a value that is not known.
    pub value: Option<u16>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// Upper seven bits; the lower ones are 0.
    Coarse(u8),
    /// Lower seven bits.
    Fine(u8),
    /// By one of the smallest steps, up or down.
    Step(i16),
}

impl Selection {
    /// Chooses nothing.
    pub fn close(&mut self) {
        *self = Self::default();
    }

    /// Takes one of the controllers that [`concerns`] names. `Err` for a value without a whole number that it could be meant for.
    pub fn controller(&mut self, number: u8, value: u8) -> Result<Option<Entry>, Unmeant> {
        match number {
            98 => self.choose(false, None, Some(value)),
            99 => self.choose(false, Some(value), None),
            100 => self.choose(true, None, Some(value)),
            101 => self.choose(true, Some(value), None),
            INCREMENT => return self.entry(Change::Step(1)).map(Some),
            DECREMENT => return self.entry(Change::Step(-1)).map(Some),
            _ if number == ENTRY[0] => return self.entry(Change::Coarse(value)).map(Some),
            _ => return self.entry(Change::Fine(value)).map(Some),
        }
        Ok(None)
    }

    /// Half of a number. The other half stays, since senders repeat only what changes; that of the other kind does not.
    fn choose(&mut self, registered: bool, upper: Option<u8>, lower: Option<u8>) {
        if self.registered != registered {
            *self = Self { registered, ..Self::default() };
        }
        self.upper = upper.or(self.upper);
        self.lower = lower.or(self.lower);
        self.value = None;
    }

    fn entry(&mut self, change: Change) -> Result<Entry, Unmeant> {
        let (Some(upper), Some(lower)) = (self.upper, self.lower) else { return Err(Unmeant) };
        let number = u16::from(upper) << 7 | u16::from(lower);
        if number == NULL {
            return Err(Unmeant);
        }
        self.value = match change {
            Change::Coarse(v) => Some(u16::from(v) << 7),
            Change::Fine(v) => Some((self.value.unwrap_or(0) & !127) | u16::from(v)),
            Change::Step(by) => self.value.map(|v| v.saturating_add_signed(by).min(16_383)),
        };
        Ok(Entry { registered: self.registered, number, change, value: self.value })
    }
}

/// A value that is meant for no parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unmeant;

#[cfg(test)]
mod tests {
    use super::{Change, Entry, Selection, Unmeant, concerns};

    fn last(controllers: &[(u8, u8)]) -> Result<Option<Entry>, Unmeant> {
        let mut selection = Selection::default();
        controllers.iter().map(|(n, v)| selection.controller(*n, *v)).last().unwrap()
    }

    #[test]
    fn a_number_is_whole_before_it_takes_a_value() {
        let entry =
            Entry { registered: false, number: 3 << 7 | 4, change: Change::Coarse(9), value: Some(9 << 7) };
        assert_eq!(last(&[(99, 3), (98, 4), (6, 9)]), Ok(Some(entry)));
        assert_eq!(last(&[(98, 4), (99, 3), (6, 9)]), Ok(Some(entry)), "in any order");
        assert_eq!(
            last(&[(99, 3), (98, 7), (6, 1), (98, 4), (6, 9)]),
            Ok(Some(entry)),
            "the upper half stays"
        );
        assert_eq!(last(&[(6, 9)]), Err(Unmeant));
        assert_eq!(last(&[(99, 3), (6, 9)]), Err(Unmeant), "half a number");
        assert_eq!(
            last(&[(101, 0), (99, 3), (98, 4), (100, 0), (6, 9)]),
            Err(Unmeant),
            "halves of two kinds"
        );
        assert_eq!(last(&[(99, 3), (98, 4), (101, 127), (100, 127), (6, 9)]), Err(Unmeant), "closed");
        assert_eq!(last(&[(99, 127), (98, 127), (38, 9)]), Err(Unmeant), "closed, by the other pair");
        assert_eq!(
            last(&[(101, 0), (100, 0), (6, 9)]).unwrap().map(|e| (e.registered, e.number)),
            Some((true, 0))
        );
    }

    #[test]
    fn values_are_refined_and_stepped() {
        let value = |more: &[(u8, u8)]| {
            let all: Vec<_> = [(99, 0), (98, 1)].into_iter().chain(more.iter().copied()).collect();
            last(&all).unwrap().unwrap().value
        };
        assert_eq!(value(&[(6, 5), (38, 7)]), Some(5 << 7 | 7));
        assert_eq!(value(&[(6, 5), (38, 7), (6, 6)]), Some(6 << 7), "the upper half alone resets the lower");
        assert_eq!(value(&[(6, 5), (38, 127), (96, 0)]), Some(6 << 7));
        assert_eq!(value(&[(6, 5), (97, 0)]), Some((5 << 7) - 1));
        assert_eq!(value(&[(6, 0), (97, 0)]), Some(0));
        assert_eq!(value(&[(6, 127), (38, 127), (96, 0)]), Some(16_383));
        assert_eq!(value(&[(96, 0)]), None, "from nowhere");
        assert_eq!(value(&[(6, 5), (98, 1), (96, 0)]), None, "chosen again");
    }

    #[test]
    fn these_are_no_ordinary_controllers() {
        let all: Vec<u8> = (0..128).filter(|n| concerns(*n)).collect();
        assert_eq!(all, [6, 38, 96, 97, 98, 99, 100, 101]);
    }
}
