//! Which OSC address somebody moves.

use std::collections::{HashMap, HashSet, VecDeque};
use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

use super::{Heard, Misfit, Source, Unfit};
use crate::io::osc::address::LONGEST;
use crate::io::osc::endpoint::{BindError, Endpoint};
use crate::io::osc::message::number;
use crate::io::osc::names::is_own;
use crate::io::osc::packet::unpack;
use crate::midi::reach::Reaches;
use crate::midi::travel::{SPAN, Travel};
use crate::patch::Mover;
use crate::patch::bind::ARGUMENTS;

/// The largest datagram of UDP.
const DATAGRAM: usize = 1 << 16;
/// Datagrams that are read before somebody else has a turn.
const TURN: usize = 256;
/// Addresses that are told apart.
const MOST: usize = 1 << 12;
/// So long what was recognised must rest before it is recognised again, seconds.
const REST: f64 = 0.7;

/// Listens to OSC for what is moved.
#[derive(Debug)]
pub(super) struct Ear {
    socket: UdpSocket,
    space: Vec<u8>,
    begin: Instant,
    /// Where each number of an address has been, and when it was heard of last.
    travels: HashMap<String, (Travel, f64)>,
    spent: Option<(String, f64)>,
    said: HashSet<String>,
    /// What a datagram said besides the first.
    waiting: VecDeque<Heard>,
    /// What was heard of and was not enough.
    pub heard: Reaches<String>,
}

impl Ear {
    /// Listens, and says where.
    ///
    /// # Errors
    /// A port that cannot be had.
    pub fn open(at: Endpoint) -> Result<(Self, SocketAddr), BindError> {
        let socket = at.bind()?;
        let deaf = |error| BindError {
            what: format!("the system does not let OSC be listened for: {error}"),
            help: "try another port".into(),
            exit_code: 74,
        };
        socket.set_nonblocking(true).map_err(deaf)?;
        let address = socket.local_addr().map_err(deaf)?;
        let ear = Self {
            socket,
            space: vec![0; DATAGRAM],
            begin: Instant::now(),
            travels: HashMap::new(),
            spent: None,
            said: HashSet::new(),
            waiting: VecDeque::new(),
            heard: Reaches::default(),
        };
        Ok((ear, address))
    }

    /// What somebody has moved since this was asked last; the rest waits.
    pub fn hear(&mut self) -> Option<Heard> {
        if let Some(heard) = self.waiting.pop_front() {
            return Some(heard);
        }
        let mut space = std::mem::take(&mut self.space);
        for _ in 0..TURN {
            // Nothing there, or nobody any more to whom nothing was sent: both come again.
            let Ok((length, _)) = self.socket.recv_from(&mut space) else { break };
            let seconds = self.begin.elapsed().as_secs_f64();
            for (_, message) in unpack(space.get(..length).unwrap_or_default()).unwrap_or_default() {
                for (at, value) in message.args.iter().enumerate().take(ARGUMENTS) {
                    let value = number(value);
                    let heard = value.and_then(|value| self.message(seconds, (&message.addr, at + 1), value));
                    self.waiting.extend(heard);
                }
            }
            if !self.waiting.is_empty() {
                break;
            }
        }
        self.space = space;
        self.waiting.pop_front()
    }

    /// Another is asked for: what was heard of is over, and what moved for the one before.
    pub fn forget(&mut self) {
        self.waiting.retain(|heard| matches!(heard, Heard::Unfit(_)));
        self.begin_anew();
    }

    fn begin_anew(&mut self) {
        self.travels.clear();
        self.heard = Reaches::default();
    }

    fn message(&mut self, seconds: f64, (address, argument): (&str, usize), value: f64) -> Option<Heard> {
        let misfit = if is_own(address) {
            Some(Misfit::Own)
        } else if address.contains(char::is_whitespace) {
            Some(Misfit::Blank)
        } else if address.len() > LONGEST {
            Some(Misfit::Long)
        } else if !(-1e-6..=1.0 + 1e-6).contains(&value) {
            Some(Misfit::Value(value))
        } else {
            None
        };
        if let Some(misfit) = misfit {
            // Once for each address.
            let new = self.said.len() < MOST && self.said.insert(address.into());
            return new.then(|| Heard::Unfit(Unfit::Osc(address.into(), misfit)));
        }
        if let Some((_, last)) = self.spent.as_mut().filter(|(spent, _)| spent == address) {
            if seconds - std::mem::replace(last, seconds) < REST {
                return None;
            }
            self.spent = None;
        }
        let from = Mover::Osc { address: address.into(), argument }.to_string();
        let name = from.strip_prefix("osc.").unwrap_or(&from);
        if self.travels.len() >= MOST && !self.travels.contains_key(name) {
            // Whatever says nothing any more makes room.
            let oldest =
                self.travels.iter().min_by(|a, b| a.1.1.total_cmp(&b.1.1)).map(|(old, _)| old.clone());
            oldest.and_then(|oldest| self.travels.remove(&oldest));
        }
        self.heard.hear(name.into(), value);
        let (travel, last) = self.travels.entry(name.into()).or_default();
        *last = seconds;
        travel.comes(seconds, value);
        let moved = travel.is_moved(SPAN) || travel.is_moved_coarsely();
        let (pressed, switch) = (!moved && travel.is_latched(), travel.is_switch());
        let alone =
            |(other, (travel, _)): (&String, &(Travel, f64))| other == name || !travel.is_far(seconds);
        let meant = moved || (pressed && self.travels.iter().all(alone));
        if !meant {
            return None;
        }
        self.begin_anew();
        self.spent = Some((address.into(), seconds));
        Some(Heard::Source(Source::Osc { address: address.into(), argument, switch }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Ear, Heard, MOST};
    use crate::io::osc::endpoint::Endpoint;

    #[test]
    fn among_more_addresses_than_are_told_apart_one_that_moves_is_recognised() {
        let (mut ear, _) = Ear::open("127.0.0.1:0".parse::<Endpoint>().unwrap()).unwrap();
        for n in 0..3 * MOST {
            assert_eq!(ear.message(1e-4 * n as f64, (&format!("/desk/{n}"), 1), 0.5), None);
        }
        assert_eq!(ear.travels.len(), MOST);
        let moved = (0..=50)
            .filter_map(|n| ear.message(2.0 + 0.02 * f64::from(n), ("/fader", 1), 0.02 * f64::from(n)));
        assert!(matches!(moved.collect::<Vec<_>>()[..], [Heard::Source(_)]));
    }

    /// All of what one datagram says is heard, one after the other: a fader that is learnt behind an address that cannot be.
    #[test]
    fn what_comes_in_one_datagram_is_heard_one_by_one() {
        use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder::encode};
        let (mut ear, at) = Ear::open("127.0.0.1:0".parse::<Endpoint>().unwrap()).unwrap();
        let message = |addr: &str, value: f32| {
            OscPacket::Message(OscMessage { addr: addr.into(), args: vec![OscType::Float(value)] })
        };
        let client = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
        let (mut unfit, mut learnt, begin) = (0, 0, std::time::Instant::now());
        for n in 0..=50_u32 {
            let content = vec![
                message(&format!("/desk/{n}/a"), 5.0),
                message(&format!("/desk/{n}/b"), 64.0),
                message("/fader", 0.02 * n as f32),
            ];
            let timetag = OscTime { seconds: 0, fractional: 1 };
            let bundle = OscPacket::Bundle(OscBundle { timetag, content });
            client.send_to(&encode(&bundle).unwrap(), at).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(5));
            while let Some(heard) = ear.hear() {
                match heard {
                    Heard::Unfit(_) => unfit += 1,
                    Heard::Source(_) => learnt += 1,
                }
            }
        }
        while unfit < 102 && begin.elapsed().as_secs() < 10 {
            unfit += i32::from(matches!(ear.hear(), Some(Heard::Unfit(_))));
        }
        assert_eq!((unfit, learnt), (102, 1));
    }

    /// Of a pad, whose messages have two numbers, the one that moves is learnt; and not the other right behind it, as the finger slides on.
    #[test]
    fn the_number_that_moves_is_told_from_the_one_beside_it() {
        let (mut ear, _) = Ear::open("127.0.0.1:0".parse::<Endpoint>().unwrap()).unwrap();
        let mut heard = Vec::new();
        for n in 0..200 {
            let (seconds, turn) = (0.01 * f64::from(n), f64::from(n) / 200.0);
            heard.extend(ear.message(seconds, ("/pad", 1), 0.5 + 0.01 * turn));
            heard.extend(ear.message(seconds, ("/pad", 2), turn));
        }
        for n in 0..20 {
            heard.extend(ear.message(2.0 + 0.01 * f64::from(n), ("/pad", 1), 0.05 * f64::from(n)));
        }
        let of = |heard: &Heard| match heard {
            Heard::Source(source) => source.mover().to_string(),
            Heard::Unfit(unfit) => panic!("{unfit:?}"),
        };
        assert_eq!(heard.iter().map(of).collect::<Vec<_>>(), ["osc./pad 2"]);
    }

    #[test]
    fn half_a_movement_is_none() {
        let (mut ear, _) = Ear::open("127.0.0.1:0".parse::<Endpoint>().unwrap()).unwrap();
        let half = |ear: &mut Ear, from: f64| {
            (0..5).find_map(|n| ear.message(from, ("/fader", 1), from + 0.012 * f64::from(n)))
        };
        assert_eq!(half(&mut ear, 0.4), None);
        ear.forget();
        assert_eq!(half(&mut ear, 0.46), None);
        assert!(half(&mut ear, 0.52).is_some());
    }
}
