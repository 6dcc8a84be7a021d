//! From the recording and its drive to what the library makes of both.

use super::super::failure::Failure;
use super::super::motor::ms;
use super::Identify;
use super::late::{Delay, fitted, followed};
use super::short::{belongs, too_short};
use super::take::{Take, Trace};
use super::target::Target;
use pacinian::actuator::identify::{Channel, Identified, Mistake, Name, motor, resonant};
use pacinian::report::decimate::Decimator;
use std::ops::Range;

/// What was found, and how.
#[derive(Debug)]
pub struct Found {
    /// What the library says.
    pub all: Identified,
    /// Seconds by which the answer is behind the drive, where that is told.
    pub delay: Option<f64>,
    /// Seconds by which the acceleration is behind the drive that came back on a channel, where that is more than an actuator makes and nobody
    /// said it.
    pub later: Option<f64>,
    /// Seconds of the recording before the drive, and behind it, that were left out.
    pub left_out: [f64; 2],
    /// Seconds of the drive of which there is no recording, before and behind.
    pub missed: [f64; 2],
    /// Volts at most.
    pub peak: f64,
}

/// Samples a second that suffice for a motor, and for a resonance.
const ENOUGH: [f64; 2] = [8000.0, 16_000.0];
/// By how much sooner than it seems an answer may have begun to ring, s.
const SOONER: f64 = 0.02;
/// How often a motor is fitted again with the delay that it showed.
const AGAIN: usize = 4;
/// The part of its time constant by which a motor's coil may be late, and how exactly that much is left to it.
const HIDDEN: f64 = 0.05;
const NOTICED: f64 = 0.01;
/// Samples that must be left.
const LEAST: usize = 64;

/// The part of drive and recording that belong together.
struct Cut {
    drive: Vec<f64>,
    acceleration: Trace,
    current: Option<Trace>,
    voltage: Option<Trace>,
    open: Vec<Range<usize>>,
    rate: f64,
    left_out: [f64; 2],
    missed: [f64; 2],
}

/// Fits it.
///
/// # Errors
/// What is wrong with the recording.
pub fn fit(asked: &Identify, take: &Take, target: &Target) -> Result<Found, Failure> {
    if asked.delay.is_some() && matches!(take.lag, Delay::Answer(_) | Delay::Current(_) | Delay::Untold) {
        let what = "--delay is counted from a drive that comes back on a channel, and none does";
        return Err(Failure::usage(what, "leave it out, or record the drive: --channels drive,acceleration"));
    }
    let shown = asked.recording.as_ref().map_or(String::new(), |path| path.display().to_string());
    let wrong = |mistake: Mistake, covered: usize| {
        // Where nothing has happened yet, nothing shows, and neither the drive nor the recording is to blame for that.
        let shows_nothing = matches!(
            mistake,
            Mistake::Constant(_) | Mistake::Silent(..) | Mistake::Noise(Name::Acceleration, ..)
        );
        if let Some(drive) = take.drive.as_ref().filter(|_| shows_nothing && asked.drive.is_some())
            && let Some(short) = too_short(&shown, covered, drive, take.rate)
        {
            return short;
        }
        // What was played is in a file of its own where it did not come back.
        let of_drive = matches!(
            mistake,
            Mistake::NotANumber(Name::Drive, _)
                | Mistake::Silent(Name::Drive, ..)
                | Mistake::Clipped(Name::Drive, ..)
                | Mistake::Constant(_)
                | Mistake::Uncovered(..)
        );
        let file = if of_drive && asked.drive.is_some() { &take.drive_name } else { &shown };
        let what = format!("`{file}`: {mistake}");
        let help = match (mistake, take.lag) {
            (Mistake::Noise(Name::Acceleration, ..) | Mistake::Uncovered(..), Delay::Untold) => {
                Some(format!("nothing in it follows {}: is that what was played?", take.drive_name))
            }
            (Mistake::Clipped(..), _) => Some("what is clipped cannot be mended: record it again".into()),
            _ => None,
        };
        match help {
            Some(help) => Failure::usage(what, help).with_code(65),
            None => Failure::said(65, what),
        }
    };
    let known = asked.delay.unwrap_or(0.0);
    let (mut shift, mut delay) = match take.lag {
        Delay::None => (0, Some(known)),
        Delay::Looped(seconds) => {
            let whole = (seconds * take.rate).floor();
            (whole as isize, Some(known + seconds - whole / take.rate))
        }
        Delay::Answer(seconds) => {
            let sooner = if target.is_motor() { 0.0 } else { SOONER };
            (((seconds - sooner) * take.rate).round() as isize, None)
        }
        // A current is late by its coil alone: nothing is left to that.
        Delay::Current(seconds) => ((seconds * take.rate).floor() as isize - 1, None),
        Delay::Untold => (0, None),
    };
    let current = match take.lag {
        Delay::None => Some(0.0),
        Delay::Looped(seconds) => Some(seconds),
        Delay::Current(_) | Delay::Answer(_) | Delay::Untold => None,
    };
    let mut round = 0;
    loop {
        round += 1;
        let cut = take.cut(shift, &shown, target)?;
        // Before it is filtered, which hides what is clipped.
        let covered = cut.drive.len() + (-shift).max(0) as usize;
        cut.check().map_err(|mistake| wrong(mistake, covered))?;
        let cut = cut.fewer(ENOUGH[usize::from(!target.is_motor())]);
        let is_calibrated = asked.acceleration_scale.is_some();
        let all = if target.is_motor() {
            let current = current.map(|late| late - shift as f64 / take.rate);
            cut.motor([delay, current], is_calibrated, asked.mass.or(target.own_value("mass")))
        } else {
            cut.resonance(is_calibrated, asked.share.or(share(target)))
        };
        let all = all.map_err(|mistake| wrong(mistake, covered))?;
        let late = all.get("lateness").or(all.get("delay")).map(|estimate| estimate.value);
        let time = all.get("time_constant").map(|estimate| estimate.value);
        if let (Some(late), Some(time), None) = (late, time, delay)
            && target.is_motor()
            && !matches!(take.lag, Delay::Current(_))
            && round < AGAIN
        {
            // Nobody knows how much of the delay is the coil's: so much of it is left for that, and the interval says it.
            let off = late - HIDDEN * time;
            if off.abs() > (NOTICED * time).max(2.0 / take.rate) {
                shift += (off * take.rate).round() as isize;
                continue;
            }
        }
        let own = late.map(|late| shift as f64 / take.rate + late);
        let looped = match take.lag {
            Delay::Looped(seconds) => seconds,
            _ => 0.0,
        };
        if delay.is_some() {
            let shows = fitted(&all, cut.rate, target).or_else(|| cut.followed(target));
            let shows = shows.map(|ends| ends.map(|end| shift as f64 / take.rate + end - looped));
            match (shows, asked.delay) {
                (Some([least, most]), Some(_)) if !(least..=most).contains(&known) => {
                    return Err(contradicted(&shown, known, [least, most]));
                }
                (Some([least, most]), None) if !(least..=most).contains(&0.0) && target.is_motor() => {
                    // Nobody said it, and it is not none: it is looked for, as if nothing had come back.
                    (delay, round) = (None, 0);
                    continue;
                }
                _ => {}
            }
        }
        let later = own.map(|own| own - looped).filter(|_| delay.is_none());
        let (delay, later) = match take.lag {
            Delay::Looped(seconds) => (Some(seconds), later),
            Delay::None => (None, later),
            Delay::Current(seconds) => {
                let late = all.get("current_lateness").map(|told| shift as f64 / take.rate + told.value);
                (late.or(Some(seconds)), None)
            }
            Delay::Answer(_) | Delay::Untold => (own, None),
        };
        let peak = cut.drive.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        return Ok(Found { all, delay, later, left_out: cut.left_out, missed: cut.missed, peak });
    }
}

/// That a delay is not what the recording shows.
fn contradicted(shown: &str, given: f64, [least, most]: [f64; 2]) -> Failure {
    let what = format!(
        "--delay is {}, but in `{shown}` the acceleration is behind the drive by {} to {}",
        ms(given),
        ms(least),
        ms(most)
    );
    Failure::usage(what, "leave it out, and it is looked for; or measure it again, in seconds").with_code(65)
}

/// The slug's share of all that moves, where that is known.
fn share(target: &Target) -> Option<f64> {
    let slug = target.value("slug_mass")?;
    Some(slug / (slug + target.own_value("casing_mass")?))
}

impl Take {
    /// The part over which the drive, so many samples later, and the recording overlap.
    fn cut(&self, shift: isize, shown: &str, target: &Target) -> Result<Cut, Failure> {
        let own = self.voltage.as_ref().map(|voltage| &voltage.samples);
        let drive = self.drive.as_ref().or(own).map_or(&[][..], |drive| drive);
        let (begin, missed) = (shift.max(0) as usize, (-shift).max(0) as usize);
        let length =
            self.acceleration.samples.len().saturating_sub(begin).min(drive.len().saturating_sub(missed));
        if length < LEAST {
            return Err(belongs(shown, length, drive, self.rate));
        }
        let before = &drive[..missed];
        if !target.is_motor() && before.iter().any(|volts| *volts != 0.0) {
            let late = missed as f64 / self.rate;
            let what = format!(
                "`{shown}` begins {late:.3} s behind the drive, but must begin while the resonance is at rest"
            );
            return Err(Failure::usage(what, "start the recording before the drive is played").with_code(65));
        }
        let part =
            |trace: &Trace| Trace { samples: trace.samples[begin..begin + length].to_vec(), ..trace.clone() };
        let moved = |range: &Range<usize>| {
            let at = |n: usize| n.saturating_sub(begin).min(length);
            at(range.start)..at(range.end)
        };
        let seconds = |samples: usize| samples as f64 / self.rate;
        let ends = [self.acceleration.samples.len() - begin - length, drive.len() - missed - length];
        Ok(Cut {
            drive: drive[missed..missed + length].to_vec(),
            acceleration: part(&self.acceleration),
            current: self.current.as_ref().map(part),
            voltage: self.voltage.as_ref().map(part),
            open: self.open.iter().map(moved).filter(|range| range.start < range.end).collect(),
            rate: self.rate,
            left_out: [seconds(begin), seconds(ends[0])],
            missed: [seconds(missed), seconds(ends[1])],
        })
    }
}

impl Cut {
    /// By how much a motor's vibration is behind its drive, where no fit tells it, s.
    fn followed(&self, target: &Target) -> Option<[f64; 2]> {
        let is_told = target.is_motor() && !self.drive.is_empty();
        is_told.then(|| followed(&self.drive, &self.acceleration.samples, self.rate))?
    }

    /// What is wrong with the channels as they were recorded.
    fn check(&self) -> Result<(), Mistake> {
        let named = [
            (Some(&self.acceleration), Name::Acceleration),
            (self.current.as_ref(), Name::Current),
            (self.voltage.as_ref(), Name::Voltage),
        ];
        for (trace, name) in named {
            trace.map_or(Ok(()), |trace| self.channel(trace).usable(name))?;
        }
        Ok(())
    }

    fn channel<'a>(&self, trace: &'a Trace) -> Channel<'a> {
        Channel { samples: &trace.samples, rate: self.rate, full_scale: trace.full_scale }
    }

    fn drive(&self) -> Channel<'_> {
        Channel { samples: &self.drive, rate: self.rate, full_scale: None }
    }

    /// At about so many samples a second, where no current and no voltage needs more.
    fn fewer(mut self, enough: f64) -> Self {
        let ratio = (self.rate / enough) as usize;
        if ratio < 2 || self.current.is_some() || self.voltage.is_some() {
            return self;
        }
        let taken = Decimator::new(ratio);
        // About its mean, so that it has no edges where it begins and ends.
        let fewer = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            let level: Vec<f64> = x.iter().map(|x| x - mean).collect();
            let mut low = vec![0.0; x.len() / ratio];
            taken.add(&level, 0, 1.0, &mut low);
            low
        };
        // A motor's drive is held, and what counts of it is the mean; both see the same filter otherwise.
        let means = |x: &[f64]| x.chunks_exact(ratio).map(|x| x.iter().sum::<f64>() / ratio as f64).collect();
        self.drive = if enough == ENOUGH[0] { means(&self.drive) } else { fewer(&self.drive) };
        self.acceleration.samples = fewer(&self.acceleration.samples);
        self.acceleration.full_scale = None;
        self.rate /= ratio as f64;
        self
    }

    fn motor(
        &self,
        [delay, current_delay]: [Option<f64>; 2],
        is_calibrated: bool,
        mass: Option<f64>,
    ) -> Result<Identified, Mistake> {
        motor::identify(&motor::Recording {
            drive: self.drive(),
            acceleration: self.channel(&self.acceleration),
            is_calibrated,
            current: self.current.as_ref().map(|trace| self.channel(trace)),
            voltage: self.voltage.as_ref().map(|trace| self.channel(trace)),
            open: &self.open,
            delay,
            current_delay,
            mass,
        })
    }

    fn resonance(&self, is_calibrated: bool, share: Option<f64>) -> Result<Identified, Mistake> {
        resonant::identify(&resonant::Recording {
            drive: self.drive(),
            acceleration: self.channel(&self.acceleration),
            is_calibrated,
            current: self.current.as_ref().map(|trace| self.channel(trace)),
            share,
        })
    }
}
