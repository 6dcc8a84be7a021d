//! Where devices are looked for.

use std::fmt;
use std::sync::Arc;

use cpal::traits::HostTrait;
use cpal::{Device, Host, HostId};

use super::failure::DeviceError;
use super::hush::{hush, quietly};
use super::jack_turn;
use super::kept;
use super::list::{self, Found};
use super::pcm;

/// Where devices are looked for: in the sound systems of the machine, which is the default, or in one that a program brings along.
///
/// A program whose devices are no sound cards (a box on the network, a simulator, a test) writes a host for them with the feature
/// `custom` of [`cpal`], and plays sessions on it as on any other: with all that happens when a device goes away and comes back.
///
/// ```
/// use pacinian::io::device::choose::Wish;
/// use pacinian::io::device::hosts::Hosts;
///
/// // `simulator` is `cpal::platform::CustomHost::from_host(...)` of something that implements `cpal::traits::HostTrait`.
/// # fn left_glove(simulator: cpal::platform::CustomHost) -> Result<(), pacinian::io::device::failure::DeviceError> {
/// let hosts = Hosts::of(simulator.into());
/// let device = Wish::Named("left glove".into()).choose_among(&hosts)?;
/// // As with a sound card: `Session::start(Beginning::of(scene, device))`.
/// # Ok(())
/// # }
/// ```
///
/// A device is found again by its id ([`cpal::traits::DeviceTrait::id`]), so that should stay the same while it is away; where a host gives
/// none, its name has to do.
#[derive(Clone, Default)]
pub struct Hosts(Option<Arc<Host>>);

/// A host, to be looked at.
pub struct Place {
    /// What it is called: `alsa`, `jack`; `custom` where a program has brought it along.
    pub name: String,
    host: Option<Arc<Host>>,
    of: Hosts,
}

impl Hosts {
    /// That one, and no other.
    pub fn of(host: Host) -> Self {
        Self(Some(Arc::new(host)))
    }

    /// The hosts that there may be, the best first. Each is only asked whether it runs when its turn comes.
    pub fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let brought = self.0.clone().map(|host| Place {
            name: host.id().to_string(),
            host: Some(host),
            of: self.clone(),
        });
        // Of those that programs bring along, the system knows nothing.
        let system = cpal::ALL_HOSTS.iter().filter(|id| **id != HostId::Custom).map(|id| Self::open(*id));
        let system = self.0.is_none().then_some(system).into_iter().flatten();
        brought.into_iter().chain(system)
    }

    /// A host of the system.
    fn open(id: HostId) -> Place {
        hush();
        let host = match id.to_string().as_str() {
            PULSE => kept::host(id),
            // It opens clients to see what there is.
            JACK => jack_turn::turn().and_then(|_turn| cpal::host_from_id(id).ok().map(Arc::new)),
            _ => cpal::host_from_id(id).ok().map(Arc::new),
        };
        Place { name: id.to_string(), host, of: Self::default() }
    }

    /// All devices of all hosts that run, those of no use too.
    pub(super) fn all(&self) -> Vec<(Device, Found)> {
        self.places().flat_map(|place| place.all().unwrap_or_default()).collect()
    }

    /// The device that has this id, if it is there. No other is looked at, and no other host.
    pub(super) fn device(&self, id: &str) -> Option<(Device, Found)> {
        let _turn = jack_turn::look(id).ok()?;
        let parsed: Option<cpal::DeviceId> = id.parse().ok();
        let host = match (&self.0, &parsed) {
            (Some(host), _) => Arc::clone(host),
            (None, Some(parsed)) if parsed.host().to_string() == PULSE => {
                hush();
                let device = kept::is_there(parsed.host(), id).then(|| kept::device(parsed.host(), id))??;
                return Some(list::look(device, None, self));
            }
            (None, Some(parsed)) => Self::open(parsed.host()).host?,
            (None, None) => return None,
        };
        hush();
        let by_id = parsed.and_then(|parsed| host.device_by_id(&parsed));
        // Those without an id are known by their names.
        let device = by_id.or_else(|| host.devices().ok()?.find(|device| list::id(device) == id))?;
        let (device, found) = list::look(device, None, self);
        (found.id == id).then_some((device, found))
    }

    /// Whether the device that has this id is there: without a word to what plays.
    pub(super) fn has(&self, id: &str) -> bool {
        match (&self.0, id.parse::<cpal::DeviceId>()) {
            (None, Ok(parsed)) if parsed.host().to_string() == PULSE => kept::is_there(parsed.host(), id),
            _ => self.device(id).is_some(),
        }
    }

    /// The id of the device that is recorded from where nobody says anything.
    pub fn default_input(&self) -> Option<String> {
        let default = |place: Place| place.host?.default_input_device().map(|device| list::id(&device));
        self.places().find_map(default)
    }
}

/// The system of which the program keeps a host. Its sinks pause at first where they were idle, and it moves streams without a word.
pub(super) const PULSE: &str = "pulseaudio";

/// The system whose clients are opened by turns.
pub(super) const JACK: &str = "jack";

impl Place {
    /// Whether it runs. Of JACK, which has a device for whoever asks, a server must be there.
    pub fn runs(&self) -> bool {
        let there = |host: &Arc<Host>| self.name != JACK || host.default_output_device().is_some();
        self.host.as_ref().is_some_and(there)
    }

    /// All its devices that are of use; none where it does not run.
    ///
    /// # Errors
    /// One that does not answer.
    pub fn devices(&self) -> Result<Vec<(Device, Found)>, DeviceError> {
        self.all().map(|all| all.into_iter().filter(|(_, found)| found.is_of_use()).collect())
    }

    /// All its devices.
    pub(super) fn all(&self) -> Result<Vec<(Device, Found)>, DeviceError> {
        let Some(host) = &self.host else { return Ok(Vec::new()) };
        hush();
        let default = host.default_output_device().as_ref().map(list::id);
        let all = host.devices().map_err(|error| DeviceError::of("the sound system", &error))?;
        let all = all.filter(|device| !list::is_none(&list::id(device)));
        let look = |device| match jack_turn::look(&list::id(&device)) {
            Ok(_turn) => quietly(|| list::look(device, default.as_deref(), &self.of)),
            Err(dead) => list::unseen(device, dead, &self.of),
        };
        let mut all = all.map(look).collect();
        pcm::tidy(&mut all);
        Ok(all)
    }
}

impl fmt::Debug for Hosts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Hosts(brought along)" } else { "Hosts(the system's)" })
    }
}

/// Those of the system are the same; of two that were brought along, clones of one are.
impl PartialEq for Hosts {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        }
    }
}
