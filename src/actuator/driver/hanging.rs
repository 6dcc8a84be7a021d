//! Where the mass of a motor hangs, for as long as that is known.
//!
//! After the way home it is known, and from there on the motor's model counts how far it turned. What the model's figures are off by adds up, so what is
//! known is less and less: the farther the mass is from home, and the longer its way was.

/// How far a model is led astray of which a figure is 5 % off: of how far the mass is from home, and of its way, which goes forth and back.
const OFF: f64 = 0.1;
const STRAYS: f64 = 0.03;

/// The doubt from which on it is not known, rad: 30 degrees. What is off grows by itself where gravity helps it on, so it may be more than is reckoned.
const DOUBT: f64 = std::f64::consts::FRAC_PI_6;

/// Since the mass was home.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hanging {
    /// Where home is, rad from straight down.
    pub home: f64,
    /// How far the mass has turned since, rad, and its way.
    net: f64,
    way: f64,
}

impl Hanging {
    /// At home.
    pub fn at(home: f64) -> Self {
        Self { home, net: 0.0, way: 0.0 }
    }

    /// The same, turned by so much more, rad.
    #[inline]
    pub fn turned(&mut self, by: f64) {
        self.net += by;
        self.way += by.abs();
    }

    /// By how much it may hang elsewhere than the model has it, rad, the spread of home aside.
    pub fn doubt(&self) -> f64 {
        OFF * self.net.abs() + STRAYS * self.way
    }

    /// Whether it is known.
    pub fn is_known(&self) -> bool {
        self.doubt() <= DOUBT
    }
}
