//! The knob of a rig that is on a serial line, while a patch is played.

use super::failure::Failure;
use super::loaded::Loaded;
use super::table::grouped;
use pacinian::graph::plan::Plan;
use pacinian::io::knob::driver::Running;
use pacinian::io::knob::patched;
use pacinian::knob::effect::program::Any;
use pacinian::live::local::Bounds;
use pacinian::live::remote::{Heard, Lateness, remote};
use pacinian::rig::knob::controller::AMPLITUDE;
use std::sync::mpsc::{Receiver, Sender, channel};

/// A knob that is talked to until this is dropped.
pub struct OnLine {
    running: Running,
    port: String,
    /// Of one whose torque is computed here: how late it is written, and how late it was expected to be, seconds.
    late: Option<Late>,
    says: Receiver<String>,
    orders: Sender<Vec<Any>>,
    /// What is told of it at first.
    pub note: String,
}

/// How late torque is written, and how late it was expected to be, seconds; the same of what the line's own thread makes.
struct Late {
    lateness: Lateness,
    expected: f64,
    alone: Option<f64>,
    exchange: f64,
}

/// Seconds for which one that renders by itself may say nothing: it may when it stands, and is lost by its session.
const STILL: f64 = 10.0;

/// The share of torques that a measured delay is to hold for; those few that are later are a tick without torque.
const OFTEN: f64 = 0.99;

impl OnLine {
    /// Opens the line, where the plan reads a knob that is on one; with what the session hears of it.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn begin(loaded: &Loaded, plan: &Plan) -> Result<Option<(Box<Heard>, Self)>, Failure> {
        let knob = loaded.rig.knob.as_ref().filter(|_| loaded.input.is_none());
        let (Some(of_rig), Some(knob), Some(sensor)) = (knob, &plan.knob, plan.sensor()) else {
            return Ok(None);
        };
        let Some(controller) = &of_rig.controller else { return Ok(None) };
        let patience = if controller.renders() { STILL } else { controller.patience };
        let budget = knob.setup.limits.budget();
        let bounds = Bounds {
            slew: of_rig.slew,
            over_speed: of_rig.over_speed,
            inverted: controller.inverted,
            budget: budget.map_err(|fault| Failure::said(65, fault.to_string()))?,
        };
        let (heard, line) = remote(knob.allowance, patience, AMPLITUDE, sensor.channels, bounds);
        let late = (!controller.renders()).then(|| Late {
            lateness: line.lateness(),
            expected: knob.allowance,
            alone: of_rig.local(),
            exchange: controller.exchange(),
        });
        let (told, says) = channel();
        let (orders, taken) = channel();
        let running =
            patched::begin(of_rig, controller, &knob.setup.effects, taken, line, told).map_err(|why| {
                match why.help {
                    Some(help) => Failure::usage(why.message, help).with_code(why.exit_code),
                    None => Failure::said(why.exit_code, why.message),
                }
            })?;
        let note = format!("its knob is on {}", controller.port);
        let port = controller.port.clone();
        Ok(Some((Box::new(heard), Self { running, port, late, says, orders, note })))
    }

    /// What it did, and what that is worth.
    pub fn conclude(&self) -> String {
        let standing = self.running.standing();
        let trip = standing.round_trip;
        let of = &standing.counts;
        let mut text = format!("  the knob on {}: {} readings", self.port, grouped(of.readings));
        let faults = [(of.dropped, "without an answer"), (of.bad_checksum + of.unexpected, "not understood")];
        for (count, what) in faults.into_iter().filter(|(count, _)| *count > 0) {
            text += &format!(", {} {what}", grouped(count));
        }
        if trip.worst > 0.0 {
            text += &format!(
                "; of the last answers the mean took {:.2} ms, the slowest {:.2} ms",
                1e3 * trip.mean,
                1e3 * trip.worst
            );
        }
        let Some(Late { lateness, expected, alone, exchange }) = &self.late else { return text + "\n" };
        let Some(within) = lateness.within(OFTEN) else { return text + "\n" };
        // The angle was on its way before that, and the torque after it: one answer's time together.
        let delay = ((within + trip.mean) * 1e4).ceil() * 1e-4;
        text += &format!(
            "\n    from an angle to its torque {:.1} ms (99 of 100), {:.1} ms are reckoned with",
            1e3 * delay,
            1e3 * expected
        );
        if delay < 0.9 * expected {
            text += &format!(": `delay = {delay:.4}` in [knob] of the rig makes the knob stiffer");
        } else if delay > *expected {
            text += ": what was later is no torque; smaller blocks, or a longer `delay` in [knob] of the rig, give it back";
        }
        if let Some((within, alone)) = lateness.local_within(OFTEN).zip(*alone) {
            let delay = ((within + trip.mean) * 1e4).ceil() * 1e-4;
            text += &format!(
                "\n    of what depends on the angle alone, which the line's own thread works out, {:.1} ms, and {:.1} ms are reckoned with",
                1e3 * (delay + 0.5 * exchange),
                1e3 * alone
            );
            if delay + 0.5 * exchange < 0.9 * alone {
                text += &format!(": `delay = {delay:.4}` in its controller makes the knob stiffer");
            } else if delay + 0.5 * exchange > alone {
                text += &format!(": write `delay = {delay:.4}` into its controller, or it may swing");
            }
        }
        let profiles = lateness.profiles();
        if profiles.taken > 0 {
            text += &format!(
                "\n    {} blocks' torques came over, {} were replaced by newer ones on their way; their changes put in {:.2e} J; \
                 {:.3} J went into what is felt, by the torques that were given, and its winding was loaded to {:.0} % at the end",
                grouped(profiles.taken),
                grouped(profiles.replaced),
                profiles.booked,
                profiles.absorbed,
                100.0 * profiles.load
            );
            let more = [
                (profiles.beyond, "for angles beyond what was known of"),
                (profiles.slewed, "held to the slew"),
                (profiles.cut, "held to what its winding bears"),
                (profiles.too_fast, "0 as it was too fast"),
            ];
            for (count, what) in more.into_iter().filter(|(count, _)| *count > 0) {
                text += &format!("; {} torques {what}", grouped(count));
            }
        }
        text + "\n"
    }

    /// What a patch that took over wants it to be.
    pub fn follow(&self, effects: Vec<Any>) {
        // Where nobody takes it any more, the knob is gone.
        let _ = self.orders.send(effects);
    }

    /// What it has said since this was asked last.
    pub fn news(&self) -> impl Iterator<Item = String> {
        self.says.try_iter()
    }
}
