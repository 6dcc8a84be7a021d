use super::super::Outlet;
use super::super::staged::{self, HEAD, VOICE};
use super::{Message, Performer, When};
use crate::engine::event::{Event, Source};
use crate::schedule::Instant;

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

/// A beat of half a beat's length, at 120 a minute by its own count; every fourth is left out. What stands behind a line of its own goes
/// behind the pattern.
fn text(clock: &str) -> String {
    let (clock, rest) = clock.split_once("---").unwrap_or((clock, ""));
    format!(
        "{HEAD}{VOICE}[pattern.p]\ntime = \"beats\"\n{clock}\n\
         events = [{{ at = 0, voice = \"v\", duration = 0.5, repeat = {{ every = 1, times = 3 }} }}]\n\
         repeat = {{ every = 4, times = 50 }}\n{rest}"
    )
}

fn performer(clock: &str) -> Performer {
    staged::performer(&text(clock), 1)
}

/// The same patch with other lines is saved while it plays.
fn save(performer: &mut Performer, clock: &str) {
    staged::save(performer, &text(clock), 1);
}

fn say(performer: &mut Performer, kept: &mut Kept, seconds: f64, message: Message) {
    say_to(performer, 0, kept, seconds, message);
}

fn say_to(performer: &mut Performer, port: u16, kept: &mut Kept, seconds: f64, message: Message) {
    kept.0 = (seconds * RATE) as u64;
    performer.midi(When::of_seconds(seconds, RATE), port, message, kept).unwrap_or_else(|p| panic!("{p}"));
    // As a session does: fifty milliseconds ahead.
    performer.feed(kept.0 + 400, kept);
}

/// So many clocks at a tempo, the first at `from`, each up to `jitter` late. Gives when the next is due.
fn clocks(performer: &mut Performer, kept: &mut Kept, from: f64, count: u32, bpm: f64, jitter: f64) -> f64 {
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
    let wanted = [(0.0, 0.5), (1.0, 0.5), (2.0, 0.5), (4.0, 0.125), (4.25, 0.125), (4.5, 0.125), (5.0, 1.0)];
    assert_eq!(all, wanted);
    assert_eq!(fed(1), all);
    assert_eq!(fed(12_345), all);
}

/// Senders that send no clocks while their song stands.
#[test]
fn after_a_pause_nothing_plays_before_the_first_clock() {
    let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
    performer.await_clock().unwrap();
    say(&mut performer, &mut kept, 0.99, Message::Start);
    let stop = clocks(&mut performer, &mut kept, 1.0, 36, 120.0, 0.0);
    say(&mut performer, &mut kept, stop, Message::Stop);
    performer.feed(80_000, &mut kept);
    near(&kept, &due(1.0, 0, 2, 120.0), 1e-3);
    // It stands half a beat behind the second.
    for (message, at, first) in [(Message::Start, 20.0, 0), (Message::Continue, 40.0, 2)] {
        kept.1.clear();
        say(&mut performer, &mut kept, at, message);
        for n in 1..20 {
            performer.feed((at * RATE) as u64 + 400 * n, &mut kept);
        }
        assert!(kept.1.is_empty(), "no clock has come: {:?}", kept.1);
        let wait = if first > 0 { 0.25 } else { 0.0 };
        let stop = clocks(&mut performer, &mut kept, at + 2.0, 36, 120.0, 0.0);
        say(&mut performer, &mut kept, stop, Message::Stop);
        near(&kept, &due(at + 2.0 + wait, first, 2 - first / 2, 120.0), 2e-3);
    }
}

#[test]
fn a_song_position_outlasts_another_stop() {
    let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
    performer.await_clock().unwrap();
    say(&mut performer, &mut kept, 0.99, Message::Start);
    let end = clocks(&mut performer, &mut kept, 1.0, 30, 120.0, 0.0);
    kept.1.clear();
    for message in
        [Message::Stop, Message::SongPosition { sixteenths: 4 * 17 }, Message::Stop, Message::Continue]
    {
        say(&mut performer, &mut kept, end - 0.01, message);
    }
    clocks(&mut performer, &mut kept, end, 2 * 24, 120.0, 0.0);
    near(&kept, &due(end, 17, 2, 120.0), 2e-3);
}

/// A port that only sends clocks, as many do at all times, keeps nobody from playing.
#[test]
fn the_port_counts_whose_song_runs() {
    let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
    performer.await_clock().unwrap();
    let begin = clocks(&mut performer, &mut kept, 0.0, 48, 60.0, 0.0);
    say_to(&mut performer, 5, &mut kept, begin, Message::Start);
    let other = |performer: &mut Performer, kept: &mut Kept, from: f64, count: u32| {
        for n in 0..count {
            let at = from + f64::from(n) / 48.0;
            say_to(performer, 5, kept, at, Message::Clock);
            // The first goes on; its clocks, and its song while the other runs, count for nothing.
            let noise = [Message::Clock, Message::Start, Message::SongPosition { sixteenths: 99 }];
            say(performer, kept, at + 0.001, noise[n as usize % 3]);
        }
        from + f64::from(count) / 48.0
    };
    let stop = other(&mut performer, &mut kept, begin + 0.1, 60);
    near(&kept, &due(begin + 0.1, 0, 3, 120.0), 2e-3);
    // The first stops what is not its own; the other does, and then the first may.
    say(&mut performer, &mut kept, stop, Message::Stop);
    assert_eq!(performer.patterns().filter(|(serial, _)| *serial > 0).count(), 1);
    say_to(&mut performer, 5, &mut kept, stop, Message::Stop);
    assert_eq!(performer.patterns().filter(|(serial, _)| *serial > 0).count(), 0);
    kept.1.clear();
    say(&mut performer, &mut kept, stop, Message::SongPosition { sixteenths: 8 });
    say(&mut performer, &mut kept, stop, Message::Continue);
    clocks(&mut performer, &mut kept, stop + 0.1, 20, 60.0, 0.0);
    near(&kept, &[stop + 0.1], 2e-3);
}

#[test]
fn a_file_that_is_saved_may_change_who_counts() {
    let (own, clock) = ("tempo = 60", "clock = \"midi\"");
    let (mut performer, mut kept) = (performer(own), Kept::default());
    performer.await_clock().unwrap();
    let feed = |performer: &mut Performer, kept: &mut Kept, until: f64| {
        performer.feed((until * RATE) as u64, kept);
        std::mem::take(&mut kept.1).into_iter().map(|(at, _)| at).collect::<Vec<_>>()
    };
    assert_eq!(feed(&mut performer, &mut kept, 1.5), [0.0, 1.0]);
    // From its own tempo to the clock, which does not run.
    save(&mut performer, clock);
    assert!(feed(&mut performer, &mut kept, 5.0).is_empty());
    say(&mut performer, &mut kept, 6.0, Message::Start);
    let now = clocks(&mut performer, &mut kept, 6.0, 30, 120.0, 0.0);
    near(&kept, &due(6.0, 0, 2, 120.0), 2e-3);
    kept.1.clear();
    // Back, and it is where it would have been. The clock goes on meanwhile.
    save(&mut performer, own);
    let now = clocks(&mut performer, &mut kept, now, 24 * 5 - 6, 120.0, 0.0);
    let played: Vec<_> = kept.1.drain(..).map(|(at, _)| at).collect();
    assert_eq!(played, [8.0, 9.0]);
    // And to the clock again: its song is at the sixth beat, which has just been played, and the seventh is left out.
    save(&mut performer, clock);
    clocks(&mut performer, &mut kept, now, 3 * 24 - 6, 120.0, 0.0);
    near(&kept, &due(now + 0.5, 7, 2, 120.0), 2e-3);
    assert!((now - 9.0).abs() < 1e-9);
    // Saved once more as it is, it plays on as it did.
    kept.1.clear();
    save(&mut performer, clock);
    clocks(&mut performer, &mut kept, now + 1.5 - 0.125, 30, 120.0, 0.0);
    near(&kept, &due(now + 1.5, 9, 2, 120.0), 2e-3);
    // What was stopped does not come back by being saved.
    performer.stop_patterns(When::of_seconds(now, 8000.0), &mut kept);
    kept.1.clear();
    for file in [own, clock, own] {
        save(&mut performer, file);
        performer.feed(160_000, &mut kept);
    }
    assert!(kept.1.is_empty(), "{:?}", kept.1);
}

/// Every message asks for millions of events to be left out.
#[test]
fn a_flood_of_song_positions_is_cheap() {
    let many = "clock = \"midi\"---[[trigger]]\non = \"start\"\nplay = \"q\"\n[pattern.q]\ntime = \"beats\"\nclock = \"midi\"\nrepeat = { every = 0.001 }\n\
                events = [{ at = 0, voice = \"v\" }]\n";
    let (mut performer, mut kept) = (performer(many), Kept::default());
    performer.await_clock().unwrap();
    for n in 0..20_000 {
        let at = When::of_seconds(f64::from(n) * 1e-4, RATE);
        let place = Message::SongPosition { sixteenths: 16_383 };
        for message in [place, Message::Continue] {
            performer.midi(at, 0, message, &mut kept).unwrap();
        }
        if n % 100 == 0 {
            performer.feed_some(16_000, &mut kept);
        }
    }
    assert!(!performer.feed_some(16_000, &mut kept), "it is on its way");
    assert!(kept.1.is_empty());
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

/// What sounds when, as the engine has it: an order to stop takes effect at its instant, on whatever has been sent by then.
#[derive(Default)]
struct Sounding {
    clock: u64,
    /// Of each voice its id, and from when to when it sounds, in seconds.
    voices: Vec<(u64, f64, f64)>,
    stops: Vec<(f64, u64, u8)>,
}

impl Outlet for Sounding {
    fn clock(&self) -> u64 {
        self.clock
    }
    fn room(&self, _: Source) -> usize {
        10_000
    }
    fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
        let at = at.since(Instant::default()) / RATE;
        match event {
            Event::Play(play) => self.voices.push((play.id, at, at + play.duration)),
            Event::Cancel(id, bits) => self.stops.push((at, id, bits)),
            other => panic!("{other:?}"),
        }
        true
    }
}

impl Sounding {
    /// At so many seconds, a message comes; the session goes on to there, and feeds fifty milliseconds ahead.
    fn say(&mut self, performer: &mut Performer, seconds: f64, message: Message) {
        self.clock = (seconds * RATE) as u64;
        let due = std::mem::take(&mut self.stops).into_iter().partition(|(at, ..)| *at <= seconds);
        let (due, later): (Vec<_>, Vec<_>) = due;
        self.stops = later;
        for (at, id, bits) in due {
            let is_of = |voice: &(u64, f64, f64)| crate::engine::event::is_of(voice.0, id, bits);
            self.voices.retain(|voice| !is_of(voice) || voice.1 < at);
            self.voices.iter_mut().filter(|voice| is_of(voice)).for_each(|voice| voice.2 = voice.2.min(at));
        }
        performer.midi(When::of_seconds(seconds, RATE), 0, message, self).unwrap_or_else(|p| panic!("{p}"));
        performer.feed(self.clock + 400, self);
    }

    fn clocks(&mut self, performer: &mut Performer, from: f64, count: u32) -> f64 {
        (0..count).for_each(|n| self.say(performer, from + f64::from(n) / 48.0, Message::Clock));
        from + f64::from(count) / 48.0
    }
}

/// Each of its voices is played for eight beats, of which there are two a second.
#[test]
fn a_sequencer_that_stops_or_jumps_releases_what_its_patterns_sound() {
    let long = text("clock = \"midi\"").replace("duration = 0.5", "duration = 8");
    let (mut performer, mut sounding) = (staged::performer(&long, 1), Sounding::default());
    performer.await_clock().unwrap();
    sounding.say(&mut performer, 0.99, Message::Start);
    // A beat has just been sent ahead when it stops.
    let stop = sounding.clocks(&mut performer, 1.0, 24 + 23);
    sounding.say(&mut performer, stop, Message::Stop);
    sounding.clocks(&mut performer, stop, 48);
    let until = |sounding: &Sounding| sounding.voices.iter().map(|voice| voice.2).fold(0.0, f64::max);
    assert_eq!(sounding.voices.len(), 2, "{:?}", sounding.voices);
    assert!((until(&sounding) - stop).abs() < 1e-3, "{:?}", sounding.voices);
    // From one place to another without a pause, as in a loop: what begins there is heard from its first beat on.
    sounding.voices.clear();
    sounding.say(&mut performer, 5.0, Message::Start);
    let jump = sounding.clocks(&mut performer, 5.0, 36);
    for message in [Message::Stop, Message::SongPosition { sixteenths: 16 }, Message::Continue] {
        sounding.say(&mut performer, jump, message);
    }
    let again = sounding.clocks(&mut performer, jump, 36);
    let begun = |sounding: &Sounding, from: f64| -> Vec<f64> {
        sounding.voices.iter().map(|voice| voice.1).filter(|at| *at > from - 0.01).collect()
    };
    let heard = begun(&sounding, jump);
    assert!(heard.len() == 2 && (heard[0] - jump).abs() < 2e-3, "{heard:?} from {jump} on");
    assert!(sounding.voices[..2].iter().all(|voice| (voice.2 - jump).abs() < 1e-3), "{:?}", sounding.voices);
    // Started again without a stop.
    sounding.say(&mut performer, again, Message::Start);
    sounding.clocks(&mut performer, again, 12);
    assert!(sounding.voices[2..4].iter().all(|voice| voice.2 < again + 1e-3), "{:?}", sounding.voices);
    assert_eq!(begun(&sounding, again).len(), 1, "{:?}", sounding.voices);
}

/// Said before anything of it is fed, a start is one, wherever the song then goes on; a continuation alone draws what was drawn.
#[test]
fn what_is_to_begin_anew_does_so_from_wherever() {
    let (mut performer, mut kept) = (performer("clock = \"midi\""), Kept::default());
    performer.await_clock().unwrap();
    let say = |performer: &mut Performer, kept: &mut Kept, messages: &[Message]| {
        for message in messages {
            performer.midi(When::of_seconds(1.0, RATE), 0, *message, kept).unwrap();
        }
        performer.feed(8_400, kept);
        let started = performer.clocked.patterns[0].1.unwrap();
        (started.serial, started.draws)
    };
    let (serial, first) = say(&mut performer, &mut kept, &[Message::Start]);
    assert_eq!(serial, first);
    let place = Message::SongPosition { sixteenths: 16 };
    let (serial, draws) = say(&mut performer, &mut kept, &[Message::Stop, place, Message::Continue]);
    assert!(serial != first && draws == first, "it goes on: {serial}, {draws}");
    let (serial, draws) = say(&mut performer, &mut kept, &[Message::Start, place, Message::Continue]);
    assert_eq!(serial, draws, "it was started");
}

/// When a song from a file is over, or a clock has died without a word, what is started then has its own tempo; and a clock counts that comes.
#[test]
fn what_is_started_once_nobody_counts_has_its_own_tempo() {
    let key = "clock = \"midi\"\n---[[trigger]]\non = \"key.1\"\nplay = \"p\"\n";
    let own = |performer: &mut Performer, kept: &mut Kept, at: f64| {
        kept.1.clear();
        kept.0 = (at * RATE) as u64;
        performer.feed(kept.0, kept);
        performer.key(When::of_seconds(at, RATE), 1, kept).unwrap();
        performer.feed(((at + 1.4) * RATE) as u64, kept);
        near(kept, &due(at, 0, 3, 120.0), 1e-6);
    };
    let (mut performer, mut kept) = (performer(key), Kept::default());
    performer.follow_song(&[(0.0, 60.0)], 2.0).unwrap();
    performer.play_song([], 2.0);
    // All at once: what falls before the song's end is there.
    performer.feed((2.5 * RATE) as u64, &mut kept);
    near(&kept, &due(0.0, 0, 2, 60.0), 1e-6);
    own(&mut performer, &mut kept, 3.0);
    // Once that has sounded, a sequencer begins.
    let serials: Vec<u64> = performer.patterns().map(|(serial, _)| serial).collect();
    for serial in serials {
        assert!(performer.stop_pattern(When::of_seconds(5.0, RATE), serial, &mut kept));
    }
    say(&mut performer, &mut kept, 5.9, Message::Start);
    let mid = clocks(&mut performer, &mut kept, 6.0, 24, 90.0, 0.0);
    kept.1.clear();
    // Meant for half a beat later.
    let later = mid + 0.5 * 60.0 / 90.0;
    performer.key(When::of_seconds(later, RATE), 1, &mut kept).unwrap();
    let end = clocks(&mut performer, &mut kept, mid, 36, 90.0, 0.0);
    // The clock has begun the pattern as well; its third beat lies between.
    let beat = 60.0 / 90.0;
    near(&kept, &[later, mid + beat, later + beat], 5e-3);
    // Its cable stays, and nothing comes any more: what falls within a beat is played by it, and for what is behind that it is waited for.
    kept.1.clear();
    performer.key(When::of_seconds(end + 0.3, RATE), 1, &mut kept).unwrap();
    performer.feed(((end + 4.0) * RATE) as u64, &mut kept);
    near(&kept, &[end + 0.3], 5e-3);
    own(&mut performer, &mut kept, end + 5.0);
}
