use super::device::{Delay, Device, Resonance};
use super::limit::{Limit, Remedy};
use super::{Governor, MARGIN};
use crate::knob::effect::Bound;
use crate::knob::stability::rules::gil;
use crate::knob::test_plant::{Delay as Line, Plant, count, floor};

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
    let block = |block| Delay { fixed: 1.4, block, frames: 1.0, blocks: 2.0 };
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
        delay: Delay { fixed: 0.0, block: 64, frames: 1.0, blocks: 2.0 },
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
            Device { delay: Delay { fixed: 0.0, block: 60_000, frames: 1.0, blocks: 2.0 }, ..good.clone() },
            "delay",
        ),
        (Device { resonance, ..good.clone() }, "knob"),
        (Device { low_pass: Some(0.0), ..good.clone() }, "low_pass"),
    ] {
        assert_eq!(Governor::new(&d, MARGIN).unwrap_err().field, field);
    }
    assert!(Governor::new(&good, 0.0).is_err() && Governor::new(&good, 1.1).is_err());
}
