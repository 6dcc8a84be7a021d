use std::sync::Arc;

use super::{Message, Outlet, Performer, When, wheel};
use crate::engine::event::{Event, Source};
use crate::graph::scene::{Options, scene};
use crate::midi::Channel;
use crate::node::asset::NoAssets;
use crate::patch::Patch;
use crate::rig::Rig;
use crate::schedule::Instant;
use crate::text::Problem;

/// Keeps what it is sent.
#[derive(Default)]
struct Kept(Vec<(Instant, Event)>);

impl Outlet for Kept {
    fn clock(&self) -> u64 {
        1
    }
    fn room(&self, _: Source) -> usize {
        1000
    }
    fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
        self.0.push((at, event));
        true
    }
}

const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.depth]\ndefault = 0.5\nrange = [0, 2]\n\
    [voice.v]\noutput = \"o\"\n[voice.v.nodes]\ns = { type = \"sine\", frequency = \"event.frequency\" }\n\
    e = { type = \"envelope\" }\no = { type = \"multiply\", inputs = [\"s\", \"e\", \"depth\"] }\n\
    [pattern.p]\nevents = [{ at = 0.25, voice = \"v\", level = 0.5 }]\n";

fn performer(rest: &str) -> (Performer, Kept) {
    let patch = Patch::parse("t", format!("{HEAD}{rest}").as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::default_for(8);
    let options = Options { live: true, ..Options::default() };
    let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    let refuse = |_: &str| Err(Problem::of_file("no files here"));
    let performer = Performer::new(scene, Arc::new(patch), Arc::new(rig), Box::new(refuse));
    (performer.unwrap_or_else(|p| panic!("{p}")), Kept::default())
}

fn channel(number: u8) -> Channel {
    Channel::new(number).unwrap()
}

fn send(performer: &mut Performer, kept: &mut Kept, seconds: f64, message: Message) {
    performer.midi(When::of_seconds(seconds, 8000.0), 0, message, kept).unwrap_or_else(|p| panic!("{p}"));
}

fn on(number: u8, note: u8, velocity: u8) -> Message {
    Message::NoteOn { channel: channel(number), note, velocity }
}

fn off(number: u8, note: u8) -> Message {
    Message::NoteOff { channel: channel(number), note, velocity: 64 }
}

fn controller(number: u8, value: u8) -> Message {
    Message::Controller { channel: channel(0), number, value }
}

#[test]
fn a_key_holds_its_voice_and_gives_level_pitch_and_place() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [\"C2\", 51]\nspread = \"notes\"\n\
         set = { frequency = \"pitch\" }\n",
    );
    send(&mut performer, &mut kept, 0.5, on(0, 36, 127));
    // Beyond the keys that it listens to.
    send(&mut performer, &mut kept, 0.6, on(0, 52, 127));
    send(&mut performer, &mut kept, 0.6, on(0, 51, 64));
    let plays: Vec<_> = kept
        .0
        .iter()
        .filter_map(|(at, e)| if let Event::Play(p) = e { Some((at, p)) } else { None })
        .collect();
    let [(first_at, first), (_, last)] = plays[..] else { panic!("{plays:?}") };
    assert_eq!(*first_at, Instant::of_samples(4000.0));
    assert_eq!((first.level, first.duration, first.place), (1.0, f64::INFINITY, 0));
    // Two octaves and nine semitones below 440 Hz.
    assert!((first.own[0] - 440.0 * f64::exp2(-33.0 / 12.0)).abs() < 1e-9);
    // Sixteen keys on eight tactors: the last two share the last.
    assert_eq!((last.level, last.place), (64.0 / 127.0, 7));
    let (first, last) = (first.id, last.id);
    send(&mut performer, &mut kept, 1.0, off(0, 51));
    assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Release(last)));
    // The pedal holds the other.
    send(&mut performer, &mut kept, 1.0, controller(64, 127));
    let sent = kept.0.len();
    send(&mut performer, &mut kept, 1.1, off(0, 36));
    assert_eq!(kept.0.len(), sent);
    send(&mut performer, &mut kept, 1.2, controller(64, 0));
    assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Release(first)));
}

#[test]
fn what_is_said_goes_before_what_is_played() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nchannel = 10\nplace = \"t3\"\n\
         set = { level = \"velocity / 2\", duration = 0.2, frequency = \"40 + note\" }\n",
    );
    send(&mut performer, &mut kept, 0.0, on(0, 60, 100));
    assert!(kept.0.is_empty(), "channel 1 is not meant");
    send(&mut performer, &mut kept, 0.0, on(9, 60, 127));
    let Some((_, Event::Play(play))) = kept.0.first() else { panic!("{:?}", kept.0) };
    assert_eq!((play.level, play.duration, play.own[0], play.place), (0.5, 0.2, 100.0, 2));
    // It ends by itself.
    send(&mut performer, &mut kept, 0.1, off(9, 60));
    assert_eq!(kept.0.len(), 1);
}

#[test]
fn controllers_move_controls_from_where_they_stand() {
    let (mut performer, mut kept) = performer(
        "[[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"depth\"\n[[bind]]\nfrom = \"midi.bend\"\ncontrol = \"depth\"\n\
         range = [1.0, 0.0]\npickup = false\n",
    );
    // The control stands at a quarter of its range.
    send(&mut performer, &mut kept, 0.0, controller(7, 127));
    assert!(kept.0.is_empty());
    send(&mut performer, &mut kept, 0.1, controller(7, 0));
    send(&mut performer, &mut kept, 0.2, controller(7, 127));
    let values: Vec<f64> =
        kept.0.iter().map(|(_, e)| if let Event::Control(0, x) = e { *x } else { panic!("{e:?}") }).collect();
    assert_eq!(values, [0.0, 2.0]);
    let bend = |bend| Message::Bend { channel: channel(3), bend };
    for (to, value) in [(-8192, 1.0), (0, 0.5), (8191, 0.0)] {
        send(&mut performer, &mut kept, 0.3, bend(to));
        assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Control(0, value)));
    }
    assert_eq!([wheel(-8192), wheel(0), wheel(8191)], [0.0, 0.5, 1.0]);
}

#[test]
fn patterns_start_by_key_program_controller_and_message() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"key.1\"\nplay = \"p\"\n[[trigger]]\non = \"midi.program 3\"\nplay = \"p\"\n\
         [[trigger]]\non = \"midi.controller 80 rises 0.5\"\nplay = \"p\"\nset = { gain = \"value\", rate = 2 }\n\
         [[trigger]]\non = \"osc./go\"\nplay = \"v\"\nset = { level = \"value\" }\n",
    );
    let at = |seconds| When::of_seconds(seconds, 8000.0);
    performer.key(at(1.0), 1, &mut kept).unwrap();
    performer.key(at(1.0), 2, &mut kept).unwrap();
    send(&mut performer, &mut kept, 2.0, Message::Program { channel: channel(0), program: 3 });
    send(&mut performer, &mut kept, 3.0, controller(80, 127));
    // It has risen already.
    send(&mut performer, &mut kept, 3.1, controller(80, 126));
    assert_eq!(performer.osc(at(4.0), "/go", &[0.25], &mut kept), Ok(true));
    assert_eq!(performer.osc(at(4.0), "/gone", &[], &mut kept), Ok(false));
    performer.feed(40_000, &mut kept);
    let mut plays: Vec<(f64, f64)> = kept
        .0
        .iter()
        .filter_map(|(at, e)| match e {
            Event::Play(p) => Some((at.since(Instant::default()) / 8000.0, p.level)),
            _ => None,
        })
        .collect();
    plays.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(plays, [(1.25, 0.5), (2.25, 0.5), (3.125, 0.5), (4.0, 0.25)]);
}

#[test]
fn a_panic_stops_patterns_and_voices() {
    let (mut performer, mut kept) = performer("[[trigger]]\non = \"midi.note\"\nplay = \"v\"\n");
    performer.start_pattern(When::of_seconds(0.1, 8000.0), "p").unwrap();
    send(&mut performer, &mut kept, 0.1, on(0, 60, 100));
    send(&mut performer, &mut kept, 0.2, controller(120, 0));
    assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::ReleaseAll));
    let sent = kept.0.len();
    send(&mut performer, &mut kept, 0.3, off(0, 60));
    performer.feed(80_000, &mut kept);
    assert_eq!(kept.0.len(), sent, "nothing is released twice, and nothing plays any more");
}

#[test]
fn hostile_numbers_of_a_trigger_stay_within_what_a_file_could_say() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nset = { level = \"1 / (note - 60)\", duration = \"-1 / (note - 60)\", \
         frequency = \"log(0 - note)\" }\n",
    );
    for note in [60, 61, 59] {
        send(&mut performer, &mut kept, 0.0, on(0, note, 100));
    }
    for (_, event) in &kept.0 {
        let Event::Play(play) = event else { continue };
        assert!(
            (0.0..=100.0).contains(&play.level) && play.duration >= 0.0 && play.own[0].is_finite(),
            "{play:?}"
        );
    }
    assert_eq!(kept.0.len(), 3);
}
