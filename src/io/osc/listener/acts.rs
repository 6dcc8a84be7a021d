//! Does what was asked for, and answers.

use std::net::SocketAddr;
use std::time::Duration;

use rosc::{OscMessage, OscPacket, OscType, encoder};

use super::Listener;
use crate::io::osc::announce::{Announcer, Wants};
use crate::io::osc::message::Ask;
use crate::io::osc::names::Kind;
use crate::io::osc::peers::{LIFE, What};
use crate::live::signal::{Handle, Origin, Signal};
use crate::live::stamp::Stamp;
use crate::live::way::Way;

impl Listener {
    fn send(&self, at: Stamp, signal: Signal) -> bool {
        self.send_numbered(at, signal).is_some()
    }

    /// The same. Gives the signal's number, if it was taken.
    fn send_numbered(&self, at: Stamp, signal: Signal) -> Option<u64> {
        self.send_by(&self.handle, at, signal)
    }

    fn send_by(&self, handle: &Handle, at: Stamp, signal: Signal) -> Option<u64> {
        let taken = handle.send_knowing(at, signal, self.pulls).ok();
        if taken.is_some() { &self.counts.taken } else { &self.counts.refused }.add(1);
        taken
    }

    /// Where a control stands: as whoever moved it last has sent it, those included that the session has not come to yet.
    fn value(&self, number: usize) -> Option<f64> {
        let (control, (own, id)) = self.names.controls.get(number).zip(self.values.get(number))?;
        Some(self.handle.board().values.since(&control.name, Way::Osc, *id).unwrap_or(*own))
    }

    /// Does what was asked for, as of `at`.
    pub(super) fn act(&mut self, at: Stamp, from: SocketAddr, message: u64, what: Ask) {
        match what {
            Ask::Play(voice, note, id) => {
                let number = self.handle.number();
                let handle = self.handle.tagged(id);
                let taken = self.send_by(&handle, at, Signal::Play(number, voice, note)).is_some();
                if let (true, Some(id)) = (taken, id) {
                    self.counts.forgotten.add(self.ids.keep(id, message, number));
                }
            }
            Ask::Touch(id, touch) => match self.ids.get(id) {
                Some(numbers) => numbers.iter().for_each(|number| {
                    self.send(at, Signal::Touch(*number, touch));
                }),
                None => self.strange(id),
            },
            Ask::Release(id) => match self.ids.take(id) {
                Some(numbers) => {
                    for number in numbers {
                        if !self.send(at, Signal::Release(number)) {
                            // It can be tried again.
                            self.ids.keep(id, message, number);
                        }
                    }
                }
                None => self.strange(id),
            },
            Ask::ReleaseAll => drop(self.send(at, Signal::ReleaseAll)),
            Ask::Start(name) => drop(self.send(at, Signal::Start(self.handle.number(), name))),
            Ask::Stop(name) => drop(self.send(at, Signal::StopNamed(name))),
            Ask::Set(number, value) => self.set(at, number, value),
            Ask::Feed(values) => {
                for (number, value) in values {
                    // Which of them it is.
                    let name = self.names.controls.get(number).map_or("", |control| &control.name);
                    let origin = Origin::Osc(format!("/input/{name}").into(), value.to_string().into());
                    self.handle = self.handle.from(origin);
                    self.set(at, number, value);
                }
            }
            Ask::Get(control) => self.tell(from, control),
            Ask::Report(control, Some(every)) => {
                self.tell(from, control);
                self.subscribe(from, What::Control(control), every);
            }
            Ask::Report(control, None) => self.peers.unsubscribe(from, What::Control(control)),
            Ask::List(Kind::Controls) => self.list(from),
            Ask::List(Kind::Voices) => self.names(from, "/voices", &self.names.voices),
            Ask::List(Kind::Patterns) => self.names(from, "/patterns", &self.names.patterns),
            Ask::Panic => {
                // It was when this came, but somebody may have let it go since.
                let number = self.brakes.take().unwrap_or_else(|| self.handle.signal_number());
                let board = self.handle.board();
                if !board.is_panicked() {
                    board.lever.panic(number);
                }
                self.pulls = board.lever.pulls();
                let taken = self.handle.send_panic(at, number);
                if taken.is_ok() { &self.counts.taken } else { &self.counts.refused }.add(1);
                self.cancel();
            }
            // A brake that was pulled since then holds.
            Ask::Calm if self.handle.board().lever.pulls() != self.pulls => {
                self.counts.cancelled.add(1);
                let why = self.complaints.cancelled(self.handle.epoch().now());
                self.write(why);
            }
            Ask::Calm => drop(self.send(at, Signal::Calm)),
            Ask::Arm(armed) => drop(self.send(at, Signal::Arm(armed))),
            Ask::Torque(on) => drop(self.send(at, Signal::Torque(on))),
            Ask::Subscribe(every) => {
                if self.subscribe(from, What::Meter, every) {
                    let every = OscType::Int(every.as_millis() as i32);
                    self.answer(from, "/meter/subscribed", vec![every, OscType::Int(LIFE as i32)]);
                }
            }
            Ask::Unsubscribe => self.peers.unsubscribe(from, What::Meter),
            Ask::Invite(wants) => {
                let invite = |announcer: &Announcer| announcer.invite(from, &self.socket, wants);
                if self.announcer.as_ref().is_some_and(invite) {
                    let what = match wants {
                        Wants::Markers => "/marker/subscribed",
                        Wants::All => "/event/subscribed",
                    };
                    self.answer(from, what, vec![OscType::Int(LIFE as i32)]);
                } else {
                    self.counts.crowded.add(1);
                }
            }
            Ask::Dismiss => self.announcer.iter().for_each(|announcer| announcer.dismiss(from)),
            Ask::Status => self.status(from),
            Ask::Ping => self.answer(from, "/pong", vec![]),
            Ask::Trigger(address, numbers) => {
                self.complaints.position(&address, &numbers, &self.names);
                self.send(at, Signal::Osc(address, numbers));
            }
            Ask::Note(text) => drop(self.send(at, Signal::Note(text))),
            Ask::Nothing => {}
        }
    }

    fn set(&mut self, at: Stamp, number: usize, value: f64) {
        let Some(control) = self.names.controls.get(number) else { return };
        let (name, value) = (control.name.clone(), value.clamp(control.range[0], control.range[1]));
        if let (Some(id), Some(slot)) =
            (self.send_numbered(at, Signal::Set(name, value)), self.values.get_mut(number))
        {
            *slot = (value, id);
        }
    }

    fn subscribe(&mut self, to: SocketAddr, what: What, every: Duration) -> bool {
        let room = self.peers.subscribe(to, what, every, self.handle.epoch().now());
        self.counts.crowded.add(u64::from(!room));
        room
    }

    pub(super) fn answer(&self, to: SocketAddr, addr: &str, args: Vec<OscType>) {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args });
        let sent = encoder::encode(&packet).is_ok_and(|bytes| self.socket.send_to(&bytes, to).is_ok());
        self.counts.unsent.add(u64::from(!sent));
    }

    pub(super) fn tell(&self, to: SocketAddr, control: usize) {
        if let (Some(c), Some(value)) = (self.names.controls.get(control), self.value(control)) {
            self.answer(to, &format!("/control/{}", c.name), vec![OscType::Float(value as f32)]);
        }
    }

    fn list(&self, to: SocketAddr) {
        for (number, control) in self.names.controls.iter().enumerate() {
            let Some(value) = self.value(number) else { continue };
            let [least, most] = control.range;
            let numbers = [value, least, most, control.default].map(|x| OscType::Float(x as f32));
            let args = std::iter::once(control.name.as_str().into()).chain(numbers);
            self.answer(to, "/controls", args.chain([control.unit.as_str().into()]).collect());
        }
        self.answer(to, "/controls/end", vec![count(self.values.len() as u64)]);
    }

    fn names(&self, to: SocketAddr, address: &str, names: &[String]) {
        names.iter().for_each(|name| self.answer(to, address, vec![name.as_str().into()]));
        self.answer(to, &format!("{address}/end"), vec![count(names.len() as u64)]);
    }

    fn status(&self, to: SocketAddr) {
        let board = self.handle.board();
        let mut args = vec![
            OscType::Long(i64::try_from(board.frames.get()).unwrap_or(i64::MAX)),
            count(board.voices.get()),
            OscType::Float(board.load.mean() as f32),
            count(board.xruns.get()),
            count(board.late.get()),
            count(board.dropped.get() + board.refused.get()),
        ];
        // Of those, signals and patterns that found no room, by where they came from.
        args.extend(board.refused.named().map(|(_, refused)| count(refused)));
        self.answer(to, "/status", args);
    }
}

/// As many as 32 bits hold.
fn count(n: u64) -> OscType {
    OscType::Int(i32::try_from(n).unwrap_or(i32::MAX))
}
