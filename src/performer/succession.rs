//! From one scene to the next while patterns play.

use std::sync::Arc;

use super::clocked::speed;
use super::pickup::Pickups;
use super::run::Run;
use super::stopping::Sent;
use super::{OpenEvents, Performer};
use crate::graph::plan::Plan;
use crate::graph::scene::Scene;
use crate::patch::{Bind, Patch};
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
        let (began, runs): (Vec<_>, Vec<_>) = self.runs.drain(..).partition(|run| run.serial == 0);
        let counted = self.counted();
        let mut new = Self::bare(scene, patch, rig, files);
        std::mem::swap(self, &mut new);
        (self.played, self.started, self.fed, self.lead) = (new.played, new.started, fed, new.lead);
        self.clock = new.clock;
        self.turned_away = new.turned_away;
        self.troubles = std::mem::take(&mut new.troubles);
        self.endless = std::mem::take(&mut new.endless);
        self.asleep = std::mem::take(&mut new.asleep);
        self.owed = std::mem::take(&mut new.owed);
        self.stops = std::mem::take(&mut new.stops);
        (self.crossed, self.crossings) = (std::mem::take(&mut new.crossed), new.crossings);
        let become_of = |pattern: usize| {
            let name = &old.patterns.get(pattern)?.name;
            self.patch.patterns.iter().position(|p| p.name == *name)
        };
        let ahead = std::mem::take(&mut new.ahead).into_iter();
        let instrument = |number: u32| {
            let name = &new.plan.instruments.get(number as usize)?.name;
            self.plan.instruments.iter().position(|i| i.name == *name).map(|number| number as u32)
        };
        let sent = ahead.filter_map(|sent| {
            // One whose instrument is no more fades.
            let instrument = match sent.instrument {
                Some(number) => Some(instrument(number)?),
                None => None,
            };
            Some(Sent { pattern: become_of(sent.pattern)?, instrument, ..sent })
        });
        self.ahead = sent.collect();
        // What does not go on in the new plan sounds there from its beginning.
        self.asleep.retain(|name| {
            let of = |plan: &'_ Plan| plan.instruments.iter().find(|i| *i.name == **name).cloned();
            of(&new.plan).zip(of(&self.plan)).is_some_and(|(old, new)| old.goes_on_as(&new))
        });
        self.take_clock(&mut new, &old);
        self.hands = std::mem::take(&mut new.hands);
        self.take_hands(&new.plan);
        (self.song, self.sung) = (std::mem::take(&mut new.song), new.sung);
        self.take_faders(&old, std::mem::take(&mut new.pickups));
        // Controls that still exist keep their values.
        for (control, target) in self.patch.controls.iter().zip(&mut self.targets) {
            let before = old.controls.iter().position(|c| c.name == control.name);
            if let Some(value) = before.and_then(|number| new.targets.get(number)) {
                *target = value.clamp(control.range[0], control.range[1]);
            }
        }
        for (control, stream) in self.patch.controls.iter().zip(&mut self.streams) {
            let before = old.controls.iter().position(|c| c.name == control.name);
            if let (Some(stream), Some(Some(before))) =
                (stream, before.and_then(|number| new.streams.get(number)))
            {
                stream.go_on(before);
            }
        }
        (self.record, self.moves, self.listener) = (new.record.take(), new.moves.take(), new.listener.take());
        (self.length, self.cut) = (new.length, new.cut);
        self.stopped = new.stopped;
        // What is new there, was away, followed a clock until now or had come to its end stands where it would have come to.
        if !began.is_empty() || !self.roots.is_empty() {
            let mut run = self.beginning()?;
            let stopped = |p: &crate::patch::Pattern| self.stopped.contains(&p.name);
            let patterns = self.patch.patterns.iter().enumerate();
            patterns.filter(|(_, p)| stopped(p)).for_each(|(pattern, _)| run.stop(pattern));
            // Voices that it has begun sound on.
            for (root, end) in began.iter().flat_map(|run| run.roots.iter().zip(&run.ends)) {
                let name = old.patterns.get(root.pattern).map(|p| &p.name);
                let is = |new: &Root| self.patch.patterns.get(new.pattern).map(|p| &p.name) == name;
                if let Some(new) = run.roots.iter().position(is) {
                    run.sounds_until(new, *end);
                }
            }
            self.resume(run);
        }
        for Run { serial, draws, whence, cause, roots, follows, ends, .. } in runs {
            let Some(&root) = roots.first() else { continue };
            let name = old.patterns.get(root.pattern).map(|p| &p.name);
            let Some(pattern) = self.patch.patterns.iter().position(|p| Some(&p.name) == name) else {
                continue;
            };
            let mut root = Root { pattern, ..root };
            let new = self.patch.patterns.get(pattern).filter(|new| new.follows).map(speed);
            if let (Some((begin, beats)), None) = (follows, new) {
                if counted.contains(&serial) {
                    continue;
                }
                // A clock counted it, and does so no more.
                let beat = self.clocked.beats.beat(fed).unwrap_or(begin);
                root.at = (fed - (beat - begin) / beats).max(0.0);
            }
            let score = self.score(&[root], self.seed_of(draws))?;
            let mut run = Run::new(serial, vec![root], score).by(whence, cause).drawing(draws);
            ends.into_iter().for_each(|end| run.sounds_until(0, end));
            self.resume(match follows.zip(new) {
                Some(((beat, _), beats)) => run.following(beat, beats),
                None => run,
            });
        }
        self.join_clock()
    }

    /// Lets patterns that follow a clock since now join in where its song runs.
    fn join_clock(&mut self) -> Result<(), Problem> {
        let Some(beat) = self.clocked.beats.runs(self.fed).filter(|_| self.clocked.begin.is_none()) else {
            return Ok(());
        };
        let mut result = Ok(());
        for number in 0..self.clocked.patterns.len() {
            let (pattern, before) = self.clocked.patterns[number];
            let stopped = self.patch.patterns.get(pattern).is_none_or(|p| self.stopped.contains(&p.name));
            if before.is_none() && !stopped {
                result = result.and(self.start_one_clocked(number, beat, false));
            }
        }
        result
    }

    /// The serial numbers of the patterns that a clock has started.
    fn counted(&self) -> Vec<u64> {
        self.clocked.patterns.iter().filter_map(|(_, started)| Some(started.as_ref()?.serial)).collect()
    }

    /// A fader that has a control in hand, or waits for it, still does where a binding of the new patch is of both.
    fn take_faders(&mut self, old: &Patch, faders: Vec<Pickups>) {
        let mut of_old: Vec<_> = old.binds.iter().zip(faders).collect();
        for (bind, pickups) in self.patch.binds.iter().zip(&mut self.pickups) {
            let is = |(old, _): &(&Bind, _)| {
                (&old.from, &old.control, old.channel) == (&bind.from, &bind.control, bind.channel)
            };
            if let Some(known) = of_old.iter().position(is) {
                *pickups = of_old.swap_remove(known).1;
            }
        }
    }

    /// Voices that keys of the `old` plan hold are those of this one, and hear what theirs hear now; controllers are those of the new patch.
    fn take_hands(&mut self, old: &Plan) {
        let claims = self.patch.controllers();
        self.hands.iter_mut().for_each(|hands| hands.claim(&claims));
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

    /// The clock counts on, for the patterns that follow it now; one that did before was started as it was.
    fn take_clock(&mut self, from: &mut Self, old: &Patch) {
        if from.clocked.awaits {
            let follows = |p: &usize| self.patch.patterns.get(*p).is_some_and(|pattern| pattern.follows);
            let (clocked, own): (Vec<usize>, Vec<usize>) = self.roots.iter().partition(|p| follows(p));
            let name = |patch: &Patch, p: usize| patch.patterns.get(p).map(|p| p.name.clone());
            let started = |pattern: usize| {
                let known =
                    from.clocked.patterns.iter().find(|(p, _)| name(old, *p) == name(&self.patch, pattern));
                known.and_then(|(_, started)| *started)
            };
            let patterns = clocked.into_iter().map(|pattern| (pattern, started(pattern))).collect();
            self.roots = own;
            self.clocked = std::mem::take(&mut from.clocked);
            self.clocked.patterns = patterns;
        }
    }

    /// Takes a run up where feeding stands.
    fn resume(&mut self, run: Run) {
        let fed = match run.follows {
            Some((begin, beats)) => self.clocked.beats.beat(self.fed).map(|beat| (beat - begin) / beats),
            None => Some(self.fed),
        };
        self.runs.push(match fed {
            Some(fed) => run.from(fed),
            None => run,
        });
    }
}
