//! Rows and columns.

use super::{Layout, count, length};
use crate::space::fault::{Fault, within};

/// Rows from the top, columns from the wearer's left, at one spacing in metres, about the middle: `r1c1`, `r1c2`, …
///
/// Groups: the rows `r1`, …, the columns `c1`, …, and the halves `left`, `right`, `upper`, `lower`.
///
/// # Errors
/// Rows or columns of none; more than [`MOST`](super::MOST) tactors; a spacing outside [`SIZES`](super::SIZES).
pub fn grid(rows: usize, columns: usize, spacing: f64) -> Result<Layout, Fault> {
    count("rows", rows, 1)?;
    count("columns", columns, 1)?;
    within("rows × columns", rows as f64 * columns as f64, 1.0, super::MOST as f64)?;
    length("spacing", spacing)?;
    let mut layout = Layout::new(
        format!("Grid, {rows} by {columns}"),
        &[
            "Rows from the top, columns from the wearer's left. On the back, that is as it is seen from behind.",
            "Positions are metres from the middle of the array: x to the wearer's right, y up.",
        ],
    );
    let from_the_middle = |n: usize, of: usize| (n as f64 - 0.5 * (of - 1) as f64) * spacing;
    for row in 0..rows {
        for column in 0..columns {
            let position = [from_the_middle(column, columns), -from_the_middle(row, rows), 0.0];
            layout.add(format!("r{}c{}", row + 1, column + 1), position);
        }
    }
    (0..rows).for_each(|row| layout.gather(format!("r{}", row + 1), |n, _| n / columns == row));
    (0..columns).for_each(|column| layout.gather(format!("c{}", column + 1), |n, _| n % columns == column));
    layout.halve(0, "left", "right");
    layout.halve(1, "lower", "upper");
    layout.checked()
}
