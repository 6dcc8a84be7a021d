//! What of a song a patch cannot hear.

use pacinian::midi::Message;
use pacinian::midi::file::Song;
use pacinian::midi::pitch;
use pacinian::patch::{Mover, Patch, Source, Start, Trigger};
use pacinian::text::problem::Severity;
use pacinian::text::{Problem, Problems};
use std::collections::BTreeSet;
use std::path::Path;

/// Seconds of a song that are rendered without anybody saying how many are wanted: an hour.
pub const LONGEST: f64 = 3600.0;

/// The voice that the notes of a song play where nothing in a patch hears MIDI, as it is the only one that they could; and a warning that says so.
pub fn only_voice(patch: &Patch, path: &Path) -> Option<(String, Problems)> {
    if patch.hears_midi() || patch.follows_clock() {
        return None;
    }
    let mut voices = patch.voices.iter().filter(|voice| voice.start != Start::Always);
    let (Some(voice), None) = (voices.next(), voices.next()) else { return None };
    let what = format!("nothing in the patch hears MIDI: the song's notes play its voice `{}`", voice.name);
    let help = "--notes VOICE says so as well; or add a [[trigger]] with on = \"midi.note\": see `pacinian format trigger`";
    Some((voice.name.clone(), warning(path, what, help)))
}

/// A warning where nothing in a patch hears a song, or nothing that is in it.
pub fn unsung(patch: &Patch, path: &Path, song: &Song) -> Option<Problems> {
    // The tempo of a song counts, even where no message does.
    let counts = patch.follows_clock();
    let (what, help) = if !patch.hears_midi() {
        if counts {
            return None;
        }
        let what = "nothing in the patch hears MIDI, so that the song changes nothing";
        let help = "--notes VOICE lets its notes play a voice; or add a [[trigger]] with on = \"midi.note\" and play = \"VOICE\", a [[bind]] with from = \"midi.controller 1\", or clock = \
                    \"midi\" to a pattern: see `pacinian format trigger`";
        (what.to_string(), help)
    } else if !counts && !song.messages.is_empty() && !song.messages.iter().any(|(_, m)| hears(patch, *m)) {
        let what = format!(
            "the patch hears none of what is in the song: {}",
            content(song).unwrap_or_else(|| "no notes".into())
        );
        (what, "look at `channel` and `notes` of its triggers and bindings")
    } else {
        return None;
    };
    Some(warning(path, what, help))
}

fn warning(path: &Path, what: String, help: &str) -> Problems {
    let warning = Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help.to_string()) };
    Problems { file: path.display().to_string(), source: String::new(), list: vec![warning] }
}

/// Whether a message may set off a trigger.
pub fn sets_off(trigger: &Trigger, message: Message) -> bool {
    let on =
        |channel: pacinian::midi::Channel| trigger.channel.is_none_or(|wanted| wanted == channel.number());
    match (&trigger.on, message) {
        (Source::MidiNote, Message::NoteOn { channel, note, velocity: 1.. }) => {
            on(channel) && trigger.notes.is_none_or(|[least, most]| (least..=most).contains(&note))
        }
        (Source::MidiProgram(wanted), Message::Program { channel, program }) => {
            on(channel) && *wanted == program
        }
        (Source::MidiController { number, .. }, Message::Controller { channel, number: moved, .. }) => {
            on(channel) && moves(*number, moved)
        }
        _ => false,
    }
}

/// Whether a trigger or a binding may have use for a message.
fn hears(patch: &Patch, message: Message) -> bool {
    let on = |wanted: Option<u8>, channel: pacinian::midi::Channel| {
        wanted.is_none_or(|wanted| wanted == channel.number())
    };
    let triggers = patch.triggers.iter().any(|trigger| sets_off(trigger, message));
    let binds = patch.binds.iter().any(|bind| match (&bind.from, message) {
        (Mover::Controller(number), Message::Controller { channel, number: moved, .. }) => {
            on(bind.channel, channel) && moves(*number, moved)
        }
        (Mover::Bend, Message::Bend { channel, .. })
        | (
            Mover::Pressure,
            Message::ChannelPressure { channel, .. } | Message::PolyPressure { channel, .. },
        ) => on(bind.channel, channel),
        _ => false,
    });
    triggers || binds
}

/// Whether a controller moves another: itself, or the pair of which it is the lower half.
fn moves(number: u8, moved: u8) -> bool {
    moved == number || number < 32 && moved == number + 32
}

/// Which notes are in it, on which channels.
fn content(song: &Song) -> Option<String> {
    let notes = || {
        song.messages.iter().filter_map(|(_, message)| match message {
            Message::NoteOn { channel, note, velocity: 1.. } => Some((channel.number(), *note)),
            _ => None,
        })
    };
    let (least, most) = (notes().map(|(_, note)| note).min()?, notes().map(|(_, note)| note).max()?);
    let channels: BTreeSet<u8> = notes().map(|(channel, _)| channel).collect();
    let listed: Vec<String> = channels.iter().map(u8::to_string).collect();
    let word = if listed.len() == 1 { "channel" } else { "channels" };
    Some(format!("notes {} to {} on {word} {}", pitch::name(least)?, pitch::name(most)?, listed.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::{Message, Patch, Path, Song, unsung};
    use pacinian::midi::Channel;

    fn told(rest: &str, messages: &[Message]) -> Option<String> {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.c]\ndefault = 0.5\n[voice.v]\noutput = \"s\"\n[voice.v.nodes]\n\
             s = {{ type = \"sine\", frequency = 100, amplitude = \"c\" }}\n{rest}"
        );
        let patch = Patch::parse("p", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let messages = messages.iter().map(|message| (0.0, *message)).collect();
        let song = Song { messages, ..Song::default() };
        unsung(&patch, Path::new("song.mid"), &song).map(|problems| problems.to_string())
    }

    #[test]
    fn a_song_that_nothing_hears_is_told_with_what_to_add() {
        let on = |note| Message::NoteOn { channel: Channel::LAST, note, velocity: 9 };
        let silent = told("", &[on(60)]).unwrap();
        for words in ["song.mid", "nothing in the patch hears MIDI", "[[trigger]]", "midi.note", "[[bind]]"] {
            assert!(silent.contains(words), "{words}: {silent}");
        }
        let notes = "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [0, 63]\n";
        assert_eq!(told(notes, &[on(60), on(80)]), None);
        let beyond = told(notes, &[on(64), on(72)]).unwrap();
        assert!(beyond.contains("notes E4 to C5 on channel 16") && beyond.contains("`notes`"), "{beyond}");
        assert!(told(&format!("{notes}channel = 1\n"), &[on(60)]).is_some());
        let bind = "[[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"c\"\n";
        let controller = |number| Message::Controller { channel: Channel::FIRST, number, value: 1 };
        assert_eq!([told(bind, &[controller(7)]), told(bind, &[controller(39)])], [None, None]);
        assert!(told(bind, &[on(60), controller(8)]).is_some());
        let clock = "[pattern.p]\ntime = \"beats\"\nclock = \"midi\"\nevents = [{ at = 0, voice = \"v\" }]\n";
        assert_eq!(told(clock, &[on(60)]), None, "its tempo counts");
    }
}
