//! What `pacinian motor` says of an actuator with a coil.

use super::super::check::json;
use super::super::even::EvenReport;
use super::super::failure::Failure;
use super::super::paint::Paint;
use super::super::problems;
use super::super::table::Table;
use super::super::terminal::Terminal;
use super::shown::ms;
use super::subject::Subject;
use super::{Motor, response, usage};
use pacinian::actuator::coil::equaliser::Equaliser;
use pacinian::actuator::coil::resonance::Resonance;
use pacinian::actuator::drive::Drive;
use pacinian::io::out;
use pacinian::report::motion::coil::{Shake, Tone, acceleration, evened, shakes, tones};
use pacinian::report::plot::{Column, Curve, Panel, Strips};
use pacinian::text::Problem;
use serde::Serialize;
use std::fmt::Write;

/// Frequencies that are told, Hz.
const TOLD: [f64; 10] = [30.0, 60.0, 100.0, 150.0, 200.0, 250.0, 300.0, 400.0, 600.0, 1000.0];

/// Everything there is to say.
#[derive(Debug, Serialize)]
struct Answer {
    name: String,
    title: String,
    model: &'static str,
    rated_volts: Option<f64>,
    limit_volts: Option<f64>,
    /// With shorted terminals, and with open ones; null where there is no spring.
    shorted: Option<Pole>,
    open: Option<Pole>,
    /// Acceleration at the shorted resonance with the rated volts, m/s².
    rated_acceleration: Option<f64>,
    origins: std::collections::BTreeMap<&'static str, usize>,
    from_the_rig: usize,
    assumed: Vec<&'static str>,
    response: Vec<ToneReport>,
    equaliser: Option<EvenReport>,
    length: f64,
    bursts: Vec<BurstReport>,
    /// Why there are no bursts, or no equaliser.
    why: Vec<String>,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Pole {
    hertz: f64,
    q: f64,
    /// Until the amplitude has fallen to 1/e, s.
    decay: f64,
}

/// For each volt.
#[derive(Debug, Serialize)]
struct ToneReport {
    hertz: f64,
    acceleration: f64,
    displacement: f64,
    amperes: f64,
    /// Gain of the equaliser there, dB.
    equaliser_db: Option<f64>,
}

#[derive(Debug, Serialize)]
struct BurstReport {
    way: &'static str,
    rise_90: Option<f64>,
    stop: f64,
    peak: f64,
    left: f64,
    /// Joules that the drive supplied.
    energy: f64,
}

/// Computes and says it.
pub fn run(asked: &Motor, subject: &Subject, terminal: &Terminal) -> Result<(), Failure> {
    let of_motors = [
        (asked.drive.is_some(), "--drive"),
        (asked.turns.is_some(), "--turns"),
        (asked.level.is_some(), "--level"),
        (asked.envelope.is_some(), "--envelope"),
        (asked.error.is_some(), "--error"),
        (asked.tilt.is_some(), "--tilt"),
        (asked.angle.is_some(), "--angle"),
        (!asked.coupling.is_empty(), "--coupling"),
    ];
    if let Some((_, option)) = of_motors.iter().find(|(given, _)| *given) {
        let what = format!(
            "{option} is of rumble motors, and {} is of model {}",
            subject.name,
            subject.actuator.model.word()
        );
        return Err(Failure::usage(what, format!("leave {option} out")));
    }
    subject.complete()?;
    let plant = subject.actuator.coil().map_err(|lack| subject.impossible(&lack))?;
    if let Some(what) = asked.beyond(subject) {
        terminal.note(&problems::sentence(&Problem::warning(&(0..0), what), terminal));
    }
    let rate = asked.rate(subject);
    let (limit, mut why) = (asked.volts.or(subject.limit), Vec::new());
    let bears = subject.actuator.value("rated_volts").or(limit);
    let rated = bears.map(|rated| limit.map_or(rated, |limit| rated.min(limit)));
    let shorted = plant.resonance(Drive::Voltage);
    let own = shorted.map(|pole| pole.hertz).filter(|hertz| (1.0..=1e4).contains(hertz));
    let mut told: Vec<f64> = TOLD.iter().copied().chain(own).collect();
    told.sort_by(f64::total_cmp);
    let told = tones(&plant, &told).map_err(|f| usage(&f))?;
    let bursts = match rated.zip(limit) {
        Some((rated, most)) => match shakes(&plant, [rated, most], asked.seconds, rate) {
            Ok(bursts) => bursts,
            Err(fault) if ["length", "rate"].contains(&fault.field) => return Err(usage(&fault)),
            Err(fault) => {
                why.push(format!("no bursts: {fault}"));
                Vec::new()
            }
        },
        None => {
            why.push("no bursts: nothing says how many volts it bears; --volts V does".into());
            Vec::new()
        }
    };
    let limits = subject.actuator.limits();
    let even = rated.map(|rated| evened(&plant, rated, &limits));
    let even = even.and_then(|even| even.map_err(|fault| why.push(format!("no equaliser: {fault}"))).ok());
    if let Some(path) = &asked.plot {
        out::write(path, picture(subject, asked.seconds, &bursts, rate).svg().as_bytes())?;
    }
    if let Some(path) = &asked.response {
        let chart = response::chart(subject, &plant, even.as_ref()).map_err(|f| usage(&f))?;
        out::write(path, chart.svg().as_bytes())?;
    }
    if let Some(path) = &asked.csv {
        out::write(path, csv(&bursts, rate).as_bytes())?;
    }
    let answer = Answer {
        name: subject.name.clone(),
        title: subject.title.clone(),
        model: subject.actuator.model.word(),
        rated_volts: rated,
        limit_volts: limit,
        shorted: shorted.map(Pole::of),
        open: plant.resonance(Drive::Current).map(Pole::of),
        rated_acceleration: shorted.zip(rated).map(|(pole, rated)| rated * acceleration(&plant, pole.hertz)),
        origins: subject.known.origins.clone(),
        from_the_rig: subject.known.by_rig,
        assumed: subject.known.assumed.clone(),
        response: told.iter().map(|tone| ToneReport::new(tone, even.as_ref())).collect(),
        equaliser: even.as_ref().map(EvenReport::new),
        length: asked.seconds,
        bursts: bursts.iter().map(BurstReport::new).collect(),
        why,
    };
    let text = if asked.json { json(&answer) } else { answer.text(subject, terminal.out) };
    terminal.print(&text)
}

impl Pole {
    fn of(pole: Resonance) -> Self {
        Self { hertz: pole.hertz, q: pole.q, decay: pole.decay() }
    }
}

impl ToneReport {
    fn new(tone: &Tone, even: Option<&Equaliser>) -> Self {
        Self {
            hertz: tone.hertz,
            acceleration: tone.acceleration,
            displacement: tone.displacement,
            amperes: tone.current,
            equaliser_db: even.map(|even| 20.0 * even.response(tone.hertz).abs().log10()),
        }
    }
}

impl BurstReport {
    fn new(shake: &Shake) -> Self {
        Self {
            way: shake.name,
            rise_90: shake.rise,
            stop: shake.stop,
            peak: shake.peak,
            left: shake.left,
            energy: shake.energy,
        }
    }
}

impl Answer {
    fn text(&self, subject: &Subject, paint: Paint) -> String {
        let mut text = format!("{}: {}\n", paint.bold(&self.name), self.title);
        let mut table = Table::default();
        table.row(["model", self.model]);
        for (name, pole) in [("shorted", self.shorted), ("open", self.open)] {
            let told = pole.map_or("no spring, no resonance".into(), |pole| {
                format!(
                    "resonance at {:.1} Hz, Q {:.2}, falls to 1/e in {}",
                    pole.hertz,
                    pole.q,
                    ms(pole.decay)
                )
            });
            table.row([name.into(), told]);
        }
        if let Some((volts, acceleration)) = self.rated_volts.zip(self.rated_acceleration) {
            let most = self.limit_volts.map_or(String::new(), |most| format!("; {most} V at most"));
            table.row([
                "rated".into(),
                format!("{acceleration:.2} m/s2 at the resonance with {volts} V{most}"),
            ]);
        }
        let assumed = match self.assumed.as_slice() {
            [] => String::new(),
            assumed => format!("; nobody measured {}", assumed.join(", ")),
        };
        table.row(["figures".into(), format!("{}{assumed}", subject.known.text())]);
        text += &table.text();

        text += &format!("\n{} for each volt\n", paint.bold("response"));
        let mut table = Table::default();
        table.row(["Hz", "m/s2", "um", "mA", "equaliser"].map(|head| paint.dim(head)));
        for tone in &self.response {
            table.row([
                format!("{:.1}", tone.hertz),
                format!("{:.4}", tone.acceleration),
                format!("{:.3}", 1e6 * tone.displacement),
                format!("{:.2}", 1e3 * tone.amperes),
                tone.equaliser_db.map_or("-".into(), |db| format!("{db:+.1} dB")),
            ]);
        }
        text += &table.text();
        if let Some(even) = &self.equaliser {
            text += &format!("  with the equaliser: {}\n", even.text());
        }
        if !self.bursts.is_empty() {
            text += &format!("\n{} of {} at the resonance\n", paint.bold("a burst"), ms(self.length));
            let mut table = Table::default();
            table.row(["", "to 90 %", "peak m/s2", "stop", "left", "energy mJ"].map(|head| paint.dim(head)));
            for burst in &self.bursts {
                table.row([
                    burst.way.into(),
                    burst.rise_90.map_or("-".into(), ms),
                    format!("{:.2}", burst.peak),
                    ms(burst.stop),
                    format!("{:.1} %", 100.0 * burst.left),
                    format!("{:.2}", 1e3 * burst.energy),
                ]);
            }
            text += &table.text();
        }
        for why in &self.why {
            text += &format!("  {}\n", paint.yellow(why));
        }
        text
    }
}

fn picture(subject: &Subject, length: f64, bursts: &[Shake], rate: f64) -> Strips {
    let panel = |label: &str, which: usize| {
        let curve = |shake: &Shake| Curve {
            name: shake.name.into(),
            rate,
            values: shake.traces[which].clone(),
            wanted: false,
        };
        Panel { label: label.into(), curves: bursts.iter().map(curve).collect() }
    };
    let over = bursts.iter().map(|shake| shake.stop).fold(0.0, f64::max);
    let column = Column {
        heading: format!("A burst of {} at the resonance", ms(length)),
        seconds: length + 1.25 * over,
        panels: vec![panel("drive (V)", 0), panel("acceleration (m/s2)", 1)],
    };
    let title = format!("{}: {}", subject.name, subject.title);
    Strips { title, subtitle: subject.known.text(), columns: vec![column] }
}

/// A line for each step: time, and volts and acceleration in each way.
fn csv(bursts: &[Shake], rate: f64) -> String {
    let mut text = String::from("seconds");
    for shake in bursts {
        let _ = write!(text, ",{0}_volts,{0}_m_per_s2", shake.name);
    }
    text.push('\n');
    let steps = bursts.iter().map(|shake| shake.traces[0].len()).max().unwrap_or(0);
    for n in 0..steps {
        let _ = write!(text, "{:.9}", (n + 1) as f64 / rate);
        for values in bursts.iter().flat_map(|shake| &shake.traces) {
            match values.get(n) {
                Some(value) => drop(write!(text, ",{value:.9}")),
                None => text.push(','),
            }
        }
        text.push('\n');
    }
    text
}
