//! What goes along with a session while it plays: instruments, OSC, files that are watched, what is kept of it.

use super::super::failure::Failure;
use super::super::keep::Kept;
use super::super::line::OnLine;
use super::super::loaded::Loaded;
use super::super::osc;
use super::super::screen::Show;
use super::super::terminal::Terminal;
use super::super::watch::{News, Watching};
use super::instruments::Instruments;
use pacinian::io::osc::announce::Announcer;
use pacinian::io::osc::counts::Counts;
use pacinian::io::osc::server::Server;
use pacinian::io::session::Session;
use pacinian::live::gate::RAMP_IN;
use std::sync::Arc;

/// All of it.
pub struct Company {
    /// What plays, as it was read last.
    pub loaded: Loaded,
    pub kept: Kept,
    pub announcer: Option<Announcer>,
    pub osc: Option<Server>,
    /// What came over OSC, once nothing more does.
    pub counts: Option<Arc<Counts>>,
    pub instruments: Instruments,
    pub watching: Option<Watching>,
    pub line: Option<OnLine>,
    /// When a song ends that is not over yet, seconds.
    pub song_ends: Option<f64>,
}

impl Company {
    /// When its song ends: everything of the beginning comes behind the ramp.
    pub fn song_ends(loaded: &Loaded) -> Option<f64> {
        loaded.song.as_ref().map(|song| RAMP_IN + song.seconds)
    }

    /// Hears what each has to say, and lets them follow a patch that took over; to be called often.
    pub fn look(&mut self, session: &Session, show: &mut Show) {
        let played = session.board().frames.get() as f64 / session.rate();
        if self.song_ends.take_if(|end| *end <= played).is_some() {
            show.tell("the song has ended; the session goes on until it is ended");
        }
        if let Some(trouble) = self.kept.look(session) {
            show.say(&trouble);
        }
        for vain in self.announcer.iter().flat_map(Announcer::unheard) {
            show.say(&format!("{}: what is told there over OSC is lost", osc::in_vain(&vain)));
        }
        for complaint in self.osc.iter().flat_map(Server::complaints) {
            show.say(&complaint);
        }
        self.line.iter().flat_map(OnLine::news).for_each(|said| show.say(&said));
        let news: Vec<News> = self.watching.iter().flat_map(Watching::news).collect();
        for news in news {
            show.watched(&news);
            if let News::Took(new, .., effects) = news {
                self.loaded = *new;
                self.line.iter().for_each(|line| line.follow(effects.clone()));
                self.osc.iter().for_each(|osc| osc.follow(&self.loaded.patch));
                // The new one may be the first that has use for them.
                if let Err(failure) = self.instruments.open_for(&self.loaded.patch) {
                    show.say(&failure.brief());
                }
            }
        }
    }

    /// Nothing that is saved takes over any more, and nothing comes in over OSC.
    pub fn close(&mut self) {
        drop(self.watching.take());
        // What the system dropped last is counted when the server ends.
        self.counts = self.osc.take().map(|osc| Arc::clone(osc.counts()));
    }

    /// The session has stopped: says what was lost on its ways in and out.
    pub fn leave(self, session: &Session, terminal: &Terminal) -> Parted {
        let Self { loaded, kept, announcer, instruments, line, counts, .. } = self;
        // A session that has ended is told no more of their keys.
        drop(instruments);
        counts.iter().for_each(|counts| kept.counted(counts));
        let troubles = [counts.and_then(|counts| counts.trouble()), session.board().midi.trouble()];
        troubles.iter().flatten().for_each(|trouble| terminal.note(&format!("{trouble}\n")));
        let unsent = announcer.as_ref().map_or(0, Announcer::finish);
        for vain in announcer.iter().flat_map(Announcer::unheard) {
            terminal.note(&format!("{}\n", osc::in_vain(&vain)));
        }
        if unsent > 0 {
            terminal.note(&format!(
                "{unsent} messages of markers, voices and the gate could not be told over OSC\n"
            ));
        }
        Parted { loaded, kept, line }
    }

    /// A session that cannot go on: what was made for it is gone again.
    pub fn abandon(self, failure: Failure) -> Failure {
        self.kept.abandon();
        failure
    }
}

/// What is left when all others have gone.
pub struct Parted {
    pub loaded: Loaded,
    pub kept: Kept,
    pub line: Option<OnLine>,
}
