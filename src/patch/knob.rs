//! What a force-feedback knob feels like, `[knob]`: effects that add up.

mod figures;
mod kinds;

use super::control::{Control, Curve};
use super::expr::Expr;
use super::node::{Argument, Node, Value};
use super::trigger::Happening;
use crate::actuator::fault::Fault;
use crate::knob::effect::program::{Any, MOST_EFFECTS};
use crate::node::NodeKind;
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::{Problem, Span};
use figures::figures;
use kinds::COMMON;
pub use kinds::{EFFECT, TABLE, TYPES, Type};
use std::f64::consts::TAU;

/// A knob, as a patch wants it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Knob {
    /// What it feels like, in the order of the file, but those that begin with contact last.
    pub effects: Vec<Effect>,
    /// Where it stands.
    pub span: Span,
}

/// An effect, `[knob.effects] NAME = { type = ... }`.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Its figures.
    pub figures: Any,
    /// Factor of its torque.
    pub gain: Scaled,
    /// By how much it is turned, radians.
    pub shift: Scaled,
    /// What a texture plays.
    pub signal: Scaled,
    /// Where it stands.
    pub span: Span,
}

/// What scales an effect.
#[derive(Debug, Clone, PartialEq)]
pub enum Scaled {
    /// A number.
    Constant(f64),
    /// A shared node of this name, made for an expression.
    Node(String),
}

/// Readings of the knob that expressions may name: `knob.angle`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reading {
    /// Radians, as read.
    Angle,
    /// Radians a second, as estimated.
    Speed,
    /// Newton metres that it was given.
    Torque,
    /// Notches passed within the sample, with the sign of the turn; else 0.
    Detent,
    /// How fast a wall was hit within the sample, rad/s; else 0.
    Wall,
}

impl Reading {
    /// All, as they are numbered.
    pub const ALL: [Self; 5] = [Self::Angle, Self::Speed, Self::Torque, Self::Detent, Self::Wall];
    /// Their words.
    pub const WORDS: [&'static str; 5] = ["angle", "speed", "torque", "detent", "wall"];

    /// Of what happens to it, what that is.
    pub(crate) fn happens(self) -> Option<Happening> {
        match self {
            Self::Angle | Self::Speed | Self::Torque => None,
            Self::Detent => Some(Happening::Detent),
            Self::Wall => Some(Happening::Wall),
        }
    }

    /// That of a word.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Self::WORDS.iter().position(|w| *w == word).and_then(|place| Self::ALL.get(place)).copied()
    }
}

impl Knob {
    /// That a trigger waits for what never happens: an effect that is not there, or one to which it does not happen.
    pub(super) fn never(&self, what: Happening, effect: Option<&str>, span: &Span) -> Option<Problem> {
        let happens = |figures: &Any| match what {
            Happening::Detent => matches!(figures, Any::Detent(_) | Any::Snap(_)),
            Happening::Wall => matches!(figures, Any::Wall(_) | Any::Stops(_) | Any::Hertz(_)),
        };
        let able = || self.effects.iter().filter(|e| happens(&e.figures)).map(|e| e.name.as_str());
        let word = what.word();
        let told = match effect {
            Some(name) => match self.effects.iter().find(|e| e.name == name) {
                None => format!("`{word} {name}`: the knob has no effect `{name}`"),
                Some(effect) if !happens(&effect.figures) => {
                    format!("`{word}` never happens to effect `{name}`")
                }
                Some(_) => return None,
            },
            None if able().next().is_none() => {
                format!("`{word}` never happens: no effect of the knob is such that it does")
            }
            None => return None,
        };
        let types = match what {
            Happening::Detent => "detents or snap",
            Happening::Wall => "wall, end-stops or contact",
        };
        let all: Vec<&str> = able().collect();
        let help = effect.and_then(|name| suggest(name, all.iter().copied())).unwrap_or_else(|| {
            match all.is_empty() {
                true => format!("it happens to effects of type {types}"),
                false => format!("it happens to {}", all.join(", ")),
            }
        });
        Some(Problem::error(span, told).help(help))
    }
}

/// The control by which a simulated knob is turned.
pub const HAND: &str = "hand";

/// The angle of the hand that turns a simulated knob, rad, where the patch does not say how far it goes.
pub(crate) fn hand(span: &Span) -> Control {
    Control {
        name: HAND.into(),
        default: 0.0,
        range: [-TAU, TAU],
        unit: "rad".into(),
        curve: Curve::Linear,
        smoothing: 0.1,
        stream: 0.0,
        span: span.clone(),
    }
}

/// The knob of a patch. Expressions become nodes that are added to the shared ones.
pub(crate) fn read(reader: &Reader, shared: &mut Vec<Node>) -> Knob {
    let mut effects = Vec::new();
    for (name, reader) in reader.named("effects", "effect") {
        if effects.len() == MOST_EFFECTS {
            let what = format!("a knob has {MOST_EFFECTS} effects at most");
            reader.sink.push(Problem::error(&reader.span, what));
            break;
        }
        effects.extend(effect(&name, &reader, shared));
    }
    // A ringing hears what hits a wall in the same tick, from those before it.
    effects.sort_by_key(|effect| matches!(effect.figures, Any::Transient(_)));
    let heard = effects.iter().any(|e| matches!(e.figures, Any::Wall(_) | Any::Stops(_) | Any::Hertz(_)));
    if let Some(effect) = effects.iter().find(|e| matches!(e.figures, Any::Transient(_)) && !heard) {
        let what = format!("effect `{}` rings as a wall is hit, and the knob has none", effect.name);
        let help = "add an effect of type wall, end-stops or contact".to_string();
        reader.sink.push(Problem::warning(&effect.span, what).help(help));
    }
    Knob { effects, span: reader.span.clone() }
}

fn effect(name: &str, reader: &Reader, shared: &mut Vec<Node>) -> Option<Effect> {
    if !reader.has("type") {
        return None;
    }
    let kind = TYPES.get(reader.word("type"))?;
    let mut fine = true;
    for key in EFFECT.keys().filter(|key| reader.has(key) && !COMMON.contains(key)) {
        if !kind.needs.contains(&key) && !kind.may.contains(&key) {
            let keys: Vec<&str> = kind.needs.iter().chain(kind.may).chain(&COMMON[1..]).copied().collect();
            let what = format!("{} is of type {}, which has no `{key}`", reader.who, kind.word);
            let help =
                suggest(key, keys.iter().copied()).unwrap_or_else(|| format!("it has {}", keys.join(", ")));
            reader.sink.push(Problem::error(&reader.span_of(key), what).help(help));
            fine = false;
        }
    }
    for key in kind.needs.iter().filter(|key| !reader.has(key)) {
        let what = format!("{} is of type {} and lacks `{key}`", reader.who, kind.word);
        let help = EFFECT.field(key).map(|field| EFFECT.to_add(field));
        reader.sink.push(Problem::error(&reader.span, what).help(help));
        fine = false;
    }
    let (gain, shift) =
        (scaled(name, "gain", 1.0, reader, shared), scaled(name, "shift", 0.0, reader, shared));
    let signal = scaled(name, "signal", 0.0, reader, shared);
    let figures = figures(kind.word, reader).filter(|_| fine)?;
    match figures {
        Ok(figures) if figures.check().is_ok() => Some(Effect {
            name: name.into(),
            figures,
            gain: gain?,
            shift: shift?,
            signal: signal?,
            span: reader.span.clone(),
        }),
        Ok(figures) => {
            wrong(reader, kind, &figures.check().err()?);
            None
        }
        Err(fault) => {
            wrong(reader, kind, &fault);
            None
        }
    }
}

fn wrong(reader: &Reader, kind: &Type, fault: &Fault) {
    // The library's word for a figure may not be the file's.
    let key = match fault.field {
        "amplitude" | "most" | "scale" => "torque",
        "hertz" => "frequency",
        "stretch" | "z_max" => "stretch",
        "shape" => "table",
        field => field,
    };
    let what = format!("{} ({}): {}", reader.who, kind.word, Fault { field: key, ..*fault });
    let span = if reader.has(key) { reader.span_of(key) } else { reader.span.clone() };
    reader.sink.push(Problem::error(&span, what));
}

/// A number or an expression, which becomes a shared node.
fn scaled(
    name: &str,
    key: &'static str,
    otherwise: f64,
    reader: &Reader,
    shared: &mut Vec<Node>,
) -> Option<Scaled> {
    let Some(value) = reader.at(key) else { return Some(Scaled::Constant(otherwise)) };
    if let Some(number) = value.number() {
        return reader.number_in(key, &value, -1e6, 1e6).map(|_| Scaled::Constant(number));
    }
    let Some(text) = value.text() else {
        reader.mistaken(key, &value, "a number or an expression");
        return None;
    };
    if key == "signal" && text == VOICES {
        return Some(Scaled::Node(VOICES.into()));
    }
    let span = value.span();
    let expr = Expr::parse(text, &span).map_err(|problem| reader.sink.push(problem)).ok()?;
    if let Some(number) = expr.constant() {
        return Some(Scaled::Constant(number));
    }
    let node = format!("knob.{name}.{key}");
    let argument = Argument { value: Value::Signals(vec![expr]), span: span.clone() };
    shared.push(Node { name: node.clone(), kind: NodeKind::ADD, arguments: vec![argument], span });
    Some(Scaled::Node(node))
}

/// The signal that is whatever voices play at the knob's output.
pub const VOICES: &str = "voices";

#[cfg(test)]
mod tests;
