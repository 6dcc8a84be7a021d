//! The name that was probably meant.

/// Advice that names the candidate nearest to `word`, or lists them where they are few; `None` where there is nothing to say.
pub fn suggest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut candidates: Vec<&str> = candidates.into_iter().take(MOST_CANDIDATES + 1).collect();
    if candidates.len() > MOST_CANDIDATES {
        return None;
    }
    if let Some(name) = nearest(word, candidates.iter().copied()) {
        return Some(format!("did you mean `{name}`?"));
    }
    candidates.sort_unstable();
    candidates.dedup();
    match candidates.len() {
        0 => None,
        1 => Some(format!("there is only `{}`", candidates[0])),
        2..=12 => Some(format!("there are {}", listed(&candidates))),
        _ => None,
    }
}

/// Advice that names the candidate nearest to `word`, where one is near and they are not too many.
pub(crate) fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let candidates: Vec<&str> = candidates.into_iter().take(MOST_CANDIDATES + 1).collect();
    let few = candidates.len() <= MOST_CANDIDATES;
    nearest(word, candidates.into_iter().filter(|_| few)).map(|name| format!("did you mean `{name}`?"))
}

/// The candidate nearest to `word`: at most two edits away, or a third of its length; the first by name among equals.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let folded = fold(word);
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let plain: String = folded.iter().collect();
    let other_words = SYNONYMS.iter().filter(|(said, _)| *said == plain).flat_map(|(_, meant)| *meant);
    for meant in other_words {
        if let Some(candidate) = candidates.iter().find(|c| *c == meant) {
            return Some(candidate);
        }
    }
    let most = (folded.len() / 3).max(2).min(folded.len().saturating_sub(1)).max(1);
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates {
        if candidate.len() > MOST || folded.len() > MOST || candidate.is_empty() {
            continue;
        }
        let far = distance(&folded, &fold(candidate), most);
        if far <= most && best.is_none_or(|b| (far, candidate) < b) {
            best = Some((far, candidate));
        }
    }
    best.map(|(_, name)| name)
}

/// Other words that people use, and which key they may mean; the first that there is.
const SYNONYMS: &[(&str, &[&str])] = &[
    ("volume", &["level", "gain", "amplitude"]),
    ("amplitude", &["level", "gain"]),
    ("amp", &["level", "gain", "amplitude"]),
    ("intensity", &["level", "gain", "amplitude"]),
    ("strength", &["level", "gain", "amplitude"]),
    ("loudness", &["level", "gain", "amplitude"]),
    ("level", &["gain", "amplitude"]),
    ("gain", &["level", "amplitude"]),
    ("frequency", &["rate", "cutoff"]),
    ("cutoff", &["frequency"]),
    ("corner", &["cutoff", "frequency"]),
    ("freq", &["frequency", "rate", "cutoff"]),
    ("hz", &["frequency", "rate"]),
    ("pitch", &["frequency"]),
    ("rate", &["frequency", "speed"]),
    ("speed", &["rate"]),
    ("count", &["times", "voices", "channels"]),
    ("number", &["times", "channel"]),
    ("interval", &["every"]),
    ("period", &["every"]),
    ("bpm", &["tempo"]),
    ("path", &["file"]),
    ("wav", &["file"]),
    ("length", &["duration"]),
    ("dur", &["duration"]),
    ("time", &["at", "duration"]),
    ("start", &["at"]),
    ("when", &["at"]),
    ("onset", &["at"]),
    ("tactor", &["place"]),
    ("location", &["place", "position"]),
    ("position", &["place"]),
    ("channel", &["place"]),
    ("input", &["inputs"]),
    ("curve", &["shape"]),
    ("type", &["kind", "model"]),
    ("name", &["title"]),
];

/// "`a`, `b` and `c`".
pub(crate) fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        Some((last, _)) => last.clone(),
        None => String::new(),
    }
}

/// Names longer than this have no neighbours.
const MOST: usize = 64;

/// Among more names than this nobody looks: many wrong names among many would take for ever.
const MOST_CANDIDATES: usize = 5_000;

/// Case and the two dashes make no difference.
fn fold(word: &str) -> Vec<char> {
    word.chars().take(MOST + 1).flat_map(char::to_lowercase).map(|c| if c == '-' { '_' } else { c }).collect()
}

/// Edits (insert, delete, replace, swap neighbours) from `a` to `b`, as long as they are at most `most`: the distance of
/// Damerau in the form of optimal string alignment.
fn distance(a: &[char], b: &[char], most: usize) -> usize {
    if a.len().abs_diff(b.len()) > most {
        return most + 1;
    }
    let mut before: Vec<usize> = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::{listed, nearest, suggest};

    #[test]
    fn finds_what_was_meant() {
        let names = ["frequency", "phase", "amplitude"];
        for (word, name) in [
            ("frequncy", "frequency"),
            ("Frequency", "frequency"),
            ("pahse", "phase"),
            ("amp-litude", "amplitude"),
        ] {
            assert_eq!(nearest(word, names), Some(name), "{word}");
        }
        assert_eq!(nearest("colour", names), None);
        assert_eq!(nearest("x", ["y"]), Some("y"), "one edit is always near");
        assert_eq!(nearest("xz", ["ab"]), None, "nothing in common");
        assert_eq!(nearest("", ["ab"]), None);
        assert_eq!(nearest(&"a".repeat(1 << 20), ["ab"]), None);
    }

    #[test]
    fn other_words_for_a_key_are_known() {
        for (word, names, meant) in [
            ("volume", &["at", "level", "place"][..], "level"),
            ("Amplitude", &["at", "level"], "level"),
            ("frequency", &["rate", "low", "high"], "rate"),
            ("count", &["every", "times"], "times"),
            ("path", &["file", "speed"], "file"),
            ("curve", &["at", "value", "shape"], "shape"),
            ("times", &["time", "tempo"], "time"),
        ] {
            assert_eq!(nearest(word, names.iter().copied()), Some(meant), "{word}");
        }
        assert_eq!(nearest("volume", ["x"]), None);
    }

    #[test]
    fn lists_when_nothing_is_near() {
        assert_eq!(
            suggest("q", ["linear", "exponential"]).as_deref(),
            Some("there are `exponential` and `linear`")
        );
        assert_eq!(suggest("q", ["linear"]).as_deref(), Some("there is only `linear`"));
        assert_eq!(suggest("q", []), None);
        assert_eq!(listed(&["a", "b", "c"]), "`a`, `b` and `c`");
    }
}
