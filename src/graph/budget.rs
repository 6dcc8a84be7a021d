//! The memory that an engine for a plan will take, worked out before any of it is taken.

use std::fmt;
use std::sync::Arc;

use super::plan::{Plan, Precision};
use super::program::Program;
use crate::dsp::lanes::{LANES, Real};
use crate::node::States;
use crate::text::Problem;

/// The most memory that an engine may take, bytes: 1 GiB.
pub const MOST: u64 = 1 << 30;

/// What a lane takes besides its signals: who is on it, and when it ends.
const LANE: u64 = 240;
/// What a lane takes besides whose voice may move.
const JOURNEY: u64 = 264;
/// What a tactor takes that shares points, and what it takes besides where they move.
const TACTOR: u64 = 1024;
const MOVER: u64 = 2048;
/// Rows of a buffer: the samples of a block.
const ROWS: u64 = 64;
/// What the output stage takes for a group of eight channels, and what an engine takes that has nothing to do: its queue above all.
const STAGE: u64 = 16 << 10;
const ENGINE: u64 = 4 << 20;

/// What it takes to watch a signal, with what waits to begin; and what keeps what has begun, where there is any.
const WATCH: u64 = 576;
const BEGUN: u64 = 576 << 10;

/// What an engine will take, as an estimate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Need {
    /// Bytes, all in all.
    pub bytes: u64,
    /// Who takes most of it.
    pub most: Share,
}

/// A part of what an engine takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Share {
    /// Bytes.
    pub bytes: u64,
    /// The instrument, by its place; `None`: the shared nodes.
    pub instrument: Option<usize>,
    /// Its name.
    pub voice: Arc<str>,
    /// How many of it may sound at once.
    pub voices: usize,
    /// The node that takes more than half of that, if one does: its name and its type.
    pub node: Option<(Arc<str>, &'static str)>,
}

impl Need {
    /// What an engine for `plan` will take.
    pub fn of(plan: &Plan) -> Self {
        match plan.precision {
            Precision::Single => of::<f32>(plan),
            Precision::Double => of::<f64>(plan),
        }
    }

    /// Whether it is more than there is.
    pub fn is_too_much(&self) -> bool {
        self.bytes > MOST
    }

    /// What to do about it.
    pub(crate) fn help(&self) -> String {
        match &self.most.node {
            Some((name, "delay")) => {
                format!(
                    "give `{name}` a shorter `longest`, and the voice no more `voices` than sound at once"
                )
            }
            _ => "give voices no more `voices` than sound at once".to_string(),
        }
    }

    /// As a problem of the patch, without its place there.
    pub(crate) fn problem(&self) -> Problem {
        Problem::of_file(self.to_string()).help(self.help())
    }
}

/// The number of groups of eight lanes for an instrument of so many voices: spare lanes let a voice that makes room fade while the
/// new one already sounds.
pub(crate) fn groups(voices: usize) -> usize {
    voices.saturating_add(voices.min(LANES)).div_ceil(LANES)
}

fn of<R: Real>(plan: &Plan) -> Need {
    let rate = plan.engine_rate();
    let real = size_of::<R>() as u64;
    let channels = plan.channels.div_ceil(LANES) as u64;
    let buffers = |program: &Program| program.buffers as u64 + 1;
    let mut most = Share { bytes: 0, instrument: None, voice: "".into(), voices: 1, node: None };
    // Eight channels: a group of the mix, twice, the stage, and what waits for the device.
    let frames = (plan.ratio as u64).saturating_mul(LANES as u64 * 4);
    let eight = frames.saturating_add(STAGE + ROWS * LANES as u64 * (real + 4));
    let mut bytes = channels.saturating_mul(eight).saturating_add(ENGINE);
    let programs = plan.instruments.iter().map(|i| &i.program).chain([&plan.shared_program]);
    let buffers = programs.map(buffers).max().unwrap_or(0) + plan.shared.len() as u64;
    bytes = bytes.saturating_add(buffers.saturating_mul(ROWS * LANES as u64 * real));
    let watches = plan.watches.len() as u64;
    bytes = bytes.saturating_add(watches.saturating_mul(WATCH) + if watches > 0 { BEGUN } else { 0 });

    let tactors = plan.spread.as_ref().map_or(0, |spread| spread.channels().len() as u64);
    bytes = bytes.saturating_add(tactors * if plan.moves() { TACTOR + MOVER } else { TACTOR });
    let lane = if plan.moves() { LANE + JOURNEY } else { LANE };

    let mut add = |program: &Program, groups: u64, routes: u64, share: Share| {
        let mut greatest = (0, None);
        let mut all = 0_u64;
        for op in &program.ops {
            let state = States::<R>::bytes(op.node.kind, &op.node.setup(rate, rate)) as u64;
            let taken = state.saturating_mul(groups);
            all = all.saturating_add(taken);
            if taken > greatest.0 {
                greatest = (taken, Some((Arc::clone(&op.node.name), op.node.kind.spec().name)));
            }
        }
        let rows = program.steady.len() as u64 * (real + 8) + program.late.len() as u64 * real;
        let group = routes.saturating_add(LANES as u64 * (rows + lane));
        all = all.saturating_add(groups.saturating_mul(group));
        bytes = bytes.saturating_add(all);
        if all > most.bytes {
            let node = greatest.1.filter(|_| greatest.0 > all / 2);
            most = Share { bytes: all, node, ..share };
        }
    };
    // A group of lanes may reach all channels, by a matrix for each eight of them.
    let routes = channels.saturating_mul((LANES * LANES + LANES) as u64 * real + 16);
    for (i, instrument) in plan.instruments.iter().enumerate() {
        let (voice, voices) = (Arc::clone(&instrument.name), instrument.voices);
        let share = Share { bytes: 0, instrument: Some(i), voice, voices, node: None };
        add(&instrument.program, groups(voices) as u64, routes, share);
    }
    let share = Share { bytes: 0, instrument: None, voice: "".into(), voices: 1, node: None };
    add(&plan.shared_program, 1, 0, share);
    Need { bytes, most }
}

/// Bytes in the unit that makes them short.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mebi = self.0 as f64 / 1_048_576.0;
        if mebi >= 1000.0 { write!(f, "{:.1} GiB", mebi / 1024.0) } else { write!(f, "{mebi:.1} MiB") }
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Share { bytes, instrument, voice, voices, node } = &self.most;
        write!(f, "this takes {} of memory, and {} is the most: ", Bytes(self.bytes), Bytes(MOST))?;
        match (instrument, node) {
            (Some(_), Some((name, kind))) => write!(f, "node `{name}` ({kind}) of voice `{voice}`")?,
            (Some(_), None) => write!(f, "voice `{voice}`")?,
            (None, Some((name, kind))) => write!(f, "shared node `{name}` ({kind})")?,
            (None, None) => write!(f, "the shared nodes")?,
        }
        match instrument {
            Some(_) => write!(f, ", with {voices} voices, takes {} of it", Bytes(*bytes)),
            None => write!(f, " takes {} of it", Bytes(*bytes)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Need};
    use crate::engine::Engine;
    use crate::engine::refusal::Refusal;
    use crate::graph::plan::Plan;
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::text::Problems;

    fn plan(voices: &str) -> Result<Plan, Problems> {
        let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{voices}");
        let patch = Patch::parse("t.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live: true, ..Options::default() };
        scene(&patch, &Rig::default_for(2), &options, &NoAssets).map(|s| s.plan)
    }

    fn echo(voices: u32, longest: f64) -> String {
        format!(
            "[voice.v]\nvoices = {voices}\noutput = \"echo\"\n[voice.v.nodes]\n\
             s = {{ type = \"sine\", frequency = 80 }}\n\
             echo = {{ type = \"delay\", input = \"s\", time = 0.1, longest = {longest} }}\n"
        )
    }

    #[test]
    fn long_delays_of_many_voices_are_refused_and_named() {
        let problems = plan(&echo(4096, 60.0)).err().unwrap_or_default();
        let shown = problems.to_string();
        assert!(shown.contains("node `echo` (delay) of voice `v`, with 4096 voices"), "{shown}");
        assert!(shown.contains("1.0 GiB is the most") && shown.contains("`longest`"), "{shown}");
        assert!(shown.contains("t.toml:8:"), "at the line of the node: {shown}");
        // 8 lanes of 2^19 samples of 4 bytes in each of 513 groups.
        let lines = 513 * 8 * (1_u64 << 19) * 4;
        assert!(shown.contains(&format!("{:.1} GiB", lines as f64 / MOST as f64)), "{shown}");
        assert!(plan(&echo(4, 60.0)).is_ok() && plan(&echo(4096, 0.1)).is_ok());
    }

    #[test]
    fn many_small_ones_are_refused_too() {
        let many: String =
            (0..60).map(|n| echo(8, 60.0).replace("voice.v", &format!("voice.v{n}"))).collect();
        assert!(plan(&many).is_err());
        let silent = |n: usize| {
            format!(
                "[voice.v{n}]\nvoices = 4096\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 80 }}\n"
            )
        };
        let shown = plan(&(0..3000).map(silent).collect::<String>()).err().unwrap_or_default().to_string();
        assert!(shown.contains("voice `v0`, with 4096 voices") && shown.contains("`voices`"), "{shown}");
    }

    #[test]
    fn a_plan_made_in_code_is_refused_before_memory_is_taken() {
        let mut big = plan(&echo(8, 60.0)).unwrap();
        big.instruments[0].voices = usize::MAX;
        match Engine::new(&big).err() {
            Some(Refusal::Memory(need)) => assert!(need.is_too_much() && need.most.instrument == Some(0)),
            other => panic!("{other:?}"),
        }
        assert!(!Need::of(&plan(&echo(8, 1.0)).unwrap()).is_too_much());
    }
}
