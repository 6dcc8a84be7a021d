//! Energy is kept, or lost.

use super::super::{Build, Chain, Drive};
use super::{FREE, full, mixed};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::wave::Wave;

#[test]
fn nothing_makes_energy_by_itself() {
    for (n, rate) in [500.0, 1e3, 8e3, 48e3].into_iter().enumerate() {
        for waved in [false, true] {
            let build = Build {
                drive: Drive::Torque,
                grasp: None,
                ripple: Wave::default(),
                cogging: if waved { full().cogging } else { Wave::default() },
                ..full()
            };
            for start in 0..6 {
                let mut chain = Chain::new(&build, rate).unwrap();
                chain.place(0.25 * mixed(start), 60.0 * mixed(start + 10 * n as u64)).unwrap();
                let mut last = chain.energy();
                for _ in 0..(0.1 * rate) as usize {
                    chain.step(0.0, &FREE);
                    let now = chain.energy();
                    // A wall that is left with a dent keeps no energy of the knob's; one that is met again has none to give.
                    if chain.contact == super::super::Contact::Away {
                        assert!(now <= last + 1e-12 * last.abs() + 1e-18, "{rate} {waved}: {last} {now}");
                        last = now;
                    }
                }
                assert_eq!(chain.counts().crowded, 0);
            }
        }
    }
}

#[test]
fn a_detent_without_friction_keeps_its_energy() {
    let parameters = Parameters { viscous: 0.0, ..Parameters::default() };
    let build = Build { parameters, cogging: Wave::detent(8e-3, 24.0).unwrap(), ..Build::default() };
    for rate in [200.0, 1e3, 48e3] {
        let mut chain = Chain::new(&build, rate).unwrap();
        chain.place(0.02, 9.0).unwrap();
        let before = chain.energy();
        (0..(2.0 * rate) as usize).for_each(|_| chain.step(0.0, &FREE));
        assert!((chain.energy() / before - 1.0).abs() < 1e-11, "{rate}: {}", chain.energy() / before);
    }
}
