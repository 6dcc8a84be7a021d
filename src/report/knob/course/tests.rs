use super::column::Column;
use super::{Course, MOST_COLUMNS, MOST_EVENTS, Sample, kind};
use crate::knob::effect::events::{Events, What};
use crate::knob::effect::program::Program;
use crate::knob::effect::{Reading, detent::Detent, wall::Stops};
use crate::knob::plant::Plant;
use crate::knob::plant::encoder::Encoder;
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Build, Hand};
use crate::knob::velocity::{Estimator, filtered::Filtered};

fn sound(svg: &str) {
    roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

/// Keeps a picture where one asks for it, to be looked at.
fn keep(name: &str, svg: &str) {
    if let Ok(folder) = std::env::var("PACINIAN_PICTURES") {
        std::fs::write(format!("{folder}/{name}.svg"), svg).unwrap();
    }
}

/// A knob that a hand turns through detents against a stop, and lets go.
fn run(seconds: f64, rate: f64) -> Course {
    let stop = Stops { low: -1.0, high: 1.2, stiffness: 0.4, damping: 1e-3 };
    let mut effects = Program::new(vec![Detent::with_stiffness(24.0, 0.1).into(), stop.into()]).unwrap();
    let parameters = Parameters { coulomb: 2e-4, stiction: 2e-4, ..Parameters::default() };
    let mut knob = Plant::new(&Build { parameters, ..Build::default() }, rate).unwrap();
    let encoder = Encoder::of_counts(4000.0).unwrap();
    let mut estimator = Filtered::new(200.0, 1.0 / rate).unwrap();
    let (mut course, mut events) = (Course::new(rate), Events::default());
    for n in 0..(seconds * rate) as u64 {
        let time = n as f64 / rate;
        let velocity = estimator.push(encoder.read(knob.angle()));
        let reading = Reading { angle: encoder.read(knob.angle()), velocity, dt: 1.0 / rate };
        let asked = effects.tick(&reading, 1.0, 1.0, &mut events);
        let given = asked.clamp(-0.06, 0.06);
        events.list().iter().for_each(|event| course.event(time, kind(&event.what)));
        course.push(&Sample {
            angle: knob.angle(),
            speed: knob.speed(),
            estimated: velocity,
            asked,
            given,
            energy: knob.energy(),
            hand: None,
        });
        let torque = if time < 0.1 { 4.6e-3 } else { 0.0 };
        knob.step(given, &Hand { torque, ..Hand::default() });
    }
    course
}

#[test]
fn a_run_is_a_sheet() {
    let course = run(0.4, 10_000.0);
    let svg = course.svg("Through detents against a stop");
    keep("course", &svg);
    sound(&svg);
    for label in ["angle (rad)", "speed (rad/s)", "torque (N m)", "energy (J)", "time (s)", "detent", "wall"]
    {
        assert!(svg.contains(&format!(">{label}<")), "{label}");
    }
    assert!(course.events().iter().filter(|e| e.kind == "detent").count() > 4);
    let csv = course.csv();
    assert_eq!(csv.lines().count(), 4001);
    assert!(csv.lines().all(|line| line.matches(',').count() == 14));
    assert!(course.events_csv().contains(",wall\n"));
    let line = Sample { angle: 1.5, speed: f64::NAN, ..Sample::default() }.line(0.25);
    assert_eq!((line.as_str(), Sample::names().matches(',').count()), ("0.25,1.5,,0,0,0,0,", 7));
}

#[test]
fn its_size_has_a_bound_and_nothing_that_sticks_out_is_lost() {
    let mut course = Course::new(48_000.0);
    let mut size = 0;
    for n in 0..3_000_000u32 {
        let (sin, cos) = (f64::from(n) * 0.37).sin_cos();
        // One sample alone is far out.
        let angle = if n == 1_234_567 { 30.0 } else { sin };
        course.push(&Sample {
            angle,
            speed: 10.0 * cos,
            estimated: 9.0 * cos,
            asked: sin,
            given: sin,
            energy: cos,
            hand: Some(0.0),
        });
        if n % 40 == 0 {
            course.event(f64::from(n) / 48_000.0, "detent");
        }
        if n == 100_000 {
            size = course.svg("a").len();
        }
    }
    assert!(course.columns.len() <= MOST_COLUMNS && course.columns.len() >= MOST_COLUMNS / 2);
    assert!(course.columns.iter().any(|c| c.extremes[0][1] == 30.0));
    let svg = course.svg("A minute");
    keep("course minute", &svg);
    sound(&svg);
    assert!(svg.len() < 250_000 && svg.len() < 2 * size, "{} {size}", svg.len());
    assert!(course.csv().len() < 2_000_000);
    assert_eq!((course.events().len(), course.lost()), (MOST_EVENTS, 75_000 - MOST_EVENTS as u64));
    assert!((course.seconds() - 62.5).abs() < 1e-9);
}

#[test]
fn columns_hold_the_extremes_in_their_order() {
    let of = |x: f64| Column::of(&[x, -x, 0.0, 0.0, 0.0, 0.0, f64::NAN]);
    let up = Column::joined(&[of(1.0), of(2.0)]);
    assert_eq!((up.ends(0), up.ends(1)), ([1.0, 2.0], [-1.0, -2.0]));
    let down = Column::joined(&[of(2.0), of(1.0)]);
    assert_eq!((down.ends(0), down.ends(1)), ([2.0, 1.0], [-2.0, -1.0]));
    let all = Column::joined(&[up, Column::joined(&[of(-3.0), of(5.0)])]);
    assert_eq!(all.ends(0), [-3.0, 5.0]);
    assert!(all.extremes[6][0] > all.extremes[6][1], "no number has come");
    let way = all.way();
    assert_eq!((way[0], *way.last().unwrap()), ((1.0, -1.0), (5.0, -5.0)));
    assert!(way.contains(&(-3.0, 3.0)));
    assert!(Column::of(&[f64::NAN; 7]).way().is_empty());
}

#[test]
fn nothing_and_nonsense_are_still_a_sheet() {
    sound(&Course::new(f64::NAN).svg("nothing"));
    assert_eq!(Course::new(1.0).csv().lines().count(), 1);
    for value in [f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX, 5e-324, 0.0] {
        let mut course = Course::new(1000.0);
        for n in 0..5000 {
            let [angle, speed, estimated] = [value, if n % 2 == 0 { value } else { -value }, value];
            course.push(&Sample {
                angle,
                speed,
                estimated,
                asked: value,
                given: 1.0,
                energy: value,
                hand: None,
            });
            course.event(value, "wall");
        }
        course.event(-1.0, "too early");
        let svg = course.svg("nonsense");
        sound(&svg);
        assert!(!course.csv().contains("NaN") && !course.csv().contains("inf"));
        if !value.is_finite() {
            assert!(svg.contains("Values that were no numbers, and are left out: 25000."), "{svg}");
        }
    }
    let mut course = Course::new(1000.0);
    for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
        course.push(&Sample::default());
        course.event(1e-3, name);
    }
    let svg = course.svg("many kinds");
    assert!(svg.contains(">others<") && svg.contains("others 3") && !svg.contains(">f<"), "{svg}");
    assert_eq!(kind(&What::Wall { speed: 1.0, side: 1 }), "wall");
}
