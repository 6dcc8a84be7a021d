//! Cost of the vibration stage a channel-sample at the device's rate: `cargo bench --bench output`.
//!
//! The least of many short runs, which is what the machine does when nothing else disturbs it.

use pacinian::dsp::isa::Isa;
use pacinian::engine::vibration::{Options, Row, Vibration};
use std::time::Instant;

const FRAMES: usize = 64;

fn main() {
    for (channels, rate) in [(24, 48_000.0), (16, 48_000.0), (1024, 48_000.0), (24, 192_000.0)] {
        for (name, level, limiter) in [
            ("limiter off", 0.3, false),
            ("level 0.3", 0.3, true),
            ("level 0.95", 0.95, true),
            ("level 4", 4.0, true),
        ] {
            println!(
                "{channels:5} channels {rate:7} Hz  {name:12} {:.3} ns",
                cost(channels, rate, level, limiter)
            );
        }
    }
}

fn cost(channels: usize, rate: f64, level: f32, limiter: bool) -> f64 {
    let options = Options { limiter, isa: Isa::detect(), ..Options::default() };
    let Ok(mut stage) = Vibration::new(channels, rate, &options) else { return f64::NAN };
    let groups = stage.groups();
    let blocks: Vec<Vec<Row>> = (0..4)
        .map(|block| {
            (0..groups * FRAMES)
                .map(|i| {
                    let n = (block * FRAMES + i % FRAMES) as f32;
                    std::array::from_fn(|l| {
                        let hertz = 1000.0 / 32.0 * (2 + (i / FRAMES * 8 + l) % 12) as f32;
                        level * (std::f32::consts::TAU * hertz / 8000.0 * n).sin()
                    })
                })
                .collect()
        })
        .collect();
    let length = FRAMES * stage.ratio() * channels;
    let mut store = vec![0.0f32; length + 16];
    let shift = store.as_ptr().align_offset(64).min(16);
    let out = &mut store[shift..shift + length];
    let mut rows = blocks[0].clone();
    let (mut clock, mut least) = (0, f64::INFINITY);
    for run in 0..1600 {
        let start = Instant::now();
        for block in &blocks {
            rows.copy_from_slice(block);
            std::hint::black_box(stage.process(FRAMES, &mut rows, &[], clock, out));
            std::hint::black_box(&mut *out);
            clock += FRAMES as u64;
        }
        let each = start.elapsed().as_secs_f64() / (blocks.len() * out.len()) as f64;
        if run > 20 {
            least = least.min(each);
        }
    }
    least * 1e9
}
