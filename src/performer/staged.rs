//! For tests: performers of a patch in a line or two.

use std::sync::Arc;

use super::{OpenEvents, Outlet, Performer};
use crate::engine::event::{Event, Source};
use crate::graph::scene::{Options, Scene, scene};
use crate::node::asset::NoAssets;
use crate::patch::Patch;
use crate::rig::Rig;
use crate::schedule::Instant;
use crate::text::Problem;

/// What stands before a voice `v`.
pub const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n";

/// A voice `v` that is a sine.
pub const VOICE: &str =
    "[voice.v]\noutput = \"o\"\n[voice.v.nodes]\no = { type = \"sine\", frequency = 100 }\n";

/// Keeps what it is sent.
#[derive(Default)]
pub struct Kept(pub Vec<(Instant, Event)>);

impl Outlet for Kept {
    fn clock(&self) -> u64 {
        1
    }
    fn room(&self, _: Source) -> usize {
        1000
    }
    fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
        self.0.push((at, event));
        true
    }
}

/// Plays a patch on a rig of so many channels, as a live one that waits for nothing.
pub fn performer(text: &str, channels: u32) -> Performer {
    let (scene, patch, rig) = compiled(text, channels);
    Performer::new(scene, patch, rig, no_files()).unwrap_or_else(|p| panic!("{p}"))
}

/// Another text of the patch is saved while it plays.
pub fn save(performer: &mut Performer, text: &str, channels: u32) {
    let (scene, patch, rig) = compiled(text, channels);
    performer.become_of(scene, patch, rig, no_files()).unwrap_or_else(|p| panic!("{p}"));
}

fn compiled(text: &str, channels: u32) -> (Scene, Arc<Patch>, Arc<Rig>) {
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::default_for(channels);
    let options = Options { live: true, ..Options::default() };
    let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    (scene, Arc::new(patch), Arc::new(rig))
}

fn no_files() -> OpenEvents {
    Box::new(|_| Err(Problem::of_file("no files here")))
}
