//! The board on which the audio thread shows how things stand, for all to read. Neither side ever waits for the other.

#![deny(clippy::disallowed_methods)]

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use super::cables::Cables;
use super::device_delay::DeviceDelay;
use super::lever::Lever;
use super::load::Load;
use super::midi_board::MidiBoard;
use super::torque::Torque;
use super::values::Values;
use super::way::Refusals;
use crate::engine::knob::tally::Tally;

/// A figure that one thread writes and others read.
#[derive(Debug, Default)]
pub struct Figure(AtomicU64);

impl Figure {
    /// What it shows.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    /// Shows something else.
    pub fn set(&self, value: u64) {
        self.0.store(value, Ordering::Relaxed);
    }

    /// Counts on.
    pub fn add(&self, more: u64) {
        if more != 0 {
            self.0.fetch_add(more, Ordering::Relaxed);
        }
    }
}

/// How it stands with what a session hears.
#[derive(Debug, Default)]
pub struct InputBoard {
    /// Frames that the device has brought.
    pub frames: Figure,
    /// Nanoseconds from when the device heard a frame to when the engine is given it; 0 while it is given silence.
    pub latency: Figure,
    /// Nanoseconds from when the device heard the first frame of a block to when it handed it over, as it has it.
    pub device_delay: Figure,
    /// Times that nothing was there when it was due.
    pub dry: Figure,
    /// Times that so much waited that some was left out.
    pub jumps: Figure,
    /// Frames that found no room, since nobody fetched any.
    pub lost: Figure,
    /// Gaps that the device told of.
    pub xruns: Figure,
    /// Frames given to the device that plays before the last of them.
    pub xrun_at: Figure,
    /// Frames that the recording of what was heard missed.
    pub unrecorded: Figure,
}

/// Of counts with their words, those that are not 0, in a list; `None` if all are.
pub(crate) fn in_words(counted: &[(&str, u64, &str)]) -> Option<String> {
    let told = counted.iter().filter(|(_, count, _)| *count != 0);
    let told: Vec<String> = told.map(|(_, count, words)| format!("{count} {words}")).collect();
    (!told.is_empty()).then(|| told.join(", "))
}

/// What a knob said and was given last.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turned {
    /// As it is read, radians.
    pub angle: f64,
    /// As it is estimated, rad/s.
    pub speed: f64,
    /// N m.
    pub torque: f64,
}

/// How a session stands.
#[derive(Debug, Default)]
pub struct Board {
    /// What is wanted of the gate.
    pub lever: Lever,
    /// By channel: the largest magnitude since it was fetched last, as bits of a number that is never negative.
    peaks: Vec<AtomicU32>,
    /// The same for whoever sends them on, so that the two do not take them from each other.
    sent_peaks: Vec<AtomicU32>,
    /// Frames given to the device.
    pub frames: Figure,
    /// 1 where what computes has panicked: silence from there on.
    pub faults: Figure,
    /// The next engine sample.
    pub clock: Figure,
    /// Voices that sound.
    pub voices: Figure,
    /// Voices started so far.
    pub started: Figure,
    /// Voices that had to make room.
    pub stolen: Figure,
    /// Events that came too late for their instant and took effect with the next sample.
    pub late: Figure,
    /// Events for which the engine had no room, and orders for which a motor had none.
    pub dropped: Figure,
    /// Frames that nobody felt, as the device was away.
    pub away: Figure,
    /// One more than the frames before it went that is away; 0 while it is there.
    pub away_since: Figure,
    /// Samples that were no numbers.
    pub masked: Figure,
    /// Samples that were cut at full scale.
    pub clamped: Figure,
    /// Samples that the limiter turned down.
    pub limited: Figure,
    /// Samples that were held back for the sake of actuators.
    pub held_back: Figure,
    /// Signals and patterns that found no room, by where they came from.
    pub refused: Refusals,
    /// Times that something was asked for and could not be done.
    pub undone: Figure,
    /// Frames that the recording missed.
    pub unrecorded: Figure,
    /// Things done that the log did not hear of.
    pub untold: Figure,
    /// Frames before which everything that was done has been told.
    pub told: Figure,
    /// 0 while all periodic tasks run; where there is too much to do, 255 less the rank above which they rest.
    pub shed: Figure,
    /// Whether the gate is shut: 1, or 0.
    pub shut: Figure,
    /// Where controls stand.
    pub values: Values,
    /// Of a knob that is there, see [`Board::torque`].
    pub(super) knob: Figure,
    /// Of a knob, there or simulated, see [`Board::knob`]: its ticks, and bits of its angle, speed and torque.
    pub(super) turned: [Figure; 4],
    /// What that did so far, see [`Board::tally`].
    pub(super) tally: [Figure; Tally::NUMBERS],
    /// Run time of the callbacks.
    pub load: Load,
    /// Gaps that the device told of.
    pub xruns: Figure,
    /// Frames given to the device before the last of them.
    pub xrun_at: Figure,
    /// Frames of the last block.
    pub block: Figure,
    /// From a callback to when the device plays its first frame, as the device has it.
    pub device_delay: DeviceDelay,
    /// Nanoseconds from an event to the middle of what it makes at the output, at 250 Hz.
    pub engine_delay: Figure,
    /// What comes over MIDI.
    pub midi: MidiBoard,
    /// Its cables.
    pub(super) cables: Cables,
    /// What it hears.
    pub input: InputBoard,
}

impl Board {
    /// Frames that nobody felt so far, as the device was away, and whether it is.
    pub fn absence(&self) -> (u64, bool) {
        let since = self.away_since.get();
        let now = if since > 0 { (self.frames.get() + 1).saturating_sub(since) } else { 0 };
        (self.away.get() + now, since > 0)
    }

    /// The device has told of a gap.
    pub fn gap(&self) {
        self.xrun_at.set(self.frames.get());
        self.xruns.add(1);
    }

    /// The device that is listened to has.
    pub fn gap_of_input(&self) {
        self.input.xrun_at.set(self.frames.get());
        self.input.xruns.add(1);
    }

    /// For so many channels.
    pub fn new(channels: usize) -> Self {
        let peaks = || (0..channels).map(|_| AtomicU32::new(0)).collect();
        Self { peaks: peaks(), sent_peaks: peaks(), ..Self::default() }
    }

    /// As [`Lever::panic`].
    pub fn panic(&self) {
        self.lever.panic(0);
    }

    /// As [`Lever::calm`].
    pub fn calm(&self) {
        self.lever.calm();
    }

    /// Nobody listens to a port of MIDI any more: its cable is free of what it had promised.
    pub(crate) fn forget_cable(&self, port: u16) {
        self.cables.take_promise(port);
    }

    /// As [`Lever::is_panicked`].
    pub fn is_panicked(&self) -> bool {
        self.lever.is_panicked()
    }

    /// How it stands with a knob's torque.
    pub fn torque(&self) -> Torque {
        Torque::of_figure(self.knob.get())
    }

    /// Where a knob is and what it gives, once it has ticked.
    pub fn knob(&self) -> Option<Turned> {
        let [ticks, angle, speed, torque] = &self.turned;
        let of = |figure: &Figure| f64::from_bits(figure.get());
        (ticks.get() > 0).then(|| Turned { angle: of(angle), speed: of(speed), torque: of(torque) })
    }

    /// What a knob did so far, there or simulated, once it has ticked. While a session runs, parts of it may be a block apart.
    pub fn tally(&self) -> Option<Tally> {
        self.knob()?;
        Some(Tally::of(&std::array::from_fn(|n| self.tally[n].get())))
    }

    /// Channels.
    pub fn channels(&self) -> usize {
        self.peaks.len()
    }

    /// The largest magnitude that went out on a channel (from 0) since this was asked last, by whichever thread.
    pub fn take_peak(&self, channel: usize) -> f32 {
        self.peaks.get(channel).map_or(0.0, |peak| f32::from_bits(peak.swap(0, Ordering::Relaxed)))
    }

    /// As [`Board::take_peak`], since it was asked here last: for meters that are sent on.
    pub fn take_sent_peak(&self, channel: usize) -> f32 {
        self.sent_peaks.get(channel).map_or(0.0, |peak| f32::from_bits(peak.swap(0, Ordering::Relaxed)))
    }

    /// Notes the peaks of interleaved frames.
    pub(super) fn meter(&self, frames: &[f32], channels: usize) {
        match ABREAST.is_multiple_of(channels) {
            true => self.meter_narrow(frames, channels),
            false => self.meter_wide(frames, channels),
        }
    }

    /// Where whole frames stand in a row.
    fn meter_narrow(&self, frames: &[f32], channels: usize) {
        let mut peaks = [0.0_f32; ABREAST];
        let (rows, rest) = frames.as_chunks::<ABREAST>();
        for row in rows {
            (0..ABREAST).for_each(|lane| rise(&mut peaks[lane], row[lane]));
        }
        peaks.iter_mut().zip(rest).for_each(|(peak, value)| rise(peak, *value));
        let (first, others) = peaks.split_at_mut(channels);
        for frame in others.chunks_exact(channels) {
            first.iter_mut().zip(frame).for_each(|(peak, value)| rise(peak, *value));
        }
        self.show_peaks(0, first);
    }

    /// Where a frame is longer than a row or does not divide it.
    fn meter_wide(&self, frames: &[f32], channels: usize) {
        const HALF: usize = ABREAST / 2;
        for first in (0..channels).step_by(HALF) {
            let mut peaks = [0.0_f32; HALF];
            for frame in frames.chunks_exact(channels) {
                match frame[first..].first_chunk::<HALF>() {
                    Some(row) => (0..HALF).for_each(|lane| rise(&mut peaks[lane], row[lane])),
                    None => {
                        peaks.iter_mut().zip(&frame[first..]).for_each(|(peak, value)| rise(peak, *value))
                    }
                }
            }
            self.show_peaks(first, &peaks);
        }
    }

    /// Peaks of the channels from `first` on.
    fn show_peaks(&self, first: usize, peaks: &[f32]) {
        for cells in [&self.peaks, &self.sent_peaks] {
            for (cell, peak) in cells.iter().skip(first).zip(peaks) {
                // To look costs less than to exchange, and others only ever take.
                if *peak > f32::from_bits(cell.load(Ordering::Relaxed)) {
                    cell.fetch_max(peak.to_bits(), Ordering::Relaxed);
                }
            }
        }
    }
}

/// Samples that are looked at side by side.
const ABREAST: usize = 16;

/// Not-a-number has no size.
#[inline(always)]
fn rise(peak: &mut f32, value: f32) {
    let size = value.abs();
    *peak = if size > *peak { size } else { *peak };
}

#[cfg(test)]
mod tests {
    use super::Board;

    #[test]
    fn peaks_are_those_of_their_channel_and_are_seen_once() {
        for channels in [1, 2, 3, 4, 8, 16, 17, 24, 32, 40] {
            for count in [1, 5, 10] {
                let board = Board::new(channels);
                let own = |channel: usize| (channel + 1) as f32 / 64.0;
                let mut frames = vec![1e-3; channels * count];
                for channel in 0..channels {
                    frames[7 * channel % count * channels + channel] =
                        own(channel) * [1.0, -1.0][channel % 2];
                }
                board.meter(&frames, channels);
                board.meter(&vec![f32::NAN; channels], channels);
                board.meter(&vec![-0.01; channels], channels);
                for channel in 0..channels {
                    assert_eq!(board.take_peak(channel), own(channel), "{channel} of {channels}");
                    assert_eq!(board.take_peak(channel), 0.0);
                    // Whoever sends them on has not had any yet.
                    assert_eq!(
                        (board.take_sent_peak(channel), board.take_sent_peak(channel)),
                        (own(channel), 0.0)
                    );
                }
                assert_eq!(board.take_peak(channels), 0.0);
            }
        }
    }
}
