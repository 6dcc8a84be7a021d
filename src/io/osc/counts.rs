//! What came, and what became of it.

use crate::live::board::{Figure, in_words};

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
    /// What waited for its time when a panic or the end came, and what would have taken one back that came after it.
    pub cancelled: Figure,
    /// Ids of voices forgotten since there were too many; what plays under them goes on.
    pub forgotten: Figure,
    /// Subscriptions for which there was no room.
    pub crowded: Figure,
    /// Answers and reports that could not be sent.
    pub unsent: Figure,
    /// Datagrams for which there was no room among those that wait, or that still did at the end; of them, those that pull the brake did.
    pub crammed: Figure,
    /// Datagrams that the system dropped before they could be received, where it tells (Linux).
    pub missed: Figure,
    /// Times that the system could not receive.
    pub failed: Figure,
    /// Of what came to nothing, how much has no line in a journal: too much of it came.
    pub unwritten: Figure,
}

impl Counts {
    /// What went wrong: by what name a journal has it, how often, and in words.
    pub fn named(&self) -> [(&'static str, u64, &'static str); 15] {
        [
            ("osc_refused", self.refused.get(), "refused for lack of room"),
            ("osc_malformed", self.malformed.get(), "malformed"),
            ("osc_deep", self.deep.get(), "nested too deeply"),
            ("osc_unknown", self.unknown.get(), "to nothing that is there"),
            ("osc_wrong", self.wrong.get(), "with arguments that do not fit"),
            ("osc_late", self.late.get(), "late"),
            ("osc_far", self.far.get(), "too far ahead"),
            ("osc_cancelled", self.cancelled.get(), "cancelled by a panic or the end"),
            ("osc_forgotten", self.forgotten.get(), "ids forgotten"),
            ("osc_crowded", self.crowded.get(), "subscriptions too many"),
            ("osc_unsent", self.unsent.get(), "answers not sent"),
            ("osc_crammed", self.crammed.get(), "datagrams for which there was no room"),
            ("osc_missed", self.missed.get(), "datagrams dropped by the system"),
            ("osc_failed", self.failed.get(), "failures to receive"),
            ("osc_unwritten", self.unwritten.get(), "of that with no line in a journal"),
        ]
    }

    /// What went wrong, in words; `None` if nothing did.
    pub fn trouble(&self) -> Option<String> {
        let named = self.named();
        // The last is for journals alone.
        in_words(&named[..named.len() - 1])
            .map(|told| format!("OSC, {} messages read: {told}", self.messages.get()))
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
