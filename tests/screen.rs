//! What `pacinian play` shows, in a terminal of its own.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod program;
mod seat;

use std::io::Read;
use std::num::NonZero;
use std::time::Instant;

use program::Scratch;
use rustix::termios::{LocalModes, tcgetattr};
use seat::{PATIENCE, Seat, resize};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title = "Two hands"

[voice.tap]
output = "wave"

[voice.tap.nodes]
wave = { type = "sine", frequency = 200 }

[pattern.left]
events = [{ at = 0, voice = "tap", duration = 0.1 }]
repeat = { every = 0.2, times = 10000 }

[pattern.right]
events = [{ at = 0, voice = "tap", duration = 0.1, level = 0.5 }]
repeat = { every = 0.3, times = 10000 }
"#;

/// What a session leaves beside its patch.
const JOURNAL: &str = "e.jsonl";

/// Plays in front of a terminal of that size.
fn sit(name: &str, columns: u16, rows: u16, term: &str, owned: bool) -> Option<(Scratch, Seat)> {
    let scratch = Scratch::new(&format!("screen-{name}"));
    scratch.write("patch.toml", PATCH);
    let words = ["play", "patch.toml", "--device", "virtual", "--pattern", "left", "--events", JOURNAL];
    let command = scratch.command(&words);
    Seat::at(&command, (columns, rows), term, owned).map(|seat| (scratch, seat))
}

#[test]
fn keys_do_what_the_screen_says() {
    let Some((_scratch, mut seat)) = sit("keys", 100, 30, "xterm-256color", true) else { return };
    seat.see("first pattern", |text| text.contains("1 ▶ left") && text.contains("tap on t1"));
    let text = seat.see("meter", |text| text.contains("██"));
    for part in ["Two hands", "virtual card", "load", "latency", "xruns ", "2 right", "ARMED", "q end"] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
    // The block of the virtual card, 128 frames, and what the engine takes: the latest onset within a sample of 1/8,000 s, and the band limit.
    let line = text.lines().find(|line| line.contains("latency")).unwrap();
    let figure = |name: &str| -> f64 {
        let rest = line.split(name).nth(1).unwrap_or_else(|| panic!("no `{name}` in {line}"));
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        rest[..end].parse().unwrap_or_else(|_| panic!("{name}: {line}"))
    };
    let [all, block, engine, device] = ["latency ", "block ", "engine ", "device "].map(figure);
    // By how much callbacks have come early so far is in it.
    assert!((2.7..3.2).contains(&block), "{line}");
    assert!((1.0..1.7).contains(&engine) && (all - block - engine - device).abs() < 0.02, "{line}");
    // It holds the block that it plays while the next is asked for.
    assert!((device - 2.67).abs() < 0.01, "{line}");
    seat.press("2");
    seat.see("second pattern", |text| text.contains("2 ▶ right"));
    seat.press("1");
    seat.see("end of the first", |text| text.contains("1 left") && text.contains("2 ▶ right"));
    seat.press(" ");
    seat.see("end of all", |text| text.contains("2 right"));
    seat.press("a");
    seat.see("-20 dB", |text| text.lines().next().is_some_and(|line| line.trim_end().ends_with("-20 dB")));
    seat.press("p");
    seat.see("panic", |text| text.contains("PANIC: the output is shut") && text.contains("SHUT"));
    seat.see("what the device holds", |text| text.contains("the device still held 2.7 ms"));
    seat.press("c");
    seat.see("calm", |text| {
        !text.contains("SHUT") && text.contains("open again; patterns were stopped: 1 or space starts them")
    });
    // A smaller window is filled anew.
    resize(seat.keyboard.as_ref().unwrap(), 50, 12);
    let size = |n| NonZero::new(n).unwrap();
    seat.screen.lock().unwrap().screen_mut().set_size(size(12), size(50));
    let fits = |text: &str| text.lines().last().is_some_and(|line| line.starts_with(" p panic"));
    seat.see("all in a smaller window", |text| fits(text) && text.lines().count() == 12);
    assert!(!seat.is_given_back_now());
    seat.press("q");
    assert!(seat.end().success());
    assert!(seat.is_given_back());
    let after = seat.see("summary", |text| text.contains("frames"));
    assert!(!after.contains("PANIC"), "{after}");
}

/// A pattern whose one event sounds for long plays for as long: its key stops it, and does not play it once more.
#[test]
fn what_sounds_for_long_stops_with_its_pattern() {
    let scratch = Scratch::new("screen-long");
    scratch.write(
        "patch.toml",
        PATCH.replace("duration = 0.1 }]", "duration = 600 }]").replace("\nrepeat", "\n#"),
    );
    let command = scratch.command(&["play", "patch.toml", "--device", "virtual", "--pattern", "left"]);
    let Some(mut seat) = Seat::at(&command, (100, 30), "xterm-256color", true) else { return };
    let voices = |count: u32| move |text: &str| text.contains(&format!("voices {count} "));
    seat.see("it plays", |text| voices(1)(text) && text.contains("1 ▶ left"));
    seat.press("1");
    seat.see("it has stopped", |text| voices(0)(text) && text.contains("1 left"));
    seat.press(" ");
    seat.see("it plays again", |text| voices(1)(text) && text.contains("1 ▶ left"));
    // Another key: the same at once would be one that repeats.
    seat.press("1");
    seat.see("it has stopped again", |text| voices(0)(text) && text.contains("1 left"));
    seat.press("q");
    assert!(seat.end().success());
}

/// And who that was, is in the journal.
#[test]
fn whoever_ends_it_gets_the_terminal_back() {
    let ends = [
        ("TERM", 143, "system", "SIGTERM"),
        ("INT", 130, "system", "SIGINT"),
        ("HUP", 129, "system", "SIGHUP"),
        ("\x03", 130, "key", "Ctrl-C"),
        ("q", 0, "key", "q"),
    ];
    for (how, code, source, name) in ends {
        let Some((scratch, mut seat)) = sit("end", 80, 24, "xterm-256color", true) else { return };
        seat.see("screen", |text| text.contains("▶ left"));
        match how {
            "\x03" | "q" => seat.press(how),
            signal => seat.signal(signal),
        }
        assert_eq!(seat.end().code(), Some(code), "{how:?}");
        assert!(seat.is_given_back(), "{how:?}");
        let journal = std::fs::read_to_string(scratch.0.join(JOURNAL)).unwrap();
        let end = journal.lines().rfind(|line| line.contains("\"message\":\"end\"")).unwrap();
        for said in [format!("\"source\":\"{source}\""), format!("\"name\":\"{name}\"")] {
            assert!(end.contains(&said), "{how:?}: {end}");
        }
    }
}

/// A rig whose knob is said to be where the person types: neither by that name nor by another is it opened.
#[test]
fn the_terminal_is_no_knob() {
    for port in ["/dev/tty", "/dev/stdin"] {
        let scratch = Scratch::new("screen-knob");
        let effects = "[knob.effects]\nd = { type = \"damper\", damping = 1e-4 }\n";
        scratch.write("patch.toml", format!("{PATCH}{effects}"));
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nrate = 48000\n[[tactor]]\nname = \"t1\"\nchannel = 1\n[knob]\ninertia = 2e-5\nviscous = 2e-3\n\
             peak_torque = 0.05\nstale = 5\ndelay = 0.3\ncontroller = {{ type = \"odrive\", port = \"{port}\" }}\n"
        );
        scratch.write("rig.toml", rig);
        let command = scratch.command(&["play", "patch.toml", "--rig", "rig.toml", "--device", "virtual"]);
        let Some(mut seat) = Seat::at(&command, (160, 60), "xterm-256color", true) else { return };
        assert_eq!(seat.end().code(), Some(69), "{}", seat.contents());
        let told = seat.see("error", |text| text.contains("`pacinian devices` lists"));
        assert!(told.contains(&format!("{port} is the terminal that this program runs in")), "{told}");
        assert!(seat.is_given_back());
    }
}

#[test]
fn a_closed_terminal_ends_it() {
    // With the signal that the system sends then, and without.
    for owned in [true, false] {
        let Some((_scratch, mut seat)) = sit("closed", 80, 24, "xterm-256color", owned) else { return };
        if !owned {
            // Nobody reads in its own thread here, so that this end is the only one.
            let (begin, mut bytes) = (Instant::now(), [0; 4096]);
            while !seat.contents().contains("▶ left") && begin.elapsed() < PATIENCE {
                let count = seat.keyboard.as_mut().unwrap().read(&mut bytes).unwrap();
                seat.screen.lock().unwrap().process(&bytes[..count]);
            }
            drop(seat.keyboard.take());
        } else {
            seat.see("screen", |text| text.contains("▶ left"));
            seat.signal("HUP");
        }
        assert_eq!(seat.end().code(), Some(129), "{owned}");
    }
}

#[test]
fn where_a_screen_makes_no_sense_there_are_lines() {
    for (columns, rows, term) in [(20, 5, "xterm-256color"), (100, 30, "dumb")] {
        let Some((_scratch, mut seat)) = sit("lines", columns, rows, term, true) else { return };
        seat.see("events", |text| text.replace('\n', "").contains("tap on t1"));
        assert!(!seat.screen.lock().unwrap().screen().alternate_screen());
        assert!(tcgetattr(&seat.line).unwrap().local_modes.contains(LocalModes::ICANON));
        // Through the terminal, as the keys are not read.
        seat.press("\x03");
        assert_eq!(seat.end().code(), Some(130));
    }
}

/// Somebody shuts the output over OSC; whoever wants silence at the keyboard must not open it.
#[test]
fn a_panic_from_elsewhere_is_opened_by_no_key_that_shuts() {
    use rosc::{OscMessage, OscPacket, OscType, encoder};
    let port = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
    let scratch = Scratch::new("screen-elsewhere");
    scratch.write(
        "patch.toml",
        PATCH
            .replace("[voice.tap]", "[control.depth]\ndefault = 0.5\nunit = \"m\"\n[voice.tap]")
            .replace("frequency = 200", "frequency = \"400 * depth\""),
    );
    let command =
        scratch.command(&["play", "patch.toml", "--device", "virtual", "--pattern", "left", "--osc", &port]);
    let Some(mut seat) = Seat::at(&command, (100, 30), "xterm-256color", true) else { return };
    seat.shows("1 ▶ left");
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let say = |addr: &str, args: Vec<OscType>| {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args });
        socket.send_to(&encoder::encode(&packet).unwrap(), format!("127.0.0.1:{port}")).unwrap();
    };
    say("/panic", vec![]);
    seat.shows("SHUT");
    for (key, then) in [("p", "at -20 dB"), ("\x1b", "armed: full level")] {
        seat.press(key);
        std::thread::sleep(std::time::Duration::from_millis(700));
        // The key behind it was heard, and so was that one.
        seat.press("a");
        let text = seat.shows(then);
        assert!(text.contains("SHUT") && !text.contains("open again"), "{text}");
    }
    // What plays now is not felt, and says so.
    say("/voice/tap/play", vec![]);
    seat.shows("not felt: the output is shut");
    seat.press("c");
    seat.shows("the output is open again; patterns were stopped: 1 or space starts them");
    seat.press("1");
    seat.shows("1 ▶ left");
    // Controls are seen, and follow the arrows and whoever else moves them.
    seat.shows("0.5 m");
    seat.press("\x1b[C");
    seat.shows("0.52 m");
    seat.press("\x1b[1;2C");
    seat.shows("0.62 m");
    say("/control/depth", vec![OscType::Float(0.25)]);
    seat.shows("0.25 m");
    seat.press("0");
    seat.shows("0.5 m");
    seat.press("q");
    assert!(seat.end().success());
}

/// The simulated knob of a patch, turned by keys: the hand is the control that the arrows move, and the dial goes with it.
#[test]
fn a_knob_is_turned_by_keys_and_its_dial_goes_with_it() {
    let scratch = Scratch::new("screen-knob");
    let knob = "[knob.effects]\nnotches = { type = \"detents\", count = 24, torque = 0.004 }\n\
        [voice.click]\noutput = \"o\"\nnodes.o = { type = \"sine\", frequency = 200, amplitude = \"e\" }\n\
        nodes.e = { type = \"envelope\", decay = 0.01, sustain = 0 }\n\
        [[trigger]]\non = \"knob.detent\"\nplay = \"click\"\n[control.depth]\ndefault = 1\n";
    scratch.write("patch.toml", format!("format = \"pacinian-patch/1\"\ntitle = \"Dial\"\n{knob}"));
    let command = scratch.command(&["knob", "patch.toml", "--keys"]);
    // What the dial says of the angle, rad.
    let angle = |text: &str| -> Option<f64> {
        let line =
            text.lines().find(|line| line.trim_start().starts_with("knob ") && line.contains("rad/s"))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let unit = words.iter().position(|word| *word == "rad")?;
        words[unit - 1].parse().ok()
    };
    // With q, and with Ctrl-C.
    for (key, success) in [("q", true), ("\x03", false)] {
        let Some(mut seat) = Seat::at(&command, (100, 30), "xterm-256color", true) else { return };
        seat.see("the dial", |text| {
            angle(text).is_some_and(|angle| angle.abs() < 0.1) && text.contains("mN m")
        });
        // Right: two steps of a fiftieth of two turns either way.
        seat.press("\x1b[C\x1b[C");
        seat.see("a turn", |text| angle(text).is_some_and(|angle| angle > 0.3) && text.contains("click"));
        seat.press("0");
        seat.see("the way back", |text| angle(text).is_some_and(|angle| angle.abs() < 0.15));
        // It begins with its torque, and has it back.
        seat.press("t");
        seat.see("no torque", |text| text.contains("the knob's torque is off") && text.contains("t torque"));
        // Sooner, it would be taken for a key that is held down.
        std::thread::sleep(std::time::Duration::from_millis(400));
        seat.press("t");
        seat.see("torque", |text| {
            text.contains("the simulated knob has its torque") && text.contains("t no torque")
        });
        seat.press(key);
        assert_eq!(seat.end().success(), success);
        assert!(seat.is_given_back());
        // What it did is said where the shell goes on.
        let text = seat.shows("what it did");
        let row = |head: &str| {
            let line = text.lines().find(|line| line.trim_start().starts_with(head));
            line.unwrap_or_else(|| panic!("no {head} in\n{text}")).split_whitespace().collect::<Vec<_>>()
        };
        let turned = row("turned");
        let to = turned.iter().position(|word| *word == "to").unwrap();
        let most: f64 = turned[to + 1].parse().unwrap();
        assert!((0.3..1.0).contains(&most), "{turned:?}");
        let speed: f64 = row("speed")[1].parse().unwrap();
        assert!(speed > 0.5, "{text}");
        // Forth and back: two notches at least each way.
        let set_off = row("set off");
        let times: usize = set_off[set_off.len() - 2].parse().unwrap();
        assert!(set_off.contains(&"knob.detent") && times >= 2, "{set_off:?}");
    }
}
