//! What comes from outside: keys, messages of MIDI and OSC set triggers off and move controls.

use super::bindings::Mind;
use super::touch::Held;
use super::{Note, Outlet, Performer, Touch, When, Whence};
use crate::midi::interpreter::{self, RESET_CONTROLLERS};
use crate::midi::{Channel, Claims, Expression, Gesture, Interpreter, Message, pitch};
use crate::node::motion::Motion;
use crate::patch::event::limits;
use crate::patch::{Bind, Mover, Place, Source, Spread, Trigger};
use crate::rig::{Output, OutputKind};
use crate::text::Problem;

/// Ports that are told apart.
pub const PORTS: usize = 64;

/// A song has hands of its own, before those of the ports.
pub(super) const SONG: usize = 0;

/// Whose hands are those of a port. All above the most are the last's.
fn seat(port: u16) -> usize {
    SONG + 1 + usize::from(port).min(PORTS - 1)
}

/// Where wheel and pressure of a channel stand, 0 to 1 each, as bindings know it.
type Wheels = [(Mover, f64); 2];

/// Where they stand when nobody touches them.
const REST: Wheels = [(Mover::Bend, 0.5), (Mover::Pressure, 0.0)];

/// One port of MIDI: what its messages mean, and which voices its keys hold.
pub(super) struct Hands {
    interpreter: Interpreter,
    pub(super) held: Vec<Held>,
    /// Patterns without end that keys hold: the key, its channel, and the pattern's serial number.
    holds: Vec<(u32, Channel, u64)>,
    /// Channels through which something was started that may sound: a bit each.
    loud: u16,
    /// Where each controller of each channel stood, for triggers that it passes.
    stood: Box<[[f64; 120]; 16]>,
    /// Those of each channel that may have been moved unseen since, a bit each.
    unseen: [u128; 16],
    wheels: [Wheels; 16],
    gestures: Vec<Gesture>,
    /// Messages that came, and values of numbered parameters, which nothing in a patch can hear.
    messages: u64,
    unheard: u64,
    /// Notes and programs that no trigger plays.
    unplayed: u64,
}

/// Messages of MIDI, and what of them could not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MidiCounts {
    /// All that came.
    pub messages: u64,
    /// Note-offs and key pressures of notes that did not sound.
    pub unmatched: u64,
    /// Notes that ended since there were too many; see [`crate::midi::sounding::MOST`].
    pub stolen: u64,
    /// Notes and programs that no trigger of the patch plays; none where it hears no messages but a clock's.
    pub unplayed: u64,
    /// Values for numbered parameters of which none was chosen.
    pub unmeant: u64,
    /// Values of numbered parameters (NRPN, RPN), which nothing in a patch can hear, but for the bend range and zones of MPE.
    pub unheard: u64,
    /// Messages that concern no player: local control, zones that cannot be.
    pub left_out: u64,
}

/// What sets triggers off.
#[derive(Clone, Copy, Default)]
pub(super) struct Hit {
    /// The level where nothing else is said.
    velocity: Option<f64>,
    /// The port and channel through which it came.
    port: Option<(usize, Channel)>,
    /// The key that goes down, and how it is bent and pressed.
    key: Option<(u32, Expression)>,
    /// Its note.
    note: Option<u8>,
}

/// What a voice that follows the wheel by itself gets for `pitch`: that of the key, since the bend would count twice. No patch can name it so.
const UNBENT: &str = "pitch without its bend";

impl Hands {
    fn new(claims: &Claims) -> Self {
        let mut interpreter = Interpreter::new();
        interpreter.claim(claims);
        Self {
            interpreter,
            held: Vec::new(),
            holds: Vec::new(),
            loud: 0,
            stood: Box::new([[0.0; 120]; 16]),
            unseen: [0; 16],
            wheels: [REST; 16],
            gestures: Vec::new(),
            messages: 0,
            unheard: 0,
            unplayed: 0,
        }
    }

    /// Whose hand is on a channel.
    pub fn hand(&self, channel: Channel) -> Channel {
        self.interpreter.hand(channel)
    }

    /// Another patch listens, to other controllers.
    pub fn claim(&mut self, claims: &Claims) {
        self.interpreter.claim(claims);
    }
}

/// What a trigger may read.
type Known<'a> = &'a dyn Fn(&str) -> Option<f64>;

impl Performer {
    /// A message of MIDI came through a port.
    ///
    /// # Errors
    /// The first of what it would play and cannot; the rest is played.
    pub fn midi(
        &mut self,
        at: When,
        port: u16,
        message: Message,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        self.midi_of(at, seat(port), message, outlet)
    }

    /// A message came from those hands.
    pub(super) fn midi_of(
        &mut self,
        at: When,
        port: usize,
        message: Message,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        self.meet_hands(port);
        // Bindings go by the wheel and the pressure themselves, whether a note sounds or not.
        let moved = match message {
            Message::Bend { channel, bend } => Some((Mover::Bend, channel, wheel(bend))),
            Message::ChannelPressure { channel, pressure }
            | Message::PolyPressure { channel, pressure, .. } => {
                Some((Mover::Pressure, channel, f64::from(pressure) / 127.0))
            }
            _ => None,
        };
        let result = moved.map_or(Ok(()), |(mover, channel, position)| {
            let wheels = self.hands[port].wheels[channel.index()].iter_mut();
            wheels.filter(|(of, _)| *of == mover).for_each(|(_, stands)| *stands = position);
            let says = |bind: &Bind| (bind.from == mover).then_some(position);
            self.move_by((at, at), &says, Some((port, channel)), outlet)
        });
        self.count(at, port, message, outlet);
        let mind = self.mind;
        let resets =
            matches!(message, Message::Reset | Message::Controller { number: RESET_CONTROLLERS, .. });
        if mind == Mind::Hand && resets {
            self.mind = Mind::Rest;
        }
        let heard = self.hear(port, at, outlet, |interpreter, sink| interpreter.message(message, sink));
        self.mind = mind;
        self.hands[port].messages += 1;
        if message == Message::Reset {
            self.hands[port].unseen = [u128::MAX; 16];
        }
        result.and(heard)
    }

    /// Wheel and pressure of a channel go to rest, and what they moved goes with them.
    fn rest(
        &mut self,
        at: When,
        port: usize,
        channel: Channel,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        let before = std::mem::replace(&mut self.hands[port].wheels[channel.index()], REST);
        let mind = self.mind;
        if mind == Mind::Hand {
            self.mind = Mind::Rest;
        }
        let mut result = Ok(());
        for ((mover, position), _) in REST.iter().zip(before).filter(|((_, rest), (_, stood))| rest != stood)
        {
            let says = |bind: &Bind| (bind.from == *mover).then_some(*position);
            result = result.and(self.move_by((at, at), &says, Some((port, channel)), outlet));
        }
        self.mind = mind;
        result
    }

    /// Counts a note or program that no trigger plays, but of a song of whose clock alone the patch makes something.
    fn count_unplayed(&mut self, port: usize, fits: &dyn Fn(&Trigger) -> bool) {
        let (triggers, patterns) = (&self.patch.triggers, &self.patch.patterns);
        let is_midi = |trigger: &Trigger| {
            matches!(trigger.on, Source::MidiNote | Source::MidiProgram(_) | Source::MidiController { .. })
        };
        let is_meant = triggers.iter().any(is_midi) || !patterns.iter().any(|pattern| pattern.follows);
        self.hands[port].unplayed += u64::from(is_meant && !triggers.iter().any(fits));
    }

    /// What of the messages of all ports could not be used.
    pub fn midi_counts(&self) -> MidiCounts {
        self.hands.iter().fold(MidiCounts::default(), |sum, hands| {
            let interpreter::Counts { unmatched, stolen, unmeant, left_out } = hands.interpreter.counts();
            MidiCounts {
                messages: sum.messages + hands.messages,
                unmatched: sum.unmatched + unmatched,
                stolen: sum.stolen + stolen,
                unplayed: sum.unplayed + hands.unplayed,
                unmeant: sum.unmeant + unmeant,
                unheard: sum.unheard + hands.unheard,
                left_out: sum.left_out + left_out,
            }
        })
    }

    /// Ends what pedals held that another patch has made something else.
    ///
    /// # Errors
    /// As [`Performer::midi`].
    pub fn midi_settle(&mut self, at: When, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        let mut result = Ok(());
        for port in 0..self.hands.len() {
            result = result.and(self.hear(port, at, outlet, Interpreter::settle));
        }
        result
    }

    /// A port is gone, or its cable: what it holds is released.
    ///
    /// # Errors
    /// As [`Performer::midi`].
    pub fn midi_gone(&mut self, at: When, port: u16, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        self.gone(at, seat(port), outlet)
    }

    /// Those hands are gone.
    pub(super) fn gone(&mut self, at: When, port: usize, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        self.meet_hands(port);
        self.count_no_more(at, port, outlet);
        let result = self.hear(port, at, outlet, |interpreter, sink| interpreter.let_go(sink));
        self.hands[port].unseen = [u128::MAX; 16];
        // A wheel springs back; a fader may be moved meanwhile.
        let faders = self.patch.binds.iter().zip(&mut self.pickups);
        faders
            .filter(|(bind, _)| matches!(bind.from, Mover::Controller(_)))
            .for_each(|(_, all)| all.forget(port));
        result
    }

    /// There is somebody of that number from now on.
    fn meet_hands(&mut self, port: usize) {
        while self.hands.len() <= port {
            self.hands.push(Hands::new(&self.patch.controllers()));
        }
    }

    fn hear(
        &mut self,
        port: usize,
        at: When,
        outlet: &mut dyn Outlet,
        say: impl FnOnce(&mut Interpreter, &mut dyn FnMut(Gesture)),
    ) -> Result<(), Problem> {
        self.tell_moves(at, port, outlet);
        let hands = &mut self.hands[port];
        let mut gestures = std::mem::take(&mut hands.gestures);
        say(&mut hands.interpreter, &mut |gesture| gestures.push(gesture));
        let mut result = Ok(());
        for gesture in gestures.drain(..) {
            result = result.and(self.gesture(at, port, gesture, outlet));
        }
        self.hands[port].gestures = gestures;
        self.tell_moves(at, port, outlet);
        result
    }

    fn gesture(
        &mut self,
        at: When,
        port: usize,
        gesture: Gesture,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        match gesture {
            Gesture::NoteOn { key, channel, note, velocity, expression } => {
                let known = |name: &str| match name {
                    "note" => Some(f64::from(note)),
                    "velocity" => Some(velocity),
                    "pitch" => Some(pitch::hertz(note, expression.bend)),
                    UNBENT => Some(pitch::hertz(note, 0.0)),
                    "channel" => Some(f64::from(channel.number())),
                    "bend" => Some(expression.bend),
                    "pressure" => Some(expression.pressure),
                    "timbre" => Some(expression.timbre),
                    _ => None,
                };
                let fits = |t: &Trigger| {
                    t.on == Source::MidiNote
                        && on_channel(t.channel, channel)
                        && t.notes.is_none_or(|[least, most]| (least..=most).contains(&note))
                };
                let hit = Hit {
                    velocity: Some(velocity),
                    port: Some((port, channel)),
                    key: Some((key, expression)),
                    note: Some(note),
                };
                self.count_unplayed(port, &fits);
                self.set_off(at, &fits, &known, hit, outlet)
            }
            Gesture::NoteOff { key, .. } => {
                let mut held = std::mem::take(&mut self.hands[port].held);
                held.retain_mut(|voice| {
                    if voice.key == key {
                        self.tell_voice(at, voice, true, outlet);
                        if voice.holds {
                            self.release(at, voice.voice, outlet);
                        }
                    }
                    voice.key != key
                });
                self.hands[port].held = held;
                while let Some(place) = self.hands[port].holds.iter().position(|(of, ..)| *of == key) {
                    let (_, _, serial) = self.hands[port].holds.swap_remove(place);
                    self.stop_pattern(at, serial, outlet);
                }
                Ok(())
            }
            Gesture::Move { key, what, value } => {
                let held = &mut self.hands[port].held;
                held.iter_mut().filter(|voice| voice.key == key).for_each(|voice| {
                    voice.moved(Touch::of(what, value));
                });
                Ok(())
            }
            Gesture::Controller { channel, number, value, .. } => {
                let says = |bind: &Bind| (bind.from == Mover::Controller(number)).then_some(value);
                let result = self.move_by((at, at), &says, Some((port, channel)), outlet);
                let Some(stood) = self.hands[port].stood[channel.index()].get_mut(usize::from(number)) else {
                    return result;
                };
                let before = std::mem::replace(stood, value);
                let bit = 1 << number;
                let unseen = self.hands[port].unseen[channel.index()] & bit != 0;
                self.hands[port].unseen[channel.index()] &= !bit;
                let passes = |t: &Trigger| match t.on {
                    Source::MidiController { number: n, rises, threshold } => {
                        // A switch that goes to its end has passed it; a fader is where it has been moved to.
                        let up = if unseen { value == 1.0 } else { before < threshold && value >= threshold };
                        let down =
                            if unseen { value == 0.0 } else { before > threshold && value <= threshold };
                        n == number && on_channel(t.channel, channel) && if rises { up } else { down }
                    }
                    _ => false,
                };
                let known = |name: &str| match name {
                    "value" => Some(value),
                    "channel" => Some(f64::from(channel.number())),
                    _ => None,
                };
                let hit = Hit { port: Some((port, channel)), ..Hit::default() };
                result.and(self.set_off(at, &passes, &known, hit, outlet))
            }
            Gesture::Program { channel, program, .. } => {
                let fits =
                    |t: &Trigger| t.on == Source::MidiProgram(program) && on_channel(t.channel, channel);
                let known = |name: &str| match name {
                    "program" => Some(f64::from(program)),
                    "channel" => Some(f64::from(channel.number())),
                    _ => None,
                };
                let hit = Hit { port: Some((port, channel)), ..Hit::default() };
                self.count_unplayed(port, &fits);
                self.set_off(at, &fits, &known, hit, outlet)
            }
            Gesture::Rest { channel } => self.rest(at, port, channel, outlet),
            Gesture::Panic { channel, .. } => {
                self.quiet(at, port, channel, outlet);
                Ok(())
            }
            Gesture::Parameter { .. } => {
                self.hands[port].unheard += 1;
                Ok(())
            }
            // The clock counts by itself.
            Gesture::Transport { .. } | Gesture::Position { .. } => Ok(()),
        }
    }

    /// Voices that keys of MIDI hold.
    pub fn held(&self) -> usize {
        self.hands.iter().map(|hands| hands.held.len()).sum()
    }

    /// A key of the computer went down, from 1.
    ///
    /// # Errors
    /// The first of what it would play and cannot; the rest is played.
    pub fn key(&mut self, at: When, key: u32, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        self.set_off(at, &|t| t.on == Source::Key(key), &|_| None, Hit::default(), outlet)
    }

    /// All that a port has started, or one of its channels, falls silent at once, and nothing else.
    fn quiet(&mut self, at: When, port: usize, channel: Option<Channel>, outlet: &mut dyn Outlet) {
        let hands = &mut self.hands[port];
        hands.held.retain(|held| channel.is_some_and(|channel| held.channel != channel));
        hands.holds.retain(|(_, of, _)| channel.is_some_and(|channel| *of != channel));
        let quiet = channel.map_or(u16::MAX, |channel| 1 << channel.index());
        // What a clock has started is its port's, and of no channel.
        let clock = channel.is_none() && self.clock_is_of(port);
        if self.hands[port].loud & quiet == 0 && !clock {
            return;
        }
        self.silence(at, port, channel, outlet);
        self.hands[port].loud &= !quiet;
        if clock {
            self.count_no_more(at, port, outlet);
        }
    }

    /// A message of OSC came to an address, with its values. Says whether something listens to that.
    ///
    /// # Errors
    /// The first of what it would play and cannot; the rest is played.
    pub fn osc(
        &mut self,
        at: When,
        address: &str,
        values: &[f64],
        outlet: &mut dyn Outlet,
    ) -> Result<bool, Problem> {
        self.osc_by((at, at), address, values, outlet)
    }

    /// The same of one of `at`, which came so late that nothing before `now` can be changed any more: a stream still reaches its value in time.
    ///
    /// # Errors
    /// As [`Performer::osc`].
    pub fn osc_by(
        &mut self,
        (at, now): (When, When),
        address: &str,
        values: &[f64],
        outlet: &mut dyn Outlet,
    ) -> Result<bool, Problem> {
        let says = |bind: &Bind| match &bind.from {
            Mover::Osc { address: a, argument } if a == address => {
                Some(bind.position_of(*values.get(argument.checked_sub(1)?)?))
            }
            _ => None,
        };
        let of_binding = |bind: &Bind| matches!(&bind.from, Mover::Osc { address: a, .. } if a == address);
        let of_it = |t: &Trigger| matches!(&t.on, Source::Osc(a) if a == address);
        let listens = self.patch.binds.iter().any(of_binding) || self.patch.triggers.iter().any(of_it);
        // What is said beside numbers takes their places, and is none.
        let value = values.iter().copied().find(|value| !value.is_nan()).or(values.first().copied());
        // Surfaces send that when a button is let go.
        let fits = |t: &Trigger| of_it(t) && (value != Some(0.0) || t.reads("value"));
        let known = |name: &str| if name == "value" { value.or(Some(1.0)) } else { None };
        self.move_by((at, now), &says, None, outlet)?;
        self.set_off(at, &fits, &known, Hit::default(), outlet).map(|()| listens)
    }

    /// Plays what the triggers that fit play.
    fn set_off(
        &mut self,
        at: When,
        fits: &dyn Fn(&Trigger) -> bool,
        known: Known<'_>,
        hit: Hit,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        let patch = std::sync::Arc::clone(&self.patch);
        let mut result = Ok(());
        let whence = hit.port.map_or(Whence::HERE, |(port, channel)| Whence::midi(port, Some(channel)));
        for trigger in patch.triggers.iter().filter(|t| fits(t)) {
            if let Some((port, channel)) = hit.port {
                self.hands[port].loud |= 1 << channel.index();
            }
            let mut note =
                Note { place: self.spread(trigger, hit).or(trigger.place.clone()), ..Note::default() };
            note.level = hit.velocity;
            let (mut gain, mut rate) = (hit.velocity.unwrap_or(1.0), 1.0);
            let instrument = self.voices.get(&trigger.play).and_then(|voice| self.instruments[*voice]);
            let hears = instrument.and_then(|i| self.hears.get(i as usize)).copied().unwrap_or_default();
            let follows = hears[Motion::Detune.number()];
            let known = |name: &str| known(if follows && name == "pitch" { UNBENT } else { name });
            for (field, expr, _) in &trigger.set {
                let Some(value) = expr.value(&known) else { continue };
                match field.as_str() {
                    "level" => note.level = Some(value),
                    "felt" => note.felt = Some(value),
                    "duration" => note.duration = Some(value),
                    "gain" => gain = value,
                    "rate" => rate = value,
                    _ => note.fields.push((field.clone(), value)),
                }
            }
            let told = |problem: Problem| Problem { span: Some(trigger.span.clone()), ..problem };
            if !self.voices.contains_key(&trigger.play) {
                let scale = (gain.clamp(0.0, 100.0), rate.clamp(0.001, 1000.0));
                let started = self.start_by(at, &trigger.play, scale, (whence, hit), outlet);
                result = result.and(started.map_err(told));
                continue;
            }
            // A key holds what has no duration of its own.
            let holds = hit.key.is_some() && note.duration.is_none();
            if holds {
                note.duration = Some(f64::INFINITY);
            }
            // Whatever an expression makes of it: what the engine does with a voice must stay within what a file could ask for.
            // What it is to be felt like goes before the velocity of a key.
            let says = |wanted: &str| trigger.set.iter().any(|(field, ..)| field == wanted);
            let by_default =
                || self.voices.get(&trigger.play).is_some_and(|v| patch.voices[*v].felt.is_some());
            if !says("level") && (note.felt.is_some() || by_default()) {
                note.level = None;
            }
            if let Some((field, value)) = [("felt", note.felt), ("level", note.level)]
                .into_iter()
                .find_map(|(field, value)| Some((field, value.filter(|value| !value.is_finite())?)))
            {
                let what = format!(
                    "`{field}` of a trigger of `{}` comes to {value}: nothing is played",
                    trigger.play
                );
                let help = "hold what divides in its expression above 0".to_string();
                result = result.and(Err(told(Problem::of_file(what).help(help))));
                continue;
            }
            let within = |field: &str, value: f64| {
                let [least, most] = limits(field);
                if value.is_nan() { 0.0 } else { value.clamp(least, most) }
            };
            note.felt = note.felt.map(|felt| within("felt", felt));
            note.level = note.level.map(|level| within("level", level));
            // One without end is held.
            note.duration = note.duration.map(|s| if s == f64::INFINITY { s } else { within("duration", s) });
            for (name, value) in &mut note.fields {
                *value = if value.is_finite() { within(name, *value) } else { 0.0 };
            }
            match self.play_by(at, &trigger.play, &note, whence, outlet) {
                Ok(voice) => {
                    if let (Some((port, channel)), Some((key, expression)), Some(instrument)) =
                        (hit.port, hit.key, instrument)
                    {
                        let key = (key, channel);
                        let mut voice = Held::new(key, voice, holds, instrument, hears, expression);
                        // At the instant of its onset, so that it begins there.
                        self.tell_voice(at, &mut voice, true, outlet);
                        self.hands[port].held.push(voice);
                    }
                }
                Err(problem) => result = result.and(Err(told(problem))),
            }
        }
        result
    }

    /// Starts a pattern for a trigger. One without end plays as long as the key is held that started it; one that no key holds begins
    /// anew with every hit, since two of it would never end.
    pub(super) fn start_by(
        &mut self,
        at: When,
        pattern: &str,
        (gain, rate): (f64, f64),
        (whence, hit): (Whence, Hit),
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        let endless = self.is_endless(pattern);
        let held = hit.port.zip(hit.key).filter(|_| endless);
        if endless
            && held.is_none()
            && let Some(before) = self.endless.remove(pattern)
        {
            self.stop_pattern(at, before, outlet);
        }
        let serial = self.start_scaled(at, pattern, gain, rate, whence)?;
        match held {
            Some(((port, channel), (key, _))) => self.hands[port].holds.push((key, channel, serial)),
            None if endless => drop(self.endless.insert(pattern.into(), serial)),
            None => {}
        }
        Ok(())
    }

    /// The tactor that a trigger spreads a note to.
    fn spread(&self, trigger: &Trigger, hit: Hit) -> Option<Place> {
        // What gives pulses or torque is none that a note could be felt on.
        let felt = |output: &&Output| !matches!(output.kind, OutputKind::Trigger { .. } | OutputKind::Torque);
        let tactors = self.rig.outputs.iter().filter(felt).count();
        let (port, channel) = hit.port.filter(|_| tactors > 0)?;
        let note = hit.note.unwrap_or(0);
        let number = match trigger.spread {
            Spread::Off => return None,
            Spread::Channels => channel.index() % tactors,
            Spread::Controller(number) => {
                let stands = self.hands.get(port)?.stood[channel.index()].get(usize::from(number))?;
                ((stands * tactors as f64) as usize).min(tactors - 1)
            }
            Spread::Notes => match trigger.notes {
                Some([least, most]) => {
                    let (place, width) =
                        (usize::from(note.saturating_sub(least)), usize::from(most - least) + 1);
                    (place * tactors / width).min(tactors - 1)
                }
                None => usize::from(note) % tactors,
            },
        };
        self.rig.outputs.iter().filter(felt).nth(number).map(|output| Place::Channel(output.channel))
    }
}

/// The position of a wheel, 0 to 1: the middle is one half exactly, and both ends are reached.
fn wheel(bend: i16) -> f64 {
    let bend = f64::from(bend);
    0.5 + 0.5 * (bend / if bend < 0.0 { 8192.0 } else { 8191.0 })
}

fn on_channel(wanted: Option<u8>, channel: Channel) -> bool {
    wanted.is_none_or(|wanted| wanted == channel.number())
}

#[cfg(test)]
mod seats;
#[cfg(test)]
mod tests;
