//! What a knob is, what it bears and what it did.

use super::turn::{Set, Turned};
use crate::cli::load::Loaded;
use crate::cli::paint::Paint;
use crate::cli::table::{Table, many};
use pacinian::knob::governor::device::Device;
use pacinian::knob::safety::chain::{Stage, Trip};
use pacinian::patch::Knob;
use serde::Serialize;
use std::collections::BTreeMap;

/// All of it.
#[derive(Debug, Serialize)]
pub struct Answer {
    patch: String,
    /// Hertz of the servo, and ticks from a reading to its torque.
    rate: f64,
    delay_ticks: f64,
    /// kg m², N m s/rad, N m, counts a turn, N m.
    inertia: f64,
    damping: f64,
    friction: Option<f64>,
    counts: f64,
    peak_torque: f64,
    /// Peak torque over friction.
    dynamic_range: Option<f64>,
    effects: Vec<String>,
    stiffness: Share,
    damping_asked: Share,
    /// What binds, and what would lift it.
    binds: Option<String>,
    seconds: f64,
    /// How often each trigger set off its voice.
    set_off: BTreeMap<String, usize>,
    /// Each of them, with its seconds.
    events: Vec<Set>,
    /// Of the knob, rad.
    least_angle: f64,
    most_angle: f64,
    /// rad/s.
    most_speed: f64,
    /// Root-mean-square error of the estimated speed, rad/s.
    speed_error: f64,
    /// N m.
    most_torque: f64,
    /// Joules that went into the virtual world, and that it gave more than it was given, at most.
    absorbed: f64,
    created: f64,
    /// In how many ticks each stage of the chain of safety acted.
    held_back: BTreeMap<&'static str, u64>,
    tripped: Option<&'static str>,
}

/// What was asked for, and what was granted.
#[derive(Debug, Serialize)]
struct Share {
    asked: f64,
    granted: f64,
}

const STAGES: [(Stage, &str); 8] = [
    (Stage::NonFinite, "no number"),
    (Stage::Governor, "governor"),
    (Stage::Slew, "slew"),
    (Stage::Budget, "heat budget"),
    (Stage::Peak, "peak"),
    (Stage::Stale, "stale reading"),
    (Stage::OverSpeed, "over-speed"),
    (Stage::Latch, "latched"),
];

impl Answer {
    /// Of a knob that was turned.
    pub fn new(loaded: &Loaded, knob: &Knob, turned: &Turned) -> Self {
        let plan = turned.player.plan();
        let device = plan.knob.as_ref().map(|knob| &knob.setup.device);
        let servo = turned.player.knob().map(|knob| knob.servo());
        let ask = servo.map(|servo| servo.demand()).unwrap_or_default();
        let governor = servo.map(|servo| servo.governor());
        let allowed = governor.map(|governor| governor.allow(&ask)).unwrap_or_default();
        let explained = governor.and_then(|governor| governor.explain(ask.damping).ok());
        let samples = &turned.course.samples;
        let most = |of: &dyn Fn(usize) -> f64| (0..samples.len()).map(of).fold(f64::NEG_INFINITY, f64::max);
        let squares: f64 = samples.iter().map(|s| (s.read[1] - s.speed).powi(2)).sum();
        let mut set_off = BTreeMap::new();
        for set in &turned.set_off {
            *set_off.entry(format!("{} plays {}", set.by, set.voice)).or_insert(0) += 1;
        }
        let chain = servo.map(|servo| servo.chain());
        let held = |stage: Stage| chain.map_or(0, |chain| chain.count(stage));
        Self {
            patch: loaded.name().into(),
            rate: device.map_or(0.0, |d| 1.0 / d.period),
            delay_ticks: device.map_or(0.0, |d| d.delay.total()),
            inertia: device.map_or(0.0, |d| d.inertia),
            damping: device.map_or(0.0, |d| d.damping),
            friction: device.and_then(|d| d.friction),
            counts: device.map_or(0.0, |d| std::f64::consts::TAU / d.count),
            peak_torque: device.map_or(0.0, |d| d.peak),
            dynamic_range: device.and_then(Device::dynamic_range),
            effects: knob.effects.iter().map(|effect| effect.name.clone()).collect(),
            stiffness: Share { asked: ask.stiffness, granted: ask.stiffness * allowed.stiffness },
            damping_asked: Share { asked: ask.damping, granted: ask.damping * allowed.damping },
            binds: explained.map(|explained| explained.to_string()),
            seconds: samples.len() as f64 / turned.course.rate,
            set_off,
            events: turned.set_off.clone(),
            least_angle: -most(&|n| -samples[n].angle),
            most_angle: most(&|n| samples[n].angle),
            most_speed: most(&|n| samples[n].speed.abs()),
            speed_error: (squares / samples.len().max(1) as f64).sqrt(),
            most_torque: most(&|n| samples[n].torque[1].abs()),
            absorbed: samples.last().map_or(0.0, |s| s.absorbed),
            created: most(&|n| -samples[n].absorbed).max(0.0),
            held_back: STAGES
                .iter()
                .map(|(stage, word)| (*word, held(*stage)))
                .filter(|(_, n)| *n > 0)
                .collect(),
            tripped: chain.and_then(|chain| chain.trip()).map(|trip| match trip {
                Trip::Reading => "the angle was no number",
                Trip::Lost => "readings failed",
                Trip::OverSpeed => "the knob was too fast",
                Trip::Panic => "somebody asked for it",
            }),
        }
    }

    /// For people.
    pub fn text(&self, paint: Paint) -> String {
        let mut table = Table::default();
        let friction = self.friction.map_or("unknown".into(), |f| format!("{} N m", short(f)));
        table.row([
            "  knob".into(),
            format!(
                "simulated: {} kg m2, friction {friction}, damping {} N m s/rad, {:.0} counts a turn",
                short(self.inertia),
                short(self.damping),
                self.counts
            ),
        ]);
        let range = match self.dynamic_range {
            Some(range) => format!("{range:.0} times friction ({:.0} dB)", 20.0 * range.log10()),
            None => "friction is not known, so neither is the dynamic range".into(),
        };
        table.row(["".into(), format!("{} N m at most, {range}", short(self.peak_torque))]);
        table.row(["  servo".into(), format!("{:.0} Hz, {} late", self.rate, many_ticks(self.delay_ticks))]);
        table.row(["  effects".into(), self.effects.join(", ")]);
        let share = |share: &Share, unit: &str| match share.granted < share.asked {
            true => format!("{} {unit}, held to {}", short(share.asked), short(share.granted)),
            false => format!("{} {unit}, granted", short(share.asked)),
        };
        table.row(["  they ask".into(), share(&self.stiffness, "N m/rad")]);
        if self.damping_asked.asked > 0.0 {
            table.row(["".into(), share(&self.damping_asked, "N m s/rad")]);
        }
        if let Some(binds) = &self.binds {
            table.row(["  it bears".into(), binds.clone()]);
        }
        table.row([
            "  turned".into(),
            format!(
                "{:.2} s, from {:.2} to {:.2} rad, {:.1} rad/s at most (estimated within {} rad/s rms)",
                self.seconds,
                self.least_angle,
                self.most_angle,
                self.most_speed,
                short(self.speed_error)
            ),
        ]);
        table.row(["  torque".into(), format!("{} N m at most", short(self.most_torque))]);
        let created = match self.created > 0.0 {
            true => format!("; {} J more than it was given, at most", short(self.created)),
            false => String::new(),
        };
        table.row(["  energy".into(), format!("{} J went into what is felt{created}", short(self.absorbed))]);
        for (n, (what, times)) in self.set_off.iter().enumerate() {
            let head = if n == 0 { "  set off" } else { "" };
            table.row([head.to_string(), format!("{what}: {}", many(*times, "time"))]);
        }
        for (n, (stage, ticks)) in self.held_back.iter().enumerate() {
            let head = if n == 0 { "  held back" } else { "" };
            table.row([head.to_string(), format!("{stage}: {}", many(*ticks as usize, "tick"))]);
        }
        if let Some(why) = self.tripped {
            table.row(["  torque is off".to_string(), paint.red(why)]);
        }
        format!("{}\n{}", paint.bold(&self.patch), table.text())
    }
}

fn many_ticks(ticks: f64) -> String {
    if ticks == 1.0 { "a tick".into() } else { format!("{ticks} ticks") }
}

/// A number as people read it: three digits.
fn short(x: f64) -> String {
    let size = x.abs();
    match () {
        () if size == 0.0 => "0".into(),
        () if (1e-3..1e4).contains(&size) => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{x:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_string()
            } else {
                text
            }
        }
        () => format!("{x:.2e}"),
    }
}
