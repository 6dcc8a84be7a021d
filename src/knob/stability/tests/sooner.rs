//! Springs whose torque comes sooner than that of the damping.

use super::super::sampled::Loop;
use super::{J, rigid};
use crate::knob::governor::device::{Delay as Late, Device};
use crate::knob::governor::{Governor, MARGIN};
use crate::knob::test_plant::{Delay, Plant};
use crate::knob::velocity::choice::Choice;
use crate::knob::velocity::transfer::Transfer;

const B: f64 = 1e-4;
const RATE: f64 = 8000.0;
/// Ticks after which the spring acts, and the damping.
const LATE: [(usize, usize); 6] = [(0, 3), (3, 11), (8, 12), (12, 32), (32, 128), (16, 512)];

/// Whether a knob goes on swinging; its speed is a difference over `window` ticks.
fn grows([spring, damper]: [usize; 2], window: usize, (k, b): (f64, f64), hertz: f64) -> bool {
    let mut plant = Plant::new(J, B, 0.0, 1.0 / RATE);
    plant.angle = 1.0;
    let (mut stiff, mut viscous) = (Delay::new(spring), Delay::new(damper));
    let mut past = vec![1.0; window];
    let span = (50.0 * RATE / hertz) as usize;
    let mut peaks = [0.0f64; 3];
    let mut tick = 0;
    for peak in &mut peaks {
        for _ in 0..span {
            let speed = (plant.angle - past[tick % window]) / window as f64 * RATE;
            past[tick % window] = plant.angle;
            tick += 1;
            let torque = stiff.pass(-k * plant.angle) + viscous.pass(-b * speed);
            plant.step(torque);
            *peak = peak.max(plant.angle.abs());
        }
    }
    peaks[2] > peaks[1]
}

/// By bisection on simulated knobs, which know nothing of eigenvalues; and by all eigenvalues.
#[test]
fn a_knob_begins_to_swing_at_the_edge_of_both_delays() {
    for (spring, damper) in LATE {
        for window in [1, 5] {
            let one = rigid(B, RATE, damper as f64).estimated(Transfer::difference(window));
            let one = one.sooner(damper - spring);
            for share in [0.0, 0.2, 0.6] {
                let b = share * one.damping_edge().gain;
                let edge = one.edge(b);
                let (mut low, mut high) = (0.7 * edge.gain, 1.3 * edge.gain);
                let what = format!("{spring} and {damper} ticks, over {window}, {share}: {edge:?}");
                let grows = |k: f64| grows([spring, damper], window, (k, b), edge.hertz);
                assert!(grows(high) && !grows(low), "{what}");
                while high - low > 1e-3 * low {
                    let middle = 0.5 * (low + high);
                    if grows(middle) { high = middle } else { low = middle }
                }
                assert!((low / edge.gain - 1.0).abs() < 0.01, "{what}: {low}");
                if damper < 100 {
                    let radius = |by: f64| one.radius(edge.gain * by, b);
                    assert!(radius(1.0 - 1e-5) < 1.0 && radius(1.0 + 1e-5) > 1.0, "{what}");
                }
            }
        }
    }
}

/// As soon as each other they are the loop that has one delay; and a spring alone has the delay of its own.
#[test]
fn one_delay_is_both_that_are_alike() {
    for late in [0.0, 2.4, 32.0] {
        let one = rigid(B, RATE, late);
        assert_eq!(one.clone().sooner(0), one);
        let far = rigid(B, RATE, late + 40.0).sooner(40);
        assert!((far.edge(0.0).gain / one.edge(0.0).gain - 1.0).abs() < 1e-12);
        let growth = |of: &Loop| of.growth(0.5 * one.edge(0.0).gain, 0.0);
        assert!((growth(&far) / growth(&one) - 1.0).abs() < 1e-6, "{late}");
    }
    // No torque is sooner than its reading.
    assert_eq!(rigid(B, RATE, 3.0).sooner(9), rigid(B, RATE, 3.0).sooner(3));
}

/// What is granted lies within the edge at every damping, and is what the line's delay bears where the spring is alone.
#[test]
fn the_governor_grants_what_the_line_bears() {
    let device = |block: u32, local: Option<f64>| Device {
        inertia: 2e-5,
        damping: 4e-4,
        friction: None,
        count: 1e-6,
        period: 1.0 / RATE,
        delay: Late { fixed: 32.0, block, frames: 6.0, blocks: 2.0, local },
        resonance: None,
        low_pass: None,
        velocity: Choice::Adaptive(0.01),
        peak: 0.05,
    };
    for (block, times) in [(32, 1.28), (64, 1.6), (256, 3.4)] {
        let [late, local] = [None, Some(32.0)].map(|local| device(block, local));
        let [before, now] = [&late, &local].map(|d| Governor::new(d, MARGIN).unwrap());
        let gain = now.most_stiffness(0.0) / before.most_stiffness(0.0);
        println!("block {block}: {gain} times");
        assert!(gain > times && now.most_damping() == before.most_damping(), "{block}: {gain}");
        let alone = Device { delay: Late::ticks(32.0), ..local.clone() };
        let alone = Governor::new(&alone, MARGIN).unwrap().most_stiffness(0.0);
        // What the delays differ by is rounded down to whole ticks.
        assert!((0.97..1.000_001).contains(&(now.most_stiffness(0.0) / alone)));
        let sampled = local.sampled().unwrap();
        for k in 0..100 {
            let b = now.most_damping() * f64::from(k) / 100.0;
            let (granted, edge) = (now.most_stiffness(b), sampled.edge(b).gain);
            assert!(granted <= 1.02 * MARGIN * edge, "{block}, {b}: {granted} of {edge}");
        }
        let says = now.explain(0.0).unwrap().to_string();
        assert!(says.contains("bound by the delay") && says.contains("16 ticks on the line"), "{says}");
    }
}
