//! Events files from the patch's folder: streamed for the score, or read through once to find what is wrong with them.

use super::assets::Folder;
use super::error::FileError;
use super::open::open as opened;
use crate::patch::advice::Advice;
use crate::patch::names::Names;
use crate::patch::{Action, Event, EventsFile, Patch, Place, Play};
use crate::score::{EventStream, MOST_HELD};
use crate::text::{Problem, Severity, Span};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};
use std::fs::File;
use std::io::BufReader;

/// What reading an events file through found out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// Events that can be played.
    pub events: u64,
    /// Places that they name: each tactor and channel once.
    pub places: Vec<Place>,
    /// What is wrong, each at its place in `source`; of at most [`MOST_PROBLEMS`] lines.
    pub problems: Vec<Problem>,
    /// Warnings about the first line that works and will hardly be felt as it was meant, at its place in `source`.
    pub advice: Vec<Problem>,
    /// What stands in the file, as [`EventsFile::source`] has it.
    pub source: String,
}

/// After so many bad lines the file is read no further.
pub const MOST_PROBLEMS: usize = 50;

/// Opens an events file for [`crate::player::Player::with_files`]. What its lines name is left to the score.
///
/// # Errors
/// When it is not in the folder or cannot be read, and when its columns are wrong.
pub fn open(folder: &Folder, path: &str) -> Result<EventStream<'static>, Problem> {
    let file = file(folder, path).map_err(|error| Problem::of_file(error.message))?;
    Ok(Box::new(EventsFile::new(path, BufReader::new(file), None)?))
}

/// Reads an events file through. Each place is shown to `resolve` once, which says what is wrong with it.
///
/// # Errors
/// When it is not in the folder or cannot be read; bad lines are in the survey.
pub fn survey(
    folder: &Folder,
    path: &str,
    patch: &Patch,
    resolve: impl FnMut(&Place) -> Option<Problem>,
) -> Result<Survey, FileError> {
    survey_with(folder, path, patch, resolve, |_| None)
}

/// The same, and each event that plays a voice is shown to `feel`, which says what is wrong with how strongly it is to be felt: of what is a warning, the first
/// is told.
///
/// # Errors
/// As [`survey`].
pub fn survey_with(
    folder: &Folder,
    path: &str,
    patch: &Patch,
    mut resolve: impl FnMut(&Place) -> Option<Problem>,
    mut feel: impl FnMut(&Play) -> Option<Problem>,
) -> Result<Survey, FileError> {
    let file = file(folder, path)?;
    let mut survey = Survey::default();
    let mut reader = match EventsFile::checked(path, BufReader::new(file), Names::new(patch)) {
        Ok(reader) => reader,
        Err((problem, source)) => {
            survey.problems.push(problem);
            survey.source = source;
            return Ok(survey);
        }
    };
    let head = reader.whole();
    let (mut names, mut channels) = (HashSet::new(), HashSet::new());
    let (mut order, mut advice) = (Order::default(), Advice::new(patch));
    let mut bad = 0;
    while let Some(event) = reader.line_of_events() {
        if bad >= MOST_PROBLEMS {
            survey.problems.push(Problem::of_file("too many bad lines to look at more"));
            break;
        }
        let event = match event {
            Ok(event) => event,
            Err(problems) => {
                survey.problems.extend(problems);
                bad += 1;
                continue;
            }
        };
        survey.events += 1;
        if survey.advice.is_empty() {
            let told = advice.of(&event, &format!("line {}", reader.line())).into_iter();
            let severity = Severity::Warning;
            let at = |p: Problem| {
                let span = p.span.clone().unwrap_or(event.span.clone());
                Problem { severity, ..reader.wrong(&span, &p.what, p.help) }
            };
            survey.advice = told.map(at).collect();
        }
        if let Some(late) = order.take(event.at) {
            let what = format!("`at` is {}, but {late}", event.at);
            let help = format!("sort the lines by `at`: none may come more than {MOST_HELD} lines late");
            survey.problems.push(reader.wrong(&event.span, &what, Some(help)));
        }
        if let Action::Voice(play) = &event.action
            && let Some(told) = feel(play)
        {
            let span = told.span.clone().unwrap_or(event.span.clone());
            let problem = Problem { severity: told.severity, ..reader.wrong(&span, &told.what, told.help) };
            if problem.is_error() {
                survey.problems.push(problem);
                bad += 1;
            } else if survey.advice.is_empty() {
                survey.advice.push(problem);
            }
        }
        let Some((place, span)) = place(&event) else { continue };
        let is_new = match place {
            Place::Name(name) => names.len() < MOST_NAMES && names.insert(name.clone()),
            Place::Channel(channel) => channels.insert(*channel),
            Place::Position(_) | Place::Names(_) | Place::Path(_) => false,
        };
        if is_new {
            survey.places.push(place.clone());
            survey.problems.extend(resolve(place).map(|p| reader.wrong(span, &p.what, p.help)));
        }
    }
    if survey.events == 0 && survey.problems.is_empty() {
        let help = "write a line for each, below the names of the columns".to_string();
        survey
            .advice
            .push(Problem::warning(&head, "the file has no events, only names of columns").help(help));
    }
    survey.source = reader.source();
    Ok(survey)
}

/// What a score would have played by the time it reads a line: it holds [`MOST_HELD`] of them to bring them into order.
#[derive(Debug, Default)]
struct Order {
    held: BinaryHeap<Reverse<Bits>>,
    played: f64,
    told: bool,
}

/// A time that is not negative, by which numbers and their bits have the same order.
type Bits = u64;

impl Order {
    /// The next line; why it comes too late, said of the first that does.
    fn take(&mut self, at: f64) -> Option<String> {
        if at < self.played {
            let first = !std::mem::replace(&mut self.told, true);
            return first.then(|| format!("what is at {} has been played", self.played));
        }
        // Without the sign of -0.
        self.held.push(Reverse(at.abs().to_bits()));
        if self.held.len() > MOST_HELD
            && let Some(Reverse(bits)) = self.held.pop()
        {
            self.played = f64::from_bits(bits);
        }
        None
    }
}

/// More names than this no rig has, so one of them has been complained about.
const MOST_NAMES: usize = 2 * crate::rig::MAX_CHANNELS as usize;

fn place(event: &Event) -> Option<(&Place, &Span)> {
    if let Action::Voice(play) = &event.action {
        Some((play.place.as_ref()?, &play.place_span))
    } else {
        None
    }
}

fn file(folder: &Folder, path: &str) -> Result<File, FileError> {
    opened(&folder.resolve(path)?)
}

#[cfg(test)]
mod tests {
    use super::{open, survey};
    use crate::io::assets::Folder;
    use crate::patch::{Patch, Place};
    use crate::rig::Rig;
    use crate::space::spot::Spot;
    use crate::text::Problems;

    const PATCH: &[u8] = b"format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"s\"\nnodes.s = { type = \"white\" }\n";

    /// Line and column of each problem.
    fn places_of(found: &super::Survey) -> Vec<(usize, usize)> {
        let shown = Problems { source: found.source.clone(), ..Problems::default() };
        found.problems.iter().map(|p| shown.position(p.span.as_ref().unwrap().start)).collect()
    }

    /// A line with several mistakes tells them all, each at its cell; the lines of a large table keep their numbers.
    #[test]
    fn every_mistake_of_a_line_is_told_at_its_cell() {
        let folder = std::env::temp_dir().join(format!("pacinian-cells-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let patch = Patch::parse("p", PATCH).unwrap().value;
        let files = Folder::new(&folder);
        for (before, spaces) in [(1, ""), (100_000, "  ")] {
            let good = "0.25,a,0.5\n".repeat(before);
            let text = format!("\u{feff}at,voice,level\n{good}\n# µ\n{spaces}x,\"b\",loud\n{good},,1\n");
            std::fs::write(folder.join("w.csv"), text).unwrap();
            let found = survey(&files, "w.csv", &patch, |_| None).unwrap();
            let (bad, indent) = (before + 4, spaces.len());
            let last = 2 * before + 5;
            let expected = [(bad, 1 + indent), (bad, 3 + indent), (bad, 7 + indent), (last, 1), (last, 1)];
            assert_eq!(places_of(&found), expected, "{:?}", found.problems);
            assert!(found.source.contains("x,\"b\",loud") && found.source.len() < 1 << 20);
        }
        std::fs::write(folder.join("w.csv"), "at,voice\n").unwrap();
        let found = survey(&files, "w.csv", &patch, |_| None).unwrap();
        assert!(found.advice.len() == 1 && found.advice[0].what.contains("no events"), "{:?}", found.advice);
        for text in ["at;voice;level\n0;a;1\n", "at\tvoice\n"] {
            std::fs::write(folder.join("w.csv"), text).unwrap();
            let found = survey(&files, "w.csv", &patch, |_| None).unwrap();
            assert!(found.problems[0].to_string().contains("divided by commas"), "{:?}", found.problems);
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn every_bad_line_and_every_place_is_found() {
        let folder = std::env::temp_dir().join(format!("pacinian-events-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let text = "at,voice,place\n0,a,t1\n1,b,t1\n2,a,nowhere\nx,a,\n3,a,nowhere\n4,a,2\n5,a,0.1 0.2\n";
        std::fs::write(folder.join("w.csv"), text).unwrap();
        let patch = Patch::parse("p", PATCH).unwrap().value;
        let rig = Rig::default_for(2);
        let files = Folder::new(&folder);
        let found = survey(&files, "w.csv", &patch, |p| rig.resolve(Some(p), &(0..0)).err()).unwrap();
        assert_eq!(places_of(&found), [(3, 3), (4, 5), (5, 1)], "{:?}", found.problems);
        let places = [Place::Name("t1".into()), Place::Name("nowhere".into()), Place::Channel(2)];
        assert_eq!((found.events, found.places.as_slice()), (5, &places[..]));

        assert_eq!(
            open(&files, "w.csv").unwrap().filter(Result::is_ok).count(),
            6,
            "names are not its business"
        );
        assert_eq!(survey(&files, "none.csv", &patch, |_| None).unwrap_err().exit_code(), 66);
        assert_eq!(survey(&files, "../w.csv", &patch, |_| None).unwrap_err().exit_code(), 65);
        assert!(open(&files, ".").is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    /// Of many lines that will not be felt, the first is told, once.
    #[test]
    fn what_will_not_be_felt_is_told_of_the_first_line() {
        let folder = std::env::temp_dir().join(format!("pacinian-unfelt-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = Folder::new(&folder);
        let patch = [
            PATCH,
            b"[voice.b]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n",
        ];
        let patch = Patch::parse("p", &patch.concat()).unwrap().value;
        let told = |lines: &str| {
            std::fs::write(folder.join("w.csv"), format!("at,voice,frequency,level\n{lines}")).unwrap();
            let found = survey(&files, "w.csv", &patch, |_| None).unwrap();
            assert_eq!(found.problems, []);
            found.advice.into_iter().map(|p| (p.is_error(), p.what)).collect::<Vec<_>>()
        };
        let high = "frequency 5000 of line 4: nothing above 1000 Hz is felt".to_string();
        assert_eq!(told("0,b,300,\n1,b,,\n2,b,5000,\n3,b,7000,9\n"), [(false, high)]);
        let loud = told("0,a,,0.5\n1,a,,2\n");
        assert!(loud.len() == 1 && loud[0].1.starts_with("level 2 of line 3"), "{loud:?}");
        assert_eq!(told("0,b,1000,1\n1,b,,\n"), []);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    /// What the survey passes, a score plays, and what it refuses, the score refuses at the same line.
    #[test]
    fn lines_too_late_for_a_score_are_found() {
        use crate::score::{MOST_HELD, Score};
        let folder = std::env::temp_dir().join(format!("pacinian-late-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = Folder::new(&folder);
        let patch = [PATCH, b"[pattern.p]\nevents = \"w.csv\"\n"].concat();
        let patch = Patch::parse("p", &patch).unwrap().value;
        for (before, good) in [(MOST_HELD, true), (MOST_HELD + 1, false), (70_000, false)] {
            let text = format!("at,voice\n{}0,a\n6,a\n", "5,a\n".repeat(before));
            std::fs::write(folder.join("w.csv"), text).unwrap();
            let found = survey(&files, "w.csv", &patch, |_| None).unwrap();
            assert_eq!(found.problems.is_empty(), good, "{before}: {:?}", found.problems);
            let mut score =
                Score::new(&patch, |_| Ok(Spot::Row(0)), &[(0, 0.0)], 0, |path| open(&files, path)).unwrap();
            assert_eq!(score.all(|event| event.is_ok()), good, "{before}");
            if let [problem] = &found.problems[..] {
                assert!(problem.what.starts_with("`at` is 0"), "{problem}");
                assert_eq!(places_of(&found), [(before + 2, 1)]);
            }
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
