//! Triangles joined to polygons, where the way they were cut is an accident.

use super::super::point::{Flat, cross, inner, less, size};
use super::cell::{Cell, Kind, MOST_CORNERS};
use super::mesh::{Mesh, outline};
use std::collections::{BTreeMap, BTreeSet};

/// Four corners lie on a circle where the sine of the sum of two opposite angles is no more than this.
const ON_A_CIRCLE: f64 = 1e-9;
/// Up to this sine, 5.7 degrees, two triangles were meant to be one: it is what placing by hand makes of a rectangle.
const NEARLY: f64 = 0.1;
/// The sine of the turn at each corner of four that were meant to be one.
const BLUNTEST: f64 = 0.5;

/// Cells of a mesh without what was taken off, and the edges between and around them.
///
/// Triangles whose corners all lie on one circle are joined: Delaunay's rule says nothing of how they are cut, and in a mirror they might
/// be cut the other way. So are two whose four corners nearly do, the nearest first: in a grid measured with a tape, the middle of a cell
/// sounds its four tactors, not two of them.
pub(super) fn tiles(flat: &[Flat], mesh: &Mesh, taken: &[Option<u32>]) -> (Vec<Cell>, Vec<[u32; 2]>) {
    let (mut cells, mut edges) = (Vec::new(), BTreeSet::new());
    let mut single = Vec::new();
    for triangles in on_circles(flat, mesh, taken) {
        match polygon(flat, mesh, &triangles).filter(|_| triangles.len() > 1) {
            Some(cell) => keep(cell, &mut cells, &mut edges),
            None => single.extend(triangles),
        }
    }
    let mut free: BTreeSet<u32> = single.iter().copied().collect();
    for (_, here, there) in meant_to_be_one(flat, mesh, &free) {
        if free.contains(&here)
            && free.contains(&there)
            && let Some(cell) = polygon(flat, mesh, &[here, there]).filter(|cell| cell.bluntest() >= BLUNTEST)
        {
            free.remove(&here);
            free.remove(&there);
            keep(cell, &mut cells, &mut edges);
        }
    }
    for number in free {
        let corners = mesh.triangles[number as usize];
        edges.extend([(0, 1), (1, 2), (2, 0)].map(|(a, b)| ordered(corners[a], corners[b])));
        cells.extend(Cell::triangle(flat, corners, Kind::Triangle));
    }
    (cells, edges.into_iter().collect())
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn keep(cell: Cell, cells: &mut Vec<Cell>, edges: &mut BTreeSet<[u32; 2]>) {
    let corners = cell.corners();
    let behind = corners.iter().cycle().skip(1);
    edges.extend(corners.iter().zip(behind).map(|(a, b)| ordered(*a, *b)));
    cells.push(cell);
}

/// The cell of triangles that lie side by side; `None` where they are no convex polygon of so many corners.
fn polygon(flat: &[Flat], mesh: &Mesh, triangles: &[u32]) -> Option<Cell> {
    let sides = triangles.iter().flat_map(|&n| {
        let [a, b, c] = mesh.triangles[n as usize];
        [((a, b), n), ((b, c), n), ((c, a), n)]
    });
    let corners = outline(&sides.collect())?;
    let simple = corners.len() == triangles.len() + 2 && corners.len() <= MOST_CORNERS;
    if simple { Cell::polygon(flat, &corners) } else { None }
}

/// The sine of the sum of the angles that two triangles have opposite their common edge: 0 where their corners lie on a circle.
fn off_a_circle(flat: &[Flat], mesh: &Mesh, (a, b): (u32, u32), here: u32, there: u32) -> f64 {
    let angle = |apex: u32| {
        let [a, b, apex] = [a, b, apex].map(|n| flat[n as usize]);
        let (e, f) = (less(a, apex), less(b, apex));
        let scale = size(e) * size(f);
        (cross(e, f).abs() / scale, inner(e, f) / scale)
    };
    let (one, other) = (angle(mesh.apex(here, (a, b))), angle(mesh.apex(there, (a, b))));
    (one.0 * other.1 + one.1 * other.0).abs()
}

/// Triangles in groups on one circle each; those that were taken off are in none.
fn on_circles(flat: &[Flat], mesh: &Mesh, taken: &[Option<u32>]) -> Vec<Vec<u32>> {
    let mut group: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    fn top(group: &mut [u32], mut n: u32) -> u32 {
        while group[n as usize] != n {
            group[n as usize] = group[group[n as usize] as usize];
            n = group[n as usize];
        }
        n
    }
    let free = |n: &u32| taken[*n as usize].is_none();
    for (&(a, b), here) in &mesh.left {
        let there = mesh.left.get(&(b, a)).filter(|there| a < b && free(here) && free(there));
        if let Some(there) = there
            && off_a_circle(flat, mesh, (a, b), *here, *there) <= ON_A_CIRCLE
        {
            let (one, other) = (top(&mut group, *here), top(&mut group, *there));
            group[one.max(other) as usize] = one.min(other);
        }
    }
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for n in (0..mesh.triangles.len() as u32).filter(free) {
        members.entry(top(&mut group, n)).or_default().push(n);
    }
    members.into_values().collect()
}

/// Pairs of neighbours that nearly lie on one circle, the nearest to it first.
fn meant_to_be_one(flat: &[Flat], mesh: &Mesh, free: &BTreeSet<u32>) -> Vec<(f64, u32, u32)> {
    let mut pairs = Vec::new();
    for (&(a, b), here) in &mesh.left {
        let there =
            mesh.left.get(&(b, a)).filter(|there| a < b && free.contains(here) && free.contains(there));
        if let Some(there) = there {
            let off = off_a_circle(flat, mesh, (a, b), *here, *there);
            if off <= NEARLY {
                pairs.push((off, *here, *there));
            }
        }
    }
    pairs.sort_by(|one, other| one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2))));
    pairs
}

#[cfg(test)]
mod tests {
    use super::super::cell::{Cell, Kind};
    use super::super::mesh::Mesh;
    use super::tiles;
    use crate::space::point::Flat;

    /// How many triangles there are, and the corners of what has more than three.
    fn made(flat: &[Flat]) -> (usize, Vec<Vec<u32>>) {
        let mesh = Mesh::of(flat).unwrap();
        let (cells, edges) = tiles(flat, &mesh, &vec![None; mesh.triangles.len()]);
        // Euler: corners and cells are one more than edges.
        assert_eq!(flat.len() + cells.len(), edges.len() + 1);
        let (three, more): (Vec<&Cell>, Vec<&Cell>) =
            cells.iter().partition(|cell| matches!(cell.kind, Kind::Triangle));
        let sorted = |cell: &&Cell| {
            let mut corners = cell.corners().to_vec();
            corners.sort();
            corners
        };
        (three.len(), more.iter().map(sorted).collect())
    }

    #[test]
    fn of_two_ways_to_join_the_better_is_taken() {
        // All but a square, and a corner that is not so well on a circle with three of it.
        let five = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.001], [0.0, 1.0], [1.22, 0.5]];
        for order in 0..120 {
            let mut left = vec![0, 1, 2, 3, 4];
            let (mut picked, mut rest) = (Vec::new(), order);
            for n in (1..=5).rev() {
                picked.push(left.remove(rest % n));
                rest /= n;
            }
            let flat: Vec<Flat> = picked.iter().map(|n| five[*n]).collect();
            let square: Vec<u32> = (0..5).filter(|n| picked[*n as usize] != 4).collect();
            assert_eq!(made(&flat), (1, vec![square]), "{picked:?}");
        }
    }

    #[test]
    fn corners_that_are_nearly_straight_are_joined_on_circles_alone() {
        let on_a_circle = |radius: f64| -> Vec<Flat> {
            let at = [0.0_f64, 10.0, 20.0, 180.0].map(|degrees| degrees.to_radians().sin_cos());
            at.iter()
                .enumerate()
                .map(|(n, (s, c))| [*c, *s].map(|x| x * if n == 1 { radius } else { 1.0 }))
                .collect()
        };
        assert_eq!(made(&on_a_circle(1.0)), (0, vec![vec![0, 1, 2, 3]]));
        assert_eq!(made(&on_a_circle(1.001)).0, 2);
    }

    #[test]
    fn a_polygon_is_convex_or_none() {
        let dented = [[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]];
        assert!(Cell::polygon(&dented, &[0, 1, 2, 3]).is_none());
        let straight = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
        assert!(Cell::polygon(&straight, &[0, 1, 2, 3]).is_none());
        assert!(Cell::polygon(&straight, &[0, 0, 2, 3]).is_none());
        assert!(Cell::polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.5], [0.0, 1.0]], &[0, 1, 2, 3]).is_some());
    }
}
