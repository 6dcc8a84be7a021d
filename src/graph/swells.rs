//! The envelopes that the voices of a patch may order of motors.

use std::sync::Arc;

use super::command::Command;
use super::motors::name_of;
use super::plan::{Drive, Instrument, Swell};
use super::{Settings, plan};
use crate::actuator::driver::setup::Shaping;
use crate::actuator::driver::track::Track;
use crate::actuator::fault::Fault;
use crate::node::course::Course;
use crate::rig::Rig;
use crate::text::Problem;

/// Those of every motor, but for those that are there for clicks alone; of motors that are alike each is worked out once.
pub fn swells(
    rig: &Rig,
    drives: &[Drive],
    instruments: &[Instrument],
    problems: &mut Vec<Problem>,
) -> Vec<plan::Swell> {
    let mut swells: Vec<Swell> = Vec::new();
    for instrument in instruments {
        for command in instrument.commands() {
            let Command::Swell(settings, _) = command else { continue };
            for (number, drive) in drives.iter().enumerate() {
                let is_same = |known: &&Swell| known.settings.points == settings.points;
                let mut known = swells.iter().filter(is_same);
                if drive.setup.shaping == Shaping::Clicks || known.clone().any(|known| known.drive == number)
                {
                    continue;
                }
                let alike =
                    known.find(|known| drives.get(known.drive).is_some_and(|d| d.setup == drive.setup));
                let track = match alike {
                    Some(known) => Ok(Arc::clone(&known.track)),
                    None => worked_out(drive, &settings).map(Arc::new),
                };
                match track {
                    Ok(track) => swells.push(Swell {
                        drive: number,
                        voice: Arc::clone(&instrument.name),
                        settings: Arc::clone(&settings),
                        track,
                    }),
                    Err(why) => {
                        let what = format!(
                            "voice `{}` orders an envelope that the motor of `{}` cannot be given: {why}",
                            instrument.name,
                            name_of(rig, drive)
                        );
                        let help = "the points of a node `drive-swell` take from 0.1 ms to 10 s";
                        problems.push(Problem::of_file(what).help(help.to_string()));
                        return swells;
                    }
                }
            }
        }
    }
    swells
}

/// That of a motor: from 0 through the points and to 0.
fn worked_out(drive: &Drive, settings: &Settings) -> Result<Track, Fault> {
    let (mut course, mut before) = (Course::new(), 0.0_f64);
    for point in &settings.points {
        let at = point.at.max(before);
        course.ramp(point.value, at - before, point.curve);
        before = at;
    }
    Track::new(&drive.setup, before, |t| course.at(t))
}
