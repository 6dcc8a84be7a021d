//! What a session's callback takes of a core: a block again and again, and a block after a pause, as a sound card asks for it, when
//! whatever ran meanwhile has the caches.
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
use pacinian::live::board::Board;
use pacinian::live::callback::Callback;
use pacinian::live::gate::Gate;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
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

/// Microseconds of each of so many calls, after a pause of so long before each, rising; what the clock itself takes is taken off.
fn times(calls: usize, pause: Duration, mut call: impl FnMut()) -> Vec<f64> {
    let timed = |call: &mut dyn FnMut()| {
        if !pause.is_zero() {
            std::thread::sleep(pause);
        }
        let begin = ThreadTime::now();
        call();
        begin.elapsed().as_secs_f64() * 1e6
    };
    // By turns, since a clock that rested takes longer, too.
    let (mut times, mut clock): (Vec<f64>, Vec<f64>) =
        (0..calls).map(|_| (timed(&mut call), timed(&mut || ()))).unzip();
    times.sort_by(f64::total_cmp);
    clock.sort_by(f64::total_cmp);
    let clock = clock[calls / 2];
    times.iter().map(|time| time - clock).collect()
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
        let cold = times(2_000, Duration::from_secs_f64(period), &mut call);
        assert!(frames.iter().any(|x| x.abs() > 0.01), "it sounds");
        let shown = |time: f64| format!("{time:.2} us {:.2} %", time / period * 1e-4);
        let (middle, most) = (cold[cold.len() / 2], cold[cold.len() - 2]);
        println!(
            "{block:>6}  {:>24}  {:>34}",
            shown(warm[warm.len() / 2]),
            format!("{}, {}", shown(middle), shown(most))
        );
    }
}
