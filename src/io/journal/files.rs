//! The recordings that a session plays, by their digests, in a folder beside its journal: where one is saved anew meanwhile, its path leads to the
//! new one alone, and a replay needs both. When the session ends, what is still where it was is of no use there and gone again.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::digest::{Digest, of_file};
use crate::io::assets::Folder;
use crate::io::error::{FileError, FileErrorKind};
use crate::io::open;
use crate::live::provenance::Provenance;
use crate::patch::Patch;

/// Digits of a SHA-256 in hexadecimal.
const DIGITS: usize = 64;

/// Where recordings are kept that a session plays. Clones keep into the same folder.
#[derive(Debug, Clone)]
pub struct Files(Arc<Keeping>);

#[derive(Debug)]
struct Keeping {
    folder: PathBuf,
    played: Mutex<Played>,
    ended: AtomicBool,
}

#[derive(Debug, Default)]
struct Played {
    /// Where each lies, and its digest.
    all: Vec<(PathBuf, String)>,
    /// The first that could not be kept.
    trouble: Option<FileError>,
}

/// The folder of a journal: `s.csv.files` for `s.csv`.
pub fn beside(journal: &Path) -> PathBuf {
    let mut name = journal.as_os_str().to_owned();
    name.push(".files");
    name.into()
}

/// Where a folder has the recording of a digest; nowhere, where that is none.
pub fn copy_in(folder: &Path, sha256: &str) -> Option<PathBuf> {
    let is_digit = |c: u8| matches!(c, b'0'..=b'9' | b'a'..=b'f');
    let is_digest = sha256.len() == DIGITS && sha256.bytes().all(is_digit);
    is_digest.then(|| folder.join(format!("{sha256}.wav")))
}

/// Forgets what an earlier journal of that name has kept, and nothing else.
///
/// # Errors
/// What cannot be removed.
pub fn clear(journal: &Path) -> Result<(), FileError> {
    let folder = beside(journal);
    let Ok(entries) = fs::read_dir(&folder) else { return Ok(()) };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let digest = path.file_stem().and_then(|stem| copy_in(&folder, &stem.to_string_lossy()));
        if digest.as_ref() == Some(&path) {
            fs::remove_file(&path).map_err(|error| FileError::creating(&path, &error))?;
        }
    }
    // Whatever else lies there stays.
    let _ = fs::remove_dir(&folder);
    Ok(())
}

impl Files {
    /// For the journal at a path. The folder is made when there is something to keep.
    pub fn beside(journal: &Path) -> Self {
        let (folder, played) = (beside(journal), Mutex::default());
        Self(Arc::new(Keeping { folder, played, ended: AtomicBool::new(false) }))
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.0.folder
    }

    /// Keeps the recordings of a patch that is about to play, with its files in `folder`. What cannot be written is told by [`Files::finish`].
    ///
    /// # Errors
    /// A recording that is not what was read any more.
    pub fn keep(&self, folder: &Folder, patch: &Patch, made_of: &Provenance) -> Result<(), FileError> {
        let is_recording = |path: &str| patch.recordings().any(|(recording, _)| recording == path);
        for file in made_of.files.iter().filter(|file| is_recording(&file.path)) {
            let played = (folder.root().join(&file.path), file.sha256.clone());
            if self.get().all.contains(&played) {
                continue;
            }
            match self.copy(&folder.resolve(&file.path)?, &file.sha256) {
                Ok(true) => self.get().all.push(played),
                Ok(false) => {
                    let what = format!(
                        "`{}` was written anew while it was read: a replay needs it as it was",
                        played.0.display()
                    );
                    return Err(FileError::new(FileErrorKind::Io, what));
                }
                Err(error) => self.fail(error),
            }
        }
        Ok(())
    }

    /// A recording could not be kept.
    pub fn fail(&self, error: FileError) {
        self.get().trouble.get_or_insert(error);
    }

    /// Whether something could not be kept; [`Files::finish`] says what.
    pub fn has_failed(&self) -> bool {
        self.get().trouble.is_some()
    }

    /// The session has ended. Gives how many recordings a replay needs of the folder: those of a path that has had another one as well, or has now.
    ///
    /// # Errors
    /// The first that could not be kept.
    pub fn finish(&self) -> Result<usize, FileError> {
        self.0.ended.store(true, Ordering::Release);
        let Played { all, trouble } = std::mem::take(&mut *self.get());
        let mut digests: Vec<&String> = all.iter().map(|(_, sha256)| sha256).collect();
        digests.sort_unstable();
        digests.dedup();
        let replaced = |(path, sha256): &(PathBuf, String)| {
            all.iter().any(|(other, another)| other == path && another != sha256)
                || of_file(path).ok().as_ref() != Some(sha256)
        };
        let count = digests.len();
        digests.retain(|sha256| all.iter().filter(|(_, of)| of == *sha256).all(|played| !replaced(played)));
        let useless = digests.iter().filter_map(|sha256| copy_in(&self.0.folder, sha256));
        // What cannot be removed is no harm.
        useless.for_each(|path| drop(fs::remove_file(path)));
        // It stays where there is something in it.
        let _ = fs::remove_dir(&self.0.folder);
        trouble.map_or(Ok(count - digests.len()), Err)
    }

    fn get(&self) -> MutexGuard<'_, Played> {
        // Nobody leaves it half-done.
        self.0.played.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Copies a file; says whether it has that digest. Whoever breaks off leaves no half of it under that name.
    fn copy(&self, from: &Path, sha256: &str) -> Result<bool, FileError> {
        let Keeping { folder, ended, .. } = &*self.0;
        let Some(to) = copy_in(folder, sha256) else { return Ok(false) };
        if of_file(&to).is_ok_and(|there| there == sha256) {
            return Ok(true);
        }
        fs::create_dir_all(folder).map_err(|error| FileError::writing(folder, &error))?;
        let part = to.with_extension("part");
        let failed = |error: std::io::Error| FileError::writing(&to, &error);
        let copied = || -> Result<bool, FileError> {
            let mut source = open::open(from)?;
            let mut file = File::create(&part).map_err(failed)?;
            let (mut digest, mut bytes) = (Digest::new(), vec![0; 1 << 16]);
            while !ended.load(Ordering::Acquire) {
                let count = source.read(&mut bytes).map_err(|error| FileError::reading(from, &error))?;
                let read = bytes.get(..count).unwrap_or_default();
                if read.is_empty() {
                    let same = digest.finish() == sha256;
                    return match same {
                        true => fs::rename(&part, &to).map_err(failed).map(|()| true),
                        false => Ok(false),
                    };
                }
                digest.bytes(read);
                file.write_all(read).map_err(failed)?;
            }
            Ok(false)
        }();
        if !matches!(copied, Ok(true)) {
            let _ = fs::remove_file(&part);
        }
        copied
    }
}

#[cfg(test)]
mod tests {
    use super::{Files, clear, copy_in};
    use crate::graph::scene::Options;
    use crate::io::assets::Folder;
    use crate::io::journal::of_bytes;
    use crate::live::provenance::{FileDigest, Provenance, RigText, Text};
    use crate::patch::Patch;
    use std::fs;
    use std::path::Path;

    const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n[voice.v.nodes]\n\
        a = { type = \"sample\", file = \"a.wav\" }\nb = { type = \"sample\", file = \"b.wav\" }\n\
        o = { type = \"add\", inputs = [\"a\", \"b\"] }\n";

    fn made_of(files: [&str; 2]) -> Provenance {
        let digest = |(path, bytes): (&str, &str)| FileDigest {
            path: path.into(),
            sha256: of_bytes(bytes.as_bytes()),
        };
        Provenance {
            patch: Text { name: "p".into(), sha256: String::new(), text: PATCH.into() },
            rig: RigText::Line { line: 1 },
            tables: Vec::new(),
            folder: String::new(),
            allow_outside: false,
            files: ["a.wav", "b.wav"].into_iter().zip(files).map(digest).collect(),
            song: None,
            set: Vec::new(),
            notes: None,
            options: (&Options::default()).into(),
        }
    }

    #[test]
    fn what_was_replaced_stays_and_nothing_else() {
        let root = std::env::temp_dir().join(format!("pacinian-files-{}", std::process::id()));
        fs::create_dir_all(&root).unwrap();
        let journal = root.join("j.csv");
        let (folder, patch) = (Folder::new(&root), Patch::parse("p", PATCH.as_bytes()).unwrap().value);
        let write = |name: &str, what: &str| fs::write(root.join(name), what).unwrap();
        let kept =
            |what: &str| fs::read(copy_in(&root.join("j.csv.files"), &of_bytes(what.as_bytes())).unwrap());
        write("a.wav", "one");
        write("b.wav", "two");
        let files = Files::beside(&journal);
        let keep = |files: &Files, of: [&str; 2]| files.keep(&folder, &patch, &made_of(of));
        keep(&files, ["one", "two"]).unwrap();
        write("a.wav", "three");
        // What is read is not what was read before.
        let changed = keep(&files, ["four", "two"]).unwrap_err();
        assert!(changed.message.contains("a.wav` was written anew"), "{changed}");
        keep(&files, ["three", "two"]).unwrap();
        assert_eq!((files.finish(), files.has_failed()), (Ok(2), false));
        assert_eq!((kept("one").unwrap(), kept("three").unwrap()), (b"one".to_vec(), b"three".to_vec()));
        assert!(kept("two").is_err() && kept("four").is_err());
        // One that somebody has changed, but that never took over.
        let files = Files::beside(&journal);
        keep(&files, ["three", "two"]).unwrap();
        write("b.wav", "five");
        assert_eq!(files.finish(), Ok(1));
        assert_eq!(kept("two").unwrap(), b"two");
        // What an earlier session has kept goes, and nothing else.
        write("j.csv.files/notes.txt", "mine");
        clear(&journal).unwrap();
        assert_eq!(fs::read_dir(root.join("j.csv.files")).unwrap().count(), 1);
        fs::remove_file(root.join("j.csv.files/notes.txt")).unwrap();
        clear(&journal).unwrap();
        assert!(!root.join("j.csv.files").exists());
        // Where nothing was replaced, there is no folder.
        let files = Files::beside(&journal);
        keep(&files, ["three", "five"]).unwrap();
        assert!(root.join("j.csv.files").exists());
        assert_eq!(files.finish(), Ok(0));
        assert!(!root.join("j.csv.files").exists());
        // What cannot be written is told, and the session goes on.
        write("j.csv.files", "no folder");
        let files = Files::beside(&journal);
        keep(&files, ["three", "five"]).unwrap();
        assert!(files.has_failed());
        assert_eq!(files.finish().unwrap_err().exit_code(), 74);
        fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn no_digest_leads_out_of_the_folder() {
        let digest = of_bytes(b"");
        assert_eq!(copy_in(Path::new("f"), &digest), Some(Path::new("f").join(format!("{digest}.wav"))));
        let up = format!("../{}", &digest[3..]);
        for wrong in ["", "../x", &digest[1..], &digest.to_uppercase(), &up, &format!("{digest}0")] {
            assert_eq!(copy_in(Path::new("f"), wrong), None, "{wrong}");
        }
    }
}
