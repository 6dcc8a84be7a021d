//! What an actuator does under a patch.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};

use super::modelled::Modelled;
use crate::actuator::fault::Fault;
use crate::feel::{Feel, Wish};
use crate::performer::Happening;
use crate::player::Player;
use crate::rig::Rig;

/// What an actuator did while a patch was played, a frame of the device each; and what was played on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Played {
    /// Frames a second.
    pub rate: f64,
    /// By how much what is sent is later than the patch has it, s: a whole number of frames.
    pub late: f64,
    /// How much of what follows lies before the patch begins, s: all by which it is late, unless it was [aligned](Self::align). All times are those of
    /// the patch.
    pub before: f64,
    /// How it was computed.
    pub modelled: Modelled,
    /// What it was given on average, V; A where its amplifier imposes a current.
    pub drives: Vec<f64>,
    /// Of a rumble motor, rad/s; empty for what is none.
    pub speeds: Vec<f64>,
    /// Of a rumble motor, the speed that was wished for, as late as what was sent; likewise.
    pub wished: Vec<f64>,
    /// The magnitude of what is felt, m/s², or N.
    pub felt: Vec<f64>,
    /// Drawn by the end of each, J; empty of a motor that is known from outside alone.
    pub energy: Vec<f64>,
    /// Turned by the end of each, rad; empty for what is no rumble motor.
    pub turned: Vec<f64>,
    /// What coil and friction did to its casing about the shaft, N m; empty for one that is known from outside alone, and for what is no rumble
    /// motor.
    pub reactions: Vec<f64>,
    /// When a voice began on it, s, and its name.
    pub voices: Vec<(f64, String)>,
    /// m/s², or N.
    pub unit: &'static str,
}

/// A stretch of it in which something was wished for or done to it, or it moved.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stretch {
    /// From when to when, s, as the patch has it.
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// The voices that began in it.
    pub voices: Vec<String>,
    /// From when a speed was wished for until the vibration was 50 % and 90 % of the most that was; where none was wished for, from the beginning, of the
    /// most that there was. `None`: it never was, or it is no rumble motor.
    pub rise: [Option<f64>; 2],
    /// The most that was felt, and when, s.
    pub peak: f64,
    /// See `peak`.
    pub peak_at: f64,
    /// From the end of the wish, or of the drive where there was none, until it stood; `None`: it never did, or is no rumble motor.
    pub stop: Option<f64>,
    /// By how much the vibration missed what was wished for: root mean square over the wish, as a share of the most.
    pub error: Option<f64>,
    /// Drawn, J.
    pub energy: Option<f64>,
    /// Turned, turns.
    pub turns: Option<f64>,
    /// Where its mass is at the end, rad within ±π from where it hangs straight down.
    pub angle: Option<f64>,
    /// The largest torque on the casing about the shaft, of either sign, N m.
    pub peak_reaction: Option<f64>,
}

/// Below this share of the most there was nothing moves, and what parts stretches, s.
const STILL: f64 = 1e-3;
const PARTS: f64 = 0.02;

/// Of what is wished for, shares at which a rise is told; of the peak, what counts as felt where nobody wished.
const RISE: [f64; 2] = [0.5, 0.9];

impl Played {
    /// Plays a patch from its beginning until it is over and what it moved has come to rest, or for so many seconds, and sees what it does to the actuator of an
    /// output, with no larger error than that; `None` where it is not known what that moves.
    ///
    /// # Errors
    /// An error or a rig that cannot be simulated.
    pub fn new(
        player: &mut Player,
        rig: &Rig,
        output: &str,
        seconds: f64,
        error: f64,
    ) -> Result<Option<Self>, Fault> {
        let (rate, channels, ratio) =
            (player.plan().device_rate, player.plan().channels, player.plan().ratio);
        let mut feel = Feel::new(rig, channels, rate, &Wish { error })?;
        let Some(place) = feel.felt().iter().position(|felt| felt.output == output) else { return Ok(None) };
        let Some(described) = rig.outputs.iter().find(|described| described.name == output) else {
            return Ok(None);
        };
        let channel = described.channel.saturating_sub(1) as usize;
        let first = feel.traces().iter().position(|trace| trace.output == output).unwrap_or(0);
        let (width, own) = (feel.traces().len(), feel.felt()[place].traces().count());
        let drives = player.engine().stage().drives();
        let late = match drives.late(channel) {
            Some(late) => late as f64 * ratio as f64 / rate + player.engine().delay().lead,
            None => player.engine().delay().total(),
        };
        let late = (late * rate).round() / rate;
        let voices = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&voices);
        let name = output.to_string();
        player.listen(Box::new(move |event| {
            if let Happening::Voice { name: voice, place, .. } = event.what
                && place.split([',', ' ', '+']).any(|part| part == name)
            {
                heard.lock().unwrap_or_else(PoisonError::into_inner).push((event.at, voice.to_string()));
            }
        }));
        let modelled = Modelled::new(&feel.felt()[place], error);
        let unit = feel.felt()[place].unit().word();
        let mut new = Self { rate, late, before: late, modelled, unit, ..Self::default() };
        let (mut block, mut felt) = (vec![0.0; channels * ratio], Vec::new());
        let (most, mut still) = ((seconds * rate).ceil() as usize, 0);
        let waits = (PARTS * rate) as usize;
        while new.drives.len() < most {
            player.process(&mut block);
            let wished = player.engine().stage().drives().wished(channel);
            for frame in block.chunks(channels) {
                feel.process(frame, &mut felt);
                let now = feel.felt()[place].now();
                // Before diodes the first frames wait for what follows them.
                let Some(frame) = felt.chunks(width).next_back() else { continue };
                let moves =
                    frame[first..first + own].iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
                new.felt.push(moves.sqrt());
                new.drives.push(now.drive);
                new.speeds.extend(now.speed);
                new.turned.extend(now.turned);
                new.reactions.extend(now.reaction);
                new.energy.extend(now.energy);
                new.wished.extend(now.speed.and(wished));
                let rests = now.drive == 0.0 && now.speed.is_none_or(|speed| speed == 0.0);
                still = if rests { still + 1 } else { 0 };
            }
            if player.is_over() && still > waits && feel.rests(STILL) {
                break;
            }
        }
        new.voices.append(&mut voices.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(Some(new))
    }

    /// How long it took, s.
    pub fn seconds(&self) -> f64 {
        self.drives.len() as f64 / self.rate
    }

    /// When a frame begins, s.
    pub fn time(&self, frame: usize) -> f64 {
        frame as f64 / self.rate - self.before
    }

    /// Shifts several so that what is played at an instant stands at the same frame in all of them, however late each is. What is sent before
    /// the patch begins, as coupling may ask for, is kept.
    pub fn align(all: &mut [Self]) {
        let early = |played: &Self| {
            let least = STILL * played.drives.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let first = played.drives.iter().position(|drive| drive.abs() > least);
            let before = played.frames_before();
            first.map_or(0, |first| before.saturating_sub(first))
        };
        let before = all.iter().map(early).max().unwrap_or(0);
        for played in all {
            let is = played.frames_before();
            let of = [&mut played.drives, &mut played.speeds, &mut played.wished];
            let more = [&mut played.felt, &mut played.energy, &mut played.turned, &mut played.reactions];
            for values in of.into_iter().chain(more).filter(|values| !values.is_empty()) {
                if is > before {
                    values.drain(..(is - before).min(values.len()));
                } else {
                    values.splice(..0, std::iter::repeat_n(0.0, before - is));
                }
            }
            played.before = before as f64 / played.rate;
        }
    }

    fn frames_before(&self) -> usize {
        (self.before * self.rate).round() as usize
    }

    /// Stretches between rests of 20 ms.
    pub fn stretches(&self) -> Vec<Stretch> {
        let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let [drive, speed, felt, wished] =
            [&self.drives, &self.speeds, &self.felt, &self.wished].map(|values| STILL * most(values));
        let moves = |n: usize| {
            let over = |values: &[f64], least: f64| values.get(n).is_some_and(|x| x.abs() > least);
            over(&self.drives, drive)
                || over(&self.speeds, speed)
                // Something is to move, though it does not yet, or never does.
                || over(&self.wished, wished)
                || (self.speeds.is_empty() && over(&self.felt, felt))
        };
        let apart = (PARTS * self.rate) as usize;
        let mut found: Vec<[usize; 2]> = Vec::new();
        for n in (0..self.drives.len()).filter(|n| moves(*n)) {
            match found.last_mut() {
                Some([_, to]) if n <= *to + apart => *to = n + 1,
                _ => found.push([n, n + 1]),
            }
        }
        found.into_iter().map(|[from, to]| self.stretch(from, to)).collect()
    }

    fn stretch(&self, from: usize, to: usize) -> Stretch {
        let time = |n: usize| self.time(n);
        let (begin, end) = (time(from), time(to));
        let square = |values: &[f64], n: usize| values.get(n).map_or(0.0, |x| x * x);
        let (peak_at, peak) =
            (from..to).map(|n| (n, self.felt[n])).fold((from, 0.0), |m, x| if x.1 > m.1 { x } else { m });
        let wishes: Vec<usize> =
            (from.saturating_sub(1)..to).filter(|n| square(&self.wished, *n) > 0.0).collect();
        let wanted = wishes.iter().map(|n| square(&self.wished, *n)).fold(0.0, f64::max);
        // Where nothing is wished for, a rise is one to the most that there was.
        let most = if wanted > 0.0 {
            wanted
        } else {
            (from..to).map(|n| square(&self.speeds, n)).fold(0.0, f64::max)
        };
        let last_drive = (from..to).rev().find(|n| self.drives[*n] != 0.0).map_or(from, |n| n + 1);
        let over = wishes.last().map_or(last_drive, |n| n + 1);
        let first = wishes.first().copied().or((most > 0.0).then_some(from));
        let rise = RISE.map(|share| {
            let first = first?;
            let n = (first..to).find(|n| square(&self.speeds, *n) >= share * most)?;
            Some(time(n + 1) - time(first))
        });
        let still = STILL * self.speeds.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let moves = (from..self.speeds.len().min(to + 1)).rev().find(|n| self.speeds[*n].abs() > still);
        let stands =
            (!self.speeds.is_empty() && to < self.speeds.len()).then(|| moves.map_or(from, |n| n + 1));
        let off: f64 =
            wishes.iter().map(|n| (square(&self.speeds, *n) - square(&self.wished, *n)).powi(2)).sum();
        let gained = |values: &[f64]| {
            let before = from.checked_sub(1).and_then(|n| values.get(n)).copied().unwrap_or(0.0);
            values.get(to - 1).map(|is| is - before)
        };
        Stretch {
            from: begin,
            to: end,
            voices: self
                .voices
                .iter()
                .filter(|(at, _)| *at >= begin - PARTS && *at < end)
                .map(|(_, voice)| voice.clone())
                .collect(),
            rise,
            peak,
            peak_at: time(peak_at),
            stop: stands.map(|stands| (time(stands) - time(over)).max(0.0)),
            error: (wanted > 0.0).then(|| (off / wishes.len() as f64).sqrt() / wanted),
            energy: gained(&self.energy),
            turns: gained(&self.turned).map(|turned| turned / TAU),
            angle: self.turned.get(to - 1).map(|angle| angle - TAU * (angle / TAU).round()),
            peak_reaction: self
                .reactions
                .get(from..to)
                .map(|torques| torques.iter().fold(0.0, |most, torque| torque.abs().max(most))),
        }
    }
}

#[cfg(test)]
mod tests;
