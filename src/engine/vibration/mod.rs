//! The vibration stage: engine-rate channels in, interleaved device frames out.
//!
//! In order, a channel: the high-pass that keeps steady voltages off (where it has one), equaliser, limiter, band limit, up-sampling, and
//! a clamp that should never act. Limiter and clamp act at full scale, or at the channel's own level where that is lower.
//! Channels run in groups of eight lanes. Everything is decided by engine time, so any split of a run into blocks gives
//! the same bits; so does every instruction set.

mod ceiling;
mod design;
mod group;
mod limiter;
mod loops;
mod shape;
#[cfg(test)]
mod tests;

use crate::dsp::biquad::{Biquad, Complex, MOST_SECTIONS};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::LANES;
pub(super) use ceiling::single;
use design::Design;
pub use design::{DEVICE_RATES, ENGINE_RATES};
use group::{Channel, Group, Place, Scratch, Target};

/// One engine sample of eight channels.
pub type Row = [f32; LANES];

/// Engine samples between two looks at what may sleep; on engine time, not on blocks.
pub const GRID: u64 = 64;

/// Values of output to write in one turn, about: 64 KiB.
const NEAR: usize = 16_384;

/// Channels beyond which groups write into a tile first, and groups in a tile.
const WIDE: usize = 128;
const TILE: usize = 4;

/// What can be chosen about the stage.
#[derive(Clone, Debug)]
pub struct Options {
    /// Taps a phase of the up-sampling filter, 4 to 12. Images: 4 gives -66 dB, 6 about -98 dB, 8 below -120 dB.
    pub taps: usize,
    /// Device frames for each engine sample; `None`: so many that the engine runs at about 8 kHz.
    pub ratio: Option<usize>,
    /// Equaliser sections of each channel at the engine's rate; channels beyond the list have none.
    pub equalisers: Vec<Vec<Biquad>>,
    /// Channels with a high-pass that keeps steady voltages off; those beyond the list have none.
    pub keeps_dc_off: Vec<bool>,
    /// The most that leaves each channel, as a share of full scale, above 0 and 1 at most; it is 1 for those beyond the list.
    pub levels: Vec<f64>,
    /// Whether the limiter is there.
    pub limiter: bool,
    /// Instruction set; what the machine lacks falls back to the baseline.
    pub isa: Isa,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            taps: 6,
            ratio: None,
            equalisers: Vec::new(),
            keeps_dc_off: Vec::new(),
            levels: Vec::new(),
            limiter: true,
            isa: Isa::detect(),
        }
    }
}

/// Why a stage cannot be built.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// Taps out of 4 to 12.
    Taps(usize),
    /// Device rate (Hz) out of 6 kHz to 1 MHz.
    Rate(f64),
    /// Engine rate (Hz), that of the device over the ratio, out of 6 to 12 kHz.
    EngineRate(f64),
    /// Too many equaliser sections: the channel (from 0), and how many it has.
    Sections(usize, usize),
    /// A level that is not above 0 and 1 at most: the channel (from 0), and the level.
    Level(usize, f64),
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Taps(taps) => write!(f, "{taps} taps a phase; choose 4 to 12"),
            Self::Rate(rate) => write!(f, "a device rate of {rate} Hz; choose 6,000 to 1,000,000 Hz"),
            Self::EngineRate(rate) => {
                write!(f, "an engine rate of {rate} Hz; choose a ratio that gives 6,000 to 12,000 Hz")
            }
            Self::Sections(channel, count) => write!(
                f,
                "channel {} has {count} equaliser sections; {MOST_SECTIONS} are the most",
                channel + 1
            ),
            Self::Level(channel, level) => {
                let channel = channel + 1;
                write!(
                    f,
                    "channel {channel} lets {level} of full scale leave; choose more than 0, and 1 at most"
                )
            }
        }
    }
}

impl std::error::Error for Refusal {}

/// What the stage adds in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Up-sampling, device frames (exact, the same at every frequency).
    pub fir_frames: f64,
    /// Band limit: phase delay at 250 Hz, seconds.
    pub band_limit_phase_250: f64,
    /// Band limit: group delay at 250 Hz, seconds.
    pub band_limit_group_250: f64,
    /// The high-pass that keeps steady voltages off: group delay at 250 Hz, seconds, of channels that have one; 0 where none has.
    pub high_pass_group_250: f64,
}

impl Delay {
    /// Frames of a device from what comes in to what leaves, for the envelope of a tone of 250 Hz.
    pub(super) fn frames(&self, device_rate: f64) -> f64 {
        self.fir_frames + (self.band_limit_group_250 + self.high_pass_group_250) * device_rate
    }
}

/// What the stage has met since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Input samples that were not finite (taken as 0).
    pub masked: u64,
    /// Input samples beyond ±1e6, 120 dB over full scale (held there).
    pub held: u64,
    /// Device-rate samples that the clamp cut.
    pub clamped: u64,
    /// Channel-samples at the engine's rate that the limiter turned down.
    pub limited: u64,
}

/// The stage.
#[derive(Debug)]
pub struct Vibration {
    design: Design,
    groups: Vec<Group>,
    channels: usize,
    equalisers: Vec<Vec<Biquad>>,
    keeps_dc_off: Vec<bool>,
    isa: Isa,
    scratch: Box<Scratch>,
    /// Groups that run through a turn one after another before the next do: all, or as many as a tile holds.
    abreast: usize,
    tile: Vec<f32>,
}

impl Vibration {
    /// For `channels` at `device_rate` (Hz, 6 kHz to 1 MHz).
    pub fn new(channels: usize, device_rate: f64, options: &Options) -> Result<Self, Refusal> {
        let design = Design::new(device_rate, options)?;
        let sections = |channel: usize| options.equalisers.get(channel).map_or(&[][..], Vec::as_slice);
        if let Some(channel) = (0..channels).find(|&c| sections(c).len() > MOST_SECTIONS) {
            return Err(Refusal::Sections(channel, sections(channel).len()));
        }
        let usable = |level: f64| level.is_finite() && f64::from(f32::MIN_POSITIVE) <= level && level <= 1.0;
        let levels = &options.levels[..options.levels.len().min(channels)];
        if let Some(channel) = levels.iter().position(|level| !usable(*level)) {
            return Err(Refusal::Level(channel, levels[channel]));
        }
        let channel = |channel: usize| Channel {
            equaliser: sections(channel),
            keeps_dc_off: options.keeps_dc_off.get(channel) == Some(&true),
            level: levels.get(channel).map_or(1.0, |level| single(*level)),
        };
        let groups = (0..channels)
            .step_by(LANES)
            .map(|first| Group::new(&design, (channels - first).min(LANES), |lane| channel(first + lane)))
            .collect();
        let scratch = Box::new(Scratch::new(channels, design.fir.ratio));
        let (equalisers, isa) = (options.equalisers.clone(), options.isa.or_supported());
        let keeps_dc_off: Vec<bool> = options.keeps_dc_off.iter().take(channels).copied().collect();
        // In wide frames the lines that one group writes would throw each other out of the cache before the next group adds
        // its part to them: a kilochannel's frames lie 4,096 bytes apart, which is where most caches begin again.
        let wide = channels > WIDE;
        let groups: Vec<Group> = groups;
        let abreast = if wide { TILE } else { groups.len().max(1) };
        let tile = vec![0.0; if wide { GRID as usize * design.fir.ratio * TILE * LANES } else { 0 }];
        Ok(Self { design, groups, channels, equalisers, keeps_dc_off, isa, scratch, abreast, tile })
    }

    /// Engine rate, Hz.
    pub fn rate(&self) -> f64 {
        self.design.rate
    }

    /// Device frames to an engine sample.
    pub fn ratio(&self) -> usize {
        self.design.fir.ratio
    }

    /// Channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Groups of eight channels, the last one padded.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// What the stage adds in time.
    pub fn delay(&self) -> Delay {
        Delay {
            fir_frames: self.design.fir.delay(),
            band_limit_phase_250: self.design.band_limit.phase_delay(250.0),
            band_limit_group_250: self.design.band_limit.group_delay(250.0),
            high_pass_group_250: match self.keeps_dc_off.contains(&true) {
                true => self.design.blocker.group_delay(250.0, self.design.rate),
                false => 0.0,
            },
        }
    }

    /// Lets no more leave the channels than these levels, of full scale, from now on: at once where nothing sounds, else gliding
    /// there within 100 ms, on whose way what leaves a channel keeps to the higher of both. Channels beyond the list go to 1.
    pub(super) fn limit_to(&mut self, levels: &[f32]) {
        for (g, group) in self.groups.iter_mut().enumerate() {
            group.limit_to(std::array::from_fn(|l| levels.get(g * LANES + l).copied().unwrap_or(1.0)));
        }
    }

    /// Takes over from an old stage of as many channels at the same rates: channels that are not among the `crossed` (from 0) go on as they were
    /// there, at their levels of now; the others begin at rest.
    pub(super) fn take_over(&mut self, old: &mut Self, crossed: &[usize]) {
        for (g, (group, old)) in self.groups.iter_mut().zip(&mut old.groups).enumerate() {
            group.take_over(old, std::array::from_fn(|l| !crossed.contains(&(g * LANES + l))));
        }
    }

    /// The designed linear response of `channel` at `frequency` (Hz): its high-pass, equaliser, band limit and up-sampling, their delays
    /// included. Device frame m holds time m / device rate, engine sample n falls on frame n × ratio.
    pub fn response(&self, channel: usize, frequency: f64) -> Complex {
        let sections = self.equalisers.get(channel).into_iter().flatten();
        let high_pass = match self.keeps_dc_off.get(channel) {
            Some(true) => self.design.blocker.response(frequency, self.design.rate),
            _ => Complex::from(1.0),
        };
        let equaliser = sections.fold(high_pass, |r, s| r * s.response(frequency, self.design.rate));
        equaliser * self.design.band_limit.response(frequency) * self.design.fir.response(frequency)
    }

    /// Renders `frames` engine samples, the first of them number `clock` since the start.
    ///
    /// `rows` is `groups()` blocks of `frames` rows each, and is spoilt. `fed[g]` false says that block g is all zero
    /// and need not be looked at; groups beyond the list count as fed. `out` takes `frames × ratio() × channels()`
    /// values, frame by frame. Returns the number of engine samples rendered: fewer than `frames` where `out` is too
    /// short, none where `rows` is.
    pub fn process(
        &mut self,
        frames: usize,
        rows: &mut [Row],
        fed: &[bool],
        clock: u64,
        out: &mut [f32],
    ) -> usize {
        self.process_with_rest(frames, rows, fed, clock, out, &mut [])
    }

    /// The same; the engine sample after those for which `out` has room goes to `rest`, if that can hold one.
    pub fn process_with_rest(
        &mut self,
        frames: usize,
        rows: &mut [Row],
        fed: &[bool],
        clock: u64,
        out: &mut [f32],
        rest: &mut [f32],
    ) -> usize {
        let step = self.ratio() * self.channels;
        if step == 0 || frames == 0 {
            return frames;
        }
        let whole = if out.len() >= frames * step { frames } else { out.len() / step };
        let room = whole + usize::from(rest.len() >= step);
        let count = if rows.len() < frames * self.groups.len() { 0 } else { frames.min(room) };
        let rest = if count > whole { &mut rest[..step] } else { &mut [] };
        let still = |(g, group): (usize, &Group)| group.sleeps() && fed.get(g) == Some(&false);
        if count > 0 && self.groups.iter().enumerate().all(still) {
            out[..count.min(whole) * step].fill(0.0);
            rest.fill(0.0);
            return count;
        }
        // Short turns, so that the frames that the groups write between each other stay in the cache.
        let turn = if GRID as usize * step <= NEAR { GRID as usize } else { GRID as usize / 2 };
        let mut from = 0;
        while from < count {
            let to = (from + turn).min(count);
            let out = &mut out[from * step..to.min(whole) * step];
            let rest = if to > whole { &mut *rest } else { &mut [] };
            let now = clock.wrapping_add(from as u64);
            let tile = &mut self.tile[..];
            for (t, groups) in self.groups.chunks_mut(self.abreast).enumerate() {
                let first = t * self.abreast;
                // Written in its place at once, or in a tile that is then copied, whole cache lines at a time.
                let wide = self.channels > self.abreast * LANES;
                let values = (to - from) * self.design.fir.ratio * self.abreast * LANES;
                for (i, group) in groups.iter_mut().enumerate() {
                    let g = first + i;
                    let block = &mut rows[g * frames + from..g * frames + to];
                    let fed = fed.get(g).copied().unwrap_or(true);
                    let to = if wide {
                        let place = Place { channels: self.abreast * LANES, first: i * LANES };
                        Target { out: &mut tile[..values], rest: &mut [], place }
                    } else {
                        Target { out, rest, place: Place { channels: self.channels, first: g * LANES } }
                    };
                    group.process(&self.design, self.isa, block, fed, now, to, &mut self.scratch);
                }
                if wide {
                    let place = Place { channels: self.channels, first: first * LANES };
                    let count = (groups.len() * LANES).min(self.channels - place.first);
                    let from = tile[..values].chunks_exact(self.abreast * LANES);
                    for (to, from) in (Target { out, rest, place }).frames().zip(from) {
                        to[place.first..][..count].copy_from_slice(&from[..count]);
                    }
                }
            }
            from = to;
        }
        count
    }

    /// Largest magnitude of `channel` at the device's rate before the clamp, since the last call of this; 0 for a
    /// channel that is not there.
    pub fn take_peak(&mut self, channel: usize) -> f32 {
        self.groups.get_mut(channel / LANES).map_or(0.0, |g| std::mem::take(&mut g.peak[channel % LANES]))
    }

    /// Gain the limiter holds on `channel`, 1 when it does nothing.
    pub fn gain(&self, channel: usize) -> f32 {
        self.groups.get(channel / LANES).map_or(1.0, |g| g.gain(channel % LANES))
    }

    /// What was met so far, all channels together.
    pub fn counts(&self) -> Counts {
        self.groups.iter().fold(Counts::default(), |sum, g| Counts {
            masked: sum.masked + g.counts.masked,
            held: sum.held + g.counts.held,
            clamped: sum.clamped + g.counts.clamped,
            limited: sum.limited + g.counts.limited,
        })
    }

    /// Whether group `group` sleeps: its state is exactly zero and it costs nothing until it is fed.
    pub fn sleeps(&self, group: usize) -> bool {
        self.groups.get(group).is_none_or(Group::sleeps)
    }
}
