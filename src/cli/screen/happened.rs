//! What happened, in a line each.

use std::borrow::Cow;
use std::fmt::Write;

use pacinian::io::device::keeper::Fate;
use pacinian::node::motion::Motion;
use pacinian::performer::{Happening, Heard};
use pacinian::space::spot::Spot;

/// What is said where it may come back on another device.
pub const LOWERED: &str = "nobody has named the device, and the system may play on another: at -20 dB until it is armed (--device names one)";

/// How it is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mood {
    /// What was to be expected.
    #[default]
    Usual,
    /// What somebody has asked for.
    Told,
    /// What is good news.
    Good,
    /// What is not.
    Bad,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Happened {
    /// Seconds since the beginning.
    pub at: f64,
    /// What.
    pub text: String,
    /// How it is meant.
    pub mood: Mood,
    /// How often the same happened since, without anything in between.
    pub again: u64,
    /// The control that has moved, if that is what happened.
    pub control: Option<String>,
}

impl Happened {
    /// At so many seconds. A text of several lines, such as that of a problem with its help, is put into one.
    pub fn new(at: f64, mood: Mood, text: impl Into<String>) -> Self {
        let mut text: String = text.into();
        if text.contains('\n') {
            let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
            text =
                lines.map(|line| line.strip_prefix("help: ").unwrap_or(line)).collect::<Vec<_>>().join(": ");
        }
        Self { at, text, mood, again: 0, control: None }
    }

    /// The same of what played and was not felt, and why.
    pub fn unfelt(mut self, why: &str) -> Self {
        self.text += &format!(", not felt: {why}");
        self
    }

    /// Which voice begins, and where, if one does.
    pub fn who(heard: &Heard<'_>) -> Option<String> {
        match heard.what {
            Happening::Voice { name, place, .. } => Some(format!("{name} on {}", spot(place))),
            _ => None,
        }
    }

    /// The same of that voice, if it is known.
    pub fn releases(self, who: Option<&String>) -> Self {
        Self { text: who.map_or(self.text, |who| format!("{who} {RELEASED}")), ..self }
    }

    /// The same of that voice, if it is known.
    pub fn touches(self, who: Option<&String>, motion: Motion, to: f64) -> Self {
        Self { text: who.map_or(self.text, |who| format!("{who} {}", touched(motion, to))), ..self }
    }

    /// An event that the performer tells of.
    pub fn heard(heard: &Heard<'_>) -> Self {
        let mut text = String::new();
        let _ = match heard.what {
            Happening::Voice { name, place, level, felt, duration, fields, own, pitched } => {
                let mut own = fields.iter().zip(own);
                let frequency = own.find(|((name, _), _)| pitched && name == "frequency");
                let how = match felt {
                    None => short(level),
                    Some(felt) if level == 1.0 => format!("{} dB felt", short(felt)),
                    Some(felt) => format!("{} of {} dB felt", short(level), short(felt)),
                };
                write!(text, "{name} on {} at {how}", spot(place))
                    .and_then(|()| match frequency {
                        Some((_, hertz)) => write!(text, ", {} Hz", short(*hertz)),
                        None => Ok(()),
                    })
                    .and_then(|()| match duration.is_finite() {
                        true => write!(text, ", {}", seconds(duration)),
                        false => write!(text, ", held"),
                    })
            }
            Happening::Start(name) => write!(text, "pattern {name} begins"),
            Happening::Marker(name) => write!(text, "marker {name}"),
            Happening::Message(_) => write!(text, "a message of the song"),
            Happening::Control(name, value) => write!(text, "{name} to {}", short(value)),
            Happening::Waits { control, position, stands } => write!(
                text,
                "{control} waits to be picked up: what moves it is at {}, and takes it at {}",
                short(position),
                short(stands)
            ),
            Happening::Touch(motion, to) => write!(text, "a voice {}", touched(motion, to)),
            Happening::Release => write!(text, "a voice {RELEASED}"),
            Happening::ReleaseAll => write!(text, "all voices are released"),
            Happening::Silence(_) => write!(text, "what MIDI had started falls silent"),
            Happening::Cancel(_) => write!(
                text,
                "a pattern is stopped: what was still to begin of it is called off, and what sounds is released"
            ),
        };
        if let Some(origin) = heard.origin {
            let _ = write!(text, "  [{}]", origin.pattern);
        }
        let mood = match heard.what {
            Happening::Voice { .. } | Happening::Touch(..) | Happening::Release => Mood::Usual,
            Happening::Start(_)
            | Happening::Marker(_)
            | Happening::Message(_)
            | Happening::Control(..)
            | Happening::Waits { .. }
            | Happening::ReleaseAll
            | Happening::Silence(_)
            | Happening::Cancel(_) => Mood::Told,
        };
        let control = match heard.what {
            Happening::Control(name, _) => Some(name.into()),
            _ => None,
        };
        Self { control, ..Self::new(heard.at, mood, text) }
    }

    /// What became of the device.
    pub fn fate(at: f64, fate: Fate) -> Self {
        match fate {
            Fate::Lost(why) => {
                Self::new(at, Mood::Bad, format!("the device is gone ({why}); going on in silence"))
            }
            Fate::Back => Self::new(at, Mood::Good, "the device is back"),
            Fate::Moved => Self::new(at, Mood::Bad, "the system moved the stream to another device"),
            Fate::Lowered => Self::new(at, Mood::Told, LOWERED),
            Fate::Said(what) => Self::new(at, Mood::Bad, what),
        }
    }

    /// Its text, with how often.
    pub fn told(&self) -> String {
        match self.again {
            0 => self.text.clone(),
            again => format!("{} (x {})", self.text, again + 1),
        }
    }
}

const RELEASED: &str = "is released";

/// What a hand does with a voice, and how far.
fn touched(motion: Motion, to: f64) -> String {
    let percent = |x: f64| format!("{} %", (100.0 * x).round());
    match motion {
        // The share of its frequency by which it is moved: 1 is an octave.
        Motion::Detune => match short(12.0 * (1.0 + to.max(-1.0)).log2()).as_str() {
            "0" => "is bent back".into(),
            down if down.starts_with('-') => format!("is bent by {down} semitones"),
            up => format!("is bent by +{up} semitones"),
        },
        Motion::Pressure => format!("is pressed to {}", percent(to)),
        Motion::Timbre => format!("is tilted to {}", percent(to)),
    }
}

/// A number in as many digits as one reads at a glance: three, or all before the point.
pub fn short(value: f64) -> String {
    let digits = match value.abs() {
        x if x >= 99.95 => 0,
        x if x >= 9.995 => 1,
        _ => 2,
    };
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

/// A place by its name; a point without digits that nobody can feel: they are metres.
fn spot(place: &str) -> Cow<'_, str> {
    match Spot::unnamed(place) {
        Some(Spot::Point(point)) => {
            let metres = point.map(|x| {
                let text = format!("{x:.4}");
                let text = text.trim_end_matches('0').trim_end_matches('.');
                if text == "-0" { "0".into() } else { text.to_string() }
            });
            format!("[{}]", metres.join(", ")).into()
        }
        _ => place.into(),
    }
}

/// A duration.
fn seconds(value: f64) -> String {
    if value < 1.0 { format!("{} ms", short(1000.0 * value)) } else { format!("{} s", short(value)) }
}

/// Minutes and seconds since the beginning, and hours where there are any.
pub fn clock(seconds: f64) -> String {
    let (whole, hour) = (seconds.max(0.0) as u64, 3600);
    let (minutes, rest) = (whole % hour / 60, whole % 60);
    if whole >= hour {
        format!("{}:{minutes:02}:{rest:02}", whole / hour)
    } else {
        format!("{minutes}:{rest:02}")
    }
}

/// The same, to the millisecond.
pub fn moment(seconds: f64) -> String {
    let thousandths = (seconds.max(0.0) * 1000.0).round() as u64;
    format!("{}.{:03}", clock((thousandths / 1000) as f64), thousandths % 1000)
}

#[cfg(test)]
mod tests {
    use super::{Happened, Mood, clock, moment, short, spot};
    use pacinian::performer::{Happening, Heard, Origin};
    use pacinian::schedule::Instant;
    use pacinian::text::Problem;

    #[test]
    fn times_and_numbers_are_short() {
        assert_eq!(
            [0.0, 59.9, 61.0, 3600.0, 36_061.0].map(clock),
            ["0:00", "0:59", "1:01", "1:00:00", "10:01:01"]
        );
        assert_eq!([0.0, 1.2345, 59.9996].map(moment), ["0:00.000", "0:01.235", "1:00.000"]);
        assert_eq!(
            [0.0, -0.001, 0.804, 12.34, 250.0, 999.6, 12_345.6].map(short),
            ["0", "0", "0.8", "12.3", "250", "1000", "12346"]
        );
    }

    #[test]
    fn places_are_told_to_a_tenth_of_a_millimetre() {
        let sum = 0.045_000_000_000_000_005;
        assert_eq!(format!("{sum:?}").len(), 20, "{sum:?}");
        let place = |point: [f64; 3]| pacinian::space::spot::Spot::Point(point).name(|_| None).into_owned();
        assert_eq!(spot(&place([sum, -0.0, -0.120_04])), "[0.045, 0, -0.12]");
        assert_eq!([spot("left"), spot("path 2"), spot("[odd]")], ["left", "path 2", "[odd]"]);
    }

    #[test]
    fn a_problem_with_its_help_is_one_line() {
        let problem = Problem::of_file("there is no voice `hmu`").help("did you mean `hum`?".to_string());
        let happened = Happened::new(0.0, Mood::Bad, problem.to_string());
        assert_eq!(happened.text, "there is no voice `hmu`: did you mean `hum`?");
        assert_eq!(Happened::new(0.0, Mood::Bad, "one\n\n two").text, "one: two");
    }

    #[test]
    fn a_voice_says_what_where_and_how() {
        let fields = [("roughness".to_string(), 0.0), ("frequency".to_string(), 1.0)];
        let what = |duration, pitched| Happening::Voice {
            name: "pulse",
            place: "chest",
            felt: None,
            level: 0.8,
            duration,
            fields: &fields,
            own: &[0.3, 175.0],
            pitched,
        };
        let origin = Some(Origin { pattern: "beat", event: 0, drawn: None });
        let heard =
            Heard { at: 1.5, instant: Instant::default(), origin, id: Some(1), what: what(0.12, true) };
        assert_eq!(Happened::heard(&heard).text, "pulse on chest at 0.8, 175 Hz, 120 ms  [beat]");
        let heard = Heard { origin: None, what: what(f64::INFINITY, true), ..heard };
        assert_eq!(Happened::heard(&heard).text, "pulse on chest at 0.8, 175 Hz, held");
        // What its nodes do not read does not sound.
        let heard = Heard { what: what(0.12, false), ..heard };
        assert_eq!(Happened::heard(&heard).text, "pulse on chest at 0.8, 120 ms");
    }
}
