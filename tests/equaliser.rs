//! The equaliser of an actuator is heard on its outputs, on no others, and is what the reference knows of.

mod common;

use common::{channel, moments, patch, play, rendered};
use pacinian::engine::exchange::exchange;
use pacinian::engine::handover::Mismatch;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;

const PATCH: &str = r#"
[voice.tone]
output = "out"
[voice.tone.nodes]
sine = { type = "sine", frequency = "event.frequency" }
swell = { type = "envelope", attack = 0.05, decay = 0.0, sustain = 1.0, release = 0.05 }
out = { type = "multiply", inputs = ["sine", "swell", 0.2] }
"#;

/// A rig whose first tactor has this equaliser and whose second has none.
fn rig(equaliser: &str) -> Rig {
    let text = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[actuator.coil]\nequaliser = [{equaliser}]\n\
         [[tactor]]\nname = \"a\"\nchannel = 1\nactuator = \"coil\"\n[[tactor]]\nname = \"b\"\nchannel = 2\n"
    );
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn plan(equaliser: &str, rate: f64) -> Plan {
    let options = Options { rate: Some(rate), live: true, ..Options::default() };
    scene(&patch(PATCH), &rig(equaliser), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

const PEAK: &str = "{ frequency = 200, gain_db = 6, q = 2 }";

/// Strength of a steady tone on both channels.
fn strengths(plan: &Plan, hertz: f64) -> [f64; 2] {
    let events = [(0.0, play(0, 0, hertz, 2.0, 1)), (0.0, play(0, 1, hertz, 2.0, 2))];
    let (engine, frames) = rendered(plan, &events, 0.0);
    assert_eq!(engine.stage().counts().limited, 0);
    let rate = plan.device_rate;
    let (from, to) = ((0.5 * rate) as usize, (1.5 * rate) as usize);
    [0, 1].map(|c| {
        let (re, im) = moments(&channel(&frames, 2, c)[from..to], hertz, rate)[0];
        re.hypot(im)
    })
}

#[test]
fn a_peak_raises_its_frequency_and_leaves_the_rest() {
    for rate in [48_000.0, 44_100.0] {
        let equalised = plan(PEAK, rate);
        for (hertz, wanted, within) in [(200.0, 6.0, 0.01), (50.0, 0.0, 0.2), (900.0, 0.0, 0.2)] {
            let [with, without] = strengths(&equalised, hertz);
            let gain = 20.0 * (with / without).log10();
            assert!((gain - wanted).abs() < within, "{hertz} Hz at {rate} Hz: {gain} dB");
        }
        // The neighbour without an equaliser is as on a rig that has none at all.
        let plain = strengths(&plan("", rate), 200.0);
        assert_eq!(strengths(&equalised, 200.0)[1], plain[1]);
    }
}

#[cfg(feature = "report")]
#[test]
fn the_reference_goes_through_the_same_equaliser() {
    use pacinian::report::measure;
    let several = format!("{PEAK}, {{ frequency = 60, gain_db = -9, q = 1.5 }}");
    let events = [(0.01, play(0, 0, 210.0, 0.5, 1)), (0.02, play(0, 0, 61.0, 0.5, 2))];
    for rate in [48_000.0, 44_100.0] {
        let found = measure(&plan(&several, rate), &events, 0.7).unwrap().comparison;
        assert!(found.error_db < -80.0, "{rate} Hz: {found:?}");
    }
}

#[test]
fn a_filter_that_the_engine_has_no_room_for_is_refused() {
    let options = Options { rate: Some(6_000.0), ..Options::default() };
    let rig = rig("{ frequency = 3000, gain_db = 6 }");
    let problems = scene(&patch(PATCH), &rig, &options, &NoAssets).unwrap_err().to_string();
    for word in ["`coil`", "3000 Hz", "6000 Hz"] {
        assert!(problems.contains(word), "{word}: {problems}");
    }
}

#[test]
fn a_plan_with_another_equaliser_does_not_follow_unheard() {
    let (mut director, _stagehand) = exchange(&plan(PEAK, 48_000.0)).unwrap();
    assert_eq!(director.send(&plan("", 48_000.0)), Err(Mismatch::Outputs));
    assert_eq!(director.send(&plan(PEAK, 48_000.0)), Ok(true));
}
