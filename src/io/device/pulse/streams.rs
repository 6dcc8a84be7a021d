//! Where the streams of this program are: somebody may lead them to another device with a mixer's window, and cpal does not hear of it.

use std::ffi::CString;

use pulseaudio::protocol::{Command, LookupReply, Prop, Props, SinkInputInfoList, SourceOutputInfoList};

use super::client::{Client, process};
use crate::io::device::watch::Direction;

/// Looks at the streams of one device.
#[derive(Debug, Default)]
pub(crate) struct Streams {
    client: Option<Client>,
    /// Those that were seen on the device.
    seen: Vec<u32>,
}

impl Streams {
    /// Whether one of this program's has left `device` for another. Not where nobody answers: that is known by other signs.
    pub fn left(&mut self, way: Direction, device: &str) -> bool {
        let Some((device, all)) = self.look(way, device) else {
            self.client = None;
            return false;
        };
        left(&mut self.seen, device, &all)
    }

    /// The number of the device, and of each stream the number and that of its device.
    fn look(&mut self, way: Direction, device: &str) -> Option<(u32, Vec<[u32; 2]>)> {
        let client = match &mut self.client {
            Some(client) => client,
            none => none.insert(Client::connect().ok()?),
        };
        let name = CString::new(device).ok()?;
        let lookup = match way {
            Direction::Out => Command::LookupSink(name),
            Direction::In => Command::LookupSource(name),
        };
        let LookupReply(device) = client.ask(&lookup).ok()?;
        let process = process();
        let own = |props: &Props| {
            let of = props.get(Prop::ApplicationProcessId);
            of.is_some_and(|of| of.strip_suffix(&[0]).unwrap_or(of) == process.as_bytes())
        };
        let all = match way {
            Direction::Out => {
                let all: SinkInputInfoList = client.ask(&Command::GetSinkInputInfoList).ok()?;
                all.iter().filter(|one| own(&one.props)).map(|one| [one.index, one.sink_index]).collect()
            }
            Direction::In => {
                let all: SourceOutputInfoList = client.ask(&Command::GetSourceOutputInfoList).ok()?;
                all.iter().filter(|one| own(&one.props)).map(|one| [one.index, one.source_index]).collect()
            }
        };
        Some((device, all))
    }
}

/// Whether one that was seen on a device is on another now, or all are on others; whatever is on it has been seen then.
fn left(seen: &mut Vec<u32>, device: u32, all: &[[u32; 2]]) -> bool {
    let (here, there): (Vec<[u32; 2]>, Vec<[u32; 2]>) = all.iter().partition(|[_, of]| *of == device);
    let left = there.iter().any(|[one, _]| seen.contains(one)) || (here.is_empty() && !there.is_empty());
    *seen = here.iter().map(|[one, _]| *one).collect();
    left
}

#[cfg(test)]
mod tests {
    use super::left;

    #[test]
    fn a_stream_has_left_that_was_here_and_is_there() {
        let (mut seen, here, there) = (Vec::new(), 3, 5);
        let mut looks = |all: &[[u32; 2]]| left(&mut seen, here, all);
        assert!(!looks(&[[7, here], [8, there]]), "another one of this program's plays elsewhere");
        assert!(!looks(&[[7, here], [8, there], [9, here]]));
        assert!(looks(&[[7, there], [8, there], [9, here]]));
        assert!(!looks(&[[7, there], [8, there], [9, here]]), "that was told");
        assert!(looks(&[[7, there], [8, there]]), "none is here any more");
        assert!(!looks(&[]), "there are none at all: whoever plays hears of that otherwise");
        // Moved before anybody looked.
        assert!(left(&mut Vec::new(), here, &[[7, there]]));
    }
}
