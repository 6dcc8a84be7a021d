//! Which device a session plays on.

use cpal::Device;

use super::failure::{DeviceError, Trouble};
use super::list::{self, Found, Offer};

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
            Self::Virtual(_) => "virtual card",
        }
    }

    /// The rate it plays at, if `wanted` is asked for, or nothing: 48 kHz where it has that.
    pub fn rate(&self, wanted: Option<u32>) -> u32 {
        let usual = 48_000;
        match (wanted, self) {
            (Some(rate), _) => rate,
            (None, Self::Card(_, Found { output: Some(Offer { rates: (least, most), .. }), .. })) => {
                usual.clamp(*least, *most)
            }
            _ => usual,
        }
    }
}

/// What the virtual card is called on the command line and in a rig.
pub const VIRTUAL: &str = "virtual";

impl Wish {
    /// What is said on the command line, or else in the rig, or nowhere.
    pub fn of(said: Option<&str>, rig: Option<&str>) -> Self {
        match said.or(rig) {
            Some(VIRTUAL) => Self::Virtual,
            Some(name) => Self::Named(name.into()),
            None => Self::Default,
        }
    }

    /// The device that is meant.
    ///
    /// # Errors
    /// A device that was named and is not there. Of what is not named nothing is expected.
    pub fn choose(&self) -> Result<Chosen, DeviceError> {
        let plays = |found: &Found| found.output.is_some();
        match self {
            Self::Virtual => Ok(Chosen::Virtual(None)),
            Self::Default => {
                for (_, host) in list::hosts() {
                    let Some(host) = host else { continue };
                    let all = list::devices(&host).unwrap_or_default();
                    if let Some((device, found)) = all.into_iter().find(|(_, f)| f.default && plays(f)) {
                        return Ok(Chosen::Card(device, found));
                    }
                }
                Ok(Chosen::Virtual(Some("no sound card is there")))
            }
            Self::Named(name) => {
                let mut all = Vec::new();
                for (_, host) in list::hosts() {
                    all.extend(host.and_then(|host| list::devices(&host).ok()).unwrap_or_default());
                }
                let (device, found) = list::find(&all, name, plays)?;
                Ok(Chosen::Card(device.clone(), found.clone()))
            }
        }
    }
}

/// A card by its id, if it is there now.
pub fn again(id: &str) -> Result<(Device, Found), DeviceError> {
    by_id(id, |found| found.output.is_some())
}

fn by_id(id: &str, fits: impl Fn(&Found) -> bool) -> Result<(Device, Found), DeviceError> {
    for (_, host) in list::hosts() {
        let all = host.and_then(|host| list::devices(&host).ok()).unwrap_or_default();
        if let Some(found) = all.into_iter().find(|(_, found)| found.id == id && fits(found)) {
            return Ok(found);
        }
    }
    Err(DeviceError::new(Trouble::Missing, format!("{id} is not there")))
}

/// What the system's default for recording is called on the command line and in a rig.
pub const DEFAULT: &str = "default";

/// The device that a person means by `name`, to be listened to.
///
/// # Errors
/// None of that name that has inputs, or several.
pub fn heard(name: &str) -> Result<(Device, Found), DeviceError> {
    let hears = |found: &Found| found.input.is_some();
    let all: Vec<_> = list::hosts()
        .into_iter()
        .flat_map(|(_, host)| host.and_then(|host| list::devices(&host).ok()).unwrap_or_default())
        .collect();
    match list::find(&all, name, hears) {
        Ok(found) => Ok(found.clone()),
        Err(error) if name == DEFAULT => {
            let id = list::default_input().ok_or(error)?;
            heard_again(&id)
        }
        Err(error) => match list::find(&all, name, |_| true) {
            Ok((_, found)) => Err(DeviceError::new(Trouble::Unfit, format!("{} has no inputs", found.name))
                .help("`pacinian devices` lists which have")),
            Err(_) => Err(error),
        },
    }
}

/// A device with inputs by its id, if it is there now.
pub(super) fn heard_again(id: &str) -> Result<(Device, Found), DeviceError> {
    by_id(id, |found| found.input.is_some())
}
