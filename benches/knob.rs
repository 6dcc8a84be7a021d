//! A simulated knob: what a step costs, and error against run time of its integrators and friction models, as CPU time of this thread.
//!
//! `cargo bench --bench knob` prints both; the second as CSV: problem, method, steps a second, relative error at the end, ns a step. Errors on
//! the way, with tables and pictures, are those of `examples/knob_error.rs`.

use std::hint::black_box;

use cpu_time::ThreadTime;
use pacinian::knob::plant::Plant;
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::parts::{Build, Drive, Grasp, Hand, Shaft, Winding};
use pacinian::knob::plant::rival::bristle::{Bristle, Bristled};
use pacinian::knob::plant::rival::integrator::{Method, Rival};
use pacinian::knob::plant::rotor::Rotor;
use pacinian::knob::plant::stops::Stops;
use pacinian::knob::plant::wave::{Harmonic, Wave};

/// The least CPU nanoseconds of a step over some runs of so many.
fn least(name: &str, steps: usize, mut run: impl FnMut(usize)) {
    let mut best = f64::INFINITY;
    for _ in 0..15 {
        let start = ThreadTime::now();
        run(steps);
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{:62} {:9.2} ns", name, best / steps as f64 * 1e9);
}

fn main() {
    one_inertia();
    builds();
    println!("\nproblem,method,rate,error,ns");
    walls();
    free_runs();
}

fn one_inertia() {
    let base = Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..Parameters::default() };
    let mut rotor = Rotor::<false>::new(&base, 48e3).unwrap();
    least("friction, slipping, no event", 1 << 18, |n| {
        rotor.place(0.0, 30.0).unwrap();
        for _ in 0..n {
            rotor.step(black_box(1.5e-3));
        }
    });
    least("friction, torque from state (loop latency)", 1 << 18, |n| {
        rotor.place(0.0, 30.0).unwrap();
        for _ in 0..n {
            rotor.step(1.6e-3 - 1e-7 * rotor.angle());
        }
    });
    least("sticking", 1 << 18, |n| {
        rotor.place(0.0, 0.0).unwrap();
        for _ in 0..n {
            rotor.step(black_box(1e-3));
        }
    });
    least("reversal every step (stop, then start the other way)", 1 << 14, |n| {
        rotor.place(0.0, 1.0).unwrap();
        for i in 0..n {
            let speed = rotor.speed();
            rotor.step(black_box(
                -speed * 6e-6 * 48e3 * 2.0 - 1e-3f64.copysign(speed) * if i & 1 == 0 { 2.0 } else { 2.1 },
            ));
        }
    });
    println!("   events {:?}", rotor.counts());
    let walled = |ratio| Parameters {
        coulomb: 0.0,
        stiction: 0.0,
        stops: Some(Stops::of_ratio(-0.01, 0.01, 400.0, ratio, 6e-6)),
        ..Parameters::default()
    };
    for (name, rate, ratio) in [("flight", 48e3, 0.0), ("bounces", 48e3, 0.05), ("bounces", 1e3, 0.0)] {
        let mut rotor = Rotor::<true>::new(&walled(ratio), rate).unwrap();
        let before = rotor.counts().events;
        least(&format!("walled {name}, rate {rate}, zeta {ratio}"), 1 << 14, |n| {
            rotor.place(0.0, 20.0).unwrap();
            for _ in 0..n {
                rotor.step(black_box(0.0));
            }
        });
        println!("   events a step {:.3}", (rotor.counts().events - before) as f64 / (15 << 14) as f64);
    }
    // A gap so narrow that a step sees four contacts made and lost.
    for ratio in [0.0, 0.05] {
        let stops = Some(Stops::of_ratio(-1e-3, 1e-3, 4e4, ratio, 6e-6));
        let narrow = Parameters { stops, viscous: 0.0, ..Parameters::default() };
        let mut rotor = Rotor::<true>::new(&narrow, 1e3).unwrap();
        least(&format!("walled, many events a step, zeta {ratio}"), 1 << 12, |n| {
            for _ in 0..n {
                rotor.place(0.0, 7.0).unwrap();
                rotor.step(black_box(0.0));
            }
        });
        println!(
            "   events a step {:.3}, {:?}",
            rotor.counts().events as f64 / (15 << 12) as f64,
            rotor.counts()
        );
    }
    let rough = Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..walled(0.05) };
    let mut rotor = Rotor::<true>::new(&rough, 1e3).unwrap();
    least("walled and friction, contact, reversal and release in a step", 1 << 12, |n| {
        for _ in 0..n {
            rotor.place(0.0, 20.0).unwrap();
            rotor.step(black_box(0.0));
        }
    });
    println!("   {:?} in {} steps", rotor.counts(), 15 << 12);
    let mut rotor = Rotor::<true>::new(&walled(0.0), 48e3).unwrap();
    least("walled, held against it", 1 << 18, |n| {
        rotor.place(0.0101, 0.0).unwrap();
        for _ in 0..n {
            rotor.step(black_box(0.05));
        }
    });
    let far =
        Parameters { stops: Some(Stops { low: -1e6, high: 1e6, stiffness: 1.0, damping: 0.0 }), ..base };
    let mut rotor = Rotor::<true>::new(&far, 48e3).unwrap();
    least("walled and friction, flight", 1 << 18, |n| {
        rotor.place(0.0, 30.0).unwrap();
        for _ in 0..n {
            rotor.step(black_box(1.5e-3));
        }
    });
}

fn builds() {
    let rough = Parameters { coulomb: 1e-3, stiction: 1.3e-3, inertia: 1e-6, ..Parameters::default() };
    let smooth = Parameters { inertia: 1e-6, ..Parameters::default() };
    let shaft = Some(Shaft { inertia: 5e-6, viscous: 1e-6, stiffness: 14.2, damping: 6e-5 });
    let winding = Winding { resistance: 2.6, inductance: 1.5e-3, gain: 19.7e-3, supply: 19.0 };
    let current = Drive::Current { winding, bandwidth: 6e3, peak: 7.0 };
    let grasp = Some(Grasp { stiffness: 0.3, damping: 2e-3 });
    let stops = Some(Stops { low: -0.4, high: 0.3, stiffness: 40.0, damping: 1e-3 });
    let one = Wave::detent(8e-3, 24.0).unwrap();
    let eight: Vec<Harmonic> =
        (1..=8).map(|n| Harmonic { periods: 12.0 * n as f64, sine: 1e-4, cosine: 1e-4 }).collect();
    let eight = Wave::new(&eight).unwrap();
    let base = Build::default();
    for (name, build) in [
        ("plant, bare", base),
        ("grasp", Build { grasp, ..base }),
        ("two inertias", Build { parameters: smooth, shaft, ..base }),
        ("two inertias, friction", Build { parameters: rough, shaft, ..base }),
        ("voltage", Build { drive: Drive::Voltage(winding), ..base }),
        ("current loop", Build { drive: current, ..base }),
        ("current loop, friction", Build { parameters: rough, drive: current, ..base }),
        ("one harmonic", Build { cogging: one, ..base }),
        ("eight harmonics", Build { cogging: eight, ..base }),
        (
            "all but torque over angle",
            Build { parameters: Parameters { stops, ..rough }, shaft, drive: current, grasp, ..base },
        ),
        (
            "all",
            Build {
                parameters: Parameters { stops, ..rough },
                shaft,
                drive: current,
                grasp,
                cogging: eight,
                ripple: one,
            },
        ),
    ] {
        let mut plant = Plant::new(&build, 48e3).unwrap();
        let hand = Hand { torque: 1e-3, ..Hand::default() };
        least(&format!("{name}, turning"), 1 << 13, |n| {
            plant.place(0.0, 20.0).unwrap();
            for _ in 0..n {
                plant.step(black_box(2e-3), &hand);
                if plant.angle().abs() > 0.25 {
                    plant.place(0.0, 20.0).unwrap();
                }
            }
        });
        let c = plant.counts();
        println!("   events {} crowded {} of {} steps", c.events, c.crowded, 15 << 13);
        if build.parameters.stiction > 0.0 && build.cogging.is_flat() {
            let before = plant.counts().events;
            least(&format!("{name}, an event most steps"), 1 << 12, |n| {
                for i in 0..n {
                    if i & 1 == 0 {
                        plant.place(0.0, 0.01).unwrap();
                    }
                    plant.step(black_box(-4e-3), &hand);
                }
            });
            println!("   events a step {:.3}", (plant.counts().events - before) as f64 / (15 << 12) as f64);
        }
    }
}

const RATES: [f64; 6] = [1e3, 4e3, 8e3, 16e3, 48e3, 192e3];

/// The least time of a step over some runs, ns, and what the last run gave.
fn timed(steps: usize, mut run: impl FnMut(usize) -> f64) -> (f64, f64) {
    let (mut best, mut result) = (f64::INFINITY, 0.0);
    for _ in 0..7 {
        let start = ThreadTime::now();
        result = run(steps);
        best = best.min(start.elapsed().as_secs_f64());
    }
    (best / steps as f64 * 1e9, result)
}

fn walls() {
    for (rim, ratio) in [(1e3, 0.0), (1e4, 0.0), (1e5, 0.0), (1e6, 0.0), (1e4, 0.05)] {
        let stops = Stops::of_ratio(f64::NEG_INFINITY, 0.0, rim * 4e-4, ratio, 6e-6);
        let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
        let q = (1.0f64 - ratio * ratio).sqrt();
        let leaves = (std::f64::consts::PI - (2.0 * ratio * q).atan2(1.0 - 2.0 * ratio * ratio)) / q;
        let expected = -20.0 * (-ratio * leaves).exp();
        let problem = format!("wall {rim:e} N/m ratio {ratio}");
        for rate in RATES {
            let steps = (0.03 * rate) as usize;
            for method in Method::ALL {
                let mut rival = Rival::new(&parameters, method, rate).unwrap();
                let (ns, speed) = timed(steps, |n| {
                    rival.place(-0.0503, 20.0);
                    (0..n).for_each(|_| rival.step(0.0));
                    rival.speed()
                });
                println!("{problem},{},{rate},{:.2e},{ns:.1}", method.name(), (speed / expected - 1.0).abs());
            }
            let mut rotor = Rotor::<true>::new(&parameters, rate).unwrap();
            let (ns, speed) = timed(steps, |n| {
                rotor.place(-0.0503, 20.0).unwrap();
                (0..n).for_each(|_| rotor.step(0.0));
                rotor.speed()
            });
            println!("{problem},exact with events,{rate},{:.2e},{ns:.1}", (speed / expected - 1.0).abs());
        }
    }
}

fn free_runs() {
    // Free running to rest: J ω0 − T_c t over b.
    let parameters = Parameters { coulomb: 1e-3, stiction: 1e-3, ..Parameters::default() };
    let (j, b, c) = (parameters.inertia, parameters.viscous, parameters.coulomb);
    let stop = (j * 35.0 - c * (j / b * (1.0 + b * 35.0 / c).ln())) / b;
    for rate in RATES {
        let steps = (0.2 * rate) as usize;
        let print = |name: &str, (ns, angle): (f64, f64)| {
            println!("free run,{name},{rate},{:.2e},{ns:.1}", (angle / stop - 1.0).abs());
        };
        for method in Method::ALL {
            let mut rival = Rival::new(&parameters, method, rate).unwrap();
            print(
                method.name(),
                timed(steps, |n| {
                    rival.place(0.0, 35.0);
                    (0..n).for_each(|_| rival.step(0.0));
                    rival.angle()
                }),
            );
        }
        for (name, kind) in [
            ("LuGre 100", Bristle::LuGre { stiffness: 100.0, damping: 0.0245, stribeck: 0.5 }),
            ("Dahl 100", Bristle::Dahl { stiffness: 100.0 }),
        ] {
            let mut knob = Bristled::new(&parameters, kind, rate).unwrap();
            print(
                name,
                timed(steps, |n| {
                    knob.place(0.0, 35.0);
                    (0..n).for_each(|_| knob.step(0.0));
                    knob.angle()
                }),
            );
        }
        let mut rotor = Rotor::<false>::new(&parameters, rate).unwrap();
        print(
            "exact with events",
            timed(steps, |n| {
                rotor.place(0.0, 35.0).unwrap();
                (0..n).for_each(|_| rotor.step(0.0));
                rotor.angle()
            }),
        );
    }
}
