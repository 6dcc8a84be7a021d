//! A node of a voice, as written: its type and its parameters.

use super::expr::Expr;
use crate::node::NodeKind;
use crate::node::kernel::Point;
use crate::text::Span;

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
