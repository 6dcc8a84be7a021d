//! Where there is no screen: a line for each thing that happens, written by a thread of its own, for whoever reads them may be slow.

use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::happened::{Happened, clock, moment};
use super::line::{Ink, Line};
use super::snapshot::Snapshot;
use crate::cli::table::{dbfs, grouped, many};
use crate::cli::terminal::Terminal;

/// Lines that may wait to be written.
const WAITING: usize = 1 << 10;

/// So long whoever reads may take for the last ones.
const PATIENCE: Duration = Duration::from_millis(500);

/// Writes lines.
pub struct Lines {
    out: Option<SyncSender<String>>,
    thread: Option<JoinHandle<()>>,
    /// Lines that found no room and nobody was told of yet.
    lost: u64,
    /// The same of events that came too fast for lines to be made of them, and how many of them there were in all.
    missed: u64,
    known: u64,
}

impl Lines {
    /// To standard error.
    ///
    /// # Errors
    /// What the system says where it gives no thread.
    pub fn begin(terminal: Terminal) -> std::io::Result<Self> {
        let (out, lines) = sync_channel::<String>(WAITING);
        let write = move || lines.iter().for_each(|line| terminal.note(&line));
        let thread = std::thread::Builder::new().name("log".into()).spawn(write)?;
        Ok(Self { out: Some(out), thread: Some(thread), lost: 0, missed: 0, known: 0 })
    }

    /// Writes a line, now or soon.
    pub fn put(&mut self, line: &str) {
        self.tell_of_gaps();
        let sent = self.send(format!("{line}\n"));
        self.lost += u64::from(!sent);
    }

    /// So many events have come too fast by now, all in all.
    pub fn missed(&mut self, all: u64) {
        self.missed += all - std::mem::replace(&mut self.known, all).min(all);
        self.tell_of_gaps();
    }

    fn tell_of_gaps(&mut self) {
        if self.lost > 0 && self.send(format!("{} lines were left out here\n", grouped(self.lost))) {
            self.lost = 0;
        }
        let missed = || format!("{} events came too fast to be written here\n", grouped(self.missed));
        if self.missed > 0 && self.send(missed()) {
            self.missed = 0;
        }
    }

    fn send(&self, text: String) -> bool {
        self.out.as_ref().is_some_and(|out| !matches!(out.try_send(text), Err(TrySendError::Full(_))))
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        self.tell_of_gaps();
        drop(self.out.take());
        let until = Instant::now() + PATIENCE;
        while let Some(thread) = &self.thread
            && !thread.is_finished()
            && Instant::now() < until
        {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The line of an event.
pub fn event(happened: &Happened) -> String {
    let mut line = Line::of(Ink::Plain, &format!("{:>9}  ", moment(happened.at)));
    line.put(Ink::Plain, &happened.text);
    line.text()
}

/// Voices that others took the place of before they were over.
pub fn cut_short(stolen: u64) -> String {
    if stolen == 0 { String::new() } else { format!(" ({} cut short)", grouped(stolen)) }
}

/// Of what was lost, where it came from.
fn by_source(refused: &str) -> String {
    if refused.is_empty() { String::new() } else { format!(" ({refused})") }
}

/// The line that says how things stand.
pub fn status(snapshot: &Snapshot, highest: f32) -> String {
    let (figures, latency) = (&snapshot.figures, &snapshot.latency);
    format!(
        "{:>9}  -- load {:.2} % (99.9 %: {:.1} %), {}{}, {}, {} late, {} lost{}, {} limited, {} clamped{}{}, latency {}{}, peak {}{}",
        clock(snapshot.elapsed),
        100.0 * figures.mean,
        100.0 * figures.p999,
        many(figures.voices as usize, "voice"),
        cut_short(figures.stolen),
        many(figures.xruns as usize, "xrun"),
        figures.late,
        figures.lost,
        by_source(&snapshot.refused),
        figures.limited,
        figures.clamped,
        [(figures.masked, "no numbers"), (figures.held_back, "held back"), (figures.over, "over their time")]
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!(", {} {what}", grouped(count)))
            .collect::<String>(),
        match figures.midi {
            0 => String::new(),
            unused => format!(", {} of MIDI unused", grouped(unused)),
        },
        latency.told(),
        latency.input.map_or(String::new(), |input| format!(", input {:.2} ms", 1000.0 * input)),
        match snapshot.blind {
            true if highest == 0.0 => "not measured".into(),
            _ => dbfs(highest),
        },
        match (snapshot.lost, snapshot.panicked) {
            (true, _) => ", device gone",
            (_, true) => ", shut by a panic",
            _ => "",
        }
    )
}
