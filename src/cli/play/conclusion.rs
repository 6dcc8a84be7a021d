//! What is said of a session that is over.

use super::super::failure::Failure;
use super::super::loaded::Loaded;
use super::super::screen::{Latency, cut_short};
use super::super::table::{dbfs, grouped, many};
use super::super::terminal::Terminal;
use pacinian::io::session::Session;
use pacinian::live::board::Board;
use pacinian::live::gate::RAMP_IN;
use pacinian::text::problem::escaped;

/// Seconds that may be missing in the end without a word.
const UNPLAYED: f64 = 0.5;

/// A session that is over.
pub struct Conclusion<'a> {
    pub loaded: &'a Loaded,
    pub session: &'a Session,
    /// The largest magnitude on each output.
    pub peaks: &'a [f32],
    /// What the device still held when the output was shut, in words.
    pub held: Option<&'a str>,
    /// Seconds that were asked for, if the session was not ended before.
    pub asked: Option<f64>,
}

impl Conclusion<'_> {
    /// Says it.
    ///
    /// # Errors
    /// A device that was away in the end, and an output that takes no more.
    pub fn tell(&self, terminal: &Terminal) -> Result<(), Failure> {
        let (away, is_away) = self.session.board().absence();
        let text = [self.sums(), self.time(away), self.delays(), self.heard(), self.tasks(), self.outputs()];
        terminal.print(&text.concat())?;
        if !is_away {
            return Ok(());
        }
        let what = "the device was away at the end";
        Err(Failure::usage(what, "plug it in, or see above why it went, and play again").with_code(74))
    }

    /// What was played, and what was not.
    fn sums(&self) -> String {
        let board = self.session.board();
        let load = &board.load;
        let refused = Some(board.refused.words()).filter(|words| !words.is_empty());
        let refused = refused.map_or(String::new(), |words| format!(" (no room for {words})"));
        let mut text = format!(
            "{}: {} frames, {}{}, load {:.2} % (half of the callbacks below {:.2} %, 99.9 % below {:.1} %), {} over their time, {}, {} late, {} lost{}\n",
            escaped(self.loaded.name()),
            board.frames.get(),
            many(board.started.get() as usize, "voice"),
            cut_short(board.stolen.get()),
            100.0 * load.mean(),
            100.0 * load.quantile(0.5),
            100.0 * load.quantile(0.999),
            load.over(),
            many(board.xruns.get() as usize, "xrun"),
            board.late.get(),
            board.dropped.get() + board.refused.get(),
            refused,
        );
        let undone = board.undone.get();
        if undone > 0 {
            text += &format!(
                "  asked for and could not be done, as was told: {}\n",
                many(undone as usize, "time")
            );
        }
        let changed = changed(board);
        if !changed.is_empty() {
            text += &format!("  of the samples: {changed}\n");
        }
        text
    }

    /// Where less was felt than was asked for; `away` in frames.
    fn time(&self, away: u64) -> String {
        let rate = self.session.rate();
        let played = self.session.board().frames.get() as f64 / rate;
        let mut text = String::new();
        if let Some(asked) = self.asked.filter(|asked| played < asked - UNPLAYED) {
            text += &format!(
                "  of {asked} s no more than {played:.1} s were played, as the machine or the device could not keep time\n"
            );
        }
        if self.asked.is_some_and(|asked| asked <= RAMP_IN) && self.session.board().started.get() == 0 {
            text += &format!(
                "  the output comes in within {RAMP_IN} s, and patterns begin behind that: ask for more\n"
            );
        }
        if away > 0 {
            let seconds = away as f64 / rate;
            text += &format!("  the device was away for {seconds:.1} of {played:.1} s, which nobody felt\n");
        }
        text
    }

    fn delays(&self) -> String {
        let latency = Latency::of(self.session, self.loaded.rig.device.loop_latency);
        let held = self.held.map_or(String::new(), |held| format!("  when the output was shut, {held}\n"));
        format!("  from an event to the middle of what it makes at 250 Hz: {}\n{held}", latency.told())
    }

    fn heard(&self) -> String {
        let input = &self.session.board().input;
        if input.frames.get() == 0 {
            return String::new();
        }
        // While nothing is heard there is none.
        let latency = match input.latency.get() {
            0 => "not heard in the end".to_string(),
            known => format!("latency {:.1} ms", 1e3 * (known as f64 * 1e-9 + self.session.input_delay())),
        };
        format!(
            "  input: {latency}, {} frames, {}, {} too late, {} too many, {} lost\n",
            input.frames.get(),
            many(input.xruns.get() as usize, "xrun"),
            many(input.dry.get() as usize, "time"),
            many(input.jumps.get() as usize, "time"),
            many(input.lost.get() as usize, "frame"),
        )
    }

    fn tasks(&self) -> String {
        let mut text = String::new();
        for duty in self.session.duties().iter().filter(|duty| duty.runs() + duty.skipped() > 0) {
            text += &format!(
                "  {}: {} runs, the longest {}, {}",
                escaped(duty.name()),
                grouped(duty.runs()),
                brief(duty.longest()),
                match duty.cost() {
                    0.0 => "no limit declared".into(),
                    cost => format!("{} times longer than {}", grouped(duty.overruns()), brief(cost)),
                }
            );
            text += &match duty.skipped() {
                0 => "\n".into(),
                skipped => format!(", {} left out, as there was too much to do\n", grouped(skipped)),
            };
        }
        text
    }

    fn outputs(&self) -> String {
        let names = self.loaded.tactors();
        let loud = names.iter().zip(self.peaks).filter(|(_, peak)| **peak > 0.0);
        loud.map(|(name, &peak)| format!("  {}: {}\n", escaped(name), dbfs(peak))).collect()
    }
}

/// What became of samples that could not leave as they were; nothing where all could.
fn changed(board: &Board) -> String {
    let kinds = [
        (board.limited.get(), "turned down by the limiter"),
        (board.clamped.get(), "cut at full scale"),
        (board.masked.get(), "no numbers, played as 0"),
        (board.held_back.get(), "held back, so that actuators bear it"),
    ];
    let told = kinds.into_iter().filter(|(count, _)| *count > 0);
    told.map(|(count, what)| format!("{} {what}", grouped(count))).collect::<Vec<_>>().join(", ")
}

/// A short time.
fn brief(seconds: f64) -> String {
    if seconds < 1e-6 { format!("{:.1} ns", 1e9 * seconds) } else { format!("{:.1} µs", 1e6 * seconds) }
}
