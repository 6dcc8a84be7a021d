//! Which devices there are, and what they offer.

use cpal::traits::DeviceTrait;
use cpal::{Device, SupportedBufferSize, SupportedStreamConfigRange};

use super::card::KNOWN;
use super::failure::{DeviceError, Trouble};
use super::hosts::{Hosts, PULSE};
use super::pcm;
use super::rates::Rates;
use super::servers::Server;
use crate::text::nearest::nearest;

/// A device that there is.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Names it for good, with its host: `alsa:hw:CARD=Device,DEV=0`.
    pub id: String,
    /// For people.
    pub name: String,
    /// Whether it is the one that the system plays on where nobody says anything.
    pub default: bool,
    /// What it offers to be played on.
    pub output: Option<Offer>,
    /// What it offers to be heard.
    pub input: Option<Offer>,
    /// Why it does not say what it offers: somebody else has it, the system does not let us, or it cannot be opened at all.
    pub trouble: Option<DeviceError>,
    /// Where it was found, and is looked for when it was away.
    pub hosts: Hosts,
}

/// What a device offers in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// Numbers of channels, ascending.
    pub channels: Vec<u16>,
    /// How many there are, of a device that takes fewer as well, where that is known.
    pub there: Option<u16>,
    /// Frames a second.
    pub rates: Rates,
    /// Frames a block, least and most, where it says.
    pub blocks: Option<(u32, u32)>,
    /// Names of sample formats.
    pub formats: Vec<String>,
}

impl Found {
    /// What its host is called.
    pub fn host(&self) -> &str {
        self.id.split_once(':').map_or("", |(host, _)| host)
    }

    /// What PulseAudio calls it, where it is that which has it.
    pub(super) fn pulse(&self) -> Option<&str> {
        pulse(&self.id)
    }

    /// Whether nobody has named it: it is what the system plays on by default, which may be another by the time it is there again. JACK has one device, its
    /// server.
    pub fn may_be_another(&self) -> bool {
        self.default && self.host() != "jack"
    }

    /// Whether it is told of where devices are listed. What can neither be played on nor heard, and is neither in use nor kept from us, is of
    /// no use: ALSA lists its converters too.
    pub(super) fn is_of_use(&self) -> bool {
        let kept = |trouble: &DeviceError| matches!(trouble.kind, Trouble::Busy | Trouble::Forbidden);
        self.output.is_some() || self.input.is_some() || self.trouble.as_ref().is_some_and(kept)
    }

    /// Whether it is a device, and neither a further name of ALSA's for one (`plughw`, `default`, `front` with its card) nor a converter for others.
    pub fn is_itself(&self) -> bool {
        pcm::is_itself(self)
    }

    /// Whether it is as good as another for whoever says its name: the same card in another host, or ALSA's other ways to it
    /// (`hw:CARD=X,DEV=0`, `plughw:CARD=X,DEV=0`). A second card of the same make is not.
    fn may_stand_for(&self, other: &Self) -> bool {
        let card = |found: &Self| {
            let (_, rest) = found.id.split_once("CARD=")?;
            rest.split(',').next().map(str::to_string)
        };
        let same_card = card(self).is_some() && card(self) == card(other);
        self.name == other.name && (self.host() != other.host() || same_card)
    }
}

impl Offer {
    fn of(ranges: Vec<SupportedStreamConfigRange>) -> Option<Self> {
        let mut offer: Option<Self> = None;
        for range in &ranges {
            let (channels, format) = (range.channels(), range.sample_format().to_string());
            let none = || Self {
                channels: vec![],
                there: None,
                rates: Rates::default(),
                blocks: None,
                formats: vec![],
            };
            let all = offer.get_or_insert_with(none);
            all.rates.add((range.min_sample_rate(), range.max_sample_rate()));
            if let Err(place) = all.channels.binary_search(&channels) {
                all.channels.insert(place, channels);
            }
            if !all.formats.contains(&format) {
                all.formats.push(format);
            }
        }
        // How long a block may be depends on the format: what counts is that which would be taken.
        let taken = KNOWN.iter().find(|format| ranges.iter().any(|range| range.sample_format() == **format));
        for range in ranges.iter().filter(|range| taken.is_none_or(|taken| range.sample_format() == *taken)) {
            if let (Some(all), SupportedBufferSize::Range { min, max }) = (&mut offer, range.buffer_size()) {
                all.blocks = Some(all.blocks.map_or((*min, *max), |all| (all.0.min(*min), all.1.max(*max))));
            }
        }
        offer
    }
}

/// What a device is called for good.
pub(super) fn id(device: &Device) -> String {
    device.id().map_or_else(|_| device.to_string(), |id| id.to_string())
}

/// What PulseAudio calls a device of that id, where it is that which has it.
pub(super) fn pulse(id: &str) -> Option<&str> {
    id.split_once(':').filter(|(host, _)| *host == PULSE).map(|(_, name)| name)
}

/// Whether a device only swallows what it is given, as fast as it comes: on it no session would keep time.
pub(super) fn is_none(id: &str) -> bool {
    id == "alsa:null"
}

/// What a device offers to be played on.
pub(super) fn outputs(device: &Device) -> Result<Vec<SupportedStreamConfigRange>, cpal::Error> {
    let ranges = device.supported_output_configs()?.collect();
    Ok(as_it_is(device, |own| own.default_output_config(), ranges))
}

/// What it offers to be heard.
pub(super) fn inputs(device: &Device) -> Result<Vec<SupportedStreamConfigRange>, cpal::Error> {
    let ranges = device.supported_input_configs()?.collect();
    Ok(as_it_is(device, |own| own.default_input_config(), ranges))
}

/// Of a default of PipeWire's, of which cpal does not know what it is now, with the channels that it has.
fn as_it_is(
    device: &Device,
    usual: impl Fn(&Device) -> Result<cpal::SupportedStreamConfig, cpal::Error>,
    ranges: Vec<SupportedStreamConfigRange>,
) -> Vec<SupportedStreamConfigRange> {
    if ranges.is_empty() {
        return ranges;
    }
    let own = own(device);
    let Some(channels) = own.and_then(|own| Some(usual(&own).ok()?.channels())) else { return ranges };
    let with = |range: SupportedStreamConfigRange| {
        let (least, most) = (range.min_sample_rate(), range.max_sample_rate());
        SupportedStreamConfigRange::new(channels, least, most, *range.buffer_size(), range.sample_format())
    };
    ranges.into_iter().map(with).collect()
}

/// The device that a default of PipeWire's is now.
fn own(device: &Device) -> Option<Device> {
    #[cfg(all(feature = "pipewire", target_os = "linux"))]
    {
        super::pipewire_default::device(&id(device))
    }
    #[cfg(not(all(feature = "pipewire", target_os = "linux")))]
    {
        let _ = device;
        None
    }
}

/// Looks at a device of `hosts`; `default` is the id of theirs that is played on where nobody says anything.
pub(super) fn look(device: Device, default: Option<&str>, hosts: &Hosts) -> (Device, Found) {
    let id = id(&device);
    let name = match id.as_str() {
        // It has the name that this program's ports would have.
        "jack:output" => "JACK, outputs".into(),
        "jack:input" => "JACK, inputs".into(),
        _ => device.to_string(),
    };
    let (mut trouble, mut other) = (None, None);
    let mut refused = |error: cpal::Error| {
        let mut error = DeviceError::of(&name, &error);
        // What ALSA hands to a server that is not there.
        if let Some(server) = id.strip_prefix("alsa:").and_then(Server::named).filter(|server| !server.runs) {
            error = error.help(format!("{} does not run; start it: {}", server.name, server.start));
        }
        match error.kind {
            Trouble::Busy | Trouble::Forbidden => _ = trouble.get_or_insert(error),
            Trouble::Unfit | Trouble::System | Trouble::Other => _ = other.get_or_insert(error),
            Trouble::Missing => {}
        }
    };
    let mut output = outputs(&device).map_err(&mut refused).ok().and_then(Offer::of);
    let mut input = inputs(&device).map_err(&mut refused).ok().and_then(Offer::of);
    // PulseAudio takes any number of channels, and mixes those that are not the device's own into others, or into nothing.
    if pulse(&id).is_some() {
        let own =
            |config: Result<cpal::SupportedStreamConfig, _>| config.ok().map(|config| config.channels());
        limit(&mut output, own(device.default_output_config()));
        limit(&mut input, own(device.default_input_config()));
    }
    // Its two devices are one each way, though cpal offers both ways of either.
    match id.as_str() {
        "jack:output" => input = None,
        "jack:input" => output = None,
        _ => {}
    }
    #[cfg(all(feature = "jack", target_os = "linux"))]
    match id.as_str() {
        "jack:output" => super::jack_ports::limit(&mut output, "system:playback_.*"),
        "jack:input" => super::jack_ports::limit(&mut input, "system:capture_.*"),
        _ => {}
    }
    // One that plays and does not hear says so, which is no trouble.
    let trouble = trouble.or(other.filter(|_| output.is_none() && input.is_none()));
    let default = default == Some(id.as_str());
    let found = Found { id, name, default, output, input, trouble, hosts: hosts.clone() };
    (device, found)
}

/// A device that cannot be looked at now.
pub(super) fn unseen(device: Device, why: DeviceError, hosts: &Hosts) -> (Device, Found) {
    let (id, name) = (id(&device), device.to_string());
    let found = Found {
        id,
        name,
        default: false,
        output: None,
        input: None,
        trouble: Some(why),
        hosts: hosts.clone(),
    };
    (device, found)
}

/// Leaves so many channels of what is offered, where it is known how many.
fn limit(offer: &mut Option<Offer>, channels: Option<u16>) {
    if let (Some(offer), Some(channels)) = (offer, channels) {
        offer.channels = vec![channels];
    }
}

/// The device that a person means by `name`: its id, its name, or a part of its name that no other has. Where several hosts have
/// it, that of the first is meant, unless a host stands in front: `pipewire:NAME`; a host alone means its default. Only those for which
/// `fits` says yes are looked at.
///
/// # Errors
/// None of that name, or several.
pub fn find<'a, D>(
    all: &'a [(D, Found)],
    name: &str,
    fits: impl Fn(&Found) -> bool,
) -> Result<&'a (D, Found), DeviceError> {
    let fitting: Vec<&(D, Found)> = all.iter().filter(|(_, found)| fits(found)).collect();
    let by_id = |id: &str| {
        let own = |found: &Found| found.id.split_once(':').is_some_and(|(_, own)| own == id);
        let exact = fitting.iter().find(|(_, f)| f.id == id || own(f));
        exact.or_else(|| fitting.iter().find(|(_, f)| pcm::means(id, &f.id)))
    };
    // A host goes before a device that is called like one: ALSA's plug-in for JACK is `jack`, too.
    if let Some(found) = by_id(name).filter(|_| fitting.iter().all(|(_, f)| f.host() != name)) {
        return Ok(found);
    }
    let (host, rest) = name.split_once(':').unwrap_or((name, ""));
    let of_host: Vec<_> =
        fitting.iter().copied().filter(|(_, f)| f.host().eq_ignore_ascii_case(host)).collect();
    let several = match rest {
        _ if of_host.is_empty() => called(&fitting, name)?,
        "" => {
            let default = of_host.iter().find(|(_, found)| found.default);
            return Ok(default.unwrap_or(&of_host[0]));
        }
        rest => called(&of_host, rest)?,
    };
    several.ok_or_else(|| {
        let what = match is_none(name) {
            true => format!("`{name}` takes all at once, so that nothing keeps time on it (`virtual` does)"),
            false => format!("there is no device `{name}`"),
        };
        let near = nearest(name, fitting.iter().map(|(_, found)| found.name.as_str()));
        // Where several systems have one of a name, the system in front tells them apart.
        let elsewhere =
            |found: &Found, other: &Found| other.name == found.name && other.host() != found.host();
        let shown = |found: &Found| match fitting.iter().any(|(_, other)| elsewhere(found, other)) {
            true => format!("{}:{}", found.host(), found.name),
            false => found.name.clone(),
        };
        let mut names: Vec<String> = Vec::new();
        for name in fitting.iter().filter(|(_, found)| found.is_itself()).map(|(_, found)| shown(found)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let there = match names.as_slice() {
            [] => "no other is there either".to_string(),
            names => format!("there is: {}", names.join(", ")),
        };
        let help = near.map_or(there, |near| format!("did you mean `{near}`?"));
        DeviceError::new(Trouble::Missing, what).help(format!("{help}; `pacinian devices` lists all"))
    })
}

/// Whether words in it begin so: `card` is in `USB Card`, not in `Discard`.
fn holds(text: &str, lower: &str) -> bool {
    let text = text.to_lowercase();
    let begins = |at: usize| !text[..at].ends_with(char::is_alphanumeric);
    text.match_indices(lower).any(|(at, _)| begins(at))
}

/// The one of that name, or else the one with that in its name or id, if there is one.
fn called<'a, D>(all: &[&'a (D, Found)], name: &str) -> Result<Option<&'a (D, Found)>, DeviceError> {
    let lower = name.to_lowercase();
    let part = |found: &Found| holds(&found.name, &lower) || holds(&found.id, &lower);
    let exact = all.iter().any(|(_, found)| found.name == name);
    let mut meant = all.iter().filter(|(_, found)| if exact { found.name == name } else { part(found) });
    let Some(first) = meant.next() else { return Ok(None) };
    match meant.find(|(_, found)| !found.may_stand_for(&first.1)) {
        None => Ok(Some(first)),
        Some((_, other)) => {
            let what = format!("`{name}` may be {} or {}", first.1.id, other.id);
            let help = if other.name == first.1.name { "name it by its id" } else { "give more of its name" };
            Err(DeviceError::new(Trouble::Missing, what).help(help))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Found, Hosts, find};

    #[test]
    fn blocks_are_those_of_the_format_that_is_taken() {
        use super::Offer;
        use cpal::{SampleFormat, SupportedBufferSize, SupportedStreamConfigRange};
        let range = |channels, format, most| {
            let blocks = match most {
                0 => SupportedBufferSize::Unknown,
                most => SupportedBufferSize::Range { min: 8, max: most },
            };
            SupportedStreamConfigRange::new(channels, 8_000, 96_000, blocks, format)
        };
        let blocks =
            |ranges: &[SupportedStreamConfigRange]| Offer::of(ranges.to_vec()).and_then(|o| o.blocks);
        let card = [
            range(1, SampleFormat::I16, 8192),
            range(2, SampleFormat::I16, 4096),
            range(1, SampleFormat::F32, 4096),
            range(2, SampleFormat::F32, 2048),
        ];
        assert_eq!(blocks(&card), Some((8, 4096)));
        assert_eq!(blocks(&card[..2]), Some((8, 8192)));
        // Of a format that is none of ours, nothing else is known.
        assert_eq!(blocks(&[range(1, SampleFormat::U8, 100)]), Some((8, 100)));
        assert_eq!(blocks(&[range(1, SampleFormat::F32, 0), range(1, SampleFormat::I16, 100)]), None);
        let offer = Offer::of(card.to_vec()).unwrap();
        assert_eq!((offer.channels, offer.formats), (vec![1, 2], vec!["i16".to_string(), "f32".into()]));
        // And of those channels, where it is opened.
        let shape = |channels, block| crate::io::device::card::Shape {
            channels,
            rate: 48_000,
            block: Some(block),
            exact: true,
        };
        let known =
            |channels| crate::io::device::card::known_format(card.into_iter(), shape(channels, 64)).unwrap();
        assert_eq!(known(2), (SampleFormat::F32, Some((8, 2048))));
        assert_eq!(known(1), (SampleFormat::F32, Some((8, 4096))));
    }

    fn found(id: &str, name: &str) -> ((), Found) {
        let hosts = Hosts::default();
        let (id, name) = (id.into(), name.into());
        ((), Found { id, name, default: false, output: None, input: None, trouble: None, hosts })
    }

    #[test]
    fn a_device_is_found_by_what_people_call_it() {
        let all = [
            found("alsa:hw:CARD=Device,DEV=0", "USB Sound Device, USB Audio"),
            found("alsa:hw:CARD=PCH,DEV=0", "HDA Intel PCH"),
            found("alsa:pipewire", "PipeWire Sound Server"),
        ];
        let id = |name: &str| find(&all, name, |_| true).map(|(_, found)| found.id.clone());
        assert_eq!(id("alsa:pipewire").unwrap(), "alsa:pipewire");
        assert_eq!(id("hw:CARD=PCH,DEV=0").unwrap(), "alsa:hw:CARD=PCH,DEV=0");
        assert_eq!(id("usb").unwrap(), "alsa:hw:CARD=Device,DEV=0");
        assert_eq!(id("HDA Intel PCH").unwrap(), "alsa:hw:CARD=PCH,DEV=0");
        let both = id("sound").unwrap_err();
        assert!(both.what.contains("CARD=Device") && both.what.contains("alsa:pipewire"), "{both}");
        let twice = [
            found("pipewire:glove", "Glove"),
            found("pulseaudio:glove", "Glove"),
            found("jack:output", "JACK"),
        ];
        let none = find(&twice, "chair", |_| true).unwrap_err().to_string();
        assert!(none.contains("pipewire:Glove, pulseaudio:Glove, JACK;"), "{none}");
        let none = id("HDA Intel PHC").unwrap_err();
        assert!(none.to_string().contains("did you mean `HDA Intel PCH`?"), "{none}");
        assert_eq!(none.kind.exit_code(), 69);
        let empty: [((), Found); 0] = [];
        assert!(find(&empty, "x", |_| true).unwrap_err().to_string().contains("no other is there"));
    }
    #[test]
    fn a_name_in_two_hosts_is_the_first_ones_and_two_cards_of_one_name_are_two() {
        let mut all = [
            found("pipewire:usb-1", "Belt"),
            found("pipewire:out", "Speakers"),
            found("alsa:sysdefault:CARD=Belt", "Belt"),
            found("alsa:hw:CARD=Belt,DEV=0", "Belt"),
            found("alsa:hw:CARD=Glove,DEV=0", "Glove, USB Audio"),
            found("alsa:plughw:CARD=Glove,DEV=0", "Glove, USB Audio"),
            found("alsa:hw:CARD=Glove_1,DEV=0", "Glove, USB Audio"),
            found("alsa:hw:CARD=Hat,DEV=0", "Hat, USB Audio"),
            found("alsa:plughw:CARD=Hat,DEV=0", "Hat, USB Audio"),
        ];
        all[1].1.default = true;
        let id = |name: &str| find(&all, name, |_| true).map(|(_, found)| found.id.clone());
        assert_eq!(id("Belt").unwrap(), "pipewire:usb-1");
        assert_eq!(id("alsa:Belt").unwrap(), "alsa:sysdefault:CARD=Belt");
        assert_eq!(id("ALSA:bel").unwrap(), "alsa:sysdefault:CARD=Belt");
        assert_eq!(id("pipewire").unwrap(), "pipewire:out");
        assert_eq!(id("hat").unwrap(), "alsa:hw:CARD=Hat,DEV=0");
        for name in ["Glove, USB Audio", "glove", "alsa:glove"] {
            let two = id(name).unwrap_err().to_string();
            assert!(
                two.contains("CARD=Glove,DEV=0 or alsa:hw:CARD=Glove_1,DEV=0") && two.contains("by its id"),
                "{two}"
            );
        }
        assert_eq!(id("hw:CARD=Glove_1,DEV=0").unwrap(), "alsa:hw:CARD=Glove_1,DEV=0");
        assert!(id("jack:Belt").unwrap_err().to_string().contains("there is no device `jack:Belt`"));
        assert!(id("alsa:null").unwrap_err().to_string().contains("nothing keeps time on it"));
        assert!(id("pipewire:Hat").is_err(), "it is not in that host");
    }
}
