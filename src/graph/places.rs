//! Where voices sound, as channels with gains.

use super::plan::Plan;
use crate::space::law::Law;
use crate::space::spot::{Spot, Spread};

/// The places of a plan.
#[derive(Debug, Clone)]
pub struct Places {
    rows: Vec<Vec<(u32, f64)>>,
    spread: Option<Spread>,
    /// By instrument: how tactors share its points, and how far those spread.
    sharing: Vec<(Law, f64)>,
    /// Room for what is found.
    found: Vec<(u32, f64)>,
}

impl Places {
    /// Those of a plan.
    pub fn new(plan: &Plan) -> Self {
        let most = plan.spread.as_ref().map_or(0, |spread| spread.channels().len());
        Self {
            rows: plan.places.clone(),
            spread: plan.spread.clone(),
            sharing: plan.instruments.iter().map(|instrument| (instrument.law, instrument.width)).collect(),
            found: Vec::with_capacity(most),
        }
    }

    /// The channels on which a voice of an instrument sounds, with their gains; none where there is no such place.
    pub fn of(&mut self, instrument: usize, spot: Spot) -> &[(u32, f64)] {
        match spot {
            Spot::Row(row) => self.rows.get(row as usize).map_or(&[][..], |row| row),
            Spot::Point(point) => {
                self.found.clear();
                let (law, width) = self.sharing.get(instrument).copied().unwrap_or_default();
                if let Some(spread) = &mut self.spread {
                    spread.gains(point, width, law, &mut self.found);
                }
                &self.found
            }
        }
    }
}
