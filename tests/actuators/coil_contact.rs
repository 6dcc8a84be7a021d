//! Actuators of all kinds between stops and on skin, at random.

use pacinian::actuator::coil::bounds::{Bounds, EndStop};
use pacinian::actuator::coil::energy::Ledger;
use pacinian::actuator::coil::model::Model;
use pacinian::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::drive::Drive;

fn stop(stroke: f64, stiffness: f64, damping: f64) -> Bounds {
    Bounds { end_stop: Some(EndStop { stroke, spring: Spring { stiffness, damping } }), preload: None }
}

fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 40) as f64 / 8_388_608.0 - 1.0
}

/// A number between two, all magnitudes alike.
fn between(seed: &mut u64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(0.5 * (noise(seed) + 1.0))
}

/// An actuator, bounds near to each other, and a drive that reaches them.
fn any(seed: &mut u64) -> (Plant, Bounds, Drive, f64) {
    let inductance = if noise(seed) < -0.4 { 0.0 } else { between(seed, 1e-7, 0.1) };
    let coil =
        Coil { resistance: between(seed, 0.5, 50.0), inductance, force_factor: between(seed, 0.2, 10.0) };
    let (mass, omega) = (between(seed, 1e-4, 0.1), between(seed, 120.0, 12_000.0));
    let stiffness = mass * omega * omega;
    let suspension = Spring { stiffness, damping: mass * omega / between(seed, 0.3, 100.0) };
    let stroke = between(seed, 1e-5, 1e-3);
    let damping = if noise(seed) < -0.4 { 0.0 } else { mass * omega * between(seed, 0.01, 100.0) };
    let mut bounds = stop(stroke, stiffness * between(seed, 1.0, 1e3), damping);
    let plant = if noise(seed) < 0.0 {
        let spring = Spring {
            stiffness: stiffness * between(seed, 0.1, 10.0),
            damping: mass * omega * between(seed, 0.01, 10.0),
        };
        bounds.preload = Some(spring.stiffness * stroke * between(seed, 0.1, 2.0));
        let skin = Skin::One(Tissue { mass: 0.1 * mass, spring });
        Plant::voice_coil(&VoiceCoil { coil, mass, suspension, skin }).expect("sound")
    } else {
        let spring = Spring { stiffness: stiffness * between(seed, 0.01, 1.0), damping: mass * omega };
        let hand = if noise(seed) < 0.0 { Tissue::default() } else { Tissue { mass: 0.01, spring } };
        let casing_mass = mass * between(seed, 0.5, 20.0);
        Plant::inertial(&Inertial { coil, slug_mass: mass, casing_mass, suspension, hand }).expect("sound")
    };
    let drive = if noise(seed) < 0.0 { Drive::Voltage } else { Drive::Current };
    let compliance = plant.per_ampere(1e-6).displacement.abs();
    let most = stroke / compliance * between(seed, 0.3, 10.0);
    (plant, bounds, drive, if drive == Drive::Voltage { most * coil.resistance } else { most })
}

/// Of actuators of all kinds, at all rates, none gains energy, also where there are more events than are followed.
#[test]
fn no_actuator_gains_energy() {
    let (mut seed, mut capped) = (11, 0);
    for _ in 0..400 {
        let (plant, bounds, drive, most) = any(&mut seed);
        let rate = between(&mut seed, 50.0, 192e3);
        let mut model = Model::bounded(&plant, rate, drive, &bounds).expect("sound");
        let (mut ledger, coil) = (Ledger::new(&model), plant.coil());
        let (mut lost, mut peak, mut rounding) = (0.0, 0.0f64, 0.0);
        for _ in 0..100 {
            let o = ledger.step(&mut model, most * noise(&mut seed));
            let parts = o.voltage.abs() / rate
                + 2.0 * coil.inductance * o.current.abs()
                + 2.0 * coil.force_factor * o.displacement.abs();
            rounding += 1e-14 * o.voltage.abs() * parts / coil.resistance;
            peak = peak.max(ledger.stored).max(ledger.supplied.abs());
            assert!(ledger.lost() >= lost - 1e-11 * peak - rounding, "{plant:?} {bounds:?} {rate}");
            lost = ledger.lost();
        }
        capped += model.contacts().capped;
    }
    assert!(capped > 100, "{capped}");
}

/// Nothing is overlooked by long steps, but for a release so short that the body hardly left: in one of a hundred actuators.
#[test]
fn hardly_anything_is_overlooked() {
    let (mut seed, mut apart, mut count) = (3, 0, 0);
    for _ in 0..400 {
        let (plant, bounds, drive, most) = any(&mut seed);
        let mut coarse = Model::bounded(&plant, 1000.0, drive, &bounds).expect("sound");
        let mut fine = Model::bounded(&plant, 64_000.0, drive, &bounds).expect("sound");
        let (mut worst, mut size) = (0.0f64, 0.0f64);
        for _ in 0..20 {
            let u = most * noise(&mut seed);
            coarse.advance(u);
            fine.run(&[u; 64], |_| ());
            worst = worst.max((coarse.state().displacement - fine.state().displacement).abs());
            size = size.max(coarse.state().displacement.abs());
        }
        if coarse.contacts().capped == 0 && fine.contacts().capped == 0 {
            count += 1;
            apart += u32::from(worst > 1e-6 * size);
        }
    }
    assert!(count > 300 && apart <= 4, "{apart} of {count}");
}
