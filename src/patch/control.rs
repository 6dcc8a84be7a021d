//! A live parameter: what MIDI, OSC or a program may move while a patch plays.

use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// A control, `[control.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Its name, by which nodes read it.
    pub name: String,
    /// Value at the start.
    pub default: f64,
    /// Least and most.
    pub range: [f64; 2],
    /// Its unit, shown to people; may be empty.
    pub unit: String,
    /// How a position between 0 and 1 maps to the range.
    pub curve: Curve,
    /// Seconds in which it goes, in a straight line, to each new value.
    pub smoothing: f64,
    /// For one that a sensor moves, many times a second: seconds by which it is later than what comes, so that it goes in straight lines
    /// from one value to the next, whenever they arrive. 0 for one that goes to each new value by `smoothing`.
    pub stream: f64,
    /// Where it stands.
    pub span: Span,
}

/// How a position from 0 to 1 maps to a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// Equal steps are equal differences.
    Linear,
    /// Equal steps are equal ratios; the range lies above 0.
    Exponential,
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "control",
    doc: "A live parameter, which nodes read by its name.",
    fields: &[
        Field::new("default", Form::any_number(-1e9, 1e9), "", "Value at the start.").required(),
        Field::new("range", Form::Defined("range"), "", "Least and most; [0, 1] where nothing is said."),
        Field::new("unit", Form::Text, "", "Its unit, shown to people."),
        Field::new(
            "curve",
            Form::Word(&["linear", "exponential"]),
            "",
            "How a position from 0 to 1 maps to the range.",
        ),
        Field::new(
            "smoothing",
            Form::number(0.01, 0.0, 10.0),
            "s",
            "How long it takes to each new value, in a straight line.",
        ),
        Field::new(
            "stream",
            Form::number(0.0, 0.0, 1.0),
            "s",
            "For one that a sensor, a tracker or a mouse moves: how much later than what comes it is, so that it goes in straight lines \
             from value to value; longer than the longest pause between two (and their way here, where bundles say when they were sampled). 0 for a control that goes to each new value by itself.",
        ),
    ],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Control {
    let range = reader.at("range").map_or(Some([0.0, 1.0]), |value| {
        let numbers: Option<Vec<f64>> = value.list().and_then(|list| list.map(|v| v.number()).collect());
        match numbers.as_deref() {
            Some(&[least, most]) if least.is_finite() && most.is_finite() && least < most => {
                Some([least, most])
            }
            _ => {
                let wanted = match numbers.as_deref() {
                    Some(&[least, most]) if least >= most => "the first number must be less than the second",
                    Some(&[_, _]) => "both numbers must be finite",
                    _ => "it must be two numbers, [least, most]",
                };
                reader.wrong("range", &value, wanted);
                None
            }
        }
    });
    let default = reader.number("default");
    let curve = if reader.word("curve") == 0 { Curve::Linear } else { Curve::Exponential };
    if let (Some([least, most]), Some(default)) = (range, default) {
        if default < least || default > most {
            let what =
                format!("`default` of {} is {default}; its range is from {least} to {most}", reader.who);
            let help = (!reader.has("range"))
                .then(|| "give it `range = [LEAST, MOST]`; without, it is [0, 1]".to_string());
            reader.sink.push(Problem::error(&reader.span_of("default"), what).help(help));
        }
        if curve == Curve::Exponential && least <= 0.0 {
            let what = format!(
                "the range of {} begins at {least}; for an exponential curve it must lie above 0",
                reader.who
            );
            reader.sink.error(&reader.span_of("range"), what);
        }
    }
    Control {
        name: name.into(),
        default: default.unwrap_or(0.0),
        range: range.unwrap_or([0.0, 1.0]),
        unit: reader.text("unit").unwrap_or("").into(),
        curve,
        smoothing: reader.number_or_default("smoothing"),
        stream: reader.number_or_default("stream"),
        span: reader.span.clone(),
    }
}
