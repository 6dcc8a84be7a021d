//! Patches and rigs from files, with errors that name file and line.

use super::assets::Folder;
use super::calibrations;
use super::error::FileError;
use super::text;
use crate::patch::Patch;
use crate::rig::Rig;
use crate::text::{Checked, Origin, Problem, Problems};
use std::path::Path;

/// The patch in a file. Recordings and events files beside it are left to whoever plays it: [`super::assets::Folder`].
///
/// # Errors
/// That the file cannot be read, or every problem in it, each at its line.
pub fn patch(path: impl AsRef<Path>) -> Result<Checked<Patch>, Problems> {
    let (name, bytes) = read(path.as_ref())?;
    Patch::parse(&name, &bytes)
}

/// The rig in a file, with the tables of its calibrations that stand in files beside it.
///
/// # Errors
/// As [`patch`].
pub fn rig(path: impl AsRef<Path>) -> Result<Checked<Rig>, Problems> {
    let (name, bytes) = read(path.as_ref())?;
    let mut checked = Rig::parse(&name, &bytes)?;
    let origin = Origin { file: name.into(), source: String::from_utf8_lossy(&bytes).as_ref().into() };
    let folder = Folder::new(path.as_ref().parent().unwrap_or(Path::new("")));
    match calibrations::fill(&mut checked.value, &origin, &folder).1.into_iter().next() {
        Some(problems) => Err(problems),
        None => Ok(checked),
    }
}

/// The name of a file, as it is shown, and what stands in it.
fn read(path: &Path) -> Result<(String, Vec<u8>), Problems> {
    // The message names the file.
    let told =
        |error: FileError| Problems { list: vec![Problem::of_file(error.message)], ..Problems::default() };
    Ok((path.display().to_string(), text::read(path).map_err(told)?))
}

#[cfg(test)]
mod tests {
    use super::{patch, rig};

    #[test]
    fn errors_name_file_and_line() {
        let folder = std::env::temp_dir().join(format!("pacinian-load-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("p.toml");
        std::fs::write(&file, "format = \"pacinian-patch/1\"\ntitle = \"t\"\n\nvoise = 1\n").unwrap();
        let shown = file.display().to_string();
        let told = patch(&file).unwrap_err().to_string();
        assert!(told.starts_with(&format!("{shown}:4:1: error: ")), "{told}");
        let told = rig(&file).unwrap_err().to_string();
        assert!(told.starts_with(&format!("{shown}:1:")), "{told}");
        let none = folder.join("none.toml");
        let told = patch(&none).unwrap_err().to_string();
        assert!(told.contains(&format!("`{}` is not there", none.display())), "{told}");
        std::fs::write(&file, "format = \"pacinian-patch/1\"\ntitle = \"t\"\n").unwrap();
        assert_eq!(patch(&file).unwrap().value.title, "t");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
