//! What will be done with an output.

use super::super::coupled::Coupled;
use super::super::even::EvenReport;
use super::super::felt::FeltReport;
use super::super::loaded::Loaded;
use super::super::pushes::Push;
use super::super::table::hertz;
use pacinian::actuator::driver::coast::{Coast, STANDS};
use pacinian::actuator::driver::order::{After, By};
use pacinian::actuator::driver::setup::Stage;
use pacinian::graph::plan::{Output, OutputKind, Plan};
use pacinian::player::Player;
use pacinian::rig::{self, Bridge, Peak, Terminals};
use serde::Serialize;

/// What will be done with one.
#[derive(Debug, Serialize)]
pub struct OutputReport {
    channel: u32,
    name: String,
    kind: &'static str,
    /// The most that leaves it: as a share of full scale, and in volts (peak) where it is known what full scale is.
    max_level: f64,
    max_volts: Option<f64>,
    /// Whether a steady voltage may leave it; null where the device is not known to let any through.
    dc: Option<bool>,
    /// How its motor is turned; null for what is none.
    motor: Option<MotorReport>,
    /// What its actuator is protected from.
    protected: Vec<&'static str>,
    /// What its actuator's own model asks of the equaliser, and the filters of the rig.
    even_out: Option<EvenReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    felt: Option<FeltReport>,
    equaliser: Vec<PeakReport>,
}

#[derive(Debug, Serialize)]
struct PeakReport {
    frequency: f64,
    gain_db: f64,
    q: f64,
}

#[derive(Debug, Serialize)]
struct MotorReport {
    shaping: &'static str,
    /// Whether its amplifier imposes a current, so that its limit is in amperes.
    is_current: bool,
    /// The most that reaches it, volts or amperes.
    limit: f64,
    /// From an event to what is sent.
    late_ms: f64,
    /// Behind a bridge: pulses a second, and the smallest difference of volts.
    pulses: Option<[f64; 2]>,
    /// Before a rectifier: hertz of the carrier, and seconds in which the motor rolls out, as nothing brakes it.
    carrier: Option<[f64; 2]>,
    /// Before a rectifier: what clicks, which are pushes there, come to.
    pushes: Vec<Push>,
    /// Behind coupling.
    coupled: Option<Coupled>,
    /// Envelopes that voices order: by what voice, the share of the largest vibration that is reached, and the share of its speeds that is missed.
    swells: Vec<(String, f64, f64)>,
    /// Of levels that are plain or switch: what a drive is held by, and what follows it, where something is said.
    held: Option<String>,
    /// Seconds of rest after which its mass goes home again.
    park: Option<f64>,
    /// The way home, where a voice sends it there: s, where the mass hangs then, rad from straight down, and by how much it may be elsewhere, with its
    /// figures as they are and with one of them 5 % off.
    home: Option<[f64; 4]>,
    /// Why its mass cannot be brought home, where a voice sends motors there.
    homeless: Option<String>,
}

impl OutputReport {
    /// Of an output of a player that has not begun.
    pub fn of(loaded: &Loaded, player: &Player, output: &Output) -> Self {
        let plan = player.plan();
        let peaks = if output.equaliser.is_empty() { Vec::new() } else { peaks(loaded, &output.name) };
        Self {
            channel: output.channel + 1,
            name: output.name.to_string(),
            kind: kind(output.kind),
            max_level: output.max_level,
            max_volts: loaded.rig.device.full_scale_volts.map(|volts| output.max_level * volts),
            dc: dc(loaded, output),
            motor: motor(loaded, player, output),
            protected: protected(plan, output),
            even_out: even_out(loaded, output),
            felt: FeltReport::of(loaded, plan, output),
            equaliser: peaks,
        }
    }

    /// Channel, name, kind, and all that is to be said of it.
    pub fn row(&self) -> [String; 4] {
        let peak = |p: &PeakReport| format!("{:+} dB at {} (q {})", p.gain_db, hertz(p.frequency), p.q);
        let peaks: Vec<String> = self.equaliser.iter().map(peak).collect();
        let equaliser = (!peaks.is_empty()).then(|| format!("equaliser {}", peaks.join(", ")));
        let even = self.even_out.as_ref().map(EvenReport::text);
        let felt = self.felt.as_ref().map(FeltReport::text);
        let notes = [self.most(), self.turned(), self.steady(), self.watched(), even, equaliser, felt];
        let notes: Vec<String> = notes.into_iter().flatten().collect();
        [self.channel.to_string(), self.name.clone(), self.kind.into(), notes.join("; ")]
    }

    /// The most that leaves it, where that is less than full scale.
    fn most(&self) -> Option<String> {
        let volts = self.max_volts.map_or(String::new(), |volts| format!(" = {volts:.3} V"));
        (self.max_level < 1.0).then(|| format!("at most {}{volts}", self.max_level))
    }

    /// How its motor is turned, and how late.
    fn turned(&self) -> Option<String> {
        let motor = self.motor.as_ref()?;
        let unit = if motor.is_current { "A" } else { "V" };
        let pulses = motor.pulses.map_or(String::new(), |[rate, step]| {
            format!(", by {} pulses in steps of {step:.3} V", hertz(rate))
        });
        let (by, rolls) = motor.carrier.map_or_else(Default::default, |[rate, rolls]| {
            (
                format!(" on average by a carrier of {}", hertz(rate)),
                format!(
                    "; forward alone: nothing brakes it, it rolls out in {rolls:.2} s, and clicks are pushes"
                ),
            )
        });
        let pushes: String = motor.pushes.iter().filter_map(Push::text).collect();
        let swells: String = motor.swells.iter().filter_map(out_of_reach).collect();
        let coupled = motor.coupled.as_ref().map_or(String::new(), |coupled| coupled.text(unit));
        let unhomed = match (&motor.homeless, motor.park) {
            (Some(why), None) => format!(", not to be brought home: {why}"),
            (Some(why), Some(_)) => format!(", not to be brought home and so never parked: {why}"),
            (None, Some(_)) => ", never parked since no voice sends it home (drive-home)".into(),
            (None, None) => String::new(),
        };
        let home = motor.home.map_or(unhomed, |[seconds, angle, spread, astray]| {
            let [angle, spread, astray] = [angle, spread, astray].map(f64::to_degrees);
            format!(
                ", home in {seconds:.2} s at {angle:.0}° within {spread:.1}° ({astray:.0}° where a figure of the motor is 5 % off), clicks from there on with gravity{}",
                motor.park.map_or(String::new(), |seconds| format!(", and there again after {seconds} s of rest, for which a rendering waits"))
            )
        });
        Some(format!(
            "{}{} within {:.3} {unit}{by}, {:.1} ms late{pulses}{home}{rolls}{pushes}{swells}{coupled}",
            motor.shaping,
            motor.held.as_deref().unwrap_or_default(),
            motor.limit,
            motor.late_ms
        ))
    }

    /// What its actuator is protected from.
    fn watched(&self) -> Option<String> {
        (!self.protected.is_empty()).then(|| format!("protected from too much {}", self.protected.join(", ")))
    }

    /// What becomes of a steady voltage, where that is known.
    fn steady(&self) -> Option<String> {
        self.dc.map(|may| if may { "DC may leave".into() } else { "DC is kept off".into() })
    }
}

fn kind(kind: OutputKind) -> &'static str {
    match kind {
        OutputKind::Vibration => "vibration",
        OutputKind::Raw => "raw: no limiter, no band limit",
        OutputKind::Drive => "turns a motor",
        OutputKind::Silent => "torque",
        OutputKind::Trigger { .. } => "trigger",
    }
}

/// Whether a steady voltage may leave an output that is rendered, where that is known.
fn dc(loaded: &Loaded, output: &Output) -> Option<bool> {
    let described = loaded.rig.outputs.iter().find(|o| *o.name == *output.name)?;
    let amplifier = described.amplifier.as_ref().and_then(|name| loaded.rig.amplifier(name));
    // Before a rectifier goes a tone and nothing else.
    let is_tone = amplifier.is_some_and(|amplifier| matches!(amplifier.drive, rig::Drive::Carrier(_)));
    loaded.rig.lets_dc(described).filter(|_| output.kind != OutputKind::Silent && !is_tone)
}

/// In words, what of an envelope is out of a motor's reach.
fn out_of_reach((voice, reached, missed): &(String, f64, f64)) -> Option<String> {
    (*missed > NEAR).then(|| {
        format!(
            "; the envelope of `{voice}` is out of reach: {:.0} % of its vibration is reached, {:.0} % of its speeds are missed",
            100.0 * reached,
            100.0 * missed
        )
    })
}

/// How levels that are plain or switch are held and let go, where that is said.
fn held(turning: &rig::Turning) -> Option<String> {
    let Stage { by, after, share, on_at, off_at } = turning.stage;
    let mut text = String::new();
    if turning.word() == "on-off" {
        text += &format!(" (on at {on_at}, off at {off_at}, {share} of the most)");
    }
    text += match by {
        By::Amplifier => "",
        By::Voltage => " by voltage",
        By::Current => " by current",
    };
    text += match after {
        After::Nothing => "",
        After::Short => ", then short",
        After::Open => ", then open",
    };
    (!text.is_empty()).then_some(text)
}

/// Of an envelope's speeds, what may be missed and nothing is said.
const NEAR: f64 = 0.02;

/// How a motor is turned; `None` for what is none.
fn motor(loaded: &Loaded, player: &Player, output: &Output) -> Option<MotorReport> {
    let plan = player.plan();
    let drive = plan.drives.iter().find(|drive| drive.channel == output.channel)?;
    let late = player.engine().stage().drives().late(output.channel as usize)?;
    let described = loaded.rig.outputs.iter().find(|o| *o.name == *output.name)?;
    let rig::OutputKind::Drive(turning) = &described.kind else { return None };
    let swells = plan.swells.iter().filter(|swell| plan.drives.get(swell.drive) == Some(drive));
    let swells = swells.map(|swell| {
        let [reached, missed] = swell.track.reach();
        (swell.voice.to_string(), reached, missed)
    });
    let home = plan.homes.iter().find(|(of, _)| plan.drives.get(*of) == Some(drive));
    let homeless = plan.homeless.iter().find(|(of, _)| plan.drives.get(*of) == Some(drive));
    let switching = match drive.terminals {
        Terminals::Bridge(Bridge { switching, .. }) => Some(switching),
        Terminals::Straight | Terminals::Carrier(_) | Terminals::Coupled(_) => None,
    };
    let coupled = match &drive.terminals {
        Terminals::Coupled(corners) => Some(Coupled::of(plan, drive, corners)),
        Terminals::Straight | Terminals::Bridge(_) | Terminals::Carrier(_) => None,
    };
    let carrier = match drive.terminals {
        Terminals::Carrier(carrier) => {
            let parameters = &drive.setup.parameters;
            let full = drive.setup.full_speed();
            Some([carrier.hertz, Coast::new(parameters).seconds(full, STANDS * full)])
        }
        Terminals::Straight | Terminals::Bridge(_) | Terminals::Coupled(_) => None,
    };
    let pushes = match &drive.terminals {
        Terminals::Carrier(carrier) => {
            let amplifier = described.amplifier.as_ref().and_then(|name| loaded.rig.amplifier(name));
            Push::all(plan, drive, carrier, amplifier.and_then(|amplifier| amplifier.max_volts))
        }
        Terminals::Straight | Terminals::Bridge(_) | Terminals::Coupled(_) => Vec::new(),
    };
    // What is wanted in one period is given in the next.
    let switched = switching.map_or(0.0, |switching| 1.0 / switching.hertz(plan.device_rate));
    let pulses = switching.map(|switching| [switching.hertz(plan.device_rate), switching.resolution()]);
    Some(MotorReport {
        shaping: turning.word(),
        held: held(turning),
        park: turning.park,
        is_current: drive.setup.imposes == pacinian::actuator::drive::Drive::Current,
        limit: drive.setup.limit,
        late_ms: 1e3 * (late as f64 / plan.engine_rate() + player.engine().delay().lead + switched),
        pulses,
        carrier,
        pushes,
        coupled,
        swells: swells.collect(),
        home: home.map(|(_, home)| [home.seconds(), home.angle, home.spread, home.astray]),
        homeless: homeless.map(|(_, why)| why.to_string()),
    })
}

/// What an output's actuator is protected from.
fn protected(plan: &Plan, output: &Output) -> Vec<&'static str> {
    let bounds = plan.protections.iter().find(|(channel, _)| *channel == output.channel);
    let bounds = bounds.map(|(_, bounds)| *bounds).unwrap_or_default();
    let bears =
        plan.drives.iter().find(|drive| drive.channel == output.channel).and_then(|drive| drive.bears);
    let bears = bears.unwrap_or_default();
    let all = [
        (bounds.peak.is_some() || bounds.range.is_some(), "voltage"),
        (bounds.slew.is_some(), "slew"),
        (bounds.rms.is_some() || bears.rms.is_some(), "power"),
        (bounds.heat.is_some() || bears.heat.is_some(), "heat"),
        (bounds.stroke.is_some(), "stroke"),
        (bounds.steady.is_some(), "that is steady"),
        (bounds.alternating.is_some(), "that alternates"),
    ];
    all.into_iter().filter_map(|(is, what)| is.then_some(what)).collect()
}

/// What becomes of the resonance of an output's actuator, where the rig wants it evened out.
fn even_out(loaded: &Loaded, output: &Output) -> Option<EvenReport> {
    let described = loaded.rig.outputs.iter().find(|o| *o.name == *output.name)?;
    loaded.rig.evened(described)?.ok().map(|even| EvenReport::new(&even))
}

/// The equaliser of an output.
fn peaks(loaded: &Loaded, name: &str) -> Vec<PeakReport> {
    let output = loaded.rig.outputs.iter().find(|o| o.name == name);
    let actuator = output.and_then(|o| loaded.rig.actuator(o.actuator.as_deref()?));
    let report = |p: &Peak| PeakReport { frequency: p.frequency, gain_db: p.gain_db, q: p.q };
    actuator.map_or(Vec::new(), |a| a.equaliser.iter().map(report).collect())
}
