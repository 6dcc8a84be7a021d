//! What an actuator does under a patch.

use std::sync::{Arc, Mutex, PoisonError};

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
    /// What it was given on average, V; A where its amplifier imposes a current.
    pub drives: Vec<f64>,
    /// Of a rumble motor, rad/s; empty for what is none.
    pub speeds: Vec<f64>,
    /// Of a rumble motor, the speed that was wished for, as late as what was sent; likewise.
    pub wished: Vec<f64>,
    /// The magnitude of what is felt, m/s², or N.
    pub felt: Vec<f64>,
    /// Drawn by the end of each, J; empty where the resistance of the winding is not known.
    pub energy: Vec<f64>,
    /// Turned by the end of each, rad; empty for what is no rumble motor.
    pub turned: Vec<f64>,
    /// When (s, as late as what is sent) a voice began on it, and its name.
    pub voices: Vec<(f64, String)>,
    /// m/s², or N.
    pub unit: &'static str,
}

/// A stretch of it in which something was wished for or done to it, or it moved.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stretch {
    /// From when to when, s.
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
        let voices = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&voices);
        let name = output.to_string();
        player.listen(Box::new(move |event| {
            if let Happening::Voice { name: voice, place, .. } = event.what
                && place.split([',', ' ', '+']).any(|part| part == name)
            {
                heard
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .push((event.at + late, voice.to_string()));
            }
        }));
        let mut new = Self { rate, unit: feel.felt()[place].unit().word(), ..Self::default() };
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
        let time = |n: usize| n as f64 / self.rate;
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
            turns: gained(&self.turned).map(|turned| turned / std::f64::consts::TAU),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Played;

    /// A wish of 100 rad/s from 0.1 s to 0.4 s, and a motor that has that speed from `from` on, if ever, until the wish ends.
    fn late(from: Option<f64>) -> Played {
        let rate = 1000.0;
        let of = |begin: f64| {
            (0..600).map(move |n| if (begin..0.4).contains(&(n as f64 / rate)) { 100.0 } else { 0.0 })
        };
        let speeds: Vec<f64> = of(from.unwrap_or(1.0)).collect();
        Played {
            rate,
            drives: speeds.iter().map(|speed| 0.01 * speed).collect(),
            felt: speeds.iter().map(|speed| 1e-3 * speed * speed).collect(),
            energy: vec![0.0; 600],
            turned: vec![0.0; 600],
            wished: of(0.1).collect(),
            voices: vec![(0.1, "v".into())],
            speeds,
            ..Played::default()
        }
    }

    /// A rise counts from the wish, and what was missed before anything moved counts as well.
    #[test]
    fn what_begins_late_has_risen_late() {
        let stretches = late(Some(0.25)).stretches();
        assert_eq!(stretches.len(), 1);
        let [half, most] = stretches[0].rise.map(Option::unwrap);
        assert!((half - 0.151).abs() < 1e-9 && half == most, "{half} {most}");
        assert_eq!(stretches[0].voices, ["v"]);
        // All of it is missed for half of the time.
        assert!((stretches[0].error.unwrap() - 0.5_f64.sqrt()).abs() < 1e-9);
    }

    /// What was wished for and never moved was played none the less.
    #[test]
    fn what_never_moves_is_told() {
        let stretches = late(None).stretches();
        assert_eq!(stretches.len(), 1);
        assert_eq!((stretches[0].rise, stretches[0].error), ([None; 2], Some(1.0)));
        assert!((stretches[0].from, stretches[0].to) == (0.1, 0.4) && stretches[0].peak == 0.0);
    }
}
