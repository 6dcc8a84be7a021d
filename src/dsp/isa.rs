//! Instruction sets: found once, chosen by hand in tests.
//!
//! A hot loop is an `#[inline(always)]` body, called as it stands or from a wrapper that has
//! `#[target_feature(enable = "avx2")]`. No body contracts a multiply and an add, so every level gives the same bits.

/// The instruction set that hot loops use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// What the compiler may assume of every machine of this target.
    Baseline,
    /// x86 with AVX2.
    Avx2,
}

impl Isa {
    /// The best level this machine has.
    pub fn detect() -> Self {
        Self::Avx2.or_supported()
    }

    /// This level where the machine has it, otherwise the baseline.
    pub fn or_supported(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if self == Self::Avx2 && std::arch::is_x86_feature_detected!("avx2") {
            return Self::Avx2;
        }
        Self::Baseline
    }
}

#[cfg(test)]
mod tests {
    use super::Isa;

    #[test]
    fn the_baseline_is_always_there_and_detection_is_stable() {
        assert_eq!(Isa::Baseline.or_supported(), Isa::Baseline);
        assert_eq!(Isa::detect(), Isa::detect().or_supported());
    }
}
