//! How a new plan reaches the audio thread and the old one comes back.
//!
//! One engine is under way at a time: going in, fading out, or coming back.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ringbuf::HeapRb;
use ringbuf::traits::{Consumer, Producer, Split};
use ringbuf::{HeapCons, HeapProd};

use super::Engine;
use super::handover::{Handover, Mismatch, Passage, listens, prepare};
use crate::graph::plan::Plan;

/// Bytes of the past of delays that are copied ahead with each engine sample: at 8 kHz, about a sixtieth of the time of one that are not in the caches.
const AHEAD: usize = 1 << 12;

/// The control thread's end: sends new plans.
pub struct Director {
    plan: Plan,
    /// Channels of an input that the engine hears, from its beginning on.
    hears: usize,
    out: HeapProd<Box<Handover>>,
    back: HeapCons<Box<Handover>>,
    /// What is under way.
    passage: Option<Arc<Passage>>,
}

/// The audio thread's end: an engine that takes new plans when they come.
pub struct Stagehand {
    engine: Engine,
    new: HeapCons<Box<Handover>>,
    old: HeapProd<Box<Handover>>,
    coming: Option<Box<Handover>>,
    leaving: Option<Box<Handover>>,
}

/// An engine for `plan`, and the handle by which other plans follow.
///
/// # Errors
/// As [`Engine::new`].
pub fn exchange(plan: &Plan) -> Result<(Director, Stagehand), super::refusal::Refusal> {
    let engine = Engine::new(plan)?;
    let (out, new) = HeapRb::new(1).split();
    let (old, back) = HeapRb::new(1).split();
    let director = Director { plan: plan.clone(), hears: listens(plan), out, back, passage: None };
    Ok((director, Stagehand { engine, new, old, coming: None, leaving: None }))
}

impl Director {
    /// Lets `plan` follow the one that plays, as soon as it can. Says `false`, and does nothing, while another is still under way.
    ///
    /// # Errors
    /// A plan that cannot follow without a new beginning.
    pub fn send(&mut self, plan: &Plan) -> Result<bool, Mismatch> {
        let sent = self.offer(plan)?;
        if sent {
            self.admit();
        }
        Ok(sent)
    }

    /// Gets `plan` ready to follow the one that plays, which goes on until the other is [admitted](Self::admit). Says `false`, and does nothing, while
    /// another is still under way.
    ///
    /// # Errors
    /// A plan that cannot follow without a new beginning.
    pub fn offer(&mut self, plan: &Plan) -> Result<bool, Mismatch> {
        if self.collect() > 0 {
            return Ok(false);
        }
        let handover = Box::new(prepare(&self.plan, plan, self.hears)?);
        let passage = Arc::clone(&handover.passage);
        let sent = self.out.try_push(handover).is_ok();
        if sent {
            self.passage = Some(passage);
            self.plan = plan.clone();
        }
        Ok(sent)
    }

    /// Whether what was offered takes over at the beginning of a call once it is admitted: what is long of its past has been copied, a little in each call.
    pub fn is_ready(&self) -> bool {
        self.passage.as_ref().is_some_and(|passage| passage.ready.load(Ordering::Acquire))
    }

    /// Lets what was offered take over as soon as it is ready.
    pub fn admit(&mut self) {
        if let Some(passage) = &self.passage {
            passage.admitted.store(true, Ordering::Release);
        }
    }

    /// Frees the engine that came back; how many are still under way, 1 or none.
    pub fn collect(&mut self) -> usize {
        while let Some(old) = self.back.try_pop() {
            drop(old);
            self.passage = None;
        }
        usize::from(self.passage.is_some())
    }
}

impl Stagehand {
    /// The engine that plays.
    pub fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Takes a new plan if one has come and is ready, as [`Stagehand::process`] does by itself. Says whether a plan took over: events from here on
    /// are those of that plan.
    pub fn take_over(&mut self) -> bool {
        self.take_over_if(|passage| passage.ready.load(Ordering::Relaxed))
    }

    /// As [`Stagehand::take_over`], of one that was admitted, whether it is ready or not: what is missing of its past is copied at once, for which a
    /// device would not wait.
    pub fn take_over_now(&mut self) -> bool {
        self.take_over_if(|_| true)
    }

    fn take_over_if(&mut self, can: impl FnOnce(&Passage) -> bool) -> bool {
        if self.coming.is_none() {
            self.coming = self.new.try_pop();
        }
        let may = |new: &Handover| new.passage.admitted.load(Ordering::Acquire) && can(&new.passage);
        if self.leaving.is_some() || !self.coming.as_deref().is_some_and(may) {
            return false;
        }
        self.leaving = self.coming.take();
        if let Some(new) = &mut self.leaving {
            self.engine.adopt(new);
        }
        true
    }

    /// Takes a new plan if one has come, and computes as [`Engine::process_input`]. Neither allocates nor frees.
    pub fn process(&mut self, input: &[f32], output: &mut [f32]) {
        self.take_over();
        self.compute(input, output);
    }

    /// Computes on the plan that plays, and copies some of what one that is to follow will need.
    pub(crate) fn compute(&mut self, input: &[f32], output: &mut [f32]) {
        let frames = output.len() / self.engine.channels().max(1);
        if let Some(new) = &mut self.coming
            && self.engine.copy_ahead(new, frames, AHEAD)
        {
            new.passage.ready.store(true, Ordering::Release);
        }
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

#[cfg(test)]
mod tests {
    use super::{Mismatch, exchange};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;

    /// A patch that listens no more for a while may listen again as far as the first did: the engine has heard all along.
    #[test]
    fn what_was_listened_to_from_the_beginning_may_be_again() {
        let plan = |node: &str| {
            let text = format!(
                "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"o\"\nnodes.o = {{ {node} }}\n"
            );
            let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
            scene(&patch, &Rig::default_for(1), &Options::default(), &NoAssets)
                .unwrap_or_else(|p| panic!("{p}"))
                .plan
        };
        let listens = |channel: u32| plan(&format!("type = \"input\", channel = {channel}"));
        let (mut director, mut stagehand) = exchange(&listens(2)).unwrap();
        for next in [plan("type = \"sine\", frequency = 100"), listens(1), listens(2)] {
            assert!(matches!(director.send(&next), Ok(true)));
            for _ in 0..100 {
                stagehand.process(&[0.25; 2 * 480], &mut [0.0; 480]);
            }
        }
        assert!(matches!(director.send(&listens(3)), Err(Mismatch::Inputs)));
    }
}
