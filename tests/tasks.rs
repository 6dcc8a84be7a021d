//! Periodic tasks: what they see and move is the same for any cut of time and any instruction set.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use common::{compiled, play, run, schedule};
use pacinian::dsp::isa::Isa;
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::engine::meter::Meter;
use pacinian::engine::task::{Task, Values};
use pacinian::schedule::Beat;

const PATCH: &str = r#"
[control.drive]
default = 0.0
range = [-1.0, 1.0]
smoothing = 0.0
[shared.nodes]
sway = { type = "sine", frequency = 37, amplitude = 0.8 }
[voice.hum]
output = "out"
[voice.hum.nodes]
tone = { type = "sine", frequency = "event.frequency + 30 * sway" }
hold = { type = "envelope", attack = 0.01, release = 0.01 }
out = { type = "multiply", inputs = ["tone", "hold", "drive"] }
"#;

const SAMPLES: usize = 3_000;

/// Sends a control to where a shared node is, at every sample, and keeps what it saw of both.
struct Servo {
    node: usize,
    control_signal: usize,
    control: usize,
    saw: Arc<[[AtomicU32; 2]]>,
}

impl Task for Servo {
    fn beat(&self) -> Beat {
        Beat::every(1)
    }
    fn run(&mut self, board: &mut dyn Values) {
        let (node, control) = (board.signal(self.node), board.signal(self.control_signal));
        if let Some([a, b]) = self.saw.get(board.clock() as usize) {
            a.store((node as f32).to_bits(), Ordering::Relaxed);
            b.store((control as f32).to_bits(), Ordering::Relaxed);
        }
        board.send(self.control, node);
    }
}

/// The output, and before each sample the node and the control.
fn servo(isa: Isa, calls: &[usize]) -> (Vec<u32>, Vec<[f32; 2]>) {
    let plan = compiled(PATCH, 8, 48_000.0).plan;
    let mut engine = Engine::with_isa(&plan, isa).unwrap();
    let saw: Arc<[[AtomicU32; 2]]> = (0..SAMPLES).map(|_| [AtomicU32::new(0), AtomicU32::new(0)]).collect();
    engine.add_task(Box::new(Servo {
        node: plan.signal("sway").unwrap(),
        control_signal: plan.signal("drive").unwrap(),
        control: plan.control("drive").unwrap() as usize,
        saw: Arc::clone(&saw),
    }));
    let events: Vec<_> = (0..8)
        .map(|i| (f64::from(i) * 211.3, play(0, i, 60.0 + 20.0 * f64::from(i), 0.1, u64::from(i))))
        .collect();
    schedule(&mut engine, &events);
    let output = run(&mut engine, SAMPLES * 6, calls);
    for channel in 0..8 {
        assert!(
            output.iter().skip(channel).step_by(8).any(|x| x.abs() > 0.05),
            "channel {channel} is silent"
        );
    }
    let read = |x: &AtomicU32| f32::from_bits(x.load(Ordering::Relaxed));
    (output.iter().map(|x| x.to_bits()).collect(), saw.iter().map(|[a, b]| [read(a), read(b)]).collect())
}

#[test]
fn a_task_moves_a_control_at_every_sample() {
    let (_, saw) = servo(Isa::detect(), &[480]);
    // The node is what its definition says, one sample ago; it starts where a voice does, LEAD = 2 samples before its time 0.
    let peak = saw.iter().fold(0.0_f32, |peak, [node, _]| peak.max(node.abs()));
    assert!((peak - 0.8).abs() < 1e-3, "{peak}");
    let different = saw.windows(2).filter(|w| w[0][0] != w[1][0]).count();
    assert!(different > SAMPLES - 20, "the node was seen to move {different} times");
    // A control without smoothing takes a sample to arrive, and another passes until it is seen.
    for (n, w) in saw.windows(3).enumerate().skip(1) {
        assert_eq!(w[2][1], w[0][0], "before sample {}", n + 2);
    }
}

#[test]
fn any_cut_and_any_instruction_set_give_the_same_bits() {
    let whole = servo(Isa::detect(), &[SAMPLES * 6]);
    for calls in [&[1][..], &[7], &[64], &[480], &[3, 1000, 1, 17, 250, 64]] {
        assert!(servo(Isa::detect(), calls) == whole, "in calls of {calls:?}");
    }
    assert!(servo(Isa::Baseline, &[480]) == whole);
}

#[test]
fn a_meter_reads_on_its_beat() {
    let plan = compiled(PATCH, 8, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let (every, level) = Meter::new(plan.signal("sway").unwrap(), Beat::every(1));
    let (once, rare) = Meter::new(plan.signal("sway").unwrap(), Beat { period: 1_000_000, phase: 100 });
    engine.add_task(Box::new(every));
    engine.add_task(Box::new(once));
    // 0.5 s: many periods of 37 Hz.
    run(&mut engine, 24_000, &[333]);
    assert!((level.take_peak() - 0.8).abs() < 1e-3);
    assert_eq!(level.take_peak(), 0.0);
    // Before sample 100 it reads sample 99, and a shared node lags LEAD = 2 samples behind the clock.
    let wanted = 0.8 * (std::f64::consts::TAU * 37.0 * (99.0 - 2.0) / 8000.0).sin();
    assert!((f64::from(rare.latest()) - wanted).abs() < 1e-4, "{} for {wanted}", rare.latest());
}

/// Counts its runs under a rank, and how often it was told to rest or to go on.
struct Ranked {
    rank: u8,
    told: Arc<AtomicU32>,
}

impl Task for Ranked {
    fn beat(&self) -> Beat {
        Beat::every(10)
    }
    fn run(&mut self, _: &mut dyn Values) {
        // A thousandth of a second on the clock of the test.
        CLOCK.fetch_add(1_000_000, Ordering::Relaxed);
    }
    fn name(&self) -> &str {
        "ranked"
    }
    fn cost(&self) -> f64 {
        // One of them claims more than it keeps.
        if self.rank == 5 { 0.9e-3 } else { 1.1e-3 }
    }
    fn rank(&self) -> u8 {
        self.rank
    }
    fn rest(&mut self, rests: bool) {
        self.told.fetch_add(if rests { 1 } else { 100 }, Ordering::Relaxed);
    }
}

static CLOCK: AtomicU32 = AtomicU32::new(0);

#[test]
fn the_least_important_rest_from_an_instant_on_and_overruns_are_counted() {
    let plan = compiled(PATCH, 8, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    engine.time_tasks(|| u64::from(CLOCK.load(Ordering::Relaxed)));
    let told = Arc::new(AtomicU32::new(0));
    let duties: Vec<_> = [0, 9, 5, 9]
        .map(|rank| engine.add_task(Box::new(Ranked { rank, told: Arc::clone(&told) })))
        .into_iter()
        .collect();
    assert_eq!(
        (engine.rank_below(256), engine.rank_below(9), engine.rank_below(5)),
        (Some(9), Some(5), None)
    );
    assert_eq!((engine.rank_above(0), engine.rank_above(5), engine.rank_above(9)), (Some(5), Some(9), None));
    let at = |sample| pacinian::schedule::Instant { sample, fraction: 0 };
    for (sample, above) in [(95, 8), (195, 0), (290, 255)] {
        engine.schedule(at(sample), Source::Program, Event::Shed(above));
    }
    // To sample 400, in calls of any length.
    let mut out = vec![0.0; 400 * 6 * 8];
    let mut rest = out.as_mut_slice();
    for frames in (1..).map(|n| n * 37 % 301) {
        let (part, left) = rest.split_at_mut((frames * 8).min(rest.len()));
        engine.process(part);
        rest = left;
        if rest.is_empty() {
            break;
        }
    }
    let counts: Vec<_> = duties.iter().map(|duty| (duty.runs(), duty.skipped())).collect();
    // Before 100 ten runs each; to 200 the nines rest, to 290 all but the rank 0.
    assert_eq!(counts, [(40, 0), (21, 19), (31, 9), (21, 19)]);
    assert_eq!(duties.iter().map(|duty| duty.overruns()).collect::<Vec<_>>(), [0, 0, 31, 0]);
    assert!(duties.iter().all(|duty| (duty.longest() - 1e-3).abs() < 1e-12 && !duty.is_resting()));
    assert_eq!(told.load(Ordering::Relaxed), 303);
}

/// Motors are turned at every engine sample, and what that costs is counted as a task's cost is: by the mean of what was timed together.
#[test]
fn motors_are_work_with_a_declared_cost() {
    static SLOW: AtomicU32 = AtomicU32::new(0);
    let motors = |rig: &str| {
        let rig =
            pacinian::rig::Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options =
            pacinian::graph::scene::Options { rate: Some(48_000.0), live: true, ..Default::default() };
        let none = pacinian::node::asset::NoAssets;
        let scene =
            pacinian::graph::scene::scene(&common::patch(common::scenes::MOVES), &rig, &options, &none);
        let mut engine = Engine::new(&scene.unwrap_or_else(|p| panic!("{p}")).plan).unwrap();
        // A clock that moves by 64 ms each time it is asked: 1 ms or more for each sample.
        engine.time_tasks(|| u64::from(SLOW.fetch_add(64_000_000, Ordering::Relaxed)));
        engine.process(&mut vec![0.0; 48_000 * 3]);
        let [motors, knob] = engine.duties();
        assert_eq!((knob.runs(), knob.overruns()), (0, 0));
        (motors.name().to_string(), motors.runs(), motors.overruns() > 0, motors.longest() >= 1e-3)
    };
    assert_eq!(motors(common::scenes::MOTORS), ("motors".into(), 8_000, true, true));
}

/// A simulated knob that is turned to and fro, with voices that begin at any moment between.
const KNOB: &str = r#"
[knob.effects]
notches = { type = "detents", count = 24, torque = 0.01 }
[voice.click]
voices = 8
output = "o"
nodes.o = { type = "sine", frequency = 200, amplitude = "decay" }
nodes.decay = { type = "envelope", attack = 0.001, decay = 0.01, sustain = 0 }
[[trigger]]
on = "knob.detent"
play = "click"
"#;

/// A knob's servo is ticked before every engine sample, inside the call that asks for it, however a run is cut into calls and whatever
/// happens between: as many runs as samples. One that takes more than it declares is counted, and one that does not is not.
#[test]
fn a_knobs_servo_is_a_task_of_exact_intervals_with_a_declared_cost() {
    static SLOW: AtomicU32 = AtomicU32::new(0);
    static QUICK: AtomicU32 = AtomicU32::new(0);
    // Clocks that move each time they are asked: by 100 us, which is 25 us or more for each sample of a stretch of four, and by 1 us.
    let slow: fn() -> u64 = || u64::from(SLOW.fetch_add(100_000, Ordering::Relaxed));
    let quick: fn() -> u64 = || u64::from(QUICK.fetch_add(1_000, Ordering::Relaxed));
    for (clock, over) in [(slow, true), (quick, false)] {
        for calls in [&[6][..], &[480], &[8_000], &[1, 7, 480, 33, 6, 64]] {
            let plan = compiled(KNOB, 1, 48_000.0).plan;
            let knob = plan.knob.as_ref().expect("a knob");
            let (per_sample, hand) = (u64::from(knob.ticks), plan.control("hand").unwrap());
            let mut engine = Engine::new(&plan).unwrap();
            engine.time_tasks(clock);
            // By one sample after another, so that every stretch is broken off somewhere.
            let events: Vec<_> =
                (0..700).map(|n| (f64::from(n) * 11.3, play(0, 0, 60.0, 0.004, 1_000 + n as u64))).collect();
            schedule(&mut engine, &events);
            let turn = Event::Glide(hand, 1.2, 0.5);
            assert!(engine.schedule(pacinian::schedule::Instant::of_samples(100.0), Source::Program, turn));
            let [_, duty] = engine.duties();
            assert_eq!((duty.name(), duty.cost()), ("knob", 10e-6));
            let mut frames = 0;
            for n in calls.iter().cycle() {
                engine.process(&mut vec![0.0; *n]);
                frames += n;
                // Ahead of what is given out by less than a sample.
                let (samples, ticks) = (engine.clock(), engine.knob().unwrap().servo().ticks());
                assert_eq!(samples, frames.div_ceil(6) as u64);
                assert_eq!(
                    (duty.runs(), ticks),
                    (samples, samples * per_sample),
                    "after {frames} frames of {calls:?}"
                );
                if frames >= 48_000 {
                    break;
                }
            }
            assert!(engine.counters().started > 700, "{:?}: the knob sets off some, too", engine.counters());
            assert_eq!((duty.overruns() > 1_000, duty.overruns() > 0), (over, over), "{}", duty.overruns());
            assert_eq!(duty.longest() > duty.cost(), over, "{}", duty.longest());
            assert_eq!((duty.skipped(), duty.is_resting(), duty.rank()), (0, false, 0));
        }
    }
}

/// Of what belongs to every session the meters rest first, before any task of another rank, and run again last.
#[cfg(feature = "live")]
#[test]
fn meters_rest_first_and_run_again_last() {
    use pacinian::live::board::Board;
    use pacinian::live::callback::Callback;
    use pacinian::live::gate::Gate;
    use pacinian::live::relief::Relieved::{Fewer, More};

    let plan = compiled(PATCH, 2, 48_000.0).plan;
    let (_director, mut stagehand) = pacinian::engine::exchange::exchange(&plan).unwrap();
    let task = stagehand.engine().add_task(Box::new(Ranked { rank: 9, told: Arc::default() }));
    let board = Arc::new(Board::new(2));
    let (mut callback, _rings) = Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::clone(&board));
    let [.., meters] = callback.duties();
    let mut output = vec![0.0; 480 * 2];
    let mut rest = |how: Option<_>| {
        how.into_iter().for_each(|how| callback.relieve(how));
        callback.process(&[], &mut output);
        (meters.is_resting(), task.is_resting())
    };
    assert_eq!(rest(None), (false, false));
    assert_eq!(rest(Some(Fewer)), (false, false));
    assert_eq!(rest(Some(More)), (true, false));
    assert_eq!(rest(Some(More)), (true, true));
    assert_eq!(rest(Some(More)), (true, true));
    assert_eq!(rest(Some(Fewer)), (true, false));
    assert_eq!(rest(Some(Fewer)), (false, false));
    assert_eq!((meters.runs(), meters.skipped()), (3 * 480, 4 * 480));
    assert_eq!(board.shed.get(), 0);
}

/// A task that takes two milliseconds of the processor for each of the engine's beats rests after the meters, as a stamped event, and
/// runs again once there has been room for long; the load tells of it.
#[cfg(feature = "live")]
#[test]
fn a_session_that_has_too_much_to_do_lets_tasks_rest() {
    use cpu_time::ThreadTime;
    use pacinian::live::board::Board;
    use pacinian::live::callback::{Callback, Deed};
    use pacinian::live::driver::Driver;
    use pacinian::live::gate::Gate;
    use pacinian::live::stamp::Epoch;
    use ringbuf::traits::Consumer;

    const BUSY: f64 = 0.002;
    struct Greedy(Arc<AtomicU32>);
    impl Task for Greedy {
        fn name(&self) -> &str {
            "greedy"
        }
        fn cost(&self) -> f64 {
            BUSY
        }
        fn rank(&self) -> u8 {
            9
        }
        fn beat(&self) -> Beat {
            Beat::every(8)
        }
        fn run(&mut self, _values: &mut dyn Values) {
            self.0.fetch_add(1, Ordering::Relaxed);
            let begin = ThreadTime::now();
            while begin.elapsed().as_secs_f64() < BUSY {
                std::hint::spin_loop();
            }
        }
    }
    let plan = compiled(PATCH, 2, 48_000.0).plan;
    let (_director, mut stagehand) = pacinian::engine::exchange::exchange(&plan).unwrap();
    let runs = Arc::<AtomicU32>::default();
    let task = stagehand.engine().add_task(Box::new(Greedy(Arc::clone(&runs))));
    let board = Arc::new(Board::new(2));
    let (mut callback, mut rings) = Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::clone(&board));
    let [.., meters] = callback.duties();
    callback.time(|| 0);
    // A callback a millisecond, of eight engine samples each.
    let (mut driver, _clock) = Driver::new(callback, 48_000.0, 48, Epoch::begin(), Arc::clone(&board));
    let mut shed = Vec::new();
    for n in 0..6_000_u64 {
        driver.fill(&mut [0.0; 96]);
        for report in rings.reports.pop_iter() {
            if let Deed::Event { at, event: Event::Shed(rank), .. } = report.deed {
                assert_eq!(
                    (at.sample, report.frame),
                    (8 * (n + 1), 48 * (n + 1)),
                    "at once, where it is told of"
                );
                shed.push((rank, meters.is_resting(), task.is_resting()));
            }
        }
    }
    // The meters, the task, which after five seconds of room runs again, and again takes too much.
    let resting: Vec<u8> = shed.iter().map(|(rank, ..)| *rank).collect();
    assert_eq!(resting, [254, 8, 254, 8], "{shed:?}");
    assert!(shed.iter().all(|(_, meters, _)| *meters));
    let load = &board.load;
    assert_eq!((load.count(), load.over()), (6_000, u64::from(runs.load(Ordering::Relaxed))));
    assert!(load.most() >= 2.0, "{}", load.most());
    assert!(runs.load(Ordering::Relaxed) >= 200 && task.skipped() > 0);
}
