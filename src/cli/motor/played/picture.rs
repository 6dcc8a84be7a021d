//! What an actuator did under a patch, as a picture and as a table.

use super::super::super::loaded::Loaded;
use super::super::shown::ms;
use super::super::subject::Subject;
use super::word;
use pacinian::actuator::driver::setup::Shaping;
use pacinian::report::motion::Played;
use pacinian::report::plot::{Column, Curve, Panel, Strips};
use std::fmt::Write;

/// Drive, speed and vibration in each way, with what was wanted.
pub fn picture(
    title: &str,
    loaded: &Loaded,
    subject: &Subject,
    ways: &[(Option<Shaping>, Played)],
) -> Strips {
    let curve = |name: &str, played: &Played, values: Vec<f64>, wanted| Curve {
        name: name.into(),
        rate: played.rate,
        values,
        wanted,
    };
    let panel = |label: String, of: &dyn Fn(&Played) -> Vec<f64>, wanted: Option<&dyn Fn(f64) -> f64>| {
        let wanted = wanted.into_iter().flat_map(|wanted| {
            let wished = |played: &Played| played.wished.iter().map(|speed| wanted(*speed)).collect();
            wishes(ways).into_iter().map(move |played| curve("wanted", played, wished(played), true))
        });
        let curves = ways.iter().map(|(shaping, played)| curve(word(*shaping), played, of(played), false));
        Panel { label, curves: wanted.chain(curves).collect() }
    };
    let unit = ways.first().map_or("", |(_, played)| played.unit);
    let felt = if unit == "N" { "force" } else { "acceleration" };
    let given = if subject.current.is_some() { "drive (A)" } else { "drive (V)" };
    let mut panels = vec![panel(given.into(), &|played| played.drives.clone(), None)];
    let per_square =
        subject.actuator.rumble_motor().ok().map(|p| p.eccentric / p.casing.mass().unwrap_or(1.0));
    let felt = format!("{felt} ({unit})");
    if let Some(per_square) = per_square {
        panels.push(panel("speed (rad/s)".into(), &|played| played.speeds.clone(), Some(&|speed| speed)));
        panels.push(panel(felt, &|played| played.felt.clone(), Some(&|speed| per_square * speed * speed)));
    } else {
        panels.push(panel(felt, &|played| played.felt.clone(), None));
    }
    let seconds = ways.iter().map(|(_, played)| played.seconds()).fold(0.0, f64::max);
    let column = Column { heading: loaded.patch.title.clone(), seconds, panels };
    let before = ways.iter().map(|(_, played)| played.before).fold(0.0, f64::max);
    let before = match before {
        0.0 => String::new(),
        before => format!("; it begins {} before the patch", ms(before)),
    };
    let late: Vec<String> =
        ways.iter().map(|(shaping, played)| format!("{} {}", word(*shaping), ms(played.late))).collect();
    let subtitle = format!(
        "under {}, when the patch has it{before}; sent later by: {}; amplitudes as they are felt",
        loaded.name(),
        late.join(", ")
    );
    Strips { title: title.into(), subtitle, columns: vec![column] }
}

/// Those that wish for something, and for something else than those before.
fn wishes(ways: &[(Option<Shaping>, Played)]) -> Vec<&Played> {
    let end = |wished: &[f64]| wished.iter().rposition(|speed| *speed != 0.0).map_or(0, |last| last + 1);
    let mut found: Vec<&Played> = Vec::new();
    for (_, played) in ways {
        let wished = &played.wished[..end(&played.wished)];
        let is = |other: &&Played| other.wished[..end(&other.wished)] == *wished;
        if !wished.is_empty() && !found.iter().any(is) {
            found.push(played);
        }
    }
    found
}

/// A line for each frame of the device: time as the patch has it, and drive, speed, what was wished for, what was felt, angle and
/// reaction torque in each way. What is not known, or has ended, is empty.
pub fn csv(ways: &[(Option<Shaping>, Played)]) -> String {
    let mut text = String::from("seconds");
    for (shaping, played) in ways {
        let way = shaping.map_or(String::new(), |shaping| format!("{}_", shaping.word()));
        let unit = played.unit.replace('/', "_per_");
        let _ =
            write!(text, ",{way}drive,{way}rad_per_s,{way}wanted_rad_per_s,{way}{unit},{way}rad,{way}N_m");
    }
    text.push('\n');
    let frames = ways.iter().map(|(_, played)| played.drives.len()).max().unwrap_or(0);
    for n in 0..frames {
        let _ = write!(text, "{:.9}", ways.first().map_or(0.0, |(_, played)| played.time(n + 1)));
        for (_, played) in ways {
            for values in [&played.drives, &played.speeds, &played.wished, &played.felt, &played.turned] {
                match values.get(n) {
                    Some(value) => drop(write!(text, ",{value:.9}")),
                    None => text.push(','),
                }
            }
            match played.reactions.get(n) {
                // No minus before nothing.
                Some(torque) => drop(write!(text, ",{:.6e}", torque + 0.0)),
                None => text.push(','),
            }
        }
        text.push('\n');
    }
    text
}
