//! Many steps at once, and a step at rest: the same as one by one, to the bit, and quicker.

use super::drive::{Drive, MOST_DRIVE};
use super::model::{Grip, Motor, NOTHING, Regime};
use super::swift::{MIDPOINT, Method, NONE, PARABOLA};

impl<const BOOKED: bool> Motor<BOOKED> {
    /// As many steps as there are voltages, and what is wanted of each: it is told the current (A), the speed (rad/s) and the angle (turns
    /// within ±½). The same as one by one, and faster.
    pub fn run(&mut self, volts: &[f64], mut seen: impl FnMut(f64, f64, f64)) {
        let mut left = volts.iter();
        while let Some(first) = left.next() {
            // By the way that can do everything; then by the short one as long as it goes.
            self.drive(Drive::Voltage(*first));
            self.step();
            let state = &self.state;
            seen(state.current, state.speed, state.phase);
            if self.grip == Grip::Sticks || self.mount.is_some() || BOOKED {
                continue;
            }
            let smooth = self.grip == Grip::None;
            match (self.method, self.rotor.inductance == 0.0) {
                (Method::None, true) => self.rush::<NONE, true, true>(&mut left, &mut seen),
                (Method::None, _) if smooth => self.rush::<NONE, false, false>(&mut left, &mut seen),
                (Method::None, _) => self.rush::<NONE, false, true>(&mut left, &mut seen),
                (Method::Midpoint, true) => self.rush::<MIDPOINT, true, true>(&mut left, &mut seen),
                (Method::Midpoint, _) if smooth => self.rush::<MIDPOINT, false, false>(&mut left, &mut seen),
                (Method::Midpoint, _) => self.rush::<MIDPOINT, false, true>(&mut left, &mut seen),
                (Method::Parabola, true) => self.rush::<PARABOLA, true, true>(&mut left, &mut seen),
                (Method::Parabola, _) if smooth => self.rush::<PARABOLA, false, false>(&mut left, &mut seen),
                (Method::Parabola, _) => self.rush::<PARABOLA, false, true>(&mut left, &mut seen),
            }
        }
    }

    /// Steps until one in which something may happen, which is left. `FULL` and `DRY` as in [`Swift::step`](super::swift::Swift::step); `FULL` without inductance.
    #[inline(always)]
    fn rush<const METHOD: u8, const FULL: bool, const DRY: bool>(
        &mut self,
        left: &mut std::slice::Iter<'_, f64>,
        seen: &mut impl FnMut(f64, f64, f64),
    ) {
        let (swift, flow, mut state, mut last) = (self.swift, self.flows[0], self.state, self.volts);
        let all = left.as_slice();
        let mut rest = all.iter();
        while let Some(volts) = rest.clone().next().filter(|v| v.abs() <= MOST_DRIVE) {
            let mut from = state;
            if FULL && *volts != last {
                from.current = flow.dictated(state.speed, *volts).unwrap_or(state.current);
            }
            let Some((next, _)) = swift.step::<METHOD, FULL, DRY>(&from, *volts) else { break };
            state = next;
            if FULL {
                last = *volts;
            }
            rest.next();
            seen(state.current, state.speed, state.phase);
        }
        self.state = state;
        if let Some(volts) = all[..all.len() - rest.len()].last() {
            (self.drive, self.volts) = (Drive::Voltage(*volts), *volts);
        }
        *left = rest;
    }

    /// Whether it stays at rest for a step, in a common case; if so, that step is done.
    #[inline]
    pub(super) fn stays(&mut self) -> bool {
        let (from, volts) = (self.state.current, self.volts);
        if BOOKED || self.mount.is_some() || matches!(self.drive, Drive::Current { .. }) {
            return false;
        }
        let to = match self.regime {
            Regime::Held => from,
            Regime::Coil => from + self.settles * (volts / self.rotor.resistance - from),
        };
        let holds =
            |current: f64| (self.rotor.gain * current + self.state.pull).abs() <= self.parameters.stiction;
        let stays = holds(from) && holds(to);
        if stays {
            self.state.current = if to.abs() < NOTHING { 0.0 } else { to };
        }
        stays
    }
}
