//! Drives that tell much of an actuator: steps and a ramp for a motor, a sweep for a resonance.

use std::f64::consts::{PI, TAU};

use crate::actuator::fault::{Fault, positive, within};

/// Seconds of silence before anything is driven.
pub const LEAD: f64 = 0.5;
/// Shares of the voltage at which a motor runs, one after the other.
const LEVELS: [f64; 3] = [1.0, 0.5, 0.8];
/// Time constants for each of them, and the seconds that this takes at least and at most.
const SETTLED: f64 = 8.0;
const HOLD: [f64; 2] = [0.3, 4.0];
/// A ramp that grows by the same part of itself in each time constant, from one share of the voltage to another: as slow for a motor that starts
/// early as for one that starts late. Before it, the first share is reached in so many time constants.
const RAMP: [f64; 2] = [0.06, 0.6];
const SLOW: f64 = 0.04;
const FIRST: f64 = 4.0;
/// Share of a sweep in which it comes in, and in which it goes out.
const FADE: f64 = 0.05;
/// Cycles of the lowest frequency that follow a sweep as silence, and how long that is at least, s.
const RING: f64 = 4.0;
const REST: f64 = 0.5;

/// Volts for a rumble motor, sample by sample: silence, three steps of different heights while it runs, a rest, a slow ramp on which it
/// starts once more, a rest. `time` is its mechanical time constant, s, 1e-3 to 2, or what it is at most where it is not known.
///
/// # Errors
/// A figure beyond its limits: `volts` above 0, `rate` 100 to 1e6 samples a second.
pub fn steps(volts: f64, time: f64, rate: f64) -> Result<Vec<f64>, Fault> {
    positive("volts", volts)?;
    within("time_constant", time, (1e-3, 2.0), "s")?;
    within("rate", rate, (100.0, 1e6), "samples a second")?;
    let hold = (SETTLED * time).clamp(HOLD[0], HOLD[1]);
    let mut all = Vec::new();
    let mut piece = |seconds: f64, share: &dyn Fn(f64) -> f64| {
        let count = (seconds * rate).round() as usize;
        all.extend((0..count).map(|n| volts * share(n as f64 / count as f64)));
    };
    piece(LEAD, &|_| 0.0);
    LEVELS.iter().for_each(|level| piece(hold, &|_| *level));
    piece(hold, &|_| 0.0);
    let [from, to] = RAMP;
    piece(FIRST * time, &|part| from * part);
    piece((to / from).ln() / SLOW * time, &|part| from * (to / from).powf(part));
    piece(hold, &|_| to);
    piece(hold, &|_| 0.0);
    Ok(all)
}

/// Volts for a resonance, sample by sample: silence, a logarithmic sweep that fades in and out, silence.
///
/// # Errors
/// A figure beyond its limits: `volts` above 0, frequencies from 1 Hz to 0.45 of the `rate`, the second above the first; `seconds` 0.1 to 100.
pub fn sweep(volts: f64, [from, to]: [f64; 2], seconds: f64, rate: f64) -> Result<Vec<f64>, Fault> {
    positive("volts", volts)?;
    within("rate", rate, (100.0, 1e6), "samples a second")?;
    within("from", from, (1.0, 0.45 * rate), "Hz")?;
    within("to", to, (from * 1.01, 0.45 * rate), "Hz")?;
    within("seconds", seconds, (0.1, 100.0), "s")?;
    let slope = (to / from).ln() / seconds;
    let count = (seconds * rate).round() as usize;
    let silence = |seconds: f64| vec![0.0; (seconds * rate).round() as usize];
    let mut all = silence(LEAD);
    all.extend((0..count).map(|n| {
        let t = n as f64 / rate;
        let edge = (t / seconds).min(1.0 - t / seconds) / FADE;
        let swell = 0.5 - 0.5 * (PI * edge.clamp(0.0, 1.0)).cos();
        volts * swell * (TAU * from * ((slope * t).exp() - 1.0) / slope).sin()
    }));
    all.extend(silence((RING / from).max(REST)));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::{steps, sweep};
    use std::f64::consts::TAU;

    #[test]
    fn a_motor_gets_three_levels_and_a_ramp_that_rises_slowly() {
        let volts = steps(3.0, 0.05, 1000.0).unwrap();
        let at = |seconds: f64| volts[(seconds * 1000.0) as usize];
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        for (seconds, volts) in [(0.49, 0.0), (0.51, 3.0), (0.91, 1.5), (1.31, 2.4), (1.71, 0.0), (5.3, 1.8)]
        {
            assert!(close(at(seconds), volts), "{seconds}");
        }
        let ramp: Vec<f64> = volts[2101..5178].to_vec();
        assert!(ramp.windows(2).all(|v| v[1] > v[0]) && volts.iter().all(|v| (0.0..=3.0).contains(v)));
        // From 6 to 60 % it rises by 4 % within each time constant.
        assert!((volts[2300] - 0.18).abs() < 1e-3, "{}", volts[2300]);
        for n in 2300..5120 {
            assert!((volts[n + 50] / volts[n] - 0.04_f64.exp()).abs() < 1e-4, "{n}");
        }
        assert_eq!(volts[volts.len() - 1], 0.0);
    }

    /// Its frequency, counted by zero crossings, grows by equal factors in equal times.
    #[test]
    fn a_sweep_goes_over_the_octaves_evenly() {
        let volts = sweep(2.0, [20.0, 640.0], 2.5, 48e3).unwrap();
        assert!(volts[..24_000].iter().all(|v| *v == 0.0) && volts[144_000..].iter().all(|v| *v == 0.0));
        assert!(volts.iter().all(|v| v.abs() <= 2.0) && volts.iter().any(|v| v.abs() > 1.99));
        let rises =
            |from: usize, to: usize| volts[from..to].windows(2).filter(|v| v[0] < 0.0 && v[1] >= 0.0).count();
        // An octave takes half a second; f / ln 2 / 2 cycles of it lie in the one that ends at 2 f.
        for (octave, hertz) in [(1, 40.0_f64), (2, 80.0), (3, 160.0)] {
            let (from, cycles) = (24_000 + octave * 24_000, hertz * 0.5 / 2f64.ln());
            assert!((rises(from, from + 24_000) as f64 - cycles).abs() <= 1.0, "{octave}");
        }
        // It is a sine: what one sample differs from the last is bounded by the frequency.
        assert!(volts.windows(2).all(|v| (v[1] - v[0]).abs() <= 2.0 * TAU * 640.0 / 48e3 * 1.01));
    }

    #[test]
    fn what_cannot_be_is_named() {
        assert_eq!(steps(f64::NAN, 0.05, 1e3).unwrap_err().field, "volts");
        assert_eq!(steps(1.0, 9.0, 1e3).unwrap_err().field, "time_constant");
        assert_eq!(sweep(1.0, [20.0, 480.0], 1.0, 1e3).unwrap_err().field, "to");
        assert_eq!(sweep(1.0, [20.0, 400.0], f64::INFINITY, 1e3).unwrap_err().field, "seconds");
    }
}
