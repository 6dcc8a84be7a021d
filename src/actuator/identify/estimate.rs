//! What a recording tells of an actuator, and what it does not.

use std::fmt;

/// A figure that a recording tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What it is: the key of a rig, where it is one.
    pub name: &'static str,
    /// Whether a rig has a key of that name.
    pub is_key: bool,
    /// In `unit`.
    pub value: f64,
    /// Its SI unit; `1` where it is a ratio.
    pub unit: &'static str,
    /// Where it lies with 95 % probability, ends included: by the scatter of what the fit leaves, which counts as connected over a
    /// twelfth of the recording, and by what the recording cannot tell apart from it.
    pub interval: [f64; 2],
}

/// A figure that a recording does not tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Untold {
    /// The key of a rig.
    pub name: &'static str,
    /// Why not, and what would tell it.
    pub why: String,
}

/// All that a recording tells, and does not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Identified {
    /// What it tells.
    pub told: Vec<Estimate>,
    /// What it does not.
    pub untold: Vec<Untold>,
    /// The signal to noise ratio of the recorded acceleration, dB: all of what the model explains, over what it leaves.
    pub signal_to_noise: f64,
}

/// An interval wider than this share of its value on either side tells nothing.
const WIDEST: f64 = 0.3;

impl Estimate {
    /// Whether a value lies in the interval.
    pub fn holds(&self, value: f64) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&value)
    }
}

impl Identified {
    /// What is told under a name.
    pub fn get(&self, name: &str) -> Option<&Estimate> {
        self.told.iter().find(|estimate| estimate.name == name)
    }

    /// Why a name is not told, where it is not.
    pub fn why_not(&self, name: &str) -> Option<&str> {
        self.untold.iter().find(|untold| untold.name == name).map(|untold| untold.why.as_str())
    }

    pub(super) fn untold(&mut self, name: &'static str, why: impl Into<String>) {
        self.untold.push(Untold { name, why: why.into() });
    }

    /// A value and how far it may be off, down and up. Where that is much of it, or a positive figure comes out as none, it is not told.
    pub(super) fn key(&mut self, name: &'static str, unit: &'static str, value: f64, off: [f64; 2]) {
        let interval = [value - off[0], value + off[1]];
        let off = off[0].max(off[1]);
        if value > 0.0 && off <= WIDEST * value {
            self.told.push(Estimate { name, is_key: true, value, unit, interval });
        } else if interval[1] <= 0.0 {
            self.untold(name, "it comes out below 0: there is as good as none of it");
        } else if value.is_finite() && off.is_finite() {
            let [least, most] = interval;
            self.untold(
                name,
                format!(
                    "the recording leaves it between {:.3e} and {most:.3e} {unit}: give it more changes of the drive, \
                     a longer time, or less noise",
                    least.max(0.0)
                ),
            );
        } else {
            self.untold(name, "nothing in the recording depends on it");
        }
    }

    /// A figure that is no key of a rig.
    pub(super) fn aside(&mut self, name: &'static str, unit: &'static str, value: f64, off: f64) {
        if value.is_finite() && off.is_finite() {
            let interval = [value - off, value + off];
            self.told.push(Estimate { name, is_key: false, value, unit, interval });
        }
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, unit, interval: [least, most], .. } = self;
        write!(f, "{name} = {value:.5e} {unit} ({least:.5e} to {most:.5e})")
    }
}

impl fmt::Display for Untold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is not told: {}", self.name, self.why)
    }
}

#[cfg(test)]
mod tests {
    use super::Identified;

    #[test]
    fn what_is_too_wide_is_not_told() {
        let mut all = Identified::default();
        all.key("q", "1", 10.0, [2.9, 1.0]);
        all.key("resistance", "ohm", 10.0, [1.0, 3.1]);
        all.key("inertia", "kg m2", -1e-9, [1e-12, 1e-12]);
        all.key("viscous_friction", "N m s/rad", -1e-9, [1e-12, 2e-9]);
        all.key("inductance", "H", f64::NAN, [0.0, 0.0]);
        all.aside("delay", "s", -0.1, 3.0);
        assert_eq!(all.told.len(), 2);
        let q = all.get("q").unwrap();
        assert!(q.is_key && q.holds(7.1) && q.holds(11.0) && !q.holds(7.0) && !q.holds(11.1));
        assert!(!all.get("delay").unwrap().is_key);
        assert!(all.why_not("resistance").unwrap().contains("between 9.000e0 and 1.310e1 ohm"));
        assert!(all.why_not("inertia").unwrap().contains("as good as none"));
        assert!(all.why_not("viscous_friction").unwrap().contains("between 0.000e0 and 1.000e-9"));
        assert!(all.why_not("inertia").is_some() && all.why_not("q").is_none());
        assert!(all.why_not("inductance").unwrap().contains("nothing"));
        assert!(q.to_string().starts_with("q = 1.00000e1 1 (7.1"), "{q}");
    }
}
