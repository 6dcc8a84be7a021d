//! The same trouble again and again: a line for the first, and one a second for those that follow.

use super::happened::{Happened, Mood};
use crate::cli::table::grouped;

/// Seconds for which the same trouble is held back.
const HOLD: f64 = 1.0;

/// Holds back what was said a moment ago.
#[derive(Debug, Default)]
pub struct Echo {
    /// What was said last of all trouble, and how often the same came since.
    last: Option<Happened>,
}

impl Echo {
    /// What is to be said where this happens.
    pub fn take(&mut self, happened: Happened) -> impl Iterator<Item = Happened> {
        if happened.mood == Mood::Good {
            // What is wrong after it is wrong anew.
            let held = self.release(happened.at);
            self.last = None;
            return held.into_iter().chain(Some(happened));
        }
        if happened.mood != Mood::Bad {
            return None.into_iter().chain(Some(happened));
        }
        if let Some(last) = self.last.as_mut().filter(|last| last.text == happened.text) {
            last.again += 1;
            return self.due(happened.at).into_iter().chain(None);
        }
        let held = self.release(happened.at);
        self.last = Some(happened.clone());
        held.into_iter().chain(Some(happened))
    }

    /// What is to be said of what was held back, if it is time.
    pub fn due(&mut self, now: f64) -> Option<Happened> {
        let due = self.last.as_ref().is_some_and(|last| now - last.at >= HOLD);
        if due { self.release(now) } else { None }
    }

    /// What is to be said of what was held back, now.
    pub fn release(&mut self, now: f64) -> Option<Happened> {
        let last = self.last.as_mut()?;
        let held = std::mem::take(&mut last.again);
        if held == 0 {
            // It may be said in full again.
            self.last.take_if(|last| now - last.at >= HOLD);
            return None;
        }
        last.at = now;
        Some(Happened::new(now, Mood::Bad, format!("{} ({} more)", last.text, grouped(held))))
    }
}

#[cfg(test)]
mod tests {
    use super::{Echo, Happened, Mood};

    #[test]
    fn what_is_said_again_is_counted() {
        let mut echo = Echo::default();
        let mut said = Vec::new();
        let bad = |ms: u64, text: &str| Happened::new(ms as f64 / 1000.0, Mood::Bad, text);
        for ms in 0..2_500 {
            said.extend(echo.take(bad(ms, "no")));
            said.extend(echo.take(Happened::new(ms as f64, Mood::Usual, "a voice")));
        }
        said.extend(echo.take(bad(2_600, "nor this")));
        said.extend(echo.take(bad(2_700, "nor this")));
        said.extend(echo.due(3_500.0 / 1000.0));
        said.extend(echo.due(3_800.0 / 1000.0));
        said.extend(echo.due(5_000.0 / 1000.0));
        said.extend(echo.take(bad(5_100, "nor this")));
        said.extend(echo.take(Happened::new(5.2, Mood::Good, "mended")));
        said.extend(echo.take(bad(5_300, "nor this")));
        let usual = said.iter().filter(|h| h.mood == Mood::Usual).count();
        let texts: Vec<_> = said.iter().filter(|h| h.mood == Mood::Bad).map(|h| h.text.as_str()).collect();
        assert_eq!(usual, 2_500);
        let wanted = [
            "no",
            "no (1 000 more)",
            "no (1 000 more)",
            "no (499 more)",
            "nor this",
            "nor this (1 more)",
            "nor this",
            "nor this",
        ];
        assert_eq!(texts.iter().map(|t| t.replace([',', '\u{202f}'], " ")).collect::<Vec<_>>(), wanted);
    }
}
