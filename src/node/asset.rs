//! A recording in memory, as the nodes that play it see it. Files are opened elsewhere; see [`Assets`].

use std::sync::Arc;

/// One channel of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Asset {
    /// Samples, full scale ±1.
    pub samples: Vec<f32>,
    /// Samples a second.
    pub rate: f64,
}

/// Where the graph compiler asks for recordings, so that it never opens a file.
pub trait Assets {
    /// The channel (from 1) of the recording at `path`, as written in the patch.
    ///
    /// # Errors
    /// Says in one sentence what is wrong with the file and what to do.
    fn load(&self, path: &str, channel: usize) -> Result<Arc<Asset>, String>;
}

/// No recordings at all.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoAssets;

impl Assets for NoAssets {
    fn load(&self, path: &str, _channel: usize) -> Result<Arc<Asset>, String> {
        Err(format!("no recordings can be read here, so `{path}` has nothing to play"))
    }
}
