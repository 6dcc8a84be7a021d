use super::super::bounds::{Bounds, EndStop};
use super::super::energy::Ledger;
use super::super::model::{Model, State};
use super::super::parameters::tests::{held, inertial, layered, tactor};
use super::super::parameters::{Coil, Skin, Spring, VoiceCoil};
use super::super::plant::Plant;
use super::{Contact, WHOLE};
use crate::actuator::drive::Drive;

fn stop(stroke: f64, stiffness: f64, damping: f64) -> Bounds {
    Bounds { end_stop: Some(EndStop { stroke, spring: Spring { stiffness, damping } }), preload: None }
}

fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 40) as f64 / 8_388_608.0 - 1.0
}

/// Far from its bounds a bounded model is the unbounded one.
#[test]
fn bounds_out_of_reach_change_nothing() {
    let far = stop(1.0, 1e6, 1.0);
    for plant in [Plant::voice_coil(&layered()).unwrap(), Plant::inertial(&held()).unwrap()] {
        for drive in [Drive::Voltage, Drive::Current] {
            let mut free = Model::new(&plant, 8000.0, drive).unwrap();
            let mut bounded = Model::bounded(&plant, 8000.0, drive, &far).unwrap();
            let mut seed = 1;
            for _ in 0..5000 {
                let u = noise(&mut seed);
                assert_eq!(free.step(u), bounded.step(u));
            }
            assert_eq!(bounded.contacts().events, 0);
        }
    }
    // On the skin with its preload, the springs are summed in another order.
    let plant = Plant::voice_coil(&tactor()).unwrap();
    let pressed = Bounds { preload: Some(1e3), ..far };
    let mut free = Model::new(&plant, 8000.0, Drive::Voltage).unwrap();
    let mut bounded = Model::bounded(&plant, 8000.0, Drive::Voltage, &pressed).unwrap();
    for n in 0..1000 {
        let (a, b) = (free.step(f64::from(n % 7)), bounded.step(f64::from(n % 7)));
        assert!(
            (a.displacement - b.displacement).abs() < 1e-15 && (a.force - b.force).abs() < 1e-11,
            "{a:?} {b:?}"
        );
    }
}

/// Driven hard into stops and off the skin, over stiffness, damping, rate: nothing gains energy.
#[test]
fn no_contact_gains_energy() {
    let mut events = 0;
    for rate in [1e3, 8e3, 48e3, 192e3] {
        for stiffness in [1e2, 1e4, 1e6, 1e9] {
            for damping in [0.0, 0.3, 30.0, 1e5] {
                for (preload, inductance) in [(None, 2.5e-4), (Some(0.05), 2.5e-4), (Some(0.0), 0.0)] {
                    let coil = Coil { inductance, ..tactor().coil };
                    let plant = Plant::voice_coil(&VoiceCoil { coil, ..tactor() }).unwrap();
                    let bounds = Bounds { preload, ..stop(1e-4, stiffness, damping) };
                    events += check_energy(&plant, rate, Drive::Voltage, &bounds);
                    events += check_energy(&plant, rate, Drive::Current, &bounds);
                }
                let bounds = stop(5e-5, stiffness, damping);
                for plant in [
                    Plant::inertial(&inertial()).unwrap(),
                    Plant::inertial(&held()).unwrap(),
                    Plant::voice_coil(&layered()).unwrap(),
                ] {
                    events += check_energy(&plant, rate, Drive::Voltage, &bounds);
                }
            }
        }
    }
    assert!(events > 20_000, "{events}");
}

fn check_energy(plant: &Plant, rate: f64, drive: Drive, bounds: &Bounds) -> u64 {
    let mut model = Model::bounded(plant, rate, drive, bounds).unwrap();
    let mut ledger = Ledger::new(&model);
    let (mut lost, mut peak, mut seed) = (0.0, 0.0f64, 7);
    let mut noisy = 0.0;
    for n in 0..400 {
        let swing = if (f64::from(n) * 700.0 / rate).fract() < 0.5 { 8.0 } else { -8.0 };
        let u = match n / 100 {
            0 | 2 => swing,
            1 => 10.0 * noise(&mut seed),
            _ => 0.0,
        };
        let o = ledger.step(&mut model, u);
        let coil = plant.coil();
        let charge = o.voltage * model.period()
            + coil.inductance * o.current.abs()
            + coil.force_factor * o.displacement.abs();
        noisy += 1e-15 * (o.voltage.abs() * charge / coil.resistance).abs();
        peak = peak.max(ledger.stored).max(ledger.supplied.abs());
        assert!(
            ledger.lost() >= lost - 1e-12 * peak - noisy,
            "{plant:?} {bounds:?} {rate} {n}: {lost:e} to {:e} of {peak:e}",
            ledger.lost()
        );
        lost = ledger.lost();
        assert!(o.acceleration.is_finite() && o.force.is_finite() && o.current.is_finite());
        if let Some(stop) = &bounds.end_stop {
            // A stiff stop holds: the depth is bounded by what the energy can compress.
            let most = (2.0 * (peak + 1e-9) / stop.spring.stiffness).sqrt()
                + 2.0 * coil.force_factor * o.current.abs().max(10.0) / stop.spring.stiffness;
            assert!(o.displacement.abs() <= stop.stroke + most, "{} {most}", o.displacement);
        }
    }
    model.contacts().events
}

/// With contacts too, fine steps come to where coarse ones do.
#[test]
fn it_does_not_matter_how_fine_the_steps_are() {
    let pressed = Bounds { preload: Some(0.05), ..stop(1.2e-4, 2e5, 3.0) };
    let plants = [
        (Plant::voice_coil(&tactor()).unwrap(), pressed),
        (Plant::voice_coil(&layered()).unwrap(), stop(1.2e-4, 2e5, 3.0)),
        (Plant::inertial(&inertial()).unwrap(), stop(3e-4, 2e5, 0.0)),
        (Plant::inertial(&held()).unwrap(), stop(3e-4, 2e5, 20.0)),
    ];
    for (plant, bounds) in plants {
        for drive in [Drive::Voltage, Drive::Current] {
            let mut coarse = Model::bounded(&plant, 500.0, drive, &bounds).unwrap();
            let mut fine = Model::bounded(&plant, 96_000.0, drive, &bounds).unwrap();
            let (mut seed, mut apart, mut most) = (5, 0.0f64, 0.0f64);
            for _ in 0..40 {
                let u = 8.0 * noise(&mut seed)
                    / if drive == Drive::Current { plant.coil().resistance } else { 1.0 };
                coarse.advance(u);
                fine.run(&[u; 192], |_| ());
                let (a, b) = (coarse.state(), fine.state());
                apart = apart.max((a.displacement - b.displacement).abs());
                most = most.max(a.displacement.abs());
            }
            let (a, b) = (coarse.contacts(), fine.contacts());
            assert!(a == b && a.events > 10 && a.capped == 0, "{plant:?}: {a:?} {b:?}");
            assert!(apart < 1e-9 * most, "{plant:?}: {apart:e} of {most:e}");
        }
    }
}

/// Held against a stop, force is in balance: coil, suspension and stop.
#[test]
fn a_steady_push_rests_in_the_stop() {
    for plant in [Plant::voice_coil(&layered()).unwrap(), Plant::inertial(&held()).unwrap()] {
        for sign in [1.0, -1.0] {
            let bounds = stop(1e-6, 1e5, 20.0);
            let mut model = Model::bounded(&plant, 48_000.0, Drive::Current, &bounds).unwrap();
            (0..96_000).for_each(|_| model.advance(sign));
            let o = model.outputs();
            let push = plant.coil().force_factor;
            let own = push / plant.per_ampere(1e-9).displacement.re;
            let depth = (push - own * 1e-6) / (own + 1e5);
            assert!((sign * o.displacement - 1e-6 - depth).abs() < 1e-9 * depth, "{o:?} {depth}");
            assert!(o.velocity.abs() < 1e-12);
        }
    }
}

/// A contactor pulled off the skin feels the preload as a steady push, and the skin no force.
#[test]
fn what_is_pulled_off_the_skin_hangs_on_its_suspension() {
    let plant = Plant::voice_coil(&tactor()).unwrap();
    let bounds = Bounds { preload: Some(0.1), end_stop: None };
    let mut model = Model::bounded(&plant, 48_000.0, Drive::Current, &bounds).unwrap();
    // Skin of 1200 N/m under 0.1 N is 83 µm deep; coil and preload against 3132.7 N/m lift by more than that.
    (0..96_000).for_each(|_| model.advance(-0.5));
    let o = model.outputs();
    assert!((o.displacement - (0.1 - 0.5 * 1.2) / 3132.7).abs() < 1e-12, "{o:?}");
    assert_eq!((o.force, model.contacts().events), (-0.1, 1));
    (0..96_000).for_each(|_| model.advance(-0.25));
    let o = model.outputs();
    assert!((o.displacement + 0.25 * 1.2 / 4332.7).abs() < 1e-12, "{o:?}");
    assert!((o.force + 0.25 * 1.2 / 4332.7 * 1200.0).abs() < 1e-9);
    assert_eq!(model.contacts().events % 2, 0);
    assert!(model.energy() > 0.0);
}

/// Stiff undamped walls on both sides, many bounces a sample: bounded work, a count, and no more energy than before.
#[test]
fn at_the_cap_on_events_it_gives_up_without_gaining() {
    let bare = VoiceCoil { suspension: Spring::default(), skin: Skin::None, ..tactor() };
    let plant = Plant::voice_coil(&bare).unwrap();
    let mut model = Model::bounded(&plant, 1000.0, Drive::Current, &stop(1e-5, 1e8, 0.0)).unwrap();
    model.set_state(&State { velocity: 1.0, ..State::default() });
    let mut last = model.energy();
    for _ in 0..20 {
        model.advance(0.0);
        assert!(model.energy() <= last * (1.0 + 1e-12));
        last = model.energy();
    }
    let counts = model.contacts();
    assert!(counts.capped > 0 && counts.events <= 8 * 20, "{counts:?}");
    assert!(model.state().displacement.abs() < 1e-4);
}

/// What sticks stops at once, and takes what is coupled to it along; the rest of the step passes for that alone, as for a body of its own.
#[test]
fn what_sticks_leaves_the_rest_in_motion() {
    let period = 1e-3;
    let bounds = stop(1e-4, 1e6, 0.0);
    let motor = held();
    let plant = Plant::inertial(&motor).unwrap();
    let mut contact = Contact::<4>::new(&plant, period, Drive::Current, &bounds).unwrap();
    contact.state = [5e-5, 2.0, 1e-4, -0.3];
    contact.stick(WHOLE, 0.0);
    let together = motor.slug_mass + motor.casing_mass + motor.hand.mass;
    let casing = motor.casing_mass + motor.hand.mass;
    let momentum = motor.slug_mass * (2.0 - 0.3) - casing * 0.3;
    let alone = |mass: f64, suspension: Spring, displacement: f64, velocity: f64, push: f64| {
        let coil = Coil { resistance: 1.0, inductance: 0.0, force_factor: 1.0 };
        let plant = Plant::voice_coil(&VoiceCoil { coil, mass, suspension, skin: Skin::None }).unwrap();
        let mut model = Model::new(&plant, 1.0 / period, Drive::Current).unwrap();
        model.set_state(&State { displacement, velocity, ..State::default() });
        model.advance(push);
        model.state()
    };
    let expected = alone(together, motor.hand.spring, 1e-4, momentum / together, 0.0);
    assert_eq!([contact.state[0], contact.state[1]], [5e-5, 0.0]);
    assert!(
        (contact.state[2] / expected.displacement - 1.0).abs() < 1e-12,
        "{:?} {expected:?}",
        contact.state
    );
    assert!((contact.state[3] / expected.velocity - 1.0).abs() < 1e-12, "{:?} {expected:?}", contact.state);

    let v = layered();
    let Skin::Two(_, layer) = v.skin else { unreachable!() };
    let mut contact =
        Contact::<4>::new(&Plant::voice_coil(&v).unwrap(), period, Drive::Current, &bounds).unwrap();
    contact.state = [5e-5, 2.0, 1e-4, -0.3];
    contact.stick(WHOLE, 0.0);
    let spring = Spring {
        stiffness: layer.coupling.stiffness + layer.anchor.stiffness,
        damping: layer.coupling.damping + layer.anchor.damping,
    };
    let expected = alone(layer.mass, spring, 1e-4, -0.3, layer.coupling.stiffness * 5e-5);
    assert!(
        (contact.state[2] / expected.displacement - 1.0).abs() < 1e-12,
        "{:?} {expected:?}",
        contact.state
    );
    assert!((contact.state[3] / expected.velocity - 1.0).abs() < 1e-12, "{:?} {expected:?}", contact.state);
    // A coil that is held takes its current as one without motion.
    let plant = Plant::voice_coil(&tactor()).unwrap();
    let mut contact = Contact::<3>::new(&plant, period, Drive::Voltage, &bounds).unwrap();
    contact.state = [5e-5, 2.0, 0.3];
    contact.stick(WHOLE, 7.0);
    let expected = 1.0 - 0.7 * (-period * 7.0 / 2.5e-4f64).exp();
    assert!((contact.state[2] - expected).abs() < 1e-12, "{:?} {expected}", contact.state);
}

/// A grazing approach: whether the crest between two samples reaches the stop is told from the crest, not from the samples.
#[test]
fn a_crest_between_samples_is_found() {
    let free =
        VoiceCoil { suspension: Spring { stiffness: 1e4, damping: 0.0 }, skin: Skin::None, ..tactor() };
    let plant = Plant::voice_coil(&free).unwrap();
    let crest = 1e-3;
    for (stroke, hits) in [(crest * (1.0 - 1e-9), true), (crest * (1.0 + 1e-9), false)] {
        let mut model = Model::bounded(&plant, 1000.0, Drive::Current, &stop(stroke, 1e7, 0.0)).unwrap();
        // With no damping it swings to the crest and to minus it.
        let omega = (1e4f64 / 1.5e-3).sqrt();
        let phase = -0.5e-3 * omega;
        model.set_state(&State {
            displacement: crest * phase.cos(),
            velocity: -crest * omega * phase.sin(),
            ..State::default()
        });
        model.advance(0.0);
        assert_eq!(model.contacts().events, if hits { 2 } else { 0 }, "{stroke}");
    }
}
