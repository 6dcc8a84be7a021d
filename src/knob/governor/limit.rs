//! Which limit binds, and what would lift it.

use super::device::{Delay, Device};
use crate::actuator::fault::Fault;
use crate::knob::velocity::choice::Choice;
use std::fmt;

/// What keeps a stiffness down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Torque is held over a tick.
    Sampling,
    /// Torque comes late.
    Delay,
    /// Damping is computed from differences, which come late themselves.
    ComputedDamping,
    /// What makes a speed of angles comes late, and with it the computed damping.
    Estimator,
    /// The encoder's steps exceed what dry friction covers.
    Quantisation,
    /// The shaft twists.
    Resonance,
    /// The reconstruction low-pass comes late.
    LowPass,
    /// A count asks for more than the peak torque.
    Torque,
}

/// What would lift it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Remedy {
    /// Blocks of so many frames.
    Block(u32),
    /// A delay of so many ticks.
    Delay(f64),
    /// A delay of so many ticks of what depends on the angle alone, where that is sooner than all else.
    Local(f64),
    /// A tick at so many hertz, at the same delay in seconds.
    Rate(f64),
    /// An encoder of so many counts a turn.
    Counts(f64),
    /// Twice the damping of the device, N m s/rad.
    Damping(f64),
    /// Half the computed damping, N m s/rad.
    HalfDamping(f64),
    /// Speed by a quicker estimator.
    Estimator(Choice),
    /// No reconstruction low-pass.
    NoLowPass,
    /// A stiff shaft.
    StiffShaft,
    /// Twice the peak torque, N m.
    Peak(f64),
}

/// What binds a stiffness, and what would lift it.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The largest stiffness, N m/rad.
    pub stiffness: f64,
    /// The edge of stability itself, N m/rad, and the frequency at which the knob swings there, hertz.
    pub edge: (f64, f64),
    /// What binds.
    pub binds: Limit,
    /// What would lift it and how many times more it would allow, the strongest first.
    pub remedies: Vec<(Remedy, f64)>,
}

/// Blocks that sound cards may be asked for.
const LEAST_BLOCK: u32 = 16;
/// A remedy that allows less than this much more is none.
const WORTH: f64 = 1.05;

fn most(device: &Device, margin: f64, damping: f64) -> Result<f64, Fault> {
    let sampled = device.sampled()?;
    Ok(f64::min(margin * sampled.edge(damping).gain, device.still()))
}

/// Tries each cause and each remedy on the exact edge.
pub(super) fn explain(device: &Device, margin: f64, damping: f64) -> Result<Explanation, Fault> {
    let edge = device.sampled()?.edge(damping);
    let now = most(device, margin, damping)?;
    let faster = |times: f64, d: &Device| Device {
        period: d.period / times,
        delay: d.delay.times(times),
        ..d.clone()
    };
    let no_delay = Device { delay: Delay::ticks(0.0), ..device.clone() };
    let no_filter = Device { low_pass: None, ..device.clone() };
    let rigid = Device { resonance: None, ..device.clone() };
    let quick = Device { velocity: Choice::Difference, ..device.clone() };
    let gain = |d: &Device, b: f64| d.sampled().map(|l| l.edge(b).gain).unwrap_or(0.0);
    let binds = if device.peak / device.count <= now {
        Limit::Torque
    } else if device.covered() <= now {
        Limit::Quantisation
    } else if gain(device, 0.0).max(gain(device, 0.5 * damping)) > edge.gain * WORTH {
        // Computed damping adds stiffness up to a point; here it is beyond, by itself or for what it is computed of.
        let by_itself = gain(&quick, 0.0).max(gain(&quick, 0.5 * damping)) > gain(&quick, damping) * WORTH;
        if by_itself { Limit::ComputedDamping } else { Limit::Estimator }
    } else {
        // What is gained where one cause alone is taken away.
        [
            (Limit::Sampling, gain(&faster(4.0, device), damping)),
            (Limit::Delay, gain(&no_delay, damping)),
            (Limit::LowPass, gain(&no_filter, damping)),
            (Limit::Resonance, gain(&rigid, damping)),
            (Limit::Estimator, gain(&quick, damping)),
        ]
        .into_iter()
        .fold((Limit::Sampling, 0.0), |best, next| if next.1 > best.1 * 1.000_1 { next } else { best })
        .0
    };
    let mut tries: Vec<(Remedy, Device, f64)> = Vec::new();
    let mut offer = |remedy, device, damping| tries.push((remedy, device, damping));
    if device.delay.sooner() > 0 {
        let half = 0.5 * device.delay.spring();
        let delay = Delay { local: Some(half), ..device.delay };
        offer(Remedy::Local(half), Device { delay, ..device.clone() }, damping);
    }
    if device.delay.block > LEAST_BLOCK {
        let delay = Delay { block: LEAST_BLOCK, ..device.delay };
        offer(Remedy::Block(LEAST_BLOCK), Device { delay, ..device.clone() }, damping);
    } else if device.delay.total() > 0.0 {
        let half = 0.5 * device.delay.total();
        offer(Remedy::Delay(half), Device { delay: device.delay.times(0.5), ..device.clone() }, damping);
    }
    offer(Remedy::Rate(2.0 / device.period), faster(2.0, device), damping);
    let counts = 2.0 * std::f64::consts::TAU / device.count;
    offer(Remedy::Counts(counts), Device { count: 0.5 * device.count, ..device.clone() }, damping);
    let more = 2.0 * device.damping;
    offer(Remedy::Damping(more), Device { damping: more, ..device.clone() }, damping);
    offer(Remedy::Peak(2.0 * device.peak), Device { peak: 2.0 * device.peak, ..device.clone() }, damping);
    if damping > 0.0 {
        offer(Remedy::HalfDamping(0.5 * damping), device.clone(), 0.5 * damping);
        if let Some(velocity) = device.velocity.quicker() {
            offer(Remedy::Estimator(velocity), Device { velocity, ..device.clone() }, damping);
        }
    }
    if device.low_pass.is_some() {
        offer(Remedy::NoLowPass, no_filter, damping);
    }
    if device.resonance.is_some() {
        offer(Remedy::StiffShaft, rigid, damping);
    }
    let mut remedies = Vec::new();
    for (remedy, device, damping) in tries {
        // A remedy may be out of range (a delay too long in shorter ticks): then it is none.
        let times = most(&device, margin, damping).map_or(0.0, |more| more / now);
        if times > WORTH {
            remedies.push((remedy, times));
        }
    }
    remedies.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(Explanation { stiffness: now, edge: (edge.gain, edge.hertz), binds, remedies })
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sampling => "the rate",
            Self::Delay => "the delay",
            Self::ComputedDamping => "computed damping",
            Self::Estimator => "the velocity estimator",
            Self::Quantisation => "the encoder's counts against dry friction",
            Self::Resonance => "the shaft's resonance",
            Self::LowPass => "the reconstruction low-pass",
            Self::Torque => "the peak torque",
        })
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Block(frames) => write!(f, "block {frames}"),
            Self::Delay(ticks) => write!(f, "a delay of {ticks} ticks"),
            Self::Local(ticks) => write!(f, "a delay of {ticks} ticks on the line"),
            Self::Rate(hertz) => write!(f, "a rate of {hertz:.0} Hz"),
            Self::Counts(counts) => write!(f, "an encoder of {counts:.0} counts a turn"),
            Self::Damping(b) => write!(f, "a damping of {b:.3e} N m s/rad in the device"),
            Self::HalfDamping(b) => write!(f, "a computed damping of {b:.3e} N m s/rad"),
            Self::Estimator(choice) => choice.fmt(f),
            Self::NoLowPass => f.write_str("no reconstruction low-pass"),
            Self::StiffShaft => f.write_str("a stiff shaft"),
            Self::Peak(torque) => write!(f, "a peak torque of {torque} N m"),
        }
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "up to {:.3} N m/rad, bound by {}", self.stiffness, self.binds)?;
        self.remedies.iter().try_for_each(|(remedy, times)| {
            let digits = usize::from(*times < 9.95);
            write!(f, "; {remedy} would allow {times:.digits$} times")
        })
    }
}
