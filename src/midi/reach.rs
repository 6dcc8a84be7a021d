//! From where to where each of several controllers went, so that somebody can be told what was heard of those that did not go far enough.

use std::collections::HashMap;
use std::hash::Hash;

/// Controllers that are told apart.
const MOST: usize = 1 << 12;

/// From where to where it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// The lowest position, 0 to 1,
    pub least: f64,
    /// and the highest.
    pub most: f64,
}

/// The same of several.
#[derive(Debug, Clone)]
pub struct Reaches<K> {
    all: HashMap<K, Reach>,
}

impl<K> Default for Reaches<K> {
    fn default() -> Self {
        Self { all: HashMap::new() }
    }
}

impl<K: Eq + Hash + Ord> Reaches<K> {
    /// It stands at `position`.
    pub fn hear(&mut self, key: K, position: f64) {
        if !position.is_finite() || (self.all.len() >= MOST && !self.all.contains_key(&key)) {
            return;
        }
        let reach = self.all.entry(key).or_insert(Reach { least: position, most: position });
        reach.least = reach.least.min(position);
        reach.most = reach.most.max(position);
    }

    /// The one that went furthest; of equals, whichever comes first by its key.
    pub fn most(&self) -> Option<(&K, Reach)> {
        let way = |reach: &Reach| reach.most - reach.least;
        let further = |a: &(&K, &Reach), b: &(&K, &Reach)| way(a.1).total_cmp(&way(b.1)).then(b.0.cmp(a.0));
        self.all.iter().max_by(further).map(|(key, reach)| (key, *reach))
    }

    /// How many were heard of.
    pub fn count(&self) -> usize {
        self.all.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Reach, Reaches};

    #[test]
    fn the_one_that_went_furthest_is_known() {
        let mut all = Reaches::default();
        assert!(all.most().is_none());
        for (key, position) in [(4, 0.5), (3, 0.2), (4, 0.4), (3, 0.25), (9, 0.9), (4, f64::NAN)] {
            all.hear(key, position);
        }
        assert_eq!(all.most(), Some((&4, Reach { least: 0.4, most: 0.5 })));
        assert_eq!(all.count(), 3);
        for key in 0..3 * MOST as i32 {
            all.hear(10 + key, 0.5);
        }
        assert_eq!(all.count(), MOST);
    }
}
