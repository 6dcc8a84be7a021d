//! The last readings.

/// So many readings, each kept twice, so that those up to the newest lie in one piece wherever it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ring {
    twice: Box<[f64]>,
    size: usize,
    /// Where the newest is, in the first half; older ones are behind it.
    newest: usize,
    filled: usize,
}

impl Ring {
    /// For the newest reading and so many before it.
    pub(super) fn new(before: usize) -> Self {
        let size = before + 1;
        Self { twice: vec![0.0; 2 * size].into_boxed_slice(), size, newest: 0, filled: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, reading: f64) {
        self.newest = if self.newest == 0 { self.size - 1 } else { self.newest - 1 };
        self.twice[self.newest] = reading;
        self.twice[self.newest + self.size] = reading;
        self.filled += usize::from(self.filled < self.size);
    }

    /// How many there are before the newest.
    #[inline(always)]
    pub(super) fn before(&self) -> usize {
        self.filled.saturating_sub(1)
    }

    /// What was read before the newest, by age.
    #[inline(always)]
    pub(super) fn past(&self) -> &[f64] {
        &self.twice[self.newest + 1..=self.newest + self.before()]
    }

    /// The reading so many before the newest; no more than [`before`](Self::before).
    #[inline(always)]
    pub(super) fn at(&self, age: usize) -> f64 {
        self.twice[self.newest + age]
    }

    /// As if nothing but `reading` had ever been read.
    pub(super) fn fill(&mut self, reading: f64) {
        self.twice.fill(reading);
        self.filled = self.size;
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;

    #[test]
    fn what_was_read_lies_in_its_order() {
        for size in [1, 2, 7] {
            let mut ring = Ring::new(size - 1);
            assert_eq!((ring.before(), ring.past().len()), (0, 0));
            let mut all: Vec<f64> = Vec::new();
            for n in 0..50 {
                ring.push(f64::from(n));
                all.push(f64::from(n));
                let past: Vec<f64> = all.iter().rev().skip(1).take(size - 1).copied().collect();
                assert_eq!((ring.past(), ring.before()), (&past[..], past.len()));
                (0..=past.len()).for_each(|age| assert_eq!(ring.at(age), all[all.len() - 1 - age]));
            }
            ring.fill(0.5);
            assert!(ring.before() == size - 1 && ring.at(size - 1) == 0.5);
        }
    }
}
