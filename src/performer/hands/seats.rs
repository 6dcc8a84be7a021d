//! Whose hands are whose: ports apart, a song apart from all of them, and what becomes of where things stood.

use super::super::staged::{self, HEAD, Kept, VOICE};
use super::{Message, Performer, When};
use crate::engine::event::Event;
use crate::midi::Channel;
use crate::performer::{Happening, Outlet};

const RATE: f64 = 8000.0;

const CONTROL: &str = "[control.depth]\ndefault = 0.5\n";

fn controller(number: u8, value: u8) -> Message {
    Message::Controller { channel: Channel::FIRST, number, value }
}

fn at(seconds: f64) -> When {
    When::of_seconds(seconds, RATE)
}

fn say(performer: &mut Performer, port: u16, message: Message) {
    performer.midi(at(0.1), port, message, &mut Kept::default()).unwrap();
}

/// A performer with a binding, and where its control stands.
fn bound(bind: &str) -> Performer {
    staged::performer(&patch(bind), 1)
}

fn patch(bind: &str) -> String {
    let voice = VOICE.replace("frequency = 100", "frequency = 100, amplitude = \"depth\"");
    format!("{HEAD}{CONTROL}[[bind]]\ncontrol = \"depth\"\n{bind}\n{voice}")
}

fn stands(performer: &Performer) -> f64 {
    performer.targets[0]
}

/// A wheel and a key spring back when nobody touches them: what they moved goes with them, and a fader stays where it is.
#[test]
fn what_a_wheel_or_a_pressed_key_has_moved_goes_back_with_it() {
    let channel = Channel::FIRST;
    let bend = Message::Bend { channel, bend: 8191 };
    let channel_pressure = Message::ChannelPressure { channel, pressure: 127 };
    let key_pressure = Message::PolyPressure { channel, note: 60, pressure: 127 };
    let zone = [controller(101, 0), controller(100, 6), controller(6, 3)];
    for (from, message, rest) in
        [("bend", bend, 0.5), ("pressure", channel_pressure, 0.0), ("pressure", key_pressure, 0.0)]
    {
        let ends: [&dyn Fn(&mut Performer); 4] = [
            &|performer| say(performer, 0, controller(121, 0)),
            &|performer| say(performer, 0, Message::Reset),
            &|performer| performer.midi_gone(at(0.2), 0, &mut Kept::default()).unwrap(),
            &|performer| zone.into_iter().for_each(|message| say(performer, 0, message)),
        ];
        for (n, end) in ends.into_iter().enumerate() {
            for pickup in ["", "pickup = false"] {
                let mut performer = bound(&format!("from = \"midi.{from}\"\n{pickup}"));
                if !pickup.is_empty() || from == "bend" {
                    say(&mut performer, 0, message);
                } else {
                    // Picked up from where it stands.
                    let half = Message::ChannelPressure { channel, pressure: 64 };
                    [half, message].into_iter().for_each(|message| say(&mut performer, 0, message));
                }
                if from == "bend" && pickup.is_empty() {
                    // The wheel's middle is where the control stands.
                    let middle = Message::Bend { channel, bend: 0 };
                    [middle, message].into_iter().for_each(|message| say(&mut performer, 0, message));
                }
                assert_eq!(stands(&performer), 1.0, "{from} {pickup}");
                // Nothing of another port.
                say(&mut performer, 1, controller(121, 0));
                assert_eq!(stands(&performer), 1.0, "{from} {pickup}");
                end(&mut performer);
                assert_eq!(stands(&performer), rest, "{from} {pickup} {n}");
            }
        }
    }
    let mut performer = bound("from = \"midi.controller 7\"\npickup = false");
    say(&mut performer, 0, controller(7, 127));
    performer.midi_gone(at(0.2), 0, &mut Kept::default()).unwrap();
    assert_eq!(stands(&performer), 1.0, "a fader stays");
}

/// A fader that has its control in hand is one of one port and one channel; and once its port was away, nobody knows where it stands.
#[test]
fn each_fader_picks_up_for_itself() {
    let near = |performer: &Performer, value: u8| {
        let off = stands(performer) - f64::from(value) / 127.0;
        assert!(off.abs() < 1e-9, "{} for {value}/127", stands(performer));
    };
    let mut performer = bound("from = \"midi.controller 7\"");
    [64, 100].into_iter().for_each(|value| say(&mut performer, 0, controller(7, value)));
    near(&performer, 100);
    // Another keyboard, and another channel of this one.
    say(&mut performer, 1, controller(7, 20));
    let other = Message::Controller { channel: Channel::new(4).unwrap(), number: 7, value: 20 };
    say(&mut performer, 0, other);
    near(&performer, 100);
    // Another comes there and has it; the first waits where it is.
    [100, 30].into_iter().for_each(|value| say(&mut performer, 1, controller(7, value)));
    near(&performer, 30);
    say(&mut performer, 0, controller(7, 101));
    near(&performer, 30);
    // It was moved while it was away.
    performer.midi_gone(at(0.2), 1, &mut Kept::default()).unwrap();
    say(&mut performer, 1, controller(7, 90));
    near(&performer, 30);
    [30, 50].into_iter().for_each(|value| say(&mut performer, 1, controller(7, value)));
    near(&performer, 50);
}

/// A reset says that a wheel is at rest: where it has the control, that goes with it; where it waits, nothing moves, then or with what comes next.
#[test]
fn a_reset_moves_only_what_was_in_hand() {
    let mut performer = bound("from = \"midi.controller 1\"");
    for value in [127, 126] {
        say(&mut performer, 0, controller(1, value));
        say(&mut performer, 0, controller(121, 0));
        assert_eq!(stands(&performer), 0.5, "it waited");
    }
    [20, 64, 90].into_iter().for_each(|value| say(&mut performer, 0, controller(1, value)));
    say(&mut performer, 0, controller(121, 0));
    assert_eq!(stands(&performer), 0.0);
    say(&mut performer, 0, controller(1, 9));
    assert_eq!(stands(&performer), 9.0 / 127.0, "it is still in hand");
}

/// To save a patch lets go of no fader.
#[test]
fn a_patch_that_is_saved_leaves_faders_in_hand() {
    let bind = "from = \"midi.controller 7\"";
    let mut performer = bound(bind);
    [64, 100].into_iter().for_each(|value| say(&mut performer, 0, controller(7, value)));
    let more = format!("from = \"midi.controller 8\"\n[[bind]]\ncontrol = \"depth\"\n{bind}");
    staged::save(&mut performer, &patch(&more), 1);
    say(&mut performer, 0, controller(7, 110));
    assert_eq!(stands(&performer), 110.0 / 127.0);
    // One that is new has never had it.
    say(&mut performer, 0, controller(8, 3));
    assert_eq!(stands(&performer), 110.0 / 127.0);
}

/// A foot switch that was down when its cable was pulled sets something off the next time that it is pressed, and so behind a reset.
#[test]
fn a_switch_is_up_when_its_port_is_back() {
    let text = format!("{HEAD}{VOICE}[[trigger]]\non = \"midi.controller 80 rises 0.5\"\nplay = \"v\"\n");
    let mut performer = staged::performer(&text, 1);
    let mut kept = Kept::default();
    let mut presses = |performer: &mut Performer| {
        kept.0.clear();
        performer.midi(at(0.1), 0, controller(80, 127), &mut kept).unwrap();
        kept.0.iter().filter(|(_, event)| matches!(event, Event::Play(_))).count()
    };
    assert_eq!((presses(&mut performer), presses(&mut performer)), (1, 0));
    performer.midi_gone(at(0.2), 0, &mut Kept::default()).unwrap();
    assert_eq!((presses(&mut performer), presses(&mut performer)), (1, 0));
    say(&mut performer, 0, Message::Reset);
    assert_eq!((presses(&mut performer), presses(&mut performer)), (1, 0));
}

/// A song and a player on the same channel: neither ends what the other has begun, presses its pedal or lets go of it.
#[test]
fn a_song_has_hands_of_its_own() {
    let text = format!("{HEAD}{VOICE}[[trigger]]\non = \"midi.note\"\nplay = \"v\"\n");
    let mut performer = staged::performer(&text, 1);
    let (channel, note) = (Channel::FIRST, 60);
    let (on, off) =
        (Message::NoteOn { channel, note, velocity: 90 }, Message::NoteOff { channel, note, velocity: 0 });
    performer.play_song(
        [
            (0.0, controller(120, 0)),
            (0.1, on),
            (0.2, controller(64, 127)),
            (0.3, off),
            (0.4, controller(64, 0)),
        ],
        1.0,
    );
    let mut kept = Kept::default();
    let ended = |performer: &mut Performer, kept: &mut Kept, until: f64| {
        performer.feed((until * RATE) as u64, kept);
        let played =
            kept.0.iter().filter_map(|(_, e)| if let Event::Play(p) = e { Some(p.id) } else { None });
        let played: Vec<u64> = played.collect();
        let released =
            kept.0.iter().filter_map(|(_, e)| if let Event::Release(id) = e { Some(*id) } else { None });
        let released: Vec<u64> = released.collect();
        let silenced = kept.0.iter().filter(|(_, e)| matches!(e, Event::Silence(..))).count();
        (played, released, silenced)
    };
    // The player's key goes down before the song says anything.
    performer.midi(at(0.0), 0, on, &mut kept).unwrap();
    let (played, released, silenced) = ended(&mut performer, &mut kept, 0.05);
    assert_eq!((played.len(), released.len(), silenced), (1, 0, 0), "its panic is its own");
    let player = played[0];
    let (played, ..) = ended(&mut performer, &mut kept, 0.15);
    let song = played[1];
    // The song's pedal holds nothing of the player's.
    ended(&mut performer, &mut kept, 0.25);
    performer.midi(at(0.25), 0, off, &mut kept).unwrap();
    assert_eq!(ended(&mut performer, &mut kept, 0.28).1, [player]);
    // It goes down again, and the keyboard goes while the song sounds: that goes on.
    performer.midi(at(0.28), 0, on, &mut kept).unwrap();
    performer.midi_gone(at(0.29), 0, &mut kept).unwrap();
    let (played, released, _) = ended(&mut performer, &mut kept, 0.35);
    assert_eq!((played.len(), released.contains(&song)), (3, false), "its pedal holds it");
    assert!(ended(&mut performer, &mut kept, 0.45).1.contains(&song));
    // The song's end lets go of nothing of the player's.
    performer.midi(at(0.5), 0, on, &mut kept).unwrap();
    let before = ended(&mut performer, &mut kept, 0.6).1.len();
    assert_eq!(ended(&mut performer, &mut kept, 2.0).1.len(), before);
}

/// That a control waits is told for each that does.
#[test]
fn each_fader_that_waits_is_told_of() {
    let mut performer = bound("from = \"midi.controller 7\"");
    let told = std::sync::Arc::new(std::sync::Mutex::new(0));
    let counts = std::sync::Arc::clone(&told);
    performer.listen(Box::new(move |heard| {
        *counts.lock().unwrap() += i32::from(matches!(heard.what, Happening::Waits { .. }));
    }));
    let mut kept = Kept::default();
    for (port, value) in [(0, 100), (0, 101), (1, 100), (1, 101)] {
        performer.midi(at(0.1), port, controller(7, value), &mut kept).unwrap();
    }
    assert_eq!((*told.lock().unwrap(), kept.clock()), (2, 1));
}

/// Where somebody else has moved the control since, what goes to rest leaves it alone, whether it would have had to be picked up or not.
#[test]
fn what_somebody_else_has_moved_since_stays() {
    for pickup in ["", "pickup = false"] {
        let mut performer = bound(&format!("from = \"midi.bend\"\n{pickup}"));
        let channel = Channel::FIRST;
        for bend in [0, 8191] {
            say(&mut performer, 0, Message::Bend { channel, bend });
        }
        assert_eq!(stands(&performer), 1.0);
        performer.set(at(0.15), "depth", 0.2, &mut Kept::default()).unwrap();
        performer.midi_gone(at(0.2), 0, &mut Kept::default()).unwrap();
        assert_eq!(stands(&performer), 0.2, "{pickup}");
    }
}

/// A song's wheel is at rest when the song is over.
#[test]
fn a_song_that_ends_bent_leaves_nothing_bent() {
    let mut performer = bound("from = \"midi.bend\"");
    performer.play_song([(0.1, Message::Bend { channel: Channel::FIRST, bend: -8192 })], 0.5);
    performer.feed((0.3 * RATE) as u64, &mut Kept::default());
    assert_eq!(stands(&performer), 0.0);
    performer.feed((0.6 * RATE) as u64, &mut Kept::default());
    assert_eq!(stands(&performer), 0.5);
}

/// Notes of MPE have a channel each, and all are of one hand: what one has picked up the next one moves on.
#[test]
fn fingers_of_mpe_are_one_hand() {
    let mut performer = bound("from = \"midi.bend\"");
    let bend = |number: u8, bend: i16| Message::Bend { channel: Channel::new(number).unwrap(), bend };
    let zone = [controller(101, 0), controller(100, 6), controller(6, 3)];
    zone.into_iter().for_each(|message| say(&mut performer, 0, message));
    [bend(1, 0), bend(1, 2000), bend(2, 2100)]
        .into_iter()
        .for_each(|message| say(&mut performer, 0, message));
    let wanted = 0.5 + 0.5 * 2100.0 / 8191.0;
    assert!((stands(&performer) - wanted).abs() < 1e-9, "{}", stands(&performer));
    // Beyond the zone it is another's.
    say(&mut performer, 0, bend(9, -4000));
    assert!((stands(&performer) - wanted).abs() < 1e-9, "{}", stands(&performer));
}

/// A fader that may have been moved unseen passes nothing where it stands; only a switch that goes to its end has.
#[test]
fn a_fader_that_is_back_passes_nothing_by_that() {
    let text = format!(
        "{HEAD}{VOICE}[[trigger]]\non = \"midi.controller 7 rises 0.5\"\nplay = \"v\"\n\
         [[trigger]]\non = \"midi.controller 80 falls 0.5\"\nplay = \"v\"\n"
    );
    let mut performer = staged::performer(&text, 1);
    let mut kept = Kept::default();
    let mut sets_off = |performer: &mut Performer, number: u8, value: u8| {
        kept.0.clear();
        performer.midi(at(0.1), 0, controller(number, value), &mut kept).unwrap();
        !kept.0.is_empty()
    };
    assert!(sets_off(&mut performer, 7, 100));
    assert!(!sets_off(&mut performer, 80, 127) && sets_off(&mut performer, 80, 0));
    assert!(!sets_off(&mut performer, 80, 127));
    performer.midi_gone(at(0.2), 0, &mut Kept::default()).unwrap();
    assert!(!sets_off(&mut performer, 7, 101), "it has not passed anything");
    assert!(!sets_off(&mut performer, 7, 20) && sets_off(&mut performer, 7, 90));
    assert!(sets_off(&mut performer, 80, 0), "a pedal that closes when it is let go of");
}
