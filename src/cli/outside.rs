//! What plays a patch and moves its controls from outside: keys, MIDI, OSC; for people and for programs.

use super::table::Table;
use pacinian::midi::pitch;
use pacinian::patch::{Bind, Mover, Patch, Source, Spread, Trigger};
use serde::Serialize;

/// A trigger or a binding.
#[derive(Debug, Serialize)]
pub struct OutsideReport {
    from: String,
    /// The MIDI channel, from 1; null for any.
    channel: Option<u8>,
    /// The lowest and the highest note; null for any.
    notes: Option<[u8; 2]>,
    /// The voice or pattern that it plays.
    plays: Option<String>,
    /// "notes", "channels" or "controller N", where it is spread over the tactors by these.
    spread: Option<String>,
    /// The control that it moves.
    moves: Option<String>,
    /// What its ends become, in the control's unit.
    range: Option<[f64; 2]>,
    /// Whether the control waits until it has come to where that stands.
    pickup: Option<bool>,
}

/// Lines, at most.
const SHOWN: usize = 16;

/// What sets it off from outside, in words; `None` for what is no live source.
pub fn words(on: &Source) -> Option<String> {
    Some(match on {
        Source::Key(key) => format!("key {key}"),
        Source::MidiNote => "notes of MIDI".into(),
        Source::MidiProgram(program) => format!("program {program} of MIDI"),
        Source::MidiController { number, .. } => format!("controller {number} of MIDI"),
        Source::Osc(address) => format!("OSC to {address}"),
        Source::Start | Source::Knob { .. } | Source::Node { .. } => return None,
    })
}

/// All of a patch: triggers, then bindings, in its order.
pub fn all(patch: &Patch) -> Vec<OutsideReport> {
    let triggers = patch.triggers.iter().filter_map(OutsideReport::of_trigger);
    triggers.chain(patch.binds.iter().map(|bind| OutsideReport::of_bind(bind, patch))).collect()
}

/// As lines for people.
pub fn lines(all: &[OutsideReport]) -> String {
    let mut table = Table::default();
    all.iter().take(SHOWN).for_each(|report| table.row(report.row()));
    if all.len() > SHOWN {
        table.row(["...".into(), format!("and {} more", all.len() - SHOWN)]);
    }
    table.text()
}

impl OutsideReport {
    fn of_trigger(trigger: &Trigger) -> Option<Self> {
        let from = match &trigger.on {
            Source::MidiController { rises, threshold, .. } => {
                format!("{} {} {threshold}", words(&trigger.on)?, if *rises { "rises" } else { "falls" })
            }
            on => words(on)?,
        };
        Some(Self {
            from,
            channel: trigger.channel,
            notes: trigger.notes,
            plays: Some(trigger.play.clone()),
            spread: match trigger.spread {
                Spread::Off => None,
                Spread::Notes => Some("notes".into()),
                Spread::Channels => Some("channels".into()),
                Spread::Controller(number) => Some(format!("controller {number}")),
            },
            moves: None,
            range: None,
            pickup: None,
        })
    }

    fn of_bind(bind: &Bind, patch: &Patch) -> Self {
        let from = match &bind.from {
            Mover::Controller(number) => {
                let encoder = bind.encoder.map(|encoder| format!(", an encoder ({})", encoder.name()));
                format!("controller {number} of MIDI{}", encoder.unwrap_or_default())
            }
            Mover::Bend => "bend of MIDI".into(),
            Mover::Pressure => "pressure of MIDI".into(),
            Mover::Osc { address, argument: 1 } => format!("OSC to {address}"),
            Mover::Osc { address, argument } => format!("number {argument} of OSC to {address}"),
        };
        let control = patch.controls.iter().find(|control| control.name == bind.control);
        Self {
            from,
            channel: bind.channel,
            notes: None,
            plays: None,
            spread: None,
            moves: Some(bind.control.clone()),
            range: control.map(|control| [0.0, 1.0].map(|position| bind.value(control, position))),
            pickup: Some(bind.pickup && bind.encoder.is_none()),
        }
    }

    fn row(&self) -> [String; 3] {
        let channel = self.channel.map(|channel| format!(" on channel {channel}")).unwrap_or_default();
        let name = |note: u8| pitch::name(note).unwrap_or_else(|| note.to_string());
        let notes = self.notes.map(|[low, high]| format!(" from {} to {}", name(low), name(high)));
        let from = format!("{}{}{channel}", self.from, notes.unwrap_or_default());
        if let Some(plays) = &self.plays {
            let spread = self.spread.as_ref().map(|by| format!("spread over the tactors by {by}"));
            return [from, format!("plays {plays}"), spread.unwrap_or_default()];
        }
        let range = self.range.map(|[low, high]| format!("from {low} to {high}")).unwrap_or_default();
        let pickup = if self.pickup == Some(true) { ", with pick-up" } else { "" };
        let moves = self.moves.as_deref().unwrap_or_default();
        [from, format!("moves {moves}"), format!("{range}{pickup}")]
    }
}
