//! A recording, and what can be wrong with it.

use std::fmt;

use crate::actuator::fault::{Fault, Shown};

/// Samples a second of a recording, at least and at most: no converter is slower or faster.
pub const RATES: (f64, f64) = (10.0, 1e7);

/// One channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel<'a> {
    /// What was recorded.
    pub samples: &'a [f64],
    /// Samples a second, as [`RATES`] are.
    pub rate: f64,
    /// The largest value that its converter gives, if known; lets what is clipped or silent be seen for certain.
    pub full_scale: Option<f64>,
}

/// Which channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Name {
    /// The voltage that was wished for.
    Drive,
    /// Of the casing or the contactor.
    Acceleration,
    /// Of the coil.
    Current,
    /// At the terminals.
    Voltage,
}

/// What is wrong with a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mistake {
    /// A figure beside the channels is beyond its limits.
    Fault(Fault),
    /// So many samples, where the drive has so many.
    Length(Name, usize, usize),
    /// So many samples a second, where the drive has so many.
    Rate(Name, f64, f64),
    /// A sample is no number: this one.
    NotANumber(Name, usize),
    /// Nothing but the same value, or no peak above a limit: peak and limit.
    Silent(Name, f64, f64),
    /// It stays at its extreme value so many times.
    Clipped(Name, f64, usize),
    /// Seconds that can be used, and those that are needed; what they are.
    Short(f64, f64, &'static str),
    /// The drive is the same all the time.
    Constant(f64),
    /// Signal to noise, and the least that allows a fit, dB.
    Noise(Name, f64, f64),
    /// Samples a second, the least for a frequency, and that frequency, Hz.
    Slow(f64, f64, f64),
    /// The drive does not reach the resonance: where that seems to be, and the lowest and highest frequency driven, Hz.
    Uncovered(f64, f64, f64),
}

/// A peak below this share of the full scale is silence.
const SILENT: f64 = 1e-4;
/// Equal samples at an extreme, one after the other, from which on it is an edge.
const EDGE: usize = 3;
/// So many edges are no accident.
const MOST_EDGES: usize = 2;
/// A step to an edge is larger than so many of the smallest steps there are.
const LEAP: f64 = 4.0;

impl Channel<'_> {
    /// Whether it can be used with a drive.
    pub(super) fn check(&self, name: Name, drive: &Channel) -> Result<(), Mistake> {
        crate::actuator::fault::within("rate", self.rate, RATES, "samples a second")?;
        if let Some(full) = self.full_scale {
            crate::actuator::fault::positive("full_scale", full)?;
        }
        if (self.rate - drive.rate).abs() > 1e-9 * drive.rate {
            return Err(Mistake::Rate(name, self.rate, drive.rate));
        }
        if self.samples.len() != drive.samples.len() {
            return Err(Mistake::Length(name, self.samples.len(), drive.samples.len()));
        }
        self.usable(name)
    }

    /// Whether it can be used by itself: numbers, neither silent nor clipped; of a drive, that it changes.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn usable(&self, name: Name) -> Result<(), Mistake> {
        if let Some(at) = self.samples.iter().position(|x| x.abs() > 1e12 || x.is_nan()) {
            return Err(Mistake::NotANumber(name, at));
        }
        let (least, most) = extremes(self.samples);
        if name == Name::Drive {
            return if most > least { Ok(()) } else { Err(Mistake::Constant(least)) };
        }
        let limit = self.full_scale.map_or(0.0, |full| SILENT * full);
        if 0.5 * (most - least) <= limit {
            return Err(Mistake::Silent(name, 0.5 * (most - least), limit));
        }
        for edge in [least, most] {
            let times = edges(self.samples, edge, self.full_scale);
            if times >= MOST_EDGES {
                return Err(Mistake::Clipped(name, edge, times));
            }
        }
        Ok(())
    }
}

/// The least and the largest sample.
fn extremes(samples: &[f64]) -> (f64, f64) {
    samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), &x| (l.min(x), m.max(x)))
}

/// How often samples stay at an extreme value that they come to with a leap. A quiet sine in few bits stays at its top too, but comes to it
/// by the smallest step there is.
fn edges(samples: &[f64], edge: f64, full: Option<f64>) -> usize {
    // No converter ends at 0: there a signal rests.
    if edge == 0.0 {
        return 0;
    }
    let at_end = full.is_some_and(|full| edge.abs() >= 0.999 * full);
    let distances = samples.iter().map(|x| (x - edge).abs()).filter(|d| *d > 0.0);
    let smallest = distances.fold(f64::INFINITY, f64::min);
    let (mut times, mut begin) = (0, 0);
    while begin < samples.len() {
        let length = samples[begin..].iter().take_while(|x| **x == samples[begin]).count();
        if samples[begin] == edge && length >= EDGE {
            let before = begin.checked_sub(1).map_or(0.0, |n| (samples[n] - edge).abs());
            let behind = samples.get(begin + length).map_or(0.0, |x| (x - edge).abs());
            times += usize::from(at_end || before.max(behind) > LEAP * smallest);
        }
        begin += length;
    }
    times
}

impl From<Fault> for Mistake {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Drive => "`drive`",
            Self::Acceleration => "`acceleration`",
            Self::Current => "`current`",
            Self::Voltage => "`voltage`",
        })
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => fault.fmt(f),
            Self::Length(name, is, drive) => write!(
                f,
                "{name} has {is} samples, but must have the {drive} of `drive`: record both at once, and cut both alike"
            ),
            Self::Rate(name, is, drive) => write!(
                f,
                "{name} has {is} samples a second, but must have the {drive} of `drive`: record both at one rate"
            ),
            Self::NotANumber(name, at) => {
                write!(
                    f,
                    "{name} is no number at sample {at}, or is beyond ±1e12: record it again, or give its scale anew"
                )
            }
            Self::Silent(name, peak, limit) => write!(
                f,
                "{name} is silent: it peaks at {} about its middle, but must do so above {}: connect it, or turn it up",
                Shown(*peak),
                Shown(*limit)
            ),
            Self::Clipped(name, edge, times) => write!(
                f,
                "{name} is clipped: it stays at {edge} {times} times, but must do so less than {MOST_EDGES} times: turn it down"
            ),
            Self::Short(is, least, what) => {
                write!(f, "the recording is too short: {is:.4} s of {what}, but {least:.4} s are needed")
            }
            Self::Constant(value) => {
                let value = Shown(*value);
                write!(f, "`drive` is {value} all the time, but must change: play a step, a burst or a sweep")
            }
            Self::Noise(name, is, least) => write!(
                f,
                "{name} has {is:.1} dB signal to noise, but must have at least {least:.1} dB: fix the sensor firmly, drive harder, or \
                 record what belongs to this drive"
            ),
            Self::Slow(rate, least, hertz) => write!(
                f,
                "`rate` is {rate}, but must be at least {least:.0} samples a second for the {hertz:.1} Hz that were seen: record faster"
            ),
            Self::Uncovered(hertz, low, high) => write!(
                f,
                "`drive` reaches from {low:.1} to {high:.1} Hz, but must go well beyond the resonance, near {hertz:.1} Hz, on both sides"
            ),
        }
    }
}

impl std::error::Error for Mistake {}

#[cfg(test)]
mod tests {
    use super::{Channel, Mistake, Name};

    fn channel(samples: &[f64]) -> Channel<'_> {
        Channel { samples, rate: 48e3, full_scale: None }
    }

    fn checked(samples: &[f64], full_scale: Option<f64>) -> Result<(), Mistake> {
        let drive = vec![0.0; samples.len()];
        Channel { full_scale, ..channel(samples) }.check(Name::Acceleration, &channel(&drive))
    }

    fn sine(amplitude: f64, hertz: f64) -> Vec<f64> {
        (0..4800).map(|n| amplitude * (std::f64::consts::TAU * hertz * f64::from(n) / 48e3).sin()).collect()
    }

    #[test]
    fn what_is_clipped_is_told_from_what_is_coarse() {
        let clipped: Vec<f64> = sine(1.3, 177.0).iter().map(|x| x.clamp(-1.0, 1.0)).collect();
        let Err(Mistake::Clipped(Name::Acceleration, -1.0, times)) = checked(&clipped, None) else {
            panic!()
        };
        assert_eq!(times, 18);
        let text = checked(&clipped, None).unwrap_err().to_string();
        assert!(
            text.starts_with("`acceleration` is clipped: it stays at -1 18 times")
                && text.ends_with("turn it down")
        );
        // 100 steps of a converter: some equal samples at each top.
        let coarse: Vec<f64> = sine(100.0, 50.0).iter().map(|x| x.round()).collect();
        assert!(coarse.windows(3).any(|w| w == [100.0; 3]));
        assert_eq!(checked(&coarse, None), Ok(()));
        assert_eq!(checked(&coarse, Some(32768.0)), Ok(()));
        // The same at the end of the scale is clipped.
        assert!(matches!(checked(&coarse, Some(100.0)), Err(Mistake::Clipped(..))));
        assert_eq!(checked(&sine(1.0, 177.0), None), Ok(()));
    }

    #[test]
    fn what_does_not_belong_together_is_named() {
        let (x, drive) = (sine(1.0, 100.0), sine(3.0, 100.0));
        let drive = channel(&drive);
        let err = |c: &Channel, name| c.check(name, &drive).unwrap_err();
        assert_eq!(err(&channel(&x[1..]), Name::Current), Mistake::Length(Name::Current, 4799, 4800));
        let slow = Channel { rate: 44.1e3, ..channel(&x) };
        assert_eq!(err(&slow, Name::Voltage), Mistake::Rate(Name::Voltage, 44.1e3, 48e3));
        assert!(
            err(&slow, Name::Voltage).to_string().contains("44100")
                && err(&slow, Name::Voltage).to_string().contains("48000")
        );
        assert!(
            matches!(err(&Channel { rate: f64::NAN, ..channel(&x) }, Name::Voltage), Mistake::Fault(f) if f.field == "rate")
        );
        let zero = Channel { full_scale: Some(0.0), ..channel(&x) };
        assert!(matches!(err(&zero, Name::Voltage), Mistake::Fault(f) if f.field == "full_scale"));
        for bad in [f64::NAN, f64::INFINITY, 1e13] {
            let mut broken = x.clone();
            broken[7] = bad;
            assert_eq!(
                err(&channel(&broken), Name::Acceleration),
                Mistake::NotANumber(Name::Acceleration, 7)
            );
        }
    }

    #[test]
    fn silence_and_a_drive_that_does_nothing_are_named() {
        assert!(matches!(checked(&[0.5; 100], None), Err(Mistake::Silent(Name::Acceleration, 0.0, 0.0))));
        assert!(matches!(checked(&sine(3.0, 99.0), Some(32768.0)), Err(Mistake::Silent(..))));
        assert_eq!(checked(&sine(4.0, 99.0), Some(32768.0)), Ok(()));
        let flat = [2.5; 100];
        let err = channel(&flat).check(Name::Drive, &channel(&flat)).unwrap_err();
        assert_eq!(err, Mistake::Constant(2.5));
        assert!(matches!(checked(&[], None), Err(Mistake::Silent(..))));
    }
}
