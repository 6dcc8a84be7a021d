//! How a session comes to its end.

use super::super::screen::{Ending, Show};
use super::super::stop::{CLOSED, INTERRUPTED, Stop};
use pacinian::io::session::Session;
use pacinian::live::signal::Origin;
use std::time::Instant;

/// So many seconds a device may be behind at the end of a session of so long.
const SLOW: f64 = 3.0;

/// Why a session comes to its end.
#[derive(Clone, Copy, PartialEq)]
pub enum End {
    /// Its time is over.
    Over,
    /// A signal, or a terminal that was closed: the exit code.
    Signal(u8),
    /// A key: the exit code, if not that of success.
    Key(Option<u8>),
}

impl End {
    /// The exit code, if not that of success.
    pub fn code(self) -> Option<u8> {
        match self {
            Self::Over => None,
            Self::Signal(code) => Some(code),
            Self::Key(code) => code,
        }
    }

    /// Who ends the session, as a journal has it.
    pub fn origin(self) -> Origin {
        match self {
            Self::Over => Origin::System("time".into()),
            Self::Signal(code) => {
                let name = signal_hook::low_level::signal_name(i32::from(code) - 128);
                Origin::System(name.unwrap_or("end").into())
            }
            Self::Key(Some(INTERRUPTED)) => Origin::Key("Ctrl-C".into()),
            Self::Key(_) => Origin::Key("q".into()),
        }
    }

    /// Waits until somebody asks to stop, or the `duration` is over.
    pub fn wait(
        duration: Option<f64>,
        session: &Session,
        stop: &Stop,
        show: &mut Show,
        mut meanwhile: impl FnMut(&mut Show),
    ) -> Self {
        let begin = Instant::now();
        loop {
            meanwhile(show);
            if let Some(code) = stop.asked() {
                return Self::Signal(code);
            }
            let (passed, played) =
                (begin.elapsed().as_secs_f64(), session.board().frames.get() as f64 / session.rate());
            // A device may need a while before it asks for frames regularly; it is waited for, but not for ever.
            if duration.is_some_and(|whole| passed >= whole && (played >= whole || passed >= whole + SLOW)) {
                return Self::Over;
            }
            match show.step(session) {
                None => {}
                Some(Ending::Asked(code)) => return Self::Key(code),
                Some(Ending::Closed) => return Self::Signal(stop.asked().unwrap_or(CLOSED)),
            }
        }
    }
}
