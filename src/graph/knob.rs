//! The knob of a patch on a rig: what its servo runs, what moves it, what it sets off.

use std::sync::Arc;

use super::answer::{Answer, Started, Voiced};
use super::build::{Want, Wanted};
use super::plan::Shared;
use super::start::{Binary, FIELDS, Fields, StartProgram, Step, Unary};
use crate::actuator::fault::Fault;
use crate::knob::angle::decoder::Sensor;
use crate::knob::effect::Bound;
use crate::knob::servo::setup::Setup;
use crate::knob::servo::simulated::Model;
use crate::knob::servo::tick::Servo;
use crate::patch::knob::{HAND, Scaled, VOICES};
use crate::patch::{Expr, Function, Happening, Operator, Patch, Source, Trigger, Voice};
use crate::rig::knob::made::Pace;
use crate::rig::{self, Finder, Rig};
use crate::space::spot::Spot;
use crate::text::Problem;

/// Engine samples by which signals of the patch reach the knob late: always as many, however a run is cut into calls. The knob itself is read
/// and felt at every tick.
pub const CELL: u64 = 4;

/// A knob.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// What the servo is made of, at its rate.
    pub setup: Setup,
    /// Ticks of the servo in an engine sample, 1 or more, and frames of the device in a tick.
    pub ticks: u32,
    /// See `ticks`.
    pub frames: u32,
    /// What is turned where none is there; `None`: one is.
    pub model: Option<Model>,
    /// What reads the one that is there.
    pub sensor: Option<Sensor>,
    /// Seconds that a card may take from the angle to its torque: more than that, and torque falls.
    pub allowance: f64,
    /// The control that turns it, by its place in [`super::plan::Plan::shared`].
    pub hand: Option<u32>,
    /// Whether torque flows from the beginning; else it waits to be asked.
    pub armed: bool,
    /// Names of the effects.
    pub names: Vec<Arc<str>>,
    /// What scales each effect.
    pub scales: Vec<Scales>,
    /// What it sets off.
    pub starts: Vec<Start>,
    /// The channel (from 0) on which voices play for it.
    pub channel: Option<u32>,
    /// The sample for 1 N m on that channel; `None`: no torque leaves, as that of a simulated knob that is turned live: what hangs there would be
    /// driven by what another knob feels.
    pub per_newton_metre: Option<f64>,
}

impl Knob {
    /// Its sensor is heard on the channels behind those of `input` nodes, from `least` on.
    pub(super) fn hear_behind(&mut self, shared: &[Shared], least: usize) {
        let nodes =
            shared.iter().map(|shared| if let Shared::Input(c) = shared { *c as usize + 1 } else { 0 });
        let first = nodes.max().unwrap_or(0).max(least);
        self.sensor.iter_mut().for_each(|sensor| sensor.channels = [first, first + 1]);
    }

    /// How stiff and how viscous all effects are together at most, those whose gain moves at a gain of 1.
    pub fn bound(&self) -> Bound {
        let mut sum = Bound::default();
        for (effect, scales) in self.setup.effects.iter().zip(&self.scales) {
            let gain = if let Feed::Constant(gain) = scales.gain { gain.abs() } else { 1.0 };
            let bound = effect.bound();
            sum.stiffness += gain * bound.stiffness;
            sum.damping += gain * bound.damping;
        }
        sum
    }
}

/// What scales an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Factor of its torque.
    pub gain: Feed,
    /// By how much it is turned, radians.
    pub shift: Feed,
    /// What a texture plays.
    pub signal: Feed,
}

/// Where a value comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feed {
    /// It never changes.
    Constant(f64),
    /// An engine-wide signal, by its place in [`super::plan::Plan::shared`].
    Signal(u32),
    /// What voices play on the knob's output.
    Voices,
}

/// A voice or a pattern that the knob sets off.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// What sets it off, as the patch has it: `knob.detent notches`.
    pub name: Arc<str>,
    /// What must happen.
    pub what: Happening,
    /// To which effect, by its place; `None`: any.
    pub effect: Option<u32>,
    /// What it sets off, where the trigger says nothing of it.
    pub answer: Answer,
    /// What the trigger says, to be worked out of what happened: that has the fields of [`Happening::names`].
    pub set: Vec<(Slot, StartProgram)>,
}

/// What a trigger says of what it plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// Its level, 0 to 100.
    Level,
    /// Decibels above the threshold.
    Felt,
    /// Seconds until its release, 0 to 1e6.
    Duration,
    /// One of its own fields, ±1e9.
    Own(u8),
    /// A pattern's gain, 0 to 100.
    Gain,
    /// How many times as fast a pattern plays, 0.001 to 1000.
    Rate,
}

impl Start {
    /// What `happened` sets off, by the values of [`Happening::names`].
    pub(crate) fn answer(&self, happened: &[f64]) -> Answer {
        let mut own = [0.0; FIELDS];
        own.iter_mut().zip(happened).for_each(|(to, from)| *to = *from);
        let fields = Fields { level: 0.0, duration: 0.0, own };
        let mut answer = self.answer;
        for (slot, program) in &self.set {
            let value = program.value(&fields);
            match &mut answer {
                Answer::Voice(voiced) => slot.of_voice(voiced, value),
                Answer::Pattern(started) => slot.of_pattern(started, value),
            }
        }
        answer
    }
}

impl Slot {
    fn of_voice(self, voiced: &mut Voiced, value: f64) {
        match self {
            Self::Level => (voiced.level, voiced.felt) = (value.clamp(0.0, 100.0), None),
            Self::Felt => (voiced.level, voiced.felt) = (1.0, Some(value)),
            Self::Duration => voiced.duration = value.clamp(0.0, 1e6),
            Self::Own(slot) => {
                if let Some(to) = voiced.own.get_mut(usize::from(slot)) {
                    *to = value.clamp(-1e9, 1e9);
                }
            }
            Self::Gain | Self::Rate => {}
        }
    }

    fn of_pattern(self, started: &mut Started, value: f64) {
        let Started { pattern, gain, rate } = *started;
        match self {
            Self::Gain => *started = Started::new(pattern, value, rate),
            Self::Rate => *started = Started::new(pattern, gain, value),
            Self::Level | Self::Felt | Self::Duration | Self::Own(_) => {}
        }
    }
}

/// What a knob is made from.
pub(super) struct Made<'a> {
    pub patch: &'a Patch,
    pub rig: &'a Rig,
    pub finder: &'a Finder,
    /// The instruments of voices.
    pub of_voice: &'a [Option<u32>],
    /// The engine's and the device's, Hz.
    pub rates: [f64; 2],
    pub is_live: bool,
    /// Whether a knob that a card reads is there, and frames of a block.
    pub attached: bool,
    /// See `attached`.
    pub block: u32,
}

/// The knob of a patch on a rig, if the patch has one.
/// `answering`: the names of the patterns that are set off so far.
pub(super) fn knob(
    from: &Made,
    wanted: &mut Wanted,
    answering: &mut Vec<Arc<str>>,
    problems: &mut Vec<Problem>,
) -> Option<Knob> {
    let &Made { patch, rig, finder, of_voice, rates, is_live, attached, block } = from;
    let felt = patch.knob.as_ref()?;
    let ratio = (rates[1] / rates[0]).round() as u32;
    let plain = rig::Knob::default();
    let of_rig = rig.knob.as_ref().unwrap_or(&plain);
    let ticks = ticks(of_rig.rate / rates[0], ratio);
    let rate = rates[0] * f64::from(ticks);
    let effects = felt.effects.iter().map(|effect| effect.figures.clone()).collect();
    let pace = Pace { rate, frames: ratio.max(1) / ticks, ticks, block };
    let setup = Setup { effects, ..of_rig.servo(&pace) };
    if let Err(why) = Servo::new(&setup) {
        let effect = why.effect.and_then(|effect| felt.effects.get(effect));
        let span = effect.map_or(&felt.span, |effect| &effect.span);
        let what = match effect {
            Some(effect) => format!("effect `{}` of the knob: {}", effect.name, why.fault),
            None => format!(
                "the knob of the rig, whose servo runs at {rate:.0} Hz: {}",
                named(&why.fault, of_rig)
            ),
        };
        problems.push(Problem::error(span, what));
        return None;
    }
    let scales = scales(patch, wanted);
    let sensor = of_rig.sensor.filter(|_| attached);
    let model = sensor.is_none().then(|| of_rig.model(&pace));
    let (way, is_simulated) = (rig.torque_output(of_rig), model.is_some());
    let hand = model.as_ref().and_then(|_| hand(patch, wanted));
    let voice = |name: &str| patch.voices.iter().position(|voice| voice.name == name);
    let mut starts = Vec::new();
    for trigger in patch.triggers.iter().filter(|t| matches!(t.on, Source::Knob { .. })) {
        let Some(number) = voice(&trigger.play) else {
            let started = patch.pattern_of(trigger).map(|name| answering_as(answering, name));
            starts.extend(started.and_then(|pattern| start(trigger, patch, Played::Pattern(pattern))));
            continue;
        };
        let (Some(voice), Some(instrument)) =
            (patch.voices.get(number), of_voice.get(number).copied().flatten())
        else {
            continue;
        };
        let (place, span) = match &trigger.place {
            Some(place) => (Some(place), &trigger.span),
            None => (voice.place.as_ref(), &voice.place_span),
        };
        match rig.resolve_by(finder, place, span) {
            Ok(place) => starts.extend(start(trigger, patch, Played::Voice(voice, instrument, place))),
            Err(problem) => problems.push(problem),
        }
    }
    Some(Knob {
        setup,
        ticks,
        frames: pace.frames,
        // What a real one feels waits until somebody asks.
        armed: is_simulated || !is_live,
        model,
        sensor,
        allowance: of_rig.allowance(block, rates[1]),
        hand,
        names: felt.effects.iter().map(|effect| effect.name.as_str().into()).collect(),
        scales,
        starts,
        channel: way.map(|(channel, _)| channel),
        per_newton_metre: way
            .filter(|_| !(is_live && is_simulated) && of_rig.controller.is_none())
            .map(|(_, per)| per),
    })
}

/// A figure of a servo as its rig calls it.
fn named(fault: &Fault, of_rig: &rig::Knob) -> Fault {
    let is_torque = fault.field == "low_pass" && of_rig.reconstruction == Some(fault.value);
    let field = match fault.field {
        "low_pass" if is_torque => "reconstruction",
        "low_pass" => "velocity_corner",
        "window" => "velocity_window",
        "winding" => "winding_time",
        "continuous" => "continuous_torque",
        "peak" => "peak_torque",
        field => field,
    };
    Fault { field, ..*fault }
}

/// Ticks of the servo in an engine sample: of the divisors of `ratio` the one nearest to what is wanted.
fn ticks(wanted: f64, ratio: u32) -> u32 {
    let off = |ticks: u32| (f64::from(ticks) / wanted).ln().abs();
    let divisors = (1..=ratio.max(1)).filter(|ticks| ratio.is_multiple_of(*ticks));
    divisors.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1)
}

/// What scales the effects of a patch's knob; asks for the signals it takes.
fn scales(patch: &Patch, wanted: &mut Wanted) -> Vec<Scales> {
    let Some(knob) = &patch.knob else { return Vec::new() };
    let mut feed = |scaled: &Scaled| match scaled {
        Scaled::Constant(x) => Feed::Constant(*x),
        Scaled::Node(name) if name == VOICES => Feed::Voices,
        Scaled::Node(name) => match patch.shared.iter().position(|node| node.name == *name) {
            Some(node) => Feed::Signal(wanted.number(Want::Node(node))),
            // A patch that was made in code and names no node.
            None => Feed::Constant(0.0),
        },
    };
    knob.effects
        .iter()
        .map(|e| Scales { gain: feed(&e.gain), shift: feed(&e.shift), signal: feed(&e.signal) })
        .collect()
}

/// The control that turns a simulated knob.
fn hand(patch: &Patch, wanted: &mut Wanted) -> Option<u32> {
    let control = patch.controls.iter().position(|control| control.name == HAND)?;
    Some(wanted.number(Want::Control(control)))
}

/// The place of a pattern among those that are set off.
pub(super) fn answering_as(answering: &mut Vec<Arc<str>>, name: &str) -> u32 {
    let place = answering.iter().position(|known| **known == *name).unwrap_or_else(|| {
        answering.push(name.into());
        answering.len() - 1
    });
    place as u32
}

/// What a trigger plays.
enum Played<'a> {
    /// A voice, its instrument, and where it sounds.
    Voice(&'a Voice, u32, Spot),
    /// A pattern, by its place among those that are set off.
    Pattern(u32),
}

impl Played<'_> {
    fn answer(&self) -> Answer {
        match *self {
            Self::Voice(voice, instrument, place) => {
                let mut own = [0.0; FIELDS];
                own.iter_mut().zip(&voice.fields).for_each(|(value, (_, default))| *value = *default);
                let (level, felt) = voice.strength(None, None);
                Answer::Voice(Voiced { instrument, place, level, felt, duration: voice.duration, own })
            }
            Self::Pattern(pattern) => Answer::Pattern(Started::new(pattern, 1.0, 1.0)),
        }
    }

    fn slot(&self, field: &str) -> Option<Slot> {
        match (self, field) {
            (Self::Pattern(_), "gain") => Some(Slot::Gain),
            (Self::Pattern(_), "rate") => Some(Slot::Rate),
            (Self::Pattern(_), _) => None,
            (Self::Voice(..), "level") => Some(Slot::Level),
            (Self::Voice(..), "felt") => Some(Slot::Felt),
            (Self::Voice(..), "duration") => Some(Slot::Duration),
            (Self::Voice(voice, ..), own) => {
                let place = voice.fields.iter().position(|(name, _)| name == own);
                place.map(|slot| Slot::Own(slot as u8))
            }
        }
    }
}

/// What a trigger sets off, if a knob sets that off.
fn start(trigger: &Trigger, patch: &Patch, played: Played) -> Option<Start> {
    let Source::Knob { what, effect } = &trigger.on else { return None };
    let effects = patch.knob.iter().flat_map(|knob| &knob.effects);
    let effect = match effect {
        Some(name) => Some(effects.into_iter().position(|e| e.name == *name)? as u32),
        None => None,
    };
    let program = |expr: &Expr| {
        let mut steps = Vec::new();
        push(expr, what.names(), &mut steps);
        StartProgram::new(steps).ok()
    };
    let set = trigger
        .set
        .iter()
        .filter_map(|(field, expr, _)| Some((played.slot(field)?, program(expr)?)))
        .collect();
    let name = trigger.on.by_itself()?;
    Some(Start { name: name.into(), what: *what, effect, answer: played.answer(), set })
}

/// An expression of named values as steps, the values in their order.
fn push(expr: &Expr, names: &[&str], steps: &mut Vec<Step>) {
    match expr {
        Expr::Number(x) => steps.push(Step::Number(*x)),
        Expr::Name(name, _) => match names.iter().position(|n| n == name) {
            Some(place) => steps.push(Step::Own(place as u8)),
            None => steps.push(Step::Number(0.0)),
        },
        Expr::Event(..) | Expr::Touch(..) | Expr::Knob(..) => steps.push(Step::Number(0.0)),
        Expr::Negate(a) => {
            push(a, names, steps);
            steps.push(Step::Unary(Unary::Negate));
        }
        Expr::Binary(operator, a, b) => {
            push(a, names, steps);
            push(b, names, steps);
            steps.push(Step::Binary(match operator {
                Operator::Add => Binary::Add,
                Operator::Subtract => Binary::Subtract,
                Operator::Multiply => Binary::Multiply,
                Operator::Divide => Binary::Divide,
            }));
        }
        Expr::Call(function, arguments) => {
            let after = match function {
                Function::Abs => Step::Unary(Unary::Abs),
                Function::Sqrt => Step::Unary(Unary::Sqrt),
                Function::Exp => Step::Unary(Unary::Exp),
                Function::Log => Step::Unary(Unary::Log),
                Function::Sin => Step::Unary(Unary::Sin),
                Function::Floor => Step::Unary(Unary::Floor),
                Function::Min => Step::Binary(Binary::Min),
                Function::Max | Function::Clamp => Step::Binary(Binary::Max),
                Function::Pow => Step::Binary(Binary::Power),
            };
            for (place, argument) in arguments.iter().enumerate() {
                push(argument, names, steps);
                match (function, place) {
                    (Function::Clamp, 2) => steps.push(Step::Binary(Binary::Min)),
                    (_, last) if last + 1 == function.arity().min(2) => steps.push(after),
                    _ => {}
                }
            }
        }
    }
}
