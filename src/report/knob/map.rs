//! The stability map: stiffness over damping, the edge beyond which a knob swings by itself, what its governor grants, and where its effects are.
//!
//! The edge is exact: where the first eigenvalue of the sampled loop, with its delay, reaches the unit circle. Beside it stands the closed form
//! (b + B) / (T / 2 + late), of which it is the corner for a small B (Gil et al. 2009), and the stiffness up to which dry friction covers a
//! count of the encoder, 2 f / δ (Abbott & Okamura 2005).

use crate::actuator::fault::Fault;
use crate::knob::effect::Bound;
use crate::knob::governor::Governor;
use crate::knob::governor::device::Device;
use crate::knob::stability::rules::gil;
use crate::report::plot::{Axis, Chart, Point, Series};
use std::fmt::Write;

/// A map. Points are a computed damping (N m s/rad) and a stiffness (N m/rad).
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The exact edge.
    pub edge: Vec<(f64, f64)>,
    /// What the governor grants.
    pub granted: Vec<(f64, f64)>,
    /// The closed form.
    pub rule: Vec<(f64, f64)>,
    /// The stiffness up to which friction covers a count; `None`: friction is not known.
    pub covered: Option<f64>,
    /// What effects ask for, and what is left of that.
    pub asked: Option<[(f64, f64); 2]>,
    /// What binds where they are, and what would lift it.
    pub binds: String,
}

/// Points of a curve, and decades of damping.
const POINTS: usize = 80;
const DECADES: f64 = 4.0;

impl Map {
    /// Of a device whose governor grants a share `margin` of the edge, and effects that ask for so much.
    ///
    /// # Errors
    /// A figure of the device that cannot be, or `margin`.
    pub fn new(device: &Device, margin: f64, ask: Option<&Bound>) -> Result<Self, Fault> {
        let governor = Governor::new(device, margin)?;
        let sampled = device.sampled()?;
        let late = device.delay.total() * device.period;
        // Beyond the edge of damping alone nothing is stable. Where that is without end, as far as the effects ask.
        let asked = ask.map_or(0.0, |ask| ask.damping);
        let edge = sampled.damping_edge().gain;
        let most = if edge.is_finite() && edge > 0.0 {
            edge
        } else {
            f64::max(2.0 * asked, device.damping.max(1e-6))
        };
        // By decades: what devices bear without damping and with the most that helps lies a hundred times apart.
        let along = |most: f64| {
            (0..=POINTS).map(move |n| most * 10f64.powf(DECADES * (n as f64 / POINTS as f64 - 1.0)))
        };
        let curve =
            |most: f64, of: &dyn Fn(f64) -> f64| along(most).map(|damping| (damping, of(damping))).collect();
        let allowed = ask.map(|ask| {
            let allowed = governor.allow(ask);
            [(ask.damping, ask.stiffness), (ask.damping * allowed.damping, ask.stiffness * allowed.stiffness)]
        });
        Ok(Self {
            edge: curve(most, &|damping| sampled.edge(damping).gain),
            granted: curve(governor.most_damping().min(most), &|damping| governor.most_stiffness(damping)),
            rule: curve(most, &|damping| gil(device.damping, damping, device.period, late)),
            covered: Some(device.covered()).filter(|covered| covered.is_finite()),
            asked: allowed,
            binds: governor.explain(asked)?.to_string(),
        })
    }

    /// The picture.
    pub fn chart(&self, title: &str) -> Chart {
        let stiffnesses = || self.edge.iter().map(|(_, k)| *k).filter(|k| k.is_finite() && *k > 0.0);
        let highest = stiffnesses().fold(0.0, f64::max);
        let left = self.edge.first().map_or(0.0, |(damping, _)| *damping);
        // The closed form leaves the map at the top, and the edge at the bottom.
        let (top, bottom) = (3.0 * highest, 1e-4 * highest);
        let series = |name: &str, points: &[(f64, f64)]| Series {
            name: name.into(),
            points: points
                .iter()
                .filter(|(_, stiffness)| (bottom..=top).contains(stiffness))
                .map(|(x, y)| Point { x: *x, y: *y, label: String::new() })
                .collect(),
            smooth: true,
        };
        let mut all = vec![
            series("it swings above", &self.edge),
            series("granted", &self.granted),
            series("(b + B) / (T/2 + late)", &self.rule),
        ];
        let right = self.edge.last().map_or(0.0, |(x, _)| *x);
        let mut notes: Vec<String> =
            format!("Bears {}.", self.binds).split_inclusive("; ").map(str::to_string).collect();
        match self.covered {
            Some(covered) if covered <= top => {
                all.push(series("friction hides a count below", &[(0.0, covered), (right, covered)]));
            }
            Some(covered) => notes.push(format!(
                "Friction hides the encoder's counts up to {covered:.3} N m/rad, beyond this map."
            )),
            None => notes
                .push("Friction is not known: whether it hides the encoder's counts is not either.".into()),
        }
        if let Some([(x, y), (gx, gy)]) = self.asked {
            let at = |x: f64, y: f64, label: &str| Point { x, y, label: label.into() };
            let is_less = gx < x || gy < y;
            let mut points = Vec::new();
            let is_shown = (bottom..=top).contains(&y);
            if is_shown {
                points.push(at(x.max(left), y, if is_less { "asked" } else { "asked, and granted" }));
            } else {
                notes.push(format!(
                    "The effects ask for {y:.3} N m/rad and {x:.3e} N m s/rad, beyond this map."
                ));
            }
            if is_less && (bottom..=top).contains(&gy) {
                points.push(at(gx.max(left), gy, "left of it"));
            }
            if is_shown && x < left {
                notes.push("The effects ask for no damping: they stand at the left edge.".into());
            }
            all.push(Series { name: "effects".into(), points, smooth: false });
        }
        Chart {
            title: title.into(),
            x: Axis { label: "computed damping B (N m s/rad)".into(), log: true, least: 0.0 },
            y: Axis { label: "stiffness K (N m/rad)".into(), log: true, least: 0.0 },
            series: all,
            notes,
        }
    }

    /// As a table: damping, and the stiffness at the edge, by the closed form, and granted (empty beyond what is granted of damping).
    pub fn csv(&self) -> String {
        let mut text = String::from("damping,edge,rule,granted\n");
        let most = self.granted.last().map_or(0.0, |(damping, _)| *damping);
        for ((damping, edge), (_, rule)) in self.edge.iter().zip(&self.rule) {
            let granted = between(&self.granted, *damping).filter(|_| *damping <= most);
            let granted = granted.map_or(String::new(), |k| format!("{k:.9e}"));
            let _ = writeln!(text, "{damping:.9e},{edge:.9e},{rule:.9e},{granted}");
        }
        text
    }
}

/// On the line through points.
fn between(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = points.partition_point(|(at, _)| *at <= x);
    match (after.checked_sub(1).and_then(|n| points.get(n)), points.get(after)) {
        (Some(&(a, from)), Some(&(b, to))) => Some(from + (to - from) * (x - a) / (b - a)),
        (Some(&(_, last)), None) => Some(last),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Bound, Device, Map};
    use crate::knob::governor::device::Delay;

    fn device(delay: f64) -> Device {
        Device {
            inertia: 6e-6,
            damping: 2e-4,
            friction: Some(2.1e-3),
            count: std::f64::consts::TAU / 4096.0,
            period: 1.0 / 8000.0,
            delay: Delay::ticks(delay),
            resonance: None,
            low_pass: None,
            peak: 0.15,
        }
    }

    /// A little below the edge every eigenvalue lies within the unit circle, a little above one does not.
    #[test]
    fn the_edge_is_where_it_begins_to_swing() {
        for delay in [0.0, 1.5, 12.0] {
            let map = Map::new(&device(delay), 0.5, None).unwrap();
            let sampled = device(delay).sampled().unwrap();
            for (damping, stiffness) in map.edge.iter().step_by(9).filter(|(_, k)| *k > 1e-6) {
                assert!(sampled.radius(0.99 * stiffness, *damping) < 1.0, "{delay} {damping}");
                assert!(sampled.radius(1.01 * stiffness, *damping) > 1.0, "{delay} {damping}");
            }
            // The rule is its corner at a small damping.
            assert!(
                (map.rule[0].1 / map.edge[0].1 - 1.0).abs() < 0.05,
                "{:?} {:?}",
                map.rule[0],
                map.edge[0]
            );
        }
    }

    #[test]
    fn what_is_asked_is_shown_with_what_is_left_of_it() {
        let ask = Bound { stiffness: 10.0, damping: 1e-4 };
        let map = Map::new(&device(1.0), 0.5, Some(&ask)).unwrap();
        let [asked, left] = map.asked.unwrap();
        assert_eq!(asked, (1e-4, 10.0));
        assert!(left.1 < 10.0 && left.0 == 1e-4);
        let at = super::between(&map.granted, left.0).unwrap();
        assert!((left.1 / at - 1.0).abs() < 0.02, "{left:?} {at}");
        let svg = map.chart("A knob").svg();
        assert!(svg.contains("left of it") && svg.contains("N m/rad"));
        assert_eq!(map.csv().lines().count(), map.edge.len() + 1);
    }

    #[test]
    fn whatever_the_device_a_picture_is_drawn() {
        let plain = device(0.0);
        for device in [
            Device { damping: 0.0, ..plain.clone() },
            Device { friction: None, ..plain.clone() },
            Device { friction: Some(0.0), ..plain.clone() },
            Device { damping: 1e3, ..plain.clone() },
            Device { inertia: 1e-12, ..plain.clone() },
            Device { delay: Delay { fixed: 0.5, block: 512, blocks: 2.0 }, ..plain.clone() },
        ] {
            for ask in [None, Some(Bound { stiffness: 1e9, damping: 1e9 }), Some(Bound::default())] {
                let map = Map::new(&device, 0.5, ask.as_ref()).unwrap();
                let svg = map.chart("").svg();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{device:?}");
            }
        }
        assert!(Map::new(&Device { inertia: f64::NAN, ..plain.clone() }, 0.5, None).is_err());
        assert!(Map::new(&plain, 0.0, None).is_err());
    }
}
