//! What is felt on a channel when it is its turn: a tone, or a short turn of a motor, that suits its actuator and cannot harm it.

use std::f64::consts::SQRT_2;

use crate::rig::{Output, OutputKind, Rig, Shaping};
use crate::text::Problems;
use crate::{Note, Patch, Place};

/// A tone that comes and goes gently; a turn and a click of a motor, as its own output drives it.
const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"A walk over the channels\"\n\
    [voice.probe]\nvoices = 1\noutput = \"felt\"\n[voice.probe.nodes]\n\
    tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
    ramp = { type = \"envelope\", attack = 0.04, release = 0.04 }\n\
    felt = { type = \"multiply\", inputs = [\"tone\", \"ramp\"] }\n\
    [voice.turn]\nvoices = 1\noutput = \"spin\"\n[voice.turn.nodes]\nspin = { type = \"drive-spin\" }\n\
    [voice.click]\nvoices = 1\noutput = \"click\"\n[voice.click.nodes]\nclick = { type = \"drive-click\" }\n";

/// Where nothing is known of the actuator: near what skin feels best.
const USUAL: f64 = 200.0;

/// Below this card and amplifier may not follow, above it hardly anything is felt.
const BAND: [f64; 2] = [30.0, 500.0];

/// Of what an actuator is rated for, at most.
const SHARE: f64 = 0.5;

/// The level where there is a rating, and nothing says what of it a sample makes.
const CAUTIOUS: f64 = 0.05;

/// Seconds that a motor turns, at most.
const TURN: f64 = 0.3;

/// What a probe does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deed {
    /// A tone, Hz.
    Tone(f64),
    /// A motor turns for a moment, forward.
    Turn,
    /// A motor clicks, where it can do no more.
    Click,
}

/// Why a level is lower than was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lowered {
    /// The actuator gets half of what it is rated for.
    Rated,
    /// Of what it is rated for, nothing says at which level it gets that.
    Unknown,
    /// The rig lets no more out.
    MaxLevel,
}

/// A channel that is to be felt.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The channel, from 1.
    pub channel: u32,
    /// The output that the rig has there, by its place in the rig.
    pub output: Option<usize>,
    /// What is played.
    pub deed: Deed,
    /// Share of full scale; of a motor, of its rated vibration, or of its strongest click.
    pub level: f64,
    /// Why the level is lower than was asked for, if it is.
    pub lowered: Option<Lowered>,
}

impl Probe {
    /// What is asked of its voice.
    pub fn note(&self, seconds: f64) -> Note {
        let mut note = Note::default().level(self.level).duration(self.deed.seconds(seconds));
        if let Deed::Tone(frequency) = self.deed {
            note = note.frequency(frequency);
        }
        note.place = Some(Place::Channel(self.channel));
        note
    }
}

impl Deed {
    /// The voice that plays it.
    pub fn voice(self) -> &'static str {
        match self {
            Self::Tone(_) => "probe",
            Self::Turn => "turn",
            Self::Click => "click",
        }
    }

    /// How long, where so many seconds are asked for.
    pub fn seconds(self, asked: f64) -> f64 {
        if matches!(self, Self::Tone(_)) { asked } else { asked.min(TURN) }
    }
}

/// What plays probes, at a channel unless they say where.
///
/// # Errors
/// None: it is made here.
pub fn patch(probes: &[Probe]) -> Result<Patch, Problems> {
    let channel = probes.first().map_or(1, |probe| probe.channel);
    let placed = PATCH.replace("voices = 1\n", &format!("voices = 1\nplace = {channel}\n"));
    Patch::parse("walk", placed.as_bytes()).map(|checked| checked.value)
}

/// Whether a probe may go there: vibration for the skin, what is played as it comes, and a rumble motor, whose own output sees to its
/// limits. Never a knob's torque, nor a pulse to somebody's recorder.
pub fn may_be_felt(output: &Output) -> bool {
    match output.kind {
        OutputKind::Vibration | OutputKind::Raw | OutputKind::Drive(_) => true,
        OutputKind::Torque | OutputKind::Trigger { .. } => false,
    }
}

/// The channels to walk over, in their order; with `all`, also those of which the rig says nothing.
pub fn probes(rig: &Rig, level: f64, all: bool) -> Vec<Probe> {
    let leads = |channel: u32| rig.outputs.iter().any(|output| output.direction() == Some(channel));
    let probe = |channel: u32| {
        let at = rig.outputs.iter().position(|output| output.channel == channel);
        let output = at.and_then(|at| rig.outputs.get(at));
        match output {
            Some(output) if !may_be_felt(output) => None,
            // The line that says which way a bridge turns its motor is none of its own.
            None if !all || leads(channel) => None,
            _ => {
                let (deed, most) = match output.map(|output| &output.kind) {
                    Some(OutputKind::Drive(turning)) if turning.shaping == Shaping::Clicks => {
                        (Deed::Click, Some(Most::Level(SHARE)))
                    }
                    Some(OutputKind::Drive(_)) => (Deed::Turn, Some(Most::Level(SHARE))),
                    _ => (
                        Deed::Tone(output.map_or(USUAL, |output| frequency(rig, output))),
                        output.and_then(|output| bearable(rig, output)),
                    ),
                };
                let bearable = match most {
                    Some(Most::Level(level)) => level,
                    Some(Most::Unknown) => CAUTIOUS,
                    None => f64::INFINITY,
                };
                let leaves = match deed {
                    Deed::Tone(_) => output.map_or(rig.device.max_level, |o| rig.max_level(o) / o.gain),
                    // What a motor may be given is a part of its drive.
                    Deed::Turn | Deed::Click => f64::INFINITY,
                };
                let lowered = match () {
                    () if leaves < bearable.min(level) => Some(Lowered::MaxLevel),
                    () if bearable < level && most == Some(Most::Unknown) => Some(Lowered::Unknown),
                    () if bearable < level => Some(Lowered::Rated),
                    () => None,
                };
                Some(Probe { channel, output: at, deed, level: level.min(bearable).min(leaves), lowered })
            }
        }
    };
    (1..=rig.device.channels).filter_map(probe).collect()
}

/// The rig with nothing on it but what is probed: no torque, and no knob that would ask for one.
pub fn bare(rig: &Rig, probes: &[Probe]) -> Rig {
    let mut bare = Rig { knob: None, ..rig.clone() };
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

/// How loud a probe may be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Most {
    Level(f64),
    /// There is a limit, and nobody can tell at which level that is.
    Unknown,
}

/// The level at which its actuator gets half of what it is rated for, where the rig says enough to know; `None` where nothing is said of that.
fn bearable(rig: &Rig, output: &Output) -> Option<Most> {
    let actuator = rig.actuator(output.actuator.as_ref()?)?;
    let least = |of: [Option<f64>; 3]| of.into_iter().flatten().min_by(f64::total_cmp);
    let rms = |key: &str| actuator.value(key).map(|rms| rms * SQRT_2);
    let volts = least([actuator.value("rated_volts"), actuator.value("max_volts"), rms("max_rms_volts")]);
    let flows = volts.zip(actuator.value("resistance")).map(|(volts, ohms)| volts / ohms);
    let amperes = least([flows, actuator.value("max_amperes"), rms("max_rms_amperes")]);
    let known = [rig.volts_per_sample(output).zip(volts), rig.amperes_per_sample(output).zip(amperes)];
    let Some((scale, bears)) = known.into_iter().flatten().next() else {
        // What a full scale is has to be known before anybody can ask.
        let rated = volts.or(amperes).is_some() && rig.device.full_scale_volts.is_some();
        return rated.then_some(Most::Unknown);
    };
    // As if all its peaks were at the frequency of the probe.
    let lifted: f64 = actuator.equaliser.iter().map(|peak| peak.gain_db.max(0.0)).sum();
    let most = SHARE * bears / (scale * output.gain.abs() * 10_f64.powf(lifted / 20.0));
    most.is_finite().then_some(Most::Level(most))
}

#[cfg(test)]
mod tests {
    use super::{Deed, Lowered, bare, patch, probes};
    use crate::{NoAssets, Options, Patch, Player, Rig};

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
            probes(&rig(), 0.3, false).iter().map(|p| (p.channel, p.deed, p.lowered.is_some())).collect();
        let tone = Deed::Tone;
        assert_eq!(
            told,
            [(1, tone(65.0), true), (2, tone(500.0), false), (4, Deed::Turn, false), (7, tone(200.0), false)]
        );
        let all = probes(&rig(), 0.9, true);
        assert_eq!(all.iter().map(|p| p.channel).collect::<Vec<_>>(), [1, 2, 4, 6, 7]);
        assert_eq!(
            (all[2].level, all[2].lowered),
            (0.5, Some(Lowered::Rated)),
            "half of its rated vibration"
        );
        // Half of 2 V: through 2 V a full scale times 5, and through 2 V times a gain of 0.5 times 6 dB.
        assert!((all[0].level - 0.1).abs() < 1e-9 && (all[1].level - 0.5).abs() < 1e-4, "{all:?}");
        assert_eq!((all[3].level, all[4].level), (0.9, 0.9));
        // What leaves is held to `max_level`, so that is what is told: behind the gain of 0.5, and where there is no output.
        let held = RIG.replace("coupling = \"dc\"\n[amp", "coupling = \"dc\"\nmax_level = 0.08\n[amp");
        let held =
            probes(&Rig::parse("r", held.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value, 0.9, true);
        let told: Vec<_> = held.iter().map(|p| (p.level, p.lowered)).collect();
        let most = Some(Lowered::MaxLevel);
        assert_eq!(
            told,
            [(0.08, most), (0.16, most), (0.5, Some(Lowered::Rated)), (0.08, most), (0.08, most)]
        );
    }

    /// A tactor for 2 V (peak) behind each amplifier: half of that is the most, whichever way it is wired, and at a current what of that flows
    /// through its 8 ohm; less yet where it bears less. Where nobody can tell, it is little.
    #[test]
    fn half_of_what_it_is_rated_for_is_that_at_a_current_and_upside_down_as_well() {
        let coil = "model = \"voice-coil\"\nresonance = 100\nresistance = 8\n";
        let current = "drive = \"current\"";
        for (gain, drive, more, wanted) in [
            (5, "", "", 0.1),
            (-5, "", "", 0.1),
            (5, "", "max_rms_volts = 1", 0.1 * std::f64::consts::FRAC_1_SQRT_2),
            (1, current, coil, 0.0625),
            (-1, current, "max_amperes = 0.2", 0.05),
            (1, current, "max_rms_amperes = 0.1", 0.025 * std::f64::consts::SQRT_2),
            (1, current, "", 0.05),
        ] {
            let text = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 2.0\n[amplifier.a]\ngain = {gain}\n{drive}\n\
                 [actuator.t]\nrated_volts = 2\n{more}\n[[tactor]]\nname = \"t\"\nchannel = 1\nactuator = \"t\"\namplifier = \"a\"\n"
            );
            let rig = Rig::parse("r", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
            let probe = &probes(&rig, 0.9, false)[0];
            assert!((probe.level / wanted - 1.0).abs() < 1e-9, "{gain} {drive} {more}: {probe:?}");
            let told = if drive.is_empty() || !more.is_empty() { Lowered::Rated } else { Lowered::Unknown };
            assert_eq!(probe.lowered, Some(told), "{gain} {drive} {more}");
        }
    }

    /// What goes out while one channel has its turn: its tone and no more, and nothing on what is no skin's.
    #[test]
    fn only_the_channel_whose_turn_it_is_moves() {
        let rig = rig();
        let probes = probes(&rig, 0.5, true);
        let patch: Patch = patch(&probes).unwrap();
        for probe in &probes {
            let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
            let mut player = Player::new(&patch, &bare(&rig, &probes), &options, &NoAssets).unwrap();
            let note = probe.note(0.3);
            player.play_at(0.05, probe.deed.voice(), &note).unwrap();
            let mut out = vec![0.0_f32; 7 * 24_000];
            player.process(&mut out);
            for channel in 1..=7 {
                let peak = out.iter().skip(channel - 1).step_by(7).fold(0.0_f32, |most, x| most.max(x.abs()));
                let gain = if channel == 2 { 0.5 } else { 1.0 };
                if channel == probe.channel as usize && probe.deed == Deed::Turn {
                    // A full scale of 2 V times 5, within what its part bears.
                    assert!((0.02..=0.6).contains(&peak), "{channel}: {peak}");
                } else if channel == probe.channel as usize {
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

    /// A rig without any tactor: what is played as it comes is walked over as well.
    #[test]
    fn raw_outputs_alone_are_walked_over() {
        let text = "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\n[[output]]\nname = \"r\"\nkind = \"raw\"\nchannel = 3\n";
        let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
        let probes = probes(&rig, 0.25, false);
        let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
        let mut player =
            Player::new(&patch(&probes).unwrap(), &bare(&rig, &probes), &options, &NoAssets).unwrap();
        player.play_at(0.05, "probe", &probes[0].note(0.3)).unwrap();
        let mut out = vec![0.0_f32; 3 * 9_600];
        player.process(&mut out);
        assert!(out.chunks(3).any(|frame| frame[2].abs() > 0.1));
    }

    /// Every rig that ships can be walked over, knobs and all, and no torque moves.
    #[test]
    fn rigs_that_ship_can_be_walked_over() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("rigs");
        let mut knobs = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|kind| kind != "toml") {
                continue;
            }
            let name = path.display().to_string();
            let rig = Rig::parse(&name, &std::fs::read(&path).unwrap()).unwrap().value;
            knobs += u32::from(rig.knob.is_some());
            let probes = probes(&rig, 0.25, true);
            let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
            let mut player = Player::new(&patch(&probes).unwrap(), &bare(&rig, &probes), &options, &NoAssets)
                .unwrap_or_else(|problems| panic!("{name}: {problems}"));
            for (number, probe) in probes.iter().enumerate() {
                let at = 0.05 + 0.5 * number as f64;
                player.play_at(at, probe.deed.voice(), &probe.note(0.1)).unwrap();
            }
            let channels = player.plan().channels;
            let mut out = vec![0.0_f32; channels * 24_000 * (probes.len() + 1)];
            player.process(&mut out);
            let moves =
                |channel: u32| out.iter().skip(channel as usize - 1).step_by(channels).any(|x| *x != 0.0);
            for probe in &probes {
                assert!(moves(probe.channel), "{name}: nothing on channel {}", probe.channel);
            }
            for output in rig.outputs.iter().filter(|output| !super::may_be_felt(output)) {
                assert!(!moves(output.channel), "{name}: {}", output.name);
            }
        }
        assert!(knobs >= 2);
    }
}
