//! A pulse of known shape through coupling that takes its steady part away.
//!
//! The coupling's inverse is an integrator: to keep up a voltage behind a capacitor, the one before it must rise, and where it has
//! risen to, it stands after the pulse. So the samples of a pulse begin with a lead-in, which charges the capacitor the other way by a
//! voltage too small to matter, if that makes room; and end with a discharge by no more than that voltage. What full scale and amplifier
//! keep from the actuator is simulated and told.

use super::coupling::HighPass;
use super::{Chain, Link};
use crate::actuator::fault::{Fault, not_negative, positive};

/// What a pulse may cost besides itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Volts (or amperes) at the actuator that do not matter before and after the pulse: below what starts a motor.
    pub quiet: f64,
    /// Seconds of lead-in, at most.
    pub lead: f64,
    /// Seconds of discharge, at most.
    pub tail: f64,
}

/// A pulse as samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaped {
    /// Samples, within ±1.
    pub samples: Vec<f64>,
    /// Samples of lead-in, before the pulse itself.
    pub lead: usize,
    /// Volts (or amperes) that the actuator gets, the mean over each sample.
    pub given: Vec<f64>,
    /// What it does not get.
    pub shortfall: Shortfall,
}

/// What an actuator does not get of a pulse. All are 0 where nothing is short.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shortfall {
    /// The largest difference in the pulse, volts (or amperes).
    pub worst: f64,
    /// Volt-seconds (or ampere-seconds) that are missing, differences in either sense added up.
    pub missing: f64,
    /// The same as a share of the pulse's own.
    pub share: f64,
    /// The most outside of the pulse beyond what does not matter, volts (or amperes).
    pub outside: f64,
}

/// From one length of lead-in that is tried to the next.
const LONGER: f64 = 1.1;
/// Of full scale: differences below this are rounding.
const ROUNDING: f64 = 1e-9;

/// Samples that bring the actuator the `wanted` volts (or amperes, as the amplifier imposes) at `rate` samples a second, one after another.
///
/// # Errors
/// A figure that cannot be.
pub fn compensate(chain: &Chain, rate: f64, wanted: &[f64], allowance: &Allowance) -> Result<Shaped, Fault> {
    chain.check()?;
    positive("rate", rate)?;
    positive("quiet", allowance.quiet)?;
    not_negative("lead", allowance.lead)?;
    not_negative("tail", allowance.tail)?;
    let make = |lead, tail| shape(chain, rate, wanted, allowance.quiet, lead, tail);
    let share = |lead| make(lead, 0).map(|shaped| shaped.shortfall.share);
    let count = |seconds: f64| (seconds * rate).min(1e9) as usize;
    let mut best = ((0, 1.0), share((0, 1.0))?);
    // The shortest lead-in that is enough, or the one that leaves the least.
    let mut length = 1.0;
    while best.1 > 0.0 && !chain.corners.hertz().is_empty() && length as usize <= count(allowance.lead) {
        for sign in [1.0, -1.0] {
            let lead = (length as usize, sign);
            let share = share(lead)?;
            if share < best.1 {
                best = (lead, share);
            }
        }
        length = (length * LONGER).max(length + 1.0);
    }
    make(best.0, count(allowance.tail))
}

/// The samples as they would be without compensation, and what becomes of them.
///
/// # Errors
/// A figure that cannot be.
pub fn plain(chain: &Chain, rate: f64, wanted: &[f64]) -> Result<Shaped, Fault> {
    let gain = chain.full_scale * chain.amplifier.signed_gain();
    let samples = wanted.iter().map(|volts| (volts / gain).clamp(-1.0, 1.0)).collect();
    told(chain, rate, wanted, samples, 0, f64::INFINITY)
}

/// With a lead-in of so many samples of a sign, and a discharge of no more than so many.
fn shape(
    chain: &Chain,
    rate: f64,
    wanted: &[f64],
    quiet: f64,
    (lead, sign): (usize, f64),
    tail: usize,
) -> Result<Shaped, Fault> {
    let gain = chain.amplifier.signed_gain();
    let small = quiet / gain.abs();
    let mut filter = HighPass::new(&chain.corners, rate)?;
    let mut samples = Vec::with_capacity(lead + wanted.len());
    // What the converter gives, and the filter follows.
    let mut put = |filter: &mut HighPass, output: f64| {
        let sample = (filter.needed(output) / chain.full_scale).clamp(-1.0, 1.0);
        filter.step(sample * chain.full_scale);
        samples.push(sample);
    };
    (0..lead).for_each(|_| put(&mut filter, sign * small));
    wanted.iter().for_each(|&volts| put(&mut filter, chain.amplifier.within(volts) / gain));
    for _ in 0..tail {
        let output = filter.discharging(small);
        if output == 0.0 {
            break;
        }
        put(&mut filter, output);
    }
    told(chain, rate, wanted, samples, lead, quiet)
}

fn told(
    chain: &Chain,
    rate: f64,
    wanted: &[f64],
    samples: Vec<f64>,
    lead: usize,
    quiet: f64,
) -> Result<Shaped, Fault> {
    let mut link = Link::new(chain, rate)?;
    let given: Vec<f64> = samples.iter().map(|&sample| link.step(sample)).collect();
    let small = ROUNDING * chain.full_scale * chain.amplifier.gain.abs();
    let some = |x: f64| if x.abs() > small { x.abs() } else { 0.0 };
    let mut shortfall = Shortfall::default();
    let mut own = 0.0;
    for (given, wanted) in given[lead..].iter().zip(wanted) {
        let apart = some(given - wanted);
        shortfall.worst = shortfall.worst.max(apart);
        shortfall.missing += apart / rate;
        own += wanted.abs() / rate;
    }
    shortfall.share = if own > 0.0 { shortfall.missing / own } else { 0.0 };
    let after = (lead + wanted.len()).min(given.len());
    let mut beyond =
        |volts: f64| shortfall.outside = shortfall.outside.max(some((volts.abs() - quiet).max(0.0)));
    given[..lead].iter().chain(&given[after..]).for_each(|&volts| beyond(volts));
    // Behind the last sample the converter stands at 0.
    beyond(link.step(0.0));
    Ok(Shaped { samples, lead, given, shortfall })
}

#[cfg(test)]
mod tests {
    use super::super::coupling::Corners;
    use super::super::tests::chain;
    use super::{Allowance, compensate, plain};

    const RATE: f64 = 48_000.0;
    const ALLOWANCE: Allowance = Allowance { quiet: 0.15, lead: 2.0, tail: 4.0 };

    /// 2.25 ms forward, 1.6 ms in reverse: a click.
    fn click(volts: f64) -> Vec<f64> {
        (0..185).map(|n| if n < 108 { volts } else { -volts }).collect()
    }

    /// The corners of usual cards, and two in series: the click arrives as it should, with nothing of note before and after.
    #[test]
    fn a_click_arrives_behind_any_usual_corner() {
        for corners in [
            Corners::none(),
            Corners::one(2.0),
            Corners::one(10.0),
            Corners::one(20.0),
            Corners::two(10.0, 10.0),
            Corners::two(20.0, 2.0),
        ] {
            let wanted = click(2.7);
            let shaped = compensate(&chain(corners), RATE, &wanted, &ALLOWANCE).unwrap();
            assert_eq!(shaped.shortfall.share, 0.0, "{corners:?}: {:?}", shaped.shortfall);
            assert!(shaped.shortfall.outside < 0.01, "{corners:?}: {:?}", shaped.shortfall);
            for (given, wanted) in shaped.given[shaped.lead..].iter().zip(&wanted) {
                assert!((given - wanted).abs() < 1e-9, "{corners:?}: {given} {wanted}");
            }
            assert!(shaped.samples.iter().all(|x| x.abs() <= 1.0));
        }
    }

    /// Without it: a step of 5 ms droops by 27 % at 10 Hz and is followed by an undershoot of that size.
    #[test]
    fn without_compensation_it_droops_and_undershoots() {
        let wanted = vec![2.0; 240];
        let mut there = wanted.clone();
        there.extend([0.0; 10]);
        let shaped = plain(&chain(Corners::one(10.0)), RATE, &there).unwrap();
        assert!((shaped.given[239] / 2.0 - (1.0 - 0.27)).abs() < 0.005, "{}", shaped.given[239]);
        assert!((shaped.given[240] / 2.0 + 0.27).abs() < 0.005, "{}", shaped.given[240]);
        let shaped = compensate(&chain(Corners::one(10.0)), RATE, &wanted, &ALLOWANCE).unwrap();
        assert_eq!(shaped.shortfall.share, 0.0);
    }

    /// Cut off without a discharge, the capacitor's voltage is left: by as much as it drooped, less what does not matter.
    #[test]
    fn what_comes_after_is_told() {
        let cut = Allowance { tail: 0.0, ..ALLOWANCE };
        let shaped = compensate(&chain(Corners::one(10.0)), RATE, &[2.0; 240], &cut).unwrap();
        let charge = 2.0 * std::f64::consts::TAU * 10.0 * 5e-3;
        assert_eq!((shaped.shortfall.share, shaped.samples.len()), (0.0, 240));
        assert!((shaped.shortfall.outside - (charge - 0.15)).abs() < 2e-3, "{:?} {charge}", shaped.shortfall);
    }

    /// A lead-in makes room where full scale is not enough without: up to twice the droop.
    #[test]
    fn a_lead_in_makes_room() {
        // 3 V of 3.08 for 5 ms: 31 % more would be needed at the end.
        let wanted = vec![3.0; 240];
        let corners = chain(Corners::one(10.0));
        let none = compensate(&corners, RATE, &wanted, &Allowance { lead: 0.0, ..ALLOWANCE }).unwrap();
        assert!(none.shortfall.share > 0.05 && none.shortfall.worst > 0.3, "{:?}", none.shortfall);
        let some = compensate(&corners, RATE, &wanted, &ALLOWANCE).unwrap();
        assert_eq!(some.shortfall.share, 0.0);
        assert!(some.lead > 0 && some.given[..some.lead].iter().all(|v| v.abs() <= 0.15 + 1e-9));
    }

    /// What cannot be done is told: a long pulse through a high corner, more volts than the amplifier has.
    #[test]
    fn what_is_missing_is_told() {
        let wanted = vec![2.8; 4800];
        let shaped = compensate(&chain(Corners::one(20.0)), RATE, &wanted, &ALLOWANCE).unwrap();
        assert!(shaped.shortfall.share > 0.3, "{:?}", shaped.shortfall);
        let missing: f64 =
            shaped.given[shaped.lead..].iter().zip(&wanted).map(|(g, w)| (g - w).abs() / RATE).sum();
        assert!((missing / shaped.shortfall.missing - 1.0).abs() < 1e-6);
        let mut weak = chain(Corners::none());
        weak.amplifier.volts = Some(2.0);
        let shaped = compensate(&weak, RATE, &click(2.5), &ALLOWANCE).unwrap();
        assert!((shaped.shortfall.worst - 0.5).abs() < 1e-12 && (shaped.shortfall.share - 0.2).abs() < 1e-9);
        let silent = compensate(&weak, RATE, &[], &ALLOWANCE).unwrap();
        assert!(silent.samples.is_empty() && silent.shortfall.share == 0.0);
    }

    #[test]
    fn an_allowance_that_cannot_be_is_refused() {
        let fault = |a: Allowance| compensate(&chain(Corners::one(8.0)), RATE, &[1.0], &a).unwrap_err().field;
        assert_eq!(fault(Allowance { quiet: 0.0, ..ALLOWANCE }), "quiet");
        assert_eq!(fault(Allowance { lead: -1.0, ..ALLOWANCE }), "lead");
        assert_eq!(fault(Allowance { tail: f64::NAN, ..ALLOWANCE }), "tail");
    }
}
