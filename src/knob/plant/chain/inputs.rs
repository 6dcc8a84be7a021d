//! What a command and a hand do to a chain.

use super::{Chain, Contact, Grip};
use crate::actuator::exponential::MOST;
use crate::knob::plant::network::SPEED;
use crate::knob::plant::parameters::MOST_TORQUE;
use crate::knob::plant::parts::{Drive, Hand};

impl Chain {
    /// Passes one step with a command held over it ([`Drive`] says of what) and a hand. What is no number or beyond limits counts as 0 and is
    /// counted; a hand whose target is no number stays where it was.
    pub fn step(&mut self, command: f64, hand: &Hand) {
        let command = self.checked(command);
        let (most, gain) = (self.network.build.winding()).map_or((0.0, 1.0), |w| (w.supply, w.gain));
        (self.torque, self.command) = match self.network.build.drive {
            Drive::Torque => (command, 0.0),
            Drive::Voltage(_) => (0.0, command.clamp(-most, most)),
            Drive::Current { peak, .. } => (0.0, (command / gain).clamp(-peak, peak)),
        };
        self.hand.torque = self.checked(hand.torque);
        if hand.target.abs() <= 1e9 && hand.target_speed.abs() <= 1e9 {
            (self.hand.target, self.hand.target_speed) = (hand.target, hand.target_speed);
        } else {
            self.counts.masked += 1;
            self.hand.target = self.network.target.map_or(0.0, |target| self.origin + self.x[target]);
            self.hand.target_speed = 0.0;
        }
        if let Some(target) = self.network.target {
            self.x[target] = self.hand.target - self.origin;
        }
        self.renew();
        self.begin();
        let piece = self.period / self.pieces as f64;
        for n in 0..self.pieces {
            let waves = self.waved && self.grip != Grip::Sticks;
            if waves || !self.glide(piece) {
                return self.careful(self.period - n as f64 * piece);
            }
        }
    }

    fn checked(&mut self, value: f64) -> f64 {
        if value.abs() <= MOST_TORQUE {
            return value;
        }
        self.counts.masked += 1;
        0.0
    }

    /// What new inputs change at once.
    fn begin(&mut self) {
        if let Drive::Current { winding, .. } = self.network.build.drive {
            let asks = self.asks();
            self.limit = if asks.abs() > winding.supply { 1.0f64.copysign(asks) } else { 0.0 };
        }
        self.drives();
        if self.grip == Grip::Sticks {
            let net = self.net();
            if net.abs() > self.network.build.parameters.stiction {
                self.counts.events += 1;
                self.grip = Grip::Slips(1.0f64.copysign(net));
                self.drives();
            }
        }
    }

    /// f of inputs and mode.
    pub(super) fn drives(&mut self) {
        let (network, p) = (&self.network, &self.network.build.parameters);
        let mut f = [0.0; MOST];
        let speed = network.knob + 1;
        let rubs = if let Grip::Slips(sense) = self.grip { sense * p.coulomb } else { 0.0 };
        f[SPEED] += (self.torque - rubs) / p.inertia;
        let mut on_knob = self.hand.torque;
        if let Some(grasp) = &network.build.grasp {
            on_knob += grasp.damping * self.hand.target_speed;
        }
        if let (Contact::Touching(side), Some(stops)) = (self.contact, p.stops) {
            on_knob += stops.stiffness * self.stop(side);
        }
        f[speed] += on_knob / network.knob_inertia();
        if let Some(target) = network.target {
            f[target] = self.hand.target_speed;
        }
        match (network.build.drive, network.current, network.integral) {
            (Drive::Voltage(winding), Some(i), _) => f[i] = self.command / winding.inductance,
            (Drive::Current { winding, .. }, Some(i), Some(q)) => {
                let proportional = network.loop_gains().0;
                if self.limit == 0.0 {
                    (f[i], f[q]) = (proportional * self.command / winding.inductance, self.command);
                } else {
                    let volts = self.limit * winding.supply;
                    (f[i], f[q]) = (volts / winding.inductance, volts / proportional);
                }
            }
            _ => {}
        }
        if self.grip == Grip::Sticks {
            f[SPEED] = 0.0;
        }
        self.force = f;
    }
}
