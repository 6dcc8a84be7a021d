//! Tables of calibrations from files beside a rig.

use std::path::PathBuf;

use super::assets::Folder;
use super::error::FileError;
use super::text;
use crate::rig::Rig;
use crate::text::{Origin, Problem, Problems};

/// The most bytes of such a file.
pub const LIMIT: u64 = 1 << 20;

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Read {
    /// Its path as the rig says it.
    pub path: String,
    /// Where it is.
    pub real: PathBuf,
    /// What stands in it.
    pub text: String,
}

/// Fills in the tables of a rig's calibrations that stand in files of a folder. Gives the files, and what is wrong with them, each at its place in them or where
/// the rig, which was read from `origin`, names them.
pub fn fill(rig: &mut Rig, origin: &Origin, folder: &Folder) -> (Vec<Read>, Vec<Problems>) {
    let (mut files, mut wrong): (Vec<Read>, Vec<Problems>) = (Vec::new(), Vec::new());
    for calibration in &mut rig.calibrations {
        let Some(path) = calibration.file.clone() else { continue };
        let known = files.iter().position(|file| file.path == path);
        let file = match known
            .map_or_else(|| read(folder, &path).map(|file| (file, true)), |n| Ok((files[n].clone(), false)))
        {
            Ok((file, new)) => {
                if new {
                    files.push(file.clone());
                }
                file
            }
            Err(error) => {
                let what = error.message.replace("patch's folder", "rig's folder");
                wrong.push(origin.problems(vec![Problem::error(&calibration.table_span, what)]));
                continue;
            }
        };
        if let Err(list) = calibration.take(&file.text) {
            let shown = folder.root().join(&path).display().to_string();
            wrong.push(Origin { file: shown.into(), source: file.text.as_str().into() }.problems(list));
        }
    }
    (files, wrong)
}

fn read(folder: &Folder, path: &str) -> Result<Read, FileError> {
    let real = folder.resolve(path)?;
    let bytes = text::read_up_to(&real, LIMIT)?;
    // What is no text has no numbers, which is told at its lines.
    Ok(Read { path: path.into(), real, text: String::from_utf8_lossy(&bytes).into_owned() })
}

#[cfg(test)]
mod tests {
    use super::fill;
    use crate::io::assets::Folder;
    use crate::rig::Rig;
    use crate::text::Origin;

    fn rig(file: &str) -> (Rig, Origin) {
        let text = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 1\n[calibration.a]\ndate = 2026-03-14\n\
             method = \"laser\"\narea = 2e-5\nunit = \"um/V\"\ntable = \"{file}\"\n[[tactor]]\nname = \"t\"\nchannel = 1\ncalibration = \"a\"\n"
        );
        let rig = Rig::parse("r.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        (rig, Origin { file: "r.toml".into(), source: text.as_str().into() })
    }

    #[test]
    fn tables_are_read_and_their_mistakes_told_at_their_line() {
        let folder = std::env::temp_dir().join(format!("pacinian-calibrations-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = Folder::new(&folder);
        let good = "\u{feff}# phase in degrees\nfrequency, phase,output\r\n\n50,-3,31.5\n250.5, 4,12e0\n";
        std::fs::write(folder.join("a.csv"), good).unwrap();
        let (mut measured, origin) = rig("a.csv");
        let (read, wrong) = fill(&mut measured, &origin, &files);
        assert!(wrong.is_empty() && read.len() == 1 && read[0].text == good, "{wrong:?}");
        assert_eq!(measured.calibrations[0].points, [[50.0, 31.5], [250.5, 12.0]]);

        let told = |text: &str| {
            std::fs::write(folder.join("a.csv"), text).unwrap();
            let (mut rig, origin) = rig("a.csv");
            let (_, wrong) = fill(&mut rig, &origin, &files);
            assert!(rig.calibrations[0].response().is_none());
            wrong.into_iter().map(|problems| problems.to_string()).collect::<String>()
        };
        for (text, line, wanted) in [
            ("", "a.csv", "without points"),
            ("hz,um\n50,1\n", "a.csv:1:1", "`frequency` and `output`"),
            ("frequency;output\n50;1\n", "a.csv:1:1", "divided by commas"),
            ("frequency,output\n50,1\n", "a.csv", "1 point says nothing"),
            ("frequency,output\n50,1\n40,1\n", "a.csv:3:1", "sort the points"),
            ("frequency,output\n50,1\n50,2\n", "a.csv:3:1", "stands there twice"),
            ("frequency,output\n50,1\n60,nan\n", "a.csv:3:1", "is no output"),
            ("frequency,output\n50,1\n60,1e300\n", "a.csv:3:1", "is no output"),
            ("frequency,output\n50,1\nsixty,1\n70\n80,1\n", "a.csv:3:1", "no number"),
            ("frequency,output\n50,1\n\u{fffd}\u{0},\u{1}\n", "a.csv:3:1", "no number"),
        ] {
            let told = told(text);
            assert!(told.contains(line) && told.contains(wanted), "{text:?}: {told}");
        }
        for (file, wanted) in
            [("none.csv", "is not there"), ("../a.csv", "leads out of the rig's folder"), (".", "a folder")]
        {
            let (mut rig, origin) = rig(file);
            let (_, wrong) = fill(&mut rig, &origin, &files);
            let told = wrong.first().map(ToString::to_string).unwrap_or_default();
            assert!(told.starts_with("r.toml:10:") && told.contains(wanted), "{file}: {told}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
