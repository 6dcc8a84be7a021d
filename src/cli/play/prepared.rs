//! What is to be played, on what: all that is known before anything is opened.

use super::super::choose;
use super::super::failure::Failure;
use super::super::load::Scene;
use super::super::loaded::Loaded;
use super::super::problems;
use super::super::terminal::Terminal;
use super::{FOREVER, Play};
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::{Chosen, Wish};
use pacinian::live::reload::Reload;
use std::sync::Arc;

/// A patch, compiled for a device.
pub struct Prepared {
    /// What is read again when it is saved.
    pub scene: Scene,
    pub loaded: Loaded,
    /// What was wished for, and what there is.
    pub wish: Wish,
    pub device: Chosen,
    /// Frames a second, and whether it has its full level.
    pub rate: u32,
    pub armed: bool,
    pub reload: Reload,
}

impl Prepared {
    /// As the command line has it.
    ///
    /// # Errors
    /// A patch or a rig that cannot be played; a device that is not there, or has other channels than are needed.
    pub fn of(play: &Play, terminal: &Terminal) -> Result<Self, Failure> {
        let mut scene = Scene {
            live: true,
            hears: play.input_device.is_some(),
            simulated: play.simulated,
            journalled: play.keep.events.is_some(),
            block: play.block,
            ..play.scene.clone()
        };
        // Where no rig says which tactors there are, the device does.
        let mut device = None;
        if scene.rig.is_none() {
            let chosen = choose::choose(&Wish::of(play.device.as_deref(), None), None, terminal)?;
            scene.offered = chosen.fitting().to_vec();
            device = Some(chosen);
        }
        // However long it plays, all of an input may be heard.
        let mut loaded = scene.load(true, Some(play.duration.unwrap_or(FOREVER)))?;
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        let (said, file) = (loaded.rig.device.name.as_deref(), loaded.rig_source.as_ref());
        let file = file.map_or("the rig".into(), |source| Arc::clone(&source.file));
        let (wish, device) = match device {
            Some(device) => (Wish::of(play.device.as_deref(), said), device),
            None => choose::choose_for(play.device.as_deref(), said, file, None, terminal)?,
        };
        let rate = device.rate(play.scene.rate.or(loaded.rig.device.rate.map(|rate| rate as u32)));
        let armed = play.arm || device.is_meant(&wish);
        let block = play.block.or_else(|| device.usual_block());
        scene.block = block;
        // The virtual one as well: what is tried on it is what a card would get.
        scene.on_card = true;
        let rate_of_device = Some(f64::from(rate));
        let options =
            Options { rate: rate_of_device, live: true, block, on_card: true, ..loaded.options.clone() };
        let reload = loaded.reload(&options, play.keep.events.is_some())?;
        play.keep.check(&loaded, !reload.scene.plan.inputs().is_empty(), play.watch)?;
        if scene.rig.is_none() {
            choose::fits(&device, reload.scene.plan.channels)?;
        }
        Ok(Self { scene, loaded, wish, device, rate, armed, reload })
    }
}
