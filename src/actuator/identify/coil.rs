//! The coil of a resonant actuator, from its current.
//!
//! V = R i + L di/dt + s, and what the coil's motion gives, s, follows the current: s″ + (ω/Q) s′ + ω² s = m i′ with the open-circuit pole
//! pair and m = Bl²/μ, in the time integral. The recorded acceleration for each volt, with its share of the coil's own, is Bl/μ of the same.

use super::estimate::Identified;
use super::held::Held;
use super::least::{Fit, descend};
use super::resonant::{LAG, Motion, Recording, lag};

/// An inductance shows where it makes a lag of this share of a sample for certain.
const SHOWS: f64 = 0.2;

/// The fitted current.
pub(super) struct Electric {
    /// R, m = Bl²/μ, ω and Q with open terminals, delay, offset, and what makes L/R.
    fit: Fit,
    rate: f64,
}

/// With less than this share of its mean square left a fit needs no other beside it.
const GOOD: f64 = 1e-3;
/// The coil's part of the damping, at first.
const PARTS: [f64; 3] = [0.2, 0.5, 0.8];

impl Electric {
    /// From drive and current; `None` where one does not follow the other.
    pub fn of(drive: &[f64], current: &[f64], rate: f64, motion: &Motion) -> Option<Self> {
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let resistance = (square(drive) / square(current).max(1e-300)).sqrt();
        let [omega, q] = [motion.fit.values[0], motion.fit.values[1]];
        let peak = current.iter().fold(0.0_f64, |m, i| m.max(i.abs()));
        let steps = [
            1e-6 * resistance,
            1e-5 * resistance * omega / q,
            1e-6 * omega,
            1e-5 * q,
            1e-4 / rate,
            1e-5 * peak,
            1e-4,
        ];
        let fit = |start: &[f64]| {
            descend(start, &steps[..start.len()], |p| {
                let sound = p[0] > 0.0 && p[2] > 0.0 && p[3] > 0.0;
                let held = Held::coil(p[0], p[0] * lag(p.get(6)) / rate, p[1], p[2], p[3]);
                let out = sound.then(|| held.play(drive, 1.0 / rate, p[4]))??;
                Some(out.iter().zip(current).map(|(y, i)| y + p[5] - i).collect())
            })
        };
        // The current comes as late as the acceleration where both went the same way, or with the drive.
        let starts = [motion.fit.values[3], 0.0].into_iter().flat_map(|late| {
            PARTS.map(|part| [resistance, resistance * omega * part / q, omega, q / (1.0 - part), late, 0.0])
        });
        let mut best: Option<Fit> = None;
        for start in starts {
            best = best.into_iter().chain(fit(&start)).min_by(|a, b| a.left.total_cmp(&b.left));
            let share = |fit: &Fit| fit.left * current.len() as f64 / square(current);
            if best.as_ref().is_some_and(|best| share(best) < GOOD) {
                break;
            }
        }
        let best = best?;
        // Where within its sample a current is taken is not known: from both ends.
        let ends = [0.0, LAG / rate].map(|late| {
            let mut start = best.values.clone();
            start[4] += late;
            start.push(LAG);
            fit(&start)
        });
        let fit = ends.into_iter().flatten().min_by(|a, b| a.left.total_cmp(&b.left))?;
        let share = fit.left * current.len() as f64 / square(current);
        (share < 0.3).then_some(Self { fit, rate })
    }

    /// What of it a rig knows.
    pub fn tell(&self, r: &Recording, motion: &Motion, all: &mut Identified) {
        let fit = &self.fit;
        let told = |figure: &dyn Fn(&[f64]) -> f64| (figure(&fit.values), fit.off_of(figure));
        let (resistance, off) = told(&|p| p[0]);
        all.key("resistance", "ohm", resistance, [off; 2]);
        let (hertz, off) = told(&|p| p[2] / std::f64::consts::TAU);
        all.aside("open_resonance", "Hz", hertz, off);
        let (q, off) = told(&|p| p[3]);
        all.aside("open_q", "1", q, off);
        let (inductance, off) = told(&|p| p[0] * lag(p.get(6)) / self.rate);
        if (inductance - off) * self.rate > SHOWS * resistance {
            all.key("inductance", "H", inductance, [off; 2]);
        } else {
            let most = (inductance + off).max(SHOWS * resistance / self.rate);
            all.untold(
                "inductance",
                format!(
                    "the current follows at once: below {most:.1e} H; drive higher frequencies, record faster"
                ),
            );
        }
        match r.share {
            Some(share) if r.is_calibrated => {
                // G = share Bl / (μ R′) with R′ = R ω_o²/ω², so that Bl = (Bl²/μ) share / (G R′).
                let omega = motion.fit.values[0];
                let (per, off) = told(&|p| p[1] * omega * omega / (p[0] * p[2] * p[2]));
                let gain = motion.fit.values[2].abs();
                let (slack, tilt) = (motion.fit.off(&unit(2, &motion.fit)) / gain, 2.0 * motion.fit.off(&unit(0, &motion.fit)) / omega);
                let value = share * per / gain;
                let off = value * ((off / per).hypot(slack).hypot(tilt) + motion.unseen());
                all.key("force_factor", "N/A", value, [off; 2]);
            }
            _ => all.untold(
                "force_factor",
                "only Bl² over what moves shows: record in m/s2, and say what share of the coil's own acceleration that is",
            ),
        }
    }
}

/// The gradient of a parameter.
fn unit(at: usize, fit: &Fit) -> Vec<f64> {
    (0..fit.values.len()).map(|n| f64::from(u8::from(n == at))).collect()
}
