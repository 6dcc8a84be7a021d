//! What of OSC came to nothing: said once for each address while it plays, and by its message in a journal, as long as not too much comes;
//! all of it is counted in [`Counts`](super::counts::Counts).

use std::collections::BTreeSet;
use std::sync::mpsc::Sender;

use rosc::OscType;

use super::allowance::Allowance;
use super::names::{Method, Names, Unfound};
use super::time::FURTHEST;
use crate::live::stamp::Stamp;
use crate::patch::Mover;
use crate::text::problem::shown;

/// Addresses of which it is said.
const MOST: usize = 32;

/// Says what came to nothing.
#[derive(Debug)]
pub struct Complaints {
    to: Sender<String>,
    known: BTreeSet<String>,
    allowance: Allowance,
}

/// Why something came to nothing, for a journal; `None` where too much of it comes.
pub type Why = Option<String>;

impl Complaints {
    /// Says it there.
    pub fn new(to: Sender<String>) -> Self {
        Self { to, known: BTreeSet::new(), allowance: Allowance::default() }
    }

    /// A message to an address that is not there.
    pub fn unknown(&mut self, now: Stamp, address: &str, names: &Names) -> Why {
        self.say_and_write(now, address, || {
            let near = names.nearest(address).map_or(
                ": there are /voice/NAME/play, /pattern/NAME/play, /control/NAME, and those of the patch"
                    .into(),
                |near| format!(": did you mean `{near}`?"),
            );
            format!("nothing is at `{address}`{near}")
        })
    }

    /// A message whose arguments do not fit.
    pub fn wrong(&mut self, now: Stamp, address: &str, args: &[OscType], method: &Method) -> Why {
        self.say_and_write(now, address, || {
            let told = if args.is_empty() { "nothing".into() } else { listed(args) };
            format!("`{address}` takes {}, and was sent {told}", method.takes())
        })
    }

    /// One whose address was not looked for.
    pub fn unfound(&mut self, now: Stamp, unfound: Unfound) -> Why {
        self.write(now, || {
            match unfound {
                Unfound::NoPattern => "its address is too long, or no pattern",
                Unfound::Costly => "its address, or all that is in its datagram, takes too long to look for",
            }
            .into()
        })
    }

    /// One that is about what was played under an `id`, of which nothing is known.
    pub fn strange(&mut self, now: Stamp, id: i64) -> Why {
        self.write(now, || format!("nothing that was played under the id {id} is known any more"))
    }

    /// One for which there is no room among what waits for its time.
    pub fn crammed(&mut self, now: Stamp) -> Why {
        self.write(now, || "too much waits for its time already".into())
    }

    /// One that waited for its time when a panic came, or came after it and would have taken it back.
    pub fn cancelled(&mut self, now: Stamp) -> Why {
        self.write(now, || "a panic came before its time".into())
    }

    /// One that waited for its time when a patch took over that has no such control.
    pub fn forgotten(&mut self, now: Stamp) -> Why {
        self.write(now, || "a patch took over before its time that has no such control".into())
    }

    /// A message to what bindings listen to, which take numbers from one of their ends to the other; and those that it has.
    pub fn position(&mut self, address: &str, numbers: &[f64], names: &Names) {
        for bind in names.bound(address) {
            let Mover::Osc { argument, .. } = bind.from else { continue };
            let [from, to] = bind.sends;
            let which = if argument == 1 { String::new() } else { format!(" as its number {argument}") };
            let place = argument.checked_sub(1).and_then(|place| numbers.get(place));
            let Some(number) = place.filter(|number| !number.is_nan()) else {
                // A button that says nothing at all is pushed.
                if numbers.is_empty() {
                    continue;
                }
                self.say(address, || match numbers.len() {
                    count if argument <= count => {
                        format!("`{address}` says no number in place {argument}, for which its binding waits")
                    }
                    1 => format!("`{address}` says 1 number; its binding waits for number {argument}"),
                    count => {
                        format!("`{address}` says {count} numbers; its binding waits for number {argument}")
                    }
                });
                continue;
            };
            let (least, most) = (from.min(to), from.max(to));
            if !(least..=most).contains(number) {
                self.say(address, || {
                    let nearest = number.clamp(least, most);
                    format!(
                        "`{address}` says {number}{which}: its binding takes numbers from {from} to {to}, so it is {nearest}; say in [[bind]] what it `sends`"
                    )
                });
            }
        }
    }

    /// A message from `sender` whose time was so many seconds ago: below a second, it was on its way.
    pub fn late(&mut self, sender: &str, seconds: f64) {
        if seconds >= 1.0 {
            self.say(&format!("late {sender}"), || {
                format!("what {sender} sent for {seconds:.1} s ago is played at once: compare the clocks of the two machines")
            });
        }
    }

    /// One from `sender` whose time is farther ahead than anything waits.
    pub fn far(&mut self, now: Stamp, sender: &str) -> Why {
        self.say_and_write(now, &format!("far {sender}"), || {
            format!(
                "what {sender} sent for more than {FURTHEST} s ahead is not played: compare the clocks of the two machines"
            )
        })
    }

    /// Says it, where it was not said of that address.
    fn say(&mut self, address: &str, text: impl FnOnce() -> String) {
        if self.known.len() > MOST || self.known.contains(address) {
            return;
        }
        let text = match self.known.len() {
            MOST => "OSC: more came to nothing, which is counted in the end".into(),
            _ => shown(&format!("OSC: {}", text())),
        };
        self.known.insert(address.into());
        // Where nobody listens any more, the session is over.
        let _ = self.to.send(text);
    }

    /// Gives it, as long as not too much came before.
    fn write(&mut self, now: Stamp, text: impl FnOnce() -> String) -> Why {
        self.allowance.take(now).then(|| shown(&text()))
    }

    fn say_and_write(&mut self, now: Stamp, address: &str, text: impl Fn() -> String) -> Why {
        self.say(address, &text);
        self.write(now, text)
    }
}

/// Arguments in words, the first of them.
fn listed(args: &[OscType]) -> String {
    let word = |arg: &OscType| match arg {
        OscType::Int(x) => x.to_string(),
        OscType::Long(x) => x.to_string(),
        OscType::Float(x) => x.to_string(),
        OscType::Double(x) => x.to_string(),
        OscType::String(text) => format!("\"{text}\""),
        OscType::Bool(x) => x.to_string(),
        _ => "something else".into(),
    };
    let rest = if args.len() > 4 { ", ..." } else { "" };
    args.iter().take(4).map(word).collect::<Vec<_>>().join(", ") + rest
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use rosc::OscType;

    use super::{Complaints, MOST, Method, Names};
    use crate::io::osc::tests::PATCH;
    use crate::live::stamp::Stamp;
    use crate::patch::Patch;

    #[test]
    fn each_address_is_told_of_once_and_says_what_it_takes() {
        let patch = Patch::parse("t", PATCH.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let names = Names::of(&patch);
        let (to, told) = channel();
        let mut complaints = Complaints::new(to);
        let said = || told.try_iter().collect::<Vec<String>>();
        let now = Stamp(0);
        for _ in 0..3 {
            let why = complaints.unknown(now, "/voice/lo/play", &names);
            assert_eq!(why.unwrap(), "nothing is at `/voice/lo/play`: did you mean `/voice/low/play`?");
        }
        assert_eq!(said(), ["OSC: nothing is at `/voice/lo/play`: did you mean `/voice/low/play`?"]);
        complaints.unknown(now, "/q", &names);
        assert!(said()[0].ends_with("and those of the patch"));
        let args = [OscType::String("0.5\n".into()), OscType::Float(0.25)];
        complaints.wrong(now, "/control/depth", &args, &Method::Set(0));
        assert_eq!(said(), ["OSC: `/control/depth` takes a number, and was sent \"0.5\\n\", 0.25"]);
        complaints.wrong(now, "/voice/release", &[], &Method::Release);
        assert_eq!(said(), ["OSC: `/voice/release` takes an id, and was sent nothing"]);
        for _ in 0..2 {
            complaints.late("10.0.0.2:9000", 0.9);
            complaints.late("10.0.0.2:9000", 3.04);
            complaints.far(now, "10.0.0.2:9000");
        }
        let clocks = said();
        assert!(
            clocks.len() == 2 && clocks[0].contains("10.0.0.2:9000 sent for 3.0 s ago is played at once")
        );
        assert!(clocks[1].contains("for more than 60 s ahead is not played"), "{}", clocks[1]);
        for n in 0..3 * MOST {
            complaints.unknown(now, &format!("/{n}"), &names);
        }
        let rest = said();
        assert_eq!(rest.len(), MOST + 1 - 6);
        assert_eq!(rest.last().unwrap(), "OSC: more came to nothing, which is counted in the end");
    }

    const FADER: &str = "/1/fader1";

    #[test]
    fn a_binding_takes_positions() {
        let patch = Patch::parse("t", PATCH.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let names = Names::of(&patch);
        let (to, told) = channel();
        let mut complaints = Complaints::new(to);
        for (address, numbers) in
            [("/hit/left", vec![64.0]), (FADER, vec![0.0]), (FADER, vec![1.0, 9.0]), (FADER, vec![])]
        {
            complaints.position(address, &numbers, &names);
        }
        assert!(told.try_recv().is_err());
        complaints.position(FADER, &[64.0], &names);
        assert!(
            told.try_recv()
                .unwrap()
                .contains("`/1/fader1` says 64: its binding takes numbers from 0 to 1, so it is 1;")
        );
    }

    #[test]
    fn of_several_numbers_each_is_looked_at() {
        let text = format!(
            "{PATCH}[[bind]]\nfrom = \"osc./hand\"\ncontrol = \"depth\"\nsends = [0.5, -0.5]\n\
             [[bind]]\nfrom = \"osc./head 2\"\ncontrol = \"depth\"\n"
        );
        let names = Names::of(&Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value);
        let said = |address: &str, numbers: &[f64]| {
            let (to, told) = channel();
            Complaints::new(to).position(address, numbers, &names);
            told.try_recv().unwrap_or_default()
        };
        assert_eq!(said("/hand", &[-0.5, 7.0]) + &said("/head", &[9.0, 1.0]), "");
        assert!(
            said("/hand", &[-0.75])
                .contains("`/hand` says -0.75: its binding takes numbers from 0.5 to -0.5, so it is -0.5;")
        );
        assert!(said("/head", &[0.0, 2.0]).contains("`/head` says 2 as its number 2: its binding"));
        assert!(said("/head", &[0.0]).contains("`/head` says 1 number; its binding waits for number 2"));
    }
}
