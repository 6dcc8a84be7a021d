//! Sweep: a sine that glides from one frequency to another.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::elementary::{exp2, fraction};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::quadrature::bend;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "sweep",
    family: Family::Oscillator,
    summary: "A sine that glides from one frequency to another.",
    detail: "amplitude × sin 2π(Φ(t) + phase), Φ the integral of the frequency from the onset in closed form, so that no error builds up. \
             `linear`: f = from + (to − from) t / duration; `exponential`: f = from (to / from)^(t / duration), which needs two frequencies of the \
             same sign and is linear where they are not. Before the onset f is `from`, after `duration` it stays `to`; with a \
             duration of 0 it is `to` at once. A phase beyond ±2048 turns counts as 0.",
    params: &[
        Param {
            name: "law",
            kind: Kind::Choice(&["linear", "exponential"], 0),
            unit: "",
            doc: "How the frequency moves.",
        },
        Param {
            name: "from",
            kind: Kind::Start(Numeric::required(-4000.0, 4000.0)),
            unit: "Hz",
            doc: "Frequency at the onset.",
        },
        Param {
            name: "to",
            kind: Kind::Start(Numeric::required(-4000.0, 4000.0)),
            unit: "Hz",
            doc: "Frequency at the end.",
        },
        Param {
            name: "duration",
            kind: Kind::Start(Numeric::required(0.0, 86_400.0)),
            unit: "s",
            doc: "How long it takes.",
        },
        Param {
            name: "phase",
            kind: Kind::Signal(Numeric::or(0.0, -2048.0, 2048.0)),
            unit: "turns",
            doc: "Added to the phase; moving it is phase modulation.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Peak value.",
        },
    ],
    example: r#"rise = { type = "sweep", law = "exponential", from = 40, to = 300, duration = 1.5 }"#,
};

/// Eight sweeps.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    exponential: bool,
    period: f64,
    /// Voice time of the next sample, in samples; whole samples are counted, so it stays exact.
    age: [f64; LANES],
    count: [f64; LANES],
    duration: [f64; LANES],
    /// Φ = size × (2^(octaves × t) − 1) + linear × t + square × t², t from 0 to the duration.
    octaves: [f64; LANES],
    size: [f64; LANES],
    linear: [f64; LANES],
    square: [f64; LANES],
    /// Frequency before the onset and after the end, and Φ at the end.
    from: [f64; LANES],
    to: [f64; LANES],
    end: [f64; LANES],
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let zero = [0.0; LANES];
        Self {
            exponential: setup.choices.first() == Some(&1),
            period: 1.0 / setup.rate,
            age: zero,
            count: zero,
            duration: zero,
            octaves: zero,
            size: zero,
            linear: zero,
            square: zero,
            from: zero,
            to: zero,
            end: zero,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let [from, to, duration] =
            [0, 1, 2].map(|k| if onset.start[k].is_finite() { onset.start[k] } else { 0.0 });
        let l = lane;
        self.age[l] = onset.age;
        self.count[l] = 0.0;
        self.duration[l] = duration.max(0.0);
        self.from[l] = if duration > 0.0 { from } else { to };
        self.to[l] = to;
        let ratio = to / from;
        [self.octaves[l], self.size[l], self.linear[l], self.square[l], self.end[l]] = [0.0; 5];
        if duration <= 0.0 {
            return;
        }
        // Closer than this the exponential is a straight line, and its formula would lose digits.
        if self.exponential && ratio > 0.0 && ratio.is_finite() && ratio.ln().abs() > 1e-5 {
            self.octaves[l] = ratio.log2() / duration;
            self.size[l] = from * duration / ratio.ln();
            self.end[l] = self.size[l] * (ratio - 1.0);
        } else {
            self.linear[l] = from;
            self.square[l] = (to - from) / (2.0 * duration);
            self.end[l] = (from + to) / 2.0 * duration;
        }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [phase, amplitude] = [io.inputs[3], io.inputs[4]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (shift, gain) = (phase.at(frame), amplitude.at(frame));
            for l in 0..LANES {
                let t = (self.count[l] + self.age[l]) * self.period;
                let before = if t < 0.0 { t } else { 0.0 };
                let after = if t > self.duration[l] { t - self.duration[l] } else { 0.0 };
                let within = t - before - after;
                let mut turns = within * (self.linear[l] + within * self.square[l]);
                if self.exponential {
                    turns += self.size[l] * (exp2(self.octaves[l] * within) - 1.0);
                }
                let turns = if after > 0.0 { self.end[l] } else { turns };
                let turns = turns + before * self.from[l] + after * self.to[l];
                out[l] = R::sine(bend(fraction(turns)).wrapping_add(bend(shift[l].wide()))) * gain[l];
                self.count[l] += 1.0;
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    exponential: bool,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { exponential: setup.choices.first() == Some(&1) }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let [from, to, duration] = [inputs[0], inputs[1], inputs[2]];
        let turns_to = |t: f64| {
            let share = t / duration;
            if self.exponential && from * to > 0.0 && from != to {
                let ratio = to / from;
                from * duration * (ratio.powf(share) - 1.0) / ratio.ln()
            } else {
                duration * (from * share + (to - from) * share * share / 2.0)
            }
        };
        let turns = if duration <= 0.0 {
            to * t
        } else if t < 0.0 {
            from * t
        } else if t <= duration {
            turns_to(t)
        } else {
            turns_to(duration) + to * (t - duration)
        };
        inputs[4] * (std::f64::consts::TAU * (turns + inputs[3])).sin()
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn both_laws_follow_their_twin() {
        for law in 0..2 {
            for (from, to, duration) in
                [(40.0, 400.0, 3.0), (400.0, 40.0, 30.0), (-40.0, 40.0, 2.0), (100.0, 100.0, 1.0), (20.0, 30.0, 0.0)]
            {
                let bench = Bench::new("sweep", 8000.0)
                    .age(-1.7)
                    .choice("law", law)
                    .steady("from", from)
                    .steady("to", to)
                    .steady("duration", duration)
                    .moving("phase", 0.0, |t| (9.0 * t).sin());
                bench.check_contract();
                let error = bench.error_db::<f32>(80_000);
                assert!(error < -120.0, "{law}, {from} to {to} Hz: {error}");
                assert!(bench.error_db::<f64>(80_000) < -200.0);
            }
        }
    }

    #[test]
    fn hostile_frequencies_stay_finite() {
        for bad in [f64::NAN, f64::INFINITY, 1e300, 0.0] {
            for law in 0..2 {
                let bench = Bench::new("sweep", 8000.0)
                    .choice("law", law)
                    .steady("from", bad)
                    .steady("to", 1e-300)
                    .steady("duration", 1e300);
                assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() <= 1.000_001), "{bad}");
            }
        }
    }
}
