//! A replay against a recording of the same session.

use super::failure::Failure;
use super::replay::Run;
use super::table::grouped;
use pacinian::io::wav::WavReader;
use serde::Serialize;
use std::path::Path;

/// What is different from a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The recording, by its path.
    pub recording: String,
    /// Whether no sample differs, and no frame is missing on either side.
    pub identical: bool,
    /// Frames that both have.
    frames: u64,
    /// Frames that only the recording has, behind all others.
    only_recorded: u64,
    /// Frames that only the replay has.
    only_replayed: u64,
    /// Samples that differ.
    different: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    first: Option<Difference>,
    /// The largest difference.
    largest: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    frame: u64,
    /// From 1.
    channel: usize,
    recorded: f32,
    replayed: f32,
}

/// Compares every sample with those of a recording, by their bits.
///
/// # Errors
/// A recording that cannot be read or is of another kind, and what goes wrong with the replay.
pub fn compare(run: &mut Run<'_>, path: &Path) -> Result<Comparison, Failure> {
    let mut reader = WavReader::open(path)?;
    let (info, head) = (reader.info(), run.player.head().clone());
    if info.channels != head.channels || f64::from(info.rate) != head.rate || !info.float {
        let is = |channels: usize, rate: f64| format!("{channels} channels at {rate} Hz");
        let stored = if info.float { "" } else { ", stored as integers" };
        let what = format!(
            "`{}` has {}{stored}, the session had {} as 32-bit floats",
            path.display(),
            is(info.channels, f64::from(info.rate)),
            is(head.channels, head.rate)
        );
        return Err(Failure::usage(what, "name what play --record has kept of the same session"));
    }
    let channels = head.channels.max(1);
    let mut found = Comparison {
        recording: path.display().to_string(),
        identical: true,
        frames: 0,
        only_recorded: 0,
        only_replayed: 0,
        different: 0,
        first: None,
        largest: 0.0,
    };
    let (mut ours, mut at, mut failed) = (Vec::new(), 0, None);
    let read = reader.each_frame(|theirs| {
        if at == ours.len() {
            at = 0;
            if let Err(failure) = run.block(&mut ours) {
                failed = Some(failure);
                // It is told below, in its own words.
                return Err(String::new());
            }
        }
        let Some(frame) = ours.get(at..at + channels) else {
            found.only_recorded += 1;
            return Ok(());
        };
        at += channels;
        for (channel, (&recorded, &replayed)) in theirs.iter().zip(frame).enumerate() {
            if recorded.to_bits() != replayed.to_bits() {
                found.different += 1;
                found.largest = found.largest.max(f64::from(recorded - replayed).abs());
                let here = Difference { frame: found.frames, channel: channel + 1, recorded, replayed };
                found.first.get_or_insert(here);
            }
        }
        found.frames += 1;
        Ok(())
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    read?;
    found.only_replayed += ((ours.len() - at) / channels) as u64;
    while {
        run.block(&mut ours)?;
        !ours.is_empty()
    } {
        found.only_replayed += (ours.len() / channels) as u64;
    }
    found.identical = found.different + found.only_recorded + found.only_replayed == 0;
    Ok(found)
}

impl Comparison {
    /// For people.
    pub fn text(&self) -> String {
        if self.identical {
            return format!("  the same, to the bit, in {} frames", grouped(self.frames));
        }
        let both = grouped(self.frames);
        let mut text = match self.first {
            None => format!("  the same, to the bit, in the {both} frames that both have"),
            Some(Difference { frame, channel, recorded, replayed }) => format!(
                "  different: first in frame {} on channel {channel}, {recorded:e} there and {replayed:e} here; {} samples, by {:.1e} at most",
                grouped(frame),
                grouped(self.different),
                self.largest
            ),
        };
        if self.only_recorded > 0 {
            text += &format!("; the recording goes on for {} frames", grouped(self.only_recorded));
        }
        if self.only_replayed > 0 {
            text += &format!("; it ends {} frames before the session", grouped(self.only_replayed));
        }
        text
    }
}
