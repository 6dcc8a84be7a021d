//! The device that is meant, and why there is none.

use super::failure::Failure;
use super::patience;
use super::stop::Stop;
use super::terminal::Terminal;
use pacinian::io::device::choose::{Chosen, Wish};
use pacinian::io::device::failure::Trouble;
use pacinian::io::device::servers::Server;
use pacinian::text::problem::escaped;

/// The device that is meant. Where none of a sound server is there that was named, the server is the reason.
///
/// # Errors
/// As [`Wish::choose`], and a sound system that does not answer.
pub fn choose(wish: &Wish, stop: Option<&Stop>, terminal: &Terminal) -> Result<Chosen, Failure> {
    let asked = wish.clone();
    patience::look(stop, terminal, move || asked.choose())?.map_err(|error| {
        let named = match wish {
            Wish::Named(name) if error.kind == Trouble::Missing => Server::named(name),
            _ => None,
        };
        match named {
            Some(Server { name, built_in: false, help, .. }) => Failure::usage(
                format!("{}: this program does not speak with {name} itself", error.what),
                help,
            ),
            Some(Server { name, runs: false, help, .. }) => {
                Failure::usage(format!("{}: {name} does not run", error.what), format!("start it: {help}"))
            }
            _ => return error.into(),
        }
        .with_code(error.kind.exit_code())
    })
}

/// As [`choose`]: the device that the command line names, or else the rig in that file; and how it was meant.
///
/// # Errors
/// As [`choose`]; of a rig's device it is said where it stands.
pub fn choose_for(
    device: Option<&str>,
    by_rig: Option<&str>,
    rig: impl std::fmt::Display,
    stop: Option<&Stop>,
    terminal: &Terminal,
) -> Result<(Wish, Chosen), Failure> {
    let wish = Wish::of(device, by_rig);
    match choose(&wish, stop, terminal) {
        Ok(chosen) => Ok((wish, chosen)),
        Err(failure) if device.is_none() && by_rig.is_some() => Err(failure.and(&format!(
            "it is the `name` under [device] in {}; --device names another",
            escaped(&rig.to_string())
        ))),
        Err(failure) => Err(failure),
    }
}

/// A device that nobody has described has to have as many outputs as the patch has tactors.
pub fn fits(device: &Chosen, channels: usize) -> Result<(), Failure> {
    let offered = device.channels();
    let Some(most) = offered.last().filter(|_| offered.iter().all(|count| usize::from(*count) != channels))
    else {
        return Ok(());
    };
    let what = format!("the patch plays on {channels} tactors, and {} has {most} outputs", device.name());
    let help =
        "choose another card with --device (`virtual` is one that has any number), or name a rig with --rig";
    Err(Failure::usage(what, help).with_code(69))
}
