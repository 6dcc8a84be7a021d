//! Which OSC address somebody moves.

use super::source::Source;
use pacinian::io::osc::address::LONGEST;
use pacinian::io::osc::endpoint::{BindError, Endpoint};
use pacinian::io::osc::packet::unpack;
use pacinian::midi::reach::Reaches;
use pacinian::midi::travel::{SPAN, Travel};
use pacinian::text::problem::escaped;
use rosc::OscType;
use std::collections::{HashMap, HashSet};
use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

/// The largest datagram of UDP.
const DATAGRAM: usize = 1 << 16;
/// Datagrams that are read before somebody else has a turn.
const TURN: usize = 256;
/// Addresses that are told apart.
const MOST: usize = 1 << 12;
/// So long what was recognised must rest before it is recognised again, seconds.
const REST: f64 = 0.7;

/// Characters of an address that are shown, at most.
const SHOWN: usize = 80;

/// First parts of addresses that pacinian has itself.
const OWN: [&str; 11] =
    ["voice", "pattern", "control", "controls", "panic", "calm", "arm", "meter", "status", "ping", "input"];

/// Listens to OSC for what is moved.
pub struct Ear {
    socket: UdpSocket,
    space: Vec<u8>,
    begin: Instant,
    travels: HashMap<String, Travel>,
    spent: Option<(String, f64)>,
    said: HashSet<String>,
    /// What was heard of and was not enough.
    pub heard: Reaches<String>,
}

/// What was heard.
pub enum Heard {
    /// Somebody moves this.
    Source(Source),
    /// Something that cannot be bound, in words.
    Useless(String),
}

impl Ear {
    /// Listens there.
    ///
    /// # Errors
    /// A port that cannot be had.
    pub fn open(at: Endpoint) -> Result<Self, BindError> {
        let socket = at.bind()?;
        socket.set_nonblocking(true).map_err(|error| BindError {
            what: format!("the system does not let OSC be listened for: {error}"),
            help: "try another port".into(),
            exit_code: 74,
        })?;
        Ok(Self {
            socket,
            space: vec![0; DATAGRAM],
            begin: Instant::now(),
            travels: HashMap::new(),
            spent: None,
            said: HashSet::new(),
            heard: Reaches::default(),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// What somebody has moved since this was asked last; the rest waits.
    pub fn hear(&mut self) -> Option<Heard> {
        let mut space = std::mem::take(&mut self.space);
        let mut heard = None;
        for _ in 0..TURN {
            // Nothing there, or nobody any more to whom nothing was sent: both come again.
            let Ok((length, _)) = self.socket.recv_from(&mut space) else { break };
            let seconds = self.begin.elapsed().as_secs_f64();
            for (_, message) in unpack(space.get(..length).unwrap_or_default()).unwrap_or_default() {
                let value = message.args.first().and_then(number);
                heard = heard.or(value.and_then(|value| self.message(seconds, &message.addr, value)));
            }
            if heard.is_some() {
                break;
            }
        }
        self.space = space;
        heard
    }

    fn message(&mut self, seconds: f64, address: &str, value: f64) -> Option<Heard> {
        let first = address.split('/').nth(1).unwrap_or_default();
        let shown = shown(address);
        if OWN.contains(&first) {
            return self.say(address, format!("{shown} is an address of pacinian's own; see docs/osc.md"));
        }
        if address.contains(char::is_whitespace) {
            return self.say(address, format!("{shown} has a blank in it, which a binding cannot have; name it otherwise where it comes from"));
        }
        if address.len() > LONGEST {
            let why = format!(
                "{shown} is longer than the {LONGEST} bytes that an address may have; name it otherwise where it comes from"
            );
            return self.say(address, why);
        }
        if !(-1e-6..=1.0 + 1e-6).contains(&value) {
            let why = format!(
                "{shown} says {value}: a binding takes positions from 0 to 1; set it so where it comes from"
            );
            return self.say(address, why);
        }
        if let Some((_, last)) = self.spent.as_mut().filter(|(spent, _)| spent == address) {
            if seconds - std::mem::replace(last, seconds) < REST {
                return None;
            }
            self.spent = None;
        }
        if self.travels.len() >= MOST && !self.travels.contains_key(address) {
            return None;
        }
        self.heard.hear(address.into(), value);
        let travel = self.travels.entry(address.into()).or_default();
        travel.comes(seconds, value);
        let moved = travel.is_moved(SPAN) || travel.is_moved_coarsely();
        let (pressed, source) = (!moved && travel.is_latched(), Source::osc(address, travel.is_switch()));
        let alone = |(other, travel): (&String, &Travel)| other == address || !travel.is_far(seconds);
        let meant = moved || (pressed && self.travels.iter().all(alone));
        if !meant {
            return None;
        }
        self.travels.clear();
        self.heard = Reaches::default();
        self.spent = Some((address.into(), seconds));
        Some(Heard::Source(source))
    }

    /// Once for each address.
    fn say(&mut self, address: &str, why: String) -> Option<Heard> {
        let new = self.said.len() < MOST && self.said.insert(address.into());
        new.then_some(Heard::Useless(why))
    }
}

/// As it may be shown: whoever sends it chooses it.
pub fn shown(address: &str) -> String {
    let cut: String = address.chars().take(SHOWN).collect();
    format!("{}{}", escaped(&cut), if cut.len() < address.len() { "..." } else { "" })
}

fn number(value: &OscType) -> Option<f64> {
    match value {
        OscType::Int(x) => Some(f64::from(*x)),
        OscType::Long(x) => Some(*x as f64),
        OscType::Float(x) => Some(f64::from(*x)),
        OscType::Double(x) => Some(*x),
        OscType::Bool(x) => Some(f64::from(u8::from(*x))),
        _ => None,
    }
    .filter(|x| x.is_finite())
}
