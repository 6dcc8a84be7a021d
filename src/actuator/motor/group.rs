//! Eight rumble motors side by side.

mod lane;

use super::drive::{Drive, MOST_DRIVE};
use super::model::{Motor, NOTHING};
use super::output::Reading;
use super::parameters::Parameters;
use super::plan::{Level, Plan};
use super::table::Row;
use crate::actuator::elementary::wrapped;
use crate::actuator::fault::Fault;

/// Motors in a group.
pub const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Eight motors whose common steps are taken together: gravity left out, everything else as each [`Motor`] has it, to the bit. A motor in which
/// something may happen takes that step by itself, and so does one that is at rest, driven by a current, or held by springs that matter. A place
/// without a motor costs next to nothing.
#[derive(Debug, Clone)]
pub struct Group {
    motors: [Option<Motor>; LANES],
    /// Whose state stands in the lanes, and not in the motor.
    aboard: [bool; LANES],
    /// Those of them at a voltage; where there is no inductance, with what of voltage and speed makes the current.
    voltage: [Option<Option<(f64, f64)>>; LANES],
    #[cfg(target_arch = "x86_64")]
    avx2: bool,
    /// Whether all lanes with a motor take a voltage as it comes.
    all_take_volts: bool,
    /// Whether any has no dry friction, so that its motion may dwindle.
    any_smooth: bool,
    lanes: State,
    steps: Steps,
}

/// By lane. Aligned, so that lanes are loaded as they are used.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct State {
    current: Lanes,
    speed: Lanes,
    phase: Lanes,
    turns: Lanes,
    volts: Lanes,
}

/// What a step adds: of current, speed and voltage, and by itself; and what it must keep to.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct Steps {
    current: [Lanes; 4],
    speed: [Lanes; 4],
    turns: [Lanes; 4],
    sense: [Lanes; 2],
    dip: [Lanes; 3],
}

impl Group {
    /// Motors at `rate` steps a second; `None` leaves a lane empty. Gravity is not computed. With `inductance` off none has any.
    ///
    /// # Errors
    /// As [`Motor::new`], of the first that is wrong, with its lane.
    pub fn new(
        parameters: &[Option<Parameters>; LANES],
        inductance: bool,
        rate: f64,
    ) -> Result<Self, (usize, Fault)> {
        let level = if inductance { Level::Default } else { Level::Economy };
        let plan = Plan { gravity: false, ..Plan::whole(level) };
        let mut motors = [const { None }; LANES];
        for (lane, (motor, parameters)) in motors.iter_mut().zip(parameters).enumerate() {
            if let Some(parameters) = parameters {
                *motor = Some(Motor::new(parameters, &plan, rate).map_err(|fault| (lane, fault))?);
            }
        }
        let no = [0.0; LANES];
        let mut group = Self {
            motors,
            aboard: [false; LANES],
            voltage: [None; LANES],
            #[cfg(target_arch = "x86_64")]
            avx2: std::arch::is_x86_feature_detected!("avx2"),
            all_take_volts: false,
            any_smooth: parameters.iter().flatten().any(|p| p.stiction == 0.0),
            lanes: State { current: no, speed: no, phase: no, turns: no, volts: no },
            steps: Steps { current: [no; 4], speed: [no; 4], turns: [no; 4], sense: [no; 2], dip: [no; 3] },
        };
        for lane in 0..LANES {
            group.board(lane);
        }
        Ok(group)
    }

    /// Puts the mass of a motor at an angle (rad, 0 hanging) and gives it a speed (rad/s), without current; nothing where there is no motor.
    pub fn place(&mut self, lane: usize, angle: f64, speed: f64) {
        self.alone(lane, |motor| motor.place(angle, speed));
    }

    /// Does this to a motor from now on; nothing where there is none.
    #[inline]
    pub fn drive(&mut self, lane: usize, drive: Drive) {
        if let (Drive::Voltage(volts), Some(Some(dictates))) = (drive, self.voltage.get(lane))
            && volts.abs() <= MOST_DRIVE
        {
            if let Some((of_volts, of_speed)) = dictates
                && volts != self.lanes.volts[lane]
            {
                self.lanes.current[lane] = of_volts * volts + of_speed * self.lanes.speed[lane];
            }
            self.lanes.volts[lane] = volts;
            return;
        }
        self.alone(lane, |motor| motor.drive(drive));
    }

    /// [`Group::drive`] for all lanes, each a voltage.
    #[inline]
    pub fn voltages(&mut self, volts: &Lanes) {
        // By far the most common: all take a voltage as it comes.
        let mut sane = true;
        for v in volts {
            sane &= v.abs() <= MOST_DRIVE;
        }
        if self.all_take_volts && sane {
            self.lanes.volts = *volts;
            return;
        }
        for (lane, v) in volts.iter().enumerate() {
            self.drive(lane, Drive::Voltage(*v));
        }
    }

    /// One step further, all of them.
    #[inline]
    pub fn step(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if self.avx2 {
            // SAFETY: the instruction set was found on this machine when the group was made.
            unsafe { self.step_avx2() };
            return;
        }
        self.step_plain();
    }

    /// The same, four lanes to an instruction. Nothing contracts a multiply and an add, so the bits are the same.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn step_avx2(&mut self) {
        self.step_plain();
    }

    #[inline(always)]
    fn step_plain(&mut self) {
        let (now, steps) = (&self.lanes, &self.steps);
        let (i, w, v) = (&now.current, &now.speed, &now.volts);
        let (mut current, mut speed, mut phase) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        // In the order of a motor's own step.
        let [a, b, c, d] = &steps.current;
        for l in 0..LANES {
            current[l] = ((i[l] + (c[l] * v[l] + d[l])) + a[l] * i[l]) + b[l] * w[l];
        }
        let [a, b, c, d] = &steps.speed;
        for l in 0..LANES {
            speed[l] = w[l] + ((a[l] * i[l] + (c[l] * v[l] + d[l])) + b[l] * w[l]);
        }
        let [a, b, c, d] = &steps.turns;
        for l in 0..LANES {
            phase[l] = now.phase[l] + ((a[l] * i[l] + (c[l] * v[l] + d[l])) + b[l] * w[l]);
        }
        let mut unfit = [0; LANES];
        for l in 0..LANES {
            let dips = steps.dip[0][l] * i[l] + steps.dip[1][l] * w[l] < steps.dip[2][l];
            let turns_on = steps.sense[0][l] * speed[l] > steps.sense[1][l];
            unfit[l] = u64::from(dips) | u64::from(!turns_on);
        }
        if self.any_smooth {
            for l in 0..LANES {
                unfit[l] |= u64::from(speed[l].abs() < NOTHING) & u64::from(speed[l] != 0.0);
            }
        }
        let any = unfit.iter().fold(0, |any, one| any | one);
        let mut beyond = [0; LANES];
        for l in 0..LANES {
            beyond[l] = u64::from(phase[l].abs() > 0.5);
        }
        let beyond = beyond.iter().fold(0, |any, one| any | one);
        let before = (any > 0).then(|| now.clone());
        let lanes = &mut self.lanes;
        (lanes.current, lanes.speed, lanes.phase) = (current, speed, phase);
        if beyond > 0 {
            for l in 0..LANES {
                let (rest, whole) = wrapped(phase[l]);
                (lanes.phase[l], lanes.turns[l]) = (rest, lanes.turns[l] + whole);
            }
        }
        if let Some(before) = before {
            self.each(&before, &unfit);
        }
    }

    /// Puts back those that do not fit, and steps them one by one.
    #[cold]
    #[inline(never)]
    fn each(&mut self, before: &State, unfit: &[u64; LANES]) {
        for lane in 0..LANES {
            if unfit[lane] > 0 {
                self.lanes.current[lane] = before.current[lane];
                self.lanes.speed[lane] = before.speed[lane];
                self.lanes.phase[lane] = before.phase[lane];
                self.lanes.turns[lane] = before.turns[lane];
                self.alone(lane, Motor::step);
            }
        }
    }

    /// What a motor does now; `None` where there is none.
    pub fn reading(&mut self, lane: usize) -> Option<Reading> {
        self.land(lane);
        self.motors.get(lane)?.as_ref().map(Motor::reading)
    }

    /// Currents (A), speeds (rad/s) and angles (turns within ±½) of all.
    pub fn seen(&self) -> [[f64; LANES]; 3] {
        [self.lanes.current, self.lanes.speed, self.lanes.phase]
    }

    /// Something that a motor does by itself.
    fn alone(&mut self, lane: usize, mut work: impl FnMut(&mut Motor)) {
        self.land(lane);
        if let Some(Some(motor)) = self.motors.get_mut(lane) {
            work(motor);
            self.board(lane);
        }
        let takes = |lane: usize| self.motors[lane].is_none() || self.voltage[lane] == Some(None);
        self.all_take_volts = (0..LANES).all(takes);
    }

    /// Tells the motor what its lane knows.
    fn land(&mut self, lane: usize) {
        if let (Some(Some(motor)), Some(true)) = (self.motors.get_mut(lane), self.aboard.get(lane)) {
            let now = &self.lanes;
            let state = [now.current[lane], now.speed[lane], now.phase[lane], now.turns[lane]];
            motor.set_lane(state, self.voltage[lane].map(|_| now.volts[lane]));
        }
    }

    /// Tells the lane what its motor knows; one that must step by itself stays out.
    fn board(&mut self, lane: usize) {
        let Some(motor) = &self.motors[lane] else {
            // An empty lane: nothing moves, and nothing can happen.
            self.steps.sense[1][lane] = -1.0;
            return;
        };
        let ([current, speed, phase, turns], volts) = motor.lane_state();
        (self.lanes.current[lane], self.lanes.speed[lane]) = (current, speed);
        (self.lanes.phase[lane], self.lanes.turns[lane]) = (phase, turns);
        self.aboard[lane] = motor.is_plain();
        if !self.aboard[lane] {
            // No speed is above this: it never fits.
            (self.steps.sense[1][lane], self.voltage[lane]) = (f64::INFINITY, None);
            return;
        }
        let swift = &motor.swift;
        let by = |row: &Row| [row[0], row[1], row[2], row[3] * swift.friction];
        for (lanes, row) in [
            (&mut self.steps.current, &swift.table.current),
            (&mut self.steps.speed, &swift.table.speed),
            (&mut self.steps.turns, &swift.table.turns),
        ] {
            for (to, from) in lanes.iter_mut().zip(by(row)) {
                to[lane] = from;
            }
        }
        for (to, from) in self.steps.dip.iter_mut().zip(swift.bounds.dip) {
            to[lane] = from;
        }
        (self.steps.sense[0][lane], self.steps.sense[1][lane]) = swift.bounds.sense;
        self.lanes.volts[lane] = volts;
        self.voltage[lane] = matches!(motor.drive, Drive::Voltage(_)).then_some(motor.flows[0].dictates());
    }
}

#[cfg(test)]
mod tests;
