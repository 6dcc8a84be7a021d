//! What is told of a session, line by line: with the names that its plans give, where in the patterns an event stands, and its times.

use std::cell::Cell;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use super::kind::Kind;
use super::line::Line;
use super::names::Names;
use super::words;
use super::world;
use crate::engine::event::Event;
use crate::engine::turnover::{Turn, Turned};
use crate::engine::watch::{Crossing, SetOff};
use crate::graph::answer::Started;
use crate::graph::plan::Plan;
use crate::live::board::Board;
use crate::live::callback::{Deed, Report};
use crate::live::clock::Moment;
use crate::live::conductor::Told;
use crate::live::signal::Stamped;
use crate::live::stamp::{Epoch, Stamp};
use crate::performer::{Happening, Heard};
use crate::schedule::Instant;

/// Origins of events that may wait for the callback to take them.
const PENDING: usize = 1 << 17;

/// By more than this, a clock that is another was set; by less, it was only read a little later.
const SET: Duration = Duration::from_millis(2);

/// Makes lines of what is told of a session.
#[derive(Debug)]
pub struct Chronicle {
    /// What sounds, and what has not taken over yet.
    names: Names,
    /// With the number of the signal that asked for it.
    next: VecDeque<(Names, u64)>,
    /// Where events come from, by their ids; of markers, what they are called as well.
    voices: BTreeMap<u64, Stand>,
    markers: BTreeMap<u64, (String, Stand)>,
    began: Option<(Epoch, Cell<SystemTime>)>,
    /// That of the session, once it has begun.
    pub board: Arc<Board>,
}

/// Where in the patterns an event stands, counted from 1.
#[derive(Debug, Clone)]
struct Stand {
    pattern: String,
    event: u64,
    drawn: Option<u64>,
}

/// What is beyond the sample of an instant.
fn fraction(instant: Instant) -> f64 {
    f64::from(instant.fraction) / 4_294_967_296.0
}

/// The number of the signal that asked for something; 0 is none.
fn signalled(cause: u64) -> Option<u64> {
    (cause > 0).then_some(cause)
}

/// When a session began that has gone on for so long, by a clock that says `now`; as it said at the beginning, unless it was set since.
fn began(then: SystemTime, elapsed: Duration, now: SystemTime) -> SystemTime {
    let by_now = now.checked_sub(elapsed).unwrap_or(then);
    let off = by_now.duration_since(then).unwrap_or_else(|error| error.duration());
    if off > SET { by_now } else { then }
}

impl Chronicle {
    /// Of a session that begins with `plan`.
    pub fn of(plan: &Plan) -> Self {
        Self {
            names: Names::of(plan),
            next: VecDeque::new(),
            voices: BTreeMap::new(),
            markers: BTreeMap::new(),
            began: None,
            board: Arc::default(),
        }
    }

    /// For the listener of the session: a line of what is not told of otherwise.
    pub fn hear(&mut self, heard: &Heard<'_>) -> Option<Line> {
        if let Happening::Message(message) = heard.what {
            return Some(Line {
                source: Some(words::SONG.into()),
                id: heard.id,
                message: Some(words::hexadecimal(&message.bytes())),
                due_sample: Some(heard.instant.sample),
                due_fraction: Some(fraction(heard.instant)),
                ..self.now(Kind::In)
            });
        }
        let origin = heard.origin?;
        let (event, drawn) = (origin.event + 1, origin.drawn.map(|drawn| u64::from(drawn) + 1));
        let stand = Stand { pattern: origin.pattern.into(), event, drawn };
        match (heard.what, heard.id) {
            // Those of events that found no room, or were called off, would stay for ever.
            (Happening::Marker(name), Some(id)) => {
                self.markers.insert(id, (name.into(), stand));
                if self.markers.len() > PENDING {
                    self.markers.pop_first();
                }
            }
            (_, Some(id)) => {
                self.voices.insert(id, stand);
                if self.voices.len() > PENDING {
                    self.voices.pop_first();
                }
            }
            _ => {}
        }
        None
    }

    /// For its audience: a line, where there is one to be made of it.
    pub fn told(&mut self, told: &Told<'_>) -> Option<Line> {
        match told {
            Told::Began(epoch, board) => {
                let elapsed = epoch.instant(Stamp(0)).elapsed();
                let utc = SystemTime::now().checked_sub(elapsed).unwrap_or(SystemTime::now());
                (self.began, self.board) = (Some((*epoch, Cell::new(utc))), Arc::clone(board));
                None
            }
            Told::Came(stamped) => Some(self.came(stamped)),
            Told::Lost(port, name) => Some(Line {
                source: Some("midi".into()),
                name: Some(port.to_string()),
                peer: name.map(String::from),
                message: Some("cable lost, panic".into()),
                ..self.now(Kind::In)
            }),
            Told::Report(report, moment) => Some(self.report(report, *moment)),
            Told::Reloading(reload, cause) => {
                self.next.push_back((Names::of(&reload.scene.plan), *cause));
                None
            }
            Told::Refused(problem, cause) => Some(self.refused(None, &problem.to_string(), *cause)),
            Told::Vain(why, cause) => Some(self.refused(None, why, *cause)),
            Told::Kept(why, cause) => Some(self.refused(Some("reload"), why, *cause)),
            Told::Playing(_) | Told::Reloaded => None,
        }
    }

    /// Seconds of the engine's delay.
    pub fn delay(&self) -> f64 {
        self.board.engine_delay.get() as f64 * 1e-9
    }

    /// The time of day, so many seconds after the beginning, by the system's clock as it goes now: where that is set meanwhile, times are others from
    /// then on.
    pub fn time(&self, seconds: f64) -> Option<SystemTime> {
        let (epoch, utc) = self.began.as_ref()?;
        let (before, now, after) = (epoch.now().seconds(), SystemTime::now(), epoch.now().seconds());
        // Else this thread has waited in between, and does not know.
        if after - before < 0.5 * SET.as_secs_f64() {
            utc.set(began(utc.get(), Duration::try_from_secs_f64(before).ok()?, now));
        }
        utc.get().checked_add(Duration::try_from_secs_f64(seconds).ok()?)
    }

    /// The same in words.
    pub fn date(&self, seconds: f64) -> Option<String> {
        self.time(seconds).map(|time| humantime::format_rfc3339_nanos(time).to_string())
    }

    /// A line of something that is noticed now.
    pub fn now(&self, kind: Kind) -> Line {
        let seconds = self.began.as_ref().map(|(epoch, _)| epoch.now().seconds());
        Line { seconds, utc: seconds.and_then(|seconds| self.date(seconds)), ..Line::new(kind) }
    }

    fn report(&mut self, report: &Report, moment: Option<Moment>) -> Line {
        let mut line = match &report.deed {
            Deed::Event { at, due, source, event, cause } => {
                let line = self.event(*at, *due, words::of_source(*source), event, moment);
                Line { cause: signalled(*cause), ..line }
            }
            Deed::Crossing(crossing @ Crossing { at, .. }) => match &crossing.what {
                SetOff::Voice(play) => self.event(*at, *at, words::NODE, &Event::Play(*play), moment),
                SetOff::Pattern(started) => self.set_off(crossing, started),
            },
            Deed::Turn(Turn { at, what: Turned::Began(play) }) => {
                self.event(*at, *at, words::ALWAYS, &Event::Play(*play), moment)
            }
            Deed::Turn(Turn { at, what: Turned::Stolen(id, by) }) => {
                let line = Line { id: Some(*id), message: Some(by.to_string()), ..Line::new(Kind::Stolen) };
                self.timed(line, *at, moment)
            }
            Deed::Followed(followed) => Line {
                sample: Some(followed.sample),
                fraction: Some(0.0),
                fields: world::fields(&followed.message),
                ..Line::new(Kind::Model)
            },
            Deed::Order(order, cause) => {
                let (name, value) = words::of_order(*order);
                // What the device still holds goes out whatever the gate does.
                let held = self.board.device_delay.get().map(|held| held as f64 * 1e-9);
                let fields = held.map(|held| ("device_delay".into(), held)).into_iter().collect();
                let cause = signalled(*cause);
                Line { name: Some(name.into()), value, fields, cause, ..Line::new(Kind::Gate) }
            }
            Deed::Steps(steps) => {
                Line { value: Some(f64::from(steps.bits().unwrap_or(0))), ..Line::new(Kind::Steps) }
            }
            Deed::Swap => {
                let mut line = Line::new(Kind::Swap);
                if let Some((names, cause)) = self.next.pop_front() {
                    (self.names, line.cause) = (names, signalled(cause));
                }
                line
            }
        };
        line.frame = Some(report.frame);
        if line.seconds.is_none()
            && let Some(moment) = moment
        {
            // What the gate does leaves the converter behind all that the device holds; the engine is in front of it.
            let held = if line.kind == Kind::Gate { self.board.device_delay.seconds() } else { 0.0 };
            line.seconds = Some(moment.time_of(report.frame as f64) + held);
            line.utc = line.seconds.and_then(|seconds| self.date(seconds));
        }
        line
    }

    /// A pattern is started by what the engine has come to: like something that came in.
    fn set_off(&self, crossing: &Crossing, started: &Started) -> Line {
        let Crossing { at, watch, .. } = crossing;
        let name = self.names.watches.get(*watch as usize).map(ToString::to_string);
        let source =
            if name.as_ref().is_some_and(|name| name.starts_with("knob.")) { "knob" } else { words::NODE };
        let pattern = self.names.patterns.get(started.pattern as usize).map_or("", |name| &**name);
        let fields = [("gain", started.gain), ("rate", started.rate)];
        Line {
            source: Some(source.into()),
            id: Some(crossing.id()),
            name,
            message: Some(format!("start {pattern}")),
            fields: fields.into_iter().map(|(name, value)| (name.to_string(), value)).collect(),
            due_sample: Some(at.sample),
            due_fraction: Some(fraction(*at)),
            ..Line::new(Kind::In)
        }
    }

    fn event(
        &mut self,
        at: Instant,
        due: Instant,
        source: &str,
        event: &Event,
        moment: Option<Moment>,
    ) -> Line {
        let mut line = self.names.line(event);
        line.source = Some(source.into());
        (line.due_sample, line.due_fraction) = (Some(due.sample), Some(fraction(due)));
        let stand = match event {
            Event::Play(play) => self.voices.remove(&play.id),
            Event::Marker(_, id) => self.markers.remove(id).map(|(name, stand)| {
                line.name = Some(name);
                stand
            }),
            _ => None,
        };
        if let Some(Stand { pattern, event, drawn }) = stand {
            (line.pattern, line.event, line.drawn) = (Some(pattern), Some(event), drawn);
        }
        self.timed(line, at, moment)
    }

    /// With its instant, and when that leaves the converter.
    fn timed(&self, mut line: Line, at: Instant, moment: Option<Moment>) -> Line {
        (line.sample, line.fraction) = (Some(at.sample), Some(fraction(at)));
        if let Some(moment) = moment {
            let frame = at.since(Instant::default()) * self.names.ratio;
            let seconds = moment.time_of(frame) + self.delay() + self.board.device_delay.seconds();
            (line.seconds, line.utc) = (Some(seconds), self.date(seconds));
        }
        line
    }

    fn refused(&self, name: Option<&str>, why: &str, cause: u64) -> Line {
        let why = why.replace("\n  help: ", "; ");
        let name = name.map(String::from);
        Line { name, message: Some(why), cause: signalled(cause), ..self.now(Kind::Refused) }
    }

    fn came(&self, Stamped { id, stamp, origin, peer, ahead, signal, .. }: &Stamped) -> Line {
        let (source, name, message) = words::of_signal(signal, origin);
        let fields = ahead.map(|ahead| ("ahead".to_string(), ahead)).into_iter().collect();
        let (id, peer) = (Some(*id), peer.as_ref().map(ToString::to_string));
        let seconds = Some(stamp.seconds());
        let utc = self.date(stamp.seconds());
        let source = Some(source.into());
        Line { source, id, name, peer, message, seconds, utc, fields, ..Line::new(Kind::In) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Board, Chronicle, Epoch, Moment, began};
    use crate::engine::event::{Event, Source};
    use crate::graph::scene::{Options, scene};
    use crate::io::journal::Line;
    use crate::live::callback::{Deed, Report};
    use crate::live::conductor::Told;
    use crate::live::gate::Order;
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::performer::Origin;
    use crate::performer::{Happening, Heard};
    use crate::rig::Rig;
    use crate::schedule::Instant;
    use std::sync::Arc;
    use std::time::{Duration, SystemTime};

    /// Of a patch in which nothing plays.
    fn of_nothing() -> Chronicle {
        let patch = Patch::parse("p", b"format = \"pacinian-patch/1\"\ntitle = \"t\"\n")
            .unwrap_or_else(|p| panic!("{p}"))
            .value;
        let scene = scene(&patch, &Rig::default_for(1), &Options::default(), &NoAssets);
        Chronicle::of(&scene.unwrap_or_else(|p| panic!("{p}")).plan)
    }

    /// Of two at the same instant, one was called off before it was played.
    #[test]
    fn a_marker_is_named_by_its_id_and_not_by_its_time() {
        let mut chronicle = of_nothing();
        let instant = Instant { sample: 96, fraction: 0 };
        for (id, name) in [(7, "off"), (8, "on")] {
            let origin = Origin { pattern: "p", event: id, drawn: None };
            let what = Happening::Marker(name);
            chronicle.hear(&Heard { at: 0.001, instant, origin: Some(origin), id: Some(id), what });
        }
        let deed = Deed::Event {
            at: instant,
            due: instant,
            source: Source::Pattern,
            event: Event::Marker(u32::MAX, 8),
            cause: 0,
        };
        let told = chronicle.told(&Told::Report(&Report { frame: 0, deed }, None));
        let Some(Line { name, id, event, .. }) = told else { panic!("no line") };
        assert_eq!((name.as_deref(), id, event), (Some("on"), Some(8), Some(9)));
    }

    /// What is told of the gate can be compared with what is told of markers: both are when it leaves the converter.
    #[test]
    fn what_the_gate_does_is_told_as_it_leaves_the_converter() {
        let mut chronicle = of_nothing();
        let board = Arc::new(Board::new(1));
        board.device_delay.note(20_000_000);
        chronicle.told(&Told::Began(Epoch::begin(), &board));
        let moment = Some(Moment { frames: 4_800, time: 1.0, frame: 1.0 / 48_000.0, ahead: 64 });
        let instant = Instant { sample: 800, fraction: 0 };
        let marker = Event::Marker(u32::MAX, 1);
        let mut seconds = |deed| {
            let line = chronicle.told(&Told::Report(&Report { frame: 4_800, deed }, moment)).unwrap();
            line.seconds.unwrap()
        };
        let (at, due, source) = (instant, instant, Source::Pattern);
        assert!((seconds(Deed::Order(Order::Latch, 0)) - 1.02).abs() < 1e-9);
        // With no delay of an engine, the same sample.
        assert!((seconds(Deed::Event { at, due, source, event: marker, cause: 0 }) - 1.02).abs() < 1e-9);
    }

    #[test]
    fn a_clock_that_is_set_is_followed() {
        let then = SystemTime::UNIX_EPOCH + Duration::from_secs(1_800_000_000);
        let (hour, second) = (Duration::from_secs(3600), Duration::from_secs(1));
        let by = |now| began(then, hour, now);
        assert_eq!(by(then + hour + Duration::from_micros(900)), then, "read a little later");
        assert_eq!(by(then + hour + second), then + second, "set forward");
        assert_eq!(by(then + hour - second), then - second, "set back");
    }
}
