//! What a session's callback takes of a core: a block again and again, and a block after a pause, as a sound card asks for it, when
//! whatever ran meanwhile has the caches. Then the demo, with its patterns, which in a session another thread feeds.
//!
//! `cargo bench --bench callback`. CPU time of this thread; the clock's own share is taken off.

use pacinian::space::spot::Spot;
use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::io::assets::Folder;
use pacinian::live::board::Board;
use pacinian::live::callback::Callback;
use pacinian::live::gate::Gate;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::player::Player;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const RATE: f64 = 48_000.0;
const CHANNELS: usize = 16;
const VOICES: u32 = 32;

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "A bench"
[voice.v]
voices = 32
output = "out"
[voice.v.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit = { type = "envelope", attack = 0.01, decay = 0.1, sustain = 0.7, release = 0.05 }
out = { type = "multiply", inputs = ["tone", "hit"] }
"#;

/// A callback with all voices sounding, behind an open gate.
fn callback(board: &Arc<Board>) -> Callback {
    let patch = Patch::parse("bench.toml", PATCH.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let rig = Rig::default_for(CHANNELS as u32);
    let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    let (_, mut stagehand) = exchange(&scene.plan).unwrap_or_else(|why| panic!("{why}"));
    for voice in 0..VOICES {
        let mut own = [0.0; FIELDS];
        own[0] = 60.0 + 17.0 * f64::from(voice);
        let (place, id) = (voice % CHANNELS as u32, u64::from(voice));
        let play = Play {
            instrument: 0,
            place: Spot::Row(place),
            level: 0.3,
            felt: None,
            duration: f64::INFINITY,
            own,
            id,
        };
        assert!(stagehand.engine().schedule(Instant::default(), Source::Program, Event::Play(play)));
    }
    board.lever.open();
    let (mut callback, _) = Callback::new(stagehand, Gate::new(RATE, 1.0), Arc::clone(board));
    // Behind the ramp of the beginning.
    (0..20).for_each(|_| callback.process(&[], &mut vec![0.0; CHANNELS * 960]));
    callback
}

/// Microseconds of each of so many calls, after a pause of so long before each; what the clock itself takes is taken off.
fn times_in_order(calls: usize, pause: Duration, mut call: impl FnMut()) -> Vec<f64> {
    let timed = |call: &mut dyn FnMut()| {
        if !pause.is_zero() {
            std::thread::sleep(pause);
        }
        let begin = ThreadTime::now();
        call();
        begin.elapsed().as_secs_f64() * 1e6
    };
    // By turns, since a clock that rested takes longer, too.
    let (times, mut clock): (Vec<f64>, Vec<f64>) =
        (0..calls).map(|_| (timed(&mut call), timed(&mut || ()))).unzip();
    clock.sort_by(f64::total_cmp);
    let clock = clock[calls / 2];
    times.iter().map(|time| time - clock).collect()
}

/// The same, rising.
fn times(calls: usize, pause: Duration, call: impl FnMut()) -> Vec<f64> {
    let mut times = times_in_order(calls, pause, call);
    times.sort_by(f64::total_cmp);
    times
}

/// One that begins to play `pacinian demo`.
fn demo() -> Player {
    let read = |path: &str| std::fs::read(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let patch = Patch::parse("demo.toml", &read("patches/demo.toml")).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::parse("demo-16.toml", &read("rigs/demo-16.toml")).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let folder = Folder::new(concat!(env!("CARGO_MANIFEST_DIR"), "/patches"));
    Player::new(&patch, &rig, &options, &folder).unwrap_or_else(|p| panic!("{p}"))
}

/// Microseconds of the blocks of the demo's 20 s, in their order, after a pause of so long before each.
fn demo_times(block: usize, pause: Duration) -> Vec<f64> {
    let (mut player, mut frames) = (demo(), vec![0.0_f32; CHANNELS * block]);
    let mut loudest = 0.0_f32;
    let times = times_in_order(20 * RATE as usize / block, pause, || {
        player.process(&mut frames);
        loudest = frames.iter().fold(loudest, |most, x| most.max(x.abs()));
    });
    assert!(loudest > 0.1, "it sounds");
    times
}

fn main() {
    println!(
        "{VOICES} voices of sine x envelope on {CHANNELS} tactors at 48 kHz: microseconds a callback, and share of a core"
    );
    println!("{:>6}  {:>24}  {:>34}", "block", "again and again: median", "after a pause: median, 99.9 %");
    for block in [64, 128, 256, 4096] {
        let period = block as f64 / RATE;
        let board = Arc::new(Board::new(CHANNELS));
        let mut callback = callback(&board);
        let mut frames = vec![0.0_f32; CHANNELS * block];
        let mut call = || callback.process(&[], &mut frames);
        let warm = times(20_000_000 / (block * 64), Duration::ZERO, &mut call);
        // Ten seconds of them at most.
        let calls = 2_000.min((10.0 / period) as usize);
        let cold = times(calls, Duration::from_secs_f64(period), &mut call);
        assert!(frames.iter().any(|x| x.abs() > 0.01), "it sounds");
        let shown = |time: f64| format!("{time:.2} us {:.2} %", time / period * 1e-4);
        let (middle, most) = (cold[cold.len() / 2], cold[cold.len() - 2]);
        println!(
            "{block:>6}  {:>24}  {:>34}",
            shown(warm[warm.len() / 2]),
            format!("{}, {}", shown(middle), shown(most))
        );
    }
    println!(
        "\nthe demo in blocks of 64, with what feeds its patterns: microseconds a block, and share of a core"
    );
    let period = 64.0 / RATE;
    for (how, pause) in
        [("again and again", Duration::ZERO), ("after a pause", Duration::from_secs_f64(period))]
    {
        let runs: Vec<Vec<f64>> = (0..3).map(|_| demo_times(64, pause)).collect();
        // The same block does the same work in each run: what the machine takes away takes it from one of them.
        let mut least: Vec<f64> =
            (0..runs[0].len()).map(|n| runs.iter().map(|run| run[n]).fold(f64::INFINITY, f64::min)).collect();
        let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
        let (all, undisturbed) = (mean(&runs.concat()), mean(&least));
        least.sort_by(f64::total_cmp);
        let shown = |time: f64| format!("{time:.2} us {:.2} %", time / period * 1e-4);
        println!(
            "{how:>15}: mean {}; each at its least of three runs: mean {}, median {}",
            shown(all),
            shown(undisturbed),
            shown(least[least.len() / 2])
        );
    }
}
