//! Following a vibration of changing frequency, turn by turn, without a model of what makes it.
//!
//! A turn of sine and cosine is fitted to a turn of the recording; what its phase differs from the expected one corrects angle, speed and
//! acceleration for the next half turn. It begins where the recording is strongest and goes both ways from there, until no sine is left.

use std::f64::consts::{PI, TAU};

use super::least::solve;
use super::recording::Mistake;

/// A stretch over which a vibration was followed.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    /// Half a turn apart, in order of time.
    pub knots: Vec<Knot>,
}

impl Stretch {
    /// How long it is.
    pub fn samples(&self) -> f64 {
        self.knots.last().map_or(0.0, |last| last.at - self.knots[0].at)
    }
}

/// Where the vibration is at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knot {
    /// Samples from the beginning.
    pub at: f64,
    /// Radians, not wrapped.
    pub angle: f64,
    /// Radians a sample.
    pub speed: f64,
}

/// Seconds of a frame in which a frequency is looked for at first, and at most; the cycles that it must hold.
const FRAME: f64 = 0.05;
const LONGEST: f64 = 0.8;
const CYCLES: f64 = 4.0;
/// The highest frequency that is looked for, Hz.
const HIGHEST: f64 = 2000.0;
/// The least share of its mean square that the sine has in a turn.
const SHARE: f64 = 0.6;
/// The most that a phase may differ from what was expected, rad.
const ASTRAY: f64 = 1.3;
/// How much of a difference corrects speed and acceleration.
const GAINS: [f64; 2] = [0.8, 0.4];
/// Samples of a turn, at least; with fewer, several turns are taken at once.
const SAMPLES: f64 = 12.0;
/// Samples a turn that a recording must have.
pub(super) const PER_TURN: f64 = 8.0;
/// Knots of a stretch, at least: two turns.
const KNOTS: usize = 4;
/// Frames from which to begin, at most.
const BEGINNINGS: usize = 200;

/// All stretches, in order of time; and the largest share of a sine that was found where there is none.
///
/// # Errors
/// A frequency too high for the rate.
pub(super) fn follow(x: &[f64], rate: f64) -> Result<(Vec<Stretch>, f64), Mistake> {
    let frame = ((FRAME * rate) as usize).clamp(16, x.len().max(16));
    let mut taken = vec![false; x.len()];
    let (mut stretches, mut best) = (Vec::<Stretch>::new(), 0.0_f64);
    let mut begins: Vec<(f64, usize)> = (0..x.len().saturating_sub(frame))
        .step_by((frame / 2).max(1))
        .map(|n| (variance(&x[n..n + frame]), n))
        .collect();
    begins.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut tried = 0;
    for (energy, begin) in begins {
        let middle = begin + frame / 2;
        if energy == 0.0 || tried == BEGINNINGS {
            break;
        }
        if taken[middle] {
            continue;
        }
        tried += 1;
        let Some(speed) = strongest(x, rate, middle) else { continue };
        let start = Knot { at: middle as f64, angle: 0.0, speed };
        let Some((phase, share)) = turn(x, start, 0.0) else { continue };
        best = best.max(share);
        if share < SHARE {
            continue;
        }
        if TAU / speed < PER_TURN {
            // Where it is loudest it is no accident.
            let hertz = speed * rate / TAU;
            if tried > 1 {
                continue;
            }
            return Err(Mistake::Slow(rate, PER_TURN * hertz, hertz));
        }
        let start = Knot { angle: phase, ..start };
        let mut knots = walk(x, start, -1.0, &taken);
        knots.reverse();
        knots.push(start);
        knots.extend(walk(x, start, 1.0, &taken));
        if knots.len() >= KNOTS {
            let (from, to) = (knots[0].at as usize, knots[knots.len() - 1].at as usize);
            taken[from..=to.min(x.len() - 1)].fill(true);
            stretches.push(Stretch { knots });
        }
    }
    stretches.sort_by(|a, b| a.knots[0].at.total_cmp(&b.knots[0].at));
    Ok((stretches, best))
}

fn variance(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / x.len() as f64
}

/// The strongest frequency around a sample, rad a sample: in a frame that holds some cycles of it.
fn strongest(x: &[f64], rate: f64, middle: usize) -> Option<f64> {
    let mut seconds = FRAME;
    while seconds <= LONGEST {
        let half = ((0.5 * seconds * rate) as usize).max(16);
        let (from, to) = (middle.saturating_sub(half), (middle + half).min(x.len()));
        let (frame, length) = (&x[from..to], to - from);
        let mean = frame.iter().sum::<f64>() / length as f64;
        // Hann's window, so that a frequency's neighbours are its own.
        let shaped: Vec<f64> = frame
            .iter()
            .enumerate()
            .map(|(n, x)| (x - mean) * (0.5 - 0.5 * (TAU * (n as f64 + 0.5) / length as f64).cos()))
            .collect();
        let step = PI / length as f64;
        let last = (0.48 * TAU).min(TAU * HIGHEST / rate);
        let count = (last / step) as usize;
        let power: Vec<f64> = (0..count).map(|n| goertzel(&shaped, step * n as f64)).collect();
        let lowest = (2.0 * CYCLES) as usize;
        let found = (lowest..count.saturating_sub(1)).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
        let below = power[..lowest].iter().fold(0.0, |m: f64, p| m.max(*p));
        if power[found] > 0.0 && below <= power[found] {
            // The top of a parabola through three powers.
            let [a, b, c] = [power[found - 1], power[found], power[found + 1]];
            let off = if a + c < 2.0 * b { 0.5 * (a - c) / (a + c - 2.0 * b) } else { 0.0 };
            return Some(step * (found as f64 + off.clamp(-0.5, 0.5)));
        }
        if from == 0 && to == x.len() {
            return None;
        }
        seconds *= 2.0;
    }
    None
}

/// The power at a frequency, rad a sample (Goertzel, 1958).
fn goertzel(x: &[f64], speed: f64) -> f64 {
    let twice = 2.0 * speed.cos();
    let (mut last, mut before) = (0.0, 0.0);
    for x in x {
        (last, before) = (x + twice * last - before, last);
    }
    last * last + before * before - twice * last * before
}

/// By how much the phase of a turn around a knot differs from the knot's, and the share of the sine in its mean square.
fn turn(x: &[f64], knot: Knot, bend: f64) -> Option<(f64, f64)> {
    let length = TAU / knot.speed;
    let half = 0.5 * length * (SAMPLES / length).ceil().max(1.0);
    let (from, to) = (knot.at - half, knot.at + half);
    if !(from >= 0.0 && to < x.len() as f64 - 1.0) {
        return None;
    }
    let samples = from.ceil() as usize..=to.floor() as usize;
    let (mut normal, mut right, mut square, mut count) = (vec![vec![0.0; 3]; 3], [0.0; 3], 0.0, 0.0);
    for n in samples {
        let t = n as f64 - knot.at;
        let (s, c) = (knot.angle + t * (knot.speed + 0.5 * bend * t)).sin_cos();
        let row = [1.0, s, c];
        for i in 0..3 {
            right[i] += row[i] * x[n];
            (0..3).for_each(|j| normal[i][j] += row[i] * row[j]);
        }
        (square, count) = (square + x[n] * x[n], count + 1.0);
    }
    let found = solve(&normal, &right)?;
    let mean = right[0] / count;
    let whole = square - mean * right[0];
    let left = square - found.iter().zip(&right).map(|(f, r)| f * r).sum::<f64>();
    (whole > 0.0).then(|| (found[2].atan2(found[1]), 1.0 - left / whole))
}

/// On from a knot, half a turn at a time, forward or backward.
fn walk(x: &[f64], start: Knot, way: f64, taken: &[bool]) -> Vec<Knot> {
    let (mut knots, mut now, mut bend) = (Vec::new(), start, 0.0);
    // Half a turn takes at least a sample each.
    for _ in 0..x.len() {
        let hop = way * PI / now.speed;
        let angle = now.angle + hop * (now.speed + 0.5 * bend * hop);
        let expected = Knot { at: now.at + hop, angle, speed: now.speed + bend * hop };
        if !(expected.speed > 0.0 && expected.speed < TAU / PER_TURN) {
            break;
        }
        let Some((off, share)) = turn(x, expected, bend) else { break };
        if share < SHARE || off.abs() > ASTRAY || taken.get(expected.at as usize) != Some(&false) {
            break;
        }
        now = Knot { angle: angle + off, speed: expected.speed + GAINS[0] * off / hop, ..expected };
        bend += GAINS[1] * off / (hop * hop);
        if now.speed <= 0.0 || now.speed.is_nan() {
            break;
        }
        knots.push(now);
    }
    knots
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::noise::Noise;
    use super::super::recording::Mistake;
    use super::follow;

    /// A chirp whose phase is known: 40 to 250 Hz and back within 1.2 s, its amplitude as the square of the frequency, at 40 dB.
    #[test]
    fn a_chirp_is_followed_to_a_hundredth_of_a_turn() {
        for rate in [4000.0, 48e3] {
            let count = (1.2 * rate) as usize;
            let hertz = |t: f64| 145.0 - 105.0 * (TAU * t / 1.2).cos();
            let angle = |t: f64| TAU * 145.0 * t - 105.0 * 1.2 * (TAU * t / 1.2).sin();
            let at = |n: usize| n as f64 / rate;
            let clean: Vec<f64> =
                (0..count).map(|n| hertz(at(n)).powi(2) * angle(at(n)).sin() / 62500.0 + 0.1).collect();
            let x = Noise::new(1).add(&clean, 40.0);
            let (stretches, _) = follow(&x, rate).unwrap();
            assert_eq!(stretches.len(), 1);
            let knots = &stretches[0].knots;
            let turns = (knots[knots.len() - 1].at - knots[0].at) / rate;
            assert!(turns > 1.1, "{turns} s of 1.2");
            let mut worst = 0.0_f64;
            for knot in knots {
                let off = knot.angle - angle(knot.at / rate) - (knots[0].angle - angle(knots[0].at / rate));
                let whole = (off / TAU).round() * TAU;
                worst = worst.max((off - whole).abs());
                assert_eq!(whole, 0.0, "a turn was lost");
            }
            assert!(worst < 0.3, "{worst}");
            let within = knots.iter().filter(|k| hertz(k.at / rate) > 100.0);
            for knot in within {
                assert!((knot.speed * rate / TAU / hertz(knot.at / rate) - 1.0).abs() < 0.02, "{knot:?}");
            }
        }
    }

    #[test]
    fn noise_is_no_vibration_and_what_is_too_fast_is_said() {
        let mut noise = Noise::new(3);
        let x: Vec<f64> = (0..48_000).map(|_| noise.normal()).collect();
        let (stretches, best) = follow(&x, 48e3).unwrap();
        assert!(stretches.is_empty() && best < 0.6, "{best}");
        let fast: Vec<f64> = (0..2000).map(|n| (TAU * 0.2 * f64::from(n)).sin()).collect();
        let Err(Mistake::Slow(rate, least, hertz)) = follow(&fast, 1000.0) else { panic!() };
        assert!(rate == 1000.0 && (hertz - 200.0).abs() < 2.0 && (least - 8.0 * hertz).abs() < 1e-9);
        assert!(follow(&[], 1000.0).unwrap().0.is_empty() && follow(&[1.0; 5], 1e3).unwrap().0.is_empty());
    }
}
