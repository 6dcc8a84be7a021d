//! The way from the threads of a session to who shows what they say. It never makes them wait.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use pacinian::engine::event::is_of;
use pacinian::io::device::keeper::Fate;
use pacinian::io::midi_in::PortNews;
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::gate::Order;
use pacinian::live::signal::{Signal, Stamped};
use pacinian::node::motion::Motion;
use pacinian::performer::{Happening, Heard};
use pacinian::schedule::Instant as Due;
use pacinian::text::problem::shown;

use super::happened::{Happened, Mood};

/// Events that may wait to be shown, and those among them whose time has not come.
const WAITING: usize = 1 << 10;
const COMING: usize = 1 << 12;

/// Voices that are known by their names.
const KNOWN: usize = 1 << 12;

/// How things stand; none of it may get lost.
#[derive(Debug)]
pub enum State {
    /// The device is gone, or back.
    Device(Fate),
    /// Full level, or not.
    Armed(bool),
    /// This pattern was set off by something of the engine, which says so itself.
    SetOff(String),
    /// These patterns play: the numbers by which they were started, 0 for those of the beginning, and their names.
    Playing(Vec<(u64, String)>),
}

/// Something that is to be shown.
#[derive(Debug)]
struct Letter {
    happened: Happened,
    /// When it is due, on the engine's clock; `None`: now.
    due: Option<Due>,
    /// What it is of.
    of: Of,
    /// Of a voice that begins, which it is and where.
    who: Option<String>,
}

/// What a letter is of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    /// The voice of that id, if it has one.
    Voice(Option<u64>),
    /// What a hand does with the voice of that id, and where to.
    Touch(u64, Motion, f64),
    /// The release of the voice of that id.
    Release(u64),
    /// The marker of that id.
    Marker(u64),
    /// What MIDI had started falls silent.
    Silence,
    /// Something else.
    Other,
    /// No event: of voices and markers to come, those of that id but for so many of its lowest bits, there is none.
    Cancel(u64, u8),
}

impl Of {
    fn heard(heard: &Heard<'_>) -> Self {
        match (&heard.what, heard.id) {
            (Happening::Voice { .. }, id) => Self::Voice(id),
            (Happening::Touch(motion, to), Some(id)) => Self::Touch(id, *motion, *to),
            (Happening::Release, Some(id)) => Self::Release(id),
            (Happening::Marker(_), Some(id)) => Self::Marker(id),
            (Happening::Silence(_), _) => Self::Silence,
            (Happening::Cancel(bits), Some(id)) => Self::Cancel(id, *bits),
            _ => Self::Other,
        }
    }

    fn calls_off(self, other: Self) -> bool {
        match (self, other) {
            (Self::Cancel(id, bits), Self::Voice(Some(of)) | Self::Marker(of)) => is_of(of, id, bits),
            _ => false,
        }
    }
}

/// Where the controls were sent last, by their names.
type Moved = Arc<Mutex<BTreeMap<String, f64>>>;

/// Where threads of a session put what they say.
#[derive(Debug, Clone)]
pub struct Post {
    events: SyncSender<Letter>,
    moved: Moved,
    states: Sender<State>,
    missed: Arc<AtomicU64>,
    begin: Instant,
}

/// Where it is fetched.
#[derive(Debug)]
pub struct PostBox {
    events: Receiver<Letter>,
    /// What is still to come, in its order; the second number tells apart what comes at the same time.
    coming: BTreeMap<(Due, u64), Letter>,
    taken: u64,
    /// Voices that have begun, by their ids.
    voices: BTreeMap<u64, String>,
    moved: Moved,
    /// Seconds that the session's clock is behind the post's.
    behind: f64,
    /// How far the session had come, seconds, when it was asked last what happened, or the latest that was told of then.
    latest: f64,
    states: Receiver<State>,
    missed: Arc<AtomicU64>,
    begin: Instant,
}

/// A post that begins now.
pub fn post() -> (Post, PostBox) {
    let (events, event) = sync_channel(WAITING);
    let (states, state) = channel();
    let (missed, begin) = (Arc::<AtomicU64>::default(), Instant::now());
    let moved = Moved::default();
    let post = Post { events, moved: Arc::clone(&moved), states, missed: Arc::clone(&missed), begin };
    let fetch = PostBox {
        events: event,
        coming: BTreeMap::new(),
        taken: 0,
        voices: BTreeMap::new(),
        moved,
        behind: 0.0,
        latest: 0.0,
        states: state,
        missed,
        begin,
    };
    (post, fetch)
}

impl Post {
    fn put(&self, letter: Letter) {
        if self.events.try_send(letter).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn say(&self, mood: Mood, text: impl Into<String>) {
        let happened = Happened::new(self.begin.elapsed().as_secs_f64(), mood, text);
        self.put(Letter { happened, due: None, of: Of::Other, who: None });
    }

    fn state(&self, state: State) {
        // Where nobody fetches any more, the session is over.
        let _ = self.states.send(state);
    }

    /// For the listener of a session.
    pub fn hear(&self, heard: &Heard<'_>) {
        match heard.what {
            // What follows from it is shown.
            Happening::Message(_) => return,
            Happening::Start(name) => self.state(State::SetOff(name.into())),
            _ => {}
        }
        if let Happening::Control(name, value) = heard.what
            // It is held for no longer than it takes to copy a few numbers.
            && let Ok(mut moved) = self.moved.lock()
        {
            match moved.get_mut(name) {
                Some(last) => *last = value,
                None => drop(moved.insert(name.into(), value)),
            }
        }
        self.put(Letter {
            happened: Happened::heard(heard),
            due: Some(heard.instant),
            of: Of::heard(heard),
            who: Happened::who(heard),
        });
    }

    /// For its audience.
    pub fn told(&self, told: Told<'_>) {
        match told {
            Told::Report(Report { deed: Deed::Order(Order::Gain(gain), _), .. }, _) => {
                self.state(State::Armed(*gain >= 1.0));
            }
            Told::Came(Stamped { signal: Signal::Note(text), .. }) => {
                self.say(Mood::Told, format!("note: {}", shown(text)));
            }
            Told::Report(..) | Told::Began(..) | Told::Came(..) | Told::Reloading(..) => {}
            Told::Lost(port, name) => {
                let of = name.map_or_else(|| format!("port {port}"), ToString::to_string);
                self.say(
                    Mood::Bad,
                    format!("the MIDI cable of {of} is lost, which had promised to stay: panic"),
                );
            }
            Told::Refused(problem, _) => self.say(Mood::Bad, problem.to_string()),
            Told::Playing(playing) => {
                self.state(State::Playing(
                    playing.iter().map(|(serial, name)| (*serial, (*name).into())).collect(),
                ));
            }
            // Whoever sent it says so.
            Told::Reloaded | Told::Kept(..) | Told::Vain(..) => {}
        }
    }

    /// For what becomes of the device that is listened to.
    pub fn input_fate(&self, fate: Fate) {
        match fate {
            Fate::Lost(why) => self
                .say(Mood::Bad, format!("the input device is gone ({why}); it is silence until it is back")),
            Fate::Back => self.say(Mood::Good, "the input device is back"),
            Fate::Moved => self.say(Mood::Bad, "the system moved the input to another device"),
            // It has no level.
            Fate::Lowered => {}
            Fate::Said(what) => self.say(Mood::Bad, format!("input: {what}")),
        }
    }

    /// For what becomes of the device.
    pub fn fate(&self, fate: Fate) {
        self.state(State::Device(fate));
    }
}

impl Post {
    /// For what becomes of ports of MIDI.
    pub fn port(&self, news: &PortNews) {
        match news {
            PortNews::Opened(name) => self.say(Mood::Good, format!("MIDI from {name}")),
            PortNews::Gone(name) => {
                self.say(Mood::Bad, format!("the MIDI port {name} is gone; its notes are released"))
            }
            PortNews::Unknown(unknown) => self.say(Mood::Bad, unknown.to_string()),
            PortNews::None(why) => self.say(Mood::Bad, format!("no MIDI: {why}")),
            PortNews::Refused(name, why) => {
                self.say(Mood::Bad, format!("the MIDI port {name} cannot be opened: {why}"))
            }
        }
    }
}

impl PostBox {
    /// The session has come so far: engine samples, and seconds. `unfelt` says why nothing of it is felt now, if it is not.
    ///
    /// Gives what happened since this was asked last, in its order, as the session's clock has it: what is played ahead only when its
    /// time has come.
    pub fn events(&mut self, clock: u64, seconds: f64, unfelt: Option<&str>) -> Vec<Happened> {
        self.behind = self.elapsed() - seconds;
        let mut now: Vec<Happened> = Vec::new();
        for letter in self.events.try_iter().take(WAITING) {
            match letter.due {
                Some(due) if matches!(letter.of, Of::Cancel(..)) => {
                    self.coming.retain(|(at, _), known| *at < due || !letter.of.calls_off(known.of));
                }
                // It is an event for the voices and one for the patterns, and one thing to whoever looks.
                Some(due) if letter.of == Of::Silence && self.is_to_be_silent(due) => {}
                Some(_) if self.coming.len() >= COMING => {
                    self.missed.fetch_add(1, Ordering::Relaxed);
                }
                Some(due) => {
                    self.taken += 1;
                    self.coming.insert((due, self.taken), letter);
                }
                None => {
                    // Stamped by the other clock, and so told neither before what was told already nor behind what is still to come.
                    let at = (letter.happened.at - self.behind).min(seconds).max(self.latest);
                    now.push(Happened { at, ..letter.happened });
                }
            }
        }
        while let Some(first) = self.coming.first_entry().filter(|first| first.key().0.ceiling() < clock) {
            let Letter { happened, of, who, .. } = first.remove();
            if let Of::Voice(id) = of {
                self.begin(id, who);
            }
            now.push(match of {
                Of::Voice(_) | Of::Marker(_) => unfelt.into_iter().fold(happened, Happened::unfelt),
                Of::Touch(id, motion, to) => happened.touches(self.voices.get(&id), motion, to),
                Of::Release(id) => happened.releases(self.voices.get(&id)),
                _ => happened,
            });
        }
        now.sort_by(|a, b| a.at.total_cmp(&b.at));
        self.latest = now.iter().fold(self.latest.max(seconds), |latest, happened| latest.max(happened.at));
        now
    }

    /// A voice has begun; what begins next knows it by its id.
    fn begin(&mut self, id: Option<u64>, who: Option<String>) {
        if let Some((id, who)) = id.zip(who) {
            self.voices.insert(id, who);
            if self.voices.len() > KNOWN {
                // Any of them: there are far more than can sound.
                self.voices.pop_first();
            }
        }
    }

    /// Whether what MIDI had started is to fall silent then.
    fn is_to_be_silent(&self, due: Due) -> bool {
        self.coming.range((due, 0)..=(due, u64::MAX)).any(|(_, letter)| letter.of == Of::Silence)
    }

    /// Where controls were sent since this was asked last.
    pub fn moved(&self) -> BTreeMap<String, f64> {
        self.moved.lock().map(|mut moved| std::mem::take(&mut *moved)).unwrap_or_default()
    }

    /// Seconds since the beginning, as the session's clock has it, to where all that happened has been told: what is told as of now stands between
    /// that and what is still to come.
    pub fn now(&self) -> f64 {
        self.latest
    }

    /// How things came to stand since.
    pub fn states(&self) -> impl Iterator<Item = State> {
        self.states.try_iter()
    }

    /// Events that found no room.
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }

    /// Seconds since the beginning.
    pub fn elapsed(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::{Due, KNOWN, Mood, Motion, Post, PostBox, State, WAITING, post};
    use pacinian::io::device::keeper::Fate;
    use pacinian::performer::{Happening, Heard};

    #[test]
    fn nobody_waits_and_nothing_is_lost_silently() {
        let (post, mut fetch) = post();
        for _ in 0..3 * WAITING {
            post.say(Mood::Usual, "x");
            post.fate(Fate::Back);
        }
        assert_eq!(fetch.events(0, 0.0, None).len() as u64 + fetch.missed(), 3 * WAITING as u64);
        assert!(fetch.missed() > 0);
        let states = fetch.states().filter(|s| matches!(s, State::Device(Fate::Back))).count();
        assert_eq!(states, 3 * WAITING);
        drop(fetch);
        post.fate(Fate::Back);
        post.say(Mood::Bad, "nobody is there");
    }

    /// Tells of a marker or a voice at an engine sample, where there are 8,000 a second.
    fn hear(post: &Post, sample: u64, voice: bool) {
        hear_of(post, sample, voice, None);
    }

    fn hear_of(post: &Post, sample: u64, voice: bool, id: Option<u64>) {
        let (at, instant) = (sample as f64 / 8000.0, Due { sample, fraction: 0 });
        let place = "t1";
        let what = match voice {
            true => Happening::Voice {
                name: "tap",
                place,
                level: 1.0,
                felt: None,
                duration: 0.1,
                fields: &[],
                own: &[],
                pitched: false,
            },
            false => Happening::Marker("m"),
        };
        // Markers have one.
        let id = if voice { id } else { id.or(Some(1 << 32)) };
        post.hear(&Heard { at, instant, origin: None, id, what });
    }

    #[test]
    fn what_becomes_of_a_voice_is_told_with_its_name() {
        let (post, mut fetch) = post();
        hear_of(&post, 100, true, Some(7));
        for (sample, id, what) in [
            (200, 7, Happening::Touch(Motion::Detune, 2.0_f64.powf(1.5 / 12.0) - 1.0)),
            (210, 7, Happening::Touch(Motion::Detune, -0.5)),
            (220, 7, Happening::Touch(Motion::Detune, 0.0)),
            (300, 7, Happening::Touch(Motion::Pressure, 0.634)),
            (310, 7, Happening::Touch(Motion::Timbre, 0.5)),
            (320, 8, Happening::Touch(Motion::Pressure, 1.0)),
            (400, 7, Happening::Release),
            (500, 8, Happening::Release),
        ] {
            let instant = Due { sample, fraction: 0 };
            post.hear(&Heard { at: sample as f64 / 8000.0, instant, origin: None, id: Some(id), what });
        }
        let told: Vec<String> = fetch.events(501, 501.0 / 8000.0, None).into_iter().map(|h| h.text).collect();
        let rest = [
            "tap on t1 is bent by +1.5 semitones",
            "tap on t1 is bent by -12 semitones",
            "tap on t1 is bent back",
            "tap on t1 is pressed to 63 %",
            "tap on t1 is tilted to 50 %",
            "a voice is pressed to 100 %",
            "tap on t1 is released",
            "a voice is released",
        ];
        assert_eq!(told[1..], rest);
        // However many there were.
        for id in 0..3 * KNOWN as u64 {
            hear_of(&post, 600, true, Some(id));
            fetch.events(700, 0.1, None);
        }
        assert!(fetch.voices.len() <= KNOWN);
    }

    #[test]
    fn what_is_called_off_before_its_time_is_not_shown() {
        let (post, mut fetch) = post();
        for (sample, id) in [(100, 0x10), (200, 0x11), (300, 0x12), (300, 0x20)] {
            hear_of(&post, sample, sample > 100, Some(id));
        }
        assert_eq!(fetch.events(101, 101.0 / 8000.0, None).len(), 1);
        // From 250 on, and of 0x10 to 0x1f alone.
        let instant = Due { sample: 250, fraction: 0 };
        post.hear(&Heard {
            at: 250.0 / 8000.0,
            instant,
            origin: None,
            id: Some(0x1a),
            what: Happening::Cancel(4),
        });
        let shown = fetch.events(8000, 1.0, None);
        let at: Vec<f64> = shown.iter().map(|happened| happened.at * 8000.0).collect();
        assert_eq!(at, [200.0, 300.0], "{shown:?}");
    }

    #[test]
    fn what_midi_had_started_falls_silent_once() {
        let (post, mut fetch) = post();
        for (sample, id) in [(100, 0x10), (100, 0x20), (300, 0x10), (300, 0x20)] {
            let instant = Due { sample, fraction: 0 };
            let what = Happening::Silence(4);
            post.hear(&Heard { at: sample as f64 / 8000.0, instant, origin: None, id: Some(id), what });
        }
        hear(&post, 300, false);
        let at: Vec<f64> =
            fetch.events(8000, 1.0, None).iter().map(|happened| happened.at * 8000.0).collect();
        assert_eq!(at, [100.0, 300.0, 300.0]);
    }

    #[test]
    fn what_is_played_ahead_is_shown_when_its_time_has_come_and_in_its_order() {
        let (post, mut fetch) = post();
        // 50 ms ahead, and out of order: a pattern is fed before somebody presses a key.
        [400, 800, 240, 1200].iter().for_each(|sample| hear(&post, *sample, false));
        assert_eq!(fetch.events(240, 0.03, None).len(), 0, "not before it is computed");
        post.say(Mood::Bad, "trouble");
        let mut shown = Vec::new();
        for clock in (241..1600).step_by(16) {
            // What is told as of now, in between, is behind all that was told, and before all that is told next.
            let before = fetch.now();
            let events = fetch.events(clock, clock as f64 / 8000.0, None);
            assert!(
                events.iter().all(|happened| (before..=fetch.now()).contains(&happened.at)),
                "{events:?}"
            );
            assert!(fetch.now() <= clock as f64 / 8000.0);
            if clock == 497 {
                post.say(Mood::Good, "all is well");
            }
            shown.extend(events);
        }
        assert!(shown.is_sorted_by(|a, b| a.at <= b.at), "{shown:?}");
        let count = |text: &str| shown.iter().filter(|happened| happened.text == text).count();
        assert_eq!(
            (count("marker m"), count("trouble"), count("all is well"), shown.len()),
            (4, 1, 1, 6),
            "{shown:?}"
        );
        assert_eq!(shown.last().unwrap().at, 0.15, "to the bit as the patterns have it");
    }

    #[test]
    fn what_plays_behind_a_shut_gate_says_so() {
        let (post, mut fetch) = post();
        (0..4).for_each(|n| hear(&post, 10 * n, n != 2));
        let told = |fetch: &mut PostBox, clock, unfelt| -> Vec<bool> {
            let events = fetch.events(clock, 0.0, unfelt);
            events.iter().map(|h| h.text.ends_with(", not felt: the output is shut")).collect()
        };
        assert_eq!(told(&mut fetch, 5, None), [false]);
        assert_eq!(told(&mut fetch, 25, Some("the output is shut")), [true, true], "a marker as well");
        assert_eq!(told(&mut fetch, 35, None), [false]);
    }

    #[test]
    fn where_a_control_was_sent_last_is_known_whatever_is_shown() {
        let (post, fetch) = post();
        for n in 0..3 * WAITING {
            let what = Happening::Control("depth", n as f64);
            post.hear(&Heard { at: 0.0, instant: Due::default(), origin: None, id: None, what });
        }
        assert_eq!(fetch.moved().into_iter().collect::<Vec<_>>(), [("depth".to_string(), 3071.0)]);
        assert!(fetch.moved().is_empty());
    }
}
