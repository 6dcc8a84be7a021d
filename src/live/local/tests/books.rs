//! What the line gives between blocks is booked: heat and energy.

use super::super::{Bounds, Counts, Local, Told};
use super::{MS, bounds, spring, told};
use crate::dsp::random::uniform;
use crate::knob::local_model::profile::Profile;
use crate::knob::safety::budget::Budget;
use crate::knob::safety::chain::Limits;
use crate::knob::test_plant::Plant;
use std::f64::consts::TAU;

const LIMITS: Limits = Limits {
    period: 1e-3,
    slew: 1e9,
    low_pass: None,
    continuous: 0.02,
    winding: 4.0,
    peak: 0.05,
    soft_start: 0.0,
    stale: 10,
    release: 0.1,
    over_speed: 60.0,
};

/// A hand that trembles between the servo's ticks: all that the servo gives is 0, and the winding warms by what the line gives.
#[test]
fn a_tremble_that_the_servo_does_not_see_heats_the_winding() {
    for block in [1, 7, 40] {
        let mut local = Local::new(Bounds { budget: LIMITS.budget().unwrap(), ..bounds() });
        let counts = Counts::default();
        let (stiffness, away) = (2.0, 0.02);
        let asked = stiffness * away;
        let load = |seconds: f64| (asked / LIMITS.continuous).powi(2) * -(-seconds / LIMITS.winding).exp_m1();
        let mut held = 0.0;
        for n in 0..20_000u64 {
            if n % block == 0 {
                local.take(&told(n / block + 1, spring(stiffness, 0.0, 0.1)), &counts);
            }
            let side = if n % 2 == 0 { 1.0 } else { -1.0 };
            let torque = local.torque(n * MS, side * away, 0.0, &counts);
            assert!(torque * side < 0.0 && counts.now().load < 1.0);
            // Until the budget acts it is what was asked, and its load the closed form.
            if counts.now().cut == 0 {
                assert!((torque.abs() - asked).abs() < 1e-15, "{n}");
                assert!((counts.now().load - load(n as f64 * 1e-3)).abs() < 1e-9, "{n}");
            }
            held = torque.abs();
        }
        let end = counts.now();
        assert!(end.cut > 10_000, "{end:?}");
        assert!((held / LIMITS.continuous - 1.0).abs() < 0.02 && end.load > 0.98, "{held} {end:?}");
    }
}

/// The line's end and the servo's chain are held to one budget: a steady torque is cut by neither before the other.
#[test]
fn a_steady_torque_is_cut_where_the_servo_cuts_it() {
    let mut local = Local::new(Bounds { budget: LIMITS.budget().unwrap(), ..bounds() });
    let (counts, mut servo) = (Counts::default(), LIMITS.budget().unwrap());
    for n in 0..30_000u64 {
        let wanted = 0.045f64.min(servo.allowed());
        servo.spend(wanted);
        local.take(&told(n + 1, Profile::flat(wanted)), &counts);
        let given = local.torque(n * MS, 0.0, 0.0, &counts);
        assert!((given / wanted - 1.0).abs() < 1e-9, "{n}: {given} {wanted}");
    }
    assert!(servo.load() > 0.9 && counts.now().load > 0.9);
}

/// A knob without friction, and nothing but the line's torque: what leaves the one is in the other, whichever profiles come and go, on a line
/// that is turned round, some turns away, and where readings are lost.
#[test]
fn energy_is_that_of_the_torques_given_and_the_angles_read() {
    for inverted in [false, true] {
        let mut local = Local::new(Bounds { inverted, ..bounds() });
        let counts = Counts::default();
        let mut plant = Plant::new(2e-5, 0.0, 0.0, 1e-3);
        plant.angle = 0.05;
        let sign = if inverted { -1.0 } else { 1.0 };
        let line = |angle: f64| sign * (angle - 3.0 * TAU);
        let mut most = 0.0f64;
        for n in 0..4000u64 {
            if n % 9 == 0 {
                // The servo may count turns anew, which the line does not.
                let centre = plant.angle + (n / 1000) as f64 * TAU;
                // A spring around where it is, beside a torque that comes and goes.
                let around = spring(0.4 + 0.3 * uniform(3, n), 0.0, 0.01);
                let profile = Profile { centre, torque: 0.01 * uniform(4, n), ..around };
                let profile = if n % 63 == 0 { Profile { centre, ..Profile::flat(0.002) } } else { profile };
                local.take(&Told { heard: line(plant.angle), ..told(n / 9 + 1, profile) }, &counts);
            }
            let torque = match n % 101 {
                50 => local.nothing(n * MS, line(plant.angle), &counts),
                _ => local.torque(n * MS, line(plant.angle), 0.0, &counts),
            };
            let kinetic = 0.5 * plant.inertia * plant.speed * plant.speed;
            most = most.max(kinetic);
            assert!((counts.now().absorbed + kinetic).abs() < 1e-9 * most.max(1e-6), "{n}");
            plant.step(torque);
        }
        assert!(most > 1e-5, "{most}");
        // A reading that is no number loses neither the books nor what comes after it.
        let before = counts.now().absorbed;
        local.torque(4000 * MS, f64::NAN, 0.0, &counts);
        local.torque(4001 * MS, line(plant.angle), 0.0, &counts);
        assert_eq!(counts.now().absorbed, before);
    }
}

/// Where a line stands still its winding cools, and a clock that goes back is no time.
#[test]
fn without_torque_it_cools() {
    let budget = Budget::new(0.02, 4.0, 1.0, 1e-3).unwrap();
    let mut hot = budget;
    hot.spend_over(0.03, 4.0);
    let warm = hot.load();
    assert!((warm - 2.25 * (1.0 - (-1.0f64).exp())).abs() < 1e-12);
    hot.spend_over(0.0, 4.0);
    assert!((hot.load() - warm * (-1.0f64).exp()).abs() < 1e-12);
    let before = hot;
    hot.spend_over(0.05, -1.0);
    hot.spend_over(f64::NAN, 1.0);
    assert_eq!(hot, before);
}
