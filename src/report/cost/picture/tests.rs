//! What the picture says and shows.

use super::super::row::{Outcome, Row};
use super::{Across, lines, panel, picture};

fn row(method: &'static str, rate: f64, outcome: Outcome) -> Row {
    let held = outcome == Outcome::Held;
    Row {
        model: "tactor",
        problem: "burst",
        about: "what happens",
        method,
        own: method == "exact",
        rate,
        of: "error of the displacement, share of its peak",
        error: if held { 1e3 / (rate * rate) } else { f64::NAN },
        angle: None,
        ns: held.then_some(20.0),
        outcome,
    }
}

fn rows() -> Vec<Row> {
    use Outcome::{Diverged, Held, Refused};
    let rates = [1e3, 8e3, 48e3, 192e3];
    let of = |method, outcomes: [Outcome; 4]| {
        rates.into_iter().zip(outcomes).map(move |(rate, outcome)| row(method, rate, outcome))
    };
    of("exact", [Held; 4])
        .chain(of("Euler", [Diverged, Diverged, Held, Held]))
        .chain(of("RK4", [Diverged, Held, Diverged, Held]))
        .chain(of("split", [Refused, Held, Held, Held]))
        .collect()
}

#[test]
fn it_says_what_it_does_not_show() {
    let rows = rows();
    let all: Vec<&Row> = rows.iter().collect();
    let panel = panel("tactor, burst".into(), &all, Across::Step);
    let notes = panel.notes.join("; ");
    assert_eq!(
        notes,
        "Euler unstable at 1 kHz to 8 kHz; RK4 unstable at 1 kHz, 48 kHz; split refused at 1 kHz"
    );
    assert!(panel.curves[0].strong && !panel.curves[1].strong);
    assert_eq!(panel.curves.iter().map(|c| c.points.len()).collect::<Vec<_>>(), [4, 2, 2, 3]);
    let svg = picture(&rows, Across::Second, "Errors: of something.");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> =
        document.descendants().filter_map(|n| if n.is_text() { n.text() } else { None }).collect();
    for text in
        ["tactor, burst", "what happens", "exact", "Euler", "RK4", "CPU time of a second of motion (µs)"]
    {
        assert!(texts.contains(&text), "{text} in {texts:?}");
    }
}

#[test]
fn points_stand_at_cost_and_error() {
    let rows = rows();
    let all: Vec<&Row> = rows.iter().collect();
    let step = panel(String::new(), &all, Across::Step);
    let second = panel(String::new(), &all, Across::Second);
    assert_eq!(step.curves[0].points[2], (20.0, 1e3 / (48e3 * 48e3), true));
    // 20 ns × 48 kHz are 960 µs a second.
    let (cost, _, large) = second.curves[0].points[2];
    assert!((cost - 960.0).abs() < 1e-9 && large && !second.curves[0].points[1].2);
}

#[test]
fn no_rows_are_still_a_picture() {
    roxmltree::Document::parse(&picture(&[], Across::Step, "")).unwrap();
    assert!(lines(&[]).is_empty());
    let long = vec!["x".repeat(50); 3];
    assert_eq!(lines(&long).len(), 3);
}
