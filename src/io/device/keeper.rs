//! Keeps a session on its device: notices when that is gone, goes on in silence, and comes back when it does. Never to another one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use cpal::Device;

use super::card::{Card, News, Shape};
use super::choose::{Chosen, again};
use super::failure::{DeviceError, Trouble};
use super::hosts::Hosts;
use super::list::Found;
use super::minder::{Bell, Minder, Pace, Pulse, RUSH, Search, WATCH, bell, let_go};
use super::returning::{Returning, Stand};
use super::servers::Server;
use super::virtual_card::VirtualCard;
use super::watch::{Direction, Watch};
use crate::live::board::Board;
use crate::live::driver::Driver;
use crate::live::gate::{Order, UNARMED};
use crate::live::lent::{Lent, Recall, lend};

/// What becomes of a device.
#[derive(Debug, Clone, PartialEq)]
pub enum Fate {
    /// It is gone; the session goes on in silence.
    Lost(String),
    /// It is back.
    Back,
    /// The system has led the stream to another device than it was opened on: it is let go of.
    Moved,
    /// Nobody has named the device, so what comes back may be another: at -20 dB until it is armed.
    Lowered,
    /// Something else that the device said.
    Said(String),
}

/// What is said where what computes has panicked.
const FAULT: &str =
    "the thread that computes has panicked, or a task in it: silence from here on; start anew";

/// Frames of a block of the virtual card where nobody says otherwise.
pub const BLOCK: usize = 128;

/// So long without a callback, and so many blocks: then the device is taken for lost.
const SILENT: Duration = Duration::from_millis(300);
const MISSED: f64 = 12.0;

/// How often a driver is looked for that a device has, which fills a block in less than all of that, and how long after each.
const RECALLS: u32 = 50;
const RECALL: Duration = Duration::from_micros(200);

enum Playing {
    Card(Card),
    Virtual(#[expect(dead_code, reason = "held, and dropped")] VirtualCard),
    /// The device has not let go of the driver yet.
    Nothing,
}

/// Keeps a session on its device until it is dropped.
pub struct Keeper {
    resting: Arc<AtomicBool>,
    _minder: Minder,
}

struct Keeping {
    /// Where the device is looked for, and its id; `None`: the virtual card is all that was chosen.
    sought: Option<(Hosts, String)>,
    /// Whether it is what the system plays on where nobody says anything: its id may then lead to another device.
    default: bool,
    /// Whether a server has run that may be behind a device of ALSA's.
    served: bool,
    shape: Shape,
    board: Arc<Board>,
    playing: Playing,
    /// Where it seems to be back.
    returning: Option<Returning>,
    home: Receiver<Box<Driver>>,
    lend: Sender<Box<Driver>>,
    /// By which it is taken from whatever does not give it back.
    recall: Option<Recall<Driver>>,
    /// What the device that plays says; of one that was let go of, nobody hears any more.
    news: Option<Receiver<News>>,
    fate: Box<dyn FnMut(Fate) + Send>,
    /// What a device says is looked at at once.
    bell: Bell,
    pulse: Pulse,
    pace: Pace,
    /// Whether it was told that what computes has panicked.
    faulted: bool,
    /// It computed ahead of time, and is given nothing before it keeps time again.
    rushed: bool,
    search: Search,
    watch: Watch,
    /// The session is about to end.
    resting: Arc<AtomicBool>,
    /// What was said last of why it does not play.
    trouble: Option<String>,
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
        let ((lend, home), (bell, ear)) = (channel(), bell());
        let mut keeping = Keeping {
            sought: None,
            default: false,
            served: false,
            shape,
            board: Arc::clone(board),
            playing: Playing::Nothing,
            returning: None,
            home,
            lend,
            recall: None,
            news: None,
            fate,
            bell: bell.clone(),
            pulse: Pulse::new(),
            pace: Pace::begin(Instant::now(), board.frames.get()),
            faulted: false,
            rushed: false,
            search: Search::new(),
            watch: Watch::default(),
            resting: Arc::default(),
            trouble: None,
        };
        let resting = Arc::clone(&keeping.resting);
        match chosen {
            Chosen::Card(device, found) => {
                if found.pulse().is_some() {
                    keeping.begin_late(&device, &found, driver)?;
                } else {
                    let (tell, news) = keeping.bell.news();
                    let lent = keeping.lend(driver);
                    keeping.playing = Playing::Card(Card::open(&device, &found, shape, lent, board, tell)?);
                    keeping.news = Some(news);
                }
                keeping.default = found.may_be_another();
                keeping.served = keeping.default && Server::all().iter().any(Server::may_be_behind_alsa);
                keeping.watch = Watch::of(&found.id);
                keeping.sought = Some((found.hosts, found.id));
            }
            Chosen::Virtual(_) => keeping.tick(driver, false)?,
        }
        let minder = Minder::start("device", (bell, ear), move || keeping.look())?;
        Ok(Self { resting, _minder: minder })
    }

    /// From now on, a device that is away is not come back to: what is about to be closed is not to be opened once more.
    pub fn rest(&self) {
        self.resting.store(true, Ordering::Release);
    }
}

impl Keeping {
    fn lend(&mut self, driver: Driver) -> Lent<Driver> {
        let (lent, recall) = lend(Box::new(driver), self.lend.clone());
        self.recall = Some(recall);
        lent
    }

    /// Of a device that may pause at first: the clock begins when it does not any more.
    fn begin_late(&mut self, device: &Device, found: &Found, driver: Driver) -> Result<(), DeviceError> {
        let mut first = Returning::open(device, found, self.shape, false, &self.board, &self.bell)?;
        loop {
            match first.stand(Instant::now()) {
                Stand::Waits => std::thread::sleep(WATCH),
                Stand::Plays => break,
                Stand::Fails(why) => {
                    return Err(DeviceError::new(Trouble::Other, format!("{}: {why}", found.name)));
                }
            }
        }
        let (card, said, news) = first.play(self.lend(driver));
        (self.playing, self.news) = (Playing::Card(card), Some(news));
        said.into_iter().for_each(|news| self.hear(news));
        Ok(())
    }

    /// On the virtual card, which may stand in for one that is away.
    fn tick(&mut self, driver: Driver, stands_in: bool) -> Result<(), DeviceError> {
        let block = self.shape.block.map_or(BLOCK, |block| block as usize);
        let lent = self.lend(driver);
        let (channels, rate, board) = (self.shape.channels, f64::from(self.shape.rate), self.board.clone());
        let card = VirtualCard::start(lent, channels, rate, block, board, stands_in)
            .map_err(|error| DeviceError::no_thread("virtual card", &error))?;
        self.playing = Playing::Virtual(card);
        Ok(())
    }

    /// The clock goes on, on the virtual card, behind a closed gate.
    fn go_on(&mut self, mut driver: Driver) {
        let block = self.shape.block.map_or(BLOCK, |block| block as usize);
        driver.move_to(block, Order::Close);
        if let Err(error) = self.tick(driver, true) {
            (self.fate)(Fate::Said(error.to_string()));
        }
    }

    /// Takes the driver from whatever plays; `None` while that does not let go of it.
    fn take_home(&mut self) -> Option<Box<Driver>> {
        match std::mem::replace(&mut self.playing, Playing::Nothing) {
            Playing::Card(card) => let_go(card),
            other => drop(other),
        }
        self.driver()
    }

    /// The driver, once a device has let go of it or is between two blocks.
    fn driver(&self) -> Option<Box<Driver>> {
        self.home.try_recv().ok().or_else(|| self.recall.as_ref()?.take())
    }

    fn is_present(&self) -> bool {
        matches!(self.playing, Playing::Card(_))
    }

    /// Looks whether the device is there and asks for frames.
    fn look(&mut self) {
        let now = Instant::now();
        let pause = self.pulse.pause(now, self.board.frames.get());
        while let Some(Ok(news)) = self.news.as_ref().map(Receiver::try_recv) {
            self.hear(news);
        }
        if self.board.faults.get() > 0 && !std::mem::replace(&mut self.faulted, true) {
            (self.fate)(Fate::Said(FAULT.into()));
        }
        let block = self.board.block.get().max(1) as f64 / f64::from(self.shape.rate);
        let silent = SILENT.max(Duration::from_secs_f64(MISSED * block));
        if self.is_present() && pause > silent {
            self.lose("it does not ask for anything any more".into());
        }
        let speed = self.pace.speed(now, self.board.frames.get(), f64::from(self.shape.rate));
        let rushes = self.is_present() && speed.is_some_and(|speed| speed > RUSH);
        if matches!(&self.playing, Playing::Card(card) if card.rushes()) {
            self.rushed = true;
            self.leave(
                "JACK computes ahead of time (freewheel): it is waited for until it keeps time again".into(),
            );
        } else if rushes {
            self.leave("it takes what it is given as fast as it comes, so that nothing keeps time on it: it is not come back to".into());
            self.sought = None;
        }
        if matches!(self.playing, Playing::Nothing)
            && let Some(driver) = self.driver()
        {
            self.go_on(*driver);
        }
        if self.resting.load(Ordering::Acquire) {
            return;
        }
        match self.returning.as_mut().map(|returning| returning.stand(now)) {
            Some(Stand::Waits) => {}
            Some(Stand::Plays) => self.come_back(),
            Some(Stand::Fails(why)) => {
                self.returning.take().into_iter().for_each(let_go);
                self.complain(why);
            }
            None if self.search.is_due(now, self.is_present()) => self.find(),
            None if self.is_present() && self.finds_away(now) => self.moved(),
            None => {}
        }
    }

    /// Of a host that moves streams without a word: whether the device is none of its any more, or the stream is on another.
    fn finds_away(&mut self, now: Instant) -> bool {
        let Some((hosts, id)) = &self.sought else { return false };
        self.watch.finds_away(now, hosts, id, Direction::Out)
    }

    fn hear(&mut self, news: News) {
        match news {
            News::Lost(why) => self.lose(why),
            // ALSA's device is opened as it was, where no server can have made another of it.
            News::Broke(why) if self.sought.as_ref().is_some_and(|(_, id)| id.starts_with("alsa:")) => self
                .break_off(format!(
                    "{why}: it was not fed in time, or its server let go of it; a larger --block helps"
                )),
            // Whoever moves streams may have done so.
            News::Broke(why) => self.lose(why),
            News::Moved => self.moved(),
            News::Said(what) => (self.fate)(Fate::Said(what)),
        }
    }

    /// A device of ALSA's broke off. A server that ALSA hands a default to, and that dies, leaves it to whatever is there then.
    fn break_off(&mut self, why: String) {
        self.served |= Server::all().iter().any(Server::may_be_behind_alsa);
        if self.served { self.lose(why) } else { self.leave(why) }
    }

    /// The device is gone. What the system plays on by default may be another by the time it is there again.
    fn lose(&mut self, why: String) {
        if self.default {
            self.board.lever.gain(UNARMED, 0);
            (self.fate)(Fate::Lowered);
        }
        self.leave(why);
    }

    /// Goes on in silence until the device is opened again.
    fn leave(&mut self, why: String) {
        self.news = None;
        self.trouble = Some(why.clone());
        self.board.away_since.set(self.board.frames.get() + 1);
        (self.fate)(Fate::Lost(why));
        // The clock goes on before the device has let go: one whose server has died may take seconds for it, or for ever.
        let left = std::mem::replace(&mut self.playing, Playing::Nothing);
        if let Some(driver) = self.recall() {
            self.go_on(*driver);
        }
        if let Playing::Card(card) = left {
            let_go(card);
        }
    }

    /// The driver, taken from a device between two blocks.
    fn recall(&self) -> Option<Box<Driver>> {
        (0..RECALLS).find_map(|n| {
            if n > 0 {
                std::thread::sleep(RECALL);
            }
            self.driver()
        })
    }

    /// The stream plays somewhere else: it is let go of, and its own device looked for.
    fn moved(&mut self) {
        (self.fate)(Fate::Moved);
        self.lose("what is played goes to no other; its own is waited for".into());
    }

    /// Opens the device if it is there again.
    fn find(&mut self) {
        let Some((hosts, id)) = &self.sought else { return };
        let found = again(hosts, id);
        match found.and_then(|(device, found)| {
            Returning::open(&device, &found, self.shape, self.rushed, &self.board, &self.bell)
        }) {
            Ok(returning) => self.returning = Some(returning),
            // That it is away is known.
            Err(error) if error.kind == Trouble::Missing => {}
            Err(error) => self.complain(error.to_string()),
        }
    }

    /// It is there and cannot be played on, which is said once.
    fn complain(&mut self, why: String) {
        if self.trouble.as_ref() != Some(&why) {
            (self.fate)(Fate::Said(why.clone()));
            self.trouble = Some(why);
        }
    }

    /// It asks for frames: it gets those of the session.
    fn come_back(&mut self) {
        let Some(mut driver) = self.take_home() else { return };
        let Some(returning) = self.returning.take() else { return self.go_on(*driver) };
        driver.move_to(self.shape.block.unwrap_or(0) as usize, Order::Return);
        let (card, said, news) = returning.play(self.lend(*driver));
        (self.playing, self.news, self.trouble) = (Playing::Card(card), Some(news), None);
        self.rushed = false;
        self.pulse.begin();
        self.watch.forget();
        self.board.away.set(self.board.absence().0);
        self.board.away_since.set(0);
        (self.fate)(Fate::Back);
        said.into_iter().for_each(|news| self.hear(news));
    }
}

impl Drop for Keeping {
    fn drop(&mut self) {
        drop(self.take_home());
        self.returning.take().into_iter().for_each(let_go);
    }
}
