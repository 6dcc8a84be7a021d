//! What a patch says that will not be felt as it was meant: warnings.

use super::expr::Reads;
use super::node::Argument;
use super::{Action, Event, Events, Expr, Node, Patch, Play, Start, Trigger, Value, Voice};
use crate::node::spec::{Family, Kind};
use crate::text::sink::Sink;
use crate::text::{Problem, Span};
use std::collections::HashMap;

/// Where the band ends, Hz.
const BAND: f64 = 1000.0;
/// What to do about what lies beyond.
const HELP: &str = "the band ends at 1000 Hz; the skin feels most from 200 to 300 Hz";

/// Envelopes that a release cuts short, and the parameter that says how long they rise.
const RISES: [(&str, &str); 2] = [("envelope", "attack"), ("gate", "rise")];

impl Patch {
    /// Warnings about levels, frequencies and attacks.
    pub(super) fn advice(&self) -> Vec<Problem> {
        let mut advice = Advice::new(self);
        for voice in &self.voices {
            let who = format!("the defaults of voice `{}`", voice.name);
            advice.values(voice, &[], None, &voice.span, &who);
        }
        for pattern in &self.patterns {
            let Events::Inline(events) = &pattern.events else { continue };
            for (i, event) in events.iter().enumerate() {
                advice.event(event, &format!("event {} of pattern `{}`", i + 1, pattern.name));
            }
        }
        for (i, trigger) in self.triggers.iter().enumerate() {
            advice.trigger(trigger, &format!("trigger {}", i + 1));
        }
        for node in self.shared.iter() {
            advice.literal(node, "the shared nodes");
        }
        let longest = longest(self);
        for voice in &self.voices {
            let who = format!("voice `{}`", voice.name);
            voice.nodes.iter().for_each(|node| advice.literal(node, &who));
            if let Some(longest) = longest.get(voice.name.as_str()) {
                advice.rises(voice, *longest);
            }
        }
        advice.problems
    }
}

/// Warnings about the events of a patch.
pub(crate) struct Advice<'a> {
    voices: HashMap<&'a str, &'a Voice>,
    problems: Vec<Problem>,
}

impl<'a> Advice<'a> {
    /// None so far.
    pub(crate) fn new(patch: &'a Patch) -> Self {
        let voices = patch.voices.iter().map(|v| (v.name.as_str(), v)).collect();
        Self { voices, problems: Vec::new() }
    }

    /// What there is to say of one event, which is called `who`.
    #[cfg(feature = "io")] // Events files are read there.
    pub(crate) fn of(&mut self, event: &Event, who: &str) -> Vec<Problem> {
        self.event(event, who);
        std::mem::take(&mut self.problems)
    }

    /// What a trigger sets to a number; of the rest, only whoever sets it off knows.
    fn trigger(&mut self, trigger: &Trigger, who: &str) {
        let Some(voice) = self.voices.get(trigger.play.as_str()).copied() else { return };
        let mut fields = Vec::new();
        let mut level = None;
        for (field, expr, span) in &trigger.set {
            match (field.as_str(), expr.value(&|name| trigger.on.known(name))) {
                ("level", value) => level = value,
                (name, Some(value)) => fields.push((name, value, span)),
                (_, None) => {}
            }
        }
        if !fields.is_empty() || level.is_some() {
            self.values(voice, &fields, level, &trigger.span, who);
        }
    }

    fn event(&mut self, event: &Event, who: &str) {
        match &event.action {
            Action::Voice(play) => self.play(play, who),
            Action::Choose(list) => {
                for (i, alternative) in list.iter().enumerate() {
                    if let Action::Voice(play) = &alternative.action {
                        self.play(play, &format!("alternative {} of {who}", i + 1));
                    }
                }
            }
            Action::Pattern { .. } | Action::Marker(_) => {}
        }
    }

    fn play(&mut self, play: &Play, who: &str) {
        let Some(voice) = self.voices.get(play.voice.as_str()).copied() else { return };
        let fields: Vec<(&str, f64, &Span)> =
            play.fields.iter().map(|f| (f.name.as_str(), f.value, &f.span)).collect();
        // What is as the voice has it, has been told of the voice.
        if !fields.is_empty() || play.level.is_some() {
            self.values(voice, &fields, play.level, &play.span, who);
        }
    }

    /// Level and frequencies of an event that has these fields.
    fn values(
        &mut self,
        voice: &Voice,
        fields: &[(&str, f64, &Span)],
        level: Option<f64>,
        span: &Span,
        who: &str,
    ) {
        if self.problems.len() >= Sink::MOST {
            return;
        }
        let is_default = fields.is_empty() && level.is_none();
        if let Some(level) = level
            .or(is_default.then_some(voice.level).filter(|_| voice.felt.is_none()))
            .filter(|level| *level > 1.0)
        {
            let what = format!("level {level} of {who}: 1 is all that an actuator is rated for");
            let help = "the limiter turns down what passes full scale; write a level from 0 to 1".to_string();
            self.problems.push(Problem::warning(span, what).help(help));
        }
        let of = |name: &str| fields.iter().find(|f| f.0 == name).map(|f| f.1).or_else(|| voice.field(name));
        let oscillators = voice.nodes.iter().filter(|n| n.kind.spec().family == Family::Oscillator);
        for node in oscillators {
            let Some(expr) = frequency(node) else { continue };
            let mut read = Vec::new();
            expr.visit(&mut |reads, _| {
                if let Reads::Event(field) = reads {
                    read.push(field);
                }
            });
            let said = fields.iter().find(|f| read.contains(&f.0));
            if read.is_empty() || (said.is_none() && !is_default) {
                continue;
            }
            // What other nodes add is not known here; their middle is taken for nothing, which is right for what swings.
            let plain = matches!(expr, Expr::Event(..));
            let comes = value(expr, &of);
            let raw = of("frequency").filter(|_| read.contains(&"frequency"));
            let Some(hertz) = comes.or(raw).filter(|hertz| hertz.abs() > BAND) else { continue };
            let field = said.map_or(*read.first().unwrap_or(&"frequency"), |f| f.0);
            let what = if plain || comes.is_none() {
                format!("{field} {hertz} of {who}: nothing above 1000 Hz is felt")
            } else {
                format!("node `{}` comes to {hertz} Hz in {who}: nothing above 1000 Hz is felt", node.name)
            };
            self.problems.push(Problem::warning(said.map_or(span, |f| f.2), what).help(HELP.to_string()));
            return;
        }
    }

    /// An oscillator whose frequency is a number above the band.
    fn literal(&mut self, node: &Node, of: &str) {
        if self.problems.len() >= Sink::MOST || node.kind.spec().family != Family::Oscillator {
            return;
        }
        for (param, argument) in node.kind.spec().params.iter().zip(&node.arguments) {
            let Value::Expr(expr) = &argument.value else { continue };
            let hertz = expr.constant().filter(|_| matches!(param.kind, Kind::Frequency(_)));
            let Some(hertz) = hertz.filter(|hertz| hertz.abs() > BAND) else { continue };
            let what = format!(
                "`{}` of node `{}` of {of} is {hertz}: nothing above 1000 Hz is felt",
                param.name, node.name
            );
            self.problems.push(Problem::warning(&argument.span, what).help(HELP.to_string()));
        }
    }

    /// Envelopes that take longer to rise than any event lasts.
    fn rises(&mut self, voice: &Voice, longest: f64) {
        for (node, key, argument, seconds) in rises(voice).filter(|(.., seconds)| *seconds > longest) {
            if self.problems.len() >= Sink::MOST {
                return;
            }
            let what = format!(
                "`{key}` of node `{}` of voice `{}` is {seconds} s, and its events last {longest} s at most: they end before \
                 it has risen",
                node.name, voice.name
            );
            let help = format!("write a shorter `{key}`, or a `duration` that is longer");
            self.problems.push(Problem::warning(&argument.span, what).help(help));
        }
    }
}

/// Nodes of a voice that rise for a time that is a number: which, by which key, where it stands, and for how long, s.
fn rises(voice: &Voice) -> impl Iterator<Item = (&Node, &'static str, &Argument, f64)> {
    voice.nodes.iter().filter_map(|node| {
        let spec = node.kind.spec();
        let (_, key) = RISES.iter().find(|(name, _)| *name == spec.name)?;
        let argument = spec.param(key).and_then(|(i, _)| node.arguments.get(i))?;
        let Value::Expr(expr) = &argument.value else { return None };
        Some((node, *key, argument, expr.constant()?))
    })
}

impl Voice {
    /// The longest time for which one of its nodes rises, s, by which key of which node.
    pub(crate) fn rises(&self) -> Option<(f64, &'static str, &str)> {
        let all = rises(self).map(|(node, key, _, seconds)| (seconds, key, node.name.as_str()));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Seconds of the longest event of each voice that has any and of which all are known.
fn longest(patch: &Patch) -> HashMap<&str, f64> {
    let mut longest: HashMap<&str, f64> = HashMap::new();
    for pattern in &patch.patterns {
        let Events::Inline(events) = &pattern.events else { return HashMap::new() };
        let slower = |action: &Action| matches!(action, Action::Pattern { rate, .. } if *rate < 1.0);
        // A pattern that another plays more slowly lasts as long as one would have to work out.
        let slow = |event: &Event| match &event.action {
            Action::Choose(list) => list.iter().any(|a| slower(&a.action)),
            action => slower(action),
        };
        if events.iter().any(slow) {
            return HashMap::new();
        }
    }
    let defaults: HashMap<&str, f64> = patch.voices.iter().map(|v| (v.name.as_str(), v.duration)).collect();
    patch.each_play(|play, pattern| {
        let Some(default) = defaults.get(play.voice.as_str()) else { return };
        let jitter = pattern.jitter.iter().flat_map(|j| &j.fractions).find(|f| f.name == "duration");
        let most = 1.0 + jitter.map_or(0.0, |f| f.value);
        let seconds = play.duration.unwrap_or(*default) * pattern.time.seconds() / pattern.rate;
        let seconds = most * play.motion.as_ref().map_or(seconds, |motion| motion.longest(seconds));
        longest.entry(&play.voice).and_modify(|l| *l = l.max(seconds)).or_insert(seconds);
    });
    for trigger in &patch.triggers {
        let Some(default) = defaults.get(trigger.play.as_str()) else { continue };
        let said = trigger.set.iter().find(|(field, ..)| field == "duration");
        let known = |name: &str| trigger.on.known(name);
        let seconds = said.map_or(Some(*default), |(_, expr, _)| expr.value(&known));
        // Whoever sets it off may hold it.
        let holds = trigger.on.is_live();
        let seconds = seconds.filter(|_| !holds).unwrap_or(f64::INFINITY);
        longest.entry(&trigger.play).and_modify(|l| *l = l.max(seconds)).or_insert(seconds);
    }
    longest.retain(|_, seconds| seconds.is_finite());
    patch.voices.iter().filter(|v| v.start == Start::Always).for_each(|v| {
        longest.remove(v.name.as_str());
    });
    longest
}

/// What stands at the parameter of an oscillator that is its frequency.
pub(super) fn frequency(node: &Node) -> Option<&Expr> {
    let at = node.kind.spec().params.iter().position(|p| matches!(p.kind, Kind::Frequency(_)))?;
    match node.arguments.get(at).map(|a| &a.value) {
        Some(Value::Expr(expr)) => Some(expr),
        _ => None,
    }
}

/// The value of an expression that reads fields of an event and nothing else, in a hand at rest.
fn value(expr: &Expr, of: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    match expr {
        Expr::Number(x) => Some(*x),
        Expr::Name(..) | Expr::Knob(..) => None,
        Expr::Event(field, _) => of(field),
        Expr::Touch(motion, _) => Some(motion.rest()),
        Expr::Negate(a) => value(a, of).map(|a| -a),
        Expr::Binary(op, a, b) => Some(op.apply(value(a, of)?, value(b, of)?)),
        Expr::Call(function, values) => {
            let values: Option<Vec<f64>> = values.iter().map(|v| value(v, of)).collect();
            values.map(|v| function.apply(&v))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::patch::Patch;

    /// What is said of a voice with these nodes and defaults, played by these events.
    fn told(frequency: &str, more: &str, defaults: &str, pattern: &str) -> Vec<String> {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"n\"\ndefaults = {{ {defaults} }}\n\
             nodes.n = {{ type = \"sine\", frequency = \"{frequency}\" }}\n{more}\n[pattern.p]\n{pattern}\n"
        );
        let checked = Patch::parse("p.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}"));
        assert!(!checked.warnings.has_errors());
        checked.warnings.list.into_iter().map(|p| p.what).collect()
    }
    fn one(list: Vec<String>, wanted: &str) {
        assert!(list.len() == 1 && list[0].contains(wanted), "{wanted}: {list:?}");
    }

    #[test]
    fn frequencies_that_no_skin_feels_are_told() {
        let own = "event.frequency";
        let events = |fields: &str| {
            format!("events = [{{ at = 0, voice = \"v\" }}, {{ at = 1, voice = \"v\", {fields} }}]")
        };
        one(
            told(own, "", "", &events("frequency = 7900")),
            "frequency 7900 of event 2 of pattern `p`: nothing above 1000 Hz is felt",
        );
        one(
            told(own, "", "frequency = 5000", &events("level = 0.5")),
            "frequency 5000 of the defaults of voice `v`",
        );
        one(
            told("event.pitch * 100", "", "pitch = 2", &events("pitch = 20")),
            "node `n` comes to 2000 Hz in event 2",
        );
        one(
            told(
                "event.frequency * (1 + w)",
                "nodes.w = { type = \"lfo\" }",
                "",
                &events("frequency = 3000"),
            ),
            "frequency 3000 of event 2",
        );
        one(
            told(
                own,
                "",
                "",
                "events = [{ at = 0, choose = [{ voice = \"v\" }, { voice = \"v\", frequency = -1200 }] }]",
            ),
            "frequency -1200 of alternative 2 of event 1",
        );
        for (frequency, fields) in [
            (own, "frequency = 1000"),
            ("event.frequency / 10", "frequency = 5000"),
            ("200", "frequency = 5000"),
        ] {
            assert_eq!(
                told(frequency, "", "", &events(fields)),
                Vec::<String>::new(),
                "{frequency} {fields}"
            );
        }
    }

    #[test]
    fn so_are_those_that_stand_in_a_node() {
        let events = "events = [{ at = 0, voice = \"v\" }, { at = 1, voice = \"v\", level = 0.5 }]";
        for frequency in ["1500", "3 * 500"] {
            one(
                told(frequency, "", "", events),
                "`frequency` of node `n` of voice `v` is 1500: nothing above",
            );
        }
        let shared = "[shared.nodes]\ns = { type = \"triangle\", frequency = -2000 }\n";
        one(told("200", shared, "", events), "`frequency` of node `s` of the shared nodes is -2000");
        assert!(
            told("1000", "nodes.f = { type = \"lowpass\", input = \"n\", cutoff = 2000 }", "", events)
                .is_empty()
        );
    }

    #[test]
    fn what_a_trigger_sets_is_told() {
        let of = |rest: &str| {
            let start = format!(
                "events = [{{ at = 0, marker = \"m\" }}]\n[[trigger]]\non = \"start\"\nplay = \"v\"\nset = {{ {rest} }}"
            );
            told("event.frequency", "", "", &start)
        };
        one(of("frequency = \"2 * 600\""), "frequency 1200 of trigger 1: nothing above 1000 Hz is felt");
        one(of("level = 3"), "level 3 of trigger 1");
        assert!(of("frequency = 300, level = 1, duration = 2000").is_empty());
    }

    /// Many voices and many events take time by their sum, not by their product.
    #[test]
    fn large_patches_are_advised_at_once() {
        let many = 20_000;
        let mut text = String::from("format = \"pacinian-patch/1\"\ntitle = \"T\"\n");
        for i in 0..many {
            text +=
                &format!("[voice.v{i}]\noutput = \"n\"\nnodes.n = {{ type = \"envelope\", attack = 0.3 }}\n");
        }
        text += "[pattern.p]\nevents = [\n";
        (0..many).for_each(|i| text += &format!("{{ at = {i}, voice = \"v{i}\", level = 2 }},\n"));
        let checked = Patch::parse("p.toml", (text + "]\n").as_bytes()).unwrap_or_else(|p| panic!("{p}"));
        assert!(checked.warnings.list.len() >= 500);
    }

    #[test]
    fn levels_past_the_rating_are_told() {
        let of =
            |level| told("200", "", "", &format!("events = [{{ at = 0, voice = \"v\", level = {level} }}]"));
        one(of("1.5"), "level 1.5 of event 1 of pattern `p`");
        assert!(of("1").is_empty());
        one(told("200", "", "level = 2", "events = [{ at = 0, voice = \"v\" }]"), "level 2 of the defaults");
    }

    #[test]
    fn attacks_longer_than_every_event_are_told() {
        let hit = "nodes.e = { type = \"envelope\", attack = 0.3 }";
        let of = |pattern: &str| told("200", hit, "", pattern);
        one(
            of("events = [{ at = 0, voice = \"v\", duration = 0.2 }]"),
            "`attack` of node `e` of voice `v` is 0.3 s, and its events last 0.2 s",
        );
        one(of("events = [{ at = 0, voice = \"v\" }]"), "last 0.1 s at most");
        one(
            of("time = \"beats\"\ntempo = 120\nevents = [{ at = 0, voice = \"v\", duration = 0.5 }]"),
            "last 0.25 s",
        );
        for fine in [
            "events = [{ at = 0, voice = \"v\" }, { at = 1, voice = \"v\", duration = 0.3 }]",
            "time = \"beats\"\ntempo = 60\nevents = [{ at = 0, voice = \"v\", duration = 0.5 }]",
            "events = \"many.csv\"",
            "events = [{ at = 0, marker = \"m\" }]",
            "rate = 0.25\nevents = [{ at = 0, voice = \"v\" }]",
            "jitter = { duration = 1 }\nevents = [{ at = 0, voice = \"v\", duration = 0.2 }]",
        ] {
            assert!(of(fine).is_empty(), "{fine}: {:?}", of(fine));
        }
    }
}
