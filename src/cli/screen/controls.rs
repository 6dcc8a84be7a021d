//! The controls of a patch: where they are, and which of them the keys move.

use std::collections::BTreeMap;

use pacinian::patch::{Curve, Patch};

/// Steps from one end of a range to the other.
const STEPS: f64 = 50.0;

/// A control.
#[derive(Debug, Clone, PartialEq)]
struct Known {
    name: String,
    unit: String,
    range: [f64; 2],
    curve: Curve,
    default: f64,
    value: f64,
}

/// A control as it is shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ControlFace {
    /// Its name.
    pub name: String,
    /// Where it was sent last.
    pub value: f64,
    /// Its unit; may be empty.
    pub unit: String,
    /// Where that lies in its range, 0 to 1, as its curve has it.
    pub position: f64,
    /// Whether keys move it.
    pub chosen: bool,
}

/// The controls of a patch.
#[derive(Debug, Default)]
pub struct Controls {
    all: Vec<Known>,
    chosen: usize,
}

impl Known {
    fn position_of(&self, value: f64) -> f64 {
        let [least, most] = self.range;
        let position = match self.curve {
            Curve::Exponential if least > 0.0 => (value / least).ln() / (most / least).ln(),
            _ => (value - least) / (most - least),
        };
        if position.is_finite() { position.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn value_at(&self, position: f64) -> f64 {
        let [least, most] = self.range;
        let value = match self.curve {
            _ if position <= 0.0 => least,
            _ if position >= 1.0 => most,
            Curve::Exponential if least > 0.0 => least * (most / least).powf(position),
            _ => least + position * (most - least),
        };
        value.clamp(least, most)
    }
}

impl Controls {
    /// Of a patch as it begins.
    pub fn new(patch: &Patch) -> Self {
        let known = |control: &pacinian::patch::Control| Known {
            name: control.name.clone(),
            unit: control.unit.clone(),
            range: control.range,
            curve: control.curve,
            default: control.default,
            value: control.default,
        };
        Self { all: patch.controls.iter().map(known).collect(), chosen: 0 }
    }

    /// The patch is another; controls that both have stay where they are, as far as their range goes.
    pub fn become_of(&mut self, patch: &Patch) {
        let before = std::mem::replace(self, Self::new(patch));
        for control in &mut self.all {
            if let Some(old) = before.all.iter().find(|old| old.name == control.name) {
                control.value = old.value.clamp(control.range[0], control.range[1]);
            }
        }
        let chosen = before.all.get(before.chosen).map(|old| old.name.as_str());
        self.chosen = self.all.iter().position(|control| Some(control.name.as_str()) == chosen).unwrap_or(0);
    }

    /// They were sent there, by whomever.
    pub fn hear(&mut self, moved: &BTreeMap<String, f64>) {
        for control in &mut self.all {
            if let Some(value) = moved.get(&control.name) {
                control.value = value.clamp(control.range[0], control.range[1]);
            }
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The one of that name is chosen, if there is one.
    pub fn choose_named(&mut self, name: &str) {
        self.chosen = self.all.iter().position(|control| control.name == name).unwrap_or(self.chosen);
    }

    /// The next is chosen, or one before.
    pub fn choose(&mut self, by: i32) {
        let count = self.all.len().max(1);
        self.chosen = (self.chosen % count + count).saturating_add_signed(by as isize) % count;
    }

    /// The chosen one goes so many steps on: its name, and where to.
    pub fn step(&mut self, by: i32) -> Option<(String, f64)> {
        let control = self.all.get_mut(self.chosen)?;
        // From one mark to the next, so that what went up comes down to where it was.
        let at = (STEPS * control.position_of(control.value)).round() + f64::from(by);
        control.value = control.value_at(at / STEPS);
        Some((control.name.clone(), control.value))
    }

    /// The chosen one goes back to where it was at first.
    pub fn reset(&mut self) -> Option<(String, f64)> {
        let control = self.all.get_mut(self.chosen)?;
        control.value = control.default;
        Some((control.name.clone(), control.value))
    }

    /// As they are shown.
    pub fn faces(&self) -> Vec<ControlFace> {
        let face = |(place, control): (usize, &Known)| ControlFace {
            name: control.name.clone(),
            value: control.value,
            unit: control.unit.clone(),
            position: control.position_of(control.value),
            chosen: place == self.chosen,
        };
        self.all.iter().enumerate().map(face).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Controls;
    use pacinian::Patch;
    use std::collections::BTreeMap;

    fn patch(controls: &str) -> Patch {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n{controls}\n[voice.v]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 100 }}\n"
        );
        Patch::parse("", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    }

    const TWO: &str = "[control.depth]\ndefault = 0.5\nrange = [0, 2]\n\
        [control.pitch]\ndefault = 200\nrange = [50, 800]\ncurve = \"exponential\"\nunit = \"Hz\"\n";

    #[test]
    fn a_step_is_a_fiftieth_of_the_range_and_ends_hold() {
        let mut controls = Controls::new(&patch(TWO));
        let at = |moved: Option<(String, f64)>| moved.unwrap().1;
        // 12.5 steps from the end: to the mark beside it.
        assert!((at(controls.step(1)) - 14.0 / 25.0).abs() < 1e-12);
        assert!((at(controls.step(-1)) - 13.0 / 25.0).abs() < 1e-12);
        assert_eq!(
            [at(controls.step(1000)), at(controls.step(1)), at(controls.step(-1000))],
            [2.0, 2.0, 0.0]
        );
        assert_eq!(controls.reset(), Some(("depth".into(), 0.5)));
        // Equal ratios: the range is a factor of 16, so half of it is one of 4.
        controls.choose(1);
        assert!((at(controls.step(25)) - 800.0).abs() < 1e-9);
        assert!((at(controls.step(-25)) - 200.0).abs() < 1e-9);
        assert!((controls.faces()[1].position - 0.5).abs() < 1e-12);
        assert!(controls.faces()[1].chosen && !controls.faces()[0].chosen);
        controls.choose(1);
        assert!(controls.faces()[0].chosen);
        controls.choose(-1);
        assert!(controls.faces()[1].chosen);
    }

    #[test]
    fn what_others_move_is_seen_and_stays_when_the_patch_is_another() {
        let mut controls = Controls::new(&patch(TWO));
        controls.hear(&BTreeMap::from([("depth".to_string(), 1.5), ("none".to_string(), 3.0)]));
        controls.hear(&BTreeMap::from([("pitch".to_string(), 1e9)]));
        let values = |controls: &Controls| -> Vec<f64> { controls.faces().iter().map(|f| f.value).collect() };
        assert_eq!(values(&controls), [1.5, 800.0]);
        controls.choose(1);
        let other = TWO
            .replace("range = [0, 2]", "range = [0, 1]")
            .replace("[control.depth]", "[control.new]\ndefault = 0.1\n[control.depth]");
        controls.become_of(&patch(&other));
        let mut named: Vec<_> = controls.faces().into_iter().map(|f| (f.name, f.value, f.chosen)).collect();
        named.sort_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(
            named,
            [("depth".into(), 1.0, false), ("new".into(), 0.1, false), ("pitch".into(), 800.0, true)]
        );
        let mut none = Controls::default();
        none.choose(-1);
        assert!(none.is_empty() && none.step(1).is_none() && none.reset().is_none());
    }
}
