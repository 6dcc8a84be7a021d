//! In which order what arrives takes effect: as it arrived, though the clock be set anew in between.
//!
//! Within one [`Moment`] of the stream's clock, what arrives later takes effect later. The next moment may place the same arrival a little sooner, or
//! much sooner where a device was away: then a key that goes up would overtake its going down. So nothing that arrives takes effect before what the
//! last moments would have made of it, as far as they were asked.

use std::collections::VecDeque;

use super::clock::Moment;
use super::stamp::Stamp;

/// Moments that are remembered. One more comes with each callback; more than two are only needed where something was sent ahead of its time.
const KEPT: usize = 8;

/// What has taken effect of late, and when.
#[derive(Debug, Default)]
pub(super) struct Sequence(VecDeque<Given>);

/// What was asked of a moment.
#[derive(Debug, Clone, Copy)]
struct Given {
    moment: Moment,
    /// The latest arrival, and the frame at which it takes effect.
    stamp: Stamp,
    frame: f64,
}

impl Sequence {
    /// The frame at which something takes effect that arrived at `stamp`, or is meant for then, where it is `now`; what arrives later does not
    /// overtake it.
    pub fn take(&mut self, moment: Moment, stamp: Stamp, now: Stamp) -> f64 {
        let frame = self.see(moment, stamp, now);
        match self.0.back_mut().filter(|given| given.moment == moment) {
            Some(last) if last.stamp <= stamp => (last.stamp, last.frame) = (stamp, frame),
            Some(_) => {}
            None => {
                if self.0.len() == KEPT {
                    self.0.pop_front();
                }
                self.0.push_back(Given { moment, stamp, frame });
            }
        }
        frame
    }

    /// The same of what nothing has to wait for.
    pub fn see(&self, moment: Moment, stamp: Stamp, now: Stamp) -> f64 {
        let made = |given: &Given| match stamp >= given.stamp {
            true => given.frame,
            false => given.moment.frame_of(stamp, now),
        };
        self.0.iter().map(made).fold(moment.frame_of(stamp, now), f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::{Moment, Sequence, Stamp};

    fn moment(frames: u64, time: f64) -> Moment {
        Moment { frames, time, frame: 1.0 / 48_000.0, ahead: 64 }
    }

    fn stamp(seconds: f64) -> Stamp {
        Stamp((seconds * 1e9) as u64)
    }

    /// Arrivals in order, each by another moment that is a little early or late, now and then with something that was sent ahead of its time, and
    /// with what only looks at the time.
    #[test]
    fn what_arrives_later_takes_effect_later() {
        let (mut sequence, mut state) = (Sequence::default(), 1_u64);
        let mut noise = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut all: Vec<(f64, f64)> = Vec::new();
        let mut now = moment(0, 1.0);
        for n in 0..20_000_u64 {
            let seconds = 1.0 + 50e-6 * n as f64;
            if n % 26 == 0 {
                // A tenth of a millisecond to either side of where it was.
                now = moment((seconds * 48_000.0) as u64 - 48_000, seconds + 1e-4 * (2.0 * noise() - 1.0));
            }
            // What looks a little later than this arrived.
            sequence.see(now, stamp(seconds + 40e-6), stamp(seconds + 40e-6));
            if n % 100 == 50 {
                sequence.take(now, stamp(seconds + 0.001), stamp(seconds));
            }
            all.push((seconds, sequence.take(now, stamp(seconds), stamp(seconds))));
        }
        assert!(all.windows(2).all(|w| w[0].1 <= w[1].1), "one overtakes the one before");
        for (seconds, frame) in all {
            let off = frame - ((seconds - 1.0) * 48_000.0 + 64.0);
            assert!(off.abs() < 12.0, "{seconds}: {off} frames off");
        }
    }

    #[test]
    fn a_clock_that_is_set_back_is_waited_for() {
        let mut sequence = Sequence::default();
        let far = sequence.take(moment(10_000, 1.0), stamp(1.0), stamp(1.0));
        for n in 1..200 {
            // Callbacks go on, 200 ms behind.
            let at = 1.0 + 0.001 * f64::from(n);
            let frame = sequence.take(moment(400 + 48 * n as u64, at), stamp(at), stamp(at));
            assert!(frame >= far, "{n}: {frame} {far}");
        }
        // What had arrived before, and is only found now, is where it belongs.
        assert!(sequence.take(moment(10_048, 1.201), stamp(0.9), stamp(1.201)) < far);
    }
}
