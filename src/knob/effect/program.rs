//! The effects of a knob, in the order they were named.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use super::{
    constant, damper, detent, friction, hertz, inertia, magnet, snap, spin, spring, table, texture,
    transient, wall,
};
use crate::actuator::fault::{Fault, Limit, check};

/// Effects of one knob, at most.
pub const MOST_EFFECTS: usize = 64;

macro_rules! effects {
    ($($name:ident: $of:ty,)*) => {
        /// Any effect.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Any {
            $(#[doc = concat!("See [`", stringify!($of), "`].")] $name($of),)*
        }

        /// An effect and what it remembers. With a tag of its own, which costs less to tell than one that is hidden in another's fields.
        #[derive(Debug, Clone)]
        #[repr(u8)]
        enum Running {
            $($name($of, <$of as Effect>::State),)*
        }

        impl Any {
            /// Refuses what cannot be.
            ///
            /// # Errors
            /// The first figure that breaks its limit.
            pub fn check(&self) -> Result<(), Fault> {
                match self { $(Self::$name(e) => e.check(),)* }
            }

            /// How stiff and how viscous it is at most.
            pub fn bound(&self) -> Bound {
                match self { $(Self::$name(e) => e.bound(),)* }
            }

            fn started(self) -> Running {
                match self { $(Self::$name(e) => Running::$name(e, Default::default()),)* }
            }
        }

        impl Running {
            #[inline(always)]
            fn torque(&mut self, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
                match self { $(Self::$name(e, state) => e.torque(state, r, m, events),)* }
            }

            /// What it would give, and remembers nothing of it.
            fn peek(&self, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
                match self { $(Self::$name(e, state) => { let mut state = *state; e.torque(&mut state, r, m, events) })* }
            }

            fn reset(&mut self) {
                match self { $(Self::$name(_, state) => *state = Default::default(),)* }
            }

            fn energy(&self, angle: f64) -> Option<f64> {
                match self { $(Self::$name(e, _) => e.energy(angle),)* }
            }
        }

        $(impl From<$of> for Any {
            fn from(e: $of) -> Self { Self::$name(e) }
        })*
    };
}

effects! {
    Spring: spring::Spring,
    Damper: damper::Damper,
    Wall: wall::Wall,
    Stops: wall::Stops,
    Detent: detent::Detent,
    Snap: snap::Snap,
    Magnet: magnet::Magnet,
    Friction: friction::Friction,
    Inertia: inertia::Inertia,
    Constant: constant::Constant,
    Spin: spin::Spin,
    Ripple: texture::Ripple,
    Fed: texture::Fed,
    Table: table::Table,
    Hertz: hertz::Hertz,
    Transient: transient::Transient,
}

/// What scales an effect from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// Factor of its torque.
    pub gain: f64,
    /// A signal for those that take one.
    pub fed: f64,
    /// By how much it is turned, radians: it is at an angle as it would be that much before.
    pub shift: f64,
}

impl Default for Control {
    fn default() -> Self {
        Self { gain: 1.0, fed: 0.0, shift: 0.0 }
    }
}

/// An effect that runs, and what belongs to it.
#[derive(Debug, Clone)]
struct Slot {
    effect: Running,
    bound: Bound,
    control: Control,
    /// What it gave last, N m.
    torque: f64,
}

/// Effects that run.
#[derive(Debug, Clone)]
pub struct Program {
    slots: Box<[Slot]>,
    /// Effects whose torque was not a number, ever.
    masked: u64,
}

impl Program {
    /// Of the effects named.
    ///
    /// # Errors
    /// The number of the effect and its fault; `effects` if there are more than [`MOST_EFFECTS`].
    pub fn new(effects: Vec<Any>) -> Result<Self, (usize, Fault)> {
        check("effects", effects.len() as f64, Limit::Most(MOST_EFFECTS as f64))
            .map_err(|fault| (MOST_EFFECTS, fault))?;
        effects.iter().enumerate().try_for_each(|(k, e)| e.check().map_err(|fault| (k, fault)))?;
        let slot = |of: Any| {
            let bound = of.bound();
            Slot { effect: of.started(), bound, control: Control::default(), torque: 0.0 }
        };
        Ok(Self { slots: effects.into_iter().map(slot).collect(), masked: 0 })
    }

    /// What scales each effect, in their order.
    #[inline]
    pub fn controls(&mut self) -> impl Iterator<Item = &mut Control> {
        self.slots.iter_mut().map(|slot| &mut slot.control)
    }

    /// What scales an effect, by its place.
    pub fn control(&mut self, place: usize) -> Option<&mut Control> {
        self.slots.get_mut(place).map(|slot| &mut slot.control)
    }

    /// How stiff and how viscous all are together at most, at their gains: what the governor is asked for.
    #[inline(always)]
    pub fn demand(&self) -> Bound {
        let mut sum = Bound::default();
        for Slot { bound, control, .. } in &self.slots {
            let gain = control.gain.abs();
            sum.stiffness += gain * bound.stiffness;
            sum.damping += gain * bound.damping;
        }
        sum
    }

    /// One tick: the sum of all torques (N m), with the shares of stiffness and damping that the governor leaves. An effect whose torque is
    /// not a number adds nothing and is counted;
    /// with a reading that is none, nothing runs.
    #[inline(always)]
    pub fn tick(&mut self, reading: &Reading, stiffness: f64, damping: f64, events: &mut Events) -> f64 {
        events.clear();
        // No effect may remember what is not a number.
        if !(reading.angle.is_finite()
            && reading.velocity.is_finite()
            && reading.dt > 0.0
            && reading.dt < 1.0)
        {
            self.masked += 1;
            return 0.0;
        }
        let mut sum = 0.0;
        for (k, Slot { effect, control, torque, .. }) in self.slots.iter_mut().enumerate() {
            events.effect = k;
            let m = Modulation { gain: control.gain, fed: control.fed, stiffness, damping };
            let turned = Reading { angle: reading.angle - control.shift, ..*reading };
            *torque = effect.torque(&turned, &m, events);
            sum += *torque;
        }
        // A sum is a number only if all that it is made of are.
        if sum.is_finite() { sum } else { self.sum_of_numbers() }
    }

    /// What the sum of all torques (N m) would be were this the next reading, without what is no number; nothing of it is remembered.
    pub fn peek(&self, reading: &Reading, stiffness: f64, damping: f64) -> f64 {
        let mut events = Events::default();
        let torque = |Slot { effect, control, .. }: &Slot| {
            let m = Modulation { gain: control.gain, fed: control.fed, stiffness, damping };
            effect.peek(&Reading { angle: reading.angle - control.shift, ..*reading }, &m, &mut events)
        };
        self.slots.iter().map(torque).filter(|torque| torque.is_finite()).sum()
    }

    /// The sum of those that are numbers.
    #[cold]
    fn sum_of_numbers(&mut self) -> f64 {
        let numbers = self.slots.iter().map(|slot| slot.torque).filter(|torque| torque.is_finite());
        self.masked += (self.slots.len() - numbers.clone().count()) as u64;
        numbers.sum()
    }

    /// How often an effect's torque was not a number.
    pub fn masked(&self) -> u64 {
        self.masked
    }

    /// Potential energy of those effects that have one, at a gain of 1, joules.
    pub fn energy(&self, angle: f64) -> f64 {
        self.slots.iter().filter_map(|slot| slot.effect.energy(angle)).sum()
    }

    /// Potential energy as effects are scaled now, with the share of stiffness that the governor leaves, joules.
    pub fn potential(&self, angle: f64, stiffness: f64) -> f64 {
        let of = |Slot { effect, control, bound, .. }: &Slot| {
            // What has no stiffness is left as it is.
            let share = if bound.stiffness > 0.0 { stiffness } else { 1.0 };
            effect.energy(angle - control.shift).map(|energy| control.gain * share * energy)
        };
        self.slots.iter().filter_map(of).filter(|energy| energy.is_finite()).sum()
    }

    /// Everything as if it had not been read yet.
    pub fn reset(&mut self) {
        self.slots.iter_mut().for_each(|slot| slot.effect.reset());
    }
}
