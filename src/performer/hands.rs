//! What comes from outside: keys, messages of MIDI and OSC set triggers off and move controls.

use super::{Note, Outlet, Performer, When};
use crate::midi::{Channel, Gesture, Interpreter, Message, pitch};
use crate::patch::{Mover, Place, Source, Spread, Trigger};
use crate::text::Problem;

/// Ports that are told apart.
pub const PORTS: usize = 64;

/// One port of MIDI: what its messages mean, and which voices its keys hold.
pub(super) struct Hands {
    interpreter: Interpreter,
    held: Vec<Held>,
    /// Where each controller of each channel stood, for triggers that it passes.
    stood: Box<[[f64; 120]; 16]>,
    gestures: Vec<Gesture>,
}

/// A voice that a key holds.
#[derive(Debug, Clone, Copy)]
struct Held {
    key: u32,
    voice: u64,
}

impl Default for Hands {
    fn default() -> Self {
        Self {
            interpreter: Interpreter::new(),
            held: Vec::new(),
            stood: Box::new([[0.0; 120]; 16]),
            gestures: Vec::new(),
        }
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
            self.move_by(at, &|from| *from == mover, Some(channel), position, outlet)
        });
        result.and(
            self.hear(port, at, outlet, |interpreter, sink| interpreter.message(at.seconds, message, sink)),
        )
    }

    /// Time has passed at a port: a cable that promised to stay may be lost.
    ///
    /// # Errors
    /// As [`Performer::midi`].
    pub fn midi_tick(&mut self, at: When, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        let mut result = Ok(());
        for port in 0..self.hands.len() {
            let ticked =
                self.hear(port as u16, at, outlet, |interpreter, sink| interpreter.tick(at.seconds, sink));
            result = result.and(ticked);
        }
        result
    }

    /// A port is gone: what it holds is released.
    ///
    /// # Errors
    /// As [`Performer::midi`].
    pub fn midi_gone(&mut self, at: When, port: u16, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        self.hear(port, at, outlet, |interpreter, sink| interpreter.let_go(sink))
    }

    fn hear(
        &mut self,
        port: u16,
        at: When,
        outlet: &mut dyn Outlet,
        say: impl FnOnce(&mut Interpreter, &mut dyn FnMut(Gesture)),
    ) -> Result<(), Problem> {
        let port = usize::from(port).min(PORTS - 1);
        while self.hands.len() <= port {
            self.hands.push(Hands::default());
        }
        let hands = &mut self.hands[port];
        let mut gestures = std::mem::take(&mut hands.gestures);
        say(&mut hands.interpreter, &mut |gesture| gestures.push(gesture));
        let mut result = Ok(());
        for gesture in gestures.drain(..) {
            result = result.and(self.gesture(at, port, gesture, outlet));
        }
        self.hands[port].gestures = gestures;
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
                let held = Some((port, key));
                self.set_off(at, &fits, &known, Some(velocity), held, Some((channel, note)), outlet)
            }
            Gesture::NoteOff { key, .. } => {
                let mut sent = true;
                let mut held = std::mem::take(&mut self.hands[port].held);
                held.retain(|voice| {
                    if voice.key == key {
                        sent &= self.release(at, voice.voice, outlet);
                    }
                    voice.key != key
                });
                self.hands[port].held = held;
                self.taken(sent)
            }
            // Of a voice that sounds, nothing moves but what controls move.
            Gesture::Move { .. } => Ok(()),
            Gesture::Controller { channel, number, value, .. } => {
                let moved = |from: &Mover| *from == Mover::Controller(number);
                let result = self.move_by(at, &moved, Some(channel), value, outlet);
                let Some(stood) = self.hands[port].stood[channel.index()].get_mut(usize::from(number)) else {
                    return result;
                };
                let before = std::mem::replace(stood, value);
                let passes = |t: &Trigger| match t.on {
                    Source::MidiController { number: n, rises, threshold } => {
                        let up = before < threshold && value >= threshold;
                        let down = before > threshold && value <= threshold;
                        n == number && on_channel(t.channel, channel) && if rises { up } else { down }
                    }
                    _ => false,
                };
                let known = |name: &str| match name {
                    "value" => Some(value),
                    "channel" => Some(f64::from(channel.number())),
                    _ => None,
                };
                result.and(self.set_off(at, &passes, &known, None, None, Some((channel, 0)), outlet))
            }
            Gesture::Program { channel, program, .. } => {
                let fits =
                    |t: &Trigger| t.on == Source::MidiProgram(program) && on_channel(t.channel, channel);
                let known = |name: &str| match name {
                    "program" => Some(f64::from(program)),
                    "channel" => Some(f64::from(channel.number())),
                    _ => None,
                };
                self.set_off(at, &fits, &known, None, None, Some((channel, 0)), outlet)
            }
            Gesture::Panic { .. } => {
                self.hands.iter_mut().for_each(|hands| hands.held.clear());
                let serials: Vec<u64> = self.runs.iter().map(|run| run.serial).collect();
                for serial in serials {
                    self.stop_pattern(serial);
                }
                let sent = self.release_all(at, outlet);
                self.taken(sent)
            }
            Gesture::Parameter { .. }
            | Gesture::Transport { .. }
            | Gesture::Position { .. }
            | Gesture::Tempo { .. } => Ok(()),
        }
    }

    /// A key of the computer went down, from 1.
    ///
    /// # Errors
    /// The first of what it would play and cannot; the rest is played.
    pub fn key(&mut self, at: When, key: u32, outlet: &mut dyn Outlet) -> Result<(), Problem> {
        self.set_off(at, &|t| t.on == Source::Key(key), &|_| None, None, None, None, outlet)
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
        let moved = |from: &Mover| matches!(from, Mover::Osc(a) if a == address);
        let fits = |t: &Trigger| matches!(&t.on, Source::Osc(a) if a == address);
        let listens =
            self.patch.binds.iter().any(|bind| moved(&bind.from)) || self.patch.triggers.iter().any(fits);
        let value = values.first().copied();
        let known = |name: &str| if name == "value" { value.or(Some(1.0)) } else { None };
        if let Some(value) = value {
            self.move_by(at, &moved, None, value, outlet)?;
        }
        self.set_off(at, &fits, &known, None, None, None, outlet).map(|()| listens)
    }

    /// Plays what the triggers that fit play. `velocity` is the level where nothing else is said; `held` the port and the key that
    /// hold it.
    #[expect(clippy::too_many_arguments, reason = "what a trigger knows")]
    fn set_off(
        &mut self,
        at: When,
        fits: &dyn Fn(&Trigger) -> bool,
        known: Known<'_>,
        velocity: Option<f64>,
        held: Option<(usize, u32)>,
        note: Option<(Channel, u8)>,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        let patch = std::sync::Arc::clone(&self.patch);
        let mut result = Ok(());
        for trigger in patch.triggers.iter().filter(|t| fits(t)) {
            let mut note =
                Note { place: self.spread(trigger, note).or(trigger.place.clone()), ..Note::default() };
            note.level = velocity;
            let (mut gain, mut rate) = (velocity.unwrap_or(1.0), 1.0);
            for (field, expr, _) in &trigger.set {
                let Some(value) = expr.value(known) else { continue };
                match field.as_str() {
                    "level" => note.level = Some(value),
                    "duration" => note.duration = Some(value),
                    "gain" => gain = value,
                    "rate" => rate = value,
                    _ => note.fields.push((field.clone(), value)),
                }
            }
            let told = |problem: Problem| Problem { span: Some(trigger.span.clone()), ..problem };
            if !self.voices.contains_key(&trigger.play) {
                let started =
                    self.start_scaled(at, &trigger.play, gain.clamp(0.0, 100.0), rate.clamp(0.001, 1000.0));
                result = result.and(started.map(drop).map_err(told));
                continue;
            }
            // A key holds what has no duration of its own.
            let holds = held.filter(|_| note.duration.is_none());
            if holds.is_some() {
                note.duration = Some(f64::INFINITY);
            }
            // Whatever an expression makes of it: what the engine does with a voice must stay within what a file could ask for.
            note.level =
                note.level.map(|level| if level.is_finite() { level.clamp(0.0, 100.0) } else { 0.0 });
            note.duration =
                note.duration.map(|seconds| if seconds.is_nan() { 0.0 } else { seconds.max(0.0) });
            for (_, value) in &mut note.fields {
                *value = if value.is_finite() { value.clamp(-1e9, 1e9) } else { 0.0 };
            }
            match self.play(at, &trigger.play, &note, outlet) {
                Ok(voice) => {
                    if let Some((port, key)) = holds {
                        self.hands[port].held.push(Held { key, voice });
                    }
                }
                Err(problem) => result = result.and(Err(told(problem))),
            }
        }
        result
    }

    /// The tactor that a trigger spreads a note to.
    fn spread(&self, trigger: &Trigger, note: Option<(Channel, u8)>) -> Option<Place> {
        let tactors = self.rig.outputs.len();
        let (channel, note) = note.filter(|_| tactors > 0)?;
        let number = match trigger.spread {
            Spread::Off => return None,
            Spread::Channels => channel.index() % tactors,
            Spread::Notes => match trigger.notes {
                Some([least, most]) => {
                    let (place, width) =
                        (usize::from(note.saturating_sub(least)), usize::from(most - least) + 1);
                    (place * tactors / width).min(tactors - 1)
                }
                None => usize::from(note) % tactors,
            },
        };
        self.rig.outputs.get(number).map(|output| Place::Channel(output.channel))
    }

    /// Moves the controls of the bindings that `from` says yes to, to a position from 0 to 1.
    fn move_by(
        &mut self,
        at: When,
        from: &dyn Fn(&Mover) -> bool,
        channel: Option<Channel>,
        position: f64,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        if self.patch.binds.is_empty() || !position.is_finite() {
            return Ok(());
        }
        let patch = std::sync::Arc::clone(&self.patch);
        let mut result = Ok(());
        for (number, bind) in patch.binds.iter().enumerate() {
            let fits = from(&bind.from) && channel.is_none_or(|channel| on_channel(bind.channel, channel));
            let place =
                patch.controls.iter().position(|control| control.name == bind.control).filter(|_| fits);
            let Some((control, place)) = place.and_then(|place| Some((patch.controls.get(place)?, place)))
            else {
                continue;
            };
            let stands = self.targets.get(place).and_then(|value| bind.position(control, *value));
            let moves = self.pickups.get_mut(number).is_none_or(|pickup| pickup.moves(position, stands));
            // A control that nothing reads has no place in the engine.
            if (moves || !bind.pickup) && self.plan.control(&control.name).is_ok() {
                result = result.and(self.set(at, &control.name, bind.value(control, position), outlet));
            }
        }
        result
    }

    fn taken(&self, taken: bool) -> Result<(), Problem> {
        if taken { Ok(()) } else { Err(super::full()) }
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
mod tests {
    use std::sync::Arc;

    use super::{Message, Outlet, Performer, When, wheel};
    use crate::engine::event::{Event, Source};
    use crate::graph::scene::{Options, scene};
    use crate::midi::Channel;
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::schedule::Instant;
    use crate::text::Problem;

    /// Keeps what it is sent.
    #[derive(Default)]
    struct Kept(Vec<(Instant, Event)>);

    impl Outlet for Kept {
        fn clock(&self) -> u64 {
            1
        }
        fn room(&self, _: Source) -> usize {
            1000
        }
        fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
            self.0.push((at, event));
            true
        }
    }

    const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.depth]\ndefault = 0.5\nrange = [0, 2]\n\
        [voice.v]\noutput = \"o\"\n[voice.v.nodes]\ns = { type = \"sine\", frequency = \"event.frequency\" }\n\
        e = { type = \"envelope\" }\no = { type = \"multiply\", inputs = [\"s\", \"e\", \"depth\"] }\n\
        [pattern.p]\nevents = [{ at = 0.25, voice = \"v\", level = 0.5 }]\n";

    fn performer(rest: &str) -> (Performer, Kept) {
        let patch =
            Patch::parse("t", format!("{HEAD}{rest}").as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let rig = Rig::default_for(8);
        let options = Options { live: true, ..Options::default() };
        let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let refuse = |_: &str| Err(Problem::of_file("no files here"));
        let performer = Performer::new(scene, Arc::new(patch), Arc::new(rig), Box::new(refuse));
        (performer.unwrap_or_else(|p| panic!("{p}")), Kept::default())
    }

    fn channel(number: u8) -> Channel {
        Channel::new(number).unwrap()
    }

    fn send(performer: &mut Performer, kept: &mut Kept, seconds: f64, message: Message) {
        performer.midi(When::of_seconds(seconds, 8000.0), 0, message, kept).unwrap_or_else(|p| panic!("{p}"));
    }

    fn on(number: u8, note: u8, velocity: u8) -> Message {
        Message::NoteOn { channel: channel(number), note, velocity }
    }

    fn off(number: u8, note: u8) -> Message {
        Message::NoteOff { channel: channel(number), note, velocity: 64 }
    }

    fn controller(number: u8, value: u8) -> Message {
        Message::Controller { channel: channel(0), number, value }
    }

    #[test]
    fn a_key_holds_its_voice_and_gives_level_pitch_and_place() {
        let (mut performer, mut kept) = performer(
            "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nnotes = [\"C2\", 51]\nspread = \"notes\"\n\
             set = { frequency = \"pitch\" }\n",
        );
        send(&mut performer, &mut kept, 0.5, on(0, 36, 127));
        // Beyond the keys that it listens to.
        send(&mut performer, &mut kept, 0.6, on(0, 52, 127));
        send(&mut performer, &mut kept, 0.6, on(0, 51, 64));
        let plays: Vec<_> = kept
            .0
            .iter()
            .filter_map(|(at, e)| if let Event::Play(p) = e { Some((at, p)) } else { None })
            .collect();
        let [(first_at, first), (_, last)] = plays[..] else { panic!("{plays:?}") };
        assert_eq!(*first_at, Instant::of_samples(4000.0));
        assert_eq!((first.level, first.duration, first.place), (1.0, f64::INFINITY, 0));
        // Two octaves and nine semitones below 440 Hz.
        assert!((first.own[0] - 440.0 * f64::exp2(-33.0 / 12.0)).abs() < 1e-9);
        // Sixteen keys on eight tactors: the last two share the last.
        assert_eq!((last.level, last.place), (64.0 / 127.0, 7));
        let (first, last) = (first.id, last.id);
        send(&mut performer, &mut kept, 1.0, off(0, 51));
        assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Release(last)));
        // The pedal holds the other.
        send(&mut performer, &mut kept, 1.0, controller(64, 127));
        let sent = kept.0.len();
        send(&mut performer, &mut kept, 1.1, off(0, 36));
        assert_eq!(kept.0.len(), sent);
        send(&mut performer, &mut kept, 1.2, controller(64, 0));
        assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Release(first)));
    }

    #[test]
    fn what_is_said_goes_before_what_is_played() {
        let (mut performer, mut kept) = performer(
            "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nchannel = 10\nplace = \"t3\"\n\
             set = { level = \"velocity / 2\", duration = 0.2, frequency = \"40 + note\" }\n",
        );
        send(&mut performer, &mut kept, 0.0, on(0, 60, 100));
        assert!(kept.0.is_empty(), "channel 1 is not meant");
        send(&mut performer, &mut kept, 0.0, on(9, 60, 127));
        let Some((_, Event::Play(play))) = kept.0.first() else { panic!("{:?}", kept.0) };
        assert_eq!((play.level, play.duration, play.own[0], play.place), (0.5, 0.2, 100.0, 2));
        // It ends by itself.
        send(&mut performer, &mut kept, 0.1, off(9, 60));
        assert_eq!(kept.0.len(), 1);
    }

    #[test]
    fn controllers_move_controls_from_where_they_stand() {
        let (mut performer, mut kept) = performer(
            "[[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"depth\"\n[[bind]]\nfrom = \"midi.bend\"\ncontrol = \"depth\"\n\
             range = [1.0, 0.0]\npickup = false\n",
        );
        // The control stands at a quarter of its range.
        send(&mut performer, &mut kept, 0.0, controller(7, 127));
        assert!(kept.0.is_empty());
        send(&mut performer, &mut kept, 0.1, controller(7, 0));
        send(&mut performer, &mut kept, 0.2, controller(7, 127));
        let values: Vec<f64> = kept
            .0
            .iter()
            .map(|(_, e)| if let Event::Control(0, x) = e { *x } else { panic!("{e:?}") })
            .collect();
        assert_eq!(values, [0.0, 2.0]);
        let bend = |bend| Message::Bend { channel: channel(3), bend };
        for (to, value) in [(-8192, 1.0), (0, 0.5), (8191, 0.0)] {
            send(&mut performer, &mut kept, 0.3, bend(to));
            assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::Control(0, value)));
        }
        assert_eq!([wheel(-8192), wheel(0), wheel(8191)], [0.0, 0.5, 1.0]);
    }

    #[test]
    fn patterns_start_by_key_program_controller_and_message() {
        let (mut performer, mut kept) = performer(
            "[[trigger]]\non = \"key.1\"\nplay = \"p\"\n[[trigger]]\non = \"midi.program 3\"\nplay = \"p\"\n\
             [[trigger]]\non = \"midi.controller 80 rises 0.5\"\nplay = \"p\"\nset = { gain = \"value\", rate = 2 }\n\
             [[trigger]]\non = \"osc./go\"\nplay = \"v\"\nset = { level = \"value\" }\n",
        );
        let at = |seconds| When::of_seconds(seconds, 8000.0);
        performer.key(at(1.0), 1, &mut kept).unwrap();
        performer.key(at(1.0), 2, &mut kept).unwrap();
        send(&mut performer, &mut kept, 2.0, Message::Program { channel: channel(0), program: 3 });
        send(&mut performer, &mut kept, 3.0, controller(80, 127));
        // It has risen already.
        send(&mut performer, &mut kept, 3.1, controller(80, 126));
        assert_eq!(performer.osc(at(4.0), "/go", &[0.25], &mut kept), Ok(true));
        assert_eq!(performer.osc(at(4.0), "/gone", &[], &mut kept), Ok(false));
        performer.feed(40_000, &mut kept);
        let mut plays: Vec<(f64, f64)> = kept
            .0
            .iter()
            .filter_map(|(at, e)| match e {
                Event::Play(p) => Some((at.since(Instant::default()) / 8000.0, p.level)),
                _ => None,
            })
            .collect();
        plays.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(plays, [(1.25, 0.5), (2.25, 0.5), (3.125, 0.5), (4.0, 0.25)]);
    }

    #[test]
    fn a_panic_stops_patterns_and_voices() {
        let (mut performer, mut kept) = performer("[[trigger]]\non = \"midi.note\"\nplay = \"v\"\n");
        performer.start_pattern(When::of_seconds(0.1, 8000.0), "p").unwrap();
        send(&mut performer, &mut kept, 0.1, on(0, 60, 100));
        send(&mut performer, &mut kept, 0.2, controller(120, 0));
        assert_eq!(kept.0.last().map(|(_, e)| *e), Some(Event::ReleaseAll));
        let sent = kept.0.len();
        send(&mut performer, &mut kept, 0.3, off(0, 60));
        performer.feed(80_000, &mut kept);
        assert_eq!(kept.0.len(), sent, "nothing is released twice, and nothing plays any more");
    }

    #[test]
    fn hostile_numbers_of_a_trigger_stay_within_what_a_file_could_say() {
        let (mut performer, mut kept) = performer(
            "[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nset = { level = \"1 / (note - 60)\", duration = \"-1 / (note - 60)\", \
             frequency = \"log(0 - note)\" }\n",
        );
        for note in [60, 61, 59] {
            send(&mut performer, &mut kept, 0.0, on(0, note, 100));
        }
        for (_, event) in &kept.0 {
            let Event::Play(play) = event else { continue };
            assert!(
                (0.0..=100.0).contains(&play.level) && play.duration >= 0.0 && play.own[0].is_finite(),
                "{play:?}"
            );
        }
        assert_eq!(kept.0.len(), 3);
    }
}
