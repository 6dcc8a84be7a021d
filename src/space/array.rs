//! Tactors at their positions, and how much of a point each of them has.

mod cell;
mod cloud;
mod frame;
mod line;
mod mesh;
mod rim;
mod sites;
mod spread;
mod surface;
#[cfg(test)]
mod tests;
pub(super) mod tile;
mod tiles;

use super::fault::Fault;
use super::law::Law;
use super::point::{Point, distance, minus};
use super::row::{Row, Share};
use cloud::Cloud;
use frame::Frame;
use line::Line;
use sites::Sites;
use surface::Surface;
use tile::Tile;

/// Tactors of an array, at most.
pub const MOST_TACTORS: usize = 4096;
/// No coordinate of a position may be farther from 0, in metres.
pub const FARTHEST: f64 = 1e6;
/// An array no wider across than this share of its size is a line.
const NARROW: f64 = 0.02;
/// An array no deeper than this share of its size is a surface.
const SHALLOW: f64 = 0.2;

/// What an array is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// All tactors at one place.
    One,
    /// Along a line: two neighbours share a point.
    Line,
    /// Over a plane, or a gently curved sheet: the corners of a cell share a point.
    Surface,
    /// Anywhere: the nearest few share a point.
    Cloud,
}

/// Tactors at their positions.
///
/// Tactors within a nanometre of each other, or 1e-9 of an array of more than a metre, are at one place: they share its weight equally,
/// so that by the energy law the power stays; by [`Law::Nearest`] the first of them has it all. The size of an array is twice the distance of the farthest place from the mean of all. Of the places,
///
/// * those within a line no thicker than 2 % of the array's size are a **line**, if neighbours are no farther apart beside it than half
///   of what they are along it. A point goes to the nearest point of the line between its ends. The two neighbours have 1 − β and β of
///   it.
/// * those within a plate no thicker than 20 % of it are a **surface**, if no neighbours are farther apart beside it than half of what
///   they are within it: so a curved panel is one, two layers are none, and going to the plane shortens no distance of neighbours by
///   more than 11 %. A point goes straight to the plane, and from outside to the nearest point of the convex hull. Delaunay's triangles
///   share by barycentric coordinates; where four corners are a rectangle, within 1e-9, by bilinear ones; where up to 64 lie on a
///   circle, or four nearly do, by Wachspress's, of which these two are cases: which way a polygon is cut into triangles would be an
///   accident. Tactors a little inward of a straight row at the rim, up to 2 % of the piece, count as on it.
/// * all others are a **cloud**: w ∝ ((R − r)₊ / (R r))², with R 1.5 times the distance to the fourth nearest. From outside a point is
///   drawn to the ellipsoid of the array's spread that holds all tactors.
///
/// Weights are continuous in the point, 1 on a tactor within 1e-14, and 1 in sum within 1e-12. Within a line's ends and a surface's hull the point is the
/// mean of the tactors by their weights (at the rim, up to those 2 %).
///
/// A **width** s above 0 is the standard deviation of a Gaussian, w ∝ exp(−(r² − r_min²) / 2 s²), about where the point went. From half of
/// the spacing on, these are the weights. Below, they go over into those above, by 2 s / spacing: width 0 is the law between neighbours.
#[derive(Debug, Clone)]
pub struct Array {
    positions: Vec<Point>,
    sites: Sites,
    tactors: usize,
    frame: Frame,
    form: Form,
    spacing: f64,
    /// Places of the sites in the frame, and by coordinate without what the shape leaves aside.
    places: Vec<Point>,
    columns: [Vec<f64>; 3],
    /// Its pieces that are tiles, by number.
    tiles: Box<[Option<Tile>]>,
}

#[derive(Debug, Clone)]
enum Form {
    One,
    Line(Line),
    Surface(Box<Surface>),
    Cloud(Cloud),
}

impl Array {
    /// From positions in metres, in the order by which tactors are counted.
    ///
    /// # Errors
    /// No tactor, more than [`MOST_TACTORS`], or a position that is not finite or beyond [`FARTHEST`].
    pub fn new(positions: &[Point]) -> Result<Self, Fault> {
        if positions.is_empty() {
            return Err(Fault::NoTactor);
        }
        if positions.len() > MOST_TACTORS {
            return Err(Fault::TooMany(positions.len()));
        }
        let bad = positions.iter().position(|p| !p.iter().all(|x| x.abs() <= FARTHEST));
        if let Some(index) = bad {
            return Err(Fault::Position(index, positions[index]));
        }
        let sites = Sites::of(positions);
        let frame = Frame::of(&sites.places);
        let places: Vec<Point> = sites.places.iter().map(|p| frame.local(*p)).collect();
        let form = form(&frame, &places);
        let kept = match form {
            Form::One => 0,
            Form::Line(_) => 1,
            Form::Surface(_) => 2,
            Form::Cloud(_) => 3,
        };
        let columns = [0, 1, 2].map(|k| places.iter().map(|p| if k < kept { p[k] } else { 0.0 }).collect());
        let spacing = sites.spacing();
        let mut array = Self {
            positions: positions.to_vec(),
            sites,
            tactors: positions.len(),
            frame,
            form,
            spacing,
            places,
            columns,
            tiles: Box::default(),
        };
        array.tiles = (0..array.pieces() as u32).map(|piece| array.as_tile(piece)).collect();
        Ok(array)
    }

    /// How many tactors it has; at least one.
    pub fn tactors(&self) -> usize {
        self.tactors
    }

    /// What it is like.
    pub fn shape(&self) -> Shape {
        match self.form {
            Form::One => Shape::One,
            Form::Line(_) => Shape::Line,
            Form::Surface(_) => Shape::Surface,
            Form::Cloud(_) => Shape::Cloud,
        }
    }

    /// The median distance from a place with tactors to the nearest other one, in metres; 0 where there is but one.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Whether it is of tactors at the same positions.
    pub fn same(&self, other: &Self) -> bool {
        self.positions == other.positions
    }

    /// Room for the weights of a point.
    pub fn row(&self) -> Row {
        Row::new(self.tactors, self.places.len())
    }

    /// Fills a row of this array with the weights of a point, of a width in metres. For the audio thread.
    ///
    /// A coordinate that is not a number counts as 0, an infinite one as ±1e30; a width that is not a number or below 0 as 0. Of the law only
    /// this counts: by [`Law::Nearest`] the point goes to the nearest tactor first, of several as near to the one that was given first.
    pub fn weights(&self, point: Point, width: f64, law: Law, row: &mut Row) {
        row.clear();
        let at = if law == Law::Nearest {
            let site = self.nearest(self.frame.local(point));
            row.push(site, 1.0);
            self.column(site)
        } else {
            self.share(self.frame.off_centre(point), row)
        };
        if width > 0.0 && self.places.len() > 1 {
            self.widen(at, width, row);
        }
        // Where no two are at one place, sites are tactors.
        if self.places.len() < self.tactors {
            row.each(|share, row| self.give(share, law, row));
        }
    }

    /// The piece in which a row found its last point, if it is a tile of tactors.
    #[inline(always)]
    pub(super) fn tile(&self, piece: u32) -> Option<&Tile> {
        self.tiles.get(piece as usize)?.as_ref()
    }

    /// Pieces that may be tiles: where several tactors are at one place, none.
    fn pieces(&self) -> usize {
        match &self.form {
            Form::Line(line) if self.places.len() == self.tactors => line.at.len() - 1,
            Form::Surface(surface) if self.places.len() == self.tactors => surface.cells(),
            _ => 0,
        }
    }

    fn as_tile(&self, piece: u32) -> Option<Tile> {
        let rates = &self.frame.rates;
        match &self.form {
            Form::One | Form::Cloud(_) => None,
            Form::Line(line) => {
                let (rate, [a, b]) = line.tile(piece)?;
                let u = rates[0].map(|x| x * rate);
                let origin = *self.positions.get(a as usize)?;
                Some(Tile { form: tile::Form::Segment, origin, u, v: [0.0; 3], corners: [a, b, 0, 0] })
            }
            Form::Surface(surface) => {
                let (form, [u, v], corners) = surface.tile(piece)?;
                let of = |g: [f64; 2]| [0, 1, 2].map(|k| g[0] * rates[0][k] + g[1] * rates[1][k]);
                let origin = *self.positions.get(corners[0] as usize)?;
                Some(Tile { form, origin, u: of(u), v: of(v), corners })
            }
        }
    }

    /// Whether weights of a width have no corners to speak of.
    pub(super) fn is_smooth(&self, width: f64) -> bool {
        width > 0.0 && 2.0 * width >= self.spacing
    }

    /// How far outside the array a point lies, in metres: from where it counts as being. For points off a line or a plane, along it.
    pub fn outside(&self, point: Point) -> f64 {
        let kept = self.kept(self.frame.local(point));
        distance(self.share(self.frame.off_centre(point), &mut self.row()), kept) * self.frame.unit
    }

    /// Adds the shares of the straight way between two points at which it crosses an edge of the array, in no order. None in a cloud.
    pub(super) fn crossings(&self, from: Point, to: Point, out: &mut Vec<f64>) {
        let (from, to) = (self.frame.local(from), self.frame.local(to));
        match &self.form {
            Form::One | Form::Cloud(_) => {}
            Form::Line(line) => {
                let way = to[0] - from[0];
                out.extend(
                    line.at.iter().map(|t| (t - from[0]) / way).filter(|share| (0.0..=1.0).contains(share)),
                );
            }
            Form::Surface(surface) => {
                surface.crossings(&self.places, [from[0], from[1]], [to[0], to[1]], out);
            }
        }
    }

    /// Shares what lies so far from the middle between sites, and says where it is when it was held within the array.
    #[inline(always)]
    fn share(&self, d: Point, row: &mut Row) -> Point {
        let along = |axis: usize| self.frame.along(axis, d);
        match &self.form {
            Form::One => {
                row.push(0, 1.0);
                [0.0; 3]
            }
            Form::Line(line) => [line.share(along(0), row), 0.0, 0.0],
            Form::Surface(surface) => {
                let [x, y] = surface.share([along(0), along(1)], row);
                [x, y, 0.0]
            }
            Form::Cloud(cloud) => {
                let at = cloud.held([0, 1, 2].map(along));
                cloud.share(self.column_slices(), at, row);
                at
            }
        }
    }

    /// Without the coordinates that the shape leaves aside.
    fn kept(&self, [x, y, z]: Point) -> Point {
        match self.form {
            Form::One => [0.0; 3],
            Form::Line(_) => [x, 0.0, 0.0],
            Form::Surface(_) => [x, y, 0.0],
            Form::Cloud(_) => [x, y, z],
        }
    }

    /// The site nearest to a local point; of several the first.
    fn nearest(&self, p: Point) -> u32 {
        let mut best = (0, f64::INFINITY);
        // Far away, the square of the point's own distance would drown the rest of it.
        let far = p.iter().any(|x| x.abs() > 1e3);
        for (site, place) in self.places.iter().enumerate() {
            let [a, b] =
                if far { [*place, minus(*place, p.map(|x| 2.0 * x))] } else { [minus(*place, p); 2] };
            let square = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            if square < best.1 {
                best = (site as u32, square);
            }
        }
        best.0
    }

    fn column(&self, site: u32) -> Point {
        [0, 1, 2].map(|k| self.columns[k].get(site as usize).copied().unwrap_or_default())
    }

    fn column_slices(&self) -> [&[f64]; 3] {
        [&self.columns[0], &self.columns[1], &self.columns[2]]
    }

    /// Over into a Gaussian about where the point went.
    fn widen(&self, at: Point, width: f64, row: &mut Row) {
        spread::gaussian(self.column_slices(), at, width / self.frame.unit, &mut row.dense);
        let over = (2.0 * width / self.spacing).min(1.0);
        if over < 1.0 {
            row.dense.iter_mut().for_each(|weight| *weight *= over);
            row.mix(1.0 - over);
        }
        row.clear();
        for site in 0..row.dense.len() {
            row.push(site as u32, row.dense[site]);
        }
    }

    /// The tactors at a site share its weight equally; to the nearest one goes all of it, and to the first of several.
    fn give(&self, site: Share, law: Law, row: &mut Row) {
        let mut tactors = self.sites.at(site.tactor);
        if law == Law::Nearest {
            tactors = &tactors[..tactors.len().min(1)];
        }
        let each = site.weight / tactors.len().max(1) as f64;
        tactors.iter().for_each(|tactor| row.push(*tactor, each));
    }
}

/// The simplest form that fits.
fn form(frame: &Frame, places: &[Point]) -> Form {
    if places.len() == 1 {
        return Form::One;
    }
    if frame.across <= NARROW
        && let Some(line) = Line::of(places)
    {
        return Form::Line(line);
    }
    if frame.deep <= SHALLOW
        && let Some(surface) = Surface::of(places)
    {
        return Form::Surface(Box::new(surface));
    }
    Form::Cloud(Cloud::of(places))
}
