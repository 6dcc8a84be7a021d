//! By how much a recording lags the drive that it is the response to, where nothing but the two is known.

use realfft::RealFftPlanner;

/// A delay that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// Seconds by which the recording lags the drive; negative where it began later.
    pub seconds: f64,
    /// The correlation there, over the largest of any other delay; more than [`CLEAR`].
    pub clear: f64,
}

/// A delay must agree so many times better than any other.
pub const CLEAR: f64 = 1.1;
/// And so many times better than delays do in the mean (root mean square), but of what follows slowly.
const STANDS_OUT: f64 = 5.0;
/// Seconds around a delay that are the same delay: of what comes back as it went out, and of what rings; of what follows slowly, this share
/// of the drive.
const NEAR: [f64; 2] = [0.01, 0.1];
const SLOW: f64 = 0.1;
/// What follows slowly must agree so well: the correlation by that of the same with itself.
const AGREES: f64 = 0.8;
/// Frames a second by which a vibration's strength is followed, and how long each is, s.
const FRAMES: f64 = 400.0;
const FRAME: f64 = 0.03;
/// Time constants of motors that are tried, s, and shares of the drive that friction takes.
const TIMES: [f64; 7] = [0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32];
const FRICTIONS: [f64; 3] = [0.0, 0.12, 0.24];

/// Of a drive that came back through a cable: to a part of a sample. Both are at `rate` samples a second. Capacitors on the way do not matter.
pub fn looped(drive: &[f64], back: &[f64], rate: f64) -> Option<Lag> {
    let steps = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|x| x[1] - x[0]).collect() };
    found(&correlation(&steps(drive), &steps(back))?, drive.len().checked_sub(2)?, rate, NEAR[0], STANDS_OUT)
}

/// Of a resonance's answer: to about what it rings.
pub fn rung(drive: &[f64], response: &[f64], rate: f64) -> Option<Lag> {
    found(
        &correlation(&level(drive), &level(response))?,
        drive.len().checked_sub(1)?,
        rate,
        NEAR[1],
        STANDS_OUT,
    )
}

/// Of a motor's vibration, whose amplitude is as the square of the speed, which follows the drive slowly: to some hundredths of a second.
pub fn turned(drive: &[f64], vibration: &[f64], rate: f64) -> Option<Lag> {
    let hop = ((rate / FRAMES) as usize).max(1);
    let frames = rate / hop as f64;
    let speeds = strength(vibration, hop, (FRAME * rate) as usize);
    // Beyond the recording it is as still as it ever was.
    let least = speeds.iter().fold(f64::INFINITY, |least, speed| least.min(*speed));
    let speeds: Vec<f64> = speeds.iter().map(|speed| speed - least).collect();
    let volts: Vec<f64> =
        drive.chunks(hop).map(|v| v.iter().map(|v| v.abs()).sum::<f64>() / v.len() as f64).collect();
    let most = volts.iter().fold(0.0_f64, |m, v| m.max(*v));
    let spread = spread(&speeds, volts.len());
    let reach = SLOW * drive.len() as f64 / rate;
    let least = SILENT * spread.iter().fold(0.0, |most: f64, spread| most.max(*spread));
    let mut best: Option<(f64, Lag)> = None;
    for time in TIMES {
        for friction in FRICTIONS {
            let mut speed = 0.0;
            let share = 1.0 - (-1.0 / (time * frames)).exp();
            let follow = |v: &f64| {
                speed += share * ((v - friction * most).max(0.0) - speed);
                speed
            };
            let model = level(&volts.iter().map(follow).collect::<Vec<_>>());
            let power = model.iter().map(|x| x * x).sum::<f64>().sqrt();
            // Where next to nothing was recorded, digits agree with anything.
            let share = |(sum, spread): (&f64, &f64)| match *spread > least {
                true => (sum / (power * spread).max(1e-300)).max(0.0),
                false => 0.0,
            };
            let all: Vec<f64> = correlation(&model, &speeds)?.iter().zip(&spread).map(share).collect();
            let top = all.iter().fold(0.0, |top: f64, share| top.max(*share));
            if top > best.map_or(AGREES, |(agrees, _)| agrees) {
                best = found(&all, model.len() - 1, frames, reach, 0.0).map(|lag| (top, lag)).or(best);
            }
        }
    }
    best.map(|(_, lag)| lag)
}

/// A share of the largest spread below which there was silence.
const SILENT: f64 = 1e-3;

/// How far what lies under a window of so many samples is from its mean, the root of all squares, for every place of the window from the one
/// where only its last sample is on `x`; zeros beyond `x`.
fn spread(x: &[f64], window: usize) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]];
    for x in x {
        let [sum, squares] = sums[sums.len() - 1];
        sums.push([sum + x, squares + x * x]);
    }
    let under = |n: usize| {
        let (from, to) = ((n + 1).saturating_sub(window), (n + 1).min(x.len()));
        let [sum, squares] = [0, 1].map(|k| sums[to][k] - sums[from][k]);
        (squares - sum * sum / window as f64).max(1e-12 * squares).sqrt()
    };
    (0..x.len() + window - 1).map(under).collect()
}

/// The square root of the root mean square about the mean, frame by frame, each around its instant.
fn strength(x: &[f64], hop: usize, length: usize) -> Vec<f64> {
    let half = (length / 2).max(1);
    (0..x.len())
        .step_by(hop)
        .map(|n| {
            let frame = &x[n.saturating_sub(half)..(n + half).min(x.len())];
            let count = frame.len().max(1) as f64;
            let mean = frame.iter().sum::<f64>() / count;
            (frame.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count).powf(0.25)
        })
        .collect()
}

fn level(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
    x.iter().map(|x| x - mean).collect()
}

/// Σ a[n] b[n + lag] for lags from −(a's length − 1) on.
fn correlation(a: &[f64], b: &[f64]) -> Option<Vec<f64>> {
    let count = a.len() + b.len();
    if a.is_empty() || b.is_empty() || a.iter().chain(b).any(|x| !x.is_finite()) {
        return None;
    }
    let size = count.next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (there, back) = (planner.plan_fft_forward(size), planner.plan_fft_inverse(size));
    let spectrum = |x: &mut dyn Iterator<Item = f64>| {
        let mut time = there.make_input_vec();
        time.iter_mut().zip(x).for_each(|(to, x)| *to = x);
        let mut all = there.make_output_vec();
        there.process(&mut time, &mut all).ok().map(|()| all)
    };
    let (turned, b) = (spectrum(&mut a.iter().rev().copied())?, spectrum(&mut b.iter().copied())?);
    let mut product: Vec<_> = turned.iter().zip(&b).map(|(a, b)| a * b / size as f64).collect();
    let mut all = back.make_output_vec();
    back.process(&mut product, &mut all).ok()?;
    all.truncate(count - 1);
    Some(all)
}

/// The lag at which a correlation is greatest, up or down, where no other is nearly as great. Its lag 0 is at `zero`.
fn found(all: &[f64], zero: usize, rate: f64, near: f64, stands_out: f64) -> Option<Lag> {
    let top = (0..all.len()).max_by(|a, b| all[*a].abs().total_cmp(&all[*b].abs()))?;
    let peak = all[top].abs();
    let reach = (near * rate) as usize;
    let far = |n: &usize| n.abs_diff(top) > reach;
    let next = (0..all.len()).filter(far).map(|n| all[n].abs()).fold(0.0, f64::max);
    let mean = (all.iter().map(|c| c * c).sum::<f64>() / all.len() as f64).sqrt();
    if !(peak > CLEAR * next && peak > stands_out * mean) {
        return None;
    }
    let at = |n: usize| all.get(n).map_or(0.0, |c| c.abs());
    let (before, behind) = (top.checked_sub(1).map_or(0.0, at), at(top + 1));
    let bend = before - 2.0 * peak + behind;
    let part = if bend < 0.0 { (0.5 * (before - behind) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Some(Lag { seconds: (top as f64 - zero as f64 + part) / rate, clear: peak / next.max(1e-300) })
}

#[cfg(test)]
mod tests {
    use super::{correlation, looped, rung, turned};

    /// Noise of a counter's mix.
    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1u64 << 30) as f64 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    /// So many samples later (or earlier), among zeros, of another length.
    fn late(x: &[f64], samples: isize, length: usize) -> Vec<f64> {
        (0..length as isize)
            .map(|n| usize::try_from(n - samples).ok().and_then(|n| x.get(n)).copied().unwrap_or(0.0))
            .collect()
    }

    #[test]
    fn a_correlation_is_its_definition() {
        let (a, b) = (noise(7, 1), noise(12, 2));
        let all = correlation(&a, &b).unwrap();
        assert_eq!(all.len(), 18);
        for (n, value) in all.iter().enumerate() {
            let lag = n as isize - 6;
            let due: f64 = (0..7_isize)
                .filter_map(|k| Some(a[k as usize] * b.get(usize::try_from(k + lag).ok()?)?))
                .sum();
            assert!((value - due).abs() < 1e-12, "{lag}: {value} {due}");
        }
    }

    #[test]
    fn what_comes_back_is_found_to_the_sample_whichever_way_up() {
        let drive = crate::actuator::identify::stimulus::steps(3.0, 0.03, 8000.0).unwrap();
        for (samples, sign) in [(0, 1.0), (1, -1.0), (4000, 0.01), (-777, -1.0), (30_000, 1.0)] {
            let hiss = noise(60_000, 3);
            let back: Vec<f64> =
                late(&drive, samples, 60_000).iter().zip(&hiss).map(|(x, h)| sign * (x + 0.01 * h)).collect();
            let lag = looped(&drive, &back, 8000.0).unwrap_or_else(|| panic!("{samples}"));
            assert!((lag.seconds * 8000.0 - samples as f64).abs() < 0.1, "{samples}: {lag:?}");
        }
        assert_eq!(looped(&drive, &noise(60_000, 4), 8000.0), None);
        assert_eq!(looped(&drive, &[0.0; 60_000], 8000.0), None);
        assert!(looped(&[], &[], 1.0).is_none() && looped(&[1.0], &[f64::NAN], 1.0).is_none());
    }

    /// A recursive resonance of 170 Hz, Q 20, behind a delay.
    #[test]
    fn a_ringing_answer_is_found_within_its_ringing() {
        let drive = crate::actuator::identify::stimulus::sweep(1.0, [20.0, 1500.0], 2.0, 8000.0).unwrap();
        let omega = std::f64::consts::TAU * 170.0 / 8000.0;
        let (r, mut y) = ((-omega / 40.0).exp(), [0.0; 2]);
        let rings = |x: &f64| {
            let now = x + 2.0 * r * omega.cos() * y[0] - r * r * y[1];
            y = [now, y[0]];
            now
        };
        let rings: Vec<f64> = drive.iter().map(rings).collect();
        for samples in [0, 250, 9000, -2000] {
            let lag = rung(&drive, &late(&rings, samples, 40_000), 8000.0).unwrap();
            let off = lag.seconds - samples as f64 / 8000.0;
            assert!((-0.005..0.04).contains(&off), "{samples}: {off}");
        }
        assert_eq!(rung(&drive, &noise(40_000, 5), 8000.0), None);
    }

    /// A rotor by its definition, of which the square of the speed shakes.
    #[test]
    fn a_motor_is_found_within_some_hundredths() {
        for (time, running) in [(0.012, 0.1), (0.035, 0.16), (0.09, 0.3)] {
            let drive = crate::actuator::identify::stimulus::steps(3.0, time, 8000.0).unwrap();
            let (mut speed, mut angle) = (0.0_f64, 0.0_f64);
            let shakes: Vec<f64> = drive
                .iter()
                .map(|v| {
                    speed = (speed + (500.0 * (v - 3.0 * running) - speed) / (time * 8000.0)).max(0.0);
                    angle += speed / 8000.0;
                    speed * speed * angle.sin()
                })
                .collect();
            for samples in [0, 900, 12_000] {
                let hiss = noise(100_000, 9);
                let x: Vec<f64> =
                    late(&shakes, samples, 100_000).iter().zip(&hiss).map(|(x, h)| x + 2e3 * h).collect();
                let lag = turned(&drive, &x, 8000.0).unwrap_or_else(|| panic!("{time}"));
                let off = lag.seconds - samples as f64 / 8000.0;
                assert!(off.abs() < 0.02, "{time} {samples}: {off}");
                // Nothing at all before it and behind it, as an editor leaves it.
                let there = samples as usize..samples as usize + drive.len();
                let gated: Vec<f64> =
                    x.iter().enumerate().map(|(n, x)| if there.contains(&n) { *x } else { 0.0 }).collect();
                let again = turned(&drive, &gated, 8000.0).unwrap_or_else(|| panic!("{time}, gated"));
                let off = again.seconds - samples as f64 / 8000.0;
                assert!(off.abs() < 0.02, "{time} {samples}, gated: {off}");
            }
            assert_eq!(turned(&drive, &noise(100_000, 10), 8000.0), None);
        }
    }
}
