//! Standard MIDI Files (RP-001, version 1.0) into messages with times.
//!
//! Events are read by the crate [`midly`]. It is too lax for files that are cut short or hostile: it takes what is left of a file for a
//! chunk that is longer, the first four bytes of a longer quantity, and what is left of a chunk for a longer text, and it ends a track without a
//! word where an event makes no sense. So chunks and lengths are checked here before it sees them, and where it stops a warning says where.
//! It stops at system messages (0xF1 to 0xF6, 0xF8 to 0xFE), which a file must not have, at data above 127, and at data bytes behind system
//! exclusive or a meta event, which end running status; what follows in that track is left out.

mod chunk;
mod map;
mod order;
mod track;

use crate::text::{Checked, Problem, Problems};

use super::message::Message;
use chunk::Chunks;
use map::{Division, Map};
use track::{Contents, Track};

/// The longest file that is read, bytes: 64 MiB.
pub const MOST_BYTES: usize = 64 << 20;
/// Most messages, marks and tempi that are read, of all tracks.
pub const MOST_EVENTS: usize = 10_000_000;
/// Most tracks that are read; a header cannot name more.
pub const MOST_TRACKS: usize = 65_535;
/// Most warnings that are listed; then they are counted.
pub const MOST_WARNINGS: usize = 20;

/// What a file plays, in the order of time. Notes may still sound in the end, where the file forgot them: whoever plays it with
/// [`super::Interpreter`] ends them with [`super::Interpreter::let_go`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Song {
    /// 0: one track; 1: tracks that play together; 2: tracks that are pieces of their own, here one after another.
    pub format: u8,
    /// For each track the name it has, if it has one.
    pub tracks: Vec<Option<String>>,
    /// Messages of channels, with their seconds from the beginning. At equal times they come in the order of the tracks and of the file, but
    /// a note-off that ends an earlier note goes before the note-ons.
    pub messages: Vec<(f64, Message)>,
    /// Markers and cue points.
    pub marks: Vec<Mark>,
    /// Where the tempo changes, in seconds, and what to, in quarter notes a minute. Empty where the file counts in frames, and where it
    /// names no tempo, which means 120.
    pub tempi: Vec<(f64, f64)>,
    /// How long it is, up to the last end of a track.
    pub seconds: f64,
    /// System exclusive messages and escapes, which are left out.
    pub exclusive: u64,
    /// The longest time between two events of a track.
    pub pause: Option<Pause>,
}

/// Time in which nothing happens in a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pause {
    /// How long.
    pub seconds: f64,
    /// In this track, from 0.
    pub track: usize,
    /// The byte of the file at which the event stands that ends it.
    pub at: usize,
}

/// A place in a song that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// From the beginning.
    pub seconds: f64,
    /// In this track, from 0.
    pub track: usize,
    /// Whether it says what happens there in a film or on a stage (a cue point), rather than in the music (a marker).
    pub cue: bool,
    /// Its text; bytes that are no UTF-8 are read as Latin-1.
    pub text: String,
}

impl Song {
    /// Reads a whole file called `name`: format 0, 1 or 2, also in a RIFF wrapper (RMID).
    ///
    /// What is damaged is left out with a warning that says where: a track is read up to what cannot be read, a file up to its end. A track
    /// without its end-of-track ends with its last event.
    ///
    /// # Errors
    /// That it is no such file, that its header is cut short or says what is not defined (format, division), that it has no track, or
    /// that it is beyond [`MOST_BYTES`] or [`MOST_EVENTS`].
    pub fn read(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        let problems = |list| Problems { file: name.into(), source: String::new(), list };
        let mut warnings = Warnings::default();
        let song = read(bytes, MOST_EVENTS, &mut warnings).map_err(|problem| problems(vec![problem]))?;
        Ok(Checked { value: song, warnings: problems(warnings.list()) })
    }
}

fn read(bytes: &[u8], events: usize, warnings: &mut Warnings) -> Result<Song, Problem> {
    if bytes.len() > MOST_BYTES {
        let what = format!("the file has {} bytes, and {MOST_BYTES} are read at most", bytes.len());
        return Err(
            Problem::of_file(what).help("split it, or leave out its system exclusive messages".to_string())
        );
    }
    let mut chunks = Chunks::open(bytes)?;
    let header = chunks.header(warnings)?;
    let mut song = Song { format: header.format, ..Song::default() };
    let mut contents = Contents::with_room(events);
    let mut begin = 0.0;
    while let Some(chunk) = chunks.next_track(warnings) {
        let index = song.tracks.len();
        if index == MOST_TRACKS {
            let what = format!("byte {}: tracks after the first {MOST_TRACKS} are left out", chunk.at);
            warnings.push(chunk.at, what, "merge tracks in the program that wrote the file");
            break;
        }
        let track = Track { index, at: chunk.at, bytes: chunk.bytes, cut: chunk.cut };
        song.tracks.push(track.read(&mut contents, warnings)?);
        if header.format == 2 {
            let next = Contents::with_room(contents.room());
            begin = place(std::mem::replace(&mut contents, next), header.division, begin, &mut song);
        }
    }
    let found = song.tracks.len();
    if found == 0 {
        let what = format!("there is no track: the file ends at byte {}", bytes.len());
        return Err(Problem::of_file(what).help("it was cut short; get it anew".to_string()));
    }
    if found != usize::from(header.tracks) {
        let what = format!("byte 10: the header promises {} tracks, and there are {found}", header.tracks);
        warnings.push(10, what, "if some are missing, the file was cut short: get it anew");
    }
    if header.format != 2 {
        place(contents, header.division, 0.0, &mut song);
    }
    Ok(song)
}

/// The tempo of a song that names none, quarter notes a minute.
const USUAL: f64 = 120.0;

/// Puts what tracks contain that play together into the song, from `begin` on; gives when they end.
fn place(mut contents: Contents, division: Division, begin: f64, song: &mut Song) -> f64 {
    let map = Map::new(division, &mut contents.tempi);
    let at = |tick| begin + map.seconds(tick);
    order::sort(&mut contents.messages);
    song.messages.extend(contents.messages.iter().map(|(tick, message)| (at(*tick), *message)));
    contents.marks.sort_by_key(|mark| mark.tick);
    song.marks.extend(contents.marks.into_iter().map(|mark| Mark {
        seconds: at(mark.tick),
        track: mark.track,
        cue: mark.cue,
        text: mark.text,
    }));
    if begin > 0.0 {
        // A piece of its own: it knows nothing of the tempo of the one before.
        song.tempi.push((begin, USUAL));
    }
    song.tempi.extend(map.tempi().map(|(seconds, tempo)| (begin + seconds, tempo)));
    song.exclusive += contents.exclusive;
    let pause = contents.pause.map(|pause| {
        let [from, to] = pause.ticks.map(|tick| map.seconds(tick));
        Pause { seconds: to - from, track: pause.track, at: pause.at }
    });
    song.pause = [song.pause, pause].into_iter().flatten().max_by(|a, b| a.seconds.total_cmp(&b.seconds));
    song.seconds = at(contents.end);
    song.seconds
}

/// Warnings up to a number that a person reads, and how many more there are.
#[derive(Debug, Default)]
struct Warnings {
    first: Vec<Problem>,
    more: usize,
}

impl Warnings {
    fn push(&mut self, at: usize, what: String, help: &str) {
        if self.first.len() < MOST_WARNINGS {
            self.first.push(Problem::warning(&(at..at), what).help(help.to_string()));
        } else {
            self.more += 1;
        }
    }
    fn list(self) -> Vec<Problem> {
        let Self { first: mut list, more } = self;
        if more > 0 {
            let what = format!("{more} more warnings like these");
            list.push(Problem { span: None, ..Problem::warning(&(0..0), what) });
        }
        list
    }
}

#[cfg(test)]
mod tests;
