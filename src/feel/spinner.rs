//! A rumble motor on an output.

use super::heat::Heat;
use crate::actuator::drive::Drive as Imposed;
use crate::actuator::fault::Fault;
use crate::actuator::link::amplifier::Amplifier;
use crate::actuator::link::carrier::Carrier;
use crate::actuator::link::diodes::Diodes;
use crate::actuator::motor::{Casing, Drive, Level, MOST_DRIVE, Motor, Parameters, Part, Plan, Wish};

/// A rumble motor, what drives it, and what is seen of it.
#[derive(Debug, Clone)]
pub(super) struct Spinner {
    motor: Motor<false>,
    /// Steps of the motor for each sample.
    steps: u32,
    rate: f64,
    /// The most volts of a source that imposes a current; `None`: it imposes a voltage.
    compliance: Option<f64>,
    /// What lets current in alone; `None`: nothing.
    diodes: Option<Diodes>,
    /// Whether nothing moves, so that force is told.
    held: bool,
    /// Velocity of the casing, or impulse on what holds it.
    given: [f64; 2],
    current: f64,
    turned: f64,
    fastest: f64,
    energy: f64,
    heat: Heat,
    /// Samples at whose end a source that imposes a current was at its limit.
    limited: u64,
}

/// Steps for each sample, at most.
const MOST_STEPS: u32 = 16;
/// The springs of a casing see the mass between the ends of a step as a cubic (Hermite): the fourth power of the angle of a step over this is
/// what that misses of it.
const CUBIC: f64 = 384.0;

/// The plan that grants a wish at `rate` samples a second, and how many steps a sample takes.
pub(super) fn plan(parameters: &Parameters, rate: f64, error: f64, posture: bool) -> (Plan, u32) {
    // What is felt goes with the square of the speed.
    let wish = Wish { error: 0.5 * error, posture, casing: true };
    let suspended = matches!(parameters.casing, Casing::Suspended { across, upright, .. }
        if across.stiffness + across.damping + upright.stiffness + upright.damping > 0.0);
    let mut steps = 1;
    loop {
        let rate = rate * f64::from(steps);
        let plan = Plan::choose(parameters, rate, &wish);
        let turned = parameters.rated_speed() / rate;
        let cubic = if suspended { turned * turned * turned * turned / CUBIC } else { 0.0 };
        if steps >= MOST_STEPS || (plan.error(parameters, rate) <= wish.error && cubic <= error) {
            return (plan, steps);
        }
        steps *= 2;
    }
}

/// The same with the inductance of the coil, whatever it would change at a steady voltage: behind diodes, current begins and ends with every
/// half-wave.
pub(super) fn with_coil(plan: Plan) -> Plan {
    let kept = plan.left_out.map(|left| left.filter(|left| left.part != Part::Inductance));
    let level = if plan.level == Level::Economy { Level::Default } else { plan.level };
    Plan { level, inductance: true, left_out: kept, ..plan }
}

impl Spinner {
    /// At rest, its mass hanging down, `rate` samples a second.
    ///
    /// # Errors
    /// A parameter or a rate that cannot be.
    pub fn new(
        parameters: &Parameters,
        (plan, steps): (Plan, u32),
        amplifier: &Amplifier,
        carrier: Option<&Carrier>,
        rate: f64,
        heat: Heat,
    ) -> Result<Self, Fault> {
        let current = amplifier.drive == Imposed::Current;
        Ok(Self {
            motor: Motor::new(parameters, &plan, rate * f64::from(steps))?,
            steps,
            rate,
            compliance: current.then_some(amplifier.volts.unwrap_or(f64::INFINITY)),
            diodes: carrier.map(|carrier| Diodes::new(carrier.rectifier, rate * f64::from(steps))),
            held: parameters.casing == Casing::Held,
            given: [0.0; 2],
            current: 0.0,
            turned: 0.0,
            fastest: 0.0,
            energy: 0.0,
            heat,
            limited: 0,
        })
    }

    /// Holds each drive (V or A) for a sample, or, before diodes, for a step; the mean acceleration, or force, over each sample.
    pub fn run(&mut self, drives: &[f64], felt: &mut [[f64; 2]]) {
        let each = if self.diodes.is_some() { self.steps as usize } else { 1 };
        for (drives, felt) in drives.chunks_exact(each).zip(felt) {
            if let Some(diodes) = self.diodes {
                self.pass(&diodes, drives);
            } else if let [drive] = drives {
                self.motor.drive(match self.compliance {
                    None => Drive::Voltage(*drive),
                    Some(limit) => Drive::Current { amperes: *drive, limit },
                });
                for _ in 0..self.steps {
                    self.motor.step();
                }
                self.book(*drive);
            }
            let given = if self.held { self.motor.impulse() } else { self.motor.casing_velocity() };
            let last = std::mem::replace(&mut self.given, given);
            *felt = [(given[0] - last[0]) * self.rate, (given[1] - last[1]) * self.rate];
            self.fastest = self.fastest.max(self.motor.speed().abs());
        }
    }

    /// A sample behind diodes, and what passed the terminals in it.
    fn pass(&mut self, diodes: &Diodes, sources: &[f64]) {
        let p = *self.motor.parameters();
        // A current in half-waves warms by more than the square of its mean.
        let (mut square, mut energy) = (0.0, 0.0);
        let (mut current, mut turned) = (self.current, self.turned);
        for source in sources {
            diodes.step(&mut self.motor, *source, |motor, volts, seconds| {
                if let Some(volts) = volts {
                    let stored = p.inductance * (motor.current() - current);
                    let passed =
                        (volts * seconds - stored - p.gain * (motor.turned() - turned)) / p.resistance;
                    square += passed * passed / seconds;
                    energy += volts * passed;
                }
                (current, turned) = (motor.current(), motor.turned());
            });
        }
        self.energy += energy;
        self.heat.take_square(square * self.rate);
        (self.current, self.turned) = (current, turned);
    }

    /// What passed the terminals in a sample: at a voltage, R ∫i dt = V T − L Δi − k Δθ, whatever friction did meanwhile. Exact but for samples in
    /// which a source of current meets its limit.
    #[inline]
    fn book(&mut self, drive: f64) {
        let p = self.motor.parameters();
        let (current, volts, turned) = (self.motor.current(), self.motor.voltage(), self.motor.turned());
        let back = p.gain * (turned - self.turned);
        // The model takes less than 1e-30 A for none, and what is no drive for a short circuit: neither is a limit.
        let is_limited = self.compliance.is_some_and(|limit| current != drive && volts.abs() >= limit);
        let is_held = self.compliance.is_some() && !is_limited && drive.abs() <= MOST_DRIVE;
        let charge = if is_held {
            self.energy += current * (p.resistance * current / self.rate + back);
            current / self.rate
        } else {
            let stores = self.motor.plan().inductance && self.motor.plan().level != Level::Economy;
            let stored = if stores { p.inductance * (current - self.current) } else { 0.0 };
            let charge = (volts / self.rate - stored - back) / p.resistance;
            self.limited += u64::from(is_limited);
            self.energy += volts * charge;
            charge
        };
        self.heat.take(charge * self.rate);
        (self.current, self.turned) = (current, turned);
    }

    /// How fast it turns, rad/s.
    pub fn speed(&self) -> f64 {
        self.motor.speed()
    }

    /// How far it has turned, rad from where its mass hangs straight down.
    pub fn turned(&self) -> f64 {
        self.motor.turned()
    }

    /// What coil and friction do to the casing about the shaft, N m.
    pub fn reaction(&self) -> f64 {
        self.motor.reaction()
    }

    /// The fastest so far, rad/s.
    pub fn fastest(&self) -> f64 {
        self.fastest
    }

    /// Drawn so far, J.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// See [`Heat::warmest`].
    pub fn warmest(&self) -> Option<f64> {
        self.heat.warmest()
    }

    /// Samples at which the amplifier's other limit was met, and drives that the model did not take.
    pub fn counts(&self) -> [u64; 2] {
        [self.limited, self.motor.counts().masked]
    }
}

#[cfg(test)]
mod tests {
    use super::{Level, Part, Plan, plan, with_coil};
    use crate::actuator::motor::Parameters;

    /// Of a coil that keeps its current for so short that nobody feels it at a steady voltage, the plan leaves the inductance out; behind diodes it is put
    /// back, with a level that has one, and what else is left out stays so.
    #[test]
    fn behind_diodes_a_coil_is_never_left_out() {
        let p = Parameters { inductance: 3e-7, ..Parameters::COIN };
        let parts = |plan: &Plan| plan.left_out.iter().flatten().map(|left| left.part).collect::<Vec<_>>();
        for error in [0.2, 1e-3] {
            let (without, _) = plan(&p, 48_000.0, error, false);
            assert!(!without.inductance && parts(&without).contains(&Part::Inductance), "{without:?}");
            let with = with_coil(without);
            assert!(with.inductance && with.level != Level::Economy, "{with:?}");
            let others: Vec<Part> =
                parts(&without).into_iter().filter(|part| *part != Part::Inductance).collect();
            assert!(!others.is_empty() && parts(&with) == others, "{with:?}");
            if without.level != Level::Economy {
                assert_eq!(with.level, without.level);
            }
        }
        assert_eq!(
            plan(&p, 48_000.0, 0.2, false).0.level,
            Level::Economy,
            "one of them has the level that has none"
        );
    }
}
