//! A fader that must come to where its control stands before it moves it.

use crate::midi::Channel;

/// Positions closer than this are the same: a step of 7 bits.
const NEAR: f64 = 1.0 / 127.0 + 1e-9;

/// Whether a binding has its control in hand.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Pickup {
    last: Option<f64>,
    /// What it sent last, while it has the control.
    sent: Option<f64>,
    /// Whether it was asked, since it had the control last, whether it waits.
    asked: bool,
}

impl Pickup {
    /// It stands at `position`, the control at `stands` (`None` where no position is that). Says whether it moves the control.
    pub fn moves(&mut self, position: f64, stands: Option<f64>) -> bool {
        let before = self.last.replace(position);
        let Some(stands) = stands else {
            // It could never come there.
            self.sent = Some(position);
            return true;
        };
        let holds = self.sent.is_some_and(|sent| (sent - stands).abs() < 1e-6);
        let passed = before.is_some_and(|before| (before - stands) * (position - stands) <= 0.0);
        let moves = holds || passed || (position - stands).abs() <= NEAR;
        self.sent = moves.then_some(position);
        self.asked &= !moves;
        moves
    }

    /// It has moved the control to `position`, wherever that stood.
    pub fn take(&mut self, position: f64) {
        (self.last, self.sent) = (Some(position), Some(position));
    }

    /// It was not moved: it is known to stand at `position` now, as after a reset. Says whether it moves the control: where it had that.
    pub fn rests(&mut self, position: f64, stands: Option<f64>) -> bool {
        let holds = stands.is_some_and(|stands| self.sent.is_some_and(|sent| (sent - stands).abs() < 1e-6));
        // Where it does not, nobody has seen it go there.
        let known = holds.then_some(position);
        (self.last, self.sent) = (known, known);
        holds
    }

    /// Whether it has begun to wait for its control to be where it stands; once until it has had that.
    pub fn begins_to_wait(&mut self) -> bool {
        !std::mem::replace(&mut self.asked, true)
    }
}

/// Whose hand moves something: a port of MIDI and a channel of it, or anybody's.
pub(super) type Whose = Option<(usize, Channel)>;

/// All that one binding follows: each fader stands somewhere of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Pickups(Vec<(Whose, Pickup)>);

impl Pickups {
    /// That of somebody.
    pub fn of(&mut self, whose: Whose) -> &mut Pickup {
        let known = self.0.iter().position(|(of, _)| *of == whose);
        let place = known.unwrap_or(self.0.len());
        if known.is_none() {
            self.0.push((whose, Pickup::default()));
        }
        &mut self.0[place].1
    }

    /// A port is gone: what stands there when it is back nobody knows.
    pub fn forget(&mut self, port: usize) {
        self.0.retain(|(whose, _)| whose.is_none_or(|(of, _)| of != port));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::Pickup;
    use crate::engine::event::{Event, Source};
    use crate::performer::staged::{self, HEAD, VOICE};
    use crate::performer::{Happening, Outlet, When};
    use crate::schedule::Instant;

    /// Has room for all.
    struct Nowhere;

    impl Outlet for Nowhere {
        fn clock(&self) -> u64 {
            0
        }

        fn room(&self, _: Source) -> usize {
            usize::MAX
        }

        fn send(&mut self, _: Instant, _: Source, _: Event) -> bool {
            true
        }
    }

    #[test]
    fn whoever_listens_hears_that_a_control_waits() {
        for (pickup, wanted) in [
            ("", vec!["depth waits at 0.75 for 0.25", "depth to 0.3", "depth to 1.8"]),
            ("pickup = false\n", vec!["depth to 1.5", "depth to 1.6", "depth to 0.3", "depth to 1.8"]),
        ] {
            let text = format!(
                "{HEAD}[control.depth]\ndefault = 0.5\nrange = [0, 2]\n{}[[bind]]\nfrom = \"osc./f\"\ncontrol = \"depth\"\n{pickup}",
                VOICE.replace("frequency = 100", "frequency = 100, amplitude = \"depth\"")
            );
            let mut performer = staged::performer(&text, 1);
            let told = Arc::new(Mutex::new(Vec::new()));
            let list = Arc::clone(&told);
            performer.listen(Box::new(move |heard| {
                list.lock().unwrap().push(match heard.what {
                    Happening::Waits { control, position, stands } => {
                        format!("{control} waits at {position} for {stands}")
                    }
                    Happening::Control(name, value) => format!("{name} to {value}"),
                    other => panic!("{other:?}"),
                });
            }));
            for position in [0.75, 0.8, 0.15, 0.9] {
                performer.osc(When::of_seconds(0.0, 8000.0), "/f", &[position], &mut Nowhere).unwrap();
            }
            assert_eq!(*told.lock().unwrap(), wanted);
        }
    }

    #[test]
    fn it_takes_hold_where_the_control_stands() {
        let mut fader = Pickup::default();
        // The control stands at 0.5, the fader comes from below.
        assert!(!fader.moves(0.1, Some(0.5)) && !fader.moves(0.4, Some(0.5)));
        assert!(fader.moves(0.55, Some(0.5)));
        // It has moved it, and goes on to.
        assert!(fader.moves(0.9, Some(0.55)) && fader.moves(0.2, Some(0.9)));
        // Somebody else has moved the control.
        assert!(!fader.moves(0.25, Some(0.7)) && !fader.moves(0.6, Some(0.7)));
        assert!(fader.moves(0.7, Some(0.7)));
    }

    #[test]
    fn it_waits_once_until_it_has_its_control() {
        let mut fader = Pickup::default();
        assert!(!fader.moves(0.1, Some(0.5)) && fader.begins_to_wait());
        assert!(!fader.moves(0.2, Some(0.5)) && !fader.begins_to_wait());
        assert!(fader.moves(0.6, Some(0.5)));
        assert!(!fader.moves(0.7, Some(0.1)) && fader.begins_to_wait() && !fader.begins_to_wait());
    }

    #[test]
    fn what_stands_elsewhere_is_taken_at_once() {
        assert!(Pickup::default().moves(0.3, None));
        assert!(Pickup::default().moves(0.5, Some(0.504)));
    }
}
