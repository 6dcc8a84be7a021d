use super::{Cap, Controller, Observer};
use crate::dsp::random::uniform;
use crate::knob::stability::rules::bounce as closed;
use crate::knob::test_plant::{Delay, Plant};

const J: f64 = 6e-6;
const T: f64 = 1e-3;

/// When the controller runs.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Never,
    /// Outside the wall nothing may be felt.
    InContact,
    /// In contact, and in the tick after.
    UntilLeft,
    /// Until the balance is even again.
    Always,
}

/// Energy out over energy in of one bounce off a sampled wall, without damping, and what the observer has booked over energy in. The knob meets the
/// wall 0.6 of a tick after a reading: then what a bare wall gives back is what was published, to all its digits.
fn bounce(k: f64, delay: usize, when: When, share: f64) -> (f64, f64) {
    let mut plant = Plant::new(J, 0.0, 0.0, T);
    (plant.angle, plant.speed) = (-2.6 * 20.0 * T, 20.0);
    let start = plant.energy();
    let mut line = Delay::new(delay);
    let mut controller = Controller::new(&Cap { inertia: J, share, least_speed: 1e-6 }, T, delay).unwrap();
    let (mut last, mut held, mut was_in) = (plant.angle, 0.0, false);
    for tick in 0..4000 {
        let speed = (plant.angle - last) / T;
        last = plant.angle;
        let wall = -k * plant.angle.max(0.0);
        let is_in = plant.angle > 0.0;
        let runs = match when {
            When::Never => false,
            When::InContact => is_in,
            When::UntilLeft => is_in || was_in,
            When::Always => true,
        };
        was_in = is_in;
        let wanted = if runs {
            controller.tick(plant.angle, speed, held, wall)
        } else {
            controller.observer().observe(plant.angle, held);
            wall
        };
        held = line.pass(wanted);
        plant.step(held);
        if tick > 10 && plant.angle < -0.3 {
            controller.observer().observe(plant.angle, held);
            return (plant.energy() / start, controller.observer().balance() / start);
        }
    }
    panic!("the knob did not come back");
}

/// Exact for a held torque: what the world gave is what the knob gained.
#[test]
fn the_books_are_exact() {
    for (k, delay) in [(0.4, 0), (4.0, 0), (0.4, 1), (2.0, 1), (4.0, 1), (2.0, 2)] {
        for when in [When::Never, When::InContact, When::UntilLeft, When::Always] {
            let (gained, booked) = bounce(k, delay, when, 0.5);
            assert!((gained - 1.0 + booked).abs() < 1e-9 * gained, "{k} {delay}: {gained} {booked}");
        }
    }
    // Along any path at all.
    let (mut observer, mut angle, mut sum) = (Observer::default(), 0.0, 0.0);
    observer.observe(angle, 0.0);
    for n in 0..1000 {
        let (torque, step) = (uniform(1, n), uniform(2, n));
        angle += step;
        sum -= torque * step;
        assert!((observer.observe(angle, torque) - sum).abs() < 1e-12);
    }
}

/// e^{π ω_n t_d} for a wall that is slow against the rate.
#[test]
fn a_bare_wall_gives_what_hold_and_delay_create() {
    let bare = |k: f64, d: usize| bounce(k, d, When::Never, 0.5).0;
    for (k, d, published) in [(0.4, 0, 1.483), (4.0, 0, 3.205), (0.4, 1, 3.210), (4.0, 1, 19.819)] {
        assert!((bare(k, d) - published).abs() < 1e-3, "{k} {d}: {}", bare(k, d));
    }
    assert!((bare(0.04, 0) / closed(0.04, J, 0.5 * T) - 1.0).abs() < 0.02);
}

/// Published for a controller that runs until the tick after the knob has left: 1.483 becomes 1.009, 3.2 becomes 1.064, and a cap of half J / T costs nothing.
#[test]
fn the_controller_leaves_what_was_published_without_delay() {
    for share in [0.5, 1.0, f64::INFINITY] {
        for (k, published) in [(0.4, 1.009), (4.0, 1.064)] {
            let braked = bounce(k, 0, When::UntilLeft, share).0;
            assert!((braked - published).abs() < 1e-3, "{k} {share}: {braked}");
        }
    }
    // In contact alone it leaves more; left to run until the books are even, nothing.
    for (k, most) in [(0.04, 1.1), (0.4, 1.2), (4.0, 2.4)] {
        let (contact, all) = (bounce(k, 0, When::InContact, 0.5).0, bounce(k, 0, When::Always, 0.5));
        assert!(contact > 1.0 && contact < most, "{k}: {contact}");
        assert!((all.0 - 1.0).abs() < 1e-9 && all.1.abs() < 1e-9, "{k}: {}", all.0);
    }
}

/// Published with a tick of delay: 1.018 at best for K 0.4, 1.23 for K 2, 1.73 for K 4, and for two ticks 3.5 for K 2; without a cap the knob never
/// leaves. Braking that is under way is reckoned with here, so all of these leave, and with less.
#[test]
fn what_is_under_way_is_not_braked_twice() {
    for (k, delay, published) in [(0.4, 1, 1.018_f64), (2.0, 1, 1.23), (4.0, 1, 1.73), (2.0, 2, 3.5)] {
        for share in [0.5, 0.75, 1.0, f64::INFINITY] {
            let (bare, braked) =
                (bounce(k, delay, When::Never, share).0, bounce(k, delay, When::Always, share));
            // Nothing that the hand had put in is taken.
            assert!((1.0 - 1e-9..published.min(bare)).contains(&braked.0), "{k} {delay} {share}: {braked:?}");
        }
    }
    // As this module's page has it.
    for (k, left) in [(0.4, 1.000), (2.0, 1.000), (4.0, 1.10)] {
        let braked = bounce(k, 1, When::Always, 0.5).0;
        assert!((braked - left).abs() < 0.005, "{k}: {braked}");
    }
    let even = |k: f64| bounce(k, 1, When::Always, 1.0).0 - 1.0;
    assert!(
        even(0.4) < 1e-6 && even(2.0) < 1e-3 && even(4.0) < 0.01,
        "{} {} {}",
        even(0.4),
        even(2.0),
        even(4.0)
    );
}

/// A damping of c J / T takes a share c of the speed in a tick, and no more.
#[test]
fn the_cap_keeps_the_knob_from_turning_back() {
    for share in [0.25, 0.5, 1.0] {
        let mut controller = Controller::new(&Cap { inertia: J, share, least_speed: 0.01 }, T, 0).unwrap();
        controller.tick(0.0, 0.0, 0.0, 0.0);
        // The world gave a joule: far more than a tick can take back.
        let mut plant = Plant::new(J, 0.0, 0.0, T);
        plant.speed = 3.0;
        let torque = controller.tick(1.0, plant.speed, 1.0, 0.0);
        plant.step(torque);
        assert!((plant.speed - 3.0 * (1.0 - share)).abs() < 1e-12, "{share}: {}", plant.speed);
        // Below the least speed, and for what is not a number, it does nothing.
        for speed in [0.009, 0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(controller.tick(1.0, speed, 0.0, 0.5), 0.5);
        }
        assert_eq!(controller.acted(), 1);
    }
    // A small debt is paid in one tick exactly: α ω² T.
    let mut controller = Controller::new(&Cap { inertia: J, share: 1.0, least_speed: 0.0 }, T, 0).unwrap();
    controller.tick(0.0, 2.0, 0.0, 0.0);
    let torque = controller.tick(1e-3, 2.0, 1e-3, 0.0);
    assert!((-torque * 2.0 * T - 1e-6).abs() < 1e-18);
}

#[test]
fn a_change_of_model_is_booked() {
    let mut controller = Controller::new(&Cap { inertia: J, share: 0.5, least_speed: 0.0 }, T, 0).unwrap();
    let (k, more, p) = (0.4, 0.2, 0.05);
    // Into a spring in small steps, stiffened there, and out again: the change comes out with the rest.
    let steps = 10_000;
    let mut held = 0.0;
    for n in 0..=steps {
        let angle = p * f64::from(n) / f64::from(steps);
        controller.tick(angle, 1.0, held, 0.0);
        held = -k * (angle + 0.5 * p / f64::from(steps));
    }
    controller.observer().book(0.5 * more * p * p);
    for n in (0..=steps).rev() {
        let angle = p * f64::from(n) / f64::from(steps);
        held = -(k + more) * (angle + 0.5 * p / f64::from(steps));
        controller.observer().observe(angle, if n == steps { 0.0 } else { held });
    }
    let observer = controller.observer();
    assert!(observer.balance().abs() < 1e-9 * k * p * p, "{}", observer.balance());
    assert!((observer.booked() - 2.5e-4).abs() < 1e-15 && observer.absorbed() < -2.4e-4);
    observer.book(f64::NAN);
    observer.observe(f64::NAN, 1.0);
    assert!(observer.balance().is_finite());
    observer.reset();
    assert_eq!(observer.balance(), 0.0);
}

#[test]
fn caps_that_cannot_be_are_refused() {
    let good = Cap { inertia: J, share: 0.5, least_speed: 0.1 };
    for (cap, period, field) in [
        (good, 0.0, "period"),
        (Cap { inertia: 0.0, ..good }, T, "inertia"),
        (Cap { share: -1.0, ..good }, T, "share"),
        (Cap { share: f64::NAN, ..good }, T, "share"),
        (Cap { least_speed: -1.0, ..good }, T, "least_speed"),
    ] {
        assert_eq!(Controller::new(&cap, period, 0).unwrap_err().field, field);
    }
    assert_eq!(Controller::new(&good, T, usize::MAX).unwrap_err().field, "late");
}
