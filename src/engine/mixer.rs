//! From lanes to channels: for a group of lanes, the gains with which they reach the channels they sound on.

use super::workspace::Bus;
use crate::dsp::lanes::{LANES, Real};

/// Where a group of lanes goes: a matrix for each group of eight channels that at least one lane reaches.
#[derive(Debug)]
pub struct Routes<R> {
    list: Vec<Route<R>>,
    /// Groups of channels that there are.
    most: usize,
}

#[derive(Debug)]
struct Route<R> {
    /// The group of channels.
    channels: u32,
    /// The lanes that reach it.
    lanes: u8,
    /// Where each lane reaches only the channel of its own number, so that a row times a row does: the gains of those.
    diagonal: Option<[R; LANES]>,
    /// By lane, then channel.
    gains: [[R; LANES]; LANES],
}

impl<R: Real> Routes<R> {
    /// No routes, but room for `most` groups of channels.
    pub fn new(most: usize) -> Self {
        Self { list: Vec::with_capacity(most), most }
    }

    /// Routes `lane` to a channel with a gain, on top of where it goes already. A channel beyond the groups that there are is
    /// left out.
    pub fn connect(&mut self, lane: usize, channel: u32, gain: f64) {
        let (group, c) = (channel / LANES as u32, channel as usize % LANES);
        if group as usize >= self.most {
            return;
        }
        let route = match self.list.iter().position(|r| r.channels == group) {
            Some(i) => &mut self.list[i],
            None if self.list.len() < self.list.capacity() => {
                let at = self.list.partition_point(|r| r.channels < group);
                let gains = [[R::ZERO; LANES]; LANES];
                self.list.insert(at, Route { channels: group, lanes: 0, diagonal: None, gains });
                &mut self.list[at]
            }
            None => return,
        };
        route.lanes |= 1 << lane;
        route.gains[lane][c] += R::of(gain);
        route.diagonal = route.diagonal();
    }

    /// Takes `lane` off all channels.
    pub fn disconnect(&mut self, lane: usize) {
        for route in &mut self.list {
            route.lanes &= !(1 << lane);
            route.gains[lane] = [R::ZERO; LANES];
            route.diagonal = route.diagonal();
        }
        self.list.retain(|r| r.lanes != 0);
    }

    /// Adds the lanes' rows to the channels. The order of the sum is that of the lanes.
    #[inline(always)]
    pub fn mix(&self, rows: &[[R; LANES]], bus: &mut Bus<'_, R>, offset: usize) {
        for route in &self.list {
            let group = route.channels as usize;
            if let Some(gain) = route.diagonal {
                // An unknown stride keeps the compiler to one row at a time: it would take eight and shuffle them. And rows
                // are copied before they are written, for it does not know that they lie apart.
                let step = std::hint::black_box(1);
                if let Some(sums) = bus.fresh(group, rows.len()) {
                    for (frame, sum) in sums.iter_mut().enumerate() {
                        let mut row = rows[frame * step];
                        for l in 0..LANES {
                            // As if added to silence: never -0.
                            row[l] = R::ZERO + row[l] * gain[l];
                        }
                        *sum = row;
                    }
                } else {
                    for (frame, sum) in bus.channels(group, offset, rows.len()).iter_mut().enumerate() {
                        let (row, mut new) = (rows[frame * step], *sum);
                        for l in 0..LANES {
                            new[l] += row[l] * gain[l];
                        }
                        *sum = new;
                    }
                }
            } else {
                let step = std::hint::black_box(1);
                let sums = bus.channels(group, offset, rows.len());
                for lane in (0..LANES).filter(|lane| route.lanes & (1 << lane) != 0) {
                    let gain = route.gains[lane];
                    for (frame, sum) in sums.iter_mut().enumerate() {
                        let (value, mut new) = (rows[frame * step][lane], *sum);
                        for c in 0..LANES {
                            new[c] += value * gain[c];
                        }
                        *sum = new;
                    }
                }
            }
        }
    }
}

impl<R: Real> Route<R> {
    fn diagonal(&self) -> Option<[R; LANES]> {
        let mut gain = [R::ZERO; LANES];
        for (lane, row) in self.gains.iter().enumerate() {
            for (channel, &to) in row.iter().enumerate() {
                if lane == channel {
                    gain[lane] = to;
                } else if to != R::ZERO {
                    return None;
                }
            }
        }
        Some(gain)
    }
}

#[cfg(test)]
mod tests {
    use super::Routes;
    use crate::dsp::lanes::LANES;
    use crate::engine::workspace::Workspace;

    #[test]
    fn lanes_arrive_where_they_are_sent() {
        let mut routes = Routes::<f64>::new(4);
        routes.connect(0, 3, 0.5);
        routes.connect(1, 17, 2.0);
        routes.connect(1, 3, 1.0);
        routes.connect(2, 2, 7.0);
        // There is no such channel.
        routes.connect(0, 32, 1.0);
        routes.disconnect(2);
        let mut work = Workspace::new(0, 0, 24);
        work.clear_mix(10);
        let rows = [[1.0, 10.0, 100.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 3];
        routes.mix(&rows, &mut work.bus(), 5);
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
            routes.mix(&rows, &mut work.bus(), 0);
            work.mix
        };
        for (a, b) in mix(false).iter().zip(&mix(true)) {
            assert_eq!(a[1..], b[1..]);
        }
    }
}
