//! How hard a key was struck, as loud as it is to be.

/// The exponents of [`Curve::Soft`] and [`Curve::Hard`].
const EXPONENT: f64 = 2.0;

/// From velocity to level, 0 to 1 both. Only [`Curve::Fixed`] does not keep both ends.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Curve {
    /// The velocity itself.
    #[default]
    Linear,
    /// √velocity: soft playing is already strong. For keys that are hard to strike.
    Soft,
    /// velocity²: only hard playing is strong. For keys that are struck too easily; in decibels twice the range.
    Hard,
    /// velocity to the power of this, above 0.
    Power(f64),
    /// Always this, 0 to 1.
    Fixed(f64),
}

impl Curve {
    /// The level of a velocity. What is beyond 0 and 1 counts as they do, no number as 0; an exponent that is not above 0 counts as 1.
    pub fn level(self, velocity: f64) -> f64 {
        let limited = |x: f64| if x > 0.0 { x.min(1.0) } else { 0.0 };
        let velocity = limited(velocity);
        match self {
            Self::Linear => velocity,
            Self::Soft => velocity.powf(1.0 / EXPONENT),
            Self::Hard => velocity.powf(EXPONENT),
            Self::Power(exponent) if exponent > 0.0 => velocity.powf(exponent),
            Self::Power(_) => velocity,
            Self::Fixed(level) => limited(level),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Curve;

    #[test]
    fn curves_keep_their_ends_and_their_order() {
        let curves = [Curve::Linear, Curve::Soft, Curve::Hard, Curve::Power(0.3), Curve::Power(f64::NAN)];
        for curve in curves {
            assert_eq!([0.0, 1.0, -3.0, 7.0].map(|v| curve.level(v)), [0.0, 1.0, 0.0, 1.0], "{curve:?}");
            assert_eq!(curve.level(f64::NAN), 0.0);
            let levels: Vec<f64> = (0..128).map(|v| curve.level(f64::from(v) / 127.0)).collect();
            assert!(levels.windows(2).all(|w| w[0] < w[1]), "{curve:?}");
        }
        assert_eq!(
            [Curve::Soft, Curve::Hard, Curve::Power(1.5)].map(|c| c.level(0.25)),
            [0.5, 0.0625, 0.125]
        );
        assert_eq!(
            [Curve::Fixed(0.4), Curve::Fixed(4.0), Curve::Fixed(f64::NAN)].map(|c| c.level(0.9)),
            [0.4, 1.0, 0.0]
        );
    }
}
