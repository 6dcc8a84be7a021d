//! The terminal: taken over for the screen, and given back whatever happens.

use std::io::{IsTerminal, Write, stderr, stdin, stdout};
use std::sync::atomic::{AtomicBool, Ordering};

use super::line::Line;
use crate::cli::terminal::Terminal;

/// Columns and rows below which there is no screen.
const LEAST: (u16, u16) = (20, 6);

/// To another page than that of the shell, whose cursor and whose folding of long lines are not wanted there.
const ENTER: &str = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J";
const LEAVE: &str = "\x1b[?2026l\x1b[0m\x1b[?7h\x1b[?25h\x1b[?1049l";

/// From here on the terminal shows nothing until everything is written, if it knows how.
const HOLD: &str = "\x1b[?2026h";
const SHOW: &str = "\x1b[?2026l";

static TAKEN: AtomicBool = AtomicBool::new(false);
static KEYS: AtomicBool = AtomicBool::new(false);

/// Whether there can be a screen: keys come from a terminal, both outputs go to it, it can move its cursor, it is not too small, and
/// nobody wants plain lines.
pub fn is_fit(terminal: &Terminal) -> bool {
    let plain = !terminal.pictured;
    let fits = || size().is_some_and(|(width, height)| width >= LEAST.0 && height >= LEAST.1);
    !plain && terminal.lively && stdin().is_terminal() && stdout().is_terminal() && is_in_front() && fits()
}

/// Whether keys of the terminal are this program's: one in the background is stopped as soon as it asks for them.
pub fn is_in_front() -> bool {
    // Of a terminal that is not the one it was begun at, the system says nothing, and stops nobody.
    #[cfg(unix)]
    return rustix::termios::tcgetpgrp(stdin()).map_or(true, |front| front == rustix::process::getpgrp());
    #[cfg(not(unix))]
    true
}

/// Waits until the terminal is gone, and says so; `false` where it was given back before.
#[cfg(unix)]
pub fn hangs_up() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 250_000_000 };
    while is_taken() {
        let input = stdin();
        // What is asked for is nothing: that it has hung up is told all the same.
        let mut keys = [PollFd::new(&input, PollFlags::empty())];
        if matches!(poll(&mut keys, Some(&LOOK)), Ok(1..)) {
            return is_taken();
        }
    }
    false
}

/// Which of the program's outputs were a terminal's when it began. Not everybody who has one hears by a signal that it is gone: in another
/// group of processes, say. Whoever has sent both elsewhere does not need it.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(unix), expect(dead_code, reason = "nobody says what becomes of a terminal"))]
pub struct Held([bool; 2]);

impl Held {
    /// As it is now.
    pub fn now() -> Self {
        Self([stdout().is_terminal(), stderr().is_terminal()])
    }

    /// Whether a terminal of these is gone.
    #[cfg(unix)]
    pub fn is_gone(self) -> bool {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        use std::os::fd::AsFd;
        let (out, err) = (stdout(), stderr());
        let all = [out.as_fd(), err.as_fd()].into_iter().zip(self.0);
        let hung_up = |mut stream: PollFd<'_>| {
            let told = poll(std::slice::from_mut(&mut stream), Some(&Timespec::default()));
            told.is_ok() && stream.revents().contains(PollFlags::HUP)
        };
        all.filter(|(_, held)| *held)
            .any(|(stream, _)| hung_up(PollFd::from_borrowed_fd(stream, PollFlags::empty())))
    }

    /// Nobody says.
    #[cfg(not(unix))]
    pub fn is_gone(self) -> bool {
        false
    }
}

/// Columns and rows, where the terminal says.
pub fn size() -> Option<(u16, u16)> {
    crossterm::terminal::size().ok().filter(|(width, height)| *width > 0 && *height > 0)
}

/// Whether the terminal shows more than ASCII, as far as the surroundings tell.
pub fn is_fancy(lookup: impl Fn(&str) -> Option<String>) -> bool {
    if !cfg!(unix) {
        return true;
    }
    let locale =
        ["LC_ALL", "LC_CTYPE", "LANG"].iter().find_map(|name| lookup(name).filter(|v| !v.is_empty()));
    let locale = locale.unwrap_or_default().to_lowercase();
    lookup("TERM").as_deref() != Some("linux") && (locale.contains("utf-8") || locale.contains("utf8"))
}

/// Takes the terminal over.
///
/// # Errors
/// What the system says.
pub fn take() -> std::io::Result<()> {
    // Older Windows must be asked to understand escape sequences.
    #[cfg(windows)]
    if !crossterm::ansi_support::supports_ansi() {
        return Err(std::io::ErrorKind::Unsupported.into());
    }
    crossterm::terminal::enable_raw_mode()?;
    TAKEN.store(true, Ordering::SeqCst);
    let mut out = stdout().lock();
    out.write_all(ENTER.as_bytes()).and_then(|()| out.flush()).inspect_err(|_| give_back())
}

/// Lets keys through one by one, without an echo, and leaves the terminal as it is otherwise: lines are written as ever, and Ctrl-C is
/// a signal where there are such.
///
/// # Errors
/// What the system says.
pub fn take_keys() -> std::io::Result<()> {
    crossterm::terminal::enable_raw_mode()?;
    KEYS.store(true, Ordering::SeqCst);
    #[cfg(unix)]
    {
        use rustix::termios::{LocalModes, OptionalActions, OutputModes, tcgetattr, tcsetattr};
        let as_usual = || {
            let mut modes = tcgetattr(stdin())?;
            modes.output_modes |= OutputModes::OPOST;
            modes.local_modes |= LocalModes::ISIG;
            tcsetattr(stdin(), OptionalActions::Now, &modes)
        };
        as_usual().inspect_err(|_| give_back())?;
    }
    Ok(())
}

/// Whether keys come one by one.
pub fn are_keys_taken() -> bool {
    KEYS.load(Ordering::SeqCst)
}

/// Gives the terminal back, if it was taken; from any thread, a panicking one too.
pub fn give_back() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        // Not on standard output, which another thread may hold and never let go of.
        let mut err = stderr();
        let _ = err.write_all(LEAVE.as_bytes()).and_then(|()| err.flush());
        let _ = crossterm::terminal::disable_raw_mode();
    }
    if KEYS.swap(false, Ordering::SeqCst) {
        let _ = crossterm::terminal::disable_raw_mode();
    }
}

/// Whether the terminal is still ours.
pub fn is_taken() -> bool {
    TAKEN.load(Ordering::SeqCst)
}

/// Knows what the terminal shows, and writes what is new.
#[derive(Debug, Default)]
pub struct Painter {
    shown: Vec<String>,
    size: (usize, usize),
    colours: bool,
}

impl Painter {
    /// In colours, or not.
    pub fn new(colours: bool) -> Self {
        Self { colours, ..Self::default() }
    }

    /// Everything is to be written again.
    pub fn forget(&mut self) {
        self.size = (0, 0);
    }

    /// What to write so that a terminal of that size shows these lines.
    pub fn frame(&mut self, lines: &[Line], width: usize, height: usize) -> String {
        let mut out = String::from(HOLD);
        if self.size != (width, height) {
            self.size = (width, height);
            self.shown.clear();
            out += "\x1b[0m\x1b[2J";
        }
        self.shown.resize(lines.len(), String::new());
        for (row, (line, shown)) in lines.iter().zip(&mut self.shown).enumerate() {
            let text = line.ansi(self.colours);
            if *shown == text {
                continue;
            }
            out += &format!("\x1b[{};1H{text}", row + 1);
            // In the last column, the cursor stays on the last character.
            if line.width() < width {
                out += "\x1b[K";
            }
            *shown = text;
        }
        out + SHOW
    }
}

#[cfg(test)]
mod tests {
    use super::{ENTER, LEAVE, Painter, is_fancy};
    use crate::cli::screen::line::{Ink, Line};
    use std::num::NonZero;

    fn lines(texts: &[&str]) -> Vec<Line> {
        texts.iter().map(|text| Line::of(Ink::Bold, text)).collect()
    }

    #[test]
    fn the_terminal_shows_what_was_drawn_last() {
        let some = |n| NonZero::new(n).unwrap();
        let mut terminal = vt100::Parser::new(some(3), some(10), 0);
        terminal.process(b"before");
        terminal.process(ENTER.as_bytes());
        let mut painter = Painter::new(true);
        let frames = [
            ["first", "0123456789", "手首"],
            ["fir", "9876543210", "手首"],
            ["", "987654321", "e\u{301}"],
            ["", "", "0123456789"],
        ];
        for frame in frames {
            terminal.process(painter.frame(&lines(&frame), 10, 3).as_bytes());
            let shown = frame.join("\n");
            assert_eq!(terminal.screen().contents().trim_end(), shown.trim_end());
        }
        // Another size, and whatever else stood there.
        terminal.screen_mut().set_size(some(2), some(7));
        terminal.process(b"\x1b[1;1Hxxxxxxxxxxx");
        terminal.process(painter.frame(&lines(&["abc", "1234567"]), 7, 2).as_bytes());
        assert_eq!(terminal.screen().contents(), "abc\n1234567");
        assert!(terminal.screen().hide_cursor() && terminal.screen().alternate_screen());
        terminal.process(LEAVE.as_bytes());
        assert!(!terminal.screen().hide_cursor() && !terminal.screen().alternate_screen());
        assert_eq!(terminal.screen().contents(), "before");
    }

    #[test]
    fn what_stays_is_not_written_again() {
        let mut painter = Painter::new(true);
        painter.frame(&lines(&["one", "two"]), 10, 2);
        let again = painter.frame(&lines(&["one", "too"]), 10, 2);
        assert!(again.contains("too") && !again.contains("one"));
    }

    #[test]
    fn the_locale_says_what_can_be_shown() {
        let ask = |set: &[(&str, &str)]| {
            is_fancy(|name| set.iter().find(|(n, _)| *n == name).map(|(_, v)| v.to_string()))
        };
        if cfg!(unix) {
            assert!(ask(&[("LANG", "de_DE.UTF-8")]) && ask(&[("LC_ALL", "C.utf8"), ("LANG", "C")]));
            assert!(!ask(&[]) && !ask(&[("LC_ALL", "C"), ("LANG", "C.UTF-8")]));
            assert!(!ask(&[("LANG", "C.UTF-8"), ("TERM", "linux")]));
        }
    }
}
