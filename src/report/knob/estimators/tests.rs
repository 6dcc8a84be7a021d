use super::{Estimate, NAMES, What, Wish, csv, estimators, parted, picture, text};
use std::f64::consts::TAU;

fn measured(swing: (f64, f64), rate: f64) -> Vec<Estimate> {
    estimators(&Wish { swings: vec![swing], rates: vec![rate], seconds: 1.0, ..Wish::default() }).unwrap()
}

fn of<'a>(all: &'a [Estimate], name: &str) -> &'a Estimate {
    all.iter().find(|e| e.method == name).unwrap()
}

#[test]
fn a_known_estimate_is_parted_into_what_it_was_made_of() {
    // Late by 3.7 samples, 0.8 times as large, with noise of 0.2 rms beside it at another frequency.
    let turn = TAU / 500.0;
    let values: Vec<f64> = (0..5000)
        .map(|n| {
            let n = f64::from(n) + 130.0;
            4.0 * (turn * (n - 3.7)).sin() + 0.2 * 2f64.sqrt() * (7.0 * turn * n).cos()
        })
        .collect();
    let (lag, size, noise) = parted(&values, turn, 130);
    assert!(
        (lag - 3.7).abs() < 1e-9 && (size - 4.0).abs() < 1e-12 && (noise - 0.2).abs() < 1e-12,
        "{lag} {size} {noise}"
    );
    assert!(parted(&[], turn, 0).0.is_nan());
}

/// Against figures of the literature's methods computed elsewhere at the same counts.
#[test]
fn figures_are_those_computed_elsewhere() {
    let all = measured((5.0, 2.0), 1000.0);
    assert_eq!(all.len(), NAMES.len());
    assert!((of(&all, "difference").rms / 0.62 - 1.0).abs() < 0.05);
    assert!((of(&all, "low-pass 100 Hz").rms / 0.17 - 1.0).abs() < 0.1);
    // Its bound on acceleration is a matter of taste.
    assert!((0.09..0.36).contains(&of(&all, "Kalman").rms), "{}", of(&all, "Kalman").rms);
    // Half a tick; and √2 / ω more.
    let [plain, smooth] = ["difference", "low-pass 100 Hz"].map(|name| of(&all, name).lag);
    assert!((plain - 0.5e-3).abs() < 2e-4, "{plain}");
    assert!((smooth - 0.5e-3 - 2f64.sqrt() / (TAU * 100.0)).abs() < 3e-4, "{smooth}");
    let fast = measured((20.0, 10.0), 48_000.0);
    assert!((of(&fast, "difference").rms / 28.0 - 1.0).abs() < 0.05);
    assert!((of(&fast, "low-pass 100 Hz").rms / 2.0 - 1.0).abs() < 0.1);
    for e in all.iter().chain(&fast) {
        // All that is missed is lag, gain and noise: no part is larger than the whole.
        assert!(e.noise <= e.rms * 1.01 && e.worst >= e.rms && e.ns > 0.0, "{e:?}");
        let (late, apart) = (TAU * e.swing.1 * e.lag, e.swing.0 / 2f64.sqrt());
        let swing = (1.0 + e.gain * e.gain - 2.0 * e.gain * late.cos()).sqrt() * apart;
        assert!((swing.hypot(e.noise) / e.rms - 1.0).abs() < 0.03, "{e:?}");
    }
}

#[test]
fn it_is_written_and_drawn() {
    let wish = Wish { rates: vec![1e3, 48e3], seconds: 0.2, ..Wish::default() };
    let all = estimators(&wish).unwrap();
    let text = text(&all);
    println!("{text}");
    assert_eq!(text.matches("counts a turn").count(), 6);
    assert_eq!(text.lines().count(), 6 * (2 + NAMES.len()));
    let csv = csv(&all);
    assert_eq!(csv.lines().count(), 1 + 6 * NAMES.len());
    let outside = |line: &str| line.split('"').step_by(2).collect::<String>().matches(',').count();
    assert!(csv.lines().all(|line| outside(line) == 10), "{csv}");
    for what in [What::Error, What::Noise, What::Lag] {
        roxmltree::Document::parse(&picture(&all, what)).unwrap();
        roxmltree::Document::parse(&picture(&[], what)).unwrap();
    }
}

#[test]
fn wishes_that_cannot_be_are_refused() {
    let good = Wish { seconds: 0.01, ..Wish::default() };
    for (wish, field) in [
        (Wish { counts: 0.0, ..good.clone() }, "counts"),
        (Wish { seconds: f64::NAN, ..good.clone() }, "seconds"),
        (Wish { rates: vec![1.0], ..good.clone() }, "rate"),
        (Wish { swings: vec![(0.0, 1.0)], ..good.clone() }, "peak"),
        (Wish { swings: vec![(1.0, f64::INFINITY)], ..good }, "frequency"),
    ] {
        assert_eq!(estimators(&wish).unwrap_err().field, field);
    }
}
