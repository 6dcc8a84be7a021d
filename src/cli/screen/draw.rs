//! From a snapshot to the lines of the screen.

use super::dial::dial;
use super::fold::folded;
use super::happened::{Happened, Mood, moment};
use super::head::{figures, title};
use super::line::{Ink, Line, flow};
use super::meters::meters;
use super::panel::{panel, rows, wrong};
use super::snapshot::{KeyFace, Snapshot};
use crate::cli::table::{grouped, many};

/// What is written in large letters while the output is shut.
const PANIC: [&str; 5] = [
    "#####   ####  ##  ## ######  ####",
    "##  ## ##  ## ### ##   ##   ##  ##",
    "#####  ###### ######   ##   ##",
    "##     ##  ## ## ###   ##   ##  ##",
    "##     ##  ## ##  ## ######  ####",
];

/// The same in a line.
const SHUT: &str = " PANIC: the output is shut; c opens it again ";

/// What was saved last cannot be played.
const STALE: &str = " THE OLD ONE PLAYS ON ";

/// A screen.
pub struct Drawn {
    /// As many as the screen has, none of them wider.
    pub lines: Vec<Line>,
    /// Pages of the meters.
    pub pages: usize,
}

/// Draws a screen of `width` by `height`.
pub fn draw(snapshot: &Snapshot, width: usize, height: usize) -> Drawn {
    let mark = if snapshot.fancy { "…" } else { "~" };
    let mut top = Vec::new();
    let mut foot = Vec::new();
    if snapshot.panicked {
        let mut line = Line::of(Ink::Alarm, SHUT).clip(width, mark);
        line.fill_with(Ink::Alarm, ' ', width);
        top.push(line);
    }
    if height >= 3 {
        top.push(title(snapshot, width));
    }
    if let Some(why) = snapshot.stale.as_ref().filter(|_| height >= 4) {
        let mut line = Line::of(Ink::Alarm, STALE);
        line.put(Ink::Hot, &format!(" {why}"));
        top.push(line);
    }
    if height >= 5 {
        foot.push(help(snapshot, width));
    }
    let most = match height {
        0..6 => 0,
        6..10 => 1,
        10..16 => 2,
        _ => 4,
    };
    top.extend(flow(figures(snapshot, width), width).into_iter().take(most));
    if let Some(knob) = snapshot.knob.as_ref().filter(|_| height >= 10) {
        top.push(dial(knob, width, snapshot.fancy));
    }
    if height >= 8 {
        let more = (snapshot.keyless > 0)
            .then(|| Line::of(Ink::Dim, &format!("and {} without a key", many(snapshot.keyless, "pattern"))));
        let faces = snapshot.keys.iter().map(|key| face(key, snapshot.fancy));
        let mut keys = flow(faces.chain(more), width);
        keys.truncate(if height >= 16 { 3 } else { 1 });
        keys.extend(foot);
        foot = keys;
    }
    let mut rest = height.saturating_sub(top.len() + foot.len());
    if snapshot.panicked && rest >= PANIC.len() + 9 && width >= 40 {
        let banner = banner(snapshot, width);
        rest -= banner.len();
        top.extend(banner);
    }

    // A heading for the meters, and one for the events where both have room.
    let headed = rest >= 4;
    rest -= usize::from(headed);
    // What is wrong is what somebody looks for now; the controls take what is left, and the events what nobody else wants.
    let wrong = wrong(snapshot, width);
    let for_wrong = if rest >= 8 && !wrong.is_empty() { (wrong.len() + 1).min(rest / 2) } else { 0 };
    let for_controls = match rest - for_wrong {
        room @ 8.. if !snapshot.controls.is_empty() => (rows(snapshot, width) + 1).min((room / 4).max(2)),
        _ => 0,
    };
    let rest_of_all = rest - for_wrong - for_controls;
    let for_events = if rest_of_all >= 6 { (rest_of_all / 4).clamp(4, 8) } else { 0 };
    let meters = meters(snapshot, width, rest_of_all - for_events);
    if headed {
        top.push(heading(&meters.note, width, snapshot.fancy));
    }
    rest = rest.saturating_sub(meters.lines.len() + for_controls);
    top.extend(meters.lines);
    if for_wrong > 0 {
        // All of it where few tactors leave room, but for the latest events.
        let room = (wrong.len() + 1).min(rest.saturating_sub(for_events.min(3))).max(for_wrong);
        top.push(heading("what was saved last is not played", width, snapshot.fancy));
        top.extend(cut(wrong, room - 1));
        rest = rest.saturating_sub(room);
    }
    if for_controls > 0 {
        let (lines, note) = panel(snapshot, width, for_controls - 1);
        top.push(heading(&note, width, snapshot.fancy));
        rest += for_controls - 1 - lines.len();
        top.extend(lines);
    }
    if rest >= 2 && for_events > 0 {
        let note = match snapshot.missed {
            0 => "events".to_string(),
            missed => format!("events ({} more came too fast to be shown)", grouped(missed)),
        };
        top.push(heading(&note, width, snapshot.fancy));
        rest -= 1;
    }
    if for_events > 0 || headed {
        top.extend(events(&snapshot.events, width, rest));
    }
    top.truncate(height.saturating_sub(foot.len()));
    top.resize(height.saturating_sub(foot.len()), Line::default());
    top.extend(foot);
    top.truncate(height);
    Drawn { lines: top.into_iter().map(|line| line.clip(width, mark)).collect(), pages: meters.pages }
}

/// A key that plays something.
fn face(key: &KeyFace, fancy: bool) -> Line {
    let mut line = Line::of(Ink::Accent, &key.digit.to_string());
    let sign = match (key.playing, key.trigger, fancy) {
        (true, _, true) => " ▶ ",
        (true, _, false) => " > ",
        (_, true, _) => " ! ",
        _ => " ",
    };
    line.put(Ink::Good, sign);
    let name = Line::of(if key.playing { Ink::Bold } else { Ink::Plain }, &key.name);
    line.join(name.clip(24, if fancy { "…" } else { "~" }));
    line
}

/// What the keys do; in a narrow terminal, the most important of it.
fn help(snapshot: &Snapshot, width: usize) -> Line {
    let panic = if snapshot.panicked { ("c", "opens") } else { ("p", "panic") };
    let arm = if snapshot.armed { "-20 dB" } else { "arm" };
    let mut items = vec![panic, ("q", "end"), ("space", "all patterns"), ("a", arm)];
    if let Some(wanted) = snapshot.torque {
        items.push(("t", if wanted { "no torque" } else { "torque" }));
    }
    if !snapshot.controls.is_empty() {
        items.extend([("Tab", "control"), ("arrows", "move"), ("0", "reset")]);
    }
    if snapshot.keys.iter().all(|key| key.trigger) && snapshot.keyless == 0 {
        items.retain(|(key, _)| *key != "space");
    }
    let plays = if snapshot.keys.iter().any(|key| key.trigger) { "play" } else { "pattern" };
    let digits = digits(snapshot.keys.iter().map(|key| key.digit));
    if !digits.is_empty() {
        items.insert(2, (&digits, plays));
    }
    let mut line = Line::of(Ink::Plain, " ");
    for (key, does) in items {
        let mut item = Line::of(Ink::Accent, key);
        item.put(Ink::Dim, &format!(" {does}"));
        let gap = if line.width() > 1 { 3 } else { 0 };
        if line.width() + gap + item.width() > width {
            break;
        }
        line.fill_to(line.width() + gap);
        line.join(item);
    }
    line
}

/// Digits that ascend, those that follow on one another together: `1-3,5`.
fn digits(all: impl Iterator<Item = u32>) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for digit in all {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == digit => *last = digit,
            _ => runs.push((digit, digit)),
        }
    }
    let word = |(first, last)| if first == last { format!("{first}") } else { format!("{first}-{last}") };
    runs.into_iter().map(word).collect::<Vec<_>>().join(",")
}

/// So many lines of it, the last of which says how many there are more.
fn cut(mut lines: Vec<Line>, rows: usize) -> Vec<Line> {
    if lines.len() > rows {
        let more = lines.len() - rows + 1;
        lines.truncate(rows.saturating_sub(1));
        if rows > 0 {
            lines.push(Line::of(Ink::Dim, &format!(" and {more} lines more, which are written at the end")));
        }
    }
    lines
}

fn heading(text: &str, width: usize, fancy: bool) -> Line {
    let rule = if fancy { '─' } else { '-' };
    let mut line = Line::default();
    line.fill_with(Ink::Dim, rule, 2);
    line.put(Ink::Dim, &format!(" {text} "));
    line.fill_with(Ink::Dim, rule, width);
    line
}

/// Rows that one event takes at most.
const ROWS: usize = 4;

/// The last events, the latest at the foot.
fn events(all: &[Happened], width: usize, rows: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    for event in all.iter().rev() {
        let room = (rows - lines.len()).min(ROWS);
        if room == 0 {
            break;
        }
        lines.extend(told(event, width, room).into_iter().rev());
    }
    lines.reverse();
    lines
}

/// An event in so many rows at most. What is more than usual, and may say what to do, is folded.
fn told(event: &Happened, width: usize, rows: usize) -> Vec<Line> {
    let (ink, rows) = match event.mood {
        Mood::Usual => (Ink::Plain, 1),
        Mood::Told => (Ink::Accent, rows),
        Mood::Good => (Ink::Good, rows),
        Mood::Bad => (Ink::Hot, rows),
    };
    let mut begin = Line::of(Ink::Dim, &format!(" {:>9}  ", moment(event.at)));
    let column = begin.width();
    let mut parts = folded(&event.told(), width.saturating_sub(column).max(1), 0, ink).into_iter();
    let mut lines = Vec::new();
    while let Some(part) = parts.next() {
        begin.join(part);
        if lines.len() + 1 == rows {
            // What there is no row for is cut off at the end of the last one.
            parts.by_ref().for_each(|rest| {
                begin.put(ink, " ");
                begin.join(rest);
            });
        }
        lines.push(std::mem::take(&mut begin));
        begin.fill_to(column);
    }
    lines
}

fn banner(snapshot: &Snapshot, width: usize) -> Vec<Line> {
    let wide = PANIC.iter().map(|row| row.len()).max().unwrap_or(0);
    let begin = width.saturating_sub(wide) / 2;
    let mut lines = vec![Line::default()];
    for row in PANIC {
        let mut line = Line::default();
        line.fill_to(begin);
        let sign = if snapshot.fancy { "█" } else { "#" };
        line.put(Ink::Hot, &row.replace('#', sign));
        lines.push(line);
    }
    lines.push(Line::default());
    lines
}

#[cfg(test)]
mod tests {
    use super::{SHUT, STALE, digits, draw};
    use crate::cli::screen::controls::ControlFace;
    use crate::cli::screen::happened::{Happened, Mood};
    use crate::cli::screen::line::Ink;
    use crate::cli::screen::meter::Meter;
    use crate::cli::screen::snapshot::{Figures, KeyFace, Latency, Snapshot};

    #[test]
    fn no_key_is_offered_that_plays_nothing() {
        let shown = |all: &[u32]| digits(all.iter().copied());
        assert_eq!(shown(&[1, 2, 3, 5, 7, 8]), "1-3,5,7-8");
        assert_eq!((shown(&[3]), shown(&[]), shown(&[1, 2])), ("3".into(), String::new(), "1-2".into()));
    }

    fn scene(tactors: usize, name: impl Fn(usize) -> String) -> Snapshot {
        let mut meter = Meter::default();
        meter.hear(0.3, 0.05);
        Snapshot {
            title: name(0),
            device: "USB Sound".into(),
            rate: 48_000,
            elapsed: 75.0,
            armed: true,
            figures: Figures { mean: 0.0021, p999: 0.012, voices: 3, ..Figures::default() },
            latency: Latency { block: 0.0027, engine: 0.0015, device: Some(0.001), ..Latency::default() },
            tactors: (0..tactors).map(|n| (name(n), meter)).collect(),
            keys: (1..=9)
                .map(|digit| KeyFace {
                    digit,
                    name: name(digit as usize),
                    playing: digit == 2,
                    trigger: false,
                })
                .collect(),
            events: (0..50).map(|n| Happened::new(f64::from(n), Mood::Usual, name(n as usize))).collect(),
            fancy: true,
            ..Snapshot::default()
        }
    }

    fn text(snapshot: &Snapshot, width: usize, height: usize) -> String {
        draw(snapshot, width, height)
            .lines
            .iter()
            .map(|line| line.text().trim_end().to_string() + "\n")
            .collect()
    }

    #[test]
    fn no_size_and_no_name_breaks_the_frame() {
        let names: [&dyn Fn(usize) -> String; 4] = [
            &|n| format!("t{n}"),
            &|n| format!("手首の右側にある{n}番目の振動子"),
            &|n| format!("a\x1b[31m\n\r\t\u{202e}{n}{}", "x".repeat(500)),
            &|n| format!("e\u{301}\u{200d}\u{1f9e0}{n}"),
        ];
        for name in names {
            for tactors in [0, 1, 2, 7, 16, 64, 300, 1024] {
                let mut snapshot = scene(tactors, name);
                for (width, height) in [
                    (1, 1),
                    (2, 3),
                    (20, 5),
                    (20, 6),
                    (33, 9),
                    (80, 24),
                    (100, 30),
                    (300, 90),
                    (300, 6),
                    (20, 100),
                    (0, 9),
                    (9, 0),
                ] {
                    // Of many tactors, one state in five.
                    for state in (0..16).step_by(if tactors > 16 { 5 } else { 1 }) {
                        (snapshot.panicked, snapshot.fancy, snapshot.paged) =
                            (state & 1 > 0, state & 2 > 0, state & 4 > 0);
                        snapshot.stale = (state & 8 > 0).then(|| name(1));
                        let faces = || ControlFace { name: name(2), unit: name(3), ..ControlFace::default() };
                        snapshot.controls = (0..state & 3).map(|_| faces()).collect();
                        snapshot.wrong = snapshot.stale.iter().cloned().collect();
                        let lines = draw(&snapshot, width, height).lines;
                        assert_eq!(lines.len(), height);
                        for line in lines {
                            assert!(line.width() <= width, "{width} x {height}: {}", line.text());
                            assert!(!line.text().contains(char::is_control));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn everything_is_there() {
        let mut snapshot = scene(16, |n| format!("t{n}"));
        (snapshot.figures.xruns, snapshot.keyless) = (1234, 3);
        snapshot.events.push(Happened { again: 2, ..Happened::new(3.0, Mood::Bad, "no such voice") });
        let text = text(&snapshot, 100, 30);
        for part in [
            "USB Sound, 48,000 Hz, 16 ch",
            "1:15  ARMED",
            "load 0.21 %, p99.9 1.2 %",
            "voices 3",
            "xruns 1,234",
            "late 0",
            "lost 0",
            "latency 5.20 ms = block 2.70 + engine 1.50 + device 1.00",
            "limited 0",
            "clamped 0",
            "16 outputs",
            " t15 ",
            "-10.5",
            "2 ▶ t2",
            "and 3 patterns without a key",
            "0:03.000  no such voice (x 3)",
            "p panic   q end   1-9 pattern   space all patterns   a -20 dB",
        ] {
            assert!(text.contains(part), "no `{part}` in\n{text}");
        }
        assert!(!text.contains("control") && !text.contains("over time") && !text.contains("at least"));
        snapshot.latency.device = None;
        assert!(
            self::text(&snapshot, 100, 30)
                .contains("latency at least 4.20 ms = block 2.70 + engine 1.50 + device unknown")
        );
    }

    #[test]
    fn controls_are_there_where_there_is_room() {
        let mut snapshot = scene(16, |n| format!("t{n}"));
        snapshot.controls = (0..3)
            .map(|n| ControlFace {
                name: format!("knob-{n}"),
                value: 0.25,
                position: 0.25,
                chosen: n == 1,
                ..ControlFace::default()
            })
            .collect();
        let large = text(&snapshot, 100, 30);
        for part in
            ["›knob-1", "knob-0", "knob-2", "0.25", "t15", "0:49.000", "Tab control   arrows move   0 reset"]
        {
            assert!(large.contains(part), "no `{part}` in\n{large}");
        }
        let small = text(&snapshot, 60, 12);
        assert!(!small.contains("knob") && small.contains("16 outputs"), "{small}");
    }

    /// All of it, wrapped; and what is cut off is counted.
    #[test]
    fn everything_that_is_wrong_with_what_was_saved_is_read() {
        let mut snapshot = scene(4, |n| format!("t{n}"));
        snapshot.stale = Some("p.toml:9: first (and 1 more)".into());
        let long = "p.toml:9:14: error: ".to_string() + &"word ".repeat(30) + "last";
        snapshot.wrong =
            vec![long, "  help: did you mean `sine`?".into(), "p.toml:12:3: error: second".into()];
        let shown = text(&snapshot, 80, 30);
        for part in [
            "p.toml:9:14: error: word",
            "word last",
            "     help: did you mean `sine`?",
            "p.toml:12:3: error: second",
            "0:49.000",
        ] {
            assert!(shown.contains(part), "no `{part}` in\n{shown}");
        }
        snapshot.wrong = (0..100).map(|n| format!("p.toml:{n}: error")).collect();
        let shown = text(&snapshot, 80, 24);
        let more = shown.lines().find(|line| line.contains("lines more")).unwrap();
        let seen = shown.matches(": error").count();
        assert!(seen >= 3 && more.contains(&format!("and {} lines more", 100 - seen)), "{shown}");
        assert!(shown.contains("t3 "), "{shown}");
    }

    #[test]
    fn what_matters_most_survives_the_smallest_screen() {
        let mut snapshot = scene(16, |n| format!("a rather long name {n}"));
        snapshot.panicked = true;
        for (width, height) in [(20, 1), (20, 5), (20, 6), (60, 12), (100, 30)] {
            let text = text(&snapshot, width, height);
            assert!(text.starts_with(SHUT[..17].trim_end()), "{text}");
            assert!(
                height < 5 || text.trim_end().lines().last().unwrap().starts_with(" c opens   q"),
                "{text}"
            );
        }
        // The large letters, where there is room.
        assert!(text(&snapshot, 100, 30).contains("█████   ████"));
        assert!(!text(&snapshot, 100, 14).contains("█████   ████"));
        // What is wrong with what was saved is at the top, and its line is seen.
        snapshot.panicked = false;
        snapshot.stale = Some(format!("hum.toml:12: {}", "x".repeat(500)));
        for (width, height) in [(60, 5), (60, 12), (100, 30)] {
            let text = text(&snapshot, width, height);
            assert!(text.lines().nth(1).unwrap().starts_with(&format!("{STALE} hum.toml:12: xxx")), "{text}");
        }
        // The state is seen though the name of the patch is too long.
        snapshot.panicked = false;
        (snapshot.armed, snapshot.title) = (false, "x".repeat(500));
        assert!(text(&snapshot, 40, 10).lines().next().unwrap().ends_with("1:15  -20 dB"));
        snapshot.lost = true;
        let first = draw(&snapshot, 40, 10).lines.remove(0);
        assert_eq!(first.pieces().last().unwrap(), &(Ink::Alarm, " DEVICE GONE ".to_string()));
    }

    #[test]
    fn the_latest_event_is_shown_and_those_that_are_not_are_counted() {
        let mut snapshot = scene(1000, |n| format!("t{n}"));
        snapshot.missed = 4321;
        for height in [16, 24, 40] {
            let text = text(&snapshot, 100, height);
            assert!(text.contains("0:49.000  t49"), "{height}: {text}");
            assert!(text.contains("4,321 more"));
        }
    }

    /// What went wrong, with what helps, whole where that takes four rows; what is usual takes one.
    #[test]
    fn what_says_what_to_do_is_read_to_its_end() {
        let mut snapshot = scene(2, |n| format!("t{n} {}", "usual ".repeat(40)));
        let long = "the card is gone: ".to_string() + &"why ".repeat(30) + "--block 512 helps";
        snapshot.events.push(Happened::new(50.0, Mood::Bad, long.as_str()));
        snapshot.events.push(Happened::new(51.0, Mood::Usual, "last"));
        let shown = text(&snapshot, 80, 24);
        let lines: Vec<_> = shown.lines().map(str::trim_end).collect();
        let first =
            lines.iter().position(|line| line.starts_with("  0:50.000  the card is gone: why")).unwrap();
        let after = lines.iter().position(|line| *line == "  0:51.000  last").unwrap();
        assert_eq!(after - first, 3, "{shown}");
        let whole: String = lines[first..after].iter().map(|line| line[12..].to_string() + " ").collect();
        assert_eq!(whole.trim_end(), long);
        assert!(lines[first - 1].starts_with("  0:49.000  t49 usual") && lines[first - 1].ends_with('…'));
        // What is longer than that says that it goes on.
        snapshot.events[50].text = "word ".repeat(200);
        let shown = text(&snapshot, 80, 24);
        let words = shown.lines().filter(|line| line.trim_start().starts_with("word"));
        assert!(
            words.count() == 3 && shown.lines().any(|line| line.contains("word wo") && line.ends_with('…'))
        );
    }

    #[test]
    fn where_there_is_only_ascii_there_is_only_ascii() {
        let mut snapshot = scene(16, |n| format!("t{n}"));
        snapshot.fancy = false;
        for panicked in [false, true] {
            snapshot.panicked = panicked;
            for (width, height) in [(20, 6), (100, 30)] {
                assert!(text(&snapshot, width, height).is_ascii());
            }
        }
    }
}
