//! What numbers of events are called.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::engine::event::{Event, Move, Play};
use crate::graph::places::Places;
use crate::graph::plan::Plan;
use crate::node::motion::Motion;
use crate::space::path::Route;
use crate::space::spot::Spot;

use super::kind::Kind;
use super::line::Line;

/// The names of a plan, for its events.
#[derive(Debug, Clone)]
pub struct Names {
    instruments: Vec<(Arc<str>, Vec<Arc<str>>)>,
    /// Whether the node of an instrument moves its voices.
    steered: Vec<bool>,
    rows: Vec<Arc<str>>,
    paths: Vec<Route>,
    /// What tells the gains.
    places: Places,
    controls: Vec<Arc<str>>,
    markers: Vec<Arc<str>>,
    /// What sets something off, as their ids count, and the patterns that are set off.
    pub watches: Vec<Arc<str>>,
    pub patterns: Vec<Arc<str>>,
    /// Device frames for each engine sample.
    pub ratio: f64,
}

impl Names {
    /// Those of a plan.
    pub fn of(plan: &Plan) -> Self {
        Self {
            instruments: plan.instruments.iter().map(|i| (Arc::clone(&i.name), i.fields.clone())).collect(),
            steered: plan.instruments.iter().map(|i| i.steered).collect(),
            rows: plan.outputs.iter().map(|output| &output.name).chain(&plan.together).cloned().collect(),
            paths: plan.paths.clone(),
            places: Places::new(plan),
            controls: plan.controls.iter().map(|control| Arc::clone(&control.name)).collect(),
            markers: plan.markers.clone(),
            watches: plan.watching().cloned().collect(),
            patterns: plan.answering.clone(),
            ratio: plan.ratio as f64,
        }
    }

    /// The line of an event, without its times.
    pub fn line(&mut self, event: &Event) -> Line {
        if let Event::Play(play) = event {
            return self.voice(play);
        }
        let named = |names: &[Arc<str>], number: u32| names.get(number as usize).map(|name| name.to_string());
        match event {
            Event::Play(_) => Line::new(Kind::Voice),
            Event::Release(id) => Line { id: Some(*id), ..Line::new(Kind::Release) },
            Event::ReleaseAll => Line::new(Kind::ReleaseAll),
            Event::Silence(id, bits) => {
                Line { id: Some(*id), value: Some(f64::from(*bits)), ..Line::new(Kind::Silence) }
            }
            Event::Cancel(id, bits) => {
                Line { id: Some(*id), value: Some(f64::from(*bits)), ..Line::new(Kind::Cancel) }
            }
            Event::Touch(Move { id, motion, value }) => Line {
                id: Some(*id),
                name: Motion::WORDS.get(motion.number()).map(|word| (*word).to_string()),
                value: Some(*value),
                ..Line::new(Kind::Touch)
            },
            Event::Glide(control, value, seconds) => {
                let (name, duration) = (named(&self.controls, *control), Some(*seconds));
                Line { name, value: Some(*value), duration, ..Line::new(Kind::Control) }
            }
            Event::Control(control, value) => {
                let name = named(&self.controls, *control);
                Line { name, value: Some(*value), ..Line::new(Kind::Control) }
            }
            Event::Shed(above) => Line { value: Some(f64::from(*above)), ..Line::new(Kind::Shed) },
            Event::Push(torque) => Line { value: Some(*torque), ..Line::new(Kind::Push) },
            Event::Arm(arms) => Line { value: Some(f64::from(u8::from(*arms))), ..Line::new(Kind::Arm) },
            Event::Deadline(kept) => {
                Line { value: Some(f64::from(u8::from(*kept))), ..Line::new(Kind::Deadline) }
            }
            Event::Marker(marker, id) => {
                Line { id: Some(*id), name: named(&self.markers, *marker), ..Line::new(Kind::Marker) }
            }
        }
    }

    fn voice(&mut self, play: &Play) -> Line {
        let mut gains = String::new();
        let number = play.instrument as usize;
        // Where nodes say its place, nobody knows it yet.
        let known = !self.steered.get(number).is_some_and(|steered| *steered);
        let begins = match play.place {
            Spot::Path(path) => self.paths.get(path as usize).map(|route| route.at(0.0, play.duration)),
            Spot::Row(_) | Spot::Point(_) => None,
        };
        let place = begins.map_or(play.place, Spot::Point);
        let felt = known.then(|| self.places.felt(number, place, play.strength()));
        for (channel, gain) in felt.into_iter().flatten() {
            let between = if gains.is_empty() { "" } else { ";" };
            // A string takes whatever it is given.
            let _ = write!(gains, "{between}{}={gain}", channel + 1);
        }
        let instrument = self.instruments.get(play.instrument as usize);
        let place = play.place.name(|row| self.rows.get(row).map(|name| &**name));
        let own = instrument.into_iter().flat_map(|(_, fields)| fields).zip(play.own);
        let fields: BTreeMap<String, f64> = own.map(|(name, value)| (name.to_string(), value)).collect();
        Line {
            id: Some(play.id),
            name: instrument.map(|(name, _)| name.to_string()),
            place: Some(place.into_owned()).filter(|name| !name.is_empty()),
            gains: Some(gains),
            level: Some(play.level),
            felt: play.felt,
            duration: Some(play.duration).filter(|duration| duration.is_finite()),
            fields,
            ..Line::new(Kind::Voice)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Names;
    use crate::engine::event::{Event, Play};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::space::spot::Spot;

    /// By the energy law two tactors share a point between them by the roots of what it is nearer to the one than to the other.
    #[test]
    fn what_goes_along_a_path_has_the_gains_of_its_beginning() {
        let rig = "format = \"pacinian-rig/1\"\ntitle = \"A line\"\n[device]\nchannels = 3\n".to_string()
            + &(1..=3)
                .map(|n| {
                    format!(
                        "[[tactor]]\nname = \"t{n}\"\nchannel = {n}\nposition = [{}, 0]\n",
                        0.1 * f64::from(n)
                    )
                })
                .collect::<String>();
        let voice =
            "output = \"tone\"\nlaw = \"energy\"\nnodes.tone = { type = \"sine\", frequency = 100 }\n";
        let steered = "nodes.x = { type = \"lfo\", rate = 1 }\nnodes.at = { type = \"place\", x = \"x\" }\n";
        let event = |at: u32, voice: &str, path: &str| {
            format!("{{ at = {at}, voice = \"{voice}\", duration = 2, place = {{ path = {path} }} }},\n")
        };
        let events = [
            event(0, "runs", "[[0.1, 0], [0.3, 0]]"),
            event(1, "runs", "[[0.25, 0], [0.1, 0]], over = 0.5"),
            event(2, "runs", "[[0.3, 0], [0.1, 0]], times = [0.5, 1]"),
            event(3, "led", "[[0.1, 0], [0.3, 0]]"),
        ];
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"Paths\"\n[voice.runs]\n{voice}[voice.led]\n{voice}{steered}[pattern.p]\nevents = [\n{}]\n",
            events.concat()
        );
        let patch = Patch::parse("p", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let rig = Rig::parse("r", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let scene = scene(&patch, &rig, &Options::default(), &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let mut names = Names::of(&scene.plan);
        let mut gains = |instrument, path| {
            let play = Play {
                instrument,
                place: Spot::Path(path),
                level: 1.0,
                felt: None,
                duration: 2.0,
                own: Default::default(),
                id: 1,
            };
            names.line(&Event::Play(play)).gains.unwrap()
        };
        let number =
            |name: &str| scene.plan.instruments.iter().position(|i| &*i.name == name).unwrap() as u32;
        let half = 0.5_f64.sqrt();
        for (path, wanted) in [(0, &[("1", 1.0)][..]), (1, &[("2", half), ("3", half)]), (2, &[("3", 1.0)])] {
            let told = gains(number("runs"), path);
            let parts: Vec<_> = told.split(';').filter_map(|part| part.split_once('=')).collect();
            let near = |((channel, gain), (of, due)): (&(&str, &str), &(&str, f64))| {
                channel == of && (gain.parse::<f64>().unwrap() - due).abs() < 1e-12
            };
            assert!(parts.len() == wanted.len() && parts.iter().zip(wanted).all(near), "{path}: {told}");
        }
        assert_eq!(gains(number("led"), 3), "");
    }
}
