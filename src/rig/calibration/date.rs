//! The day of a measurement.

use crate::text::reader::Reader;
use toml::de::DeValue;

/// A year, a month and a day, in quotes or as TOML has dates.
pub(super) fn date(reader: &Reader) -> Option<String> {
    let value = reader.at("date")?;
    let said = match value.value {
        DeValue::Datetime(date) => date.to_string(),
        _ => value.text().unwrap_or_default().to_string(),
    };
    if is_date(&said) {
        return Some(said);
    }
    let shown = if matches!(value.value, DeValue::Datetime(_)) { said } else { value.shown() };
    let what = format!("`date` of {} is {shown}; it must be a day: 2026-03-14", reader.who);
    reader.sink.error(&value.span(), what);
    None
}

pub(super) fn is_date(said: &str) -> bool {
    let parts: Vec<&str> = said.split('-').collect();
    let [year, month, day] = parts[..] else { return false };
    let number = |part: &str, digits: usize| {
        let all = part.len() == digits && part.bytes().all(|b| b.is_ascii_digit());
        part.parse::<u32>().ok().filter(|_| all)
    };
    let Some((year, month, day)) =
        number(year, 4).zip(number(month, 2)).zip(number(day, 2)).map(|((y, m), d)| (y, m, d))
    else {
        return false;
    };
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 => 28 + u32::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    (1..=days).contains(&day)
}
