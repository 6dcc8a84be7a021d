//! A whole step of a flow as numbers: what each input adds to current, speed and angle.

use super::flow::{Change, Flow, Motion, Push};

/// By input (current, speed, volts, torque, slope and curve of the torque): what it adds.
pub(super) type Row = [f64; 6];

/// A step. Angles are in turns.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Table {
    pub current: Row,
    pub speed: Row,
    pub turns: Row,
    /// Until half of the step.
    pub half: Row,
    /// What the beginning of the step would do to the speed in all of it: of current, speed and torque.
    pub begins: [f64; 3],
}

impl Table {
    pub fn of(flow: &Flow, period: f64) -> Self {
        let (whole, half) = (flow.over(period), flow.over(0.5 * period));
        let mut table = Self::default();
        for input in 0..6 {
            let unit = |n: usize| f64::from(u8::from(n == input));
            let push = Push { volts: unit(2), torque: unit(3), slope: unit(4), curve: unit(5) };
            let mut x = Motion { current: unit(0), speed: unit(1) };
            // Where speed and voltage dictate the current, the one there was is replaced.
            let before = x.current;
            let dictated = flow.dictated(x.speed, push.volts);
            x.current = dictated.unwrap_or(x.current);
            let rates = flow.rates(x, &push);
            let end: Change = whole.change(rates, x.speed, &push);
            table.current[input] = end.current + (x.current - before);
            table.speed[input] = end.speed;
            table.turns[input] = end.angle / std::f64::consts::TAU;
            table.half[input] = half.change(rates, x.speed, &push).angle / std::f64::consts::TAU;
        }
        // Of the current as it is, whatever dictates it.
        for (n, begins) in table.begins.iter_mut().enumerate() {
            let unit = |m: usize| f64::from(u8::from(m == n));
            let push = Push { torque: unit(2), ..Push::default() };
            *begins = period * flow.rates(Motion { current: unit(0), speed: unit(1) }, &push).speed;
        }
        table
    }
}

/// What current, speed, volts and a torque add.
#[inline(always)]
pub(super) fn held(row: &Row, x: Motion, volts: f64, torque: f64) -> f64 {
    ((row[0] * x.current + row[1] * x.speed) + row[2] * volts) + row[3] * torque
}

/// What all inputs add.
#[inline(always)]
pub(super) fn all(row: &Row, x: Motion, push: &Push) -> f64 {
    held(row, x, push.volts, push.torque) + (row[4] * push.slope + row[5] * push.curve)
}
