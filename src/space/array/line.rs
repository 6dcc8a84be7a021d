//! Tactors on a line: two neighbours share what lies between them.

use super::super::row::Row;

/// Sites by their place along a line.
#[derive(Debug, Clone)]
pub(super) struct Line {
    /// Places, rising.
    pub(super) at: Vec<f64>,
    /// Which site is there.
    sites: Vec<u32>,
}

impl Line {
    /// From places along the line and off it; `None` where neighbours lie further apart beside the line than half of what they do along it.
    pub(super) fn of(places: &[[f64; 3]]) -> Option<Self> {
        let mut order: Vec<u32> = (0..places.len() as u32).collect();
        order.sort_by(|&a, &b| places[a as usize][0].total_cmp(&places[b as usize][0]));
        let steep = order.windows(2).any(|pair| {
            let [a, b] = [places[pair[0] as usize], places[pair[1] as usize]];
            let off = ((b[1] - a[1]).powi(2) + (b[2] - a[2]).powi(2)).sqrt();
            off > 0.5 * (b[0] - a[0])
        });
        (!steep).then(|| Self { at: order.iter().map(|&n| places[n as usize][0]).collect(), sites: order })
    }

    /// Shares a place, and says where it is when it was held within the ends.
    #[inline(always)]
    pub(super) fn share(&self, t: f64, row: &mut Row) -> f64 {
        let (Some(&first), Some(&last)) = (self.at.first(), self.at.last()) else { return t };
        let t = t.max(first).min(last);
        let segment = self.segment(t, row.hint as usize);
        row.hint = segment as u32;
        let Some([a, b]) = self.at.get(segment..segment + 2) else { return t };
        let share = (t - a) / (b - a);
        let (low, high) = (self.sites[segment], self.sites[segment + 1]);
        row.push(low, 1.0 - share);
        row.push(high, share);
        t
    }

    /// A segment: one over its length, and the sites at its ends.
    #[inline]
    pub(super) fn tile(&self, segment: u32) -> Option<(f64, [u32; 2])> {
        let segment = segment as usize;
        let [a, b] = self.at.get(segment..segment.checked_add(2)?)? else { return None };
        Some((1.0 / (b - a), [self.sites[segment], self.sites[segment + 1]]))
    }

    /// The segment that holds a place within the ends: the one of last time, or by halving.
    #[inline(always)]
    fn segment(&self, t: f64, hint: usize) -> usize {
        if let Some([a, b]) = self.at.get(hint..hint.saturating_add(2))
            && (*a..=*b).contains(&t)
        {
            return hint;
        }
        self.at.partition_point(|place| *place <= t).clamp(1, self.at.len() - 1) - 1
    }
}
