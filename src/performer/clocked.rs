//! Patterns whose beats a clock counts: a MIDI clock as it comes, or the tempo of a song.
//!
//! The score says when something happens by a pattern's own tempo. What follows a clock is placed in time when it is fed, with the tempo
//! known then, and lasts as long as that tempo says; what has been fed is not moved any more.

use super::beats::Beats;
use super::run::Run;
use super::whence::{OF_RUN, Whence};
use super::{Outlet, Performer, When};
use crate::midi::Message;
use crate::patch::Pattern;
use crate::score::Root;
use crate::text::Problem;

/// Patterns that a clock starts and stops.
#[derive(Debug, Default)]
pub(super) struct Clocked {
    /// Whether what follows a clock waits for one.
    pub awaits: bool,
    /// By their place in the patch, with how each was started last.
    pub patterns: Vec<(usize, Option<Started>)>,
    pub beats: Beats,
    /// Where the song begins that was started and whose patterns have yet to begin, and whether what they draw is drawn anew.
    pub begin: Option<(f64, bool)>,
    /// The port whose clock counts, by its hands.
    port: Option<usize>,
    /// Where the song stands, in beats.
    stands: f64,
}

/// How a pattern was started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Started {
    /// The serial number of its run: another each time, as what it plays is called off by that.
    pub serial: u64,
    /// That of the run with which what it draws was drawn anew.
    pub draws: u64,
}

/// Beats by which a place may be missed and still count as reached.
pub(super) const NEAR: f64 = 1e-6;

/// A pattern's own beats a second.
pub(super) fn speed(pattern: &Pattern) -> f64 {
    1.0 / pattern.time.seconds()
}

impl Performer {
    /// Patterns that follow a clock wait for it from now on: they do not play at their own tempo.
    ///
    /// # Errors
    /// What is wrong with the patterns that play from the beginning.
    pub fn await_clock(&mut self) -> Result<(), Problem> {
        if std::mem::replace(&mut self.clocked.awaits, true) {
            return Ok(());
        }
        let follows = |p: &usize| self.patch.patterns.get(*p).is_some_and(|pattern| pattern.follows);
        let (clocked, own): (Vec<usize>, Vec<usize>) = self.roots.iter().partition(|p| follows(p));
        if clocked.is_empty() {
            return Ok(());
        }
        self.clocked.patterns = clocked.into_iter().map(|pattern| (pattern, None)).collect();
        self.roots = own;
        self.begin_anew()
    }

    /// The tempo of a song counts the beats of patterns that follow a clock, from its beginning to its end: `tempi` are the seconds at
    /// which it changes and what to, in beats a minute.
    ///
    /// # Errors
    /// As [`Performer::await_clock`].
    pub fn follow_song(&mut self, tempi: &[(f64, f64)], seconds: f64) -> Result<(), Problem> {
        self.await_clock()?;
        self.clocked.beats = Beats::of_song(tempi, seconds, self.lead);
        self.start_clocked(0.0, true)
    }

    /// What a message says about the song. A song of another port is taken up where none runs.
    pub(super) fn count(&mut self, at: When, port: usize, message: Message, outlet: &mut dyn Outlet) {
        let begins = matches!(message, Message::Start | Message::Continue | Message::SongPosition { .. });
        if !(begins || matches!(message, Message::Clock | Message::Stop))
            || !self.clocked.awaits
            || matches!(self.clocked.beats, Beats::Song(..))
        {
            return;
        }
        if self.clocked.port.is_some_and(|known| known != port) {
            if !begins || self.clocked.beats.clock().runs(at.seconds) {
                return;
            }
            // Its clocks are others, too.
            self.stop_clocked(at, outlet);
            self.clocked.beats = Beats::None;
        }
        self.clocked.port = Some(port);
        match message {
            Message::Clock => self.clocked.beats.clock().tick(at.seconds),
            Message::Start => self.song_runs(at, 0.0, true, outlet),
            Message::Continue => self.song_runs(at, self.clocked.stands, false, outlet),
            Message::SongPosition { sixteenths } => self.clocked.stands = f64::from(sixteenths) / 4.0,
            _ => self.stop_clocked(at, outlet),
        }
    }

    /// The song plays on from so many beats. Its patterns are begun when they are fed, however often it is said before.
    fn song_runs(&mut self, at: When, beat: f64, anew: bool, outlet: &mut dyn Outlet) {
        // What has yet to begin anew does so from wherever.
        let anew = anew || self.clocked.begin.is_some_and(|(_, anew)| anew);
        self.release_clocked(at, outlet);
        self.clocked.beats.clock().run(beat, at.seconds);
        self.clocked.begin = Some((beat, anew));
    }

    /// Whether the clock that counts is that of a port.
    pub(super) fn clock_is_of(&self, port: usize) -> bool {
        self.clocked.port == Some(port)
    }

    /// A port is gone: if its clock counted, another may.
    pub(super) fn count_no_more(&mut self, at: When, port: usize, outlet: &mut dyn Outlet) {
        if self.clock_is_of(port) {
            self.stop_clocked(at, outlet);
            (self.clocked.port, self.clocked.beats) = (None, Beats::None);
        }
    }

    /// Takes away what follows a clock, and releases what it sounds.
    fn stop_clocked(&mut self, at: When, outlet: &mut dyn Outlet) {
        if let Beats::Clock(clock) = &mut self.clocked.beats
            && let Some(beat) = clock.stop()
        {
            self.clocked.stands = beat;
        }
        self.release_clocked(at, outlet);
    }

    /// Nothing more of what follows a clock begins from then on, and what it sounds is released.
    fn release_clocked(&mut self, at: When, outlet: &mut dyn Outlet) {
        let clocked = self.runs.iter().filter(|run| run.follows.is_some());
        let all: Vec<u64> = clocked.map(|run| run.whence.of_run(run.serial, 0)).collect();
        self.end_clocked();
        all.into_iter().for_each(|id| self.cancel(at, id, OF_RUN as u8, outlet));
    }

    /// The song is over: nothing more of it is said, what sounds does for as long as it was to, and another clock may count.
    pub(super) fn end_song(&mut self) {
        self.end_clocked();
        if matches!(self.clocked.beats, Beats::Song(..)) {
            self.clocked.beats = Beats::None;
        }
    }

    /// Nothing more of what follows a clock is said.
    pub(super) fn end_clocked(&mut self) {
        self.clocked.begin = None;
        self.runs.retain(|run| run.follows.is_none());
    }

    /// Begins what a song that was started has yet to begin.
    pub(super) fn begin_clocked(&mut self) {
        if let Some((beat, anew)) = self.clocked.begin.take()
            && let Err(problem) = self.start_clocked(beat, anew)
        {
            self.meet(problem);
        }
    }

    /// Plays what follows a clock, from this beat on; with `anew`, what it draws is drawn anew.
    fn start_clocked(&mut self, beat: f64, anew: bool) -> Result<(), Problem> {
        let mut result = Ok(());
        for number in 0..self.clocked.patterns.len() {
            result = result.and(self.start_one_clocked(number, beat, anew));
        }
        result
    }

    /// The same for the one of that number in [`Clocked::patterns`].
    pub(super) fn start_one_clocked(&mut self, number: usize, beat: f64, anew: bool) -> Result<(), Problem> {
        let Some(&(pattern, before)) = self.clocked.patterns.get(number) else { return Ok(()) };
        let Some(speed) = self.patch.patterns.get(pattern).map(speed) else { return Ok(()) };
        self.started += 1;
        let serial = self.started;
        let draws = before.filter(|_| !anew).map_or(serial, |before| before.draws);
        self.clocked.patterns[number].1 = Some(Started { serial, draws });
        if let Some(pattern) = self.patch.patterns.get(pattern) {
            self.stopped.remove(&pattern.name);
        }
        let root = Root::at(pattern, 0.0);
        let score = self.score(&[root], self.seed_of(draws))?;
        let whence = self.clocked.port.map_or(Whence::HERE, |port| Whence::midi(port, None));
        let run = Run::new(serial, vec![root], score).by(whence, self.cause).drawing(draws);
        self.runs.push(run.following(0.0, speed).from((beat - NEAR) / speed));
        Ok(())
    }

    /// Where a pattern that is started now begins, if a clock counts its beats; one whose clocks have stopped coming counts none.
    pub(super) fn follows(&self, at: When, pattern: usize) -> Option<(f64, f64)> {
        let pattern = self.patch.patterns.get(pattern).filter(|pattern| pattern.follows)?;
        // Whether they come is so now; when it begins may lie far ahead.
        self.clocked.beats.runs(self.clock)?;
        Some((self.clocked.beats.beat(at.seconds)?, speed(pattern)))
    }

    /// When something falls that a run says at its `own` time, and by how much longer what it plays lasts. `None` where a clock has yet to
    /// say so.
    pub(super) fn falls(&self, follows: Option<(f64, f64)>, own: f64, earliest: f64) -> Option<(f64, f64)> {
        let Some((beat, usual)) = follows else { return Some((own, 1.0)) };
        let (at, speed) = self.clocked.beats.at(beat + own * usual, usual)?;
        // A clock that has become faster may ask for what is past.
        Some((at.max(earliest), usual / speed))
    }
}

#[cfg(test)]
mod tests;
