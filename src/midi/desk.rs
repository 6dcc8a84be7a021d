//! All channels of a cable, and the zones that join some of them.

use super::channel::Channel;
use super::claims::Claims;
use super::gesture::Expression;
use super::strip::{Range, SOSTENUTO, SUSTAIN, Strip};
use super::zone::{Channels, Zone, Zones};

#[derive(Debug, Clone, Default)]
pub(super) struct Desk {
    strips: [Strip; Channel::COUNT],
    pub zones: Zones,
    nowhere: Strip,
}

impl Desk {
    pub fn strip(&self, channel: Channel) -> &Strip {
        self.strips.get(channel.index()).unwrap_or(&self.nowhere)
    }
    pub fn strip_mut(&mut self, channel: Channel) -> &mut Strip {
        self.strips.get_mut(channel.index()).unwrap_or(&mut self.nowhere)
    }

    /// The channel that manages the zone whose note is on this one.
    fn manager(&self, channel: Channel) -> Option<&Strip> {
        self.zones.of_member(channel).map(|zone| self.strip(zone.manager()))
    }

    /// How a note of a channel is bent and pressed: bends add up, of pressures the hardest counts, and timbres are taken from their
    /// middle, where they add nothing.
    pub fn expression(&self, channel: Channel, poly_pressure: u8) -> Expression {
        let (own, manager) = (self.strip(channel), self.manager(channel));
        let pressure = poly_pressure.max(own.pressure).max(manager.map_or(0, |m| m.pressure));
        let timbre = i16::from(own.timbre()) + manager.map_or(0, |m| i16::from(m.timbre()) - 64);
        Expression {
            bend: own.bend_semitones() + manager.map_or(0.0, Strip::bend_semitones),
            pressure: f64::from(pressure) / 127.0,
            timbre: f64::from(timbre.clamp(0, 127)) / 127.0,
        }
    }

    /// Whether a pedal holds notes of the channel.
    pub fn pedal(&self, channel: Channel, number: u8) -> bool {
        self.strip(channel).pedal(number) || self.manager(channel).is_some_and(|m| m.pedal(number))
    }
    /// Whether a pedal keeps a note whose key is up; `caught` if its key was down when the sostenuto pedal went down.
    pub fn holds(&self, channel: Channel, caught: bool) -> bool {
        self.pedal(channel, SUSTAIN) || caught && self.pedal(channel, SOSTENUTO)
    }

    /// The channel's bend range; in a zone of MPE all members have one.
    pub fn set_range(&mut self, channel: Channel, range: Range) -> Channels {
        let members = self.zones.of_member(channel).map(|zone| self.zones.members(zone));
        let channels = members.unwrap_or(Channels::one(channel));
        channels.iter().for_each(|c| self.strip_mut(c).range = range);
        channels
    }

    /// Makes a zone anew: its channels, and those that any zone loses, rest with the bend range of what they are now. Gives them.
    pub fn set_zone(&mut self, zone: Zone, members: u8) -> Channels {
        let both = |zones: Zones| zones.channels(Zone::Lower).and(zones.channels(Zone::Upper));
        let before = self.zones;
        self.zones.set(zone, members);
        let now = self.zones;
        let changes = |c: Channel| {
            now.channels(zone).has(c)
                || both(before).has(c) && (before.of_member(c) != now.of_member(c) || !both(now).has(c))
        };
        let channels = Channel::all().filter(|c| changes(*c)).map(Channels::one);
        let channels = channels.fold(Channels::default(), Channels::and);
        for channel in channels.iter() {
            let range = if now.of_member(channel).is_some() { Range::MEMBER } else { Range::TWO };
            let strip = self.strip_mut(channel);
            strip.rest();
            strip.range = range;
        }
        channels
    }

    /// Controllers are listened to by their numbers.
    pub fn claim(&mut self, claims: &Claims) {
        for (channel, strip) in Channel::all().zip(&mut self.strips) {
            strip.claimed = claims.of(channel);
        }
    }

    /// As after switching on; what is claimed stays so.
    pub fn reset(&mut self) {
        let claimed = self.strips.map(|strip| strip.claimed);
        *self = Self::default();
        self.strips.iter_mut().zip(claimed).for_each(|(strip, claimed)| strip.claimed = claimed);
    }

    /// Hands off, everywhere.
    pub fn rest(&mut self) {
        self.strips.iter_mut().for_each(Strip::rest);
    }
}
