//! Patterns whose beats a clock counts: a MIDI clock as it comes, or the tempo of a song.
//!
//! The score says when something happens by a pattern's own tempo. What follows a clock is placed in time when it is fed, with the tempo
//! known then, and lasts as long as that tempo says; what has been fed is not moved any more.

use super::beats::Beats;
use super::run::Run;
use super::{Outlet, Performer, When};
use crate::midi::Message;
use crate::patch::Pattern;
use crate::score::Root;
use crate::text::Problem;

/// Patterns that a clock starts and stops.
#[derive(Debug, Default)]
pub(super) struct Clocked {
    /// By their place in the patch, with the serial number under which each plays or played last.
    pub patterns: Vec<(usize, Option<u64>)>,
    pub beats: Beats,
    /// The port whose clock counts.
    port: Option<u16>,
    /// Where the song stands, in beats.
    stands: f64,
}

/// Beats by which a place may be missed and still count as reached.
const NEAR: f64 = 1e-6;

fn speed(pattern: &Pattern) -> f64 {
    1.0 / pattern.time.seconds()
}

impl Performer {
    /// Patterns that follow a clock wait for it from now on: they do not play at their own tempo.
    ///
    /// # Errors
    /// What is wrong with the patterns that play from the beginning.
    pub fn await_clock(&mut self) -> Result<(), Problem> {
        let follows = |p: &usize| self.patch.patterns.get(*p).is_some_and(|pattern| pattern.follows);
        let (clocked, own): (Vec<usize>, Vec<usize>) = self.roots.iter().partition(|p| follows(p));
        if clocked.is_empty() || !self.clocked.patterns.is_empty() {
            return Ok(());
        }
        self.clocked.patterns = clocked.into_iter().map(|pattern| (pattern, None)).collect();
        self.roots = own;
        let roots: Vec<Root> = self.roots.iter().map(|&p| Root::at(p, 0.0)).collect();
        let score = self.score(&roots, self.plan.seed)?;
        let run = Run::new(0, roots, score);
        self.length = run.length();
        self.runs.retain(|run| run.serial != 0);
        self.runs.push(run);
        Ok(())
    }

    /// The tempo of a song counts the beats of patterns that follow a clock, from its beginning to its end: `tempi` are the seconds at
    /// which it changes and what to, in beats a minute.
    ///
    /// # Errors
    /// As [`Performer::await_clock`].
    pub fn follow_song(&mut self, tempi: &[(f64, f64)], seconds: f64) -> Result<(), Problem> {
        self.await_clock()?;
        self.clocked.beats = Beats::of_song(tempi, seconds);
        self.start_clocked(0.0, true)
    }

    /// What a message says about the song, where something follows it.
    pub(super) fn count(&mut self, at: When, port: u16, message: Message) -> Result<(), Problem> {
        let says = matches!(
            message,
            Message::Clock
                | Message::Start
                | Message::Continue
                | Message::Stop
                | Message::SongPosition { .. }
        );
        let other = self.clocked.port.is_some_and(|known| known != port);
        if !says || other || self.clocked.patterns.is_empty() || matches!(self.clocked.beats, Beats::Song(..))
        {
            return Ok(());
        }
        self.clocked.port = Some(port);
        match message {
            Message::Clock => self.clocked.beats.clock().tick(at.seconds),
            Message::Start => {
                self.clocked.beats.clock().run(0.0);
                return self.start_clocked(0.0, true);
            }
            Message::Continue => {
                let stands = self.clocked.stands;
                self.clocked.beats.clock().run(stands);
                return self.start_clocked(stands, false);
            }
            Message::SongPosition { sixteenths } => self.clocked.stands = f64::from(sixteenths) / 4.0,
            _ => self.stop_clocked(),
        }
        Ok(())
    }

    /// A port is gone: if its clock counted, another may.
    pub(super) fn count_no_more(&mut self, port: u16) {
        if self.clocked.port == Some(port) {
            self.stop_clocked();
            (self.clocked.port, self.clocked.beats) = (None, Beats::None);
        }
    }

    /// Takes away what follows a clock.
    pub(super) fn stop_clocked(&mut self) {
        if let Beats::Clock(clock) = &mut self.clocked.beats {
            self.clocked.stands = clock.stop();
        }
        self.runs.retain(|run| run.follows.is_none());
    }

    /// Plays what follows a clock, from this beat on; with `anew`, what it draws is drawn anew.
    fn start_clocked(&mut self, beat: f64, anew: bool) -> Result<(), Problem> {
        self.runs.retain(|run| run.follows.is_none());
        let mut result = Ok(());
        for number in 0..self.clocked.patterns.len() {
            let (pattern, serial) = self.clocked.patterns[number];
            let serial = serial.filter(|_| !anew).unwrap_or(self.started + 1);
            self.started = self.started.max(serial);
            self.clocked.patterns[number].1 = Some(serial);
            let Some(speed) = self.patch.patterns.get(pattern).map(speed) else { continue };
            let root = Root::at(pattern, 0.0);
            let run = self.score(&[root], self.seed_of(serial)).and_then(|score| {
                let mut run = Run::new(serial, vec![root], score).following(0.0, speed);
                while run.next()?.is_some_and(|own| own * speed < beat - NEAR) {
                    run.take();
                }
                Ok(run)
            });
            match run {
                Ok(run) => self.runs.push(run),
                Err(problem) => result = result.and(Err(problem)),
            }
        }
        result
    }

    /// Where a pattern that is started now begins, if a clock counts its beats.
    pub(super) fn follows(&self, at: When, pattern: usize) -> Option<(f64, f64)> {
        let pattern = self.patch.patterns.get(pattern).filter(|pattern| pattern.follows)?;
        Some((self.clocked.beats.beat(at.seconds)?, speed(pattern)))
    }

    /// When something falls that a run says at its `own` time, and by how much longer what it plays lasts. `None` where a clock has yet to
    /// say so.
    pub(super) fn falls(
        &self,
        follows: Option<(f64, f64)>,
        own: f64,
        outlet: &dyn Outlet,
    ) -> Option<(f64, f64)> {
        let Some((beat, usual)) = follows else { return Some((own, 1.0)) };
        let (at, speed) = self.clocked.beats.at(beat + own * usual, usual)?;
        // A clock that has become faster may ask for what is past.
        let earliest = outlet.clock() as f64 / self.plan.engine_rate();
        Some((at.max(earliest), usual / speed))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Message, Outlet, Performer, When};
    use crate::engine::event::{Event, Source};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::schedule::Instant;
    use crate::text::Problem;

    const RATE: f64 = 8000.0;

    /// Keeps when voices begin and how long they last, in seconds.
    #[derive(Default)]
    struct Kept(u64, Vec<(f64, f64)>);

    impl Outlet for Kept {
        fn clock(&self) -> u64 {
            self.0
        }
        fn room(&self, _: Source) -> usize {
            10_000
        }
        fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
            if let Event::Play(play) = event {
                self.1.push((at.since(Instant::default()) / RATE, play.duration));
            }
            true
        }
    }

    /// A beat of half a beat's length, at 120 a minute by its own count; every fourth is left out.
    fn performer(clock: &str) -> Performer {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n[voice.v.nodes]\n\
             o = {{ type = \"sine\", frequency = 100 }}\n[pattern.p]\ntime = \"beats\"\n{clock}\n\
             events = [{{ at = 0, voice = \"v\", duration = 0.5, repeat = {{ every = 1, times = 3 }} }}]\n\
             repeat = {{ every = 4, times = 50 }}\n"
        );
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let rig = Rig::default_for(1);
        let options = Options { live: true, ..Options::default() };
        let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let refuse = |_: &str| Err(Problem::of_file("no files here"));
        Performer::new(scene, Arc::new(patch), Arc::new(rig), Box::new(refuse))
            .unwrap_or_else(|p| panic!("{p}"))
    }

    fn say(performer: &mut Performer, kept: &mut Kept, seconds: f64, message: Message) {
        kept.0 = (seconds * RATE) as u64;
        performer.midi(When::of_seconds(seconds, RATE), 0, message, kept).unwrap_or_else(|p| panic!("{p}"));
        // As a session does: fifty milliseconds ahead.
        performer.feed(kept.0 + 400, kept);
    }

    /// So many clocks at a tempo, the first at `from`, each up to `jitter` late. Gives when the next is due.
    fn clocks(
        performer: &mut Performer,
        kept: &mut Kept,
        from: f64,
        count: u32,
        bpm: f64,
        jitter: f64,
    ) -> f64 {
        for n in 0..count {
            let late = jitter * f64::from(n.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 24);
            say(performer, kept, from + f64::from(n) * 2.5 / bpm + late, Message::Clock);
        }
        from + f64::from(count) * 2.5 / bpm
    }

    /// The beats that sound of so many, from `first` on at `at`.
    fn due(at: f64, first: u32, count: u32, bpm: f64) -> Vec<f64> {
        let sounds = (first..first + count).filter(|beat| beat % 4 != 3);
        sounds.map(|beat| at + f64::from(beat - first) * 60.0 / bpm).collect()
    }

    fn near(kept: &Kept, due: &[f64], most: f64) {
        assert!(kept.1.len() == due.len(), "{:?} for {due:?}", kept.1);
        for ((at, _), due) in kept.1.iter().zip(due) {
            assert!((at - due).abs() < most, "{at} for {due}: {:?}", kept.1);
        }
    }

    #[test]
    fn it_starts_stops_and_goes_on_with_the_clock() {
        let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
        performer.await_clock().unwrap();
        performer.feed(80_000, &mut kept);
        // Clocks alone start nothing, but say what the tempo is.
        let start = clocks(&mut performer, &mut kept, 0.3, 48, 90.0, 0.0);
        assert!(kept.1.is_empty());
        say(&mut performer, &mut kept, start - 0.01, Message::Start);
        let stop = clocks(&mut performer, &mut kept, start, 6 * 24 - 12, 90.0, 0.0);
        near(&kept, &due(start, 0, 6, 90.0), 1e-3);
        let half_a_beat = 0.5 * 60.0 / 90.0;
        assert!(kept.1.iter().all(|(_, long)| (long / half_a_beat - 1.0).abs() < 1e-3), "{:?}", kept.1);
        say(&mut performer, &mut kept, stop - 0.01, Message::Stop);
        let goes_on = clocks(&mut performer, &mut kept, stop, 100, 90.0, 0.0);
        assert_eq!(kept.1.len(), due(start, 0, 6, 90.0).len(), "it stands");
        // It stood half a beat before the seventh.
        kept.1.clear();
        say(&mut performer, &mut kept, goes_on - 0.01, Message::Continue);
        let end = clocks(&mut performer, &mut kept, goes_on, 3 * 24, 90.0, 0.0);
        near(&kept, &due(goes_on + half_a_beat, 6, 3, 90.0), 1e-3);
        // To the second beat of the fifth bar.
        kept.1.clear();
        say(&mut performer, &mut kept, end - 0.01, Message::Stop);
        say(&mut performer, &mut kept, end - 0.01, Message::SongPosition { sixteenths: 4 * 17 });
        say(&mut performer, &mut kept, end - 0.01, Message::Continue);
        clocks(&mut performer, &mut kept, end, 3 * 24 - 12, 90.0, 0.0);
        near(&kept, &due(end, 17, 3, 90.0), 1e-3);
    }

    #[test]
    fn it_follows_another_tempo_through_jitter_and_never_drifts() {
        let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
        performer.await_clock().unwrap();
        say(&mut performer, &mut kept, 0.99, Message::Start);
        let jump = clocks(&mut performer, &mut kept, 1.0, 40 * 24, 120.0, 0.002);
        // A millisecond is what the jitter comes to in the mean.
        let beats = due(1.001, 0, 40, 120.0);
        let settled: Vec<_> = kept.1.iter().zip(&beats).skip(3).collect();
        assert!(
            settled.len() == 27 && settled.iter().all(|((at, _), due)| (at - *due).abs() < 0.0015),
            "{settled:?}"
        );
        kept.1.clear();
        clocks(&mut performer, &mut kept, jump, 20 * 24 - 12, 100.0, 0.0);
        let beats = due(jump, 40, 20, 100.0);
        let off: Vec<f64> =
            kept.1.iter().rev().zip(beats.iter().rev()).map(|((at, _), due)| (at - due).abs()).collect();
        assert!(off.len() >= 10 && off[..10].iter().all(|off| *off < 0.002), "{off:?}");
    }

    #[test]
    fn a_clock_that_dies_holds_it_and_one_that_is_gone_ends_it() {
        let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
        performer.await_clock().unwrap();
        say(&mut performer, &mut kept, 0.99, Message::Start);
        let end = clocks(&mut performer, &mut kept, 1.0, 2 * 24, 120.0, 0.0);
        performer.feed(800_000, &mut kept);
        assert!(kept.1.len() <= 3 && kept.1.iter().all(|(at, _)| *at < end + 0.5), "{:?}", kept.1);
        performer.midi_gone(When::of_seconds(end, RATE), 0, &mut kept).unwrap();
        assert_eq!(performer.patterns().filter(|(serial, _)| *serial > 0).count(), 0);
        // Another port may count now, from its own start on.
        kept.1.clear();
        let mut other = |seconds: f64, message| {
            kept.0 = (seconds * RATE) as u64;
            performer.midi(When::of_seconds(seconds, RATE), 3, message, &mut kept).unwrap();
            performer.feed(kept.0 + 400, &mut kept);
        };
        other(100.0, Message::Start);
        (0..13).for_each(|n| other(100.01 + f64::from(n) / 48.0, Message::Clock));
        near(&kept, &[100.01], 1e-3);
    }

    /// The tempo of a song is known beforehand: everything falls exactly, however it is fed.
    #[test]
    fn the_tempo_of_a_song_counts_exactly() {
        let fed = |step: u64| {
            let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
            performer.play_song([], 6.2);
            // Four beats at 60, then 240, then 30 from the eighth beat on.
            performer.follow_song(&[(0.0, 60.0), (4.0, 240.0), (5.0, 30.0)], 6.2).unwrap();
            let mut until = 0;
            while until < 80_000 {
                until += step;
                performer.feed(until, &mut kept);
                kept.0 = until;
            }
            assert!(performer.is_over());
            kept.1
        };
        let all = fed(64);
        let wanted =
            [(0.0, 0.5), (1.0, 0.5), (2.0, 0.5), (4.0, 0.125), (4.25, 0.125), (4.5, 0.125), (5.0, 1.0)];
        assert_eq!(all, wanted);
        assert_eq!(fed(1), all);
        assert_eq!(fed(12_345), all);
    }

    #[test]
    fn without_a_clock_it_has_its_own_tempo() {
        let (mut performer, mut kept) = (performer("clock = \"midi\"\ntempo = 60"), Kept::default());
        performer.feed(16_001, &mut kept);
        assert_eq!(kept.1, [(0.0, 0.5), (1.0, 0.5), (2.0, 0.5)]);
        // And what has its own clock hears no other.
        let (mut performer, mut kept) = (self::performer("tempo = 60"), Kept::default());
        performer.await_clock().unwrap();
        say(&mut performer, &mut kept, 0.5, Message::Start);
        clocks(&mut performer, &mut kept, 0.5, 40, 200.0, 0.0);
        performer.feed(16_001, &mut kept);
        assert_eq!(kept.1.iter().map(|(at, _)| *at).collect::<Vec<_>>(), [0.0, 1.0, 2.0]);
    }
}
