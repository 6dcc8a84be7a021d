//! Magnets: the nearest of them, on one grid.

use super::super::config::{Config, MOST_DETENTS};
use super::{Compiling, FAR, SMALL};
use crate::knob::effect::magnet::Magnet;

impl Compiling<'_> {
    pub(super) fn magnets(
        &mut self,
        all: &[(usize, &Magnet)],
        angle: f64,
    ) -> (Config, f64, Option<(f64, f64)>) {
        let mut sorted = all.to_vec();
        sorted.sort_by(|a, b| a.1.centre.total_cmp(&b.1.centre));
        let centre = |k: usize| sorted[k].1.centre;
        // The nearest are a run of those that are sorted.
        let count = sorted.len().min(MOST_DETENTS);
        let mut first = 0;
        while first + count < sorted.len() && angle - centre(first) > centre(first + count) - angle {
            first += 1;
        }
        let below =
            if first > 0 { 0.5 * (centre(first - 1) + centre(first + count - 1)) } else { f64::NEG_INFINITY };
        let above = if first + count < sorted.len() {
            0.5 * (centre(first) + centre(first + count))
        } else {
            f64::INFINITY
        };
        let holds = (sorted.len() > count).then_some((below, above));
        let chosen = &sorted[first..first + count];
        let nearest = chosen
            .iter()
            .min_by(|a, b| (a.1.centre - angle).abs().total_cmp(&(b.1.centre - angle).abs()))
            .unwrap_or(&chosen[0]);
        let Magnet { centre: origin, stiffness, reach } = *nearest.1;
        // K r²/6 is the depth of a magnet, K (s w)²/2 that of a position that lets go s widths from its middle.
        let snap = 0.55;
        let ideal = reach / 3_f64.sqrt() / snap;
        let off = |width: f64, at: f64| (at - origin) - ((at - origin) / width).round() * width;
        let worst =
            |width: f64| chosen.iter().map(|m| off(width, m.1.centre).abs() / width).fold(0.0, f64::max);
        let width = (0..=400)
            .map(|k| ideal * (0.5 + f64::from(k) / 400.0))
            .min_by(|a, b| {
                (worst(*a) + 1e-3 * (a - ideal).abs()).total_cmp(&(worst(*b) + 1e-3 * (b - ideal).abs()))
            })
            .unwrap_or(ideal);
        let strength = self.strength(stiffness, nearest.0, "magnet");
        let mut detents: Vec<i32> = Vec::with_capacity(count);
        for (k, magnet) in chosen {
            let place =
                ((magnet.centre - origin) / width).round().clamp(-f64::from(FAR), f64::from(FAR)) as i32;
            self.dead_zone(*k, "magnet", width);
            self.near(*k, "magnet", "its smooth pull becomes a straight one that lets go, as deep");
            let away = off(width, magnet.centre).abs();
            if away > SMALL * width {
                let why = format!("it is on a position, {:.2} degrees away", away.to_degrees());
                self.near(*k, "magnet", why);
            }
            if magnet.stiffness != stiffness || magnet.reach != reach {
                self.near(*k, "magnet", "it is as stiff and wide as the nearest");
            }
            if detents.contains(&place) {
                self.near(*k, "magnet", "it falls together with another");
            } else {
                detents.push(place);
            }
        }
        for (k, _) in sorted.iter().filter(|m| !chosen.iter().any(|c| c.0 == m.0)) {
            self.near(*k, "magnet", "it comes when the knob is near: five at a time");
        }
        let (width, snap_point) = (width as f32, snap as f32);
        (Config { width, snap_point, detent_strength: strength, detents, ..Config::default() }, origin, holds)
    }
}
