use super::super::staged::{self, HEAD, Kept};
use super::{Message, MidiCounts, Note, Outlet, Performer, When, wheel};
use crate::engine::event::{Event, Play, Source};
use crate::midi::{Channel, pitch};
use crate::node::motion::Motion;
use crate::schedule::Instant;
use crate::space::spot::Spot;

const PATCH: &str = "[control.depth]\ndefault = 0.5\nrange = [0, 2]\n\
    [voice.v]\noutput = \"o\"\n[voice.v.nodes]\ns = { type = \"sine\", frequency = \"event.frequency\" }\n\
    e = { type = \"envelope\" }\no = { type = \"multiply\", inputs = [\"s\", \"e\", \"depth\"] }\n\
    [pattern.p]\nevents = [{ at = 0.25, voice = \"v\", level = 0.5 }]\n";

fn performer(rest: &str) -> (Performer, Kept) {
    (staged::performer(&format!("{HEAD}{PATCH}{rest}"), 8), Kept::default())
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
    assert_eq!((first.level, first.duration, first.place), (1.0, f64::INFINITY, Spot::Row(0)));
    // Two octaves and nine semitones below 440 Hz.
    assert!((first.own[0] - 440.0 * f64::exp2(-33.0 / 12.0)).abs() < 1e-9);
    // Sixteen keys on eight tactors: the last two share the last.
    assert_eq!((last.level, last.place), (64.0 / 127.0, Spot::Row(7)));
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

/// Eight tactors: each has an eighth of the fader's way, and a note stays where it began.
#[test]
fn a_note_begins_where_a_controller_stands_then() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nspread = \"controller\"\ncontroller = 10\n",
    );
    let mut place = |moves: Option<u8>, number: u8| {
        kept.0.clear();
        if let Some(value) = moves {
            send(&mut performer, &mut kept, 0.1, controller(10, value));
            assert!(kept.0.is_empty(), "what sounds stays");
        }
        send(&mut performer, &mut kept, 0.1, on(number, 60, 100));
        match kept.0.iter().find_map(|(_, e)| if let Event::Play(play) = e { Some(play.place) } else { None })
        {
            Some(Spot::Row(row)) => row,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(place(None, 0), 0, "one that has not moved");
    let rows: Vec<u32> = [0, 15, 16, 63, 64, 111, 112, 127].map(|value| place(Some(value), 0)).into();
    assert_eq!(rows, [0, 0, 1, 3, 4, 6, 7, 7]);
    assert_eq!(place(None, 1), 0, "another channel has a fader of its own");
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
    assert_eq!((play.level, play.duration, play.own[0], play.place), (0.5, 0.2, 100.0, Spot::Row(2)));
    // It ends by itself.
    send(&mut performer, &mut kept, 0.1, off(9, 60));
    assert_eq!(kept.0.len(), 1);
}

/// A curve of velocity is written as the level.
#[test]
fn velocity_has_the_curve_that_is_said() {
    for exponent in [0.5, 1.0, 2.0] {
        let (mut performer, mut kept) = performer(&format!(
            "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nset = {{ level = \"0.1 + 0.9 * pow(velocity, {exponent})\" }}\n"
        ));
        for velocity in [1, 64, 127] {
            send(&mut performer, &mut kept, 0.0, on(0, velocity, velocity));
            let Some((_, Event::Play(play))) = kept.0.last() else { panic!("{:?}", kept.0) };
            let exact = 0.1 + 0.9 * (f64::from(velocity) / 127.0).powf(exponent);
            assert!((play.level - exact).abs() < 1e-9, "{velocity}^{exponent}: {} {exact}", play.level);
        }
    }
}

/// How strongly something is felt goes before the velocity of a key, whether a trigger says it or the voice does.
#[test]
fn what_is_felt_goes_before_velocity() {
    let (mut performer, mut kept) = performer(
        "[voice.q]\noutput = \"s\"\ndefaults = { felt = 15 }\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n\
         [[trigger]]\non = \"midi.note\"\nchannel = 1\nplay = \"q\"\nset = { felt = \"10 + 40 * velocity\" }\n\
         [[trigger]]\non = \"midi.note\"\nchannel = 2\nplay = \"q\"\n\
         [[trigger]]\non = \"midi.note\"\nchannel = 3\nplay = \"q\"\nset = { level = \"velocity\" }\n\
         [[trigger]]\non = \"osc./f\"\nplay = \"q\"\nset = { felt = \"value\" }\n",
    );
    for channel in 0..3 {
        send(&mut performer, &mut kept, 0.0, on(channel, 60, 127));
    }
    let at = |seconds| When::of_seconds(seconds, 8000.0);
    for value in [22.0, 1e9] {
        performer.osc(at(1.0), "/f", &[value], &mut kept).unwrap();
    }
    performer.osc(at(1.0), "/f", &[f64::NAN, 22.0], &mut kept).unwrap();
    // What is no number is not played, and told.
    for value in [f64::NAN, f64::INFINITY] {
        let said = performer.osc(at(1.0), "/f", &[value], &mut kept).unwrap_err().to_string();
        assert!(said.contains(&format!("`felt` of a trigger of `q` comes to {value}")), "{said}");
    }
    let strengths: Vec<(f64, Option<f64>)> = kept
        .0
        .iter()
        .filter_map(
            |(_, event)| if let Event::Play(play) = event { Some((play.level, play.felt)) } else { None },
        )
        .collect();
    assert_eq!(
        strengths,
        [50.0, 15.0, -1.0, 22.0, 120.0, 22.0].map(|felt| (1.0, (felt > 0.0).then_some(felt)))
    );
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
         [[trigger]]\non = \"osc./go\"\nplay = \"v\"\nset = { level = \"value\" }\n\
         [[trigger]]\non = \"osc./push\"\nplay = \"v\"\n",
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
    // A button that is let go sends 0, which sets off only what asks for the number.
    let played = kept.0.len();
    for (address, plays) in [("/push", [1, 1, 0]), ("/go", [1, 1, 1])] {
        for (values, plays) in [&[][..], &[1.0], &[0.0]].into_iter().zip(plays) {
            let before = kept.0.len();
            assert_eq!(performer.osc(at(3.9), address, values, &mut kept), Ok(true));
            assert_eq!(kept.0.len() - before, plays, "{address} {values:?}");
        }
    }
    kept.0.truncate(played);
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

/// Plays `v`, and the endless pattern `e`.
const BOTH: &str = "[pattern.e]\nrepeat = { every = 0.01 }\nevents = [{ at = 0, voice = \"v\", level = 0.25 }]\n\
    [[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [0, 63]\n\
    [[trigger]]\non = \"midi.note\"\nplay = \"e\"\nnotes = [64, 127]\n";

/// Which of the plays that were sent a silence or release meant, in order of sending, and the rest of what was sent.
fn ended(kept: &Kept) -> Vec<usize> {
    let plays: Vec<Play> =
        kept.0.iter().filter_map(|(_, e)| if let Event::Play(p) = e { Some(*p) } else { None }).collect();
    let falls = |play: &Play| {
        kept.0.iter().any(|(_, event)| match event {
            Event::Release(id) => *id == play.id,
            Event::Silence(id, bits) => play.is_of(*id, *bits),
            Event::ReleaseAll => true,
            _ => false,
        })
    };
    plays.iter().enumerate().filter(|(_, play)| falls(play)).map(|(n, _)| n).collect()
}

/// Each of the 120, bound and as a trigger, alone.
#[test]
fn any_controller_can_be_bound_and_set_something_off() {
    for number in 0..120 {
        let (mut performer, mut kept) = performer(&format!(
            "[[bind]]\nfrom = \"midi.controller {number}\"\ncontrol = \"depth\"\npickup = false\n\
             [[trigger]]\non = \"midi.controller {number} rises 0.5\"\nplay = \"v\"\n"
        ));
        send(&mut performer, &mut kept, 0.1, controller(number, 127));
        assert_eq!(performer.targets[0], 2.0, "{number}");
        assert!(kept.0.iter().any(|(_, e)| matches!(e, Event::Play(_))), "{number}");
        send(&mut performer, &mut kept, 0.2, controller(number, 0));
        assert_eq!(performer.targets[0], 0.0, "{number}");
    }
}

/// The control goes from 0 to 2.
#[test]
fn an_endless_knob_moves_a_control_on_from_where_it_stands() {
    let (mut performer, mut kept) = performer(
        "[[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"depth\"\nencoder = \"twos-complement\"\nrange = [0.5, 1.5]\n\
         [[bind]]\nfrom = \"midi.controller 8\"\ncontrol = \"depth\"\nencoder = \"binary-offset\"\nstep = 0.25\n",
    );
    let mut turn = |number, value, wanted: f64| {
        send(&mut performer, &mut kept, 0.1, controller(number, value));
        assert!((performer.targets[0] - wanted).abs() < 1e-12, "{} for {wanted}", performer.targets[0]);
    };
    turn(8, 0, 0.0);
    // From below its range it begins at that, and beyond its end it does not go.
    turn(7, 1, 0.51);
    turn(7, 10, 0.61);
    turn(7, 127, 0.6);
    turn(7, 0, 0.6);
    turn(7, 63, 1.23);
    turn(7, 63, 1.5);
    turn(8, 65, 2.0);
    turn(7, 127, 1.49);
    // What is a lower half to faders is a controller of its own to these.
    turn(39, 127, 1.49);
    turn(7, 127, 1.48);
}

#[test]
fn a_lower_half_that_is_bound_itself_is_its_own() {
    let (mut performer, mut kept) =
        performer("[[bind]]\nfrom = \"midi.controller 39\"\ncontrol = \"depth\"\npickup = false\n");
    for (upper, lower) in [(127, 0), (0, 127), (64, 1)] {
        send(&mut performer, &mut kept, 0.1, controller(7, upper));
        send(&mut performer, &mut kept, 0.1, controller(39, lower));
        assert_eq!(performer.targets[0], 2.0 * f64::from(lower) / 127.0);
    }
}

#[test]
fn the_pedal_holds_keys_unless_the_patch_hears_it() {
    let keys = "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\n";
    let pedal = "[[trigger]]\non = \"midi.controller 64 rises 0.5\"\nplay = \"p\"\n";
    let play = |performer: &mut Performer, kept: &mut Kept| {
        kept.0.clear();
        for message in [controller(64, 127), on(0, 60, 100), off(0, 60)] {
            send(performer, kept, 0.1, message);
        }
        ended(kept).len()
    };
    let (mut performer, mut kept) = performer(keys);
    assert_eq!(play(&mut performer, &mut kept), 0);
    // What is saved while it is down lets go of what it holds.
    staged::save(&mut performer, &format!("{HEAD}{PATCH}{keys}{pedal}"), 8);
    performer.midi_settle(When::of_seconds(0.2, 8000.0), &mut kept).unwrap();
    assert_eq!(ended(&kept).len(), 1);
    send(&mut performer, &mut kept, 0.3, controller(64, 0));
    assert_eq!(play(&mut performer, &mut kept), 1);
    assert_eq!(performer.patterns().count(), 1, "the pedal played its pattern");
}

#[test]
fn what_midi_says_in_vain_is_counted() {
    let (mut performer, mut kept) = performer("[[trigger]]\non = \"midi.note\"\nplay = \"v\"\n");
    let parameter = [(99, 1), (98, 2), (6, 9), (38, 9), (101, 127), (100, 127), (6, 1)];
    parameter.into_iter().for_each(|(n, value)| send(&mut performer, &mut kept, 0.1, controller(n, value)));
    send(&mut performer, &mut kept, 0.1, off(0, 60));
    send(&mut performer, &mut kept, 0.1, controller(122, 0));
    let counts = MidiCounts {
        messages: 9,
        unmatched: 1,
        unmeant: 1,
        unheard: 2,
        left_out: 1,
        ..MidiCounts::default()
    };
    assert_eq!(performer.midi_counts(), counts);
}

#[test]
fn notes_and_programs_that_no_trigger_plays_are_counted() {
    let triggers = "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [36, 59]\nchannel = 1\n\
                    [[trigger]]\non = \"midi.program 3\"\nplay = \"v\"\n";
    let (mut performer, mut kept) = performer(triggers);
    let program = |program| Message::Program { channel: Channel::FIRST, program };
    let sent = [on(0, 59, 9), off(0, 59), on(0, 60, 9), off(0, 60), on(1, 59, 9), program(3), program(4)];
    sent.into_iter().for_each(|message| send(&mut performer, &mut kept, 0.1, message));
    let counts = MidiCounts { messages: 7, unplayed: 3, ..MidiCounts::default() };
    assert_eq!(performer.midi_counts(), counts, "above its notes, on another channel, another program");
}

#[test]
fn notes_of_a_song_of_which_only_the_clock_is_heard_are_not_missed() {
    let follows = "[pattern.f]\ntime = \"beats\"\ntempo = 120\nclock = \"midi\"\nevents = [{ at = 0, voice = \"v\" }]\n";
    let note = "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [36, 59]\n";
    let controller = "[[trigger]]\non = \"midi.controller 64 rises 0.5\"\nplay = \"v\"\n";
    let key = "[[trigger]]\non = \"key.1\"\nplay = \"v\"\n";
    for (rest, unplayed) in [
        (follows.to_string(), 0),
        (format!("{follows}{key}"), 0),
        (format!("{follows}{note}"), 1),
        (format!("{follows}{controller}"), 2),
        (key.to_string(), 2),
    ] {
        let (mut performer, mut kept) = performer(&rest);
        for message in [on(0, 48, 9), Message::Program { channel: Channel::FIRST, program: 3 }] {
            send(&mut performer, &mut kept, 0.1, message);
        }
        assert_eq!(performer.midi_counts().unplayed, unplayed, "{rest}");
    }
}

#[test]
fn all_notes_off_silences_its_channel_alone() {
    for number in 123..128 {
        let (mut performer, mut kept) = performer(BOTH);
        performer.start_pattern(When::of_seconds(0.0, 8000.0), "p").unwrap();
        send(&mut performer, &mut kept, 0.1, controller(64, 127));
        for (channel, note) in [(0, 60), (1, 60), (0, 61)] {
            send(&mut performer, &mut kept, 0.1, on(channel, note, 100));
        }
        send(&mut performer, &mut kept, 0.1, off(0, 61));
        performer.midi(When::of_seconds(0.1, 8000.0), 1, on(0, 60, 100), &mut kept).unwrap();
        send(&mut performer, &mut kept, 0.1, on(0, 70, 100));
        send(&mut performer, &mut kept, 0.1, on(1, 70, 100));
        send(&mut performer, &mut kept, 0.2, controller(number, 0));
        assert_eq!(ended(&kept), [0, 2], "the pedal keeps none");
        assert!(kept.0.iter().all(|(_, event)| matches!(event, Event::Play(_) | Event::Silence(..))));
        // It stops at its time.
        performer.feed(1601, &mut kept);
        let playing: Vec<_> = performer.patterns().map(|(_, name)| name).collect();
        assert_eq!(playing, ["p", "e"], "that of the other channel");
    }
}

#[test]
fn all_sound_off_silences_what_its_channel_has_started_and_nothing_else() {
    let (mut performer, mut kept) = performer(&format!(
        "{BOTH}[[trigger]]\non = \"midi.program 3\"\nplay = \"v\"\nset = {{ duration = 60 }}\n"
    ));
    let at = |seconds| When::of_seconds(seconds, 8000.0);
    performer.start_pattern(at(0.1), "e").unwrap();
    performer.play(at(0.1), "v", &Note::default(), &mut kept).unwrap();
    // One that is let go of, one that the pedal holds, one of a program, one of a pattern.
    send(&mut performer, &mut kept, 0.1, on(0, 60, 100));
    send(&mut performer, &mut kept, 0.1, off(0, 60));
    send(&mut performer, &mut kept, 0.1, controller(64, 127));
    send(&mut performer, &mut kept, 0.1, on(0, 61, 100));
    send(&mut performer, &mut kept, 0.1, off(0, 61));
    send(&mut performer, &mut kept, 0.1, Message::Program { channel: channel(0), program: 3 });
    send(&mut performer, &mut kept, 0.1, on(1, 60, 100));
    performer.midi(at(0.1), 1, on(0, 60, 100), &mut kept).unwrap();
    kept.0.retain(|(_, event)| matches!(event, Event::Play(_)));
    send(&mut performer, &mut kept, 0.1, on(0, 70, 100));
    let before = kept.0.len();
    performer.feed(804, &mut kept);
    // One of each pattern, the program's first.
    assert_eq!(kept.0.len() - before, 2);
    send(&mut performer, &mut kept, 0.2, controller(120, 0));
    let sent = kept.0.len();
    assert_eq!(ended(&kept), [1, 2, 3, before + 1]);
    assert!(kept.0.iter().all(|(_, event)| matches!(event, Event::Play(_) | Event::Silence(..))));
    // Said again and again, it says nothing.
    (0..100).for_each(|_| send(&mut performer, &mut kept, 0.2, controller(120, 0)));
    send(&mut performer, &mut kept, 0.3, off(0, 70));
    assert_eq!(kept.0.len(), sent);
    assert_eq!(performer.patterns().filter(|(_, name)| *name == "e").count(), 1, "the program's goes on");
}

#[test]
fn a_reset_silences_what_its_port_has_started_and_nothing_else() {
    let (mut performer, mut kept) = performer(BOTH);
    let at = |seconds| When::of_seconds(seconds, 8000.0);
    performer.play(at(0.1), "v", &Note::default(), &mut kept).unwrap();
    performer.start_pattern(at(0.1), "e").unwrap();
    performer.midi(at(0.1), 1, on(0, 60, 100), &mut kept).unwrap();
    for channel in [0, 7, 15] {
        send(&mut performer, &mut kept, 0.1, on(channel, 60, 100));
    }
    send(&mut performer, &mut kept, 0.1, on(3, 70, 100));
    assert!(ended(&kept).is_empty());
    send(&mut performer, &mut kept, 0.4, Message::Reset);
    assert_eq!(ended(&kept), [2, 3, 4]);
    assert!(!kept.0.iter().any(|(_, event)| matches!(event, Event::ReleaseAll)));
    assert_eq!(performer.patterns().filter(|(_, name)| *name == "e").count(), 1);
    // The next note is a new beginning.
    send(&mut performer, &mut kept, 1.0, on(0, 60, 100));
    assert!(matches!(kept.0.last(), Some((_, Event::Play(_)))));
}

#[test]
fn a_key_holds_a_pattern_without_end_and_one_that_ends_plays_on() {
    let (mut performer, mut kept) = performer(&format!(
        "{BOTH}[[trigger]]\non = \"midi.note\"\nchannel = 16\nplay = \"p\"\n\
         [[trigger]]\non = \"key.1\"\nplay = \"e\"\n[[trigger]]\non = \"osc./e\"\nplay = \"e\"\n"
    ));
    let at = |seconds| When::of_seconds(seconds, 8000.0);
    let playing = |performer: &Performer| performer.patterns().filter(|(_, name)| *name == "e").count();
    let before = playing(&performer);
    send(&mut performer, &mut kept, 0.1, on(0, 70, 100));
    send(&mut performer, &mut kept, 0.1, on(0, 71, 100));
    assert_eq!(playing(&performer) - before, 2);
    send(&mut performer, &mut kept, 0.2, off(0, 70));
    assert_eq!(playing(&performer) - before, 2, "until then");
    performer.feed(1601, &mut kept);
    assert_eq!(playing(&performer) - before, 1);
    // The pedal is as good as a key.
    send(&mut performer, &mut kept, 0.2, controller(64, 127));
    send(&mut performer, &mut kept, 0.2, off(0, 71));
    assert_eq!(playing(&performer) - before, 1);
    send(&mut performer, &mut kept, 0.2, controller(64, 0));
    assert_eq!(playing(&performer) - before, 0);
    // Hits of no key begin it anew.
    for n in 0..50 {
        performer.key(at(0.3 + 0.01 * f64::from(n)), 1, &mut kept).unwrap();
        performer.osc(at(0.305 + 0.01 * f64::from(n)), "/e", &[], &mut kept).unwrap();
        performer.feed((8000.0 * (0.306 + 0.01 * f64::from(n))) as u64, &mut kept);
        assert_eq!(playing(&performer) - before, 1);
    }
    // A pattern that ends does so by itself.
    send(&mut performer, &mut kept, 1.0, on(15, 1, 100));
    send(&mut performer, &mut kept, 1.0, off(15, 1));
    assert_eq!(performer.patterns().filter(|(_, name)| *name == "p").count(), 1);
    performer.midi_gone(at(2.0), 0, &mut kept).unwrap();
    assert_eq!(performer.patterns().filter(|(_, name)| *name == "p").count(), 1);
}

#[test]
fn hostile_numbers_of_a_trigger_stay_within_what_a_file_could_say() {
    let (mut performer, mut kept) = performer(
        "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nset = { level = \"1 / (note - 60)\", duration = \"-1 / (note - 60)\", \
         frequency = \"log(0 - note)\" }\n",
    );
    // A level that is no number is told, and not played.
    let said = performer.midi(When::of_seconds(0.0, 8000.0), 0, on(0, 60, 100), &mut kept).unwrap_err();
    assert!(
        said.to_string().contains("`level` of a trigger of `v` comes to inf: nothing is played"),
        "{said}"
    );
    for note in [61, 59] {
        send(&mut performer, &mut kept, 0.0, on(0, note, 100));
    }
    for (_, event) in &kept.0 {
        let Event::Play(play) = event else { continue };
        assert!(
            (0.0..=100.0).contains(&play.level) && play.duration >= 0.0 && play.own[0].is_finite(),
            "{play:?}"
        );
    }
    assert_eq!(kept.0.len(), 2);
}

/// A voice that follows the wheel and the pressure, and one that follows nothing; the notes of a channel each.
const FOLLOWS: &str = "[voice.f]\nvoices = 64\noutput = \"o\"\n[voice.f.nodes]\n\
    s = { type = \"sine\", frequency = \"event.frequency * touch.bend\", amplitude = \"touch.pressure\" }\n\
    o = { type = \"multiply\", inputs = [\"s\", 1.0] }\n\
    [[trigger]]\non = \"midi.note\"\nplay = \"f\"\nset = { frequency = \"pitch\" }\n";
const AND_NOT: &str =
    "[[trigger]]\non = \"midi.note\"\nchannel = 5\nplay = \"v\"\nset = { frequency = \"pitch\" }\n";

fn bend(number: u8, bend: i16) -> Message {
    Message::Bend { channel: channel(number), bend }
}

/// What was sent, in order, voices by the order in which they began.
fn told(kept: &Kept) -> Vec<(f64, usize, Motion, f64)> {
    let mut ids = Vec::new();
    let mut told = Vec::new();
    for (at, event) in &kept.0 {
        match event {
            Event::Play(play) => ids.push(play.id),
            Event::Touch(to) => {
                let seconds = at.since(Instant::default()) / 8000.0;
                told.push((seconds, ids.iter().position(|id| *id == to.id).unwrap(), to.motion, to.value));
            }
            _ => {}
        }
    }
    told
}

fn near(found: &[(f64, usize, Motion, f64)], wanted: &[(f64, usize, Motion, f64)]) {
    let same = |a: &(f64, usize, Motion, f64), b: &(f64, usize, Motion, f64)| {
        (a.1, a.2) == (b.1, b.2) && (a.0 - b.0).abs() < 1e-9 && (a.3 - b.3).abs() < 1e-12
    };
    assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| same(a, b)), "{found:?}");
}

#[test]
fn the_wheel_bends_all_voices_of_its_channel_and_a_key_presses_its_own() {
    let (mut performer, mut kept) = performer(FOLLOWS);
    for (number, note) in [(0, 60), (0, 64), (1, 60)] {
        send(&mut performer, &mut kept, 0.0, on(number, note, 100));
    }
    assert_eq!(told(&kept), []);
    send(&mut performer, &mut kept, 0.1, bend(0, -8192));
    let down = Motion::detune(-2.0);
    near(&told(&kept), &[(0.1, 0, Motion::Detune, down), (0.1, 1, Motion::Detune, down)]);
    kept.0.retain(|(_, event)| matches!(event, Event::Play(_)));
    send(
        &mut performer,
        &mut kept,
        0.2,
        Message::PolyPressure { channel: channel(0), note: 64, pressure: 127 },
    );
    send(&mut performer, &mut kept, 0.3, Message::ChannelPressure { channel: channel(1), pressure: 127 });
    // No node hears the timbre.
    send(&mut performer, &mut kept, 0.4, controller(74, 3));
    near(&told(&kept), &[(0.2, 1, Motion::Pressure, 1.0), (0.3, 2, Motion::Pressure, 1.0)]);
    // A note that has ended is in no hand any more.
    send(&mut performer, &mut kept, 0.5, off(0, 60));
    kept.0.retain(|(_, event)| matches!(event, Event::Play(_)));
    send(&mut performer, &mut kept, 0.6, bend(0, 0));
    near(&told(&kept), &[(0.6, 1, Motion::Detune, 0.0)]);
}

#[test]
fn a_member_of_mpe_moves_its_note_and_the_manager_all() {
    let (mut performer, mut kept) = performer(FOLLOWS);
    for (number, value) in [(101, 0), (100, 6), (6, 15)] {
        send(&mut performer, &mut kept, 0.0, controller(number, value));
    }
    // What comes before the note is there when it begins, and the pitch that is set is that of the key.
    send(&mut performer, &mut kept, 0.0, bend(1, 2048));
    send(&mut performer, &mut kept, 0.1, on(1, 69, 100));
    send(&mut performer, &mut kept, 0.1, on(2, 57, 100));
    let plays: Vec<f64> = kept
        .0
        .iter()
        .filter_map(|(_, e)| if let Event::Play(p) = e { Some(p.own[0]) } else { None })
        .collect();
    assert_eq!(plays, [440.0, 220.0]);
    near(&told(&kept), &[(0.1, 0, Motion::Detune, Motion::detune(48.0 * 2048.0 / 8191.0))]);
    send(&mut performer, &mut kept, 0.2, bend(2, -4096));
    send(&mut performer, &mut kept, 0.3, bend(0, 8191));
    let (one, other) = (48.0 * 2048.0 / 8191.0, -24.0);
    near(
        &told(&kept)[1..],
        &[
            (0.2, 1, Motion::Detune, Motion::detune(other)),
            (0.3, 0, Motion::Detune, Motion::detune(one + 2.0)),
            (0.3, 1, Motion::Detune, Motion::detune(other + 2.0)),
        ],
    );
}

#[test]
fn a_voice_that_follows_nothing_begins_with_its_bend() {
    let (mut performer, mut kept) = performer(&format!("{FOLLOWS}{AND_NOT}"));
    send(&mut performer, &mut kept, 0.0, bend(4, 8191));
    send(&mut performer, &mut kept, 0.1, on(4, 69, 100));
    let plays: Vec<f64> = kept
        .0
        .iter()
        .filter_map(|(_, e)| if let Event::Play(p) = e { Some(p.own[0]) } else { None })
        .collect();
    assert_eq!(plays, [440.0, pitch::hertz(69, 2.0)]);
    near(&told(&kept), &[(0.1, 0, Motion::Detune, Motion::detune(2.0))]);
}

/// However fast a wheel moves, a voice is told once in a millisecond, and where it ends.
#[test]
fn a_storm_of_moves_is_thinned_and_its_end_is_told() {
    let (mut performer, mut kept) = performer(FOLLOWS);
    send(&mut performer, &mut kept, 0.0, on(0, 60, 100));
    for i in 0..10_000_i16 {
        send(&mut performer, &mut kept, 0.1 + f64::from(i) * 1e-5, bend(0, i / 2));
    }
    performer.feed(8000, &mut kept);
    let told = told(&kept);
    assert!((95..=102).contains(&told.len()), "{} times", told.len());
    assert!(told.windows(2).all(|pair| pair[1].0 - pair[0].0 > 0.00099), "{told:?}");
    let last = told.last().unwrap();
    assert!((last.3 - Motion::detune(2.0 * 4999.0 / 8191.0)).abs() < 1e-12 && last.0 < 0.2011);
    // Nothing more is to be told; and what is not told yet when the key goes up is told then.
    assert_eq!(performer.feed(16_000, &mut kept), None);
    let before = kept.0.len();
    send(&mut performer, &mut kept, 2.0, bend(0, 1));
    send(&mut performer, &mut kept, 2.0001, bend(0, 2));
    send(&mut performer, &mut kept, 2.0002, off(0, 60));
    let rest: Vec<_> = kept.0[before..].iter().map(|(_, event)| *event).collect();
    assert!(matches!(rest[..], [Event::Touch(_), Event::Touch(_), Event::Release(_)]), "{rest:?}");
}

/// An outlet with little room: what is played finds it, what moves waits.
#[test]
fn moves_leave_room_for_notes() {
    struct Tight(Kept, usize);
    impl Outlet for Tight {
        fn clock(&self) -> u64 {
            1
        }
        fn room(&self, _: Source) -> usize {
            self.1
        }
        fn send(&mut self, at: Instant, source: Source, event: Event) -> bool {
            self.0.send(at, source, event)
        }
    }
    let (mut performer, kept) = performer(FOLLOWS);
    let mut tight = Tight(kept, 100);
    let mut say = |tight: &mut Tight, seconds: f64, message: Message| {
        performer
            .midi(When::of_seconds(seconds, 8000.0), 0, message, tight)
            .unwrap_or_else(|p| panic!("{p}"));
    };
    say(&mut tight, 0.1, on(0, 60, 100));
    say(&mut tight, 0.2, bend(0, 8191));
    say(&mut tight, 0.3, bend(0, -8192));
    assert_eq!(tight.0.0.len(), 1, "the note alone");
    tight.1 = 1000;
    say(&mut tight, 0.4, controller(1, 3));
    near(&told(&tight.0), &[(0.4, 0, Motion::Detune, Motion::detune(-2.0))]);
}
