//! Controls that move on and on: a line for where one begins, and ten a second for where it has come to.

use std::collections::BTreeMap;

use super::happened::Happened;
use crate::cli::table::grouped;

/// Seconds from one line of a control to the next.
const EVERY: f64 = 0.1;

/// Holds back moves of controls that were told a moment ago; where each is in the end is told.
#[derive(Debug, Default)]
pub struct Moves {
    /// By control: when it was told last, its latest move that was not, and how many were not.
    by_name: BTreeMap<String, (f64, Option<(Happened, u64)>)>,
}

impl Moves {
    /// What is to be said at once where this happens.
    pub fn take(&mut self, happened: Happened) -> Option<Happened> {
        let Some(name) = happened.control.clone() else { return Some(happened) };
        let (told, held) = self.by_name.entry(name).or_insert((f64::NEG_INFINITY, None));
        if held.is_none() && happened.at - *told >= EVERY {
            *told = happened.at;
            return Some(happened);
        }
        let count = held.as_ref().map_or(0, |(_, count)| *count) + 1;
        *held = Some((happened, count));
        None
    }

    /// What is to be said now of what was held back.
    pub fn due(&mut self, now: f64) -> Vec<Happened> {
        let due = |(told, held): &mut (f64, Option<(Happened, u64)>)| {
            let (mut happened, count) = held.take_if(|_| now - *told >= EVERY)?;
            *told = now;
            // It is told in its order, as where the control is now.
            happened.at = if now.is_finite() { now } else { happened.at };
            if count > 1 {
                happened.text += &format!(" ({} moves)", grouped(count));
            }
            Some(happened)
        };
        let mut all: Vec<Happened> = self.by_name.values_mut().filter_map(due).collect();
        all.sort_by(|a, b| a.at.total_cmp(&b.at));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Moves;
    use crate::cli::screen::happened::{Happened, Mood};

    fn moved(ms: u32, name: &str) -> Happened {
        let mut happened = Happened::new(f64::from(ms) / 1000.0, Mood::Told, format!("{name} to {ms}"));
        happened.control = Some(name.into());
        happened
    }

    #[test]
    fn a_flood_is_ten_lines_a_second_and_the_last_value_is_told() {
        let (mut moves, mut said) = (Moves::default(), Vec::new());
        for ms in 0..1_000 {
            said.extend(moves.take(moved(ms, "strength")));
            if ms % 20 == 0 {
                said.extend(moves.due(f64::from(ms) / 1000.0));
            }
        }
        said.extend(moves.due(1.2));
        assert!((10..=12).contains(&said.len()), "{said:?}");
        assert_eq!(said.first().unwrap().text, "strength to 0");
        assert!(said.last().unwrap().text.starts_with("strength to 999 ("), "{said:?}");
        assert!(said.windows(2).all(|two| two[0].at <= two[1].at));
    }

    #[test]
    fn what_moves_now_and_then_or_is_no_control_is_told_at_once() {
        let mut moves = Moves::default();
        let now_and_then = (0..5).filter_map(|n| moves.take(moved(200 * n, "a")));
        assert_eq!(now_and_then.count(), 5);
        let others = ["a", "b"].map(|name| moves.take(moved(1_500, name)).map(|said| said.text));
        assert_eq!(others.map(Option::unwrap), ["a to 1500", "b to 1500"]);
        let voices = (0..100).filter_map(|_| moves.take(Happened::new(2.0, Mood::Usual, "a voice")));
        assert_eq!(voices.count(), 100);
        assert_eq!(moves.due(9.0), []);
    }
}
