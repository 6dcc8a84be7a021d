//! A sound system that follows a script. Its devices keep real time in threads of their own, remember all that they are given, and fail
//! in the ways in which real ones do when they are told to.
#![allow(dead_code)]

use std::collections::VecDeque;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    Data, DeviceDescription, DeviceDescriptionBuilder, DeviceId, Error, ErrorKind, FrameCount, HostId, I24,
    InputCallbackInfo, InputStreamTimestamp, OutputCallbackInfo, OutputStreamTimestamp, SampleFormat,
    StreamConfig, StreamInstant, SupportedBufferSize, SupportedStreamConfig, SupportedStreamConfigRange,
};
use pacinian::io::device::hosts::Hosts;

/// What a device is.
#[derive(Debug, Clone)]
pub struct Make {
    /// Names it for good.
    pub id: &'static str,
    /// For people.
    pub name: &'static str,
    /// Numbers of channels that it plays; none: it does not.
    pub outputs: Vec<u16>,
    /// Numbers of channels that it hears; none: it does not.
    pub inputs: Vec<u16>,
    /// Frames a second, as it says.
    pub rate: u32,
    /// By how many millionths it is fast.
    pub fast: f64,
    /// Its formats of samples.
    pub formats: Vec<SampleFormat>,
    /// Lengths of its blocks, one after the other, again and again.
    pub blocks: Vec<usize>,
    /// What it hears: frames since the stream began, channel.
    pub heard: fn(u64, usize) -> f32,
}

impl Default for Make {
    fn default() -> Self {
        Self {
            id: "card",
            name: "Card",
            outputs: vec![2],
            inputs: vec![],
            rate: 48_000,
            fast: 0.0,
            formats: vec![SampleFormat::F32],
            blocks: vec![64],
            heard: |_, _| 0.0,
        }
    }
}

/// How a device behaves at the moment.
#[derive(Debug, Clone)]
pub struct Mood {
    /// It is plugged in.
    pub there: bool,
    /// It takes streams and does not call back.
    pub mute: bool,
    /// It goes on calling back when it has said that it is gone.
    pub undead: bool,
    /// So many times, another program has it when a stream is built.
    pub busy: u32,
    /// Another program has it, so that it does not even say what it offers.
    pub held: bool,
    /// To let go of a stream takes it so long.
    pub lets_go: Duration,
    /// It never lets go of what a stream was given.
    pub hangs: bool,
    /// It says that it is gone when a stream ends, and once more a while after that.
    pub last_words: bool,
    /// What it says before the next block.
    pub says: VecDeque<ErrorKind>,
    /// So many blocks are thrown away when they have been filled, and take no time.
    pub throws_away: u32,
}

/// What a stream was given.
#[derive(Debug, Clone, Default)]
pub struct Stretch {
    /// Samples as the device has them: of whole numbers, those.
    pub samples: Vec<f64>,
    /// Frames asked for before each callback, and when it came.
    pub callbacks: Vec<(u64, Instant)>,
    /// Samples that there were when it said that it is gone.
    pub gone: Option<usize>,
}

/// A device.
#[derive(Clone)]
pub struct Scripted(Arc<Inner>);

struct Inner {
    make: Make,
    mood: Mutex<Mood>,
    stretches: Mutex<Vec<Stretch>>,
}

fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Scripted {
    pub fn new(make: Make) -> Self {
        let mood = Mood {
            there: true,
            mute: false,
            undead: false,
            busy: 0,
            held: false,
            lets_go: Duration::ZERO,
            hangs: false,
            last_words: false,
            says: VecDeque::new(),
            throws_away: 0,
        };
        Self(Arc::new(Inner { make, mood: Mutex::new(mood), stretches: Mutex::default() }))
    }

    pub fn is(&self, change: impl FnOnce(&mut Mood)) {
        change(&mut open(&self.0.mood));
    }

    fn mood(&self) -> Mood {
        open(&self.0.mood).clone()
    }

    /// How many streams were opened on it so far.
    pub fn opened(&self) -> usize {
        open(&self.0.stretches).len()
    }

    /// Samples that the latest stream was given so far.
    pub fn length(&self) -> usize {
        open(&self.0.stretches).last().map_or(0, |last| last.samples.len())
    }

    /// What each stream was given.
    pub fn stretches(&self) -> Vec<Stretch> {
        open(&self.0.stretches).clone()
    }

    /// What the latest one was.
    pub fn latest(&self) -> Stretch {
        open(&self.0.stretches).last().cloned().unwrap_or_default()
    }

    fn configs(&self, counts: &[u16]) -> Result<std::vec::IntoIter<SupportedStreamConfigRange>, Error> {
        if self.mood().held {
            return Err(Error::new(ErrorKind::DeviceBusy));
        }
        let Make { rate, formats, .. } = &self.0.make;
        let blocks = SupportedBufferSize::Range { min: 16, max: 8192 };
        let range =
            |channels: u16, format| SupportedStreamConfigRange::new(channels, *rate, *rate, blocks, format);
        let all: Vec<_> = counts
            .iter()
            .flat_map(|n| formats.iter().map(move |format| (*n, *format)))
            .map(|(n, f)| range(n, f))
            .collect();
        Ok(all.into_iter())
    }

    fn build(
        &self,
        mut block: impl FnMut(usize, StreamInstant) -> Vec<f64> + Send + 'static,
        mut error: impl FnMut(Error) + Send + 'static,
    ) -> Result<Running, Error> {
        let mut mood = open(&self.0.mood);
        if !mood.there {
            return Err(Error::new(ErrorKind::DeviceNotAvailable));
        }
        if mood.held || mood.busy > 0 {
            mood.busy = mood.busy.saturating_sub(1);
            return Err(Error::new(ErrorKind::DeviceBusy));
        }
        drop(mood);
        let device = self.clone();
        let number = {
            let mut all = open(&self.0.stretches);
            all.push(Stretch::default());
            all.len() - 1
        };
        let (plays, ends, begin) =
            (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)), Instant::now());
        let (played, ended) = (Arc::clone(&plays), Arc::clone(&ends));
        let work = move || {
            let rate = f64::from(device.0.make.rate) * (1.0 + device.0.make.fast * 1e-6);
            let (mut paced, mut frames, mut since, mut gone) = (0_u64, 0_u64, None, false);
            let mut lengths = device.0.make.blocks.clone().into_iter().cycle();
            while !ended.load(Ordering::Acquire) {
                let mood = device.mood();
                if !mood.there && !gone {
                    gone = true;
                    let mut all = open(&device.0.stretches);
                    let stretch = &mut all[number];
                    stretch.gone = Some(stretch.samples.len());
                    drop(all);
                    error(Error::with_message(ErrorKind::DeviceNotAvailable, "Device disconnected"));
                }
                if !played.load(Ordering::Acquire) || mood.mute || (gone && !mood.undead) {
                    std::thread::sleep(Duration::from_millis(1));
                    continue;
                }
                let says = std::mem::take(&mut open(&device.0.mood).says);
                says.into_iter().for_each(|kind| error(Error::new(kind)));
                let length = lengths.next().unwrap_or(64);
                let from = *since.get_or_insert_with(Instant::now);
                let due = from + Duration::from_secs_f64(paced as f64 / rate);
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                let now = Instant::now();
                let samples = block(length, instant(begin, now));
                let mut all = open(&device.0.stretches);
                all[number].callbacks.push((frames, now));
                frames += length as u64;
                let mut mood = open(&device.0.mood);
                if mood.throws_away > 0 && length > 0 {
                    mood.throws_away -= 1;
                    continue;
                }
                paced += length as u64;
                all[number].samples.extend(samples);
            }
            if device.mood().last_words {
                error(Error::new(ErrorKind::DeviceNotAvailable));
                std::thread::spawn(move || {
                    std::thread::sleep(Duration::from_millis(150));
                    error(Error::new(ErrorKind::DeviceNotAvailable));
                });
            }
        };
        let thread = std::thread::Builder::new().name("scripted".into()).spawn(work).ok();
        Ok(Running { device: self.clone(), plays, ends, begin, thread })
    }
}

fn instant(begin: Instant, now: Instant) -> StreamInstant {
    let since = now.saturating_duration_since(begin);
    StreamInstant::new(since.as_secs(), since.subsec_nanos())
}

/// Samples in a format, as bytes of which a stream's data is made.
enum Samples {
    F32(Vec<f32>),
    I32(Vec<i32>),
    I24(Vec<I24>),
    I16(Vec<i16>),
}

impl Samples {
    fn silent(format: SampleFormat, length: usize) -> Self {
        match format {
            SampleFormat::F32 => Self::F32(vec![f32::NAN; length]),
            SampleFormat::I32 => Self::I32(vec![i32::MIN; length]),
            SampleFormat::I24 => Self::I24(vec![I24::new_unchecked(-8_388_608); length]),
            _ => Self::I16(vec![i16::MIN; length]),
        }
    }

    fn of(format: SampleFormat, values: impl Iterator<Item = f32>) -> Self {
        match format {
            SampleFormat::F32 => Self::F32(values.collect()),
            SampleFormat::I32 => Self::I32(values.map(|x| (f64::from(x) * 2_147_483_648.0) as i32).collect()),
            SampleFormat::I24 => {
                Self::I24(values.map(|x| I24::new_unchecked((f64::from(x) * 8_388_608.0) as i32)).collect())
            }
            _ => Self::I16(values.map(|x| (x * 32_768.0) as i16).collect()),
        }
    }

    fn data(&mut self) -> Data {
        // Each for as long as its samples stay where they are.
        unsafe {
            match self {
                Self::F32(all) => Data::from_parts(all.as_mut_ptr().cast(), all.len(), SampleFormat::F32),
                Self::I32(all) => Data::from_parts(all.as_mut_ptr().cast(), all.len(), SampleFormat::I32),
                Self::I24(all) => Data::from_parts(all.as_mut_ptr().cast(), all.len(), SampleFormat::I24),
                Self::I16(all) => Data::from_parts(all.as_mut_ptr().cast(), all.len(), SampleFormat::I16),
            }
        }
    }

    fn values(&self) -> Vec<f64> {
        match self {
            Self::F32(all) => all.iter().map(|x| f64::from(*x)).collect(),
            Self::I32(all) => all.iter().map(|x| f64::from(*x)).collect(),
            Self::I24(all) => all.iter().map(|x| f64::from(x.inner())).collect(),
            Self::I16(all) => all.iter().map(|x| f64::from(*x)).collect(),
        }
    }
}

/// A stream. It ends when it is dropped.
pub struct Running {
    device: Scripted,
    plays: Arc<AtomicBool>,
    ends: Arc<AtomicBool>,
    begin: Instant,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        if self.device.mood().hangs {
            return;
        }
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        std::thread::sleep(self.device.mood().lets_go);
    }
}

impl StreamTrait for Running {
    fn play(&self) -> Result<(), Error> {
        self.plays.store(true, Ordering::Release);
        Ok(())
    }

    fn pause(&self) -> Result<(), Error> {
        self.plays.store(false, Ordering::Release);
        Ok(())
    }

    fn now(&self) -> StreamInstant {
        instant(self.begin, Instant::now())
    }

    fn buffer_size(&self) -> Result<FrameCount, Error> {
        Ok(self.device.0.make.blocks.iter().copied().max().unwrap_or(64) as FrameCount)
    }
}

/// What the first of several blocks waits before it is played: of as long a block.
fn buffered(length: usize, rate: u32) -> Duration {
    Duration::from_secs_f64(length as f64 / f64::from(rate))
}

impl DeviceTrait for Scripted {
    type SupportedInputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type SupportedOutputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type Stream = Running;

    fn description(&self) -> Result<DeviceDescription, Error> {
        Ok(DeviceDescriptionBuilder::new(self.0.make.name).build())
    }

    fn id(&self) -> Result<DeviceId, Error> {
        Ok(DeviceId::new(HostId::Custom, self.0.make.id))
    }

    fn supported_input_configs(&self) -> Result<Self::SupportedInputConfigs, Error> {
        self.configs(&self.0.make.inputs)
    }

    fn supported_output_configs(&self) -> Result<Self::SupportedOutputConfigs, Error> {
        self.configs(&self.0.make.outputs)
    }

    fn default_input_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(Error::new(ErrorKind::UnsupportedConfig))
    }

    fn default_output_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(Error::new(ErrorKind::UnsupportedConfig))
    }

    fn build_input_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: SampleFormat,
        mut call: D,
        error: E,
        _: Option<Duration>,
    ) -> Result<Self::Stream, Error>
    where
        D: FnMut(&Data, &InputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        let (channels, heard) = (usize::from(config.channels), self.0.make.heard);
        let mut frames = 0;
        let block = move |length: usize, callback: StreamInstant| {
            let values = (0..length * channels).map(|n| heard(frames + (n / channels) as u64, n % channels));
            let mut samples = Samples::of(format, values);
            frames += length as u64;
            let capture = callback.checked_sub(buffered(length, config.sample_rate)).unwrap_or(callback);
            call(&samples.data(), &InputCallbackInfo::new(InputStreamTimestamp { callback, capture }));
            Vec::new()
        };
        self.build(block, error)
    }

    fn build_output_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: SampleFormat,
        mut call: D,
        error: E,
        _: Option<Duration>,
    ) -> Result<Self::Stream, Error>
    where
        D: FnMut(&mut Data, &OutputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        let channels = usize::from(config.channels);
        let block = move |length: usize, callback: StreamInstant| {
            let mut samples = Samples::silent(format, length * channels);
            let playback = callback + buffered(length, config.sample_rate);
            call(&mut samples.data(), &OutputCallbackInfo::new(OutputStreamTimestamp { callback, playback }));
            samples.values()
        };
        self.build(block, error)
    }
}

impl fmt::Display for Scripted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.make.name)
    }
}

impl fmt::Debug for Scripted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.make.id)
    }
}

impl PartialEq for Scripted {
    fn eq(&self, other: &Self) -> bool {
        self.0.make.id == other.0.make.id
    }
}

impl Eq for Scripted {}

impl Hash for Scripted {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.make.id.hash(state);
    }
}

/// A sound system of such devices.
#[derive(Clone)]
pub struct System {
    devices: Arc<Vec<Scripted>>,
    default: Arc<AtomicUsize>,
}

impl System {
    /// Of those, of which the first is played on where nobody says anything.
    pub fn of(devices: &[&Scripted]) -> Self {
        Self {
            devices: Arc::new(devices.iter().map(|device| (*device).clone()).collect()),
            default: Arc::default(),
        }
    }

    /// From now on another is.
    pub fn prefers(&self, number: usize) {
        self.default.store(number, Ordering::Release);
    }

    pub fn hosts(&self) -> Hosts {
        Hosts::of(cpal::platform::CustomHost::from_host(self.clone()).into())
    }

    fn default(&self, counts: impl Fn(&Make) -> usize) -> Option<Scripted> {
        let number = self.default.load(Ordering::Acquire);
        let there = |device: &&Scripted| device.mood().there && counts(&device.0.make) > 0;
        let rest = self.devices.iter().skip(number).chain(self.devices.iter());
        rest.clone().find(there).cloned()
    }
}

impl HostTrait for System {
    type Devices = std::vec::IntoIter<Scripted>;
    type Device = Scripted;

    fn is_available() -> bool {
        true
    }

    fn devices(&self) -> Result<Self::Devices, Error> {
        let there: Vec<_> = self.devices.iter().filter(|device| device.mood().there).cloned().collect();
        Ok(there.into_iter())
    }

    fn default_input_device(&self) -> Option<Self::Device> {
        self.default(|make| make.inputs.len())
    }

    fn default_output_device(&self) -> Option<Self::Device> {
        self.default(|make| make.outputs.len())
    }
}
