//! What the frames hold.
//!
//! Both dialects call themselves version 1. What goes to the knob has the same field numbers in both; what comes from it has not: an
//! acknowledgement, a line of its log and its state are 2, 3 and 4 in the original, and 4, 5 and 6 in SeedLabs's fork, which has in 3 what
//! the knob is. So a question with a number by chance is asked first: that number comes back in 2, or in 4 with nothing beside it.

use super::config::Config;
use super::wire::{Broken, Fields, Writer};

/// The version that both call themselves.
pub const VERSION: u32 = 1;

/// In which numbers the knob speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// scottbez1/smartknob.
    Original,
    /// SeedLabs-it/smartknob-firmware.
    SeedLabs,
}

/// What goes to the knob.
#[derive(Debug, Clone, PartialEq)]
pub enum ToKnob<'a> {
    /// Say how you are.
    State,
    /// Be this.
    Config(&'a Config),
}

impl ToKnob<'_> {
    /// As bytes, with a number by which it is acknowledged.
    pub fn encode(&self, nonce: u32) -> Vec<u8> {
        let mut writer = Writer::default();
        writer.unsigned(1, VERSION);
        writer.unsigned(2, nonce);
        match self {
            Self::State => writer.message(3, &[]),
            Self::Config(config) => writer.message(4, &config.encode()),
        }
        writer.done()
    }
}

impl Config {
    fn encode(&self) -> Vec<u8> {
        let mut writer = Writer::default();
        writer.signed(1, self.position);
        writer.float(2, self.sub_position);
        writer.unsigned(3, u32::from(self.position_nonce));
        writer.signed(4, self.min);
        writer.signed(5, self.max);
        writer.float(6, self.width);
        writer.float(7, self.detent_strength);
        writer.float(8, self.endstop_strength);
        writer.float(9, self.snap_point);
        writer.text(10, &self.text);
        writer.packed(11, &self.detents);
        writer.float(12, self.snap_point_bias);
        writer.signed(13, i32::from(self.hue));
        writer.done()
    }

    fn decode(bytes: &[u8]) -> Result<Self, Broken> {
        let empty = Self { max: 0, width: 0.0, endstop_strength: 0.0, snap_point: 0.0, ..Self::default() };
        Fields::of(bytes).try_fold(empty, |mut config, field| {
            let (field, value) = field?;
            match (field, value.number(), value.float(), value.bytes()) {
                (1, Some(n), ..) => config.position = n as i32,
                (2, _, Some(x), _) => config.sub_position = x,
                (3, Some(n), ..) => config.position_nonce = n as u8,
                (4, Some(n), ..) => config.min = n as i32,
                (5, Some(n), ..) => config.max = n as i32,
                (6, _, Some(x), _) => config.width = x,
                (7, _, Some(x), _) => config.detent_strength = x,
                (8, _, Some(x), _) => config.endstop_strength = x,
                (9, _, Some(x), _) => config.snap_point = x,
                (10, _, _, Some(text)) => config.text = String::from_utf8_lossy(text).into_owned(),
                (11, Some(n), ..) => config.detents.push(n as i32),
                (11, _, _, Some(packed)) => {
                    let mut packed = Fields::of(packed);
                    while !packed.is_done() {
                        config.detents.push(packed.varint().ok_or(Broken)? as i32);
                    }
                }
                (12, _, Some(x), _) => config.snap_point_bias = x,
                (13, Some(n), ..) => config.hue = n as u8,
                _ => {}
            }
            Ok(config)
        })
    }
}

/// How the knob is.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The position it is in.
    pub position: i32,
    /// And how far from its middle, in widths.
    pub sub_position: f32,
    /// What is in force.
    pub config: Config,
    /// Counts how often it was pressed and let go.
    pub press_nonce: u8,
}

impl State {
    /// Its angle from position 0, radians; `None` where it says nonsense.
    pub fn angle(&self) -> Option<f64> {
        let positions = f64::from(self.position) + f64::from(self.sub_position);
        let angle = positions * f64::from(self.config.width);
        (angle.is_finite() && self.config.width > 0.0).then_some(angle)
    }

    fn decode(bytes: &[u8]) -> Result<Self, Broken> {
        let empty = Self { position: 0, sub_position: 0.0, config: Config::decode(&[])?, press_nonce: 0 };
        Fields::of(bytes).try_fold(empty, |mut state, field| {
            let (field, value) = field?;
            match (field, value.number(), value.float(), value.bytes()) {
                (1, Some(n), ..) => state.position = n as i32,
                (2, _, Some(x), _) => state.sub_position = x,
                (3, _, _, Some(config)) => state.config = Config::decode(config)?,
                (4, Some(n), ..) => state.press_nonce = n as u8,
                _ => {}
            }
            Ok(state)
        })
    }
}

/// What comes from the knob.
#[derive(Debug, Clone, PartialEq)]
pub enum FromKnob {
    /// It got the message of this number.
    Ack(u32),
    /// A line of its log.
    Log(String),
    /// How it is.
    State(Box<State>),
    /// Something else.
    Other,
    /// It calls itself another version.
    Version(u32),
}

impl FromKnob {
    /// Out of the bytes of a message.
    ///
    /// # Errors
    /// Bytes that are no message.
    pub fn decode(bytes: &[u8], dialect: Dialect) -> Result<Self, Broken> {
        let numbers = match dialect {
            Dialect::Original => [2, 3, 4],
            Dialect::SeedLabs => [4, 5, 6],
        };
        let (mut version, mut found) = (0, Self::Other);
        for field in Fields::of(bytes) {
            let (field, value) = field?;
            match (field, value.number(), value.bytes()) {
                (1, Some(n), _) => version = n as u32,
                (field, _, Some(bytes)) if field == numbers[0] => {
                    found = Self::Ack(first(bytes)?.unwrap_or(0))
                }
                (field, _, Some(bytes)) if field == numbers[1] => found = Self::Log(log(bytes)?),
                (field, _, Some(bytes)) if field == numbers[2] => {
                    found = Self::State(Box::new(State::decode(bytes)?));
                }
                _ => {}
            }
        }
        Ok(if version == VERSION { found } else { Self::Version(version) })
    }
}

/// The dialect of a knob that answers the question of this number so, if it is the answer.
pub fn dialect(bytes: &[u8], nonce: u32) -> Option<Dialect> {
    Fields::of(bytes).flatten().find_map(|(field, value)| {
        let acknowledged = first(value.bytes()?).ok()?? == nonce;
        let alone = Fields::of(value.bytes()?).count() == 1;
        match field {
            2 if acknowledged => Some(Dialect::Original),
            4 if acknowledged && alone => Some(Dialect::SeedLabs),
            _ => None,
        }
    })
}

fn first(bytes: &[u8]) -> Result<Option<u32>, Broken> {
    let mut found = None;
    for field in Fields::of(bytes) {
        if let (1, value) = field? {
            found = value.number().map(|n| n as u32);
        }
    }
    Ok(found)
}

fn log(bytes: &[u8]) -> Result<String, Broken> {
    let mut text = String::new();
    for field in Fields::of(bytes) {
        if let (1, value) = field? {
            text = String::from_utf8_lossy(value.bytes().unwrap_or(&[])).into_owned();
        }
    }
    Ok(text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect())
}

#[cfg(test)]
mod tests {
    use super::super::frame::{pack, unpack};
    use super::{Config, Dialect, FromKnob, State, ToKnob, dialect};

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len()).step_by(2).map(|k| u8::from_str_radix(&hex[k..k + 2], 16).unwrap()).collect()
    }

    fn ten() -> Config {
        Config { max: 10, detent_strength: 1.0, text: "pacinian".into(), ..Config::default() }
    }

    #[test]
    fn what_goes_out_is_what_the_firmware_was_seen_to_take() {
        let state = ToKnob::State.encode(7);
        assert_eq!(state, bytes("080110071a00"));
        assert_eq!(pack(&state), bytes("06080110071a05bfb18a8500"));
        let config = ToKnob::Config(&ten()).encode(8);
        let wire = "0f080110082220280a35c2b8323e3d0104803f450116803f4dcdcc8c3f5208706163696e69616ee4d8188500";
        assert_eq!(pack(&config), bytes(wire));
        let nothing = Config { width: 0.0, endstop_strength: 0.0, snap_point: 0.0, ..Config::default() };
        let config = ToKnob::Config(&nothing).encode(9);
        assert_eq!(config, bytes("08011009220b28ffffffffffffffffff01"));
        assert_eq!(pack(&config), bytes("1608011009220b28ffffffffffffffffff01ae7f274300"));
    }

    #[test]
    fn what_comes_in_is_understood() {
        let of = |wire: &str| {
            let wire = bytes(wire);
            unpack(&wire[..wire.len() - 1]).unwrap()
        };
        let ack = of("0b0801120208083e43675f00");
        assert_eq!(FromKnob::decode(&ack, Dialect::Original), Ok(FromKnob::Ack(8)));
        let state = of(
            "080801222b080315010d80be1a20280a35c2b8323e3d0104803f450118803f4dcdcc8c3f5208706163696e69616e20020a24328000",
        );
        let wanted = State { position: 3, sub_position: -0.25, config: ten(), press_nonce: 2 };
        assert!((wanted.angle().unwrap() - 27.5_f64.to_radians()).abs() < 1e-7);
        assert_eq!(FromKnob::decode(&state, Dialect::Original), Ok(FromKnob::State(Box::new(wanted))));
    }

    #[test]
    fn the_dialect_shows_in_the_number_that_comes_back() {
        assert_eq!(dialect(&bytes("080112020808"), 8), Some(Dialect::Original));
        assert_eq!(dialect(&bytes("080122020808"), 8), Some(Dialect::SeedLabs));
        assert_eq!(dialect(&bytes("080122020808"), 9), None);
        // The original's state in position 8, with a configuration beside it.
        assert_eq!(dialect(&bytes("0801220408081a00"), 8), None);
        assert_eq!(FromKnob::decode(&bytes("080212020808"), Dialect::Original), Ok(FromKnob::Version(2)));
        assert_eq!(
            FromKnob::decode(&bytes("08012a040a026f6b"), Dialect::SeedLabs),
            Ok(FromKnob::Log("ok".into()))
        );
    }
}
