//! `pacinian identify`: actuators that are simulated with the project's own models, recorded with noise, identified by the program, and
//! compared with what they were made of; and everything that is no good.
#![cfg(feature = "cli")]

mod program;

use pacinian::actuator::coil::model::Model as Coil;
use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::motor::{Drive, GRAVITY, Motor, Parameters, Plan, Wish};
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::rig::{Actuator, Rig, part};
use program::{Scratch, read_wav};
use serde_json::Value;

const RIG: &str = "format = \"pacinian-rig/1\"   # mine\ntitle = \"T\"\n[device]\nchannels = 2\nfull_scale_volts = 5\ncoupling = \"dc\"\n\
    [amplifier.bridge]\ngain = 2\nmax_volts = 12\ncoupling = \"dc\"\n\n# What hangs on it.\n";
const WRIST: &str = "\n[[output]]\nkind = \"drive\"\nname = \"wrist\"\nchannel = 2\nactuator = \"coin\"\namplifier = \"bridge\"\n";
const TACTOR: &str =
    "\n[[tactor]]\nname = \"tip\"\nchannel = 1\nactuator = \"shaker\"\namplifier = \"bridge\"\n";
/// Volts for a sample of 1.0.
const SCALE: f64 = 10.0;

/// Normal deviates: a congruential generator (Knuth's multiplier), Box and Muller.
struct Noise(u64);

impl Noise {
    fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// So many decibels below the mean square of a signal.
    fn on(&mut self, x: &[f64], decibels: f64) -> Vec<f64> {
        let square = x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        let deviation = square.sqrt() * 10f64.powf(-decibels / 20.0);
        let mut normal = || (-2.0 * self.even().ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos();
        x.iter().map(|x| x + deviation * normal()).collect()
    }
}

/// What a file of one driven channel says, in volts.
fn driven(scratch: &Scratch, name: &str, channel: usize) -> (f64, Vec<f64>) {
    let (spec, samples) = read_wav(&scratch.0.join(name));
    let frames = samples.chunks(usize::from(spec.channels));
    (f64::from(spec.sample_rate), frames.map(|frame| SCALE * f64::from(frame[channel - 1])).collect())
}

/// Acceleration and current of a motor under volts.
fn turn(p: &Parameters, rate: f64, volts: &[f64]) -> [Vec<f64>; 2] {
    let plan = Plan::choose(p, rate, &Wish { error: 0.0, posture: true, casing: true });
    let mut motor = Motor::<false>::new(p, &plan, rate).unwrap();
    motor.place(0.4, 0.0);
    let mut all = [vec![], vec![]];
    for volts in volts {
        let now = motor.reading();
        all[0].push(now.acceleration[0]);
        all[1].push(now.current);
        motor.drive(Drive::Voltage(*volts));
        motor.step();
    }
    all
}

/// Some samples later, and some more behind.
fn late(x: &[f64], before: usize, behind: usize) -> Vec<f64> {
    [vec![0.0; before], x.to_vec(), vec![0.0; behind]].concat()
}

fn record(scratch: &Scratch, name: &str, rate: f64, encoding: Encoding, channels: &[(&[f64], f64)]) {
    let spec = WavSpec::new(channels.len(), rate as u32, encoding);
    let mut wav = WavWriter::create(scratch.0.join(name), spec).unwrap();
    let planar: Vec<Vec<f32>> =
        channels.iter().map(|(x, scale)| x.iter().map(|x| (x / scale) as f32).collect()).collect();
    wav.write_planar(&planar).unwrap();
    assert_eq!(wav.finish().unwrap().clipped, 0);
}

/// What is told under a name: within 3 % of the truth, and the interval holds it.
#[track_caller]
fn near(said: &Value, name: &str, truth: f64) {
    near_by(said, name, truth, 0.03);
}

#[track_caller]
fn near_by(said: &Value, name: &str, truth: f64, share: f64) {
    let told = said["told"].as_array().unwrap();
    let figure = told
        .iter()
        .find(|f| f["name"] == name)
        .unwrap_or_else(|| panic!("{name} is not told: {:#}", said["untold"]));
    let value = figure["value"].as_f64().unwrap();
    assert!((value / truth - 1.0).abs() < share, "{name} = {value}, but it is {truth}");
    let [least, most] = [0, 1].map(|n| figure["interval"][n].as_f64().unwrap());
    assert!((least..=most).contains(&truth), "{name}: {least} to {most}, but it is {truth}");
}

fn why_not<'a>(said: &'a Value, name: &str) -> &'a str {
    let all = said["untold"].as_array().unwrap();
    all.iter()
        .find(|one| one["name"] == name)
        .and_then(|one| one["why"].as_str())
        .unwrap_or_else(|| panic!("{name}: {said:#}"))
}

fn of_part(name: &str) -> Actuator {
    Actuator::of_part(part::find(name).unwrap())
}

fn coin() -> Parameters {
    Parameters { gravity: GRAVITY, ..of_part("coin-10mm").rumble_motor().unwrap() }
}

/// What the motion of a motor tells.
fn groups(p: &Parameters) -> [(&'static str, f64); 4] {
    [
        ("time_constant", p.mechanical_time()),
        ("speed_per_volt", p.gain / (p.resistance * p.damping())),
        ("running_volts", p.coulomb * p.resistance / p.gain),
        ("eccentric_per_mass", p.eccentric / p.casing.mass().unwrap()),
    ]
}

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
        text.lines().filter(|line| !line.contains("# identified from take.wav: ")).collect();
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
        ("eccentric_moment", p.eccentric),
    ] {
        near(&said, name, truth);
    }
    assert!((said["delay"].as_f64().unwrap() * rate - 3001.0).abs() < 0.2, "{}", said["delay"]);
    // A rotor that is fast beside its coil tells less of its dry friction, and says so by the interval.
    near_by(&said, "coulomb_friction", p.coulomb, 0.08);
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
    assert!(text.contains("# guessed; identified from take.wav: "), "{text}");
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

/// Each kind of recording that is no good, and each thing that the command line leaves open: field, limit, and what to do.
#[test]
fn what_is_no_good_is_named() {
    let scratch = Scratch::new("identify-bad");
    scratch.write(
        "r.toml",
        format!("{RIG}[actuator.coin]\npart = \"coin-10mm\"\n{WRIST}{}", TACTOR.replace("shaker", "coin")),
    );
    scratch.write("two.toml", format!("{RIG}[actuator.a]\nmodel = \"lra\"\n[actuator.b]\nmodel = \"piezo\"\n[actuator.c]\nresonance = 3\n"));
    scratch.write(
        "ac.toml",
        format!("{RIG}[actuator.coin]\npart = \"coin-10mm\"\n").replacen("\"dc\"", "{ high_pass = 8 }", 1),
    );
    scratch
        .run(&["identify", "--stimulus", "d.wav", "--rig", "r.toml", "--output", "wrist", "--rate", "4000"])
        .succeeds();
    let (rate, volts) = driven(&scratch, "d.wav", 2);
    let [x, _] = turn(&coin(), rate, &volts);
    let good = Noise(8).on(&x, 40.0);
    let put = |name: &str, x: &[f64], rate: f64| record(&scratch, name, rate, Encoding::F32, &[(x, 40.0)]);
    put("good.wav", &good, rate);
    put("silent.wav", &vec![0.01; good.len()], rate);
    let clipped: Vec<f64> = good.iter().map(|x| x.clamp(-8.0, 8.0)).collect();
    put("clipped.wav", &clipped, rate);
    put("short.wav", &good[..40], rate);
    put("early.wav", &good[..2240], rate);
    put("other.wav", &good, 8000.0);
    put(
        "hiss.wav",
        &Noise(9).on(&vec![1e-3; good.len()], -40.0).iter().map(|x| x.clamp(-0.9, 0.9)).collect::<Vec<_>>(),
        rate,
    );
    put("still.wav", &vec![0.0; good.len()], rate);
    record(&scratch, "two.wav", rate, Encoding::F32, &[(&good, 100.0), (&good, 100.0)]);
    scratch.write("no.wav", "no wave at all");
    let mut bytes = std::fs::read(scratch.0.join("good.wav")).unwrap();
    let end = bytes.len();
    bytes[end - 400..end - 396].copy_from_slice(&f32::NAN.to_le_bytes());
    scratch.write("nan.wav", bytes);
    let rig = ["--rig", "r.toml", "--output", "wrist"];
    let drive = ["--drive", "d.wav"];
    scratch.run(&[&["identify", "good.wav"][..], &drive, &rig].concat()).succeeds();
    for (words, code, said) in [
        (
            &["silent.wav", "--drive", "d.wav"][..],
            65,
            &["`silent.wav`: `acceleration` is silent", "above 0", "turn it up"][..],
        ),
        (
            &["clipped.wav", "--drive", "d.wav"],
            65,
            &["`clipped.wav`: `acceleration` is clipped", "less than 2 times", "turn it down"],
        ),
        (
            &["short.wav", "--drive", "d.wav"],
            65,
            &["`short.wav`: the recording is too short", "s of it belong to the drive"],
        ),
        (
            &["early.wav", "--drive", "d.wav"],
            65,
            &["`early.wav`: the recording is too short", "s of turning", "are needed"],
        ),
        (
            &["other.wav", "--drive", "d.wav"],
            65,
            &["`other.wav` has 8,000 Hz, but the drive `d.wav` has 4,000 Hz", "--rate"],
        ),
        (
            &["hiss.wav", "--drive", "d.wav"],
            65,
            &["`hiss.wav`: `acceleration` has", "at least 6.0 dB", "is that what was played?"],
        ),
        (&["nan.wav", "--drive", "d.wav"], 65, &["`nan.wav`", "is NaN, which is no number"]),
        (&["no.wav", "--drive", "d.wav"], 65, &["`no.wav`"]),
        (&["none.wav", "--drive", "d.wav"], 66, &["`none.wav`"]),
        (&["good.wav", "--drive", "none.wav"], 66, &["`none.wav`"]),
        (&["good.wav", "--drive", "still.wav"], 65, &["the drive `still.wav` is silent"]),
        (
            &["good.wav", "--drive", "two.wav"],
            2,
            &["several channels of `two.wav` are driven: 1, 2", "--drive-channel 1"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--drive-channel", "3"],
            65,
            &["2 channels, so there is no channel 3"],
        ),
        (&["good.wav"], 2, &["what drove it is not known", "--drive FILE.wav"]),
        (&["two.wav", "--drive", "d.wav"], 2, &["`two.wav` has 2 channels", "--channels acceleration,-"]),
        (
            &["two.wav", "--drive", "d.wav", "--channels", "acceleration,current,-"],
            2,
            &["names 3 channels, but `two.wav` has 2"],
        ),
        (
            &["two.wav", "--drive", "d.wav", "--channels", "acceleration"],
            2,
            &["names 1 channel, but `two.wav` has 2"],
        ),
        (&["two.wav", "--drive", "d.wav", "--channels", "drive,-"], 2, &["has no acceleration"]),
        (
            &["two.wav", "--drive", "d.wav", "--channels", "acceleration,acceleration"],
            2,
            &["names acceleration twice"],
        ),
        (&["two.wav", "--drive", "d.wav", "--channels", "acceleration,speed"], 2, &["speed"]),
        (
            &["two.wav", "--drive", "d.wav", "--channels", "acceleration,current"],
            2,
            &["of the current is in A", "--current-scale A"],
        ),
        (
            &["two.wav", "--drive", "d.wav", "--channels", "acceleration,drive"],
            65,
            &["looped-back drive of `two.wav` is not `d.wav`"],
        ),
        (
            &["two.wav", "--channels", "acceleration,drive"],
            2,
            &["looped-back drive stands for is not known", "--drive-scale V"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--delay", "0.1"],
            2,
            &["--delay is counted from", "--channels drive,acceleration"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--open", "1:2"],
            2,
            &["--open is for motors whose voltage was recorded"],
        ),
        (&["good.wav", "--drive", "d.wav", "--open", "2:1"], 2, &["such as 1.5:1.9"]),
        (&["good.wav", "--drive", "d.wav", "--mass", "-1"], 65, &["`mass` is -1, but must be above 0"]),
        (&["good.wav", "--drive", "d.wav", "--acceleration-scale", "0"], 2, &["from 1e-9 to 1e9"]),
        (&["good.wav", "--drive", "d.wav", "--model", "lra"], 2, &["is of model rumble-motor, not lra"]),
        (&["--stimulus", "x.wav", "--volts", "9"], 2, &["9 V are more than the 3.0000 V", "--volts 2.9"]),
        (&["--stimulus", "x.wav", "--volts", "nan"], 2, &["`volts` is NaN"]),
        (&["--stimulus", "x.mp3"], 2, &["sound is WAV, not mp3"]),
        (&["--stimulus", "r.toml"], 2, &["`r.toml` is read for this"]),
        (&["--stimulus", "no/x.wav"], 73, &["no/x.wav"]),
    ] {
        let run = scratch.run(&[&["identify"][..], words, &rig].concat());
        run.fails(code, said);
    }
    for (words, code, said) in [
        (
            &["good.wav", "--drive", "d.wav"][..],
            2,
            &["what it is that moves is not known", "--part PART"][..],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--model", "lra"],
            2,
            &["how many volts a sample of 1.0 is at lra", "--drive-scale V"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--part", "coin-11mm"],
            2,
            &["no part `coin-11mm`", "`coin-10mm`"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--rig", "r.toml", "--output", "wirst"],
            2,
            &["no output `wirst`", "`wrist`"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--rig", "r.toml", "--actuator", "cion"],
            2,
            &["no actuator `cion`", "`coin`"],
        ),
        (
            &["good.wav", "--drive", "d.wav", "--rig", "two.toml"],
            2,
            &["several actuators: a, b, c", "--actuator a"],
        ),
        (&["good.wav", "--drive", "d.wav", "--rig", "two.toml", "--actuator", "b"], 78, &["model piezo"]),
        (
            &["good.wav", "--drive", "d.wav", "--rig", "two.toml", "--actuator", "c"],
            78,
            &["nothing says what", "--model lra"],
        ),
        (&["good.wav", "--drive", "d.wav", "--rig", "none.toml"], 66, &["none.toml"]),
        (&["good.wav", "--drive", "d.wav", "--part", "coin-10mm", "--write"], 2, &["--rig"]),
        (&["--stimulus", "x.wav", "--rig", "ac.toml"], 78, &["high-pass at 8 Hz", "DC-coupled"]),
        (
            &["--stimulus", "x.wav", "--model", "lra", "--drive-scale", "5"],
            2,
            &["how many volts lra bears", "--volts V"],
        ),
        (&[], 2, &["RECORDING"]),
    ] {
        scratch.run(&[&["identify"][..], words].concat()).fails(code, said);
    }
    assert!(!scratch.0.join("x.wav").exists());
}
