//! Short expressions, by which nodes are wired: `"tone"`, `"60 + 20 * wobble"`, `"min(1, event.level * 2)"`.

use crate::text::Span;

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    /// A number.
    Number(f64),
    /// A node of the same voice, a shared node or a control; see [`super::Scope::find`].
    Name(String, Span),
    /// A field of the event: `event.NAME`.
    Event(String, Span),
    /// Minus.
    Negate(Box<Expr>),
    /// Two operands.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// A function of as many arguments as [`Function::arity`] says.
    Call(Function, Vec<Expr>),
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
