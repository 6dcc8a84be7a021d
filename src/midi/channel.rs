//! One of the sixteen channels of a cable.

use std::fmt;

/// A channel, 0 to 15 in messages and 1 to 16 for people. It cannot be another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Channel(u8);

impl Channel {
    /// How many there are.
    pub const COUNT: usize = 16;
    /// Channel 1 for people: manager of the lower zone of MPE.
    pub const FIRST: Self = Self(0);
    /// Channel 16 for people: manager of the upper zone of MPE.
    pub const LAST: Self = Self(15);

    /// From 0 to 15; `None` for more.
    pub const fn new(index: u8) -> Option<Self> {
        if index < 16 { Some(Self(index)) } else { None }
    }
    /// The channel of a status byte of a channel message: its lower four bits.
    pub const fn of_status(status: u8) -> Self {
        Self(status & 0x0F)
    }
    /// 0 to 15.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
    /// 1 to 16, as people count.
    pub const fn number(self) -> u8 {
        self.0 + 1
    }
    /// All of them, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..16).map(Self)
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.number().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::Channel;

    #[test]
    fn there_are_sixteen_and_people_count_from_one() {
        assert_eq!(Channel::new(16), None);
        assert_eq!(Channel::new(15), Some(Channel::LAST));
        assert_eq!(Channel::of_status(0x9F), Channel::LAST);
        assert_eq!(Channel::all().count(), Channel::COUNT);
        assert!(Channel::all().enumerate().all(|(i, c)| c.index() == i && usize::from(c.number()) == i + 1));
        assert_eq!(format!("{:>3}", Channel::LAST), " 16");
    }
}
