//! The servo.

use super::setup::{Setup, Unfit};
use crate::knob::effect::events::Events;
use crate::knob::effect::program::{Control, Program};
use crate::knob::effect::{Bound, Reading};
use crate::knob::governor::device::Device;
use crate::knob::governor::{Allowed, Governor};
use crate::knob::local_model::follower::{Followed, Follower};
use crate::knob::local_model::pending::Message;
use crate::knob::local_model::profile::{POINTS, Profile, SIDE};
use crate::knob::passivity::{Controller, Observer};
use crate::knob::plant::encoder::{Delay, MOST_DELAY};
use crate::knob::plant::wave::Wave;
use crate::knob::safety::chain::{Chain, Input};
use crate::knob::velocity::Estimator;
use crate::knob::velocity::choice::Any;

/// What a tick gave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Given {
    /// What the amplifier gets, N m.
    pub torque: f64,
    /// What the effects asked for, N m.
    pub asked: f64,
    /// The last angle read, radians.
    pub angle: f64,
    /// Speed as estimated, rad/s.
    pub velocity: f64,
    /// What the governor granted.
    pub allowed: Allowed,
    /// A bit for each [`Stage`](crate::knob::safety::chain::Stage) of the chain that acted.
    pub acted: u16,
}

/// Energy that went into the virtual world, and out of it.
#[derive(Debug, Clone, PartialEq)]
enum Books {
    Watched(Observer),
    Braked(Controller),
}

/// Ticks over which a new local model takes over, and after which one is too old, seconds.
const TAKE_OVER: f64 = 0.02;
const TOO_OLD: f64 = 0.25;

/// How far a knob may get until its next profile is there, at a speed: what it does without torque, and a half more; what its own torque adds,
/// and some counts.
#[derive(Debug, Clone, Copy)]
struct Reach {
    time: f64,
    beside: f64,
}

/// Counts that a profile reaches at least, and half a turn, which it never does.
const LEAST_REACH: f64 = 8.0;
const MOST_REACH: f64 = std::f64::consts::PI;

impl Reach {
    /// Of a knob of which what depends on the angle alone is worked out anew without waiting for the servo.
    fn of(device: &Device) -> Option<Self> {
        device.delay.local?;
        let time = device.delay.total() * device.period;
        let pushed = 0.5 * device.peak / device.inertia * time * time;
        Some(Self { time: 1.5 * time, beside: pushed + LEAST_REACH * device.count })
    }

    fn at(&self, velocity: f64) -> f64 {
        (self.time * velocity.abs() + self.beside).min(MOST_REACH)
    }
}

/// A servo at work. Nothing that ticks allocates, locks or panics.
#[derive(Debug, Clone)]
pub struct Servo {
    period: f64,
    estimator: Any,
    governor: Governor,
    /// What it was asked last, and what it granted.
    ask: Bound,
    allowed: Allowed,
    program: Program,
    books: Books,
    chain: Chain,
    /// Those of its motor, where it has any.
    cogging: Option<Wave>,
    ripple: Option<Wave>,
    follower: Follower,
    message: Option<Message>,
    impulse: f64,
    /// Torques given and not yet acting.
    way: Delay,
    acting: f64,
    last: Given,
    ticks: u64,
    events: Events,
    /// Where its torque is left to a quicker thread.
    reach: Option<Reach>,
}

impl Servo {
    /// Disarmed, at rest at an angle not yet known.
    ///
    /// # Errors
    /// What of the setup cannot be, and which effect it is of.
    pub fn new(setup: &Setup) -> Result<Self, Unfit> {
        let program = Program::new(setup.effects.clone())
            .map_err(|(effect, fault)| Unfit { effect: Some(effect), fault })?;
        let period = setup.period();
        let books = match &setup.passivity {
            Some(cap) => Books::Braked(Controller::new(cap, period, setup.late().min(MOST_DELAY))?),
            None => Books::Watched(Observer::default()),
        };
        let governor = Governor::new(&setup.device, setup.margin)?;
        let known = |wave: Wave| Some(wave).filter(|wave| !wave.is_flat());
        let ticks = |seconds: f64| (seconds / period).round().clamp(1.0, 1e9);
        Ok(Self {
            period,
            estimator: setup.device.velocity.started(setup.device.count, period)?,
            ask: Bound::default(),
            allowed: governor.allow(&Bound::default()),
            governor,
            program,
            books,
            chain: Chain::new(&setup.limits)?,
            cogging: known(setup.cogging),
            ripple: known(setup.ripple),
            follower: Follower::new(ticks(TAKE_OVER) as u32, ticks(TOO_OLD) as u64)?,
            message: None,
            impulse: 0.0,
            way: Delay::new(setup.late().min(MOST_DELAY), 0.0)?,
            acting: 0.0,
            last: Given::default(),
            ticks: 0,
            events: Events::default(),
            reach: Reach::of(&setup.device),
        })
    }

    /// What scales each effect, in their order.
    #[inline]
    pub fn controls(&mut self) -> impl Iterator<Item = &mut Control> {
        self.program.controls()
    }

    /// What scales an effect, by its place.
    pub fn control(&mut self, place: usize) -> Option<&mut Control> {
        self.program.control(place)
    }

    /// A world that a slow thread sends, from the next tick on.
    pub fn follow(&mut self, message: &Message) {
        self.message = Some(self.message.map_or(*message, |before| before.then(message)));
    }

    /// Goes on where another servo is: ticks are counted on, the knob is where it was, what acts acts, the winding is as warm, a fault that was
    /// latched stays so, and what is booked is added to. Where both tick alike, what a slow thread sent goes on as well.
    pub fn continue_from(&mut self, before: &Self) {
        self.chain.continue_from(&before.chain);
        if let Books::Watched(observer) = &mut self.books {
            *observer = *before.energy();
        }
        if self.period == before.period {
            self.follower.clone_from(&before.follower);
            (self.message, self.impulse) = (before.message, before.impulse);
        }
        self.ticks = before.ticks;
        self.acting = before.acting;
        self.last = before.last;
        self.estimator.reset(before.last.angle);
    }

    /// Lets torque rise from 0. `false` while a fault is latched.
    pub fn arm(&mut self) -> bool {
        self.chain.arm()
    }

    /// Torque is 0 from the next tick on.
    pub fn disarm(&mut self) {
        self.chain.disarm();
    }

    /// Latches torque at 0 until [`Servo::acknowledge`].
    pub fn panic(&mut self) {
        self.chain.panic();
    }

    /// Forgets a latched fault, and what effects remember; it stays disarmed.
    pub fn acknowledge(&mut self) {
        self.chain.acknowledge();
        self.program.reset();
    }

    /// The chain of safety: whether it is armed, what it latched, what it counted.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// What the device bears.
    pub fn governor(&self) -> &Governor {
        &self.governor
    }

    /// How stiff and how viscous effects and the local model are together at most, as they are scaled now.
    #[inline]
    pub fn demand(&self) -> Bound {
        let mut ask = self.program.demand();
        ask.stiffness += self.follower.model().most_stiffness();
        ask
    }

    /// Energy booked so far.
    pub fn energy(&self) -> &Observer {
        match &self.books {
            Books::Watched(observer) => observer,
            Books::Braked(controller) => controller.books(),
        }
    }

    /// Effects whose torque was not a number, ever.
    pub fn masked(&self) -> u64 {
        self.program.masked()
    }

    /// The world that a slow thread sent.
    pub fn follower(&self) -> &Follower {
        &self.follower
    }

    /// What happened in the last tick.
    pub fn events(&self) -> &Events {
        &self.events
    }

    /// What the last tick gave.
    pub fn last(&self) -> &Given {
        &self.last
    }

    /// What the last tick gave, and what it would have given near its angle: for a thread that reads the knob oftener than this ticks. The torque
    /// of all angles is the same where it is told not to be left to such a thread ([`Delay::local`](crate::knob::governor::device::Delay)),
    /// while none is given, and behind a low-pass.
    pub fn profile(&self) -> Profile {
        let Given { torque, angle, velocity, allowed, .. } = self.last;
        let (share, time) = (self.chain.passes(), self.ticks as f64 * self.period);
        let flat = Profile { centre: angle, time, ..Profile::flat(torque) };
        let Some(reach) = self.reach.filter(|_| share > 0.0 && angle.is_finite()) else { return flat };
        let most = self.chain.most();
        let at = |angle: f64| {
            let reading = Reading { angle, velocity, dt: self.period };
            let mut torque = self.program.peek(&reading, allowed.stiffness, allowed.damping);
            torque += self.follower.model().torque(angle) * allowed.stiffness;
            torque -= self.cogging.as_ref().map_or(0.0, |cogging| cogging.at(angle));
            torque /= self.ripple.as_ref().map_or(1.0, |ripple| f64::max(1.0 + ripple.at(angle), 0.5));
            torque.clamp(-most, most)
        };
        let mut profile = Profile { torque, reach: reach.at(velocity), ..flat };
        let here = at(angle);
        // What it gave may be more than it may give now, as the budget goes.
        let bound = f64::max(most, torque.abs());
        for k in (0..POINTS).filter(|k| *k != SIDE) {
            let there = torque + share * (at(angle + profile.away(k)) - here);
            profile.more[k] = there.clamp(-bound, bound) - torque;
        }
        let potential = self.program.potential(angle, allowed.stiffness);
        profile.energy = share * (potential + self.follower.model().energy(angle) * allowed.stiffness);
        let sound = profile.reach > 0.0 && profile.more.iter().all(|more| more.is_finite());
        if sound && profile.energy.is_finite() { profile } else { flat }
    }

    /// Ticks so far.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// One tick, `in_time` or late, with an angle (radians) or without one: the torque that the amplifier gets, N m. All else that came of it
    /// is in [`Servo::last`].
    ///
    /// Without a reading nothing is felt anew: the torque before stays until the chain lets it go. An angle that is no number is a fault, and
    /// torque is 0 with this tick.
    pub fn tick(&mut self, angle: Option<f64>, in_time: bool) -> f64 {
        self.ticks += 1;
        match angle {
            Some(angle) if angle.is_finite() => self.felt(angle, in_time),
            Some(wild) => self.wild(wild, in_time),
            None => self.blind(in_time),
        }
    }

    /// A tick with an angle that is no number.
    #[cold]
    fn wild(&mut self, angle: f64, in_time: bool) -> f64 {
        self.felt(angle, in_time)
    }

    #[inline(always)]
    fn felt(&mut self, angle: f64, in_time: bool) -> f64 {
        let velocity = self.estimator.push(angle);
        let velocity = if angle.is_finite() { velocity } else { f64::NAN };
        let followed = if self.message.is_some() {
            self.change(angle)
        } else if self.follower.is_idle() {
            Followed::NOTHING
        } else {
            self.follower.tick(self.ticks, angle, None)
        };
        let ask = self.demand();
        if ask != self.ask {
            (self.ask, self.allowed) = (ask, self.governor.allow(&ask));
        }
        let allowed = self.allowed;
        let reading = Reading { angle, velocity, dt: self.period };
        let mut torque = self.program.tick(&reading, allowed.stiffness, allowed.damping, &mut self.events);
        let kick = if self.impulse == 0.0 { 0.0 } else { std::mem::take(&mut self.impulse) / self.period };
        torque += followed.torque * allowed.stiffness + kick;
        torque = match &mut self.books {
            Books::Watched(observer) => {
                observer.book(followed.injected);
                observer.observe(angle, self.acting);
                torque
            }
            Books::Braked(controller) => {
                controller.observer().book(followed.injected);
                controller.tick(angle, velocity, self.acting, torque)
            }
        };
        let asked = torque;
        if let Some(cogging) = &self.cogging {
            torque -= cogging.at(angle);
        }
        if let Some(ripple) = &self.ripple {
            // No motor's constant falls below half of its mean; what a table says beyond that is not made up for.
            torque /= f64::max(1.0 + ripple.at(angle), 0.5);
        }
        let input = Input { torque, angle, velocity, fresh: true, in_time, governed: allowed.acted() };
        let given = self.chain.tick(&input);
        self.acting = self.way.pass(given.torque);
        self.last = Given { torque: given.torque, asked, angle, velocity, allowed, acted: given.acted };
        given.torque
    }

    /// Takes what a slow thread sent.
    #[cold]
    fn change(&mut self, angle: f64) -> Followed {
        let message = self.message.take();
        // A kick is as strong as it is short: it is given within one tick, as far as the chain lets it.
        self.impulse += message.map_or(0.0, |message| message.impulse);
        self.follower.tick(self.ticks, angle, message.as_ref().map(|message| &message.model))
    }

    /// A tick without a reading.
    #[cold]
    fn blind(&mut self, in_time: bool) -> f64 {
        self.events.clear();
        let Given { asked, angle, velocity, allowed, .. } = self.last;
        let input = Input { torque: asked, angle, velocity, fresh: false, in_time, governed: false };
        let given = self.chain.tick(&input);
        self.acting = self.way.pass(given.torque);
        self.last = Given { torque: given.torque, asked, angle, velocity, allowed, acted: given.acted };
        given.torque
    }
}
