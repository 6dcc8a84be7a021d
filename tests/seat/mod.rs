//! The program in a terminal of its own, as somebody sees it who sits in front of it.
#![allow(dead_code)] // No test needs all of it.

#[path = "../common/skipped.rs"]
mod skipped;

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

pub use skipped::skipped;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

/// So long something may take to be seen, or to end.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// The program in a terminal.
pub struct Seat {
    /// The keyboard; the terminal is closed where nobody holds it.
    pub keyboard: Option<File>,
    /// The other side.
    pub line: File,
    pub screen: Arc<Mutex<vt100::Parser>>,
    child: Child,
}

impl Seat {
    /// Sits down in front of a large terminal of its own and lets `command` run there; `None` where there is no `setsid`.
    pub fn new(command: &Command) -> Option<Self> {
        Self::at(command, (160, 60), "xterm-256color", true)
    }

    /// The same of that size (columns and rows); its own (`owned`), so that the program hears when it is closed, or not.
    pub fn at(command: &Command, (columns, rows): (u16, u16), term: &str, owned: bool) -> Option<Self> {
        if Command::new("setsid").arg("--version").output().is_err() {
            skipped("there is no setsid here, which util-linux brings");
            return None;
        }
        let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&near).unwrap();
        unlockpt(&near).unwrap();
        let path = ptsname(&near, Vec::new()).unwrap().into_string().unwrap();
        let open = || {
            use std::os::unix::fs::OpenOptionsExt;
            let noctty = OpenptFlags::NOCTTY.bits() as i32;
            File::options().read(true).write(true).custom_flags(noctty).open(&path).unwrap()
        };
        let line = open();
        resize(&near, columns, rows);
        let mut there = Command::new("setsid");
        if owned {
            there.arg("--ctty");
        }
        there.arg(command.get_program()).args(command.get_args());
        there.current_dir(command.get_current_dir().unwrap());
        there.env("TERM", term).env("LC_ALL", "C.UTF-8").env_remove("NO_COLOR");
        let child = there.stdin(open()).stdout(open()).stderr(open()).spawn().unwrap();
        let size = |n| NonZero::new(n).unwrap();
        let screen = Arc::new(Mutex::new(vt100::Parser::new(size(rows), size(columns), 1000)));
        let keyboard = File::from(near);
        let (mut out, shown) = (keyboard.try_clone().unwrap(), Arc::downgrade(&screen));
        if owned {
            std::thread::spawn(move || {
                let mut bytes = [0; 4096];
                while let Ok(count @ 1..) = out.read(&mut bytes) {
                    let Some(screen) = shown.upgrade() else { break };
                    screen.lock().unwrap().process(&bytes[..count]);
                }
            });
        }
        Some(Self { keyboard: Some(keyboard), line, screen, child })
    }

    pub fn contents(&self) -> String {
        self.screen.lock().unwrap().screen().contents()
    }

    /// Waits until the terminal shows what is wanted.
    #[track_caller]
    pub fn see(&self, what: &str, wanted: impl Fn(&str) -> bool) -> String {
        let begin = Instant::now();
        loop {
            let contents = self.contents();
            if wanted(&contents) {
                return contents;
            }
            assert!(begin.elapsed() < PATIENCE, "no {what} in\n{contents}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits until it shows this text.
    #[track_caller]
    pub fn shows(&self, text: &str) -> String {
        self.see(text, |contents| contents.contains(text))
    }

    pub fn press(&mut self, keys: &str) {
        self.keyboard.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    #[track_caller]
    pub fn end(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < PATIENCE, "it does not end:\n{}", self.contents());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Whether the terminal is as a shell wants it.
    pub fn is_given_back(&self) -> bool {
        let modes = tcgetattr(&self.line).unwrap().local_modes;
        let cooked = LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG;
        let begin = Instant::now();
        // What was written last may still be on its way.
        while begin.elapsed() < PATIENCE {
            let screen = self.screen.lock().unwrap();
            if !screen.screen().alternate_screen() && !screen.screen().hide_cursor() {
                return modes.contains(cooked);
            }
            drop(screen);
            std::thread::sleep(Duration::from_millis(10));
        }
        false
    }

    /// Closes the terminal under the program: nobody holds its other side any more.
    pub fn hang_up(&mut self) {
        drop(self.keyboard.take());
        // Whoever reads in a thread of its own lets go with the next frame that nobody wants any more.
        let size = |n| NonZero::new(n).unwrap();
        self.screen = Arc::new(Mutex::new(vt100::Parser::new(size(24), size(80), 0)));
    }

    pub fn signal(&self, name: &str) {
        let kill = Command::new("kill").args(["-s", name, &self.child.id().to_string()]).status();
        assert!(kill.unwrap().success());
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn resize(terminal: impl std::os::fd::AsFd, columns: u16, rows: u16) {
    let size = Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(terminal, size).unwrap();
}

impl Seat {
    pub fn is_given_back_now(&self) -> bool {
        tcgetattr(&self.line).unwrap().local_modes.contains(LocalModes::ICANON)
            || !self.screen.lock().unwrap().screen().alternate_screen()
    }
}
