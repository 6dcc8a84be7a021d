//! A node of a voice, as written: its type and its parameters.

use super::Permissions;
use super::expr::Expr;
use crate::node::kernel::Point;
use crate::node::spec::{Kind, Numeric, Param};
use crate::node::words::advice;
use crate::node::{NodeKind, OF_FUNDSP};
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::{listed, nearest};
use crate::text::reader::{At, Reader, range};
use crate::text::sink::Sink;
use crate::text::{Problem, Span, lower, measure};

/// A node, `NAME = { type = "...", ... }`.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Its name, by which others read it.
    pub name: String,
    /// Its type.
    pub kind: NodeKind,
    /// One for each of the type's parameters, in that order, defaults filled in.
    pub arguments: Vec<Argument>,
    /// Where its name stands.
    pub span: Span,
}

/// What a parameter is set to.
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// What it is set to.
    pub value: Value,
    /// Where that stands; the node's place for a default.
    pub span: Span,
}

/// The value of a parameter; which one it is follows from its [`crate::node::spec::Kind`].
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Of `Signal`, `Frequency` and `Start`.
    Expr(Expr),
    /// Of `Constant`.
    Constant(f64),
    /// Of `Signals`.
    Signals(Vec<Expr>),
    /// Of `Choice`: the place of the word.
    Choice(usize),
    /// Of `Points`.
    Points(Vec<Point>),
    /// Of `File`: the path, relative to the patch.
    File(String),
    /// Of `Flag`.
    Flag(bool),
}

/// The keys of a breakpoint.
pub static POINT: Table = Table {
    name: "point",
    doc: "A breakpoint of an envelope.",
    fields: &[
        Field::new(
            "at",
            Form::any_number(0.0, 1e6),
            "s",
            "Seconds after the onset; later than the point before.",
        )
        .required(),
        Field::new("value", Form::any_number(-1e6, 1e6), "", "Value reached then.").required(),
        Field::new("shape", Form::Defined("shape"), "", "Shape of the segment that leads here."),
    ],
    others: None,
};

/// Words for the shape of a segment. As a number, 0 is linear, more than 0 starts slowly and less than 0 starts fast: the
/// share of the way after the share x of the time is (e^(shape x) − 1) / (e^shape − 1).
pub const SHAPES: &[(&str, f64)] = &[("linear", 0.0), ("slow", 4.0), ("fast", -4.0), ("exponential", -5.0)];
/// The strongest shape, to either side.
pub const MOST_SHAPE: f64 = 20.0;

/// Reads `NAME = { type = "...", ... }`; `None` where the type is unknown or a parameter is wrong, which has been reported.
pub(crate) fn read(
    name: &str,
    span: Span,
    value: At,
    of: &str,
    options: &Permissions,
    sink: &Sink,
) -> Option<Node> {
    let who = format!("node `{name}` of {of}");
    let Some(entries) = value.table() else {
        sink.error_help(
            &value.span(),
            format!("{who} is {}; it must be a table", value.shown()),
            "write it as NAME = { type = \"sine\", ... }",
        );
        return None;
    };
    let Some(word) = entries.get("type").map(At::new) else {
        sink.error_help(&span, format!("{who} lacks `type`"), "`pacinian nodes` lists the types");
        return None;
    };
    let Some(kind) = word.text().and_then(NodeKind::find) else {
        if word.text().is_some_and(|name| OF_FUNDSP.contains(&name)) {
            let what = format!("{who}: this program was built without the node type {}", word.shown());
            sink.error_help(&word.span(), what, "build it with the feature `fundsp-nodes`");
            return None;
        }
        let what = format!("{who}: there is no node type {}", word.shown());
        sink.push(Problem::error(&word.span(), what).help(advice(word.text().unwrap_or(""))));
        return None;
    };
    let spec = kind.spec();
    let who = format!("{who} ({})", spec.name);
    let mut fine = true;
    // A parameter that is there under a slip of its name is told once, at the slip.
    let mut slips = Vec::new();
    for (key, value) in entries {
        let word = key.get_ref();
        if word != "type" && spec.param(word).is_none() {
            let span = if key.span().is_empty() { value.span() } else { key.span() };
            let keys = spec.params.iter().map(|p| p.name);
            slips.extend(nearest(word, keys.clone()).filter(|_| !sink.is_full()));
            sink.unknown(&span, format!("{who} has no parameter `{word}`"), word, keys);
            fine = false;
        }
    }
    let mut arguments = Vec::with_capacity(spec.params.len());
    for param in spec.params {
        let reading = Reading { param, who: &who, options, sink };
        let argument = match entries.get(param.name).map(At::new) {
            Some(value) => reading.given(value).map(|v| Argument { value: v, span: value.span() }),
            None if slips.contains(&param.name) => None,
            None => reading.absent(&span).map(|v| Argument { value: v, span: span.clone() }),
        };
        fine &= argument.is_some();
        arguments.extend(argument);
    }
    fine.then(|| Node { name: name.into(), kind, arguments, span })
}

struct Reading<'a> {
    param: &'static Param,
    who: &'a str,
    options: &'a Permissions,
    sink: &'a Sink,
}

impl Reading<'_> {
    fn mistaken<T>(&self, value: &At, wanted: &str) -> Option<T> {
        let what = format!("`{}` of {} is {}; it must be {wanted}", self.param.name, self.who, value.shown());
        self.sink.error(&value.span(), what);
        None
    }

    fn absent(&self, span: &Span) -> Option<Value> {
        match self.param.kind {
            Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n) if n.default.is_some() => {
                n.default.map(|x| Value::Expr(Expr::Number(x)))
            }
            Kind::Constant(n) if n.default.is_some() => n.default.map(Value::Constant),
            Kind::Choice(_, place) => Some(Value::Choice(place)),
            Kind::Flag(on) => Some(Value::Flag(on)),
            _ => {
                let what = format!("{} lacks `{}`", self.who, self.param.name);
                let value = match self.param.kind {
                    Kind::Signals | Kind::Points => "[...]",
                    Kind::File => "\"...\"",
                    _ => "...",
                };
                let help = format!("add {} = {value}: {}", self.param.name, lower(self.param.doc));
                self.sink.push(Problem::error(span, what).help(help));
                None
            }
        }
    }

    fn given(&self, value: At) -> Option<Value> {
        match self.param.kind {
            Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n) => {
                self.expr(&value, Some(n)).map(Value::Expr)
            }
            Kind::Constant(n) => match self.expr(&value, Some(n))?.constant() {
                Some(x) => Some(Value::Constant(x)),
                None => self.mistaken(&value, "a number, since it cannot move"),
            },
            Kind::Signals => {
                let Some(list) = value.list() else {
                    return self.mistaken(&value, "a list of numbers, names and expressions");
                };
                let list: Vec<At> = list.collect();
                if list.is_empty() {
                    return self.mistaken(&value, "a list with something in it");
                }
                let read: Vec<Option<Expr>> = list.iter().map(|v| self.expr(v, None)).collect();
                read.into_iter().collect::<Option<Vec<Expr>>>().map(Value::Signals)
            }
            Kind::Choice(words, _) => {
                let Some(word) = value.text() else { return self.mistaken(&value, &one_of(words)) };
                let place = words.iter().position(|w| *w == word);
                if place.is_none() {
                    let what = format!("`{}` of {} cannot be \"{word}\"", self.param.name, self.who);
                    self.sink.unknown(&value.span(), what, word, words.iter().copied());
                }
                place.map(Value::Choice)
            }
            Kind::Flag(_) => match value.value.as_bool() {
                Some(on) => Some(Value::Flag(on)),
                None => self.mistaken(&value, "true or false"),
            },
            Kind::File => match value.text() {
                Some(path) => {
                    let path = self.options.path(path, &value.span(), self.who, self.sink)?;
                    Some(Value::File(path))
                }
                None => self.mistaken(&value, "the path of a WAV file"),
            },
            Kind::Points => self.points(&value).map(Value::Points),
        }
    }

    fn expr(&self, value: &At, limits: Option<Numeric>) -> Option<Expr> {
        let expr = match (value.number(), value.text()) {
            (Some(x), _) => Expr::Number(x),
            (_, Some(text)) => match Expr::parse(text, &value.span()) {
                Ok(expr) => expr,
                Err(mut problem) => {
                    problem.what = format!("`{}` of {}: {}", self.param.name, self.who, problem.what);
                    problem.help = measure::advice(self.param.name, text).or(problem.help);
                    self.sink.push(problem);
                    return None;
                }
            },
            _ => return self.mistaken(value, "a number, a name or an expression"),
        };
        let Some(x) = expr.constant() else { return Some(expr) };
        let (least, most) = limits.map_or((f64::MIN, f64::MAX), |n| (n.least, n.most));
        if x.is_finite() && x >= least && x <= most {
            return Some(expr);
        }
        let unit = if self.param.unit.is_empty() { String::new() } else { format!(" {}", self.param.unit) };
        self.mistaken(value, &format!("{}{unit}", range(least, most)))
    }

    fn points(&self, value: &At) -> Option<Vec<Point>> {
        let Some(list) = value.list() else {
            return self.mistaken(value, "a list of { at, value, shape }");
        };
        let mut points: Vec<Point> = Vec::new();
        let mut fine = true;
        for (i, value) in list.enumerate() {
            let who = format!("point {} of `{}` of {}", i + 1, self.param.name, self.who);
            let Some(entries) = value.table() else {
                self.sink.error(
                    &value.span(),
                    format!("{who} is {}; it must be {{ at, value, shape }}", value.shown()),
                );
                fine = false;
                continue;
            };
            let reader = Reader::new(&POINT, entries, value.span(), who.clone(), self.sink);
            let (at, reached, curve) = (reader.number("at"), reader.number("value"), shape(&reader));
            let (Some(at), Some(reached), Some(curve)) = (at, reached, curve) else {
                fine = false;
                continue;
            };
            if let Some(last) = points.last().filter(|last| last.at >= at) {
                self.sink.error_help(
                    &reader.span_of("at"),
                    format!("{who} is at {at} s, the one before it at {} s", last.at),
                    "every point must be later than the one before; for a jump, leave 1 µs between them",
                );
                fine = false;
            }
            points.push(Point { at, value: reached, curve });
        }
        if points.is_empty() && fine {
            return self.mistaken(value, "a list with at least one point");
        }
        fine.then_some(points)
    }
}

fn shape(reader: &Reader) -> Option<f64> {
    let Some(value) = reader.at("shape") else { return Some(0.0) };
    if value.number().is_some() {
        return reader.number_in("shape", &value, -MOST_SHAPE, MOST_SHAPE);
    }
    let words: Vec<&str> = SHAPES.iter().map(|(w, _)| *w).collect();
    reader.word_of("shape", &value, &words).and_then(|i| SHAPES.get(i)).map(|(_, curve)| *curve)
}

fn one_of(words: &[&str]) -> String {
    format!("one of {}", listed(words))
}

#[cfg(test)]
mod tests {
    use toml::de::DeTable;

    use super::{Permissions, Reading, Value};
    use crate::node::kernel::Point;
    use crate::node::spec::{Kind, Numeric, Param};
    use crate::text::reader::At;
    use crate::text::sink::Sink;

    /// What a parameter of a kind makes of a value, and the problems.
    fn read(kind: Kind, source: &str) -> (Option<Value>, Vec<String>) {
        let param: &'static Param = Box::leak(Box::new(Param { name: "p", kind, unit: "s", doc: "The p." }));
        let sink = Sink::default();
        let source = format!("x = {source}");
        let value = {
            let document = DeTable::parse(&source).unwrap().into_inner();
            let reading = Reading { param, who: "n", options: &Permissions::default(), sink: &sink };
            match document.get("x").map(At::new).filter(|v| v.text() != Some("absent")) {
                Some(value) => reading.given(value),
                None => reading.absent(&(0..0)),
            }
        };
        (value, sink.into_problems("f", &source).list.into_iter().map(|p| p.what).collect())
    }
    fn good(kind: Kind, source: &str) -> Value {
        let (value, problems) = read(kind, source);
        assert_eq!(problems, Vec::<String>::new(), "{source}");
        value.unwrap()
    }
    fn bad(kind: Kind, source: &str, what: &str) {
        let (value, problems) = read(kind, source);
        assert_eq!(value, None, "{source}");
        assert_eq!(problems.len(), 1, "{source}: {problems:?}");
        assert!(problems[0].contains(what), "{source}: {problems:?}");
    }

    #[test]
    fn constants_choices_and_flags() {
        let constant = Kind::Constant(Numeric::or(2.0, 0.0, 10.0));
        assert_eq!(good(constant, "1.5"), Value::Constant(1.5));
        assert_eq!(good(constant, "\"1 / 4\""), Value::Constant(0.25));
        assert_eq!(good(constant, "\"absent\""), Value::Constant(2.0));
        bad(constant, "\"lfo\"", "it cannot move");
        bad(constant, "11", "it must be a number from 0 to 10 s");
        bad(Kind::Constant(Numeric::required(0.0, 1.0)), "\"absent\"", "n lacks `p`");
        let choice = Kind::Choice(&["white", "pink"], 1);
        assert_eq!(good(choice, "\"white\""), Value::Choice(0));
        assert_eq!(good(choice, "\"absent\""), Value::Choice(1));
        bad(choice, "\"pnik\"", "cannot be \"pnik\"");
        bad(choice, "1", "one of `white` and `pink`");
        assert_eq!(good(Kind::Flag(true), "false"), Value::Flag(false));
        assert_eq!(good(Kind::Flag(true), "\"absent\""), Value::Flag(true));
        bad(Kind::Flag(true), "1", "true or false");
    }

    #[test]
    fn breakpoints() {
        let source = "[{ at = 0, value = 1 }, { at = 0.5, value = 0, shape = \"slow\" }, { at = 1, value = 2, shape = -3 }]";
        let point = |at, value, curve| Point { at, value, curve };
        let expected = vec![point(0.0, 1.0, 0.0), point(0.5, 0.0, 4.0), point(1.0, 2.0, -3.0)];
        assert_eq!(good(Kind::Points, source), Value::Points(expected));
        bad(Kind::Points, "[]", "at least one point");
        bad(Kind::Points, "3", "a list of { at, value, shape }");
        bad(Kind::Points, "[3]", "point 1 of `p` of n is 3");
        bad(
            Kind::Points,
            "[{ at = 1, value = 1 }, { at = 1, value = 2 }]",
            "point 2 of `p` of n is at 1 s, the one before it at 1 s",
        );
        bad(Kind::Points, "[{ at = -1, value = 1 }]", "`at` of point 1");
        bad(Kind::Points, "[{ at = 1 }]", "lacks `value`");
        bad(Kind::Points, "[{ at = 1, value = 1, shape = \"lineer\" }]", "cannot be \"lineer\"");
        bad(Kind::Points, "[{ at = 1, value = 1, shape = 21 }]", "from -20 to 20");
        bad(Kind::Points, "\"absent\"", "lacks `p`");
    }

    #[cfg(not(feature = "fundsp-nodes"))]
    #[test]
    fn a_node_that_was_left_out_of_the_program_is_named_with_its_feature() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"s\"\n\
                    [voice.v.nodes]\ns = { type = \"pluck\", frequency = 100 }\n";
        let problems = crate::patch::Patch::parse("t.toml", text.as_bytes()).unwrap_err().to_string();
        assert!(problems.contains("pluck") && problems.contains("fundsp-nodes"), "{problems}");
    }

    #[test]
    fn files_stay_in_their_folder() {
        assert_eq!(good(Kind::File, "\"sub/hit.wav\""), Value::File("sub/hit.wav".into()));
        assert_eq!(good(Kind::File, "\"a..b.wav\""), Value::File("a..b.wav".into()));
        for path in
            ["../hit.wav", "a/../../hit.wav", "/hit.wav", "C:/hit.wav", "\\\\hit.wav", "a\\\\..\\\\hit.wav"]
        {
            bad(Kind::File, &format!("\"{path}\""), "leaves the folder of the patch");
        }
        bad(Kind::File, "\"\"", "has no name");
        bad(Kind::File, "3", "the path of a WAV file");
    }
}
