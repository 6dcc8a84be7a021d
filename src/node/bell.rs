//! Bell filter.

use fundsp::svf::{BellMode, Svf, SvfParams};

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, signal, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::elementary::exp2;
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::svf::{LEAST_CUTOFF, MOST_CUTOFF};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "bell",
    family: Family::Filter,
    summary: "Lifts or lowers what lies around a frequency, and leaves the rest.",
    detail: "(s²/ω² + sA/qω + 1) / (s²/ω² + s/Aqω + 1), A = 10^(gain / 40): the gain at the frequency, 1 far from it. Two bells of opposite \
             gain cancel each other. It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency; the \
             unit `bell` of fundsp. The frequency is limited to 1 Hz to 0.45 of the rate, q to 0.1 to 100 and the gain to ±40 dB, at every sample; an input that is not a number \
             counts as 0. When nothing has been above −140 dB for a second, it is silent.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1e6, 1e6)),
            unit: "",
            doc: "What is filtered.",
        },
        Param {
            name: "frequency",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "gain",
            kind: Kind::Signal(Numeric::required(-40.0, 40.0)),
            unit: "dB",
            doc: "How much it lifts, or lowers where it is negative.",
        },
        Param {
            name: "q",
            kind: Kind::Signal(Numeric::or(1.0, 0.1, 100.0)),
            unit: "",
            doc: "How narrow it is.",
        },
    ],
    example: r#"body = { type = "bell", input = "string", frequency = 120, gain = 12, q = 3 }"#,
};

/// log2(10) / 20: a gain in dB as a power of two.
const OCTAVES: f64 = std::f64::consts::LOG2_10 / 20.0;

/// Eight filters.
#[derive(Clone)]
pub struct Lanes<R> {
    filters: Leaf<Svf<f64, BellMode<f64>>>,
    most: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let params = SvfParams { sample_rate: setup.rate, cutoff: 1000.0, q: 1.0, gain: 1.0 };
        Self {
            filters: Leaf::new(setup.rate, || Svf::new(BellMode::default(), &params)),
            most: MOST_CUTOFF * setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.filters.start(lane, |_| {});
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, frequency, gain, q] = [io.inputs[0], io.inputs[1], io.inputs[2], io.inputs[3]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (input, frequency, gain, q) = (input.at(frame), frequency.at(frame), gain.at(frame), q.at(frame));
            for l in 0..LANES {
                let frequency = within(frequency[l].wide(), LEAST_CUTOFF, self.most) as f32;
                let gain = exp2(within(gain[l].wide(), -40.0, 40.0) * OCTAVES) as f32;
                let q = within(q[l].wide(), 0.1, 100.0) as f32;
                out[l] = R::of(self.filters.pass(l, &[signal(input[l]), frequency, q, gain].into()).into());
            }
        }
    }

    fn settle(&mut self) {
        self.filters.settle();
    }
}

/// The definition: both integrators of the analog filter by the trapezoidal rule, dv1/dt = ω (x − k v1 − v2), dv2/dt = ω v1 with
/// k = 1 / Aq; what comes out is x + (A² − 1) k v1.
pub struct Exact {
    /// What the integrators hold, each with half a step of what it hears.
    states: Interleaved<[f64; 2]>,
    rate: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { states: Interleaved::new([0.0; 2], setup.rate, setup.engine_rate), rate: setup.engine_rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let [x, frequency, gain, q] = [inputs[0], inputs[1], inputs[2], inputs[3]];
        let g = (std::f64::consts::PI * frequency.clamp(1.0, 0.45 * self.rate) / self.rate).tan();
        let a = 10f64.powf(gain.clamp(-40.0, 40.0) / 40.0);
        let k = 1.0 / (a * q.clamp(0.1, 100.0));
        let [s1, s2] = self.states.turn();
        // v1 = s1 + g (x − k v1 − v2), v2 = s2 + g v1, solved for v1.
        let v1 = (*s1 + g * (x - *s2)) / (1.0 + g * k + g * g);
        let v2 = *s2 + g * v1;
        (*s1, *s2) = (2.0 * v1 - *s1, 2.0 * v2 - *s2);
        x + (a * a - 1.0) * k * v1
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
        for (frequency, gain, q) in [(5.0, 20.0, 0.7), (250.0, 40.0, 30.0), (300.0, -30.0, 2.0), (3000.0, 6.0, 0.1)] {
            let steady = Bench::new("bell", 8000.0)
                .moving("input", 0.0, tone)
                .steady("frequency", frequency)
                .steady("gain", gain)
                .steady("q", q);
            let error = steady.error_db::<f32>(80_000);
            assert!(error < -110.0, "{frequency} Hz: {error}");
        }
        for (rate, age) in [(7350.0, -1.0), (8000.0, -1.99)] {
            let moving = Bench::new("bell", rate)
                .age(age)
                .moving("input", 0.0, tone)
                .moving("frequency", 300.0, |t| 250.0 * (TAU * 13.0 * t).sin())
                .moving("gain", 0.0, |t| 20.0 * (TAU * 5.0 * t).sin())
                .moving("q", 5.0, |t| 4.0 * (TAU * 3.0 * t).cos());
            moving.check_contract();
            for error in [moving.error_db::<f32>(73_500), moving.error_db::<f64>(73_500)] {
                assert!(error < -110.0, "{rate} Hz: {error}");
            }
        }
    }

    #[test]
    fn the_same_filter_at_sixteen_times_the_rate() {
        let bench = Bench::new("bell", 8000.0)
            .moving("input", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) * (TAU * 240.0 * t).sin())
            .moving("frequency", 300.0, |t| 100.0 * (TAU * 5.0 * t).sin())
            .steady("gain", 12.0);
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -80.0, "{error}");
    }

    /// The amplitude of what has become of a sine of amplitude 1, in dB.
    fn response(hertz: f64, frequency: f64, gain: f64, q: f64) -> f64 {
        let bench = Bench::new("bell", 8000.0)
            .moving("input", 0.0, move |t| (TAU * hertz * t).sin())
            .steady("frequency", frequency)
            .steady("gain", gain)
            .steady("q", q);
        let out = bench.kernel::<f64>(24_000, &[64]);
        let power = out[16_000..].iter().map(|v| v * v).sum::<f64>() / 4000.0;
        10.0 * power.log10()
    }

    #[test]
    fn it_lifts_by_its_gain_and_leaves_the_rest() {
        for gain in [-12.0, 6.0, 30.0] {
            let at = response(200.0, 200.0, gain, 2.0);
            assert!((at - gain).abs() < 0.001, "{gain} dB: {at}");
            let far = response(2.0, 200.0, gain, 8.0);
            assert!(far.abs() < 0.1, "{gain} dB: {far} far away");
        }
        // On the way: |H|² = (x² + (A/q)²) / (x² + (1/Aq)²) with x = |s/ω − ω/s|, of the image by the tangent; here at x = A/q.
        let (a, q): (f64, f64) = (10f64.powf(12.0 / 40.0), 2.0);
        let ratio = a / q / 2.0 + (1.0 + (a / q / 2.0).powi(2)).sqrt();
        let warped = |hertz: f64| (std::f64::consts::PI * hertz / 8000.0).tan();
        let hertz = (warped(200.0) * ratio).atan() * 8000.0 / std::f64::consts::PI;
        let exact = 10.0 * (2.0 * (a / q).powi(2) / ((a / q).powi(2) + (1.0 / (a * q)).powi(2))).log10();
        let got = response(hertz, 200.0, 12.0, q);
        assert!((got - exact).abs() < 0.02, "{got} {exact}");
    }

    #[test]
    fn hostile_input_stays_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 4000.0, 0.0] {
            let bench = Bench::new("bell", 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving("frequency", 100.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .moving("gain", 1.0, move |t| if t < 0.03 { bad } else { 0.0 })
                .moving("q", 1.0, move |t| if t < 0.03 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 1e7), "{bad}");
        }
    }
}
