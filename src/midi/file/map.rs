//! Ticks into seconds.

/// Microseconds of a quarter note until something else is said: 120 beats a minute.
const DEFAULT: u32 = 500_000;

/// What a tick is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Division {
    /// So many in a quarter note.
    Beat(u16),
    /// `units` / `divisor` seconds, whatever the tempo: frames of a film and their parts.
    Frame { units: u32, divisor: u32 },
}

impl Division {
    /// Of the last two bytes of the header.
    pub fn new([upper, lower]: [u8; 2]) -> Result<Self, String> {
        if upper < 0x80 {
            let ticks = u16::from_be_bytes([upper, lower]);
            return if ticks > 0 { Ok(Self::Beat(ticks)) } else { Err("a quarter note has 0 ticks".into()) };
        }
        if lower == 0 {
            return Err("a frame has 0 ticks".into());
        }
        // 29 stands for 30 frames in 1.001 s: drop-frame code.
        let (frames, units) = match upper.wrapping_neg() {
            29 => (30, 1_001),
            frames @ (24 | 25 | 30) => (u32::from(frames), 1_000),
            other => {
                return Err(format!("there are {other} frames a second, and 24, 25, 29 and 30 are defined"));
            }
        };
        Ok(Self::Frame { units, divisor: frames * u32::from(lower) * 1_000 })
    }
}

/// The times of ticks. They are counted in whole units, of which so many are a second, and divided once: the only rounding.
#[derive(Debug)]
pub(super) struct Map {
    steps: Vec<Step>,
    /// Units in a second.
    divisor: f64,
    /// Whether there are beats, so that there is a tempo.
    beats: bool,
}

/// From here on each tick has so many units.
#[derive(Debug, Clone, Copy)]
struct Step {
    tick: u64,
    before: u128,
    units: u32,
}

impl Map {
    /// Of tempi in microseconds a quarter note and the ticks where they begin; of several at a tick the last counts.
    pub fn new(division: Division, tempi: &mut [(u64, u32)]) -> Self {
        let (units, divisor, beats) = match division {
            Division::Beat(ticks) => (DEFAULT, f64::from(ticks) * 1e6, true),
            Division::Frame { units, divisor } => (units, f64::from(divisor), false),
        };
        let mut steps = vec![Step { tick: 0, before: 0, units }];
        tempi.sort_by_key(|(tick, _)| *tick);
        for (tick, units) in tempi.iter().copied().filter(|_| beats) {
            let before = steps.last().map_or(0, |step| step.units_at(tick));
            steps.push(Step { tick, before, units });
        }
        Self { steps, divisor, beats }
    }

    pub fn seconds(&self, tick: u64) -> f64 {
        let next = self.steps.partition_point(|step| step.tick <= tick);
        let step = next.checked_sub(1).and_then(|i| self.steps.get(i));
        step.map_or(0.0, |step| step.units_at(tick) as f64 / self.divisor)
    }

    /// Where the tempo changes, in seconds and quarter notes a minute.
    pub fn tempi(&self) -> impl Iterator<Item = (f64, f64)> {
        let named = self.steps.iter().skip(1).filter(|_| self.beats);
        named.map(|step| (step.before as f64 / self.divisor, 60e6 / f64::from(step.units)))
    }
}

impl Step {
    fn units_at(&self, tick: u64) -> u128 {
        self.before + u128::from(tick.saturating_sub(self.tick)) * u128::from(self.units)
    }
}
