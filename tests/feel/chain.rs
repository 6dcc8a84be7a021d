//! Card and amplifier on the way, and runs that are cut.

use std::f64::consts::TAU;

use super::{COIN, DC, RATE, TACTOR, close, coin, feel, felt, largest, lively, rig};
use pacinian::actuator::coil::model::Model;
use pacinian::actuator::coil::supply::Supply;
use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::link::coupling::{Corners, HighPass};
use pacinian::actuator::motor::{self, Drive, Motor, Plan};
use pacinian::feel::{Axis, Counts};
use pacinian::rig::{Coupling, Rig};

/// Behind capacitors: e^(−ωt) of one corner, (1 − ωt) e^(−ωt) of two that are alike; means over each frame, into the model itself.
#[test]
fn a_coupled_card_gives_what_its_closed_form_says() {
    let omega = TAU * 10.0;
    let first = |t: f64| -(-omega * t).exp() / omega;
    let second = |t: f64| t * (-omega * t).exp();
    let high_pass = "coupling = { high_pass = 10.0 }";
    let both = format!("gain = 1.5\nmax_volts = 12\n{high_pass}");
    for (keys, integral) in [
        ([high_pass, DC[1], ""], &first as &dyn Fn(f64) -> f64),
        ([DC[0], &both, ""], &first),
        ([high_pass, &both, ""], &second),
    ] {
        let rig = rig(TACTOR, keys);
        let (traces, _) = felt(&rig, RATE, &[1.0; 4800]);
        let mut model = Model::new(&rig.actuators[0].coil().unwrap(), RATE, Imposes::Voltage).unwrap();
        let (mut velocity, peak) = (0.0, largest(&traces[0]));
        for (n, is) in traces[0].iter().enumerate() {
            let volts = 3.0 * RATE * (integral((n + 1) as f64 / RATE) - integral(n as f64 / RATE));
            let now = model.step(volts).velocity;
            assert!((f64::from(*is) - (now - velocity) * RATE).abs() < 1e-6 * peak, "{n}: {is}");
            velocity = now;
        }
    }
}

/// A motor behind capacitors is no error here: it turns a little, and stops.
#[test]
fn a_motor_behind_capacitors_is_simulated_as_it_is() {
    let mut rig = rig(COIN, [DC[0], DC[1], "kind = \"drive\""]);
    rig.device.coupling = Some(Coupling::HighPass(10.0));
    assert!(rig.wiring(&rig.outputs[0]).unwrap().is_err(), "which a rendering refuses");
    let (traces, figures) = felt(&rig, RATE, &[1.0; 48_000]);
    assert!(figures.peak > 0.5 && figures.peak < 8.0, "{figures:?}");
    assert_eq!(largest(&traces[0][40_000..]), 0.0, "it stands");
}

#[test]
fn amplifiers_clip_turn_round_and_run_out_of_volts() {
    let samples = lively(9600);
    let loud: Vec<f32> = samples.iter().map(|x| 1.6 * x).collect();
    let cut = |most: f32| loud.iter().map(|x| x.clamp(-most, most)).collect::<Vec<f32>>();
    let (plain, _) = felt(&rig(TACTOR, DC), RATE, &samples);
    let (turned, _) =
        felt(&rig(TACTOR, [DC[0], "gain = -1.5\nmax_volts = 12\ncoupling = \"dc\"", ""]), RATE, &samples);
    assert!(plain[0].iter().zip(&turned[0]).all(|(a, b)| *a == -b) && largest(&plain[0]) > 1.0);
    // The card at full scale, the amplifier at 1.5 V of 3: as if no more had been played.
    let (full, figures) = felt(&rig(TACTOR, DC), RATE, &loud);
    assert_eq!(full, felt(&rig(TACTOR, DC), RATE, &cut(1.0)).0);
    let beyond = |most: f32| loud.iter().filter(|x| x.abs() > most).count() as u64;
    assert_eq!(figures.counts, Counts { clipped: beyond(1.0), limited: 0, masked: 0 });
    let small = [DC[0], "gain = 1.5\nmax_volts = 1.5\ncoupling = \"dc\"", ""];
    let (limited, figures) = felt(&rig(TACTOR, small), RATE, &loud);
    assert_eq!(limited, felt(&rig(TACTOR, DC), RATE, &cut(0.5)).0);
    assert_eq!(figures.counts, Counts { clipped: beyond(1.0), limited: beyond(0.5), masked: 0 });
    assert!(beyond(1.0) > 10 && beyond(0.5) > beyond(1.0));
    // A current amplifier of 3 V on a coil: the source with both limits, driving the model.
    let current = [DC[0], "gain = 0.5\nmax_volts = 3\ndrive = \"current\"\ncoupling = \"dc\"", ""];
    let both = rig(TACTOR, current);
    let (is, figures) = felt(&both, RATE, &samples);
    let mut model = Model::new(&both.actuators[0].coil().unwrap(), RATE, Imposes::Voltage).unwrap();
    let mut supply = Supply::new(Imposes::Current, Some(3.0), None).unwrap();
    let mut velocity = 0.0;
    for (sample, is) in samples.iter().zip(&is[0]).skip(1) {
        let now = supply.step(&mut model, f64::from(*sample) * 2.0 * 0.5).velocity;
        assert_eq!(*is, ((now - velocity) * RATE) as f32);
        velocity = now;
    }
    assert!(supply.limited() > 100);
    assert_eq!(figures.counts.limited, supply.limited());
    // And on a motor: amperes, with 3 V at most.
    let both = rig(COIN, current);
    let (is, figures) = felt(&both, RATE, &samples);
    let parameters = coin();
    let wish = motor::Wish { error: 0.5e-3, posture: false, casing: true };
    let mut motor = Motor::<true>::new(&parameters, &Plan::choose(&parameters, RATE, &wish), RATE).unwrap();
    let (mut last, mut limited) = (0.0, 0);
    for (sample, is) in samples.iter().zip(&is[0]) {
        let amperes = f64::from(*sample) * 2.0 * 0.5;
        motor.drive(Drive::Current { amperes, limit: 3.0 });
        motor.step();
        let now = motor.casing_velocity()[0];
        assert_eq!(*is, ((now - last) * RATE) as f32);
        last = now;
        limited += u64::from(motor.current() != amperes);
    }
    assert!(limited > 100 && figures.counts.limited == limited, "{limited} {figures:?}");
    close(figures.energy.unwrap(), motor.energy().supplied, 1e-2, "energy but for where limits are met");
}

/// A source of current without a limit is never at it: behind capacitors what is sent goes on as less and less, down to what no current is. What is
/// drawn is what the booked model says, whether there is a limit that is never met or none.
#[test]
fn without_a_limit_nothing_is_beyond_it() {
    let samples: Vec<f32> = lively(12_000).into_iter().chain(std::iter::repeat_n(0.0, 180_000)).collect();
    for (limit, corner) in [("", 10.0), ("\nmax_volts = 1000", 10.0), ("", 35.0), ("", 3.0)] {
        let amplifier = format!("gain = 0.05\ndrive = \"current\"\ncoupling = \"dc\"{limit}");
        let keys = format!("coupling = {{ high_pass = {corner:?} }}");
        let rig = rig(COIN, [&keys, &amplifier, ""]);
        let (_, figures) = felt(&rig, RATE, &samples);
        let parameters = coin();
        let wish = motor::Wish { error: 0.5e-3, posture: false, casing: true };
        let mut motor =
            Motor::<true>::new(&parameters, &Plan::choose(&parameters, RATE, &wish), RATE).unwrap();
        let mut passes = HighPass::new(&Corners::one(corner), RATE).unwrap();
        let mut smallest = f64::INFINITY;
        for sample in &samples {
            let amperes = passes.step(f64::from(*sample) * 2.0) * 0.05;
            smallest = smallest.min(if amperes == 0.0 { f64::INFINITY } else { amperes.abs() });
            motor.drive(Drive::Current { amperes, limit: f64::INFINITY });
            motor.step();
        }
        assert!(figures.peak > 0.1 && (corner < 5.0 || smallest < 1e-30), "{figures:?} {smallest}");
        assert_eq!(figures.counts, Counts::default(), "{limit} {corner}");
        close(figures.energy.unwrap(), motor.energy().supplied, 1e-9, "energy");
    }
}

#[test]
fn it_does_not_matter_how_a_run_is_cut() {
    let text = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\nfull_scale_volts = 2\ncoupling = {{ high_pass = 5 }}\n{}{}\
         [[output]]\nkind = \"raw\"\nname = \"m\"\nchannel = 3\nactuator = \"m\"\n[[tactor]]\nname = \"t\"\nchannel = 1\nactuator = \"a\"\n",
        COIN.replace(".a]", ".m]"),
        TACTOR
    );
    let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
    // Silence first: no model runs in it, wherever it is cut.
    let one = [vec![0.0; 777], lively(20_000)].concat();
    let frames: Vec<f32> = one.iter().flat_map(|x| [*x, 0.3, -*x]).collect();
    let (mut whole, mut due) = (feel(&rig, RATE), Vec::new());
    whole.process(&frames, &mut due);
    assert_eq!(due.len(), 3 * one.len(), "a tactor's trace and a motor's two");
    assert_eq!(
        whole.traces().iter().map(|t| t.axis).collect::<Vec<_>>(),
        [Axis::Contactor, Axis::Across, Axis::Upright]
    );
    assert!((0..3).all(|n| due.iter().skip(n).step_by(3).any(|x| x.abs() > 0.1)));
    for lengths in [&[1_usize][..], &[2, 5], &[3], &[192, 7, 1000, 0], &[767, 768, 769, 4096]] {
        let (mut cut, mut all, mut some, mut rest) = (feel(&rig, RATE), Vec::new(), Vec::new(), &frames[..]);
        for length in lengths.iter().cycle() {
            let (now, later) = rest.split_at(rest.len().min(*length));
            cut.process(now, &mut some);
            all.extend_from_slice(&some);
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        assert!(all == due, "{lengths:?}");
        assert_eq!(
            cut.felt().iter().map(|f| f.figures()).collect::<Vec<_>>(),
            whole.felt().iter().map(|f| f.figures()).collect::<Vec<_>>()
        );
    }
}
