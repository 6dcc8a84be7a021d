//! `pacinian play`.

mod company;
mod conclusion;
mod end;
mod instruments;
mod opening;
mod prepared;

use super::advice;
use super::device_queue;
use super::ear::Listens;
use super::failure::Failure;
use super::hearers::Hearers;
use super::keep::{Keep, Sound};
use super::knob::turning::Turning;
use super::line::OnLine;
use super::load::Scene;
use super::osc::Osc;
use super::patience;
use super::screen::{Scenery, Show};
use super::stop::Stop;
use super::terminal::Terminal;
use super::watch::{Course, Watching};
use clap::Args;
use company::{Company, Parted};
use conclusion::Conclusion;
use end::End;
use instruments::Instruments;
use opening::Opening;
use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::Setting;
use pacinian::io::session::Beginning;
use pacinian::live::signal::Signal;
use pacinian::patch::knob::HAND;
use prepared::Prepared;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::SystemTime;

/// Plays a patch on a sound card, in real time
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pacinian play patches/04-heartbeat.toml --rig rigs/belt.toml --device \"USB Sound\"\n  \
    pacinian play patches/04-heartbeat.toml --device virtual --duration 5\n\n\
    With no device named, here or in the rig, or a sound system alone (but for JACK), it plays on the default, which may be headphones: at -20 dB until --arm. \
    With no sound card at all it plays on a virtual one, which keeps real time and is heard by nobody.\n\
    In a terminal it shows a meter for each tactor and takes keys: 1 to 9 start and stop patterns, or play what a trigger of theirs says (`key.1`); space stops all patterns, and starts those of the beginning, or the first, where none plays; p or Escape shuts \
    the output at once (c opens it again), a is full level or -20 dB, q ends it; t lets a knob's torque rise or go; Tab chooses a control, left and right move it (with \
    Shift further), 0 or d resets it. Anywhere else, and with --plain, it writes a line for \
    everything that happens.\n\
    With --watch, what is saved takes over while it sounds: what still exists keeps sounding, as the new patch has it, controls keep \
    their values, and of a file that is broken the errors are shown while the old one plays on.\n\
    Ctrl-C ends it: the output goes to exact zeros within 2 ms of the next block that the card asks for."
)]
pub struct Play {
    #[command(flatten)]
    scene: Scene,
    /// The sound card: its id, its name or a part of that, or `virtual` [default: what the rig says, else the system's default]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// The sound card that `input` nodes hear: its id, its name or a part of that, or `default`. It may be another than the one that is
    /// played on, at another rate [default: what the rig says, else silence]
    #[arg(long, value_name = "NAME", conflicts_with = "input")]
    input_device: Option<String>,
    /// Frames in a block [default: 256, or as near as the card can; 128 on the virtual card]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    block: Option<u32>,
    /// Full level on a device that nobody has named
    #[arg(long)]
    arm: bool,
    /// Lets the torque of a knob that the rig's `sensor` or `controller` reads rise as soon as its angle is known; else `t` does, or OSC
    #[arg(long)]
    torque: bool,
    /// Turns a simulated knob, though the rig says by what a real one is read
    #[arg(long, conflicts_with = "torque")]
    simulated: bool,
    #[command(flatten)]
    osc: Osc,
    /// The ports of MIDI to listen to, by a part of their names; `none` for none [default: all, if the patch has use for MIDI]
    #[arg(long, value_name = "NAME")]
    midi_in: Option<String>,
    #[command(flatten)]
    keep: Keep,
    /// Take over what is saved while it plays: the patch, the rig, and the recordings and tables that the patch names
    #[arg(long)]
    watch: bool,
    /// Seconds to play [default: until Ctrl-C]
    #[arg(long, value_name = "S", value_parser = super::render::seconds, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Whether keys turn the knob from the beginning on.
    #[arg(skip)]
    turned: bool,
}

/// Seconds that nobody plays.
const FOREVER: f64 = 1e9;

impl Play {
    /// Of a simulated knob that keys turn, on no card.
    pub fn turned(scene: Scene, duration: Option<f64>) -> Self {
        Self {
            scene,
            device: Some("virtual".into()),
            input_device: None,
            block: None,
            arm: false,
            torque: false,
            simulated: true,
            osc: Osc::default(),
            midi_in: Some("none".into()),
            keep: Keep::default(),
            watch: false,
            duration,
            turned: true,
        }
    }

    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        if self.watch {
            self.scene.check_watch()?;
        }
        let since = SystemTime::now();
        let Prepared { scene, loaded, wish, device, rate, armed, reload } = Prepared::of(self, terminal)?;
        let is_virtual = matches!(device, Chosen::Virtual(_));
        let instead = match &device {
            Chosen::Virtual(why) => *why,
            Chosen::Card(..) => None,
        };
        let name = opening::called(&device);
        let plan = &reload.scene.plan;
        let (channels, engine_rate, heard_from) = (plan.channels, plan.engine_rate(), plan.inputs());
        let mixes = device.mixes(channels);
        let files = self.keep.files().filter(|_| self.watch);
        let playing = files.clone().zip(reload.provenance.clone());
        // Before anything is opened: from here on, a signal ends it in order.
        let stop = Stop::listen()?;
        let (on_line, line) = OnLine::begin(&loaded, plan)?.unzip();
        // What is on a line is no affair of the card.
        let first = on_line.as_ref().map_or(usize::MAX, |knob| knob.first());
        let by_card: Vec<usize> = heard_from.iter().copied().filter(|channel| *channel < first).collect();
        let listens = (self.scene.input.as_deref(), self.input_device.as_deref());
        let mut listens = Listens::of(&loaded, listens, &by_card, (rate, self.block), &stop, terminal)?;
        let hears: Vec<String> =
            listens.note.take().into_iter().chain(line.iter().map(|line| line.note.clone())).collect();
        let hears = (!hears.is_empty()).then(|| hears.join("; "));
        let scenery = Scenery {
            loaded: &loaded,
            first: &reload.scene.patterns,
            device: device.name(),
            rate,
            armed,
            duration: self.duration,
            control: self.turned.then_some(HAND),
        };
        let (mut show, post) = Show::new(&scenery, terminal)?;
        let setting = Setting {
            heard: listens.heard.take(),
            loop_latency: loaded.rig.device.loop_latency,
            device_id: Some(device.id().into()),
            ..Setting::on(scenery.device, armed)
        };
        let journal = self.keep.journal(&reload, setting)?;
        // Before anything sounds: an address that cannot be had ends it.
        let socket = self.osc.bind()?;
        let announcer = self.osc.announcer(plan)?;
        let (verdict, verdicts) = channel();
        let hearers = Hearers { journal: journal.clone(), announcer: announcer.clone(), post: post.clone() };
        let knob = self.turned.then(|| Turning::of(plan));
        let mut listener = hearers.clone().listener();
        if let Some(knob) = &knob {
            listener = knob.beside(listener);
        }
        let waits = advice::waits(&loaded, &reload.scene.patterns).filter(|_| loaded.song.is_none());
        let beginning = Beginning {
            block: self.block,
            armed,
            input: listens.ear(hearers.clone().input_fate()),
            knob: on_line,
            record: self.keep.record.is_some(),
            record_input: self.keep.events.is_some(),
            song: loaded.song.clone(),
            listener: Some(listener),
            audience: hearers.clone().audience(verdict),
            fate: hearers.fate(),
            ..Beginning::of(reload, device)
        };
        let mut session = patience::begin(&name, beginning, &stop, terminal)?;
        // A signal closes the gate itself, whatever this thread is about.
        stop.also(&session.board().lever.closing())?;
        let sound = Sound::of(&mut session);
        let opening = Opening { loaded: &loaded, name: &name, channels, rate, engine_rate, armed };
        opening.tell(terminal);
        for more in [mixes, hears, waits].into_iter().flatten() {
            terminal.note(&format!("{more}\n"));
        }
        let osc = self.osc.listen(socket, session.handle(), &loaded.patch, announcer.as_ref(), terminal)?;
        let mut instruments = Instruments::new(self.midi_in.clone(), session.handle().clone(), post);
        instruments.open_for(&loaded.patch)?;
        if self.torque {
            let _ = session.handle().send(Signal::Torque(true));
        }
        let course = Course {
            scene: Scene { midi: None, offered: vec![channels as u16], ..scene },
            device_rate: f64::from(rate),
            device: self.device.clone(),
            wish,
            rate: loaded.rig.device.rate,
            input: loaded.rig.device.input.clone(),
            input_device: self.input_device.clone(),
            heard: heard_from,
            knob_channel: if first == usize::MAX { 0 } else { first },
            channels,
            files: files.clone(),
        };
        // Only now, so that a session that could not begin has touched nothing.
        let kept = self.keep.begin(sound, journal, files, &loaded)?;
        let (folder, patch) = (Arc::clone(&loaded.folder), Arc::clone(&loaded.patch));
        let keep_what_plays = move || {
            if let Some((files, made_of)) = playing {
                files.keep(&folder, &patch, &made_of).unwrap_or_else(|error| files.fail(error));
            }
        };
        let song_ends = Company::song_ends(&loaded);
        let mut company = Company {
            loaded,
            kept,
            announcer,
            osc,
            counts: None,
            instruments,
            watching: None,
            line,
            song_ends,
        };
        if self.watch {
            let handle = session.handle().clone();
            match Watching::begin(course, since, handle, verdicts, keep_what_plays) {
                Ok(watching) => company.watching = Some(watching),
                Err(error) => {
                    return Err(company.abandon(Failure::no_thread("files that are watched", &error)));
                }
            }
        }
        if let Err(failure) = show.begin(session.board().lever.closing()) {
            return Err(company.abandon(failure));
        }
        if let Some(why) = instead {
            show.say_on_screen(&format!("a virtual card plays, which nobody feels, since {why}"));
        }
        let end = End::wait(self.duration, &session, &stop, &mut show, |show| company.look(&session, show));
        // The gate closes before anything else is done, even where the conductor is no more.
        session.handle().from(end.origin()).end();
        let held = (!is_virtual).then(|| device_queue::told(session.board()));
        company.close();
        let peaks = show.end(session.board(), terminal);
        session.stop();
        let Parted { loaded, kept, line } = company.leave(&session, terminal);
        let conclusion = Conclusion {
            loaded: &loaded,
            session: &session,
            peaks: &peaks,
            held: held.as_deref(),
            asked: self.duration.filter(|_| end == End::Over),
        };
        let concluded = conclusion.tell(terminal);
        line.iter().for_each(|line| terminal.note(&line.conclude()));
        let told = knob.map_or(Ok(()), |knob| knob.told(&loaded, session.board(), terminal));
        // Whoever has asked it to stop is told of what was lost as well.
        let mut failure = end.code().map_or(Failure::default(), Failure::told);
        for part in [kept.finish(session.board(), terminal), concluded, told] {
            part.err().into_iter().for_each(|part| failure.join(part));
        }
        if failure.is_none() { Ok(()) } else { Err(failure) }
    }
}
