//! The motors of a rig, and the clicks of them that the voices of a patch may order.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::arrival;
use super::command::Command;
use super::plan::{Clicks, Drive, Instrument, LeftOut, Why};
use super::program::Op;
use crate::actuator::driver::book::Book;
use crate::actuator::driver::homing::Homing;
use crate::actuator::driver::order::Pieces;
use crate::actuator::driver::setup::Shaping;
use crate::actuator::fault::Fault;
use crate::actuator::link::wave::HIGHEST;
use crate::actuator::protect::bounds::Bounds;
use crate::actuator::protect::budget::Bears;
use crate::actuator::protect::kernel::Protection;
use crate::actuator::shape::Unreachable;
use crate::rig::terminals::too_high;
use crate::rig::{Output, Rig, Terminals};
use crate::text::Problem;

/// Where no more of a click than that share of its turns is left it is none.
const LOST: f64 = 0.5;

/// Of what is ordered, what makes no difference between clicks that do not arrive whole.
const ALIKE: f64 = 0.02;

/// A share of a click below that is rounding.
const ROUNDING: f64 = 1e-9;

/// A motor that cannot be brought home, by its place among the drives, and why.
type Homeless = (usize, Arc<str>);

/// The motors of a rig, at an engine's rate and a device's.
pub fn drives(rig: &Rig, [rate, device_rate]: [f64; 2], problems: &mut Vec<Problem>) -> Vec<Drive> {
    let mut drives = Vec::new();
    for output in &rig.outputs {
        match rig.wiring(output) {
            Some(Ok(wiring)) => {
                if let Terminals::Carrier(carrier) = wiring.terminals
                    && carrier.hertz > HIGHEST * device_rate
                {
                    let problem = too_high(output, carrier.hertz, device_rate);
                    problems.push(Problem { span: None, ..problem });
                    continue;
                }
                drives.push(Drive {
                    channel: output.channel.saturating_sub(1),
                    setup: wiring.setup(rate),
                    per_sample: wiring.per_sample,
                    terminals: wiring.terminals,
                    bears: bears(rig, output, problems),
                });
            }
            Some(Err(problem)) => problems.push(Problem { span: None, ..problem }),
            None => {}
        }
    }
    drives
}

/// What a motor bears for long, where what turns it has to see to that.
fn bears(rig: &Rig, output: &Output, problems: &mut Vec<Problem>) -> Option<Bears> {
    let bears = rig.bears(output)?;
    let cannot = |fault: Fault| problems.push(cannot_keep(output, &fault));
    bears.check().map_err(cannot).is_ok().then_some(bears)
}

/// That what an actuator bears cannot be kept to.
fn cannot_keep(output: &Output, fault: &Fault) -> Problem {
    Problem::of_file(format!(
        "what the actuator of output `{}` bears cannot be kept to: {fault}",
        output.name
    ))
}

/// What the actuators of a rig bear, at a device's rate.
pub fn protections(rig: &Rig, rate: f64, problems: &mut Vec<Problem>) -> Vec<(u32, Bounds)> {
    let mut all = Vec::new();
    for output in &rig.outputs {
        let Some(bounds) = rig.bounds(output) else { continue };
        match Protection::new(&bounds, rate) {
            Ok(_) => all.push((output.channel.saturating_sub(1), bounds)),
            Err(fault) => problems.push(cannot_keep(output, &fault)),
        }
    }
    all
}

/// What instruments order where there is no motor.
pub fn for_nobody(instruments: &[Instrument]) -> impl Iterator<Item = LeftOut> {
    instruments.iter().flat_map(|instrument| {
        let orders = |op: &&Op| Command::of(op.node.kind, &op.node.settings).is_some();
        instrument.program.ops.iter().filter(orders).map(|op| LeftOut {
            what: format!("order `{}` of `{}`", op.node.name, instrument.name),
            why: Why::NoMotor,
        })
    })
}

/// What instruments order of motors that are there for clicks alone.
pub fn for_clicks_alone(rig: &Rig, drives: &[Drive], instruments: &[Instrument]) -> Vec<LeftOut> {
    let alone = drives.iter().filter(|drive| drive.setup.shaping == Shaping::Clicks);
    let names: Vec<String> = alone.map(|drive| format!("`{}`", name_of(rig, drive))).collect();
    if names.is_empty() {
        return Vec::new();
    }
    let orders = |op: &&Op| {
        Command::of(op.node.kind, &op.node.settings).is_some_and(|command| !command.is_heeded_for_clicks())
    };
    let of = |instrument: &Instrument| -> Vec<LeftOut> {
        let what =
            |op: &Op| format!("order `{}` of `{}` on {}", op.node.name, instrument.name, names.join(", "));
        let orders = instrument.program.ops.iter().filter(orders);
        orders.map(|op| LeftOut { what: what(op), why: Why::ClicksAlone }).collect()
    };
    instruments.iter().flat_map(of).collect()
}

/// A motor's output.
fn of_channel<'a>(rig: &'a Rig, drive: &Drive) -> Option<&'a Output> {
    rig.outputs.iter().find(|output| output.channel == drive.channel + 1)
}

/// The name of a motor's output.
pub(super) fn name_of<'a>(rig: &'a Rig, drive: &Drive) -> &'a str {
    of_channel(rig, drive).map_or("", |output| output.name.as_str())
}

/// The way home of every motor that has one, where an instrument may order it, and why of the others; of motors that are alike it is worked out
/// once. That none has one is a problem; an order to one that has none is nothing, and is counted.
pub fn homes(
    rig: &Rig,
    drives: &[Drive],
    instruments: &[Instrument],
    problems: &mut Vec<Problem>,
) -> (Vec<(usize, Homing)>, Vec<Homeless>) {
    let mut homes: Vec<(usize, Homing)> = Vec::new();
    let mut homeless: Vec<Homeless> = Vec::new();
    let sends = |instrument: &&Instrument| {
        instrument.commands().iter().any(|command| matches!(command, Command::Home))
    };
    let Some(instrument) = instruments.iter().find(sends) else { return (homes, homeless) };
    for (number, drive) in drives.iter().enumerate() {
        let alike =
            homes.iter().find(|(known, _)| drives.get(*known).is_some_and(|d| d.setup == drive.setup));
        let home = match alike {
            _ if drive.setup.shaping == Shaping::Clicks => {
                Err("it is there for clicks alone: shaping = \"clicks\"".to_string())
            }
            _ if matches!(drive.terminals, Terminals::Bridge(_)) => {
                Err("the pulses of a bridge shake loose what gravity caught".into())
            }
            Some((_, home)) => Ok(*home),
            None => Homing::new(&drive.setup).map_err(|why| why.to_string()),
        };
        match home {
            Ok(home) => homes.push((number, home)),
            Err(why) => homeless.push((number, why.into())),
        }
    }
    let refused = homeless.first().and_then(|(number, why)| drives.get(*number).zip(Some(why)));
    if let (true, Some((drive, why))) = (homes.is_empty(), refused) {
        let what = format!(
            "voice `{}` sends motors home, where the mass of that of `{}` cannot be brought: {why}",
            instrument.name,
            name_of(rig, drive)
        );
        let help =
            "an upright plane (tilt = 0.0) and a steady voltage are what it takes; or leave `drive-home` out";
        problems.push(Problem::of_file(what).help(help.to_string()));
    }
    (homes, homeless)
}

/// The clicks that instruments may order, of every motor; of motors that are alike they are worked out once.
pub fn clicks(
    rig: &Rig,
    drives: &[Drive],
    device_rate: f64,
    instruments: &[Instrument],
    problems: &mut Vec<Problem>,
) -> Vec<Clicks> {
    let mut clicks: Vec<Clicks> = Vec::new();
    for instrument in instruments {
        for command in instrument.commands() {
            let Command::Click(turns) = command else { continue };
            for (number, drive) in drives.iter().enumerate() {
                if clicks.iter().any(|known| known.drive == number && known.turns == turns) {
                    continue;
                }
                let most = of_channel(rig, drive).map_or(1.0, |output| rig.max_level(output));
                let alike = |known: &&Clicks| {
                    let is_alike = |other: &Drive| {
                        let most_there = of_channel(rig, other).map_or(1.0, |output| rig.max_level(output));
                        *other == Drive { channel: other.channel, ..*drive } && most_there == most
                    };
                    known.turns == turns && drives.get(known.drive).is_some_and(is_alike)
                };
                let found = match clicks.iter().find(alike) {
                    Some(known) => Ok(Clicks { drive: number, ..known.clone() }),
                    None => worked_out(drive, turns, device_rate, most).map(|(book, arriving)| Clicks {
                        drive: number,
                        turns,
                        book: Arc::new(book),
                        arriving,
                    }),
                };
                match found {
                    Ok(found) if found.arriving / turns < LOST => {
                        let what = format!(
                            "voice `{}` orders a click of {turns} turns, of which the coupling to the motor of `{}` lets no more than {:.2} through",
                            instrument.name,
                            name_of(rig, drive),
                            found.arriving
                        );
                        let help = "order a shorter one, or give it more room: a larger `max_level`, `full_scale_volts` or `gain`";
                        problems.push(Problem::of_file(what).help(help.to_string()));
                        return clicks;
                    }
                    Ok(found) => clicks.push(found),
                    Err(why) => {
                        let name = name_of(rig, drive);
                        let voice = &instrument.name;
                        let what = format!(
                            "voice `{voice}` orders a click of {turns} turns, which the motor of `{name}` cannot make: {why}"
                        );
                        let help = match why {
                            _ if drive.setup.one_way && turns < 0.0 => {
                                "behind a rectifier every click goes forward: give it `turns` above 0"
                            }
                            Unreachable::Fault(_) => {
                                "give its node `drive-click` other `turns`: a click takes some"
                            }
                            _ => "give the motor more volts, or order another click",
                        }
                        .to_string();
                        problems.push(Problem::of_file(what).help(help));
                        // Told of once for each motor.
                        return clicks;
                    }
                }
            }
        }
    }
    clicks
}

/// The clicks of a motor, and how far the strongest turns its mass. Behind coupling the strongest is one that can be made up for.
fn worked_out(drive: &Drive, turns: f64, rate: f64, most: f64) -> Result<(Book, f64), Unreachable> {
    let Terminals::Coupled(corners) = drive.terminals else {
        return Ok((Book::new(&drive.setup, turns)?, turns));
    };
    // A click that begins between two samples needs the room of one more.
    let turns_a_sample: f64 = corners.hertz().iter().map(|hertz| TAU * hertz / rate).sum();
    let room = most / (1.0 + 2.0 * turns_a_sample);
    let is_whole = |click: &Pieces| arrival::missing(drive, &corners, rate, room, click) < ROUNDING;
    let book = Book::of_those(&drive.setup, turns, is_whole)?;
    if is_whole(&book.strongest()) {
        return Ok((book, turns));
    }
    // Those that lose least, then.
    let arriving = |click: &Pieces| arrival::turns(drive, &corners, rate, most, click);
    let best = book.clicks().map(|click| arriving(click) / turns).fold(f64::NEG_INFINITY, f64::max);
    let book = Book::of_those(&drive.setup, turns, |click| arriving(click) / turns > best - ALIKE)?;
    let arriving = arriving(&book.strongest());
    Ok((book, arriving))
}
