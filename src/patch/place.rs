//! Where on the body.

use super::way::{self, Way};
use crate::text::reader::{At, Reader};

/// A place, as written: `"top"`, `3`, `[0.0, -0.2]`, `["left", "right"]`, `{ path = [[0, 0], [0.1, 0]] }`. A rig finds its tactors.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// The tactor, or the group, of that name.
    Name(String),
    /// Those of these names, each with the whole level.
    Names(Vec<String>),
    /// A channel of the device, from 1.
    Channel(u32),
    /// Metres; the tactors about it share it.
    Position([f64; 3]),
    /// Along a path, shared by the tactors about it all the way.
    Path(Box<Way>),
}

/// The highest channel that a place may name, and so the most that a device may have.
pub const MAX_CHANNELS: u32 = 4096;

/// The most metres from the origin, along each axis.
pub const MOST_METRES: f64 = 1000.0;

const WANTED: &str = "it must be the name of a tactor or a group, a list of such names, a channel from 1 to 4096, a position [x, y] or [x, y, z] in metres or a path { path = [[x, y], ...] }";

/// Reads the place at a key.
pub(crate) fn read(reader: &Reader, key: &str) -> Option<Place> {
    let value = reader.at(key)?;
    if let Some(table) = value.table() {
        return way::read(table, &value, reader).map(|way| Place::Path(Box::new(way)));
    }
    let place = at_rest(&value);
    if place.is_none() {
        reader.wrong(key, &value, &wanted(&value, WANTED));
    }
    place
}

/// A place that does not move.
pub(super) fn at_rest(value: &At) -> Option<Place> {
    match (value.text(), value.count()) {
        (Some(name), _) if !name.is_empty() => Some(Place::Name(name.into())),
        (_, Some(n)) => channel(n).map(Place::Channel),
        _ => position_of(value).map(Place::Position).or_else(|| names_of(value).map(Place::Names)),
    }
}

/// Reads the position at a key: two or three coordinates.
pub(crate) fn read_position(reader: &Reader, key: &str) -> Option<[f64; 3]> {
    let value = reader.at(key)?;
    let position = position_of(&value);
    if position.is_none() {
        reader.wrong(key, &value, &wanted(&value, "it must be a position [x, y] or [x, y, z] in metres"));
    }
    position
}

/// What is wrong with a place or a position: if it is a list of numbers, with those.
fn wanted(value: &At, otherwise: &str) -> String {
    let numbers: Option<Vec<f64>> = value.list().and_then(|list| list.map(|v| v.number()).collect());
    match numbers.as_deref() {
        Some([]) => otherwise.into(),
        Some(list @ ([_, _] | [_, _, _])) if list.iter().all(|x| x.is_finite()) => {
            format!("no coordinate may be further than {MOST_METRES} m from 0")
        }
        Some([_, _] | [_, _, _]) => "every coordinate must be a number of metres".into(),
        Some(other) => format!(
            "a position has two or three coordinates, [x, y] or [x, y, z] in metres; here {} {}",
            if other.len() == 1 { "is" } else { "are" },
            other.len()
        ),
        None => otherwise.into(),
    }
}

/// Names, at least one and none of them empty.
fn names_of(value: &At) -> Option<Vec<String>> {
    let name = |value: At| value.text().filter(|name| !name.is_empty()).map(String::from);
    let names: Vec<String> = value.list()?.map(name).collect::<Option<_>>()?;
    (!names.is_empty()).then_some(names)
}

/// Two or three coordinates as they stand in a file.
pub(super) fn position_of(value: &At) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = value.list()?.map(|v| v.number()).collect();
    position(&numbers?)
}

/// A channel number from 1.
pub(crate) fn channel(n: u64) -> Option<u32> {
    u32::try_from(n).ok().filter(|n| (1..=MAX_CHANNELS).contains(n))
}

/// Two or three coordinates within reach.
pub(crate) fn position(numbers: &[f64]) -> Option<[f64; 3]> {
    if numbers.iter().any(|x| !x.is_finite() || x.abs() > MOST_METRES) {
        return None;
    }
    match *numbers {
        [x, y] => Some([x, y, 0.0]),
        [x, y, z] => Some([x, y, z]),
        _ => None,
    }
}
