//! How a new plan reaches the audio thread and the old one comes back.
//!
//! Both ways are rings for [`IN_FLIGHT`] engines, and no more than that are ever under way, so neither can be full.

use ringbuf::HeapRb;
use ringbuf::traits::{Consumer, Producer, Split};
use ringbuf::{HeapCons, HeapProd};

use super::Engine;
use super::handover::{Handover, Mismatch, prepare};
use crate::graph::plan::Plan;

/// Engines that may be under way at once: going in, fading out, or coming back.
pub const IN_FLIGHT: usize = 2;

/// The control thread's end: sends new plans.
pub struct Director {
    plan: Plan,
    out: HeapProd<Box<Handover>>,
    back: HeapCons<Box<Handover>>,
    under_way: usize,
}

/// The audio thread's end: an engine that takes new plans when they come.
pub struct Stagehand {
    engine: Engine,
    new: HeapCons<Box<Handover>>,
    old: HeapProd<Box<Handover>>,
    leaving: Option<Box<Handover>>,
}

/// An engine for `plan`, and the handle by which other plans follow.
///
/// # Errors
/// As [`Engine::new`].
pub fn exchange(plan: &Plan) -> Result<(Director, Stagehand), super::refusal::Refusal> {
    let engine = Engine::new(plan)?;
    let (out, new) = HeapRb::new(IN_FLIGHT).split();
    let (old, back) = HeapRb::new(IN_FLIGHT).split();
    let director = Director { plan: plan.clone(), out, back, under_way: 0 };
    Ok((director, Stagehand { engine, new, old, leaving: None }))
}

impl Director {
    /// Lets `plan` follow the one that plays. Says `false`, and does nothing, while two are still under way.
    ///
    /// # Errors
    /// A plan that cannot follow without a new beginning.
    pub fn send(&mut self, plan: &Plan) -> Result<bool, Mismatch> {
        self.collect();
        if self.under_way >= IN_FLIGHT {
            return Ok(false);
        }
        let handover = Box::new(prepare(&self.plan, plan)?);
        let sent = self.out.try_push(handover).is_ok();
        if sent {
            self.under_way += 1;
            self.plan = plan.clone();
        }
        Ok(sent)
    }

    /// Frees the engines that came back; how many are still under way.
    pub fn collect(&mut self) -> usize {
        while let Some(old) = self.back.try_pop() {
            drop(old);
            self.under_way -= 1;
        }
        self.under_way
    }
}

impl Stagehand {
    /// The engine that plays.
    pub fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Takes a new plan if one has come and the one before has died away, as [`Stagehand::process`] does by itself. Says whether a
    /// plan took over: events from here on are those of that plan.
    pub fn take_over(&mut self) -> bool {
        if self.leaving.is_none()
            && let Some(mut new) = self.new.try_pop()
        {
            self.engine.adopt(&mut new);
            self.leaving = Some(new);
            return true;
        }
        false
    }

    /// Takes a new plan if one has come, and computes as [`Engine::process_input`]. Neither allocates nor frees.
    pub fn process(&mut self, input: &[f32], output: &mut [f32]) {
        self.take_over();
        self.compute(input, output);
    }

    /// Computes on the plan that plays.
    pub(crate) fn compute(&mut self, input: &[f32], output: &mut [f32]) {
        match &mut self.leaving {
            Some(old) => self.engine.process_with(input, output, Some(&mut old.engine)),
            None => self.engine.process_with(input, output, None),
        }
        let succeeds = self.engine.is_succeeding();
        if self.leaving.as_ref().is_some_and(|old| !succeeds && old.engine.is_gone())
            && let Some(old) = self.leaving.take()
            && let Err(old) = self.old.try_push(old)
        {
            self.leaving = Some(old);
        }
    }
}
