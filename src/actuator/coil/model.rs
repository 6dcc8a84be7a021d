//! A coil actuator in time, one sample at a step, its drive held over each.
//!
//! Steps are exact: the matrix exponential of the plant. So a model is as stable as the plant, which is passive, at any rate and for any
//! parameter that [`Plant`] admits: resonance beyond half the rate, inductance 0 or nearly so, no damping at all.

use super::bounds::Bounds;
use super::contact::Contact;
use super::flow::Flow;
use super::plant::{MOST_STATES, Plant};
use super::readout::{Outputs, Readout};
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, Limit, check};

/// Drives beyond this, and what is not a number, count as 0.
const MOST_DRIVE: f64 = 1e9;
/// The least rate, Hz.
const LEAST_RATE: f64 = 1e-3;
/// Below this a state is nothing: no number becomes so small that arithmetic slows down.
const NOTHING: f64 = 1e-30;
/// Steps after which that is looked at.
const SETTLE: u32 = 64;

/// Where everything is, how fast it moves, what flows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Of the contactor in its housing, or the slug in its casing, metres from rest.
    pub displacement: f64,
    /// Of the same, metres a second.
    pub velocity: f64,
    /// Of the layer of the skin, or the casing in the hand, metres; 0 where there is no such.
    pub other_displacement: f64,
    /// Of the same, metres a second.
    pub other_velocity: f64,
    /// Amperes; 0 where it is no state: without inductance, or under a current drive.
    pub current: f64,
}

/// A coil actuator in time.
///
/// ```
/// use pacinian::actuator::coil::model::Model;
/// use pacinian::actuator::coil::parameters::{Coil, Skin, Spring, Tissue, VoiceCoil};
/// use pacinian::actuator::coil::plant::Plant;
/// use pacinian::actuator::drive::Drive;
///
/// let skin = Tissue { mass: 1e-4, spring: Spring { stiffness: 1200.0, damping: 1.5 } };
/// let plant = Plant::voice_coil(&VoiceCoil {
///     coil: Coil { resistance: 7.0, inductance: 2.5e-4, force_factor: 1.2 },
///     mass: 1.5e-3,
///     suspension: Spring { stiffness: 3132.7, damping: 0.6 },
///     skin: Skin::One(skin),
/// })?;
/// let mut model = Model::new(&plant, 48_000.0, Drive::Voltage)?;
/// let rest = (0..9600).fold(0.0, |_, _| model.step(1.0).displacement);
/// assert!((rest - 1.2 / 7.0 / 4332.7).abs() < 1e-12);
/// # Ok::<(), pacinian::actuator::fault::Fault>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    plant: Plant,
    drive: Drive,
    period: f64,
    sized: Sized,
    last: f64,
    masked: u64,
    until_settled: u32,
}

/// By the number of states; alone, or with contacts.
#[derive(Debug, Clone)]
enum Sized {
    Two(Linear<2>),
    Three(Linear<3>),
    Four(Linear<4>),
    Five(Linear<5>),
    ContactTwo(Box<Contact<2>>),
    ContactThree(Box<Contact<3>>),
    ContactFour(Box<Contact<4>>),
    ContactFive(Box<Contact<5>>),
}

macro_rules! each {
    ($sized:expr, $it:ident => $what:expr) => {
        match $sized {
            Sized::Two($it) => $what,
            Sized::Three($it) => $what,
            Sized::Four($it) => $what,
            Sized::Five($it) => $what,
            Sized::ContactTwo($it) => $what,
            Sized::ContactThree($it) => $what,
            Sized::ContactFour($it) => $what,
            Sized::ContactFive($it) => $what,
        }
    };
}

impl Model {
    /// At rest, `rate` samples a second (at least 0.001), without limits to its motion.
    ///
    /// # Errors
    /// The rate, if it cannot be.
    pub fn new(plant: &Plant, rate: f64, drive: Drive) -> Result<Self, Fault> {
        Self::bounded(plant, rate, drive, &Bounds::default())
    }

    /// As [`Model::new`], but what moves may hit its end stops and lose the skin. Steps near neither cost little more.
    ///
    /// # Errors
    /// A rate or a bound that cannot be.
    pub fn bounded(plant: &Plant, rate: f64, drive: Drive, bounds: &Bounds) -> Result<Self, Fault> {
        check("rate", rate, Limit::Least(LEAST_RATE))?;
        let period = 1.0 / rate;
        bounds.check(plant)?;
        let stores = drive == Drive::Voltage && plant.coil.inductance > 0.0;
        let sized = match (bounds.is_none(), plant.bodies, stores) {
            (true, 1, false) => Sized::Two(Linear::new(plant, period, drive)),
            (true, 1, true) => Sized::Three(Linear::new(plant, period, drive)),
            (true, _, false) => Sized::Four(Linear::new(plant, period, drive)),
            (true, _, true) => Sized::Five(Linear::new(plant, period, drive)),
            (_, 1, false) => Sized::ContactTwo(Box::new(Contact::new(plant, period, drive, bounds)?)),
            (_, 1, true) => Sized::ContactThree(Box::new(Contact::new(plant, period, drive, bounds)?)),
            (_, _, false) => Sized::ContactFour(Box::new(Contact::new(plant, period, drive, bounds)?)),
            (_, _, true) => Sized::ContactFive(Box::new(Contact::new(plant, period, drive, bounds)?)),
        };
        Ok(Self { plant: *plant, drive, period, sized, last: 0.0, masked: 0, until_settled: SETTLE })
    }

    /// Holds a drive (volts or amperes) for a sample. One that is not a number, or beyond 1e9, counts as 0.
    #[inline]
    pub fn advance(&mut self, drive: f64) {
        self.run(&[drive], |_| ());
    }

    /// Holds each drive for a sample, and shows what is done at the end of each: as so many single steps, in less time.
    #[inline]
    pub fn run(&mut self, mut drives: &[f64], mut see: impl FnMut(Outputs)) {
        while !drives.is_empty() {
            let (now, later) = drives.split_at(drives.len().min(self.until_settled as usize));
            each!(&mut self.sized, it => {
                for &drive in now {
                    let sound = drive.abs() < MOST_DRIVE;
                    self.masked += u64::from(!sound);
                    let drive = if sound { drive } else { 0.0 };
                    it.advance(drive);
                    self.last = drive;
                    see(it.readout().read(&it.state, drive));
                }
            });
            drives = later;
            self.until_settled -= now.len() as u32;
            if self.until_settled == 0 {
                self.until_settled = SETTLE;
                each!(&mut self.sized, it => settle(&mut it.state));
            }
        }
    }

    /// What it does at the end of the last sample, the drive not yet changed.
    #[inline]
    pub fn outputs(&self) -> Outputs {
        each!(&self.sized, it => it.readout().read(&it.state, self.last))
    }

    /// A step, and what is done at its end.
    #[inline]
    pub fn step(&mut self, drive: f64) -> Outputs {
        let mut outputs = Outputs::default();
        self.run(&[drive], |o| outputs = o);
        outputs
    }

    /// The current at the end of the next sample under no drive, and what each volt (or ampere) adds to it, as far as no contact
    /// begins or ends meanwhile.
    pub(super) fn current_ahead(&self) -> [f64; 2] {
        each!(&self.sized, it => {
            let at = |drive: f64| it.readout().read(&it.flow().after(&it.state, drive), drive).current;
            [at(0.0), at(1.0) - at(0.0)]
        })
    }

    /// Where everything is.
    pub fn state(&self) -> State {
        let mut all = [0.0; MOST_STATES];
        each!(&self.sized, it => all[..it.state.len()].copy_from_slice(&it.state));
        let n = 2 * self.plant.bodies;
        let [other_displacement, other_velocity] = if n == 4 { [all[2], all[3]] } else { [0.0; 2] };
        let current = if self.states() > n { all[n] } else { 0.0 };
        State { displacement: all[0], velocity: all[1], other_displacement, other_velocity, current }
    }

    /// Puts everything elsewhere. What is no state is passed over; what is not finite counts as 0.
    pub fn set_state(&mut self, state: &State) {
        let n = 2 * self.plant.bodies;
        let mut all =
            [state.displacement, state.velocity, state.other_displacement, state.other_velocity, 0.0];
        all[n] = state.current;
        let all = all.map(|x| if x.is_finite() { x } else { 0.0 });
        each!(&mut self.sized, it => {
            let length = it.state.len();
            it.state.copy_from_slice(&all[..length]);
            it.resume();
        });
    }

    /// What it is a model of.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What drives it.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Seconds a step.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Drives that were masked so far.
    pub fn masked(&self) -> u64 {
        self.masked
    }

    /// Contacts begun and ended so far, and steps that had more of them than can be followed.
    pub fn contacts(&self) -> Counts {
        each!(&self.sized, it => it.counts())
    }

    /// Energy in masses, springs, bounds and coil, joules; that of rest is 0. Under a current drive the coil's is left out.
    pub fn energy(&self) -> f64 {
        let State { current, .. } = self.state();
        let coil = 0.5 * self.plant.coil.inductance * current * current;
        coil + each!(&self.sized, it => it.mechanical_energy(&self.plant))
    }

    fn states(&self) -> usize {
        each!(&self.sized, it => it.state.len())
    }
}

/// What happened at the bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Contacts that began or ended.
    pub events: u64,
    /// Steps with more events than are followed: for their rest, what moves stood still.
    pub capped: u64,
}

/// No bounds: one flow.
#[derive(Debug, Clone)]
struct Linear<const N: usize> {
    state: [f64; N],
    flow: Flow<N>,
    readout: Readout<N>,
}

impl<const N: usize> Linear<N> {
    fn new(plant: &Plant, period: f64, drive: Drive) -> Self {
        let system = plant.system(drive, &super::plant::Touch::default());
        debug_assert_eq!(system.size, N);
        let readout = Readout::new(plant, drive, &system, true, 0.0);
        Self { state: [0.0; N], flow: Flow::new(&system, period), readout }
    }

    #[inline(always)]
    fn advance(&mut self, drive: f64) {
        self.state = self.flow.driven(&self.state, drive);
    }

    fn readout(&self) -> &Readout<N> {
        &self.readout
    }

    fn flow(&self) -> &Flow<N> {
        &self.flow
    }

    fn mechanical_energy(&self, plant: &Plant) -> f64 {
        plant.mechanical_energy(&self.state)
    }

    fn resume(&mut self) {}

    fn counts(&self) -> Counts {
        Counts::default()
    }
}

fn settle(state: &mut [f64]) {
    for x in state {
        if x.abs() < NOTHING {
            *x = 0.0;
        }
    }
}

#[cfg(test)]
mod tests;
