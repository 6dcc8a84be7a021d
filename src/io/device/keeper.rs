//! Keeps a session on its device: notices when that is gone, goes on in silence, and comes back when it does. Never to another one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use cpal::Device;

use super::card::{Card, News, Shape};
use super::choose::{Chosen, again};
use super::failure::{DeviceError, Trouble};
use super::list::Found;
use super::minder::{Minder, Pulse, Search};
use super::virtual_card::VirtualCard;
use crate::live::board::Board;
use crate::live::driver::Driver;
use crate::live::gate::Order;

/// What becomes of a device.
#[derive(Debug, Clone, PartialEq)]
pub enum Fate {
    /// It is gone; the session goes on in silence.
    Lost(String),
    /// It is back.
    Back,
    /// The system lets the stream play on another device than it was opened on.
    Moved,
    /// Something else that the device said.
    Said(String),
}

/// Frames of a block of the virtual card where nobody says otherwise.
pub const BLOCK: usize = 128;

/// So long without a callback, and so many blocks: then the device is taken for lost.
const SILENT: Duration = Duration::from_millis(300);
const MISSED: f64 = 12.0;

/// So long a device may take to let go of a stream.
const RELEASE: Duration = Duration::from_secs(5);

enum Playing {
    Card(#[expect(dead_code, reason = "held, and dropped")] Card),
    Virtual(#[expect(dead_code, reason = "held, and dropped")] VirtualCard),
    /// The driver did not come home: nothing more can be played.
    Nothing,
}

/// Keeps a session on its device until it is dropped.
pub struct Keeper {
    _minder: Minder,
}

struct Keeping {
    id: Option<String>,
    shape: Shape,
    board: Arc<Board>,
    playing: Playing,
    home: Receiver<Box<Driver>>,
    lend: Sender<Box<Driver>>,
    news: Receiver<News>,
    tell: Sender<News>,
    fate: Box<dyn FnMut(Fate) + Send>,
    pulse: Pulse,
    search: Search,
    /// Whether the device is there.
    present: bool,
}

impl Keeper {
    /// Lets `driver` play on what was chosen, and hears of it through `fate`.
    ///
    /// # Errors
    /// A device that cannot be opened.
    pub fn start(
        driver: Driver,
        chosen: Chosen,
        shape: Shape,
        board: &Arc<Board>,
        fate: Box<dyn FnMut(Fate) + Send>,
    ) -> Result<Self, DeviceError> {
        let (lend, home) = channel();
        let (tell, news) = channel();
        let mut keeping = Keeping {
            id: None,
            shape,
            board: Arc::clone(board),
            playing: Playing::Nothing,
            home,
            lend,
            news,
            tell,
            fate,
            pulse: Pulse::new(),
            search: Search::new(),
            present: true,
        };
        match chosen {
            Chosen::Card(device, found) => {
                keeping.open(driver, &device, &found)?;
                keeping.id = Some(found.id);
            }
            Chosen::Virtual(_) => keeping.tick(driver)?,
        }
        let minder = Minder::start("device", move || keeping.look())?;
        Ok(Self { _minder: minder })
    }
}

impl Keeping {
    fn open(&mut self, driver: Driver, device: &Device, found: &Found) -> Result<(), DeviceError> {
        let lent = driver.lend(self.lend.clone());
        let card = Card::open(device, found, self.shape, lent, &self.board, self.tell.clone())?;
        self.playing = Playing::Card(card);
        Ok(())
    }

    fn tick(&mut self, driver: Driver) -> Result<(), DeviceError> {
        let block = self.shape.block.map_or(BLOCK, |block| block as usize);
        let lent = driver.lend(self.lend.clone());
        let card = VirtualCard::start(lent, self.shape.channels, f64::from(self.shape.rate), block).map_err(
            |error| DeviceError::new(Trouble::Other, format!("no thread for the virtual card: {error}")),
        )?;
        self.playing = Playing::Virtual(card);
        Ok(())
    }

    /// Takes the driver from whatever plays.
    fn take_home(&mut self) -> Option<Box<Driver>> {
        self.playing = Playing::Nothing;
        self.home.recv_timeout(RELEASE).ok()
    }

    /// Looks whether the device is there and asks for frames.
    fn look(&mut self) {
        let now = Instant::now();
        let pause = self.pulse.pause(now, self.board.frames.get());
        while let Ok(news) = self.news.try_recv() {
            match news {
                // Its own stream may say so too when it is closed.
                News::Lost(why) if self.present => self.lose(why),
                News::Lost(_) => {}
                News::Moved => (self.fate)(Fate::Moved),
                News::Said(what) => (self.fate)(Fate::Said(what)),
            }
        }
        let block = self.board.block.get().max(1) as f64 / f64::from(self.shape.rate);
        let silent = SILENT.max(Duration::from_secs_f64(MISSED * block));
        if self.present && self.id.is_some() && pause > silent {
            self.lose("it does not ask for anything any more".into());
        }
        if self.search.is_due(now, self.present) && self.find() {
            self.pulse.begin();
            // What the old stream said on its way out.
            while self.news.try_recv().is_ok() {}
        }
    }

    /// The device is gone: the clock goes on, on the virtual card, behind a closed gate.
    fn lose(&mut self, why: String) {
        self.present = false;
        if let Some(mut driver) = self.take_home() {
            let block = self.shape.block.map_or(BLOCK, |block| block as usize);
            driver.move_to(block, Order::Close);
            if let Err(error) = self.tick(*driver) {
                (self.fate)(Fate::Said(error.to_string()));
            }
        }
        (self.fate)(Fate::Lost(why));
    }

    /// Opens the device if it is there again. Says whether it did.
    fn find(&mut self) -> bool {
        let Some(id) = &self.id else { return false };
        let Ok((device, found)) = again(id) else { return false };
        let Some(mut driver) = self.take_home() else { return false };
        driver.move_to(self.shape.block.unwrap_or(0) as usize, Order::Return);
        if self.open(*driver, &device, &found).is_ok() {
            self.present = true;
            (self.fate)(Fate::Back);
            return true;
        }
        // It came home when it could not be opened.
        if let Ok(mut driver) = self.home.recv_timeout(RELEASE) {
            let block = self.shape.block.map_or(BLOCK, |block| block as usize);
            driver.move_to(block, Order::Close);
            if let Err(error) = self.tick(*driver) {
                (self.fate)(Fate::Said(error.to_string()));
            }
        }
        false
    }
}
