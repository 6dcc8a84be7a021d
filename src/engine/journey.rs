//! Voices on their way: where each is, and with which gains it reaches the channels, engine sample by engine sample.

use std::cell::Cell;
use std::ops::Range;
use std::sync::Arc;

use super::lane::Lane;
use super::workspace::Bus;
use crate::dsp::lanes::Real;
use crate::graph::places::Needs;
use crate::graph::plan::Instrument;
use crate::graph::program::Feed;
use crate::node::kernel::LEAD;
use crate::patch::Pitch;
use crate::perception::gauge::Gauge;
use crate::schedule::Instant;
use crate::space::law::Law;
use crate::space::moving::{Age, Mover, Steps, Trail};
use crate::space::path::Route;
use crate::space::point::Point;
use crate::space::spot::Spot;

/// The voices of an instrument that move, by their lanes.
#[derive(Debug)]
pub struct Journeys {
    routes: Arc<[Route]>,
    /// By channel: what it needs to be felt.
    gauges: Arc<[Option<Gauge>]>,
    pitch: Pitch,
    /// Where its program says where it is: x, y, z, and by how much its width grows.
    steers: Option<[Feed; 4]>,
    law: Law,
    width: f64,
    rate: f64,
    /// None where none can move.
    list: Vec<Journey>,
}

/// The way of one voice.
#[derive(Debug, Clone, Default)]
struct Journey {
    from: Spot,
    /// How loud it is.
    gain: f64,
    trail: Trail,
    /// Where in the array it was last.
    piece: u32,
}

impl Journeys {
    /// For so many lanes of an instrument, in an engine at `rate`.
    pub fn new(
        instrument: &Instrument,
        routes: &Arc<[Route]>,
        gauges: &Arc<[Option<Gauge>]>,
        lanes: usize,
        rate: f64,
    ) -> Self {
        let outputs = &instrument.program.outputs;
        let steers =
            if instrument.steered { outputs.get(1..5).and_then(|o| o.try_into().ok()) } else { None };
        let moves = steers.is_some() || !routes.is_empty();
        Self {
            routes: Arc::clone(routes),
            gauges: Arc::clone(gauges),
            pitch: instrument.pitch,
            steers,
            law: instrument.law,
            width: instrument.width,
            rate,
            list: vec![Journey::default(); if moves { lanes } else { 0 }],
        }
    }

    /// Whether a voice that begins at a place is on its way from then on.
    pub fn take(&self, place: Spot) -> bool {
        self.steers.is_some() || matches!(place, Spot::Path(_))
    }

    /// A voice begins on a lane.
    pub fn begin(&mut self, lane: usize, place: Spot, gain: f64) {
        if let Some(journey) = self.list.get_mut(lane) {
            *journey = Journey { from: place, gain, ..Journey::default() };
        }
    }

    /// A voice goes on from a place, where it was already under way.
    pub fn go_on(&mut self, lane: usize, place: Spot, gain: f64) {
        if let Some(journey) = self.list.get_mut(lane) {
            (journey.from, journey.gain) = (place, gain);
        }
    }

    /// Takes over what was under way, if there are as many lanes.
    pub fn swap(&mut self, old: &mut Self) {
        if self.list.len() == old.list.len() {
            std::mem::swap(&mut self.list, &mut old.list);
        }
    }

    /// Takes on what is under way on the lanes elsewhere.
    pub fn copy(&mut self, from: &Self) {
        self.list.iter_mut().zip(&from.list).for_each(|(to, from)| to.clone_from(from));
    }

    /// The feeds that say where voices are.
    pub fn steers(&self) -> Option<[Feed; 4]> {
        self.steers
    }

    /// Adds a voice to the channels over some frames, in a mix whose row for the first is `offset`. `value` gives its signal in a frame; `steer`
    /// fills in what its program says of x, y, z or its width in a row of frames from a first one.
    #[inline(always)]
    pub fn travel<R: Real>(
        &mut self,
        number: usize,
        voice: &Lane,
        (mover, bus, offset): (&mut Mover, &mut Bus<'_, R>, usize),
        frames: Range<u64>,
        value: impl Fn(usize) -> R,
        steer: impl Fn(usize, usize, &mut [f64]),
    ) {
        let Self { routes, gauges, pitch, steers, law, width, rate, list } = self;
        let Some(journey) = list.get_mut(number) else { return };
        let needs = Needs::new(gauges, voice.play.strength(), *pitch);
        let route = if let Spot::Path(path) = journey.from { routes.get(path as usize) } else { None };
        let way = Way {
            route,
            still: if let Spot::Point(point) = journey.from { point } else { [0.0; 3] },
            steered: steers.is_some(),
            born: voice.born,
            pace: route.map_or(0.0, |route| route.pace(voice.play.duration) / *rate),
        };
        if way.route.is_none() && !way.steered {
            return;
        }
        mover.forget();
        // Where on its path it was found last.
        let near = Cell::new(0);
        let count = (frames.end - frames.start) as usize;
        for first in (0..count).step_by(Mover::STRETCH) {
            let (clock, samples) = (frames.start + first as u64, (count - first).min(Mover::STRETCH));
            let mut values = [R::ZERO; Mover::STRETCH];
            (0..samples).for_each(|k| values[k] = value(first + k));
            let mut widths = [*width; Mover::STRETCH];
            let mut piece = near.get();
            let beside = way.route.map(|route| (&route.path, way.age(clock), way.pace));
            let steps = if way.steered {
                steer(3, first, &mut widths[..samples]);
                widths.iter_mut().take(samples).for_each(|wider| *wider = (*width + *wider).max(0.0));
                let steps = journey.trail.take(samples, |axis, to| steer(axis, first, to));
                mover.follow(&steps, (way.still, beside), &mut piece);
                Some(steps)
            } else {
                if let Some((path, age, pace)) = beside {
                    mover.take(path, age, pace, &mut piece);
                }
                None
            };
            near.set(piece);
            let row = offset + first;
            let narrow = widths.iter().take(samples).all(|width| *width == 0.0);
            let even = widths.iter().take(samples).all(|width| *width == widths[0]);
            if even && mover.rests(samples) {
                if values.iter().take(samples).all(|value| *value == R::ZERO) {
                    continue;
                }
                let at = |whole, share| way.at(clock, (0, whole, share), steps.as_ref(), &near);
                mover.gains(at, None, (widths[0], *law), &mut journey.piece, |channel, gain| {
                    let gain = R::of(needs.of(channel, gain) * journey.gain);
                    let (rows, lane) = bus.run(channel as usize, row, samples);
                    for (row, value) in rows.iter_mut().zip(&values) {
                        row[lane] += *value * gain;
                    }
                });
                continue;
            }
            let mut held_here = if narrow { mover.held(*law, journey.piece) } else { 0 };
            let mut k = 0;
            while k < samples {
                let run = ((!(u64::from(held_here) >> k)).trailing_zeros() as usize).min(samples - k);
                if run > 0 {
                    for (channel, hangs, shares) in mover.glide(k..k + run, *law, journey.piece) {
                        let mut added = [R::ZERO; Mover::STRETCH];
                        for ((added, share), value) in added.iter_mut().zip(shares).zip(&values[k..]) {
                            *added = *value * R::of(needs.of(channel, hangs * share) * journey.gain);
                        }
                        let (rows, lane) = bus.run(channel as usize, row + k, run);
                        for (row, added) in rows.iter_mut().zip(&added) {
                            row[lane] += *added;
                        }
                    }
                    k += run;
                    continue;
                }
                let value = values[k];
                if value != R::ZERO {
                    let piece = journey.piece;
                    let at = |whole, share| way.at(clock, (k, whole, share), steps.as_ref(), &near);
                    mover.gains(
                        at,
                        Some(clock + k as u64),
                        (widths[k], *law),
                        &mut journey.piece,
                        |channel, gain| {
                            let gain = R::of(needs.of(channel, gain) * journey.gain);
                            bus.add(channel as usize, row + k, value * gain);
                        },
                    );
                    if piece != journey.piece && narrow {
                        held_here = mover.held(*law, journey.piece);
                    }
                }
                k += 1;
            }
        }
    }
}

/// Where a voice goes.
struct Way<'a> {
    route: Option<&'a Route>,
    /// Where it is otherwise.
    still: Point,
    /// Whether a trail is added to that.
    steered: bool,
    born: Instant,
    /// Seconds of the path for a sample.
    pace: f64,
}

impl Way<'_> {
    /// Where it is at a sample and a share of the next after it, of a path found on a piece shortly before; and without what its program adds.
    #[inline(always)]
    fn known(&self, clock: u64, share: f64, piece: &mut usize) -> Point {
        let Some(route) = self.route else { return self.still };
        let age = self.born.until(clock) - LEAD + share;
        route.path.follow(age * self.pace, piece)
    }

    /// How old it is at a sample.
    #[inline(always)]
    fn age(&self, clock: u64) -> Age {
        let (samples, less) = self.born.apart(clock);
        Age { samples, less: [less, LEAD] }
    }

    /// Where it is some whole samples and a share of one from one sample of a stretch that begins at `clock`.
    #[inline(always)]
    fn at(
        &self,
        clock: u64,
        (sample, whole, share): (usize, i64, f64),
        steps: Option<&Steps>,
        piece: &Cell<usize>,
    ) -> Point {
        let mut near = piece.get();
        let begin = self.known(clock.wrapping_add_signed(sample as i64 + whole), share, &mut near);
        piece.set(near);
        steps.map_or(begin, |steps| plus(begin, steps.at(sample, whole, share)))
    }
}

fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
