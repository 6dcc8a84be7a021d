//! From lanes to channels: for a group of lanes, the gains with which they reach the channels they sound on.

use super::workspace::Workspace;
use crate::dsp::lanes::{LANES, Real};

/// Where a group of lanes goes: a matrix for each group of eight channels that at least one lane reaches.
#[derive(Debug)]
pub struct Routes<R> {
    list: Vec<Route<R>>,
}

#[derive(Debug)]
struct Route<R> {
    /// The group of channels.
    channels: u32,
    /// The lanes that reach it.
    lanes: u8,
    /// Whether each lane reaches only the channel of its own number, so that a row times a row does.
    diagonal: bool,
    /// By lane, then channel.
    gains: [[R; LANES]; LANES],
}

impl<R: Real> Routes<R> {
    /// No routes, but room for `most` groups of channels.
    pub fn new(most: usize) -> Self {
        Self { list: Vec::with_capacity(most) }
    }

    /// Routes `lane` to a channel with a gain, on top of where it goes already. A channel for which there is no room is
    /// left out, which cannot happen as long as `most` covers the channels.
    pub fn connect(&mut self, lane: usize, channel: u32, gain: f64) {
        let (group, c) = (channel / LANES as u32, channel as usize % LANES);
        let route = match self.list.iter().position(|r| r.channels == group) {
            Some(i) => &mut self.list[i],
            None if self.list.len() < self.list.capacity() => {
                let at = self.list.partition_point(|r| r.channels < group);
                let gains = [[R::ZERO; LANES]; LANES];
                self.list.insert(at, Route { channels: group, lanes: 0, diagonal: true, gains });
                &mut self.list[at]
            }
            None => return,
        };
        route.lanes |= 1 << lane;
        route.gains[lane][c] += R::of(gain);
        route.diagonal = route.is_diagonal();
    }

    /// Takes `lane` off all channels.
    pub fn disconnect(&mut self, lane: usize) {
        for route in &mut self.list {
            route.lanes &= !(1 << lane);
            route.gains[lane] = [R::ZERO; LANES];
            route.diagonal = route.is_diagonal();
        }
        self.list.retain(|r| r.lanes != 0);
    }

    /// Adds the lanes' rows to the channels. The order of the sum is that of the lanes.
    #[inline(always)]
    pub fn mix(&self, rows: &[[R; LANES]], work: &mut Workspace<R>, offset: usize) {
        for route in &self.list {
            let group = route.channels as usize;
            let sums = work.channels(group, offset, rows.len());
            if route.diagonal {
                let mut gain = [R::ZERO; LANES];
                for l in 0..LANES {
                    gain[l] = route.gains[l][l];
                }
                for (sum, row) in sums.iter_mut().zip(rows) {
                    for l in 0..LANES {
                        sum[l] += row[l] * gain[l];
                    }
                }
            } else {
                for lane in (0..LANES).filter(|lane| route.lanes & (1 << lane) != 0) {
                    let gain = route.gains[lane];
                    for (sum, row) in sums.iter_mut().zip(rows) {
                        for c in 0..LANES {
                            sum[c] += row[lane] * gain[c];
                        }
                    }
                }
            }
        }
    }
}

impl<R: Real> Route<R> {
    fn is_diagonal(&self) -> bool {
        self.gains
            .iter()
            .enumerate()
            .all(|(l, row)| row.iter().enumerate().all(|(c, g)| l == c || *g == R::ZERO))
    }
}

#[cfg(test)]
mod tests {
    use super::{Routes, Workspace};
    use crate::dsp::lanes::LANES;

    #[test]
    fn lanes_arrive_where_they_are_sent() {
        let mut routes = Routes::<f64>::new(4);
        routes.connect(0, 3, 0.5);
        routes.connect(1, 17, 2.0);
        routes.connect(1, 3, 1.0);
        routes.connect(2, 2, 7.0);
        routes.disconnect(2);
        let mut work = Workspace::new(0, 0, 24);
        work.clear_mix(10);
        let rows = [[1.0, 10.0, 100.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 3];
        routes.mix(&rows, &mut work, 5);
        assert_eq!(work.fed, [true, false, true]);
        for frame in 5..8 {
            assert_eq!(work.mix[frame], [0.0, 0.0, 0.0, 10.5, 0.0, 0.0, 0.0, 0.0]);
            assert_eq!(work.mix[20 + frame][1], 20.0);
        }
        assert_eq!(work.mix[8], [0.0; LANES]);
        work.clear_mix(10);
        assert_eq!(work.fed, [false; 3]);
        assert_eq!(work.channels(0, 0, 10), [[0.0; LANES]; 10]);
    }

    #[test]
    fn the_diagonal_gives_the_bits_of_the_matrix() {
        let rows: Vec<[f32; LANES]> =
            (0..64).map(|f| std::array::from_fn(|l| ((f * 8 + l) as f32 * 0.77).sin())).collect();
        let mix = |extra: bool| {
            let mut routes = Routes::<f32>::new(4);
            for l in 0..LANES {
                routes.connect(l, l as u32, 0.3 + l as f64 * 0.1);
            }
            if extra {
                // A lane that also goes elsewhere in the group makes the matrix necessary; its other channel is not compared.
                routes.connect(7, 0, 1e-3);
            }
            let mut work = Workspace::new(0, 0, 8);
            routes.mix(&rows, &mut work, 0);
            work.mix
        };
        for (a, b) in mix(false).iter().zip(&mix(true)) {
            assert_eq!(a[1..], b[1..]);
        }
    }
}
