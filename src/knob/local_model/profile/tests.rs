use super::{POINTS, Profile, SIDE};
use crate::dsp::random::uniform;

fn any(n: u64) -> Profile {
    let u = |k: u64| uniform(k, n);
    let mut more = std::array::from_fn::<f64, POINTS, _>(|k| 0.02 * u(10 + k as u64));
    more[SIDE] = 0.0;
    let (torque, centre) = (0.02 * u(1), 3.0 * u(2));
    Profile { torque, centre, reach: 0.2 * (1.5 + u(3)), more, energy: u(4), time: n as f64 }
}

#[test]
fn torque_is_the_fall_of_energy_and_stays_beyond_the_range() {
    for n in 0..200 {
        let p = any(n);
        assert_eq!(p.at(p.centre), (p.torque, false), "to the bit");
        assert_eq!(p.energy(p.centre), p.energy);
        for k in 0..60 {
            let (angle, h) = (p.centre + 1.5 * p.reach * uniform(n + 1, k), 1e-6);
            let slope = (p.energy(angle + h) - p.energy(angle - h)) / (2.0 * h);
            let steepest = 0.04 / p.away(SIDE + 1);
            assert!((p.at(angle).0 + slope).abs() < 1e-6 + steepest * h, "{n} {angle}");
            assert_eq!(p.at(angle).1, (angle - p.centre).abs() > p.reach, "{n} {angle}");
        }
        for k in 0..POINTS {
            let there = p.at(p.centre + p.away(k)).0;
            assert!((there - p.torque - p.more[k]).abs() < 1e-12, "{n} {k}");
        }
        for side in [-1.0, 1.0] {
            let end = p.torque + p.more[if side < 0.0 { 0 } else { POINTS - 1 }];
            let (torque, beyond) = p.at(p.centre + side * 1e3);
            assert!((torque - end).abs() < 1e-15 && beyond, "{torque} {end}");
        }
        assert_eq!(p.at(f64::NAN), (0.0, true));
        // What goes through a cell is what was put in.
        assert_eq!(Profile::of_numbers(&p.numbers()), p);
        assert_eq!(Profile::flat(0.3).at(1e9), (0.3, false));
    }
}
