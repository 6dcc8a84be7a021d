//! Eight channels of the stage: their state, and their way through a block.

use super::ceiling::Ceiling;
use super::design::{Design, MAX_TAPS, SECTIONS};
use super::limiter::{LAGS, LAGS_FAST, Limiter};
use super::loops::{Cascade, LARGEST, SILENCE, copy, filter, survey, up_sample};
use super::shape::{Bell, Block, copy_lane, swap_lane};
use super::{Counts, GRID, Row};
use crate::dsp::biquad::Biquad;
use crate::dsp::isa::Isa;
use crate::dsp::lanes::LANES;

/// State below this is flushed to zero; what it could still add to the output is below -130 dB.
const FLUSH: f32 = 1e-6;
/// Samples a block is cut into, at most.
const CHUNK: usize = GRID as usize;
/// Samples for which it is known at the least what was played: a half-wave of 16 Hz.
const WHILE: u64 = 4 * GRID;

/// Where a group's channels lie in a device frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub channels: usize,
    pub first: usize,
}

/// Where a group writes: whole engine samples, and one more where there is a rest.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub out: &'a mut [f32],
    pub rest: &'a mut [f32],
    pub place: Place,
}

impl<'a> Target<'a> {
    /// The part of the first so many values, and the part of the others.
    #[inline(always)]
    fn split(self, values: usize) -> (Target<'a>, Target<'a>) {
        let Self { out, rest, place } = self;
        if values <= out.len() {
            let (now, later) = out.split_at_mut(values);
            (Target { out: now, rest: &mut [], place }, Target { out: later, rest, place })
        } else {
            (Target { out, rest, place }, Target { out: &mut [], rest: &mut [], place })
        }
    }

    /// All frames.
    #[inline(always)]
    pub fn frames(&mut self) -> impl Iterator<Item = &mut [f32]> {
        let channels = self.place.channels;
        self.out.chunks_exact_mut(channels).chain(self.rest.chunks_exact_mut(channels))
    }
}

/// Room that the groups use in turn.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Scratch {
    /// The band limit's output, past and present.
    line: [Row; MAX_TAPS - 1 + CHUNK],
    /// What the limiter needs at the least, where a level comes down.
    needs: [Row; CHUNK],
    /// Device frames of eight channels, for a group that has fewer.
    frames: Vec<f32>,
}

impl Scratch {
    /// For a stage of `channels` whose engine samples make `ratio` frames.
    pub fn new(channels: usize, ratio: usize) -> Self {
        let padded = if channels.is_multiple_of(LANES) { 0 } else { CHUNK * ratio * LANES };
        Self { line: [SILENCE; MAX_TAPS - 1 + CHUNK], needs: [SILENCE; CHUNK], frames: vec![0.0; padded] }
    }
}

/// What is done to a channel besides limiting it to the band.
#[derive(Debug, Clone, Copy)]
pub(super) struct Channel<'a> {
    pub equaliser: &'a [Biquad],
    pub keeps_dc_off: bool,
    /// The most that leaves it, of full scale.
    pub level: f32,
}

impl Channel<'_> {
    const PLAIN: Self = Self { equaliser: &[], keeps_dc_off: false, level: 1.0 };
}

/// Eight channels.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Group {
    lanes: usize,
    block: Option<Block>,
    bells: Vec<Bell>,
    ceiling: Option<Ceiling>,
    state: Cascade,
    /// Samples of the band limit's output that the up-sampling still needs, oldest first.
    past: [Row; MAX_TAPS - 1],
    limiter: Limiter,
    /// Lanes with no input since the last grid point.
    quiet: [bool; LANES],
    asleep: bool,
    /// The largest magnitudes of a while, by the clock, and of that before; 0 while it sleeps.
    lately: [Row; 2],
    pub peak: Row,
    pub counts: Counts,
}

impl Group {
    pub fn new<'a>(design: &Design, lanes: usize, channel: impl Fn(usize) -> Channel<'a>) -> Self {
        let channel = |l: usize| if l < lanes { channel(l) } else { Channel::PLAIN };
        let deepest = (0..lanes).map(|l| channel(l).equaliser.len()).max().unwrap_or(0);
        let section = |l: usize, i: usize| channel(l).equaliser.get(i).copied();
        let bells = (0..deepest).map(|i| Bell::new(|l| section(l, i).unwrap_or(Biquad::THROUGH))).collect();
        Self {
            lanes,
            block: Block::new(design.blocker, |l| channel(l).keeps_dc_off),
            bells,
            ceiling: Ceiling::new(std::array::from_fn(|l| channel(l).level)),
            state: [[SILENCE; 2]; SECTIONS],
            past: [SILENCE; MAX_TAPS - 1],
            limiter: Limiter::REST,
            quiet: [true; LANES],
            asleep: true,
            lately: [SILENCE; 2],
            peak: SILENCE,
            counts: Counts::default(),
        }
    }

    pub fn sleeps(&self) -> bool {
        self.asleep
    }

    pub fn gain(&self, lane: usize) -> f32 {
        self.limiter.gain[lane]
    }

    /// Lets no more leave the lanes than this, from now on, or in a while where something sounds.
    pub fn limit_to(&mut self, levels: Row) {
        Ceiling::go(&mut self.ceiling, levels, !self.asleep);
        self.prepare();
    }

    /// Takes over from an old group: lanes that are kept go on as they were there. The others go on from the same state of what is the same for all
    /// lanes, and of the mean of what is played. Levels are this group's own.
    pub fn take_over(&mut self, old: &mut Self, kept: [bool; LANES]) {
        Ceiling::follow(&mut self.ceiling, &old.ceiling, |l| kept[l]);
        if let (Some(block), Some(old)) = (&mut self.block, &old.block) {
            (0..LANES).filter(|l| !kept[*l]).for_each(|lane| block.follow(old, lane));
        }
        for lane in 0..LANES {
            if !kept[lane] {
                copy_lane(self.state.as_flattened_mut(), old.state.as_flattened(), lane);
                copy_lane(&mut self.past, &old.past, lane);
                self.limiter.copy(&old.limiter, lane);
                continue;
            }
            if let (Some(block), Some(old)) = (&mut self.block, &mut old.block) {
                block.swap(old, lane);
            }
            // Where one of both has more sections, nothing passes through those in this lane.
            self.bells.iter_mut().zip(&mut old.bells).for_each(|(bell, old)| bell.swap(old, lane));
            swap_lane(self.state.as_flattened_mut(), old.state.as_flattened_mut(), lane);
            swap_lane(&mut self.past, &mut old.past, lane);
            swap_lane([&mut self.peak], [&mut old.peak], lane);
            swap_lane(&mut self.lately, &mut old.lately, lane);
            self.limiter.swap(&mut old.limiter, lane);
            std::mem::swap(&mut self.quiet[lane], &mut old.quiet[lane]);
        }
        self.asleep = old.asleep;
        self.prepare();
    }

    /// What sounds is known to a level that begins to come down.
    fn prepare(&mut self) {
        let lately = std::array::from_fn(|l| self.lately[0][l].max(self.lately[1][l]));
        Ceiling::prepare(&mut self.ceiling, &lately, &self.limiter.need);
    }

    /// Renders a block into this group's channels of `out`.
    #[expect(clippy::too_many_arguments, reason = "the stage's own arguments, handed on")]
    #[inline]
    pub fn process(
        &mut self,
        design: &Design,
        isa: Isa,
        rows: &mut [Row],
        fed: bool,
        clock: u64,
        mut target: Target<'_>,
        scratch: &mut Scratch,
    ) {
        let step = design.fir.ratio * target.place.channels;
        if self.asleep && !fed {
            self.silence(&mut target);
            return;
        }
        if !fed {
            rows.fill(SILENCE);
        }
        let mut done = 0;
        while done < rows.len() {
            let now = clock.wrapping_add(done as u64) % GRID;
            let count = ((GRID - now) as usize).min(rows.len() - done);
            let glides = self.ceiling.as_ref().and_then(Ceiling::glides);
            let count = glides.map_or(count, |left| count.min(left as usize));
            let ends_on_grid = now as usize + count == CHUNK;
            let chunk = &mut rows[done..done + count];
            let (frames, later) = target.split(count * step);
            target = later;
            match isa {
                Isa::Baseline => self.chunk_baseline(design, chunk, frames, scratch),
                #[cfg(target_arch = "x86_64")]
                // SAFETY: `Vibration::new` keeps this level only where the machine has AVX2.
                Isa::Avx2 => unsafe { self.chunk_avx2(design, chunk, frames, scratch) },
                #[cfg(not(target_arch = "x86_64"))]
                Isa::Avx2 => self.chunk_baseline(design, chunk, frames, scratch),
            }
            if self.ceiling.as_ref().is_some_and(|c| glides.is_some() && c.glides().is_none()) {
                Ceiling::settle(&mut self.ceiling);
            }
            if ends_on_grid && clock.wrapping_add((done + count) as u64).is_multiple_of(WHILE) {
                self.lately = [SILENCE, self.lately[0]];
            }
            if ends_on_grid {
                self.settle(design.fir.taps);
            }
            done += count;
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn chunk_avx2(&mut self, design: &Design, rows: &mut [Row], target: Target<'_>, scratch: &mut Scratch) {
        self.chunk(design, rows, target, scratch);
    }

    #[inline(never)]
    fn chunk_baseline(
        &mut self,
        design: &Design,
        rows: &mut [Row],
        target: Target<'_>,
        scratch: &mut Scratch,
    ) {
        self.chunk(design, rows, target, scratch);
    }

    /// At most [`CHUNK`] samples that end at a grid point or before.
    #[inline(always)]
    fn chunk(&mut self, design: &Design, rows: &mut [Row], target: Target<'_>, scratch: &mut Scratch) {
        let (mut peaks, wild) = survey(rows);
        let (mut rows, mut target) = (rows, target);
        if self.asleep {
            let silent = peaks == SILENCE && !wild;
            let first = if silent { None } else { rows.iter().position(|row| *row != SILENCE) };
            let first = first.unwrap_or(rows.len());
            let values = first * design.fir.ratio * target.place.channels;
            let (mut before, after) = target.split(values);
            self.silence(&mut before);
            (rows, target) = (&mut rows[first..], after);
            if rows.is_empty() {
                self.silence(&mut target);
                return;
            }
            self.asleep = false;
        }
        if wild {
            self.mend(rows);
            peaks = survey(rows).0;
        }
        for (quiet, peak) in self.quiet.iter_mut().zip(peaks) {
            *quiet &= peak == 0.0;
        }
        if self.block.is_some() || !self.bells.is_empty() || self.ceiling.is_some() {
            if let Some(block) = &mut self.block {
                block.run(rows);
            }
            for bell in &mut self.bells {
                bell.run(rows);
            }
            if let Some(ceiling) = &self.ceiling {
                ceiling.lift(rows);
            }
            peaks = survey(rows).0;
        }
        let Scratch { line, frames, needs } = scratch;
        let predicted = match &design.limits {
            Some(limits) => self.limiter.is_engaged() || limits.engage(&peaks),
            None => false,
        };
        let recent = &mut line[MAX_TAPS - 1..][..rows.len()];
        let least = match (&self.ceiling, &design.limits) {
            (Some(ceiling), Some(limits)) => ceiling.foresee(limits.level, &mut needs[..rows.len()]),
            _ => &[],
        };
        if predicted {
            self.limit(design, rows, least, peaks, recent);
        } else {
            filter(&design.sections, &mut self.state, rows, recent);
        }
        if let Some(ceiling) = &mut self.ceiling {
            ceiling.lower(recent);
        }
        let line = &mut line[..MAX_TAPS - 1 + rows.len()];
        if self.lanes == LANES {
            self.spread(design, line, &mut target);
        } else {
            // The loops always write eight channels; these go by way of a frame that has them.
            let out = &mut frames[..rows.len() * design.fir.ratio * LANES];
            let place = Place { channels: LANES, first: 0 };
            self.spread(design, line, &mut Target { out, rest: &mut [], place });
            let (first, lanes) = (target.place.first, self.lanes);
            for (to, from) in target.frames().zip(frames.chunks_exact(LANES)) {
                to[first..][..lanes].copy_from_slice(&from[..lanes]);
            }
        }
    }

    /// Up-samples `line`, in front of which there is room for the past, into eight channels of the target.
    #[inline(always)]
    fn spread(&mut self, design: &Design, line: &mut [Row], target: &mut Target<'_>) {
        let past = &mut self.past;
        let peak = match (design.fir.taps, design.fir.ratio) {
            (1, _) => copy(design, line, target),
            (6, 6) => up_sample::<6, 3>(design, line, past, target),
            (4, _) => up_sample::<4, 0>(design, line, past, target),
            (5, _) => up_sample::<5, 0>(design, line, past, target),
            (6, _) => up_sample::<6, 0>(design, line, past, target),
            (7, _) => up_sample::<7, 0>(design, line, past, target),
            (8, _) => up_sample::<8, 0>(design, line, past, target),
            (9, _) => up_sample::<9, 0>(design, line, past, target),
            (10, _) => up_sample::<10, 0>(design, line, past, target),
            (11, _) => up_sample::<11, 0>(design, line, past, target),
            _ => up_sample::<12, 0>(design, line, past, target),
        };
        for (held, peak) in self.lately[0].iter_mut().zip(peak) {
            *held = if *held > peak { *held } else { peak };
        }
        let most = self.ceiling.as_ref().map_or([1.0; LANES], |ceiling| *ceiling.most());
        let mut over = false;
        for ((held, peak), most) in self.peak.iter_mut().zip(peak).zip(most) {
            *held = if *held > peak { *held } else { peak };
            over |= peak > most;
        }
        if over {
            self.clamp(target, &most);
        }
    }

    /// Passes `rows` through limiter and band limit into `line`.
    #[inline(always)]
    fn limit(&mut self, design: &Design, rows: &[Row], least: &[Row], peaks: Row, line: &mut [Row]) {
        let sections = &design.sections;
        let Some(limits) = &design.limits else { return };
        let mut done = 0;
        while done < rows.len() {
            let engaging = self.limiter.listen(limits, &rows[done..], &peaks);
            if engaging == Some(0) {
                self.limiter.engage(limits, &rows[done], &self.state);
            }
            // The row that engaged a lane goes with those behind it, up to the next that does.
            let next = match engaging {
                Some(0) => self.limiter.listen(limits, &rows[done..], &peaks),
                other => other,
            };
            let count = next.unwrap_or(rows.len() - done);
            let (block, to) = (&rows[done..done + count], &mut line[done..done + count]);
            let (state, least) = (&mut self.state, least.get(done..done + count).unwrap_or_default());
            if !self.limiter.is_engaged() {
                filter(sections, state, block, to);
            } else if limits.lags == LAGS {
                self.counts.limited +=
                    self.limiter.run::<{ LAGS + 1 }>(limits, sections, state, block, least, to);
            } else {
                self.counts.limited +=
                    self.limiter.run::<{ LAGS_FAST + 1 }>(limits, sections, state, block, least, to);
            }
            done += count;
        }
    }

    #[cold]
    fn mend(&mut self, rows: &mut [Row]) {
        for value in rows.iter_mut().flat_map(|row| &mut row[..self.lanes]) {
            if !value.is_finite() {
                *value = 0.0;
                self.counts.masked += 1;
            } else if value.abs() > LARGEST {
                *value = LARGEST.copysign(*value);
                self.counts.held += 1;
            }
        }
        for value in rows.iter_mut().flat_map(|row| &mut row[self.lanes..]) {
            *value = 0.0;
        }
    }

    #[cold]
    fn clamp(&mut self, target: &mut Target<'_>, most: &Row) {
        let first = target.place.first;
        for frame in target.frames() {
            for (value, most) in frame[first..first + LANES].iter_mut().zip(most) {
                if value.abs() > *most {
                    *value = most.copysign(*value);
                    self.counts.clamped += 1;
                }
            }
        }
    }

    fn silence(&self, target: &mut Target<'_>) {
        let (first, lanes) = (target.place.first, self.lanes);
        for frame in target.frames() {
            // Eight at a time without a call for each frame.
            match frame[first..first + lanes].first_chunk_mut::<LANES>() {
                Some(row) => *row = SILENCE,
                None => frame[first..first + lanes].fill(0.0),
            }
        }
    }

    /// At a grid point: flushes lanes that had no input since the last one and have died away; sleeps when all have.
    fn settle(&mut self, taps: usize) {
        self.limiter.settle();
        if self.asleep {
            return;
        }
        if !self.quiet[..self.lanes].contains(&true) {
            self.quiet = [true; LANES];
            return;
        }
        let mut silent = true;
        for l in 0..LANES {
            let past = &self.past[..taps - 1];
            let dead = self.quiet[l]
                && self.state.iter().flatten().chain(past.iter()).all(|row| row[l].abs() < FLUSH)
                && self.bells.iter().all(|bell| bell.is_dead(l, FLUSH))
                && self.block.as_ref().is_none_or(|block| block.is_dead(l, FLUSH));
            if dead {
                for row in self.state.iter_mut().flatten().chain(&mut self.past) {
                    row[l] = 0.0;
                }
                self.bells.iter_mut().for_each(|bell| bell.rest(l));
                self.block.iter_mut().for_each(|block| block.rest(l));
                self.limiter.rest(l);
            }
            silent &= dead;
            self.quiet[l] = true;
        }
        self.asleep = silent;
        if silent {
            self.lately = [SILENCE; 2];
            Ceiling::settle(&mut self.ceiling);
        }
    }
}
