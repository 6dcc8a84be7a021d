//! Zones of MIDI Polyphonic Expression (MPE 1.0, RP-053; M1-100): one channel for what a whole zone does, one for each of its notes.

use super::channel::Channel;

/// One of the two zones that a cable can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Zone {
    /// Managed on channel 1; its notes are on channel 2 and up.
    Lower,
    /// Managed on channel 16; its notes are on channel 15 and down.
    Upper,
}

impl Zone {
    /// Most members that one can have.
    pub const MOST: u8 = 15;

    /// The channel of what concerns all of its notes.
    pub const fn manager(self) -> Channel {
        match self {
            Self::Lower => Channel::FIRST,
            Self::Upper => Channel::LAST,
        }
    }

    /// The zone that a channel could manage.
    pub(super) fn managed_by(channel: Channel) -> Option<Self> {
        [Self::Lower, Self::Upper].into_iter().find(|zone| zone.manager() == channel)
    }
}

/// A set of channels: bit 0 is channel 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Channels(u16);

impl Channels {
    pub const ALL: Self = Self(u16::MAX);

    pub fn one(channel: Channel) -> Self {
        Self(1 << channel.index())
    }
    pub fn has(self, channel: Channel) -> bool {
        self.0 & Self::one(channel).0 != 0
    }
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    pub fn iter(self) -> impl Iterator<Item = Channel> {
        Channel::all().filter(move |c| self.has(*c))
    }
}

/// How many members each zone has; 0 where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Zones {
    lower: u8,
    upper: u8,
}

impl Zones {
    /// The two share fourteen members; what the other had of them, the newer one takes. A zone of fifteen takes the other manager too.
    pub fn set(&mut self, zone: Zone, members: u8) {
        let members = members.min(Zone::MOST);
        let left = 14_u8.saturating_sub(members);
        match zone {
            Zone::Lower => (self.lower, self.upper) = (members, self.upper.min(left)),
            Zone::Upper => (self.upper, self.lower) = (members, self.lower.min(left)),
        }
    }

    pub fn members(self, zone: Zone) -> Channels {
        let bits = |n: u8| ((1_u32 << n.min(Zone::MOST)) - 1) as u16;
        match zone {
            Zone::Lower => Channels(bits(self.lower) << 1),
            Zone::Upper => Channels(bits(self.upper).reverse_bits() >> 1),
        }
    }

    /// Manager and members; none of them where the zone is off.
    pub fn channels(self, zone: Zone) -> Channels {
        let members = self.members(zone);
        if members == Channels::default() { members } else { members.and(Channels::one(zone.manager())) }
    }

    /// The zone whose notes are on this channel.
    pub fn of_member(self, channel: Channel) -> Option<Zone> {
        [Zone::Lower, Zone::Upper].into_iter().find(|zone| self.members(*zone).has(channel))
    }

    /// Whom a message of the channel concerns that a manager sends for its whole zone: pedals, panic, reset.
    pub fn scope(self, channel: Channel) -> Channels {
        let zone = Zone::managed_by(channel);
        Channels::one(channel).and(zone.map(|zone| self.channels(zone)).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, Zone, Zones};

    fn numbers(zones: Zones, zone: Zone) -> Vec<u8> {
        zones.members(zone).iter().map(Channel::number).collect()
    }

    #[test]
    fn members_go_up_from_the_lower_manager_and_down_from_the_upper() {
        let mut zones = Zones::default();
        zones.set(Zone::Lower, 3);
        zones.set(Zone::Upper, 2);
        assert_eq!(numbers(zones, Zone::Lower), [2, 3, 4]);
        assert_eq!(numbers(zones, Zone::Upper), [14, 15]);
        let scope: Vec<u8> = zones.scope(Channel::LAST).iter().map(Channel::number).collect();
        assert_eq!(scope, [14, 15, 16]);
        let second = Channel::new(1).unwrap();
        assert_eq!(zones.scope(second).iter().collect::<Vec<_>>(), [second], "a member speaks for itself");
        assert_eq!(zones.of_member(second), Some(Zone::Lower));
        assert_eq!(zones.of_member(Channel::FIRST), None);
    }

    #[test]
    fn the_newer_zone_takes_from_the_older() {
        let mut zones = Zones::default();
        zones.set(Zone::Lower, 10);
        zones.set(Zone::Upper, 7);
        assert_eq!((numbers(zones, Zone::Lower).len(), numbers(zones, Zone::Upper).len()), (7, 7));
        zones.set(Zone::Lower, 14);
        assert!(numbers(zones, Zone::Upper).is_empty());
        assert_eq!(zones.scope(Channel::LAST).iter().count(), 1);
        zones.set(Zone::Upper, 1);
        zones.set(Zone::Lower, 15);
        assert_eq!(numbers(zones, Zone::Lower).last(), Some(&16));
        assert_eq!(zones.scope(Channel::LAST).iter().count(), 1, "a member now");
        zones.set(Zone::Upper, 15);
        assert_eq!(numbers(zones, Zone::Upper), (1..16).collect::<Vec<_>>());
        zones.set(Zone::Upper, 0);
        assert_eq!(zones, Zones::default());
    }
}
