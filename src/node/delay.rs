//! Delay line.

use std::collections::VecDeque;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::fractional::Fractional;
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "delay",
    family: Family::Filter,
    summary: "Its input, some time later.",
    detail: "input(t − time), at each sample with the time of that sample; before the voice began the input was 0. Between samples it is \
             interpolated by eight taps, within −105 dB up to 1 kHz; of a time below four samples of the engine (0.5 ms) within −80 dB, and \
             such a short one amplifies what lies near half the engine's rate. The time is limited to one sample of the engine (0.125 ms) to \
             `longest`, at every sample; a moving time bends the pitch. What comes out depends on earlier samples only, so a delay may close a loop. An \
             input that is not a number counts as 0.",
    params: &[
        Param {
            name: "longest",
            kind: Kind::Constant(Numeric::or(1.0, 0.001, 60.0)),
            unit: "s",
            doc: "The longest time that can occur: what memory is kept for.",
        },
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1e6, 1e6)),
            unit: "",
            doc: "What is delayed.",
        },
        Param {
            name: "time",
            kind: Kind::Signal(Numeric::required(0.0, 60.0)),
            unit: "s",
            doc: "How much later it comes.",
        },
    ],
    example: r#"echo = { type = "delay", input = "hit", time = 0.12, longest = 0.2 }"#,
};

const TAPS: usize = 8;
const GAP: usize = 3 * TAPS;
/// Places among the taps that are read.
const FIRST: f64 = 3.0;
const LAST: f64 = 7.0;
/// Full accuracy to this share of the rate: 1 kHz at 7,350 Hz, the lowest engine rate of the usual devices. At 6,000 Hz it is 816 Hz.
const BAND: f64 = 0.136;

/// Eight lines.
#[derive(Debug, Clone)]
pub struct Lanes<R: 'static> {
    /// By lane: a ring, followed by its first samples again so that taps are always side by side. Lanes are a little more than a
    /// power of two apart, or all their places would share a few lines of the cache.
    lines: Vec<R>,
    stride: usize,
    mask: usize,
    /// Samples so far.
    clock: u64,
    /// By lane: those before its voice began. They count as 0.
    before: [u64; LANES],
    table: Fractional<R, TAPS>,
    rate: f64,
    most: f64,
    copied: Copied,
}

/// How far a copy has come.
#[derive(Debug, Clone)]
struct Copied {
    /// By lane: up to which sample.
    to: [u64; LANES],
    /// Samples that the original had when this looked last.
    seen: u64,
}

/// Zeros whose memory is there: the system gives it when it is first written to, and the audio thread is not to wait for that.
fn zeros<R: Real>(count: usize) -> Vec<R> {
    const PAGE: usize = 4096;
    let mut all = vec![R::ZERO; count];
    all.iter_mut().step_by(PAGE / size_of::<R>()).for_each(|x| *x = std::hint::black_box(R::ZERO));
    all
}

/// The longest time in samples, and the length of the ring that holds it.
fn room(setup: &Setup) -> (f64, usize) {
    let longest = setup.constants.first().copied().unwrap_or(1.0).clamp(0.001, 60.0);
    let most = (longest * setup.rate).max(1.0);
    (most, (most as usize + 2 * TAPS).next_power_of_two())
}

impl<R: Real> Lanes<R> {
    /// Copies of a lane what is missing and can still be heard, so many samples at most; how many those were.
    fn follow(&mut self, from: &Self, lane: usize, most: usize) -> usize {
        let length = self.mask + 1;
        let heard = from.before[lane].max(from.clock.saturating_sub(length as u64));
        let begin = self.copied.to[lane].max(heard);
        let count = (from.clock.saturating_sub(begin) as usize).min(most);
        let (to, from) = (lane * self.stride, &from.lines[lane * self.stride..][..self.stride]);
        let line = &mut self.lines[to..][..self.stride];
        let at = begin as usize & self.mask;
        let first = count.min(length - at);
        line[at..at + first].copy_from_slice(&from[at..at + first]);
        line[..count - first].copy_from_slice(&from[..count - first]);
        line[length..length + TAPS].copy_from_slice(&from[length..length + TAPS]);
        self.copied.to[lane] = begin + count as u64;
        count
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let (most, length) = room(setup);
        Self {
            lines: zeros((length + GAP) * LANES),
            stride: length + GAP,
            mask: length - 1,
            clock: 0,
            before: [0; LANES],
            table: Fractional::new(FIRST, LAST, BAND),
            rate: setup.rate,
            most,
            copied: Copied { to: [0; LANES], seen: u64::MAX },
        }
    }

    fn copy(&mut self, from: &Self, live: u8) {
        // Lines of the same settings are as long.
        if self.lines.len() == from.lines.len() {
            (0..LANES).filter(|l| live & (1 << l) != 0).for_each(|lane| {
                self.follow(from, lane, usize::MAX);
            });
            (self.clock, self.before) = (from.clock, from.before);
        }
    }

    fn copy_ahead(&mut self, from: &Self, live: u8, left: &mut usize) {
        if self.lines.len() != from.lines.len() {
            return;
        }
        for lane in (0..LANES).filter(|l| live & (1 << l) != 0) {
            // What came since costs no more than it did to run it.
            let keeps_up = self.copied.to[lane].max(from.before[lane]) >= self.copied.seen;
            let most = if keeps_up { usize::MAX } else { *left / size_of::<R>() };
            let bytes = self.follow(from, lane, most) * size_of::<R>();
            if !keeps_up {
                *left = if self.copied.to[lane] < from.clock { 0 } else { *left - bytes };
            }
        }
        self.copied.seen = from.clock;
    }

    fn heap(setup: &Setup) -> usize {
        (room(setup).1 + GAP) * LANES * size_of::<R>()
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.before[lane] = self.clock;
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, time] = [io.inputs[0], io.inputs[1]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (row, time) = (input.at(frame), time.at(frame));
            let next = self.clock as usize & self.mask;
            for l in 0..LANES {
                let back = time[l].wide() * self.rate;
                let back = if back > 1.0 { back } else { 1.0 };
                let back = if back < self.most { back } else { self.most };
                // Taps from `newest` samples back to seven more, with the place between the middle ones where there is room.
                let newest = (back as usize).max(4) - 3;
                let oldest = next.wrapping_sub(newest + TAPS - 1) & self.mask;
                let line = &mut self.lines[l * self.stride..][..self.stride];
                let (place, taps) = (newest as f64 + 7.0 - back, &line[oldest..]);
                let age = self.clock - self.before[l];
                out[l] = match age >= (newest + TAPS - 1) as u64 {
                    true => self.table.at(place, taps),
                    false => begun(&self.table, place, taps, newest, age as usize),
                };
                let x = if row[l].is_finite() { row[l] } else { R::ZERO };
                line[next] = x;
                if next < TAPS {
                    line[next + self.mask + 1] = x;
                }
            }
            self.clock += 1;
        }
    }
}

/// As [`Fractional::at`], where not all taps, of which the last is `newest` samples back, have been since the voice began `age` samples ago.
#[cold]
fn begun<R: Real>(table: &Fractional<R, TAPS>, place: f64, taps: &[R], newest: usize, age: usize) -> R {
    if age < newest {
        return R::ZERO;
    }
    let zeros = newest + TAPS - 1 - age;
    let mut since = [R::ZERO; TAPS];
    since.iter_mut().zip(taps).skip(zeros).for_each(|(since, tap)| *since = *tap);
    table.at(place, &since)
}

/// The definition: a sinc in the window cosh β√(1 − x²) / cosh β, as wide as the time allows, 48 samples on each side at most; β is
/// 12, or less where there is less room.
#[derive(Debug)]
pub struct Exact {
    past: VecDeque<f64>,
    rate: f64,
    least: f64,
    most: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self {
            past: VecDeque::new(),
            rate: setup.rate,
            least: 1.0 / setup.engine_rate,
            most: setup.constants[0].max(1.0 / setup.engine_rate),
        }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        self.past.push_front(inputs[0]);
        self.past.truncate((self.most * self.rate) as usize + 100);
        let back = inputs[1].clamp(self.least, self.most) * self.rate;
        let reach = back.floor().min(48.0);
        let beta = reach.min(12.0);
        let from = (back - reach).ceil().max(0.0) as usize;
        (from..=(back + reach) as usize)
            .map(|k| {
                let off = k as f64 - back;
                let angle = std::f64::consts::PI * off;
                let sinc = if off.abs() < 1e-9 { 1.0 } else { angle.sin() / angle };
                let window = (beta * (1.0 - (off / reach).powi(2)).max(0.0).sqrt()).cosh() / beta.cosh();
                self.past.get(k).copied().unwrap_or(0.0) * sinc * window
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{Lanes, TAPS};
    use crate::dsp::lanes::LANES;
    use crate::node::harness::{Bench, error_db};
    use crate::node::kernel::{Input, Io, Kernel, Onset};
    use std::f64::consts::TAU;

    fn tone(t: f64) -> f64 {
        let fade = (t / 0.1).clamp(0.0, 1.0);
        let fade = fade * fade * (3.0 - 2.0 * fade);
        fade * ((TAU * 250.0 * t).sin() + 0.5 * (TAU * 810.0 * t).cos())
    }

    #[test]
    fn it_is_the_input_some_time_ago() {
        for (time, most) in [(0.000_18, -80.0), (0.000_3, -90.0), (0.01, -110.0), (0.052_31, -110.0)] {
            let bench = Bench::new("delay", 8000.0).constant("longest", 0.1).moving("input", 0.0, tone).steady("time", time);
            bench.check_contract();
            let exact: Vec<f64> = (0..20_000).map(|n| tone((-1.6 + f64::from(n)) / 8000.0 - time)).collect();
            let error = error_db(&bench.kernel::<f32>(20_000, &[64]), &exact);
            assert!(error < most, "{time} s: {error}");
            assert!(time < 0.001 || bench.error_db::<f32>(20_000) < -110.0, "{time} s: {}", bench.error_db::<f32>(20_000));
        }
    }

    #[test]
    fn a_moving_time_follows_its_twin() {
        let bench = Bench::new("delay", 8000.0)
            .constant("longest", 0.1)
            .moving("input", 0.0, tone)
            .moving("time", 0.02, |t| 0.005 * (TAU * 3.0 * t).sin());
        bench.check_contract();
        let error = bench.error_db::<f32>(20_000);
        assert!(error < -110.0, "{error}");
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -100.0, "{error}");
    }

    #[test]
    fn whole_samples_are_exact_in_time() {
        let bench = Bench::new("delay", 8000.0)
            .age(-1.0)
            .constant("longest", 0.01)
            .moving("input", 0.0, |t| if t == 0.0 { 1.0 } else { 0.0 })
            .steady("time", 0.001);
        let out = bench.kernel::<f64>(100, &[64]);
        for (n, value) in out.iter().enumerate() {
            let exact = if n == 9 { 1.0 } else { 0.0 };
            assert!((value - exact).abs() < 1e-3, "{n}: {value}");
        }
    }

    #[test]
    fn hostile_times_and_inputs_stay_bounded() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, 0.0] {
            let bench = Bench::new("delay", 8000.0)
                .constant("longest", 0.003)
                .moving("input", 0.0, move |t| if bad.is_finite() { t.sin() } else { bad })
                .moving("time", 0.001, move |_| bad);
            assert!(bench.kernel::<f32>(1000, &[64]).iter().all(|v| v.abs() < 10.0), "{bad}");
        }
    }

    /// Whatever becomes of the original meanwhile, and however little is copied at a time.
    #[test]
    fn a_copy_is_made_a_little_at_a_time() {
        let bench = Bench::new("delay", 8000.0).constant("longest", 0.2);
        let (room, mut random) = (4096_u64, 7_u64);
        let mut draw = |below: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % below
        };
        let base = [0.0; LANES];
        let run = |lanes: &mut Lanes<f32>, from: u64, frames: u64| {
            let rows: Vec<_> = (from..from + frames)
                .map(|n| std::array::from_fn(|l| ((n * 31 + l as u64 * 7) % 1009) as f32))
                .collect();
            let time: Vec<_> = (from..from + frames)
                .map(|n| std::array::from_fn(|l| ((n * 17 + l as u64) % 1600) as f32 / 8000.0))
                .collect();
            let input = |rows| Input { rows, step: 1, steady: false, base: &base };
            let mut output = vec![[0.0; LANES]; frames as usize];
            let inputs = [input(&rows), input(&time)];
            lanes.run(&mut Io { inputs: &inputs, output: &mut output, still: false });
            output
        };
        for _ in 0..60 {
            let mut original = <Lanes<f32> as Kernel<f32>>::new(&bench.setup);
            let (mut copy, mut at, mut live) = (original.clone(), 0, 0b0110_1011_u8);
            let age = draw(3 * room);
            drop(run(&mut original, at, age));
            at += age;
            let (mut left, mut calls) = (0, 0);
            while left == 0 {
                let lane = draw(8) as usize;
                match draw(3) {
                    0 => {
                        live |= 1 << lane;
                        let onset = Onset { age: -1.0, stream: 0, start: &[0.0, 0.0] };
                        Kernel::<f32>::start(&mut original, lane, &onset);
                    }
                    1 => live &= !(1 << lane),
                    _ => {}
                }
                left = 900 + draw(2_000) as usize;
                let most = left;
                let before = copy.lines.clone();
                Kernel::<f32>::copy_ahead(&mut copy, &original, live, &mut left);
                let came = copy.lines.iter().zip(&before).filter(|(a, b)| a != b).count();
                // With what stands there twice.
                let came = came.saturating_sub(TAPS * LANES) * size_of::<f32>();
                assert!(calls > 0 || came <= most, "{came} bytes of {most}");
                calls += 1;
                let frames = 1 + draw(40);
                drop(run(&mut original, at, frames));
                at += frames;
            }
            assert!(calls > 3 || age < 500, "{calls} calls for {age} samples");
            Kernel::<f32>::copy(&mut copy, &original, live);
            let (one, other) = (run(&mut original, at, 300), run(&mut copy, at, 300));
            for l in (0..LANES).filter(|l| live & (1 << l) != 0) {
                assert!(one.iter().zip(&other).all(|(a, b)| a[l].to_bits() == b[l].to_bits()), "lane {l}, {calls} calls");
            }
        }
    }
}
