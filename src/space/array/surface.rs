//! Tactors on a surface: cells between neighbours, and the hull around them.

use super::super::point::{Flat, cross, less, size};
use super::super::row::Row;
use super::cell::{Cell, Kind, WELL_WITHIN};
use super::mesh::Mesh;
use super::rim::Rim;
use super::tile::Form;
use super::tiles::tiles;

/// Neighbours whose distance off the plane is more than this share of that in it lie on no surface.
const STEEPEST: f64 = 0.5;
/// No surface is cut into more fields.
const MOST_FIELDS: usize = 65_536;

/// Cells, found by the fields of a grid.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    cells: Vec<Cell>,
    rim: Rim,
    /// The corner of the grid and its size, fields for each unit, and how many there are along each axis.
    corner: Flat,
    size: Flat,
    rate: Flat,
    fields: [usize; 2],
    /// By field: where its cells begin in `held`; one more at the end.
    begins: Vec<u32>,
    held: Vec<u32>,
    /// Edges between cells and around them, for paths that cross them.
    edges: Vec<[u32; 2]>,
}

impl Surface {
    /// From places in a plane and off it; `None` where they are not over it like a sheet.
    pub(super) fn of(places: &[[f64; 3]]) -> Option<Self> {
        let flat: Vec<Flat> = places.iter().map(|p| [p[0], p[1]]).collect();
        let mesh = Mesh::of(&flat)?;
        let steep = mesh.left.keys().any(|&(a, b)| {
            let off = places[a as usize][2] - places[b as usize][2];
            off.abs() > STEEPEST * size(less(flat[a as usize], flat[b as usize]))
        });
        if steep {
            return None;
        }
        let (rim, taken) = Rim::of(&flat, &mesh);
        let (mut cells, edges) = tiles(&flat, &mesh, &taken);
        cells.extend(taken.iter().enumerate().filter_map(|(number, side)| {
            Cell::triangle(&flat, mesh.triangles[number], Kind::Margin((*side)?))
        }));
        let mut surface = Self {
            cells,
            rim,
            corner: [0.0; 2],
            size: [0.0; 2],
            rate: [0.0; 2],
            fields: [1, 1],
            begins: Vec::new(),
            held: Vec::new(),
            edges,
        };
        surface.sort_into_fields(&flat);
        Some(surface)
    }

    /// Some two fields a cell; each knows the cells whose bounds touch it.
    fn sort_into_fields(&mut self, flat: &[Flat]) {
        let bounds = |sites: &mut dyn Iterator<Item = u32>| {
            sites.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], site| {
                let p = flat[site as usize];
                [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
            })
        };
        let [low, high] = bounds(&mut (0..flat.len() as u32));
        let wide = less(high, low).map(|w| w.max(1e-9));
        let wanted = (2 * self.cells.len()).clamp(1, MOST_FIELDS) as f64;
        let edge = (wide[0] * wide[1] / wanted).sqrt();
        self.fields = wide.map(|w| ((w / edge).ceil() as usize).clamp(1, 4096));
        (self.corner, self.size) = (low, wide);
        self.rate = [0, 1].map(|k| self.fields[k] as f64 / wide[k]);
        let mut lists = vec![Vec::new(); self.fields[0] * self.fields[1]];
        for (number, cell) in self.cells.iter().enumerate() {
            let [low, high] = bounds(&mut cell.corners().iter().copied());
            // A little more, for points on the edge.
            let ([x0, y0], [x1, y1]) =
                (self.field(low.map(|x| x - 1e-9)), self.field(high.map(|x| x + 1e-9)));
            for y in y0..=y1 {
                for x in x0..=x1 {
                    lists[y * self.fields[0] + x].push(number as u32);
                }
            }
        }
        self.begins = vec![0];
        for list in lists {
            self.held.extend(list);
            self.begins.push(self.held.len() as u32);
        }
    }

    /// The field of a point, or the nearest.
    #[inline(always)]
    fn field(&self, p: Flat) -> [usize; 2] {
        // The cast holds what is below 0 at 0.
        [0, 1].map(|k| (((p[k] - self.corner[k]) * self.rate[k]) as usize).min(self.fields[k] - 1))
    }

    /// How many cells there are.
    pub(super) fn cells(&self) -> usize {
        self.cells.len()
    }

    /// A cell as a tile.
    #[inline]
    pub(super) fn tile(&self, cell: u32) -> Option<(Form, [Flat; 2], [u32; 4])> {
        self.cells.get(cell as usize)?.tile()
    }

    /// The cell that holds a point: the one of last time if it lies well within, else the one in which it lies deepest.
    #[inline(always)]
    fn find(&self, p: Flat, hint: u32) -> Option<(u32, Flat)> {
        if let Some(cell) = self.cells.get(hint as usize) {
            let (depth, at) = cell.depth(p);
            if depth > WELL_WITHIN {
                return Some((hint, at));
            }
        }
        let beyond = |k: usize| !(-1e-9..=self.size[k] + 1e-9).contains(&(p[k] - self.corner[k]));
        if beyond(0) || beyond(1) {
            return None;
        }
        let [x, y] = self.field(p);
        let field = y * self.fields[0] + x;
        let held = match (self.begins.get(field), self.begins.get(field + 1)) {
            (Some(&begin), Some(&end)) => self.held.get(begin as usize..end as usize).unwrap_or_default(),
            _ => &[],
        };
        let mut best = (f64::NEG_INFINITY, 0, [0.0; 2]);
        for &number in held {
            let (depth, at) = self.cells[number as usize].depth(p);
            if depth > best.0 {
                best = (depth, number, at);
            }
        }
        Cell::holds(best.0).then_some((best.1, best.2))
    }

    /// Shares a point, and says where it is when it was held within the hull.
    #[inline(always)]
    pub(super) fn share(&self, p: Flat, row: &mut Row) -> Flat {
        let Some((number, at)) = self.find(p, row.hint) else { return self.rim.share(p, row) };
        row.hint = number;
        let cell = &self.cells[number as usize];
        match cell.kind {
            Kind::Margin(side) => {
                self.rim.on(side, p, row);
            }
            _ => cell.share(p, at, row),
        }
        p
    }

    /// Adds the shares of the way from one place to another at which an edge is crossed, or a tactor of the hull is passed outside.
    pub(super) fn crossings(&self, places: &[[f64; 3]], from: Flat, to: Flat, out: &mut Vec<f64>) {
        let way = less(to, from);
        let mut meet = |origin: Flat, line: Flat, most: f64| {
            let (turn, d) = (cross(way, line), less(origin, from));
            if turn.abs() > 1e-12 * size(way) * size(line) {
                let (share, along) = (cross(d, line) / turn, cross(d, way) / turn);
                if (-1e-12..=1.0 + 1e-12).contains(&share) && along >= -1e-9 && along <= most {
                    out.push(share.clamp(0.0, 1.0));
                }
            }
        };
        let flat = |site: u32| [places[site as usize][0], places[site as usize][1]];
        for &[a, b] in &self.edges {
            meet(flat(a), less(flat(b), flat(a)), 1.0 + 1e-9);
        }
        for side in &self.rim.sides {
            side.sites.iter().for_each(|site| meet(flat(*site), side.outward(), f64::INFINITY));
        }
    }

    #[cfg(test)]
    pub(super) fn count(&self) -> [usize; 4] {
        self.cells.iter().fold([0; 4], |mut all, cell| {
            all[match cell.kind {
                Kind::Triangle => 0,
                Kind::Rectangle => 1,
                Kind::Polygon(_) => 2,
                Kind::Margin(_) => 3,
            }] += 1;
            all
        })
    }
}
