//! ALSA's names. A card has many: `hw` is the card itself, `plughw` converts for it, `default`, `front` and others share it, mix, or send channels elsewhere;
//! each with the card's name (`hw:CARD=Device,DEV=0`) or its number (`hw:1,0`), which is another when it is plugged in again.

use super::list::{Found, Offer};

/// One of them.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Pcm {
    /// `hw`, `plughw`, `front`.
    kind: String,
    /// The card's name.
    card: String,
    device: u32,
}

/// ALSA's plug-ins that convert or filter for others, by their first words.
const CONVERTERS: [&str; 9] =
    ["lavrate", "samplerate", "speexrate", "speex", "upmix", "vdownmix", "oss", "usbstream", "a52"];

/// Names for what converts or shares a card's device of the same number.
const CONVERTED: [&str; 7] = ["plughw", "front", "surround", "dmix", "dsnoop", "default", "sysdefault"];

/// Names for whatever card is the default.
const DEFAULTS: [&str; 2] = ["default", "sysdefault"];

/// The name of the card that has this number now.
fn card_of(number: u32) -> Option<String> {
    let id = std::fs::read_to_string(format!("/proc/asound/card{number}/id")).ok()?;
    Some(id.trim().to_string()).filter(|id| !id.is_empty())
}

impl Pcm {
    /// What a person or a system calls one, where it names a card; `cards` gives names for numbers.
    fn of(name: &str, cards: impl Fn(u32) -> Option<String>) -> Option<Self> {
        let name = name.strip_prefix("alsa:").unwrap_or(name);
        let (kind, rest) = name.split_once(':')?;
        let (mut card, mut device) = (None, 0);
        for (place, part) in rest.split(',').enumerate() {
            match (part.split_once('='), place) {
                (Some(("CARD", name)), _) => card = Some(name),
                (Some(("DEV", number)), _) => device = number.parse().ok()?,
                // A loop-back has several of each; the first is what everybody means.
                (Some(("SUBDEV", "0")), _) => {}
                (None, 0) => card = Some(part),
                (None, 1) => device = part.parse().ok()?,
                _ => return None,
            }
        }
        let card = card.filter(|card| !card.is_empty())?;
        let card = match card.parse::<u32>() {
            Ok(number) => cards(number)?,
            Err(_) => card.to_string(),
        };
        Some(Self { kind: kind.into(), card, device })
    }

    /// Whether it has the channels of the card's device of its number. Of `hdmi` and `iec958`, the device is a number of their own.
    fn is_converted(&self) -> bool {
        CONVERTED.contains(&self.kind.trim_end_matches(|c: char| c.is_ascii_digit()))
    }

    /// Whether both lead to one device of a card.
    fn shares(&self, other: &Self) -> bool {
        (&self.card, self.device) == (&other.card, other.device)
    }

    /// That of a device.
    fn of_device(found: &Found, cards: impl Fn(u32) -> Option<String>) -> Option<Self> {
        if found.host() == "alsa" { Self::of(&found.id, cards) } else { None }
    }
}

/// Whether a person who says `name` means the device of that id: `hw:1`, `hw:1,0` and `hw:Device` are ALSA's short forms.
pub(super) fn means(name: &str, id: &str) -> bool {
    id.starts_with("alsa:") && Pcm::of(name, card_of).is_some_and(|pcm| Pcm::of(id, card_of) == Some(pcm))
}

/// Whether it is a card, or something that is no card's at all: neither a further name for one nor a converter for others.
pub(super) fn is_itself(found: &Found) -> bool {
    let own = found.id.strip_prefix("alsa:").filter(|_| found.host() == "alsa");
    let converts = own.is_some_and(|own| CONVERTERS.contains(&own.split(':').next().unwrap_or_default()));
    !converts && Pcm::of_device(found, |number| Some(number.to_string())).is_none_or(|pcm| pcm.kind == "hw")
}

/// Leaves each device once, by the name of its card where it has one, and of what converts for a card no more channels than that has: those beyond them would
/// be left out without a word.
pub(super) fn tidy<D>(all: &mut Vec<(D, Found)>) {
    tidy_with(all, card_of, behind);
}

/// The card behind ALSA's default, where it is a card.
#[cfg(target_os = "linux")]
fn behind(name: &str) -> Option<Pcm> {
    let open = || alsa::PCM::new(name, alsa::Direction::Playback, true).ok();
    let info = super::hush::quietly(open)?.info().ok()?;
    let card = card_of(u32::try_from(info.get_card()).ok()?)?;
    Some(Pcm { kind: name.into(), card, device: info.get_device() })
}

#[cfg(not(target_os = "linux"))]
fn behind(_: &str) -> Option<Pcm> {
    None
}

fn tidy_with<D>(
    all: &mut Vec<(D, Found)>,
    cards: impl Fn(u32) -> Option<String> + Copy,
    behind: impl Fn(&str) -> Option<Pcm>,
) {
    let of = |found: &Found| Pcm::of_device(found, cards);
    let by_name: Vec<Pcm> =
        all.iter().filter(|(_, found)| !is_by_number(found)).filter_map(|(_, found)| of(found)).collect();
    all.retain(|(_, found)| {
        let is_twice = || of(found).is_some_and(|pcm| by_name.contains(&pcm));
        found.default || !is_by_number(found) || !is_twice()
    });
    let of_card = |found: &Found| {
        let pcm = of(found).filter(|pcm| pcm.kind == "hw")?;
        Some((pcm, most(&found.output), most(&found.input)))
    };
    let hardware: Vec<_> = all.iter().filter_map(|(_, found)| of_card(found)).collect();
    for (_, found) in all {
        let default = found.id.strip_prefix("alsa:").filter(|own| DEFAULTS.contains(own));
        let pcm = default.map_or_else(|| of(found), &behind).filter(Pcm::is_converted);
        let is_its = |card: &Pcm| pcm.as_ref().is_some_and(|pcm| pcm.shares(card));
        let Some((_, output, input)) = hardware.iter().find(|(card, ..)| is_its(card)) else { continue };
        limit(&mut found.output, *output);
        // Of a default, only what it plays on is known.
        if default.is_none() {
            limit(&mut found.input, *input);
        }
    }
}

/// Whether its card goes by its number.
fn is_by_number(found: &Found) -> bool {
    let card = found.id.split_once("CARD=").and_then(|(_, rest)| rest.split(',').next());
    card.is_some_and(|card| card.parse::<u32>().is_ok())
}

fn most(offer: &Option<Offer>) -> Option<u16> {
    offer.as_ref()?.channels.last().copied()
}

/// Leaves no more channels than there are, where that is known.
fn limit(offer: &mut Option<Offer>, most: Option<u16>) {
    if let (Some(offer), Some(most)) = (offer, most) {
        offer.channels.retain(|channels| *channels <= most);
    }
}

#[cfg(test)]
mod tests {
    use super::super::hosts::Hosts;
    use super::super::rates::Rates;
    use super::{Found, Offer, Pcm, is_itself, tidy_with};

    fn cards(number: u32) -> Option<String> {
        ["Device", "PCH"].get(number as usize).map(|name| (*name).to_string())
    }

    fn found(id: &str, most: u16) -> ((), Found) {
        let offer = Offer {
            channels: (1..=most).collect(),
            there: None,
            rates: Rates::default(),
            blocks: None,
            formats: vec![],
        };
        let output = (most > 0).then_some(offer);
        let input = output.clone();
        let (id, name, hosts) = (id.to_string(), "USB Sound".to_string(), Hosts::default());
        ((), Found { id, name, default: false, output, input, trouble: None, hosts })
    }

    #[test]
    fn short_forms_mean_the_same() {
        let whole = Pcm::of("alsa:hw:CARD=Device,DEV=0", cards);
        assert!(whole.is_some());
        for short in ["hw:0", "hw:0,0", "hw:Device", "hw:CARD=Device", "hw:CARD=0,DEV=0", "hw:Device,0"] {
            assert_eq!(Pcm::of(short, cards), whole, "{short}");
        }
        for other in ["hw:1", "hw:0,1", "plughw:0", "hw:CARD=PCH"] {
            assert!(Pcm::of(other, cards).is_some_and(|pcm| Some(pcm) != whole), "{other}");
        }
        for none in ["hw", "hw:", "hw:7", "hw:0,x", "default", "USB: a card, with a comma", "hw:CARD=,DEV=0"]
        {
            assert_eq!(Pcm::of(none, cards).filter(|pcm| pcm.kind == "hw"), None, "{none}");
        }
    }

    #[test]
    fn a_card_is_there_once_and_what_converts_for_it_has_its_channels() {
        let mut all = vec![
            found("alsa:hw:CARD=Device,DEV=0", 8),
            found("alsa:plughw:CARD=Device,DEV=0", 64),
            found("alsa:surround71:CARD=Device,DEV=0", 64),
            found("alsa:hw:CARD=PCH,DEV=0", 2),
            found("alsa:hdmi:CARD=PCH,DEV=0", 8),
            found("alsa:hw:CARD=PCH,DEV=3", 6),
            found("alsa:plughw:CARD=PCH,DEV=3", 64),
            // Somebody else has it, so that nobody knows.
            found("alsa:hw:CARD=Busy,DEV=0", 0),
            found("alsa:plughw:CARD=Busy,DEV=0", 64),
            found("alsa:default", 64),
            found("alsa:sysdefault", 64),
            found("alsa:pulse", 32),
            found("alsa:hw:CARD=0,DEV=0", 8),
            found("alsa:plughw:CARD=0,DEV=0", 64),
            found("alsa:hw:CARD=1,DEV=7", 4),
            found("alsa:hw:CARD=9,DEV=0", 4),
        ];
        let behind = |name: &str| Pcm::of(&format!("{name}:1"), cards).filter(|_| name == "default");
        tidy_with(&mut all, cards, behind);
        let left: Vec<(&str, usize)> = all
            .iter()
            .map(|(_, f)| {
                (f.id.trim_start_matches("alsa:"), f.output.as_ref().map_or(0, |o| o.channels.len()))
            })
            .collect();
        assert_eq!(
            left,
            [
                ("hw:CARD=Device,DEV=0", 8),
                ("plughw:CARD=Device,DEV=0", 8),
                ("surround71:CARD=Device,DEV=0", 8),
                ("hw:CARD=PCH,DEV=0", 2),
                ("hdmi:CARD=PCH,DEV=0", 8),
                ("hw:CARD=PCH,DEV=3", 6),
                ("plughw:CARD=PCH,DEV=3", 6),
                ("hw:CARD=Busy,DEV=0", 0),
                ("plughw:CARD=Busy,DEV=0", 64),
                ("default", 2),
                ("sysdefault", 64),
                ("pulse", 32),
                ("hw:CARD=1,DEV=7", 4),
                ("hw:CARD=9,DEV=0", 4),
            ]
        );
        let heard = |id: &str| {
            let device = all.iter().find(|(_, found)| found.id == id);
            device.and_then(|(_, found)| found.input.as_ref()).map(|offer| offer.channels.len())
        };
        assert_eq!(heard("alsa:plughw:CARD=Device,DEV=0"), Some(8));
        assert_eq!(heard("alsa:default"), Some(64), "it may be heard through another card");
        let itself: Vec<bool> = all.iter().map(|(_, found)| is_itself(found)).collect();
        let hidden = |at: usize| !itself[at];
        assert!((0..left.len()).all(|at| hidden(at) == [1, 2, 4, 6, 8].contains(&at)), "{itself:?}");
        assert!(!is_itself(&found("alsa:samplerate", 64).1) && is_itself(&found("alsa:vcard24", 24).1));
        assert!(is_itself(&found("jack:output", 24).1));
    }
}
