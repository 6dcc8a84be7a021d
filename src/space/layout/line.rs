//! One row.

use super::{Layout, count, length};
use crate::space::fault::Fault;

/// Tactors in a row from the wearer's left, at one spacing in metres, about the middle: `t1`, `t2`, … Groups: the halves `left`, `right`.
///
/// # Errors
/// No tactor, or more than [`MOST`](super::MOST); a spacing outside [`SIZES`](super::SIZES).
pub fn line(tactors: usize, spacing: f64) -> Result<Layout, Fault> {
    count("tactors", tactors, 1)?;
    length("spacing", spacing)?;
    let mut layout = Layout::new(
        format!("Line of {tactors}"),
        &[
            "From the wearer's left to the right.",
            "Positions are metres from the middle: x to the wearer's right, y up. Along an arm, turn x into what it is there.",
        ],
    );
    for n in 0..tactors {
        layout.add(format!("t{}", n + 1), [(n as f64 - 0.5 * (tactors - 1) as f64) * spacing, 0.0, 0.0]);
    }
    layout.halve(0, "left", "right");
    layout.checked()
}
