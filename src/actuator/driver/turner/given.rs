//! What is sent to a motor at an instant, and what its model makes of that.

use super::{Mode, OPENS, Swell, Turner};
use crate::actuator::drive::Drive;
use crate::actuator::driver::coast::{Coast, STANDS};
use crate::actuator::driver::order::{After, By, Switch};
use crate::actuator::driver::setup::Shaping;
use crate::actuator::driver::warmth::Before;

impl Turner {
    /// What is sent from now on; `whole`: at the beginning of a sample.
    pub(super) fn given(&mut self, speeds: &[f64; 3], whole: bool) -> f64 {
        let (speed, current) =
            self.motor.as_ref().map_or((0.0, 0.0), |motor| (motor.speed(), motor.current()));
        let (shaping, speeds) = match self.mode {
            _ if self.rests => return 0.0,
            _ if self.halts => return self.seek.step(speed, current, 0.0),
            Mode::Speed(wished, ..) => return self.seek.step(speed, current, wished),
            Mode::Click(pieces, piece, _) => return pieces.list.get(piece).map_or(0.0, |piece| piece.1),
            Mode::On(switch) => return self.on(switch),
            Mode::Roll(after) => return self.after(after),
            Mode::Keep(wished, shaping) => (shaping, [wished; 3]),
            Mode::Swell(swell) => (swell.shaping, self.swell(swell)),
            Mode::Level => (self.setup.shaping, *speeds),
        };
        match shaping {
            Shaping::Plain => self.plain(speeds[0]),
            Shaping::OnOff => self.on_off(speeds[0]),
            Shaping::Overdrive => self.seek.step(speed, current, speeds[1]),
            Shaping::Switching => self.switched(speed, current, speeds[1]),
            Shaping::Clicks => self.seek.step(speed, current, 0.0),
            _ if self.away && speeds == [0.0; 3] && self.stands() => 0.0,
            Shaping::Inverse if self.away => {
                // Also the current must have died away: the inverse would take it, and what it is still to do, at once.
                let off = self.seek.off(speed, current, speeds[0]).abs();
                let left = (speed - speeds[0]).abs();
                if off.max(left) < STANDS * self.setup.full_speed() && whole {
                    self.away = false;
                    self.follow.restart(current);
                    return self.followed(&speeds);
                }
                self.seek.step(speed, current, speeds[1])
            }
            Shaping::Inverse => self.followed(&speeds),
        }
    }

    /// What is wished for now, rad/s, where levels wish for that.
    pub(super) fn wish(&self, level: f64) -> f64 {
        match self.mode {
            _ if self.halts || self.rests => 0.0,
            Mode::Level => level,
            Mode::Speed(wished, ..) | Mode::Keep(wished, _) => wished,
            Mode::Swell(Swell { number, root, begin, .. }) => {
                let track = self.tracks.get(number as usize);
                track.map_or(0.0, |track| track.wished(self.clock as f64 - begin, root))
            }
            Mode::Click(..) | Mode::On(_) | Mode::Roll(_) => 0.0,
        }
    }

    /// The speeds of an envelope: at this sample, after it, and after that. What is wished, where no plan is kept to.
    fn swell(&self, swell: Swell) -> [f64; 3] {
        let Some(track) = self.tracks.get(swell.number as usize) else { return [0.0; 3] };
        let at = self.clock as f64 - swell.begin;
        [0.0, 1.0, 2.0].map(|ahead| match swell.shaping {
            Shaping::Inverse => track.planned(at + ahead, swell.root),
            _ => track.wished(at + ahead, swell.root),
        })
    }

    /// What the motor makes itself in the middle of this sample where nothing flows, V.
    fn rolling(&self) -> f64 {
        let (p, speed) = (&self.setup.parameters, self.motor.as_ref().map_or(0.0, |motor| motor.speed()));
        p.gain * Coast::new(p).after(speed.abs(), 0.5 / self.setup.rate).copysign(speed)
    }

    /// A drive that is switched on.
    pub(super) fn on(&self, switch: Switch) -> f64 {
        let p = &self.setup.parameters;
        let wanted = match (self.setup.imposes, switch.by) {
            (Drive::Voltage, By::Current) => switch.amount + self.rolling(),
            (Drive::Current, By::Voltage) => switch.amount - self.rolling() / p.resistance,
            _ => switch.amount,
        };
        wanted.clamp(self.setup.least(), self.setup.limit)
    }

    /// What follows it.
    pub(super) fn after(&self, after: After) -> f64 {
        let wanted = match (self.setup.imposes, after) {
            (Drive::Voltage, After::Open) => self.rolling(),
            (Drive::Current, After::Short) => -self.rolling() / self.setup.parameters.resistance,
            _ => 0.0,
        };
        wanted.clamp(self.setup.least(), self.setup.limit)
    }

    fn followed(&mut self, speeds: &[f64; 3]) -> f64 {
        let (given, limited) = self.follow.step(*speeds);
        self.counts.limited += u64::from(limited);
        given
    }

    fn switched(&mut self, speed: f64, current: f64, wished: f64) -> f64 {
        let off = wished - speed;
        // What is to stand is not kept swinging about rest.
        if wished == 0.0 && off.abs() <= self.seek.most() {
            return self.seek.step(speed, current, wished);
        }
        if off != 0.0 {
            self.forward = off > 0.0;
        }
        if self.forward { self.setup.limit } else { self.setup.least() }
    }

    pub(super) fn stands(&self) -> bool {
        let Some(motor) = &self.motor else { return true };
        motor.is_stuck()
            && motor.current().abs() * self.setup.parameters.gain <= self.setup.parameters.stiction
            || self.seek.off(motor.speed(), motor.current(), 0.0).abs() < STANDS * self.setup.full_speed()
                && motor.speed().abs() < STANDS * self.setup.full_speed()
    }

    /// Moves the model on, and says what is sent meanwhile.
    pub(super) fn move_model(&mut self, given: f64, share: f64) -> f64 {
        let Some(motor) = &mut self.motor else { return given };
        let (gain, before, was) = (self.setup.parameters.gain, motor.speed(), Before::of(motor));
        let turned = motor.turned();
        // So close above what the motor makes itself, what flows is nothing, and the carrier for it would be all but none.
        let blocked = self.setup.one_way && given <= gain * before.max(0.0) + OPENS * self.setup.limit;
        if blocked {
            // What the coil still holds goes on through the diodes.
            self.diodes.part(motor, 0.0, share, |_, _, _| {});
        } else {
            motor.drive(self.setup.drive(given));
            if share == 1.0 { motor.step() } else { motor.part(share) }
        }
        if let Some(hangs) = &mut self.hangs {
            hangs.turned(motor.turned() - turned);
        }
        let emf = 0.5 * gain * (before + motor.speed());
        self.emf += share * emf;
        if let Some(warmth) = &mut self.warmth {
            warmth.note(given, share, was, motor, blocked);
        }
        match self.setup.one_way {
            true if blocked => 0.0,
            true => (given - emf).max(0.0),
            false => given,
        }
    }
}
