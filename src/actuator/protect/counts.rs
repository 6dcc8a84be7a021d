//! What protection did.

/// What one bound did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Touched {
    /// Samples that it changed, each counted once.
    pub samples: u64,
    /// The most by which it changed one: volts, or shares of full scale where the volts are not known.
    pub most: f64,
}

/// What protection did since it began.
///
/// Each bound counts what it changed in the sample as the bound before it left it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counts {
    /// Samples that it saw.
    pub samples: u64,
    /// Samples that left other than they came, whatever the reason.
    pub changed: u64,
    /// Samples that were not finite, and became 0.
    pub masked: u64,
    /// Samples that were held at 16 times full scale, where a mean is kept.
    pub held: u64,
    /// By the budget of what alternates.
    pub alternating: Touched,
    /// By the heat, its gain and its cap together.
    pub heat: Touched,
    /// By the mean square, its gain and its cap together.
    pub rms: Touched,
    /// By taking off a steady voltage.
    pub steady: Touched,
    /// By the peak.
    pub peak: Touched,
    /// By the slew.
    pub slew: Touched,
    /// By the stroke.
    pub stroke: Touched,
    /// The warmest that the winding became, kelvins above the air; 0 without a heat bound.
    pub warmest: f64,
    /// The farthest that the model moved at a sample, metres; 0 without a stroke.
    pub farthest: f64,
}

impl Touched {
    /// Enters a change.
    #[inline(always)]
    pub(super) fn enter(&mut self, before: f64, after: f64) {
        if before != after {
            self.samples += 1;
            self.most = self.most.max((before - after).abs());
        }
    }

    /// Enters further changes of a sample that this bound changed already.
    #[inline(always)]
    pub(super) fn enter_more(&mut self, already: bool, before: f64, after: f64) {
        if before != after {
            self.samples += u64::from(!already);
            self.most = self.most.max((before - after).abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Touched;

    #[test]
    fn a_sample_is_counted_once_and_only_if_it_changed() {
        let mut t = Touched::default();
        t.enter(1.0, 1.0);
        assert_eq!(t, Touched::default());
        t.enter(1.0, 0.5);
        t.enter_more(true, 1.0, 0.25);
        assert_eq!(t, Touched { samples: 1, most: 0.75 });
        t.enter_more(false, 1.0, 0.9);
        t.enter_more(false, 1.0, 1.0);
        assert_eq!(t, Touched { samples: 2, most: 0.75 });
    }
}
