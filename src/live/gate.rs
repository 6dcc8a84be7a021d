//! The gate: the last thing before the device. It lets the output in gently, holds it down until the user says that actuators and not
//! headphones hang there, and closes at once when asked.
//!
//! All it does is a function of frames and of what it was told at which frame, so a replay opens and closes as the session did.

#![deny(clippy::disallowed_methods)]

use crate::engine;
use crate::engine::stage::Stage;
use crate::live::steps::{Rounding, Steps};

/// Where a gate is told to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Open within [`RAMP_IN`]; a latch stays, and so does [`Order::Close`].
    Open,
    /// Open within [`RAMP_BACK`], after [`Order::Close`], since the device was away; a latch stays.
    Return,
    /// Close within [`RAMP_OUT`] and stay closed until [`Order::Release`].
    Latch,
    /// Takes back a latch, and opens within [`RAMP_IN`], but for [`Order::Close`].
    Release,
    /// Close within [`RAMP_OUT`] and stay closed until [`Order::Return`].
    Close,
    /// Go to this gain, from 0 to 1, within [`RAMP_IN`].
    Gain(f32),
}

/// Seconds in which the output comes in.
pub const RAMP_IN: f64 = 0.2;

/// Seconds in which it comes back after the device was away.
pub const RAMP_BACK: f64 = 0.02;

/// Seconds in which motors are braked behind a gate that is to close: what turns them comes through as before, and then nothing does.
pub const BRAKING: f64 = engine::BRAKING;

/// Seconds in which it goes out. A callback that is told so ends in exact zeros after as many frames.
pub const RAMP_OUT: f64 = 0.002;

/// Until the user arms the output: -20 dB.
pub const UNARMED: f32 = 0.1;

/// A gain that moves to where it is told, in a curve without corners.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    from: f32,
    to: f32,
    /// Frames done, and frames in all.
    done: u32,
    length: u32,
}

impl Ramp {
    fn resting(value: f32) -> Self {
        Self { from: value, to: value, done: 0, length: 0 }
    }

    fn rests(&self) -> bool {
        self.done >= self.length
    }

    fn value(&self) -> f32 {
        if self.rests() {
            return self.to;
        }
        let x = self.done as f32 / self.length as f32;
        // Rounding must not carry it past its ends: a gain of more than 1 would be more than what may leave.
        let (least, most) = if self.from < self.to { (self.from, self.to) } else { (self.to, self.from) };
        (self.from + (self.to - self.from) * (x * x * (3.0 - 2.0 * x))).max(least).min(most)
    }

    fn go(&mut self, to: f32, frames: f64) {
        let from = self.value();
        if from == to {
            *self = Self::resting(to);
        } else {
            *self = Self { from, to, done: 0, length: (frames.ceil() as u32).max(1) };
        }
    }

    fn step(&mut self) -> f32 {
        if !self.rests() {
            self.done += 1;
        }
        self.value()
    }
}

/// The gate of a device.
#[derive(Debug)]
pub struct Gate {
    rate: f64,
    /// Open or closed, and how loud.
    open: Ramp,
    gain: Ramp,
    latched: bool,
    /// The device is away, or all is over.
    closed: bool,
    /// Channels of motors (from 0), what lets them through while they are braked, and for how many frames they still are.
    motors: Vec<bool>,
    /// Channels of pulses (from 0), which others count on: they are whole as soon as it opens.
    pulses: Vec<bool>,
    kept: f32,
    braking: u32,
    rounding: Rounding,
}

impl Gate {
    /// Closed, for frames at `rate`; open, it has the gain `gain`.
    pub fn new(rate: f64, gain: f32) -> Self {
        let (open, gain) = (Ramp::resting(0.0), Ramp::resting(gain));
        let (motors, pulses) = (Vec::new(), Vec::new());
        let rounding = Rounding::none(0);
        Self {
            rate,
            open,
            gain,
            latched: false,
            closed: false,
            motors,
            pulses,
            kept: 0.0,
            braking: 0,
            rounding,
        }
    }

    /// The same, of so many channels with motors and pulses on those of `stage`. Where it closes, motors come through for [`BRAKING`] as they did before, as
    /// whoever turns them brakes them then ([`Engine::hold_motors`](crate::engine::Engine::hold_motors)), and exact zeros after that. Where it opens,
    /// pulses do not come in slowly: a pulse that is not as high as others is none to an amplifier.
    pub fn before(mut self, width: usize, stage: &Stage) -> Self {
        (self.motors, self.pulses) = (vec![false; width], vec![false; width]);
        self.rounding = Rounding::none(width);
        self.stands_before(stage);
        self
    }

    /// From the next frame on, motors and pulses are on the channels of `stage`, and rounding adds nothing to the most that leaves it.
    pub fn stands_before(&mut self, stage: &Stage) {
        mark(&mut self.motors, stage.drives().channels());
        mark(&mut self.pulses, stage.pulsed());
        self.rounding.below(stage.levels());
    }

    /// From the next frame on, the device takes samples in these steps.
    pub fn round_to(&mut self, steps: Steps) {
        self.rounding.to(steps);
    }

    /// Whether nothing may leave, so that motors must stand.
    pub fn holds(&self) -> bool {
        self.latched || self.closed
    }

    /// Does as told, from the next frame on.
    pub fn order(&mut self, order: Order) {
        match order {
            Order::Latch => self.latched = true,
            Order::Release => self.latched = false,
            Order::Close => self.closed = true,
            Order::Return => self.closed = false,
            _ => {}
        }
        let (to, seconds) = match order {
            Order::Gain(gain) => {
                let gain = if gain.is_finite() { gain.clamp(0.0, 1.0) } else { 0.0 };
                self.gain.go(gain, RAMP_IN * self.rate);
                return;
            }
            Order::Latch | Order::Close => (0.0, RAMP_OUT),
            _ if self.latched || self.closed => return,
            Order::Return => {
                // A gain that it was told while nothing came through need not be gone to: it is there.
                if self.is_shut() {
                    self.gain = Ramp::resting(self.gain.to);
                }
                (1.0, RAMP_BACK)
            }
            Order::Open | Order::Release => (1.0, RAMP_IN),
        };
        if to == 0.0 && self.open.to != 0.0 && self.motors.contains(&true) {
            (self.kept, self.braking) = (self.open.value(), (BRAKING * self.rate).floor() as u32);
        } else if to != 0.0 {
            self.braking = 0;
        }
        self.open.go(to, seconds * self.rate);
    }

    /// Whether it was latched and not yet released.
    pub fn is_latched(&self) -> bool {
        self.latched
    }

    /// Whether nothing comes through and nothing will until it is told.
    pub fn is_shut(&self) -> bool {
        self.open.rests() && self.open.to == 0.0 && self.braking == 0
    }

    /// The gain with which the next frame comes through, were it not for the ramp.
    pub fn gain(&self) -> f32 {
        self.open.to * self.gain.to
    }

    /// How far it is open, 0 to 1, whatever its gain.
    pub fn opening(&self) -> f32 {
        self.open.value()
    }

    /// Lets frames of so many channels through, in the steps of the device.
    pub fn pass(&mut self, frames: &mut [f32], channels: usize) {
        self.scale(frames, channels);
        self.rounding.round(frames);
    }

    fn scale(&mut self, frames: &mut [f32], channels: usize) {
        let mut rest = frames;
        let opens = self.open.to > 0.0 && self.pulses.contains(&true);
        while !self.open.rests() || !self.gain.rests() || self.braking > 0 {
            if rest.is_empty() {
                return;
            }
            let (open, gain) = (self.open.step(), self.gain.step());
            let (frame, others) = rest.split_at_mut(channels.clamp(1, rest.len()));
            if self.braking > 0 || opens {
                for (channel, value) in frame.iter_mut().enumerate() {
                    let is = |marked: &[bool]| marked.get(channel) == Some(&true);
                    let open = match () {
                        () if self.braking > 0 && is(&self.motors) => self.kept,
                        () if opens && is(&self.pulses) => self.open.to,
                        () => open,
                    };
                    scale(std::slice::from_mut(value), open * gain);
                }
                self.braking = self.braking.saturating_sub(1);
            } else {
                scale(frame, open * gain);
            }
            rest = others;
        }
        scale(rest, self.open.value() * self.gain.value());
    }
}

/// Marks these channels, and no others.
fn mark(marks: &mut [bool], channels: impl Iterator<Item = usize>) {
    marks.fill(false);
    for channel in channels {
        marks.iter_mut().skip(channel).take(1).for_each(|mark| *mark = true);
    }
}

/// Zero is exact, whatever stood there; one leaves all as it is.
fn scale(values: &mut [f32], gain: f32) {
    if gain == 0.0 {
        values.fill(0.0);
    } else if gain != 1.0 {
        values.iter_mut().for_each(|value| *value *= gain);
    }
}

#[cfg(test)]
mod tests {
    use super::{Gate, Order, UNARMED};

    const RATE: f64 = 48_000.0;

    fn pass(gate: &mut Gate, frames: usize) -> Vec<f32> {
        let mut block = vec![1.0; 2 * frames];
        gate.pass(&mut block, 2);
        assert!(block.chunks(2).all(|frame| frame[0] == frame[1]));
        block.into_iter().step_by(2).collect()
    }

    #[test]
    fn it_opens_gently_and_then_leaves_all_as_it_is() {
        let mut gate = Gate::new(RATE, 1.0);
        assert_eq!(pass(&mut gate, 100), [0.0; 100]);
        gate.order(Order::Open);
        let rising = pass(&mut gate, 9600);
        assert!(rising.windows(2).all(|w| (0.0..2e-4).contains(&(w[1] - w[0]))));
        assert!(rising[0] < 1e-6 && (rising[4799] - 0.5).abs() < 1e-3);
        assert_eq!(rising[9599], 1.0);
        let mut odd = [0.1, -0.7, f32::MIN_POSITIVE, 1.0];
        gate.pass(&mut odd, 2);
        assert_eq!(odd, [0.1, -0.7, f32::MIN_POSITIVE, 1.0]);
    }

    #[test]
    fn a_latch_ends_in_exact_zeros_and_holds() {
        let mut gate = Gate::new(RATE, 1.0);
        gate.order(Order::Open);
        pass(&mut gate, 9600);
        gate.order(Order::Latch);
        let falling = pass(&mut gate, 200);
        // Two milliseconds: 96 frames.
        assert!(falling[..95].iter().all(|&x| x > 0.0) && falling[96..].iter().all(|&x| x == 0.0));
        for order in [Order::Open, Order::Return, Order::Gain(1.0)] {
            gate.order(order);
            assert_eq!(pass(&mut gate, 10_000), [0.0; 10_000], "{order:?}");
        }
        assert!(gate.is_latched() && gate.is_shut());
        gate.order(Order::Release);
        assert_eq!(pass(&mut gate, 9600)[9599], 1.0);
        // What is no number does not come through a closed gate either.
        gate.order(Order::Close);
        pass(&mut gate, 96);
        let mut wild = [f32::NAN, f32::INFINITY];
        gate.pass(&mut wild, 2);
        assert_eq!(wild, [0.0, 0.0]);
    }

    #[test]
    fn what_is_closed_while_the_device_is_away_comes_in_when_it_is_back_and_not_before() {
        // Whatever happens meanwhile.
        for meanwhile in
            [vec![], vec![Order::Open], vec![Order::Latch, Order::Release], vec![Order::Gain(0.5)]]
        {
            let mut gate = Gate::new(RATE, 1.0);
            gate.order(Order::Close);
            for order in &meanwhile {
                gate.order(*order);
                assert_eq!(pass(&mut gate, 10_000), [0.0; 10_000], "{order:?}");
            }
            gate.order(Order::Return);
            let rising = pass(&mut gate, 961);
            assert!(rising[0] < 1e-5 && rising.windows(2).all(|w| w[1] - w[0] < 2e-3), "{meanwhile:?}");
            assert!(rising[960] >= 0.5);
        }
        // A brake that was pulled and not let go holds.
        let mut gate = Gate::new(RATE, 1.0);
        for order in [Order::Open, Order::Close, Order::Latch, Order::Return] {
            gate.order(order);
        }
        assert_eq!(pass(&mut gate, 10_000), [0.0; 10_000]);
        gate.order(Order::Release);
        assert_eq!(pass(&mut gate, 9600)[9599], 1.0);
    }

    #[test]
    fn pulses_are_whole_as_soon_as_it_opens_and_end_with_all_else() {
        for gain in [1.0, UNARMED] {
            let mut gate = Gate::new(RATE, gain);
            (gate.motors, gate.pulses) = (vec![false; 2], vec![false, true]);
            let both = |gate: &mut Gate, frames: usize| -> Vec<[f32; 2]> {
                let mut block = vec![1.0; 2 * frames];
                gate.pass(&mut block, 2);
                block.as_chunks().0.to_vec()
            };
            assert_eq!(both(&mut gate, 10), [[0.0; 2]; 10]);
            for opens in [Order::Open, Order::Release, Order::Return] {
                gate.order(opens);
                let rising = both(&mut gate, 900);
                assert!(rising[0][0] < 1e-5 && rising[899][0] > 0.02 * gain, "{opens:?}");
                assert!(rising.iter().all(|frame| frame[1] == gain), "{opens:?}");
                let shut = if opens == Order::Release { Order::Close } else { Order::Latch };
                gate.order(shut);
                let falling = both(&mut gate, 200);
                assert!(falling[96..].iter().all(|frame| *frame == [0.0; 2]), "{opens:?}");
                if opens == Order::Open {
                    continue;
                }
                // Whatever shut it.
                gate.order(Order::Release);
                gate.order(Order::Close);
                both(&mut gate, 200);
            }
        }
    }

    #[test]
    fn arming_goes_from_a_tenth_to_all() {
        let mut gate = Gate::new(RATE, UNARMED);
        gate.order(Order::Open);
        assert_eq!(pass(&mut gate, 9600)[9599], 0.1);
        gate.order(Order::Gain(1.0));
        let rising = pass(&mut gate, 9600);
        assert!(rising.windows(2).all(|w| w[1] >= w[0]) && rising[9599] == 1.0);
        gate.order(Order::Gain(f32::NAN));
        assert_eq!(pass(&mut gate, 9600)[9599], 0.0);
    }

    /// A gain of more than 1, by however little, would let more leave than the engine holds back to.
    #[test]
    fn no_ramp_passes_its_ends() {
        // Where rounding would carry it beyond.
        let (low, high) = (0.200_108_5, 0.823_125_2);
        let mut gate = Gate::new(768_000.0, low);
        gate.order(Order::Open);
        pass(&mut gate, 153_600);
        gate.order(Order::Gain(high));
        assert_eq!(pass(&mut gate, 160_000).into_iter().find(|x| !(low..=high).contains(x)), None);
        for rate in [6000.0, 7350.0, 44_100.0, 48_000.0, 96_000.0, 192_000.0, 767_999.0] {
            for gain in [1.0, 0.7, UNARMED] {
                let mut gate = Gate::new(rate, UNARMED);
                gate.order(Order::Open);
                gate.order(Order::Gain(gain));
                for order in [Order::Open, Order::Close, Order::Return, Order::Close, Order::Open] {
                    gate.order(order);
                    let all = pass(&mut gate, (0.25 * rate) as usize);
                    let beyond = all.iter().find(|x| !(0.0..=gain.max(UNARMED)).contains(*x));
                    assert_eq!(beyond, None, "{rate} Hz, {order:?} to {gain}");
                }
            }
        }
    }

    #[test]
    fn cutting_time_changes_nothing() {
        let run = |cuts: &[usize]| {
            let mut gate = Gate::new(RATE, UNARMED);
            gate.order(Order::Open);
            gate.order(Order::Gain(1.0));
            cuts.iter().flat_map(|&n| pass(&mut gate, n)).map(f32::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(run(&[10_000]), run(&[1, 7, 64, 480, 9000, 448]));
    }

    #[test]
    fn an_order_on_the_way_goes_on_from_there() {
        let mut gate = Gate::new(RATE, 1.0);
        gate.order(Order::Open);
        let half = pass(&mut gate, 4800)[4799];
        gate.order(Order::Close);
        let falling = pass(&mut gate, 96);
        assert!((half - falling[0]).abs() < 0.02 && falling[95] == 0.0);
    }
}
