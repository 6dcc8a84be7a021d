//! Makes the recordings that the patches play: textures and a short groove, computed from nothing but numbers.
//!
//! ```console
//! cargo run --example recordings -- patches/recordings
//! ```
//!
//! Without a folder it writes to a temporary one. Everything is below 1 kHz in essence, mono, 16 bit, 8 kHz.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use pacinian::io::wav::{Encoding, WavSpec, WavWriter};

/// Frames a second.
const RATE: f64 = 8000.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("pacinian"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    write(&folder, "corduroy", "Corduroy", &around(&corduroy()))?;
    write(&folder, "felt", "Felt", &around(&felt()))?;
    write(&folder, "groove", "Groove", &groove())?;
    Ok(())
}

/// Writes samples, brought to a peak of 0.9.
fn write(folder: &Path, name: &str, title: &str, samples: &[f64]) -> Result<(), Box<dyn std::error::Error>> {
    let path = folder.join(format!("{name}.wav"));
    let most = samples.iter().fold(1e-9_f64, |most, x| most.max(x.abs()));
    let samples: Vec<f32> = samples.iter().map(|x| (0.9 * x / most) as f32).collect();
    let spec = WavSpec { title: title.into(), ..WavSpec::new(1, RATE as u32, Encoding::I16) };
    let mut writer = WavWriter::create(&path, spec)?;
    writer.write(&samples)?;
    let written = writer.finish()?;
    println!("{}: {} frames", path.display(), written.frames);
    Ok(())
}

/// Numbers from 0 to 1 that look random and never change (Marsaglia, xorshift, 2003).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// What repeats, with 50 ms of its end before it and 50 ms of its beginning after it: so that at both ends of the loop, which lie
/// within, a filter finds what it would find going round.
fn around(samples: &[f64]) -> Vec<f64> {
    let more = (0.05 * RATE) as usize;
    [&samples[samples.len() - more..], samples, &samples[..more]].concat()
}

/// Cloth with ridges: 64 of them in 1.6 s, each a push and a pull of the skin, no two alike. Its end fits its beginning.
fn corduroy() -> Vec<f64> {
    let (length, ridges, width) = (12_800_usize, 64, 0.0016 * RATE);
    let mut dice = Dice(0x00C0_FFEE);
    let mut samples = vec![0.0; length];
    for ridge in 0..ridges {
        let spacing = length as f64 / f64::from(ridges);
        let centre = (f64::from(ridge) + 0.25 * (dice.roll() - 0.5)) * spacing;
        let height = 0.6 + 0.4 * dice.roll();
        for n in -80_i64..80 {
            let place = centre.floor() as i64 + n;
            let x = (place as f64 - centre) / width;
            samples[place.rem_euclid(length as i64) as usize] -= height * x * (-0.5 * x * x).exp();
        }
    }
    samples
}

/// Cloth without a pattern: 1.6 s of 560 sines between 40 and 390 Hz at random phases, softer the higher. Its end fits its beginning.
fn felt() -> Vec<f64> {
    let length = 12_800_usize;
    let mut dice = Dice(0x5EED);
    let mut samples = vec![0.0; length];
    for cycles in 64..624 {
        let (phase, level) = (dice.roll(), (64.0 / f64::from(cycles)).sqrt());
        for (n, sample) in samples.iter_mut().enumerate() {
            *sample += level * (TAU * (f64::from(cycles) * n as f64 / length as f64 + phase)).sin();
        }
    }
    samples
}

/// Two bars of drums at 150 beats a minute, 3.2 s: low drum, high drum, and something that hisses.
fn groove() -> Vec<f64> {
    let step = 0.1;
    let mut dice = Dice(0xD12A);
    let mut samples = vec![0.0; 26_400];
    let mut hit = |at: f64, sound: &mut dyn FnMut(f64) -> f64| {
        let begin = (at * RATE).round() as usize;
        for (n, sample) in samples.iter_mut().skip(begin).take(2400).enumerate() {
            let t = n as f64 / RATE;
            *sample += (t / 0.002).min(1.0) * sound(t);
        }
    };
    for (n, kind) in "k.h.s.hkk.h.s.h.k.h.s.hkkhk.s.ss".chars().enumerate() {
        let at = 0.02 + n as f64 * step;
        let (mut low, mut high) = (0.0, 0.0);
        let mut hiss = |quick: f64, slow: f64| {
            low += quick * (2.0 * dice.roll() - 1.0 - low);
            high += slow * (low - high);
            low - high
        };
        match kind {
            'k' => hit(at, &mut |t| {
                (TAU * (55.0 * t + 2.0 * (1.0 - (-t / 0.03).exp()))).sin() * (-t / 0.07).exp()
            }),
            's' => {
                hit(at, &mut |t| (0.5 * (TAU * 180.0 * t).sin() + 0.9 * hiss(0.5, 0.1)) * (-t / 0.05).exp())
            }
            'h' => hit(at, &mut |t| 0.6 * hiss(0.7, 0.4) * (-t / 0.02).exp()),
            _ => {}
        }
    }
    samples
}
