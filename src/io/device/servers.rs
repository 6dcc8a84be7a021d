//! Sound servers: whether they run, and by what they are reached.

use std::path::{Path, PathBuf};

use serde::Serialize;

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
    /// How to start it, where it does not run; else nothing.
    #[serde(skip)]
    pub start: &'static str,
}

impl Server {
    /// Those of this system; none but on Linux, as other systems have one sound system of their own, which runs.
    pub fn all() -> Vec<Self> {
        if cfg!(target_os = "linux") { servers(|name| std::env::var(name).ok()) } else { Vec::new() }
    }

    /// The one of [`Server::all`] that a device's name or id begins with: `jack:...`, `pulse:...`.
    pub fn named(device: &str) -> Option<Self> {
        let host = device.split(':').next().unwrap_or(device).to_lowercase();
        let is = |server: &Self| server.is(&host) || (host == "pulse" && server.is("pulseaudio"));
        Self::all().into_iter().find(is)
    }

    /// Whether it runs and ALSA may hand its devices to it.
    pub fn may_be_behind_alsa(&self) -> bool {
        self.runs && self.name != "JACK"
    }

    /// Whether it is the sound system of that name.
    pub fn is(&self, host: &str) -> bool {
        self.name.eq_ignore_ascii_case(host)
    }
}

/// Those that there may be; `lookup` is the environment.
fn servers(lookup: impl Fn(&str) -> Option<String>) -> Vec<Server> {
    let path = |name: &str| lookup(name).filter(|path| !path.is_empty()).map(PathBuf::from);
    let runtime = path("XDG_RUNTIME_DIR");
    let pipewire = path("PIPEWIRE_RUNTIME_DIR").or_else(|| runtime.clone()).map(|folder| {
        folder.join(lookup("PIPEWIRE_REMOTE").filter(|name| !name.is_empty()).unwrap_or("pipewire-0".into()))
    });
    let pulse = path("PULSE_SERVER")
        .and_then(|server| server.to_str()?.strip_prefix("unix:").map(PathBuf::from))
        .or_else(|| path("PULSE_RUNTIME_PATH").map(|folder| folder.join("native")))
        .or_else(|| runtime.map(|folder| folder.join("pulse/native")));
    let jack = jack_name(lookup("JACK_DEFAULT_SERVER"));
    [
        (
            "PipeWire",
            pipewire.is_some_and(|path| answers(&path)),
            cfg!(feature = "pipewire"),
            [
                "systemctl --user start pipewire wireplumber (packages pipewire, wireplumber)",
                "cargo install --path . --features pipewire (packages libpipewire-0.3-dev, libclang-dev); or through ALSA (package pipewire-alsa), \
                 which mixes channels beyond 8 together",
            ],
        ),
        (
            "PulseAudio",
            pulse.is_some_and(|path| answers(&path)),
            cfg!(feature = "pulseaudio"),
            [
                "pulseaudio --start (package pulseaudio)",
                "cargo install --path . --features pulseaudio (no package); or through ALSA (package libasound2-plugins)",
            ],
        ),
        (
            "JACK",
            jack_at(Path::new(SHM), &jack).is_some(),
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
        Server { name, runs, built_in, help, start: if runs { "" } else { start } }
    })
    .to_vec()
}

/// Whether somebody listens there.
fn answers(socket: &Path) -> bool {
    #[cfg(unix)]
    return std::os::unix::net::UnixStream::connect(socket).is_ok();
    #[cfg(not(unix))]
    return socket.exists();
}

/// Where JACK's sockets are.
const SHM: &str = "/dev/shm";

/// What JACK's server is called.
fn jack_name(wanted: Option<String>) -> String {
    wanted.filter(|name| !name.is_empty()).unwrap_or("default".into())
}

/// The socket of JACK's server, where it runs.
pub(super) fn jack_socket() -> Option<PathBuf> {
    jack_at(Path::new(SHM), &jack_name(std::env::var("JACK_DEFAULT_SERVER").ok()))
}

/// The same of one of that name in a folder: `jack_NAME_USER_0`.
fn jack_at(folder: &Path, name: &str) -> Option<PathBuf> {
    let begins = format!("jack_{name}_");
    let sockets = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| {
        let file = entry.file_name();
        file.to_str().is_some_and(|file| file.starts_with(&begins) && file.ends_with("_0"))
    });
    sockets.map(|entry| entry.path()).find(|socket| answers(socket))
}

#[cfg(all(test, unix))]
mod tests {
    use super::{Server, jack_at, servers};
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
        assert_eq!(jack_at(&folder, "default"), None);
        let _jack = UnixListener::bind(folder.join("jack_default_0_0")).unwrap();
        assert!(jack_at(&folder, "default").is_some() && jack_at(&folder, "other").is_none());
        for server in servers(|_| None) {
            assert!(server.built_in || server.help.contains("--features"), "{server:?}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_server_is_a_system_by_its_name() {
        let is = |host: &str| servers(|_| None).iter().any(|server| server.is(host));
        for (host, due) in
            [("pipewire", true), ("pulseaudio", true), ("jack", true), ("alsa", false), ("wasapi", false)]
        {
            assert_eq!(is(host), due, "{host}");
        }
        let named = |device: &str| Server::named(device).map(|server| server.name);
        if cfg!(target_os = "linux") {
            assert_eq!(named("jack:system"), Some("JACK"));
            assert_eq!(named("Pulse:alsa_output.usb"), Some("PulseAudio"));
        }
        assert_eq!((named("alsa:hw:0"), named("USB Sound")), (None, None));
    }
}
