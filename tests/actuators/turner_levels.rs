//! Levels that a motor is turned by: followed, forgotten after a silence, and within the limit.

use crate::common::{COIN, PAD};
use crate::turner::{PARTS, RATE, cylinder, plant, play, raised_cosine, setup};
use pacinian::actuator::driver::order::{Order, Pieces};
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::{self, Casing, Parameters};
use pacinian::actuator::shape::Inverse;

/// The envelope as a whole, shaped by the inverse that knows all of it, is the exact twin: whatever is feasible, and whatever is not.
#[test]
fn levels_become_what_the_inverse_of_the_whole_envelope_gives() {
    for (parameters, seconds) in [(COIN, 0.15), (COIN, 0.04), (PAD, 0.15), (PAD, 0.02), (cylinder(), 0.03)] {
        let setup = Setup { ordered: false, ..setup(parameters, Shaping::Inverse) };
        let mut turner = Turner::new(&setup, 0).unwrap();
        let mut levels = vec![0.0; 37];
        levels.extend(raised_cosine(1.0, seconds));
        levels.extend(raised_cosine(-0.4, seconds));
        levels.extend(vec![0.3; 500]);
        levels.extend(vec![0.0; 4000]);
        let speeds: Vec<f64> = levels.iter().map(|level| setup.speed_of(*level)).collect();
        let inverse = Inverse { parameters: setup.parameters, limit: setup.limit, rate: RATE, angle: None };
        let whole = inverse.shape(&speeds).unwrap();
        let mut sent = Vec::new();
        for level in &levels {
            let mut part = [0.0];
            turner.step(*level, &mut part);
            sent.push(part[0]);
        }
        let late = turner.late();
        assert!(whole.limited > 0 && sent[..late].iter().all(|volts| *volts == 0.0));
        for (n, (streamed, known)) in sent[late..].iter().zip(&whole.volts).enumerate() {
            assert!((streamed - known).abs() < 1e-9, "{seconds} s: sample {n}: {streamed} {known}");
        }
        assert!(turner.is_idle() && turner.counts().limited > 0);
    }
}

/// What was played long ago is forgotten, however long the silence was: each of two envelopes is sent as if it were alone.
#[test]
fn nothing_comes_back_after_a_silence() {
    for shaping in [Shaping::Inverse, Shaping::Plain] {
        let setup = Setup { ordered: false, ..setup(PAD, shaping) };
        let envelope = raised_cosine(1.0, 0.03);
        let mut alone = Turner::new(&setup, 0).unwrap();
        let sent = |turner: &mut Turner, level: f64| {
            let mut part = [0.0];
            turner.step(level, &mut part);
            part[0]
        };
        let tail = alone.late() + 40;
        let wanted: Vec<f64> =
            envelope.iter().copied().chain(vec![0.0; tail]).map(|level| sent(&mut alone, level)).collect();
        for silence in (60..400).step_by(16).map(|n| n + tail - tail % 16) {
            let mut turner = Turner::new(&setup, 0).unwrap();
            for level in envelope.iter().copied().chain(vec![0.0; silence + 16 - envelope.len() % 16]) {
                sent(&mut turner, level);
            }
            let again = envelope.iter().copied().chain(vec![0.0; tail]);
            for (n, (level, wanted)) in again.zip(&wanted).enumerate() {
                let got = sent(&mut turner, level);
                assert!(
                    (got - wanted).abs() < 1e-9,
                    "{shaping:?} after {silence}: sample {n}: {got} {wanted}"
                );
            }
        }
    }
}

/// 8 m/s² as a raised cosine of 150 ms on a coin motor with inductance and gravity, turned at 8 kHz: the acceleration amplitude follows within
/// 1 % of its peak (root mean square), where the voltage that holds the speed misses it by a quarter and more.
#[test]
fn envelopes_are_followed() {
    let real = Parameters { gravity: motor::GRAVITY, ..COIN };
    let miss = |shaping: Shaping| {
        let setup = setup(COIN, shaping);
        let mut turner = Turner::new(&setup, 0).unwrap();
        let peak = 8.0 / COIN.rated_acceleration().unwrap();
        let mut levels = raised_cosine(peak, 0.15);
        let wished = levels.clone();
        levels.extend(vec![0.0; 2400]);
        let (_, speeds) = play(&mut turner, &mut plant(&real, 0.0), &levels);
        let late = turner.late();
        let (mut sum, mut count) = (0.0, 0);
        for (n, wish) in wished.iter().enumerate().skip(1) {
            let speed = speeds[(n + late) * PARTS - 1];
            let got = speed * speed / (setup.full_speed() * setup.full_speed());
            (sum, count) = (sum + ((got - wish) / peak).powi(2), count + 1);
        }
        (sum / f64::from(count)).sqrt()
    };
    let [inverse, overdrive, plain] = [Shaping::Inverse, Shaping::Overdrive, Shaping::Plain].map(miss);
    assert!(inverse < 0.01, "inverse {inverse}");
    assert!(overdrive < 0.02, "overdrive {overdrive}");
    assert!(plain > 0.25, "plain {plain}");
}

/// Whatever comes in, what goes out is a number within the limit, on motors far from any that there are.
#[test]
fn nothing_leaves_beyond_the_limit() {
    let hostile = [f64::NAN, f64::INFINITY, -1e300, 1e-320, 3.0, -0.2, 0.0, 1.0];
    for (inductance, inertia, friction) in [
        (0.0, 1e-12, 0.0),
        (3e-1, 1.8e-9, 0.0),
        (1e-3, 1.8e-6, 1e-5),
        (1e-9, 1.8e-9, 2e-5),
        (0.3e-3, 1e-3, 0.0),
    ] {
        let parameters = Parameters {
            inductance,
            inertia,
            coulomb: friction,
            stiction: friction,
            casing: Casing::Held,
            ..COIN
        };
        for shaping in [Shaping::Inverse, Shaping::Overdrive, Shaping::Switching, Shaping::Plain] {
            for rate in [100.0, 8000.0, 1e6] {
                let setup = Setup { rate, look_ahead: Some(0.01), ..setup(parameters, shaping) };
                let mut turner = Turner::new(&setup, 3).unwrap();
                for n in 0..3000_usize {
                    if n % 7 == 0 {
                        let level = hostile[n / 7 % hostile.len()];
                        let pieces = Pieces { list: [(level, level), (0.001, -1e9), (f64::NAN, 2.0)] };
                        let order = [
                            Order::Spin(level),
                            Order::On(level.into()),
                            Order::Click(pieces),
                            Order::Release,
                            Order::Brake,
                        ];
                        turner.order(n as f64 + level, 1, order[n % 5]);
                    }
                    let mut parts = [0.0; 3];
                    turner.step(hostile[n % hostile.len()], &mut parts);
                    assert!(
                        parts.iter().all(|volts| volts.abs() <= setup.limit * (1.0 + 1e-12)),
                        "{shaping:?} {n}: {parts:?}"
                    );
                }
                assert!(turner.counts().masked > 0);
                let motor = turner.motor().unwrap();
                assert!(motor.speed().is_finite() && motor.current().is_finite());
            }
        }
    }
}
