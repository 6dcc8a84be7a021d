//! What is let out of drives, against the winding and the mean square that it is for.

use super::{Bears, Budget};
use crate::actuator::drive::Drive;
use crate::actuator::thermal::{COPPER, Cooling, Thermal};

const RATE: f64 = 8000.0;
const OHMS: f64 = 7.0;

fn cooling() -> Cooling {
    Cooling {
        resistance: OHMS,
        rise: COPPER,
        to_housing: 20.0,
        to_air: 60.0,
        winding_time: 0.8,
        housing_time: 40.0,
        most: 80.0,
    }
}

fn warm(drive: Drive) -> Budget {
    let bears = Bears { heat: Some(cooling()), rms: None };
    Budget::new(&bears, drive, OHMS, RATE).unwrap()
}

fn square(rms: f64, drive: Drive) -> Budget {
    let bears = Bears { heat: None, rms: Some([rms, 0.8]) };
    Budget::new(&bears, drive, OHMS, RATE).unwrap()
}

/// A sample of a steady drive, `amperes` for each of it: what was let out.
fn sample(budget: &mut Budget, drive: f64, amperes: f64) -> f64 {
    let left = budget.hold(drive).0;
    budget.note(1.0, [drive * drive, left * left, (amperes * left).powi(2)]);
    budget.pass(1);
    left
}

/// A tick is 1/400 of the time: 16 samples here. At its end, not before, the winding is as warm as the current of its samples makes it.
#[test]
fn the_winding_is_that_of_the_current_noted() {
    let mut budget = warm(Drive::Voltage);
    let mut thermal = Thermal::new(&cooling()).unwrap();
    let mut warmest = 0.0_f64;
    for (amperes, parts) in [(3.0_f64, vec![1.0]), (6.0, vec![0.25, 0.75]), (0.0, vec![0.5, 0.5])] {
        for n in 1..=16 {
            let before = budget.temperature();
            for share in &parts {
                budget.note(*share, [1.0, 1.0, amperes * amperes]);
            }
            if n % 4 == 0 {
                // Said otherwise after all.
                budget.flowed(1.0);
            }
            budget.pass(6);
            assert_eq!(before != budget.temperature(), n == 16, "{amperes} {n}");
        }
        thermal.step((12.0 * amperes * amperes + 4.0) / 16.0, 16.0 / RATE);
        let is = budget.temperature().unwrap();
        assert!((is / thermal.winding() - 1.0).abs() < 1e-12, "{amperes}: {is} {thermal:?}");
        warmest = warmest.max(is);
    }
    (0..8000).for_each(|_| budget.pass(6));
    assert!(budget.temperature().unwrap() < 0.5 * warmest);
    assert_eq!((budget.counts().warmest, budget.counts().samples), (warmest, 8048 * 6));
}

/// Volts and amperes alike: at first all may leave that a tick bears, in the end what the winding bears for ever.
#[test]
fn heat_is_kept_of_volts_and_of_amperes() {
    let steady = cooling().continuous_amperes();
    for drive in [Drive::Voltage, Drive::Current] {
        let mut budget = warm(drive);
        let cold = if drive == Drive::Voltage { OHMS } else { 1.0 };
        // What, held for a tick, would heat it to its limit if it shed nothing and were as hot all the while: 80 × 1.02 K and C = 0.8/20 J/K.
        let most = (81.6 * 0.04 / (16.0 / RATE) / (OHMS * (1.0 + COPPER * 81.6))).sqrt();
        let (cap, by_heat) = budget.hold(1e9);
        assert!(by_heat && (cap / (most * cold) - 1.0).abs() < 0.01, "{drive:?}: {cap} {most}");
        let mut left = 0.0;
        for _ in 0..400_000 {
            // Of volts, less flows as it becomes warm.
            let hot = OHMS * (1.0 + COPPER * budget.temperature().unwrap());
            let amperes = if drive == Drive::Voltage { 1.0 / hot } else { 1.0 };
            left = amperes * sample(&mut budget, 5.0 * steady * cold, amperes);
        }
        let is = budget.temperature().unwrap();
        assert!((is - 80.0).abs() < 0.1, "{drive:?}: {is}");
        assert!(budget.counts().warmest < 82.0);
        // The housing is still on its way, so what leaves is a little more.
        assert!((left / steady - 1.0).abs() < 0.1 && left > steady, "{drive:?}: {left} {steady}");
    }
}

/// The mean square is that of the volts, of a current those on the winding alone.
#[test]
fn the_mean_square_is_one_of_volts() {
    for (drive, end) in [(Drive::Voltage, 2.0), (Drive::Current, 2.0 / OHMS)] {
        let mut budget = square(2.0, drive);
        let left = (0..80_000).map(|_| sample(&mut budget, 5.0 * end, 0.0)).last().unwrap();
        assert!((left / end - 1.0).abs() < 1e-6, "{drive:?}: {left}");
        assert!(!budget.hold(5.0 * end).1, "it is not the heat");
        let mut budget = square(2.0, drive);
        assert!((0..80_000).all(|_| sample(&mut budget, end, 0.0) == end), "what it bears for ever");
    }
}

/// What is set aside for a click is there for it to its end, and nothing is left for more.
#[test]
fn a_share_is_what_may_leave_and_no_more() {
    for rms in [true, false] {
        for passed in [0, 5] {
            let mut budget = if rms { square(2.0, Drive::Voltage) } else { warm(Drive::Voltage) };
            (0..passed).for_each(|_| _ = sample(&mut budget, 1.0, 1.0 / OHMS));
            let (wanted, length) = (1000.0, 160 - passed);
            let (share, by_heat) = budget.share(wanted * wanted, f64::from(length) / RATE);
            assert!(share > 0.0 && share < 0.2 && by_heat != rms, "{share}");
            let left = share * wanted;
            for _ in 0..length {
                budget.reserve();
                budget.note(1.0, [wanted * wanted, left * left, (left / OHMS).powi(2)]);
                budget.pass(1);
            }
            if let Some(kelvins) = budget.temperature() {
                // Reckoned as if it were hot all the while, and shed nothing.
                assert!(kelvins < 81.6 + 1e-6 && kelvins > 60.0, "{passed}: {kelvins}");
            } else {
                let cap = budget.hold(1e9).0.powi(2);
                // Of an empty store a tick takes 4 × 1.02 V² × 400; what is left of it now is next to nothing.
                assert!(cap < 0.02 * 4.08 * 400.0, "{passed}: {cap}");
            }
        }
    }
    // Of nothing, everything.
    assert_eq!(square(2.0, Drive::Voltage).share(0.0, 0.1).0, 1.0);
}

/// In a tick that has part in what was set aside, what else is let out is what that left of the cap of the whole; in the next it is the cap again.
#[test]
fn a_tick_that_was_set_aside_lets_out_no_more_than_its_cap() {
    let mut budget = square(2.0, Drive::Voltage);
    let cap = budget.hold(1e9).0;
    budget.reserve();
    for _ in 0..8 {
        budget.note(1.0, [1.0, cap * cap, 0.0]);
        budget.pass(1);
    }
    let rest = budget.hold(1e9).0;
    assert!(rest <= cap && rest > 0.0);
    for _ in 0..4 {
        budget.note(1.0, [1.0, 1.9 * cap * cap, 0.0]);
        budget.pass(1);
    }
    // 8 and 4 × 1.9 of 16 are gone, and 4 samples are left: (16 − 15.6)/4.
    let rest = budget.hold(1e9).0;
    assert!(((rest / cap).powi(2) - 0.1).abs() < 1e-9, "{rest} {cap}");
    (0..4).for_each(|_| budget.pass(1));
    // One that was not set aside: each sample may be as much as the cap, whatever left before.
    let mut budget = square(2.0, Drive::Voltage);
    budget.note(1.0, [1.0, 10.0 * cap * cap, 0.0]);
    budget.pass(1);
    assert_eq!(budget.hold(1e9).0, cap);
    budget.reserve();
    assert!(budget.hold(1e9).0 < cap);
    (0..15).for_each(|_| budget.pass(1));
    let next = budget.hold(1e9).0;
    budget.note(1.0, [1.0, 10.0 * next * next, 0.0]);
    budget.pass(1);
    assert_eq!(budget.hold(1e9).0, next, "that is over with its tick");
}

/// Where the mean square turned everything down, a click is turned down by no less.
#[test]
fn a_share_is_no_more_than_the_gain() {
    let mut budget = square(2.0, Drive::Voltage);
    (0..80_000).for_each(|_| _ = sample(&mut budget, 20.0, 0.0));
    let gain = budget.hold(1e-3).0 / 1e-3;
    assert!((gain - 0.1).abs() < 1e-3, "{gain}");
    let (share, by_heat) = budget.share(1e-6, 0.01);
    assert!((share / gain - 1.0).abs() < 1e-3 && !by_heat, "{share} {gain}");
}

/// Which of both held a drive back, by how much at most, and in how many frames.
#[test]
fn it_is_told_what_held_back_what() {
    let bears = Bears { heat: Some(cooling()), rms: Some([1e-3, 0.8]) };
    let mut budget = Budget::new(&bears, Drive::Voltage, OHMS, RATE).unwrap();
    assert!(!budget.hold(100.0).1, "the mean square is the lower");
    let bears = Bears { rms: Some([1e3, 0.8]), ..bears };
    assert!(Budget::new(&bears, Drive::Voltage, OHMS, RATE).unwrap().hold(1e4).1, "the heat is");
    budget.changed(3.0, 1.0, true);
    budget.changed(3.0, 2.5, true);
    budget.pass(6);
    budget.changed(1.0, 0.5, false);
    budget.pass(6);
    budget.pass(6);
    let counts = budget.counts();
    assert_eq!((counts.samples, counts.changed), (18, 12));
    assert_eq!((counts.heat.samples, counts.heat.most), (6, 2.0));
    assert_eq!((counts.rms.samples, counts.rms.most), (6, 0.5));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let field = |bears: Bears, ohms: f64, rate: f64| {
        Budget::new(&bears, Drive::Voltage, ohms, rate).unwrap_err().field
    };
    let none = Bears::default();
    assert_eq!(field(none, 0.0, RATE), "resistance");
    assert_eq!(field(none, OHMS, 10.0), "rate");
    assert_eq!(field(Bears { rms: Some([0.0, 1.0]), ..none }, OHMS, RATE), "rms.most");
    assert_eq!(field(Bears { rms: Some([1.0, 0.001]), ..none }, OHMS, RATE), "rms.seconds");
    assert_eq!(field(Bears { heat: Some(Cooling { most: 0.0, ..cooling() }), ..none }, OHMS, RATE), "most");
}
