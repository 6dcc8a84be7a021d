//! Clicks worked out ahead, for every level.
//!
//! A click is solved on the motor's own model, which takes milliseconds; when it is played there is no time for that. So it is solved for
//! some strengths beforehand, and what lies between is interpolated.

use super::coast::Coast;
use super::order::Pieces;
use super::setup::Setup;
use std::f64::consts::TAU;

use crate::actuator::fault::{Fault, Limit, within};
use crate::actuator::link::carrier::Rectifier;
use crate::actuator::link::diodes::Diodes;
use crate::actuator::motor::{Drive, Level, Motor, Parameters, Plan};
use crate::actuator::shape::trial::{PATIENCE, Trial};
use crate::actuator::shape::{Click, Ending, Unreachable, starts};

/// Volts, or amperes, for which clicks are worked out.
const ROWS: usize = 24;

/// Halvings of the way to the strongest click that is fit.
const HALVINGS: usize = 12;

/// Rounds in which it is found how a coil's current goes on; what stands against it, as a share of what it is worth, at least.
const RUNS_ON: usize = 4;
const SLIGHT: f64 = 1e-3;

/// Rounds in which a push is mended by what the diodes themselves make of it; share of the way that is near enough; after how many of its own times
/// a current has ceased.
const ROUNDS: usize = 6;
const NEAR: f64 = 1e-3;
const LASTS: f64 = 30.0;

/// Steps a second at which it is seen how strong a click is.
const RATE: f64 = 48_000.0;

/// Clicks by level.
#[derive(Debug, Clone, PartialEq)]
pub struct Book {
    /// The largest casing acceleration of each, as a share of that at the limit, ascending; and what it is made of.
    rows: Vec<(f64, Pieces)>,
}

impl Book {
    /// Clicks that turn the mass so far (turns, negative backward), from the weakest that turns it to that at the limit. Of a motor that nothing
    /// brakes they are pushes: it is let go so early that it comes to rest there by itself.
    ///
    /// # Errors
    /// A number beyond its limits; a limit at which the motor does not turn that far; a way back where diodes let none.
    pub fn new(setup: &Setup, turns: f64) -> Result<Self, Unreachable> {
        Self::of_those(setup, turns, |_| true)
    }

    /// The same, of those clicks only that are found fit; all of them where not even the weakest is.
    ///
    /// # Errors
    /// As [`Book::new`].
    pub fn of_those(
        setup: &Setup,
        turns: f64,
        is_fit: impl Fn(&Pieces) -> bool,
    ) -> Result<Self, Unreachable> {
        setup.check()?;
        let setup = &setup.on_average();
        // Where the mass hangs is not known: clicks are those of a motor that lies flat.
        let motor = Parameters { gravity: 0.0, ..setup.parameters };
        if setup.one_way && turns < 0.0 {
            let because = "behind diodes the motor turns one way";
            return Err(Fault::because("turns", turns, Limit::Above(0.0), because).into());
        }
        let solve = |amount: f64| -> Result<(Pieces, f64), Unreachable> {
            let drive = setup.drive(amount);
            if setup.one_way {
                let seconds = push(&motor, turns, drive, setup.diode_drop)?;
                let steps = (seconds * RATE).ceil().max(1.0) as usize;
                let strength = strength(setup, &motor, &vec![amount; steps])?;
                return Ok((Pieces { list: [(seconds, amount), (0.0, 0.0), (0.0, 0.0)] }, strength));
            }
            let click = Click { turns, drive, angle: 0.0, ending: Ending::Settled }.solve(&motor)?;
            let strength = strength(setup, &motor, &click.course.means(RATE).unwrap_or_default())?;
            Ok((pieces(click.seconds, amount.copysign(turns)), strength))
        };
        let starts = starts(&motor, setup.drive(setup.limit)).amount();
        let least = (1.2 * starts).min(setup.limit);
        // Closer to one another where they are weak: there the times change fastest.
        let amount = |n: usize, most: f64| least + (most - least) * (n as f64 / (ROWS - 1) as f64).powi(2);
        let fit = |amount: f64| solve(amount).ok().filter(|(click, _)| is_fit(click));
        let mut limit = setup.limit;
        let (mut strongest, mut most) = solve(limit)?;
        let mut are_fit = is_fit(&strongest);
        if !are_fit && let Some(n) = (0..ROWS - 1).rev().find(|n| fit(amount(*n, limit)).is_some()) {
            are_fit = true;
            let (mut low, mut high) = (amount(n, limit), amount(n + 1, limit));
            (strongest, most) = solve(low)?;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                match fit(middle) {
                    Some(found) => (low, (strongest, most)) = (middle, found),
                    None => high = middle,
                }
            }
            limit = low;
        }
        let mut rows = Vec::with_capacity(ROWS);
        for n in 0..ROWS - 1 {
            let found = if are_fit { fit(amount(n, limit)) } else { solve(amount(n, limit)).ok() };
            rows.extend(found.map(|(click, strength)| (strength / most, click)));
        }
        rows.push((1.0, strongest));
        rows.dedup_by(|next, row| next.0 <= row.0);
        Ok(Self { rows })
    }

    /// Those that were worked out, the weakest first.
    pub fn clicks(&self) -> impl Iterator<Item = &Pieces> {
        self.rows.iter().map(|(_, click)| click)
    }

    /// The click of a level: its largest acceleration as a share of that at the limit, backward where it is negative; the weakest there is
    /// where it is weaker than that. `None` for 0 and for what is no number.
    pub fn at(&self, level: f64) -> Option<Pieces> {
        let size = level.abs().min(1.0);
        if size == 0.0 || size.is_nan() {
            return None;
        }
        let above = self.rows.partition_point(|(strength, _)| *strength < size);
        let (_, high) = self.rows.get(above).or(self.rows.last())?;
        let mut click = *high;
        if let (Some((from, low)), Some((to, _))) =
            (above.checked_sub(1).and_then(|n| self.rows.get(n)), self.rows.get(above))
        {
            let share = (size - from) / (to - from);
            for (piece, low) in click.list.iter_mut().zip(&low.list) {
                *piece = (low.0 + share * (piece.0 - low.0), low.1 + share * (piece.1 - low.1));
            }
        }
        for piece in &mut click.list {
            piece.1 *= level.signum();
        }
        Some(click)
    }

    /// The strongest there is.
    pub fn strongest(&self) -> Pieces {
        self.rows.last().map_or(Pieces::default(), |(_, click)| *click)
    }

    /// The level of the weakest there is.
    pub fn weakest(&self) -> f64 {
        self.rows.first().map_or(1.0, |(strength, _)| *strength)
    }
}

/// For how long a drive pushes the mass through diodes, which take `drop` volts, so that it has turned so far when it stands, s.
fn push(motor: &Parameters, turns: f64, drive: Drive, drop: f64) -> Result<f64, Unreachable> {
    within("turns", turns, (1e-4, 1000.0), "turns")?;
    let (coast, far) = (Coast::new(motor), TAU * turns);
    let mut trial = Trial::new(motor, 0.0, RATE)?;
    let left = |motor: &Motor| {
        let (speed, turned) = runs_on(motor, drop);
        far - motor.turned() - turned - coast.angle(speed)
    };
    let seconds = trial.until(drive, PATIENCE, left).ok_or_else(|| match trial.motor.is_stuck() {
        true => Unreachable::Start(drive, starts(motor, drive)),
        false => Unreachable::Slow(drive, PATIENCE),
    })?;
    if motor.inductance == 0.0 {
        return Ok(seconds);
    }
    // How its current goes on was taken from its mean speed: by the diodes themselves it is found out how far off that is.
    let off = |seconds: f64| reached(motor, seconds, drive, drop).map(|turned| turned - far);
    let mut best = (seconds, off(seconds)?);
    let mut other = (0.95 * seconds, if best.1.abs() > NEAR * far { off(0.95 * seconds)? } else { 0.0 });
    for _ in 0..ROUNDS {
        let next = best.0 - best.1 * (best.0 - other.0) / (best.1 - other.1);
        if best.1.abs() <= NEAR * far || !(next > 0.0 && next < PATIENCE) {
            break;
        }
        other = std::mem::replace(&mut best, (next, off(next)?));
    }
    Ok(best.0)
}

/// How far a push of so many seconds turns the mass until it stands, rad, its current going on through the diodes.
fn reached(motor: &Parameters, seconds: f64, drive: Drive, drop: f64) -> Result<f64, Unreachable> {
    let mut trial = Trial::new(motor, 0.0, RATE)?;
    trial.run(seconds, drive);
    let diodes = Diodes::new(Rectifier { full_wave: true, drop }, RATE);
    let motor = &mut trial.motor;
    let p = *motor.parameters();
    // At rest behind ideal diodes it would go on for ever, as less and less.
    let most = (LASTS * p.electrical_time()).min(PATIENCE) * RATE;
    for _ in 0..most as u64 {
        if motor.current() <= 0.0 || (motor.is_stuck() && motor.current() * p.gain < p.stiction) {
            break;
        }
        diodes.step(motor, 0.0, |_, _, _| {});
    }
    Ok(motor.turned() + Coast::new(&p).angle(motor.speed()))
}

/// What the coil does after a push, as its current goes on through diodes that take `drop` volts: the speed (rad/s) when it has ceased, and how far the mass has
/// turned by then (rad). With what the motor makes itself as it is on average meanwhile, i = (i₀ + u/R) e^(−s R/L) − u/R until t = (L/R) ln(1 + R i₀/u).
fn runs_on(motor: &Motor, drop: f64) -> (f64, f64) {
    let p = motor.parameters();
    let (current, before) = (motor.current(), motor.speed());
    if !(p.inductance > 0.0 && current > 0.0) {
        return (before, 0.0);
    }
    let (time, inertia) = (p.electrical_time(), p.effective_inertia());
    let (mut mean, mut runs) = (before, (before, 0.0));
    for _ in 0..RUNS_ON {
        // At rest behind ideal diodes it would go on for ever, as less and less.
        let against = ((drop + p.gain * mean.max(0.0)) / p.resistance).max(SLIGHT * current);
        let seconds = time * (current / against).ln_1p();
        let slows = p.viscous * mean + p.coulomb;
        // ∫ i and ∬ i, of which e^(−t R/L) is u/(u + R i₀).
        let once = time * current - against * seconds;
        let twice =
            time * ((current + against) * seconds - time * current) - 0.5 * against * seconds * seconds;
        let gained = (p.gain * once - slows * seconds) / inertia;
        let turned = before * seconds + (p.gain * twice - 0.5 * slows * seconds * seconds) / inertia;
        runs = ((before + gained).max(0.0), turned.max(0.0));
        mean = runs.1 / seconds;
    }
    runs
}

fn pieces(seconds: [f64; 3], amount: f64) -> Pieces {
    Pieces { list: [(seconds[0], amount), (seconds[1], -amount), (seconds[2], amount)] }
}

/// What the casing's largest acceleration goes with: √(ω⁴ + α²).
fn strength(setup: &Setup, motor: &Parameters, means: &[f64]) -> Result<f64, Unreachable> {
    let mut motor: Motor = Motor::new(motor, &Plan { casing: false, ..Plan::whole(Level::Default) }, RATE)?;
    let mut most = 0.0_f64;
    for mean in means {
        motor.drive(setup.drive(*mean));
        let before = motor.angular_acceleration();
        most = most.max((motor.speed() * motor.speed()).hypot(before));
        motor.step();
    }
    Ok(most)
}

#[cfg(test)]
mod tests {
    use super::{Diodes, Drive, Level, Motor, Parameters, Plan, Rectifier, TAU, push};

    /// Behind the diodes themselves, a push turns the mass as far as it is to: also where the coil keeps its current for longer than the mass is pushed.
    #[test]
    fn a_push_counts_with_what_the_coil_keeps() {
        let rate = 192_000.0;
        for inductance in [0.0, 1e-4, 4e-3, 2e-2, 6e-2] {
            for drop in [0.0, 0.7, 1.4] {
                for (turns, volts) in [(0.25, 6.0), (0.25, 1.2), (1.0, 4.0), (0.02, 6.0)] {
                    let p = Parameters {
                        resistance: 10.42,
                        inductance,
                        gain: 0.011,
                        inertia: 1.15e-7,
                        viscous: 1e-6,
                        coulomb: 6e-4,
                        stiction: 8e-4,
                        gravity: 0.0,
                        ..Parameters::COIN
                    };
                    let Ok(seconds) = push(&p, turns, Drive::Voltage(volts), drop) else {
                        panic!("{inductance} {drop} {turns} {volts}")
                    };
                    let mut motor = Motor::<false>::new(&p, &Plan::whole(Level::Default), rate).unwrap();
                    let diodes = Diodes::new(Rectifier { full_wave: false, drop }, rate);
                    let whole = (seconds * rate) as usize;
                    (0..whole).for_each(|_| diodes.step(&mut motor, volts + drop, |_, _, _| {}));
                    diodes.part(&mut motor, volts + drop, (seconds * rate).fract(), |_, _, _| {});
                    let mut steps = 0;
                    while !(motor.is_stuck() && motor.current() * p.gain < p.stiction) && steps < 400_000 {
                        diodes.step(&mut motor, 0.0, |_, _, _| {});
                        steps += 1;
                    }
                    let is = motor.turned() / TAU;
                    assert!((is / turns - 1.0).abs() < 3e-3, "{inductance} {drop} {turns} {volts}: {is}");
                }
            }
        }
    }
}
