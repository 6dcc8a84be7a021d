//! The convex hull of a surface: where points go that lie outside.

use super::super::point::{Flat, inner, less, size};
use super::super::row::Row;
use super::mesh::Mesh;

/// A corner counts as on a side of the hull that it lies within, but no farther from it than this share of the side's piece.
const THIN: f64 = 0.02;

/// One side of the hull, with the sites along it.
#[derive(Debug, Clone)]
pub(super) struct Side {
    from: Flat,
    /// Of length 1, counter-clockwise.
    along: Flat,
    length: f64,
    /// Places along it, rising from 0 to its length, and the sites there.
    at: Vec<f64>,
    pub(super) sites: Vec<u32>,
}

impl Side {
    fn new(places: &[Flat], a: u32, b: u32) -> Self {
        let from = places[a as usize];
        let d = less(places[b as usize], from);
        let length = size(d);
        Self { from, along: d.map(|x| x / length), length, at: vec![0.0, length], sites: vec![a, b] }
    }

    /// How far along it a point lies, and how far outside.
    #[inline(always)]
    fn of(&self, p: Flat) -> (f64, f64) {
        let d = less(p, self.from);
        (inner(d, self.along), d[0] * self.along[1] - d[1] * self.along[0])
    }

    /// The point of it at a place along it.
    fn point(&self, t: f64) -> Flat {
        [self.from[0] + t * self.along[0], self.from[1] + t * self.along[1]]
    }

    /// Outward.
    pub(super) fn outward(&self) -> Flat {
        [self.along[1], -self.along[0]]
    }
}

/// All sides of a hull, counter-clockwise.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    pub(super) sides: Vec<Side>,
}

impl Rim {
    /// The sides of a mesh, and by triangle whether it is so thin that it belongs to one of them.
    ///
    /// A row of tactors that was meant to be straight is not quite so. Where one of it lies a little inward, a triangle fills the gap, in
    /// which weights would change from one tactor to another within no distance. Such triangles are taken off; what falls into one
    /// goes straight to the side, on which all of the row share it.
    pub(super) fn of(places: &[Flat], mesh: &Mesh) -> (Self, Vec<Option<u32>>) {
        let mut taken = vec![None; mesh.triangles.len()];
        let mut on_the_rim = vec![false; places.len()];
        mesh.hull.iter().for_each(|corner| on_the_rim[*corner as usize] = true);
        let n = mesh.hull.len();
        let mut sides = Vec::with_capacity(n);
        for k in 0..n {
            let mut side = Side::new(places, mesh.hull[k], mesh.hull[(k + 1) % n]);
            let mut piece = 0;
            while piece + 1 < side.sites.len() {
                let edge = (side.sites[piece], side.sites[piece + 1]);
                let thin = mesh.left.get(&edge).and_then(|&triangle| {
                    let apex = mesh.apex(triangle, edge);
                    let (t, _) = side.of(places[apex as usize]);
                    let rising = t - side.at[piece] > 1e-12 && side.at[piece + 1] - t > 1e-12;
                    let (_, outside) = Side::new(places, edge.0, edge.1).of(places[apex as usize]);
                    let near = -outside <= THIN * (side.at[piece + 1] - side.at[piece]);
                    (rising && near && !on_the_rim[apex as usize]).then_some((triangle, apex, t))
                });
                match thin {
                    Some((triangle, apex, t)) => {
                        taken[triangle as usize] = Some(k as u32);
                        on_the_rim[apex as usize] = true;
                        side.at.insert(piece + 1, t);
                        side.sites.insert(piece + 1, apex);
                    }
                    None => piece += 1,
                }
            }
            sides.push(side);
        }
        (Self { sides }, taken)
    }

    /// Shares the point of the hull that is nearest to a point outside it, and gives that point.
    ///
    /// It walks along the sides: on those that are seen from the point, the distance has but one minimum. A point that jumped to where
    /// the last side is not seen any more costs a look at every side.
    pub(super) fn share(&self, p: Flat, row: &mut Row) -> Flat {
        let n = self.sides.len();
        let mut k = (row.hint as usize).min(n.saturating_sub(1));
        if !self.sides.get(k).is_some_and(|side| side.of(p).1 > 0.0) {
            // Seen best; within the hull by rounding, this is the side that is nearest.
            let mut best = (0, f64::NEG_INFINITY);
            for (number, side) in self.sides.iter().enumerate() {
                let (_, outside) = side.of(p);
                if outside > best.1 {
                    best = (number, outside);
                }
            }
            k = best.0;
        }
        for _ in 0..n {
            let Some(side) = self.sides.get(k) else { return p };
            let (t, _) = side.of(p);
            let other = match t {
                t if t > side.length => (k + 1) % n,
                t if t < 0.0 => (k + n - 1) % n,
                _ => break,
            };
            let (t_there, _) = self.sides[other].of(p);
            // Beyond the end of the one and before the beginning of the other: the corner between them.
            if (t < 0.0 && t_there >= self.sides[other].length) || (t > side.length && t_there <= 0.0) {
                break;
            }
            k = other;
        }
        row.hint = k as u32;
        self.on(k as u32, p, row)
    }

    /// Shares a point on a side, as far along it as a point lies, and gives it.
    #[inline(always)]
    pub(super) fn on(&self, side: u32, p: Flat, row: &mut Row) -> Flat {
        let Some(side) = self.sides.get(side as usize) else { return p };
        let t = side.of(p).0.max(0.0).min(side.length);
        let piece = match side.at.len() {
            0..=2 => 0,
            n => side.at.partition_point(|place| *place <= t).clamp(1, n - 1) - 1,
        };
        let (a, b) = (side.at[piece], side.at[piece + 1]);
        let share = (t - a) / (b - a);
        row.push(side.sites[piece], 1.0 - share);
        row.push(side.sites[piece + 1], share);
        side.point(t)
    }
}
