//! Clicks from where the mass is known to hang: they stop it, gravity or no gravity.

use std::f64::consts::{PI, TAU};

use crate::shape::motors;
use crate::turner::{PARTS, RATE, plant, setup};
use pacinian::actuator::driver::book::Book;
use pacinian::actuator::driver::hanging::Hanging;
use pacinian::actuator::driver::homing::Homing;
use pacinian::actuator::driver::order::{Order, Pieces};
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::{GRAVITY, Motor, Parameters};
use pacinian::rig::{Actuator, Model, part};

/// What was sent to a motor, in parts of a sample, and its speed at the end of each.
fn run(turner: &mut Turner, plant: &mut Motor, seconds: f64) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    for _ in 0..(seconds * RATE) as usize {
        let mut parts = [0.0; PARTS];
        turner.step(0.0, &mut parts);
        for amount in parts {
            plant.drive(turner.setup().drive(amount));
            plant.step();
            all.push((amount, plant.speed()));
        }
    }
    all
}

/// The share of its peak speed that a click leaves when its drive ends: where it is not given backward any more and its coil is empty.
fn left(sent: &[(f64, f64)], coil: f64) -> f64 {
    // The first part of a drive may be less, as it begins anywhere.
    let (drive, _) = sent.iter().filter(|(amount, _)| *amount != 0.0).nth(1).unwrap();
    let (way, most) = (drive.signum(), drive.abs());
    let peak = sent.iter().fold(0.0_f64, |most, (_, speed)| most.max(speed.abs()));
    let back =
        sent.iter().position(|(amount, _)| way * amount < -0.999 * most).expect("it is driven backward");
    let over = back + sent[back..].iter().position(|(amount, _)| way * amount > -0.999 * most).unwrap();
    let end = over + (coil * std::f64::consts::LN_2 * RATE * PARTS as f64).ceil() as usize;
    sent[end].1.abs() / peak
}

/// A motor whose mass is known to hang there, and its model.
fn at(setup: &Setup, angle: f64) -> (Turner, Motor) {
    let mut turner = Turner::new(setup, 0).unwrap();
    // There is nothing to do on the way home: it is there.
    turner.order(0.0, 1, Order::Home(Pieces::default(), angle));
    (0..turner.late() + 8).for_each(|_| turner.step(0.0, &mut [0.0; PARTS]));
    assert!((turner.hangs().unwrap() - angle).abs() < 1e-9);
    (turner, plant(&setup.parameters, angle))
}

#[test]
fn a_click_from_a_known_place_has_stopped_when_its_drive_ends() {
    for (name, motor) in ["coin10", "cyl6", "gamepadL"].iter().zip(motors()) {
        for inductance in [0.0, motor.inductance, 0.1 * motor.resistance * motor.mechanical_time()] {
            let parameters = Parameters { inductance, gravity: GRAVITY, ..motor };
            let setup = Setup { parameters, ..setup(parameters, Shaping::Inverse) };
            for turns in [0.25, -0.25, 1.0] {
                let book = Book::new(&setup, turns).unwrap();
                let (mut most, mut flat, mut far) = (0.0_f64, 0.0_f64, 0.0_f64);
                for angle in (0..16).map(|n| TAU * (f64::from(n) + 0.37) / 16.0 - PI) {
                    for level in [1.0, 0.55, -0.8] {
                        let pieces = book.at(level).unwrap();
                        let due = turns * f64::signum(level);
                        let coil = parameters.electrical_time();
                        let (mut turner, mut plant) = at(&setup, angle);
                        turner.order(10.3, 1, Order::Turn(pieces, due));
                        let sent = run(&mut turner, &mut plant, 0.4);
                        most = most.max(left(&sent, coil));
                        let turned = (plant.turned() - angle) / TAU;
                        far = far.max((turned / due - 1.0).abs());
                        // A whole turn is too far to know it.
                        assert_eq!(turner.hangs().is_some(), turns.abs() < 1.0);
                        let off = turner.hangs().map_or(0.0, |hangs| hangs - plant.reading().angle);
                        assert!(off.sin().abs() < 0.01);
                        // The same, as if it lay flat.
                        let (mut turner, mut plant) = at(&setup, angle);
                        turner.order(10.3, 1, Order::Click(pieces));
                        flat = flat.max(left(&run(&mut turner, &mut plant, 0.4), coil));
                    }
                }
                println!(
                    "{name} L {inductance:.1e} {turns} turns: of the peak speed {:.3} % is left at most ({:.2} % as if it lay flat), {:.2} % off its way",
                    100.0 * most,
                    100.0 * flat,
                    100.0 * far
                );
                assert!(most < 0.005, "{name} {inductance} {turns}: {most}");
            }
        }
    }
}

/// As many clicks as it takes until it is not known any more; then they are what they are of a motor that lies flat.
#[test]
fn what_is_known_of_a_place_wears_off() {
    let [coin, ..] = motors()[..] else { panic!() };
    let setup =
        Setup { parameters: Parameters { gravity: GRAVITY, ..coin }, ..setup(coin, Shaping::Inverse) };
    let pieces = Book::new(&setup, 0.25).unwrap().strongest();
    let run_of = |order: &dyn Fn(u32) -> Order, clicks: u32| {
        let (mut turner, mut plant) = at(&setup, 1.0);
        let mut all = Vec::new();
        for n in 0..clicks {
            turner.order(8.0 + f64::from(n) * 0.1 * RATE, 1, order(n));
            all.push((turner.hangs().is_some(), run(&mut turner, &mut plant, 0.1)));
        }
        all
    };
    // One way: 10 % of how far it is from home and 3 % of its way are 30 degrees after 2.6 clicks.
    let one_way = run_of(&|_| Order::Turn(pieces, 0.25), 12);
    assert_eq!(one_way.iter().position(|(known, _)| !known), Some(3));
    let fresh = {
        let mut turner = Turner::new(&setup, 0).unwrap();
        (0..turner.late() + 8).for_each(|_| turner.step(0.0, &mut [0.0; PARTS]));
        turner.order(8.0, 1, Order::Click(pieces));
        run(&mut turner, &mut plant(&setup.parameters, 1.0), 0.1)
    };
    let backward = |sent: &[(f64, f64)]| sent.iter().filter(|(amount, _)| *amount == -setup.limit).count();
    assert_eq!(backward(&one_way[8].1), backward(&fresh));
    assert_ne!(backward(&one_way[1].1), backward(&fresh));
    // Forth and back it lasts: 30 degrees are 3 % of 11.1 quarters of a turn, and less by what it is from home.
    let to_and_fro = run_of(&|n| Order::Turn(pieces, if n % 2 == 0 { 0.25 } else { -0.25 }), 30);
    let lasts = to_and_fro.iter().position(|(known, _)| !known).unwrap();
    assert!((8..=11).contains(&lasts), "{lasts}");
}

/// Of a motor of which a figure is 5 % off, it hangs no farther from where its model has it than is reckoned with.
#[test]
fn figures_that_are_off_lead_no_farther_astray_than_is_reckoned() {
    for motor in motors() {
        let model = Parameters { gravity: GRAVITY, ..motor };
        let setup = Setup { parameters: model, ..setup(motor, Shaping::Inverse) };
        let book = Book::new(&setup, 0.25).unwrap();
        let clicks = [book.strongest(), book.at(0.5).unwrap()];
        for (figure, by) in (0..4).flat_map(|figure| [(figure, 1.05), (figure, 0.95)]) {
            let of = |which: u32| if which == figure { by } else { 1.0 };
            let real = Parameters {
                resistance: of(0) * model.resistance,
                gain: of(1) * model.gain,
                inertia: of(2) * model.inertia,
                coulomb: of(3) * model.coulomb,
                stiction: of(3) * model.stiction,
                viscous: of(3) * model.viscous,
                ..model
            };
            for fro in [-0.25, 0.25] {
                let (mut turner, _) = at(&setup, 1.0);
                let mut plant = plant(&real, 1.0);
                let mut reckoned = Hanging::at(1.0);
                for n in 0..8 {
                    let turns = if n % 2 == 0 { 0.25 } else { fro };
                    turner.order(
                        8.0 + f64::from(n) * 0.2 * RATE,
                        1,
                        Order::Turn(clicks[n as usize % 2], turns),
                    );
                    run(&mut turner, &mut plant, 0.2);
                    reckoned.turned(TAU * turns);
                    let Some(hangs) = turner.hangs() else { break };
                    let off = ((plant.turned() - hangs + PI).rem_euclid(TAU) - PI).abs();
                    assert!(off < reckoned.doubt(), "{figure} {by} {fro} {n}: {off} {}", reckoned.doubt());
                }
            }
        }
    }
}

/// What is braked half way, and what is turned by levels: its model knows where it hangs then, and the next click stops it all the same. A way home that is
/// cut short is none.
#[test]
fn what_comes_between_is_known_too() {
    let [coin, ..] = motors()[..] else { panic!() };
    let parameters = Parameters { gravity: GRAVITY, ..coin };
    let setup = Setup { parameters, ..setup(coin, Shaping::Overdrive) };
    let pieces = Book::new(&setup, 0.25).unwrap().strongest();
    for (between, levels) in
        [(Order::Turn(pieces, 0.25), 0.0), (Order::Spin(300.0), 0.0), (Order::Brake, 0.1)]
    {
        let (mut turner, mut plant) = at(&setup, 2.0);
        turner.order(8.0, 1, between);
        turner.order(8.0 + 0.004 * RATE, 1, Order::Brake);
        let mut parts = [0.0; PARTS];
        for n in 0..1600 {
            turner.step(if (400..480).contains(&n) { levels } else { 0.0 }, &mut parts);
            for amount in parts {
                plant.drive(setup.drive(amount));
                plant.step();
            }
        }
        assert!(turner.hangs().is_some() && (plant.turned() - 2.0).abs() > 0.1, "{between:?}");
        turner.order(8.0 + 0.25 * RATE, 1, Order::Turn(pieces, 0.25));
        let left = left(&run(&mut turner, &mut plant, 0.3), parameters.electrical_time());
        assert!(left < 0.005, "{between:?}: {left}");
    }
    let way = Homing::new(&setup).unwrap();
    for (what, interrupted) in
        [(None, false), (Some(Order::Brake), true), (Some(Order::Turn(pieces, 0.25)), true)]
    {
        let mut turner = Turner::new(&setup, 0).unwrap();
        turner.order(0.0, 1, Order::Home(way.pieces, way.angle));
        if let Some(order) = what {
            turner.order(0.5 * way.seconds() * RATE, 1, order);
        }
        (0..RATE as usize).for_each(|_| turner.step(0.0, &mut [0.0; PARTS]));
        assert_eq!(turner.hangs().is_none(), interrupted, "{what:?}");
    }
    // Nor is one during which it was to stand at once.
    let mut turner = Turner::new(&setup, 0).unwrap();
    turner.order(0.0, 1, Order::Home(way.pieces, way.angle));
    for n in 0..RATE as usize {
        turner.halt((1000..1040).contains(&n), false);
        turner.step(0.0, &mut [0.0; PARTS]);
    }
    assert_eq!(turner.hangs(), None);
}

/// Sent home again after each rest, every click of a row begins at the same place, wherever the mass hung at first and however strong the clicks are;
/// left where they end, they would not.
#[test]
fn a_parked_mass_begins_every_click_at_home() {
    for motor in motors() {
        let parameters = Parameters { gravity: GRAVITY, ..motor };
        let flat = Setup { parameters, ..setup(motor, Shaping::Inverse) };
        let way = Homing::new(&flat).unwrap();
        let book = Book::new(&flat, 0.25).unwrap();
        // Long enough to come to rest, to be sent home and to rest there.
        let pause = 0.6 + 0.1 + way.seconds() + 0.6;
        for level in [1.0, 0.5, 0.1] {
            let pieces = book.at(level).unwrap();
            let run_with = |park: Option<f64>, angle: f64| {
                let setup = Setup { park, ..flat };
                let (mut turner, mut plant) = (Turner::new(&setup, 0).unwrap(), plant(&parameters, angle));
                turner.order(8.0, 1, Order::Home(way.pieces, way.angle));
                run(&mut turner, &mut plant, pause);
                let mut most = 0.0_f64;
                for n in 0..8 {
                    most = most.max(((plant.turned() - way.angle + PI).rem_euclid(TAU) - PI).abs());
                    turner.order(8.0 + (1.0 + f64::from(n)) * pause * RATE, 1, Order::Turn(pieces, 0.25));
                    run(&mut turner, &mut plant, pause);
                }
                (most, turner.is_idle())
            };
            for angle in [-2.9, -1.1, 0.2, 2.2] {
                let (parked, idle) = run_with(Some(0.1), angle);
                assert!(
                    parked < way.spread + 0.02 && idle,
                    "{level} from {angle}: {parked} of {}, {idle}",
                    way.spread
                );
            }
            let (left, _) = run_with(None, 0.2);
            assert!(left > 1.5, "{level}: {left}");
        }
    }
}

/// A mass that friction does not hold swings down after every drive. When it is said to be home it is there and at rest, wherever it was before; a click from there
/// stops it, and where it swings to then is known as well.
#[test]
fn a_mass_that_gravity_moves_is_home_when_it_rests() {
    let [coin, ..] = motors()[..] else { panic!() };
    for share in [0.2, 0.05, 0.0] {
        let heavy = Parameters { gravity: GRAVITY, ..coin };
        let parameters =
            Parameters { coulomb: 0.8 * share * heavy.weight(), stiction: share * heavy.weight(), ..heavy };
        let setup = Setup { parameters, ..setup(parameters, Shaping::Inverse) };
        let way = Homing::new(&setup).unwrap();
        let pieces = Book::new(&setup, 0.25).unwrap().strongest();
        for begin in [-2.9, -1.3, 0.4, 1.9, 3.1] {
            let (mut turner, mut plant) = (Turner::new(&setup, 0).unwrap(), plant(&parameters, begin));
            turner.order(8.0, 1, Order::Home(way.pieces, way.angle));
            let mut waited = 0.0;
            while turner.hangs().is_none() {
                run(&mut turner, &mut plant, 0.001);
                waited += 0.001;
                assert!(waited < way.seconds() + 1.0, "{share} from {begin}");
            }
            let off = |turner: &Turner, plant: &Motor| {
                let hangs = turner.hangs().unwrap();
                ((plant.turned() - hangs + PI).rem_euclid(TAU) - PI).abs()
            };
            assert!(off(&turner, &plant) < way.spread + 0.005, "{share} from {begin}");
            assert!(plant.speed().abs() < 0.2, "{share} from {begin}: {} rad/s", plant.speed());
            run(&mut turner, &mut plant, 2.0);
            assert!(off(&turner, &plant) < way.spread + 0.005, "{share} from {begin}, later");
            turner.order((waited + 2.1) * RATE, 1, Order::Turn(pieces, 0.25));
            let sent = run(&mut turner, &mut plant, 0.5);
            let left = left(&sent, parameters.electrical_time());
            assert!(left < 0.005, "{share} from {begin}: {left}");
            run(&mut turner, &mut plant, 2.0);
            assert!(off(&turner, &plant) < 0.02, "{share} from {begin}: where the click left it");
        }
    }
}

/// Every motor that ships is brought home to within what is said, from wherever it hung, and where a figure is 5 % off is said to be as far off as it is. Where a motor
/// is as it is said to be, a click leaves less than 4 % of its peak speed, from where it really hangs then.
#[test]
fn motors_that_ship_are_as_certainly_home_as_is_said() {
    let mut tried = 0;
    for part in part::all().iter().filter(|part| part.model == Model::RumbleMotor) {
        let Ok(motor) = Actuator::of_part(part).rumble_motor() else { continue };
        let parameters = Parameters { gravity: GRAVITY, ..motor };
        let setup = Setup { parameters, ..setup(parameters, Shaping::Inverse) };
        let setup = Setup { limit: motor.rated_volts.max(1.5 * parameters.start_volts()), ..setup };
        let way = Homing::new(&setup).unwrap();
        let pieces = Book::new(&setup, 0.25).unwrap().strongest();
        let (mut worst, mut most) = ([0.0_f64; 2], 0.0_f64);
        for (figure, by) in
            [(4, 1.0), (0, 0.95), (0, 1.05), (1, 0.95), (1, 1.05), (2, 0.95), (2, 1.05), (3, 0.95), (3, 1.05)]
        {
            let of = |which: u32| if which == figure { by } else { 1.0 };
            let real = Parameters {
                resistance: of(0) * parameters.resistance,
                gain: of(1) * parameters.gain,
                inertia: of(2) * parameters.inertia,
                coulomb: of(3) * parameters.coulomb,
                stiction: of(3) * parameters.stiction,
                viscous: of(3) * parameters.viscous,
                ..parameters
            };
            for begin in (0..7).map(|n| TAU * (f64::from(n) + 0.4) / 7.0) {
                let (mut turner, mut plant) = (Turner::new(&setup, 0).unwrap(), plant(&real, begin));
                turner.order(8.0, 1, Order::Home(way.pieces, way.angle));
                run(&mut turner, &mut plant, way.seconds() + 0.5);
                assert!(turner.hangs().is_some(), "{}", part.name);
                let off = ((plant.turned() - way.angle + PI).rem_euclid(TAU) - PI).abs();
                let which = usize::from(by != 1.0);
                worst[which] = worst[which].max(off);
                if by == 1.0 {
                    turner.order(8.0 + (way.seconds() + 0.6) * RATE, 1, Order::Turn(pieces, 0.25));
                    most = most.max(left(&run(&mut turner, &mut plant, 0.5), real.electrical_time()));
                }
            }
        }
        tried += 1;
        println!(
            "{}: home at {:.0} within {:.1} degrees ({:.1} told), {:.0} ({:.0}) with a figure 5 % off, in {:.2} s; a click there leaves {:.2} %",
            part.name,
            way.angle.to_degrees(),
            worst[0].to_degrees(),
            way.spread.to_degrees(),
            worst[1].to_degrees(),
            way.astray.to_degrees(),
            way.seconds(),
            100.0 * most
        );
        assert!(worst[0] < 1.1 * way.spread + 0.02 && way.spread < 0.5, "{}", part.name);
        assert!(way.astray >= way.spread && worst[1] < 1.3 * way.astray + 0.1, "{}", part.name);
        assert!(most < 0.04, "{}: {most}", part.name);
    }
    assert!(tried >= 7, "{tried}");
}
