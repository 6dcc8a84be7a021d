//! Step by step until its loop is closed.

use super::super::setup::{ERRORS, Errors, Missing, Property, Step, WATCHED};
use super::super::text::{self, command};
use super::{CLOSED, CLOSING, ODrive, QUIET, Question, SETTLED, SLOW, Setup, Stage, TRIES};
use crate::io::knob::lost::Lost;
use crate::io::knob::servo::{News, Servo};
use crate::io::knob::session::Turn;

impl ODrive {
    pub(super) fn setup_answer(&mut self, mut setup: Setup, text: &str, now: f64, servo: &mut dyn Servo) {
        self.answered = now;
        let value = text::value(text);
        let unknown = text == "invalid property";
        match Step::ALL[setup.at] {
            Step::Identify => {
                let says = ["Hardware version", "Firmware version", "Serial number"];
                if says.iter().any(|prefix| text.starts_with(prefix)) && self.identity.len() < says.len() {
                    self.identity.push(text.into());
                    setup.named = true;
                    self.stage = Stage::Setup(setup);
                    if text.starts_with(says[2]) {
                        self.next_step(setup);
                    }
                } else if text == "unknown command" {
                    servo.news(&News::Note("it does not say what it is".into()));
                    self.next_step(setup);
                } else {
                    self.counts.unexpected += 1;
                    self.puzzled(text.as_bytes(), now);
                }
            }
            Step::Errors if unknown && setup.name + 1 < ERRORS.len() => {
                self.go_on(Setup { name: setup.name + 1, ..setup });
            }
            Step::Errors => match value {
                Some(bits) => {
                    let kind = if setup.name == 0 { Errors::Old } else { Errors::New };
                    self.errors = Some(kind);
                    let errors = bits as u64;
                    let watchdog = errors == kind.watchdog();
                    if errors == 0 {
                        self.next_step(setup);
                    } else if watchdog && !setup.set {
                        servo.news(&News::Note("its watchdog had stopped it; that is cleared".into()));
                        self.go_on(Setup { set: true, ..setup });
                    } else {
                        self.end(Lost::Axis { state: None, errors, names: kind.names(errors), watchdog });
                    }
                }
                None => {
                    servo.news(&News::Note(format!("its errors cannot be read ({text})")));
                    self.next_step(setup);
                }
            },
            Step::Set(property) => self.property_answer(setup, property, text, now, servo),
            Step::Close if unknown => {
                servo.news(&News::Note("it does not say whether its loop is closed".into()));
                self.drive(now, servo);
            }
            Step::Close => match value {
                Some(state) if state as i64 == CLOSED => {
                    self.tells_state = true;
                    self.drive(now, servo);
                }
                Some(state) => {
                    let since = setup.since.unwrap_or(now);
                    if now - since > CLOSING {
                        self.awaited = None;
                        self.left(state as i64);
                    } else {
                        self.go_on(Setup { set: true, since: Some(since), after: now + QUIET, ..setup });
                    }
                }
                None => self.end(Lost::Dialect(format!(
                    "to close its loop is `{text}`; firmware 0.5.4 or later can be told so"
                ))),
            },
        }
    }

    pub(super) fn property_answer(
        &mut self,
        setup: Setup,
        property: &Property,
        text: &str,
        now: f64,
        servo: &mut dyn Servo,
    ) {
        let wanted = (property.value)(&self.settings);
        let near = |there: f64| (there - wanted).abs() <= 1e-3 * wanted.abs() + 1e-6;
        let name = property.names[setup.name];
        match (text::value(text), setup.set) {
            (Some(there), false) if (property.stays)(there, wanted) => {
                if !near(there) {
                    servo.news(&News::Note(format!("{name} is {there} and stays so, below {wanted:.6}")));
                }
                self.next_step(setup);
            }
            (Some(_), false) => self.go_on(Setup { set: true, ..setup }),
            (Some(there), true) if near(there) => self.next_step(setup),
            (None, false) if setup.name + 1 < property.names.len() => {
                self.go_on(Setup { name: setup.name + 1, ..setup });
            }
            (there, _) => {
                let there = there.map_or(text.into(), |there| format!("{there}, not {wanted:.6}"));
                let said = format!("{name}: {there}");
                match property.missing {
                    Missing::Nothing => {}
                    Missing::Note(meaning) => servo.news(&News::Note(format!("{said}; {meaning}"))),
                    Missing::Watchdog if self.settings.unwatched => {
                        servo.news(&News::Note(format!("{said}; no watchdog, as was allowed")));
                    }
                    Missing::Watchdog => return self.end(Lost::Unwatched(said)),
                }
                // What was set and failed may have been answered twice.
                self.next_step(setup);
                if let Stage::Setup(next) = &mut self.stage {
                    next.after = now + if setup.set { SETTLED } else { 0.0 };
                }
            }
        }
    }

    /// Asks the next of this step.
    pub(super) fn go_on(&mut self, setup: Setup) {
        self.awaited = None;
        self.stage = Stage::Setup(Setup { tries: 0, ..setup });
    }

    pub(super) fn next_step(&mut self, setup: Setup) {
        self.go_on(Setup { at: setup.at + 1, ..Setup::default() });
    }

    pub(super) fn drive(&mut self, now: f64, servo: &mut dyn Servo) {
        self.stage = Stage::Driven;
        (self.awaited, self.read, self.torque) = (None, None, 0.0);
        (self.probe, self.flushing) = (None, false);
        (self.answered, self.next, self.glanced) = (now, now, now);
        servo.news(&News::Ready(if self.identity.is_empty() {
            "ODrive".into()
        } else {
            format!("ODrive, {}", self.identity.join(", "))
        }));
    }

    /// What is asked in a step.
    pub(super) fn ask(&mut self, setup: Setup, out: &mut Vec<u8>) {
        let axis = self.settings.axis;
        if setup.at >= WATCHED {
            command(out, format_args!("u {axis}"));
        }
        match Step::ALL[setup.at] {
            Step::Identify => {
                self.identity.clear();
                command(out, format_args!("i"));
            }
            Step::Errors => {
                if setup.set {
                    // Else it would expire again before it is fed.
                    command(out, format_args!("w axis{axis}.config.enable_watchdog 0"));
                    command(out, format_args!("sc"));
                }
                command(out, format_args!("r axis{axis}.{}", ERRORS[setup.name]));
            }
            Step::Set(property) => {
                let name = property.names[setup.name];
                if setup.set {
                    let value = (property.value)(&self.settings);
                    let value = (value * 1e6).round() / 1e6;
                    command(out, format_args!("w axis{axis}.{name} {value}"));
                }
                command(out, format_args!("r axis{axis}.{name}"));
            }
            Step::Close => {
                command(out, format_args!("c {axis} 0"));
                if !setup.set {
                    command(out, format_args!("w axis{axis}.requested_state {CLOSED}"));
                }
                command(out, format_args!("r axis{axis}.current_state"));
            }
        }
    }

    pub(super) fn turn_setup(&mut self, mut setup: Setup, now: f64, out: &mut Vec<u8>) -> Turn {
        let axis = self.settings.axis;
        let feed = self.settings.watchdog / 3.0;
        if let Some((_, asked)) = self.awaited {
            if now - asked > SLOW {
                self.awaited = None;
                if setup.named {
                    // The rest of what it says it is does not come.
                    self.next_step(setup);
                    return self.step(now, out);
                }
                self.counts.dropped += 1;
                setup.tries += 1;
                setup.after = now;
                self.stage = Stage::Setup(setup);
                if setup.tries >= TRIES {
                    let mut asked = Vec::new();
                    self.ask(setup, &mut asked);
                    let asked = String::from_utf8_lossy(&asked).trim_end().replace('\n', ", ");
                    self.end(Lost::Silent(format!("`{asked}`")));
                    return self.step(now, out);
                }
            } else if setup.at >= WATCHED && now - self.fed > feed {
                command(out, format_args!("u {axis}"));
                self.fed = now;
            }
        }
        if self.awaited.is_none() && now >= setup.after {
            self.lines.forget();
            self.ask(setup, out);
            (self.awaited, self.fed) = (Some((Question::Other, now)), now);
        }
        let due = self.awaited.map_or(setup.after, |(_, asked)| asked + SLOW);
        let time = if setup.at >= WATCHED { due.min(self.fed + feed) } else { due };
        Turn::Until { time: time.max(now + 1e-4), awaits: true }
    }
}
