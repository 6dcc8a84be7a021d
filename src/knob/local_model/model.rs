//! A world as it is near one angle.

use crate::actuator::fault::{Fault, Limit, check, not_negative};

/// A plane that pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Where it is, radians.
    pub angle: f64,
    /// Whether it stands in the way of smaller angles rather than larger ones.
    pub below: bool,
    /// N m/rad.
    pub stiffness: f64,
}

impl Contact {
    fn depth(&self, angle: f64) -> f64 {
        f64::max(if self.below { self.angle - angle } else { angle - self.angle }, 0.0)
    }
}

/// torque − K (θ − centre), a contact, and where they hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalModel {
    /// The tick of the reading that it was made from.
    pub stamp: u64,
    /// Torque at the centre, N m.
    pub torque: f64,
    /// K, N m/rad.
    pub stiffness: f64,
    /// Radians.
    pub centre: f64,
    /// A plane.
    pub contact: Option<Contact>,
    /// The smallest and the largest angle for which it was made. Beyond them torque stays what it is there.
    pub range: (f64, f64),
}

impl LocalModel {
    /// Nothing there.
    pub const FREE: Self = Self {
        stamp: 0,
        torque: 0.0,
        stiffness: 0.0,
        centre: 0.0,
        contact: None,
        range: (f64::MIN, f64::MAX),
    };

    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first figure that breaks its limit.
    pub fn check(&self) -> Result<(), Fault> {
        check("torque", self.torque, Limit::Least(f64::MIN))?;
        not_negative("stiffness", self.stiffness)?;
        check("centre", self.centre, Limit::Least(f64::MIN))?;
        if let Some(contact) = &self.contact {
            check("contact", contact.angle, Limit::Least(f64::MIN))?;
            not_negative("contact_stiffness", contact.stiffness)?;
        }
        check("range", self.range.0, Limit::Least(f64::MIN))?;
        check("range", self.range.1, Limit::Above(self.range.0))
    }

    /// The angle within the range, and whether it was outside.
    #[inline(always)]
    pub fn within(&self, angle: f64) -> (f64, bool) {
        let within = f64::min(f64::max(angle, self.range.0), self.range.1);
        (within, within != angle)
    }

    /// Torque on the knob, N m.
    #[inline(always)]
    pub fn torque(&self, angle: f64) -> f64 {
        let angle = self.within(angle).0;
        let push = self.contact.map_or(0.0, |c| {
            let push = c.stiffness * c.depth(angle);
            if c.below { push } else { -push }
        });
        self.torque - self.stiffness * (angle - self.centre) + push
    }

    /// Potential energy, joules: 0 at the centre, but for the contact.
    pub fn energy(&self, angle: f64) -> f64 {
        let (within, _) = self.within(angle);
        let away = within - self.centre;
        let depth = self.contact.map_or(0.0, |c| c.stiffness * c.depth(within).powi(2));
        let beyond = if within == angle { 0.0 } else { -self.torque(angle) * (angle - within) };
        0.5 * (self.stiffness * away * away + depth) - self.torque * away + beyond
    }

    /// How stiff it is at most, N m/rad.
    #[inline(always)]
    pub fn most_stiffness(&self) -> f64 {
        self.stiffness + self.contact.map_or(0.0, |c| c.stiffness)
    }
}
