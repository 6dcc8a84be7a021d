//! Rumble motors: against the model itself, closed forms, finer steps.

use super::{COIN, DC, RATE, close, coin, feel, felt, largest, lively, rig};
use pacinian::actuator::motor::{self, Casing, Drive, Level, Motor, Plan};
use pacinian::feel::{Counts, Feel, Unit, Wish};
use pacinian::rig::part;

/// A motor: the mean of the casing's acceleration over each frame, from nothing but speed and angle, and the energy of the motor's own book.
#[test]
fn a_motor_is_felt_as_its_model_turns() {
    let samples = lively(48_000);
    for (keys, tilt) in [(["", "kind = \"drive\"\ntilt = 0.3"], Some(0.3_f64)), (["", ""], None)] {
        let (traces, figures) = felt(&rig(COIN, [DC[0], DC[1], keys[1]]), RATE, &samples);
        let mut parameters = coin();
        parameters.gravity = tilt.map_or(0.0, |tilt| motor::GRAVITY * tilt.cos());
        let wish = motor::Wish { error: 0.5e-3, posture: tilt.is_some(), casing: true };
        let plan = Plan::choose(&parameters, RATE, &wish);
        let mut motor = Motor::<true>::new(&parameters, &plan, RATE).unwrap();
        let share = parameters.eccentric / parameters.casing.mass().unwrap();
        let (mut last, mut fastest, mut peak, mut at, mut squares) = ([0.0; 2], 0.0_f64, 0.0, 0, 0.0);
        for (n, sample) in samples.iter().enumerate() {
            motor.drive(Drive::Voltage(f64::from(*sample) * 2.0 * 1.5));
            motor.step();
            let now = motor.reading();
            // The mass moves against the casing: X = −μ sin θ, and upright μ cos θ.
            let velocity = [-share * now.speed * now.angle.cos(), -share * now.speed * now.angle.sin()];
            let due = [0, 1].map(|axis| (velocity[axis] - last[axis]) * RATE);
            for axis in [0, 1] {
                let is = f64::from(traces[axis][n]);
                assert!((is - due[axis]).abs() <= 1e-7 * due[axis].abs() + 1e-9, "{n}: {is} {}", due[axis]);
            }
            let size = due[0].hypot(due[1]);
            if size > peak {
                (peak, at) = (size, n);
            }
            squares += size * size;
            fastest = fastest.max(now.speed.abs());
            last = velocity;
        }
        close(figures.peak, peak, 1e-9, "peak");
        assert_eq!(figures.peak_at, at as f64 / RATE);
        close(figures.rms, (squares / samples.len() as f64).sqrt(), 1e-9, "rms");
        assert_eq!(figures.fastest, Some(fastest));
        assert!(figures.peak > 5.0 && figures.rms < 0.8 * figures.peak, "{figures:?}");
        // The book integrates currents, we count charges.
        close(figures.energy.unwrap(), motor.energy().supplied, 1e-6, "energy");
        assert_eq!((figures.farthest, figures.warmest, figures.counts), (None, None, Counts::default()));
    }
}

/// m_e r ω²/M at the speed where what the voltage drives and friction takes are even; the mean over a frame of what turns by x in it is
/// sin(x/2)/(x/2) of it.
#[test]
fn a_steady_voltage_shakes_as_the_closed_form_says() {
    for (rate, seconds, sample) in [(48_000.0, 1.0, 0.9_f32), (8000.0, 1.5, -0.5)] {
        let (traces, figures) = felt(&rig(COIN, DC), rate, &vec![sample; (rate * seconds) as usize]);
        let p = coin();
        let volts = 3.0 * f64::from(sample.abs());
        let speed =
            (p.gain * volts / p.resistance - p.coulomb) / (p.viscous + p.gain * p.gain / p.resistance);
        let half = 0.5 * speed / rate;
        let due = p.eccentric * speed * speed / 0.1 * half.sin() / half;
        let from = traces[0].len() - 500;
        for (x, y) in traces[0][from..].iter().zip(&traces[1][from..]) {
            close(f64::from(x.hypot(*y)), due, 1e-6, "steady");
        }
        close(figures.fastest.unwrap(), speed, 1e-6, "speed");
        // At rest it hangs down; begun forward, it goes the way of its first quarter turn: against the casing, to the left.
        let first = traces[0].iter().position(|x| *x != 0.0).unwrap();
        assert_eq!(traces[0][first + 1] < 0.0, sample > 0.0);
    }
}

/// A casing on springs: means of what the motor reads at 64 times the rate.
#[test]
fn a_casing_on_springs_is_felt_as_finer_steps_have_it() {
    let sprung = format!("{COIN}mount_stiffness = 30000\nmount_damping = 8\n");
    let samples = vec![0.8; 9600];
    let (traces, _) = felt(&rig(&sprung, DC), RATE, &samples);
    let parameters = rig(&sprung, DC).actuators[0].rumble_motor().unwrap();
    let fine = 64;
    let mut motor =
        Motor::<false>::new(&parameters, &Plan::whole(Level::Fine), RATE * f64::from(fine)).unwrap();
    let (peak, mut before) = (largest(&traces[0]), [0.0; 2]);
    motor.drive(Drive::Voltage(2.4));
    for n in 0..samples.len() {
        let mut sum = [0.0; 2];
        for _ in 0..fine {
            motor.step();
            let now = motor.acceleration();
            sum = [0, 1].map(|axis| sum[axis] + 0.5 * (before[axis] + now[axis]));
            before = now;
        }
        for axis in [0, 1] {
            let (is, due) = (f64::from(traces[axis][n]), sum[axis] / f64::from(fine));
            // Breaking away from rest is a jump, of which the trapezoid takes half a fine step wrong.
            assert!(n < 50 || (is - due).abs() < 2e-4 * peak, "{n} {axis}: {is} {due} of {peak}");
        }
    }
}

/// Of a motor that nothing is known to move with, the force: m_e r ω².
#[test]
fn what_does_not_move_is_pushed() {
    let held = "[actuator.a]\nmodel = \"rumble-motor\"\nrated_volts = 3\nresistance = 30\ntorque_constant = 0.955e-3\ninertia = 1.8e-9\n\
        viscous_friction = 2.15e-8\ncoulomb_friction = 1.5e-5\neccentric_moment = 7.3e-7\n";
    let rig = rig(held, DC);
    let feel = feel(&rig, RATE);
    assert!(feel.traces().iter().all(|trace| trace.unit == Unit::Force));
    let told: Vec<String> = feel.traces().iter().map(ToString::to_string).collect();
    assert_eq!(told, ["o, across, N", "o, upright, N"]);
    assert!(feel.felt()[0].assumed.iter().any(|a| a.contains("`mass`")), "{:?}", feel.felt()[0].assumed);
    let p = rig.actuators[0].rumble_motor().unwrap();
    assert_eq!(p.casing, Casing::Held);
    let (traces, _) = felt(&rig, RATE, &vec![1.0; 48_000]);
    let (speed, last) = (p.steady_speed(3.0), traces[0].len() - 1);
    let half = 0.5 * speed / RATE;
    let due = p.eccentric * speed * speed * half.sin() / half;
    close(f64::from(traces[0][last].hypot(traces[1][last])), due, 1e-6, "force");
}

/// Every motor that ships, however it is held, is felt within the wish of what the finest steps at eight times the rate make.
#[test]
fn motors_are_as_exact_as_is_wished() {
    let mut levels = Vec::new();
    for part in part::all().iter().filter(|part| part.model == pacinian::rig::Model::RumbleMotor) {
        let volts = part.values["rated_volts"].value;
        for (rate, tilt, error) in [
            (48_000.0, Some(0.0), 1e-3),
            (8000.0, Some(0.5), 1e-3),
            (8000.0, Some(0.0), 2e-7),
            (1000.0, Some(0.0), 1e-5),
            (48_000.0, None, 1e-3),
        ] {
            let keys = tilt.map_or("kind = \"drive\"".to_string(), |tilt: f64| {
                format!("kind = \"drive\"\ntilt = {tilt}")
            });
            let actuator = format!("[actuator.a]\npart = \"{}\"\n", part.name);
            let amplifier = format!("gain = {}\ncoupling = \"dc\"", 0.5 * volts);
            let rig = rig(&actuator, [DC[0], &amplifier, &keys]);
            let mut feel = Feel::new(&rig, 1, rate, &Wish { error }).unwrap();
            levels.push((feel.felt()[0].level(), feel.felt()[0].steps()));
            // Up, held, reversed, let down: a tenth of a second each or more.
            let count = (0.8 * rate) as usize;
            let at = |n: usize| [1.0, 1.0, 1.0, -1.0, -1.0, 0.4, 0.0, 0.0][(n * 8 / count).min(7)];
            let samples: Vec<f32> = (0..count).map(at).collect();
            let mut frames = Vec::new();
            feel.process(&samples, &mut frames);
            let mut parameters = rig.actuators[0].rumble_motor().unwrap();
            parameters.gravity = tilt.map_or(0.0, |tilt| motor::GRAVITY * tilt.cos());
            let mut fine = Motor::<false>::new(&parameters, &Plan::whole(Level::Fine), 8.0 * rate).unwrap();
            let rated = parameters.rated_acceleration().unwrap();
            let (mut last, mut apart) = ([0.0; 2], Vec::new());
            for (n, sample) in samples.iter().enumerate() {
                fine.drive(Drive::Voltage(f64::from(*sample) * volts));
                (0..8).for_each(|_| fine.step());
                let now = fine.casing_velocity();
                let due = ((now[0] - last[0]) * rate).hypot((now[1] - last[1]) * rate);
                let is = f64::from(frames[2 * n]).hypot(f64::from(frames[2 * n + 1]));
                apart.push((is - due) / rated);
                last = now;
            }
            let window = (1e-3 * rate) as usize;
            let means = apart.windows(window).map(|w| w.iter().sum::<f64>() / window as f64);
            let worst = means.fold(0.0_f64, |worst, mean| worst.max(mean.abs()));
            assert!(
                worst <= error,
                "{} at {rate}, {tilt:?}: {worst:e} for {error:e}, {:?}",
                part.name,
                levels.last()
            );
        }
    }
    for level in [Level::Economy, Level::Default, Level::Fine] {
        assert!(levels.iter().any(|l| l.0 == Some(level)), "{level:?} of {levels:?}");
    }
    assert!(levels.iter().any(|l| l.1 > 1), "{levels:?}");
}

/// A bridge's lines do what they say: on, off, and which way; the rest is the motor at the bridge's supply.
#[test]
fn a_bridge_switches_its_supply() {
    let text = |amplifier: &str, output: &str| {
        format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 2.0\ncoupling = \"dc\"\n[amplifier.amp]\n{amplifier}\n\
             {COIN}[[output]]\nkind = \"drive\"\nname = \"out\"\nchannel = 1\nactuator = \"a\"\namplifier = \"amp\"\n{output}\n"
        )
    };
    let parsed = |text: &str| {
        pacinian::Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    };
    let bridge = parsed(&text("drive = \"bridge\"\nmax_volts = 2.4", "direction = 2\nmax_level = 0.5"));
    let direct = parsed(&text("gain = 1.2\ncoupling = \"dc\"", ""));
    // Pulses of all widths, forward and then backward; the direction says nothing while it is off.
    let pulses: Vec<[bool; 2]> =
        (0..48_000).map(|n| [n % 37 < n / 1000 % 38, n > 24_000 || n % 37 > 36]).collect();
    let lines = |[on, back]: &[bool; 2]| [f32::from(u8::from(*on)) * 0.5, f32::from(u8::from(*back)) * 0.5];
    let volts = |[on, back]: &[bool; 2]| {
        let way = if *back { -1.0 } else { 1.0 };
        [if *on { way } else { 0.0_f32 }, 0.3]
    };
    let run = |rig: &pacinian::Rig, frames: Vec<f32>| {
        let mut feel = Feel::new(rig, 2, RATE, &Wish::default()).unwrap();
        assert!(feel.unfelt().is_empty(), "{:?}", feel.unfelt());
        let mut felt = Vec::new();
        feel.process(&frames, &mut felt);
        felt
    };
    let one = run(&bridge, pulses.iter().flat_map(lines).collect());
    let other = run(&direct, pulses.iter().flat_map(volts).collect());
    assert!(one == other && largest(&one) > 1.0);
}
