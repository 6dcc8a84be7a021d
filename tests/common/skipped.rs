//! Tests that cannot be had say so.

use std::io::Write;

/// Says that a test was skipped, and why: to who reads the output, and in the file that PACINIAN_SKIPPED names, by which `.ci/run` knows.
pub fn skipped(why: impl std::fmt::Display) {
    println!("skipped: {why}");
    let Some(path) = std::env::var_os("PACINIAN_SKIPPED") else { return };
    let test = std::thread::current().name().unwrap_or_default().to_string();
    let mut file = std::fs::File::options().create(true).append(true).open(path).unwrap();
    file.write_all(format!("{test}: {why}\n").as_bytes()).unwrap();
}
