//! What a knob did, sample by sample.

use crate::cli::failure::Failure;
use pacinian::io::error::FileError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// An engine sample of a knob.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Of the knob that is held, rad.
    pub angle: f64,
    /// rad/s.
    pub speed: f64,
    /// As the servo read and estimated them.
    pub read: [f64; 2],
    /// What the effects asked for and what was given, N m.
    pub torque: [f64; 2],
    /// Energy that went into the virtual world, J.
    pub absorbed: f64,
    /// Of the hand: where it holds the knob (rad), and how it pushes (N m).
    pub hand: [f64; 2],
}

/// All of them.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Samples a second.
    pub rate: f64,
    /// One after the other.
    pub samples: Vec<Sample>,
}

/// Writes them as a table.
///
/// # Errors
/// What keeps the file from being written.
pub fn write(path: &Path, course: &Course) -> Result<(), Failure> {
    let creating = |error: &std::io::Error| FileError::creating(path, error);
    let mut file = BufWriter::new(File::create(path).map_err(|error| creating(&error))?);
    let mut all = || -> std::io::Result<()> {
        writeln!(
            file,
            "time,angle,speed,read_angle,estimated_speed,asked_torque,torque,absorbed_energy,hand_angle,hand_torque"
        )?;
        for (n, sample) in course.samples.iter().enumerate() {
            let Sample { angle, speed, read, torque, absorbed, hand } = sample;
            writeln!(
                file,
                "{:.9},{angle:.9},{speed:.6},{:.9},{:.6},{:.9},{:.9},{absorbed:.9e},{:.9},{:.9}",
                n as f64 / course.rate,
                read[0],
                read[1],
                torque[0],
                torque[1],
                hand[0],
                hand[1]
            )?;
        }
        file.flush()
    };
    Ok(all().map_err(|error| creating(&error))?)
}
