//! What an actuator bears, and what is known of it.

use crate::actuator::coil::limits::Limits;
use crate::actuator::coil::plant::Plant;
use crate::actuator::coil::resonance::Resonance;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive, within};
use crate::actuator::motor::Parameters;
use crate::actuator::thermal::Cooling;

/// What protection keeps an actuator to. A bound that is `None` is not kept, and costs nothing.
///
/// Where the volts at full scale are not known, peak and slew are in shares of full scale, and the other bounds cannot be kept.
///
/// ```
/// use pacinian::actuator::protect::bounds::Bounds;
/// use pacinian::actuator::protect::kernel::Protection;
///
/// let bounds = Bounds { full_scale: Some(5.0), peak: Some(3.0), slew: Some(2e4), ..Bounds::default() };
/// let mut protection = Protection::new(&bounds, 48_000.0)?;
/// let mut samples = [0.0, 0.05, 0.5, f32::NAN];
/// protection.process(&mut samples);
/// // 20 kV/s at 48 kHz and 5 V: 1/12 of full scale a sample.
/// assert_eq!(samples[1], 0.05);
/// assert!((samples[2] - (0.05 + 1.0 / 12.0)).abs() < 1e-6);
/// let counts = protection.counts();
/// assert_eq!((counts.masked, counts.slew.samples), (1, 2));
/// # Ok::<(), pacinian::actuator::fault::Fault>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// Volts at the actuator for a sample of 1, 1e-6 to 1e6; `None`: not known.
    pub full_scale: Option<f64>,
    /// Volts, either way.
    pub peak: Option<f64>,
    /// The lowest and the highest volts, around 0, of what bears less one way than the other, as a piezo does; it has no `stroke` then.
    pub range: Option<[f64; 2]>,
    /// Volts a second, either way.
    pub slew: Option<f64>,
    /// The root mean square over a time.
    pub rms: Option<Rms>,
    /// How the winding sheds its heat, and how warm it may become.
    pub heat: Option<Cooling>,
    /// Metres from rest, either way, of what moves in the [`Actuator`].
    pub stroke: Option<f64>,
    /// The steady voltage that it bears, volts: the mean of what leaves (corner [`CORNER`](super::kernel::CORNER)); 0: none at all, so that
    /// every sample passes a high-pass. `None`: any. Where the engine's own high-pass keeps steady voltages off, a small bound here does
    /// nothing but watch over it.
    pub steady: Option<f64>,
    /// What may alternate faster than it can follow; `None`: anything.
    pub alternating: Option<Alternating>,
    /// What is known of it, for `heat`, `rms` in amperes and `stroke`.
    pub actuator: Actuator,
}

/// A root mean square, weighted with e^(−t / `seconds`): a budget where nothing is known of the heat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rms {
    /// In this unit.
    pub most: f64,
    /// Of what.
    pub unit: Unit,
    /// The time over which it is taken, 10 ms to 1e6 s.
    pub seconds: f64,
}

/// What a root mean square is one of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Volts.
    Volts,
    /// Amperes; that takes an [`Actuator`] whose current is known.
    Amperes,
}

/// A budget for what a motor cannot follow: a DC motor at an audio frequency does not move, it only heats.
///
/// What is slower than `hertz` (a low-pass of first order) passes whole, so envelopes do; of the rest, the root mean square is kept by a
/// gain. A drive that overshoots, or brakes, alternates only briefly and passes untouched; a tone is turned down, and goes on being so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternating {
    /// What it follows: one over 2π times its mechanical time constant, 0.01 to 1000 Hz.
    pub hertz: f64,
    /// Volts, root mean square over `seconds`, of what is faster.
    pub most: f64,
    /// 10 ms to 1e6 s.
    pub seconds: f64,
}

/// What is known of an actuator. It is driven by a voltage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(clippy::large_enum_variant, reason = "there is one for each output, and it is read once")]
pub enum Actuator {
    /// Nothing; a winding whose cooling is given has the resistance that is part of it.
    #[default]
    Unknown,
    /// These ohms.
    Resistance(f64),
    /// What moves swings as one.
    Resonant {
        /// With the source connected: at a steady voltage amplitude.
        resonance: Resonance,
        /// Metres from rest for each steady volt.
        per_volt: f64,
    },
    /// All; its resistance is the cold one, so that its currents are on the safe side.
    Coil(Plant),
}

impl Bounds {
    /// Those of a coil actuator: volts and amperes (what they would be in the resistance alone), root mean square over so many seconds,
    /// stroke.
    pub fn coil(plant: &Plant, limits: &Limits, full_scale: f64, seconds: f64) -> Self {
        let by_current = limits.amperes.map(|i| i * plant.coil().resistance);
        let peak = match (limits.volts, by_current) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let rms = limits.amperes_rms.map(|most| Rms { most, unit: Unit::Amperes, seconds });
        Self {
            full_scale: Some(full_scale),
            peak,
            rms,
            stroke: limits.stroke,
            actuator: Actuator::Coil(*plant),
            ..Self::default()
        }
    }

    /// Those of a rumble motor: `overdrive` times its rated volts at most, these as the root mean square over a second, and half of
    /// them alternating faster than its mechanical time constant J R / (k² + b R) lets it follow.
    pub fn motor(motor: &Parameters, full_scale: f64, overdrive: f64) -> Self {
        let rate = (motor.gain * motor.gain / motor.resistance + motor.viscous) / motor.effective_inertia();
        let rated = motor.rated_volts;
        Self {
            full_scale: Some(full_scale),
            peak: Some(overdrive * rated),
            rms: Some(Rms { most: rated, unit: Unit::Volts, seconds: 1.0 }),
            alternating: Some(Alternating {
                hertz: (rate / std::f64::consts::TAU).clamp(0.01, 1000.0),
                most: 0.5 * rated,
                seconds: 1.0,
            }),
            actuator: Actuator::Resistance(motor.resistance),
            ..Self::default()
        }
    }

    /// Refuses what cannot be.
    ///
    /// # Errors
    /// A figure that is not above 0 (`steady`: below it); a bound in volts, heat or metres where the volts at full scale are not known; one
    /// for which too little is known of the actuator.
    pub fn check(&self) -> Result<(), Fault> {
        for (field, value) in [("peak", self.peak), ("slew", self.slew), ("stroke", self.stroke)] {
            value.map_or(Ok(()), |value| positive(field, value))?;
        }
        self.full_scale.map_or(Ok(()), |volts| within("full_scale", volts, (1e-6, 1e6), "V"))?;
        if let Some([low, high]) = self.range {
            check("range.low", low, Limit::Most(0.0))?;
            // There may be none above.
            if high != f64::INFINITY {
                check("range.high", high, if low < 0.0 { Limit::Least(0.0) } else { Limit::Above(0.0) })?;
            }
            if let Some(stroke) = self.stroke {
                let because = "what bears less one way than the other has none that would be kept to";
                return Err(Fault::because("stroke", stroke, Limit::Absent, because));
            }
        }
        self.steady.map_or(Ok(()), |volts| not_negative("steady", volts))?;
        let seconds = |field, value| within(field, value, (0.01, 1e6), "s");
        if let Some(rms) = &self.rms {
            positive("rms.most", rms.most)?;
            seconds("rms.seconds", rms.seconds)?;
        }
        if let Some(a) = &self.alternating {
            within("alternating.hertz", a.hertz, (0.01, 1e3), "Hz")?;
            positive("alternating.most", a.most)?;
            seconds("alternating.seconds", a.seconds)?;
        }
        self.heat.map_or(Ok(()), |cooling| cooling.check())?;
        match &self.actuator {
            Actuator::Unknown | Actuator::Coil(_) => {}
            Actuator::Resistance(ohms) => positive("resistance", *ohms)?,
            Actuator::Resonant { resonance, per_volt } => {
                positive("resonance.hertz", resonance.hertz)?;
                positive("resonance.q", resonance.q)?;
                positive("per_volt", *per_volt)?;
            }
        }
        self.known()
    }

    /// Whether enough is known for each bound.
    fn known(&self) -> Result<(), Fault> {
        let all = [
            ("rms.most", self.rms.map(|rms| rms.most)),
            ("heat.most", self.heat.map(|cooling| cooling.most)),
            ("stroke", self.stroke),
            ("steady", self.steady),
            ("alternating.most", self.alternating.map(|a| a.most)),
        ];
        let absent = |field, value, because| Err(Fault::because(field, value, Limit::Absent, because));
        if self.full_scale.is_none()
            && let Some((field, Some(value))) = all.into_iter().find(|(_, value)| value.is_some())
        {
            return absent(field, value, "the volts at full scale are not known");
        }
        if let (Some(stroke), Actuator::Unknown | Actuator::Resistance(_)) = (self.stroke, &self.actuator) {
            return absent("stroke", stroke, "it is not known how far a volt moves the actuator");
        }
        match (self.rms, &self.actuator) {
            (Some(Rms { most, unit: Unit::Amperes, .. }), Actuator::Unknown | Actuator::Resonant { .. }) => {
                absent("rms.most", most, "the current that a volt makes is not known; say it in volts")
            }
            _ => Ok(()),
        }
    }
}
