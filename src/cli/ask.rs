//! What somebody types, fetched without waiting for it: key by key in a terminal, and line by line where input is piped.

use super::screen::tty;
use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::io::{BufRead, IsTerminal, Read, stderr, stdin};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;

/// What somebody types. The terminal is as it was once this is dropped.
pub struct Typed {
    said: Receiver<Said>,
    /// Whether it comes key by key.
    pub keyed: bool,
}

/// What was typed since it was asked last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Said {
    /// Nothing yet.
    Nothing,
    /// A line, without blanks around it.
    Line(String),
    /// A key: a character, Enter as a line feed, and what takes the last character away as a backspace.
    Key(char),
    /// Something that means nothing here: a key that moves a cursor, or a line of such.
    Unclear,
    /// That all is to stop, where Ctrl-C is a key and no signal.
    Stop,
    /// Nobody will type anything any more.
    End,
}

/// Bytes of the longest line.
const LONGEST: u64 = 4096;

/// What may wait.
const WAITING: usize = 64;

/// So often it is looked whether the terminal was given back.
const LOOK: Duration = Duration::from_millis(50);

impl Typed {
    /// Of a person at a terminal, or of what is piped in if `piped` is wanted; `None` where there is neither.
    ///
    /// # Errors
    /// What the system says where it gives no thread.
    pub fn listen(piped: bool) -> std::io::Result<Option<Self>> {
        let person = stdin().is_terminal() && tty::is_in_front();
        let wanted = if person { stderr().is_terminal() } else { piped && !is_nothing() };
        if !wanted {
            return Ok(None);
        }
        let (say, said) = sync_channel(WAITING);
        let keyed = person && tty::take_keys().is_ok();
        // They wait for as long as the program runs, or the terminal is ours.
        let listen: Box<dyn FnOnce() + Send> = match keyed {
            true => Box::new(move || keys(&say)),
            false => Box::new(move || lines(&say)),
        };
        let typed = Self { said, keyed };
        std::thread::Builder::new().name("typed".into()).spawn(listen)?;
        Ok(Some(typed))
    }

    /// What was typed.
    pub fn said(&self) -> Said {
        self.said.try_recv().unwrap_or_else(|error| match error {
            TryRecvError::Empty => Said::Nothing,
            TryRecvError::Disconnected => Said::End,
        })
    }

    /// Forgets which keys were pressed before they were asked for; lines that are piped in were there all the time.
    pub fn forget(&self) {
        if self.keyed {
            self.said.try_iter().for_each(drop);
        }
    }
}

impl Drop for Typed {
    fn drop(&mut self) {
        if self.keyed {
            tty::give_back();
        }
    }
}

/// Whether standard input is a device that is no terminal, such as one where nothing ever comes from.
fn is_nothing() -> bool {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        use std::os::unix::fs::FileTypeExt;
        let file = stdin().as_fd().try_clone_to_owned().map(std::fs::File::from);
        file.and_then(|file| file.metadata()).map_or(true, |about| about.file_type().is_char_device())
    }
    #[cfg(not(unix))]
    {
        false
    }
}

fn keys(say: &SyncSender<Said>) {
    while tty::are_keys_taken() {
        let event =
            crossterm::event::poll(LOOK).and_then(|some| some.then(crossterm::event::read).transpose());
        match event {
            Ok(Some(Event::Key(key))) => {
                // More keys than anybody can type at once are left out.
                key_of(key).into_iter().for_each(|said| drop(say.try_send(said)));
            }
            Ok(_) => {}
            Err(_) => break,
        }
    }
}

fn key_of(key: KeyEvent) -> Option<Said> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    Some(match key.code {
        KeyCode::Char('c' | 'C') if control => Said::Stop,
        // A line feed, which terminals send for Ctrl-J, and programs for Enter.
        KeyCode::Enter => Said::Key('\n'),
        KeyCode::Char('j') if control => Said::Key('\n'),
        KeyCode::Backspace | KeyCode::Delete => Said::Key('\u{8}'),
        KeyCode::Char(c) if !control && !key.modifiers.contains(KeyModifiers::ALT) => Said::Key(c),
        _ => Said::Unclear,
    })
}

fn lines(say: &SyncSender<Said>) {
    let mut from = stdin().lock();
    while let Some(said) = next_line(&mut from) {
        if say.send(said).is_err() {
            break;
        }
    }
}

/// The next line, of which no more is kept than somebody may type; `None` at the end, or where nothing can be read any more.
fn next_line(from: &mut impl BufRead) -> Option<Said> {
    let mut line = Vec::new();
    let read = from.by_ref().take(LONGEST).read_until(b'\n', &mut line).ok()?;
    if read == 0 {
        return None;
    }
    if read as u64 == LONGEST && line.last() != Some(&b'\n') {
        from.skip_until(b'\n').ok()?;
        return Some(Said::Unclear);
    }
    let line = line.strip_suffix(b"\n").unwrap_or(&line);
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    let Ok(text) = std::str::from_utf8(line) else { return Some(Said::Unclear) };
    let plain = plain(text);
    // What was not empty does not mean what an empty line means.
    Some(if plain.is_empty() && !line.is_empty() { Said::Unclear } else { Said::Line(plain) })
}

/// Without blanks around it, and without what keys leave behind that move a cursor.
fn plain(line: &str) -> String {
    let (mut out, mut rest) = (String::new(), line.chars());
    while let Some(c) = rest.next() {
        if c == '\u{1b}' {
            // ECMA-48: a bracket, parameters, and a letter; some keys have another sign and a letter.
            if matches!(rest.next(), Some('[' | 'O')) {
                let _ = rest.find(|c| ('@'..='~').contains(c));
            }
        } else if !c.is_control() {
            out.push(c);
        }
    }
    out.trim().to_string()
}

/// A line that is typed key by key.
#[derive(Debug, Default)]
pub struct Entry(String);

/// What a key does to it.
#[derive(Debug, PartialEq, Eq)]
pub enum Edit {
    /// This is to be written.
    Echo(String),
    /// It is complete.
    Line(String),
}

impl Entry {
    /// A key was pressed.
    pub fn press(&mut self, key: char) -> Edit {
        match key {
            '\n' => return Edit::Line(std::mem::take(&mut self.0).trim().to_string()),
            '\u{8}' => {
                let columns = |text: &str| unicode_width::UnicodeWidthStr::width(text);
                let gone = self.0.pop().map_or(0, |c| columns(c.encode_utf8(&mut [0; 4])));
                return Edit::Echo("\u{8} \u{8}".repeat(gone));
            }
            c if pacinian::text::problem::is_hidden(c) => {}
            c => {
                self.0.push(c);
                return Edit::Echo(c.into());
            }
        }
        Edit::Echo(String::new())
    }
}

#[cfg(test)]
mod tests {
    use super::{Edit, Entry, LONGEST, Said, key_of, next_line, plain};
    use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

    #[test]
    fn keys_that_move_a_cursor_leave_nothing_behind() {
        for (typed, line) in [
            (" left ", "left"),
            ("\x1b[C", ""),
            ("le\x1b[1;5Dft\x1bOP", "left"),
            ("µ\t", "µ"),
            ("\x1b", ""),
            ("\x1b[", ""),
        ] {
            assert_eq!(plain(typed), line, "{typed:?}");
        }
    }

    #[test]
    fn lines_are_text_and_no_longer_than_somebody_types() {
        let long = vec![b'x'; 3 * LONGEST as usize];
        let all = [b"left\r\n\n \n\xff\xfe\n".as_slice(), &long, b"\nright"].concat();
        let mut from = all.as_slice();
        let said: Vec<_> = std::iter::from_fn(|| next_line(&mut from)).collect();
        let line = |text: &str| Said::Line(text.into());
        assert_eq!(
            said,
            [line("left"), line(""), Said::Unclear, Said::Unclear, Said::Unclear, line("right")]
        );
        let whole = [&long[..LONGEST as usize - 1], b"\n"].concat();
        assert!(matches!(next_line(&mut whole.as_slice()), Some(Said::Line(_))));
    }

    #[test]
    fn only_keys_that_say_something_say_something() {
        let of = |code, modifiers| key_of(KeyEvent::new(code, modifiers));
        let none = KeyModifiers::NONE;
        assert_eq!(of(KeyCode::Char('y'), none), Some(Said::Key('y')));
        assert_eq!(of(KeyCode::Enter, none), Some(Said::Key('\n')));
        assert_eq!(of(KeyCode::Right, none), Some(Said::Unclear));
        assert_eq!(of(KeyCode::Char('y'), KeyModifiers::ALT), Some(Said::Unclear));
        assert_eq!(of(KeyCode::Char('c'), KeyModifiers::CONTROL), Some(Said::Stop));
    }

    #[test]
    fn a_line_is_typed_and_mended() {
        let mut entry = Entry::default();
        let echoed: Vec<_> = "lw\u{8}eft\u{1b}".chars().map(|c| entry.press(c)).collect();
        assert_eq!(echoed[2], Edit::Echo("\u{8} \u{8}".into()));
        assert_eq!(echoed[6], Edit::Echo(String::new()));
        assert_eq!(entry.press('\n'), Edit::Line("left".into()));
        assert_eq!(entry.press('\u{8}'), Edit::Echo(String::new()));
        assert_eq!(entry.press('\n'), Edit::Line(String::new()));
    }
}
