//! What a session hears: a file or a sound card.

use super::failure::Failure;
use super::input::named;
use super::loaded::Loaded;
use super::patience;
use super::stop::Stop;
use super::table::many;
use super::terminal::Terminal;
use pacinian::io::device::capture;
use pacinian::io::device::choose;
use pacinian::io::device::keeper::Fate;
use pacinian::io::device::list::Found;
use pacinian::io::input::Input;
use pacinian::io::session::Ear;
use pacinian::text::problem::escaped;
use std::path::Path;
use std::sync::Arc;

/// What a session hears, and what is told of it.
#[derive(Default)]
pub struct Listens {
    file: Option<Arc<Input>>,
    device: Option<(cpal::Device, Found)>,
    /// For people.
    pub note: Option<String>,
    /// What is listened to, by its name.
    pub heard: Option<String>,
}

impl Listens {
    /// To what a patch that listens to `channels` (from 0) at `rate` hears: the file, the device that was named, or the rig's.
    ///
    /// # Errors
    /// A device that is not there or has no inputs; a file that cannot be brought to the rate.
    pub fn of(
        loaded: &Loaded,
        (path, device): (Option<&Path>, Option<&str>),
        channels: &[usize],
        (rate, block): (u32, Option<u32>),
        stop: &Stop,
        terminal: &Terminal,
    ) -> Result<Self, Failure> {
        if let (Some(input), Some(path)) = (&loaded.input, path) {
            // Nobody knew the device's rate when it was read.
            let file = match loaded.options.rate == Some(f64::from(rate)) {
                true => Arc::clone(input),
                false => {
                    let file = Input::open(path, f64::from(rate), channels)?;
                    Arc::new(file.marking(input.marked()))
                }
            };
            let name = loaded.input_name.as_deref().unwrap_or("a file");
            let note = (!channels.is_empty()).then(|| {
                format!("it hears {name} from the beginning on, {:.1} s; then silence", file.seconds())
            });
            let heard = note.is_some().then(|| name.to_string());
            return Ok(Self { file: Some(file), note, heard, ..Self::default() });
        }
        let Some(name) = device.or(loaded.rig.device.input.as_deref()) else { return Ok(Self::default()) };
        if channels.is_empty() {
            // A rig may be for many patches.
            let note = device.map(|_| "nothing in this patch listens, so no input is opened".to_string());
            return Ok(Self { note, ..Self::default() });
        }
        let name = name.to_string();
        let (device, found) = patience::look(Some(stop), terminal, move || choose::heard(&name))??;
        let most = channels.last().map_or(0, |last| last + 1);
        let shape = capture::shape(&found, most, rate, block)?;
        let of = many(shape.channels, "channel");
        let mut note = format!(
            "it listens to {}: {} of {of} at {} Hz",
            escaped(&found.name),
            named(&channels.iter().map(|c| c + 1).collect::<Vec<_>>()),
            shape.rate
        );
        let missing: Vec<usize> = channels.iter().map(|c| c + 1).filter(|c| *c > shape.channels).collect();
        if !missing.is_empty() {
            note += &format!("; {} is not there and stays silent", named(&missing));
        }
        let heard = Some(found.name.clone());
        Ok(Self { device: Some((device, found)), note: Some(note), file: None, heard })
    }

    /// For a session; `fate` hears what becomes of a device.
    pub fn ear(self, fate: Box<dyn FnMut(Fate) + Send>) -> Ear {
        match (self.file, self.device) {
            (Some(file), _) => Ear::File(file),
            (None, Some(device)) => Ear::Device { device, fate },
            (None, None) => Ear::Nothing,
        }
    }
}
