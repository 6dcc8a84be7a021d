//! Keeps a session listening to its input device: notices when that is gone, and comes back when it does. Never to another one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use cpal::Device;

use super::capture::Capture;
use super::card::{News, Shape};
use super::choose::heard_again;
use super::failure::{DeviceError, Trouble};
use super::hosts::Hosts;
use super::keeper::Fate;
use super::list::Found;
use super::minder::{Bell, Minder, Pulse, Search, bell, let_go};
use super::watch::{Direction, Watch};
use crate::live::board::Board;
use crate::live::intake::Intake;
use crate::live::lent::{Recall, lend};

/// So long without a callback: then the device is taken for lost.
const SILENT: Duration = Duration::from_millis(500);

/// Listens until it is dropped.
pub struct Listening {
    _minder: Minder,
}

struct Keeping {
    /// Where the device is looked for, and its id.
    hosts: Hosts,
    id: String,
    shape: Shape,
    board: Arc<Board>,
    /// While the device is there.
    capture: Option<Capture>,
    /// While it is not.
    intake: Option<Box<Intake>>,
    home: Receiver<Box<Intake>>,
    lend: Sender<Box<Intake>>,
    /// By which it is taken from a device that does not give it back.
    recall: Option<Recall<Intake>>,
    /// What the device that is open says; of one that was let go of, nobody hears any more.
    news: Option<Receiver<News>>,
    fate: Box<dyn FnMut(Fate) + Send>,
    bell: Bell,
    pulse: Pulse,
    search: Search,
    watch: Watch,
    /// Where it was told that the device is gone: frames that had come by then.
    gone: Option<u64>,
    /// What was said last of why it is not listened to.
    trouble: Option<String>,
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
        let ((lend, home), (bell, ear)) = (channel(), bell());
        let mut keeping = Keeping {
            hosts: found.hosts.clone(),
            id: found.id.clone(),
            shape,
            board: Arc::clone(board),
            capture: None,
            intake: Some(Box::new(intake)),
            home,
            lend,
            recall: None,
            news: None,
            fate,
            bell: bell.clone(),
            pulse: Pulse::new(),
            search: Search::new(),
            watch: Watch::of(&found.id),
            gone: None,
            trouble: None,
        };
        keeping.open(&device, &found)?;
        let minder = Minder::start("input", (bell, ear), move || keeping.look())?;
        Ok(Self { _minder: minder })
    }
}

impl Keeping {
    fn open(&mut self, device: &Device, found: &Found) -> Result<(), DeviceError> {
        let home = || self.home.try_recv().ok().or_else(|| self.recall.as_ref()?.take());
        let Some(mut intake) = self.intake.take().or_else(home) else {
            let what = format!("{} has not let go of the input", found.name);
            return Err(DeviceError::new(Trouble::Other, what));
        };
        let shape = self.shape.again(found.input.as_ref());
        intake.forget(shape.block.unwrap_or(0) as usize);
        let (lent, recall) = lend(intake, self.lend.clone());
        self.recall = Some(recall);
        let (tell, news) = self.bell.news();
        self.capture = Some(Capture::open(device, found, shape, lent, &self.board, tell)?);
        self.news = Some(news);
        Ok(())
    }

    /// Looks whether the device is there and brings frames.
    fn look(&mut self) {
        let now = Instant::now();
        let frames = self.board.input.frames.get();
        let pause = self.pulse.pause(now, frames);
        while let Some(Ok(news)) = self.news.as_ref().map(Receiver::try_recv) {
            match news {
                News::Lost(why) | News::Broke(why) => self.lose(why),
                News::Moved => self.moved(),
                News::Said(what) => (self.fate)(Fate::Said(what)),
            }
        }
        if self.capture.is_some() && pause > SILENT {
            self.lose("it brings nothing any more".into());
        }
        if self.capture.is_some() && self.watch.finds_away(now, &self.hosts, &self.id, Direction::In) {
            self.moved();
        }
        // That it lets itself be opened does not mean that it hears.
        if self.capture.is_some() && self.gone.is_some_and(|before| frames != before) {
            (self.gone, self.trouble) = (None, None);
            (self.fate)(Fate::Back);
        }
        if self.search.is_due(now, self.capture.is_some()) {
            let there = heard_again(&self.hosts, &self.id);
            match there.and_then(|(device, found)| self.open(&device, &found)) {
                Ok(()) => {
                    self.pulse.begin();
                    self.watch.forget();
                }
                // That it is away is known.
                Err(error) if error.kind == Trouble::Missing => {}
                Err(error) => self.complain(error.to_string()),
            }
        }
    }

    /// What comes is of another device, and is not listened to.
    fn moved(&mut self) {
        (self.fate)(Fate::Moved);
        self.lose("what comes from another is not heard; its own is waited for".into());
    }

    /// The device is gone, or gone again.
    fn lose(&mut self, why: String) {
        self.news = None;
        if self.gone.is_none() {
            self.trouble = Some(why.clone());
            (self.fate)(Fate::Lost(why));
        } else {
            self.complain(why);
        }
        self.capture.take().into_iter().for_each(let_go);
        self.gone = Some(self.board.input.frames.get());
    }

    /// It is there and cannot be listened to, which is said once.
    fn complain(&mut self, why: String) {
        if self.trouble.as_ref() != Some(&why) {
            (self.fate)(Fate::Said(why.clone()));
            self.trouble = Some(why);
        }
    }
}

impl Drop for Keeping {
    fn drop(&mut self) {
        self.capture.take().into_iter().for_each(let_go);
    }
}
