//! Identification of a rumble motor from what its casing does.
//!
//! The casing of a motor that turns at ω shakes with the frequency ω/2π and the amplitude (m_e r/M) √(ω⁴ + α²), so the speed is told
//! by any accelerometer, calibrated or not, and with the voltages at hand the law ω′ = g V − r ω − c with it: the mechanical time constant
//! from 1/r, the speed a volt from g/r, the voltage that running friction takes from c/g. A calibrated accelerometer tells m_e r/M beside.
//! Nothing absolute is in that: a motor of twice the torque constant, inertia and friction, and four times the resistance, does the same.
//! With the current as a channel it is: R, L and k from V = R i + L di/dt + k ω, and J, b and T_c from J ω′ = k i − b ω − T_c. So it
//! is, as far as k goes, with the voltage of open terminals.

mod electric;

use std::ops::Range;

use electric::Electric;

use super::estimate::Identified;
use super::recording::{Channel, Mistake, Name};
use super::rotor::Rotor;
use super::spin::Push;
use super::start::Began;
use super::winding::of_open;
use crate::actuator::fault::{not_negative, within};

/// What was recorded of a rumble motor. All channels begin in the same instant and have the same rate.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// Volts at the terminals, held from each sample to the next. At rest in the beginning, then steps of some heights, each until the
    /// speed stands; switching between them while it runs tells the delay.
    pub drive: Channel<'a>,
    /// The casing's, along one axis in the plane of rotation; m/s² where it `is_calibrated`, else in any unit. Only the casing of
    /// a device that hangs free, or lies soft, shakes as this assumes.
    pub acceleration: Channel<'a>,
    /// Whether `acceleration` is in m/s².
    pub is_calibrated: bool,
    /// Of the coil, A.
    pub current: Option<Channel<'a>>,
    /// At the terminals, V. Where they are open it is k ω; elsewhere it takes the place of the drive.
    pub voltage: Option<Channel<'a>>,
    /// Samples over which the terminals are open; `drive` is not looked at there.
    pub open: &'a [Range<usize>],
    /// Seconds by which the recording chain delays the acceleration against the drive, if known.
    pub delay: Option<f64>,
    /// Seconds by which it delays the current against the drive, -1 to 10, if known to half a sample; else it is fitted, and looked for within
    /// six samples around none. Not looked at where there is a `voltage`, which is recorded as the current is.
    pub current_delay: Option<f64>,
    /// All that moves, M, kg, 1e-9 to 1e6, if known: with it m_e r is told beside m_e r/M.
    pub mass: Option<f64>,
}

/// Seconds that a recording may be late.
const DELAY: (f64, f64) = (-1.0, 10.0);
/// All that moves with a motor, kg.
const MASS: (f64, f64) = (1e-9, 1e6);
/// The part of the starting voltage that may be left open, at most.
const WIDE: f64 = 0.3;
/// The fast time constant as a share of the slow one, at most: with more, coil and rotor all but swing.
const FASTEST: f64 = 0.25;
/// What it is without a hint, at most.
const LIKELY: f64 = 0.02;
/// The share of the starting voltage that gravity may have, at most.
const HIDES: f64 = 0.15;
/// Gravity's ripple is read to first order in 1/(ω τ): so much of it is off.
const RIPPLE: f64 = 0.05;

/// What a recording tells of a motor.
///
/// Rig keys: `time_constant`, `speed_per_volt`, `running_volts`, `start_volts`, `eccentric_per_mass`; with a current `resistance`,
/// `inductance`, `torque_constant`, `inertia`, `viscous_friction`, `coulomb_friction`, `static_friction`; with a mass `eccentric_moment`.
/// Those that the recording does not tell are in `untold` of [`Identified`], each with its reason. Beside keys: `lateness`, s, of the recording
/// behind the drive, `current_lateness` of the current alone, and `weight_over_inertia`, m_e g r/J, 1/s².
///
/// `speed_per_volt` is the slope of the steady speed over the voltage; the speed at V volts is `speed_per_volt` (V − `running_volts`).
/// Groups and figures of coils were found within 3 %, and inside their intervals as often as those say, over some hundred simulated recordings at
/// 40 dB. What takes a current is as good where the rotor is slow beside the samples (a coin of 35 ms: 0.1 %). Of a coil that takes samples winding and
/// rotor are fitted in one: of a fast motor with a slow coil (9 ms and 0.4 ms) at 8 kHz resistance was within 0.2 %, inductance 1 %, torque constant 0.03 %,
/// inertia 0.4 % and frictions 0.2 % of the truth, in intervals of 0.6, 2, 0.1, 0.9 and 0.7 % to either side. The noise alone would allow a tenth to a twentieth of
/// that; the ripple of gravity may be what takes the rest, which was not shown.
///
/// Without a `mass`, `inertia` is what a torque meets in a casing that gives way, J − (m_e r)²/M.
///
/// # Errors
/// What is wrong with the recording.
pub fn identify(recording: &Recording) -> Result<Identified, Mistake> {
    let r = recording;
    r.check()?;
    let period = 1.0 / r.drive.rate;
    let volts = r.volts();
    let push = Push { samples: &volts, held: true, open: r.open, period };
    let rotor = Rotor::of(r.acceleration.samples, &push)?;
    let mut all = Identified { signal_to_noise: rotor.signal_to_noise, ..Identified::default() };
    let electric = r.current.as_ref().and_then(|current| Electric::of(r, current.samples, &rotor, &push));
    r.groups(&rotor, electric.as_ref(), &push, &mut all);
    r.start(&rotor, electric.as_ref(), &push, &mut all);
    r.arm(&rotor, &mut all);
    match (&r.current, &electric) {
        (_, Some(electric)) => electric.tell(r, &rotor, &mut all),
        (Some(_), None) => {
            let why = "the current does not belong to voltage and motion: check its channel, its sign, and by how much it is behind the drive";
            ABSOLUTE.iter().for_each(|name| all.untold(name, why));
        }
        (None, None) => {
            let open = r.voltage.as_ref().and_then(|v| of_open(v.samples, &rotor, &push));
            for name in ABSOLUTE {
                match open {
                    Some((k, off)) if name == "torque_constant" => all.key(name, "N m/A", k, [off, off]),
                    _ => all.untold(name, "only groups of it show in the motion: record the current as well"),
                }
            }
            all.untold("static_friction", "without a current only the voltage that overcomes it can be told");
        }
    }
    Ok(all)
}

/// Keys that need a current.
const ABSOLUTE: [&str; 6] =
    ["resistance", "inductance", "torque_constant", "inertia", "viscous_friction", "coulomb_friction"];

impl Recording<'_> {
    fn check(&self) -> Result<(), Mistake> {
        let drive = &self.drive;
        drive.check(Name::Drive, drive)?;
        self.acceleration.check(Name::Acceleration, drive)?;
        for (channel, name) in [(&self.current, Name::Current), (&self.voltage, Name::Voltage)] {
            channel.as_ref().map_or(Ok(()), |channel| channel.check(name, drive))?;
        }
        for (name, delay) in [("delay", self.delay), ("current_delay", self.current_delay)] {
            delay.map_or(Ok(()), |delay| within(name, delay, DELAY, "s"))?;
        }
        self.mass.map_or(Ok(()), |mass| within("mass", mass, MASS, "kg"))?;
        for range in self.open {
            not_negative("open", range.end as f64 - range.start as f64)?;
        }
        Ok(())
    }

    fn is_open(&self, n: usize) -> bool {
        self.open.iter().any(|range| range.contains(&n))
    }

    /// What is at the terminals.
    fn volts(&self) -> Vec<f64> {
        match &self.voltage {
            // A voltage that is measured at the beginning of a sample tells of the time before and behind.
            Some(voltage) => {
                let drive = self.drive.samples;
                // Where the drive jumps, what is measured in that instant is of one side: the next sample is of the right one.
                let behind = |n: usize| voltage.samples[(n + 1).min(drive.len() - 1)];
                (0..drive.len()).map(|n| if self.is_open(n) { 0.0 } else { behind(n) }).collect()
            }
            None => self.drive.samples.to_vec(),
        }
    }

    /// What the motion alone tells.
    fn groups(&self, rotor: &Rotor, electric: Option<&Electric>, push: &Push, all: &mut Identified) {
        let late = rotor.late(push);
        if rotor.switched {
            let (late, off) = late;
            all.aside("lateness", "s", late, off);
        }
        let (slow, off) = rotor.told(|law| 1.0 / law.rate);
        // A rate below 0 is that of no motor, and is not told either.
        let fastest = (FASTEST * slow).max(0.0);
        // The slow one of two time constants is seen; they add up to the mechanical one, but for friction's part of the damping. The fast one
        // shows as lateness, if nothing else makes any.
        let (value, off) = match (electric.map(Electric::times), self.delay) {
            (Some(([least, time, most], friction)), _) => {
                let sum = |fast: f64| (slow - friction * fast) / (1.0 - (fast / slow).min(FASTEST));
                (sum(time), [off + sum(time) - sum(least), off + sum(most) - sum(time)])
            }
            (None, Some(delay)) if rotor.switched => {
                let fast = (late.0 - delay).clamp(0.0, fastest);
                (slow + fast, [off + late.1.min(fast), off + late.1])
            }
            _ => {
                // Most of a large lateness is the recording chain's.
                let most = (late.0 + late.1).clamp(0.0, fastest);
                let likely = (0.5 * most).min(LIKELY * slow);
                (slow + likely, [off + likely, off + most - likely])
            }
        };
        all.key("time_constant", "s", value, off);
        if rotor.single {
            let why = "the drive has one voltage only: record at least two while it runs, or let it run down shorted";
            all.untold("speed_per_volt", why);
            all.untold("running_volts", why);
        } else {
            let (slope, off) = rotor.told(|law| law.gain / law.rate);
            all.key("speed_per_volt", "rad/s/V", slope, [off, off]);
            let (volts, off) = rotor.told(|law| law.drag / law.gain);
            all.key("running_volts", "V", volts, [off, off]);
        }
        let (weight, off) = rotor.gravity;
        all.aside("weight_over_inertia", "1/s2", weight, off + RIPPLE * weight);
    }

    fn arm(&self, rotor: &Rotor, all: &mut Identified) {
        let (arm, off) = rotor.arm;
        if self.is_calibrated {
            all.key("eccentric_per_mass", "m", arm, [off, off]);
            match self.mass {
                Some(mass) => all.key("eccentric_moment", "kg m", arm * mass, [off * mass, off * mass]),
                None => all.untold("eccentric_moment", "only its ratio to all that moves shows: weigh that"),
            }
        } else {
            for name in ["eccentric_per_mass", "eccentric_moment"] {
                all.untold(name, "the accelerometer is not calibrated: record in m/s2");
            }
        }
    }

    /// When it breaks away, on a slow ramp.
    fn start(&self, rotor: &Rotor, electric: Option<&Electric>, push: &Push, all: &mut Identified) {
        let mut enough = f64::INFINITY;
        let mut why = String::from(
            "it shows only where the drive rises slowly from rest until the motor starts: record such a ramp",
        );
        for run in &rotor.runs {
            let Some(Began { at: value, within: [least, most] }) =
                Began::of(self.acceleration.samples, rotor, run, push)
            else {
                continue;
            };
            if !(least > 0.0 && most - least <= WIDE * value) {
                enough = enough.min(most);
                continue;
            }
            // What hangs may be lifted before it goes round: by that much less it may have come loose; and what rests beyond the top falls, by
            // that much more.
            let lift = (rotor.gravity.0 + rotor.gravity.1) / rotor.law.gain.abs();
            if lift > HIDES * value {
                let why = format!(
                    "gravity hides it, between {:.3} and {most:.3} V: lay the motor so that its mass spins in a level plane",
                    (least - lift).max(0.0)
                );
                all.untold("start_volts", why.clone());
                if electric.is_some() {
                    all.untold("static_friction", why);
                }
                return;
            }
            let (least, most) = (least - lift, most + lift);
            all.key("start_volts", "V", value, [value - least, most - value]);
            if let Some(([r, dr], [k, dk])) = electric.map(|e| (e.winding.resistance, e.winding.gain)) {
                let torque = k * value / r;
                let off = (dr / r).hypot(dk / k) * torque;
                let sides = [value - least, most - value].map(|v| k / r * v + off);
                all.key("static_friction", "N m", torque, sides);
            }
            return;
        }
        if enough.is_finite() {
            why = format!("{why}; all that is known is that {enough:.3} V were enough");
        }
        if rotor.gravity.0 > rotor.gravity.1 {
            why = format!(
                "{why}; gravity is in the way: lay the motor so that its mass spins in a level plane"
            );
        }
        all.untold("start_volts", why.clone());
        if electric.is_some() {
            all.untold("static_friction", why);
        }
    }
}

#[cfg(test)]
mod bound;
#[cfg(test)]
mod mistakes;
#[cfg(test)]
mod start;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod wander;
