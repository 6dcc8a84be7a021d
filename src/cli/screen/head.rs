//! The head of the screen: what is played on what, and how it is doing.

use super::happened::clock;
use super::line::{Ink, Line};
use super::snapshot::Snapshot;
use crate::cli::table::{grouped, hertz};

/// From so many columns on, the parts of the latency are shown.
const PARTS: usize = 80;

/// Patch and device to the left, time and state to the right.
pub fn title(snapshot: &Snapshot, width: usize) -> Line {
    let mut state = Line::of(Ink::Plain, &clock(snapshot.elapsed));
    if let Some(duration) = snapshot.duration {
        state.put(Ink::Dim, &format!(" of {}", clock(duration)));
    }
    state.put(Ink::Plain, " ");
    let (ink, text) = match (snapshot.lost, snapshot.panicked, snapshot.armed) {
        (true, ..) => (Ink::Alarm, " DEVICE GONE "),
        (_, true, _) => (Ink::Alarm, " SHUT "),
        (.., true) => (Ink::Good, " ARMED "),
        (.., false) => (Ink::Warm, " -20 dB "),
    };
    state.put(ink, text);
    let mut line = Line::of(Ink::Bold, &format!(" {}", snapshot.title));
    line.put(Ink::Dim, &format!("  on {}", snapshot.device));
    if snapshot.rate > 0 {
        let channels = snapshot.tactors.len();
        line.put(Ink::Dim, &format!(", {}, {channels} ch", hertz(f64::from(snapshot.rate))));
    }
    let room = width.saturating_sub(state.width());
    let mut line = line.clip(room.saturating_sub(1), if snapshot.fancy { "…" } else { "~" });
    line.fill_to(room);
    line.join(state);
    line
}

/// A name and its figure.
fn figure(name: &str, value: &str, ink: Ink) -> Line {
    let mut line = Line::of(Ink::Dim, name);
    line.put(Ink::Plain, " ");
    line.put(ink, value);
    line
}

/// What should be nought.
fn fault(name: &str, count: u64) -> Line {
    figure(name, &grouped(count), if count == 0 { Ink::Plain } else { Ink::Hot })
}

/// Load, counters and latency, the most telling first.
pub fn figures(snapshot: &Snapshot, width: usize) -> Vec<Line> {
    let (figures, latency) = (&snapshot.figures, &snapshot.latency);
    let share = |share: f64| match share {
        x if x >= 0.7 => Ink::Hot,
        x if x >= 0.35 => Ink::Warm,
        _ => Ink::Plain,
    };
    let mut load = figure("load", &format!("{:.2} %", 100.0 * figures.mean), share(figures.mean));
    load.put(Ink::Dim, ", p99.9 ");
    load.put(share(figures.p999), &format!("{:.1} %", 100.0 * figures.p999));
    let milli = |seconds: f64| format!("{:.2}", 1000.0 * seconds);
    let mut delay = figure("latency", &latency.told(), Ink::Plain);
    if width >= PARTS {
        delay.put(Ink::Dim, &format!(" = block {} + engine {}", milli(latency.block), milli(latency.engine)));
        match latency.device {
            Some(device) => delay.put(Ink::Dim, &format!(" + device {}", milli(device))),
            None => delay.put(Ink::Dim, " + device unknown"),
        }
        if let Some(beyond) = latency.beyond {
            delay.put(Ink::Dim, &format!(" + measured {}", milli(beyond)));
        }
    }
    let touched = |name: &str, count: u64| {
        figure(name, &grouped(count), if count == 0 { Ink::Plain } else { Ink::Warm })
    };
    let mut lost = fault("lost", figures.lost);
    if !snapshot.refused.is_empty() {
        lost.put(Ink::Dim, &format!(" ({})", snapshot.refused));
    }
    let mut all = vec![
        load,
        figure("voices", &grouped(figures.voices), Ink::Bold),
        fault("xruns", figures.xruns),
        fault("late", figures.late),
        lost,
        delay,
        touched("limited", figures.limited),
        touched("clamped", figures.clamped),
    ];
    if let Some(input) = latency.input {
        all.push(figure("input", &format!("{} ms", milli(input)), Ink::Plain));
    }
    // What hardly ever happens takes no room until it does.
    let rare = [
        ("over time", figures.over),
        ("no numbers", figures.masked),
        ("voices cut short", figures.stolen),
        ("held back", figures.held_back),
        ("MIDI unused", figures.midi),
    ];
    all.extend(rare.into_iter().filter(|(_, count)| *count > 0).map(|(name, count)| fault(name, count)));
    all
}

#[cfg(test)]
mod tests {
    use super::figures;
    use crate::cli::screen::snapshot::{Figures, Snapshot};

    #[test]
    fn the_document_explains_every_figure() {
        let text = include_str!("../../../docs/live.md");
        let mut snapshot = Snapshot {
            figures: Figures { over: 1, masked: 1, stolen: 1, held_back: 1, midi: 1, ..Figures::default() },
            ..Snapshot::default()
        };
        snapshot.latency.input = Some(0.01);
        let all = figures(&snapshot, 200);
        assert_eq!(all.len(), 14);
        for line in all {
            let line = line.text();
            let name = line.split(|c: char| c.is_ascii_digit()).next().unwrap().trim();
            let name = name.strip_suffix("at least").unwrap_or(name).trim();
            assert!(text.contains(&format!("| `{name}` |")), "docs/live.md does not explain `{name}`");
        }
    }
}
