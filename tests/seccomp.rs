//! The audio thread makes no system call: it runs under a filter by which the first one ends the process.
//!
//! The filter allows nothing at all, or what a device calls the one clock that has to be asked for, so it is set in a child: this very program, told by its environment what to do. The audio
//! thread cannot even end; it says that it is done through memory and waits.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

mod common;
#[path = "common/skipped.rs"]
mod skipped;

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use common::compiled;
use common::scenes::busy;
use common::storm::{self, due};
use pacinian::engine::event::Source;
use pacinian::engine::exchange::{Stagehand, exchange};
use pacinian::graph::plan::Plan;

/// What a child is to do.
const TASK: &str = "PACINIAN_SECCOMP";
/// How a child ends that has done it, and one that could not be filtered; libtest uses neither.
const DONE: i32 = 42;
const NO_FILTER: i32 = 43;

const CHANNELS: usize = 16;
const FRAMES: usize = 480;
const EVENTS: u32 = 50_000;
const PLANS: u32 = 100;

/// From now on, any system call of this thread ends the process, but for one. Says whether the system can do that.
fn forbid_all_but(one: Option<libc::c_long>) -> bool {
    let word = |code: u32, jf: u8, k: u32| libc::sock_filter { code: code as u16, jt: 0, jf, k };
    let mut all = [
        // The number of the call; none has the last of all numbers.
        word(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS, 0, 0),
        word(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 1, one.map_or(u32::MAX, |call| call as u32)),
        word(libc::BPF_RET | libc::BPF_K, 0, libc::SECCOMP_RET_ALLOW),
        word(libc::BPF_RET | libc::BPF_K, 0, libc::SECCOMP_RET_KILL_PROCESS),
    ];
    let program = libc::sock_fprog { len: all.len() as u16, filter: all.as_mut_ptr() };
    // SAFETY: both calls read their arguments and nothing else; the program outlives them.
    unsafe {
        libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0
            && libc::prctl(libc::PR_SET_SECCOMP, libc::SECCOMP_MODE_FILTER, &program) == 0
    }
}

/// The same of every one.
fn forbid() -> bool {
    forbid_all_but(None)
}

#[derive(Default)]
struct Progress {
    /// 1: under the filter; 2: it cannot be had; 3: done.
    state: AtomicU32,
    /// Plans that were sent.
    plans: AtomicU32,
    /// Voices that were started.
    voices: AtomicU64,
}

/// The audio thread: callbacks with events and input under the filter, until all is done. It never returns.
fn perform(mut stagehand: Stagehand, task: &str, progress: &Progress) -> ! {
    let (input, mut output) = (vec![0.1_f32; FRAMES], vec![0.0_f32; FRAMES * CHANNELS]);
    let allowed = forbid();
    progress.state.store(if allowed { 1 } else { 2 }, Ordering::Release);
    let mut event = 0_u32;
    while allowed && (event < EVENTS || progress.plans.load(Ordering::Acquire) < PLANS) {
        for _ in 0..100 {
            let at = due(stagehand.engine().clock(), event);
            stagehand.engine().schedule(at, Source::Program, storm::event(event));
            event = event.wrapping_add(1);
        }
        stagehand.process(&input, &mut output);
        if event == 10_000 {
            match task {
                // SAFETY: it takes nothing and gives a number.
                "call" => _ = unsafe { libc::syscall(libc::SYS_getpid) },
                // More than any allocator has at hand.
                "allocate" => drop(std::hint::black_box(vec![1_u8; 256 << 20])),
                _ => {}
            }
        }
    }
    progress.voices.store(stagehand.engine().counters().started, Ordering::Release);
    if allowed {
        progress.state.store(3, Ordering::Release);
    }
    loop {
        std::hint::spin_loop();
    }
}

/// Callbacks of a session under the filter, with events, orders and plans that another thread sends, until that says it is enough.
#[cfg(feature = "live")]
fn call_back(mut callback: pacinian::live::callback::Callback, progress: &Progress) -> ! {
    let (input, mut output) = (vec![0.1_f32; FRAMES], vec![0.0_f32; FRAMES * CHANNELS]);
    let allowed = forbid();
    progress.state.store(if allowed { 1 } else { 2 }, Ordering::Release);
    while allowed && progress.plans.load(Ordering::Acquire) < PLANS {
        callback.process(&input, &mut output);
        if progress.plans.load(Ordering::Acquire) == PLANS / 2 {
            callback.relieve(pacinian::live::relief::Relieved::More);
        }
    }
    if allowed {
        progress.state.store(3, Ordering::Release);
    }
    loop {
        std::hint::spin_loop();
    }
}

/// The same by what a device calls, which asks for the processor time of its thread.
#[cfg(feature = "live")]
fn fill(mut driver: pacinian::live::driver::Driver, progress: &Progress, task: &str) -> ! {
    let mut output = vec![0.0_f32; FRAMES * CHANNELS];
    let allowed = forbid_all_but(Some(libc::SYS_clock_gettime).filter(|_| task == "fill"));
    progress.state.store(if allowed { 1 } else { 2 }, Ordering::Release);
    while allowed && progress.plans.load(Ordering::Acquire) < PLANS {
        driver.fill(&mut output);
    }
    if allowed {
        progress.state.store(3, Ordering::Release);
    }
    loop {
        std::hint::spin_loop();
    }
}

/// The child's other thread, for a callback, or what a device calls.
#[cfg(feature = "live")]
fn send_to_callback(plans: &[Plan; 2], task: String) -> ! {
    use common::storm::pull;
    use pacinian::live::board::Board;
    use pacinian::live::callback::{Callback, Cue};
    use pacinian::live::driver::Driver;
    use pacinian::live::gate::Gate;
    use pacinian::live::stamp::Epoch;
    use ringbuf::HeapRb;
    use ringbuf::traits::{Consumer, Producer, Split};
    use std::sync::Arc;

    let (mut director, stagehand) = exchange(&plans[0]).unwrap();
    let board = Arc::new(Board::new(CHANNELS));
    let (mut callback, mut rings) = Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::clone(&board));
    let (record, mut recorded) = HeapRb::new(FRAMES * CHANNELS * 64).split();
    callback.record(record);
    let progress: &'static Progress = Box::leak(Box::default());
    let calls = Arc::clone(&board);
    std::thread::spawn(move || match task.as_str() {
        "callback" => call_back(callback, progress),
        _ => fill(Driver::new(callback, 48_000.0, FRAMES, Epoch::begin(), calls).0, progress, &task),
    });
    let (mut sent, mut event, mut heard) = (0_u32, 0_u32, 0_u64);
    loop {
        match progress.state.load(Ordering::Acquire) {
            2 => std::process::exit(NO_FILTER),
            3 => break,
            _ => {}
        }
        let clock = board.clock.get();
        for _ in 0..200 {
            let cue =
                Cue { plan: u64::from(sent), at: due(clock, event), event: storm::event(event), cause: 0 };
            let taken = rings.cues[(event % 2) as usize].try_push(cue);
            event += u32::from(taken.is_ok());
        }
        pull(&board, event);
        recorded.clear();
        while let Some(report) = rings.reports.try_pop() {
            heard += 1;
            std::hint::black_box(report);
        }
        if event % 64 < 8 {
            board.panic();
            board.calm();
        }
        if event > 1_000 * sent && director.send(&plans[(sent as usize + 1) % 2]).unwrap() {
            sent += 1;
            progress.plans.store(sent.saturating_sub(2), Ordering::Release);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let well = heard > u64::from(event) / 2 && board.started.get() > u64::from(event) / 4;
    std::process::exit(if well { DONE } else { 1 });
}

/// A thread that hears what a card on another clock brings, under the filter.
#[cfg(feature = "live")]
fn listen() -> ! {
    use pacinian::live::board::Board;
    use pacinian::live::intake::{Ears, bridge};
    use pacinian::live::stamp::Epoch;
    use std::sync::Arc;

    let board = Arc::new(Board::new(1));
    let ears = Ears { rate: 44_100.0, channels: 2, block: 128 };
    let (mut intake, mut feed) = bridge(ears, 48_000.0, 64, Epoch::begin(), &board);
    let progress: &'static Progress = Box::leak(Box::default());
    let hears = Arc::clone(&board);
    std::thread::spawn(move || {
        let allowed = forbid();
        let heard = if allowed { storm::listen(&mut intake, &mut feed, &hears) } else { 0.0 };
        progress.voices.store(u64::from(heard > 0.24), Ordering::Release);
        progress.state.store(if allowed { 3 } else { 2 }, Ordering::Release);
        loop {
            std::hint::spin_loop();
        }
    });
    loop {
        match progress.state.load(Ordering::Acquire) {
            2 => std::process::exit(NO_FILTER),
            3 => break,
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    let well = progress.voices.load(Ordering::Acquire) == 1 && board.input.dry.get() > 0;
    std::process::exit(if well { DONE } else { 1 });
}

/// Not a test of its own: what the child does.
#[test]
fn child() {
    let Ok(task) = std::env::var(TASK) else { return };
    #[cfg(feature = "live")]
    if task == "listen" {
        listen();
    }
    let plan = |time: &str| -> Plan {
        compiled(&busy(24, 8).replace("0.01,", time), CHANNELS as u32, 48_000.0).plan
    };
    let plans = [plan("0.01,"), plan("0.02,")];
    #[cfg(feature = "live")]
    if ["callback", "fill", "fill without a clock"].contains(&task.as_str()) {
        send_to_callback(&plans, task);
    }
    let (mut director, stagehand) = exchange(&plans[0]).unwrap();
    // The audio thread goes on when this function ends.
    let progress: &'static Progress = Box::leak(Box::default());
    std::thread::spawn(move || perform(stagehand, &task, progress));
    let mut sent = 0_u32;
    loop {
        match progress.state.load(Ordering::Acquire) {
            2 => std::process::exit(NO_FILTER),
            3 => break,
            _ => {}
        }
        if director.send(&plans[(sent as usize + 1) % 2]).unwrap() {
            sent += 1;
            // The next one is sent when this one has been taken, or it would not be.
            progress.plans.store(sent.saturating_sub(2), Ordering::Release);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let started = progress.voices.load(Ordering::Acquire);
    let well = sent >= PLANS && started > u64::from(EVENTS) / 2;
    std::process::exit(if well { DONE } else { 1 });
}

fn run(task: &str) -> Option<ExitStatus> {
    let program = std::env::current_exe().unwrap();
    let mut command = Command::new(program);
    command.args(["--exact", "child", "--nocapture", "--test-threads", "1"]).env(TASK, task);
    let status = command.output().unwrap().status;
    if status.code() == Some(NO_FILTER) {
        skipped::skipped("this system has no seccomp filters, so nothing is proved here");
        return None;
    }
    Some(status)
}

#[test]
fn events_and_plans_without_a_system_call() {
    let Some(status) = run("perform") else { return };
    assert_eq!(status.code(), Some(DONE), "{status}");
}

#[cfg(feature = "live")]
#[test]
fn a_session_s_callback_without_a_system_call() {
    let Some(status) = run("callback") else { return };
    assert_eq!(status.code(), Some(DONE), "{status}");
}

/// But that of the thread's own clock.
#[cfg(feature = "live")]
#[test]
fn a_device_is_filled_without_another_system_call() {
    let Some(status) = run("fill") else { return };
    assert_eq!(status.code(), Some(DONE), "{status}");
    let Some(status) = run("fill without a clock") else { return };
    assert_eq!(status.signal(), Some(libc::SIGSYS), "{status}");
}

#[cfg(feature = "live")]
#[test]
fn what_a_card_brings_is_heard_without_a_system_call() {
    let Some(status) = run("listen") else { return };
    assert_eq!(status.code(), Some(DONE), "{status}");
}

#[test]
fn the_filter_bites() {
    for task in ["call", "allocate"] {
        let Some(status) = run(task) else { return };
        assert_eq!(status.signal(), Some(libc::SIGSYS), "{task}: {status}");
    }
}
