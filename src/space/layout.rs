//! Tactors of common arrays: names, positions in metres, groups.
//!
//! | of | is |
//! |---|---|
//! | [`grid()`], [`line()`] | rows and columns, one row |
//! | [`ring()`] | a circle, or a [`belt()`] around the waist |
//! | [`vest()`] | forty on chest and back |
//! | [`sleeve()`] | rows around a forearm |
//! | [`hand()`] | finger tips, pads, palm |
//!
//! Of the body, x points to the wearer's right, y up and z ahead; each layout says what that is on its limb. Sizes are those of the mean
//! of men and women of the 2012 survey of the U.S. Army (Gordon and others, "2012 Anthropometric Survey of U.S. Army Personnel",
//! Natick/TR-15/007, 2014: 4,082 men and 1,986 women; each sex counts as half), as computed from its public data; what is a choice is said
//! to be one. Measure the wearer, and write the wearer's own figures into the rig.

mod grid;
mod hand;
mod line;
mod ring;
mod sleeve;
mod vest;

pub use grid::grid;
pub use hand::{Hand, hand};
pub use line::line;
pub use ring::{belt, ring};
pub use sleeve::sleeve;
pub use vest::vest;

use super::fault::{Fault, within};
use super::point::Point;

/// Least and greatest distance of neighbours, or radius, in metres.
pub const SIZES: (f64, f64) = (1e-3, 10.0);
/// No coordinate of a rig is farther from 0, in metres.
const REACH: f64 = 1000.0;
/// A layout has no more tactors.
pub const MOST: usize = 1024;
/// Positions are rounded to as many parts of a metre: no tape measures finer, and so every machine writes the same file.
const GRAINS: f64 = 1e4;
/// On a middle line is what is no farther from it, in metres.
const MIDDLE: f64 = 1e-6;

/// A tactor of a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Its name: small letters, digits and hyphens.
    pub name: String,
    /// Where it is, in metres.
    pub position: Point,
}

/// Tactors that go by one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Its name, which no tactor of the layout has.
    pub name: String,
    /// Numbers of its tactors, rising, counted from 0; one at least.
    pub tactors: Vec<usize>,
}

/// Tactors with names, positions and groups.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// What it is, in a few words.
    pub title: String,
    /// Sentences for whoever wears it: where it begins, which way it goes, what x, y and z are, and where its sizes are from.
    pub notes: Vec<String>,
    /// In the order of their channels.
    pub tactors: Vec<Placed>,
    /// Halves, rows, sides.
    pub groups: Vec<Group>,
}

impl Layout {
    fn new(title: String, notes: &[&str]) -> Self {
        let notes = notes.iter().map(|note| note.to_string()).collect();
        Self { title, notes, tactors: Vec::new(), groups: Vec::new() }
    }

    /// The positions, for an array.
    pub fn positions(&self) -> Vec<Point> {
        self.tactors.iter().map(|tactor| tactor.position).collect()
    }

    /// A group by its name.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.groups.iter().find(|group| group.name == name)
    }

    /// Adds a tactor, rounded.
    fn add(&mut self, name: String, position: Point) {
        // Adding 0 takes the sign from −0.
        let position = position.map(|x| (x * GRAINS).round() / GRAINS + 0.0);
        self.tactors.push(Placed { name, position });
    }

    /// As it is, if a rig can hold it.
    ///
    /// # Errors
    /// A position beyond [`REACH`], or two tactors that rounding puts at one place.
    fn checked(self) -> Result<Self, Fault> {
        let mut places = std::collections::BTreeMap::new();
        for (n, tactor) in self.tactors.iter().enumerate() {
            if let Some(far) = tactor.position.iter().find(|x| x.abs() > REACH) {
                return Err(Fault::Range("position", *far, -REACH, REACH));
            }
            if let Some(other) = places.insert(tactor.position.map(|x| (x * GRAINS).round() as i64), n) {
                return Err(Fault::OnePlace(other, n, tactor.position));
            }
        }
        Ok(self)
    }

    /// Adds a group of the tactors that belong to it; none where there are none.
    fn gather(&mut self, name: impl Into<String>, belongs: impl Fn(usize, &Placed) -> bool) {
        let tactors: Vec<usize> = self
            .tactors
            .iter()
            .enumerate()
            .filter(|(n, tactor)| belongs(*n, tactor))
            .map(|(n, _)| n)
            .collect();
        if !tactors.is_empty() {
            self.groups.push(Group { name: name.into(), tactors });
        }
    }

    /// Adds the two halves of a coordinate: what is beyond the middle on either side. What is on it belongs to neither.
    fn halve(&mut self, coordinate: usize, below: &str, above: &str) {
        self.gather(below, |_, tactor| tactor.position[coordinate] < -MIDDLE);
        self.gather(above, |_, tactor| tactor.position[coordinate] > MIDDLE);
    }
}

/// Refuses what is no number of tactors.
fn count(name: &'static str, value: usize, least: usize) -> Result<(), Fault> {
    within(name, value as f64, least as f64, MOST as f64)
}

/// Refuses what is no size.
fn length(name: &'static str, value: f64) -> Result<(), Fault> {
    within(name, value, SIZES.0, SIZES.1)
}

#[cfg(test)]
mod tests;
