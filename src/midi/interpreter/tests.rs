//! Against the specifications' own words, and for any messages at all.

use std::collections::HashMap;

use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

use super::{Counts, Interpreter, RELEASE};
use crate::midi::message::tests::messages;
use crate::midi::{Channel, Claims, Expression, Gesture, Message, Parser, Reason, Transport, What, Zone};

/// What bytes mean, all of them at the same time.
fn hear(interpreter: &mut Interpreter, bytes: &[u8]) -> Vec<Gesture> {
    let (mut parser, mut out) = (Parser::new(), Vec::new());
    parser.read(bytes, &mut |message| interpreter.message(message, &mut |g| out.push(g)));
    out
}

fn all(bytes: &[u8]) -> Vec<Gesture> {
    hear(&mut Interpreter::new(), bytes)
}

fn channel(number: u8) -> Channel {
    Channel::new(number - 1).unwrap()
}

fn on(key: u32, number: u8, note: u8, expression: Expression) -> Gesture {
    Gesture::NoteOn { key, channel: channel(number), note, velocity: 1.0, expression }
}

fn off(key: u32, velocity: u8) -> Gesture {
    Gesture::NoteOff { key, velocity: f64::from(velocity) / 127.0 }
}

fn bend(key: u32, value: f64) -> Gesture {
    Gesture::Move { key, what: What::Bend, value }
}

const REST: Expression = Expression::REST;

/// Channels that are at rest, from 1.
fn rest(channels: std::ops::RangeInclusive<u8>) -> Vec<Gesture> {
    channels.map(|number| Gesture::Rest { channel: channel(number) }).collect()
}

#[test]
fn every_note_on_is_a_sounding_and_the_oldest_ends_first() {
    let gestures = all(&[0x90, 60, 127, 60, 127, 61, 127, 0x80, 60, 1, 60, 2, 61, 127]);
    let expected =
        [on(0, 1, 60, REST), on(1, 1, 60, REST), on(2, 1, 61, REST), off(0, 1), off(1, 2), off(2, 127)];
    assert_eq!(gestures, expected);
    assert_eq!(all(&[0x90, 60, 127, 60, 0]), [on(0, 1, 60, REST), off(0, 64)], "velocity 0");
    let mut interpreter = Interpreter::new();
    assert_eq!(hear(&mut interpreter, &[0x91, 60, 127, 0x80, 60, 1]).len(), 1, "on another channel");
    assert_eq!(interpreter.counts(), Counts { unmatched: 1, ..Counts::default() });
}

#[test]
fn the_sustain_pedal_keeps_note_offs_back() {
    let mut i = Interpreter::new();
    assert_eq!(hear(&mut i, &[0xB0, 64, 64, 0x90, 60, 127, 61, 127, 0x80, 60, 9]).len(), 2);
    assert_eq!(hear(&mut i, &[0xB1, 64, 0]), [], "another channel's pedal");
    assert_eq!(hear(&mut i, &[0xB0, 64, 63]), [off(0, 9)], "with the velocity that it had");
    assert_eq!(hear(&mut i, &[0x80, 61, 1]), [off(1, 1)]);
    // Struck again while it is held: the key that goes up is the newer one's.
    let struck = hear(&mut i, &[0xB0, 64, 127, 0x90, 60, 127, 0x80, 60, 1, 0x90, 60, 127, 0xB0, 64, 0]);
    assert_eq!(struck, [on(2, 1, 60, REST), on(3, 1, 60, REST), off(2, 1)]);
    assert_eq!(hear(&mut i, &[0x80, 60, 2]), [off(3, 2)]);
    hear(&mut i, &[0xB0, 64, 127, 0x90, 60, 127, 0x80, 60, 1, 0x90, 60, 127, 0x80, 60, 2]);
    assert_eq!(hear(&mut i, &[0xB0, 64, 0]), [off(4, 1), off(5, 2)], "each note-off has its own");
}

#[test]
fn the_sostenuto_pedal_keeps_what_was_down() {
    let mut i = Interpreter::new();
    hear(&mut i, &[0x90, 60, 127, 0xB0, 66, 127, 0x90, 61, 127]);
    assert_eq!(hear(&mut i, &[0x80, 60, 1, 61, 2]), [off(1, 2)], "61 came later");
    assert_eq!(hear(&mut i, &[0xB0, 66, 100]), [], "still down");
    assert_eq!(hear(&mut i, &[0xB0, 66, 0]), [off(0, 1)]);
    hear(&mut i, &[0x90, 60, 127, 0xB0, 66, 127, 64, 127, 0x80, 60, 1]);
    assert_eq!(hear(&mut i, &[0xB0, 66, 0]), [], "the other pedal holds it");
    assert_eq!(hear(&mut i, &[0xB0, 66, 127, 64, 0]), [off(2, 1)], "its key was up when the pedal went down");
}

#[test]
fn bends_count_before_the_note_and_after() {
    let mut i = Interpreter::new();
    let expression = Expression { bend: 2.0, pressure: 1.0, timbre: 1.0 };
    assert_eq!(hear(&mut i, &[0xE0, 127, 127, 0xD0, 127]), []);
    hear(&mut i, &[0xB0, 74, 127]);
    assert_eq!(hear(&mut i, &[0x90, 60, 127]), [on(0, 1, 60, expression)]);
    assert_eq!(hear(&mut i, &[0xE0, 0, 0]), [bend(0, -2.0)]);
    assert_eq!(hear(&mut i, &[0xE1, 127, 127]), [], "another channel");
    // RPN 0: 7 semitones at once, then 25 cents more, then one less.
    let range = hear(&mut i, &[0xB0, 101, 0, 100, 0, 6, 7, 38, 25, 97, 0]);
    assert_eq!(range, [bend(0, -7.0), bend(0, -7.25), bend(0, -7.24)]);
    assert_eq!(hear(&mut i, &[0xE0, 0, 64]), [bend(0, 0.0)]);
    assert_eq!(hear(&mut i, &[0xE0, 0, 64]), [], "only what changes");
}

#[test]
fn pressure_of_a_key_is_its_own() {
    let mut i = Interpreter::new();
    hear(&mut i, &[0x90, 60, 127, 61, 127]);
    let pressure = |key, value: u8| {
        let value = f64::from(value) / 127.0;
        Gesture::Move { key, what: What::Pressure, value }
    };
    assert_eq!(hear(&mut i, &[0xA0, 61, 50]), [pressure(1, 50)]);
    assert_eq!(hear(&mut i, &[0xD0, 20]), [pressure(0, 20)], "61 is pressed harder");
    assert_eq!(hear(&mut i, &[0xD0, 127]), [pressure(0, 127), pressure(1, 127)]);
    assert_eq!(hear(&mut i, &[0xD0, 0]), [pressure(0, 0), pressure(1, 50)]);
    assert_eq!(hear(&mut i, &[0xA0, 62, 50]), []);
    assert_eq!(i.counts().unmatched, 1);
    assert_eq!(
        hear(&mut i, &[0xB0, 64, 127, 0x80, 61, 1, 0xA0, 61, 99]),
        [],
        "the pedal holds it, and no finger"
    );
    assert_eq!(i.counts().unmatched, 2);
}

/// RPN 6 on a manager.
fn zone(status: u8, members: u8) -> [u8; 9] {
    [status, 101, 0, status, 100, 6, status, 6, members]
}

#[test]
fn in_a_zone_each_note_has_its_own_bend_and_the_manager_adds() {
    let mut i = Interpreter::new();
    hear(&mut i, &[0xE2, 0, 0, 0xD2, 127, 0xB2, 74, 127]);
    assert_eq!(hear(&mut i, &zone(0xB0, 3)), rest(1..=4));
    assert_eq!(
        hear(&mut i, &[0x92, 60, 127, 0x82, 60, 1]),
        [on(0, 3, 60, REST), off(0, 1)],
        "at rest in the zone"
    );
    let mut i = Interpreter::new();
    hear(&mut i, &zone(0xB0, 3));
    // Channel 2 by a quarter of its 48 semitones downwards, the manager by both of its own up, before and after the notes.
    hear(&mut i, &[0xE1, 0, 48, 0xE0, 127, 127]);
    let bent = |bend| Expression { bend, ..REST };
    assert_eq!(
        hear(&mut i, &[0x91, 60, 127, 0x92, 60, 127]),
        [on(0, 2, 60, bent(-10.0)), on(1, 3, 60, bent(2.0))]
    );
    assert_eq!(hear(&mut i, &[0x90, 61, 127, 0x95, 62, 127]), [on(2, 1, 61, bent(2.0)), on(3, 6, 62, REST)]);
    let wider = hear(&mut i, &[0xB0, 101, 0, 100, 0, 6, 4]);
    assert_eq!(wider, [bend(0, -8.0), bend(1, 4.0), bend(2, 4.0)], "the manager's range");
    let middle = hear(&mut i, &[0xE0, 0, 64]);
    assert_eq!(middle, [bend(0, -12.0), bend(1, 0.0), bend(2, 0.0)]);
    assert_eq!(hear(&mut i, &[0xE2, 127, 127]), [bend(1, 48.0)]);
    // A range for one member is for all.
    assert_eq!(hear(&mut i, &[0xB3, 101, 0, 100, 0, 6, 24]), [bend(0, -6.0), bend(1, 24.0)]);
    // Pressure and timbre: per note, and of all.
    let moved = |key, what, value: u8| Gesture::Move { key, what, value: f64::from(value) / 127.0 };
    assert_eq!(hear(&mut i, &[0xD1, 9]), [moved(0, What::Pressure, 9)]);
    assert_eq!(hear(&mut i, &[0xB1, 74, 74]), [moved(0, What::Timbre, 74)], "no ordinary controller there");
    let of_all = hear(&mut i, &[0xB0, 74, 54]);
    assert_eq!(
        of_all[1..],
        [moved(0, What::Timbre, 64), moved(1, What::Timbre, 54), moved(2, What::Timbre, 54)]
    );
    assert_eq!(hear(&mut i, &[0xD0, 5]), [moved(1, What::Pressure, 5), moved(2, What::Pressure, 5)]);
    // The manager's pedal holds the notes of members.
    assert_eq!(hear(&mut i, &[0xB0, 64, 127, 0x81, 60, 1]), []);
    assert_eq!(hear(&mut i, &[0xB0, 64, 0]), [off(0, 1)]);
    // A smaller zone: all that sounded on its channels ends, what did not belong to it goes on.
    assert_eq!(hear(&mut i, &zone(0xB0, 1)), [vec![off(1, 64), off(2, 64)], rest(1..=4)].concat());
    let fresh = hear(&mut i, &[0x92, 60, 127, 0xE2, 127, 127]);
    assert_eq!(fresh, [on(4, 3, 60, REST), bend(4, 2.0)], "channel 3 is an ordinary one again");
    assert_eq!(hear(&mut i, &zone(0xB3, 1)), []);
    assert_eq!(hear(&mut i, &zone(0xB0, 16)), []);
    assert_eq!(i.counts(), Counts { left_out: 2, ..Counts::default() });
}

#[test]
fn the_upper_zone_and_a_managers_panic() {
    let mut i = Interpreter::new();
    i.set_zone(Zone::Upper, 2, &mut |_| ());
    hear(&mut i, &[0x9E, 60, 127, 0x9D, 60, 127, 0x9C, 60, 127]);
    assert_eq!(hear(&mut i, &[0xEE, 127, 127, 0xED, 0, 0]), [bend(0, 48.0), bend(1, -48.0)]);
    let panic = |number| Gesture::Panic { reason: Reason::AllSoundOff, channel: Some(channel(number)) };
    assert_eq!(hear(&mut i, &[0xBF, 120, 0]), [panic(14), panic(15), panic(16)]);
    assert_eq!(i.sounding(), 1);
}

#[test]
fn numbered_parameters_and_programs() {
    let first = Channel::FIRST;
    let parameter =
        |value, fine| Gesture::Parameter { channel: first, registered: false, number: 130, value, fine };
    let expected = [parameter(1.0, false), parameter(1.0, true), parameter(16_382.0 / 16_383.0, true)];
    assert_eq!(all(&[0xB0, 99, 1, 98, 2, 6, 127, 38, 127, 97, 0]), expected);
    let mut i = Interpreter::new();
    assert_eq!(hear(&mut i, &[0xB0, 6, 1, 99, 1, 6, 1, 98, 1, 96, 1, 101, 127, 100, 127, 6, 1]), []);
    assert_eq!(i.counts(), Counts { unmeant: 4, ..Counts::default() });
    let program = Gesture::Program { channel: channel(2), bank: 2 << 7 | 3, program: 7 };
    assert_eq!(all(&[0xB1, 0, 2, 32, 3, 0xC1, 7]), [program]);
}

#[test]
fn controllers_come_as_they_move() {
    let controller =
        |number, value, fine| Gesture::Controller { channel: Channel::FIRST, number, value, fine };
    let expected =
        [controller(7, 1.0, false), controller(7, 0.0, false), controller(7, 127.0 / 16_383.0, true)];
    assert_eq!(all(&[0xB0, 7, 127, 7, 0, 39, 127]), expected);
    assert_eq!(all(&[0xB0, 64, 127, 66, 127, 0, 1, 32, 1, 122, 0]), []);
}

#[test]
fn all_sound_off_and_reset_name_the_channel() {
    let mut i = Interpreter::new();
    hear(&mut i, &[0xB0, 64, 127, 0x90, 60, 127, 0x91, 60, 127]);
    let expected = [Gesture::Panic { reason: Reason::AllSoundOff, channel: Some(Channel::FIRST) }];
    assert_eq!(hear(&mut i, &[0xB0, 120, 0]), expected);
    assert_eq!(i.sounding(), 1);
    assert_eq!(hear(&mut i, &[0x80, 60, 1, 0xB0, 64, 0]), [], "it is gone");
    let mut i = Interpreter::new();
    hear(&mut i, &zone(0xB0, 3));
    hear(&mut i, &[0x90, 60, 127, 0xE1, 127, 127]);
    let panic = vec![Gesture::Panic { reason: Reason::Reset, channel: None }];
    assert_eq!(hear(&mut i, &[0xFF]), [rest(1..=16), panic].concat());
    assert_eq!(
        hear(&mut i, &[0x91, 60, 127]),
        [on(1, 2, 60, REST)],
        "wheels and zones are as after switching on"
    );
}

#[test]
fn all_notes_off_is_a_panic_of_its_channel_pedals_or_not() {
    let panic = |number| Gesture::Panic { reason: Reason::AllNotesOff, channel: Some(channel(number)) };
    for number in [123, 124, 125, 126, 127] {
        let mut i = Interpreter::new();
        hear(&mut i, &[0xB0, 64, 127, 66, 127, 0x90, 60, 127, 62, 127, 0x80, 62, 1, 0x91, 60, 127]);
        assert_eq!(hear(&mut i, &[0xB0, number, 0]), [panic(1)]);
        assert_eq!((i.sounding(), i.counts()), (1, Counts::default()));
        assert_eq!(hear(&mut i, &[0xB0, 64, 0]), [], "nothing is left to be let go of");
    }
    // That of a manager is for its zone.
    let mut i = Interpreter::new();
    hear(&mut i, &zone(0xB0, 3));
    hear(&mut i, &[0x91, 60, 127, 0x93, 60, 127, 0x94, 60, 127]);
    assert_eq!(hear(&mut i, &[0xB0, 123, 0]), [1, 2, 3, 4].map(panic));
    assert_eq!(i.sounding(), 1);
}

#[test]
fn what_is_claimed_says_where_it_stands_and_means_nothing_else() {
    let claims = |numbers: &[u8]| {
        let mut claims = Claims::default();
        numbers.iter().for_each(|number| claims.add(*number, Some(Channel::FIRST)));
        claims
    };
    let controller =
        |number, value: f64| Gesture::Controller { channel: Channel::FIRST, number, value, fine: false };
    let mut i = Interpreter::new();
    i.claim(&claims(&[64, 66, 98, 99, 6]));
    let bytes = [0xB0, 64, 127, 66, 127, 99, 127, 98, 127, 6, 127];
    assert_eq!(hear(&mut i, &bytes), [64, 66, 99, 98, 6].map(|n| controller(n, 1.0)));
    assert_eq!(hear(&mut i, &[0x90, 60, 127, 0x80, 60, 1]).len(), 2, "no pedal holds it");
    hear(&mut i, &[0xB1, 64, 127, 0x91, 60, 127]);
    assert_eq!(hear(&mut i, &[0x81, 60, 1]), [], "on another channel it is one");
    // A system reset leaves it so.
    hear(&mut i, &[0xFF]);
    assert_eq!(hear(&mut i, &[0xB0, 64, 0]), [controller(64, 0.0)]);
    // Once it is bound, a pedal that is down holds nothing any more; once it is not, it does so again.
    let mut i = Interpreter::new();
    hear(&mut i, &[0xB0, 64, 127, 0x90, 60, 127, 0x80, 60, 1]);
    i.claim(&claims(&[64]));
    let mut out = Vec::new();
    i.settle(&mut |gesture| out.push(gesture));
    assert_eq!(out, [off(0, 1)]);
    i.claim(&claims(&[]));
    assert_eq!(hear(&mut i, &[0x90, 60, 127, 0x80, 60, 1]).len(), 1);
    // Timbre is heard on a member, and stays timbre.
    let mut i = Interpreter::new();
    hear(&mut i, &zone(0xB0, 3));
    let mut all = Claims::default();
    all.add(74, None);
    i.claim(&all);
    hear(&mut i, &[0x91, 60, 127]);
    let timbre = Gesture::Move { key: 0, what: What::Timbre, value: 1.0 };
    let told = Gesture::Controller { channel: channel(2), number: 74, value: 1.0, fine: false };
    assert_eq!(hear(&mut i, &[0xB1, 74, 127]), [told, timbre]);
}

#[test]
fn reset_all_controllers_is_rp_015() {
    let mut i = Interpreter::new();
    hear(
        &mut i,
        &[0xB0, 64, 127, 1, 5, 0xE0, 0, 0, 0xD0, 9, 0x90, 60, 127, 61, 127, 0xA0, 61, 99, 0x80, 60, 1],
    );
    let gestures = hear(&mut i, &[0xB0, 121, 0]);
    let moved = Gesture::Move { key: 1, what: What::Pressure, value: 0.0 };
    let controller = Gesture::Controller { channel: Channel::FIRST, number: 1, value: 0.0, fine: false };
    assert_eq!(gestures, [controller, rest(1..=1)[0], off(0, 1), bend(1, 0.0), moved]);
}

#[test]
fn what_the_song_does() {
    let transport = |what| Gesture::Transport { what };
    let expected = [
        transport(Transport::Start),
        transport(Transport::Stop),
        Gesture::Position { beats: 32.25 },
        transport(Transport::Continue),
    ];
    assert_eq!(all(&[0xFA, 0xFC, 0xF2, 1, 1, 0xFB]), expected);
    assert_eq!(all(&[0xF8, 0xF8]), [], "its clocks count for those who follow them");
}

#[test]
fn a_port_that_vanished_holds_nothing() {
    let mut i = Interpreter::new();
    hear(&mut i, &zone(0xB0, 1));
    hear(&mut i, &[0xB0, 64, 127, 0xE1, 0, 0, 0x91, 60, 127, 0x81, 60, 5, 0x91, 61, 127]);
    let mut out = Vec::new();
    i.let_go(&mut |g| out.push(g));
    assert_eq!(out, [vec![off(0, 5), off(1, 64)], rest(1..=16)].concat());
    i.settle(&mut |g| panic!("{g:?}"));
    assert_eq!(hear(&mut i, &[0x91, 60, 127, 0xE1, 127, 127]), [on(2, 2, 60, REST), bend(2, 48.0)]);
    assert_eq!(hear(&mut i, &[0x81, 60, 1]), [off(2, 1)], "no pedal is down");
}

/// Messages that meet often: few notes, few channels, all controllers.
fn narrow(message: Message, which: u8) -> Message {
    let few = [Channel::FIRST, channel(2), channel(15), Channel::LAST][usize::from(which % 4)];
    let bytes = message.bytes();
    let mut bytes = bytes.to_vec();
    if bytes[0] < 0xF0 {
        bytes[0] = bytes[0] & 0xF0 | few.index() as u8;
        if bytes[0] < 0xB0 {
            bytes[1] &= 3;
        }
    }
    Message::parse(&bytes).unwrap()
}

proptest! {
    #[test]
    fn whatever_comes_gestures_make_sense(
        sequence in proptest::collection::vec((messages(), any::<u8>(), any::<bool>()), 0..400),
        zones in proptest::collection::vec(0_u8..16, 2),
    ) {
        let mut i = Interpreter::new();
        i.set_zone(Zone::Lower, zones[0], &mut |_| ());
        i.set_zone(Zone::Upper, zones[1], &mut |_| ());
        let mut sounding: HashMap<u32, Channel> = HashMap::new();
        let mut wrong = None;
        let mut follow = |g: Gesture| {
            let fine = match g {
                Gesture::NoteOn { key, channel, note, velocity, expression: e } => {
                    sounding.insert(key, channel).is_none()
                        && note < 128
                        && velocity > 0.0
                        && velocity <= 1.0
                        && e.bend.abs() <= 260.0
                        && (0.0..=1.0).contains(&e.pressure)
                        && (0.0..=1.0).contains(&e.timbre)
                }
                Gesture::NoteOff { key, velocity } => {
                    sounding.remove(&key).is_some() && (0.0..=1.0).contains(&velocity)
                }
                Gesture::Move { key, what, value } => {
                    sounding.contains_key(&key)
                        && if what == What::Bend { value.abs() <= 260.0 } else { (0.0..=1.0).contains(&value) }
                }
                Gesture::Controller { number, value, .. } => number < 120 && (0.0..=1.0).contains(&value),
                Gesture::Parameter { number, value, .. } => number < 16_383 && (0.0..=1.0).contains(&value),
                Gesture::Panic { channel, .. } => {
                    sounding.retain(|_, on| channel.is_some_and(|c| c != *on));
                    true
                }
                _ => true,
            };
            if !fine {
                wrong = Some(g);
            }
        };
        for (message, which, twice) in sequence {
            i.message(narrow(message, which), &mut follow);
            if twice {
                i.settle(&mut follow);
            }
        }
        let left = i.sounding();
        i.let_go(&mut follow);
        prop_assert_eq!(wrong, None);
        prop_assert!(sounding.is_empty(), "{:?}", sounding);
        prop_assert!(left <= crate::midi::sounding::MOST);
        prop_assert_eq!(i.sounding(), 0);
    }
}

#[test]
fn too_many_notes_end_the_oldest() {
    let mut i = Interpreter::new();
    for _ in 0..crate::midi::sounding::MOST {
        hear(&mut i, &[0x90, 60, 127]);
    }
    let next = hear(&mut i, &[0x90, 61, 127]);
    assert_eq!(next[0], Gesture::NoteOff { key: 0, velocity: RELEASE });
    assert_eq!((i.counts().stolen, i.sounding()), (1, crate::midi::sounding::MOST));
}
