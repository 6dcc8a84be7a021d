//! The curves by which `felt` counts, for people: thresholds by site with their sources, and how strength grows.

use pacinian::perception::loudness::{EXPONENTS, as_strong};
use pacinian::perception::site::{SITES, Site};
use pacinian::perception::threshold::{CONTACTOR, MICRO, SUMMED, Threshold};

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
         average by some 5 to 10 dB, and the old by more (a judgement).\n\n",
        1e4 * CONTACTOR
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
            "| {word} | {corner} Hz | {rise:+} dB an octave | {pacinian:+} ±{pacinian_error} dB | {other:+.1} ±{other_error} dB | {source} |\n"
        );
    }
    let low = EXPONENTS[0].0;
    let strong = |felt: f64| as_strong(felt, 250.0, low).unwrap_or(felt);
    text += &format!(
        "\nOf hairy skin the threshold of the other channels is a judgement: they are taken to lose half as many dB as the Pacinian one.\n\n\
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
         - google/audio-to-tactile, perceptual measurements, <https://github.com/google/audio-to-tactile/tree/main/extras/doc/perceptual_measurements>: one person\n\
         - Stevens, S. S. (1968), Tactile vibration: change of exponent with frequency, Perception & Psychophysics 3, 223, <https://doi.org/10.3758/BF03212732> (abstract); his list of exponents as quoted in <https://en.wikipedia.org/wiki/Stevens%27s_power_law>\n\
         - Verrillo, R. T. (1970), Subjective magnitude functions for vibrotaction (abstract)\n",
        EXPONENTS[0].1,
        EXPONENTS[0].0,
        EXPONENTS[1].1,
        EXPONENTS[1].0,
        strong(20.0)
    );
    text
}
