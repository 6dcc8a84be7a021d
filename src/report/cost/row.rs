//! What came of a method on a problem at a rate.

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The model of the problem: "rumble motor".
    pub model: &'static str,
    /// The problem: "full".
    pub problem: &'static str,
    /// What happens in it, in a line.
    pub about: &'static str,
    /// The method: "default".
    pub method: &'static str,
    /// Whether the method is the project's own.
    pub own: bool,
    /// Samples a second.
    pub rate: f64,
    /// What the error is of: "error of the speed, share of the rated speed".
    pub of: &'static str,
    /// The largest error, a share. Not a number where it was not computed or ran away.
    pub error: f64,
    /// The largest error of the angle, rad; `None` of what does not turn.
    pub angle: Option<f64>,
    /// CPU time of a step, nanoseconds, the least of several runs, all that happens on the way included; `None` unless it held out.
    pub ns: Option<f64>,
    /// How it went.
    pub outcome: Outcome,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// To the end.
    Held,
    /// It ran away: beyond a few times what the problem does at most, or to what is no number.
    Diverged,
    /// The method refuses the problem at this rate.
    Refused,
}

impl Row {
    /// Whether it ran away.
    pub fn diverged(&self) -> bool {
        self.outcome == Outcome::Diverged
    }

    /// CPU time a second of motion, as a share of that second; `None` unless it held out.
    pub fn load(&self) -> Option<f64> {
        self.ns.map(|ns| ns * 1e-9 * self.rate)
    }

    /// Model and problem in one: "rumble motor, full".
    pub fn title(&self) -> String {
        format!("{}, {}", self.model, self.problem)
    }
}

impl Outcome {
    /// A word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Diverged => "unstable",
            Self::Refused => "refused",
        }
    }
}
