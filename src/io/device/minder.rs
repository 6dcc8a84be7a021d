//! A thread that looks after a device until somebody lets go of it, and what it needs for that.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cpal::ErrorKind;

use super::callers::Callers;
use super::card::News;
use super::failure::DeviceError;
use crate::io::parting::part_with;

/// How often it looks.
pub(super) const WATCH: Duration = Duration::from_millis(20);

/// How often a device is looked for while it is away: soon at first, later not so often.
pub(super) const SEARCH: Duration = Duration::from_millis(100);
const SEARCH_LATER: Duration = Duration::from_secs(1);
const SOON: Duration = Duration::from_secs(5);

/// Looks after a device until it is dropped.
pub(super) struct Minder {
    quit: Arc<AtomicBool>,
    bell: Bell,
    thread: Option<JoinHandle<()>>,
    parts_after: Duration,
}

/// By which a minder is called, to look at once.
#[derive(Clone)]
pub(super) struct Bell(Sender<()>);

/// Where the minder of such a bell hears it.
pub(super) struct Ear(Receiver<()>);

/// A bell for a minder that is to be.
pub(super) fn bell() -> (Bell, Ear) {
    let (rings, heard) = channel();
    (Bell(rings), Ear(heard))
}

impl Bell {
    fn ring(&self) {
        // Nobody is there any more who would look.
        let _ = self.0.send(());
    }

    /// Somebody to whom to tell news, who rings then, and where they are heard.
    pub fn news(&self) -> (impl Fn(News) + Send + 'static, Receiver<News>) {
        let ((tell, news), bell) = (channel(), self.clone());
        let tell = move |what| {
            // Whoever has let go of the stream does not hear of it any more.
            let _ = tell.send(what);
            bell.ring();
        };
        (tell, news)
    }
}

impl Minder {
    /// Calls `look` every now and then, and whenever the bell rings, in a thread of that name.
    ///
    /// # Errors
    /// No thread.
    pub fn start(
        name: &str,
        (bell, ear): (Bell, Ear),
        look: impl FnMut() + Send + 'static,
    ) -> Result<Self, DeviceError> {
        Self::start_every(name, WATCH, (bell, ear), look)
    }

    fn start_every(
        name: &str,
        every: Duration,
        (bell, Ear(ear)): (Bell, Ear),
        mut look: impl FnMut() + Send + 'static,
    ) -> Result<Self, DeviceError> {
        let quit = Arc::new(AtomicBool::new(false));
        let quits = Arc::clone(&quit);
        let work = move || {
            while ear.recv_timeout(every) != Err(RecvTimeoutError::Disconnected)
                && !quits.load(Ordering::Acquire)
            {
                // However often it rang.
                while ear.try_recv().is_ok() {}
                look();
            }
        };
        let thread = std::thread::Builder::new()
            .name(name.into())
            .spawn(work)
            .map_err(|error| DeviceError::no_thread(name, &error))?;
        Ok(Self { quit, bell, thread: Some(thread), parts_after: PARTS_AFTER })
    }
}

impl Drop for Minder {
    fn drop(&mut self) {
        self.quit.store(true, Ordering::Release);
        self.bell.ring();
        self.thread.take().into_iter().for_each(|thread| _ = part_with(thread, self.parts_after));
    }
}

/// So long a minder may take to end: what it does is done within [`RELEASE`], but for the opening of a device whose system stands still.
const PARTS_AFTER: Duration = Duration::from_secs(2 * RELEASE.as_secs());

/// So long after it was opened, a device's callbacks may take to begin and to become regular: a sink of PulseAudio that was idle asks
/// for a block or two, and then plays two seconds of its own silence first.
pub(super) const PATIENCE: Duration = Duration::from_secs(3);

/// Looks at which there were more frames, after which a device's callbacks are regular.
const REGULAR: u32 = 10;

/// From one look to the next, no more counts for a pause: who looks so late stood still with the whole machine, and so did the device.
const STALL: Duration = Duration::from_millis(60);

/// So much faster than it plays a device may ask for frames, over so long: no buffer is that large.
pub(super) const RUSH: f64 = 10.0;
pub(super) const RUSH_FOR: Duration = Duration::from_millis(500);

/// Whether a device takes what it is given as fast as it comes, so that nothing keeps time on it.
pub(super) struct Pace {
    since: Instant,
    frames: u64,
}

impl Pace {
    /// From so many frames on.
    pub fn begin(now: Instant, frames: u64) -> Self {
        Self { since: now, frames }
    }

    /// How much faster than it plays it has asked for frames at `rate`, so many by now; `None` while nobody can tell yet.
    pub fn speed(&mut self, now: Instant, frames: u64, rate: f64) -> Option<f64> {
        let time = now.saturating_duration_since(self.since);
        if time < RUSH_FOR {
            return None;
        }
        let begun = std::mem::replace(self, Self::begin(now, frames));
        Some(frames.saturating_sub(begun.frames) as f64 / (rate * time.as_secs_f64()))
    }
}

/// Whether a device still calls back.
pub(super) struct Pulse {
    /// Frames that were counted last, and for how long there have been no more.
    frames: u64,
    pause: Duration,
    /// When it was looked at last, and until when it may take its time.
    looked: Instant,
    patient: Instant,
    /// How often there were more, since it was opened.
    looks: u32,
}

impl Pulse {
    /// Of a device that was just opened.
    pub fn new() -> Self {
        let now = Instant::now();
        Self { frames: 0, pause: Duration::ZERO, looked: now, patient: now + PATIENCE, looks: 0 }
    }

    /// It was opened again.
    pub fn begin(&mut self) {
        let now = Instant::now();
        (self.pause, self.looked, self.patient, self.looks) = (Duration::ZERO, now, now + PATIENCE, 0);
    }

    /// For how long there have been no more than so many frames, as far as somebody has looked.
    pub fn pause(&mut self, now: Instant, frames: u64) -> Duration {
        let since = if self.looks < REGULAR { self.looked.max(self.patient) } else { self.looked };
        self.pause += now.saturating_duration_since(since).min(STALL);
        self.looked = now;
        if frames != self.frames {
            self.looks = self.looks.saturating_add(1);
            (self.frames, self.pause) = (frames, Duration::ZERO);
        }
        self.pause
    }
}

/// When a device is looked for that is away.
pub(super) struct Search {
    /// When it was there last, and when it was looked for.
    there: Instant,
    last: Instant,
}

impl Search {
    /// For one that is there.
    pub fn new() -> Self {
        Self { there: Instant::now(), last: Instant::now() }
    }

    /// Whether it is to be looked for now.
    pub fn is_due(&mut self, now: Instant, present: bool) -> bool {
        if present {
            self.there = now;
            return false;
        }
        let away = now.saturating_duration_since(self.there);
        let pause = if away < SOON { SEARCH } else { SEARCH_LATER };
        let due = now.saturating_duration_since(self.last) >= pause;
        if due {
            self.last = now;
        }
        due
    }
}

/// What a stream is given to tell of its errors: `gap` counts those after which it has gone on by itself, `lost` hears at once of those
/// after which it is of no use, such as that it plays on another device now. `callers` know of the thread that tells them.
pub(super) fn teller(
    news: impl Fn(News) + Send + 'static,
    gap: impl Fn() + Send + 'static,
    lost: impl Fn() + Send + 'static,
    callers: Callers,
) -> impl FnMut(cpal::Error) + Send + 'static {
    let lost = move || {
        callers.lose();
        lost();
    };
    move |error| match error.kind() {
        ErrorKind::Xrun => gap(),
        ErrorKind::DeviceChanged => {
            lost();
            news(News::Moved);
        }
        ErrorKind::RealtimeDenied => news(News::Said(error.to_string())),
        // ALSA's plug-ins say so of an underrun.
        ErrorKind::BackendError => {
            lost();
            news(News::Broke(error.to_string()));
        }
        _ => {
            lost();
            news(News::Lost(error.to_string()));
        }
    }
}

/// So long a device may take to let go of a stream.
pub(super) const RELEASE: Duration = Duration::from_secs(5);

/// Lets go of a stream. A device that takes longer than [`RELEASE`] for it does so by itself.
pub(super) fn let_go(stream: impl Send + 'static) {
    // Where there is no thread for it, it is gone already.
    let _ = within("release", RELEASE, move || drop(stream));
}

/// What somebody does who may never be done, in a thread of that name; `None` where it takes longer than that, and goes on by itself.
pub(super) fn within<T: Send + 'static>(
    name: &str,
    time: Duration,
    work: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    let (done, waits) = channel();
    let work = move || {
        // Who has waited long enough does not any more.
        let _ = done.send(work());
    };
    std::thread::Builder::new().name(name.into()).spawn(work).ok()?;
    waits.recv_timeout(time).ok()
}

#[cfg(test)]
mod tests {
    use super::{Minder, PATIENCE, Pace, Pulse, RUSH, SEARCH, SOON, STALL, Search, bell};
    use crate::io::device::card::News;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    /// As one that opens a device of a server that stands still.
    #[test]
    fn one_that_waits_for_ever_is_parted_with() {
        let (goes_on, waits) = channel::<()>();
        let (began, begins) = channel();
        let look = move || {
            began.send(()).unwrap();
            let _ = waits.recv();
        };
        let mut minder = Minder::start("waits", bell(), look).unwrap();
        minder.parts_after = Duration::from_millis(50);
        begins.recv().unwrap();
        drop(minder);
        // It waits still, and goes when it may.
        assert!(goes_on.send(()).is_ok());
        while begins.recv().is_ok() {}
    }

    /// One that would look once an hour.
    #[test]
    fn what_a_device_says_is_heard_at_once_and_so_is_that_it_is_over() {
        let (bell, ear) = bell();
        let (tell, news) = bell.news();
        let (looked, looks) = channel();
        let look = move || looked.send(news.try_iter().count()).unwrap();
        let minder = Minder::start_every("test", Duration::from_secs(3600), (bell, ear), look)
            .unwrap_or_else(|e| panic!("{e}"));
        let mut heard = 0;
        for told in 1..=100 {
            tell(News::Moved);
            while heard < told {
                heard += looks.recv_timeout(Duration::from_secs(60)).unwrap();
            }
        }
        drop(minder);
        tell(News::Moved);
        assert_eq!((heard, looks.try_iter().sum()), (100, 0));
    }

    /// Milliseconds of pause that looks every 20 ms find, after that to that, of so many frames: the last of them.
    fn looks(pulse: &mut Pulse, begin: Instant, ms: (u64, u64), frames: u64) -> u128 {
        let at = |n: u64| begin + Duration::from_millis(20 * n);
        (ms.0 / 20 + 1..=ms.1 / 20).map(|n| pulse.pause(at(n), frames).as_millis()).last().unwrap()
    }

    #[test]
    fn a_pause_begins_with_the_last_frame() {
        let mut pulse = Pulse::new();
        let begin = pulse.looked;
        assert_eq!(looks(&mut pulse, begin, (0, 2_900), 0), 0, "it has just been opened");
        assert_eq!(looks(&mut pulse, begin, (2_900, 3_500), 0), 500);
        assert_eq!(looks(&mut pulse, begin, (3_500, 3_520), 64), 0);
        assert_eq!(looks(&mut pulse, begin, (3_520, 3_820), 64), 300);
    }

    #[test]
    fn a_machine_that_stands_still_is_no_device_that_is_gone() {
        let mut pulse = Pulse::new();
        let begin = pulse.looked;
        assert!((1..=12).all(|n| looks(&mut pulse, begin, (20 * (n - 1), 20 * n), 256 * n) == 0));
        // Nobody looks for ten seconds, and nobody calls back either.
        assert_eq!(looks(&mut pulse, begin, (10_000, 10_020), 256 * 12), STALL.as_millis());
        assert_eq!(looks(&mut pulse, begin, (10_020, 10_040), 256 * 13), 0);
        assert_eq!(looks(&mut pulse, begin, (10_040, 10_400), 256 * 13), 360, "one that is gone is found");
    }

    #[test]
    fn it_is_looked_for_often_at_first_and_then_once_a_second() {
        let (begin, mut search) = (Instant::now(), Search::new());
        let at = |ms: u64| begin + Duration::from_millis(ms);
        assert!((0..100).all(|n| !search.is_due(at(20 * n), true)));
        let due = |from: u64, to: u64, search: &mut Search| {
            (from / 20..to / 20).filter(|n| search.is_due(at(20 * n), false)).count() as u64
        };
        let soon = SOON.as_millis() as u64;
        assert_eq!(due(2_000, 2_000 + soon - 100, &mut search), (soon - 100) / SEARCH.as_millis() as u64);
        assert_eq!(due(2_000 + soon, 12_000 + soon, &mut search), 10);
    }

    #[test]
    fn a_device_that_takes_all_at_once_keeps_no_time() {
        let begin = Instant::now();
        let at = |ms: u64| begin + Duration::from_millis(ms);
        let mut pace = Pace::begin(begin, 0);
        // Two seconds of a server's buffer at once, and then as it plays.
        let buffered = |ms: u64| 96_000 + 48 * ms;
        assert!(
            (1..200).all(|n| pace.speed(at(20 * n), buffered(20 * n), 48e3).is_none_or(|speed| speed < RUSH))
        );
        let mut pace = Pace::begin(begin, 0);
        let rushes = (1..100)
            .find(|n| pace.speed(at(20 * n), 1_000 * 48 * 20 * n, 48e3).is_some_and(|speed| speed > RUSH));
        assert_eq!(rushes, Some(25), "after half a second");
    }

    #[test]
    fn a_device_may_take_its_time_at_first_and_not_later() {
        let mut pulse = Pulse::new();
        let (begin, patience) = (pulse.looked, PATIENCE.as_millis() as u64);
        assert_eq!(looks(&mut pulse, begin, (0, 20), 256), 0);
        assert_eq!(looks(&mut pulse, begin, (20, 40), 512), 0);
        assert_eq!(looks(&mut pulse, begin, (40, patience), 512), 0);
        assert_eq!(looks(&mut pulse, begin, (patience, patience + 400), 512), 400);
        assert_eq!(looks(&mut pulse, begin, (patience + 400, patience + 420), 768), 0);
        assert_eq!(looks(&mut pulse, begin, (patience + 420, patience + 920), 768), 500);
        // One that has been regular for a while is not waited for any longer.
        let mut pulse = Pulse::new();
        let begin = pulse.looked;
        assert!((1..=12).all(|n| looks(&mut pulse, begin, (20 * (n - 1), 20 * n), 256 * n) == 0));
        assert_eq!(looks(&mut pulse, begin, (240, 640), 256 * 12), 400);
    }
}
