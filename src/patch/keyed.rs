//! A voice that a keyboard plays, whether its patch has thought of that or not.

use super::expr::Expr;
use super::trigger::{Source, Spread, Trigger};
use super::{Patch, Voice};

impl Patch {
    /// Lets notes of MIDI play a voice, at their pitch where it reads a frequency, as a trigger on `midi.note` would, unless one does with all
    /// of them; whether there is such a voice.
    pub fn key(&mut self, voice: &str) -> bool {
        let Some(reads) = self.voices.iter().find(|v| v.name == voice).map(Voice::reads_frequency) else {
            return false;
        };
        let does = |t: &Trigger| {
            t.on == Source::MidiNote && t.play == voice && t.channel.is_none() && t.notes.is_none()
        };
        if self.triggers.iter().any(does) {
            return true;
        }
        let nowhere = 0..0;
        let pitch = || ("frequency".into(), Expr::Name("pitch".into(), nowhere.clone()), nowhere.clone());
        self.triggers.push(Trigger {
            on: Source::MidiNote,
            on_span: nowhere.clone(),
            play: voice.into(),
            play_span: nowhere.clone(),
            set: if reads { vec![pitch()] } else { Vec::new() },
            place: None,
            channel: None,
            notes: None,
            spread: Spread::Off,
            hold: 0.0,
            rearm: None,
            span: nowhere.clone(),
        });
        true
    }
}

#[cfg(test)]
mod tests {
    use crate::patch::Patch;

    #[test]
    fn it_is_the_trigger_that_somebody_would_write() {
        let head = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n\
            [voice.low]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n\
            [voice.rough]\noutput = \"s\"\nnodes.s = { type = \"white\" }\n";
        let parse = |text: &str| Patch::parse("p", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        for (voice, set) in [("low", "set = { frequency = \"pitch\" }"), ("rough", "")] {
            let mut patch = parse(head);
            assert!(!patch.hears_midi() && patch.key(voice) && patch.hears_midi());
            let written =
                parse(&format!("{head}[[trigger]]\non = \"midi.note\"\nplay = \"{voice}\"\n{set}\n"));
            let (made, written) = (&patch.triggers[0], &written.triggers[0]);
            assert_eq!((&made.on, &made.play, made.spread), (&written.on, &written.play, written.spread));
            assert_eq!(
                (&made.place, made.channel, made.notes),
                (&written.place, written.channel, written.notes)
            );
            assert_eq!(made.reads("pitch"), voice == "low");
            assert_eq!(made.set.len(), written.set.len());
        }
        assert!(!parse(head).key("lo"));
        // Nothing is played twice.
        let mut patch = parse(head);
        assert!(patch.key("low") && patch.key("low") && patch.triggers.len() == 1);
    }
}
