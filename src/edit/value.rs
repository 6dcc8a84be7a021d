//! One value of a table in place of another.

use toml_edit::{Item, TableLike, Value};

/// Gives `key` another value, with the blanks and comments around the old one; where there is none, it gets a line of its own at the table's end.
pub(super) fn put(table: &mut dyn TableLike, key: &str, new: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            let decor = old.decor().clone();
            *old = new;
            *old.decor_mut() = decor;
        }
        None => drop(table.insert(key, Item::Value(new))),
    }
}

/// Makes room at the end of a table of one line: the space before its end belongs to the value that was the last.
pub(super) fn make_room(item: &mut Item, key: &str) {
    if let Some(inline) = item.as_inline_table_mut().filter(|table| !table.contains_key(key))
        && let Some((_, last)) = inline.iter_mut().last()
    {
        last.decor_mut().set_suffix("");
    }
}
