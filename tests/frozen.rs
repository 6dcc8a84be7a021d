//! The audio thread waits for nobody: it goes on while every other thread of a session stands still, wherever that stands.
//!
//! Whoever stands still in the middle of something keeps what it has locked, be that a lock of Rust's own, one of the allocator or one of a
//! library. So all of them are stopped, again and again, in the midst of a storm of events, messages and reloads, and the audio thread must
//! play on for some blocks before they go on.
#![cfg(all(feature = "live", target_os = "linux", target_arch = "x86_64"))]

mod common;

use std::fs;
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::scenes::busy;
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::osc::endpoint::Endpoint;
use pacinian::io::osc::server::Server;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::midi::{Channel, Message};
use pacinian::node::asset::NoAssets;
use pacinian::{Note, Patch, Rig};
use ringbuf::traits::Consumer;

const CHANNELS: u32 = 16;
/// How often all others are stopped, and for how many blocks of 64 frames.
const TIMES: u32 = 300;
const BLOCKS: u64 = 4;
/// So long one may wait for the other, microseconds: longer than any machine stalls.
const PATIENCE: u32 = 10_000_000;

/// Whether others are to stand still, how many do, and whether one of them has given up waiting.
static STAND: AtomicBool = AtomicBool::new(false);
static STANDING: AtomicU32 = AtomicU32::new(0);
static GIVEN_UP: AtomicBool = AtomicBool::new(false);

/// In a signal's handler, so that nothing but atomics and a system call is used.
extern "C" fn stand(_: libc::c_int) {
    STANDING.fetch_add(1, Ordering::AcqRel);
    let mut waited = 0;
    while STAND.load(Ordering::Acquire) {
        // SAFETY: it takes a number, and may be called from a signal's handler.
        unsafe { libc::usleep(200) };
        waited += 200;
        if waited > PATIENCE {
            GIVEN_UP.store(true, Ordering::Release);
            STAND.store(false, Ordering::Release);
        }
    }
    STANDING.fetch_sub(1, Ordering::AcqRel);
}

/// The threads of this process that are to be stopped: all but this one, those of the test's harness, and the one that plays.
fn others() -> Vec<libc::pid_t> {
    // SAFETY: it takes nothing and gives a number.
    let me = unsafe { libc::gettid() };
    let all = fs::read_dir("/proc/self/task").unwrap().flatten();
    let numbered = all.filter_map(|entry| {
        let number: libc::pid_t = entry.file_name().to_str()?.parse().ok()?;
        let name = fs::read_to_string(entry.path().join("comm")).ok()?;
        let spared =
            number == me || name.trim() == "virtual card" || number == std::process::id() as libc::pid_t;
        (!spared).then_some(number)
    });
    numbered.collect()
}

/// Waits without taking memory, which somebody who stands still may have locked.
fn until(done: impl Fn() -> bool) -> bool {
    let begin = Instant::now();
    while !done() {
        if begin.elapsed() > Duration::from_micros(u64::from(PATIENCE)) {
            return false;
        }
        std::thread::sleep(Duration::from_micros(100));
    }
    true
}

fn reload(text: &str) -> Reload {
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(patch, Rig::default_for(CHANNELS), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

#[test]
fn the_audio_thread_goes_on_while_all_others_stand_still() {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{}", busy(8, 8));
    let told = Arc::<Mutex<u64>>::default();
    let [audience, listener] = [(); 2].map(|()| Arc::clone(&told));
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        audience: Box::new(move |_| *audience.lock().unwrap() += 1),
        listener: Some(Box::new(move |_| *listener.lock().unwrap() += 1)),
        ..Beginning::of(reload(&text), Chosen::Virtual(None))
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let mut recording = session.recording().unwrap();
    let server = Server::start(
        "127.0.0.1:0".parse::<Endpoint>().unwrap(),
        session.handle().clone(),
        &reload(&text).patch,
        None,
    );
    let server = server.unwrap_or_else(|error| panic!("{error:?}"));
    let (over, done) = (AtomicBool::new(false), AtomicU64::new(0));
    let (handle, board, at) = (session.handle().clone(), Arc::clone(session.board()), server.address());

    std::thread::scope(|scope| {
        let (over, done) = (&over, &done);
        // Each works for a while and rests for a while, so that the audio thread has its share of a small machine.
        let work = |what: &mut dyn FnMut(u64)| {
            let mut n = 0;
            while !over.load(Ordering::Acquire) {
                what(n);
                n += 1;
                if n % 16 == 0 {
                    std::thread::sleep(Duration::from_micros(500));
                }
            }
            done.fetch_add(n, Ordering::Relaxed);
        };
        let (player, keys, sender) = (handle.clone(), handle.clone(), handle.clone());
        let (text, board) = (&text, &board);
        scope.spawn(move || {
            work(&mut |_| {
                if let Ok(number) = player.play("beat", Note::default()) {
                    let _ = player.release(number);
                }
            })
        });
        scope.spawn(move || {
            work(&mut |n| {
                let (channel, note, velocity) = (Channel::FIRST, (n / 2 % 128) as u8, 100 * (n % 2) as u8);
                let _ = keys.send(Signal::Midi(0, Message::NoteOn { channel, note, velocity }));
            })
        });
        scope.spawn(move || {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            work(&mut |_| drop(socket.send_to(b"/controls\0\0\0,\0\0\0", at)));
        });
        scope.spawn(move || {
            work(&mut |n| {
                let other = text.replace("title = \"t\"", &format!("title = \"{n}\""));
                let _ = sender.send(Signal::Reload(Box::new(reload(&other))));
                std::thread::sleep(Duration::from_millis(5));
            })
        });
        scope.spawn(move || {
            work(&mut |_| {
                recording.clear();
                std::hint::black_box((board.frames.get(), board.voices.get(), board.load.quantile(0.5)));
            })
        });

        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        action.sa_sigaction = stand as *const () as usize;
        action.sa_flags = libc::SA_RESTART;
        // SAFETY: the handler does only what one may do; nothing else here uses this signal.
        assert_eq!(unsafe { libc::sigaction(libc::SIGUSR1, &action, std::ptr::null_mut()) }, 0);
        assert!(until(|| session.board().frames.get() > 48_000));
        let threads = others();
        assert!(threads.len() >= 8, "{threads:?}");
        let me = std::process::id() as libc::pid_t;
        let mut result = Ok(());
        for n in 0..TIMES {
            STAND.store(true, Ordering::Release);
            // SAFETY: it sends a signal that has a handler to threads of this process, which do not end before this does.
            let sent = threads.iter().filter(|number| unsafe {
                libc::syscall(libc::SYS_tgkill, me, **number, libc::SIGUSR1) == 0
            });
            let sent = sent.count() as u32;
            let stood =
                until(|| STANDING.load(Ordering::Acquire) >= sent || GIVEN_UP.load(Ordering::Acquire));
            let from = session.board().frames.get();
            let went_on = until(|| {
                session.board().frames.get() >= from + 64 * BLOCKS || GIVEN_UP.load(Ordering::Acquire)
            });
            let given_up = GIVEN_UP.load(Ordering::Acquire);
            STAND.store(false, Ordering::Release);
            until(|| STANDING.load(Ordering::Acquire) == 0);
            if !stood || !went_on || given_up {
                result = Err(format!(
                    "the {n}th time: all others stood: {stood}; it went on: {}",
                    went_on && !given_up
                ));
                break;
            }
            // At any point of what they do.
            std::thread::sleep(Duration::from_micros(200 + 137 * u64::from(n % 23)));
        }
        over.store(true, Ordering::Release);
        assert_eq!(result, Ok(()));
    });
    assert!(*told.lock().unwrap() > 1_000 && done.load(Ordering::Relaxed) > 10_000, "nothing was going on");
    assert!(session.board().started.get() > 1_000);
    session.stop();
}
