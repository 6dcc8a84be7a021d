//! What a journal says that a scene was made of.

use super::loaded::Loaded;
use super::named::named;
use pacinian::graph::scene::Options;
use pacinian::io::error::FileError;
use pacinian::io::journal::{of_bytes, of_file};
use pacinian::live::provenance::{FileDigest, Provenance, RigText, Text};

/// All of it. Recordings are read again for their digests.
///
/// # Errors
/// A file that cannot be read any more.
pub fn provenance(loaded: &Loaded, options: &Options) -> Result<Provenance, FileError> {
    let text = |name: &str, text: &str| Text {
        name: name.into(),
        sha256: of_bytes(text.as_bytes()),
        text: text.into(),
    };
    let folder = &*loaded.folder;
    let mut files: Vec<FileDigest> = Vec::new();
    for (path, _) in named(&loaded.patch) {
        if files.iter().all(|known| known.path != path) {
            let sha256 = match folder.digest(path) {
                Some(read) => read,
                None => of_file(&folder.resolve(path)?)?,
            };
            files.push(FileDigest { path: path.into(), sha256 });
        }
    }
    let source = &loaded.source;
    // It is played again from wherever somebody is then.
    let root = std::path::absolute(folder.root()).unwrap_or_else(|_| folder.root().to_path_buf());
    Ok(Provenance {
        patch: text(&source.file, &source.source),
        rig: match &loaded.rig_source {
            Some(rig) => RigText::Text(text(&rig.file, &rig.source)),
            None => RigText::Line { line: loaded.rig.device.channels },
        },
        tables: loaded.tables.iter().map(|table| text(&table.path, &table.text)).collect(),
        folder: root.display().to_string(),
        allow_outside: folder.allows_outside(),
        files,
        song: loaded
            .song_digest
            .clone()
            .zip(loaded.song_name.clone())
            .map(|(sha256, path)| FileDigest { path, sha256 }),
        set: loaded.settings.iter().map(|s| (s.control.clone(), s.value)).collect(),
        notes: loaded.notes.clone(),
        options: options.into(),
    })
}
