//! Motors, from their stimulus into their rigs.

use super::program::Scratch;
use super::{
    Noise, RIG, SCALE, WRIST, coin, coin_take, driven, groups, late, near, of_part, record, turn, why_not,
};
use pacinian::actuator::motor::{Drive, GRAVITY, Motor, Parameters, Plan, Wish};
use pacinian::io::wav::Encoding;
use pacinian::rig::Rig;
use serde_json::Value;

/// From the stimulus to a rig that plays: nothing is known of the motor but what it is made for, and nothing of the recording's beginning.
#[test]
fn a_motor_goes_from_a_stimulus_into_its_rig() {
    let scratch = Scratch::new("identify-motor");
    let bare = format!(
        "{RIG}[actuator.coin]   # bought\nmodel = \"rumble-motor\"\nrated_volts = 3   # says the seller\n{WRIST}"
    );
    scratch.write("r.toml", &bare);
    let made = scratch.run(&[
        "identify",
        "--stimulus",
        "d.wav",
        "--rig",
        "r.toml",
        "--output",
        "wrist",
        "--rate",
        "48000",
    ]);
    assert!(made.succeeds().out.contains("--drive d.wav --rig r.toml --output wrist"), "{}", made.out);
    assert!(made.out.contains("3 V, 0.3 of full scale"), "{}", made.out);
    let (rate, volts) = driven(&scratch, "d.wav", 2);
    assert!(rate == 48e3 && volts.iter().fold(0.0_f64, |m, v| m.max(*v)) == SCALE * f64::from(0.3_f32));
    let p = coin();
    let [x, _] = turn(&p, rate, &volts);
    let x = Noise(1).on(&late(&x, 61_234, 9_999), 40.0);
    record(&scratch, "take.wav", rate, Encoding::I24, &[(&x, 40.0)]);
    let words = [
        "identify",
        "take.wav",
        "--drive",
        "d.wav",
        "--rig",
        "r.toml",
        "--output",
        "wrist",
        "--acceleration-scale",
        "40",
    ];
    let dry = scratch.run(&words);
    assert!(
        dry.succeeds()
            .out
            .contains("--write would put into r.toml: time_constant, speed_per_volt, running_volts"),
        "{}",
        dry.out
    );
    assert_eq!(
        std::fs::read_to_string(scratch.0.join("r.toml")).unwrap(),
        bare,
        "nothing is written without --write"
    );
    let said = scratch.run(&[&words[..], &["--json", "--write"]].concat()).succeeds().json();
    groups(&p).into_iter().for_each(|(name, truth)| near(&said, name, truth));
    assert!((said["delay"].as_f64().unwrap() - 61_234.0 / rate).abs() < 1e-3, "{}", said["delay"]);
    assert!(said["signal_to_noise_db"].as_f64().unwrap() > 35.0, "{}", said["signal_to_noise_db"]);
    assert!(why_not(&said, "resistance").contains("record the current"));
    assert!(why_not(&said, "start_volts").contains("level plane"), "{}", why_not(&said, "start_volts"));
    assert!(said["written"] == true && said["missing"].as_array().unwrap().is_empty(), "{said:#}");
    // The rig is as it was, but for the figures; and it plays.
    let text = std::fs::read_to_string(scratch.0.join("r.toml")).unwrap();
    let kept: Vec<&str> =
        text.lines().filter(|line| !line.contains("# pacinian identify take.wav: ")).collect();
    assert_eq!(kept, bare.lines().collect::<Vec<_>>());
    let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
    let motor = rig.actuator("coin").unwrap().rumble_motor().unwrap();
    assert!((motor.rated_acceleration().unwrap() / p.rated_acceleration().unwrap() - 1.0).abs() < 0.03);
    assert!((motor.mechanical_time() / p.mechanical_time() - 1.0).abs() < 0.03);
    assert!(scratch.run(&["motor", "r.toml"]).succeeds().out.contains("from the rig"));
}

/// The drive comes back on a channel, upside down and weaker: the delay is told to a part of a sample, and the time constant more closely.
#[test]
fn a_looped_back_drive_and_a_current_tell_more() {
    let scratch = Scratch::new("identify-loop");
    let part = format!("{RIG}[actuator.coin]\npart = \"constar-vc2039\"\nmass = 0.25\n{WRIST}")
        .replace("full_scale_volts = 5", "full_scale_volts = 10");
    scratch.write("r.toml", &part);
    scratch
        .run(&[
            "identify",
            "--stimulus",
            "d.wav",
            "--rig",
            "r.toml",
            "--output",
            "wrist",
            "--rate",
            "12000",
            "--volts",
            "9",
        ])
        .succeeds();
    let (rate, volts) = driven(&scratch, "d.wav", 2);
    // It is a motor of its kind, and not the one of the data sheet.
    let sheet = of_part("constar-vc2039").rumble_motor().unwrap();
    let p = Parameters {
        gravity: GRAVITY,
        inertia: 1.3e-7,
        coulomb: 5e-4,
        gain: 0.0102,
        resistance: 11.0,
        ..sheet
    };
    let volts: Vec<f64> = volts.iter().map(|v| 2.0 * v).collect();
    let [x, i] = turn(&p, rate, &volts);
    let (x, i) = (Noise(2).on(&late(&x, 3001, 500), 40.0), Noise(3).on(&late(&i, 3001, 500), 40.0));
    let back = Noise(4).on(&late(&volts, 3001, 500), 40.0);
    record(
        &scratch,
        "take.wav",
        rate,
        Encoding::F32,
        &[(&back, -77.0), (&x, 500.0), (&i, 4.0), (&back, 100.0)],
    );
    let words = [
        "identify",
        "take.wav",
        "--drive",
        "d.wav",
        "--channels",
        "drive,acceleration,current,-",
        "--current-scale",
        "4",
        "--acceleration-scale",
        "500",
        "--rig",
        "r.toml",
        "--output",
        "wrist",
        "--json",
    ];
    let said = scratch.run(&words).succeeds().json();
    groups(&p).into_iter().for_each(|(name, truth)| near(&said, name, truth));
    for (name, truth) in [
        ("resistance", p.resistance),
        ("torque_constant", p.gain),
        ("inertia", p.inertia),
        ("coulomb_friction", p.coulomb),
        ("eccentric_moment", p.eccentric),
    ] {
        near(&said, name, truth);
    }
    assert!((said["delay"].as_f64().unwrap() * rate - 3001.0).abs() < 0.2, "{}", said["delay"]);
    // With all that it is made of, how it moves follows.
    let figure =
        |name: &str| said["told"].as_array().unwrap().iter().find(|f| f["name"] == name).unwrap().clone();
    assert!(figure("time_constant")["left_out"].as_str().unwrap().contains("follows"));
    assert_eq!(figure("torque_constant")["before"], sheet.gain);
    scratch.run(&[&words[..], &["--write"]].concat()).succeeds();
    let text = std::fs::read_to_string(scratch.0.join("r.toml")).unwrap();
    let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
    let motor = rig.actuator("coin").unwrap().rumble_motor().unwrap();
    assert!((motor.mechanical_time() / p.mechanical_time() - 1.0).abs() < 0.05, "{text}");
    // Without the loop, the interval of the time constant is wider.
    let alone = scratch.run(&[
        "identify",
        "take.wav",
        "--drive",
        "d.wav",
        "--channels",
        "-,acceleration,-,-",
        "--rig",
        "r.toml",
        "--output",
        "wrist",
        "--json",
    ]);
    let alone = alone.succeeds().json();
    let width = |said: &Value| {
        let told = said["told"].as_array().unwrap();
        let interval = &told.iter().find(|f| f["name"] == "time_constant").unwrap()["interval"];
        interval[1].as_f64().unwrap() - interval[0].as_f64().unwrap()
    };
    let looped = scratch.run(&[
        "identify",
        "take.wav",
        "--drive",
        "d.wav",
        "--channels",
        "drive,acceleration,-,-",
        "--rig",
        "r.toml",
        "--output",
        "wrist",
        "--json",
    ]);
    let looped = looped.succeeds().json();
    // Both hold the truth: how much of the lateness is the coil's is left open without a loop.
    [&alone, &looped].into_iter().for_each(|said| near(said, "time_constant", p.mechanical_time()));
    assert!(
        width(&looped) < 0.7 * width(&alone),
        "{} {} {looped:#} {alone:#}",
        width(&looped),
        width(&alone)
    );
    assert!(why_not(&alone, "eccentric_per_mass").contains("--acceleration-scale"));
}

/// Terminals that are open for a while: their voltage tells the torque constant, and takes the place of the drive elsewhere.
#[test]
fn a_voltage_takes_the_place_of_the_drive() {
    let scratch = Scratch::new("identify-voltage");
    let rate = 8000.0;
    let p = Parameters { gain: 1.1e-3, ..coin() };
    let plan = Plan::choose(&p, rate, &Wish { error: 0.0, posture: true, casing: true });
    let mut motor = Motor::<false>::new(&p, &plan, rate).unwrap();
    let (mut x, mut v) = (vec![], vec![]);
    for n in 0..10_400 {
        let now = motor.reading();
        x.push(now.acceleration[0]);
        v.push(now.voltage);
        motor.drive(match n {
            0..800 => Drive::SHORT,
            800..4000 => Drive::Voltage(3.0),
            4000..7200 => Drive::Voltage(1.8),
            7200..8800 => Drive::Open,
            _ => Drive::SHORT,
        });
        motor.step();
    }
    let (x, v) = (Noise(10).on(&x, 40.0), Noise(11).on(&v, 40.0));
    record(&scratch, "take.wav", rate, Encoding::I24, &[(&v, 5.0), (&x, 60.0)]);
    let words = [
        "identify",
        "take.wav",
        "--channels",
        "voltage,acceleration",
        "--voltage-scale",
        "5",
        "--part",
        "coin-10mm",
        "--acceleration-scale",
        "60",
        "--open",
        "0.9:1.1",
        "--json",
    ];
    let said = scratch.run(&words).succeeds().json();
    groups(&p).into_iter().for_each(|(name, truth)| near(&said, name, truth));
    near(&said, "torque_constant", p.gain);
    assert!(said["drive"] == "the channel `voltage`" && said["delay_by"] == "one recording");
    let told = said["told"].as_array().unwrap();
    let k = told.iter().find(|f| f["name"] == "torque_constant").unwrap();
    assert!(k["left_out"].as_str().unwrap().contains("nothing without resistance, inertia"), "{k}");
}

/// What the command line says of a motor goes into a rig that does not say it: without the mass that moves nothing of what it shakes would be left.
#[test]
fn what_the_command_line_says_is_written_where_the_rig_lacks_it() {
    let scratch = Scratch::new("identify-given");
    let bare = format!("{RIG}[actuator.coin] # bought\nrated_volts = 3\n").replace('\n', "\r\n");
    scratch.write("r.toml", format!("\u{feff}{bare}"));
    let p = coin_take(&scratch, "take.wav", 0);
    let mass = p.casing.mass().unwrap().to_string();
    let words = [
        "identify",
        "take.wav",
        "--channels",
        "drive,acceleration,current",
        "--drive-scale",
        "10",
        "--current-scale",
        "1",
        "--acceleration-scale",
        "40",
        "--rig",
        "r.toml",
        "--actuator",
        "coin",
        "--model",
        "rumble-motor",
    ];
    let with = |more: &[&str]| scratch.run(&[&words[..], more].concat());
    let dry = with(&["--mass", &mass]);
    assert!(dry.succeeds().out.contains("coulomb_friction, model, mass\n"), "{}", dry.out);
    let said = with(&["--mass", &mass, "--write", "--json"]).succeeds().json();
    assert_eq!(said["given"][0]["value"], "rumble-motor");
    assert_eq!(said["given"][1]["value"].as_f64(), p.casing.mass());
    assert!(
        said["missing"].as_array().unwrap().is_empty()
            && said["contradictions"].as_array().unwrap().is_empty(),
        "{said:#}"
    );
    let text = std::fs::read_to_string(scratch.0.join("r.toml")).unwrap();
    assert!(text.contains("mass = 0.1  # given to pacinian identify\r\n"), "{text}");
    let kept: String =
        text.split_inclusive('\n').filter(|line| !line.contains("pacinian identify")).collect();
    assert_eq!(kept, format!("\u{feff}{bare}"), "what stood there is as it was, to the byte");
    let rig = Rig::parse("r", text.as_bytes()).unwrap().value;
    let motor = rig.actuator("coin").unwrap().rumble_motor().unwrap();
    let shakes = motor.rated_acceleration().expect("it moves as one with its casing");
    assert!((shakes / p.rated_acceleration().unwrap() - 1.0).abs() < 0.03, "{shakes}");
    // What the rig says stays, and what does not go with it is named.
    let other = scratch
        .run(&[&words[..words.len() - 2], &["--mass", "0.2", "--write", "--json"]].concat())
        .succeeds()
        .json();
    assert!(other["given"].as_array().unwrap().is_empty());
    let named = other["contradictions"][0].as_str().unwrap();
    assert!(named.contains("mass of the rig is 0.1 kg, and --mass says 0.2"), "{named}");
    let text = std::fs::read_to_string(scratch.0.join("r.toml")).unwrap();
    assert_eq!(text.matches("mass = 0.1  # given").count(), 1, "{text}");
}

/// A delay that was said wrongly would go into the time constant.
#[test]
fn a_delay_is_held_against_the_recording() {
    let scratch = Scratch::new("identify-delay");
    let p = coin_take(&scratch, "take.wav", 24);
    let with = |more: &[&str]| {
        let words = [
            "identify",
            "take.wav",
            "--channels",
            "drive,acceleration,-",
            "--drive-scale",
            "10",
            "--part",
            "coin-10mm",
            "--json",
        ];
        scratch.run(&[&words[..], more].concat())
    };
    let said = with(&["--delay", "0.003"]).succeeds().json();
    near(&said, "time_constant", p.mechanical_time());
    assert!(said["later"].is_null());
    for (wrong, shown) in [("0.1", "100.0 ms"), ("-0.05", "-50.0 ms"), ("0", "0.0 ms"), ("0.006", "6.0 ms")] {
        let both = [
            &format!("--delay is {shown}"),
            "`take.wav` the acceleration is behind the drive by 2.",
            " ms to 3.",
            "leave it out",
        ];
        with(&["--delay", wrong]).fails(65, &both);
    }
    with(&["--delay", "11"]).fails(2, &["from -1 to 10"]);
    // Where nobody says it, it is none but where the recording shows another: that is said, and left open in the interval.
    let said = with(&[]).succeeds().json();
    near(&said, "time_constant", p.mechanical_time());
    assert!((said["later"].as_f64().unwrap() - 0.003).abs() < 5e-4, "{}", said["later"]);
}
