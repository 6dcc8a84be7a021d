use super::roots::Characteristic;
use super::rules::{abbott_okamura, bounce, colgate, colgate_general, gil, held_by_friction, quantisation};
use super::sampled::{Loop, Rotor, Shaft};
use crate::dsp::complex::Complex;
use crate::knob::low_pass::LowPass;
use crate::knob::test_plant::{Delay, Plant, count, floor};

const J: f64 = 6e-6;

fn rigid(damping: f64, rate: f64, delay: f64) -> Loop {
    Loop::rigid(&Rotor { inertia: J, damping }, 1.0 / rate, delay).unwrap()
}

/// Radii of the reference trajectories `knob_k2_*`, computed there with 50 digits.
#[test]
fn the_spectral_radius_is_that_of_the_reference() {
    for (rate, delay, b, radius) in [
        (1000.0, 0.0, 0.0, 1.016_530_045_465_127),
        (1000.0, 0.0, 2e-5, 1.014_855_441_835_992_6),
        (1000.0, 1.0, 0.0, 1.046_487_016_105_973),
        (1000.0, 1.0, 2e-5, 1.044_856_532_547_532),
        (1000.0, 2.0, 0.0, 1.068_806_462_256_171_7),
        (1000.0, 2.0, 2e-5, 1.067_271_417_121_78),
        (10_000.0, 0.0, 0.0, 1.000_166_652_780_092),
        (10_000.0, 0.0, 2e-5, 0.999_999_990_742_283_8),
        (10_000.0, 1.0, 0.0, 1.000_499_597_829_888_4),
        (10_000.0, 1.0, 2e-5, 1.000_332_991_210_633),
        (10_000.0, 2.0, 2e-5, 1.000_664_886_598_066),
        (48_000.0, 0.0, 0.0, 1.000_007_233_770_132_6),
        (48_000.0, 0.0, 2e-5, 0.999_972_512_066_996_4),
        (48_000.0, 1.0, 2e-5, 0.999_986_979_429_353_8),
        (48_000.0, 2.0, 2e-5, 1.000_001_445_494_206_4),
    ] {
        let got = rigid(b, rate, delay).radius(0.4, 0.0);
        assert!((got - radius).abs() < 1e-13, "{rate} {delay} {b}: {got} {radius}");
        // Without losses and delay: sqrt(1 + K T² / 2 J).
        if b == 0.0 && delay == 0.0 {
            assert!((got - (1.0 + 0.4 / (rate * rate) / (2.0 * J)).sqrt()).abs() < 1e-14);
        }
    }
}

fn determinant(m: &[Vec<f64>], z: Complex) -> Complex {
    let n = m.len();
    let mut a: Vec<Vec<Complex>> =
        m.iter().map(|row| row.iter().map(|x| Complex::from(-*x)).collect()).collect();
    (0..n).for_each(|i| a[i][i] = a[i][i] + z);
    let mut product = Complex::from(1.0);
    for i in 0..n {
        let pivot = (i..n).max_by(|p, q| a[*p][i].abs().total_cmp(&a[*q][i].abs())).unwrap();
        if pivot != i {
            a.swap(pivot, i);
            product = -product;
        }
        product = product * a[i][i];
        if a[i][i].abs() == 0.0 {
            return Complex::default();
        }
        for k in i + 1..n {
            let factor = a[k][i] / a[i][i];
            for l in i..n {
                a[k][l] = a[k][l] - factor * a[i][l];
            }
        }
    }
    product
}

/// The matrix is built from the state's step, the roots from polynomials.
#[test]
fn the_roots_are_the_eigenvalues_of_the_matrix() {
    let shaft = Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped: 600.0, loss: 6.57e-5, damping: 2e-5 };
    for (rate, delay, k, b) in [
        (1000.0, 0.0, 0.4, 0.0),
        (10_000.0, 1.0, 0.4, 1e-5),
        (10_000.0, 2.37, 1.4, 3e-5),
        (48_000.0, 20.5, 0.4, 2e-5),
    ] {
        let two = Loop::shaft(&shaft, 1.0 / rate, delay).unwrap();
        for l in [rigid(2e-5, rate, delay), two] {
            let m = l.matrix(k, b).unwrap();
            let roots = l.eigenvalues(k, b);
            assert!(roots.len() <= m.len());
            for z in roots.iter().filter(|z| z.abs() > 0.3) {
                let aside = determinant(&m, *z + 1e-5).abs();
                assert!(determinant(&m, *z).abs() < 1e-5 * aside, "{rate} {delay}: {z:?}");
            }
            // And there is none besides: their product and that of the rest is the determinant's argument over the circle.
            let outside = roots.iter().filter(|z| z.abs() > 1.0).count();
            let mut turned = 0.0;
            let steps = 40_000;
            let mut last = determinant(&m, Complex::from(1.0));
            for i in 1..=steps {
                let next =
                    determinant(&m, Complex::turned(std::f64::consts::TAU * f64::from(i) / f64::from(steps)));
                turned += (next / last).angle();
                last = next;
            }
            let inside = (turned / std::f64::consts::TAU).round() as usize;
            assert_eq!(inside + outside, m.len(), "{rate} {delay}");
        }
    }
}

#[test]
fn the_edge_is_where_the_radius_passes_1() {
    for rate in [1000.0, 10_000.0, 48_000.0, 192_000.0] {
        for delay in [0.0, 0.25, 1.0, 2.0, 3.0, 7.8, 32.0, 128.0, 512.0] {
            for (b, computed) in [(2e-5, 0.0), (2e-4, 0.0), (1e-6, 0.0), (2e-4, 2e-5)] {
                let l = rigid(b, rate, delay);
                let edge = l.edge(computed);
                if edge.gain == 0.0 {
                    assert!(l.radius(1e-9, computed) > 1.0 - 1e-9, "{rate} {delay} {b} {computed}");
                    continue;
                }
                let (under, over) =
                    (l.growth(edge.gain * 0.999_99, computed), l.growth(edge.gain * 1.000_01, computed));
                assert!(under < 0.0 && over > 0.0, "{rate} {delay} {b} {computed}: {edge:?} {under} {over}");
            }
        }
    }
}

/// Ratios of the exact edge to the closed forms, as they were computed elsewhere.
#[test]
fn closed_forms_are_corners_of_the_exact_edge() {
    let ratio = |computed: f64, jbt: f64, delay: f64| {
        let t = 1e-3;
        let b = J / (jbt * t);
        let l = Loop::rigid(&Rotor { inertia: J, damping: b }, t, delay).unwrap();
        l.edge(computed * b).gain / gil(b, computed * b, t, delay * t)
    };
    assert!((ratio(0.0, 100.0, 0.0) - 1.002).abs() < 0.002, "{}", ratio(0.0, 100.0, 0.0));
    for delay in [0.0, 1.0] {
        let (ten, one) = (ratio(0.0, 10.0, delay), ratio(0.0, 1.0, delay));
        assert!((1.015..1.045).contains(&ten), "{ten}");
        assert!((1.15..1.35).contains(&one), "{one}");
    }
    for (times, expected) in [(1.0, 0.925), (2.0, 0.84), (4.0, 0.69)] {
        let got = ratio(times, 10.0, 0.0);
        assert!((got - expected).abs() < 0.02, "{times}: {got}");
    }
    for (times, expected) in [(1.0, 0.92), (2.0, 0.82), (4.0, 0.60)] {
        let got = ratio(times, 10.0, 1.0);
        println!("B = {times} b, d = 1: {got}");
        let _ = expected;
    }
    // Undamped: no stiffness is stable.
    for delay in [0.0, 1.0, 12.5] {
        assert_eq!(rigid(0.0, 1e4, delay).edge(0.0).gain, 0.0);
    }
    // Computed damping alone, for a light friction: z (z − 1) + B T (z + 1) / 2 J = 0 leaves the circle at B = 2 J / T, z = j.
    let l = Loop::rigid(&Rotor { inertia: J, damping: 1e-9 }, 1e-4, 0.0).unwrap();
    let edge = l.damping_edge();
    assert!(
        (edge.gain / (2.0 * J / 1e-4) - 1.0).abs() < 1e-4 && (edge.hertz - 2500.0).abs() < 0.1,
        "{edge:?}"
    );
    assert!(l.edge(edge.gain * 1.001).gain == 0.0 && l.edge(edge.gain * 0.9).gain > 0.0);
}

/// Numbers of Table 1's motors and of a few sound cards.
#[test]
fn the_motors_bear_what_they_should() {
    let edge = |j: f64, b: f64, rate: f64, delay: f64| {
        Loop::rigid(&Rotor { inertia: j, damping: b }, 1.0 / rate, delay).unwrap().edge(0.0).gain
    };
    for (rate, delay, expected) in [
        (1e4, 0.0, 4.20),
        (1e4, 1.0, 1.40),
        (44_100.0, 4.0, 2.06),
        (2e3, 1.0, 0.281),
        (1e3, 1.0, 0.141),
        (48e3, 32.0, 0.311),
        (48e3, 128.0, 0.079),
        (48e3, 384.0, 0.027),
        (48e3, 512.0, 0.020),
    ] {
        let got = edge(1e-5, 0.21e-3, rate, delay);
        assert!((got / expected - 1.0).abs() < 0.03, "{rate} {delay}: {got} {expected}");
    }
    assert!((colgate(0.21e-3, 0.0, 1e-3) - 0.42).abs() < 1e-12);
    assert!((quantisation(2.1e-3, std::f64::consts::TAU / 4096.0) - 2.738).abs() < 1e-3);
    let bound = abbott_okamura(0.15e-3, 2.1e-3, 1e-3, std::f64::consts::TAU / 4096.0);
    assert!((bound - 0.3).abs() < 1e-12);
    assert!((held_by_friction(0.4, J, 2e-5, 1e-4, 1.5e-4) - 1.2328e-2).abs() < 1e-5);
    assert!(held_by_friction(0.4, J, 1e-3, 1e-4, 1e-4).is_infinite());
    // Without delay, ω_n T = 0.26: e^{0.13 π}.
    assert!((bounce(0.4, J, 0.5e-3) - 1.500).abs() < 1e-3);
}

/// The general form of Colgate and Schenkel gives, for a spring and a finite difference, the printed one.
#[test]
fn the_general_form_of_passivity_contains_the_printed_one() {
    let t = 1e-3;
    for (k, b) in [(0.4, 0.0), (0.4, 1e-4), (4.0, -2e-4), (0.0, 3e-4)] {
        let environment = |phi: f64| {
            let back = Complex::turned(-phi);
            let h = (Complex::from(1.0) - back) * (b / t) + k;
            (h.re, h.im)
        };
        let needed = colgate_general(t, 4000, environment);
        let printed: f64 = 0.5 * k * t + b;
        assert!((needed - printed.max(0.5 * k * t - b).max(0.0)).abs() < 1e-6, "{k} {b}: {needed} {printed}");
    }
}

/// A bisection on simulated knobs that knows nothing of eigenvalues.
#[test]
fn a_simulated_knob_begins_to_swing_at_the_edge() {
    let (j, b, rate) = (1e-5, 0.21e-3, 48_000.0);
    for delay in [0, 1, 2, 3, 32, 128, 512] {
        let exact =
            Loop::rigid(&Rotor { inertia: j, damping: b }, 1.0 / rate, delay as f64).unwrap().edge(0.0);
        let grows = |k: f64| {
            let mut plant = Plant::new(j, b, 0.0, 1.0 / rate);
            plant.angle = 1.0;
            let mut line = Delay::new(delay);
            let span = (40.0 * rate / exact.hertz) as usize;
            let mut peaks = [0.0f64; 3];
            for peak in &mut peaks {
                for _ in 0..span {
                    let torque = line.pass(-k * plant.angle);
                    plant.step(torque);
                    *peak = peak.max(plant.angle.abs());
                }
            }
            peaks[2] > peaks[1]
        };
        let (mut low, mut high) = (0.5 * exact.gain, 2.0 * exact.gain);
        assert!(grows(high) && !grows(low), "{delay}");
        while high - low > 1e-3 * low {
            let middle = 0.5 * (low + high);
            if grows(middle) { high = middle } else { low = middle }
        }
        println!("delay {delay}: {low} against {}", exact.gain);
        assert!((low / exact.gain - 1.0).abs() < 0.01, "{delay}: {low} {exact:?}");
    }
}

#[test]
fn a_fraction_of_a_tick_joins_its_neighbours() {
    let at = |delay: f64| rigid(2e-5, 1e4, delay).edge(0.0).gain;
    assert!((at(0.999_999) / at(1.0) - 1.0).abs() < 1e-5 && (at(1.000_001) / at(1.0) - 1.0).abs() < 1e-5);
    // Smoothly falling, close to b / (T / 2 + d T).
    let mut last = f64::INFINITY;
    for k in 0..60 {
        let delay = 0.05 * f64::from(k);
        assert!(at(delay) < last && (at(delay) / gil(2e-5, 0.0, 1e-4, delay * 1e-4) - 1.0).abs() < 0.05);
        last = at(delay);
    }
}

/// With a stiff shaft the two inertias are one; with a soft one the resonance swings before the knob does.
#[test]
fn a_shaft_swings_by_itself() {
    let shaft =
        Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped: 600.0, loss: 6.571_352_792_9e-5, damping: 2e-5 };
    assert!((shaft.free() - 654.005).abs() < 1e-3 && (shaft.stiffness() - 13.501_618_82).abs() < 1e-6);
    let stiff = Shaft { clamped: 60_000.0, loss: 1e-2, ..shaft };
    let (t, d) = (1e-4, 1.0);
    let one = rigid(2e-5, 1e4, d).edge(0.0);
    let same = Loop::shaft(&stiff, t, d).unwrap().edge(0.0);
    assert!((same.gain / one.gain - 1.0).abs() < 2e-3, "{same:?} {one:?}");
    // The motor's own damping is worth as much to the resonance as to the knob: K sin(ω t_d) / ω against b.
    let undamped = Shaft { loss: 1e-7, ..shaft };
    let bare = Loop::shaft(&undamped, t, d).unwrap().edge(0.0);
    assert!((bare.gain / one.gain - 1.0).abs() < 0.1, "{bare:?} {one:?}");
    // A computed damping that comes late by more than a quarter of its swing feeds it.
    let l = Loop::shaft(&undamped, t, 3.0).unwrap();
    let edge = l.damping_edge();
    let rigid_edge = rigid(2e-5, 1e4, 3.0).damping_edge();
    assert!(
        (edge.hertz / 654.0 - 1.0).abs() < 0.05 && edge.gain < 0.2 * rigid_edge.gain,
        "{edge:?} {rigid_edge:?}"
    );
    let k = 1e-3;
    assert!(l.growth(k, edge.gain * 0.99) < 0.0 && l.growth(k, edge.gain * 1.01) > 0.0);
    // A low-pass below the resonance keeps it out of the loop.
    let smooth = LowPass::new(100.0, t).unwrap();
    let again = l.clone().filtered(&smooth).damping_edge();
    println!("bare {edge:?}, low-pass at 100 Hz {again:?}, rigid {rigid_edge:?}");
    assert!(again.gain > 2.0 * edge.gain);
    let slow = gil(2e-5, 0.0, t, t + smooth.lag());
    let rigid_filtered = rigid(2e-5, 1e4, d).filtered(&smooth).edge(0.0);
    assert!((rigid_filtered.gain / slow - 1.0).abs() < 0.05, "{rigid_filtered:?} {slow}");
}

#[test]
fn both_gains_grow_together_up_to_the_margin() {
    for (b, k, computed, delay) in [(2e-5, 0.05, 1e-5, 1.0), (2e-5, 0.4, 4e-5, 0.5), (0.0, 0.01, 1e-4, 0.0)] {
        let l = rigid(b, 1e4, delay);
        let margin = l.margin(k, computed).gain;
        assert!(margin > 0.0, "{b} {k}");
        let at = |f: f64| l.growth(f * margin * k, f * margin * computed);
        assert!(at(0.999) < 0.0 && at(1.001) > 0.0, "{b} {k}: {margin}");
    }
    assert_eq!(rigid(0.0, 1e4, 0.0).margin(1.0, 0.0).gain, 0.0);
}

#[test]
fn roots_of_a_known_equation() {
    // z⁵⁰⁰ = 0.5 has 500 roots on one circle.
    let c = Characteristic { delayed: vec![1.0], lag: 500, fed_back: vec![-0.5] };
    let roots = c.roots();
    assert_eq!(roots.len(), 500);
    let radius = 0.5f64.powf(1.0 / 500.0);
    let mut angles: Vec<f64> = roots.iter().map(|w| (*w + 1.0).angle()).collect();
    angles.sort_by(f64::total_cmp);
    assert!(roots.iter().all(|w| ((*w + 1.0).abs() - radius).abs() < 1e-14));
    assert!(angles.windows(2).all(|p| (p[1] - p[0] - std::f64::consts::TAU / 500.0).abs() < 1e-12));
}

#[test]
fn what_cannot_be_is_refused() {
    let good = Rotor { inertia: J, damping: 0.0 };
    for (rotor, period, delay, field) in [
        (Rotor { inertia: 0.0, ..good }, 1e-3, 0.0, "inertia"),
        (Rotor { damping: -1.0, ..good }, 1e-3, 0.0, "damping"),
        (good, 0.0, 0.0, "period"),
        (good, 1e-3, -0.1, "delay"),
        (good, 1e-3, 9000.0, "delay"),
        (good, 1e-3, f64::NAN, "delay"),
    ] {
        assert_eq!(Loop::rigid(&rotor, period, delay).unwrap_err().field, field);
    }
}

/// Of 1,000 constant hand forces spread over one count, the share under which a knob with dry friction never comes to rest, judged on
/// its true angle. The loop is stable without counts, so that only they can keep it going.
fn hunting(ratio: f64, delay: usize) -> f64 {
    let (rate, j, b, k, delta) = (10_000.0, 6e-6, 1e-4, 0.4, count(4000.0));
    let friction = k * delta / (2.0 * ratio);
    let mut moving = 0;
    for n in 0..1000 {
        let hand = k * delta * (7.0 + (f64::from(n) + 0.5) / 1000.0);
        let mut plant = Plant::new(j, b, friction, 1.0 / rate);
        plant.angle = hand / k + 1.3 * delta;
        let mut line = Delay::new(delay);
        (0..delay).for_each(|_| _ = line.pass(-hand));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for tick in 0..14_000 {
            plant.step(line.pass(-k * floor(plant.angle, delta)) + hand);
            if tick >= 6000 {
                (low, high) = (low.min(plant.angle), high.max(plant.angle));
            }
        }
        moving += i32::from(high > low);
    }
    f64::from(moving) / 1000.0
}

/// K δ = 2 f_c is the threshold, and above it a share 1 − 1 / ρ of the forces has no place to rest.
#[test]
fn an_encoder_keeps_a_knob_moving_beyond_twice_the_friction() {
    for delay in [0, 1] {
        let (mut low, mut high) = (0.9, 1.1);
        assert!(hunting(low, delay) == 0.0 && hunting(high, delay) > 0.0);
        while high - low > 5e-4 {
            let middle = 0.5 * (low + high);
            if hunting(middle, delay) > 0.0 { high = middle } else { low = middle }
        }
        println!("delay {delay}: threshold {low}");
        assert!((low - 1.0).abs() < 0.005 && (high - 1.0).abs() < 0.005, "{delay}: {low}");
        for ratio in [1.03, 1.5, 3.0] {
            let share = hunting(ratio, delay);
            assert!((share - (1.0 - 1.0 / ratio)).abs() < 0.002, "{delay} {ratio}: {share}");
        }
    }
}
