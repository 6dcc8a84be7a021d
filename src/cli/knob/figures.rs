//! What a knob is, and what it bears of what its effects ask.

use crate::cli::table::Table;
use pacinian::engine::knob::Knob;
use pacinian::graph::answer::Answer;
use pacinian::graph::knob::Start;
use pacinian::graph::plan::Plan;
use pacinian::knob::governor::device::Device;
use serde::Serialize;

/// All of it.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// Whether no knob is there.
    simulated: bool,
    /// Hertz of the servo.
    rate: f64,
    /// Ticks from a reading to its torque, beside the one for which torque is held.
    delay_ticks: f64,
    /// The same of what depends on the angle alone, where the line's own thread makes it; null: the same.
    local_ticks: Option<f64>,
    /// kg m².
    inertia: f64,
    /// Viscous friction under its drive, N m s/rad.
    damping: f64,
    /// Dry friction, N m; null where it is not known.
    friction: Option<f64>,
    /// Counts a turn, a count in rad, and the speed of a count a tick, rad/s.
    counts: f64,
    count: f64,
    count_speed: f64,
    /// N m, and for how many seconds from cold; null: for good.
    peak_torque: f64,
    peak_seconds: Option<f64>,
    /// Peak torque over dry friction.
    dynamic_range: Option<f64>,
    /// In the order in which they add up.
    effects: Vec<String>,
    /// N m/rad.
    stiffness: Share,
    /// N m s/rad.
    computed_damping: Share,
    /// The stiffest that it bears beside that damping, what binds, and what would lift it.
    bears: Option<String>,
    /// What it sets off, by what.
    sets_off: Vec<String>,
}

/// What is asked for, and what is granted.
#[derive(Debug, Serialize)]
struct Share {
    asked: f64,
    granted: f64,
}

/// What a start plays; a pattern some milliseconds later.
fn sets_off(plan: &Plan, Start { name, answer, .. }: &Start) -> String {
    match answer {
        Answer::Voice(voiced) => {
            let voice = plan.instruments.get(voiced.instrument as usize);
            format!("{name} plays {}", voice.map_or("", |i| &*i.name))
        }
        Answer::Pattern(started) => {
            let pattern = plan.answering.get(started.pattern as usize);
            let late = 1e3 * plan.answer as f64 / plan.engine_rate();
            format!("{name} plays pattern {} {late:.1} ms later", pattern.map_or("", |name| &**name))
        }
    }
}

impl Figures {
    /// Those of a plan's knob, as its effects are scaled now.
    pub fn new(plan: &Plan, knob: &Knob) -> Option<Self> {
        let of = plan.knob.as_ref()?;
        let (device, limits, servo) = (&of.setup.device, &of.setup.limits, knob.servo());
        // At the beginning nothing has scaled them yet.
        let ask = if servo.ticks() == 0 { of.bound() } else { servo.demand() };
        let allowed = servo.governor().allow(&ask);
        let most = device.peak / limits.continuous;
        Some(Self {
            simulated: of.model.is_some(),
            rate: 1.0 / device.period,
            delay_ticks: device.delay.total(),
            local_ticks: (device.delay.sooner() > 0).then(|| device.delay.spring()),
            inertia: device.inertia,
            damping: device.damping,
            friction: device.friction,
            // As they stand in the rig.
            counts: (std::f64::consts::TAU / device.count * 1e6).round() / 1e6,
            count: device.count,
            count_speed: device.count / device.period,
            peak_torque: device.peak,
            peak_seconds: (most > 1.0).then(|| -limits.winding * (-1.0 / (most * most)).ln_1p()),
            dynamic_range: Device::dynamic_range(device),
            effects: of.names.iter().map(ToString::to_string).collect(),
            stiffness: Share { asked: ask.stiffness, granted: ask.stiffness * allowed.stiffness },
            computed_damping: Share { asked: ask.damping, granted: ask.damping * allowed.damping },
            bears: servo.governor().explain(ask.damping).ok().map(|why| why.to_string()),
            sets_off: of.starts.iter().map(|start| sets_off(plan, start)).collect(),
        })
    }

    /// For people.
    pub fn rows(&self, table: &mut Table) {
        let friction = self.friction.map_or("unknown".into(), |f| format!("{} N m", short(f)));
        let (is, inertia) = (if self.simulated { "simulated" } else { "real" }, short(self.inertia));
        let damping = short(self.damping);
        table.row([
            "knob".into(),
            format!("{is}: {inertia} kg m2, dry friction {friction}, {damping} N m s/rad"),
        ]);
        let range = match self.dynamic_range {
            Some(range) => {
                format!("dynamic range {range:.0} ({:.0} dB): peak over friction", 20.0 * range.log10())
            }
            None => "its dynamic range is unknown, as nobody has measured its friction".into(),
        };
        let lasts = self.peak_seconds.map_or(String::new(), |s| format!(" for {} s from cold", short(s)));
        table.row(["torque".into(), format!("{} N m{lasts}; {range}", short(self.peak_torque))]);
        let counts = match self.counts > 1e7 {
            true => "the angle is known exactly".into(),
            false => format!(
                "{:.0} counts a turn, {} mrad each; one a tick is {} rad/s",
                self.counts,
                short(1e3 * self.count),
                short(self.count_speed)
            ),
        };
        table.row(["encoder".into(), counts]);
        let late = match self.delay_ticks == 0.0 {
            true => "torque follows within the tick".into(),
            false => format!("torque is {} ticks late", short(self.delay_ticks)),
        };
        let alone = |ticks: f64| format!("{late}, {} where it depends on the angle alone", short(ticks));
        let late = self.local_ticks.map_or(late.clone(), alone);
        table.row(["servo".into(), format!("{:.0} Hz, {late}", self.rate)]);
        table.row(["effects".into(), self.effects.join(", ")]);
        let share = |share: &Share, unit: &str| match share.granted < share.asked {
            true => format!("{} {unit}, held to {}", short(share.asked), short(share.granted)),
            false => format!("{} {unit}, granted", short(share.asked)),
        };
        let mut asks = share(&self.stiffness, "N m/rad");
        if self.computed_damping.asked > 0.0 {
            asks = format!("{asks}; {}", share(&self.computed_damping, "N m s/rad"));
        }
        table.row(["they ask for".into(), asks]);
        for (n, part) in self.bears.iter().flat_map(|bears| bears.split("; ")).enumerate() {
            table.row([if n == 0 { "it bears".into() } else { String::new() }, part.to_string()]);
        }
        for (n, what) in self.sets_off.iter().enumerate() {
            table.row([if n == 0 { "sets off".into() } else { String::new() }, what.clone()]);
        }
    }
}

/// A number as people read it: three digits.
pub fn short(x: f64) -> String {
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

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.15, "0.15"),
            (2.1e-3, "0.0021"),
            (8e-6, "8.00e-6"),
            (2.7384, "2.74"),
            (71.43, "71.4"),
            (1234.5, "1234"),
            (-0.5, "-0.5"),
            (1e9, "1.00e9"),
        ] {
            assert_eq!(short(x), text);
        }
    }
}
