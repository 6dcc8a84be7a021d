//! A port that was asked for and is not there, while others are.

use std::fmt;

use crate::text::nearest::nearest;

/// Ports that are named, at most.
const MOST: usize = 12;

/// No port has the name that was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// What was asked for.
    pub wanted: String,
    /// The port that may have been meant.
    pub meant: Option<String>,
    /// Those that there are.
    pub there: Vec<String>,
}

/// Whether a port of that name is asked for: any part of it will do.
pub(super) fn fits(wanted: &str, name: &str) -> bool {
    name.to_lowercase().contains(&wanted.to_lowercase())
}

impl Unknown {
    /// Where ports are there, and none is the one that is wanted. Where there is none at all, nothing was mistaken.
    pub fn of(wanted: &str, there: &[String]) -> Option<Self> {
        if there.is_empty() || there.iter().any(|name| fits(wanted, name)) {
            return None;
        }
        // As a part of a name will do, a part may have been mistyped: a word, several, or the beginning of either.
        let length = wanted.chars().count();
        let parts = |name: &String| {
            let starts: Vec<usize> = name
                .char_indices()
                .filter(|(at, c)| {
                    let before = name.get(..*at).and_then(|before| before.chars().next_back());
                    c.is_alphanumeric() && before.is_none_or(|before| !before.is_alphanumeric())
                })
                .map(|(at, _)| at)
                .collect();
            let from = |at: &usize| name.get(*at..).unwrap_or_default();
            let first = |text: &str| text.chars().take(length).collect::<String>();
            let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric()).collect::<String>();
            starts.iter().flat_map(|at| [first(from(at)), word(from(at))]).collect::<Vec<_>>()
        };
        let all: Vec<(String, &String)> = there
            .iter()
            .flat_map(|name| parts(name).into_iter().chain([name.clone()]).map(move |part| (part, name)))
            .collect();
        let near = nearest(wanted, all.iter().map(|(part, _)| part.as_str()));
        let meant = near.and_then(|near| all.iter().find(|(part, _)| part == near));
        Some(Self {
            wanted: wanted.into(),
            meant: meant.map(|(_, name)| (*name).clone()),
            there: there.to_vec(),
        })
    }
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no MIDI port is called `{}`", self.wanted)?;
        let names: Vec<String> = self.there.iter().take(MOST).map(|name| format!("`{name}`")).collect();
        match (&names[..], &self.meant) {
            ([only], _) => write!(f, "; there is only {only}")?,
            (several, None) => write!(f, "; there are {}", several.join(", "))?,
            (several, Some(meant)) => {
                write!(f, ": did you mean `{meant}`? There are {}", several.join(", "))?;
            }
        }
        match self.there.len().saturating_sub(MOST) {
            0 => {}
            more => write!(f, " and {more} more")?,
        }
        write!(f, "; it is waited for")
    }
}

#[cfg(test)]
mod tests {
    use super::Unknown;

    fn of(wanted: &str, there: &[&str]) -> Option<Unknown> {
        let there: Vec<String> = there.iter().map(|name| (*name).to_string()).collect();
        Unknown::of(wanted, &there)
    }

    #[test]
    fn nothing_is_unknown_where_it_is_there_or_nothing_is() {
        assert_eq!(of("kyes", &[]), None);
        assert_eq!(of("keys", &["Pads", "USB KEYS 20:0"]), None, "in any case, and a part of it");
        assert!(of("kyes", &["Pads", "USB KEYS 20:0"]).is_some());
    }

    #[test]
    fn the_port_that_was_meant_is_found_by_a_part_of_its_name() {
        let ports =
            ["nanoPAD2:nanoPAD2 MIDI 1 24:0", "Keystation 49:Keystation 49 MIDI 1 20:0", "Launch Control"];
        for (wanted, meant) in [
            ("kyes", Some(1)),
            ("kyestation", Some(1)),
            ("Keystatoin 49", Some(1)),
            ("nanopad3", Some(0)),
            ("lanuch", Some(2)),
            ("launch contrl", Some(2)),
            ("contrl", Some(2)),
            ("oboe d'amore", None),
        ] {
            let unknown = of(wanted, &ports).unwrap();
            assert_eq!(unknown.meant.as_deref(), meant.map(|n: usize| ports[n]), "{wanted}");
            assert_eq!(unknown.there.len(), 3);
        }
    }

    #[test]
    fn it_is_told_in_a_line() {
        let said = |wanted, there: &[&str]| of(wanted, there).unwrap().to_string();
        assert_eq!(
            said("kyes", &["Keys", "Pads"]),
            "no MIDI port is called `kyes`: did you mean `Keys`? There are `Keys`, `Pads`; it is waited for"
        );
        assert_eq!(
            said("x", &["Pads"]),
            "no MIDI port is called `x`; there is only `Pads`; it is waited for"
        );
        assert_eq!(
            said("xylophone", &["A", "B"]),
            "no MIDI port is called `xylophone`; there are `A`, `B`; it is waited for"
        );
        let many: Vec<String> = (0..40).map(|n| format!("Port {n}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        let said = said("xylophone", &many);
        assert!(
            said.contains("`Port 11` and 28 more; it is waited for") && !said.contains("Port 12"),
            "{said}"
        );
    }
}
