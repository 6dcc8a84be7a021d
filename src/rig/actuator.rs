//! What moves.

use crate::dsp::biquad::MOST_SECTIONS;
use crate::text::Span;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// An actuator, `[actuator.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// What it is.
    pub model: Model,
    /// Resonance, Hz; `None`: unknown.
    pub resonance: Option<f64>,
    /// Quality of the resonance; `None`: unknown.
    pub q: Option<f64>,
    /// What it is made for, volts (peak); `None`: unknown.
    pub rated_volts: Option<f64>,
    /// Peaking filters that even it out, in order.
    pub equaliser: Vec<Peak>,
    /// Where it stands.
    pub span: Span,
}

/// What an actuator is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Nothing is known of it.
    Generic,
    /// A voice coil that pushes the skin itself.
    VoiceCoil,
    /// A mass on a spring, moved by a coil: the exciter.
    InertialMotor,
    /// A motor with an eccentric mass.
    RumbleMotor,
    /// A linear resonant actuator.
    Lra,
}

impl Model {
    /// All, in the order of the words in a file.
    pub(crate) const ALL: [Self; 5] =
        [Self::Generic, Self::VoiceCoil, Self::InertialMotor, Self::RumbleMotor, Self::Lra];
}

/// A peaking filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Hz.
    pub frequency: f64,
    /// Gain at that frequency, dB.
    pub gain_db: f64,
    /// Frequency over bandwidth.
    pub q: f64,
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "actuator",
    doc: "What moves.",
    fields: &[
        Field::new(
            "model",
            Form::Word(&["generic", "voice-coil", "inertial-motor", "rumble-motor", "lra"]),
            "",
            "What it is.",
        ),
        Field::new("resonance", Form::any_number(1.0, 10_000.0), "Hz", "Its resonance."),
        Field::new("q", Form::any_number(0.05, 1000.0), "", "Quality of the resonance."),
        Field::new("rated_volts", Form::any_number(1e-3, 1e4), "V", "What it is made for (peak)."),
        Field::new("equaliser", Form::Many(&PEAK), "", "Peaking filters that even it out, in order."),
    ],
    others: None,
};

/// The keys of a peaking filter.
pub static PEAK: Table = Table {
    name: "peak",
    doc: "A peaking filter.",
    fields: &[
        Field::new("frequency", Form::any_number(1.0, 3000.0), "Hz", "Where it peaks.").required(),
        Field::new("gain_db", Form::any_number(-40.0, 40.0), "dB", "Gain there.").required(),
        Field::new("q", Form::number(1.0, 0.05, 100.0), "", "Frequency over bandwidth."),
    ],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Actuator {
    let peaks = reader.many("equaliser", |n| format!("filter {n} of {}", reader.who));
    if peaks.len() > MOST_SECTIONS {
        let what = format!("{} has {} filters, the most is {MOST_SECTIONS}", reader.who, peaks.len());
        reader.sink.error(&reader.span_of("equaliser"), what);
    }
    Actuator {
        name: name.into(),
        model: Model::ALL.get(reader.word("model")).copied().unwrap_or(Model::Generic),
        resonance: reader.number("resonance"),
        q: reader.number("q"),
        rated_volts: reader.number("rated_volts"),
        equaliser: peaks
            .iter()
            .filter_map(|p| {
                Some(Peak {
                    frequency: p.number("frequency")?,
                    gain_db: p.number("gain_db")?,
                    q: p.number("q")?,
                })
            })
            .collect(),
        span: reader.span.clone(),
    }
}
