//! Clicks from a place that is known: the motor's model ends them while they are under way, gravity included.
//!
//! Each of their drives ends at the instant at which the model, were it driven on as is foreseen, would stand where it is to stand: forward until driven
//! backward from there it would come as far as was ordered, backward until it stands once its coil has been emptied. That is looked for within
//! the sample that is next, so it costs a step of the model more for each sample of a click.

use std::f64::consts::{PI, TAU};

use super::{Mode, Turner};
use crate::actuator::drive::Drive;
use crate::actuator::driver::hanging::Hanging;
use crate::actuator::driver::order::{PIECES, Pieces};
use crate::actuator::driver::setup::Setup;
use crate::actuator::driver::stopping::{Stopping, certain};

/// The most looks at where within a sample a drive ends; how near is near enough, as a share of it.
const LOOKS: usize = 8;
const NEAR: f64 = 1e-6;

/// How much longer than of a motor that lies flat a drive may last, as a multiple, and s beyond that.
const LONGER: f64 = 4.0;
const BEYOND: f64 = 0.05;

/// A mass that hangs no farther from home than that is there, rad: 3 degrees.
const THERE: f64 = 0.05;

/// A click that waits for rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Click {
    pub pieces: Pieces,
    pub aim: Aim,
}

/// What a click is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Aim {
    /// Its pieces are all there is to it.
    Pieces,
    /// So many turns from where the mass hangs, if that is known.
    Turns(f64),
    /// To where the model's angle is this, rad.
    To(f64),
    /// Home, rad from straight down; and that it was brought there, and is to come to rest.
    Home(f64),
    Homed(f64),
}

impl Turner {
    /// Where the mass hangs, rad from straight down, as far as that is known: after the way home, until it has turned so much that its model's
    /// figures may be off by more than counts.
    pub fn hangs(&self) -> Option<f64> {
        let motor = self.motor.as_ref()?;
        self.hangs.as_ref().filter(|hangs| hangs.is_known())?;
        Some((motor.turned() + PI).rem_euclid(TAU) - PI)
    }

    /// The same click as it is from where the mass hangs.
    pub(super) fn as_it_hangs(&self, click: Click) -> Click {
        let Click { mut pieces, aim } = click;
        let known = self.hangs().filter(|_| can_be_ended(&self.setup));
        let (Some(hangs), Some(motor)) = (known, &self.motor) else {
            let aim = if let Aim::Home(_) = aim { aim } else { Aim::Pieces };
            return Click { pieces, aim };
        };
        let Aim::Turns(turns) = aim else { return click };
        if turns == 0.0 {
            return Click { pieces: Pieces::default(), aim: Aim::Pieces };
        }
        let way = turns.signum();
        let amount = certain(&self.setup.parameters, hangs, way, pieces.list[0].1.abs(), self.setup.limit);
        for (piece, sign) in pieces.list.iter_mut().zip([1.0, -1.0, 1.0]) {
            piece.1 = sign * way * amount;
        }
        Click { pieces, aim: Aim::To(motor.turned() + TAU * turns) }
    }

    /// Whether a mass that rests is to be brought home again after a while: one that was brought there before, and has moved since.
    pub(super) fn waits_to_park(&self) -> bool {
        let (Some(_), Some(hanging)) = (self.setup.park, &self.hangs) else { return false };
        let there = self.hangs().is_some_and(|hangs| {
            let off = (hanging.home - hangs + PI).rem_euclid(TAU) - PI;
            off.abs() < THERE
        });
        can_be_ended(&self.setup) && !there
    }

    /// Of a motor at rest: sends its mass home once it has rested for long enough. That is the whole way home: turned back by its model, slowly and
    /// near the top, it would be farther off each time.
    pub(super) fn park(&mut self) {
        let (Some(seconds), Some(Hanging { home, .. })) = (self.setup.park, self.hangs) else { return };
        self.rested += 1;
        if self.halts
            || self.rests
            || (self.rested as f64) < seconds * self.setup.rate
            || !self.waits_to_park()
        {
            return;
        }
        self.rested = 0;
        let click = Click { pieces: self.way, aim: Aim::Home(home) };
        self.mode = Mode::Speed(0.0, Some(click), self.clock);
        (self.voice, self.away) = (None, true);
    }

    /// Brings forward the end of a drive of a click that is under way, where the model says so, and gives what becomes of the next.
    pub(super) fn foresee(&mut self, now: f64, given: f64, share: f64) {
        let (Aim::To(target), Mode::Click(pieces, piece @ 0..=1, ends)) = (self.aim, self.mode) else {
            return;
        };
        let Some(motor) = &self.motor else { return };
        let (_, amount) = pieces.list[0];
        let (way, volts) = (amount.signum(), amount.abs());
        let left = |motor: &_| {
            let stopping = Stopping { motor, way, volts };
            match piece {
                0 => way * (target - motor.turned()) - stopping.angle(),
                _ => stopping.emptied().1,
            }
        };
        let ahead = |part: f64| {
            let mut ahead = (**motor).clone();
            ahead.drive(self.setup.drive(given));
            if part == 1.0 {
                ahead.step()
            } else {
                ahead.part(part)
            }
            left(&ahead)
        };
        let (mut from, mut to) = ((0.0, left(motor)), (share, 0.0));
        let mut part = 0.0;
        if from.1 > 0.0 {
            to.1 = ahead(share);
            if to.1 > 0.0 {
                return;
            }
            part = share;
            // By the chord, of which the end that stays is taken for less each time.
            for _ in 0..LOOKS {
                part = to.0 - to.1 * (to.0 - from.0) / (to.1 - from.1);
                let is = (part, ahead(part));
                if (is.0 - to.0).abs() < NEAR * share || is.1 == 0.0 {
                    break;
                }
                if (is.1 > 0.0) == (to.1 > 0.0) {
                    from.1 *= 0.5
                } else {
                    from = to
                }
                to = is;
            }
        }
        self.mode = Mode::Click(pieces, piece, (now + part).min(ends));
    }

    /// Samples for which a drive of a click that is to begin lasts at most: where the model ends it, longer than it should, and the last until the coil is empty.
    pub(super) fn lasts(&self, pieces: &Pieces, piece: usize) -> f64 {
        let (seconds, _) = pieces.list[piece];
        let seconds = match (self.aim, &self.motor) {
            (Aim::To(_), Some(motor)) if piece + 1 == PIECES => {
                let (_, amount) = pieces.list[0];
                Stopping { motor, way: amount.signum(), volts: amount.abs() }.emptied().0
            }
            (Aim::To(_), _) => LONGER * seconds + BEYOND,
            _ => seconds,
        };
        seconds * self.setup.rate
    }

    /// A mass that was brought home and stands there hangs where home is.
    pub(super) fn come_home(&mut self) {
        if !(self.mode == Mode::Level && self.stands()) {
            self.rested = 0;
        }
        let Aim::Homed(home) = self.aim else { return };
        if self.mode != Mode::Level || !self.ahead.is_still() {
            self.aim = Aim::Pieces;
        } else if self.stands() {
            self.aim = Aim::Pieces;
            self.hangs = Some(Hanging::at(home));
            if let Some(motor) = &mut self.motor {
                motor.place(home, 0.0);
            }
        }
    }
}

/// Whether the model may end clicks: of voltages that may go either way.
fn can_be_ended(setup: &Setup) -> bool {
    !setup.one_way && setup.imposes == Drive::Voltage
}
