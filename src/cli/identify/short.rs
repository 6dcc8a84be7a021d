//! Recordings that end before their drive has done anything.

use super::super::failure::Failure;

/// The part of what a drive does, from its first change to its last, of which there is a recording at least where nothing in it is seen.
const SEEN: f64 = 0.5;

/// That a recording holds but so many samples of its drive, from the beginning of that; `None` where they are not too few.
pub fn too_short(shown: &str, recorded: usize, drive: &[f64], rate: f64) -> Option<Failure> {
    let end = drive.last()?;
    let first = begins(drive)?;
    let last = drive.iter().rposition(|volts| volts != end)?.max(first);
    ((recorded as f64) < first as f64 + SEEN * (last - first) as f64)
        .then(|| belongs(shown, recorded, drive, rate))
}

/// The sample at which a drive changes first.
fn begins(drive: &[f64]) -> Option<usize> {
    drive.iter().position(|volts| *volts != drive[0])
}

/// That no more than so many samples of a recording belong to its drive.
pub fn belongs(shown: &str, recorded: usize, drive: &[f64], rate: f64) -> Failure {
    let [recorded, whole] = [recorded, drive.len()].map(|samples| samples as f64 / rate);
    let rests =
        begins(drive).map_or(String::new(), |first| format!("rests until {:.3} s and ", first as f64 / rate));
    let what = format!(
        "`{shown}`: the recording is too short: {recorded:.4} s of it belong to the drive, which {rests}is {whole:.3} s long"
    );
    Failure::usage(what, format!("record all of the drive, {whole:.3} s, and some rest behind it"))
        .with_code(65)
}
