//! The drive that is to be played, as a WAV file.

use super::super::check::json;
use super::super::failure::Failure;
use super::super::parts::number;
use super::super::place::check_sound;
use super::super::table::{Table, hertz};
use super::super::terminal::Terminal;
use super::Identify;
use super::target::Target;
use pacinian::actuator::fault::Fault;
use pacinian::actuator::identify::stimulus::{LEAD, steps, sweep};
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use serde::Serialize;
use std::path::Path;

/// The time constant of a motor of which nothing is known, s: few are slower.
const SLOW: f64 = 0.1;
/// Of what a resonance is made for, so much is enough.
const ENOUGH: f64 = 0.5;
/// How far a sweep goes beyond a resonance that is known, down and up; and from where to where, Hz, where it is not.
const BEYOND: f64 = 6.0;
const BAND: [f64; 2] = [15.0, 1500.0];
/// Seconds of a sweep.
const SWEEP: f64 = 4.0;

/// What was made.
#[derive(Debug, Serialize)]
struct Made {
    file: String,
    of: String,
    kind: &'static str,
    seconds: f64,
    rate_hz: u32,
    /// Where the drive is in the file, from 1, and how many there are.
    channel: usize,
    channels: usize,
    peak_volts: f64,
    /// Of full scale.
    peak: f64,
    volts_per_sample: f64,
    says: String,
}

/// Makes it.
pub fn make(asked: &Identify, path: &Path, target: &Target, terminal: &Terminal) -> Result<(), Failure> {
    let own: Vec<_> = asked.rig.iter().cloned().collect();
    check_sound(path, "--stimulus", &own)?;
    if let Some(corner) = target.corners.hertz().first().filter(|_| target.is_motor()) {
        let what = format!("steps do not reach {}: a high-pass at {corner} Hz is on the way", target.name);
        return Err(Failure::usage(
            what,
            "a motor turns by a steady voltage: take a DC-coupled card and a DC amplifier",
        )
        .with_code(78));
    }
    let rate = asked.rate.unwrap_or(target.rate.unwrap_or(48_000.0) as u32);
    let per_sample =
        asked.drive_scale.map(f64::abs).or(target.per_sample).ok_or_else(|| unknown_scale(target))?;
    let volts = asked.volts.map_or_else(|| usual(target, f64::from(rate)), Ok)?;
    let most = asked.drive_scale.map_or(target.limit, |scale| {
        let reaches = scale.abs() * target.most;
        Some(target.limit.map_or(reaches, |limit| limit.min(reaches)))
    });
    if volts / per_sample < LEAST {
        let what = format!(
            "{volts:?} V are less than a card can give: a millionth of full scale is {:.2e} V",
            LEAST * per_sample
        );
        return Err(Failure::usage(
            what,
            "give more: --volts V; or say what a sample of 1.0 is in volts: --drive-scale V",
        ));
    }
    if let Some(most) = most.filter(|most| volts > most * (1.0 + 1e-9)) {
        let what = format!(
            "{} V are more than the {most:.4} V that {} bears, or that reach it",
            number(volts),
            target.name
        );
        return Err(Failure::usage(what, format!("give fewer: --volts {}", number(0.999 * most))));
    }
    let (drive, says) = drive(target, volts, f64::from(rate)).map_err(|fault| usage(&fault))?;
    let [channel, channels] = target.channel.filter(|[n, of]| n <= of && *n > 0).unwrap_or([1, 1]);
    let spec = WavSpec {
        title: format!("a drive for {}", target.name),
        ..WavSpec::new(channels, rate, Encoding::F32)
    };
    let mut wav = WavWriter::create(path, spec)?;
    let mut frame = vec![0.0_f32; channels];
    for volts in &drive {
        frame[channel - 1] = (volts / per_sample) as f32;
        wav.write(&frame)?;
    }
    wav.finish()?;
    let made = Made {
        file: path.display().to_string(),
        of: target.name.clone(),
        kind: if target.is_motor() { "steps" } else { "sweep" },
        seconds: drive.len() as f64 / f64::from(rate),
        rate_hz: rate,
        channel,
        channels,
        peak_volts: volts,
        peak: volts / per_sample,
        volts_per_sample: per_sample,
        says,
    };
    terminal.print(&if asked.json { json(&made) } else { made.text(asked, terminal) })
}

/// Volts at its most.
fn usual(target: &Target, rate: f64) -> Result<f64, Failure> {
    let rated = target.value("rated_volts");
    let share = if target.is_motor() { 1.0 } else { ENOUGH };
    let wanted = rated.map(|volts| share * volts).or(target.limit.map(|limit| share * limit));
    let wanted = wanted.ok_or_else(|| {
        let what = format!("nothing says how many volts {} bears", target.name);
        Failure::usage(what, "say it: --volts V, or rated_volts under its [actuator]")
    })?;
    let most = target.limit.map_or(wanted, |limit| wanted.min(limit));
    let coil = target.actuator.as_ref().filter(|_| !target.is_motor());
    let Some((limits, plant)) = coil.and_then(|coil| Some((coil.limits(), coil.coil().ok()?))) else {
        return Ok(most);
    };
    // As far as both it and its motion are known.
    limits.most_volts(&plant, band(target, rate)).map(|bears| most.min(bears)).map_err(|fault| usage(&fault))
}

/// From where to where a sweep goes, Hz.
fn band(target: &Target, rate: f64) -> [f64; 2] {
    let highest = 0.4 * rate;
    let [from, to] = match target.value("resonance") {
        Some(hertz) => [(hertz / BEYOND).max(1.0), hertz * BEYOND],
        None => BAND,
    };
    [from.min(0.1 * highest), to.min(highest)]
}

/// Volts sample by sample, and what they are in a line.
fn drive(target: &Target, volts: f64, rate: f64) -> Result<(Vec<f64>, String), Fault> {
    if target.is_motor() {
        let known = target.actuator.as_ref().and_then(|actuator| actuator.outside().ok()?[0].1);
        let time = known.map_or(SLOW, |time| time.clamp(1e-3, 2.0));
        let of = if known.is_some() { "its time constant of" } else { "a time constant of at most" };
        let says = format!("silence, three steps, rest, a slow ramp, rest; for {of} {:.1} ms", 1e3 * time);
        return Ok((steps(volts, time, rate)?, says));
    }
    let [from, to] = band(target, rate);
    let says = format!("{LEAD} s of silence, a sweep from {from:.1} to {to:.0} Hz in {SWEEP} s, silence");
    Ok((sweep(volts, [from, to], SWEEP, rate)?, says))
}

/// That nobody said what a sample of the drive is in volts.
pub fn unknown_scale(target: &Target) -> Failure {
    let what = format!("how many volts a sample of 1.0 is at {} is not known", target.name);
    let help = "say it: --drive-scale V; or --rig with full_scale_volts under [device] and the gain of the amplifier, and --output";
    Failure::usage(what, help)
}

/// Of full scale, what is no drive: 24 bits are 1.2e-7.
const LEAST: f64 = 1e-6;

/// To four digits behind the point, without zeros at the end.
pub fn tidy(value: f64) -> String {
    number((value * 1e4).round() / 1e4)
}

fn usage(fault: &Fault) -> Failure {
    let option = if ["volts", "rate"].contains(&fault.field) { fault.field } else { "rate" };
    Failure::usage(fault.to_string(), format!("give another --{option}"))
}

impl Made {
    fn text(&self, asked: &Identify, terminal: &Terminal) -> String {
        let paint = terminal.out;
        let mut text = format!("{}: a drive for {}\n", paint.bold(&self.file), self.of);
        let mut table = Table::default();
        table.row(["what".to_string(), self.says.clone()]);
        table.row(["length".into(), format!("{:.3} s at {}", self.seconds, hertz(f64::from(self.rate_hz)))]);
        let db = 20.0 * self.peak.log10();
        table.row([
            "peak".into(),
            format!("{} V, {} of full scale ({db:.1} dBFS)", tidy(self.peak_volts), tidy(self.peak)),
        ]);
        let of = match self.channels {
            1 => "the only one".into(),
            n => format!("{} of {n}, the others silent", self.channel),
        };
        table.row(["channel".to_string(), of]);
        text += &table.text();
        text += "Play it at full volume and its own rate, and record the acceleration; begin before it and end behind it. Then:\n";
        let given = [
            ("--rig", asked.rig.as_ref().map(|rig| rig.display().to_string())),
            ("--output", asked.output.clone()),
            ("--actuator", asked.actuator.clone()),
            ("--part", asked.part.clone()),
            ("--model", asked.model.map(|model| model.word().to_string())),
            ("--drive-scale", asked.drive_scale.map(|scale| scale.to_string())),
        ];
        text += &format!("  pacinian identify RECORDING.wav --drive {}", self.file);
        for (option, value) in given.iter().filter_map(|(option, value)| Some((option, value.as_ref()?))) {
            text += &format!(" {option} {value}");
        }
        text + "\n"
    }
}
