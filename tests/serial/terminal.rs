//! A device of the tests behind a pseudo-terminal.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::cable::Device;

/// A pseudo-terminal with a device at its far end, which runs on its own thread.
pub struct Terminal<D> {
    /// A name that can lead to another terminal later, as that of a device that is plugged in again.
    pub path: PathBuf,
    device: Arc<Mutex<D>>,
    plugged: Option<Plugged>,
    began: Instant,
}

struct Plugged {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl<D: Device + Send + 'static> Terminal<D> {
    /// Plugs a device in.
    pub fn new(device: D) -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("pacinian-line-{}-{number}", std::process::id()));
        let mut terminal =
            Self { path, device: Arc::new(Mutex::new(device)), plugged: None, began: Instant::now() };
        terminal.plug();
        terminal
    }

    /// The device.
    pub fn device(&self) -> MutexGuard<'_, D> {
        self.device.lock().unwrap()
    }

    pub fn name(&self) -> &str {
        self.path.to_str().unwrap()
    }

    /// Seconds of the device's clock.
    pub fn now(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Plugs it in.
    pub fn plug(&mut self) {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        // Held, or the master hangs up as soon as the other side closes for a moment.
        let slave = OpenOptions::new().read(true).write(true).open(&name).unwrap();
        let mut mode = tcgetattr(&slave).unwrap();
        mode.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &mode).unwrap();
        rustix::io::ioctl_fionbio(&master, true).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, device, began) = (Arc::clone(&stop), Arc::clone(&self.device), self.began);
        let mut master = File::from(master);
        let thread = std::thread::spawn(move || {
            let _held = slave;
            let mut bytes = [0; 4096];
            while !stopped.load(Ordering::Acquire) {
                let count = master.read(&mut bytes).unwrap_or(0);
                let said = {
                    let mut device = device.lock().unwrap();
                    let now = began.elapsed().as_secs_f64();
                    device.hear(&bytes[..count], now);
                    device.pass(now)
                };
                // What finds no room is lost, as on a wire.
                let _ = master.write(&said);
                if count == 0 {
                    std::thread::sleep(Duration::from_micros(100));
                }
            }
        });
        symlink(&name, &self.path).unwrap();
        self.plugged = Some(Plugged { stop, thread });
    }

    /// Pulls it out.
    pub fn pull(&mut self) {
        if let Some(plugged) = self.plugged.take() {
            // Its name first: the system gives the number of a terminal that is gone to the next one.
            std::fs::remove_file(&self.path).unwrap();
            plugged.stop.store(true, Ordering::Release);
            plugged.thread.join().unwrap();
        }
    }
}

impl<D> Drop for Terminal<D> {
    fn drop(&mut self) {
        if let Some(plugged) = self.plugged.take() {
            plugged.stop.store(true, Ordering::Release);
            let _ = plugged.thread.join();
        }
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Waits until something holds, for as long as a machine under load may take.
pub fn wait(what: &str, mut holds: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_secs(60);
    while !holds() {
        assert!(Instant::now() < until, "waited in vain for: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
