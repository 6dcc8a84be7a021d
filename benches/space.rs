//! What it costs to move: `cargo bench --bench space`.
//!
//! The least of many short runs, which is what the machine does when nothing else disturbs it.

use std::hint::black_box;
use std::time::Instant as Wall;

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

const RATE: f64 = 48_000.0;
/// Frames of a run.
const FRAMES: usize = 480;

fn main() {
    println!(
        "64 voices (a sine with an envelope each), 48 kHz; grids of 30 mm, cells crossed as the speed says"
    );
    for (rows, columns) in [(8, 8), (16, 16)] {
        let tactors = rows * columns;
        let still = takes(&plan(rows, columns, &still(rows, columns)), 64);
        println!(
            "{tactors:4} tactors  at points           {:6.2} us a ms   {:6.0} x real time",
            still * 1e6,
            1e-3 / still
        );
        for speed in [0.1, 1.0, 5.0, 50.0] {
            let moved = takes(&plan(rows, columns, &path(rows, columns, speed)), 64);
            println!(
                "{tactors:4} tactors  paths, {speed:4} m/s    {:6.2} us a ms   {:6.0} x real time   {:.2} times",
                moved * 1e6,
                1e-3 / moved,
                moved / still
            );
        }
        let steered = takes(&plan(rows, columns, STEERED), 64);
        println!(
            "{tactors:4} tactors  nodes, 0.6 m/s      {:6.2} us a ms   {:6.0} x real time   {:.2} times",
            steered * 1e6,
            1e-3 / steered,
            steered / still
        );
    }
    for (rows, columns) in [(8, 8), (16, 16)] {
        let one = |voice: &str| takes(&plan(rows, columns, voice), 1);
        let (fixed, moving) = (one(&still(rows, columns)), one(&path(rows, columns, 1.0)));
        println!(
            "{:4} tactors, one voice  {:.3} us a ms at a point, {:.3} on a path at 1 m/s   {:.2} times",
            rows * columns,
            fixed * 1e6,
            moving * 1e6,
            moving / fixed
        );
    }
}

const STEERED: &str = "[voice.v.nodes]\nsway = { type = \"sine\", frequency = 1 }\n\
                       here = { type = \"place\", x = \"0.1 + 0.1 * sway\", y = 0.1 }\n";

fn still(rows: usize, columns: usize) -> String {
    format!("place = [{}, {}]\n[voice.v.nodes]\n", 0.017 * columns as f64, 0.013 * rows as f64)
}

/// From corner to corner and back, for ever.
fn path(rows: usize, columns: usize, speed: f64) -> String {
    let (x, y) = (0.03 * (columns - 1) as f64, 0.03 * (rows - 1) as f64);
    let leg = (x * x + y * y).sqrt() / speed;
    let count = ((60.0 / leg) as usize).clamp(2, 20_000);
    let point = |n: usize| if n.is_multiple_of(2) { "[0.0, 0.0]".into() } else { format!("[{x}, {y}]") };
    let points: Vec<String> = (0..count).map(point).collect();
    let times: Vec<String> = (0..count).map(|n| (n as f64 * leg).to_string()).collect();
    format!("place = {{ path = [{}], times = [{}] }}\n[voice.v.nodes]\n", points.join(", "), times.join(", "))
}

fn plan(rows: usize, columns: usize, voice: &str) -> Plan {
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"out\"\nvoices = 64\n{voice}\
         tone = {{ type = \"sine\", frequency = \"event.frequency\", amplitude = 0.02 }}\n\
         edge = {{ type = \"envelope\", attack = 0.01 }}\nout = {{ type = \"multiply\", inputs = [\"tone\", \"edge\"] }}\n"
    );
    let patch = Patch::parse("bench", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let mut rig = Rig::default_for((rows * columns) as u32);
    for (n, output) in rig.outputs.iter_mut().enumerate() {
        output.position = Some([0.03 * (n % columns) as f64, 0.03 * (n / columns) as f64, 0.0]);
    }
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Seconds for a millisecond of so many voices.
fn takes(plan: &Plan, voices: u64) -> f64 {
    let mut engine = Engine::new(plan).unwrap_or_else(|why| panic!("{why}"));
    let play = plan.play("v", &[]).unwrap_or_else(|why| panic!("{why}"));
    for id in 0..voices {
        let mut own = play.own;
        own[0] = 60.0 + 3.0 * id as f64;
        // Points that do not all share tactors.
        let place = match play.place {
            Spot::Point([x, y, z]) => {
                Spot::Point([x + 0.0023 * (id % 8) as f64, y + 0.0031 * (id / 8) as f64, z])
            }
            other => other,
        };
        let play = Play { place, own, id, duration: f64::INFINITY, ..play };
        // One after the other, so that not all cross at once.
        engine.schedule(Instant::of_samples(17.3 * id as f64), Source::Program, Event::Play(play));
    }
    let mut frames = vec![0.0; FRAMES * engine.channels()];
    (0..20).for_each(|_| engine.process(&mut frames));
    let least = (0..60)
        .map(|_| {
            let begin = Wall::now();
            (0..10).for_each(|_| engine.process(&mut frames));
            black_box(&frames);
            begin.elapsed().as_secs_f64() / 10.0
        })
        .fold(f64::INFINITY, f64::min);
    least * RATE / FRAMES as f64 * 1e-3
}
