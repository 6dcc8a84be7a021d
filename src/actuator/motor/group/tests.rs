use super::super::{Drive, Level, Motor, Parameters, Plan};
use super::{Group, LANES};

const COIN: Parameters = Parameters::COIN;

/// Eight that differ, one of them none, one without friction, one without inductance.
fn eight() -> [Option<Parameters>; LANES] {
    let of = |n: usize| Parameters { inertia: 1e-9 * (1.0 + n as f64), ..COIN };
    let mut all: [_; LANES] = std::array::from_fn(|n| Some(of(n)));
    all[1] = None;
    all[2] = Some(Parameters { coulomb: 0.0, stiction: 0.0, ..COIN });
    all[3] = Some(Parameters { inductance: 0.0, ..COIN });
    all
}

#[test]
fn each_moves_as_it_would_alone_to_the_bit() {
    for inductance in [true, false] {
        let level = if inductance { Level::Default } else { Level::Economy };
        let plan = Plan { gravity: false, ..Plan::whole(level) };
        let parameters = eight();
        let mut group = Group::new(&parameters, inductance, 48e3).unwrap();
        let mut plain = group.clone();
        let mut single = parameters.map(|p| p.map(|p| Motor::<false>::new(&p, &plan, 48e3).unwrap()));
        for n in 0..30_000_usize {
            for lane in 0..LANES {
                let drive = match (n / 500 + lane) % 9 {
                    0 => Drive::Open,
                    1 => Drive::Current { amperes: 0.07, limit: 3.0 },
                    2 => Drive::Voltage(-3.0),
                    3 if n % 7 == 0 => Drive::Voltage(f64::NAN),
                    4 => Drive::SHORT,
                    _ => Drive::Voltage(1.0 + 0.2 * (n % 11) as f64),
                };
                group.drive(lane, drive);
                plain.drive(lane, drive);
                if let Some(motor) = &mut single[lane] {
                    motor.drive(drive);
                }
            }
            group.step();
            plain.step_plain();
            assert_eq!(plain.seen(), group.seen());
            for (lane, motor) in single.iter_mut().enumerate() {
                let Some(motor) = motor else { continue };
                motor.step();
                let [i, w, _] = group.seen();
                assert_eq!((i[lane], w[lane]), (motor.current(), motor.speed()), "{lane} {n}");
                if n % 97 == 0 {
                    assert_eq!(group.reading(lane), Some(motor.reading()), "{lane} {n}");
                }
            }
        }
        assert_eq!(group.reading(1), None);
        assert_eq!(group.reading(LANES), None);
        group.drive(LANES, Drive::Open);
    }
}

#[test]
fn a_fault_tells_its_lane() {
    let mut all = eight();
    all[5] = Some(Parameters { resistance: 0.0, ..COIN });
    let (lane, fault) = Group::new(&all, true, 48e3).unwrap_err();
    assert_eq!((lane, fault.field), (5, "resistance"));
}
