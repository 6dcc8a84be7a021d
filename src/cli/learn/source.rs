//! What is moved, and what is not enough, in words.

use pacinian::io::learn::{Candidate, Misfit, Short, Source, Unfit};
use pacinian::io::osc::address::LONGEST;
use pacinian::midi::moved::{Control, Moved, Useless};
use pacinian::midi::reach::Reach;
use pacinian::midi::travel::SPAN;
use pacinian::text::problem::escaped;

/// Characters of an address that are shown, at most.
const SHOWN: usize = 80;

/// What it is.
pub fn shown(source: &Source) -> String {
    match source {
        Source::Midi { moved, port } => {
            let Moved { channel, control, fine, switch, encoder, .. } = *moved;
            let what = match control {
                Control::Controller(number) => {
                    let bits = if fine { 14 } else { 7 };
                    let kind = match encoder {
                        Some(encoder) => format!("an encoder ({}), ", encoder.name()),
                        None if switch => "a button, ".into(),
                        None => format!("{bits} bits, "),
                    };
                    format!("controller {number}, {kind}")
                }
                Control::Bend => "the pitch wheel, 14 bits, ".into(),
                Control::Pressure => "pressure, 7 bits, ".to_string(),
            };
            format!("{what}on channel {} of {}", channel.number(), escaped(port))
        }
        Source::Osc { address, argument: 1, .. } => format!("OSC {}", escaped(address)),
        Source::Osc { address, argument, .. } => format!("OSC {}, number {argument}", escaped(address)),
    }
}

/// An address as it may be shown: whoever sends it chooses it.
fn cut(address: &str) -> String {
    let cut: String = address.chars().take(SHOWN).collect();
    format!("{}{}", escaped(&cut), if cut.len() < address.len() { "..." } else { "" })
}

/// Why something that was used is no source.
pub fn why(unfit: &Unfit) -> String {
    match unfit {
        Unfit::Midi(useless) => of_midi(*useless),
        Unfit::Osc(address, misfit) => of_osc(&cut(address), *misfit),
    }
}

fn of_osc(shown: &str, misfit: Misfit) -> String {
    let elsewhere = "name it otherwise where it comes from";
    match misfit {
        Misfit::Own => format!("{shown} is an address of pacinian's own; see docs/osc.md"),
        Misfit::Blank => format!("{shown} has a blank in it, which a binding cannot have; {elsewhere}"),
        Misfit::Long => {
            format!("{shown} is longer than the {LONGEST} bytes that an address may have; {elsewhere}")
        }
        Misfit::Value(value) => {
            format!(
                "{shown} says {value}: what is learnt goes from 0 to 1; set it so where it comes from, or write [[bind]] with what it `sends`"
            )
        }
    }
}

fn of_midi(useless: Useless) -> String {
    match useless {
        Useless::Note => "keys play voices: a [[trigger]] with on = \"midi.note\" does that".into(),
        Useless::Program => {
            "a program is chosen, not moved: a [[trigger]] with on = \"midi.program N\" hears it".into()
        }
        Useless::Parameter => {
            "that is a numbered parameter (NRPN), which cannot be bound: set it to a controller in its editor"
                .into()
        }
        Useless::Pedal(number) => format!(
            "controller {number} is a pedal that holds voices: a [[bind]] or a [[trigger]] that names midi.controller {number} makes it something else"
        ),
        Useless::Steps(number) => format!(
            "controller {number} says the same again and again, as endless knobs do that tell steps: turn it one way and back"
        ),
    }
}

/// What is called so in a sentence.
fn named(control: Control) -> String {
    match control {
        Control::Controller(number) => format!("controller {number}"),
        Control::Bend => "the pitch wheel".into(),
        Control::Pressure => "pressure".into(),
    }
}

/// What was heard of and is not taken, and why not.
pub fn not_enough(short: &Short) -> (String, String) {
    match short {
        Short::Moved(mover, reach, others) => {
            let (what, keys) = match mover {
                Candidate::Midi(channel, control) => (
                    format!("{} on channel {}", named(*control), channel.number()),
                    *control == Control::Pressure,
                ),
                Candidate::Osc(address) => (format!("OSC {}", cut(address)), false),
            };
            let why = too_short(&what, *reach, *others, keys);
            (what, why)
        }
        Short::Nothing => {
            (String::new(), "messages came, and none of them says where something stands".into())
        }
    }
}

/// Why what was heard of is not taken: it went furthest, and `others` went less far. `keys` says that it comes along with keys.
fn too_short(what: &str, reach: Reach, others: usize, keys: bool) -> String {
    let Reach { least, most } = reach;
    let percent = |digits: usize| [least, most].map(|x| format!("{:.digits$} %", 100.0 * x));
    let same = |[a, b]: &[String; 2]| a == b;
    let [from, to] = Some(percent(0)).filter(|both| !same(both)).unwrap_or_else(|| percent(2));
    let how = if keys {
        format!("{what} went from {from} to {to}: press a key harder, and hold it")
    } else if least == most {
        format!("{what} says that it stands at {}, and has not moved", percent(0)[0])
    } else if most - least < SPAN {
        format!("{what} moved from {from} to {to}: move it by a tenth of its way or more")
    } else {
        format!(
            "{what} went from {from} to {to} at once or too slowly: move it on, or back; press a button once more"
        )
    };
    match others {
        0 => how,
        1 => format!("{how}; another moved less"),
        several => format!("{how}; {several} others moved less"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Control, named, too_short};
    use pacinian::midi::reach::Reach;

    #[test]
    fn what_is_not_taken_is_told_with_its_way() {
        let of = |least, most, others| {
            too_short(&named(Control::Controller(21)), Reach { least, most }, others, false)
        };
        assert_eq!(
            of(0.12, 0.14, 0),
            "controller 21 moved from 12 % to 14 %: move it by a tenth of its way or more"
        );
        assert!(of(0.120_1, 0.120_5, 1).starts_with("controller 21 moved from 12.01 % to 12.05 %: "));
        assert!(of(0.5, 0.5, 2).ends_with("stands at 50 %, and has not moved; 2 others moved less"));
        assert!(of(0.0, 1.0, 0).contains("from 0 % to 100 % at once or too slowly: move it on, or back"));
        let keys = too_short("pressure", Reach { least: 0.0, most: 0.25 }, 0, true);
        assert_eq!(keys, "pressure went from 0 % to 25 %: press a key harder, and hold it");
    }
}
