//! How far a rendering has come.

use super::terminal::Terminal;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Instant;

/// A bar on a terminal, and nothing anywhere else.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    total: Option<f64>,
    begin: Instant,
}

/// Steps of the bar in a second of vibration.
const STEPS: f64 = 1000.0;

impl Progress {
    /// Of a rendering that will be `total` seconds long, if that is known.
    pub fn new(terminal: &Terminal, total: Option<f64>) -> Self {
        let template = match total {
            Some(_) => "  {bar:32} {percent:>3} %  {msg}  {eta} left",
            None => "  {spinner} {msg}",
        };
        let bar = terminal.lively.then(|| {
            let length = total.map(|t| (t * STEPS).max(1.0) as u64);
            let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("━━─"));
            }
            bar
        });
        Self { bar, total, begin: Instant::now() }
    }

    /// So many seconds are there.
    pub fn at(&self, seconds: f64) {
        let Some(bar) = &self.bar else { return };
        let of = match self.total {
            Some(total) if seconds <= total => format!(" of {total:.1} s"),
            // What rings has no length beforehand.
            Some(_) => " s, ringing out".into(),
            None => " s".into(),
        };
        let speed = seconds / self.begin.elapsed().as_secs_f64().max(1e-6);
        bar.set_message(format!("{seconds:.1}{of}  {speed:.0} x real time"));
        bar.set_position((seconds * STEPS) as u64);
    }
}

impl Progress {
    /// What is being done, at so much of the total.
    pub fn says(&self, what: &str, at: f64) {
        let Some(bar) = &self.bar else { return };
        bar.set_message(what.to_string());
        bar.set_position((at * STEPS) as u64);
    }

    /// Takes the bar away.
    pub fn ends(self) {}
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
