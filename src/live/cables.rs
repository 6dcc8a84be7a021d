//! The cables of MIDI: whether those are there that had promised to say so.

use std::time::Duration;

use super::stamp::Stamp;
use crate::midi::Message;
use crate::midi::sensing::Sensing;
use crate::performer::PORTS;

/// Between two looks there is no more time than this, or the machine stood still.
const STANDSTILL: Duration = Duration::from_millis(50);

/// Those of all ports. Any thread may say what comes, and none waits.
#[derive(Debug)]
pub struct Cables(Box<[Sensing]>);

impl Default for Cables {
    fn default() -> Self {
        Self((0..PORTS).map(|_| Sensing::default()).collect())
    }
}

impl Cables {
    /// Bytes came through a port, whatever they mean.
    pub fn heard(&self, port: u16, now: Stamp) {
        self.of(port).heard(time(now));
    }

    /// A message did.
    pub(super) fn message(&self, port: u16, now: Stamp, message: Message) {
        self.of(port).message(time(now), message);
    }

    /// Whether the cable of a port had promised to stay. It has not any more.
    pub(super) fn take_promise(&self, port: u16) -> bool {
        self.of(port).take_promise()
    }

    /// Ports that are beyond the last share its cable, as they do its hands.
    fn of(&self, port: u16) -> &Sensing {
        &self.0[usize::from(port).min(PORTS - 1)]
    }
}

/// Looks after them, again and again.
#[derive(Debug, Default)]
pub(super) struct Watch {
    looked: Duration,
    gaps: u64,
}

impl Watch {
    /// The ports whose cables are lost by now. `gaps` counts what was left out on the way: while it grows, and where nobody looked for long, silence
    /// says nothing.
    pub fn look<'a>(
        &mut self,
        cables: &'a Cables,
        now: Stamp,
        gaps: u64,
    ) -> impl Iterator<Item = u16> + use<'a> {
        let now = time(now);
        let unfair = gaps != self.gaps || now.saturating_sub(self.looked) > STANDSTILL;
        *self = Self { looked: now, gaps };
        if unfair {
            cables.0.iter().for_each(|cable| cable.forgive(now));
        }
        (0..).zip(&cables.0).filter(move |(_, cable)| cable.is_lost(now)).map(|(port, _)| port)
    }
}

fn time(stamp: Stamp) -> Duration {
    Duration::from_nanos(stamp.0)
}

#[cfg(test)]
mod tests {
    use super::{Cables, Message, Stamp, Watch};

    const NONE: [u16; 0] = [];

    /// Milliseconds at which the watch looks, the gaps that it is told of then, and what it finds.
    fn found(cables: &Cables, watch: &mut Watch, at: u64, gaps: u64) -> Vec<u16> {
        watch.look(cables, Stamp(at * 1_000_000), gaps).collect()
    }

    #[test]
    fn a_cable_that_is_lost_is_found_once_and_no_other() {
        let (cables, mut watch) = (Cables::default(), Watch::default());
        cables.message(3, Stamp(0), Message::ActiveSensing);
        cables.message(9, Stamp(0), Message::Clock);
        for at in (0..=330).step_by(5) {
            assert_eq!(found(&cables, &mut watch, at, 0), NONE, "{at} ms");
        }
        assert_eq!(found(&cables, &mut watch, 335, 0), [3]);
        assert_eq!(found(&cables, &mut watch, 340, 0), NONE);
        // A port beyond all others.
        cables.message(u16::MAX, Stamp(340_000_000), Message::ActiveSensing);
        assert!(cables.take_promise(900));
    }

    #[test]
    fn neither_a_machine_that_stood_still_nor_what_was_left_out_is_silence() {
        let (cables, mut watch) = (Cables::default(), Watch::default());
        cables.message(0, Stamp(0), Message::ActiveSensing);
        assert_eq!(found(&cables, &mut watch, 40, 0), NONE);
        assert_eq!(found(&cables, &mut watch, 400, 0), NONE, "nobody looked");
        for at in (410..=640).step_by(10) {
            assert_eq!(found(&cables, &mut watch, at, 0), NONE, "{at} ms");
        }
        assert_eq!(found(&cables, &mut watch, 650, 1), NONE, "a gap");
        for at in (660..=980).step_by(10) {
            assert_eq!(found(&cables, &mut watch, at, 1), NONE, "{at} ms");
        }
        assert_eq!(found(&cables, &mut watch, 990, 1), [0]);
    }
}
