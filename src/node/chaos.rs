//! Chaotic movement.

use fundsp::audionode::AudioNode;
use fundsp::oscillator::{Lorenz, Rossler};

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, Sampled, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "chaos",
    family: Family::Noise,
    summary: "A movement that swings, but never the same way twice.",
    detail: "The first number of a system of three, from Euler's rule at the engine's rate; the units `lorenz` and `rossler` of fundsp. \
             `lorenz` (J. Atmospheric Sciences 20, 1963) dx = 10 (y − x), dy = x (28 − z) − y, dz = xy − 8z/3 with 0.75 frequency units \
             of time a second, out comes 0.05107 x: it circles on one side, and goes over to the other when one expects it least. `roessler` \
             (Physics Letters 57A, 1976) dx = −y − z, dy = x + 0.15 y, dz = 0.2 + z (x − 10) with 5.88 frequency units a second, \
             out comes 0.05757 x: a swing that stays in step, but for its size. It begins at y = z = 1 and x random in 0 to 1 from the stream of the \
             node in the voice: the same seed gives the same movement. All of it in 32 bits, in the order written here, since of a chaotic system any other \
             rounding makes another movement. Peaks lie within ±1.2 amplitude, the RMS is 0.4 to 0.55 amplitude. The sequence begins with the \
             voice's first sample, one to two samples ahead of the onset; between samples it is band-limited.",
    params: &[
        Param {
            name: "system",
            kind: Kind::Choice(&["lorenz", "roessler"], 0),
            unit: "",
            doc: "Which of the two.",
        },
        Param {
            name: "frequency",
            kind: Kind::Start(Numeric::required(0.0, MOST)),
            unit: "Hz",
            doc: "Swings a second, on average and within a tenth; read when the voice starts.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"unrest = { type = "chaos", frequency = 4, amplitude = 0.3 }"#,
};

/// Beyond this Euler's rule is near its end.
const MOST: f64 = 75.0;
/// Units of time a swing; the other unit of fundsp has its time multiplied by 2.91.
const LORENZ: f64 = 0.75;
const ROSSLER: f64 = 5.88 / 2.91;

/// Eight systems.
#[derive(Clone)]
pub struct Lanes<R> {
    system: System,
    frequency: [f32; LANES],
    _real: std::marker::PhantomData<R>,
}

#[derive(Clone)]
enum System {
    Lorenz(Leaf<Lorenz>),
    Rossler(Leaf<Rossler>),
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let system = match setup.choices.first() {
            Some(&1) => System::Rossler(Leaf::new(setup.rate, Rossler::new)),
            _ => System::Lorenz(Leaf::new(setup.rate, Lorenz::new)),
        };
        Self { system, frequency: [0.0; LANES], _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.turn(lane, onset.start[0]);
        match &mut self.system {
            System::Lorenz(leaf) => leaf.start(lane, |unit| unit.set_hash(onset.stream)),
            System::Rossler(leaf) => leaf.start(lane, |unit| unit.set_hash(onset.stream)),
        }
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.turn(lane, now[0]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[1];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let gain = amplitude.at(frame);
            for l in 0..LANES {
                let frequency = [self.frequency[l]].into();
                let x = match &mut self.system {
                    System::Lorenz(leaf) => leaf.draw(l, &frequency),
                    System::Rossler(leaf) => leaf.draw(l, &frequency),
                };
                out[l] = R::of(x.into()) * gain[l];
            }
        }
    }
}

impl<R> Lanes<R> {
    /// Lets a lane swing so often a second.
    fn turn(&mut self, lane: usize, frequency: f64) {
        let unit = if let System::Lorenz(_) = self.system { LORENZ } else { ROSSLER };
        self.frequency[lane] = (unit * within(frequency, 0.0, MOST)) as f32;
    }
}

/// The definition.
pub struct Exact {
    system: Sampled,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let frequency = onset.start[0].clamp(0.0, 75.0);
        let rate = setup.engine_rate as f32;
        let (mut x, mut y, mut z) = (begin(onset.stream), 1.0_f32, 1.0_f32);
        let system = if setup.choices[0] == 0 {
            let dt = (frequency * 0.75) as f32 / rate;
            Sampled::new(setup, onset, move || {
                let slopes = [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
                (x, y, z) = (x + slopes[0] * dt, y + slopes[1] * dt, z + slopes[2] * dt);
                f64::from(0.05107 * x)
            })
        } else {
            let dt = 2.91 * (frequency * (5.88 / 2.91)) as f32 / rate;
            Sampled::new(setup, onset, move || {
                let slopes = [-y - z, x + 0.15 * y, 0.2 + z * (x - 10.0)];
                (x, y, z) = (x + slopes[0] * dt, y + slopes[1] * dt, z + slopes[2] * dt);
                f64::from(0.05757 * x)
            })
        };
        Self { system }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        inputs[1] * self.system.at(t)
    }
}

/// A number in 0 to 1 from a stream: the output function of SplitMix64 (Steele, Lea, Flood, 2014).
fn begin(stream: u64) -> f32 {
    let mut x = (stream ^ 0x5555_5555_5555_5555).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ x >> 31) >> 11) as f32 / 2f32.powi(53)
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    fn system(rate: f64, choice: usize, frequency: f64) -> Bench {
        Bench::new("chaos", rate).choice("system", choice).steady("frequency", frequency)
    }

    #[test]
    fn the_kernel_follows_its_twin() {
        for (rate, age, choice, frequency) in
            [(8000.0, -1.0, 0, 8.0), (7350.0, -1.99, 1, 8.0), (7350.0, -1.3, 0, 75.0), (8000.0, -1.7, 1, 75.0)]
        {
            let bench = system(rate, choice, frequency).age(age).moving("amplitude", 1.0, |t| 0.5 * t.sin());
            bench.check_contract();
            let error = bench.error_db::<f32>(80_000);
            assert!(error < -130.0, "{choice}, {frequency} Hz: {error}");
        }
    }

    #[test]
    fn between_samples_it_is_band_limited() {
        let bench = system(8000.0, 0, 20.0).moving("amplitude", 0.0, |t| 1.0 - (100.0 * t.max(0.0)).cos());
        let error = bench.band_error_db::<f32>(3000, 16);
        assert!(error < -80.0, "{error}");
    }

    /// Circles are counted by the peaks, of which Lorenz's first number has one a circle and Rössler's too.
    #[test]
    fn it_swings_as_often_as_it_is_told_and_stays_within_its_bounds() {
        for (choice, frequency) in [(0, 5.0), (0, 40.0), (0, 75.0), (1, 5.0), (1, 40.0), (1, 75.0)] {
            for rate in [7350.0, 8000.0] {
                let out = system(rate, choice, frequency).kernel::<f64>((20.0 * rate) as usize, &[64]);
                let out = &out[(2.0 * rate) as usize..];
                let peaks = out.windows(3).filter(|w| w[1].abs() > w[0].abs() && w[1].abs() >= w[2].abs());
                let peaks = peaks.filter(|w| choice == 0 || w[1] > 0.0).count();
                let swings = peaks as f64 / 18.0 / frequency;
                assert!((0.9..1.1).contains(&swings), "{choice}, {frequency} Hz: {swings}");
                let power = out.iter().map(|v| v * v).sum::<f64>() / out.len() as f64;
                assert!((0.35..0.6).contains(&power.sqrt()), "{choice}, {frequency} Hz: {}", power.sqrt());
                assert!(out.iter().all(|v| v.abs() < 1.3));
            }
        }
    }

    #[test]
    fn voices_part_company() {
        let of = |stream: u64| {
            let mut bench = system(8000.0, 0, 20.0);
            bench.stream = stream;
            bench.kernel::<f64>(40_000, &[64])
        };
        assert_eq!(of(1), of(1));
        let (a, b) = (of(1), of(2));
        let cross: f64 = a[20_000..].iter().zip(&b[20_000..]).map(|(a, b)| a * b).sum();
        assert!(cross.abs() < 0.5 * a[20_000..].iter().map(|v| v * v).sum::<f64>(), "{cross}");
    }

    #[test]
    fn hostile_frequencies_are_limited() {
        for choice in [0, 1] {
            for bad in [f64::NAN, f64::INFINITY, -1e30, 0.0, 1e9] {
                let out = system(7350.0, choice, bad).kernel::<f32>(20_000, &[64]);
                assert!(out.iter().all(|v| v.abs() < 1.3), "{bad}");
            }
        }
    }
}
