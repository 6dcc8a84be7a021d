//! Knobs that are simulated, and know nothing of eigenvalues.

use super::super::sampled::{Loop, Rotor, Shaft};
use super::of_shaft;
use crate::knob::plant::Plant as Model;
use crate::knob::plant::parts::Hand;
use crate::knob::test_plant::{Delay, Plant, count, floor};

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

/// The same with a motor and a knob on a shaft, by the plant of the library: a stiff shaft, and one so soft that it moves the edge.
#[test]
fn a_simulated_shaft_begins_to_swing_at_the_edge() {
    let (damping, rate) = (2e-5, 10_000.0);
    for (clamped, loss) in [(600.0, 6.571_352_792_9e-5), (40.0, 2e-4)] {
        let shaft = Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped, loss, damping };
        let build = of_shaft(&shaft);
        for delay in [0, 1, 2, 3, 32, 128, 512] {
            let exact = Loop::shaft(&shaft, 1.0 / rate, delay as f64).unwrap().edge(0.0);
            let grows = |k: f64| {
                let mut model = Model::new(&build, rate).unwrap();
                model.place(1.0, 0.0).unwrap();
                let mut line = Delay::new(delay);
                let span = (30.0 * rate / exact.hertz) as usize;
                let mut peaks = [0.0f64; 3];
                for peak in &mut peaks {
                    for _ in 0..span {
                        let torque = line.pass(-k * model.angle());
                        model.step(torque, &Hand::default());
                        *peak = peak.max(model.angle().abs());
                        // Far beyond the edge it leaves what the plant tells apart.
                        if *peak > 1e9 {
                            return true;
                        }
                    }
                }
                peaks[2] > peaks[1]
            };
            let (mut low, mut high) = (0.5 * exact.gain, 2.0 * exact.gain);
            assert!(grows(high) && !grows(low), "{clamped} {delay}: {exact:?}");
            while high - low > 2e-3 * low {
                let middle = 0.5 * (low + high);
                if grows(middle) { high = middle } else { low = middle }
            }
            let one = Loop::rigid(&Rotor { inertia: 6e-6, damping }, 1.0 / rate, delay as f64).unwrap();
            println!("{clamped} Hz, delay {delay}: {low} against {exact:?}, rigid {}", one.edge(0.0).gain);
            assert!((low / exact.gain - 1.0).abs() < 0.01, "{clamped} {delay}: {low} {exact:?}");
        }
    }
}
