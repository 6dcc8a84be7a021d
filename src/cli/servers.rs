//! Sound servers: whether they run, and by what they are reached.

use super::failure::Failure;
use super::patience;
use super::terminal::Terminal;
use pacinian::io::device::choose::{Chosen, Wish};
use pacinian::io::device::failure::Trouble;
use pacinian::text::problem::escaped;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A sound server.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Server {
    /// What it is called.
    pub name: &'static str,
    /// Whether it answers.
    pub runs: bool,
    /// Whether this program has been built to speak with it.
    pub built_in: bool,
    /// How to get at it, where that is not so, or how to start it; what is done in one line.
    pub help: &'static str,
}

/// Those that there may be; `lookup` is the environment.
pub fn servers(lookup: impl Fn(&str) -> Option<String>) -> Vec<Server> {
    let path = |name: &str| lookup(name).filter(|path| !path.is_empty()).map(PathBuf::from);
    let runtime = path("XDG_RUNTIME_DIR");
    let pipewire = path("PIPEWIRE_RUNTIME_DIR").or_else(|| runtime.clone()).map(|folder| {
        folder.join(lookup("PIPEWIRE_REMOTE").filter(|name| !name.is_empty()).unwrap_or("pipewire-0".into()))
    });
    let pulse = path("PULSE_SERVER")
        .and_then(|server| server.to_str()?.strip_prefix("unix:").map(PathBuf::from))
        .or_else(|| path("PULSE_RUNTIME_PATH").map(|folder| folder.join("native")))
        .or_else(|| runtime.map(|folder| folder.join("pulse/native")));
    let jack = lookup("JACK_DEFAULT_SERVER").filter(|name| !name.is_empty()).unwrap_or("default".into());
    [
        (
            "PipeWire",
            pipewire.is_some_and(|path| answers(&path)),
            cfg!(feature = "pipewire"),
            [
                "systemctl --user start pipewire wireplumber (packages pipewire, wireplumber)",
                "cargo install --path . --features pipewire (packages libpipewire-0.3-dev, libclang-dev); or through ALSA, which mixes channels beyond \
                 8 together: sudo apt-get install pipewire-alsa",
            ],
        ),
        (
            "PulseAudio",
            pulse.is_some_and(|path| answers(&path)),
            cfg!(feature = "pulseaudio"),
            [
                "pulseaudio --start (package pulseaudio)",
                "cargo install --path . --features pulseaudio (no package); or through ALSA: sudo apt-get install libasound2-plugins",
            ],
        ),
        (
            "JACK",
            has_jack(Path::new("/dev/shm"), &jack),
            cfg!(feature = "jack"),
            [
                "jackd -R -d alsa -d hw:CARD (package jackd2)",
                "cargo install --path . --features jack (package libjack-jackd2-dev)",
            ],
        ),
    ]
    .map(|(name, runs, built_in, [start, build])| {
        let help = match (runs, built_in) {
            (true, true) => "",
            (false, true) => start,
            (_, false) => build,
        };
        Server { name, runs, built_in, help }
    })
    .to_vec()
}

/// The device that is meant. Where none of a sound server is there that was named, the server is the reason.
///
/// # Errors
/// As [`Wish::choose`], and a sound system that does not answer.
pub fn choose(wish: &Wish, terminal: &Terminal) -> Result<Chosen, Failure> {
    let asked = wish.clone();
    patience::look(terminal, move || asked.choose())?.map_err(|error| {
        let named = match wish {
            Wish::Named(name) if error.kind == Trouble::Missing => named(name),
            _ => None,
        };
        match named {
            Some(Server { name, built_in: false, help, .. }) => Failure::usage(
                format!("{}: this program does not speak with {name} itself", error.what),
                help,
            ),
            Some(Server { name, runs: false, help, .. }) => {
                Failure::usage(format!("{}: {name} does not run", error.what), format!("start it: {help}"))
            }
            _ => return error.into(),
        }
        .with_code(error.kind.exit_code())
    })
}

/// As [`choose`]: the device that the command line names, or else the rig in that file; and how it was meant.
///
/// # Errors
/// As [`choose`]; of a rig's device it is said where it stands.
pub fn choose_for(
    device: Option<&str>,
    by_rig: Option<&str>,
    rig: impl std::fmt::Display,
    terminal: &Terminal,
) -> Result<(Wish, Chosen), Failure> {
    let wish = Wish::of(device, by_rig);
    match choose(&wish, terminal) {
        Ok(chosen) => Ok((wish, chosen)),
        Err(failure) if device.is_none() && by_rig.is_some() => Err(failure.and(&format!(
            "it is the `name` under [device] in {}; --device names another",
            escaped(&rig.to_string())
        ))),
        Err(failure) => Err(failure),
    }
}

/// The server that a device's name begins with.
fn named(device: &str) -> Option<Server> {
    let host = device.split(':').next().unwrap_or(device).to_lowercase();
    let is = |server: &Server| {
        let name = server.name.to_lowercase();
        name == host || (host == "pulse" && name == "pulseaudio")
    };
    servers(|name| std::env::var(name).ok()).into_iter().find(is)
}

/// Whether somebody listens there.
fn answers(socket: &Path) -> bool {
    #[cfg(unix)]
    return std::os::unix::net::UnixStream::connect(socket).is_ok();
    #[cfg(not(unix))]
    return socket.exists();
}

/// Whether a server of that name has its socket in a folder: `jack_NAME_USER_0`.
fn has_jack(folder: &Path, name: &str) -> bool {
    let begins = format!("jack_{name}_");
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let file = entry.file_name();
        file.to_str().is_some_and(|file| file.starts_with(&begins) && file.ends_with("_0"))
            && answers(&entry.path())
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::{has_jack, servers};
    use std::os::unix::net::UnixListener;

    #[test]
    fn a_server_runs_while_somebody_listens() {
        let folder = std::env::temp_dir().join(format!("pacinian-servers-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("pulse")).unwrap();
        let lookup = |name: &str| (name == "XDG_RUNTIME_DIR").then(|| folder.to_str().unwrap().to_string());
        let running = || {
            let all = servers(lookup).into_iter().filter(|server| server.runs && server.name != "JACK");
            all.map(|server| server.name).collect::<Vec<_>>()
        };
        assert!(running().is_empty());
        let pipewire = UnixListener::bind(folder.join("pipewire-0")).unwrap();
        assert_eq!(running(), ["PipeWire"]);
        let _pulse = UnixListener::bind(folder.join("pulse/native")).unwrap();
        assert_eq!(running(), ["PipeWire", "PulseAudio"]);
        drop(pipewire);
        assert_eq!(running(), ["PulseAudio"], "its socket is left, and nobody listens");
        assert!(!has_jack(&folder, "default"));
        let _jack = UnixListener::bind(folder.join("jack_default_0_0")).unwrap();
        assert!(has_jack(&folder, "default") && !has_jack(&folder, "other"));
        for server in servers(|_| None) {
            assert!(server.built_in || server.help.contains("--features"), "{server:?}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
