//! Delaunay triangles over places in a plane, checked.

use super::super::point::{Flat, cross, less};
use delaunator::{Point, triangulate};
use std::collections::BTreeMap;

/// An area, in squared extents, that counts as none.
pub(super) const NO_AREA: f64 = 1e-13;

/// Triangles that tile the convex hull of their corners.
#[derive(Debug)]
pub(super) struct Mesh {
    /// Corners of each, counter-clockwise.
    pub(super) triangles: Vec<[u32; 3]>,
    /// By an edge with its direction: the triangle to its left.
    pub(super) left: BTreeMap<(u32, u32), u32>,
    /// The hull, counter-clockwise; corners on a straight side may be among it.
    pub(super) hull: Vec<u32>,
}

impl Mesh {
    /// `None` where the triangles do not tile the hull or leave out a place, as rounding may have it for places that all but coincide.
    pub(super) fn of(places: &[Flat]) -> Option<Self> {
        let points: Vec<Point> = places.iter().map(|&[x, y]| Point { x, y }).collect();
        let found = triangulate(&points).triangles;
        let mut triangles: Vec<[u32; 3]> =
            found.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect();
        if triangles.iter().map(|t| area(places, *t)).sum::<f64>() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let mut left = BTreeMap::new();
        let mut seen = vec![false; places.len()];
        for (number, [a, b, c]) in triangles.iter().copied().enumerate() {
            for edge in [(a, b), (b, c), (c, a)] {
                if left.insert(edge, number as u32).is_some() {
                    return None;
                }
                seen[edge.0 as usize] = true;
            }
        }
        let areas: Vec<f64> = triangles.iter().map(|t| area(places, *t)).collect();
        let hull = outline(&left)?;
        let whole: f64 =
            (1..hull.len().saturating_sub(1)).map(|k| area(places, [hull[0], hull[k], hull[k + 1]])).sum();
        let convex = (0..hull.len()).all(|k| {
            let [a, b, c] = [0, 1, 2].map(|n| hull[(k + n) % hull.len()]);
            area(places, [a, b, c]) >= -NO_AREA
        });
        let whole_and_sound = seen.iter().all(|seen| *seen)
            && convex
            && areas.iter().all(|area| *area >= -NO_AREA)
            && (areas.iter().sum::<f64>() - whole).abs() <= 1e-9 * whole;
        whole_and_sound.then_some(Self { triangles, left, hull })
    }

    /// The corner of a triangle that an edge of it leaves out.
    pub(super) fn apex(&self, triangle: u32, edge: (u32, u32)) -> u32 {
        let corners = self.triangles[triangle as usize];
        corners.into_iter().find(|corner| *corner != edge.0 && *corner != edge.1).unwrap_or(corners[0])
    }
}

/// The area of a triangle; above 0 counter-clockwise.
pub(super) fn area(places: &[Flat], [a, b, c]: [u32; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|n| places[n as usize]);
    0.5 * cross(less(b, a), less(c, a))
}

/// The loop of edges that have nothing on their right; `None` if they are not one loop. It begins at its least corner.
pub(super) fn outline(left: &BTreeMap<(u32, u32), u32>) -> Option<Vec<u32>> {
    let mut next = BTreeMap::new();
    for &(a, b) in left.keys() {
        if !left.contains_key(&(b, a)) && next.insert(a, b).is_some() {
            return None;
        }
    }
    let first = *next.keys().next()?;
    let mut all = vec![first];
    let mut at = *next.get(&first)?;
    while at != first {
        if all.len() >= next.len() {
            return None;
        }
        all.push(at);
        at = *next.get(&at)?;
    }
    (all.len() == next.len()).then_some(all)
}
