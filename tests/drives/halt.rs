//! Everything that stops a session stops its motors: braked for as long as there is time, and then exact zeros.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::motor::{Drive, Level, Motor, Parameters, Plan};
use pacinian::engine::event::{Event, Play};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::live::board::Board;
use pacinian::live::callback::{Callback, Cue, Rings};
use pacinian::live::gate::{Gate, Order};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use ringbuf::traits::Producer;

use super::{RATE, common, play};

const VOLTAGE: &str = "gain = 2.5\nmax_volts = 12.5\ncoupling = \"dc\"\n";
const CURRENT: &str = "drive = \"current\"\ngain = 0.2\nmax_volts = 30.0\ncoupling = \"dc\"\n";
const BRIDGE: &str = "drive = \"bridge\"\nmax_volts = 12.5\n";

const BUZZ: &str = "[voice.buzz]\noutput = \"buzz\"\n[voice.buzz.nodes]\nbuzz = { type = \"drive-spin\" }\n";

/// Where the motor is: behind the tactor.
const PLACE: u32 = 1;

/// When it is stopped, s.
const STOPS: f64 = 0.8;

fn compiled(amplifier: &str) -> plan::Plan {
    compiled_on(1, amplifier)
}

fn compiled_on(channel: u32, amplifier: &str) -> plan::Plan {
    let direction = if amplifier == BRIDGE { "direction = 2\n" } else { "" };
    let rig = format!(
        "format = \"pacinian-rig/1\"\ntitle = \"t\"\n[device]\nchannels = 3\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
         [amplifier.before]\n{amplifier}\n[actuator.pad]\nmodel = \"rumble-motor\"\nrated_volts = 12.5\nresistance = 10.42\n\
         inductance = 4.2e-3\ntorque_constant = 0.011\ninertia = 1.15e-7\nviscous_friction = 1e-6\ncoulomb_friction = 6e-4\n\
         static_friction = 8e-4\neccentric_moment = 1.38e-5\nmass = 0.25\n\
         [[output]]\nkind = \"drive\"\nname = \"pad\"\nchannel = {channel}\n{direction}actuator = \"pad\"\namplifier = \"before\"\n\
         [[tactor]]\nname = \"skin\"\nchannel = 3\n"
    );
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&common::patch(BUZZ), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Ways of stopping.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Panic,
    /// The session is ended: from within, or by a signal (Ctrl-C, a terminal that is closed).
    End,
    Signal,
    LostDevice,
    /// All sound off, and what becomes of a MIDI input that is not heard any more.
    SoundOff,
}

const WAYS: [Way; 5] = [Way::Panic, Way::End, Way::Signal, Way::LostDevice, Way::SoundOff];

/// A motor of a session.
struct Stage {
    plan: plan::Plan,
    callback: Callback,
    rings: Rings,
    board: Arc<Board>,
    frames: Vec<f32>,
}

impl Stage {
    /// One that spins at that level when it is to be stopped.
    fn spinning(amplifier: &str, level: f64) -> Self {
        let plan = compiled(amplifier);
        let (_, stagehand) = exchange(&plan).unwrap();
        let board = Arc::new(Board::new(3));
        let (callback, rings) = Callback::new(stagehand, Gate::new(RATE, 1.0), Arc::clone(&board));
        let mut stage = Self { plan, callback, rings, board, frames: Vec::new() };
        stage.callback.order(Order::Open);
        stage.cue(0.3, Event::Play(play(0, PLACE, level, 10.0)));
        stage.until(STOPS);
        stage
    }

    fn cue(&mut self, seconds: f64, event: Event) {
        let at = Instant::of_samples(seconds * self.plan.engine_rate());
        assert!(self.rings.cues[1].try_push(Cue { plan: 0, at, cause: 0, event }).is_ok());
    }

    fn until(&mut self, seconds: f64) {
        while self.frames.len() < (seconds * RATE) as usize * 3 {
            let begin = self.frames.len();
            // No whole number of engine samples.
            self.frames.resize(begin + 3 * 100, 0.0);
            self.callback.process(&[], &mut self.frames[begin..]);
        }
    }

    /// Stops it, and gives the frame of that.
    fn stop(&mut self, way: Way) -> usize {
        let told = self.frames.len() / 3;
        match way {
            Way::Panic => self.board.panic(),
            Way::End => self.board.lever.close(0),
            Way::Signal => self.board.lever.closing().store(true, Ordering::Release),
            Way::LostDevice => self.callback.order(Order::Close),
            Way::SoundOff => self.cue(0.0, Event::Silence(0, 64)),
        }
        told
    }

    /// What reaches the terminals, a frame each.
    fn sent(&self) -> Vec<f64> {
        let drive = &self.plan.drives[0];
        let most = drive.setup.limit;
        let of = |frame: &[f32]| match drive.terminals {
            pacinian::rig::Terminals::Bridge(_) => match (frame[0] != 0.0, frame[1] != 0.0) {
                (false, _) => 0.0,
                (true, reverse) => {
                    if reverse {
                        -most
                    } else {
                        most
                    }
                }
            },
            _ => f64::from(frame[0]) * drive.per_sample,
        };
        self.frames.chunks_exact(3).map(of).collect()
    }

    fn drive(&self, amount: f64) -> Drive {
        self.plan.drives[0].setup.drive(amount)
    }
}

/// Speeds of a real motor, at the end of each frame.
fn speeds(stage: &Stage, sent: impl Iterator<Item = Drive>) -> Vec<f64> {
    let parameters = &stage.plan.drives[0].setup.parameters;
    let mut motor = Motor::<false>::new(parameters, &Plan::whole(Level::Fine), RATE).unwrap();
    let step = |drive: Drive| {
        motor.drive(drive);
        motor.step();
        motor.speed()
    };
    sent.map(step).collect()
}

/// Another one: what was under way was that of a sender who is silent now.
fn again() -> Play {
    Play { id: 7, ..play(0, PLACE, 1.0, 10.0) }
}

const MS: usize = 48;

#[test]
fn every_way_of_stopping_brakes_a_motor_and_ends_in_exact_zeros() {
    for amplifier in [VOLTAGE, CURRENT, BRIDGE] {
        for way in WAYS {
            let mut stage = Stage::spinning(amplifier, 1.0);
            let told = stage.stop(way);
            stage.until(STOPS + 0.1);
            let how = format!("{way:?}, {}", amplifier.lines().next().unwrap());
            // Exact zeros, on all lines, within 5 ms.
            let zeros = stage.frames.iter().rev().take_while(|x| x.to_bits() == 0).count() / 3;
            let last = stage.frames.len() / 3 - zeros - told;
            assert!((3 * MS..5 * MS).contains(&last), "{how}: {last} frames");
            let sent = stage.sent();
            let real = speeds(&stage, sent.iter().map(|x| stage.drive(*x)));
            let before = real[told - 1];
            let setup = &stage.plan.drives[0].setup;
            assert!((before / setup.full_speed() - 1.0).abs() < 0.02, "{how}: {before}");
            // The same motor, that gets something else from there on.
            let twin = |what: &dyn Fn(usize) -> Drive| {
                let until = told + 60 * MS;
                let drive = |n: usize| if n < told { stage.drive(sent[n]) } else { what(n - told) };
                speeds(&stage, (0..until).map(drive))
            };
            let let_go = twin(&|_| Drive::Open);
            let shorted = twin(&|_| stage.drive(0.0));
            let reversed = twin(&|n| stage.drive(if n < 4 * MS { -setup.limit } else { 0.0 }));
            let at = told + 5 * MS;
            let share = |now: f64| (before - now) / before;
            let most = share(reversed[at]);
            assert!(most > 0.25 && share(real[at]) > 0.9 * most, "{how}: {} of {most}", share(real[at]));
            assert!(share(let_go[at]) < 0.4 * share(real[at]), "{how}: {}", share(let_go[at]));
            assert!(share(shorted[at]) < 0.8 * share(real[at]), "{how}: {}", share(shorted[at]));
            // Nothing goes on braking at a voltage: there it is a short circuit. At a current it lets it roll.
            let (mut rolls, later) = (
                twin(&|n| if n < 5 * MS { stage.drive(sent[told + n]) } else { Drive::Open }),
                told + 25 * MS,
            );
            let rolled = rolls.swap_remove(later);
            match setup.imposes {
                Imposes::Voltage => assert!(real[later] < 0.25 * rolled, "{how}: {} {rolled}", real[later]),
                Imposes::Current => assert!((real[later] / rolled - 1.0).abs() < 1e-6, "{how}"),
            }
            assert!(real.iter().all(|now| *now > -0.01 * setup.full_speed()), "{how}");
        }
    }
}

/// One that stands before the time is over is not driven backward.
#[test]
fn a_slow_motor_is_stopped_and_not_reversed() {
    for amplifier in [VOLTAGE, CURRENT] {
        let mut stage = Stage::spinning(amplifier, 0.03);
        let told = stage.stop(Way::Panic);
        stage.until(STOPS + 0.05);
        let real = speeds(&stage, stage.sent().iter().map(|x| stage.drive(*x)));
        assert!(real[told - 1] > 100.0, "{}", real[told - 1]);
        let after = &real[told + 4 * MS..];
        assert!(after.iter().all(|now| now.abs() < 0.03 * real[told - 1]), "{:?}", &after[..4]);
    }
}

#[test]
fn what_still_holds_goes_on_when_the_device_is_back() {
    let mut stage = Stage::spinning(VOLTAGE, 1.0);
    stage.stop(Way::LostDevice);
    // Told twice, it is not braked twice.
    stage.until(STOPS + 0.02);
    let from = stage.frames.len();
    stage.callback.order(Order::Latch);
    stage.until(STOPS + 0.1);
    assert!(stage.frames[from..].iter().all(|x| x.to_bits() == 0));
    stage.callback.order(Order::Release);
    stage.callback.order(Order::Return);
    stage.until(STOPS + 0.6);
    let real = speeds(&stage, stage.sent().iter().map(|x| stage.drive(*x)));
    let full = stage.plan.drives[0].setup.full_speed();
    assert!((real.last().unwrap() / full - 1.0).abs() < 0.02, "{:?}", real.last());
    // What begins after all sound off is played.
    let mut stage = Stage::spinning(VOLTAGE, 1.0);
    stage.stop(Way::SoundOff);
    stage.until(STOPS + 0.1);
    stage.cue(STOPS + 0.2, Event::Play(again()));
    stage.until(STOPS + 0.6);
    let real = speeds(&stage, stage.sent().iter().map(|x| stage.drive(*x)));
    assert!((real.last().unwrap() / full - 1.0).abs() < 0.02, "{:?}", real.last());
}

/// What vibrates is as quick as ever, and a gate before no motor is as it was.
#[test]
fn how_a_session_is_cut_changes_nothing() {
    let run = |calls: &[usize]| -> Vec<u32> {
        let mut stage = Stage::spinning(VOLTAGE, 0.7);
        stage.cue(STOPS + 0.001_3, Event::Silence(0, 0));
        stage.cue(STOPS + 0.03, Event::Play(again()));
        let mut all = Vec::new();
        for call in calls.iter().cycle() {
            if all.len() >= 3 * 4800 {
                break;
            }
            let mut frames = vec![0.0; 3 * call];
            stage.callback.process(&[], &mut frames);
            all.extend(frames.iter().map(|x| x.to_bits()));
        }
        all.truncate(3 * 4800);
        all
    };
    let whole = run(&[480]);
    for calls in [&[1][..], &[7, 64], &[1000, 3]] {
        assert!(run(calls) == whole, "{calls:?}");
    }
}

/// A motor of a rig that came while it sounded is braked like one that was there from the beginning, and so is one that is on its way out: by the
/// full drive backward, and then exact zeros.
#[test]
fn a_motor_of_another_rig_is_braked_as_well() {
    // On another channel, so that the gate has to learn of it; and the same with another amplifier, which is braked before the other is driven.
    let elsewhere = || compiled_on(2, VOLTAGE);
    let weaker = || compiled("gain = 2.4\nmax_volts = 12.5\ncoupling = \"dc\"\n");
    for way in [Way::Panic, Way::SoundOff] {
        for (first, second, from) in
            [(elsewhere(), compiled(VOLTAGE), 0.1), (compiled(VOLTAGE), weaker(), STOPS)]
        {
            let (mut director, stagehand) = exchange(&first).unwrap();
            let board = Arc::new(Board::new(3));
            let (callback, rings) = Callback::new(stagehand, Gate::new(RATE, 1.0), Arc::clone(&board));
            let mut stage = Stage { plan: first, callback, rings, board, frames: Vec::new() };
            stage.callback.order(Order::Open);
            stage.cue(0.0, Event::Play(play(0, PLACE, 1.0, 10.0)));
            stage.until(from);
            assert_eq!(director.send(&second), Ok(true));
            let cue = |stage: &mut Stage, seconds: f64, event| {
                let at = Instant::of_samples(seconds * second.engine_rate());
                assert!(stage.rings.cues[1].try_push(Cue { plan: 1, at, cause: 0, event }).is_ok());
            };
            if from < 0.5 {
                cue(&mut stage, from + 0.4, Event::Play(again()));
            }
            stage.until(STOPS);
            let told = stage.frames.len() / 3;
            match way {
                Way::SoundOff => cue(&mut stage, 0.0, Event::Silence(0, 64)),
                way => _ = stage.stop(way),
            }
            stage.until(STOPS + 0.3);
            let (sent, most) = (stage.sent(), stage.plan.drives[0].setup.limit);
            let backward = sent[told..told + 4 * MS].iter().filter(|volts| **volts < -0.9 * most).count();
            assert!(backward > 3 * MS, "{way:?} {from}: {backward} frames backward");
            assert!(stage.frames[3 * (told + 5 * MS)..].iter().all(|x| x.to_bits() == 0), "{way:?} {from}");
        }
    }
}

/// What those 4 ms are worth to a coin motor at its rated speed, as the reference of rigs tells.
#[test]
fn after_the_full_drive_a_short_circuit_is_what_brakes_most() {
    let rig = Rig::parse("rig.toml", common::scenes::MOTORS.as_bytes()).unwrap_or_else(|p| panic!("{p}"));
    let coin = rig.value.actuators.iter().find(|actuator| actuator.name == "coin").unwrap();
    let coin = Parameters { gravity: 0.0, ..coin.rumble_motor().unwrap() };
    let stands = |first: Drive, then: Drive| {
        let mut motor = Motor::<false>::new(&coin, &Plan::whole(Level::Fine), RATE).unwrap();
        motor.place(0.0, coin.rated_speed());
        let stood = (0..20_000).find(|n| {
            motor.drive(if *n < 4 * MS { first } else { then });
            motor.step();
            motor.speed() <= 0.0
        });
        1e3 * stood.unwrap() as f64 / RATE
    };
    let back = Drive::Voltage(-coin.rated_volts);
    let told = [(back, Drive::SHORT), (back, back), (Drive::SHORT, Drive::SHORT), (back, Drive::Open)];
    let told = told.map(|(first, then)| stands(first, then).round());
    assert_eq!(told, [59.0, 19.0, 64.0, 85.0]);
}
