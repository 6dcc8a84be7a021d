//! Positions on paper: one view of what is flat, two of what has a front and a back.

use super::Site;

/// The axes by their names, toward the greater and the lesser end.
const SIDES: [[&str; 2]; 3] = [["right", "left"], ["above", "below"], ["ahead", "behind"]];
const AXES: [&str; 3] = ["x", "y", "z"];

/// What is flatter than this share of its extent is flat.
const FLAT: f64 = 0.05;
/// Extents so near each other are one.
const ALIKE: f64 = 0.9;

/// Tactors on paper.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    /// What it shows; nothing where it is the only one.
    pub label: &'static str,
    /// Its tactors: their numbers, and where they are, m, to the right and up from the corner at the lower left.
    pub tactors: Vec<(usize, [f64; 2])>,
}

/// Views side by side, all of one size.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Views {
    pub list: Vec<View>,
    /// What goes to the right and up.
    pub axes: [&'static str; 2],
    /// Metres to the right and up.
    pub size: [f64; 2],
    /// The distance to the nearest neighbour on paper that is not at the same place; 0 with one place.
    pub spacing: f64,
}

impl Views {
    pub fn new(sites: &[Site]) -> Self {
        let least = |axis: usize| sites.iter().map(|s| s.position[axis]).fold(f64::INFINITY, f64::min);
        let most = |axis: usize| sites.iter().map(|s| s.position[axis]).fold(f64::NEG_INFINITY, f64::max);
        let extent = [0, 1, 2].map(|axis| (most(axis) - least(axis)).max(0.0));
        let widest = extent.iter().copied().fold(0.0, f64::max);
        // The depth: of what goes around something, ahead or up, whichever is not along it; else what is least, of equals rather ahead or up.
        let thinnest = extent.iter().copied().fold(f64::INFINITY, f64::min);
        let least_deep = [2, 1, 0].into_iter().find(|axis| ALIKE * extent[*axis] <= thinnest).unwrap_or(2);
        let is_flat = sites.is_empty() || extent[least_deep] <= FLAT * widest;
        let deep = match along(sites, extent) {
            Some(axis) if !is_flat => {
                if axis == 2 {
                    1
                } else {
                    2
                }
            }
            _ => least_deep,
        };
        let [right, up] = match deep {
            0 => [2, 1],
            1 => [0, 2],
            _ => [0, 1],
        };
        let middle = 0.5 * (least(deep) + most(deep));
        let tactors = |side: usize| {
            let here = |site: &Site| is_flat || (site.position[deep] >= middle) == (side == 0);
            let on_paper = |site: &Site| [site.position[right] - least(right), site.position[up] - least(up)];
            sites
                .iter()
                .enumerate()
                .filter(|(_, site)| here(site))
                .map(|(n, site)| (n, on_paper(site)))
                .collect()
        };
        let list: Vec<View> = if is_flat {
            vec![View { label: "", tactors: tactors(0) }]
        } else {
            [0, 1].map(|side| View { label: SIDES[deep][side], tactors: tactors(side) }).into()
        };
        let spacing = list.iter().map(spacing).fold(f64::INFINITY, f64::min);
        Self {
            list,
            axes: [AXES[right], AXES[up]],
            size: [extent[right], extent[up]],
            spacing: if spacing.is_finite() { spacing } else { 0.0 },
        }
    }
}

/// The axis about which tactors go around, if there is one: seen along it, none is near the middle.
fn along(sites: &[Site], extent: [f64; 3]) -> Option<usize> {
    let hollow = |axis: usize| {
        let across: Vec<usize> = (0..3).filter(|other| *other != axis && extent[*other] > 0.0).collect();
        if across.len() < 2 {
            return 0.0;
        }
        let middle = |a: usize| {
            let all = sites.iter().map(|site| site.position[a]);
            0.5 * (all.clone().fold(f64::INFINITY, f64::min) + all.fold(f64::NEG_INFINITY, f64::max))
        };
        let away = |site: &Site| {
            let far = |a: usize| (site.position[a] - middle(a)) / extent[a];
            across.iter().map(|a| far(*a)).fold(0.0, f64::hypot)
        };
        sites.iter().map(away).fold(f64::INFINITY, f64::min)
    };
    let all = [0, 1, 2].map(hollow);
    let most = all.iter().copied().fold(0.0, f64::max);
    // A quarter of the width is free about the middle.
    (most >= 0.25).then(|| all.iter().position(|h| *h == most)).flatten()
}

/// The distance of the nearest two at unlike places.
fn spacing(view: &View) -> f64 {
    let mut least = f64::INFINITY;
    for (n, (_, a)) in view.tactors.iter().enumerate() {
        for (_, b) in &view.tactors[n + 1..] {
            let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
            if apart > 1e-6 {
                least = least.min(apart);
            }
        }
    }
    least
}
