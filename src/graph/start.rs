//! Values worked out when a voice starts, from the fields of its event: small stack programs in `f64`.

/// A start program, by its place.
pub type StartId = u32;

/// Fields an event may carry: its frequency and what a voice declares for itself.
pub const FIELDS: usize = crate::patch::voice::MOST_FIELDS;

/// What the event says, as start programs read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fields {
    /// Level, 1 for a full one.
    pub level: f64,
    /// Seconds until the release; infinite while it is held.
    pub duration: f64,
    /// The voice's own fields, in the order in which it declares them.
    pub own: [f64; FIELDS],
}

/// One step of a start program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Push a number.
    Number(f64),
    /// Push the level.
    Level,
    /// Push the duration.
    Duration,
    /// Push one of the voice's own fields.
    Own(u8),
    /// Replace the topmost value.
    Unary(Unary),
    /// Replace the two topmost values.
    Binary(Binary),
}

/// Functions of one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unary {
    /// −x.
    Negate,
    /// Absolute value.
    Abs,
    /// Square root; 0 below 0.
    Sqrt,
    /// e^x.
    Exp,
    /// Natural logarithm; that of 1e-300 at and below 0.
    Log,
    /// Sine of x radians.
    Sin,
    /// The largest whole number not above.
    Floor,
}

/// Functions of two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binary {
    /// a + b.
    Add,
    /// a − b.
    Subtract,
    /// a b.
    Multiply,
    /// a / b; 0 where b is 0.
    Divide,
    /// The smaller.
    Min,
    /// The greater.
    Max,
    /// a^b for a ≥ 0; 0 for a below.
    Power,
}

impl Unary {
    /// The value.
    pub(crate) fn of(self, x: f64) -> f64 {
        match self {
            Self::Negate => -x,
            Self::Abs => x.abs(),
            Self::Sqrt => x.max(0.0).sqrt(),
            Self::Exp => x.exp(),
            Self::Log => x.max(1e-300).ln(),
            Self::Sin => x.sin(),
            Self::Floor => x.floor(),
        }
    }
}

impl Binary {
    /// The value.
    pub(crate) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide if b == 0.0 => 0.0,
            Self::Divide => a / b,
            Self::Min => a.min(b),
            Self::Max => a.max(b),
            Self::Power if a < 0.0 => 0.0,
            Self::Power => a.powf(b),
        }
    }
}

/// A value worked out at the onset.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StartProgram {
    steps: Vec<Step>,
}

/// How deep a start program's stack may grow.
const DEPTH: usize = 64;

impl StartProgram {
    /// A program of these steps.
    ///
    /// # Errors
    /// Says so where the steps take more values than they give, leave other than one, or need a stack deeper than 64.
    pub fn new(steps: Vec<Step>) -> Result<Self, &'static str> {
        let mut depth = 0_usize;
        for step in &steps {
            let (takes, gives) = match step {
                Step::Number(_) | Step::Level | Step::Duration | Step::Own(_) => (0, 1),
                Step::Unary(_) => (1, 1),
                Step::Binary(_) => (2, 1),
            };
            depth = depth.checked_sub(takes).ok_or("a step takes a value that is not there")? + gives;
            if depth > DEPTH {
                return Err("the expression is nested more than 64 deep");
            }
        }
        if depth == 1 { Ok(Self { steps }) } else { Err("an expression must leave one value") }
    }

    /// The value for an event. Not-a-number becomes 0; infinity becomes 1e300.
    pub(crate) fn value(&self, fields: &Fields) -> f64 {
        let mut stack = [0.0; DEPTH + 1];
        let mut top = 0;
        for step in &self.steps {
            match *step {
                Step::Unary(f) => stack[top - 1] = f.of(stack[top - 1]),
                Step::Binary(f) => {
                    top -= 1;
                    stack[top - 1] = f.of(stack[top - 1], stack[top]);
                }
                Step::Number(_) | Step::Level | Step::Duration | Step::Own(_) => {
                    stack[top] = match *step {
                        Step::Number(x) => x,
                        Step::Level => fields.level,
                        Step::Duration => fields.duration,
                        Step::Own(i) => fields.own.get(usize::from(i)).copied().unwrap_or(0.0),
                        Step::Unary(_) | Step::Binary(_) => 0.0,
                    };
                    top += 1;
                }
            }
        }
        let value = stack[0];
        if value.is_nan() { 0.0 } else { value.clamp(-1e300, 1e300) }
    }

    /// The steps, in order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::{Binary, FIELDS, Fields, StartProgram, Step, Unary};

    const FIELDS_OF_A_NOTE: Fields = Fields { level: 0.5, duration: 2.0, own: [60.0; FIELDS] };

    #[test]
    fn programs_compute() {
        let steps = vec![
            Step::Own(0),
            Step::Number(2.0),
            Step::Level,
            Step::Binary(Binary::Multiply),
            Step::Binary(Binary::Add),
            Step::Unary(Unary::Negate),
        ];
        assert_eq!(StartProgram::new(steps).unwrap().value(&FIELDS_OF_A_NOTE), -61.0);
    }

    #[test]
    fn broken_programs_are_refused() {
        assert!(StartProgram::new(vec![]).is_err());
        assert!(StartProgram::new(vec![Step::Binary(Binary::Add)]).is_err());
        assert!(StartProgram::new(vec![Step::Level, Step::Level]).is_err());
        assert!(StartProgram::new(vec![Step::Level; 100]).is_err());
    }

    #[test]
    fn values_are_finite() {
        let divide = vec![Step::Number(1.0), Step::Number(0.0), Step::Binary(Binary::Divide)];
        assert_eq!(StartProgram::new(divide).unwrap().value(&FIELDS_OF_A_NOTE), 0.0);
        let root = vec![Step::Number(-4.0), Step::Unary(Unary::Sqrt)];
        assert_eq!(StartProgram::new(root).unwrap().value(&FIELDS_OF_A_NOTE), 0.0);
    }
}
