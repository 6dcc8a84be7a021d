//! A force-feedback knob, `[knob]`: what it is, and what it must keep to.

pub mod controller;
pub mod made;
pub mod motor;
pub(crate) mod sensor;
pub mod table;

use super::{Device, OutputKind, Rig};
use crate::knob::angle::decoder::Sensor;
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::{Harmonic, Wave};
use crate::knob::velocity::choice::Choice;
use crate::text::field::Form;
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::{Problem, Span};
use controller::Controller;
use table::{FIELDS, HARMONIC, OUTPUT};

/// A knob. Figures in SI; angles are radians, torques newton metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// The motor that it has, of those that ship.
    pub motor: Option<&'static str>,
    /// Of the motor's side.
    pub inertia: f64,
    /// Of the knob on it; 0: none, or counted with the motor.
    pub knob_inertia: f64,
    /// Bearings.
    pub viscous: f64,
    /// What a short circuit adds.
    pub viscous_shorted: f64,
    /// Dry friction, if it is known.
    pub friction: Option<f64>,
    /// Dry friction at rest.
    pub stiction: f64,
    /// The most torque.
    pub peak: f64,
    /// What it bears for good.
    pub continuous: f64,
    /// The winding: N m/A, ohms, henries, volts of its supply, where all are known.
    pub winding: Option<[f64; 4]>,
    /// What the amplifier imposes.
    pub drive: Imposed,
    /// Seconds in which the winding warms.
    pub winding_time: f64,
    /// Seconds in which the housing does, if it is known.
    pub housing_time: Option<f64>,
    /// Hertz of the motor against its shaft, with the knob clamped, and the shaft's damping.
    pub resonance: Option<(f64, f64)>,
    /// Counts a turn; `None`: the angle is known exactly.
    pub counts: Option<f64>,
    /// Torque that the motor makes by itself.
    pub cogging: Wave,
    /// By what share its torque constant is larger than on the mean.
    pub ripple: Wave,
    /// Whether both are made up for.
    pub compensate: bool,
    /// Where it ends.
    pub stops: Option<Stops>,
    /// Hertz that its servo is to have.
    pub rate: f64,
    /// Seconds from the angle to its torque, if they were measured.
    pub delay: Option<f64>,
    /// What reads its angle; `None`: it is simulated.
    pub sensor: Option<Sensor>,
    /// The serial line that it is on. Its angle is heard as `sensor` says.
    pub controller: Option<Controller>,
    /// How speed is estimated.
    pub velocity: Choice,
    /// The share of the edge of stability that is granted.
    pub margin: f64,
    /// The passivity controller's cap; 0: it watches.
    pub passivity: f64,
    /// N m/s.
    pub slew: f64,
    /// Hertz of a low-pass on the torque.
    pub reconstruction: Option<f64>,
    /// Seconds in which torque rises, for which a reading may be missing, and in which torque falls then.
    pub soft_start: f64,
    /// See `soft_start`.
    pub stale: f64,
    /// See `soft_start`.
    pub release: f64,
    /// rad/s at which torque goes off.
    pub over_speed: f64,
    /// The output that it leaves by, and the torque of a sample of 1.0.
    pub output: Option<(String, f64)>,
    /// Where it stands.
    pub span: Span,
}

/// What an amplifier imposes on a knob's motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Imposed {
    /// The torque.
    Torque,
    /// A current, by a loop of so many hertz.
    Current(f64),
    /// A voltage.
    Voltage,
}

impl Default for Knob {
    /// A small one of a rig that says nothing: as one holds it between two fingers, with an encoder of 1000 lines.
    fn default() -> Self {
        Self {
            motor: None,
            inertia: 8e-6,
            knob_inertia: 0.0,
            viscous: 1e-4,
            viscous_shorted: 0.0,
            friction: Some(1e-3),
            stiction: 1.2e-3,
            peak: 0.15,
            continuous: 0.03,
            winding: None,
            drive: Imposed::Torque,
            winding_time: 12.0,
            housing_time: None,
            resonance: None,
            counts: Some(4000.0),
            cogging: Wave::default(),
            ripple: Wave::default(),
            compensate: false,
            stops: None,
            rate: 8000.0,
            delay: None,
            sensor: None,
            controller: None,
            velocity: Choice::Adaptive(0.01),
            margin: crate::knob::governor::MARGIN,
            passivity: 0.0,
            slew: 1000.0,
            reconstruction: None,
            soft_start: 0.3,
            stale: 0.005,
            release: 0.05,
            over_speed: 60.0,
            output: None,
            span: 0..0,
        }
    }
}

/// A figure of the rig, else of the motor.
struct Figures<'a, 'b> {
    reader: &'a Reader<'b>,
    motor: Option<&'static motor::Motor>,
}

impl Figures<'_, '_> {
    fn known(&self, key: &str) -> Option<f64> {
        let is_count =
            FIELDS.iter().any(|field| field.key == key && matches!(field.form, Form::Count { .. }));
        if self.reader.has(key) {
            return if is_count { self.reader.count(key).map(|n| n as f64) } else { self.reader.number(key) };
        }
        self.motor.and_then(|motor| motor.values.get(key)).map(|value| value.value)
    }

    fn or_default(&self, key: &str) -> f64 {
        self.known(key).unwrap_or_else(|| self.reader.number_or_default(key))
    }
}

pub(super) fn read(reader: &Reader) -> Knob {
    let plain = Knob::default();
    let motor = reader.text("motor").and_then(|name| {
        let found = motor::find(name);
        if found.is_none() {
            let what = format!("{} has a motor `{name}`, which does not ship with pacinian", reader.who);
            let help = suggest(name, motor::all().iter().map(|motor| motor.name))
                .unwrap_or_else(|| "give its figures instead: inertia, peak_torque, ...".into());
            reader.sink.push(Problem::error(&reader.span_of("motor"), what).help(help));
        }
        found
    });
    let figures = Figures { reader, motor };
    let needed = |key: &str| {
        let value = figures.known(key);
        if value.is_none() && !reader.has(key) && !reader.has("motor") {
            let what = format!("{} has no motor and lacks `{key}`", reader.who);
            let help = "name one that ships, motor = \"pittman-8693\", or say what yours has".to_string();
            reader.sink.push(Problem::error(&reader.span, what).help(help));
        }
        value
    };
    let inertia = needed("inertia").unwrap_or(plain.inertia);
    let peak = needed("peak_torque").unwrap_or(plain.peak);
    let friction = figures.known("friction");
    let winding = ["torque_constant", "resistance", "inductance", "supply"].map(|key| figures.known(key));
    let drive = match reader.word("drive") {
        1 => Imposed::Current(reader.number_or_default("current_bandwidth")),
        2 => Imposed::Voltage,
        _ => Imposed::Torque,
    };
    let counts = match (reader.has("lines"), reader.count("lines")) {
        (true, lines) => lines.map(|lines| 4.0 * lines as f64),
        (false, _) => figures.known("counts"),
    };
    let sensor = reader.one("sensor", format!("`sensor` of {}", reader.who));
    let sensor = sensor.and_then(|of| sensor::read(&of, counts));
    let controller = reader.one("controller", format!("`controller` of {}", reader.who));
    let controller = controller.and_then(|of| controller::read(&of));
    let knob = Knob {
        motor: motor.map(|motor| motor.name),
        inertia,
        knob_inertia: figures.known("knob_inertia").unwrap_or(0.0),
        viscous: figures.known("viscous").unwrap_or(0.0),
        viscous_shorted: figures.known("viscous_shorted").unwrap_or(0.0),
        friction,
        stiction: figures.known("stiction").or(friction).unwrap_or(0.0),
        peak,
        continuous: figures.known("continuous_torque").unwrap_or(0.2 * peak),
        winding: match winding {
            [Some(k), Some(r), Some(l), Some(v)] => Some([k, r, l, v]),
            _ => None,
        },
        drive,
        winding_time: figures.or_default("winding_time"),
        housing_time: figures.known("housing_time"),
        resonance: figures.known("resonance").map(|hertz| (hertz, reader.number_or_default("shaft_damping"))),
        counts: counts.or_else(|| sensor.as_ref().and_then(sensor::counts)),
        cogging: wave(reader, "cogging"),
        ripple: wave(reader, "ripple"),
        compensate: reader.flag("compensate"),
        stops: stops(reader),
        rate: reader.number_or_default("rate"),
        delay: reader.number("delay"),
        sensor: controller.as_ref().map(Controller::sensor).or(sensor),
        controller,
        velocity: match reader.word("velocity") {
            1 => Choice::Kalman(reader.number_or_default("acceleration")),
            2 => Choice::Filtered(reader.number_or_default("velocity_corner")),
            3 => Choice::Difference,
            _ => Choice::Adaptive(reader.number_or_default("velocity_window")),
        },
        margin: reader.number_or_default("margin"),
        passivity: reader.number_or_default("passivity"),
        slew: reader.number_or_default("slew"),
        reconstruction: reader.number("reconstruction"),
        soft_start: reader.number_or_default("soft_start"),
        stale: reader.number_or_default("stale"),
        release: reader.number_or_default("release"),
        over_speed: reader.number_or_default("over_speed"),
        output: output(reader),
        span: reader.span.clone(),
    };
    contradictions(&knob, reader);
    knob
}

/// The key of what the model calls so; where it has none, the same.
fn key_of(field: &str) -> String {
    match field {
        "stop low" => "low".into(),
        "stop high" => "high".into(),
        other => other.replace(' ', "_"),
    }
}

/// What figures say of each other.
fn contradictions(knob: &Knob, reader: &Reader) {
    let wrong = |key: &str, what: String, help: &str| {
        let stands = reader.describes(key) && reader.has(key);
        let span = if stands { reader.span_of(key) } else { reader.span.clone() };
        reader.sink.push(Problem::error(&span, format!("{}: {what}", reader.who)).help(help.to_string()));
    };
    if knob.continuous > knob.peak {
        let what = format!(
            "`continuous_torque` {} N m is more than `peak_torque` {} N m",
            knob.continuous, knob.peak
        );
        wrong("continuous_torque", what, "the peak is what it bears for a short time");
    }
    if let Some(friction) = knob.friction {
        if knob.stiction < friction {
            let what = format!("`stiction` {} N m is less than `friction` {friction} N m", knob.stiction);
            wrong("stiction", what, "what holds it at rest is what slows it, or more");
        }
        if friction >= knob.peak {
            let what = format!(
                "`friction` {friction} N m is not below `peak_torque` {} N m: nothing would be felt",
                knob.peak
            );
            wrong("friction", what, "both are in newton metres");
        }
    }
    if reader.has("controller") {
        for (key, does) in
            [("sensor", "the angle comes by its line"), ("output", "the torque leaves by its line")]
        {
            if reader.has(key) {
                let what = format!("`{key}` and `controller` say two ways of one knob: {does}");
                wrong(key, what, "leave one of them out");
            }
        }
    }
    if reader.has("counts") && reader.has("lines") {
        wrong(
            "lines",
            "`counts` and `lines` say the same".into(),
            "leave one of them out: a line has four counts",
        );
    }
    if knob.drive != Imposed::Torque && knob.winding.is_none() {
        let what =
            "`drive` needs the winding: torque_constant, resistance, inductance and supply".to_string();
        wrong("drive", what, "give all four, or leave `drive` out: then the torque is there at once");
    }
    for (key, of, is) in [
        ("current_bandwidth", "drive = \"current\"", matches!(knob.drive, Imposed::Current(_))),
        ("velocity_window", "velocity = \"adaptive\"", matches!(knob.velocity, Choice::Adaptive(_))),
        ("velocity_corner", "velocity = \"filtered\"", matches!(knob.velocity, Choice::Filtered(_))),
        ("acceleration", "velocity = \"kalman\"", matches!(knob.velocity, Choice::Kalman(_))),
        ("stop_stiffness", "`low` or `high`", knob.stops.is_some()),
        ("stop_damping", "`low` or `high`", knob.stops.is_some()),
        ("compensate", "`cogging` or `ripple`", !knob.cogging.is_flat() || !knob.ripple.is_flat()),
    ] {
        if reader.has(key) && !is {
            wrong(key, format!("`{key}` goes with {of}"), "leave it out");
        }
    }
    if knob.stops.is_some_and(|stops| stops.low >= stops.high) {
        wrong("high", "`high` is not above `low`".into(), "angles rise from the lower stop to the upper one");
    }
    if let Some([k, r, _, v]) = knob.winding
        && knob.drive != Imposed::Torque
        && v / r * k < 0.9 * knob.peak
    {
        let what = format!(
            "{}: `peak_torque` is {} N m, and {v} V over {r} ohm make {:.3} N m at a standstill",
            reader.who,
            knob.peak,
            v / r * k
        );
        let help = "more than that is never there; less, the faster it turns".to_string();
        reader.sink.push(Problem::warning(&reader.span, what).help(help));
    }
    let fast = match (knob.drive, knob.winding, knob.resonance) {
        (Imposed::Voltage, Some([_, r, l, _]), _) => Some(("its winding", r / l / std::f64::consts::TAU)),
        (_, _, Some((hertz, _))) if knob.knob_inertia > 0.0 => Some(("its shaft", hertz)),
        _ => None,
    };
    if let Some((what, hertz)) = fast.filter(|(_, hertz)| *hertz > 0.5 * knob.rate) {
        let what = format!(
            "{}: {what} moves at {hertz:.0} Hz, and a servo at {:.0} Hz does not see that",
            reader.who, knob.rate
        );
        let span = if reader.has("rate") { reader.span_of("rate") } else { reader.span.clone() };
        reader.sink.push(Problem::warning(&span, what).help("give a higher `rate`".to_string()));
    }
    // Which friction holds it, and where its stops are, was told above.
    let told = |field: &str| match field {
        "stiction" => knob.friction.is_some_and(|f| knob.stiction < f),
        "stop high" => knob.stops.is_some_and(|stops| stops.low >= stops.high),
        _ => false,
    };
    if let Err(fault) = made::build(knob).check()
        && !told(fault.field)
    {
        wrong(&key_of(fault.field), fault.to_string(), "it cannot be simulated so");
    }
}

fn stops(reader: &Reader) -> Option<Stops> {
    if !reader.has("low") && !reader.has("high") {
        return None;
    }
    Some(Stops {
        low: reader.number("low").unwrap_or(f64::NEG_INFINITY),
        high: reader.number("high").unwrap_or(f64::INFINITY),
        stiffness: reader.number_or_default("stop_stiffness"),
        damping: reader.number_or_default("stop_damping"),
    })
}

fn wave(reader: &Reader, key: &str) -> Wave {
    let Some(value) = reader.at(key) else { return Wave::default() };
    let Some(list) = value.list() else {
        reader.mistaken(key, &value, "a list of harmonics: [{ periods = 7, amplitude = 0.002 }]");
        return Wave::default();
    };
    let mut harmonics = Vec::new();
    for (n, entry) in list.enumerate() {
        let Some(table) = entry.table() else {
            reader.mistaken(key, &entry, "a harmonic: { periods = 7, amplitude = 0.002 }");
            continue;
        };
        let who = format!("harmonic {} of `{key}` of {}", n + 1, reader.who);
        let of = Reader::new(&HARMONIC, table, entry.span(), who, reader.sink);
        let (Some(periods), Some(amplitude)) = (of.count("periods"), of.number("amplitude")) else {
            continue;
        };
        let phase = of.number_or_default("phase");
        harmonics.push(Harmonic {
            periods: periods as f64,
            sine: amplitude * phase.cos(),
            cosine: amplitude * phase.sin(),
        });
    }
    Wave::new(&harmonics).unwrap_or_else(|fault| {
        reader.wrong(key, &value, &fault.to_string());
        Wave::default()
    })
}

fn output(reader: &Reader) -> Option<(String, f64)> {
    let value = reader.at("output")?;
    let Some(table) = value.table() else {
        reader.mistaken(
            "output",
            &value,
            "an output and its torque: { name = \"knob\", newton_metres = 0.15 }",
        );
        return None;
    };
    let of = Reader::new(&OUTPUT, table, value.span(), format!("`output` of {}", reader.who), reader.sink);
    Some((of.text("name")?.to_string(), of.number("newton_metres")?))
}

impl Rig {
    /// The channel (from 0) that a knob's torque leaves by, and the sample for 1 N m.
    pub fn torque_output(&self, knob: &Knob) -> Option<(u32, f64)> {
        let mut all = self.outputs.iter().filter(|output| output.kind == OutputKind::Torque);
        let (output, newton_metres) = match &knob.output {
            Some((name, newton_metres)) => (all.find(|output| output.name == *name)?, *newton_metres),
            None => (all.next()?, knob.peak),
        };
        let gain = if output.inverted { -output.gain } else { output.gain };
        Some((output.channel.checked_sub(1)?, gain / newton_metres))
    }

    /// What is wrong with the way by which torque leaves.
    pub(super) fn torque_way(&self) -> Vec<Problem> {
        let torques: Vec<_> =
            self.outputs.iter().filter(|output| output.kind == OutputKind::Torque).collect();
        let mut problems = Vec::new();
        if let Some((name, _)) = self.knob.as_ref().and_then(|knob| knob.output.as_ref())
            && !torques.iter().any(|output| output.name == *name)
        {
            let what =
                format!("the knob leaves by output `{name}`, and there is none of kind torque called so");
            let help =
                suggest(name, torques.iter().map(|output| output.name.as_str())).unwrap_or_else(|| {
                    format!("add one: [[output]] name = \"{name}\", kind = \"torque\", channel = ...")
                });
            let span = self.knob.as_ref().map(|knob| knob.span.clone()).unwrap_or_default();
            problems.push(Problem::error(&span, what).help(help));
        }
        if torques.len() > 1 && self.knob.as_ref().is_none_or(|knob| knob.output.is_none()) {
            let what = format!(
                "output `{}` is of kind torque as well as `{}`: a knob has one",
                torques[1].name, torques[0].name
            );
            let help = "say which: [knob] output = { name = ..., newton_metres = ... }".to_string();
            problems.push(Problem::error(&torques[1].span, what).help(help));
        }
        let Device { coupling, .. } = &self.device;
        if let Some(output) = torques.first()
            && let Some(super::Coupling::HighPass(hertz)) = coupling
        {
            let what = format!(
                "output `{}` is a torque, which is steady for as long as a hand pushes, and the device lets nothing steady through: its coupling is a high-pass at {hertz} Hz",
                output.name
            );
            let help = "a card with DC-coupled outputs passes it".to_string();
            problems.push(Problem::error(&output.span, what).help(help));
        }
        problems
    }
}
