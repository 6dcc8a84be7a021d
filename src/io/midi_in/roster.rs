//! Which ports are open, and under which numbers.

/// Ports by the numbers under which the session hears them. One that comes back has the number it had, so that what it had set up (bend
/// ranges, zones of MPE) is still its own; of several with one name, whichever is free.
#[derive(Debug, Default)]
pub(super) struct Roster {
    /// The name that had each number last, and the id of the port that has it now.
    seats: Vec<(String, Option<String>)>,
}

impl Roster {
    /// Whether a port is open.
    pub fn has(&self, id: &str) -> bool {
        self.seats.iter().any(|(_, seated)| seated.as_deref() == Some(id))
    }

    /// A port is opened; gives its number. `None`: so many are open that it has none.
    pub fn seat(&mut self, id: &str, name: &str) -> Option<u16> {
        let free = |seat: &(String, Option<String>)| seat.1.is_none();
        let known = self.seats.iter().position(|seat| free(seat) && seat.0 == name);
        let number = match known {
            Some(number) => number,
            None if self.seats.len() < crate::performer::PORTS => {
                self.seats.push((name.into(), None));
                self.seats.len() - 1
            }
            None => self.seats.iter().position(free)?,
        };
        if let Some(seat) = self.seats.get_mut(number) {
            *seat = (name.into(), Some(id.into()));
        }
        u16::try_from(number).ok()
    }

    /// A port is gone, or could not be opened after all.
    pub fn leave(&mut self, id: &str) {
        let seat = self.seats.iter_mut().find(|(_, seated)| seated.as_deref() == Some(id));
        seat.into_iter().for_each(|(_, seated)| *seated = None);
    }
}

#[cfg(test)]
mod tests {
    use super::Roster;
    use crate::performer::PORTS;
    use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};
    use std::collections::HashMap;

    #[test]
    fn two_of_one_name_are_two_and_have_their_numbers_again() {
        let mut roster = Roster::default();
        assert_eq!(["20:0", "24:0", "28:0"].map(|id| roster.seat(id, "Keys").unwrap()), [0, 1, 2]);
        assert_eq!(roster.seat("32:0", "Pads"), Some(3));
        roster.leave("24:0");
        assert!(!roster.has("24:0") && roster.has("20:0") && roster.has("28:0"));
        assert_eq!(roster.seat("40:0", "Other"), Some(4), "not what the gone one had set up");
        assert_eq!(roster.seat("24:0", "Keys"), Some(1));
        ["20:0", "32:0"].into_iter().for_each(|id| roster.leave(id));
        assert_eq!(
            (roster.seat("20:1", "Pads"), roster.seat("32:1", "Keys")),
            (Some(3), Some(0)),
            "in another order"
        );
    }

    #[test]
    fn one_too_many_has_no_number_until_another_leaves() {
        let mut roster = Roster::default();
        let numbers: Vec<_> = (0..PORTS).map(|n| roster.seat(&format!("{n}"), "Keys")).collect();
        assert!(numbers.iter().enumerate().all(|(n, number)| *number == Some(n as u16)));
        assert!(roster.seat("more", "Keys").is_none() && !roster.has("more"));
        roster.leave("7");
        assert_eq!(roster.seat("more", "Pads"), Some(7));
    }

    proptest! {
        /// However ports come and go, open ones have numbers of their own; and a name that nobody else wants finds its number again.
        #[test]
        fn open_ports_have_numbers_of_their_own(steps in proptest::collection::vec(any::<(u8, u8)>(), 0..400)) {
            let mut roster = Roster::default();
            let mut open: HashMap<String, u16> = HashMap::new();
            for (id, name) in steps {
                let (id, name) = (format!("{}", id % 20), format!("{}", name % 3));
                match open.remove(&id) {
                    Some(number) => {
                        roster.leave(&id);
                        prop_assert!(!roster.has(&id));
                        prop_assert!(number < 64);
                    }
                    None => {
                        let number = roster.seat(&id, &name).unwrap();
                        prop_assert!(roster.has(&id) && open.values().all(|other| *other != number));
                        open.insert(id, number);
                    }
                }
            }
            let number = roster.seat("alone", "alone");
            roster.leave("alone");
            prop_assert_eq!(roster.seat("again", "alone"), number);
        }
    }
}
