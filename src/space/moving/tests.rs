//! Moving points against the law evaluated continuously.

use super::{Age, LATE, Mover, SEEN, Steps, Trail};
use crate::schedule::Instant;
use crate::space::array::Array;
use crate::space::law::Law;
use crate::space::path::{Path, Timing};
use crate::space::point::Point;
use crate::space::spot::Spread;
use std::f64::consts::TAU;

const RATE: f64 = 8000.0;
const SECONDS: f64 = 0.25;
/// Fine samples to an engine sample, of the reference.
const OVER: usize = 128;

fn signal(t: f64) -> f64 {
    let tone = [60.0, 172.0, 252.0, 388.0, 612.0, 928.0]
        .iter()
        .enumerate()
        .map(|(k, f)| (TAU * f * t + 1.7 * k as f64).sin())
        .sum::<f64>();
    tone * (std::f64::consts::PI * t / SECONDS).sin().powi(4)
}

/// Real and imaginary parts of some bins up to 1 kHz, by channel.
struct Bins(Vec<[Vec<f64>; 2]>);

impl Bins {
    fn of(channels: usize, samples: usize, rate: f64, mut at: impl FnMut(usize, &mut [f64])) -> Self {
        let bins: Vec<f64> = (0..50).map(|k| 4.0 * (5.0 * k as f64 + 3.0)).collect();
        let mut phasors: Vec<(f64, f64)> = vec![(1.0, 0.0); bins.len()];
        let turns: Vec<(f64, f64)> =
            bins.iter().map(|f| (TAU * f / rate).sin_cos()).map(|(s, c)| (c, -s)).collect();
        let mut sums = vec![[vec![0.0; bins.len()], vec![0.0; bins.len()]]; channels];
        let mut values = vec![0.0; channels];
        for n in 0..samples {
            values.fill(0.0);
            at(n, &mut values);
            for (value, [re, im]) in values.iter().zip(&mut sums) {
                if *value != 0.0 {
                    for (k, p) in phasors.iter().enumerate() {
                        re[k] += value * p.0 / rate;
                        im[k] += value * p.1 / rate;
                    }
                }
            }
            for (p, turn) in phasors.iter_mut().zip(&turns) {
                *p = (p.0 * turn.0 - p.1 * turn.1, p.0 * turn.1 + p.1 * turn.0);
            }
        }
        Self(sums)
    }

    fn error_db(&self, reference: &Self) -> f64 {
        let (mut off, mut all) = (0.0, 0.0);
        for (a, b) in self.0.iter().zip(&reference.0) {
            for part in 0..2 {
                for (x, y) in a[part].iter().zip(&b[part]) {
                    off += (x - y) * (x - y);
                    all += y * y;
                }
            }
        }
        10.0 * (off / all).log10()
    }
}

fn spread(points: &[Point]) -> Spread {
    Spread::new(Array::new(points).unwrap(), (0..points.len() as u32).map(|k| (k, 1.0)).collect()).unwrap()
}

/// The error of a point that moves by `way`, and the most and least sum of squares of its gains, in dB.
fn measured(points: &[Point], law: Law, way: &dyn Fn(f64) -> Point, trail: bool) -> (f64, f64) {
    measured_of(points, (0.0, law), way, trail)
}

/// The same of a width (m).
fn measured_of(
    points: &[Point],
    (width, law): (f64, Law),
    way: &dyn Fn(f64) -> Point,
    trail: bool,
) -> (f64, f64) {
    let n = points.len();
    let spread = spread(points);
    let samples = (SECONDS * RATE) as usize;
    let mut row = spread.array().row();
    let late = if trail { LATE as f64 / RATE } else { 0.0 };
    let reference = Bins::of(n, samples * OVER, RATE * OVER as f64, |k, out| {
        let t = k as f64 / (RATE * OVER as f64);
        // What is told is first told at 0.
        let told = if trail { (t - late).max(0.0) } else { t };
        spread.array().weights(way(told), width, law, &mut row);
        for share in row.shares() {
            out[share.tactor as usize] += law.gain(share.weight) * signal(t);
        }
    });
    let mut mover = Mover::new(&spread);
    let (mut piece, mut least, mut most, mut last) = (0, f64::INFINITY, 0.0_f64, Trail::default());
    let ours = Bins::of(n, samples, RATE, |k, out| {
        let t = k as f64 / RATE;
        let mut power = 0.0;
        let mut to = |channel: u32, gain: f64| {
            power += gain * gain;
            out[channel as usize] += gain * signal(t);
        };
        let (sample, what) = (Some(k as u64), (width, law));
        if trail {
            let steps = last.take(1, |axis, to| to.fill(way(t)[axis]));
            mover.gains(|whole, share| steps.at(0, whole, share), sample, what, &mut piece, &mut to);
        } else {
            let at = |whole, share| way(((k as i64 + whole) as f64 + share) / RATE);
            mover.gains(at, sample, what, &mut piece, &mut to);
        }
        least = least.min(power);
        most = most.max(power);
    });
    (ours.error_db(&reference), 10.0 * (most / least).log10())
}

/// From end to end and back, as a sine.
fn swing(speed: f64, length: f64) -> impl Fn(f64) -> Point {
    move |t| {
        let x = 0.5 * length * (1.0 - 0.999 * (2.0 * speed * t / length).cos());
        [x, 0.0, 0.0]
    }
}

fn line() -> Vec<Point> {
    line_of(0.05)
}

fn line_of(spacing: f64) -> Vec<Point> {
    (0..8).map(|k| [spacing * f64::from(k), 0.0, 0.0]).collect()
}

/// Rows beside each other by half a spacing: triangles of 50 mm, and what is left over at the ends.
fn triangles() -> Vec<Point> {
    let row = |k: i32| f64::from(k / 4);
    (0..16).map(|k| [0.05 * (f64::from(k % 4) + 0.5 * (row(k) % 2.0)), 0.0433 * row(k), 0.0]).collect()
}

fn grid() -> Vec<Point> {
    (0..20).map(|k| [0.05 * f64::from(k % 5), 0.05 * f64::from(k / 5), 0.0]).collect()
}

/// Two layers, 50 mm apart.
fn cloud() -> Vec<Point> {
    (0..24)
        .map(|k| [0.05 * f64::from(k % 4), 0.05 * f64::from(k / 4 % 3), 0.05 * f64::from(k / 12)])
        .collect()
}

/// Along x and y, and through the layers, so many metres a second in all.
fn across(speed: f64, size: Point) -> impl Fn(f64) -> Point {
    let shares = [0, 1, 2].map(|k| if size[k] > 0.0 { [0.8, 0.55, 0.24][k] } else { 0.0 });
    let all = shares.iter().map(|share| share * share).sum::<f64>().sqrt();
    let ways = shares.map(|share| share / all * speed);
    let tri = move |t: f64, k: usize| {
        let x = (ways[k] * t / size[k] + [0.137, 0.41, 0.73][k]).rem_euclid(2.0);
        size[k] * if x > 1.0 { 2.0 - x } else { x }
    };
    move |t| [0, 1, 2].map(|k| if size[k] > 0.0 { tri(t, k) } else { 0.0 })
}

const SPEEDS: [f64; 8] = [0.1, 0.6, 2.0, 3.1, 5.0, 12.0, 30.0, 50.0];

/// Below -80 dB, and the sum of squares within 0.1 dB, where the way is known, at any speed and with corners in it.
#[test]
fn a_known_way_is_as_if_gains_were_continuous() {
    for speed in SPEEDS {
        for (name, points, size) in [
            ("line", line(), [0.35, 0.0, 0.0]),
            ("grid", grid(), [0.2, 0.15, 0.0]),
            ("triangles", triangles(), [0.175, 0.13, 0.0]),
            ("cloud", cloud(), [0.15, 0.1, 0.05]),
        ] {
            let (error, swing) = measured(&points, Law::Energy, &across(speed, size), false);
            // Triangles at the rim are half as high as the spacing.
            let most = if name == "triangles" && speed > 20.0 { 0.2 } else { 0.1 };
            assert!(error < -80.0 && swing < most, "{name} at {speed} m/s: {error:.1} dB, {swing:.3} dB");
        }
    }
}

/// What counts is by how much of the spacing a point goes on in an engine sample.
#[test]
fn what_is_closer_together_is_as_exact_at_as_many_tactors_a_second() {
    for spacing in [0.005, 0.01, 0.02, 0.04] {
        let size = [7.0 * spacing, 0.0, 0.0];
        for (share, most) in [(0.14, 0.1), (0.17, 0.13)] {
            let way = across(share * spacing * RATE, size);
            let (error, swing) = measured(&line_of(spacing), Law::Energy, &way, false);
            assert!(error < -80.0 && swing < most, "{spacing} m, {share}: {error:.1} dB, {swing:.3} dB");
        }
    }
}

/// Of any width; in a test for each arrangement, so that they run side by side.
fn wide(points: &[Point], size: [f64; 3]) {
    // Just below where boxes are looked at more closely, and where that is as close as it gets.
    for speed in [0.6, 7.9, 19.9, 50.0] {
        for width in [0.005, 0.015, 0.03, 0.1] {
            let (error, swing) = measured_of(points, (width, Law::Energy), &across(speed, size), false);
            // Narrow ones change as fast as those of no width.
            let most = if width < 0.01 && speed > 20.0 { 0.2 } else { 0.1 };
            assert!(error < -80.0 && swing < most, "{width} m, {speed} m/s: {error:.1} dB, {swing:.3} dB");
        }
    }
}

#[test]
fn wide_points_move_along_a_line_as_if_gains_were_continuous() {
    wide(&line(), [0.35, 0.0, 0.0]);
}

#[test]
fn wide_points_move_over_a_grid_as_if_gains_were_continuous() {
    wide(&grid(), [0.2, 0.15, 0.0]);
}

#[test]
fn wide_points_move_through_a_cloud_as_if_gains_were_continuous() {
    wide(&cloud(), [0.15, 0.1, 0.05]);
}

/// The same where positions become known one after the other, some samples late.
#[test]
fn a_trail_is_as_exact_as_a_known_way() {
    for speed in SPEEDS {
        let (error, swing) = measured(&line(), Law::Energy, &swing(speed, 0.35), true);
        assert!(error < -80.0 && swing < 0.1, "{speed} m/s: {error:.1} dB, {swing:.3} dB");
    }
}

/// Every other law, and points that wander beyond the rim.
#[test]
fn other_laws_and_ways_beyond_the_rim() {
    for law in [Law::Linear, Law::Logarithmic] {
        let (error, _) = measured(&grid(), law, &across(20.0, [0.2, 0.15, 0.0]), false);
        assert!(error < -80.0, "{law}: {error:.1} dB");
    }
    let wide = |t: f64| across(10.0, [0.4, 0.35, 0.0])(t).map(|x| x - 0.1);
    let (error, swing) = measured(&grid(), Law::Energy, &wide, false);
    assert!(error < -80.0 && swing < 0.1, "{error:.1} dB, {swing:.3} dB");
}

/// All gains of a point, by channel.
fn gains(mover: &mut Mover, at: impl Fn(f64) -> Point, width: f64, law: Law) -> Vec<(u32, f64)> {
    let mut all = Vec::new();
    mover.gains(
        |n, u| at(n as f64 + u),
        None,
        (width, law),
        &mut 0,
        |channel, gain| all.push((channel, gain)),
    );
    all.sort_by_key(|(channel, _)| *channel);
    all
}

/// What does not move has the gains of the law, to the bit, of any width.
#[test]
fn what_rests_has_the_gains_of_a_fixed_point() {
    for points in [line(), grid(), cloud(), vec![[0.0; 3]], vec![[0.1; 3]; 3]] {
        let mut fixed = spread(&points);
        let mut mover = Mover::new(&fixed);
        for law in Law::ALL {
            for width in [0.0, 0.01, 0.04, 1.0] {
                for at in [
                    [0.0; 3],
                    [0.05, 0.0, 0.0],
                    [0.013, 0.021, 0.03],
                    [-0.4, 9.0, 0.0],
                    [f64::NAN, 0.1, f64::INFINITY],
                ] {
                    let mut wanted = Vec::new();
                    fixed.gains(at, width, law, &mut wanted);
                    wanted.sort_by_key(|(channel, _)| *channel);
                    assert_eq!(gains(&mut mover, |_| at, width, law), wanted, "{law} {width} {at:?}");
                }
            }
        }
    }
}

/// A stretch of a point that is `at` so many samples after its first.
fn take(mover: &mut Mover, straight: bool, at: impl Fn(i64) -> Point) {
    for k in 0..mover.stretch.course[0].len() {
        let point = at(k as i64 - SEEN);
        (0..3).for_each(|axis| mover.stretch.course[axis][k] = point[axis]);
    }
    mover.stretch.straight = straight;
}

/// Along a path it is where the path has it at each sample, old or young, at its ends and around its corners.
#[test]
fn a_stretch_of_a_path_is_its_points() {
    let corners = [[0.0; 3], [0.06, 0.0, 0.01], [0.06, 0.0, 0.01], [0.01, 0.09, 0.0]];
    let by_times = Timing::At(vec![0.01, 0.05, 0.055, 0.0903]);
    let paths = [
        Path::new(&corners, 0.11, Timing::Linear).unwrap(),
        Path::new(&corners, 0.0831, Timing::Smooth).unwrap(),
        Path::new(&corners, 1.0, by_times).unwrap(),
    ];
    let mut mover = Mover::new(&spread(&grid()));
    let mut straight = [0, 0];
    for path in &paths {
        for (born, pace) in
            [(Instant::of_samples(3.7), 1.0 / RATE), (Instant::of_samples(700.25), 0.37 / RATE)]
        {
            let mut piece = 0;
            for first in (0..3000_u64).step_by(Mover::STRETCH) {
                let (samples, less) = born.apart(first);
                mover.take(path, Age { samples, less: [less, 2.0] }, pace, &mut piece);
                // What goes straight on is held where it is held otherwise.
                if mover.stretch.straight {
                    let held = |mover: &Mover| {
                        (0..12).map(|tile| mover.held(Law::Energy, tile)).collect::<Vec<u32>>()
                    };
                    let quickly = held(&mover);
                    mover.stretch.straight = false;
                    assert_eq!(quickly, held(&mover), "{first}");
                    straight[0] += 1;
                    straight[1] += usize::from(quickly.iter().any(|held| *held != 0));
                }
                for k in 0..Mover::STRETCH {
                    for far in [-SEEN, 0, SEEN] {
                        let age = born.until(first.wrapping_add(k as u64).wrapping_add_signed(far)) - 2.0;
                        let wanted = path.at(age * pace);
                        let found = mover.stretch.course.map(|axis| axis[(k as i64 + SEEN + far) as usize]);
                        assert_eq!(found.map(f64::to_bits), wanted.map(f64::to_bits), "{first} {k} {far}");
                    }
                }
            }
        }
    }
    assert!(straight.iter().all(|count| *count > 40), "{straight:?}");
}

/// Many at once are those one by one, to the bit, and most of a slow way is.
#[test]
fn a_stretch_is_its_samples() {
    let triangles = vec![[0.0; 3], [0.05, 0.0, 0.0], [0.02, 0.04, 0.0], [0.07, 0.05, 0.0], [0.04, 0.09, 0.0]];
    for (points, least) in [(line(), 0.9), (grid(), 0.8), (triangles, 0.4), (cloud(), 0.0)] {
        let mut mover = Mover::new(&spread(&points));
        for law in [Law::Linear, Law::Logarithmic, Law::Energy] {
            let way = across(0.3, [0.1, 0.08, 0.0]);
            let at = |n: i64, u: f64| way((n as f64 + u) / RATE);
            let (mut piece, mut glides, mut rests) = (0, 0_u32, 0);
            for first in (0..3200).step_by(Mover::STRETCH) {
                take(&mut mover, false, |k| at(first + k, 0.0));
                rests += usize::from(mover.rests(Mover::STRETCH));
                for k in 0..Mover::STRETCH {
                    let mut found = Vec::new();
                    if mover.held(law, piece) >> k & 1 == 1 {
                        glides += 1;
                        for (channel, _, shares) in mover.glide(k..k + 1, law, piece) {
                            found.push((channel, shares[0]));
                        }
                        found.retain(|(_, share)| *share > 0.0);
                    }
                    let (mut wanted, before) = (Vec::new(), piece);
                    mover.gains(
                        |n, u| at(first + k as i64 + n, u),
                        Some((first + k as i64) as u64),
                        (0.0, law),
                        &mut piece,
                        |channel, gain| wanted.push((channel, gain)),
                    );
                    assert!(found.is_empty() || found == wanted && piece == before, "{law} {first} {k}");
                }
            }
            assert_eq!(rests, 0);
            assert!(f64::from(glides) >= least * 3200.0, "{law}: {glides} of {}", points.len());
        }
        for straight in [false, true] {
            take(&mut mover, straight, |_| points[0]);
            assert!(mover.rests(7) && mover.held(Law::Energy, 0) & 127 == 0);
        }
    }
}

/// What is kept from sample to sample is what would be worked out anew, also where the width changes.
#[test]
fn what_is_kept_is_what_it_was() {
    let way = across(9.0, [0.2, 0.15, 0.0]);
    for widths in [[0.0, 0.0, 0.0], [0.012, 0.012, 0.012], [0.012, 0.02, 0.0]] {
        let mut movers = [Mover::new(&spread(&grid())), Mover::new(&spread(&grid()))];
        let mut pieces = [0, 0];
        for k in 0..2000_u64 {
            let at = |whole: i64, share: f64| way(((k as i64 + whole) as f64 + share) / RATE);
            let width = widths[k as usize / 5 % 3];
            let mut found = [Vec::new(), Vec::new()];
            movers[1].forget();
            for ((mover, piece), found) in movers.iter_mut().zip(&mut pieces).zip(&mut found) {
                mover.gains(at, Some(k), (width, Law::Energy), piece, |channel, gain| {
                    found.push((channel, gain))
                });
                found.sort_by_key(|(channel, _)| *channel);
            }
            assert_eq!(found[0], found[1], "{k} {width}");
        }
    }
}

/// Whatever moves how, gains are numbers, and no larger than a low pass lets a step become.
#[test]
fn wild_ways_give_gains_within_bounds() {
    let numbers = [0.0, 0.07, -3.0, 1e30, f64::NAN, f64::INFINITY, 1e-300, 0.05];
    for points in [line(), grid(), cloud(), vec![[0.0; 3]]] {
        let mut mover = Mover::new(&spread(&points));
        let mut trail = Trail::default();
        for n in 0..600_usize {
            let pick = |k: usize| numbers[(n * (2 * k + 1) + n / 7 + k) % numbers.len()];
            let steps = trail.take(1, |axis, to| to.fill(pick(axis)));
            for law in Law::ALL {
                for width in [0.0, 0.01] {
                    for (_, gain) in
                        gains(&mut mover, |u| steps.at(0, u.floor() as i64, u - u.floor()), width, law)
                    {
                        assert!(gain.abs() < 1.3, "{law} {n} {gain}");
                    }
                    let jumps = |u: f64| if u > 0.3 { [pick(0), pick(1), pick(2)] } else { [0.02; 3] };
                    for (_, gain) in gains(&mut mover, jumps, width, law) {
                        assert!(gain.abs() < 1.3, "{law} {n} {gain}");
                    }
                }
            }
        }
    }
}

/// Tells a trail its next positions.
fn told(trail: &mut Trail, samples: usize, at: impl Fn(usize) -> Point) -> Steps {
    trail.take(samples, |axis, to| to.iter_mut().enumerate().for_each(|(k, to)| *to = at(k)[axis]))
}

/// Exact for cubics, straight where it turns, and at the nearer of two places where it jumps; each of them late.
#[test]
fn a_trail_goes_as_it_was_told() {
    let mut trail = Trail::default();
    let way = |t: f64| [1e-3 * t, 2e-4 * t + 1e-6 * t * t, 3e-3 * t - 1e-7 * t * t * t];
    let steps = told(&mut trail, 20, |k| way(k as f64));
    for (sample, whole, share) in [(19, -4, 0.0), (19, 3, 0.25), (14, 0, 0.5), (11, -4, 0.75), (19, 4, 0.0)] {
        let wanted = way((sample as i64 + whole - LATE) as f64 + share);
        let found = steps.at(sample, whole, share);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?} {wanted:?}");
    }
    // Before its first position it was there.
    assert_eq!(steps.at(0, 4, 0.5), way(0.0));
    let corner = told(&mut Trail::default(), 20, |k| [1e-3 * (k as f64 - 9.0).max(0.0), 0.0, 0.0]);
    for (share, wanted) in [(0.25, 0.25e-3), (0.5, 0.5e-3), (0.75, 0.75e-3)] {
        assert!((corner.at(14, 0, share)[0] - wanted).abs() < 1e-15, "{share}");
    }
    assert_eq!(corner.at(13, 0, 0.5), [0.0; 3]);
    let jump = told(&mut Trail::default(), 20, |k| [if k < 10 { 0.0 } else { 0.02 }, 0.0, 0.0]);
    let found = [0.25, 0.49, 0.5, 0.75].map(|share| jump.at(14, 0, share)[0]);
    assert_eq!(found, [0.0, 0.0, 0.02, 0.02]);
}

/// However positions come, many at once or one by one, it is where it was told, beside a place or a path.
#[test]
fn a_stretch_of_a_trail_is_its_points() {
    let corners = [[0.0; 3], [0.06, 0.0, 0.01], [0.01, 0.09, 0.0]];
    let path = Path::new(&corners, 0.11, Timing::Linear).unwrap();
    let (mut mover, still, pace) = (Mover::new(&spread(&grid())), [0.1, 0.05, 0.0], 1.0 / RATE);
    let slow = |k: u64| [0.05 * (k as f64 * 1e-3).sin(), 0.03, 0.0];
    let quick = |k: u64| [0.05 * (k as f64 * 0.4).sin(), 0.03, 0.01 * (k % 7) as f64];
    for (wander, smooth) in [(&slow as &dyn Fn(u64) -> Point, true), (&quick, false)] {
        for on_path in [false, true] {
            let (mut all, mut single, mut clock, mut straight) = (Trail::default(), Trail::default(), 0, 0);
            let (mut piece, mut number) = (0, 0);
            while clock < 2000 {
                let samples = [Mover::STRETCH, 5, 1, 17][number % 4];
                number += 1;
                let born = Instant::of_samples(3.7);
                let (since, less) = born.apart(clock);
                let age = Age { samples: since, less: [less, 2.0] };
                let steps = told(&mut all, samples, |k| wander(clock + k as u64));
                let (still, beside) =
                    if on_path { ([0.0; 3], Some((&path, age, pace))) } else { (still, None) };
                mover.follow(&steps, (still, beside), &mut piece);
                let held =
                    |mover: &Mover| (0..12).map(|tile| mover.held(Law::Energy, tile)).collect::<Vec<u32>>();
                let quickly = held(&mover);
                straight += u32::from(std::mem::take(&mut mover.stretch.straight));
                let counted = |bits: Vec<u32>| {
                    bits.iter().map(|bits| bits & (1_u64 << samples).wrapping_sub(1) as u32).collect()
                };
                let [quickly, slowly]: [Vec<u32>; 2] = [counted(quickly), counted(held(&mover))];
                assert_eq!(quickly, slowly);
                for k in 0..samples {
                    let now = clock + k as u64;
                    let one = told(&mut single, 1, |_| wander(now));
                    for far in [-SEEN, 0, SEEN] {
                        let begin =
                            if on_path { path.at(age.after((k as i64 + far) as i32) * pace) } else { still };
                        let told = steps.at(k, far, 0.0);
                        assert_eq!(told, one.at(0, far, 0.0));
                        assert_eq!(told, wander((now as i64 + far - LATE).max(0) as u64));
                        let wanted = [0, 1, 2].map(|axis| begin[axis] + told[axis]);
                        let found = mover.stretch.course.map(|axis| axis[(k as i64 + SEEN + far) as usize]);
                        assert_eq!(found, wanted, "{now} {far}");
                    }
                    assert_eq!(steps.at(k, 3, 0.3), one.at(0, 3, 0.3));
                    assert_eq!(steps.at(k, -4, 0.3), one.at(0, -4, 0.3));
                }
                clock += samples as u64;
            }
            assert!(if smooth { straight > 20 } else { straight == 0 }, "{straight}");
        }
    }
}
