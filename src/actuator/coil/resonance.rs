//! The pole pair of the coil's own motion.

use super::plant::{MOST_STATES, Plant, Touch};
use crate::actuator::drive::Drive;

/// A pole pair: the roots of s² + (ω / Q) s + ω².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// ω / 2π.
    pub hertz: f64,
    /// Q; up to 0.5 the poles are real.
    pub q: f64,
}

/// Newton steps towards the quadratic factor, at most.
const STEPS: usize = 100;

impl Resonance {
    /// ω, radians a second.
    pub fn omega(&self) -> f64 {
        std::f64::consts::TAU * self.hertz
    }

    /// Time in which the amplitude falls to 1/e, seconds: 2 Q / ω.
    pub fn decay(&self) -> f64 {
        2.0 * self.q / self.omega()
    }
}

impl Plant {
    /// The pole pair next to the resonance that coil and springs have by themselves, damped by what drives the coil: shorted
    /// terminals, or open ones. Without any stiffness there is none.
    pub fn resonance(&self, drive: Drive) -> Option<Resonance> {
        let system = self.system(drive, &Touch::default());
        let [mass, stiffness] = [1.0 / self.push(), self.mechanics().0];
        if stiffness <= 0.0 {
            return None;
        }
        // In units of the frequency at which that mass would swing on that spring.
        let unit = (stiffness / mass).sqrt();
        let bl = self.coil.force_factor;
        let electric = if drive == Drive::Voltage { bl * bl / self.coil.resistance } else { 0.0 };
        let mut pair = [(self.mechanics().1 + electric) / (mass * unit), 1.0];
        let polynomial = characteristic(&system.matrix, system.size, unit);
        let start = pair;
        for _ in 0..STEPS {
            let Some(step) = correction(&polynomial[..=system.size], pair) else { break };
            pair = [pair[0] + step[0], pair[1] + step[1]];
            if step[0].abs() + step[1].abs() < 1e-15 {
                break;
            }
        }
        // What does not converge to something that decays is known by its start.
        let [u, v] = if pair[0] >= 0.0 && pair[1] > 0.0 { pair } else { start };
        let omega = v.sqrt();
        Some(Resonance { hertz: omega * unit / std::f64::consts::TAU, q: omega / u })
    }
}

/// The characteristic polynomial of A / unit, from the highest power (Faddeev & LeVerrier).
fn characteristic(
    a: &crate::actuator::exponential::Square,
    size: usize,
    unit: f64,
) -> [f64; MOST_STATES + 1] {
    // Scaled so that displacements and velocities are of a size: T⁻¹ A T / unit with T = diag(1, unit) for each coordinate.
    let scale = |i: usize| if i % 2 == 1 { unit } else { 1.0 };
    let entry = |i: usize, j: usize| a[i][j] * scale(j) / (scale(i) * unit);
    let mut coefficients = [0.0; MOST_STATES + 1];
    coefficients[0] = 1.0;
    let mut m = [[0.0; MOST_STATES]; MOST_STATES];
    for k in 1..=size {
        // M ← A M + c I, c ← −trace(A M) / k.
        let mut next = [[0.0; MOST_STATES]; MOST_STATES];
        for i in 0..size {
            for j in 0..size {
                next[i][j] = (0..size).map(|l| entry(i, l) * m[l][j]).sum();
            }
            next[i][i] += coefficients[k - 1];
        }
        m = next;
        let trace: f64 = (0..size).map(|i| (0..size).map(|l| entry(i, l) * m[l][i]).sum::<f64>()).sum();
        coefficients[k] = -trace / k as f64;
    }
    coefficients
}

/// Bairstow's correction of s² + u s + v towards a factor of a polynomial.
fn correction(polynomial: &[f64], [u, v]: [f64; 2]) -> Option<[f64; 2]> {
    let divide = |from: &[f64]| {
        let mut b = [0.0; MOST_STATES + 1];
        for i in 0..from.len() {
            b[i] = from[i] - if i > 0 { u * b[i - 1] } else { 0.0 } - if i > 1 { v * b[i - 2] } else { 0.0 };
        }
        b
    };
    let n = polynomial.len() - 1;
    let b = divide(polynomial);
    if n == 2 {
        return Some([b[1], b[2]]);
    }
    let c = divide(&b[..n]);
    let (c1, c2, c3) = (c[n - 1], c[n - 2], if n > 2 { c[n - 3] } else { 0.0 });
    let determinant = c2 * c2 - c1 * c3;
    let step = [(b[n - 1] * c2 - b[n] * c3) / determinant, (b[n] * c2 - b[n - 1] * c1) / determinant];
    step.iter().all(|s| s.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::{Plant, Resonance};
    use crate::actuator::coil::lra::tests::sheet;
    use crate::actuator::coil::parameters::tests::{held, inertial, layered, tactor};
    use crate::actuator::coil::parameters::{Coil, Skin, Spring, VoiceCoil};
    use crate::actuator::drive::Drive;
    use crate::dsp::complex::Complex;

    /// What vanishes at a pole: L s + R + Bl² s / D, or D.
    fn at_pole(plant: &Plant, drive: Drive, s: Complex) -> f64 {
        let r = plant.at(s, plant.load(s));
        if !r.displacement.abs().is_finite() {
            return 0.0;
        }
        let d = Complex::new(plant.coil().force_factor, 0.0) / r.displacement;
        match drive {
            Drive::Voltage => {
                r.impedance.abs() / (plant.coil().resistance + s.abs() * plant.coil().inductance)
            }
            Drive::Current => d.abs() / (plant.mass[0][0] * s.abs() * s.abs()),
        }
    }

    #[test]
    fn it_is_a_pole_of_the_response() {
        let tactors = [tactor(), layered(), VoiceCoil { skin: Skin::None, ..tactor() }];
        let plants = tactors.map(|v| Plant::voice_coil(&v).unwrap());
        for plant in plants.into_iter().chain([inertial(), held()].map(|m| Plant::inertial(&m).unwrap())) {
            for drive in [Drive::Voltage, Drive::Current] {
                let Resonance { q, .. } = plant.resonance(drive).unwrap();
                let omega = plant.resonance(drive).unwrap().omega();
                assert!(q > 0.5, "{q}");
                let s = Complex::new(-0.5 / q, (1.0 - 0.25 / (q * q)).sqrt()) * omega;
                let rest = at_pole(&plant, drive, s);
                assert!(rest < 1e-8, "{omega} {q}: {rest:e} {plant:?}");
            }
        }
    }

    /// The table of representative tactors, to the digits it has; its Q under voltage drive leaves out the inductance.
    #[test]
    fn it_is_what_the_tables_say() {
        for (k, c, m, hertz, [current, voltage]) in [
            (600.0, 0.8, 5e-5, 247.0, [1.72, 1.50]),
            (1200.0, 1.5, 1e-4, 262.0, [1.25, 1.14]),
            (3000.0, 3.0, 2e-4, 302.0, [0.90, 0.85]),
            (0.0, 0.0, 0.0, 230.0, [3.6, 2.7]),
        ] {
            let mut v = tactor();
            v.coil.inductance = 0.0;
            let spring = Spring { stiffness: k, damping: c };
            v.skin = Skin::One(crate::actuator::coil::parameters::Tissue { mass: m, spring });
            let plant = Plant::voice_coil(&v).unwrap();
            for (drive, q) in [(Drive::Current, current), (Drive::Voltage, voltage)] {
                let is = plant.resonance(drive).unwrap();
                assert!((is.hertz - hertz).abs() < 0.6 && (is.q - q).abs() < 0.06, "{is:?} {hertz} {q}");
            }
        }
        let lra = Plant::inertial(&sheet().actuator().unwrap()).unwrap().resonance(Drive::Voltage).unwrap();
        assert!((lra.hertz - 175.0).abs() < 1e-9 && (lra.q - 15.0).abs() < 1e-9);
        assert!((lra.decay() - 15.0 / (std::f64::consts::PI * 175.0)).abs() < 1e-12);
    }

    #[test]
    fn extremes_have_one_too() {
        for q in [0.05, 0.5, 200.0, 1e6] {
            for inductance in [0.0, 1e-9, 1e-4, 1.0] {
                let coil = Coil { inductance, ..tactor().coil };
                let stiffness: f64 = 3132.7;
                let damping = (stiffness * 1.5e-3).sqrt() / q;
                let suspension = Spring { stiffness, damping };
                let plant =
                    Plant::voice_coil(&VoiceCoil { coil, suspension, skin: Skin::None, ..tactor() }).unwrap();
                let open = plant.resonance(Drive::Current).unwrap();
                assert!((open.q / q - 1.0).abs() < 1e-9, "{open:?}");
                let shorted = plant.resonance(Drive::Voltage).unwrap();
                assert!(shorted.q > 0.0 && shorted.hertz > 0.0 && shorted.hertz.is_finite(), "{shorted:?}");
            }
        }
        let floating = VoiceCoil { suspension: Spring::default(), skin: Skin::None, ..tactor() };
        assert_eq!(Plant::voice_coil(&floating).unwrap().resonance(Drive::Voltage), None);
    }
}
