//! The exact frequency response.

use super::parameters::{Skin, Spring, Tissue};
use super::plant::{Kind, Plant};
use crate::dsp::complex::Complex;

/// What an actuator does at one frequency, for each volt or each ampere that drives it; amplitude and phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Of the contactor in its housing, or the slug in its casing, metres.
    pub displacement: Complex,
    /// Of the same, metres a second.
    pub velocity: Complex,
    /// Of the same, metres a second squared.
    pub acceleration: Complex,
    /// On the skin, or on the hand that holds the casing, newtons.
    pub force: Complex,
    /// Acceleration of the casing, metres a second squared; 0 for a tactor, whose housing is held.
    pub casing: Complex,
    /// Amperes.
    pub current: Complex,
    /// Volts an ampere at the terminals, whichever drives it.
    pub impedance: Complex,
}

impl Plant {
    /// What it does for each volt at a frequency (Hz, above 0).
    pub fn per_volt(&self, hertz: f64) -> Response {
        let response = self.per_ampere(hertz);
        response.times(Complex::new(1.0, 0.0) / response.impedance)
    }

    /// What it does for each ampere at a frequency (Hz, above 0).
    pub fn per_ampere(&self, hertz: f64) -> Response {
        self.at(Complex::oscillation(hertz), self.load(Complex::oscillation(hertz)))
    }

    /// As [`Plant::per_ampere`] against another load than its own: a measured one. `stiffness` is its force for each metre,
    /// newtons a metre, at that frequency: of the skin, or of the hand without the casing.
    pub fn against(&self, hertz: f64, stiffness: Complex) -> Response {
        self.at(Complex::oscillation(hertz), stiffness)
    }

    /// For each ampere at a complex frequency s.
    pub(super) fn at(&self, s: Complex, load: Complex) -> Response {
        let bl = self.coil.force_factor;
        let (own, casing, force);
        match &self.kind {
            Kind::Tactor(v) => {
                own = s * s * v.mass + dynamic(&v.suspension, s) + load;
                casing = Complex::default();
                force = load;
            }
            Kind::Inertial(m) => {
                // (H + m s²) X = −m s² z, where H moves with the casing.
                let slug = s * s * m.slug_mass;
                let held = s * s * m.casing_mass + load;
                let both = held + slug;
                own = dynamic(&m.suspension, s) + slug * held / both;
                casing = -(slug / both);
                force = casing * load;
            }
        }
        let displacement = Complex::new(bl, 0.0) / own;
        Response {
            displacement,
            velocity: displacement * s,
            acceleration: displacement * s * s,
            force: displacement * force,
            casing: displacement * casing * s * s,
            current: Complex::new(1.0, 0.0),
            impedance: s * self.coil.inductance + displacement * s * bl + self.coil.resistance,
        }
    }

    /// What its own load resists with, newtons a metre, at a complex frequency s.
    pub(super) fn load(&self, s: Complex) -> Complex {
        let tissue = |t: &Tissue| s * s * t.mass + dynamic(&t.spring, s);
        match &self.kind {
            Kind::Inertial(m) => tissue(&m.hand),
            Kind::Tactor(v) => match &v.skin {
                Skin::None => Complex::default(),
                Skin::One(one) => tissue(one),
                Skin::Two(one, layer) => {
                    // Coupling and what is beyond it, one after the other.
                    let coupling = dynamic(&layer.coupling, s);
                    let beyond = tissue(&Tissue { mass: layer.mass, spring: layer.anchor });
                    let both = coupling + beyond;
                    let series = if both == Complex::default() { both } else { coupling * beyond / both };
                    tissue(one) + series
                }
            },
        }
    }
}

impl Response {
    fn times(self, factor: Complex) -> Self {
        Self {
            displacement: self.displacement * factor,
            velocity: self.velocity * factor,
            acceleration: self.acceleration * factor,
            force: self.force * factor,
            casing: self.casing * factor,
            current: self.current * factor,
            impedance: self.impedance,
        }
    }
}

fn dynamic(spring: &Spring, s: Complex) -> Complex {
    s * spring.damping + spring.stiffness
}

#[cfg(test)]
mod tests {
    use super::Complex;
    use crate::actuator::coil::parameters::tests::{held, inertial, layered, tactor};
    use crate::actuator::coil::parameters::{Inertial, Skin, Spring, Tissue, VoiceCoil};
    use crate::actuator::coil::plant::Plant;

    fn close(a: Complex, b: Complex, within: f64) {
        assert!((a - b).abs() <= within * b.abs(), "{a:?} {b:?}");
    }

    /// Ratios that follow from the definitions alone.
    #[test]
    fn force_motion_and_current_belong_together() {
        for hertz in [3.0, 40.0, 250.0, 1000.0] {
            let s = Complex::oscillation(hertz);
            let skin = tactor();
            let r = Plant::voice_coil(&skin).unwrap().per_volt(hertz);
            let Skin::One(tissue) = skin.skin else { unreachable!() };
            let resists = s * s * tissue.mass + s * tissue.spring.damping + tissue.spring.stiffness;
            close(r.force, r.displacement * resists, 1e-14);
            // Newton on the contactor: coil less suspension less skin.
            let spring = r.displacement * (s * skin.suspension.damping + skin.suspension.stiffness);
            close(r.acceleration * skin.mass + spring + r.force, r.current * skin.coil.force_factor, 1e-14);

            let motor = held();
            let r = Plant::inertial(&motor).unwrap().per_volt(hertz);
            // Newton on slug and casing together: only the hand pushes from outside.
            let inertia = (r.acceleration + r.casing) * motor.slug_mass + r.casing * motor.casing_mass;
            close(-r.force, inertia, 1e-12);
        }
    }

    #[test]
    fn a_free_casing_follows_the_closed_form() {
        let m = inertial();
        let mu = m.slug_mass * m.casing_mass / (m.slug_mass + m.casing_mass);
        for hertz in [5.0, 58.0, 900.0] {
            let s = Complex::oscillation(hertz);
            let below = s * s + s * (m.suspension.damping / mu) + m.suspension.stiffness / mu;
            let expected = -(s * s * (m.coil.force_factor / m.casing_mass) / below);
            close(Plant::inertial(&m).unwrap().per_ampere(hertz).casing, expected, 1e-13);
        }
    }

    /// A soft load is none, and a layer that is glued on is more skin.
    #[test]
    fn the_limits_of_the_loads_meet() {
        let bare = VoiceCoil { skin: Skin::None, ..tactor() };
        let soft = VoiceCoil { skin: Skin::One(Tissue::default()), ..tactor() };
        let Skin::Two(tissue, mut layer) = layered().skin else { unreachable!() };
        layer.coupling = Spring { stiffness: 1e14, damping: 0.0 };
        let glued = VoiceCoil { skin: Skin::Two(tissue, layer), ..tactor() };
        let sum = Tissue {
            mass: tissue.mass + layer.mass,
            spring: Spring {
                stiffness: tissue.spring.stiffness + layer.anchor.stiffness,
                damping: tissue.spring.damping + layer.anchor.damping,
            },
        };
        let one = VoiceCoil { skin: Skin::One(sum), ..tactor() };
        let heavy = Inertial { hand: Tissue { mass: 0.02, ..Tissue::default() }, ..inertial() };
        let mounted = Inertial { casing_mass: 0.12, ..inertial() };
        for hertz in [20.0, 300.0] {
            let at = |v| Plant::voice_coil(v).unwrap().per_volt(hertz);
            assert_eq!(at(&bare), at(&soft));
            close(at(&glued).displacement, at(&one).displacement, 1e-9);
            let at = |m| Plant::inertial(m).unwrap().per_volt(hertz);
            close(at(&heavy).casing, at(&mounted).casing, 1e-14);
        }
    }

    #[test]
    fn a_measured_load_takes_the_place_of_its_own() {
        let plant = Plant::voice_coil(&tactor()).unwrap();
        let s = Complex::oscillation(120.0);
        let measured = s * s * 1e-4 + s * 1.5 + 1200.0;
        assert_eq!(plant.against(120.0, measured), plant.per_ampere(120.0));
    }

    /// Neither terminals nor contactor ever give back more than they took: real parts of impedance and of velocity over force.
    #[test]
    fn both_ports_are_passive() {
        let tactors = [tactor(), layered()].map(|v| Plant::voice_coil(&v).unwrap());
        let motors = [inertial(), held()].map(|m| Plant::inertial(&m).unwrap());
        for plant in tactors.into_iter().chain(motors) {
            for n in 0..200 {
                let hertz = 1e-2 * 1.1f64.powi(n);
                let r = plant.per_ampere(hertz);
                assert!(r.impedance.re >= plant.coil().resistance, "{hertz}: {:?}", r.impedance);
                assert!(r.velocity.re >= 0.0, "{hertz}: {:?}", r.velocity);
                // What the load takes up: force times velocity, averaged over a turn.
                let velocity = if r.casing == Complex::default() {
                    r.velocity
                } else {
                    r.casing / Complex::oscillation(hertz)
                };
                let power = r.force.re * velocity.re + r.force.im * velocity.im;
                assert!(power >= -1e-12 * r.force.abs() * velocity.abs(), "{hertz}: {power}");
            }
        }
    }

    /// The table of representative tactors: resonance and Q under current and voltage drive.
    #[test]
    fn skin_moves_the_resonance_as_it_should() {
        for (k, c, m, hertz) in
            [(600.0, 0.8, 5e-5, 247.0), (1200.0, 1.5, 1e-4, 262.0), (3000.0, 3.0, 2e-4, 302.0)]
        {
            let skin = Skin::One(Tissue { mass: m, spring: Spring { stiffness: k, damping: c } });
            let plant = Plant::voice_coil(&VoiceCoil { skin, ..tactor() }).unwrap();
            // At the undamped resonance velocity and current are in phase.
            let phase = |hertz| plant.per_ampere(hertz).velocity.angle();
            assert!(phase(hertz - 0.6) > 0.0 && phase(hertz + 0.6) < 0.0, "{hertz}");
        }
    }
}
