//! The thread that writes a journal, so that a slow disk makes nobody wait.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::head::{Head, PlanHead};
use super::kind::Kind;
use super::line::{COLUMNS, Line};
use crate::io::error::{FileError, FileErrorKind};
use crate::io::out::OutputFile;

/// Lines that may wait to be written, and of their room what is for [rare ones](Kind::is_rare) alone.
const WAITING: usize = 1 << 18;
const FOR_RARE: usize = 1 << 12;

/// Of a session that breaks off, so much is missing at the end of its journal.
const FLUSH: Duration = Duration::from_millis(500);

/// Bytes that are written together, at the latest.
const TOGETHER: usize = 1 << 16;

/// How a journal is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A table, with what is no line of it behind `# `.
    Csv,
    /// A JSON object a line.
    JsonLines,
}

impl Form {
    /// By the ending of a file's name.
    ///
    /// # Errors
    /// Any other than `.csv`, `.jsonl` and `.ndjson`.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("jsonl" | "ndjson") => Ok(Self::JsonLines),
            _ => Err(FileError::new(
                FileErrorKind::Misuse,
                format!(
                    "`{}` does not say by its ending how events are written: name it .csv for a table or .jsonl for JSON lines",
                    path.display()
                ),
            )),
        }
    }
}

/// What is to be written.
#[derive(Debug)]
pub enum Entry {
    /// What the session is.
    Head(Box<Head>),
    /// What is played from here on.
    Plan(Box<PlanHead>),
    /// Anything else.
    Line(Box<Line>),
}

impl Entry {
    fn is_rare(&self) -> bool {
        match self {
            Self::Head(_) | Self::Plan(_) => true,
            Self::Line(line) => line.kind.is_rare(),
        }
    }
}

/// The way to the thread.
#[derive(Debug)]
pub struct Writer {
    out: Option<Sender<Entry>>,
    waiting: Arc<AtomicUsize>,
    /// What waits for the file to be made.
    entries: Option<Receiver<Entry>>,
    thread: Option<JoinHandle<Result<(), FileError>>>,
    path: PathBuf,
    form: Form,
    /// Lines that found no room since the last that did.
    lost: u64,
    lost_in_all: u64,
}

impl Writer {
    /// For a file that is made by [`Writer::open`]; until then, as much waits as there is room for.
    ///
    /// # Errors
    /// A name that does not say how it is written.
    pub fn new(path: &Path) -> Result<Self, FileError> {
        let form = Form::of(path)?;
        let (out, entries) = channel();
        Ok(Self {
            out: Some(out),
            waiting: Arc::default(),
            entries: Some(entries),
            thread: None,
            path: path.to_owned(),
            form,
            lost: 0,
            lost_in_all: 0,
        })
    }

    /// Makes the file, or empties the one that is there. Where it is open already, nothing happens.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn open(&mut self) -> Result<(), FileError> {
        let Some(entries) = self.entries.take() else { return Ok(()) };
        let file = OutputFile::create(&self.path)?;
        let (form, waiting) = (self.form, Arc::clone(&self.waiting));
        let thread = std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || write(&entries, &waiting, form, file))
            .map_err(|error| FileError::no_thread(&self.path, &error))?;
        self.thread = Some(thread);
        Ok(())
    }

    /// Has something written; what finds no room is counted, there and in the file.
    pub fn put(&mut self, entry: Entry) {
        let kept = if entry.is_rare() { 0 } else { FOR_RARE };
        // Nobody else adds to them.
        let room = (WAITING - kept).saturating_sub(self.waiting.load(Ordering::Acquire));
        // With the line that says how many are missing before it.
        if room < 1 + usize::from(self.lost > 0) {
            self.lose();
            return;
        }
        if self.lost > 0 {
            let line = Line { value: Some(self.lost as f64), ..Line::new(Kind::Lost) };
            if self.send(Entry::Line(Box::new(line))) {
                self.lost = 0;
            }
        }
        if !self.send(entry) {
            self.lose();
        }
    }

    fn lose(&mut self) {
        self.lost += 1;
        self.lost_in_all += 1;
    }

    /// Says whether anybody writes any more.
    fn send(&self, entry: Entry) -> bool {
        self.waiting.fetch_add(1, Ordering::AcqRel);
        self.out.as_ref().is_some_and(|out| out.send(entry).is_ok())
    }

    /// Whether the thread has given up; it says why when it is asked to finish.
    pub fn has_failed(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Writes what waits. Gives how many lines were lost.
    ///
    /// # Errors
    /// What went wrong with the file.
    pub fn finish(&mut self) -> Result<u64, FileError> {
        drop(self.out.take());
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(written)) => written.map(|()| self.lost_in_all),
            None => Ok(self.lost_in_all),
            Some(Err(_)) => Err(FileError::new(
                FileErrorKind::Io,
                format!("the thread that wrote `{}` has failed: what it held is lost", self.path.display()),
            )),
        }
    }
}

fn write(
    entries: &Receiver<Entry>,
    waiting: &AtomicUsize,
    form: Form,
    mut file: OutputFile,
) -> Result<(), FileError> {
    let path = file.path().to_owned();
    let failed = |error: std::io::Error| FileError::writing(&path, &error);
    let mut flushed = Instant::now();
    let mut headed = false;
    let mut lines = Vec::with_capacity(2 * TOGETHER);
    loop {
        let (mut ended, mut at_once) = (false, false);
        match entries.recv_timeout(FLUSH.saturating_sub(flushed.elapsed())) {
            Ok(entry) => {
                waiting.fetch_sub(1, Ordering::AcqRel);
                // Without what is played, nothing that comes later is of use to a replay.
                at_once = !matches!(entry, Entry::Line(_));
                if !std::mem::replace(&mut headed, true) && form == Form::Csv {
                    // Before the column names, so that whoever reads the first line knows what the file is.
                    match entry {
                        Entry::Head(head) => note(form, "session", &head, &mut lines),
                        other => put(form, other, &mut lines),
                    }
                    lines.extend_from_slice(COLUMNS.join(",").as_bytes());
                    lines.push(b'\n');
                } else {
                    put(form, entry, &mut lines);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => ended = true,
        }
        if ended || at_once || lines.len() >= TOGETHER || flushed.elapsed() >= FLUSH {
            flushed = Instant::now();
            file.write_all(&lines).map_err(failed)?;
            lines.clear();
        }
        if ended {
            return file.flush().map_err(failed);
        }
    }
}

fn put(form: Form, entry: Entry, to: &mut Vec<u8>) {
    match entry {
        Entry::Head(head) => note(form, "session", &head, to),
        Entry::Plan(head) => note(form, "plan", &head, to),
        Entry::Line(line) => match form {
            Form::JsonLines => {
                // Every value has a form in JSON.
                let _ = serde_json::to_writer(&mut *to, &line);
                to.push(b'\n');
            }
            Form::Csv => {
                // What has a `#` in it is put in quotes, in which it begins no comment.
                let mut table = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(&mut *to);
                let _ = table.write_record(line.cells());
            }
        },
    }
}

/// What is no line of the table: the same object in both forms.
fn note(form: Form, kind: &str, head: &impl Serialize, to: &mut Vec<u8>) {
    #[derive(Serialize)]
    struct Note<'a, T> {
        kind: &'a str,
        #[serde(flatten)]
        head: &'a T,
    }
    if form == Form::Csv {
        to.extend_from_slice(b"# ");
    }
    let _ = serde_json::to_writer(&mut *to, &Note { kind, head });
    to.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::{Entry, Form, WAITING, Writer, put};
    use crate::io::journal::kind::Kind;
    use crate::io::journal::line::{COLUMNS, Line};

    /// Nobody writes yet: lines of every kind come, far more than there is room for.
    #[test]
    fn a_flood_of_events_leaves_room_for_the_gate() {
        let path = std::env::temp_dir().join(format!("pacinian-flood-{}.jsonl", std::process::id()));
        let mut writer = Writer::new(&path).unwrap();
        let line =
            |kind, number: usize| Entry::Line(Box::new(Line { id: Some(number as u64), ..Line::new(kind) }));
        for n in 0..WAITING + 1000 {
            writer.put(line(Kind::In, n));
            // As the flood comes to its end.
            if n > WAITING && n % 100 == 0 {
                writer.put(line(Kind::Gate, n));
            }
        }
        writer.open().unwrap();
        let lost = writer.finish().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let count = |kind: &str| text.lines().filter(|l| l.contains(&format!("\"kind\":\"{kind}\""))).count();
        assert_eq!((count("in") as u64 + lost, count("gate")), ((WAITING + 1000) as u64, 10));
        // What is missing is told where it is, but for what came after the last.
        let told = text.lines().filter(|l| l.contains("\"kind\":\"lost\"")).map(|l| {
            let line: Line = serde_json::from_str(l).unwrap();
            line.value.unwrap() as u64
        });
        assert!(told.sum::<u64>() + 100 > lost && lost > 0);
    }

    /// The cells of a line as `pandas.read_csv(..., comment="#")` finds them: outside quotes a `#` ends the line.
    fn read(line: &str) -> Vec<String> {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        let mut letters = line.chars().peekable();
        while let Some(letter) = letters.next() {
            match letter {
                '"' if quoted && letters.peek() == Some(&'"') => {
                    cells.last_mut().unwrap().extend(letters.next())
                }
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                '#' if !quoted => return cells,
                '\n' if !quoted => return cells,
                letter => cells.last_mut().unwrap().push(letter),
            }
        }
        cells
    }

    #[test]
    fn no_name_begins_a_comment() {
        for name in ["trial #1", "#", "say \"#\"", "a,#b", "plain"] {
            let line = Line { name: Some(name.into()), utc: Some("2026".into()), ..Line::new(Kind::Marker) };
            let mut bytes = Vec::new();
            put(Form::Csv, Entry::Line(Box::new(line.clone())), &mut bytes);
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(read(&text), line.cells(), "{text}");
            assert_eq!(read(&text).len(), COLUMNS.len());
        }
    }
}
