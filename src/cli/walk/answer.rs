//! What somebody says about what was felt.

use pacinian::live::walk::probe::may_be_felt;
use pacinian::rig::{Output, Rig};
use pacinian::text::nearest::suggest;
use pacinian::text::problem::escaped;

/// What was said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// It was where it should be.
    Yes,
    /// It was this output of the rig.
    Felt(usize),
    /// Nothing was felt.
    Nothing,
    /// The same again.
    Again,
    /// On to the next, without an answer.
    Skip,
    /// The one before again.
    Back,
    /// Enough.
    Quit,
}

/// What may be said in a line.
pub const LINES: &str = "Enter: yes   NAME, t NAME or channel: it was that one   n: nothing   r: again   s: skip   b: back   q: end";

/// What may be said with a key.
pub const KEYS: &str = "y or Enter: yes   t: it was another, by name or channel   n: nothing   r: again   s: skip   b: back   q: end";

/// What a key says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pressed {
    /// An answer, and the word for it.
    Answer(Answer, &'static str),
    /// That the name or the channel of an output follows.
    Name,
    /// Nothing.
    Nothing,
}

impl Pressed {
    /// Of a key.
    pub fn of(key: char) -> Self {
        match key.to_ascii_lowercase() {
            'y' | '\n' => Self::Answer(Answer::Yes, "yes"),
            'n' => Self::Answer(Answer::Nothing, "nothing"),
            'r' => Self::Answer(Answer::Again, "again"),
            's' => Self::Answer(Answer::Skip, "skipped"),
            'b' => Self::Answer(Answer::Back, "back"),
            'q' => Self::Answer(Answer::Quit, "end"),
            't' => Self::Name,
            _ => Self::Nothing,
        }
    }
}

impl Answer {
    /// Of a line.
    ///
    /// # Errors
    /// Says what it cannot mean.
    pub fn of(line: &str, rig: &Rig) -> Result<Self, String> {
        match line {
            "" | "y" => Ok(Self::Yes),
            "n" => Ok(Self::Nothing),
            "r" => Ok(Self::Again),
            "s" => Ok(Self::Skip),
            "b" => Ok(Self::Back),
            "q" => Ok(Self::Quit),
            // A name may be a letter that means something else.
            _ => Self::named(line, rig).or_else(|why| {
                line.strip_prefix("t ").map_or(Err(why), |name| Self::named(name.trim_start(), rig))
            }),
        }
    }

    /// Of the name or the channel of an output.
    ///
    /// # Errors
    /// Says what it cannot mean.
    pub fn named(line: &str, rig: &Rig) -> Result<Self, String> {
        let felt = || rig.outputs.iter().enumerate().filter(|(_, output)| may_be_felt(output));
        let only = |which: &dyn Fn(&Output) -> bool| {
            let mut found = felt().filter(|(_, output)| which(output));
            found.next().filter(|_| found.next().is_none()).map(|(at, _)| Self::Felt(at))
        };
        if let Ok(channel) = line.parse::<u32>() {
            return only(&|output| output.channel == channel)
                .ok_or_else(|| format!("the rig has nothing that is felt on channel {channel}"));
        }
        if line.is_empty() {
            return Err("no name, no channel".into());
        }
        let lower = line.to_lowercase();
        only(&|output| output.name == line)
            .or_else(|| only(&|output| output.name.to_lowercase() == lower))
            .or_else(|| only(&|output| output.name.to_lowercase().starts_with(&lower)))
            .ok_or_else(|| {
                let near = suggest(line, felt().map(|(_, output)| output.name.as_str()));
                format!(
                    "no tactor is called `{}`{}",
                    escaped(line),
                    near.map_or(String::new(), |near| format!("; {near}"))
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, KEYS, Pressed};
    use pacinian::Rig;

    #[test]
    fn names_numbers_and_letters() {
        let text = "format = \"pacinian-rig/1\"\n[device]\nchannels = 4\n[[tactor]]\nname = \"Front-left\"\nchannel = 2\n\
            [[tactor]]\nname = \"front\"\nchannel = 1\n[[tactor]]\nname = \"back\"\nchannel = 3\n\
            [[output]]\nname = \"knob\"\nkind = \"torque\"\nchannel = 4\n";
        let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
        let of = |line: &str| Answer::of(line, &rig);
        assert_eq!([of(""), of("n"), of("b")], [Ok(Answer::Yes), Ok(Answer::Nothing), Ok(Answer::Back)]);
        assert_eq!(
            [of("2"), of("front"), of("front-l"), of("BACK")],
            [0, 1, 0, 2].map(|n| Ok(Answer::Felt(n)))
        );
        for wrong in ["4", "0", "9", "knob", "fro", "-1", "x"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
        assert!(of("bakc").unwrap_err().contains("`back`"));
        // A name is a name, though it begins as a word that may be said.
        assert_eq!(Answer::named("b", &rig), Ok(Answer::Felt(2)));
        assert!(Answer::named("", &rig).is_err());
        assert_eq!([of("t b"), of("t  BACK"), of("t 1")], [2, 2, 1].map(|n| Ok(Answer::Felt(n))));
        assert!(of("t").is_err() && of("t x").unwrap_err().contains("`x`"));
    }

    #[test]
    fn keys_say_what_their_help_says() {
        let keys = KEYS.split("   ").map(|item| item.chars().next().unwrap());
        let said: Vec<_> = keys.clone().map(Pressed::of).collect();
        assert_eq!(keys.collect::<String>(), "ytnrsbq");
        assert!(!said.contains(&Pressed::Nothing) && said[1] == Pressed::Name);
        assert_eq!(Pressed::of('\n'), said[0]);
        for key in ['x', ' ', '1', '\u{8}', '[', 'a'] {
            assert_eq!(Pressed::of(key), Pressed::Nothing);
        }
    }
}
