//! A device that does not answer: a word after some seconds, and an end after more.

use super::failure::Failure;
use super::guard;
use super::stop::Stop;
use super::terminal::Terminal;
use pacinian::io::device::hush::aloud;
use pacinian::io::session::{Beginning, Session, SessionError};
use pacinian::text::problem::escaped;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How long somebody is waited for.
#[derive(Debug, Clone, Copy)]
struct Patience {
    /// Until something is said.
    word: Duration,
    /// Until it is given up.
    most: Duration,
    /// The same once somebody has asked to stop.
    grace: Duration,
}

/// A sound system that wakes a headphone may take ten seconds.
const DEVICE: Patience = Patience {
    word: Duration::from_secs(5),
    most: Duration::from_secs(30),
    grace: Duration::from_millis(500),
};

/// How often it is looked whether somebody has asked to stop.
const LOOK: Duration = Duration::from_millis(20);

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Silence {
    /// It was waited for long enough.
    Long,
    /// Somebody has asked to stop, with this exit code.
    Stopped(u8),
    /// There is no thread to ask in.
    NoThread,
    /// Who asked has panicked.
    Panicked,
}

/// A session on the device of that name.
///
/// # Errors
/// As [`Session::start`], and a device that does not answer: what asks it goes on until the program ends.
pub fn begin(name: &str, beginning: Beginning, stop: &Stop, terminal: &Terminal) -> Result<Session, Failure> {
    let patch = Arc::clone(&beginning.scene.patch);
    let answer = ask(&escaped(name), || stop.asked(), terminal, || Session::start(beginning))?;
    answer.map_err(|error| match error {
        SessionError::Device(error) => error.into(),
        SessionError::Patch(problem) => Failure::of(65, patch.origin.problems(vec![problem])),
        error @ SessionError::Engine(_) => Failure::said(65, error.to_string()),
        error @ SessionError::Thread(_) => Failure::said(71, error.to_string()),
    })
}

/// What the sound systems say of their devices. Where nobody listens to signals yet, they end the program by themselves.
///
/// # Errors
/// One that does not answer, such as a server that has been stopped.
pub fn look<T: Send + 'static>(
    stop: Option<&Stop>,
    terminal: &Terminal,
    look: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Failure> {
    ask("a sound system", || stop.and_then(Stop::asked), terminal, look)
}

/// What a device is used for that may not answer at first, but takes its time once `begun` says that it has.
///
/// # Errors
/// A device that does not answer.
pub fn long<T: Send + 'static>(
    name: &str,
    begun: &Arc<AtomicBool>,
    stop: &Stop,
    terminal: &Terminal,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Failure> {
    let ((answer, answers), now) = (channel(), Arc::clone(begun));
    let work = move || {
        // Who has given up does not hear it any more.
        let _ = answer.send(work());
        now.store(true, Ordering::Release);
    };
    let begins = Arc::clone(begun);
    let until_it_begins = move || -> std::io::Result<()> {
        std::thread::Builder::new().name("use".into()).spawn(work)?;
        while !begins.load(Ordering::Acquire) {
            std::thread::sleep(LOOK);
        }
        Ok(())
    };
    let started = ask(&escaped(name), || stop.asked(), terminal, until_it_begins)?;
    started.map_err(|error| Failure::no_thread(name, &error))?;
    // It looks by itself whether somebody has asked to stop.
    answers.recv().map_err(|_| Failure::told(guard::BUG))
}

fn ask<T: Send + 'static>(
    name: &str,
    asked: impl Fn() -> Option<u8>,
    terminal: &Terminal,
    ask: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Failure> {
    let told = || {
        aloud();
        terminal.note(&format!("{name} does not answer yet; Ctrl-C gives up\n"));
    };
    DEVICE.wait(asked, told, ask).map_err(|silence| match silence {
        Silence::Long => Failure::usage(
            format!("{name} has not answered for {} s", DEVICE.most.as_secs()),
            "try once more; if it stays so, start the sound server anew, or do without: --device virtual",
        )
        .with_code(69),
        Silence::Stopped(code) => Failure::told(code),
        Silence::NoThread => Failure::said(71, format!("no thread to ask {name} in")),
        Silence::Panicked => Failure::told(guard::BUG),
    })
}

impl Patience {
    /// What `ask` comes to, in a thread of its own; `asked` says whether somebody has asked to stop, and `told` is called where it takes long.
    fn wait<T: Send + 'static>(
        self,
        asked: impl Fn() -> Option<u8>,
        told: impl FnOnce(),
        ask: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Silence> {
        let (answer, answers) = channel();
        let work = move || {
            // Who has given up does not hear it any more.
            let _ = answer.send(ask());
        };
        std::thread::Builder::new().name("open".into()).spawn(work).map_err(|_| Silence::NoThread)?;
        let begin = Instant::now();
        let (mut told, mut stopped) = (Some(told), None);
        loop {
            match answers.recv_timeout(LOOK) {
                Ok(answer) => return Ok(answer),
                Err(RecvTimeoutError::Disconnected) => return Err(Silence::Panicked),
                Err(RecvTimeoutError::Timeout) => {}
            }
            let passed = begin.elapsed();
            // One that answers after all is closed in order.
            if let Some(code) = asked() {
                let (at, code) = *stopped.get_or_insert((passed, code));
                if passed - at >= self.grace {
                    return Err(Silence::Stopped(code));
                }
            }
            if passed >= self.most {
                return Err(Silence::Long);
            }
            if passed >= self.word {
                told.take().into_iter().for_each(|told| told());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Patience, Silence};
    use std::cell::Cell;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    const NONE: Duration = Duration::ZERO;
    const LONG: Duration = Duration::from_secs(600);

    #[test]
    fn only_who_takes_long_is_told_of() {
        let told = Cell::new(false);
        let patience = Patience { word: LONG, most: LONG, grace: LONG };
        assert_eq!(patience.wait(|| None, || told.set(true), || 1), Ok(1));
        assert!(!told.get());
        let (wake, waits) = channel();
        let tell = || {
            told.set(true);
            wake.send(()).unwrap();
        };
        let slow = Patience { word: NONE, ..patience };
        assert_eq!(slow.wait(|| None, tell, move || waits.recv().map(|()| 2)), Ok(Ok(2)));
        assert!(told.get());
    }

    #[test]
    fn who_never_answers_is_given_up() {
        // Who is asked waits for whoever asks, for ever.
        let (wake, waits) = channel::<()>();
        let never = move || waits.recv().is_ok();
        let patience = Patience { word: NONE, most: Duration::from_millis(30), grace: LONG };
        assert_eq!(patience.wait(|| None, || (), never), Err(Silence::Long));
        drop(wake);
    }

    #[test]
    fn a_stop_ends_it_but_for_who_answers_a_little_later() {
        let (wake, waits) = channel::<()>();
        let never = move || waits.recv().is_ok();
        let patience = Patience { word: LONG, most: LONG, grace: Duration::from_millis(30) };
        assert_eq!(patience.wait(|| Some(130), || (), never), Err(Silence::Stopped(130)));
        drop(wake);
        let later = Patience { grace: LONG, ..patience };
        let (wake, waits) = channel();
        let asked = || {
            let _ = wake.send(());
            Some(130)
        };
        assert_eq!(later.wait(asked, || (), move || waits.recv().is_ok()), Ok(true));
    }

    #[test]
    fn who_panics_does_not_answer() {
        let patience = Patience { word: LONG, most: LONG, grace: LONG };
        assert_eq!(patience.wait(|| None, || (), || -> u8 { panic!("no device") }), Err(Silence::Panicked));
    }
}
