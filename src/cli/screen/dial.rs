//! A knob as a line: its turn unrolled, and what it says and gives.

use super::line::{Ink, Line};
use pacinian::live::board::Turned;
use std::f64::consts::TAU;

/// Columns of a turn.
const TURN: usize = 25;

/// Half a turn to the left of where it was at first and half a turn to the right, and further round; whole turns are in the figure.
pub fn dial(knob: &Turned, width: usize, fancy: bool) -> Line {
    let [rule, zero, hand] = if fancy { ['─', '┼', '●'] } else { ['-', '+', 'O'] };
    let mut line = Line::of(Ink::Dim, " knob ");
    let share = (knob.angle / TAU + 0.5).rem_euclid(1.0);
    let at = if share.is_finite() { Some((share * TURN as f64) as usize % TURN) } else { None };
    for column in 0..TURN {
        match (Some(column) == at, column == TURN / 2) {
            (true, _) => line.put(Ink::Accent, &hand.to_string()),
            (_, true) => line.put(Ink::Dim, &zero.to_string()),
            _ => line.put(Ink::Dim, &rule.to_string()),
        }
    }
    for (value, digits, unit) in
        [(knob.angle, 3, "rad"), (knob.speed, 1, "rad/s"), (1e3 * knob.torque, 2, "mN m")]
    {
        let text = if value.is_finite() { format!("{value:+.digits$}") } else { "?".into() };
        line.put(Ink::Bold, &format!("  {text:>9}"));
        line.put(Ink::Dim, &format!(" {unit}"));
    }
    line.clip(width, if fancy { "…" } else { "~" })
}

#[cfg(test)]
mod tests {
    use super::{TURN, dial};
    use pacinian::live::board::Turned;
    use std::f64::consts::PI;

    fn plain(angle: f64) -> String {
        let knob = Turned { angle, speed: -2.0, torque: 0.0123 };
        dial(&knob, 200, false).pieces().iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn the_hand_goes_round_and_the_figures_go_on() {
        let place = |angle: f64| plain(angle).find('O').unwrap() - " knob ".len();
        assert_eq!((place(0.0), place(2.0 * PI), place(-4.0 * PI)), (TURN / 2, TURN / 2, TURN / 2));
        assert_eq!((place(-PI + 1e-9), place(PI - 1e-9)), (0, TURN - 1));
        assert!(place(0.5) > TURN / 2 && place(-0.5) < TURN / 2);
        let text = plain(8.0);
        for part in ["+8.000 rad", "-2.0 rad/s", "+12.30 mN m"] {
            assert!(text.contains(part), "{text}");
        }
        let text = plain(f64::NAN);
        assert!(!text.contains('O') && text.contains("? rad"), "{text}");
        assert_eq!(dial(&Turned::default(), 12, true).width(), 12);
    }
}
