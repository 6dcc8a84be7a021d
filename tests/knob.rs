//! The plant against trajectories of 50 digits. `KNOB_REFERENCE` names another directory of the same form to read instead.

#[path = "knob/shipped.rs"]
mod shipped;

use pacinian::knob::plant::chain::Chain;
use pacinian::knob::plant::encoder::{Delay, Encoder};
use pacinian::knob::plant::parameters::Parameters;
use pacinian::knob::plant::parts::{Build, Hand, Shaft};
use pacinian::knob::plant::rotor::Rotor;
use pacinian::knob::plant::stops::Stops;
use pacinian::knob::plant::wave::Wave;
use std::collections::HashMap;

struct Case {
    name: String,
    values: HashMap<String, f64>,
    rows: Vec<(usize, Vec<f64>)>,
}

impl Case {
    fn get(&self, key: &str) -> f64 {
        self.values.get(key).copied().unwrap_or(0.0)
    }

    fn rate(&self) -> f64 {
        self.get("rate")
    }

    fn parameters(&self) -> Parameters {
        let coulomb = self.get("Tc");
        Parameters { inertia: self.get("J"), viscous: self.get("b"), coulomb, stiction: coulomb, stops: None }
    }

    /// Largest magnitudes of the columns.
    fn most(&self) -> Vec<f64> {
        let width = self.rows[0].1.len();
        (0..width).map(|c| self.rows.iter().map(|(_, row)| row[c].abs()).fold(0.0, f64::max)).collect()
    }

    /// The worst error over the rows that fall on steps of `stride` ticks, relative to the largest magnitude of each column.
    fn worst<P>(
        &self,
        stride: usize,
        plant: &mut P,
        step: impl FnMut(&mut P),
        state: impl Fn(&P) -> Vec<f64>,
    ) -> f64 {
        let most = self.most();
        self.against(stride, plant, step, state, |_| most.clone())
    }

    fn against<P>(
        &self,
        stride: usize,
        plant: &mut P,
        mut step: impl FnMut(&mut P),
        state: impl Fn(&P) -> Vec<f64>,
        scale: impl Fn(&[f64]) -> Vec<f64>,
    ) -> f64 {
        let (mut tick, mut worst) = (0, 0.0f64);
        for (row, expected) in self.rows.iter().filter(|(row, _)| row % stride == 0) {
            while tick < *row {
                step(plant);
                tick += stride;
            }
            for ((is, should), scale) in state(plant).iter().zip(expected).zip(scale(expected)) {
                assert!(is.is_finite());
                worst = worst.max((is - should).abs() / scale);
            }
        }
        worst
    }
}

fn cases(family: &str) -> Vec<Case> {
    let directory = std::env::var("KNOB_REFERENCE")
        .unwrap_or_else(|_| format!("{}/tests/knob", env!("CARGO_MANIFEST_DIR")));
    let text = std::fs::read_to_string(format!("{directory}/{family}.csv")).unwrap();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines() {
        if let Some(head) = line.strip_prefix("# ") {
            let (mut name, mut values) = (String::new(), HashMap::new());
            for (key, value) in head.split(' ').filter_map(|pair| pair.split_once('=')) {
                if key == "name" {
                    name = value.to_string();
                } else {
                    values.insert(key.to_string(), value.parse().unwrap());
                }
            }
            cases.push(Case { name, values, rows: Vec::new() });
        } else {
            let mut numbers = line.split(',');
            let tick = numbers.next().unwrap().parse().unwrap();
            let row = numbers.map(|n| n.parse().unwrap()).collect();
            cases.last_mut().unwrap().rows.push((tick, row));
        }
    }
    cases
}

fn tell(family: &str, worst: &[(f64, String)], tolerance: f64) {
    let (most, name) = worst.iter().fold((0.0, ""), |w, (e, n)| if *e >= w.0 { (*e, n) } else { w });
    println!("{family}: {most:.2e} ({name})");
    assert!(most < tolerance, "{family}: {most:e} in {name}");
}

/// What a controller samples, and the torque that acts until it samples again.
struct Sampled<P, L> {
    plant: P,
    encoder: Option<Encoder>,
    delay: Delay,
    law: L,
    torque: f64,
}

impl<P, L: Fn(f64) -> f64> Sampled<P, L> {
    /// At the beginning it has sampled that angle.
    fn new(case: &Case, plant: P, angle: f64, law: L) -> Self {
        let quantised = case.values.get("quantised").is_none_or(|q| *q == 1.0);
        let encoder =
            (case.get("cpr") > 0.0 && quantised).then(|| Encoder::of_counts(case.get("cpr")).unwrap());
        let read = encoder.map_or(angle, |e| e.read(angle));
        let mut delay = Delay::new(case.get("delay") as usize, read).unwrap();
        let torque = law(delay.pass(read));
        Self { plant, encoder, delay, law, torque }
    }

    fn sample(&mut self, angle: f64) {
        let now = self.encoder.map_or(angle, |e| e.read(angle));
        self.torque = (self.law)(self.delay.pass(now));
    }
}

fn state<const WALLED: bool>(rotor: &Rotor<WALLED>) -> Vec<f64> {
    vec![rotor.angle(), rotor.speed()]
}

type Closed<L> = Sampled<Rotor<false>, L>;

fn sampled<L: Fn(f64) -> f64>(case: &Case, start: [f64; 2], law: L) -> Closed<L> {
    let mut rotor = Rotor::new(&case.parameters(), case.rate()).unwrap();
    rotor.place(start[0], start[1]).unwrap();
    Sampled::new(case, rotor, start[0], law)
}

impl<L: Fn(f64) -> f64> Closed<L> {
    fn tick(&mut self) {
        self.plant.step(self.torque);
        self.sample(self.plant.angle());
    }

    /// Angle, speed, and torque.
    fn state(&self) -> Vec<f64> {
        vec![self.plant.angle(), self.plant.speed(), self.torque]
    }
}

fn run(case: &Case, law: impl Fn(f64) -> f64) -> f64 {
    let start = &case.rows[0].1;
    let mut closed = sampled(case, [start[0], start[1]], law);
    case.worst(1, &mut closed, Closed::tick, Closed::state)
}

#[test]
fn k1_free_run() {
    let mut worst = Vec::new();
    for case in cases("k1") {
        for stride in [1, 4, 20] {
            let mut rotor = Rotor::<false>::new(&case.parameters(), case.rate() / stride as f64).unwrap();
            rotor.place(0.0, case.get("omega0")).unwrap();
            worst.push((case.worst(stride, &mut rotor, |r| r.step(0.0), state), case.name.clone()));
            let stopped = (rotor.angle() / case.get("stop_angle") - 1.0).abs();
            worst.push((stopped, "stop angle".into()));
        }
    }
    tell("k1", &worst, 1e-11);
}

#[test]
fn k2_sampled_spring() {
    let mut worst = Vec::new();
    for case in cases("k2") {
        let (k, w) = (case.get("K"), (case.get("K") / case.get("J")).sqrt());
        let mut s = sampled(&case, [case.get("theta0"), 0.0], |read| -k * read);
        // That of the rotor and of a spring that acts all the time: what hold and delay make is in it.
        let energy =
            |s: &Closed<_>| 0.5 * (case.get("J") * s.plant.speed().powi(2) + k * s.plant.angle().powi(2));
        let error = case.against(
            1,
            &mut s,
            Closed::tick,
            |s| [s.state(), vec![energy(s)]].concat(),
            |row| {
                // Relative to the amplitude at the time: it grows in some. A torque is of one before.
                let amplitude = row[0].hypot(row[1] / w);
                vec![amplitude, amplitude * w, k * amplitude, k * amplitude * amplitude]
            },
        );
        worst.push((error, case.name.clone()));
    }
    tell("k2", &worst, 1e-11);
}

fn wall(case: &Case, rate: f64) -> Rotor<true> {
    let stops = Stops { low: f64::NEG_INFINITY, high: 0.0, stiffness: case.get("K"), damping: case.get("D") };
    let mut rotor = Rotor::new(&Parameters { stops: Some(stops), ..case.parameters() }, rate).unwrap();
    rotor.place(case.get("theta0"), case.get("omega0")).unwrap();
    rotor
}

#[test]
fn k3_wall_of_the_plant() {
    let mut worst = Vec::new();
    for case in cases("k3") {
        for stride in [1, 4, 16, 48, 240] {
            let mut rotor = wall(&case, case.rate() / stride as f64);
            worst.push((
                case.worst(stride, &mut rotor, |r| r.step(0.0), state),
                format!("{} by {stride}", case.name),
            ));
            // Speeds without damping after it are those at the release.
            if case.get("b") == 0.0 {
                worst.push(((rotor.speed() / case.get("omega_rebound") - 1.0).abs(), "rebound".into()));
            }
        }
    }
    tell("k3", &worst, 1e-11);
}

#[test]
fn k3s_sampled_wall() {
    let mut worst = Vec::new();
    for case in cases("k3s") {
        let k = case.get("K");
        worst.push((run(&case, |read| if read > 0.0 { -k * read } else { 0.0 }), case.name.clone()));
    }
    tell("k3s", &worst, 1e-10);
}

/// A sampled wall makes energy, which one that acts continuously does not: who integrates the one as the other is told apart.
#[test]
fn k3s_is_no_wall_of_the_plant() {
    let mut told = 0;
    for case in cases("k3s") {
        let start = &case.rows[0].1;
        let mut rotor =
            wall(&Case { values: case.values.clone(), name: String::new(), rows: Vec::new() }, case.rate());
        rotor.place(start[0], start[1]).unwrap();
        let error = case.worst(1, &mut rotor, |r| r.step(0.0), state);
        assert!(error > 1e-4, "{}: {error:e}", case.name);
        told += usize::from(error > 0.02);
    }
    assert!(told >= 24, "{told}");
}

#[test]
fn k4s_sampled_detent() {
    let mut worst = Vec::new();
    for mut case in cases("k4s") {
        case.values.insert("delay".into(), 1.0);
        let (a, n) = (case.get("A"), case.get("N"));
        worst.push((run(&case, |read| -a * (n * read).sin()), case.name.clone()));
    }
    tell("k4s", &worst, 1e-10);
}

#[test]
fn k5_quantised_spring_and_hand() {
    let mut worst = Vec::new();
    for case in cases("k5") {
        let (k, hand) = (case.get("K"), case.get("Fh"));
        let start = &case.rows[0].1;
        let mut s = sampled(&case, [start[0], start[1]], |read| hand - k * read);
        // One that never moves has no largest speed.
        let most: Vec<f64> =
            case.most().into_iter().map(|most| if most == 0.0 { 1.0 } else { most }).collect();
        let error = case.against(1, &mut s, Closed::tick, Closed::state, |_| most.clone());
        worst.push((error, case.name.clone()));
    }
    tell("k5", &worst, 1e-11);
}

#[test]
fn k4_continuous_detent() {
    let mut worst = Vec::new();
    for case in cases("k4") {
        for stride in [1, 2, 4] {
            let build = Build {
                parameters: case.parameters(),
                cogging: Wave::detent(case.get("A"), case.get("N")).unwrap(),
                ..Build::default()
            };
            let mut chain = Chain::new(&build, case.rate() / stride as f64).unwrap();
            chain.place(case.get("theta0"), case.get("omega0")).unwrap();
            let error = case.worst(
                stride,
                &mut chain,
                |c| c.step(0.0, &Hand::default()),
                |c| vec![c.angle(), c.speed()],
            );
            worst.push((error, case.name.clone()));
        }
    }
    tell("k4", &worst, 1e-10);
}

#[test]
fn k6_two_inertias() {
    let mut worst = Vec::new();
    for case in cases("k6") {
        let shaft = Shaft {
            inertia: case.get("Jk"),
            viscous: 0.0,
            stiffness: case.get("ks"),
            damping: case.get("cs"),
        };
        let parameters =
            Parameters { inertia: case.get("Jm"), viscous: case.get("b"), ..Parameters::default() };
        let build = Build { parameters, shaft: Some(shaft), ..Build::default() };
        let mut chain = Chain::new(&build, case.rate()).unwrap();
        chain.place(0.05, 0.0).unwrap();
        let late =
            Case { values: HashMap::from([("delay".into(), 1.0)]), name: String::new(), rows: Vec::new() };
        let mut closed = Sampled::new(&late, chain, 0.05, |read| -case.get("K") * read);
        let error = case.worst(
            1,
            &mut closed,
            |s| {
                s.plant.step(s.torque, &Hand::default());
                s.sample(s.plant.angle());
            },
            |s| {
                let chain = &s.plant;
                vec![chain.angle(), chain.knob_angle(), chain.speed(), chain.knob_speed(), s.torque]
            },
        );
        worst.push((error, case.name.clone()));
    }
    tell("k6", &worst, 1e-10);
}
