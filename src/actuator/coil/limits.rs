//! What a coil actuator bears.

use crate::actuator::fault::{Fault, Limit, positive};

/// What a coil actuator, or what drives it, bears at most; `None`: unknown, or of no concern.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Volts at the terminals, peak.
    pub volts: Option<f64>,
    /// Amperes, peak.
    pub amperes: Option<f64>,
    /// Amperes for as long as one likes (root mean square): what heat allows.
    pub amperes_rms: Option<f64>,
    /// Metres from rest.
    pub stroke: Option<f64>,
}

impl Limits {
    /// The same behind what gives no more than these volts and amperes, peak.
    pub fn within(self, volts: Option<f64>, amperes: Option<f64>) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        Self { volts: least(self.volts, volts), amperes: least(self.amperes, amperes), ..self }
    }

    /// Refuses limits that cannot be.
    ///
    /// # Errors
    /// A limit that is not above 0, or a steady current beyond the peak.
    pub fn check(&self) -> Result<(), Fault> {
        let fields = ["volts", "amperes", "amperes_rms", "stroke"];
        for (field, limit) in
            fields.into_iter().zip([self.volts, self.amperes, self.amperes_rms, self.stroke])
        {
            limit.map_or(Ok(()), |limit| positive(field, limit))?;
        }
        match (self.amperes_rms, self.amperes) {
            (Some(rms), Some(peak)) if rms > peak => Err(Fault::because(
                "amperes_rms",
                rms,
                Limit::Most(peak),
                "no current is on average above its peak",
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Limits;

    #[test]
    fn limits_that_contradict_each_other_are_refused() {
        let sound =
            Limits { volts: Some(3.0), amperes: Some(0.5), amperes_rms: Some(0.5), stroke: Some(1e-3) };
        assert!(sound.check().is_ok() && Limits::default().check().is_ok());
        let fault = Limits { amperes_rms: Some(0.6), ..sound }.check().unwrap_err().to_string();
        assert!(fault.starts_with("`amperes_rms` is 0.6, but must be at most 0.5"), "{fault}");
        for (limits, field) in [
            (Limits { volts: Some(0.0), ..sound }, "volts"),
            (Limits { amperes: Some(f64::NAN), ..sound }, "amperes"),
            (Limits { stroke: Some(-1.0), ..sound }, "stroke"),
        ] {
            assert_eq!(limits.check().unwrap_err().field, field);
        }
    }
}
