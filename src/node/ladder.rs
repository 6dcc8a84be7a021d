//! Ladder filter.

use fundsp::moog::Moog;
use fundsp::typenum::U3;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, signal, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "ladder",
    family: Family::Filter,
    summary: "A low-pass filter, 24 dB an octave, that rounds what is strong and may ring by itself.",
    detail: "After Moog's transistor ladder (US patent 3475623), in a form for samples at the engine's rate; the unit `moog` of fundsp. \
             With c = 2 cutoff / rate, p = c (1.8 − 0.8 c), k = 2 sin(πc/2) − 1, t = 1.386249 (1 − p) and r = resonance × \
             (12 + t² + 6t) / (12 + t² − 6t): x[n] = input − r s₄[n−1], sᵢ[n] = p (sᵢ₋₁[n] + sᵢ₋₁[n−1]) − k sᵢ[n−1], of s₄ the hyperbolic \
             tangent, which comes out. So the output stays within ±1, and the stronger the input, the rounder. Without resonance it amplifies low \
             frequencies, 1.7 times at most; the more resonance, the less. From a resonance of about 0.6 on (0.8 for 1 kHz) it goes on ringing \
             near the cutoff by itself, once it has heard something, until the voice ends. The cutoff is limited to 1 Hz to 0.45 of the rate, the resonance to 0 to 1, at every sample. \
             An input that is not a number counts as 0. When nothing has been above −140 dB for a second, it is silent.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1e6, 1e6)),
            unit: "",
            doc: "What is filtered; below ±0.3 hardly rounded.",
        },
        Param {
            name: "cutoff",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "resonance",
            kind: Kind::Signal(Numeric::or(0.3, 0.0, 1.0)),
            unit: "",
            doc: "How much of the output is fed back.",
        },
    ],
    example: r#"growl = { type = "ladder", input = "saw", cutoff = "80 + 400 * hit", resonance = 0.5 }"#,
};

/// The highest cutoff as a share of the rate.
const MOST: f64 = 0.45;

/// Eight filters.
#[derive(Clone)]
pub struct Lanes<R> {
    filters: Leaf<Moog<f64, U3>>,
    most: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self {
            filters: Leaf::new(setup.rate, || Moog::new(1000.0, 0.0)),
            most: MOST * setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.filters.start(lane, |_| {});
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, cutoff, resonance] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (input, cutoff, resonance) = (input.at(frame), cutoff.at(frame), resonance.at(frame));
            for l in 0..LANES {
                let cutoff = within(cutoff[l].wide(), 1.0, self.most) as f32;
                let resonance = within(resonance[l].wide(), 0.0, 1.0) as f32;
                let now = self.filters.pass(l, &[signal(input[l]), cutoff, resonance].into());
                out[l] = R::of(now.into());
            }
        }
    }

    fn settle(&mut self) {
        self.filters.settle();
    }
}

/// The definition.
pub struct Exact {
    /// What the four stages heard last, and what they said: each hears what the one before says.
    stages: Interleaved<[f64; 5]>,
    rate: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let stages = Interleaved::new([0.0; 5], setup.rate, setup.engine_rate);
        Self { stages, rate: setup.engine_rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let c = 2.0 * inputs[1].clamp(1.0, 0.45 * self.rate) / self.rate;
        let p = c * (1.8 - 0.8 * c);
        let k = 2.0 * (std::f64::consts::FRAC_PI_2 * c).sin() - 1.0;
        let t = 1.386249 * (1.0 - p);
        let r = inputs[2].clamp(0.0, 1.0) * (12.0 + t * t + 6.0 * t) / (12.0 + t * t - 6.0 * t);
        let s = self.stages.turn();
        let mut now = [inputs[0] - r * s[4]; 5];
        for i in 1..5 {
            now[i] = p * (now[i - 1] + s[i - 1]) - k * s[i];
        }
        now[4] = now[4].tanh();
        *s = now;
        now[4]
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    fn tone(t: f64) -> f64 {
        (TAU * 60.0 * t).sin() + 0.5 * (TAU * 311.0 * t).cos()
    }

    #[test]
    fn steady_and_moving() {
        for (cutoff, resonance) in [(5.0, 0.0), (250.0, 0.55), (3000.0, 0.3), (120.0, 0.9)] {
            let steady = Bench::new("ladder", 8000.0)
                .moving("input", 0.0, tone)
                .steady("cutoff", cutoff)
                .steady("resonance", resonance);
            for error in [steady.error_db::<f32>(80_000), steady.error_db::<f64>(80_000)] {
                assert!(error < -110.0, "{cutoff} Hz: {error}");
            }
        }
        for (rate, age) in [(7350.0, -1.0), (8000.0, -1.99)] {
            let moving = Bench::new("ladder", rate)
                .age(age)
                .moving("input", 0.0, |t| 3.0 * tone(t))
                .moving("cutoff", 300.0, |t| 250.0 * (TAU * 13.0 * t).sin())
                .moving("resonance", 0.4, |t| 0.3 * (TAU * 3.0 * t).cos());
            moving.check_contract();
            let error = moving.error_db::<f32>(73_500);
            assert!(error < -110.0, "{rate} Hz: {error}");
        }
    }

    #[test]
    fn the_same_filter_at_sixteen_times_the_rate() {
        let bench = Bench::new("ladder", 8000.0)
            .moving("input", 0.0, |t| 0.5 * (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) * (TAU * 140.0 * t).sin())
            .moving("cutoff", 300.0, |t| 100.0 * (TAU * 5.0 * t).sin())
            .steady("resonance", 0.4);
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -80.0, "{error}");
    }

    /// A sine of amplitude `size` comes out with that power, as a share of its own.
    fn gain(hertz: f64, size: f64, cutoff: f64, resonance: f64) -> f64 {
        let bench = Bench::new("ladder", 8000.0)
            .moving("input", 0.0, move |t| size * (TAU * hertz * t).sin())
            .steady("cutoff", cutoff)
            .steady("resonance", resonance);
        let out = bench.kernel::<f64>(24_000, &[64]);
        (out[16_000..].iter().map(|v| v * v).sum::<f64>() / 4000.0).sqrt() / size
    }

    #[test]
    fn what_is_weak_is_filtered_by_four_poles() {
        // Of the linear filter: its stages at 0 Hz have 2p / (1 + k), and the loop takes r of the fourth power.
        let c: f64 = 2.0 * 200.0 / 8000.0;
        let (p, k) = (c * (1.8 - 0.8 * c), 2.0 * (TAU / 4.0 * c).sin() - 1.0);
        let open = (2.0 * p / (1.0 + k)).powi(4);
        let t = 1.386249 * (1.0 - p);
        let loops = (12.0 + t * t + 6.0 * t) / (12.0 + t * t - 6.0 * t);
        for resonance in [0.0, 0.2] {
            let (got, exact) = (gain(2.0, 1e-3, 200.0, resonance), open / (1.0 + resonance * loops * open));
            assert!((got / exact - 1.0).abs() < 0.01, "{resonance}: {got} {exact}");
        }
        let fall = 20.0 * (gain(1600.0, 1e-3, 100.0, 0.0) / gain(800.0, 1e-3, 100.0, 0.0)).log10();
        // The bilinear image falls a little faster than 24 dB.
        assert!((-29.0..-23.0).contains(&fall), "{fall}");
    }

    #[test]
    fn what_is_strong_is_rounded() {
        assert!(gain(50.0, 5.0, 1000.0, 0.1) < 0.3 * gain(50.0, 0.1, 1000.0, 0.1));
    }

    #[test]
    fn much_resonance_rings_by_itself_near_the_cutoff() {
        for (cutoff, resonance) in [(80.0, 0.8), (250.0, 0.8)] {
            let struck = Bench::new("ladder", 8000.0)
                .moving("input", 0.0, |t| if t.abs() < 0.001 { 0.5 } else { 0.0 })
                .steady("cutoff", cutoff)
                .steady("resonance", resonance);
            let out = struck.kernel::<f64>(32_000, &[64]);
            let rises = out[16_000..].windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count();
            let hertz = rises as f64 / 2.0;
            assert!((0.9..1.15).contains(&(hertz / cutoff)), "{cutoff} Hz: {hertz}");
            let damped = struck.steady("resonance", 0.4).kernel::<f64>(32_000, &[64]);
            assert!(damped[24_000..].iter().all(|v| *v == 0.0));
        }
    }

    #[test]
    fn hostile_input_stays_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 4000.0, 0.0] {
            let bench = Bench::new("ladder", 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving("cutoff", 100.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .moving("resonance", 0.5, move |t| if t < 0.03 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() <= 1.0), "{bad}");
        }
    }
}
