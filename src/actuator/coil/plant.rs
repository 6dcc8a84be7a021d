//! The mechanics and the coil as one linear system.

use super::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use crate::actuator::drive::Drive;
use crate::actuator::exponential::{MOST, Square};
use crate::actuator::fault::Fault;

/// A checked actuator on its load: what response and time-domain model are made from.
///
/// The coil's coordinate y is that of the contactor in its housing, or of the slug in its casing; where it matters there is
/// a second, Y: the layer of the skin, or the casing in the hand. M q̈ + C q̇ + K q = (f, 0) with the force f on y, f = Bl i from the coil,
/// and L di/dt + R i + Bl ẏ = V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    pub(super) kind: Kind,
    pub(super) coil: Coil,
    /// Coordinates: 1 or 2.
    pub(super) bodies: usize,
    /// M, and its inverse worked out by hand so that nothing cancels.
    pub(super) mass: Pair,
    inverse: Pair,
    damping: Pair,
    stiffness: Pair,
}

/// A symmetric 2 × 2 matrix.
pub(super) type Pair = [[f64; 2]; 2];

/// What it was made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Tactor(VoiceCoil),
    Inertial(Inertial),
}

/// What pushes on y besides coil, suspension and load: a spring, and a force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Touch {
    pub spring: Spring,
    pub force: f64,
}

/// dx/dt = A x + B (drive, 1), x = (y, ẏ, Y, Ẏ, i) as far as there are such.
#[derive(Debug, Clone, Copy)]
pub(super) struct System {
    pub size: usize,
    /// [A, B] above rows of zeros.
    pub matrix: Square,
}

/// The largest state.
pub(super) const MOST_STATES: usize = 5;
const _: () = assert!(MOST_STATES + 2 <= MOST);

impl Plant {
    /// A tactor.
    ///
    /// # Errors
    /// The first parameter that cannot be.
    pub fn voice_coil(v: &VoiceCoil) -> Result<Self, Fault> {
        v.check()?;
        let (tissue, layer) = match v.skin {
            Skin::None => (Tissue::default(), None),
            Skin::One(tissue) => (tissue, None),
            Skin::Two(tissue, layer) => (tissue, Some(layer)),
        };
        let mass = v.mass + tissue.mass;
        let sum = |of: fn(&Spring) -> f64| {
            let own = of(&v.suspension) + of(&tissue.spring);
            layer.map_or([[own, 0.0], [0.0; 2]], |layer| {
                let (coupling, anchor) = (of(&layer.coupling), of(&layer.anchor));
                [[own + coupling, -coupling], [-coupling, coupling + anchor]]
            })
        };
        let other = layer.map_or(1.0, |layer| layer.mass);
        Ok(Self {
            kind: Kind::Tactor(*v),
            coil: v.coil,
            bodies: 1 + usize::from(layer.is_some()),
            mass: [[mass, 0.0], [0.0, other]],
            inverse: [[1.0 / mass, 0.0], [0.0, 1.0 / other]],
            damping: sum(|spring| spring.damping),
            stiffness: sum(|spring| spring.stiffness),
        })
    }

    /// An inertial motor.
    ///
    /// # Errors
    /// The first parameter that cannot be.
    pub fn inertial(m: &Inertial) -> Result<Self, Fault> {
        m.check()?;
        let (slug, casing) = (m.slug_mass, m.casing_mass + m.hand.mass);
        let Spring { stiffness, damping } = m.suspension;
        let hand = m.hand.spring;
        let bodies = if m.hand.is_free() { 1 } else { 2 };
        let mutual = 1.0 / slug + 1.0 / casing;
        Ok(Self {
            kind: Kind::Inertial(*m),
            coil: m.coil,
            bodies,
            // A casing that nothing holds has no coordinate of its own: the slug's is that of both about their common centre.
            mass: if bodies == 1 {
                [[1.0 / mutual, 0.0], [0.0; 2]]
            } else {
                [[slug, slug], [slug, slug + casing]]
            },
            inverse: [[mutual, -1.0 / casing], [-1.0 / casing, 1.0 / casing]],
            damping: [[damping, 0.0], [0.0, hand.damping]],
            stiffness: [[stiffness, 0.0], [0.0, hand.stiffness]],
        })
    }

    /// Whether its coil shakes a casing; else it moves a contactor in a housing that is held.
    pub fn shakes(&self) -> bool {
        matches!(self.kind, Kind::Inertial(_))
    }

    /// The same without inductance: the current follows the voltage at once.
    #[must_use]
    pub fn without_inductance(&self) -> Self {
        let mut plant = *self;
        plant.coil.inductance = 0.0;
        match &mut plant.kind {
            Kind::Tactor(tactor) => tactor.coil.inductance = 0.0,
            Kind::Inertial(inertial) => inertial.coil.inductance = 0.0,
        }
        plant
    }

    /// Its coil.
    pub fn coil(&self) -> Coil {
        self.coil
    }

    /// Acceleration of y for each newton on it.
    pub(super) fn push(&self) -> f64 {
        self.inverse[0][0]
    }

    /// Stiffness and damping of y alone.
    pub(super) fn mechanics(&self) -> (f64, f64) {
        (self.stiffness[0][0], self.damping[0][0])
    }

    /// Energy in masses and springs, joules: ½ q̇ᵀM q̇ + ½ qᵀK q.
    pub(super) fn mechanical_energy(&self, state: &[f64]) -> f64 {
        let form = |of: &Pair, at: usize| {
            let q = |j: usize| state[2 * j + at];
            let product = |j: usize, k: usize| of[j][k] * q(j) * q(k);
            (0..self.bodies).map(|j| (0..self.bodies).map(|k| product(j, k)).sum::<f64>()).sum::<f64>()
        };
        0.5 * (form(&self.mass, 1) + form(&self.stiffness, 0))
    }

    /// How fast things go at most, radians a second: a bound on frequencies and rates of the mechanics, and of what the coil does to them.
    pub(super) fn pace(&self, drive: Drive, touch: &Touch) -> f64 {
        let Coil { resistance, inductance, force_factor } = self.coil;
        // It brakes with Bl² / R m, or swings with Bl / √(L m), whichever is slower.
        let electric = match drive {
            Drive::Current => 0.0,
            Drive::Voltage => {
                let brakes = force_factor * force_factor * self.push() / resistance;
                if inductance > 0.0 {
                    brakes.min(force_factor * (self.push() / inductance).sqrt())
                } else {
                    brakes
                }
            }
        };
        let norm = |of: &Pair, more: f64| {
            let mut of = *of;
            of[0][0] += more;
            let product =
                |j: usize, k: usize| (0..self.bodies).map(|l| self.inverse[j][l] * of[l][k]).sum::<f64>();
            // The trace: of what is never negative it bounds every eigenvalue.
            (0..self.bodies).map(|j| product(j, j).abs()).sum::<f64>()
        };
        norm(&self.stiffness, touch.spring.stiffness).sqrt()
            + norm(&self.damping, touch.spring.damping)
            + electric
    }

    /// The system under a drive, with what else touches it.
    pub(super) fn system(&self, drive: Drive, touch: &Touch) -> System {
        let Coil { resistance, inductance, force_factor } = self.coil;
        let n = self.bodies;
        let stores = drive == Drive::Voltage && inductance > 0.0;
        let size = 2 * n + usize::from(stores);
        let (mut stiffness, mut damping) = (self.stiffness, self.damping);
        stiffness[0][0] += touch.spring.stiffness;
        damping[0][0] += touch.spring.damping;
        let mut push = force_factor;
        if drive == Drive::Voltage && !stores {
            // i = (V − Bl ẏ) / R.
            damping[0][0] += force_factor * force_factor / resistance;
            push = force_factor / resistance;
        }
        let mut a = [[0.0; MOST]; MOST];
        for j in 0..n {
            a[2 * j][2 * j + 1] = 1.0;
            let row = &mut a[2 * j + 1];
            for k in 0..n {
                for l in 0..n {
                    row[2 * k] -= self.inverse[j][l] * stiffness[l][k];
                    row[2 * k + 1] -= self.inverse[j][l] * damping[l][k];
                }
            }
            row[if stores { 2 * n } else { size }] = self.inverse[j][0] * push;
            row[size + 1] = self.inverse[j][0] * touch.force;
        }
        if stores {
            let row = &mut a[2 * n];
            row[1] = -force_factor / inductance;
            row[2 * n] = -resistance / inductance;
            row[size] = 1.0 / inductance;
        }
        System { size, matrix: a }
    }

    /// The system while y is held where it is.
    pub(super) fn held(&self, drive: Drive) -> System {
        let mut system = self.system(drive, &Touch::default());
        let a = &mut system.matrix;
        a[0] = [0.0; MOST];
        a[1] = [0.0; MOST];
        if self.bodies == 2 {
            a[3] = [0.0; MOST];
            a[3][0] = -self.stiffness[1][0] / self.mass[1][1];
            a[3][2] = -self.stiffness[1][1] / self.mass[1][1];
            a[3][3] = -self.damping[1][1] / self.mass[1][1];
        }
        system
    }

    /// Velocity that the other coordinate gets for each metre a second that a push on y gives y.
    pub(super) fn along(&self) -> f64 {
        self.inverse[1][0] / self.inverse[0][0]
    }
}
