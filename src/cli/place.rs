//! Where output may go: not over what is read, not where it would be lost, and not under a name that lies.

use super::failure::Failure;
use super::loaded::Loaded;
use pacinian::io::out;
use std::path::{Path, PathBuf};

/// Refuses a WAV file where nothing good would come of it.
///
/// # Errors
/// Over a file that is read or that has the terminal's output, to a pipe, under another format's name, or where it cannot be made.
pub fn check_wav(output: &Path, loaded: &Loaded) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        return Err(Failure::usage(
            "a file whose length is written last cannot go to standard output",
            "name a file: -o out.wav",
        ));
    }
    refuse_to_replace(output, loaded, "-o")?;
    check_extension(output, "wav", "sound is WAV", "sox and ffmpeg convert it afterwards")?;
    Ok(out::check(output)?)
}

/// Refuses a picture where nothing good would come of it.
///
/// # Errors
/// As [`check_wav`].
pub fn check_picture(output: &Path, loaded: &Loaded) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        let what = "the picture goes to a file, since standard output has the rest";
        return Err(Failure::usage(what, "name a file: -o out.svg"));
    }
    refuse_to_replace(output, loaded, "-o")?;
    check_extension(output, "svg", "pictures are SVG", "browsers, Inkscape and LaTeX read SVG")?;
    Ok(out::check(output)?)
}

/// Refuses a log where nothing good would come of it.
///
/// # Errors
/// As [`check_wav`], and over the rendering itself.
pub fn check_log(log: &Path, output: &Path, loaded: &Loaded) -> Result<(), Failure> {
    if log.as_os_str() == "-" {
        let what = "the log goes to a file, since standard output has the summary";
        return Err(Failure::usage(what, "name a file: --log out.csv"));
    }
    if place(log) == place(output) || is_same(log, output) {
        let what = format!("`{}` cannot be both the rendering and its log", log.display());
        return Err(Failure::usage(what, "choose another file for --log"));
    }
    refuse_to_replace(log, loaded, "--log")?;
    Ok(out::check(log)?)
}

/// Refuses a recording or a journal of a session where nothing good would come of it; `others` are the session's other files.
///
/// # Errors
/// As [`check_log`].
pub fn check_kept(
    output: &Path,
    option: &str,
    others: &[&Path],
    loaded: Option<&Loaded>,
) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        let what = "it goes to a file, since standard output has what happens";
        return Err(Failure::usage(what, format!("name a file: {option} FILE")));
    }
    if let Some(other) = others.iter().find(|other| place(output) == place(other) || is_same(output, other)) {
        let what = format!("`{}` is meant for something else already", other.display());
        return Err(Failure::usage(what, format!("choose another file for {option}")));
    }
    if let Some(loaded) = loaded {
        refuse_to_replace(output, loaded, option)?;
    }
    if option != "--events" {
        check_extension(output, "wav", "sound is WAV", "sox and ffmpeg convert it afterwards")?;
    }
    Ok(out::check(output)?)
}

/// Refuses to write over what a session was made of, where that is there.
///
/// # Errors
/// A file that is one of `own`.
pub fn check_own(output: &Path, option: &str, own: &[PathBuf]) -> Result<(), Failure> {
    if own.iter().any(|file| is_same(file, output)) {
        let what = format!("`{}` belongs to the session itself, so it is not written over", output.display());
        return Err(Failure::usage(what, format!("choose another file for {option}")));
    }
    Ok(())
}

/// Refuses to write over a recording that was made before: nobody can play it again.
///
/// # Errors
/// A file that is there and not empty; exit code 73.
pub fn check_new(output: &Path) -> Result<(), Failure> {
    if std::fs::metadata(output).is_ok_and(|about| about.is_file() && about.len() > 0) {
        let what = format!("`{}` is there already", output.display());
        return Err(Failure::usage(what, "give another name, or --replace").with_code(73));
    }
    Ok(())
}

/// Refuses a folder for what belongs to a journal where something else is, or where something is in it that is not to be replaced.
///
/// # Errors
/// Exit code 73.
pub fn check_folder(folder: &Path, replace: bool) -> Result<(), Failure> {
    let there = match std::fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some() && !replace,
        Err(error) => error.kind() != std::io::ErrorKind::NotFound,
    };
    if !there {
        return Ok(());
    }
    let help = if folder.is_dir() {
        "give the journal another name, or --replace"
    } else {
        "give the journal another name"
    };
    Err(Failure::usage(format!("`{}` is there already", folder.display()), help).with_code(73))
}

/// Refuses a picture or a table that is made of something else than a rendering where nothing good would come of it; `own` is what it
/// is made of.
///
/// # Errors
/// As [`check_wav`].
pub fn check_made(output: &Path, option: &str, extension: &str, own: &[PathBuf]) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        let what = "it goes to a file, since standard output has the figures";
        return Err(Failure::usage(what, format!("name a file: {option} out.{extension}")));
    }
    if own.iter().any(|file| is_same(file, output)) {
        let what = format!("`{}` is read for this, so it is not written over", output.display());
        return Err(Failure::usage(what, format!("choose another file for {option}")));
    }
    refuse_messages(output, option)?;
    let (what, help) = match extension {
        "svg" => ("pictures are SVG", "browsers, Inkscape and LaTeX read SVG"),
        _ => ("tables are comma-separated values", "spreadsheets and statistics programs read them"),
    };
    check_extension(output, extension, what, help)?;
    Ok(out::check(output)?)
}

/// Refuses a WAV file that is made of something else than a patch where nothing good would come of it; `own` is what it is made of.
///
/// # Errors
/// As [`check_wav`].
pub fn check_sound(output: &Path, option: &str, own: &[PathBuf]) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        let what = "a file whose length is written last cannot go to standard output";
        return Err(Failure::usage(what, format!("name a file: {option} out.wav")));
    }
    if own.iter().any(|file| is_same(file, output)) {
        let what = format!("`{}` is read for this, so it is not written over", output.display());
        return Err(Failure::usage(what, format!("choose another file for {option}")));
    }
    refuse_messages(output, option)?;
    check_extension(output, "wav", "sound is WAV", "sox and ffmpeg convert it afterwards")?;
    Ok(out::check(output)?)
}

fn check_extension(output: &Path, right: &str, what: &str, help: &str) -> Result<(), Failure> {
    match output.extension() {
        Some(other) if !other.eq_ignore_ascii_case(right) => Err(Failure::usage(
            format!("{what}, not {}", other.to_string_lossy()),
            format!("name it `{}`; {help}", output.with_extension(right).display()),
        )),
        _ => Ok(()),
    }
}

fn refuse_to_replace(output: &Path, loaded: &Loaded, option: &str) -> Result<(), Failure> {
    if loaded.files.iter().any(|file| is_same(file, output)) {
        let what = format!("`{}` is read for this rendering, so it is not written over", output.display());
        return Err(Failure::usage(what, format!("choose another file for {option}")));
    }
    refuse_messages(output, option)
}

fn refuse_messages(output: &Path, option: &str) -> Result<(), Failure> {
    let choose = || format!("choose another file for {option}");
    if takes_messages(output) {
        let what =
            format!("`{}` has what this program says, so nothing else is written there", output.display());
        return Err(Failure::usage(what, choose()));
    }
    Ok(())
}

/// Whether two paths lead to one file that is there, be it by links of either kind.
fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    {
        let of = |path: &Path| std::fs::metadata(path).ok().map(|about| identity(&about));
        of(a).is_some_and(|a| of(b) == Some(a))
    }
    #[cfg(not(unix))]
    {
        a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
    }
}

#[cfg(unix)]
fn identity(about: &std::fs::Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (about.dev(), about.ino())
}

/// Whether standard output or standard error goes into this very file.
fn takes_messages(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let Ok(about) = std::fs::metadata(path) else { return false };
        let (out, err) = (std::io::stdout(), std::io::stderr());
        about.is_file()
            && [out.as_fd(), err.as_fd()].into_iter().any(|stream| {
                // A copy of its own, since a file is closed when it is dropped.
                let file = stream.try_clone_to_owned().map(std::fs::File::from);
                let there = file.and_then(|file| file.metadata());
                there.is_ok_and(|there| there.is_file() && identity(&there) == identity(&about))
            })
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// Where a file is or will be, however it is written.
fn place(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    // As many links as systems follow.
    for _ in 0..40 {
        if let Ok(real) = path.canonicalize() {
            return real;
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // A link to what is not there yet is where that will be.
        if let Ok(target) = path.read_link() {
            path = folder.join(target);
            continue;
        }
        return match (folder.canonicalize(), path.file_name()) {
            (Ok(folder), Some(name)) => folder.join(name),
            _ => path,
        };
    }
    path
}
