//! The ports of MIDI that a session hears.

use super::super::failure::Failure;
use super::super::screen::Post;
use pacinian::io::midi_in::MidiPorts;
use pacinian::live::signal::Handle;
use pacinian::patch::Patch;

/// Ports that are heard, or will be as soon as a patch has use for them: what nothing listens to is not opened.
pub struct Instruments {
    /// `--midi-in`.
    asked: Option<String>,
    session: Handle,
    post: Post,
    ports: Option<MidiPorts>,
}

impl Instruments {
    /// Of a session; `asked` as the person wrote it: a part of names, or `none`.
    pub fn new(asked: Option<String>, session: Handle, post: Post) -> Self {
        Self { asked, session, post, ports: None }
    }

    /// Opens them, unless they are open, where they were asked for or the patch has use for them.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn open_for(&mut self, patch: &Patch) -> Result<(), Failure> {
        let wanted = self.asked.clone().filter(|name| name != "none");
        let by_patch = self.asked.is_none() && (patch.hears_midi() || patch.follows_clock());
        if self.ports.is_some() || !(wanted.is_some() || by_patch) {
            return Ok(());
        }
        let post = self.post.clone();
        let ports = MidiPorts::listen(&self.session, wanted, Box::new(move |news| post.port(&news)));
        self.ports = Some(ports.map_err(|error| Failure::no_thread("MIDI", &error))?);
        Ok(())
    }
}
