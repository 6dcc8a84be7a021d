//! The audio input as a reference hears it.
//!
//! A node `input` is defined as what is left of the input by the filter that brings it down to the engine's rate. So that filter,
//! in `f64`, is where a reference begins too, and between its samples lies the one signal without anything above half that rate.

use realfft::RealFftPlanner;

use crate::dsp::interpolator::Interpolator;
use crate::graph::plan::Plan;
use crate::node::kernel::LEAD;

/// Engine samples of silence between end and beginning, which a transform takes for neighbours.
const GAP: usize = 4096;

/// What each input channel brings at `over` times the engine's rate for `length` engine samples; `input` holds the channels at the
/// device's rate, from their beginning. Voices lag behind the engine's clock, so they hear that much ahead of their own time.
pub(super) fn hearing(plan: &Plan, input: &[Vec<f32>], length: usize, over: usize) -> Vec<Vec<f64>> {
    let filter = Interpolator::design(plan.taps, plan.ratio, plan.engine_rate());
    let sum: f64 = filter.response.iter().sum();
    let lead = LEAD as usize;
    let channel = |samples: &Vec<f32>| {
        let at = |frame: usize, back: usize| {
            frame.checked_sub(back).and_then(|f| samples.get(f)).map_or(0.0, |x| f64::from(*x))
        };
        let low = (0..length + lead).map(|n| {
            let taps = filter.response.iter().enumerate();
            taps.map(|(k, tap)| tap / sum * at(n * plan.ratio, k)).sum()
        });
        finer(low.collect(), over).split_off(lead * over)
    };
    input.iter().map(channel).collect()
}

/// The signal at `over` times its rate: its spectrum with nothing above it.
fn finer(low: Vec<f64>, over: usize) -> Vec<f64> {
    let wanted = low.len() * over;
    let size = (low.len() + GAP).next_multiple_of(GAP);
    let mut low = low;
    low.resize(size, 0.0);
    let mut planner = RealFftPlanner::<f64>::new();
    let (down, up) = (planner.plan_fft_forward(size), planner.plan_fft_inverse(size * over));
    let (mut few, mut many, mut high) = (down.make_output_vec(), up.make_input_vec(), up.make_output_vec());
    // The lengths are the plans' own, and the first and last bins are real, so neither can fail.
    if down.process(&mut low, &mut few).is_err() {
        return vec![0.0; wanted];
    }
    for (to, from) in many.iter_mut().zip(&few) {
        *to = *from / size as f64;
    }
    if over > 1
        && let Some(last) = many.get_mut(few.len() - 1)
    {
        *last /= 2.0;
    }
    if up.process(&mut many, &mut high).is_err() {
        return vec![0.0; wanted];
    }
    high.truncate(wanted);
    high
}

#[cfg(test)]
mod tests {
    use super::finer;

    #[test]
    fn between_the_samples_lies_the_tone_that_they_were_taken_from() {
        let tone = |t: f64| {
            // Fades in and out, so that there is nothing but the tone.
            let swell = (std::f64::consts::PI * t / 2000.0).sin().powi(4);
            swell * (0.7 * t).sin()
        };
        let high = finer((0..2000).map(|n| tone(f64::from(n))).collect(), 16);
        assert_eq!(high.len(), 32_000);
        for (n, x) in high.iter().enumerate().step_by(7) {
            assert!((x - tone(n as f64 / 16.0)).abs() < 1e-6, "{n}: {x}");
        }
    }
}
