//! Sends probes round and reckons how long they took.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use cpal::Device;
use ringbuf::traits::{Consumer, Observer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};

use super::echo::{Echo, find};
use super::line::{Errors, Line};
use super::probe;
use crate::dsp::random;
use crate::io::device::capture::{Capture, Hear};
use crate::io::device::card::{Card, Fill, News, Shape};
use crate::io::device::failure::{DeviceError, Trouble};
use crate::io::device::list::Found;
use crate::live::board::Board;
use crate::live::stamp::Epoch;
use crate::live::steps::Steps;

/// Seconds from one probe to the next, more or less by up to so much; of silence before the first, and within which one must come back.
pub const EVERY: f64 = 0.49;
const UNEVEN: f64 = 0.09;
const BEFORE: f64 = 0.4;
const WITHIN: f64 = 0.3;
/// What the system says of its buffers may be too much by all of it and by so much, seconds: a loop within a server has none of them. More than
/// the second would reach into what came of the probe before.
const EARLY: f64 = 0.02;
const EARLIEST: f64 = 0.09;

/// Callbacks by which a stretch without a gap must be known.
const FEWEST: usize = 12;

/// And so many, after which the buffers have filled.
const SETTLING: usize = 16;

/// What is measured.
pub struct Loop {
    /// The device that plays, what is asked of it, and its channel, from 0.
    pub out: (Device, Found, Shape, usize),
    /// The device that hears, likewise.
    pub input: (Device, Found, Shape, usize),
    /// Largest sample of a probe.
    pub level: f64,
    /// How many probes are sent.
    pub count: usize,
}

/// A probe that went round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Round {
    /// When it went out, seconds since the first did.
    pub at: f64,
    /// How long it took, seconds.
    pub latency: f64,
    /// What of it came back, as a share.
    pub gain: f64,
}

/// What was measured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measured {
    /// Those that came back.
    pub rounds: Vec<Round>,
    /// Those that did not, or not clearly.
    pub unheard: usize,
    /// Those that a gap of a device fell into.
    pub broken: usize,
    /// Seconds that frames wait to be played, and that they waited after they were heard, as the system says; on the average.
    pub says: [f64; 2],
    /// By how much the clock of the device that hears is fast against that of the one that plays, as a share.
    pub drift: f64,
    /// How far the devices' times may be off, both together: seconds, and the share of `drift`.
    pub times: Errors,
    /// The largest sample that came in.
    pub peak: f32,
}

/// A callback: the number of its first frame, when it was played or heard as the system says, and the gaps before it.
#[derive(Debug, Clone, Copy)]
struct Callback {
    frame: u64,
    time: f64,
    delay: f64,
    gaps: u64,
}

struct Sender {
    frame: u64,
    /// The probe, and from where to where it is sent again and again.
    probe: Vec<f32>,
    every: u64,
    before: u64,
    count: u64,
    channel: usize,
    channels: usize,
    board: Arc<Board>,
    told: HeapProd<Callback>,
}

/// Seconds of silence before the first probe: until the buffers of both have filled.
fn before(blocks: [Option<u32>; 2], rates: [f64; 2]) -> f64 {
    let settles =
        |(block, rate): (Option<u32>, f64)| (SETTLING + 2) as f64 * f64::from(block.unwrap_or(0)) / rate;
    blocks.into_iter().zip(rates).map(settles).fold(BEFORE, f64::max) + EARLIEST
}

/// When, in frames since the beginning, probe `n` goes out: in step neither with the blocks nor with one another, so that what comes back of the one before
/// is at another place each time.
fn begins(n: u64, every: u64, before: u64) -> u64 {
    let apart = (every as f64 * UNEVEN / EVERY) as u64;
    before + n * every + ((u64::from(random::bits(0, n)) * apart) >> 32)
}

impl Fill for Sender {
    /// What is between two steps of the device is noise to what is measured.
    fn round_to(&mut self, _steps: Steps) {}

    fn begin(&mut self, _frames: usize, callback: f64, delay: f64) {
        let (time, gaps) = (callback + delay, self.board.xruns.get());
        // One that finds no room is missed by nobody.
        let _ = self.told.try_push(Callback { frame: self.frame, time, delay, gaps });
    }

    fn fill(&mut self, output: &mut [f32]) {
        for frame in output.chunks_exact_mut(self.channels) {
            frame.fill(0.0);
            // The latest that can have begun, or the one before.
            let latest = self.frame.saturating_sub(self.before) / self.every;
            for n in latest.saturating_sub(1)..=latest {
                let since =
                    self.frame.checked_sub(begins(n, self.every, self.before)).filter(|_| n < self.count);
                let value = since.and_then(|since| self.probe.get(since as usize));
                if let (Some(value), Some(slot)) = (value, frame.get_mut(self.channel)) {
                    *slot += value;
                }
            }
            self.frame += 1;
        }
    }
}

struct Recorder {
    frame: u64,
    callback: f64,
    channel: usize,
    channels: usize,
    board: Arc<Board>,
    told: HeapProd<Callback>,
    samples: HeapProd<f32>,
}

impl Hear for Recorder {
    fn begin(&mut self, callback: f64) {
        self.callback = callback;
    }

    fn hear(&mut self, delay: f64, frames: &[f32]) {
        let (time, gaps) = (self.callback - delay, self.board.input.xruns.get());
        let _ = self.told.try_push(Callback { frame: self.frame, time, delay, gaps });
        let count = frames.len() / self.channels;
        let kept = if self.samples.vacant_len() >= count {
            let channel = frames.iter().skip(self.channel).step_by(self.channels).copied();
            // Of a frame that is not whole nothing counts.
            self.samples.push_iter(channel.take(count))
        } else {
            0
        };
        self.board.input.lost.add((count - kept) as u64);
        self.frame += count as u64;
    }
}

/// A stretch of a stream without a gap.
struct Stretch {
    first: f64,
    last: f64,
    line: Line,
    errors: Errors,
}

fn stretches(callbacks: &[Callback]) -> Vec<Stretch> {
    // Before the buffers have filled, at the beginning and after a gap, what the system says of them is of no use.
    let settled = |part: &'_ [Callback]| part.len().min(SETTLING);
    let parts = callbacks.chunk_by(|a, b| a.gaps == b.gaps).map(|part| &part[settled(part)..]);
    let parts = parts.filter(|part| part.len() >= FEWEST);
    let parts: Vec<Vec<_>> =
        parts.map(|part| part.iter().map(|c| (c.frame as f64, c.time)).collect()).collect();
    // The clock is the same before a gap and after it, and the longest stretch knows it best.
    let longest = parts.iter().max_by_key(|points| points.len()).and_then(|points| Line::beneath(points));
    let stretch = |points: &Vec<(f64, f64)>| {
        let line = Line::rising(points, longest?.slope())?;
        let errors = line.errors(points).unwrap_or_default();
        Some(Stretch { first: points.first()?.0, last: points.last()?.0, line, errors })
    };
    parts.iter().filter_map(stretch).collect()
}

/// What comes of callbacks on both sides and of what was heard.
fn reckon(
    sent: &[Callback],
    heard: &[Callback],
    samples: &[f32],
    rates: [f64; 2],
    (before, count): (f64, usize),
) -> Measured {
    let (every, before) = ((EVERY * rates[0]) as u64, (before * rates[0]) as u64);
    let mut measured = Measured {
        peak: samples.iter().fold(0.0, |most, x| x.abs().max(most)),
        says: [sent, heard].map(|all| all.iter().map(|c| c.delay).sum::<f64>() / all.len().max(1) as f64),
        ..Measured::default()
    };
    let early = (EARLY + measured.says.iter().sum::<f64>()).clamp(EARLY, EARLIEST);
    let (plays, hears) = (stretches(sent), stretches(heard));
    let length = |s: &Stretch| s.last - s.first;
    let longest = |all: &[Stretch]| {
        all.iter().max_by(|a, b| length(a).total_cmp(&length(b))).map(|s| (s.line.slope(), s.errors))
    };
    if let (Some((out, of_out)), Some((input, of_input))) = (longest(&plays), longest(&hears)) {
        measured.drift = (out * rates[0]) / (input * rates[1]) - 1.0;
        measured.times = Errors {
            height: of_out.height.hypot(of_input.height),
            slope: of_out.slope.hypot(of_input.slope),
        };
    }
    let mut begun = None;
    for n in 0..count as u64 {
        let begin = begins(n, every, before) as f64;
        let end = begin + probe::SECONDS * rates[0];
        let playing = plays.iter().find(|s| s.first <= begin && end <= s.last);
        let hearing = playing.and_then(|playing| {
            let at = playing.line.at(begin);
            let find = |s: &&Stretch| {
                s.first <= s.line.place(at - early) && s.line.place(at + WITHIN + probe::SECONDS) <= s.last
            };
            Some((playing, at, hears.iter().find(find)?))
        });
        let Some((playing, at, hearing)) = hearing else {
            measured.broken += 1;
            continue;
        };
        let first = hearing.line.place(at - early).max(0.0) as usize;
        let last = (hearing.line.place(at + WITHIN + probe::SECONDS) as usize).min(samples.len());
        // Seconds by the clock of the device that plays, between two samples that are heard.
        let step = hearing.line.slope() / (playing.line.slope() * rates[0]);
        let echo = samples.get(first..last).and_then(|part| find(part, step));
        match echo.filter(Echo::is_clear) {
            Some(Echo { at: place, gain, .. }) => {
                let latency = hearing.line.at(first as f64 + place) - at;
                let since = at - *begun.get_or_insert(at);
                measured.rounds.push(Round { at: since, latency, gain });
            }
            None => measured.unheard += 1,
        }
    }
    measured
}

/// Measures. `go_on` is asked several times a second, with the share that is done.
///
/// # Errors
/// A device that does not open or goes away, and a machine that cannot keep up. `None`: it was not to go on.
pub fn measure(what: &Loop, mut go_on: impl FnMut(f64) -> bool) -> Result<Option<Measured>, DeviceError> {
    let (device, found, shape, channel_out) = &what.out;
    let (ear, heard_of, ears, channel_in) = &what.input;
    let (board, epoch) = (Arc::new(Board::new(shape.channels)), Epoch::begin());
    let (news, told) = channel();
    // Nobody hears what is said once it is over.
    let tell = || {
        let news = news.clone();
        move |what| drop(news.send(what))
    };
    let rates = [f64::from(shape.rate), f64::from(ears.rate)];
    let (sent_in, mut sent_out) = ring(1 << 14);
    let (heard_in, mut heard_out) = ring(1 << 14);
    let (samples_in, mut samples_out) = ring((4.0 * rates[1]) as usize);
    let before = before([shape.block, ears.block], rates);
    let length = (probe::SECONDS * rates[0]).ceil() as usize;
    let sender = Sender {
        frame: 0,
        probe: (0..length).map(|n| (what.level * probe::at(n as f64 / rates[0])) as f32).collect(),
        every: (EVERY * rates[0]) as u64,
        before: (before * rates[0]) as u64,
        count: what.count as u64,
        channel: *channel_out,
        channels: shape.channels,
        board: Arc::clone(&board),
        told: sent_in,
    };
    let recorder = Recorder {
        frame: 0,
        callback: 0.0,
        channel: *channel_in,
        channels: ears.channels,
        board: Arc::clone(&board),
        told: heard_in,
        samples: samples_in,
    };
    let listening = Capture::open(ear, heard_of, *ears, recorder, &board, tell())?;
    let playing = Card::open(device, found, *shape, sender, &board, tell())?;
    let (mut sent, mut heard, mut samples) = (Vec::new(), Vec::new(), Vec::<f32>::new());
    let seconds = before + what.count as f64 * EVERY + WITHIN + 0.3;
    let (begin, mut frames) = (Instant::now(), 0);
    let mut since = Instant::now();
    loop {
        std::thread::sleep(Duration::from_millis(20));
        sent.extend(sent_out.pop_iter());
        heard.extend(heard_out.pop_iter());
        samples.extend(samples_out.pop_iter());
        while let Ok(news) = told.try_recv() {
            match news {
                News::Lost(why) | News::Broke(why) => {
                    let what = format!("a device went away while it was measured: {why}");
                    return Err(
                        DeviceError::new(Trouble::Missing, what).help("plug it in, and measure again")
                    );
                }
                News::Moved => {
                    let what = "the system moved a stream to another device";
                    return Err(DeviceError::new(Trouble::Other, what).help("measure again"));
                }
                News::Said(_) => {}
            }
        }
        if board.input.lost.get() > 0 {
            let what = "this machine does not keep up with its inputs";
            return Err(
                DeviceError::new(Trouble::Other, what).help("close other programs, and measure again")
            );
        }
        let now = (sent.len(), heard.len());
        if std::mem::replace(&mut frames, now.0.min(now.1)) != now.0.min(now.1) {
            since = Instant::now();
        }
        if since.elapsed() > Duration::from_secs(3) {
            let who = if now.0 <= now.1 { &found.name } else { &heard_of.name };
            let what = format!("{who} was opened but does nothing");
            return Err(DeviceError::new(Trouble::Other, what).help("unplug it and plug it in again"));
        }
        let done = sent.last().map_or(0.0, |last: &Callback| last.frame as f64 / rates[0] / seconds);
        if !go_on(done.min(1.0)) {
            return Ok(None);
        }
        if done >= 1.0 || begin.elapsed().as_secs_f64() > 2.0 * seconds + 5.0 {
            break;
        }
    }
    // Each stream has a clock of its own, which began with it.
    let now = || epoch.now().seconds();
    let apart = listening.behind(now) - playing.behind(now);
    drop(playing);
    drop(listening);
    heard.iter_mut().for_each(|callback| callback.time += apart);
    let mut measured = reckon(&sent, &heard, &samples, rates, (before, what.count));
    measured.rounds.iter_mut().for_each(|round| round.gain /= what.level);
    Ok(Some(measured))
}

fn ring<T>(room: usize) -> (HeapProd<T>, HeapCons<T>) {
    HeapRb::new(room).split()
}

#[cfg(test)]
mod tests {
    use super::{BEFORE, Callback, EARLIEST, EVERY, SETTLING, before, begins, probe, reckon};

    /// Callbacks of a device of `rate` from `begin` on, each a little late by the numbers `late` gives; the true moment is `sign` times
    /// the delay away.
    fn callbacks(rate: f64, block: u64, begin: f64, seconds: f64, sign: f64) -> Vec<Callback> {
        let count = (seconds * rate) as u64 / block;
        let late = |n: u64| (n * 7919 % 101) as f64 * 2e-6;
        (0..count)
            .map(|n| {
                let time = begin + (n * block) as f64 / rate + late(n);
                Callback {
                    frame: n * block,
                    time,
                    delay: 0.01 * sign.abs(),
                    gaps: u64::from(n * 3 > count * 2),
                }
            })
            .collect()
    }

    #[test]
    fn a_known_loop_is_reckoned_within_a_hundredth_of_a_sample_at_whatever_clocks() {
        let seconds = 12.0;
        for (nominal, fast) in [(48_000.0, 0.0), (48_000.0, 300e-6), (44_100.0, -200e-6)] {
            for latency in [0.001_234_5, 0.0, 0.25, -0.005, -0.035] {
                let (out, input) = (48_000.0, nominal * (1.0 + fast));
                let sent = callbacks(out, 256, 3.0, seconds, 1.0);
                let heard = callbacks(input, 200, 2.9, seconds + 1.0, -1.0);
                let count = 20;
                let went: Vec<f64> = (0..count)
                    .map(|n| {
                        3.0 + begins(n, (EVERY * out) as u64, (BEFORE * out) as u64) as f64 / out + latency
                    })
                    .collect();
                let samples: Vec<f32> = (0..(input * (seconds + 0.9)) as u64)
                    .map(|n| {
                        let time = 2.9 + n as f64 / input;
                        let last = went.partition_point(|at| *at <= time);
                        let value = last.checked_sub(1).map_or(0.0, |n| probe::at(time - went[n]));
                        (-0.01 * value) as f32
                    })
                    .collect();
                let measured = reckon(&sent, &heard, &samples, [out, nominal], (BEFORE, count as usize));
                // Two of the streams' gaps fall into probes.
                assert!(measured.rounds.len() >= 15 && measured.unheard == 0, "{measured:?}");
                assert_eq!(measured.rounds.len() + measured.broken, count as usize);
                for round in &measured.rounds {
                    assert!((round.latency - latency).abs() < 0.01 / 48_000.0, "{latency}: {round:?}");
                    assert!((round.gain + 0.01).abs() < 1e-4, "{round:?}");
                }
                assert!((measured.drift - fast).abs() < 1e-7, "{}", measured.drift);
            }
        }
    }

    /// A loop that is longer than what is looked at: the echo of a probe falls to the next one, at another place each time, so that it is no measurement.
    #[test]
    fn a_loop_that_is_too_long_is_no_short_one() {
        let (rate, count, seconds) = (48_000.0, 25, 14.0);
        for latency in [0.35, 0.5, 0.6, 1.2] {
            let (sent, heard) = [(3.0, 1.0), (2.9, -1.0)]
                .map(|(begin, sign)| callbacks(rate, 256, begin, seconds + 1.0, sign))
                .into();
            let went: Vec<f64> = (0..count)
                .map(|n| {
                    3.0 + begins(n, (EVERY * rate) as u64, (BEFORE * rate) as u64) as f64 / rate + latency
                })
                .collect();
            let samples: Vec<f32> = (0..(rate * (seconds + 0.9)) as u64)
                .map(|n| {
                    let time = 2.9 + n as f64 / rate;
                    let last = went.partition_point(|at| *at <= time);
                    last.checked_sub(1).map_or(0.0, |n| 0.1 * probe::at(time - went[n]) as f32)
                })
                .collect();
            let mut measured = reckon(&sent, &heard, &samples, [rate; 2], (BEFORE, count as usize));
            measured.leave_out_strays();
            let doubt = measured.figures().doubt(measured.drift);
            assert!(doubt.is_some(), "{latency}: {:?} of {measured:?}", measured.figures());
        }
    }

    /// One clock, callbacks late by chance: no drift but what the margin allows, 95 times in 100.
    #[test]
    fn a_loop_of_one_clock_does_not_drift() {
        let mut seed = 3_u64;
        let mut late = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1e-3 * ((seed >> 11) as f64 / (1_u64 << 53) as f64).powi(2)
        };
        let (rate, count, cable) = (48_000.0, 6, 100.0 / 48_000.0);
        let went =
            |n: u64| 3.0 + begins(n, (EVERY * rate) as u64, (BEFORE * rate) as u64) as f64 / rate + cable;
        let samples: Vec<f32> = (0..(4.2 * rate) as u64)
            .map(|n| {
                let time = 2.9 + n as f64 / rate;
                (0..count)
                    .rev()
                    .find(|n| went(*n) <= time)
                    .map_or(0.0, |n| 0.1 * probe::at(time - went(n)) as f32)
            })
            .collect();
        let (mut drifts, sets) = (0, 40);
        for _ in 0..sets {
            let mut device = |begin: f64, seconds: f64| -> Vec<Callback> {
                (0..(seconds * rate) as u64 / 256)
                    .map(|n| {
                        let time = begin + (n * 256) as f64 / rate + late();
                        Callback { frame: n * 256, time, delay: 0.01, gaps: 0 }
                    })
                    .collect()
            };
            let measured =
                reckon(&device(3.0, 3.9), &device(2.9, 4.2), &samples, [rate; 2], (BEFORE, count as usize));
            assert_eq!(measured.rounds.len(), count as usize, "{measured:?}");
            let figures = measured.figures();
            drifts += i32::from(figures.drifts() == Some(true));
            let off = (figures.mean - cable).abs();
            assert!(off < 1.5 * figures.mean_margin.unwrap(), "{off} {:?}", figures.mean_margin);
            assert!(figures.margin.unwrap() < 500e-6, "{:?}", figures.margin);
        }
        assert!(drifts <= 6, "{drifts} of {sets}");
    }

    #[test]
    fn nothing_that_comes_back_is_not_taken_for_something() {
        let (sent, heard) = (callbacks(48e3, 256, 3.0, 10.0, 1.0), callbacks(48e3, 256, 3.0, 10.0, -1.0));
        let hum: Vec<f32> = (0..480_000).map(|n| (n as f32 * 0.0065).sin()).collect();
        for samples in [vec![0.0; 480_000], hum, vec![]] {
            let measured = reckon(&sent, &heard, &samples, [48e3; 2], (BEFORE, 20));
            assert!(measured.rounds.is_empty() && measured.unheard + measured.broken == 20, "{measured:?}");
        }
        assert_eq!(reckon(&[], &[], &[], [48e3; 2], (BEFORE, 3)).broken, 3);
    }

    #[test]
    fn the_first_probe_waits_until_buffers_have_filled() {
        let at = |blocks| before(blocks, [48_000.0, 44_100.0]);
        assert_eq!(at([Some(64), None]), BEFORE + EARLIEST);
        let of = |block: f64, rate: f64| (SETTLING + 2) as f64 * block / rate + EARLIEST;
        assert!((at([Some(4096), Some(64)]) - of(4096.0, 48e3)).abs() < 1e-12);
        assert!((at([Some(64), Some(4096)]) - of(4096.0, 44.1e3)).abs() < 1e-12);
    }
}
