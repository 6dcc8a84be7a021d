//! The sound cards of the machine, as its kernel has them: each is listed once, with the channels that it has. Nothing is played on them.
#![cfg(target_os = "linux")]

mod program;
#[path = "common/skipped.rs"]
mod skipped;

use std::collections::HashMap;

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

#[test]
fn every_card_is_listed_once_and_found_by_what_people_call_it() {
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
