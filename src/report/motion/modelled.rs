//! How an actuator was computed under a patch.

use crate::actuator::motor::Level;
use crate::feel::{Felt, Left};

/// How an actuator was computed under a patch, and what its model does not know of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Modelled {
    /// Of a rumble motor; `None`: of what has a coil, whose model is exact but for rounding.
    pub level: Option<Level>,
    /// Steps of the model for each frame.
    pub steps: u32,
    /// The largest error that was wished for, as a share of what is felt at the rated drive.
    pub error: f64,
    /// The one that is left where the wish cannot be granted; `None` where it is.
    pub reaches: Option<f64>,
    /// What of the model was left out, and why.
    pub left_out: Vec<Left>,
    /// What the rig does not say and was assumed, a clause each.
    pub assumed: Vec<String>,
}

impl Modelled {
    /// Of one for which so large an error was wished.
    pub(super) fn new(felt: &Felt, error: f64) -> Self {
        Self {
            level: felt.level(),
            steps: felt.steps(),
            error,
            reaches: felt.reaches(),
            left_out: felt.left_out().to_vec(),
            assumed: felt.assumed.clone(),
        }
    }
}
