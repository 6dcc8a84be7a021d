//! Files that are looked at again and again: which of them say something else than before, once they have been left alone.
//!
//! Looking needs no help from the system, so it works on every disk and share, and for every way of saving: in place, by renaming
//! another file over it, through a link that is turned elsewhere. A file that is gone, or is a folder now, says something else,
//! too; why it cannot be read, whoever reads it finds out.
//!
//! ```no_run
//! let mut watch = pacinian::io::watch::Watch::of(["patch.toml"]);
//! while let Some(changed) = watch.wait(|| false) {
//!     println!("{changed:?}: {:?}", pacinian::io::load::patch("patch.toml"));
//! }
//! ```

use std::fs::{File, Metadata};
use std::hash::{DefaultHasher, Hasher};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// From one look to the next.
pub const EVERY: Duration = Duration::from_millis(100);

/// So long a file is left alone before what stands in it counts: whoever saves in two strokes has not saved half of it.
pub const SETTLE: Duration = Duration::from_millis(200);

/// The same of a file that breaks off in the middle of a line, as it did not before: somebody still writes it, over a slow network perhaps.
const BROKEN_OFF: Duration = Duration::from_secs(2);

/// So long files that have settled wait for others that have not: what is saved together is told together.
const TOGETHER: Duration = Duration::from_secs(1);

/// So long after a file was touched, what stands in it is read though its length and time are the same: some disks tell time in steps
/// of two seconds.
const COARSE: Duration = Duration::from_millis(2500);

/// Larger files are not read at all: they say something else when the system says so.
const SMALL: u64 = 1 << 20;

/// Files that are looked at.
#[derive(Debug, Default)]
pub struct Watch {
    places: Vec<Place>,
}

#[derive(Debug)]
struct Place {
    path: PathBuf,
    about: About,
    /// What was read last, and what was told last.
    seen: Content,
    told: Content,
    /// Whether the last line had an end when bytes stood there last, whatever came after: it may have been gone meanwhile.
    whole: bool,
    /// When it was touched last, if that has not been told.
    restless: Option<Instant>,
    /// Until when it is read though nothing about it is different.
    fresh: Instant,
}

/// What the system says about a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum About {
    File {
        length: u64,
        modified: Option<SystemTime>,
        /// Device and number, where there are such.
        number: (u64, u64),
    },
    Folder,
    /// A pipe or a device, which are not read: which one.
    Other((u64, u64)),
    Not(ErrorKind),
}

/// What stands there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Content {
    Bytes {
        length: u64,
        hash: u64,
        /// Whether its last line has an end.
        ended: bool,
    },
    /// More than is read.
    Large(About),
    Folder,
    Other((u64, u64)),
    Not(ErrorKind),
    /// It was touched before anything was read here.
    Unknown,
}

impl Watch {
    /// These files, as they are now; whoever reads them afterwards misses nothing.
    pub fn of<P: Into<PathBuf>>(paths: impl IntoIterator<Item = P>) -> Self {
        let mut watch = Self::default();
        watch.look_at_these(paths, None);
        watch
    }

    /// From now on these files. Of those that it looks at already it knows what it knew; of others, whether they were written at
    /// `since` or later, when somebody may have read them: those will be told.
    pub fn follow<P: Into<PathBuf>>(&mut self, paths: impl IntoIterator<Item = P>, since: SystemTime) {
        self.look_at_these(paths, Some(since));
    }

    fn look_at_these<P: Into<PathBuf>>(
        &mut self,
        paths: impl IntoIterator<Item = P>,
        since: Option<SystemTime>,
    ) {
        let now = Instant::now();
        let mut before = std::mem::take(&mut self.places);
        for path in paths {
            let path = path.into();
            if self.places.iter().any(|place| place.path == path) {
                continue;
            }
            let known = before.iter().position(|place| place.path == path);
            self.places.push(match known {
                Some(number) => before.swap_remove(number),
                None => Place::new(path, since, now),
            });
        }
    }

    /// The files that it looks at.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.places.iter().map(|place| place.path.as_path())
    }

    /// Looks at all of them. Gives those that say something else than what was told of them last, once they have been left alone
    /// for [`SETTLE`], ten times as long where one breaks off in the middle of a line and did not before. A file of more than a mebibyte is not read, and counts as something else when its length, time or number is.
    pub fn look(&mut self) -> Vec<PathBuf> {
        self.look_at(Instant::now(), &|| false)
    }

    /// Looks until some say something else, or `stop` says so: then `None`.
    pub fn wait(&mut self, stop: impl Fn() -> bool) -> Option<Vec<PathBuf>> {
        loop {
            if stop() {
                return None;
            }
            let changed = self.look_at(Instant::now(), &stop);
            if !changed.is_empty() {
                return Some(changed);
            }
            std::thread::sleep(EVERY);
        }
    }

    /// Nothing where `stop` says so meanwhile, which it is asked between files: a share may be slow.
    fn look_at(&mut self, now: Instant, stop: &dyn Fn() -> bool) -> Vec<PathBuf> {
        for place in &mut self.places {
            if stop() {
                return Vec::new();
            }
            place.look(now);
        }
        let beyond = || self.places.iter().filter_map(|place| place.beyond(now));
        let Some(longest) = beyond().flatten().max() else { return Vec::new() };
        let breaks_off = |place: &Place| place.beyond(now) == Some(None) && place.breaks_off();
        let together = if self.places.iter().any(breaks_off) { BROKEN_OFF } else { TOGETHER };
        if beyond().any(|beyond| beyond.is_none()) && longest < together {
            return Vec::new();
        }
        let told = |place: &mut Place| (!stop() && place.tell(now)).then(|| place.path.clone());
        self.places.iter_mut().filter_map(told).collect()
    }
}

impl Place {
    fn new(path: PathBuf, since: Option<SystemTime>, now: Instant) -> Self {
        let about = About::of(&path);
        let seen = Content::of(&path, about);
        // A disk's clock may be that of the last tick.
        let since = since.map(|since| since - Duration::from_millis(10));
        let young =
            matches!(about, About::File { modified: Some(at), .. } if since.is_some_and(|since| at >= since));
        let told = if young { Content::Unknown } else { seen };
        let whole = seen.is_whole().unwrap_or(false);
        Self { path, about, seen, told, whole, restless: young.then_some(now), fresh: now + COARSE }
    }

    fn look(&mut self, now: Instant) {
        let about = About::of(&self.path);
        let touched = about != self.about;
        self.about = about;
        if touched {
            self.fresh = now + COARSE;
        }
        let rewritten = now < self.fresh && {
            let content = Content::of(&self.path, about);
            content != std::mem::replace(&mut self.seen, content)
        };
        if touched || rewritten {
            self.restless = Some(now);
        }
    }

    /// Whether it breaks off in the middle of a line, and did not before.
    fn breaks_off(&self) -> bool {
        self.whole && self.seen.is_whole() == Some(false)
    }

    /// If it was touched: for how long it has settled, `None` where it has not.
    fn beyond(&self, now: Instant) -> Option<Option<Duration>> {
        let settles = if self.breaks_off() { BROKEN_OFF } else { SETTLE };
        self.restless.map(|since| now.saturating_duration_since(since).checked_sub(settles))
    }

    /// Whether it has settled on something else.
    fn tell(&mut self, now: Instant) -> bool {
        if self.beyond(now).flatten().is_none() {
            return false;
        }
        self.restless = None;
        self.seen = Content::of(&self.path, self.about);
        self.whole = self.seen.is_whole().unwrap_or(self.whole);
        self.seen != std::mem::replace(&mut self.told, self.seen)
    }
}

impl About {
    fn of(path: &Path) -> Self {
        match std::fs::metadata(path) {
            Ok(about) if about.is_dir() => Self::Folder,
            Ok(about) if about.is_file() => {
                Self::File { length: about.len(), modified: about.modified().ok(), number: number(&about) }
            }
            Ok(about) => Self::Other(number(&about)),
            Err(error) => Self::Not(error.kind()),
        }
    }
}

#[cfg(unix)]
fn number(about: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (about.dev(), about.ino())
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> (u64, u64) {
    (0, 0)
}

impl Content {
    fn of(path: &Path, about: About) -> Self {
        let read = |path: &Path| -> std::io::Result<Self> {
            // It may grow while it is read.
            let (mut file, mut hasher) = (File::open(path)?.take(SMALL + 1), DefaultHasher::new());
            let (mut bytes, mut length, mut last) = (vec![0; 1 << 16], 0, None);
            loop {
                match file.read(&mut bytes) {
                    Ok(0) => {
                        let ended = last == Some(b'\n');
                        return Ok(Self::Bytes { length, hash: hasher.finish(), ended });
                    }
                    Ok(count) => {
                        let read = bytes.get(..count).unwrap_or_default();
                        length += count as u64;
                        last = read.last().copied().or(last);
                        hasher.write(read);
                    }
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        };
        match about {
            About::File { length, .. } if length > SMALL => Self::Large(about),
            About::File { .. } => read(path).unwrap_or_else(|error| Self::Not(error.kind())),
            About::Folder => Self::Folder,
            About::Other(which) => Self::Other(which),
            About::Not(why) => Self::Not(why),
        }
    }

    /// Whether its last line has an end; `None` where no bytes stand.
    fn is_whole(self) -> Option<bool> {
        match self {
            Self::Bytes { ended, .. } => Some(ended),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BROKEN_OFF, COARSE, SETTLE, TOGETHER, Watch};
    use std::fs;
    use std::path::PathBuf;
    use std::time::{Duration, Instant, SystemTime};

    /// A folder with files, and a clock that goes when the test says so.
    struct Bench {
        folder: PathBuf,
        watch: Watch,
        now: Instant,
    }

    const STEP: Duration = Duration::from_millis(50);

    impl Bench {
        fn new(name: &str, files: &[&str]) -> Self {
            let folder = std::env::temp_dir().join(format!("pacinian-watch-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
            files.iter().for_each(|file| fs::write(folder.join(file), "one").unwrap());
            let watch = Watch::of(files.iter().map(|file| folder.join(file)));
            Self { folder, watch, now: Instant::now() }
        }

        fn path(&self, name: &str) -> PathBuf {
            self.folder.join(name)
        }

        /// What is told within so long.
        fn told(&mut self, within: Duration) -> Vec<String> {
            let (until, mut told) = (self.now + within, Vec::new());
            while self.now < until {
                self.now += STEP;
                let name = |path: PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
                told.extend(self.watch.look_at(self.now, &|| false).into_iter().map(name));
            }
            told
        }
    }

    impl Drop for Bench {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.folder);
        }
    }

    const SOON: Duration = Duration::from_millis(600);

    #[test]
    fn every_way_of_saving_is_told_once() {
        let mut bench = Bench::new("ways", &["a"]);
        let file = bench.path("a");
        assert!(bench.told(SOON).is_empty());
        fs::write(&file, "in place").unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        fs::write(bench.path("b"), "renamed!").unwrap();
        fs::rename(bench.path("b"), &file).unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        fs::remove_file(&file).unwrap();
        assert_eq!(bench.told(SOON), ["a"], "gone");
        assert!(bench.told(SOON).is_empty());
        fs::create_dir(&file).unwrap();
        assert_eq!(bench.told(SOON), ["a"], "a folder");
        fs::remove_dir(&file).unwrap();
        fs::write(&file, "back").unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        // Nothing else stands in it.
        fs::write(&file, "back").unwrap();
        fs::remove_file(&file).unwrap();
        bench.told(STEP);
        fs::write(&file, "back").unwrap();
        assert!(bench.told(SOON).is_empty());
        #[cfg(unix)]
        {
            fs::write(bench.path("c"), "linked").unwrap();
            fs::remove_file(&file).unwrap();
            std::os::unix::fs::symlink("c", &file).unwrap();
            assert_eq!(bench.told(SOON), ["a"]);
            fs::write(bench.path("c"), "behind the link").unwrap();
            assert_eq!(bench.told(SOON), ["a"]);
            fs::remove_file(&file).unwrap();
            let _socket = std::os::unix::net::UnixListener::bind(&file).unwrap();
            assert_eq!(bench.told(SOON), ["a"], "what is not read");
            fs::remove_file(&file).unwrap();
            std::os::unix::fs::symlink("/dev/null", &file).unwrap();
            assert_eq!(bench.told(SOON), ["a"], "something else that is not read");
        }
    }

    /// However large it is: three gibibytes are looked at here hundreds of times.
    #[test]
    fn a_large_file_is_not_read() {
        let mut bench = Bench::new("large", &["a"]);
        let large = bench.path("large");
        let file = fs::File::create(&large).unwrap();
        file.set_len(3 << 30).unwrap();
        let seen = |bench: &Bench| bench.watch.places.last().unwrap().seen;
        bench.watch.follow([bench.path("a"), large.clone()], SystemTime::now() + Duration::from_secs(60));
        assert!(matches!(seen(&bench), super::Content::Large(_)));
        assert!(bench.told(2 * COARSE).is_empty());
        file.set_len((3 << 30) + 1).unwrap();
        assert_eq!(bench.told(SOON), ["large"]);
        file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert_eq!(bench.told(SOON), ["large"]);
        assert!(matches!(seen(&bench), super::Content::Large(_)));
        // A small one from now on, and then large again.
        fs::write(&large, "one").unwrap();
        assert_eq!(bench.told(SOON), ["large"]);
        assert!(matches!(seen(&bench), super::Content::Bytes { length: 3, .. }));
        fs::File::options().write(true).open(&large).unwrap().set_len(super::SMALL + 1).unwrap();
        assert_eq!(bench.told(SOON), ["large"]);
        assert!(matches!(seen(&bench), super::Content::Large(_)));
    }

    #[test]
    fn whoever_stops_is_not_kept_waiting_by_the_rest_of_the_files() {
        let bench = &mut Bench::new("stop", &["a", "b", "c"]);
        let asked = std::cell::Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > 2
        };
        ["a", "b", "c"].iter().for_each(|file| fs::write(bench.path(file), "new").unwrap());
        assert_eq!(bench.watch.wait(stop), None);
        // Asked once before, and then before each file: one was looked at.
        let looked = bench.watch.places.iter().filter(|place| place.restless.is_some()).count();
        assert_eq!((asked.get(), looked), (4, 1));
    }

    #[test]
    fn what_is_still_written_is_waited_for() {
        let mut bench = Bench::new("half", &["a"]);
        let mut text = String::new();
        for _ in 0..20 {
            text.push('x');
            fs::write(bench.path("a"), &text).unwrap();
            assert!(bench.told(SETTLE - STEP).is_empty());
        }
        assert_eq!(bench.told(2 * STEP), ["a"]);
    }

    #[test]
    fn what_breaks_off_in_a_line_is_waited_for_longer() {
        let mut bench = Bench::new("broken", &["a"]);
        fs::write(bench.path("a"), "one\ntwo\n").unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        // The rest comes much later, as from a slow network.
        fs::write(bench.path("a"), "three\nfo").unwrap();
        assert!(bench.told(BROKEN_OFF - 2 * STEP).is_empty());
        fs::write(bench.path("a"), "three\nfour\n").unwrap();
        assert!(bench.told(SETTLE - STEP).is_empty());
        assert_eq!(bench.told(2 * STEP), ["a"]);
        // It was gone meanwhile, or was a folder.
        for folder in [false, true] {
            fs::remove_file(bench.path("a")).unwrap();
            folder.then(|| fs::create_dir(bench.path("a")).unwrap());
            assert_eq!(bench.told(SOON), ["a"]);
            folder.then(|| fs::remove_dir(bench.path("a")).unwrap());
            fs::write(bench.path("a"), "five\nsi").unwrap();
            assert!(bench.told(BROKEN_OFF - 2 * STEP).is_empty());
            fs::write(bench.path("a"), "five\nsix\n").unwrap();
            assert_eq!(bench.told(SOON), ["a"]);
        }
        // Nor is what is saved beside it told without it.
        let mut bench = Bench::new("beside", &["a", "b"]);
        fs::write(bench.path("a"), "one\ntwo\n").unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        fs::write(bench.path("a"), "three\nfo").unwrap();
        fs::write(bench.path("b"), "new").unwrap();
        assert!(bench.told(BROKEN_OFF - 2 * STEP).is_empty());
        fs::write(bench.path("a"), "three\nfour\n").unwrap();
        let told = bench.told(SETTLE + 2 * STEP);
        assert!(told.contains(&"a".to_string()) && told.contains(&"b".to_string()), "{told:?}");
        // Nothing comes: so it is to be.
        fs::write(bench.path("a"), "five").unwrap();
        assert_eq!(bench.told(BROKEN_OFF + 2 * STEP), ["a"]);
        fs::write(bench.path("a"), "six").unwrap();
        assert_eq!(bench.told(SETTLE + 2 * STEP), ["a"], "as it was before");
    }

    #[test]
    fn the_same_length_at_the_same_time_is_seen() {
        let mut bench = Bench::new("same", &["a"]);
        let time = fs::metadata(bench.path("a")).unwrap().modified().unwrap();
        fs::write(bench.path("a"), "two").unwrap();
        fs::File::options().write(true).open(bench.path("a")).unwrap().set_modified(time).unwrap();
        assert_eq!(bench.told(SOON), ["a"]);
        // Long after, nobody reads it again without a reason.
        bench.told(2 * COARSE);
        let time = fs::metadata(bench.path("a")).unwrap().modified().unwrap();
        fs::write(bench.path("a"), "six").unwrap();
        fs::File::options().write(true).open(bench.path("a")).unwrap().set_modified(time).unwrap();
        assert!(bench.told(SOON).is_empty());
    }

    #[test]
    fn what_is_saved_together_is_told_together_but_not_waited_for_for_ever() {
        let mut bench = Bench::new("together", &["a", "b"]);
        fs::write(bench.path("a"), "new").unwrap();
        assert!(bench.told(3 * STEP).is_empty());
        fs::write(bench.path("b"), "new").unwrap();
        assert!(bench.told(SETTLE - STEP).is_empty());
        assert_eq!(bench.told(2 * STEP), ["a", "b"]);
        // One to which somebody writes all the time.
        fs::write(bench.path("a"), "newer").unwrap();
        let mut told = Vec::new();
        for n in 0..(2 * TOGETHER).as_millis() / STEP.as_millis() {
            fs::write(bench.path("b"), "x".repeat(n as usize)).unwrap();
            told.extend(bench.told(STEP));
        }
        assert_eq!(told, ["a"]);
    }

    #[test]
    fn what_was_written_while_somebody_read_is_told() {
        let mut bench = Bench::new("since", &["a"]);
        let since = SystemTime::now();
        fs::write(bench.path("new"), "two").unwrap();
        let both = [bench.path("a"), bench.path("new"), bench.path("a"), bench.path("none")];
        bench.watch.follow(both, since);
        assert_eq!(bench.watch.paths().count(), 3);
        assert_eq!(bench.told(SOON), ["new"]);
        // Not of those that it no longer looks at.
        bench.watch.follow([bench.path("none")], SystemTime::now());
        fs::write(bench.path("a"), "three").unwrap();
        fs::write(bench.path("none"), "there").unwrap();
        assert_eq!(bench.told(SOON), ["none"]);
    }
}
