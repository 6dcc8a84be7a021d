//! Pictures of a knob that was turned.

use super::course::{Course, Sample};
use super::turn::Turned;
use pacinian::report::plot::{Axis, Chart, Column, Curve, Panel, Point, Series, Strips};

/// Angle, speed, torque and energy over time.
pub fn strips(title: &str, turned: &Turned) -> Strips {
    let Course { rate, samples } = &turned.course;
    let curve = |name: &str, wanted: bool, of: &dyn Fn(&Sample) -> f64| Curve {
        name: name.into(),
        rate: *rate,
        values: samples.iter().map(of).collect(),
        wanted,
    };
    let panel = |label: &str, curves: Vec<Curve>| Panel { label: label.into(), curves };
    let panels = vec![
        panel("angle (rad)", vec![curve("hand", true, &|s| s.hand[0]), curve("knob", false, &|s| s.angle)]),
        panel(
            "speed (rad/s)",
            vec![curve("knob", false, &|s| s.speed), curve("estimated", false, &|s| s.read[1])],
        ),
        panel(
            "torque (N m)",
            vec![curve("asked for", true, &|s| s.torque[0]), curve("given", false, &|s| s.torque[1])],
        ),
        panel("energy put in (mJ)", vec![curve("put in", false, &|s| 1e3 * s.absorbed)]),
    ];
    let seconds = samples.len() as f64 / rate;
    let set_off = turned.set_off.len();
    let heading = format!("{set_off} voices set off in {seconds:.2} s");
    Strips {
        title: title.into(),
        subtitle: "a simulated knob".into(),
        columns: vec![Column { heading, seconds, panels }],
    }
}

/// Points of a phase plot, at most.
const POINTS: usize = 4000;

/// Speed over angle.
pub fn phase(title: &str, course: &Course) -> Chart {
    let every = course.samples.len().div_ceil(POINTS).max(1);
    let points = course.samples.iter().step_by(every);
    let points = points.map(|s| Point { x: s.angle, y: s.speed, label: String::new() }).collect();
    Chart {
        title: title.into(),
        x: Axis { label: "angle (rad)".into(), ..Axis::default() },
        y: Axis { label: "speed (rad/s)".into(), ..Axis::default() },
        series: vec![Series { name: String::new(), points, smooth: true }],
        notes: if every > 1 { vec![format!("Of every {every} samples one is drawn.")] } else { Vec::new() },
    }
}
