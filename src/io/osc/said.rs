//! What a message said, in words: for journals.

use std::fmt::Write as _;

use rosc::{OscMessage, OscType};

use crate::live::signal::Origin;

/// Bytes of an address, and of the arguments, that are kept.
const MOST: usize = 1000;

/// The message as the origin of what it asks for: its address, and its arguments with spaces between. Texts are in quotes.
pub(super) fn origin(message: &OscMessage) -> Origin {
    Origin::Osc(cut(&message.addr).into(), listed(&message.args).into())
}

/// Arguments with spaces between, as much of them as is kept.
pub(super) fn listed(args: &[OscType]) -> String {
    let mut words = String::new();
    for argument in args {
        if words.len() > MOST {
            break;
        }
        if !words.is_empty() {
            words.push(' ');
        }
        argued(argument, &mut words);
    }
    cut(&words)
}

fn argued(argument: &OscType, words: &mut String) {
    // A string takes whatever it is given.
    let _ = match argument {
        OscType::Int(value) => write!(words, "{value}"),
        OscType::Long(value) => write!(words, "{value}"),
        OscType::Float(value) => write!(words, "{value}"),
        OscType::Double(value) => write!(words, "{value}"),
        OscType::Bool(value) => write!(words, "{value}"),
        OscType::String(text) => write!(words, "{:?}", cut(text)),
        OscType::Char(letter) => write!(words, "{letter:?}"),
        OscType::Nil => write!(words, "nil"),
        OscType::Inf => write!(words, "inf"),
        OscType::Blob(bytes) => write!(words, "blob({})", bytes.len()),
        OscType::Array(array) => {
            words.push('[');
            for (place, argument) in array.content.iter().enumerate() {
                if words.len() > MOST {
                    break;
                }
                words.push_str(if place == 0 { "" } else { " " });
                argued(argument, words);
            }
            write!(words, "]")
        }
        OscType::Time(time) => write!(words, "time({}.{})", time.seconds, time.fractional),
        OscType::Color(c) => write!(words, "#{:02x}{:02x}{:02x}{:02x}", c.red, c.green, c.blue, c.alpha),
        OscType::Midi(m) => write!(words, "midi({} {} {} {})", m.port, m.status, m.data1, m.data2),
    };
}

/// As much of a text as is kept.
fn cut(text: &str) -> String {
    match text.char_indices().find(|(at, _)| *at >= MOST) {
        Some((at, _)) => format!("{}...", &text[..at]),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use rosc::{OscArray, OscMessage, OscType};

    use super::{MOST, origin};
    use crate::live::signal::Origin;

    #[test]
    fn a_message_is_written_as_it_came_but_not_without_end() {
        let said = |args: &[OscType]| match origin(&OscMessage {
            addr: "/voice/*/play".into(),
            args: args.to_vec(),
        }) {
            Origin::Osc(address, words) => {
                assert_eq!(&*address, "/voice/*/play");
                words
            }
            other => panic!("{other:?}"),
        };
        assert_eq!(&*said(&[]), "");
        let args = [OscType::Float(0.5), "place".into(), "left \"a\"".into(), OscType::Int(-3), OscType::Nil];
        assert_eq!(&*said(&args), r#"0.5 "place" "left \"a\"" -3 nil"#);
        assert_eq!(&*said(&[OscType::Blob(vec![0; 9]), OscType::Bool(true)]), "blob(9) true");
        let array = |content: Vec<OscType>| OscType::Array(OscArray { content });
        let nested = array(vec![OscType::Float(0.25), array(vec![]), array(vec!["x".into(), 0.into()])]);
        assert_eq!(&*said(&[1.into(), nested]), r#"1 [0.25 [] ["x" 0]]"#);
        for long in [
            vec![OscType::Long(7); 60_000],
            vec![array(vec![OscType::Long(7); 60_000])],
            vec!["ä".repeat(60_000).into()],
        ] {
            let words = said(&long);
            assert!(words.len() < MOST + 10 && words.contains("..."), "{}", words.len());
        }
    }
}
