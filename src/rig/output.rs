//! A channel of the device and what hangs on it.

use super::MAX_CHANNELS;
use super::device::MAX_LEVEL;
use crate::actuator::driver::order::{After, By};
use crate::actuator::driver::setup::{Shaping, Stage};
use crate::patch::place;
use crate::perception::site::Site;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// An output, `[[output]]`; `[[tactor]]` is the short form for one of kind vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name; every output has its own.
    pub name: String,
    /// What goes out of it.
    pub kind: OutputKind,
    /// Channel of the device, from 1, as printed on the card.
    pub channel: u32,
    /// Where on the body, metres; `None`: nowhere in particular, so that no position finds it.
    pub position: Option<[f64; 3]>,
    /// Name of the actuator.
    pub actuator: Option<String>,
    /// Name of the amplifier.
    pub amplifier: Option<String>,
    /// Name of the calibration; `None`: nobody has measured it.
    pub calibration: Option<String>,
    /// Where on the body, as its threshold goes; see [`super::Rig::site_of`].
    pub site: Option<&'static Site>,
    /// Multiplies what goes out.
    pub gain: f64,
    /// Whether what goes out is turned upside down.
    pub inverted: bool,
    /// The most that leaves it, as a share of full scale; see [`super::Rig::max_level`].
    pub max_level: f64,
    /// For vibration on a device whose coupling is "dc": whether a steady voltage may leave it.
    pub dc: bool,
    /// Where it stands.
    pub span: Span,
    /// Where its channel stands.
    pub channel_span: Span,
}

/// What goes out of an output.
#[derive(Debug, Clone, PartialEq)]
pub enum OutputKind {
    /// Vibration for the skin, band-limited to 1 kHz.
    Vibration,
    /// What turns a rumble motor.
    Drive(Turning),
    /// A knob's torque.
    Torque,
    /// Pulses at markers: all of them, or those of one name.
    Trigger {
        /// Name of the marker; `None`: all.
        marker: Option<String>,
        /// Length of the pulse, seconds.
        pulse: f64,
    },
    /// What is played there as it comes: no equaliser, no limiter, no band limit at 1 kHz; cut at full scale.
    Raw,
}

/// How a rumble motor is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    /// From the level that is played to what reaches the terminals.
    pub shaping: Shaping,
    /// Seconds by which it knows ahead what is played; `None`: as long as the motor needs to be braked from its full speed.
    pub look_ahead: Option<f64>,
    /// The channel, from 1, of the line that says which way a bridge turns it; `None`: none.
    pub direction: Option<u32>,
    /// How drives are held and what follows them, where they are plain or switched.
    pub stage: Stage,
    /// Seconds of rest after which the mass goes home again; `None`: it is left where it is.
    pub park: Option<f64>,
    /// By how much the plane in which its mass spins is tilted off upright, rad; `None`: unknown, and gravity has no part in what is worked out.
    pub tilt: Option<f64>,
}

impl Turning {
    /// The word for its shaping in a file.
    pub fn word(&self) -> &'static str {
        self.shaping.word()
    }
}

impl OutputKind {
    /// The word for it in a file.
    pub(crate) fn word(&self) -> &'static str {
        match self {
            Self::Vibration => "vibration",
            Self::Drive(_) => "drive",
            Self::Torque => "torque",
            Self::Trigger { .. } => "trigger",
            Self::Raw => "raw",
        }
    }
}

impl Output {
    /// Whether it is declared for steady voltages.
    pub(crate) fn is_for_dc(&self) -> bool {
        self.kind != OutputKind::Vibration || self.dc
    }

    /// The channel, from 1, of the line that says which way its motor turns, if it has one.
    pub fn direction(&self) -> Option<u32> {
        match &self.kind {
            OutputKind::Drive(turning) => turning.direction,
            _ => None,
        }
    }

    /// A plain tactor with neither actuator nor amplifier.
    pub fn tactor(name: &str, channel: u32, position: [f64; 3]) -> Self {
        Self {
            name: name.into(),
            kind: OutputKind::Vibration,
            channel,
            position: Some(position),
            actuator: None,
            amplifier: None,
            calibration: None,
            site: None,
            gain: 1.0,
            inverted: false,
            max_level: 1.0,
            dc: false,
            span: 0..0,
            channel_span: 0..0,
        }
    }
}

const NAME: Field = Field::new("name", Form::Text, "", "Its name, by which events find it.").required();
const CHANNEL: Field = Field::new(
    "channel",
    Form::any_count(1, MAX_CHANNELS as u64),
    "",
    "Channel of the device, from 1, as printed on the card.",
)
.required();
const ACTUATOR: Field = Field::new("actuator", Form::Text, "", "Name of the actuator.");
const AMPLIFIER: Field = Field::new("amplifier", Form::Text, "", "Name of the amplifier.");
const CALIBRATION: Field =
    Field::new("calibration", Form::Text, "", "Name of its calibration, for what is played with `felt`.");
const SITE: Field = Field::new(
    "site",
    Form::Defined("site"),
    "",
    "Where on the body, for what is played with `felt`; that of the calibration where nothing is said, else the thenar.",
);
const GAIN: Field = Field::new("gain", Form::number(1.0, 0.0, 1000.0), "", "Multiplies what goes out.");
const POLARITY: Field = Field::new(
    "polarity",
    Form::Defined("polarity"),
    "",
    "1, or -1 or \"invert\" to turn what goes out upside down.",
);
const POSITION: Field =
    Field::new("position", Form::Defined("position"), "m", "Where on the body: [x, y] or [x, y, z].");

const DC: Field = Field::new(
    "dc",
    Form::Flag(false),
    "",
    "Whether a steady voltage may leave it, where the device's coupling is \"dc\"; for vibration.",
);

/// The keys of a tactor.
pub static TACTOR: Table = Table {
    name: "tactor",
    doc: "An output for vibration.",
    fields: &[NAME, CHANNEL, POSITION, SITE, ACTUATOR, AMPLIFIER, CALIBRATION, GAIN, POLARITY, MAX_LEVEL, DC],
    others: None,
};

/// The keys of any output.
pub static TABLE: Table = Table {
    name: "output",
    doc: "A channel of the device and what hangs on it.",
    fields: &[
        Field::new(
            "kind",
            Form::Word(&["vibration", "drive", "torque", "trigger", "raw"]),
            "",
            "What goes out of it.",
        )
        .required(),
        NAME,
        CHANNEL,
        POSITION,
        SITE,
        ACTUATOR,
        AMPLIFIER,
        CALIBRATION,
        GAIN,
        POLARITY,
        MAX_LEVEL,
        DC,
        Field::new(
            "marker",
            Form::Text,
            "",
            "For a trigger: the marker that gives a pulse; all of them where nothing is said.",
        ),
        Field::new("pulse", Form::number(0.005, 1e-5, 10.0), "s", "For a trigger: length of the pulse."),
        Field::new(
            "shaping",
            Form::Word(Shaping::WORDS),
            "",
            "For a drive: from the level that is played to what reaches the motor's terminals.",
        ),
        Field::new(
            "by",
            Form::Word(&["amplifier", "voltage", "current"]),
            "",
            "For a drive whose shaping is \"plain\" or \"on-off\": what is held, what the amplifier imposes, a voltage (the faster the motor turns the less flows) or a current (as much torque at every speed, as long as there are volts for it).",
        ),
        Field::new(
            "after",
            Form::Word(&["nothing", "short", "open"]),
            "",
            "For the same: what is done while the motor is to be slower than it is, or off; nothing is sent (of \"plain\": what holds the lower speed is), a short circuit, which brakes, or open terminals, where friction alone slows it.",
        ),
        Field::new(
            "share",
            Form::number(1.0, 0.001, 1.0),
            "",
            "For a drive whose shaping is \"on-off\": the share of the most that there may be that it is on with. Held by a current at a voltage amplifier, below 1: a current takes more volts as the motor becomes faster.",
        ),
        Field::new(
            "on_at",
            Form::number(0.5, 0.001, 1.0),
            "",
            "For a drive whose shaping is \"on-off\": the level from which on the motor is on.",
        ),
        Field::new(
            "off_at",
            Form::number(0.25, 0.0, 1.0),
            "",
            "For the same: the level at which it is off again, no more than `on_at`, so that what wavers does not switch it.",
        ),
        Field::new(
            "park",
            Form::any_number(0.01, 60.0),
            "s",
            "For a drive with `tilt`, but for shaping = \"clicks\": how long its mass rests before it goes home again, the way of `drive-home` that a voice has ordered before, so that the next click kicks the same way: longer than the pauses within a row of clicks. A rendering lasts until it is home again. It is left where it is where nothing is said.",
        ),
        Field::new(
            "look_ahead",
            Form::any_number(0.0, 0.5),
            "s",
            "For a drive whose shaping is \"inverse\": by how much what is played there is late, so that the motor can be braked in time; as long as braking from its full speed takes where nothing is said. None behind a rectifier, where nothing brakes.",
        ),
        Field::new(
            "direction",
            Form::any_count(1, MAX_CHANNELS as u64),
            "",
            "For a drive behind a bridge: the channel of the line that says which way, full scale for backward.",
        ),
        Field::new(
            "tilt",
            Form::any_number(-4.0, 4.0),
            "rad",
            "For a drive: by how much the plane in which the mass spins is tilted off upright; gravity has no part in it where nothing is said, nor of a motor that is known from outside alone (`time_constant` and what goes with it), the weight of whose mass beside its torques nobody can tell.",
        ),
    ],
    others: None,
};

/// How drives are held, and what follows them.
fn stage(reader: &Reader) -> Stage {
    let shaping = Shaping::ALL.get(reader.word("shaping")).copied().unwrap_or_default();
    let stage = Stage {
        by: By::ALL.get(reader.word("by")).copied().unwrap_or_default(),
        after: After::ALL.get(reader.word("after")).copied().unwrap_or_default(),
        share: reader.number_or_default("share"),
        on_at: reader.number_or_default("on_at"),
        off_at: reader.number_or_default("off_at"),
    };
    for (keys, of) in [
        (&["by", "after"][..], &[Shaping::Plain, Shaping::OnOff][..]),
        (&["share", "on_at", "off_at"], &[Shaping::OnOff]),
        (&["look_ahead"], &[Shaping::Inverse]),
        // Of what is there for clicks alone nothing steady gets through, and so no way home.
        (
            &["park"],
            &[Shaping::Inverse, Shaping::Overdrive, Shaping::Switching, Shaping::Plain, Shaping::OnOff],
        ),
    ] {
        for key in keys.iter().filter(|key| !of.contains(&shaping) && reader.has(key)) {
            let words: Vec<String> = of.iter().map(|shaping| format!("\"{}\"", shaping.word())).collect();
            let what =
                format!("{} has `{key}`, which is of shaping = {} alone", reader.who, words.join(" or "));
            let help = match *key {
                "look_ahead" => "leave it out: of this shaping what is played is as late as all else; or say shaping = \"inverse\"".into(),
                key => format!("leave `{key}` out, or say shaping = {}", words[words.len() - 1]),
            };
            reader.sink.push(Problem::error(&reader.span_of(key), what).help(help));
        }
    }
    if shaping == Shaping::OnOff && stage.by == By::Current && stage.share == 1.0 {
        let what = format!(
            "{} has `by` = \"current\" and is on with all that there may be: an amplifier that imposes a voltage has none left to hold a current with as the motor becomes faster",
            reader.who
        );
        let help = "leave it room: share = 0.5; or leave `by` out".to_string();
        reader.sink.push(Problem::warning(&reader.span_of("by"), what).help(help));
    }
    // Where one of them alone is said, the other goes with it.
    let off_at = if reader.has("off_at") { stage.off_at } else { stage.off_at.min(0.5 * stage.on_at) };
    if off_at > stage.on_at {
        let what = format!(
            "{} is off at a level of {off_at} and on at {}: it would be both in between",
            reader.who, stage.on_at
        );
        let help = "`off_at` must be no more than `on_at`".to_string();
        reader.sink.push(Problem::error(&reader.span_of("off_at"), what).help(help));
        return Stage::default();
    }
    if reader.has("park") && !reader.has("tilt") {
        let what =
            format!("{} has `park`, and without `tilt` it is not known how its mass hangs", reader.who);
        let help = "say how its plane is tilted off upright: tilt = 0.0; or leave `park` out".to_string();
        reader.sink.push(Problem::error(&reader.span_of("park"), what).help(help));
    }
    Stage { off_at, ..stage }
}

pub(crate) fn read(reader: &Reader, is_tactor: bool) -> Output {
    let kind = match if is_tactor { 0 } else { reader.word("kind") } {
        1 => OutputKind::Drive(Turning {
            shaping: Shaping::ALL.get(reader.word("shaping")).copied().unwrap_or(Shaping::Inverse),
            look_ahead: reader.number("look_ahead"),
            stage: stage(reader),
            park: reader.number("park"),
            direction: reader.count("direction").and_then(|n| u32::try_from(n).ok()),
            tilt: reader.number("tilt"),
        }),
        2 => OutputKind::Torque,
        3 => OutputKind::Trigger {
            marker: reader.text("marker").map(Into::into),
            pulse: reader.number_or_default("pulse"),
        },
        4 => OutputKind::Raw,
        _ => OutputKind::Vibration,
    };
    if !is_tactor {
        let (triggers, turns) =
            (matches!(kind, OutputKind::Trigger { .. }), matches!(kind, OutputKind::Drive(_)));
        for (is, keys, of) in [
            (triggers, &["marker", "pulse"][..], "a trigger"),
            (
                turns,
                &[
                    "shaping",
                    "by",
                    "after",
                    "share",
                    "on_at",
                    "off_at",
                    "park",
                    "look_ahead",
                    "direction",
                    "tilt",
                ],
                "a drive",
            ),
        ] {
            for key in keys.iter().filter(|key| !is && reader.has(key)) {
                let what = format!("{} is of kind {}; only {of} has `{key}`", reader.who, kind.word());
                reader.sink.error(&reader.span_of(key), what);
            }
        }
    }
    if kind != OutputKind::Vibration && reader.has("dc") {
        let what = format!("{} is of kind {}; only vibration has `dc`", reader.who, kind.word());
        let help = match kind {
            OutputKind::Raw | OutputKind::Trigger { .. } => {
                "leave it out: what is of this kind may be steady"
            }
            _ => "leave it out",
        };
        let problem = Problem::error(&reader.span_of("dc"), what).help(help.to_string());
        reader.sink.push(problem);
    }
    let inverted = reader.at("polarity").is_some_and(|value| match (value.number(), value.text()) {
        (Some(1.0), _) => false,
        (Some(-1.0), _) | (_, Some("invert")) => true,
        _ => {
            reader.mistaken("polarity", &value, "1, -1 or \"invert\"");
            false
        }
    });
    let name = reader.text("name");
    if let Some(name) = name {
        let named = if is_tactor { "tactor" } else { "output" };
        reader.check_name(name, &reader.span_of("name"), &format!("{named} `{name}`"));
    }
    Output {
        name: name.unwrap_or("").into(),
        kind,
        channel: reader.count("channel").and_then(|n| u32::try_from(n).ok()).unwrap_or(0),
        position: place::read_position(reader, "position"),
        actuator: reader.text("actuator").map(Into::into),
        amplifier: reader.text("amplifier").map(Into::into),
        calibration: reader.text("calibration").map(Into::into),
        site: super::calibration::read_site(reader),
        gain: reader.number_or_default("gain"),
        inverted,
        max_level: reader.number_or_default("max_level"),
        dc: reader.flag("dc"),
        span: reader.span.clone(),
        channel_span: reader.span_of("channel"),
    }
}
