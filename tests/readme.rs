//! The README does what it says: its console blocks are run as they stand, in a folder that holds the patches, the rigs and the
//! files that the README itself shows.
//!
//! A block is a list of commands after `$ `, each followed by what it prints, standard error included; a command that no output
//! follows may print what it likes. In output, a line `...` stands for any lines, and `...` in a line for any characters.
//! `cargo run --release --` stands for the program that is being tested; `cargo test` is not run from within itself. A
//! comment `<!-- file: NAME -->` before a block gives it to the commands as a file.
#![cfg(all(unix, feature = "cli"))]

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

const README: &str = include_str!("../README.md");

/// A fenced block.
struct Block<'a> {
    /// What it is written in.
    language: &'a str,
    /// The file that it is given as.
    file: Option<&'a str>,
    lines: Vec<&'a str>,
    /// Line of the README where it begins.
    at: usize,
}

fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut open, mut file) = (false, None);
    for (n, line) in text.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(language) => {
                open = true;
                blocks.push(Block { language, file: file.take(), lines: Vec::new(), at: n + 1 });
            }
            None if open => blocks.iter_mut().last().into_iter().for_each(|block| block.lines.push(line)),
            None => {
                let named = line.strip_prefix("<!-- file: ").and_then(|rest| rest.strip_suffix(" -->"));
                file = named.or(file.filter(|_| line.is_empty()));
            }
        }
    }
    blocks
}

/// Whether `line` is as `wanted` says, where `...` stands for any characters.
fn line_matches(wanted: &str, line: &str) -> bool {
    let mut parts = wanted.split("...");
    let Some(mut rest) = line.strip_prefix(parts.next().unwrap_or("")) else { return false };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

/// Whether `lines` are as `wanted` say, where a line `...` stands for any lines.
fn matches(wanted: &[&str], lines: &[&str]) -> bool {
    match wanted.split_first() {
        None => lines.is_empty(),
        Some((&"...", later)) => (0..=lines.len()).any(|n| matches(later, &lines[n..])),
        Some((first, later)) => {
            lines.split_first().is_some_and(|(line, rest)| line_matches(first, line) && matches(later, rest))
        }
    }
}

/// A folder that goes when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pacinian-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn program(path: &Path, text: &str) {
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// What stands in for cargo: it runs the program under test, and refuses what the README does not say.
const CARGO: &str = r#"#!/bin/sh
case "$1 $2 $3" in
  "run --release --") shift 3; exec pacinian "$@" ;;
  "test "*) exit 0 ;;
  "install --path ."*) exit 0 ;;
  *) echo "no such command in the test of the README: cargo $*" >&2; exit 1 ;;
esac
"#;

#[test]
fn the_console_blocks_hold() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Folder::new("readme");
    let bin = folder.0.join("bin");
    let work = folder.0.join("work");
    fs::create_dir_all(&bin).unwrap();
    fs::create_dir_all(&work).unwrap();
    symlink(env!("CARGO_BIN_EXE_pacinian"), bin.join("pacinian")).unwrap();
    program(&bin.join("cargo"), CARGO);
    for shared in ["patches", "rigs", "schema"] {
        symlink(root.join(shared), work.join(shared)).unwrap();
    }
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());

    let mut ran = 0;
    for block in blocks(README) {
        if let Some(file) = block.file {
            fs::write(work.join(file), block.lines.join("\n") + "\n").unwrap();
        }
        if block.language != "console" {
            continue;
        }
        let first = block.lines.first().copied().unwrap_or("");
        assert!(first.starts_with("$ "), "README.md:{}: a console block begins with a command", block.at);
        for part in block.lines.chunk_by(|_, next| !next.starts_with("$ ")) {
            let Some((command, wanted)) = part.split_first() else { continue };
            let command = command.trim_start_matches("$ ");
            let output = Command::new("sh")
                .args(["-c", &format!("{{ {command}\n}} 2>&1")])
                .current_dir(&work)
                .env("PATH", &path)
                .env_remove("CLICOLOR_FORCE")
                .env_remove("FORCE_COLOR")
                .output()
                .unwrap();
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let lines: Vec<&str> = text.lines().collect();
            let place = format!("README.md:{}: `{command}`", block.at);
            // A command that is there to fail shows what it prints.
            assert!(output.status.success() || !wanted.is_empty(), "{place} fails:\n{text}");
            assert!(wanted.is_empty() || matches(wanted, &lines), "{place} prints:\n{text}");
            ran += 1;
        }
    }
    assert!(ran >= 4, "only {ran} commands of the README were found");
}

#[test]
fn the_readme_links_to_what_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let targets = README.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let (mut seen, mut broken) = (0, Vec::new());
    for target in targets.filter(|t| !t.contains("://")) {
        let (path, heading) = target.split_once('#').unwrap_or((target, ""));
        let known = if path.is_empty() {
            README.lines().any(|l| l.starts_with('#') && anchor(l) == heading)
        } else {
            root.join(path).exists()
        };
        seen += 1;
        if !known {
            broken.push(target);
        }
    }
    assert!(seen > 0 && broken.is_empty(), "links of the README that lead nowhere: {broken:?}");
}

/// The name under which a heading can be linked to.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    text.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
}

#[test]
fn dots_stand_for_anything() {
    assert!(line_matches("a ... c", "a b b c"));
    assert!(line_matches("... of ... s", "1 of 20 s"));
    assert!(!line_matches("a ... c", "a c"));
    assert!(!line_matches("plain", "plain and more"));
    assert!(matches(&["a", "...", "c"], &["a", "x", "y", "c"]));
    assert!(matches(&["..."], &[]));
    assert!(!matches(&["a", "...", "c"], &["a", "x", "c", "d"]));
    assert!(!matches(&["a"], &[]));
}
