//! Recordings of a motor that something is wrong with.

use super::super::noise::Noise;
use super::super::{Channel, Mistake, Name, resonant};
use super::tests::{STAIRS, simulate};
use super::{Recording, identify};
use crate::actuator::motor::Parameters;

#[test]
fn what_is_wrong_is_named_with_its_limit() {
    let p = Parameters::COIN;
    let run = simulate(&p, 4000.0, 0.3, &STAIRS);
    let good = Noise::new(1).add(&run.acceleration, 40.0);
    let fails = |r: &Recording| identify(r).unwrap_err();
    let silent = vec![0.02; good.len()];
    assert!(matches!(fails(&run.recording(&silent)), Mistake::Silent(Name::Acceleration, ..)));
    let clipped: Vec<f64> = good.iter().map(|x| x.clamp(-5.0, 5.0)).collect();
    assert!(matches!(fails(&run.recording(&clipped)), Mistake::Clipped(Name::Acceleration, ..)));
    let mut other = run.recording(&good);
    other.acceleration.rate = 4410.0;
    assert_eq!(fails(&other), Mistake::Rate(Name::Acceleration, 4410.0, 4000.0));
    assert_eq!(
        fails(&run.recording(&good[9..])),
        Mistake::Length(Name::Acceleration, good.len() - 9, good.len())
    );
    let mut broken = good.clone();
    broken[99] = f64::NAN;
    assert_eq!(fails(&run.recording(&broken)), Mistake::NotANumber(Name::Acceleration, 99));
    let none = Noise::new(2).add(&run.acceleration, -40.0);
    let noise = fails(&run.recording(&none));
    assert!(matches!(noise, Mistake::Noise(Name::Acceleration, is, 6.0) if is < 6.0), "{noise}");
    assert!(noise.to_string().contains("at least 6.0 dB"), "{noise}");
    // Four turns and a bit.
    let short = simulate(&p, 4000.0, 0.3, &[(Some(0.0), 0.05), (Some(1.0), 0.06)]);
    let x = Noise::new(3).add(&short.acceleration, 40.0);
    let error = fails(&short.recording(&x));
    assert!(matches!(error, Mistake::Short(is, least, "turning") if is < least), "{error}");
    let steady = vec![3.0; good.len()];
    let mut recording = run.recording(&good);
    recording.drive.samples = &steady;
    assert_eq!(fails(&recording), Mistake::Constant(3.0));
    // 247 Hz at 1000 samples a second: 1975 would do.
    let slow = simulate(&p, 1000.0, 0.3, &STAIRS);
    let x = Noise::new(3).add(&slow.acceleration, 40.0);
    assert!(
        matches!(fails(&slow.recording(&x)), Mistake::Slow(1000.0, least, _) if (1800.0..2100.0).contains(&least))
    );
    for (field, recording) in [
        ("delay", Recording { delay: Some(f64::NAN), ..run.recording(&good) }),
        ("current_delay", Recording { current_delay: Some(10.1), ..run.recording(&good) }),
        ("mass", Recording { mass: Some(0.0), ..run.recording(&good) }),
        ("mass", Recording { mass: Some(1e-300), ..run.recording(&good) }),
        ("mass", Recording { mass: Some(1e7), ..run.recording(&good) }),
    ] {
        assert!(matches!(fails(&recording), Mistake::Fault(fault) if fault.field == field));
    }
    // A current that is not this motor's.
    let current = Noise::new(4).add(&vec![0.0; good.len()], 0.0);
    let current: Vec<f64> = current.iter().enumerate().map(|(n, i)| i + (n as f64).sin()).collect();
    let all = identify(&Recording { current: Some(run.channel(&current)), ..run.recording(&good) }).unwrap();
    assert!(all.why_not("resistance").unwrap().contains("check its channel"), "{all:?}");
    assert!(all.get("speed_per_volt").is_some());
}

/// Lengths of nothing and little, noise, edges and constants, at odd rates: an error or an answer, and no panic.
#[test]
fn nothing_panics() {
    let mut noise = Noise::new(77);
    for count in [0, 1, 2, 3, 15, 16, 17, 40, 100, 333] {
        for rate in [10.0, 100.0, 1e3, 1e7] {
            let random: Vec<f64> = (0..count).map(|_| noise.normal()).collect();
            let sine: Vec<f64> = (0..count).map(|n| (0.4 * n as f64).sin() * 1e11).collect();
            let edge: Vec<f64> = (0..count).map(|n| f64::from(u8::from(n > count / 2))).collect();
            let all = [&random, &sine, &edge];
            for drive in all {
                for x in all {
                    let open: Vec<_> = std::iter::once(count / 3..count + 9).collect();
                    let channel = |samples| Channel { samples, rate, full_scale: None };
                    let recording = Recording {
                        drive: channel(drive),
                        acceleration: channel(x),
                        is_calibrated: true,
                        current: Some(channel(&random)),
                        voltage: Some(channel(&sine)),
                        open: if count % 2 == 0 { &open } else { &[] },
                        delay: None,
                        current_delay: None,
                        mass: Some(0.1),
                    };
                    let _ = identify(&recording);
                    let _ = resonant::identify(&resonant::Recording {
                        drive: channel(drive),
                        acceleration: channel(x),
                        is_calibrated: true,
                        current: Some(channel(&random)),
                        share: Some(1.0),
                    });
                }
            }
        }
    }
}
