//! Which device a session plays on.

use cpal::Device;

use super::access;
use super::failure::{DeviceError, Trouble};
use super::hosts::Hosts;
use super::list::{self, Found, Offer};
use super::servers::Server;
use crate::text::nearest::nearest;

/// What a person says about the device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// This one and no other.
    Named(String),
    /// What the system plays on where nobody says anything; where nothing is there, the virtual card.
    Default,
    /// The virtual card.
    Virtual,
}

/// The device that was found.
#[expect(clippy::large_enum_variant, reason = "there is one, for a moment")]
pub enum Chosen {
    /// A card.
    Card(Device, Found),
    /// The virtual card, and why nothing better if it was not asked for.
    Virtual(Option<&'static str>),
}

impl Chosen {
    /// Its name, for people.
    pub fn name(&self) -> &str {
        match self {
            Self::Card(_, found) => &found.name,
            Self::Virtual(_) => VIRTUAL_NAME,
        }
    }

    /// What names it for good, with its host.
    pub fn id(&self) -> &str {
        match self {
            Self::Card(_, found) => &found.id,
            Self::Virtual(_) => VIRTUAL,
        }
    }

    /// What PulseAudio does with so many channels that it is not to do, and what a server may do behind a device of ALSA's, which hands them to it
    /// by the names of loudspeakers: those beyond eight have none, and are mixed into others or into nothing.
    pub fn mixes(&self, channels: usize) -> Option<String> {
        let Self::Card(_, found) = self else { return None };
        #[cfg(all(feature = "pulseaudio", target_os = "linux"))]
        if let Some(sink) = found.pulse() {
            return super::pulse::map::told(sink, channels);
        }
        let id = ALIASES.iter().find(|id| **id == found.id)?;
        let exact = "`pacinian walk` shows what arrives where; a card by its own name (hw:...), JACK and PipeWire are exact";
        if channels <= NAMED && !Server::all().iter().any(Server::may_be_behind_alsa) {
            return None;
        }
        let does = match channels > NAMED {
            true => format!("mixes them by the names of loudspeakers, of which there are {NAMED}"),
            false => "spreads them over all that its device has, if that has more".into(),
        };
        Some(format!("{id} may hand {channels} channels to a server that {does}: {exact}"))
    }

    /// Whether a person means this device and no other, or nobody feels it; of others, who knows what hangs on them. Who names a system has named
    /// none: see [`Found::may_be_another`].
    pub fn is_meant(&self, wish: &Wish) -> bool {
        match self {
            Self::Card(_, found) => *wish != Wish::Default && !found.may_be_another(),
            Self::Virtual(_) => true,
        }
    }

    /// The numbers of channels that it offers, ascending; none: any.
    pub fn channels(&self) -> &[u16] {
        match self {
            Self::Card(_, found) => found.output.as_ref().map_or(&[], |offer| &offer.channels),
            Self::Virtual(_) => &[],
        }
    }

    /// As many as a line of tactors may have that is to fit it: those that it offers, or all that are there where that is known.
    pub fn fitting(&self) -> &[u16] {
        match self {
            Self::Card(_, Found { output: Some(Offer { there: Some(there), .. }), .. }) => {
                std::slice::from_ref(there)
            }
            _ => self.channels(),
        }
    }

    /// Frames of a block where nobody says otherwise; `None`: as it likes, where it does not say what it can.
    pub fn usual_block(&self) -> Option<u32> {
        let Self::Card(_, Found { output: Some(Offer { blocks: Some((least, most)), .. }), .. }) = self
        else {
            return None;
        };
        Some(USUAL_BLOCK.min(*most).max(*least))
    }

    /// The rate it plays at, if `wanted` is asked for, or nothing: 48 kHz where it has that.
    pub fn rate(&self, wanted: Option<u32>) -> u32 {
        let usual = 48_000;
        match (wanted, self) {
            (Some(rate), _) => rate,
            (None, Self::Card(_, Found { output: Some(Offer { rates, .. }), .. })) => rates.nearest(usual),
            _ => usual,
        }
    }
}

/// Names of ALSA's for the card, or the device of a server, that is the default.
const ALIASES: [&str; 4] = ["alsa:default", "alsa:sysdefault", "alsa:pulse", "alsa:pipewire"];

/// What cpal calls whatever PipeWire plays by default. It is named with the channels that it has, and is not mixed.
const USUAL: [&str; 2] = ["pipewire:output_default", "pipewire:sink_default"];

/// Channels that have a name behind those, where a server may be.
const NAMED: usize = 8;

/// Frames of a block where nobody says otherwise: a system's own choice may be a second long.
const USUAL_BLOCK: u32 = 256;

/// What the virtual card is called on the command line and in a rig.
pub const VIRTUAL: &str = "virtual";

/// What it is called where devices are listed.
pub const VIRTUAL_NAME: &str = "virtual card";

fn is_whatever_plays(id: &str) -> bool {
    ALIASES.contains(&id) || USUAL.contains(&id)
}

fn is_virtual(name: &str) -> bool {
    [VIRTUAL, VIRTUAL_NAME].iter().any(|known| name.eq_ignore_ascii_case(known))
}

impl Wish {
    /// What is said on the command line, or else in the rig, or nowhere.
    pub fn of(said: Option<&str>, rig: Option<&str>) -> Self {
        match said.or(rig) {
            Some(name) if is_virtual(name) => Self::Virtual,
            // Whoever says so has not said which.
            Some(name) if name.eq_ignore_ascii_case(DEFAULT) => Self::Default,
            Some(name) => Self::Named(name.into()),
            None => Self::Default,
        }
    }

    /// The device that is meant, among those of the system.
    ///
    /// # Errors
    /// A device that was named and is not there, or cannot be had. Of what is not named nothing is expected.
    pub fn choose(&self) -> Result<Chosen, DeviceError> {
        self.choose_among(&Hosts::default())
    }

    /// The device that is meant, among those of `hosts`; the session on it looks for it there again when it was away.
    ///
    /// # Errors
    /// As [`Wish::choose`].
    pub fn choose_among(&self, hosts: &Hosts) -> Result<Chosen, DeviceError> {
        match self {
            Self::Virtual => Ok(Chosen::Virtual(None)),
            Self::Default => {
                let mut why = match access::forbidden() {
                    true => "this user may not use the sound cards (`pacinian devices` says what helps)",
                    false => "no sound card is there",
                };
                for place in hosts.places() {
                    let all = place.all().unwrap_or_default();
                    let others = all.iter().any(|(_, found)| found.output.is_some());
                    let Some((device, found)) = all.into_iter().find(|(_, f)| f.default) else {
                        if others {
                            why = "the system says of no sound card that it is the usual one (--device names one)";
                        }
                        continue;
                    };
                    match found.trouble.as_ref().map(|trouble| trouble.kind) {
                        _ if found.output.is_some() => return Ok(Chosen::Card(device, found)),
                        Some(Trouble::Busy) => why = "another program plays on the sound card",
                        Some(Trouble::Forbidden) => why = "this user may not play on the sound card",
                        Some(Trouble::Other) => why = "the sound card cannot be opened",
                        _ => {}
                    }
                }
                Ok(Chosen::Virtual(Some(why)))
            }
            Self::Named(name) => {
                let all = hosts.all();
                let (device, found) =
                    named(&all, name, |found| found.output.is_some()).map_err(|error| match error.kind {
                        Trouble::Missing if nearest(name, [VIRTUAL]).is_some() => {
                            error.help(format!("did you mean `{VIRTUAL}`? It is a card that is always there"))
                        }
                        Trouble::Missing => error.and(&format!("`{VIRTUAL}` is a card that is always there")),
                        _ => error,
                    })?;
                // Who names a device means that one, whatever is played on by default; who names a host has named none, and ALSA and PipeWire have
                // names for whatever plays by default as well.
                let alone = name.strip_suffix(':').unwrap_or(name);
                let default = found.host().eq_ignore_ascii_case(alone) || is_whatever_plays(&found.id);
                Ok(Chosen::Card(device.clone(), Found { default, ..found.clone() }))
            }
        }
    }
}

/// What a session plays on where nobody names another: the first usual device, in the order of the systems, that can be played on; none: the virtual
/// card. As [`Wish::choose`] of [`Wish::Default`], for whoever has looked already.
pub fn played_by_default<'a>(systems: impl IntoIterator<Item = &'a [Found]>) -> Option<&'a Found> {
    let usual = |found: &'a [Found]| found.iter().find(|found| found.default);
    systems.into_iter().filter_map(usual).find(|found| found.output.is_some())
}

/// The device of that name that fits, or that nobody can tell of whether it does, which is an error of its own.
fn named<'a>(
    all: &'a [(Device, Found)],
    name: &str,
    fits: impl Fn(&Found) -> bool,
) -> Result<&'a (Device, Found), DeviceError> {
    let wanted = |found: &Found| fits(found) || found.is_of_use() && found.trouble.is_some();
    let device = list::find(all, name, wanted).map_err(|error| {
        if error.kind != Trouble::Missing {
            return error;
        }
        if let Some(why) = why_not(all, name) {
            return why.clone();
        }
        match access::forbidden() {
            true => DeviceError::new(
                Trouble::Forbidden,
                format!(
                    "{}, or this user may not use it: sound cards are there that the system keeps from it",
                    error.what
                ),
            )
            .help(access::HELP),
            false => error,
        }
    })?;
    match &device.1.trouble {
        Some(trouble) if !fits(&device.1) => Err(trouble.clone()),
        _ => Ok(device),
    }
}

/// Why the device that is called exactly so cannot be opened at all.
fn why_not<'a>(all: &'a [(Device, Found)], name: &str) -> Option<&'a DeviceError> {
    let is_called = |found: &Found| {
        let own = found.id.split_once(':').map(|(_, own)| own);
        found.id == name || found.name == name || own == Some(name)
    };
    let device = all.iter().find(|(_, found)| !found.is_of_use() && is_called(found))?;
    device.1.trouble.as_ref()
}

/// A card of `hosts` by its id, if it is there now.
pub(super) fn again(hosts: &Hosts, id: &str) -> Result<(Device, Found), DeviceError> {
    by_id(hosts, id, |found| found.output.is_some())
}

fn by_id(hosts: &Hosts, id: &str, fits: impl Fn(&Found) -> bool) -> Result<(Device, Found), DeviceError> {
    let device = hosts.device(id).filter(|(_, found)| found.is_of_use());
    match device {
        Some(device) if fits(&device.1) => Ok(device),
        Some((_, Found { trouble: Some(trouble), .. })) => Err(trouble),
        _ => Err(DeviceError::new(Trouble::Missing, format!("{id} is not there"))),
    }
}

/// What the system's default is called on the command line and in a rig.
pub const DEFAULT: &str = "default";

/// The device that a person means by `name`, to be listened to, among those of the system.
///
/// # Errors
/// None of that name that has inputs, or several.
pub fn heard(name: &str) -> Result<(Device, Found), DeviceError> {
    heard_among(&Hosts::default(), name)
}

/// The device that a person means by `name`, to be listened to, among those of `hosts`.
///
/// # Errors
/// As [`heard`].
pub fn heard_among(hosts: &Hosts, name: &str) -> Result<(Device, Found), DeviceError> {
    if is_virtual(name) {
        let what = "the virtual card plays, and hears nothing";
        return Err(DeviceError::new(Trouble::Unfit, what).help("`pacinian devices` lists which hear"));
    }
    let all = hosts.all();
    match named(&all, name, |found| found.input.is_some()) {
        Ok(found) => Ok(found.clone()),
        Err(error) if name.eq_ignore_ascii_case(DEFAULT) => {
            match hosts.default_input().map(|id| heard_again(hosts, &id)) {
                Some(heard) if heard.as_ref().err().is_none_or(|error| error.kind != Trouble::Missing) => {
                    heard
                }
                _ if error.kind != Trouble::Missing => Err(error),
                _ => Err(DeviceError::new(Trouble::Missing, "the system names no sound card that hears")
                    .help("plug one in, or name one; `pacinian devices` lists which are there")),
            }
        }
        Err(error) if error.kind != Trouble::Missing => Err(error),
        Err(error) => match list::find(&all, name, Found::is_of_use) {
            Ok((_, found)) => Err(DeviceError::new(Trouble::Unfit, format!("{} has no inputs", found.name))
                .help("`pacinian devices` lists which have")),
            Err(_) => Err(error),
        },
    }
}

/// What hears where `played` plays: the card itself; of JACK, which has a device for each way, the one for the other.
///
/// # Errors
/// A card without inputs.
pub fn heard_beside(played: &(Device, Found)) -> Result<(Device, Found), DeviceError> {
    let (_, found) = played;
    if found.input.is_some() {
        return Ok(played.clone());
    }
    let jack = (found.host() == "jack").then_some(&found.hosts);
    let other = jack.and_then(|hosts| by_id(hosts, JACK_HEARS, |found| found.input.is_some()).ok());
    other.ok_or_else(|| {
        DeviceError::new(Trouble::Unfit, format!("{} has no inputs", found.name))
            .help("name a sound card that hears: --input-device NAME")
    })
}

/// JACK's inputs, where they are there.
const JACK_HEARS: &str = "jack:input";

/// A device of `hosts` with inputs by its id, if it is there now.
pub(super) fn heard_again(hosts: &Hosts, id: &str) -> Result<(Device, Found), DeviceError> {
    by_id(hosts, id, |found| found.input.is_some())
}

#[cfg(test)]
mod tests {
    use super::{Found, Hosts, Offer, played_by_default};
    use crate::io::device::rates::Rates;

    fn found(default: bool, plays: bool) -> Found {
        let offer = Offer {
            channels: vec![2],
            there: None,
            rates: Rates::default(),
            blocks: None,
            formats: Vec::new(),
        };
        Found {
            id: String::new(),
            name: String::new(),
            default,
            output: plays.then(|| offer.clone()),
            input: Some(offer),
            trouble: None,
            hosts: Hosts::default(),
        }
    }

    #[test]
    fn the_first_usual_device_that_can_be_played_on_is_and_else_the_virtual_card() {
        let (others, busy) = (vec![found(false, true)], vec![found(false, true), found(true, false)]);
        let usual = vec![found(false, false), found(true, true)];
        let second = vec![found(true, true)];
        let is = |systems: &[&Vec<Found>], it: Option<&Found>| {
            let chosen = played_by_default(systems.iter().map(|found| found.as_slice()));
            chosen.map(std::ptr::from_ref) == it.map(std::ptr::from_ref)
        };
        assert!(is(&[], None) && is(&[&Vec::new()], None) && is(&[&others, &busy], None));
        let it = Some(&usual[1]);
        assert!(is(&[&usual], it) && is(&[&busy, &usual, &second], it) && is(&[&usual, &others], it));
        assert!(is(&[&second, &usual], Some(&second[0])));
    }
}
