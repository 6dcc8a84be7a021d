//! Through the program.

use crate::program::Scratch;
use pacinian::actuator::motor::{Drive, GRAVITY, Level, Motor, Parameters, Plan};
use pacinian::feel::{Feel, Wish};
use pacinian::rig::{Actuator, Rig, part};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn shipped(path: &str) -> String {
    format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))
}

/// The file holds what the library makes of the rendering, to the bit; so does JSON.
#[test]
fn the_file_is_what_the_library_makes_of_the_rendering() {
    let scratch = Scratch::new("feel");
    let (patch, rig) = (shipped("patches/30-motor.toml"), shipped("rigs/motors.toml"));
    let base = ["render", &patch, "--rig", &rig, "-o", "x.wav"];
    let plain = scratch.run(&[&base[..], &["--json"]].concat()).succeeds().json();
    assert!(plain["feel"].is_null());
    let (_, alone) = scratch.wav("x.wav");
    let words = ["--feel", "felt.wav", "--feel-error", "1e-4"];
    let said = scratch.run(&[&base[..], &words, &["--json"]].concat()).succeeds().json();
    let (spec, sent) = scratch.wav("x.wav");
    // How soon it is noticed that nothing rings any more may differ.
    let both = sent.len().min(alone.len());
    assert!(sent[..both] == alone[..both] && both > 3 * 48_000 * 2, "nothing of the rendering is changed");
    let rig = Rig::parse("r", &std::fs::read(&rig).unwrap()).unwrap().value;
    let mut feel = Feel::new(&rig, 3, f64::from(spec.sample_rate), &Wish { error: 1e-4 }).unwrap();
    let mut due = Vec::new();
    feel.process(&sent, &mut due);
    let (is, felt) = scratch.wav("felt.wav");
    assert_eq!((is.channels, is.sample_rate, is.bits_per_sample), (5, spec.sample_rate, 32));
    assert!(felt == due && felt.iter().any(|x| x.abs() > 10.0), "figures beyond 1 stay");
    let bytes = std::fs::read(scratch.0.join("felt.wav")).unwrap();
    let head = String::from_utf8_lossy(&bytes[..2000]).into_owned();
    for words in ["what is felt, figures in m/s2", "1: fingertip, contactor, m/s2", "3: wrist, upright, m/s2"]
    {
        assert!(head.contains(words), "{words}");
    }
    let said = &said["feel"];
    assert_eq!((&said["file"], &said["error"]), (&"felt.wav".into(), &1e-4.into()));
    assert_eq!(said["frames"].as_u64(), Some(sent.len() as u64 / 3));
    let (channels, outputs) = (said["channels"].as_array().unwrap(), said["outputs"].as_array().unwrap());
    assert_eq!((channels.len(), outputs.len()), (5, 3));
    assert_eq!(channels[4]["output"], "grip");
    for (said, felt) in outputs.iter().zip(feel.felt()) {
        let figures = felt.figures();
        for (key, due) in [
            ("peak", Some(figures.peak)),
            ("peak_at", Some(figures.peak_at)),
            ("rms", Some(figures.rms)),
            ("farthest", figures.farthest),
            ("fastest", figures.fastest),
            ("energy", figures.energy),
        ] {
            assert_eq!(said[key].as_f64(), due, "{key} of {}", felt.output);
        }
        assert_eq!(said["output"], felt.output.as_str());
        assert_eq!(said["channel"], felt.channel as u64 + 1);
        assert_eq!(said["level"].is_null(), felt.level().is_none());
    }
    let text = scratch.run(&[&base[..], &words].concat()).succeeds().out.clone();
    for words in [
        "felt.wav, what is felt",
        "2, 3  wrist: across, upright, m/s2",
        "nobody said how the device is held (`grip`)",
        "of the 10 figures of `coin` nobody measured any",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// A rendering of the way home and clicks after it: by what the casing does, the mass stands when the drive of each is over. As if it lay flat, it would not.
#[test]
fn what_is_felt_of_a_click_after_the_way_home_ends_with_its_drive() {
    let scratch = Scratch::new("feel-home");
    let rig = shipped("rigs/motors.toml");
    let of = |home: bool| {
        let event = |at: f64, voice: &str| {
            format!("{{ at = {at:?}, voice = \"{voice}\", place = \"wrist\", duration = 0.05 }}, ")
        };
        let events = [event(1.0, "click"), event(1.3, "back"), event(1.6, "thump")].concat();
        let home = if home { event(0.0, "home") } else { String::new() };
        let patch = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"Home\"\n[voice.home]\noutput = \"go\"\n[voice.home.nodes]\ngo = {{ type = \"drive-home\" }}\n\
             [voice.click]\noutput = \"go\"\n[voice.click.nodes]\ngo = {{ type = \"drive-click\" }}\n\
             [voice.back]\noutput = \"go\"\n[voice.back.nodes]\ngo = {{ type = \"drive-click\", turns = -0.25 }}\n\
             [voice.thump]\noutput = \"go\"\n[voice.thump.nodes]\ngo = {{ type = \"drive-click\", turns = 1 }}\n\
             [pattern.p]\ntime = \"seconds\"\nevents = [{home}{events}]\n"
        );
        scratch.write("home.toml", &patch);
        let words =
            ["render", "home.toml", "--rig", &rig, "-o", "x.wav", "--duration", "2", "--feel", "f.wav"];
        scratch.run(&[&words[..], &["--feel-error", "1e-6"]].concat()).succeeds();
        let ((spec, sent), (_, felt)) = (scratch.wav("x.wav"), scratch.wav("f.wav"));
        // Across and upright are channels 2 and 3 of 5.
        let moves: Vec<f64> = felt.chunks(5).map(|frame| f64::from(frame[1].hypot(frame[2]))).collect();
        let rate = f64::from(spec.sample_rate);
        let coin = Actuator::of_part(part::find("coin-10mm").unwrap()).rumble_motor().unwrap();
        let coin = Parameters { gravity: GRAVITY, ..coin };
        let mut motor = Motor::<false>::new(&coin, &Plan::whole(Level::Fine), rate).unwrap();
        let (mut speeds, mut pulls) = (Vec::new(), Vec::new());
        for frame in sent.chunks(3) {
            motor.drive(Drive::Voltage(12.5 * f64::from(frame[0])));
            motor.step();
            speeds.push(motor.speed().abs());
            pulls.push((motor.speed() * motor.speed()).hypot(motor.angular_acceleration()));
        }
        [1.0, 1.3, 1.6].map(|at| {
            let window = (at * rate) as usize..((at + 0.3) * rate) as usize;
            // Forward first, of which the first frame may be less; then backward as much, until it is not any more.
            let given: Vec<f32> =
                sent.chunks(3).map(|frame| frame[0]).skip(window.start).take(window.len()).collect();
            let full = *given.iter().filter(|x| x.abs() > 0.02).nth(1).unwrap();
            let back = given.iter().position(|x| x / full < -0.999).unwrap();
            let over = window.start + back + given[back..].iter().position(|x| x / full > -0.999).unwrap();
            let [peak, most] =
                [&speeds, &pulls].map(|all| all[window.clone()].iter().fold(0.0_f64, |m, x| m.max(*x)));
            // What is felt is what such a motor does.
            let felt = moves[window.clone()].iter().fold(0.0_f64, |most, x| most.max(*x));
            for n in (window.start..over).step_by(37) {
                assert!(
                    (moves[n] / felt - pulls[n] / most).abs() < 0.01,
                    "{at} {n}: {} {}",
                    moves[n] / felt,
                    pulls[n] / most
                );
            }
            speeds[over] / peak
        })
    };
    let (known, flat) = (of(true), of(false));
    println!("{known:?} {flat:?}");
    assert!(
        known.iter().all(|left| *left < 0.005) && flat.iter().all(|left| *left > 0.005),
        "{known:?} {flat:?}"
    );
}

/// A bracelet of known coils behind a jack; what is not known of the others is told beside.
#[test]
fn what_is_known_is_felt_and_the_rest_is_told() {
    let scratch = Scratch::new("feel-some");
    let bracelet = std::fs::read_to_string(shipped("rigs/bracelet.toml")).unwrap();
    let measured = bracelet.replace("[device]\n", "[device]\nfull_scale_volts = 1.0\n");
    let known = "[actuator.known]\npart = \"vybronics-vg0832013d\"\n[[tactor]]";
    let known =
        measured.replacen("[[tactor]]", known, 1).replacen("actuator = \"coil\"", "actuator = \"known\"", 1);
    scratch.write("some.toml", known);
    let run = scratch.run(&["render", "good.toml", "--rig", "some.toml", "-o", "x.wav", "--feel", "f.wav"]);
    let place = &run.err;
    assert!(run.code == Some(65) && place.contains("t2"), "the patch means t2: {place}");
    let patch =
        std::fs::read_to_string(scratch.0.join("good.toml")).unwrap().replace("\"t2\"", "\"outside\"");
    scratch.write("wrist.toml", patch);
    let base = ["render", "wrist.toml", "--rig", "some.toml", "-o", "x.wav", "--feel", "f.wav"];
    let text = scratch.run(&base).succeeds().out.clone();
    for words in [
        "1  inside: casing, m/s2",
        "`outside`: actuator `coil` (voice-coil) lacks `resistance`",
        "lets steady voltages through",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let said = scratch.run(&[&base[..], &["--json"]].concat()).succeeds().json();
    assert_eq!(said["feel"]["not_felt"][0]["output"], "outside");
    assert_eq!(scratch.wav("f.wav").0.channels, 1);
    // Of the shipped bracelet nothing is: everything that is missing, once, at its line.
    scratch.write("bracelet.toml", bracelet);
    let run =
        scratch.run(&["render", "wrist.toml", "--rig", "bracelet.toml", "-o", "y.wav", "--feel", "g.wav"]);
    run.fails(
        78,
        &[
            "nothing is felt: of no output of bracelet.toml",
            "full_scale_volts",
            "bracelet.toml:23:1",
            "`pacinian parts`",
        ],
    );
    assert_eq!(run.err.matches("lacks").count(), 1, "{}", run.err);
    assert!(!scratch.0.join("y.wav").exists() && !scratch.0.join("g.wav").exists());
}

#[test]
fn what_makes_no_sense_is_refused_before_a_file_is_made() {
    let scratch = Scratch::new("feel-no");
    let (patch, rig) = (shipped("patches/30-motor.toml"), shipped("rigs/motors.toml"));
    let run = |words: &[&str]| {
        let run = scratch.run(&[&["render", &patch, "--rig", &rig, "-o", "x.wav"], words].concat());
        assert!(!scratch.0.join("x.wav").exists() && !scratch.0.join("f.wav").exists());
        run
    };
    run(&["--feel", "x.wav"]).fails(2, &["meant for something else", "--feel"]);
    run(&["--feel", "./x.wav"]).fails(2, &["meant for something else"]);
    run(&["--feel", "l.wav", "--log", "l.wav"]).fails(2, &["meant for something else"]);
    run(&["--feel", &rig]).fails(2, &["--feel"]);
    run(&["--feel", "-"]).fails(2, &["standard output"]);
    run(&["--feel", "f.csv"]).fails(2, &["WAV", "f.wav"]);
    run(&["--feel", "no/f.wav"]).fails(73, &["no"]);
    run(&["--feel-error", "0.1"]).fails(2, &["--feel"]);
    for error in ["0", "-1", "nan", "2"] {
        run(&["--feel", "f.wav", "--feel-error", error]).fails(2, &["--feel-error", "0.5"]);
    }
    scratch
        .run(&["render", "good.toml", "-o", "x.wav", "--feel", "f.wav"])
        .fails(2, &["without a rig", "--rig"]);
}

/// A motor behind a carrier, on a headphone jack: what is felt is as long as what is sent, and it is told how that was computed; `check` says what a click
/// comes to where that is far from what was ordered, and nothing where it is near.
#[test]
fn a_carrier_is_felt_and_what_clicks_come_to_is_told() {
    let scratch = Scratch::new("feel-carrier");
    let (patch, rig) = (shipped("patches/32-headphone.toml"), shipped("rigs/carrier.toml"));
    let base = ["render", &patch, "--rig", &rig, "-o", "x.wav", "--feel", "f.wav"];
    let text = scratch.run(&base).succeeds().out.clone();
    for words in
        ["2, 3  palm: across, upright, m/s2", "16 steps a frame (`palm`)", "as a converter joins them"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("more than was wished for"), "{text}");
    let (_, sent) = scratch.wav("x.wav");
    let (_, felt) = scratch.wav("f.wav");
    assert!(sent.len() / 2 == felt.len() / 3 && felt.iter().any(|x| x.abs() > 5.0));
    let short = [&base[..], &["--feel-error", "1e-7", "--duration", "0.1", "--json"]].concat();
    let said = scratch.run(&short).succeeds().json();
    let [finger, palm] = [0, 1].map(|n| &said["feel"]["outputs"][n]);
    assert!(palm["reaches"].as_f64().is_some_and(|reaches| reaches > 1e-6 && reaches < 1e-4));
    assert!(palm["joined"] == true && finger["joined"] == false && finger["reaches"].is_null());
    let text = scratch.run(&short[..short.len() - 1]).succeeds().out.clone();
    assert!(text.contains("(`palm`), more than was wished for"), "{text}");

    let small = std::fs::read_to_string(&patch).unwrap().replace("turns = 1.0", "turns = 0.05");
    scratch.write("small.toml", small);
    let half = std::fs::read_to_string(&rig).unwrap();
    scratch
        .write("half.toml", half.replace("carrier = 4000.0", "rectifier = \"half-wave\"\ncarrier = 2000.0"));
    let told = |rig: &str| {
        let words = ["check", "small.toml", "--rig", rig];
        let said = scratch.run(&[&words[..], &["--json"]].concat()).succeeds().json();
        let outputs = said["plan"]["outputs"].as_array().unwrap();
        let push = &outputs.iter().find(|o| o["name"] == "palm").unwrap()["motor"]["pushes"][0];
        let reaches = [0, 1].map(|n| push["reaches"][n].as_f64().unwrap());
        assert_eq!(push["turns"], 0.05);
        (scratch.run(&words).succeeds().out.clone(), reaches)
    };
    let (text, [least, most]) = told(&rig);
    assert!(least > 0.0475 && least < most && most < 0.0525 && !text.contains("reaches"), "{least} {most}");
    let (text, [least, most]) = told("half.toml");
    assert!(least < 0.0475 && least > 0.03 && least < most, "{least} {most}");
    let words = format!("reaches {} of them (at level", format!("{least:.2e}").parse::<f64>().unwrap());
    assert!(text.contains("a click of 0.05 turns reaches") && text.contains(&words), "{words}: {text}");
}

/// A resonance of 60 Hz and a quality of 150 rings for seconds after its voice: both files go on until 1 % of it is left, and where somebody says how long
/// they are, what they cut off is told.
#[test]
fn what_rings_on_is_not_cut_off() {
    let scratch = Scratch::new("feel-rings");
    scratch.write(
        "rings.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 2.0\n[actuator.l]\nmodel = \"lra\"\nresonance = 60\nq = 150\n\
         rated_volts = 2\nrated_acceleration = 3\ntest_mass = 0.1\ndevice_mass = 2.5e-3\nslug_mass = 1.5e-3\nresistance = 2000\n\
         [[tactor]]\nname = \"l\"\nchannel = 1\nactuator = \"l\"\n",
    );
    scratch.write(
        "tone.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.a]\noutput = \"o\"\n[voice.a.nodes]\ns = { type = \"sine\", frequency = 60 }\n\
         e = { type = \"envelope\", attack = 0.01, release = 0.01 }\no = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n\
         [pattern.p]\nevents = [{ at = 0, voice = \"a\", duration = 0.3 }]\n",
    );
    let base = ["render", "tone.toml", "--rig", "rings.toml", "-o", "x.wav"];
    scratch.run(&base).succeeds();
    assert!(scratch.wav("x.wav").1.len() < 48_000, "without --feel nobody waits for it");
    let words = [&base[..], &["--feel", "f.wav"]].concat();
    let run = scratch.run(&words);
    assert!(!run.succeeds().out.contains("where the file ends"), "{}", run.out);
    let ([x, f], rate) = (["x.wav", "f.wav"].map(|name| scratch.wav(name).1), 48_000.0);
    assert_eq!(x.len(), f.len());
    // e^(−π f t / Q) is 1 % after 3.66 s; what is looked back, and the block in which it is noticed, come beside.
    let seconds = f.len() as f64 / rate;
    let due = 0.31 + 150.0 / (60.0 * std::f64::consts::PI) * 100f64.ln();
    assert!((due..due + 0.25).contains(&seconds), "{seconds} {due}");
    let most = |part: &[f32]| part.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    assert!(most(&f[f.len() - 800..]) < 0.0101 * most(&f));
    let short = [&words[..], &["--duration", "0.4"]].concat();
    let run = scratch.run(&short);
    assert!(run.succeeds().out.contains("m/s2 where the file ends"), "{}", run.out);
    let said = scratch.run(&[&short[..], &["--json"]].concat()).succeeds().json();
    let felt = scratch.wav("f.wav").1;
    let last = said["feel"]["outputs"][0]["last"].as_f64().unwrap();
    let crest = f64::from(most(&felt[felt.len() - 800..]));
    assert!((0.99 * crest..1.1 * crest).contains(&last), "{last} {crest}");
}

/// Ctrl-C leaves both complete, and as long as each other.
#[test]
fn both_files_are_complete_when_it_is_stopped() {
    let scratch = Scratch::new("feel-stop");
    let (patch, rig) = (shipped("patches/30-motor.toml"), shipped("rigs/motors.toml"));
    let words = ["render", &patch, "--rig", &rig, "-o", "x.wav", "--feel", "f.wav", "--duration", "1e6"];
    let mut child = scratch.command(&words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    while !std::fs::metadata(scratch.0.join("f.wav")).is_ok_and(|f| f.len() > 100_000) {
        assert!(child.try_wait().unwrap().is_none() && begin.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let run = crate::program::Run::of(child.wait_with_output().unwrap());
    run.fails(130, &["`x.wav` and `f.wav` are complete up to"]);
    let frames = |name: &str, channels: usize| scratch.wav(name).1.len() / channels;
    assert!(frames("x.wav", 3) == frames("f.wav", 5) && frames("x.wav", 3) > 10_000);
}
