//! What an equaliser makes of a resonance, as both `check` and `motor` say it.

use pacinian::actuator::coil::equaliser::{Equaliser, Limited};
use serde::Serialize;

/// What becomes of a resonance.
#[derive(Debug, Serialize)]
pub struct EvenReport {
    /// Hz and quality.
    from: [f64; 2],
    to: [f64; 2],
    gain_db: f64,
    boost_db: f64,
    /// What kept it from going farther.
    limited: Option<&'static str>,
}

impl EvenReport {
    /// That of an equaliser.
    pub fn new(even: &Equaliser) -> Self {
        Self {
            from: [even.own.hertz, even.own.q],
            to: [even.poles.hertz, even.poles.q],
            gain_db: 20.0 * even.gain.log10(),
            boost_db: even.boost,
            limited: even.limited.map(|limited| match limited {
                Limited::Boost => "the largest boost",
                Limited::Cut => "the largest cut",
                Limited::Volts => "volts",
                Limited::Amperes => "amperes",
                Limited::Heat => "heat",
                Limited::Stroke => "stroke",
            }),
        }
    }

    /// In words.
    pub fn text(&self) -> String {
        let ([hertz, q], [to, even_q]) = (self.from, self.to);
        let gain = if self.gain_db > -0.05 {
            String::new()
        } else {
            format!(" at a gain of {:.1} dB", self.gain_db)
        };
        let limited = self.limited.map_or(String::new(), |by| format!(", kept back by {by}"));
        let boost = if self.boost_db < 0.05 {
            String::new()
        } else {
            format!(", raised by {:.1} dB at most", self.boost_db)
        };
        format!(
            "resonance moved from {hertz:.1} Hz, Q {q:.2} to {to:.1} Hz, Q {even_q:.2}{gain}{boost}{limited}"
        )
    }
}
