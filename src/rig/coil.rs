//! An actuator with a coil as a rig or a part describes it.

use std::f64::consts::TAU;

use super::motor::Lack;
use super::part::Part;
use super::{Actuator, Model};
use crate::actuator::coil::limits::Limits;
use crate::actuator::coil::lra::Sheet;
use crate::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use crate::actuator::coil::plant::Plant;
use crate::actuator::fault::Fault;

/// Figures of which one is needed.
type OneOf = &'static [&'static str];

/// What an actuator of a model cannot be without: of each, the first that is known counts.
fn needed(model: Model) -> &'static [OneOf] {
    match model {
        Model::RumbleMotor => {
            &[&["rated_volts"], &["resistance"], &["torque_constant"], &["inertia"], &["eccentric_moment"]]
        }
        Model::VoiceCoil => &[
            &["resistance"],
            &["force_factor"],
            &["moving_mass"],
            &["stiffness", "resonance"],
            &["damping", "q"],
        ],
        Model::InertialMotor => &[
            &["resistance"],
            &["force_factor"],
            &["slug_mass"],
            &["casing_mass"],
            &["stiffness", "resonance"],
            &["damping", "q"],
        ],
        Model::Lra => &[
            &["resonance"],
            &["q"],
            &["rated_volts"],
            &["rated_acceleration"],
            &["test_mass"],
            &["device_mass"],
            &["slug_mass"],
            &["resistance"],
        ],
        Model::Generic | Model::Piezo => &[],
    }
}

/// What a motor cannot be without that is known from outside only.
const OUTSIDE: &[OneOf] =
    &[&["rated_volts"], &["time_constant"], &["speed_per_volt"], &["eccentric_per_mass"]];

impl Actuator {
    /// One that is a part, with the figures of that and no others.
    pub fn of_part(part: &Part) -> Self {
        let values = part.values.iter().map(|(key, value)| (*key, value.value)).collect();
        Self { model: part.model, part: Some(part.name.into()), values, ..Self::generic(part.name) }
    }

    /// The figures that its model needs and nothing says, where one of several would do joined by "or"; of a motor those of the way that
    /// more is known of. None where it can be computed, and for models that there are none of.
    pub fn lacking(&self) -> Vec<String> {
        let of = |needed: &[OneOf]| -> Vec<String> {
            let known = |keys: &&OneOf| keys.iter().any(|key| self.value(key).is_some());
            needed.iter().filter(|keys| !known(keys)).map(|keys| keys.join("` or `")).collect()
        };
        let inside = of(needed(self.model));
        if self.model != Model::RumbleMotor || self.value("torque_constant").is_some() {
            return inside;
        }
        let outside = of(OUTSIDE);
        if self.value("time_constant").is_some() || outside.len() < inside.len() { outside } else { inside }
    }

    /// A voice coil, an inertial motor or a linear resonant actuator, from what is known of it.
    ///
    /// Where the suspension's stiffness is not known it follows from `resonance`, that of what moves on it: moving mass, or slug against casing;
    /// and its damping from `q`, the quality of that with open terminals. Of a linear resonant actuator both are those of its data sheet, see
    /// [`Sheet`]. Its mount is what it was measured on.
    ///
    /// # Errors
    /// The first figure that is missing or cannot be; of another model, its `force_factor`.
    pub fn coil(&self) -> Result<Plant, Lack> {
        let get = |key: &'static str| self.value(key).ok_or(Lack::Figure(key));
        let or = |key: &str| self.value(key).unwrap_or(0.0);
        let plant = |plant: Result<Plant, Fault>| plant.map_err(Lack::Fault);
        if self.model == Model::Lra {
            let sheet = Sheet {
                resonance: get("resonance")?,
                q: get("q")?,
                rated_volts: get("rated_volts")?,
                rated_acceleration: get("rated_acceleration")?,
                on_mass: get("test_mass")?,
                device_mass: get("device_mass")?,
                slug_mass: get("slug_mass")?,
                resistance: get("resistance")?,
                inductance: or("inductance"),
            };
            return plant(sheet.actuator().and_then(|inertial| Plant::inertial(&inertial)));
        }
        let coil = Coil {
            resistance: get("resistance")?,
            inductance: or("inductance"),
            force_factor: get("force_factor")?,
        };
        let suspension = |mass: f64| -> Result<Spring, Lack> {
            let omega = |mass: f64, stiffness: f64| (stiffness / mass).sqrt();
            let stiffness = match self.value("stiffness") {
                Some(stiffness) => stiffness,
                None => mass * (TAU * get("resonance")?).powi(2),
            };
            let damping = match self.value("damping") {
                Some(damping) => damping,
                None => mass * omega(mass, stiffness) / get("q")?,
            };
            Ok(Spring { stiffness, damping })
        };
        if self.model == Model::InertialMotor {
            let (slug_mass, casing_mass) = (get("slug_mass")?, get("casing_mass")?);
            let suspension = suspension(1.0 / (1.0 / slug_mass + 1.0 / casing_mass))?;
            let hand = Tissue::default();
            return plant(Plant::inertial(&Inertial { coil, slug_mass, casing_mass, suspension, hand }));
        }
        let mass = get("moving_mass")?;
        let spring = Spring { stiffness: or("skin_stiffness"), damping: or("skin_damping") };
        let tissue = Tissue { mass: or("skin_mass"), spring };
        let skin = if tissue == Tissue::default() { Skin::None } else { Skin::One(tissue) };
        plant(Plant::voice_coil(&VoiceCoil { coil, mass, suspension: suspension(mass)?, skin }))
    }

    /// What it bears, as far as that is known.
    pub fn limits(&self) -> Limits {
        Limits {
            volts: self.most_volts(),
            amperes: self.value("max_amperes"),
            amperes_rms: self.value("max_rms_amperes"),
            stroke: self.value("stroke"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{Actuator, Lack, Model, Plant, Sheet};
    use crate::actuator::drive::Drive;

    fn of(model: Model, values: &[(&'static str, f64)]) -> Actuator {
        Actuator {
            model,
            values: values.iter().copied().collect::<BTreeMap<_, _>>(),
            ..Actuator::generic("a")
        }
    }

    const TACTOR: [(&str, f64); 5] = [
        ("resistance", 7.0),
        ("force_factor", 1.2),
        ("moving_mass", 1.5e-3),
        ("resonance", 230.0),
        ("q", 3.6),
    ];
    const LRA: [(&str, f64); 8] = [
        ("resonance", 175.0),
        ("q", 15.0),
        ("rated_volts", 2.0),
        ("rated_acceleration", 12.0),
        ("test_mass", 0.1),
        ("device_mass", 2.5e-3),
        ("slug_mass", 1.5e-3),
        ("resistance", 25.0),
    ];

    /// With open terminals nothing but the suspension is left: the resonance and the quality that were said, of whatever moves on it.
    #[test]
    fn suspensions_are_those_of_resonance_and_quality() {
        let exciter =
            [("slug_mass", 5.5e-3), ("casing_mass", 0.1), ("force_factor", 1.5), ("resistance", 6.0)];
        let exciter = [&exciter[..], &[("resonance", 60.0), ("q", 1.5)]].concat();
        for (actuator, hertz, q) in
            [(of(Model::VoiceCoil, &TACTOR), 230.0, 3.6), (of(Model::InertialMotor, &exciter), 60.0, 1.5)]
        {
            let is = actuator.coil().unwrap().resonance(Drive::Current).unwrap();
            assert!((is.hertz / hertz - 1.0).abs() < 1e-9 && (is.q / q - 1.0).abs() < 1e-9, "{is:?}");
        }
        // A spring that is said goes before a resonance, and the quality counts for what then swings.
        let stiff = [&TACTOR[..], &[("stiffness", 5000.0)]].concat();
        let is = of(Model::VoiceCoil, &stiff).coil().unwrap().resonance(Drive::Current).unwrap();
        let due = (5000.0_f64 / 1.5e-3).sqrt() / std::f64::consts::TAU;
        assert!((is.hertz / due - 1.0).abs() < 1e-9 && (is.q / 3.6 - 1.0).abs() < 1e-9, "{is:?}");
        // Skin adds its own.
        let skin = [&TACTOR[..], &[("skin_stiffness", 1200.0), ("skin_mass", 1e-4)]].concat();
        let on = of(Model::VoiceCoil, &skin).coil().unwrap().resonance(Drive::Current).unwrap();
        let stiffness = 1.5e-3 * (std::f64::consts::TAU * 230.0).powi(2) + 1200.0;
        assert!((on.omega() / (stiffness / 1.6e-3).sqrt() - 1.0).abs() < 1e-9, "{on:?}");
    }

    #[test]
    fn a_resonant_actuator_does_what_its_sheet_says() {
        let plant = of(Model::Lra, &LRA).coil().unwrap();
        assert!((plant.per_volt(175.0).casing.abs() * 2.0 / 12.0 - 1.0).abs() < 1e-9);
        let short = plant.resonance(Drive::Voltage).unwrap();
        assert!((short.q / 15.0 - 1.0).abs() < 1e-9, "{short:?}");
        // The heavier what it was measured on, the stronger it is.
        let sheet = Sheet {
            resonance: 175.0,
            q: 15.0,
            rated_volts: 2.0,
            rated_acceleration: 12.0,
            on_mass: 0.1,
            device_mass: 2.5e-3,
            slug_mass: 1.5e-3,
            resistance: 25.0,
            inductance: 0.0,
        };
        assert_eq!(Ok(plant), sheet.actuator().and_then(|inertial| Plant::inertial(&inertial)));
    }

    /// All that is missing is named, the first of it by the error; with it, nothing is.
    #[test]
    fn what_is_missing_is_named() {
        for (model, all) in [(Model::VoiceCoil, &TACTOR[..]), (Model::Lra, &LRA[..])] {
            assert!(of(model, all).lacking().is_empty() && of(model, all).coil().is_ok());
            for n in 0..all.len() {
                let mut some = all.to_vec();
                let (key, _) = some.remove(n);
                let lacking = of(model, &some).lacking();
                assert!(lacking.len() == 1 && lacking[0].ends_with(key), "{key}: {lacking:?}");
                assert_eq!(of(model, &some).coil(), Err(Lack::Figure(key)));
            }
        }
        assert_eq!(of(Model::VoiceCoil, &[]).lacking()[3], "stiffness` or `resonance");
        let motor = |values: &[(&'static str, f64)]| of(Model::RumbleMotor, values).lacking();
        assert_eq!(
            motor(&[("rated_volts", 3.0), ("time_constant", 0.03)]),
            ["speed_per_volt", "eccentric_per_mass"]
        );
        assert_eq!(
            motor(&[("rated_volts", 3.0), ("torque_constant", 1e-3), ("resistance", 30.0)]),
            ["inertia", "eccentric_moment"]
        );
        assert!(of(Model::Piezo, &[]).lacking().is_empty());
    }
}
