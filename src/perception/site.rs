//! Sites of the body, and what is known of the threshold there.

/// A site of the body.
///
/// Two channels feel there, and the more sensitive one decides: the Pacinian one, of which the threshold falls by 12 dB an octave up to a
/// corner and rises above it, and the others together, of which the threshold does not depend on the frequency.
#[derive(Debug, PartialEq)]
pub struct Site {
    /// The word for it in a rig.
    pub word: &'static str,
    /// Where the Pacinian channel is most sensitive, Hz.
    pub corner: f64,
    /// By how much its threshold rises above that, dB an octave.
    pub rise: f64,
    /// Its threshold at the corner under [`CONTACTOR`](super::threshold::CONTACTOR), dB above 1 µm.
    pub pacinian: f64,
    /// By how much that may be off, dB either way, for an average of adults. Above 250 Hz it is more: see [`Threshold::error`].
    ///
    /// [`Threshold::error`]: super::threshold::Threshold::error
    pub pacinian_error: f64,
    /// The threshold of the others, dB above 1 µm.
    pub other: f64,
    /// By how much that may be off, dB either way.
    pub other_error: f64,
    /// Where the figures are from.
    pub source: &'static str,
}

/// The site of which most is known; those of which nothing is said are taken for it.
pub const THENAR: &Site = &SITES[0];

/// Of the glabrous skin of the hand: flat up to 40 Hz, then 12 dB an octave down to 250 Hz. That it rises as fast above is a judgement: what is quoted of
/// Verrillo 1963 ends there, and his of 1966 has 9 on the forearm.
const fn glabrous(word: &'static str, error: f64, source: &'static str) -> Site {
    Site {
        word,
        corner: 250.0,
        rise: 12.0,
        pacinian: -20.0,
        pacinian_error: error,
        // What the slope has come to at 40 Hz: -20 + 40 log10(250 / 40).
        other: 11.8,
        other_error: error,
        source,
    }
}

/// By how much the difference from the fingertip at the corner of hairy skin is above its mean from 100 to 300 Hz, evenly over the logarithm of the frequency,
/// dB: as corners and slopes are unlike. Evenly over the frequency the mean is 0.4 dB larger.
const CORNER: f64 = 1.4;

/// Of hairy skin, so many decibels less sensitive than the fingertip, as a mean of 100 to 300 Hz. The slopes are those of the forearm.
const fn hairy(word: &'static str, less: f64, error: f64, source: &'static str) -> Site {
    Site {
        word,
        corner: 220.0,
        rise: 9.0,
        pacinian: -20.0 + less + CORNER,
        pacinian_error: error,
        // Half of what the Pacinian channel loses: a judgement.
        other: 11.8 + 0.5 * less,
        other_error: 10.0,
        source,
    }
}

/// All.
pub static SITES: [Site; 8] = [
    glabrous(
        "thenar",
        5.0,
        "Shape: Verrillo 1963, as Gescheider and Verrillo quote it (contactors of 2.9 cm2 and more: flat up to 40 Hz, then -12 dB an octave to 250 Hz). +12 dB above 250 Hz: a judgement. -20 dB re 1 um at 250 Hz is what is usually quoted: a judgement",
    ),
    glabrous(
        "fingertip",
        6.0,
        "Taken for the thenar: a judgement. Morioka, Whitehouse and Griffin 2008 found it more sensitive than forearm, toe and heel at all of 8 to 250 Hz",
    ),
    glabrous("palm", 6.0, "Taken for the thenar: a judgement"),
    hairy(
        "wrist",
        27.0,
        10.0,
        "24 and 30 dB above the index finger on its two sides, mean of 100 to 300 Hz: one person, one exciter (google/audio-to-tactile). Slopes of the forearm",
    ),
    hairy(
        "forearm",
        30.5,
        10.0,
        "Slopes: Verrillo 1966 (-12 dB an octave, +9 above 220 Hz). 29 and 32 dB above the index finger, mean of 100 to 300 Hz: one person, one exciter (google/audio-to-tactile)",
    ),
    hairy(
        "shoulder",
        34.0,
        10.0,
        "34 dB above the index finger, mean of 100 to 300 Hz: one person, one exciter (google/audio-to-tactile). Slopes of the forearm",
    ),
    hairy(
        "torso",
        35.0,
        12.0,
        "Taken to be a little less sensitive than the shoulder: a judgement. Slopes of the forearm",
    ),
    hairy(
        "ankle",
        29.0,
        10.0,
        "29 dB above the index finger, mean of 100 to 300 Hz: one person, one exciter (google/audio-to-tactile). Slopes of the forearm",
    ),
];

/// Their words.
pub const WORDS: &[&str] = &["thenar", "fingertip", "palm", "wrist", "forearm", "shoulder", "torso", "ankle"];

/// The site of a word.
#[cfg(test)]
pub(crate) fn find(word: &str) -> Option<&'static Site> {
    SITES.iter().find(|site| site.word == word)
}

#[cfg(test)]
mod tests {
    use super::{SITES, Site, THENAR, WORDS, find};
    use crate::patch::reference::TOPICS;
    use crate::perception::threshold::{CONTACTOR, Threshold};

    #[test]
    fn every_word_is_a_site_and_says_where_its_figures_are_from() {
        assert_eq!(SITES.iter().map(|site| site.word).collect::<Vec<_>>(), WORDS);
        assert_eq!((find("thenar"), find("nose")), (Some(THENAR), None));
        for site in &SITES {
            let told = site.source.contains("judgement")
                || site.source.contains("19")
                || site.source.contains("person");
            assert!(told && site.pacinian_error >= 5.0 && site.other_error >= 5.0, "{site:?}");
        }
    }

    /// What was measured of hairy skin is a mean of 100 to 300 Hz of how much less sensitive it is than the fingertip; of two sides, their mean.
    #[test]
    fn hairy_sites_have_the_mean_that_was_measured() {
        let finger = Threshold::new(find("fingertip").unwrap(), CONTACTOR);
        for (word, due) in [
            ("wrist", (24.0 + 30.0) / 2.0),
            ("forearm", (29.0 + 32.0) / 2.0),
            ("shoulder", 34.0),
            ("ankle", 29.0),
        ] {
            let site = Threshold::new(find(word).unwrap(), CONTACTOR);
            let less = |n: i32| {
                let hertz = 100.0 * 3f64.powf(f64::from(n) / 1000.0);
                site.metres(hertz) - finger.metres(hertz)
            };
            let mean = (0..1000).map(less).sum::<f64>() / 1000.0;
            assert!((mean - due).abs() < 0.1, "{word}: {mean}");
        }
    }

    /// What the reference says of how well thresholds are known is what stands here.
    #[test]
    fn the_reference_tells_the_largest_errors() {
        // The largest that is told of any frequency up to 250 Hz.
        let error = |site: &'static Site| {
            let at = |n: i32| Threshold::new(site, CONTACTOR).error(10.0 * 25f64.powf(f64::from(n) / 100.0));
            (0..=100).map(at).fold(0.0, f64::max)
        };
        let most =
            |of: &dyn Fn(&Site) -> bool| SITES.iter().filter(|site| of(site)).map(error).fold(0.0, f64::max);
        let hand = |site: &Site| ["thenar", "fingertip", "palm"].contains(&site.word);
        let said = format!(
            "up to 250 Hz within {} dB on the hand and {} dB elsewhere",
            most(&hand),
            most(&|site| !hand(site))
        );
        let felt = TOPICS.iter().find(|topic| topic.name == "felt").unwrap();
        assert!(felt.text.contains(&said), "{said}");
        let far = Threshold::new(THENAR, CONTACTOR);
        let wider = format!("{:.0} dB more at 1000 Hz", far.error(1000.0) - far.error(250.0));
        let odd = Threshold::new(THENAR, 1.0);
        let contactor = format!("{:.0} dB more under a contactor", odd.error(250.0) - far.error(250.0));
        assert!(felt.text.contains(&wider) && felt.text.contains(&contactor), "{wider}, {contactor}");
    }
}
