//! Units of `fundsp` as leaves of a graph: one instance a lane, run sample by sample.
//!
//! A unit computes single samples (`tick`) and never blocks, so that nothing depends on how time is cut. It is built and given its
//! memory once; a voice's start resets it and gives it its random numbers. What goes in and comes out is in `f32`, as the units have
//! it. Units whose clock, random start or sample rate are not under control are left out: envelopes, sequencers, oscillators, `Slot`.

use fundsp::Frame;
use fundsp::audionode::AudioNode;
use fundsp::typenum::U1;

use super::kernel::{Onset, Setup};
use super::white::REACH;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::sinc::weights;

/// What is not a number, and what lies beyond this, counts as 0.
const MOST_INPUT: f64 = 1e9;
/// Below this a signal is nothing: −140 dB.
const NOTHING: f32 = 1e-7;
/// A unit in which nothing has moved for so many calls of `settle` rests: about a second.
const PATIENCE: u32 = 128;

/// Eight units.
#[derive(Clone)]
pub struct Leaf<U> {
    units: [U; LANES],
    /// A lane that rests gives 0 and costs nothing.
    rests: [bool; LANES],
    /// Whether there was anything to hear since the last call of `settle`.
    heard: [bool; LANES],
    /// For how many calls of `settle` there was not.
    calm: [u32; LANES],
}

impl<U: AudioNode<Outputs = U1>> Leaf<U> {
    /// Eight resting units at `rate` samples a second, with all the memory that they will need.
    pub fn new(rate: f64, make: impl Fn() -> U) -> Self {
        let units = std::array::from_fn(|_| {
            let mut unit = make();
            unit.set_sample_rate(rate);
            unit.allocate();
            unit
        });
        Self { units, rests: [true; LANES], heard: [false; LANES], calm: [0; LANES] }
    }

    /// Becomes a copy; units that have memory of their own are copied into that.
    pub fn copy(&mut self, from: &Self) {
        self.units.iter_mut().zip(&from.units).for_each(|(to, from)| to.clone_from(from));
        (self.rests, self.heard, self.calm) = (from.rests, from.heard, from.calm);
    }

    /// A lane forgets what was there; `set` gives its unit what it has to know at the onset.
    pub fn start(&mut self, lane: usize, set: impl FnOnce(&mut U)) {
        let unit = &mut self.units[lane];
        unit.reset();
        set(unit);
        (self.rests[lane], self.heard[lane], self.calm[lane]) = (false, true, 0);
    }

    /// Tells a unit something in the middle of its work.
    pub fn change(&mut self, lane: usize, set: impl FnOnce(&mut U)) {
        set(&mut self.units[lane]);
    }

    /// The next sample of a unit that makes a signal: once it has died away, it rests until the next start.
    #[inline(always)]
    pub fn draw(&mut self, lane: usize, input: &Frame<f32, U::Inputs>) -> f32 {
        if self.rests[lane] {
            return 0.0;
        }
        let out = self.units[lane].tick(input)[0];
        if !out.is_finite() {
            self.rests[lane] = true;
            return 0.0;
        }
        self.heard[lane] |= out.abs() >= NOTHING;
        out
    }

    /// The next sample of a unit that changes a signal, its first input: what rests wakes as soon as there is one.
    #[inline(always)]
    pub fn pass(&mut self, lane: usize, input: &Frame<f32, U::Inputs>) -> f32 {
        if input[0].abs() >= NOTHING {
            if self.rests[lane] {
                self.units[lane].reset();
                (self.rests[lane], self.calm[lane]) = (false, 0);
            }
            self.heard[lane] = true;
        }
        self.draw(lane, input)
    }

    /// See [`super::kernel::Kernel::settle`].
    pub fn settle(&mut self) {
        for l in 0..LANES {
            self.calm[l] = if self.heard[l] { 0 } else { (self.calm[l] + 1).min(PATIENCE) };
            self.rests[l] |= self.calm[l] == PATIENCE;
            self.heard[l] = false;
        }
    }
}

/// A signal as units take it.
#[inline(always)]
pub fn signal<R: Real>(x: R) -> f32 {
    let x = x.wide();
    if x.abs() < MOST_INPUT { x as f32 } else { 0.0 }
}

/// Within `least` and `most`; what is not a number is `least`.
#[inline(always)]
pub fn within(x: f64, least: f64, most: f64) -> f64 {
    let x = if x > least { x } else { least };
    if x < most { x } else { most }
}

/// For the twins: a sequence that is defined at the engine's rate, one number a sample from the voice's first on, as a function of
/// time. Between samples it is band-limited, in the way of [`super::white::Sequence`].
pub struct Sampled {
    next: Box<dyn FnMut() -> f64 + Send>,
    values: Vec<f64>,
    age: f64,
    rate: f64,
}

impl Sampled {
    /// `next` gives one number after the other.
    pub fn new(setup: &Setup, onset: &Onset, next: impl FnMut() -> f64 + Send + 'static) -> Self {
        Self { next: Box::new(next), values: Vec::new(), age: onset.age, rate: setup.engine_rate }
    }

    fn value(&mut self, place: i64) -> f64 {
        let Ok(place) = usize::try_from(place) else { return 0.0 };
        while self.values.len() <= place {
            let value = (self.next)();
            self.values.push(value);
        }
        self.values[place]
    }

    /// Its value at voice time `t` (seconds).
    pub fn at(&mut self, t: f64) -> f64 {
        let place = t * self.rate - self.age;
        let near = place.round();
        if (place - near).abs() < 1e-6 {
            return self.value(near as i64);
        }
        weights(place, REACH as f64).map(|(k, weight)| self.value(k) * weight).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, Leaf, PATIENCE, within};
    use fundsp::Frame;
    use fundsp::audionode::AudioNode;
    use fundsp::filter::Lowpole;
    use fundsp::typenum::{U1, U2};

    /// Its input, and nothing but what is not a number after one.
    #[derive(Clone, Default)]
    struct Fragile(f32);

    impl AudioNode for Fragile {
        const ID: u64 = 9000;
        type Inputs = U1;
        type Outputs = U1;
        fn reset(&mut self) {
            self.0 = 0.0;
        }
        fn tick(&mut self, input: &Frame<f32, U1>) -> Frame<f32, U1> {
            self.0 += input[0];
            [self.0].into()
        }
    }

    #[test]
    fn a_unit_that_went_astray_rests_until_the_next_start() {
        let mut leaf = Leaf::new(8000.0, Fragile::default);
        assert_eq!(leaf.draw(2, &[1.0].into()), 0.0, "no voice, no signal");
        leaf.start(2, |_| {});
        assert_eq!(leaf.draw(2, &[1.0].into()), 1.0);
        for bad in [f32::NAN, 1.0, f32::INFINITY, 2.0] {
            assert_eq!(leaf.draw(2, &[bad].into()), 0.0);
        }
        leaf.start(2, |_| {});
        assert_eq!(leaf.draw(2, &[3.0].into()), 3.0);
    }

    #[test]
    fn what_has_died_away_rests_and_wakes() {
        let mut leaf = Leaf::new(8000.0, || Lowpole::<f64, U2>::new(100.0));
        leaf.start(0, |_| {});
        let mut fall = vec![leaf.pass(0, &[1.0, 100.0].into())];
        for n in 0..64 * (PATIENCE + 40) {
            if n % 64 == 0 {
                leaf.settle();
            }
            fall.push(leaf.pass(0, &[0.0, 100.0].into()));
        }
        assert!(fall[0] > 0.07 && fall.last() == Some(&0.0) && leaf.rests == [true; LANES]);
        assert!(fall[1000..].iter().all(|x| *x < 1e-7), "it was let go while there was something to hear");
        assert_eq!(leaf.pass(0, &[1.0, 100.0].into()), fall[0], "it wakes as it began");
    }

    #[test]
    fn limits_hold_for_any_number() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -0.0] {
            assert!((1.0..=2.0).contains(&within(x, 1.0, 2.0)), "{x}");
        }
    }
}
