//! Rows as text, and as comma-separated values.

use std::fmt::Write;

use super::row::{Outcome, Row};

/// A table for each problem: a line a method, a column a rate, in each the error and the nanoseconds a step; for what turns another of
/// the errors of the angle.
pub fn text(rows: &[Row]) -> String {
    let mut out = String::new();
    for (title, rows) in by_problem(rows) {
        let what = rows.first().map_or("error", |row| row.of);
        let _ = writeln!(out, "{title}: {what} | ns a step");
        block(&mut out, &rows, |row| format!("{} |{:>6}", power(row.error), nanoseconds(row.ns)));
        if rows.iter().any(|row| row.angle.is_some()) {
            let _ = writeln!(out, "{title}: error of the angle, rad");
            block(&mut out, &rows, |row| power(row.angle.unwrap_or(f64::NAN)));
        }
    }
    out
}

/// One line a row, under a line of names: `model,problem,method,own,rate_hz,error,error_angle_rad,ns_per_step,outcome`. What there is not,
/// is empty.
pub fn csv(rows: &[Row]) -> String {
    let mut out =
        String::from("model,problem,method,own,rate_hz,error,error_angle_rad,ns_per_step,outcome\n");
    let cell = |x: f64| if x.is_finite() { format!("{x:.3e}") } else { String::new() };
    for row in rows {
        let Row { model, problem, method, own, rate, .. } = row;
        let (error, angle) = (cell(row.error), cell(row.angle.unwrap_or(f64::NAN)));
        let ns = row.ns.map_or(String::new(), |ns| format!("{ns:.2}"));
        let outcome = row.outcome.word();
        // Names with commas are the only ones that need it.
        let _ = writeln!(out, "{model},{problem},\"{method}\",{own},{rate},{error},{angle},{ns},{outcome}");
    }
    out
}

/// Problems in the order in which they first come, with their rows.
pub(super) fn by_problem(rows: &[Row]) -> Vec<(String, Vec<&Row>)> {
    grouped(rows.iter(), Row::title)
}

/// The same by method.
pub(super) fn by_method<'a>(rows: &[&'a Row]) -> Vec<(String, Vec<&'a Row>)> {
    grouped(rows.iter().copied(), |row| row.method.to_string())
}

fn grouped<'a>(
    rows: impl Iterator<Item = &'a Row>,
    name: impl Fn(&Row) -> String,
) -> Vec<(String, Vec<&'a Row>)> {
    let mut groups: Vec<(String, Vec<&Row>)> = Vec::new();
    for row in rows {
        let name = name(row);
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, group)) => group.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    groups
}

/// A rate: "44.1 kHz".
pub(super) fn kilohertz(rate: f64) -> String {
    format!("{} kHz", (rate * 1e-3 * 1e6).round() / 1e6)
}

fn block(out: &mut String, rows: &[&Row], cell: impl Fn(&Row) -> String) {
    let mut rates: Vec<f64> = Vec::new();
    for row in rows {
        if !rates.contains(&row.rate) {
            rates.push(row.rate);
        }
    }
    let mut lines = vec![[vec![String::new()], rates.iter().map(|rate| kilohertz(*rate)).collect()].concat()];
    for (method, rows) in by_method(rows) {
        let mut line = vec![method];
        for rate in &rates {
            line.push(rows.iter().find(|row| row.rate == *rate).map_or(
                String::new(),
                |row| match row.outcome {
                    Outcome::Held => cell(row),
                    other => other.word().to_string(),
                },
            ));
        }
        lines.push(line);
    }
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..=rates.len()).map(width).collect();
    for line in &lines {
        let _ = write!(out, "  {:<wide$}", line[0], wide = widths[0]);
        for (cell, wide) in line.iter().zip(&widths).skip(1) {
            let _ = write!(out, "   {cell:>wide$}");
        }
        let end = out.trim_end().len();
        out.truncate(end);
        out.push('\n');
    }
    out.push('\n');
}

/// Two digits and a power of ten: "2.4e-7".
fn power(x: f64) -> String {
    if x.is_finite() { format!("{x:.1e}") } else { "none".into() }
}

fn nanoseconds(ns: Option<f64>) -> String {
    match ns {
        None => "none".into(),
        Some(ns) if ns < 99.95 => format!("{ns:.1}"),
        Some(ns) => format!("{ns:.0}"),
    }
}

#[cfg(test)]
mod tests;
