//! A hand turns a simulated knob.

use super::record::{Record, Sample};
use super::set_off::{Set, SetOff};
use crate::cli::failure::Failure;
use crate::cli::loaded::Loaded;
use crate::cli::progress::Progress;
use crate::cli::stop::Stop;
use crate::cli::terminal::Terminal;
use pacinian::io::gesture::Gesture;
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::patch::knob::HAND;
use pacinian::player::Player;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// How to turn it.
pub struct Turn<'a> {
    /// What the hand does.
    pub gesture: Gesture,
    /// For so long; `None`: until the hand is done, and [`AFTER`].
    pub seconds: Option<f64>,
    /// Where what leaves the channels goes.
    pub output: Option<&'a Path>,
    /// Where the table of every sample goes.
    pub table: Option<&'a Path>,
}

/// Seconds that go on after the hand is done.
const AFTER: f64 = 0.5;
/// The longest turn, seconds.
const LONGEST: f64 = 3600.0;

/// A turn forth and back, after half a second in which torque rises.
pub fn forth_and_back() -> Gesture {
    let turn = std::f64::consts::TAU;
    let angles = vec![
        (0.0, 0.0),
        (0.5, 0.0),
        (1.75, 0.5 * turn),
        (2.25, 0.5 * turn),
        (4.75, -0.5 * turn),
        (5.0, -0.5 * turn),
        (6.25, 0.0),
    ];
    Gesture { angles, torques: Vec::new(), seconds: 6.25 }
}

/// What came of it.
pub struct Turned {
    /// What the knob did.
    pub record: Record,
    /// What it set off.
    pub set_off: SetOff,
    /// The player at its end.
    pub player: Player,
    /// Why it ended early, if it did.
    pub ending: Result<(), Failure>,
}

impl Turn<'_> {
    /// Turns it.
    ///
    /// # Errors
    /// A gesture beyond what the hand can do, a file that cannot be written.
    pub fn run(&self, loaded: &Loaded, terminal: &Terminal) -> Result<Turned, Failure> {
        let mut player = loaded.player()?;
        let set_off = Arc::new(Mutex::new(SetOff { each: Some(Vec::new()), ..SetOff::default() }));
        let heard = Arc::clone(&set_off);
        player.listen(Box::new(move |event| {
            heard.lock().unwrap_or_else(PoisonError::into_inner).hear(event);
        }));
        let (rate, ratio, channels) =
            (player.plan().engine_rate(), player.plan().ratio, player.plan().channels);
        let simulated = player.plan().knob.as_ref().is_some_and(|knob| knob.model.is_some());
        if !simulated {
            let what = "the rig's knob is a real one".to_string();
            let help = "leave `sensor` or `controller` out of the rig's [knob], and it is simulated";
            return Err(Failure::usage(what, help).with_code(78));
        }
        self.within_reach(&player)?;
        let seconds = self.seconds.unwrap_or(self.gesture.seconds + AFTER);
        if seconds > LONGEST {
            let what = format!("{seconds} s are more than the {LONGEST} s that a turn may take");
            return Err(Failure::usage(what, "give a shorter --duration"));
        }
        let mut writer = match self.output {
            Some(path) => {
                let mut spec = WavSpec::new(channels, player.plan().device_rate as u32, Encoding::F32);
                spec.tactors = loaded.tactors();
                Some(WavWriter::create(path, spec)?)
            }
            None => None,
        };
        let stop = Stop::listen()?;
        let progress = Progress::new(terminal, Some(seconds));
        let samples = (seconds * rate).ceil() as usize;
        let mut record = Record::new(rate, self.table)?;
        let mut frames = vec![0.0; ratio * channels];
        let mut hand = Hand::new(&self.gesture);
        let mut stopped = None;
        for n in 0..samples {
            if n.is_multiple_of(1024) {
                progress.at(n as f64 / rate);
                stopped = stop.asked();
                if stopped.is_some() {
                    break;
                }
            }
            let now = n as f64 / rate;
            hand.feed(&mut player, now)?;
            player.process(&mut frames);
            if let Some(writer) = &mut writer {
                writer.write(&frames)?;
            }
            if let Some(sample) = sample(&player, hand.at(now)) {
                record.push(&sample)?;
            }
        }
        progress.ends();
        record.finish()?;
        writer.map(WavWriter::finish).transpose()?;
        let ending = stopped.map_or(Ok(()), |code| Err(Failure::told(code)));
        let set_off = std::mem::take(&mut *set_off.lock().unwrap_or_else(PoisonError::into_inner));
        // One notch may set off several voices.
        let mut seen: Option<&Set> = None;
        for set in set_off.each.iter().flatten() {
            if seen.is_none_or(|last| (last.at, &last.by) != (set.at, &set.by)) {
                record.event(set.at, &set.by);
            }
            seen = Some(set);
        }
        Ok(Turned { record, set_off, player, ending })
    }

    /// Whether the hand's control goes as far as the gesture.
    fn within_reach(&self, player: &Player) -> Result<(), Failure> {
        let Some(control) = player.plan().controls.iter().find(|control| *control.name == *HAND) else {
            return Ok(());
        };
        let beyond =
            self.gesture.angles.iter().find(|(_, angle)| *angle < control.least || *angle > control.most);
        let Some((at, angle)) = beyond else { return Ok(()) };
        let what = format!(
            "the hand goes to {angle} rad at {at} s, and its control from {} to {} rad",
            control.least, control.most
        );
        let help = "let it go further, in the patch: [control.hand] default = 0, range = [-100, 100], unit = \"rad\"";
        Err(Failure::usage(what, help))
    }
}

/// A hand that is fed to a player as it goes.
struct Hand<'a> {
    gesture: &'a Gesture,
    angle: usize,
    torque: usize,
}

/// Seconds by which the hand's events are ahead.
const AHEAD: f64 = 0.1;

impl<'a> Hand<'a> {
    fn new(gesture: &'a Gesture) -> Self {
        Self { gesture, angle: 0, torque: 0 }
    }

    /// Gives the player what is due soon.
    fn feed(&mut self, player: &mut Player, now: f64) -> Result<(), Failure> {
        while let Some(&(until, angle)) = self.gesture.angles.get(self.angle) {
            let (from, is_first) = match self.angle.checked_sub(1).and_then(|n| self.gesture.angles.get(n)) {
                Some((from, _)) => (*from, false),
                None => (until, true),
            };
            if from > now + AHEAD {
                break;
            }
            let seconds = if is_first { 0.0 } else { until - from };
            player.glide_at(from, HAND, angle, seconds).map_err(|problem| Failure::said(70, problem.what))?;
            self.angle += 1;
        }
        while let Some(&(at, torque)) = self.gesture.torques.get(self.torque) {
            if at > now + AHEAD || !player.push_at(at, torque) {
                break;
            }
            self.torque += 1;
        }
        Ok(())
    }

    /// Where the hand is, rad, if it holds the knob, and how it pushes, N m.
    fn at(&self, now: f64) -> (Option<f64>, f64) {
        let angles = &self.gesture.angles;
        let after = angles.partition_point(|(at, _)| *at <= now);
        let angle = match (after.checked_sub(1).and_then(|n| angles.get(n)), angles.get(after)) {
            (Some(&(from, a)), Some(&(to, b))) => Some(a + (b - a) * (now - from) / (to - from)),
            (Some(&(_, a)), None) => Some(a),
            _ => None,
        };
        let torques = &self.gesture.torques;
        let torque =
            torques.partition_point(|(at, _)| *at <= now).checked_sub(1).and_then(|n| torques.get(n));
        (angle, torque.map_or(0.0, |(_, torque)| *torque))
    }
}

fn sample(player: &Player, hand: (Option<f64>, f64)) -> Option<Sample> {
    let knob = player.knob()?;
    let (given, plant) = (knob.last(), knob.simulated()?.plant());
    Some(Sample {
        angle: plant.knob_angle(),
        speed: plant.knob_speed(),
        read: [given.angle, given.velocity],
        torque: [given.asked, given.torque],
        absorbed: knob.servo().energy().absorbed(),
        hand,
        warm: knob.simulated()?.thermal().map(|thermal| thermal.winding()),
    })
}
