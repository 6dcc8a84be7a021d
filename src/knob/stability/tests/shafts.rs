//! A shaft that twists.

use super::super::rules::gil;
use super::super::sampled::{Loop, Shaft};
use super::rigid;
use crate::knob::low_pass::LowPass;

/// With a stiff shaft the two inertias are one; with a soft one the resonance swings before the knob does.
#[test]
fn a_shaft_swings_by_itself() {
    let shaft =
        Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped: 600.0, loss: 6.571_352_792_9e-5, damping: 2e-5 };
    assert!((shaft.free() - 654.005).abs() < 1e-3 && (shaft.stiffness() - 13.501_618_82).abs() < 1e-6);
    let stiff = Shaft { clamped: 60_000.0, loss: 1e-2, ..shaft };
    let (t, d) = (1e-4, 1.0);
    let one = rigid(2e-5, 1e4, d).edge(0.0);
    let same = Loop::shaft(&stiff, t, d).unwrap().edge(0.0);
    assert!((same.gain / one.gain - 1.0).abs() < 2e-3, "{same:?} {one:?}");
    // The motor's own damping is worth as much to the resonance as to the knob: K sin(ω t_d) / ω against b.
    let undamped = Shaft { loss: 1e-7, ..shaft };
    let bare = Loop::shaft(&undamped, t, d).unwrap().edge(0.0);
    assert!((bare.gain / one.gain - 1.0).abs() < 0.1, "{bare:?} {one:?}");
    // A computed damping that comes late by more than a quarter of its swing feeds it.
    let l = Loop::shaft(&undamped, t, 3.0).unwrap();
    let edge = l.damping_edge();
    let rigid_edge = rigid(2e-5, 1e4, 3.0).damping_edge();
    assert!(
        (edge.hertz / 654.0 - 1.0).abs() < 0.05 && edge.gain < 0.2 * rigid_edge.gain,
        "{edge:?} {rigid_edge:?}"
    );
    let k = 1e-3;
    assert!(l.growth(k, edge.gain * 0.99) < 0.0 && l.growth(k, edge.gain * 1.01) > 0.0);
    // A low-pass below the resonance keeps it out of the loop.
    let smooth = LowPass::new(100.0, t).unwrap();
    let again = l.clone().filtered(&smooth).damping_edge();
    println!("bare {edge:?}, low-pass at 100 Hz {again:?}, rigid {rigid_edge:?}");
    assert!(again.gain > 2.0 * edge.gain);
    let slow = gil(2e-5, 0.0, t, t + smooth.lag());
    let rigid_filtered = rigid(2e-5, 1e4, d).filtered(&smooth).edge(0.0);
    assert!((rigid_filtered.gain / slow - 1.0).abs() < 0.05, "{rigid_filtered:?} {slow}");
}
