//! A port that may be listened to.

/// One of those that there are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Source {
    /// What the system knows it by, as long as it is there.
    pub id: String,
    /// What a person reads.
    pub name: String,
    /// What stays of its name when it is plugged in again.
    pub kind: String,
}
