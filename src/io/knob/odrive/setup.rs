//! What is set on the board before it is driven, in order.

use std::f64::consts::TAU;

use super::settings::Settings;

/// In which way a board tells its errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Errors {
    /// Firmware 0.5.
    Old,
    /// Firmware 0.6.
    New,
}

/// The names of errors, the older first.
pub(super) const ERRORS: [&str; 2] = ["error", "active_errors"];

/// What a step of set-up is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// Asks what it is.
    Identify,
    /// Asks for its errors, and clears those of a watchdog.
    Errors,
    /// Sets a property.
    Set(&'static Property),
    /// Closes the loop, and waits until it is.
    Close,
}

/// A property of an axis.
#[derive(Debug)]
pub(super) struct Property {
    /// Its names behind `axis0.`, the older first.
    pub names: &'static [&'static str],
    /// What it is to be, as the board has it.
    pub value: fn(&Settings) -> f64,
    /// Whether what is there may stay.
    pub stays: fn(there: f64, wanted: f64) -> bool,
    /// What it means that it is not there.
    pub missing: Missing,
}

/// What it means that a property is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Missing {
    /// Nothing: boards of that firmware have none.
    Nothing,
    /// Something to know.
    Note(&'static str),
    /// That it cannot be driven, unless that is allowed.
    Watchdog,
}

impl Step {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Identify,
        Self::Errors,
        Self::Set(&Property {
            names: &["motor.config.torque_lim", "config.torque_soft_max"],
            value: |settings| settings.most_torque,
            stays: |there, wanted| there <= wanted,
            missing: Missing::Note("its torque has no limit but the one here"),
        }),
        Self::Set(&Property {
            names: &["config.torque_soft_min"],
            value: |settings| -settings.most_torque,
            stays: |there, wanted| there >= wanted,
            missing: Missing::Nothing,
        }),
        Self::Set(&Property {
            names: &["controller.config.vel_limit"],
            value: |settings| settings.most_speed / TAU,
            stays: |there, wanted| there <= wanted,
            missing: Missing::Note("its speed has no limit"),
        }),
        // Torque, 1, and as it is told, 1: `c` alone leaves a ramp in between where one was set.
        Self::Set(&Property {
            names: &["controller.config.control_mode"],
            value: |_| 1.0,
            stays: |there, wanted| there == wanted,
            missing: Missing::Note("whether it follows torque is not known"),
        }),
        Self::Set(&Property {
            names: &["controller.config.input_mode"],
            value: |_| 1.0,
            stays: |there, wanted| there == wanted,
            missing: Missing::Note("whether it follows torque at once is not known"),
        }),
        Self::Set(&Property {
            names: &["config.watchdog_timeout"],
            value: |settings| settings.watchdog,
            stays: |_, _| false,
            missing: Missing::Watchdog,
        }),
        Self::Set(&Property {
            names: &["config.enable_watchdog"],
            value: |_| 1.0,
            stays: |_, _| false,
            missing: Missing::Watchdog,
        }),
        Self::Close,
    ];
}

/// From this step on the watchdog is to be fed.
pub(super) const WATCHED: usize = 7;
