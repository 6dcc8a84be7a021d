//! Which controller somebody moves, so that it can be bound to something: told from those that are noisy, that spring back, or that
//! come along with keys.

use std::collections::{HashMap, HashSet};

use super::channel::Channel;
use super::claims::Claims;
use super::encoder::{Encoder, Said, Turns};
use super::gesture::Gesture;
use super::interpreter::Interpreter;
use super::message::Message;
use super::reach::Reaches;
use super::strip::{SOSTENUTO, SUSTAIN};
use super::travel::{SPAN, Travel};

/// Keys that are played hard are pressed by as much without being meant.
const PRESSED: f64 = 0.3;
/// So long what was recognised must rest before it is recognised again: whoever turned it may still be turning.
const REST: f64 = 0.7;
/// A wheel that is closer to its middle is at rest.
const MIDDLE: f64 = 0.05;
/// The halves of a controller of 14 bits come this close to each other while it is moved, seconds; of a fader that is moved as little as this, the
/// upper one need not come.
const PAIR: f64 = 1.0;
/// A controller that says the same so often is no position.
const SAME: u32 = 8;

/// What somebody moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Control {
    /// A controller, 0 to 119; of a pair of 14 bits the lower number.
    Controller(u8),
    /// The wheel.
    Bend,
    /// The pressure on a channel or a key.
    Pressure,
}

/// What was moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moved {
    /// On which port.
    pub port: u16,
    /// On which channel.
    pub channel: Channel,
    /// What.
    pub control: Control,
    /// Whether it says where it stands with 14 bits.
    pub fine: bool,
    /// Whether it is a button.
    pub switch: bool,
    /// Of an endless knob, how it says its steps.
    pub encoder: Option<Encoder>,
}

/// Something that was used and gives no position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Useless {
    /// A key was played.
    Note,
    /// A program was chosen.
    Program,
    /// A numbered parameter (NRPN, RPN) was moved.
    Parameter,
    /// This pedal, 64 or 66, was pressed: it holds voices.
    Pedal(u8),
    /// This controller says the same again and again, as endless knobs do that tell steps: it has to be turned both ways to tell which.
    Steps(u8),
}

/// What is to be said about a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// Somebody has moved this.
    Moved(Moved),
    /// Somebody uses this, and it cannot be bound.
    Useless(Useless),
}

/// A port, a channel of it, and what is there.
pub type Source = (u16, Channel, Control);

/// Recognises what is moved, in the messages of all ports. It understands them as [`Interpreter`] does, so that what it recognises is
/// what a binding hears.
#[derive(Debug, Default)]
pub struct Recogniser {
    ports: HashMap<u16, Interpreter>,
    /// When the upper half of what may be of 14 bits came last, and the controllers that are taken for others than lower halves, since none did.
    upper: HashMap<(u16, Channel, u8), f64>,
    alone: HashMap<u16, HashSet<(Channel, u8)>>,
    travels: HashMap<Source, Travel>,
    /// Keys that are down.
    keys: HashMap<(u16, Channel), u32>,
    /// How often a controller has said the same, and what.
    same: HashMap<Source, (f64, u32)>,
    said: HashMap<Source, Said>,
    /// What was recognised last, and when it was heard of since.
    spent: Option<(Source, f64)>,
    /// Wheels that must come to rest before they count.
    astray: Vec<Source>,
    /// What was heard of since something was recognised, or [`Recogniser::forget`].
    heard: Reaches<Source>,
}

impl Recogniser {
    /// A message that came through a port at so many seconds.
    pub fn message(&mut self, seconds: f64, port: u16, message: Message) -> Option<Seen> {
        let mut gestures = Vec::new();
        self.tell_pairs(seconds, port, message);
        self.ports.entry(port).or_default().message(message, &mut |gesture| gestures.push(gesture));
        match message {
            Message::NoteOn { channel, velocity: 1.., .. } => {
                *self.keys.entry((port, channel)).or_default() += 1;
                return Some(Seen::Useless(Useless::Note));
            }
            Message::NoteOn { channel, .. } | Message::NoteOff { channel, .. } => {
                let down = self.keys.entry((port, channel)).or_default();
                *down = down.saturating_sub(1);
                // What falls with the key is not meant.
                self.travels.remove(&(port, channel, Control::Pressure));
                return None;
            }
            Message::Controller { number: number @ (SUSTAIN | SOSTENUTO), value, .. } => {
                return (value >= 64).then_some(Seen::Useless(Useless::Pedal(number)));
            }
            Message::Program { .. } => return Some(Seen::Useless(Useless::Program)),
            Message::Bend { channel, bend } => {
                return self.bend(seconds, (port, channel, Control::Bend), f64::from(bend) / 8192.0);
            }
            Message::ChannelPressure { channel, pressure }
            | Message::PolyPressure { channel, pressure, .. } => {
                return self.press(seconds, (port, channel, Control::Pressure), f64::from(pressure) / 127.0);
            }
            _ => {}
        }
        gestures.into_iter().find_map(|gesture| match gesture {
            Gesture::Controller { channel, number, value, fine } => {
                let raw = match message {
                    Message::Controller { value, .. } if !fine => Some(value),
                    _ => None,
                };
                self.turn(seconds, (port, channel, Control::Controller(number)), value, raw)
            }
            Gesture::Parameter { .. } => Some(Seen::Useless(Useless::Parameter)),
            _ => None,
        })
    }

    /// A controller from 32 to 63 is a lower half only behind its upper one: there are boxes that have knobs of both numbers.
    fn tell_pairs(&mut self, seconds: f64, port: u16, message: Message) {
        let Message::Controller { channel, number, .. } = message else { return };
        if number < 32 {
            self.upper.insert((port, channel, number), seconds);
        }
        if !(32..64).contains(&number) {
            return;
        }
        let upper = self.upper.get(&(port, channel, number - 32));
        let is_pair = upper.is_some_and(|upper| seconds - upper <= PAIR);
        let alone = self.alone.entry(port).or_default();
        let changes =
            if is_pair { alone.remove(&(channel, number)) } else { alone.insert((channel, number)) };
        if changes {
            let mut claims = Claims::default();
            alone.iter().for_each(|(channel, number)| claims.add(*number, Some(*channel)));
            self.ports.entry(port).or_default().claim(&claims);
        }
    }

    /// What was heard of and was not enough to be recognised.
    pub fn heard(&self) -> &Reaches<Source> {
        &self.heard
    }

    /// What was heard of is over: something else is asked for, and half a movement counts for nothing.
    pub fn forget(&mut self) {
        self.travels.clear();
        self.same.clear();
        self.said.clear();
        self.heard = Reaches::default();
    }

    /// A controller stands at a position, or says seven bits that may be steps.
    fn turn(&mut self, seconds: f64, source: Source, value: f64, raw: Option<u8>) -> Option<Seen> {
        if !self.rested(seconds, source) {
            return None;
        }
        let turns = raw.map_or(Turns::No, |raw| self.said.entry(source).or_default().says(raw));
        let (last, count) = self.same.entry(source).or_insert((value, 0));
        *count = if *last == value { *count + 1 } else { 1 };
        *last = value;
        let (count, number) = (*count, source.2);
        match (turns, number) {
            (Turns::Yes(encoder), _) => self.found(seconds, source, Some(encoder), false, false),
            (_, Control::Controller(number)) if count == SAME => Some(Seen::Useless(Useless::Steps(number))),
            // Steps are no way that it goes.
            (Turns::Perhaps, _) => {
                self.travels.remove(&source);
                self.heard.hear(source, value);
                None
            }
            _ => self.count(seconds, source, value, SPAN, raw.is_none()),
        }
    }

    /// A wheel springs back: it counts from its rest on.
    fn bend(&mut self, seconds: f64, source: Source, bend: f64) -> Option<Seen> {
        if bend.abs() < MIDDLE {
            self.astray.retain(|other| *other != source);
            self.travels.remove(&source);
        }
        if self.astray.contains(&source) {
            return None;
        }
        let seen = self.count(seconds, source, 0.5 + 0.5 * bend, SPAN, true);
        if seen.is_some() {
            self.astray.push(source);
        }
        seen
    }

    /// Pressure counts while a key is down and it rises.
    fn press(&mut self, seconds: f64, source: Source, pressure: f64) -> Option<Seen> {
        let down = self.keys.get(&(source.0, source.1)).is_some_and(|down| *down > 0);
        let last = self.travels.get(&source).and_then(Travel::last);
        if !down || last.is_some_and(|last| last > pressure) {
            self.travels.remove(&source);
        }
        if down { self.count(seconds, source, pressure, PRESSED, false) } else { None }
    }

    fn count(&mut self, seconds: f64, source: Source, value: f64, span: f64, fine: bool) -> Option<Seen> {
        if !self.rested(seconds, source) {
            return None;
        }
        self.heard.hear(source, value);
        let travel = self.travels.entry(source).or_default();
        travel.comes(seconds, value);
        // Of keys that are played hard, a few steps are the rule.
        let moved = match source.2 {
            Control::Pressure => travel.is_moved(span),
            _ => travel.is_moved(span) || travel.is_moved_coarsely(),
        };
        let pressed = !moved && travel.is_latched();
        let switch = travel.is_switch();
        let alone = |(other, travel): (&Source, &Travel)| *other == source || !travel.is_far(seconds);
        let meant = moved || (pressed && self.travels.iter().all(alone));
        if !meant {
            return None;
        }
        self.found(seconds, source, None, fine, switch)
    }

    /// Whether it is not what was recognised last, or has rested since.
    fn rested(&mut self, seconds: f64, source: Source) -> bool {
        let Some((_, heard)) = self.spent.as_mut().filter(|(spent, _)| *spent == source) else { return true };
        let rested = seconds - std::mem::replace(heard, seconds) >= REST;
        if rested {
            self.spent = None;
        }
        rested
    }

    /// It was moved, and has [rested](Self::rested) before.
    fn found(
        &mut self,
        seconds: f64,
        source: Source,
        encoder: Option<Encoder>,
        fine: bool,
        switch: bool,
    ) -> Option<Seen> {
        let (port, channel, control) = source;
        self.spent = Some((source, seconds));
        self.forget();
        Some(Seen::Moved(Moved { port, channel, control, fine, switch, encoder }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Control, Encoder, Moved, Recogniser, Seen, Useless};
    use crate::midi::{Channel, Message};

    const CHANNEL: Channel = Channel::FIRST;

    fn controller(number: u8, value: u8) -> Message {
        Message::Controller { channel: CHANNEL, number, value }
    }

    fn bend(bend: i16) -> Message {
        Message::Bend { channel: CHANNEL, bend }
    }

    fn pressure(pressure: u8) -> Message {
        Message::ChannelPressure { channel: CHANNEL, pressure }
    }

    /// A recogniser and a clock: a message each hundredth of a second.
    #[derive(Default)]
    struct Bench(Recogniser, f64);

    impl Bench {
        fn play(&mut self, messages: impl IntoIterator<Item = Message>) -> Vec<Moved> {
            let mut moved = Vec::new();
            for message in messages {
                self.1 += 0.01;
                if let Some(Seen::Moved(one)) = self.0.message(self.1, 3, message) {
                    moved.push(one);
                }
            }
            moved
        }
    }

    fn moved(control: Control, fine: bool, switch: bool) -> Moved {
        Moved { port: 3, channel: CHANNEL, control, fine, switch, encoder: None }
    }

    #[test]
    fn a_knob_that_is_turned_among_noisy_ones_is_recognised_once() {
        let mut bench = Bench::default();
        let noise = |n: u8| [controller(20, 60 + n % 2), controller(22, 100 + 4 * (n % 3))];
        assert!(bench.play((0..200).flat_map(noise)).is_empty());
        let turned = (0..100).flat_map(|n| [noise(n)[0], noise(n)[1], controller(21, n)]);
        assert_eq!(bench.play(turned), [moved(Control::Controller(21), false, false)]);
        // It is turned on, back, and left alone; then turned again.
        assert!(bench.play((0..100).rev().map(|n| controller(21, n))).is_empty());
        bench.1 += 1.0;
        assert_eq!(bench.play((0..100).map(|n| controller(21, n))).len(), 1);
    }

    #[test]
    fn fourteen_bits_are_one_knob_and_an_upper_number_alone_is_another() {
        let mut bench = Bench::default();
        let pair = (0..400_u16).flat_map(|n| {
            let long = 20 * n;
            [controller(16, (long >> 7) as u8), controller(48, (long & 127) as u8)]
        });
        assert_eq!(bench.play(pair), [moved(Control::Controller(16), true, false)]);
        assert_eq!(
            bench.play((0..50).map(|n| controller(49, n))),
            [moved(Control::Controller(49), false, false)]
        );
    }

    /// Two knobs of one box, as its maker has numbered them.
    #[test]
    fn a_knob_32_above_another_is_no_half_of_it() {
        let mut bench = Bench::default();
        let turned = |number: u8| (0..100).map(move |n| controller(number, n));
        assert_eq!(bench.play(turned(17)), [moved(Control::Controller(17), false, false)]);
        bench.1 += 3.0;
        assert_eq!(bench.play(turned(49)), [moved(Control::Controller(49), false, false)]);
        bench.1 += 3.0;
        assert_eq!(bench.play(turned(17).rev()), [moved(Control::Controller(17), false, false)]);
        // One of 14 bits that tells its upper half only when it changes is one all the same, also where it was moved before.
        let long = (0..500_u16).flat_map(|n| {
            let lower = controller(52, ((32 * n) & 127) as u8);
            let upper = (n % 4 == 0).then(|| controller(20, ((32 * n) >> 7) as u8));
            upper.into_iter().chain([lower])
        });
        for _ in 0..2 {
            bench.1 += 3.0;
            assert_eq!(bench.play(long.clone()), [moved(Control::Controller(20), true, false)]);
        }
    }

    /// Up, down, and what it says in each of the three ways.
    #[test]
    fn an_endless_knob_is_one_once_it_was_turned_both_ways() {
        for (encoder, [up, down]) in [
            (Encoder::TwosComplement, [1, 127]),
            (Encoder::BinaryOffset, [65, 63]),
            (Encoder::SignedBit, [1, 65]),
        ] {
            let mut bench = Bench::default();
            assert!(bench.play([controller(21, up); 12]).is_empty(), "which of them it is, is not known yet");
            let found = bench.play([controller(21, down); 3]);
            let one = Moved { encoder: Some(encoder), ..moved(Control::Controller(21), false, false) };
            assert_eq!(found, [one]);
            assert!(bench.play([controller(21, up); 12]).is_empty(), "it is still turned");
            // For long, and then back.
            let on = [controller(21, up); 200].into_iter().chain([controller(21, down); 20]);
            assert!(bench.play(on).is_empty(), "it has not rested");
            // Another, when it has come to rest and something else is asked for.
            bench.1 += 5.0;
            assert_eq!(
                bench.play([up, up, up, up, down, down, down, down].map(|v| controller(21, v))),
                [one]
            );
        }
    }

    #[test]
    fn a_wheel_counts_on_its_way_out_and_not_on_its_way_back() {
        let mut bench = Bench::default();
        let out = || (0..40).map(|n| bend(200 * n));
        assert_eq!(bench.play(out()), [moved(Control::Bend, true, false)]);
        bench.1 += 5.0;
        assert!(bench.play((0..40).rev().map(|n| bend(200 * n))).is_empty(), "let go of much later");
        bench.1 += 5.0;
        assert_eq!(bench.play(out()).len(), 1);
    }

    #[test]
    fn pressure_is_meant_when_a_key_is_pressed_hard() {
        let mut bench = Bench::default();
        let down = Message::NoteOn { channel: CHANNEL, note: 60, velocity: 90 };
        let up = Message::NoteOff { channel: CHANNEL, note: 60, velocity: 0 };
        let played = [down]
            .into_iter()
            .chain([0, 8, 16, 24, 30].map(pressure))
            .chain([20, 10, 4].map(pressure))
            .chain([up]);
        assert!(bench.play(played.chain([3, 2, 1, 0].map(pressure))).is_empty(), "played and let go");
        assert!(bench.play((0..127).map(pressure)).is_empty(), "without a key");
        assert_eq!(
            bench.play([down].into_iter().chain((0..127).map(pressure))),
            [moved(Control::Pressure, false, false)]
        );
    }

    #[test]
    fn a_button_is_recognised_when_it_is_pressed_twice() {
        let mut bench = Bench::default();
        assert!(bench.play([127, 0].map(|v| controller(80, v))).is_empty());
        assert_eq!(
            bench.play([127, 0].map(|v| controller(80, v))),
            [moved(Control::Controller(80), false, true)]
        );
    }

    #[test]
    fn a_sweep_of_few_steps_is_recognised() {
        // A selector of few steps, a switch of three positions, and one of them flicked there and back; a tenth of a second each.
        let others = [1, 2, 3].map(|number| controller(number, 64));
        for steps in [&[0x10, 0x30, 0x60][..], &[0, 64, 127], &[127, 64, 0], &[64, 127, 64], &[64, 0, 64]] {
            let mut bench = Bench::default();
            let turned = steps.iter().flat_map(|value| {
                let mut all = vec![controller(21, *value)];
                all.extend(others.iter().cycle().take(9).copied());
                all
            });
            let all = bench.play(turned);
            assert_eq!(all.len(), 1, "{steps:?}");
            assert_eq!(all[0].control, Control::Controller(21), "{steps:?}");
        }
        let wheel = Bench::default().play([2000, 5000].map(bend));
        assert!(wheel.is_empty(), "two positions are no sweep");
        let mut bench = Bench::default();
        let all = [1000, 3000, 7000].into_iter().flat_map(|value| {
            bench.1 += 0.05;
            bench.play([bend(value)])
        });
        assert_eq!(all.collect::<Vec<_>>(), [moved(Control::Bend, true, false)]);
    }

    #[test]
    fn neither_spikes_nor_a_stray_message_are_a_sweep() {
        // A worn potentiometer that jumps for a moment, on its own and among its noise; a message, and a pair of them with 14 bits.
        for noise in [&[60, 127, 60][..], &[10, 60, 110], &[60, 61, 60, 0], &[10, 110], &[127]] {
            let mut bench = Bench::default();
            assert!(bench.play(noise.iter().map(|v| controller(20, *v))).is_empty(), "{noise:?}");
        }
        let pair = |high: u8, low: u8| [controller(16, high), controller(48, low)];
        let mut bench = Bench::default();
        assert!(bench.play(pair(20, 5).into_iter().chain(pair(90, 77)).take(3)).is_empty());
    }

    #[test]
    fn a_button_that_stays_down_is_recognised_when_nothing_else_moves() {
        let press = |bench: &mut Bench, value: u8, more: &[Message]| {
            bench.1 += 0.6;
            bench.play(more.iter().copied().chain([controller(80, value)]))
        };
        let mut bench = Bench::default();
        assert!(press(&mut bench, 127, &[]).is_empty());
        assert_eq!(press(&mut bench, 0, &[]), [moved(Control::Controller(80), false, true)]);
        // Something else moves as well.
        let mut bench = Bench::default();
        assert!(press(&mut bench, 127, &[controller(22, 10)]).is_empty());
        assert!(press(&mut bench, 0, &[controller(22, 60)]).is_empty());
        // Pressed at leisure.
        let mut bench = Bench::default();
        assert!(bench.play([127, 0].map(|v| controller(80, v))).is_empty());
        bench.1 += 3.0;
        assert_eq!(bench.play([controller(80, 127)]), [moved(Control::Controller(80), false, true)]);
    }

    #[test]
    fn what_was_not_enough_is_known() {
        let mut bench = Bench::default();
        assert!(bench.0.heard().most().is_none());
        bench.play([controller(20, 60), controller(21, 15), controller(21, 18), controller(20, 61)]);
        let (source, reach) = bench.0.heard().most().unwrap();
        assert_eq!(source.2, Control::Controller(21));
        assert_eq!([reach.least, reach.most], [15.0 / 127.0, 18.0 / 127.0]);
        bench.0.forget();
        assert!(bench.0.heard().most().is_none());
        // Half a movement for what was asked before, and half for what is asked now.
        let rise = |from: u8| (0..5).map(move |n| controller(22, from + 2 * n));
        assert!(bench.play(rise(40)).is_empty());
        bench.0.forget();
        assert!(bench.play(rise(50)).is_empty());
        assert!(bench.play([controller(23, 9); 7]).is_empty());
        bench.0.forget();
        assert_eq!(bench.0.message(bench.1, 3, controller(23, 9)), None, "steps of before");
        // What is recognised is over, and what it says while it is turned on is not heard of.
        bench.play((0..100).map(|n| controller(21, n)));
        assert!(bench.0.heard().most().is_none());
    }

    #[test]
    fn what_cannot_be_bound_is_named() {
        let mut recogniser = Recogniser::default();
        let mut seen = |message| recogniser.message(0.0, 0, message);
        let note = Message::NoteOn { channel: CHANNEL, note: 60, velocity: 1 };
        assert_eq!(seen(note), Some(Seen::Useless(Useless::Note)));
        assert_eq!(seen(Message::NoteOff { channel: CHANNEL, note: 60, velocity: 1 }), None);
        assert_eq!(
            seen(Message::Program { channel: CHANNEL, program: 5 }),
            Some(Seen::Useless(Useless::Program))
        );
        let steps: Vec<_> = (0..30).filter_map(|_| seen(controller(70, 65))).collect();
        assert_eq!(steps, [Seen::Useless(Useless::Steps(70))]);
        let parameter = [(99, 1), (98, 2), (6, 64)].map(|(number, value)| seen(controller(number, value)));
        assert_eq!(parameter[2], Some(Seen::Useless(Useless::Parameter)));
        // A desk that tells where everything stands has not been moved; nor do clocks, pedals and modes.
        let all = (0..128).flat_map(|number| [controller(number, 99), Message::Clock]);
        assert!(all.into_iter().all(|message| !matches!(seen(message), Some(Seen::Moved(_)))));
        for number in [64, 66] {
            let pedal: Vec<_> = (0..4).map(|n| seen(controller(number, 127 * (n % 2)))).collect();
            let pressed = Some(Seen::Useless(Useless::Pedal(number)));
            assert_eq!(pedal, [None, pressed, None, pressed]);
        }
    }
}
