use super::{Law, Push, Run};
use crate::actuator::motor::{Drive, Motor, Parameters, Plan, Wish};

/// The law against the exact motor: without inductance and gravity they are one.
#[test]
fn it_is_the_motor_where_gravity_and_inductance_are_left_out() {
    let p = Parameters { gravity: 0.0, inductance: 0.0, ..Parameters::COIN };
    let plan = Plan::choose(&p, 8000.0, &Wish { error: 0.0, posture: true, casing: true });
    let mut motor = Motor::<false>::new(&p, &plan, 8000.0).unwrap();
    let inertia = p.effective_inertia();
    let law = Law {
        gain: p.gain / p.resistance / inertia,
        rate: 1.0 / p.mechanical_time(),
        drag: p.coulomb / inertia,
        late: 0.0,
        coast: p.viscous / inertia,
        gravity: 0.0,
        damping: 0.0,
    };
    let volts: Vec<f64> = (0..1600).map(|n| if n < 800 { -3.0 } else { -1.5 }).collect();
    let open: Vec<_> = std::iter::once(1200..1400).collect();
    let push = Push { samples: &volts, held: true, open: &open, period: 1.0 / 8000.0 };
    let spun = law.spin(&Run { samples: 0..1600, sense: -1.0, start: 0.0 }, &push).unwrap();
    for n in 0..1600 {
        let turned = std::f64::consts::TAU * motor.reading().turns + motor.reading().angle;
        assert!((spun.speed[n] + motor.speed()).abs() < 1e-8, "{n}: {} {}", spun.speed[n], motor.speed());
        assert!((spun.angle[n] + turned).abs() < 1e-9 * (1.0 + turned.abs()), "{n}");
        motor.drive(if open[0].contains(&n) { Drive::Open } else { Drive::Voltage(volts[n]) });
        if n > 0 {
            assert!((spun.bend[n] + motor.angular_acceleration()).abs() < 1e-6 * law.drag, "{n}");
        }
        motor.step();
    }
    // Half a sample late: the volt-seconds of both neighbours.
    let late = Law { late: 0.5 / 8000.0, ..law };
    let spun = late.spin(&Run { samples: 700..900, sense: -1.0, start: 1000.0 }, &push).unwrap();
    let held = |n: usize| spun.bend[n] + law.drag + law.rate * spun.speed[n];
    assert!((held(100) / law.gain - 2.25).abs() < 1e-9 && (held(101) / law.gain - 1.5).abs() < 1e-9);
    assert!(Law { rate: -11.0, ..law }.spin(&Run { samples: 0..9, sense: 1.0, start: 0.0 }, &push).is_none());
}

/// What gravity takes of the mean speed, against the exact motor over some hundred turns: near the slowest speed that is used, where it takes
/// 0.4 % (and is 1e4 times what the mean over turns that are not whole leaves open), and at twice that.
#[test]
fn gravity_slows_a_rotor_as_the_law_says() {
    let p = Parameters { inductance: 0.0, ..Parameters::COIN };
    let inertia = p.effective_inertia();
    let free = Law {
        gain: p.gain / p.resistance / inertia,
        rate: 1.0 / p.mechanical_time(),
        drag: p.coulomb / inertia,
        late: 0.0,
        coast: 0.0,
        gravity: 0.0,
        damping: 1.0 / p.mechanical_time(),
    };
    let law = Law { gravity: p.weight() / inertia, ..free };
    for (volts, takes) in [(0.83, 0.003..0.006), (1.2, 0.000_05..0.001)] {
        let plan = Plan::choose(&p, 8000.0, &Wish { error: 0.0, posture: true, casing: true });
        let mut motor = Motor::<false>::new(&p, &plan, 8000.0).unwrap();
        motor.place(0.0, p.steady_speed(volts));
        motor.drive(Drive::Voltage(volts));
        let turned =
            |motor: &Motor<false>| std::f64::consts::TAU * motor.reading().turns + motor.reading().angle;
        (0..8000).for_each(|_| motor.step());
        let before = turned(&motor);
        (0..80_000).for_each(|_| motor.step());
        let mean = (turned(&motor) - before) / 10.0;
        let drive = vec![volts; 8000];
        let push = Push { samples: &drive, held: true, open: &[], period: 1.0 / 8000.0 };
        let settles = |law: &Law| {
            let spun = law.spin(&Run { samples: 0..8000, sense: 1.0, start: mean }, &push).unwrap();
            spun.speed[7999]
        };
        let [without, with] = [settles(&free), settles(&law)];
        assert!(mean > law.slowest() && takes.contains(&(without / mean - 1.0)), "{mean} {without}");
        assert!((without - with) / (without - mean) > 0.85, "{mean} {with} {without}");
        assert!((without - with) / (without - mean) < 1.15, "{mean} {with} {without}");
    }
}

/// Turns of a known recording, ahead by 0.2 rad, with a second harmonic of 5 % a quarter of a period off.
#[test]
fn a_window_reads_angle_arm_and_harmonic() {
    let law =
        Law { gain: 2000.0, rate: 20.0, drag: 500.0, late: 0.0, coast: 1.0, gravity: 0.0, damping: 0.0 };
    let volts = vec![3.0; 4000];
    let push = Push { samples: &volts, held: true, open: &[], period: 1e-4 };
    let spun = law.spin(&Run { samples: 0..4000, sense: 1.0, start: 100.0 }, &push).unwrap();
    // Without a harmonic, every window does, that of the fastest change first.
    let clean = |n: usize| {
        let angle = spun.angle[n] + 0.2;
        spun.speed[n].powi(2) * angle.sin() - spun.bend[n] * angle.cos()
    };
    let clean: Vec<f64> = (0..4000).map(clean).collect();
    for w in spun.windows(&clean) {
        assert!((w.ahead - 0.2).abs() < 1e-9 && (w.arm - 1.0).abs() < 1e-9, "{w:?}");
    }
    let x: Vec<f64> = (0..4000)
        .map(|n| {
            let (angle, w2) = (spun.angle[n] + 0.2, spun.speed[n].powi(2));
            1e-5 * (w2 * angle.sin() - spun.bend[n] * angle.cos()) + 5e-7 * w2 * (2.0 * angle).cos()
        })
        .collect();
    let windows = spun.windows(&x);
    assert!(windows.len() > 12, "{}", windows.len());
    for w in &windows[windows.len() - 8..] {
        assert!((w.ahead - 0.2).abs() < 2e-3 && (w.arm / 1e-5 - 1.0).abs() < 3e-3, "{w:?}");
        assert!(w.second[0].abs() < 2e-3 && (w.second[1] - 0.05).abs() < 2e-3, "{w:?}");
    }
}
