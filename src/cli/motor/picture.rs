//! What a motor did, as a picture and as a table.

use super::shown::ms;
use pacinian::report::motion::{Bench, Done, Row, Way, Wish};
use pacinian::report::plot::{Column, Curve, Panel, Strips};
use std::fmt::Write;

/// Drive, speed and vibration of every way, with what is wanted: bursts beside clicks.
pub fn strips(title: &str, bench: &Bench, wish: Option<&Wish>, rows: &[Row], turns: f64) -> Strips {
    let of = |ways: &[Way]| -> Vec<(Way, &Done)> {
        let chosen = rows.iter().filter(|row| ways.contains(&row.way));
        chosen.filter_map(|row| Some((row.way, row.done.as_ref().ok()?))).collect()
    };
    let bursts = of(&[Way::Plain, Way::Overdrive, Way::Inverse, Way::Switching, Way::Own]);
    let clicks = of(&[Way::Click, Way::Pulse]);
    let heading = match wish {
        Some(wish) => {
            format!("A burst of {} at level {}, {}", ms(wish.seconds), wish.level, wish.envelope.word())
        }
        None => "The course".into(),
    };
    let mut columns = Vec::new();
    for (heading, all, wish) in [(heading, bursts, wish), (format!("A click of {turns} turns"), clicks, None)]
    {
        if !all.is_empty() {
            columns.push(column(heading, bench, wish, &all));
        }
    }
    let subtitle = format!(
        "time constant {}, {:.0} rad/s and {:.3} {} at {} V; amplitudes as they are felt",
        ms(bench.parameters.mechanical_time()),
        bench.parameters.rated_speed(),
        bench.rated(),
        bench.felt().unit(),
        bench.parameters.rated_volts
    );
    Strips { title: title.into(), subtitle, columns }
}

/// Of what goes on for long only so much is shown, as a share of what all the others take.
const LONGER: f64 = 1.25;

fn column(heading: String, bench: &Bench, wish: Option<&Wish>, all: &[(Way, &Done)]) -> Column {
    // Until the amplitude of every one is below a tenth, and a little longer.
    let over = all.iter().filter_map(|(_, done)| done.figures.felt.map(|[_, until]| until));
    let stands = all.iter().filter_map(|(_, done)| done.run.stands).fold(0.0, f64::max);
    let felt = over.fold(wish.map_or(0.0, |wish| wish.seconds), f64::max);
    let all_of_it =
        all.iter().map(|(_, done)| done.run.time(done.run.traces.speeds.len())).fold(0.0, f64::max);
    let seconds = if felt > 0.0 { LONGER * felt } else { all_of_it };
    let seconds = if stands > 0.0 { seconds.min(LONGER * stands) } else { seconds };
    let curve =
        |name: &str, values: Vec<f64>, wanted| Curve { name: name.into(), rate: bench.rate, values, wanted };
    let wanted = |to: &dyn Fn(f64) -> f64| {
        let at = |n: usize| (n + 1) as f64 / bench.rate;
        let steps = (seconds * bench.rate) as usize;
        wish.map(|wish| curve("wanted", (0..steps).map(|n| to(wish.at(at(n)))).collect(), true))
    };
    let top = bench.parameters.rated_speed();
    let panel = |label: String, of: fn(&Done) -> &Vec<f64>, wanted: Option<Curve>| {
        let curves = all.iter().map(|(way, done)| curve(way.word(), of(done).clone(), false));
        Panel { label, curves: wanted.into_iter().chain(curves).collect() }
    };
    let unit = bench.felt().unit();
    let felt = if unit == "N" { "force" } else { "acceleration" };
    Column {
        heading,
        seconds,
        panels: vec![
            panel("drive (V)".into(), |done| &done.run.traces.volts, None),
            panel(
                "speed (rad/s)".into(),
                |done| &done.run.traces.speeds,
                wanted(&|share| top * share.sqrt()),
            ),
            panel(
                format!("{felt} ({unit})"),
                |done| &done.run.traces.felt,
                wanted(&|share| bench.rated() * share),
            ),
        ],
    }
}

/// A line for each step: time, what is wanted, and volts, amperes, speed, vibration, angle from straight down and
/// reaction torque in each way. What has ended is empty, and so is what is not known; `torques` says whether torques and amperes are known.
pub fn csv(bench: &Bench, wish: Option<&Wish>, rows: &[Row], torques: bool) -> String {
    let all: Vec<(Way, &Done)> =
        rows.iter().filter_map(|row| Some((row.way, row.done.as_ref().ok()?))).collect();
    let unit = bench.felt().unit().replace('/', "_per_");
    let mut text = String::from("seconds");
    if wish.is_some() {
        let _ = write!(text, ",wanted_rad_per_s,wanted_{unit}");
    }
    for (way, _) in &all {
        let way = way.word();
        let _ = write!(text, ",{way}_volts,{way}_amperes,{way}_rad_per_s,{way}_{unit},{way}_rad,{way}_N_m");
    }
    text.push('\n');
    let steps = all.iter().map(|(_, done)| done.run.traces.speeds.len()).max().unwrap_or(0);
    for n in 0..steps {
        let time = (n + 1) as f64 / bench.rate;
        let _ = write!(text, "{time:.9}");
        if let Some(share) = wish.map(|wish| wish.at(time)) {
            let speed = bench.parameters.rated_speed() * share.sqrt();
            let _ = write!(text, ",{speed:.6},{:.9}", bench.rated() * share);
        }
        for (_, done) in &all {
            let traces = &done.run.traces;
            // A motor that is known from outside has no amperes and no torques.
            for (values, known) in [
                (&traces.volts, true),
                (&traces.amperes, torques),
                (&traces.speeds, true),
                (&traces.felt, true),
                (&traces.angles, true),
            ] {
                match values.get(n).filter(|_| known) {
                    Some(value) => drop(write!(text, ",{value:.9}")),
                    None => text.push(','),
                }
            }
            match traces.reactions.get(n).filter(|_| torques) {
                // No minus before nothing.
                Some(value) => drop(write!(text, ",{:.6e}", value + 0.0)),
                None => text.push(','),
            }
        }
        text.push('\n');
    }
    text
}
