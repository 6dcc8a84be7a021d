//! How strongly something is felt: decibels above the threshold, by the calibration of each tactor, from the file to the skin.
#![cfg(feature = "cli")]

#[path = "../common/mod.rs"]
mod common;

mod advice;
mod refused;
mod strength;

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use pacinian::io::wav::WavReader;
use pacinian::{Rig, io};

const RATE: f64 = 48_000.0;
const VOLTS: f64 = 1.4;

const RIG: &str = r#"format = "pacinian-rig/1"
title = "Unequal"
[device]
channels = 5
full_scale_volts = 1.4
coupling = { high_pass = 6.0 }
[amplifier.board]
gain = 2.0
[amplifier.coil]
gain = -0.3
drive = "current"
[actuator.peaky]
equaliser = [{ frequency = 150, gain_db = 5, q = 1.5 }, { frequency = 70, gain_db = -8, q = 3 }]
[calibration.finger]
date = 2026-03-14
method = "laser vibrometer on the contactor, on the fingertip, 0.5 N"
site = "fingertip"
area = 2e-5
unit = "um/V"
table = [[40, 61.0], [100, 48.5], [250, 22.1], [400, 6.0]]
[calibration.palm]
date = "2026-03-15"
method = "accelerometer, on the palm"
area = 3e-4
unit = "g/V"
table = "palm.csv"
[calibration.current]
date = "2026-03-15"
method = "laser vibrometer, velocity"
area = 1e-5
unit = "mm/s/A"
table = [[35, 300.0], [300, 410.0], [900, 190.0]]
[calibration.whole]
date = "2026-03-16"
method = "laser vibrometer, from the card on"
area = 1e-4
unit = "um/FS"
table = [[20, 90.0], [1000, 1.5]]
[[tactor]]
name = "finger"
channel = 1
position = [0.0, 0.0]
calibration = "finger"
amplifier = "board"
actuator = "peaky"
[[tactor]]
name = "palm"
channel = 2
position = [0.04, 0.0]
site = "palm"
calibration = "palm"
amplifier = "board"
gain = 0.5
polarity = -1
[[tactor]]
name = "current"
channel = 3
calibration = "current"
amplifier = "coil"
site = "thenar"
[[tactor]]
name = "whole"
channel = 4
calibration = "whole"
site = "thenar"
gain = 3.0
[[tactor]]
name = "nobody"
channel = 5
"#;

const PALM: &str = "frequency,coherence,output\n30,0.99,0.35\n120,0.99,2.5\n500,0.97,9.0\n";

const VOICE: &str =
    "[voice.v]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n";

struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-felt-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("rig.toml"), RIG).unwrap();
        std::fs::write(folder.join("palm.csv"), PALM).unwrap();
        Self(folder)
    }

    fn rig(&self) -> Rig {
        io::load::rig(self.0.join("rig.toml")).unwrap_or_else(|p| panic!("{p}")).value
    }

    fn patch(&self, text: &str) -> PathBuf {
        let path = self.0.join("patch.toml");
        std::fs::write(&path, format!("format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}{text}"))
            .unwrap();
        path
    }

    fn pacinian(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_pacinian")).args(words).current_dir(&self.0).output().unwrap()
    }

    /// What `check` says, on both streams.
    fn check(&self, text: &str) -> (Option<i32>, String) {
        self.patch(text);
        let output = self.pacinian(&["check", "patch.toml", "--rig", "rig.toml"]);
        let said = [output.stderr, output.stdout].map(|said| String::from_utf8(said).unwrap()).concat();
        (output.status.code(), said)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The threshold of the glabrous hand by the published slopes, m: 12 dB an octave down to 250 Hz and up again, flat where that is above what it is at
/// 40 Hz, and 3 dB for each doubling of the area against 2.9 cm².
fn threshold(hertz: f64, area: f64) -> f64 {
    let slope = 40.0 * (hertz / 250.0).log10();
    let up = slope.max(0.0) * 12.0 / (40.0 * 2f64.log10());
    let pacinian = -20.0 - 10.0 * (area / 2.9e-4).log10() + if slope < 0.0 { -slope } else { up };
    1e-6 * 10f64.powf(pacinian.min(11.8) / 20.0)
}

/// What a table says, straight in dB over the logarithm of the frequency.
fn table(points: &[[f64; 2]], hertz: f64) -> f64 {
    let pair = points.windows(2).find(|pair| hertz >= pair[0][0] && hertz <= pair[1][0]).unwrap();
    let share = (hertz / pair[0][0]).ln() / (pair[1][0] / pair[0][0]).ln();
    pair[0][1].powf(1.0 - share) * pair[1][1].powf(share)
}

/// Metres for a sample of 1 that leaves on a channel.
fn metres(channel: usize, hertz: f64) -> f64 {
    let omega = TAU * hertz;
    let coupling = hertz / hertz.hypot(6.0);
    match channel {
        0 => {
            VOLTS
                * 2.0
                * coupling
                * table(&[[40.0, 61e-6], [100.0, 48.5e-6], [250.0, 22.1e-6], [400.0, 6e-6]], hertz)
        }
        1 => {
            let g = table(&[[30.0, 0.35], [120.0, 2.5], [500.0, 9.0]], hertz);
            VOLTS * 2.0 * coupling * g * 9.80665 / (omega * omega)
        }
        2 => VOLTS * 0.3 * coupling * table(&[[35.0, 0.3], [300.0, 0.41], [900.0, 0.19]], hertz) / omega,
        _ => table(&[[20.0, 90e-6], [1000.0, 1.5e-6]], hertz),
    }
}

const AREAS: [f64; 4] = [2e-5, 3e-4, 1e-5, 1e-4];

/// The amplitude of a sine of that frequency in frames that hold it steadily, by least squares over whole periods.
fn amplitude(signal: &[f64], hertz: f64) -> f64 {
    let periods = (signal.len() as f64 * hertz / RATE).floor();
    let length = (periods * RATE / hertz).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, x) in signal[..length].iter().enumerate() {
        let (sin, cos) = (TAU * hertz * n as f64 / RATE).sin_cos();
        (re, im) = (re + x * cos, im + x * sin);
    }
    2.0 * re.hypot(im) / length as f64
}

fn read(path: &Path) -> Vec<f32> {
    let mut frames = Vec::new();
    let mut reader = WavReader::open(path).unwrap();
    reader
        .each_frame(|frame| {
            frames.extend_from_slice(frame);
            Ok(())
        })
        .unwrap();
    frames
}
