//! What a program says about a voice that it plays.

use crate::patch::Place;

/// What a program may say about a voice that it plays; what it does not say is as the voice has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Note {
    /// Share of the rated vibration.
    pub level: Option<f64>,
    /// In place of a level: decibels above the threshold, on every tactor.
    pub felt: Option<f64>,
    /// Seconds until the release; infinite to hold it.
    pub duration: Option<f64>,
    /// Where.
    pub place: Option<Place>,
    /// Fields that the voice declares, `frequency` among them.
    pub fields: Vec<(String, f64)>,
}

impl Note {
    /// The same at this level, a share of the rated vibration.
    #[must_use]
    pub fn level(mut self, level: f64) -> Self {
        self.level = Some(level);
        self
    }
    /// The same so many decibels above the threshold, in place of a level.
    #[must_use]
    pub fn felt(mut self, decibels: f64) -> Self {
        self.felt = Some(decibels);
        self
    }
    /// The same with so many seconds until the release; infinite to hold it.
    #[must_use]
    pub fn duration(mut self, seconds: f64) -> Self {
        self.duration = Some(seconds);
        self
    }
    /// The same on the output of that name.
    #[must_use]
    pub fn at_place(mut self, name: &str) -> Self {
        self.place = Some(Place::Name(name.into()));
        self
    }
    /// The same at this frequency, Hz, for voices that read `event.frequency`.
    #[must_use]
    pub fn frequency(self, hertz: f64) -> Self {
        self.field("frequency", hertz)
    }
    /// The same with a field that the voice declares; one that was given before is replaced.
    #[must_use]
    pub fn field(mut self, name: &str, value: f64) -> Self {
        self.fields.retain(|(known, _)| known != name);
        self.fields.push((name.into(), value));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::Note;
    use crate::patch::Place;

    #[test]
    fn what_is_said_last_holds() {
        let note =
            Note::default().frequency(50.0).level(0.5).at_place("left").field("bite", 2.0).frequency(90.0);
        let fields = vec![("bite".to_string(), 2.0), ("frequency".into(), 90.0)];
        let place = Some(Place::Name("left".into()));
        assert_eq!(note, Note { level: Some(0.5), felt: None, duration: None, place, fields });
        assert_eq!(Note::default().duration(1.5).duration, Some(1.5));
    }
}
