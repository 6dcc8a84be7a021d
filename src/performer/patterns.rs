//! Patterns and songs that play: started, stopped, and fed to the outlet in order of time.

use super::run::Run;
use super::touch::RESERVED;
use super::{Happening, Outlet, Performer, Stand, When, in_time};
use crate::engine::event::{Event, Play, Source};
use crate::score::{Root, Timed, What};
use crate::text::Problem;
use crate::text::nearest::suggest;

/// Ids of a pattern that the program starts have its serial number from this bit on.
const OF_RUN: u32 = 40;

/// Room that a message of a song needs at most, lest one that could set more off than there ever is room for would wait for ever.
const MOST_NEEDED: usize = 1 << 12;

impl Performer {
    /// Starts a pattern. Gives a number to stop it by. What it draws differs from one start to the next.
    ///
    /// # Errors
    /// A pattern that the patch does not have, what is wrong with it, or a time that cannot be.
    pub fn start_pattern(&mut self, at: When, name: &str) -> Result<u64, Problem> {
        self.start_scaled(at, name, 1.0, 1.0)
    }

    /// The same, with a gain and a rate.
    pub(super) fn start_scaled(
        &mut self,
        at: When,
        name: &str,
        gain: f64,
        rate: f64,
    ) -> Result<u64, Problem> {
        in_time(at)?;
        let names = || self.patch.patterns.iter().map(|p| p.name.as_str());
        let Some(pattern) = names().position(|n| n == name) else {
            let what = format!("there is no pattern `{name}`");
            return Err(Problem::of_file(what).help(suggest(name, names())));
        };
        let serial = self.started + 1;
        let follows = self.follows(at, pattern);
        let root = Root { pattern, at: if follows.is_some() { 0.0 } else { at.seconds }, gain, rate };
        let score = self.score(&[root], self.seed_of(serial))?;
        self.started = serial;
        let run = Run::new(serial, vec![root], score);
        self.runs.push(match follows {
            Some((beat, beats)) => run.following(beat, beats),
            None => run,
        });
        Ok(serial)
    }

    /// Stops a pattern by the number under which it was started, or what plays from the beginning by 0: nothing more of it will be
    /// fed. What it has played sounds its time. Says whether it still played.
    pub fn stop_pattern(&mut self, serial: u64) -> bool {
        let before = self.runs.len();
        self.cut |= self.runs.iter().any(|run| run.serial == serial && run.is_cut());
        self.runs.retain(|run| run.serial != serial);
        self.runs.len() < before
    }

    /// Stops all patterns of this name, those that play from the beginning as well, as [`Performer::stop_pattern`] does.
    pub fn stop_named(&mut self, name: &str) {
        let Some(pattern) = self.patch.patterns.iter().position(|p| p.name == name) else { return };
        self.runs.iter_mut().for_each(|run| run.stop(pattern));
        let (cut, stopped) = (&mut self.cut, &mut self.stopped);
        self.runs.retain(|run| {
            let goes = run.serial > 0 && run.roots.iter().all(|root| root.pattern == pattern);
            *cut |= goes && run.is_cut();
            if run.serial == 0 && run.roots.iter().any(|root| root.pattern == pattern) {
                stopped.insert(name.into());
            }
            !goes
        });
    }

    /// Stops all patterns.
    pub fn stop_patterns(&mut self) {
        self.cut |= self.runs.iter().any(Run::is_cut);
        self.runs.clear();
    }

    /// The patterns that play: number, and name; those that play from the beginning have number 0.
    pub fn patterns(&self) -> impl Iterator<Item = (u64, &str)> {
        let name = |pattern: usize| self.patch.patterns.get(pattern).map_or("", |p| p.name.as_str());
        self.runs.iter().flat_map(move |run| run.playing().map(move |pattern| (run.serial, name(pattern))))
    }

    /// Gives the outlet all that patterns have before engine sample `until`, as long as it has room. Where it has not, the sample
    /// with which the first event takes effect that did not find any.
    pub fn feed(&mut self, until: u64, outlet: &mut dyn Outlet) -> Option<u64> {
        let until = until as f64 / self.plan.engine_rate();
        let song = self.feed_song(until, outlet);
        while let Some((number, at, longer)) = self.first_run(outlet) {
            if at >= until {
                break;
            }
            if outlet.room(Source::Pattern) == 0 {
                let full = self.when(at).instant.ceiling();
                return Some(song.map_or(full, |song| song.min(full)));
            }
            let run = &mut self.runs[number];
            let (serial, timed) = (run.serial, run.take());
            if let Some(mut timed) = timed {
                timed.at = at;
                if let What::Play(note) = &mut timed.what {
                    note.duration *= longer;
                }
                self.fed = self.fed.max(at);
                self.perform(serial, timed, outlet);
            }
        }
        self.fed = self.fed.max(until);
        song
    }

    /// The messages of a song before `until` seconds, and how keys have moved that may be told before then, as far as there is room; where
    /// there is not, the sample of the first without.
    fn feed_song(&mut self, until: f64, outlet: &mut dyn Outlet) -> Option<u64> {
        loop {
            let message = self.song.front().copied().filter(|(at, _)| *at < until);
            let earliest = outlet.clock() as f64 / self.plan.engine_rate();
            let told = self.next_move().map(|at| at.max(earliest)).filter(|at| *at < until);
            // A message may set several triggers off, and move every voice that a key holds.
            let held: usize = self.hands.iter().map(|hands| hands.held.len()).sum();
            let (triggers, binds) = (self.patch.triggers.len(), self.patch.binds.len());
            let room = outlet.room(Source::Program)
                > (RESERVED + 3 * (held + triggers) + triggers + binds).min(MOST_NEEDED);
            if let Some(at) = told.filter(|told| message.is_none_or(|(at, _)| *told <= at)) {
                let at = self.when(at);
                if !room {
                    return Some(at.instant.ceiling());
                }
                let before = self.next_move();
                (0..self.hands.len()).for_each(|port| self.tell_moves(at, port, outlet));
                if self.next_move() == before {
                    return Some(at.instant.ceiling());
                }
                continue;
            }
            let (at, message) = message?;
            let at = self.when(at);
            if !room {
                return Some(at.instant.ceiling());
            }
            self.song.pop_front();
            let played = match message {
                Some(message) => self.midi(at, 0, message, outlet),
                None => {
                    self.stop_clocked();
                    self.midi_gone(at, 0, outlet)
                }
            };
            if let Err(problem) = played {
                self.trouble.get_or_insert(problem);
            }
        }
    }

    /// Which pattern says something next, when, and how much longer than by its own count it lasts; of those at the same time, the one that was started first. Takes those away
    /// that have ended.
    fn first_run(&mut self, outlet: &dyn Outlet) -> Option<(usize, f64, f64)> {
        let mut first: Option<(usize, f64, f64)> = None;
        let mut number = 0;
        while number < self.runs.len() {
            let next = self.runs[number].next().unwrap_or_else(|problem| {
                self.trouble.get_or_insert(problem);
                None
            });
            match next {
                Some(own) => {
                    if let Some((at, longer)) = self.falls(self.runs[number].follows, own, outlet)
                        && first.is_none_or(|(_, earliest, _)| at < earliest)
                    {
                        first = Some((number, at, longer));
                    }
                    number += 1;
                }
                None => {
                    let run = self.runs.remove(number);
                    self.cut |= run.is_cut();
                }
            }
        }
        first
    }

    fn perform(&mut self, serial: u64, timed: Timed, outlet: &mut dyn Outlet) {
        let from = Stand { pattern: timed.pattern, event: timed.event, drawn: timed.drawn };
        let (id, at) = ((serial << OF_RUN) + timed.id, self.when(timed.at));
        match timed.what {
            What::Play(note) => {
                let Some(instrument) = self.instruments[note.voice] else { return };
                let (place, level, duration, own) = (note.place, note.level, note.duration, note.own);
                let play = Play { instrument, place, level, duration, own, id };
                if self.send(at, Source::Pattern, play, outlet) {
                    self.tell_play(at, Some(from), &play);
                }
            }
            What::Marker(name) => {
                let number = self.plan.markers.iter().position(|m| *m == name);
                let event = Event::Marker(number.map_or(u32::MAX, |i| i as u32));
                if outlet.send(at.instant, Source::Pattern, event) {
                    self.tell(at, Some(from), Some(id), Happening::Marker(&name));
                }
            }
        }
    }
}
