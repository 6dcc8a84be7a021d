//! The instruction set that hot loops are compiled for, chosen once.

/// An instruction-set level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Isa {
    /// What the build was made for.
    Baseline,
    /// 256-bit vectors on x86-64.
    Avx2,
}

impl Isa {
    /// The best level of this machine.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            return Self::Avx2;
        }
        Self::Baseline
    }
}
