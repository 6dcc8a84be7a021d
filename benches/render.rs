//! CPU time of whole processes: `pacinian render` of a minute of 64 sines with an ADSR each, gated once a second, on 8 channels,
//! to a WAV of 32-bit floats.
//!
//! `cargo bench --bench render`. Linux only: it reads the CPU time of its children from `/proc/self/stat`, in hundredths of a
//! second, so it takes the mean of many runs.

use std::process::{Command, Stdio};

const RUNS: u32 = 20;
/// Clock ticks a second in `/proc`: always 100 on Linux.
const TICKS: f64 = 100.0;

fn main() {
    let Some(begin) = children() else {
        println!("there is no /proc/self/stat here, so the CPU time of a process is not known");
        return;
    };
    let patch = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/sines.toml");
    let wav = std::env::temp_dir().join(format!("pacinian-bench-{}.wav", std::process::id()));
    for _ in 0..RUNS {
        let done = Command::new(env!("CARGO_BIN_EXE_pacinian"))
            .args(["render", patch, "--duration", "60", "--format", "f32", "-o"])
            .arg(&wav)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        assert!(done.is_ok_and(|status| status.success()), "pacinian render {patch} failed");
    }
    let bytes = std::fs::metadata(&wav).map_or(0, |file| file.len());
    let _ = std::fs::remove_file(&wav);
    let seconds = (children().unwrap_or(f64::NAN) - begin) / f64::from(RUNS);
    println!(
        "a minute of 64 sines with ADSR, 8 channels, {bytes} bytes: {seconds:.3} s of CPU time, the whole process"
    );
}

/// CPU seconds, user and system, of the children that have ended.
fn children() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the process, in brackets, may hold anything; the fields are counted behind it.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(13)?.parse::<f64>().ok()? + fields.get(14)?.parse::<f64>().ok()?;
    Some(ticks / TICKS)
}
