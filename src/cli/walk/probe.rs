//! What is felt on a channel when it is its turn: a tone that suits its actuator and cannot harm it.

use pacinian::Patch;
use pacinian::rig::{Output, OutputKind, Rig};
use pacinian::text::Problems;

/// A tone that comes and goes gently.
const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"A walk over the channels\"\n\
    [voice.probe]\nvoices = 1\noutput = \"felt\"\n[voice.probe.nodes]\n\
    tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
    ramp = { type = \"envelope\", attack = 0.04, release = 0.04 }\n\
    felt = { type = \"multiply\", inputs = [\"tone\", \"ramp\"] }\n";

/// Where nothing is known of the actuator: near what skin feels best.
const USUAL: f64 = 200.0;

/// Below this card and amplifier may not follow, above it hardly anything is felt.
const BAND: [f64; 2] = [30.0, 500.0];

/// Of what an actuator is rated for, at most.
const SHARE: f64 = 0.5;

/// A channel that is to be felt.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The channel, from 1.
    pub channel: u32,
    /// The output that the rig has there, by its place in the rig.
    pub output: Option<usize>,
    /// Hz.
    pub frequency: f64,
    /// Share of full scale.
    pub level: f64,
    /// Whether the level is lower than was asked for, as the actuator is rated for no more.
    pub lowered: bool,
}

/// What plays probes.
pub fn patch() -> Result<Patch, Problems> {
    Patch::parse("walk", PATCH.as_bytes()).map(|checked| checked.value)
}

/// Whether a probe may go there: vibration for the skin, and what is played as it comes. Never a knob's torque or a motor's
/// voltage, nor a pulse to somebody's recorder.
pub fn may_be_felt(output: &Output) -> bool {
    match output.kind {
        OutputKind::Vibration | OutputKind::Raw => true,
        OutputKind::Drive(_) | OutputKind::Torque | OutputKind::Trigger { .. } => false,
    }
}

/// The channels to walk over, in their order; with `all`, also those of which the rig says nothing.
pub fn probes(rig: &Rig, level: f64, all: bool) -> Vec<Probe> {
    let probe = |channel: u32| {
        let at = rig.outputs.iter().position(|output| output.channel == channel);
        let output = at.and_then(|at| rig.outputs.get(at));
        match output {
            Some(output) if !may_be_felt(output) => None,
            None if !all => None,
            _ => {
                let most = output.and_then(|output| bearable(rig, output)).unwrap_or(f64::INFINITY);
                let frequency = output.map_or(USUAL, |output| frequency(rig, output));
                Some(Probe { channel, output: at, frequency, level: level.min(most), lowered: most < level })
            }
        }
    };
    (1..=rig.device.channels).filter_map(probe).collect()
}

/// The rig with nothing on it but what may be felt: its torques and drives are not there.
pub fn bare(rig: &Rig, probes: &[Probe]) -> Rig {
    let mut bare = rig.clone();
    bare.outputs
        .retain(|output| probes.iter().any(|probe| probe.channel == output.channel) && may_be_felt(output));
    for probe in probes.iter().filter(|probe| probe.output.is_none()) {
        bare.outputs.push(Output::tactor(&format!("channel-{}", probe.channel), probe.channel, [0.0; 3]));
    }
    bare
}

/// Its resonance, if that is known and can be felt.
fn frequency(rig: &Rig, output: &Output) -> f64 {
    let actuator = output.actuator.as_ref().and_then(|name| rig.actuator(name));
    let resonance = actuator.and_then(|actuator| actuator.value("resonance"));
    resonance.map_or(USUAL, |hertz| hertz.clamp(BAND[0], BAND[1]))
}

/// The level at which its actuator gets half of what it is rated for, where the rig says enough to know.
fn bearable(rig: &Rig, output: &Output) -> Option<f64> {
    let actuator = rig.actuator(output.actuator.as_ref()?)?;
    let amplifier = output.amplifier.as_ref().map(|name| rig.amplifier(name));
    let gain = match amplifier {
        None => 1.0,
        Some(amplifier) => amplifier?.gain,
    };
    // As if all its peaks were at the frequency of the probe.
    let lifted: f64 = actuator.equaliser.iter().map(|peak| peak.gain_db.max(0.0)).sum();
    let volts = rig.device.full_scale_volts? * gain * output.gain * 10_f64.powf(lifted / 20.0);
    let most = SHARE * actuator.value("rated_volts")? / volts;
    most.is_finite().then_some(most)
}

#[cfg(test)]
mod tests {
    use super::{bare, patch, probes};
    use pacinian::patch::Place;
    use pacinian::{NoAssets, Note, Options, Patch, Player, Rig};

    const RIG: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 7\nfull_scale_volts = 2.0\ncoupling = \"dc\"\n\
        [amplifier.a]\ngain = 5\ncoupling = \"dc\"\n[actuator.coin]\npart = \"coin-10mm\"\n[actuator.slow]\nresonance = 65\nrated_volts = 2\n[actuator.odd]\nresonance = 3000\n\
        equaliser = [{ frequency = 100, gain_db = 6.0206 }]\nrated_volts = 2\n\
        [[tactor]]\nname = \"left\"\nchannel = 1\nactuator = \"slow\"\namplifier = \"a\"\n\
        [[tactor]]\nname = \"right\"\nchannel = 2\nactuator = \"odd\"\ngain = 0.5\n\
        [[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 3\n[[output]]\nkind = \"drive\"\nname = \"motor\"\nchannel = 4\nactuator = \"coin\"\namplifier = \"a\"\n\
        [[output]]\nkind = \"trigger\"\nname = \"eeg\"\nchannel = 5\n[[output]]\nkind = \"raw\"\nname = \"coil\"\nchannel = 7\n";

    fn rig() -> Rig {
        Rig::parse("r", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    }

    #[test]
    fn each_actuator_has_its_own_probe() {
        let told: Vec<_> =
            probes(&rig(), 0.3, false).iter().map(|p| (p.channel, p.frequency, p.lowered)).collect();
        assert_eq!(told, [(1, 65.0, true), (2, 500.0, false), (7, 200.0, false)]);
        let all = probes(&rig(), 0.9, true);
        assert_eq!(all.iter().map(|p| p.channel).collect::<Vec<_>>(), [1, 2, 6, 7]);
        // Half of 2 V: through 2 V a full scale times 5, and through 2 V times a gain of 0.5 times 6 dB.
        assert!((all[0].level - 0.1).abs() < 1e-9 && (all[1].level - 0.5).abs() < 1e-4, "{all:?}");
        assert_eq!((all[2].level, all[3].level), (0.9, 0.9));
    }

    /// What goes out while one channel has its turn: its tone and no more, and nothing on what is no skin's.
    #[test]
    fn only_the_channel_whose_turn_it_is_moves() {
        let rig = rig();
        let probes = probes(&rig, 0.5, true);
        let patch: Patch = patch().unwrap();
        for probe in &probes {
            let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
            let mut player = Player::new(&patch, &bare(&rig, &probes), &options, &NoAssets).unwrap();
            let mut note = Note::default().level(probe.level).duration(0.3).frequency(probe.frequency);
            note.place = Some(Place::Channel(probe.channel));
            player.play_at(0.05, "probe", &note).unwrap();
            let mut out = vec![0.0_f32; 7 * 24_000];
            player.process(&mut out);
            for channel in 1..=7 {
                let peak = out.iter().skip(channel - 1).step_by(7).fold(0.0_f32, |most, x| most.max(x.abs()));
                let gain = if channel == 2 { 0.5 } else { 1.0 };
                if channel == probe.channel as usize {
                    assert!(
                        f64::from(peak) < 1.05 * probe.level * gain * 2.0 && peak > 0.02,
                        "{channel}: {peak}"
                    );
                } else {
                    assert!(peak == 0.0, "{channel} while {} is probed: {peak}", probe.channel);
                }
            }
        }
    }
}
