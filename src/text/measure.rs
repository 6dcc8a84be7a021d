//! Numbers with a unit, as people write them where a bare number is wanted.

/// What to write instead of a text like "120 Hz", "4ms" or "50%" at `key`; `None` where it is none.
pub fn advice(key: &str, text: &str) -> Option<String> {
    let text = text.trim();
    let end = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    let (end, number) = end.filter_map(|end| Some((end, text[..end].parse::<f64>().ok()?))).next()?;
    let unit = text[end..].trim();
    // "inf" and "nan" are words.
    if !number.is_finite() || !text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        return None;
    }
    if unit.is_empty() {
        return Some(format!("a number stands without quotes: write {key} = {}", shown(number)));
    }
    let factor = match unit.to_lowercase().as_str() {
        "hz" | "s" | "sec" | "m" | "v" | "a" | "db" => 1.0,
        "khz" => 1e3,
        "ms" | "mm" => 1e-3,
        "cm" | "%" => 1e-2,
        "us" | "µs" => 1e-6,
        _ => return None,
    };
    Some(format!("write {key} = {}: {UNITS}", shown(number * factor)))
}

const UNITS: &str = "numbers have no unit here; frequency is in Hz, times in s, shares from 0 to 1";

/// A number as it is said in a sentence: in full where that is short, else with a power of ten.
pub fn number(x: f64) -> String {
    match x.abs() {
        size if size == 0.0 || (1e-6..1e12).contains(&size) || !x.is_finite() => x.to_string(),
        _ => format!("{x:e}"),
    }
}

/// Without what only the binary system adds.
fn shown(x: f64) -> String {
    format!("{:.9}", x).trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::{advice, number};

    #[test]
    fn no_number_is_long() {
        for (x, wanted) in [
            (0.0, "0"),
            (-3.0, "-3"),
            (1e6, "1000000"),
            (0.125, "0.125"),
            (1e300, "1e300"),
            (-2.5e-9, "-2.5e-9"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(x), wanted);
        }
    }

    #[test]
    fn units_are_taken_off() {
        for (text, wanted) in [
            ("120 Hz", "write x = 120:"),
            ("250Hz", "write x = 250:"),
            ("1.2 kHz", "write x = 1200:"),
            ("4ms", "write x = 0.004:"),
            ("50%", "write x = 0.5:"),
            ("-3 mm", "write x = -0.003:"),
            ("1e3", "without quotes: write x = 1000"),
            ("7", "without quotes: write x = 7"),
        ] {
            let advice = advice("x", text).unwrap_or_default();
            assert!(advice.contains(wanted), "{text}: {advice}");
        }
        for text in ["", "Hz", "tone", "2 * tone", "4 parsecs", "inf", "nan Hz", "µ", "1µ"] {
            assert_eq!(advice("x", text), None, "{text}");
        }
    }
}
