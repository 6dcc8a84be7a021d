//! What is no number, and what cannot be.

use super::super::{Build, Chain, Drive, Hand};
use super::{full, shaft, state, winding};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Grasp, Shaft, Winding};
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::Wave;
use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};

#[test]
fn what_is_no_number_is_none_and_counted() {
    let mut chain = Chain::new(&full(), 1e3).unwrap();
    let wild = [f64::NAN, f64::INFINITY, -1e300];
    for value in wild {
        chain.step(value, &Hand { torque: value, target: value, target_speed: value });
        assert!(state(&chain).iter().all(|x| *x == 0.0), "{:?}", state(&chain));
    }
    assert_eq!(chain.counts().masked, 9);
}

#[test]
fn what_cannot_be_is_named() {
    let w = winding();
    for (build, field) in [
        (Build { shaft: Some(Shaft { inertia: 0.0, ..shaft() }), ..full() }, "shaft inertia"),
        (Build { shaft: Some(Shaft { stiffness: f64::NAN, ..shaft() }), ..full() }, "shaft stiffness"),
        (Build { drive: Drive::Voltage(Winding { inductance: 0.0, ..w }), ..full() }, "inductance"),
        (Build { drive: Drive::Voltage(Winding { resistance: -1.0, ..w }), ..full() }, "resistance"),
        (Build { drive: Drive::Current { winding: w, bandwidth: 0.0, peak: 1.0 }, ..full() }, "bandwidth"),
        (Build { drive: Drive::Current { winding: w, bandwidth: 1e3, peak: 0.0 }, ..full() }, "peak"),
        (Build { grasp: Some(Grasp { stiffness: -1.0, damping: 0.0 }), ..full() }, "grasp stiffness"),
        (Build { parameters: Parameters { inertia: -1.0, ..full().parameters }, ..full() }, "inertia"),
    ] {
        assert_eq!(Chain::new(&build, 1e3).unwrap_err().field, field);
    }
    let stiff = Build { shaft: Some(Shaft { stiffness: 1e9, ..shaft() }), ..full() };
    let fault = Chain::new(&stiff, 1.0).unwrap_err();
    assert_eq!(fault.field, "rate");
    assert!(fault.because.is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn nothing_finite_makes_it_panic_or_lose_its_number(
        e in proptest::array::uniform14(0.0f64..1.0), torques in proptest::collection::vec(any::<f64>(), 1..12),
        kind in 0..3, parts in 0..8,
    ) {
        let power = |n: usize, low: f64, high: f64| 10f64.powf(low + (high - low) * e[n]);
        let coulomb = power(2, -9.0, 1.0);
        let w = Winding {
            resistance: power(6, -3.0, 3.0), inductance: power(7, -7.0, 1.0), gain: power(8, -6.0, 1.0), supply: power(9, -2.0, 3.0),
        };
        let build = Build {
            parameters: Parameters {
                inertia: power(0, -9.0, 0.0), viscous: power(1, -9.0, 0.0), coulomb, stiction: coulomb * 1.5,
                stops: Some(Stops { low: -0.1, high: 0.1, stiffness: power(3, -3.0, 4.0), damping: power(4, -9.0, 1.0) }),
            },
            shaft: (parts & 1 > 0).then(|| Shaft {
                inertia: power(10, -9.0, 0.0), viscous: 0.0, stiffness: power(11, -3.0, 4.0), damping: power(12, -9.0, 0.0),
            }),
            grasp: (parts & 2 > 0).then(|| Grasp { stiffness: power(13, -3.0, 3.0), damping: 1e-3 }),
            drive: match kind {
                0 => Drive::Torque,
                1 => Drive::Voltage(w),
                _ => Drive::Current { winding: w, bandwidth: power(5, 1.0, 5.0), peak: 10.0 },
            },
            cogging: if parts & 4 > 0 { full().cogging } else { Wave::default() },
            ripple: if parts & 4 > 0 { full().ripple } else { Wave::default() },
        };
        let Ok(mut chain) = Chain::new(&build, power(5, 2.5, 6.0)) else { return Ok(()) };
        chain.place(0.2 * (e[5] - 0.5), 1e3 * (e[6] - 0.5)).unwrap();
        for torque in torques {
            chain.step(torque, &Hand { torque, target: torque, target_speed: 0.0 });
            chain.step(torque % 1.0, &Hand { torque: torque % 0.1, target: torque % 0.2, target_speed: 0.1 });
            prop_assert!(state(&chain).iter().all(|x| x.is_finite()) && chain.voltage().is_finite(), "{:?}", state(&chain));
        }
    }
}
