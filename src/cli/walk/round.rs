//! Channel after channel: with somebody who says what is felt, or without.

use super::answer::{Answer, KEYS, LINES, Pressed};
use super::presence::Presence;
use crate::cli::ask::{Edit, Entry, Said, Typed};
use crate::cli::failure::Failure;
use crate::cli::stop::{INTERRUPTED, Stop};
use crate::cli::terminal::Terminal;
use crate::cli::wrap::wrapped;
use pacinian::io::session::Session;
use pacinian::live::gate::RAMP_IN;
use pacinian::live::walk::map::Felt;
use pacinian::live::walk::probe::{Deed, Lowered, Probe};
use pacinian::live::walk::turns::Turns;
use pacinian::rig::Rig;
use pacinian::text::problem::escaped;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// From one tone to the next where nobody is asked.
const PAUSE: Duration = Duration::from_millis(300);

/// So long the output takes to come in.
const OPENS: Duration = Duration::from_millis((1000.0 * RAMP_IN) as u64);

/// Before a name.
const IT_WAS: &str = "it was ";

/// How it came to an end.
pub enum End {
    /// Every channel had its turn, or somebody has had enough.
    Over,
    /// Somebody has asked to stop, with this exit code.
    Stopped(u8),
}

/// What a walk has with it.
pub struct Round<'a> {
    /// The rig, as it was read.
    pub rig: &'a Rig,
    /// What is to be felt.
    pub probes: &'a [Probe],
    /// What plays it.
    pub session: Session,
    /// Whether its device is there.
    pub presence: &'a Presence,
    /// Whether somebody wants it to stop.
    pub stop: &'a Stop,
    /// Where it is shown.
    pub terminal: &'a Terminal,
    /// Of each probe.
    pub seconds: f64,
}

impl Round<'_> {
    /// Over all of them without waiting for anybody.
    ///
    /// # Errors
    /// A session that takes nothing any more.
    pub fn pass(&self) -> Result<End, Failure> {
        for probe in self.probes {
            if let Some(code) = self.wait(PAUSE) {
                return Ok(End::Stopped(code));
            }
            self.terminal.note(&format!("{}\n", self.described(probe)));
            if let Some(code) = self.play(probe)? {
                return Ok(End::Stopped(code));
            }
        }
        // The last one rings out.
        Ok(self.wait(PAUSE).map_or(End::Over, End::Stopped))
    }

    /// One after the other, as somebody says what is felt; by channel.
    ///
    /// # Errors
    /// As [`Round::pass`].
    pub fn ask(&self, person: &Typed, felt: &mut BTreeMap<u32, Felt>) -> Result<End, Failure> {
        let help = if person.keyed { KEYS } else { LINES };
        self.terminal.note(&format!("{}\n\n", wrapped(help, 0)));
        if let Some(code) = self.wait(OPENS) {
            return Ok(End::Stopped(code));
        }
        let mut turns = Turns::over(self.probes.iter().map(|probe| probe.channel).collect());
        while let Some(probe) = turns.now().and_then(|at| self.probes.get(at)) {
            let (turn, of) = turns.count();
            let head = format!("{turn}/{of}  {}? ", self.described(probe));
            self.terminal.note(&head);
            person.forget();
            let answer = match self.play(probe)? {
                Some(code) => Err(End::Stopped(code)),
                None => self.answer(person, help),
            };
            let answer = match answer {
                Ok(answer) => answer,
                Err(end) => {
                    // Behind the question.
                    self.terminal.note("\n");
                    return Ok(end);
                }
            };
            let what = match answer {
                // Where the rig has nothing, there is nothing to agree with.
                Answer::Yes => probe.output.map(Felt::Output),
                Answer::Felt(output) => Some(Felt::Output(output)),
                Answer::Nothing => Some(Felt::Nothing),
                Answer::Again => continue,
                Answer::Skip => None,
                Answer::Back => {
                    turns.back();
                    continue;
                }
                Answer::Quit => break,
            };
            if let (Some(other), Some(Felt::Output(output))) = (turns.said(what, felt), what) {
                let name = self.rig.outputs.get(output).map_or("", |output| output.name.as_str());
                let why =
                    format!("`{}` was felt on channel {other} before, which comes again", escaped(name));
                self.terminal.note(&format!("     {}\n", wrapped(&why, 5)));
            }
        }
        Ok(End::Over)
    }

    /// Waits for an answer that can be understood.
    fn answer(&self, person: &Typed, help: &str) -> Result<Answer, End> {
        let mut entry: Option<Entry> = None;
        // Whether something was typed that means nothing, so that Enter does not agree to anything.
        let mut unclear = false;
        let again = |why: &str| {
            let (why, help) = (wrapped(why, 5), wrapped(help, 5));
            self.terminal.note(&format!("\n     {why}\n     {help}\n     ? "));
        };
        loop {
            match person.said() {
                Said::End => return Err(End::Over),
                Said::Stop => return Err(End::Stopped(INTERRUPTED)),
                Said::Unclear if person.keyed => unclear = true,
                Said::Unclear => again("that was not understood"),
                Said::Line(line) => match Answer::of(&line, self.rig) {
                    Ok(answer) => {
                        self.terminal.note(&format!("{}\n", escaped(&line)));
                        return Ok(answer);
                    }
                    Err(why) => again(&why),
                },
                Said::Key(key) => match entry.as_mut().map(|entry| entry.press(key)) {
                    Some(Edit::Echo(text)) => self.terminal.echo(&text),
                    Some(Edit::Line(line)) => match Answer::named(&line, self.rig) {
                        Ok(answer) => {
                            self.terminal.note("\n");
                            return Ok(answer);
                        }
                        // Nothing but Enter is a way back to the keys.
                        Err(why) if line.is_empty() => {
                            again(&why);
                            (entry, unclear) = (None, false);
                        }
                        Err(why) => {
                            let why = wrapped(&format!("{why}; Enter alone leads back"), 5);
                            self.terminal.note(&format!("\n     {why}\n     {IT_WAS}"));
                            entry = Some(Entry::default());
                        }
                    },
                    None => match Pressed::of(key) {
                        _ if key == '\n' && unclear => {
                            again("that was not understood");
                            unclear = false;
                        }
                        Pressed::Answer(answer, word) => {
                            self.terminal.note(&format!("{word}\n"));
                            return Ok(answer);
                        }
                        Pressed::Name => {
                            self.terminal.note(IT_WAS);
                            entry = Some(Entry::default());
                        }
                        Pressed::Nothing => unclear = true,
                    },
                },
                Said::Nothing => {
                    if let Some(code) = self.wait(Duration::from_millis(10)) {
                        return Err(End::Stopped(code));
                    }
                }
            }
        }
    }

    /// Whether somebody with keys wants what they are asked; the exit code where they ask to stop.
    pub fn agrees(&self, person: &Typed, question: &str) -> Result<bool, u8> {
        self.terminal.note(&format!("{} y: yes   n: no ", wrapped(question, 0)));
        let agreed = loop {
            match person.said() {
                Said::Key('y' | 'Y') => break true,
                Said::Key('n' | 'N' | 'q' | 'Q') | Said::End => break false,
                Said::Stop => return Err(INTERRUPTED),
                Said::Nothing => self.wait(Duration::from_millis(10)).map_or(Ok(()), Err)?,
                _ => {}
            }
        };
        self.terminal.note(if agreed { "yes\n" } else { "no\n" });
        Ok(agreed)
    }

    /// Plays a probe and waits until it is over; the exit code where somebody asks to stop.
    fn play(&self, probe: &Probe) -> Result<Option<u8>, Failure> {
        let seconds = probe.deed.seconds(self.seconds);
        loop {
            while self.presence.is_away() {
                if let Some(code) = self.wait(Duration::from_millis(20)) {
                    return Ok(Some(code));
                }
            }
            let losses = self.presence.losses();
            let played = self.session.handle().play(probe.deed.voice(), probe.note(self.seconds));
            played.map_err(|refused| Failure::said(71, refused.to_string()))?;
            let stopped = self.wait(Duration::from_secs_f64(seconds));
            if stopped.is_some() || self.presence.losses() == losses {
                return Ok(stopped);
            }
            self.terminal.note(&format!("again: {}\n", self.described(probe)));
        }
    }

    /// Waits; the exit code where somebody asks to stop.
    fn wait(&self, time: Duration) -> Option<u8> {
        let until = Instant::now() + time;
        loop {
            if let Some(code) = self.stop.asked() {
                return Some(code);
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            std::thread::sleep(left.min(Duration::from_millis(5)));
        }
    }

    fn described(&self, probe: &Probe) -> String {
        let output = probe.output.and_then(|at| self.rig.outputs.get(at));
        let name =
            output.map_or("nothing in the rig".into(), |output| format!("`{}`", escaped(&output.name)));
        let why = match probe.lowered {
            Some(Lowered::Rated) => ", half of what it is rated for",
            Some(Lowered::Unknown) => ", since nothing says at which level it gets what it is rated for",
            Some(Lowered::MaxLevel) => ", the most that `max_level` lets out",
            None => "",
        };
        let what = match probe.deed {
            Deed::Tone(frequency) => format!("{frequency:.0} Hz"),
            Deed::Turn => "a short turn".into(),
            Deed::Click => "a click".into(),
        };
        let digits = if probe.level < 0.01 { 4 } else { 2 };
        format!("channel {}: {name}, {what} at level {:.digits$}{why}", probe.channel, probe.level)
    }
}
