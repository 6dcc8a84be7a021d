//! What may be ordered of a motor, and when.

use super::setup::Shaping;
use std::collections::VecDeque;

/// The most drives of which a click is made.
pub const PIECES: usize = 3;

/// A click: drives one after the other, from rest to rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pieces {
    /// Seconds of each, and volts or amperes.
    pub list: [(f64, f64); PIECES],
}

/// What a drive that is switched on is held at, whatever the amplifier imposes: it is worked out from the speed of the motor's model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum By {
    /// What the amplifier imposes.
    #[default]
    Amplifier,
    /// A voltage: as the motor becomes faster, less flows.
    Voltage,
    /// A current: the same torque at every speed, as long as there are volts for it.
    Current,
}

impl By {
    /// All.
    pub const ALL: [Self; 3] = [Self::Amplifier, Self::Voltage, Self::Current];
}

/// What is done with a motor that is switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum After {
    /// Nothing is sent: a short circuit of a voltage, open terminals of a current.
    #[default]
    Nothing,
    /// A short circuit, which brakes with the mechanical time constant.
    Short,
    /// Open terminals: friction alone stops it.
    Open,
}

impl After {
    /// All.
    pub const ALL: [Self; 3] = [Self::Nothing, Self::Short, Self::Open];
}

/// A drive that is switched on, and what follows it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Switch {
    /// Volts or amperes, as the amplifier imposes; held by the other one, what that amounts to at rest: volts on the resistance, amperes through it.
    pub amount: f64,
    /// What is held.
    pub by: By,
    /// What follows.
    pub after: After,
}

impl From<f64> for Switch {
    fn from(amount: f64) -> Self {
        Self { amount, ..Self::default() }
    }
}

/// What is ordered. The newest holds; what is under way is braked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// A click, from rest.
    Click(Pieces),
    /// A click of so many turns, from rest: where it is known where the mass hangs, it is ended by the motor's model, gravity included; where it is not,
    /// it is these pieces.
    Turn(Pieces, f64),
    /// To where gravity catches the mass, rad from straight down.
    Home(Pieces, f64),
    /// Home, of a motor that cannot be brought there: nothing, and counted.
    Homeless,
    /// To a speed (rad/s), as fast as may be, until the voice is released.
    Spin(f64),
    /// A speed (rad/s), as levels are shaped, until the voice is released: then to rest as fast as may be, or of [`Shaping::Plain`] by what nothing does.
    Keep(f64, Shaping),
    /// An envelope that is known as a whole, by its number, at the root of a level (-1 to 1), shaped as levels are; to its end, whatever is released.
    Swell(u32, f64, Shaping),
    /// A drive until the voice is released; then what follows that.
    On(Switch),
    /// The voice is released.
    Release,
    /// To rest, as fast as may be, whatever was ordered.
    Brake,
}

impl Order {
    /// Whether it is for the way that diodes do not let.
    pub fn is_backward(self) -> bool {
        match self {
            Self::Click(pieces) | Self::Turn(pieces, _) | Self::Home(pieces, _) => {
                pieces.list.iter().any(|(seconds, drive)| *seconds > 0.0 && *drive < 0.0)
            }
            Self::Spin(x) | Self::Keep(x, _) | Self::Swell(_, x, _) | Self::On(Switch { amount: x, .. }) => {
                x < 0.0
            }
            Self::Homeless | Self::Release | Self::Brake => false,
        }
    }

    /// Whether it holds until its voice is released.
    pub fn holds(self) -> bool {
        matches!(self, Self::Spin(_) | Self::Keep(..) | Self::On(_))
    }

    /// The same within a speed and a drive, and with times of 0 s to 10 s; what is no number is 0.
    pub fn sane(self, speed: f64, drive: f64) -> Self {
        let within = |x: f64, most: f64| if x.is_nan() { 0.0 } else { x.clamp(-most, most) };
        let click = |pieces: Pieces| Pieces {
            list: pieces.list.map(|(s, x)| (within(s, 10.0).max(0.0), within(x, drive))),
        };
        match self {
            Self::Click(pieces) => Self::Click(click(pieces)),
            Self::Turn(pieces, turns) => Self::Turn(click(pieces), within(turns, 1000.0)),
            Self::Home(pieces, angle) => Self::Home(click(pieces), within(angle, std::f64::consts::PI)),
            Self::Spin(to) => Self::Spin(within(to, speed)),
            Self::Keep(to, shaping) => Self::Keep(within(to, speed), shaping),
            Self::Swell(track, root, shaping) => Self::Swell(track, within(root, 1.0), shaping),
            Self::On(switch) => Self::On(Switch { amount: within(switch.amount, drive), ..switch }),
            Self::Homeless | Self::Release | Self::Brake => self,
        }
    }
}

/// An order at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// In samples.
    pub at: f64,
    /// Whose it is.
    pub voice: u64,
    /// What is ordered.
    pub order: Order,
}

/// Orders for later samples than the one in which they come that may wait.
pub const WAITING: usize = 64;

/// Orders for one sample that may wait.
pub const AT_ONCE: usize = 16;

/// Samples that a caller computes at a time, at most; orders of all of them come before the first is computed.
pub const TOGETHER: usize = 64;

/// Orders for which there is room: more than callers that keep to [`TOGETHER`] can have waiting, so that room never decides.
const MOST: usize = WAITING + (TOGETHER + 2) * AT_ONCE;

/// Orders to come, in order of time; among equals the first that came.
#[derive(Debug)]
pub struct Agenda {
    list: VecDeque<Entry>,
    dropped: u64,
}

impl Default for Agenda {
    fn default() -> Self {
        Self { list: VecDeque::with_capacity(MOST), dropped: 0 }
    }
}

impl Clone for Agenda {
    fn clone(&self) -> Self {
        let mut agenda = Self { dropped: self.dropped, ..Self::default() };
        agenda.list.extend(&self.list);
        agenda
    }
}

impl Agenda {
    /// Takes an order that comes in the sample `now`. Where too many wait, it is counted and left out. A brake and a release always find room, or a motor
    /// might run on for ever: in place of the last order that begins something, or, with none, the last of all becomes a brake.
    ///
    /// Who has waited long enough to be carried out before `now` does not count, whether that has been done or the caller computes several samples at a
    /// time: what is left out is the same in blocks of any length.
    pub fn push(&mut self, entry: Entry, now: f64) {
        let before = |end: f64| self.list.partition_point(|other| other.at < end);
        let (later, sample) = (before(now.floor() + 1.0), entry.at.floor());
        let own = before(sample)..before(sample + 1.0);
        let crowd = match self.list.len() {
            waiting if waiting - later >= WAITING => Some(later..waiting),
            MOST.. => Some(0..self.list.len()),
            _ => Some(own).filter(|own| own.len() >= AT_ONCE),
        };
        if let Some(crowd) = crowd {
            self.dropped += 1;
            let ends = |entry: &Entry| matches!(entry.order, Order::Brake | Order::Release);
            if !ends(&entry) {
                return;
            }
            let last = crowd.end - 1;
            let Some(begins) = crowd.rev().find(|n| !ends(&self.list[*n])) else {
                self.list[last].order = Order::Brake;
                return;
            };
            self.list.remove(begins);
        }
        let at = self.list.partition_point(|other| other.at <= entry.at);
        self.list.insert(at, entry);
    }

    /// The next order before `end` (in samples), if there is one.
    pub fn pop_before(&mut self, end: f64) -> Option<Entry> {
        self.list.front().filter(|first| first.at < end)?;
        self.list.pop_front()
    }

    /// The next order.
    pub fn first(&self) -> Option<&Entry> {
        self.list.front()
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Orders that found no room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Forgets the envelopes that wait, as what their numbers name is something else from now on.
    pub fn clear_swells(&mut self) {
        let before = self.list.len();
        self.list.retain(|entry| !matches!(entry.order, Order::Swell(..)));
        self.dropped += (before - self.list.len()) as u64;
    }

    /// Forgets all that waits for an instant (samples) or what comes after it.
    pub fn clear_from(&mut self, at: f64) {
        self.list.truncate(self.list.partition_point(|entry| entry.at < at));
    }
}
