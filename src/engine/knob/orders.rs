//! What a knob is told, on its way to the sample from which it holds.
//!
//! A knob runs ahead of the graph to the end of its cell, or of the call: where it is when an event takes place depends on how time is cut
//! into calls. So an order that comes in the middle of a cell holds from the next one on, wherever the knob is.

/// What a knob is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::engine) enum Order {
    /// A hand pushes with so many newton metres; what is no number is no hand.
    Push(f64),
    /// Whether what comes in and goes out does so in the time that the governor was told of.
    Deadline(bool),
    /// Torque may rise, after a fault as well: that of a knob that is there as soon as its angle is known.
    Rise,
    /// Torque is 0.
    Fall,
    /// Something sounds: torque rises where the patch has it rise by itself and it does not flow.
    Open,
}

/// Those that came in a cell, as what they amount to: however many there are, they have room.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Orders {
    due: Option<u64>,
    push: Option<f64>,
    in_time: Option<bool>,
    falls: bool,
    /// The last of those that let it rise.
    rises: Option<Order>,
    acknowledges: bool,
}

impl Orders {
    /// One more, that holds from sample `due` on. Those before it hold from then on, too.
    pub fn add(&mut self, due: u64, order: Order) {
        self.due = Some(due);
        match order {
            Order::Push(torque) => self.push = Some(torque),
            Order::Deadline(kept) => self.in_time = Some(kept),
            Order::Rise => (self.acknowledges, self.rises) = (true, Some(Order::Rise)),
            Order::Fall => (self.falls, self.rises) = (true, None),
            // It lets rise no more than what did before.
            Order::Open => self.rises = self.rises.or(Some(Order::Open)),
        }
    }

    /// Those that hold from a sample on, in their order, if it is theirs.
    pub fn take(&mut self, sample: u64) -> Option<impl Iterator<Item = Order> + use<>> {
        self.due.filter(|due| *due <= sample)?;
        let Self { push, in_time, falls, rises, acknowledges, .. } = std::mem::take(self);
        // What was let rise and then let go of was acknowledged.
        let first = (acknowledges && rises != Some(Order::Rise)).then_some(Order::Rise);
        let pushed = push.map(Order::Push).into_iter().chain(in_time.map(Order::Deadline));
        let fall = falls.then_some(Order::Fall);
        Some(pushed.chain(first).chain(fall).chain(rises))
    }
}

#[cfg(test)]
mod tests {
    use super::Order::{Deadline, Fall, Open, Push, Rise};
    use super::{Order, Orders};

    fn amount(orders: &[Order]) -> Vec<Order> {
        let mut all = Orders::default();
        orders.iter().for_each(|order| all.add(8, *order));
        assert!(all.take(7).is_none());
        let taken = all.take(8).unwrap().collect();
        assert_eq!(all, Orders::default());
        taken
    }

    /// What a knob is that is told them: whether torque may rise, and whether a fault is still latched.
    fn told(orders: &[Order], mut armed: bool, wanted: bool) -> (bool, bool, Option<f64>, Option<bool>) {
        let (mut fault, mut push, mut kept) = (true, None, None);
        for order in orders {
            match *order {
                Push(torque) => push = Some(torque),
                Deadline(in_time) => kept = Some(in_time),
                Rise => (fault, armed) = (false, true),
                Fall => armed = false,
                Open => armed |= wanted && !fault,
            }
        }
        (armed, fault, push, kept)
    }

    #[test]
    fn what_they_amount_to_is_what_they_do_one_by_one() {
        let kinds = [Push(1.0), Push(-2.0), Deadline(false), Deadline(true), Rise, Fall, Open];
        for number in 0..7_usize.pow(4) {
            let orders: Vec<Order> = (0..4).map(|place| kinds[number / 7_usize.pow(place) % 7]).collect();
            for (armed, wanted) in [(false, false), (false, true), (true, false), (true, true)] {
                let amount = amount(&orders);
                assert_eq!(
                    told(&amount, armed, wanted),
                    told(&orders, armed, wanted),
                    "{orders:?} as {amount:?}, armed {armed}, wanted {wanted}"
                );
            }
        }
    }

    #[test]
    fn however_many_they_have_room() {
        let many: Vec<Order> =
            (0..100_000).map(|n| [Rise, Fall, Open, Push(f64::from(n))][n as usize % 4]).collect();
        assert!(amount(&many).len() <= 5);
    }
}
