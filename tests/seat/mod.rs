//! The program in a terminal of its own, as somebody sees it who sits in front of it.
#![allow(dead_code)] // No test needs all of it.

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::process::{Child, Command};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// So long something may take to be seen, or to end.
const PATIENCE: Duration = Duration::from_secs(20);

const ROWS: u16 = 60;
const COLUMNS: u16 = 160;

/// The program in a terminal.
pub struct Seat {
    keyboard: File,
    screen: Arc<Mutex<vt100::Parser>>,
    child: Child,
}

impl Seat {
    /// Lets `command` run there; `None` where there is no `setsid`.
    pub fn new(command: &Command) -> Option<Self> {
        if Command::new("setsid").arg("--version").output().is_err() {
            eprintln!("skipped: there is no setsid here, which util-linux brings");
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
        let size = Winsize { ws_row: ROWS, ws_col: COLUMNS, ws_xpixel: 0, ws_ypixel: 0 };
        tcsetwinsize(&near, size).unwrap();
        let mut there = Command::new("setsid");
        there.arg("--ctty").arg(command.get_program()).args(command.get_args());
        there.current_dir(command.get_current_dir().unwrap());
        there.env("TERM", "xterm-256color").env("LC_ALL", "C.UTF-8").env("NO_COLOR", "1");
        let child = there.stdin(open()).stdout(open()).stderr(open()).spawn().unwrap();
        let size = |n| NonZero::new(n).unwrap();
        let screen = Arc::new(Mutex::new(vt100::Parser::new(size(ROWS), size(COLUMNS), 1000)));
        let keyboard = File::from(near);
        let (mut out, shown) = (keyboard.try_clone().unwrap(), Arc::downgrade(&screen));
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = out.read(&mut bytes) {
                let Some(screen) = shown.upgrade() else { break };
                screen.lock().unwrap().process(&bytes[..count]);
            }
        });
        Some(Self { keyboard, screen, child })
    }

    pub fn contents(&self) -> String {
        self.screen.lock().unwrap().screen().contents()
    }

    /// Waits until the terminal shows this.
    #[track_caller]
    pub fn see(&self, what: &str) -> String {
        let begin = Instant::now();
        loop {
            let contents = self.contents();
            if contents.contains(what) {
                return contents;
            }
            assert!(begin.elapsed() < PATIENCE, "no `{what}` in\n{contents}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub fn press(&mut self, keys: &str) {
        self.keyboard.write_all(keys.as_bytes()).unwrap();
    }

    /// Waits for the end; the exit code.
    #[track_caller]
    pub fn end(&mut self) -> Option<i32> {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            assert!(begin.elapsed() < PATIENCE, "it does not end:\n{}", self.contents());
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
