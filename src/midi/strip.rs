//! What one channel stands at.

use std::cmp::Ordering;

use super::claims::Own;
use super::parameter::{self, Selection};

/// A controller that never moved.
const NEVER: u8 = 0xFF;

/// Sustain pedal.
pub(super) const SUSTAIN: u8 = 64;
/// Sostenuto pedal.
pub(super) const SOSTENUTO: u8 = 66;
/// The third dimension of MPE.
pub(super) const TIMBRE: u8 = 74;
/// The first channel mode message.
pub(super) const MODES: u8 = 120;

const BANK: [u8; 2] = [0, 32];
/// What Reset All Controllers (RP-015) sets: modulation, expression, sustain, portamento, sostenuto, soft pedal.
const RESETS: [(u8, u8); 6] = [(1, 0), (11, 127), (SUSTAIN, 0), (65, 0), (SOSTENUTO, 0), (67, 0)];

/// How far the pitch wheel bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Range {
    pub semitones: u8,
    pub cents: u8,
}

impl Range {
    /// MIDI 1.0, and of a manager of MPE.
    pub const TWO: Self = Self { semitones: 2, cents: 0 };
    /// Of a member of MPE.
    pub const MEMBER: Self = Self { semitones: 48, cents: 0 };

    /// One cent more or less, with 100 of them in a semitone (RP-018).
    pub fn step(self, by: i16) -> Self {
        let cents = (i16::from(self.semitones) * 100 + i16::from(self.cents) + by).clamp(0, 12_799);
        Self { semitones: (cents / 100) as u8, cents: (cents % 100) as u8 }
    }
    fn as_semitones(self) -> f64 {
        f64::from(self.semitones) + f64::from(self.cents) / 100.0
    }
}

/// A controller that moved: its number, where it stands, and whether that has 14 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moved {
    pub number: u8,
    pub value: f64,
    pub fine: bool,
}

impl Moved {
    fn coarse(number: u8, value: u8) -> Self {
        Self { number, value: f64::from(value) / 127.0, fine: false }
    }
    fn fine(number: u8, upper: u8, lower: u8) -> Self {
        let long = u16::from(upper) << 7 | u16::from(lower);
        Self { number, value: f64::from(long) / 16_383.0, fine: true }
    }
}

/// Controllers, pitch wheel, pressure, bend range and chosen parameter of a channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip {
    values: [u8; 128],
    /// Controllers of 14 bits whose upper half came last, a bit each: their lower half is awaited.
    halves: u32,
    pub bend: i16,
    pub pressure: u8,
    pub range: Range,
    pub selection: Selection,
    /// Those that are listened to by their numbers.
    pub claimed: Own,
}

impl Default for Strip {
    fn default() -> Self {
        Self {
            values: [NEVER; 128],
            halves: 0,
            bend: 0,
            pressure: 0,
            range: Range::TWO,
            selection: Selection::default(),
            claimed: Own::default(),
        }
    }
}

impl Strip {
    fn value(&self, number: u8) -> Option<u8> {
        self.values.get(usize::from(number)).copied().filter(|v| *v != NEVER)
    }
    fn set(&mut self, number: u8, value: u8) {
        if let Some(slot) = self.values.get_mut(usize::from(number)) {
            *slot = value;
        }
    }

    /// Notes where a controller stands; gives what an ordinary one, or one that is claimed, moved to.
    ///
    /// Controllers 0 to 31 may have seven more bits in those from 32 to 63. The upper half applies at once, as upper / 127; the lower half refines
    /// it to (128 upper + lower) / 16,383. The first of these always lies among the values that the second can have, and both reach 0 and 1. Where
    /// lower halves come, an upper half moves it no further than to the nearest of the values that it leaves open, so that a fader that rises never
    /// seems to fall; a second one without a lower half between them is one of 7 bits again. A controller from 32 to 63 that is claimed itself, or
    /// whose partner never moved on this channel, is one of 7 bits of its own: there are boxes that send them so.
    pub fn controller(&mut self, number: u8, value: u8) -> Option<Moved> {
        let moved = match number {
            0..32 => self.upper(number, value),
            32..64 => match self.value(number - 32).filter(|_| !self.claimed.has(number)) {
                Some(upper) => {
                    self.halves &= !(1 << (number - 32));
                    Moved::fine(number - 32, upper, value)
                }
                None => Moved::coarse(number, value),
            },
            _ => Moved::coarse(number, value),
        };
        self.set(number, value);
        let ordinary = !parameter::concerns(number)
            && ![SUSTAIN, SOSTENUTO].contains(&number)
            && !BANK.contains(&number);
        Some(moved).filter(|_| (ordinary || self.claimed.takes(number)) && number < MODES)
    }

    /// The upper half of a controller, or all of it. What the lower one stands at then is noted.
    fn upper(&mut self, number: u8, value: u8) -> Moved {
        let (before, bit) = (self.value(number), 1_u32 << number);
        let known = self.value(number + 32).filter(|_| !self.claimed.has(number + 32));
        let (Some(before), Some(lower)) = (before, known) else { return Moved::coarse(number, value) };
        if number == BANK[0] {
            // No fader: the standard's nought.
            self.set(BANK[1], 0);
            return Moved::coarse(number, value);
        }
        if self.halves & bit != 0 && value != before {
            self.set(number + 32, NEVER);
            self.halves &= !bit;
            return Moved::coarse(number, value);
        }
        self.halves |= bit;
        let nearest = match value.cmp(&before) {
            Ordering::Less => 127,
            Ordering::Equal => lower,
            Ordering::Greater => 0,
        };
        self.set(number + 32, nearest);
        Moved::fine(number, value, nearest)
    }

    /// Semitones, with both ends of the wheel exact: −8192 and 8191 are the whole range.
    pub fn bend_semitones(&self) -> f64 {
        let end = if self.bend < 0 { 8192.0 } else { 8191.0 };
        f64::from(self.bend) / end * self.range.as_semitones()
    }
    /// 0 to 127; 64 at rest.
    pub fn timbre(&self) -> u8 {
        self.value(TIMBRE).unwrap_or(64)
    }
    /// Whether a pedal is down: from 64 on. One that is claimed is none.
    pub fn pedal(&self, number: u8) -> bool {
        self.value(number).is_some_and(|v| v >= 64) && !self.claimed.has(number)
    }
    /// 14 bits; 0 where none was chosen.
    pub fn bank(&self) -> u16 {
        let chosen = |n: u8| self.value(n).filter(|_| !self.claimed.takes(n)).unwrap_or(0);
        let [upper, lower] = BANK.map(|n| u16::from(chosen(n)));
        upper << 7 | lower
    }

    /// What a player's hands and feet hold goes to rest; what was set up stays.
    pub fn rest(&mut self) {
        (self.bend, self.pressure) = (0, 0);
        [SUSTAIN, SOSTENUTO, TIMBRE].into_iter().for_each(|n| self.set(n, NEVER));
        self.selection.close();
    }

    /// Reset All Controllers, after RP-015: wheel, pressure, pedals, modulation, expression, chosen parameter. Volume, pan, sounds (70 to 79,
    /// so timbre too), effects, bank and bend range stay. Gives the controllers that this moves, as [`Strip::controller`] does.
    pub fn reset(&mut self) -> impl Iterator<Item = Moved> + use<> {
        (self.bend, self.pressure) = (0, 0);
        self.selection.close();
        RESETS
            .map(|(number, value)| {
                let pair = number < 32 && !self.claimed.has(number + 32);
                let fine = pair.then(|| self.value(number + 32)).flatten().unwrap_or(0);
                let stands = self.value(number).filter(|_| !self.claimed.steps(number));
                stands.filter(|stands| *stands != value || fine != 0)?;
                if pair {
                    self.set(number + 32, NEVER);
                    self.halves &= !(1 << number);
                }
                self.controller(number, value)
            })
            .into_iter()
            .flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::{Moved, Range, Strip};
    use crate::midi::channel::Channel;
    use crate::midi::claims::Claims;

    fn coarse(number: u8, value: f64) -> Option<Moved> {
        Some(Moved { number, value, fine: false })
    }

    #[test]
    fn the_upper_half_applies_and_the_lower_refines() {
        let mut strip = Strip::default();
        assert_eq!(strip.controller(33, 127), coarse(33, 1.0), "without a partner it is an ordinary one");
        assert_eq!(strip.controller(1, 64), coarse(1, 64.0 / 127.0));
        let fine = |value: u16| Some(Moved { number: 1, value: f64::from(value) / 16_383.0, fine: true });
        assert_eq!(strip.controller(33, 5), fine(64 << 7 | 5));
        assert_eq!(strip.controller(33, 6), fine(64 << 7 | 6));
        assert_eq!(strip.controller(1, 126), fine(126 << 7), "as little as may be");
        assert_eq!(strip.controller(1, 126), fine(126 << 7), "it stands");
        assert_eq!(strip.controller(1, 127), coarse(1, 1.0), "the lower half comes no more");
        assert_eq!(strip.controller(33, 127), fine(16_383));
        assert_eq!(fine(16_383).map(|m| m.value), Some(1.0));
        for upper in 0..128 {
            strip = Strip::default();
            let once = strip.controller(1, upper).unwrap().value;
            let range = [0, 127].map(|lower| strip.controller(33, lower).unwrap().value);
            assert!((range[0]..=range[1]).contains(&once), "{upper}");
        }
    }

    /// A fader of 14 bits that rises is never told to fall, nor the other way round, and ends where it stands.
    #[test]
    fn a_fader_moves_one_way() {
        let mut strip = Strip::default();
        let mut move_to = |long: u16| {
            let [upper, lower] = [long >> 7, long & 127].map(|half| half as u8);
            [strip.controller(1, upper), strip.controller(33, lower)].map(|moved| moved.unwrap().value)
        };
        let mut before = move_to(0)[1];
        for long in (0..16_384).step_by(3) {
            let now = move_to(long);
            assert!(before <= now[0] && now[0] <= now[1], "{long}: {before} {now:?}");
            assert_eq!(now[1], f64::from(long) / 16_383.0);
            before = now[1];
        }
        for long in (0..16_384).step_by(7).map(|n| 16_383 - n) {
            let now = move_to(long);
            assert!(before >= now[0] && now[0] >= now[1], "{long}: {before} {now:?}");
            before = now[1];
        }
    }

    #[test]
    fn what_has_a_meaning_of_its_own_is_no_ordinary_controller() {
        let not = |n: u8| Strip::default().controller(n, 1).is_none();
        let special: Vec<u8> = (0..128).filter(|n| not(*n)).collect();
        let expected: Vec<u8> = [0, 6, 32, 38, 64, 66].into_iter().chain(96..=101).chain(120..128).collect();
        assert_eq!(special, expected);
    }

    #[test]
    fn what_is_claimed_has_no_other_meaning() {
        let mut claims = Claims::default();
        (0..128).for_each(|number| claims.add(number, None));
        let mut strip = Strip { claimed: claims.of(Channel::FIRST), ..Strip::default() };
        for number in 0..128 {
            let expected = if number < 120 { coarse(number, 1.0) } else { None };
            assert_eq!(strip.controller(number, 127), expected, "each for itself, halves too");
        }
        assert!(!strip.pedal(64) && !strip.pedal(66) && strip.bank() == 0);
        let moved: Vec<u8> = strip.reset().map(|m| m.number).collect();
        assert_eq!(moved, [1, 64, 65, 66, 67], "11 stands there");
        assert_eq!(strip.value(33), Some(127), "no half of 1");
        // What tells steps stands nowhere.
        claims.add_steps(1, None);
        let mut strip = Strip { claimed: claims.of(Channel::FIRST), ..Strip::default() };
        assert_eq!([1, 33].map(|number| strip.controller(number, 127)), [coarse(1, 1.0), coarse(33, 1.0)]);
        assert_eq!(strip.reset().count(), 0);
        // A pair of which the upper half is claimed.
        let mut claims = Claims::default();
        claims.add(6, None);
        let mut strip = Strip { claimed: claims.of(Channel::FIRST), ..Strip::default() };
        assert_eq!(strip.controller(6, 1), coarse(6, 1.0 / 127.0));
        let fine = Some(Moved { number: 6, value: f64::from(128 + 2) / 16_383.0, fine: true });
        assert_eq!(strip.controller(38, 2), fine);
    }

    #[test]
    fn banks_have_two_halves() {
        let mut strip = Strip::default();
        assert_eq!(strip.bank(), 0);
        strip.controller(0, 2);
        strip.controller(32, 3);
        assert_eq!(strip.bank(), 2 << 7 | 3);
        strip.controller(0, 1);
        assert_eq!(strip.bank(), 1 << 7);
    }

    #[test]
    fn the_wheel_reaches_both_ends_of_its_range() {
        let mut strip = Strip::default();
        let mut at = |bend, range| {
            (strip.bend, strip.range) = (bend, range);
            strip.bend_semitones()
        };
        assert_eq!(at(8191, Range::TWO), 2.0);
        assert_eq!(at(-8192, Range::TWO), -2.0);
        assert_eq!(at(-4096, Range::MEMBER), -24.0);
        assert_eq!(at(8191, Range { semitones: 1, cents: 50 }), 1.5);
        assert_eq!(Range::TWO.step(-1), Range { semitones: 1, cents: 99 });
        assert_eq!(Range { semitones: 127, cents: 99 }.step(1), Range { semitones: 127, cents: 99 });
        assert_eq!(Range { semitones: 0, cents: 0 }.step(-1), Range { semitones: 0, cents: 0 });
        assert_eq!(Range { semitones: 127, cents: 127 }.step(1), Range { semitones: 127, cents: 99 });
    }

    #[test]
    fn a_reset_moves_what_had_moved_and_leaves_what_rp_015_leaves() {
        let mut strip = Strip::default();
        assert_eq!(strip.reset().count(), 0, "nothing had moved");
        for (number, value) in [(1, 9), (7, 9), (10, 9), (11, 9), (67, 9), (74, 9), (64, 127), (0, 3)] {
            strip.controller(number, value);
        }
        (strip.bend, strip.pressure, strip.range) = (5, 5, Range::MEMBER);
        let moved: Vec<(u8, f64)> = strip.reset().map(|m| (m.number, m.value)).collect();
        assert_eq!(moved, [(1, 0.0), (11, 1.0), (67, 0.0)]);
        assert_eq!((strip.bend, strip.pressure, strip.timbre(), strip.bank()), (0, 0, 9, 3 << 7));
        assert!(!strip.pedal(64) && strip.range == Range::MEMBER);
        assert_eq!(strip.reset().count(), 0, "it stands there now");
        strip.controller(1, 0);
        strip.controller(33, 1);
        assert_eq!(strip.reset().map(|m| m.number).collect::<Vec<_>>(), [1], "its lower half");
    }
}
