//! Unrolling: takes what is next from the heap, and puts on it what that leads to.

use std::collections::BinaryHeap;
use std::sync::Arc;

use super::book::Book;
use super::entry::{Bursts, Entry, Task, Which};
use super::playing::{Leaf, Playing};
use super::sheet::{Content, Deed, Deviations, Item, Nested, Play, Sheet};
use super::walk::Walk;
use super::{HORIZON, MOST_AT_ONCE, MOST_DEEP, Next, Note, Root, Timed, What, keys};
use crate::patch::event::{LEAST_FELT, MOST_FELT};
use crate::patch::motion::{BURST, SINCE};
use crate::text::Problem;

/// At what a score gives up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Steps after which something must have happened, and at least [`INSTANT`] seconds must have passed.
    pub patience: u64,
    /// Things under way.
    pub at_once: usize,
    /// Numbers of permutations that may be held at once; the windows of long files count for as much.
    pub permuted: usize,
}

impl Limits {
    pub const DEFAULT: Self = Self { patience: 1 << 22, at_once: MOST_AT_ONCE, permuted: 1 << 25 };
}

const INSTANT: f64 = 1e-6;

/// No rate or scale goes beyond its inverse or itself, so that no product is not-a-number.
const EXTREME: f64 = 1e300;

/// No level or field goes beyond.
const LOUDEST: f64 = 1e9;

/// Patterns being unrolled.
pub(super) struct Unroll<'a> {
    book: Book<'a>,
    pub limits: Limits,
    heap: BinaryHeap<Entry<'a>>,
    /// Of each root, how many entries are on the heap.
    under_way: Vec<usize>,
    /// What all walks hold, in numbers of permutations.
    permuted: usize,
    next_id: u64,
    /// Steps since `mark`.
    steps: u64,
    /// Seconds: when something last happened and time had passed.
    mark: f64,
    length: Option<f64>,
    /// Whether anything was left out for lying past the horizon.
    pub cut: bool,
}

impl<'a> Unroll<'a> {
    pub fn new(book: Book<'a>, roots: &[Root], seed: u64) -> Result<Self, Problem> {
        let heap = BinaryHeap::new();
        let mut unroll = Self {
            book,
            limits: Limits::DEFAULT,
            heap,
            under_way: vec![0; roots.len()],
            permuted: 0,
            next_id: 0,
            steps: 0,
            mark: -1.0,
            length: Some(0.0),
            cut: false,
        };
        for (root, &Root { pattern: index, at: start, gain, rate }) in roots.iter().enumerate() {
            let number = root as u64;
            let sheet = unroll.book.sheet(index)?;
            if !(start >= 0.0 && start.is_finite()) {
                let what = format!("pattern `{}` cannot start at {start} s", sheet.name);
                return Err(Problem::error(&sheet.span, what));
            }
            if !((0.0..=100.0).contains(&gain) && (0.001..=1000.0).contains(&rate)) {
                let what = format!("pattern `{}` cannot play with gain {gain} and rate {rate}", sheet.name);
                let help = "a gain is from 0 to 100, a rate from 0.001 to 1000".to_string();
                return Err(Problem::error(&sheet.span, what).help(help));
            }
            if sheet.barren {
                continue;
            }
            let end = sheet.length.map(|length| start + length / rate).filter(|end| *end <= HORIZON);
            unroll.length = unroll.length.zip(end).map(|(a, b)| a.max(b));
            let leaf = Leaf { event: number, k: 0 };
            let base = keys::root(seed, number);
            let nested = Nested { sheet: index, gain, rate };
            unroll.begin(root, None, leaf, base, &nested, start + 0.0)?;
        }
        Ok(unroll)
    }

    pub fn length(&self) -> Option<f64> {
        self.length
    }

    #[cfg(test)]
    pub fn under_way(&self) -> usize {
        self.heap.len()
    }

    pub fn plays(&self, root: usize) -> bool {
        self.under_way.get(root).is_some_and(|entries| *entries > 0)
    }

    pub fn stop(&mut self, root: usize) {
        let Some(entries) = self.under_way.get_mut(root) else { return };
        *entries = 0;
        let permuted = &mut self.permuted;
        self.heap.retain(|entry| {
            let goes = entry.playing.root == root;
            if goes {
                *permuted = permuted.saturating_sub(entry.task.holds());
            }
            !goes
        });
    }

    /// What happens next, in no more than so many steps, which are taken off. After an error the root that it is of has nothing left to play.
    pub fn next(&mut self, steps: &mut usize) -> Result<Next, Problem> {
        while *steps > 0 {
            let Some(entry) = self.heap.pop() else { return Ok(Next::Over) };
            let (root, before) = (entry.playing.root, self.steps);
            if let Some(entries) = self.under_way.get_mut(root) {
                *entries -= 1;
            }
            let done = self.patience(&entry).and_then(|()| self.step(entry));
            *steps = steps.saturating_sub(usize::try_from(self.steps - before).unwrap_or(usize::MAX));
            match done {
                Ok(None) => {}
                Ok(Some(timed)) => {
                    if timed.at >= self.mark + INSTANT {
                        (self.mark, self.steps) = (timed.at, 0);
                    }
                    return Ok(Next::Happens(timed));
                }
                Err(problem) => {
                    self.stop(root);
                    self.steps = 0;
                    // What was at hand is in no entry any more.
                    self.permuted = self.heap.iter().map(|entry| entry.task.holds()).sum();
                    return Err(problem);
                }
            }
        }
        Ok(Next::NotYet)
    }

    /// Counts steps that lead nowhere.
    fn patience(&mut self, entry: &Entry) -> Result<(), Problem> {
        self.steps += 1;
        if self.steps <= self.limits.patience {
            return Ok(());
        }
        let sheet = self.book.sheet(entry.playing.sheet)?;
        let what = format!(
            "pattern `{}` does not get on at {} s: {} steps and no way forward",
            sheet.name, entry.time, self.limits.patience
        );
        let help = "its repetitions are too close, or almost none of them plays anything";
        Err(Problem::error(&sheet.span, what).help(help.to_string()))
    }

    fn push(&mut self, entry: Entry<'a>) -> Result<(), Problem> {
        if entry.time > HORIZON {
            self.cut = true;
            return Ok(());
        }
        if self.heap.len() >= self.limits.at_once {
            let sheet = self.book.sheet(entry.playing.sheet)?;
            let what = format!(
                "pattern `{}`: more than {} things are under way at {} s",
                sheet.name, self.limits.at_once, entry.time
            );
            let help = "let fewer repetitions overlap, and shorten delays and jitter";
            return Err(Problem::error(&sheet.span, what).help(help.to_string()));
        }
        if let Some(entries) = self.under_way.get_mut(entry.playing.root) {
            *entries += 1;
        }
        self.heap.push(entry);
        Ok(())
    }

    fn step(&mut self, entry: Entry<'a>) -> Result<Option<Timed>, Problem> {
        let Entry { time, playing, leaf, task } = entry;
        let k = leaf.map_or(0, |leaf| leaf.k);
        match task {
            Task::Round => {
                let walk = Walk::new(&mut self.book, &playing)?;
                if self.book.sheet(playing.sheet)?.barren {
                    return Ok(None);
                }
                self.next_round(&playing)?;
                // To shuffle takes a while, too.
                self.steps += walk.holds() as u64 / 16;
                self.permuted += walk.holds();
                if self.permuted > self.limits.permuted {
                    let sheet = self.book.sheet(playing.sheet)?;
                    let what = format!("pattern `{}` shuffles too much at once at {time} s", sheet.name);
                    return Err(
                        Problem::error(&sheet.span, what).help("let fewer of its rounds overlap".to_string())
                    );
                }
                self.walk_on(playing, Box::new(walk))?;
                Ok(None)
            }
            Task::Walk { mut walk, exact } => {
                let taken = walk.take(&mut self.book, &playing)?;
                self.walk_on(playing.clone(), walk)?;
                let Some((which, at)) = taken else { return Ok(None) };
                if exact {
                    return self.happen(playing, which, at, 0, time);
                }
                self.draw(playing, which, at, 0)?;
                Ok(None)
            }
            Task::Draw { which, at } => {
                self.draw(playing, which, at, k)?;
                Ok(None)
            }
            Task::Happen { which, at } => self.happen(playing, which, at, k, time),
            Task::Burst(bursts) => self.burst(playing, leaf.unwrap_or_default(), bursts, time),
        }
    }

    /// A burst of an event sounds, and the next one is put on the heap.
    fn burst(
        &mut self,
        playing: Arc<Playing>,
        leaf: Leaf,
        bursts: Bursts,
        time: f64,
    ) -> Result<Option<Timed>, Problem> {
        let (root, pattern, drawn) = (playing.root, playing.sheet, bursts.drawn);
        let Some(burst) = bursts.list.get(bursts.next) else { return Ok(None) };
        let key = keys::occurrence(playing.key, leaf.event, leaf.k);
        let jitter = self.book.sheet(pattern)?.jitter.as_ref();
        // How long its bursts are is what makes the illusion.
        let mut note = Note {
            duration: bounded(burst.play.duration.clamp(0.0, EXTREME) * playing.scale, HORIZON).max(0.0),
            ..self.note(&playing, &burst.play, jitter, key)
        };
        let (_, names) = self.book.fields(burst.play.voice);
        for (slot, name) in note.own.iter_mut().zip(names) {
            match name.as_str() {
                SINCE => *slot = time - bursts.begin,
                BURST => *slot = bursts.next as f64,
                _ => {}
            }
        }
        self.wait(playing, leaf, Bursts { next: bursts.next + 1, ..bursts })?;
        let id = self.next_id;
        self.next_id += 1;
        Ok(Some(Timed { at: time, id, root, pattern, event: leaf.event, drawn, what: What::Play(note) }))
    }

    /// Puts the next burst of an event on the heap.
    fn wait(&mut self, playing: Arc<Playing>, leaf: Leaf, bursts: Bursts) -> Result<(), Problem> {
        let Some(burst) = bursts.list.get(bursts.next) else { return Ok(()) };
        let time = bursts.begin + burst.start * playing.scale;
        self.push(Entry { time, playing, leaf: Some(leaf), task: Task::Burst(bursts) })
    }

    /// Puts a walk back before its next event.
    fn walk_on(&mut self, playing: Arc<Playing>, walk: Box<Walk<'a>>) -> Result<(), Problem> {
        let holds = walk.holds();
        let ahead = walk.ahead(self.book.sheet(playing.sheet)?);
        let time = ahead.as_ref().map_or(f64::INFINITY, |ahead| playing.seconds(ahead.time));
        let Some(ahead) = ahead.filter(|_| time <= HORIZON) else {
            self.cut |= time < f64::INFINITY;
            self.permuted -= holds;
            return Ok(());
        };
        let leaf = Some(Leaf { event: ahead.number, k: 0 });
        self.push(Entry { time, playing, leaf, task: Task::Walk { walk, exact: ahead.exact } })
    }

    /// Puts the next round of a playing on the heap.
    fn next_round(&mut self, playing: &Arc<Playing>) -> Result<(), Problem> {
        let sheet = self.book.sheet(playing.sheet)?;
        let round = playing.round.saturating_add(1);
        let Some(repeat) = sheet.repeat.filter(|_| round < sheet.rounds()) else { return Ok(()) };
        let start = playing.begin + round as f64 * repeat.every * playing.scale;
        let next = Playing {
            parent: playing.parent.clone(),
            round,
            start,
            key: keys::round(playing.base, round),
            ..**playing
        };
        self.push(Entry { time: start, playing: Arc::new(next), leaf: None, task: Task::Round })
    }

    /// Puts round 0 of a pattern on the heap.
    fn begin(
        &mut self,
        root: usize,
        parent: Option<Arc<Playing>>,
        leaf: Leaf,
        base: u64,
        nested: &Nested,
        start: f64,
    ) -> Result<(), Problem> {
        let sheet = self.book.sheet(nested.sheet)?;
        let (rate, gain, depth) = parent.as_ref().map_or((1.0, 1.0, 1), |p| (p.rate, p.gain, p.depth + 1));
        if depth > MOST_DEEP {
            let what = format!("pattern `{}` is played more than {MOST_DEEP} patterns deep", sheet.name);
            return Err(Problem::error(&sheet.span, what).help("see whether it contains itself".to_string()));
        }
        let rate = (rate * nested.rate * sheet.rate).clamp(1.0 / EXTREME, EXTREME);
        let scale = (sheet.unit / rate).clamp(1.0 / EXTREME, EXTREME);
        let gain = (gain * nested.gain * sheet.gain).clamp(-EXTREME, EXTREME);
        let playing = Playing {
            root,
            parent,
            leaf,
            round: 0,
            sheet: nested.sheet,
            depth,
            begin: start,
            start,
            rate,
            scale,
            gain,
            base,
            key: keys::round(base, 0),
        };
        self.push(Entry { time: start, playing: Arc::new(playing), leaf: None, task: Task::Round })
    }

    /// Draws the onset of an event's `k`th time.
    fn draw(&mut self, playing: Arc<Playing>, which: Which, at: f64, k: u64) -> Result<(), Problem> {
        let sheet = self.book.sheet(playing.sheet)?;
        let Some(item) = find(sheet, &which) else { return Ok(()) };
        let leaf = Leaf { event: item.number, k };
        let spread = sheet.spread();
        if spread == 0.0 {
            let time = playing.seconds(item.onset(at, k));
            return self.push(Entry { time, playing, leaf: Some(leaf), task: Task::Happen { which, at } });
        }
        let moved = spread * keys::deviation(keys::occurrence(playing.key, item.number, k), keys::ONSET);
        let time = playing.seconds((at + item.later(k) + moved).max(0.0) + item.delay);
        if k + 1 < item.times() {
            let soonest = playing.seconds((at + item.later(k + 1) - spread).max(0.0));
            let leaf = Some(Leaf { k: k + 1, ..leaf });
            let (playing, which) = (playing.clone(), which.clone());
            self.push(Entry { time: soonest, playing, leaf, task: Task::Draw { which, at } })?;
        }
        self.push(Entry { time, playing, leaf: Some(leaf), task: Task::Happen { which, at } })
    }

    /// An event happens for the `k`th time.
    fn happen(
        &mut self,
        playing: Arc<Playing>,
        which: Which,
        at: f64,
        k: u64,
        time: f64,
    ) -> Result<Option<Timed>, Problem> {
        let sheet = self.book.sheet(playing.sheet)?;
        let Some(item) = find(sheet, &which).filter(|item| !self.book.is_barren(&item.deed)) else {
            return Ok(None);
        };
        let leaf = Leaf { event: item.number, k };
        let key = keys::occurrence(playing.key, item.number, k);
        let (deed, drawn) = match &item.deed {
            Deed::Choose(all) => match choose(all, key) {
                Some((deed, drawn)) => (deed, Some(drawn)),
                None => return Ok(None),
            },
            deed => (deed, None),
        };
        let (mut nested, mut bursts) = (None, None);
        let what = match deed {
            Deed::Play(play) => Some(What::Play(self.note(&playing, play, sheet.jitter.as_ref(), key))),
            Deed::Marker(name) => Some(What::Marker(name.clone())),
            Deed::Pattern(pattern) => {
                nested = Some(pattern.clone()).filter(|_| !self.book.is_barren(deed));
                None
            }
            Deed::Motion(list) => {
                bursts = Some(Bursts { list: Arc::clone(list), next: 0, begin: time, drawn });
                None
            }
            Deed::Choose(_) => None,
        };
        // With jitter, `draw` has seen to the next time.
        if sheet.spread() == 0.0 && k + 1 < item.times() {
            let time = playing.seconds(item.onset(at, k + 1));
            let (playing, leaf) = (playing.clone(), Some(Leaf { k: k + 1, ..leaf }));
            self.push(Entry { time, playing, leaf, task: Task::Happen { which, at } })?;
        }
        let (root, pattern) = (playing.root, playing.sheet);
        if let Some(bursts) = bursts {
            self.wait(playing, leaf, bursts)?;
        } else if let Some(nested) = nested {
            self.begin(root, Some(playing), leaf, key, &nested, time)?;
        }
        let Some(what) = what else { return Ok(None) };
        let id = self.next_id;
        self.next_id += 1;
        Ok(Some(Timed { at: time, id, root, pattern, event: leaf.event, drawn, what }))
    }

    fn note(&self, playing: &Playing, play: &Play, jitter: Option<&Deviations>, key: u64) -> Note {
        let (mut own, names) = self.book.fields(play.voice);
        for &(place, value) in &play.own {
            if let Some(slot) = own.get_mut(usize::from(place)) {
                *slot = value;
            }
        }
        let mut level = bounded(play.level, LOUDEST) * playing.gain;
        let mut duration = play.duration.clamp(0.0, EXTREME) * playing.scale;
        for (draw, (name, fraction)) in
            (keys::FRACTIONS..).zip(jitter.iter().flat_map(|j| j.fractions.iter()))
        {
            let factor = 1.0 + keys::deviation(key, draw) * fraction;
            match name.as_str() {
                "level" => level *= factor,
                "duration" => duration *= factor,
                _ => {
                    let slots = own.iter_mut().zip(names).filter(|(_, n)| *n == name);
                    slots.for_each(|(slot, _)| *slot *= factor);
                }
            }
        }
        Note {
            voice: play.voice as usize,
            level: bounded(level, LOUDEST),
            felt: play.felt.map(|felt| felt.clamp(LEAST_FELT, MOST_FELT)),
            duration: bounded(duration, HORIZON).max(0.0),
            place: play.place,
            own: own.map(|x| bounded(x, LOUDEST)),
        }
    }
}

fn find<'s>(sheet: &'s Sheet, which: &'s Which) -> Option<&'s Item> {
    match (which, &sheet.content) {
        (Which::Read(item), _) => Some(item),
        (Which::Held(place), Content::Held(items)) => items.get(*place),
        (Which::Held(_), Content::File { .. }) => None,
    }
}

/// One of several by their weights, and its number.
fn choose(all: &[(f64, Deed)], key: u64) -> Option<(&Deed, u32)> {
    let (sum, _) = all.last()?;
    let drawn = keys::fraction(key, keys::CHOICE) * sum;
    let index = all.partition_point(|(to, _)| *to <= drawn).min(all.len() - 1);
    all.get(index).map(|(_, deed)| (deed, u32::try_from(index).unwrap_or(u32::MAX)))
}

/// Within ±`limit`; 0 for what is not a number.
fn bounded(x: f64, limit: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(-limit, limit) }
}
