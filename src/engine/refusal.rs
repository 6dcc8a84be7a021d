//! Why no engine can be built for a plan.

use std::fmt;

use super::vibration;
use crate::actuator::fault::Fault;
use crate::graph::budget::Need;
use crate::graph::plan::{Plan, Shared};
use crate::knob::servo::setup::Unfit;

/// Why no engine can be built for a plan.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// The output stage cannot be built.
    Stage(vibration::Refusal),
    /// A place (by its number) reaches a channel (from 0) beyond those of the plan.
    Place {
        /// The place.
        place: usize,
        /// The channel.
        channel: u32,
        /// How many the plan has.
        channels: usize,
    },
    /// An output (by its number) hangs on a channel (from 0) beyond those of the plan.
    Output {
        /// The output.
        output: usize,
        /// The channel.
        channel: u32,
        /// How many the plan has.
        channels: usize,
    },
    /// The actuator on a channel (from 0) cannot be.
    Motor {
        /// The channel.
        channel: u32,
        /// What of it.
        fault: Fault,
    },
    /// The knob cannot be.
    Knob(Unfit),
    /// An instrument (by its number) of which no voice may sound.
    Voices(usize),
    /// A control (by its number) without a range, or whose default is no number.
    Control(usize),
    /// An engine-wide signal (by its number) is to be a control that is not there.
    Signal(usize),
    /// It takes more memory than [`crate::graph::budget::MOST`].
    Memory(Box<Need>),
}

impl Refusal {
    /// Refuses a plan whose rates no engine has, that reaches beyond its channels, or that takes too much memory.
    ///
    /// # Errors
    /// The first that is wrong; rates come first.
    pub(crate) fn check(plan: &Plan) -> Result<(), Self> {
        let (rate, engine_rate) = (plan.device_rate, plan.engine_rate());
        if !vibration::DEVICE_RATES.contains(&rate) {
            return Err(Self::Stage(vibration::Refusal::Rate(rate)));
        }
        if !vibration::ENGINE_RATES.contains(&engine_rate) {
            return Err(Self::Stage(vibration::Refusal::EngineRate(engine_rate)));
        }
        if let Some(i) = plan.instruments.iter().position(|i| i.voices == 0) {
            return Err(Self::Voices(i));
        }
        if let Some(i) = plan.controls.iter().position(|c| !(c.least <= c.most && c.default.is_finite())) {
            return Err(Self::Control(i));
        }
        let missing = |s: &Shared| matches!(s, Shared::Control(c) if *c as usize >= plan.controls.len());
        if let Some(i) = plan.shared.iter().position(missing) {
            return Err(Self::Signal(i));
        }
        let channels = plan.channels;
        let beyond = |channel: u32| channel as usize >= channels;
        for (place, row) in plan.places.iter().enumerate() {
            if let Some(&(channel, _)) = row.iter().find(|(channel, _)| beyond(*channel)) {
                return Err(Self::Place { place, channel, channels });
            }
        }
        let shared = plan.spread.iter().flat_map(|spread| spread.channels());
        if let Some(&(channel, _)) = shared.clone().find(|(channel, _)| beyond(*channel)) {
            return Err(Self::Place { place: plan.places.len(), channel, channels });
        }
        if let Some((output, o)) = plan.outputs.iter().enumerate().find(|(_, o)| beyond(o.channel)) {
            return Err(Self::Output { output, channel: o.channel, channels });
        }
        let need = Need::of(plan);
        if need.is_too_much() { Err(Self::Memory(Box::new(need))) } else { Ok(()) }
    }
}

impl From<Unfit> for Refusal {
    fn from(why: Unfit) -> Self {
        Self::Knob(why)
    }
}

impl From<vibration::Refusal> for Refusal {
    fn from(why: vibration::Refusal) -> Self {
        Self::Stage(why)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, number, channel, channels) = match self {
            Self::Stage(why) => return why.fmt(f),
            Self::Place { place, channel, channels } => ("place", place, channel, channels),
            Self::Output { output, channel, channels } => ("output", output, channel, channels),
            Self::Motor { channel, fault } => {
                return write!(
                    f,
                    "the actuator on channel {} of the plan cannot be: {fault}",
                    u64::from(*channel) + 1
                );
            }
            Self::Knob(why) => return write!(f, "the knob of the plan cannot be: {why}"),
            Self::Voices(i) => {
                return write!(f, "instrument {} of the plan has no voices; give it at least 1", i + 1);
            }
            Self::Control(i) => {
                let number = i + 1;
                return write!(
                    f,
                    "control {number} of the plan has no range or no default; give it numbers, the least not above the most"
                );
            }
            Self::Signal(i) => {
                return write!(f, "signal {} of the plan is a control that is not there; add it", i + 1);
            }
            Self::Memory(need) => return write!(f, "{need}; {}", need.help()),
        };
        let (number, channel) = (number + 1, u64::from(*channel) + 1);
        write!(
            f,
            "{what} {number} of the plan is on channel {channel}, the plan has {channels}; give it more channels"
        )
    }
}

impl std::error::Error for Refusal {}

#[cfg(test)]
mod tests {
    use super::{Refusal, Shared, vibration};
    use crate::engine::Engine;
    use crate::graph::plan::{Control, Plan};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::{Output, Rig};

    const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.c]\ndefault = 0.5\n[voice.a]\noutput = \"s\"\n\
        [voice.a.nodes]\ns = { type = \"sine\", frequency = 250 }\n[pattern.p]\nevents = [{ at = 0, voice = \"a\" }]\n";

    fn patch() -> Patch {
        Patch::parse("t.toml", PATCH.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    }

    fn plan() -> Plan {
        let options = Options::default();
        scene(&patch(), &Rig::default_for(2), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    }

    #[test]
    fn a_plan_beyond_its_channels_is_refused() {
        let mut far = plan();
        far.places[1] = vec![(0, 1.0), (9, 1.0)];
        let why = Engine::new(&far).err();
        assert_eq!(why, Some(Refusal::Place { place: 1, channel: 9, channels: 2 }));
        assert!(why.is_some_and(|w| w.to_string().contains("place 2 of the plan is on channel 10")));
        let mut far = plan();
        far.outputs[0].channel = 2;
        assert_eq!(Engine::new(&far).err(), Some(Refusal::Output { output: 0, channel: 2, channels: 2 }));
        assert!(Engine::new(&plan()).is_ok());
    }

    #[test]
    fn a_plan_that_no_engine_can_run_is_refused() {
        let refused = |change: &dyn Fn(&mut Plan)| {
            let mut plan = plan();
            change(&mut plan);
            Engine::new(&plan).err()
        };
        for rate in [f64::INFINITY, f64::NAN, 1e12, 0.0, -48_000.0] {
            let why = refused(&|plan| plan.device_rate = rate);
            assert!(matches!(why, Some(Refusal::Stage(vibration::Refusal::Rate(_)))), "{rate}: {why:?}");
        }
        for ratio in [0, 1, 9, usize::MAX] {
            let why = refused(&|plan| plan.ratio = ratio);
            assert!(
                matches!(why, Some(Refusal::Stage(vibration::Refusal::EngineRate(_)))),
                "{ratio}: {why:?}"
            );
        }
        assert_eq!(refused(&|plan| plan.instruments[0].voices = 0), Some(Refusal::Voices(0)));
        assert_eq!(refused(&|plan| plan.shared.push(Shared::Control(3))), Some(Refusal::Signal(0)));
        for (least, most, default) in
            [(1.0, 0.0, 0.5), (f64::NAN, 1.0, 0.5), (0.0, f64::NAN, 0.5), (0.0, 1.0, f64::INFINITY)]
        {
            let control = Control { name: "c".into(), default, least, most, smoothing: 0.01 };
            assert_eq!(refused(&|plan| plan.controls.push(control.clone())), Some(Refusal::Control(0)));
        }
        let why = refused(&|plan| plan.channels = usize::MAX);
        assert!(matches!(why, Some(Refusal::Memory(_))), "{why:?}");
    }

    #[test]
    fn a_patch_made_in_code_is_checked() {
        let refused = |change: &dyn Fn(&mut Patch)| {
            let mut patch = patch();
            change(&mut patch);
            let problems = scene(&patch, &Rig::default_for(2), &Options::default(), &NoAssets).err();
            problems.unwrap_or_default().to_string()
        };
        for voices in [0, 4097, u32::MAX] {
            let shown = refused(&|patch| patch.voices[0].voices = voices);
            assert!(shown.contains(&format!("voice `a` has {voices} voices")), "{shown}");
        }
        for range in [[1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [0.5, 0.5]] {
            let shown = refused(&|patch| patch.controls[0].range = range);
            assert!(shown.contains("range of control `c`"), "{shown}");
        }
        let shown = refused(&|patch| patch.controls[0].default = f64::NAN);
        assert!(shown.contains("default of control `c`"), "{shown}");
        let shown = refused(&|patch| patch.controls[0].smoothing = f64::NAN);
        assert!(shown.contains("smoothing of control `c`"), "{shown}");
    }

    #[test]
    fn a_rig_made_in_code_is_checked() {
        let mut rig = Rig::default_for(2);
        rig.outputs.push(Output::tactor("far", 20, [0.0; 3]));
        let problems = scene(&patch(), &rig, &Options::default(), &NoAssets).err().unwrap_or_default();
        assert!(problems.list.iter().any(|p| p.what.contains("on channel 20")), "{problems}");
        let mut broken = patch();
        broken.voices[0].output = "nothing".into();
        assert!(scene(&broken, &Rig::default_for(2), &Options::default(), &NoAssets).is_err());
    }
}
