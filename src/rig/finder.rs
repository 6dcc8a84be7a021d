//! Outputs of a rig in an order in which they are found at once, for many events on many tactors.

use super::{Output, OutputKind, Rig};
use crate::patch::{Patch, Place};
use crate::space::path::Route;
use crate::space::spot::Spot;
use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};

/// Where the outputs of a rig are found. It is that of the rig as it was when this was made.
#[derive(Debug, Clone, Default)]
pub struct Finder {
    /// Where nothing is said.
    first: Option<usize>,
    /// The first of each name, and of each channel.
    names: HashMap<Box<str>, usize>,
    channels: HashMap<u32, usize>,
    /// The axis along which tactors lie apart most, and the tactors that have a position in order along it.
    axis: usize,
    along: Vec<Tactor>,
    /// What sounds together: groups, and lists of names in a patch, as outputs.
    together: Vec<Vec<usize>>,
    called: Vec<String>,
    groups: HashMap<Box<str>, usize>,
    lists: HashMap<Vec<String>, usize>,
    /// The paths in a patch, each once.
    paths: Vec<Route>,
    ways: HashMap<Vec<u64>, u32>,
    /// How many outputs there are.
    outputs: usize,
}

#[derive(Debug, Clone, Copy)]
struct Tactor {
    at: [f64; 3],
    output: usize,
}

/// What tells a path from others.
fn bits(Route { path, stretched }: &Route) -> Vec<u64> {
    let numbers = path.points().iter().flatten().chain(path.times());
    let mut bits: Vec<u64> = numbers.map(|x| x.to_bits()).collect();
    bits.extend([path.seconds().to_bits(), u64::from(path.is_smooth()), u64::from(*stretched)]);
    bits
}

/// The output that is meant where nothing is said: the first tactor; of a rig of motors alone, the first motor.
pub(super) fn first(outputs: &[Output]) -> Option<usize> {
    let is = |kind: fn(&OutputKind) -> bool| outputs.iter().position(|output| kind(&output.kind));
    is(|kind| *kind == OutputKind::Vibration).or_else(|| is(|kind| matches!(kind, OutputKind::Drive(_))))
}

impl Finder {
    /// That of a rig and of the lists of names in a patch.
    pub fn with(rig: &Rig, patch: &Patch) -> Self {
        let mut finder = Self::new(rig);
        patch.each_place_written(|place| {
            if let Place::Path(way) = place {
                let number = finder.paths.len() as u32;
                let entry = finder.ways.entry(bits(way.route()));
                if let Entry::Vacant(vacant) = entry {
                    vacant.insert(number);
                    finder.paths.push(way.route().clone());
                }
            }
            let Place::Names(names) = place else { return };
            if finder.lists.contains_key(names) {
                return;
            }
            let found: Option<Vec<Vec<usize>>> = names.iter().map(|name| finder.named(name)).collect();
            if let Some(found) = found {
                finder.lists.insert(names.to_vec(), finder.together.len());
                let all: BTreeSet<usize> = found.into_iter().flatten().collect();
                finder.together.push(all.into_iter().collect());
                finder.called.push(names.join(" + "));
            }
        });
        finder
    }

    /// That of a rig.
    pub fn new(rig: &Rig) -> Self {
        let outputs = rig.outputs.len();
        let mut finder = Self { first: first(&rig.outputs), outputs, ..Self::default() };
        for (i, output) in rig.outputs.iter().enumerate() {
            finder.names.entry(output.name.as_str().into()).or_insert(i);
            finder.channels.entry(output.channel).or_insert(i);
            if output.kind != OutputKind::Vibration {
                continue;
            }
            let at = output.position.filter(|at| at.iter().all(|x| x.is_finite()));
            finder.along.extend(at.map(|at| Tactor { at, output: i }));
        }
        let spread = |axis: usize| {
            let all = || finder.along.iter().map(|tactor| tactor.at[axis]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        finder.axis = (0..3).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
        let axis = finder.axis;
        finder.along.sort_by(|a, b| a.at[axis].total_cmp(&b.at[axis]));
        for group in &rig.groups {
            let all = group.tactors.iter().filter_map(|name| finder.names.get(name.as_str()).copied());
            let all = all.collect();
            finder.groups.entry(group.name.as_str().into()).or_insert(finder.together.len());
            finder.together.push(all);
            finder.called.push(group.name.clone());
        }
        finder
    }

    /// Outputs that sound together, by their places in [`Rig::outputs`]: what [`Spot::Row`] counts behind the outputs themselves.
    pub fn together(&self) -> &[Vec<usize>] {
        &self.together
    }

    /// What those are called: a group by its name, a list by all of its names.
    pub fn called(&self) -> impl Iterator<Item = &str> {
        self.called.iter().map(String::as_str)
    }

    /// How far tactors lie apart along the axis along which they do most, m; 0 with fewer than two.
    pub(super) fn extent(&self) -> f64 {
        let at = |tactor: &Tactor| tactor.at[self.axis];
        match (self.along.first(), self.along.last()) {
            (Some(first), Some(last)) => at(last) - at(first),
            _ => 0.0,
        }
    }

    /// The paths that are places: what [`Spot::Path`] counts.
    pub fn paths(&self) -> &[Route] {
        &self.paths
    }

    /// What a row is called.
    pub fn name_of<'a>(&'a self, rig: &'a Rig, row: usize) -> Option<&'a str> {
        let output = rig.outputs.get(row).map(|output| output.name.as_str());
        output.or_else(|| self.called.get(row.checked_sub(self.outputs)?).map(String::as_str))
    }

    /// The outputs that may sound where something was found.
    pub fn outputs(&self, spot: Spot) -> Vec<usize> {
        match spot {
            Spot::Point(_) | Spot::Path(_) => self.along.iter().map(|tactor| tactor.output).collect(),
            Spot::Row(row) if (row as usize) < self.outputs => vec![row as usize],
            Spot::Row(row) => self.together.get(row as usize - self.outputs).cloned().unwrap_or_default(),
        }
    }

    /// The tactor or the group of a name.
    fn named(&self, name: &str) -> Option<Vec<usize>> {
        let group = || self.together.get(*self.groups.get(name)?).cloned();
        self.names.get(name).map(|output| vec![*output]).or_else(group)
    }

    /// Where something sounds; where nothing is said, on [`first`].
    pub(super) fn find(&self, place: Option<&Place>) -> Option<Spot> {
        let row = |row: usize| Spot::Row(u32::try_from(row).unwrap_or(u32::MAX));
        let together = |number: &usize| row(self.outputs + number);
        match place {
            Some(Place::Position(position)) => (!self.along.is_empty()).then_some(Spot::Point(*position)),
            Some(Place::Path(_)) if self.along.is_empty() => None,
            Some(Place::Path(way)) => self.ways.get(&bits(way.route())).copied().map(Spot::Path),
            Some(Place::Names(names)) => self.lists.get(names).map(together),
            Some(Place::Name(name)) if !self.names.contains_key(name.as_str()) => {
                self.groups.get(name.as_str()).map(together)
            }
            other => self.output(other).map(row),
        }
    }

    /// The output at a place, by its place in [`Rig::outputs`]; where nothing is said, [`first`]; of a position, the nearest tactor.
    pub(super) fn output(&self, place: Option<&Place>) -> Option<usize> {
        match place {
            None => self.first,
            Some(Place::Name(name)) => self.names.get(name.as_str()).copied(),
            Some(Place::Channel(channel)) => self.channels.get(channel).copied(),
            Some(Place::Position(position)) => self.nearest(position).map(|(_, output)| output),
            Some(Place::Names(_) | Place::Path(_)) => None,
        }
    }

    /// The nearest tactor, the first in the rig among equals, with its distance in metres.
    pub(super) fn nearest(&self, position: &[f64; 3]) -> Option<(f64, usize)> {
        let middle = self.along.partition_point(|tactor| tactor.at[self.axis] < position[self.axis]);
        let mut best: Option<(f64, usize)> = None;
        // Says whether those beyond it cannot be nearer, as they are farther already along the axis.
        let mut see = |tactor: &Tactor| {
            let apart = tactor.at[self.axis] - position[self.axis];
            if best.is_some_and(|(least, _)| apart * apart > least) {
                return true;
            }
            let far: f64 = tactor.at.iter().zip(position).map(|(a, b)| (a - b) * (a - b)).sum();
            if best.is_none_or(|(least, first)| far < least || (far == least && tactor.output < first)) {
                best = Some((far, tactor.output));
            }
            false
        };
        // From the place outwards, both ways in turn.
        let (mut down, mut up) = (self.along[..middle].iter().rev(), self.along[middle..].iter());
        let (mut below, mut above) = (true, true);
        while below || above {
            below = below && down.next().is_some_and(|tactor| !see(tactor));
            above = above && up.next().is_some_and(|tactor| !see(tactor));
        }
        best.map(|(square, output)| (square.sqrt(), output))
    }
}

#[cfg(test)]
mod tests {
    use super::Finder;
    use crate::patch::Place;
    use crate::rig::{OutputKind, Rig};

    /// By the definition: all of them are looked at.
    fn nearest(rig: &Rig, position: &[f64; 3]) -> Option<usize> {
        let tactors = rig.outputs.iter().enumerate().filter(|(_, o)| o.kind == OutputKind::Vibration);
        let far = |at: [f64; 3]| at.iter().zip(position).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let all = tactors.filter_map(|(i, o)| Some((far(o.position?), i)));
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, i)| i)
    }

    #[test]
    fn what_is_found_is_the_first_or_the_nearest() {
        let mut state = 1_u64;
        let mut number = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % below
        };
        for round in 0..60_u64 {
            let mut rig = Rig::default_for(1 + number(80) as u32);
            for output in &mut rig.outputs {
                // Coarse, so that many are equally near.
                let coarse = [number(9) as f64 / 10.0, number(5) as f64 / 10.0, number(3) as f64 / 10.0];
                output.position = Some(coarse).filter(|_| round % 3 > 0 || number(3) > 0);
                output.channel = 1 + number(40) as u32;
                output.name = format!("t{}", number(40));
                if round % 2 > 0 && number(4) == 0 {
                    output.kind = OutputKind::Raw;
                }
            }
            let finder = Finder::new(&rig);
            for _ in 0..200 {
                let at = [number(21) as f64 / 20.0, number(21) as f64 / 20.0, number(9) as f64 / 20.0];
                assert_eq!(finder.output(Some(&Place::Position(at))), nearest(&rig, &at), "{at:?}: {rig:?}");
                let (name, channel) = (format!("t{}", number(50)), number(50) as u32);
                let by_name = rig.outputs.iter().position(|o| o.name == name);
                assert_eq!(finder.output(Some(&Place::Name(name))), by_name);
                let by_channel = rig.outputs.iter().position(|o| o.channel == channel);
                assert_eq!(finder.output(Some(&Place::Channel(channel))), by_channel);
            }
            let first = rig.outputs.iter().position(|o| o.kind == OutputKind::Vibration);
            assert_eq!(finder.output(None), first);
        }
    }

    /// A million events on 4,096 tactors look at few of them each.
    #[test]
    fn few_tactors_are_looked_at() {
        let mut rig = Rig::default_for(4096);
        for (i, output) in rig.outputs.iter_mut().enumerate() {
            output.position = Some([(i / 64) as f64 * 0.02, (i % 64) as f64 * 0.02, 0.0]);
        }
        let finder = Finder::new(&rig);
        for n in 0..1_000_000_u32 {
            let i = (n as usize * 2_654_435_761) % 4096;
            let place = match n % 3 {
                0 => Place::Name(format!("t{}", i + 1)),
                1 => Place::Channel(i as u32 + 1),
                _ => Place::Position(rig.outputs[i].position.unwrap_or_default()),
            };
            assert_eq!(finder.output(Some(&place)), Some(i));
        }
    }
}
