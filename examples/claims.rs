//! The figures of an article, each worked out anew from what the article itself gives.
//!
//! Hayward & MacLean, "Do it yourself haptics: part I", IEEE Robotics & Automation Magazine 14(4), 2007, is where much of pacinian begins. It
//! supports what it teaches with figures; this prints each beside what its own inputs come to, by a formula or by simulation, and
//! whether the two agree within the digits that were given. `cargo run --release --example claims`

use std::f64::consts::{PI, TAU};

use pacinian::knob::plant::encoder::Encoder;
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::rotor::Rotor;
use pacinian::knob::stability::rules;
use pacinian::knob::stability::sampled::{Loop, Rotor as Light};

/// Table 1: inertia (kg m²), friction, shorted damping, peak torque (N m), volts, inductance, resistance.
struct Motor {
    inertia: f64,
    damping: f64,
    peak: f64,
    continuous: f64,
    volts: f64,
    inductance: f64,
    resistance: f64,
}

const PITTMAN: Motor = Motor {
    inertia: 1.6e-6,
    damping: 0.15e-3,
    peak: 0.150,
    continuous: 0.022,
    volts: 19.0,
    inductance: 1.5e-3,
    resistance: 2.6,
};
const PITTMAN_FRICTION: f64 = 2.1e-3;
const RE25: Motor = Motor {
    inertia: 0.95e-6,
    damping: 0.21e-3,
    peak: 0.175,
    continuous: 0.023,
    volts: 18.0,
    inductance: 0.15e-3,
    resistance: 1.26,
};

/// One figure: what is said, what it comes to, and by how much of itself it may be off to agree.
struct Claim {
    what: &'static str,
    said: f64,
    found: f64,
    unit: &'static str,
    within: f64,
    /// Whether the two are known to agree.
    agree: bool,
}

impl Claim {
    fn agrees(&self) -> bool {
        (self.found / self.said - 1.0).abs() <= self.within
    }
}

fn main() {
    let claims = claims();
    println!("{:88} {:>10} {:>10}", "", "said", "comes to");
    let mut strange = 0;
    for claim in &claims {
        let verdict = if claim.agrees() {
            "holds".to_string()
        } else {
            let times = claim.found / claim.said;
            if times >= 1.0 { format!("no: {times:.3} times") } else { format!("no: 1/{:.3}", 1.0 / times) }
        };
        println!(
            "{:88} {:>10} {:>10}  {:9} {verdict}",
            claim.what,
            shown(claim.said),
            shown(claim.found),
            claim.unit
        );
        strange += usize::from(claim.agrees() != claim.agree);
    }
    let hold = claims.iter().filter(|claim| claim.agrees()).count();
    println!("\n{hold} of {} agree.", claims.len());
    assert_eq!(strange, 0, "a verdict is not what it was when it was looked into");
}

fn shown(value: f64) -> String {
    if (1e-2..1e4).contains(&value.abs()) { format!("{value:.4}") } else { format!("{value:.3e}") }
}

fn claims() -> Vec<Claim> {
    let mut all = Vec::new();
    let mut tell = |what, said, found, unit, within, agree| {
        all.push(Claim { what, said, found, unit, within, agree });
    };

    // A wooden surface of 10 GPa under a ball of 1 mm, pressed with 2.5 N.
    let (modulus, radius, force) = (10e9, 1e-3_f64, 2.5_f64);
    let depth = |factor: f64| (force / factor).powf(2.0 / 3.0);
    let printed = depth(0.75 * (radius * modulus).sqrt());
    let meant = depth(0.75 * modulus * radius.sqrt());
    let hertz = depth(4.0 / 3.0 * modulus * radius.sqrt());
    tell(
        "wood gives way by 5 um: with the formula as printed, E under the root",
        5e-6,
        printed,
        "m",
        0.1,
        false,
    );
    tell("  with E before the root", 5e-6, meant, "m", 0.1, true);
    tell("  by Hertz's law, 4/3 in place of 3/4", 5e-6, hertz, "m", 0.1, false);
    tell(
        "its stiffness there is nearly 1e6 N/m: with E before the root",
        1e6,
        1.5 * force / meant,
        "N/m",
        0.25,
        true,
    );
    tell("  by Hertz's law", 1e6, 1.5 * force / hertz, "N/m", 0.25, true);
    tell(
        "1e4 N/m is two orders of magnitude below",
        2.0,
        (1.5 * force / hertz / 1e4).log10(),
        "decades",
        0.1,
        true,
    );

    // Table 1.
    let range = 10.0 * (PITTMAN.peak / PITTMAN_FRICTION).log10();
    tell("dynamic range of the wound motor, peak torque over friction", 20.0, range, "dB", 0.1, true);
    let swing = peak_to_peak(RE25.peak, 100.0);
    tell(
        "RE25 at 100 Hz and its largest torque swings by 0.025 degrees (peak torque)",
        0.025,
        swing,
        "degrees",
        0.2,
        false,
    );
    tell("  with the continuous torque", 0.025, peak_to_peak(RE25.continuous, 100.0), "degrees", 0.2, false);
    let resolved = (2.0 * RE25.peak / (RE25.inertia * TAU / 400.0)).sqrt() / TAU;
    tell("an encoder of 400 counts resolves what it does up to 10 Hz", 10.0, resolved, "Hz", 0.2, false);
    tell("electrical time constant of the RE25", 1e-4, RE25.inductance / RE25.resistance, "s", 0.25, true);
    let gains = |motor: &Motor| {
        [(motor.damping * motor.resistance).sqrt(), motor.peak * motor.resistance / motor.volts]
    };
    let [of_damping, of_peak] = gains(&PITTMAN);
    tell(
        "torque constant of the wound motor, by its damping and by its peak torque",
        of_damping,
        of_peak,
        "N m/A",
        0.05,
        true,
    );
    let [of_damping, of_peak] = gains(&RE25);
    tell("  of the RE25: its row contradicts itself", of_damping, of_peak, "N m/A", 0.05, false);

    // A spring of 1000 N/m on 0.1 kg, at 1 kHz.
    let (spring, mass, tick) = (1000.0_f64, 0.1, 1e-3);
    tell(
        "a soft spring of 1000 N/m on 0.1 kg swings with 100 rad/s",
        100.0,
        (spring / mass).sqrt(),
        "rad/s",
        1e-9,
        true,
    );
    let free = Light { inertia: mass, damping: 0.0 };
    let grows =
        |delay: f64| loop_of(&free, tick, delay).map_or(f64::NAN, |l| (0.1 * l.growth(spring, 0.0)).exp());
    tell(
        "at 1 kHz its swing doubles in 0.1 s: with the hold and one sample of delay",
        2.0,
        grows(1.0),
        "times",
        0.1,
        true,
    );
    tell("  with the hold alone", 2.0, grows(0.0), "times", 0.1, false);
    tell("steps of 10 um at 1 kHz make steps of speed of", 0.01, 10e-6 / tick, "m/s", 1e-9, true);
    let bound = |delay: f64| needed(spring, mass, tick, delay);
    tell(
        "damping that keeps it stable, sT/2: without a delay",
        0.5 * spring * tick,
        bound(0.0),
        "N s/m",
        0.02,
        true,
    );
    tell(
        "  with the one sample of delay that the figure draws",
        0.5 * spring * tick,
        bound(1.0),
        "N s/m",
        0.02,
        false,
    );
    tell(
        "friction that covers the encoder, sd/2: K d / 2 f at which a knob begins to hunt",
        1.0,
        hunts(),
        "",
        0.005,
        true,
    );
    let knob = Light { inertia: 6e-6, damping: 2e-5 };
    let edge = |computed: f64| loop_of(&knob, 1e-4, 0.0).map_or(f64::NAN, |l| l.edge(computed).gain);
    let passive = |computed: f64| rules::colgate(knob.damping, computed, 1e-4);
    tell(
        "computed damping b costs b of what a wall may have and still be passive (b/2)",
        0.5,
        passive(1e-5) / passive(0.0),
        "times",
        1e-9,
        true,
    );
    tell("  and of what is stable", 0.5, edge(1e-5) / edge(0.0), "times", 0.1, false);

    // A motor that is driven forward and then backward for as long.
    let after = (1.0 - (-1.0_f64).exp()).powi(2);
    tell(
        "reverse drive for as long as forward leaves it at rest (speed after a time constant each)",
        1.0,
        1.0 - after,
        "",
        0.05,
        false,
    );
    all
}

fn loop_of(rotor: &Light, tick: f64, delay: f64) -> Option<Loop> {
    Loop::rigid(rotor, tick, delay).ok()
}

/// How far a torque that swings turns the RE25, from end to end, in degrees: simulated.
fn peak_to_peak(torque: f64, hertz: f64) -> f64 {
    let rate = 192_000.0;
    let parameters = Parameters { inertia: RE25.inertia, viscous: 0.0, ..Parameters::default() };
    let Ok(mut rotor) = Rotor::<false>::new(&parameters, rate) else { return f64::NAN };
    // So fast that it comes back to where it was.
    if rotor.place(0.0, -torque / (RE25.inertia * TAU * hertz)).is_err() {
        return f64::NAN;
    }
    let (mut least, mut most) = (0.0_f64, 0.0_f64);
    for n in 0..(rate / hertz) as usize {
        rotor.step(torque * (TAU * hertz * (n as f64 + 0.5) / rate).sin());
        (least, most) = (least.min(rotor.angle()), most.max(rotor.angle()));
    }
    (most - least) * 180.0 / PI
}

/// The damping at which a sampled spring neither grows nor decays.
fn needed(spring: f64, mass: f64, tick: f64, delay: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0 * spring * tick);
    for _ in 0..60 {
        let damping = 0.5 * (low + high);
        let grows = loop_of(&Light { inertia: mass, damping }, tick, delay)
            .is_none_or(|l| l.growth(spring, 0.0) > 0.0);
        if grows { low = damping } else { high = damping }
    }
    high
}

/// K δ / 2 f_c at which a knob of an encoder of 4000 counts no longer rests under every one of 1,000 constant torques of a hand: simulated.
fn hunts() -> f64 {
    let friction = 1e-3;
    let Ok(encoder) = Encoder::of_counts(4000.0) else { return f64::NAN };
    let rests = |ratio: f64| {
        let spring = 2.0 * friction * ratio / encoder.quantum();
        let parameters = Parameters { coulomb: friction, stiction: friction, ..Parameters::default() };
        (0..1000).all(|hand| {
            let Ok(mut rotor) = Rotor::<false>::new(&parameters, 10_000.0) else { return false };
            let hand = spring * encoder.quantum() * f64::from(hand) / 1000.0;
            for n in 0..20_000 {
                rotor.step(hand - spring * encoder.read(rotor.angle()));
                if n > 15_000 && rotor.speed() != 0.0 {
                    return false;
                }
            }
            true
        })
    };
    let (mut low, mut high) = (0.5, 2.0);
    while high - low > 1e-3 {
        let middle = 0.5 * (low + high);
        if rests(middle) { low = middle } else { high = middle }
    }
    high
}
