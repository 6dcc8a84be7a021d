//! Whose turn it is, while channel after channel is asked about.

use super::map::Felt;
use std::collections::BTreeMap;

/// The turns of a walk, by places in its list of channels, and what was felt so far.
#[derive(Debug)]
pub struct Turns {
    channels: Vec<u32>,
    turns: Vec<usize>,
    at: usize,
}

impl Turns {
    /// Each channel once, in this order.
    pub fn over(channels: Vec<u32>) -> Self {
        Self { turns: (0..channels.len()).collect(), channels, at: 0 }
    }

    /// Whose turn it is, if there are any left.
    pub fn now(&self) -> Option<usize> {
        self.turns.get(self.at).copied()
    }

    /// The number of this turn, from 1, and of how many.
    pub fn count(&self) -> (usize, usize) {
        (self.at + 1, self.turns.len())
    }

    /// The turn before comes again.
    pub fn back(&mut self) {
        self.at = self.at.saturating_sub(1);
    }

    /// What was felt on the channel whose turn it is goes to `felt`, and the next is on.
    ///
    /// A tactor hangs on one channel: where it was felt on another before, what was said of that one is taken back and it
    /// has a turn again. Gives that channel.
    pub fn said(&mut self, what: Option<Felt>, felt: &mut BTreeMap<u32, Felt>) -> Option<u32> {
        let channel = *self.channels.get(self.now()?)?;
        self.at += 1;
        let Some(what) = what else {
            felt.remove(&channel);
            return None;
        };
        felt.insert(channel, what);
        let tactor = Some(what).filter(|what| matches!(what, Felt::Output(_)))?;
        let other = felt.iter().find(|(at, what)| **at != channel && **what == tactor).map(|(at, _)| *at)?;
        felt.remove(&other);
        let place = self.channels.iter().position(|channel| *channel == other)?;
        if !self.turns.get(self.at..).is_some_and(|left| left.contains(&place)) {
            self.turns.push(place);
        }
        Some(other)
    }
}

#[cfg(test)]
mod tests {
    use super::Turns;
    use crate::live::walk::map::Felt;
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn what_is_felt_twice_is_asked_again() {
        let (mut turns, mut felt) = (Turns::over(vec![1, 2, 4]), BTreeMap::new());
        assert_eq!(turns.said(Some(Felt::Output(0)), &mut felt), None);
        assert_eq!(turns.said(Some(Felt::Output(0)), &mut felt), Some(1));
        assert_eq!(felt, BTreeMap::from([(2, Felt::Output(0))]));
        // Nothing may be felt more often than once.
        assert_eq!(turns.said(Some(Felt::Nothing), &mut felt), None);
        assert_eq!((turns.now(), turns.count()), (Some(0), (4, 4)));
        assert_eq!(turns.said(Some(Felt::Nothing), &mut felt), None);
        assert_eq!(turns.now(), None);
        // Nobody is asked once more who will be asked anyway.
        turns.back();
        turns.back();
        assert_eq!(turns.said(Some(Felt::Output(0)), &mut felt), Some(2));
        assert_eq!((turns.now(), turns.count()), (Some(0), (4, 5)));
        turns.back();
        assert_eq!(turns.said(None, &mut felt), None);
        assert_eq!(felt, BTreeMap::from([(1, Felt::Nothing)]));
    }

    #[test]
    fn whatever_is_said_no_tactor_is_on_two_channels_and_all_who_lost_it_have_a_turn() {
        // Walks of 8 answers on three channels of two tactors: each, nothing, no answer, back.
        for code in 0..5_usize.pow(8) {
            let (mut turns, mut felt) = (Turns::over(vec![3, 5, 6]), BTreeMap::new());
            let mut lost = BTreeSet::new();
            for n in 0..8 {
                let Some(place) = turns.now() else { break };
                lost.remove(&[3, 5, 6][place]);
                let other = match code / 5_usize.pow(n) % 5 {
                    4 => {
                        turns.back();
                        continue;
                    }
                    3 => turns.said(None, &mut felt),
                    2 => turns.said(Some(Felt::Nothing), &mut felt),
                    output => turns.said(Some(Felt::Output(output)), &mut felt),
                };
                lost.extend(other);
                for output in 0..2 {
                    assert!(felt.values().filter(|what| **what == Felt::Output(output)).count() < 2);
                }
            }
            if turns.now().is_none() {
                assert!(lost.is_empty(), "{code}");
            }
        }
    }
}
