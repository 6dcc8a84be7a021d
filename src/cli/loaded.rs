//! A patch on a rig, checked, and what plays it.

use super::failure::Failure;
use super::named::Codes;
use super::provenance::provenance;
use super::setting::Setting;
use pacinian::graph::scene::{Options, scene};
use pacinian::io::{
    assets::{Folder, recordings_rate},
    calibrations, events,
    input::Input,
};
use pacinian::live::reload::Reload;
use pacinian::midi::file::Song;
use pacinian::patch::Patch;
use pacinian::player::{OpenEvents, Player};
use pacinian::rig::{OutputKind, Rig, Turning};
use pacinian::score::EventStream;
use pacinian::text::{Origin, Problem, Problems, Severity, Sink};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

/// A patch on a rig, checked.
#[derive(Debug)]
pub struct Loaded {
    /// The patch.
    pub patch: Arc<Patch>,
    /// The rig.
    pub rig: Rig,
    /// How to compile them.
    pub options: Options,
    /// Warnings of all files.
    pub warnings: Vec<Problems>,
    /// Events of each events file, by its path in the patch.
    pub surveyed: Vec<(String, u64)>,
    /// Every file that was read.
    pub files: Vec<PathBuf>,
    /// Controls that the command line set.
    pub settings: Vec<Setting>,
    /// The voice that notes play, whatever its triggers do.
    pub notes: Option<String>,
    /// Files with tables of the rig's calibrations.
    pub tables: Vec<calibrations::Read>,
    /// What plays the patch besides its patterns.
    pub song: Option<Arc<Song>>,
    /// Its file.
    pub song_name: Option<String>,
    /// SHA-256 of its bytes.
    pub song_digest: Option<String>,
    /// What the `input` nodes hear.
    pub input: Option<Arc<Input>>,
    /// Its name as the person wrote it.
    pub input_name: Option<String>,
    /// The rig as it was read; `None` for the one that is there where nobody names any.
    pub rig_source: Option<Origin>,
    /// The patch as it was read.
    pub source: Problems,
    /// Where its recordings are.
    pub folder: Arc<Folder>,
}

impl Loaded {
    /// Takes an input, and warns of what of it cannot be heard.
    pub fn hear(&mut self, input: Option<Input>, listened: &[usize]) {
        let (Some(input), Some(name)) = (input, &self.input_name) else { return };
        let missing: Vec<usize> = input.missing().map(|c| c + 1).collect();
        let (what, help) = if listened.is_empty() {
            ("nothing in this patch listens to it".to_string(), "see `pacinian nodes input`")
        } else if missing.is_empty() {
            (String::new(), "")
        } else {
            let has = super::table::many(input.file_channels(), "channel");
            let lacking = super::input::named(&missing);
            (
                format!("the patch listens to {lacking}, the file has {has}; what is missing is silence"),
                "choose another `channel` in the patch or a file that has it",
            )
        };
        if !what.is_empty() {
            let warning =
                Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help.to_string()) };
            self.warnings.push(Problems { file: name.clone(), source: String::new(), list: vec![warning] });
        }
        self.input = Some(Arc::new(input));
    }

    /// The events of a file that the patch names.
    ///
    /// # Errors
    /// As [`events::open`].
    pub fn events(&self, path: &str) -> Result<EventStream<'static>, Problem> {
        events::open(&self.folder, path)
    }

    /// A player at its beginning.
    ///
    /// # Errors
    /// What only shows when the engine is built.
    pub fn player(&self) -> Result<Player, Failure> {
        Player::with_files(&self.patch, &self.rig, &self.options, &*self.folder, self.open_events())
            .map_err(|problems| self.refuse(problems.list, &Codes::new()))
            .and_then(|player| self.with_song(player))
    }

    fn with_song(&self, mut player: Player) -> Result<Player, Failure> {
        if let Some(song) = &self.song {
            player.play_song(song.messages.iter().copied(), song.seconds);
            let counted = player.follow_song(&song.tempi, song.seconds);
            counted.map_err(|problem| self.refuse(vec![problem], &Codes::new()))?;
        }
        Ok(player)
    }

    /// Opens its events files.
    pub fn open_events(&self) -> OpenEvents {
        let folder = Arc::clone(&self.folder);
        Box::new(move |path: &str| events::open(&folder, path))
    }

    /// Problems of the patch, with its source. Those that are a file's have the exit code of that.
    pub fn refuse(&self, list: Vec<Problem>, codes: &Codes) -> Failure {
        let mut problems = self.source.clone();
        let mut known = HashSet::new();
        let place = |p: &Problem| p.span.as_ref().map(|s| (s.start, s.end));
        problems.list = list.into_iter().filter(|p| known.insert((place(p), p.what.clone()))).collect();
        problems.list.sort_by_key(|p| p.span.as_ref().map_or(0, |s| s.start + 1));
        // A file that is not there is that, as long as nothing is wrong with the patch itself.
        let code = |p: &Problem| place(p).and_then(|place| codes.get(&place)).copied().unwrap_or(65);
        let mut all = problems.list.iter().filter(|p| p.is_error()).map(code);
        let first = all.next().unwrap_or(65);
        let code = if all.any(|code| code == 65) { 65 } else { first };
        let further = problems.list.len().saturating_sub(Sink::MOST);
        // One may be a count of others.
        if further > 1 {
            problems.list.truncate(Sink::MOST);
            let end = problems.source.len();
            problems.list.push(Problem::error(&(end..end), format!("and {further} more problems")));
        }
        Failure::of(code, problems)
    }

    /// Name of the patch as the person wrote it.
    pub fn name(&self) -> &str {
        &self.source.file
    }

    /// Names of the outputs in the order of the channels, and of lines that say which way a bridge turns one; "" where nothing hangs.
    pub fn tactors(&self) -> Vec<String> {
        let mut names = vec![String::new(); self.rig.device.channels as usize];
        let mut say = |channel: u32, said: String| {
            if let Some(name) = names.get_mut((channel as usize).wrapping_sub(1)) {
                *name = said;
            }
        };
        for output in &self.rig.outputs {
            say(output.channel, output.name.clone());
            if let OutputKind::Drive(Turning { direction: Some(line), .. }) = output.kind {
                say(line, format!("{}, direction", output.name));
            }
        }
        names
    }

    /// Compiled, ready to take over; with what a journal says of it, if there is one.
    pub fn reload(&mut self, options: &Options, journalled: bool) -> Result<Reload, Failure> {
        // Nobody knew the device's rate when the folder was opened.
        let rate = options.rate.map(recordings_rate);
        if let Some(folder) = rate.and_then(|rate| self.folder.at_other_rate(rate)) {
            self.folder = Arc::new(folder);
        }
        let refuse = |problems: Problems| self.refuse(problems.list, &Codes::new());
        let scene = scene(&self.patch, &self.rig, options, &*self.folder).map_err(refuse)?;
        let provenance = journalled.then(|| provenance(self, options)).transpose()?;
        Ok(Reload {
            scene,
            patch: Arc::clone(&self.patch),
            rig: Arc::new(self.rig.clone()),
            files: self.open_events(),
            provenance: provenance.map(Arc::new),
        })
    }
}
