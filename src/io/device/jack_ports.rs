//! How many channels a JACK server has. A client may have as many as it likes, and cpal offers 64; those for which the server's card has no
//! port would go nowhere.

use jack::{Client, ClientOptions, PortFlags};

use super::list::Offer;

/// What a device of JACK offers, as far as there are ports that it is connected with.
pub(super) fn limit(offer: &mut Option<Offer>, ports: &str) {
    let Some(offer) = offer else { return };
    let Some(_turn) = super::jack_turn::turn() else { return };
    let Ok((client, _)) = Client::new("pacinian_ports", ClientOptions::NO_START_SERVER) else { return };
    let there = client.ports(Some(ports), None, PortFlags::empty()).len();
    // Where there is no card at all, somebody connects them by hand.
    if there > 0 {
        offer.channels.retain(|channels| usize::from(*channels) <= there);
        offer.there = offer.channels.last().copied().filter(|most| usize::from(*most) == there);
    }
}
