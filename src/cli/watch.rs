//! `play --watch`: what is saved takes over while it sounds.
//!
//! A thread of its own looks at the files, reads and compiles what was saved, sends it to the session and waits for its answer. What
//! became of it is told to who shows the session; one save is dealt with after the other.

use super::failure::Failure;
use super::load::Scene;
use super::loaded::Loaded;
use super::named::named;
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Wish;
use pacinian::io::parting::part_with;
use pacinian::io::{assets::Folder, error::FileErrorKind, journal::files::Files, text, watch};
use pacinian::knob::effect::program::Any;
use pacinian::live::reload::Reload;
use pacinian::live::signal::{Handle, Refused, Signal};
use pacinian::patch::{Patch, Permissions};
use pacinian::rig::Rig;
use pacinian::text::problem::escaped;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// What became of something that was saved.
#[derive(Debug)]
pub enum News {
    /// It plays now. What it is, the patterns that play from the beginning, which files are different, and what its knob is to be.
    Took(Box<Loaded>, Vec<usize>, Vec<PathBuf>, Vec<Any>),
    /// It cannot be played at all.
    Broken(Failure),
    /// It cannot take over while something else plays: why, and what to do.
    Kept(String, String),
}

/// What a session says to a scene that is to take over: taken, or why not.
pub type Verdict = Result<(), String>;

/// How the session began that goes on with what is saved.
pub struct Course {
    /// What is read again.
    pub scene: Scene,
    /// The rate that the device runs at.
    pub device_rate: f64,
    /// `--device`.
    pub device: Option<String>,
    /// What was wished for: nothing that is saved can change it.
    pub wish: Wish,
    /// The rate that the rig asked for.
    pub rate: Option<f64>,
    /// The input that the rig named, and `--input-device`.
    pub input: Option<String>,
    /// See `input`.
    pub input_device: Option<String>,
    /// Channels of the input (from 0) that were listened to from the beginning: no others are heard.
    pub heard: Vec<usize>,
    /// The first of them by which a knob on a line is heard; 0: none is.
    pub knob_channel: usize,
    /// Channels of the device.
    pub channels: usize,
    /// Where the recordings are kept of a journal, which writes down what takes over; `None`: none is kept.
    pub files: Option<Files>,
}

/// Looks at files until it is dropped.
pub struct Watching {
    news: Receiver<News>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Scene {
    /// The files that `--watch` looks at: patch and rig, and the recordings and tables that the patch names, as far as it can be read.
    pub fn watched(&self) -> Vec<PathBuf> {
        let mut all: Vec<PathBuf> = vec![self.patch.clone()];
        all.extend(self.rig.clone());
        if let Some((path, bytes)) = self.rig.as_ref().and_then(|path| Some((path, text::read(path).ok()?)))
            && let Ok(rig) = Rig::draft("", &bytes)
        {
            let folder = path.parent().unwrap_or(Path::new(""));
            all.extend(rig.value.calibrations.iter().filter_map(|c| Some(folder.join(c.file.as_ref()?))));
        }
        let may = Permissions { allow_outside: self.allow_outside };
        if let Some(patch) = text::read(&self.patch).ok().and_then(|bytes| Patch::readable(&bytes, may)) {
            let folder = Folder::new(self.root()).allow_outside(self.allow_outside);
            let outside =
                |path: &str| folder.resolve(path).is_err_and(|error| error.kind == FileErrorKind::Outside);
            // As they are written, so that a link which is turned elsewhere is noticed.
            all.extend(
                named(&patch).filter(|(path, _)| !outside(path)).map(|(path, _)| self.root().join(path)),
            );
        }
        all
    }

    /// Refuses to look at what is read but once.
    ///
    /// # Errors
    /// Of usage.
    pub fn check_watch(&self) -> Result<(), Failure> {
        let files = [("the patch", Some(&self.patch)), ("the rig", self.rig.as_ref())];
        for (which, path) in files {
            if path.is_some_and(|path| text::is_stream(path)) {
                return Err(Failure::usage(
                    format!("--watch looks at files, and {which} comes through a pipe"),
                    "save it to a file and name that, or leave --watch out",
                ));
            }
        }
        Ok(())
    }
}

impl Watching {
    /// Looks at what `course` was read from since `since`, and sends what is saved to the session; before, does what is to be done `first`.
    ///
    /// # Errors
    /// What the system says where it gives no thread.
    pub fn begin(
        course: Course,
        since: SystemTime,
        session: Handle,
        verdicts: Receiver<Verdict>,
        first: impl FnOnce() + Send + 'static,
    ) -> std::io::Result<Self> {
        let (tell, news) = channel();
        let stop = Arc::<AtomicBool>::default();
        let mut watch = watch::Watch::default();
        watch.follow(course.scene.watched(), since);
        let mut watcher = Watcher { course, watch, session, verdicts, tell, stop: Arc::clone(&stop) };
        let work = move || {
            first();
            while watcher.turn().is_some() {}
        };
        let thread = std::thread::Builder::new().name("watch".into()).spawn(work)?;
        Ok(Self { news, stop, thread: Some(thread) })
    }

    /// What became of what was saved since this was asked last.
    pub fn news(&self) -> impl Iterator<Item = News> {
        self.news.try_iter()
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            part_with(thread, PATIENCE);
        }
    }
}

/// So long a thread may take to end before it is left to itself: it may be in the middle of a large file, or wait for a share that is
/// gone, and a session must end all the same.
const PATIENCE: Duration = Duration::from_millis(200);

struct Watcher {
    course: Course,
    watch: watch::Watch,
    session: Handle,
    verdicts: Receiver<Verdict>,
    tell: Sender<News>,
    stop: Arc<AtomicBool>,
}

impl Watcher {
    /// Waits for something to be saved, and deals with it; `None` when the session is over.
    fn turn(&mut self) -> Option<()> {
        let stop = Arc::clone(&self.stop);
        let changed = self.watch.wait(|| stop.load(Ordering::Relaxed))?;
        let since = SystemTime::now();
        let loaded = self.course.scene.load(true, None);
        let mut paths = self.course.scene.watched();
        if loaded.is_err() {
            // What it named before is named by what plays.
            paths.extend(self.watch.paths().map(PathBuf::from));
        }
        self.watch.follow(paths, since);
        let news = match loaded.and_then(|loaded| self.course.compile(loaded)) {
            Err(failure) => self.broken(failure),
            Ok(Err((why, help))) => {
                self.in_vain(format!("{why}; {help}"));
                News::Kept(why, help)
            }
            Ok(Ok((mut loaded, reload))) => {
                let first = reload.scene.patterns.clone();
                let effects = reload.scene.plan.knob.as_ref().map(|knob| knob.setup.effects.clone());
                match self.send(&mut loaded, reload)? {
                    Ok(Ok(())) => News::Took(loaded, first, changed, effects.unwrap_or_default()),
                    // The session has said so itself.
                    Ok(Err(why)) => News::Kept(why, AGAIN.into()),
                    Err(failure) => self.broken(failure),
                }
            }
        };
        self.tell.send(news).ok()
    }

    fn broken(&self, failure: Failure) -> News {
        self.in_vain(failure.brief());
        News::Broken(failure)
    }

    /// What was saved does not get as far as the session, whose journal is to say why.
    fn in_vain(&self, why: String) {
        // Where there is no room for it now, it is shown all the same.
        let _ = self.session.send(Signal::Vain("reload".into(), why));
    }

    /// Sends it to the session and waits for the answer; `None` when the session is over.
    fn send(&self, loaded: &mut Loaded, mut reload: Reload) -> Option<Result<Verdict, Failure>> {
        loop {
            match self.session.send(Signal::Reload(Box::new(reload))) {
                Ok(()) => break,
                Err(Refused::Ended) => return None,
                Err(Refused::Busy) if self.stop.load(Ordering::Relaxed) => return None,
                Err(Refused::Busy) => std::thread::sleep(Duration::from_millis(20)),
            }
            reload = match self.course.reload(loaded) {
                Ok(reload) => reload,
                Err(failure) => return Some(Err(failure)),
            };
        }
        loop {
            match self.verdicts.recv_timeout(Duration::from_millis(20)) {
                Ok(verdict) => return Some(Ok(verdict)),
                Err(RecvTimeoutError::Timeout) if !self.stop.load(Ordering::Relaxed) => {}
                Err(_) => return None,
            }
        }
    }
}

/// What to do about what cannot take over.
const AGAIN: &str = "stop, and play again";

/// Ready to take over, or why it cannot and what to do.
type Compiled = Result<(Box<Loaded>, Reload), (String, String)>;

impl Course {
    /// Compiles it for the session, or says why it needs another.
    fn compile(&self, mut loaded: Loaded) -> Result<Compiled, Failure> {
        let device = &loaded.rig.device;
        let of = |file: &str, why: String| {
            let why = if file.is_empty() { why } else { format!("{}: {why}", escaped(file)) };
            Ok(Err((why, AGAIN.to_string())))
        };
        let rig_file = loaded.rig_source.as_ref().map_or("", |source| &*source.file);
        let no = |why: String| of(rig_file, why);
        if Wish::of(self.device.as_deref(), device.name.as_deref()) != self.wish {
            return no(match &device.name {
                Some(name) => format!("the rig names another device, `{name}`"),
                None => "the rig names no device any more".into(),
            });
        }
        if self.scene.rate.is_none() && device.rate != self.rate {
            let rate =
                device.rate.map_or("no rate any more".into(), |rate| format!("another rate, {rate} Hz"));
            return no(format!("the rig says {rate}, and {} Hz play", self.device_rate));
        }
        let by_rig = self.input_device.is_none() && self.scene.input.is_none();
        if by_rig && device.input != self.input {
            return no("the rig names another input".into());
        }
        let channels = device.channels as usize;
        if channels != self.channels {
            let began = format!("{channels} channels, and the session began with {}", self.channels);
            return match self.scene.rig.is_some() {
                true => no(format!("the rig has {began}")),
                false => of(&loaded.patch.origin.file, format!("the patch needs {began}")),
            };
        }
        let hears = !by_rig || device.input.is_some();
        let reload = self.reload(&mut loaded)?;
        let unheard = reload.scene.plan.inputs().into_iter().find(|channel| !self.heard.contains(channel));
        if let Some(channel) = unheard.filter(|_| hears) {
            let why = format!(
                "the patch listens to channel {} of the input, and the session does not",
                channel + 1
            );
            return of(&loaded.patch.origin.file, why);
        }
        Ok(Ok((Box::new(loaded), reload)))
    }

    /// Ready to take over, with its recordings kept.
    fn reload(&self, loaded: &mut Loaded) -> Result<Reload, Failure> {
        let options = self.options(loaded);
        let reload = loaded.reload(&options, self.files.is_some())?;
        if let Some((files, made_of)) = self.files.as_ref().zip(reload.provenance.as_ref()) {
            files.keep(&loaded.folder, &loaded.patch, made_of)?;
        }
        Ok(reload)
    }

    fn options(&self, loaded: &Loaded) -> Options {
        let (rate, knob_channel) = (Some(self.device_rate), self.knob_channel);
        Options { rate, live: true, knob_channel, ..loaded.options.clone() }
    }
}
