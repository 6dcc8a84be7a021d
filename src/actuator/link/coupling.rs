//! Coupling that keeps steady voltages off: capacitors, each with a resistance behind it.

use crate::actuator::exponential::{MOST, exponential};
use crate::actuator::fault::{Fault, positive};
use crate::dsp::complex::Complex;

/// First-order high-passes in series, none to two: that of the card, that of the amplifier.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Corners {
    hertz: [f64; 2],
    count: usize,
}

impl Corners {
    /// Everything passes.
    pub const fn none() -> Self {
        Self { hertz: [0.0; 2], count: 0 }
    }

    /// One, at so many hertz.
    pub const fn one(hertz: f64) -> Self {
        Self { hertz: [hertz, 0.0], count: 1 }
    }

    /// Two in series, the second unloaded by the first.
    pub const fn two(first: f64, second: f64) -> Self {
        Self { hertz: [first, second], count: 2 }
    }

    /// As many as there are of two.
    pub fn of(first: Option<f64>, second: Option<f64>) -> Self {
        match (first, second) {
            (Some(first), Some(second)) => Self::two(first, second),
            (Some(one), None) | (None, Some(one)) => Self::one(one),
            (None, None) => Self::none(),
        }
    }

    /// Their frequencies, hertz.
    pub fn hertz(&self) -> &[f64] {
        &self.hertz[..self.count]
    }

    pub(super) fn check(&self) -> Result<(), Fault> {
        self.hertz().iter().try_for_each(|&hertz| positive("high_pass", hertz))
    }

    /// Response at a frequency (Hz): s / (s + ω) of each.
    pub fn response(&self, hertz: f64) -> Complex {
        let s = Complex::oscillation(hertz);
        let one = |corner: &f64| s / (s + std::f64::consts::TAU * corner);
        self.hertz().iter().map(one).fold(Complex::new(1.0, 0.0), |a, b| a * b)
    }
}

/// Coupling in time, its input held over each sample: ċ = ω (u − c) for each capacitor, whose output u − c is the next one's input.
///
/// Exact, by the matrix exponential; the output over a sample is given by its mean, so that its volt-seconds are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HighPass {
    count: usize,
    charge: [f64; 2],
    /// What a sample adds to the charges, by charge; by the input.
    change: [[f64; 2]; 2],
    input: [f64; 2],
    /// Mean of the output over a sample, by charge; by the input.
    mean: [f64; 2],
    through: f64,
    omega: [f64; 2],
}

/// Below this a charge is nothing.
const NOTHING: f64 = 1e-30;

impl HighPass {
    /// Without charge, `rate` samples a second.
    ///
    /// # Errors
    /// A corner or a rate that cannot be.
    pub fn new(corners: &Corners, rate: f64) -> Result<Self, Fault> {
        corners.check()?;
        positive("rate", rate)?;
        let n = corners.count;
        let mut omega = [0.0; 2];
        let mut a = [[0.0; MOST]; MOST];
        for (i, hertz) in corners.hertz().iter().enumerate() {
            omega[i] = std::f64::consts::TAU * hertz;
            // u − c₁ − … − c_i.
            a[i][..=i].fill(-omega[i]);
            a[i][n + 1] = omega[i];
        }
        // The integral of the output, and the input.
        a[n][..n].fill(-1.0);
        a[n][n + 1] = 1.0;
        let d = exponential(&a, n + 2, 1.0 / rate);
        let upto = |i: usize, value: f64| if i < n { value } else { 0.0 };
        Ok(Self {
            count: n,
            charge: [0.0; 2],
            change: std::array::from_fn(|i| std::array::from_fn(|j| upto(i.max(j), d[i][j]))),
            input: std::array::from_fn(|i| upto(i, d[i][n + 1])),
            mean: std::array::from_fn(|j| upto(j, d[n][j] * rate)),
            through: d[n][n + 1] * rate,
            omega,
        })
    }

    /// Passes a sample; mean of the output over it.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        if self.count == 0 {
            return input;
        }
        let [c, d] = self.charge;
        let output = self.mean[0] * c + self.mean[1] * d + self.through * input;
        let next = |i: usize| {
            let charge =
                self.charge[i] + self.change[i][0] * c + self.change[i][1] * d + self.input[i] * input;
            if charge.abs() < NOTHING { 0.0 } else { charge }
        };
        self.charge = [next(0), next(1)];
        output
    }

    /// The input for which the mean over the next sample is `output`.
    pub fn needed(&self, output: f64) -> f64 {
        if self.count == 0 {
            return output;
        }
        (output - self.mean[0] * self.charge[0] - self.mean[1] * self.charge[1]) / self.through
    }

    /// Whether there is no charge.
    pub(super) fn is_empty(&self) -> bool {
        self.charge == [0.0; 2]
    }

    /// Lets charges go that are all below this.
    pub(super) fn forget(&mut self, below: f64) {
        if self.charge.iter().all(|charge| charge.abs() < below) {
            self.charge = [0.0; 2];
        }
    }

    /// The output, of magnitude `most`, that takes the charges to nothing soonest; 0 where they are as good as that: an input of 0 then
    /// makes no output beyond `most`.
    pub(super) fn discharging(&self, most: f64) -> f64 {
        let [c, d] = self.charge;
        if (c + d).abs() <= most && c.abs().max(d.abs()) <= most {
            return 0.0;
        }
        if self.count == 1 {
            return -most.copysign(c);
        }
        // ∫y and ∬y are a double integrator; the parabola is where braking must begin.
        let once = d / self.omega[1];
        let twice = (c / self.omega[0] - once) / self.omega[1];
        let ahead = twice + 0.5 * once * once.abs() / most;
        -most.copysign(ahead)
    }
}

#[cfg(test)]
mod tests {
    use super::{Corners, HighPass};
    use crate::dsp::complex::Complex;

    /// Droop of a step: 27, 47, 96 % after 5, 10, 50 ms at 10 Hz; 47, 72, 99.8 % at 20 Hz.
    #[test]
    fn a_step_droops() {
        for (hertz, droops) in [(10.0, [0.27, 0.47, 0.96]), (20.0, [0.47, 0.72, 0.998])] {
            for (time, expected) in [5e-3, 10e-3, 50e-3].into_iter().zip(droops) {
                let rate = 48_000.0;
                let mut filter = HighPass::new(&Corners::one(hertz), rate).unwrap();
                let count = (time * rate) as u32;
                let mut last = 0.0;
                for _ in 0..count {
                    last = filter.step(1.0);
                }
                let omega = std::f64::consts::TAU * hertz;
                // Mean of e^(−ωt) over the last sample.
                let end = -omega * f64::from(count) / rate;
                let exact = end.exp() * (omega / rate).exp_m1() / (omega / rate);
                assert!((last - exact).abs() < 1e-12, "{last} {exact}");
                assert!((1.0 - last - expected).abs() < 0.006, "{hertz} {time}: {last}");
            }
        }
    }

    /// Two equal corners: (1 − ωt) e^(−ωt); its integral over each sample t e^(−ωt).
    #[test]
    fn two_in_series_undershoot() {
        for rate in [1000.0, 48_000.0] {
            let mut filter = HighPass::new(&Corners::two(10.0, 10.0), rate).unwrap();
            let omega = std::f64::consts::TAU * 10.0;
            let integral = |n: u32| f64::from(n) / rate * (-omega * f64::from(n) / rate).exp();
            for n in 0..500 {
                let expected = (integral(n + 1) - integral(n)) * rate;
                let is = filter.step(1.0);
                assert!((is - expected).abs() < 1e-12, "{n}: {is} {expected}");
            }
        }
    }

    #[test]
    fn phase_leads_by_the_arc_tangent() {
        assert!((Corners::one(10.0).response(30.0).angle().to_degrees() - 18.43).abs() < 0.01);
        let two = Corners::two(10.0, 3.0).response(30.0);
        let apart = two - Corners::one(10.0).response(30.0) * Corners::one(3.0).response(30.0);
        assert!(apart.abs() < 1e-15);
        assert_eq!(Corners::none().response(1.0), Complex::new(1.0, 0.0));
    }

    /// What is needed for an output makes that output.
    #[test]
    fn the_inverse_inverts() {
        for corners in [Corners::none(), Corners::one(20.0), Corners::two(20.0, 5.0)] {
            let mut filter = HighPass::new(&corners, 8000.0).unwrap();
            for n in 0..1000 {
                let wanted = (f64::from(n) * 0.01).sin() + 0.3;
                let input = filter.needed(wanted);
                assert!((filter.step(input) - wanted).abs() < 1e-9, "{corners:?} {n}");
            }
        }
    }

    /// However long it was charged, discharging ends, and no input after that makes more than was allowed.
    #[test]
    fn discharging_ends() {
        for corners in [Corners::one(10.0), Corners::two(10.0, 10.0), Corners::two(2.0, 20.0)] {
            for charged in [10, 1000, 30_000] {
                let mut filter = HighPass::new(&corners, 8000.0).unwrap();
                (0..charged).for_each(|_| {
                    filter.step(1.0);
                });
                let (most, mut steps) = (0.02, 0);
                loop {
                    let wanted = filter.discharging(most);
                    if wanted == 0.0 {
                        break;
                    }
                    let input = filter.needed(wanted);
                    filter.step(input);
                    steps += 1;
                    assert!(steps < 200_000, "{corners:?}: {filter:?}");
                }
                for _ in 0..80_000 {
                    assert!(filter.step(0.0).abs() <= most * 1.001);
                }
            }
        }
    }
}
