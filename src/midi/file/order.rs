//! The order of messages that come at one time.

use crate::midi::channel::Channel;
use crate::midi::message::Message;

/// Sorts by ticks. At one tick the order stays, except that a note-off which ends a note from an earlier tick goes before the first
/// note-on: where a note follows itself it is then ended before it is struck, and voices are free before others want them. A note-off
/// that ends a note of its own tick stays behind it, or that note would never end.
pub(super) fn sort(messages: &mut [(u64, Message)]) {
    messages.sort_by_key(|(tick, _)| *tick);
    let mut open = vec![0_u32; Channel::COUNT * 128];
    for group in messages.chunk_by_mut(|a, b| a.0 == b.0) {
        let begins = |(_, message): &(u64, Message)| matches!(edge(*message), Some((true, _)));
        let first = group.iter().position(begins).unwrap_or(group.len());
        let (before, behind) = group.split_at_mut(first);
        before.iter().filter_map(|(_, m)| edge(*m)).for_each(|(_, slot)| {
            close(&mut open, slot);
        });
        let ends = |(_, message): &(u64, Message)| match edge(*message) {
            Some((false, slot)) => close(&mut open, slot),
            _ => false,
        };
        let (ahead, after): (Vec<_>, Vec<_>) = behind.iter().copied().partition(ends);
        for (place, event) in behind.iter_mut().zip(ahead.into_iter().chain(after.iter().copied())) {
            *place = event;
        }
        for (_, message) in after {
            match edge(message) {
                Some((true, slot)) => open.get_mut(slot).into_iter().for_each(|n| *n += 1),
                Some((false, slot)) => {
                    close(&mut open, slot);
                }
                None => (),
            }
        }
    }
}

/// One less of a note; whether there was one.
fn close(open: &mut [u32], slot: usize) -> bool {
    let there = open.get_mut(slot).filter(|n| **n > 0);
    there.map(|n| *n -= 1).is_some()
}

/// Whether a note begins (or ends), and its number among all notes of all channels.
fn edge(message: Message) -> Option<(bool, usize)> {
    let (begins, channel, note) = match message {
        Message::NoteOn { channel, note, velocity } => (velocity > 0, channel, note),
        Message::NoteOff { channel, note, .. } => (false, channel, note),
        _ => return None,
    };
    Some((begins, channel.index() * 128 + usize::from(note & 127)))
}

#[cfg(test)]
mod tests {
    use super::sort;
    use crate::midi::Message;

    fn sorted(messages: &[(u64, &[u8])]) -> Vec<Vec<u8>> {
        let mut messages: Vec<_> = messages.iter().map(|(t, b)| (*t, Message::parse(b).unwrap())).collect();
        sort(&mut messages);
        messages.iter().map(|(_, m)| m.bytes().to_vec()).collect()
    }

    const ON: &[u8] = &[0x90, 60, 1];
    const OFF: &[u8] = &[0x80, 60, 0];
    const ZERO: &[u8] = &[0x90, 60, 0];
    const OTHER: &[u8] = &[0x90, 61, 1];
    const PEDAL: &[u8] = &[0xB0, 64, 127];

    #[test]
    fn a_note_that_follows_itself_ends_first() {
        assert_eq!(sorted(&[(0, ON), (9, ON), (9, OFF)]), [ON, OFF, ON]);
        assert_eq!(sorted(&[(0, ON), (9, OTHER), (9, ON), (9, ZERO)]), [ON, ZERO, OTHER, ON]);
        assert_eq!(sorted(&[(9, ON), (9, OFF), (0, ON)]), [ON, OFF, ON], "whatever track it stands in");
        assert_eq!(sorted(&[(0, ON), (9, PEDAL), (9, OFF)]), [ON, PEDAL, OFF], "nothing to go before");
        assert_eq!(sorted(&[(0, ON), (9, PEDAL), (9, ON), (9, OFF)]), [ON, PEDAL, OFF, ON]);
    }

    #[test]
    fn a_note_without_length_still_ends() {
        assert_eq!(sorted(&[(0, ON), (0, OFF)]), [ON, OFF]);
        assert_eq!(sorted(&[(0, ON), (9, ON), (9, OFF), (9, OFF)]), [ON, OFF, ON, OFF]);
        assert_eq!(sorted(&[(0, ON), (9, OFF), (9, ON), (9, OFF)]), [ON, OFF, ON, OFF]);
        assert_eq!(sorted(&[(0, ON), (9, OFF), (9, OFF), (9, OTHER), (9, OFF)]), [ON, OFF, OFF, OTHER, OFF]);
    }

    #[test]
    fn no_order_leaves_a_note_open_that_had_its_end() {
        // All sequences of six events at two ticks.
        for code in 0..4_u32.pow(6) {
            let mut messages: Vec<(u64, Message)> = Vec::new();
            for i in 0..6 {
                let (tick, on) = (u64::from(code >> (2 * i) & 1), code >> (2 * i + 1) & 1 == 1);
                messages.push((tick, Message::parse(if on { ON } else { OFF }).unwrap()));
            }
            let left = |messages: &[(u64, Message)]| {
                messages.iter().fold(0_u32, |open, (_, m)| match m {
                    Message::NoteOn { .. } => open + 1,
                    _ => open.saturating_sub(1),
                })
            };
            let mut plain = messages.clone();
            plain.sort_by_key(|(tick, _)| *tick);
            let before = left(&plain);
            sort(&mut messages);
            assert!(left(&messages) <= before, "{messages:?}");
            let count = |m: &[(u64, Message)]| m.iter().filter(|(_, m)| m.bytes()[0] == 0x90).count();
            assert_eq!((count(&messages), messages.len()), (count(&plain), 6));
        }
    }
}
