//! What a plan has under a name: events, controls, places and signals for programs that drive an engine themselves.

use super::event::Play;
use crate::graph::felt::unfelt;
use crate::graph::plan::{Instrument, Plan, Shared};
use crate::graph::program::Feed;
use crate::graph::start::FIELDS;
use crate::patch::event::limits;
use crate::space::spot::{Spot, Spread};
use crate::text::measure::number;
use crate::text::{Problem, nearest};

/// The id of the voice of an instrument that sounds from the beginning on.
pub(crate) fn always_id(instrument: usize) -> u64 {
    u64::MAX - 1 - instrument as u64
}

impl Plan {
    /// A voice by its name, with values for its fields; what is not named is as the voice has it. Besides the fields that the
    /// voice declares there are `level` (1 for a full one), `felt` (dB above the threshold that a level of 1 is felt like) and `duration` (seconds until the release; without it the voice is
    /// held until it is released). It sounds at the voice's place, under the id 0:
    ///
    /// ```
    /// # use pacinian::{engine::event::Play, graph::plan::Plan, text::Problem};
    /// # fn second(plan: &Plan) -> Result<Play, Problem> {
    /// let play = Play { place: plan.place("t2")?, id: 1, ..plan.play("tap", &[("frequency", 80.0), ("level", 0.5)])? };
    /// # Ok(play) }
    /// ```
    ///
    /// # Errors
    /// A voice that the plan does not have, a field that the voice does not declare, or a value that no event of a patch may have: levels
    /// are 0 to 100, `felt` -60 to 120 dB, durations 0 to 1e6 s or infinite, fields of its own within ±1e9.
    pub fn play(&self, voice: &str, fields: &[(&str, f64)]) -> Result<Play, Problem> {
        self.play_within(voice, fields, limits)
    }

    /// What a pattern has played, whose gains, rates and beats make more of an event than a file may say.
    #[cfg(feature = "live")]
    pub(crate) fn played(&self, voice: &str, fields: &[(&str, f64)]) -> Result<Play, Problem> {
        self.play_within(voice, fields, |field| match field {
            "level" => limits(""),
            "duration" => [0.0, f64::MAX],
            other => limits(other),
        })
    }

    fn play_within(
        &self,
        voice: &str,
        fields: &[(&str, f64)],
        limits: impl Fn(&str) -> [f64; 2],
    ) -> Result<Play, Problem> {
        let index = find("voice", voice, self.instruments.iter().map(|i| &*i.name))?;
        let instrument = &self.instruments[index];
        let mut play = held(index, instrument);
        for &(name, value) in fields {
            let declared = instrument.fields.iter().position(|field| **field == *name);
            let slot = match (declared, name) {
                (Some(i), _) => play.own.get_mut(i),
                (None, "level") => Some(&mut play.level),
                (None, "duration") => Some(&mut play.duration),
                (None, "felt") => Some(play.felt.insert(0.0)),
                (None, _) => None,
            };
            let Some(slot) = slot else {
                let names = instrument.fields.iter().map(|f| &**f).chain(["level", "felt", "duration"]);
                let what = format!("voice `{voice}` has no field `{name}`");
                return Err(Problem::of_file(what).help(nearest::suggest(name, names)));
            };
            let duration = declared.is_none() && name == "duration";
            let [least, most] = limits(if declared.is_some() { "" } else { name });
            // One without end is held until it is released.
            if !((least..=most).contains(&value) || duration && value == f64::INFINITY) {
                let what = format!("voice `{voice}` cannot be played with `{name}` = {}", number(value));
                let or = if duration { ", or infinity: until it is released" } else { "" };
                return Err(Problem::of_file(what).help(format!("it may be from {least} to {most}{or}")));
            }
            *slot = value;
        }
        // What is said goes before what the voice says; both are said where a level scales what is felt.
        let says = |wanted: &str| fields.iter().any(|(name, _)| *name == wanted);
        match (says("level"), says("felt")) {
            (true, false) => play.felt = None,
            (false, true) => play.level = 1.0,
            (true, true) | (false, false) => {}
        }
        Ok(play)
    }

    /// Whether a voice can be felt as strongly as it says where it is played.
    ///
    /// # Errors
    /// That its voice does not say at which frequency that holds, that a motor is at its place, or that its frequency is beyond what is known.
    pub fn check_felt(&self, play: &Play) -> Result<(), Problem> {
        let Some(felt) = play.felt else { return Ok(()) };
        let Some(instrument) = self.instruments.get(play.instrument as usize) else { return Ok(()) };
        if felt.is_nan() {
            return Err(
                Problem::of_file("`felt` is not a number").help("give dB above the threshold".to_string())
            );
        }
        let Some(hertz) = instrument.pitch.hertz(play.own[0]) else {
            let what = format!("voice `{}` does not say at which frequency `felt` holds", instrument.name);
            let help = format!(
                "write felt_at = 250 under [voice.{}], or let it read event.frequency",
                instrument.name
            );
            return Err(Problem::of_file(what).help(help));
        };
        let channels: Vec<u32> = match play.place {
            Spot::Row(row) => {
                self.places.get(row as usize).into_iter().flatten().map(|(channel, _)| *channel).collect()
            }
            Spot::Point(_) | Spot::Path(_) => {
                self.spread.iter().flat_map(Spread::channels).map(|(channel, _)| *channel).collect()
            }
        };
        for channel in &channels {
            let output = self.outputs.iter().find(|output| output.channel == *channel);
            let name = output.map_or("", |output| &output.name);
            let gauge = self.gauges.get(*channel as usize).and_then(Option::as_ref);
            if let Some((what, help)) = unfelt(name, gauge, hertz) {
                return Err(Problem::of_file(what).help(help));
            }
        }
        Ok(())
    }

    /// The voices that sound from the beginning on, each under an id that nothing else has.
    pub(crate) fn always(&self) -> impl Iterator<Item = Play> + Clone {
        let always = self.instruments.iter().enumerate().filter(|(_, instrument)| instrument.always);
        always.map(|(i, instrument)| Play { id: always_id(i), ..held(i, instrument) })
    }

    /// A control's number, for [`super::event::Event::Control`].
    ///
    /// # Errors
    /// A control that the patch does not have, or that nothing reads.
    pub fn control(&self, name: &str) -> Result<u32, Problem> {
        find("control that moves anything", name, self.controls.iter().map(|c| &*c.name)).map(|i| i as u32)
    }

    /// A place, for [`Play::place`], by the name of its output or group; a point is one as it is, [`Spot::Point`].
    ///
    /// # Errors
    /// An output that the rig does not have.
    pub fn place(&self, name: &str) -> Result<Spot, Problem> {
        let names =
            self.outputs.iter().map(|output| &*output.name).chain(self.together.iter().map(|name| &**name));
        find("tactor or output", name, names.take(self.places.len())).map(|i| Spot::Row(i as u32))
    }

    /// An engine-wide signal's number, for [`super::task::Values::signal`], by the name of its control or shared node.
    ///
    /// # Errors
    /// A control or shared node that the patch does not have, or that no voice reads.
    pub fn signal(&self, name: &str) -> Result<usize, Problem> {
        find("control or shared node that a voice reads", name, self.shared.iter().map(|s| self.name_of(*s)))
    }

    /// The name of an engine-wide signal; "" for an input, and for a node that has become a number.
    fn name_of(&self, shared: Shared) -> &str {
        match shared {
            Shared::Control(c) => self.controls.get(c as usize).map_or("", |c| &c.name),
            Shared::Input(_) | Shared::Knob(_) => "",
            Shared::Node(output) => match self.shared_program.outputs.get(output as usize) {
                Some(Feed::Buffer(b)) => {
                    let last = self.shared_program.ops.iter().rev().find(|op| op.output == *b);
                    last.map_or("", |op| &op.node.name)
                }
                Some(Feed::Shared(s)) => match self.shared.get(*s as usize) {
                    Some(Shared::Control(c)) => self.controls.get(*c as usize).map_or("", |c| &c.name),
                    _ => "",
                },
                _ => "",
            },
        }
    }
}

/// A voice with all that it says of itself, held, under the id 0.
fn held(index: usize, instrument: &Instrument) -> Play {
    let mut own = [0.0; FIELDS];
    own.iter_mut().zip(&instrument.defaults).for_each(|(value, default)| *value = *default);
    let (place, level, felt) = (instrument.place, instrument.level, instrument.felt);
    Play { instrument: index as u32, place, level, felt, duration: f64::INFINITY, own, id: 0 }
}

fn find<'a>(kind: &str, name: &str, names: impl Iterator<Item = &'a str> + Clone) -> Result<usize, Problem> {
    names.clone().position(|n| n == name && !n.is_empty()).ok_or_else(|| {
        let help = nearest::suggest(name, names.filter(|n| !n.is_empty()));
        Problem::of_file(format!("there is no {kind} called `{name}`")).help(help)
    })
}

#[cfg(test)]
mod tests {
    use super::{Plan, Shared};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::space::spot::Spot;

    fn plan() -> Plan {
        let text = r#"
            format = "pacinian-patch/1"
            title = "Names"
            [control.unread]
            default = 0.0
            [control.strength]
            default = 1.0
            [shared.nodes]
            slow = { type = "lfo", rate = 2 }
            slower = { type = "lfo", rate = 1 }
            [voice.hum]
            output = "tone"
            nodes.tone = { type = "sine", frequency = "event.frequency" }
            [voice.tap]
            output = "out"
            place = "t2"
            defaults = { level = 0.75, frequency = 90, bite = 0.25 }
            [voice.tap.nodes]
            tone = { type = "sine", frequency = "event.frequency", amplitude = "event.bite * strength" }
            out = { type = "multiply", inputs = ["tone", "slow", "slower"] }
        "#;
        let patch = Patch::parse("names.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live: true, ..Options::default() };
        scene(&patch, &Rig::default_for(3), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    }

    #[test]
    fn what_is_not_said_is_as_the_voice_has_it() {
        let plan = plan();
        let play = plan.play("tap", &[("bite", -2.0)]).unwrap();
        let tap = plan.instruments.iter().position(|i| &*i.name == "tap").unwrap();
        let bite = plan.instruments[tap].fields.iter().position(|f| &**f == "bite").unwrap();
        let frequency = plan.instruments[tap].fields.iter().position(|f| &**f == "frequency").unwrap();
        assert_eq!((play.instrument, play.place, play.level), (tap as u32, Spot::Row(1), 0.75));
        assert_eq!((play.own[bite], play.own[frequency]), (-2.0, 90.0));
        assert_eq!(play.duration, f64::INFINITY);
        let play = plan.play("tap", &[("duration", 0.5), ("level", 0.1), ("frequency", 40.0)]).unwrap();
        assert_eq!((play.duration, play.level, play.own[frequency], play.own[bite]), (0.5, 0.1, 40.0, 0.25));
    }

    #[test]
    fn names_find_their_numbers() {
        let plan = plan();
        assert_eq!((plan.place("t1").unwrap(), plan.place("t3").unwrap()), (Spot::Row(0), Spot::Row(2)));
        assert_eq!(&*plan.controls[plan.control("strength").unwrap() as usize].name, "strength");
        let (slow, slower) = (plan.signal("slow").unwrap(), plan.signal("slower").unwrap());
        assert!(slow != slower && matches!(plan.shared[slow], Shared::Node(_)));
        assert!(matches!(plan.shared[plan.signal("strength").unwrap()], Shared::Control(_)));
    }

    #[test]
    fn a_wrong_name_is_told_the_nearest() {
        let plan = plan();
        let says = |problem: crate::text::Problem, words: &str| {
            let shown = problem.to_string();
            assert!(shown.contains(words), "{shown}");
        };
        says(plan.play("tab", &[]).unwrap_err(), "did you mean `tap`?");
        says(plan.play("tap", &[("frequenzy", 1.0)]).unwrap_err(), "did you mean `frequency`?");
        says(plan.play("tap", &[("levl", 1.0)]).unwrap_err(), "did you mean `level`?");
        says(plan.play("hum", &[("bite", 1.0)]).unwrap_err(), "no field `bite`");
        says(plan.control("strenght").unwrap_err(), "did you mean `strength`?");
        says(plan.control("unread").unwrap_err(), "there is only `strength`");
        says(plan.place("t33").unwrap_err(), "did you mean `t3`?");
        says(plan.signal("slwo").unwrap_err(), "did you mean `slow`?");
        says(plan.play("tap", &[("level", f64::NAN)]).unwrap_err(), "from 0 to 100");
        says(plan.play("tap", &[("level", f64::INFINITY)]).unwrap_err(), "from 0 to 100");
        says(plan.play("tap", &[("frequency", 1e30)]).unwrap_err(), "to 1000000000");
        says(plan.play("tap", &[("duration", 1e30)]).unwrap_err(), "or infinity");
        says(plan.play("tap", &[("duration", -1.0)]).unwrap_err(), "from 0 to 1000000");
        says(plan.play("tap", &[("duration", f64::NAN)]).unwrap_err(), "from 0 to 1000000");
    }
}
