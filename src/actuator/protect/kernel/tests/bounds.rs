//! Bounds as they follow from limits and motors, and those that cannot be.

use super::{
    Actuator, Alternating, Bounds, Casing, Cooling, Limits, Parameters, Protection, RATE, Rms, TAU, Unit,
    all, bits, cooling, hostile, none, plant, run,
};

#[test]
fn what_is_derived_from_limits_and_motors_is_what_they_say() {
    let limits = Limits { volts: Some(5.0), amperes: Some(0.5), amperes_rms: Some(0.25), stroke: Some(3e-4) };
    let b = Bounds::coil(&plant(), &limits, 6.0, 2.0);
    assert_eq!((b.peak, b.stroke, b.full_scale), (Some(3.5), Some(3e-4), Some(6.0)));
    assert_eq!(b.rms, Some(Rms { most: 0.25, unit: Unit::Amperes, seconds: 2.0 }));
    assert!(Protection::new(&b, 48e3).is_ok());
    assert_eq!(Bounds::coil(&plant(), &Limits { amperes: None, ..limits }, 6.0, 2.0).peak, Some(5.0));
    let coin = Parameters {
        resistance: 30.0,
        inductance: 3e-4,
        gain: 0.955e-3,
        inertia: 1.8e-9,
        viscous: 2.15e-8,
        coulomb: 0.0,
        stiction: 0.0,
        eccentric: 7.3e-7,
        gravity: 0.0,
        casing: Casing::Held,
        rated_volts: 3.0,
    };
    let b = Bounds::motor(&coin, 5.0, 1.5);
    assert_eq!((b.peak, b.rms.unwrap().most), (Some(4.5), 3.0));
    let time = 1.8e-9 * 30.0 / (0.955e-3f64.powi(2) + 2.15e-8 * 30.0);
    assert!((b.alternating.unwrap().hertz * TAU * time - 1.0).abs() < 1e-12);
    // At its rated voltage it runs untouched for ever.
    let rated = vec![0.6; 200_000];
    assert!(bits(&run(&b, RATE, &rated).0) == bits(&rated));
}

/// What bears less one way than the other: nothing leaves beyond either end, also where 0 is one, and what lies between leaves as it is.
#[test]
fn a_range_is_kept_to_at_both_ends() {
    let input = hostile(50_000);
    for range in [[-0.5, 2.0], [0.0, 3.0], [-4.0, 0.0], [-0.3, f64::INFINITY]] {
        for (peak, slew) in [(None, None), (Some(1.5), None), (None, Some(1.5e4))] {
            let (out, counts) = run(&Bounds { range: Some(range), peak, slew, ..none() }, RATE, &input);
            let [low, high] = peak.map_or(range, |peak: f64| [range[0].max(-peak), range[1].min(peak)]);
            let mut held = 0;
            for (came, left) in input.iter().zip(&out) {
                let volts = f64::from(*left) * 5.0;
                assert!(volts >= low && volts <= high, "{range:?} {peak:?} {slew:?}: {came} {volts}");
                // What is no number becomes 0, also where nothing is too high.
                let inside = came.is_finite() && (low..=high).contains(&(f64::from(*came) * 5.0));
                held += u64::from(came.is_finite() && !inside);
                assert!(slew.is_some() || !inside || came.to_bits() == left.to_bits(), "{came} {left}");
            }
            assert_eq!(counts.peak.samples, held);
        }
    }
    let refused = |range: [f64; 2], more: Bounds| {
        Protection::new(&Bounds { range: Some(range), ..more }, 48e3).unwrap_err().field
    };
    for (range, field) in [
        ([0.1, 1.0], "range.low"),
        ([f64::NAN, 1.0], "range.low"),
        ([-1.0, -0.1], "range.high"),
        ([0.0, 0.0], "range.high"),
        ([-1.0, f64::NAN], "range.high"),
    ] {
        assert_eq!(refused(range, none()), field, "{range:?}");
    }
    assert_eq!(refused([-1.0, 1.0], all()), "stroke");
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |bounds: Bounds| Protection::new(&bounds, 48e3).unwrap_err().field;
    let rms = Rms { most: 1.0, unit: Unit::Volts, seconds: 1.0 };
    let a = Alternating { hertz: 5.0, most: 1.0, seconds: 1.0 };
    for (bounds, field) in [
        (Bounds { full_scale: Some(0.0), ..none() }, "full_scale"),
        (Bounds { peak: Some(f64::NAN), ..none() }, "peak"),
        (Bounds { slew: Some(-1.0), ..none() }, "slew"),
        (Bounds { stroke: Some(0.0), ..all() }, "stroke"),
        (Bounds { steady: Some(-0.1), ..none() }, "steady"),
        (Bounds { rms: Some(Rms { most: 0.0, ..rms }), ..none() }, "rms.most"),
        (Bounds { rms: Some(Rms { seconds: f64::INFINITY, ..rms }), ..none() }, "rms.seconds"),
        (Bounds { rms: Some(Rms { unit: Unit::Amperes, ..rms }), ..none() }, "rms.most"),
        (Bounds { alternating: Some(Alternating { hertz: 0.0, ..a }), ..none() }, "alternating.hertz"),
        (Bounds { alternating: Some(Alternating { most: -1.0, ..a }), ..none() }, "alternating.most"),
        (Bounds { alternating: Some(Alternating { seconds: 0.0, ..a }), ..none() }, "alternating.seconds"),
        (Bounds { heat: Some(Cooling { most: 0.0, ..cooling() }), ..none() }, "most"),
        (Bounds { stroke: Some(1e-3), ..none() }, "stroke"),
        (Bounds { actuator: Actuator::Resistance(0.0), ..none() }, "resistance"),
        (Bounds { full_scale: None, ..all() }, "rms.most"),
        (Bounds { heat: Some(cooling()), ..Bounds::default() }, "heat.most"),
        (Bounds { steady: Some(0.1), ..Bounds::default() }, "steady"),
    ] {
        assert_eq!(refused(bounds), field);
    }
    for rate in [0.0, f64::NAN, 5999.0, 1.1e6] {
        assert_eq!(Protection::new(&none(), rate).unwrap_err().field, "rate");
    }
    let text = Bounds { stroke: Some(1e-3), ..none() }.check().unwrap_err().to_string();
    assert_eq!(
        text,
        "`stroke` is 0.001, but must be left out: it is not known how far a volt moves the actuator"
    );
}
