//! The recording with its drive, read from files: channels, scales, and where both belong together.

use super::super::failure::Failure;
use super::super::table::{hertz, many};
use super::late::{Delay, lag};
use super::short::too_short;
use super::stimulus::unknown_scale;
use super::target::Target;
use super::{Holds, Identify, Open};
use pacinian::actuator::identify::RATES;
use pacinian::actuator::link::coupling::{Corners, HighPass};
use pacinian::io::wav::{WavInfo, WavReader};
use std::ops::Range;
use std::path::Path;

/// A channel in its unit, and the largest value that its converter gives, where that is known.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Samples.
    pub samples: Vec<f64>,
    /// In the same unit; floats have none.
    pub full_scale: Option<f64>,
}

/// What was recorded, and the drive; both as they are, at one rate.
#[derive(Debug)]
pub struct Take {
    /// Samples a second.
    pub rate: f64,
    /// Seconds of the recording.
    pub seconds: f64,
    /// Volts; `None`: the voltage takes its place.
    pub drive: Option<Vec<f64>>,
    /// As people call it.
    pub drive_name: String,
    /// m/s², or what it is.
    pub acceleration: Trace,
    /// A.
    pub current: Option<Trace>,
    /// V.
    pub voltage: Option<Trace>,
    /// Samples of the recording with open terminals.
    pub open: Vec<Range<usize>>,
    /// By how much the recording lags the drive.
    pub lag: Delay,
}

/// Frames of a file, at most.
const MOST: u64 = 1 << 23;

/// Volts behind what keeps steady ones off.
///
/// # Errors
/// A corner or a rate that cannot be.
fn coupled(volts: impl Iterator<Item = f64>, corners: &Corners, rate: f64) -> Result<Vec<f64>, Failure> {
    if corners.hertz().is_empty() {
        return Ok(volts.collect());
    }
    let through = HighPass::new(corners, rate);
    let mut through = through
        .map_err(|fault| Failure::usage(fault.to_string(), "see `coupling` in the rig").with_code(78))?;
    Ok(volts.map(|volts| through.step(volts)).collect())
}

impl Take {
    /// Reads it.
    ///
    /// # Errors
    /// What files lack, what the command line does not say or says wrongly, rates that differ.
    pub fn read(asked: &Identify, path: &Path, target: &Target) -> Result<Self, Failure> {
        let shown = path.display().to_string();
        let mut reader = WavReader::open(path)?;
        let info = reader.info();
        let holds = named(asked, &shown, info.channels)?;
        check_rate(&shown, &info)?;
        check_length(&shown, &info)?;
        let rate = f64::from(info.rate);
        let mut all = reader.channels()?;
        let mut take = |what: Holds| {
            let at = holds.iter().position(|holds| *holds == what)?;
            Some(std::mem::take(&mut all[at]))
        };
        let trace = |samples: Vec<f32>, scale: f64| Trace {
            samples: samples.iter().map(|x| scale * f64::from(*x)).collect(),
            full_scale: (!info.float).then_some(scale.abs()),
        };
        let scaled = |what: Holds, samples: Option<Vec<f32>>, scale: Option<f64>, unit: &str| {
            let need = || {
                let what = what.word();
                let said = format!("what a sample of 1.0 of the {what} is in {unit} is not known");
                Failure::usage(said, format!("say it: --{what}-scale {}", &unit[..1]))
            };
            let scaled = |samples| scale.ok_or_else(need).map(|scale| trace(samples, scale));
            samples.map(scaled).transpose()
        };
        let acceleration =
            trace(take(Holds::Acceleration).unwrap_or_default(), asked.acceleration_scale.unwrap_or(1.0));
        let current = scaled(Holds::Current, take(Holds::Current), asked.current_scale, "A")?;
        let voltage = scaled(Holds::Voltage, take(Holds::Voltage), asked.voltage_scale, "V")?;
        let back = take(Holds::Drive);
        let open = open(asked, &shown, &info, voltage.is_some(), target)?;
        let played = asked.drive.as_deref().map(|path| played(asked, path, rate, &shown)).transpose()?;
        let (drive, drive_name, lag) = match (played, back) {
            // What is at the terminals is what drives it.
            _ if voltage.is_some() => (None, "the channel `voltage`".into(), Delay::None),
            (Some((drive, name)), back) => {
                let scale = asked.drive_scale.or(target.per_sample).ok_or_else(|| unknown_scale(target))?;
                let lag = lag(
                    &drive,
                    back.as_deref(),
                    current.as_ref().map(|current| &current.samples[..]),
                    &acceleration.samples,
                    rate,
                    target,
                );
                if let (Delay::Untold, Some(back)) = (lag, &back) {
                    if let Some(short) = too_short(&shown, back.len(), &drive, rate) {
                        return Err(short);
                    }
                    let what =
                        format!("the looped-back drive of `{shown}` is not `{name}`: nothing in it fits");
                    let help = "check its channel, or leave it out: - in its place under --channels";
                    return Err(Failure::usage(what, help).with_code(65));
                }
                let volts = drive.iter().map(|x| scale * x);
                (Some(coupled(volts, &target.corners, rate)?), name, lag)
            }
            (None, Some(back)) => {
                let scale = asked.drive_scale.ok_or_else(|| {
                    let what =
                        "how many volts a sample of 1.0 of the looped-back drive stands for is not known";
                    Failure::usage(
                        what,
                        "say it: --drive-scale V; or give the drive that was played, --drive FILE.wav",
                    )
                })?;
                let drive = back.iter().map(|x| scale * f64::from(*x)).collect();
                (Some(drive), "the channel `drive`".into(), Delay::None)
            }
            (None, None) => {
                let help = "give what was played: --drive FILE.wav, or a channel of the recording: --channels drive,acceleration";
                return Err(Failure::usage("what drove it is not known", help));
            }
        };
        let seconds = info.frames as f64 / rate;
        Ok(Self { rate, seconds, drive, drive_name, acceleration, current, voltage, open, lag })
    }
}

/// That a file's header names a rate that something was recorded at.
fn check_rate(shown: &str, info: &WavInfo) -> Result<(), Failure> {
    let (least, most) = RATES;
    if (least..=most).contains(&f64::from(info.rate)) {
        return Ok(());
    }
    let what = format!(
        "`{shown}` has {} by its header, but a recording has from {} to {}",
        hertz(f64::from(info.rate)),
        hertz(least),
        hertz(most)
    );
    let help = "the header is wrong: write the file anew with the rate at which it was recorded, which is that of its drive";
    Err(Failure::usage(what, help).with_code(65))
}

/// Channels that are named one by one, at most.
const MOST_NAMED: usize = 16;

/// That a file is not so long that looking for the drive in it takes all memory.
fn check_length(shown: &str, info: &WavInfo) -> Result<(), Failure> {
    if info.frames <= MOST {
        return Ok(());
    }
    let [is, most] = [info.frames, MOST].map(|frames| frames as f64 / f64::from(info.rate));
    let what = format!("`{shown}` is {is:.0} s long, and no more than {most:.0} s at this rate are taken");
    Err(Failure::usage(what, "cut away what does not belong to the drive, or record at a lower rate")
        .with_code(65))
}

/// What the channels hold, as many as there are.
fn named(asked: &Identify, shown: &str, channels: usize) -> Result<Vec<Holds>, Failure> {
    let given = &asked.channels;
    let words = || given.iter().map(|holds| holds.word()).collect::<Vec<_>>().join(",");
    if given.is_empty() {
        return match channels {
            1 => Ok(vec![Holds::Acceleration]),
            n => {
                let what =
                    format!("`{shown}` has {n} channels, and nothing says which of them is the acceleration");
                let rest = vec!["-"; (n - 1).min(MOST_NAMED)].join(",");
                let more = if n - 1 > MOST_NAMED { ",..." } else { "" };
                Err(Failure::usage(
                    what,
                    format!("say what they hold, in order: --channels acceleration,{rest}{more}, say"),
                ))
            }
        };
    }
    if given.len() != channels {
        let what = format!(
            "--channels {} names {}, but `{shown}` has {channels}",
            words(),
            many(given.len(), "channel")
        );
        return Err(Failure::usage(what, "name each of them, in order; - for one that holds nothing of use"));
    }
    for (n, holds) in given.iter().enumerate().filter(|(_, holds)| **holds != Holds::Nothing) {
        if given[..n].contains(holds) {
            let what = format!("--channels {} names {} twice", words(), holds.word());
            return Err(Failure::usage(what, "name one of them, and - for the other"));
        }
    }
    if !given.contains(&Holds::Acceleration) {
        let what = format!("--channels {} has no acceleration, which every fit needs", words());
        return Err(Failure::usage(what, "name it; fix an accelerometer to what is shaken"));
    }
    Ok(given.clone())
}

/// Where terminals are open, in samples of the recording.
fn open(
    asked: &Identify,
    shown: &str,
    info: &WavInfo,
    has_voltage: bool,
    target: &Target,
) -> Result<Vec<Range<usize>>, Failure> {
    if asked.open.is_empty() {
        return Ok(Vec::new());
    }
    if !has_voltage || !target.is_motor() {
        let what = "--open is for motors whose voltage was recorded: with open terminals it tells how fast they turn";
        return Err(Failure::usage(
            what,
            "leave it out, or name the channel: --channels acceleration,voltage",
        ));
    }
    let rate = f64::from(info.rate);
    let range = |Open { from, to }: &Open| {
        let seconds = info.frames as f64 / rate;
        if *to > seconds {
            let what = format!("--open {from}:{to} ends behind `{shown}`, which is {seconds:.3} s long");
            return Err(Failure::usage(what, "count from its beginning"));
        }
        Ok((from * rate) as usize..(to * rate) as usize)
    };
    asked.open.iter().map(range).collect()
}

/// What was played, in shares of full scale, and its file's name.
fn played(asked: &Identify, path: &Path, rate: f64, recording: &str) -> Result<(Vec<f64>, String), Failure> {
    let shown = path.display().to_string();
    let mut reader = WavReader::open(path)?;
    let info = reader.info();
    check_rate(&shown, &info)?;
    check_length(&shown, &info)?;
    if f64::from(info.rate) != rate {
        let what = format!(
            "`{recording}` has {}, but the drive `{shown}` has {}",
            hertz(rate),
            hertz(f64::from(info.rate))
        );
        return Err(Failure::usage(
            what,
            "record at the rate of the drive, or make one of this rate: --stimulus with --rate",
        )
        .with_code(65));
    }
    let sounds = |channel: &Vec<f32>| channel.iter().any(|x| *x != 0.0);
    let samples = match asked.drive_channel {
        Some(n) => reader.channel(usize::from(n))?,
        None => {
            let all = reader.channels()?;
            let which: Vec<usize> = (0..all.len()).filter(|n| sounds(&all[*n])).collect();
            match which[..] {
                [] => Vec::new(),
                [one] => all[one].clone(),
                _ => {
                    let list: Vec<String> =
                        which.iter().take(MOST_NAMED).map(|n| (n + 1).to_string()).collect();
                    let more = if which.len() > list.len() { ", ..." } else { "" };
                    let what = format!("several channels of `{shown}` are driven: {}{more}", list.join(", "));
                    return Err(Failure::usage(
                        what,
                        format!("name the one that was played: --drive-channel {}", list[0]),
                    ));
                }
            }
        }
    };
    if !sounds(&samples) {
        let what = format!("the drive `{shown}` is silent");
        return Err(Failure::usage(what, "give what was played; --stimulus makes one").with_code(65));
    }
    Ok((samples.iter().map(|x| f64::from(*x)).collect(), shown))
}
