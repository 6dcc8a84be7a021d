//! A circle around something, or a belt around the waist.

use super::{Layout, count, length};
use crate::space::fault::Fault;
use std::f64::consts::TAU;

/// Half of a waist's breadth and of its depth, in metres, with the belt and some clothes: rounded up from 0.157 and 0.113 (waist breadth
/// 0.313 and depth 0.225), a choice.
const WAIST: (f64, f64) = (0.18, 0.15);
/// Names of eight around.
const EIGHT: [&str; 8] =
    ["front", "front-right", "right", "back-right", "back", "back-left", "left", "front-left"];

/// Tactors on a circle of a radius in metres, lying level: the first in front, then to the wearer's right, clockwise seen from above.
///
/// Eight are called `front`, `front-right`, `right` and so on, four `front`, `right`, `back`, `left`, others `t1`, `t2`, … Groups:
/// `front-half`,
/// `back-half`, `left-half`, `right-half`.
///
/// # Errors
/// Fewer than three tactors, or more than [`MOST`](super::MOST); a radius outside [`SIZES`](super::SIZES).
pub fn ring(tactors: usize, radius: f64) -> Result<Layout, Fault> {
    length("radius", radius)?;
    around(tactors, (radius, radius), format!("Ring of {tactors}"), &[])
}

/// The same on an ellipse the size of a waist, 0.36 m wide and 0.30 m deep: at even angles of a circle that was pressed flat.
///
/// # Errors
/// Fewer than three tactors, or more than [`MOST`](super::MOST).
pub fn belt(tactors: usize) -> Result<Layout, Fault> {
    let note = "Around the waist, 0.36 m wide and 0.30 m deep with belt and clothes: a choice; waists are 0.31 m wide and 0.23 m deep on the mean.";
    around(tactors, WAIST, format!("Belt of {tactors}"), &[note])
}

fn around(tactors: usize, (wide, deep): (f64, f64), title: String, notes: &[&str]) -> Result<Layout, Fault> {
    count("tactors", tactors, 3)?;
    let mut all = notes.to_vec();
    all.extend([
        "The first is in front, the next to the wearer's right: clockwise, seen from above.",
        "Positions are metres from the middle: x to the wearer's right, y up, z ahead.",
    ]);
    let mut layout = Layout::new(title, &all);
    for n in 0..tactors {
        let name = match tactors {
            4 => EIGHT[2 * n].to_string(),
            8 => EIGHT[n].to_string(),
            _ => format!("t{}", n + 1),
        };
        let (right, ahead) = (n as f64 / tactors as f64 * TAU).sin_cos();
        layout.add(name, [wide * right, 0.0, deep * ahead]);
    }
    layout.halve(0, "left-half", "right-half");
    layout.halve(2, "back-half", "front-half");
    layout.checked()
}
