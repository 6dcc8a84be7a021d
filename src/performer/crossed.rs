//! What signals and the knob set off in the engine, which no performer has played: voices are told of, patterns are started.

use std::sync::Arc;

use super::hands::Hit;
use super::run::Run;
use super::{Happening, Heard, Origin, Outlet, Performer, When, Whence};
use crate::engine::event::Play;
use crate::engine::watch::{Crossing, SetOff};
use crate::graph::answer::Started;
use crate::graph::plan::Plan;
use crate::patch::Pitch;
use crate::schedule::Instant;

/// Serial numbers of patterns that are started so have this set: they count for themselves, so that they are the same however a run is cut.
const SERIAL: u64 = 1 << 40;

/// A voice by its name, its fields with their defaults, and whether it has the frequency of its event.
type Voice = (Arc<str>, Vec<(String, f64)>, bool);

/// What a plan calls what its watches and its knob set off.
#[derive(Debug, Clone)]
pub struct Callings {
    /// By instrument.
    voices: Vec<Voice>,
    places: Vec<Arc<str>>,
    watches: Vec<Arc<str>>,
    patterns: Vec<Arc<str>>,
    rate: f64,
}

impl Callings {
    /// Those of a plan.
    pub fn of(plan: &Plan) -> Self {
        let (rate, patterns) = (plan.engine_rate(), plan.answering.clone());
        if plan.watching().next().is_none() {
            return Self { voices: vec![], places: vec![], watches: vec![], patterns, rate };
        }
        let voices = plan.instruments.iter().map(|instrument| {
            let fields = instrument
                .fields
                .iter()
                .map(|name| name.to_string())
                .zip(instrument.defaults.iter().copied());
            let pitched = !matches!(instrument.pitch, Pitch::Unsaid(_));
            (Arc::clone(&instrument.name), fields.collect(), pitched)
        });
        Self {
            voices: voices.collect(),
            places: plan.outputs.iter().map(|output| &output.name).chain(&plan.together).cloned().collect(),
            watches: plan.watching().cloned().collect(),
            patterns,
            rate,
        }
    }

    /// Whether patterns may be set off, which wait for whoever feeds the engine.
    pub fn has_patterns(&self) -> bool {
        !self.patterns.is_empty()
    }
}

/// A pattern that was set off and has not begun yet.
#[derive(Debug, Clone)]
pub(super) struct Crossed {
    at: When,
    /// What set it off, and how often that had done so before.
    by: (u32, u64),
    id: u64,
    watch: Arc<str>,
    name: Arc<str>,
    gain: f64,
    rate: f64,
}

impl Performer {
    /// Hears of what was set off in an engine whose plan calls things so. The listener is told of a voice, whose origin is what set it off,
    /// `node.breath rises 0.3`. A pattern waits for its time: says whether it is one.
    pub fn cross(&mut self, callings: &Callings, crossing: &Crossing) -> bool {
        match &crossing.what {
            SetOff::Voice(play) => self.tell_crossing(callings, crossing, play),
            SetOff::Pattern(started) => return self.await_crossed(callings, crossing, started),
        }
        false
    }

    fn tell_crossing(&mut self, callings: &Callings, crossing: &Crossing, play: &Play) {
        let Some(listener) = &mut self.listener else { return };
        let &Crossing { at, watch, number, .. } = crossing;
        let (Some((name, fields, pitched)), Some(pattern)) =
            (callings.voices.get(play.instrument as usize), callings.watches.get(watch as usize))
        else {
            return;
        };
        let what = Happening::Voice {
            name,
            place: &play.place.name(|row| callings.places.get(row).map(|name| &**name)),
            level: play.level,
            felt: play.felt,
            duration: play.duration,
            fields,
            own: &play.own,
            pitched: *pitched,
        };
        let seconds = at.since(Instant::default()) / callings.rate;
        let origin = Some(Origin { pattern, event: number, drawn: None });
        listener(&Heard { at: seconds, instant: at, origin, id: Some(play.id), what });
    }

    fn await_crossed(&mut self, callings: &Callings, crossing: &Crossing, started: &Started) -> bool {
        let name = callings.patterns.get(started.pattern as usize);
        let (Some(name), Some(watch)) = (name, callings.watches.get(crossing.watch as usize)) else {
            return false;
        };
        self.crossed.push(Crossed {
            at: When::of_instant(crossing.at, callings.rate),
            by: (crossing.watch, crossing.number),
            id: crossing.id(),
            watch: Arc::clone(watch),
            name: Arc::clone(name),
            gain: started.gain,
            rate: started.rate,
        });
        true
    }

    /// Those of this name that were set off and have not begun do not.
    pub(super) fn stop_crossed(&mut self, name: &str) {
        self.crossed.retain(|crossed| *crossed.name != *name);
    }

    /// Starts the patterns that were set off and begin before `until` seconds, in order of time.
    pub(super) fn begin_crossed(&mut self, until: f64, outlet: &mut dyn Outlet) {
        if self.crossed.is_empty() {
            return;
        }
        let (mut due, later): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.crossed).into_iter().partition(|crossed| crossed.at.seconds < until);
        self.crossed = later;
        due.sort_by_key(|crossed| (crossed.at.instant, crossed.by));
        for Crossed { at, by, id, watch, name, gain, rate } in due {
            // A patch that has taken over since may have it no more.
            if !self.patch.patterns.iter().any(|pattern| *pattern.name == *name) {
                continue;
            }
            let cause = std::mem::replace(&mut self.cause, id);
            let started = self.start_by(at, &name, (gain, rate), (Whence::CROSSED, Hit::default()), outlet);
            self.cause = cause;
            match started {
                Ok(()) => {
                    let Some(listener) = &mut self.listener else { continue };
                    let origin = Some(Origin { pattern: &watch, event: by.1, drawn: None });
                    let what = Happening::Start(&name);
                    listener(&Heard { at: at.seconds, instant: at.instant, origin, id: None, what });
                }
                Err(problem) => {
                    self.meet(problem);
                }
            }
        }
    }

    /// The serial number of the next pattern that somebody starts. There are fewer ids than runs: those that one has which still plays are left out.
    pub(super) fn next_serial(&self, whence: Whence) -> u64 {
        let first = if whence == Whence::CROSSED { SERIAL + self.crossings + 1 } else { self.started + 1 };
        let ids = |serial| whence.of_run(serial, 0);
        let has = |run: &Run, serial| run.whence == whence && ids(run.serial) == ids(serial);
        let is_free = |serial: &u64| !self.runs.iter().any(|run| has(run, *serial));
        (first..).find(is_free).unwrap_or(first)
    }

    /// The pattern of that serial number has been started.
    pub(super) fn count_started(&mut self, whence: Whence, serial: u64) {
        match whence == Whence::CROSSED {
            true => self.crossings = serial - SERIAL,
            false => self.started = serial,
        }
    }
}
