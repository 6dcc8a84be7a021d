//! What things are called in a journal.

use crate::engine::event::Source;
use crate::live::gate::Order;
use crate::live::signal::{Origin, Signal};
use crate::performer::Touch;

/// How something came in, where, and what it was.
pub(super) fn of_signal(signal: &Signal, origin: &Origin) -> (&'static str, Option<String>, Option<String>) {
    match (origin, signal) {
        (Origin::Osc(address, arguments), _) => ("osc", Some(address.to_string()), filled(arguments)),
        (Origin::Key(key), Signal::Key(_)) => ("key", Some(key.to_string()), None),
        (Origin::Key(key), _) => {
            let (what, which) = asked(signal);
            let words = [what].into_iter().chain(which).collect::<Vec<_>>().join(" ");
            ("key", Some(key.to_string()), Some(words))
        }
        (_, Signal::Midi(port, message)) => {
            ("midi", Some(port.to_string()), Some(hexadecimal(&message.bytes())))
        }
        (_, Signal::MidiGone(port)) => ("midi", Some(port.to_string()), Some("gone".into())),
        (_, Signal::Osc(address, values)) => {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            ("osc", Some(address.clone()), filled(&values.join(" ")))
        }
        (_, Signal::Key(key)) => ("key", Some(key.to_string()), None),
        (Origin::System(name), _) => ("system", Some(name.to_string()), Some(asked(signal).0)),
        (Origin::Program, _) => {
            let (what, which) = asked(signal);
            ("program", which, Some(what))
        }
    }
}

fn filled(text: &str) -> Option<String> {
    Some(text).filter(|text| !text.is_empty()).map(String::from)
}

/// What a program asks for, and of what.
fn asked(signal: &Signal) -> (String, Option<String>) {
    match signal {
        Signal::Play(_, voice, _) => ("play".into(), Some(voice.clone())),
        Signal::Release(number) => ("release".into(), Some(number.to_string())),
        Signal::Touch(number, touch) => (touched(*touch), Some(number.to_string())),
        Signal::ReleaseAll => ("release-all".into(), None),
        Signal::Set(control, value) => (format!("set {value}"), Some(control.clone())),
        Signal::Start(_, pattern) => ("start".into(), Some(pattern.clone())),
        Signal::Stop(number) => ("stop".into(), Some(number.to_string())),
        Signal::StopNamed(pattern) => ("stop".into(), Some(pattern.clone())),
        Signal::Panic => ("panic".into(), None),
        Signal::Calm => ("calm".into(), None),
        Signal::Arm(armed) => (if *armed { "arm" } else { "disarm" }.into(), None),
        Signal::Torque(on) => (if *on { "torque" } else { "torque-off" }.into(), None),
        Signal::Reload(reload) => ("reload".into(), Some(reload.patch.title.clone())),
        Signal::Note(text) => ("note".into(), Some(text.clone())),
        Signal::Vain(what, _) => (what.clone(), None),
        Signal::End => ("end".into(), None),
        Signal::Key(key) => ("key".into(), Some(key.to_string())),
        Signal::Midi(port, _) | Signal::MidiGone(port) => ("midi".into(), Some(port.to_string())),
        Signal::Osc(address, _) => ("osc".into(), Some(address.clone())),
    }
}

fn touched(touch: Touch) -> String {
    match touch {
        Touch::Bend(semitones) => format!("bend {semitones}"),
        Touch::Pressure(value) => format!("pressure {value}"),
        Touch::Timbre(value) => format!("timbre {value}"),
    }
}

pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

/// Sources of events.
const SOURCES: [(Source, &str); 3] =
    [(Source::Stop, "stop"), (Source::Pattern, "pattern"), (Source::Program, "program")];

/// What the messages of a song come by.
pub(super) const SONG: &str = "song";

/// What a signal of the engine has set off: it is no event that was given to the engine, and arises again by itself.
pub(super) const NODE: &str = "node";

/// And what always sounds.
pub(super) const ALWAYS: &str = "always";

pub(super) fn of_source(source: Source) -> &'static str {
    SOURCES.iter().find(|(known, _)| *known == source).map_or("", |(_, word)| word)
}

/// Whether what is of a source begins in a replay by itself.
pub(super) fn by_itself(source: &str) -> bool {
    source == NODE || source == ALWAYS
}

/// What a gate was told, in a word and perhaps a number.
pub(super) fn of_order(order: Order) -> (&'static str, Option<f64>) {
    match order {
        Order::Open => ("open", None),
        Order::Return => ("return", None),
        Order::Latch => ("latch", None),
        Order::Release => ("release", None),
        Order::Close => ("close", None),
        Order::Gain(gain) => ("gain", Some(f64::from(gain))),
    }
}

/// The same, read.
pub(super) fn order(word: &str, value: Option<f64>) -> Option<Order> {
    match (word, value) {
        ("open", _) => Some(Order::Open),
        ("return", _) => Some(Order::Return),
        ("latch", _) => Some(Order::Latch),
        ("release", _) => Some(Order::Release),
        ("close", _) => Some(Order::Close),
        ("gain", Some(gain)) => Some(Order::Gain(gain as f32)),
        _ => None,
    }
}

/// A source by its word.
pub(super) fn source(word: &str) -> Option<Source> {
    SOURCES.iter().find(|(_, known)| *known == word).map(|(source, _)| *source)
}

#[cfg(test)]
mod tests {
    use super::{SOURCES, of_order, of_signal, of_source, order, source};
    use crate::live::gate::Order;
    use crate::live::signal::{Origin, Signal};
    use crate::midi::Message;

    #[test]
    fn what_came_in_says_by_which_way() {
        let told = |signal: &Signal, origin: &Origin| {
            let (source, name, message) = of_signal(signal, origin);
            format!("{source}|{}|{}", name.unwrap_or_default(), message.unwrap_or_default())
        };
        let (program, key) = (Origin::Program, Origin::Key("3".into()));
        let osc = Origin::Osc("/pattern/w*/play".into(), "1".into());
        let start = Signal::Start(4, "walk".into());
        assert_eq!(told(&start, &program), "program|walk|start");
        assert_eq!(told(&start, &key), "key|3|start walk");
        assert_eq!(told(&start, &osc), "osc|/pattern/w*/play|1");
        assert_eq!(told(&Signal::Panic, &key), "key|3|panic");
        assert_eq!(told(&Signal::End, &Origin::System("SIGINT".into())), "system|SIGINT|end");
        assert_eq!(told(&Signal::Key(3), &key), "key|3|");
        assert_eq!(told(&Signal::Key(3), &program), "key|3|");
        let midi = Signal::Midi(
            2,
            Message::NoteOff { channel: crate::midi::Channel::new(1).unwrap(), note: 60, velocity: 0 },
        );
        assert_eq!(told(&midi, &program), "midi|2|81 3C 00");
        assert_eq!(told(&Signal::Osc("/a".into(), vec![0.5, 2.0]), &program), "osc|/a|0.5 2");
    }

    #[test]
    fn what_is_written_is_understood() {
        use Order::{Close, Gain, Latch, Open, Release, Return};
        for told in [Open, Return, Latch, Release, Close, Gain(0.1)] {
            let (word, value) = of_order(told);
            assert_eq!(order(word, value), Some(told));
        }
        assert_eq!((order("gain", None), order("ajar", Some(0.5))), (None, None));
        for (known, _) in SOURCES {
            assert_eq!(source(of_source(known)), Some(known));
        }
        assert_eq!(source("nobody"), None);
    }
}
