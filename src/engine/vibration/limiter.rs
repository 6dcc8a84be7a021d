//! A limiter that knows the filter behind it.
//!
//! It scales the band limit's *input*, so that no gain step comes after the band limit, and needs no look-ahead: the
//! band limit itself delays a sample by about nine, so what a sample will do to the output is known before it is heard.
//! `ahead[k]` is the output k samples on if nothing more came in. A new sample u adds h[k] u to it.
//!
//! **The gain.** A second copy of the band limit, with its own predictions, hears the input as it is. The largest of these
//! predictions, or the input itself where that is larger by up to [`EAGER`], is what the channel needs; held for [`HOLD`], then
//! falling with time constant [`RELEASE`]. The gain is what brings it down to [`AIM`] of the ceiling, and 1 if it is below. So a
//! steady tone meets a steady gain, from its second period on, and comes out as the tone that it is.
//!
//! **The guarantee.** What begins so steeply that this comes too late, and the ceiling would be passed, is turned down further for
//! that sample, to the largest share that keeps every prediction within the ceiling. The share 0 always does, for the predictions
//! have kept to it before: so the ceiling holds by induction whatever comes, an input that stops dead included. The gain then falls
//! by up to [`STEP`], so that it comes once and not in every period.
//!
//! That guarantee has a price: when a sine above 500 Hz stops dead, the band limit rings on above the sine's own
//! amplitude, so such a sine is held to where its ringing keeps to the ceiling (0.88 at 600 Hz, 0.71 at 800 Hz).
//!
//! All predictions cost much, so the later ones are made only while a lane's first ones, or the last look at all of them,
//! were not far below the ceiling.
//!
//! A channel whose input stays below [`Limits::threshold`] cannot reach the ceiling (threshold times the L1 norm of h
//! is below it) and is not predicted at all.
//!
//! All values are in units of the band limit's sections, before its gain.
#![allow(clippy::needless_range_loop, reason = "several rows run under one lane index")]

use super::Row;
use super::design::SECTIONS;
use super::loops::{Cascade, SILENCE, Sections, cascade};
use super::shape::{copy_lane, swap_lane};
use crate::dsp::elliptic::Elliptic;
use crate::dsp::lanes::LANES;

/// Predictions, samples ahead, that are made at every sample, up to 8.2 kHz and above that.
pub(super) const LAGS: usize = 12;
pub(super) const LAGS_FAST: usize = 18;
/// The same for lanes that may come near the ceiling. With fewer, an output that keeps to the ceiling as far as is looked may
/// pass it behind that, and nothing helps any more (a linear programme over all inputs: by 20 % with 12, not at all with 26).
const FAR: usize = 26;
const FAR_FAST: usize = 28;
const MAX_LAGS: usize = FAR_FAST + 1;
/// Share of the ceiling up to which the first predictions leave no room for later ones to pass it.
const NEAR: f64 = 0.75;
/// Highest predicted engine sample, of full scale, at 6 and from 8 kHz; the device's samples lie up to 7 and 5 % above the engine's.
const CEILING: [f64; 2] = [0.93, 0.952];
/// Share of the ceiling to which the gain brings what is louder.
const AIM: f64 = 0.99;
/// How much larger than the predictions the input may count: a slow crest is seen in the input a few samples before it is
/// foreseen. More than this would turn down clicks that the band limit makes smaller anyway. Times [`NEAR`] it is below [`AIM`].
const EAGER: f64 = 1.04;
/// Most by which the gain falls at a sample that nothing foresaw.
const STEP: f32 = 1.05;
/// How long a need is held: a period of 17 Hz, seconds.
const HOLD: f64 = 0.06;
/// A need that comes back to this share renews the one that is held: crests fall between samples.
const AGAIN: f32 = 0.95;
/// Time constant with which a need is forgotten after that, seconds.
const RELEASE: f64 = 0.08;
/// Grid periods of quiet input after which predicting stops: old input has decayed by 70 dB or more.
const CALM: u8 = 8;

/// What the band limit tells the limiter.
#[derive(Debug)]
pub(super) struct Limits {
    pub ceiling: f32,
    /// Input magnitude that can never lead to the ceiling.
    pub threshold: f32,
    /// Where the gain brings what is louder.
    aim: f32,
    /// What a steady input of 1 becomes.
    pub level: f32,
    /// Samples for which a need is held, and what is left of it a sample afterwards.
    hold: f32,
    left: f32,
    /// Predicted magnitude beyond which later predictions are looked at.
    near: f32,
    pub lags: usize,
    far: usize,
    /// Impulse response from lag 1.
    impulse: [Row; MAX_LAGS],
    /// `free[k]` times the state is the output k + 1 samples on, without input.
    free: [[f32; 2 * SECTIONS]; MAX_LAGS],
    /// The last of them, for the loops.
    last: [Row; 2 * SECTIONS],
}

impl Limits {
    pub fn new(filter: &Elliptic) -> Self {
        let (lags, far) = if filter.rate > 8200.0 { (LAGS_FAST, FAR_FAST) } else { (LAGS, FAR) };
        let run = |state: &mut [[f64; 2]], x: f64| {
            filter.sections.iter().zip(state).fold(x, |x, (section, state)| section.step(state, x))
        };
        let mut state = [[0.0; 2]; SECTIONS];
        run(&mut state, 1.0);
        let mut impulse = [[0.0; LANES]; MAX_LAGS];
        for to in impulse.iter_mut().take(far) {
            *to = [run(&mut state, 0.0) as f32; LANES];
        }
        let mut state = [[0.0; 2]; SECTIONS];
        let norm: f64 = (0..4000).map(|n| run(&mut state, if n == 0 { 1.0 } else { 0.0 }).abs()).sum();
        let mut free = [[0.0; 2 * SECTIONS]; MAX_LAGS];
        for i in 0..2 * SECTIONS {
            let mut state = [[0.0; 2]; SECTIONS];
            // The loops hold a section's first state and the sum of both: one of the first alone is less one of the second.
            state[i / 2] = if i % 2 == 0 { [1.0, -1.0] } else { [0.0, 1.0] };
            run(&mut state, 0.0);
            for row in free.iter_mut().take(far) {
                row[i] = run(&mut state, 0.0) as f32;
            }
        }
        let share = ((filter.rate - 6000.0) / 2000.0).clamp(0.0, 1.0);
        let ceiling = (CEILING[0] + share * (CEILING[1] - CEILING[0])) / filter.gain;
        Self {
            ceiling: ceiling as f32,
            threshold: (0.98 * ceiling / norm) as f32,
            aim: (AIM * ceiling) as f32,
            level: (1.0 / filter.gain) as f32,
            hold: (HOLD * filter.rate).round() as f32,
            left: (-1.0 / (RELEASE * filter.rate)).exp() as f32,
            near: (NEAR * ceiling) as f32,
            lags,
            far,
            impulse,
            free,
            last: std::array::from_fn(|i| [free[lags - 1][i]; LANES]),
        }
    }
}

impl Limits {
    /// Whether input of these magnitudes makes a lane engage.
    #[inline(always)]
    pub fn engage(&self, peaks: &Row) -> bool {
        peaks.iter().any(|&peak| peak > self.threshold)
    }
}

/// Predictions on whole cache lines.
#[repr(align(64))]
struct Ring<const N: usize>([Row; N]);

/// The limiter's state on eight lanes.
#[derive(Debug)]
pub(super) struct Limiter {
    /// `ahead[k]`: output k samples after the next one, without input; the last one is worked out afresh each time.
    ahead: [Row; MAX_LAGS],
    /// The same, and the band limit's state, for the input as it is; kept up for lanes whose gain is not 1.
    bare: [Row; MAX_LAGS],
    bare_state: Cascade,
    pub gain: Row,
    /// What the channel needs, 0 where that is below the aim; and samples for which that is still held.
    pub need: Row,
    held: Row,
    engaged: [bool; LANES],
    /// Whether the last look at all predictions found one that was not near zero.
    far: [bool; LANES],
    loud: [bool; LANES],
    calm: [u8; LANES],
}

impl Limiter {
    pub const REST: Self = Self {
        ahead: [[0.0; LANES]; MAX_LAGS],
        bare: [[0.0; LANES]; MAX_LAGS],
        bare_state: [[[0.0; LANES]; 2]; SECTIONS],
        gain: [1.0; LANES],
        need: [0.0; LANES],
        held: [0.0; LANES],
        engaged: [false; LANES],
        far: [false; LANES],
        loud: [false; LANES],
        calm: [0; LANES],
    };

    /// Whether any lane needs predictions.
    pub fn is_engaged(&self) -> bool {
        self.engaged.contains(&true)
    }

    /// Puts `lane`, which is silent, back to where it began.
    pub fn rest(&mut self, lane: usize) {
        (self.gain[lane], self.need[lane], self.held[lane]) = (1.0, 0.0, 0.0);
        (self.engaged[lane], self.far[lane], self.calm[lane]) = (false, false, 0);
    }

    /// Takes note of the input magnitudes of the rows to come. Returns the first row at which a lane has to engage.
    #[inline(always)]
    pub fn listen(&mut self, limits: &Limits, rows: &[Row], peaks: &Row) -> Option<usize> {
        let mut news = false;
        for l in 0..LANES {
            let loud = peaks[l] > limits.threshold;
            self.loud[l] |= loud;
            news |= loud & !self.engaged[l];
        }
        if news { self.engaging(limits, rows, peaks) } else { None }
    }

    #[cold]
    fn engaging(&self, limits: &Limits, rows: &[Row], peaks: &Row) -> Option<usize> {
        let idle = (0..LANES).filter(|&l| peaks[l] > limits.threshold && !self.engaged[l]);
        idle.filter_map(|l| rows.iter().position(|row| row[l].abs() > limits.threshold)).min()
    }

    /// Engages the lanes that `row` makes engage; `state` is the band limit's before it.
    pub fn engage(&mut self, limits: &Limits, row: &Row, state: &Cascade) {
        for l in 0..LANES {
            if !self.engaged[l] && row[l].abs() > limits.threshold {
                (self.engaged[l], self.far[l], self.calm[l]) = (true, false, 0);
                for (ahead, free) in self.ahead[1..].iter_mut().zip(&limits.free).take(limits.lags) {
                    let mut sum = 0.0;
                    for (i, weight) in free.iter().enumerate() {
                        sum += weight * state[i / 2][i % 2][l];
                    }
                    ahead[l] = sum;
                }
            }
        }
    }

    /// At a grid point: lanes that have long been quiet need no predictions.
    /// What a lane holds changes places with what it holds in another.
    pub fn swap(&mut self, other: &mut Self, lane: usize) {
        swap_lane(&mut self.ahead, &mut other.ahead, lane);
        swap_lane(&mut self.bare, &mut other.bare, lane);
        swap_lane(self.bare_state.as_flattened_mut(), other.bare_state.as_flattened_mut(), lane);
        let own = [&mut self.gain, &mut self.need, &mut self.held];
        swap_lane(own, [&mut other.gain, &mut other.need, &mut other.held], lane);
        for (own, other) in [
            (&mut self.engaged, &mut other.engaged),
            (&mut self.far, &mut other.far),
            (&mut self.loud, &mut other.loud),
        ] {
            std::mem::swap(&mut own[lane], &mut other[lane]);
        }
        std::mem::swap(&mut self.calm[lane], &mut other.calm[lane]);
    }

    /// A lane becomes what it is in another.
    pub fn copy(&mut self, other: &Self, lane: usize) {
        copy_lane(&mut self.ahead, &other.ahead, lane);
        copy_lane(&mut self.bare, &other.bare, lane);
        copy_lane(self.bare_state.as_flattened_mut(), other.bare_state.as_flattened(), lane);
        let own = [&mut self.gain, &mut self.need, &mut self.held];
        copy_lane(own, [&other.gain, &other.need, &other.held], lane);
        self.engaged[lane] = other.engaged[lane];
        self.far[lane] = other.far[lane];
        self.loud[lane] = other.loud[lane];
        self.calm[lane] = other.calm[lane];
    }

    pub fn settle(&mut self) {
        for l in 0..LANES {
            let calm = !self.loud[l] && self.gain[l] == 1.0;
            self.calm[l] = if calm { self.calm[l].saturating_add(1) } else { 0 };
            self.loud[l] = false;
            if self.calm[l] >= CALM {
                self.engaged[l] = false;
            }
        }
    }

    /// Limits `rows`, of which each needs so much at the `least` (where that is empty, nothing), and passes them through the band limit into `out`. `N` is the number of lags and one. Returns how
    /// many samples were turned down.
    #[inline(always)]
    pub fn run<const N: usize>(
        &mut self,
        limits: &Limits,
        filter: &Sections,
        state: &mut Cascade,
        rows: &[Row],
        least: &[Row],
        out: &mut [Row],
    ) -> u64 {
        let mut z = *state;
        let mut limited = 0;
        // Two copies that change places, since a sample that is turned down needs the predictions before it. In `old`,
        // 1 to N - 1 are the outputs after this sample; in `new`, 0 to N - 2 are the same ones with this sample in.
        let (mut one, mut two) = (Ring([[0.0; LANES]; N]), Ring([[0.0; LANES]; N]));
        let (mut old, mut new) = (&mut one.0, &mut two.0);
        old[..N - 1].copy_from_slice(&self.ahead[..N - 1]);
        let Some(impulse) = limits.impulse.first_chunk::<N>() else { return 0 };
        // Whether a gain is not 1, so that the input as it is has predictions of its own.
        let mut active = !least.is_empty() || self.need != [0.0; LANES];
        if active {
            self.follow(&self.need.map(|need| need == 0.0), &old[..N - 1], &z);
        }
        let mut done = 0;
        while done < rows.len() {
            // As long as no gain is lowered, two samples at a time: half the traffic of predictions.
            if !active && self.far == [false; LANES] {
                let (pairs, _) = rows[done..].as_chunks::<2>();
                let mut passed = 0;
                for (x, y) in pairs.iter().zip(out[done..].chunks_exact_mut(2)) {
                    let mut after = z;
                    old[N - 1] = rest(limits, &after);
                    let first = cascade(filter, &mut after, x[0]);
                    let last = rest(limits, &after);
                    let second = cascade(filter, &mut after, x[1]);
                    let peak = predict_two(impulse, old, new, &last, x);
                    let mut high = false;
                    for size in peak {
                        high |= size > limits.near;
                    }
                    if high {
                        break;
                    }
                    (y[0], y[1], z) = (first, second, after);
                    std::mem::swap(&mut old, &mut new);
                    passed += 2;
                }
                done += passed;
            }
            let (Some(x), Some(y)) = (rows.get(done), out.get_mut(done)) else { break };
            let floor = least.get(done).unwrap_or(&SILENCE);
            done += 1;
            old[N - 1] = rest(limits, &z);
            let before = self.need;
            let mut u = *x;
            if active {
                self.weigh::<N>(limits, filter, impulse, x, floor, &mut u);
            }
            let mut peak = predict(impulse, old, new, &u);
            // Without a gain, the need is seen in the predictions that are made anyway.
            let mut seen = active;
            if !active && wanted(limits, x, &peak).iter().any(|&need| need > limits.aim) {
                self.follow(&[true; LANES], &old[..N - 1], &z);
                self.weigh::<N>(limits, filter, impulse, x, floor, &mut u);
                peak = predict(impulse, old, new, &u);
                seen = true;
            }
            let mut high = false;
            for l in 0..LANES {
                self.far[l] |= peak[l] > limits.near;
                high |= self.far[l];
            }
            if high {
                let mut free = [[0.0; LANES]; MAX_LAGS + 1];
                // What comes out now without this sample, which was foreseen, but for rounding.
                free[0] = cascade(filter, &mut z.clone(), [0.0; LANES]);
                free[1..N].copy_from_slice(&old[1..N]);
                look_far(limits, &z, &u, &mut free, &mut peak, &mut self.far);
                let mut over = false;
                for size in peak {
                    over |= size > limits.ceiling;
                }
                if over {
                    if !seen {
                        self.follow(&[true; LANES], &old[..N - 1], &z);
                        self.weigh::<N>(limits, filter, impulse, x, floor, &mut u);
                    }
                    self.turn_down(limits, &free, &peak, x, &mut u);
                    predict(impulse, old, new, &u);
                }
            }
            *y = cascade(filter, &mut z, u);
            std::mem::swap(&mut old, &mut new);
            if before != [0.0; LANES] || self.need != [0.0; LANES] {
                active = !least.is_empty();
                let (mut met, mut any) = ([false; LANES], false);
                for l in 0..LANES {
                    limited += u64::from(self.need[l] > 0.0);
                    active |= self.need[l] > 0.0;
                    met[l] = before[l] > 0.0 && self.need[l] == 0.0;
                    any |= met[l];
                }
                // With a gain of 1 again, the input is what the band limit hears.
                if any {
                    self.follow(&met, &old[..N - 1], &z);
                }
            }
        }
        self.ahead[..N - 1].copy_from_slice(&old[..N - 1]);
        *state = z;
        limited
    }

    /// For some lanes, the input as it is has these predictions and this state.
    #[inline(never)]
    fn follow(&mut self, which: &[bool; LANES], ahead: &[Row], state: &Cascade) {
        for l in 0..LANES {
            if which[l] {
                for (to, from) in self.bare.iter_mut().zip(ahead) {
                    to[l] = from[l];
                }
                for (to, from) in self.bare_state.iter_mut().flatten().zip(state.iter().flatten()) {
                    to[l] = from[l];
                }
            }
        }
    }

    /// What the channels need with the sample `x`, or at the least, the gain that follows from it, and what it makes of the sample.
    #[inline(always)]
    fn weigh<const N: usize>(
        &mut self,
        limits: &Limits,
        filter: &Sections,
        impulse: &[Row; N],
        x: &Row,
        least: &Row,
        u: &mut Row,
    ) {
        let Some(bare) = self.bare.first_chunk_mut::<N>() else { return };
        bare[N - 1] = rest(limits, &self.bare_state);
        cascade(filter, &mut self.bare_state, *x);
        let mut peak = [0.0f32; LANES];
        for k in 0..N - 1 {
            let mut sum = bare[k + 1];
            for l in 0..LANES {
                sum[l] += impulse[k][l] * x[l];
            }
            bare[k] = sum;
            peak = larger(&peak, &sum);
        }
        let mut now = wanted(limits, x, &peak);
        for l in 0..LANES {
            now[l] = now[l].max(if self.engaged[l] { least[l] } else { 0.0 });
            let before = self.need[l];
            let held = self.held[l] - 1.0;
            let faded = if held > 0.0 { before } else { before * limits.left };
            self.held[l] = if now[l] >= AGAIN * before { limits.hold } else { held };
            let need = if now[l] > faded { now[l] } else { faded };
            let idle = need <= limits.aim;
            self.need[l] = if idle { 0.0 } else { need };
            self.gain[l] = if idle { 1.0 } else { limits.aim / need };
            u[l] = self.gain[l] * x[l];
        }
    }

    /// Turns the sample `u` of lanes whose prediction `peak` passes the ceiling down, as far as it must be.
    #[inline(always)]
    fn turn_down(&mut self, limits: &Limits, before: &[Row; MAX_LAGS + 1], peak: &Row, x: &Row, u: &mut Row) {
        let ceiling = limits.ceiling;
        let mut wanted = [0.0f32; LANES];
        for l in 0..LANES {
            let over = peak[l] > ceiling;
            let known = if self.need[l] > limits.aim { self.need[l] } else { limits.aim };
            let (seen, most) = (peak[l] / self.gain[l], STEP * known);
            let need = if seen < most { seen } else { most };
            let need = if need > known { need } else { known };
            self.need[l] = if over { need } else { self.need[l] };
            self.held[l] = if over { limits.hold } else { self.held[l] };
            self.gain[l] = if over { limits.aim / need } else { self.gain[l] };
            wanted[l] = self.gain[l] * x[l];
        }
        // The least room / step, as a pair, so that one division does.
        let (mut room, mut step) = ([1.0f32; LANES], [1.0f32; LANES]);
        for k in 0..=limits.far {
            for l in 0..LANES {
                // The impulse response begins with 1.
                let add = if k == 0 { wanted[l] } else { limits.impulse[k - 1][l] * wanted[l] };
                let towards = if add < 0.0 { -before[k][l] } else { before[k][l] };
                // Rounding may have left a prediction a hair past the ceiling: then there is no room.
                let free = ceiling - towards;
                let free = if free > 0.0 { free } else { 0.0 };
                let size = add.abs();
                let tighter = free * step[l] < room[l] * size;
                room[l] = if tighter { free } else { room[l] };
                step[l] = if tighter { size } else { step[l] };
            }
        }
        for l in 0..LANES {
            let held = wanted[l] * (room[l] / step[l]);
            u[l] = if peak[l] > ceiling { held } else { u[l] };
        }
    }
}

/// Predictions with the sample `u`, from those without, which begin a sample later; and the largest magnitudes.
#[inline(always)]
fn predict<const N: usize>(impulse: &[Row; N], old: &[Row; N], new: &mut [Row; N], u: &Row) -> Row {
    let mut peak = [0.0f32; LANES];
    for k in 0..N - 1 {
        let mut sum = old[k + 1];
        for l in 0..LANES {
            sum[l] += impulse[k][l] * u[l];
        }
        new[k] = sum;
        peak = larger(&peak, &sum);
    }
    peak
}

/// The same for two samples, one after the other; `last` is the last prediction behind the first.
#[inline(always)]
fn predict_two<const N: usize>(
    impulse: &[Row; N],
    old: &[Row; N],
    new: &mut [Row; N],
    last: &Row,
    x: &[Row; 2],
) -> Row {
    let mut peak = [0.0f32; LANES];
    for l in 0..LANES {
        peak[l] = (old[1][l] + impulse[0][l] * x[0][l]).abs();
    }
    for k in 1..N - 1 {
        // Loaded and stored as rows: the compiler cannot know that both copies are apart, and would take the lanes one by one.
        let (mut sum, mut next) = (old[k + 1], SILENCE);
        for l in 0..LANES {
            sum[l] += impulse[k][l] * x[0][l];
            next[l] = sum[l] + impulse[k - 1][l] * x[1][l];
        }
        new[k - 1] = next;
        peak = larger(&larger(&peak, &sum), &next);
    }
    // The last prediction is the second sample's alone.
    let mut next = *last;
    for l in 0..LANES {
        next[l] += impulse[N - 2][l] * x[1][l];
    }
    new[N - 2] = next;
    larger(&peak, &next)
}

/// The larger of each of `peak` and the magnitude of each of `row`.
#[inline(always)]
fn larger(peak: &Row, row: &Row) -> Row {
    std::array::from_fn(|l| {
        let size = row[l].abs();
        if peak[l] > size { peak[l] } else { size }
    })
}

/// What channels need whose predictions go up to `peak` and whose input is `x`.
#[inline(always)]
fn wanted(limits: &Limits, x: &Row, peak: &Row) -> Row {
    let mut need = *peak;
    for l in 0..LANES {
        let (input, most) = (limits.level * x[l].abs(), EAGER as f32 * peak[l]);
        let eager = if input < most { input } else { most };
        need[l] = if need[l] > eager { need[l] } else { eager };
    }
    need
}

/// The last prediction, which no sample has moved yet.
#[inline(always)]
fn rest(limits: &Limits, z: &Cascade) -> Row {
    // Two sums, since one would wait for itself.
    let mut last = [[0.0; LANES]; 2];
    for i in 0..SECTIONS {
        for l in 0..LANES {
            last[0][l] += limits.last[2 * i][l] * z[i][0][l];
            last[1][l] += limits.last[2 * i + 1][l] * z[i][1][l];
        }
    }
    for l in 0..LANES {
        last[0][l] += last[1][l];
    }
    last[0]
}

/// All predictions, of which the first are in `before`, counted from this sample on; for the lanes that are `far`, their
/// largest magnitude with this sample in joins `peak`. Says whether that is still so.
#[inline(always)]
fn look_far(
    limits: &Limits,
    z: &Cascade,
    u: &Row,
    before: &mut [Row; MAX_LAGS + 1],
    peak: &mut Row,
    far: &mut [bool; LANES],
) {
    let mut most = [0.0f32; LANES];
    for l in 0..LANES {
        most[l] = (before[0][l] + u[l]).abs();
    }
    for k in limits.lags..limits.far {
        let mut sum = [0.0; LANES];
        for i in 0..2 * SECTIONS {
            for l in 0..LANES {
                sum[l] += limits.free[k][i] * z[i / 2][i % 2][l];
            }
        }
        before[k + 1] = sum;
        for l in 0..LANES {
            let size = (sum[l] + limits.impulse[k][l] * u[l]).abs();
            most[l] = if most[l] > size { most[l] } else { size };
        }
    }
    for l in 0..LANES {
        let all = if peak[l] > most[l] { peak[l] } else { most[l] };
        peak[l] = if far[l] { all } else { peak[l] };
        far[l] &= all > limits.near;
    }
}
