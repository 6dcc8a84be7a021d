//! The equaliser of an actuator is heard on its outputs, on no others, and is what the reference knows of.

mod common;

use common::{channel, moments, patch, play, rendered};
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

/// A rig whose only tactor is an LRA, or a coil on the skin, evened out as said, or not at all.
fn resonant(figures: &str, even_out: &str) -> String {
    format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 2.5\n\
         [amplifier.board]\ngain = 2.0\nmax_volts = 5.0\n[actuator.it]\n{figures}\n{even_out}\n\
         [[tactor]]\nname = \"a\"\nchannel = 1\nactuator = \"it\"\namplifier = \"board\"\n"
    )
}

const LRA: &str = "model = \"lra\"\nresonance = 175.0\nq = 15.0\nrated_volts = 2.0\nmax_volts = 5.0\nrated_acceleration = 12.0\n\
                   test_mass = 0.1\ndevice_mass = 2.5e-3\nslug_mass = 1.5e-3\nresistance = 25.0";
const COIL: &str = "model = \"voice-coil\"\nresistance = 7.0\nforce_factor = 1.2\nmoving_mass = 1.5e-3\nresonance = 230.0\nq = 3.6\n\
                    max_volts = 5.0";

fn parsed(text: &str) -> Rig {
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn planned(rig: &Rig) -> Plan {
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    scene(&patch(PATCH), rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// With the pole pair taken out, drive and motion together have the pair that was asked for.
#[test]
fn a_resonance_goes_where_the_rig_wants_it() {
    use pacinian::actuator::coil::resonance::Resonance;
    use pacinian::dsp::complex::Complex;
    for (figures, even_out, target, of_casing) in [
        (LRA, "even_out = { q = 4.0, most_db = 30.0 }", Resonance { hertz: 175.0, q: 4.0 }, true),
        (COIL, "even_out = { resonance = 120.0, most_db = 30.0 }", Resonance { hertz: 120.0, q: 0.7 }, false),
    ] {
        let (rig, plain) = (parsed(&resonant(figures, even_out)), parsed(&resonant(figures, "")));
        let even = rig.evened(&rig.outputs[0]).unwrap().unwrap();
        assert_eq!((even.limited, even.gain), (None, 1.0), "{even:?}");
        let plant = rig.actuators[0].coil().unwrap();
        let engines = [&rig, &plain].map(|rig| pacinian::engine::Engine::new(&planned(rig)).unwrap());
        let moved = |hertz: f64| {
            let [with, without] = engines.each_ref().map(|engine| engine.stage().response(0, hertz));
            let response = plant.per_volt(hertz);
            let motion = if of_casing { response.casing } else { response.displacement };
            (with / without * motion).abs()
        };
        // Of a pair, by its definition: the acceleration far above it is even, or the displacement far below.
        let due = |hertz: f64, pair: &Resonance| {
            let s = Complex::oscillation(hertz);
            let bottom = s * s + s * (pair.omega() / pair.q) + pair.omega() * pair.omega();
            1.0 / bottom.abs()
        };
        let own = even.own;
        for hertz in [25.0, 60.0, 120.0, 174.0, 176.0, 240.0, 500.0, 900.0] {
            let scale = if of_casing { 1.0 } else { (target.hertz / own.hertz).powi(2) };
            let response = plant.per_volt(hertz);
            let motion = if of_casing { response.casing } else { response.displacement };
            let wanted = motion.abs() / due(hertz, &own) * due(hertz, &target) * scale;
            let off = 20.0 * (moved(hertz) / wanted).log10();
            assert!(off.abs() < 0.01, "{hertz} Hz of {figures}: {off} dB");
        }
    }
}

/// Through the engine onto the model of the actuator: it is up and still again much sooner.
#[test]
fn a_resonant_actuator_begins_and_ends_faster() {
    use pacinian::actuator::coil::model::Model;
    use pacinian::actuator::drive::Drive;
    let peaks = |even_out: &str| {
        let rig = parsed(&resonant(LRA, even_out));
        let plan = planned(&rig);
        let (_, frames) = rendered(&plan, &[(0.0, play(0, 0, 175.0, 0.4, 1))], 0.6);
        let plant = rig.actuators[0].coil().unwrap();
        let mut model = Model::new(&plant, 48_000.0, Drive::Voltage).unwrap();
        let casing: Vec<f64> = frames.iter().map(|x| model.step(5.0 * f64::from(*x)).casing).collect();
        // The largest of each period of the tone.
        casing
            .chunks(48_000 / 175)
            .map(|part| part.iter().fold(0.0_f64, |m, a| m.max(a.abs())))
            .collect::<Vec<_>>()
    };
    let (evened, plain) = (peaks("even_out = { q = 2.0, most_db = 20.0 }"), peaks(""));
    // Periods until 90 % of what it becomes, and those in which more than a tenth of that is left.
    let times = |peaks: &[f64]| {
        let full = peaks[60];
        assert!(full > 0.1, "{full}");
        let rise = peaks.iter().position(|peak| *peak > 0.9 * full).unwrap();
        let stop = peaks.iter().rposition(|peak| *peak > 0.1 * full).unwrap() - 70;
        (rise, stop)
    };
    let ((rise, stop), (slow_rise, slow_stop)) = (times(&evened), times(&plain));
    // Q of 15 takes 11 periods to 90 %, and as many to a tenth; the patch itself swells for 9, and goes in as many.
    assert!(rise + 3 <= slow_rise && stop + 3 <= slow_stop, "{rise} {stop}, plain {slow_rise} {slow_stop}");
}

#[test]
fn evening_out_keeps_to_what_is_borne_and_says_what_it_lacks() {
    use pacinian::actuator::coil::equaliser::Limited;
    let of = |text: &str| {
        let rig = parsed(text);
        rig.evened(&rig.outputs[0]).map(|even| even.map_err(|problem| problem.to_string()))
    };
    let even = |text: &str| of(text).unwrap().unwrap();
    // A resonance moved down asks for more below: as far as the volts go, or the boost.
    let far = resonant(COIL, "even_out = { resonance = 60.0, most_db = 40.0 }");
    let stroke = far.replace("max_volts = 5.0\neven", "max_volts = 5.0\nstroke = 1e-4\neven");
    let held = even(&stroke);
    assert_eq!(held.limited, Some(Limited::Stroke), "{held:?}");
    let little = even(&resonant(COIL, "even_out = { most_db = 3.0 }"));
    assert_eq!(little.limited, Some(Limited::Cut));
    // Without volts, only the most that is said holds it back.
    assert_eq!(even(&stroke.replace("full_scale_volts = 2.5\n", "")).limited, None);
    assert!(of(&resonant(COIL, "")).is_none());
    let lacks =
        of(&resonant(&COIL.replace("force_factor = 1.2\n", ""), "even_out = {}")).unwrap().unwrap_err();
    assert!(lacks.contains("`it`") && lacks.contains("`force_factor`"), "{lacks}");
    for (figures, even_out, words) in [
        ("model = \"rumble-motor\"", "even_out = {}", ["rumble-motor", "lra"]),
        (COIL, "even_out = { low = 300.0, high = 100.0 }", ["`low`", "`high`"]),
        (COIL, "even_out = { q = 0.0 }", ["`q`", "0.3"]),
        (COIL, "even_out = 3", ["`even_out`", "table"]),
    ] {
        let text = resonant(figures, even_out);
        let said = Rig::parse("rig.toml", text.as_bytes()).map(|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
}
