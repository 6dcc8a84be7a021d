//! Voices that can still be released and touched, by the numbers of the signals that played them.

use std::collections::BTreeMap;

use crate::performer::When;
use crate::text::Problem;

/// So many.
const MOST: usize = 1 << 14;

/// A voice that was played.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    /// Its id.
    pub id: u64,
    /// When it begins.
    pub onset: When,
    /// When its event ends, seconds; infinite for one that is held.
    pub until: f64,
}

/// All that are known.
#[derive(Debug, Default)]
pub(super) struct Voices {
    known: BTreeMap<u64, Known>,
    /// The highest number that had to be forgotten though its voice may still sound.
    forgotten: u64,
}

impl Voices {
    /// A voice of that number begins. Where there are too many, those go that are over `now`, and then, of an eighth, the oldest.
    pub fn note(&mut self, number: u64, known: Known, now: f64) {
        if self.known.len() >= MOST {
            self.known.retain(|_, known| known.until > now);
            while self.known.len() > MOST - MOST / 8
                && let Some((oldest, _)) = self.known.pop_first()
            {
                self.forgotten = self.forgotten.max(oldest);
            }
        }
        self.known.insert(number, known);
    }

    /// The voice of that number; `None` if it is over.
    ///
    /// # Errors
    /// One that was forgotten and may still sound.
    pub fn find(&self, number: u64) -> Result<Option<Known>, Problem> {
        let known = self.known.get(&number).copied();
        if known.is_none() && number <= self.forgotten {
            let what = format!("its voice is not known any more: {MOST} others were not over at once");
            let help = "if it still sounds, release all; and release sooner what is held";
            return Err(Problem::of_file(what).help(help.to_string()));
        }
        Ok(known)
    }

    /// The same, and it is known no more.
    ///
    /// # Errors
    /// As [`Voices::find`].
    pub fn take(&mut self, number: u64) -> Result<Option<Known>, Problem> {
        let found = self.find(number);
        self.known.remove(&number);
        found
    }

    /// None is known any more. Gives those that have yet to begin then.
    pub fn clear(&mut self, at: When) -> impl Iterator<Item = Known> + use<> {
        let known = std::mem::take(self).known;
        known.into_values().filter(move |known| known.onset.instant > at.instant)
    }
}

#[cfg(test)]
mod tests {
    use super::{Known, MOST, Voices, When};

    #[test]
    fn what_is_held_is_known_behind_any_number_of_others_that_are_over() {
        let mut voices = Voices::default();
        let known =
            |number: u64, until: f64| Known { id: number, onset: When::of_seconds(0.0, 8000.0), until };
        voices.note(1, known(1, f64::INFINITY), 0.0);
        for number in 2..200_000 {
            let now = 0.001 * number as f64;
            voices.note(number, known(number, now + 0.05), now);
        }
        assert_eq!(voices.find(1).unwrap().map(|known| known.id), Some(1));
        assert!(voices.find(2).unwrap().is_none(), "it is over");
        assert_eq!(voices.take(1).unwrap().map(|known| known.id), Some(1));
        assert!(voices.take(1).unwrap().is_none(), "it was released");
        // More than there is room for, and none of them over.
        let mut voices = Voices::default();
        (1..=MOST as u64 + 1).for_each(|number| voices.note(number, known(number, f64::INFINITY), 0.0));
        assert!(
            voices.find(1).is_err() && voices.take(2).is_err() && voices.find(MOST as u64).unwrap().is_some()
        );
    }
}
