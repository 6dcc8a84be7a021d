//! Forty tactors on chest and back, as vests for games have them.

use super::Layout;
use crate::space::point::Point;

/// Rows and columns on either side.
const ROWS: usize = 5;
const COLUMNS: usize = 4;
/// Half of the breadth and of the depth of a chest, in metres: chest breadth 0.279, depth 0.251.
const CHEST: (f64, f64) = (0.140, 0.125);
/// The same at the navel: waist breadth 0.313, depth 0.225.
const WAIST: (f64, f64) = (0.157, 0.113);
/// From the navel to the chest's fullest part, in metres: chest height 1.231 less waist height 1.018.
const HEIGHT: f64 = 0.213;
/// Between columns around the body, in metres: a choice.
const SPACING: f64 = 0.06;
/// Steps by which a quarter of the way around an ellipse is measured: finer than what positions are rounded to.
const STEPS: usize = 10_000;

/// Five rows of four on the chest and on the back: `front-r1c1` to `front-r5c4`, then `back-r1c1` to `back-r5c4`.
///
/// Rows from the top: the first at the height of the chest's fullest part, the last at the navel's. Columns from the wearer's left on both
/// sides, 60 mm apart around the body: so the back is numbered as it is seen from behind. Groups: `front`, `back`, `left`, `right`,
/// `upper`, `lower`,
/// `r1` to `r5`, and with `front-` or `back-` each half and row of one side.
pub fn vest() -> Layout {
    let mut layout = Layout::new(
        "Vest of 40".into(),
        &[
            "Twenty on the chest, then twenty on the back: rows from the top, columns from the wearer's left.",
            "The first row is where the chest is fullest, the last at the navel, 0.21 m below; columns are 60 mm apart around the body.",
            "A chest 0.28 m wide and 0.25 m deep, a waist 0.31 m by 0.23 m: means of men and women of a survey (ANSUR II, 2012).",
            "Positions are metres from the middle of the trunk: x to the wearer's right, y up, z ahead.",
        ],
    );
    for (side, ahead) in [("front", 1.0), ("back", -1.0)] {
        for row in 0..ROWS {
            let down = row as f64 / (ROWS - 1) as f64;
            let girth = (CHEST.0 + down * (WAIST.0 - CHEST.0), CHEST.1 + down * (WAIST.1 - CHEST.1));
            for column in 0..COLUMNS {
                let way = (column as f64 - 0.5 * (COLUMNS - 1) as f64) * SPACING;
                let [x, z] = on_an_ellipse(girth, way);
                let position: Point = [x, (0.5 - down) * HEIGHT, ahead * z];
                layout.add(format!("{side}-r{}c{}", row + 1, column + 1), position);
            }
        }
    }
    let half = ROWS * COLUMNS;
    layout.gather("front", |n, _| n < half);
    layout.gather("back", |n, _| n >= half);
    layout.halve(0, "left", "right");
    layout.halve(1, "lower", "upper");
    let row = |n: usize| n % half / COLUMNS;
    (0..ROWS).for_each(|r| layout.gather(format!("r{}", r + 1), |n, _| row(n) == r));
    for (side, name) in ["front", "back"].into_iter().enumerate() {
        layout.gather(format!("{name}-left"), |n, tactor| n / half == side && tactor.position[0] < 0.0);
        layout.gather(format!("{name}-right"), |n, tactor| n / half == side && tactor.position[0] > 0.0);
        (0..ROWS).for_each(|r| {
            layout.gather(format!("{name}-r{}", r + 1), |n, _| n / half == side && row(n) == r)
        });
    }
    layout
}

/// The point of an ellipse a way around from where it is farthest ahead, to the right if above 0: x and z.
fn on_an_ellipse((wide, deep): (f64, f64), way: f64) -> [f64; 2] {
    let at = |angle: f64| [wide * angle.sin(), deep * angle.cos()];
    let step = std::f64::consts::FRAC_PI_2 / STEPS as f64;
    let (mut gone, mut last) = (0.0, at(0.0));
    for n in 1..=STEPS {
        let next = at(n as f64 * step);
        let piece = ((next[0] - last[0]).powi(2) + (next[1] - last[1]).powi(2)).sqrt();
        if gone + piece >= way.abs() {
            return [next[0].copysign(way), next[1]];
        }
        (gone, last) = (gone + piece, next);
    }
    [last[0].copysign(way), last[1]]
}
