//! What is wrong with a patch as a whole: names that nothing has, cycles, patterns that contain themselves.

use std::collections::{HashMap, HashSet};

use super::crossing;
use super::cycle::{chain, cycles};
use super::event::limits;
use super::expr::Reads;
use super::names::{Names, no_field};
use super::steered;
use super::voice::MOST_VOICES;
use super::{
    Action, Bind, Control, Curve, Events, Expr, Knob, Node, Patch, Pattern, Scope, Source, Spread, Start,
    Target, Trigger, Value, Voice,
};
use crate::node::NodeKind;
use crate::node::spec::Kind;
use crate::text::nearest::{did_you_mean, listed, suggest};
use crate::text::sink::Sink;
use crate::text::{Problem, Span};

impl Patch {
    /// `broken` are names that are in the file although they are not in the patch.
    pub(super) fn problems(&self, broken: &[String]) -> Vec<Problem> {
        let broken_names = broken.iter().map(String::as_str).collect();
        let mut check = Check { problems: Vec::new(), broken: broken_names, knob: self.knob.as_ref() };
        check.names(self);
        self.controls.iter().for_each(|control| check.control(control));
        let shared = Scope::new(self, None);
        check.nodes(&self.shared, &shared, None);
        for voice in &self.voices {
            check.voice(voice, &shared.within(voice));
        }
        let names = Names::new(self);
        for pattern in &self.patterns {
            check.pattern(pattern, &names);
        }
        check.nesting(self);
        for trigger in &self.triggers {
            check.trigger(trigger, &names, &shared);
            check.midi(trigger);
        }
        for bind in &self.binds {
            check.bind(bind, &self.controls);
        }
        // Of what is broken, nobody wants to know how it would feel.
        if !check.problems.iter().any(Problem::is_error) && broken.is_empty() {
            check.problems.extend(self.advice());
        }
        check.problems
    }
}

struct Check<'a> {
    problems: Vec<Problem>,
    broken: HashSet<&'a str>,
    knob: Option<&'a Knob>,
}

impl Check<'_> {
    fn error(&mut self, span: &Span, what: String, help: impl Into<Option<String>>) {
        self.problems.push(Problem::error(span, what).help(help));
    }

    /// Advice about the name of a node, while anyone still reads it: the many after the first few hundred are only counted.
    fn suggest<'b>(&self, word: &str, names: impl IntoIterator<Item = &'b str>) -> Option<String> {
        if self.problems.len() >= Sink::MOST {
            return None;
        }
        if self.broken.is_empty() {
            return suggest(word, names);
        }
        // What cannot be read may be what is meant; and without it, a list of all there is would be none.
        let names = names.into_iter().map(|name| -> &str { name });
        did_you_mean(word, names.chain(self.broken.iter().copied()))
    }

    /// Every name means one thing.
    fn names(&mut self, patch: &Patch) {
        let voices = patch.voices.iter().map(|v| ("voice", v.name.as_str(), &v.span));
        let patterns = patch.patterns.iter().map(|p| ("pattern", p.name.as_str(), &p.span));
        self.unique(voices.chain(patterns), "a trigger or the command line could not tell them apart");
        let controls = patch.controls.iter().map(|c| ("control", c.name.as_str(), &c.span));
        let shared = patch.shared.iter().map(|n| ("shared node", n.name.as_str(), &n.span));
        self.unique(controls.clone().chain(shared.clone()), "nodes could not tell them apart");
        let outer: HashMap<&str, &str> = controls.chain(shared).map(|(kind, name, _)| (name, kind)).collect();
        for voice in &patch.voices {
            let nodes = voice.nodes.iter().map(|n| ("node", n.name.as_str(), &n.span));
            self.unique(nodes, "nodes could not tell them apart");
            for node in &voice.nodes {
                if let Some(kind) = outer.get(node.name.as_str()) {
                    let what = format!(
                        "node `{}` of voice `{}` hides the {kind} of that name",
                        node.name, voice.name
                    );
                    self.problems.push(Problem::warning(&node.span, what));
                }
            }
        }
    }

    fn unique<'b>(&mut self, all: impl Iterator<Item = (&'b str, &'b str, &'b Span)>, why: &str) {
        let mut kinds: HashMap<&str, &str> = HashMap::new();
        for (kind, name, span) in all {
            if let Some(other) = kinds.insert(name, kind) {
                self.error(span, format!("there is a {other} called `{name}` already"), why.to_string());
            }
        }
    }

    /// Its numbers; those of a file always are.
    fn control(&mut self, control: &Control) {
        let ([least, most], name) = (control.range, &control.name);
        let mut wrong = |what: &str, help: &str| {
            self.error(
                &control.span,
                format!("the {what} of control `{name}` cannot be used"),
                help.to_string(),
            );
        };
        if !(least.is_finite() && most.is_finite() && least < most) {
            wrong("range", "give two numbers, the least first");
        }
        if !control.default.is_finite() {
            wrong("default", "give a number");
        }
        if !(0.0..=10.0).contains(&control.smoothing) {
            wrong("smoothing", "give seconds, at most 10");
        }
    }

    fn voice(&mut self, voice: &Voice, scope: &Scope) {
        if !(1..=MOST_VOICES).contains(&voice.voices) {
            let what = format!("voice `{}` has {} voices", voice.name, voice.voices);
            self.error(&voice.span, what, format!("give it 1 to {MOST_VOICES}"));
        }
        super::felt::check_voice(voice, &mut self.problems);
        let known = matches!(scope.find(&voice.output), Some(Target::Node(_)));
        if !known && !voice.output.is_empty() && !self.broken.contains(voice.output.as_str()) {
            let what =
                format!("the output of voice `{}` names no node of it: `{}`", voice.name, voice.output);
            let help = self.suggest(&voice.output, voice.nodes.iter().map(|n| n.name.as_str()));
            self.error(&voice.output_span, what, help);
        }
        self.problems.extend(steered::fits(voice, voice.place.as_ref(), &voice.place_span));
        self.nodes(&voice.nodes, scope, Some(voice));
    }

    /// Arguments, names and cycles of the nodes of a voice, or of the shared ones.
    fn nodes(&mut self, nodes: &[Node], scope: &Scope, voice: Option<&Voice>) {
        self.problems.extend(steered::check(nodes, voice));
        let mut edges: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
        for (node, edges) in nodes.iter().zip(&mut edges) {
            let spec = node.kind.spec();
            let who = match voice {
                Some(voice) => format!("node `{}` of voice `{}`", node.name, voice.name),
                None => format!("shared node `{}`", node.name),
            };
            if voice.is_none() && node.kind == NodeKind::TOUCH {
                self.touch(&node.span, &who, Some(""), None);
            }
            if node.arguments.len() != spec.params.len() {
                let what = format!(
                    "{who} has {} arguments, {} wants {}",
                    node.arguments.len(),
                    spec.name,
                    spec.params.len()
                );
                self.error(&node.span, what, None);
                continue;
            }
            for (param, argument) in spec.params.iter().zip(&node.arguments) {
                if !fits(&param.kind, &argument.value) {
                    let what = format!("`{}` of {who} is not what {} takes there", param.name, spec.name);
                    self.error(&argument.span, what, param.doc.to_string());
                }
                let parts: &[Expr] = match &argument.value {
                    Value::Expr(expr) => std::slice::from_ref(expr),
                    Value::Signals(list) => list,
                    _ => &[],
                };
                let starts = matches!(param.kind, Kind::Start(_));
                // What goes into a delay comes out later, so it may close a loop.
                let loops = spec.name == "delay" && param.name == "input";
                let mut seen: Vec<(Reads, &Span)> = Vec::new();
                parts.iter().for_each(|e| e.visit(&mut |reads, span| seen.push((reads, span))));
                for (reads, span) in seen {
                    let name = match reads {
                        Reads::Event(field) => {
                            self.event_field(field, span, &who, voice);
                            continue;
                        }
                        Reads::Touch(_) => {
                            self.touch(span, &who, (starts || voice.is_none()).then_some(param.name), voice);
                            continue;
                        }
                        Reads::Knob(reading) => {
                            if starts {
                                let what = format!(
                                    "`{}` of {who} cannot follow the knob: it is read once, when the voice starts",
                                    param.name
                                );
                                let help = "let a trigger `knob.detent` set a field of the event".to_string();
                                self.error(span, what, help);
                            }
                            self.no_knob(span, &who);
                            let never = |what| self.knob?.never(what, None, span);
                            self.problems.extend(reading.happens().and_then(never));
                            continue;
                        }
                        Reads::Name(name) => name,
                    };
                    let target = scope.find(name);
                    if starts && (target.is_some() || !self.broken.contains(name)) {
                        let what = format!(
                            "`{}` of {who} cannot follow `{name}`: it is read once, when the voice starts",
                            param.name
                        );
                        self.error(
                            span,
                            what,
                            "use numbers and fields of the event there: event.level".to_string(),
                        );
                        continue;
                    }
                    match (target, voice) {
                        (Some(Target::Node(i)), Some(_)) | (Some(Target::Shared(i)), None) if !loops => {
                            edges.push(i)
                        }
                        (Some(_), _) => {}
                        (None, _) if self.broken.contains(name) => {}
                        (None, _) => {
                            let what = format!(
                                "`{}` of {who} names `{name}`, but there is no such node or control",
                                param.name
                            );
                            let declared = voice
                                .and_then(|v| v.field(name))
                                .map(|_| format!("the event's field is `event.{name}`"));
                            let help = declared.or_else(|| self.suggest(name, scope.names()));
                            self.error(span, what, help);
                        }
                    }
                }
            }
        }
        for cycle in cycles(&edges) {
            let Some(first) = cycle.first().and_then(|&i| nodes.get(i)) else { continue };
            let of = voice.map_or("the shared nodes".to_string(), |v| format!("voice `{}`", v.name));
            let name = |i: usize| nodes.get(i).map_or("", |n| n.name.as_str());
            let what = format!("nodes of {of} read each other in a circle: {}", chain(&cycle, name));
            let help = "let the loop pass through the input of a `delay`".to_string();
            self.error(&first.span, what, help);
        }
    }

    /// That there is no knob that could be read.
    fn no_knob(&mut self, span: &Span, who: &str) {
        if self.knob.is_none() {
            let what = format!("{who} reads the knob, and the patch has none");
            let help = "describe what it feels like: [knob.effects] notches = { type = \"detents\", count = 24, torque = 0.02 }";
            self.error(span, what, help.to_string());
        }
    }

    /// What a hand does is read by what sounds in it and may move; `wrong` is the parameter that cannot follow it.
    fn touch(&mut self, span: &Span, who: &str, wrong: Option<&str>, voice: Option<&Voice>) {
        match (wrong, voice) {
            (None, _) => {}
            (Some(_), None) => self.error(
                span,
                format!("{who} reads what a hand does, but shared nodes belong to no voice"),
                "read it in a voice, or use a control".to_string(),
            ),
            (Some(param), Some(_)) => self.error(
                span,
                format!("`{param}` of {who} cannot follow the hand: it is read once, when the voice starts"),
                "use numbers and fields of the event there: event.level".to_string(),
            ),
        }
    }

    fn event_field(&mut self, field: &str, span: &Span, who: &str, voice: Option<&Voice>) {
        match voice {
            None => self.error(
                span,
                format!("{who} reads `event.{field}`, but shared nodes belong to no event"),
                "read it in a voice, or use a control".to_string(),
            ),
            Some(voice) if voice.field(field).is_none() => {
                let fields = voice.fields.iter().map(|(n, _)| n.as_str());
                let help = crate::text::nearest::nearest(field, fields.chain(["level", "duration"]))
                    .map(|name| format!("did you mean `event.{name}`?"))
                    .unwrap_or_else(|| {
                        format!("declare it with its default under [voice.{}.defaults]", voice.name)
                    });
                self.error(
                    span,
                    format!("{who} reads `event.{field}`, but its events have no such field"),
                    help,
                );
            }
            Some(_) => {}
        }
    }

    fn pattern(&mut self, pattern: &Pattern, names: &Names) {
        if let Events::Inline(events) = &pattern.events {
            for event in events {
                if self.problems.len() >= Sink::MOST {
                    break;
                }
                self.problems.extend(names.check_event(event));
            }
        }
        for setting in pattern.jitter.iter().flat_map(|j| &j.fractions) {
            let known = matches!(setting.name.as_str(), "level" | "duration")
                || names.fields.contains(setting.name.as_str());
            if !known {
                let what = format!(
                    "`jitter` of pattern `{}` names `{}`, a field that no voice has",
                    pattern.name, setting.name
                );
                let help = suggest(&setting.name, names.fields().chain(["at", "level", "duration"]));
                self.error(&setting.span, what, help);
            }
        }
    }

    /// No pattern contains itself.
    fn nesting(&mut self, patch: &Patch) {
        let places: HashMap<&str, usize> =
            patch.patterns.iter().enumerate().map(|(i, p)| (p.name.as_str(), i)).collect();
        let edges: Vec<Vec<usize>> = patch
            .patterns
            .iter()
            .map(|pattern| {
                let Events::Inline(events) = &pattern.events else { return Vec::new() };
                let actions = events.iter().flat_map(|e| match &e.action {
                    Action::Choose(list) => list.iter().map(|a| &a.action).collect(),
                    action => vec![action],
                });
                let mut inner: Vec<usize> = actions
                    .filter_map(|action| match action {
                        Action::Pattern { pattern, .. } => places.get(pattern.as_str()).copied(),
                        _ => None,
                    })
                    .collect();
                inner.sort_unstable();
                inner.dedup();
                inner
            })
            .collect();
        for cycle in cycles(&edges) {
            let Some(first) = cycle.first().and_then(|&i| patch.patterns.get(i)) else { continue };
            let name = |i: usize| patch.patterns.get(i).map_or("", |p| p.name.as_str());
            let what = format!("pattern `{}` contains itself: {}", first.name, chain(&cycle, name));
            self.error(&first.span, what, "take one of them out of the other".to_string());
        }
    }

    /// Keys of a trigger that only MIDI gives a meaning.
    fn midi(&mut self, trigger: &Trigger) {
        let note = trigger.on == Source::MidiNote;
        let midi = note || matches!(trigger.on, Source::MidiProgram(_) | Source::MidiController { .. });
        let by_note = trigger.notes.is_some() || trigger.spread == Spread::Notes;
        let key = if trigger.notes.is_some() { "notes" } else { "spread" };
        if by_note && !note {
            let what = format!("`{key}` goes with notes, and this trigger is set off by something else");
            self.error(&trigger.span, what, "set it off by on = \"midi.note\"".to_string());
        } else if !midi
            && (trigger.channel.is_some() || !matches!(trigger.spread, Spread::Off | Spread::Notes))
        {
            let what = "a MIDI channel goes with MIDI, and this trigger is set off by something else";
            self.error(&trigger.span, what.into(), "set it off by on = \"midi.note\"".to_string());
        }
        if trigger.spread != Spread::Off && trigger.place.is_some() {
            let what = "a trigger cannot have a `place` and `spread` over the tactors, too";
            self.error(&trigger.span, what.into(), "take one of them out".to_string());
        }
    }

    /// Whether there is what a binding moves.
    fn bind(&mut self, bind: &Bind, controls: &[Control]) {
        let Some(control) = controls.iter().find(|control| control.name == bind.control) else {
            let help = suggest(&bind.control, controls.iter().map(|control| control.name.as_str()));
            self.error(&bind.control_span, format!("there is no control `{}`", bind.control), help);
            return;
        };
        let Some([from, to]) = bind.range else { return };
        let [least, most] = control.range;
        if from.min(to) < least || from.max(to) > most {
            let what = format!(
                "`range` goes from {from} to {to}; control `{}` from {least} to {most}",
                control.name
            );
            self.error(&bind.span, what, None);
        }
        if bind.curve == Some(Curve::Exponential) && from.min(to) <= 0.0 {
            let what = "for an exponential curve, `range` must lie above 0";
            self.error(&bind.span, what.into(), None);
        }
    }

    fn trigger(&mut self, trigger: &Trigger, names: &Names, shared: &Scope) {
        let voice = names.voice(&trigger.play);
        if voice.is_none() && names.pattern(&trigger.play).is_none() {
            let all = names.voices.keys().chain(names.patterns.keys()).copied();
            let help = suggest(&trigger.play, all);
            self.error(&trigger.play_span, format!("there is no voice or pattern `{}`", trigger.play), help);
        } else if let Some(voice) = voice.filter(|v| v.start == Start::Always) {
            self.error(
                &trigger.play_span,
                format!("voice `{}` is always on, so no trigger can start it", voice.name),
                None,
            );
        }
        if let Source::Node { node, .. } = &trigger.on
            && !matches!(shared.find(node), Some(Target::Shared(_) | Target::Control(_)))
            && !self.broken.contains(node.as_str())
        {
            let what = format!("there is no shared node `{node}`, and no control, to set off a trigger");
            let help = self.suggest(node, shared.names());
            self.error(&trigger.on_span, what, help);
        }
        if let Source::Knob { what, effect } = &trigger.on {
            self.no_knob(&trigger.on_span, "this trigger");
            let never = |knob: &Knob| knob.never(*what, effect.as_deref(), &trigger.on_span);
            self.problems.extend(self.knob.and_then(never));
        }
        let of_pattern = voice.is_none() && names.pattern(&trigger.play).is_some();
        crossing::check(trigger, &mut self.problems);
        if let Some(voice) = voice {
            self.problems.extend(steered::fits(voice, trigger.place.as_ref(), &trigger.span));
        }
        if of_pattern && trigger.place.is_some() {
            let what = format!("a trigger cannot say where pattern `{}` plays", trigger.play);
            self.error(&trigger.span, what, "its events say so, or their voices".to_string());
        }
        if let Some(voice) = voice {
            super::felt::check_trigger(voice, trigger, &mut self.problems);
        }
        for (field, expr, span) in &trigger.set {
            if of_pattern && trigger.on == Source::Start && ["gain", "rate"].contains(&field.as_str()) {
                let what = format!("a pattern that starts by itself has no `{field}`");
                let help = format!(
                    "start one that plays it: {{ at = 0, pattern = \"{}\", {field} = ... }}",
                    trigger.play
                );
                self.error(span, what, help);
            }
            if let (Some(_), Some(value)) = (voice, expr.value(&|name| trigger.on.known(name))) {
                let [least, most] = limits(field);
                if !(least..=most).contains(&value) {
                    let what = format!("`{field}` of a trigger is {value}; it may be from {least} to {most}");
                    self.error(span, what, None);
                }
            }
            match voice {
                Some(voice) if field != "felt" && voice.field(field).is_none() => {
                    self.problems.push(no_field(voice, field, span))
                }
                None if names.pattern(&trigger.play).is_some()
                    && !["gain", "rate"].contains(&field.as_str()) =>
                {
                    let what = format!("a trigger cannot set `{field}` of a pattern");
                    self.error(span, what, suggest(field, ["gain", "rate"]));
                }
                _ => {}
            }
            let known = trigger.on.names();
            let mut unknown = Vec::new();
            expr.visit(&mut |reads, span| match reads {
                Reads::Name(name) if known.contains(&name) => {}
                Reads::Name(name) | Reads::Event(name) => unknown.push((name, span)),
                Reads::Touch(_) => unknown.push(("touch", span)),
                Reads::Knob(_) => unknown.push(("knob", span)),
            });
            for (name, span) in unknown {
                let help = if matches!(shared.find(name), Some(Target::Shared(_) | Target::Control(_))) {
                    format!("`set` is worked out when the voice begins; let its nodes read `{name}`")
                } else if known.is_empty() {
                    "it gives nothing to read".into()
                } else {
                    format!("it gives {}", listed(known))
                };
                self.error(span, format!("`{name}` is nothing that this trigger gives"), help);
            }
        }
    }
}

/// Whether a value is what a parameter takes. From a file it always is.
fn fits(kind: &Kind, value: &Value) -> bool {
    let within = |x: f64, least: f64, most: f64| x.is_finite() && x >= least && x <= most;
    match (kind, value) {
        (Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n), Value::Expr(expr)) => {
            expr.constant().is_none_or(|x| within(x, n.least, n.most))
        }
        (Kind::Constant(n), Value::Constant(x)) => within(*x, n.least, n.most),
        (Kind::Signals, Value::Signals(list)) => {
            !list.is_empty() && list.iter().all(|e| e.constant().is_none_or(f64::is_finite))
        }
        (Kind::Choice(words, _), Value::Choice(place)) => *place < words.len(),
        (Kind::Points, Value::Points(points)) => {
            let finite = points.iter().all(|p| {
                within(p.at, 0.0, 1e6)
                    && within(p.value, -1e6, 1e6)
                    && p.curve.abs() <= super::node::MOST_SHAPE
            });
            !points.is_empty() && finite && points.windows(2).all(|w| w[0].at < w[1].at)
        }
        (Kind::File, Value::File(path)) => !path.is_empty(),
        (Kind::Flag(_), Value::Flag(_)) => true,
        _ => false,
    }
}
