//! Eight channels of the stage: their state, and their way through a block.

use super::design::{Design, MAX_TAPS, SECTIONS};
use super::limiter::{LAGS, LAGS_FAST, Limiter};
use super::loops::{Cascade, LARGEST, SILENCE, copy, filter, survey, up_sample};
use super::{Counts, GRID, Row};
use crate::dsp::biquad::Biquad;
use crate::dsp::isa::Isa;
use crate::dsp::lanes::LANES;

/// State below this is flushed to zero; what it could still add to the output is below -130 dB.
const FLUSH: f32 = 1e-6;
/// Samples a block is cut into, at most.
const CHUNK: usize = GRID as usize;

/// Where a group's channels lie in a device frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub channels: usize,
    pub first: usize,
}

/// An equaliser's section on eight lanes.
#[derive(Debug)]
struct Bell {
    b: [Row; 3],
    a: [Row; 2],
    state: [Row; 2],
}

/// Room that the groups use in turn.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Scratch {
    /// The band limit's output, past and present.
    line: [Row; MAX_TAPS - 1 + CHUNK],
    /// Device frames of eight channels, for a group that has fewer.
    frames: Vec<f32>,
}

impl Scratch {
    /// For a stage of `channels` whose engine samples make `ratio` frames.
    pub fn new(channels: usize, ratio: usize) -> Self {
        let padded = if channels.is_multiple_of(LANES) { 0 } else { CHUNK * ratio * LANES };
        Self { line: [SILENCE; MAX_TAPS - 1 + CHUNK], frames: vec![0.0; padded] }
    }
}

/// Eight channels.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Group {
    lanes: usize,
    bells: Vec<Bell>,
    state: Cascade,
    /// Samples of the band limit's output that the up-sampling still needs, oldest first.
    past: [Row; MAX_TAPS - 1],
    limiter: Limiter,
    /// Lanes with no input since the last grid point.
    quiet: [bool; LANES],
    asleep: bool,
    pub peak: Row,
    pub counts: Counts,
}

impl Group {
    pub fn new<'a>(lanes: usize, equaliser: impl Fn(usize) -> &'a [Biquad]) -> Self {
        let deepest = (0..lanes).map(|l| equaliser(l).len()).max().unwrap_or(0);
        let bells = (0..deepest)
            .map(|i| {
                let section = |l: usize| match l < lanes {
                    true => equaliser(l).get(i).copied().unwrap_or(Biquad::THROUGH),
                    false => Biquad::THROUGH,
                };
                Bell {
                    b: std::array::from_fn(|k| std::array::from_fn(|l| section(l).b[k] as f32)),
                    a: std::array::from_fn(|k| std::array::from_fn(|l| section(l).a[k] as f32)),
                    state: [SILENCE; 2],
                }
            })
            .collect();
        Self {
            lanes,
            bells,
            state: [[SILENCE; 2]; SECTIONS],
            past: [SILENCE; MAX_TAPS - 1],
            limiter: Limiter::REST,
            quiet: [true; LANES],
            asleep: true,
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

    /// Renders a block into this group's channels of `out`.
    #[expect(clippy::too_many_arguments, reason = "the stage's own arguments, handed on")]
    pub fn process(
        &mut self,
        design: &Design,
        isa: Isa,
        rows: &mut [Row],
        fed: bool,
        clock: u64,
        out: &mut [f32],
        place: Place,
        scratch: &mut Scratch,
    ) {
        let step = design.fir.ratio * place.channels;
        if self.asleep && !fed {
            self.silence(out, place);
            return;
        }
        if !fed {
            rows.fill(SILENCE);
        }
        let mut done = 0;
        while done < rows.len() {
            let now = clock.wrapping_add(done as u64);
            let count = ((GRID - now % GRID) as usize).min(rows.len() - done);
            let ends_on_grid = (now % GRID) as usize + count == CHUNK;
            let chunk = &mut rows[done..done + count];
            let frames = &mut out[done * step..(done + count) * step];
            match isa {
                Isa::Baseline => self.chunk(design, chunk, frames, place, scratch),
                #[cfg(target_arch = "x86_64")]
                // SAFETY: `Vibration::new` keeps this level only where the machine has AVX2.
                Isa::Avx2 => unsafe { self.chunk_avx2(design, chunk, frames, place, scratch) },
                #[cfg(not(target_arch = "x86_64"))]
                Isa::Avx2 => self.chunk(design, chunk, frames, place, scratch),
            }
            if ends_on_grid {
                self.settle(design.fir.taps);
            }
            done += count;
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn chunk_avx2(
        &mut self,
        design: &Design,
        rows: &mut [Row],
        out: &mut [f32],
        place: Place,
        scratch: &mut Scratch,
    ) {
        self.chunk(design, rows, out, place, scratch);
    }

    /// At most [`CHUNK`] samples that end at a grid point or before.
    #[inline(always)]
    fn chunk(
        &mut self,
        design: &Design,
        rows: &mut [Row],
        out: &mut [f32],
        place: Place,
        scratch: &mut Scratch,
    ) {
        let (mut peaks, wild) = survey(rows);
        let (mut rows, mut out) = (rows, out);
        if self.asleep {
            let silent = peaks == SILENCE && !wild;
            let first = if silent { None } else { rows.iter().position(|row| *row != SILENCE) };
            let first = first.unwrap_or(rows.len());
            let (before, after) = out.split_at_mut(first * design.fir.ratio * place.channels);
            self.silence(before, place);
            (rows, out) = (&mut rows[first..], after);
            if rows.is_empty() {
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
        if !self.bells.is_empty() {
            for bell in &mut self.bells {
                bell.run(rows);
            }
            peaks = survey(rows).0;
        }
        let Scratch { line, frames } = scratch;
        line[..MAX_TAPS - 1].copy_from_slice(&self.past);
        if self.lanes == LANES {
            self.render(design, rows, peaks, line, out, place);
        } else {
            // The loops always write eight channels; these go by way of a frame that has them.
            let frames = &mut frames[..rows.len() * design.fir.ratio * LANES];
            self.render(design, rows, peaks, line, frames, Place { channels: LANES, first: 0 });
            for (to, from) in out.chunks_exact_mut(place.channels).zip(frames.chunks_exact(LANES)) {
                to[place.first..][..self.lanes].copy_from_slice(&from[..self.lanes]);
            }
        }
        self.past.copy_from_slice(&line[rows.len()..][..MAX_TAPS - 1]);
    }

    /// Limits, filters and up-samples `rows` into eight channels of `out`.
    #[inline(always)]
    fn render(
        &mut self,
        design: &Design,
        rows: &[Row],
        peaks: Row,
        line: &mut [Row; MAX_TAPS - 1 + CHUNK],
        out: &mut [f32],
        place: Place,
    ) {
        let predicted = match &design.limits {
            Some(limits) => self.limiter.is_engaged() || limits.engage(&peaks),
            None => false,
        };
        let line = &mut line[MAX_TAPS - design.fir.taps..MAX_TAPS - 1 + rows.len()];
        let recent = &mut line[design.fir.taps - 1..];
        if predicted {
            self.limit(design, rows, peaks, recent);
        } else {
            filter(&design.sections, &mut self.state, rows, recent);
        }
        let peak = match design.fir.taps {
            1 => copy(design, line, out, place),
            4 => up_sample::<4>(design, line, out, place),
            5 => up_sample::<5>(design, line, out, place),
            6 => up_sample::<6>(design, line, out, place),
            7 => up_sample::<7>(design, line, out, place),
            8 => up_sample::<8>(design, line, out, place),
            9 => up_sample::<9>(design, line, out, place),
            10 => up_sample::<10>(design, line, out, place),
            11 => up_sample::<11>(design, line, out, place),
            _ => up_sample::<12>(design, line, out, place),
        };
        for (held, peak) in self.peak.iter_mut().zip(peak) {
            *held = held.max(peak);
        }
        if peak.iter().any(|&p| p > 1.0) {
            self.clamp(out, place);
        }
    }

    /// Passes `rows` through limiter and band limit into `line`.
    #[inline(always)]
    fn limit(&mut self, design: &Design, rows: &[Row], peaks: Row, line: &mut [Row]) {
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
            let state = &mut self.state;
            if !self.limiter.is_engaged() {
                filter(sections, state, block, to);
            } else if limits.lags == LAGS {
                self.counts.limited += self.limiter.run::<{ LAGS + 1 }>(limits, sections, state, block, to);
            } else {
                self.counts.limited +=
                    self.limiter.run::<{ LAGS_FAST + 1 }>(limits, sections, state, block, to);
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
    fn clamp(&mut self, out: &mut [f32], place: Place) {
        for frame in out.chunks_exact_mut(place.channels) {
            for value in &mut frame[place.first..place.first + LANES] {
                if value.abs() > 1.0 {
                    *value = value.clamp(-1.0, 1.0);
                    self.counts.clamped += 1;
                }
            }
        }
    }

    fn silence(&self, out: &mut [f32], place: Place) {
        for frame in out.chunks_exact_mut(place.channels) {
            frame[place.first..place.first + self.lanes].fill(0.0);
        }
    }

    /// At a grid point: flushes lanes that had no input since the last one and have died away; sleeps when all have.
    fn settle(&mut self, taps: usize) {
        self.limiter.settle();
        if self.asleep {
            return;
        }
        let mut silent = true;
        for l in 0..LANES {
            let past = &mut self.past[MAX_TAPS - taps..];
            let bells = self.bells.iter().flat_map(|bell| &bell.state);
            let dead = self.quiet[l]
                && self
                    .state
                    .iter()
                    .flatten()
                    .chain(past.iter())
                    .chain(bells)
                    .all(|row| row[l].abs() < FLUSH);
            if dead {
                let bells = self.bells.iter_mut().flat_map(|bell| &mut bell.state);
                for row in self.state.iter_mut().flatten().chain(&mut self.past).chain(bells) {
                    row[l] = 0.0;
                }
                self.limiter.rest(l);
            }
            silent &= dead;
            self.quiet[l] = true;
        }
        self.asleep = silent;
    }
}

impl Bell {
    #[inline(always)]
    fn run(&mut self, rows: &mut [Row]) {
        let [mut first, mut second] = self.state;
        for row in rows {
            for l in 0..LANES {
                let x = row[l];
                let y = self.b[0][l] * x + first[l];
                first[l] = self.b[1][l] * x - self.a[0][l] * y + second[l];
                second[l] = self.b[2][l] * x - self.a[1][l] * y;
                row[l] = y;
            }
        }
        self.state = [first, second];
    }
}
