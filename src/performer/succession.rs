//! From one scene to the next while patterns play.

use std::sync::Arc;

use super::run::Run;
use super::{OpenEvents, Performer};
use crate::graph::plan::Plan;
use crate::graph::scene::Scene;
use crate::patch::Patch;
use crate::rig::Rig;
use crate::score::Root;
use crate::text::Problem;

impl Performer {
    /// Goes on with another scene: patterns that play go on where they stand if the new patch still has them, in the words of the
    /// new patch.
    ///
    /// # Errors
    /// What is wrong with its patterns; then the old ones are gone, and the new ones do not play.
    pub fn become_of(
        &mut self,
        scene: Scene,
        patch: Arc<Patch>,
        rig: Arc<Rig>,
        files: OpenEvents,
    ) -> Result<(), Problem> {
        let (old, fed) = (Arc::clone(&self.patch), self.fed);
        let runs: Vec<(u64, Option<Root>)> = self.runs.drain(..).map(|run| (run.serial, run.root)).collect();
        let began = runs.iter().any(|(serial, _)| *serial == 0);
        let roots: Vec<Root> = scene.patterns.iter().map(|&p| Root::at(p, 0.0)).collect();
        let mut new = Self::bare(scene, patch, rig, files);
        std::mem::swap(self, &mut new);
        (self.played, self.started, self.fed) = (new.played, new.started, fed);
        self.hands = std::mem::take(&mut new.hands);
        self.take_hands(&new.plan);
        self.song = std::mem::take(&mut new.song);
        // Controls that still exist keep their values.
        for (control, target) in self.patch.controls.iter().zip(&mut self.targets) {
            let before = old.controls.iter().position(|c| c.name == control.name);
            if let Some(value) = before.and_then(|number| new.targets.get(number)) {
                *target = value.clamp(control.range[0], control.range[1]);
            }
        }
        (self.record, self.moves, self.listener) = (new.record.take(), new.moves.take(), new.listener.take());
        (self.length, self.cut) = (new.length, new.cut);
        if began {
            let score = self.score(&roots, self.plan.seed)?;
            self.resume(Run::new(0, None, score))?;
        }
        for (serial, root) in runs {
            let Some(root) = root else { continue };
            let name = old.patterns.get(root.pattern).map(|p| &p.name);
            let Some(pattern) = self.patch.patterns.iter().position(|p| Some(&p.name) == name) else {
                continue;
            };
            let root = Root { pattern, ..root };
            let score = self.score(&[root], self.seed_of(serial))?;
            self.resume(Run::new(serial, Some(root), score))?;
        }
        Ok(())
    }

    /// Voices that keys of the `old` plan hold are those of this one, and hear what theirs hear now.
    fn take_hands(&mut self, old: &Plan) {
        let plan = &self.plan;
        let become_of = |number: u32| {
            let name = &old.instruments.get(number as usize)?.name;
            let new = plan.instruments.iter().position(|instrument| instrument.name == *name)?;
            Some((new as u32, self.hears.get(new).copied().unwrap_or_default()))
        };
        for voice in self.hands.iter_mut().flat_map(|hands| &mut hands.held) {
            let (instrument, hears) = become_of(voice.instrument).unwrap_or((u32::MAX, [false; 3]));
            voice.become_of(instrument, hears);
        }
    }

    /// Takes a run up where feeding stands.
    fn resume(&mut self, mut run: Run) -> Result<(), Problem> {
        while run.next()?.is_some_and(|at| at < self.fed) {
            run.take();
        }
        self.runs.push(run);
        Ok(())
    }
}
