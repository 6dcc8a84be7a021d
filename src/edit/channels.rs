//! Channels into the text of a rig.

use std::collections::BTreeMap;

use toml_edit::{ArrayOfTables, Item, Table, TableLike, Value, value};

use super::text::Text;
use super::value::put;
use super::{EditError, broken};
use crate::rig::Rig;

/// The text of a rig with outputs on other channels (from 1), by their places in `rig`, which was read from it. A rig that lists no tactors
/// gets a list of those that it has.
///
/// # Errors
/// A text that is not that of `rig`, and one that is no rig then, since two outputs are on one channel, or one is where there is none.
pub fn channels(source: &str, rig: &Rig, moved: &BTreeMap<usize, u32>) -> Result<String, EditError> {
    let mut text = Text::of(source);
    let document = text.document()?;
    let listed = ["tactor", "output"].iter().any(|key| document.contains_key(key));
    let channel =
        |n: usize| moved.get(&n).copied().unwrap_or(rig.outputs.get(n).map_or(0, |output| output.channel));
    if listed {
        for (n, channel) in moved {
            let name = rig.outputs.get(*n).map_or("", |output| output.name.as_str());
            text.change(|document| {
                let mut lists =
                    document.iter_mut().filter(|(key, _)| ["tactor", "output"].contains(&key.get()));
                let table = lists.find_map(|(_, list)| find(list, name));
                let table = table.filter(|table| table.contains_key("channel"));
                let table = table.ok_or_else(|| EditError::Missing(format!("output `{name}`")))?;
                put(table, "channel", i64::from(*channel).into())
            })?;
        }
    } else if !moved.is_empty() {
        // A line of tactors that stands nowhere yet.
        let mut tactors = ArrayOfTables::new();
        for (n, output) in rig.outputs.iter().enumerate() {
            let mut table = Table::new();
            table.insert("name", value(output.name.as_str()));
            table.insert("channel", value(i64::from(channel(n))));
            if let Some(position) = output.position {
                table.insert("position", value(position.into_iter().collect::<Value>()));
            }
            tactors.push(table);
        }
        text.change(|document| {
            document.insert("tactor", Item::ArrayOfTables(tactors));
            Ok(())
        })?;
    }
    let text = text.finish();
    // What will be read of it is what was meant.
    let read = Rig::parse("", text.as_bytes()).map_err(broken)?;
    let wanted = rig.outputs.iter().enumerate().map(|(n, output)| (output.name.as_str(), channel(n)));
    match wanted.eq(read.value.outputs.iter().map(|output| (output.name.as_str(), output.channel))) {
        true => Ok(text),
        false => Err(EditError::Form("list of outputs".into())),
    }
}

/// The table of that name, in a list of tables of either form.
fn find<'a>(item: &'a mut Item, name: &str) -> Option<&'a mut dyn TableLike> {
    let is_it = |table: &dyn TableLike| table.get("name").and_then(Item::as_str) == Some(name);
    match item {
        Item::ArrayOfTables(tables) => {
            tables.iter_mut().find(|table| is_it(*table)).map(|table| table as &mut dyn TableLike)
        }
        Item::Value(Value::Array(list)) => {
            let mut tables = list.iter_mut().filter_map(Value::as_inline_table_mut);
            tables.find(|table| is_it(*table)).map(|table| table as &mut dyn TableLike)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{EditError, channels};
    use crate::rig::Rig;

    fn written(source: &str, moved: &[(usize, u32)]) -> String {
        let rig = Rig::parse("r", source.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        channels(source, &rig, &moved.iter().copied().collect::<BTreeMap<_, _>>()).unwrap()
    }

    #[test]
    fn nothing_but_the_numbers_is_different() {
        let source = "#:schema x\nformat = \"pacinian-rig/1\"   # of these\n[device]\nchannels = 0x4\n\n# The left one.\n[[tactor]]\n\
            name = 'left' # here\n  channel   =  1     # white jack\ngain = 1.50\n\n[[tactor]]\nchannel = 2\nname = \"ri\\u0067ht\"\n\
            # last\n[[output]]\nkind = \"trigger\"\nname = \"eeg\"\nchannel = 3\n";
        let expected = source.replace("=  1     #", "=  2     #").replace("channel = 2\n", "channel = 1\n");
        assert_eq!(written(source, &[(0, 2), (1, 1)]), expected);
        assert_eq!(written(source, &[]), source);
        let crlf = |text: &str| format!("\u{feff}{}", text.replace('\n', "\r\n"));
        assert_eq!(written(&crlf(source), &[(0, 2), (1, 1)]), crlf(&expected));
        let inline = "format = \"pacinian-rig/1\"\ndevice = { channels = 3 }\ntactor = [\n  { name = \"a\", channel = 1 },  # one\n\
            \x20 { name = \"b\", channel = 2 },\n]\n";
        assert_eq!(written(inline, &[(1, 3)]), inline.replace("channel = 2", "channel = 3"));
    }

    #[test]
    fn what_is_not_there_or_cannot_be_is_told() {
        let source = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[[tactor]]\nname = \"a\"\nchannel = 1\n[[tactor]]\n\
            name = \"b\"\nchannel = 2\n";
        let rig = Rig::parse("r", source.as_bytes()).unwrap().value;
        let with = |source: &str, moved: &[(usize, u32)]| {
            channels(source, &rig, &moved.iter().copied().collect::<BTreeMap<_, _>>())
        };
        let another = source.replace("\"b\"", "\"c\"");
        assert_eq!(with(&another, &[(1, 1), (0, 2)]), Err(EditError::Missing("output `b`".into())));
        for (n, channel) in [(0, 2), (0, 3), (0, 0)] {
            assert!(matches!(with(source, &[(n, channel)]), Err(EditError::Broken(_))), "{channel}");
        }
        assert!(matches!(with("[", &[]), Err(EditError::Unreadable(_))));
    }

    #[test]
    fn a_line_that_stands_nowhere_is_written_out() {
        let source = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2 # both\n";
        assert_eq!(written(source, &[]), source, "nothing is another channel");
        let text = written(source, &[(0, 2), (1, 1)]);
        let crlf = |text: &str| text.replace('\n', "\r\n");
        assert_eq!(written(&crlf(source), &[(0, 2), (1, 1)]), crlf(&text));
        assert!(text.starts_with(source), "{text}");
        let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
        assert_eq!(
            rig.outputs.iter().map(|o| (o.name.as_str(), o.channel)).collect::<Vec<_>>(),
            [("t1", 2), ("t2", 1)]
        );
        assert_eq!(rig.outputs[1].position, Some([0.04, 0.0, 0.0]));
    }
}
