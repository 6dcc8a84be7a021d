//! How a real knob's angle comes in by a sound card, `sensor`.

use crate::knob::angle::decoder::{Decoder, Sense, Sensor};
use crate::knob::angle::linear::Slope;
use crate::knob::angle::quadrature::Lines;
use crate::knob::angle::resolver::Pair;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::{Problem, nearest};
use std::f64::consts::TAU;

/// Inputs that a card may have.
const MOST: u64 = 1024;
/// What a converter of 16 bits tells apart, as a share of full scale.
const STEP: f64 = 1.0 / 32_768.0;
/// A voltage this near full scale may be one beyond it.
const CLIPPED: f64 = 0.999;

/// Its keys.
pub(crate) static SENSOR: Table = Table {
    name: "knob sensor",
    doc: "How the angle of a knob that is there comes in by a sound card, with `pacinian play` and --input. Without it the knob is simulated.",
    fields: &[
        Field::new(
            "type",
            Form::Word(&["sine-cosine", "quadrature", "voltage"]),
            "",
            "What comes in: the sine and the cosine of the angle, the two lines of an encoder, or a voltage that grows with it.",
        )
        .required(),
        Field::new("sine_channel", Form::any_count(1, MOST), "", "Input channel of the sine, from 1; needed for sine-cosine."),
        Field::new("cosine_channel", Form::any_count(1, MOST), "", "Input channel of the cosine, from 1; needed for sine-cosine."),
        Field::new(
            "periods",
            Form::count(1, 1, 1_000_000),
            "a turn",
            "Of sine and cosine. With more than one, the angle is known within one of them when it begins.",
        ),
        Field::new("sine_middle", Form::number(0.0, -1.0, 1.0), "", "The sample about which the sine goes up and down."),
        Field::new("cosine_middle", Form::number(0.0, -1.0, 1.0), "", "The same of the cosine."),
        Field::new("sine_amplitude", Form::number(0.5, 1e-4, 1.0), "", "By how many samples of full scale it does."),
        Field::new(
            "cosine_amplitude",
            Form::any_number(1e-4, 1.0),
            "",
            "The same of the cosine; that of the sine where nothing is said.",
        ),
        Field::new("phase", Form::number(0.0, -1.0, 1.0), "rad", "By how much the sine leads where it should not."),
        Field::new("a_channel", Form::any_count(1, MOST), "", "Input channel of line A, from 1; needed for quadrature. A leads where the angle rises."),
        Field::new("b_channel", Form::any_count(1, MOST), "", "Input channel of line B, from 1; needed for quadrature."),
        Field::new("threshold", Form::number(0.0, -1.0, 1.0), "", "The sample above which a line is high."),
        Field::new("hysteresis", Form::number(0.05, 0.0, 1.0), "", "By how much it must pass that, so that noise is no edge."),
        Field::new("channel", Form::any_count(1, MOST), "", "Input channel of the voltage, from 1; needed for voltage."),
        Field::new("full_scale_volts", Form::any_number(1e-3, 1e3), "V", "At a sample of 1.0; needed for voltage."),
        Field::new(
            "radians_per_volt",
            Form::any_number(-1e4, 1e4),
            "rad/V",
            "Below 0 where the voltage falls as the angle rises; needed for voltage.",
        ),
        Field::new("zero_volts", Form::number(0.0, -1e3, 1e3), "V", "Where the angle is 0."),
        Field::new(
            "low_volts",
            Form::any_number(-1e3, 1e3),
            "V",
            "Below this the sensor or its wire is broken; where nothing is said, what the input cannot tell from its end.",
        ),
        Field::new("high_volts", Form::any_number(-1e3, 1e3), "V", "And above this."),
        Field::new("inverted", Form::Flag(false), "", "Whether its angle falls where the knob's rises."),
    ],
    others: None,
};

/// Keys that each type needs, and those that it may have besides.
const KEYS: [(&[&str], &[&str]); 3] = [
    (
        &["sine_channel", "cosine_channel"],
        &["periods", "sine_middle", "cosine_middle", "sine_amplitude", "cosine_amplitude", "phase"],
    ),
    (&["a_channel", "b_channel"], &["threshold", "hysteresis"]),
    (&["channel", "full_scale_volts", "radians_per_volt"], &["zero_volts", "low_volts", "high_volts"]),
];

/// Reads it, of a knob whose encoder has so many counts a turn, if that is said.
pub(super) fn read(reader: &Reader, counts: Option<f64>) -> Option<Sensor> {
    reader.at("type")?.text()?;
    let kind = reader.word("type");
    let (needed, others) = KEYS[kind.min(2)];
    for field in SENSOR.fields.iter().map(|field| field.key) {
        let is_its = needed.contains(&field) || others.contains(&field);
        if reader.has(field) && !is_its && !["type", "inverted"].contains(&field) {
            let goes =
                KEYS.iter().position(|(needed, others)| needed.contains(&field) || others.contains(&field));
            let of = ["sine-cosine", "quadrature", "voltage"][goes.unwrap_or(0)];
            let what = format!("`{field}` of {} goes with type = \"{of}\"", reader.who);
            reader.sink.push(Problem::error(&reader.span_of(field), what).help("leave it out".to_string()));
        }
    }
    let missing: Vec<&str> = needed.iter().copied().filter(|key| !reader.has(key)).collect();
    if !missing.is_empty() {
        let what = format!("{} lacks {}", reader.who, nearest::listed(&missing));
        reader.sink.push(Problem::error(&reader.span, what).help("input channels count from 1".to_string()));
        return None;
    }
    let channel = |key: &str| reader.count(key).map(|channel| channel as usize - 1);
    let (sense, channels) = match kind {
        0 => {
            let channels = [channel("sine_channel")?, channel("cosine_channel")?];
            let amplitude = reader.number_or_default("sine_amplitude");
            let pair = Pair {
                offset: ["sine_middle", "cosine_middle"].map(|key| reader.number_or_default(key)),
                gain: [amplitude, reader.number("cosine_amplitude").unwrap_or(amplitude)],
                phase: reader.number_or_default("phase"),
                turns: reader.count("periods").map_or(1, |periods| periods as u32),
            };
            (Sense::Pair(pair), channels)
        }
        1 => {
            let channels = [channel("a_channel")?, channel("b_channel")?];
            let Some(counts) = counts else {
                let what = format!(
                    "{} counts an encoder's edges, and nothing says how many make a turn",
                    reader.who
                );
                let help = "say so beside it: [knob] counts = 4000, or lines = 1000".to_string();
                reader.sink.push(Problem::error(&reader.span, what).help(help));
                return None;
            };
            let threshold = reader.number_or_default("threshold");
            let hysteresis = reader.number_or_default("hysteresis");
            (Sense::Lines(Lines { counts: counts as u32, threshold, hysteresis }), channels)
        }
        _ => {
            let channel = channel("channel")?;
            let full_scale = reader.number("full_scale_volts")?;
            let end = CLIPPED * full_scale;
            let whole = [
                reader.number("low_volts").unwrap_or(-end).max(-end),
                reader.number("high_volts").unwrap_or(end).min(end),
            ];
            let slope = Slope {
                full_scale,
                radians_per_volt: reader.number("radians_per_volt")?,
                zero: reader.number_or_default("zero_volts"),
                whole,
            };
            (Sense::Slope(slope), [channel; 2])
        }
    };
    if kind < 2 && channels[0] == channels[1] {
        let what = format!("{} has input channel {} twice", reader.who, channels[0] + 1);
        let help = "each comes in by a channel of its own".to_string();
        reader.sink.push(Problem::error(&reader.span_of(needed[1]), what).help(help));
        return None;
    }
    let sensor = Sensor { sense, channels, inverted: reader.flag("inverted") };
    if let Err(fault) = Decoder::new(&sensor, 1) {
        let what = format!("{}: {fault}", reader.who);
        let help = "then no angle could be read".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
        return None;
    }
    Some(sensor)
}

/// Counts a turn of what it reads by a converter of 16 bits, where nobody has said how finely it tells angles apart.
pub(super) fn counts(sensor: &Sensor) -> Option<f64> {
    match sensor.sense {
        Sense::Lines(lines) => Some(f64::from(lines.counts)),
        Sense::Pair(pair) => Some(TAU * f64::min(pair.gain[0], pair.gain[1]) * f64::from(pair.turns) / STEP),
        Sense::Slope(slope) => Some(TAU / (slope.full_scale * slope.radians_per_volt.abs() * STEP)),
    }
}
