//! The log of a rendering: a table of what was played when, a line an event.

use std::fmt::{self, Write as _};
use std::io::{BufWriter, Write};
use std::path::Path;

use super::error::FileError;
use super::out::OutputFile;
use crate::node::motion::Motion;
use crate::player::{Happening, Heard};

/// What a log says about its rendering, in its first line.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Name of the patch.
    pub patch: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Frames a second.
    pub device_rate: f64,
    /// Engine samples a second.
    pub engine_rate: f64,
    /// Seconds by which the output is later than the log, at 250 Hz.
    pub delay: f64,
    /// Controls that were set from the start on, in place of their defaults.
    pub set: Vec<(String, f64)>,
}

/// Names of the columns.
pub const COLUMNS: &str =
    "seconds,sample,fraction,kind,pattern,event,drawn,name,place,level,frequency,fields,duration,id";

/// A log being written, to the disk as it comes.
#[derive(Debug)]
pub struct EventLog {
    file: BufWriter<OutputFile>,
    line: String,
    trouble: Option<FileError>,
}

impl EventLog {
    /// Makes the file, or empties the one that is there, and writes the first two lines: what was rendered, and [`COLUMNS`].
    ///
    /// # Errors
    /// As [`OutputFile::create`].
    pub fn create(path: &Path, head: &Head) -> Result<Self, FileError> {
        let file = BufWriter::with_capacity(1 << 16, OutputFile::create(path)?);
        let mut log = Self { file, line: String::new(), trouble: None };
        let Head { patch, seed, device_rate, engine_rate, delay, set } = head;
        let _ = write!(
            log.line,
            "# pacinian-log/1 patch={patch:?} seed={seed} device_rate={device_rate} engine_rate={engine_rate} \
             delay={delay}"
        );
        if !set.is_empty() {
            let set: Vec<String> = set.iter().map(|(control, value)| format!("{control}={value}")).collect();
            let _ = write!(log.line, " set={:?}", set.join(";"));
        }
        let _ = writeln!(log.line, "\n{COLUMNS}");
        log.put();
        Ok(log)
    }

    /// Writes the line of an event. What goes wrong is kept for [`EventLog::check`]; nothing is written after that.
    pub fn hear(&mut self, heard: &Heard<'_>) {
        self.line.clear();
        // A string takes whatever it is given.
        let _ = line(&mut self.line, heard);
        self.put();
    }

    fn put(&mut self) {
        if self.trouble.is_none()
            && let Err(error) = self.file.write_all(self.line.as_bytes())
        {
            self.trouble = Some(FileError::writing(self.file.get_ref().path(), &error));
        }
    }

    /// Whether all is well so far.
    ///
    /// # Errors
    /// What went wrong with the file.
    pub fn check(&self) -> Result<(), FileError> {
        self.trouble.clone().map_or(Ok(()), Err)
    }

    /// Writes what is still held, so that a log that goes no further is whole up to here.
    ///
    /// # Errors
    /// As [`EventLog::check`].
    pub fn flush(&mut self) -> Result<(), FileError> {
        self.check()?;
        self.file.flush().map_err(|error| FileError::writing(self.file.get_ref().path(), &error))
    }
}

fn line(to: &mut String, heard: &Heard<'_>) -> fmt::Result {
    let fraction = f64::from(heard.instant.fraction) / 4_294_967_296.0;
    let kind = match heard.what {
        Happening::Voice { .. } => "voice",
        Happening::Start(_) => "start",
        Happening::Marker(_) => "marker",
        Happening::Control(..) => "control",
        Happening::Touch(..) => "touch",
        Happening::Release => "release",
        Happening::ReleaseAll => "release-all",
        Happening::Silence(_) => "silence",
        Happening::Cancel(_) => "cancel",
        // Nothing is played.
        Happening::Waits { .. } | Happening::Message(_) => return Ok(()),
    };
    write!(to, "{},{},{fraction},{kind},", heard.at, heard.instant.sample)?;
    match heard.origin {
        // From 1, as problems count them.
        Some(origin) => {
            cell(to, origin.pattern)?;
            write!(to, ",{},", origin.event + 1)?;
            origin.drawn.map_or(Ok(()), |drawn| write!(to, "{}", u64::from(drawn) + 1))?;
        }
        None => to.push_str(",,"),
    }
    to.push(',');
    match heard.what {
        Happening::Voice { name, place, level, felt, duration, fields, own, .. } => {
            cell(to, name)?;
            to.push(',');
            cell(to, place)?;
            write!(to, ",{level},")?;
            let mut others = felt.map_or(String::new(), |felt| format!("felt={felt}"));
            for ((name, _), value) in fields.iter().zip(own) {
                if name == "frequency" {
                    write!(to, "{value}")?;
                } else {
                    let between = if others.is_empty() { "" } else { ";" };
                    write!(others, "{between}{name}={value}")?;
                }
            }
            to.push(',');
            cell(to, &others)?;
            write!(to, ",{duration},")?;
        }
        Happening::Start(name) | Happening::Marker(name) => {
            cell(to, name)?;
            to.push_str(",,,,,,");
        }
        Happening::Control(name, value) => {
            cell(to, name)?;
            write!(to, ",,,,value={value},,")?;
        }
        Happening::Touch(motion, value) => {
            write!(to, "{},,,,value={value},,", Motion::WORDS[motion.number()])?;
        }
        Happening::Silence(bits) | Happening::Cancel(bits) => write!(to, ",,,,value={bits},,")?,
        Happening::Release | Happening::ReleaseAll | Happening::Waits { .. } | Happening::Message(_) => {
            to.push_str(",,,,,,")
        }
    }
    heard.id.map_or(Ok(()), |id| write!(to, "{id}"))?;
    to.push('\n');
    Ok(())
}

/// A cell, quoted where it must be (RFC 4180). What would break the line, or move the cursor of who reads it, becomes a space.
fn cell(to: &mut String, text: &str) -> fmt::Result {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    if !text.contains([',', '"']) && !text.contains(char::is_control) {
        return to.write_str(text);
    }
    write!(to, "\"{}\"", text.chars().map(plain).collect::<String>().replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, Happening, Heard, line};
    use crate::player::Origin;
    use crate::schedule::Instant;

    #[test]
    fn every_kind_fills_the_columns() {
        let origin = Origin { pattern: "walk", event: 2, drawn: Some(0) };
        let fields = [("frequency".to_string(), 200.0), ("width".into(), 0.5), ("bite".into(), 0.0)];
        let voice = Happening::Voice {
            name: "tap",
            place: "t1",
            level: 0.25,
            felt: Some(20.0),
            duration: f64::INFINITY,
            fields: &fields,
            own: &[80.0, 0.1, -3.0, 0.0],
            pitched: true,
        };
        let instant = Instant { sample: 12, fraction: 1 << 31 };
        let mut heard = Heard { at: 0.0015625, instant, origin: Some(origin), id: Some(7), what: voice };
        let mut text = String::new();
        line(&mut text, &heard).unwrap();
        assert_eq!(text, "0.0015625,12,0.5,voice,walk,3,1,tap,t1,0.25,80,felt=20;width=0.1;bite=-3,inf,7\n");
        heard.origin = None;
        for what in [
            Happening::Marker("go"),
            Happening::Control("strength", 0.5),
            Happening::Release,
            Happening::ReleaseAll,
            Happening::Silence(14),
            Happening::Cancel(40),
        ] {
            text.clear();
            line(&mut text, &Heard { what, ..heard }).unwrap();
            assert_eq!(text.matches(',').count(), COLUMNS.matches(',').count(), "{text}");
        }
    }

    #[test]
    fn a_name_cannot_break_the_table() {
        let heard = Heard {
            at: 0.0,
            instant: Instant::default(),
            origin: None,
            id: None,
            what: Happening::Marker("a,\"b\"\nc\u{1b}[2J\0"),
        };
        let mut text = String::new();
        line(&mut text, &heard).unwrap();
        assert_eq!(text, "0,0,0,marker,,,,\"a,\"\"b\"\" c [2J \",,,,,,\n");
    }
}
