//! What is said of a session that begins.

use super::super::loaded::Loaded;
use super::super::terminal::Terminal;
use pacinian::io::device::choose::Chosen;
use pacinian::rig::OutputKind;
use pacinian::text::problem::escaped;

/// What is done where a rig leaves open what its card lets through.
const UNSAID: &str = "the rig does not say whether the card lets steady voltages through, so none leaves but on outputs declared for \
                      them: say `coupling` in [device]\n";

/// What a device is called for people.
pub fn called(device: &Chosen) -> String {
    match device {
        Chosen::Card(_, found) => found.name.clone(),
        Chosen::Virtual(None) => "a virtual card".into(),
        Chosen::Virtual(Some(why)) => format!("a virtual card, since {why}"),
    }
}

/// A session that has begun.
pub struct Opening<'a> {
    pub loaded: &'a Loaded,
    /// Of the device, as [`called`].
    pub name: &'a str,
    pub channels: usize,
    /// Frames a second, of the device and of the engine.
    pub rate: u32,
    pub engine_rate: f64,
    /// Whether it is at full level.
    pub armed: bool,
}

impl Opening<'_> {
    /// Says what plays where, and how loud.
    pub fn tell(&self, terminal: &Terminal) {
        let Self { loaded, channels, rate, engine_rate, .. } = self;
        let pulses = loaded.rig.outputs.iter().any(|o| matches!(o.kind, OutputKind::Trigger { .. }));
        let level = match (self.armed, pulses) {
            (true, _) => "",
            (false, false) => ", at -20 dB: --arm for full level",
            (false, true) => ", at -20 dB, pulses on trigger outputs as well: --arm for full level",
        };
        let (patch, device) = (escaped(loaded.name()), escaped(self.name));
        terminal.note(&format!(
            "{patch} plays on {device}: {channels} channels at {rate} Hz, engine at {engine_rate} Hz{level}\n"
        ));
        if loaded.rig_source.is_some() && loaded.rig.device.coupling.is_none() {
            terminal.note(UNSAID);
        }
    }
}
