//! A stream to a sound card.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cpal::traits::{DeviceTrait, StreamTrait};
use cpal::{
    BufferSize, Device, ErrorKind, FromSample, SampleFormat, SizedSample, StreamConfig, SupportedBufferSize,
    SupportedStreamConfigRange,
};

use super::ahead::Ahead;
use super::callers::Callers;
use super::failure::{DeviceError, Trouble};
use super::hosts::JACK;
use super::jack_turn::{self, Stay};
use super::list::{self, Found, Offer};
use super::minder::teller;
use super::priority;
use super::rates::Rates;
use crate::live::board::Board;
use crate::live::driver::Driver;
use crate::live::lent::Lent;
use crate::live::stamp::Epoch;
use crate::live::steps::Steps;

/// What is wanted of a card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Channels of a frame.
    pub channels: usize,
    /// Frames a second.
    pub rate: u32,
    /// Frames a block; `None`: as the card likes.
    pub block: Option<u32>,
    /// Whether somebody has asked for blocks of that length: where they are not offered that is an error. Otherwise those nearest to it are taken.
    pub exact: bool,
}

impl Shape {
    /// For a device that is back: in blocks as near to those of before as it now offers.
    pub(super) fn again(self, offer: Option<&Offer>) -> Self {
        Self { exact: false, ..self.within(offer.and_then(|offer| offer.blocks)) }
    }

    /// In blocks as near to its own as are offered, from the least to the most.
    pub(super) fn within(self, blocks: Option<(u32, u32)>) -> Self {
        let Some((least, most)) = blocks else { return self };
        Self { block: self.block.map(|block| block.min(most).max(least)), ..self }
    }
}

/// What a card tells of itself while it plays.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// It is gone, or its stream is of no use any more.
    Lost(String),
    /// Its stream failed, which says nothing of the device: it is opened again.
    Broke(String),
    /// The system lets it play on another device than before.
    Moved,
    /// Anything else, for the log.
    Said(String),
}

/// What fills the frames that a device plays.
pub trait Fill: Send + 'static {
    /// The device takes samples in these steps; told before the first block, and nothing beyond them reaches it.
    fn round_to(&mut self, steps: Steps);

    /// A block of `frames` is to be filled at `callback`, seconds on the stream's own clock, and will be played `delay` seconds later, as
    /// the device has it.
    fn begin(&mut self, frames: usize, callback: f64, delay: f64);

    /// Fills the next interleaved frames of the block that began last, all of it or a part. Neither allocates nor blocks.
    fn fill(&mut self, output: &mut [f32]);
}

impl Fill for Lent<Driver> {
    fn round_to(&mut self, steps: Steps) {
        self.used(|driver| driver.round_to(steps));
    }

    fn begin(&mut self, frames: usize, _callback: f64, _delay: f64) {
        self.used(|driver| driver.begin(frames));
    }

    fn fill(&mut self, output: &mut [f32]) {
        if !self.used(|driver| driver.go_on(output)) {
            output.fill(0.0);
        }
    }
}

/// A card that plays until this is dropped.
pub struct Card {
    /// Dropped first, so that nothing calls back any more.
    stream: cpal::Stream,
    /// Frames a block, as far as it says.
    pub block: Option<u32>,
    rushes: Arc<AtomicBool>,
    callers: Callers,
    /// Dropped last.
    _stay: Option<Stay>,
}

impl Drop for Card {
    fn drop(&mut self) {
        self.callers.rest();
    }
}

impl Card {
    /// Begins to play. `news` hears what becomes of it; `board` counts its gaps.
    ///
    /// # Errors
    /// What the card does not offer, or the system does not allow; then the driver goes home.
    pub fn open(
        device: &Device,
        found: &Found,
        shape: Shape,
        driver: impl Fill,
        board: &Arc<Board>,
        news: impl Fn(News) + Send + 'static,
    ) -> Result<Self, DeviceError> {
        fit(found, shape)?;
        let (turn, stay) = jack_turn::stream(found)?.unzip();
        let trouble = |error: &cpal::Error| DeviceError::of(&found.name, error);
        let ranges = list::outputs(device).map_err(|error| trouble(&error))?;
        let mut rates = Rates::default();
        // Of so many channels it may have other rates than on the whole.
        let own = ranges.iter().filter(|range| usize::from(range.channels()) == shape.channels);
        own.for_each(|range| rates.add((range.min_sample_rate(), range.max_sample_rate())));
        if !rates.contains(shape.rate) {
            return Err(no_rate(&found.name, shape, &rates));
        }
        let (format, blocks) = known_format(ranges.into_iter(), shape).map_err(|error| trouble(&error))?;
        // What a device offers on the whole may be more than so many channels have room for.
        let shape = if shape.exact { shape } else { shape.within(blocks) };
        fit_block(found, shape, blocks)?;
        let buffer_size = shape.block.map_or(BufferSize::Default, BufferSize::Fixed);
        let config = StreamConfig { channels: shape.channels as u16, sample_rate: shape.rate, buffer_size };
        let gaps = Arc::clone(board);
        let gone = Arc::new(AtomicBool::new(false));
        let callers = Callers::default();
        let rushes = Arc::<AtomicBool>::default();
        let mut player = Player {
            driver,
            raised: false,
            raise: priority::of_host(found.host()),
            gone: Arc::clone(&gone),
            board: Arc::clone(board),
            callers: callers.clone(),
            ahead: (found.host() == JACK)
                .then(|| Ahead::new(f64::from(shape.rate), 0.0, Arc::clone(&rushes))),
            epoch: Epoch::begin(),
        };
        player.driver.round_to(steps(format));
        let lost = move || gone.store(true, Ordering::Relaxed);
        let tell = teller(news, move || gaps.gap(), lost, callers.clone());
        let stream = match format {
            SampleFormat::F32 => device.build_output_stream(
                config,
                move |output: &mut [f32], info: &cpal::OutputCallbackInfo| {
                    if player.begin(output.len() / shape.channels.max(1), info) {
                        player.driver.fill(output);
                    } else {
                        output.fill(0.0);
                    }
                },
                tell,
                None,
            ),
            SampleFormat::I32 => convert::<i32, _>(device, config, player, tell),
            SampleFormat::I24 => convert::<cpal::I24, _>(device, config, player, tell),
            _ => convert::<i16, _>(device, config, player, tell),
        };
        let stream = stream.map_err(|error| DeviceError::of(&found.name, &error))?;
        stream.play().map_err(|error| DeviceError::of(&found.name, &error))?;
        drop(turn);
        let block = stream.buffer_size().ok();
        Ok(Self { stream, block, rushes, callers, _stay: stay })
    }

    /// Whether its server computes ahead of time: until it does so no more, it is given silence.
    pub(super) fn rushes(&self) -> bool {
        self.rushes.load(Ordering::Relaxed)
    }

    /// By how much a clock is ahead of the stream's own, seconds.
    pub(crate) fn behind(&self, clock: impl Fn() -> f64) -> f64 {
        behind(&self.stream, clock)
    }
}

/// A moment on a stream's own clock, in seconds.
pub(super) fn seconds(moment: cpal::StreamInstant) -> f64 {
    moment.as_nanos() as f64 * 1e-9
}

/// By how much `clock` is ahead of a stream's own, seconds: of several tries the one that took the shortest time.
pub(super) fn behind(stream: &cpal::Stream, clock: impl Fn() -> f64) -> f64 {
    let tries = (0..32).map(|_| {
        let before = clock();
        let own = seconds(stream.now());
        let after = clock();
        (after - before, (before + after) / 2.0 - own)
    });
    tries.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, ahead)| ahead)
}

/// What a stream's callback holds.
struct Player<F> {
    driver: F,
    raised: bool,
    /// How it asks to run before others.
    raise: fn(),
    /// The device was lost, even if it still asks for frames.
    gone: Arc<AtomicBool>,
    board: Arc<Board>,
    callers: Callers,
    /// Of a server that may compute ahead of time.
    ahead: Option<Ahead>,
    epoch: Epoch,
}

impl<F: Fill> Player<F> {
    /// Begins a block of `frames`. Says whether anything is to be played in it.
    fn begin(&mut self, frames: usize, info: &cpal::OutputCallbackInfo) -> bool {
        if self.gone.load(Ordering::Relaxed) {
            return false;
        }
        if !std::mem::replace(&mut self.raised, true) {
            self.callers.calls();
            (self.raise)();
        }
        if self.ahead.as_mut().is_some_and(|ahead| ahead.asks(frames as u64, self.epoch.now().seconds())) {
            return false;
        }
        let stamp = info.timestamp();
        let delay = stamp.playback.saturating_duration_since(stamp.callback);
        self.driver.begin(frames, seconds(stamp.callback), delay.as_secs_f64());
        self.board.device_delay.note(delay.as_nanos() as u64);
        true
    }
}

/// Frames that are converted at a time, at least.
pub(super) const STRETCH: usize = 8192;

fn convert<T, E>(
    device: &Device,
    config: StreamConfig,
    mut player: Player<impl Fill>,
    tell: E,
) -> Result<cpal::Stream, cpal::Error>
where
    T: SizedSample + FromSample<f32>,
    E: FnMut(cpal::Error) + Send + 'static,
{
    let channels = usize::from(config.channels).max(1);
    let mut scratch = vec![0.0_f32; STRETCH * channels];
    let fill = move |output: &mut [T], info: &cpal::OutputCallbackInfo| {
        if !player.begin(output.len() / channels, info) {
            output.fill(T::EQUILIBRIUM);
            return;
        }
        for part in output.chunks_mut(scratch.len()) {
            let frames = &mut scratch[..part.len()];
            player.driver.fill(frames);
            for (to, from) in part.iter_mut().zip(frames) {
                *to = T::from_sample_(*from);
            }
        }
    };
    device.build_output_stream(config, fill, tell, None)
}

/// Refuses what the card does not offer, and says what it does.
fn fit(found: &Found, shape: Shape) -> Result<(), DeviceError> {
    let Some(offer) = &found.output else {
        return Err(DeviceError::new(Trouble::Unfit, format!("{} has no outputs", found.name)));
    };
    let unfit = |what: String, help: String| {
        Err(DeviceError::new(Trouble::Unfit, format!("{}: {what}", found.name)).help(help))
    };
    let channels = shape.channels as u16;
    if usize::from(channels) != shape.channels || !offer.channels.contains(&channels) {
        let list: Vec<String> = offer.channels.iter().map(u16::to_string).collect();
        return unfit(
            format!("{} channels are not offered", shape.channels),
            format!("it offers {}; say so under [device] in the rig", list.join(", ")),
        );
    }
    if !offer.rates.contains(shape.rate) {
        return Err(no_rate(&found.name, shape, &offer.rates));
    }
    fit_block(found, shape, offer.blocks)
}

/// That a rate is not offered, and which are.
fn no_rate(name: &str, shape: Shape, rates: &Rates) -> DeviceError {
    let what = format!("{name}: {} Hz are not offered", shape.rate);
    DeviceError::new(Trouble::Unfit, what)
        .help(format!("it offers {rates} Hz: --rate, or `rate` under [device] in the rig"))
}

/// The same of how long blocks are.
fn fit_block(found: &Found, shape: Shape, offered: Option<(u32, u32)>) -> Result<(), DeviceError> {
    match (shape.block, offered) {
        (Some(block), Some((least, most))) if block < least || block > most => {
            let what = format!("{}: blocks of {block} frames are not offered", found.name);
            Err(DeviceError::new(Trouble::Unfit, what)
                .help(format!("it offers {least} to {most}: --block N")))
        }
        _ => Ok(()),
    }
}

/// Formats in which samples are exchanged: as they are, if a card takes that, else as exact as it does.
pub(super) const KNOWN: [SampleFormat; 4] =
    [SampleFormat::F32, SampleFormat::I32, SampleFormat::I24, SampleFormat::I16];

/// The steps of one of them.
fn steps(format: SampleFormat) -> Steps {
    let bits = format.bits_per_sample() as u8;
    Steps::of(bits).filter(|_| !format.is_float()).unwrap_or(Steps::FLOAT)
}

/// The format in which samples are exchanged with the card, and how long blocks may be then, as far as it says: a card whose memory is
/// counted in bytes has room for fewer frames of more bytes.
pub(super) fn known_format(
    ranges: impl Iterator<Item = SupportedStreamConfigRange>,
    shape: Shape,
) -> Result<(SampleFormat, Option<(u32, u32)>), cpal::Error> {
    let fits = |range: &SupportedStreamConfigRange| {
        usize::from(range.channels()) == shape.channels
            && (range.min_sample_rate()..=range.max_sample_rate()).contains(&shape.rate)
    };
    let fitting: Vec<SupportedStreamConfigRange> = ranges.filter(fits).collect();
    let of = |format: &SampleFormat| fitting.iter().find(|range| range.sample_format() == *format);
    let range = KNOWN.iter().find_map(of).ok_or_else(|| {
        cpal::Error::with_message(ErrorKind::UnsupportedConfig, "none of its sample formats is known here; ALSA converts them where a card is named plughw:... in place of hw:...")
    })?;
    let blocks = match range.buffer_size() {
        SupportedBufferSize::Range { min, max } => Some((*min, *max)),
        SupportedBufferSize::Unknown => None,
    };
    Ok((range.sample_format(), blocks))
}
