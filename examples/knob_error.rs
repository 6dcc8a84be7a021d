//! Error against run time of a simulated knob and of velocity estimators, as tables, comma-separated values and pictures.
//!
//! `cargo run --release --no-default-features --features report --example knob_error -- FOLDER` prints the tables and writes the rest into
//! the folder; without one it prints only. It takes half a minute, most of it for the truths at 192 kHz.

use std::path::Path;

use pacinian::report::cost::{self, Across};
use pacinian::report::knob::estimators::{self, What, estimators};
use pacinian::report::knob::race::{self, race};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    let wish = race::Wish::default();
    let (mut done, all) = (0, wish.rows());
    let rows = race(&wish, &mut |row| {
        done += 1;
        eprint!("\r{done} of {all}: {}, {}                ", row.problem, row.method);
    })?;
    eprintln!();
    print!("{}", cost::text(&rows));
    let estimates = estimators(&estimators::Wish::default())?;
    print!("{}", estimators::text(&estimates));
    let Some(folder) = folder else { return Ok(()) };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for (name, text) in [
        ("knob.csv", cost::csv(&rows)),
        ("knob-step.svg", race::picture(&rows, Across::Step)),
        ("knob-second.svg", race::picture(&rows, Across::Second)),
        ("velocity.csv", estimators::csv(&estimates)),
        ("velocity-error.svg", estimators::picture(&estimates, What::Error)),
        ("velocity-noise.svg", estimators::picture(&estimates, What::Noise)),
        ("velocity-lag.svg", estimators::picture(&estimates, What::Lag)),
    ] {
        std::fs::write(folder.join(name), text)?;
        println!("{}", folder.join(name).display());
    }
    Ok(())
}
