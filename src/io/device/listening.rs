//! Keeps a session listening to its input device: notices when that is gone, and comes back when it does. Never to another one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use cpal::Device;

use super::capture::Capture;
use super::card::{News, Shape};
use super::choose::heard_again;
use super::failure::{DeviceError, Trouble};
use super::keeper::Fate;
use super::list::Found;
use super::minder::{Minder, Pulse, Search};
use crate::live::board::Board;
use crate::live::intake::Intake;

/// So long without a callback: then the device is taken for lost.
const SILENT: Duration = Duration::from_millis(500);

/// So long a device may take to let go of a stream.
const RELEASE: Duration = Duration::from_secs(5);

/// Listens until it is dropped.
pub struct Listening {
    _minder: Minder,
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
    pulse: Pulse,
    search: Search,
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
        let (pulse, search) = (Pulse::new(), Search::new());
        let mut keeping =
            Keeping { id, shape, board, capture, intake, home, lend, news, tell, fate, pulse, search };
        keeping.open(&device, &found)?;
        let minder = Minder::start("input", move || keeping.look())?;
        Ok(Self { _minder: minder })
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

    /// Looks whether the device is there and brings frames.
    fn look(&mut self) {
        let now = Instant::now();
        let pause = self.pulse.pause(now, self.board.input.frames.get());
        while let Ok(news) = self.news.try_recv() {
            match news {
                // Its own stream may say so too when it is closed.
                News::Lost(why) if self.capture.is_some() => self.lose(why),
                News::Lost(_) => {}
                News::Moved => (self.fate)(Fate::Moved),
                News::Said(what) => (self.fate)(Fate::Said(what)),
            }
        }
        if self.capture.is_some() && pause > SILENT {
            self.lose("it brings nothing any more".into());
        }
        if self.search.is_due(now, self.capture.is_some()) {
            let there = heard_again(&self.id).and_then(|(device, found)| self.open(&device, &found));
            if there.is_ok() {
                self.pulse.begin();
                // What the old stream said on its way out.
                while self.news.try_recv().is_ok() {}
                (self.fate)(Fate::Back);
            }
        }
    }

    fn lose(&mut self, why: String) {
        self.capture = None;
        self.intake = self.home.recv_timeout(RELEASE).ok();
        (self.fate)(Fate::Lost(why));
    }
}
