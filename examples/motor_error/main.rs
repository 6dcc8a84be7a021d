//! Error against run time of the models of actuators, of plain methods and of a crate of solvers, as a table, comma-separated values and pictures.
//!
//! `cargo run --release --no-default-features --features report --example motor_error -- FOLDER` prints the table and writes the rest into
//! the folder; without one it prints only.

mod solver;

use std::path::Path;

use pacinian::report::actuators::{Across, Row, Wish, csv, picture, race, text};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wish = Wish::default();
    let (mut done, all) = (0, wish.rows() + solver::count(&wish));
    let mut tell = |row: &Row| {
        done += 1;
        eprint!("\r{done} of {all}: {}, {}                ", row.problem, row.method);
    };
    let mut rows = race(&wish, &mut tell)?;
    rows.extend(solver::race(&wish, &mut tell));
    eprintln!();
    print!("{}", text(&rows));
    solver::print_faster(&rows);
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
