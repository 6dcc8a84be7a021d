//! Controllers that somebody listens to by their numbers.

use super::channel::Channel;

/// Which controllers are meant for what listens to them: on those channels they say where they stand, and mean nothing else. Timbre (74)
/// alone keeps its meaning besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Claims([Own; Channel::COUNT]);

/// Those of one channel: bit 0 is controller 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Own {
    all: u128,
    /// Of these, those that tell steps.
    steps: u128,
}

impl Claims {
    /// One more, 0 to 119, on a channel, or on all.
    pub fn add(&mut self, number: u8, channel: Option<Channel>) {
        self.on(channel, |own| own.all |= bit(number));
    }

    /// One more that tells steps, as an [encoder](super::Encoder) does: it stands nowhere, so that nothing resets it, and has no lower half.
    pub fn add_steps(&mut self, number: u8, channel: Option<Channel>) {
        let lower = if number < 32 { bit(number + 32) } else { 0 };
        self.on(channel, |own| {
            own.all |= bit(number) | lower;
            own.steps |= bit(number);
        });
    }

    fn on(&mut self, channel: Option<Channel>, change: impl FnMut(&mut Own)) {
        let fits = |of: &(Channel, &mut Own)| channel.is_none_or(|channel| channel == of.0);
        Channel::all().zip(&mut self.0).filter(fits).map(|(_, own)| own).for_each(change);
    }

    pub(super) fn of(&self, channel: Channel) -> Own {
        self.0.get(channel.index()).copied().unwrap_or_default()
    }
}

impl Own {
    /// Whether it is listened to by its own number.
    pub fn has(self, number: u8) -> bool {
        self.all & bit(number) != 0
    }
    /// Whether it tells steps.
    pub fn steps(self, number: u8) -> bool {
        self.steps & bit(number) != 0
    }
    /// Whether it is listened to, or as the lower half of one that is.
    pub fn takes(self, number: u8) -> bool {
        self.has(number) || (32..64).contains(&number) && self.has(number - 32)
    }
}

fn bit(number: u8) -> u128 {
    if number < super::strip::MODES { 1 << number } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::{Channel, Claims};

    #[test]
    fn a_controller_is_claimed_with_its_lower_half_on_its_channel() {
        let mut claims = Claims::default();
        claims.add(6, Some(Channel::LAST));
        claims.add(119, None);
        claims.add(120, None);
        let takes = |channel| (0..=255).filter(|n| claims.of(channel).takes(*n)).collect::<Vec<u8>>();
        assert_eq!((takes(Channel::LAST), takes(Channel::FIRST)), (vec![6, 38, 119], vec![119]));
        assert!(!claims.of(Channel::LAST).has(38));
    }
}
