//! What a hand that holds a voice may do with it.

/// A way in which a voice that sounds is moved, apart from all others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Motion {
    /// The share by which its frequency is moved: 0 at rest, 1 an octave up, at least −1 and at most 1023.
    Detune,
    /// How hard it is pressed, 0 at rest to 1.
    Pressure,
    /// Where across the key, or by how much tilted, it is held: 0 to 1; 64/127 at rest, where MIDI has its middle.
    Timbre,
}

impl Motion {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Detune, Self::Pressure, Self::Timbre];

    /// What a patch calls them, in that order.
    pub const WORDS: &'static [&'static str] = &["detune", "pressure", "timbre"];

    /// Its place among all.
    pub const fn number(self) -> usize {
        self as usize
    }

    /// Where a voice stands that nobody moves.
    pub const fn rest(self) -> f64 {
        match self {
            Self::Detune | Self::Pressure => 0.0,
            Self::Timbre => 64.0 / 127.0,
        }
    }

    /// The nearest value that it may have; `None` for what is no number.
    pub fn within(self, value: f64) -> Option<f64> {
        let (least, most) = match self {
            Self::Detune => (-1.0, 1023.0),
            Self::Pressure | Self::Timbre => (0.0, 1.0),
        };
        (!value.is_nan()).then(|| value.clamp(least, most))
    }

    /// The share by which so many semitones move a frequency: 2^(semitones / 12) − 1. For no semitones it is 0 exactly.
    pub fn detune(semitones: f64) -> f64 {
        (semitones / 12.0 * std::f64::consts::LN_2).exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::Motion;

    #[test]
    fn twelve_semitones_are_an_octave() {
        assert_eq!(Motion::detune(0.0), 0.0);
        assert!((Motion::detune(12.0) - 1.0).abs() < 1e-15 && (Motion::detune(-12.0) + 0.5).abs() < 1e-15);
        assert!((Motion::detune(1.0) - (2.0_f64.powf(1.0 / 12.0) - 1.0)).abs() < 1e-15);
    }

    #[test]
    fn nothing_leaves_its_range() {
        for motion in Motion::ALL {
            assert_eq!(motion.within(motion.rest()), Some(motion.rest()));
            assert_eq!(motion.within(f64::NAN), None);
            let [least, most] = [f64::NEG_INFINITY, f64::INFINITY].map(|x| motion.within(x).unwrap());
            assert!(least.is_finite() && most.is_finite() && least < most);
            assert_eq!(Motion::ALL[motion.number()], motion);
        }
        assert_eq!(Motion::ALL.len(), Motion::WORDS.len());
    }
}
