//! Patterns that are stopped, each at an instant: nothing of them begins with it or behind it, and what sounds of them is released. What was sent ahead
//! is called off in the engine.

use std::collections::HashMap;

use super::run::Run;
use super::whence::OF_RUN;
use super::{Outlet, Performer, When};
use crate::engine::event::{Event, is_of};
use crate::midi::Channel;

/// Bits of an id below those that no pattern has.
const ALL: u8 = 62;

/// A run that is to stop when it has been fed up to an instant, or one pattern of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stop {
    at: When,
    serial: u64,
    /// The pattern's name; `None` for the whole run.
    name: Option<String>,
}

/// What a pattern of the beginning has sent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sent {
    /// When it is over: a marker with its instant, a voice when it is released; seconds.
    pub end: f64,
    pub id: u64,
    /// When it begins, likewise.
    pub begin: f64,
    /// The instrument that plays it, by its place in the plan; none for a marker.
    pub instrument: Option<u32>,
    /// The pattern, by its place in the patch.
    pub pattern: usize,
}

impl Performer {
    /// Stops a pattern by the number under which it was started, or what plays from the beginning by 0: nothing more of it begins at that
    /// instant or later, and what it sounds is released. Says whether it still played.
    pub fn stop_pattern(&mut self, at: When, serial: u64, outlet: &mut dyn Outlet) -> bool {
        let played = self.plays(serial);
        self.stop_at(Stop { at, serial, name: None }, outlet);
        played
    }

    /// Stops all patterns of this name that play now, those that play from the beginning as well, as [`Performer::stop_pattern`] does.
    pub fn stop_named(&mut self, at: When, name: &str, outlet: &mut dyn Outlet) {
        let Some(pattern) = self.patch.patterns.iter().position(|p| p.name == name) else { return };
        let has = |run: &&Run| run.roots.iter().any(|root| root.pattern == pattern);
        let stop = |run: &Run| Stop { at, serial: run.serial, name: Some(name.into()) };
        let stops: Vec<Stop> = self.runs.iter().filter(has).map(stop).collect();
        self.stop_crossed(name);
        stops.into_iter().for_each(|stop| self.stop_at(stop, outlet));
    }

    /// Stops all patterns.
    pub fn stop_patterns(&mut self, at: When, outlet: &mut dyn Outlet) {
        self.cut |= self.runs.iter().any(Run::is_cut);
        self.runs.clear();
        self.crossed.clear();
        self.stops.clear();
        self.clocked.begin = None;
        self.remember_stopped(true);
        self.cancel(at, 0, ALL, outlet);
    }

    /// Stops what a port of MIDI has started, or one of its channels.
    pub(super) fn stop_of(&mut self, port: usize, channel: Option<Channel>) {
        let (cut, runs) = (&mut self.cut, &mut self.runs);
        runs.retain(|run| {
            let goes = run.whence.is_of(port, channel);
            *cut |= goes && run.is_cut();
            !goes
        });
    }

    /// Stops it now, or when all before that instant was fed.
    fn stop_at(&mut self, stop: Stop, outlet: &mut dyn Outlet) {
        if stop.at.seconds <= self.fed {
            return self.stop_now(stop, outlet);
        }
        let same = |known: &&mut Stop| known.serial == stop.serial && known.name == stop.name;
        match self.stops.iter_mut().find(same) {
            Some(known) if known.at.seconds <= stop.at.seconds => {}
            Some(known) => known.at = stop.at,
            None => self.stops.push(stop),
        }
    }

    /// When the next that is to stop does, in seconds.
    pub(super) fn next_stop(&self) -> Option<f64> {
        self.stops.iter().map(|stop| stop.at.seconds).min_by(f64::total_cmp)
    }

    /// Stops what is to stop by then.
    pub(super) fn stop_until(&mut self, seconds: f64, outlet: &mut dyn Outlet) {
        let (due, later) = std::mem::take(&mut self.stops).into_iter().partition(|s| s.at.seconds <= seconds);
        self.stops = later;
        let due: Vec<Stop> = due;
        due.into_iter().for_each(|stop| self.stop_now(stop, outlet));
    }

    fn stop_now(&mut self, Stop { at, serial, name }: Stop, outlet: &mut dyn Outlet) {
        let pattern = name.as_ref().and_then(|name| self.patch.patterns.iter().position(|p| p.name == *name));
        let Some(place) = self.runs.iter().position(|run| run.serial == serial) else { return };
        let run = &self.runs[place];
        let is_first = serial == 0 || run.follows.is_some();
        match (&name, pattern) {
            (None, _) => {
                if serial == 0 {
                    self.remember_stopped(false);
                }
            }
            // Another patch has it no more.
            (Some(_), None) => return,
            (Some(name), Some(_)) => {
                if is_first {
                    self.stopped.insert(name.clone());
                }
            }
        }
        let run = &mut self.runs[place];
        let others =
            pattern.filter(|pattern| serial == 0 || run.roots.iter().any(|root| root.pattern != *pattern));
        let Some(pattern) = others else {
            let id = run.whence.of_run(serial, 0);
            self.cut |= run.is_cut();
            self.runs.remove(place);
            return self.cancel(at, id, OF_RUN as u8, outlet);
        };
        run.stop(pattern);
        // Of those that have begun, no more sound than their instrument has voices; the latest, and as many again, whichever were taken from others.
        let voices = |number: u32| self.plan.instruments.get(number as usize).map_or(0, |i| 2 * i.voices);
        let mut begun: HashMap<u32, usize> = HashMap::new();
        let sounds = |sent: &&Sent| match sent.instrument.filter(|_| sent.begin < at.seconds) {
            None => true,
            Some(number) => {
                let count = begun.entry(number).or_default();
                *count += 1;
                *count <= voices(number)
            }
        };
        let sent = self.ahead.iter().rev().filter(|sent| sent.pattern == pattern && sent.end >= at.seconds);
        let ids: Vec<u64> = sent.filter(sounds).map(|sent| sent.id).collect();
        ids.into_iter().for_each(|id| self.cancel(at, id, 0, outlet));
    }

    /// Calls off what was sent of patterns whose ids agree with this one but for so many of the lowest bits, from `at` on, and releases what sounds.
    pub(super) fn cancel(&mut self, at: When, id: u64, bits: u8, outlet: &mut dyn Outlet) {
        if let Some(record) = &mut self.record {
            record.retain(|(start, play)| *start < at.seconds || !is_of(play.id, id, bits));
            for (start, play) in record.iter_mut().filter(|(_, play)| play.is_of(id, bits)) {
                play.duration = play.duration.min((at.seconds - *start).max(0.0));
            }
        }
        self.let_go(at, Event::Cancel(id, bits), outlet);
    }

    /// What plays from the beginning does not come back with another patch; with `clocked`, what follows a clock neither.
    fn remember_stopped(&mut self, clocked: bool) {
        let clocked = self.clocked.patterns.iter().filter(|_| clocked).map(|(pattern, _)| pattern);
        let names = self.roots.iter().chain(clocked).filter_map(|pattern| self.patch.patterns.get(*pattern));
        self.stopped.extend(names.map(|pattern| pattern.name.clone()));
    }
}
