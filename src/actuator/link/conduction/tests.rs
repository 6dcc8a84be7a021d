//! What a carrier makes flow, against closed forms and the circuit itself.

use super::{Carrier, Conduction, PI, Rectifier, TAU};

fn carrier(full_wave: bool, drop: f64) -> Carrier {
    Carrier { hertz: 4000.0, rectifier: Rectifier { full_wave, drop } }
}

/// Without inductance: the closed form of the half-waves above what stands against them, which is also their mean by the definition.
#[test]
fn without_inductance_it_is_the_closed_form() {
    for full_wave in [true, false] {
        for (amplitude, emf, drop) in
            [(3.0, 0.0, 0.0), (3.0, 1.5, 0.0), (5.5, 2.4, 1.4), (1.0, 0.98, 0.0), (7.0, 0.1, 0.6)]
        {
            let conduction = Conduction::new(&carrier(full_wave, drop), 0.0).unwrap();
            let is = conduction.mean(amplitude, emf);
            let u: f64 = emf + drop;
            let angle = (u / amplitude).acos();
            let share = if full_wave { 2.0 / PI } else { 1.0 / PI };
            let closed = share * ((amplitude * amplitude - u * u).sqrt() - u * angle);
            assert!((is - closed).abs() < 1e-12, "{is} {closed}");
            let count = 100_000;
            let passes = |n: i32| {
                let x = TAU * (f64::from(n) + 0.5) / f64::from(count);
                let volts = amplitude * x.sin();
                ((if full_wave { volts.abs() } else { volts }) - u).max(0.0)
            };
            let sum = (0..count).map(passes).sum::<f64>() / f64::from(count);
            assert!((is - sum).abs() < 1e-8, "{is} {sum}");
            assert_eq!(conduction.mean(u, emf), 0.0);
        }
    }
}

/// The mean of R i that a circuit settles to, by its own equation L i' = |A sin x| − u − R i with i ≥ 0 in small steps (trapezoids, and the
/// current's end within a step where a straight line has it), for an amplitude.
fn settled(full_wave: bool, lag: f64, amplitude: f64, opposed: f64) -> f64 {
    let count = 4000;
    let step = TAU / f64::from(count);
    let source = |n: i32| {
        let x = (step * f64::from(n)).sin() * amplitude;
        (if full_wave { x.abs() } else { x }) - opposed
    };
    let (mut current, mut sum) = (0.0_f64, 0.0);
    let turns = 4 + (8.0 * lag) as i32;
    let half = 0.5 * step / lag;
    for n in 0..count * turns {
        if n == count * (turns - 1) {
            sum = 0.0;
        }
        let (now, then) = (source(n % count), source(n % count + 1));
        let next = (current * (1.0 - half) + half * (now + then)) / (1.0 + half);
        let flowed =
            if next >= 0.0 { 0.5 * (current + next) } else { 0.5 * current * current / (current - next) };
        sum += flowed / f64::from(count);
        current = next.max(0.0);
    }
    sum
}

/// What is looked up makes the circuit itself carry the mean that was asked for: from a motor at rest to one that takes nearly all, for every lag,
/// and where the current begins never to cease above all.
#[test]
fn the_circuit_carries_what_was_asked_for() {
    for (full_wave, drop) in [(true, 0.0), (true, 1.4), (false, 0.7)] {
        for lag in [0.02, 0.25, 0.6, 2.0, 10.0, 50.0] {
            let conduction = Conduction::new(&carrier(full_wave, drop), lag / TAU / 4000.0).unwrap();
            for (shares, within) in [
                // Every size of the wish as a share of what there is to work against.
                ((1..40).map(|n| f64::from(n) / 40.0).collect::<Vec<f64>>(), 3e-4),
                (vec![0.015, 0.01], 3e-4),
                (vec![0.003, 1e-3], 1.5e-3),
            ] {
                for share in shares {
                    let (whole, mean) = (3.0, 3.0 * share);
                    let against = whole - mean;
                    let amplitude = conduction.amplitude(mean, against - drop);
                    let is = settled(full_wave, lag, amplitude, against);
                    assert!(
                        (is / mean - 1.0).abs() < within,
                        "{full_wave} {lag} {share}: {is} for {mean}, {:.2} %",
                        100.0 * (is / mean - 1.0)
                    );
                }
            }
        }
    }
}

/// With inductance: the steady state of L i' = |A sin x| − u − R i, i ≥ 0, in small steps.
#[test]
fn with_inductance_it_is_what_the_circuit_settles_to() {
    for full_wave in [true, false] {
        for lag in [0.05, 0.6, 2.0, 10.0] {
            for opposed in [0.0, 0.2, 0.5, 0.62, 0.9] {
                let count = 20_000;
                let step = TAU / f64::from(count);
                let (mut current, mut sum) = (0.0_f64, 0.0);
                let turns = 12 + (6.0 * lag) as i32;
                for n in 0..count * turns {
                    let x: f64 = step * (f64::from(n % count) + 0.5);
                    let source = if full_wave { x.sin().abs() } else { x.sin() } - opposed;
                    let middle = current + 0.5 * step / lag * (source - current);
                    let next = current + step / lag * (source - middle);
                    // Diodes let nothing back.
                    let next = if next > 0.0 { next } else { 0.0 };
                    if n >= count * (turns - 1) {
                        sum += 0.5 * (current + next) / f64::from(count);
                    }
                    current = next;
                }
                let conduction = Conduction::new(&carrier(full_wave, 0.0), lag / TAU / 4000.0).unwrap();
                let is = conduction.mean(2.0, 2.0 * opposed);
                assert!(
                    (is - 2.0 * sum).abs() < 2e-3 * sum + 1e-4,
                    "{full_wave} {lag} {opposed}: {is} {}",
                    2.0 * sum
                );
            }
        }
    }
}

/// What is looked up makes what was asked for, for every speed from rest to where it hardly flows any more.
#[test]
fn the_amplitude_makes_the_mean() {
    for full_wave in [true, false] {
        for time in [0.0, 1e-5, 1e-4, 4e-4] {
            for drop in [0.0, 1.4] {
                let conduction = Conduction::new(&carrier(full_wave, drop), time).unwrap();
                for emf in [0.0, 1e-6, 0.3, 2.5, 40.0] {
                    for mean in [1e-6, 1e-3, 0.2, 3.0, 100.0] {
                        let amplitude = conduction.amplitude(mean, emf);
                        let back = conduction.mean(amplitude, emf);
                        let off = (back - mean).abs();
                        assert!(
                            off < 1e-4 * (mean + emf + drop) && off < 0.02 * mean + 2e-6 * (emf + drop),
                            "{time} {drop} {emf} {mean}: {back}"
                        );
                    }
                }
            }
        }
    }
    let conduction = Conduction::new(&carrier(true, 1.4), 0.0).unwrap();
    for nothing in [(0.0, 1.0), (-1.0, 0.0), (f64::NAN, 0.0), (1.0, f64::NAN), (f64::INFINITY, 0.0)] {
        assert_eq!(conduction.amplitude(nothing.0, nothing.1), 0.0);
    }
    // A motor that is swung backward helps.
    assert!(conduction.amplitude(1.0, -9.0) > 0.0);
}

/// As a motor turns faster, the same amplitude holds it to a higher mean: what can be had at rest can be had at any speed.
#[test]
fn what_can_be_had_at_rest_can_be_had_at_speed() {
    for full_wave in [true, false] {
        for time in [0.0, 1e-4, 4e-4] {
            let conduction = Conduction::new(&carrier(full_wave, 0.7), time).unwrap();
            let most = conduction.mean(5.0, 0.0);
            for n in 0..100 {
                let emf = most * f64::from(n) / 100.0;
                assert!(emf + conduction.mean(5.0, emf) > most * (1.0 - 1e-12), "{full_wave} {time} {emf}");
                assert!(conduction.amplitude(most - emf, emf) < 5.0 * (1.0 + 1e-4));
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let field = |carrier: Carrier, time: f64| Conduction::new(&carrier, time).unwrap_err().field;
    assert_eq!(field(Carrier { hertz: 0.0, ..carrier(true, 0.0) }, 0.0), "carrier");
    assert_eq!(field(carrier(true, -0.1), 0.0), "diode_drop");
    assert_eq!(field(carrier(true, 0.0), f64::NAN), "inductance");
}

/// The root mean square that is looked up is that of the circuit itself, and the mean whose it is comes back: for every lag, and on both sides of where the current
/// begins never to cease.
#[test]
fn a_current_warms_as_that_of_the_circuit() {
    for full_wave in [true, false] {
        for lag in [0.0, 0.02, 0.25, 0.6, 2.0, 10.0] {
            let conduction = Conduction::new(&carrier(full_wave, 0.7), lag / TAU / 4000.0).unwrap();
            for share in [0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95] {
                let (mean, against) = (3.0 * share, 3.0 * (1.0 - share));
                let amplitude = conduction.amplitude(mean, against - 0.7);
                let (count, turns) = (4000, 4 + (8.0 * lag) as i32);
                let step = TAU / f64::from(count);
                let source = |n: i32| {
                    let x = (step * f64::from(n)).sin() * amplitude;
                    (if full_wave { x.abs() } else { x }) - against
                };
                let (mut current, mut sum) = (0.0_f64, 0.0);
                for n in 0..count * turns {
                    sum = if n == count * (turns - 1) { 0.0 } else { sum };
                    let (now, then) = (source(n % count), source(n % count + 1));
                    let half = 0.5 * step / lag.max(1e-9);
                    let next = if lag == 0.0 {
                        then
                    } else {
                        (current * (1.0 - half) + half * (now + then)) / (1.0 + half)
                    };
                    let next = next.max(0.0);
                    sum += (current * current + current * next + next * next) / 3.0 / f64::from(count);
                    current = next;
                }
                let is = conduction.root(mean, against - 0.7);
                assert!(
                    (is / sum.sqrt() - 1.0).abs() < 0.003,
                    "{full_wave} {lag} {share}: {is} {}",
                    sum.sqrt()
                );
            }
        }
    }
}
