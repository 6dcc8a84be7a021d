//! The knob of a rig that is on a serial line, while a patch is played.

use super::failure::Failure;
use super::load::Loaded;
use pacinian::graph::plan::{Plan, Shared};
use pacinian::io::knob::driver::Running;
use pacinian::io::knob::patched;
use pacinian::knob::effect::program::Any;
use pacinian::live::remote::{Heard, remote};
use pacinian::rig::knob::controller::AMPLITUDE;
use std::sync::mpsc::{Receiver, Sender, channel};

/// A knob that is talked to until this is dropped.
pub struct OnLine {
    _running: Running,
    says: Receiver<String>,
    orders: Sender<Vec<Any>>,
    /// What is told of it at first.
    pub note: String,
}

/// Seconds for which one that renders by itself may say nothing: it may when it stands, and is lost by its session.
const STILL: f64 = 10.0;

impl OnLine {
    /// Opens the line, where the plan reads a knob that is on one; with what the session hears of it.
    ///
    /// # Errors
    /// A port that cannot be opened; a patch that would hear a sound card as well.
    pub fn begin(loaded: &Loaded, plan: &Plan) -> Result<Option<(Box<Heard>, Self)>, Failure> {
        let knob = loaded.rig.knob.as_ref().filter(|_| loaded.input.is_none());
        let (Some(of_rig), Some(knob), Some(sensor)) = (knob, &plan.knob, plan.sensor()) else {
            return Ok(None);
        };
        let Some(controller) = &of_rig.controller else { return Ok(None) };
        if plan.shared.iter().any(|shared| matches!(shared, Shared::Input(_))) {
            let what = "the patch listens to a sound card, and its knob is on a serial line: one of them can be heard, not both";
            let help = "play it with --simulated, or without `input` nodes";
            return Err(Failure::usage(what, help).with_code(65));
        }
        let patience = if controller.renders() { STILL } else { controller.patience };
        let (heard, line) = remote(knob.allowance, patience, AMPLITUDE, sensor.channels);
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
        Ok(Some((Box::new(heard), Self { _running: running, says, orders, note })))
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
