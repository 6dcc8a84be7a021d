//! A knob that is there: its angle comes in by a card's inputs, its torque leaves by an output.

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::engine::handover::Mismatch;
use pacinian::graph::knob::CELL;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::knob::angle::decoder::NOT_HEARD;
use pacinian::knob::safety::chain::Trip;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use std::f64::consts::TAU;

const RIG: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nrate = 48000\ncoupling = \"dc\"\n\
    [[tactor]]\nname = \"a\"\nchannel = 1\n[[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 2\n\
    [knob]\ninertia = 1e-5\nfriction = 1e-3\nviscous = 2e-4\npeak_torque = 0.1\nslew = 1e6\nover_speed = 500\n\
    output = { name = \"knob\", newton_metres = 0.1 }\n";

const PAIR: &str = "sensor = { type = \"sine-cosine\", sine_channel = 2, cosine_channel = 1, sine_amplitude = 0.4, cosine_amplitude = 0.45, \
    sine_middle = 0.02, phase = 0.05, periods = 2 }\n";
const LINES: &str = "counts = 4000\nsensor = { type = \"quadrature\", a_channel = 1, b_channel = 3 }\n";
const VOLTS: &str = "sensor = { type = \"voltage\", channel = 3, full_scale_volts = 5, radians_per_volt = -1.5, zero_volts = 0.5 }\n";

const SPRING: &str = "[knob.effects]\nspring = { type = \"spring\", stiffness = 0.004 }\n";

/// A frame of three inputs at an angle.
fn pair(angle: f64) -> [f32; 3] {
    [(0.45 * (2.0 * angle).cos()) as f32, (0.02 + 0.4 * (2.0 * angle + 0.05).sin()) as f32, 0.9]
}

fn lines(angle: f64) -> [f32; 3] {
    let state = (angle * 4000.0 / TAU).round() as i64;
    let [a, b] = [[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]][state.rem_euclid(4) as usize];
    [a, 0.9, b]
}

fn volts(angle: f64) -> [f32; 3] {
    [0.9, 0.9, ((0.5 - angle / 1.5) / 5.0) as f32]
}

type Frame = fn(f64) -> [f32; 3];

/// By each sensor: what the rig says, what comes in, and how finely it tells angles apart.
const SENSORS: [(&str, Frame, f64); 3] =
    [(PAIR, pair, 1e-6), (LINES, lines, 0.51 * TAU / 4000.0), (VOLTS, volts, 1e-6)];

fn compiled(knob: &str, effects: &str, options: &Options) -> Plan {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{effects}");
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::parse("r", format!("{RIG}{knob}").as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    scene(&patch, &rig, options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

fn attached() -> Options {
    Options { attached: true, ..Options::default() }
}

/// To and fro, by less than the voltage's input can say.
fn way(frame: f64) -> f64 {
    1.3 * (TAU * 3.0 * frame / 48_000.0).sin()
}

#[test]
fn every_sensor_is_read_at_every_tick_as_late_as_it_says() {
    for rate in [8000, 24_000, 48_000] {
        for (sensor, frame, fine) in SENSORS {
            let plan = compiled(&format!("rate = {rate}\n{sensor}"), SPRING, &attached());
            assert_eq!(plan.inputs().len(), if sensor == VOLTS { 1 } else { 2 });
            let knob = plan.knob.clone().unwrap();
            let (ticks, frames) = (knob.ticks as usize, knob.frames as usize);
            assert_eq!((ticks * 8000, ticks * frames, knob.model), (rate, 6, None));
            let mut engine = Engine::new(&plan).unwrap();
            let channels = engine.input_channels();
            let mut output = vec![0.0; 12];
            let late = knob.sensor.unwrap().late(frames);
            for sample in 0..4000_usize {
                let input: Vec<f32> =
                    (0..6).flat_map(|n| frame(way((6 * sample + n) as f64))[..channels].to_vec()).collect();
                engine.process_input(&input, &mut output);
                let last = engine.knob().unwrap().last();
                // The last tick of this sample had the reading that ended with the sample's first frame.
                let truth = way(6.0 * sample as f64 - if sample == 0 { 0.0 } else { late });
                assert!(
                    (last.angle - truth).abs() < fine + 1e-5,
                    "{rate} {sensor} {sample}: {last:?} {truth}"
                );
            }
            // Torque has risen, and leaves by its channel: 0.1 N m are a sample of 1.
            let last = engine.knob().unwrap().last();
            assert!((last.torque + 0.004 * last.angle * last.allowed.stiffness).abs() < 1e-12, "{last:?}");
            assert!((f64::from(output[11]) - last.torque / 0.1).abs() < 1e-6 && last.torque != 0.0);
        }
    }
}

#[test]
fn what_is_felt_is_the_same_however_a_run_is_cut_into_calls() {
    let effects = "[knob.effects]\nnotches = { type = \"detents\", count = 24, torque = 0.01 }\n\
        [voice.v]\noutput = \"o\"\nplace = \"a\"\nnodes.o = { type = \"sine\", frequency = 200, amplitude = \"e\" }\n\
        nodes.e = { type = \"envelope\", decay = 0.01, sustain = 0 }\n\
        [[trigger]]\non = \"knob.detent\"\nplay = \"v\"\n";
    for (sensor, frame, _) in SENSORS {
        for rate in [8000, 48_000] {
            let plan = compiled(&format!("rate = {rate}\ndelay = 0\n{sensor}"), effects, &attached());
            let channels = Engine::new(&plan).unwrap().input_channels();
            let input: Vec<f32> = (0..48_000)
                .flat_map(|n| {
                    let frame = if n % 7000 == 6900 { [NOT_HEARD; 3] } else { frame(way(f64::from(n))) };
                    frame[..channels].to_vec()
                })
                .collect();
            let run = |cuts: &[usize]| {
                let mut engine = Engine::new(&plan).unwrap();
                let mut output = vec![0.0; 2 * 48_000];
                let (mut at, mut cut) = (0, 0);
                while at < 48_000 {
                    let n = cuts[cut % cuts.len()].min(48_000 - at);
                    cut += 1;
                    engine.process_input(
                        &input[at * channels..(at + n) * channels],
                        &mut output[2 * at..2 * (at + n)],
                    );
                    at += n;
                }
                (output, engine.counters().started)
            };
            let (whole, started) = run(&[48_000]);
            assert!(
                started > 10 && whole.chunks(2).any(|frame| frame[1].abs() > 0.05),
                "{sensor}: {started}"
            );
            for cuts in [&[1][..], &[6], &[5, 64, 1, 513], &[256], &[47_999, 1]] {
                assert!(run(cuts).0 == whole, "{sensor} {rate}: calls of {cuts:?}");
            }
        }
    }
}

/// Torque (N m) of each frame, and the engine behind it, of a knob that stands at 1 rad; `heard` says what comes in.
struct Run {
    engine: Engine,
    frame: usize,
}

impl Run {
    fn new(knob: &str, live: bool) -> Self {
        let plan = compiled(knob, SPRING, &Options { live, ..attached() });
        Self { engine: Engine::new(&plan).unwrap(), frame: 0 }
    }

    fn torque(&mut self, frames: usize, heard: Option<[f32; 3]>) -> Vec<f64> {
        let channels = self.engine.input_channels();
        let mut torque = Vec::new();
        for _ in 0..frames {
            let mut output = [0.0; 2];
            match heard {
                Some(frame) => self.engine.process_input(&frame[..channels], &mut output),
                None => self.engine.process(&mut output),
            }
            torque.push(0.1 * f64::from(output[1]));
            self.frame += 1;
        }
        torque
    }

    fn tell(&mut self, event: Event) {
        let now = Instant { sample: self.engine.clock(), fraction: 0 };
        assert!(self.engine.schedule(now, Source::Program, event));
    }

    fn trip(&self) -> Option<Trip> {
        self.engine.knob().unwrap().servo().chain().trip()
    }
}

const FULL: f64 = -0.004;

#[test]
fn torque_waits_until_it_is_asked_for_and_rises_softly_once_the_angle_is_known() {
    let mut run = Run::new(PAIR, true);
    assert!(run.torque(24_000, Some(pair(1.0))).iter().all(|torque| *torque == 0.0), "nobody asked");
    run.tell(Event::Arm(true));
    let rising = run.torque(20_000, Some(pair(1.0)));
    // 0.3 s: 14,400 frames.
    assert!((rising[7200] / FULL - 0.5).abs() < 0.01 && (rising[15_000] / FULL - 1.0).abs() < 1e-4);
    assert!(rising.windows(2).all(|w| w[1] <= w[0]));
    run.tell(Event::Arm(false));
    // With the next cell, and what of a sample was computed already.
    let cell = 6 * (CELL as usize + 1);
    assert!(run.torque(2000, Some(pair(1.0)))[cell..].iter().all(|torque| *torque == 0.0));
    // Asked for before anything is heard, it waits for that.
    let mut run = Run::new(PAIR, true);
    run.tell(Event::Arm(true));
    assert!(run.torque(48_000, None).iter().all(|torque| *torque == 0.0));
    assert!(run.engine.knob().unwrap().is_asked() && run.trip().is_none());
    assert!((run.torque(20_000, Some(pair(1.0)))[19_999] / FULL - 1.0).abs() < 1e-4);
}

#[test]
fn torque_of_a_lost_sensor_falls_and_stays_away() {
    let gone: [(&str, Frame, Option<[f32; 3]>); 6] = [
        // Not plugged in; not heard; a broken pair; a cut wire; no numbers.
        (PAIR, pair, None),
        (PAIR, pair, Some([NOT_HEARD; 3])),
        (PAIR, pair, Some([0.0; 3])),
        (VOLTS, volts, Some([0.0, 0.0, 1.0])),
        (VOLTS, volts, Some([f32::NAN; 3])),
        (LINES, lines, Some([f32::INFINITY; 3])),
    ];
    for (sensor, frame, nothing) in gone {
        let mut run = Run::new(sensor, false);
        // An encoder counts from where it began.
        run.torque(100, Some(frame(0.0)));
        for n in 0..1000 {
            run.torque(1, Some(frame(f64::from(n) / 1000.0)));
        }
        let up = run.torque(24_000, Some(frame(1.0)));
        assert!((up[23_999] / FULL - 1.0).abs() < 1e-3, "{sensor}: {}", up[23_999]);
        let down = run.torque(4800, nothing);
        // 5 ms are 240 frames, and another 50 ms 2,400.
        assert!(down[..200].iter().all(|torque| (torque / FULL - 1.0).abs() < 1e-3), "{sensor}");
        assert!((down[300 + 1200] / FULL - 0.5).abs() < 0.1, "{sensor}: {}", down[1500]);
        assert!(down[2800..].iter().all(|torque| *torque == 0.0), "{sensor}");
        assert_eq!(run.trip(), Some(Trip::Lost));
        // It is back, and torque is not, until somebody asks.
        assert!(run.torque(24_000, Some(frame(1.0)))[100..].iter().all(|torque| *torque == 0.0));
        run.tell(Event::Arm(true));
        assert!(run.torque(24_000, Some(frame(1.0)))[23_999] < 0.9 * FULL, "{sensor}");
    }
}

#[test]
fn torque_falls_where_the_device_takes_longer_than_its_governor_was_told() {
    let mut run = Run::new(PAIR, false);
    run.torque(24_000, Some(pair(1.0)));
    run.tell(Event::Deadline(false));
    let down = run.torque(480, Some(pair(1.0)));
    assert!((down[479] / FULL - 0.8).abs() < 0.02, "a fifth of 50 ms: {}", down[479]);
    run.tell(Event::Deadline(true));
    let up = run.torque(9600, Some(pair(1.0)));
    assert!((up[9599] / FULL - 1.0).abs() < 1e-4 && run.trip().is_none(), "late for a moment");
    run.tell(Event::Deadline(false));
    assert!(run.torque(4800, Some(pair(1.0)))[2600..].iter().all(|torque| *torque == 0.0));
    assert_eq!(run.trip(), Some(Trip::Lost));
}

/// What blocks cost is in the delay that the governor is told of; what was measured is there instead.
#[test]
fn the_governor_is_told_how_late_a_card_is() {
    let delay = |knob: &str, block: Option<u32>| {
        let knob = compiled(knob, SPRING, &Options { block, ..attached() }).knob.unwrap();
        (knob.setup.device.delay.total() / (8000.0 * f64::from(knob.ticks)), knob.allowance)
    };
    for rate in [8000.0, 48_000.0] {
        let knob = format!("rate = {rate}\n{PAIR}");
        let frames = 48_000.0 / rate;
        // Five sixths of an engine sample, and half a tick's frames less one.
        let own = (6.0 - frames) / 48_000.0 + 0.5 * (frames - 1.0) / 48_000.0;
        for (block, seconds) in [(Some(16), 64.0 / 48e3), (Some(512), 2048.0 / 48e3), (None, 1024.0 / 48e3)] {
            let (all, allowed) = delay(&knob, block);
            assert!((all - own - seconds - 4e-3).abs() < 1e-9 && (allowed - seconds - 4e-3).abs() < 1e-12);
        }
        let (all, allowed) = delay(&format!("delay = 0.007\n{knob}"), Some(512));
        assert!((all - own - 7e-3).abs() < 1e-9 && allowed == 7e-3);
    }
    // Simulated, it is as late: what is tried without it holds with it.
    let simulated = compiled(PAIR, SPRING, &Options { block: Some(64), ..Options::default() }).knob.unwrap();
    let real = compiled(PAIR, SPRING, &Options { block: Some(64), ..attached() }).knob.unwrap();
    assert_eq!(simulated.setup, real.setup);
    assert_eq!(simulated.model.unwrap().delay, real.setup.late());
}

/// A rotor of the test's own, between the output of one block and the input of the next: at what the governor grants it comes to rest, and
/// at four times that, granted by a governor that was told nothing of the delay, it swings.
#[test]
fn a_rotor_in_the_loop_comes_to_rest_with_what_the_governor_grants() {
    let swing = |delay: f64, block: usize| {
        let knob = format!("delay = {delay}\nstale = 0.05\nmargin = 0.5\n{PAIR}");
        let wall = "[knob.effects]\nspring = { type = \"spring\", stiffness = 50 }\n";
        let mut engine = Engine::new(&compiled(&knob, wall, &attached())).unwrap();
        let (mut angle, mut speed, mut most) = (0.02, 0.0, 0.0_f64);
        let (mut input, mut output) = (vec![0.0; 2 * block], vec![0.0; 2 * block]);
        for n in 0..(96_000 / block) {
            // What is played now was computed from what was heard a block ago.
            let playing = output.clone();
            engine.process_input(&input, &mut output);
            for (heard, frame) in input.chunks_mut(2).zip(playing.chunks(2)) {
                heard.copy_from_slice(&pair(angle)[..2]);
                let torque = 0.1 * f64::from(frame[1]);
                speed += (torque - 2e-4 * speed) / 1e-5 / 48_000.0;
                angle += speed / 48_000.0;
                if n > 72_000 / block {
                    most = most.max(f64::abs(angle));
                }
            }
        }
        (most, engine.knob().unwrap().last().allowed.stiffness * 50.0)
    };
    for block in [16, 64, 256] {
        let delay = 2.0 * block as f64 / 48_000.0;
        let (still, granted) = swing(delay, block);
        let (swings, more) = swing(0.0, block);
        assert!(still < 2e-3 && granted > 0.0 && more > 3.0 * granted, "{block}: {still} {granted} {more}");
        assert!(swings > 10.0 * still.max(1e-3), "{block}: {swings}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_the_key() {
    let refused = |sensor: &str| {
        let rig = format!("{RIG}{sensor}");
        Rig::parse("r", rig.as_bytes()).map(|_| String::new()).unwrap_or_else(|p| p.to_string())
    };
    for (sensor, says) in [
        ("sensor = { sine_channel = 1, cosine_channel = 2 }", "type"),
        ("sensor = { type = \"hall\" }", "sine-cosine"),
        ("sensor = { type = \"sine-cosine\", sine_channel = 1 }", "cosine_channel"),
        ("sensor = { type = \"sine-cosine\", sine_channel = 1, cosine_channel = 1 }", "twice"),
        ("sensor = { type = \"sine-cosine\", sine_channel = 0, cosine_channel = 1 }", "from 1 to"),
        (
            "sensor = { type = \"sine-cosine\", sine_channel = 1, cosine_channel = 2, threshold = 0.1 }",
            "quadrature",
        ),
        ("sensor = { type = \"quadrature\", a_channel = 1, b_channel = 2 }", "counts"),
        ("sensor = { type = \"voltage\", channel = 1 }", "radians_per_volt"),
        (
            "sensor = { type = \"voltage\", channel = 1, full_scale_volts = 5, radians_per_volt = 0 }",
            "radians_per_volt",
        ),
        (
            "sensor = { type = \"voltage\", channel = 1, full_scale_volts = 5, radians_per_volt = 1, low_volts = 3, high_volts = 2 }",
            "whole",
        ),
        ("sensor = 3", "a table"),
    ] {
        let told = refused(sensor);
        assert!(told.contains(says), "{sensor}: {told}");
    }
    for (sensor, ..) in SENSORS {
        assert_eq!(refused(sensor), "");
    }
}

/// What only the servo's own rate shows to be wrong is told by the rig's key, with that rate.
#[test]
fn what_the_servo_cannot_be_is_told_by_the_key_of_the_rig() {
    let refused = |knob: &str| {
        let patch = Patch::parse("t", b"format = \"pacinian-patch/1\"\ntitle = \"t\"\n[knob.effects]\ns = { type = \"spring\", stiffness = 0.01 }\n");
        let patch = patch.unwrap_or_else(|p| panic!("{p}")).value;
        let rig = Rig::parse("r", format!("{RIG}{knob}").as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        scene(&patch, &rig, &Options::default(), &NoAssets)
            .map(|_| String::new())
            .unwrap_or_else(|p| p.to_string())
    };
    for (knob, key, value) in [
        ("rate = 8000\nreconstruction = 3900\n", "reconstruction", 3900),
        ("rate = 8000\nvelocity = \"filtered\"\nvelocity_corner = 3900\n", "velocity_corner", 3900),
    ] {
        let told = refused(knob);
        assert!(told.contains(&format!("`{key}` is {value}")) && told.contains("at 8000 Hz"), "{told}");
    }
    assert_eq!(refused("rate = 8000\nreconstruction = 3500\n"), "");
}

/// A knob on a line is heard behind a card's inputs. A patch that listens to fewer of them takes over and hears the knob where it was heard.
#[test]
fn a_knob_on_a_line_goes_on_where_a_patch_that_follows_listens_to_less() {
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nrate = 48000\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
        [knob]\ninertia = 1e-5\nviscous = 2e-4\npeak_torque = 0.1\ncontroller = { type = \"odrive\", port = \"/dev/none\" }\n";
    let rig = Rig::parse("r", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let plan = |voice: &str, knob_channel: usize| {
        let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{SPRING}{voice}");
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live: true, knob_channel, ..attached() };
        scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    };
    let listens =
        "[voice.v]\nstart = \"always\"\noutput = \"i\"\nnodes.i = { type = \"input\", channel = 2 }\n";
    let (before, less, further) = (plan(listens, 0), plan("", 2), plan("", 0));
    let [first, second] = [&before, &less].map(|plan| plan.sensor().unwrap().channels);
    assert_eq!((first, second, further.sensor().unwrap().channels), ([2, 3], [2, 3], [0, 1]));
    let (mut director, mut stagehand) = exchange(&before).unwrap();
    // Where it would be looked for elsewhere, it cannot follow.
    assert_eq!(director.send(&further).unwrap_err(), Mismatch::Sensor);
    let mut turn = |angle: f64| {
        let frame = [0.0, 0.7, 0.5 * angle.sin() as f32, 0.5 * angle.cos() as f32];
        for _ in 0..480 {
            let inputs = stagehand.engine().input_channels();
            stagehand.process(&frame[..inputs], &mut [0.0]);
        }
        stagehand.engine().knob().unwrap().last().angle
    };
    assert!((turn(0.3) - 0.3).abs() < 1e-6);
    assert!(director.send(&less).unwrap());
    assert!((turn(0.4) - 0.4).abs() < 1e-6);
}
