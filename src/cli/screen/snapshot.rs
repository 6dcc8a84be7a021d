//! Everything that the screen shows at one moment.

use super::controls::ControlFace;
use super::happened::Happened;
use super::meter::Meter;
use pacinian::io::session::Session;
use pacinian::live::board::Turned;

/// Everything that the screen shows at one moment.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// The patch.
    pub title: String,
    /// The device.
    pub device: String,
    /// Frames a second.
    pub rate: u32,
    /// Seconds since the session began, and how many it is to last.
    pub elapsed: f64,
    /// See `elapsed`.
    pub duration: Option<f64>,
    /// Full level, or -20 dB.
    pub armed: bool,
    /// Whether the torque of a knob that is read is wanted; `None`: none is.
    pub torque: Option<bool>,
    /// Where a knob is, if there is one.
    pub knob: Option<Turned>,
    /// Whether the brake is pulled.
    pub panicked: bool,
    /// Whether the device is away.
    pub lost: bool,
    /// Whether nothing is measured of what leaves: there is too much to do.
    pub blind: bool,
    /// Signals and patterns that found no room, by where they came from, in words.
    pub refused: String,
    /// Why what was saved last does not play.
    pub stale: Option<String>,
    /// The same in full, with places and help, a line each.
    pub wrong: Vec<String>,
    /// How the engine is doing.
    pub figures: Figures,
    /// What lies between an event and the skin.
    pub latency: Latency,
    /// By channel: the tactor's name, "" where nothing hangs, and its meter.
    pub tactors: Vec<(String, Meter)>,
    /// By key, from 1.
    pub keys: Vec<KeyFace>,
    /// The controls of the patch.
    pub controls: Vec<ControlFace>,
    /// Patterns for which there is no digit left.
    pub keyless: usize,
    /// The latest events, the last at the end.
    pub events: Vec<Happened>,
    /// Events that came too fast to be shown.
    pub missed: u64,
    /// Which page of the meters, where they have pages.
    pub page: usize,
    /// Rather pages with names than one sign for each tactor.
    pub paged: bool,
    /// Whether the terminal shows more than ASCII.
    pub fancy: bool,
}

/// What a digit does.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct KeyFace {
    /// The digit.
    pub digit: u32,
    /// The pattern or voice.
    pub name: String,
    /// Whether the pattern plays.
    pub playing: bool,
    /// Whether it sets off a trigger of the patch rather than a pattern.
    pub trigger: bool,
}

/// Counters and loads.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Figures {
    /// Share of all time that callbacks take, and that which 99.9 % of them do not pass.
    pub mean: f64,
    /// See `mean`.
    pub p999: f64,
    /// Callbacks that took longer than their period.
    pub over: u64,
    /// Gaps that the device told of.
    pub xruns: u64,
    /// Events that came too late.
    pub late: u64,
    /// Events and signals for which there was no room.
    pub lost: u64,
    /// Samples that the limiter turned down, that were cut at full scale, and that were no numbers.
    pub limited: u64,
    /// See `limited`.
    pub clamped: u64,
    /// See `limited`.
    pub masked: u64,
    /// Samples that were held back for the sake of actuators.
    pub held_back: u64,
    /// Messages of MIDI that could not be used.
    pub midi: u64,
    /// Voices that sound, that were started, and that had to make room.
    pub voices: u64,
    /// See `voices`.
    pub started: u64,
    /// See `voices`.
    pub stolen: u64,
}

/// What lies between an event and the skin, seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Latency {
    /// The longest block of the device so far, the most by which a callback comes early against the others, and what an event may take to the callback: by so much
    /// is everything played later than it comes, whatever the length of its own block.
    pub block: f64,
    /// The engine, for the envelope of a tone of 250 Hz.
    pub engine: f64,
    /// The device, as far as it says.
    pub device: Option<f64>,
    /// What lies beyond, as it was measured and the rig has it.
    pub beyond: Option<f64>,
    /// From what a device hears to the nodes that listen to it, while it is heard.
    pub input: Option<f64>,
}

impl Latency {
    /// As a session has it now; `beyond` as its rig has it.
    pub fn of(session: &Session, beyond: Option<f64>) -> Self {
        let board = session.board();
        let (device, input) = (board.device_delay.get(), board.input.latency.get());
        Self {
            // What events are delayed by is the same for all, whatever the last block was.
            block: session.clock().ahead() as f64 / session.rate().max(1.0),
            engine: session.delay().total(),
            device: device.map(|nanoseconds| nanoseconds as f64 * 1e-9),
            beyond,
            input: (input > 0).then_some(input as f64 * 1e-9 + session.input_delay()),
        }
    }

    /// All of what lies between an event and the skin.
    pub fn total(&self) -> f64 {
        self.block + self.engine + self.device.unwrap_or(0.0) + self.beyond.unwrap_or(0.0)
    }

    /// The same for people, who learn where the device does not say what it adds.
    pub fn told(&self) -> String {
        let least = if self.device.is_none() { "at least " } else { "" };
        format!("{least}{:.2} ms", 1000.0 * self.total())
    }
}
