//! The controls, as they stand on the screen, and what is wrong with what was saved.

use super::controls::ControlFace;
use super::fold::folded;
use super::happened::short;
use super::line::{Ink, Line};
use super::snapshot::Snapshot;

/// Columns that a control needs.
const CELL: usize = 36;

/// Columns that its name takes, at most, and its value with the unit.
const NAME: usize = 16;
const VALUE: usize = 12;

/// What the keys do.
const MOVES: &str = "Tab chooses, left and right move, 0 resets";

/// Rows that the controls need where they are `width` wide.
pub fn rows(snapshot: &Snapshot, width: usize) -> usize {
    snapshot.controls.len().div_ceil((width / CELL).max(1))
}

/// The controls in so many rows, the chosen one among them, and which of all they are.
pub fn panel(snapshot: &Snapshot, width: usize, rows: usize) -> (Vec<Line>, String) {
    let all = &snapshot.controls;
    let columns = (width / CELL).max(1).min(all.len().max(1));
    let shown = (columns * rows).max(1);
    let chosen = all.iter().position(|control| control.chosen).unwrap_or(0);
    let first = chosen / shown * shown;
    let part = all.get(first..all.len().min(first + shown)).unwrap_or_default();
    let cell = (width.saturating_sub(1) / columns).saturating_sub(if columns > 1 { 2 } else { 0 });
    let lines = part.chunks(columns).take(rows).map(|row| {
        let mut line = Line::default();
        for (column, control) in row.iter().enumerate() {
            line.fill_to(column * (cell + 2));
            line.join(face(control, cell, snapshot.fancy));
        }
        line
    });
    let note = match part.len() == all.len() {
        true => format!("controls: {MOVES}"),
        false => format!("controls {} to {} of {}: {MOVES}", first + 1, first + part.len(), all.len()),
    };
    (lines.collect(), note)
}

fn face(control: &ControlFace, width: usize, fancy: bool) -> Line {
    let mark = if fancy { "…" } else { "~" };
    let sign = match (control.chosen, fancy) {
        (true, true) => "›",
        (true, false) => ">",
        _ => " ",
    };
    let ink = if control.chosen { Ink::Accent } else { Ink::Plain };
    let mut line = Line::of(Ink::Accent, sign);
    let name = NAME.min(width / 3);
    line.join(Line::of(ink, &control.name).clip(name, mark));
    line.fill_to(name + 2);
    let value = VALUE.min(width / 3);
    let bar = width.saturating_sub(name + value + 4);
    let full = (control.position * bar as f64).round() as usize;
    let (filled, empty) = if fancy { ('█', '·') } else { ('#', '.') };
    let begin = line.width();
    line.fill_with(Ink::Good, filled, begin + full);
    line.fill_with(Ink::Dim, empty, begin + bar);
    let unit = if control.unit.is_empty() { String::new() } else { format!(" {}", control.unit) };
    line.put(Ink::Plain, " ");
    line.join(Line::of(ink, &format!("{}{unit}", short(control.value))).clip(value, mark));
    line.clip(width, mark)
}

/// Everything that is wrong with what was saved, in lines that are no wider than the screen.
pub fn wrong(snapshot: &Snapshot, width: usize) -> Vec<Line> {
    let lines = snapshot.wrong.iter().flat_map(|line| {
        let help = line.starts_with(' ');
        let ink = if help { Ink::Dim } else { Ink::Plain };
        folded(line.trim(), width.saturating_sub(if help { 5 } else { 1 }), if help { 5 } else { 1 }, ink)
    });
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::{panel, rows, wrong};
    use crate::cli::screen::controls::ControlFace;
    use crate::cli::screen::snapshot::Snapshot;

    fn snapshot(count: usize, chosen: usize) -> Snapshot {
        let face = |n: usize| ControlFace {
            name: format!("control-{n}"),
            value: 250.0,
            unit: "Hz".into(),
            position: 0.5,
            chosen: n == chosen,
        };
        Snapshot { controls: (0..count).map(face).collect(), fancy: true, ..Snapshot::default() }
    }

    #[test]
    fn the_chosen_control_is_seen_however_little_room_there_is() {
        for (count, width, height) in [(1, 80, 1), (3, 80, 2), (40, 80, 3), (40, 20, 1), (7, 160, 1)] {
            for chosen in 0..count {
                let (lines, note) = panel(&snapshot(count, chosen), width, height);
                assert!(lines.len() <= height && lines.iter().all(|line| line.width() <= width));
                let text: String = lines.iter().map(|line| line.text() + "\n").collect();
                assert!(text.contains('›'), "{chosen} of {count} in\n{text}");
                assert_eq!(note.contains(" of "), rows(&snapshot(count, 0), width) > height, "{note}");
            }
        }
        let (lines, _) = panel(&snapshot(2, 0), 80, 1);
        let text = lines[0].text();
        assert!(
            text.starts_with("›control-0") && text.contains(" 250 Hz") && text.contains("control-1"),
            "{text}"
        );
        let full = text.split("control-1").next().unwrap().chars().filter(|c| *c == '█').count();
        let empty = text.split("control-1").next().unwrap().chars().filter(|c| *c == '·').count();
        assert!(full == empty || full + 1 == empty || full == empty + 1, "half: {text}");
    }

    #[test]
    fn what_is_wrong_is_shown_with_what_helps() {
        let wrong_lines =
            wrong(&Snapshot { wrong: vec!["what".into(), "  help: do".into()], ..Snapshot::default() }, 40);
        assert_eq!(wrong_lines.iter().map(|l| l.text()).collect::<Vec<_>>(), [" what", "     help: do"]);
    }
}
