//! What a knob did: what pictures need of it, and every sample of it as a table.

use crate::cli::failure::Failure;
use pacinian::io::error::FileError;
use pacinian::report::knob::course::{self, Course};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

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
    /// How much warmer than the air its winding is, K, where that is known.
    pub warm: Option<f64>,
    /// Of the hand: where it holds the knob (rad), if it does, and how it pushes (N m).
    pub hand: (Option<f64>, f64),
}

/// What is kept of them, in a bounded size however long it goes on.
pub struct Record {
    /// For pictures.
    pub course: Course,
    rate: f64,
    samples: u64,
    table: Option<(PathBuf, BufWriter<File>)>,
}

const NAMES: &str = "time,angle,speed,read_angle,estimated_speed,asked_torque,torque,absorbed_energy,hand_angle,hand_torque,winding_rise";

impl Record {
    /// Of so many samples a second, and with every one of them in a table at `path`.
    ///
    /// # Errors
    /// What keeps the table from being written.
    pub fn new(rate: f64, path: Option<&Path>) -> Result<Self, Failure> {
        let table = path.map(|path| {
            let mut file =
                File::create(path).map(BufWriter::new).map_err(|e| FileError::creating(path, &e))?;
            writeln!(file, "{NAMES}").map_err(|e| FileError::creating(path, &e))?;
            Ok::<_, Failure>((path.to_path_buf(), file))
        });
        Ok(Self { course: Course::new(rate), rate, samples: 0, table: table.transpose()? })
    }

    /// The next sample.
    ///
    /// # Errors
    /// What keeps the table from being written.
    pub fn push(&mut self, sample: &Sample) -> Result<(), Failure> {
        let time = self.samples as f64 / self.rate;
        self.samples += 1;
        let Sample { angle, speed, read, torque, absorbed, hand, .. } = *sample;
        let [asked, given] = torque;
        let estimated = read[1];
        self.course.push(&course::Sample {
            angle,
            speed,
            estimated,
            asked,
            given,
            energy: absorbed,
            hand: hand.0,
        });
        let Some((path, file)) = &mut self.table else { return Ok(()) };
        line(file, time, sample).map_err(|e| FileError::creating(path, &e).into())
    }

    /// Something that the knob set off at a time, s, by a trigger such as `knob.detent notches`.
    pub fn event(&mut self, time: f64, by: &str) {
        let kind = if by.starts_with("knob.detent") { "detent" } else { "wall" };
        self.course.event(time, kind);
    }

    /// Ends the table.
    ///
    /// # Errors
    /// What keeps it from being written.
    pub fn finish(&mut self) -> Result<(), Failure> {
        let Some((path, mut file)) = self.table.take() else { return Ok(()) };
        file.flush().map_err(|e| FileError::creating(&path, &e).into())
    }
}

fn line(file: &mut impl Write, time: f64, sample: &Sample) -> io::Result<()> {
    let Sample { angle, speed, read, torque, absorbed, hand, warm } = sample;
    write!(
        file,
        "{time:.9},{angle:.9},{speed:.6},{:.9},{:.6},{:.9},{:.9},{absorbed:.9e},",
        read[0], read[1], torque[0], torque[1],
    )?;
    hand.0.map_or(Ok(()), |angle| write!(file, "{angle:.9}"))?;
    write!(file, ",{:.9},", hand.1)?;
    warm.map_or(Ok(()), |warm| write!(file, "{warm:.6}"))?;
    writeln!(file)
}
