//! Short expressions, by which nodes are wired: `"tone"`, `"60 + 20 * wobble"`, `"min(1, event.level * 2)"`.

use super::knob::Reading;
use crate::node::motion::Motion;
use crate::text::nearest::suggest;
use crate::text::{Problem, Span};

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    /// A number.
    Number(f64),
    /// A node of the same voice, a shared node or a control, in this order.
    Name(String, Span),
    /// A field of the event: `event.NAME`.
    Event(String, Span),
    /// What the hand does that holds the voice: `touch.pressure`, `touch.timbre`; `touch.bend` is read as `1 + detune`.
    Touch(Motion, Span),
    /// What the knob does: `knob.angle`, `knob.speed`, `knob.torque`, `knob.detent`, `knob.wall`.
    Knob(Reading, Span),
    /// Minus.
    Negate(Box<Expr>),
    /// Two operands.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// A function of as many arguments as [`Function::arity`] says.
    Call(Function, Vec<Expr>),
}

/// What an expression reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reads<'a> {
    /// A node or a control.
    Name(&'a str),
    /// A field of the event.
    Event(&'a str),
    /// What the hand does.
    Touch(Motion),
    /// What the knob does.
    Knob(Reading),
}

/// Between two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
}

/// A function of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Function {
    /// Lesser of two.
    Min,
    /// Greater of two.
    Max,
    /// Without its sign.
    Abs,
    /// `clamp(x, least, most)`.
    Clamp,
    /// Square root.
    Sqrt,
    /// e to the power.
    Exp,
    /// Natural logarithm.
    Log,
    /// Sine of an angle in radians.
    Sin,
    /// `pow(base, exponent)`.
    Pow,
    /// Greatest whole number that is not greater.
    Floor,
}

/// The longest expression, characters.
pub const MAX_LENGTH: usize = 1000;
/// The deepest nesting of parentheses, functions and signs.
pub const MAX_DEPTH: usize = 64;

/// All functions, by name.
pub const FUNCTIONS: &[(&str, Function)] = &[
    ("min", Function::Min),
    ("max", Function::Max),
    ("abs", Function::Abs),
    ("clamp", Function::Clamp),
    ("sqrt", Function::Sqrt),
    ("exp", Function::Exp),
    ("log", Function::Log),
    ("sin", Function::Sin),
    ("pow", Function::Pow),
    ("floor", Function::Floor),
];

impl Function {
    /// The function of that name.
    pub(crate) fn find(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(n, _)| *n == name).map(|(_, f)| *f)
    }
    /// How many values it takes.
    pub const fn arity(self) -> usize {
        match self {
            Self::Min | Self::Max | Self::Pow => 2,
            Self::Clamp => 3,
            Self::Abs | Self::Sqrt | Self::Exp | Self::Log | Self::Sin | Self::Floor => 1,
        }
    }
    /// Its definition. Values that are missing count as 0.
    pub(crate) fn apply(self, values: &[f64]) -> f64 {
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        match self {
            Self::Min => at(0).min(at(1)),
            Self::Max => at(0).max(at(1)),
            Self::Abs => at(0).abs(),
            Self::Clamp => at(0).max(at(1)).min(at(2)),
            Self::Sqrt => at(0).sqrt(),
            Self::Exp => at(0).exp(),
            Self::Log => at(0).ln(),
            Self::Sin => at(0).sin(),
            Self::Pow => at(0).powf(at(1)),
            Self::Floor => at(0).floor(),
        }
    }
}

impl Operator {
    /// Its definition.
    pub(crate) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
        }
    }
}

impl Expr {
    /// Reads an expression that stands, quoted or not, at `span` of a file.
    ///
    /// # Errors
    /// Points at what cannot be read.
    pub fn parse(text: &str, span: &Span) -> Result<Self, Problem> {
        // Within quotes the text begins a quote later; where escapes blur that, the whole stands for each part.
        let first = match (span.end - span.start.min(span.end)).checked_sub(text.len()) {
            Some(0) => Some(span.start),
            Some(2) => Some(span.start + 1),
            Some(6) => Some(span.start + 3),
            _ => None,
        };
        let mut parser = Parser { text, at: 0, depth: 0, first, span };
        if text.chars().count() > MAX_LENGTH {
            return Err(Problem::error(span, format!("an expression has at most {MAX_LENGTH} characters"))
                .help("make nodes of its parts".to_string()));
        }
        let expr = parser.sum()?;
        match parser.peek() {
            None => Ok(expr),
            Some(c) => Err(parser.wrong(parser.at, c.len_utf8(), format!("`{c}` makes no sense here"))),
        }
    }

    /// Its value where it reads no names and no event.
    pub fn constant(&self) -> Option<f64> {
        self.value(&|_| None)
    }

    /// Its value where it reads no event, and no names but those that `known` knows.
    pub(crate) fn value(&self, known: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
        match self {
            Self::Number(x) => Some(*x),
            Self::Name(name, _) => known(name),
            Self::Event(..) | Self::Touch(..) | Self::Knob(..) => None,
            Self::Negate(a) => a.value(known).map(|a| -a),
            Self::Binary(op, a, b) => Some(op.apply(a.value(known)?, b.value(known)?)),
            Self::Call(function, values) => {
                let values: Option<Vec<f64>> = values.iter().map(|v| v.value(known)).collect();
                values.map(|v| function.apply(&v))
            }
        }
    }

    /// Calls `see` with everything that it reads.
    pub(crate) fn visit<'a>(&'a self, see: &mut dyn FnMut(Reads<'a>, &'a Span)) {
        match self {
            Self::Number(_) => {}
            Self::Name(name, span) => see(Reads::Name(name), span),
            Self::Event(field, span) => see(Reads::Event(field), span),
            Self::Touch(motion, span) => see(Reads::Touch(*motion), span),
            Self::Knob(reading, span) => see(Reads::Knob(*reading), span),
            Self::Negate(a) => a.visit(see),
            Self::Binary(_, a, b) => {
                a.visit(see);
                b.visit(see);
            }
            Self::Call(_, values) => values.iter().for_each(|v| v.visit(see)),
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    first: Option<usize>,
    span: &'a Span,
}

impl Parser<'_> {
    fn place(&self, at: usize, length: usize) -> Span {
        self.first.map_or_else(|| self.span.clone(), |first| first + at..first + at + length)
    }
    fn wrong(&self, at: usize, length: usize, what: String) -> Problem {
        Problem::error(&self.place(at, length), format!("in the expression \"{}\": {what}", self.text))
    }
    fn peek(&mut self) -> Option<char> {
        let rest = self.text.get(self.at..).unwrap_or("");
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        trimmed.chars().next()
    }
    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }
    fn sum(&mut self) -> Result<Expr, Problem> {
        let mut left = self.product()?;
        loop {
            let operator = match self.peek() {
                Some('+') => Operator::Add,
                Some('-') => Operator::Subtract,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Expr::Binary(operator, Box::new(left), Box::new(self.product()?));
        }
    }
    fn product(&mut self) -> Result<Expr, Problem> {
        let mut left = self.unary()?;
        loop {
            let operator = match self.peek() {
                Some('*') => Operator::Multiply,
                Some('/') => Operator::Divide,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Expr::Binary(operator, Box::new(left), Box::new(self.unary()?));
        }
    }
    fn unary(&mut self) -> Result<Expr, Problem> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.wrong(self.at, 1, format!("it nests deeper than {MAX_DEPTH}")));
        }
        let result = if self.take('-') {
            // A negative number is one number.
            self.unary().map(|e| match e {
                Expr::Number(x) => Expr::Number(-x),
                e => Expr::Negate(Box::new(e)),
            })
        } else {
            self.primary()
        };
        self.depth -= 1;
        result
    }
    fn primary(&mut self) -> Result<Expr, Problem> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                if !self.take(')') {
                    return Err(self.wrong(self.at, 0, "a `)` is missing".into()));
                }
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            Some(c) => Err(self.wrong(self.at, c.len_utf8(), format!("`{c}` makes no sense here"))),
            None => Err(self.wrong(self.at, 0, "a number or a name is missing at its end".into())),
        }
    }
    fn number(&mut self) -> Result<Expr, Problem> {
        let rest = self.text.as_bytes().get(self.at..).unwrap_or(&[]);
        let mut length = 0;
        while let Some(&c) = rest.get(length) {
            let after_e = length > 0 && matches!(rest[length - 1], b'e' | b'E');
            if c.is_ascii_alphanumeric() || c == b'.' || c == b'_' || (matches!(c, b'+' | b'-') && after_e) {
                length += 1;
            } else {
                break;
            }
        }
        let digits = self.text.get(self.at..self.at + length).unwrap_or("");
        match digits.parse::<f64>() {
            Ok(x) if x.is_finite() => {
                self.at += length;
                Ok(Expr::Number(x))
            }
            _ => Err(self.wrong(self.at, length, format!("`{digits}` is no number"))),
        }
    }
    fn word(&mut self) -> (usize, String) {
        let start = self.at;
        let rest = self.text.get(start..).unwrap_or("");
        let word: String = rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        self.at += word.len();
        (start, word)
    }
    fn name(&mut self) -> Result<Expr, Problem> {
        let (start, name) = self.word();
        if name == "event" {
            if !self.take('.') {
                let what = "`event` needs a field: `event.level`, `event.frequency`, ...".into();
                return Err(self.wrong(start, name.len(), what));
            }
            let (at, field) = self.word();
            if field.is_empty() {
                return Err(self.wrong(at, 0, "the name of a field is missing after `event.`".into()));
            }
            let place = self.place(start, self.at - start);
            return Ok(Expr::Event(field, place));
        }
        if name == "touch" && self.take('.') {
            return self.touch(start);
        }
        if name == "knob" && self.take('.') {
            return self.knob(start);
        }
        let function = Function::find(&name);
        if self.peek() != Some('(') {
            return match function {
                Some(f) => {
                    let what =
                        format!("`{name}` is a function and takes {} in parentheses", values(f.arity()));
                    Err(self.wrong(start, name.len(), what))
                }
                None if self.peek() == Some('.') => {
                    let what = "`.` stands in a number, or behind `event`, `touch` or `knob`".into();
                    let wrong = self.wrong(self.at, 1, what);
                    self.at += 1;
                    let (_, meant) = self.word();
                    let help = format!("a control or a node is called by its name alone: `{meant}`");
                    Err(if meant.is_empty() { wrong } else { wrong.help(help) })
                }
                None => {
                    let place = self.place(start, name.len());
                    Ok(Expr::Name(name, place))
                }
            };
        }
        let Some(function) = function else {
            let help = suggest(&name, FUNCTIONS.iter().map(|(n, _)| *n));
            return Err(self.wrong(start, name.len(), format!("there is no function `{name}`")).help(help));
        };
        self.at += 1;
        let mut arguments = Vec::new();
        if self.peek() != Some(')') {
            arguments.push(self.sum()?);
            while self.take(',') {
                arguments.push(self.sum()?);
            }
        }
        if !self.take(')') {
            return Err(self.wrong(self.at, 0, "a `)` is missing".into()));
        }
        if arguments.len() != function.arity() {
            let what = format!("`{name}` takes {}, here are {}", values(function.arity()), arguments.len());
            return Err(self.wrong(start, self.at - start, what));
        }
        Ok(Expr::Call(function, arguments))
    }
}

/// What the hand may do, as expressions name it.
const TOUCHES: [&str; 3] = ["bend", "pressure", "timbre"];

impl Parser<'_> {
    /// What stands after `touch.`, which begins at `start`.
    fn touch(&mut self, start: usize) -> Result<Expr, Problem> {
        let (at, word) = self.word();
        let place = self.place(start, self.at - start);
        match word.as_str() {
            // A share that is added to 1 keeps the frequency that is known at the onset in full precision.
            "bend" => {
                let detune = Expr::Touch(Motion::Detune, place);
                Ok(Expr::Binary(Operator::Add, Box::new(Expr::Number(1.0)), Box::new(detune)))
            }
            "pressure" => Ok(Expr::Touch(Motion::Pressure, place)),
            "timbre" => Ok(Expr::Touch(Motion::Timbre, place)),
            _ => {
                let what = format!("`touch.{word}` is nothing that a hand does");
                Err(self.wrong(at, word.len(), what).help(suggest(&word, TOUCHES)))
            }
        }
    }
}

impl Parser<'_> {
    /// What stands after `knob.`, which begins at `start`.
    fn knob(&mut self, start: usize) -> Result<Expr, Problem> {
        let (at, word) = self.word();
        let place = self.place(start, self.at - start);
        match Reading::of_word(&word) {
            Some(reading) => Ok(Expr::Knob(reading, place)),
            None => {
                let what = format!("`knob.{word}` is nothing that is known of a knob");
                Err(self.wrong(at, word.len(), what).help(suggest(&word, Reading::WORDS)))
            }
        }
    }
}

fn values(count: usize) -> String {
    if count == 1 { "1 value".into() } else { format!("{count} values") }
}

#[cfg(test)]
mod tests {
    use super::{Expr, FUNCTIONS, Function, Motion, Operator, Reads};

    fn value(text: &str) -> f64 {
        Expr::parse(text, &(0..text.len())).unwrap().constant().unwrap()
    }
    fn problem(text: &str) -> (usize, String) {
        let problem = Expr::parse(text, &(10..12 + text.len())).unwrap_err();
        (problem.span.unwrap().start, problem.what)
    }

    #[test]
    fn follows_the_rules_of_arithmetic() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("8 - 4 - 2", 2.0),
            ("16 / 4 / 2", 2.0),
            ("-2 * -3", 6.0),
            ("--2", 2.0),
            ("1e3 + 1.5E-1 + .5", 1000.65),
            ("2 - -3", 5.0),
            ("min(3, 2) + max(3, 2) + abs(-1)", 6.0),
            ("clamp(5, 0, 2) + clamp(-5, 0, 2)", 2.0),
            ("pow(2, sqrt(9)) + floor(-0.5)", 7.0),
            ("exp(0) + log(1) + sin(0)", 1.0),
        ] {
            assert_eq!(value(text), expected, "{text}");
        }
    }

    #[test]
    fn names_keep_their_places() {
        let expr = Expr::parse("40 + 2 * lfo + event.depth", &(100..128)).unwrap();
        let mut seen = Vec::new();
        expr.visit(&mut |reads, span| seen.push((reads, span.clone())));
        assert_eq!(seen, [(Reads::Name("lfo"), 110..113), (Reads::Event("depth"), 116..127)]);
        assert_eq!(expr.constant(), None);
    }

    #[test]
    fn what_a_hand_does_is_read_by_its_name() {
        let read = |text: &str| Expr::parse(text, &(0..text.len())).unwrap();
        assert_eq!(read("touch.pressure"), Expr::Touch(Motion::Pressure, 0..14));
        let Expr::Binary(Operator::Multiply, _, bend) = read("2 * touch.bend") else { panic!() };
        let detune = Expr::Touch(Motion::Detune, 4..14);
        assert_eq!(*bend, Expr::Binary(Operator::Add, Expr::Number(1.0).into(), detune.into()));
        // Alone it is a name like any other.
        assert_eq!(read("touch"), Expr::Name("touch".into(), 0..5));
        assert_eq!(read("touch.timbre").constant(), None);
    }

    #[test]
    fn points_at_what_is_wrong() {
        for (text, at, what) in [
            ("", 0, "missing at its end"),
            ("2 +", 3, "missing at its end"),
            ("2 3", 2, "`3` makes no sense here"),
            ("(2", 2, "`)` is missing"),
            ("2 * control.depth", 11, "behind `event`"),
            ("2 $ x", 2, "`$` makes no sense"),
            ("1.2.3", 0, "`1.2.3` is no number"),
            ("2x", 0, "`2x` is no number"),
            ("1e999", 0, "is no number"),
            ("mn(1, 2)", 0, "no function `mn`"),
            ("min(1)", 0, "takes 2 values, here are 1"),
            ("min + 1", 0, "is a function"),
            ("event + 1", 0, "`event` needs a field"),
            ("event.", 6, "field is missing"),
            ("2 * touch.bent", 10, "`touch.bent` is nothing"),
            ("touch.", 6, "is nothing"),
            ("2 * µ", 4, "`µ` makes no sense"),
        ] {
            let (start, found) = problem(text);
            assert!(found.contains(what), "{text}: {found}");
            assert_eq!(start, 11 + at, "{text}: {found}");
        }
        let help = |text: &str| Expr::parse(text, &(0..text.len())).unwrap_err().help;
        assert!(help("2 * control.depth").is_some_and(|help| help.ends_with("by its name alone: `depth`")));
        assert_eq!(help("depth. * 2"), None);
        assert!(problem(&"(".repeat(500)).1.contains("deeper than 64"));
        assert!(problem(&"-".repeat(500)).1.contains("deeper than 64"));
        assert!(problem(&"1+".repeat(5000)).1.contains("at most 1000"));
    }

    #[test]
    fn every_function_is_listed() {
        for (name, function) in FUNCTIONS {
            assert_eq!(Function::find(name), Some(*function));
            assert!((1..=3).contains(&function.arity()));
        }
    }
}
