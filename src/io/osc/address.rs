//! Address patterns: `?`, `*`, `[a-z]`, `[!a-z]` and `{one,other}`, each within a part of an address, as OSC 1.0 has them.

/// The longest address that is read, in bytes. What a pattern costs grows with its length.
pub const LONGEST: usize = 256;

/// A pattern that addresses may match.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    parts: Vec<Vec<Token>>,
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    /// This character.
    Literal(char),
    /// Any one.
    One,
    /// Any number of any.
    Many,
    /// One within one of these ranges; or in none of them.
    Among(Vec<(char, char)>, bool),
    /// One of these words.
    Either(Vec<Vec<char>>),
}

impl Pattern {
    /// Reads one; `None` where it does not begin with `/`, is longer than [`LONGEST`], or leaves a bracket open.
    pub fn parse(text: &str) -> Option<Self> {
        let rest = text.strip_prefix('/').filter(|_| text.len() <= LONGEST)?;
        Some(Self { parts: rest.split('/').map(tokens).collect::<Option<_>>()? })
    }

    /// Whether an address matches, part by part. Adds to `steps` how many characters were looked at, those of each token anew.
    pub fn matches(&self, address: &str, steps: &mut u64) -> bool {
        let Some(rest) = address.strip_prefix('/') else { return false };
        let mut parts = rest.split('/');
        self.parts.iter().all(|tokens| parts.next().is_some_and(|part| fits(tokens, part, steps)))
            && parts.next().is_none()
    }
}

fn tokens(part: &str) -> Option<Vec<Token>> {
    let mut chars = part.chars();
    let mut tokens = Vec::new();
    while let Some(c) = chars.next() {
        let token = match c {
            '?' => Token::One,
            // Several in a row mean no more than one.
            '*' if tokens.last() == Some(&Token::Many) => continue,
            '*' => Token::Many,
            '[' => among(&until(&mut chars, ']')?),
            '{' => {
                Token::Either(until(&mut chars, '}')?.split(|c| *c == ',').map(<[char]>::to_vec).collect())
            }
            ']' | '}' => return None,
            c => Token::Literal(c),
        };
        tokens.push(token);
    }
    Some(tokens)
}

/// Everything before `end`, which is passed over.
fn until(chars: &mut std::str::Chars<'_>, end: char) -> Option<Vec<char>> {
    let text = chars.as_str();
    let length = text.find(end)?;
    *chars = text[length + end.len_utf8()..].chars();
    Some(text[..length].chars().collect())
}

/// What stands between square brackets: a `-` between two characters makes a range, a `!` in front turns it round.
fn among(inner: &[char]) -> Token {
    let (not, mut rest) = match inner {
        ['!', rest @ ..] => (true, rest),
        _ => (false, inner),
    };
    let mut ranges = Vec::new();
    while let [first, after @ ..] = rest {
        rest = match after {
            ['-', last, after @ ..] => {
                ranges.push((*first.min(last), *first.max(last)));
                after
            }
            _ => {
                ranges.push((*first, *first));
                after
            }
        };
    }
    Token::Among(ranges, not)
}

/// Follows all ways through the pattern at once, so that no pattern takes longer than its length times that of the part.
fn fits(tokens: &[Token], part: &str, steps: &mut u64) -> bool {
    let part: Vec<char> = part.chars().collect();
    // Which numbers of characters the tokens so far can have taken.
    let mut reached = vec![false; part.len() + 1];
    reached[0] = true;
    for token in tokens {
        let words = if let Token::Either(words) = token { words.len() } else { 0 };
        *steps += (part.len() as u64 + 1) * (1 + words as u64);
        let mut next = vec![false; part.len() + 1];
        for (at, _) in reached.iter().enumerate().filter(|(_, reached)| **reached) {
            let one = |fits: bool, next: &mut [bool]| {
                if let Some(slot) = next.get_mut(at + 1).filter(|_| fits) {
                    *slot = true;
                }
            };
            match (token, part.get(at)) {
                (Token::Many, _) => {
                    next[at..].fill(true);
                    break;
                }
                (Token::Either(words), _) => {
                    for word in words.iter().filter(|word| part[at..].starts_with(word)) {
                        next[at + word.len()] = true;
                    }
                }
                (_, None) => {}
                (Token::Literal(wanted), Some(c)) => one(wanted == c, &mut next),
                (Token::One, Some(_)) => one(true, &mut next),
                (Token::Among(ranges, not), Some(c)) => {
                    one(ranges.iter().any(|(first, last)| (first..=last).contains(&c)) != *not, &mut next);
                }
            }
        }
        reached = next;
    }
    reached.last() == Some(&true)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Pattern};
    use proptest::prelude::{ProptestConfig, any, prop, proptest};

    #[track_caller]
    fn check(pattern: &str, yes: &[&str], no: &[&str]) {
        let parsed = Pattern::parse(pattern).unwrap();
        yes.iter().for_each(|address| assert!(parsed.matches(address, &mut 0), "{pattern} {address}"));
        no.iter().for_each(|address| assert!(!parsed.matches(address, &mut 0), "{pattern} {address}"));
    }

    #[test]
    fn as_osc_has_them() {
        check("/a/b", &["/a/b"], &["/a", "/a/b/", "/a/bb", "a/b", "/a/c", ""]);
        check("/v?/x", &["/v1/x", "/vé/x"], &["/v/x", "/v12/x", "/v//x"]);
        check("/*/play", &["/a/play", "//play"], &["/a/b/play", "/play", "/a/plays"]);
        check("/a*b*c", &["/abc", "/a1b2c", "/abcbc", "/abbcc"], &["/ab", "/acb", "/abcd", "/a/b/c"]);
        check("/[a-c3]x", &["/ax", "/cx", "/3x"], &["/dx", "/x", "/-x"]);
        check("/[!a-c]x", &["/dx", "/-x"], &["/ax", "/x"]);
        check("/[c-a]", &["/b"], &["/d"]);
        // At the end, or in front, a minus is itself; and so is an exclamation mark elsewhere.
        check("/[a-]", &["/a", "/-"], &["/b"]);
        check("/[-a!]", &["/a", "/-", "/!"], &["/b"]);
        check("/{one,other}s", &["/ones", "/others"], &["/one", "/another", "/oneothers"]);
        check("/{,a,ab}b", &["/b", "/ab", "/abb"], &["/a", "/"]);
        check("/{a,ab}{bc,c}", &["/abc", "/abbc", "/ac"], &["/a"]);
        check("/voice/{low,high}*/play", &["/voice/lower/play"], &["/voice/mid/play"]);
        check("/", &["/"], &["", "/a"]);
    }

    #[test]
    fn what_is_no_pattern() {
        for text in ["", "a", "/[a", "/{a,b", "/a]", "/a}", "/{a/b}", "/a/[b/c]"] {
            assert_eq!(Pattern::parse(text), None, "{text}");
        }
        let long = |n: usize| format!("/{}", "a".repeat(n));
        assert!(Pattern::parse(&long(LONGEST - 1)).is_some() && Pattern::parse(&long(LONGEST)).is_none());
    }

    /// By the definition, one character after the other, trying everything; only for short patterns.
    fn slow(pattern: &[char], text: &[char]) -> bool {
        match pattern {
            [] => text.is_empty(),
            ['*', rest @ ..] => (0..=text.len()).any(|n| slow(rest, &text[n..])),
            ['?', rest @ ..] => !text.is_empty() && slow(rest, &text[1..]),
            ['{', rest @ ..] => {
                let end = rest.iter().position(|c| *c == '}').unwrap();
                rest[..end]
                    .split(|c| *c == ',')
                    .any(|word| text.starts_with(word) && slow(&rest[end + 1..], &text[word.len()..]))
            }
            [c, rest @ ..] => text.first() == Some(c) && slow(rest, &text[1..]),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn all_ways_at_once_are_each_way_in_turn(
            pieces in prop::collection::vec(
                prop::sample::select(vec!["a", "b", "?", "*", "{a,bb}", "{,ab}", "{b}"]), 0..7),
            text in "[ab]{0,8}",
        ) {
            let pattern = pieces.concat();
            let wanted = slow(&pattern.chars().collect::<Vec<_>>(), &text.chars().collect::<Vec<_>>());
            let found = Pattern::parse(&format!("/{pattern}")).unwrap().matches(&format!("/{text}"), &mut 0);
            assert_eq!(found, wanted, "{pattern} {text}");
        }

        #[test]
        fn nothing_panics(pattern in any::<String>(), address in any::<String>(), odd in "/[\\[\\]{}!,*?a-c/-]{0,30}") {
            for text in [pattern, odd] {
                if let Some(pattern) = Pattern::parse(&text) {
                    pattern.matches(&address, &mut 0);
                    pattern.matches("/voice/abc/play", &mut 0);
                }
            }
        }
    }
}
