//! Bindings: what is moved outside moves controls.

use super::pickup::Whose;
use super::{Happening, Outlet, Performer, When};
use crate::patch::Bind;
use crate::text::Problem;

/// What moves controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Mind {
    /// A hand.
    #[default]
    Hand,
    /// A song, which has no fader that stands anywhere.
    Song,
    /// A reset, or a port that is gone.
    Rest,
}

impl Performer {
    /// Moves the controls of the bindings for which `says` has a position, from 0 to 1, to that.
    pub(super) fn move_by(
        &mut self,
        (at, now): (When, When),
        says: &dyn Fn(&Bind) -> Option<f64>,
        whose: Whose,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        if self.patch.binds.is_empty() {
            return Ok(());
        }
        // A finger that moves on a channel of MPE is one of one hand.
        let hand = whose.map(|(port, channel)| match self.hands.get(port) {
            Some(hands) => (port, hands.hand(channel)),
            None => (port, channel),
        });
        let patch = std::sync::Arc::clone(&self.patch);
        let mut result = Ok(());
        for (number, bind) in patch.binds.iter().enumerate() {
            let on_channel =
                whose.zip(bind.channel).is_none_or(|((_, channel), wanted)| channel.number() == wanted);
            let Some(position) = says(bind).filter(|position| on_channel && position.is_finite()) else {
                continue;
            };
            let place = patch.controls.iter().position(|control| control.name == bind.control);
            let Some((control, place)) = place.and_then(|place| Some((patch.controls.get(place)?, place)))
            else {
                continue;
            };
            if let Some((encoder, value)) = bind.encoder.zip(self.targets.get(place).copied()) {
                let turned = bind.turned(encoder, control, value, (127.0 * position).round() as u8);
                if turned != value {
                    result = result.and(self.set_by(at, now, &control.name, turned, outlet));
                }
                continue;
            }
            let stands = self.targets.get(place).and_then(|value| bind.position(control, *value));
            // A song has no fader that stands anywhere, and a sensor is where it is.
            let picks_up = bind.pickup && self.mind != Mind::Song && control.stream == 0.0;
            let waits = self.pickups.get_mut(number).and_then(|pickups| {
                let pickup = pickups.of(hand);
                if self.mind == Mind::Rest {
                    return (!pickup.rests(position, stands)).then_some(false);
                }
                let moves = pickup.moves(position, stands);
                if !picks_up {
                    pickup.take(position);
                    return None;
                }
                (!moves).then(|| pickup.begins_to_wait())
            });
            if waits == Some(true) {
                let control = &control.name;
                self.tell(
                    at,
                    None,
                    None,
                    Happening::Waits { control, position, stands: stands.unwrap_or(0.0) },
                );
            }
            if waits.is_none() {
                let value = bind.value(control, position);
                result = result.and(self.set_by(at, now, &control.name, value, outlet));
            }
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::super::staged::{self, HEAD, Kept, VOICE};
    use super::{Happening, When};
    use crate::engine::event::Event;

    /// A tracker that tells where it is in metres, all in one message: each number moves its own control, at once, and all that is missing nothing.
    #[test]
    fn numbers_of_one_message_move_controls_of_their_own() {
        let text = format!(
            "{HEAD}[control.x]\ndefault = 0\nrange = [-1, 1]\nstream = 0.03\n[control.y]\ndefault = 0\nrange = [0, 10]\n\
             [[bind]]\nfrom = \"osc./hand\"\ncontrol = \"x\"\nsends = [-0.5, 0.5]\n\
             [[bind]]\nfrom = \"osc./hand 3\"\ncontrol = \"y\"\nsends = [2, 1]\npickup = false\n{}",
            VOICE.replace("frequency = 100", "frequency = 100, amplitude = \"x + y\"")
        );
        let mut performer = staged::performer(&text, 1);
        let told = Arc::new(Mutex::new(Vec::new()));
        let list = Arc::clone(&told);
        performer.listen(Box::new(move |heard| {
            list.lock().unwrap().push(match heard.what {
                Happening::Control(name, value) => (name.to_string(), value),
                other => panic!("{other:?}"),
            });
        }));
        let mut kept = Kept::default();
        let at = |seconds| When::of_seconds(seconds, 8000.0);
        // Three numbers; two, of which the second is nobody's; what is no number; and beyond the ends.
        performer.osc_by((at(0.99), at(1.0)), "/hand", &[0.25, 7.0, 1.25], &mut kept).unwrap();
        performer.osc(at(1.1), "/hand", &[-0.5, 7.0], &mut kept).unwrap();
        performer.osc(at(1.2), "/hand", &[f64::NAN, 7.0, 2.0], &mut kept).unwrap();
        performer.osc(at(1.3), "/hand", &[9.0, 7.0, -9.0], &mut kept).unwrap();
        performer.osc(at(1.4), "/hand", &[], &mut kept).unwrap();
        assert_eq!(performer.patch().binds[0].position_of(1e300), 1.0);
        let wanted = [("x", 0.5), ("y", 7.5), ("x", -1.0), ("y", 0.0), ("x", 1.0), ("y", 10.0)];
        assert_eq!(*told.lock().unwrap(), wanted.map(|(name, value)| (name.to_string(), value)));
        // What was sampled 10 ms ago is there 30 ms after that.
        let glide = kept.0.iter().find_map(|(at, event)| match event {
            Event::Glide(_, _, seconds) => Some((*at, *seconds)),
            _ => None,
        });
        let (begins, seconds) = glide.unwrap();
        assert!(
            (begins.since(Default::default()) / 8000.0 - 1.0).abs() < 1e-9 && (seconds - 0.02).abs() < 1e-9,
            "{begins:?} {seconds}"
        );
    }
}
