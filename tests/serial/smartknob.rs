//! A simulated SmartKnob, with a simulated knob that its own firmware's law turns.

use pacinian::knob::plant::Plant;
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::parts::{Build, Hand};

use crate::cable::Device;
use crate::frames::{Field, fields, float, frame, nested, number, unframe};

/// Of its loop.
const RATE: f64 = 1_000.0;

/// Torque of its motor for a volt, N m: 4 volts a radian at a strength of 1 are then 0.1 N m/rad.
pub const PER_VOLT: f64 = 0.025;

/// What it is, as far as it moves.
#[derive(Debug, Clone, Default)]
struct Figures {
    position: i32,
    sub: f32,
    nonce: u64,
    min: i32,
    max: i32,
    width: f32,
    detent: f32,
    endstop: f32,
    snap: f32,
    bias: f32,
    text: Vec<u8>,
    detents: Vec<i32>,
}

/// How it misbehaves.
#[derive(Debug, Clone, Default)]
pub struct Mischief {
    /// It says back what it is told.
    pub echo: bool,
    /// It hears and says nothing from this time on, until that.
    pub stall: Option<(f64, f64)>,
    /// It starts anew at this time, with a second of plain text.
    pub reset: Option<f64>,
    /// So many acknowledgements are lost.
    pub lost_acks: u32,
    /// It acknowledges, and its motor refuses.
    pub refuses: bool,
    /// Its states say that it is what it was at first.
    pub hides: bool,
    /// It never acknowledges what it is to be.
    pub deaf: bool,
    /// Each frame of this number is damaged; 0 for none. Likewise: has garbage before it; is cut short.
    pub damaged: u64,
    pub garbage: u64,
    pub cut: u64,
    /// Bytes a second of no frame, and states a second beyond its own.
    pub flood: f64,
    pub chatter: f64,
    /// The version that it calls itself.
    pub version: i64,
}

pub struct FakeSmartKnob {
    pub mischief: Mischief,
    pub plant: Plant,
    /// A hand's torque on the knob, N m.
    pub hand: f64,
    /// Of the fork.
    pub fork: bool,
    /// It takes single bytes for commands.
    pub plain: bool,
    /// Those that it took while it did.
    pub commands: Vec<u8>,
    /// It was told to calibrate its motor.
    pub calibrated: bool,
    pub press: u8,
    /// Configurations that it took, by the bytes of their text.
    pub taken: Vec<Vec<u8>>,
    /// Nonces of the messages that came, and bytes before the first that was not 0.
    pub nonces: Vec<u64>,
    pub zeros: usize,
    figures: Figures,
    raw: Vec<u8>,
    pub position: i32,
    centre: f64,
    last: Option<u64>,
    held: Vec<u8>,
    says: Vec<u8>,
    steps: u64,
    frames: u64,
    spilled: f64,
    awake: f64,
    /// So many bytes are still lost when it has booted.
    deaf: usize,
    began: bool,
}

impl FakeSmartKnob {
    /// Radians from notch to notch, of what it is.
    pub fn width(&self) -> f64 {
        f64::from(self.figures.width)
    }

    pub fn new(fork: bool) -> Self {
        let parameters = Parameters { inertia: 4e-5, viscous: 4e-4, ..Parameters::default() };
        let plant = Plant::new(&Build { parameters, ..Build::default() }, RATE).unwrap();
        let mut knob = Self {
            mischief: Mischief { version: 1, ..Mischief::default() },
            plant,
            hand: 0.0,
            fork,
            plain: true,
            commands: Vec::new(),
            calibrated: false,
            press: 0,
            taken: Vec::new(),
            nonces: Vec::new(),
            zeros: 0,
            figures: Figures::default(),
            raw: Vec::new(),
            position: 0,
            centre: 0.0,
            last: None,
            held: Vec::new(),
            says: Vec::new(),
            steps: 0,
            frames: 0,
            spilled: 0.0,
            awake: 0.0,
            deaf: 0,
            began: false,
        };
        knob.demonstrate();
        knob
    }

    /// What it is when it starts: a free knob of its own.
    fn demonstrate(&mut self) {
        self.raw = [number(5, -1), float(6, 0.1745), float(8, 1.0), float(9, 1.1), nested(10, b"Unbounded")]
            .concat();
        self.figures = read(&self.raw).unwrap();
        (self.position, self.centre) = (0, self.plant.angle());
    }

    fn put(&mut self, message: &[u8]) {
        self.frames += 1;
        let every = |n: u64, k: u64| n != 0 && k.is_multiple_of(n);
        let mut bytes = frame(&[number(1, self.mischief.version), message.to_vec()].concat());
        if every(self.mischief.damaged, self.frames) {
            let at = bytes.len() / 2;
            bytes[at] = if bytes[at] == 7 { 9 } else { 7 };
        }
        if every(self.mischief.garbage, self.frames) {
            self.says.extend([0xff, 0x13, 0x00, 0x41, 0x02]);
        }
        if every(self.mischief.cut, self.frames) {
            bytes.truncate(bytes.len() / 2);
        }
        self.says.extend(bytes);
    }

    fn log(&mut self, words: &str) {
        let field = if self.fork { 5 } else { 3 };
        let level = if self.fork { number(2, 3) } else { Vec::new() };
        self.put(&nested(field, &[nested(1, words.as_bytes()), level].concat()));
    }

    fn state(&mut self) {
        let sub = ((self.plant.angle() - self.centre) / f64::from(self.figures.width)) as f32;
        let state = [
            number(1, i64::from(self.position)),
            float(2, sub),
            nested(3, if self.mischief.hides { &[0x30, 1] } else { &self.raw }),
            number(4, i64::from(self.press)),
        ];
        self.put(&nested(if self.fork { 6 } else { 4 }, &state.concat()));
    }

    fn message(&mut self, bytes: &[u8]) {
        let all = fields(bytes).unwrap_or_default();
        let find =
            |wanted: u64| all.iter().find(|(field, _)| *field == wanted).map(|(_, value)| value.clone());
        let nonce = match find(2) {
            Some(Field::Number(nonce)) => nonce,
            _ => 0,
        };
        let config = match find(4) {
            Some(Field::Bytes(raw)) => Some(raw),
            _ => None,
        };
        // What its small decoder cannot hold it does not even acknowledge.
        let parsed = config.as_ref().map(|raw| read(raw));
        let decodes = match &parsed {
            Some(Some(figures)) => {
                figures.text.len() <= 50 && figures.detents.len() <= 5 && figures.nonce < 256
            }
            Some(None) => false,
            None => true,
        };
        if !decodes || (self.mischief.deaf && config.is_some()) {
            return self.log("cannot decode");
        }
        self.nonces.push(nonce);
        if self.mischief.lost_acks > 0 && config.is_some() {
            self.mischief.lost_acks -= 1;
        } else {
            self.put(&nested(if self.fork { 4 } else { 2 }, &number(1, nonce as i64)));
        }
        if self.last.replace(nonce) == Some(nonce) {
            return;
        }
        match (config, parsed.flatten()) {
            (Some(raw), Some(figures)) => self.become_this(raw, figures),
            _ => self.state(),
        }
    }

    fn become_this(&mut self, raw: Vec<u8>, new: Figures) {
        if self.mischief.refuses || new.detent < 0.0 || new.endstop < 0.0 || new.snap < 0.5 || new.bias < 0.0
        {
            return self.log("Ignoring invalid config");
        }
        let old = std::mem::replace(&mut self.figures, new.clone());
        self.raw = raw;
        self.taken.push(new.text.clone());
        if (old.position, old.sub, old.nonce) != (new.position, new.sub, new.nonce) {
            self.position = new.position;
            self.centre = self.plant.angle() - f64::from(new.sub) * f64::from(new.width);
        }
        if new.max >= new.min {
            self.position = self.position.clamp(new.min, new.max);
        }
        self.state();
    }

    /// Volts that its firmware gives.
    fn volts(&mut self) -> f64 {
        let Figures { min, max, width, detent, endstop, snap, ref detents, .. } = self.figures;
        let (width, bounded) = (f64::from(width), max >= min);
        let away = self.plant.angle() - self.centre;
        let reach = width * f64::from(snap);
        if away > reach && (!bounded || self.position < max) {
            (self.position, self.centre) = (self.position + 1, self.centre + width);
        } else if away < -reach && (!bounded || self.position > min) {
            (self.position, self.centre) = (self.position - 1, self.centre - width);
        }
        let away = self.plant.angle() - self.centre;
        let dead = (0.2 * width).min(1_f64.to_radians());
        let pull = away - away.clamp(-dead, dead);
        let beyond =
            bounded && ((self.position == max && away > 0.0) || (self.position == min && away < 0.0));
        let here = detents.is_empty() || detents.contains(&self.position);
        let strength = if beyond {
            endstop
        } else if here {
            detent
        } else {
            0.0
        };
        let narrow = ((8_f64.to_radians() - width) / 5_f64.to_radians()).clamp(0.0, 1.0);
        let damping = if detents.is_empty() { f64::from(detent) * (0.02 + 0.06 * narrow) } else { 0.0 };
        let speed = self.plant.speed();
        if speed.abs() > 60.0 {
            return 0.0;
        }
        (-4.0 * f64::from(strength) * pull - damping * speed).clamp(-5.0, 5.0)
    }
}

/// A configuration out of its bytes.
fn read(raw: &[u8]) -> Option<Figures> {
    let mut figures = Figures::default();
    for (field, value) in fields(raw)? {
        match (field, value) {
            (1, Field::Number(n)) => figures.position = n as i32,
            (2, Field::Float(x)) => figures.sub = x,
            (3, Field::Number(n)) => figures.nonce = n,
            (4, Field::Number(n)) => figures.min = n as i32,
            (5, Field::Number(n)) => figures.max = n as i32,
            (6, Field::Float(x)) => figures.width = x,
            (7, Field::Float(x)) => figures.detent = x,
            (8, Field::Float(x)) => figures.endstop = x,
            (9, Field::Float(x)) => figures.snap = x,
            (10, Field::Bytes(text)) => figures.text = text,
            (11, Field::Bytes(packed)) => {
                // As fields of their own, so that one reader of varints is enough.
                let mut rest = &packed[..];
                while !rest.is_empty() {
                    let length = rest.iter().position(|byte| *byte < 128)? + 1;
                    let one = fields(&[&[8], &rest[..length]].concat())?;
                    if let Field::Number(n) = one[0].1 {
                        figures.detents.push(n as i32);
                    }
                    rest = &rest[length..];
                }
            }
            (12, Field::Float(x)) => figures.bias = x,
            _ => {}
        }
    }
    Some(figures)
}

impl Device for FakeSmartKnob {
    fn hear(&mut self, bytes: &[u8], now: f64) {
        let stalled = self.mischief.stall.is_some_and(|(from, to)| (from..to).contains(&now));
        // What comes while it boots is not heard.
        if stalled || now < self.awake {
            return;
        }
        if self.mischief.echo {
            self.says.extend(bytes);
        }
        let lost = self.deaf.min(bytes.len());
        self.deaf -= lost;
        for byte in &bytes[lost..] {
            if !self.began {
                self.began = *byte != 0;
                self.zeros += usize::from(*byte == 0);
            }
            match (*byte, self.plain) {
                (0, true) => self.plain = false,
                (letter, true) => {
                    self.commands.push(letter);
                    self.calibrated |= letter == b'C';
                }
                (0, false) => {
                    let held = std::mem::take(&mut self.held);
                    match unframe(&held) {
                        Some(message) => self.message(&message),
                        None => self.log("a frame that is none"),
                    }
                }
                (byte, false) => {
                    self.held.push(byte);
                    assert!(self.held.len() <= 410, "longer than the knob bears");
                }
            }
        }
    }

    fn pass(&mut self, now: f64) -> Vec<u8> {
        if self.mischief.reset.take_if(|at| *at <= now).is_some() {
            self.demonstrate();
            (self.plain, self.last, self.awake, self.deaf) = (true, None, now + 1.0, 12);
            self.held.clear();
            self.says.clear();
            self.says
                .extend(b"ets Jun  8 2016 00:22:57\r\nrst:0x1 (POWERON_RESET)\r\nSmartKnob starting\r\n");
        }
        while (self.steps as f64) < now * RATE {
            self.steps += 1;
            let torque = self.volts() * PER_VOLT;
            self.plant.step(torque, &Hand { torque: self.hand, ..Hand::default() });
            if self.steps.is_multiple_of(5) && !self.plain {
                self.state();
            }
            if self.steps.is_multiple_of(400) && self.plain {
                self.says.extend(b"Position: 0\r\n");
            }
        }
        let since = (now - self.spilled).max(0.0);
        self.spilled = now;
        for _ in 0..(since * self.mischief.chatter).round() as usize {
            self.state();
        }
        let mut out = std::mem::take(&mut self.says);
        if self.mischief.stall.is_some_and(|(from, to)| (from..to).contains(&now)) {
            out.clear();
        }
        out.extend(std::iter::repeat_n(0x55, (since * self.mischief.flood).round() as usize));
        out
    }
}
