//! What the nodes `input` of a patch hear, for people and for programs.

use super::loaded::Loaded;
use super::table::{hertz, many};
use pacinian::player::Player;
use serde::Serialize;

/// What a patch listens to, and what it hears.
#[derive(Debug, Serialize)]
pub struct InputReport {
    /// The file that is heard; null where there is none.
    file: Option<String>,
    file_channels: usize,
    file_rate: u32,
    seconds: f64,
    /// Of the filter that brings it down to the engine's rate.
    delay_ms: f64,
    /// Channels that are listened to, from 1.
    channels: Vec<usize>,
    /// Those of them that are silence.
    silent: Vec<usize>,
}

impl InputReport {
    /// Of a patch that listens to something; of others there is nothing to say.
    pub fn of(loaded: &Loaded, player: &Player) -> Option<Self> {
        let channels: Vec<usize> = player.plan().inputs().iter().map(|c| c + 1).collect();
        if channels.is_empty() {
            return None;
        }
        let input = loaded.input.as_deref();
        let silent = input.map_or(channels.clone(), |input| input.missing().map(|c| c + 1).collect());
        Some(Self {
            file: loaded.input_name.clone(),
            file_channels: input.map_or(0, |input| input.file_channels()),
            file_rate: input.map_or(0, |input| input.file_rate()),
            seconds: input.map_or(0.0, |input| input.seconds()),
            delay_ms: 1e3 * player.engine().input_delay(),
            channels,
            silent,
        })
    }

    /// In one line.
    pub fn text(&self) -> String {
        let Some(file) = &self.file else {
            return format!("{}: silence; --input FILE.wav gives it something", named(&self.channels));
        };
        let heard: Vec<usize> = self.channels.iter().copied().filter(|c| !self.silent.contains(c)).collect();
        let mut parts = Vec::new();
        if !heard.is_empty() {
            parts.push(format!("{} of {file}", named(&heard)));
        }
        if !self.silent.is_empty() {
            parts.push(format!("{}: silence", named(&self.silent)));
        }
        let form = format!(
            "{}, {}, {:.3} s",
            many(self.file_channels, "channel"),
            hertz(f64::from(self.file_rate)),
            self.seconds
        );
        format!("{} ({form}), {:.2} ms late", parts.join("; "), self.delay_ms)
    }
}

/// "channel 1", "channels 1, 2".
pub fn named(channels: &[usize]) -> String {
    let list: Vec<String> = channels.iter().map(usize::to_string).collect();
    format!("channel{} {}", if channels.len() == 1 { "" } else { "s" }, list.join(", "))
}
