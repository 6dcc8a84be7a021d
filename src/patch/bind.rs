//! What moves a control from outside.

use super::control::{Control, Curve};
use crate::midi::Encoder;
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// A binding, `[[bind]]`: something that moves outside moves a control.
#[derive(Debug, Clone, PartialEq)]
pub struct Bind {
    /// What moves it.
    pub from: Mover,
    /// The control.
    pub control: String,
    /// Where that stands.
    pub control_span: Span,
    /// The MIDI channel, from 1; `None`: any.
    pub channel: Option<u8>,
    /// What its ends become, in the control's unit; `None`: the control's range.
    pub range: Option<[f64; 2]>,
    /// How a position between them maps; `None`: as the control says.
    pub curve: Option<Curve>,
    /// Of an OSC message, the numbers at its ends.
    pub sends: [f64; 2],
    /// Whether it moves the control only from where that stands, so that nothing jumps; a stream follows at once.
    pub pickup: bool,
    /// Of an endless knob that tells steps, how it says them: it moves the control on from where that stands.
    pub encoder: Option<Encoder>,
    /// The part of its range by which one such step moves it.
    pub step: f64,
    /// Where it stands.
    pub span: Span,
}

/// What moves a control.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Mover {
    /// A MIDI controller, 0 to 119; of a pair of 14 bits the lower number.
    Controller(u8),
    /// The wheel: from 0, down, to 1, up.
    Bend,
    /// The pressure on a channel or a key.
    Pressure,
    /// A number of the messages to an OSC address.
    Osc {
        /// The address.
        address: String,
        /// Which of the numbers, from 1 to [`ARGUMENTS`].
        argument: usize,
    },
}

/// The arguments of an OSC message that can be bound.
pub const ARGUMENTS: usize = 64;

/// The numbers at the ends of an OSC message where nobody says so.
pub const SENDS: [f64; 2] = [0.0, 1.0];

/// What one step of an encoder does where nobody says so: a hundred for the whole range.
pub const STEP: f64 = 0.01;

/// Its keys.
pub(crate) static TABLE: Table = Table {
    name: "bind",
    doc: "What moves a control from outside.",
    fields: &[
        Field::new(
            "from",
            Form::Text,
            "",
            "midi.controller 21, midi.bend, midi.pressure, osc./address or, of a message with several numbers, osc./address 2.",
        )
        .required(),
        Field::new("control", Form::Text, "", "The control that it moves.").required(),
        Field::new("channel", Form::any_count(1, 16), "", "The MIDI channel; any where nothing is said."),
        Field::new(
            "range",
            Form::Defined("range"),
            "",
            "What its ends become, in the control's unit, the first more than the second to turn it round; the control's range where \
             nothing is said.",
        ),
        Field::new(
            "curve",
            Form::Word(&["control", "linear", "exponential"]),
            "",
            "How positions between the ends map; `control` as the control says.",
        ),
        Field::new(
            "sends",
            Form::Defined("range"),
            "",
            "Of an OSC message: the numbers at its ends, as [-0.5, 0.5] of a tracker that says metres; [0, 1] where nothing is said.",
        ),
        Field::new(
            "pickup",
            Form::Flag(true),
            "",
            "Whether it moves the control only once it has come to where that stands, so that nothing jumps. A control that is a \
             stream follows at once.",
        ),
        Field::new(
            "encoder",
            Form::Word(&["none", "twos-complement", "binary-offset", "signed-bit"]),
            "",
            "Of a controller that is an endless knob and tells steps in place of positions: how it says them.",
        ),
        Field::new(
            "step",
            Form::Number { default: Some(STEP), least: 0.0, most: 1.0 },
            "",
            "Of an encoder: the part of the range, as the curve has it, by which one step moves the control.",
        ),
    ],
    others: None,
};

const NO_ADDRESS: &str = "an OSC address begins with `/` and has no blanks: osc./strength";

const MOVERS: &[&str] = &["midi.controller 21", "midi.bend", "midi.pressure", "osc./address"];

impl Mover {
    /// Reads what stands at `from`.
    ///
    /// # Errors
    /// Says what it cannot be.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some(number) = text.strip_prefix("midi.controller ") {
            return match number.trim().parse() {
                Ok(number) if number <= 119 => Ok(Self::Controller(number)),
                _ => Err(format!("`{number}` is no controller; they count from 0 to 119")),
            };
        }
        match (text, text.strip_prefix("osc.")) {
            ("midi.bend", _) => Ok(Self::Bend),
            ("midi.pressure", _) => Ok(Self::Pressure),
            (_, Some(words)) if words.starts_with('/') => {
                let (address, argument) = words.split_once(' ').unwrap_or((words, "1"));
                if address.contains(char::is_whitespace) {
                    return Err(NO_ADDRESS.into());
                }
                match argument.parse() {
                    Ok(argument @ 1..=ARGUMENTS) => Ok(Self::Osc { address: address.into(), argument }),
                    _ => Err(format!(
                        "behind the address stands which of the numbers in a message, from 1 to {ARGUMENTS}: osc.{address} 2"
                    )),
                }
            }
            (_, Some(_)) => Err(NO_ADDRESS.into()),
            _ => Err("nothing like that moves a control".into()),
        }
    }
}

/// As `from` of a binding says it.
impl std::fmt::Display for Mover {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Controller(number) => write!(f, "midi.controller {number}"),
            Self::Bend => f.write_str("midi.bend"),
            Self::Pressure => f.write_str("midi.pressure"),
            Self::Osc { address, argument: 1 } => write!(f, "osc.{address}"),
            Self::Osc { address, argument } => write!(f, "osc.{address} {argument}"),
        }
    }
}

impl Bind {
    /// One that moves a control by all its range, on any channel, from where it stands on.
    pub fn new(from: Mover, control: &str) -> Self {
        Self {
            from,
            control: control.into(),
            control_span: Span::default(),
            channel: None,
            range: None,
            curve: None,
            sends: SENDS,
            pickup: true,
            encoder: None,
            step: STEP,
            span: Span::default(),
        }
    }

    /// The position of a number in an OSC message: 0 and 1 at the ends, and beyond them.
    pub fn position_of(&self, number: f64) -> f64 {
        let [from, to] = self.sends;
        (number.clamp(from.min(to), from.max(to)) - from) / (to - from)
    }

    /// What the control becomes at a position from 0 to 1.
    pub fn value(&self, control: &Control, position: f64) -> f64 {
        let [from, to] = self.range.unwrap_or(control.range);
        let position = position.clamp(0.0, 1.0);
        match self.curve.unwrap_or(control.curve) {
            Curve::Exponential if from > 0.0 && to > 0.0 => from * (to / from).powf(position),
            _ => from + (to - from) * position,
        }
    }

    /// What the control becomes from `value` on when an encoder says this, 0 to 127; the same where it says no step. Beyond the ends of the range it goes on
    /// from the nearer one.
    pub fn turned(&self, encoder: Encoder, control: &Control, value: f64, says: u8) -> f64 {
        let steps = encoder.steps(says);
        if steps == 0 {
            return value;
        }
        let [from, to] = self.range.unwrap_or(control.range);
        let within = value.clamp(from.min(to), from.max(to));
        let position = self.position(control, within).unwrap_or(0.0);
        self.value(control, position + f64::from(steps) * self.step)
    }

    /// The position at which the control is what it is, where there is one.
    pub fn position(&self, control: &Control, value: f64) -> Option<f64> {
        let [from, to] = self.range.unwrap_or(control.range);
        let position = match self.curve.unwrap_or(control.curve) {
            Curve::Exponential if from > 0.0 && to > 0.0 => (value / from).ln() / (to / from).ln(),
            _ => (value - from) / (to - from),
        };
        (-1e-9..=1.0 + 1e-9).contains(&position).then_some(position)
    }
}

pub(crate) fn read(reader: &Reader) -> Option<Bind> {
    let from = reader.text("from").and_then(|text| match Mover::parse(text) {
        Ok(from) => Some(from),
        Err(why) => {
            let what = format!("`from` of {} cannot be \"{text}\": {why}", reader.who);
            let problem = Problem::error(&reader.span_of("from"), what);
            reader.sink.push(problem.help(suggest(text, MOVERS.iter().copied())));
            None
        }
    });
    let range = ends(reader, "range");
    let sends = ends(reader, "sends");
    if sends.is_some() && from.as_ref().is_some_and(|from| !matches!(from, Mover::Osc { .. })) {
        let what = format!("`sends` of {}: only OSC sends numbers of any size", reader.who);
        let help = "what MIDI says goes from 0 to 1; `range` says what its ends become".to_string();
        reader.sink.push(Problem::error(&reader.span_of("sends"), what).help(help));
    }
    let curve = match reader.word("curve") {
        1 => Some(Curve::Linear),
        2 => Some(Curve::Exponential),
        _ => None,
    };
    let encoder = reader.word("encoder").checked_sub(1).and_then(|n| Encoder::ALL.get(n).copied());
    if encoder.is_some() && from.as_ref().is_some_and(|from| !matches!(from, Mover::Controller(_))) {
        reader.sink.push(
            Problem::error(
                &reader.span_of("encoder"),
                format!("`encoder` of {}: only a controller tells steps", reader.who),
            )
            .help(
                "from = \"midi.controller 21\"; the wheel, pressure and OSC say where they stand".to_string(),
            ),
        );
    }
    Some(Bind {
        control: reader.text("control")?.into(),
        control_span: reader.span_of("control"),
        channel: reader.count("channel").and_then(|n| u8::try_from(n).ok()),
        range,
        curve,
        sends: sends.unwrap_or(SENDS),
        pickup: reader.flag("pickup"),
        encoder,
        step: reader.number_or_default("step"),
        span: reader.span.clone(),
        // What is wrong has been reported; what it moves can be looked at all the same.
        from: from.unwrap_or(Mover::Bend),
    })
}

/// Two numbers, as far from each other as both are precise.
fn ends(reader: &Reader, key: &str) -> Option<[f64; 2]> {
    let value = reader.at(key)?;
    let numbers: Option<Vec<f64>> = value.list().and_then(|list| list.map(|v| v.number()).collect());
    match numbers.as_deref() {
        Some(&[from, to]) if from.is_finite() && to.is_finite() && (to - from).is_normal() => {
            Some([from, to])
        }
        _ => {
            reader.wrong(key, &value, "it must be two different numbers, [from, to]");
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Bind, Mover};
    use crate::midi::Encoder;
    use crate::patch::{Control, Curve};
    use crate::text::field::Form;

    #[test]
    fn what_may_stand_there() {
        assert_eq!(Mover::parse("midi.controller 21"), Ok(Mover::Controller(21)));
        for (text, argument) in [("osc./a/b", 1), ("osc./a/b 2", 2), ("osc./a/b 64", 64)] {
            let mover = Mover::parse(text).unwrap();
            assert_eq!(mover, Mover::Osc { address: "/a/b".into(), argument });
            assert_eq!(mover.to_string(), text);
        }
        assert_eq!(Mover::parse("osc./a 1").unwrap().to_string(), "osc./a");
        for wrong in ["osc./a 0", "osc./a 65", "osc./a b", "osc./a  2", "osc./a\t2", "osc./a 2 3", "osc. /a"]
        {
            assert!(Mover::parse(wrong).is_err(), "{wrong}");
        }
        for wrong in ["midi.controller 120", "midi.controller x", "osc.a", "midi.note", ""] {
            assert!(Mover::parse(wrong).is_err(), "{wrong}");
        }
    }

    fn control(curve: Curve) -> Control {
        Control {
            name: "c".into(),
            default: 20.0,
            range: [10.0, 1000.0],
            unit: String::new(),
            curve,
            smoothing: 0.0,
            stream: 0.0,
            span: 0..0,
        }
    }

    /// What a patch may say is what there is.
    #[test]
    fn every_encoder_has_its_word() {
        let words = super::TABLE.fields.iter().find(|field| field.key == "encoder").map(|field| &field.form);
        let Some(Form::Word(words)) = words else { panic!("no words") };
        let names = Encoder::ALL.map(Encoder::name);
        assert_eq!(words[1..], names);
    }

    /// A hundred steps are the whole range, in ratios where the curve has them, and back again.
    #[test]
    fn steps_of_an_encoder_go_along_the_curve() {
        for (curve, range) in
            [(Curve::Linear, None), (Curve::Exponential, None), (Curve::Exponential, Some([800.0, 20.0]))]
        {
            let bind = Bind { range, ..Bind::new(Mover::Controller(1), "c") };
            let control = control(curve);
            let [from, to] = range.unwrap_or(control.range);
            let turn = |value, says| bind.turned(Encoder::TwosComplement, &control, value, says);
            let up: Vec<f64> =
                std::iter::successors(Some(from), |value| Some(turn(*value, 1))).take(101).collect();
            assert!((up[100] / to - 1.0).abs() < 1e-9, "{}", up[100]);
            assert!((up[50] / bind.value(&control, 0.5) - 1.0).abs() < 1e-9, "{}", up[50]);
            assert!((turn(up[30], 127) / up[29] - 1.0).abs() < 1e-9);
            assert_eq!((turn(from, 127), turn(to, 1)), (from, to), "the ends are the ends");
            assert_eq!(turn(123.4, 0), 123.4);
        }
    }

    #[test]
    fn positions_and_values_are_inverse() {
        let bind = |range, curve| Bind { range, curve, ..Bind::new(Mover::Bend, "c") };
        let exponential = bind(None, None);
        // A tenth of the way in ratios: 10 * 100^0.5.
        assert!((exponential.value(&control(Curve::Exponential), 0.5) - 100.0).abs() < 1e-9);
        for curve in [Curve::Linear, Curve::Exponential] {
            for bind in [bind(None, None), bind(Some([500.0, 20.0]), None), bind(None, Some(Curve::Linear))] {
                let control = control(curve);
                for position in [0.0, 0.25, 1.0] {
                    let back = bind.position(&control, bind.value(&control, position)).unwrap();
                    assert!((back - position).abs() < 1e-12);
                }
            }
        }
        assert_eq!(bind(Some([500.0, 20.0]), None).position(&control(Curve::Linear), 900.0), None);
    }
}
