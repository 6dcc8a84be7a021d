//! Illusions of motion as one event: a stroke, apparent motion, the rabbit; from the file to the channels.

mod common;

use std::f64::consts::TAU;

use common::{channel, patch};
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::{motions, quick};
use pacinian::node::asset::NoAssets;
use pacinian::player::Player;
use pacinian::rig::Rig;
use pacinian::space::array::Array;
use pacinian::space::brush::Stroke;
use pacinian::space::path::{Path, Timing};

/// Rows and columns, 50 mm apart, row by row.
fn grid(rows: u32, columns: u32) -> Rig {
    let mut rig = Rig::default_for(rows * columns);
    for (n, output) in (0..).zip(&mut rig.outputs) {
        output.position = Some([0.05 * f64::from(n % columns), 0.05 * f64::from(n / columns), 0.0]);
    }
    rig
}

fn array(rig: &Rig) -> Array {
    let points: Vec<_> = rig.outputs.iter().filter_map(|output| output.position).collect();
    Array::new(&points).unwrap()
}

/// A voice with further keys, and one pattern of these events.
fn text(keys: &str, phase: &str, events: &str) -> String {
    format!(
        "[voice.v]\nvoices = 32\noutput = \"out\"\n{keys}\n[voice.v.nodes]\n\
         tone = {{ type = \"sine\", frequency = 200, amplitude = 0.2, phase = \"{phase}\" }}\n\
         edge = {{ type = \"envelope\", attack = 0.005, release = 0.005 }}\n\
         out = {{ type = \"multiply\", inputs = [\"tone\", \"edge\"] }}\n[pattern.p]\nevents = [{events}]\n"
    )
}

fn rendered(text: &str, rig: &Rig, seconds: f64, live: bool) -> Vec<f32> {
    let options = Options { live, ..Options::default() };
    let mut player = Player::new(&patch(text), rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    let mut frames = vec![0.0; (seconds * 48_000.0) as usize * rig.device.channels as usize];
    player.process(&mut frames);
    frames
}

/// What one event plays is what its bursts play that are written one by one, to the bit.
#[test]
fn an_event_is_its_bursts() {
    let rig = grid(3, 4);
    let path = Path::new(&[[0.0, 0.02, 0.0], [0.14, 0.09, 0.0]], 0.7, Timing::Smooth).unwrap();
    let stroke = Stroke::new(&array(&rig), &path).unwrap();
    assert!(stroke.bursts.len() > 3);
    let burst = |at: f64, seconds: f64, place: &str| {
        format!("{{ at = {at:?}, voice = \"v\", level = 0.7, duration = {seconds:?}, place = {place} }}")
    };
    let of_stroke: Vec<String> = stroke
        .bursts
        .iter()
        .map(|b| {
            burst(b.start, b.seconds(), &format!("[{:?}, {:?}, {:?}]", b.place[0], b.place[1], b.place[2]))
        })
        .collect();
    let hops: Vec<String> = (0..6)
        .map(|k| burst(f64::from(k) * 0.06, 0.01, if k < 3 { "\"t4\"" } else { "[0.02, 0.03]" }))
        .collect();
    let steps: Vec<String> =
        (0..3).map(|k| burst(f64::from(k) * (0.32 * 0.1 + 0.0473), 0.1, &format!("{}", 3 + k))).collect();
    for (event, bursts) in [
        ("stroke = { path = [[0, 0.02], [0.14, 0.09]], over = 0.7, timing = \"smooth\" }", of_stroke),
        ("saltation = { places = [\"t4\", [0.02, 0.03]], taps = 3, interval = 0.06, tap = 0.01 }", hops),
        ("apparent = { places = [3, 4, 5], burst = 0.1 }", steps),
    ] {
        let law = "law = \"logarithmic\"";
        let one = text(law, "0", &format!("{{ at = 0, voice = \"v\", level = 0.7, {event} }}"));
        let many = text(law, "0", &bursts.join(", "));
        for live in [false, true] {
            let (one, many) = (rendered(&one, &rig, 1.0, live), rendered(&many, &rig, 1.0, live));
            assert!(one.iter().any(|x| x.abs() > 0.05), "{event}: silence");
            assert!(one.iter().zip(&many).all(|(a, b)| a.to_bits() == b.to_bits()), "{event}");
        }
    }
}

/// Where two bursts overlap on a tactor, a voice that goes on through both is as strong as their powers together.
#[test]
fn powers_of_bursts_that_overlap_add_up() {
    let rig = grid(1, 2);
    // At 25 % and 75 % between two tactors: both sound on both.
    let event = "{ at = 0, voice = \"v\", apparent = { places = [[0.0125, 0], [0.0375, 0]], burst = 0.15 } }";
    let onset = 0.32 * 0.15 + 0.0473;
    let share = |gain: f64, of: f64| 0.2 * gain * of;
    let strength = |phase: &str, fields: &str, begin: f64, end: f64, c: usize| {
        let frames = rendered(&text(fields, phase, event), &rig, 0.5, false);
        let signal = channel(&frames, 2, c);
        // Whole waves of 200 Hz, 240 frames each.
        let begin = (begin * 48_000.0) as usize;
        let count = ((end * 48_000.0) as usize - begin) / 240 * 240;
        let turned = |turn: fn(f64) -> f64| {
            let wave = |k: usize| turn(TAU * 200.0 * k as f64 / 48_000.0);
            (begin..begin + count).map(|k| wave(k) * signal[k]).sum::<f64>() * 2.0 / count as f64
        };
        turned(f64::sin).hypot(turned(f64::cos))
    };
    let (quarter, three) = (0.25_f64.sqrt(), 0.75_f64.sqrt());
    let goes_on =
        ("event.since * 200 + event.burst * event.burst / 4", "defaults = { since = 0, burst = 0 }");
    for (c, first, second) in [(0, three, quarter), (1, quarter, three)] {
        let alone = strength(goes_on.0, goes_on.1, 0.03, onset - 0.01, c);
        let both = strength(goes_on.0, goes_on.1, onset + 0.02, 0.145, c);
        let wanted = share(first, 1.0).hypot(share(second, 1.0));
        // The path out passes 200 Hz as it is, within its ripple.
        assert!((alone / share(first, 1.0) - 1.0).abs() < 0.02, "{c}: {alone}");
        assert!((both / wanted - 1.0).abs() < 0.02, "{c}: {both} {wanted}");
    }
}

/// Of three that overlap on one tactor, the first and the last are in step: the more sound, the stronger it is, and none takes another away.
#[test]
fn no_burst_takes_another_away() {
    let rig = grid(1, 1);
    let event = "{ at = 0, voice = \"v\", apparent = { places = [1, 1, 1], burst = 0.6 } }";
    let onset = 0.32 * 0.6 + 0.0473;
    let phase = "event.since * 200 + event.burst * event.burst / 4";
    let frames = rendered(&text("defaults = { since = 0, burst = 0 }", phase, event), &rig, 1.2, false);
    let strength = |begin: f64, end: f64| {
        let range = (begin * 48_000.0) as usize..(end * 48_000.0) as usize;
        let count = range.len() as f64;
        (2.0 * frames[range].iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / count).sqrt()
    };
    let edge = 0.03;
    for (begin, end, wanted) in [
        (0.0, onset, 1.0),
        (onset, 2.0 * onset, 2.0_f64.sqrt()),
        (2.0 * onset, 0.6, 5.0_f64.sqrt()),
        (0.6, onset + 0.6, 2.0_f64.sqrt()),
        (onset + 0.6, 2.0 * onset + 0.6, 1.0),
    ] {
        let strength = strength(begin + edge, end - edge) / 0.2;
        assert!((strength / wanted - 1.0).abs() < 0.03, "{begin}: {strength} {wanted}");
    }
}

#[test]
fn what_is_too_fast_is_refused_at_its_line_and_what_is_unusual_is_told() {
    let rig = grid(3, 4);
    let refused = |event: &str| {
        let text = text("", "0", event);
        let problems = scene(&patch(&text), &rig, &Options::default(), &NoAssets).err();
        problems.unwrap_or_else(|| panic!("{event} is taken")).to_string()
    };
    for (event, wanted) in [
        ("{ at = 0, voice = \"v\", duration = 0.04, stroke = { path = [[0, 0], [0.1, 0]] } }", "stroke"),
        ("{ at = 0, voice = \"v\", duration = 0, stroke = { path = [[0, 0], [0.1, 0]] } }", "stroke"),
        ("{ at = 0, voice = \"v\", duration = 0.05, apparent = { places = [1, 2, 3] } }", "apparent"),
        ("{ at = 0, voice = \"v\", stroke = { path = [[0, 0], [0.1, 0]], over = 0.001 } }", "stroke"),
    ] {
        let said = refused(event);
        assert!(said.contains(wanted), "{event}: {said}");
    }
    let told = |event: &str| {
        let patch = patch(&text("", "0", event));
        let list = motions::remarks(&patch, Some(&array(&rig)));
        list.into_iter().map(|problem| problem.what).collect::<Vec<_>>().join("\n")
    };
    let stroke = |points: &str, over: f64| {
        told(&format!("{{ at = 0, voice = \"v\", stroke = {{ path = {points}, over = {over:?} }} }}"))
    };
    assert_eq!(stroke("[[0, 0.025], [0.15, 0.025]]", 0.35), "");
    assert!(
        stroke("[[0, 0.025], [0.15, 0.025]]", 5.0)
            .contains("outside what the law of onsets is told to be measured for")
    );
    assert!(stroke("[[0, 0], [0.15, 0.1]]", 0.12).contains("too fast for"));
    assert!(stroke("[[0, 0.025], [0.3, 0.025]]", 0.6).contains("leaves the tactors by 0.150 m"));
}

/// Bursts that are cut off, and attacks that no burst is long enough for.
#[test]
fn voices_that_cannot_play_a_stroke_are_told() {
    let rig = grid(3, 4);
    let told = |voices: u32, attack: f64| {
        let event = "{ at = 0, voice = \"v\", stroke = { path = [[0, 0], [0.15, 0.1]], over = 0.6 } }";
        let text = text("", "0", event)
            .replace("voices = 32", &format!("voices = {voices}"))
            .replace("attack = 0.005", &format!("attack = {attack}"));
        let list = motions::remarks(&patch(&text), Some(&array(&rig)));
        list.into_iter()
            .map(|problem| problem.what)
            .filter(|what| !what.contains("measured"))
            .collect::<Vec<_>>()
    };
    let path = Path::new(&[[0.0; 3], [0.15, 0.1, 0.0]], 0.6, Timing::Linear).unwrap();
    let bursts = Stroke::new(&array(&rig), &path).unwrap().bursts;
    let at_once = |t: f64| bursts.iter().filter(|b| b.start <= t && t < b.start + b.seconds()).count();
    let most = bursts.iter().map(|burst| at_once(burst.start)).max().unwrap() as u32;
    let longest = bursts.iter().map(|burst| burst.seconds()).fold(0.0, f64::max);
    assert!(most > 1 && told(most, longest).is_empty(), "{:?}", told(most, longest));
    let crowded = told(most - 1, 0.005);
    assert!(crowded.len() == 1 && crowded[0].contains(&format!("{most} of its bursts sound")), "{crowded:?}");
    let slow = told(most, longest + 1e-3);
    assert!(slow.len() == 1 && slow[0].contains("`attack` of node `edge`"), "{slow:?}");
}

/// Paths that pass tactors faster than the band lets them sound, or that have hardly begun when the event is over.
#[test]
fn paths_that_are_not_felt_as_written_are_told() {
    let rig = grid(1, 4);
    let told = |event: &str| {
        let patch = patch(&text("", "0", &format!("{{ at = 0, voice = \"v\", {event} }}")));
        quick::advice(&patch, Some(&array(&rig))).into_iter().map(|problem| problem.what).collect::<String>()
    };
    // 0.15 m over tactors 50 mm apart: 2000 of them a second are passed at 100 m/s.
    assert_eq!(told("place = { path = [[0, 0], [0.15, 0]], over = 0.00151 }"), "");
    assert!(told("place = { path = [[0, 0], [0.15, 0]], over = 0.00149 }").contains("at up to 100.671 m/s"));
    assert_eq!(told("place = { path = [[0, 0], [0.15, 0]], over = 0.0023, timing = \"smooth\" }"), "");
    assert!(
        told("place = { path = [[0, 0], [0.15, 0]], over = 0.0022, timing = \"smooth\" }")
            .contains("passes 2045")
    );
    assert!(told("duration = 0.0014, place = { path = [[0, 0], [0.15, 0]] }").contains("felt weaker"));
    let times = |from: f64| {
        format!("duration = 1, place = {{ path = [[0, 0], [0.15, 0]], times = [{from}, {}] }}", from + 5.0)
    };
    assert_eq!(told(&times(0.9)), "");
    assert!(
        told(&times(0.96)).contains("hardly moves") && told(&times(5.0)).contains("takes from 5 to 10 s")
    );
    assert_eq!(told("place = { path = [[0, 0], [0.15, 0]], over = 10 }, duration = 0.2"), "");
    assert!(told("place = { path = [[0, 0], [0.15, 0]], over = 1000 }, duration = 0.2").contains("hardly"));
}

/// A patch of millions of bursts is refused where it passes the limit, not when memory is gone.
#[test]
fn too_many_bursts_are_refused_at_their_line() {
    let event = format!("saltation = {{ places = [{}], taps = 100 }}", ["1, 2"; 20].join(", "));
    let events: String = (0..251).map(|at| format!("{{ at = {at}, voice = \"v\", {event} }},\n")).collect();
    let rig = grid(1, 2);
    let problems = scene(&patch(&text("", "0", &events)), &rig, &Options::default(), &NoAssets);
    let built = problems.and_then(|_| {
        Player::new(&patch(&text("", "0", &events)), &rig, &Options::default(), &NoAssets).map(drop)
    });
    let said = built.unwrap_err().to_string();
    assert!(said.contains("more than 1000000 bursts, up to here"), "{said}");
}

/// No tactor has a position: a stroke is nowhere, steps from one to the other are somewhere.
#[test]
fn a_stroke_needs_positions_and_steps_do_not() {
    let mut rig = grid(1, 3);
    rig.outputs.iter_mut().for_each(|output| output.position = None);
    let lacks = |event: &str| {
        let list = rig.check_places(&patch(&text("", "0", event)));
        list.into_iter().map(|problem| problem.what).collect::<Vec<_>>().join("\n")
    };
    let stroke = lacks("{ at = 0, voice = \"v\", stroke = { path = [[0, 0], [0.1, 0]], over = 1 } }");
    assert!(stroke.contains("no tactor of the rig has a position"), "{stroke}");
    assert_eq!(lacks("{ at = 0, voice = \"v\", apparent = { places = [1, 2, 3], burst = 0.1 } }"), "");
    let nobody = lacks("{ at = 0, voice = \"v\", saltation = { places = [1, \"nobody\"] } }");
    assert!(nobody.contains("no tactor `nobody`"), "{nobody}");
}
