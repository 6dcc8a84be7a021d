//! The voices of one instrument: who sounds on which lane, from the onset until it has died away.

mod adopt;

use super::core::GRID;
use super::event::{Move, Play};
use super::journey::Journeys;
use super::lane::{Dying, Lane, Status};
use super::mixer::Routes;
use super::ops::Ops;
use super::workspace::{Buffer, Bus, Workspace};
use crate::dsp::fade::{CROSS, FADE, HUSH, fade};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::budget;
use crate::graph::plan::Instrument;
use crate::graph::program::Feed;
use crate::node::kernel::LEAD;
use crate::perception::gauge::Gauge;
use crate::schedule::Instant;
use crate::space::moving::Mover;
use crate::space::path::Route;
use std::ops::Range;
use std::sync::Arc;

/// What counts as silence: −120 dB.
const SILENCE: f64 = 1e-6;

/// Seconds, besides what its delays hold back, in which a voice that was released and whose envelopes have ended must become quieter.
/// One that does not would sound for ever: it fades, as a voice without envelopes does at its release. An echo or a resonator that
/// dies away, however slowly, does so in peace.
const STRETCH: f64 = 5.0;

/// The largest gain of a voice: 120 dB over full scale, where the output stage holds its input as well.
const LOUDEST: f64 = 1e6;

/// A voice that had to make room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stolen {
    /// Where it fades, unless whoever it made room for had to take that as well.
    pub lane: usize,
    /// Its serial number.
    pub serial: u64,
    /// Its id.
    pub id: u64,
}

/// States and lanes of one instrument.
pub struct Bank<R: Real> {
    isa: Isa,
    ops: Ops<R>,
    lanes: Vec<Lane>,
    live: Vec<u8>,
    /// Lanes that are live.
    taken: usize,
    rising: Vec<u8>,
    fading: Vec<u8>,
    ending: Vec<u8>,
    /// Lanes whose voices come from another bank, in which they fade meanwhile, and since when.
    crossing: Vec<u8>,
    crossed: u64,
    peaks: Vec<[R; LANES]>,
    routes: Vec<Routes<R>>,
    /// Lanes whose voices move, and how.
    moving: Vec<u8>,
    journeys: Journeys,
    /// By lane: the id of the voice that is or was there; none where no node listens to what hands do.
    ids: Vec<u64>,
    voices: usize,
    /// Engine samples of silence before a voice that has ended is let go.
    tail: u64,
    /// Engine samples from one to the next of which it must become quieter by then.
    stretch: u64,
    sounding: usize,
    rate: f64,
    /// Samples that were not finite and were masked.
    pub masked: u64,
    /// Voices that had to make room.
    pub stolen: u64,
}

impl<R: Real> Bank<R> {
    /// Silent lanes for an instrument, whose voices may go along some paths, in an engine at `rate` with so many groups of channels.
    pub fn new(
        instrument: &Instrument,
        (paths, gauges): (&Arc<[Route]>, &Arc<[Option<Gauge>]>),
        rate: f64,
        seed: u64,
        channel_groups: usize,
        isa: Isa,
    ) -> Self {
        let groups = budget::groups(instrument.voices);
        let tail = instrument.tail.clamp(0.0, 3600.0);
        let ops = Ops::new(&instrument.program, groups, rate, seed, isa);
        Self {
            isa,
            ids: vec![u64::MAX; if ops.listen() { groups * LANES } else { 0 }],
            ops,
            lanes: vec![Lane::default(); groups * LANES],
            live: vec![0; groups],
            taken: 0,
            rising: vec![0; groups],
            fading: vec![0; groups],
            ending: vec![0; groups],
            crossing: vec![0; groups],
            crossed: 0,
            peaks: vec![[R::ZERO; LANES]; groups],
            routes: (0..groups).map(|_| Routes::new(channel_groups)).collect(),
            moving: vec![0; groups],
            journeys: Journeys::new(instrument, paths, gauges, groups * LANES, rate),
            voices: instrument.voices,
            tail: (tail * rate) as u64,
            stretch: ((tail + STRETCH) * rate) as u64,
            sounding: 0,
            rate,
            masked: 0,
            stolen: 0,
        }
    }

    /// Lanes, spare ones included.
    pub fn lanes(&self) -> usize {
        self.lanes.len()
    }

    /// Voices that sound, those that fade aside.
    pub fn sounding(&self) -> usize {
        self.sounding
    }

    /// Whether all lanes are free.
    pub fn is_idle(&self) -> bool {
        self.taken == 0
    }

    /// Starts a voice at `at`, when `clock` is the next sample to be computed, on the channels of `place`. Gives its lane, and
    /// which voice had to make room, if one had to.
    pub fn start(
        &mut self,
        play: &Play,
        at: Instant,
        clock: u64,
        place: &[(u32, f64)],
        serial: u64,
    ) -> (usize, Option<Stolen>) {
        let stolen = if self.sounding >= self.voices { self.make_room(at) } else { None };
        let lane = self.free_lane();
        let (group, l) = (lane / LANES, lane % LANES);
        let status = Status::Held;
        let (play, level, quiet) = (*play, 0.0, 0);
        self.lanes[lane] = Lane { play, born: at, serial, level, quiet, dying: Dying::default(), status };
        if let Some(id) = self.ids.get_mut(lane) {
            *id = play.id;
        }
        self.ops.set(lane, &play.fields());
        self.ops.start(lane, play.id, at.until(clock) - LEAD);
        let gain = self.place(lane, place);
        if self.journeys.take(play.place) {
            self.moving[group] |= 1 << l;
            self.journeys.begin(lane, play.place, gain);
        }
        // A lane that still faded may have been taken over.
        self.taken += usize::from(self.live[group] & (1 << l) == 0);
        self.live[group] |= 1 << l;
        if !self.ops.decide() {
            self.rising[group] |= 1 << l;
        }
        self.sounding += 1;
        (lane, stolen)
    }

    /// Sends a lane to the channels of `place`, with the gain of its event, and gives that. One that moves is on its way instead.
    fn place(&mut self, lane: usize, place: &[(u32, f64)]) -> f64 {
        let (group, l) = (lane / LANES, lane % LANES);
        let play = &self.lanes[lane].play;
        let gain = play.level * self.ops.gain(&play.fields());
        let gain = if gain.is_finite() { gain.clamp(-LOUDEST, LOUDEST) } else { 0.0 };
        let stays = !self.journeys.take(play.place);
        for &(channel, share) in place.iter().filter(|_| stays) {
            self.routes[group].connect(l, channel, share * gain);
        }
        self.lanes[lane].level = gain.abs();
        gain
    }

    /// Makes room to take over the voices of another bank. It allocates.
    pub fn expect_voices(&mut self) {
        self.ops.expect_voices();
    }

    /// A voice that sounds falls silent from `at` on, so many times as fast as most do.
    fn let_fade(&mut self, lane: usize, at: Instant, pace: f64) {
        self.lanes[lane].status = Status::Fading(at, pace);
        self.fading[lane / LANES] |= 1 << (lane % LANES);
        self.sounding -= 1;
    }

    /// Lets voices that were started before the engine took over begin now.
    pub fn begin_at(&mut self, now: Instant) {
        for lane in self.lanes.iter_mut().filter(|lane| lane.status != Status::Free) {
            lane.born = now;
        }
    }

    /// Lets all voices fall silent from `at` on, as slowly as those that cross.
    pub fn fade_all(&mut self, at: Instant) {
        for lane in 0..self.lanes.len() {
            if matches!(self.lanes[lane].status, Status::Held | Status::Released) {
                self.let_fade(lane, at, FADE / CROSS);
            }
        }
    }

    /// Lets all voices that `falls` says yes to fall silent within [`HUSH`] from `at` on, released or not; `silenced` hears of their lanes and
    /// serial numbers.
    pub fn silence(
        &mut self,
        falls: impl Fn(&Play) -> bool,
        at: Instant,
        mut silenced: impl FnMut(usize, u64),
    ) {
        for lane in 0..self.lanes.len() {
            let (status, pace) = (self.lanes[lane].status, FADE / HUSH);
            match status {
                Status::Free => {}
                _ if !falls(&self.lanes[lane].play) => {}
                Status::Held | Status::Released => {
                    self.let_fade(lane, at, pace);
                    silenced(lane, self.lanes[lane].serial);
                }
                // One that makes room goes on faster from where it is.
                Status::Fading(since, slow) => {
                    let done = at.since(since).max(0.0) * (1.0 - slow / pace);
                    self.lanes[lane].status = Status::Fading(since + done, pace);
                }
            }
        }
    }

    /// Whether every voice that sounds or still fades is one that `falls` says yes to.
    pub fn only_sounds(&self, falls: impl Fn(&Play) -> bool) -> bool {
        self.lanes.iter().all(|lane| lane.status == Status::Free || falls(&lane.play))
    }

    /// Releases the voice of that serial number on `lane`, if it is still there.
    pub fn end(&mut self, lane: usize, serial: u64, at: Instant) {
        let Some(voice) = self.lanes.get_mut(lane).filter(|v| v.serial == serial && v.status == Status::Held)
        else {
            return;
        };
        if self.ops.decide() {
            voice.status = Status::Released;
            self.ops.release(lane, at.since(voice.born));
        } else {
            self.let_fade(lane, at, 1.0);
        }
    }

    /// Releases the voices whose ids are such; `released` hears of their lanes and serial numbers.
    pub fn release(
        &mut self,
        which: impl Fn(u64) -> bool,
        at: Instant,
        mut released: impl FnMut(usize, u64),
    ) {
        for lane in 0..self.lanes.len() {
            let voice = self.lanes[lane];
            if voice.status == Status::Held && which(voice.play.id) {
                self.end(lane, voice.serial, at);
                released(lane, voice.serial);
            }
        }
    }

    /// The hand that holds the voices of that id moves. Those that fade have been let go of.
    pub fn touch(&mut self, Move { id, motion, value }: Move, at: Instant) {
        for lane in 0..self.ids.len() {
            if self.ids[lane] != id {
                continue;
            }
            let voice = &self.lanes[lane];
            if matches!(voice.status, Status::Held | Status::Released) {
                self.ops.touch(lane, motion, value, at.since(voice.born));
            }
        }
    }

    /// Computes `frames` samples from `clock` on and adds them to the mix at `offset`.
    pub fn run(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        if self.taken == 0 {
            return;
        }
        if self.ops.have_loops() && frames > 1 {
            for frame in 0..frames {
                self.run(work, 1, offset + frame, clock + frame as u64);
            }
            return;
        }
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: an engine holds this level only where `Isa::or_supported` found it on this machine.
            Isa::Avx2 => unsafe { self.run_avx2(work, frames, offset, clock) },
            _ => self.run_groups(work, frames, offset, clock),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn run_avx2(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        self.run_groups(work, frames, offset, clock);
    }

    #[inline(always)]
    fn run_groups(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        for group in 0..self.live.len() {
            if self.live[group] != 0 {
                self.ops.run(group, work, frames);
                self.finish(group, work, frames, offset, clock);
            }
        }
    }

    /// Masks what is not finite, fades what fades, notes peaks where a voice may be at its end, and mixes.
    #[inline(always)]
    fn finish(&mut self, group: usize, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        let Workspace { buffers, shared, mix, stride, fed, mover } = work;
        // The last buffer of the workspace is the mixer's own.
        let own = buffers.len() - 1;
        let at = match self.ops.output(0) {
            Some(Feed::Buffer(b)) => b as usize,
            Some(Feed::Shared(s)) => {
                // Read and left as it is: what rests is filled once, for all blocks to come.
                let signal = &shared[s as usize];
                for (frame, row) in buffers[own].rows[..frames].iter_mut().enumerate() {
                    *row = signal.at(frame);
                }
                own
            }
            Some(Feed::Steady(row)) => {
                buffers[own].rows[..frames].fill(self.ops.steady(group, row));
                own
            }
            Some(Feed::Late(_)) | None => return,
        };
        let block = buffers[at].spelt_out(frames);
        if !R::all_finite(block) {
            self.masked += mask(block, self.live[group]);
        }
        if (self.rising[group] | self.fading[group] | self.crossing[group]) != 0 {
            self.fade(group, block, clock);
        }
        if self.ending[group] != 0 {
            let mut peak = self.peaks[group];
            for row in block.iter() {
                for l in 0..LANES {
                    peak[l] = peak[l].max(row[l].abs());
                }
            }
            self.peaks[group] = peak;
        }
        let mut bus = Bus { rows: mix, stride: *stride, fed };
        self.routes[group].mix(block, &mut bus, offset);
        if self.moving[group] != 0
            && let Some(mover) = mover
        {
            self.travel(
                group,
                &*buffers,
                at,
                &*shared,
                (mover, &mut bus, offset),
                clock..clock + frames as u64,
            );
        }
    }

    /// Mixes the lanes that move, whose signals are in buffer `at`.
    #[inline(always)]
    fn travel(
        &mut self,
        group: usize,
        buffers: &[Buffer<R>],
        at: usize,
        shared: &[Buffer<R>],
        (mover, bus, offset): (&mut Mover, &mut Bus<'_, R>, usize),
        frames: Range<u64>,
    ) {
        let Self { journeys, lanes, ops, moving, .. } = self;
        let steers = journeys.steers();
        for l in (0..LANES).filter(|l| moving[group] & (1 << l) != 0) {
            let lane = group * LANES + l;
            let steer = |which: usize, first: usize, to: &mut [f64]| {
                let mut from = |buffer: &Buffer<R>| {
                    to.iter_mut().enumerate().for_each(|(k, to)| *to = buffer.at(first + k)[l].wide());
                };
                match steers.map_or(Feed::Late(0), |feeds| feeds[which]) {
                    Feed::Buffer(b) => from(&buffers[b as usize]),
                    Feed::Shared(s) => from(&shared[s as usize]),
                    // What stays is known better than to the lanes: on the edge of a cell a nanometre is heard.
                    Feed::Steady(row) => to.fill(ops.base(lane, row)),
                    Feed::Late(_) => to.fill(0.0),
                }
            };
            let value = |frame: usize| buffers[at].rows[frame][l];
            journeys.travel(lane, &lanes[lane], (mover, bus, offset), frames.clone(), value, steer);
        }
    }

    #[cold]
    fn fade(&mut self, group: usize, block: &mut [[R; LANES]], clock: u64) {
        for l in 0..LANES {
            if self.rising[group] & (1 << l) != 0 {
                let age = self.lanes[group * LANES + l].born.until(clock) - LEAD;
                for (frame, row) in block.iter_mut().enumerate() {
                    row[l] *= R::of(1.0 - fade((age + frame as f64) / self.rate));
                }
                if age > FADE * self.rate {
                    self.rising[group] &= !(1 << l);
                }
            }
            if self.crossing[group] & (1 << l) != 0 {
                // What its copy in the old bank lacks of 1.
                let age = Instant { sample: self.crossed, fraction: 0 }.until(clock) - LEAD;
                for (frame, row) in block.iter_mut().enumerate() {
                    row[l] *= R::of(1.0 - fade((age + frame as f64) / self.rate * (FADE / CROSS)));
                }
                if age > CROSS * self.rate {
                    self.crossing[group] &= !(1 << l);
                }
            }
            if let Status::Fading(since, pace) = self.lanes[group * LANES + l].status {
                let age = since.until(clock) - LEAD;
                for (frame, row) in block.iter_mut().enumerate() {
                    row[l] *= R::of(fade((age + frame as f64) / self.rate * pace));
                }
            }
        }
    }

    /// Every 64 engine samples: settles states, and frees lanes whose voices have ended.
    pub fn settle(&mut self, clock: u64) {
        if self.taken == 0 {
            return;
        }
        for group in 0..self.live.len() {
            if self.live[group] == 0 {
                continue;
            }
            self.ops.settle(group);
            let ended = self.ops.ended(group);
            for l in 0..LANES {
                let lane = group * LANES + l;
                let over = match self.lanes[lane].status {
                    Status::Free => continue,
                    Status::Fading(since, pace) => {
                        since.until(clock) - LEAD > FADE / pace.min(1.0) * self.rate
                    }
                    Status::Held | Status::Released => {
                        let bit = 1 << l;
                        if self.ending[group] & bit != 0 && self.peaks[group][l] < R::of(SILENCE) {
                            self.lanes[lane].quiet += GRID;
                        } else {
                            self.lanes[lane].quiet = 0;
                        }
                        let (status, dies) = (self.lanes[lane].status, self.ending[group] & bit != 0);
                        self.ending[group] |= ended & bit;
                        if status == Status::Released && dies {
                            let peak = self.peaks[group][l].wide();
                            if self.lanes[lane].dying.goes_on(GRID, peak, self.stretch) {
                                self.let_fade(lane, Instant { sample: clock, fraction: 0 }, 1.0);
                                continue;
                            }
                        }
                        self.lanes[lane].quiet > self.tail
                    }
                };
                if over {
                    self.free(lane);
                }
            }
            self.peaks[group] = [R::ZERO; LANES];
        }
    }

    fn free(&mut self, lane: usize) {
        let (group, l) = (lane / LANES, lane % LANES);
        if !matches!(self.lanes[lane].status, Status::Fading(..) | Status::Free) {
            self.sounding -= 1;
        }
        self.lanes[lane].status = Status::Free;
        let keep = !(1 << l);
        self.taken -= usize::from(self.live[group] & (1 << l) != 0);
        self.live[group] &= keep;
        self.rising[group] &= keep;
        self.fading[group] &= keep;
        self.ending[group] &= keep;
        self.crossing[group] &= keep;
        self.moving[group] &= keep;
        self.routes[group].disconnect(l);
    }

    /// The lowest free lane; where all are taken, the one that has faded longest.
    fn free_lane(&mut self) -> usize {
        for (group, live) in self.live.iter().enumerate() {
            let l = live.trailing_ones() as usize;
            if l < LANES {
                return group * LANES + l;
            }
        }
        let since =
            |lane: &Lane| if let Status::Fading(since, _) = lane.status { since } else { Instant::NEVER };
        let lane = (0..self.lanes.len()).min_by_key(|&i| since(&self.lanes[i])).unwrap_or(0);
        self.free(lane);
        lane
    }

    /// Lets a voice fade: of those released the quietest, else the oldest. Gives which.
    fn make_room(&mut self, at: Instant) -> Option<Stolen> {
        let of_status = |status| {
            let lanes = self.lanes.iter().enumerate();
            lanes.filter(move |(_, lane)| lane.status == status).map(|(i, lane)| (i, lane.serial))
        };
        let quietest = of_status(Status::Released)
            .map(|(lane, serial)| (lane, self.ops.loudness(lane) * self.lanes[lane].level, serial))
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)))
            .map(|(lane, ..)| lane);
        let victim = quietest
            .or_else(|| of_status(Status::Held).min_by_key(|(_, serial)| *serial).map(|(lane, _)| lane));
        let lane = victim?;
        let Lane { serial, play: Play { id, .. }, .. } = self.lanes[lane];
        self.let_fade(lane, at, 1.0);
        self.stolen += 1;
        Some(Stolen { lane, serial, id })
    }
}

/// Makes what is not finite 0; how many samples of live lanes that were.
#[cold]
fn mask<R: Real>(block: &mut [[R; LANES]], live: u8) -> u64 {
    let mut count = 0;
    for row in block {
        for (l, value) in row.iter_mut().enumerate() {
            if !value.is_finite() {
                *value = R::ZERO;
                count += u64::from(live & (1 << l) != 0);
            }
        }
    }
    count
}
