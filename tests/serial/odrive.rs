//! A simulated ODrive with a simulated knob on its axis 0.

use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::TAU;

use pacinian::knob::plant::Plant;
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::parts::{Build, Hand};

use crate::cable::Device;

/// Of its motor's loop.
pub const RATE: f64 = 8_000.0;

/// Counts a turn.
pub const COUNTS: f64 = 8_192.0;

/// Which names its properties have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Names {
    Old,
    New,
    /// No watchdog among them.
    Unwatched,
    /// Commands alone.
    Bare,
}

/// How it misbehaves.
#[derive(Debug, Clone, Default)]
pub struct Mischief {
    /// It says back what it is told.
    pub echo: bool,
    /// It hears and says nothing between these times.
    pub stall: Option<(f64, f64)>,
    /// It says nothing but hears.
    pub mute: bool,
    /// Bytes a second of numbers without an end.
    pub flood: f64,
    /// Lines that nobody asked for, with right checksums, a second.
    pub chatter: f64,
    /// Each answer of this number has a wrong checksum; 0 for none. Likewise: is cut short with its line end; has garbage before it; says
    /// something that fits no question; comes 30 ms late.
    pub bad_checksum: u64,
    pub cut: u64,
    pub garbage: u64,
    pub odd: u64,
    pub late: u64,
    /// It answers without checksums.
    pub no_checksum: bool,
    /// It answers each line with these words.
    pub says: Option<&'static str>,
    /// At this time it starts anew.
    pub reset: Option<f64>,
    /// At this time it finds this error.
    pub fails: Option<(f64, u64)>,
}

pub struct FakeODrive {
    pub mischief: Mischief,
    pub names: Names,
    pub plant: Plant,
    /// A hand's torque on the knob, N m.
    pub hand: f64,
    pub properties: BTreeMap<String, f64>,
    pub state: i64,
    pub error: u64,
    /// N m, as commanded last.
    pub set_point: f64,
    /// Torques that the motor made, with the time at which they began.
    pub made: Vec<(f64, f64)>,
    /// Lines that came, but for those of an exchange.
    pub lines: Vec<String>,
    pub exchanges: u64,
    /// Longest line that came.
    pub longest: usize,
    held: Vec<u8>,
    says: VecDeque<(f64, Vec<u8>)>,
    fed: f64,
    steps: u64,
    answers: u64,
    spilled: f64,
}

fn xor(bytes: &[u8]) -> u8 {
    let mut sum = 0;
    for byte in bytes {
        sum ^= *byte;
    }
    sum
}

impl FakeODrive {
    pub fn new(names: Names) -> Self {
        // As heavy as a knob with a motor of 1.6e-6 kg m2 and some friction in its bearing.
        let parameters = Parameters { inertia: 2e-5, viscous: 2e-4, ..Parameters::default() };
        let plant = Plant::new(&Build { parameters, ..Build::default() }, RATE).unwrap();
        let mut properties: BTreeMap<String, f64> = BTreeMap::new();
        let mut put = |name: &str, value: f64| properties.insert(format!("axis0.{name}"), value);
        if names != Names::Bare {
            put("requested_state", 0.0);
            put("controller.config.vel_limit", 20.0);
            put("controller.config.control_mode", 3.0);
            put("controller.config.input_mode", 6.0);
        }
        match names {
            Names::Old | Names::Unwatched => put("motor.config.torque_lim", f64::INFINITY),
            Names::New => {
                put("config.torque_soft_max", f64::INFINITY);
                put("config.torque_soft_min", f64::NEG_INFINITY)
            }
            Names::Bare => None,
        };
        if matches!(names, Names::Old | Names::New) {
            put("config.watchdog_timeout", 0.0);
            put("config.enable_watchdog", 0.0);
        }
        Self {
            mischief: Mischief::default(),
            names,
            plant,
            hand: 0.0,
            properties,
            state: 1,
            error: 0,
            set_point: 0.0,
            made: vec![(0.0, 0.0)],
            lines: Vec::new(),
            exchanges: 0,
            longest: 0,
            held: Vec::new(),
            says: VecDeque::new(),
            fed: 0.0,
            steps: 0,
            answers: 0,
            spilled: 0.0,
        }
    }

    /// It was without current until now.
    pub fn pass_to(&mut self, now: f64) {
        (self.steps, self.spilled) = ((now * RATE) as u64, now);
    }

    fn get(&self, name: &str) -> f64 {
        self.properties.get(&format!("axis0.{name}")).copied().unwrap_or(0.0)
    }

    fn error_name(&self) -> &'static str {
        if self.names == Names::New { "axis0.active_errors" } else { "axis0.error" }
    }

    fn watchdog_bit(&self) -> u64 {
        if self.names == Names::New { 1 << 24 } else { 0x800 }
    }

    /// The torque on its motor now, N m.
    pub fn torque(&self) -> f64 {
        let most = self.get("motor.config.torque_lim").max(self.get("config.torque_soft_max"));
        let most = if self.names == Names::Bare { f64::INFINITY } else { most };
        if self.state == 8 { self.set_point.clamp(-most, most) } else { 0.0 }
    }

    /// The angle as its encoder has it, rad.
    pub fn angle(&self) -> f64 {
        (self.plant.angle() / TAU * COUNTS).floor() / COUNTS * TAU
    }

    fn answer(&mut self, now: f64, text: &str, summed: bool) {
        self.answers += 1;
        let every = |n: u64, k: u64| n != 0 && k.is_multiple_of(n);
        let text = self.mischief.says.unwrap_or(text);
        let mut bytes: Vec<u8> = text.bytes().take(64).collect();
        if every(self.mischief.odd, self.answers) {
            bytes = b"unknown command".to_vec();
        }
        if summed && !self.mischief.no_checksum {
            let wrong = u8::from(every(self.mischief.bad_checksum, self.answers));
            let sum = xor(&bytes) ^ wrong;
            bytes.extend(format!("*{sum}").bytes());
        }
        bytes.extend(b"\r\n");
        bytes.truncate(64);
        if every(self.mischief.cut, self.answers) {
            bytes.truncate(bytes.len() / 2);
        }
        if every(self.mischief.garbage, self.answers) {
            bytes.splice(0..0, [0xff, 0x00, b'*', b'7', 0x80]);
        }
        let at = now + if every(self.mischief.late, self.answers) { 0.03 } else { 0.0 };
        if !self.mischief.mute {
            self.says.push_back((at, bytes));
        }
    }

    fn line(&mut self, line: &[u8], now: f64) {
        self.longest = self.longest.max(line.len());
        if self.mischief.echo {
            self.says.push_back((now, [line, b"\r\n"].concat()));
        }
        let line = line.split(|byte| *byte == b';').next().unwrap();
        let (words, summed) = match line.iter().position(|byte| *byte == b'*') {
            Some(star) => {
                let sum =
                    std::str::from_utf8(&line[star + 1..]).ok().and_then(|s| s.trim().parse::<u32>().ok());
                if sum != Some(u32::from(xor(&line[..star]))) {
                    return;
                }
                (&line[..star], true)
            }
            None => (line, false),
        };
        let text = String::from_utf8_lossy(words).into_owned();
        let parts: Vec<&str> = text.split_whitespace().collect();
        let axis: Option<u32> = parts.get(1).and_then(|word| word.parse().ok());
        let Some(letter) = text.chars().next() else { return };
        if !matches!(letter, 'c' | 'f' | 'u') {
            self.lines.push(text.trim().into());
        }
        match (letter, axis) {
            ('c' | 'f' | 'u', None) => self.answer(now, "invalid command format", summed),
            ('c' | 'f' | 'u', Some(axis)) if axis > 0 => {
                self.answer(now, &format!("invalid motor {axis}"), summed)
            }
            ('c', _) => match parts.get(2).and_then(|word| word.parse::<f64>().ok()) {
                Some(torque) => {
                    self.exchanges += 1;
                    self.properties
                        .entry("axis0.controller.config.control_mode".into())
                        .and_modify(|m| *m = 1.0);
                    (self.set_point, self.fed) = (torque, now);
                    self.note(now);
                }
                None => self.answer(now, "invalid command format", summed),
            },
            ('u', _) => self.fed = now,
            ('f', _) => {
                let (turns, speed) = (self.angle() / TAU, self.plant.speed() / TAU);
                self.answer(now, &format!("{turns:.6} {speed:.6}"), summed);
            }
            ('i', _) if self.names == Names::Bare => self.answer(now, "unknown command", summed),
            ('i', _) => {
                self.answer(now, "Hardware version: 3.6-56V", summed);
                self.answer(now, "Firmware version: 0.5.6", summed);
                self.answer(now, "Serial number: 336B31643536", summed);
            }
            ('s', _) if text.starts_with("sc") => self.error = 0,
            ('r', _) => self.read(parts.get(1).copied().unwrap_or(""), now, summed),
            ('w', _) => self.write(&parts, now, summed),
            _ => self.answer(now, "unknown command", summed),
        }
    }

    fn read(&mut self, name: &str, now: f64, summed: bool) {
        let text = match name {
            name if self.names == Names::Bare && !name.is_empty() => "invalid property".into(),
            name if name == self.error_name() => self.error.to_string(),
            "axis0.current_state" => self.state.to_string(),
            name => match self.properties.get(name) {
                Some(value) if name.ends_with("mode") || name.ends_with("enable_watchdog") => {
                    format!("{value:.0}")
                }
                Some(value) => format!("{value:.6}").chars().take(9).collect(),
                None => "invalid property".into(),
            },
        };
        self.answer(now, &text, summed);
    }

    fn write(&mut self, parts: &[&str], now: f64, summed: bool) {
        let (Some(name), Some(value)) =
            (parts.get(1), parts.get(2).and_then(|word| word.parse::<f64>().ok()))
        else {
            return self.answer(now, "invalid command format", summed);
        };
        let Some(property) = self.properties.get_mut(*name) else {
            return self.answer(now, "invalid property", summed);
        };
        *property = value;
        if name.ends_with("requested_state") {
            self.state = if self.error == 0 { value as i64 } else { 1 };
            self.note(now);
        }
    }

    /// Writes down what the motor makes.
    fn note(&mut self, now: f64) {
        let torque = self.torque();
        if self.made.last().is_some_and(|(_, last)| *last != torque) {
            self.made.push((now, torque));
        }
    }
}

impl Device for FakeODrive {
    fn hear(&mut self, bytes: &[u8], now: f64) {
        if self.mischief.stall.is_some_and(|(from, to)| (from..to).contains(&now)) {
            return;
        }
        for byte in bytes {
            if matches!(byte, b'\n' | b'\r' | b'!') {
                let line = std::mem::take(&mut self.held);
                self.line(&line, now);
            } else {
                self.held.push(*byte);
                assert!(self.held.len() <= 256, "longer than the board bears");
            }
        }
    }

    fn pass(&mut self, now: f64) -> Vec<u8> {
        if self.mischief.reset.take_if(|at| *at <= now).is_some() {
            (self.state, self.error, self.set_point) = (1, 0, 0.0);
            self.properties.entry("axis0.config.enable_watchdog".into()).and_modify(|on| *on = 0.0);
            self.held.clear();
            self.says.clear();
        }
        if let Some((_, error)) = self.mischief.fails.take_if(|(at, _)| *at <= now) {
            (self.error, self.state) = (self.error | error, 1);
        }
        while (self.steps as f64) < now * RATE {
            self.steps += 1;
            let at = self.steps as f64 / RATE;
            let timeout = self.get("config.watchdog_timeout");
            if self.get("config.enable_watchdog") != 0.0 && at - self.fed > timeout {
                self.error |= self.watchdog_bit();
            }
            if self.error != 0 {
                self.state = 1;
            }
            self.note(at);
            let hand = Hand { torque: self.hand, ..Hand::default() };
            let torque = self.torque();
            self.plant.step(torque, &hand);
        }
        let mut out = Vec::new();
        if self.mischief.stall.is_some_and(|(from, to)| (from..to).contains(&now)) {
            self.says.clear();
            self.spilled = now;
            return out;
        }
        let since = (now - self.spilled).max(0.0);
        self.spilled = now;
        out.resize((since * self.mischief.flood).round() as usize, b'7');
        for _ in 0..(since * self.mischief.chatter).round() as usize {
            out.extend(b"0.1 0.2*35\r\n");
        }
        while self.says.front().is_some_and(|(at, _)| *at <= now) {
            out.extend(self.says.pop_front().unwrap().1);
        }
        out
    }
}
