//! What a program says about a voice that it plays.

use crate::patch::Place;

/// What a program may say about a voice that it plays; what it does not say is as the voice has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Note {
    /// Share of the rated vibration.
    pub level: Option<f64>,
    /// Seconds until the release; infinite to hold it.
    pub duration: Option<f64>,
    /// Where.
    pub place: Option<Place>,
    /// Fields that the voice declares, `frequency` among them.
    pub fields: Vec<(String, f64)>,
}
