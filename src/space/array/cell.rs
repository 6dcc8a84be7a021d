//! One tile of a surface: a triangle, a rectangle, or a polygon on a circle.

use super::super::point::{Flat, cross, inner, less, size};
use super::super::row::Row;
use super::tile::Form;

/// A polygon has no more corners; one with more stays in triangles.
pub(super) const MOST_CORNERS: usize = 64;
/// A point counts as within a tile up to this far outside, in shares of the tile.
pub(super) const ON_THE_EDGE: f64 = -1e-13;
/// Only so far within a tile, no other can hold the point as well.
pub(super) const WELL_WITHIN: f64 = 1e-9;

/// What a tile does with a point.
#[derive(Debug, Clone)]
pub(super) enum Kind {
    /// Barycentric coordinates of three corners.
    Triangle,
    /// Bilinear coordinates of four corners.
    Rectangle,
    /// Wachspress coordinates of the corners of a convex polygon.
    Polygon(Box<Polygon>),
    /// A thin triangle at the rim: it belongs to this side of the hull.
    Margin(u32),
}

/// A tile; its coordinates are taken from its first corner, so that they keep their places where it is small.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    origin: Flat,
    /// What a step adds to the share of the second corner, or of the second and third of a rectangle.
    u: Flat,
    /// The same for the third corner, or the third and fourth.
    v: Flat,
    corners: [u32; 4],
    pub(super) kind: Kind,
}

/// The edges of a convex polygon.
#[derive(Debug, Clone)]
pub(super) struct Polygon {
    corners: Vec<u32>,
    places: Vec<Flat>,
    /// Inward, of the edge that begins at each corner, and as long as one over the polygon's size.
    normals: Vec<Flat>,
    /// The sine of the turn at each corner.
    turns: Vec<f64>,
}

impl Cell {
    /// A triangle, counter-clockwise; `None` where it has no area to speak of.
    pub(super) fn triangle(places: &[Flat], [a, b, c]: [u32; 3], kind: Kind) -> Option<Self> {
        let [p, q, r] = [a, b, c].map(|n| places[n as usize]);
        let (e, f) = (less(q, p), less(r, p));
        let twice = cross(e, f);
        let widest = inner(e, e).max(inner(f, f)).max(inner(less(r, q), less(r, q)));
        (twice > super::mesh::NO_AREA * widest).then(|| Self {
            origin: p,
            u: [f[1] / twice, -f[0] / twice],
            v: [-e[1] / twice, e[0] / twice],
            corners: [a, b, c, 0],
            kind,
        })
    }

    /// A polygon, counter-clockwise: a rectangle where it is one; `None` where it is not convex.
    pub(super) fn polygon(places: &[Flat], corners: &[u32]) -> Option<Self> {
        let n = corners.len();
        let at: Vec<Flat> = corners.iter().map(|c| places[*c as usize]).collect();
        let edges: Vec<Flat> = (0..n).map(|k| less(at[(k + 1) % n], at[k])).collect();
        let lengths: Vec<f64> = edges.iter().map(|e| size(*e)).collect();
        let whole = lengths.iter().sum::<f64>();
        let turns: Vec<f64> = (0..n)
            .map(|k| cross(edges[(k + n - 1) % n], edges[k]) / (lengths[(k + n - 1) % n] * lengths[k]))
            .collect();
        if n < 4 || turns.iter().any(|turn| turn.is_nan() || *turn < 1e-9) {
            return None;
        }
        let mut cell =
            Self { origin: at[0], u: [0.0; 2], v: [0.0; 2], corners: [0; 4], kind: Kind::Rectangle };
        let (e, f) = (edges[0], less(at[n - 1], at[0]));
        let fourth = less(at[2], [at[0][0] + e[0] + f[0], at[0][1] + e[1] + f[1]]);
        // Four corners on a circle are a rectangle where they are a parallelogram.
        if n == 4 && size(fourth) <= 1e-9 * whole {
            cell.corners = [corners[0], corners[1], corners[2], corners[3]];
            cell.u = e.map(|x| x / inner(e, e));
            cell.v = f.map(|x| x / inner(f, f));
        } else {
            let normals =
                (0..n).map(|k| [-edges[k][1], edges[k][0]].map(|x| x / (lengths[k] * whole))).collect();
            let polygon = Polygon { corners: corners.to_vec(), places: at, normals, turns };
            cell.kind = Kind::Polygon(Box::new(polygon));
        }
        Some(cell)
    }

    /// The corners, for a search.
    pub(super) fn corners(&self) -> &[u32] {
        match &self.kind {
            Kind::Triangle | Kind::Margin(_) => &self.corners[..3],
            Kind::Rectangle => &self.corners,
            Kind::Polygon(polygon) => &polygon.corners,
        }
    }

    /// The least sine of a turn at a corner; a rectangle's is 1.
    pub(super) fn bluntest(&self) -> f64 {
        match &self.kind {
            Kind::Polygon(polygon) => polygon.turns.iter().copied().fold(1.0, f64::min),
            _ => 1.0,
        }
    }

    /// How far within a point lies, in shares of the tile, below 0 outside; and its coordinates in it.
    #[inline(always)]
    pub(super) fn depth(&self, p: Flat) -> (f64, Flat) {
        let d = less(p, self.origin);
        let (u, v) = (inner(self.u, d), inner(self.v, d));
        let depth = match &self.kind {
            Kind::Triangle | Kind::Margin(_) => u.min(v).min(1.0 - u - v),
            Kind::Rectangle => u.min(v).min((1.0 - u).min(1.0 - v)),
            Kind::Polygon(polygon) => polygon.depth(p),
        };
        (depth, [u, v])
    }

    /// As a tile, if its weights are products of coordinates and its corners are its own.
    #[inline]
    pub(super) fn tile(&self) -> Option<(Form, [Flat; 2], [u32; 4])> {
        let form = match self.kind {
            Kind::Triangle => Form::Triangle,
            Kind::Rectangle => Form::Rectangle,
            Kind::Polygon(_) | Kind::Margin(_) => return None,
        };
        Some((form, [self.u, self.v], self.corners))
    }

    /// Whether a depth is that of a point within, or on the edge.
    #[inline(always)]
    pub(super) fn holds(depth: f64) -> bool {
        depth >= ON_THE_EDGE
    }

    /// Shares a point that lies within, by its coordinates there.
    #[inline(always)]
    pub(super) fn share(&self, p: Flat, [u, v]: Flat, row: &mut Row) {
        let [a, b, c, e] = self.corners;
        match &self.kind {
            Kind::Triangle | Kind::Margin(_) => {
                row.push(a, 1.0 - u - v);
                row.push(b, u);
                row.push(c, v);
            }
            Kind::Rectangle => {
                row.push(a, (1.0 - u) * (1.0 - v));
                row.push(b, u * (1.0 - v));
                row.push(c, u * v);
                row.push(e, (1.0 - u) * v);
            }
            Kind::Polygon(polygon) => polygon.share(p, row),
        }
    }
}

impl Polygon {
    #[inline(always)]
    fn height(&self, edge: usize, p: Flat) -> f64 {
        inner(self.normals[edge], less(p, self.places[edge]))
    }

    fn depth(&self, p: Flat) -> f64 {
        (0..self.corners.len()).map(|k| self.height(k, p)).fold(f64::INFINITY, f64::min)
    }

    /// w ∝ sin(turn) / (heights over the two edges that meet there): Wachspress, "A Rational Finite Element Basis", 1975, in the form of
    /// Meyer, Lee, Barr & Desbrun, "Generalized Barycentric Coordinates on Irregular Polygons", 2002. All are multiplied by the two
    /// least heights, so that they hold on edges and at corners as well.
    fn share(&self, p: Flat, row: &mut Row) {
        let n = self.corners.len();
        let mut heights = [0.0; MOST_CORNERS];
        let (mut least, mut second) = (0, 1);
        for k in 0..n {
            // Not quite 0, of which there could be three.
            heights[k] = self.height(k, p).max(1e-100);
        }
        if heights[1] < heights[0] {
            (least, second) = (1, 0);
        }
        for k in 2..n {
            if heights[k] < heights[least] {
                (least, second) = (k, least);
            } else if heights[k] < heights[second] {
                second = k;
            }
        }
        // One of the two over a height that may itself be one of them.
        let part = |edge: usize| {
            if edge == least || edge == second { 1.0 } else { 1.0 / heights[edge] }
        };
        let mut sum = 0.0;
        let mut weights = [0.0; MOST_CORNERS];
        for k in 0..n {
            let before = if k == 0 { n - 1 } else { k - 1 };
            weights[k] = self.turns[k] * part(before) * part(k);
            for edge in [least, second] {
                if edge != before && edge != k {
                    weights[k] *= heights[edge];
                }
            }
            sum += weights[k];
        }
        for k in 0..n {
            row.push(self.corners[k], weights[k] / sum);
        }
    }
}
