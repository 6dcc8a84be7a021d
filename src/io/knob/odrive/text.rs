//! A line with its checksum.

use std::fmt::{Arguments, Write as _};

/// All bytes of a line, one upon the other.
pub fn checksum(line: &[u8]) -> u8 {
    line.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Appends a command with its checksum and line end.
pub(super) fn command(out: &mut Vec<u8>, words: Arguments<'_>) {
    let mut line = String::with_capacity(64);
    // A string takes whatever it is given.
    let _ = write!(line, "{words} ");
    let sum = checksum(line.as_bytes());
    let _ = writeln!(line, "*{sum}");
    out.extend_from_slice(line.as_bytes());
}

/// The text of an answer whose checksum is right. `None` where it is wrong or missing: whoever is asked with one answers with one.
pub fn answer(line: &[u8]) -> Option<&str> {
    let star = line.iter().rposition(|byte| *byte == b'*')?;
    let (text, sum) = (&line[..star], std::str::from_utf8(&line[star + 1..]).ok()?);
    let right = !sum.is_empty() && sum.bytes().all(|byte| byte.is_ascii_digit());
    if !right || sum.parse() != Ok(checksum(text)) {
        return None;
    }
    std::str::from_utf8(text).ok()
}

/// Position (turns) and velocity (turns a second).
pub(super) fn feedback(text: &str) -> Option<(f64, f64)> {
    let (position, velocity) = text.split_once(' ')?;
    let (position, velocity): (f64, f64) = (position.parse().ok()?, velocity.parse().ok()?);
    (position.is_finite() && velocity.is_finite()).then_some((position, velocity))
}

/// The value of a property, which may be cut. Firmware 0.5.3 puts a letter behind whole numbers; some say true and false.
pub(super) fn value(text: &str) -> Option<f64> {
    match text {
        "true" | "True" => Some(1.0),
        "false" | "False" => Some(0.0),
        _ => {
            let number: f64 = text.strip_suffix('d').unwrap_or(text).parse().ok()?;
            (!number.is_nan()).then_some(number)
        }
    }
}

/// A torque to a millionth, without a sign where it is nothing.
pub(super) fn torque(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

#[cfg(test)]
mod tests {
    use super::{answer, command, feedback, torque, value};

    fn of(words: &str) -> String {
        let mut out = Vec::new();
        command(&mut out, format_args!("{words}"));
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn commands_are_as_documented() {
        assert_eq!(of("r vbus_voltage"), "r vbus_voltage *93\n");
        assert_eq!(of("f 0"), "f 0 *86\n");
        assert_eq!(of(&format!("c 0 {}", torque(0.05))), "c 0 0.05 *104\n");
        assert_eq!(format!("{}", torque(-1e-9)), "0");
        assert_eq!(format!("{}", torque(-0.1234567)), "-0.123457");
    }

    #[test]
    fn an_answer_is_taken_with_its_checksum_alone() {
        assert_eq!(answer(b"f 0*118"), Some("f 0"));
        assert_eq!(answer(b"c 0 0.05*72"), Some("c 0 0.05"));
        for wrong in
            [&b"f 0*117"[..], b"f 0", b"f 0*", b"f 0*+118", b"f 0*374", b"*", b"", b"\xff*255", b"f 0*118 "]
        {
            assert_eq!(answer(wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn numbers_are_finite_or_none() {
        assert_eq!(feedback("-0.250000 1.500000"), Some((-0.25, 1.5)));
        for wrong in ["", "1", "1 2 3", "nan 0", "0 inf", "1e999 0", "a b", "1  2"] {
            assert_eq!(feedback(wrong), None, "{wrong}");
        }
        assert_eq!((value("0d"), value("8"), value("true")), (Some(0.0), Some(8.0), Some(1.0)));
        assert_eq!((value("inf"), value("lu"), value("nan")), (Some(f64::INFINITY), None, None));
    }
}
