//! The addresses there are: those of pacinian, and those that a patch gives.

use std::collections::HashMap;

use super::address::{LONGEST, Pattern};
use super::announce::Wants;
use crate::midi::What;
use crate::patch::{Bind, Control, Mover, Patch, Source};
use crate::text::nearest::nearest;

/// Addresses among which the one that was meant is looked for.
const NEAR: usize = 1000;

/// What an address does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Method {
    /// Plays a voice.
    Play(String),
    /// Releases what was played under an id.
    Release,
    /// Releases all that sounds.
    ReleaseAll,
    /// Moves the hand that holds what was played under an id.
    Touch(What),
    /// Starts a pattern.
    Start(String),
    /// Stops a pattern.
    Stop(String),
    /// Moves a control, by its number in the patch.
    Set(usize),
    /// Moves several at once, each with its number of the message.
    Feed(Vec<usize>),
    /// Tells the value of a control, once or again and again.
    Get(usize),
    /// Tells all that there is of a kind.
    List(Kind),
    /// Closes the gate.
    Panic,
    /// Takes a panic back.
    Calm,
    /// Full level, or that for headphones.
    Arm,
    /// The knob's torque, or none.
    Torque,
    /// Tells peaks again and again.
    Subscribe,
    /// No more.
    Unsubscribe,
    /// Tells what is played, as it is played.
    Invite(Wants),
    /// No more.
    Dismiss,
    /// Tells how the session stands.
    Status,
    /// Answers.
    Ping,
    /// Goes into the journal.
    Note,
    /// Is for the patch's triggers and bindings.
    Trigger(String),
}

/// What can be listed of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Its controls, and where they stand.
    Controls,
    /// Its voices.
    Voices,
    /// Its patterns.
    Patterns,
}

impl Method {
    /// What arguments it takes, in words.
    pub fn takes(&self) -> &'static str {
        match self {
            Self::Play(_) => {
                "a level, a duration and a frequency, or fewer of them, and then pairs of a name and a value"
            }
            Self::Release => "an id",
            Self::Touch(_) => "an id and a number",
            Self::Set(_) => "a number",
            Self::Feed(_) => "as many numbers as there are names in the address",
            Self::Get(_) | Self::Subscribe => "nothing, or milliseconds from report to report",
            Self::Arm | Self::Torque => "0 or 1",
            Self::Trigger(_) => "numbers",
            Self::Note => "anything",
            Self::Start(_)
            | Self::Stop(_)
            | Self::List(_)
            | Self::ReleaseAll
            | Self::Panic
            | Self::Calm
            | Self::Unsubscribe
            | Self::Invite(_)
            | Self::Dismiss
            | Self::Status
            | Self::Ping => "nothing, or 1 from a button that is pressed and 0 as it is let go",
        }
    }
}

/// Addresses that are there whatever the patch.
const OWN: [(&str, Method); 21] = [
    ("/release", Method::ReleaseAll),
    ("/voice/release", Method::Release),
    ("/voice/bend", Method::Touch(What::Bend)),
    ("/voice/pressure", Method::Touch(What::Pressure)),
    ("/voice/timbre", Method::Touch(What::Timbre)),
    ("/controls", Method::List(Kind::Controls)),
    ("/voices", Method::List(Kind::Voices)),
    ("/patterns", Method::List(Kind::Patterns)),
    ("/panic", Method::Panic),
    ("/calm", Method::Calm),
    ("/arm", Method::Arm),
    ("/torque", Method::Torque),
    ("/meter/subscribe", Method::Subscribe),
    ("/meter/unsubscribe", Method::Unsubscribe),
    ("/marker/subscribe", Method::Invite(Wants::Markers)),
    ("/marker/unsubscribe", Method::Dismiss),
    ("/event/subscribe", Method::Invite(Wants::All)),
    ("/event/unsubscribe", Method::Dismiss),
    ("/status", Method::Status),
    ("/ping", Method::Ping),
    ("/journal/note", Method::Note),
];

/// What addresses begin with that are those of a patch's voices, patterns and controls.
const OF_PATCHES: [&str; 4] = ["voice", "pattern", "control", "input"];

/// Whether an address is one of pacinian's own, or beside such, where a patch may have one.
pub fn is_own(address: &str) -> bool {
    let first = |address: &str| address.split('/').nth(1).map(String::from);
    first(address).is_some_and(|begins| {
        OF_PATCHES.contains(&begins.as_str())
            || OWN.iter().any(|(own, _)| first(own).as_ref() == Some(&begins))
    })
}

/// The addresses there are for a patch.
#[derive(Debug, Clone, Default)]
pub struct Names {
    methods: Vec<(String, Method)>,
    places: HashMap<String, usize>,
    /// The bindings to each.
    bound: HashMap<String, Vec<Bind>>,
    /// By how many seconds the least of the streams is later that are bound to each, and to which nothing else listens.
    streams: HashMap<String, f64>,
    /// The patch's controls.
    pub controls: Vec<Control>,
    /// The names of its voices.
    pub voices: Vec<String>,
    /// The names of its patterns.
    pub patterns: Vec<String>,
}

impl Names {
    /// Of a patch. Where two things would share an address, the first has it: pacinian's own, then voices, patterns, controls, triggers and
    /// bindings; both hear of one that they share.
    pub fn of(patch: &Patch) -> Self {
        let mut names = Self {
            controls: patch.controls.clone(),
            voices: patch.voices.iter().map(|voice| voice.name.clone()).collect(),
            patterns: patch.patterns.iter().map(|pattern| pattern.name.clone()).collect(),
            ..Self::default()
        };
        for (address, method) in OWN {
            names.add(address.into(), method);
        }
        for voice in &patch.voices {
            names.add(format!("/voice/{}/play", voice.name), Method::Play(voice.name.clone()));
        }
        for pattern in &patch.patterns {
            names.add(format!("/pattern/{}/play", pattern.name), Method::Start(pattern.name.clone()));
            names.add(format!("/pattern/{}/stop", pattern.name), Method::Stop(pattern.name.clone()));
        }
        for (number, control) in patch.controls.iter().enumerate() {
            names.add(format!("/control/{}", control.name), Method::Set(number));
            names.add(format!("/control/{}/get", control.name), Method::Get(number));
            if control.stream > 0.0 {
                names.add(format!("/input/{}", control.name), Method::Set(number));
            }
        }
        for trigger in &patch.triggers {
            if let Source::Osc(address) = &trigger.on {
                names.add(address.clone(), Method::Trigger(address.clone()));
            }
        }
        for bind in &patch.binds {
            if let Mover::Osc { address, .. } = &bind.from {
                names.add(address.clone(), Method::Trigger(address.clone()));
                names.bound.entry(address.clone()).or_default().push(bind.clone());
            }
        }
        let stream = |bind: &Bind| {
            names.controls.iter().find(|control| control.name == bind.control).map_or(0.0, |c| c.stream)
        };
        let least = |binds: &[Bind]| binds.iter().map(stream).fold(f64::INFINITY, f64::min);
        let set_off =
            |address: &str| patch.triggers.iter().any(|t| matches!(&t.on, Source::Osc(on) if on == address));
        let of_streams = names.bound.iter().filter(|(address, _)| !set_off(address));
        names.streams = of_streams.map(|(address, binds)| (address.clone(), least(binds))).collect();
        names
    }

    fn add(&mut self, address: String, method: Method) {
        self.places.entry(address.clone()).or_insert_with(|| {
            self.methods.push((address, method));
            self.methods.len() - 1
        });
    }

    /// The bindings that listen to an address.
    pub fn bound(&self, address: &str) -> &[Bind] {
        self.bound.get(address).map_or(&[], Vec::as_slice)
    }

    /// By how many seconds all that a method moves is later than what comes, so that a value may come late and yet be there in time.
    pub fn stream(&self, method: &Method) -> f64 {
        let of = |number: &usize| self.controls.get(*number).map_or(0.0, |control| control.stream);
        match method {
            Method::Set(number) => of(number),
            Method::Feed(numbers) => numbers.iter().map(of).fold(f64::INFINITY, f64::min),
            Method::Trigger(address) => self.streams.get(address).copied().unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// The streams that `/input/NAME/NAME/...` names.
    fn fed(&self, address: &str) -> Option<Vec<usize>> {
        let names = address.strip_prefix("/input/")?;
        let number = |name: &str| {
            self.controls.iter().position(|control| control.name == name && control.stream > 0.0)
        };
        names.split('/').map(number).collect()
    }

    /// The address that was probably meant.
    pub fn nearest(&self, address: &str) -> Option<&str> {
        nearest(address, self.methods.iter().take(NEAR).map(|(address, _)| address.as_str()))
    }

    /// What an address means: that which has it to the letter, else all that it matches as a pattern. Nothing, if there is none. It takes no more than
    /// so many steps ([`Pattern::matches`]), which become fewer.
    ///
    /// # Errors
    /// An address that is too long, or no pattern; one that takes more steps.
    pub fn find(&self, address: &str, steps: &mut u64) -> Result<Vec<Method>, Unfound> {
        if let Some((_, method)) = self.places.get(address).and_then(|place| self.methods.get(*place)) {
            return Ok(vec![method.clone()]);
        }
        if address.len() > LONGEST {
            return Err(Unfound::NoPattern);
        }
        if !address.contains(['?', '*', '[', ']', '{', '}']) {
            return Ok(self.fed(address).map(Method::Feed).into_iter().collect());
        }
        let pattern = Pattern::parse(address).ok_or(Unfound::NoPattern)?;
        let mut found = Vec::new();
        for (address, method) in &self.methods {
            let mut taken = 0;
            if pattern.matches(address, &mut taken) {
                found.push(method.clone());
            }
            *steps = steps.saturating_sub(taken);
            if *steps == 0 {
                return Err(Unfound::Costly);
            }
        }
        Ok(found)
    }
}

/// Why an address is not looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unfound {
    /// It is too long, or no pattern.
    NoPattern,
    /// It takes too many steps.
    Costly,
}

#[cfg(test)]
mod tests {
    use super::{Method, Names, Unfound, is_own};
    use crate::io::osc::tests::PATCH;
    use crate::patch::Patch;

    #[test]
    fn whatever_a_session_has_itself_is_its_own() {
        let names = Names::of(&Patch::parse("p", PATCH.as_bytes()).unwrap().value);
        assert!(names.methods.len() > 25);
        for (address, method) in &names.methods {
            assert_eq!(is_own(address), !matches!(method, Method::Trigger(_)), "{address}");
        }
        for other in ["/1/fader1", "/voicemail", "/", "", "voice", "/torque2"] {
            assert!(!is_own(other), "{other}");
        }
    }

    #[test]
    fn to_the_letter_and_by_pattern() {
        let names = Names::of(&Patch::parse("p", PATCH.as_bytes()).unwrap().value);
        let find = |address: &str| names.find(address, &mut { u64::MAX }).unwrap();
        assert_eq!(find("/voice/low/play"), [Method::Play("low".into())]);
        assert_eq!(
            find("/voice/*/play"),
            [Method::Play("low".into()), Method::Play("high".into()), Method::Play("release".into())]
        );
        assert_eq!(find("/voice/{high,none}/play"), [Method::Play("high".into())]);
        assert_eq!(find("/voice/release"), [Method::Release]);
        assert_eq!(find("/pattern/walk/stop"), [Method::Stop("walk".into())]);
        assert_eq!(find("/control/tem?o"), [Method::Set(1)]);
        assert_eq!(find("/control/*/get"), [Method::Get(0), Method::Get(1)]);
        assert_eq!(find("/hit/left"), [Method::Trigger("/hit/left".into())]);
        assert_eq!(find("/1/fader*"), [Method::Trigger("/1/fader1".into())]);
        // A trigger cannot take what is pacinian's own.
        assert_eq!(find("/ping"), [Method::Ping]);
        // Of controls, those that are streams have that address, too.
        assert_eq!((find("/input/depth"), find("/input/tempo")), (vec![], vec![Method::Set(1)]));
        for nothing in
            ["/", "/voice", "/voice/none/play", "/voice/low/play/", "/nothing*", "/input/", "voice"]
        {
            assert_eq!(find(nothing), [], "{nothing}");
        }
        // What a pattern costs is known, and what costs too much is not done.
        let cost = |pattern: &str| {
            let mut steps = 1_000_000;
            let found = names.find(pattern, &mut steps);
            (found.is_ok(), 1_000_000 - steps)
        };
        let (all, hostile) = (cost("/control/*"), cost(&format!("/control/{}*0", "*{a,}".repeat(48))));
        assert!(all.0 && all.1 < 20_000, "{all:?}");
        assert!(hostile.1 > 20 * names.controls.len() as u64, "{hostile:?}");
        assert_eq!(names.find(&format!("/*/{}", "*{a,}".repeat(49)), &mut 100), Err(Unfound::Costly));
        assert_eq!(names.find("/panic", &mut 1), Ok(vec![Method::Panic]));
        for wrong in ["/voice/[a/play", "/a{", &format!("/{}", "a".repeat(300))] {
            assert_eq!(names.find(wrong, &mut { u64::MAX }), Err(Unfound::NoPattern), "{wrong}");
        }
    }
}
