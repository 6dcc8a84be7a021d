//! What came, and what became of it.

use crate::live::board::Figure;

/// What came, and what became of it. Nothing that is asked for is lost without being counted here.
#[derive(Debug, Default)]
pub struct Counts {
    /// Datagrams received.
    pub datagrams: Figure,
    /// Messages in them that could be read.
    pub messages: Figure,
    /// Signals given to the session.
    pub taken: Figure,
    /// Signals for which the session, or the list of what waits for its time, had no room.
    pub refused: Figure,
    /// Datagrams that are no OSC, and addresses that are no pattern.
    pub malformed: Figure,
    /// Datagrams nested too deeply.
    pub deep: Figure,
    /// Messages to an address that is not there, and releases of an id that is not.
    pub unknown: Figure,
    /// Messages whose arguments do not fit.
    pub wrong: Figure,
    /// Messages whose time had passed; they were done at once.
    pub late: Figure,
    /// Messages for a time too far ahead.
    pub far: Figure,
    /// What waited for its time when a panic came.
    pub cancelled: Figure,
    /// Ids of voices forgotten since there were too many; what plays under them goes on.
    pub forgotten: Figure,
    /// Subscriptions for which there was no room.
    pub crowded: Figure,
    /// Answers and reports that could not be sent.
    pub unsent: Figure,
    /// Datagrams that the system dropped before they could be received, where it tells (Linux).
    pub missed: Figure,
    /// Times that the system could not receive.
    pub failed: Figure,
}

impl Counts {
    /// What went wrong, in words; `None` if nothing did.
    pub fn trouble(&self) -> Option<String> {
        let kinds = [
            (&self.refused, "refused for lack of room"),
            (&self.malformed, "malformed"),
            (&self.deep, "nested too deeply"),
            (&self.unknown, "to nothing that is there"),
            (&self.wrong, "with arguments that do not fit"),
            (&self.late, "late"),
            (&self.far, "too far ahead"),
            (&self.cancelled, "cancelled by a panic"),
            (&self.forgotten, "ids forgotten"),
            (&self.crowded, "subscriptions too many"),
            (&self.unsent, "answers not sent"),
            (&self.missed, "datagrams dropped by the system"),
            (&self.failed, "failures to receive"),
        ];
        let told: Vec<String> = kinds
            .iter()
            .filter(|(figure, _)| figure.get() != 0)
            .map(|(figure, kind)| format!("{} {kind}", figure.get()))
            .collect();
        (!told.is_empty()).then(|| format!("OSC, {} messages read: {}", self.messages.get(), told.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    #[test]
    fn only_what_went_wrong_is_told() {
        let counts = Counts::default();
        counts.messages.add(9);
        counts.taken.add(9);
        assert_eq!(counts.trouble(), None);
        counts.late.add(2);
        counts.malformed.add(1);
        assert_eq!(counts.trouble().unwrap(), "OSC, 9 messages read: 1 malformed, 2 late");
    }
}
