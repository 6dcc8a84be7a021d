//! Run time of whole scenes, as CPU time of this thread, beside a peer on the same scene in the same run.
//!
//! `cargo bench --bench engine` prints a table. Every figure is the median of many windows; peer and engine take turns, so that
//! a change of the machine's speed meets both.

use pacinian::space::spot::Spot;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use pacinian::dsp::isa::Isa;
use pacinian::engine::Engine;
use pacinian::engine::bank::Bank;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::workspace::Workspace;
use pacinian::graph::plan::{Plan, compile};
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::graph::{Graph, Node, Wire};
use pacinian::node::NodeKind;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const RATE: f64 = 48_000.0;
const BLOCK: usize = 64;

/// Median CPU nanoseconds a call of each of `work` takes, taking turns.
fn turns(work: &mut [&mut dyn FnMut()], calls: usize) -> Vec<f64> {
    let mut times = vec![Vec::new(); work.len()];
    for _ in 0..41 {
        for (work, times) in work.iter_mut().zip(&mut times) {
            let begin = ThreadTime::now();
            for _ in 0..calls {
                work();
            }
            times.push(begin.elapsed().as_nanos() as f64 / calls as f64);
        }
    }
    times
        .into_iter()
        .map(|mut t| {
            t.sort_by(f64::total_cmp);
            t[t.len() / 2]
        })
        .collect()
}

fn plan(voice: &str, voices: usize, channels: u32) -> Plan {
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"A bench\"\n[voice.v]\nvoices = {voices}\noutput = \"out\"\n[voice.v.nodes]\n{voice}"
    );
    let patch = Patch::parse("bench.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch, &Rig::default_for(channels), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

const SINE: &str = r#"tone = { type = "sine", frequency = "event.frequency" }
hit = { type = "envelope", attack = 0.01, decay = 0.1, sustain = 0.7, release = 0.05 }
out = { type = "multiply", inputs = ["tone", "hit"] }"#;

fn start(engine: &mut Engine, voices: usize, channels: usize, level: f64) {
    for i in 0..voices {
        let mut own = [0.0; FIELDS];
        own[0] = 60.0 + 700.0 * i as f64 / voices as f64;
        let play = Play {
            felt: None,
            instrument: 0,
            place: Spot::Row((i % channels) as u32),
            level,
            duration: f64::INFINITY,
            own,
            id: i as u64,
        };
        assert!(engine.schedule(Instant::default(), Source::Program, Event::Play(play)));
    }
}

fn engine(voices: usize, channels: usize, level: f64) -> Engine {
    engine_on(Isa::detect(), voices, channels, level)
}

fn engine_on(isa: Isa, voices: usize, channels: usize, level: f64) -> Engine {
    let mut engine = Engine::with_isa(&plan(SINE, voices, channels as u32), isa).unwrap();
    start(&mut engine, voices, channels, level);
    let mut warm = vec![0.0; 4800 * channels];
    engine.process(&mut warm);
    engine
}

/// The same scene in fundsp's `Net`: 32 sines by envelopes, placed on 16 outputs.
fn net(voices: usize, channels: usize, level: f32) -> fundsp::net::Net {
    use fundsp::prelude32::{envelope, pass, sine_hz};
    let mut net = fundsp::net::Net::new(0, channels);
    let mut sums: Vec<Option<fundsp::net::NodeId>> = vec![None; channels];
    for i in 0..voices {
        let hertz = 60.0 + 700.0 * i as f32 / voices as f32;
        let shape = move |t: f32| {
            level
                * if t < 0.01 {
                    t / 0.01
                } else if t < 0.11 {
                    1.0 - 3.0 * (t - 0.01)
                } else {
                    0.7
                }
        };
        let voice = net.push(Box::new(sine_hz(hertz) * envelope(shape)));
        let channel = i % channels;
        sums[channel] = Some(match sums[channel] {
            None => voice,
            Some(before) => {
                let sum = net.push(Box::new(pass() + pass()));
                net.connect(before, 0, sum, 0);
                net.connect(voice, 0, sum, 1);
                sum
            }
        });
    }
    for (channel, node) in sums.into_iter().enumerate() {
        if let Some(node) = node {
            net.connect_output(node, 0, channel);
        }
    }
    net.set_sample_rate(RATE);
    net.allocate();
    net
}

use fundsp::audiounit::AudioUnit;
use fundsp::buffer::BufferVec;

fn against_net(isa: Isa, block: usize) {
    let (voices, channels) = (32, 16);
    let mut ours = engine_on(isa, voices, channels, 0.45);
    let mut frames = vec![0.0; block * channels];
    let mut net = net(voices, channels, 0.45);
    let input = BufferVec::new(0);
    let mut output = BufferVec::new(channels);
    let mut sum = 0.0;
    let times = turns(
        &mut [
            &mut || {
                ours.process(&mut frames);
                sum += black_box(frames[5]);
            },
            &mut || {
                for _ in 0..block / BLOCK {
                    net.process(BLOCK, &input.buffer_ref(), &mut output.buffer_mut());
                    black_box(&output);
                }
            },
        ],
        25_600 / block,
    );
    let frame = |ns: f64| ns / block as f64;
    println!(
        "32 voices on 16 outputs, {isa:8?}, blocks of {block:5}  pacinian {:6.2} ns a frame   fundsp Net {:6.2}   ratio {:.1}",
        frame(times[0]),
        frame(times[1]),
        times[1] / times[0]
    );
}

fn channel_samples(voices: usize, channels: usize, level: f64, block: usize, name: &str) {
    let mut engine = engine(voices, channels, level);
    let mut room = vec![0.0_f32; block * channels + 16];
    // On a cache line, as drivers' buffers are.
    let begin = room.as_ptr().align_offset(64);
    let frames = &mut room[begin..][..block * channels];
    let times = turns(
        &mut [&mut || {
            engine.process(frames);
            black_box(&*frames);
        }],
        (2_500_000 / (channels * block)).max(2),
    );
    let second = times[0] / block as f64 * RATE;
    println!(
        "{name:43} {:6.3} ns a channel-sample   {:.0} x real time",
        times[0] / (block * channels) as f64,
        1e9 / second
    );
}

fn asleep() {
    let plan = plan(SINE, 256, 16);
    let mut silent = Engine::new(&plan).unwrap();
    let mut busy = Engine::new(&plan).unwrap();
    start(&mut busy, 256, 16, 0.05);
    let mut frames = vec![0.0; BLOCK * 16];
    let mut other = frames.clone();
    let times = turns(&mut [&mut || silent.process(&mut frames), &mut || busy.process(&mut other)], 200);
    println!(
        "256 voices, none sounding / all sounding    {:6.2} / {:.2} ns a frame   {:.2} %",
        times[0] / BLOCK as f64,
        times[1] / BLOCK as f64,
        100.0 * times[0] / times[1]
    );
}

/// The same without the output stage.
fn asleep_without_stage() {
    let plan = plan(SINE, 256, 16);
    let rate = plan.engine_rate();
    let pool = |sounding: usize| {
        let mut bank = Bank::<f32>::new(
            &plan.instruments[0],
            (&plan.paths.as_slice().into(), &plan.gauges),
            rate,
            plan.seed,
            2,
            Isa::detect(),
        );
        for i in 0..sounding {
            let mut own = [0.0; FIELDS];
            own[0] = 60.0 + 2.0 * i as f64;
            let id = i as u64;
            let play = Play {
                instrument: 0,
                place: Spot::Row(0),
                level: 0.05,
                felt: None,
                duration: f64::INFINITY,
                own,
                id,
            };
            bank.start(&play, Instant::default(), 0, &[(i as u32 % 16, 1.0)], id);
        }
        (bank, Workspace::new(plan.instruments[0].program.buffers + 1, 0, 16), 0)
    };
    let samples = 10;
    let run = |(bank, work, clock): &mut (Bank<f32>, Workspace<f32>, u64)| {
        work.clear_mix(samples);
        bank.run(work, samples, 0, *clock);
        black_box(&work.mix);
        *clock += samples as u64;
        if clock.is_multiple_of(320) {
            bank.settle(*clock);
        }
    };
    let (mut silent, mut busy) = (pool(0), pool(256));
    let times = turns(&mut [&mut || run(&mut silent), &mut || run(&mut busy)], 400);
    let frame = |ns: f64| ns / (samples * plan.ratio) as f64;
    println!(
        "the same, voices and mix alone              {:6.2} / {:.2} ns a frame   {:.2} %",
        frame(times[0]),
        frame(times[1]),
        100.0 * times[0] / times[1]
    );
}

/// Compiles a mixer of 512 nodes, and a chain that would overflow a stack that followed it.
fn compiling() {
    let node = |name: &str, inputs| Node {
        name: "node".into(),
        kind: NodeKind::find(name).unwrap(),
        settings: Arc::default(),
        inputs,
    };
    let sine = |hertz| node("sine", vec![Wire::constant(hertz), Wire::constant(0.0), Wire::constant(1.0)]);
    let mut nodes = vec![sine(50.0)];
    for i in 0..255 {
        let last = nodes.len() as u32 - 1;
        nodes.push(sine(60.0 + f64::from(i)));
        nodes.push(node("multiply", vec![Wire::node(last), Wire::node(last + 1)]));
    }
    nodes.push(node("clip", vec![Wire::node(510), Wire::constant(-1.0), Wire::constant(1.0)]));
    let graph = |nodes: &[Node]| Graph {
        nodes: nodes.to_vec(),
        outputs: vec![Wire::node(nodes.len() as u32 - 1)],
        ..Graph::default()
    };
    let mut chain = vec![sine(50.0)];
    for i in 0..199_999 {
        chain.push(node("multiply", vec![Wire::node(i), Wire::node(i)]));
    }
    for (nodes, ops, turns) in [(&nodes, 257, 101), (&chain, 200_000, 3)] {
        let mut times = Vec::new();
        for _ in 0..turns {
            let graph = graph(nodes);
            let begin = ThreadTime::now();
            let compiled = compile(graph, true, 8_000.0);
            times.push(begin.elapsed().as_secs_f64());
            assert_eq!(black_box(compiled).map(|c| c.program.ops.len()), Ok(ops));
        }
        times.sort_by(f64::total_cmp);
        println!("compiling {:7} nodes                     {:8.3} ms", nodes.len(), 1e3 * times[turns / 2]);
    }
}

fn main() {
    let begin = std::time::Instant::now();
    if let Some(which) = std::env::args().nth(1).filter(|w| w.starts_with("only")) {
        for _ in 0..20 {
            match which.as_str() {
                "only24" => channel_samples(24, 24, 0.3, 4096, "24"),
                "only16big" => channel_samples(32, 16, 0.3, 4096, "16 big"),
                "only16" => channel_samples(32, 16, 0.3, 64, "16"),
                "onlynet" => against_net(Isa::detect(), 64),
                "only1024" => channel_samples(1024, 1024, 0.3, 64, "1024"),
                _ => asleep(),
            }
        }
        return;
    }
    for block in [64, 4096] {
        against_net(Isa::detect(), block);
    }
    against_net(Isa::Baseline, 64);
    channel_samples(24, 24, 0.3, BLOCK, "24 channels, sine x ASR, level 0.3");
    channel_samples(24, 24, 0.3, 4096, "the same in blocks of 4,096");
    channel_samples(24, 24, 0.95, 4096, "the same at level 0.95");
    channel_samples(1024, 1024, 0.3, BLOCK, "1,024 voices on 1,024 channels");
    asleep();
    asleep_without_stage();
    compiling();
    eprintln!("{:.0} s", begin.elapsed().max(Duration::from_secs(1)).as_secs_f64());
}
