//! End stops, and a contactor that leaves the skin.
//!
//! A stop is a spring with its damping that pushes and never pulls: force k p + c ṗ while that is positive and the depth p is. It stores
//! ½ k p² and no more, so no motion gains energy from it. Skin under a preload is such a stop as well, one in which the contactor rests;
//! while it is away its mass is still counted as moving with it. Between contacts everything is linear. The instants at which
//! one begins or ends are found within 2⁻⁴⁰ of a step, by going half of what is left if nothing happens in it: exact flows of
//! T/2, T/4, ... are laid out beforehand, so that no function is evaluated while running.

use super::bounds::Bounds;
use super::flow::{Flow, Reach};
use super::model::Counts;
use super::parameters::{Skin, Spring, Tissue, VoiceCoil};
use super::plant::{Kind, Plant, System, Touch};
use super::readout::Readout;
use crate::actuator::drive::Drive;
use crate::actuator::fault::Fault;

mod one_sided;

use one_sided::OneSided;

/// Halvings of a step.
const LEVELS: usize = 40;
const WHOLE: u64 = 1 << LEVELS;
/// A step is looked at in pieces in which nothing turns by more than this (radians), but no shorter than 2^-8 of it.
const TURN: f64 = 0.5;
const MOST_HALVINGS: usize = 8;
/// Contacts begun, ended, or nearly begun that are followed in a step.
const MOST_EVENTS: u32 = 8;
/// Upper stop, lower stop, skin.
const SPRINGS: usize = 3;
const SKIN: usize = 2;

/// What holds while the same springs push.
#[derive(Debug, Clone)]
struct Mode<const N: usize> {
    /// Over T, T/2, T/4, ...
    flows: Vec<Flow<N>>,
    /// Over the longest of these.
    reaches: Vec<Reach<N>>,
    readout: Readout<N>,
}

/// A plant with bounds.
#[derive(Debug, Clone)]
pub(super) struct Contact<const N: usize> {
    pub state: [f64; N],
    springs: [Option<OneSided>; SPRINGS],
    modes: Vec<Mode<N>>,
    /// Where the mode stands in which certain springs push, one bit each.
    places: [usize; 1 << SPRINGS],
    mode: usize,
    /// While y is held; and how the other coordinate goes along when it is stopped.
    stuck: Vec<Flow<N>>,
    along: f64,
    /// Force that presses the contactor on the skin, and the plant without the skin's spring.
    preload: f64,
    lifted: Plant,
    counts: Counts,
}

impl<const N: usize> Contact<N> {
    pub fn new(plant: &Plant, period: f64, drive: Drive, bounds: &Bounds) -> Result<Self, Fault> {
        let mut springs = [None; SPRINGS];
        if let Some(stop) = &bounds.end_stop {
            springs[0] = Some(OneSided::new(1.0, stop.stroke, stop.spring));
            springs[1] = Some(OneSided::new(-1.0, -stop.stroke, stop.spring));
        }
        let (mut preload, mut lifted) = (0.0, *plant);
        if let (Some(force), Kind::Tactor(v)) = (bounds.preload, &plant.kind)
            && let Skin::One(tissue) = &v.skin
        {
            let bare = Skin::One(Tissue { mass: tissue.mass, spring: Spring::default() });
            lifted = Plant::voice_coil(&VoiceCoil { skin: bare, ..*v })?;
            preload = force;
            springs[SKIN] = Some(OneSided::new(1.0, -force / tissue.spring.stiffness, tissue.spring));
        }
        let (mut modes, mut places) = (Vec::new(), [0; 1 << SPRINGS]);
        for (pushing, place) in places.iter_mut().enumerate() {
            let pushes = |i: usize| pushing >> i & 1 == 1;
            if (0..SPRINGS).any(|i| pushes(i) && springs[i].is_none()) || (pushes(0) && pushes(1)) {
                continue;
            }
            let touched = springs[SKIN].is_none() || pushes(SKIN);
            // On the skin the preload and the skin's answer to it are in balance.
            let (base, force) = if touched { (plant, 0.0) } else { (&lifted, preload) };
            let mut touch = Touch { force, ..Touch::default() };
            for (i, side) in [(0, 1.0), (1, -1.0)] {
                if let (true, Some(stop)) = (pushes(i), &bounds.end_stop) {
                    touch.spring = stop.spring;
                    touch.force += side * stop.spring.stiffness * stop.stroke;
                }
            }
            let readout = Readout::new(plant, drive, &base.system(drive, &touch), touched, preload);
            *place = modes.len();
            modes.push(Mode::new(base, period, drive, &touch, readout));
        }
        let mut new = Self {
            state: [0.0; N],
            springs,
            modes,
            places,
            mode: 0,
            stuck: ladder(&plant.held(drive), period),
            along: plant.along(),
            preload,
            lifted,
            counts: Counts::default(),
        };
        new.resume();
        Ok(new)
    }

    /// Which springs push, from where the state is.
    pub fn resume(&mut self) {
        self.mode = self.pushing(&self.state);
    }

    pub fn counts(&self) -> Counts {
        self.counts
    }

    pub fn readout(&self) -> &Readout<N> {
        &self.current().readout
    }

    pub fn flow(&self) -> &Flow<N> {
        &self.current().flows[0]
    }

    #[inline(always)]
    pub fn advance(&mut self, drive: f64) {
        let mode = self.current();
        if self.stays(mode, 0, drive) {
            self.state = mode.flows[0].after(&self.state, drive);
        } else {
            self.walk(drive);
        }
    }

    /// Energy in masses and springs; in the skin, less the work that the preload has done.
    pub fn mechanical_energy(&self, _: &Plant) -> f64 {
        let y = self.state[0];
        let mut sum = self.lifted.mechanical_energy(&self.state);
        for (i, spring) in self.springs.iter().enumerate() {
            let Some(spring) = spring else { continue };
            let depth = spring.depth(y);
            if i == SKIN {
                let at_rest = 0.5 * self.preload * -spring.origin;
                sum -= self.preload * y + at_rest;
            }
            if depth > 0.0 {
                sum += 0.5 * spring.stiffness * depth * depth;
            }
        }
        sum
    }

    #[inline(always)]
    fn current(&self) -> &Mode<N> {
        &self.modes[self.places[self.mode]]
    }

    fn pushing(&self, x: &[f64; N]) -> usize {
        let pushes = |i: usize| self.springs[i].as_ref().is_some_and(|s| s.guard(x[0], x[1]) > 0.0);
        (0..SPRINGS).map(|i| usize::from(pushes(i)) << i).sum()
    }

    /// Whether it is certain that the same springs push for T/2^level.
    #[inline(always)]
    fn stays(&self, mode: &Mode<N>, level: usize, drive: f64) -> bool {
        let Some(reach) = mode.reaches.get(level) else { return false };
        let [way, change] = reach.of(&self.state, drive);
        let (y, velocity) = (self.state[0], self.state[1]);
        self.springs.iter().enumerate().all(|(i, spring)| {
            let Some(spring) = spring else { return true };
            let depth = spring.depth(y);
            if self.mode >> i & 1 == 0 {
                return depth + way < 0.0;
            }
            let away = change - spring.side * velocity;
            depth - way - spring.relaxation * if away > 0.0 { away } else { 0.0 } > 0.0
        })
    }

    /// A step in which something may happen.
    #[inline(never)]
    fn walk(&mut self, drive: f64) {
        let (mut left, mut searches) = (WHOLE, 0);
        while left > 0 {
            let mode = self.current();
            let (mut level, finest) = (LEVELS - left.ilog2() as usize, mode.reaches.len() - 1);
            let calm = loop {
                if level > finest || self.stays(mode, level, drive) {
                    break level <= finest;
                }
                if level == finest {
                    break false;
                }
                level += 1;
            };
            let end = mode.flows[level].after(&self.state, drive);
            if calm || !self.breaks(&self.state, &end) {
                self.state = end;
                left -= WHOLE >> level;
                continue;
            }
            if searches == MOST_EVENTS {
                return self.stick(left, drive);
            }
            // As far as nothing breaks, by ever smaller steps; then to the nearest point known at which it is broken.
            let (mut x, mut beyond) = (self.state, (end, left - (WHOLE >> level)));
            for finer in level + 1..=LEVELS {
                let next = mode.flows[finer].after(&x, drive);
                if self.breaks(&self.state, &next) {
                    beyond = (next, left - (WHOLE >> finer));
                } else {
                    x = next;
                    left -= WHOLE >> finer;
                }
            }
            (self.state, left) = beyond;
            let pushing = self.pushing(&self.state);
            self.counts.events += u64::from(pushing != self.mode);
            self.mode = pushing;
            searches += 1;
        }
    }

    /// Whether from `begin` to `x` a spring came to push or ceased to, or passed the point at which it was nearest to that.
    #[inline(always)]
    fn breaks(&self, begin: &[f64; N], x: &[f64; N]) -> bool {
        self.springs.iter().enumerate().any(|(i, spring)| {
            let Some(spring) = spring else { return false };
            let (pushed, pushes) = (self.mode >> i & 1 == 1, spring.guard(x[0], x[1]) > 0.0);
            let side = if pushed { -spring.side } else { spring.side };
            pushes != pushed || (side * begin[1] > 0.0 && side * x[1] <= 0.0)
        })
    }

    /// After too many events: y stands still for the rest of the step, and all the energy of its motion is lost.
    fn stick(&mut self, mut left: u64, drive: f64) {
        self.counts.capped += 1;
        let speed = self.state[1];
        self.state[1] = 0.0;
        if N > 3 {
            self.state[3] -= speed * self.along;
        }
        while left > 0 {
            let level = LEVELS - left.ilog2() as usize;
            self.state = self.stuck[level].after(&self.state, drive);
            left -= WHOLE >> level;
        }
        self.resume();
    }
}

impl<const N: usize> Mode<N> {
    fn new(plant: &Plant, period: f64, drive: Drive, touch: &Touch, readout: Readout<N>) -> Self {
        let system = plant.system(drive, touch);
        let turns = plant.pace(drive, touch) * period / TURN;
        let halvings = if turns > 1.0 { (turns.log2().ceil() as usize).min(MOST_HALVINGS) } else { 0 };
        Self {
            flows: ladder(&system, period),
            reaches: Reach::halvings(&system, period, halvings + 1),
            readout,
        }
    }
}

/// Over T, T/2, T/4, ...
fn ladder<const N: usize>(system: &System, period: f64) -> Vec<Flow<N>> {
    (0..=LEVELS).map(|level| Flow::new(system, period * 0.5f64.powi(level as i32))).collect()
}

#[cfg(test)]
mod tests;
