//! The sound cards of the machine, as its kernel has them: each is listed once, with the channels that it has. Nothing is played on them, but on one of
//! QEMU's, which hangs on nobody.
#![cfg(target_os = "linux")]

mod common;
mod program;
#[path = "common/skipped.rs"]
mod skipped;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Wish;
use pacinian::io::device::keeper::Fate;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::reload::Reload;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use program::Scratch;
use serde_json::Value;

/// The names of the kernel's cards, by their numbers, that have something to play on.
fn cards() -> HashMap<String, String> {
    let card = |entry: std::fs::DirEntry| {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        let number = name.strip_prefix("card")?.to_string();
        path.join("pcm0p").exists().then_some(())?;
        let id = std::fs::read_to_string(path.join("id")).ok()?;
        Some((number, id.trim().to_string()))
    };
    std::fs::read_dir("/proc/asound").into_iter().flatten().flatten().filter_map(card).collect()
}

/// Who has the cards: what is pulled is not there to be listed.
static TURN: Mutex<()> = Mutex::new(());

#[test]
fn every_card_is_listed_once_and_found_by_what_people_call_it() {
    let _turn = TURN.lock();
    let cards = cards();
    if cards.is_empty() {
        return skipped::skipped("there is no sound card (tests/devices/kernel.sh has one)");
    }
    let scratch = Scratch::new("cards");
    let said = scratch.run(&["devices", "--json"]).succeeds().json();
    let hosts = said["hosts"].as_array().unwrap();
    let alsa = hosts.iter().find(|host| host["name"] == "alsa").unwrap();
    let devices: Vec<&Value> = alsa["devices"].as_array().unwrap().iter().collect();
    let offers = |id: &str| {
        let device = devices.iter().find(|device| device["id"] == id);
        device.and_then(|device| device["output"]["channels"].as_array().cloned()).unwrap_or_default()
    };
    let shown = String::from_utf8(scratch.command(&["devices"]).output().unwrap().stdout).unwrap();
    for (number, name) in &cards {
        let id = format!("alsa:hw:CARD={name},DEV=0");
        let all = devices.iter().filter(|device| device["id"] == id.as_str()).count();
        assert_eq!(all, 1, "{id} in {said:#}");
        for again in [format!("alsa:hw:CARD={number},DEV=0"), format!("alsa:plughw:CARD={number},DEV=0")] {
            assert!(devices.iter().all(|device| device["id"] != again.as_str()), "{again} is the same");
        }
        assert!(shown.contains(&id) && !shown.contains(&format!("plughw:CARD={name}")), "{shown}");
        let card = offers(&id);
        let converted = offers(&format!("alsa:plughw:CARD={name},DEV=0"));
        // Somebody else may have it.
        if let (Some(most), Some(more)) = (card.last(), converted.last()) {
            assert!(more.as_u64() <= most.as_u64(), "{more} channels of a card that has {most}");
        }
        // More outputs than any card has: what is looked for is found, and not played on.
        let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 255\n[[tactor]]\nname = \"t2\"\nchannel = 255\n";
        scratch.write("r.toml", rig);
        scratch.write("p.toml", program::GOOD);
        for called in [format!("hw:{number}"), format!("hw:{number},0"), format!("hw:{name}"), id.clone()] {
            let play = ["play", "p.toml", "--rig", "r.toml", "--device", &called, "--duration", "0.1"];
            let err = String::from_utf8(scratch.command(&play).output().unwrap().stderr).unwrap();
            // What it offers is known unless somebody has it.
            let meant = if card.is_empty() { name.as_str() } else { "255 channels are not offered" };
            assert!(err.contains(meant), "{called}: {err}");
        }
    }
}

/// A card that another program plays on keeps nobody waiting who only asks what there is.
#[test]
fn a_card_that_another_program_has_is_listed_at_once() {
    let _turn = TURN.lock();
    if std::env::var_os("PACINIAN_EMULATED").is_none() {
        return skipped::skipped(
            "nothing is played on a card that somebody may hear (tests/devices/kernel.sh has one)",
        );
    }
    let scratch = Scratch::new("held");
    scratch.write("p.toml", program::GOOD);
    let devices: Vec<String> =
        cards().into_values().map(|name| format!("alsa:hw:CARD={name},DEV=0")).collect();
    let play = |device: &String| {
        let play = ["play", "p.toml", "--device", device, "--duration", "120"];
        scratch
            .command(&play)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap()
    };
    let mut others: Vec<_> = devices.iter().map(play).collect();
    std::thread::sleep(Duration::from_secs(4));
    let said = scratch.run(&["devices", "--json"]).succeeds().json();
    let held =
        others.iter_mut().filter_map(|other| other.try_wait().unwrap().is_none().then_some(())).count();
    for mut other in others {
        let _ = other.kill();
        other.wait().unwrap();
    }
    assert!(held > 0, "whoever had a card has it still: {said:#}");
}

/// A card on USB that nobody hears, as QEMU makes it up: its name, and what plugs it in (`1`) and pulls it (`0`), as far as drivers can tell.
fn emulated() -> Option<(String, Plug)> {
    // Elsewhere somebody may hear it.
    std::env::var_os("PACINIAN_EMULATED")?;
    let of = |(number, name): (String, String)| {
        let interface = Path::new("/sys/class/sound").join(format!("card{number}/device"));
        let device = std::fs::canonicalize(interface).ok()?.parent()?.to_path_buf();
        let id = |file: &str| std::fs::read_to_string(device.join(file)).unwrap_or_default();
        (id("idVendor").trim() == "46f4").then(|| (name, Plug(device.join("authorized"))))
    };
    cards().into_iter().find_map(of)
}

/// What plugs a card in, as it is in the end.
struct Plug(PathBuf);

impl Plug {
    fn set(&self, is_in: bool) {
        std::fs::write(&self.0, if is_in { "1" } else { "0" }).unwrap();
    }
}

impl Drop for Plug {
    fn drop(&mut self) {
        let _ = std::fs::write(&self.0, "1");
    }
}

/// Somebody pulls its cable while a voice sounds, and plugs it in again: the session goes on in silence, and then on the same card.
#[test]
fn a_card_that_is_pulled_and_plugged_in_plays_on() {
    let _turn = TURN.lock();
    let Some((name, plug)) = emulated() else {
        return skipped::skipped("there is no USB card of QEMU's (tests/devices/kernel.sh has one)");
    };
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    let text = "[voice.hum]\noutput = \"s\"\nstart = \"always\"\n[voice.hum.nodes]\n\
        s = { type = \"sine\", frequency = 200 }\n";
    let scene = Reload::of(common::patch(text), Rig::default_for(2), &options, &NoAssets).unwrap();
    let device = Wish::Named(format!("hw:{name}")).choose().unwrap_or_else(|error| panic!("{error}"));
    let (told, fates) = channel();
    let session = Session::start(Beginning {
        // Emulated, it is no quicker.
        block: Some(2048),
        fate: Box::new(move |fate| drop(told.send(fate))),
        ..Beginning::of(scene, device)
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let board = session.board();
    let wait = |what: &str, comes: &mut dyn FnMut() -> bool| {
        let begin = Instant::now();
        while !comes() {
            assert!(
                begin.elapsed() < Duration::from_secs(30),
                "{what}: {:?}",
                fates.try_iter().collect::<Vec<_>>()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let plays = || {
        let before = board.frames.get();
        wait("it plays", &mut || board.frames.get() > before + 24_000);
    };
    for round in 0..3 {
        plays();
        assert!(!board.absence().1 && board.voices.get() == 1, "{round}");
        assert_eq!(board.shut.get(), 0, "{round}");
        plug.set(false);
        wait("it is gone", &mut || fates.try_iter().any(|fate| matches!(fate, Fate::Lost(_))));
        assert!(board.absence().1, "{round}");
        // Time goes on, and nothing comes through.
        plays();
        assert_eq!(board.shut.get(), 1, "{round}");
        plug.set(true);
        wait("it is back", &mut || fates.try_iter().any(|fate| fate == Fate::Back));
        assert!(!board.absence().1 && board.absence().0 > 0, "{round}");
    }
    plays();
}
