//! Rows as a picture: error against run time, a chart a problem, a curve a method, a point a rate.

use super::row::{Outcome, Row};
use super::table::{by_method, by_problem, kilohertz};
use crate::report::plot::sheet::{Curve, Panel, Sheet};

/// What runs across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// Nanoseconds a step: what a method costs wherever it runs.
    Step,
    /// Microseconds a second of motion: what it costs at a rate.
    Second,
}

/// Errors below this are drawn there: they are rounding.
const LEAST: f64 = 1e-17;
/// The rate whose points are large, Hz.
const MAIN: f64 = 48e3;
const COLUMNS: usize = 3;
/// Letters of a note, at most.
const NOTE: usize = 82;

/// The picture as SVG. `of` says what the errors are of, in a sentence or more, in a line or more.
pub fn picture(rows: &[Row], across: Across, of: &str) -> String {
    let mut rates: Vec<f64> = Vec::new();
    for row in rows {
        if !rates.contains(&row.rate) {
            rates.push(row.rate);
        }
    }
    rates.sort_by(f64::total_cmp);
    let rates = rates.iter().map(|rate| kilohertz(*rate)).collect::<Vec<_>>().join(", ");
    let about = format!(
        "A curve a method, a point a rate ({rates}), of which 48 kHz is large. Thick: the models; thin: plain methods. {of}"
    );
    let x = match across {
        Across::Step => "CPU time of a step (ns)",
        Across::Second => "CPU time of a second of motion (µs)",
    };
    Sheet {
        title: "Error against run time".into(),
        about: about.lines().map(str::to_string).collect(),
        x: x.into(),
        y: "largest error".into(),
        columns: COLUMNS,
        panels: by_problem(rows).into_iter().map(|(title, rows)| panel(title, &rows, across)).collect(),
    }
    .svg()
}

fn panel(title: String, rows: &[&Row], across: Across) -> Panel {
    let methods = by_method(rows);
    let mut away = Vec::new();
    for (name, rows) in &methods {
        for outcome in [Outcome::Diverged, Outcome::Refused] {
            let at: Vec<f64> = rows.iter().filter(|row| row.outcome == outcome).map(|row| row.rate).collect();
            if let (Some(first), Some(last)) = (at.first(), at.last()) {
                let from = if first < last { format!("{} to ", kilohertz(*first)) } else { String::new() };
                // Rates need not be in a row; then all are named.
                let all = rows.iter().filter(|row| (*first..=*last).contains(&row.rate)).count();
                let span = if all == at.len() {
                    from + &kilohertz(*last)
                } else {
                    at.iter().map(|rate| kilohertz(*rate)).collect::<Vec<_>>().join(", ")
                };
                away.push(format!("{name} {} at {span}", outcome.word()));
            }
        }
    }
    let about = rows.first().map_or(String::new(), |row| row.about.to_string());
    Panel {
        title,
        about,
        curves: methods.iter().map(|(name, rows)| curve(name, rows, across)).collect(),
        notes: lines(&away),
    }
}

fn curve(name: &str, rows: &[&Row], across: Across) -> Curve {
    let point = |row: &&Row| {
        let cost = match across {
            Across::Step => row.ns?,
            Across::Second => row.load()? * 1e6,
        };
        Some((cost, row.error.max(LEAST), row.rate == MAIN))
    };
    Curve {
        name: name.into(),
        strong: rows.first().is_some_and(|row| row.own),
        points: rows.iter().filter_map(point).collect(),
    }
}

/// Phrases in lines.
fn lines(phrases: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for phrase in phrases {
        match lines.last_mut() {
            Some(line) if line.chars().count() + phrase.chars().count() + 2 <= NOTE => {
                *line += "; ";
                *line += phrase;
            }
            _ => lines.push(phrase.clone()),
        }
    }
    lines
}

#[cfg(test)]
mod tests;
