//! Patterns and songs that play: started, stopped, and fed to the outlet in order of time.

use super::bindings::Mind;
use super::clocked::NEAR;
use super::hands::SONG;
use super::run::{Next, Run};
use super::stopping::Sent;
use super::touch::RESERVED;
use super::whence::Whence;
use super::{Happening, Outlet, Performer, Stand, When, in_time};
use crate::engine::event::{Event, Play, Source};
use crate::score::{Root, Timed, What};
use crate::text::Problem;
use crate::text::nearest::suggest;

/// Patterns that play at a time, however they were started; those of the beginning count as one.
pub const MOST_RUNS: usize = 256;

/// Events that [`Performer::feed_some`] gives or leaves out, and messages of a song that it plays: about a millisecond's work.
const AT_ONCE: usize = 512;

/// Steps that patterns may take for every one of them, whatever they lead to; each its share, and at least so many.
const STEPS: usize = 8;
const LEAST_STEPS: usize = 16;

/// What patterns of the beginning have sent and is remembered until it is over, so that it can be stopped.
const MOST_KEPT: usize = 1 << 13;

/// Room that a message of a song needs at most, lest one that could set more off than there ever is room for would wait for ever.
const MOST_NEEDED: usize = 1 << 12;

/// Set in the numbers of messages of a song: no signal of a session has it, as those count from 1, and no voice.
const OF_SONG: u64 = 3 << 62;

impl Performer {
    /// What is started from now on is started because of a signal of that number; 0 for none.
    pub fn because(&mut self, cause: u64) {
        self.cause = cause;
    }

    /// Starts a pattern. Gives a number to stop it by. What it draws differs from one start to the next.
    ///
    /// # Errors
    /// A pattern that the patch does not have, what is wrong with it, a time that cannot be, or [`MOST_RUNS`] patterns that play already.
    pub fn start_pattern(&mut self, at: When, name: &str) -> Result<u64, Problem> {
        self.start_scaled(at, name, 1.0, 1.0, Whence::HERE)
    }

    /// The same, with a gain and a rate, for somebody.
    pub(super) fn start_scaled(
        &mut self,
        at: When,
        name: &str,
        gain: f64,
        rate: f64,
        whence: Whence,
    ) -> Result<u64, Problem> {
        in_time(at)?;
        let names = || self.patch.patterns.iter().map(|p| p.name.as_str());
        let Some(pattern) = names().position(|n| n == name) else {
            let what = format!("there is no pattern `{name}`");
            return Err(Problem::of_file(what).help(suggest(name, names())));
        };
        if self.runs.iter().filter(|run| !run.is_over()).count() >= MOST_RUNS {
            self.turned_away += 1;
            let what = format!("pattern `{name}` does not play: {MOST_RUNS} patterns play already");
            return Err(Problem::of_file(what).help("stop some, or start fewer".to_string()));
        }
        let follows = self.follows(at, pattern);
        let root = Root { pattern, at: if follows.is_some() { 0.0 } else { at.seconds }, gain, rate };
        let serial = self.next_serial(whence);
        let score = self.score(&[root], self.seed_of(serial))?;
        self.count_started(whence, serial);
        let run = Run::new(serial, vec![root], score).by(whence, self.cause);
        // Of those that only sound, the oldest is forgotten, and sounds its time.
        if self.runs.len() >= 2 * MOST_RUNS
            && let Some(oldest) = self.runs.iter().position(Run::is_over)
        {
            self.runs.remove(oldest);
        }
        self.runs.push(match follows {
            Some((beat, beats)) => run.following(beat, beats),
            None => run,
        });
        Ok(serial)
    }

    /// How many patterns did not play since too many did, since this was asked last.
    pub fn take_turned_away(&mut self) -> u64 {
        std::mem::take(&mut self.turned_away)
    }

    /// Whether a pattern plays that has this number.
    pub fn plays(&self, serial: u64) -> bool {
        self.runs.iter().any(|run| run.serial == serial)
    }

    /// Whether a pattern goes on until it is stopped.
    pub(super) fn is_endless(&self, name: &str) -> bool {
        let pattern = self.patch.patterns.iter().find(|pattern| pattern.name == name);
        pattern.and_then(|pattern| pattern.repeat).is_some_and(|repeat| repeat.times.is_none())
    }

    /// The patterns that play, until the last of their voices is released: number, and name; those that play from the beginning have number 0.
    pub fn patterns(&self) -> impl Iterator<Item = (u64, &str)> {
        let name = |pattern: usize| self.patch.patterns.get(pattern).map_or("", |p| p.name.as_str());
        self.runs
            .iter()
            .flat_map(move |run| run.playing(self.clock).map(move |pattern| (run.serial, name(pattern))))
    }

    /// Gives the outlet all that patterns have before engine sample `until`, as long as it has room. Where it has not, the sample
    /// with which the first event takes effect that did not find any.
    pub fn feed(&mut self, until: u64, outlet: &mut dyn Outlet) -> Option<u64> {
        // No machine would live to see the end of that.
        self.feed_up_to(until, outlet, usize::MAX).1
    }

    /// The same, but no more than what takes about a millisecond. Says whether that was all, as far as there was room; what has gone by
    /// until it goes on is given late, or left out where a pattern had yet to come to where it begins.
    pub fn feed_some(&mut self, until: u64, outlet: &mut dyn Outlet) -> bool {
        self.feed_up_to(until, outlet, AT_ONCE).0
    }

    /// The same for so many events. Says whether that was all, and the sample of the first for which there was no room.
    fn feed_up_to(&mut self, until: u64, outlet: &mut dyn Outlet, most: usize) -> (bool, Option<u64>) {
        self.pay(When::of_sample(outlet.clock(), self.plan.engine_rate()), outlet);
        let until = until as f64 / self.plan.engine_rate();
        // What the tempo of a song counts is sent up to its end before that is.
        if let Some(end) = self.song.back().map(|(end, _)| *end).filter(|end| (self.fed..until).contains(end))
        {
            let (done, full) = self.feed_before(end, outlet, most);
            if !done || full.is_some() {
                return (done, full);
            }
        }
        self.feed_before(until, outlet, most)
    }

    /// The same for what is before `until` seconds.
    fn feed_before(&mut self, until: f64, outlet: &mut dyn Outlet, most: usize) -> (bool, Option<u64>) {
        let mut work = most;
        let song = self.feed_song(until, outlet, &mut work);
        let song_is_done = work > 0;
        self.begin_clocked();
        self.begin_crossed(until, outlet);
        let with_song =
            |(done, full): (bool, Option<u64>)| (song_is_done && done, song.into_iter().chain(full).min());
        while let Some(at) = self.next_stop().filter(|at| *at < until) {
            let (done, full) = self.feed_patterns(at, outlet, most);
            // One whose time has come waits no longer, whatever else could not be sent.
            if (!done || full.is_some()) && at > outlet.clock() as f64 / self.plan.engine_rate() {
                return with_song((done, full));
            }
            self.stop_until(at, outlet);
        }
        with_song(self.feed_patterns(until, outlet, most))
    }

    /// The same for what patterns have before `until` seconds, in which none is stopped.
    fn feed_patterns(&mut self, until: f64, outlet: &mut dyn Outlet, most: usize) -> (bool, Option<u64>) {
        let earliest = outlet.clock() as f64 / self.plan.engine_rate();
        self.clock = earliest;
        // What has much to leave out must not keep the others waiting.
        let (mut work, mut left_out) = (most, most);
        let each = (most.saturating_mul(STEPS) / self.runs.len().max(1)).max(LEAST_STEPS);
        self.runs.iter_mut().for_each(|run| run.may_take(each));
        while let Some((number, at, longer)) = self.first_run(outlet, &mut left_out) {
            if at >= until {
                break;
            }
            if outlet.room(Source::Pattern) == 0 {
                return (true, Some(self.when(at).instant.ceiling()));
            }
            if work == 0 {
                return (false, None);
            }
            work -= 1;
            let run = &mut self.runs[number];
            let (serial, whence, cause, timed) = (run.serial, run.whence, run.cause, run.take());
            if let Some(mut timed) = timed {
                timed.at = at;
                if let What::Play(note) = &mut timed.what {
                    note.duration *= longer;
                }
                self.fed = self.fed.max(at);
                let end = match &timed.what {
                    What::Play(note) => at + note.duration,
                    What::Marker(_) => at,
                };
                run.sounds_until(timed.root, end);
                if serial == 0 {
                    self.keep_ahead(&timed, end, earliest);
                }
                outlet.because(cause);
                self.perform(whence.of_run(serial, timed.id), timed, outlet);
                outlet.because(0);
            }
        }
        self.fed = self.fed.max(until);
        (!self.runs.iter().any(Run::is_behind), None)
    }

    /// The messages of a song before `until` seconds, and how keys have moved that may be told before then, as far as there is room; where
    /// there is not, the sample of the first without.
    fn feed_song(&mut self, until: f64, outlet: &mut dyn Outlet, work: &mut usize) -> Option<u64> {
        while *work > 0 {
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
                *work -= 1;
                continue;
            }
            let (at, message) = message?;
            let at = self.when(at);
            if !room {
                return Some(at.instant.ceiling());
            }
            self.song.pop_front();
            *work -= 1;
            let played = match message {
                Some(message) => {
                    self.sung += 1;
                    let number = OF_SONG | self.sung;
                    self.tell(at, None, Some(number), Happening::Message(message));
                    self.because(number);
                    outlet.because(number);
                    self.mind = Mind::Song;
                    let played = self.midi_of(at, SONG, message, outlet);
                    self.mind = Mind::Hand;
                    played
                }
                None => {
                    self.end_song();
                    self.gone(at, SONG, outlet)
                }
            };
            if let Err(problem) = played {
                self.meet(problem);
            }
            self.because(0);
            outlet.because(0);
        }
        None
    }

    /// Which pattern says something next, when, and how much longer than by its own count it lasts; of those at the same time, the one
    /// that was started first. Takes those away that have ended. There are no more than twice [`MOST_RUNS`], so they are searched.
    fn first_run(&mut self, outlet: &dyn Outlet, left_out: &mut usize) -> Option<(usize, f64, f64)> {
        let earliest = outlet.clock() as f64 / self.plan.engine_rate();
        let mut first: Option<(usize, f64, f64)> = None;
        let mut number = 0;
        while number < self.runs.len() {
            if self.runs[number].is_behind() {
                let now = self.now_of(&self.runs[number], earliest);
                self.runs[number].leave_out(now);
            }
            let next = loop {
                match self.runs[number].next(left_out) {
                    Ok(next) => break next,
                    // Each takes one of its patterns away.
                    Err(problem) => self.meet(problem),
                }
            };
            match next {
                Next::Later => number += 1,
                Next::At(own) => {
                    if let Some((at, longer)) = self.falls(self.runs[number].follows, own, earliest)
                        && first.is_none_or(|(_, earliest, _)| at < earliest)
                    {
                        first = Some((number, at, longer));
                    }
                    number += 1;
                }
                Next::Over => {
                    self.cut |= self.runs[number].is_cut();
                    if self.runs[number].sounds(earliest) {
                        number += 1;
                    } else {
                        self.runs.remove(number);
                    }
                }
            }
        }
        first
    }

    /// Where a run stands at `seconds`, by its own count.
    fn now_of(&self, run: &Run, seconds: f64) -> f64 {
        match run.follows {
            // Where the song stands, so does the run.
            Some((begin, beats)) => {
                let beat = self.clocked.beats.beat(seconds);
                beat.map_or(f64::NEG_INFINITY, |beat| (beat - begin - NEAR) / beats)
            }
            None => seconds,
        }
    }

    /// Notes what a pattern of the beginning sends and when it is over, so that it can be called off by its id: all of them share one run.
    fn keep_ahead(&mut self, timed: &Timed, end: f64, now: f64) {
        if self.ahead.len() >= MOST_KEPT {
            self.ahead.retain(|sent| sent.end >= now);
            let more = self.ahead.len().saturating_sub(MOST_KEPT / 2);
            self.ahead.drain(..more);
        }
        let Some(run) = self.runs.iter().find(|run| run.serial == 0) else { return };
        if let Some(root) = run.roots.get(timed.root) {
            let id = run.whence.of_run(0, timed.id);
            let instrument = match &timed.what {
                What::Play(note) => self.instruments.get(note.voice).copied().flatten(),
                What::Marker(_) => None,
            };
            let begin = timed.at;
            self.ahead.push_back(Sent { end, id, begin, instrument, pattern: root.pattern });
        }
    }

    fn perform(&mut self, id: u64, timed: Timed, outlet: &mut dyn Outlet) {
        let from = Stand { pattern: timed.pattern, event: timed.event, drawn: timed.drawn };
        let at = self.when(timed.at);
        match timed.what {
            What::Play(note) => {
                let Some(instrument) = self.instruments[note.voice] else { return };
                let (place, level, felt) = (note.place, note.level, note.felt);
                let play =
                    Play { instrument, place, level, felt, duration: note.duration, own: note.own, id };
                if self.send(at, Source::Pattern, play, outlet) {
                    self.tell_play(at, Some(from), &play);
                }
            }
            What::Marker(name) => {
                let number = self.plan.markers.iter().position(|m| *m == name);
                let event = Event::Marker(number.map_or(u32::MAX, |i| i as u32), id);
                if outlet.send(at.instant, Source::Pattern, event) {
                    self.tell(at, Some(from), Some(id), Happening::Marker(&name));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
