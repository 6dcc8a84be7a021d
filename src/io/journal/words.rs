//! What things are called in a journal.

use crate::engine::event::Source;
use crate::live::gate::Order;
use crate::live::signal::Signal;
use crate::performer::Touch;

/// Where something came in, at what, and what it was.
pub(super) fn of_signal(signal: &Signal) -> (&'static str, Option<String>, Option<String>) {
    match signal {
        Signal::Midi(port, message) => ("midi", Some(port.to_string()), Some(hexadecimal(&message.bytes()))),
        Signal::MidiGone(port) => ("midi", Some(port.to_string()), Some("gone".into())),
        Signal::Osc(address, values) => {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            ("osc", Some(address.clone()), Some(values.join(" ")))
        }
        Signal::Key(key) => ("key", Some(key.to_string()), None),
        Signal::Play(_, voice, _) => ("program", Some(voice.clone()), Some("play".into())),
        Signal::Release(_) => ("program", None, Some("release".into())),
        Signal::Touch(number, touch) => ("program", Some(number.to_string()), Some(touched(*touch))),
        Signal::ReleaseAll => ("program", None, Some("release-all".into())),
        Signal::Set(control, value) => ("program", Some(control.clone()), Some(format!("set {value}"))),
        Signal::Start(_, pattern) => ("program", Some(pattern.clone()), Some("start".into())),
        Signal::Stop(number) => ("program", Some(number.to_string()), Some("stop".into())),
        Signal::StopNamed(pattern) => ("program", Some(pattern.clone()), Some("stop".into())),
        Signal::Panic => ("program", None, Some("panic".into())),
        Signal::Calm => ("program", None, Some("calm".into())),
        Signal::Arm(armed) => ("program", None, Some(if *armed { "arm" } else { "disarm" }.into())),
        Signal::Reload(reload) => ("program", Some(reload.patch.title.clone()), Some("reload".into())),
        Signal::End => ("program", None, Some("end".into())),
    }
}

fn touched(touch: Touch) -> String {
    match touch {
        Touch::Bend(semitones) => format!("bend {semitones}"),
        Touch::Pressure(value) => format!("pressure {value}"),
        Touch::Timbre(value) => format!("timbre {value}"),
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

/// Sources of events.
const SOURCES: [(Source, &str); 2] = [(Source::Pattern, "pattern"), (Source::Program, "program")];

pub(super) fn of_source(source: Source) -> &'static str {
    SOURCES.iter().find(|(known, _)| *known == source).map_or("", |(_, word)| word)
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
    use super::{SOURCES, of_order, of_source, order, source};
    use crate::live::gate::Order;

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
