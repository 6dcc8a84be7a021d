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
    /// Place in the ring of the next sample.
    next: usize,
    mask: usize,
    table: Fractional<R, TAPS>,
    rate: f64,
    most: f64,
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

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let (most, length) = room(setup);
        Self {
            lines: zeros((length + GAP) * LANES),
            stride: length + GAP,
            next: 0,
            mask: length - 1,
            table: Fractional::new(FIRST, LAST, BAND),
            rate: setup.rate,
            most,
        }
    }

    fn copy(&mut self, from: &Self) {
        // Lines of the same settings are as long.
        if self.lines.len() == from.lines.len() {
            self.lines.copy_from_slice(&from.lines);
            (self.stride, self.next, self.mask) = (from.stride, from.next, from.mask);
            (self.rate, self.most) = (from.rate, from.most);
        }
    }

    fn heap(setup: &Setup) -> usize {
        (room(setup).1 + GAP) * LANES * size_of::<R>()
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.lines[lane * self.stride..][..self.stride].fill(R::ZERO);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, time] = [io.inputs[0], io.inputs[1]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (row, time) = (input.at(frame), time.at(frame));
            for l in 0..LANES {
                let back = time[l].wide() * self.rate;
                let back = if back > 1.0 { back } else { 1.0 };
                let back = if back < self.most { back } else { self.most };
                // Taps from `newest` samples back to seven more, with the place between the middle ones where there is room.
                let newest = (back as usize).max(4) - 3;
                let oldest = self.next.wrapping_sub(newest + TAPS - 1) & self.mask;
                let line = &mut self.lines[l * self.stride..][..self.stride];
                out[l] = self.table.at(newest as f64 + 7.0 - back, &line[oldest..]);
                let x = if row[l].is_finite() { row[l] } else { R::ZERO };
                line[self.next] = x;
                if self.next < TAPS {
                    line[self.next + self.mask + 1] = x;
                }
            }
            self.next = (self.next + 1) & self.mask;
        }
    }
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
    use crate::node::harness::{Bench, error_db};
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
}
