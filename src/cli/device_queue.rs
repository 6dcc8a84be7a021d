//! What a device still holds of what it was given: it goes out whatever the engine does.

use pacinian::live::board::Board;

/// In words, of a session whose output was shut now.
pub fn told(board: &Board) -> String {
    words(board.device_delay.get())
}

fn words(nanoseconds: Option<u64>) -> String {
    match nanoseconds {
        None => "the device does not say how much it still holds".into(),
        Some(nanoseconds) => format!("the device still held {:.1} ms", nanoseconds as f64 * 1e-6),
    }
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn what_is_not_known_is_not_nought() {
        assert_eq!(words(Some(21_333_333)), "the device still held 21.3 ms");
        assert_eq!(words(Some(0)), "the device still held 0.0 ms");
        assert_eq!(words(None), "the device does not say how much it still holds");
    }
}
