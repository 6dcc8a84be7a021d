//! Motors that are turned while they are played: levels and orders, sample by sample, on the motors that they are for.

use std::f64::consts::PI;

use pacinian::actuator::drive::Drive;
use pacinian::actuator::driver::book::Book;
use pacinian::actuator::driver::order::Order;
use pacinian::actuator::driver::setup::{Setup, Shaping, Stage};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::{self, Casing, Level, Motor, Parameters, Plan};
use pacinian::actuator::shape::{Spin, Unreachable};

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
        stage: Stage::default(),
        park: None,
        look_ahead: None,
        ordered: true,
        rate: RATE,
    }
}

/// A small cylinder, the third kind beside coin and pad.
pub fn cylinder() -> Parameters {
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
    turner.brake(0);
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
