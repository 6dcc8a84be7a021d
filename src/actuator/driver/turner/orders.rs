//! What becomes of orders: they wait, are carried out, and end.

use super::known::{Aim, Click};
use super::{Mode, PATIENCE, Swell, Turner};
use crate::actuator::driver::order::{After, Entry, Order, PIECES, Pieces};
use crate::actuator::driver::setup::Shaping;

impl Turner {
    /// An order of a voice at an instant: samples since the beginning, the same in which levels are counted. It comes in the sample that begins then or
    /// next. The release of a voice whose order does not hold is nothing.
    pub fn order(&mut self, at: f64, voice: u64, order: Order) {
        let now = if at.is_finite() { at.max(0.0) } else { self.clock as f64 };
        let at = now + self.late() as f64;
        self.agenda.push(Entry { at, voice, order }, now.ceil());
    }

    /// Forgets what waits from a sample on, and brakes there. It is never late.
    pub fn brake(&mut self, clock: u64) {
        let at = clock.max(self.clock) as f64;
        self.agenda.clear_from(at);
        self.agenda.push(Entry { at, voice: u64::MAX, order: Order::Brake }, at);
    }

    /// Whether it is to stand from the next sample on, whatever is played and ordered meanwhile: braked as fast as may be, or given nothing at all. What
    /// was ordered and still holds goes on then; what levels were known ahead is forgotten.
    pub fn halt(&mut self, halts: bool, rests: bool) {
        if halts && !self.halts {
            self.ahead.forget();
        }
        (self.halts, self.rests) = (halts, rests);
        self.away |= halts;
        if halts {
            self.aim = Aim::Pieces;
        }
    }

    /// Knows other envelopes from now on. Where they differ from those before, what was ordered of these ends.
    pub(crate) fn trade_tracks(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.tracks, &mut other.tracks);
        self.agenda.clear_swells();
        if matches!(self.mode, Mode::Swell(_)) {
            self.mode = Mode::Speed(0.0, None, self.clock);
        }
    }

    /// When the next order is due, in samples, if it is in this one. Releases of voices whose orders hold no longer are nothing, and are
    /// forgotten, and so is a way home that there is not: they must not part a sample either.
    pub(super) fn due(&mut self) -> Option<f64> {
        let end = (self.clock + 1) as f64;
        while let Some(first) = self.agenda.first().filter(|first| first.at < end) {
            if self.heeds(first) {
                return Some(first.at);
            }
            self.counts.homeless += u64::from(first.order == Order::Homeless);
            self.agenda.pop_before(end);
        }
        None
    }

    fn heeds(&self, entry: &Entry) -> bool {
        match entry.order {
            Order::Homeless => false,
            Order::Release => self.voice == Some(entry.voice),
            _ => true,
        }
    }

    pub(super) fn carry_out(&mut self, entry: Entry) {
        if !self.heeds(&entry) {
            self.counts.homeless += u64::from(entry.order == Order::Homeless);
            return;
        }
        let Entry { voice, order, .. } = entry;
        if self.setup.one_way && order.is_backward() {
            self.counts.backward += 1;
            return;
        }
        if self.setup.shaping == Shaping::Clicks
            && matches!(order, Order::Spin(_) | Order::Keep(..) | Order::Swell(..) | Order::On(_))
        {
            self.counts.unplayed += 1;
            return;
        }
        let order = order.sane(self.setup.full_speed(), self.setup.limit);
        match order {
            Order::Click(pieces) | Order::Turn(pieces, _) | Order::Home(pieces, _) => {
                let aim = match order {
                    Order::Turn(_, turns) => Aim::Turns(turns),
                    Order::Home(_, angle) => Aim::Home(angle),
                    _ => Aim::Pieces,
                };
                if let Aim::Home(_) = aim {
                    self.way = pieces;
                }
                // At rest it begins at once.
                self.mode = Mode::Speed(0.0, Some(Click { pieces, aim }), self.clock);
                self.voice = None;
            }
            Order::Spin(speed) => {
                self.mode = Mode::Speed(speed, None, self.clock);
                self.voice = Some(voice);
            }
            Order::Keep(speed, shaping) => {
                self.mode = Mode::Keep(speed, shaping);
                self.voice = Some(voice);
            }
            Order::Swell(number, root, shaping) => {
                if self.tracks.get(number as usize).is_none() {
                    return;
                }
                self.mode = Mode::Swell(Swell { number, root, begin: entry.at, shaping });
                self.voice = None;
            }
            Order::On(switch) => {
                self.mode = Mode::On(switch);
                self.voice = Some(voice);
            }
            Order::Release => {
                self.voice = None;
                self.mode = match self.mode {
                    Mode::On(switch) => Mode::Roll(switch.after),
                    Mode::Keep(_, Shaping::Plain) => Mode::Roll(After::Nothing),
                    _ => Mode::Speed(0.0, None, self.clock),
                };
            }
            // Not heeded above.
            Order::Homeless => return,
            Order::Brake => {
                self.voice = None;
                self.mode = Mode::Speed(0.0, None, self.clock);
            }
        }
        self.away = true;
        self.aim = Aim::Pieces;
    }

    /// Goes on to what comes behind what has been reached, at this instant (samples).
    pub(super) fn arrive(&mut self, now: f64, speeds: &[f64; 3]) {
        if let Mode::Swell(swell) = self.mode
            && self
                .tracks
                .get(swell.number as usize)
                .is_none_or(|track| now - swell.begin >= track.samples() as f64)
        {
            self.mode = Mode::Speed(0.0, None, self.clock);
        }
        if matches!(self.mode, Mode::Roll(_)) && (*speeds != [0.0; 3] || self.stands()) {
            self.mode = Mode::Level;
        }
        if let Mode::Speed(0.0, click, since) = self.mode {
            let waited = (self.clock - since) as f64 > PATIENCE * self.setup.rate;
            if self.voice.is_none() && (self.stands() || waited) {
                self.mode = match click.map(|click| self.as_it_hangs(click)) {
                    Some(Click { pieces, aim }) if self.begins(&pieces) => {
                        self.aim = aim;
                        Mode::Click(pieces, 0, now + self.lasts(&pieces, 0))
                    }
                    _ => Mode::Level,
                };
            }
        }
        while let Mode::Click(pieces, piece, ends) = self.mode {
            if ends > now {
                break;
            }
            self.mode = match pieces.list.get(piece + 1) {
                _ if self.cut => Mode::Speed(0.0, None, self.clock),
                Some(_) if piece + 1 < PIECES => {
                    Mode::Click(pieces, piece + 1, ends + self.lasts(&pieces, piece + 1))
                }
                _ => {
                    self.aim = match self.aim {
                        Aim::Home(angle) => Aim::Homed(angle),
                        _ => Aim::Pieces,
                    };
                    Mode::Level
                }
            };
        }
    }

    /// Whether a click is begun. One that is weaker than it was ordered is slower than its pieces have it: it ends as one of which some did not arrive.
    fn begins(&mut self, click: &Pieces) -> bool {
        self.cut = false;
        let Some(warmth) = &mut self.warmth else { return true };
        let share = warmth.click(click);
        self.cut = share < 1.0;
        self.counts.weakened += u64::from(share > 0.0 && share < 1.0);
        self.counts.refused += u64::from(share == 0.0);
        share > 0.0
    }
}
