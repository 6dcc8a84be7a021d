//! What the digits play, and what plays.

use super::snapshot::KeyFace;
use pacinian::live::signal::Signal;
use pacinian::patch::{Patch, Source};

/// Digits that play something.
const DIGITS: u32 = 9;

/// What the digits play, and what plays.
#[derive(Debug, Default)]
pub struct Players {
    patterns: Vec<String>,
    /// Those that play from the beginning.
    first: Vec<String>,
    /// What a key sets off.
    triggers: Vec<(u32, String)>,
    /// Those that play.
    playing: Vec<String>,
    /// The same, with the numbers by which they were started, as of when it was asked last what changes.
    running: Vec<(u64, String)>,
    /// Those of which it was said since that they begin.
    said: Vec<String>,
    /// Whether any has played.
    played: bool,
    /// Whether the patch that took over last has one of which the patch before knew nothing, and which begins by itself.
    begins: bool,
}

impl Players {
    /// Of a patch of which these patterns play from the beginning.
    pub fn new(patch: &Patch, first: &[usize]) -> Self {
        let name = |&pattern: &usize| patch.patterns.get(pattern).map(|p| p.name.clone());
        let trigger = |on: &Source| match on {
            Source::Key(key) => Some(*key),
            _ => None,
        };
        Self {
            patterns: patch.patterns.iter().map(|p| p.name.clone()).collect(),
            first: first.iter().filter_map(name).collect(),
            triggers: patch.triggers.iter().filter_map(|t| Some((trigger(&t.on)?, t.play.clone()))).collect(),
            ..Self::default()
        }
    }

    /// The patch is another; what plays goes on until it is told otherwise.
    pub fn become_of(&mut self, patch: &Patch, first: &[usize]) {
        let (playing, running) = (std::mem::take(&mut self.playing), std::mem::take(&mut self.running));
        let (said, played) = (std::mem::take(&mut self.said), self.played);
        let before = std::mem::take(&mut self.patterns);
        *self = Self { playing, running, said, played, ..Self::new(patch, first) };
        self.begins = self.first.iter().any(|name| !before.contains(name));
    }

    /// Something of the engine has set that pattern off, and it was said that it begins.
    pub fn set_off(&mut self, name: String) {
        self.said.push(name);
    }

    /// What is to be said of those that begin or are over, where these play now: whether it begins with the session, and its words. Of one that was set off
    /// by something of the engine it was said before that it begins.
    pub fn changes(&mut self, playing: &[(u64, String)]) -> Vec<(bool, String)> {
        let mut known = std::mem::take(&mut self.said);
        let over = self.running.iter().filter(|run| !playing.contains(run));
        let mut said: Vec<_> = over.map(|(_, name)| (false, format!("pattern {name} is over"))).collect();
        for (serial, name) in playing.iter().filter(|run| !self.running.contains(run)) {
            match known.iter().position(|known| known == name) {
                Some(place) => drop(known.swap_remove(place)),
                None => said.push((*serial == 0, format!("pattern {name} begins"))),
            }
        }
        self.running = playing.to_vec();
        said
    }

    /// These play now; one that plays twice stands there twice.
    pub fn play(&mut self, playing: Vec<String>) {
        self.played |= !playing.is_empty();
        self.playing = playing;
    }

    /// What is to be said of patterns that have played where none plays any more; `keys` says whether there are such.
    pub fn over(&self, keys: bool) -> &'static str {
        let over = self.played && !self.patterns.is_empty() && self.playing.is_empty() && !self.begins;
        match (over, keys) {
            (false, _) => "",
            (true, true) => {
                "; patterns that are over do not begin again by themselves: 1 or space starts one"
            }
            (true, false) => "; patterns that are over do not begin again by themselves",
        }
    }

    /// What is to be said where the output is open again, and a panic has stopped what played; `keys` says whether there are such.
    pub fn after_panic(&self, keys: bool) -> String {
        let open = "the output is open again";
        if !self.played || self.patterns.is_empty() || !self.playing.is_empty() {
            return open.into();
        }
        let first = self.faces().into_iter().find(|face| !face.trigger);
        match first.filter(|_| keys) {
            Some(face) => format!("{open}; patterns were stopped: {} or space starts them", face.digit),
            None if keys => format!("{open}; patterns were stopped: space starts them"),
            None => format!("{open}; patterns were stopped"),
        }
    }

    /// The digits that play something.
    pub fn faces(&self) -> Vec<KeyFace> {
        let face = |digit: u32| {
            if let Some((_, play)) = self.triggers.iter().find(|(key, _)| *key == digit) {
                return Some(KeyFace { digit, name: play.clone(), playing: false, trigger: true });
            }
            let name = self.of_digit(digit)?;
            Some(KeyFace { digit, name: name.clone(), playing: self.playing.contains(name), trigger: false })
        };
        (1..=DIGITS).filter_map(face).collect()
    }

    /// The pattern that a digit starts and stops: the first has 1, the second 2, and so on. Those whose digit is a trigger's, unless a trigger
    /// plays them, have the digits that are left.
    fn of_digit(&self, digit: u32) -> Option<&String> {
        let is_free = |digit: &u32| !self.triggers.iter().any(|(key, _)| key == digit);
        if !(1..=DIGITS).contains(&digit) || !is_free(&digit) {
            return None;
        }
        let own = |place: usize| u32::try_from(place + 1).ok().filter(|own| *own <= DIGITS && is_free(own));
        if let Some(name) = self.patterns.get(digit as usize - 1) {
            return Some(name);
        }
        let mut left = self.patterns.iter().enumerate().filter(|(place, name)| {
            own(*place).is_none() && !self.triggers.iter().any(|(_, play)| play == *name)
        });
        let before = (self.patterns.len() as u32 + 1..digit).filter(is_free).count();
        left.nth(before).map(|(_, name)| name)
    }

    /// Patterns that no digit plays.
    pub fn keyless(&self) -> usize {
        let faces = self.faces();
        self.patterns.iter().filter(|name| !faces.iter().any(|face| face.name == **name)).count()
    }

    /// What a digit asks for; `number` gives numbers that nobody else has.
    ///
    /// # Errors
    /// A digit that plays nothing.
    pub fn digit(&self, digit: u32, number: impl FnMut() -> u64) -> Result<Vec<Signal>, String> {
        if self.triggers.iter().any(|(key, _)| *key == digit) {
            return Ok(vec![Signal::Key(digit)]);
        }
        let Some(name) = self.of_digit(digit) else {
            let count = self.patterns.len();
            return Err(match count {
                0 => "this patch has no patterns".into(),
                1 => format!("there is no pattern {digit}: this patch has only one"),
                _ => format!("there is no pattern {digit}: this patch has {count}"),
            });
        };
        Ok(if self.playing.contains(name) { self.stop(|n| n == name) } else { start(&[name], number) })
    }

    /// What the space bar asks for: that all patterns stop, or where none plays, that those play again that played from the
    /// beginning, or else the first.
    ///
    /// # Errors
    /// Where there are no patterns.
    pub fn all(&self, number: impl FnMut() -> u64) -> Result<Vec<Signal>, String> {
        if !self.playing.is_empty() {
            return Ok(self.stop(|_| true));
        }
        let first: Vec<&String> = match self.first.is_empty() {
            true => self.patterns.iter().take(1).collect(),
            false => self.first.iter().collect(),
        };
        if first.is_empty() { Err("this patch has no patterns".into()) } else { Ok(start(&first, number)) }
    }

    fn stop(&self, which: impl Fn(&String) -> bool) -> Vec<Signal> {
        let mut names: Vec<&String> = self.playing.iter().filter(|name| which(name)).collect();
        names.sort();
        names.dedup();
        names.into_iter().map(|name| Signal::StopNamed(name.clone())).collect()
    }
}

fn start(names: &[&String], mut number: impl FnMut() -> u64) -> Vec<Signal> {
    names.iter().map(|name| Signal::Start(number(), (*name).clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::Players;
    use pacinian::live::signal::Signal;
    use pacinian::patch::Patch;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(ToString::to_string).collect()
    }

    fn players() -> Players {
        Players {
            patterns: names(&["walk", "run", "rest"]),
            first: names(&["run"]),
            triggers: vec![(5, "bump".into()), (3, "knock".into())],
            ..Players::default()
        }
    }

    fn said(signals: Result<Vec<Signal>, String>) -> String {
        signals.map_or_else(|why| why, |signals| signals.iter().map(|s| format!("{s:?};")).collect())
    }

    #[test]
    fn a_digit_starts_and_stops() {
        let mut players = players();
        assert_eq!(said(players.digit(1, || 7)), "Start(7, \"walk\");");
        players.play(names(&["run", "walk", "walk"]));
        assert_eq!(said(players.digit(1, || 7)), "StopNamed(\"walk\");");
        assert_eq!(said(players.digit(2, || 7)), "StopNamed(\"run\");");
        assert_eq!(said(players.digit(6, || 7)), "there is no pattern 6: this patch has 3");
        assert_eq!(said(players.digit(0, || 7)), "there is no pattern 0: this patch has 3");
        // Ended by itself: a digit starts it again.
        players.play(names(&["rest"]));
        assert_eq!(said(players.digit(2, || 7)), "Start(7, \"run\");");
    }

    #[test]
    fn each_that_begins_or_ends_is_told_of_once() {
        let mut players = players();
        let mut told = |runs: &[(u64, &str)]| -> Vec<(bool, String)> {
            players.changes(&runs.iter().map(|(serial, name)| (*serial, (*name).into())).collect::<Vec<_>>())
        };
        let said = |at_first, text: &str| (at_first, text.to_string());
        assert_eq!(told(&[(0, "run")]), [said(true, "pattern run begins")]);
        assert_eq!(
            told(&[(0, "run"), (7, "run"), (8, "walk")]),
            [said(false, "pattern run begins"), said(false, "pattern walk begins")]
        );
        assert_eq!(told(&[(8, "walk"), (7, "run"), (0, "run")]), [], "the same");
        // One ends as another of its name begins.
        assert_eq!(
            told(&[(8, "walk"), (9, "run"), (0, "run")]),
            [said(false, "pattern run is over"), said(false, "pattern run begins")]
        );
        assert_eq!(told(&[(0, "run"), (9, "run")]), [said(false, "pattern walk is over")]);
        assert_eq!(told(&[]).len(), 2);
        // What has set it off has said so.
        players.set_off("run".into());
        let more = players.changes(&[(10, "run".into()), (11, "run".into())]);
        assert_eq!(more, [said(false, "pattern run begins")]);
    }

    /// Of a pattern that the patch before did not have, which begins by itself, it is not said that it does not.
    #[test]
    fn patterns_that_are_over_are_told_of_and_new_ones_are_not() {
        let patch = |names: &[&str]| {
            let pattern =
                |name: &&str| format!("[pattern.{name}]\nevents = [{{ at = 0, marker = \"m\" }}]\n");
            let patterns: String = names.iter().map(pattern).collect();
            let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{patterns}");
            Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
        };
        let mut players = Players::new(&patch(&["walk"]), &[0]);
        players.play(names(&["walk"]));
        players.play(vec![]);
        players.become_of(&patch(&["walk"]), &[0]);
        assert!(
            players.over(true).contains("1 or space starts one")
                && players.over(false).ends_with("themselves")
        );
        players.become_of(&patch(&[]), &[]);
        assert_eq!(players.over(true), "", "there are none");
        players.become_of(&patch(&["walk"]), &[0]);
        assert_eq!(players.over(true), "", "it begins");
        players.become_of(&patch(&["walk", "run"]), &[0]);
        assert!(!players.over(true).is_empty(), "the new one waits to be started");
    }

    #[test]
    fn whoever_opens_the_output_again_is_told_why_nothing_plays() {
        let mut players = players();
        assert_eq!(players.after_panic(true), "the output is open again", "nothing has played");
        players.play(names(&["run"]));
        players.play(vec![]);
        let stopped = "the output is open again; patterns were stopped";
        assert_eq!(players.after_panic(true), format!("{stopped}: 1 or space starts them"));
        assert_eq!(players.after_panic(false), stopped);
        players.triggers.push((1, "knock".into()));
        assert_eq!(players.after_panic(true), format!("{stopped}: 2 or space starts them"));
        // Somebody was faster.
        players.play(names(&["run"]));
        assert_eq!(players.after_panic(true), "the output is open again");
    }

    #[test]
    fn a_trigger_goes_first() {
        let players = players();
        assert_eq!(said(players.digit(3, || 7)), "Key(3);");
        let faces = players.faces();
        assert_eq!(faces.iter().map(|f| f.digit).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        assert_eq!((faces[2].name.as_str(), faces[2].trigger), ("knock", true));
        // The third pattern has the first digit that is left.
        assert_eq!((faces[3].name.as_str(), faces[3].trigger), ("rest", false));
        assert_eq!(said(players.digit(4, || 7)), "Start(7, \"rest\");");
        assert_eq!(players.keyless(), 0);
    }

    #[test]
    fn a_pattern_that_a_trigger_plays_has_its_key() {
        let mut players = players();
        players.triggers = vec![(1, "run".into()), (2, "walk".into())];
        let names: Vec<_> = players.faces().into_iter().map(|f| (f.digit, f.name)).collect();
        assert_eq!(names, [(1, "run".to_string()), (2, "walk".into()), (3, "rest".into())]);
        assert_eq!(
            (players.keyless(), said(players.digit(4, || 7))),
            (0, "there is no pattern 4: this patch has 3".into())
        );
        // More than there are digits for.
        players.patterns = (0..12).map(|n| format!("p{n}")).collect();
        assert_eq!(players.keyless(), 5);
    }

    #[test]
    fn space_stops_all_and_then_begins_again() {
        let mut players = players();
        players.play(names(&["walk", "run"]));
        assert!(players.faces()[0].playing && players.faces()[1].playing);
        assert_eq!(said(players.all(|| 7)), "StopNamed(\"run\");StopNamed(\"walk\");");
        players.play(vec![]);
        assert_eq!(said(players.all(|| 7)), "Start(7, \"run\");");
        players.first.clear();
        assert_eq!(said(players.all(|| 7)), "Start(7, \"walk\");");
        assert_eq!(said(Players::default().all(|| 7)), "this patch has no patterns");
    }
}
