//! The colours of pictures: evenly spaced to the eye, told apart on white, on black and in a grey print.

/// What a mark is painted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Ink {
    /// The page.
    Page,
    /// Titles and names.
    Text,
    /// What stands back: units, silent rows.
    Dim,
    /// Grid lines.
    Grid,
    /// Base lines and frames.
    Axis,
    /// A region set off from the page.
    Shade,
    /// The limit of the band.
    Limit,
    /// The curve of the spectrum.
    Curve,
    /// What shakes on a map.
    Heat,
    /// The row or series `index` of `of`.
    Row {
        /// Counted from 0.
        index: usize,
        /// How many there are.
        of: usize,
    },
    /// A thing that is no more and no less than the others: hues all around, those next to each other far apart.
    Kind {
        /// Counted from 0; after six they come again.
        index: usize,
    },
}

/// Lightness on white, and hue (degrees), of things of a kind.
const KINDS: [(f64, f64); 6] =
    [(0.36, 295.0), (0.60, 50.0), (0.50, 250.0), (0.48, 20.0), (0.60, 150.0), (0.58, 200.0)];

impl Ink {
    /// A short name, unlike that of every other ink of the picture.
    pub fn class(self) -> String {
        match self {
            Self::Page => "p".into(),
            Self::Text => "t".into(),
            Self::Dim => "d".into(),
            Self::Grid => "g".into(),
            Self::Axis => "a".into(),
            Self::Shade => "h".into(),
            Self::Limit => "l".into(),
            Self::Curve => "c".into(),
            Self::Heat => "e".into(),
            Self::Row { index, .. } => index.to_string(),
            Self::Kind { index } => format!("k{index}"),
        }
    }

    /// The colour on white.
    pub fn light(self) -> String {
        match self {
            Self::Page => "#ffffff".into(),
            Self::Text => "#1b1f24".into(),
            Self::Dim => "#68707a".into(),
            Self::Grid => "#e7e9ec".into(),
            Self::Axis => "#b4bac1".into(),
            Self::Shade => "#f6f4f1".into(),
            Self::Limit => "#b3402e".into(),
            Self::Curve => hex(0.45, 0.125, hue(0.2)),
            Self::Heat => hex(0.55, 0.21, 30.0),
            Self::Row { index, of } => {
                let t = share(index, of);
                hex(0.40 + 0.25 * t, 0.125, hue(t))
            }
            Self::Kind { index } => {
                let (lightness, hue) = KINDS[index % KINDS.len()];
                hex(lightness, 0.15, hue)
            }
        }
    }

    /// The colour on black.
    pub fn dark(self) -> String {
        match self {
            Self::Page => "#0f1216".into(),
            Self::Text => "#e8ebee".into(),
            Self::Dim => "#949da7".into(),
            Self::Grid => "#22272e".into(),
            Self::Axis => "#505862".into(),
            Self::Shade => "#171614".into(),
            Self::Limit => "#f08a75".into(),
            Self::Curve => hex(0.70, 0.12, hue(0.2)),
            Self::Heat => hex(0.80, 0.16, 65.0),
            Self::Row { index, of } => {
                let t = share(index, of);
                hex(0.62 + 0.20 * t, 0.12, hue(t))
            }
            Self::Kind { index } => {
                let (lightness, hue) = KINDS[index % KINDS.len()];
                hex(lightness + 0.24, 0.13, hue)
            }
        }
    }
}

fn share(index: usize, of: usize) -> f64 {
    if of < 2 { 0.2 } else { index.min(of - 1) as f64 / (of - 1) as f64 }
}

/// From violet over blue and teal to green, in degrees: the way on which brightness can rise evenly.
fn hue(t: f64) -> f64 {
    295.0 - 160.0 * t
}

/// An OKLCH colour (Ottosson 2020: lightness 0 to 1, chroma, hue in degrees) as sRGB; chroma is lowered to what sRGB can show.
fn hex(lightness: f64, chroma: f64, hue: f64) -> String {
    let mut chroma = chroma;
    loop {
        let linear = linear(lightness, chroma, hue.to_radians());
        if linear.iter().all(|v| (-1e-4..=1.0001).contains(v)) || chroma < 1e-3 {
            let [r, g, b] = linear.map(|v| (gamma(v.clamp(0.0, 1.0)) * 255.0).round() as u8);
            return format!("#{r:02x}{g:02x}{b:02x}");
        }
        chroma *= 0.97;
    }
}

fn linear(lightness: f64, chroma: f64, hue: f64) -> [f64; 3] {
    let (a, b) = (chroma * hue.cos(), chroma * hue.sin());
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

fn gamma(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::{Ink, hex};

    /// Relative luminance of WCAG 2.1.
    fn luminance(hex: &str) -> f64 {
        let part = |at: usize| {
            let v = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn oklch_meets_known_colours() {
        // sRGB red and blue in OKLCH, from the definition's own tables.
        for (lch, rgb) in
            [((0.627_955, 0.257_683, 29.233_9), "#ff0000"), ((0.452_014, 0.313_214, 264.052), "#0000ff")]
        {
            assert_eq!(hex(lch.0, lch.1, lch.2), rgb);
        }
        assert_eq!(hex(1.0, 0.0, 0.0), "#ffffff");
    }

    #[test]
    fn rows_stand_out_from_the_page_and_grow_lighter_in_grey() {
        for of in [1, 2, 16, 64] {
            let rows: Vec<Ink> = (0..of).map(|index| Ink::Row { index, of }).collect();
            for row in &rows {
                assert!(contrast(&row.light(), &Ink::Page.light()) > 3.0, "{row:?}");
                assert!(contrast(&row.dark(), &Ink::Page.dark()) > 3.0, "{row:?}");
            }
            for pair in rows.windows(2) {
                assert!(luminance(&pair[0].light()) < luminance(&pair[1].light()), "{pair:?}");
            }
        }
        for kind in (0..6).map(|index| Ink::Kind { index }) {
            assert!(contrast(&kind.light(), &Ink::Page.light()) > 3.0, "{kind:?}");
            assert!(contrast(&kind.dark(), &Ink::Page.dark()) > 3.0, "{kind:?}");
        }
        assert!(contrast(&Ink::Dim.light(), &Ink::Page.light()) > 4.5, "small text");
        assert!(contrast(&Ink::Dim.dark(), &Ink::Page.dark()) > 4.5, "small text");
    }
}
