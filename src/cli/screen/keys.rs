//! What keys mean.

use std::time::{Duration, Instant};

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use pacinian::live::signal::Origin;

/// What somebody at the keyboard wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// End the session, with this exit code if not with success.
    End(Option<u8>),
    /// Shut the output.
    Panic,
    /// Open it again.
    Calm,
    /// Full level, or back to -20 dB.
    Arm,
    /// What a digit plays.
    Digit(u32),
    /// All patterns.
    All,
    /// Pages of the meters on, or back.
    Turn(i32),
    /// The other form of the meters.
    Form,
    /// Draw everything again.
    Redraw,
}

/// Presses of the same key that come faster than this are those of a key that is held down.
const REPEATED: Duration = Duration::from_millis(70);

/// The key that shuts the output opens it again only after it was left alone for so long: who hammers on it, or holds it down, wants
/// silence.
const SETTLED: Duration = Duration::from_secs(1);

/// Understands keys.
#[derive(Debug, Default)]
pub struct Keys {
    last: Option<(KeyCode, Instant)>,
    panic: Option<Instant>,
}

impl Keys {
    /// A key was pressed at `now`, while the output was shut by a panic or not.
    pub fn press(&mut self, key: KeyEvent, now: Instant, panicked: bool) -> Option<Act> {
        if key.kind == KeyEventKind::Release {
            return None;
        }
        let before = self.last.replace((key.code, now));
        let repeated = before.is_some_and(|(code, at)| code == key.code && now - at < REPEATED);
        let repeated = repeated || key.kind == KeyEventKind::Repeat;
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return match key.code {
                KeyCode::Char('c' | 'C') => Some(Act::End(Some(130))),
                KeyCode::Char('l' | 'L') => Some(Act::Redraw),
                _ => None,
            };
        }
        let act = match key.code {
            KeyCode::Char('q' | 'Q') => Act::End(None),
            KeyCode::Char('p' | 'P') | KeyCode::Esc => {
                let settled = self.panic.replace(now).is_none_or(|at| now - at >= SETTLED);
                match panicked {
                    false => Act::Panic,
                    true if settled => Act::Calm,
                    true => return None,
                }
            }
            KeyCode::Char('c' | 'C') => Act::Calm,
            KeyCode::Char('a' | 'A') => Act::Arm,
            KeyCode::Char(' ') => Act::All,
            KeyCode::Char('m' | 'M') => Act::Form,
            KeyCode::Char('>' | '.') | KeyCode::Right | KeyCode::Down | KeyCode::PageDown => Act::Turn(1),
            KeyCode::Char('<' | ',') | KeyCode::Left | KeyCode::Up | KeyCode::PageUp => Act::Turn(-1),
            KeyCode::Char(digit) => Act::Digit(digit.to_digit(10).filter(|&digit| digit > 0)?),
            _ => return None,
        };
        // Held down, a key that goes to and fro would flutter.
        let flutters = matches!(act, Act::Arm | Act::All | Act::Form | Act::Digit(_));
        (!(repeated && flutters)).then_some(act)
    }
}

/// Where what somebody has typed comes from, for journals.
pub fn origin(event: &Event) -> Origin {
    match event {
        Event::Key(key) => Origin::Key(key.code.to_string().into()),
        _ => Origin::Program,
    }
}

#[cfg(test)]
mod tests {
    use super::{Act, Keys, Origin, origin};
    use crossterm::event::{Event, KeyCode, KeyEvent, KeyModifiers};
    use std::time::{Duration, Instant};

    /// Presses keys at so many milliseconds; whether the output is shut follows from what they do.
    fn type_in(keys: &[(u64, KeyCode)]) -> Vec<Option<Act>> {
        let (begin, mut state, mut panicked) = (Instant::now(), Keys::default(), false);
        let mut press = |&(at, code): &(u64, KeyCode)| {
            let event = KeyEvent::new(code, KeyModifiers::NONE);
            let act = state.press(event, begin + Duration::from_millis(at), panicked);
            panicked = match act {
                Some(Act::Panic) => true,
                Some(Act::Calm) => false,
                _ => panicked,
            };
            act
        };
        keys.iter().map(&mut press).collect()
    }

    #[test]
    fn who_hammers_on_panic_gets_silence() {
        let key = KeyCode::Esc;
        // Held down: once, then after half a second thirty times a second.
        let mut held = vec![(0, key)];
        held.extend((0..200).map(|n| (500 + 33 * n, key)));
        let acts = type_in(&held);
        assert_eq!(acts[0], Some(Act::Panic));
        assert!(acts[1..].iter().all(Option::is_none));
        // Once more, a while later.
        assert_eq!(
            type_in(&[(0, key), (1500, key), (1600, key)]),
            [Some(Act::Panic), Some(Act::Calm), Some(Act::Panic)]
        );
        assert_eq!(type_in(&[(0, KeyCode::Char('p')), (10, KeyCode::Char('c'))])[1], Some(Act::Calm));
    }

    #[test]
    fn a_key_that_is_held_down_does_not_flutter() {
        for (code, act) in [(KeyCode::Char('3'), Act::Digit(3)), (KeyCode::Char(' '), Act::All)] {
            let held: Vec<_> = (0..20).map(|n| (33 * n, code)).collect();
            let acts = type_in(&held);
            assert_eq!(acts[0], Some(act));
            assert!(acts[1..].iter().all(Option::is_none));
            assert_eq!(type_in(&[(0, code), (150, code)]), [Some(act); 2]);
        }
        // Other keys in between are no repetition.
        let (one, two) = (KeyCode::Char('1'), KeyCode::Char('2'));
        assert!(type_in(&[(0, one), (20, two), (40, one)]).iter().all(Option::is_some));
    }

    #[test]
    fn a_key_is_called_by_what_stands_on_it() {
        for (code, name) in [(KeyCode::Char('3'), "3"), (KeyCode::Char(' '), "Space"), (KeyCode::Esc, "Esc")]
        {
            let pressed = Event::Key(KeyEvent::new(code, KeyModifiers::NONE));
            assert_eq!(origin(&pressed), Origin::Key(name.into()));
        }
    }

    #[test]
    fn control_and_letters() {
        let mut keys = Keys::default();
        let mut press = |code, modifiers| keys.press(KeyEvent::new(code, modifiers), Instant::now(), false);
        assert_eq!(press(KeyCode::Char('c'), KeyModifiers::CONTROL), Some(Act::End(Some(130))));
        assert_eq!(press(KeyCode::Char('c'), KeyModifiers::NONE), Some(Act::Calm));
        assert_eq!(press(KeyCode::Char('q'), KeyModifiers::NONE), Some(Act::End(None)));
        assert_eq!(press(KeyCode::Char('z'), KeyModifiers::CONTROL), None);
        assert_eq!(press(KeyCode::Char('0'), KeyModifiers::NONE), None);
        assert_eq!(press(KeyCode::F(5), KeyModifiers::NONE), None);
    }
}
