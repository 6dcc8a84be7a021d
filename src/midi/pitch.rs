//! Notes as frequencies and as names.

/// The note A above middle C.
const A4: u8 = 69;
/// Its frequency (ISO 16).
const A4_HERTZ: f64 = 440.0;
const NAMES: [&str; 12] = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];

/// The frequency of a note in Hz, `bend` semitones above it: equal temperament with A4 = 69 = 440 Hz (MIDI Tuning Standard). Middle C, 60, is
/// 261.63 Hz; all of the vibration that pacinian makes lies below 1 kHz, which is between notes 83 and 84.
pub fn hertz(note: u8, bend: f64) -> f64 {
    A4_HERTZ * ((f64::from(note) - f64::from(A4) + bend) / 12.0).exp2()
}

/// The name of a note, with middle C, 60, as C4: from C-1 to G9. Notes above 127 have none.
pub fn name(note: u8) -> Option<String> {
    let pitch = NAMES.get(usize::from(note % 12)).filter(|_| note < 128)?;
    Some(format!("{pitch}{}", i16::from(note / 12) - 1))
}

/// The note of a name such as `C4`, `f#3` or `Bb-1`, as [`name`] counts octaves. `None` for what is no name, or beyond the 128 notes.
pub fn note(name: &str) -> Option<u8> {
    let mut letters = name.chars();
    let letter = letters.next()?.to_ascii_uppercase();
    let pitch = NAMES.iter().position(|n| n.len() == 1 && n.starts_with(letter))? as i16;
    let rest = letters.as_str();
    let (shift, octave) = match rest.chars().next()? {
        '#' => (1, rest.get(1..)?),
        'b' => (-1, rest.get(1..)?),
        _ => (0, rest),
    };
    let number = octave.strip_prefix('-').unwrap_or(octave);
    if number.is_empty() || number.len() > 2 || !number.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let octave: i16 = octave.parse().ok()?;
    u8::try_from((octave + 1) * 12 + pitch + shift).ok().filter(|note| *note < 128)
}

#[cfg(test)]
mod tests {
    use super::{hertz, name, note};

    #[test]
    fn twelve_equal_steps_make_an_octave() {
        assert_eq!(
            [hertz(69, 0.0), hertz(57, 0.0), hertz(69, 12.0), hertz(69, -24.0)],
            [440.0, 220.0, 880.0, 110.0]
        );
        assert!((hertz(60, 0.0) - 261.625_565_300_598_6).abs() < 1e-9, "middle C");
        assert!((hertz(0, 0.0) - 8.175_798_915_643_707).abs() < 1e-12);
        assert!((hertz(60, 0.5) / hertz(60, 0.0) - 2_f64.powf(1.0 / 24.0)).abs() < 1e-15);
        assert!(hertz(83, 0.0) < 1_000.0 && hertz(84, 0.0) > 1_000.0);
    }

    #[test]
    fn names_read_back() {
        let expected = [(60, "C4"), (69, "A4"), (0, "C-1"), (127, "G9"), (61, "C#4"), (11, "B-1")];
        for (number, text) in expected {
            assert_eq!(name(number).as_deref(), Some(text));
        }
        assert!((0..128).all(|n| note(&name(n).unwrap()) == Some(n)));
        assert_eq!(name(128), None);
        assert_eq!(
            [note("c4"), note("Db4"), note("Cb4"), note("B#3")],
            [Some(60), Some(61), Some(59), Some(60)]
        );
        for wrong in
            ["", "C", "H4", "C#", "4", "C--1", "C+4", "Cb-1", "G#9", "C99999999", "Cé4", "é4", "C 4", "C4 "]
        {
            assert_eq!(note(wrong), None, "{wrong}");
        }
    }
}
