//! Coils: resonances from a sweep into their rigs.

use super::program::Scratch;
use super::{Noise, RIG, SCALE, TACTOR, driven, late, near, of_part, record};
use pacinian::actuator::coil::model::Model as Coil;
use pacinian::actuator::coil::parameters::{Coil as Winding, Inertial, Spring, Tissue};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::identify::stimulus::sweep;
use pacinian::io::wav::Encoding;
use pacinian::rig::Rig;

/// A resonant actuator by its sweep, on a rig that knows of its data sheet; the recording ends early.
#[test]
fn a_resonance_goes_from_a_sweep_into_its_rig() {
    let scratch = Scratch::new("identify-lra");
    scratch.write(
        "r.toml",
        format!("{RIG}[actuator.shaker]\npart = \"vybronics-vg1040003d\"\nq = 9.0 # guessed\n{TACTOR}"),
    );
    let made = scratch
        .run(&[
            "identify",
            "--stimulus",
            "d.wav",
            "--rig",
            "r.toml",
            "--output",
            "tip",
            "--rate",
            "48000",
            "--json",
        ])
        .succeeds()
        .json();
    assert!(
        (made["peak_volts"].as_f64().unwrap() - 1.768).abs() < 1e-9 && made["kind"] == "sweep",
        "{made:#}"
    );
    let (rate, volts) = driven(&scratch, "d.wav", 1);
    let plant = of_part("vybronics-vg1040003d").coil().unwrap();
    let mut model = Coil::new(&plant, rate, Imposes::Voltage).unwrap();
    let mut x = vec![0.0];
    model.run(&volts, |o| x.push(o.casing));
    let x = Noise(5).on(&late(&x, 20_000, 0)[..240_000], 40.0);
    record(&scratch, "take.wav", rate, Encoding::I24, &[(&x, -60.0), (&vec![0.0; 240_000], 1.0)]);
    let words = [
        "identify",
        "take.wav",
        "--channels",
        "acceleration,-",
        "--drive",
        "d.wav",
        "--rig",
        "r.toml",
        "--actuator",
        "shaker",
        "--acceleration-scale",
        "-60",
        "--json",
        "--write",
    ];
    let said = scratch.run(&words).succeeds().json();
    let pair = plant.resonance(Imposes::Voltage).unwrap();
    let gain = plant.per_volt(pair.hertz).casing.abs();
    for (name, truth) in [("resonance", pair.hertz), ("q", pair.q), ("sensitivity", gain)] {
        near(&said, name, truth);
    }
    assert!((said["delay"].as_f64().unwrap() - 20_000.0 / rate).abs() < 5e-4, "{}", said["delay"]);
    assert!(said["missed"][1].as_f64().unwrap() > 0.01, "{}", said["missed"]);
    let text = std::fs::read_to_string(scratch.0.join("r.toml")).unwrap();
    assert!(text.contains("# guessed; pacinian identify take.wav: "), "{text}");
    let q = Rig::parse("r", text.as_bytes()).unwrap().value.actuator("shaker").unwrap().value("q").unwrap();
    assert!((q / pair.q - 1.0).abs() < 0.03, "{q}");
}

/// A voice coil with its current: a rig has the resonance and quality of open terminals, so those go there, and none without a current.
#[test]
fn a_voice_coil_with_a_current_gets_what_its_rig_means() {
    let scratch = Scratch::new("identify-coil");
    let known = "[actuator.shaker]\npart = \"eai-c-mf\"\n";
    scratch.write("r.toml", format!("{RIG}{known}{TACTOR}"));
    scratch
        .run(&["identify", "--stimulus", "d.wav", "--rig", "r.toml", "--output", "tip", "--rate", "16000"])
        .succeeds();
    let (rate, volts) = driven(&scratch, "d.wav", 1);
    let plant = of_part("eai-c-mf").coil().unwrap();
    let mut model = Coil::new(&plant, rate, Imposes::Voltage).unwrap();
    let (mut x, mut i) = (vec![0.0], vec![0.0]);
    model.run(&volts, |o| {
        x.push(o.acceleration);
        i.push(o.current);
    });
    let (x, i) = (Noise(6).on(&late(&x, 800, 100), 40.0), Noise(7).on(&late(&i, 800, 100), 40.0));
    record(&scratch, "take.wav", rate, Encoding::F32, &[(&x, 5000.0), (&i, 1.0)]);
    let words = [
        "identify",
        "take.wav",
        "--drive",
        "d.wav",
        "--rig",
        "r.toml",
        "--output",
        "tip",
        "--acceleration-scale",
        "5000",
        "--json",
    ];
    let with = ["--channels", "acceleration,current", "--current-scale", "1", "--share", "1"];
    let said = scratch.run(&[&words[..], &with].concat()).succeeds().json();
    let [open, shorted] = [Imposes::Current, Imposes::Voltage].map(|drive| plant.resonance(drive).unwrap());
    for (name, truth) in [
        ("resonance", open.hertz),
        ("q", open.q),
        ("shorted_q", shorted.q),
        ("resistance", 10.0),
        ("force_factor", 1.5),
    ] {
        near(&said, name, truth);
    }
    assert!(open.q > 1.3 * shorted.q, "it is not the same");
    assert_eq!(said["contradictions"].as_array().unwrap().len(), 0, "{said:#}");
    let without = scratch.run(&[&words[..], &["--channels", "acceleration,-"]].concat()).succeeds().json();
    near(&without, "q", shorted.q);
    for key in ["resonance", "q"] {
        let told = without["told"].as_array().unwrap().iter().find(|f| f["name"] == key).unwrap().clone();
        assert!(told["left_out"].as_str().unwrap().contains("open ones: record the current"), "{told}");
    }
    // What is written is what the rig then moves by, whatever springs the part has.
    let other = "[actuator.shaker]\npart = \"eai-c-mf\"\nresonance = 300.0\nq = 9.0\n";
    scratch.write("r.toml", format!("{RIG}{other}{TACTOR}"));
    scratch.run(&[&words[..words.len() - 1], &with, &["--write"]].concat()).succeeds();
    let rig = Rig::parse("r", std::fs::read(scratch.0.join("r.toml")).unwrap().as_slice()).unwrap().value;
    let is = rig.actuator("shaker").unwrap().coil().unwrap().resonance(Imposes::Current).unwrap();
    assert!(
        (is.hertz / open.hertz - 1.0).abs() < 0.01 && (is.q / open.q - 1.0).abs() < 0.05,
        "{is:?} {open:?}"
    );
}

/// An exciter of 23 Hz.
fn low() -> Plant {
    let coil = Winding { resistance: 6.0, inductance: 2e-4, force_factor: 1.5 };
    let suspension = Spring { stiffness: 900.0, damping: 1.0 };
    let hand = Tissue::default();
    Plant::inertial(&Inertial { coil, slug_mass: 0.05, casing_mass: 0.3, suspension, hand }).unwrap()
}

/// Behind the capacitors of a card a low resonance gets less than was played: by the rig that is known.
#[test]
fn a_coupling_is_no_part_of_what_is_found() {
    let scratch = Scratch::new("identify-coupling");
    let rig = |coupling: &str| {
        let rig = RIG.replacen("coupling = \"dc\"", coupling, 1);
        format!("{rig}[actuator.shaker]\nmodel = \"inertial-motor\"\n{TACTOR}")
    };
    scratch.write("ac.toml", rig("coupling = { high_pass = 20.0 }"));
    scratch.write("dc.toml", rig("coupling = \"dc\""));
    let (rate, fine) = (8000.0, 4_usize);
    let played = sweep(1.0, [5.0, 200.0], 4.0, rate).unwrap();
    record(&scratch, "d.wav", rate, Encoding::F32, &[(&played, SCALE)]);
    // A capacitor by its definition: c' = w (u - c), the voltage u - c in the mean over a fourth of a sample.
    let z = std::f64::consts::TAU * 20.0 / (rate * fine as f64);
    let (mut charge, mut volts) = (0.0, vec![]);
    for u in &played {
        for _ in 0..fine {
            volts.push((u - charge) * -(-z).exp_m1() / z);
            charge += (u - charge) * -(-z).exp_m1();
        }
    }
    let plant = low();
    let mut model = Coil::new(&plant, rate * fine as f64, Imposes::Voltage).unwrap();
    let mut x = vec![0.0];
    model.run(&volts, |o| x.push(o.casing));
    let x: Vec<f64> = x.into_iter().step_by(fine).collect();
    record(&scratch, "take.wav", rate, Encoding::F32, &[(&Noise(31).on(&late(&x, 900, 100), 40.0), 40.0)]);
    let of = |rig: &str| {
        let words = [
            "identify",
            "take.wav",
            "--drive",
            "d.wav",
            "--acceleration-scale",
            "40",
            "--output",
            "tip",
            "--json",
            "--rig",
            rig,
        ];
        scratch.run(&words).succeeds().json()
    };
    let pair = plant.resonance(Imposes::Voltage).unwrap();
    let gain = plant.per_volt(pair.hertz).casing.abs();
    let said = of("ac.toml");
    [("resonance", pair.hertz), ("q", pair.q), ("sensitivity", gain)]
        .into_iter()
        .for_each(|(name, truth)| near(&said, name, truth));
    // It is not the same as none.
    let without = of("dc.toml");
    let told =
        without["told"].as_array().unwrap().iter().find(|figure| figure["name"] == "sensitivity").unwrap();
    assert!(told["value"].as_f64().unwrap() < 0.9 * gain, "{told}, but it is {gain}");
}
