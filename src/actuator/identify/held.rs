//! A small linear system behind a drive that is held over each sample and arrives with a delay.

use crate::actuator::exponential::{Square, exponential};

/// ẋ = A x + B u, y = C x + D u; up to three states.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held {
    /// States.
    pub size: usize,
    /// A, and B in the column behind it.
    pub matrix: [[f64; 4]; 3],
    /// C, and D behind it.
    pub output: [f64; 4],
}

/// The largest delay or lead, samples.
const MOST_DELAY: f64 = 1e7;

impl Held {
    /// A resonance with a pole pair s² + (ω/Q) s + ω² behind a lag (s; 0: none), as an acceleration: s² over both.
    pub fn resonance(omega: f64, q: f64, lag: f64) -> Self {
        let bend = [-omega * omega, -omega / q];
        let push = [bend[0], bend[1], 1.0, 0.0];
        if lag > 0.0 {
            let matrix = [[0.0, 1.0, 0.0, 0.0], push, [0.0, 0.0, -1.0 / lag, 1.0 / lag]];
            Self { size: 3, matrix, output: push }
        } else {
            Self { size: 2, matrix: [[0.0, 1.0, 0.0, 0.0], push, [0.0; 4]], output: push }
        }
    }

    /// The same without what comes through at once: −((ω/Q) s + ω²) over the pole pair.
    pub fn rings(omega: f64, q: f64) -> Self {
        let all = Self::resonance(omega, q, 0.0);
        Self { output: [all.output[0], all.output[1], 0.0, 0.0], ..all }
    }

    /// The current of a coil that moves: V = R i + L di/dt + s, where s′ is what the coil's motion gives:
    /// s″ + (ω/Q) s′ + ω² s = m i, with the open-circuit pole pair and m = Bl²/μ.
    pub fn coil(resistance: f64, inductance: f64, motion: f64, omega: f64, q: f64) -> Self {
        let bend = [-omega * omega, -omega / q];
        if inductance > 0.0 {
            let per = 1.0 / inductance;
            let matrix =
                [[0.0, 1.0, 0.0, 0.0], [bend[0], bend[1], motion, 0.0], [0.0, -per, -resistance * per, per]];
            Self { size: 3, matrix, output: [0.0, 0.0, 1.0, 0.0] }
        } else {
            let g = 1.0 / resistance;
            let push = [bend[0], bend[1] - motion * g, motion * g, 0.0];
            Self { size: 2, matrix: [[0.0, 1.0, 0.0, 0.0], push, [0.0; 4]], output: [0.0, -g, g, 0.0] }
        }
    }

    /// What comes out at the beginning of each sample; `None` where the numbers cannot be.
    pub fn play(&self, drive: &[f64], period: f64, delay: f64) -> Option<Vec<f64>> {
        let shift = delay / period;
        let sound = shift.abs() < MOST_DELAY
            && self.matrix[..self.size].iter().flatten().chain(&self.output).all(|x| x.is_finite());
        if !sound {
            return None;
        }
        // A drive begins a share of a sample behind the sample's own beginning; before it, the last one acts.
        let (whole, share) = (shift.floor() as isize, shift - shift.floor());
        let [first, second] = [share, 1.0 - share].map(|part| self.over(part * period));
        let at = |n: isize| if n < 0 { 0.0 } else { drive[(n as usize).min(drive.len() - 1)] };
        let mut x = [0.0; 3];
        let mut out = Vec::with_capacity(drive.len());
        for n in 0..drive.len() as isize {
            let [before, behind] = [at(n - whole - 1), at(n - whole)];
            let c = &self.output;
            let third = if self.size == 3 { c[2] } else { 0.0 };
            // What comes through at once is the mean over a sample around the instant, as converters have it: without that, what
            // comes out would not change with the delay but in leaps.
            let through = if share < 0.5 {
                (0.5 + share) * before + (0.5 - share) * behind
            } else {
                (share - 0.5) * at(n - whole - 2) + (1.5 - share) * before
            };
            out.push(c[0] * x[0] + c[1] * x[1] + third * x[2] + c[self.size] * through);
            for (step, drive) in [(&first, before), (&second, behind)] {
                let change: [f64; 3] = std::array::from_fn(|i| {
                    let row = &step[i];
                    row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] * drive
                });
                x = std::array::from_fn(|i| x[i] + change[i]);
            }
        }
        x.iter().all(|x| x.is_finite()).then_some(out)
    }

    /// e^(A t) − 1, and what a held drive adds.
    fn over(&self, t: f64) -> [[f64; 4]; 3] {
        let mut a: Square = Default::default();
        for i in 0..self.size {
            a[i][..=self.size].copy_from_slice(&self.matrix[i][..=self.size]);
        }
        let e = exponential(&a, self.size + 1, t);
        std::array::from_fn(|i| {
            let mut row = [0.0; 4];
            if i < self.size {
                row[..self.size].copy_from_slice(&e[i][..self.size]);
                row[3] = e[i][self.size];
            }
            row
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Held;
    use crate::actuator::coil::model::Model;
    use crate::actuator::coil::parameters::{Coil, Inertial, Spring, Tissue};
    use crate::actuator::coil::plant::Plant;
    use crate::actuator::drive::Drive;

    const RATE: f64 = 8000.0;

    fn motor(inductance: f64) -> Inertial {
        Inertial {
            coil: Coil { resistance: 6.0, inductance, force_factor: 1.5 },
            slug_mass: 5.5e-3,
            casing_mass: 0.1,
            suspension: Spring { stiffness: 741.0, damping: 0.983 },
            hand: Tissue::default(),
        }
    }

    /// A drive that changes at every sample.
    fn drive() -> Vec<f64> {
        (0..800).map(|n| f64::from(n * 7919 % 31) / 10.0 - 1.5).collect()
    }

    /// The coil against the exact model of the project: its current, with inductance and without.
    #[test]
    fn the_current_is_that_of_the_model() {
        for inductance in [0.0, 2e-4, 5e-3] {
            let m = motor(inductance);
            let mu = 1.0 / (1.0 / m.slug_mass + 1.0 / m.casing_mass);
            let omega = (m.suspension.stiffness / mu).sqrt();
            let held = Held::coil(6.0, inductance, 1.5 * 1.5 / mu, omega, mu * omega / m.suspension.damping);
            let mut model = Model::new(&Plant::inertial(&m).unwrap(), RATE, Drive::Voltage).unwrap();
            let current = held.play(&drive(), 1.0 / RATE, 0.0).unwrap();
            for (n, volts) in drive().iter().enumerate().take(799) {
                // Without inductance the current leaps with the voltage: half of that leap.
                let leap = if inductance > 0.0 { 0.0 } else { 0.5 * (drive()[n + 1] - volts) / 6.0 };
                let is = model.step(*volts).current + leap;
                assert!((current[n + 1] - is).abs() < 1e-12, "{inductance} {n}: {} {is}", current[n + 1]);
            }
        }
    }

    /// The casing without inductance against the same, with a delay of whole samples and of half a sample by a rate twice as high.
    #[test]
    fn the_acceleration_is_that_of_the_model_however_late() {
        let m = motor(0.0);
        let plant = Plant::inertial(&m).unwrap();
        let pair = plant.resonance(Drive::Voltage).unwrap();
        let gain = -1.5 / (m.casing_mass * 6.0);
        for half in [0_i32, 1, 2, 7] {
            let mut model = Model::new(&plant, 2.0 * RATE, Drive::Voltage).unwrap();
            let held = Held::resonance(pair.omega(), pair.q, 0.0);
            let out = held.play(&drive(), 1.0 / RATE, f64::from(half) * 0.5 / RATE).unwrap();
            let at = |n: i32| if n < 0 { 0.0 } else { drive()[n as usize] };
            let mut casing = 0.0;
            for n in 0..1600_i32 {
                // Half of the leap that comes through at once.
                let [before, behind] = [n - 1 - half, n - half].map(|n| at(n.div_euclid(2)));
                if n % 2 == 0 {
                    let due = casing + gain * 0.5 * (behind - before);
                    assert!((gain * out[n as usize / 2] - due).abs() < 1e-11, "{half} {n}");
                }
                casing = model.step(behind).casing;
            }
        }
        // A lead is a delay back.
        let held = Held::resonance(pair.omega(), pair.q, 1e-4);
        let [now, ahead] = [0.0, -3.25 / RATE].map(|d| held.play(&drive(), 1.0 / RATE, d).unwrap());
        let back = held.play(&drive()[3..], 1.0 / RATE, -0.25 / RATE).unwrap();
        assert!(now != ahead && (ahead[700] - back[700]).abs() < 1e-6 * back[700].abs().max(1.0));
        assert!(held.play(&drive(), 1.0 / RATE, f64::NAN).is_none());
        assert!(Held::resonance(f64::NAN, 1.0, 0.0).play(&drive(), 1e-4, 0.0).is_none());
    }

    /// A lag of its own against the product of two frequency responses: a steady sine of whole samples a period.
    #[test]
    fn a_lag_is_a_factor_of_the_response() {
        let (omega, q, lag, rate) = (600.0, 3.0, 4e-4, 96e3);
        let hertz = 200.0;
        let sine: Vec<f64> =
            (0..96_000).map(|n| (std::f64::consts::TAU * hertz * f64::from(n) / rate).cos()).collect();
        let out = Held::resonance(omega, q, lag).play(&sine, 1.0 / rate, 0.0).unwrap();
        let s = crate::dsp::complex::Complex::oscillation(hertz);
        let due = s * s / ((s * s + s * (omega / q) + omega * omega) * (s * lag + 1.0));
        let peak = out[90_000..].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // The hold takes 1 − sinc(f/rate), 7e-6.
        assert!((peak / due.abs() - 1.0).abs() < 1e-4, "{peak} {}", due.abs());
    }
}
