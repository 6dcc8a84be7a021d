//! `pacinian learn`.

mod bound;
mod source;

use super::ask::{Said, Typed};
use super::failure::Failure;
use super::stop::{INTERRUPTED, Stop};
use super::table::Table;
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::learn::{Heard, Learner, Source};
use pacinian::io::midi_in::{self, PortNews};
use pacinian::io::osc::endpoint::Endpoint;
use pacinian::io::{replace, text};
use pacinian::patch::Bind;
use pacinian::text::nearest::suggest;
use pacinian::text::problem::escaped;
use pacinian::{Patch, edit};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Binds the controls of a patch to what you move: a knob, a fader, a wheel, an OSC address
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pacinian learn patches/27-keys.toml\n  \
    pacinian learn PATCH --control strength --osc 9000\n\n\
    It goes through the controls, one after the other; move for each what is to move it, by a tenth of its way or more. Knobs that are \
    noisy, wheels that spring back and keys that are let go are not mistaken for one that is moved; a selector of few steps counts as it \
    goes on to a third or comes back, a button when it is pressed twice. What was heard and is not enough is told.\n\
    In a terminal, the key s or Enter leaves a control as it is, b goes back to the one before, q ends it; lines of the same may be \
    piped in.\n\
    At the end the bindings go into the patch as [[bind]], and the rest of the file stays as it is. A control that has a binding keeps \
    its range, curve and pick-up. Ctrl-C ends it and writes nothing.")]
pub struct Learn {
    /// The patch, a TOML file
    patch: PathBuf,
    /// Only this control; may be given again
    #[arg(long = "control", value_name = "NAME")]
    controls: Vec<String>,
    /// The ports of MIDI to listen to, by a part of their names; `none` for none [default: all]
    #[arg(long, value_name = "NAME")]
    midi_in: Option<String>,
    /// Listen for OSC on this UDP port, or address and port; a port alone is for this machine only
    #[arg(long, value_name = "ADDR")]
    osc: Option<Endpoint>,
    /// Seconds to wait for each control [default: until something moves]
    #[arg(long, value_name = "S", value_parser = super::render::seconds)]
    wait: Option<f64>,
}

const LOOK: Duration = Duration::from_millis(10);
/// So long what was heard may become enough, before it is told of.
const HINT: Duration = Duration::from_secs(4);

/// What may be typed.
const KEYS: &str = "s or Enter: leave it as it is   b: back to the one before   q: end";
const LINES: &str = "s or an empty line: leave it as it is   b: back to the one before   q: end";

/// What comes from outside.
struct Ears {
    learner: Learner,
    news: Receiver<String>,
    /// What was told of as not enough.
    hinted: HashSet<String>,
}

/// What becomes of a control.
enum Turn {
    Learnt(Source),
    Left,
    Back,
    End,
    Stopped(u8),
}

impl Learn {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        if text::is_stream(&self.patch) {
            let what = "learn writes into the patch, and this one comes through a pipe";
            return Err(Failure::usage(what, "save it to a file and name that"));
        }
        let before = text::read(&self.patch)?;
        let name = self.patch.display().to_string();
        let patch = Patch::parse(&name, &before).map_err(|problems| Failure::of(65, problems))?.value;
        let controls = self.chosen(&patch)?;
        let midi_in = self.midi_in.clone().filter(|name| name != "none");
        let midi = self.midi_in.is_none() || midi_in.is_some();
        if !midi && self.osc.is_none() {
            return Err(Failure::usage(
                "there is nothing to learn from",
                "leave --midi-in none out, or add --osc PORT",
            ));
        }
        if let Some(why) = midi_in::names().err().filter(|_| self.osc.is_none()) {
            return Err(Failure::usage(
                format!("there is no MIDI to learn from: {why}"),
                "--osc PORT learns from OSC",
            )
            .with_code(69));
        }
        let mut learner = Learner::default();
        if let Some(osc) = self.osc {
            let at = learner.hear_osc(osc)?;
            terminal.note(&format!("OSC is heard on {at}\n"));
        }
        let (tell, news) = channel();
        let no_thread = |error: std::io::Error| Failure::no_thread("what is heard", &error);
        if midi {
            // It is told by who knows what stands on the line.
            let news = move |news| drop(tell.send(told(&news)));
            learner.hear_midi(midi_in, Box::new(news)).map_err(no_thread)?;
        }
        let person = Typed::listen(true).map_err(no_thread)?;
        let stop = Stop::listen()?;
        let mut ears = Ears { learner, news, hinted: HashSet::new() };
        list(&patch, terminal);
        if let Some(person) = &person {
            terminal.note(&format!("{}\n\n", help(person)));
        }
        let mut learnt: Vec<Option<Source>> = vec![None; controls.len()];
        let mut at = 0;
        while let Some(&number) = controls.get(at) {
            let control = &patch.controls[number];
            let [least, most] = control.range;
            let asked = format!(
                "{}/{}  {} ({least} to {most}{}): move something ",
                at + 1,
                controls.len(),
                escaped(&control.name),
                if control.unit.is_empty() { String::new() } else { format!(" {}", escaped(&control.unit)) },
            );
            terminal.note(&asked);
            match self.turn(&mut ears, person.as_ref(), &stop, &asked, terminal) {
                Turn::Learnt(source) => {
                    let instead = bound::replaced(&patch, &source.bind(&control.name));
                    let instead = instead.map_or(String::new(), |old| format!(", {old}"));
                    terminal.note(&format!("\n     {}{instead}\n", source::shown(&source)));
                    if let Some(slot) = learnt.get_mut(at) {
                        *slot = Some(source);
                    }
                    at += 1;
                }
                Turn::Left => at += 1,
                Turn::Back => {
                    at = at.saturating_sub(1);
                    if let Some(slot) = learnt.get_mut(at) {
                        *slot = None;
                    }
                }
                Turn::End => break,
                Turn::Stopped(code) => {
                    terminal.note("\nnothing was written\n");
                    return Err(Failure::told(code));
                }
            }
        }
        drop((ears, person));
        let name_of = |number: &usize| patch.controls[*number].name.as_str();
        let learnt: Vec<(Bind, Source)> = controls
            .iter()
            .zip(learnt)
            .filter_map(|(number, source)| source.map(|source| (source.bind(name_of(number)), source)))
            .collect();
        let shown = escaped(&name);
        if learnt.is_empty() {
            return terminal.print(&format!("{shown}: nothing was learnt, so it is as it was\n"));
        }
        let binds: Vec<Bind> = learnt.iter().map(|(bind, _)| bind.clone()).collect();
        // What somebody has taken the trouble to move is not lost with the file.
        let all: Vec<String> =
            binds.iter().map(|bind| format!("{} from {}", bind.control, bind.from)).collect();
        let by_hand = format!("write the bindings by hand: {}", all.join(", "));
        let after = edit::bindings(&String::from_utf8_lossy(&before), &binds)
            .map_err(|why| Failure::said(65, format!("`{name}` was left alone: {why}")).and(&by_hand))?;
        replace::replace(&self.patch, &before, after.as_bytes())
            .map_err(|error| Failure::from(error).and(&by_hand))?;
        let mut table = Table::default();
        for (bind, source) in &learnt {
            let instead = bound::replaced(&patch, bind).unwrap_or_default();
            table.row([bind.control.clone(), bind.from.to_string(), source::shown(source), instead]);
        }
        let count = super::table::many(learnt.len(), "binding");
        terminal.print(&format!("{shown}: {count}\n{}", table.text()))
    }

    /// The controls to learn, by their places in the patch.
    fn chosen(&self, patch: &Patch) -> Result<Vec<usize>, Failure> {
        let names = || patch.controls.iter().map(|control| control.name.as_str());
        if patch.controls.is_empty() {
            return Err(Failure::said(
                65,
                "the patch has no controls: declare one, [control.NAME]; see `pacinian format control`",
            ));
        }
        if self.controls.is_empty() {
            return Ok((0..patch.controls.len()).collect());
        }
        let find = |word: &String| {
            names().position(|name| name == word).ok_or_else(|| {
                let help = suggest(word, names()).unwrap_or_default();
                Failure::usage(format!("the patch has no control `{word}`"), help)
            })
        };
        let chosen: Vec<usize> = self.controls.iter().map(find).collect::<Result<_, _>>()?;
        let twice = chosen.iter().enumerate().find(|(n, number)| chosen[..*n].contains(number));
        match twice {
            Some((n, _)) => Err(Failure::usage(
                format!("`{}` is asked for twice", self.controls[n]),
                "name each control once",
            )),
            None => Ok(chosen),
        }
    }

    /// Waits for something to move, for somebody to say otherwise, or for as long as was said. What is told meanwhile gets lines of its
    /// own, and what was `asked` stands behind it again.
    fn turn(
        &self,
        ears: &mut Ears,
        person: Option<&Typed>,
        stop: &Stop,
        asked: &str,
        terminal: &Terminal,
    ) -> Turn {
        let begin = Instant::now();
        ears.learner.forget();
        // Since when something was heard that is not enough.
        let mut heard: Option<Instant> = None;
        let aside = |what: &str| terminal.note(&format!("\n     {what}\n{asked}"));
        // Whether something was typed that means nothing, so that Enter does not agree to anything.
        let mut unclear = false;
        let mut typed = |person: &Typed| {
            let said = match person.said() {
                Said::Stop => return Some(Turn::Stopped(INTERRUPTED)),
                // A pipe has an end, and then there is nobody.
                Said::End => return person.keyed.then_some(Turn::End),
                Said::Nothing => return None,
                Said::Line(line) => line,
                Said::Key('\n') if !std::mem::take(&mut unclear) => String::new(),
                Said::Key(key) => key.to_lowercase().to_string(),
                Said::Unclear if person.keyed => {
                    unclear = true;
                    return None;
                }
                Said::Unclear => "?".into(),
            };
            let (turn, word) = match said.as_str() {
                "" | "s" => (Turn::Left, "left as it is"),
                "u" | "b" => (Turn::Back, "back"),
                "q" => (Turn::End, "end"),
                _ => {
                    aside(help(person));
                    return None;
                }
            };
            terminal.note(&format!("{word}\n"));
            Some(turn)
        };
        loop {
            if let Some(code) = stop.asked() {
                return Turn::Stopped(code);
            }
            if let Some(turn) = person.and_then(&mut typed) {
                return turn;
            }
            match ears.learner.hear() {
                Some(Heard::Source(source)) => return Turn::Learnt(source),
                Some(Heard::Unfit(unfit)) => aside(&source::why(&unfit)),
                None => {}
            }
            ears.news.try_iter().for_each(|news| aside(&news));
            if self.wait.is_some_and(|wait| begin.elapsed().as_secs_f64() >= wait) {
                let short = ears.learner.short().map(|short| source::not_enough(&short));
                let why = short.map_or(String::new(), |(_, why)| format!("\n     {why}"));
                terminal.note(&format!("\n     nothing moved; it is left as it is{why}\n"));
                return Turn::Left;
            }
            if ears.learner.has_heard() && heard.get_or_insert_with(Instant::now).elapsed() >= HINT {
                heard = Some(Instant::now());
                let short = ears.learner.short().map(|short| source::not_enough(&short));
                if let Some((_, why)) = short.filter(|(what, _)| ears.hinted.insert(what.clone())) {
                    aside(&why);
                }
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// What may be typed.
fn help(person: &Typed) -> &'static str {
    if person.keyed { KEYS } else { LINES }
}

/// What became of ports, for people.
fn told(news: &PortNews) -> String {
    match news {
        PortNews::Opened(name) => format!("MIDI from {}", escaped(name)),
        PortNews::Gone(name) => format!("the MIDI port {} is gone", escaped(name)),
        PortNews::Unknown(unknown) => escaped(&unknown.to_string()).into_owned(),
        PortNews::None(why) => format!("no MIDI: {}", escaped(why)),
        PortNews::Refused(name, why) => {
            format!("the MIDI port {} cannot be opened: {}", escaped(name), escaped(why))
        }
    }
}

/// The controls, and what moves them.
fn list(patch: &Patch, terminal: &Terminal) {
    let mut table = Table::default();
    for control in &patch.controls {
        let [least, most] = control.range;
        let binds = patch.binds.iter().filter(|bind| bind.control == control.name);
        let from: Vec<String> = binds.map(bound::moved_by).collect();
        let moved = if from.is_empty() { "not bound".into() } else { from.join(", ") };
        table.row([control.name.clone(), format!("{least} to {most} {}", control.unit), moved]);
    }
    terminal.note(&table.text());
}
