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
    /// Whether so much would have had to be cut that part of the resonance stays.
    stays: bool,
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
            stays: even.cut_held,
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
        let boost = match self.boost_db {
            less if less < 0.05 => String::new(),
            boost => {
                let level = 10f64.powf(-boost / 20.0);
                format!(
                    ", raised by {boost:.1} dB at most: above a level of {level:.2} the limiter may take that back"
                )
            }
        };
        let stays = if self.stays { ", part of the resonance stays" } else { "" };
        format!(
            "resonance moved from {hertz:.1} Hz, Q {q:.2} to {to:.1} Hz, Q {even_q:.2}{gain}{boost}{limited}{stays}"
        )
    }
}
