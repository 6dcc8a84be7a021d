//! A real knob on a serial line, `controller`.

use crate::knob::angle::decoder::{Sense, Sensor};
use crate::knob::angle::resolver::Pair;
use crate::text::Problem;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// What is at the other end of a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    /// The port: `/dev/ttyACM0`, `COM3`.
    pub port: String,
    /// Bits a second.
    pub baud: u32,
    /// Whether its angle falls where the knob's rises; its torque is turned round with it.
    pub inverted: bool,
    /// Seconds that an answer may take: then torque ends. Of one that does not render by itself.
    pub patience: f64,
    /// What it speaks.
    pub kind: Kind,
}

/// What a controller speaks.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// An ODrive's ASCII lines: the torque is computed here.
    ODrive {
        /// 0 or 1.
        axis: u8,
        /// Exchanges a second.
        exchanges: f64,
        /// Seconds after which the board stops its motor by itself.
        watchdog: f64,
        /// Whether to drive a board that has no watchdog.
        unwatched: bool,
        /// Seconds from an angle to the torque that the line's own thread makes of it, where somebody has measured it.
        delay: Option<f64>,
    },
    /// A SmartKnob's frames: it renders by itself, N m/rad at a strength of 1.
    SmartKnob(f64),
}

/// The amplitude with which sine and cosine of its angle are heard, and their input channels.
pub const AMPLITUDE: f64 = 0.5;
const CHANNELS: [usize; 2] = [0, 1];

/// Its keys.
pub(crate) static CONTROLLER: Table = Table {
    name: "knob controller",
    doc: "The serial line of a knob that is there, with `pacinian play`. Its angle is heard as input, on the two channels behind those that `input` nodes hear of a sound card.",
    fields: &[
        Field::new(
            "type",
            Form::Word(&["odrive", "smartknob"]),
            "",
            "An ODrive by its ASCII lines, which gives the torque that is computed here; or a SmartKnob, which is told what to be and renders by itself.",
        )
        .required(),
        Field::new("port", Form::Text, "", "Its serial port: /dev/ttyACM0, COM3.").required(),
        Field::new("baud", Form::any_count(300, 10_000_000), "bit/s", "115200 for an ODrive, 921600 for a SmartKnob. Over USB alone any will do."),
        Field::new("inverted", Form::Flag(false), "", "Whether its angle falls where the knob's rises."),
        Field::new(
            "patience",
            Form::number(0.004, 1e-3, 0.25),
            "s",
            "How long an ODrive's answer is waited for. Torque is 0 from the end of its exchange on, or from a quarter more than the slowest of the last answers took, until it comes; for `stale` longer, and it stays so until somebody asks. Half the watchdog's time at most.",
        ),
        Field::new("axis", Form::count(0, 0, 1), "", "Of an ODrive."),
        Field::new("exchanges", Form::number(1000.0, 100.0, 20_000.0), "Hz", "Torques out and angles back a second, of an ODrive."),
        Field::new(
            "watchdog",
            Form::number(0.05, 0.01, 1.0),
            "s",
            "After which an ODrive stops its motor by itself where nothing reaches it.",
        ),
        Field::new(
            "delay",
            Form::any_number(0.0, 0.1),
            "s",
            "Of an ODrive: from an angle to what depends on the angle alone of its torque, measured, beside the exchange for which that is held. The line's own thread works that out at each angle; only what is made of the speed waits for a block, `delay` of the knob. Two exchanges and 2 ms where nothing is said.",
        ),
        Field::new("unwatched", Form::Flag(false), "", "Whether to drive a board whose watchdog cannot be set: nothing stops its motor then if this program dies."),
        Field::new(
            "strength",
            Form::any_number(1e-6, 1e3),
            "N m/rad",
            "Of a SmartKnob: how stiff it is at a strength of 1. A weight on a lever tells it.",
        ),
    ],
    others: None,
};

const OF_ODRIVE: [&str; 6] = ["axis", "exchanges", "watchdog", "patience", "unwatched", "delay"];
const OF_SMARTKNOB: [&str; 1] = ["strength"];

/// Reads it.
pub(super) fn read(reader: &Reader) -> Option<Controller> {
    reader.at("type")?.text()?;
    let is_odrive = reader.word("type") == 0;
    let (others, name): (&[&str], _) =
        if is_odrive { (&OF_SMARTKNOB, "smartknob") } else { (&OF_ODRIVE, "odrive") };
    let wrong = |key: &str, what: String, help: &str| {
        let span = if reader.has(key) { reader.span_of(key) } else { reader.span.clone() };
        reader.sink.push(Problem::error(&span, what).help(help.to_string()));
    };
    for key in others.iter().filter(|key| reader.has(key)) {
        wrong(key, format!("`{key}` of {} goes with type = \"{name}\"", reader.who), "leave it out");
    }
    let port = reader.text("port")?.to_string();
    if port.is_empty() {
        wrong(
            "port",
            format!("{} has a `port` without a name", reader.who),
            "name it: port = \"/dev/ttyACM0\"",
        );
        return None;
    }
    let patience = reader.number_or_default("patience");
    let kind = if is_odrive {
        let (exchanges, watchdog) =
            (reader.number_or_default("exchanges"), reader.number_or_default("watchdog"));
        if patience > 0.5 * watchdog {
            let what = format!(
                "`patience` {patience} s of {} is more than half of `watchdog` {watchdog} s",
                reader.who
            );
            wrong("patience", what, "the watchdog is there for what patience does not see");
            return None;
        }
        if exchanges * watchdog < 2.0 {
            let what = format!(
                "`watchdog` {watchdog} s of {} has no two exchanges, of {exchanges} a second",
                reader.who
            );
            wrong("watchdog", what, "it must be fed twice over");
            return None;
        }
        Kind::ODrive {
            axis: reader.count("axis").unwrap_or(0) as u8,
            exchanges,
            watchdog,
            unwatched: reader.flag("unwatched"),
            delay: reader.number("delay"),
        }
    } else {
        let Some(strength) = reader.number("strength") else {
            let what =
                format!("{} lacks `strength`: how stiff a SmartKnob is at a strength of 1", reader.who);
            wrong(
                "strength",
                what,
                "hang a weight on a lever of known length and read the angle: strength = torque / angle",
            );
            return None;
        };
        Kind::SmartKnob(strength)
    };
    let baud = reader.count("baud").map_or(if is_odrive { 115_200 } else { 921_600 }, |baud| baud as u32);
    Some(Controller { port, baud, inverted: reader.flag("inverted"), patience, kind })
}

impl Controller {
    /// How its angle is heard.
    pub fn sensor(&self) -> Sensor {
        Sensor { sense: Sense::Pair(Pair::of(AMPLITUDE, 1)), channels: CHANNELS, inverted: self.inverted }
    }

    /// Whether it renders by itself.
    pub fn renders(&self) -> bool {
        matches!(self.kind, Kind::SmartKnob(_))
    }

    /// Seconds from an angle to its torque, without what blocks take: it waits for one exchange each way, and for the line.
    pub fn late(&self) -> f64 {
        match self.kind {
            Kind::ODrive { exchanges, .. } => 2.0 / exchanges + LINE,
            Kind::SmartKnob(_) => LINE,
        }
    }

    /// Seconds from exchange to exchange, where torque is computed here; 0 where it is not.
    pub fn exchange(&self) -> f64 {
        match self.kind {
            Kind::ODrive { exchanges, .. } => 1.0 / exchanges,
            Kind::SmartKnob(_) => 0.0,
        }
    }

    /// Seconds from an angle to the torque that the line's own thread makes of it: all of the above but for blocks, or as measured, and half of the
    /// exchange for which it is held. `None`: the line's thread makes none.
    pub fn alone(&self) -> Option<f64> {
        match self.kind {
            Kind::ODrive { exchanges, delay, .. } => {
                Some(delay.map_or(self.late(), |delay| delay + 0.5 / exchanges))
            }
            Kind::SmartKnob(_) => None,
        }
    }
}

/// Seconds that a USB line takes both ways, where nobody has measured it.
const LINE: f64 = 2e-3;
/// Blocks: one for which an angle waits, and one over which its torque is held.
pub(super) const BLOCKS: f64 = 2.0;
