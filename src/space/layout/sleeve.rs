//! Rows around a forearm.

use super::{Layout, count};
use crate::space::fault::{Fault, within};
use std::f64::consts::TAU;

/// Around the wrist, and around the forearm at its thickest, in metres (wrist and flexed forearm circumference).
const WRIST: f64 = 0.165;
const FOREARM: f64 = 0.287;
/// From the wrist to the elbow, in metres (radiale to stylion).
const LENGTH: f64 = 0.255;
/// The first and the last row, in shares of the way from the wrist to the elbow: a choice, so that hand and elbow can move.
const ROWS: (f64, f64) = (0.1, 0.9);

/// Rows from the wrist to the elbow, each with tactors around the arm: `r1a1`, `r1a2`, …; the first of each is on top, the next to the
/// wearer's right.
///
/// The arm is held out ahead, palm down: x points to the wearer's right, y up, out of the back of the hand, z ahead, from the elbow to the
/// hand. Groups: the rows `r1`, …, the lines along the arm `a1`, …, and the halves `top`, `under`, `left`, `right`, `hand-side`,
/// `elbow-side`.
///
/// # Errors
/// No row; fewer than three around; more than [`MOST`](super::MOST) tactors.
pub fn sleeve(rows: usize, around: usize) -> Result<Layout, Fault> {
    count("rows", rows, 1)?;
    count("around", around, 3)?;
    within("rows × around", rows as f64 * around as f64, 3.0, super::MOST as f64)?;
    let mut layout = Layout::new(
        format!("Sleeve, {rows} rows of {around}"),
        &[
            "Rows from the wrist to the elbow. In each the first is on top, the next to the wearer's right: clockwise, looking ahead.",
            "The arm is held out ahead, palm down. Positions are metres from the middle of the forearm: x to the wearer's right, y up, z ahead, to the hand.",
            "A forearm 0.255 m long, 0.165 m around at the wrist and 0.287 m where it is thickest, taken to be round and to taper evenly: means of men and women of a survey (ANSUR II, 2012).",
        ],
    );
    for row in 0..rows {
        let share = if rows > 1 { row as f64 / (rows - 1) as f64 } else { 0.5 };
        let way = ROWS.0 + share * (ROWS.1 - ROWS.0);
        let radius = (WRIST + way * (FOREARM - WRIST)) / TAU;
        for n in 0..around {
            let (right, up) = (n as f64 / around as f64 * TAU).sin_cos();
            layout
                .add(format!("r{}a{}", row + 1, n + 1), [radius * right, radius * up, (0.5 - way) * LENGTH]);
        }
    }
    (0..rows).for_each(|row| layout.gather(format!("r{}", row + 1), |n, _| n / around == row));
    (0..around).for_each(|a| layout.gather(format!("a{}", a + 1), |n, _| n % around == a));
    layout.halve(0, "left", "right");
    layout.halve(1, "under", "top");
    layout.halve(2, "elbow-side", "hand-side");
    layout.checked()
}
