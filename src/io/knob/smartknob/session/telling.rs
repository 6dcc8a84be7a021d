//! What goes to the knob, and goes again until it is acknowledged.

use super::super::config::Config;
use super::super::frame::pack;
use super::super::message::ToKnob;
use super::{AGAIN, Feel, Flight, IN_FORCE, SmartKnob, TRIES, Telling, WAKE};

impl SmartKnob {
    /// A 0 before it, for a knob that has been restarted since its last sign of life.
    pub(super) fn send(message: &[u8], out: &mut Vec<u8>) {
        out.push(0);
        out.extend(pack(message));
    }

    pub(super) fn ask(&mut self, now: f64, out: &mut Vec<u8>) {
        let ping = self.question(now);
        out.extend(WAKE);
        out.extend(pack(&ping.message));
        self.ping = Some(ping);
    }

    /// Asks again; whether it was asked often enough.
    pub(super) fn ask_again(&mut self, most: u32, now: f64, out: &mut Vec<u8>) -> bool {
        let Some(ping) = self.ping.as_mut().filter(|ping| now - ping.sent >= AGAIN) else { return false };
        if ping.tries >= most {
            return true;
        }
        (ping.sent, ping.tries) = (now, ping.tries + 1);
        self.counts.dropped += 1;
        out.extend(WAKE);
        out.extend(pack(&ping.message));
        false
    }

    pub(super) fn tell(&mut self, mut feel: Feel, now: f64, out: &mut Vec<u8>) {
        if let (true, Some(current)) = (feel.stay, &self.current) {
            let Config { position, sub_position, position_nonce, .. } = current.config;
            feel.config = Config { position, sub_position, position_nonce, ..feel.config };
        } else {
            let last =
                self.current.as_ref().map_or(self.nonce as u8, |current| current.config.position_nonce);
            feel.config.position_nonce = last.wrapping_add(1);
        }
        let nonce = self.count();
        let message = ToKnob::Config(&feel.config).encode(nonce);
        Self::send(&message, out);
        let flight = Flight { nonce, message, sent: now, tries: 1 };
        self.telling = Some(Telling { feel, flight, acknowledged: None });
    }

    /// Whether what it is told to be is given up, and why.
    pub(super) fn tell_again(&mut self, now: f64, out: &mut Vec<u8>) -> Option<String> {
        let alive = self.is_alive(now);
        let telling = self.telling.as_mut()?;
        let flight = &mut telling.flight;
        match telling.acknowledged {
            None if now - flight.sent < AGAIN || !alive => None,
            None if flight.tries >= TRIES => Some("it does not acknowledge it".into()),
            None => {
                (flight.sent, flight.tries) = (now, flight.tries + 1);
                self.counts.dropped += 1;
                Self::send(&flight.message, out);
                None
            }
            Some(since) if now - since > IN_FORCE => Some(match self.log.is_empty() {
                true => "it got it and did not take it".into(),
                false => format!("it got it and did not take it; its log says: {}", self.log),
            }),
            Some(_) => None,
        }
    }
}
