//! Other words that people know nodes by.

use super::REGISTRY;
use crate::text::nearest::nearest;

/// The word, and the nodes that it may mean, the likeliest first.
const WORDS: &[(&str, &[&str])] = &[
    ("adsr", &["envelope"]),
    ("ar", &["envelope"]),
    ("asr", &["envelope"]),
    ("env", &["envelope"]),
    ("eg", &["envelope"]),
    ("ramp", &["breakpoints", "sweep"]),
    ("line", &["breakpoints", "sweep"]),
    ("saw", &["sawtooth"]),
    ("square", &["pulse"]),
    ("rectangle", &["pulse"]),
    ("pwm", &["pulse"]),
    ("tri", &["triangle"]),
    ("chirp", &["sweep"]),
    ("osc", &["sine", "triangle", "sawtooth", "pulse"]),
    ("oscillator", &["sine", "triangle", "sawtooth", "pulse"]),
    ("cos", &["sine"]),
    ("cosine", &["sine"]),
    ("tone", &["sine"]),
    ("noise", &["white", "pink", "band_noise"]),
    ("random", &["white", "lfo"]),
    ("rand", &["white", "lfo"]),
    ("vibrato", &["lfo"]),
    ("tremolo", &["lfo"]),
    ("mul", &["multiply"]),
    ("times", &["multiply"]),
    ("product", &["multiply"]),
    ("gain", &["multiply"]),
    ("amp", &["multiply"]),
    ("vca", &["multiply"]),
    ("volume", &["multiply"]),
    ("sum", &["add", "mix"]),
    ("plus", &["add"]),
    ("mixer", &["mix", "add"]),
    ("lpf", &["lowpass"]),
    ("lp", &["lowpass"]),
    ("hpf", &["highpass"]),
    ("hp", &["highpass"]),
    ("bpf", &["bandpass"]),
    ("bp", &["bandpass"]),
    ("filter", &["lowpass", "highpass", "bandpass"]),
    ("vcf", &["lowpass", "highpass", "bandpass"]),
    ("bandstop", &["notch"]),
    ("echo", &["delay"]),
    ("wav", &["sample"]),
    ("file", &["sample", "scan"]),
    ("recording", &["sample", "scan"]),
    ("map", &["scale"]),
    ("fade", &["crossfade"]),
    ("mic", &["input"]),
    ("microphone", &["input"]),
];

/// Words for a number that stands still, which needs no node.
const CONSTANTS: &[&str] = &["const", "constant", "number", "value"];

/// What to do about a node type that there is not.
pub fn advice(word: &str) -> String {
    let plain = word.to_lowercase().replace('-', "_");
    if CONSTANTS.contains(&plain.as_str()) {
        return "a number needs no node: write it where a node's name may stand".into();
    }
    // Those of a feature may be missing.
    let there = |name: &&&str| REGISTRY.iter().any(|spec| spec.name == **name);
    let meant =
        WORDS.iter().filter(|(said, _)| *said == plain).flat_map(|(_, meant)| meant.iter().filter(there));
    let mut meant: Vec<&str> = meant.copied().collect();
    if meant.is_empty() {
        meant.extend(nearest(word, REGISTRY.iter().map(|spec| spec.name)));
    }
    let quoted: Vec<String> = meant.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => "`pacinian nodes` lists all".into(),
        Some((last, [])) => format!("did you mean {last}?"),
        Some((last, rest)) => format!("did you mean {} or {last}?", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::{REGISTRY, WORDS, advice};

    #[test]
    fn words_of_other_programs_are_known() {
        for (word, told) in [
            ("adsr", "did you mean `envelope`?"),
            ("SAW", "did you mean `sawtooth`?"),
            ("sum", "did you mean `add` or `mix`?"),
            ("noise", "did you mean `white`, `pink` or `band_noise`?"),
            ("sinus", "did you mean `sine`?"),
            ("qqqqqq", "`pacinian nodes` lists all"),
        ] {
            assert_eq!(advice(word), told, "{word}");
        }
        assert!(advice("const").contains("needs no node"));
    }

    /// No word leads to a node that there is not, or away from one that there is.
    #[test]
    fn every_word_leads_somewhere() {
        let known = |name: &str| REGISTRY.iter().any(|spec| spec.name == name);
        for (word, meant) in WORDS {
            assert!(!known(word) && meant.iter().all(|name| known(name)), "{word}: {meant:?}");
        }
    }
}
