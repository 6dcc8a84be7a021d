//! Messages into gestures.

use super::channel::Channel;
use super::claims::Claims;
use super::desk::Desk;
use super::gesture::{Gesture, Reason, Transport, What};
use super::message::Message;
use super::parameter::{self, Change, Entry};
use super::sounding::{Note, Sounding};
use super::strip::{MODES, Moved, Range, SOSTENUTO, SUSTAIN, TIMBRE};
use super::zone::{Channels, Zone};

/// The velocity of a key that goes up where nothing says it: 64, as the MIDI 1.0 Detailed Specification has it for a note-on of velocity 0.
const RELEASE: f64 = 64.0 / 127.0;

const ALL_SOUND_OFF: u8 = 120;
/// Reset All Controllers.
pub(crate) const RESET_CONTROLLERS: u8 = 121;
const LOCAL: u8 = 122;

const RANGE: u16 = 0;
const ZONE: u16 = 6;

/// Where gestures go.
type Sink<'a> = &'a mut dyn FnMut(Gesture);

/// What could not be used. Nothing is dropped without being counted here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Note-offs and key pressures of notes that did not sound.
    pub unmatched: u64,
    /// Notes that ended since there were too many; see [`super::sounding::MOST`].
    pub stolen: u64,
    /// Values for numbered parameters of which none, or half a number, was chosen, and steps from a value that is not known.
    pub unmeant: u64,
    /// Messages that concern no player: local control (122), zones on channels that cannot manage one or with too many members.
    pub left_out: u64,
}

/// Understands the messages of one cable.
///
/// It is a state machine: the same messages give the same gestures, whenever they come. After [`Interpreter::new`] nothing is allocated. Whether
/// the cable is still there is [`super::sensing`]'s to say; [`Interpreter::let_go`] is for when it is not.
///
/// - **Notes.** Each note-on is a sounding of its own, named by a key, also where the note sounds already on its channel. A note-off
///   ends the oldest sounding of its note whose key is still down: two sequences that overlap on one note then each get the length
///   they asked for, and every note-on is ended by exactly one note-off, as the specification asks of senders. A note-on of velocity 0 is
///   a note-off of velocity 64.
/// - **Pedals.** While the sustain pedal (64) is down, a note-off is kept until it goes up; the sostenuto pedal (66) does so for notes
///   whose keys were down when it went down. Pedals are down from 64 on.
/// - **Expression.** The wheel bends by 2 semitones unless RPN 0 says otherwise. Pressure is the harder of that of the channel and that of the
///   note's own key, timbre is controller 74. All of them count for notes that begin later, the pressure of a key for the sounding
///   notes whose key is down. Only what changes is said.
/// - **MPE.** RPN 6 on channel 1 or 16, or [`Interpreter::set_zone`], makes a zone. Notes end on all channels that it concerns, and
///   the bend range is ±48 semitones for members, ±2 for the manager. The manager's bend adds to that of each member, its pressure counts
///   where it is harder, its timbre adds as far as it is from the middle. Its pedals, its panic and its resets are the whole zone's. RPN 0
///   on a member is for all members of its zone. On members controller 74 is timbre alone, elsewhere an ordinary controller too.
/// - **Controllers** are at their upper 7 bits at once and at 14 bits when the lower ones follow; numbered parameters too. Those that
///   somebody listens to by their numbers ([`Interpreter::claim`]) say where they stand, and mean nothing else.
/// - **Panic.** Controllers 120 and 123 silence a channel, a reset all of them, at once, pedals or not; 124 to 127, which
///   choose modes that do not exist here, imply 123. The MIDI 1.0 Detailed Specification lets notes of 123 die away, and a pedal keep
///   them ("Channel Mode Messages", "Hold 1"); but it is what panic buttons send, and what is felt must stop when somebody presses one.
#[derive(Debug)]
pub struct Interpreter {
    desk: Desk,
    sounding: Sounding,
    counts: Counts,
    /// Whether pedals have become other controllers, or the other way round.
    claimed: bool,
}

impl Default for Interpreter {
    fn default() -> Self {
        Self::new()
    }
}

impl Interpreter {
    /// As after switching on: nothing sounds, no zones.
    pub fn new() -> Self {
        Self { desk: Desk::default(), sounding: Sounding::new(), counts: Counts::default(), claimed: false }
    }

    /// Controllers that somebody listens to by their numbers, from now on. Notes that a pedal among them held end with what comes next.
    pub fn claim(&mut self, claims: &Claims) {
        self.desk.claim(claims);
        self.claimed = true;
    }

    /// Takes a message.
    pub fn message(&mut self, message: Message, sink: Sink<'_>) {
        self.settle(sink);
        match message {
            Message::NoteOn { channel, note, velocity } => match velocity & 127 {
                0 => self.note_off(channel, note & 127, RELEASE, sink),
                velocity => self.note_on(channel, note & 127, seven(velocity), sink),
            },
            Message::NoteOff { channel, note, velocity } => {
                self.note_off(channel, note & 127, seven(velocity), sink);
            }
            Message::PolyPressure { channel, note, pressure } => {
                self.poly_pressure(channel, note & 127, pressure & 127, sink);
            }
            Message::ChannelPressure { channel, pressure } => {
                self.desk.strip_mut(channel).pressure = pressure & 127;
                self.refresh(self.desk.zones.scope(channel), sink);
            }
            Message::Bend { channel, bend } => {
                self.desk.strip_mut(channel).bend = bend.clamp(-8192, 8191);
                self.refresh(self.desk.zones.scope(channel), sink);
            }
            Message::Controller { channel, number, value } => {
                self.controller(channel, number & 127, value & 127, sink);
            }
            Message::Program { channel, program } => {
                let bank = self.desk.strip(channel).bank();
                sink(Gesture::Program { channel, bank, program: program & 127 });
            }
            Message::SongPosition { sixteenths } => {
                sink(Gesture::Position { beats: f64::from(sixteenths & 16_383) / 4.0 });
            }
            // Whoever follows them goes by when they come.
            Message::Clock | Message::ActiveSensing => (),
            Message::Start => sink(Gesture::Transport { what: Transport::Start }),
            Message::Continue => sink(Gesture::Transport { what: Transport::Continue }),
            Message::Stop => sink(Gesture::Transport { what: Transport::Stop }),
            Message::Reset => {
                self.desk.reset();
                at_rest(Channels::ALL, sink);
                self.panic(Reason::Reset, sink);
            }
        }
    }

    /// Ends what a pedal held that has become another controller ([`Interpreter::claim`]); the next message does so as well.
    pub fn settle(&mut self, sink: Sink<'_>) {
        if std::mem::take(&mut self.claimed) {
            self.let_up(Channels::ALL, sink);
        }
    }

    /// The port is gone, or its cable: all that sounds ends, and hands are off wheels and pedals. Zones and bend ranges stay for when it comes back.
    pub fn let_go(&mut self, sink: Sink<'_>) {
        self.desk.rest();
        self.end(Channels::ALL, sink);
        at_rest(Channels::ALL, sink);
    }

    /// Makes a zone of MPE with so many members, at most 15, as RPN 6 does; 0 ends it. For controllers that do not say it themselves.
    /// A system reset ends zones, these too: make them again after [`Reason::Reset`].
    pub fn set_zone(&mut self, zone: Zone, members: u8, sink: Sink<'_>) {
        let channels = self.desk.set_zone(zone, members);
        self.end(channels, sink);
        at_rest(channels, sink);
    }

    /// Whose hand is on a channel: of one in a zone of MPE, its manager; else its own.
    pub fn hand(&self, channel: Channel) -> Channel {
        self.desk.zones.of_member(channel).map_or(channel, Zone::manager)
    }

    /// How many notes sound, those that pedals hold among them.
    pub fn sounding(&self) -> usize {
        self.sounding.count()
    }

    /// What could not be used, since the beginning.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn note_on(&mut self, channel: Channel, note: u8, velocity: f64, sink: Sink<'_>) {
        let expression = self.desk.expression(channel, 0);
        let (key, ended) = self.sounding.begin(channel, note, expression);
        if let Some(ended) = ended {
            self.counts.stolen += 1;
            sink(off(&ended));
        }
        sink(Gesture::NoteOn { key, channel, note, velocity, expression });
    }

    fn note_off(&mut self, channel: Channel, note: u8, velocity: f64, sink: Sink<'_>) {
        match self.sounding.down(channel, note) {
            Some(sounding) => sounding.released = Some(velocity),
            None => self.counts.unmatched += 1,
        }
        self.let_up(Channels::one(channel), sink);
    }

    fn poly_pressure(&mut self, channel: Channel, note: u8, pressure: u8, sink: Sink<'_>) {
        let mut any = false;
        let down = |n: &&mut Note| (n.channel, n.note) == (channel, note) && n.released.is_none();
        for sounding in self.sounding.iter_mut().filter(down) {
            (sounding.poly_pressure, any) = (pressure, true);
        }
        self.counts.unmatched += u64::from(!any);
        self.refresh(Channels::one(channel), sink);
    }

    fn controller(&mut self, channel: Channel, number: u8, value: u8, sink: Sink<'_>) {
        if number >= MODES {
            return self.mode(channel, number, sink);
        }
        let claimed = self.desk.strip(channel).claimed;
        if parameter::concerns(number) && !claimed.takes(number) {
            match self.desk.strip_mut(channel).selection.controller(number, value) {
                Ok(entry) => entry.into_iter().for_each(|entry| self.parameter(channel, entry, sink)),
                Err(parameter::Unmeant) => self.counts.unmeant += 1,
            }
            return;
        }
        let scope = self.desk.zones.scope(channel);
        let before = self.desk.strip(channel).pedal(SOSTENUTO);
        let moved = self.desk.strip_mut(channel).controller(number, value);
        match number {
            SOSTENUTO => {
                let now = self.desk.strip(channel).pedal(SOSTENUTO);
                for note in self.sounding.iter_mut().filter(|n| scope.has(n.channel)) {
                    note.caught =
                        if now && !before { note.caught || note.released.is_none() } else { note.caught };
                    note.caught &= self.desk.pedal(note.channel, SOSTENUTO);
                }
                self.let_up(scope, sink);
            }
            SUSTAIN => self.let_up(scope, sink),
            _ => (),
        }
        let member = self.desk.zones.of_member(channel).is_some();
        if let Some(moved) = moved.filter(|_| number != TIMBRE || !member || claimed.has(TIMBRE)) {
            sink(controller(channel, moved));
        }
        if number == TIMBRE {
            self.refresh(scope, sink);
        }
    }

    fn parameter(&mut self, channel: Channel, entry: Entry, sink: Sink<'_>) {
        let Entry { registered, number, change, value } = entry;
        if registered && number == RANGE {
            let range = self.desk.strip(channel).range;
            let range = match change {
                Change::Coarse(semitones) => Range { semitones, cents: 0 },
                Change::Fine(cents) => Range { cents, ..range },
                Change::Step(by) => range.step(by),
            };
            let mut concerned = self.desk.set_range(channel, range);
            concerned = concerned.and(self.desk.zones.scope(channel));
            return self.refresh(concerned, sink);
        }
        if registered && number == ZONE {
            return match (Zone::managed_by(channel), change) {
                (Some(zone), Change::Coarse(members @ 0..=Zone::MOST)) => self.set_zone(zone, members, sink),
                (Some(_), Change::Fine(_)) => (),
                _ => self.counts.left_out += 1,
            };
        }
        let Some(long) = value else {
            self.counts.unmeant += 1;
            return;
        };
        let (value, fine) = match change {
            Change::Coarse(upper) => (seven(upper), false),
            _ => (f64::from(long) / 16_383.0, true),
        };
        sink(Gesture::Parameter { channel, registered, number, value, fine });
    }

    fn mode(&mut self, channel: Channel, number: u8, sink: Sink<'_>) {
        let scope = self.desk.zones.scope(channel);
        match number {
            LOCAL => self.counts.left_out += 1,
            RESET_CONTROLLERS => {
                for channel in scope.iter() {
                    self.desk.strip_mut(channel).reset().for_each(|moved| sink(controller(channel, moved)));
                }
                for note in self.sounding.iter_mut().filter(|n| scope.has(n.channel)) {
                    (note.poly_pressure, note.caught) = (0, false);
                }
                at_rest(scope, sink);
                self.let_up(scope, sink);
                self.refresh(scope, sink);
            }
            _ => {
                self.sounding.end(|note| scope.has(note.channel));
                let reason = if number == ALL_SOUND_OFF { Reason::AllSoundOff } else { Reason::AllNotesOff };
                scope.iter().for_each(|channel| sink(Gesture::Panic { reason, channel: Some(channel) }));
            }
        }
    }

    fn panic(&mut self, reason: Reason, sink: Sink<'_>) {
        self.sounding.end(|_| true);
        sink(Gesture::Panic { reason, channel: None });
    }

    /// Ends the notes whose keys are up and that no pedal holds.
    fn let_up(&mut self, channels: Channels, sink: Sink<'_>) {
        let desk = &self.desk;
        self.sounding.end(|note| {
            let ends = channels.has(note.channel)
                && note.released.is_some()
                && !desk.holds(note.channel, note.caught);
            if ends {
                sink(off(note));
            }
            ends
        });
    }

    /// Ends all notes of some channels.
    fn end(&mut self, channels: Channels, sink: Sink<'_>) {
        self.sounding.end(|note| {
            let ends = channels.has(note.channel);
            if ends {
                sink(off(note));
            }
            ends
        });
    }

    /// Says how the sounding notes of some channels have changed.
    fn refresh(&mut self, channels: Channels, sink: Sink<'_>) {
        for note in self.sounding.iter_mut().filter(|n| channels.has(n.channel)) {
            let now = self.desk.expression(note.channel, note.poly_pressure);
            let parts = [
                (What::Bend, note.said.bend, now.bend),
                (What::Pressure, note.said.pressure, now.pressure),
                (What::Timbre, note.said.timbre, now.timbre),
            ];
            for (what, _, value) in parts.into_iter().filter(|(_, before, now)| before != now) {
                sink(Gesture::Move { key: note.key, what, value });
            }
            note.said = now;
        }
    }
}

fn seven(value: u8) -> f64 {
    f64::from(value & 127) / 127.0
}

fn controller(channel: Channel, Moved { number, value, fine }: Moved) -> Gesture {
    Gesture::Controller { channel, number, value, fine }
}

fn at_rest(channels: Channels, sink: Sink<'_>) {
    channels.iter().for_each(|channel| sink(Gesture::Rest { channel }));
}

fn off(note: &Note) -> Gesture {
    Gesture::NoteOff { key: note.key, velocity: note.released.unwrap_or(RELEASE) }
}

#[cfg(test)]
mod tests;
