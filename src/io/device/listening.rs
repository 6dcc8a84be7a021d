//! Keeps a session listening to its input device: notices when that is gone, and comes back when it does. Never to another one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cpal::Device;

use super::capture::Capture;
use super::card::{News, Shape};
use super::choose::heard_again;
use super::failure::{DeviceError, Trouble};
use super::keeper::Fate;
use super::list::Found;
use crate::live::board::Board;
use crate::live::intake::Intake;

/// So long without a callback: then the device is taken for lost; and so long it may take for the first.
const SILENT: Duration = Duration::from_millis(500);
const PATIENCE: Duration = Duration::from_secs(3);

/// How often it is looked after, and how often it is looked for while it is away.
const WATCH: Duration = Duration::from_millis(20);
const SEARCH: Duration = Duration::from_millis(100);

/// So long a device may take to let go of a stream.
const RELEASE: Duration = Duration::from_secs(5);

/// Listens until it is dropped.
pub struct Listening {
    quit: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Keeping {
    id: String,
    shape: Shape,
    board: Arc<Board>,
    /// While the device is there.
    capture: Option<Capture>,
    /// While it is not.
    intake: Option<Box<Intake>>,
    home: Receiver<Box<Intake>>,
    lend: Sender<Box<Intake>>,
    news: Receiver<News>,
    tell: Sender<News>,
    fate: Box<dyn FnMut(Fate) + Send>,
}

impl Listening {
    /// Lets `intake` take what a device hears that is asked for `shape`, and hears of it through `fate`.
    ///
    /// # Errors
    /// A device that cannot be opened.
    pub fn start(
        intake: Intake,
        (device, found): (Device, Found),
        shape: Shape,
        board: &Arc<Board>,
        fate: Box<dyn FnMut(Fate) + Send>,
    ) -> Result<Self, DeviceError> {
        let (lend, home) = channel();
        let (tell, news) = channel();
        let (capture, intake, id) = (None, Some(Box::new(intake)), found.id.clone());
        let board = Arc::clone(board);
        let mut keeping = Keeping { id, shape, board, capture, intake, home, lend, news, tell, fate };
        keeping.open(&device, &found)?;
        let (quit, asked) = channel();
        let thread = std::thread::Builder::new()
            .name("input".into())
            .spawn(move || keeping.keep(&asked))
            .map_err(|error| DeviceError::new(Trouble::Other, format!("no thread for the input: {error}")))?;
        Ok(Self { quit: Some(quit), thread: Some(thread) })
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        drop(self.quit.take());
        if let Some(thread) = self.thread.take() {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

impl Keeping {
    fn open(&mut self, device: &Device, found: &Found) -> Result<(), DeviceError> {
        let Some(mut intake) = self.intake.take() else {
            return Err(DeviceError::new(
                Trouble::Other,
                format!("{} has not let go of the input", found.name),
            ));
        };
        intake.forget(self.shape.block.unwrap_or(0) as usize);
        let lent = intake.lend(self.lend.clone());
        match Capture::open(device, found, self.shape, lent, &self.board, self.tell.clone()) {
            Ok(capture) => self.capture = Some(capture),
            Err(error) => {
                self.intake = self.home.recv_timeout(RELEASE).ok();
                return Err(error);
            }
        }
        Ok(())
    }

    fn keep(mut self, asked: &Receiver<()>) {
        let (mut seen, mut since, mut searched) = (0, Instant::now() + PATIENCE, Instant::now());
        while asked.recv_timeout(WATCH) == Err(RecvTimeoutError::Timeout) {
            let now = Instant::now();
            let frames = self.board.input.frames.get();
            if frames != seen {
                (seen, since) = (frames, now);
            }
            while let Ok(news) = self.news.try_recv() {
                match news {
                    // Its own stream may say so too when it is closed.
                    News::Lost(why) if self.capture.is_some() => self.lose(why),
                    News::Lost(_) => {}
                    News::Moved => (self.fate)(Fate::Moved),
                    News::Said(what) => (self.fate)(Fate::Said(what)),
                }
            }
            if self.capture.is_some() && now.saturating_duration_since(since) > SILENT {
                self.lose("it brings nothing any more".into());
            }
            if self.capture.is_none() && now.duration_since(searched) >= SEARCH {
                searched = now;
                let there = heard_again(&self.id).and_then(|(device, found)| self.open(&device, &found));
                if there.is_ok() {
                    since = Instant::now() + PATIENCE;
                    // What the old stream said on its way out.
                    while self.news.try_recv().is_ok() {}
                    (self.fate)(Fate::Back);
                }
            }
        }
    }

    fn lose(&mut self, why: String) {
        self.capture = None;
        self.intake = self.home.recv_timeout(RELEASE).ok();
        (self.fate)(Fate::Lost(why));
    }
}
