//! What a comparison with the reference takes of memory, before it takes it.

use super::failure::Failure;
use super::table::many;
use pacinian::engine::event::Play;
use pacinian::graph::plan::Plan;
use pacinian::report::measure::{OVER, TAIL};

/// Bytes that a comparison may take, at most.
const MOST: f64 = 2e9;

/// Bytes of a comparison, by seconds and events.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    channels: usize,
    second: f64,
    event: f64,
}

impl Memory {
    /// Of a plan, with an audio input or without, for so many settings.
    pub fn new(plan: &Plan, hears: bool, settings: usize) -> Self {
        let (device, engine) = (plan.device_rate, plan.engine_rate());
        let (channels, inputs) = (plan.channels as f64, plan.inputs().len() as f64);
        // Numbers of 8 bytes. An input's filter has as many taps as the output's, so each number of taps has a reference.
        let references = 8.0 * engine * channels * if hears { settings as f64 } else { 1.0 };
        let heard = if hears { inputs * device * 4.0 } else { 0.0 };
        // A voice at the reference's rate, with the room that it grows by; what all voices share; an input's spectra.
        let signals = 3.0 + plan.shared.len() as f64 + if hears { 5.0 * inputs } else { 0.0 };
        let reference = 8.0 * engine * OVER as f64 * signals;
        // All that is played, its copy of the input, and one channel with its spectrum and what the transform needs for itself.
        let comparison = device * (4.0 * channels + 48.0) + heard;
        Self {
            channels: plan.channels,
            second: references + heard + reference.max(comparison),
            // A list has up to twice the room that it needs.
            event: 2.0 * size_of::<(f64, Play)>() as f64,
        }
    }

    /// Refuses what takes too much.
    ///
    /// # Errors
    /// Says how long it might be.
    pub fn check(&self, seconds: f64, events: usize) -> Result<(), Failure> {
        let of_events = self.event * events as f64;
        if of_events + self.second * (seconds + TAIL) <= MOST {
            return Ok(());
        }
        let all = match events {
            0 => String::new(),
            _ => format!(" with {}", many(events, "event")),
        };
        let channels = many(self.channels, "channel");
        let what = format!(
            "comparing {seconds:.0} s of {channels}{all} with the reference takes more than {:.0} GB of memory",
            MOST / 1e9
        );
        // As dense as it is up to here.
        let density = of_events / seconds.max(1e-9);
        let fits = (MOST / (self.second + density) - TAIL).max(0.1);
        let fits = if fits > 10.0 { fits.floor() } else { (10.0 * fits).floor() / 10.0 };
        Err(Failure::usage(what, format!("measure a part of it: --duration {fits}")))
    }
}

#[cfg(test)]
mod tests {
    use super::Memory;

    #[test]
    fn what_is_advised_fits_and_more_does_not() {
        for (second, event, events_a_second) in [(1e6, 208.0, 0.0), (5e6, 208.0, 1e5), (3e8, 208.0, 0.0)] {
            let memory = Memory { channels: 8, second, event };
            let check = |seconds: f64| memory.check(seconds, (seconds * events_a_second) as usize);
            let refused = check(1e4).unwrap_err().problems();
            let help = refused[0].list[0].help.clone().unwrap();
            let advised: f64 = help.rsplit(' ').next().unwrap().parse().unwrap();
            assert!(check(advised).is_ok(), "{advised}");
            assert!(check(1.02 * advised + 0.2).is_err(), "{advised}");
        }
    }
}
