//! `pacinian latency`.

use super::failure::Failure;
use super::patience;
use super::priority;
use super::stop::{INTERRUPTED, Stop};
use super::table::{Table, dbfs, many};
use super::terminal::Terminal;
use clap::Args;
use pacinian::edit;
use pacinian::io::device::capture;
use pacinian::io::device::card::Shape;
use pacinian::io::device::choose::{self, Chosen, Wish};
use pacinian::io::latency::figures::{Doubt, Figures};
use pacinian::io::latency::measure::{EVERY, Loop, Measured, measure};
use pacinian::io::{replace, text};
use pacinian::rig::{Output, OutputKind, Rig};
use pacinian::text::problem::escaped;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Measures how long it takes from an output through a cable, or a tactor and an accelerometer, back to an input
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pacinian latency --device \"USB Sound\" --out 1 --in 1\n  \
    pacinian latency --rig belt.toml --out spine --in 2 --count 100 --save\n\n\
    It sends a sweep of 60 to 900 Hz, 80 ms long, again and again, and looks for it in what comes in. The loop's latency is what passes \
    beyond what the system says that frames wait in its buffers: converters, cable, and what hangs on the output. `--save` writes it \
    into the rig as `loop_latency`, and touches nothing else there.")]
pub struct Latency {
    /// The output: a channel, from 1 as printed on the card, or the name that the rig has for it
    #[arg(long, value_name = "N")]
    out: String,
    /// The input's channel, from 1
    #[arg(long = "in", value_name = "M", value_parser = clap::value_parser!(u16).range(1..=4096))]
    input: u16,
    /// The sound card that plays: its id, its name or a part of that [default: what the rig says, else the system's default]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// The sound card that hears [default: what the rig says, else the one that plays; of JACK, its inputs]
    #[arg(long, value_name = "NAME")]
    input_device: Option<String>,
    /// The rig, a TOML file
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,
    /// Frames a second [default: what the rig says, else 48000]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(6_000..=768_000))]
    rate: Option<u32>,
    /// Frames in a block
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65536))]
    block: u32,
    /// How many times to measure
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u16).range(1..=1000))]
    count: u16,
    /// Largest sample that goes out, 0 to 1 [default: 0.1, or the rig's `max_level` where that is less]
    #[arg(long, value_name = "X", value_parser = level)]
    level: Option<f64>,
    /// Write the mean into the rig
    #[arg(long, requires = "rig")]
    save: bool,
    /// As one JSON object
    #[arg(long)]
    json: bool,
}

/// Largest sample that goes out where nothing says another.
const USUAL: f64 = 0.1;

fn level(word: &str) -> Result<f64, String> {
    let known = "it is a share of full scale, above 0 and at most 1, such as 0.1";
    word.parse::<f64>().ok().filter(|x| *x > 0.0 && *x <= 1.0).ok_or_else(|| known.into())
}

/// The drift, and how sure it is.
fn drift(figures: &Figures) -> [String; 2] {
    let minute = |x: f64| format!("{:.1} us a minute", 60e6 * x);
    match (figures.margin, figures.drifts()) {
        (Some(margin), Some(true)) => [minute(figures.drift), format!("+-{} (95 %)", minute(margin))],
        (Some(margin), _) => [format!("none beyond +-{}", minute(margin)), "95 %".into()],
        (None, _) => {
            [minute(figures.drift), "of two probes, so by how much that is chance is unknown".into()]
        }
    }
}

impl Latency {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let rig = self.rig.as_deref().map(|path| read(path, terminal)).transpose()?;
        let rig = rig.as_ref();
        if let Some(path) = self.rig.as_deref().filter(|_| self.save) {
            // Better said now than when it has been measured.
            if text::is_stream(path) {
                return Err(Failure::usage("there is no file to save it in", "name one: --rig RIG.toml"));
            }
            replace::check(path)?;
        }
        let (channel, name) = self.output(rig)?;
        let level = self.level(rig, channel, &name)?;
        let said = rig.and_then(|rig| rig.device.name.as_deref());
        let file = self.rig.as_ref().map_or_else(String::new, |path| path.display().to_string());
        let (wish, chosen) = super::choose::choose_for(self.device.as_deref(), said, file, None, terminal)?;
        let rate = chosen.rate(self.rate.or(rig.and_then(|rig| rig.device.rate.map(|rate| rate as u32))));
        let Chosen::Card(device, found) = chosen else {
            let what = match wish {
                Wish::Virtual => "the virtual card has no inputs, and so no loop to measure",
                _ => "there is no sound card to measure",
            };
            let help = "plug one in, or name one; `pacinian devices` lists what is there";
            return Err(Failure::usage(what, help).with_code(69));
        };
        let offered = found.output.as_ref().map_or(&[][..], |offer| &offer.channels);
        let declared = rig.map(|rig| rig.device.channels as usize);
        let fits = |count: usize| offered.iter().any(|&n| usize::from(n) == count);
        let channels = declared
            .filter(|&count| fits(count) && count >= channel)
            .or_else(|| offered.iter().map(|&n| usize::from(n)).find(|&n| n >= channel))
            .ok_or_else(|| {
                let most = offered.iter().max().copied().unwrap_or(0);
                Failure::usage(
                    format!("{} has {most} outputs, so none is number {channel}", found.name),
                    "choose another with --out or --device",
                )
                .with_code(69)
            })?;
        let blocks = found.output.as_ref().and_then(|offer| offer.blocks);
        let block = blocks.map(|(least, most)| self.block.clamp(least, most.max(least)));
        let ear = self.input_device.as_deref().or(rig.and_then(|rig| rig.device.input.as_deref()));
        let playing = (device, found);
        let longer = longer(self.block, blocks);
        let ear = ear.map(str::to_string);
        let (playing, heard) = patience::look(None, terminal, move || {
            let heard = ear.map_or_else(|| choose::heard_beside(&playing), |ear| choose::heard(&ear));
            (playing, heard)
        })?;
        let ((device, found), (ear, heard_of)) = (playing, heard?);
        let ears = capture::shape(&heard_of, usize::from(self.input), rate, block)?;
        if usize::from(self.input) > ears.channels {
            let what =
                format!("{} has {} inputs, so none is number {}", heard_of.name, ears.channels, self.input);
            return Err(Failure::usage(what, "choose another with --in or --input-device").with_code(69));
        }
        terminal.note(&format!(
            "{} at {} to go out on {} of {}, listened for on input {} of {}: {:.0} s\n",
            many(self.count as usize, "probe"),
            dbfs(level as f32),
            escaped(&name),
            escaped(&found.name),
            self.input,
            escaped(&heard_of.name),
            f64::from(self.count) * EVERY + 1.0
        ));
        let names = [found.name.clone(), heard_of.name.clone()];
        let rates = [rate, ears.rate];
        let what = Loop {
            out: (device, found, Shape { channels, rate, block, exact: false }, channel - 1),
            input: (ear, heard_of, ears, usize::from(self.input) - 1),
            level,
            count: usize::from(self.count),
        };
        let stop = Stop::listen()?;
        let begun = Arc::<AtomicBool>::default();
        let (begins, asked) = (Arc::clone(&begun), stop.clone());
        let measured = patience::long(&names[0], &begun, &stop, terminal, move || {
            measure(&what, |_| {
                begins.store(true, Ordering::Release);
                asked.asked().is_none()
            })
        })?;
        priority::told().iter().for_each(|told| terminal.note(&format!("{told}\n")));
        let Some(mut measured) = measured? else {
            return Err(Failure::told(stop.asked().unwrap_or(INTERRUPTED)));
        };
        // One that came much later than most is another sound.
        let strays = measured.leave_out_strays();
        if measured.rounds.len() * 2 < usize::from(self.count) {
            return Err(self.nothing(&measured, strays, &names, &name, level, longer));
        }
        let figures = measured.figures();
        if self.json {
            terminal
                .print(&format!("{:#}\n", self.as_json(&measured, strays, &figures, &names, rates, &name)))?;
        } else {
            terminal.print(&self.text(&measured, strays, &figures, rates))?;
        }
        match &self.rig {
            Some(path) if self.save => {
                trusted(&measured, &figures, longer)?;
                save(path, figures.mean, terminal)
            }
            _ => Ok(()),
        }
    }

    /// The output's channel, from 1, and what it is called.
    fn output(&self, rig: Option<&Rig>) -> Result<(usize, String), Failure> {
        let outputs = rig.map_or(&[][..], |rig| &rig.outputs);
        let number = self.out.parse::<usize>().ok().filter(|n| (1..=4096).contains(n));
        let output = match number {
            Some(n) => outputs.iter().find(|output| output.channel as usize == n),
            None => Some(outputs.iter().find(|output| output.name == self.out).ok_or_else(|| {
                let names: Vec<&str> = outputs.iter().map(|output| output.name.as_str()).collect();
                let help = match names.as_slice() {
                    [] => "give its channel, from 1: --out 1; names are those of a rig: --rig RIG".into(),
                    names => format!("give a channel, from 1, or one of {}", names.join(", ")),
                };
                Failure::usage(format!("there is no output `{}`", self.out), help)
            })?),
        };
        if let Some(output) = output
            && output.kind != OutputKind::Vibration
        {
            let what = format!("`{}` is no output for vibration, so no probe goes out there", output.name);
            return Err(Failure::usage(what, "choose another with --out"));
        }
        let leads = |output: &&Output| output.direction().is_some_and(|d| Some(d as usize) == number);
        if let Some(output) = outputs.iter().find(leads) {
            let what = format!(
                "output {} says which way `{}` turns, so no probe goes out there",
                self.out, output.name
            );
            return Err(Failure::usage(what, "choose another with --out"));
        }
        let channel = number.or(output.map(|output| output.channel as usize)).unwrap_or(1);
        let name = output.map_or(format!("output {channel}"), |output| format!("`{}`", output.name));
        Ok((channel, name))
    }

    /// The largest sample that goes out: never more than the rig lets leave there.
    fn level(&self, rig: Option<&Rig>, channel: usize, name: &str) -> Result<f64, Failure> {
        let output =
            |rig: &Rig| rig.outputs.iter().find(|o| o.channel as usize == channel).map(|o| rig.max_level(o));
        let most = rig.map_or(1.0, |rig| output(rig).unwrap_or(rig.device.max_level));
        match self.level {
            Some(level) if level > most => Err(Failure::usage(
                format!("the rig lets at most {most} of full scale leave on {name}; --level {level} is more"),
                format!("send less, --level {most}, or raise `max_level` in the rig"),
            )),
            level => Ok(level.unwrap_or(USUAL.min(most))),
        }
    }

    fn nothing(
        &self,
        measured: &Measured,
        strays: usize,
        names: &[String; 2],
        name: &str,
        level: f64,
        longer: Option<u32>,
    ) -> Failure {
        let heard = measured.rounds.len() + strays;
        if measured.broken * 2 > usize::from(self.count) {
            let what = format!("{} of {} probes fell into gaps of the devices", measured.broken, self.count);
            let help = longer.map_or("close other programs, and measure again".into(), |block| {
                format!("measure with longer blocks: --block {block}")
            });
            return Failure::usage(what, help).with_code(74);
        }
        let what = format!("nothing came back on input {} of {}", self.input, names[1]);
        let (what, help) = match measured.peak {
            0.0 => (format!("{what}: it is silent"), "is it connected, and not muted?".to_string()),
            peak if heard > 0 => (
                format!(
                    "{what} that is like the probe each time: {heard} of {} did, the largest sample is {}",
                    self.count,
                    dbfs(peak)
                ),
                format!("come nearer, or send more: --level {}", (level * 4.0).min(1.0)),
            ),
            peak => (
                format!("{what} that is like the probe: the largest sample is {}", dbfs(peak)),
                format!(
                    "is it connected to {name} of {}? Send more: --level {}",
                    names[0],
                    (level * 4.0).min(1.0)
                ),
            ),
        };
        Failure::usage(what, help).with_code(74)
    }

    fn text(&self, measured: &Measured, strays: usize, figures: &Figures, rates: [u32; 2]) -> String {
        let Figures { mean, deviation, least, most, .. } = *figures;
        let micro = |seconds: f64| format!("{:.1} us", 1e6 * seconds);
        let frames = |seconds: f64| format!("{:.2} frames", seconds * f64::from(rates[0]));
        let gain = measured.gain();
        let mut table = Table::default();
        table.row(["loop latency".into(), format!("{:.4} ms", 1e3 * mean), frames(mean)]);
        if measured.rounds.len() > 1 {
            let spread = format!("{} (standard deviation)", frames(deviation));
            table.row(["spread".into(), micro(deviation), spread]);
            table.row(["from, to".into(), format!("{:.4} ms", 1e3 * least), format!("{:.4} ms", 1e3 * most)]);
            let [drift, how] = drift(figures);
            table.row(["drift".into(), drift, how]);
        } else {
            let why = "of one probe: send more, --count";
            table.row(["spread, drift".into(), "unknown".to_string(), why.into()]);
        }
        table.row([
            "clocks".into(),
            format!("{:+.1} ppm", 1e6 * measured.drift),
            format!("+-{:.1} (95 %), the input's against the output's", 1e6 * measured.clocks_margin()),
        ]);
        table.row([
            "heard".into(),
            format!("{} of {}", measured.rounds.len(), self.count),
            format!(
                "{} at {}, {}",
                dbfs(gain.abs() as f32),
                "the input for full scale out",
                if gain < 0.0 { "upside down" } else { "upright" }
            ),
        ]);
        let [out, input] = measured.says;
        table.row([
            "round trip".into(),
            format!("{:.2} ms", 1e3 * (out + mean + input)),
            format!(
                "with what the system says of its buffers: {:.2} ms out, {:.2} ms in",
                1e3 * out,
                1e3 * input
            ),
        ]);
        let mut text = table.text();
        if measured.broken + measured.unheard + strays > 0 {
            text += &format!(
                "  not counted: {} in gaps of the devices, {} not heard clearly, {strays} far off\n",
                measured.broken, measured.unheard
            );
        }
        if measured.peak >= 0.999 {
            text += "  the input is at full scale: turn it down, or send less with --level\n";
        }
        text
    }

    fn as_json(
        &self,
        measured: &Measured,
        strays: usize,
        figures: &Figures,
        names: &[String; 2],
        rates: [u32; 2],
        name: &str,
    ) -> serde_json::Value {
        let Figures { mean, mean_margin, deviation, least, most, drift, error, margin } = *figures;
        // One probe says nothing of them.
        let [deviation, drift] =
            [deviation, drift].map(|figure| (measured.rounds.len() > 1).then_some(figure));
        json!({
            "out": { "device": names[0], "output": name, "rate_hz": rates[0], "says_s": measured.says[0] },
            "in": { "device": names[1], "channel": self.input, "rate_hz": rates[1], "says_s": measured.says[1] },
            "loop_latency_s": mean,
            "loop_latency_margin_s": mean_margin,
            "loop_latency_frames": mean * f64::from(rates[0]),
            "deviation_s": deviation, "least_s": least, "most_s": most,
            "drift_s_per_s": drift,
            "drift_error_s_per_s": error,
            "drift_margin_s_per_s": margin,
            "clocks_ppm": 1e6 * measured.drift,
            "clocks_margin_ppm": 1e6 * measured.clocks_margin(),
            "round_trip_s": measured.says[0] + mean + measured.says[1],
            "gain": measured.gain(),
            "probes": self.count, "heard": measured.rounds.len(),
            "unheard": measured.unheard, "in_gaps": measured.broken, "far_off": strays,
            "overdriven": measured.peak >= 0.999,
            "rounds": measured.rounds.iter().map(|r| json!({ "at_s": r.at, "latency_s": r.latency })).collect::<Vec<_>>(),
        })
    }
}

/// Whether what was measured is fit to be written into a rig.
fn trusted(measured: &Measured, figures: &Figures, longer: Option<u32>) -> Result<(), Failure> {
    let Some(doubt) = figures.doubt(measured.drift) else { return Ok(()) };
    let why = match doubt {
        Doubt::Clocks(drift) => format!(
            "the clocks come out {:+.0} ppm apart, and no two crystals are: the devices' times are not to be trusted",
            1e6 * drift
        ),
        Doubt::Spread(deviation) => {
            format!("the rounds differ by {:.0} us (standard deviation)", 1e6 * deviation)
        }
        Doubt::Few(sure) => {
            let by = sure.map_or("nobody knows by how much".into(), |sure| {
                format!("by +-{:.0} us (95 %)", 1e6 * sure)
            });
            let what = format!("of {}, the mean may be off, {by}", many(measured.rounds.len(), "probe"));
            return Err(
                Failure::usage(format!("it is not saved: {what}"), "send more: --count 25").with_code(74)
            );
        }
    };
    let blocks = longer.map_or(String::new(), |block| format!(" ask for longer blocks (--block {block}),"));
    let help = format!("close other programs,{blocks} and measure again");
    Err(Failure::usage(format!("it is not saved: {why}"), help).with_code(74))
}

/// Longer blocks than `asked`, where the device offers such.
fn longer(asked: u32, offered: Option<(u32, u32)>) -> Option<u32> {
    let (least, most) = offered?;
    let longer = asked.saturating_mul(4).min(most);
    (longer > asked.max(least)).then_some(longer)
}

fn read(path: &Path, terminal: &Terminal) -> Result<Rig, Failure> {
    let bytes = text::read(path)?;
    let checked =
        Rig::parse(&path.display().to_string(), &bytes).map_err(|problems| Failure::of(78, problems))?;
    if !checked.warnings.list.is_empty() {
        terminal.note(&super::problems::shown(&checked.warnings, terminal));
    }
    Ok(checked.value)
}

/// Writes the latency into a rig, and nothing else.
fn save(path: &Path, seconds: f64, terminal: &Terminal) -> Result<(), Failure> {
    let name = path.display().to_string();
    // Read again, as it may have changed while it was measured.
    let bytes = text::read(path)?;
    let with = edit::loop_latency(&String::from_utf8_lossy(&bytes), seconds).map_err(|why| {
        Failure::usage(format!("`{name}` was left as it is: {why}"), "mend it, and measure again")
    })?;
    let latency = Rig::parse(&name, with.as_bytes()).map_err(|problems| Failure::of(78, problems))?;
    replace::replace(path, &bytes, with.as_bytes())?;
    let latency = latency.value.device.loop_latency.unwrap_or(seconds);
    let less = "; less than the system says passes, so that it is taken off what is told";
    terminal.note(&format!("{name}: loop_latency = {latency}{}\n", if latency < 0.0 { less } else { "" }));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Figures, Measured, drift, longer, trusted};
    use pacinian::io::latency::measure::Round;

    fn round(at: f64, latency: f64) -> Round {
        Round { at, latency, gain: 1.0 }
    }

    #[test]
    fn a_drift_that_may_be_chance_is_none() {
        let of = |slope, margin| {
            let rounds = [round(0.0, 0.0), round(1.0, 0.0)];
            drift(&Figures { drift: slope, margin, ..Figures::of(&rounds) }).join(", ")
        };
        assert_eq!(of(-64.6e-6 / 60.0, Some(80e-6 / 60.0)), "none beyond +-80.0 us a minute, 95 %");
        assert_eq!(of(-90e-6 / 60.0, Some(80e-6 / 60.0)), "-90.0 us a minute, +-80.0 us a minute (95 %)");
        assert!(of(-90e-6 / 60.0, None).ends_with("is unknown"));
    }

    #[test]
    fn only_blocks_that_are_offered_are_advised() {
        assert_eq!(longer(512, Some((64, 8192))), Some(2048));
        assert_eq!(longer(512, Some((64, 1024))), Some(1024));
        assert_eq!(longer(512, Some((64, 512))), None);
        assert_eq!(
            longer(64, Some((1024, 1024))),
            None,
            "it has those alone, and they were asked for in their place"
        );
        assert_eq!(longer(512, None), None);
        let rounds = [0.01, 0.0119, 0.0103].map(|latency| round(0.0, latency)).to_vec();
        let figures = Figures::of(&rounds);
        let measured = Measured { rounds, ..Measured::default() };
        let help = |longer| {
            trusted(&measured, &figures, longer).unwrap_err().problems()[0].list[0].help.clone().unwrap()
        };
        assert_eq!(
            help(Some(1024)),
            "close other programs, ask for longer blocks (--block 1024), and measure again"
        );
        assert_eq!(help(None), "close other programs, and measure again");
        let rounds = vec![round(0.0, 0.01)];
        let figures = Figures::of(&rounds);
        let why = trusted(&Measured { rounds, ..Measured::default() }, &figures, None).unwrap_err();
        let why = &why.problems()[0].list[0];
        assert_eq!(why.what, "it is not saved: of 1 probe, the mean may be off, nobody knows by how much");
        assert_eq!(why.help.as_deref(), Some("send more: --count 25"));
    }
}
