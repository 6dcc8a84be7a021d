//! One wish, driven in several ways.

use super::bench::{Bench, Given, Run};
use super::figures::Figures;
use super::wish::{Envelope, Wish};
use crate::actuator::fault::{Fault, within};
use crate::actuator::motor::{Drive, Parameters};
use crate::actuator::shape::{Click, Clicked, Course, Ending, Inverse, Spin, Switching, Unreachable};

/// A way to drive a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// The voltage that holds the speed, and a short circuit behind it.
    Plain,
    /// All the voltage there is until the speed is reached, and all of it backward at the end.
    Overdrive,
    /// Inverse dynamics: the voltage that makes the motor follow.
    Inverse,
    /// All the voltage there is, one way or the other.
    Switching,
    /// Forward, then backward until it stands, for a part of a turn.
    Click,
    /// On for as long as a click, and a short circuit behind it.
    Pulse,
    /// What somebody wrote.
    Own,
}

impl Way {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Overdrive => "overdrive",
            Self::Inverse => "inverse",
            Self::Switching => "switching",
            Self::Click => "click",
            Self::Pulse => "pulse",
            Self::Own => "drive",
        }
    }
}

/// A way, and what came of it.
#[derive(Debug, Clone)]
pub struct Row {
    /// Which.
    pub way: Way,
    /// What the motor did, or why it cannot be driven so.
    pub done: Result<Done, Unreachable>,
}

/// What a motor did in one of the ways.
#[derive(Debug, Clone)]
pub struct Done {
    /// What was done to the terminals.
    pub given: Given,
    /// What the motor did.
    pub run: Run,
    /// What is read off that.
    pub figures: Figures,
    /// By how much it must know ahead what is wanted, s: it brakes that long before the wish falls.
    pub look_ahead: f64,
    /// For a click: how it was worked out.
    pub click: Option<Clicked>,
}

/// How a burst is driven, with so many volts at most.
type Drives = fn(&Bench, &Wish, f64) -> Result<Done, Unreachable>;

/// Share of the speed at the voltage's limit that a spin may aim at: the whole of it is reached never.
const NEARLY: f64 = 0.99;

impl Done {
    fn new(bench: &Bench, given: Given, wish: Option<&Wish>, end: f64) -> Result<Self, Unreachable> {
        let run = bench.run(&given, end)?;
        let figures = Figures::new(bench, &run, wish, end);
        Ok(Self { given, run, figures, look_ahead: 0.0, click: None })
    }
}

/// A burst in the ways in which one can be driven, with no more than `limit` volts either way: plain, overdrive, inverse, switching. An
/// overdriven one has one speed and cannot follow an envelope: it is there for rectangles only.
///
/// # Errors
/// A number of the wish or the limit beyond its bounds; what a way cannot do stands in its row.
pub fn bursts(bench: &Bench, wish: &Wish, limit: f64) -> Result<Vec<Row>, Fault> {
    wish.check()?;
    within("volts", limit, (1e-6, 1e6), "V")?;
    let ways: [(Way, Drives); 4] = [
        (Way::Plain, plain),
        (Way::Overdrive, overdrive),
        (Way::Inverse, inverse),
        (Way::Switching, switching),
    ];
    let fits = |way: Way| way != Way::Overdrive || wish.envelope == Envelope::Rectangle;
    let rows = ways.into_iter().filter(|(way, _)| fits(*way));
    Ok(rows.map(|(way, drive)| Row { way, done: drive(bench, wish, limit) }).collect())
}

/// A click of so many turns by a drive of so many volts, or amperes, and a pulse of the same length.
///
/// # Errors
/// A drive beyond its bounds; what cannot be done stands in its row.
pub fn clicks(bench: &Bench, turns: f64, drive: Drive) -> Result<Vec<Row>, Fault> {
    let click = Click { turns, drive, angle: bench.angle, ending: Ending::Settled };
    let clicked = match click.solve(&bench.parameters) {
        Ok(clicked) => clicked,
        Err(Unreachable::Fault(fault)) => return Err(fault),
        Err(why) => return Ok(vec![Row { way: Way::Click, done: Err(why) }]),
    };
    let seconds = clicked.course.duration();
    let done = |course: Course| Done::new(bench, Given::Course(course), None, seconds);
    let forward = drive.with(drive.amount().abs().copysign(turns));
    let pulse = done(Course::ending_in(drive.with(0.0)).then(seconds, forward));
    let click = done(clicked.course.clone()).map(|done| Done { click: Some(clicked), ..done });
    Ok(vec![Row { way: Way::Click, done: click }, Row { way: Way::Pulse, done: pulse }])
}

/// A course that somebody wrote.
pub fn own(bench: &Bench, course: &Course) -> Row {
    Row { way: Way::Own, done: Done::new(bench, Given::Course(course.clone()), None, course.duration()) }
}

fn plain(bench: &Bench, wish: &Wish, limit: f64) -> Result<Done, Unreachable> {
    let held = |speed: f64| held_within(&bench.parameters, speed, limit);
    let given = match wish.envelope {
        Envelope::Rectangle => {
            let volts = held(bench.parameters.rated_speed() * wish.level.sqrt());
            Given::Course(Course::on(volts, wish.seconds))
        }
        Envelope::RaisedCosine => {
            let speeds = wish.speeds(&bench.parameters, bench.rate);
            Given::Samples(speeds.iter().skip(1).map(|speed| held(*speed)).collect())
        }
    };
    Done::new(bench, given, Some(wish), wish.seconds)
}

/// The voltage at which a motor runs at a speed, (B ω + T_c) R/k, as far as there is one.
fn held_within(p: &Parameters, speed: f64, limit: f64) -> f64 {
    let torque = p.damping() * speed + if speed > 0.0 { p.coulomb } else { 0.0 };
    (torque * p.resistance / p.gain).min(limit)
}

fn overdrive(bench: &Bench, wish: &Wish, limit: f64) -> Result<Done, Unreachable> {
    let p = &bench.parameters;
    if limit < p.start_volts() && p.steady_speed(limit) == 0.0 {
        return Err(Unreachable::Start(Drive::Voltage(limit), Drive::Voltage(p.start_volts())));
    }
    let speed = (p.rated_speed() * wish.level.sqrt()).min(NEARLY * p.steady_speed(limit));
    let course = Spin { speed, seconds: wish.seconds, volts: limit, angle: bench.angle }.solve(p)?;
    Done::new(bench, Given::Course(course), Some(wish), wish.seconds)
}

fn inverse(bench: &Bench, wish: &Wish, limit: f64) -> Result<Done, Unreachable> {
    let p = &bench.parameters;
    let angle = (p.gravity > 0.0).then_some(bench.angle);
    let inverse = Inverse { parameters: *p, limit, rate: bench.rate, angle };
    let wished = wish.speeds(p, bench.rate);
    let shaped = inverse.shape(&wished)?;
    let look_ahead = ahead(&wished, &shaped.speeds) as f64 / bench.rate;
    let done = Done::new(bench, Given::Samples(shaped.volts), Some(wish), wish.seconds)?;
    Ok(Done { look_ahead, ..done })
}

/// The most samples in a row in which an aim falls and is below the wish.
fn ahead(wished: &[f64], aimed: &[f64]) -> usize {
    let falls = |n: usize| aimed[n + 1] < aimed[n] && aimed[n] < wished[n] * (1.0 - 1e-9);
    let mut most = 0;
    let mut row = 0;
    for n in 0..aimed.len().min(wished.len()).saturating_sub(1) {
        row = if falls(n) { row + 1 } else { 0 };
        most = most.max(row);
    }
    most
}

fn switching(bench: &Bench, wish: &Wish, limit: f64) -> Result<Done, Unreachable> {
    let p = &bench.parameters;
    let mut wished = wish.speeds(p, bench.rate).split_off(1);
    let samples = wished.len();
    // What brakes a motor from there takes no longer: τ ln(1 + ω B/(k V/R)), and the coil.
    let fastest = p.rated_speed();
    let brake = p.mechanical_time() * (fastest * p.damping() / p.stall_torque(limit)).ln_1p();
    let more = ((brake + 10.0 * p.electrical_time()) * bench.rate).ceil().min(1e7) as usize + 1;
    wished.resize(samples + more, 0.0);
    let switching = Switching {
        parameters: *p,
        volts: limit,
        rate: bench.rate,
        pull: 0.0,
        band: 0.0,
        angle: bench.angle,
    };
    let (mut volts, speeds) = switching.shape(&wished)?;
    // As soon as the model has turned the other way, or rests, there is nothing left to brake.
    let over = speeds.iter().skip(samples).position(|speed| *speed <= 0.0);
    volts.truncate(over.map_or(volts.len(), |over| samples + over));
    Done::new(bench, Given::Samples(volts), Some(wish), wish.seconds)
}

#[cfg(test)]
mod tests;
