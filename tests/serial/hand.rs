//! The servo of the tests: a spring with a damper, that writes down what it is told.

use pacinian::io::knob::lost::Lost;
use pacinian::io::knob::servo::{News, Reading, Servo};

#[derive(Debug, Default, Clone)]
pub struct Hand {
    /// N m/rad, N m s/rad, rad.
    pub stiffness: f64,
    pub damping: f64,
    pub centre: f64,
    /// Takes the spring's place.
    pub forced: Option<f64>,
    /// What it gives once an exchange is due.
    pub newest: Option<f64>,
    /// The thread is to end in the middle.
    pub panics_at: Option<u64>,
    pub ticks: u64,
    pub last: Option<Reading>,
    pub lost: Vec<Lost>,
    pub news: Vec<News>,
}

impl Servo for Hand {
    fn tick(&mut self, reading: &Reading) -> f64 {
        assert!(reading.angle.is_finite() && reading.dt > 0.0, "{reading:?}");
        self.ticks += 1;
        self.last = Some(*reading);
        if self.panics_at == Some(self.ticks) {
            std::panic::resume_unwind(Box::new("as the test wants it"));
        }
        let pull = -self.stiffness * (reading.angle - self.centre);
        self.forced.unwrap_or(pull - self.damping * reading.velocity.unwrap_or(0.0))
    }

    fn newest(&mut self) -> Option<f64> {
        self.newest
    }

    fn lost(&mut self, why: &Lost) {
        self.lost.push(why.clone());
    }

    fn news(&mut self, news: &News) {
        self.news.push(news.clone());
    }
}

impl Hand {
    /// Notes that hold these words.
    pub fn notes(&self, words: &str) -> usize {
        self.news.iter().filter(|news| matches!(news, News::Note(note) if note.contains(words))).count()
    }
}
