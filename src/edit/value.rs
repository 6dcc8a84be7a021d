//! One value of a table in place of another.

use toml_edit::{InlineTable, Item, TableLike, Value};

use super::EditError;

/// Gives `key` another value, with the blanks and comments around the old one; where there is none, it is the table's last.
///
/// # Errors
/// A table or a list of them in its place.
pub(super) fn put(table: &mut dyn TableLike, key: &str, new: Value) -> Result<(), EditError> {
    let Some(item) = table.get_mut(key) else {
        table.insert(key, Item::Value(new));
        return Ok(());
    };
    let old = item.as_value_mut().ok_or_else(|| EditError::Form(format!("`{key}`")))?;
    let decor = old.decor().clone();
    *old = new;
    *old.decor_mut() = decor;
    Ok(())
}

/// Changes a table in either form; `what` it is, where it is none. In one of one line, the blanks before its end stay there.
///
/// # Errors
/// Something that is no table, and those of the change.
pub(super) fn table(
    item: &mut Item,
    what: &str,
    change: impl FnOnce(&mut dyn TableLike) -> Result<(), EditError>,
) -> Result<(), EditError> {
    match item.as_inline_table_mut() {
        Some(inline) => one_line(inline, change),
        None => change(item.as_table_like_mut().ok_or_else(|| EditError::Form(what.into()))?),
    }
}

/// The same of a table of one line.
pub(super) fn one_line(
    table: &mut InlineTable,
    change: impl FnOnce(&mut dyn TableLike) -> Result<(), EditError>,
) -> Result<(), EditError> {
    let last = |table: &InlineTable| table.iter().last().map(|(key, _)| key.to_string());
    let before = last(table);
    change(table)?;
    let (Some(before), Some(now)) = (before, last(table)) else { return Ok(()) };
    if before == now {
        return Ok(());
    }
    let is_blank = |blank: &&str| !blank.is_empty() && blank.chars().all(|c| c == ' ' || c == '\t');
    let end = table.get(&before).and_then(|value| value.decor().suffix()?.as_str().filter(is_blank));
    if let Some(end) = end.map(String::from) {
        let mut set = |key: &str, end: &str| {
            table.get_mut(key).into_iter().for_each(|value| value.decor_mut().set_suffix(end));
        };
        set(&before, "");
        set(&now, &end);
    }
    Ok(())
}
