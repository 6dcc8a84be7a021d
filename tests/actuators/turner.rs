//! Motors that are turned while they are played: levels and orders, sample by sample, on the motors that they are for.

use std::f64::consts::PI;

use pacinian::actuator::drive::Drive;
use pacinian::actuator::driver::book::Book;
use pacinian::actuator::driver::order::{Order, Pieces, WAITING};
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::{self, Casing, Level, Motor, Parameters, Plan};
use pacinian::actuator::shape::{Inverse, Spin, Unreachable};

use crate::common::{COIN, PAD};

/// Samples a second of the turner, and parts of a sample that are sent.
pub const RATE: f64 = 8000.0;
pub const PARTS: usize = 6;

pub fn setup(parameters: Parameters, shaping: Shaping) -> Setup {
    let limit = parameters.rated_volts;
    let gravity = 0.0;
    Setup {
        parameters: Parameters { gravity, ..parameters },
        imposes: Drive::Voltage,
        one_way: false,
        diode_drop: 0.0,
        half_wave: false,
        limit,
        compliance: limit,
        shaping,
        look_ahead: None,
        ordered: true,
        rate: RATE,
    }
}

/// A small cylinder, the third kind beside coin and pad.
fn cylinder() -> Parameters {
    Parameters {
        resistance: 10.5,
        inductance: 1.05e-4,
        gain: 0.62e-3,
        inertia: 7.5e-10,
        viscous: 4e-9,
        coulomb: 6e-6,
        stiction: 8e-6,
        eccentric: 2.6e-7,
        gravity: 0.0,
        casing: Casing::Free { mass: 0.08 },
        rated_volts: 1.3,
    }
}

/// A real motor: as fine as can be, with inductance, and gravity where it has any.
pub fn plant(parameters: &Parameters, angle: f64) -> Motor {
    let mut motor = Motor::new(parameters, &Plan::whole(Level::Fine), RATE * PARTS as f64).unwrap();
    motor.place(angle, 0.0);
    motor
}

/// What is sent for levels, and the speeds of a real motor under it, at the end of each part of a sample.
pub fn play(turner: &mut Turner, plant: &mut Motor, levels: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut sent, mut speeds) = (Vec::new(), Vec::new());
    for level in levels {
        let mut parts = [0.0; PARTS];
        turner.step(*level, &mut parts);
        for amount in parts {
            plant.drive(turner.setup().drive(amount));
            plant.step();
            sent.push(amount);
            speeds.push(plant.speed());
        }
    }
    (sent, speeds)
}

pub fn raised_cosine(height: f64, seconds: f64) -> Vec<f64> {
    let count = (seconds * RATE) as usize;
    (0..=count).map(|n| 0.5 * height * (1.0 - (2.0 * PI * n as f64 / count as f64).cos())).collect()
}

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

fn ordered(
    turner: &mut Turner,
    plant: &mut Motor,
    orders: &[(f64, u64, Order)],
    samples: usize,
) -> (Vec<f64>, Vec<f64>) {
    for (at, voice, order) in orders {
        turner.order(at * RATE, *voice, *order);
    }
    play(turner, plant, &vec![0.0; samples])
}

/// Of every level, also those between the ones that were worked out: by the time the drive is over, the rotor of a real motor is.
#[test]
fn clicks_of_every_level_end_at_rest() {
    for parameters in [COIN, PAD, cylinder()] {
        for inductance in [0.0, parameters.inductance] {
            let parameters = Parameters { inductance, gravity: 0.0, ..parameters };
            let volts = setup(parameters, Shaping::Inverse);
            let amperes = Setup {
                imposes: Drive::Current,
                limit: 0.8 * volts.limit / parameters.resistance,
                compliance: 2.0 * volts.limit,
                ..volts
            };
            for (setup, turns) in [(volts, 0.25), (volts, -1.0), (amperes, 0.25), (amperes, -1.0)] {
                let book = Book::new(&setup, turns).unwrap();
                let mut strongest = 0.0;
                for level in [1.0, 0.83, 0.5, 0.31, 0.11, -0.4] {
                    let click = book.at(level).unwrap();
                    let length: f64 = click.list.iter().map(|piece| piece.0).sum();
                    let mut turner = Turner::new(&setup, 0).unwrap();
                    let mut plant = plant(&parameters, 0.0);
                    // It begins between two samples, and its switches fall anywhere.
                    let at = 0.003_137;
                    let over = at + length + turner.late() as f64 / RATE;
                    let samples = (over * RATE).ceil() as usize;
                    let (_, speeds) =
                        ordered(&mut turner, &mut plant, &[(at, 1, Order::Click(click))], samples);
                    let peak = speeds.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
                    let left = speeds.last().unwrap().abs() / peak;
                    assert!(left < 0.005, "{turns} turns at {level}: {left}");
                    assert!(speeds.iter().sum::<f64>() * turns * level > 0.0);
                    // As strong as the level says.
                    let steps =
                        speeds.windows(2).map(|w| (w[1] * w[1]).hypot((w[1] - w[0]) * RATE * PARTS as f64));
                    let strength = steps.fold(0.0, f64::max);
                    if level == 1.0 {
                        strongest = strength;
                    }
                    let (got, wanted) = (strength / strongest, level.abs().max(book.weakest()));
                    assert!((got - wanted).abs() < 0.03, "{level}: {got} {wanted}");
                    assert!(
                        (plant.reading().angle / std::f64::consts::TAU + plant.reading().turns).abs()
                            > 0.9 * turns.abs()
                    );
                }
            }
        }
    }
}

/// With no inductance: up to the speed in τ ln(ω∞/(ω∞ − ω)), down in τ ln(1 + ω/ω_b), each to the sample; with it, as the solver of spins has it.
#[test]
fn spins_rise_and_stop_as_fast_as_the_drive_allows() {
    for parameters in [COIN, PAD, cylinder()] {
        for inductance in [0.0, parameters.inductance] {
            let parameters = Parameters { inductance, gravity: 0.0, ..parameters };
            let setup = setup(parameters, Shaping::Inverse);
            let speed = 0.5 * setup.full_speed();
            let mut turner = Turner::new(&setup, 0).unwrap();
            let late = turner.late() as f64 / RATE;
            let orders = [(0.0, 7, Order::Spin(speed)), (0.1, 8, Order::Release), (0.2, 7, Order::Release)];
            let (sent, speeds) =
                ordered(&mut turner, &mut plant(&parameters, 0.0), &orders, ((0.4 + late) * RATE) as usize);
            let part = RATE * PARTS as f64;
            let first = |from: f64, of: &dyn Fn(f64) -> bool| {
                let from = ((from + late) * part) as usize;
                speeds[from..].iter().position(|speed| of(*speed)).unwrap() as f64 / part
            };
            let spin =
                Spin { speed, seconds: 0.2, volts: setup.limit, angle: 0.0 }.solve(&parameters).unwrap();
            let pieces = spin.pieces();
            let rise = first(0.0, &|now| now >= 0.999 * speed);
            // A coil needs some of its own time constants more, to end without running past the speed.
            let coil = 4.0 * parameters.electrical_time();
            assert!((rise - pieces[0].0).abs() < coil + 2.0 / RATE, "{rise} {:?}", pieces[0]);
            let fall = first(0.2, &|now| now < 0.01 * speed);
            let brake = pieces[2].0 - pieces[1].0;
            assert!(fall < brake + 2.0 / RATE + coil, "{fall} {brake}");
            if inductance == 0.0 {
                let top = parameters.steady_speed(setup.limit);
                let tau = parameters.mechanical_time();
                assert!((rise - tau * (top / (top - 0.999 * speed)).ln()).abs() < 2.0 / RATE, "{rise}");
                let back = (parameters.stall_torque(setup.limit) + parameters.coulomb) / parameters.damping();
                assert!(
                    (fall - tau * ((back + speed) / (back + 0.01 * speed)).ln()).abs() < 2.0 / RATE,
                    "{fall}"
                );
            }
            // Held in between, and no swing back behind it.
            let held = &speeds[((0.1 + late) * part) as usize..((0.2 + late) * part) as usize];
            assert!(held.iter().all(|now| (now / speed - 1.0).abs() < 1e-3));
            let behind =
                speeds[((0.2 + late) * part) as usize..].iter().fold(0.0_f64, |least, now| least.min(*now));
            assert!(behind > -0.005 * speed, "{}", behind / speed);
            assert!(sent.iter().rev().take(100).all(|volts| *volts == 0.0) && turner.is_idle());
        }
    }
}

#[test]
fn the_newest_order_holds_and_what_was_under_way_is_braked() {
    let parameters = Parameters { gravity: 0.0, ..COIN };
    let setup = setup(parameters, Shaping::Inverse);
    let click = Book::new(&setup, 0.25).unwrap().at(1.0).unwrap();
    let mut turner = Turner::new(&setup, 0).unwrap();
    let late = turner.late() as f64 / RATE;
    let speed = setup.full_speed() * 0.8;
    // The release of a voice whose order no longer holds changes nothing.
    let orders = [(0.0, 1, Order::Spin(speed)), (0.15, 2, Order::Click(click)), (0.151, 1, Order::Release)];
    let mut plant = plant(&parameters, 0.0);
    let (sent, speeds) = ordered(&mut turner, &mut plant, &orders, ((0.4 + late) * RATE) as usize);
    let part = RATE * PARTS as f64;
    let from = ((0.15 + late) * part) as usize;
    assert!((speeds[from - 10] / speed - 1.0).abs() < 0.01);
    assert_eq!(sent[from + PARTS], -setup.limit);
    // It comes to rest, and then kicks as from rest.
    let rests = from + speeds[from..].iter().position(|now| now.abs() < 2.0).unwrap();
    let peak = speeds[rests..].iter().fold(0.0_f64, |most, now| most.max(*now));
    let mut alone = Turner::new(&setup, 0).unwrap();
    let mut other = super::turner::plant(&parameters, 0.0);
    let (_, fresh) = ordered(&mut alone, &mut other, &[(0.0, 1, Order::Click(click))], 2000);
    let wanted = fresh.iter().fold(0.0_f64, |most, now| most.max(*now));
    assert!((peak / wanted - 1.0).abs() < 0.02, "{peak} {wanted}");
    assert!(speeds.last().unwrap().abs() < 1e-3 * speed && turner.is_idle());
    // A brake forgets what waits.
    turner.order(3500.0, 3, Order::Spin(speed));
    turner.brake();
    let (sent, _) = play(&mut turner, &mut plant, &[0.0; 4000]);
    assert!(sent.iter().all(|volts| *volts == 0.0));
}

#[test]
fn levels_go_on_where_an_order_has_left_the_motor() {
    let parameters = Parameters { gravity: 0.0, ..COIN };
    let setup = setup(parameters, Shaping::Inverse);
    let click = Book::new(&setup, 0.25).unwrap().at(1.0).unwrap();
    let mut turner = Turner::new(&setup, 0).unwrap();
    turner.order(0.1 * RATE, 1, Order::Click(click));
    let (_, speeds) = play(&mut turner, &mut plant(&parameters, 0.0), &vec![0.25; 4000]);
    let (before, after) = (speeds[(0.1 * RATE) as usize * PARTS], speeds.last().unwrap());
    let wanted = 0.5 * setup.full_speed();
    assert!(
        (before / wanted - 1.0).abs() < 1e-3 && (after / wanted - 1.0).abs() < 1e-3,
        "{before} {after} {wanted}"
    );
}

/// A current source: what holds a speed is its friction, and nothing means open terminals.
#[test]
fn a_current_turns_it_too() {
    let parameters = Parameters { gravity: 0.0, ..COIN };
    let amperes = setup(parameters, Shaping::Inverse);
    let current = Setup { imposes: Drive::Current, limit: 0.1, compliance: 5.0, ..amperes };
    let mut turner = Turner::new(&current, 0).unwrap();
    let mut levels = raised_cosine(0.3, 0.2);
    let count = levels.len();
    levels.extend(vec![0.0; 800]);
    let mut real = Motor::<false>::new(&parameters, &Plan::whole(Level::Fine), RATE).unwrap();
    let (late, mut worst) = (turner.late(), 0.0_f64);
    for n in 0..levels.len() {
        let mut part = [0.0];
        turner.step(levels[n], &mut part);
        assert!(part[0].abs() <= 0.1);
        real.drive(motor::Drive::Current { amperes: part[0], limit: 5.0 });
        real.step();
        if n + 1 > late && n + 1 - late < count {
            let wished = current.speed_of(levels[n + 1 - late]);
            worst = worst.max((real.speed() - wished).abs() / current.full_speed());
        }
    }
    assert!(worst < 0.005, "{worst}");
    let weak = Setup { limit: 1e-3, ..current };
    let told = Book::new(&weak, 0.25).unwrap_err().to_string();
    assert!(told.starts_with("0.001 A do not start the motor; from wherever"), "{told}");
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
                            Order::On(level),
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

#[test]
fn orders_that_find_no_room_are_counted_and_a_brake_finds_some() {
    let mut turner = Turner::new(&setup(COIN, Shaping::Inverse), 0).unwrap();
    for n in 0..WAITING + 3 {
        turner.order(100.0 + n as f64, n as u64, Order::Spin(10.0));
    }
    turner.order(1000.0, 0, Order::Brake);
    assert_eq!(turner.counts().dropped, 4);
    let mut plant = plant(&COIN, 0.0);
    play(&mut turner, &mut plant, &vec![0.0; 4000]);
    assert!(turner.is_idle(), "the brake held");
}

#[test]
fn what_cannot_be_is_refused() {
    let fine = setup(COIN, Shaping::Inverse);
    let field = |setup: Setup| Turner::new(&setup, 0).unwrap_err().field;
    assert_eq!(field(Setup { limit: 0.0, ..fine }), "limit");
    assert_eq!(field(Setup { rate: f64::NAN, ..fine }), "rate");
    assert_eq!(field(Setup { look_ahead: Some(2.0), ..fine }), "look_ahead");
    assert_eq!(field(Setup { compliance: 0.0, ..fine }), "compliance");
    assert_eq!(field(Setup { parameters: Parameters { inertia: 0.0, ..COIN }, ..fine }), "inertia");
    assert!(matches!(Book::new(&Setup { limit: 0.1, ..fine }, 0.25), Err(Unreachable::Start(..))));
    assert!(matches!(Book::new(&fine, f64::NAN), Err(Unreachable::Fault(_))));
}

/// However many orders wait, a voice that is let go of is let go of: the motor stands in the end.
#[test]
fn a_release_always_finds_room() {
    // All that wait begin something; half of them end it; all of them are brakes.
    for kind in 0..3 {
        let setup = setup(COIN, Shaping::Inverse);
        let mut turner = Turner::new(&setup, 0).unwrap();
        let mut plant = plant(&COIN, 0.0);
        turner.order(0.0, 1, Order::Spin(setup.full_speed()));
        play(&mut turner, &mut plant, &vec![0.0; 250]);
        for n in 0..WAITING as u64 {
            let at = 400.0 + n as f64;
            match (kind, n % 2) {
                (0, _) | (1, 0) => turner.order(at, 1000 + n, Order::On(0.1)),
                (1, _) => turner.order(at, 1000 + n - 1, Order::Release),
                _ => turner.order(at, 1000 + n, Order::Brake),
            }
        }
        turner.order(500.0, 1, Order::Release);
        (0..WAITING as u64).for_each(|n| turner.order(600.0, 1000 + n, Order::Release));
        play(&mut turner, &mut plant, &vec![0.0; 8000]);
        assert!(turner.is_idle() && turner.counts().dropped > 0, "{kind}: {:?}", turner.counts());
    }
}

/// A release of whoever has no order under way is nothing: levels go on to the bit.
#[test]
fn a_release_of_another_voice_changes_nothing() {
    let setup = setup(PAD, Shaping::Inverse);
    let levels: Vec<f64> = raised_cosine(0.8, 0.2);
    let sent = |releases: bool| {
        let mut turner = Turner::new(&setup, 0).unwrap();
        if releases {
            (0..20).for_each(|n| turner.order(50.0 * f64::from(n) + 0.3, 7, Order::Release));
        }
        play(&mut turner, &mut plant(&PAD, 0.0), &levels).0
    };
    assert!(sent(true) == sent(false));
}
