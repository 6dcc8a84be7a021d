//! The bar of a meter.

use super::line::{Ink, Line};
use super::meter::{LEAST, Meter};

/// From here on up, dB: near full scale, and at it.
const WARM: f32 = -12.0;
const HOT: f32 = -3.0;

/// Eighths of a column, from the left.
const EIGHTHS: [char; 8] = [' ', '▏', '▎', '▍', '▌', '▋', '▊', '▉'];

/// Eighths of a line, from the foot.
const RISING: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
const DIGITS: [char; 8] = ['1', '2', '3', '4', '5', '6', '7', '8'];

/// How a level looks, dB.
pub fn ink(level: f32) -> Ink {
    match level {
        x if x >= HOT => Ink::Hot,
        x if x >= WARM => Ink::Warm,
        _ => Ink::Good,
    }
}

/// Which part of the bar a level fills, 0 to 1.
fn part(level: f32) -> f32 {
    (1.0 - level / LEAST).clamp(0.0, 1.0)
}

/// A bar of so many columns.
pub fn bar(meter: &Meter, width: usize, fancy: bool) -> Line {
    let mut line = Line::default();
    let filled = part(meter.level) * width as f32;
    let mark = part(meter.mark) * width as f32;
    // The column in which the level ends.
    let mark = (mark > 0.0).then(|| (mark.ceil() as usize).saturating_sub(1));
    for column in 0..width {
        let ink = ink(LEAST * (1.0 - (column as f32 + 0.5) / width as f32));
        let inside = (filled - column as f32).clamp(0.0, 1.0);
        let eighths = (inside * 8.0).round() as usize;
        let (ink, sign) = match (eighths, fancy) {
            (8.., true) => (ink, '█'),
            (4.., false) => (ink, '#'),
            (0, _) | (_, false) if mark == Some(column) => (ink, if fancy { '│' } else { '|' }),
            (0, true) => (Ink::Dim, '·'),
            (_, false) => (Ink::Dim, '.'),
            (some, true) => (ink, EIGHTHS[some]),
        };
        line.put(ink, sign.encode_utf8(&mut [0; 4]));
    }
    line
}

/// The level in decibels, in five columns.
pub fn number(meter: &Meter, fancy: bool) -> Line {
    if meter.is_full() {
        return Line::of(Ink::Alarm, " FULL");
    }
    match meter.mark {
        mark if mark >= LEAST => Line::of(ink(mark), &format!("{:>5.1}", mark.min(0.0))),
        _ => Line::of(Ink::Dim, if fancy { "   −∞" } else { " -inf" }),
    }
}

/// A meter of one column.
pub fn sign(meter: &Meter, fancy: bool) -> Line {
    let ink = if meter.is_full() { Ink::Alarm } else { ink(meter.level) };
    let step = (part(meter.level) * 8.0).ceil() as usize;
    match (step.checked_sub(1), fancy) {
        (None, true) => Line::of(Ink::Dim, "·"),
        (None, false) => Line::of(Ink::Dim, "."),
        (Some(step), fancy) => {
            let signs = if fancy { RISING } else { DIGITS };
            Line::of(ink, signs[step.min(7)].encode_utf8(&mut [0; 4]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{bar, number, sign};
    use crate::cli::screen::line::Ink;
    use crate::cli::screen::meter::Meter;

    fn at(db: f32) -> Meter {
        let mut meter = Meter::default();
        meter.hear(10.0_f32.powf(db / 20.0), 0.05);
        meter
    }

    #[test]
    fn the_bar_is_as_long_as_the_level_is_high() {
        // Sixty columns: one a decibel.
        for db in [-59.0, -42.0, -30.0, -12.0, -1.0, 0.0] {
            let text = bar(&at(db), 60, true).text();
            let full = text.chars().filter(|c| *c == '█').count();
            assert_eq!(full, (60.0 + db).round() as usize, "{db} dB: {text}");
            let plain = bar(&at(db), 60, false);
            assert_eq!(plain.text().chars().filter(|c| *c == '#').count(), full);
            assert!(plain.text().is_ascii() && plain.width() == 60);
        }
        assert_eq!(bar(&Meter::default(), 10, true).text(), "··········");
        assert_eq!(bar(&at(40.0), 10, true).text(), "██████████");
        assert_eq!(bar(&at(-55.0), 6, true).text(), "▌·····");
        assert_eq!(bar(&at(-6.0), 0, true).width(), 0);
    }

    #[test]
    fn the_mark_stays_behind_and_the_colour_is_that_of_the_place() {
        let mut meter = at(-10.5);
        meter.hear(0.0, 0.5);
        let line = bar(&meter, 60, true);
        assert_eq!(line.text().chars().position(|c| c == '│'), Some(49));
        let inks: Vec<_> =
            bar(&at(0.0), 60, true).pieces().iter().map(|(i, t)| (*i, t.chars().count())).collect();
        assert_eq!(inks, [(Ink::Good, 48), (Ink::Warm, 9), (Ink::Hot, 3)]);
    }

    #[test]
    fn numbers_take_five_columns() {
        let texts =
            [at(-12.34), at(-3.0), at(-60.0), Meter::default(), at(0.0)].map(|m| number(&m, true).text());
        assert_eq!(texts, ["-12.3", " -3.0", "-60.0", "   −∞", " FULL"]);
        assert_eq!(number(&Meter::default(), false).text(), " -inf");
    }

    #[test]
    fn a_single_sign_grows() {
        let signs: String =
            [-70.0, -59.0, -45.0, -30.0, -16.0, -1.0].iter().map(|db| sign(&at(*db), true).text()).collect();
        assert_eq!(signs, "·▁▂▄▆█");
        assert_eq!(sign(&at(-30.0), false).text(), "4");
        assert_eq!(sign(&at(0.0), true).pieces()[0].0, Ink::Alarm);
    }
}
