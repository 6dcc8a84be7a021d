//! Files that a patch names: which they are, and what became of them.

use pacinian::io::assets::Folder;
use pacinian::node::asset::{Asset, Assets};
use pacinian::patch::{Argument, Events, Patch, Value};
use pacinian::text::{Problem, Span};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Exit codes of files that cannot be read, by where the patch names them.
pub type Codes = HashMap<(usize, usize), u8>;

/// Recordings of a folder, and what became of them.
pub struct Watched<'a> {
    folder: &'a Folder,
    seen: Mutex<Seen>,
}

/// What became of them.
#[derive(Debug, Default)]
pub struct Seen {
    /// Those that were read.
    pub paths: Vec<PathBuf>,
    /// Exit codes by the path that the patch names.
    pub failures: HashMap<String, u8>,
}

impl<'a> Watched<'a> {
    /// Of a folder from which nothing was read.
    pub fn new(folder: &'a Folder) -> Self {
        Self { folder, seen: Mutex::default() }
    }

    /// What became of them.
    pub fn finish(self) -> Seen {
        self.seen.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Seen {
    /// Exit codes by where the patch names what failed.
    pub fn codes(&self, patch: &Patch) -> Codes {
        let code = |(path, span): (&str, &Span)| Some(((span.start, span.end), *self.failures.get(path)?));
        named(patch).filter_map(code).collect()
    }
}

impl Assets for Watched<'_> {
    fn load(&self, path: &str, channel: usize) -> Result<Arc<Asset>, String> {
        let result = self.folder.recording(path, channel);
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        match &result {
            Ok(_) => seen.paths.extend(self.folder.resolve(path)),
            Err(error) => drop(seen.failures.insert(path.into(), error.exit_code())),
        }
        result.map_err(|error| error.message)
    }
}

/// What is wrong with the files that a patch names, where nothing is compiled that would find out.
pub fn unreadable(patch: &Patch, folder: &Folder) -> Vec<Problem> {
    let mut problems = Vec::new();
    let nodes = patch.voices.iter().flat_map(|voice| &voice.nodes).chain(&patch.shared);
    for node in nodes {
        let constant = |argument: &Argument| match argument.value {
            Value::Constant(x) => Some(x as usize),
            _ => None,
        };
        let channel = node.arguments.iter().find_map(constant).unwrap_or(1);
        for argument in &node.arguments {
            let Value::File(path) = &argument.value else { continue };
            let trouble = folder.recording(path, channel).err();
            problems.extend(trouble.map(|error| Problem::error(&argument.span, error.message)));
        }
    }
    for pattern in &patch.patterns {
        // What is empty was refused for where it leads.
        if let Events::File(path, span) = &pattern.events
            && !path.is_empty()
        {
            let trouble = folder.resolve(path).err();
            problems.extend(trouble.map(|error| Problem::error(span, error.message)));
        }
    }
    problems
}

/// Every file that a patch names, be it ever played or not, and where it names it.
pub fn named(patch: &Patch) -> impl Iterator<Item = (&str, &Span)> {
    patch.recordings().chain(patch.events_files())
}
