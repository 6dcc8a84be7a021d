//! A patch that is played while somebody writes it: what is saved takes over, what is broken does not.
//!
//! Plays on the virtual card, so that nobody needs a real one; `Wish::Default.choose()` finds that. Run with
//! `cargo run --release --example live_coding`.

use pacinian::io::device::choose::Chosen;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::watch::Watch;
use pacinian::io::{assets::Folder, events, load};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::text::Problems;
use pacinian::{Options, Rig};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// What is written, one after the other, and at how many seconds it is saved.
const SAVED: [(f64, &str); 3] = [
    (0.5, r#"{ type = "sine", frequency = 120, amplitude = 0.5 }"#),
    (1.2, r#"{ type = "sinus", frequency = 120 }"#),
    (1.9, r#"{ type = "triangle", frequency = 40, amplitude = 0.5 }"#),
];

fn patch(node: &str) -> String {
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"Hum\"\n[voice.hum]\nstart = \"always\"\noutput = \"tone\"\n\
         [voice.hum.nodes]\ntone = {node}\n"
    )
}

/// Reads and compiles what stands in the file. In a thread that may take its time: not in that of the sound.
fn compile(path: &Path) -> Result<Reload, Problems> {
    let folder = Arc::new(Folder::new(path.parent().unwrap_or(Path::new(""))));
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    let reload = Reload::of(load::patch(path)?.value, Rig::default_for(2), &options, &*folder)?;
    Ok(Reload { files: Box::new(move |path| events::open(&folder, path)), ..reload })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::temp_dir().join(format!("pacinian-live-{}.toml", std::process::id()));
    std::fs::write(&path, patch(r#"{ type = "sine", frequency = 80, amplitude = 0.5 }"#))?;
    // From before it is read, so that nothing that is saved meanwhile is missed.
    let mut watch = Watch::of([&path]);
    let (tell, told) = channel();
    let mut session = Session::start(Beginning {
        // In the thread that leads the session, which must not wait for a terminal.
        audience: Box::new(move |told| {
            let line = match told {
                Told::Reloaded => "it plays".to_string(),
                Told::Kept(why, _) => format!("it needs a session of its own: {why}"),
                _ => return,
            };
            let _ = tell.send(line);
        }),
        ..Beginning::of(compile(&path)?, Chosen::Virtual(None))
    })?;
    let (begin, mut saved) = (Instant::now(), SAVED.iter().peekable());
    while begin.elapsed() < Duration::from_millis(2600) {
        if let Some((_, node)) = saved.next_if(|(at, _)| begin.elapsed().as_secs_f64() >= *at) {
            std::fs::write(&path, patch(node))?;
        }
        told.try_iter().for_each(|line| println!("{line}"));
        for changed in watch.look() {
            match compile(&changed) {
                Ok(reload) => session.handle().send(Signal::Reload(Box::new(reload)))?,
                Err(problems) => println!("{problems}"),
            }
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    session.stop();
    std::fs::remove_file(&path)?;
    Ok(())
}
