//! Time tags: seconds since 1900 in 32.32 bits, as in NTP. The tag 1 means at once.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::live::stamp::Stamp;

/// A time tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tag(pub u64);

/// Seconds from 1900 to 1970 (RFC 5905).
const UNIX: u64 = 2_208_988_800;

/// The furthest ahead that something may be asked for, in seconds.
pub const FURTHEST: u64 = 60;

/// When something is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// At once, as was asked for.
    AtOnce,
    /// So many nanoseconds ago.
    Late(u64),
    /// Then.
    At(Stamp),
    /// More than [`FURTHEST`] ahead.
    Far,
}

impl Tag {
    /// At once.
    pub const AT_ONCE: Self = Self(1);

    /// Of a time of the system.
    pub fn of(time: SystemTime) -> Self {
        let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
        // The seconds begin anew in 2036.
        let seconds = since.as_secs().wrapping_add(UNIX) << 32;
        Self(seconds | ((u64::from(since.subsec_nanos()) << 32) / 1_000_000_000))
    }

    /// Whether it means at once. Of 0, which is not defined, many senders mean that too.
    pub fn is_at_once(self) -> bool {
        self.0 <= 1
    }

    /// By how much it comes after `other`, in parts of 2^-32 s; both are taken to lie within 68 years, whatever the era.
    fn after(self, other: Self) -> i64 {
        self.0.wrapping_sub(other.0) as i64
    }

    /// The tag of what lies in a bundle of this tag and has a tag of its own: it cannot be due before its bundle.
    pub fn of_inner(self, inner: Self) -> Self {
        match (self.is_at_once(), inner.is_at_once()) {
            (_, true) => self,
            (true, false) => inner,
            (false, false) if inner.after(self) > 0 => inner,
            (false, false) => self,
        }
    }

    /// When it is due in the session's time, if it is `now` there and `wall` by the clock that senders go by.
    pub fn due(self, now: Stamp, wall: Self) -> Due {
        if self.is_at_once() {
            return Due::AtOnce;
        }
        let ahead = self.after(wall);
        let nanoseconds = (u128::from(ahead.unsigned_abs()) * 1_000_000_000) >> 32;
        match u64::try_from(nanoseconds) {
            ago if ahead < 0 => Due::Late(ago.unwrap_or(u64::MAX)),
            Ok(ns) if ns <= FURTHEST * 1_000_000_000 => Due::At(Stamp(now.0.saturating_add(ns))),
            _ => Due::Far,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Due, Tag};
    use crate::live::stamp::Stamp;
    use std::time::{Duration, UNIX_EPOCH};

    #[test]
    fn tags_of_known_times() {
        assert_eq!(Tag::of(UNIX_EPOCH), Tag(2_208_988_800 << 32));
        assert_eq!(Tag::of(UNIX_EPOCH + Duration::from_millis(250)), Tag((2_208_988_800 << 32) | 1 << 30));
        // 7 February 2036, 06:28:16 UTC: the seconds begin anew (RFC 5905, figure 4).
        assert_eq!(Tag::of(UNIX_EPOCH + Duration::from_secs(2_085_978_496)), Tag(0));
    }

    #[test]
    fn due_now_then_and_never() {
        let now = Stamp(5_000_000_000);
        // The second time six seconds before the tags begin anew.
        for start in [1_700_000_000, 2_085_978_470_u64] {
            let at = |ms: u64| Tag::of(UNIX_EPOCH + Duration::from_millis(start * 1000 + ms));
            let due = |tag: Tag| tag.due(now, at(20_000));
            let Due::Late(ago) = due(at(19_993)) else { panic!() };
            assert!(ago.abs_diff(7_000_000) <= 1, "{ago}");
            assert_eq!(due(Tag::AT_ONCE), Due::AtOnce);
            assert_eq!(due(at(80_002)), Due::Far);
            for ms in [0, 1, 250, 59_999] {
                let Due::At(stamp) = due(at(20_000 + ms)) else { panic!("{ms}") };
                assert!(stamp.0.abs_diff(now.0 + ms * 1_000_000) <= 1, "{ms} {stamp:?}");
            }
        }
        assert_eq!(
            Tag(u64::MAX).due(Stamp(u64::MAX - 5), Tag(u64::MAX - (1 << 32))),
            Due::At(Stamp(u64::MAX))
        );
    }

    #[test]
    fn nothing_is_due_before_the_bundle_it_lies_in() {
        let (early, late) = (Tag(100 << 32), Tag(200 << 32));
        assert_eq!(late.of_inner(early), late);
        assert_eq!(early.of_inner(late), late);
        assert_eq!(late.of_inner(Tag::AT_ONCE), late);
        assert_eq!(Tag::AT_ONCE.of_inner(early), early);
        assert!(Tag::AT_ONCE.of_inner(Tag(0)).is_at_once());
    }
}
