//! What of a motor's click gets through coupling.

use std::f64::consts::TAU;

use super::plan::Drive;
use crate::actuator::driver::order::{Order, Pieces};
use crate::actuator::driver::setup::{Setup, Shaping};
use crate::actuator::driver::turner::Turner;
use crate::actuator::link::coupling::{Corners, HighPass};
use crate::actuator::motor::Parameters;
use crate::actuator::shape::Course;

/// Seconds after which a mass that does not come to rest is left as it is.
const PATIENCE: f64 = 5.0;

/// Of a click's volt-seconds behind coupling, sent by samples of no more than `most`, `rate` a second, the share that does not arrive.
pub fn missing(drive: &Drive, corners: &Corners, rate: f64, most: f64, click: &Pieces) -> f64 {
    let nothing = drive.setup.drive(0.0);
    let course = click.list.iter().fold(Course::ending_in(nothing), |course, (seconds, amount)| {
        course.then(*seconds, nothing.with(*amount))
    });
    let (before, coupling) =
        (drive.setup.through(corners, rate, drive.per_sample), HighPass::new(corners, rate));
    // What cannot be is refused where it is to be played.
    let (Ok(mut before), Ok(mut coupling)) = (before, coupling) else { return 0.0 };
    let (mut off, mut own) = (0.0, 0.0);
    for mean in course.means(rate).unwrap_or_default() {
        let wanted = mean / drive.per_sample;
        off += (coupling.step(before.step(Some(wanted), most)) - wanted).abs();
        own += wanted.abs();
    }
    if own > 0.0 { off / own } else { 0.0 }
}

/// How far such a click turns the mass of a motor that lies flat and that nothing has moved before, turns. What was cut of it is known to what
/// sends it, which brakes accordingly.
pub fn turns(drive: &Drive, corners: &Corners, rate: f64, most: f64, click: &Pieces) -> f64 {
    let flat = Parameters { gravity: 0.0, ..drive.setup.parameters };
    let setup = Setup { parameters: flat, shaping: Shaping::Clicks, ordered: true, ..drive.setup };
    let before = setup.through(corners, rate, drive.per_sample);
    let (Ok(mut turner), Ok(mut before)) = (Turner::new(&setup, 0), before) else { return 0.0 };
    turner.order(0.0, 0, Order::Click(*click));
    let frames = (rate / setup.rate).round().clamp(1.0, 1024.0) as usize;
    let (mut sent, mut arriving) = (vec![0.0; frames], vec![0.0; frames]);
    for _ in 0..(PATIENCE * setup.rate) as usize {
        turner.step(0.0, &mut sent);
        if turner.is_idle() && before.is_idle() {
            break;
        }
        let (rests, mut short) = (turner.rests(), false);
        for (sent, arriving) in sent.iter().zip(&mut arriving) {
            before.step((*sent != 0.0 || !rests).then_some(sent / drive.per_sample), most);
            *arriving = before.arrived() * drive.per_sample;
            short |= before.is_short();
        }
        if short {
            turner.arrived(&arriving);
        }
    }
    let reading = turner.motor().map(|motor| motor.reading());
    reading.map_or(0.0, |now| now.turns + now.angle / TAU)
}
