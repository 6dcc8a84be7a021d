use super::super::exact::{Twice, exponential};
use super::{Change, Flow, Motion, Push, Rotor};

impl Flow {
    /// How far all goes from `x` in a time.
    fn change(&self, x: Motion, push: &Push, t: f64) -> Change {
        self.over(t).change(self.rates(x, push), x.speed, push)
    }
}

const COIN: Rotor =
    Rotor { resistance: 30.0, inductance: 3e-4, gain: 0.955e-3, inertia: 1.8e-9, viscous: 2.15e-8 };

/// Coil or none, with the voltage or with the current held, and a time.
#[derive(Debug, Clone, Copy)]
struct Case {
    rotor: Rotor,
    held: bool,
    t: f64,
}

/// What unit inputs do, by the exponential of the whole system in 106 bits. Units are chosen so that all are of like size:
/// columns current, speed, volts, torque, slope, curve; rows current, speed, angle.
fn exact(case: &Case) -> [[f64; 6]; 3] {
    let of = Twice::of;
    let Rotor { resistance: r, inductance: l, gain: k, inertia: j, viscous: b } = case.rotor;
    let zero = of(0.0);
    let mut m = [[zero; 7]; 7];
    let h = of(case.t);
    let (r, l, k, j, b) = (of(r), of(l), of(k), of(j), of(b));
    let coil = case.rotor.inductance > 0.0 && !case.held;
    if coil {
        m[0][0] = -(r.over(l)) * h;
        m[0][1] = -(k.over(l)) * h;
        m[0][3] = h.over(l);
        m[1][0] = k.over(j) * h;
        m[1][1] = -(b.over(j)) * h;
    } else if case.held {
        m[1][0] = k.over(j) * h;
        m[1][1] = -(b.over(j)) * h;
    } else {
        m[1][1] = -((b + k * k.over(r)).over(j)) * h;
        m[1][3] = k.over(r).over(j) * h;
    }
    m[1][4] = h.over(j);
    m[2][1] = h;
    m[4][5] = h;
    m[5][6] = h;
    let e = exponential(&m);
    let mut out = [[0.0; 6]; 3];
    for (c, from) in [0, 1, 3, 4, 5, 6].into_iter().enumerate() {
        for row in 0..3 {
            let unit = of(f64::from(u8::from(row == from)));
            out[row][c] = (e[row][from] - unit).0;
            if row == 0 && !coil && !case.held {
                // Algebraic: what the speed and the volts dictate, less what was.
                let now = -(k * e[1][from]) + if from == 3 { of(1.0) } else { zero };
                out[0][c] = now.over(r).0;
            }
        }
    }
    out
}

/// Inputs of the size they have in a motor, and the sizes of what comes out.
fn worst(case: &Case) -> f64 {
    let flow = if case.held { Flow::of_current(&case.rotor) } else { Flow::of_voltage(&case.rotor) };
    let table = exact(case);
    let algebraic = flow.dictated(0.0, 1.0).is_some();
    let r = &case.rotor;
    let (volts, speed) = (3.0, 3.0 / r.gain);
    let amperes = volts / r.resistance;
    let torque = r.gain * amperes;
    let sizes = [amperes, speed, volts, torque, torque / case.t, torque / case.t / case.t];
    let mut most = 0.0_f64;
    for seed in 0..64_u32 {
        let mut x: [f64; 6] =
            std::array::from_fn(|n| sizes[n] * [-1.0, 0.0, 0.3, 1.0][((seed >> n) as usize * 5 + n) % 4]);
        if seed < 6 {
            x = std::array::from_fn(|n| if n == seed as usize { sizes[n] } else { 0.0 });
        }
        let before = if algebraic { 0.0 } else { x[0] };
        if algebraic {
            x[0] = (x[2] - r.gain * x[1]) / r.resistance;
        }
        let push = Push { volts: x[2], torque: x[3], slope: x[4], curve: x[5] };
        let motion = Motion { current: x[0], speed: x[1] };
        let (got, rates) = (flow.change(motion, &push, case.t), flow.rates(motion, &push));
        let got = [got.current + (x[0] - before), got.speed, got.angle];
        for row in 0..3 {
            let terms: [f64; 6] = std::array::from_fn(|c| {
                let c_in = if algebraic && c == 0 { 0.0 } else { x[c] };
                table[row][c] * c_in
            });
            let sum = terms.iter().fold(Twice::of(0.0), |s, t| s + Twice::of(*t)).0;
            // The terms, and what nothing would have damped; what is coupled through a fast direction is rounded there.
            let rates = [
                rates.current * case.t.min(1.0 / flow.fastest()),
                rates.speed * case.t,
                rates.speed * case.t * case.t,
            ];
            let size: f64 = terms.iter().map(|t| t.abs()).sum::<f64>() + rates[row].abs();
            let size = size * (1.0 + 0.1 * case.t * flow.fastest());
            if size > 0.0 {
                most = most.max((got[row] - sum).abs() / size);
            }
        }
    }
    most
}

/// Electrical constants from none to a second, mechanical ones around them, and steps of every rate and of parts of a sample.
#[test]
fn it_agrees_with_the_exponential_in_twice_the_digits() {
    let mut most = (0.0, None);
    for electrical in [0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1.0] {
        for mechanical in [1e-4, 5e-3, 35e-3, 0.3] {
            for viscous in [0.0, 2.15e-8, 1e-5] {
                for t in [1e-9, 1e-6, 1.0 / 192e3, 1.0 / 48e3, 1.0 / 8e3, 1e-3] {
                    for held in [false, true] {
                        let inertia = mechanical * COIN.gain * COIN.gain / COIN.resistance;
                        let rotor = Rotor { inductance: 30.0 * electrical, inertia, viscous, ..COIN };
                        let case = Case { rotor, held, t };
                        let error = worst(&case);
                        if error > most.0 {
                            most = (error, Some(case));
                        }
                    }
                }
            }
        }
    }
    assert!(most.0 < 3e-15, "{most:?}");
}

/// 4 L J (R b + k²) = (R J + L b)²: both eigenvalues fall together; just beside it they are close or turn slowly.
#[test]
fn eigenvalues_that_fall_together_lose_nothing() {
    for viscous in [0.0, 1e-7] {
        let meets = |l: f64| {
            let r = COIN.resistance * COIN.inertia - l * viscous;
            r * r - 4.0 * l * COIN.inertia * COIN.gain * COIN.gain
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let l = 0.5 * (low + high);
            if meets(l) > 0.0 { low = l } else { high = l }
        }
        for off in [0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8, -1e-8, 1e-4, -1e-4, 0.05, -0.05, 0.2, -0.2] {
            let rotor = Rotor { inductance: low * (1.0 + off), viscous, ..COIN };
            for t in [1e-6, 1e-3, 0.02, 0.05, 0.2] {
                let error = worst(&Case { rotor, held: false, t });
                assert!(error < 3e-15, "{off} {t}: {error}");
            }
        }
    }
}

#[test]
fn two_halves_of_a_way_make_the_whole() {
    let flow = Flow::of_voltage(&COIN);
    let (x, push) =
        (Motion { current: 0.05, speed: 700.0 }, Push { volts: -2.0, torque: 1e-6, slope: 0.1, curve: 30.0 });
    let whole = flow.change(x, &push, 1e-3);
    let first = flow.change(x, &push, 4e-4);
    let middle = Motion { current: x.current + first.current, speed: x.speed + first.speed };
    let torque = push.torque + 4e-4 * (push.slope + 2e-4 * push.curve);
    let later = Push { torque, slope: push.slope + 4e-4 * push.curve, ..push };
    let second = flow.change(middle, &later, 6e-4);
    assert!((first.current + second.current - whole.current).abs() < 1e-15);
    assert!((first.speed + second.speed - whole.speed).abs() < 1e-12);
    assert!((first.angle + second.angle - whole.angle).abs() < 1e-15);
}

#[test]
fn without_friction_an_open_rotor_keeps_its_speed_exactly() {
    let flow = Flow::of_current(&Rotor { viscous: 0.0, ..COIN });
    let x = Motion { current: 0.0, speed: 777.7 };
    let change = flow.change(x, &Push::default(), 1.0 / 48e3);
    assert_eq!(change, Change { current: 0.0, speed: 0.0, angle: 777.7 * (1.0 / 48e3) });
}

/// A derivative is the change over a short time.
#[test]
fn rates_belong_to_the_flow() {
    for flow in [
        Flow::of_voltage(&COIN),
        Flow::of_voltage(&Rotor { inductance: 0.0, ..COIN }),
        Flow::of_current(&COIN),
    ] {
        let volts = 2.0;
        let current = flow.dictated(300.0, volts).unwrap_or(0.02);
        let (x, push) =
            (Motion { current, speed: 300.0 }, Push { volts, torque: -1e-5, slope: 0.0, curve: 0.0 });
        let (rates, change) = (flow.rates(x, &push), flow.change(x, &push, 1e-10));
        assert!((change.current * 1e10 - rates.current).abs() <= 1e-4 * rates.current.abs());
        assert!((change.speed * 1e10 - rates.speed).abs() <= 1e-4 * rates.speed.abs());
    }
}
