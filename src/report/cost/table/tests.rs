//! Text and comma-separated values.

use super::super::row::{Outcome, Row};
use super::{csv, kilohertz, power, text};

fn row(method: &'static str, rate: f64, error: f64, angle: Option<f64>, outcome: Outcome) -> Row {
    let held = outcome == Outcome::Held;
    let (model, problem) = if angle.is_some() { ("rumble motor", "full") } else { ("tactor", "burst") };
    Row {
        model,
        problem,
        about: "what happens",
        method,
        own: method == "fine",
        rate,
        of: if angle.is_some() {
            "error of the speed, share of the rated speed"
        } else {
            "error of the displacement, share of its peak"
        },
        error,
        angle,
        ns: held.then_some(123.456),
        outcome,
    }
}

fn rows() -> Vec<Row> {
    vec![
        row("fine", 1e3, 2.44e-7, Some(3e-5), Outcome::Held),
        row("fine", 44.1e3, 0.0, Some(0.0), Outcome::Held),
        row("Euler", 1e3, f64::NAN, Some(f64::NAN), Outcome::Diverged),
        row("Euler", 44.1e3, 0.5, Some(1.5), Outcome::Held),
        row("split, 4 steps", 1e3, 1.0, None, Outcome::Refused),
    ]
}

#[test]
fn a_table_has_every_figure_in_its_place() {
    let text = text(&rows());
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("rumble motor, full: error of the speed, share of the rated speed"));
    assert_eq!(lines[1].split_whitespace().collect::<Vec<_>>(), ["1", "kHz", "44.1", "kHz"]);
    let cells = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
    assert_eq!(cells(lines[2]), ["fine", "2.4e-7", "|", "123", "0.0e0", "|", "123"]);
    assert_eq!(cells(lines[3]), ["Euler", "unstable", "5.0e-1", "|", "123"]);
    assert_eq!(lines[5], "rumble motor, full: error of the angle, rad");
    assert_eq!(cells(lines[7]), ["fine", "3.0e-5", "0.0e0"]);
    assert!(text.contains("tactor, burst: error of the displacement, share of its peak"));
    assert!(text.lines().any(|line| cells(line).last().is_some_and(|cell| cell == "refused")));
    // Columns end where their heads do.
    assert_eq!(lines[1].len(), lines[2].len());
    assert_eq!(lines[2].len(), lines[3].len());
}

#[test]
fn values_are_one_line_a_row_and_as_many_cells() {
    let text = csv(&rows());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 6);
    assert_eq!(lines[1], "rumble motor,full,\"fine\",true,1000,2.440e-7,3.000e-5,123.46,held");
    assert_eq!(lines[3], "rumble motor,full,\"Euler\",false,1000,,,,unstable");
    assert_eq!(lines[5], "tactor,burst,\"split, 4 steps\",false,1000,1.000e0,,,refused");
    for line in &lines {
        // Commas between quotes do not part.
        let outside: String = line.split('"').step_by(2).collect();
        assert_eq!(outside.matches(',').count(), 8, "{line}");
    }
}

#[test]
fn numbers_are_short() {
    assert_eq!([1e3, 44.1e3, 192e3].map(kilohertz), ["1 kHz", "44.1 kHz", "192 kHz"]);
    assert_eq!([2.449e-7, 0.0, 1.0, f64::NAN].map(power), ["2.4e-7", "0.0e0", "1.0e0", "none"]);
}
