//! What became of what was saved while it plays.

use super::happened::{Happened, Mood};
use super::{Out, Show, lines};
use crate::cli::failure::Failure;
use crate::cli::loaded::Loaded;
use crate::cli::problems;
use crate::cli::watch::News;
use pacinian::text::Problems;
use pacinian::text::problem::escaped;

impl Show {
    /// What became of something that was saved.
    pub fn watched(&mut self, news: &News) {
        let now = self.fetch.now();
        self.due = true;
        // In a log, what is wrong with a file is shown with its lines.
        let (why, brief, wrong, shown) = match news {
            News::Took(loaded, first, changed, _) => {
                self.snapshot.title = title(loaded);
                for (place, name) in self.snapshot.tactors.iter_mut().zip(loaded.tactors()) {
                    place.0 = name;
                }
                self.players.become_of(&loaded.patch, first);
                self.controls.become_of(&loaded.patch);
                (self.snapshot.stale, self.stale) = (None, String::new());
                self.snapshot.wrong.clear();
                let names: Vec<String> = changed.iter().map(|path| path.display().to_string()).collect();
                let names = escaped(&names.join(", ")).into_owned();
                let over = self.players.over(matches!(self.out, Out::Screen(_)));
                self.note(Happened::new(now, Mood::Good, format!("{names}: taken up{over}")));
                // What was said before is not said with every save.
                let new = loaded.warnings.iter().filter(|warning| !self.warned.contains(warning));
                let new: Vec<Problems> = new.cloned().collect();
                for warnings in &new {
                    self.warn(now, warnings);
                }
                self.warned.clone_from(&loaded.warnings);
                return;
            }
            News::Broken(failure) => (failure.text(&self.terminal), failure.brief(), in_full(failure), true),
            News::Kept(why, help) => {
                let failure = Failure::usage(why.as_str(), help.as_str());
                (failure.text(&self.terminal), format!("{why}: {help}"), in_full(&failure), false)
            }
        };
        match &mut self.out {
            // Together, so that nothing comes between.
            Out::Lines(lines) if shown => {
                let head =
                    Happened::new(now, Mood::Told, "the old one plays on, as what was saved is broken:");
                lines.put(&format!("{}\n{}", lines::event(&head), why.trim_end()));
            }
            _ => self.note(Happened::new(now, Mood::Told, format!("the old one plays on: {brief}"))),
        }
        (self.snapshot.stale, self.stale, self.snapshot.wrong) = (Some(brief), why, wrong);
    }

    fn warn(&mut self, now: f64, warnings: &Problems) {
        match &mut self.out {
            Out::Lines(lines) => lines.put(problems::shown(warnings, &self.terminal).trim_end()),
            Out::Screen(_) => {
                let brief = Failure::of(0, warnings.clone()).brief();
                self.note(Happened::new(now, Mood::Told, brief));
            }
        }
    }
}

/// All that is wrong, with line, column and help, a line each.
fn in_full(failure: &Failure) -> Vec<String> {
    failure
        .problems()
        .iter()
        .flat_map(|problems| problems.to_string().lines().map(String::from).collect::<Vec<_>>())
        .collect()
}

/// What the patch is called, or else its file.
pub(super) fn title(loaded: &Loaded) -> String {
    let title = Some(&loaded.patch.title).filter(|t| !t.is_empty());
    title.map_or(loaded.name(), String::as_str).into()
}
