//! Envelopes that are known as a whole, speeds that are kept, and drives with what follows them, as orders.

use std::f64::consts::TAU;
use std::sync::Arc;

use pacinian::actuator::drive::Drive;
use pacinian::actuator::driver::order::{After, By, Order, Switch};
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::track::Track;
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::Parameters;
use pacinian::actuator::shape::Inverse;

use crate::common::{COIN, PAD};
use crate::turner::{PARTS, RATE, plant, play, setup};

const PART: f64 = RATE * PARTS as f64;

fn flat(parameters: Parameters) -> Parameters {
    Parameters { gravity: 0.0, ..parameters }
}

fn hump(height: f64, seconds: f64) -> impl Fn(f64) -> f64 {
    move |t: f64| if t < seconds { 0.5 * height * (1.0 - (TAU * t / seconds).cos()) } else { 0.0 }
}

/// The same plan as that of whoever shapes the envelope of that strength alone; between two strengths that were worked out nearly so.
#[test]
fn plans_are_those_of_the_inverse() {
    let setup = setup(flat(COIN), Shaping::Plain);
    for seconds in [0.04, 0.15] {
        let track = Track::new(&setup, seconds, hump(1.0, seconds)).unwrap();
        for root in [1.0, 0.5, 0.7, -0.25] {
            let inverse =
                Inverse { parameters: setup.parameters, limit: setup.limit, rate: RATE, angle: None };
            let at = |n: usize| n as f64;
            let wished: Vec<f64> = (0..=track.samples()).map(|n| track.wished(at(n), root)).collect();
            let shaped = inverse.shape(&wished).unwrap();
            let off = shaped.speeds.iter().enumerate().map(|(n, speed)| speed - track.planned(at(n), root));
            let worst = off.fold(0.0_f64, |most, off| most.max(off.abs()));
            let share = if (root * 8.0_f64).fract() == 0.0 { 1e-12 } else { 0.02 };
            assert!(worst < share * setup.full_speed(), "{seconds} {root}: {worst}");
        }
    }
    assert!(Track::new(&setup, 1.0, hump(0.5, 1.0)).unwrap().reach()[1] < 1e-3);
    let [largest, missed] = Track::new(&setup, 0.04, hump(1.0, 0.04)).unwrap().reach();
    assert!(largest < 0.8 && missed > 0.1, "{largest} {missed}");
    for seconds in [0.0, 10.1, f64::NAN] {
        assert_eq!(Track::new(&setup, seconds, |_| 0.5).unwrap_err().field, "seconds");
    }
}

/// A turner that knows an envelope, which is ordered between two samples, and the speeds of a real motor from there on, one a part of a sample.
fn swelled(setup: &Setup, track: &Arc<Track>, root: f64, shaping: Shaping) -> (Turner, Vec<f64>, Vec<f64>) {
    let mut turner = Turner::new(setup, 0).unwrap().knowing(vec![Arc::clone(track)]);
    turner.order(200.5, 1, Order::Swell(0, root, shaping));
    turner.order(300.0, 1, Order::Release);
    let from = ((200.5 + turner.late() as f64) * PARTS as f64) as usize;
    let (sent, speeds) = play(&mut turner, &mut plant(&setup.parameters, 0.0), &vec![0.0; 4000]);
    (turner, sent[from..].to_vec(), speeds[from..].to_vec())
}

/// 150 ms of 8 m/s² on the coin: by inverse dynamics below 1 % of the peak, whatever levels are shaped by, also of less than that and backward.
#[test]
fn an_envelope_is_followed() {
    for shaping in [Shaping::Inverse, Shaping::Overdrive, Shaping::Plain] {
        let setup = setup(flat(COIN), shaping);
        let height = 8.0 / (setup.full_speed().powi(2) * COIN.eccentric / COIN.casing.mass().unwrap());
        let wish = hump(height, 0.15);
        let track = Arc::new(Track::new(&setup, 0.15, &wish).unwrap());
        for root in [1.0, 0.7, -1.0] {
            let off = |by: Shaping| {
                let (turner, _, speeds) = swelled(&setup, &track, root, by);
                assert!(turner.is_idle() && speeds.last() == Some(&0.0), "{shaping:?} {root} {by:?}");
                let level = |speed: &f64| (speed / setup.full_speed()).powi(2);
                assert!(speeds.iter().all(|speed| speed * root > -0.02 * setup.full_speed()));
                let off = speeds
                    .iter()
                    .enumerate()
                    .take((0.2 * PART) as usize)
                    .map(|(n, speed)| level(speed) - root * root * wish((n as f64 + 1.0) / PART));
                let squares: f64 = off.map(|off| off * off).sum();
                (squares / (0.2 * PART)).sqrt() / (root * root * height)
            };
            let [inverse, switching, plain] = [Shaping::Inverse, Shaping::Switching, Shaping::Plain].map(off);
            assert!(inverse < 0.01 && switching < 0.02 && plain > 0.15, "{inverse} {switching} {plain}");
        }
    }
}

/// What is out of reach is braked in time, within the limit; without a plan it is late.
#[test]
fn what_is_out_of_reach_ends_in_time() {
    let setup = setup(flat(PAD), Shaping::Plain);
    let track = Arc::new(Track::new(&setup, 0.02, |t| if t < 0.02 { 1.0 } else { 0.0 }).unwrap());
    let end = (0.02 * PART) as usize;
    let [planned, late] = [Shaping::Inverse, Shaping::Overdrive].map(|by| {
        let (_, sent, speeds) = swelled(&setup, &track, 1.0, by);
        assert!(sent.iter().all(|volts| volts.abs() <= setup.limit));
        let most = speeds.iter().fold(0.0_f64, |most, speed| most.max(*speed));
        assert!(most > 0.4 * setup.full_speed(), "{by:?}: {most}");
        speeds[end] / setup.full_speed()
    });
    assert!(planned.abs() < 0.05 && late > 0.3, "{planned} {late}");
}

/// A drive that switches gives all there is at every sample, and chatters by no more than that makes of speed within two; a plain one holds.
#[test]
fn speeds_are_kept_as_levels_would_be() {
    let setup = setup(Parameters { inductance: 0.0, ..flat(COIN) }, Shaping::Inverse);
    let p = &setup.parameters;
    let speed = 0.6 * setup.full_speed();
    let kept = |shaping: Shaping| {
        let mut turner = Turner::new(&setup, 0).unwrap();
        turner.order(0.0, 1, Order::Keep(speed, shaping));
        turner.order(2000.0, 1, Order::Release);
        let frame = (2000 + turner.late()) * PARTS;
        let (sent, speeds) = play(&mut turner, &mut plant(p, 0.0), &vec![0.0; 4000]);
        assert!(turner.is_idle() && speeds.last() == Some(&0.0), "{shaping:?}");
        (frame, sent, speeds)
    };
    let (until, sent, speeds) = kept(Shaping::Switching);
    let steps = p.gain / (p.resistance * p.effective_inertia()) * 2.0 * setup.limit / RATE;
    let begins = until - 2000 * PARTS;
    assert!(sent[begins..until].iter().all(|volts| volts.abs() == setup.limit));
    assert!(speeds[until - 6000..until].iter().all(|now| (now - speed).abs() < steps));
    // Braked by all there is.
    assert!(speeds[until + (0.5 * p.mechanical_time() * PART) as usize].abs() < 0.05 * speed);
    let (until, sent, speeds) = kept(Shaping::Plain);
    let begins = until - 2000 * PARTS;
    assert!(sent[begins..until].iter().all(|volts| (volts / setup.held_by(speed) - 1.0).abs() < 1e-12));
    assert!((speeds[until - 1] / speed - 1.0).abs() < 1e-3);
    // The short circuit's closed form.
    let (dry, time) = (p.coulomb / p.damping(), p.mechanical_time());
    for seconds in [0.005, 0.02, 0.04] {
        let is = speeds[until - 1 + (seconds * PART) as usize];
        let wanted = (speeds[until - 1] + dry) * (-seconds / time).exp() - dry;
        assert!((is - wanted).abs() < 1e-3 * speed, "{seconds}: {is} {wanted}");
    }
}

/// What is steady and what follows are as if the amplifier imposed it: by the closed forms of physics, on an amplifier that imposes the other.
#[test]
fn a_switch_is_held_by_what_it_says_and_followed_by_what_it_says() {
    let parameters = Parameters { inductance: 0.0, ..flat(PAD) };
    let volts = setup(parameters, Shaping::Inverse);
    let amperes = Setup {
        imposes: Drive::Current,
        limit: volts.limit / parameters.resistance,
        compliance: 3.0 * volts.limit,
        ..volts
    };
    let p = &parameters;
    for setup in [volts, amperes] {
        for (by, after) in [
            (By::Voltage, After::Short),
            (By::Voltage, After::Open),
            (By::Current, After::Open),
            (By::Current, After::Short),
        ] {
            let share = 0.3;
            let mut turner = Turner::new(&setup, 0).unwrap();
            let switch = Switch { amount: share * setup.limit, by, after };
            let on = if by == By::Current { 0.008 } else { 0.03 };
            turner.order(0.0, 1, Order::On(switch));
            turner.order(on * RATE, 1, Order::Release);
            let late = turner.late() as f64;
            let (_, speeds) = play(&mut turner, &mut plant(p, 0.0), &vec![0.0; 8000]);
            let at = |seconds: f64| speeds[((late / RATE + seconds) * PART).round() as usize - 1];
            let short = (p.damping() / p.effective_inertia(), p.coulomb / p.damping());
            let open = (p.viscous / p.effective_inertia(), p.coulomb / p.viscous);
            let torque = p.gain * share * amperes.limit;
            for seconds in [0.25 * on, 0.6 * on, on] {
                let (rate, damping) = match by {
                    By::Current => (open.0, p.viscous),
                    _ => (short.0, p.damping()),
                };
                let wanted = (torque - p.coulomb) / damping * -(-rate * seconds).exp_m1();
                let off = at(seconds) / wanted - 1.0;
                assert!(off.abs() < 0.01, "{:?} {by:?}: {off} at {seconds}", setup.imposes);
            }
            let (rate, dry) = if after == After::Short { short } else { open };
            for seconds in [0.002, 0.006] {
                let wanted = ((at(on) + dry) * (-rate * seconds).exp() - dry).max(0.0);
                let off = (at(on + seconds) - wanted) / at(on);
                assert!(off.abs() < 0.005, "{:?} {after:?}: {off} after {seconds}", setup.imposes);
            }
        }
    }
}

/// Of a motor that a spin has brought to its speed an envelope takes over; where other envelopes are known, or none, it is nothing. Behind diodes
/// it goes forward alone.
#[test]
fn the_newest_order_holds() {
    let setup = setup(flat(COIN), Shaping::Plain);
    let track = Arc::new(Track::new(&setup, 0.5, |_| 0.04).unwrap());
    let mut turner = Turner::new(&setup, 0).unwrap().knowing(vec![Arc::clone(&track)]);
    turner.order(0.0, 1, Order::Spin(setup.full_speed()));
    turner.order(2000.0, 2, Order::Swell(0, 1.0, Shaping::Inverse));
    turner.order(2100.0, 1, Order::Release);
    turner.order(2200.0, 3, Order::Swell(7, 1.0, Shaping::Inverse));
    let (_, speeds) = play(&mut turner, &mut plant(&setup.parameters, 0.0), &vec![0.0; 7000]);
    let slow = 0.2 * setup.full_speed();
    assert!((speeds[4000 * PARTS] / slow - 1.0).abs() < 0.01, "{}", speeds[4000 * PARTS]);
    assert!(turner.is_idle());

    let one_way = Setup { one_way: true, ..setup };
    let track = Arc::new(Track::new(&one_way, 0.1, |t| if t < 0.05 { 0.5 } else { -0.5 }).unwrap());
    let mut turner = Turner::new(&one_way, 0).unwrap().knowing(vec![track]);
    turner.order(0.0, 1, Order::Swell(0, -1.0, Shaping::Inverse));
    turner.order(4000.0, 1, Order::Swell(0, 1.0, Shaping::Inverse));
    let mut parts = [0.0];
    let sent: Vec<f64> = (0..16_000)
        .map(|_| {
            turner.step(0.0, &mut parts);
            parts[0]
        })
        .collect();
    assert_eq!(turner.counts().backward, 1);
    assert!(sent[..4000].iter().all(|x| *x == 0.0) && sent.iter().all(|x| *x >= 0.0));
    assert!(sent.iter().any(|x| *x > 0.1) && turner.is_idle());
}
