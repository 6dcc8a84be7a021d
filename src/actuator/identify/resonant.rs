//! Identification of a resonant actuator: voice coil, inertial motor or linear resonant actuator.
//!
//! Its acceleration for each volt is G s² / ((s² + (ω/Q) s + ω²) (1 + τ s)), with the pole pair of shorted terminals and, of the
//! inductance, a lag τ; exactly so for one mass on a spring, or for two of which no other spring holds one. Resonance, Q and G are fitted to
//! the recording itself, sample by sample, behind a drive that is held, with an unknown delay; so any drive does that moves it about its
//! resonance: a sweep, a burst, a step. With the current as a channel, V = R i + L di/dt + Bl v tells resistance and inductance, and how
//! much of the voltage is motion; with what the recorded acceleration is of the coil's own, that tells Bl.

use super::coil::Electric;
use super::estimate::Identified;
use super::held::Held;
use super::least::{Fit, descend};
use super::recording::{Channel, Mistake, Name};
use super::spectrum::Spectra;
use crate::actuator::fault::within;

/// What was recorded of a resonant actuator. All channels begin in the same instant, at rest, and have the same rate.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// Volts at the terminals, held from each sample to the next.
    pub drive: Channel<'a>,
    /// Of contactor or casing; m/s² where it `is_calibrated`, else in any unit.
    pub acceleration: Channel<'a>,
    /// Whether `acceleration` is in m/s².
    pub is_calibrated: bool,
    /// Of the coil, A.
    pub current: Option<Channel<'a>>,
    /// The recorded acceleration as a share of the one between coil and magnet, 1e-6 to 1, if known: 1 for a contactor whose housing is
    /// held, the slug's share of all that moves for a free casing.
    pub share: Option<f64>,
}

/// The fitted motion.
pub(super) struct Motion {
    /// ω, Q, G, delay, offset; and the taps of what comes through at once, or what makes the lag.
    pub fit: Fit,
    taps: bool,
    rate: f64,
}

/// Least signal to noise, dB.
const LEAST: f64 = 6.0;
/// Cycles of the resonance in a recording.
const CYCLES: f64 = 4.0;
/// Samples of a cycle of the resonance.
const PER_CYCLE: f64 = 6.0;
/// Samples of a recording.
const SAMPLES: usize = 64;
/// Taps must take off the squares so many times what is left of one to be better than a lag.
const WORTH: f64 = 20.0;
/// A lag is at least this share of a sample, so that what comes out changes with the delay smoothly; what more it is in samples is the
/// square of a parameter, which is this at first.
const LEAST_LAG: f64 = 0.1;
pub(super) const LAG: f64 = 0.6;
/// Seconds of lead and delay of a recording chain that are looked for, at so many samples a period.
const DELAYS: [f64; 2] = [0.01, 0.3];
const COARSE: f64 = 16.0;
/// With less than this left a guess needs no other beside it.
const GOOD: f64 = 0.1;

/// What a recording tells of a resonant actuator.
///
/// Rig keys: `resonance`, `q`, `sensitivity` (m/s² a volt at the resonance); with a current `resistance`, `inductance`, and `force_factor` where
/// the share of the acceleration is known. Those that the recording does not tell are in `untold` of [`Identified`], each with its reason. Beside
/// keys: `delay`, s, of the recording behind the drive; with a current `open_resonance`, Hz, and `open_q`, those of open terminals.
///
/// # Errors
/// What is wrong with the recording.
pub fn identify(recording: &Recording) -> Result<Identified, Mistake> {
    let r = recording;
    let (drive, rate) = (r.drive.samples, r.drive.rate);
    r.drive.check(Name::Drive, &r.drive)?;
    r.acceleration.check(Name::Acceleration, &r.drive)?;
    r.current.map_or(Ok(()), |current| current.check(Name::Current, &r.drive))?;
    r.share.map_or(Ok(()), |share| {
        within("share", share, (1e-6, 1.0), "of the acceleration between coil and magnet")
    })?;
    if drive.len() < SAMPLES {
        return Err(Mistake::Short(drive.len() as f64 / rate, SAMPLES as f64 / rate, "samples"));
    }
    let x = r.acceleration.samples;
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let power = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / x.len() as f64;
    let level: Vec<f64> = x.iter().map(|x| x - mean).collect();
    let spectra = Spectra::new(drive, &level, rate);
    let (low, high) = spectra.driven();
    let motion = Motion::best(drive, &level, rate, &spectra.guesses(), power);
    let Some(motion) = motion else { return Err(Mistake::Uncovered(spectra.peak(), low, high)) };
    let [hertz, q] = [motion.fit.values[0] / std::f64::consts::TAU, motion.fit.values[1]];
    let signal_to_noise =
        10.0 * ((power - motion.fit.left).max(1e-300) / motion.fit.left.max(1e-300)).log10();
    if signal_to_noise < LEAST || signal_to_noise.is_nan() {
        return Err(Mistake::Noise(Name::Acceleration, signal_to_noise, LEAST));
    }
    let half = 1.0 + 0.5 / q.max(1.0);
    if !(hertz > low * half && hertz * half < high) {
        return Err(Mistake::Uncovered(hertz, low, high));
    }
    if rate < PER_CYCLE * hertz {
        return Err(Mistake::Slow(rate, PER_CYCLE * hertz, hertz));
    }
    let seconds = drive.len() as f64 / rate;
    if seconds * hertz < CYCLES {
        return Err(Mistake::Short(seconds, CYCLES / hertz, "the resonance's cycles"));
    }
    let mut all = Identified { signal_to_noise, ..Identified::default() };
    motion.tell(r, &mut all);
    let current = r.current.and_then(|current| Electric::of(drive, current.samples, rate, &motion));
    match (&r.current, current) {
        (_, Some(current)) => current.tell(r, &motion, &mut all),
        (Some(_), None) => {
            let why = "the current does not belong to voltage and motion: check its channel and its sign";
            ABSOLUTE.iter().for_each(|name| all.untold(name, why));
        }
        (None, None) => ABSOLUTE.iter().for_each(|name| all.untold(name, "record the current as well")),
    }
    Ok(all)
}

/// Keys that need a current.
const ABSOLUTE: [&str; 3] = ["resistance", "inductance", "force_factor"];

/// Taps.
const TAPS: usize = 4;

/// Whether a pole pair can be.
fn sound(p: &[f64], rate: f64) -> bool {
    p[0] > 0.0 && p[0] < std::f64::consts::PI * rate && p[1] > 0.05 && p[1] < 1e4
}

/// Samples of lag for a parameter.
pub(super) fn lag(parameter: Option<&f64>) -> f64 {
    let parameter = parameter.copied().unwrap_or(LAG);
    LEAST_LAG + parameter * parameter
}

/// Delay and gain with which a pole pair agrees best with a response, at some samples a period.
fn located(drive: &[f64], x: &[f64], rate: f64, omega: f64, q: f64) -> Option<[f64; 2]> {
    let out = Held::resonance(omega, q, lag(None) / rate).play(drive, 1.0 / rate, 0.0)?;
    let every = ((std::f64::consts::TAU * rate / (omega * COARSE)) as usize).max(1);
    let coarse = |x: &[f64]| -> Vec<f64> { x.chunks(every).map(|x| x.iter().sum()).collect() };
    let (x, out) = (coarse(x), coarse(&out));
    let agrees = |late: isize| -> f64 {
        let (x, out) =
            if late >= 0 { (&x[late as usize..], &out[..]) } else { (&x[..], &out[-late as usize..]) };
        x.iter().zip(out).map(|(x, y)| x * y).sum()
    };
    let [lead, late] = DELAYS.map(|s| ((s * rate) as usize / every).min(x.len() / 2) as isize);
    let all = (-lead..=late).map(|late| (late, agrees(late)));
    let (late, sum) = all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let power = out.iter().map(|y| y * y).sum::<f64>();
    (power > 0.0).then(|| [(late * every as isize) as f64 / rate, sum / power])
}

impl Motion {
    /// The best fit: from some guesses with a fixed lag, then with all that is free.
    fn best(drive: &[f64], x: &[f64], rate: f64, guesses: &[(f64, f64)], power: f64) -> Option<Self> {
        let mut best: Option<Fit> = None;
        for (omega, q) in guesses {
            let Some([delay, gain]) = located(drive, x, rate, *omega, *q) else { continue };
            let start = [*omega, *q, gain, delay, 0.0];
            let better = |fit: &Fit| best.as_ref().is_none_or(|best| fit.left < best.left);
            if let Some(fit) = Self::fit(drive, x, rate, &start).filter(better) {
                let good = fit.left < GOOD * power;
                best = Some(fit);
                if good {
                    break;
                }
            }
        }
        Self::finished(best?, drive, x, rate)
    }

    /// The last fit. What rings follows the pole pair; what comes through at once, and how converters and inductance smear it over the samples
    /// about its delay, is left open: some taps.
    fn finished(first: Fit, drive: &[f64], x: &[f64], rate: f64) -> Option<Self> {
        let [omega, q, gain, delay, offset] = [0, 1, 2, 3, 4].map(|n| first.values[n]);
        let nearest = (delay * rate).floor() as isize - 1;
        let mut start = vec![omega, q, gain, delay + lag(None) / rate, offset];
        start.extend([0.0, 0.5 * gain, 0.5 * gain, 0.0]);
        let mut steps = Self::steps(&start, x, rate);
        steps.resize(start.len(), 1e-5 * gain.abs());
        let at = |n: isize| if n < 0 { 0.0 } else { drive[(n as usize).min(drive.len() - 1)] };
        let fit = descend(&start, &steps, |p| {
            let out = sound(p, rate).then(|| Held::rings(p[0], p[1]).play(drive, 1.0 / rate, p[3]))??;
            let rest = |(n, (y, x)): (usize, (&f64, &f64))| {
                let through: f64 = (0..TAPS).map(|k| p[5 + k] * at(n as isize - nearest - k as isize)).sum();
                p[2] * y + through + p[4] - x
            };
            Some(out.iter().zip(x).enumerate().map(rest).collect())
        })?;
        let worse = |lagged: &Fit| (lagged.left - fit.left) * x.len() as f64 > WORTH * fit.left;
        match Self::lagged(&first, drive, x, rate).filter(|lagged| !worse(lagged)) {
            Some(fit) => Some(Self { fit, taps: false, rate }),
            None => Some(Self { fit, taps: true, rate }),
        }
    }

    /// With a lag for the inductance in place of taps: what a coil has, but not where samples are taken in the instant of a leap.
    fn lagged(first: &Fit, drive: &[f64], x: &[f64], rate: f64) -> Option<Fit> {
        let mut start = first.values.clone();
        start.push(LAG);
        let mut steps = Self::steps(&start, x, rate);
        steps.push(1e-4);
        descend(&start, &steps, |p| {
            let resonance = Held::resonance(p[0], p[1], lag(p.get(5)) / rate);
            let out = sound(p, rate).then(|| resonance.play(drive, 1.0 / rate, p[3]))??;
            Some(out.iter().zip(x).map(|(y, x)| p[2] * y + p[4] - x).collect())
        })
    }

    /// The gain at the resonance, where s² over the pole pair is Q; and how far off it may be.
    fn gain(&self) -> (f64, f64) {
        let slow = |p: &[f64]| if self.taps { 1.0 } else { (p[0] * lag(p.get(5)) / self.rate).hypot(1.0) };
        let figure = |p: &[f64]| p[2].abs() * p[1] / slow(p);
        let value = figure(&self.fit.values);
        (value, self.fit.off_of(figure) + self.unseen() * value)
    }

    /// What taps hide of a lag within half a sample: its share of a gain at the resonance.
    pub fn unseen(&self) -> f64 {
        let half = 0.5 * self.fit.values[0] / self.rate;
        if self.taps { 0.5 * half * half } else { 0.0 }
    }

    fn steps(start: &[f64], x: &[f64], rate: f64) -> Vec<f64> {
        let peak = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        vec![1e-6 * start[0], 1e-5 * start[1], 1e-5 * start[2].abs(), 1e-4 / rate, 1e-5 * peak]
    }

    fn fit(drive: &[f64], x: &[f64], rate: f64, start: &[f64]) -> Option<Fit> {
        descend(start, &Self::steps(start, x, rate), |p| {
            let resonance = Held::resonance(p[0], p[1], lag(None) / rate);
            let out = sound(p, rate).then(|| resonance.play(drive, 1.0 / rate, p[3]))??;
            Some(out.iter().zip(x).map(|(y, x)| p[2] * y + p[4] - x).collect())
        })
    }

    fn tell(&self, r: &Recording, all: &mut Identified) {
        let fit = &self.fit;
        let told = |figure: &dyn Fn(&[f64]) -> f64| (figure(&fit.values), fit.off_of(figure));
        let (hertz, off) = told(&|p| p[0] / std::f64::consts::TAU);
        all.key("resonance", "Hz", hertz, [off; 2]);
        let (q, off) = told(&|p| p[1]);
        all.key("q", "1", q, [off; 2]);
        if r.is_calibrated {
            let (gain, off) = self.gain();
            all.key("sensitivity", "m/s2/V", gain, [off; 2]);
        } else {
            all.untold("sensitivity", "the accelerometer is not calibrated: record in m/s2");
        }
        let (delay, off) = told(&|p| p[3]);
        all.aside("delay", "s", delay, off);
    }
}

#[cfg(test)]
mod tests;
