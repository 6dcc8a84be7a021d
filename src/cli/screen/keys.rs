//! What keys mean.

use std::time::{Duration, Instant};

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use pacinian::live::signal::Origin;

use crate::cli::stop::INTERRUPTED;

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
    /// The torque of a knob that is there, or none.
    Torque,
    /// What a digit plays.
    Digit(u32),
    /// All patterns.
    All,
    /// Pages of the meters on, or back.
    Turn(i32),
    /// Another control.
    Choose(i32),
    /// The chosen control so many steps up; where there is none, as [`Act::Turn`].
    Move(i32),
    /// The chosen control to where it was at first.
    Reset,
    /// The other form of the meters.
    Form,
    /// Draw everything again.
    Redraw,
}

/// Presses of the same key that come faster than this are those of a key that is held down.
const REPEATED: Duration = Duration::from_millis(70);

/// Steps that a control moves with Shift.
const FAR: i32 = 5;

/// What follows an Escape within this time may be the rest of its sequence that came late, as on a slow line.
const TORN: Duration = Duration::from_millis(500);

/// Understands keys.
#[derive(Debug, Default)]
pub struct Keys {
    last: Option<(KeyCode, Instant)>,
    /// Since when the rest of a torn sequence is awaited.
    torn: Option<Instant>,
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
                KeyCode::Char('c' | 'C') => Some(Act::End(Some(INTERRUPTED))),
                KeyCode::Char('l' | 'L') => Some(Act::Redraw),
                _ => None,
            };
        }
        // An Escape and a key that come at once look like a key with Alt: it may have been meant to shut the output.
        if key.modifiers.contains(KeyModifiers::ALT) && matches!(key.code, KeyCode::Char(_)) {
            return (!(repeated && panicked)).then_some(Act::Panic);
        }
        if self.is_torn(key.code, before, now) {
            return None;
        }
        let act = match key.code {
            KeyCode::Char('q' | 'Q') => Act::End(None),
            // Whoever presses it wants silence, whoever has shut the output before. It is said again, as somebody may be opening it.
            KeyCode::Char('p' | 'P') | KeyCode::Esc if repeated && panicked => return None,
            KeyCode::Char('p' | 'P') | KeyCode::Esc => Act::Panic,
            KeyCode::Char('c' | 'C') => Act::Calm,
            KeyCode::Char('a' | 'A') => Act::Arm,
            KeyCode::Char('t' | 'T') => Act::Torque,
            KeyCode::Char(' ') => Act::All,
            KeyCode::Char('m' | 'M') => Act::Form,
            KeyCode::Char('>' | '.') | KeyCode::PageDown => Act::Turn(1),
            KeyCode::Char('<' | ',') | KeyCode::PageUp => Act::Turn(-1),
            KeyCode::BackTab => Act::Choose(-1),
            KeyCode::Tab if key.modifiers.contains(KeyModifiers::SHIFT) => Act::Choose(-1),
            KeyCode::Tab | KeyCode::Down => Act::Choose(1),
            KeyCode::Up => Act::Choose(-1),
            KeyCode::Right | KeyCode::Left => {
                let far = if key.modifiers.contains(KeyModifiers::SHIFT) { FAR } else { 1 };
                Act::Move(if key.code == KeyCode::Left { -far } else { far })
            }
            KeyCode::Char('0' | 'd' | 'D') => Act::Reset,
            KeyCode::Char(digit) => Act::Digit(digit.to_digit(10).filter(|&digit| digit > 0)?),
            _ => return None,
        };
        // Held down, a key that goes to and fro would flutter.
        let flutters = matches!(act, Act::Arm | Act::Torque | Act::All | Act::Form | Act::Digit(_));
        (!(repeated && flutters)).then_some(act)
    }

    /// Whether a key belongs to the sequence of another (ECMA-48: an Escape, a bracket or an O, parameters, and a letter) of which
    /// the Escape came before the rest. Up would arm and Right would open otherwise.
    fn is_torn(&mut self, code: KeyCode, before: Option<(KeyCode, Instant)>, now: Instant) -> bool {
        let KeyCode::Char(c) = code else {
            self.torn = None;
            return false;
        };
        if self.torn.take().is_some_and(|since| now - since < TORN) {
            self.torn = (!('@'..='~').contains(&c)).then_some(now);
            return true;
        }
        let begins = matches!(c, '[' | 'O')
            && before.is_some_and(|(code, at)| code == KeyCode::Esc && now - at < TORN);
        self.torn = begins.then_some(now);
        begins
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
        assert!(acts[1..].iter().all(|act| matches!(act, None | Some(Act::Panic))));
        assert_eq!(acts.iter().flatten().count(), 2, "the second when the key begins to repeat");
        assert_eq!(type_in(&[(0, KeyCode::Char('p')), (10, KeyCode::Char('c'))])[1], Some(Act::Calm));
    }

    #[test]
    fn the_keys_that_shut_the_output_never_open_it() {
        for code in [KeyCode::Esc, KeyCode::Char('p'), KeyCode::Char('P')] {
            // However long after; also where the panic came from elsewhere, of which this keyboard knows nothing.
            let waits = [0, 10, 80, 999, 1000, 1500, 60_000, 3_600_000];
            assert!(
                type_in(&waits.map(|at| (at, code))).iter().all(|act| matches!(act, None | Some(Act::Panic)))
            );
            let mut keys = Keys::default();
            for at in waits {
                let event = KeyEvent::new(code, KeyModifiers::NONE);
                let act = keys.press(event, Instant::now() + Duration::from_millis(at), true);
                assert!(matches!(act, None | Some(Act::Panic)), "{code:?} after {at} ms: {act:?}");
            }
        }
        // Somebody is opening it just now.
        let (esc, calm) = (KeyCode::Esc, KeyCode::Char('c'));
        assert_eq!(type_in(&[(0, esc), (20, calm), (40, esc)])[2], Some(Act::Panic));
    }

    #[test]
    fn the_rest_of_a_torn_sequence_is_no_key() {
        let torn = |rest: &str| {
            let rest = rest.chars().enumerate().map(|(n, c)| (10 + 40 * n as u64, KeyCode::Char(c)));
            type_in(&std::iter::once((0, KeyCode::Esc)).chain(rest).collect::<Vec<_>>())
        };
        // Up, Right, Left, Page Up, F1, Ctrl-Right.
        for rest in ["[A", "[C", "[D", "[5~", "OP", "[1;5C"] {
            let acts = torn(rest);
            assert_eq!(acts[0], Some(Act::Panic));
            assert!(acts[1..].iter().all(Option::is_none), "{rest}: {acts:?}");
        }
        // Behind it keys are keys again, as they are where no sequence begins.
        assert_eq!(torn("[Cc")[3], Some(Act::Calm));
        assert_eq!(torn("c")[1], Some(Act::Calm));
        assert_eq!(
            type_in(&[(0, KeyCode::Esc), (900, KeyCode::Char('[')), (950, KeyCode::Char('c'))])[2],
            Some(Act::Calm)
        );
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
        assert_eq!(press(KeyCode::Char('0'), KeyModifiers::NONE), Some(Act::Reset));
        assert_eq!(press(KeyCode::Char('d'), KeyModifiers::NONE), Some(Act::Reset));
        assert_eq!(press(KeyCode::Right, KeyModifiers::NONE), Some(Act::Move(1)));
        assert_eq!(press(KeyCode::Left, KeyModifiers::SHIFT), Some(Act::Move(-5)));
        assert_eq!(press(KeyCode::Tab, KeyModifiers::NONE), Some(Act::Choose(1)));
        assert_eq!(press(KeyCode::BackTab, KeyModifiers::SHIFT), Some(Act::Choose(-1)));
        assert_eq!(press(KeyCode::F(5), KeyModifiers::NONE), None);
        assert_eq!(
            press(KeyCode::Char('c'), KeyModifiers::ALT),
            Some(Act::Panic),
            "an Escape, and c at once"
        );
    }
}
