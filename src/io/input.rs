//! Audio input from a file: what the nodes `input` hear where there is no sound card.

use super::assets::check_rate;
use super::error::FileError;
use super::resample::Converter;
use super::wav::WavReader;
use crate::io::error::FileErrorKind;
use crate::knob::angle::decoder::NOT_HEARD;
use std::path::Path;

/// Samples of all channels together that are held, at most.
const MOST: u64 = 1 << 28;

/// A WAV file at a device's rate, as input for an engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// By input channel; empty for one that nobody listens to or the file does not have.
    channels: Vec<Vec<f32>>,
    /// Channels that are listened to, from 0.
    wanted: Vec<usize>,
    file_channels: usize,
    file_rate: u32,
    frames: usize,
    rate: f64,
    /// Channels that a knob's sensor hears: silence there would say an angle.
    marked: Vec<usize>,
}

impl Input {
    /// Reads the channels `wanted` (from 0) of the file at `path` and brings them to `rate` (Hz). Channels that the file does not
    /// have are silence.
    ///
    /// # Errors
    /// As [`WavReader`], when its rate is not from 1 to 384 kHz, and when more than 2²⁸ samples (1 GiB) would come of it.
    pub fn open(path: &Path, rate: f64, wanted: &[usize]) -> Result<Self, FileError> {
        Self::open_for(path, rate, wanted, None)
    }

    /// As [`Input::open`], but what is heard is right for the first `seconds` alone, where some are given; no more is read.
    ///
    /// # Errors
    /// As [`Input::open`].
    pub fn open_for(
        path: &Path,
        rate: f64,
        wanted: &[usize],
        seconds: Option<f64>,
    ) -> Result<Self, FileError> {
        let mut reader = WavReader::open(path)?;
        let info = reader.info();
        check_rate(path, info.rate)?;
        let unusable = |what: String| {
            let message = format!("`{}` cannot be used: {what}", path.display());
            FileError::new(FileErrorKind::Malformed, message)
        };
        let from = f64::from(info.rate);
        let mut channels = vec![Vec::new(); wanted.iter().max().map_or(0, |most| most + 1)];
        let mut frames = (info.frames as f64 * rate / from).ceil() as usize;
        let heard: Vec<usize> = wanted.iter().copied().filter(|c| *c < info.channels).collect();
        for &channel in &heard {
            let mut converter = Converter::new(from, rate).map_err(unusable)?;
            frames = usize::try_from(converter.length(info.frames)).unwrap_or(usize::MAX);
            let needed = |seconds: f64| (seconds * from).ceil() as u64 + converter.margin();
            let taken = seconds.map_or(info.frames, |seconds| needed(seconds).min(info.frames));
            let held = converter.length(taken);
            if held.saturating_mul(heard.len() as u64) > MOST {
                let count = heard.len();
                return Err(unusable(format!(
                    "{count} times {held} samples at {rate} Hz are more than the {MOST} that are taken into memory: \
                     cut the file, render less of it with --duration, or at a lower --rate"
                )));
            }
            converter.reserve(taken).map_err(unusable)?;
            reader.read(channel + 1, taken, |x| converter.push(x))?;
            channels[channel] = converter.finish().map_err(unusable)?;
            if let Some(seconds) = seconds {
                // What is behind lacks what follows it.
                channels[channel].truncate((seconds * rate).ceil() as usize);
            }
        }
        let (file_channels, file_rate) = (info.channels, info.rate);
        Ok(Self {
            channels,
            wanted: wanted.to_vec(),
            file_channels,
            file_rate,
            frames,
            rate,
            marked: Vec::new(),
        })
    }

    /// What is not there on these channels (from 0), before it begins and after it ends, is [`NOT_HEARD`] and no silence.
    pub fn marking(self, channels: &[usize]) -> Self {
        Self { marked: channels.to_vec(), ..self }
    }

    /// What was marked.
    pub fn marked(&self) -> &[usize] {
        &self.marked
    }

    /// Its length in seconds.
    pub fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    /// Channels of the file.
    pub fn file_channels(&self) -> usize {
        self.file_channels
    }

    /// Frames a second in the file, Hz.
    pub fn file_rate(&self) -> u32 {
        self.file_rate
    }

    /// Channels (from 0) that are listened to and that the file does not have: they are silence.
    pub fn missing(&self) -> impl Iterator<Item = usize> {
        self.wanted.iter().copied().filter(|channel| *channel >= self.file_channels)
    }

    /// By input channel: all samples at the device's rate. One that is not there is empty.
    pub fn channels(&self) -> &[Vec<f32>] {
        &self.channels
    }

    /// Fills `frames`, interleaved frames of `channels`, with what is heard from device frame `first` on; silence after its end, but for
    /// channels that are [marked](Input::marking).
    pub fn fill(&self, first: u64, channels: usize, frames: &mut [f32]) {
        for (n, frame) in frames.chunks_mut(channels.max(1)).enumerate() {
            let at = usize::try_from(first).unwrap_or(usize::MAX).saturating_add(n);
            for (channel, value) in frame.iter_mut().enumerate() {
                let heard = self.channels.get(channel).and_then(|c| c.get(at)).copied();
                let nothing = || if self.marked.contains(&channel) { NOT_HEARD } else { 0.0 };
                *value = heard.unwrap_or_else(nothing);
            }
        }
    }
}

/// A file as what a session hears, from its first frame on.
#[cfg(feature = "live")]
pub struct Heard {
    input: std::sync::Arc<Input>,
    frames: u64,
}

#[cfg(feature = "live")]
impl Heard {
    /// From the beginning.
    pub fn new(input: std::sync::Arc<Input>) -> Self {
        Self { input, frames: 0 }
    }
}

#[cfg(feature = "live")]
impl crate::live::intake::Hearing for Heard {
    fn hear(&mut self, _due: f64, channels: usize, frames: &mut [f32]) {
        self.input.fill(self.frames, channels, frames);
        self.frames += (frames.len() / channels.max(1)) as u64;
    }

    /// The file knows that already.
    fn mark(&mut self, _channels: &[usize]) {}
}

#[cfg(test)]
mod tests {
    use super::Input;
    use crate::io::wav::{Encoding, WavSpec, WavWriter};
    use std::path::PathBuf;

    /// A file of two channels: a steady one and one at 100 Hz.
    fn file(name: &str, rate: u32) -> PathBuf {
        let path = std::env::temp_dir().join(format!("pacinian-input-{name}-{}.wav", std::process::id()));
        let mut wav = WavWriter::create(&path, WavSpec::new(2, rate, Encoding::F32)).unwrap();
        let tone = |n: u32| (std::f64::consts::TAU * 100.0 * f64::from(n) / f64::from(rate)).sin() as f32;
        let frames: Vec<f32> = (0..rate).flat_map(|n| [0.25, tone(n)]).collect();
        wav.write(&frames).unwrap();
        wav.finish().unwrap();
        path
    }

    #[test]
    fn channels_come_at_the_device_rate_and_those_that_are_missing_are_silence() {
        let path = file("rate", 22_050);
        let input = Input::open(&path, 48_000.0, &[1, 4]).unwrap();
        std::fs::remove_file(path).unwrap();
        assert_eq!(input.missing().collect::<Vec<_>>(), [4]);
        assert_eq!((input.file_channels(), input.file_rate(), input.seconds()), (2, 22_050, 1.0));
        let mut frames = vec![f32::NAN; 5 * 1000];
        input.fill(24_000, 5, &mut frames);
        for (n, frame) in frames.chunks(5).enumerate() {
            let exact = (std::f64::consts::TAU * 100.0 * (24_000 + n) as f64 / 48_000.0).sin();
            assert!((f64::from(frame[1]) - exact).abs() < 1e-4, "frame {n}: {}", frame[1]);
            // Channel 1 is not listened to, so it is not read.
            assert_eq!([frame[0], frame[2], frame[3], frame[4]], [0.0; 4]);
        }
        input.fill(47_999, 5, &mut frames);
        assert!(frames[1] != 0.0 && frames[5..].iter().all(|x| *x == 0.0), "silence after the end");
    }

    #[test]
    fn the_beginning_is_the_same_when_no_more_is_read() {
        let path = file("part", 22_050);
        let whole = Input::open(&path, 48_000.0, &[0, 1]).unwrap();
        for seconds in [1e-4, 0.25, 0.9, 1.0, 7.0] {
            let part = Input::open_for(&path, 48_000.0, &[0, 1], Some(seconds)).unwrap();
            assert_eq!((part.seconds(), part.missing().count()), (whole.seconds(), 0));
            for (part, whole) in part.channels().iter().zip(whole.channels()) {
                assert_eq!(part.len(), whole.len().min((seconds * 48_000.0).ceil() as usize));
                assert!(part.iter().zip(whole).all(|(a, b)| a.to_bits() == b.to_bits()), "{seconds} s");
            }
        }
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_file_that_nobody_listens_to_still_has_its_length() {
        let path = file("none", 8_000);
        let input = Input::open(&path, 44_100.0, &[]).unwrap();
        std::fs::remove_file(path).unwrap();
        assert_eq!((input.seconds(), input.channels().len()), (1.0, 0));
    }
}
