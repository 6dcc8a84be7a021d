//! Nodes that set off voices: when, how often, and the same however a run is cut.

mod common;

use common::{compiled, patch};
use pacinian::engine::Engine;
use pacinian::engine::event::Play;
use pacinian::engine::exchange::{Director, exchange};
use pacinian::graph::answer::{Answer, Voiced};
use pacinian::graph::plan::{Plan, Precision};
use pacinian::graph::scene::Options;
use pacinian::graph::start::FIELDS;
use pacinian::graph::watch::Watch;
use pacinian::node::asset::NoAssets;
use pacinian::player::{Happening, Player};
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;
use std::sync::{Arc, Mutex};

const TICK: &str = r#"
[voice.tick]
voices = 8
output = "out"
[voice.tick.defaults]
frequency = 200
[voice.tick.nodes]
tone = { type = "sine", frequency = "event.frequency" }
rub = { type = "white", amplitude = 0.1 }
hit = { type = "burst", attack = 0.002, decay = 0.01 }
out = { type = "multiply", inputs = ["tone + rub", "hit"] }
"#;

/// A plan whose nodes set off ticks.
fn plan(shared: &str, triggers: &[(&str, &str)]) -> Plan {
    compiled(&text(shared, triggers), 4, 48_000.0).plan
}

fn text(shared: &str, triggers: &[(&str, &str)]) -> String {
    let mut text = format!("[shared.nodes]\n{shared}\n{TICK}");
    for (on, more) in triggers {
        text += &format!("[[trigger]]\non = \"{on}\"\nplay = \"tick\"\n{more}\n");
    }
    text
}

/// What was set off: when (samples of the engine), by which watch, and as which voice.
type Found = Vec<(Instant, u32, u64)>;

/// Frames of a run in calls of these lengths, and what was set off in it.
fn run(plan: &Plan, seconds: f64, calls: &[usize], input: &[f32]) -> (Vec<f32>, Found) {
    let mut engine = Engine::new(plan).unwrap();
    let mut output = vec![0.0; (seconds * plan.device_rate) as usize * plan.channels];
    let (mut rest, mut heard, mut found) = (&mut output[..], input, Vec::new());
    let ears = engine.input_channels();
    for &call in calls.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let frames = call.min(rest.len() / plan.channels);
        let (now, later) = rest.split_at_mut(frames * plan.channels);
        let (hears, later_heard) = heard.split_at((frames * ears).min(heard.len()));
        engine.process_input(hears, now);
        found.extend(engine.crossings().map(|c| (c.at, c.watch, c.id())));
        (rest, heard) = (later, later_heard);
    }
    assert_eq!((engine.counters().dropped, engine.take_unkept()), (0, 0));
    (output, found)
}

/// In seconds, without the engine's latency.
fn times(plan: &Plan, found: &Found) -> Vec<f64> {
    let delay = Engine::new(plan).unwrap().watch_delay();
    assert!((delay * plan.engine_rate() - 8.0).abs() < 1e-12);
    found.iter().map(|(at, ..)| at.since(Instant::default()) / plan.engine_rate() - delay).collect()
}

/// Where ½ + ½ sin 2πft passes a threshold in a stretch of time, upwards or downwards.
fn exact(hertz: f64, threshold: f64, rises: bool, seconds: f64) -> Vec<f64> {
    let up = (2.0 * threshold - 1.0).asin() / std::f64::consts::TAU;
    let turn = if rises { up } else { 0.5 - up };
    (-1..)
        .map(|n| (turn + f64::from(n)) / hertz)
        .skip_while(|t| *t <= 0.0)
        .take_while(|t| *t < seconds)
        .collect()
}

#[test]
fn a_sine_passes_a_threshold_when_its_formula_says() {
    for hertz in [0.7, 3.1, 23.0, 97.0] {
        for (threshold, rises) in [(0.5, true), (0.2, true), (0.9, true), (0.5, false), (0.85, false)] {
            let way = if rises { "rises" } else { "falls" };
            let on = format!("node.lfo {way} {threshold}");
            let mut plan = plan(&format!("lfo = {{ type = \"lfo\", rate = {hertz} }}"), &[(&on, "")]);
            for precision in [Precision::Single, Precision::Double] {
                plan.precision = precision;
                let (_, found) = run(&plan, 3.0, &[480], &[]);
                // At the beginning it stands where half is passed, up to the last bit.
                let times: Vec<f64> = times(&plan, &found).into_iter().filter(|time| *time > 1e-9).collect();
                let exact = exact(hertz, threshold, rises, 2.99);
                // A straight line errs by h² |x''| / 8 |x'| of a sample h at most, with what follows; numbers of 32 bits by half a bit.
                let omega = std::f64::consts::TAU * hertz;
                let (height, h) = (2.0 * threshold - 1.0, 1.0 / plan.engine_rate());
                let slope = omega * (1.0 - height * height).sqrt();
                let straight =
                    h * h / 8.0 * omega * omega * height.abs() / slope + (omega * h).powi(3) / omega;
                let bits = if precision == Precision::Single { 2e-7 / slope } else { 1e-12 };
                assert!(times.len().abs_diff(exact.len()) <= 1 && exact.len() > 1, "{on}, {hertz} Hz");
                for (time, exact) in times.iter().zip(&exact) {
                    let off = (time - exact).abs();
                    assert!(off < straight + bits + 1e-11, "{on}, {hertz} Hz: {exact} s is {off} s off");
                    assert!(off < 0.05 * h || hertz > 50.0);
                }
            }
        }
    }
}

/// The voice sounds where it would if somebody had played it then.
#[test]
fn what_is_set_off_sounds_as_if_it_were_played_at_that_instant() {
    let set = "place = \"t2\"\nset = { frequency = \"100 + 200 * value\", level = 0.4, duration = 0.03 }";
    let watched = plan("lfo = { type = \"lfo\", rate = 3.1 }", &[("node.lfo rises 0.3", set)]);
    let (output, found) = run(&watched, 1.0, &[480], &[]);
    assert!(found.len() == 3, "{found:?}");
    let mut silent = watched.clone();
    silent.watches.clear();
    let mut engine = Engine::new(&silent).unwrap();
    for (at, _, id) in &found {
        let mut own = [0.0; FIELDS];
        own[0] = 160.0;
        let play =
            Play { instrument: 0, place: Spot::Row(1), level: 0.4, felt: None, duration: 0.03, own, id: *id };
        let (source, event) =
            (pacinian::engine::event::Source::Program, pacinian::engine::event::Event::Play(play));
        assert!(engine.schedule(*at, source, event));
    }
    let mut again = vec![0.0; output.len()];
    engine.process(&mut again);
    assert!(output.iter().any(|x| x.abs() > 0.1));
    assert!(output.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn no_way_to_cut_a_run_changes_a_bit_or_an_instant() {
    let shared = "ear = { type = \"input\", channel = 1 }\nloud = { type = \"follow\", input = \"ear\", attack = 0.001, release = 0.01 }\n\
        hiss = { type = \"white\" }\nlfo = { type = \"lfo\", rate = 37 }";
    let plan = plan(
        shared,
        &[
            ("node.loud rises 0.1", "place = 1"),
            ("node.hiss rises 0.5", "place = 2\nset = { level = 0.1 }"),
            ("node.hiss falls 0", "place = 3\nhold = 0.01\nset = { level = 0.1, duration = 0.05 }"),
            ("node.hiss rises 0.5", "place = 3\nset = { level = 0.1, frequency = 90 }"),
            ("node.lfo rises 0.7", "place = 4\nrearm = 0.1"),
        ],
    );
    let mut state = 1_u32;
    let input: Vec<f32> = (0..24_000)
        .map(|n| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let clap = if n % 4_000 < 400 { 0.8 } else { 0.01 };
            if n == 9_000 { f32::NAN } else { clap * (state as f32 / u32::MAX as f32 - 0.5) }
        })
        .collect();
    let (whole, found) = run(&plan, 0.5, &[24_000], &input);
    assert!(whole.iter().all(|x| x.is_finite()) && whole.iter().any(|x| *x != 0.0));
    let of = |watch: u32| found.iter().filter(|(_, w, _)| *w == watch).count();
    assert!(
        (5..=8).contains(&of(0)) && of(1) > 500 && of(1) == of(3) && (20..=50).contains(&of(2)),
        "{:?}",
        [of(0), of(1), of(2)]
    );
    assert!((17..=19).contains(&of(4)));
    // Onsets are told in their order.
    assert!(found.windows(2).all(|w| w[0].0 <= w[1].0));
    for calls in [&[1][..], &[7], &[48], &[1, 5, 6, 11, 64, 480, 3], &[383, 2]] {
        let (cut, again) = run(&plan, 0.5, calls, &input);
        assert!(again == found, "calls of {calls:?}");
        assert!(whole.iter().zip(&cut).all(|(a, b)| a.to_bits() == b.to_bits()), "calls of {calls:?}");
    }
}

/// Four thousand thresholds that noise passes at the engine's rate.
fn stormy() -> Plan {
    let mut plan = plan("hiss = { type = \"white\" }", &[("node.hiss rises 0.5", "set = { level = 0.01 }")]);
    let one = plan.watches[0].clone();
    plan.watches = (0..4_000)
        .map(|i| Watch {
            threshold: f64::from(i) / 4_000.0 - 0.5,
            rearm: f64::from(i) / 4_000.0 - 0.5,
            rises: i % 2 == 0,
            ..one.clone()
        })
        .collect();
    plan
}

/// Thousands of nodes that tremble at the engine's rate take their time, and no more; what is too much is counted.
#[test]
fn a_storm_is_bounded_and_the_same_however_it_is_cut() {
    let plan = stormy();
    let storm = |call: usize| {
        let mut engine = Engine::new(&plan).unwrap();
        let (mut output, mut told) = (vec![0.0; 4 * 4_800], 0);
        for part in output.chunks_mut(4 * call) {
            engine.process(part);
            told += engine.crossings().count() as u64;
        }
        let counters = engine.counters();
        assert_eq!(told + engine.take_unkept(), counters.started);
        (output, counters)
    };
    let (output, counters) = storm(480);
    assert!(output.iter().all(|x| x.is_finite()));
    // A hundred milliseconds are twelve and a half stretches of the grid.
    assert_eq!(counters.started, 13 * 1024);
    assert!(counters.dropped > 10 * counters.started, "{counters:?}");
    for call in [7, 4_800] {
        let (again, counted) = storm(call);
        assert!(again == output && counted == counters, "calls of {call}: {counted:?}, not {counters:?}");
    }
}

/// The voice that a watch sets off.
fn voiced(watch: &mut Watch) -> &mut Voiced {
    match &mut watch.answer {
        Answer::Voice(voiced) => voiced,
        Answer::Pattern(started) => panic!("{started:?}"),
    }
}

#[test]
fn watches_that_no_plan_should_have_do_no_harm() {
    let plain = plan("lfo = { type = \"lfo\", rate = 50 }", &[("node.lfo rises 0.5", "")]);
    let started = |change: &dyn Fn(&mut Watch)| {
        let mut plan = plain.clone();
        change(&mut plan.watches[0]);
        let mut engine = Engine::new(&plan).unwrap();
        let mut output = vec![0.0; 4 * 9_600];
        engine.process(&mut output);
        assert!(output.iter().all(|x| x.is_finite()));
        engine.counters().started
    };
    assert_eq!(started(&|_| {}), 9);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(started(&|watch| watch.threshold = bad), 0);
        started(&|watch| watch.rearm = bad);
        started(&|watch| watch.hold = bad);
        started(&|watch| voiced(watch).level = bad);
        started(&|watch| voiced(watch).duration = bad);
        started(&|watch| voiced(watch).own = [bad; FIELDS]);
    }
    assert_eq!(started(&|watch| watch.hold = f64::INFINITY), 1);
    assert_eq!(started(&|watch| watch.signal = 99), 0);
    assert_eq!(started(&|watch| voiced(watch).instrument = 99), 0);
    assert_eq!(started(&|watch| voiced(watch).place = Spot::Row(99)), 9);
}

/// What is set off in a run in which other plans take over, before the calls (of 6 frames, a sample of the engine) that `change` names.
fn with_swaps(
    first: &Plan,
    calls: usize,
    mut change: impl FnMut(usize) -> Option<Plan>,
) -> (Vec<f32>, Found, u64) {
    let (mut director, mut stagehand) = exchange(first).unwrap();
    let (mut output, mut found) = (Vec::new(), Vec::new());
    let mut frames = vec![0.0; 6 * first.channels];
    for n in 0..calls {
        if let Some(plan) = change(n) {
            director.send(&plan).unwrap();
        }
        stagehand.process(&[], &mut frames);
        found.extend(stagehand.engine().crossings().map(|c| (c.at, c.watch, c.id())));
        output.extend_from_slice(&frames);
    }
    (output, found, stagehand.engine().counters().dropped)
}

/// What was not kept is told once, whatever takes over before or after.
#[test]
fn what_was_not_kept_is_counted_once_through_reloads() {
    let plan = stormy();
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    let mut frames = vec![0.0; 4_800 * plan.channels];
    let reload = |director: &mut Director| director.send(&plan).unwrap();
    stagehand.process(&[], &mut frames);
    let lost = stagehand.engine().take_unkept();
    assert!(lost > 1_000 && stagehand.engine().take_unkept() == 0, "{lost}");
    reload(&mut director);
    stagehand.process(&[], &mut []);
    assert_eq!(stagehand.engine().take_unkept(), 0, "what was told is not told again");
    // What was not told yet is told by the one that follows.
    stagehand.process(&[], &mut frames);
    reload(&mut director);
    stagehand.process(&[], &mut []);
    assert!(stagehand.engine().take_unkept() > 1_000);
}

#[test]
fn a_reload_neither_sets_off_nor_forgets() {
    let shared = "lfo = { type = \"lfo\", rate = 41 }";
    let rises = ("node.lfo rises 0.7", "hold = 0.03");
    let first = plan(shared, &[rises]);
    let (plain, expected, _) = with_swaps(&first, 1600, |_| None);
    assert_eq!(expected.len(), 5, "every other one: {expected:?}");
    // The same again, at every place of the 8 samples between a crossing and its onset and around them: no bit is another.
    for shift in 0..12 {
        let (output, found, dropped) =
            with_swaps(&first, 1600, |n| (n % 97 == 13 + shift).then(|| first.clone()));
        let instants = |found: &Found| found.iter().map(|(at, ..)| *at).collect::<Vec<_>>();
        assert_eq!((instants(&found), dropped), (instants(&expected), 0), "{shift}");
        // The ids go on, so nothing else is drawn.
        assert_eq!(found, expected);
        assert!(output.iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()), "{shift}");
    }
    // With other triggers before it, another voice, and another level: it goes on at its instants.
    let more = plan(
        shared,
        &[("node.lfo falls 0.99", ""), ("node.lfo rises 0.7", "hold = 0.03\nset = { level = 0.2 }")],
    );
    for at in 400..500 {
        let (_, found, dropped) = with_swaps(&first, 1600, |n| (n == at).then(|| more.clone()));
        let swapped = |(when, watch, _): &&(Instant, u32, u64)| *watch == 1 || when.sample < at as u64;
        let instants: Vec<Instant> = found.iter().filter(swapped).map(|(at, ..)| *at).collect();
        assert_eq!(instants, expected.iter().map(|(at, ..)| *at).collect::<Vec<_>>(), "at {at}");
        assert_eq!(dropped, 0);
        // No voice has the id of another.
        let mut ids: Vec<u64> = found.iter().map(|(.., id)| *id).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), found.len());
    }
}

#[test]
fn a_signal_that_becomes_another_sets_nothing_off_as_it_does() {
    let at = |low: f64| {
        plan(
            &format!("lfo = {{ type = \"lfo\", rate = 2, low = {low}, high = {} }}", low + 0.1),
            &[("node.lfo rises 0.5", ""), ("node.lfo falls 0.5", "")],
        )
    };
    // From below to above, and back.
    for n in 700..720 {
        let (_, found, _) = with_swaps(&at(0.0), 2000, |call| match call {
            _ if call == n => Some(at(0.9)),
            _ if call == n + 600 => Some(at(0.0)),
            _ => None,
        });
        assert_eq!(found, [], "{n}");
    }
    // One that is new, of a signal that stands above, waits for it to come back.
    let shared = "lfo = { type = \"lfo\", rate = 10 }";
    let new = plan(shared, &[("node.lfo rises 0.3", "")]);
    let (_, found, _) = with_swaps(&plan(shared, &[]), 2000, |n| (n == 80).then(|| new.clone()));
    // The node begins as it takes over.
    let first = times(&new, &found)[0] - 80.0 / 8_000.0;
    assert!((first - exact(10.0, 0.3, true, 1.0)[0]).abs() < 1e-5, "{first}");
}

#[test]
fn a_player_tells_of_them_and_takes_them_for_no_silence() {
    let shared = "lfo = { type = \"lfo\", rate = 10 }";
    let text = text(shared, &[("node.lfo falls 0.25", "place = \"t3\"\nset = { duration = 0.01 }")]);
    let mut player =
        Player::new(&patch(&text), &Rig::default_for(4), &Options::default(), &NoAssets).unwrap();
    let told: Arc<Mutex<Vec<String>>> = Arc::default();
    let hears = Arc::clone(&told);
    player.record();
    player.listen(Box::new(move |heard| {
        let origin = heard.origin.unwrap();
        let Happening::Voice { name, place, duration, .. } = heard.what else { panic!() };
        assert_eq!(heard.id.unwrap() >> 62, 0b10);
        hears
            .lock()
            .unwrap()
            .push(format!("{} {} {name} {place} {duration} {:.4}", origin.pattern, origin.event, heard.at));
    }));
    player.process(&mut vec![0.0; 4 * 48_000]);
    let told = told.lock().unwrap();
    // A quarter is passed downwards at 7/12 of a turn; onsets are 1 ms later.
    let expected: Vec<String> = (0..10)
        .map(|n| {
            format!("node.lfo falls 0.25 {n} tick t3 0.01 {:.4}", (f64::from(n) + 7.0 / 12.0) / 10.0 + 0.001)
        })
        .collect();
    assert_eq!(*told, expected);
    assert!(player.recorded().is_empty(), "whoever plays it again sets it off again");
    assert_eq!((player.counters().started, player.counters().late), (10, 0));
}

#[test]
fn a_control_sets_voices_off_too() {
    let text = format!(
        "[control.push]\ndefault = 0\nsmoothing = 0.01\n{TICK}[[trigger]]\non = \"node.push rises 0.5\"\nplay = \"tick\"\n"
    );
    let mut player =
        Player::new(&patch(&text), &Rig::default_for(1), &Options::default(), &NoAssets).unwrap();
    player.process(&mut vec![0.0; 4_800]);
    assert_eq!(player.counters().started, 0);
    for expected in [1, 1, 2] {
        player.set("push", if expected == 1 && player.counters().started == 1 { 0.0 } else { 1.0 }).unwrap();
        player.process(&mut vec![0.0; 4_800]);
        assert_eq!(player.counters().started, expected);
    }
}

/// The reference sees by itself what the engine has set off.
#[cfg(feature = "report")]
#[test]
fn the_reference_hears_them() {
    use pacinian::graph::scene::scene;
    use pacinian::report::Take;
    let shared = "slow = { type = \"lfo\", rate = 7.3 }\nwild = { type = \"lfo\", wave = \"triangle\", rate = 61, high = \"slow\" }";
    let text = text(
        shared,
        &[
            ("node.slow rises 0.6", "place = 1\nset = { level = 0.5, duration = 0.02 }"),
            ("node.wild falls 0.3", "place = 2\nhold = 0.05\nset = { level = 0.5, duration = 0.02 }"),
            ("node.wild rises 0.4", "place = 3\nrearm = 0.05\nset = { level = 0.4, frequency = 90 }"),
        ],
    );
    let scene = scene(&patch(&text), &Rig::default_for(3), &Options::default(), &NoAssets).unwrap();
    let take = Take { events: &[], moves: &[], input: &[], seconds: 0.7 };
    let ideal = take.reference(&scene.plan);
    assert!(ideal.channels.iter().all(|c| c.iter().any(|x| x.abs() > 0.1)));
    let measured = take.measure(&scene.plan, &ideal).unwrap();
    assert!(measured.comparison.error_db < -80.0 && measured.stolen == 0, "{measured:?}");
    assert!(take.rings(&scene.plan) < 1.0, "nothing is set off after its end");
}
