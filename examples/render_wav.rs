//! A patch with a pattern, rendered to a WAV file with a channel for each tactor.
//!
//! Run it with `cargo run --example render_wav`, or `cargo run --example render_wav -- there.wav` to keep the file.

use std::error::Error;
use std::path::PathBuf;

use pacinian::io::wav::{Encoding, WavReader, WavSpec, WavWriter};
use pacinian::{NoAssets, Options, Patch, Player, Rig};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title  = "Up the arm"

[voice.step]
output = "felt"
[voice.step.nodes]
tone = { type = "sine", frequency = 180 }
hit  = { type = "envelope", attack = 0.02, release = 0.05 }
felt = { type = "multiply", inputs = ["tone", "hit"] }

[pattern.up]
events = [
  { at = 0.0, voice = "step", duration = 0.1, place = "t1" },
  { at = 0.1, voice = "step", duration = 0.1, place = "t2" },
  { at = 0.2, voice = "step", duration = 0.1, place = "t3" },
  { at = 0.3, voice = "step", duration = 0.1, place = "t4" },
]
repeat = { every = 0.6, times = 3 }
"#;

const CHANNELS: usize = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let kept = std::env::args_os().nth(1).map(PathBuf::from);
    let path = kept.clone().unwrap_or_else(|| {
        std::env::temp_dir().join(format!("pacinian-render-wav-{}.wav", std::process::id()))
    });

    let patch = Patch::parse("arm.toml", PATCH.as_bytes())?.value;
    let rig = Rig::default_for(CHANNELS as u32);
    let mut player = Player::new(&patch, &rig, &Options::default(), &NoAssets)?;
    let rate = player.plan().device_rate as u32;
    let mut writer = WavWriter::create(&path, WavSpec::new(CHANNELS, rate, Encoding::F32))?;
    let mut block = vec![0.0_f32; CHANNELS * 480];
    while !player.is_over() {
        player.process(&mut block);
        writer.write(&block)?;
    }
    let written = writer.finish()?;

    // What stands in the file, read back.
    let channels = WavReader::open(&path)?.channels()?;
    let seconds = written.frames as f64 / f64::from(rate);
    let peaks: Vec<String> = channels.iter().map(|c| format!("{:.2}", peak(c))).collect();
    println!(
        "{seconds:.2} s on {} channels, {} voices, peaks {}",
        channels.len(),
        started(&player),
        peaks.join(" ")
    );
    assert_eq!(channels.len(), CHANNELS);
    assert!(channels.iter().all(|c| c.len() as u64 == written.frames && peak(c) > 0.5));

    match kept {
        Some(path) => println!("wrote {}", path.display()),
        None => std::fs::remove_file(&path)?,
    }
    Ok(())
}

fn started(player: &Player) -> u64 {
    player.counters().started
}

fn peak(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |peak, x| peak.max(x.abs()))
}
