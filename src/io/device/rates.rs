//! Rates that a device runs at.

use std::fmt;

/// Ranges of rates, samples a second, in ascending order and apart from each other. Most cards have a few rates and none between them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rates(Vec<(u32, u32)>);

impl Rates {
    /// From the least to the most of each range, both included.
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32)> {
        self.0.iter().copied()
    }

    /// Whether it runs at that rate.
    pub fn contains(&self, rate: u32) -> bool {
        self.iter().any(|(least, most)| (least..=most).contains(&rate))
    }

    /// The rate that is nearest to one, of two as near the higher; that itself where there are none.
    pub fn nearest(&self, rate: u32) -> u32 {
        let all = self.iter().map(|(least, most)| rate.clamp(least, most));
        all.min_by_key(|near| (near.abs_diff(rate), u32::MAX - near)).unwrap_or(rate)
    }

    /// With another range; what overlaps it becomes one with it.
    pub(super) fn add(&mut self, (least, most): (u32, u32)) {
        let mut all = (least, most.max(least));
        self.0.retain(|&(least, most)| {
            let apart = most < all.0 || least > all.1;
            if !apart {
                all = (all.0.min(least), all.1.max(most));
            }
            apart
        });
        let place = self.0.partition_point(|range| range.0 < all.0);
        self.0.insert(place, all);
    }
}

/// `44100, 48000 to 96000`.
impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, (least, most)) in self.iter().enumerate() {
            let between = if n == 0 { "" } else { ", " };
            match least == most {
                true => write!(f, "{between}{least}")?,
                false => write!(f, "{between}{least} to {most}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Rates;

    fn of(ranges: &[(u32, u32)]) -> Rates {
        let mut rates = Rates::default();
        ranges.iter().for_each(|range| rates.add(*range));
        rates
    }

    #[test]
    fn between_the_rates_of_a_card_there_are_none() {
        let card = of(&[(96_000, 96_000), (44_100, 44_100), (48_000, 48_000), (44_100, 44_100)]);
        assert_eq!(card.to_string(), "44100, 48000, 96000");
        assert!(card.contains(48_000) && !card.contains(50_000) && !card.contains(192_000));
        let nearest = [8_000, 46_050, 50_000, 72_000, 200_000].map(|rate| card.nearest(rate));
        assert_eq!(nearest, [44_100, 48_000, 48_000, 96_000, 96_000]);
        assert_eq!(Rates::default().nearest(48_000), 48_000);
    }

    #[test]
    fn ranges_that_overlap_are_one() {
        let some =
            of(&[(8_000, 16_000), (32_000, 48_000), (15_000, 20_000), (96_000, 96_000), (40_000, 96_000)]);
        assert_eq!(some.iter().collect::<Vec<_>>(), [(8_000, 20_000), (32_000, 96_000)]);
        assert_eq!(some.to_string(), "8000 to 20000, 32000 to 96000");
        assert_eq!((some.nearest(25_000), some.nearest(44_100)), (20_000, 44_100));
    }
}
