//! What a node says about itself: the one description from which parsing, checks, the schema and the reference are made.

/// A node type, as written in a patch: `{ type = "sine", frequency = 250 }`.
#[derive(Debug)]
pub struct NodeSpec {
    /// The `type` in a patch.
    pub name: &'static str,
    /// Where the reference lists it.
    pub family: Family,
    /// One sentence.
    pub summary: &'static str,
    /// The definition, with its source; what happens at the ends of the ranges.
    pub detail: &'static str,
    /// The parameters, in the order in which the kernel gets them.
    pub params: &'static [Param],
    /// One line of a patch that uses it.
    pub example: &'static str,
}

/// Groups of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Oscillators, sweeps.
    Oscillator,
    /// Noise.
    Noise,
    /// Envelopes and low-frequency oscillators.
    Envelope,
    /// Recordings.
    Recording,
    /// Sums, products, shapes.
    Arithmetic,
    /// Filters, delay, followers.
    Filter,
    /// What comes from outside.
    Input,
    /// Orders to motors.
    Motor,
    /// Where on the body.
    Place,
}

/// A parameter of a node.
#[derive(Debug)]
pub struct Param {
    /// The key in a patch.
    pub name: &'static str,
    /// What may stand there.
    pub kind: Kind,
    /// SI unit, or "" for a pure number.
    pub unit: &'static str,
    /// One sentence.
    pub doc: &'static str,
}

/// What may stand in a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number, a node, a control or an expression of them; it may move at every sample.
    Signal(Numeric),
    /// A signal whose part known at the onset reaches the kernel apart from the rest and in full precision.
    Frequency(Numeric),
    /// A number or an expression of numbers and fields of the event; read when the voice starts.
    Start(Numeric),
    /// A number that is known when the patch is loaded.
    Constant(Numeric),
    /// A list of signals, as many as one likes; always the last of the numeric parameters.
    Signals,
    /// One of a few words; the number is the default's place.
    Choice(&'static [&'static str], usize),
    /// Breakpoints: a list of `{ at, value, shape }`.
    Points,
    /// A recording: path of a WAV file, relative to the patch.
    File,
    /// `true` or `false`.
    Flag(bool),
}

/// Default and range of a numeric parameter. Numbers outside the range are refused when the patch is loaded; a signal that
/// leaves it is limited to it, sample by sample, where the definition says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numeric {
    /// What holds where a patch says nothing; `None` where it must say something.
    pub default: Option<f64>,
    /// The least allowed.
    pub least: f64,
    /// The most allowed.
    pub most: f64,
}

impl Numeric {
    /// A range that must be given a value.
    pub(crate) const fn required(least: f64, most: f64) -> Self {
        Self { default: None, least, most }
    }
    /// A range with a default.
    pub(crate) const fn or(default: f64, least: f64, most: f64) -> Self {
        Self { default: Some(default), least, most }
    }
}

impl Kind {
    /// Whether the kernel gets it as an input.
    pub const fn is_input(&self) -> bool {
        matches!(self, Kind::Signal(_) | Kind::Frequency(_) | Kind::Start(_) | Kind::Signals)
    }
}

impl NodeSpec {
    /// How many of `inputs` a kernel is given while it runs: all up to the last that may move then.
    pub(crate) fn running(&self, inputs: usize) -> usize {
        let (mut all, mut last) = (0, 0);
        for param in self.params.iter().filter(|p| p.kind.is_input()) {
            all += 1;
            match param.kind {
                Kind::Start(_) => {}
                Kind::Signals => return inputs,
                _ => last = all,
            }
        }
        // What comes from outside is no parameter.
        if inputs > all {
            return inputs;
        }
        last.min(inputs)
    }

    /// The parameter of that name, with its place in `params`.
    pub fn param(&self, name: &str) -> Option<(usize, &'static Param)> {
        self.params.iter().enumerate().find(|(_, p)| p.name == name)
    }
}
