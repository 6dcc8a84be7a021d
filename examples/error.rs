//! Error against run time: the same scene with several settings, each compared with the scene reference, which computes every
//! node from its definition in 64 bits at 16 times the engine's rate.
//!
//! Run it with `cargo run --release --example error`.

use std::error::Error;

use pacinian::graph::plan::Precision;
use pacinian::graph::scene::{Options, scene};
use pacinian::report::measure;
use pacinian::{NoAssets, Patch, Player, Rig};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title  = "Short taps between the samples"

[voice.tap]
output = "felt"
[voice.tap.nodes]
tone = { type = "triangle", frequency = "event.frequency" }
hit  = { type = "envelope", attack = 0.002, decay = 0.05, sustain = 0.3, release = 0.01 }
felt = { type = "multiply", inputs = ["tone", "hit", 0.5] }

[pattern.taps]
events = [
  { at = 0.01003, voice = "tap", duration = 0.1, place = "t1", frequency = 61 },
  { at = 0.12347, voice = "tap", duration = 0.1, place = "t2", frequency = 118 },
  { at = 0.25071, voice = "tap", duration = 0.1, place = "t1", frequency = 243 },
]
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let patch = Patch::parse("taps.toml", PATCH.as_bytes())?.value;
    let rig = Rig::default_for(2);

    // What the pattern plays, written down once, so that every setting plays the same.
    let mut player = Player::new(&patch, &rig, &Options::default(), &NoAssets)?;
    player.record();
    let mut block = vec![0.0_f32; 2 * 480];
    while !player.is_over() {
        player.process(&mut block);
    }

    println!("numbers  taps  error, 0 to 1 kHz  power above 1 kHz  times real time");
    for (name, precision) in [("f32", Precision::Single), ("f64", Precision::Double)] {
        for taps in [4, 6, 8] {
            let options = Options { precision, taps, ..Options::default() };
            let plan = scene(&patch, &rig, &options, &NoAssets)?.plan;
            let measured = measure(&plan, player.recorded(), player.seconds())?;
            let (error, above) = (measured.comparison.error_db, measured.comparison.above_db);
            let speed = measured.seconds / measured.run_time.as_secs_f64();
            println!("{name:7}  {taps:4}  {error:14.1} dB  {above:14.1} dB  {speed:15.0}");
            assert!(error < -60.0 && above < -40.0, "{name}, {taps} taps: {error} dB, {above} dB");
        }
    }
    Ok(())
}
