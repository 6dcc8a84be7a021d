//! A knob that is turned while it sounds, and what is said of it at the end.

use super::answer::Answer;
use super::figures::Figures;
use super::set_off::SetOff;
use crate::cli::failure::Failure;
use crate::cli::loaded::Loaded;
use crate::cli::terminal::Terminal;
use pacinian::engine::knob::Knob;
use pacinian::graph::plan::Plan;
use pacinian::live::board::Board;
use pacinian::performer::Listener;
use std::sync::{Arc, Mutex, PoisonError};

/// What is known of it from the beginning on, and what it set off so far.
pub struct Turning {
    figures: Option<Figures>,
    rate: f64,
    set_off: Arc<Mutex<SetOff>>,
}

impl Turning {
    /// That of a plan.
    pub fn of(plan: &Plan) -> Self {
        let knob = Knob::new(plan).ok().flatten();
        let figures = knob.and_then(|knob| Figures::new(plan, &knob));
        Self { figures, rate: plan.engine_rate(), set_off: Arc::default() }
    }

    /// Hears what it sets off, beside another who hears all.
    pub fn beside(&self, mut other: Listener) -> Listener {
        let set_off = Arc::clone(&self.set_off);
        Box::new(move |event| {
            set_off.lock().unwrap_or_else(PoisonError::into_inner).hear(event);
            other(event);
        })
    }

    /// Says what it is and what it did.
    ///
    /// # Errors
    /// What keeps it from being written.
    pub fn told(self, loaded: &Loaded, board: &Board, terminal: &Terminal) -> Result<(), Failure> {
        let Some(tally) = board.tally() else { return Ok(()) };
        let set_off = std::mem::take(&mut *self.set_off.lock().unwrap_or_else(PoisonError::into_inner));
        let answer = Answer::new(loaded.name(), self.figures, self.rate, &tally, set_off);
        terminal.print(&answer.text(terminal.out))
    }
}
