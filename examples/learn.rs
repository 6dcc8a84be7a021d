//! Which fader moves which control, found out by moving it, and written into a patch whose comments stay.
//!
//! With the name of a patch it listens to all ports of MIDI and to OSC on port 9000, and changes that file. Without one, it has a patch of its own, and
//! a thread that moves an OSC fader. Run with `cargo run --release --example learn -- PATCH`.

use std::error::Error;
use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use pacinian::io::learn::{Heard, Learner};
use pacinian::io::replace;
use pacinian::{Patch, edit};
use rosc::{OscMessage, OscPacket, OscType, encoder::encode};

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "A hand"

[control.strength]   # of the buzz
default = 0.5

[voice.buzz]
start = "always"
output = "tone"
nodes.tone = { type = "sine", frequency = 200, amplitude = "strength" }
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    let before = file.as_ref().map_or(Ok(PATCH.into()), std::fs::read_to_string)?;
    let patch = Patch::parse("the patch", before.as_bytes())?.value;

    let mut learner = Learner::default();
    let port = if file.is_some() { "9000" } else { "127.0.0.1:0" };
    let heard_at = learner.hear_osc(port.parse()?)?;
    if file.is_some() {
        learner.hear_midi(None, Box::new(|news| println!("{news:?}")))?;
    } else {
        thread::spawn(move || fader(heard_at));
    }

    let mut binds = Vec::new();
    for control in &patch.controls {
        println!("move what is to move `{}`; OSC is heard on {heard_at}", control.name);
        learner.forget();
        let source = loop {
            match learner.hear() {
                Some(Heard::Source(source)) => break source,
                Some(Heard::Unfit(what)) => println!("that cannot be bound: {what:?}"),
                None => thread::sleep(Duration::from_millis(10)),
            }
        };
        println!("`{}` is moved by {}", control.name, source.mover());
        binds.push(source.bind(&control.name));
    }

    let after = edit::bindings(&before, &binds)?;
    match file {
        Some(file) => replace::replace(file, before.as_bytes(), after.as_bytes())?,
        None => println!("\n{after}"),
    }
    Ok(())
}

/// Somebody who pushes a fader up.
fn fader(to: SocketAddr) {
    let Ok(socket) = UdpSocket::bind("127.0.0.1:0") else { return };
    for step in 0..=20 {
        thread::sleep(Duration::from_millis(20));
        let args = vec![OscType::Float(0.05 * step as f32)];
        let packet = OscPacket::Message(OscMessage { addr: "/fader/1".into(), args });
        let Ok(bytes) = encode(&packet) else { return };
        let _ = socket.send_to(&bytes, to);
    }
}
