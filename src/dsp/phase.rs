//! Phase as a 64-bit fraction of a turn: it wraps by itself and keeps a frequency exact for hours.

/// `turns` (any sign, any size) as a phase. Not-a-number and infinity give 0.
pub fn turns(turns: f64) -> u64 {
    if !turns.is_finite() {
        return 0;
    }
    // The cast saturates, so a value that rounds up to one turn must wrap first.
    let fraction = turns - turns.floor();
    if fraction >= 1.0 { 0 } else { (fraction * TURN) as u64 }
}

/// A deviation in turns, at most ±½ a step, as a wrapping phase step; cheap enough for every sample.
#[inline(always)]
pub fn deviation(turns: f64) -> u64 {
    (turns * TURN) as i64 as u64
}

const TURN: f64 = 18_446_744_073_709_551_616.0;

#[cfg(test)]
mod tests {
    use super::turns;

    #[test]
    fn an_hour_of_phase_is_within_a_billionth_of_a_turn() {
        let step = turns(250.1 / 8000.0);
        let phase = step.wrapping_mul(8000 * 3600);
        let exact = 250.1_f64 * 3600.0;
        let error = phase as f64 / 2f64.powi(64) - exact;
        let error = error - error.round();
        assert!(error.abs() < 1e-8, "{error}");
    }

    #[test]
    fn hostile_values_give_a_phase() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(turns(value), 0);
        }
        assert_eq!(turns(-0.25), 3 << 62);
        assert_eq!(turns(-1e-300), 0);
        assert_eq!(turns(1e300), 0);
    }
}
