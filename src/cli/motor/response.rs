//! The response of an actuator with a coil over frequency, as a picture.

use super::super::even::EvenReport;
use super::subject::Subject;
use pacinian::actuator::coil::equaliser::Equaliser;
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::drive::Drive;
use pacinian::actuator::fault::Fault;
use pacinian::report::motion::coil::{Tone, tones};
use pacinian::report::plot::{Axis, Chart, Point, Series};

/// What is drawn, Hz, in so many points at equal ratios.
const SPAN: [f64; 2] = [10.0, 1000.0];
const POINTS: u32 = 240;
/// Letters of a note, at most.
const NOTE: usize = 90;

/// Acceleration for each volt, as it is and with an equaliser before it; the resonance is marked.
pub fn chart(subject: &Subject, plant: &Plant, even: Option<&Equaliser>) -> Result<Chart, Fault> {
    let ratio = (SPAN[1] / SPAN[0]).powf(1.0 / f64::from(POINTS));
    let mut hertz: Vec<f64> = (0..=POINTS).map(|n| (SPAN[0] * ratio.powi(n as i32)).min(SPAN[1])).collect();
    let resonance = plant.resonance(Drive::Voltage);
    let shown = resonance.filter(|pole| (SPAN[0]..=SPAN[1]).contains(&pole.hertz));
    hertz.extend(shown.map(|pole| pole.hertz));
    hertz.sort_by(f64::total_cmp);
    let tones = tones(plant, &hertz)?;
    let series = |name: &str, marked: bool, gain: &dyn Fn(f64) -> f64| {
        let point = |tone: &Tone| {
            let own = shown.filter(|pole| marked && pole.hertz == tone.hertz);
            let label = own.map_or(String::new(), |pole| format!("{:.1} Hz, Q {:.2}", pole.hertz, pole.q));
            Point { x: tone.hertz, y: tone.acceleration * gain(tone.hertz), label }
        };
        Series { name: name.into(), points: tones.iter().map(point).collect(), smooth: true }
    };
    let mut all = vec![series("as it is", true, &|_| 1.0)];
    let mut notes = vec![format!("Figures: {}.", subject.known.text())];
    if let Some(even) = even {
        all.push(series("with the equaliser", false, &|hertz| even.response(hertz).abs()));
        for word in format!("Equaliser: {}.", EvenReport::new(even).text()).split(' ') {
            match notes
                .last_mut()
                .filter(|line| !word.starts_with("Equaliser") && line.len() < NOTE - word.len())
            {
                Some(line) => *line += &format!(" {word}"),
                None => notes.push(word.to_string()),
            }
        }
    }
    Ok(Chart {
        title: format!("{}: {}", subject.name, subject.title),
        x: Axis { label: "frequency (Hz)".into(), log: true, ..Axis::default() },
        y: Axis { label: "acceleration for each volt (m/s2)".into(), log: true, ..Axis::default() },
        series: all,
        notes,
    })
}
