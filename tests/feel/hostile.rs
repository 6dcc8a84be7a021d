//! What is no number, what cannot be, what is not known.

use super::{COIN, DC, LRA, RATE, SHAKER, TACTOR, feel, felt, lively, rig};
use pacinian::feel::{Counts, Feel, Wish};
use pacinian::rig::{Actuator, Rig};

#[test]
fn what_is_no_number_is_silence_and_counted() {
    let samples = lively(4800);
    for actuator in [COIN, TACTOR, LRA] {
        let mut bad = samples.clone();
        let mut zero = samples.clone();
        for (n, value) in [(100, f32::NAN), (2000, f32::INFINITY), (2001, f32::NEG_INFINITY)] {
            (bad[n], zero[n]) = (value, 0.0);
        }
        let (is, figures) = felt(&rig(actuator, DC), RATE, &bad);
        assert_eq!(is, felt(&rig(actuator, DC), RATE, &zero).0);
        assert_eq!(figures.counts, Counts { clipped: 0, limited: 0, masked: 3 });
        // Voltages beyond any: finite, whatever they do; what a motor does not take is counted.
        let mut rig = rig(actuator, [DC[0], "gain = 1e4\ncoupling = \"dc\"", ""]);
        rig.device.full_scale_volts = Some(1e4);
        let (is, figures) = felt(&rig, RATE, &samples);
        assert!(is.iter().flatten().all(|x| x.is_finite()) && figures.peak.is_finite(), "{figures:?}");
        assert!(actuator != COIN || figures.counts.masked > 1000, "{figures:?}");
        // Of a program, not of a file: so strong and so light that a float holds no such acceleration.
        if actuator == TACTOR {
            let free = ["stiffness", "damping", "skin_mass", "skin_stiffness", "skin_damping"];
            rig.actuators[0].values.extend(free.map(|key| (key, 0.0)));
            rig.actuators[0].values.insert("moving_mass", 1e-30);
            rig.amplifiers[0].drive = pacinian::rig::Drive::Current;
            let (is, figures) = felt(&rig, RATE, &samples);
            assert!(is.iter().flatten().all(|x| x.is_finite()) && figures.rms.is_finite(), "{figures:?}");
            assert!(figures.counts.masked > 1000, "{figures:?}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let rig = rig(COIN, DC);
    let field = |channels, rate, error| Feel::new(&rig, channels, rate, &Wish { error }).unwrap_err().field;
    for rate in [0.0, -48e3, 1.0, 1e9, f64::NAN, f64::INFINITY] {
        assert_eq!(field(1, rate, 1e-3), "rate");
    }
    assert_eq!((field(0, RATE, 1e-3), field(usize::MAX, RATE, 1e-3)), ("channels", "channels"));
    assert_eq!((field(1, RATE, 0.0), field(1, RATE, f64::NAN)), ("error", "error"));
    for rate in [100.0, 6000.0, 44_100.0, 768_000.0, 1e7] {
        for actuator in [COIN, TACTOR, SHAKER, LRA] {
            let (is, figures) = felt(&super::rig(actuator, DC), rate, &lively(3000));
            assert!(is.iter().flatten().all(|x| x.is_finite()) && figures.rms > 0.0, "{rate} {figures:?}");
        }
    }
}

#[test]
fn what_is_not_known_is_named_with_what_would_help() {
    let why = |rig: &Rig| -> Vec<String> {
        let feel = Feel::new(rig, 1, RATE, &Wish::default()).unwrap();
        assert!(feel.traces().is_empty() && feel.felt().is_empty());
        feel.unfelt()[0].why.iter().map(ToString::to_string).collect()
    };
    let good = rig(COIN, DC);
    let with = |change: fn(&mut Rig)| {
        let mut rig = good.clone();
        change(&mut rig);
        why(&rig)
    };
    for (told, words) in [
        (with(|r| r.outputs[0].actuator = None), &["output `o` has no actuator", "actuator = \"NAME\""][..]),
        (with(|r| r.outputs[0].actuator = Some("b".into())), &["`b`, which is not there", "[actuator.b]"]),
        (with(|r| r.outputs[0].amplifier = Some("b".into())), &["amplifier `b`", "[amplifier.b]"]),
        (with(|r| r.amplifiers[0].gain = 0.0), &["`amp` has a gain of 0", "give its gain"]),
        (with(|r| r.device.full_scale_volts = None), &["models need volts", "full_scale_volts = 1.4"]),
        (with(|r| r.outputs[0].channel = 2), &["channel 2, where 1 were rendered"]),
        (with(|r| r.outputs[0].channel = 0), &["channel 0"]),
        (
            with(|r| r.actuators[0] = Actuator::generic("a")),
            &["model generic", "`pacinian parts` lists them"],
        ),
        (
            with(|r| {
                r.actuators[0].values.remove("inertia");
            }),
            &["(rumble-motor) lacks `inertia`", "its part does not say"],
        ),
        (
            with(|r| {
                r.actuators[0].values.insert("mass", 1e-9);
            }),
            &["`a` cannot be: `mass` is 1e-9", "correct it"],
        ),
        (
            with(|r| r.device.full_scale_volts = Some(f64::NAN)),
            &["cannot be simulated: `full_scale_volts` is NaN"],
        ),
    ] {
        assert_eq!(told.len(), 1, "{told:?}");
        words.iter().for_each(|word| assert!(told[0].contains(word), "no `{word}`: {told:?}"));
    }
    let piezo = why(&rig("[actuator.a]\npart = \"tdk-powerhap-1313h018v120\"\n", DC));
    assert!(piezo[0].contains("model piezo"), "{piezo:?}");
    let keys = "drive = \"carrier\"\ngain = 4\ndiode_drop = 0.7\ncoupling = \"dc\"";
    let rectified = why(&rig(TACTOR, [DC[0], keys, ""]));
    let words = ["`o` has voice-coil behind the rectifier of `amp`", "only rumble motors"];
    assert!(words.iter().all(|word| rectified[0].contains(word)), "{rectified:?}");
    let both = with(|r| {
        r.device.full_scale_volts = None;
        r.actuators[0].values.remove("inertia");
    });
    assert_eq!(both.len(), 2, "all at once: {both:?}");
    // What is assumed is said.
    let assumed =
        |keys: [&str; 3], actuator: &str| feel(&rig(actuator, keys), RATE).felt()[0].assumed.join("; ");
    assert_eq!(assumed(DC, TACTOR), "");
    assert!(assumed(["", "gain = 1", ""], TACTOR).contains("the device lets steady voltages through"));
    let told = assumed(["", "gain = 1", ""], TACTOR);
    assert!(
        told.contains("amplifier `amp` lets steady voltages through")
            && told.contains("`max_volts` is not known")
    );
    assert!(assumed([DC[0], "", ""], TACTOR).contains("no amplifier is named"));
    assert!(
        assumed(DC, &TACTOR.replace("skin_mass = 1e-4\nskin_stiffness = 1200\nskin_damping = 1.5\n", ""))
            .contains("touches nothing")
    );
}
