use super::decoder::{Decoder, NOT_HEARD, Sense, Sensor};
use super::linear::{Linear, Slope};
use super::quadrature::{Lines, QUIET, Quadrature};
use super::resolver::{MOST_STEP, Pair, Resolver};
use super::turn::{angle, shortest};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use std::f64::consts::{PI, TAU};

#[test]
fn angles_of_pairs_are_angles_all_around_and_at_any_size() {
    for n in -2000..=2000 {
        let phi = PI * f64::from(n) / 2000.0;
        for size in [1e-300, 1e-3, 1.0, 1e300] {
            let at = angle(size * phi.sin(), size * phi.cos());
            assert!(shortest(at, phi).abs() < 1e-15 * 4.0, "{phi} {size}: {at}");
            assert!((-PI..=PI).contains(&at), "{phi}");
        }
    }
    for (s, c) in [(0.0, 0.0), (f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0), (f64::NAN, f64::NAN)] {
        assert_eq!(angle(s, c), 0.0);
    }
}

/// The true angle comes back over many turns, whatever the pair's errors, once they are known.
#[test]
fn a_resolver_is_exact_once_its_errors_are_known() {
    let pair = Pair { offset: [0.03, -0.05], gain: [0.45, 0.55], phase: 0.1, turns: 3 };
    let (mut known, mut unknown) = (Resolver::new(&pair).unwrap(), Resolver::new(&Pair::of(0.5, 3)).unwrap());
    let (mut worst, mut wrong) = (0.0_f64, 0.0_f64);
    for n in 0..20_000 {
        // To and fro by 40 turns of the knob.
        let truth = 40.0 * TAU * (1.0 - (TAU * f64::from(n) / 20_000.0).cos()) / 2.0;
        let (s, c) = (0.03 + 0.45 * (3.0 * truth + 0.1).sin(), -0.05 + 0.55 * (3.0 * truth).cos());
        worst = worst.max((known.push(s, c).unwrap() - truth).abs());
        wrong = wrong.max((unknown.push(s, c).unwrap() - truth).abs());
    }
    assert!(worst < 1e-13 * 250.0 && (0.01..0.2).contains(&wrong), "{worst} {wrong}");
    assert_eq!((known.lost(), unknown.lost()), (0, 0));
}

#[test]
fn a_resolver_is_lost_where_its_pair_is_none() {
    let mut resolver = Resolver::new(&Pair::of(0.5, 1)).unwrap();
    let mut at = |size: f64, phi: f64| resolver.push(size * phi.sin(), size * phi.cos());
    assert_eq!(at(0.5, 0.25).map(|x| (x * 1e12).round()), Some(0.25e12));
    for size in [0.0, 0.249, 1.001, f64::NAN, f64::INFINITY] {
        assert_eq!(at(size, 0.25), None, "{size}");
    }
    assert!(at(0.251, 0.5).is_some() && at(0.999, 0.75).is_some());
    // Half a turn: it may have gone either way.
    assert_eq!(at(0.5, 0.75 + PI), None);
    assert!(at(0.5, 0.75 + PI + 0.9 * MOST_STEP).is_some());
    assert_eq!(resolver.lost(), 6);
    resolver.reset();
    assert!(resolver.push(0.0, 0.5).is_some_and(|x| x == 0.0));
    for bad in [
        Pair { gain: [0.0, 1.0], ..Pair::of(1.0, 1) },
        Pair { offset: [f64::NAN, 0.0], ..Pair::of(1.0, 1) },
        Pair { phase: 1.5, ..Pair::of(1.0, 1) },
        Pair::of(1.0, 0),
        Pair::of(f64::INFINITY, 1),
    ] {
        assert!(Resolver::new(&bad).is_err(), "{bad:?}");
    }
}

fn lines(count: i64) -> [f64; 2] {
    let [a, b] = [[0, 0], [1, 0], [1, 1], [0, 1]][count.rem_euclid(4) as usize];
    [f64::from(a), f64::from(b)]
}

#[test]
fn quadrature_counts_every_edge_and_no_noise() {
    let made = Lines { counts: 4000, threshold: 0.5, hysteresis: 0.2 };
    let mut decoder = Quadrature::new(&made).unwrap();
    let mut noise = 1_u64;
    for n in 0..100_000_i64 {
        // As fast as an edge a frame, both ways.
        let truth = (3000.0 * (n as f64 * 3e-4).sin()).round() as i64;
        let shaken = lines(truth).map(|x| {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            x + 0.25 * ((noise >> 40) as f64 / (1_u64 << 23) as f64 - 1.0)
        });
        let angle = decoder.push(shaken[0], shaken[1]).unwrap();
        assert_eq!(decoder.count(), truth, "{n}");
        assert!((angle - TAU * truth as f64 / 4000.0).abs() < 1e-12);
    }
    assert_eq!((decoder.illegal(), decoder.lost()), (0, 0));
}

#[test]
fn quadrature_is_lost_where_edges_come_too_fast() {
    let mut decoder = Quadrature::new(&Lines { counts: 400, threshold: 0.5, hysteresis: 0.1 }).unwrap();
    let mut at = |count: i64| {
        let [a, b] = lines(count);
        decoder.push(a, b)
    };
    assert!(at(0).is_some() && at(1).is_some());
    assert_eq!(at(3), None, "two edges in a frame");
    // Three look like one backward: not believed, as nothing stood still since.
    assert!((1..50).all(|n| at(3 + 3 * n).is_none()));
    // It stands: believed after a while, from where it was left.
    assert!((1..QUIET).all(|_| at(150).is_none()));
    assert!(at(150).is_some() && at(151).is_some());
    assert_eq!((decoder.illegal(), decoder.lost()), (1, 1 + 49 + u64::from(QUIET) - 1));
    decoder.reset(7);
    assert_eq!(decoder.count(), 7);
    assert_eq!(decoder.push(f64::NAN, 0.0), None);
    for bad in [(0, 0.5, 0.1), (400, f64::NAN, 0.1), (400, 0.5, -0.1), (400, 0.5, f64::INFINITY)] {
        let (counts, threshold, hysteresis) = bad;
        assert!(Quadrature::new(&Lines { counts, threshold, hysteresis }).is_err(), "{bad:?}");
    }
}

#[test]
fn a_voltage_is_an_angle_while_its_sensor_is_whole() {
    let slope = Slope { full_scale: 8.0, radians_per_volt: -1.2, zero: 2.5, whole: [0.1, 4.9] };
    let mut linear = Linear::new(&slope).unwrap();
    assert_eq!(linear.push(2.5 / 8.0), Some(0.0));
    assert!((linear.push(3.5 / 8.0).unwrap() + 1.2).abs() < 1e-12);
    for lost in [0.0, 0.62, 1.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(linear.push(lost), None, "{lost}");
    }
    assert_eq!(linear.lost(), 6);
    for bad in [
        Slope { full_scale: 0.0, ..slope },
        Slope { radians_per_volt: 0.0, ..slope },
        Slope { zero: f64::NAN, ..slope },
        Slope { whole: [1.0, 1.0], ..slope },
    ] {
        assert!(Linear::new(&bad).is_err(), "{bad:?}");
    }
}

fn pair(sense: Pair) -> Sensor {
    Sensor { sense: Sense::Pair(sense), channels: [2, 0], inverted: false }
}

/// A reading for each tick, of the mean of its frames; the first frame has one of its own.
#[test]
fn a_reading_is_of_the_frames_of_its_tick() {
    let mut decoder = Decoder::new(&pair(Pair::of(0.5, 1)), 6).unwrap();
    let mut readings = Vec::new();
    let rate = 1e-4;
    for n in 0..601 {
        let phi = 1.0 + rate * f64::from(n);
        let frame = [0.5 * phi.cos() as f32, 9.0, 0.5 * phi.sin() as f32];
        readings.extend(decoder.push(Some(&frame)));
    }
    assert_eq!((readings.len(), decoder.lost()), (101, 0));
    for (tick, reading) in readings.iter().enumerate().skip(1) {
        // The middle of six frames is two and a half before the last.
        let late = pair(Pair::of(0.5, 1)).late(6);
        let middle = 1.0 + rate * (6.0 * tick as f64 - late);
        assert!((reading.unwrap() - middle).abs() < 2e-7, "{tick}: {reading:?} {middle}");
    }
}

/// The mean of a tick's frames has less noise than one of them, by the root of their number.
#[test]
fn the_mean_of_a_tick_takes_noise_away() {
    let noise = |frames: usize| {
        let mut decoder = Decoder::new(&pair(Pair::of(0.5, 1)), frames).unwrap();
        let (mut state, mut sum, mut count) = (7_u64, 0.0, 0.0);
        let mut shaken = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1e-3 * ((state >> 40) as f64 / (1_u64 << 23) as f64 - 1.0)
        };
        for _ in 0..60_000 {
            let frame = [(0.5 + shaken()) as f32, 0.0, shaken() as f32];
            if let Some(Some(angle)) = decoder.push(Some(&frame)) {
                (sum, count) = (sum + angle * angle, count + 1.0);
            }
        }
        f64::sqrt(sum / count)
    };
    let ratio = noise(1) / noise(6);
    assert!((ratio / 6.0_f64.sqrt() - 1.0).abs() < 0.05, "{ratio}");
}

/// A tick of which a frame was not heard has no reading, whatever the sensor is; the next has one again.
#[test]
fn a_frame_that_was_not_heard_takes_its_tick_away() {
    let lines = Lines { counts: 400, threshold: 0.0, hysteresis: 0.05 };
    let slope = Slope { full_scale: 4.0, radians_per_volt: 2.0, zero: 0.0, whole: [-3.9, 3.9] };
    for sense in [Sense::Pair(Pair::of(0.5, 1)), Sense::Lines(lines), Sense::Slope(slope)] {
        let sensor = Sensor { sense, channels: [0, 1], inverted: true };
        for gap in [None, Some([NOT_HEARD; 2]), Some([f32::NAN, 0.3]), Some([f32::NEG_INFINITY; 2])] {
            let mut decoder = Decoder::new(&sensor, 3).unwrap();
            let readings: Vec<bool> = (0..13)
                .filter_map(|n| match (n, &gap) {
                    (5, gap) => decoder.push(gap.as_ref().map(|gap| &gap[..])),
                    _ => decoder.push(Some(&[0.3, 0.4])),
                })
                .map(|reading| reading.is_some())
                .collect();
            assert_eq!(readings, [true, true, false, true, true], "{sense:?} {gap:?}");
            assert_eq!(decoder.lost(), 1);
        }
        // A frame that lacks a channel is none, but where the sensor has only one.
        let mut decoder = Decoder::new(&sensor, 1).unwrap();
        assert_eq!(decoder.push(Some(&[])), Some(None), "{sense:?}");
    }
}

/// A frame that is far off is not hidden in the mean of those beside it.
#[test]
fn a_tick_with_one_broken_frame_is_lost() {
    let slope = Slope { full_scale: 4.0, radians_per_volt: 2.0, zero: 0.0, whole: [-3.9, 3.9] };
    for (sense, broken) in [(Sense::Pair(Pair::of(0.5, 1)), [0.0, 0.1]), (Sense::Slope(slope), [1.0, 0.4])] {
        let mut decoder = Decoder::new(&Sensor { sense, channels: [0, 1], inverted: false }, 6).unwrap();
        let mut readings = Vec::new();
        for n in 0..19 {
            readings.extend(decoder.push(Some(if n == 8 { &broken } else { &[0.3, 0.4] })));
        }
        let known: Vec<bool> = readings.iter().map(Option::is_some).collect();
        assert_eq!(known, [true, true, false, true], "{sense:?}");
    }
}

#[test]
fn an_inverted_sensor_falls_where_the_other_rises() {
    let slope = Slope { full_scale: 4.0, radians_per_volt: 2.0, zero: 0.5, whole: [-3.9, 3.9] };
    let read = |inverted: bool, volts: f32| {
        let sensor = Sensor { sense: Sense::Slope(slope), channels: [0, 0], inverted };
        Decoder::new(&sensor, 1).unwrap().push(Some(&[volts / 4.0])).flatten().unwrap()
    };
    assert_eq!([read(false, 1.5), read(true, 1.5)], [2.0, -2.0]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever comes in, and however a decoder was made, what comes out is a number or nothing.
    #[test]
    fn nothing_that_comes_in_breaks_a_decoder(
        samples in prop::collection::vec((any::<f64>(), any::<f64>()), 1..200),
        figures in prop::collection::vec(any::<f64>(), 6),
        counts in any::<u32>(),
    ) {
        let f = &figures;
        let pair = Pair { offset: [f[0], f[1]], gain: [f[2], f[3]], phase: f[4], turns: counts };
        let mut resolvers = vec![Resolver::new(&Pair::of(0.5, 1)).unwrap()];
        resolvers.extend(Resolver::new(&pair));
        let mut edges = vec![Quadrature::new(&Lines { counts: 400, threshold: 0.0, hysteresis: 0.1 }).unwrap()];
        edges.extend(Quadrature::new(&Lines { counts, threshold: f[0], hysteresis: f[1] }));
        let slope = Slope { full_scale: f[0], radians_per_volt: f[1], zero: f[2], whole: [f[3], f[4]] };
        let mut linear: Vec<Linear> = Linear::new(&slope).into_iter().collect();
        let mut decoders: Vec<Decoder> = [Sense::Pair(pair), Sense::Slope(slope)]
            .iter()
            .filter_map(|sense| Decoder::new(&Sensor { sense: *sense, channels: [0, 1], inverted: true }, 2).ok())
            .collect();
        for (a, b) in samples {
            let frame = [a as f32, b as f32];
            assert!(decoders.iter_mut().all(|d| d.push(Some(&frame)).flatten().is_none_or(f64::is_finite)));
            for resolver in &mut resolvers {
                assert!(resolver.push(a, b).is_none_or(f64::is_finite));
            }
            assert!(edges.iter_mut().all(|e| e.push(a, b).is_none_or(f64::is_finite)));
            assert!(linear.iter_mut().all(|l| l.push(a).is_none_or(f64::is_finite)));
        }
    }
}
