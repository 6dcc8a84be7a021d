//! Playing in stretches short enough for the engine's queue to hold what they play: the one way in which events reach an engine,
//! be they those of a score or of a recorded take.

use crate::engine::Engine;

/// Whoever has an engine and events for it.
pub(crate) trait Feeds {
    /// The engine.
    fn engine(&mut self) -> &mut Engine;

    /// Engine samples that may be computed before it is fed anew.
    fn most(&self) -> usize {
        MOST
    }

    /// Gives the engine all events before engine sample `until`, as long as it has room. Where it has not, the sample with which
    /// the first event takes effect that did not find any.
    fn feed(&mut self, until: u64) -> Option<u64>;
}

/// Engine samples that are fed at once, at most.
const MOST: usize = 256;

/// Fills `output`, interleaved frames at `ratio` times the engine's rate, with what came in during the same frames.
pub(crate) fn play(feeds: &mut impl Feeds, ratio: usize, input: &[f32], output: &mut [f32]) {
    let most = feeds.most().min(MOST);
    let (channels, ears) = (feeds.engine().channels().max(1), feeds.engine().input_channels());
    let (mut input, mut output) = (input, output);
    while !output.is_empty() {
        let wanted = output.len().div_ceil(channels).min(ratio * most);
        let samples = wanted / ratio + 2;
        let until = feeds.engine().clock() + samples as u64;
        let full = feeds.feed(until);
        let engine = feeds.engine();
        let mut frames = full.map_or(wanted, |sample| engine.frames_before(sample).min(wanted));
        if frames == 0 {
            let room = engine.room();
            engine.run_ahead();
            if engine.room() > room {
                continue;
            }
            // Unreachable as long as whoever feeds leaves room: better late than never.
            frames = wanted;
        }
        let (now, later) = output.split_at_mut((frames * channels).min(output.len()));
        let (heard, unheard) = input.split_at((frames * ears).min(input.len()));
        engine.process_input(heard, now);
        (input, output) = (unheard, later);
    }
}
