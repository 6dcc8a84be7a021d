//! What a force-feedback knob feels like, `[knob]`: effects that add up.

use super::control::{Control, Curve};
use super::expr::Expr;
use super::node::{Argument, Node, Value};
use super::trigger::Happening;
use crate::actuator::fault::Fault;
use crate::knob::effect::program::{Any, MOST_EFFECTS};
use crate::knob::effect::{
    constant, damper, detent, friction, hertz, inertia, magnet, snap, spin, spring, table, texture,
    transient, wall,
};
use crate::node::NodeKind;
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::{Problem, Span};
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

/// A type of effect.
#[derive(Debug)]
pub struct Type {
    /// The word for it.
    pub word: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// Keys that it must have.
    pub needs: &'static [&'static str],
    /// Keys that it may have.
    pub may: &'static [&'static str],
}

const fn of(
    word: &'static str,
    needs: &'static [&'static str],
    may: &'static [&'static str],
    doc: &'static str,
) -> Type {
    Type { word, doc, needs, may }
}

/// Types of effects.
pub static TYPES: [Type; 16] = [
    of("spring", &["stiffness"], &["centre"], "-K (angle - centre)"),
    of("damper", &["damping"], &[], "-B times the estimated speed"),
    of(
        "wall",
        &["angle", "stiffness"],
        &["damping", "side"],
        "a wall, which pushes and never pulls; a `knob.wall` as it is hit",
    ),
    of(
        "end-stops",
        &["low", "high", "stiffness"],
        &["damping"],
        "two walls with a range between them; a `knob.wall` as either is hit",
    ),
    of(
        "detents",
        &["count", "torque"],
        &["centre", "shape", "table", "hysteresis"],
        "so many notches a turn, the strongest pull of each `torque`; a `knob.detent` as one is passed",
    ),
    of(
        "snap",
        &["width", "stiffness", "torque"],
        &["point", "centre"],
        "a spring to the nearest of places `width` apart, at most `torque`, which changes over with hysteresis",
    ),
    of(
        "magnet",
        &["centre", "stiffness", "reach"],
        &[],
        "a pull to an angle that ends at its reach, smooth everywhere",
    ),
    of(
        "friction",
        &["torque"],
        &["stretch", "law"],
        "dry friction of displacement alone: it needs no speed and does not drift",
    ),
    of("inertia", &["inertia", "stiffness"], &["damping"], "a flywheel behind a spring and a damper"),
    of("constant", &["torque"], &[], "a torque that depends on nothing; positive turns to larger angles"),
    of(
        "spin",
        &["speed", "damping", "torque"],
        &[],
        "a pull to a speed, at most `torque`: it turns by itself",
    ),
    of("ripple", &["torque", "wavelength"], &[], "a sine over the angle"),
    of("texture", &["torque", "signal"], &[], "a signal of the patch times a torque"),
    of("table", &["points"], &[], "torque over angle, straight lines between points"),
    of(
        "contact",
        &["angle", "factor", "torque"],
        &["side"],
        "a round body in the way (Hertz): factor times depth to the power of 3/2, at most `torque`",
    ),
    of(
        "transient",
        &["strength", "frequency", "decay"],
        &["least", "torque"],
        "a ringing as a wall is hit, as strong as that was fast",
    ),
];

/// Keys that every effect may have.
const COMMON: [&str; 3] = ["type", "gain", "shift"];

/// The words for the types.
const WORDS: [&str; 16] = {
    let mut words = [""; 16];
    let mut n = 0;
    while n < 16 {
        words[n] = TYPES[n].word;
        n += 1;
    }
    words
};

/// Its keys.
pub static TABLE: Table = Table {
    name: "knob",
    doc: "What a force-feedback knob feels like. The rig says what the knob is; where it has none, one is simulated.",
    fields: &[
        Field::new("effects", Form::Named(&EFFECT), "", "Effects, by name; their torques add up.").required()
    ],
    others: None,
};

/// The keys of an effect.
pub static EFFECT: Table = Table {
    name: "effect",
    doc: "An effect: a torque of the knob that depends on its angle, its speed, or a signal.",
    fields: &[
        Field::new("type", Form::Word(&WORDS), "", "What it does.").required(),
        Field::new("torque", Form::any_number(-1e3, 1e3), "N m", "Its torque, or the most of it."),
        Field::new(
            "stiffness",
            Form::any_number(0.0, 1e6),
            "N m/rad",
            "How stiff it is. More than the device bears is held to that.",
        ),
        Field::new(
            "damping",
            Form::any_number(0.0, 1e3),
            "N m s/rad",
            "How viscous it is; 0 of walls where nothing is said.",
        ),
        Field::new(
            "centre",
            Form::number(0.0, -1e6, 1e6),
            "rad",
            "Where it is at rest, or one of its places is.",
        ),
        Field::new("angle", Form::any_number(-1e6, 1e6), "rad", "Where it begins."),
        Field::new(
            "side",
            Form::Word(&["above", "below"]),
            "",
            "Of a wall or a contact: it stands in the way of larger angles, or of smaller ones.",
        ),
        Field::new("low", Form::any_number(-1e6, 1e6), "rad", "The smallest free angle."),
        Field::new("high", Form::any_number(-1e6, 1e6), "rad", "The largest free angle."),
        Field::new("count", Form::any_number(1e-3, 1e5), "a turn", "How many detents."),
        Field::new("shape", Form::Word(&["sine", "triangle"]), "", "How torque runs from detent to detent."),
        Field::new(
            "table",
            Form::Defined("numbers"),
            "",
            "In place of a shape: torque over `torque` at equal steps from crest to crest, 2 or more values within -1 and 1.",
        ),
        Field::new(
            "hysteresis",
            Form::number(0.05, 0.0, 0.4),
            "pitches",
            "By how much a crest must be passed until the detent counts as passed.",
        ),
        Field::new("width", Form::any_number(1e-6, 1e6), "rad", "From place to place."),
        Field::new(
            "point",
            Form::number(0.6, 0.5, 1.0),
            "widths",
            "How far from its place the knob changes over to the next: 0.5 is no hysteresis.",
        ),
        Field::new("reach", Form::any_number(1e-9, 1e6), "rad", "How far from its centre it pulls."),
        Field::new(
            "stretch",
            Form::number(0.01, 1e-9, 1e3),
            "rad",
            "How far the knob gives before it slides: several counts of the encoder.",
        ),
        Field::new(
            "law",
            Form::Word(&["adhesion", "dahl"]),
            "",
            "Whether friction gives like a spring until it slides, or more and more.",
        ),
        Field::new("inertia", Form::any_number(1e-12, 1e3), "kg m2", "Of the flywheel."),
        Field::new("speed", Form::any_number(-1e4, 1e4), "rad/s", "The speed that it pulls to."),
        Field::new("wavelength", Form::any_number(1e-6, 1e6), "rad", "From crest to crest."),
        Field::new(
            "signal",
            Form::Defined("signal"),
            "",
            "A number or an expression of shared nodes, controls and `knob.speed`; \"voices\": what is played at the knob's output.",
        ),
        Field::new(
            "points",
            Form::Defined("curve"),
            "rad, N m",
            "Pairs of angle and torque, angles rising; beyond the ends, the torque of the end.",
        ),
        Field::new("factor", Form::any_number(1e-9, 1e9), "N m/rad^1.5", "Of a contact."),
        Field::new(
            "strength",
            Form::any_number(0.0, 1e3),
            "N m s/rad",
            "Amplitude of a ringing for a hit at 1 rad/s.",
        ),
        Field::new("frequency", Form::any_number(20.0, 300.0), "Hz", "Of a ringing."),
        Field::new("decay", Form::any_number(1e-3, 10.0), "s", "In which a ringing falls to 1/e."),
        Field::new("least", Form::number(0.05, 0.0, 1e4), "rad/s", "Hits slower than this pass unheard."),
        Field::new(
            "gain",
            Form::Defined("signal"),
            "",
            "Factor of its torque: a number, or an expression of shared nodes, controls and `knob.speed`; 1 where nothing is said.",
        ),
        Field::new(
            "shift",
            Form::Defined("signal"),
            "rad",
            "By how much it is turned: a number or such an expression; 0 where nothing is said.",
        ),
    ],
    others: None,
};

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

/// The figures of an effect; `None` where one that it needs cannot be read, which has been told.
fn figures(word: &str, reader: &Reader) -> Option<Result<Any, Fault>> {
    let number = |key: &str| reader.number(key);
    let or = |key: &str| reader.number_or_default(key);
    let damping = || if reader.has("damping") { reader.number("damping") } else { Some(0.0) };
    let below = || reader.word("side") == 1;
    Some(Ok(match word {
        "spring" => spring::Spring { stiffness: number("stiffness")?, centre: or("centre") }.into(),
        "damper" => damper::Damper { damping: number("damping")? }.into(),
        "wall" => {
            let (angle, stiffness) = (number("angle")?, number("stiffness")?);
            wall::Wall { angle, below: below(), stiffness, damping: damping()? }.into()
        }
        "end-stops" => {
            let (low, high) = (number("low")?, number("high")?);
            wall::Stops { low, high, stiffness: number("stiffness")?, damping: damping()? }.into()
        }
        "detents" => {
            let shape = match reader.at("table") {
                Some(_) => detent::Shape::Table(numbers(reader, "table")?.into()),
                None if reader.word("shape") == 1 => detent::Shape::Triangle,
                None => detent::Shape::Sine,
            };
            let (count, amplitude) = (number("count")?, number("torque")?);
            detent::Detent { count, amplitude, centre: or("centre"), shape, hysteresis: or("hysteresis") }
                .into()
        }
        "snap" => {
            let (width, stiffness, most) = (number("width")?, number("stiffness")?, number("torque")?);
            snap::Snap { width, stiffness, most, point: or("point"), centre: or("centre") }.into()
        }
        "magnet" => {
            magnet::Magnet { centre: or("centre"), stiffness: number("stiffness")?, reach: number("reach")? }
                .into()
        }
        "friction" => {
            let law = if reader.word("law") == 1 { friction::Law::Dahl } else { friction::Law::Adhesion };
            friction::Friction { torque: number("torque")?, stretch: or("stretch"), law }.into()
        }
        "inertia" => {
            let (inertia, stiffness) = (number("inertia")?, number("stiffness")?);
            // Critically damped, so that it does not swing behind its spring.
            let damping =
                if reader.has("damping") { number("damping")? } else { 2.0 * (inertia * stiffness).sqrt() };
            inertia::Inertia { inertia, stiffness, damping }.into()
        }
        "constant" => constant::Constant { torque: number("torque")? }.into(),
        "spin" => {
            spin::Spin { speed: number("speed")?, damping: number("damping")?, most: number("torque")? }
                .into()
        }
        "ripple" => {
            texture::Ripple { amplitude: number("torque")?, wavelength: number("wavelength")? }.into()
        }
        "texture" => texture::Fed { scale: number("torque")? }.into(),
        "table" => return Some(table::Table::new(&points(reader)?).map(Into::into)),
        "contact" => {
            let (angle, factor) = (number("angle")?, number("factor")?);
            hertz::Hertz { angle, below: below(), factor, most: number("torque")? }.into()
        }
        _ => {
            let (strength, hertz) = (number("strength")?, number("frequency")?);
            let most = if reader.has("torque") { number("torque")? } else { 1e3 };
            transient::Transient { strength, hertz, decay: number("decay")?, least: or("least"), most }.into()
        }
    }))
}

fn numbers(reader: &Reader, key: &str) -> Option<Vec<f64>> {
    let value = reader.at(key)?;
    let list: Option<Vec<f64>> = value.list().and_then(|list| list.map(|v| v.number()).collect());
    if list.is_none() {
        reader.mistaken(key, &value, "a list of numbers");
    }
    list
}

fn points(reader: &Reader) -> Option<Vec<(f64, f64)>> {
    let value = reader.at("points")?;
    let pair = |value: crate::text::reader::At| {
        let pair: Vec<f64> = value.list()?.map(|v| v.number()).collect::<Option<_>>()?;
        if let [angle, torque] = pair[..] { Some((angle, torque)) } else { None }
    };
    let list: Option<Vec<_>> = value.list().and_then(|list| list.map(pair).collect());
    if list.is_none() {
        reader.mistaken("points", &value, "pairs of an angle and a torque: [[-0.5, 0.02], [0.5, -0.02]]");
    }
    list
}

#[cfg(test)]
mod tests {
    use super::{Any, EFFECT, Knob, Scaled, TYPES};
    use crate::patch::Patch;
    use crate::patch::reference::TOPICS;

    fn patch(effects: &str, more: &str) -> Result<Patch, String> {
        let text =
            format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{more}\n[knob.effects]\n{effects}\n");
        Patch::parse("t", text.as_bytes())
            .map(|checked| checked.value)
            .map_err(|problems| problems.to_string())
    }

    fn knob(effects: &str) -> Knob {
        patch(effects, "").unwrap_or_else(|p| panic!("{p}")).knob.unwrap()
    }

    fn told(effects: &str) -> String {
        patch(effects, "").map(|_| effects.to_string()).unwrap_err()
    }

    /// A figure that fits each key.
    fn figure(key: &str) -> &'static str {
        match key {
            "low" => "-1",
            "signal" => "\"voices\"",
            "points" => "[[-1, 0.1], [1, -0.1]]",
            "frequency" => "100",
            "point" => "0.7",
            _ => "1",
        }
    }

    #[test]
    fn every_type_is_read_with_its_keys_and_told_of_without_one_of_them() {
        for kind in &TYPES {
            let keys: Vec<String> = kind.needs.iter().map(|key| format!("{key} = {}", figure(key))).collect();
            let of = |keys: &[String]| format!("e = {{ type = \"{}\", {} }}", kind.word, keys.join(", "));
            // A ringing alone is told of, and not refused.
            assert_eq!(knob(&of(&keys)).effects.len(), 1, "{}", kind.word);
            for (n, key) in kind.needs.iter().enumerate() {
                let mut fewer = keys.clone();
                fewer.remove(n);
                let what = told(&of(&fewer));
                assert!(what.contains(&format!("lacks `{key}`")) && what.contains(kind.word), "{what}");
            }
            let mut more = keys.clone();
            let other = EFFECT.keys().find(|key| {
                !kind.needs.contains(key)
                    && !kind.may.contains(key)
                    && !["type", "gain", "shift"].contains(key)
            });
            let other = other.unwrap();
            more.push(format!("{other} = {}", if other == "law" { "\"dahl\"" } else { figure(other) }));
            assert!(told(&of(&more)).contains(&format!("has no `{other}`")), "{}", told(&of(&more)));
        }
    }

    #[test]
    fn every_type_is_described() {
        let topic = TOPICS.iter().find(|topic| topic.name == "knob").unwrap();
        for kind in &TYPES {
            let line = topic.text.lines().find(|line| line.starts_with(&format!("- {}: ", kind.word)));
            let line = line.unwrap_or_else(|| panic!("{}", kind.word));
            for key in kind.needs.iter().chain(kind.may) {
                assert!(line.contains(key), "{line}: {key}");
            }
        }
    }

    #[test]
    fn expressions_become_shared_nodes_and_numbers_stay_numbers() {
        let text = "a = { type = \"spring\", stiffness = 0.1, gain = \"2 * strength\", shift = 0.5 }\n\
            b = { type = \"texture\", torque = 0.1, signal = \"abs(knob.speed)\" }\n";
        let patch = patch(text, "[control.strength]\ndefault = 1\n").unwrap();
        let effects = patch.knob.unwrap().effects;
        assert_eq!(effects[0].gain, Scaled::Node("knob.a.gain".into()));
        assert_eq!((&effects[0].shift, &effects[0].signal), (&Scaled::Constant(0.5), &Scaled::Constant(0.0)));
        assert_eq!(effects[1].signal, Scaled::Node("knob.b.signal".into()));
        let names: Vec<&str> = patch.shared.iter().map(|node| node.name.as_str()).collect();
        assert_eq!(names, ["knob.a.gain", "knob.b.signal"]);
        let controls: Vec<&str> = patch.controls.iter().map(|control| control.name.as_str()).collect();
        assert_eq!(controls, ["strength", "hand"]);
    }

    #[test]
    fn a_ringing_comes_after_the_wall_that_it_rings_at() {
        let text = "ring = { type = \"transient\", strength = 0.01, frequency = 100, decay = 0.02 }\n\
            wall = { type = \"wall\", angle = 1, stiffness = 0.1 }\n";
        let knob = knob(text);
        assert!(matches!(knob.effects[1].figures, Any::Transient(_)), "{knob:?}");
    }

    #[test]
    fn what_cannot_be_is_told_with_its_key() {
        for (effects, what) in [
            ("e = { type = \"spring\", stiffness = -1 }", "stiffness"),
            ("e = { type = \"sprung\", stiffness = 1 }", "sprung"),
            ("e = { stiffness = 1 }", "lacks `type`"),
            (
                "e = { type = \"end-stops\", low = 1, high = -1, stiffness = 1 }",
                "`high` is -1, but must be at least 1",
            ),
            ("e = { type = \"table\", points = [[0, 1]] }", "`points` is 1, but must be within 2"),
            ("e = { type = \"table\", points = [[1, 0], [0, 0]] }", "`angle`"),
            ("e = { type = \"table\", points = [[1, 0, 2], [0, 0]] }", "pairs of an angle"),
            ("e = { type = \"detents\", count = 0, torque = 1 }", "count"),
            ("e = { type = \"detents\", count = 4, torque = -1 }", "`torque`"),
            ("e = { type = \"detents\", count = 4, torque = 1, table = [0, 2] }", "`table`"),
            ("e = { type = \"spring\", stiffness = 1, gain = \"strenght\" }", "strenght"),
            ("e = { type = \"spring\", stiffness = 1, gain = \"event.level\" }", "event"),
            ("e = { type = \"spring\", stiffness = 1, gain = \"touch.pressure\" }", "hand"),
            ("e = { type = \"spring\", stiffness = 1, gain = \"knob.angel\" }", "knob.angel"),
            ("e = { type = \"spring\", stiffness = 1, gain = true }", "gain"),
            ("e = { type = \"spring\", stiffness = nan }", "stiffness"),
        ] {
            let told = told(effects);
            assert!(told.contains(what), "{effects}: {told}");
        }
    }

    #[test]
    fn a_trigger_that_waits_for_what_never_happens_is_told() {
        let more = |on: &str| {
            format!(
                "[voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = 99 }}\n[[trigger]]\non = \"{on}\"\nplay = \"v\"\n"
            )
        };
        let both = "a = { type = \"detents\", count = 4, torque = 0.1 }\nb = { type = \"wall\", angle = 1, stiffness = 1 }\n";
        for on in ["knob.detent", "knob.detent a", "knob.wall", "knob.wall b"] {
            assert!(patch(both, &more(on)).is_ok(), "{on}");
        }
        for (effects, on, told) in [
            (both, "knob.wall a", "never happens to effect `a`"),
            (both, "knob.detent c", "no effect `c`"),
            ("d = { type = \"damper\", damping = 1 }", "knob.detent", "of type detents or snap"),
            (both, "knob.bump", "nothing like that sets off a trigger"),
        ] {
            let what = patch(effects, &more(on)).unwrap_err();
            assert!(what.contains(told), "{on}: {what}");
        }
    }

    #[test]
    fn what_never_happens_cannot_be_read() {
        let reads = |word: &str| {
            format!(
                "[voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"multiply\", inputs = [\"knob.{word}\", 1] }}\n"
            )
        };
        let notches = "a = { type = \"detents\", count = 4, torque = 0.1 }\n";
        for word in ["angle", "speed", "torque", "detent"] {
            assert!(patch(notches, &reads(word)).is_ok(), "{word}");
        }
        let told = patch(notches, &reads("wall")).unwrap_err();
        assert!(
            told.contains("`knob.wall` never happens") && told.contains("end-stops or contact"),
            "{told}"
        );
    }

    #[test]
    fn without_a_knob_nothing_can_read_it() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n\
            nodes.o = { type = \"sine\", frequency = \"100 + knob.angle\" }\n[[trigger]]\non = \"knob.wall\"\nplay = \"v\"\n";
        let told = Patch::parse("t", text.as_bytes()).unwrap_err().to_string();
        assert!(told.contains("reads the knob, and the patch has none"), "{told}");
        assert_eq!(told.matches("the patch has none").count(), 2, "{told}");
    }
}
