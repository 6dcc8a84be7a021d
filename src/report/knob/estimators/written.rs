//! Estimates as text, comma-separated values, and SVG.

use std::fmt::Write;

use super::{Estimate, Swing};
use crate::report::plot::sheet::{Curve, Panel, Sheet};

/// What runs up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// All that is missed, rad/s.
    Error,
    /// What is left beside the swing, rad/s.
    Noise,
    /// How late it is, s.
    Lag,
}

/// The rate whose points are large, Hz.
const MAIN: f64 = 48e3;

/// A table for each swing and rate: a line an estimator.
pub fn text(all: &[Estimate]) -> String {
    let mut out = String::new();
    let mut last: Option<(Swing, f64)> = None;
    for e in all_by_rate(all) {
        if last.replace((e.swing, e.rate)) != Some((e.swing, e.rate)) {
            let _ = writeln!(out, "{}, {} Hz, {} counts a turn", title(e.swing), e.rate, e.counts);
            let _ = writeln!(
                out,
                "  {:16} {:>10} {:>10} {:>10} {:>8} {:>10} {:>8}",
                "", "rms rad/s", "worst", "lag ms", "gain", "noise", "ns"
            );
        }
        let _ = writeln!(
            out,
            "  {:16} {:>10.4} {:>10.4} {:>10.3} {:>8.4} {:>10.4} {:>8.1}",
            e.method,
            e.rms,
            e.worst,
            1e3 * e.lag,
            e.gain,
            e.noise,
            e.ns
        );
    }
    out
}

/// One line an estimate, under a line of names:
/// `method,rate_hz,counts,peak_rad_s,frequency_hz,rms_rad_s,worst_rad_s,lag_s,gain,noise_rad_s,ns_per_reading`. What is no number, is empty.
pub fn csv(all: &[Estimate]) -> String {
    let mut out = String::from(
        "method,rate_hz,counts,peak_rad_s,frequency_hz,rms_rad_s,worst_rad_s,lag_s,gain,noise_rad_s,ns_per_reading\n",
    );
    let cell = |x: f64| if x.is_finite() { format!("{x:.4e}") } else { String::new() };
    for e in all {
        let [rms, worst, lag, gain, noise] = [e.rms, e.worst, e.lag, e.gain, e.noise].map(cell);
        let (peak, hertz) = e.swing;
        let _ = writeln!(
            out,
            "\"{}\",{},{},{peak},{hertz},{rms},{worst},{lag},{gain},{noise},{:.2}",
            e.method, e.rate, e.counts, e.ns
        );
    }
    out
}

/// The picture as SVG: a chart a swing, a curve an estimator, a point a rate.
pub fn picture(all: &[Estimate], what: What) -> String {
    let mut swings: Vec<Swing> = Vec::new();
    all.iter().for_each(|e| {
        if !swings.contains(&e.swing) {
            swings.push(e.swing);
        }
    });
    let mut rates: Vec<f64> = all.iter().map(|e| e.rate).collect();
    rates.sort_by(f64::total_cmp);
    rates.dedup();
    let rates = rates.iter().map(|rate| format!("{} kHz", rate * 1e-3)).collect::<Vec<_>>().join(", ");
    let counts = all.first().map_or(0.0, |e| e.counts);
    let (title, y) = match what {
        What::Error => ("Velocity estimators: error against run time", "rms error (rad/s)"),
        What::Noise => ("Velocity estimators: noise against run time", "rms noise beside the swing (rad/s)"),
        What::Lag => ("Velocity estimators: lag against run time", "lag (s)"),
    };
    Sheet {
        title: title.into(),
        about: vec![format!(
            "A curve an estimator, a point a rate ({rates}), of which 48 kHz is large. An encoder of {counts} counts a turn."
        )],
        x: "CPU time of a reading (ns)".into(),
        y: y.into(),
        columns: 3,
        panels: swings.iter().map(|swing| panel(all, *swing, what)).collect(),
    }
    .svg()
}

fn panel(all: &[Estimate], swing: Swing, what: What) -> Panel {
    let mut curves: Vec<Curve> = Vec::new();
    let mut hidden = 0;
    for e in all.iter().filter(|e| e.swing == swing) {
        let up = match what {
            What::Error => e.rms,
            What::Noise => e.noise,
            What::Lag => e.lag,
        };
        hidden += usize::from(!(up > 0.0 && up.is_finite()));
        let point = (e.ns, up, e.rate == MAIN);
        match curves.iter_mut().find(|curve| curve.name == e.method) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve { name: e.method.into(), strong: false, points: vec![point] }),
        }
    }
    let mut notes = Vec::new();
    if hidden > 0 {
        notes.push(format!("Not above 0, and not shown: {hidden}"));
    }
    Panel { title: title(swing), about: String::new(), curves, notes }
}

fn title((peak, hertz): Swing) -> String {
    format!("{peak} rad/s at {hertz} Hz")
}

/// By swing, then by rate, then as they came.
fn all_by_rate(all: &[Estimate]) -> Vec<&Estimate> {
    let mut keys: Vec<(Swing, f64)> = Vec::new();
    all.iter().for_each(|e| {
        if !keys.contains(&(e.swing, e.rate)) {
            keys.push((e.swing, e.rate));
        }
    });
    let first = |swing: Swing| keys.iter().position(|k| k.0 == swing);
    let mut sorted = keys.clone();
    sorted.sort_by_key(|(swing, _)| first(*swing));
    sorted.iter().flat_map(|key| all.iter().filter(move |e| (e.swing, e.rate) == *key)).collect()
}
