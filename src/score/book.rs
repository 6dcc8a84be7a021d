//! The book: every pattern that may be played, with names resolved and numbers checked.

use std::collections::HashMap;
use std::sync::Arc;

use super::sheet::{Burst, Content, Deed, Deviations, Item, Nested, Play, Sheet};
use super::{EventStream, FIELDS, Places, Root, length};
use crate::patch::felt::strength;
use crate::patch::{self, Action, Event, Events, Motion, Patch, Pattern, Place, Repeat, motion};
use crate::space::spot::Spot;
use crate::text::{Problem, Span};

/// Finds where places are.
pub(super) type Where<'a> = Box<dyn Places + Send + 'a>;

/// Opens an events file.
pub(super) type Files<'a> = Box<dyn FnMut(&str) -> Result<EventStream<'a>, Problem> + Send + 'a>;

/// What a voice says of its events.
struct Instrument {
    name: String,
    level: f64,
    felt: Option<f64>,
    duration: f64,
    place: Option<Place>,
    /// The output for `place`, once it has been asked for.
    output: Option<Spot>,
    fields: Vec<String>,
    own: [f64; FIELDS],
}

/// Every pattern that may be played.
pub(super) struct Book<'a> {
    /// By their place in the patch; `None` for what cannot be reached.
    sheets: Vec<Option<Sheet>>,
    instruments: Vec<Instrument>,
    voices: HashMap<String, u32>,
    patterns: HashMap<String, usize>,
    places: Where<'a>,
    files: Files<'a>,
    /// Bursts of motions, up to here.
    bursts: usize,
}

/// All motions of a patch have no more bursts: that is some hundred megabytes of them.
const MOST_BURSTS: usize = 1_000_000;

impl<'a> Book<'a> {
    /// Of what can be reached from the roots.
    pub fn new(patch: &Patch, roots: &[Root], places: Where<'a>, files: Files<'a>) -> Result<Self, Problem> {
        let instrument = |voice: &patch::Voice| {
            let mut own = [0.0; FIELDS];
            for (slot, (_, value)) in own.iter_mut().zip(&voice.fields) {
                *slot = *value;
            }
            Instrument {
                name: voice.name.clone(),
                level: voice.level,
                felt: voice.felt.as_ref().map(|felt| felt.value),
                duration: voice.duration,
                place: voice.place.clone(),
                output: None,
                fields: voice.fields.iter().map(|(name, _)| name.clone()).collect(),
                own,
            }
        };
        let mut book = Self {
            sheets: vec![None; patch.patterns.len()],
            instruments: patch.voices.iter().map(instrument).collect(),
            voices: patch.voices.iter().zip(0..).map(|(v, i)| (v.name.clone(), i)).collect(),
            patterns: patch.patterns.iter().enumerate().map(|(i, p)| (p.name.clone(), i)).collect(),
            places,
            files,
            bursts: 0,
        };
        let mut ahead: Vec<usize> = roots.iter().map(|root| root.pattern).collect();
        while let Some(index) = ahead.pop() {
            let Some(pattern) = patch.patterns.get(index) else {
                let last = patch.patterns.len();
                return Err(Problem::of_file(format!(
                    "pattern {index} is played, but there are {last} from 0"
                )));
            };
            if book.sheets[index].is_some() {
                continue;
            }
            let sheet = book.sheet_of(pattern)?;
            match &sheet.content {
                // Its lines may name any.
                Content::File { .. } => ahead.extend(0..patch.patterns.len()),
                Content::Held(items) => ahead.extend(items.iter().flat_map(|i| length::nested(&i.deed))),
            }
            book.sheets[index] = Some(sheet);
        }
        length::settle(&mut book.sheets)?;
        Ok(book)
    }

    /// A sheet.
    pub fn sheet(&self, index: usize) -> Result<&Sheet, Problem> {
        let sheet = self.sheets.get(index).and_then(Option::as_ref);
        sheet.ok_or_else(|| Problem::of_file(format!("pattern {index} was not prepared")))
    }

    /// Remembers what an events file turned out to hold.
    pub fn learn(&mut self, index: usize, content: Content) {
        if let Some(Some(sheet)) = self.sheets.get_mut(index) {
            sheet.barren = matches!(&content, Content::Held(items) if items.is_empty());
            sheet.content = content;
            if sheet.barren {
                length::spread_barrenness(&mut self.sheets);
            }
        }
    }

    /// Opens an events file.
    pub fn open(&mut self, path: &str) -> Result<EventStream<'a>, Problem> {
        (self.files)(path)
    }

    /// A voice's own fields, and their names.
    pub fn fields(&self, voice: u32) -> ([f64; FIELDS], &[String]) {
        self.instruments.get(voice as usize).map_or(([0.0; FIELDS], &[]), |i| (i.own, &i.fields))
    }

    /// Whether nothing ever comes of it.
    pub fn is_barren(&self, deed: &Deed) -> bool {
        length::is_barren(&self.sheets, deed)
    }

    fn sheet_of(&mut self, pattern: &Pattern) -> Result<Sheet, Problem> {
        let of = |what: String| Problem::error(&pattern.span, format!("pattern `{}`: {what}", pattern.name));
        let unit = pattern.time.seconds();
        if !(unit > 0.0 && unit.is_finite()) {
            return Err(of("its tempo must be above 0".into()));
        }
        if !(pattern.rate > 0.0 && pattern.rate.is_finite()) {
            return Err(of(format!("its rate is {}, and must be above 0", pattern.rate)));
        }
        if !pattern.gain.is_finite() {
            return Err(of("its gain is not a number".into()));
        }
        check_repeat(pattern.repeat.as_ref()).map_err(of)?;
        let jitter = pattern.jitter.as_ref().filter(|j| j.at != 0.0 || !j.fractions.is_empty());
        if jitter.is_some_and(|j| !(j.at >= 0.0 && j.at.is_finite())) {
            return Err(of("its jitter of `at` must be at least 0".into()));
        }
        let deviations = |j: &patch::Jitter| Deviations {
            at: j.at,
            fractions: j.fractions.iter().map(|s| (s.name.clone(), s.value)).collect(),
        };
        let mut sheet = Sheet {
            name: pattern.name.as_str().into(),
            span: pattern.span.clone(),
            unit,
            gain: pattern.gain,
            rate: pattern.rate,
            repeat: pattern.repeat,
            shuffle: pattern.shuffle,
            jitter: jitter.map(deviations),
            content: Content::Held(Arc::default()),
            barren: false,
            length: None,
        };
        sheet.content = match &pattern.events {
            Events::Inline(events) => {
                let mut items = Vec::with_capacity(events.len());
                for (number, event) in (0..).zip(events) {
                    let item = self.item(event, number, sheet.unit / sheet.rate);
                    items.push(item.map_err(|what| place(what, &event.span, &pattern.name, number))?);
                }
                sheet.sort(&mut items);
                Content::Held(Arc::new(items))
            }
            Events::File(path, span) => {
                Content::File { path: path.as_str().into(), span: span.clone(), long: false }
            }
        };
        Ok(sheet)
    }

    /// An event with its names resolved, in a pattern of which a unit of time is so many seconds.
    pub fn item(&mut self, event: &Event, number: u64, unit: f64) -> Result<Item, Problem> {
        let says = |what: &str| Problem::error(&event.span, what);
        if !(event.at >= 0.0 && event.at.is_finite()) {
            return Err(says(&format!("`at` is {}, and must be at least 0", event.at)));
        }
        if !(event.delay >= 0.0 && event.delay.is_finite()) {
            return Err(says(&format!("`delay` is {}, and must be at least 0", event.delay)));
        }
        check_repeat(event.repeat.as_ref()).map_err(|what| says(&what))?;
        let deed = match &event.action {
            Action::Choose(alternatives) => {
                let (mut sum, mut all) = (0.0, Vec::with_capacity(alternatives.len()));
                for alternative in alternatives {
                    let weight = alternative.weight;
                    if !(weight >= 0.0 && weight.is_finite()) {
                        return Err(says(&format!("a weight is {weight}, and must be above 0")));
                    }
                    sum += weight;
                    all.push((sum, self.deed(&alternative.action, &event.span, unit)?));
                }
                if !(sum > 0.0 && sum.is_finite()) {
                    return Err(says("a choice needs alternatives whose weights add up to more than 0"));
                }
                Deed::Choose(all.into())
            }
            action => self.deed(action, &event.span, unit)?,
        };
        let repeat = event.repeat.filter(|r| r.times != Some(1)).map(Box::new);
        Ok(Item { at: event.at, delay: event.delay, repeat, number, deed })
    }

    fn deed(&mut self, action: &Action, span: &Span, unit: f64) -> Result<Deed, Problem> {
        let says = |what: String| Problem::error(span, what);
        match action {
            Action::Voice(play) => match &play.motion {
                Some(motion) => self.motion(play, motion, span, unit),
                None => self.play(play, span).map(Deed::Play),
            },
            Action::Pattern { pattern, gain, rate, .. } => {
                let sheet = self.patterns.get(pattern).copied();
                let sheet = sheet.ok_or_else(|| says(format!("there is no pattern `{pattern}`")))?;
                if !(gain.is_finite() && rate.is_finite() && *rate > 0.0) {
                    return Err(says(format!(
                        "gain {gain} and rate {rate} of pattern `{pattern}` cannot be played"
                    )));
                }
                Ok(Deed::Pattern(Nested { sheet, gain: *gain, rate: *rate }))
            }
            Action::Marker(name) => Ok(Deed::Marker(name.as_str().into())),
            Action::Choose(_) => Err(says("an alternative of a choice cannot be a choice".into())),
        }
    }

    /// A voice in several bursts; a unit of time is so many seconds.
    fn motion(
        &mut self,
        play: &patch::Play,
        motion: &Motion,
        span: &Span,
        unit: f64,
    ) -> Result<Deed, Problem> {
        // Where there is no such voice, that is said first.
        let first = patch::Play { place: motion.places.first().cloned(), ..play.clone() };
        let plain = self.play(&first, span)?;
        let bursts = motion.bursts(plain.duration * unit, self.places.array()).map_err(|fault| {
            Problem::error(&motion.span, format!("`{}` of voice `{}`: {fault}", motion.key(), play.voice))
        })?;
        self.bursts += bursts.list.len();
        if self.bursts > MOST_BURSTS {
            let what = format!("the motions of the patch come to more than {MOST_BURSTS} bursts, up to here");
            let help = "write one that recurs once, in a pattern that others play".to_string();
            return Err(Problem::error(&motion.span, what).help(help));
        }
        let burst = |burst: &motion::Burst| {
            let place = self.places.spot(Some(&burst.place))?;
            let play = Play { place, duration: burst.seconds / unit, ..plain.clone() };
            Ok(Burst { start: burst.start / unit, play })
        };
        Ok(Deed::Motion(bursts.list.iter().map(burst).collect::<Result<_, Problem>>()?))
    }

    fn play(&mut self, play: &patch::Play, span: &Span) -> Result<Play, Problem> {
        let says = |what: String| Problem::error(span, what);
        let voice = self.voices.get(&play.voice).copied();
        let voice = voice.ok_or_else(|| says(format!("there is no voice `{}`", play.voice)))?;
        let Some(instrument) = self.instruments.get_mut(voice as usize) else {
            return Err(says(format!("there is no voice `{}`", play.voice)));
        };
        if instrument.fields.len() > FIELDS {
            let what = format!("voice `{}` has {} fields", instrument.name, instrument.fields.len());
            return Err(says(what).help(format!("at most {FIELDS} are possible, frequency included")));
        }
        let mut own = Vec::with_capacity(play.fields.len());
        for patch::Setting { name, value, .. } in &play.fields {
            let place = (0..).zip(&instrument.fields).find(|(_, n)| *n == name);
            let (place, _) =
                place.ok_or_else(|| says(format!("voice `{}` has no field `{name}`", instrument.name)))?;
            own.push((place, *value));
        }
        let said = play.felt.as_ref().map(|felt| felt.value);
        let (level, felt) = strength(play.level, said, (instrument.level, instrument.felt));
        let duration = play.duration.unwrap_or(instrument.duration);
        if level.is_nan()
            || felt.is_some_and(f64::is_nan)
            || duration.is_nan()
            || own.iter().any(|(_, v)| v.is_nan())
        {
            return Err(says(format!("a field of an event of voice `{}` is not a number", instrument.name)));
        }
        let output = match (&play.place, instrument.output) {
            (None, Some(output)) => output,
            (None, None) => {
                let output = self.places.spot(instrument.place.as_ref())?;
                instrument.output = Some(output);
                output
            }
            (Some(place), _) => self.places.spot(Some(place))?,
        };
        Ok(Play { voice, place: output, level, felt, duration, own: own.into() })
    }
}

/// The same problem with the event named.
fn place(problem: Problem, span: &Span, pattern: &str, number: u64) -> Problem {
    let what = format!("event {} of pattern `{pattern}`: {}", number + 1, problem.what);
    Problem { span: Some(problem.span.unwrap_or_else(|| span.clone())), what, ..problem }
}

fn check_repeat(repeat: Option<&Repeat>) -> Result<(), String> {
    match repeat {
        Some(r) if !(r.every > 0.0 && r.every.is_finite()) => {
            Err(format!("`repeat` is every {}, and must be above 0", r.every))
        }
        Some(r) if r.times == Some(0) => Err("`repeat` is 0 times, and must be at least 1".into()),
        _ => Ok(()),
    }
}
