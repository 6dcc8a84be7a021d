//! A patch and a rig from the command line, with everything that is wrong with them.

use super::by_default;
use super::failure::Failure;
use super::felt::Felt;
use super::loaded::Loaded;
use super::named::{Watched, named, unreadable};
use super::rise;
use super::setting::{self, Setting};
use super::unsung::{only_voice, unsung};
use clap::{Args, ValueEnum};
use pacinian::graph::plan::Precision;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::{motions, quick};
use pacinian::io::{
    assets::{Folder, recordings_rate},
    calibrations,
    error::FileErrorKind,
    events,
    input::Input,
    journal::of_bytes,
    song,
    song::SongError,
    text,
};
use pacinian::patch::{self, Events, Patch, Start};
use pacinian::rig::{RATES, Rig};
use pacinian::space::spot::Spread;
use pacinian::text::{Checked, Origin, Problem, Problems, Sink, nearest};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is played on what, and how.
#[derive(Debug, Clone, Args)]
pub struct Scene {
    /// The patch, a TOML file: what is felt, and when; - for standard input
    pub patch: PathBuf,
    /// The rig, a TOML file: which tactor hangs on which channel [default: a line of tactors, t1 to t8, or as many as the patch needs]
    #[arg(long, value_name = "RIG")]
    pub rig: Option<PathBuf>,
    /// The pattern to play [default: those that a trigger with on = "start" names, else the first, unless keys or messages play something]
    #[arg(long, value_name = "NAME")]
    pub pattern: Option<String>,
    /// Samples a second [default: what the rig says, else 48000, or what a card has that is nearest]
    #[arg(long, value_name = "HZ", value_parser = hertz, allow_negative_numbers = true)]
    pub rate: Option<u32>,
    /// The seed of everything random [default: what the patch says, else 0]
    #[arg(long, value_name = "N", value_parser = seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Sets a control of the patch from the start on, in place of its `default`; may be given for each control
    #[arg(long = "set", value_name = "CONTROL=VALUE")]
    pub settings: Vec<Setting>,
    /// Number type that voices are computed in
    #[arg(long, value_name = "TYPE", value_enum, default_value_t = Number::F32)]
    pub precision: Number,
    /// Taps a phase of the filter that brings the engine's rate to the device's, 4 to 12
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u8).range(4..=12))]
    pub taps: u8,
    /// What the patch's `input` nodes hear, a WAV file of any rate [default: silence]
    #[arg(long, value_name = "FILE.wav")]
    pub input: Option<PathBuf>,
    /// A Standard MIDI File that plays the patch, through its triggers and bindings
    #[arg(long, visible_alias = "midi-file", value_name = "SONG.mid")]
    pub midi: Option<PathBuf>,
    /// Lets notes of MIDI play this voice too, at their pitch, whatever the triggers of the patch do
    #[arg(long, value_name = "VOICE")]
    pub notes: Option<String>,
    /// Lets recordings and events files lie outside the patch's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Where no rig is named, the numbers of channels of which the line of tactors is to have one; none: any.
    #[arg(skip)]
    pub offered: Vec<u16>,
    /// Whether somebody keeps a journal, which has a digest of each file.
    #[arg(skip)]
    pub journalled: bool,
    /// Whether it is played on a real card.
    #[arg(skip)]
    pub on_card: bool,
    /// Whether it is played live, and whether somebody has named a device to listen to.
    #[arg(skip)]
    pub live: bool,
    /// See `live`.
    #[arg(skip)]
    pub hears: bool,
    /// Whether the knob is simulated, whatever the rig reads it by.
    #[arg(skip)]
    pub simulated: bool,
    /// Frames of a device's block, where they are known.
    #[arg(skip)]
    pub block: Option<u32>,
    /// Recordings that need no disk.
    #[arg(skip)]
    pub held: &'static [(&'static str, &'static [u8])],
}

/// Whether a rig has a knob on a serial line.
pub fn serial(rig: &Rig) -> bool {
    rig.knob.as_ref().is_some_and(|knob| knob.controller.is_some())
}

/// A rate that a WAV file can say and the engine can serve.
fn hertz(word: &str) -> Result<u32, String> {
    let [least, most] = RATES;
    let known = format!("whole hertz from {least} to {most}, such as 44100 or 48000");
    if let Ok(rate) = word.parse::<f64>() {
        return match rate {
            _ if rate.fract() == 0.0 && (least..=most).contains(&rate) => Ok(rate as u32),
            _ if (least / 1e3..=most / 1e3).contains(&rate) => {
                Err(format!("it is in {known}; is {} meant?", (rate * 1e3).round()))
            }
            _ => Err(format!("it must be {known}")),
        };
    }
    let thousands = word.trim_end_matches("Hz").trim_end_matches("hz").trim_end_matches(['k', 'K']);
    match thousands.trim().parse::<f64>() {
        Ok(rate) if rate.is_finite() => {
            let factor = if word.contains(['k', 'K']) { 1e3 } else { 1.0 };
            Err(format!("it is a number without a unit, {known}: --rate {}", (rate * factor).round()))
        }
        _ => Err(format!("it must be {known}")),
    }
}

/// A seed.
fn seed(word: &str) -> Result<u64, String> {
    word.parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Number {
    /// 32 bits
    F32,
    /// 64 bits
    F64,
}

impl Scene {
    /// Reads and checks everything. With `all`, also what never sounds; of an input, no more than `duration` (s) needs.
    ///
    /// # Errors
    /// All problems of patch, rig, recordings and events files at once.
    pub fn load(&self, all: bool, duration: Option<f64>) -> Result<Loaded, Failure> {
        let mut failure = Failure::default();
        if self.rig.as_ref().is_some_and(|rig| text::is_same_stream(&self.patch, rig)) {
            return Err(Failure::usage(
                "patch and rig cannot both come from standard input",
                "name a file for one of them: --rig RIG",
            ));
        }
        let patch = read(&self.patch, 65, &mut failure);
        let rig = self.rig.as_ref().map(|path| read(path, 78, &mut failure));
        self.understand(patch, rig, failure, all, duration)
    }

    /// A patch as it is where nothing else is said.
    fn bare(patch: PathBuf) -> Self {
        Self {
            patch,
            rig: None,
            pattern: None,
            rate: None,
            seed: None,
            settings: Vec::new(),
            precision: Number::F32,
            taps: 6,
            input: None,
            midi: None,
            notes: None,
            allow_outside: false,
            offered: Vec::new(),
            journalled: false,
            on_card: false,
            live: false,
            hears: false,
            simulated: false,
            block: None,
            held: &[],
        }
    }

    /// A patch on a rig, of which nothing else is said.
    pub fn of_files(patch: &Path, rig: &Path, pattern: Option<String>, rate: Option<u32>) -> Self {
        Self { rig: Some(rig.into()), pattern, rate, ..Self::bare(patch.into()) }
    }

    /// A scene from texts and recordings that are at hand; nothing else is read from the disk but what they name.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn of_texts(
        patch: (&str, &str),
        rig: (&str, &str),
        held: &'static [(&'static str, &'static [u8])],
    ) -> Result<Loaded, Failure> {
        let scene = Self { held, ..Self::bare(patch.0.into()) };
        let text = |(name, text): (&str, &str)| Text { name: name.into(), bytes: Some(text.into()) };
        scene.understand(text(patch), Some(text(rig)), Failure::default(), false, None)
    }

    fn understand(
        &self,
        patch: Text,
        rig: Option<Text>,
        mut failure: Failure,
        all: bool,
        duration: Option<f64>,
    ) -> Result<Loaded, Failure> {
        let mut warnings = Vec::new();
        let Text { name, bytes } = patch;
        let may = patch::Permissions { allow_outside: self.allow_outside };
        let parsed = bytes.as_ref().map(|bytes| {
            Patch::parse_with(&name, bytes, may).map_err(|mut problems| {
                // Nothing will be compiled, but trouble with its files is told along with the rest.
                let part = Patch::readable(bytes, may);
                let folder = Folder::new(self.root()).allow_outside(self.allow_outside).holding(self.held);
                problems.list.extend(part.iter().flat_map(|part| unreadable(part, &folder)).take(Sink::MOST));
                problems.list.sort_by_key(|p| p.span.as_ref().map_or(0, |s| s.start + 1));
                problems
            })
        });
        let patch = parsed.and_then(|parsed| sound(parsed, 65, &mut warnings, &mut failure));
        let rig_source = rig.as_ref().map(|rig| {
            let text = rig.bytes.as_deref().map(String::from_utf8_lossy).unwrap_or_default();
            Origin { file: rig.name.as_str().into(), source: text.as_ref().into() }
        });
        let mut tables = Vec::new();
        let given = rig.map(|Text { name, bytes }| {
            let parsed = Rig::parse(&name, &bytes?);
            let mut rig = sound(parsed, 78, &mut warnings, &mut failure)?;
            let origin = rig_source.clone().unwrap_or_default();
            let (read, wrong) = calibrations::fill(&mut rig, &origin, &self.beside_rig());
            tables = read;
            let is_right = wrong.is_empty();
            wrong.into_iter().for_each(|problems| failure.join(Failure::of(78, problems)));
            is_right.then_some(rig)
        });
        let (patch, rig) = match (patch, given) {
            (Some(patch), None) => (patch, None),
            (Some(patch), Some(Some(rig))) => (patch, Some(rig)),
            _ => return Err(failure),
        };
        warnings.retain(|w: &Problems| !w.list.is_empty());
        let source = String::from_utf8(bytes.unwrap_or_default()).unwrap_or_default();
        let source = Problems { file: name, source, list: Vec::new() };
        let mut loaded = self.join(patch, rig, source, warnings, all, duration)?;
        loaded.rig_source = rig_source;
        loaded.files.extend(tables.iter().map(|table| table.real.clone()));
        loaded.tables = tables;
        Ok(loaded)
    }

    /// The folder that paths of the patch count from.
    pub fn root(&self) -> &Path {
        // What comes through a pipe lies nowhere: its paths count from where the person is.
        let parent = self.patch.parent().filter(|_| !text::is_stream(&self.patch));
        parent.unwrap_or(Path::new(""))
    }

    /// The folder that paths of the rig count from.
    fn beside_rig(&self) -> Folder {
        let path = self.rig.as_ref().filter(|path| !text::is_stream(path));
        let folder = path.and_then(|path| path.parent()).unwrap_or(Path::new(""));
        Folder::new(folder).allow_outside(self.allow_outside)
    }

    /// What is wrong with patch and rig together.
    fn join(
        &self,
        mut patch: Patch,
        given: Option<Rig>,
        source: Problems,
        mut warnings: Vec<Problems>,
        all: bool,
        duration: Option<f64>,
    ) -> Result<Loaded, Failure> {
        let by_default = given.is_none();
        let rig = given.unwrap_or_else(|| by_default::rig(&patch, &self.offered));
        self.check_words(&patch)?;
        setting::set(&mut patch, &self.settings)?;
        let always = |name: &String| patch.voices.iter().any(|v| v.name == *name && v.start == Start::Always);
        if let Some(voice) = self.notes.as_ref().filter(|name| always(name)) {
            let what = format!("--notes: voice `{voice}` is always on, so no note can start it");
            return Err(Failure::usage(what, "name another voice"));
        }
        if let Some(voice) = self.notes.as_ref().filter(|voice| !patch.key(voice)) {
            let near = nearest::suggest(voice, patch.voices.iter().map(|v| v.name.as_str()));
            let help = near.unwrap_or_else(|| "a patch declares them with [voice.NAME]".into());
            return Err(Failure::usage(format!("--notes: the patch has no voice `{voice}`"), help));
        }
        let notes = self.notes.clone().or_else(|| {
            let (voice, told) = self.midi.as_ref().and_then(|song| only_voice(&patch, song))?;
            patch.key(&voice).then(|| {
                warnings.push(told);
                voice
            })
        });
        let rate = self.rate.map(f64::from).or(rig.device.rate).unwrap_or(48_000.0);
        if rate.fract() != 0.0 {
            let what = format!("the rig's device has a rate of {rate} Hz, which no WAV file can say");
            return Err(Failure::usage(what, format!("give a whole number: --rate {rate:.0}")));
        }
        let root = self.root();
        let folder = Folder::new(root)
            .allow_outside(self.allow_outside)
            .at_rate(recordings_rate(rate))
            .holding(self.held);
        let folder = if self.journalled { folder.digesting(of_bytes) } else { folder };
        let folder = Arc::new(folder);
        let (hears, on_line) = (self.hears || rig.device.input.is_some(), serial(&rig));
        let options = Options {
            rate: Some(rate),
            precision: match self.precision {
                Number::F32 => Precision::Single,
                Number::F64 => Precision::Double,
            },
            taps: usize::from(self.taps),
            seed: self.seed,
            pattern: self.pattern.clone(),
            // What comes in by a file is what the sensor says.
            attached: !self.simulated && (self.input.is_some() || (self.live && (hears || on_line))),
            block: self.block,
            on_card: self.on_card,
            live: self.midi.is_some() || (all && patch.triggers.iter().any(|t| t.on.is_live())),
            ..Options::default()
        };
        let watched = Watched::new(&folder);
        let mut problems = rig.check_places(&patch);
        let live = Options { live: true, ..options.clone() };
        let (mut listened, mut sensed, mut unheard, mut short) = (Vec::new(), Vec::new(), None, None);
        let compiled = scene(&patch, &rig, if all { &live } else { &options }, &watched);
        let (mut felt, mut rises, mut unplayed) = (None, None, None);
        match &compiled {
            Ok(scene) => {
                rises = Some(rise::search(&patch, &rig, scene));
                unplayed = super::unplayed::search(&patch, &rig, scene);
                felt = Some(Felt::new(&patch, &rig, scene));
                listened = scene.plan.inputs();
                sensed = scene.plan.sensor().map_or(Vec::new(), |sensor| sensor.channels.to_vec());
                unheard = setting::unheard(&patch, &self.settings, &scene.plan.left_out);
                short = super::coupled::short(&patch, &scene.plan);
            }
            Err(more) => problems.extend(more.list.clone()),
        }
        // A comparison with the reference goes on for a moment.
        let needed = duration.or(patch.render.duration).map(|seconds| seconds + 1.0);
        let heard = |path: &PathBuf| {
            Input::open_for(path, rate, &listened, needed).map(|input| input.marking(&sensed))
        };
        let heard = self.input.as_ref().map(heard).transpose();

        let (mut surveyed, mut unfelt, mut bad_tables) = (Vec::new(), Vec::new(), Vec::new());
        let mut seen = watched.finish();
        for pattern in &patch.patterns {
            let Events::File(path, span) = &pattern.events else { continue };
            if surveyed.iter().any(|(p, _)| p == path) {
                continue;
            }
            let resolve = |place: &patch::Place| rig.resolve(Some(place), &(0..0)).err();
            let unit = pattern.time.seconds() / pattern.rate;
            let feel = |play: &patch::Play| {
                unplayed.iter_mut().for_each(|unplayed| unplayed.row(play));
                let capped = felt.as_mut().and_then(|felt| felt.event(play, unit));
                capped.or_else(|| rises.as_mut()?.row(play, pattern))
            };
            match events::survey_with(&folder, path, &patch, resolve, feel) {
                Ok(mut survey) => {
                    surveyed.push((path.clone(), survey.events));
                    seen.paths.extend(folder.resolve(path));
                    if by_default {
                        by_default::advise_a_rig(&mut survey.problems, &source.source);
                    }
                    // Where the table is named is told once.
                    let line = source.position(span.start).0;
                    if let Some(first) = survey.problems.iter_mut().find(|p| p.is_error()) {
                        let named = format!("`{path}` is named in {}:{line}", source.file);
                        let help = first.help.take();
                        first.help = Some(help.map_or(named.clone(), |help| format!("{help}; {named}")));
                    }
                    let table = Origin {
                        file: root.join(path).display().to_string().into(),
                        source: survey.source.into(),
                    };
                    bad_tables.extend(Some(table.problems(survey.problems)).filter(Problems::has_errors));
                    unfelt.extend(Some(table.problems(survey.advice)).filter(|p| !p.list.is_empty()));
                }
                Err(error) => {
                    problems.push(Problem::error(span, error.message.as_str()));
                    seen.failures.insert(path.clone(), error.exit_code());
                }
            }
        }
        if by_default {
            by_default::advise_a_rig(&mut problems, &source.source);
        }
        let codes = seen.codes(&patch);
        let capped = felt.and_then(Felt::advice);
        let unrisen = rises.and_then(rise::Search::advice);
        let unplayed = unplayed.and_then(super::unplayed::Search::advice);
        let moves = compiled.as_ref().ok().map(|scene| {
            let array = scene.plan.spread.as_ref().map(Spread::array);
            let mut told = motions::remarks(&patch, array);
            told.extend(quick::advice(&patch, array));
            patch.origin.problems(told)
        });
        let mut files = seen.paths;
        files.extend(named(&patch).filter_map(|(path, _)| folder.resolve(path).ok()));
        let mut loaded = Loaded {
            patch: Arc::new(patch),
            rig,
            options,
            warnings,
            surveyed,
            settings: self.settings.clone(),
            notes,
            files,
            tables: Vec::new(),
            song: None,
            song_digest: None,
            song_name: self.midi.as_ref().map(|path| path.display().to_string()),
            input: None,
            input_name: self.input.as_ref().map(|path| path.display().to_string()),
            rig_source: None,
            source,
            folder,
        };
        let read = [Some(&self.patch), self.rig.as_ref(), self.input.as_ref(), self.midi.as_ref()]
            .into_iter()
            .flatten();
        // Standard input may be a file, too.
        let on_disk =
            |path: &PathBuf| if path.as_os_str() == "-" { "/dev/stdin".into() } else { path.clone() };
        loaded.files.extend(read.map(on_disk));
        let hears = self.hears || (self.live && hears);
        let by_card = |channel: &usize| !on_line || !sensed.contains(channel);
        let deaf = self.input.is_none() && !hears && listened.iter().any(by_card);
        loaded.warnings.extend(unheard);
        loaded.warnings.extend(short);
        loaded.warnings.extend(capped);
        loaded.warnings.extend(unrisen);
        loaded.warnings.extend(unplayed);
        loaded.warnings.extend(moves.filter(|told| !told.list.is_empty()));
        loaded.warnings.extend(unfelt);
        loaded.warnings.extend(super::advice::of(&loaded, by_default, deaf, self.live));
        let mut failure = Failure::default();
        if problems.iter().any(Problem::is_error) {
            failure.join(loaded.refuse(problems, &codes));
        }
        bad_tables.into_iter().for_each(|table| failure.join(Failure::of(65, table)));
        let digest = &mut loaded.song_digest;
        let read = |path| song::read_with(path, |bytes| *digest = Some(of_bytes(bytes)));
        match self.midi.as_ref().map(read).transpose() {
            Ok(song) => {
                let song = song.map(|song| {
                    loaded.warnings.extend(Some(song.warnings).filter(|warnings| !warnings.list.is_empty()));
                    let unsung = self.midi.as_ref().and_then(|path| unsung(&loaded.patch, path, &song.value));
                    loaded.warnings.extend(unsung);
                    Arc::new(song.value)
                });
                loaded.song = song;
            }
            Err(SongError::File(error)) => failure.join(error.into()),
            Err(SongError::Song(problems)) => failure.join(Failure::of(65, problems)),
        }
        match heard {
            Ok(heard) if failure.is_none() => loaded.hear(heard, &listened),
            Ok(_) => {}
            Err(error) => failure.join(error.into()),
        }
        if failure.is_none() { Ok(loaded) } else { Err(failure) }
    }

    /// Words of the command line that must fit the patch.
    fn check_words(&self, patch: &Patch) -> Result<(), Failure> {
        let Some(name) = &self.pattern else { return Ok(()) };
        let names = || patch.patterns.iter().map(|p| p.name.as_str());
        if names().any(|n| n == name) {
            return Ok(());
        }
        let help = nearest::suggest(name, names()).unwrap_or_else(|| "see `pacinian check`".into());
        Err(Failure::usage(format!("the patch has no pattern `{name}`"), help))
    }
}

/// A file as it was read.
struct Text {
    name: String,
    bytes: Option<Vec<u8>>,
}

/// What was parsed, if it could be; warnings and failures go where they belong.
fn sound<T>(
    parsed: Result<Checked<T>, Problems>,
    code: u8,
    warnings: &mut Vec<Problems>,
    failure: &mut Failure,
) -> Option<T> {
    match parsed {
        Ok(checked) => {
            warnings.push(checked.warnings);
            Some(checked.value)
        }
        Err(problems) => {
            failure.join(Failure::of(code, problems));
            None
        }
    }
}

/// A document; `code` is that of one whose content is wrong.
fn read(path: &Path, code: u8, failure: &mut Failure) -> Text {
    let name = if path.as_os_str() == "-" { "stdin".into() } else { path.display().to_string() };
    match text::read(path) {
        Ok(bytes) => Text { name, bytes: Some(bytes) },
        Err(error) => {
            let malformed = error.kind == FileErrorKind::Malformed;
            let told = Failure::from(error);
            failure.join(if malformed { told.with_code(code) } else { told });
            Text { name, bytes: None }
        }
    }
}
