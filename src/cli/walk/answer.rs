//! What somebody says about what was felt.

use super::probe::may_be_felt;
use pacinian::rig::{Output, Rig};
use pacinian::text::nearest::suggest;

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
    /// The one before again.
    Back,
    /// Enough.
    Quit,
}

/// What may be said.
pub const HELP: &str =
    "Enter: yes   NAME or channel: it was that one   n: nothing   r: again   b: back   q: end";

impl Answer {
    /// Of a line.
    ///
    /// # Errors
    /// Says what it cannot mean.
    pub fn of(line: &str, rig: &Rig) -> Result<Self, String> {
        match line {
            "" | "y" => return Ok(Self::Yes),
            "n" => return Ok(Self::Nothing),
            "r" => return Ok(Self::Again),
            "b" => return Ok(Self::Back),
            "q" => return Ok(Self::Quit),
            _ => {}
        }
        let felt = || rig.outputs.iter().enumerate().filter(|(_, output)| may_be_felt(output));
        let only = |which: &dyn Fn(&Output) -> bool| {
            let mut found = felt().filter(|(_, output)| which(output));
            found.next().filter(|_| found.next().is_none()).map(|(at, _)| Self::Felt(at))
        };
        if let Ok(channel) = line.parse::<u32>() {
            return only(&|output| output.channel == channel)
                .ok_or_else(|| format!("the rig has nothing that is felt on channel {channel}"));
        }
        let lower = line.to_lowercase();
        only(&|output| output.name == line)
            .or_else(|| only(&|output| output.name.to_lowercase() == lower))
            .or_else(|| only(&|output| output.name.to_lowercase().starts_with(&lower)))
            .ok_or_else(|| {
                let near = suggest(line, felt().map(|(_, output)| output.name.as_str()));
                format!(
                    "no tactor is called `{line}`{}",
                    near.map_or(String::new(), |near| format!("; {near}"))
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::Answer;
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
    }
}
