//! Files made by hand, against the definitions.

use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

use super::{MOST_BYTES, MOST_WARNINGS, Mark, Song, Warnings};
use crate::midi::{Channel, Message};
use crate::text::{Checked, Problems};

fn chunk(name: &[u8], data: &[u8]) -> Vec<u8> {
    [name, &(data.len() as u32).to_be_bytes(), data].concat()
}

fn file(format: u8, division: [u8; 2], tracks: &[&[u8]]) -> Vec<u8> {
    let header = [&[0, format][..], &(tracks.len() as u16).to_be_bytes(), &division].concat();
    let tracks: Vec<u8> = tracks.iter().flat_map(|t| chunk(b"MTrk", t)).collect();
    [chunk(b"MThd", &header), tracks].concat()
}

/// 480 ticks a quarter note.
const BEATS: [u8; 2] = [1, 224];
/// A quarter note of 480 ticks, as a delta time.
const QUARTER: [u8; 2] = [0x83, 0x60];
const END: [u8; 4] = [0, 0xFF, 0x2F, 0];

fn read(bytes: &[u8]) -> Result<Checked<Song>, Problems> {
    Song::read("song.mid", bytes)
}

/// A file that gives neither errors nor warnings.
fn song(bytes: &[u8]) -> Song {
    let Checked { value, warnings } = read(bytes).unwrap();
    assert_eq!(warnings.to_string(), "");
    value
}

/// A file that gives warnings, and what they say.
fn warned(bytes: &[u8]) -> (Song, String) {
    let Checked { value, warnings } = read(bytes).unwrap();
    assert!(
        warnings.list.iter().all(|w| !w.is_error() && w.what.contains("byte") && w.help.is_some()),
        "{warnings}"
    );
    (value, warnings.to_string())
}

fn on(note: u8) -> Message {
    Message::NoteOn { channel: Channel::FIRST, note, velocity: 1 }
}

fn times(song: &Song) -> Vec<f64> {
    song.messages.iter().map(|(seconds, _)| *seconds).collect()
}

/// A note after a delta time.
fn note(delta: &[u8], note: u8) -> Vec<u8> {
    [delta, &[0x90, note, 1]].concat()
}

#[test]
fn the_longest_pause_says_where_it_ends() {
    // Two quarter notes, then the longest delta time that there is.
    let far = [&note(&[0], 60)[..], &note(&QUARTER, 61), &note(&[0xFF, 0xFF, 0xFF, 0x7F], 62), &END].concat();
    let other = [&note(&[0], 60)[..], &END].concat();
    let song = song(&file(1, BEATS, &[&other, &far]));
    let pause = song.pause.unwrap();
    let seconds = f64::from((1 << 28) - 1) / 960.0;
    assert!((pause.seconds - seconds).abs() < 1e-6 && (song.seconds - seconds - 0.5).abs() < 1e-6);
    // A header of 14 bytes, a track of 8 + 8, the head of another, and notes of 4 and 5 bytes.
    assert_eq!((pause.track, pause.at), (1, 14 + 16 + 8 + 4 + 5));
}

#[test]
fn ticks_are_half_seconds_unless_a_tempo_says_otherwise() {
    let tempo = [0, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40]; // 1,000,000 µs
    let track = [&note(&QUARTER, 1)[..], &tempo, &note(&QUARTER, 2), &QUARTER, &END[1..]].concat();
    let found = song(&file(0, BEATS, &[&track]));
    assert_eq!(found.messages, [(0.5, on(1)), (1.5, on(2))]);
    assert_eq!((found.seconds, found.format), (2.5, 0));
    assert_eq!(found.tempi, [(0.5, 60.0)]);
}

#[test]
fn the_tempo_of_any_track_is_that_of_all() {
    let first = [&note(&[0], 1)[..], &note(&QUARTER, 2), &END].concat();
    let second = [&[0x81, 0x70, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40][..], &END].concat();
    let found = song(&file(1, BEATS, &[&first, &second]));
    assert_eq!(times(&found), [0.0, 0.25 + 0.5], "from the middle of the beat on twice as slow");
    let late = [&QUARTER[..], &[0xFF, 0x51, 3, 0x07, 0xA1, 0x20], &note(&QUARTER, 3), &END].concat();
    let found = song(&file(1, BEATS, &[&late, &second]));
    assert_eq!(times(&found), [0.25 + 0.5 + 0.5], "and at 120 again for the second beat");
    assert_eq!(found.tempi, [(0.25, 60.0), (0.75, 120.0)]);
    let found = song(&file(2, BEATS, &[&first, &second, &first]));
    assert_eq!(times(&found), [0.0, 0.5, 0.75, 1.25], "one piece after another, each with its own tempo");
    let tempi = vec![(0.5, 120.0), (0.75, 60.0), (0.75, 120.0)];
    assert_eq!((found.seconds, found.tempi), (1.25, tempi), "none has that of the one before");
}

#[test]
fn frames_have_no_tempo() {
    let tempo = [0, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40];
    let track = [&tempo[..], &note(&[100], 1), &END].concat();
    for (frames, ticks, second) in [(-24_i8, 4, 96.0), (-25, 40, 1_000.0), (-30, 80, 2_400.0)] {
        let found = song(&file(1, [frames as u8, ticks], &[&track]));
        assert_eq!(times(&found), [100.0 / second], "{frames}");
        assert_eq!(found.tempi, []);
    }
    let found = song(&file(1, [-29_i8 as u8, 100], &[&track]));
    assert!((times(&found)[0] - 1.001 / 30.0).abs() < 1e-15, "drop frame: one frame");
}

#[test]
fn an_hour_of_changing_tempo_is_exact() {
    // A new tempo every 7 ticks; the sum is kept in whole microseconds / 96, beside the map.
    let (mut track, mut units, mut expected) = (Vec::new(), 0_u128, Vec::new());
    let mut tempo = 500_000_u32;
    let mut seed = 1_u32;
    while units < 3_600_000_000 * 96 {
        units += 7 * u128::from(tempo);
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        tempo = 100_000 + (seed >> 12);
        track.extend([7, 0xFF, 0x51, 3]);
        track.extend(&tempo.to_be_bytes()[1..]);
        track.extend([0, 0x90, 60, 1]);
        expected.push(units);
    }
    track.extend(END);
    let found = song(&file(0, [0, 96], &[&track]));
    assert!(expected.len() > 10_000 && found.seconds > 3_600.0);
    assert_eq!(found.messages.len(), expected.len());
    for ((seconds, _), units) in found.messages.iter().zip(expected) {
        // Whole seconds apart from the rest, so that the reference has no rounding to speak of.
        let (whole, rest) = (units / 96_000_000, units % 96_000_000);
        let difference = (seconds - whole as f64) - rest as f64 / 96e6;
        assert!(difference.abs() < 1e-9, "{seconds}: {difference}");
    }
}

#[test]
fn everything_that_a_track_says() {
    let mut track = vec![0, 0xFF, 3, 4];
    track.extend(b"walk");
    track.extend([0, 0xFF, 3, 1, b'x', 0, 0xFF, 6, 2, b'a', 0xE9]);
    track.extend([0, 0xF0, 3, 1, 2, 0xF7, 0, 0xF7, 1, 0xF8, 0, 0xFF, 0x7F, 1, 0]);
    track.extend([
        0, 0x80, 1, 2, 0, 0x91, 3, 4, 0, 5, 6, 0, 0xA2, 7, 8, 0, 0xB3, 9, 10, 0, 0xC4, 11, 0, 0xD5, 12,
    ]);
    track.extend([0, 0xEF, 0x7F, 0x7F, 0x83, 0x60, 0xFF, 7, 3]);
    track.extend("é!".as_bytes());
    track.extend(END);
    let found = song(&file(0, BEATS, &[&track]));
    let expected: [&[u8]; 8] = [
        &[0x80, 1, 2],
        &[0x91, 3, 4],
        &[0x91, 5, 6],
        &[0xA2, 7, 8],
        &[0xB3, 9, 10],
        &[0xC4, 11],
        &[0xD5, 12],
        &[0xEF, 127, 127],
    ];
    let messages: Vec<Vec<u8>> = found.messages.iter().map(|(_, m)| m.bytes().to_vec()).collect();
    assert_eq!(messages, expected);
    assert_eq!((found.tracks, found.exclusive), (vec![Some("walk".to_string())], 2));
    let mark = |seconds, cue, text: &str| Mark { seconds, track: 0, cue, text: text.into() };
    assert_eq!(found.marks, [mark(0.0, false, "aé"), mark(0.5, true, "é!")]);
}

#[test]
fn marks_of_all_tracks_are_in_the_order_of_time() {
    let late = [&QUARTER[..], &[0xFF, 6, 1, b'b'], &END].concat();
    let early = [&[0, 0xFF, 6, 1, b'a'][..], &QUARTER, &[0xFF, 6, 1, b'c'], &END].concat();
    let found = song(&file(1, BEATS, &[&late, &early]));
    let marks: Vec<_> = found.marks.iter().map(|m| (m.seconds, m.track, m.text.as_str())).collect();
    assert_eq!(marks, [(0.0, 1, "a"), (0.5, 0, "b"), (0.5, 1, "c")]);
}

#[test]
fn longer_headers_unknown_chunks_and_wrappers_are_read() {
    let track = [&note(&QUARTER, 1)[..], &END].concat();
    let header = chunk(b"MThd", &[0, 0, 0, 1, 1, 224, 9, 9, 9]);
    let bytes = [header, chunk(b"XFIH", &[1; 99]), chunk(b"MTrk", &track), chunk(b"XFKM", &[])].concat();
    assert_eq!(song(&bytes).messages, [(0.5, on(1))]);
    let plain = file(0, BEATS, &[&track]);
    let little = |n: usize| (n as u32).to_le_bytes();
    let inner = [b"RMIDINFO", &little(3)[..], &[1, 2, 3, 0], b"data", &little(plain.len()), &plain].concat();
    let wrapped = [b"RIFF", &little(inner.len())[..], &inner, b"after"].concat();
    let (mut inside, mut bare) = (song(&wrapped), song(&plain));
    // Its bytes stand as much farther on as the wrapper is long.
    let at = |song: &mut Song| song.pause.take().map_or(0, |pause| pause.at);
    assert_eq!(at(&mut inside) - at(&mut bare), 12 + 8 + 4 + 8);
    assert_eq!(inside, bare);
}

#[test]
fn offs_come_before_ons_at_one_time() {
    let first = [&[0, 0x90, 60, 1][..], &QUARTER, &[0x90, 60, 1], &END].concat();
    let second = [&QUARTER[..], &[0x80, 60, 9], &END].concat();
    let found = song(&file(1, BEATS, &[&first, &second]));
    let off = Message::NoteOff { channel: Channel::FIRST, note: 60, velocity: 9 };
    assert_eq!(found.messages, [(0.0, on(60)), (0.5, off), (0.5, on(60))]);
}

#[test]
fn what_is_damaged_is_said_and_the_rest_is_read() {
    let good = [&note(&[0], 1)[..], &END].concat();
    let whole = file(1, BEATS, &[&good, &good]);
    let (found, text) = warned(&whole[..whole.len() - 8]);
    assert_eq!(found.messages.len(), 1);
    assert!(text.contains("byte 30: the chunk `MTrk` claims 8 bytes, and the file has 0 more"), "{text}");
    assert_eq!(text.matches("byte ").count(), 1, "it says once that it was cut: {text}");
    // Within an event, and with one before it that is none.
    for left in 1..8 {
        let (found, text) = warned(&whole[..whole.len() - left]);
        assert_eq!(
            (found.messages.len(), text.matches("byte ").count()),
            (if left > 4 { 1 } else { 2 }, 1),
            "{text}"
        );
    }
    let longer = file(1, BEATS, &[&[&[0, 0x90, 1, 1, 0, 0xF8, 0][..], &[0; 9]].concat(), &good]);
    let (_, text) = warned(
        &file(1, BEATS, &[&[&[0, 0x90, 1, 1, 0x81, 0x81, 0x81, 0x81, 1][..], &[0; 9]].concat()])[..36],
    );
    assert!(text.contains("byte 26, track 1: a number has more than four bytes"), "{text}");
    let (_, text) = warned(&longer[..36]);
    assert!(
        text.contains("the file has 14 more") && text.contains("byte 26, track 1: this is no event"),
        "{text}"
    );
    let (_, text) = warned(&whole[..30]);
    assert!(text.contains("the header promises 2 tracks, and there are 1"), "{text}");
    let (_, text) = warned(&[&whole[..], b"MTr"].concat());
    assert!(text.contains("byte 46: 3 bytes at the end are no whole chunk"), "{text}");
    // In the first of two tracks; the second is read all the same. Offsets count from the first byte of the file.
    let cases: [(&[u8], &str); 9] = [
        (&[0, 0x90, 1, 1, 0, 0xF8], "byte 26, track 1: this is no event"),
        (&[0, 0x90, 1, 1, 0, 0x90, 0x80, 1], "byte 26, track 1: this is no event"),
        (&[0, 0x90, 1, 1, 0, 0xFF, 1, 0, 0, 1, 1], "byte 30, track 1: this is no event"),
        (&[0, 0x90, 1, 1, 0x81, 0x81, 0x81, 0x81, 1], "byte 26, track 1: a number has more than four bytes"),
        (&[0, 0x90, 1, 1, 0x81], "byte 26, track 1: the track ends within a number"),
        (
            &[0, 0x90, 1, 1, 0, 0xFF, 6, 9, b'a'],
            "byte 26, track 1: an event claims more bytes than its track has",
        ),
        (&[0, 0x90, 1, 1, 0, 0xF0, 0x81, 0x80, 0x80, 0x80, 0], "track 1: a number has more than four bytes"),
        (&[0, 0x90, 1, 1], "byte 26, track 1: there is no end of track"),
        (&[0, 0x90, 1, 1, 0, 0xFF, 0x2F, 0, 9, 9], "byte 30, track 1: 2 bytes behind the end of the track"),
    ];
    for (bad, what) in cases {
        let (found, text) = warned(&file(1, BEATS, &[bad, &good]));
        assert!(text.contains(what) && text.matches("track 1: ").count() == 1, "{text}");
        assert_eq!(found.messages, [(0.0, on(1)), (0.0, on(1))], "{what}");
        assert!(found.marks.is_empty());
    }
    let (found, text) =
        warned(&file(0, BEATS, &[&[&[0, 0xFF, 0x51, 3, 0, 0, 0, 0, 0xFF, 0x51, 1, 9][..], &good].concat()]));
    assert!(text.contains("a tempo without a length") && found.tempi.is_empty(), "{text}");
    let (_, text) = warned(&file(0, BEATS, &[&[&[0, 0xFF, 0x21, 1, 1][..], &good].concat()]));
    assert!(text.contains("port 2"), "{text}");
    let many = vec![&[0_u8, 0x90, 1, 1][..]; 100];
    let (found, text) = warned_many(&file(1, BEATS, &many));
    assert_eq!(found.messages.len(), 100);
    assert!(text.contains(&format!("{} more warnings", 100 - MOST_WARNINGS)), "{text}");
}

fn warned_many(bytes: &[u8]) -> (Song, String) {
    let Checked { value, warnings } = read(bytes).unwrap();
    assert_eq!(warnings.list.len(), MOST_WARNINGS + 1);
    (value, warnings.to_string())
}

#[test]
fn what_is_no_song_says_why() {
    let track = &END[..];
    let cases = [
        (vec![], "no Standard MIDI File"),
        (b"RIFF....WAVEdata".to_vec(), "something other than MIDI"),
        (b"RIFF....RMIDdat".to_vec(), "without a chunk `data`"),
        (chunk(b"MTrk", track), "no Standard MIDI File"),
        (chunk(b"MThd", &[0, 0, 0, 1]), "the header has 4 bytes instead of 6"),
        (file(3, BEATS, &[track]), "byte 8: the file has format 3"),
        (file(0, [0, 0], &[track]), "byte 12: a quarter note has 0 ticks"),
        (file(0, [0xE8, 0], &[track]), "byte 12: a frame has 0 ticks"),
        (file(0, [0x80, 1], &[track]), "byte 12: there are 128 frames a second"),
        (file(0, BEATS, &[]), "there is no track"),
        (vec![0; MOST_BYTES + 1], "67108864 are read at most"),
    ];
    for (bytes, what) in cases {
        let problems = read(&bytes).unwrap_err();
        assert!(problems.to_string().starts_with("song.mid: error: "), "{problems}");
        assert!(problems.to_string().contains(what), "{problems}");
        assert!(problems.list.iter().all(|p| p.help.is_some()), "{problems}");
    }
}

#[test]
fn there_is_an_end_to_events() {
    let track = [&note(&[0], 1)[..], &[0, 0xFF, 6, 0, 0, 0xFF, 1, 0], &note(&[0], 1), &END].concat();
    for format in [1, 2] {
        let bytes = file(format, BEATS, &[&track, &track]);
        assert!(super::read(&bytes, 6, &mut Warnings::default()).is_ok(), "text takes no room");
        let problem = super::read(&bytes, 5, &mut Warnings::default()).unwrap_err();
        assert!(
            problem.what.starts_with(&format!("byte {}: there are more than", bytes.len() - 8)),
            "{problem}"
        );
    }
}

/// A song with everything in it, by another writer.
fn written() -> (Vec<u8>, usize) {
    use midly::num::{u4, u7, u15, u24, u28};
    use midly::{Format, Header, MetaMessage, MidiMessage, Smf, Timing, TrackEvent, TrackEventKind};
    let event = |delta: u32, kind| TrackEvent { delta: u28::new(delta), kind };
    let meta = |delta, meta| event(delta, TrackEventKind::Meta(meta));
    let midi =
        |delta, channel, message| event(delta, TrackEventKind::Midi { channel: u4::new(channel), message });
    let end = || meta(300, MetaMessage::EndOfTrack);
    let first = vec![
        meta(0, MetaMessage::TrackName(b"tempo")),
        meta(0, MetaMessage::Tempo(u24::new(400_000))),
        meta(1_000, MetaMessage::Marker(b"here")),
        meta(0, MetaMessage::Tempo(u24::new(600_000))),
        end(),
    ];
    let mut second = vec![event(0, TrackEventKind::SysEx(&[1, 2, 3, 0xF7]))];
    for i in 0..40 {
        let (key, vel) = (u7::new(i), u7::new(100));
        second.push(midi(50, i % 16, MidiMessage::NoteOn { key, vel }));
        second.push(midi(20_000 * u32::from(i == 30), i % 16, MidiMessage::NoteOff { key, vel }));
    }
    second.push(end());
    let header = Header::new(Format::Parallel, Timing::Metrical(u15::new(960)));
    let mut bytes = Vec::new();
    Smf { header, tracks: vec![first, second] }.write_std(&mut bytes).unwrap();
    (bytes, 80)
}

#[test]
fn what_another_writer_wrote_is_read() {
    let (bytes, messages) = written();
    let found = song(&bytes);
    assert_eq!((found.messages.len(), found.exclusive, found.tracks.len()), (messages, 1, 2));
    assert_eq!(found.tempi, [(0.0, 150.0), (1_000.0 * 0.4 / 960.0, 100.0)]);
    assert_eq!(found.marks[0].text, "here");
    let ticks = 40.0 * 50.0 + 20_000.0 + 300.0;
    assert!((found.seconds - (1_000.0 * 0.4 + (ticks - 1_000.0) * 0.6) / 960.0).abs() < 1e-12);
}

#[test]
fn every_beginning_of_a_file_is_an_error_or_has_warnings() {
    let (bytes, _) = written();
    let all = song(&bytes);
    for length in 0..bytes.len() {
        match read(&bytes[..length]) {
            Ok(found) => {
                assert!(!found.warnings.list.is_empty(), "{length}");
                assert!(found.value.messages.len() <= all.messages.len());
                assert!(found.value.messages.iter().all(|(t, _)| t.is_finite()));
            }
            Err(problems) => assert!(length <= 22 && problems.has_errors(), "{length}: {problems}"),
        }
    }
}

proptest! {
    #[test]
    fn any_bytes_give_a_song_or_a_reason(
        track in proptest::collection::vec(any::<u8>(), 0..300),
        format in 0_u8..4,
        division in any::<[u8; 2]>(),
        change in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..4),
    ) {
        let mut bytes = file(format, division, &[&track, &track]);
        for (at, value) in change {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        if let Ok(found) = read(&bytes) {
            let seconds = times(&found.value);
            prop_assert!(seconds.is_sorted() && seconds.iter().all(|t| *t >= 0.0 && *t <= found.value.seconds));
        }
        let _ = read(&track);
    }

    #[test]
    fn damage_anywhere_never_panics(at in any::<usize>(), value in any::<u8>(), cut in any::<usize>()) {
        let (mut bytes, _) = written();
        let at = at % bytes.len();
        bytes[at] = value;
        let _ = read(&bytes);
        bytes.truncate(cut % bytes.len());
        let _ = read(&bytes);
    }

    #[test]
    fn times_are_those_of_a_plain_sum(
        events in proptest::collection::vec((0_u8..128, proptest::option::of(1_u32..0xFF_FFFF)), 1..80),
        division in 1_u16..0x8000,
    ) {
        let (mut track, mut tempo, mut now, mut expected) = (Vec::new(), 500_000_u32, 0.0, Vec::new());
        for (delta, change) in events {
            now += f64::from(delta) * f64::from(tempo) / 1e6 / f64::from(division);
            match change {
                Some(to) => {
                    tempo = to;
                    track.extend([delta, 0xFF, 0x51, 3]);
                    track.extend(&to.to_be_bytes()[1..]);
                }
                None => {
                    track.extend(note(&[delta], 60));
                    expected.push(now);
                }
            }
        }
        track.extend(END);
        let found = song(&file(0, division.to_be_bytes(), &[&track]));
        prop_assert_eq!(found.messages.len(), expected.len());
        for ((seconds, _), expected) in found.messages.iter().zip(expected) {
            prop_assert!((seconds - expected).abs() < 1e-9 * (1.0 + expected));
        }
        prop_assert!((found.seconds - now).abs() < 1e-9 * (1.0 + now));
    }
}
