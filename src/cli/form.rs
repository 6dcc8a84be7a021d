//! Whether a rendering has a form that a WAV file can have.

use super::failure::Failure;
use super::loaded::Loaded;
use super::table::hertz;
use pacinian::graph::plan::Plan;
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::text::{Problem, Problems};

const FORMATS: [Encoding; 3] = [Encoding::F32, Encoding::I24, Encoding::I16];

/// The formats whose header has room for the channels of a plan.
fn possible(plan: &Plan) -> Vec<String> {
    let fits =
        |format: &Encoding| WavSpec::new(plan.channels, plan.device_rate as u32, *format).check().is_ok();
    FORMATS.iter().filter(|format| fits(format)).map(ToString::to_string).collect()
}

fn what(plan: &Plan, format: &str) -> String {
    let (channels, rate) = (plan.channels, hertz(plan.device_rate));
    format!(
        "no WAV file{format} holds {channels} channels at {rate}: its header counts the bytes of a second up to 4 GiB"
    )
}

/// Refuses a format that has no room for the channels.
///
/// # Errors
/// Says which has, or what else to do.
pub fn check(plan: &Plan, format: Encoding) -> Result<(), Failure> {
    let possible = possible(plan);
    if possible.contains(&format.to_string()) {
        return Ok(());
    }
    Err(match possible.is_empty() {
        true => {
            Failure::usage(what(plan, ""), "lower the rate, or give the device fewer channels").with_code(78)
        }
        false => Failure::usage(
            what(plan, &format!(" of {format}")),
            format!("choose --format {}, or a lower rate", possible.join(" or ")),
        ),
    })
}

/// The same, for who does not render yet: a warning as long as some format will do.
///
/// # Errors
/// When none will.
pub fn foresee(plan: &Plan, loaded: &mut Loaded) -> Result<(), Failure> {
    let possible = possible(plan);
    if possible.is_empty() {
        return check(plan, Encoding::default());
    }
    let missing: Vec<String> =
        FORMATS.iter().map(ToString::to_string).filter(|format| !possible.contains(format)).collect();
    if !missing.is_empty() {
        let warning = Problem::warning(&(0..0), what(plan, &format!(" of {}", missing.join(" or "))))
            .help(format!("render with --format {}, or at a lower rate", possible.join(" or ")));
        let file = loaded.name().to_string();
        loaded.warnings.push(Problems { file, source: String::new(), list: vec![warning] });
    }
    Ok(())
}
