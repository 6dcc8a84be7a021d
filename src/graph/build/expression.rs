//! Expressions become what is worked out at the onset, and nodes for what moves.

use super::{Base, Builder, Signal, Want, Wire};
use crate::graph::NodeId;
use crate::graph::start::{Binary, Step, Unary};
use crate::patch::{Expr, Function, Operator, Target};
use crate::text::{Problem, Span};

/// A known factor times a sum or a difference, as two products: `event.frequency * (1 + 0.1 * wobble)` is a known frequency and
/// what moves it. A product that does not move at all stays as it is, and so does a sum of more than [`MOST_TERMS`], since each
/// gets a copy of the factor. Of several factors, one after the other is taken: `2 * (1 + wobble) * event.frequency` as well.
fn multiplied_out(expr: &Expr) -> Option<(Operator, Expr, Expr)> {
    let Expr::Binary(Operator::Multiply, a, b) = expr else { return None };
    let (factor, sum) = match (is_steady(a), is_steady(b)) {
        (true, false) => (a, b),
        (false, true) => (b, a),
        _ => return None,
    };
    match &**sum {
        Expr::Binary(operator @ (Operator::Add | Operator::Subtract), x, y) if terms(sum) <= MOST_TERMS => {
            let times =
                |part: &Expr| Expr::Binary(Operator::Multiply, factor.clone(), Box::new(part.clone()));
            Some((*operator, times(x), times(y)))
        }
        product @ Expr::Binary(Operator::Multiply, ..) => {
            let (operator, x, y) = multiplied_out(product)?;
            let times = |part: Expr| Expr::Binary(Operator::Multiply, factor.clone(), Box::new(part));
            Some((operator, times(x), times(y)))
        }
        _ => None,
    }
}

/// The longest sum that is multiplied out.
const MOST_TERMS: usize = 64;

/// Terms of a sum; parts that do not move count once.
fn terms(expr: &Expr) -> usize {
    match expr {
        Expr::Binary(Operator::Add | Operator::Subtract, a, b) if !is_steady(expr) => terms(a) + terms(b),
        _ => 1,
    }
}

/// Whether an expression names nothing that could move.
fn is_steady(expr: &Expr) -> bool {
    match expr {
        Expr::Number(_) | Expr::Event(..) => true,
        Expr::Name(..) | Expr::Touch(..) | Expr::Knob(..) => false,
        Expr::Negate(a) => is_steady(a),
        Expr::Binary(_, a, b) => is_steady(a) && is_steady(b),
        Expr::Call(_, arguments) => arguments.iter().all(is_steady),
    }
}

/// What an expression amounts to.
pub(super) enum Term {
    /// Known when the voice starts.
    Known(Vec<Step>),
    /// Moves.
    Moving(Signal),
}

impl Builder<'_> {
    /// What is known of a frequency apart from what moves: `60 + 20 * wobble` is 60 and a deviation.
    pub(super) fn frequency(&mut self, owner: &str, expr: &Expr) -> Wire {
        let (mut known, mut moving) = (Vec::new(), Vec::new());
        self.summands(owner, expr, false, &mut known, &mut moving);
        let base = if known.is_empty() { Base::Constant(0.0) } else { self.base(known) };
        let signal = match moving[..] {
            [] => None,
            [only] => Some(only),
            _ => {
                let inputs =
                    moving.into_iter().map(|s| Wire { base: Base::Constant(0.0), signal: Some(s) }).collect();
                Some(self.made(owner, "add", None, inputs))
            }
        };
        Wire { base, signal }
    }

    fn summands(
        &mut self,
        owner: &str,
        expr: &Expr,
        negative: bool,
        known: &mut Vec<Step>,
        moving: &mut Vec<Signal>,
    ) {
        if let Some((operator, a, b)) = multiplied_out(expr) {
            let second = negative != (operator == Operator::Subtract);
            self.summands(owner, &a, negative, known, moving);
            return self.summands(owner, &b, second, known, moving);
        }
        match expr {
            Expr::Binary(Operator::Add, a, b) => {
                self.summands(owner, a, negative, known, moving);
                self.summands(owner, b, negative, known, moving);
            }
            Expr::Binary(Operator::Subtract, a, b) => {
                self.summands(owner, a, negative, known, moving);
                self.summands(owner, b, !negative, known, moving);
            }
            Expr::Negate(a) => self.summands(owner, a, !negative, known, moving),
            other => match self.term(owner, other) {
                Term::Known(steps) => {
                    let first = known.is_empty();
                    known.extend(steps);
                    match (first, negative) {
                        (true, true) => known.push(Step::Unary(Unary::Negate)),
                        (true, false) => {}
                        (false, true) => known.push(Step::Binary(Binary::Subtract)),
                        (false, false) => known.push(Step::Binary(Binary::Add)),
                    }
                }
                Term::Moving(signal) if negative => {
                    let inputs =
                        vec![Wire { base: Base::Constant(0.0), signal: Some(signal) }, Wire::constant(-1.0)];
                    moving.push(self.made(owner, "multiply", None, inputs));
                }
                Term::Moving(signal) => moving.push(signal),
            },
        }
    }

    pub(super) fn term(&mut self, owner: &str, expr: &Expr) -> Term {
        match expr {
            Expr::Number(x) => Term::Known(vec![Step::Number(*x)]),
            Expr::Event(field, span) => Term::Known(vec![self.field(field, span)]),
            Expr::Name(name, span) => match self.scope.find(name) {
                Some(Target::Node(i)) => Term::Moving(Signal::Node(i as NodeId)),
                Some(Target::Shared(i)) if self.shared => Term::Moving(Signal::Node(i as NodeId)),
                Some(Target::Shared(i)) => Term::Moving(Signal::Shared(self.wanted.number(Want::Node(i)))),
                Some(Target::Control(i)) => {
                    Term::Moving(Signal::Shared(self.wanted.number(Want::Control(i))))
                }
                None => {
                    self.problems.push(Problem::error(span, format!("nothing here is called `{name}`")));
                    Term::Known(vec![Step::Number(0.0)])
                }
            },
            Expr::Touch(motion, _) => Term::Moving(self.touch(*motion)),
            Expr::Knob(reading, _) => Term::Moving(Signal::Shared(self.wanted.number(Want::Knob(*reading)))),
            Expr::Negate(a) => match self.term(owner, a) {
                Term::Known(mut steps) => {
                    steps.push(Step::Unary(Unary::Negate));
                    Term::Known(steps)
                }
                moving => {
                    let inputs = vec![self.wire(moving), Wire::constant(-1.0)];
                    Term::Moving(self.made(owner, "multiply", None, inputs))
                }
            },
            Expr::Binary(operator, a, b) => {
                let (a, b) = (self.term(owner, a), self.term(owner, b));
                let (step, node, choice) = match operator {
                    Operator::Add => (Binary::Add, "add", None),
                    Operator::Subtract => (Binary::Subtract, "function", Some("subtract")),
                    Operator::Multiply => (Binary::Multiply, "multiply", None),
                    Operator::Divide => (Binary::Divide, "function", Some("divide")),
                };
                self.binary(owner, step, node, choice, a, b)
            }
            Expr::Call(function, arguments) => self.call(owner, *function, arguments),
        }
    }

    fn binary(
        &mut self,
        owner: &str,
        step: Binary,
        node: &str,
        choice: Option<&str>,
        a: Term,
        b: Term,
    ) -> Term {
        match (a, b) {
            (Term::Known(mut a), Term::Known(b)) => {
                a.extend(b);
                a.push(Step::Binary(step));
                Term::Known(a)
            }
            (a, b) => {
                let inputs = vec![self.wire(a), self.wire(b)];
                Term::Moving(self.made(owner, node, choice, inputs))
            }
        }
    }

    fn call(&mut self, owner: &str, function: Function, arguments: &[Expr]) -> Term {
        let mut terms: Vec<Term> = arguments.iter().map(|a| self.term(owner, a)).collect();
        let unary = match function {
            Function::Abs => Some((Unary::Abs, "abs")),
            Function::Sqrt => Some((Unary::Sqrt, "sqrt")),
            Function::Exp => Some((Unary::Exp, "exp")),
            Function::Log => Some((Unary::Log, "log")),
            Function::Sin => Some((Unary::Sin, "sin")),
            Function::Floor => Some((Unary::Floor, "floor")),
            Function::Min | Function::Max | Function::Pow | Function::Clamp => None,
        };
        let mut next =
            || if terms.is_empty() { Term::Known(vec![Step::Number(0.0)]) } else { terms.remove(0) };
        match (unary, function) {
            (Some((step, choice)), _) => match next() {
                Term::Known(mut steps) => {
                    steps.push(Step::Unary(step));
                    Term::Known(steps)
                }
                moving => {
                    let inputs = vec![self.wire(moving)];
                    Term::Moving(self.made(owner, "function", Some(choice), inputs))
                }
            },
            (None, Function::Clamp) => {
                let (x, least, most) = (next(), next(), next());
                let above = self.binary(owner, Binary::Max, "function", Some("max"), x, least);
                self.binary(owner, Binary::Min, "function", Some("min"), above, most)
            }
            (None, Function::Min) => {
                let (a, b) = (next(), next());
                self.binary(owner, Binary::Min, "function", Some("min"), a, b)
            }
            (None, Function::Max) => {
                let (a, b) = (next(), next());
                self.binary(owner, Binary::Max, "function", Some("max"), a, b)
            }
            (None, _) => {
                let (a, b) = (next(), next());
                self.binary(owner, Binary::Power, "function", Some("power"), a, b)
            }
        }
    }

    fn field(&mut self, field: &str, span: &Span) -> Step {
        match field {
            "level" => Step::Level,
            "duration" => Step::Duration,
            own => match self.fields.iter().position(|f| *f == own) {
                Some(i) => Step::Own(i as u8),
                None => {
                    self.problems.push(Problem::error(span, format!("events here have no field `{own}`")));
                    Step::Number(0.0)
                }
            },
        }
    }
}
