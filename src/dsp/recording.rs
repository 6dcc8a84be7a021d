//! A recording as it is played at any speed: copies with ever lower bands, between which the speed cross-fades.
//!
//! A recording has twice the engine's rate and content up to half the engine's rate. Copy n holds the content up to 1/2^n of that. Up to
//! speed 1 copy 0 is heard; from 2^n to 1.75 × 2^n it fades from copy n to n + 1, so that what is heard never reaches 7/4 of half the
//! engine's rate, from where it would fold into the lower eighth of the rate; from 2^4 on there is silence.

use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use super::fractional::Fractional;
use super::lanes::Real;
use super::sinc::weights;

/// Samples that one value is made of.
pub const TAPS: usize = 16;
/// Samples on each side that no value outside needs.
const MARGIN: usize = TAPS;
/// How many copies there are.
const COPIES: usize = 5;
/// The speed from which on there is silence.
pub const MOST_SPEED: f64 = 16.0;

/// The copies of a recording.
#[derive(Debug)]
pub struct Copies {
    /// Samples of each copy between margins of silence.
    copies: Vec<Vec<f32>>,
    /// Samples of the recording.
    pub length: usize,
    round: bool,
}

/// Where a recording repeats, in whole samples: from the first to before the second.
pub type Loop = Option<(usize, usize)>;

impl Copies {
    /// The copies of `samples`, made once for as long as someone holds them. `owner` names the recording; with `round`, its end
    /// is followed by its beginning.
    #[allow(clippy::disallowed_methods)] // when an engine is made
    pub fn of<T: Send + Sync + 'static>(owner: &Arc<T>, samples: &[f32], round: bool) -> Arc<Self> {
        type Kept = Mutex<Vec<(Weak<dyn std::any::Any + Send + Sync>, Weak<Copies>)>>;
        static KEPT: OnceLock<Kept> = OnceLock::new();
        let any: Arc<dyn std::any::Any + Send + Sync> = owner.clone();
        let mut kept = KEPT.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(owner, copies)| owner.strong_count() > 0 && copies.strong_count() > 0);
        let same = kept.iter().filter(|(owner, _)| std::ptr::addr_eq(owner.as_ptr(), Arc::as_ptr(&any)));
        if let Some(found) =
            same.filter_map(|(_, copies)| copies.upgrade()).find(|copies| copies.round == round)
        {
            return found;
        }
        let copies = Arc::new(Self::new(samples, round));
        kept.push((Arc::downgrade(&any), Arc::downgrade(&copies)));
        copies
    }

    fn new(samples: &[f32], round: bool) -> Self {
        let mut copies =
            vec![samples.iter().map(|x| if x.is_finite() { *x } else { 0.0 }).collect::<Vec<f32>>()];
        for n in 1..COPIES {
            copies.push(lowered(&copies[n - 1], 1 << (n - 1), round));
        }
        let margin = [0.0; MARGIN];
        let copies = copies.into_iter().map(|copy| [&margin[..], &copy, &margin].concat()).collect();
        Self { copies, length: samples.len(), round }
    }

    /// A sample of a copy; 0 outside.
    fn sample(&self, copy: usize, index: i64) -> f32 {
        let index = usize::try_from(index + MARGIN as i64).unwrap_or(usize::MAX);
        self.copies.get(copy).and_then(|c| c.get(index)).copied().unwrap_or(0.0)
    }

    /// The value at `place` (samples of the recording) heard at `speed`. Within a loop what lies beyond its end is its beginning, and,
    /// once it was `entered`, what lies before its beginning is its end.
    #[inline(always)]
    pub fn at<R: Real>(
        &self,
        table: &Fractional<R, TAPS>,
        place: f64,
        speed: f64,
        around: Loop,
        entered: bool,
    ) -> R {
        let (copy, share) = heard(speed);
        if copy >= COPIES {
            return R::ZERO;
        }
        let value = self.of_copy(table, copy, place, around, entered);
        if share == 0.0 {
            return value;
        }
        let next =
            if copy + 1 < COPIES { self.of_copy(table, copy + 1, place, around, entered) } else { R::ZERO };
        value + (next - value) * R::of(share)
    }

    #[inline(always)]
    fn of_copy<R: Real>(
        &self,
        table: &Fractional<R, TAPS>,
        copy: usize,
        place: f64,
        around: Loop,
        entered: bool,
    ) -> R {
        let samples = &self.copies[copy];
        let most = samples.len() as f64;
        // Nothing is within reach, or the place is not a number.
        if !(place > -(TAPS as f64) && place < most) {
            return R::ZERO;
        }
        let whole = place.floor();
        let (first, inside) = (whole as i64 - 7, place - whole + 7.0);
        let mut taps = [R::ZERO; TAPS];
        let beyond = around
            .is_some_and(|(start, end)| whole + 9.0 > end as f64 || (entered && whole - 7.0 < start as f64));
        if beyond {
            self.gather(&mut taps, copy, first, around, entered);
        } else {
            let from = first + MARGIN as i64;
            if from < 0 || from as usize + TAPS > samples.len() {
                return R::ZERO;
            }
            for (tap, sample) in taps.iter_mut().zip(&samples[from as usize..]) {
                *tap = R::of(f64::from(*sample));
            }
        }
        table.at(inside, &taps)
    }

    /// Taps across the seam of a loop.
    #[cold]
    #[inline(never)]
    fn gather<R: Real>(&self, taps: &mut [R; TAPS], copy: usize, first: i64, around: Loop, entered: bool) {
        let Some((start, end)) = around else { return };
        let (start, end) = (start as i64, end as i64);
        let length = (end - start).max(1);
        for (k, tap) in taps.iter_mut().enumerate() {
            let index = first + k as i64;
            let wraps = index >= end || (entered && index < start);
            let index = if wraps { start + (index - start).rem_euclid(length) } else { index };
            *tap = R::of(f64::from(self.sample(copy, index)));
        }
    }

    /// What [`Copies::at`] approximates, for the twins: a sinc in the window cosh 12√(1 − x²) / cosh 12, of 48 samples on each side.
    pub fn exact(&self, place: f64, speed: f64, around: Loop, entered: bool) -> f64 {
        const REACH: f64 = 48.0;
        let (copy, share) = heard(speed);
        let one = |copy: usize| {
            if copy >= COPIES || !place.is_finite() {
                return 0.0;
            }
            let bounds = around.map(|(start, end)| (start as i64, end as i64));
            let played = |index: i64| match bounds {
                Some((start, end)) if index >= end || (entered && index < start) => {
                    start + (index - start).rem_euclid((end - start).max(1))
                }
                _ => index,
            };
            weights(place, REACH)
                .map(|(index, weight)| f64::from(self.sample(copy, played(index))) * weight)
                .sum::<f64>()
        };
        one(copy) * (1.0 - share) + one(copy + 1) * share
    }
}

/// The copy for a speed, and the share of the next one.
#[inline(always)]
fn heard(speed: f64) -> (usize, f64) {
    let size = speed.abs();
    if size.is_nan() || size <= 1.0 {
        return (0, 0.0);
    }
    if size >= MOST_SPEED {
        return (COPIES, 0.0);
    }
    let bits = size.to_bits();
    let fraction = f64::from_bits((bits & 0x000F_FFFF_FFFF_FFFF) | 1.0_f64.to_bits()) - 1.0;
    let share = fraction / 0.75;
    ((bits >> 52) as usize - 1023, if share < 1.0 { share } else { 1.0 })
}

/// What lies below an eighth of the rate divided by `spacing`, of a copy that has nothing above twice that: flat to 0.09, −90 dB from
/// 0.125 on.
fn lowered(samples: &[f32], spacing: usize, round: bool) -> Vec<f32> {
    const REACH: i64 = 84;
    const CUT: f64 = 0.2150;
    let bessel = |x: f64| {
        let term = |(sum, term): (f64, f64), k: i32| (sum + term, term * (x / (2.0 * f64::from(k))).powi(2));
        (1..40).fold((0.0, 1.0), term).0
    };
    let taps: Vec<f64> = (-REACH..=REACH)
        .map(|k| {
            let angle = std::f64::consts::PI * CUT * k as f64;
            let sinc = if k == 0 { 1.0 } else { angle.sin() / angle };
            let window = bessel(9.0 * (1.0 - (k as f64 / (REACH + 1) as f64).powi(2)).sqrt()) / bessel(9.0);
            CUT * sinc * window
        })
        .collect();
    // What is around the recording: its other end, or silence.
    let count = samples.len();
    let reach = REACH as usize * spacing;
    let around = |n: usize| match n.checked_sub(reach) {
        _ if round && count > 0 => f64::from(samples[(n + count * reach - reach) % count]),
        place => place.and_then(|n| samples.get(n)).map_or(0.0, |x| f64::from(*x)),
    };
    let wide: Vec<f64> = (0..count + 2 * reach).map(around).collect();
    (0..count)
        .map(|n| wide[n..].iter().step_by(spacing).zip(&taps).map(|(x, tap)| x * tap).sum::<f64>() as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Copies, heard};
    use std::sync::Arc;

    #[test]
    fn speeds_choose_their_copies() {
        for (speed, copy, share) in [
            (0.0, 0, 0.0),
            (1.0, 0, 0.0),
            (-1.375, 0, 0.5),
            (1.9, 0, 1.0),
            (2.0, 1, 0.0),
            (3.5, 1, 1.0),
            (15.9, 3, 1.0),
            (16.0, 5, 0.0),
        ] {
            assert_eq!(heard(speed), (copy, share), "{speed}");
        }
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(heard(bad).0 <= 5);
        }
    }

    #[test]
    fn a_copy_is_the_lower_half_of_the_band() {
        let sine = |turns: f64| -> Vec<f32> {
            (0..4000).map(|n| (std::f64::consts::TAU * turns * f64::from(n)).sin() as f32).collect()
        };
        for (turns, passes) in [(0.01, true), (0.088, true), (0.126, false), (0.24, false)] {
            let copies = Copies::new(&sine(turns), false);
            for n in 400..3600 {
                let exact = if passes { (std::f64::consts::TAU * turns * n as f64).sin() } else { 0.0 };
                let error = (f64::from(copies.sample(1, n)) - exact).abs();
                assert!(error < 6e-5, "{turns} at {n}: {error}");
            }
        }
    }

    #[test]
    fn a_round_recording_has_no_seam() {
        let wave: Vec<f32> =
            (0..100).map(|n| (std::f64::consts::TAU * f64::from(n) / 100.0).sin() as f32).collect();
        let copies = Copies::new(&wave, true);
        for copy in 0..4 {
            for (n, x) in wave.iter().enumerate() {
                assert!((copies.sample(copy, n as i64) - x).abs() < 1e-4, "{copy} at {n}");
            }
        }
    }

    #[test]
    fn a_recording_is_copied_once() {
        let owner = Arc::new(7);
        let [a, b] = [0, 1].map(|_| Copies::of(&owner, &[1.0; 10], false));
        assert!(Arc::ptr_eq(&a, &b));
        assert!(!Arc::ptr_eq(&a, &Copies::of(&owner, &[1.0; 10], true)));
        assert!(!Arc::ptr_eq(&a, &Copies::of(&Arc::new(7), &[1.0; 10], false)));
    }
}
