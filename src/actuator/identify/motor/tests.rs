//! Motors that are simulated with gravity, inductance and dry friction, recorded with noise.

use std::ops::Range;

use super::super::coverage::Coverage;
use super::super::noise::Noise;
use super::super::{Channel, Identified};
use super::{Recording, identify};
use crate::actuator::motor::{Casing, Drive, Motor, Parameters, Plan, Wish};

/// What was simulated.
pub(super) struct Run {
    pub rate: f64,
    pub drive: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub current: Vec<f64>,
    pub voltage: Vec<f64>,
    pub open: Vec<Range<usize>>,
}

pub(super) const PAD: Parameters = Parameters {
    resistance: 10.42,
    inductance: 4.2e-3,
    gain: 0.011,
    inertia: 1.15e-7,
    viscous: 1e-6,
    coulomb: 6e-4,
    stiction: 7e-4,
    eccentric: 1.38e-5,
    gravity: crate::actuator::motor::GRAVITY,
    casing: Casing::Free { mass: 0.25 },
    rated_volts: 12.5,
};

/// Shares of the rated voltage and seconds; `None`: open. The mass hangs at an angle before.
pub(super) fn simulate(p: &Parameters, rate: f64, angle: f64, course: &[(Option<f64>, f64)]) -> Run {
    let plan = Plan::choose(p, rate, &Wish { error: 0.0, posture: true, casing: true });
    let mut motor = Motor::<false>::new(p, &plan, rate).unwrap();
    motor.place(angle, 0.0);
    let mut run =
        Run { rate, drive: vec![], acceleration: vec![], current: vec![], voltage: vec![], open: vec![] };
    for (share, seconds) in course {
        let count = (seconds * rate) as usize;
        if share.is_none() {
            run.open.push(run.drive.len()..run.drive.len() + count);
        }
        for _ in 0..count {
            let now = motor.reading();
            run.acceleration.push(now.acceleration[0]);
            run.current.push(now.current);
            run.voltage.push(now.voltage);
            run.drive.push(share.map_or(0.0, |s| s * p.rated_volts));
            motor.drive(share.map_or(Drive::Open, |s| Drive::Voltage(s * p.rated_volts)));
            motor.step();
        }
    }
    run
}

impl Run {
    pub fn channel<'a>(&self, samples: &'a [f64]) -> Channel<'a> {
        Channel { samples, rate: self.rate, full_scale: None }
    }

    pub fn recording<'a>(&'a self, acceleration: &'a [f64]) -> Recording<'a> {
        Recording {
            drive: self.channel(&self.drive),
            acceleration: self.channel(acceleration),
            is_calibrated: true,
            current: None,
            voltage: None,
            open: &self.open,
            delay: None,
            current_delay: Some(0.0),
            mass: None,
        }
    }
}

/// Three voltages, one way and down again.
pub(super) const STAIRS: [(Option<f64>, f64); 5] =
    [(Some(0.0), 0.05), (Some(1.0), 0.35), (Some(0.5), 0.3), (Some(0.8), 0.3), (Some(0.0), 0.3)];

/// What the motion alone should tell.
pub(super) fn groups(p: &Parameters) -> [(&'static str, f64); 4] {
    [
        ("time_constant", p.mechanical_time()),
        ("speed_per_volt", p.gain / (p.resistance * p.damping())),
        ("running_volts", p.coulomb * p.resistance / p.gain),
        ("eccentric_per_mass", p.eccentric / p.casing.mass().unwrap()),
    ]
}

/// What the current tells beside.
pub(super) fn absolutes(p: &Parameters) -> [(&'static str, f64); 7] {
    [
        ("resistance", p.resistance),
        ("inductance", p.inductance),
        ("torque_constant", p.gain),
        ("inertia", p.inertia),
        ("viscous_friction", p.viscous),
        ("coulomb_friction", p.coulomb),
        ("eccentric_moment", p.eccentric),
    ]
}

/// Within 3 %; says whether inside of the interval.
pub(super) fn near(all: &Identified, name: &str, truth: f64) -> bool {
    let found = all.get(name).unwrap_or_else(|| panic!("{name} is not told: {:?}", all.why_not(name)));
    assert!((found.value / truth - 1.0).abs() < 0.03, "{found}, but it is {truth:e}");
    found.holds(truth)
}

/// Over seeds at 40 dB: within 3 %, root mean square, as many inside of their intervals as 95 % of such draws are, and no farther off than twice what those
/// say.
fn trusted(seeds: u64, what: &[(&str, f64)], identify: impl Fn(u64) -> Identified) {
    let mut all = vec![Coverage::default(); what.len()];
    for seed in 0..seeds {
        let found = identify(seed);
        for (coverage, (name, truth)) in all.iter_mut().zip(what) {
            let estimate = found.get(name).unwrap_or_else(|| panic!("{name}: {:?}", found.why_not(name)));
            coverage.take(estimate.value, estimate.interval, *truth);
            // What the motion alone tells is within 3 % whatever the noise.
            if groups(&PAD).iter().any(|(group, _)| group == name) {
                near(&found, name, *truth);
            }
        }
    }
    for ((name, _), coverage) in what.iter().zip(&all) {
        println!("{name}: {coverage:?} {:.2} {:.4}", coverage.off(), coverage.share());
        assert!(coverage.holds() && coverage.off() < 2.0 && coverage.share() < 0.03, "{name}: {coverage:?}");
    }
}

#[test]
fn groups_are_within_three_percent_and_inside_of_their_intervals() {
    for (p, rate, angle) in [(Parameters::COIN, 6000.0, 0.3), (PAD, 8000.0, -2.0)] {
        let run = simulate(&p, rate, angle, &STAIRS);
        groups_trusted(40, &p, &run);
    }
}

/// A coil that is slow beside its rotor, 0.40 ms beside 9.1: who knows the delay gets the sum of both time constants.
#[test]
fn a_known_delay_tells_the_coil_from_it() {
    let run = simulate(&PAD, 8000.0, 0.3, &STAIRS);
    let noisy = Noise::new(21).add(&run.acceleration, 40.0);
    let all = identify(&Recording { delay: Some(0.0), ..run.recording(&noisy) }).unwrap();
    let found = all.get("time_constant").unwrap();
    assert!((found.value / PAD.mechanical_time() - 1.0).abs() < 0.015, "{found} {}", PAD.mechanical_time());
    assert!(found.interval[1] - found.interval[0] < 0.03 * found.value, "{found}");
}

fn groups_trusted(seeds: u64, p: &Parameters, run: &Run) {
    trusted(seeds, &groups(p), |seed| {
        identify(&run.recording(&Noise::new(seed).add(&run.acceleration, 40.0))).unwrap()
    });
}

fn absolutes_trusted(seeds: u64, p: &Parameters, run: &Run) {
    let what: Vec<_> = groups(p).into_iter().chain(absolutes(p)).collect();
    trusted(seeds, &what, |seed| {
        let noisy = Noise::new(seed).add(&run.acceleration, 40.0);
        let current = Noise::new(seed + 1000).add(&run.current, 40.0);
        let current = Some(run.channel(&current));
        identify(&Recording { current, mass: p.casing.mass(), ..run.recording(&noisy) }).unwrap()
    });
}

#[test]
fn a_current_tells_what_is_absolute() {
    absolutes_trusted(8, &PAD, &simulate(&PAD, 24e3, 0.3, &STAIRS));
    // L/R is 10 µs, a sample 167 µs: it is said that this does not show, and everything else does.
    let p = Parameters::COIN;
    let run = simulate(&p, 6000.0, 0.3, &STAIRS);
    let noisy = Noise::new(1).add(&run.acceleration, 40.0);
    let current = Some(run.channel(&run.current));
    let all = identify(&Recording { current, ..run.recording(&noisy) }).unwrap();
    assert!(all.why_not("inductance").unwrap().contains("record faster"), "{all:?}");
    assert!(all.why_not("eccentric_moment").unwrap().contains("weigh"));
    near(&all, "resistance", p.resistance);
}

/// Nothing but dry friction: the fit ends where viscous friction does, and tells the rest.
#[test]
fn a_motor_without_viscous_friction_is_told_too() {
    let p = Parameters { viscous: 0.0, ..PAD };
    let run = simulate(&p, 12e3, 0.3, &STAIRS);
    let noisy = Noise::new(1).add(&run.acceleration, 40.0);
    let current = Noise::new(1001).add(&run.current, 40.0);
    let current = Some(run.channel(&current));
    let all = identify(&Recording { current, mass: p.casing.mass(), ..run.recording(&noisy) }).unwrap();
    for (name, truth) in absolutes(&p) {
        if name == "viscous_friction" {
            let why = all.why_not(name).unwrap();
            assert!(why.contains("between 0.000e0") || why.contains("as good as none"), "{why}");
        } else {
            near(&all, name, truth);
        }
    }
}

/// Any sense, any polarity of the sensor, any unit, and a recording chain that is late by 2.5 ms.
#[test]
fn sense_polarity_unit_and_delay_do_not_matter() {
    let p = Parameters { rated_volts: -3.0, ..Parameters::COIN };
    let mut run = simulate(&Parameters::COIN, 8000.0, 1.0, &STAIRS);
    run.acceleration = Noise::new(5).add(&run.acceleration, 40.0).iter().map(|x| -400.0 * x).collect();
    run.acceleration.splice(0..0, [0.0; 20]);
    run.acceleration.truncate(run.drive.len());
    let forward = identify(&Recording { is_calibrated: false, ..run.recording(&run.acceleration) }).unwrap();
    run.drive.iter_mut().for_each(|u| *u = -*u);
    let backward = identify(&Recording { is_calibrated: false, ..run.recording(&run.acceleration) }).unwrap();
    assert_eq!(forward, backward);
    for (name, truth) in &groups(&Parameters { rated_volts: 3.0, ..p })[..3] {
        assert!(near(&forward, name, *truth), "{name} {truth} {forward:?}");
    }
    let late = forward.get("lateness").unwrap();
    assert!((late.value - 2.5e-3).abs() < 1e-4, "{late}");
    assert!(forward.why_not("eccentric_per_mass").unwrap().contains("calibrated"));
    // Who knows the delay gets a narrower time constant.
    let known = Recording { is_calibrated: false, delay: Some(2.5e-3), ..run.recording(&run.acceleration) };
    let known = identify(&known).unwrap();
    let width = |all: &Identified| all.get("time_constant").map(|e| e.interval[1] - e.interval[0]).unwrap();
    assert!(width(&known) < 0.3 * width(&forward) && near(&known, "time_constant", p.mechanical_time()));
}

/// One step of one height tells the time constant, and says what is missing for the rest. What it ran down by tells it.
#[test]
fn what_one_step_does_not_tell_is_said() {
    let p = Parameters::COIN;
    let run = simulate(&p, 8000.0, 0.3, &STAIRS[..2]);
    let noisy = Noise::new(7).add(&run.acceleration, 40.0);
    let all = identify(&run.recording(&noisy)).unwrap();
    assert!(near(&all, "time_constant", p.mechanical_time()), "{all:?}");
    assert!(near(&all, "eccentric_per_mass", 7.3e-6));
    for name in ["speed_per_volt", "running_volts"] {
        assert!(all.get(name).is_none() && all.why_not(name).unwrap().contains("at least two"), "{all:?}");
    }
    assert!(all.why_not("start_volts").unwrap().contains("slowly"), "{all:?}");
    for name in super::ABSOLUTE.iter().chain(&["start_volts", "static_friction", "eccentric_moment"]) {
        assert!(all.get(name).is_none() && all.why_not(name).is_some(), "{name}");
    }
    let run = simulate(&p, 8000.0, 0.3, &[(Some(0.0), 0.05), (Some(1.0), 0.35), (Some(0.0), 0.3)]);
    let all = identify(&run.recording(&Noise::new(7).add(&run.acceleration, 40.0))).unwrap();
    for (name, truth) in groups(&p) {
        assert!(near(&all, name, truth), "{name} {truth} {all:?}");
    }
}

/// A slow ramp tells the voltage that starts it, with the mass hanging at first; by a current, the torque.
#[test]
fn a_ramp_tells_the_start() {
    let p = Parameters { gravity: 0.0, ..Parameters::COIN };
    // 0.5 V a second: 17 mV within the time constant.
    let ramp = (0..2400).map(|n| (Some(f64::from(n) / 6000.0), 1e-3));
    let course: Vec<_> = ramp.chain([(Some(0.3), 0.3), (Some(0.4), 0.3)]).collect();
    let run = simulate(&p, 8000.0, 0.0, &course);
    let noisy = Noise::new(9).add(&run.acceleration, 40.0);
    let current = Some(run.channel(&run.current));
    let all = identify(&Recording { current, ..run.recording(&noisy) }).unwrap();
    let start = all.get("start_volts").unwrap_or_else(|| panic!("{all:?}"));
    assert!(start.holds(p.start_volts()), "{start} {}", p.start_volts());
    let held = all.get("static_friction").unwrap();
    assert!(held.holds(p.stiction), "{held}");
    assert!(start.interval[1] - start.interval[0] < 0.2 * start.value);
}

/// Terminals that are open after a run: their voltage is k ω.
#[test]
fn open_terminals_tell_the_torque_constant() {
    let p = Parameters::COIN;
    let course = [(Some(0.0), 0.05), (Some(1.0), 0.3), (Some(0.6), 0.3), (None, 0.2)];
    let run = simulate(&p, 8000.0, 0.3, &course);
    let noisy = Noise::new(11).add(&run.acceleration, 40.0);
    let volts = Noise::new(12).add(&run.voltage, 40.0);
    let voltage = Some(run.channel(&volts));
    let all = identify(&Recording { voltage, ..run.recording(&noisy) }).unwrap();
    assert!(near(&all, "torque_constant", p.gain), "{all:?}");
    for (name, truth) in groups(&p) {
        assert!(near(&all, name, truth), "{name} {truth} {all:?}");
    }
    assert!(all.why_not("resistance").is_some());
}
