//! The audio thread takes no lock: in what it runs there is none, and it calls none of the system's.
//!
//! A lock of Rust's own that is free is taken without a call that could be seen, so that those are looked for where they would stand:
//! in the sources of the rooms that run on the audio thread. What comes from elsewhere, libraries in C among them, is seen as it runs.

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms that run on the audio thread, all of them marked so that clippy refuses in them what they may not do.
const ROOMS: [&str; 29] = [
    "actuator/mod.rs",
    "dsp/mod.rs",
    "engine/mod.rs",
    "knob/mod.rs",
    "node/mod.rs",
    "perception/mod.rs",
    "schedule/mod.rs",
    "space/mod.rs",
    "io/device/ahead.rs",
    "io/device/capture.rs",
    "io/device/card.rs",
    "live/board.rs",
    "live/called_off.rs",
    "live/callback.rs",
    "live/clock.rs",
    "live/device_delay.rs",
    "live/driver.rs",
    "live/effort.rs",
    "live/gate.rs",
    "live/intake.rs",
    "live/lately.rs",
    "live/lent.rs",
    "live/lever.rs",
    "live/load.rs",
    "live/relief.rs",
    "live/remote.rs",
    "live/steps.rs",
    "live/torque.rs",
    "live/tracker.rs",
];

/// What locks, waits, or asks the system for something.
const REFUSED: [&str; 23] = [
    "Mutex",
    "RwLock",
    "Condvar",
    "Barrier",
    "mpsc",
    "OnceLock",
    "LazyLock",
    "OnceCell",
    "parking_lot",
    "crossbeam_channel",
    "println!",
    "eprintln!",
    "print!",
    "eprint!",
    "dbg!",
    "stdout",
    "stderr",
    "std::fs",
    "std::net",
    "std::process",
    "std::env",
    "thread::",
    "Instant::now",
];

/// Where one of them stands all the same, and why.
const ALLOWED: [(&str, &str, &str); 7] = [
    ("dsp/fractional.rs", "Mutex", "tables, made when an engine is made"),
    ("dsp/recording.rs", "Mutex", "copies of a recording, made when an engine is made"),
    ("dsp/recording.rs", "OnceLock", "where those are kept"),
    ("dsp/corner.rs", "OnceLock", "a table, made when an engine is made"),
    ("dsp/wavetable.rs", "OnceLock", "tables, made when an engine is made"),
    ("live/lent.rs", "mpsc", "by which a driver goes home when a device has dropped it"),
    ("actuator/identify", "", "reads measurements, on no audio thread"),
];

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// All files of Rust below a folder, tests left out.
fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match path.is_dir() {
            true if name != "tests" => files(&path, all),
            false if name.ends_with(".rs") && name != "tests.rs" => all.push(path),
            _ => {}
        }
    }
}

/// What a file says beside its tests and comments.
fn code(text: &str) -> String {
    let lines = text.lines().take_while(|line| !line.trim_start().starts_with("#[cfg(test)]"));
    lines.map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Which refused words stand in some code, as words of their own.
fn refused(code: &str) -> Vec<&'static str> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let stands = |wanted: &&'static str| {
        code.match_indices(*wanted).any(|(at, _)| {
            let behind = &code[at + wanted.len()..];
            !code[..at].ends_with(word) && (!wanted.ends_with(word) || !behind.starts_with(word))
        })
    };
    REFUSED.into_iter().filter(stands).collect()
}

#[test]
fn in_what_the_audio_thread_runs_no_lock_stands() {
    let source = sources();
    let (mut found, mut looked) = (BTreeSet::new(), 0);
    for room in ROOMS {
        let head = source.join(room);
        let mut all = vec![head.clone()];
        let folder = match head.file_name().unwrap() == "mod.rs" {
            true => head.parent().unwrap().to_path_buf(),
            false => head.with_extension(""),
        };
        if folder.is_dir() {
            files(&folder, &mut all);
        }
        for path in all {
            let name = path.strip_prefix(&source).unwrap().to_string_lossy().replace('\\', "/");
            looked += 1;
            for word in refused(&code(&fs::read_to_string(&path).unwrap())) {
                let known = ALLOWED.iter().position(|(file, known, _)| {
                    name.starts_with(file) && (known.is_empty() || *known == word)
                });
                match known {
                    Some(n) => _ = found.insert(n),
                    None => panic!("{name}: {word} has no place on the audio thread"),
                }
            }
        }
    }
    assert!(looked > 200, "{looked} files");
    let idle: Vec<_> = (0..ALLOWED.len()).filter(|n| !found.contains(n)).map(|n| ALLOWED[n]).collect();
    assert!(idle.iter().all(|(_, word, _)| word.is_empty()), "no longer there: {idle:?}");
}

/// Every room has the mark by which clippy refuses calls, and every file with that mark is looked through here.
#[test]
fn rooms_are_marked_and_all_that_are_marked_are_rooms() {
    let source = sources();
    let mut all = Vec::new();
    files(&source, &mut all);
    let marked = all.iter().filter(|path| {
        fs::read_to_string(path).unwrap().lines().any(|line| line == "#![deny(clippy::disallowed_methods)]")
    });
    let marked: BTreeSet<String> = marked
        .map(|path| path.strip_prefix(&source).unwrap().to_string_lossy().replace('\\', "/"))
        .filter(|name| !OTHERS.contains(&name.as_str()))
        .collect();
    assert_eq!(marked, ROOMS.iter().map(|room| room.to_string()).collect());
}

/// Marked for another thread that must not wait either.
const OTHERS: [&str; 1] = ["live/local.rs"];

#[test]
fn words_are_found_in_code_and_nowhere_else() {
    let text = "use std::sync::{Arc, Mutex};\n// RwLock\nlet mpsc_like = Ring::new(); // Condvar\nlet t = thread::current();\n#[cfg(test)]\nmod tests { dbg!(1) }\n";
    assert_eq!(refused(&code(text)), ["Mutex", "thread::"]);
    assert!(refused("let x = Mutexes::new(); reprint!(3); MyInstant::now()").is_empty());
}

/// Calls of the C library that lock, and its call of the system by number, by which Rust's own locks wait. Who waits for a condition has
/// locked before.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod calls {
    use std::cell::Cell;
    use std::ffi::{CStr, c_int, c_long, c_void};
    use std::sync::atomic::{AtomicUsize, Ordering};

    thread_local! {
        static COUNT: Cell<Option<u64>> = const { Cell::new(None) };
    }

    /// One more call of this thread, if they are counted.
    fn count() {
        let _ = COUNT.try_with(|count| count.set(count.get().map(|n| n + 1)));
    }

    /// Those of this thread while `work` runs.
    pub fn counted(work: impl FnOnce()) -> u64 {
        COUNT.with(|count| count.set(Some(0)));
        work();
        COUNT.with(|count| count.replace(None)).unwrap_or(0)
    }

    /// The library's own function of a name, looked up once.
    fn own(place: &AtomicUsize, name: &CStr) -> *mut c_void {
        let known = place.load(Ordering::Relaxed);
        if known != 0 {
            return known as *mut c_void;
        }
        // SAFETY: a name that ends in 0; what is found is only called with the type that it has.
        let found = unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) };
        place.store(found as usize, Ordering::Relaxed);
        found
    }

    macro_rules! counts {
        ($($name:ident($($argument:ident: $kind:ty),*) -> $result:ty;)*) => {$(
            /// # Safety
            /// As the function of this name in the C library, to which it goes.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $kind),*) -> $result {
                static OWN: AtomicUsize = AtomicUsize::new(0);
                count();
                let own = own(&OWN, const {
                    match CStr::from_bytes_with_nul(concat!(stringify!($name), "\0").as_bytes()) {
                        Ok(name) => name,
                        Err(_) => panic!(),
                    }
                });
                // SAFETY: it is the function of this name, and has this type; the caller's promise, handed on.
                unsafe {
                    let own: unsafe extern "C" fn($($kind),*) -> $result = std::mem::transmute(own);
                    own($($argument),*)
                }
            }
        )*};
    }

    counts! {
        pthread_mutex_lock(mutex: *mut c_void) -> c_int;
        pthread_mutex_trylock(mutex: *mut c_void) -> c_int;
        pthread_mutex_timedlock(mutex: *mut c_void, until: *const c_void) -> c_int;
        pthread_rwlock_rdlock(lock: *mut c_void) -> c_int;
        pthread_rwlock_tryrdlock(lock: *mut c_void) -> c_int;
        pthread_rwlock_wrlock(lock: *mut c_void) -> c_int;
        pthread_rwlock_trywrlock(lock: *mut c_void) -> c_int;
        pthread_spin_lock(lock: *mut c_void) -> c_int;
        pthread_once(once: *mut c_void, work: *mut c_void) -> c_int;
        sem_wait(semaphore: *mut c_void) -> c_int;
        sem_trywait(semaphore: *mut c_void) -> c_int;
        sem_post(semaphore: *mut c_void) -> c_int;
        syscall(number: c_long, a: c_long, b: c_long, c: c_long, d: c_long, e: c_long, f: c_long) -> c_long;
    }
}

/// A hundred plans and many events, as a device asks for them.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn what_the_audio_thread_runs_calls_no_lock() {
    use calls::counted;
    use common::scenes::busy;
    use common::storm::{due, event};
    use pacinian::engine::event::Source;
    use pacinian::engine::exchange::exchange;

    let first = common::compiled(&busy(24, 8), 16, 48_000.0).plan;
    let second = common::compiled(&busy(24, 8).replace("time = 0.01", "time = 0.02"), 16, 48_000.0).plan;
    let (mut director, mut stagehand) = exchange(&first).unwrap();
    let mut frames = vec![0.0; 480 * 16];
    let (mut total, mut sent) = (0, 0_u32);
    for round in 0..1_000_u32 {
        if round % 10 == 0 && director.send(if sent.is_multiple_of(2) { &second } else { &first }).unwrap() {
            sent += 1;
        }
        total += counted(|| {
            for i in 20 * round..20 * round + 20 {
                let at = due(stagehand.engine().clock(), i);
                stagehand.engine().schedule(at, Source::Program, event(i));
            }
            stagehand.process(&[], &mut frames);
        });
    }
    assert_eq!(total, 0, "calls in {sent} plans");
    assert!(sent > 20 && stagehand.engine().counters().started > 10_000);
}

/// The counter sees a lock of the C library's, and one of Rust's own that another has.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn locks_are_counted() {
    use std::sync::Mutex;
    use std::time::Duration;

    let mut lock = libc::PTHREAD_MUTEX_INITIALIZER;
    let mutex = std::ptr::from_mut(&mut lock).cast();
    // SAFETY: a mutex as it is at first, on this stack alone; it is unlocked by the same thread.
    let seen = calls::counted(|| unsafe {
        assert_eq!(calls::pthread_mutex_lock(mutex), 0);
        libc::pthread_mutex_unlock(mutex.cast());
    });
    assert_eq!(seen, 1);
    let taken = Mutex::new(());
    let (held, holds) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let guard = taken.lock();
            held.send(()).unwrap();
            std::thread::sleep(Duration::from_millis(200));
            drop(guard);
        });
        holds.recv().unwrap();
        assert!(calls::counted(|| drop(taken.lock())) > 0, "it had to wait");
    });
    assert_eq!(calls::counted(|| ()), 0);
}
