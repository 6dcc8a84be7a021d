//! Where PulseAudio leads channels. It goes by the names of loudspeakers: what a stream calls `front-center` leaves where the sink's own map has that,
//! whichever number it has there; what the sink has no name for is mixed into others, or into nothing.

use std::ffi::CString;

use pulseaudio::protocol::ChannelPosition::{self, *};
use pulseaudio::protocol::{Command, GetSinkInfo, SinkInfo};

use super::client::Client;
use crate::io::device::kept::PATIENCE;
use crate::io::device::minder::within;

/// What is to be known before `channels` of them go to a sink; `None` where each arrives on its own number, and where the sink does not say.
pub(in super::super) fn told(sink: &str, channels: usize) -> Option<String> {
    let name = CString::new(sink).ok()?;
    let own = within("asks", PATIENCE, move || {
        let asked = Command::GetSinkInfo(GetSinkInfo { index: None, name: Some(name) });
        let info: SinkInfo = Client::connect().ok()?.ask(&asked).ok()?;
        Some(info.channel_map.into_iter().map(|name| name as u8).collect::<Vec<u8>>())
    })??;
    led(sink, &stream(channels)?, &own)
}

/// The names that cpal gives to the channels of a stream: PulseAudio's default map, and for what has none numbers (`aux0` and so on). `None`: one
/// channel, which goes to all.
fn stream(channels: usize) -> Option<Vec<u8>> {
    let all = [
        FrontLeft,
        FrontRight,
        FrontCenter,
        Lfe,
        RearLeft,
        RearRight,
        SideLeft,
        SideRight,
        TopFrontLeft,
        TopFrontRight,
        TopRearLeft,
        TopRearRight,
    ];
    let named = match channels {
        0 | 1 => return None,
        4 => vec![FrontLeft, FrontRight, RearLeft, RearRight],
        5 => vec![FrontLeft, FrontRight, FrontCenter, RearLeft, RearRight],
        7 => vec![FrontLeft, FrontRight, FrontCenter, Lfe, RearLeft, RearRight, RearCenter],
        2 | 3 | 6 | 8 | 10 | 12 => all.iter().copied().take(channels).collect(),
        _ => return (0..channels).map(|n| (Aux0 as u8).checked_add(u8::try_from(n).ok()?)).collect(),
    };
    Some(named.into_iter().map(|name: ChannelPosition| name as u8).collect())
}

/// Where channels of these names leave on a sink of those.
fn led(sink: &str, stream: &[u8], own: &[u8]) -> Option<String> {
    let place = |name: &u8| own.iter().position(|own| own == name);
    let places: Vec<Option<usize>> = stream.iter().map(place).collect();
    let list =
        |numbers: Vec<usize>| numbers.iter().map(|n| (n + 1).to_string()).collect::<Vec<_>>().join(", ");
    let lost: Vec<usize> = (0..places.len()).filter(|&n| places[n].is_none()).collect();
    let (moved, to): (Vec<usize>, Vec<usize>) = (0..)
        .zip(&places)
        .filter_map(|(n, place)| Some((n, (*place)?)))
        .filter(|(n, place)| n != place)
        .unzip();
    let beside = "a card by its own name (hw:...), JACK and PipeWire lead each to its own";
    if !lost.is_empty() {
        return Some(format!(
            "PulseAudio goes by the names of loudspeakers, and {sink} has none for channels {}: they are mixed into others, or into nothing; {beside}",
            list(lost)
        ));
    }
    (!moved.is_empty()).then(|| {
        format!(
            "PulseAudio goes by the names of loudspeakers, not by numbers: channels {} leave on {} of {sink} (`pacinian walk` writes that into \
             the rig); {beside}",
            list(moved),
            list(to)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{ChannelPosition::*, led, stream};

    #[test]
    fn channels_go_where_their_names_are() {
        let six = stream(6).unwrap();
        assert_eq!(led("s", &six, &six), None);
        // As ALSA numbers the jacks of a card.
        let alsa = [FrontLeft, FrontRight, RearLeft, RearRight, FrontCenter, Lfe].map(|name| name as u8);
        let told = led("s", &six, &alsa).unwrap();
        assert!(told.contains("channels 3, 4, 5, 6 leave on 5, 6, 3, 4 of s"), "{told}");
        let told =
            led("s", &stream(4).unwrap(), &[Aux0, Aux1, Aux2, FrontLeft].map(|name| name as u8)).unwrap();
        assert!(told.contains("none for channels 2, 3, 4:"), "{told}");
        assert_eq!(led("s", &stream(3).unwrap(), &six), None, "fewer than it has");
    }

    #[test]
    fn each_channel_has_a_name_of_its_own() {
        assert_eq!((stream(0), stream(1)), (None, None));
        for count in 2..=32 {
            let names = stream(count).unwrap();
            let twice = (1..names.len()).any(|n| names[..n].contains(&names[n]));
            assert!(names.len() == count && !twice, "{names:?}");
        }
        assert_eq!(stream(9).unwrap()[..2], [Aux0 as u8, Aux1 as u8]);
    }
}
