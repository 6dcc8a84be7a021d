//! Bindings into the text of a patch.

use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::text::Text;
use super::value::{one_line, put};
use super::{EditError, broken};
use crate::patch::bind::{SENDS, STEP};
use crate::patch::{Bind, Curve, Mover, Patch};

/// The text of a patch with these bindings. A control that one binding moves already is moved by another thing from now on (`from`, `channel`), and keeps
/// its range, curve and pick-up, whatever is given here; others get a binding of their own, which says what is not as usual. Of several
/// for one control that had none or one, the last counts. Spans do not matter.
///
/// # Errors
/// A text that is no patch, or none any more: a control that is not there, a range that cannot be.
pub fn bindings(source: &str, binds: &[Bind]) -> Result<String, EditError> {
    let mut text = Text::of(source);
    for bind in binds {
        text.change(|document| bound(document, bind))?;
    }
    let text = text.finish();
    // What will be read of it is what was meant.
    let patch = Patch::parse("", text.as_bytes()).map_err(broken)?.value;
    let is_there = |bind: &Bind| {
        patch
            .binds
            .iter()
            .any(|is| is.control == bind.control && is.from == bind.from && is.channel == bind.channel)
    };
    let counts =
        |(n, bind): &(usize, &Bind)| binds[n + 1..].iter().all(|later| later.control != bind.control);
    match binds.iter().enumerate().filter(counts).all(|(_, bind)| is_there(bind)) {
        true => Ok(text),
        false => Err(EditError::Form("`bind`".into())),
    }
}

/// With one.
fn bound(document: &mut DocumentMut, bind: &Bind) -> Result<(), EditError> {
    let list = document.entry("bind").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    match list {
        Item::ArrayOfTables(tables) => {
            let known = only(tables.iter().map(|table| moves(table, &bind.control)));
            match known.and_then(|at| tables.get_mut(at)) {
                Some(table) => set(table, bind),
                None => {
                    let mut table = Table::new();
                    fill(&mut table, bind)?;
                    tables.push(table);
                    Ok(())
                }
            }
        }
        Item::Value(Value::Array(tables)) => {
            let is_it =
                |value: &Value| value.as_inline_table().is_some_and(|table| moves(table, &bind.control));
            let known = only(tables.iter().map(is_it));
            match known.and_then(|at| tables.get_mut(at)).and_then(Value::as_inline_table_mut) {
                Some(table) => one_line(table, |table| set(table, bind)),
                None => {
                    let mut table = InlineTable::new();
                    fill(&mut table, bind)?;
                    tables.push(table);
                    Ok(())
                }
            }
        }
        _ => Err(EditError::Form("`bind`".into())),
    }
}

/// The place of the only one, if there is only one.
fn only(which: impl Iterator<Item = bool>) -> Option<usize> {
    let mut found = which.enumerate().filter(|(_, is_it)| *is_it);
    found.next().filter(|_| found.next().is_none()).map(|(at, _)| at)
}

fn moves(table: &dyn TableLike, control: &str) -> bool {
    table.get("control").and_then(Item::as_str) == Some(control)
}

/// A new binding.
fn fill(table: &mut dyn TableLike, bind: &Bind) -> Result<(), EditError> {
    put(table, "from", bind.from.to_string().into())?;
    put(table, "control", bind.control.as_str().into())?;
    set(table, bind)?;
    if let Some([from, to]) = bind.range {
        put(table, "range", [from, to].into_iter().collect::<Value>())?;
    }
    if bind.sends != SENDS {
        put(table, "sends", bind.sends.into_iter().collect::<Value>())?;
    }
    if bind.step != STEP {
        put(table, "step", bind.step.into())?;
    }
    match bind.curve {
        Some(Curve::Linear) => put(table, "curve", "linear".into()),
        Some(Curve::Exponential) => put(table, "curve", "exponential".into()),
        None => Ok(()),
    }
}

/// Another source for a binding.
fn set(table: &mut dyn TableLike, bind: &Bind) -> Result<(), EditError> {
    let from = bind.from.to_string();
    let before = table.get("from").and_then(Item::as_str);
    if before.and_then(|before| Mover::parse(before).ok()) != Some(bind.from.clone()) {
        // What another sends has other ends.
        drop(table.remove("sends"));
    }
    put(table, "from", from.into())?;
    match bind.channel {
        Some(channel) => put(table, "channel", i64::from(channel).into())?,
        None => drop(table.remove("channel")),
    }
    match bind.encoder {
        Some(encoder) => put(table, "encoder", encoder.name().into())?,
        None => drop(table.remove("encoder")),
    }
    if !bind.pickup && !table.contains_key("pickup") {
        put(table, "pickup", false.into())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Curve, EditError, bindings};
    use crate::midi::Encoder;
    use crate::patch::{Bind, Mover, Patch};

    const PATCH: &str = "#:schema x\nformat = \"pacinian-patch/1\"\ntitle = \"t\"  # of these\n\n[control.a]\ndefault = 0.5\n\
        [control.b]\ndefault = 0.5\n\n# The wheel.\n[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n\n\
        # What sounds.\n[voice.v]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 100, amplitude = \"a * b\" }\n# last\n";

    fn midi(from: &str, control: &str, channel: u8, springs: bool) -> Bind {
        Bind { channel: Some(channel), pickup: !springs, ..Bind::new(Mover::parse(from).unwrap(), control) }
    }

    fn osc(address: &str, control: &str, switch: bool) -> Bind {
        Bind { pickup: !switch, ..Bind::new(Mover::parse(&format!("osc.{address}")).unwrap(), control) }
    }

    fn written(source: &str, binds: &[Bind]) -> String {
        bindings(source, binds).unwrap()
    }

    #[test]
    fn a_binding_that_is_there_hears_another_source_and_keeps_the_rest() {
        let text = written(PATCH, &[midi("midi.controller 21", "a", 3, false)]);
        let line =
            "from = \"midi.controller 21\"   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\nchannel = 3\n";
        assert_eq!(
            text,
            PATCH.replace("from = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n", line)
        );
        let back = written(&text, &[osc("/x", "a", false)]);
        assert_eq!(back, PATCH.replace("'midi.bend'", "\"osc./x\""));
    }

    #[test]
    fn a_new_binding_stands_behind_the_others_or_at_the_end() {
        let text = written(PATCH, &[midi("midi.bend", "b", 1, true)]);
        for line in PATCH.lines() {
            assert!(text.contains(line), "{line} is gone from\n{text}");
        }
        let new = "[[bind]]\nfrom = \"midi.bend\"\ncontrol = \"b\"\nchannel = 1\npickup = false\n";
        assert!(text.contains(new), "{text}");
        let bare = PATCH.replace(
            "# The wheel.\n[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n\n",
            "",
        );
        let two = written(&bare, &[midi("midi.controller 7", "b", 1, false), osc("/a", "a", true)]);
        assert!(two.starts_with(bare.trim_end_matches("# last\n")) && two.contains("# last"), "{two}");
        let binds = Patch::parse("", two.as_bytes()).unwrap().value.binds;
        let told: Vec<_> = binds.iter().map(|b| (b.control.as_str(), b.channel, b.pickup)).collect();
        assert_eq!(told, [("b", Some(1), true), ("a", None, false)]);
        let inline = bare.replace(
            "\n[control.a]",
            "bind = [{ from = \"midi.bend\", control = \"a\" }] # here\n[control.a]",
        );
        let text = written(&inline, &[osc("/a", "a", false), osc("/b", "b", false)]);
        assert!(text.contains("bind = [{ from = \"osc./a\", control = \"a\" }, { from = \"osc./b\", control = \"b\" }] # here"), "{text}");
    }

    #[test]
    fn lines_end_as_they_did_and_the_last_of_several_counts() {
        let crlf = |text: &str| format!("\u{feff}{}", text.replace('\n', "\r\n"));
        for binds in [
            vec![midi("midi.controller 21", "a", 3, false), midi("midi.bend", "b", 1, true)],
            vec![osc("/x", "a", true), osc("/y", "b", false)],
        ] {
            assert_eq!(written(&crlf(PATCH), &binds), crlf(&written(PATCH, &binds)));
        }
        let twice = [osc("/x", "b", false), osc("/y", "b", false)];
        assert_eq!(written(PATCH, &twice), written(PATCH, &twice[1..]));
        let inline = PATCH.replace(
            "# The wheel.\n[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n",
            "",
        );
        let inline =
            inline.replace("[control.a]", "bind = [{ from = \"midi.bend\", control = \"a\" }]\n[control.a]");
        let text = written(&inline, &[midi("midi.bend", "a", 3, true)]);
        let due = "bind = [{ from = \"midi.bend\", control = \"a\", channel = 3, pickup = false }]\n";
        assert!(text.contains(due), "{text}");
    }

    #[test]
    fn an_endless_knob_is_written_as_one_and_gives_way_to_a_fader() {
        let fader = midi("midi.controller 5", "b", 1, false);
        let knob = Bind { encoder: Some(Encoder::SignedBit), step: 0.05, ..fader.clone() };
        let text = written(PATCH, std::slice::from_ref(&knob));
        assert!(
            text.contains("control = \"b\"\nchannel = 1\nencoder = \"signed-bit\"\nstep = 0.05\n"),
            "{text}"
        );
        let read = Patch::parse("", text.as_bytes()).unwrap().value.binds.pop().unwrap();
        assert_eq!((read.encoder, read.step), (knob.encoder, 0.05));
        let text = written(&text, &[fader]);
        assert!(!text.contains("encoder") && text.contains("step = 0.05"), "{text}");
    }

    #[test]
    fn numbers_of_a_message_are_told_apart_and_other_sources_have_other_ends() {
        let tracker = Bind { sends: [-0.5, 0.5], ..osc("/hand 2", "b", true) };
        let text = written(PATCH, std::slice::from_ref(&tracker));
        assert!(
            text.contains("from = \"osc./hand 2\"\ncontrol = \"b\"\npickup = false\nsends = [-0.5, 0.5]\n"),
            "{text}"
        );
        // The same once more leaves them.
        assert_eq!(written(&text, &[osc("/hand 2", "b", true)]), text);
        for other in [osc("/hand 3", "b", true), midi("midi.controller 5", "b", 1, false)] {
            let text = written(&text, std::slice::from_ref(&other));
            assert!(!text.contains("sends"), "{text}");
            assert_eq!(
                Patch::parse("", text.as_bytes()).unwrap().value.binds.pop().unwrap().from,
                other.from
            );
        }
    }

    #[test]
    fn what_is_not_as_usual_is_said_and_what_cannot_be_is_told() {
        let bind = Bind {
            range: Some([0.75, 0.25]),
            curve: Some(Curve::Exponential),
            ..midi("midi.pressure", "b", 2, false)
        };
        let text = written(PATCH, std::slice::from_ref(&bind));
        assert!(text.contains("channel = 2\nrange = [0.75, 0.25]\ncurve = \"exponential\"\n"), "{text}");
        let read = Patch::parse("", text.as_bytes()).unwrap().value.binds.pop().unwrap();
        assert_eq!(Bind { span: bind.span.clone(), control_span: bind.control_span.clone(), ..read }, bind);
        let broken = |bind: Bind| matches!(bindings(PATCH, &[bind]), Err(EditError::Broken(_)));
        assert!(broken(midi("midi.bend", "c", 1, false)) && broken(midi("midi.bend", "b", 17, false)));
        assert!(broken(Bind { range: Some([f64::NAN, 1.0]), ..midi("midi.bend", "b", 1, false) }));
        let number = PATCH.replace("[control.a]", "bind = 3\n[control.a]");
        let number =
            number.replace("[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n", "");
        assert_eq!(bindings(&number, &[bind]), Err(EditError::Form("`bind`".into())));
    }
}
