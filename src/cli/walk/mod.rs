//! `pacinian walk`.

mod answer;
mod conclude;
mod presence;
mod round;

use super::ask::Typed;
use super::failure::Failure;
use super::patience;
use super::screen::happened::LOWERED;
use super::stop::Stop;
use super::terminal::Terminal;
use super::wrap::wrapped;
#[cfg(test)]
pub use answer::KEYS;
use clap::Args;
use pacinian::io::device::choose::Chosen;
use pacinian::io::device::keeper::Fate;
use pacinian::io::session::Beginning;
use pacinian::io::{replace, text};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::walk::probe::{self, Probe, bare, probes};
use pacinian::rig::{OutputKind, Rig};
use pacinian::text::Problems;
use pacinian::text::problem::escaped;
use pacinian::{NoAssets, Options};
use presence::Presence;
use round::{End, Round};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Buzzes one output after the other, to find out which tactor hangs on which channel
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pacinian walk --rig rigs/belt.toml --device \"USB Sound\"\n  \
    pacinian walk --rig rigs/belt.toml --device \"USB Sound\" --write\n\n\
    Each channel gets a short tone at the resonance of its actuator (200 Hz where that is not known), at --level or less: at most \
    half of what the actuator is rated for, where the rig says volts. A rumble motor turns for 0.3 s at most, up to half of its rated \
    vibration and within its limits, or clicks where it can do no more. Torques and triggers get nothing.\n\
    In a terminal it waits after each for what was felt, a key each: y or Enter where it was the tactor that the rig says, t and then \
    the name or the channel of the one that it was, n for nothing, r for the same again, s to leave it out, b for the one before, q to \
    end. With --write the channels that were felt go into the rig's file, which stays as it is otherwise; answers may be piped in then, a \
    line each: an empty one for yes, a name, a channel, or a letter as above. Anywhere else it walks over all of them without waiting.\n\
    With no device named, here or in the rig, or a sound system alone (but for JACK), it plays on the default, which may be headphones: at -20 dB until --arm.\n\
    Ctrl-C ends it: the output goes to exact zeros within 2 ms of the next block that the card asks for.")]
pub struct Walk {
    /// The rig [default: a line of as many tactors as the device has channels; 8 where it takes any number, 2 where it mixes them]
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,
    /// The sound card: its id, its name or a part of that, or `virtual` [default: what the rig says, else the system's default]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// How strong, as a share of full scale
    #[arg(long, value_name = "L", default_value_t = 0.25, value_parser = level)]
    level: f64,
    /// How long, seconds
    #[arg(long, value_name = "S", default_value_t = 0.6, value_parser = length)]
    seconds: f64,
    /// Only this one: the name of a tactor, or a channel; may be given again
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Also channels of which the rig says nothing
    #[arg(long)]
    all: bool,
    /// Full level on a device that nobody has named
    #[arg(long)]
    arm: bool,
    /// Write the channels that were felt into the rig
    #[arg(long, requires = "rig")]
    write: bool,
}

fn level(word: &str) -> Result<f64, String> {
    let level = word.parse().ok().filter(|level| *level > 0.0 && *level <= 1.0);
    level.ok_or_else(|| "a level is a number above 0, and 1 at most".into())
}

fn length(word: &str) -> Result<f64, String> {
    let seconds = word.parse().ok().filter(|seconds| (0.1..=10.0).contains(seconds));
    seconds.ok_or_else(|| "it is a number of seconds from 0.1 to 10".into())
}

impl Walk {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let source = self.rig.as_ref().map(text::read).transpose()?;
        let read = source.as_ref().zip(self.rig.as_ref()).map(|(bytes, path)| {
            Rig::parse(&path.display().to_string(), bytes).map_err(|problems| Failure::of(78, problems))
        });
        let given = read.transpose()?.map(|checked| checked.value);
        let named = given.as_ref().and_then(|rig| rig.device.name.as_deref());
        // Before keys are taken: from here on, a signal ends it in order, and gives them back.
        let stop = Stop::listen()?;
        let person =
            Typed::listen(self.write).map_err(|error| Failure::no_thread("what is typed", &error))?;
        if self.write {
            self.check_write(person.is_some())?;
        }
        let file = self.rig.as_ref().map_or_else(String::new, |path| path.display().to_string());
        let (wish, device) =
            super::choose::choose_for(self.device.as_deref(), named, file, Some(&stop), terminal)?;
        let rig = given.unwrap_or_else(|| Rig::default_for(channels(&device)));
        let probes = self.chosen(&rig)?;
        let presence = Arc::<Presence>::default();
        let (name, armed) = (device.name().to_string(), self.arm || device.is_meant(&wish));
        let why = match &device {
            Chosen::Virtual(Some(why)) => format!(", since {}", escaped(why)),
            _ => String::new(),
        };
        let beginning =
            Beginning { armed, ..beginning(&rig, &probes, device, Arc::clone(&presence), *terminal)? };
        let session = patience::begin(&name, beginning, &stop, terminal)?;
        // A signal closes the gate itself, whatever this thread is about.
        stop.also(&session.board().lever.closing())?;
        terminal.note(&format!(
            "walking over {} of {}{why}{}\n",
            super::table::many(probes.len(), "channel"),
            escaped(&name),
            if armed { "" } else { ", at -20 dB: --arm for full level" }
        ));
        self.say_what_is_left_out(&rig, terminal);
        let mut round = Round {
            rig: &rig,
            probes: &probes,
            session,
            presence: &presence,
            stop: &stop,
            terminal,
            seconds: self.seconds,
        };
        let mut felt = BTreeMap::new();
        let ended = match &person {
            Some(person) => round.ask(person, &mut felt),
            None => round.pass(),
        };
        round.session.stop();
        crate::cli::priority::told().iter().for_each(|told| terminal.note(&format!("{told}\n")));
        if let End::Stopped(code) = ended? {
            return Err(Failure::told(code));
        }
        let Some(person) = person else { return Ok(()) };
        if felt.is_empty() {
            let rig = self.rig.as_ref().filter(|_| self.write);
            let Some(rig) = rig.map(|rig| escaped(&rig.display().to_string()).into_owned()) else {
                return Ok(());
            };
            let what = format!("nothing was said of any channel, so `{rig}` was left alone");
            if person.keyed {
                terminal.note(&format!("{what}\n"));
                return Ok(());
            }
            return Err(Failure::said(65, format!("{what}; pipe a line for each channel in")));
        }
        self.conclude(&round, &person, &felt, &source.unwrap_or_default())
    }

    fn check_write(&self, asked: bool) -> Result<(), Failure> {
        if !asked {
            return Err(Failure::usage(
                "--write needs somebody who says what is felt",
                "run it in a terminal, pipe a line for each channel in, or leave --write out",
            ));
        }
        if self.rig.as_ref().is_some_and(|rig| text::is_stream(rig)) {
            return Err(Failure::usage(
                "--write needs a file, and the rig comes through a pipe",
                "save it first",
            ));
        }
        // Better said now than when all has been felt.
        self.rig.as_ref().map_or(Ok(()), replace::check)?;
        Ok(())
    }

    /// The channels to walk over.
    fn chosen(&self, rig: &Rig) -> Result<Vec<Probe>, Failure> {
        let all = probes(rig, self.level, self.all || !self.only.is_empty());
        let mut chosen: Vec<Probe> = Vec::new();
        for word in &self.only {
            let output = rig.outputs.iter().find(|output| output.name == *word);
            let channel = output.map(|output| output.channel).or(word.parse().ok());
            let found = all.iter().find(|probe| Some(probe.channel) == channel).ok_or_else(|| {
                let here = output.or(rig.outputs.iter().find(|output| Some(output.channel) == channel));
                match (here, channel) {
                    (Some(output), _) => Failure::usage(
                        format!(
                            "`{}` is no tactor but {}, and is never buzzed",
                            output.name,
                            kind(&output.kind)
                        ),
                        "name a tactor",
                    ),
                    (None, Some(channel)) => Failure::usage(
                        format!("there is no channel {channel}: the device has {}", rig.device.channels),
                        "channels count from 1",
                    ),
                    (None, None) => {
                        let names = rig.outputs.iter().map(|output| output.name.as_str());
                        let near = pacinian::text::nearest::suggest(word, names);
                        Failure::usage(format!("the rig has no tactor `{word}`"), near.unwrap_or_default())
                    }
                }
            })?;
            if !chosen.contains(found) {
                chosen.push(found.clone());
            }
        }
        if self.only.is_empty() {
            chosen = all;
        }
        match chosen.is_empty() {
            true => Err(Failure::said(78, "the rig has nothing that could be felt: it describes no tactor")),
            false => Ok(chosen),
        }
    }

    fn say_what_is_left_out(&self, rig: &Rig, terminal: &Terminal) {
        let others = rig.outputs.iter().filter(|output| !probe::may_be_felt(output));
        let mut moves = false;
        for output in others {
            moves |= output.kind == OutputKind::Torque;
            let what = kind(&output.kind);
            terminal.note(&format!(
                "left out: `{}` on channel {}, {what}\n",
                escaped(&output.name),
                output.channel
            ));
        }
        if moves {
            let told = "where jacks are not where they seem to be, another channel may lead there: unplug what turns";
            terminal.note(&format!("{}\n", wrapped(told, 0)));
        }
    }
}

/// Probes on a rig that is nothing else, which tell `presence` whether the device is there.
fn beginning(
    rig: &Rig,
    probes: &[Probe],
    device: Chosen,
    presence: Arc<Presence>,
    note: Terminal,
) -> Result<Beginning, Failure> {
    let bug = |problems: Problems| Failure::of(70, problems);
    let rate = device.rate(rig.device.rate.map(|rate| rate as u32));
    let patch = probe::patch(probes).map_err(bug)?;
    let options = Options { rate: Some(f64::from(rate)), on_card: true, ..Options::default() };
    let scene = Reload::of(patch, bare(rig, probes), &options, &NoAssets)
        .map_err(|problems| Failure::of(78, problems))?;
    Ok(Beginning {
        audience: Box::new(move |told| {
            if let Told::Refused(problem, _) = told {
                note.note(&format!("{problem}\n"));
            }
        }),
        fate: Box::new(move |fate| {
            presence.becomes(&fate);
            note.note(&match fate {
                Fate::Lost(why) => {
                    format!("\nthe device is gone ({}); it is waited for\n", escaped(&why))
                }
                Fate::Back => "\nthe device is back\n".into(),
                Fate::Moved => "\nthe system moved the stream to another device\n".into(),
                Fate::Lowered => format!("\n{LOWERED}\n"),
                Fate::Said(what) => format!("\n{}\n", escaped(&what)),
            });
        }),
        ..Beginning::of(scene, device)
    })
}

fn kind(kind: &OutputKind) -> &'static str {
    match kind {
        OutputKind::Vibration => "vibration",
        OutputKind::Raw => "played as it comes",
        OutputKind::Drive(_) => "a motor",
        OutputKind::Torque => "a torque",
        OutputKind::Trigger { .. } => "a trigger",
    }
}

/// As many as the device has, as far as it says, else 8; those that mix take any number, and get 2.
fn channels(device: &Chosen) -> u32 {
    crate::cli::by_default::fit(0, device.fitting())
}
