//! Why no engine can be built for a plan.

use std::fmt;

use super::vibration;
use crate::graph::plan::Plan;

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
}

impl Refusal {
    /// Refuses a plan that reaches beyond its channels.
    ///
    /// # Errors
    /// The first place or output that does.
    pub fn check(plan: &Plan) -> Result<(), Self> {
        let channels = plan.channels;
        let beyond = |channel: u32| channel as usize >= channels;
        for (place, row) in plan.places.iter().enumerate() {
            if let Some(&(channel, _)) = row.iter().find(|(channel, _)| beyond(*channel)) {
                return Err(Self::Place { place, channel, channels });
            }
        }
        match plan.outputs.iter().enumerate().find(|(_, o)| beyond(o.channel)) {
            Some((output, o)) => Err(Self::Output { output, channel: o.channel, channels }),
            None => Ok(()),
        }
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
    use super::Refusal;
    use crate::engine::Engine;
    use crate::graph::plan::Plan;
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::{Output, Rig};

    const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"s\"\n\
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
