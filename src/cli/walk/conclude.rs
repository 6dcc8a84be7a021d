//! What a walk comes to: shown, and written down if that is wanted.

use super::Walk;
use super::round::Round;
use crate::cli::ask::Typed;
use crate::cli::failure::Failure;
use crate::cli::table::{Table, many};
use pacinian::edit;
use pacinian::io::replace;
use pacinian::live::walk::map::{Felt, Map, map};
use pacinian::live::walk::probe::Probe;
use pacinian::text::problem::escaped;
use std::collections::BTreeMap;

impl Walk {
    /// Shows what was felt, and writes it down if that is wanted.
    pub fn conclude(
        &self,
        round: &Round<'_>,
        person: &Typed,
        felt: &BTreeMap<u32, Felt>,
        source: &[u8],
    ) -> Result<(), Failure> {
        let (rig, probes, terminal) = (round.rig, round.probes, round.terminal);
        let name = |at: usize| rig.outputs.get(at).map_or("", |output| output.name.as_str());
        let mut table = Table::default();
        table.row(["channel", "the rig says", "felt"]);
        for probe in probes {
            let said = match felt.get(&probe.channel) {
                Some(Felt::Output(output)) => name(*output),
                Some(Felt::Nothing) => "nothing",
                None => "",
            };
            let number = probe.channel.to_string();
            table.row([number.as_str(), probe.output.map_or("", name), said]);
        }
        terminal.print(&format!("\n{}", table.text()))?;
        let written = self.rig.as_ref().filter(|_| self.write);
        let alone = written.map(|path| format!("`{}` was left alone", escaped(&path.display().to_string())));
        let Map { moved, notes, guessed } = map(rig, probes, felt).map_err(|why| {
            let alone = alone.as_ref().map_or_else(String::new, |alone| format!("; {alone}"));
            Failure::said(65, format!("{why}{alone}"))
        })?;
        for note in notes {
            terminal.print(&format!("{note}\n"))?;
        }
        let open = open(probes, felt);
        if moved.is_empty() {
            return terminal.print(&match open {
                None => "the rig is as it was felt\n".into(),
                Some(open) => format!("no tactor was felt elsewhere than the rig says; {open}\n"),
            });
        }
        if let Some(open) = &open {
            terminal.print(&format!("{open}\n"))?;
        }
        let other = many(moved.len(), "tactor");
        let (Some(path), Some(alone)) = (written, alone) else {
            let how = if self.rig.is_some() {
                "--write puts that into the rig"
            } else {
                "a rig can say so: see docs/rig.md"
            };
            return terminal.print(&format!("on other channels than the rig says: {other}; {how}\n"));
        };
        let shown = path.display();
        // What nobody has felt is not written before somebody has agreed to it, or the walk was over and left nothing else.
        if let Some(guess) = guessed.first() {
            if person.keyed {
                let question = format!("write that into {}?", escaped(&shown.to_string()));
                if !round.agrees(person, &question).map_err(Failure::told)? {
                    return terminal.print(&format!("{alone}\n"));
                }
            } else if probes.iter().any(|probe| !felt.contains_key(&probe.channel)) {
                let why = format!(
                    "where `{}` hangs is not known, since nothing was said of a channel",
                    name(*guess)
                );
                return Err(Failure::said(65, format!("{alone}: {why}; walk over all of them")));
            }
        }
        let before = String::from_utf8_lossy(source);
        let after = edit::channels(&before, rig, &moved)
            .map_err(|why| Failure::said(78, format!("{alone}: {why}; change its channels by hand")))?;
        replace::replace(path, source, after.as_bytes())?;
        terminal.print(&format!("{}: {other} on other channels now\n", escaped(&shown.to_string())))
    }
}

/// Which channels are still not known after what was felt, in words.
fn open(probes: &[Probe], felt: &BTreeMap<u32, Felt>) -> Option<String> {
    let which = |wanted: Option<Felt>| {
        let of = probes.iter().filter(|probe| felt.get(&probe.channel).copied() == wanted);
        let channels: Vec<String> = of.map(|probe| probe.channel.to_string()).collect();
        let word = if channels.len() == 1 { "channel" } else { "channels" };
        (!channels.is_empty()).then(|| format!("{word} {}", channels.join(", ")))
    };
    let nothing = which(Some(Felt::Nothing)).map(|channels| format!("nothing was felt on {channels}"));
    let unsaid = which(None).map(|channels| format!("nothing was said of {channels}"));
    let both: Vec<String> = nothing.into_iter().chain(unsaid).collect();
    (!both.is_empty()).then(|| both.join("; "))
}
