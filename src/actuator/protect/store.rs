//! What fills while a drive lasts, and empties by itself: heat in a winding, or a running mean of squares.

use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::Fault;
use crate::actuator::thermal::{Cooling, Thermal};

/// The limit is approached with the store's own time over this.
pub(super) const HASTE: f64 = 8.0;
/// Share of the limit by which a sudden drive may pass it.
pub(super) const EXCESS: f64 = 0.02;

/// A store with a limit. Mean squares are in A², or V² where a budget is one of volts.
#[derive(Debug, Clone)]
pub(super) enum Store {
    /// A winding in a housing.
    Heat { cooling: Cooling, thermal: Thermal },
    /// dq/dt = (m − q) / time, its limit, and the share that a tick passes of it.
    Mean { level: f64, most: f64, time: f64, share: f64 },
}

impl Store {
    /// Cold.
    ///
    /// # Errors
    /// A figure of the cooling that cannot be.
    pub fn heat(cooling: &Cooling) -> Result<Self, Fault> {
        Ok(Self::Heat { cooling: *cooling, thermal: Thermal::new(cooling)? })
    }

    /// Empty; the root of what it holds shall not pass `most`.
    pub fn mean(most: f64, time: f64, tick: f64) -> Self {
        Self::Mean { level: 0.0, most: most * most, time, share: -exp_m1(-tick / time) }
    }

    /// Seconds in which it follows.
    pub fn time(&self) -> f64 {
        match self {
            Self::Heat { cooling, .. } => cooling.winding_time,
            Self::Mean { time, .. } => *time,
        }
    }

    /// Passes a tick with this mean square.
    pub fn step(&mut self, mean_square: f64, tick: f64) {
        match self {
            Self::Heat { thermal, .. } => thermal.step(mean_square, tick),
            Self::Mean { level, share, .. } => *level += *share * (mean_square - *level),
        }
    }

    /// The mean square with which it approaches its limit smoothly.
    pub fn soft(&self) -> f64 {
        match self {
            Self::Heat { cooling: c, thermal } => {
                // C dT/dt = m R − (T − T_h) / R_wh = C 8 (most − T) / τ, τ = C R_wh.
                let (t, h) = (thermal.winding(), thermal.housing());
                let watts = (HASTE * (c.most - t) + (t - h)) / c.to_housing;
                (watts / thermal.resistance()).max(0.0)
            }
            Self::Mean { level, most, .. } => (level + HASTE * (most - level)).max(0.0),
        }
    }

    /// The mean square that, for a whole tick (s), brings it to no more than its limit and [`EXCESS`].
    pub fn hard(&self, tick: f64) -> f64 {
        match self {
            Self::Heat { cooling: c, thermal } => {
                let most = c.most * (1.0 + EXCESS);
                let (t, h) = (thermal.winding(), thermal.housing());
                // The housing gets no more than the hottest winding gives it: R_wh C_h = housing_time R_wh / R_ha.
                let time = c.housing_time * c.to_housing / c.to_air;
                let h = h + (tick / time).min(1.0) * (most - h).max(0.0);
                let watts = ((most - t) * c.winding_time / tick + (t - h)) / c.to_housing;
                (watts / (c.resistance * (1.0 + c.rise * most))).max(0.0)
            }
            Self::Mean { level, most, time, .. } => {
                let share = -exp_m1(-tick / time);
                (level + (most * (1.0 + EXCESS) - level) / share).max(0.0)
            }
        }
    }

    /// Ohms of the winding as warm as it is; `None` for what is no winding.
    pub fn resistance(&self) -> Option<f64> {
        match self {
            Self::Heat { thermal, .. } => Some(thermal.resistance()),
            Self::Mean { .. } => None,
        }
    }

    /// As full as another: as warm, or of as large a mean square. One of another kind changes nothing.
    pub fn fill_as(&mut self, other: &Self) {
        match (self, other) {
            (Self::Heat { thermal, .. }, Self::Heat { thermal: other, .. }) => thermal.warm_as(other),
            (Self::Mean { level, .. }, Self::Mean { level: other, .. }) => *level = *other,
            _ => {}
        }
    }

    /// Kelvins above the air, or the mean square.
    pub fn level(&self) -> f64 {
        match self {
            Self::Heat { thermal, .. } => thermal.winding(),
            Self::Mean { level, .. } => *level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EXCESS, HASTE, Store};
    use crate::actuator::thermal::{COPPER, Cooling, Thermal};

    fn cooling() -> Cooling {
        Cooling {
            resistance: 7.0,
            rise: COPPER,
            to_housing: 20.0,
            to_air: 60.0,
            winding_time: 2.0,
            housing_time: 100.0,
            most: 80.0,
        }
    }

    /// From many temperatures: the cap never passes the limit, at any instant, and is not much lower than it needs to be.
    #[test]
    fn the_cap_of_a_tick_fills_it_to_the_limit_and_no_further() {
        for tick in [1e-4, 1e-3, 1e-2] {
            for (before, after) in [(0.0, 0.0), (1.0, 0.01), (1.0, 20.0), (0.2, 1e4), (30.0, 0.2)] {
                let mut store = Store::heat(&cooling()).unwrap();
                store.step(before, after);
                if store.level() > 80.0 * (1.0 + EXCESS) {
                    continue;
                }
                let cap = store.hard(tick);
                let Store::Heat { thermal, .. } = &store else { unreachable!() };
                let (mut fine, mut whole): (Thermal, Thermal) = (*thermal, *thermal);
                for _ in 0..50 {
                    fine.step(cap, tick / 50.0);
                    assert!(fine.winding() <= 80.0 * (1.0 + EXCESS) + 1e-9, "{tick} {before}: {fine:?}");
                }
                whole.step(cap * 1.5, tick);
                assert!(whole.winding() > 80.0 * (1.0 + EXCESS), "{tick} {before}: {whole:?}");
            }
            let mut store = Store::mean(3.0, 0.5, tick);
            store.step(4.0, tick);
            let cap = store.hard(tick);
            store.step(cap, tick);
            assert!((store.level() / (9.0 * (1.0 + EXCESS)) - 1.0).abs() < 1e-12);
        }
    }

    /// Where resistance does not rise and the housing stays cold, nothing of the cap is caution: a tick of it fills the winding to the excess.
    #[test]
    fn the_cap_makes_use_of_the_excess() {
        let plain = Cooling { rise: 0.0, housing_time: 1e6, ..cooling() };
        for before in [0.0, 0.5] {
            let mut store = Store::heat(&plain).unwrap();
            store.step(before, 1.0);
            store.step(store.hard(1e-4), 1e-4);
            assert!((store.level() / (80.0 * (1.0 + EXCESS)) - 1.0).abs() < 1e-4, "{}", store.level());
        }
    }

    /// What a winding bears for ever it bears for a tick, also where the housing follows faster than ticks do.
    #[test]
    fn the_cap_is_no_less_than_what_is_borne_for_ever() {
        for (winding_time, housing_time) in [(2.0, 100.0), (0.05, 1e-3), (0.05, 1e-6)] {
            let cooling = Cooling { winding_time, housing_time, ..cooling() };
            let mut store = Store::heat(&cooling).unwrap();
            let steady = cooling.continuous_amperes().powi(2);
            let tick = winding_time / 400.0;
            for _ in 0..4000 {
                assert!(store.hard(tick) >= steady, "{winding_time} {housing_time}: {store:?}");
                store.step(steady, tick);
            }
        }
    }

    #[test]
    fn it_follows_in_the_time_of_what_fills() {
        assert_eq!(Store::heat(&cooling()).unwrap().time(), 2.0);
        assert_eq!(Store::mean(1.0, 0.5, 1e-3).time(), 0.5);
    }

    /// Driven by what it allows, the winding approaches its limit as e^(−8 t / τ), and what is left there is what it bears for ever.
    #[test]
    fn what_it_allows_approaches_the_limit_as_it_says() {
        let mut store = Store::heat(&cooling()).unwrap();
        let (tick, mut time) = (1e-4, 0.0);
        for _ in 0..5000 {
            store.step(store.soft(), tick);
            time += tick;
            let expected = 80.0 * (1.0 - (-HASTE * time / 2.0f64).exp());
            assert!((store.level() - expected).abs() < 0.01, "{time}: {} {expected}", store.level());
        }
        for _ in 0..200_000 {
            store.step(store.soft(), 0.01);
        }
        let steady = cooling().continuous_amperes();
        assert!((store.soft() / (steady * steady) - 1.0).abs() < 1e-6 && (store.level() - 80.0).abs() < 1e-6);
    }
}
