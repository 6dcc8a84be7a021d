//! Makes a scene again from what a journal says that it was made of.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{digest, files};
use crate::graph::scene::{Options, Scene, scene};
use crate::io::assets::{Folder, recordings_rate};
use crate::io::error::{FileError, FileErrorKind};
use crate::live::provenance::{Provenance, RigText, Text};
use crate::patch::{Patch, Permissions};
use crate::rig::Rig;
use crate::text::{Origin, Problem, Problems};

/// Where the recordings are that a session's patches name, and whether they may be there. Of that a journal is not believed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recordings {
    /// The folder that their paths count from; `None`: where they were.
    pub folder: Option<PathBuf>,
    /// Whether they may lie outside of it.
    pub allow_outside: bool,
    /// The folder of those that are not there any more, by their digests: [`files::beside`] the journal.
    pub kept: Option<PathBuf>,
}

impl Recordings {
    /// The folder of what a scene was made of.
    pub fn folder(&self, made_of: &Provenance) -> Folder {
        let folder = self.folder.as_deref().unwrap_or(Path::new(&made_of.folder));
        Folder::new(folder).allow_outside(self.allow_outside)
    }

    /// Where one was kept, if it is what its name says.
    fn kept(&self, sha256: &str) -> Option<PathBuf> {
        let copy = files::copy_in(self.kept.as_deref()?, sha256)?;
        digest::of_file(&copy).is_ok_and(|now| now == sha256).then_some(copy)
    }
}

/// Why a scene cannot be made again.
#[derive(Debug, Clone, PartialEq)]
pub enum RemakeError {
    /// What the journal says cannot be: somebody has changed it.
    Journal(String),
    /// A file that is not there, or not what it was.
    File(FileError),
    /// What is wrong with patch or rig.
    Scene(Problems),
}

impl std::fmt::Display for RemakeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Journal(what) => what.fmt(f),
            Self::File(error) => error.fmt(f),
            Self::Scene(problems) => problems.fmt(f),
        }
    }
}

impl std::error::Error for RemakeError {}

/// The scene.
///
/// # Errors
/// Recordings that are not there or not the same any more, or of which the journal has no digest; and what is wrong with patch and rig,
/// which only another version of the program can find.
pub fn remake(made_of: &Provenance, recordings: &Recordings) -> Result<Scene, RemakeError> {
    let may = Permissions { allow_outside: recordings.allow_outside };
    let text = &made_of.patch;
    same(&text.text, &text.sha256, &text.name)?;
    let parsed = Patch::parse_with(&text.name, text.text.as_bytes(), may).map_err(RemakeError::Scene)?;
    let mut patch = parsed.value;
    for (name, value) in &made_of.set {
        let control = patch.controls.iter_mut().find(|control| control.name == *name);
        let control = control.ok_or_else(|| {
            let what = format!("the patch has no control `{name}`, which the session had set");
            RemakeError::Scene(patch.origin.problems(vec![Problem::of_file(what)]))
        })?;
        control.default = *value;
    }
    if let Some(voice) = made_of.notes.as_ref().filter(|voice| !patch.key(voice)) {
        let what = format!("the patch has no voice `{voice}`, which notes played");
        return Err(RemakeError::Scene(patch.origin.problems(vec![Problem::of_file(what)])));
    }
    let rig = match &made_of.rig {
        RigText::Line { line } => Rig::default_for(*line),
        RigText::Text(text) => {
            same(&text.text, &text.sha256, &text.name)?;
            let parsed = Rig::parse(&text.name, text.text.as_bytes()).map_err(RemakeError::Scene)?;
            tabled(parsed.value, &made_of.tables)?
        }
    };
    let options = Options::from(&made_of.options);
    let rate = options.rate.or(rig.device.rate).unwrap_or(48_000.0);
    let folder = recordings.folder(made_of).at_rate(recordings_rate(rate));
    let listed = |path: &str| made_of.files.iter().any(|file| file.path == path);
    if let Some((path, _)) = patch.recordings().find(|(path, _)| !listed(path)) {
        return Err(RemakeError::Journal(format!("there is no SHA-256 of `{path}`, which the patch plays")));
    }
    // Only recordings are needed again: what was in events files has become events.
    let mut elsewhere = BTreeMap::new();
    for file in made_of.files.iter().filter(|file| is_recording(&patch, &file.path)) {
        let found = folder.resolve(&file.path).and_then(|path| Ok((digest::of_file(&path)?, path)));
        let why = match found {
            Ok((now, _)) if now == file.sha256 => continue,
            Ok((now, path)) => {
                let what = format!(
                    "`{}` is not what was played: its SHA-256 is {now}, that of the session's was {}",
                    path.display(),
                    file.sha256
                );
                RemakeError::File(FileError::new(FileErrorKind::Malformed, what))
            }
            Err(error) if error.kind == FileErrorKind::Outside => return Err(missing(error, &folder)),
            Err(error) => missing(error, &folder),
        };
        elsewhere.insert(file.path.clone(), recordings.kept(&file.sha256).ok_or(why)?);
    }
    let folder = folder.with_others(elsewhere);
    scene(&patch, &rig, &options, &folder).map_err(RemakeError::Scene)
}

/// A rig with the tables of its calibrations that stood in files.
fn tabled(mut rig: Rig, tables: &[Text]) -> Result<Rig, RemakeError> {
    for calibration in &mut rig.calibrations {
        let Some(path) = &calibration.file else { continue };
        let table = tables.iter().find(|table| table.name == *path).ok_or_else(|| {
            RemakeError::Journal(format!("there is no text of `{path}`, which the rig names"))
        })?;
        same(&table.text, &table.sha256, &table.name)?;
        calibration.take(&table.text).map_err(|list| {
            let origin = Origin { file: table.name.as_str().into(), source: table.text.as_str().into() };
            RemakeError::Scene(origin.problems(list))
        })?;
    }
    Ok(rig)
}

fn is_recording(patch: &Patch, path: &str) -> bool {
    patch.recordings().any(|(recording, _)| recording == path)
}

/// A journal that somebody has edited tells of what was never played.
fn same(text: &str, sha256: &str, name: &str) -> Result<(), RemakeError> {
    if digest::of_bytes(text.as_bytes()) == sha256 {
        return Ok(());
    }
    Err(RemakeError::Journal(format!("the text of `{name}` does not have the SHA-256 beside it")))
}

/// Whoever plays a journal elsewhere has the recordings elsewhere.
fn missing(error: FileError, folder: &Folder) -> RemakeError {
    let help = match error.kind {
        FileErrorKind::Missing => {
            format!(
                "; if the patch's folder is not `{}` any more, name it: --folder DIR",
                folder.root().display()
            )
        }
        FileErrorKind::Outside => ": --allow-outside".into(),
        _ => String::new(),
    };
    RemakeError::File(FileError { message: error.message + &help, ..error })
}
