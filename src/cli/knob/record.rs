//! What a knob did: figures, what pictures need of it, and every sample of it as a table.

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

/// Figures of all samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Least and greatest angle, rad.
    pub angle: [f64; 2],
    /// rad/s.
    pub most_speed: f64,
    /// N m.
    pub most_torque: f64,
    /// Energy that went into the virtual world by the end, and at its least, J.
    pub absorbed: f64,
    pub least_absorbed: f64,
    /// K above the air, of its winding, where that is known.
    pub most_warm: Option<f64>,
    /// Squares of the errors of the estimated speed, summed, and how many there are.
    squares: f64,
    samples: u64,
}

impl Figures {
    /// Root-mean-square error of the estimated speed, rad/s.
    pub fn speed_error(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }

    fn push(&mut self, sample: &Sample) {
        let Sample { angle, speed, read, torque, absorbed, .. } = *sample;
        self.angle = [self.angle[0].min(angle), self.angle[1].max(angle)];
        self.most_speed = self.most_speed.max(speed.abs());
        self.most_torque = self.most_torque.max(torque[1].abs());
        (self.absorbed, self.least_absorbed) = (absorbed, self.least_absorbed.min(absorbed));
        if let Some(warm) = sample.warm {
            self.most_warm = Some(self.most_warm.unwrap_or(warm).max(warm));
        }
        self.squares += (read[1] - speed).powi(2);
        self.samples += 1;
    }
}

/// What is kept of them, in a bounded size however long it goes on.
pub struct Record {
    /// For pictures.
    pub course: Course,
    /// In numbers.
    pub figures: Figures,
    rate: f64,
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
        let figures = Figures {
            angle: [f64::INFINITY, f64::NEG_INFINITY],
            most_speed: 0.0,
            most_torque: 0.0,
            absorbed: 0.0,
            least_absorbed: 0.0,
            most_warm: None,
            squares: 0.0,
            samples: 0,
        };
        Ok(Self { course: Course::new(rate), figures, rate, table: table.transpose()? })
    }

    /// The next sample.
    ///
    /// # Errors
    /// What keeps the table from being written.
    pub fn push(&mut self, sample: &Sample) -> Result<(), Failure> {
        let time = self.figures.samples as f64 / self.rate;
        self.figures.push(sample);
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

    /// How long it is, s.
    pub fn seconds(&self) -> f64 {
        self.figures.samples as f64 / self.rate
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
