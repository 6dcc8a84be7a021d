//! An equaliser that moves the resonance of an actuator to where one wants it.
//!
//! H = g (s² + ω s / Q + ω²) / (s² + ω_t s / Q_t + ω_t²): its zeros take away the pole pair of the actuator, its poles put another in the place
//! (Linkwitz). Of what lies between drive and motion only this pair is undone: it is minimum-phase and inside the band, which the pole of
//! the coil and the delay of a converter are not. What that asks of amplifier and actuator is worked out before, over the whole band, and
//! the pair is moved no farther than the limits allow.

use super::limits::Limits;
use super::plant::Plant;
use super::resonance::Resonance;
use super::response::Response;
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, Limit, check, positive};
use crate::dsp::complex::Complex;

/// What is to be even: what an actuator is felt by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Displacement for each unit of drive, as it is far below the resonance: of a tactor.
    Displacement,
    /// Acceleration for each unit of drive, as it is far above the resonance: of an inertial motor.
    Acceleration,
}

/// What is wanted of an equaliser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// What is to be even.
    pub motion: Motion,
    /// Where the resonance should be.
    pub target: Resonance,
    /// The band in which it matters, hertz.
    pub band: [f64; 2],
    /// Drive at level 1 where nothing is boosted, volts or amperes, peak.
    pub level: f64,
    /// The most by which it may boost or cut anything in the band, decibels. Resonances move with the skin; a boost of more than 12 dB, or a
    /// cut that narrow, then does more harm than good.
    pub most_change: f64,
    /// What the actuator bears.
    pub limits: Limits,
}

/// What kept an equaliser from its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// The largest boost that was allowed.
    Boost,
    /// The largest cut that was allowed: part of the resonance stays.
    Cut,
    /// Volts.
    Volts,
    /// Amperes.
    Amperes,
    /// Steady amperes: heat.
    Heat,
    /// Stroke.
    Stroke,
}

/// An equaliser, as far as the limits let it go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equaliser {
    /// What is to be even.
    pub motion: Motion,
    /// The actuator's own pole pair.
    pub own: Resonance,
    /// The pole pair that it takes away: the actuator's own, or a flatter one where that would be too much of a cut.
    pub zeros: Resonance,
    /// The one that it puts there.
    pub poles: Resonance,
    /// Its gain where nothing is boosted; below 1 where not even an unmoved resonance keeps to the limits.
    pub gain: f64,
    /// What kept the poles from the target, or took gain away.
    pub limited: Option<Limited>,
    /// Whether the cut was held back as well.
    pub cut_held: bool,
    /// The largest boost in the band, decibels.
    pub boost: f64,
    /// The top of the band, hertz.
    pub high: f64,
}

/// Points of the band that are looked at, evenly on a logarithmic axis; halvings of the way of the poles; corrections of the zeros.
const POINTS: usize = 400;
const HALVINGS: usize = 50;
const HOLDS: usize = 20;

impl Equaliser {
    /// Works one out for an actuator under a drive.
    ///
    /// # Errors
    /// A wish that cannot be.
    pub fn design(plant: &Plant, drive: Drive, wish: &Wish) -> Result<Self, Fault> {
        wish.check()?;
        let Some(own) = plant.resonance(drive) else {
            return Err(Fault::because(
                "stiffness",
                0.0,
                Limit::Above(0.0),
                "without a spring there is no resonance",
            ));
        };
        let at =
            |hertz| if drive == Drive::Voltage { plant.per_volt(hertz) } else { plant.per_ampere(hertz) };
        let [low, high] = wish.band;
        let points: Vec<(f64, Response)> = (0..POINTS)
            .map(|n| low * (high / low).powf(n as f64 / (POINTS - 1) as f64))
            .map(|hertz| (hertz, at(hertz)))
            .collect();
        let try_at = |share: f64| {
            let move_to = |from: f64, to: f64| from * (to / from).powf(share);
            // The quality first of all: it costs least.
            let poles = Resonance { hertz: move_to(own.hertz, wish.target.hertz), q: wish.target.q };
            let (zeros, cut_held) = wish.hold_back(own, poles, &points);
            let new = Self {
                motion: wish.motion,
                own,
                zeros,
                poles,
                gain: 1.0,
                limited: None,
                cut_held,
                boost: 0.0,
                high,
            };
            let (demand, of) = wish.demand(&new, &points);
            (new, demand, of)
        };
        let (mut best, demand, of) = try_at(1.0);
        if demand > 1.0 {
            let (mut near, mut far, mut limited) = (0.0, 1.0, of);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (near + far);
                let (_, demand, of) = try_at(middle);
                if demand > 1.0 {
                    (far, limited) = (middle, of);
                } else {
                    near = middle;
                }
            }
            let (at_near, demand, of) = try_at(near);
            best = at_near;
            if demand > 1.0 {
                limited = of;
                best.gain = 1.0 / demand;
            }
            best.limited = Some(limited);
        }
        if best.limited.is_none() && best.cut_held {
            best.limited = Some(Limited::Cut);
        }
        let most = points.iter().map(|(hertz, _)| best.response(*hertz).abs()).fold(0.0, f64::max);
        best.boost = 20.0 * most.log10();
        Ok(best)
    }

    /// Its response at a frequency (Hz).
    pub fn response(&self, hertz: f64) -> Complex {
        let s = Complex::oscillation(hertz);
        let pair = |r: &Resonance| s * s + s * (r.omega() / r.q) + r.omega() * r.omega();
        pair(&self.zeros) / pair(&self.poles) * self.reference()
    }

    /// The gain at an infinite frequency.
    fn reference(&self) -> f64 {
        self.gain
            * match self.motion {
                Motion::Acceleration => 1.0,
                Motion::Displacement => (self.poles.hertz / self.zeros.hertz).powi(2),
            }
    }

    /// Coefficients of the same at a sampling `rate` (Hz, above 0): b0, b1, b2 and a1, a2 of (b0 + b1 z⁻¹ + b2 z⁻²) / (1 + a1 z⁻¹ + a2 z⁻²).
    ///
    /// Zeros and poles go to e^(sT). An actuator behind a converter that holds its samples has its poles at just these places, whatever
    /// the rate, so they vanish without a rest, which a bilinear section does not achieve. Since zeros and poles are displaced alike, it is
    /// also nearer to the analog form: within 0.002 dB and 2.5° up to 1 kHz at a rate of 8 kHz, where the bilinear one is up to 0.2 dB off. Its gain is
    /// right at 0 Hz (displacement), or at the top of the band (acceleration).
    pub fn section(&self, rate: f64) -> ([f64; 3], [f64; 2]) {
        let [b1, b2] = held(&self.zeros, rate);
        let a = held(&self.poles, rate);
        let at = match self.motion {
            Motion::Displacement => 0.0,
            Motion::Acceleration => self.high.min(0.5 * rate),
        };
        let z = Complex::turned(-std::f64::consts::TAU * at / rate);
        let pair = |[c1, c2]: [f64; 2]| z * (z * c2 + c1) + 1.0;
        let gain = self.response(at).abs() * pair(a).abs() / pair([b1, b2]).abs();
        ([gain, gain * b1, gain * b2], a)
    }
}

/// Where a pole pair goes under a hold: −2 e^(−ωT/2Q) cos(ωT sqrt(1 − 1/4Q²)) and e^(−ωT/Q), with cosh where the poles are real.
fn held(r: &Resonance, rate: f64) -> [f64; 2] {
    let turn = r.omega() / rate;
    let half = 0.5 / r.q;
    let inside = 1.0 - half * half;
    let decay = (-turn * half).exp();
    let sum = if inside >= 0.0 {
        2.0 * decay * (turn * inside.sqrt()).cos()
    } else {
        let apart = turn * (-inside).sqrt();
        (apart - turn * half).exp() + (-apart - turn * half).exp()
    };
    [-sum, decay * decay]
}

impl Wish {
    fn check(&self) -> Result<(), Fault> {
        positive("target.hertz", self.target.hertz)?;
        positive("target.q", self.target.q)?;
        positive("band.low", self.band[0])?;
        check("band.high", self.band[1], Limit::Above(self.band[0]))?;
        positive("level", self.level)?;
        positive("most_change", self.most_change)?;
        self.limits.check()
    }

    /// Zeros that cut no more than is allowed within an octave of the resonance: their Q is lowered until the floor is met.
    fn hold_back(&self, own: Resonance, poles: Resonance, points: &[(f64, Response)]) -> (Resonance, bool) {
        let floor = 10f64.powf(-self.most_change / 20.0);
        let mut zeros = own;
        for _ in 0..HOLDS {
            let new = Equaliser {
                motion: self.motion,
                own,
                zeros,
                poles,
                gain: 1.0,
                limited: None,
                cut_held: false,
                boost: 0.0,
                high: self.band[1],
            };
            let near = points.iter().filter(|(hertz, _)| (0.5..2.0).contains(&(hertz / own.hertz)));
            let least = near.map(|(hertz, _)| new.response(*hertz).abs()).fold(f64::MAX, f64::min);
            if least >= floor * (1.0 - 1e-9) {
                break;
            }
            zeros.q *= (least / floor).min(1.0 - 1e-9);
        }
        (zeros, zeros != own)
    }

    /// The largest share of a limit that is asked for in the band, and of which.
    fn demand(&self, equaliser: &Equaliser, points: &[(f64, Response)]) -> (f64, Limited) {
        let most_boost = 10f64.powf(self.most_change / 20.0);
        let mut worst = (0.0, Limited::Boost);
        let mut ask = |value: f64, limit: Option<f64>, of: Limited| {
            if let Some(limit) = limit
                && value / limit > worst.0
            {
                worst = (value / limit, of);
            }
        };
        for (hertz, response) in points {
            let boost = equaliser.response(*hertz).abs();
            let drive = boost * self.level;
            let amperes = drive * response.current.abs();
            ask(boost, Some(most_boost), Limited::Boost);
            ask(amperes * response.impedance.abs(), self.limits.volts, Limited::Volts);
            ask(amperes, self.limits.amperes, Limited::Amperes);
            ask(amperes * std::f64::consts::FRAC_1_SQRT_2, self.limits.amperes_rms, Limited::Heat);
            ask(drive * response.displacement.abs(), self.limits.stroke, Limited::Stroke);
        }
        worst
    }
}

#[cfg(test)]
mod tests;
