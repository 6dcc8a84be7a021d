//! A patch on a rig, played to its end.

use super::failure::Failure;
use super::loaded::Loaded;
use super::plan::{is_endless, playing};
use super::progress::Progress;
use super::stop::Stop;
use super::summary::size;
use super::terminal::Terminal;
use super::unsung::{LONGEST, sets_off};
use pacinian::graph::plan::Shared;
use pacinian::midi::file::Song;
use pacinian::patch::{Source, Trigger};
use pacinian::player::Player;
use pacinian::score::{Score, What};
use pacinian::space::spot::Spot;
use std::time::{Duration, Instant};

/// How long to play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// So many seconds.
    Seconds(f64),
    /// Until nothing plays or rings any more, and so many seconds.
    Over(f64),
}

/// What was met on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Performed {
    /// Frames of all channels.
    pub frames: u64,
    /// Largest magnitude of each channel.
    pub peaks: Vec<f32>,
    /// Wall time.
    pub run_time: Duration,
    /// The exit code to end with, where somebody stopped it.
    pub stopped: Option<u8>,
}

/// Frames of a block, where there are few channels.
const BLOCK: usize = 4096;

/// Frames of the first stretch: nobody knows yet how densely it plays.
const FIRST: usize = 16;

/// How long a stretch may take before the next is shorter.
const SLOW: Duration = Duration::from_millis(100);

/// Seconds for which it goes on for what `sink` makes of it, at most.
const PATIENCE: f64 = 10.0;

/// Samples of a block, at most.
const MOST: usize = 1 << 19;

impl Until {
    /// As the command line says, else the patch, else until it is over, or the input where it never would be.
    ///
    /// # Errors
    /// When it would never be over, or when nothing plays at all.
    pub fn of(loaded: &Loaded, player: &Player, asked: Option<f64>) -> Result<Self, Failure> {
        let patch = &loaded.patch;
        let rate = player.plan().device_rate;
        if let Some(seconds) = asked.or(patch.render.duration) {
            if (seconds * rate).round() >= 1.0 {
                return Ok(Self::Seconds(seconds));
            }
            let what =
                format!("{seconds} s are less than a frame at {rate} Hz, so there is nothing to render");
            return Err(match asked {
                Some(_) => Failure::usage(what, "say how many seconds: --duration 10"),
                None => {
                    let what = format!("{}: `duration` under [render]: {what}", loaded.name());
                    Failure::usage(
                        what,
                        "write a longer one, or leave it out to render until everything is over",
                    )
                    .with_code(65)
                }
            });
        }
        if let Some(song) = loaded.song.as_ref().filter(|song| song.seconds > LONGEST) {
            return Err(too_long(song, loaded.song_name.as_deref().unwrap_or("the song"), player));
        }
        let tail = patch.render.tail.unwrap_or(0.0);
        let heard = loaded.input.as_ref().map(|input| input.seconds());
        let sung = loaded.song.as_ref().map(|song| song.seconds);
        let lasts = heard.into_iter().chain(sung).reduce(f64::max);
        let playing = playing(loaded);
        let always = player.plan().instruments.iter().find(|i| i.always);
        // What the song begins and never ends; a key lets go of what it holds.
        let begins = |trigger: &&Trigger| {
            let messages = loaded.song.iter().flat_map(|song| &song.messages);
            trigger.on != Source::MidiNote
                && messages.into_iter().any(|(_, message)| sets_off(trigger, *message))
        };
        let begun = patch.triggers.iter().filter(begins);
        let begun = begun.filter_map(|trigger| patch.patterns.iter().find(|p| p.name == trigger.play));
        let endless =
            playing.iter().filter_map(|&i| patch.patterns.get(i)).chain(begun).find(|p| is_endless(p));
        // A control stands still, but for a song, which has an end.
        let moves =
            |signal: u32| !matches!(player.plan().shared.get(signal as usize), Some(Shared::Control(_)));
        let watch = player.plan().watches.iter().find(|watch| moves(watch.signal));
        let who = match (endless, always, watch) {
            (Some(pattern), ..) => format!("pattern `{}` repeats without end", pattern.name),
            (_, Some(voice), _) => format!("voice `{}` is always on", voice.name),
            (.., Some(watch)) => format!("`{}` may set off something at any time", watch.name),
            (None, None, None) if player.plan().instruments.is_empty() => {
                let what = format!("{}: nothing in this patch plays by itself", loaded.name());
                let notes = patch.triggers.iter().any(|t| t.on == Source::MidiNote);
                return Err(Failure::usage(
                    what,
                    match notes {
                        true => "give it a song: --midi SONG.mid; or play it live: pacinian play",
                        false => {
                            "give it a [pattern], a [[trigger]] with on = \"start\", or a voice with start = \"always\""
                        }
                    },
                )
                .with_code(65));
            }
            (None, None, None) => return Ok(Self::Over(tail)),
        };
        if let Some(seconds) = lasts.filter(|seconds| ((seconds + tail) * rate).round() >= 1.0) {
            return Ok(Self::Seconds(seconds + tail));
        }
        let example = player.length().filter(|length| *length > 0.0).map_or(10.0, f64::ceil);
        let hear = if player.plan().inputs().is_empty() {
            ""
        } else {
            "give it something to hear: --input FILE.wav; or "
        };
        Err(Failure::usage(
            format!("{}: {who}, so it has no length of its own", loaded.name()),
            format!(
                "{hear}say how many seconds: --duration {example}, or duration = {example} under [render] in the patch"
            ),
        ))
    }

    /// The length that it will turn out to have, as far as that is known.
    pub fn expected(self, player: &Player) -> Option<f64> {
        match self {
            Self::Seconds(seconds) => Some(seconds),
            Self::Over(tail) => player.length().map(|length| length + tail),
        }
    }
}

/// A song that is longer than anybody will have meant, unless somebody says so: files that are damaged or hostile last for years.
fn too_long(song: &Song, name: &str, player: &Player) -> Failure {
    let (hours, plan) = (|seconds: f64| seconds / 3600.0, player.plan());
    let place =
        song.pause.filter(|pause| pause.seconds > 0.1 * song.seconds).map_or(String::new(), |pause| {
            let (at, track) = (pause.at, pause.track + 1);
            format!(", {:.1} of them before the event at byte {at}, in track {track}", hours(pause.seconds))
        });
    let bytes = song.seconds * plan.device_rate * plan.channels as f64 * 4.0;
    let what = format!(
        "{name}: the song lasts {:.1} hours{place}, which would be {} of samples",
        hours(song.seconds),
        size(bytes.min(1e18) as u64)
    );
    let help = format!("say how much of it is wanted: --duration {LONGEST:.0}; or mend the file");
    Failure::usage(what, help).with_code(65)
}

/// Events that are unrolled beforehand to know how long they take, at most.
const FORESEEN: usize = 100_000;

/// As [`Until::expected`], and for patterns of draws and files as far as the same seed tells: seconds to the end of the last event.
fn foreseen(until: Until, loaded: &Loaded, player: &Player) -> Option<f64> {
    let (None, Until::Over(tail)) = (until.expected(player), until) else { return until.expected(player) };
    let roots: Vec<(usize, f64)> = playing(loaded).into_iter().map(|pattern| (pattern, 0.0)).collect();
    let open = |path: &str| loaded.events(path);
    let score = Score::new(&loaded.patch, |_| Ok(Spot::Row(0)), &roots, player.plan().seed, open).ok()?;
    let mut last = 0.0;
    for (n, event) in score.enumerate() {
        // Where a line is bad, playing ends too.
        let Ok(event) = event else { break };
        if n >= FORESEEN {
            return None;
        }
        let duration = if let What::Play(note) = event.what { note.duration } else { 0.0 };
        last = f64::max(last, event.at + duration);
    }
    Some(last + tail)
}

/// Plays, hears the input, and gives each block of interleaved frames to `sink`, with the player behind it; that says whether it may end as far as `sink`
/// goes.
///
/// # Errors
/// What `sink` says.
pub fn perform<E>(
    player: &mut Player,
    loaded: &Loaded,
    until: Until,
    stop: &Stop,
    terminal: &Terminal,
    mut sink: impl FnMut(&Player, &[f32]) -> Result<bool, E>,
) -> Result<Performed, (E, u64)> {
    let (channels, rate) = (player.plan().channels, player.plan().device_rate);
    let input = loaded.input.as_deref();
    let block = BLOCK.min(MOST / channels.max(1)).max(64);
    let mut buffer = vec![0.0; block * channels];
    let ears = player.engine().input_channels();
    let mut heard = vec![0.0; input.map_or(0, |_| block * ears)];
    let mut peaks = Peaks::new(channels);
    let total = if terminal.lively { foreseen(until, loaded, player) } else { None };
    let progress = Progress::new(terminal, total);
    let begin = Instant::now();
    let mut frames = 0_u64;
    let mut end = match until {
        Until::Seconds(seconds) => Some((seconds * rate).round() as u64),
        Until::Over(_) => None,
    };
    let (mut stopped, mut stretch) = (None, FIRST.min(block));
    let (mut rests, mut over) = (true, None);
    loop {
        if let (None, Until::Over(tail), true) = (end, until, player.is_over()) {
            let waited = (frames - *over.get_or_insert(frames)) as f64 / rate;
            if rests || waited >= PATIENCE {
                end = Some(frames + (tail * rate).round() as u64);
            }
        }
        stopped = stopped.or_else(|| stop.asked());
        let left = end.map_or(stretch, |end| end.saturating_sub(frames).min(stretch as u64) as usize);
        if left == 0 || stopped.is_some() {
            break;
        }
        let part = &mut buffer[..left * channels];
        let heard = &mut heard[..input.map_or(0, |_| left * ears)];
        if let Some(input) = input {
            input.fill(frames, ears, heard);
        }
        let began = Instant::now();
        player.process_input(heard, part);
        // What plays densely is played in shorter stretches, so that whoever waits sees it, and may stop it.
        stretch = match began.elapsed() {
            slow if slow > SLOW => (left / 4).max(1),
            quick if quick < SLOW / 8 => (stretch * 2).min(block),
            _ => stretch,
        };
        peaks.take(part);
        rests = sink(player, part).map_err(|error| (error, frames))?;
        frames += left as u64;
        progress.at(frames as f64 / rate);
        if player.trouble().is_some() {
            break;
        }
    }
    Ok(Performed { frames, peaks: peaks.finish(), run_time: begin.elapsed(), stopped })
}

/// Largest magnitudes, by channel; several frames side by side, so that the loop is a wide one.
struct Peaks {
    wide: Vec<f32>,
    channels: usize,
}

impl Peaks {
    fn new(channels: usize) -> Self {
        Self { wide: vec![0.0; channels * 32_usize.div_ceil(channels.max(1))], channels }
    }

    fn take(&mut self, frames: &[f32]) {
        for part in frames.chunks(self.wide.len().max(1)) {
            for (peak, sample) in self.wide.iter_mut().zip(part) {
                let size = sample.abs();
                *peak = if size > *peak { size } else { *peak };
            }
        }
    }

    fn finish(&self) -> Vec<f32> {
        let of = |c| self.wide.iter().skip(c).step_by(self.channels).copied().fold(0.0, f32::max);
        (0..self.channels).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Peaks, Until, foreseen, perform};
    use crate::cli::load::Scene;
    use crate::cli::paint::Paint;
    use crate::cli::stop::Stop;
    use crate::cli::terminal::Terminal;
    use pacinian::midi::file::{Pause, Song};
    use pacinian::player::Player;
    use std::convert::Infallible;

    #[test]
    fn what_is_drawn_has_a_length_beforehand() {
        let patch = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"o\"\n[voice.a.nodes]\n\
            s = { type = \"sine\", frequency = 250 }\ne = { type = \"envelope\", release = 0.01 }\n\
            o = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n[pattern.p]\njitter = { at = 0.5 }\n\
            events = [{ at = 1, choose = [{ voice = \"a\", duration = 0.5 }, { voice = \"a\", duration = 3 }] },\n\
            { at = 2, voice = \"a\", duration = 0.1, repeat = { every = 0.7, times = 4 } }]\n[render]\ntail = 0.5\n";
        let rig =
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\n[[tactor]]\nname = \"t1\"\nchannel = 1\n";
        for seed in 0..4 {
            let text = format!("{patch}seed = {seed}\n");
            let loaded = Scene::of_texts(("p", &text), ("r", rig), &[]).unwrap();
            let mut player = loaded.player().unwrap();
            let until = Until::of(&loaded, &player, None).unwrap();
            assert_eq!(until.expected(&player), None, "it is drawn");
            let foreseen = foreseen(until, &loaded, &player).unwrap();
            let terminal = Terminal { out: Paint(false), err: Paint(false), lively: false, pictured: false };
            let sink = |_: &Player, _: &[f32]| Ok::<bool, Infallible>(true);
            let Ok(performed) = perform(&mut player, &loaded, until, &Stop::default(), &terminal, sink);
            let seconds = performed.frames as f64 / 48_000.0;
            // What rings, and the block in which it is noticed.
            assert!((foreseen..foreseen + 0.2).contains(&seconds), "{foreseen} for {seconds}");
        }
    }

    #[test]
    fn a_song_without_end_is_refused_unless_somebody_says_how_long() {
        let patch = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"s\"\n[voice.a.nodes]\n\
            s = { type = \"sine\", frequency = 250 }\n[[trigger]]\non = \"midi.note\"\nplay = \"a\"\n";
        let rig =
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\n[[tactor]]\nname = \"t1\"\nchannel = 1\n";
        let mut loaded = Scene::of_texts(("p", patch), ("r", rig), &[]).unwrap();
        loaded.options.live = true;
        loaded.song_name = Some("long.mid".into());
        let song = |seconds| {
            let pause = Some(Pause { seconds: 0.9 * seconds, track: 1, at: 47 });
            Some(std::sync::Arc::new(Song { seconds, pause, ..Song::default() }))
        };
        loaded.song = song(36_000.0);
        let player = loaded.player().unwrap();
        let failure = format!("{:?}", Until::of(&loaded, &player, None).unwrap_err());
        for words in
            ["long.mid", "10.0 hours", "9.0 of them before the event at byte 47, in track 2", "--duration"]
        {
            assert!(failure.contains(words), "{words}: {failure}");
        }
        assert_eq!(Until::of(&loaded, &player, Some(5.0)).unwrap(), Until::Seconds(5.0));
        loaded.song = song(3_600.0);
        assert!(matches!(Until::of(&loaded, &player, None), Ok(Until::Over(_))));
    }

    #[test]
    fn peaks_are_those_of_their_channel() {
        for channels in [1, 3, 16, 50] {
            let mut peaks = Peaks::new(channels);
            let mut frames = vec![0.25; channels * 100];
            frames[42 * channels] = -0.75;
            frames[77 * channels + channels - 1] = 0.875;
            frames.chunks(channels * 9).for_each(|part| peaks.take(part));
            let mut expected = vec![0.25; channels];
            expected[0] = 0.75;
            expected[channels - 1] = 0.875;
            assert_eq!(peaks.finish(), expected, "{channels}");
        }
    }
}
