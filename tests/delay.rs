//! The delay that the engine reports is the delay it has, measured on its output.

mod common;

use common::{channel, compiled, moments, play, rendered};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const RATES: [f64; 5] = [44_100.0, 48_000.0, 88_200.0, 96_000.0, 192_000.0];

/// Half the length of the swell, seconds: its spectrum, sinc² of it, is exactly 0 at twice 250 Hz.
const HALF: f64 = 0.1;

/// A swell of 250 Hz that begins at engine sample `at`.
fn swell(rate: f64, taps: usize, at: f64) -> (pacinian::engine::Delay, Vec<f64>, f64) {
    let text = format!(
        "[voice.v]\noutput = \"o\"\n[voice.v.nodes]\nt = {{ type = \"sine\", frequency = 250 }}\n\
         e = {{ type = \"burst\", attack = {HALF}, decay = {HALF} }}\n\
         o = {{ type = \"multiply\", inputs = [\"t\", \"e\", 0.5] }}"
    );
    let mut plan = compiled(&text, 1, rate).plan;
    plan.taps = taps;
    let seconds = at / plan.engine_rate();
    let (engine, frames) = rendered(&plan, &[(seconds, play(0, 0, 250.0, 2.0 * HALF, 1))], 0.0);
    (engine.delay(), channel(&frames, 1, 0), seconds)
}

#[test]
fn envelope_and_phase_of_250_hz_come_when_the_engine_says() {
    for rate in RATES {
        for (taps, at) in [(6, 100.0), (6, 100.37), (4, 77.5), (12, 231.123)] {
            let (delay, signal, begin) = swell(rate, taps, at);
            let [zeroth, first] = moments(&signal, 250.0, rate);
            // −d arg S / dω: the middle of the swell and the group delay on top.
            let middle = (first.0 * zeroth.0 + first.1 * zeroth.1) / (zeroth.0.powi(2) + zeroth.1.powi(2));
            let group = middle - begin - HALF;
            assert!(
                (group - delay.total()).abs() < 2e-6,
                "envelope at {rate} Hz, {taps} taps: {group} s late, {} s said",
                delay.total()
            );
            // A sine is a cosine a quarter turn back.
            let lag = -zeroth.1.atan2(zeroth.0) - FRAC_PI_2 - TAU * 250.0 * begin;
            let said = delay.lead + delay.up_sampling + delay.band_limit_phase;
            let wrong = (lag - TAU * 250.0 * said + PI).rem_euclid(TAU) - PI;
            assert!(
                (wrong / TAU / 250.0).abs() < 1e-6,
                "phase at {rate} Hz, {taps} taps: {} s wrong",
                wrong / TAU / 250.0
            );
        }
    }
}

#[test]
fn band_limit_and_up_sampling_take_less_than_1_6_ms() {
    for rate in RATES {
        let (delay, ..) = swell(rate, 6, 100.0);
        let added = delay.band_limit_group + delay.up_sampling;
        // Live, an event may take some frames to the callback.
        #[cfg(feature = "live")]
        let haste = (pacinian::live::clock::HASTE * rate).ceil() / rate;
        #[cfg(not(feature = "live"))]
        let haste = 0.0;
        let total = delay.total() + haste;
        println!("{rate}: {:.3} ms added, {:.3} ms in all", 1e3 * added, 1e3 * total);
        assert!(added < 1.6e-3, "{added} s at {rate} Hz");
        assert!(delay.lead > 0.0 && delay.lead < 0.3e-3);
        assert!(total < 1.7e-3, "{total} s in all at {rate} Hz");
    }
}
