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
    for (_, host) in list::hosts() {
        let all = host.and_then(|host| list::devices(&host).ok()).unwrap_or_default();
        if let Some(found) = all.into_iter().find(|(_, found)| found.id == id && found.output.is_some()) {
            return Ok(found);
        }
    }
    Err(DeviceError::new(Trouble::Missing, format!("{id} is not there")))
}
