//! The screen: a thread that paints it, and one that listens to keys. Both may have to wait for a terminal that is slow or closed, and
//! nobody waits for them.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crossterm::event::Event;

use super::LOOK;
use super::draw::draw;
use super::snapshot::Snapshot;
use super::tty;

/// Keys that may wait.
const TYPED: usize = 200;

/// So long a terminal may take for the last frame.
const PATIENCE: Duration = Duration::from_millis(300);

/// What the thread that paints shares with the one that listens.
#[derive(Default)]
struct Face {
    /// Pages of the meters.
    pages: AtomicUsize,
    /// Whether everything is to be written again.
    redraw: AtomicBool,
}

/// A screen.
pub struct Screen {
    frames: Option<SyncSender<Snapshot>>,
    typed: Option<Receiver<Event>>,
    thread: JoinHandle<std::io::Result<()>>,
    face: Arc<Face>,
}

impl Screen {
    /// In colours, or not. The terminal is left alone until [`Screen::begin`].
    ///
    /// # Errors
    /// A thread that the system does not give.
    pub fn new(colours: bool) -> std::io::Result<Self> {
        let (frames, come) = sync_channel(1);
        let face = Arc::<Face>::default();
        let shared = Arc::clone(&face);
        let thread = std::thread::Builder::new()
            .name("screen".into())
            .spawn(move || paint(&come, &shared, colours))?;
        Ok(Self { frames: Some(frames), typed: None, thread, face })
    }

    /// Takes the terminal over, and listens to its keys from then on: in a thread of its own. Another sets `closing` at the moment at which the
    /// terminal is gone.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(&mut self, closing: Arc<AtomicBool>) -> std::io::Result<()> {
        tty::take()?;
        #[cfg(unix)]
        std::thread::Builder::new().name("hang-up".into()).spawn(move || {
            if tty::hangs_up() {
                closing.store(true, Ordering::Release);
            }
        })?;
        #[cfg(not(unix))]
        drop(closing);
        let (out, typed) = sync_channel(TYPED);
        std::thread::Builder::new().name("keys".into()).spawn(move || {
            while tty::is_taken() {
                match crossterm::event::poll(LOOK)
                    .and_then(|some| some.then(crossterm::event::read).transpose())
                {
                    Ok(None) => {}
                    // More keys than anybody can type at once are left out.
                    Ok(Some(event)) => drop(out.try_send(event)),
                    Err(_) => break,
                }
            }
        })?;
        self.typed = Some(typed);
        Ok(())
    }

    /// Waits for keys for a moment; `None` where there is no terminal any more.
    pub fn keys(&mut self) -> Option<Vec<Event>> {
        let typed = self.typed.as_ref()?;
        match typed.recv_timeout(LOOK) {
            Ok(first) => Some(std::iter::once(first).chain(typed.try_iter().take(TYPED)).collect()),
            Err(RecvTimeoutError::Timeout) => Some(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }

    /// Shows a frame, unless the last one is not shown yet. Says whether there is still a terminal.
    pub fn show(&mut self, snapshot: &Snapshot) -> bool {
        if let Some(frames) = &self.frames {
            // One that finds no room is left out: the next comes soon.
            let _ = frames.try_send(snapshot.clone());
        }
        !self.thread.is_finished()
    }
}

impl Screen {
    /// Pages of the meters.
    pub fn pages(&self) -> usize {
        self.face.pages.load(Ordering::Relaxed).max(1)
    }

    /// Everything is to be written again.
    pub fn redraw(&self) {
        self.face.redraw.store(true, Ordering::Relaxed);
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        drop(self.frames.take());
        let until = Instant::now() + PATIENCE;
        while !self.thread.is_finished() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        tty::give_back();
    }
}

fn paint(frames: &Receiver<Snapshot>, face: &Face, colours: bool) -> std::io::Result<()> {
    let mut painter = tty::Painter::new(colours);
    let mut out = std::io::stdout();
    for snapshot in frames {
        if !tty::is_taken() {
            break;
        }
        let (width, height) = crossterm::terminal::size()?;
        let (width, height) = (usize::from(width), usize::from(height));
        if width == 0 || height == 0 {
            // As that of a window which somebody has put away.
            continue;
        }
        if face.redraw.swap(false, Ordering::Relaxed) {
            painter.forget();
        }
        let drawn = draw(&snapshot, width, height);
        face.pages.store(drawn.pages, Ordering::Relaxed);
        out.write_all(painter.frame(&drawn.lines, width, height).as_bytes())?;
        out.flush()?;
    }
    Ok(())
}
