//! What a SmartKnob can be.

use crate::actuator::fault::{Fault, Limit, check, within};

/// Magnetic detents, at most.
pub const MOST_DETENTS: usize = 5;

/// The largest strength: what the firmware's own demonstrations use.
pub const MOST_STRENGTH: f32 = 2.5;

/// What a SmartKnob can be, field by field as its message has them.
///
/// It pulls the knob to the middle of its position: with 4 × strength volts a radian, beyond a dead zone of the lesser of 1° and a fifth of
/// the width, and never with more than its motor bears.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Where it is to be, in whole positions.
    pub position: i32,
    /// And in parts of one.
    pub sub_position: f32,
    /// Another number than before lets it take the position.
    pub position_nonce: u8,
    /// The first position.
    pub min: i32,
    /// The last one. Below the first: there are no ends.
    pub max: i32,
    /// From one position to the next, 1e-3 to 10 rad.
    pub width: f32,
    /// Strength of the detents, 0 to [`MOST_STRENGTH`], nominally up to 1.
    pub detent_strength: f32,
    /// Of the ends; likewise.
    pub endstop_strength: f32,
    /// How many widths from its middle it snaps to the next: 0.5 to 10. Usual are 1.1, and 0.55 for a switch.
    pub snap_point: f32,
    /// By how much of a width that is farther away from 0, 0 to 10.
    pub snap_point_bias: f32,
    /// What it shows on its screen, 50 bytes at most; the fork takes it for a name.
    pub text: String,
    /// Where there are detents; nowhere else, unless there are none here. [`MOST_DETENTS`] at most.
    pub detents: Vec<i32>,
    /// Hue of its light, 0 to 255.
    pub hue: u8,
}

impl Default for Config {
    /// It turns freely, in positions of 10°.
    fn default() -> Self {
        Self {
            position: 0,
            sub_position: 0.0,
            position_nonce: 0,
            min: 0,
            max: -1,
            width: 10_f32.to_radians(),
            detent_strength: 0.0,
            endstop_strength: 1.0,
            snap_point: 1.1,
            snap_point_bias: 0.0,
            text: String::new(),
            detents: Vec::new(),
            hue: 0,
        }
    }
}

impl Config {
    /// Refuses what the knob would refuse, or answer with silence for ever.
    ///
    /// # Errors
    /// The first field beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        within("width", f64::from(self.width), (1e-3, 10.0), "rad")?;
        let strengths =
            [("detent strength", self.detent_strength), ("endstop strength", self.endstop_strength)];
        for (field, strength) in strengths {
            check(
                field,
                f64::from(strength),
                Limit::Within(0.0, f64::from(MOST_STRENGTH), "of nominally 1"),
            )?;
        }
        within("snap point", f64::from(self.snap_point), (0.5, 10.0), "widths")?;
        within("snap point bias", f64::from(self.snap_point_bias), (0.0, 10.0), "widths")?;
        within("sub position", f64::from(self.sub_position), (-10.0, 10.0), "widths")?;
        check("text", self.text.len() as f64, Limit::Within(0.0, 50.0, "bytes"))?;
        check("detents", self.detents.len() as f64, Limit::Most(MOST_DETENTS as f64))?;
        if self.has_ends() {
            let (min, max) = (f64::from(self.min), f64::from(self.max));
            check("position", f64::from(self.position), Limit::Within(min, max, "positions"))?;
        }
        Ok(())
    }

    /// Whether it ends somewhere.
    pub fn has_ends(&self) -> bool {
        self.max >= self.min
    }

    /// Whether the knob says back this one: all but where it is to be, which it may have moved on from.
    pub(super) fn is_in_force(&self, echo: &Self) -> bool {
        let like = Self {
            position: self.position,
            sub_position: self.sub_position,
            position_nonce: self.position_nonce,
            hue: self.hue,
            ..echo.clone()
        };
        let rest = self.clone();
        let ends = |config: &Self| if config.has_ends() { Some((config.min, config.max)) } else { None };
        ends(&like) == ends(&rest) && Self { min: 0, max: 0, ..like } == Self { min: 0, max: 0, ..rest }
    }
}

#[cfg(test)]
mod tests {
    use super::Config;

    #[test]
    fn what_a_knob_would_never_answer_is_refused() {
        let good = Config { text: "x".repeat(50), detents: vec![0; 5], ..Config::default() };
        assert_eq!(good.check(), Ok(()));
        let bad = [
            (Config { text: "x".repeat(51), ..good.clone() }, "text"),
            (Config { text: "é".repeat(26), ..good.clone() }, "text"),
            (Config { detents: vec![0; 6], ..good.clone() }, "detents"),
            (Config { width: 0.0, ..good.clone() }, "width"),
            (Config { width: f32::NAN, ..good.clone() }, "width"),
            (Config { detent_strength: -1.0, ..good.clone() }, "detent strength"),
            (Config { endstop_strength: f32::INFINITY, ..good.clone() }, "endstop strength"),
            (Config { snap_point: 0.49, ..good.clone() }, "snap point"),
            (Config { snap_point_bias: -0.1, ..good.clone() }, "snap point bias"),
            (Config { min: 0, max: 3, position: 4, ..good.clone() }, "position"),
        ];
        for (config, field) in bad {
            assert_eq!(config.check().unwrap_err().field, field, "{config:?}");
        }
    }
}
