//! What moves.

use std::collections::BTreeMap;

use super::contradiction;
use super::even::{self, Even};
use super::part::{self, Part};
use super::quantity::{self, MODELS};
use crate::dsp::biquad::MOST_SECTIONS;
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// An actuator, `[actuator.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// What it is.
    pub model: Model,
    /// The part that it is, of those that ship; `None`: none of them.
    pub part: Option<String>,
    /// Its figures, by their keys, SI units: what the rig says, and below that what the part says.
    pub values: BTreeMap<&'static str, f64>,
    /// Peaking filters that even it out, in order.
    pub equaliser: Vec<Peak>,
    /// What is to be left of its resonance; `None`: all of it.
    pub even_out: Option<Even>,
    /// Where it stands.
    pub span: Span,
    /// Keys of figures that stand there and cannot be, which has been told.
    pub(super) misread: Vec<&'static str>,
}

/// What an actuator is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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
    /// A piezo-electric element.
    Piezo,
}

impl Model {
    /// All, in the order of the words in a file.
    pub const ALL: [Self; 6] =
        [Self::Generic, Self::VoiceCoil, Self::InertialMotor, Self::RumbleMotor, Self::Lra, Self::Piezo];

    /// The word for it in a file.
    pub fn word(self) -> &'static str {
        WORDS[self as usize]
    }

    /// The model of a word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.word() == word)
    }
}

const WORDS: &[&str] = &["generic", "voice-coil", "inertial-motor", "rumble-motor", "lra", "piezo"];

impl Actuator {
    /// One of which nothing is known.
    pub fn generic(name: &str) -> Self {
        Self {
            name: name.into(),
            model: Model::Generic,
            part: None,
            values: BTreeMap::new(),
            equaliser: Vec::new(),
            even_out: None,
            span: 0..0,
            misread: Vec::new(),
        }
    }

    /// The figure at a key, SI units; `None`: unknown.
    pub fn value(&self, key: &str) -> Option<f64> {
        self.values.get(key).copied()
    }

    /// Takes over what a part says and the rig does not; but nothing that what the rig says takes the place of. Of a motor of which the rig says
    /// how it moves, what the part's looks like from outside is taken over in place of what it is made of.
    fn fill_in(&mut self, part: &Part) {
        let said = |key: &str| self.values.contains_key(key);
        let replaced: Vec<&str> = REPLACED
            .iter()
            .filter(|by| by.of.contains(&self.model) && said(by.said) && !by.unless.is_some_and(said))
            .flat_map(|by| by.replaces.iter().copied())
            .collect();
        let outside = if replaced.contains(&"torque_constant") {
            let mut like = Self::of_part(part);
            like.values.extend(self.value("mass").map(|mass| ("mass", mass)));
            like.outside().ok()
        } else {
            None
        };
        let own = part.values.iter().map(|(key, value)| (*key, value.value));
        let outside = outside.into_iter().flatten().filter_map(|(key, value)| Some((key, value?)));
        for (key, value) in own.filter(|(key, _)| !replaced.contains(key)).chain(outside) {
            self.values.entry(key).or_insert(value);
        }
    }
}

/// A figure that a rig says, and those of a part that it takes the place of.
struct Replaced {
    of: &'static [Model],
    said: &'static str,
    /// Not where the rig says this, too.
    unless: Option<&'static str>,
    replaces: &'static [&'static str],
}

const REPLACED: [Replaced; 3] = [
    Replaced {
        of: &[Model::RumbleMotor],
        said: "time_constant",
        unless: Some("torque_constant"),
        replaces: &[
            "torque_constant",
            "inertia",
            "viscous_friction",
            "coulomb_friction",
            "static_friction",
            "eccentric_moment",
        ],
    },
    Replaced {
        of: &[Model::VoiceCoil, Model::InertialMotor],
        said: "resonance",
        unless: None,
        replaces: &["stiffness"],
    },
    Replaced {
        of: &[Model::VoiceCoil, Model::InertialMotor],
        said: "q",
        unless: None,
        replaces: &["damping"],
    },
];

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
pub static TABLE: Table = Table { name: "actuator", doc: "What moves.", fields: &FIELDS, others: None };

const OWN: [Field; 4] = [
    Field::new("model", Form::Word(WORDS), "", "What it is; that of the part where one is named."),
    Field::new(
        "part",
        Form::Text,
        "",
        "A part that ships with pacinian: what is not said here is taken from it. `pacinian parts` lists them.",
    ),
    Field::new("equaliser", Form::Many(&PEAK), "", "Peaking filters that even it out, in order."),
    Field::new(
        "even_out",
        Form::One(&even::TABLE),
        "",
        "Takes its resonance out of what is felt, by its own model, as far as it and the amplifier bear that: even_out = {} for all that there is.",
    ),
];

const FIELDS: [Field; OWN.len() + quantity::COUNT] = {
    let mut fields = [const { Field::new("", Form::Text, "", "") }; OWN.len() + quantity::COUNT];
    let [model, part, equaliser, even_out] = OWN;
    fields[0] = model;
    fields[1] = part;
    let mut n = 0;
    while n < quantity::COUNT {
        fields[n + 2] = quantity::FIELDS[n];
        n += 1;
    }
    fields[quantity::COUNT + 2] = equaliser;
    fields[quantity::COUNT + 3] = even_out;
    fields
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
    let most = MOST_SECTIONS - usize::from(reader.has("even_out"));
    if peaks.len() > most {
        let what = format!("{} has {} filters, the most is {most}", reader.who, peaks.len());
        reader.sink.error(&reader.span_of("equaliser"), what);
    }
    let part = reader.text("part").and_then(|name| found(name, reader));
    let said = Model::ALL.get(reader.word("model")).copied().unwrap_or(Model::Generic);
    let model = match &part {
        Some(part) if !reader.has("model") => part.model,
        Some(part) if part.model != said => {
            let what = format!(
                "{} is of model {}, but the part `{}` is of model {}",
                reader.who,
                said.word(),
                part.name,
                part.model.word()
            );
            let help = "leave `model` out: the part says it".to_string();
            reader.sink.push(Problem::error(&reader.span_of("model"), what).help(help));
            part.model
        }
        _ => said,
    };
    let (mut values, mut misread) = (BTreeMap::new(), Vec::new());
    for (field, of) in quantity::FIELDS.iter().zip(MODELS).filter(|(field, _)| reader.has(field.key)) {
        if !of.is_empty() && !of.contains(&model) {
            let what = format!("{} is of model {}, which has no `{}`", reader.who, model.word(), field.key);
            let words: Vec<&str> = of.iter().map(|model| model.word()).collect();
            let help = format!("it is a figure of {}", words.join(", "));
            reader.sink.push(Problem::error(&reader.span_of(field.key), what).help(help));
            continue;
        }
        match reader.number(field.key) {
            Some(value) => _ = values.insert(field.key, value),
            None => misread.push(field.key),
        }
    }
    contradiction::tell(reader, model, &values);
    let mut actuator = Actuator {
        name: name.into(),
        model,
        part: part.map(|part| part.name.into()),
        values,
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
        even_out: even::read(reader, model),
        span: reader.span.clone(),
        misread,
    };
    if let Some(part) = part {
        actuator.fill_in(part);
    }
    actuator
}

fn found(name: &str, reader: &Reader) -> Option<&'static Part> {
    let part = part::find(name);
    if part.is_none() {
        let what = format!("{} is the part `{name}`, which is not among those that ship", reader.who);
        let help = suggest(name, part::all().iter().map(|part| part.name))
            .unwrap_or_else(|| "`pacinian parts` lists them; or give its figures here".to_string());
        reader.sink.push(Problem::error(&reader.span_of("part"), what).help(help));
    }
    part
}
