//! Tactors at one place count as one site.

use super::super::point::{Point, distance};

/// Tactors nearer than this, in metres, are at one place; in an array of more than a metre, this share of its extent.
const ONE_PLACE: f64 = 1e-9;

/// Distinct places, and which tactors are at each.
#[derive(Debug, Clone)]
pub(super) struct Sites {
    /// The position of the first tactor of each, in the order of the tactors.
    pub(super) places: Vec<Point>,
    /// Tactors in the order of their sites.
    tactors: Vec<u32>,
    /// By site: where its tactors begin; one more at the end.
    begins: Vec<u32>,
}

impl Sites {
    /// A tactor joins the first site that is near enough.
    pub(super) fn of(positions: &[Point]) -> Self {
        let extent = (0..3).map(|k| reach(positions, k)).fold(0.0, f64::max);
        let near = ONE_PLACE * extent.max(1.0);
        let mut places: Vec<Point> = Vec::new();
        let mut members: Vec<Vec<u32>> = Vec::new();
        for (tactor, position) in positions.iter().enumerate() {
            let found = places.iter().position(|place| {
                (place[0] - position[0]).abs() <= near && distance(*place, *position) <= near
            });
            match found {
                Some(site) => members[site].push(tactor as u32),
                None => {
                    places.push(*position);
                    members.push(vec![tactor as u32]);
                }
            }
        }
        let mut begins = vec![0];
        let mut tactors = Vec::new();
        for group in members {
            tactors.extend(group);
            begins.push(tactors.len() as u32);
        }
        Self { places, tactors, begins }
    }

    /// The tactors of a site; none of a site that is not there.
    #[inline(always)]
    pub(super) fn at(&self, site: u32) -> &[u32] {
        let site = site as usize;
        match (self.begins.get(site), self.begins.get(site + 1)) {
            (Some(&begin), Some(&end)) => self.tactors.get(begin as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// The median of the distances to the nearest other site; 0 for one site.
    pub(super) fn spacing(&self) -> f64 {
        let mut nearest: Vec<f64> = vec![f64::INFINITY; self.places.len()];
        for a in 0..self.places.len() {
            for b in a + 1..self.places.len() {
                let d = distance(self.places[a], self.places[b]);
                nearest[a] = nearest[a].min(d);
                nearest[b] = nearest[b].min(d);
            }
        }
        nearest.sort_by(f64::total_cmp);
        match nearest.len() {
            0 | 1 => 0.0,
            n => 0.5 * (nearest[(n - 1) / 2] + nearest[n / 2]),
        }
    }
}

/// From the least to the greatest of one coordinate.
fn reach(positions: &[Point], k: usize) -> f64 {
    let (least, most) = positions
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), p| (least.min(p[k]), most.max(p[k])));
    (most - least).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::Sites;

    #[test]
    fn tactors_at_one_place_are_one_site() {
        let sites =
            Sites::of(&[[0.0; 3], [1.0, 0.0, 0.0], [5e-10, 0.0, 0.0], [1.0, 0.0, 1e-10], [0.0, 2e-9, 0.0]]);
        assert_eq!(
            (sites.places.len(), sites.at(0), sites.at(1), sites.at(2)),
            (3, &[0, 2][..], &[1, 3][..], &[4][..])
        );
        assert!(sites.at(3).is_empty() && sites.at(u32::MAX).is_empty());
        // A kilometre away, a micrometre is nothing.
        assert_eq!(Sites::of(&[[0.0; 3], [1e3, 0.0, 0.0], [1e3, 9e-7, 0.0]]).places.len(), 2);
    }

    #[test]
    fn spacing_is_the_median_distance_to_the_nearest() {
        let line: Vec<_> = [0.0, 0.1, 0.3, 0.6].map(|x| [x, 0.0, 0.0]).to_vec();
        // Nearest: 0.1, 0.1, 0.2, 0.3.
        assert!((Sites::of(&line).spacing() - 0.15).abs() < 1e-15);
        assert_eq!(Sites::of(&line[..1]).spacing(), 0.0);
    }
}
