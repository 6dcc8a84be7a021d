//! What `pacinian play` shows, in a terminal of its own.
#![cfg(all(feature = "cli", target_os = "linux"))]

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title = "Two hands"

[voice.tap]
output = "wave"

[voice.tap.nodes]
wave = { type = "sine", frequency = 200 }

[pattern.left]
events = [{ at = 0, voice = "tap", duration = 0.1 }]
repeat = { every = 0.2, times = 10000 }

[pattern.right]
events = [{ at = 0, voice = "tap", duration = 0.1, level = 0.5 }]
repeat = { every = 0.3, times = 10000 }
"#;

/// So long something may take to be seen, or to end.
const PATIENCE: Duration = Duration::from_secs(20);

/// The program in a terminal.
struct Seat {
    /// The keyboard; the terminal is closed where nobody holds it.
    keyboard: Option<File>,
    /// The other side.
    line: File,
    screen: Arc<Mutex<vt100::Parser>>,
    child: Child,
    folder: std::path::PathBuf,
}

impl Seat {
    /// Sits down in front of a terminal of that size; its own (`owned`), so that the program hears when it is closed, or not.
    fn new(name: &str, columns: u16, rows: u16, term: &str, owned: bool) -> Option<Self> {
        if Command::new("setsid").arg("--version").output().is_err() {
            eprintln!("skipped: there is no setsid here, which util-linux brings");
            return None;
        }
        let folder = std::env::temp_dir().join(format!("pacinian-screen-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("patch.toml"), PATCH).unwrap();
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
        let mut command = Command::new("setsid");
        if owned {
            command.arg("--ctty");
        }
        command.arg(env!("CARGO_BIN_EXE_pacinian")).args(["play", "patch.toml", "--device", "virtual"]);
        command.args(["--pattern", "left"]).current_dir(&folder);
        command.env("TERM", term).env("LC_ALL", "C.UTF-8").env_remove("NO_COLOR");
        let child = command.stdin(open()).stdout(open()).stderr(open()).spawn().unwrap();
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
        Some(Self { keyboard: Some(keyboard), line, screen, child, folder })
    }

    fn contents(&self) -> String {
        self.screen.lock().unwrap().screen().contents()
    }

    /// Waits until the terminal shows what is wanted.
    fn see(&self, what: &str, wanted: impl Fn(&str) -> bool) -> String {
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

    fn press(&mut self, keys: &str) {
        self.keyboard.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    fn end(&mut self) -> ExitStatus {
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
    fn is_given_back(&self) -> bool {
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

    fn signal(&self, name: &str) {
        let kill = Command::new("kill").args(["-s", name, &self.child.id().to_string()]).status();
        assert!(kill.unwrap().success());
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn resize(terminal: impl std::os::fd::AsFd, columns: u16, rows: u16) {
    let size = Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(terminal, size).unwrap();
}

#[test]
fn keys_do_what_the_screen_says() {
    let Some(mut seat) = Seat::new("keys", 100, 30, "xterm-256color", true) else { return };
    seat.see("first pattern", |text| text.contains("1 ▶ left") && text.contains("tap on t1"));
    let text = seat.see("meter", |text| text.contains("██"));
    for part in ["Two hands", "virtual card", "load", "latency", "xruns 0", "2 right", "ARMED", "q end"] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
    seat.press("2");
    seat.see("second pattern", |text| text.contains("2 ▶ right"));
    seat.press("1");
    seat.see("end of the first", |text| text.contains("1 left") && text.contains("2 ▶ right"));
    seat.press(" ");
    seat.see("end of all", |text| text.contains("2 right"));
    seat.press("a");
    seat.see("-20 dB", |text| text.lines().next().is_some_and(|line| line.trim_end().ends_with("-20 dB")));
    seat.press("p");
    seat.see("panic", |text| text.contains("PANIC: the output is shut") && text.contains("SHUT"));
    seat.press("c");
    seat.see("calm", |text| !text.contains("SHUT") && text.contains("open again"));
    // A smaller window is filled anew.
    resize(seat.keyboard.as_ref().unwrap(), 50, 12);
    let size = |n| NonZero::new(n).unwrap();
    seat.screen.lock().unwrap().screen_mut().set_size(size(12), size(50));
    let fits = |text: &str| text.lines().last().is_some_and(|line| line.starts_with(" p panic"));
    seat.see("all in a smaller window", |text| fits(text) && text.lines().count() == 12);
    assert!(!seat.is_given_back_now());
    seat.press("q");
    assert!(seat.end().success());
    assert!(seat.is_given_back());
    let after = seat.see("summary", |text| text.contains("frames"));
    assert!(!after.contains("PANIC"), "{after}");
}

impl Seat {
    fn is_given_back_now(&self) -> bool {
        tcgetattr(&self.line).unwrap().local_modes.contains(LocalModes::ICANON)
            || !self.screen.lock().unwrap().screen().alternate_screen()
    }
}

#[test]
fn whoever_ends_it_gets_the_terminal_back() {
    for (how, code) in [("TERM", 143), ("INT", 130), ("HUP", 129), ("\x03", 130)] {
        let Some(mut seat) = Seat::new("end", 80, 24, "xterm-256color", true) else { return };
        seat.see("screen", |text| text.contains("▶ left"));
        if how == "\x03" {
            seat.press(how)
        } else {
            seat.signal(how)
        }
        assert_eq!(seat.end().code(), Some(code), "{how:?}");
        assert!(seat.is_given_back(), "{how:?}");
    }
}

#[test]
fn a_closed_terminal_ends_it() {
    // With the signal that the system sends then, and without.
    for owned in [true, false] {
        let Some(mut seat) = Seat::new("closed", 80, 24, "xterm-256color", owned) else { return };
        if !owned {
            // Nobody reads in its own thread here, so that this end is the only one.
            let (begin, mut bytes) = (Instant::now(), [0; 4096]);
            while !seat.contents().contains("▶ left") && begin.elapsed() < PATIENCE {
                let count = seat.keyboard.as_mut().unwrap().read(&mut bytes).unwrap();
                seat.screen.lock().unwrap().process(&bytes[..count]);
            }
            drop(seat.keyboard.take());
        } else {
            seat.see("screen", |text| text.contains("▶ left"));
            seat.signal("HUP");
        }
        assert_eq!(seat.end().code(), Some(129), "{owned}");
    }
}

#[test]
fn where_a_screen_makes_no_sense_there_are_lines() {
    for (columns, rows, term) in [(20, 5, "xterm-256color"), (100, 30, "dumb")] {
        let Some(mut seat) = Seat::new("lines", columns, rows, term, true) else { return };
        seat.see("events", |text| text.replace('\n', "").contains("tap on t1"));
        assert!(!seat.screen.lock().unwrap().screen().alternate_screen());
        assert!(tcgetattr(&seat.line).unwrap().local_modes.contains(LocalModes::ICANON));
        // Through the terminal, as the keys are not read.
        seat.press("\x03");
        assert_eq!(seat.end().code(), Some(130));
    }
}
