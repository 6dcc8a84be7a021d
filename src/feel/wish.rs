//! How well somebody wants to know what is felt.

use crate::actuator::fault::{Fault, within};

/// How well somebody wants to know what is felt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// The largest error of the magnitude of what is felt in the mean over a millisecond, as skin hears nothing faster; a share of that at the
    /// rated drive, 1e-9 to 0.5. Models are computed as well as that takes, and no better; how near a model is to its actuator is another
    /// matter.
    pub error: f64,
}

impl Default for Wish {
    /// A thousandth.
    fn default() -> Self {
        Self { error: 1e-3 }
    }
}

impl Wish {
    /// Refuses what is no wish.
    ///
    /// # Errors
    /// An error beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        within("error", self.error, (1e-9, 0.5), "of what is felt")
    }
}

#[cfg(test)]
mod tests {
    use super::Wish;

    #[test]
    fn what_is_no_wish_is_refused() {
        assert_eq!(Wish::default().check(), Ok(()));
        for error in [0.0, 1e-10, 0.6, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Wish { error }.check().unwrap_err().field, "error", "{error}");
        }
    }
}
