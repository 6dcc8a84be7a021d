//! Knobs: servo, what a line works out, and both in the engine.

use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

use crate::common::{compiled, patch};
use crate::counter::counted;

/// A knob of every build and its servo, with readings and torques that are no numbers among them.
#[test]
fn a_knob_and_its_servo_take_no_memory() {
    use pacinian::knob::effect::events::Events;
    use pacinian::knob::effect::program::Program;
    use pacinian::knob::effect::{Reading, detent, friction, inertia, transient, wall};
    use pacinian::knob::governor::device::{Delay, Device};
    use pacinian::knob::governor::{Governor, MARGIN};
    use pacinian::knob::plant::Plant;
    use pacinian::knob::plant::encoder::Encoder;
    use pacinian::knob::plant::parameters::Parameters;
    use pacinian::knob::plant::parts::{Build, Drive, Grasp, Hand, Shaft, Winding};
    use pacinian::knob::plant::stops::Stops;
    use pacinian::knob::plant::wave::Wave;
    use pacinian::knob::safety::chain::{Chain, Input, Limits};
    use pacinian::knob::velocity::{Estimator, adaptive, kalman};

    let (rate, encoder) = (10_000.0, Encoder::new(1000.0).unwrap());
    let (dt, count) = (1.0 / rate, encoder.quantum());
    let stops = Some(Stops { low: -1.0, high: 1.0, stiffness: 40.0, damping: 1e-3 });
    let plain = Parameters { coulomb: 1e-3, stiction: 1.3e-3, stops, ..Parameters::default() };
    let winding = Winding { resistance: 1.26, inductance: 0.15e-3, gain: 16.3e-3, supply: 18.0 };
    let whole = Build {
        parameters: plain,
        shaft: Some(Shaft { inertia: 5e-6, viscous: 1e-6, stiffness: 13.5, damping: 6e-5 }),
        drive: Drive::Current { winding, bandwidth: 6e3, peak: 7.0 },
        grasp: Some(Grasp { stiffness: 0.3, damping: 2e-3 }),
        cogging: Wave::detent(1e-3, 7.0).unwrap(),
        ..Build::default()
    };
    let device = Device {
        inertia: 6e-6,
        damping: 2e-5,
        friction: Some(1e-3),
        count,
        period: dt,
        delay: Delay::ticks(1.0),
        resonance: None,
        low_pass: None,
        velocity: pacinian::knob::velocity::choice::Choice::Adaptive(0.01),
        peak: 0.175,
    };
    let governor = Governor::new(&device, MARGIN).unwrap();
    let limits = Limits {
        period: dt,
        slew: 100.0,
        low_pass: Some(2000.0),
        continuous: 0.023,
        winding: 12.0,
        peak: 0.175,
        soft_start: 0.1,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    };
    for build in [Build { parameters: plain, ..Build::default() }, whole] {
        let mut plant = Plant::new(&build, rate).unwrap();
        let mut program = Program::new(vec![
            wall::Stops { low: -0.8, high: 0.8, stiffness: 1.0, damping: 1e-3 }.into(),
            detent::Detent::with_stiffness(24.0, 0.1).into(),
            friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
            inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 1e-3 }.into(),
            transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.02, least: 0.01, most: 0.05 }
                .into(),
        ])
        .unwrap();
        let mut chain = Chain::new(&limits).unwrap();
        let mut estimators: [Box<dyn Estimator>; 2] = [
            Box::new(kalman::Kalman::new(50.0, count, dt).unwrap()),
            Box::new(adaptive::Adaptive::new(adaptive::Fit::Best, 32, count, dt).unwrap()),
        ];
        let (mut events, mut happened) = (Events::default(), 0);
        let total = counted(|| {
            for tick in 0..20_000_u32 {
                if tick % 3000 == 0 {
                    chain.acknowledge();
                    chain.arm();
                }
                let angle = if tick % 2999 == 2998 { f64::NAN } else { encoder.read(plant.angle()) };
                let velocity = estimators[tick as usize / 10_000].push(angle);
                let allowed = governor.allow(&program.demand());
                let reading = Reading { angle, velocity, dt };
                let torque = program.tick(&reading, allowed.stiffness, allowed.damping, &mut events);
                happened += events.list().len();
                let governed = allowed.acted();
                let input = Input {
                    torque,
                    angle,
                    velocity,
                    fresh: tick % 7 != 0,
                    in_time: tick % 5000 != 4999,
                    governed,
                };
                let command = chain.tick(&input).torque;
                let push =
                    if tick % 1013 == 1012 { f64::INFINITY } else { 0.01 * (f64::from(tick) * 1e-3).sin() };
                let (target, target_speed) =
                    (1.1 * (f64::from(tick) * 2e-3).sin(), 22.0 * (f64::from(tick) * 2e-3).cos());
                plant.step(command, &Hand { torque: push, target, target_speed });
            }
        });
        assert_eq!(total, 0, "allocations and frees");
        assert!(happened > 10 && plant.counts().masked > 10 && plant.angle().is_finite(), "{happened}");
    }
}

/// What a servo leaves to the thread of a line, with effects that remember, and what that makes of it.
#[cfg(feature = "live")]
#[test]
fn a_profile_takes_no_memory() {
    use pacinian::knob::effect::{detent, friction, inertia, transient, wall};
    use pacinian::knob::governor::device::{Delay, Device};
    use pacinian::knob::safety::chain::Limits;
    use pacinian::knob::servo::setup::Setup;
    use pacinian::knob::servo::tick::Servo;
    use pacinian::live::local::{Bounds, Counts, Local, Told};

    let device = Device {
        inertia: 2e-5,
        damping: 4e-4,
        friction: None,
        count: 1e-4,
        period: 1.0 / 8000.0,
        delay: Delay { local: Some(12.0), ..Delay::ticks(40.0) },
        resonance: None,
        low_pass: None,
        velocity: pacinian::knob::velocity::choice::Choice::Adaptive(0.01),
        peak: 0.05,
    };
    let limits = Limits {
        period: device.period,
        slew: 100.0,
        low_pass: None,
        continuous: 0.02,
        winding: 12.0,
        peak: 0.05,
        soft_start: 0.1,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    };
    let effects = vec![
        wall::Stops { low: -0.3, high: 0.3, stiffness: 0.05, damping: 1e-4 }.into(),
        detent::Detent::with_stiffness(24.0, 0.01).into(),
        friction::Friction { torque: 1e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
        inertia::Inertia { inertia: 1e-4, stiffness: 0.01, damping: 1e-4 }.into(),
        transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.02, least: 0.01, most: 0.05 }.into(),
    ];
    let mut servo = Servo::new(&Setup::new(effects, device, limits)).unwrap();
    servo.arm();
    let budget = limits.budget().unwrap();
    let bounds = Bounds { slew: 100.0, over_speed: 60.0, inverted: false, budget };
    let (mut local, counts, mut most) = (Local::new(bounds), Counts::default(), 0.0_f64);
    let total = counted(|| {
        for n in 0..4000_u64 {
            let angle = 0.4 * (n as f64 * 2e-3).sin();
            servo.tick((n % 9 != 0).then_some(angle), true);
            let told = Told { number: n + 1, stamp: n + 1, heard: angle, profile: servo.profile() };
            local.take(&told, &counts);
            let read = if n % 501 == 500 { f64::NAN } else { angle + 0.02 };
            most = most.max(local.torque(n * 125_000, read, 1.0, &counts).abs());
        }
    });
    assert_eq!(total, 0, "allocations and frees");
    assert!(most > 1e-3 && counts.now().taken == 4000);
}

/// A scene with a knob: turned, pushed by what is no number, silenced, armed, sent worlds, and swapped for another while it turns.
#[test]
fn a_knob_in_the_engine_takes_no_memory() {
    use pacinian::knob::local_model::model::LocalModel;
    use pacinian::knob::local_model::pending::Message;

    let text = |torque: f64| {
        format!(
            "[knob.effects]\n\
             notches = {{ type = \"detents\", count = 24, torque = {torque}, gain = \"1 + 0.2 * slow\" }}\n\
             ends = {{ type = \"end-stops\", low = -1, high = 1, stiffness = 0.3 }}\n\
             [shared.nodes]\nslow = {{ type = \"lfo\", rate = 3 }}\n\
             [voice.v]\nvoices = 4\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = \"200 + knob.angle\" }}\n\
             [[trigger]]\non = \"knob.detent\"\nplay = \"v\"\nset = {{ level = \"min(1, speed / 9)\" }}\n\
             [[trigger]]\non = \"knob.wall ends\"\nplay = \"v\"\n"
        )
    };
    let plans = [0.01, 0.02].map(|torque| compiled(&text(torque), 4, 48_000.0).plan);
    let hand = plans[0].control("hand").unwrap();
    let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
    let mut slow = stagehand.engine().link_knob().unwrap();
    let mut frames = vec![0.0; 480 * 4];
    let (mut total, mut started) = (0, 0);
    for n in 0..300_u64 {
        let model = LocalModel { stamp: n, stiffness: 0.05, ..LocalModel::FREE };
        slow.send(Message::new(model, 1e-6));
        if n % 40 == 39 {
            assert!(director.send(&plans[(n / 40 % 2) as usize]).unwrap());
        }
        total += counted(|| {
            stagehand.take_over();
            let engine = stagehand.engine();
            let now = Instant { sample: engine.clock(), fraction: 0 };
            let angle = 1.4 * (n as f64 * 0.2).sin();
            engine.schedule(now, Source::Program, Event::Glide(hand, angle, 0.01));
            match n % 50 {
                17 => drop(engine.schedule(now, Source::Program, Event::Push(f64::NAN))),
                23 => drop(engine.schedule(now, Source::Program, Event::Silence(0, 64))),
                31 => drop(engine.schedule(now, Source::Program, Event::Arm(true))),
                _ => {}
            }
            stagehand.process(&[], &mut frames);
        });
        started = stagehand.engine().counters().started;
        director.collect();
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(started > 100 && slow.look().tick > 20_000, "{started} {:?}", slow.look());
}

/// A knob that is there: read by every sensor, in blocks of all lengths, lost, armed, late, and swapped for another while it turns.
#[test]
fn a_knob_that_is_there_takes_no_memory() {
    use pacinian::knob::angle::decoder::NOT_HEARD;

    for sensor in [
        "rate = 48000\nsensor = { type = \"sine-cosine\", sine_channel = 1, cosine_channel = 2 }",
        "counts = 400\nsensor = { type = \"quadrature\", a_channel = 1, b_channel = 2 }",
        "sensor = { type = \"voltage\", channel = 2, full_scale_volts = 5, radians_per_volt = 1 }",
    ] {
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nrate = 48000\ncoupling = \"dc\"\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
             [[output]]\nkind = \"torque\"\nname = \"k\"\nchannel = 2\n[knob]\ninertia = 1e-5\nviscous = 1e-3\ndelay = 0\npeak_torque = 0.1\n{sensor}\n"
        );
        let rig = Rig::parse("r", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let plans = [0.01, 0.02].map(|torque| {
            let text = format!(
                "[knob.effects]\nnotches = {{ type = \"detents\", count = 24, torque = {torque} }}\n\
                 [voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = \"200 + knob.angle\" }}\n\
                 [[trigger]]\non = \"knob.detent\"\nplay = \"v\"\n"
            );
            let options = Options { live: true, attached: true, ..Options::default() };
            scene(&patch(&text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
        });
        let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
        let ears = stagehand.engine().input_channels();
        let (mut heard, mut frames) = (vec![0.0; 480 * ears], vec![0.0; 480 * 2]);
        let (mut total, mut most, mut at) = (0, 0.0_f32, 0.0_f32);
        for n in 0..400_usize {
            if n % 40 == 39 {
                assert!(director.send(&plans[n / 40 % 2]).unwrap());
            }
            let length = 1 + (n * 7919) % 480;
            for frame in heard.chunks_mut(ears).take(length) {
                at += 1e-3;
                let (angle, gone) = ((at * 0.2).sin(), n % 90 > 80);
                let values = if gone { [NOT_HEARD; 2] } else { [0.5 * angle.sin(), 0.5 * angle.cos()] };
                frame.copy_from_slice(&values[..ears]);
            }
            total += counted(|| {
                stagehand.take_over();
                let engine = stagehand.engine();
                let now = Instant { sample: engine.clock(), fraction: 0 };
                match n % 50 {
                    2 | 31 => drop(engine.schedule(now, Source::Program, Event::Arm(true))),
                    17 => drop(engine.schedule(now, Source::Program, Event::Deadline(false))),
                    19 => drop(engine.schedule(now, Source::Program, Event::Deadline(true))),
                    _ => {}
                }
                stagehand.process(&heard[..length * ears], &mut frames[..length * 2]);
            });
            most = frames[..length * 2].iter().skip(1).step_by(2).fold(most, |most, x| most.max(x.abs()));
            director.collect();
        }
        assert_eq!(total, 0, "allocations and frees, {sensor}");
        assert!(most > 0.0, "no torque, {sensor}");
    }
}
