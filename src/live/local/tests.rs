use super::{Bounds, Count, Counts, Local, Told};
use crate::dsp::random::uniform;
use crate::knob::effect::{constant::Constant, spring::Spring, wall::Wall};
use crate::knob::governor::device::{Delay, Device};
use crate::knob::local_model::profile::Profile;
use crate::knob::safety::budget::Budget;
use crate::knob::safety::chain::Limits;
use crate::knob::servo::setup::Setup;
use crate::knob::servo::tick::Servo;
use crate::knob::stability::sampled::{Loop, Rotor};
use crate::knob::test_plant::Plant;
use crate::knob::velocity::choice::Choice;
use std::f64::consts::TAU;

mod books;

/// A winding that bears whatever is asked of it.
fn bounds() -> Bounds {
    let budget = Budget::new(1e9, 12.0, 1.0, 1e-3).unwrap();
    Bounds { slew: 1e9, over_speed: 60.0, inverted: false, budget }
}

const MS: u64 = 1_000_000;

/// A spring to 0, seen from an angle, so far to either side.
fn spring(stiffness: f64, centre: f64, reach: f64) -> Profile {
    let energy = 0.5 * stiffness * centre * centre;
    let flat = Profile { centre, reach, energy, time: 1.0, ..Profile::flat(-stiffness * centre) };
    Profile { more: std::array::from_fn(|k| -stiffness * flat.away(k)), ..flat }
}

fn told(number: u64, profile: Profile) -> Told {
    Told { number, stamp: 1, heard: profile.centre, profile }
}

#[test]
fn every_profile_that_was_sent_is_taken_or_was_replaced() {
    let (mut local, counts) = (Local::new(bounds()), Counts::default());
    let (mut sent, mut looks) = (0, 0);
    for n in 0..2000 {
        if uniform(1, n) > -0.3 {
            sent += 1;
        }
        if uniform(2, n) > 0.2 {
            let newest = told(sent, Profile { time: sent as f64, ..Profile::flat(sent as f64) });
            let new = local.told().number < sent;
            local.take(&newest, &counts);
            looks += u64::from(new);
            assert_eq!(local.torque(n * MS, 0.0, 0.0, &counts), sent as f64);
        }
    }
    let Count { taken, replaced, .. } = counts.now();
    assert!(
        taken == looks && replaced > 100 && taken + replaced == local.told().number,
        "{taken} {replaced}"
    );
    // One that came before says nothing any more.
    let last = *local.told();
    local.take(&told(3, Profile::flat(9.0)), &counts);
    assert_eq!(*local.told(), last);
}

/// Without a slope it is what it was before anything was left to the line: the servo's torque, to the bit, whatever is read meanwhile.
#[test]
fn what_does_not_depend_on_the_angle_is_given_as_it_came() {
    let slow = Bounds { slew: 1e-6, ..bounds() };
    let (mut local, counts) = (Local::new(slow), Counts::default());
    for n in 1..1000 {
        let torque = 0.1 * uniform(5, n);
        local.take(&told(n, Profile::flat(torque)), &counts);
        for k in 0..4 {
            assert_eq!(local.torque(n * MS + k, uniform(6, 4 * n + k), 1.0, &counts), torque);
        }
        // And at the angle of which it was made a profile is that as well.
        let centre = uniform(7, n);
        let mut wide = Local::new(bounds());
        wide.take(&told(1, Profile { torque, ..spring(0.3, centre, 0.02) }), &counts);
        assert_eq!(wide.torque(0, centre, 0.0, &counts), torque);
    }
    assert_eq!(counts.now().slewed, 0);
}

#[test]
fn what_cannot_be_is_no_torque_and_what_is_beyond_stays() {
    let (mut local, counts) = (Local::new(bounds()), Counts::default());
    local.take(&told(1, spring(0.2, 0.0, 0.16)), &counts);
    let near = |got: f64, want: f64| (got - want).abs() < 1e-15;
    assert!(near(local.torque(0, 0.1, 0.0, &counts), -0.02));
    assert_eq!(local.torque(1, f64::NAN, 0.0, &counts), 0.0);
    assert!(near(local.torque(2, 0.1, -60.0, &counts), -0.02));
    for speed in [60.1, -1e9, f64::NAN, f64::INFINITY] {
        assert_eq!(local.torque(3, 0.1, speed, &counts), 0.0, "{speed}");
    }
    assert_eq!((counts.now().too_fast, counts.now().beyond), (4, 0));
    // The range ends at 0.16: there it holds what it is.
    for (now, angle, held) in [(4, 0.17, -0.032), (5, -0.17, 0.032), (6, 3.0, -0.032), (7, -3.0, 0.032)] {
        assert!(near(local.torque(now, angle, 0.0, &counts), held));
    }
    assert_eq!(counts.now().beyond, 4);
    local.take(&told(2, Profile { torque: f64::NAN, ..Profile::flat(0.0) }), &counts);
    assert_eq!(local.torque(8, 0.0, 0.0, &counts), 0.0);
    assert!(counts.now().booked.is_finite());
}

/// Torque changes by no more than the slew of the time that has passed; between two profiles, of the servo's time between them.
#[test]
fn torque_keeps_to_the_slew() {
    let slow = Bounds { slew: 1.0, ..bounds() };
    let (mut local, counts) = (Local::new(slow), Counts::default());
    local.take(&told(1, spring(1.0, 0.0, 0.16)), &counts);
    assert_eq!(local.torque(0, 0.0, 0.0, &counts), 0.0);
    let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-12, "{got} {want}");
    // It asks for −0.1; 10 ms let 0.01 go.
    near(local.torque(10 * MS, 0.1, 0.0, &counts), -0.01);
    near(local.torque(15 * MS, 0.1, 0.0, &counts), -0.015);
    local.take(&told(2, Profile { time: 1.02, ..spring(1.0, 0.0, 0.16) }), &counts);
    near(local.torque(20 * MS, 0.1, 0.0, &counts), -0.04);
    near(local.torque(21 * MS, -0.1, 0.0, &counts), -0.039);
    near(local.torque(1021 * MS, -0.1, 0.0, &counts), 0.1);
    assert_eq!(counts.now().slewed, 4);
}

/// Angles of a line that falls where the servo's rises and that began some turns away.
#[test]
fn a_line_is_turns_away_and_may_be_inverted() {
    for (inverted, sign) in [(false, 1.0), (true, -1.0)] {
        let (mut local, counts) = (Local::new(Bounds { inverted, ..bounds() }), Counts::default());
        let line = |servo: f64| sign * (servo - 5.0 * TAU);
        // The servo is a little behind what is heard.
        let told = Told { heard: line(0.33), ..told(1, spring(0.2, 0.3, 0.16)) };
        local.take(&told, &counts);
        for (n, angle) in [0.2, 0.3, 0.4].into_iter().enumerate() {
            let torque = local.torque(n as u64 * MS, line(angle), 0.0, &counts);
            assert!((torque + 0.2 * angle).abs() < 1e-14, "{inverted} {angle}: {torque}");
        }
    }
}

/// Stiffened in place by ΔK at a stretch p: ½ ΔK p². Seen from elsewhere, the same world puts in nothing; torque that goes takes what was stored.
#[test]
fn a_change_of_profiles_puts_in_what_the_closed_form_says() {
    let (mut local, counts) = (Local::new(bounds()), Counts::default());
    let (k, more, p) = (0.4, 0.3, 0.05);
    local.take(&told(1, spring(k, 0.0, 0.16)), &counts);
    local.torque(0, 0.0, 0.0, &counts);
    assert_eq!(counts.now().booked, 0.0);
    let mut at = 0.0;
    for (n, centre) in [(2, 0.03), (3, -0.02), (4, 0.05)] {
        local.take(&told(n, spring(k, centre, 0.08)), &counts);
        at = 0.02 * n as f64 - 0.05;
        local.torque(n, at, 0.0, &counts);
        assert!(counts.now().booked.abs() < 1e-16, "{n}: {}", counts.now().booked);
    }
    local.torque(5, p, 0.0, &counts);
    local.take(&told(5, spring(k + more, 0.02, 0.16)), &counts);
    local.torque(6, p, 0.0, &counts);
    let booked = counts.now().booked;
    assert!((booked - 0.5 * more * p * p).abs() < 1e-16, "{booked} {at}");
    local.nothing(7, p, &counts);
    assert!((counts.now().booked - booked + 0.5 * (k + more) * p * p).abs() < 1e-16);
}

/// For a knob that swings without losses under profiles that change, what went in and what changes put in is what the last one holds, but
/// for what the hold creates, which is of the order of the tick.
#[test]
fn the_books_close() {
    let missing = |finer: u64| {
        let (t, every) = (1e-5 / finer as f64, 1000 * finer);
        let (mut local, counts) = (Local::new(bounds()), Counts::default());
        let mut plant = Plant::new(6e-6, 0.0, 0.0, t);
        plant.angle = 0.1;
        let (mut absorbed, mut last) = (0.0, spring(0.0, 0.0, 0.8));
        for n in 0..20 * every {
            if n % every == 0 {
                let (k, to) = (0.4 + 0.2 * uniform(2, n / every), 0.05 * uniform(4, n / every));
                last = Profile { torque: -k * (plant.angle - to), ..spring(k, plant.angle, 0.8) };
                local.take(&told(1 + n / every, last), &counts);
            }
            let before = plant.angle;
            let torque = local.torque(n, before, 0.0, &counts);
            plant.step(torque);
            absorbed -= torque * (plant.angle - before);
        }
        assert!((absorbed + plant.energy()).abs() < 1e-12 && counts.now().booked.abs() > 1e-4);
        last.energy(plant.angle) - absorbed - counts.now().booked
    };
    let (coarse, fine) = (missing(1), missing(8));
    assert!((coarse / fine / 8.0 - 1.0).abs() < 0.1, "{coarse:e} {fine:e}");
}

/// Ticks of the servo in a second, in an exchange of the line and in a block.
const RATE: f64 = 8000.0;
const EXCHANGE: usize = 8;
const ROTOR: Rotor = Rotor { inertia: 2e-5, damping: 4e-4 };

/// A knob on a line beside a servo that ticks block by block.
struct Rig {
    servo: Servo,
    local: Local,
    counts: Counts,
    plant: Plant,
    block: usize,
    heard: f64,
    next: f64,
    torque: f64,
    number: u64,
    tick: usize,
}

impl Rig {
    fn new(effects: Vec<crate::knob::effect::program::Any>, block: usize, left: bool) -> Self {
        let delay = Delay { local: left.then_some(1.0), ..Delay::ticks(if left { 60.0 } else { 1.0 }) };
        let device = Device {
            inertia: ROTOR.inertia,
            damping: ROTOR.damping,
            friction: None,
            count: 1e-9,
            period: 1.0 / RATE,
            delay,
            resonance: None,
            low_pass: None,
            velocity: Choice::Difference,
            peak: 0.05,
        };
        let limits = Limits {
            period: device.period,
            slew: 1e9,
            low_pass: None,
            continuous: 0.05,
            winding: 100.0,
            peak: 0.05,
            soft_start: 0.0,
            stale: 1000,
            release: 1.0,
            over_speed: 1e9,
        };
        // What it is granted is no matter here: nearly the edge of a knob that is hardly late.
        let mut servo = Servo::new(&Setup { margin: 1.0, ..Setup::new(effects, device, limits) }).unwrap();
        servo.arm();
        Self {
            servo,
            local: Local::new(Bounds { slew: 1e9, over_speed: 1e9, ..bounds() }),
            counts: Counts::default(),
            plant: Plant::new(ROTOR.inertia, ROTOR.damping, 0.0, 1.0 / RATE),
            block,
            heard: 0.0,
            next: 0.0,
            torque: 0.0,
            number: 0,
            tick: 0,
        }
    }

    /// A tick of the knob under a hand's torque.
    fn step(&mut self, hand: f64) {
        if self.tick.is_multiple_of(EXCHANGE) {
            // What was made of the angle before goes out, and the next angle comes in.
            self.torque = self.next;
            if self.tick.is_multiple_of(self.block * EXCHANGE) {
                let (from, to, ticks) = (self.heard, self.plant.angle, self.block * EXCHANGE);
                for n in 1..=ticks {
                    self.servo.tick(Some(from + (to - from) * n as f64 / ticks as f64), true);
                }
                (self.heard, self.number) = (to, self.number + 1);
                let told = Told { number: self.number, stamp: 1, heard: to, profile: self.servo.profile() };
                self.local.take(&told, &self.counts);
            }
            let now = (self.tick as f64 / RATE * 1e9) as u64;
            self.next = self.local.torque(now, self.plant.angle, self.plant.speed, &self.counts);
        }
        self.plant.step(self.torque + hand);
        self.tick += 1;
    }
}

fn swings(stiffness: f64, block: usize, left: bool, hertz: f64) -> bool {
    let mut rig = Rig::new(vec![Spring { stiffness, centre: 0.0 }.into()], block, left);
    rig.plant.angle = 1e-6;
    let span = (40.0 * RATE / hertz) as usize;
    let mut peaks = [0.0f64; 3];
    for peak in &mut peaks {
        for _ in 0..span {
            rig.step(0.0);
            *peak = peak.max(rig.plant.angle.abs());
            if *peak > 0.1 {
                return true;
            }
        }
    }
    peaks[2] > peaks[1]
}

/// Servo, profile and line together are the loop of the line alone, whatever the blocks: by bisection, against its exact eigenvalues. With the
/// servo's torque alone it swings at a fraction of that.
#[test]
fn a_spring_is_as_late_as_the_line_and_not_as_the_blocks() {
    let exact = Loop::rigid(&ROTOR, EXCHANGE as f64 / RATE, 1.0).unwrap().edge(0.0);
    for block in [1, 3, 11, 40] {
        let (mut low, mut high) = (0.7 * exact.gain, 1.3 * exact.gain);
        let swings = |k: f64| swings(k, block, true, exact.hertz);
        assert!(swings(high) && !swings(low), "{block}: {exact:?}");
        while high - low > 2e-3 * low {
            let middle = 0.5 * (low + high);
            if swings(middle) { high = middle } else { low = middle }
        }
        println!("{block} exchanges a block: {low} against {}", exact.gain);
        assert!((low / exact.gain - 1.0).abs() < 0.01, "{block}: {low} {exact:?}");
    }
    assert!(swings(0.7 * exact.gain, 11, false, exact.hertz));
    assert!(swings(0.3 * exact.gain, 40, false, exact.hertz));
}

/// A hand leans on a wall, at what the governor would grant for the line: it comes to rest where Hooke says, though blocks are long.
#[test]
fn a_wall_holds_though_blocks_are_long() {
    let exact = Loop::rigid(&ROTOR, EXCHANGE as f64 / RATE, 1.0).unwrap().edge(0.0);
    let stiffness = 0.5 * exact.gain;
    let wall = Wall { angle: 0.01, below: false, stiffness, damping: 0.0 };
    let rests = |left: bool| {
        let mut rig = Rig::new(vec![wall.into(), Constant { torque: 0.0 }.into()], 11, left);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for n in 0..80_000 {
            rig.step(2e-3);
            if n >= 72_000 {
                (low, high) = (low.min(rig.plant.angle), high.max(rig.plant.angle));
            }
        }
        let there = 0.01 + 2e-3 / stiffness;
        (high - low < 1e-6 && (low - there).abs() < 1e-4, rig.counts.now())
    };
    let (rested, count) = rests(true);
    assert!(rested, "{count:?}");
    assert!(!rests(false).0);
}
