//! When something came: the kernel has it on the clock of a queue, which is compared with ours.

use std::os::fd::BorrowedFd;
use std::time::{Duration, Instant};

use alsa::Direction;
use alsa::poll::Descriptors;
use alsa::seq::{EventType, Seq};
use rustix::ioctl::{Opcode, Setter, Updater, ioctl, opcode};

/// A queue that runs, for its clock alone. `None` where the system has no more: what comes then came when it is fetched.
pub(super) fn queue(seq: &Seq) -> Option<i32> {
    let queue = seq.alloc_named_queue(c"pacinian").ok()?;
    let start = || seq.control_queue(queue, EventType::Start, 0, None).and_then(|()| seq.drain_output());
    let started = slowed(seq, queue).is_some() && start().is_ok();
    if !started {
        let _ = seq.free_queue(queue);
    }
    started.then_some(queue)
}

/// What the kernel's `snd_seq_queue_timer` is.
#[repr(C)]
struct Timer {
    queue: i32,
    kind: i32,
    /// Class, class of slaves, card, device and subdevice.
    id: [i32; 5],
    /// Hz.
    frequency: u32,
    reserved: [u8; 64],
}

/// The least at which a queue's timer interrupts, Hz. Between two of them the kernel reads its own clock.
const SLOWEST: u32 = 10;

/// Without being asked the timer would interrupt a thousand times a second. ALSA's library has no way to ask through this handle.
fn slowed(seq: &Seq, queue: i32) -> Option<()> {
    const GET: Opcode = opcode::read_write::<Timer>(b'S', 0x45);
    const SET: Opcode = opcode::write::<Timer>(b'S', 0x46);
    let all = (seq, Some(Direction::Capture)).get().ok()?;
    // SAFETY: it is the sequencer's, which `seq` holds open.
    let fd = unsafe { BorrowedFd::borrow_raw(all.first()?.fd) };
    let mut timer = Timer { queue, kind: 0, id: [0; 5], frequency: 0, reserved: [0; 64] };
    // SAFETY: the numbers and the layout are those of SNDRV_SEQ_IOCTL_GET_QUEUE_TIMER and SNDRV_SEQ_IOCTL_SET_QUEUE_TIMER in <sound/asequencer.h>.
    unsafe { ioctl(fd, Updater::<GET, Timer>::new(&mut timer)) }.ok()?;
    timer.frequency = SLOWEST;
    // SAFETY: the same.
    unsafe { ioctl(fd, Setter::<SET, Timer>::new(timer)) }.ok()
}

/// What it was on both clocks at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Times {
    here: Instant,
    there: Option<Duration>,
}

/// What is said to have come longer ago than this is not believed: the fetching thread was stopped, or the queue was.
const LONGEST: Duration = Duration::from_secs(1);

impl Times {
    /// Now.
    pub fn now(seq: &Seq, queue: Option<i32>) -> Self {
        let before = Instant::now();
        let there = queue.and_then(|queue| seq.get_queue_status(queue).ok());
        let here = before + before.elapsed() / 2;
        Self { here, there: there.map(|status| status.get_real_time()) }
    }

    /// When something came that has the queue's time, or none.
    pub fn of(&self, time: Option<Duration>) -> Instant {
        let (Some(there), Some(time)) = (self.there, time) else { return self.here };
        // What came since it was compared.
        if let Some(later) = time.checked_sub(there) {
            return self.here.checked_add(later).map_or(self.here, |at| at.min(Instant::now()));
        }
        let age = there.saturating_sub(time);
        self.here.checked_sub(age).filter(|_| age <= LONGEST).unwrap_or(self.here)
    }
}

#[cfg(test)]
mod tests {
    use super::{Duration, Instant, Times};

    #[test]
    fn what_came_before_the_comparison_is_as_old_as_the_queue_says() {
        let ms = Duration::from_millis;
        let here = Instant::now();
        let times = Times { here, there: Some(ms(7_000)) };
        assert_eq!(times.of(Some(ms(6_997))), here - ms(3));
        assert_eq!(times.of(None), here, "it has no time");
        assert_eq!(Times { here, there: None }.of(Some(ms(1))), here, "there is no queue");
        assert_eq!(times.of(Some(ms(5_000))), here, "nobody waits for so long");
        // What comes meanwhile is not from the future.
        std::thread::sleep(ms(2));
        assert_eq!(times.of(Some(ms(7_001))), here + ms(1));
        assert!(times.of(Some(ms(90_000))) <= Instant::now());
    }
}
