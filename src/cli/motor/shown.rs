//! What `pacinian motor` says of a rumble motor, as people read it.

use super::super::paint::Paint;
use super::super::table::{Table, hertz};
use super::report::{Answer, EnergyReport, Wished};
use super::subject::Subject;
use super::written;
use pacinian::report::motion::Behind;

/// "12.3 ms".
pub fn ms(seconds: f64) -> String {
    if seconds != 0.0 && seconds.abs() < 1e-4 {
        format!("{:.1} us", 1e6 * seconds)
    } else {
        format!("{:.1} ms", 1e3 * seconds)
    }
}

fn or_none(value: Option<String>) -> String {
    value.unwrap_or_else(|| "-".into())
}

impl Answer {
    /// All of it.
    pub fn text(&self, subject: &Subject, behind: &[Behind], paint: Paint) -> String {
        let mut text = format!("{}: {}\n", paint.bold(&self.name), self.title);
        text += &self.about(subject);
        if self.wish.drive {
            text += &format!("\n{}\n", paint.bold("the course"));
            text += &self.table(&["drive"], paint);
        } else {
            let Wished { level, seconds, envelope, turns, .. } = self.wish;
            let most = self.motor.limit_volts;
            text += &format!(
                "\n{} of {} at level {level}, {envelope}, with {most} V at most\n",
                paint.bold("a burst"),
                ms(seconds)
            );
            text += &self.table(&["plain", "overdrive", "inverse", "switching"], paint);
            text += &format!(
                "\n{} of {turns} turns at {most} V, and a pulse of its length\n",
                paint.bold("a click")
            );
            text += &self.table(&["click", "pulse"], paint);
            if let Some([forward, backward, again]) = self.ways.iter().find_map(|way| way.click) {
                text += &format!(
                    "  {} forward, {} backward, {} forward for the coil\n",
                    ms(forward),
                    ms(backward),
                    ms(again)
                );
            }
        }
        if !behind.is_empty() {
            text += &format!("\n{} behind AC coupling\n", paint.bold("the click"));
            text += &self.behind(behind, paint);
            let most = subject.chain.map(|chain| chain.most());
            if let (Some(most), true) = (most, self.coupling.iter().any(|c| c.compensated.missing > 0.0)) {
                text += &format!(
                    "  what is missing has no room: card and amplifier give {most:.2} V at most; more of that, or a click at fewer --volts, helps\n"
                );
            }
        }
        text
    }

    fn about(&self, subject: &Subject) -> String {
        let m = &self.motor;
        let mut table = Table::default();
        table.row(["model".into(), self.model.to_string()]);
        table.row([
            "speed".into(),
            format!(
                "{:.0} rad/s, {:.0} turns a second, at {} V",
                m.rated_speed, m.turns_per_second, m.rated_volts
            ),
        ]);
        let on = match (m.mass, m.unit) {
            (_, "N") => " on what holds it; how much moves with it is not known".into(),
            (Some(mass), _) => format!(", {:.2} g, on {mass} kg", m.rated_vibration / 9.80665),
            (None, _) => format!(", {:.2} g", m.rated_vibration / 9.80665),
        };
        table.row(["vibration".into(), format!("{:.3} {}{on}", m.rated_vibration, m.unit)]);
        let coil = match subject.actuator.value("inductance") {
            Some(henries) if henries > 0.0 => ms(m.electrical_time),
            _ => "none to speak of, or not known,".into(),
        };
        table.row(["time".into(), format!("{} of the rotor, {coil} of the coil", ms(m.mechanical_time))]);
        let posture = match m.gravity {
            Some(gravity) => format!(", with {gravity:.2} m/s2 of gravity in its plane"),
            None => ", gravity aside".into(),
        };
        table.row(["starts".into(), format!("at {:.3} V{posture}", m.start_volts)]);
        let draws = match (m.running_amperes, m.standstill_amperes) {
            (Some(runs), Some(stands)) => {
                format!("{:.1} mA running, {:.1} mA at a standstill", 1e3 * runs, 1e3 * stands)
            }
            (_, Some(stands)) => format!(
                "{:.1} mA at a standstill; running not known: its torque constant is missing, so there are no torques and no joules",
                1e3 * stands
            ),
            _ => {
                "not known: resistance and torque constant are missing, so there are no amperes and no joules"
                    .into()
            }
        };
        table.row(["draws".into(), draws]);
        let assumed = match self.figures.assumed.as_slice() {
            [] => String::new(),
            assumed => format!("; nobody measured {}", assumed.join(", ")),
        };
        table.row(["figures".into(), format!("{}{assumed}", subject.known.text())]);
        let c = &self.computed;
        table.row([
            "computed".into(),
            format!(
                "at level {}, {}, for an error of {:e} of the speed{}",
                c.level,
                hertz(c.rate),
                c.wished_error,
                if c.reached { String::new() } else { format!(", of which {:.1e} are reached", c.error) }
            ),
        ]);
        for left in &c.left_out {
            table.row(["left out".into(), left.clone()]);
        }
        table.text()
    }

    fn table(&self, ways: &[&str], paint: Paint) -> String {
        let mut table = Table::default();
        let peak = format!("peak {}", self.motor.unit);
        let heads = [
            "", "to 50 %", "to 90 %", &peak, "at", "stop", "error", "turns", "mJ in", "coil", "friction",
            "ahead",
        ];
        table.row(heads.map(|head| paint.dim(head)));
        let mut text = String::new();
        for way in self.ways.iter().filter(|way| ways.contains(&way.way)) {
            if let Some(why) = &way.why {
                text += &format!("  {}: {}\n", way.way, paint.yellow(why));
                continue;
            }
            let energy = |of: fn(&EnergyReport) -> f64| {
                or_none(way.energy.as_ref().map(|energy| format!("{:.3}", 1e3 * of(energy))))
            };
            table.row([
                way.way.into(),
                or_none(way.rise_50.map(ms)),
                or_none(way.rise_90.map(ms)),
                or_none(way.peak.map(|peak| format!("{peak:.3}"))),
                or_none(way.peak_at.map(ms)),
                way.stop.map_or("goes on".into(), ms),
                or_none(way.error.map(|error| format!("{:.1} %", 100.0 * error))),
                or_none(way.turns.map(|turns| format!("{turns:.2}"))),
                energy(|e| e.supplied),
                energy(|e| e.coil_heat),
                energy(|e| e.friction),
                or_none(way.look_ahead.filter(|ahead| *ahead > 0.0).map(ms)),
            ]);
        }
        table.text() + &text
    }

    fn behind(&self, behind: &[Behind], paint: Paint) -> String {
        let mut table = Table::default();
        let heads =
            ["corner", "", "missing", "worst", "outside", "turns", "speed left", "stop", "lead", "discharge"];
        table.row(heads.map(|head| paint.dim(head)));
        for (report, behind) in self.coupling.iter().zip(behind) {
            for (name, arrival, compensated) in
                [("plain", &report.plain, false), ("compensated", &report.compensated, true)]
            {
                let only = |seconds: f64| if compensated { ms(seconds) } else { "-".into() };
                let missing = match arrival.missing {
                    0.0 => "nothing".into(),
                    share if compensated => paint.yellow(&format!("{:.1} %", 100.0 * share)),
                    share => format!("{:.1} %", 100.0 * share),
                };
                table.row([
                    if compensated { String::new() } else { written::corners(&behind.corners) },
                    name.into(),
                    missing,
                    format!("{:.3} V", arrival.worst_volts),
                    format!("{:.3} V", arrival.outside_volts),
                    format!("{:.3}", arrival.turns),
                    format!("{:.1} %", 100.0 * arrival.speed_left),
                    arrival.stop.map_or("goes on".into(), ms),
                    only(report.lead),
                    only(report.tail),
                ]);
            }
        }
        table.text()
    }
}
