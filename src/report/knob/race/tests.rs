use super::method::Contender;
use super::{Course, Problem, Wish, listed, picture, race};
use crate::knob::plant::rival::integrator::Method;
use crate::report::cost::{Across, Outcome, csv, text};

fn problem(name: &str) -> Problem {
    listed().into_iter().find(|p| p.name == name).unwrap()
}

/// Rows of a trajectory of 50 digits: tick, angle, speed; and the line that opens it.
fn trajectory(family: &str, name: &str) -> Vec<(usize, f64, f64)> {
    let path = format!("{}/tests/knob/{family}.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let from = text.find(&format!("# name={name} ")).unwrap();
    let rows = text[from..].lines().skip(1).take_while(|line| !line.starts_with('#'));
    rows.map(|line| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        (cells[0] as usize, cells[1], cells[2])
    })
    .collect()
}

/// The truths are those of the reference, which was computed elsewhere with 50 digits.
#[test]
fn truths_are_true() {
    for (name, family, case, rate) in [
        ("free run", "k1", "k1_free_viscous_coulomb", 2000.0),
        ("soft wall", "k3", "k3_wall_K1e3_z0.05", 12_000.0),
        ("stiff wall", "k3", "k3_wall_K1e6_z0.05", 48_000.0),
        ("detent", "k4", "k4_detent_continuous", 4000.0),
    ] {
        let problem = problem(name);
        let truth = problem.truth(rate);
        let most = truth.iter().fold(problem.start.1, |most: f64, (_, v)| most.max(v.abs()));
        let (mut worst, mut seen) = (0.0f64, 0);
        for (tick, angle, speed) in trajectory(family, case) {
            if tick > 0 && tick <= truth.len() {
                let is = truth[tick - 1];
                worst = worst.max((is.1 - speed).abs() / most).max((is.0 - angle).abs());
                seen += 1;
            }
        }
        println!("{name}: {worst:.2e} over {seen}");
        assert!(seen > 10 && worst < 1e-12, "{name}: {worst:e} {seen}");
    }
}

/// Stick-slip by closed forms: how far it slips in the first tooth, from break-away to stop.
#[test]
fn it_slips_where_the_closed_form_says() {
    let (problem, rate) = (problem("stick-slip"), 20_000.0);
    let (truth, torques) = (problem.truth(rate), problem.torques(rate));
    let p = problem.parameters;
    let first = torques.iter().position(|t| *t > p.stiction).unwrap();
    assert!(truth[..first].iter().all(|x| *x == (0.0, 0.0)));
    // v' = v e + (τ − T_c) (1 − e) / b over each held torque.
    let (b, h) = (p.viscous, 1.0 / rate);
    let decay = (-b / p.inertia * h).exp();
    let (mut speed, mut n) = (0.0, first);
    loop {
        speed = speed * decay + (torques[n] - p.coulomb) / b * (1.0 - decay);
        if speed <= 0.0 {
            break;
        }
        assert!((truth[n].1 - speed).abs() < 1e-13, "{n} {} {speed}", truth[n].1);
        n += 1;
    }
    // It breaks away within the last tenth of a tooth and stands soon after its end.
    assert!(truth[n].1 == 0.0 && truth[n + 500] == truth[n] && n - first > 80, "{first} {n}");
    assert!(truth.iter().filter(|x| x.1 > 0.0).count() > 100, "four times");
}

#[test]
fn the_exact_one_is_exact_and_each_other_errs_as_its_order_says() {
    for name in ["free run", "soft wall", "stiff wall", "detent"] {
        let problem = problem(name);
        for rate in [1e3, 16e3, 48e3] {
            let row = Course::new(&problem, rate).row(Contender::Exact);
            assert!(row.error < 1e-11 && row.outcome == Outcome::Held, "{name} {rate}: {}", row.error);
        }
    }
    let error = |name: &str, method, rate| {
        let course = Course::new(&problem(name), rate);
        let made =
            Contender::made(Contender::Plain(method), &course.problem, rate, &mut |k| course.errors(k).0);
        made.unwrap()
    };
    // Without an event, methods are of their orders: the detent at 16 and 48 kHz.
    for (method, order) in [
        (Method::ForwardEuler, 1.0),
        (Method::SymplecticEuler, 1.0),
        (Method::BackwardEuler, 1.0),
        (Method::ImplicitMidpoint, 2.0),
        (Method::RungeKutta4, 4.0),
    ] {
        let (coarse, fine) = (error("detent", method, 8e3), error("detent", method, 32e3));
        let slope = (coarse / fine).log(4.0);
        assert!((slope - order).abs() < 0.3, "{}: {coarse:e} {fine:e} {slope}", method.name());
    }
    assert!(error("stiff wall", Method::ForwardEuler, 1e3) > 2.0, "it runs away");
}

#[test]
fn a_race_has_a_row_for_each_and_is_shown() {
    let mut problems = listed();
    problems.iter_mut().for_each(|p| p.seconds = p.seconds.min(0.03));
    let wish = Wish { problems, rates: vec![1e3, 16e3] };
    let mut seen = 0;
    let rows = race(&wish, &mut |_| seen += 1).unwrap();
    assert_eq!((rows.len(), seen), (wish.rows(), wish.rows()));
    let text = text(&rows);
    println!("{text}");
    assert!(text.contains("knob, stick-slip") && text.contains("unstable") && text.contains("Kikuuwe"));
    let csv = csv(&rows);
    assert!(csv.contains("knob,stiff wall,\"Euler\",false,1000,,,,unstable"), "{csv}");
    let svg = picture(&rows, Across::Step);
    roxmltree::Document::parse(&svg).unwrap();
    assert!(svg.contains("Euler unstable at 1 kHz"), "{svg}");
    for (rate, refused) in [(10.0, true), (f64::NAN, true), (1e7, true), (100.0, false)] {
        let wish = Wish { problems: Vec::new(), rates: vec![rate] };
        assert_eq!(race(&wish, &mut |_| ()).is_err(), refused, "{rate}");
    }
}

#[test]
fn friction_models_are_for_friction() {
    let of = |name: &str| Contender::of(&problem(name));
    assert!(of("free run").contains(&Contender::Dahl) && of("stick-slip").contains(&Contender::Kikuuwe));
    assert!(!of("soft wall").contains(&Contender::LuGre) && !of("detent").contains(&Contender::Kikuuwe));
    let free = Course::new(&problem("free run"), 48e3);
    let [kikuuwe, lugre, dahl] =
        [Contender::Kikuuwe, Contender::LuGre, Contender::Dahl].map(|c| free.row(c).error);
    assert!(kikuuwe < 1e-3 && lugre < 1e-2 && dahl < 1e-2, "{kikuuwe} {lugre} {dahl}");
}
