//! `--osc` and `--osc-to` of `pacinian play`.

use super::failure::Failure;
use super::terminal::Terminal;
use clap::Args;
use pacinian::graph::plan::Plan;
use pacinian::io::osc::announce::{Announcer, InVain};
use pacinian::io::osc::endpoint::{BindError, Endpoint};
use pacinian::io::osc::server::Server;
use pacinian::live::signal::Handle;
use pacinian::patch::Patch;
use std::net::UdpSocket;

/// Addresses that are told of markers, at most.
const MOST: usize = 16;

/// What is heard over OSC, and told.
#[derive(Debug, Clone, Default, Args)]
pub struct Osc {
    /// Listen for OSC on this UDP port, or address and port; a port alone is for this machine only. docs/osc.md lists what it hears
    #[arg(long, value_name = "ADDR")]
    osc: Option<Endpoint>,
    /// Tell every marker over OSC to this UDP port, or address and port, as it is played; may be given again for another
    #[arg(long, value_name = "ADDR", value_parser = target)]
    osc_to: Vec<Endpoint>,
}

/// Where somebody can listen.
fn target(text: &str) -> Result<Endpoint, String> {
    let endpoint: Endpoint = text.parse()?;
    match endpoint.0.port() {
        0 => {
            Err("nobody listens on port 0: give the port of the program that is to be told, 1 to 65535"
                .into())
        }
        _ => Ok(endpoint),
    }
}

impl From<BindError> for Failure {
    fn from(error: BindError) -> Self {
        Self::usage(error.what, error.help).with_code(error.exit_code)
    }
}

impl Osc {
    /// Who tells of a session that begins with `plan`, if anybody can ask for it or is to be told.
    ///
    /// # Errors
    /// Too many who are to be told; a system that has no thread or socket left.
    pub fn announcer(&self, plan: &Plan) -> Result<Option<Announcer>, Failure> {
        if self.osc.is_none() && self.osc_to.is_empty() {
            return Ok(None);
        }
        if self.osc_to.len() > MOST {
            let help = "let one program pass them on";
            return Err(Failure::usage(format!("--osc-to is given more than {MOST} times"), help));
        }
        let announcer =
            Announcer::new(plan).map_err(|error| Failure::no_thread("OSC that is sent", &error))?;
        for endpoint in &self.osc_to {
            announcer.always(endpoint.0)?;
        }
        Ok(Some(announcer))
    }

    /// Takes hold of the address where it is to listen, if it is to.
    ///
    /// # Errors
    /// As [`Endpoint::bind`].
    pub fn bind(&self) -> Result<Option<UdpSocket>, Failure> {
        Ok(self.osc.map(|at| at.bind()).transpose()?)
    }

    /// Listens there, and says so.
    ///
    /// # Errors
    /// As [`Server::of`].
    pub fn listen(
        &self,
        socket: Option<UdpSocket>,
        session: &Handle,
        patch: &Patch,
        announcer: Option<&Announcer>,
        terminal: &Terminal,
    ) -> Result<Option<Server>, Failure> {
        for endpoint in &self.osc_to {
            terminal.note(&format!("markers are told over OSC to {}\n", endpoint.0));
        }
        let (Some(at), Some(socket)) = (self.osc, socket) else { return Ok(None) };
        let server = Server::of(socket, at, session.clone(), patch, announcer.cloned())?;
        let by = if at.is_open() { "all that can reach it" } else { "programs on this machine" };
        terminal.note(&format!("OSC is heard on {}, from {by}\n", server.address()));
        Ok(Some(server))
    }
}

/// Why what is told over OSC does not arrive.
pub fn in_vain((at, why): &InVain) -> String {
    match why {
        None => format!("nobody listens at {at}"),
        Some(why) => format!("nothing can be sent to {at} ({why})"),
    }
}
