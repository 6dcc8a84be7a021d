//! All meters, in the most telling form for which there is room.

use super::bar::{bar, number, sign};
use super::line::{Ink, Line};
use super::meter::Meter;
use super::snapshot::Snapshot;
use crate::cli::table::{grouped, many};

/// Columns that a meter needs with its name and its number, and with a short name alone.
const WHOLE: usize = 32;
const NARROW: usize = 16;

/// Columns that names take, at most; and those of a bar that they leave, with its number and alone.
const NAME: usize = 40;
const BAR: [usize; 2] = [10, 6];

/// Meters that stand together where each has one sign.
const TOGETHER: usize = 8;

/// The meters.
#[derive(Debug, Default)]
pub struct Meters {
    /// As lines.
    pub lines: Vec<Line>,
    /// What is shown.
    pub note: String,
    /// Pages that there are.
    pub pages: usize,
}

/// How meters are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Name, bar and number, in so many columns of them.
    Whole(usize),
    /// Name and bar.
    Narrow(usize),
    /// One sign each.
    Sign,
}

impl Form {
    /// For `count` meters in `width` by `rows`.
    fn choose(count: usize, width: usize, rows: usize, paged: bool) -> Self {
        let fits = |columns: usize, rows: usize| count.div_ceil(columns) <= rows;
        let whole = 1..=width / WHOLE;
        // Long bars are easier to read, but something else is to be seen as well.
        let pleasant = whole.clone().find(|&c| fits(c, (rows * 2 / 3).max(1)));
        if let Some(columns) = pleasant.or_else(|| whole.clone().find(|&c| fits(c, rows))) {
            return Self::Whole(columns);
        }
        let most = (width / NARROW).max(1);
        match (1..=most).find(|&c| fits(c, rows)) {
            Some(columns) => Self::Narrow(columns),
            None if paged => Self::Narrow(most),
            None => Self::Sign,
        }
    }
}

/// The meters of a snapshot in `width` by at most `rows`.
pub fn meters(snapshot: &Snapshot, width: usize, rows: usize) -> Meters {
    let shown: Vec<(usize, &str, &Meter)> = snapshot
        .tactors
        .iter()
        .enumerate()
        .filter(|(_, (name, _))| !name.is_empty())
        .map(|(channel, (name, meter))| (channel, name.as_str(), meter))
        .collect();
    if shown.is_empty() || width == 0 || rows == 0 {
        return Meters { note: many(shown.len(), "output"), pages: 1, ..Meters::default() };
    }
    let form = Form::choose(shown.len(), width, rows, snapshot.paged);
    let (label, across) = match form {
        Form::Whole(columns) | Form::Narrow(columns) => (0, columns),
        Form::Sign => signs(shown.len(), width, rows),
    };
    let on_page = (across * rows).min(shown.len());
    let pages = shown.len().div_ceil(on_page);
    let page = snapshot.page.min(pages - 1);
    let part = shown.get(page * on_page..).unwrap_or_default();
    let part = part.get(..on_page).unwrap_or(part);
    let lines = match form {
        Form::Sign => part.chunks(across).map(|row| dense(row, label, width, snapshot.fancy)).collect(),
        Form::Whole(columns) => block(part, columns, width, true, snapshot.fancy),
        Form::Narrow(columns) => block(part, columns, width, false, snapshot.fancy),
    };
    let mut note = many(shown.len(), "output");
    if pages > 1 {
        let first = page * on_page + 1;
        note = format!(
            "{} to {} of {note}, page {} of {pages}: < >",
            grouped(first as u64),
            grouped((first + part.len() - 1) as u64),
            page + 1,
        );
    }
    note += match (form, pages) {
        (Form::Sign, _) => ", one sign each; m: by name",
        (Form::Narrow(_), 2..) if snapshot.paged => "; m: all at once",
        _ => "",
    };
    if snapshot.blind {
        note += "; they rest, as there is too much to do";
    }
    Meters { lines, note, pages }
}

/// Meters down one column and then the next.
fn block(
    part: &[(usize, &str, &Meter)],
    columns: usize,
    width: usize,
    whole: bool,
    fancy: bool,
) -> Vec<Line> {
    let rows = part.len().div_ceil(columns);
    let gap = if columns > 1 { 3 } else { 1 };
    let cell = (width.saturating_sub(1) / columns).saturating_sub(gap);
    let widest = part.iter().map(|(_, name, _)| Line::of(Ink::Plain, name).width()).max().unwrap_or(0);
    let (number_width, least) = if whole { (6, BAR[0]) } else { (0, BAR[1]) };
    let room = cell.saturating_sub(least + 1 + number_width).max(cell / 3);
    let name = widest.min(NAME).min(room);
    let bar_width = cell.saturating_sub(name + 1 + number_width);
    let mut lines = vec![Line::of(Ink::Plain, " "); rows];
    for (place, (_, text, meter)) in part.iter().enumerate() {
        let (column, Some(line)) = (place / rows, lines.get_mut(place % rows)) else { continue };
        let begin = 1 + column * (cell + gap);
        line.fill_to(begin);
        let ink = if meter.is_full() { Ink::Hot } else { Ink::Plain };
        line.join(Line::of(ink, text).shorten(name, if fancy { "…" } else { "~" }));
        line.fill_to(begin + name + 1);
        line.join(bar(meter, bar_width, fancy));
        if whole {
            line.put(Ink::Plain, " ");
            line.join(number(meter, fancy));
        }
    }
    lines
}

/// Columns for the number of a row's first channel, and meters in a row, for one sign each.
fn signs(count: usize, width: usize, rows: usize) -> (usize, usize) {
    let label = grouped(count as u64).len() + 2;
    let room = width.saturating_sub(label).max(1);
    // With a blank behind each group, if all fit then; a multiple of the group if that is possible.
    let apart = room / (TOGETHER + 1) * TOGETHER;
    let close = if room >= TOGETHER { room / TOGETHER * TOGETHER } else { room };
    let across = if apart > 0 && count.div_ceil(apart) <= rows { apart } else { close };
    (label, across)
}

fn dense(row: &[(usize, &str, &Meter)], label: usize, width: usize, fancy: bool) -> Line {
    let first = row.first().map_or(0, |(channel, ..)| channel + 1);
    let mut line = Line::of(Ink::Dim, &format!("{:>1$} ", grouped(first as u64), label.saturating_sub(1)));
    let apart = label + row.len() + row.len() / TOGETHER <= width;
    for (place, (_, _, meter)) in row.iter().enumerate() {
        if apart && place > 0 && place % TOGETHER == 0 {
            line.put(Ink::Plain, " ");
        }
        line.join(sign(meter, fancy));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::{Form, meters};
    use crate::cli::screen::meter::Meter;
    use crate::cli::screen::snapshot::Snapshot;

    fn of(count: usize) -> Snapshot {
        let tactors = (0..count).map(|n| (format!("t{}", n + 1), Meter::default())).collect();
        Snapshot { tactors, fancy: true, ..Snapshot::default() }
    }

    #[test]
    fn forms_get_denser_as_room_gets_scarce() {
        let form = |count, width, rows| Form::choose(count, width, rows, false);
        assert_eq!(form(4, 100, 12), Form::Whole(1));
        assert_eq!(form(16, 100, 12), Form::Whole(2));
        assert_eq!(form(36, 100, 12), Form::Whole(3));
        assert_eq!(form(60, 100, 12), Form::Narrow(5));
        assert_eq!(form(73, 100, 12), Form::Sign);
        assert_eq!(Form::choose(73, 100, 12, true), Form::Narrow(6));
        assert_eq!(form(1, 20, 1), Form::Narrow(1));
    }

    #[test]
    fn meters_that_rest_say_so() {
        let snapshot = Snapshot { blind: true, ..of(4) };
        assert_eq!(meters(&snapshot, 100, 12).note, "4 outputs; they rest, as there is too much to do");
        let line = |highest| super::super::lines::status(&snapshot, highest);
        assert!(line(0.0).contains("peak not measured") && line(0.5).contains("peak -6.0 dBFS"));
        assert!(super::super::lines::status(&of(4), 0.0).contains("peak silent"));
    }

    #[test]
    fn every_tactor_is_on_exactly_one_page() {
        for (count, width, rows) in [(100, 40, 5), (1024, 20, 3), (77, 300, 1), (9, 16, 2)] {
            for paged in [true, false] {
                let mut snapshot = Snapshot { paged, ..of(count) };
                let pages = meters(&snapshot, width, rows).pages;
                let (mut names, mut signs) = (Vec::new(), 0);
                for page in 0..pages {
                    snapshot.page = page;
                    let found = meters(&snapshot, width, rows);
                    assert!(found.lines.len() <= rows && found.lines.iter().all(|l| l.width() <= width));
                    assert_eq!(found.note.contains("page"), pages > 1, "{}", found.note);
                    let text: String = found.lines.iter().map(|l| l.text() + "\n").collect();
                    names.extend(text.split_whitespace().filter(|w| w.starts_with('t')).map(String::from));
                    signs += text.chars().filter(|c| *c == '·').count();
                }
                if names.is_empty() {
                    assert_eq!(signs, count);
                } else {
                    names.sort();
                    names.dedup();
                    assert_eq!(names.len(), count, "{width} {rows} {paged}");
                }
            }
        }
    }

    /// Names that differ in their ends alone, as those of arrays do.
    #[test]
    fn names_are_whole_where_there_is_room_and_told_apart_where_there_is_none() {
        let name = |n: usize| format!("left-forearm-outside-{n}");
        let tactors = (1..=16).map(|n| (name(n), Meter::default())).collect();
        let snapshot = Snapshot { tactors, fancy: true, ..Snapshot::default() };
        let text = |width, rows| {
            meters(&snapshot, width, rows).lines.iter().map(|l| l.text() + "\n").collect::<String>()
        };
        assert!((1..=16).all(|n| text(80, 24).contains(&format!(" {} ", name(n)))), "{}", text(80, 24));
        assert!((1..=16).all(|n| text(80, 4).contains(&format!("-{n} "))), "{}", text(80, 4));
        assert!(text(80, 4).lines().all(|line| line.chars().count() <= 80));
    }

    #[test]
    fn what_hangs_nowhere_is_not_shown() {
        let mut snapshot = of(3);
        snapshot.tactors[1].0.clear();
        let found = meters(&snapshot, 60, 10);
        assert_eq!((found.lines.len(), found.note.as_str()), (2, "2 outputs"));
        assert!(found.lines[1].text().starts_with(" t3 "));
        assert!(meters(&of(0), 60, 10).lines.is_empty());
    }
}
