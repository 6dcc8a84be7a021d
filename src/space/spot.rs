//! Where a voice sounds.

use std::borrow::Cow;

use super::array::Array;
use super::law::Law;
use super::point::Point;
use super::row::Row;

/// A place that was found in a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spot {
    /// Tactors with gains, by their row in a list that goes with the rig.
    Row(u32),
    /// A point in metres, which tactors share.
    Point(Point),
    /// Along a path, by its place in a list that goes with the rig.
    Path(u32),
}

impl Default for Spot {
    fn default() -> Self {
        Self::Row(0)
    }
}

impl Spot {
    /// What it is called, where rows have names: a point by its coordinates, `[0.1, -0.2, 0.0]`, a path by its number, `path 1`. A row without
    /// a name is called nothing.
    pub fn name<'a>(self, row: impl FnOnce(usize) -> Option<&'a str>) -> Cow<'a, str> {
        match self {
            Self::Row(number) => row(number as usize).unwrap_or_default().into(),
            Self::Point(point) => format!("{point:?}").into(),
            Self::Path(number) => format!("path {}", u64::from(number) + 1).into(),
        }
    }

    /// The point or the path of that name.
    pub fn unnamed(name: &str) -> Option<Self> {
        if let Some(number) = name.strip_prefix("path ") {
            return number.parse().ok().and_then(|n: u32| n.checked_sub(1)).map(Self::Path);
        }
        let numbers: Result<Vec<f64>, _> =
            name.strip_prefix('[')?.strip_suffix(']')?.split(',').map(|x| x.trim().parse()).collect();
        let point: Point = numbers.ok()?.try_into().ok()?;
        point.iter().all(|x| x.is_finite()).then_some(Self::Point(point))
    }
}

/// Tactors that share points, and the channels on which they hang.
#[derive(Debug, Clone)]
pub struct Spread {
    array: Array,
    /// By tactor: its channel, and the gain of what hangs there.
    channels: Vec<(u32, f64)>,
    row: Row,
}

impl Spread {
    /// Of an array, the channel and gain of each of its tactors; `None` where there are not as many.
    pub fn new(array: Array, channels: Vec<(u32, f64)>) -> Option<Self> {
        let row = array.row();
        (array.tactors() == channels.len()).then_some(Self { array, channels, row })
    }

    /// The array.
    pub fn array(&self) -> &Array {
        &self.array
    }

    /// By tactor: its channel, and the gain of what hangs there.
    pub fn channels(&self) -> &[(u32, f64)] {
        &self.channels
    }

    /// Adds the channels that a point of a width (m) sounds on, with their gains; at most as many as there are tactors. For the audio thread, if
    /// the list has room for them.
    pub fn gains(&mut self, point: Point, width: f64, law: Law, gains: &mut Vec<(u32, f64)>) {
        self.array.weights(point, width, law, &mut self.row);
        for share in self.row.shares() {
            if let Some((channel, gain)) = self.channels.get(share.tactor as usize) {
                gains.push((*channel, gain * law.gain(share.weight)));
            }
        }
    }
}

impl PartialEq for Spread {
    /// Whether the same tactors hang on the same channels.
    fn eq(&self, other: &Self) -> bool {
        self.channels == other.channels && self.array.same(&other.array)
    }
}
