//! What protection says that it did, and where its edges are.

use super::{Actuator, Bounds, Cooling, Protection, RATE, Rms, Touched, Unit, cooling, none, plant, run};

#[test]
fn counts_are_those_of_the_definitions() {
    // Peak 4 V of 4, then 1 V a sample: all of it exact.
    let bounds = Bounds { full_scale: Some(4.0), peak: Some(4.0), slew: Some(RATE), ..none() };
    let nothing = [f32::NAN, f32::INFINITY];
    let input = [0.125, 1.25, 1.25, 1.25, 0.875, 0.75, 0.625, nothing[0], -0.25, nothing[1]];
    let (out, counts) = run(&bounds, RATE, &input);
    assert_eq!(out, [0.5, 1.5, 2.5, 3.5, 3.5, 3.0, 2.5, 1.5, 0.5, 0.0].map(|v| v / 4.0));
    assert_eq!((counts.samples, counts.masked, counts.changed), (10, 2, 6));
    assert_eq!(counts.peak, Touched { samples: 3, most: 1.0 });
    // On the way up 4 V wanted at 0.5, 1.5 and 2.5 V; on the way down 0 V at 2.5 and -1 V at 1.5.
    assert_eq!(counts.slew, Touched { samples: 5, most: 2.5 });
    // With a budget, what is wild is held, and counted once.
    let (_, counts) = run(&Bounds { heat: Some(cooling()), ..none() }, RATE, &[0.1, 17.0, -1e30, 15.9]);
    assert_eq!((counts.held, counts.masked), (2, 0));
    // A gain and a cap that both lower a sample are one bound.
    let (_, counts) = run(&Bounds { heat: Some(cooling()), ..none() }, RATE, &[16.0; 8000]);
    assert!(counts.heat.samples <= 8000 && counts.heat.samples >= 7900, "{counts:?}");
}

/// Of two budgets the one that turns down is counted, and the other not.
#[test]
fn the_budget_that_turns_down_is_the_one_that_is_counted() {
    let input = vec![1.0; 16_000];
    let both = |winding: f64, volts: f64| Bounds {
        heat: Some(Cooling { most: winding, ..cooling() }),
        rms: Some(Rms { most: volts, unit: Unit::Volts, seconds: 0.5 }),
        ..none()
    };
    let (_, counts) = run(&both(1e4, 1.0), RATE, &input);
    assert!(counts.rms.samples > 10_000 && counts.heat.samples == 0, "{counts:?}");
    let (_, counts) = run(&both(1.0, 1e3), RATE, &input);
    assert!(counts.heat.samples > 10_000 && counts.rms.samples == 0, "{counts:?}");
}

/// A gain that glides is at the end of a tick where the next one begins, sample by sample.
#[test]
fn the_gain_of_a_sample_is_that_of_its_place_in_the_tick() {
    let bounds = Bounds { rms: Some(Rms { most: 1.0, unit: Unit::Volts, seconds: 1.0 }), ..none() };
    let mut p = Protection::new(&bounds, RATE).unwrap();
    let (tick, mut before, mut glides) = (p.tick as usize, 1.0, 0);
    for _ in 0..100 {
        let mut samples = vec![1.0; tick];
        p.process(&mut samples);
        let (step, now) = ((p.gain() - before) / tick as f64, p.gain());
        for (k, sample) in (1..).zip(&samples) {
            let due = before + step * f64::from(k);
            assert!((f64::from(*sample) - due).abs() < 1e-6, "{k}: {sample} {due}");
        }
        glides += u32::from(step.abs() > 1e-5);
        before = now;
    }
    assert!(glides > 20, "{glides}");
}

/// The largest sample that passes without a closer look keeps to the peak, however that is rounded to single precision.
#[test]
fn the_sample_next_to_the_peak_keeps_to_it() {
    let mut above = 0;
    for n in 1..200 {
        let (peak, volts) = (0.01 * f64::from(n), 3.3);
        let bounds = Bounds { full_scale: Some(volts), peak: Some(peak), ..none() };
        let near = (peak / volts) as f32;
        above += u32::from(f64::from(near) * volts > peak);
        for x in [near, near.next_up(), near.next_down()] {
            let (out, _) = run(&bounds, RATE, &[x, -x]);
            assert!(out.iter().all(|x| f64::from(*x).abs() * volts <= peak), "{peak}: {x} {out:?}");
        }
    }
    assert!(above > 50, "{above}");
}

/// What is wild is held also where a budget would let a tick of it pass.
#[test]
fn what_is_wild_is_held_whatever_a_budget_has_room_for() {
    let bounds = Bounds { rms: Some(Rms { most: 1e6, unit: Unit::Volts, seconds: 1.0 }), ..none() };
    let (out, counts) = run(&bounds, RATE, &[16.0, 17.0, -1e5, 1.0]);
    assert_eq!((out, counts.held), (vec![16.0, 16.0, -16.0, 1.0], 2));
}

/// The farthest is that of both ways.
#[test]
fn the_farthest_is_counted_one_way_and_the_other() {
    let bounds = Bounds { stroke: Some(1e-3), actuator: Actuator::Coil(plant()), ..none() };
    let pulse = |volts: f32| [vec![volts; 4], vec![0.0; 2000]].concat();
    let [one, other] = [0.1, -0.1].map(|volts| run(&bounds, RATE, &pulse(volts)).1.farthest);
    assert!(one > 0.0 && (one / other - 1.0).abs() < 1e-9, "{one} {other}");
}
