//! Which tactor hangs on which channel, after what was felt.

use super::probe::{Probe, may_be_felt};
use crate::rig::{Output, Rig};
use std::collections::{BTreeMap, BTreeSet};

/// What was felt on a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Felt {
    /// An output of the rig.
    Output(usize),
    /// Nothing.
    Nothing,
}

/// The channels of outputs, by their places in the rig, and what is to be said about them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Map {
    /// Outputs that are on another channel than the rig says.
    pub moved: BTreeMap<usize, u32>,
    /// Sentences.
    pub notes: Vec<String>,
    /// Outputs that are where a channel was left, without having been felt there.
    pub guessed: Vec<usize>,
}

/// What follows from what was felt, by channel.
///
/// # Errors
/// That it contradicts itself.
pub fn map(rig: &Rig, probes: &[Probe], felt: &BTreeMap<u32, Felt>) -> Result<Map, String> {
    let name = |at: usize| rig.outputs.get(at).map_or("", |output| output.name.as_str());
    let mut at: BTreeMap<usize, u32> = BTreeMap::new();
    for (channel, felt) in felt {
        if let Felt::Output(output) = felt
            && let Some(other) = at.insert(*output, *channel)
        {
            return Err(format!(
                "`{}` was felt on channels {other} and {channel}: walk over these again, `--only {other}` and `--only {channel}`",
                name(*output)
            ));
        }
    }
    let mut map = Map::default();
    // Channels that are taken: by what was felt, and by what is never felt.
    let mut taken: BTreeSet<u32> = at.values().copied().collect();
    taken.extend(rig.outputs.iter().filter(|output| !may_be_felt(output)).map(|output| output.channel));
    taken.extend(rig.outputs.iter().filter_map(Output::direction));
    let rest: Vec<usize> = (0..rig.outputs.len())
        .filter(|n| rig.outputs.get(*n).is_some_and(may_be_felt) && !at.contains_key(n))
        .collect();
    let (stay, displaced): (Vec<usize>, Vec<usize>) = rest
        .into_iter()
        .partition(|n| rig.outputs.get(*n).is_some_and(|output| taken.insert(output.channel)));
    for output in &stay {
        let channel = rig.outputs.get(*output).map_or(0, |output| output.channel);
        if felt.get(&channel) == Some(&Felt::Nothing) {
            map.notes.push(format!("`{}` was felt nowhere; it stays on channel {channel}", name(*output)));
        }
    }
    // Where nothing was felt first, since what is felt nowhere may well hang there; then the rest of those that were walked over.
    let silent = felt.iter().filter(|(_, felt)| **felt == Felt::Nothing).map(|(channel, _)| *channel);
    let walked = probes.iter().map(|probe| probe.channel);
    let free: Vec<u32> = silent.chain(walked).chain(1..=rig.device.channels).collect();
    for output in displaced {
        let Some(channel) = free.iter().copied().find(|channel| taken.insert(*channel)) else {
            return Err(format!("no channel is left for `{}`: walk over all of them", name(output)));
        };
        map.notes.push(format!(
            "`{}` was felt nowhere, and its channel is another's: it is put on channel {channel}, which is left; feel whether it is there",
            name(output)
        ));
        map.guessed.push(output);
        at.insert(output, channel);
    }
    at.retain(|output, channel| rig.outputs.get(*output).is_some_and(|output| output.channel != *channel));
    map.moved = at;
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::{Felt, map};
    use crate::Rig;
    use crate::live::walk::probe::probes;
    use crate::rig::OutputKind;
    use std::collections::{BTreeMap, BTreeSet};

    fn told(rig: &Rig, felt: &[(u32, Option<usize>)]) -> Result<Vec<(usize, u32)>, String> {
        let felt = felt.iter().map(|(c, f)| (*c, f.map_or(Felt::Nothing, Felt::Output))).collect();
        map(rig, &probes(rig, 0.1, true), &felt).map(|map| map.moved.into_iter().collect())
    }

    #[test]
    fn what_was_felt_moves_and_what_was_not_stays_out_of_its_way() {
        let rig = Rig::default_for(4);
        assert_eq!(told(&rig, &[]), Ok(vec![]));
        assert_eq!(told(&rig, &[(1, Some(0)), (2, Some(1))]), Ok(vec![]));
        // Two pairs of jacks change places.
        let swapped = [(1, Some(2)), (2, Some(3)), (3, Some(0)), (4, Some(1))];
        assert_eq!(told(&rig, &swapped), Ok(vec![(0, 3), (1, 4), (2, 1), (3, 2)]));
        // The fourth stays, as nobody took its channel; for the first, the second channel is left.
        assert_eq!(told(&rig, &[(1, Some(2)), (3, Some(1)), (4, None)]), Ok(vec![(0, 2), (1, 3), (2, 1)]));
        assert!(
            told(&rig, &[(1, Some(2)), (3, Some(2))])
                .unwrap_err()
                .contains("`t3` was felt on channels 1 and 3")
        );
    }

    #[test]
    fn whatever_was_felt_no_two_share_a_channel_and_a_knob_stays() {
        let mut rig = Rig::default_for(5);
        rig.outputs[4].kind = OutputKind::Torque;
        rig.outputs.pop();
        rig.outputs.push(crate::rig::Output {
            kind: OutputKind::Torque,
            ..crate::rig::Output::tactor("knob", 5, [0.0; 3])
        });
        // Every answer that may be given on four channels: one of four tactors, nothing, or none yet.
        for code in 0..6_usize.pow(4) {
            let felt: BTreeMap<u32, Felt> = (0..4)
                .filter_map(|n| match code / 6_usize.pow(n) % 6 {
                    5 => None,
                    4 => Some((n + 1, Felt::Nothing)),
                    output => Some((n + 1, Felt::Output(output))),
                })
                .collect();
            let Ok(map) = map(&rig, &probes(&rig, 0.1, false), &felt) else { continue };
            let channel = |n: usize| map.moved.get(&n).copied().unwrap_or(rig.outputs[n].channel);
            assert_eq!((0..5).map(channel).collect::<BTreeSet<_>>().len(), 5, "{felt:?}");
            assert_eq!(channel(4), 5);
            for (at, felt) in felt {
                assert!(felt == Felt::Nothing || matches!(felt, Felt::Output(n) if channel(n) == at));
            }
        }
    }
}
