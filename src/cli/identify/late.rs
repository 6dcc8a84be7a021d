//! How far a recording is behind its drive: found, or given and held against what the recording says.

use super::target::Target;
use pacinian::actuator::identify::Identified;
use pacinian::report::align::{Lag, looped, rung, turned};

/// How far a recording is behind its drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Delay {
    /// Not at all: drive and answer are channels of one recording.
    None,
    /// Seconds, by the drive that came back on a channel.
    Looped(f64),
    /// Seconds, to some samples: by the current, which jumps as the drive does.
    Current(f64),
    /// Seconds, about: by the answer.
    Answer(f64),
    /// It does not show.
    Untold,
}

/// What came back is at least so many samples.
const LEAST: usize = 64;
/// Samples at which an answer is looked for.
const COARSE: f64 = 8000.0;

/// The part of its time constant by which a motor's coil may make it late, at most, and how often what a rig says of the coil.
const COIL: f64 = 0.1;
const TWICE: f64 = 2.0;
/// The part of a period by which what a resonance says of a delay may be off.
const PERIOD: f64 = 0.05;
/// Samples.
const SAMPLES: f64 = 2.0;
/// Seconds by which a motor's vibration alone may say it wrongly.
const ROUGH: f64 = 0.05;

/// By how much the recording is behind.
pub fn lag(
    drive: &[f64],
    back: Option<&[f32]>,
    current: Option<&[f64]>,
    answer: &[f64],
    rate: f64,
    target: &Target,
) -> Delay {
    let told = |lag: Option<Lag>, how: fn(f64) -> Delay| lag.map_or(Delay::Untold, |lag| how(lag.seconds));
    if drive.len() < LEAST || answer.len() < LEAST {
        return Delay::Untold;
    }
    if let Some(back) = back {
        let back: Vec<f64> = back.iter().map(|x| f64::from(*x)).collect();
        return told(looped(drive, &back, rate), Delay::Looped);
    }
    if target.is_motor() {
        if let Some(lag) = current.and_then(|current| looped(drive, current, rate)) {
            return Delay::Current(lag.seconds);
        }
        return told(turned(drive, answer, rate), Delay::Answer);
    }
    // The mean of some samples is enough, and saves work.
    let every = ((rate / COARSE) as usize).max(1);
    let fewer = |x: &[f64]| -> Vec<f64> { x.chunks(every).map(|x| x.iter().sum()).collect() };
    told(rung(&fewer(drive), &fewer(answer), rate / every as f64), Delay::Answer)
}

/// What the recording says of a delay that is not looked for, s: the least and the most that go with it, by the fit. A motor's coil makes it
/// late as well, which nobody can tell from a delay.
pub fn fitted(all: &Identified, rate: f64, target: &Target) -> Option<[f64; 2]> {
    let off = SAMPLES / rate;
    if target.is_motor() {
        let [least, most] = all.get("lateness")?.interval;
        let time = all.get("time_constant")?.value;
        let figure = |key| all.get(key).map(|told| told.value).or(target.value(key));
        let known = figure("inductance").zip(figure("resistance"));
        let coil = known.map_or(COIL * time, |(inductance, resistance)| TWICE * inductance / resistance);
        return Some([least - coil.min(COIL * time) - off, most + off]);
    }
    let period = 1.0 / all.get("resonance")?.value;
    let [least, most] = all.get("delay")?.interval;
    Some([least - PERIOD * period - off, most + PERIOD * period + off])
}

/// The same of a motor whose drive does not switch while it turns, by how its vibration follows.
pub fn followed(drive: &[f64], answer: &[f64], rate: f64) -> Option<[f64; 2]> {
    turned(drive, answer, rate).map(|lag| [lag.seconds - ROUGH, lag.seconds + ROUGH])
}
