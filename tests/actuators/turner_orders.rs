//! What orders do between levels, and levels between orders: sample by sample.

use pacinian::actuator::driver::order::{AT_ONCE, Order, WAITING};
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::Parameters;

use crate::common::{COIN, PAD};
use crate::turner::{PARTS, RATE, plant, play, raised_cosine, setup};

/// What is sent for levels, one value a sample.
fn sent(turner: &mut Turner, levels: &[f64]) -> Vec<f64> {
    let mut part = [0.0];
    let step = |level: &f64| {
        turner.step(*level, &mut part);
        part[0]
    };
    levels.iter().map(step).collect()
}

#[test]
fn instants_are_those_of_levels_and_none_is_before_the_first() {
    let setup = setup(COIN, Shaping::Inverse);
    let on = |at: f64| {
        let mut turner = Turner::new(&setup, 0).unwrap();
        turner.order(at, 1, Order::On(1.0.into()));
        let late = turner.late();
        (late, sent(&mut turner, &vec![0.0; late + 20]))
    };
    let (late, at_once) = on(0.0);
    assert!(at_once[..late].iter().all(|x| *x == 0.0) && at_once[late..].iter().all(|x| *x == 1.0));
    assert_eq!(at_once, on(-5.0).1);
    let (_, within) = on(3.25);
    assert!(within[late + 2] == 0.0 && (within[late + 3] - 0.75).abs() < 1e-9 && within[late + 4] == 1.0);
}

#[test]
fn levels_that_are_no_numbers_are_silence() {
    let setup = setup(COIN, Shaping::Inverse);
    let of = |odd: [f64; 3]| {
        let mut turner = Turner::new(&setup, 0).unwrap();
        let mut levels = raised_cosine(0.7, 0.1);
        levels.extend(odd);
        levels.extend([0.0; 600]);
        (sent(&mut turner, &levels), turner.counts().masked)
    };
    let (plain, none) = of([0.0; 3]);
    let (odd, masked) = of([f64::INFINITY, f64::NAN, f64::NEG_INFINITY]);
    assert!(plain == odd && (none, masked) == (0, 3));
}

#[test]
fn what_was_switched_on_rolls_out_by_itself() {
    let setup = setup(COIN, Shaping::Inverse);
    let mut turner = Turner::new(&setup, 0).unwrap();
    turner.order(0.0, 1, Order::On(setup.limit.into()));
    turner.order(400.0, 1, Order::Release);
    let (volts, speeds) = play(&mut turner, &mut plant(&COIN, 0.0), &vec![0.0; 4000]);
    let off = (400 + turner.late()) * PARTS;
    assert!(volts[off - 1] == setup.limit && speeds[off] > 0.7 * setup.full_speed());
    assert!(volts[off..].iter().all(|x| *x == 0.0) && turner.is_idle());
}

#[test]
fn a_speed_of_nothing_is_held_while_its_voice_lasts() {
    let setup = setup(COIN, Shaping::Inverse);
    let mut turner = Turner::new(&setup, 0).unwrap();
    turner.order(800.0, 1, Order::Spin(0.0));
    turner.order(3200.0, 1, Order::Release);
    let (_, speeds) = play(&mut turner, &mut plant(&COIN, 0.0), &vec![0.5; 6000]);
    let at = |sample: usize| speeds[(sample + turner.late()) * PARTS];
    assert!(at(790) > 0.6 * setup.full_speed() && at(5500) > 0.6 * setup.full_speed());
    assert!((1200..3200).all(|n| at(n).abs() < 1e-3 * setup.full_speed()));
}

/// At the end of each sample the motor is as fast as what is played then, not as what was played before.
#[test]
fn overdrive_is_on_time() {
    let setup = setup(COIN, Shaping::Overdrive);
    let mut turner = Turner::new(&setup, 0).unwrap();
    let levels = raised_cosine(1.0, 2.0);
    let wished: Vec<f64> = levels.iter().map(|level| setup.speed_of(*level)).collect();
    for n in 0..levels.len() {
        turner.step(levels[n], &mut [0.0]);
        // On its way up, after the wish has left rest.
        if (2000..7000).contains(&n) {
            let now = n - turner.late();
            let rise = wished[now + 1] - wished[now];
            let off = turner.motor().unwrap().speed() - wished[now + 1];
            assert!(off.abs() < 0.2 * rise, "{n}: {off} of {rise}");
        }
    }
}

/// After an order the motor is where levels do not have it: it is brought there as fast as may be, and then follows without a jolt.
#[test]
fn levels_are_caught_up_with_and_then_followed() {
    for parameters in [COIN, PAD] {
        let setup = setup(Parameters { gravity: 0.0, ..parameters }, Shaping::Inverse);
        let mut turner = Turner::new(&setup, 0).unwrap();
        // Nothing flowed when the order came.
        let levels = [vec![0.0; 2400], vec![0.25; 5600]].concat();
        turner.order(1600.0, 1, Order::Spin(setup.full_speed()));
        turner.order(4800.0, 1, Order::Release);
        let (volts, speeds) = play(&mut turner, &mut plant(&setup.parameters, 0.0), &levels);
        let (wished, holds) = (0.5 * setup.full_speed(), setup.held_by(0.5 * setup.full_speed()));
        let released = (4800 + turner.late()) * PARTS;
        assert!(speeds[released] > 0.9 * setup.full_speed());
        // To rest, and from there with all there is: much sooner than what holds the wish would take, which leaves a hundredth after 4.6 time
        // constants.
        let rests = released
            + speeds[released..].iter().position(|now| now.abs() < 1e-3 * wished).expect("it comes to rest");
        let there = rests + (1.5 * parameters.mechanical_time() * RATE) as usize * PARTS;
        assert!((speeds[there] / wished - 1.0).abs() < 0.01, "{} {wished}", speeds[there]);
        let there = rests + volts[rests..].iter().position(|x| (x / holds - 1.0).abs() < 0.02).unwrap();
        let jolt = volts[there..].iter().map(|x| (x / holds - 1.0).abs()).fold(0.0, f64::max);
        assert!(jolt < 0.05, "{jolt}");
    }
}

/// Where dry friction is a good part of what the drive can, it does much of the braking; the rotor does not swing back.
#[test]
fn friction_has_its_part_in_stopping() {
    let coulomb = 0.3 * COIN.stall_torque(COIN.rated_volts);
    let rough = Parameters { coulomb, stiction: 1.2 * coulomb, gravity: 0.0, ..COIN };
    let setup = setup(rough, Shaping::Overdrive);
    for speed in [0.3, 0.5, 0.9] {
        let mut turner = Turner::new(&setup, 0).unwrap();
        turner.order(0.0, 1, Order::Spin(speed * setup.full_speed()));
        turner.order(1600.3, 1, Order::Release);
        let (_, speeds) = play(&mut turner, &mut plant(&rough, 0.0), &vec![0.0; 4000]);
        let fastest = speeds.iter().fold(0.0_f64, |most, now| most.max(*now));
        let back = speeds.iter().fold(0.0_f64, |least, now| least.min(*now));
        assert!(fastest < 1.01 * speed * setup.full_speed() && back > -1e-3 * fastest, "{fastest} {back}");
        assert!(turner.is_idle());
    }
}

#[test]
fn a_switching_drive_comes_to_rest() {
    let setup = setup(COIN, Shaping::Switching);
    let mut turner = Turner::new(&setup, 0).unwrap();
    let levels: Vec<f64> = [vec![0.6; 1600], vec![0.0; 2400]].concat();
    let (volts, _) = play(&mut turner, &mut plant(&COIN, 0.0), &levels);
    assert!(volts[1200 * PARTS..1600 * PARTS].iter().all(|x| x.abs() == setup.limit));
    assert!(volts[3200 * PARTS..].iter().all(|x| *x == 0.0) && turner.is_idle());
}

/// From one way to the other leads through rest: no plan leaps across it.
#[test]
fn the_way_round_leads_through_rest() {
    let setup = setup(PAD, Shaping::Inverse);
    let mut turner = Turner::new(&Setup { ordered: false, ..setup }, 0).unwrap();
    let levels: Vec<f64> = [vec![0.8; 4000], vec![-0.8; 4000]].concat();
    let (_, speeds) = play(&mut turner, &mut plant(&PAD, 0.0), &levels);
    let wished = setup.speed_of(0.8);
    let at = |sample: usize| speeds[(sample + turner.late()) * PARTS] / wished;
    // What is planned is feasible: it is at rest when the wish turns, and nothing is left to make up for.
    let [before, turn, after] = [3000, 4000, 7000].map(at);
    assert!((before - 1.0).abs() < 2e-3 && (after + 1.0).abs() < 2e-3, "{before} {after}");
    assert!(turn.abs() < 0.03, "{turn}");
    let fastest = speeds.iter().fold(0.0_f64, |most, now| most.max(now.abs()));
    assert!(fastest < 1.01 * wished, "{}", fastest / wished);
}

#[test]
fn orders_that_find_no_room_are_counted_and_a_brake_finds_some() {
    // Those that wait: ten for each sample, a thousand samples later than they come.
    let mut turner = Turner::new(&setup(COIN, Shaping::Inverse), 1000).unwrap();
    for n in 0..WAITING + 3 {
        turner.order(100.0 + 0.1 * n as f64, n as u64, Order::Spin(10.0));
    }
    turner.order(110.0, 0, Order::Brake);
    assert_eq!(turner.counts().dropped, 4);
    // For one sample there are fewer.
    let mut crowded = Turner::new(&setup(COIN, Shaping::Inverse), 0).unwrap();
    (0..AT_ONCE as u64 + 5).for_each(|n| crowded.order(100.5, n, Order::Spin(10.0)));
    assert_eq!(crowded.counts().dropped, 5);
    let mut plant = plant(&COIN, 0.0);
    play(&mut turner, &mut plant, &vec![0.0; 4000]);
    assert!(turner.is_idle(), "the brake held");
}

/// However many orders wait, a voice that is let go of is let go of: the motor stands in the end.
#[test]
fn a_release_always_finds_room() {
    // All that wait begin something; half of them end it; all of them are brakes.
    for kind in 0..3 {
        let setup = setup(COIN, Shaping::Inverse);
        let mut turner = Turner::new(&setup, 100).unwrap();
        let mut plant = plant(&COIN, 0.0);
        turner.order(0.0, 1, Order::Spin(setup.full_speed()));
        play(&mut turner, &mut plant, &vec![0.0; 350]);
        for n in 0..WAITING as u64 {
            let at = 400.0 + 0.1 * n as f64;
            match (kind, n % 2) {
                (0, _) | (1, 0) => turner.order(at, 1000 + n, Order::On(0.1.into())),
                (1, _) => turner.order(at, 1000 + n - 1, Order::Release),
                _ => turner.order(at, 1000 + n, Order::Brake),
            }
        }
        turner.order(410.0, 1, Order::Release);
        (0..WAITING as u64).for_each(|n| turner.order(420.0, 1000 + n, Order::Release));
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
