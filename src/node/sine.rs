//! Sine oscillator.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::phase;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "sine",
    family: Family::Oscillator,
    summary: "A sine.",
    detail: "amplitude × sin 2π(∫ frequency dt + phase). The phase is 0 at the onset, which may fall between samples. \
             A frequency that is moved by a signal may be negative; beyond half the engine's rate it folds, as any sampled sine does.",
    params: &[
        Param {
            name: "frequency",
            kind: Kind::Frequency(Numeric::required(-4000.0, 4000.0)),
            unit: "Hz",
            doc: "Frequency; moving it is frequency modulation.",
        },
        Param {
            name: "phase",
            kind: Kind::Signal(Numeric::or(0.0, -1e6, 1e6)),
            unit: "turns",
            doc: "Added to the phase; moving it is phase modulation.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Peak value; moving it is amplitude modulation.",
        },
    ],
    example: r#"tone = { type = "sine", frequency = 250 }"#,
};

/// Phase and step of eight lanes.
#[derive(Debug)]
pub struct Lanes<R> {
    phase: [u64; LANES],
    step: [u64; LANES],
    turns_a_hertz: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self {
            phase: [0; LANES],
            step: [0; LANES],
            turns_a_hertz: 1.0 / setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let turns = onset.start[0] * self.turns_a_hertz;
        self.step[lane] = phase::turns(turns);
        self.phase[lane] = phase::turns(turns * onset.age);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [frequency, phase, amplitude] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let (mut angle, step) = (self.phase, self.step);
        if frequency.is_steady() && phase.is_steady() {
            let mut shift = [0; LANES];
            for l in 0..LANES {
                shift[l] = phase::deviation(wrapped(phase.base[l]));
            }
            for (frame, out) in io.output.iter_mut().enumerate() {
                let gain = amplitude.at(frame);
                for l in 0..LANES {
                    out[l] = R::sine(angle[l].wrapping_add(shift[l])) * gain[l];
                    angle[l] = angle[l].wrapping_add(step[l]);
                }
            }
        } else {
            for (frame, out) in io.output.iter_mut().enumerate() {
                let (hertz, turns, gain) = (frequency.at(frame), phase.at(frame), amplitude.at(frame));
                for l in 0..LANES {
                    let shift = phase::deviation(wrapped(turns[l].wide()));
                    out[l] = R::sine(angle[l].wrapping_add(shift)) * gain[l];
                    let bend = phase::deviation(wrapped(hertz[l].wide() * self.turns_a_hertz));
                    angle[l] = angle[l].wrapping_add(step[l]).wrapping_add(bend);
                }
            }
        }
        self.phase = angle;
    }
}

/// Turns without their whole part, within ±½.
#[inline(always)]
fn wrapped(turns: f64) -> f64 {
    turns - (turns + 0.5).floor()
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    turns: f64,
    previous: Option<(f64, f64)>,
}

impl Exact {
    /// For one voice.
    pub fn new(_setup: &Setup, _onset: &Onset) -> Self {
        Self { turns: 0.0, previous: None }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        match self.previous {
            // The frequency holds for a sample, as it does in any sampled oscillator.
            Some((before, hertz)) => self.turns += hertz * (t - before),
            None => self.turns = inputs[0] * t,
        }
        self.turns -= self.turns.floor();
        self.previous = Some((t, inputs[0]));
        inputs[2] * (std::f64::consts::TAU * (self.turns + inputs[1])).sin()
    }
}
