//! A connection to PulseAudio by which it is asked one thing after another, and which ends when it is dropped.

use std::ffi::CString;
use std::io::{self, BufReader};
use std::os::unix::net::UnixStream;

use pulseaudio::protocol::{
    AuthParams, AuthReply, Command, CommandReply, MAX_VERSION, Prop, Props, ProtocolError,
    SetClientNameReply, read_reply_message, write_command_message,
};

use crate::io::device::kept::PATIENCE;

/// A connection.
#[derive(Debug)]
pub(super) struct Client {
    server: BufReader<UnixStream>,
    version: u16,
    number: u32,
}

impl Client {
    /// To the server that the environment names. No answer takes longer than [`PATIENCE`].
    ///
    /// # Errors
    /// None that answers.
    pub fn connect() -> Result<Self, ProtocolError> {
        let path =
            pulseaudio::socket_path_from_env().ok_or(io::ErrorKind::NotFound).map_err(io::Error::from)?;
        let server = UnixStream::connect(path)?;
        server.set_read_timeout(Some(PATIENCE))?;
        server.set_write_timeout(Some(PATIENCE))?;
        let mut client = Self { server: BufReader::new(server), version: MAX_VERSION, number: 0 };
        let cookie = pulseaudio::cookie_path_from_env().and_then(|path| std::fs::read(path).ok());
        let who = AuthParams {
            version: MAX_VERSION,
            supports_shm: false,
            supports_memfd: false,
            cookie: cookie.unwrap_or_default(),
        };
        let agreed: AuthReply = client.ask(&Command::Auth(who))?;
        client.version = agreed.version.min(MAX_VERSION);
        let mut about = Props::new();
        about.set(Prop::ApplicationName, c"pacinian, a look");
        about.set(Prop::ApplicationProcessId, process());
        let _: SetClientNameReply = client.ask(&Command::SetClientName(about))?;
        Ok(client)
    }

    /// What the server answers.
    ///
    /// # Errors
    /// What it refuses, no answer, and one to something else. But for what it refuses, nothing more is to be asked here.
    pub fn ask<R: CommandReply>(&mut self, command: &Command) -> Result<R, ProtocolError> {
        self.number += 1;
        write_command_message(self.server.get_mut(), self.number, command, self.version)?;
        let (number, answer) = read_reply_message(&mut self.server, self.version)?;
        if number == self.number {
            Ok(answer)
        } else {
            Err(ProtocolError::Invalid(format!("an answer to {number} where {} was asked", self.number)))
        }
    }
}

/// The number of this process, as it stands beside its streams.
pub(super) fn process() -> CString {
    // Digits have no zero byte among them.
    CString::new(std::process::id().to_string()).unwrap_or_default()
}
