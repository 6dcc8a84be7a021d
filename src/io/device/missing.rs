//! What is missing on this machine for playing live, and how to get it.

use super::access;
use super::priority;

/// How several sound cards become one device: what joins them, and how, in a line each; `docs/cards.md` has the whole of it.
pub const JOINING: [(&str, &str); 4] = [
    (
        "PipeWire",
        "libpipewire-module-combine-stream in ~/.config/pipewire/pipewire.conf.d; it resamples, so that cards stay together (module-combine-sink alone \
         plays the same on all)",
    ),
    (
        "PulseAudio",
        "module-remap-sink for each card, with aux0,aux1,... and aux8,aux9,..., and module-combine-sink over them with channels=16; it resamples",
    ),
    (
        "ALSA",
        "a device of `type multi` in ~/.asoundrc; without a common clock the cards drift apart, and every few minutes there is an xrun",
    ),
    (
        "JACK",
        "jackd -d dummy -P 0, zalsa_out for each card (package jackd2), and ports connected by hand; it resamples",
    ),
];

/// What this machine has of what playing live needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Machine {
    /// Whether the system knows of hardware of sound at all.
    pub cards: bool,
    /// Whether it keeps this user from it.
    pub forbidden: bool,
    /// Whether ports of MIDI are there to be had.
    pub ports: bool,
    /// Whether a callback may come before all others.
    pub real_time: bool,
}

impl Machine {
    /// The one that this runs on. It asks for real-time priority, in a thread of its own, to see whether there is any.
    pub fn this() -> Self {
        // A thread of its own, so that this one stays as it is; where there is none, nothing is known.
        let asked = std::thread::Builder::new().spawn(priority::rises);
        let real_time = asked.map_or(true, |asked| asked.join().unwrap_or(true));
        #[cfg(target_os = "linux")]
        return Self {
            cards: std::path::Path::new("/dev/snd").is_dir(),
            forbidden: access::forbidden(),
            // In a build with JACK's MIDI, ports are JACK's.
            ports: cfg!(feature = "midi-jack") || std::path::Path::new("/dev/snd/seq").exists(),
            real_time,
        };
        #[cfg(not(target_os = "linux"))]
        Self { cards: true, forbidden: false, ports: true, real_time }
    }

    /// What is missing, and what to do about it, in a line each.
    pub fn lacks(&self) -> Vec<(&'static str, &'static str)> {
        let all = [
            (
                !self.cards,
                "This system has no sound hardware: there is no /dev/snd.",
                "plug a card in, or load its driver (sudo modprobe snd-usb-audio); in a container, pass the device: --device /dev/snd",
            ),
            (self.cards && self.forbidden, "Sound cards may not be used by this user.", access::HELP),
            (
                self.cards && !self.ports,
                "ALSA has no sequencer, so there are no ports of MIDI.",
                "sudo modprobe snd-seq",
            ),
            (
                !self.real_time,
                "The system gives no real-time priority, so gaps are likelier.",
                if cfg!(target_os = "linux") {
                    "echo '@audio - rtprio 70' | sudo tee /etc/security/limits.d/pacinian.conf; sudo usermod -aG audio $USER; log in again"
                } else {
                    "close what else needs the processor, or use larger blocks: --block 512"
                },
            ),
        ];
        all.into_iter().filter(|(lacks, ..)| *lacks).map(|(_, what, help)| (what, help)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Machine;

    #[test]
    fn each_thing_that_is_missing_is_told_with_what_mends_it() {
        let whole = Machine { cards: true, forbidden: false, ports: true, real_time: true };
        assert!(whole.lacks().is_empty());
        let said = |machine: Machine| {
            let all = machine.lacks();
            assert_eq!(all.len(), 1, "{all:?}");
            assert!(!all[0].1.contains('\n'), "in one line");
            format!("{} {}", all[0].0, all[0].1)
        };
        // Without hardware there is no user whom it could be kept from, and nothing that a sequencer would help.
        let bare = said(Machine { cards: false, forbidden: true, ports: false, ..whole });
        assert!(bare.contains("no sound hardware") && bare.contains("sudo modprobe snd-usb-audio"));
        let kept = said(Machine { forbidden: true, ..whole });
        assert!(kept.contains("may not be used by this user") && kept.contains("usermod -aG audio"));
        let silent = said(Machine { ports: false, ..whole });
        assert!(silent.contains("no ports of MIDI") && silent.contains("sudo modprobe snd-seq"));
        let late = said(Machine { real_time: false, ..whole });
        assert!(late.contains("no real-time priority"));
        assert_eq!(late.contains("limits.d"), cfg!(target_os = "linux"));
        let all = Machine { cards: true, forbidden: true, ports: false, real_time: false }.lacks();
        assert_eq!(all.len(), 3);
    }
}
