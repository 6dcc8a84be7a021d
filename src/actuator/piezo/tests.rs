use super::{Charge, Piezo};
use std::f64::consts::TAU;

fn bender() -> Piezo {
    Piezo {
        capacitance: 1e-6,
        series: 100.0,
        parallel: None,
        loss: 0.02,
        volts: [-30.0, 150.0],
        amperes: 20e-3,
        slew: None,
    }
}

/// I / (2π C V): 20 mA into 1 µF at 60 V is 53 Hz; beyond, a driven sine comes out as a triangle of that slew.
#[test]
fn current_limits_the_frequency() {
    let piezo = bender();
    let edge = piezo.most_hertz(60.0);
    assert!((edge - 20e-3 / (TAU * 1e-6 * 60.0)).abs() < 1e-9 && (edge - 53.05).abs() < 0.01);
    assert!((piezo.most_volts(edge) - 60.0).abs() < 1e-9);
    assert_eq!(piezo.most_volts(1.0), 90.0);
    for (hertz, follows) in [(0.9 * edge, true), (3.0 * edge, false)] {
        let mut charge = Charge::new(&piezo).unwrap();
        let (rate, mut range, mut before) = (192_000.0, [f64::MAX, f64::MIN], 0.0);
        let mut steepest = 0.0f64;
        let count = (3.0 * rate / hertz) as u32;
        for n in 0..count {
            let v = charge.step(60.0 + 60.0 * -(TAU * hertz * f64::from(n) / rate).cos(), 1.0 / rate);
            steepest = steepest.max((v - before).abs() * rate);
            before = v;
            if n > count / 3 {
                range = [v.min(range[0]), v.max(range[1])];
            }
        }
        assert!(steepest <= piezo.most_slew() * (1.0 + 1e-9), "{steepest}");
        assert_eq!(charge.limited() == 0, follows);
        let most = 0.5 * (range[1] - range[0]);
        if follows {
            assert!((most - 60.0).abs() < 0.5, "{most}");
        } else {
            // A triangle of that slew: a quarter of a period up from the middle.
            let triangle = piezo.most_slew() / (4.0 * hertz);
            assert!((most / triangle - 1.0).abs() < 0.05, "{most} {triangle}");
        }
    }
}

/// A step up: a ramp of I / C until the rest is I R_s, then an exponential; the same however it is cut.
#[test]
fn a_leap_is_a_ramp_and_an_exponential() {
    for parallel in [None, Some(1e5)] {
        let piezo = Piezo { parallel, ..bender() };
        for time in [1e-3, 3e-3, 5.1e-3, 20e-3] {
            let (mut one, mut many) = (Charge::new(&piezo).unwrap(), Charge::new(&piezo).unwrap());
            one.step(100.0, time);
            (0..1000).for_each(|_| {
                many.step(100.0, time / 1000.0);
            });
            assert!((one.volts() - many.volts()).abs() < 1e-9, "{time}: {} {}", one.volts(), many.volts());
            if parallel.is_none() {
                let ramp = (100.0 - 2.0) / 20e3;
                let expected =
                    if time < ramp { 20e3 * time } else { 100.0 - 2.0 * (-(time - ramp) / 1e-4).exp() };
                assert!((one.volts() - expected).abs() < 1e-9, "{time}: {} {expected}", one.volts());
            }
        }
    }
    let mut leaking = Charge::new(&Piezo { parallel: Some(900.0), amperes: 1.0, ..bender() }).unwrap();
    leaking.step(100.0, 1.0);
    assert!((leaking.volts() - 90.0).abs() < 1e-9, "what leaks divides the voltage");
    // More leakage than the amplifier gives: the voltage stays at I R_p.
    let mut short = Charge::new(&Piezo { parallel: Some(1000.0), ..bender() }).unwrap();
    short.step(100.0, 1.0);
    assert!((short.volts() - 20.0).abs() < 1e-9, "{}", short.volts());
}

#[test]
fn range_and_slew_are_kept() {
    let mut charge =
        Charge::new(&Piezo { slew: Some(1e3), amperes: 10.0, series: 1e-3, ..bender() }).unwrap();
    (0..10).for_each(|_| {
        charge.step(1e6, 1e-3);
    });
    assert!((charge.volts() - 10.0).abs() < 1e-6 && charge.limited() == 10, "{}", charge.volts());
    (0..1000).for_each(|_| {
        charge.step(f64::NAN, 1e-3);
    });
    assert!(charge.volts().abs() < 1e-9 && charge.masked() == 1000);
    (0..1000).for_each(|_| {
        charge.step(-1e9, 1e-3);
    });
    assert!((charge.volts() + 30.0).abs() < 1e-9);
}

/// A voltage within the range that the slew does not reach in a step is counted, one that it reaches is not.
#[test]
fn what_the_slew_holds_back_is_counted() {
    let mut charge = Charge::new(&Piezo { slew: Some(1e4), amperes: 1.0, ..bender() }).unwrap();
    charge.step(15.0, 1e-3);
    assert_eq!(charge.limited(), 1);
    charge.step(15.0, 1e-3);
    assert_eq!(charge.limited(), 1);
}

/// Real power by integrating v i of a sine over a period, with the three losses told apart.
#[test]
fn losses_add_up() {
    let piezo = Piezo { parallel: Some(1e5), ..bender() };
    let (amplitude, hertz) = (50.0, 40.0);
    let reactive = 0.5 * amplitude * amplitude * TAU * hertz * piezo.capacitance;
    let leak = amplitude * amplitude / 2.0 / 1e5;
    let current = TAU * hertz * piezo.capacitance * amplitude;
    let expected = reactive * 0.02 + leak + current * current / 2.0 * 100.0;
    assert!((piezo.heat(amplitude, hertz) / expected - 1.0).abs() < 1e-12);
}

#[test]
fn figures_that_cannot_be_are_refused() {
    for (piezo, field) in [
        (Piezo { capacitance: 0.0, ..bender() }, "capacitance"),
        (Piezo { series: 0.0, ..bender() }, "series"),
        (Piezo { parallel: Some(-1.0), ..bender() }, "parallel"),
        (Piezo { loss: -0.1, ..bender() }, "loss"),
        (Piezo { volts: [1.0, 150.0], ..bender() }, "volts.low"),
        (Piezo { volts: [-30.0, -1.0], ..bender() }, "volts.high"),
        (Piezo { amperes: f64::NAN, ..bender() }, "amperes"),
        (Piezo { slew: Some(0.0), ..bender() }, "slew"),
    ] {
        assert_eq!(Charge::new(&piezo).unwrap_err().field, field);
    }
}
