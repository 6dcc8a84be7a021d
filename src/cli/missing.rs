//! What is missing on this machine for playing live, and how to get it.

#[cfg(target_os = "linux")]
use pacinian::io::device::access;
use pacinian::io::device::priority::{self, Priority};

/// How several sound cards become one device, by what joins them.
pub const JOINING: [(&str, &str); 3] = [
    ("PipeWire", "pactl load-module module-combine-sink; it resamples, so that they stay together"),
    (
        "ALSA",
        "a device of `type multi` in ~/.asoundrc; without a common clock the cards drift apart, by some 50 microseconds a second",
    ),
    ("JACK", "zalsa_out for each further card (package zita-ajbridge); it resamples"),
];

/// What is missing, and what to do, in a line each.
pub fn missing() -> Vec<(String, String)> {
    let mut missing: Vec<(String, String)> = Vec::new();
    let mut say = |what: &str, help: &str| missing.push((what.into(), help.into()));
    #[cfg(target_os = "linux")]
    sound(&mut say);
    // A thread of its own, so that this one stays as it is.
    let raised = std::thread::Builder::new().spawn(priority::raise).map(std::thread::JoinHandle::join);
    if raised.is_ok() && priority::latest() == Priority::Refused {
        say(
            "The system gives no real-time priority, so gaps are likelier.",
            if cfg!(target_os = "linux") {
                "echo '@audio - rtprio 70' | sudo tee /etc/security/limits.d/pacinian.conf; sudo usermod -aG audio $USER; log in again"
            } else {
                "close what else needs the processor, or use larger blocks: --block 512"
            },
        );
    }
    missing
}

#[cfg(target_os = "linux")]
fn sound(say: &mut impl FnMut(&str, &str)) {
    if !std::path::Path::new("/dev/snd").is_dir() {
        return say(
            "This system has no sound hardware: there is no /dev/snd.",
            "plug a card in, or load its driver (sudo modprobe snd-usb-audio); in a container, pass the device: --device /dev/snd",
        );
    }
    if access::forbidden() {
        say("Sound cards may not be used by this user.", access::HELP);
    }
    // In a build with JACK's MIDI, ports are JACK's.
    if cfg!(not(feature = "midi-jack")) && !std::path::Path::new("/dev/snd/seq").exists() {
        say("ALSA has no sequencer, so there are no ports of MIDI.", "sudo modprobe snd-seq");
    }
}
