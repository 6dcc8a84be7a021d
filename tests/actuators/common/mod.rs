//! Two rumble motors, and the reference trajectories: where they stand, and how a motor runs through one.

use pacinian::actuator::motor::{Casing, Drive, GRAVITY, Motor, Parameters, Plan, Suspension};
use serde_json::Value;

/// A coin motor of 10 mm on 100 g, upright.
pub const COIN: Parameters = Parameters {
    resistance: 30.0,
    inductance: 3e-4,
    gain: 0.955e-3,
    inertia: 1.8e-9,
    viscous: 2.15e-8,
    coulomb: 1.5e-5,
    stiction: 2e-5,
    eccentric: 7.3e-7,
    gravity: GRAVITY,
    casing: Casing::Free { mass: 0.1 },
    rated_volts: 3.0,
};

/// A motor of a game pad on 250 g, upright.
pub const PAD: Parameters = Parameters {
    resistance: 10.42,
    inductance: 4.2e-3,
    gain: 0.011,
    inertia: 1.15e-7,
    viscous: 1e-6,
    coulomb: 6e-4,
    stiction: 7e-4,
    eccentric: 1.38e-5,
    gravity: GRAVITY,
    casing: Casing::Free { mass: 0.25 },
    rated_volts: 12.5,
};

/// A trajectory of the reference.
pub struct Case {
    /// Its file, without `erm_` and `.csv`.
    pub name: String,
    /// The motor.
    pub parameters: Parameters,
    /// Where the mass hangs at first, rad.
    pub angle: f64,
    /// Until when (s) what is done.
    pub segments: Vec<(f64, Drive)>,
    /// Seconds between rows.
    pub every: f64,
    /// By row: whether it shows what was before a drive began in that instant.
    pub before: Vec<bool>,
    /// By row: current, speed, angle, both accelerations (force over the mass) and the displacement.
    pub rows: Vec<[f64; 6]>,
}

fn number(value: &Value, name: &str) -> Option<f64> {
    value.get(name).and_then(Value::as_f64)
}

/// All trajectories.
pub fn cases() -> Vec<Case> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/actuators/reference/");
    let text = std::fs::read_to_string(format!("{folder}erm_manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let cases = manifest["cases"].as_array().unwrap();
    cases.iter().map(|case| read(case, &manifest["devices"], folder)).collect()
}

fn read(case: &Value, devices: &Value, folder: &str) -> Case {
    let p = &case["params"];
    let of = |name: &str| number(p, name).unwrap();
    let mass = of("Mt");
    let casing = match number(p, "kc") {
        Some(stiffness) => {
            let by = Suspension { stiffness, damping: of("cc") };
            Casing::Suspended { mass, across: by, upright: by }
        }
        None => Casing::Free { mass },
    };
    let parameters = Parameters {
        resistance: of("R"),
        inductance: of("L"),
        gain: of("kt"),
        inertia: of("J"),
        viscous: of("b"),
        coulomb: of("Tc"),
        stiction: of("Ts"),
        eccentric: of("mr"),
        gravity: of("g"),
        casing,
        rated_volts: number(&devices[case["device"].as_str().unwrap()], "Vr").unwrap(),
    };
    let segment = |s: &Value| {
        let level = s[2].as_f64().unwrap();
        let drive = match s[1].as_str().unwrap() {
            "V" | "short" => Drive::Voltage(level),
            "I" => Drive::Current { amperes: level, limit: of("Vmax") },
            _ => Drive::Open,
        };
        (s[0].as_f64().unwrap(), drive)
    };
    let file = case["file"].as_str().unwrap();
    let text = std::fs::read_to_string(format!("{folder}{file}")).unwrap();
    let lines: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let segments: Vec<(f64, Drive)> = case["segments"].as_array().unwrap().iter().map(segment).collect();
    // Where a row's drive is not the one that begins in its instant.
    let before = |line: &Vec<f64>| {
        let begins = segments.iter().zip(&segments[1..]).find(|((end, _), _)| (end - line[0]).abs() < 1e-9);
        begins.is_some_and(|(_, (_, next))| match *next {
            Drive::Voltage(v) => line[2] != 0.0 || line[1] != v,
            Drive::Current { .. } => line[2] != 1.0,
            Drive::Open => line[2] != 2.0,
        })
    };
    Case {
        name: file.trim_start_matches("erm_").trim_end_matches(".csv").into(),
        parameters,
        angle: number(p, "th0").unwrap_or(0.0),
        every: of("dt"),
        before: lines.iter().map(before).collect(),
        rows: lines.iter().map(|line| std::array::from_fn(|n| line[n + 3])).collect(),
        segments,
    }
}

/// What a motor did at the rows that lie on its steps: number of the row and its columns.
pub fn run<const BOOKED: bool>(
    case: &Case,
    plan: &Plan,
    rate: f64,
) -> (Motor<BOOKED>, Vec<(usize, [f64; 6])>) {
    let mut motor = Motor::<BOOKED>::new(&case.parameters, plan, rate).unwrap();
    let mass = case.parameters.casing.mass().unwrap();
    motor.drive(case.segments[0].1);
    motor.place(case.angle, 0.0);
    let starts: Vec<(f64, Drive)> = case
        .segments
        .iter()
        .zip(&case.segments[1..])
        .map(|((end, _), (_, next))| (end * rate, *next))
        .collect();
    let mut starts = starts.into_iter().peekable();
    let mut out = Vec::new();
    let mut row = 0;
    let end = ((case.rows.len() - 1) as f64 * case.every * rate).round() as usize;
    for step in 0..=end {
        let now = step as f64;
        while row < case.rows.len() && row as f64 * case.every * rate < now - 1e-3 {
            row += 1;
        }
        let due = row < case.rows.len() && (row as f64 * case.every * rate - now).abs() < 1e-3;
        let mut note = |motor: &Motor<BOOKED>, now: bool| {
            if due && now {
                let r = motor.reading();
                let angle = r.angle + std::f64::consts::TAU * r.turns;
                let [x, y] = r.force.map(|f| f / mass);
                out.push((row, [r.current, r.speed, angle, x, y, r.displacement[0]]));
            }
        };
        note(&motor, due && case.before[row]);
        while let Some((_, drive)) = starts.next_if(|(at, _)| (at - now).abs() < 1e-6) {
            motor.drive(drive);
        }
        note(&motor, due && !case.before[row]);
        let mut within = Vec::new();
        while let Some((at, drive)) = starts.next_if(|(at, _)| at - now < 1.0 - 1e-6) {
            within.push((at - now, drive));
        }
        if step < end {
            motor.step_with(&within);
        }
    }
    (motor, out)
}
