//! Where the energy of a motor goes.

use super::flow::{Flow, Motion, Push, Rotor};
use super::kernels::of_number;
use super::model::{Motor, Regime};
use super::piece::Piece;
use crate::actuator::elementary::sine;

/// Nodes and weights of Gauss and Legendre on −1 to 1, the positive half: exact for polynomials of degree 15.
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Panels of a piece, at most.
const MOST_PANELS: usize = 64;

/// What came in and where it went since the motor was placed, J. What a casing on springs takes is not among it: it does not act back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Through the terminals.
    pub supplied: f64,
    /// R i², into heat.
    pub heat: f64,
    /// b ω², into heat.
    pub viscous: f64,
    /// Dry friction, into heat.
    pub dry: f64,
    /// What the coil held when it was opened.
    pub opened: f64,
    /// What was stored when the motor was placed.
    pub placed: f64,
}

impl Energy {
    /// What is missing, given what is stored now.
    pub fn missing(&self, stored: f64) -> f64 {
        self.supplied + self.placed - (self.heat + self.viscous + self.dry + self.opened + stored)
    }

    pub(super) fn begin(&mut self, stored: f64) {
        *self = Self { placed: stored, ..Self::default() };
    }

    /// A piece of a flow. The integrals are taken by Gauss's rule over panels that grow with the distance from the beginning, where what
    /// is fast has its time.
    pub(super) fn piece(&mut self, flow: &Flow, from: Motion, push: &Push, coulomb: f64, t: f64) {
        let piece = Piece::new(flow, from, *push);
        let Rotor { resistance, viscous, .. } = *flow.rotor();
        let [mut charge, mut heat, mut turned, mut back] = [0.0; 4];
        panels(t, flow.fastest(), |weight, t| {
            let x = piece.at(t).0;
            charge += weight * x.current;
            heat += weight * x.current * x.current;
            turned += weight * x.speed * x.speed;
            back += weight * x.speed * x.current;
        });
        self.heat += resistance * heat;
        self.viscous += viscous * turned;
        self.dry += coulomb * piece.at(t).1.abs();
        self.supplied +=
            if flow.is_held() { resistance * heat + flow.rotor().gain * back } else { push.volts * charge };
    }

    /// At rest, while the current goes where it goes at last.
    pub(super) fn relaxing(&mut self, rotor: &Rotor, volts: f64, from: f64, at_last: f64, t: f64) {
        let (mut charge, mut heat) = (0.0, 0.0);
        let rate = if rotor.inductance > 0.0 { rotor.resistance / rotor.inductance } else { 0.0 };
        panels(t, rate, |weight, t| {
            let current = if from == at_last || rate == 0.0 {
                at_last
            } else {
                from + t * of_number(-rate * t)[0] * rate * (at_last - from)
            };
            charge += weight * current;
            heat += weight * current * current;
        });
        self.supplied += volts * charge;
        self.heat += rotor.resistance * heat;
    }
}

/// Calls with weights and times of a rule for 0 to `t`.
fn panels(t: f64, fastest: f64, mut node: impl FnMut(f64, f64)) {
    let (mut begin, mut length) = (0.0, if fastest * t > 1.0 { 1.0 / fastest } else { t });
    for n in 0..MOST_PANELS {
        let end = if n + 1 == MOST_PANELS { t } else { (begin + length).min(t) };
        let (middle, half) = (0.5 * (begin + end), 0.5 * (end - begin));
        for (x, weight) in NODES {
            node(weight * half, middle - x * half);
            node(weight * half, middle + x * half);
        }
        if end >= t {
            return;
        }
        length += length;
        begin = end;
    }
}

impl<const BOOKED: bool> Motor<BOOKED> {
    pub(super) fn magnetic(&self) -> f64 {
        0.5 * self.rotor.inductance * self.state.current * self.state.current
    }

    /// The voltage at the terminals.
    pub(super) fn terminal(&self) -> f64 {
        let x = self.state.motion();
        match self.regime {
            Regime::Coil => self.volts,
            Regime::Held => self.rotor.resistance * x.current + self.rotor.gain * x.speed,
        }
    }

    /// What is stored in the coil, the rotor and the height of the mass, J.
    pub fn stored(&self) -> f64 {
        let speed = self.state.speed;
        // 1 − cos θ = 2 sin² θ/2, which loses nothing near the lowest place.
        let half = sine(0.5 * self.state.phase);
        let height = 2.0 * half * half;
        self.magnetic() + 0.5 * self.rotor.inertia * speed * speed + self.weight * height
    }
}

impl Motor<true> {
    /// What came in and where it went since the motor was placed.
    pub fn energy(&self) -> Energy {
        self.energy
    }
}
