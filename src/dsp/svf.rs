//! State-variable filter with trapezoidal integrators.
//!
//! Zavalishin: "The Art of VA Filter Design" (2012), 4.2; the form solved for its states is Simper's (Cytomic, 2013). With
//! g = tan(π cutoff / rate) and k = 1/q it is the bilinear image of the analog filter, right at the cutoff, and stays stable
//! however cutoff and q move. All of it is in `f64`: in `f32` a cutoff of 5 Hz would leave a rounding error of −90 dB.

use super::lanes::{LANES, Real};

/// The least cutoff, Hz.
pub const LEAST_CUTOFF: f64 = 1.0;
/// The highest cutoff as a share of the rate.
pub const MOST_CUTOFF: f64 = 0.45;
/// The range of q.
pub const Q: (f64, f64) = (0.1, 1000.0);
/// Inputs beyond this, and what is not a number, count as 0.
const MOST_INPUT: f64 = 1e9;
/// Below this a state is nothing: −140 dB.
const NOTHING: f64 = 1e-7;

/// 1 / (2k − 1) 2k and 1 / 2k (2k + 1): from each term of the series to the next.
const COSINE: [f64; 9] = terms(0.0);
const SINE: [f64; 9] = terms(1.0);

const fn terms(shift: f64) -> [f64; 9] {
    let (mut all, mut k) = ([0.0; 9], 1);
    while k < 9 {
        let last = 2.0 * k as f64 + shift;
        all[k] = 1.0 / (last * (last - 1.0));
        k += 1;
    }
    all
}

/// Eight filters.
#[derive(Debug, Clone)]
pub struct Filters {
    rate: f64,
    half_turn: f64,
    one: [f64; LANES],
    two: [f64; LANES],
    damping: [f64; LANES],
    a: [[f64; LANES]; 3],
}

/// What comes out of eight filters at a sample.
#[derive(Debug, Clone, Copy)]
pub struct Outputs {
    /// Low-pass, gain 1 at 0 Hz.
    pub low: [f64; LANES],
    /// Band-pass, gain 1 at the cutoff.
    pub band: [f64; LANES],
    /// What went in.
    pub input: [f64; LANES],
}

impl Filters {
    /// Silent filters at `rate` samples a second.
    pub fn new(rate: f64) -> Self {
        let zero = [0.0; LANES];
        let mut new = Self {
            rate,
            half_turn: std::f64::consts::FRAC_PI_2 / rate,
            one: zero,
            two: zero,
            damping: zero,
            a: [zero; 3],
        };
        new.tune(&[1000.0; LANES], &[1.0; LANES]);
        new
    }

    /// Empties a lane and tunes it.
    pub fn start(&mut self, lane: usize, cutoff: f64, q: f64) {
        self.one[lane] = 0.0;
        self.two[lane] = 0.0;
        self.retune(lane, cutoff, q);
    }

    /// Tunes a lane, which keeps what is in it.
    pub fn retune(&mut self, lane: usize, cutoff: f64, q: f64) {
        let (damping, a) = self.solve(&[cutoff; LANES], &[q; LANES]);
        self.damping[lane] = damping[lane];
        for (row, new) in self.a.iter_mut().zip(&a) {
            row[lane] = new[lane];
        }
    }

    /// Tunes all lanes, each cutoff limited to 1 Hz to 0.45 of the rate and each q to 0.1 to 1000.
    #[inline(always)]
    pub fn tune(&mut self, cutoff: &[f64; LANES], q: &[f64; LANES]) {
        (self.damping, self.a) = self.solve(cutoff, q);
    }

    #[inline(always)]
    fn solve(&self, cutoff: &[f64; LANES], q: &[f64; LANES]) -> ([f64; LANES], [[f64; LANES]; 3]) {
        // tan 2x = 2 sin x cos x / (cos² x − sin² x) = n / d, x within π/4: two short Taylor series and one division for all.
        let (most, half_turn) = (MOST_CUTOFF * self.rate, self.half_turn);
        let (mut x, mut z) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            x[l] = within(cutoff[l], LEAST_CUTOFF, most) * half_turn;
            z[l] = x[l] * x[l];
        }
        let (mut sine, mut cosine) = ([1.0; LANES], [1.0; LANES]);
        for k in (1..=8).rev() {
            for l in 0..LANES {
                cosine[l] = 1.0 - cosine[l] * z[l] * COSINE[k];
                sine[l] = 1.0 - sine[l] * z[l] * SINE[k];
            }
        }
        let (mut damping, mut a) = ([0.0; LANES], [[0.0; LANES]; 3]);
        for l in 0..LANES {
            let (q, s, c) = (within(q[l], Q.0, Q.1), sine[l] * x[l], cosine[l]);
            let (n, d) = (2.0 * s * c, (c - s) * (c + s));
            let scale = q / (q * (d * d + n * n) + n * d);
            damping[l] = 1.0 / q;
            a[0][l] = d * d * scale;
            a[1][l] = n * d * scale;
            a[2][l] = n * n * scale;
        }
        (damping, a)
    }

    /// The next sample of all lanes.
    #[inline(always)]
    pub fn step<R: Real>(&mut self, input: &[R; LANES]) -> Outputs {
        let mut out = Outputs { low: [0.0; LANES], band: [0.0; LANES], input: [0.0; LANES] };
        for l in 0..LANES {
            let x = input[l].wide();
            let x = if x.abs() < MOST_INPUT { x } else { 0.0 };
            let drive = x - self.two[l];
            let v1 = self.a[0][l] * self.one[l] + self.a[1][l] * drive;
            let v2 = self.two[l] + self.a[1][l] * self.one[l] + self.a[2][l] * drive;
            self.one[l] = v1 + v1 - self.one[l];
            self.two[l] = v2 + v2 - self.two[l];
            out.low[l] = v2;
            out.band[l] = self.damping[l] * v1;
            out.input[l] = x;
        }
        out
    }

    /// Lanes whose state is below −140 dB become silent.
    pub fn settle(&mut self) {
        for l in 0..LANES {
            if self.one[l].abs() < NOTHING && self.two[l].abs() < NOTHING {
                self.one[l] = 0.0;
                self.two[l] = 0.0;
            }
        }
    }
}

#[inline(always)]
fn within(value: f64, least: f64, most: f64) -> f64 {
    // What is not a number becomes the least.
    let value = if value > least { value } else { least };
    if value < most { value } else { most }
}

/// One filter for the twins.
#[derive(Debug, Clone, Default)]
pub struct Single {
    states: [f64; 2],
}

impl Single {
    /// Low-pass and band-pass (gain 1 at the cutoff) of the next sample: both integrators by the trapezoidal rule, as
    /// dv1/dt = ω (x − k v1 − v2), dv2/dt = ω v1.
    pub fn step(&mut self, x: f64, cutoff: f64, q: f64, rate: f64) -> (f64, f64) {
        let g = (std::f64::consts::PI * cutoff.clamp(LEAST_CUTOFF, MOST_CUTOFF * rate) / rate).tan();
        let k = 1.0 / q.clamp(Q.0, Q.1);
        let [s1, s2] = self.states;
        let high = (x - (g + k) * s1 - s2) / (1.0 + g * k + g * g);
        let band = g * high + s1;
        let low = g * band + s2;
        self.states = [g * high + band, g * band + low];
        (low, k * band)
    }
}

#[cfg(test)]
mod tests {
    use super::{Filters, LANES};

    /// The bilinear image of 1 / (1 + s/qω + s²/ω²), measured on a sine.
    #[test]
    fn the_response_is_the_bilinear_image() {
        let rate = 8000.0;
        for (cutoff, q, hertz) in
            [(5.0, 0.7, 20.0), (100.0, 0.7, 100.0), (250.0, 20.0, 255.0), (3600.0, 2.0, 900.0)]
        {
            let mut filters = Filters::new(rate);
            filters.start(2, cutoff, q);
            let turn = std::f64::consts::TAU * hertz / rate;
            let (mut re, mut im) = (0.0, 0.0);
            let count = 80_000;
            for n in 0..2 * count {
                let mut row = [0.0; LANES];
                row[2] = (turn * f64::from(n)).cos();
                let low = filters.step(&row).low[2];
                if n >= count {
                    re += low * (turn * f64::from(n)).cos();
                    im -= low * (turn * f64::from(n)).sin();
                }
            }
            let measured = re.hypot(im) * 2.0 / f64::from(count);
            let ratio = (turn / 2.0).tan() / (std::f64::consts::PI * cutoff / rate).tan();
            let exact = 1.0 / (1.0 - ratio * ratio).hypot(ratio / q);
            assert!((measured / exact - 1.0).abs() < 1e-3, "{cutoff} Hz: {measured} {exact}");
        }
    }

    #[test]
    fn wild_modulation_stays_bounded() {
        let mut filters = Filters::new(8000.0);
        let mut most = 0.0_f64;
        for n in 0..100_000_u32 {
            let wild = crate::dsp::random::uniform(1, u64::from(n));
            let cutoff = [0.0, 4000.0, 1e9, f64::NAN, -5.0, f64::INFINITY, 300.0 * wild, 4000.0 * wild];
            let q = [1e9, 1000.0, 0.0, f64::NAN, -1.0, 1000.0 * wild, 1000.0, 1000.0];
            filters.tune(&cutoff, &q);
            let x = crate::dsp::random::uniform(2, u64::from(n));
            let out = filters.step(&[x, x, x, x, x, f64::NAN, x, x]);
            for l in 0..LANES {
                most = most.max(out.low[l].abs()).max(out.band[l].abs());
                assert!(out.low[l].is_finite() && out.band[l].is_finite(), "lane {l}");
            }
        }
        assert!(most < 1000.0, "{most}");
    }

    #[test]
    fn a_tail_becomes_exact_zero() {
        let mut filters = Filters::new(8000.0);
        for l in 0..LANES {
            filters.start(l, 50.0, 5.0);
        }
        filters.step(&[1.0; LANES]);
        for n in 0..100_000 {
            filters.step(&[0.0; LANES]);
            if n % 64 == 0 {
                filters.settle();
            }
        }
        assert_eq!(filters.step(&[0.0; LANES]).low, [0.0; LANES]);
    }
}
