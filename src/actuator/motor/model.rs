//! A rumble motor as it runs.

use super::drive::Drive;
use super::energy::Energy;
use super::flow::{Flow, Push, Rotor};
use super::kernels::of_number;
use super::mount::Mount;
use super::parameters::{Casing, Parameters};
use super::plan::{Level, Plan};
use super::swift::{Bounds, MIDPOINT, Method, NONE, PARABOLA, State, Swift};
use super::table::Table;
use crate::actuator::elementary::{sine, wrapped};
use crate::actuator::fault::{Fault, within};

/// Below this a current (A) or a speed (rad/s) is nothing.
pub(super) const NOTHING: f64 = 1e-30;

/// A rumble motor, step by step.
///
/// Voltage and friction act exactly, for every step and every parameter that [`Parameters::check`] lets pass: the motion between events is the
/// exponential of its matrix, and what switches (friction at a stop, breaking away, a current source at its limit) does so at its instant within the
/// step. Only gravity is interpolated, to the order of the plan's [`Level`]. It is stable at every rate. It never allocates after it
/// was made, and a step has at most 8 events; after those, what stopped stays at rest until the step ends.
///
/// Angles count from where the mass hangs straight down. It starts there, at rest and shorted.
///
/// With `BOOKED` it keeps [`Energy`], which costs microseconds a step; without, nothing.
#[derive(Debug, Clone)]
// What a step loads stands apart from what was just stored: a load of two numbers waits for stores of one each.
#[repr(C)]
pub struct Motor<const BOOKED: bool = false> {
    pub(super) state: State,
    pub(super) counts: Counts,
    pub(super) volts: f64,
    /// Whether a step is numbers times numbers, and nothing but a whole turn can happen in it.
    pub(super) lean: bool,
    pub(super) method: Method,
    pub(super) grip: Grip,
    pub(super) regime: Regime,
    pub(super) swift: Swift,
    pub(super) drive: Drive,
    pub(super) period: f64,
    /// Where it slips: 1 forward, −1 backward; 0 elsewhere.
    pub(super) sense: f64,
    pub(super) weight: f64,
    /// The share of the way to where it goes that the current does in a step at rest.
    pub(super) settles: f64,
    pub(super) mount: Option<Mount>,
    pub(super) energy: Energy,
    pub(super) parameters: Parameters,
    pub(super) plan: Plan,
    pub(super) rotor: Rotor,
    /// With the voltage given, and with the current as it is.
    pub(super) flows: [Flow; 2],
    tables: [Table; 2],
}

/// What friction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grip {
    /// There is none.
    None,
    /// It holds the rotor.
    Sticks,
    /// The rotor turns forward or backward.
    Slips,
}

/// What makes the current.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Regime {
    /// A voltage.
    Coil = 0,
    /// It stays as it is.
    Held = 1,
}

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Drives that were no number or beyond [`super::MOST_DRIVE`], and became a short circuit.
    pub masked: u64,
    /// Stops, starts and switches of a current source at its limit.
    pub events: u64,
    /// Steps that had more than 8.
    pub crowded: u64,
}

impl<const BOOKED: bool> Motor<BOOKED> {
    /// A motor at `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first parameter, or the rate, that is beyond its limits.
    pub fn new(parameters: &Parameters, plan: &Plan, rate: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        let rotor = parameters.rotor(plan.inductance && plan.level != Level::Economy);
        let flows = [Flow::of_voltage(&rotor), Flow::of_current(&rotor)];
        let (period, weight) = (1.0 / rate, if plan.gravity { parameters.weight() } else { 0.0 });
        let mount = match parameters.casing {
            Casing::Suspended { mass, across, upright } if plan.casing => {
                Some(Mount::new(parameters.eccentric / mass, mass, [across, upright], period))
            }
            _ => None,
        };
        let mut motor = Self {
            parameters: *parameters,
            plan: *plan,
            rotor,
            flows,
            tables: flows.map(|flow| Table::of(&flow, period)),
            method: match plan.level {
                _ if weight == 0.0 => Method::None,
                Level::Fine => Method::Parabola,
                _ => Method::Midpoint,
            },
            lean: false,
            period,
            weight,
            settles: if rotor.inductance > 0.0 {
                let z = rotor.resistance / rotor.inductance * period;
                z * of_number(-z)[0]
            } else {
                1.0
            },
            state: State::default(),
            grip: if parameters.stiction > 0.0 { Grip::Sticks } else { Grip::None },
            sense: 0.0,
            drive: Drive::SHORT,
            regime: Regime::Coil,
            volts: 0.0,
            swift: Swift {
                table: Table::default(),
                bounds: Bounds::FREE,
                friction: 0.0,
                weight,
                gain: rotor.gain,
                viscous: rotor.viscous,
                inertia: rotor.inertia,
                period,
            },
            mount,
            counts: Counts::default(),
            energy: Energy::default(),
        };
        motor.place(0.0, 0.0);
        Ok(motor)
    }

    /// Puts the mass at an angle (rad, 0 hanging) and gives it a speed (rad/s), without current. What is no number, or beyond 1e9, counts as 0.
    pub fn place(&mut self, angle: f64, speed: f64) {
        let sane = |x: f64| if x.abs() <= 1e9 { x } else { 0.0 };
        let (phase, turns) = wrapped(sane(angle) / std::f64::consts::TAU);
        let speed = sane(speed);
        self.state = State { current: 0.0, phase, speed, turns, pull: self.gravity(phase) };
        if self.grip != Grip::None {
            self.hold();
            if speed != 0.0 {
                self.slip(speed);
                self.state.speed = speed;
            }
        }
        let drive = self.drive;
        self.switch(drive);
        if let Some(mount) = &mut self.mount {
            mount.place(phase, self.state.speed);
        }
        let stored = self.stored();
        self.energy.begin(stored);
    }

    /// Does this to the terminals from now on.
    #[inline(always)]
    pub fn drive(&mut self, drive: Drive) {
        match drive {
            Drive::Voltage(volts) if self.lean && volts.abs() <= super::MOST_DRIVE => {
                (self.drive, self.volts) = (drive, volts);
            }
            _ => self.drive_in_full(drive),
        }
    }

    /// The same where something may happen.
    #[inline]
    fn drive_in_full(&mut self, drive: Drive) {
        if let (Drive::Voltage(new), Drive::Voltage(old)) = (drive, self.drive) {
            // The common case, without what switching kinds needs.
            if new == old {
                return;
            }
            if new.abs() <= super::MOST_DRIVE && (self.grip != Grip::Sticks || self.rotor.inductance > 0.0) {
                (self.drive, self.volts) = (drive, new);
                if let Some(current) = self.flows[0].dictated(self.state.speed, new) {
                    self.state.current = current;
                }
                return;
            }
        }
        let (drive, masked) = drive.masked();
        self.counts.masked += u64::from(masked);
        if drive != self.drive {
            self.switch(drive);
        }
    }

    /// One step further.
    #[inline(always)]
    pub fn step(&mut self) {
        if self.lean
            && let Some((next, _)) = self.swift.step::<NONE, false, false>(&self.state, self.volts)
        {
            self.state = next;
        } else {
            self.step_in_full();
        }
    }

    /// The same where something may happen.
    #[inline]
    fn step_in_full(&mut self) {
        let (swift, state, volts) = (&self.swift, &self.state, self.volts);
        let next = match self.method {
            Method::None => swift.step::<NONE, true, true>(state, volts),
            Method::Midpoint => swift.step::<MIDPOINT, true, true>(state, volts),
            Method::Parabola => swift.step::<PARABOLA, true, true>(state, volts),
        };
        match next {
            Some((next, push)) => self.arrive(next, &push),
            None if self.grip == Grip::Sticks && self.stays() => {}
            None => self.careful(self.period),
        }
    }

    /// One step further, with other drives from some instants within it on: each a share of the step, 0 to 1, in order. What is out of
    /// order happens at once after what comes before it.
    pub fn step_with(&mut self, switches: &[(f64, Drive)]) {
        let mut done = 0.0;
        for (share, drive) in switches {
            let share = share.clamp(done, 1.0);
            if share > done {
                self.careful((share - done) * self.period);
                done = share;
            }
            self.drive(*drive);
        }
        match done {
            0.0 => self.step(),
            1.0 => {}
            _ => self.careful((1.0 - done) * self.period),
        }
    }

    /// Further by a part of a step, its share within 0 to 1; what is no number is no time. At most 8 events as in a whole one.
    pub fn part(&mut self, share: f64) {
        if share > 0.0 {
            self.careful(share.min(1.0) * self.period);
        }
    }

    /// The torque of gravity at an angle in turns, N m.
    #[inline(always)]
    pub(super) fn gravity(&self, phase: f64) -> f64 {
        if self.weight == 0.0 { 0.0 } else { -self.weight * sine(phase) }
    }

    /// Takes the end of a step in which nothing happened.
    #[inline(always)]
    fn arrive(&mut self, next: State, push: &Push) {
        if BOOKED {
            let flow = &self.flows[self.regime as usize];
            self.energy.piece(flow, self.state.motion(), push, self.parameters.coulomb, self.period);
        }
        self.state = next;
        if let Some(mount) = &mut self.mount {
            mount.step(next.phase, next.speed);
        }
    }

    /// What steps do and must keep to from now on.
    pub(super) fn bound(&mut self) {
        let (mut bounds, table) = (Bounds::FREE, &self.tables[self.regime as usize]);
        let friction = if self.grip == Grip::Slips { -self.sense * self.parameters.coulomb } else { 0.0 };
        if self.grip == Grip::Slips {
            let sign = self.sense;
            bounds.sense = (sign, NOTHING);
            let begins = &table.begins;
            let most = begins[2] * (self.parameters.coulomb + self.weight);
            bounds.dip = [sign * begins[0], sign * (1.0 + begins[1]), most];
        }
        if let Drive::Current { amperes, limit } = self.drive {
            let (r, k) = (self.rotor.resistance, self.rotor.gain);
            bounds.limited = true;
            if self.regime == Regime::Held {
                bounds.speed.0 = bounds.speed.0.max((-limit - r * amperes) / k);
                bounds.speed.1 = bounds.speed.1.min((limit - r * amperes) / k);
            } else if self.volts > 0.0 {
                bounds.current.1 = amperes;
            } else {
                bounds.current.0 = amperes;
            }
        }
        // At rest, and where it could swing within a step, nothing is taken for granted.
        if self.grip == Grip::Sticks || self.swings() * self.period > 1.0 {
            bounds.sense = (0.0, 0.0);
        }
        self.lean = !BOOKED
            && self.method == Method::None
            && self.grip == Grip::None
            && self.mount.is_none()
            && self.regime == Regime::Coil
            && self.rotor.inductance > 0.0
            && !bounds.limited;
        self.swift = Swift { table: *table, bounds, friction, ..self.swift };
    }

    /// At what rate coil and rotor swing, where an event could hide in it, rad/s.
    pub(super) fn swings(&self) -> f64 {
        let limited = self.grip != Grip::None || matches!(self.drive, Drive::Current { .. });
        if limited { self.flows[self.regime as usize].turning() } else { 0.0 }
    }
}
