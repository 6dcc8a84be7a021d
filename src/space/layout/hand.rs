//! Finger tips, pads and palm.

use super::Layout;

/// From the wrist's crease to the middle finger's tip, across the knuckles, and of the palm from the crease to the middle finger's root,
/// in metres (hand length, hand breadth, palm length).
const LENGTH: f64 = 0.187;
const BREADTH: f64 = 0.083;
const PALM: f64 = 0.113;
/// A contactor sits this far from the end of a finger, in metres: a choice.
const TIP: f64 = 0.010;

/// Which hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Hand {
    /// The left.
    Left,
    /// The right.
    Right,
}

/// Name, and for the right hand how far to the right in shares of the breadth, and how far ahead in shares of the length.
const FINGERS: [(&str, f64, f64); 4] =
    [("index", -0.33, 0.94), ("middle", -0.09, 1.0), ("ring", 0.15, 0.95), ("little", 0.38, 0.82)];

/// Tips of thumb and fingers, pads at the fingers' roots, and four on the palm: thirteen.
///
/// The hand lies flat, palm down, fingers ahead: x points to the wearer's right, z ahead, from the wrist to the fingers, y up, out of the
/// back of the hand; all tactors are at y 0, on the palm's side. The origin is the middle of the wrist's crease. The left hand is the
/// mirror of the right. Groups: `tips`, `pads`, `palm`, and one a finger.
pub fn hand(hand: Hand) -> Layout {
    let (side, right) = match hand {
        Hand::Left => ("Left", -1.0),
        Hand::Right => ("Right", 1.0),
    };
    let mut layout = Layout::new(
        format!("{side} hand, 13"),
        &[
            "Tips of thumb and fingers, pads at the fingers' roots, four on the palm.",
            "The hand lies flat, palm down, fingers ahead. Positions are metres from the middle of the wrist's crease: x to the wearer's right, y up, z ahead, to the fingers.",
            "A hand 0.187 m long, its palm 0.113 m by 0.083 m: means of men and women of a survey (ANSUR II, 2012). How long each finger is of it, and where on the palm they sit, is a choice.",
        ],
    );
    let mut add = |name: String, x: f64, z: f64| layout.add(name, [right * x, 0.0, z]);
    add("thumb-tip".into(), -0.78 * BREADTH, 0.62 * LENGTH - TIP);
    for (name, x, share) in FINGERS {
        // Fingers spread a little.
        add(format!("{name}-tip"), 1.2 * x * BREADTH, share * LENGTH - TIP);
    }
    for (name, x, share) in FINGERS {
        add(format!("{name}-pad"), x * BREADTH, PALM * (0.55 + 0.45 * share) - TIP);
    }
    add("thumb-ball".into(), -0.30 * BREADTH, 0.42 * PALM);
    add("palm-middle".into(), 0.03 * BREADTH, 0.52 * PALM);
    add("little-ball".into(), 0.32 * BREADTH, 0.34 * PALM);
    add("heel".into(), 0.0, 0.14 * PALM);
    layout.gather("tips", |_, tactor| tactor.name.ends_with("-tip"));
    layout.gather("pads", |_, tactor| tactor.name.ends_with("-pad"));
    layout.gather("palm", |n, _| n >= 9);
    for finger in ["thumb", "index", "middle", "ring", "little"] {
        layout.gather(finger, |n, tactor| n < 9 && tactor.name.starts_with(finger));
    }
    layout
}
