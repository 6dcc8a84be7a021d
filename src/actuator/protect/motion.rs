//! A model beside the signal: where the actuator will be, and which drive keeps it within its stroke.

use super::way::{Way, dot, solve};
use crate::actuator::coil::sampled::Sampled;
use crate::actuator::fault::{Fault, Limit};

/// The largest state.
const MOST: usize = 5;
type Table = [[f64; MOST]; MOST];
/// Shares of the pace allowed at which the voltage may be let go: at once, slowly, not at all.
const PACES: [f64; WAYS] = [1.0, 0.5, 0.2, 0.0];
const WAYS: usize = 4;

/// A model of any size.
#[derive(Debug, Clone)]
pub(super) enum Motion {
    Two(Box<Sized<2>>),
    Three(Box<Sized<3>>),
    Four(Box<Sized<4>>),
    Five(Box<Sized<5>>),
}

macro_rules! each {
    ($sized:expr, $it:ident => $what:expr) => {
        match $sized {
            Motion::Two($it) => $what,
            Motion::Three($it) => $what,
            Motion::Four($it) => $what,
            Motion::Five($it) => $what,
        }
    };
}

/// A model of `N` states, in coordinates whose length bounds the displacement where there is a stroke.
#[derive(Debug, Clone)]
pub(super) struct Sized<const N: usize> {
    /// z after a sample is z + `change` z + `drive` V.
    change: [[f64; N]; N],
    drive: [f64; N],
    state: [f64; N],
    current: [f64; N],
    conductance: f64,
    amperes: f64,
    /// Metres; infinite where only the current is asked for.
    stroke: f64,
    /// Displacement for each unit of state.
    shows: [f64; N],
    /// Ways to let the voltage go, the first `ways` of them.
    way: [Way<N>; WAYS],
    ways: usize,
}

impl Motion {
    /// At rest. `keep` is the least share of the voltage that may be left at each sample when it is let go: 0 without a slew.
    ///
    /// # Errors
    /// A stroke where no spring brings back what moves.
    pub fn new(sampled: &Sampled, stroke: Option<f64>, keep: f64) -> Result<Self, Fault> {
        Ok(match sampled.size {
            2 => Self::Two(Box::new(Sized::new(sampled, stroke, keep)?)),
            3 => Self::Three(Box::new(Sized::new(sampled, stroke, keep)?)),
            4 => Self::Four(Box::new(Sized::new(sampled, stroke, keep)?)),
            _ => Self::Five(Box::new(Sized::new(sampled, stroke, keep)?)),
        })
    }

    /// Moves by a sample: by the drive nearest to `wanted`, towards a share of `last`, that keeps to the stroke. `round` makes of it what
    /// will leave. Returns that.
    #[inline(always)]
    pub fn step(&mut self, last: f64, wanted: f64, round: impl Fn(f64) -> (f32, f64)) -> (f32, f64, f64) {
        each!(self, it => it.step(last, wanted, round))
    }

    /// Amperes at the end of the last sample.
    #[inline(always)]
    pub fn amperes(&self) -> f64 {
        each!(self, it => it.amperes)
    }

    /// Metres from rest, where there is a stroke.
    #[inline(always)]
    pub fn displacement(&self) -> f64 {
        each!(self, it => dot(&it.shows, &it.state))
    }

    /// At rest again.
    pub fn reset(&mut self) {
        each!(self, it => it.state.fill(0.0));
    }

    /// Whether nothing moves or flows.
    pub fn is_still(&self) -> bool {
        each!(self, it => it.state.iter().all(|x| *x == 0.0))
    }

    /// Puts states that are nothing to 0, so that arithmetic does not slow down.
    pub fn settle(&mut self) {
        each!(self, it => it.state.iter_mut().for_each(|x| *x = if x.abs() < 1e-30 { 0.0 } else { *x }));
    }
}

impl<const N: usize> Sized<N> {
    fn new(sampled: &Sampled, stroke: Option<f64>, keep: f64) -> Result<Self, Fault> {
        let mut it = Self {
            change: std::array::from_fn(|i| std::array::from_fn(|j| sampled.change[i][j])),
            drive: std::array::from_fn(|i| sampled.drive[i]),
            state: [0.0; N],
            current: std::array::from_fn(|i| sampled.current[i]),
            conductance: sampled.conductance,
            amperes: 0.0,
            stroke: stroke.unwrap_or(f64::INFINITY),
            shows: std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 }),
            way: [Way { keep: 0.0, rest: [0.0; N], cost: 0.0 }; WAYS],
            ways: 1,
        };
        let Some(stroke) = stroke else { return Ok(it) };
        let fault = Fault::because(
            "stroke",
            stroke,
            Limit::Absent,
            "no springs bring back all that moves, so none can be kept",
        );
        it.in_energy(&sampled.energy).ok_or(fault)?;
        it.let_go(keep);
        Ok(it)
    }

    /// Changes to coordinates z = Lᵀ x / c with P = L Lᵀ: their length is the root of the energy, so scaled that the displacement
    /// never is larger. `None` where a displacement takes no energy.
    fn in_energy(&mut self, energy: &Table) -> Option<()> {
        // Units in which the diagonal is 1: masses and springs are far apart in size.
        let unit: [f64; N] = std::array::from_fn(|i| 1.0 / energy[i][i].sqrt());
        let p = |i: usize, j: usize| energy[i][j] * unit[i] * unit[j];
        // Cholesky; and the inverse of Lᵀ, column by column.
        let mut l = [[0.0; N]; N];
        for j in 0..N {
            let square = p(j, j) - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
            if square.is_nan() || square <= 1e-12 {
                return None;
            }
            l[j][j] = square.sqrt();
            for i in j + 1..N {
                l[i][j] = (p(i, j) - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>()) / l[j][j];
            }
        }
        // x = back z, z = there x, but for c.
        let there: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| l[j][i] / unit[j]));
        let mut back = [[0.0; N]; N];
        for column in 0..N {
            for i in (0..N).rev() {
                let one = if i == column { 1.0 } else { 0.0 };
                let sum: f64 = (i + 1..N).map(|k| l[k][i] * back[k][column] / unit[k]).sum();
                back[i][column] = (one - sum) / l[i][i] * unit[i];
            }
        }
        // |y| is at most the length of the first row of `back` times that of z: c makes it 1.
        let c = dot(&back[0], &back[0]).sqrt();
        let change = self.change;
        let times = |row: &dyn Fn(usize) -> f64, column: &dyn Fn(usize) -> f64| -> f64 {
            (0..N).map(|k| row(k) * column(k)).sum()
        };
        let half: [[f64; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| times(&|k| change[i][k], &|k| back[k][j])));
        self.change =
            std::array::from_fn(|i| std::array::from_fn(|j| times(&|k| there[i][k], &|k| half[k][j])));
        let drive = self.drive;
        self.drive = std::array::from_fn(|i| dot(&there[i], &drive) * c);
        self.shows = std::array::from_fn(|j| back[0][j] / c);
        let current = self.current;
        self.current = std::array::from_fn(|j| times(&|k| current[k], &|k| back[k][j]) / c);
        (self.change.iter().flatten().chain(&self.drive).all(|x| x.is_finite())).then_some(())
    }

    /// Works out the ways to let the voltage go, no faster than `least` allows.
    fn let_go(&mut self, least: f64) {
        self.way[0].rest = self.drive;
        if least <= 0.0 {
            return;
        }
        self.ways = 0;
        for pace in PACES {
            let keep = 1.0 - pace * (1.0 - least);
            // G = ρ (ρ − A)⁻¹ B, with A = 1 + change. There is none where ρ is an eigenvalue; at 1 there always is.
            let matrix = std::array::from_fn(|i| {
                std::array::from_fn(|j| if i == j { keep - 1.0 } else { 0.0 } - self.change[i][j])
            });
            let Some(g) = solve(matrix, self.drive.map(|b| keep * b)) else { continue };
            let rest = std::array::from_fn(|i| self.drive[i] - g[i]);
            self.way[self.ways] = Way { keep, rest, cost: dot(&self.shows, &g).abs() };
            self.ways += 1;
        }
    }

    #[inline(always)]
    fn step(&mut self, last: f64, wanted: f64, round: impl Fn(f64) -> (f32, f64)) -> (f32, f64, f64) {
        let free: [f64; N] = std::array::from_fn(|i| self.state[i] + dot(&self.change[i], &self.state));
        let volts = if self.stroke < f64::INFINITY { self.nearest(&free, last, wanted) } else { wanted };
        let (sample, left) = round(volts);
        self.state = std::array::from_fn(|i| free[i] + self.drive[i] * left);
        self.amperes = dot(&self.current, &self.state) + self.conductance * left;
        (sample, left, volts)
    }

    /// The drive nearest to the one wanted, on the way to it from a safe one, that keeps to the stroke.
    #[inline(always)]
    fn nearest(&self, free: &[f64; N], last: f64, wanted: f64) -> f64 {
        let ways = &self.way[..self.ways];
        if ways.iter().any(|way| way.admits(self.stroke, free, wanted)) {
            wanted
        } else {
            self.admitted(free, last, wanted)
        }
    }

    /// The same where the one wanted is not admitted.
    #[inline(never)]
    fn admitted(&self, free: &[f64; N], last: f64, wanted: f64) -> f64 {
        let (mut best, mut nearest) = (None, f64::INFINITY);
        let (mut least, mut size) = (self.way[0].keep * last, f64::INFINITY);
        for way in &self.way[..self.ways] {
            let safe = way.keep * last;
            let is = way.size(free, safe);
            if is < size {
                (least, size) = (safe, is);
            }
            // What was admitted in one way stays so, but for rounding.
            if is <= self.stroke * (1.0 + 1e-12) {
                let drive = way.farthest(self.stroke, free, safe, wanted);
                if (drive - wanted).abs() < nearest {
                    (best, nearest) = (Some(drive), (drive - wanted).abs());
                }
            }
        }
        best.unwrap_or(least)
    }
}

#[cfg(test)]
mod tests;
