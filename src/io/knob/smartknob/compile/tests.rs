//! Effects into configurations.

use super::{Compiled, Device, compile};
use crate::knob::effect::constant::Constant;
use crate::knob::effect::damper::Damper;
use crate::knob::effect::detent::Detent;
use crate::knob::effect::magnet::Magnet;
use crate::knob::effect::program::Any;
use crate::knob::effect::snap::Snap;
use crate::knob::effect::spring::Spring;
use crate::knob::effect::wall::{Stops, Wall};
use std::f64::consts::TAU;

fn of(effects: &[Any], angle: f64) -> Compiled {
    compile(effects, &Device { stiffness: 0.1 }, angle, "t").unwrap()
}

fn stops(low: f64, high: f64) -> Any {
    Stops { low, high, stiffness: 0.1, damping: 0.0 }.into()
}

#[test]
fn nothing_is_a_free_knob() {
    let Compiled { feel, near, left_out, holds } = of(&[], 1.0);
    assert!(!feel.config.has_ends() && feel.config.detent_strength == 0.0);
    assert!(near.is_empty() && left_out.is_empty() && holds.is_none());
    let at = f64::from(feel.config.position) + f64::from(feel.config.sub_position);
    assert!((feel.origin + at * f64::from(feel.config.width) - 1.0).abs() < 1e-6);
}

#[test]
fn ends_stand_where_they_were() {
    let Compiled { feel, near, left_out, .. } = of(&[stops(-0.5, 0.8)], 0.0);
    let at = |position: i32| feel.origin + f64::from(position) * f64::from(feel.config.width);
    assert!((at(feel.config.min) + 0.5).abs() < 1e-6 && (at(feel.config.max) - 0.8).abs() < 1e-6);
    assert!((feel.config.endstop_strength - 1.0).abs() < 1e-6 && near.is_empty() && left_out.is_empty());
    let wall = Wall { angle: 0.3, below: false, stiffness: 1.0, damping: 1e-3 };
    let Compiled { feel, near, .. } = of(&[wall.into()], 0.0);
    assert_eq!((feel.config.max, feel.config.min, feel.origin), (0, -super::FAR, 0.3));
    assert_eq!((feel.config.endstop_strength, near.len()), (2.5, 2), "too stiff, and its own damping");
}

#[test]
fn detents_and_a_switch() {
    let Compiled { feel, left_out, .. } =
        of(&[Detent::with_stiffness(24.0, 0.05).into(), stops(0.0, TAU / 6.0)], 0.0);
    let config = &feel.config;
    assert!(
        (f64::from(config.width) - TAU / 24.0).abs() < 1e-6 && (config.detent_strength - 0.5).abs() < 1e-6
    );
    assert_eq!((config.min, config.max), (0, 4));
    assert!((config.snap_point - 0.55).abs() < 1e-6 && left_out.is_empty());
    let snap = Snap { width: 1.0, stiffness: 0.1, most: 0.02, point: 0.55, centre: 0.0 };
    let Compiled { feel, near, .. } = of(&[snap.into(), stops(0.0, 1.0)], 0.9);
    assert_eq!((feel.config.min, feel.config.max, feel.config.position), (0, 1, 1));
    assert!((feel.config.sub_position + 0.1).abs() < 1e-6);
    assert!(near.iter().any(|remark| remark.why.contains("0.02 N m")));
}

#[test]
fn a_spring_takes_the_ends() {
    let Compiled { feel, left_out, .. } =
        of(&[Spring { stiffness: 0.06, centre: 0.2 }.into(), stops(-1.0, 1.0)], 0.0);
    assert_eq!((feel.config.min, feel.config.max, feel.origin), (0, 0, 0.2));
    assert!((feel.config.endstop_strength - 0.6).abs() < 1e-6);
    assert_eq!((left_out.len(), left_out[0].effect, left_out[0].name), (1, 1, "stops"));
}

#[test]
fn magnets_are_the_five_nearest() {
    let magnet = |centre: f64| Any::from(Magnet { centre, stiffness: 0.05, reach: 0.1 });
    let one = of(&[magnet(0.4)], 0.4);
    assert_eq!((one.feel.config.detents.as_slice(), one.feel.origin, one.holds), (&[0][..], 0.4, None));
    let row: Vec<Any> = (0..9).map(|k| magnet(0.3 * f64::from(k))).collect();
    let mid = of(&row, 1.25);
    let config = &mid.feel.config;
    assert_eq!(config.detents.len(), 5);
    for (place, wanted) in config.detents.iter().zip([0.6, 0.9, 1.2, 1.5, 1.8]) {
        let at = mid.feel.origin + f64::from(*place) * f64::from(config.width);
        assert!((at - wanted).abs() < 1e-3, "{at} {wanted}");
    }
    let (low, high) = mid.holds.unwrap();
    assert!((low - 1.05).abs() < 1e-9 && (high - 1.35).abs() < 1e-9, "{low} {high}");
    let next = of(&row, 1.36);
    assert!((next.holds.unwrap().0 - 1.35).abs() < 1e-9);
}

#[test]
fn what_it_cannot_be_is_told() {
    let effects = [
        Damper { damping: 1e-3 }.into(),
        Constant { torque: 0.01 }.into(),
        Spring { stiffness: 0.1, centre: 0.0 }.into(),
        Detent::with_stiffness(12.0, 0.1).into(),
    ];
    let told: Vec<_> = of(&effects, 0.0).left_out.into_iter().map(|r| (r.effect, r.name)).collect();
    assert_eq!(told, [(0, "damper"), (1, "constant"), (3, "detent")]);
    let broken = [Spring { stiffness: -1.0, centre: 0.0 }.into()];
    let (effect, fault) = compile(&broken, &Device { stiffness: 0.1 }, 0.0, "").unwrap_err();
    assert_eq!((effect, fault.field), (Some(0), "stiffness"));
    assert_eq!(compile(&[], &Device { stiffness: 0.0 }, 0.0, "").unwrap_err().1.field, "stiffness");
    assert_eq!(compile(&[], &Device { stiffness: 0.1 }, 0.0, &"x".repeat(51)).unwrap_err().1.field, "text");
}
