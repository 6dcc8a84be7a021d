//! What happened at the knob in a tick.

/// Something that happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// The effect, by its place in the program.
    pub effect: usize,
    /// What it was.
    pub what: What,
}

/// What can happen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// The knob came into another detent.
    Detent {
        /// Which, counted from the one at the reference angle.
        index: i64,
        /// How many it passed, with the sign of the turn; more than one only if it was fast.
        passed: i64,
    },
    /// The knob ran into a wall.
    Wall {
        /// How fast, rad/s, without a sign.
        speed: f64,
        /// The wall's side: 1 where it stands in the way of larger angles, -1 of smaller ones.
        side: i8,
    },
}

/// Events that a tick can hold.
pub const MOST: usize = 16;

/// Those of a tick, in the order of the effects. Those beyond [`MOST`] are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Events {
    list: [Event; MOST],
    length: usize,
    lost: u64,
    pub(super) effect: usize,
}

impl Default for Events {
    fn default() -> Self {
        let nothing = Event { effect: 0, what: What::Detent { index: 0, passed: 0 } };
        Self { list: [nothing; MOST], length: 0, lost: 0, effect: 0 }
    }
}

impl Events {
    /// Forgets what it holds, but not how many were lost.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Adds one.
    #[cold]
    pub fn push(&mut self, what: What) {
        if let Some(place) = self.list.get_mut(self.length) {
            *place = Event { effect: self.effect, what };
            self.length += 1;
        } else {
            self.lost += 1;
        }
    }

    /// What happened.
    pub fn list(&self) -> &[Event] {
        &self.list[..self.length]
    }

    /// How many found no place, ever.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The fastest run into a wall in this tick, rad/s; 0 if there was none.
    #[inline]
    pub fn impact(&self) -> f64 {
        let speed = |e: &Event| if let What::Wall { speed, .. } = e.what { speed } else { 0.0 };
        self.list().iter().map(speed).fold(0.0, f64::max)
    }
}
