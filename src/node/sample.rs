//! Plays a recording.

use std::sync::Arc;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::fractional::Fractional;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::quadrature::{Rise, Turns};
use crate::dsp::recording::{Copies, Loop, TAPS};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "sample",
    family: Family::Recording,
    summary: "Plays a recording, at any speed and in both directions.",
    detail: "amplitude × the recording at start + ∫ speed dt; the integral is 0 at the onset, and a moving speed is integrated as the frequency of \
             `sine` is. Outside the recording there is silence. With `loop`, what would go beyond `loop_end` goes on at \
             `loop_start`, and once well inside, what would go before `loop_start` goes on at `loop_end`; played backwards \
             at a steady speed from `loop_start` or before, it starts at `loop_end`; both are moved to the nearest sample of the \
             recording at twice the engine's rate. Values between samples come from 16 taps, within −110 dB to 1 kHz. Faster than 1, \
             it changes to copies of lower bands (half the band up to 1.75, and so on), so that nothing folds into the band; from 16 on \
             it is silent.",
    params: &[
        Param { name: "file", kind: Kind::File, unit: "", doc: "A WAV file, relative to the patch." },
        Param {
            name: "channel",
            kind: Kind::Constant(Numeric::or(1.0, 1.0, 1024.0)),
            unit: "",
            doc: "Which of its channels, from 1.",
        },
        Param {
            name: "loop",
            kind: Kind::Flag(false),
            unit: "",
            doc: "Whether it repeats.",
        },
        Param {
            name: "loop_start",
            kind: Kind::Constant(Numeric::or(0.0, 0.0, 86_400.0)),
            unit: "s",
            doc: "Where the part that repeats begins.",
        },
        Param {
            name: "loop_end",
            kind: Kind::Constant(Numeric::or(0.0, 0.0, 86_400.0)),
            unit: "s",
            doc: "Where it ends; 0 for the end of the recording.",
        },
        Param {
            name: "start",
            kind: Kind::Start(Numeric::or(0.0, 0.0, 86_400.0)),
            unit: "s",
            doc: "Where it starts.",
        },
        Param {
            name: "speed",
            kind: Kind::Signal(Numeric::or(1.0, -16.0, 16.0)),
            unit: "",
            doc: "1 as recorded, 2 an octave up, negative backwards.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"scrape = { type = "sample", file = "scrape.wav", speed = "event.speed" }"#,
};

/// The recording and the part that repeats.
fn material(setup: &Setup) -> (Option<Arc<Copies>>, f64, Loop) {
    let Some(asset) = &setup.asset else { return (None, 0.0, None) };
    let length = asset.samples.len();
    let place = |k: usize| {
        let seconds = setup.constants.get(k).copied().unwrap_or(0.0);
        ((seconds * asset.rate).round().max(0.0) as usize).min(length)
    };
    let (start, end) = (place(1), place(2));
    let end = if end == 0 { length } else { end };
    let around = if setup.choices.first() == Some(&1) && end > start { Some((start, end)) } else { None };
    let copies = Copies::of(asset, &asset.samples, around == Some((0, length)));
    (Some(copies), asset.rate, around)
}

/// Eight players.
#[derive(Debug, Clone)]
pub struct Lanes<R: 'static> {
    copies: Option<Arc<Copies>>,
    /// A recording that a copy of another state took the place of, and that is not freed by the audio thread.
    #[expect(dead_code, reason = "held, and dropped")]
    displaced: Option<Arc<Copies>>,
    around: Loop,
    table: Fractional<R, TAPS>,
    /// Samples of the recording a second, and in a sample of the engine.
    asset_rate: f64,
    stride: f64,
    /// Where it started, and samples since.
    origin: [f64; LANES],
    count: [f64; LANES],
    moved: [f64; LANES],
    rise: Rise,
    speed: [f64; LANES],
    entered: [bool; LANES],
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let (copies, asset_rate, around) = material(setup);
        Self {
            copies,
            displaced: None,
            around,
            table: Fractional::new(7.0, 8.0, 0.25),
            asset_rate,
            stride: asset_rate / setup.rate,
            origin: [0.0; LANES],
            count: [0.0; LANES],
            moved: [0.0; LANES],
            rise: Rise::default(),
            speed: [0.0; LANES],
            entered: [false; LANES],
        }
    }

    fn copy(&mut self, from: &Self, _live: u8) {
        *self = Self { displaced: self.copies.take(), ..from.clone() };
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let origin = onset.start[0] * self.asset_rate;
        let (origin, entered) = match self.around {
            Some((start, end)) if onset.start[1] < 0.0 && origin <= start as f64 => (end as f64, true),
            _ => (origin, false),
        };
        self.origin[lane] = origin;
        self.count[lane] = onset.age;
        self.moved[lane] = 0.0;
        self.rise.start(lane, onset.age);
        self.speed[lane] = onset.start[1];
        self.entered[lane] = entered;
    }

    fn retune(&mut self, lane: usize, was: &[f64], now: &[f64]) {
        // Where the next sample would have been.
        self.origin[lane] += (self.moved[lane] + was[1]) * self.stride;
        (self.moved[lane], self.count[lane]) = (0.0, 0.0);
        self.rise.start(lane, 0.0);
        self.speed[lane] = now[1];
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let Some(copies) = &self.copies else {
            io.output.fill([R::ZERO; LANES]);
            return;
        };
        let [speed, amplitude] = [io.inputs[1], io.inputs[2]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let gain = amplitude.at(frame);
            let mut now = self.speed;
            if !speed.is_steady() {
                let row = speed.at(frame);
                for l in 0..LANES {
                    let wide = row[l].wide();
                    now[l] = if wide.abs() < 1e6 { wide } else { 0.0 };
                }
                let rise = self.rise.step(&now);
                for l in 0..LANES {
                    self.moved[l] += rise[l];
                }
            } else {
                for l in 0..LANES {
                    self.moved[l] = self.count[l] * now[l];
                    self.count[l] += 1.0;
                }
            }
            for l in 0..LANES {
                let (place, entered) =
                    folded(self.origin[l] + self.moved[l] * self.stride, self.around, self.entered[l]);
                self.entered[l] = entered;
                out[l] = copies.at(&self.table, place, now[l], self.around, entered) * gain[l];
            }
        }
    }
}

/// A place with the loop taken off, and whether the loop has been entered.
#[inline(always)]
fn folded(place: f64, around: Loop, entered: bool) -> (f64, bool) {
    let Some((start, end)) = around else { return (place, false) };
    let (start, end) = (start as f64, end as f64);
    let entered = entered || place >= end || place >= start + 64.0;
    if !entered || (place >= start && place < end) || !place.is_finite() {
        return (place, entered);
    }
    let length = end - start;
    let turns = ((place - start) / length).floor();
    (place - turns * length, true)
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    copies: Option<Arc<Copies>>,
    asset_rate: f64,
    around: Loop,
    entered: bool,
    /// Samples of the recording between `start` and where it really starts.
    ahead: f64,
    run: Turns,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let (copies, asset_rate, around) = material(setup);
        let mut new = Self { copies, asset_rate, around, entered: false, ahead: 0.0, run: Turns::default() };
        if let Some((first, end)) = around {
            let start = onset.start[0] * asset_rate;
            new.entered = onset.start[1] < 0.0 && start <= first as f64;
            new.ahead = if new.entered { end as f64 - start } else { 0.0 };
        }
        new
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let Some(copies) = &self.copies else { return 0.0 };
        let mut place = (inputs[0] + self.run.total(t, inputs[1])) * self.asset_rate + self.ahead;
        if let Some((start, end)) = self.around {
            let (start, end) = (start as f64, end as f64);
            self.entered |= place >= end.min(start + 64.0);
            if self.entered {
                place = start + (place - start).rem_euclid(end - start);
            }
        }
        inputs[2] * copies.exact(place, inputs[1], self.around, self.entered)
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::{Bench, error_db};
    use std::f64::consts::TAU;

    fn recording(count: usize) -> Vec<f32> {
        let fade = |n: usize| (n.min(count - n) as f64 / 400.0).min(1.0);
        (0..count)
            .map(|n| {
                let (t, fade) = (n as f64 / 16_000.0, fade(n));
                (fade * fade * (3.0 - 2.0 * fade) * (0.5 * (TAU * 130.0 * t).sin() + 0.4 * (TAU * 700.0 * t).cos())) as f32
            })
            .collect()
    }

    #[test]
    fn every_speed_follows_its_twin() {
        for (start, speed) in [(0.0, 1.0), (0.1, 0.37), (0.9, -1.0), (0.0, 1.3), (0.02, 1.8), (0.0, 5.0), (0.0, 20.0)] {
            let bench =
                Bench::new("sample", 8000.0).asset(recording(16_000), 16_000.0).steady("start", start).steady("speed", speed);
            bench.check_contract();
            let error = bench.error_db::<f32>(8000);
            assert!(error < -110.0 || speed == 20.0, "{speed}: {error}");
        }
        let moving = Bench::new("sample", 8000.0)
            .asset(recording(16_000), 16_000.0)
            .moving("speed", 0.3, |t| 1.2 * (TAU * 3.0 * t).sin());
        moving.check_contract();
        let error = moving.error_db::<f32>(8000);
        assert!(error < -105.0, "{error}");
    }

    #[test]
    fn the_speed_is_that_of_the_recording() {
        let sine: Vec<f32> = (0..40_000).map(|n| (TAU * 200.0 * f64::from(n) / 16_000.0).sin() as f32).collect();
        let bench = Bench::new("sample", 8000.0).asset(sine, 16_000.0).steady("speed", 1.5).steady("start", 0.1);
        let exact: Vec<f64> =
            (0..8000).map(|n| (TAU * 200.0 * (0.1 + 1.5 * (-1.6 + f64::from(n)) / 8000.0)).sin()).collect();
        let error = error_db(&bench.kernel::<f32>(8000, &[64]), &exact);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn a_loop_goes_round_both_ways() {
        let sine: Vec<f32> = (0..4000).map(|n| (TAU * f64::from(n) / 40.0).sin() as f32).collect();
        for (start, speed) in [(0.0, 1.0), (0.24, -0.7), (0.1, 2.5)] {
            let bench = Bench::new("sample", 8000.0)
                .asset(sine.clone(), 16_000.0)
                .choice("loop", 1)
                .constant("loop_start", 0.05)
                .constant("loop_end", 0.2)
                .steady("start", start)
                .steady("speed", speed);
            bench.check_contract();
            let out = bench.kernel::<f32>(80_000, &[64]);
            let exact: Vec<f64> = (0..80_000)
                .map(|n| (TAU * 400.0 * (start + speed * (-1.6 + f64::from(n)) / 8000.0)).sin())
                .collect();
            // Skips the silence before the recording.
            let error = error_db(&out[100..], &exact[100..]);
            assert!(error < -80.0, "{speed}: {error}");
        }
    }

    #[test]
    fn a_loop_that_runs_backwards_starts_at_its_end() {
        let sine: Vec<f32> = (0..4000).map(|n| (TAU * f64::from(n) / 40.0).sin() as f32).collect();
        for (first, end, start) in [(0.0, 0.0, 0.0), (0.05, 0.2, 0.05), (0.05, 0.2, 0.01)] {
            let bench = Bench::new("sample", 8000.0)
                .asset(sine.clone(), 16_000.0)
                .choice("loop", 1)
                .constant("loop_start", first)
                .constant("loop_end", end)
                .steady("start", start)
                .steady("speed", -1.0);
            bench.check_contract();
            // 400 Hz: both ends lie at phase 0.
            let exact: Vec<f64> = (0..8000).map(|n| -(TAU * 400.0 * (-1.6 + f64::from(n)) / 8000.0).sin()).collect();
            let error = error_db(&bench.kernel::<f32>(8000, &[64]), &exact);
            assert!(error < -80.0, "{first} {end} {start}: {error}");
            assert!(bench.error_db::<f32>(8000) < -110.0);
        }
    }

    #[test]
    fn what_is_fast_does_not_fold_into_the_band() {
        // A sine of 3 kHz at speed 2.4 would come out as 8000 − 7200 = 800 Hz.
        let sine: Vec<f32> = (0..64_000).map(|n| (TAU * 3000.0 * f64::from(n) / 16_000.0).sin() as f32).collect();
        let bench = Bench::new("sample", 8000.0).asset(sine, 16_000.0).steady("speed", 2.4);
        let out = bench.kernel::<f32>(8000, &[64]);
        let power = out[1000..7000].iter().map(|v| v * v).sum::<f64>() / 6000.0;
        assert!(10.0 * (2.0 * power).log10() < -80.0, "{power}");
    }

    #[test]
    fn hostile_speeds_stay_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 1e5] {
            for looped in 0..2 {
                let bench = Bench::new("sample", 8000.0)
                    .asset(recording(4000), 16_000.0)
                    .choice("loop", looped)
                    .moving("speed", 1.0, move |t| if t > 0.01 && t < 0.02 { bad } else { 0.0 });
                assert!(bench.kernel::<f32>(1000, &[64]).iter().all(|v| v.abs() < 2.0), "{bad}");
            }
        }
        let none = Bench::new("sample", 8000.0);
        assert!(none.kernel::<f32>(10, &[64]).iter().all(|v| *v == 0.0));
        let empty = Bench::new("sample", 8000.0).asset(Vec::new(), 16_000.0).choice("loop", 1);
        assert!(empty.kernel::<f32>(10, &[64]).iter().all(|v| *v == 0.0));
    }

    /// With another speed in the middle of it, a recording goes on from where it is: whichever of the two speeds is moved by a signal.
    #[test]
    fn another_speed_goes_on_from_the_place() {
        use super::{Io, Kernel, LANES, Lanes, Onset, Setup};
        use crate::node::kernel::Input;
        let samples = (0..16_000).map(|n| (TAU * 200.0 * f64::from(n) / 16_000.0).sin() as f32).collect();
        let asset = std::sync::Arc::new(crate::node::asset::Asset { samples, rate: 16_000.0 });
        let setup = Setup {
            rate: 8000.0,
            engine_rate: 8000.0,
            constants: vec![0.0; 3],
            choices: vec![0],
            points: Vec::new(),
            asset: Some(asset),
            begins: false,
        };
        for (before, after) in [((1.0, true), (1.5, true)), ((1.0, true), (1.5, false)), ((1.0, false), (1.5, true))] {
            let mut lanes: Lanes<f64> = Lanes::new(&setup);
            // What a signal moves is not known at the onset.
            let known = |(speed, steady): (f64, bool)| [0.1, if steady { speed } else { 0.0 }, 1.0];
            lanes.start(0, &Onset { age: -1.5, stream: 0, start: &known(before) });
            let mut played = Vec::new();
            for (speed, steady) in [before, after] {
                let (rows, ones, base) = ([[speed; LANES]], [[1.0; LANES]], [speed; LANES]);
                let input = |rows, steady| Input { rows, step: 0, steady, base: &base };
                let mut output = [[0.0; LANES]; 400];
                let mut io = Io { inputs: &[input(&ones, true), input(&rows, steady), input(&ones, true)], output: &mut output, still: false };
                lanes.run(&mut io);
                played.extend(output.iter().map(|row| row[0]));
                lanes.retune(0, &known(before), &known(after));
            }
            let place = |n: usize| 0.1 + (n.min(400) as f64 - 1.5 + 1.5 * n.saturating_sub(400) as f64) / 8000.0;
            let far = played.iter().enumerate().skip(8).map(|(n, value)| {
                // Within a sample at the change.
                let near = [-1.0, 0.0, 1.0].map(|off| (TAU * 200.0 * (place(n) + off / 8000.0)).sin());
                let [least, most] = [near.iter().copied().fold(f64::INFINITY, f64::min), near.iter().copied().fold(f64::NEG_INFINITY, f64::max)];
                (least - value).max(value - most)
            });
            let far = far.fold(0.0, f64::max);
            assert!(far < 1e-3, "{before:?} {after:?}: {far}");
        }
    }
}
