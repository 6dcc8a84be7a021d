//! A recorded texture, read at a place that moves.

use std::collections::VecDeque;
use std::sync::Arc;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::fractional::Fractional;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::recording::{Copies, Loop, TAPS};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "scan",
    family: Family::Recording,
    summary: "A recorded texture, read at a place that moves: moving over it plays it.",
    detail: "amplitude × the recording at `position` (seconds of the recording). The speed is the difference from the place one sample of the \
             engine earlier; as in `sample`, the faster it is, the lower the band of the copy that is heard, so that nothing folds into \
             the band, and from 16 times the recorded speed on there is silence. Standing still gives the constant value at that place. With \
             `loop` the texture repeats without end in both directions; without, there is silence outside.",
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
            kind: Kind::Flag(true),
            unit: "",
            doc: "Whether the texture repeats.",
        },
        Param {
            name: "position",
            kind: Kind::Signal(Numeric::required(-86_400.0, 86_400.0)),
            unit: "s",
            doc: "Where it is read; a signal of 32 bits is best kept within a few seconds.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"weave = { type = "scan", file = "weave.wav", position = "finger" }"#,
};

fn material(setup: &Setup) -> (Option<Arc<Copies>>, f64, Loop) {
    let Some(asset) = &setup.asset else { return (None, 0.0, None) };
    let copies = Copies::of(asset, &asset.samples, setup.choices.first() == Some(&1));
    let around = (setup.choices.first() == Some(&1) && copies.length > 0).then_some((0, copies.length));
    (Some(copies), asset.rate, around)
}

/// Eight readers.
#[derive(Debug, Clone)]
pub struct Lanes<R: 'static> {
    copies: Option<Arc<Copies>>,
    /// A recording that a copy of another state took the place of, and that is not freed by the audio thread.
    #[expect(dead_code, reason = "held, and dropped")]
    displaced: Option<Arc<Copies>>,
    around: Loop,
    table: Fractional<R, TAPS>,
    asset_rate: f64,
    rate: f64,
    before: [f64; LANES],
    fresh: [bool; LANES],
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
            rate: setup.rate,
            before: [0.0; LANES],
            fresh: [false; LANES],
        }
    }

    fn copy(&mut self, from: &Self, _live: u8) {
        *self = Self { displaced: self.copies.take(), ..from.clone() };
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.fresh[lane] = true;
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let Some(copies) = &self.copies else {
            io.output.fill([R::ZERO; LANES]);
            return;
        };
        let [position, amplitude] = [io.inputs[0], io.inputs[1]];
        let steady = position.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (row, gain) = (position.at(frame), amplitude.at(frame));
            for l in 0..LANES {
                let seconds = if steady { position.base[l] } else { row[l].wide() };
                let seconds = if seconds.abs() < 1e6 { seconds } else { 0.0 };
                let before = if self.fresh[l] { seconds } else { self.before[l] };
                self.before[l] = seconds;
                let mut place = seconds * self.asset_rate;
                if self.around.is_some() {
                    let length = copies.length as f64;
                    place -= (place / length).floor() * length;
                }
                let speed = (seconds - before) * self.rate;
                out[l] = copies.at(&self.table, place, speed, self.around, true) * gain[l];
            }
            self.fresh = [false; LANES];
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    copies: Option<Arc<Copies>>,
    asset_rate: f64,
    around: Loop,
    rate: f64,
    span: usize,
    past: VecDeque<f64>,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let (copies, asset_rate, around) = material(setup);
        let span = (setup.rate / setup.engine_rate).round().max(1.0) as usize;
        Self { copies, asset_rate, around, rate: setup.engine_rate, span, past: VecDeque::new() }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let Some(copies) = &self.copies else { return 0.0 };
        self.past.push_back(inputs[0]);
        if self.past.len() > self.span + 1 {
            self.past.pop_front();
        }
        let speed = (inputs[0] - self.past[0]) * self.rate;
        let mut place = inputs[0] * self.asset_rate;
        if self.around.is_some() {
            place = place.rem_euclid(copies.length as f64);
        }
        inputs[1] * copies.exact(place, speed, self.around, true)
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    /// Harmonics of 10 Hz, so that it repeats without a seam.
    fn texture() -> Vec<f32> {
        (0..1600)
            .map(|n| {
                let t = f64::from(n) / 16_000.0;
                (0.4 * (TAU * 120.0 * t).sin() + 0.3 * (TAU * 730.0 * t).cos()) as f32
            })
            .collect()
    }

    #[test]
    fn moving_over_it_plays_it() {
        for (reach, hertz) in [(0.05, 1.0), (0.5, 0.7), (0.4, 2.0)] {
            let bench = Bench::new("scan", 8000.0)
                .asset(texture(), 16_000.0)
                .moving("position", 0.1, move |t| reach * (TAU * hertz * t).sin());
            bench.check_contract();
            let (single, double) = (bench.error_db::<f32>(16_000), bench.error_db::<f64>(16_000));
            assert!(single < -110.0 && double < -110.0, "{reach} s: {single}, {double}");
        }
    }

    #[test]
    fn what_is_too_fast_is_silent() {
        let bench = Bench::new("scan", 8000.0).asset(texture(), 16_000.0).moving("position", 0.0, |t| 17.0 * t);
        assert!(bench.kernel::<f64>(1000, &[64])[1..].iter().all(|v| *v == 0.0));
        let still = Bench::new("scan", 8000.0).asset(texture(), 16_000.0).steady("position", 0.02);
        let out = still.kernel::<f64>(100, &[64]);
        assert!(out.iter().all(|v| *v == out[0]));
    }

    #[test]
    fn hostile_positions_stay_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 1e5] {
            for looped in 0..2 {
                let bench = Bench::new("scan", 8000.0)
                    .asset(texture(), 16_000.0)
                    .choice("loop", looped)
                    .moving("position", 0.0, move |t| if t > 0.01 && t < 0.02 { bad } else { t });
                assert!(bench.kernel::<f32>(1000, &[64]).iter().all(|v| v.abs() < 2.0), "{bad}");
            }
        }
        let empty = Bench::new("scan", 8000.0).asset(Vec::new(), 16_000.0);
        assert!(empty.kernel::<f32>(10, &[64]).iter().all(|v| *v == 0.0));
    }
}
