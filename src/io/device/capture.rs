//! A stream from a sound card that hears.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;

use cpal::traits::{DeviceTrait, StreamTrait};
use cpal::{BufferSize, Device, FromSample, SampleFormat, SizedSample, StreamConfig};

use super::callers::Callers;
use super::card::{News, STRETCH, Shape, behind, known_format, seconds};
use super::failure::{DeviceError, Trouble};
use super::jack_turn::{self, Stay};
use super::list::{self, Found};
use super::minder::teller;
use super::priority;
use crate::live::board::Board;
use crate::live::intake::Intake;
use crate::live::lent::Lent;

/// What takes frames that a device hears.
pub trait Hear: Send + 'static {
    /// A block was handed over at `callback`, seconds on the stream's own clock.
    fn begin(&mut self, _callback: f64) {}

    /// Interleaved frames, the first of which the device heard `delay` seconds ago, as far as it says. Neither allocates nor blocks.
    fn hear(&mut self, delay: f64, frames: &[f32]);
}

impl Hear for Lent<Intake> {
    fn hear(&mut self, delay: f64, frames: &[f32]) {
        self.used(|intake| intake.hear(delay, frames));
    }
}

/// A card that is listened to until this is dropped.
pub struct Capture {
    /// Dropped first, so that nothing calls back any more.
    stream: cpal::Stream,
    callers: Callers,
    /// Dropped last.
    _stay: Option<Stay>,
}

impl Drop for Capture {
    fn drop(&mut self) {
        self.callers.rest();
    }
}

/// Seconds of a block where nobody says otherwise.
const BLOCK: f64 = 0.005;

/// What is asked of a card that is to bring `channels`: as many or more, at `rate` if it has that, in blocks as long as `block` frames
/// at `rate` are.
///
/// # Errors
/// A device without inputs.
pub fn shape(found: &Found, channels: usize, rate: u32, block: Option<u32>) -> Result<Shape, DeviceError> {
    let Some(offer) = &found.input else {
        return Err(DeviceError::new(Trouble::Unfit, format!("{} has no inputs", found.name))
            .help("`pacinian devices` lists which have"));
    };
    let counts = || offer.channels.iter().map(|&n| usize::from(n));
    let enough = counts().find(|&n| n >= channels).or(counts().max());
    let taken = offer.rates.nearest(rate);
    let length = block.map_or(BLOCK, |block| f64::from(block) / f64::from(rate.max(1)));
    let frames = (length * f64::from(taken)).round().max(1.0) as u32;
    let block = offer.blocks.map(|(least, most)| frames.clamp(least, most.max(least)));
    Ok(Shape { channels: enough.unwrap_or(1), rate: taken, block, exact: false })
}

impl Capture {
    /// Begins to listen. `news` hears what becomes of it; `board` counts its gaps.
    ///
    /// # Errors
    /// What the card does not offer, or the system does not allow; then what hears goes where it goes when it is dropped.
    pub fn open(
        device: &Device,
        found: &Found,
        shape: Shape,
        hear: impl Hear,
        board: &Arc<Board>,
        news: impl Fn(News) + Send + 'static,
    ) -> Result<Self, DeviceError> {
        let (turn, stay) = jack_turn::stream(found)?.unzip();
        let trouble = |error: &cpal::Error| DeviceError::of(&found.name, error);
        let ranges = list::inputs(device).map_err(|error| trouble(&error))?;
        let (format, blocks) = known_format(ranges.into_iter(), shape).map_err(|error| trouble(&error))?;
        let buffer_size = shape.within(blocks).block.map_or(BufferSize::Default, BufferSize::Fixed);
        let config = StreamConfig { channels: shape.channels as u16, sample_rate: shape.rate, buffer_size };
        let gaps = Arc::clone(board);
        let callers = Callers::default();
        let tell = teller(news, move || gaps.gap_of_input(), || {}, callers.clone());
        let own = (priority::of_host(found.host()), callers.clone());
        let stream = match format {
            SampleFormat::F32 => stream::<f32, _>(device, config, hear, tell, own),
            SampleFormat::I32 => stream::<i32, _>(device, config, hear, tell, own),
            SampleFormat::I24 => stream::<cpal::I24, _>(device, config, hear, tell, own),
            _ => stream::<i16, _>(device, config, hear, tell, own),
        };
        let stream = stream.map_err(|error| trouble(&error))?;
        stream.play().map_err(|error| trouble(&error))?;
        drop(turn);
        Ok(Self { stream, callers, _stay: stay })
    }

    /// By how much a clock is ahead of the stream's own, seconds.
    pub(crate) fn behind(&self, clock: impl Fn() -> f64) -> f64 {
        behind(&self.stream, clock)
    }
}

fn stream<T, E>(
    device: &Device,
    config: StreamConfig,
    mut hear: impl Hear,
    tell: E,
    (raise, callers): (fn(), Callers),
) -> Result<cpal::Stream, cpal::Error>
where
    T: SizedSample,
    f32: FromSample<T>,
    E: FnMut(cpal::Error) + Send + 'static,
{
    let channels = usize::from(config.channels).max(1);
    let mut scratch = vec![0.0_f32; STRETCH * channels];
    let mut raised = false;
    let take = move |input: &[T], info: &cpal::InputCallbackInfo| {
        if !std::mem::replace(&mut raised, true) {
            callers.calls();
            raise();
        }
        let stamp = info.timestamp();
        hear.begin(seconds(stamp.callback));
        let mut delay = stamp.callback.saturating_duration_since(stamp.capture).as_secs_f64();
        for part in input.chunks(scratch.len()) {
            let frames = &mut scratch[..part.len()];
            for (to, from) in frames.iter_mut().zip(part) {
                *to = <f32 as FromSample<T>>::from_sample_(*from);
            }
            hear.hear(delay, frames);
            delay = (delay - (part.len() / channels) as f64 / f64::from(config.sample_rate)).max(0.0);
        }
    };
    device.build_input_stream(config, take, tell, None)
}

#[cfg(test)]
mod tests {
    use super::{Shape, shape};
    use crate::io::device::hosts::Hosts;
    use crate::io::device::list::{Found, Offer};
    use crate::io::device::rates::Rates;

    #[test]
    fn a_card_is_asked_for_what_it_has() {
        let mut rates = Rates::default();
        rates.add((44_100, 48_000));
        let offer =
            Offer { channels: vec![1, 2, 8], there: None, rates, blocks: Some((64, 4096)), formats: vec![] };
        let (id, name, hosts) = ("x".into(), "x".into(), Hosts::default());
        let card = Found { id, name, default: false, output: None, input: Some(offer), trouble: None, hosts };
        let of = |channels, rate, block| shape(&card, channels, rate, block).unwrap();
        assert_eq!(of(1, 48_000, None), Shape { channels: 1, rate: 48_000, block: Some(240), exact: false });
        assert_eq!(
            of(3, 96_000, Some(256)),
            Shape { channels: 8, rate: 48_000, block: Some(128), exact: false }
        );
        assert_eq!(
            of(9, 22_050, Some(8)),
            Shape { channels: 8, rate: 44_100, block: Some(64), exact: false }
        );
        let deaf = Found { input: None, ..card };
        assert!(shape(&deaf, 1, 48_000, None).unwrap_err().to_string().contains("has no inputs"));
    }
}
