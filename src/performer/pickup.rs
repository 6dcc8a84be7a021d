//! A fader that must come to where its control stands before it moves it.

/// Positions closer than this are the same: a step of 7 bits.
const NEAR: f64 = 1.0 / 127.0;

/// Whether a binding has its control in hand.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Pickup {
    last: Option<f64>,
    /// What it sent last, while it has the control.
    sent: Option<f64>,
}

impl Pickup {
    /// It stands at `position`, the control at `stands` (`None` where no position is that). Says whether it moves the control.
    pub fn moves(&mut self, position: f64, stands: Option<f64>) -> bool {
        let before = self.last.replace(position);
        let Some(stands) = stands else {
            // It could never come there.
            return true;
        };
        let holds = self.sent.is_some_and(|sent| (sent - stands).abs() < 1e-6);
        let passed = before.is_some_and(|before| (before - stands) * (position - stands) <= 0.0);
        let moves = holds || passed || (position - stands).abs() <= NEAR;
        self.sent = moves.then_some(position);
        moves
    }
}

#[cfg(test)]
mod tests {
    use super::Pickup;

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
    fn what_stands_elsewhere_is_taken_at_once() {
        assert!(Pickup::default().moves(0.3, None));
        assert!(Pickup::default().moves(0.5, Some(0.504)));
    }
}
