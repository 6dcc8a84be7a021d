//! Exchange by exchange, and what becomes of an axis that leaves closed loop.

use super::super::setup::{ERRORS, Errors};
use super::super::text::{self, command};
use super::{GLANCE, IDLE, LEAST, ODrive, QUIET, Question, SLOW, Settings, Stage};
use crate::io::knob::lost::Lost;
use crate::io::knob::servo::{Reading, Servo};
use crate::io::knob::session::Turn;

impl ODrive {
    pub(super) fn reading(&mut self, angle: f64, velocity: f64, now: f64, asked: f64, servo: &mut dyn Servo) {
        self.trips.push(now - asked);
        let dt = self.read.map_or(self.period(), |last| (now - last).max(LEAST));
        (self.awaited, self.answered, self.read, self.flushing) = (None, now, Some(now), false);
        self.counts.readings += 1;
        self.felt = true;
        if let Stage::Falling { since, from } = self.stage {
            let left = 1.0 - (now - since) / self.settings.ramp.max(1e-9);
            self.torque = from * left.max(0.0);
            return;
        }
        let round_trip = self.trips.sum_up();
        let asked = servo.tick(&Reading { angle, velocity: Some(velocity), dt, round_trip });
        self.set_torque(asked);
    }

    fn set_torque(&mut self, asked: f64) {
        let most = self.settings.most_torque;
        self.torque = if !asked.is_finite() {
            self.counts.not_finite += 1;
            0.0
        } else {
            self.counts.clipped += u64::from(asked.abs() > most);
            asked.clamp(-most, most)
        };
    }

    /// Seconds after which an answer is late: those of an exchange; on a line that is slower or wavers, a quarter more than the slowest of the last
    /// answers took, so that what is usual there is not late.
    fn tick(&self) -> f64 {
        self.period().max(1.25 * self.trips.sum_up().worst)
    }

    /// While an answer is late there is no torque; whether it was taken away just now.
    pub(super) fn ease(&mut self, now: f64, out: &mut Vec<u8>) -> bool {
        let Some((_, asked)) = self.awaited.filter(|_| self.stage == Stage::Driven && !self.eased) else {
            return false;
        };
        if self.torque == 0.0 || now - asked <= self.tick() {
            return false;
        }
        (self.torque, self.eased) = (0.0, true);
        command(out, format_args!("c {} 0", self.settings.axis));
        true
    }

    /// The next exchange takes the torque that there is by then, and not the one that there was with the last answer.
    pub(super) fn refresh(&mut self, now: f64, servo: &mut dyn Servo) {
        let quiet = self.awaited.is_none() && self.drain.is_none() && self.probe.is_none();
        let due = self.stage == Stage::Driven && self.felt && quiet && now >= self.next;
        if let Some(torque) = due.then(|| servo.newest()).flatten() {
            self.set_torque(torque);
        }
    }

    /// It is no longer in closed loop.
    pub(super) fn left(&mut self, state: i64) {
        (self.torque, self.release) = (0.0, true);
        match self.errors {
            Some(_) => self.stage = Stage::Diagnosing { state },
            None => self.diagnosed(state, 0),
        }
    }

    pub(super) fn diagnosed(&mut self, state: i64, errors: u64) {
        let kind = self.errors.unwrap_or(Errors::Old);
        let watchdog = errors == kind.watchdog();
        self.end(Lost::Axis { state: Some(state), errors, names: kind.names(errors), watchdog });
    }

    pub(super) fn turn_driven(&mut self, now: f64, out: &mut Vec<u8>) -> Turn {
        let Settings { axis, patience, watchdog, ramp, .. } = self.settings;
        if let Some((_, asked)) = self.awaited
            && now - asked > patience
        {
            self.counts.dropped += 1;
            self.drop_thread(now);
        }
        if let Stage::Falling { since, .. } = self.stage
            && (now - since >= ramp || self.drain.is_some())
        {
            self.let_go(out);
            self.stage = Stage::Done;
            return Turn::Done;
        }
        if now - self.answered > watchdog {
            self.end(Lost::Stalled(now - self.answered));
            return self.step(now, out);
        }
        if std::mem::take(&mut self.release) {
            command(out, format_args!("c {axis} 0"));
        }
        if let Some(since) = self.drain {
            let quiet = since.max(self.heard) + QUIET;
            if now < quiet {
                return Turn::Until { time: quiet, awaits: true };
            }
            self.lines.forget();
            self.drain = None;
        }
        if self.awaited.is_none() && now >= self.next {
            let period = self.period();
            self.next = if now - self.next > period { now + period } else { self.next + period };
            command(out, format_args!("c {axis} {}", text::torque(self.torque)));
            let glance = self.tells_state && now - self.glanced > GLANCE;
            self.flushing = self.probe.is_some();
            let question =
                self.probe.take().unwrap_or(if glance { Question::State } else { Question::Feedback });
            if question == Question::State {
                self.glanced = now;
                command(out, format_args!("r axis{axis}.current_state"));
            } else {
                command(out, format_args!("f {axis}"));
            }
            self.awaited = Some((question, now));
            self.eased = false;
        }
        let fall = if let Stage::Falling { since, .. } = self.stage { since + ramp } else { f64::INFINITY };
        let (time, awaits) = match self.awaited {
            // A hair later, so that it is over by then whatever rounding does.
            Some((_, asked)) if !self.eased && self.torque != 0.0 => {
                (asked + patience.min(self.tick() + LEAST), true)
            }
            Some((_, asked)) => (asked + patience, true),
            None => (self.next, false),
        };
        Turn::Until { time: time.min(fall), awaits }
    }

    /// No torque, idle, and no watchdog that would call it an error.
    pub(super) fn let_go(&self, out: &mut Vec<u8>) {
        let axis = self.settings.axis;
        command(out, format_args!("c {axis} 0"));
        command(out, format_args!("w axis{axis}.requested_state {IDLE}"));
        command(out, format_args!("w axis{axis}.config.enable_watchdog 0"));
    }

    pub(super) fn turn_diagnosing(&mut self, state: i64, now: f64, out: &mut Vec<u8>) -> Turn {
        let axis = self.settings.axis;
        match (self.awaited, self.errors) {
            (Some((_, asked)), _) if now - asked > SLOW => {
                self.diagnosed(state, 0);
                return self.step(now, out);
            }
            (None, Some(kind)) => {
                let name = ERRORS[kind as usize];
                command(out, format_args!("c {axis} 0"));
                command(out, format_args!("r axis{axis}.{name}"));
                self.awaited = Some((Question::Other, now));
            }
            _ => {}
        }
        Turn::Until { time: now + QUIET, awaits: true }
    }
}
