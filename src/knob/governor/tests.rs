use super::device::{Delay, Device, Resonance};
use super::limit::{Limit, Remedy};
use super::{Governor, MARGIN};
use crate::knob::effect::Bound;
use crate::knob::stability::rules::gil;
use crate::knob::test_plant::{Delay as Line, Plant, count, floor};
use crate::knob::velocity::Estimator;
use crate::knob::velocity::choice::Choice;

const KNOB: f64 = 5e-6;

/// The motors of the founding text's Table 1 with a knob, under voltage and under current drive.
fn motors() -> Vec<Device> {
    let base = Device {
        inertia: 1.6e-6 + KNOB,
        damping: 0.15e-3,
        friction: Some(2.1e-3),
        count: count(4096.0),
        period: 1e-3,
        delay: Delay::ticks(0.0),
        resonance: None,
        low_pass: None,
        velocity: Choice::Difference,
        peak: 0.150,
    };
    let coreless = Device {
        inertia: 0.95e-6 + KNOB,
        damping: 0.21e-3,
        friction: None,
        count: count(4000.0),
        peak: 0.175,
        ..base.clone()
    };
    let current = |d: &Device| Device { damping: 1e-5, ..d.clone() };
    vec![base.clone(), current(&base), coreless.clone(), current(&coreless)]
}

fn loops() -> Vec<(f64, Delay)> {
    let block = |block| Delay { fixed: 1.4, block, frames: 1.0, blocks: 2.0, local: None };
    vec![
        (1e3, Delay::ticks(1.0)),
        (1e4, Delay::ticks(0.0)),
        (48e3, Delay { fixed: 0.0, ..block(16) }),
        (48e3, Delay { fixed: 0.0, ..block(64) }),
        (48e3, Delay { fixed: 0.0, ..block(512) }),
    ]
}

/// A sampled knob with encoder and delay under a hand; gives the true angle to a watcher until it says stop.
fn simulate<F: FnMut(u64, f64) -> bool>(
    d: &Device,
    friction: f64,
    k: f64,
    hand: f64,
    start: f64,
    mut watch: F,
) {
    let mut plant = Plant::new(d.inertia, d.damping, friction, d.period);
    plant.angle = start;
    let mut line = Line::new(d.delay.total() as usize);
    for _ in 0..d.delay.total() as usize {
        line.pass(-k * floor(start, d.count));
    }
    for tick in 0.. {
        plant.step(line.pass(-k * floor(plant.angle, d.count)) + hand);
        if watch(tick, plant.angle) {
            return;
        }
    }
}

#[test]
fn at_half_the_limit_a_knob_settles_within_two_counts() {
    for motor in motors() {
        for (rate, delay) in loops() {
            let d = Device { period: 1.0 / rate, delay, ..motor.clone() };
            let governor = Governor::new(&d, MARGIN).unwrap();
            let k = 0.5 * governor.most_stiffness(0.0);
            assert!(k > 0.0);
            // Six of its slowest time constants, and then a while to look at it.
            let rate_of_rest = -d.sampled().unwrap().growth(k, 0.0);
            let settle = (6.0 / rate_of_rest * rate) as u64;
            let watch = (0.3 / rate_of_rest * rate) as u64 + (20.0 * rate * (d.inertia / k).sqrt()) as u64;
            let mut worst = 0.0f64;
            let forces = 100;
            for n in 0..forces {
                // Spread over ten counts and all parts of one.
                let share = (f64::from(n) + 0.37) / f64::from(forces);
                let hand = k * d.count * (10.0 * share);
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                let start = hand / k + 6.0 * d.count;
                simulate(&d, d.friction.unwrap_or(0.0), k, hand, start, |tick, angle| {
                    if tick >= settle {
                        (low, high) = (low.min(angle), high.max(angle));
                    }
                    tick > settle + watch
                });
                worst = worst.max((high - low) / d.count);
            }
            assert!(worst <= 2.0, "{rate} Hz, {delay:?}, {motor:?}: {worst} counts at {k}");
        }
    }
}

#[test]
fn at_one_and_a_half_times_the_edge_it_swings() {
    for motor in motors() {
        for (rate, delay) in loops() {
            let d = Device { period: 1.0 / rate, delay, friction: None, ..motor.clone() };
            let sampled = d.sampled().unwrap();
            let k = 1.5 * sampled.edge(0.0).gain;
            let time = 60f64.ln() / sampled.growth(k, 0.0);
            for n in 0..10 {
                let hand = k * d.count * f64::from(n) * 0.73;
                let mut far = 0.0f64;
                let limit = (3.0 * time * rate) as u64 + 1000;
                simulate(&d, 0.0, k, hand, hand / k + 3.0 * d.count, |tick, angle| {
                    far = far.max((angle - hand / k).abs() / d.count);
                    tick > limit || far > 100.0
                });
                assert!(far > 50.0, "{rate} Hz, {delay:?}, {motor:?}: {far} counts");
            }
        }
    }
}

#[test]
fn it_says_what_binds_and_what_would_lift_it() {
    let base = Device { damping: 0.21e-3, friction: None, ..motors()[2].clone() };
    let at = |d: Device, b: f64| Governor::new(&d, MARGIN).unwrap().explain(b).unwrap();
    // A sound card's block: four times smaller blocks allow four times as much.
    let card = Device {
        period: 1.0 / 48e3,
        delay: Delay { fixed: 0.0, block: 64, frames: 1.0, blocks: 2.0, local: None },
        ..base.clone()
    };
    let e = at(card.clone(), 0.0);
    assert_eq!(e.binds, Limit::Delay);
    let (_, times) = e.remedies.iter().find(|r| r.0 == Remedy::Block(16)).unwrap();
    let rule: f64 = 128.5 / 32.5;
    assert!((times / rule - 1.0).abs() < 0.05, "{times}");
    assert!(
        e.to_string().contains(&format!("bound by the delay; block 16 would allow {times:.1} times")),
        "{e}"
    );
    assert!((e.edge.0 / gil(0.21e-3, 0.0, 1.0 / 48e3, 128.0 / 48e3) - 1.0).abs() < 0.05);
    // No delay: the rate.
    let e = at(Device { period: 1e-4, ..base.clone() }, 0.0);
    assert!(
        e.binds == Limit::Sampling && e.remedies.iter().any(|r| matches!(r.0, Remedy::Rate(_)) && r.1 > 1.9),
        "{e}"
    );
    // Little friction and few counts.
    let e = at(Device { period: 1e-5, friction: Some(1e-4), ..base.clone() }, 0.0);
    assert!(e.binds == Limit::Quantisation && (e.stiffness - 2e-4 / base.count).abs() < 1e-12, "{e}");
    assert!(matches!(e.remedies[0], (Remedy::Counts(n), _) if (n - 8000.0).abs() < 1e-6), "{e}");
    // So little torque that a count asks for all of it.
    let e = at(Device { period: 1e-5, peak: 1e-4, ..base.clone() }, 0.0);
    assert!(
        e.binds == Limit::Torque && matches!(e.remedies[0], (Remedy::Peak(_) | Remedy::Counts(_), _)),
        "{e}"
    );
    // Much computed damping with a delay.
    let late = Device { period: 1e-4, delay: Delay::ticks(1.0), damping: 2e-5, ..base.clone() };
    let governor = Governor::new(&late, 1.0).unwrap();
    let e = governor.explain(0.995 * governor.most_damping()).unwrap();
    assert_eq!(e.binds, Limit::ComputedDamping, "{e}");
    // A shaft that computed damping sets ringing.
    let resonance = Some(Resonance { clamped: 600.0, knob: KNOB, loss: 1e-7 });
    let shaft = Device { resonance, delay: Delay::ticks(3.0), period: 1e-4, ..late };
    let governor = Governor::new(&shaft, 1.0).unwrap();
    let rigid = Governor::new(&Device { resonance: None, ..shaft.clone() }, 1.0).unwrap();
    assert!(
        governor.most_damping() < 0.2 * rigid.most_damping() && governor.binds_damping() == Limit::Resonance
    );
    // A low-pass that is later than all else.
    let slow = Device { period: 1e-4, low_pass: Some(30.0), ..base };
    let e = at(slow, 0.0);
    assert!(e.binds == Limit::LowPass && e.remedies[0].0 == Remedy::NoLowPass, "{e}");
}

/// The table over damping against the exact edge between its points, and the shares it grants.
#[test]
fn what_is_granted_is_within_the_exact_edge() {
    for motor in motors() {
        for (rate, delay) in loops() {
            let d = Device { period: 1.0 / rate, delay, friction: None, peak: 1e9, ..motor.clone() };
            let (governor, sampled) = (Governor::new(&d, MARGIN).unwrap(), d.sampled().unwrap());
            assert!(governor.most_damping() > 0.0);
            for share in [0.0, 0.013, 0.3, 0.51, 0.77, 0.99, 1.0] {
                let b = share * governor.most_damping();
                let (got, exact) = (governor.most_stiffness(b), MARGIN * sampled.edge_within(b).gain);
                assert!(got <= exact * 1.001 && got >= 0.9 * exact, "{rate} {share}: {got} {exact}");
            }
            let limit = governor.most_stiffness(0.0);
            let ask = |stiffness, damping| governor.allow(&Bound { stiffness, damping });
            assert!(!ask(0.99 * limit, 0.0).acted());
            assert!((ask(4.0 * limit, 0.0).stiffness - 0.25).abs() < 1e-12);
            let both = ask(1e9, 10.0 * governor.most_damping());
            assert!((both.damping - 0.1).abs() < 1e-12);
            assert!(both.stiffness * 1e9 <= governor.most_stiffness(governor.most_damping()) * (1.0 + 1e-12));
            for wild in [f64::NAN, f64::INFINITY] {
                assert!(ask(wild, 0.0).stiffness == 0.0 && ask(0.0, wild).damping == 0.0);
            }
        }
    }
}

#[test]
fn a_knob_without_damping_gets_no_stiffness() {
    let d = Device { damping: 0.0, ..motors()[3].clone() };
    let governor = Governor::new(&d, MARGIN).unwrap();
    assert_eq!(governor.most_stiffness(0.0), 0.0);
    assert!(governor.most_damping() > 0.0 && governor.most_stiffness(0.5 * governor.most_damping()) > 0.0);
    let range = motors()[0].dynamic_range().unwrap();
    assert!((range - 71.4).abs() < 0.1 && motors()[2].dynamic_range().is_none());
}

#[test]
fn contradictory_devices_are_refused() {
    let good = motors()[0].clone();
    let resonance = Some(Resonance { clamped: 600.0, knob: 1e-3, loss: 0.0 });
    for (d, field) in [
        (Device { inertia: 0.0, ..good.clone() }, "inertia"),
        (Device { damping: -1.0, ..good.clone() }, "damping"),
        (Device { friction: Some(f64::NAN), ..good.clone() }, "friction"),
        (Device { count: 0.0, ..good.clone() }, "count"),
        (Device { period: 0.0, ..good.clone() }, "period"),
        (Device { peak: 0.0, ..good.clone() }, "peak"),
        (Device { delay: Delay::ticks(-1.0), ..good.clone() }, "fixed"),
        (
            Device {
                delay: Delay { fixed: 0.0, block: 60_000, frames: 1.0, blocks: 2.0, local: None },
                ..good.clone()
            },
            "delay",
        ),
        (Device { resonance, ..good.clone() }, "knob"),
        (Device { low_pass: Some(0.0), ..good.clone() }, "low_pass"),
    ] {
        assert_eq!(Governor::new(&d, MARGIN).unwrap_err().field, field);
    }
    assert!(Governor::new(&good, 0.0).is_err() && Governor::new(&good, 1.1).is_err());
}

const ESTIMATORS: [Choice; 5] = [
    Choice::Difference,
    Choice::Filtered(400.0),
    Choice::Filtered(80.0),
    Choice::Adaptive(0.01),
    Choice::Kalman(2000.0),
];

/// How far a knob still swings, in counts, when what does not swing by itself would have come to rest long ago. It starts some counts
/// off.
fn swing(d: &Device, friction: f64, gains: (f64, f64), hand: f64, off: f64) -> f64 {
    let (k, b) = gains;
    let rate = 1.0 / d.period;
    let settle = (60.0 * 2.0 * d.inertia / (d.damping + b) * rate) as u64;
    let watch = settle + (20.0 * rate * (d.inertia / k).sqrt()) as u64;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    damped(d, friction, gains, hand, hand / k + off * d.count, |tick, angle| {
        if tick >= settle {
            (low, high) = (low.min(angle), high.max(angle));
        }
        tick > watch || angle.is_nan() || angle.abs() >= 1e6
    });
    if high.is_finite() { (high - low) / d.count } else { f64::INFINITY }
}

/// Springs and dampers together, speed by each estimator as it is: at half the limit the knob settles, at one and a half times the
/// edge it swings.
#[test]
fn with_every_estimator_half_the_limit_settles_and_more_than_the_edge_swings() {
    for motor in motors() {
        for (rate, delay) in loops() {
            for velocity in ESTIMATORS {
                if matches!(velocity, Choice::Filtered(hertz) if hertz > 0.3 * rate) {
                    continue;
                }
                let d = Device { period: 1.0 / rate, delay, velocity, ..motor.clone() };
                let governor = Governor::new(&d, MARGIN).unwrap();
                let b = 0.5 * governor.most_damping();
                let k = 0.5 * governor.most_stiffness(b);
                let what =
                    format!("{rate} Hz, {delay:?}, {motor:?}, {velocity:?}: {k} N m/rad, {b} N m s/rad");
                assert!(k > 0.0 && b > 0.0, "{what}");
                let hands = (0..10).map(|n| f64::from(n) * 1.137 * k * d.count);
                let friction = d.friction.unwrap_or(0.0);
                let worst = hands.map(|hand| swing(&d, friction, (k, b), hand, 6.0)).fold(0.0, f64::max);
                assert!(worst <= 2.0, "{worst} counts: {what}");
                let k = 1.5 * d.sampled().unwrap().edge(b).gain;
                let least = swing(&d, 0.0, (k, b), 0.37 * k * d.count, 100.0);
                // A window that shortens as the swing grows may hold it at a count or two.
                let swings = if matches!(velocity, Choice::Adaptive(_)) { 0.5 } else { 2.0 };
                assert!(least > swings, "{least} counts at {k} N m/rad: {what}");
            }
        }
    }
}

/// What is granted to a plain difference, a knob whose speed comes later does not bear.
#[test]
fn what_a_plain_difference_bears_others_do_not() {
    let d = Device { period: 1.0 / 48e3, friction: None, ..motors()[2].clone() };
    let told = Governor::new(&d, MARGIN).unwrap();
    let gains = (told.most_stiffness(told.most_damping()), told.most_damping());
    for velocity in &ESTIMATORS[1..] {
        let d = Device { velocity: *velocity, ..d.clone() };
        assert!(swing(&d, 0.0, gains, 0.0, 6.0) > 20.0, "{velocity:?}");
        let e = Governor::new(&d, MARGIN).unwrap();
        assert!(e.most_damping() < 0.2 * told.most_damping(), "{velocity:?}");
        assert_eq!(e.binds_damping(), Limit::Estimator, "{velocity:?}");
        let says = e.explain(e.most_damping()).unwrap();
        let quicker = velocity.quicker().unwrap();
        assert_eq!(says.binds, Limit::Estimator, "{velocity:?}: {says}");
        assert!(says.remedies.iter().any(|one| one.0 == Remedy::Estimator(quicker) && one.1 > 1.5), "{says}");
    }
}

/// As [`simulate`], with a damper beside the spring.
fn damped<F: FnMut(u64, f64) -> bool>(
    d: &Device,
    friction: f64,
    (k, b): (f64, f64),
    hand: f64,
    start: f64,
    mut watch: F,
) {
    let mut plant = Plant::new(d.inertia, d.damping, friction, d.period);
    plant.angle = start;
    let mut estimator = d.velocity.started(d.count, d.period).unwrap();
    estimator.reset(floor(start, d.count));
    let mut line = Line::new(d.delay.total() as usize);
    for _ in 0..d.delay.total() as usize {
        line.pass(-k * floor(start, d.count));
    }
    for tick in 0.. {
        let seen = floor(plant.angle, d.count);
        plant.step(line.pass(-k * seen - b * estimator.push(seen)) + hand);
        if watch(tick, plant.angle) {
            return;
        }
    }
}
