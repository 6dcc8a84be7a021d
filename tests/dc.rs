//! Steady voltages leave only on outputs that are declared for them.

mod common;

use std::f64::consts::{PI, TAU};

use common::{channel, moments, patch, play, rendered};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const PATCH: &str = r#"
[voice.steady]
output = "o"
[voice.steady.nodes]
e = { type = "envelope", attack = 0.0, decay = 0.0, sustain = 1.0, release = 0.0 }
o = { type = "multiply", inputs = ["e", 0.5] }
[voice.tone]
output = "o"
[voice.tone.nodes]
t = { type = "sine", frequency = "event.frequency" }
e = { type = "envelope", attack = 0.05, decay = 0.0, sustain = 1.0, release = 0.05 }
o = { type = "multiply", inputs = ["t", "e", 0.5] }
[voice.plateau]
output = "o"
[voice.plateau.nodes]
e = { type = "envelope", attack = 0.02, decay = 0.0, sustain = 1.0, release = 0.02 }
o = { type = "multiply", inputs = ["e", 0.5] }
[voice.swell]
output = "o"
[voice.swell.nodes]
t = { type = "sine", frequency = 250 }
e = { type = "burst", attack = 0.1, decay = 0.1 }
o = { type = "multiply", inputs = ["t", "e", 0.5] }
"#;

const STEADY: u32 = 0;
const TONE: u32 = 1;
#[cfg(feature = "report")]
const PLATEAU: u32 = 2;
const SWELL: u32 = 3;

/// A tactor that says nothing, one that lets all through, and a raw output.
fn rig(coupling: &str) -> Rig {
    let text = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\n{coupling}\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
         [[tactor]]\nname = \"b\"\nchannel = 2\ndc = true\n[[output]]\nkind = \"raw\"\nname = \"c\"\nchannel = 3\n"
    );
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn plan_on(rig: &Rig, rate: f64) -> Plan {
    let options = Options { rate: Some(rate), live: true, ..Options::default() };
    scene(&patch(PATCH), rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

fn plan(coupling: &str) -> Plan {
    plan_on(&rig(coupling), 48_000.0)
}

/// The same without its leave for steady voltages.
const TAKEN_BACK: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\ncoupling = \"dc\"\n[[tactor]]\nname = \"a\"\n\
     channel = 1\n[[tactor]]\nname = \"b\"\nchannel = 2\n[[output]]\nkind = \"raw\"\nname = \"c\"\nchannel = 3\n";

const DC: &str = "coupling = \"dc\"";

/// What lasts: the mean of a stretch of frames (seconds).
fn mean(signal: &[f64], from: f64, to: f64) -> f64 {
    let part = &signal[(from * 48_000.0) as usize..(to * 48_000.0) as usize];
    part.iter().sum::<f64>() / part.len() as f64
}

#[test]
fn a_steady_voltage_is_gone_after_a_second_and_a_half_unless_it_is_declared() {
    let events = [0, 1, 2].map(|place| (0.1, play(STEADY, place, 0.0, 3.0, u64::from(place))));
    let (engine, frames) = rendered(&plan(DC), &events, 4.0);
    let [kept, free, raw] = [0, 1, 2].map(|c| channel(&frames, 3, c));
    let begin = 0.1 + engine.delay().total();
    // 0.9661 of it: the band limit's ripple.
    let through = engine.stage().response(1, 0.0).abs();
    for after in [0.01, 0.1, 0.3, 1.0] {
        let at = begin + after;
        let decayed = 0.5 * through * (-TAU * after).exp();
        let is = mean(&kept, at - 0.001, at + 0.001);
        assert!((is - decayed).abs() < 2e-3, "{after} s on: {is} for {decayed}");
        assert!((mean(&free, at - 0.001, at + 0.001) - 0.5 * through).abs() < 2e-3);
        assert!((mean(&raw, at - 0.001, at + 0.001) - 0.5).abs() < 2e-3);
    }
    let [late, end] = [begin + 1.5, begin + 2.9].map(|at| (at * 48_000.0) as usize);
    let most = kept[late..end].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(most < 0.5e-4, "{most}");
    assert!((mean(&free, begin + 1.5, begin + 2.9) - 0.5 * through).abs() < 1e-4);
    // Nothing is left for ever: silence becomes exact zero.
    assert!(engine.is_silent());
    assert!(frames[frames.len() - 300..].iter().all(|x| *x == 0.0));
}

/// Where the device is not known to let anything steady through, nothing is done and no bit differs.
#[test]
fn nothing_is_done_for_a_card_that_does_it_itself() {
    let events = [0, 1, 2].map(|place| (0.1, play(STEADY, place, 0.0, 0.3, u64::from(place))));
    let (engine, frames) = rendered(&plan(""), &events, 0.1);
    assert_eq!(engine.delay().high_pass_group, 0.0);
    let unlike = (0..frames.len() / 3).find(|n| frames[3 * n].to_bits() != frames[3 * n + 1].to_bits());
    assert_eq!(unlike, None);
    let (_, again) = rendered(&plan("coupling = { high_pass = 8.0 }"), &events, 0.1);
    assert!(frames.iter().map(|x| x.to_bits()).eq(again.iter().map(|x| x.to_bits())));
}

#[test]
fn levels_and_phases_are_those_of_the_design() {
    for rate in [48_000.0, 44_100.0] {
        let plan = plan_on(&rig(DC), rate);
        let engine = Engine::new(&plan).unwrap();
        for hertz in [1.0, 20.0, 250.0] {
            // Many periods of each.
            let (from, to) = (2.0, 6.0);
            let events = [0, 1].map(|place| (0.0, play(TONE, place, hertz, 6.5, u64::from(place))));
            let (_, frames) = rendered(&plan, &events, 0.0);
            let at = |c: usize| {
                let part = channel(&frames, 3, c)[(from * rate) as usize..(to * rate) as usize].to_vec();
                moments(&part, hertz, rate)[0]
            };
            let ((a, b), (c, d)) = (at(0), at(1));
            let (level, turn) = (a.hypot(b) / c.hypot(d), b.atan2(a) - d.atan2(c));
            let [with, without] = [0, 1].map(|c| engine.stage().response(c, hertz));
            let designed = with.abs() / without.abs();
            // And as a resistor and a capacitor do it.
            let exact = hertz / hertz.hypot(1.0);
            assert!((level / designed - 1.0).abs() < 1e-4, "{hertz} Hz at {rate} Hz: {level} for {designed}");
            assert!((designed / exact - 1.0).abs() < 1e-5, "{hertz} Hz at {rate} Hz: {designed} for {exact}");
            let wrong = (turn - (1.0 / hertz).atan() + PI).rem_euclid(TAU) - PI;
            assert!(wrong.abs() < 1e-3, "{hertz} Hz at {rate} Hz: turned by {turn}");
        }
    }
}

/// The envelope of 250 Hz comes when the engine says: the same measure on both tactors, which differ by what is said of the high-pass.
#[test]
fn the_delay_that_is_said_has_the_high_pass_in_it() {
    let plan = plan(DC);
    let events = [0, 1].map(|place| (0.05, play(SWELL, place, 0.0, 0.2, u64::from(place))));
    let (engine, frames) = rendered(&plan, &events, 3.0);
    let middle = |c: usize| {
        let [zeroth, first] = moments(&channel(&frames, 3, c), 250.0, 48_000.0);
        (first.0 * zeroth.0 + first.1 * zeroth.1) / (zeroth.0.powi(2) + zeroth.1.powi(2))
    };
    let delay = engine.delay();
    assert!((2.4e-6..2.7e-6).contains(&delay.high_pass_group), "{delay:?}");
    let later = middle(0) - middle(1);
    assert!((later - delay.high_pass_group).abs() < 0.2e-6, "{later}");
    let plain = Engine::new(&self::plan("")).unwrap().delay();
    assert!((delay.total() - plain.total() - delay.high_pass_group).abs() < 1e-12);
}

/// A rig that takes back its word while a steady voltage leaves: it is gone as soon as the high-pass has it.
#[test]
fn a_rig_that_changes_its_word_on_it_is_obeyed() {
    let (mut director, mut stagehand) = exchange(&plan("")).unwrap();
    let steady = Event::Play(play(STEADY, 1, 0.0, 60.0, 1));
    assert!(stagehand.engine().schedule(Instant::default(), Source::Program, steady));
    let mut frames = vec![0.0; 48_000 * 3];
    stagehand.process(&[], &mut frames);
    assert!(frames[47_999 * 3 + 1] > 0.4, "{}", frames[47_999 * 3 + 1]);
    let forbidden = Rig::parse("rig.toml", TAKEN_BACK.as_bytes()).unwrap().value;
    assert_eq!(director.send(&plan_on(&forbidden, 48_000.0)), Ok(true));
    let mut frames = vec![0.0; 3 * 48_000 * 3];
    stagehand.process(&[], &mut frames);
    let left = channel(&frames, 3, 1);
    assert!(left[..480].iter().all(|x| *x > 0.3), "no step");
    assert!(mean(&left, 2.0, 2.9).abs() < 1e-4);
}

/// What is taken away by design is no error, of what is steady and of tones alike.
#[cfg(feature = "report")]
#[test]
fn the_reference_goes_through_the_same_high_pass() {
    use pacinian::report::measure;
    let tones: Vec<_> = [(0.01, 210.0, 0), (0.02, 61.0, 1), (0.33, 20.0, 0)]
        .map(|(at, hertz, place)| (at, play(TONE, place, hertz, 0.2, hertz as u64)))
        .to_vec();
    let steady = vec![(0.01, play(PLATEAU, 0, 0.0, 0.5, 9)), (0.2, play(PLATEAU, 1, 0.0, 0.3, 10))];
    for events in [tones, steady] {
        let error = |coupling: &str| measure(&plan(coupling), &events, 0.7).unwrap().comparison.error_db;
        let (with, without) = (error(DC), error(""));
        assert!(with < -80.0 && with < without + 3.0, "{with} dB, {without} dB without");
    }
}
