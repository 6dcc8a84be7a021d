//! A session that is played from threads of a program's own: voices, controls and patterns, now and at a time, a look at how it stands, and
//! the stop at once.
//!
//! Plays on the virtual card, so that nobody needs a real one; `Wish::Default.choose()` finds that, on which it is at -20 dB until it is armed. Run with
//! `cargo run --release --example handle`.

use std::error::Error;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use pacinian::io::device::choose::Chosen;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::live::stamp::Stamp;
use pacinian::{NoAssets, Note, Options, Patch, Rig};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title = "A hand"

[control.strength]
default = 0.8
smoothing = 0.02

[voice.buzz]
output = "felt"
[voice.buzz.nodes]
tone = { type = "sine", frequency = "event.frequency", amplitude = "strength" }
edge = { type = "envelope", attack = 0.005, release = 0.03 }
felt = { type = "multiply", inputs = ["tone", "edge"] }

# Where there is a trigger, no pattern begins by itself: this one on the key 1 of `pacinian play`.
[[trigger]]
on = "key.1"
play = "roll"

[pattern.roll]
events = [{ at = 0, voice = "buzz", duration = 0.05, repeat = { every = 0.1, times = 5 } }]
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let (patch, rig) = (Patch::parse("hand.toml", PATCH.as_bytes())?.value, Rig::default_for(4));
    let scene = Reload::of(patch, rig, &Options::for_card(48_000.0), &NoAssets)?;
    let (tell, told) = channel();
    let mut session = Session::start(Beginning {
        // In the thread that leads the session, which must not wait for a terminal.
        audience: Box::new(move |told| {
            let line = match told {
                Told::Report(Report { deed: Deed::Event { at, due, .. }, .. }, _) => {
                    format!("at engine sample {}, due at {}", at.sample, due.sample)
                }
                Told::Refused(problem, _) => format!("refused: {problem}"),
                _ => return,
            };
            let _ = tell.send(line);
        }),
        ..Beginning::of(scene, Chosen::Virtual(None))
    })?;

    // A handle is cheap to clone, can be used from any thread but the audio callback's own, and never waits for anybody.
    let handle = session.handle();
    let finger = thread::spawn({
        let handle = handle.clone();
        move || -> Result<(), pacinian::live::signal::Refused> {
            let held =
                handle.play("buzz", Note::default().at_place("t2").level(0.7).duration(f64::INFINITY))?;
            thread::sleep(Duration::from_millis(300));
            handle.set("strength", 0.3)?;
            thread::sleep(Duration::from_millis(200));
            handle.release(held)
        }
    });
    finger.join().map_err(|_| "the finger's thread has panicked")??;

    // A pattern at a time that is still to come, and stopped by its number.
    let soon = Stamp(handle.epoch().now().0 + 100_000_000);
    let number = handle.number();
    handle.send_at(soon, Signal::Start(number, "roll".into()))?;
    thread::sleep(Duration::from_millis(400));
    handle.stop(number)?;

    // What the patch does not have is refused, and the session goes on.
    handle.play("hum", Note::default())?;
    thread::sleep(Duration::from_millis(50));
    told.try_iter().for_each(|line| println!("  {line}"));
    let board = session.board();
    println!(
        "{} voices so far, {} events late, {:.2} % of a core",
        board.started.get(),
        board.late.get(),
        100.0 * board.load.mean()
    );
    // Exact zeros within 2 ms, and nothing sounds any more until it is taken back.
    handle.panic();
    session.stop();
    Ok(())
}
