//! Error against run time of the models of actuators and of plain methods, as a table, comma-separated values and pictures.
//!
//! `cargo run --release --no-default-features --features report --example motor_error -- FOLDER` prints the table and writes the rest into
//! the folder; without one it prints only. `cargo bench --bench solvers` has the rows of a crate of solvers beside them.

use std::path::Path;

use pacinian::report::actuators::{Across, Wish, csv, picture, race, text};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wish = Wish::default();
    let (mut done, all) = (0, wish.rows());
    let rows = race(&wish, &mut |row| {
        done += 1;
        eprint!("\r{done} of {all}: {}, {}                ", row.problem, row.method);
    })?;
    eprintln!();
    print!("{}", text(&rows));
    let Some(folder) = std::env::args().nth(1) else { return Ok(()) };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for (name, text) in [
        ("motor.csv", csv(&rows)),
        ("motor-step.svg", picture(&rows, Across::Step)),
        ("motor-second.svg", picture(&rows, Across::Second)),
    ] {
        std::fs::write(folder.join(name), text)?;
        println!("{}", folder.join(name).display());
    }
    Ok(())
}
