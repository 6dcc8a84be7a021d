//! The curves by which `felt` counts, for people: thresholds by site with their sources, and how strength grows.

use pacinian::perception::loudness::{EXPONENTS, as_strong};
use pacinian::perception::site::{SITES, Site};
use pacinian::perception::summation::{ABOVE, CONSTANT, LEAST, WHOLE, least_loss, loss};
use pacinian::perception::threshold::{CONTACTOR, FAR, MICRO, QUOTED, RANGE, SUMMED, Threshold};

/// Frequencies that are told, Hz.
const TOLD: [f64; 10] = [10.0, 25.0, 40.0, 63.0, 100.0, 160.0, 250.0, 400.0, 630.0, 1000.0];

/// What every row tells of a site: its word, and the threshold with its error at each of [`TOLD`].
fn row(site: &'static Site) -> Vec<String> {
    let threshold = Threshold::new(site, CONTACTOR);
    let at =
        |hertz: &f64| format!("{:+.0} ±{:.0}", threshold.metres(*hertz) - MICRO, threshold.error(*hertz));
    std::iter::once(site.word.to_string()).chain(TOLD.iter().map(at)).collect()
}

fn head() -> Vec<String> {
    std::iter::once("Hz".to_string()).chain(TOLD.iter().map(|hertz| format!("{hertz:.0}"))).collect()
}

/// As lines for a terminal.
pub fn text() -> String {
    let mut table = super::table::Table::default();
    table.row(head());
    SITES.iter().for_each(|site| table.row(row(site)));
    table.text()
}

/// Durations that are told, s.
const DURATIONS: [f64; 7] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];

/// What short tones lose, as a table of a page.
fn short() -> String {
    let row = |name: &str, of: fn(f64, f64) -> f64| {
        let cells = DURATIONS.map(|seconds| format!("{:.1}", of(seconds, 250.0)));
        format!("| {name} | {} |\n", cells.join(" | "))
    };
    let head = DURATIONS.map(|seconds| seconds.to_string()).join(" | ");
    let line = "---|".repeat(DURATIONS.len() + 1);
    format!("| s | {head} |\n|{line}\n{}{}", row("at most, dB", loss), row("at least, dB", least_loss))
}

/// As a page.
pub fn markdown() -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = String::from(
        "# How strongly something is felt\n\n<!-- Made by `pacinian format --markdown felt`; a test keeps it in step. -->\n\n\
         `felt = 20` is 20 dB above the threshold: see [felt](patch.md#felt) of a patch and [calibration](rig.md#calibration) of a rig. These are the \
         thresholds by which it counts. Most papers could be read as abstracts only; where a figure is a judgement, its source says so.\n\n\
         ## Thresholds\n\n",
    );
    text += &format!(
        "Displacement (peak), dB above 1 µm, under a contactor of {:.1} cm², for an average of adults; ± is by how much that may be off. One person differs from the \
         average by some 5 to 10 dB, and the old by more (a judgement). They are given from {} to {} Hz. Slopes are quoted up to {QUOTED} Hz; above, \
         those of the hand are a judgement, and from {FAR} Hz on all only go on, as no threshold above that was at hand: there ± is wider.\n\n",
        1e4 * CONTACTOR,
        RANGE[0],
        RANGE[1]
    );
    text += &line(head());
    text += &format!("|{}\n", "---|".repeat(TOLD.len() + 1));
    SITES.iter().for_each(|site| text += &line(row(site)));
    text += &format!(
        "\nTwo channels feel, and the more sensitive one decides: T(f) = min(P(f), N). The Pacinian one, P, falls by 12 dB an octave up to its corner and rises above it; it \
         sums over the skin: with each doubling of the contactor from {} to {} cm² its threshold falls by 3 dB (Verrillo 1963, 1966). Smaller and larger ones are \
         taken for these, ±3 dB more. The others, N, are flat, and do not sum.\n\n",
        1e4 * SUMMED[0],
        1e4 * SUMMED[1]
    );
    text += "| site | corner | above it | Pacinian there | others | from |\n|---|---|---|---|---|---|\n";
    for site in &SITES {
        let Site { word, corner, rise, pacinian, pacinian_error, other, other_error, source } = site;
        text += &format!(
            "| {word} | {corner} Hz | {rise:+} dB an octave | {pacinian:+.1} ±{pacinian_error} dB | {other:+.1} ±{other_error} dB | {source} |\n"
        );
    }
    let low = EXPONENTS[0].0;
    let strong = |felt: f64| as_strong(felt, 250.0, low).unwrap_or(felt);
    text += &format!(
        "\nOf hairy skin the threshold of the other channels is a judgement: they are taken to lose half as many dB as the Pacinian one. \
         The Pacinian one is set so that the mean from 100 to 300 Hz, over the logarithm of the frequency, is as far above the fingertip as was measured. \
         Verrillo (1966) gives −12 and +9 dB an octave on the forearm, and says that both confirm data on glabrous skin, of which the rise above 250 Hz is taken \
         here as +12: by +9 thresholds of the hand would be 3 dB lower at 500 Hz and 6 dB at 1000 Hz.\n\n\
         ## Short tones\n\n\
         Thresholds hold for tones of about {WHOLE} s. The Pacinian channel, which decides above some {ABOVE} Hz, sums over time: what is shorter is felt weaker. The \
         others do not sum: at 40 Hz 0.1 s are felt like 1 s (Gescheider, 1976: at high frequencies and not at low ones, at the threshold and above it). `felt` makes \
         nothing of that: 20 dB for 0.1 s are the amplitude of 20 dB for 1 s, and are felt like 10 to 16 dB.\n\n\
         {}\
         \nAt most is the rule of 3 dB for each halving, 10 log10(1 s / duration): a judgement. At least is an exponential of time constant {CONSTANT} s, after Zwislocki's theory \
         (1960), which Gescheider and others (1994) found to predict thresholds at 250 and 500 Hz; the theory was not at hand, and its constant is a judgement, too. What is \
         true lies from one to the other, as far as one knows. From 100 to 750 Hz it does not depend on the frequency (Boğaziçi). Durations of less than \
         {LEAST} s are taken for that.\n\n\
         ## Strength\n\n\
         Above the threshold the sensation grows as a power of the amplitude, and so curves of equal strength are L(f) = T(f) + S / β(f). Stevens lists β \
         as {} at {} Hz and {} at {} Hz on the finger (in 1968 he found about 1 at 60 Hz, and near 250 Hz half of the largest, which is near 30 Hz); Verrillo (1970) found 0.89 for all frequencies up to 350 Hz. By the first, 20 dB at 250 Hz are as strong as {:.1} dB at \
         {low} Hz, by the other as 20 dB. As long as these differ by more than the effect, `felt` counts dB above the threshold, and leaves strength alone.\n\n\
         ## Sources\n\n\
         - Verrillo, R. T. (1963), Effect of contactor area on the vibrotactile threshold, J. Acoust. Soc. Am. 35, 1962; as quoted in Gescheider and Verrillo, \
         <https://rd.springer.com/chapter/10.1007/978-1-4613-3039-4_10>\n\
         - Verrillo, R. T. (1966), Vibrotactile thresholds for hairy skin, J. Exp. Psychol. 72, 47 (abstract)\n\
         - Morioka, M., Whitehouse, D. J. and Griffin, M. J. (2008), Vibrotactile thresholds at the fingertip, volar forearm, large toe, and heel, \
         <https://eprints.soton.ac.uk/58637> (abstract)\n\
         - Gescheider, G. A. (1976), Evidence in support of the duplex theory of mechanoreception, Sensory Processes 1, 68, \
         <https://scilit.com/publications/9d46da30a9848a29033f023fafe80e55> (abstract)\n\
         - Gescheider, G. A. and others (1994), The effects of masking on vibrotactile temporal summation in the detection of sinusoidal and noise signals, J. Acoust. Soc. Am. 95, 1006 (abstract)\n\
         - Boğaziçi University, a thesis on temporal summation in the Pacinian channel, 10 subjects, 10 to 1000 ms at 100 to 750 Hz, <http://digitalarchive.boun.edu.tr/handle/123456789/18892> (abstract)\n\
         - google/audio-to-tactile, perceptual measurements, <https://github.com/google/audio-to-tactile/tree/main/extras/doc/perceptual_measurements>: one person\n\
         - Stevens, S. S. (1968), Tactile vibration: change of exponent with frequency, Perception & Psychophysics 3, 223, <https://doi.org/10.3758/BF03212732> (abstract); his list of exponents as quoted in <https://en.wikipedia.org/wiki/Stevens%27s_power_law>\n\
         - Verrillo, R. T. (1970), Subjective magnitude functions for vibrotaction (abstract)\n",
        short(),
        EXPONENTS[0].1,
        EXPONENTS[0].0,
        EXPONENTS[1].1,
        EXPONENTS[1].0,
        strong(20.0)
    );
    text
}
