//! How strongly something is felt: decibels above the threshold, by the calibration of each tactor, from the file to the skin.
#![cfg(feature = "cli")]

mod common;

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use common::{channel, rendered, run, schedule};
use pacinian::engine::Engine;
use pacinian::engine::event::Play;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::io::wav::WavReader;
use pacinian::node::asset::NoAssets;
use pacinian::report::measure;
use pacinian::space::spot::Spot;
use pacinian::{Note, Patch, Player, Rig, io};

const RATE: f64 = 48_000.0;
const VOLTS: f64 = 1.4;

const RIG: &str = r#"format = "pacinian-rig/1"
title = "Unequal"
[device]
channels = 5
full_scale_volts = 1.4
coupling = { high_pass = 6.0 }
[amplifier.board]
gain = 2.0
[amplifier.coil]
gain = -0.3
drive = "current"
[actuator.peaky]
equaliser = [{ frequency = 150, gain_db = 5, q = 1.5 }, { frequency = 70, gain_db = -8, q = 3 }]
[calibration.finger]
date = 2026-03-14
method = "laser vibrometer on the contactor, on the fingertip, 0.5 N"
site = "fingertip"
area = 2e-5
unit = "um/V"
table = [[40, 61.0], [100, 48.5], [250, 22.1], [400, 6.0]]
[calibration.palm]
date = "2026-03-15"
method = "accelerometer, on the palm"
area = 3e-4
unit = "g/V"
table = "palm.csv"
[calibration.current]
date = "2026-03-15"
method = "laser vibrometer, velocity"
area = 1e-5
unit = "mm/s/A"
table = [[35, 300.0], [300, 410.0], [900, 190.0]]
[calibration.whole]
date = "2026-03-16"
method = "laser vibrometer, from the card on"
area = 1e-4
unit = "um/FS"
table = [[20, 90.0], [1000, 1.5]]
[[tactor]]
name = "finger"
channel = 1
position = [0.0, 0.0]
calibration = "finger"
amplifier = "board"
actuator = "peaky"
[[tactor]]
name = "palm"
channel = 2
position = [0.04, 0.0]
site = "palm"
calibration = "palm"
amplifier = "board"
gain = 0.5
polarity = -1
[[tactor]]
name = "current"
channel = 3
calibration = "current"
amplifier = "coil"
site = "thenar"
[[tactor]]
name = "whole"
channel = 4
calibration = "whole"
site = "thenar"
gain = 3.0
[[tactor]]
name = "nobody"
channel = 5
"#;

const PALM: &str = "frequency,coherence,output\n30,0.99,0.35\n120,0.99,2.5\n500,0.97,9.0\n";

const VOICE: &str =
    "[voice.v]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n";

struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-felt-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("rig.toml"), RIG).unwrap();
        std::fs::write(folder.join("palm.csv"), PALM).unwrap();
        Self(folder)
    }

    fn rig(&self) -> Rig {
        io::load::rig(self.0.join("rig.toml")).unwrap_or_else(|p| panic!("{p}")).value
    }

    fn patch(&self, text: &str) -> PathBuf {
        let path = self.0.join("patch.toml");
        std::fs::write(&path, format!("format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}{text}"))
            .unwrap();
        path
    }

    fn pacinian(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_pacinian")).args(words).current_dir(&self.0).output().unwrap()
    }

    /// What `check` says, on both streams.
    fn check(&self, text: &str) -> (Option<i32>, String) {
        self.patch(text);
        let output = self.pacinian(&["check", "patch.toml", "--rig", "rig.toml"]);
        let said = [output.stderr, output.stdout].map(|said| String::from_utf8(said).unwrap()).concat();
        (output.status.code(), said)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The threshold of the glabrous hand by the published slopes, m: 12 dB an octave down to 250 Hz and up again, flat where that is above what it is at
/// 40 Hz, and 3 dB for each doubling of the area against 2.9 cm².
fn threshold(hertz: f64, area: f64) -> f64 {
    let slope = 40.0 * (hertz / 250.0).log10();
    let up = slope.max(0.0) * 12.0 / (40.0 * 2f64.log10());
    let pacinian = -20.0 - 10.0 * (area / 2.9e-4).log10() + if slope < 0.0 { -slope } else { up };
    1e-6 * 10f64.powf(pacinian.min(11.8) / 20.0)
}

/// What a table says, straight in dB over the logarithm of the frequency.
fn table(points: &[[f64; 2]], hertz: f64) -> f64 {
    let pair = points.windows(2).find(|pair| hertz >= pair[0][0] && hertz <= pair[1][0]).unwrap();
    let share = (hertz / pair[0][0]).ln() / (pair[1][0] / pair[0][0]).ln();
    pair[0][1].powf(1.0 - share) * pair[1][1].powf(share)
}

/// Metres for a sample of 1 that leaves on a channel.
fn metres(channel: usize, hertz: f64) -> f64 {
    let omega = TAU * hertz;
    let coupling = hertz / hertz.hypot(6.0);
    match channel {
        0 => {
            VOLTS
                * 2.0
                * coupling
                * table(&[[40.0, 61e-6], [100.0, 48.5e-6], [250.0, 22.1e-6], [400.0, 6e-6]], hertz)
        }
        1 => {
            let g = table(&[[30.0, 0.35], [120.0, 2.5], [500.0, 9.0]], hertz);
            VOLTS * 2.0 * coupling * g * 9.80665 / (omega * omega)
        }
        2 => VOLTS * 0.3 * coupling * table(&[[35.0, 0.3], [300.0, 0.41], [900.0, 0.19]], hertz) / omega,
        _ => table(&[[20.0, 90e-6], [1000.0, 1.5e-6]], hertz),
    }
}

const AREAS: [f64; 4] = [2e-5, 3e-4, 1e-5, 1e-4];

/// The amplitude of a sine of that frequency in frames that hold it steadily, by least squares over whole periods.
fn amplitude(signal: &[f64], hertz: f64) -> f64 {
    let periods = (signal.len() as f64 * hertz / RATE).floor();
    let length = (periods * RATE / hertz).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, x) in signal[..length].iter().enumerate() {
        let (sin, cos) = (TAU * hertz * n as f64 / RATE).sin_cos();
        (re, im) = (re + x * cos, im + x * sin);
    }
    2.0 * re.hypot(im) / length as f64
}

fn read(path: &Path) -> Vec<f32> {
    let mut frames = Vec::new();
    let mut reader = WavReader::open(path).unwrap();
    reader
        .each_frame(|frame| {
            frames.extend_from_slice(frame);
            Ok(())
        })
        .unwrap();
    frames
}

/// From the WAV back through full scale, amplifier, coupling and table, the displacement is as far above the threshold as was said.
#[test]
fn what_is_rendered_is_felt_as_strongly_as_was_said() {
    let scratch = Scratch::new("rendered");
    let names = ["finger", "palm", "current", "whole"];
    // On points of the tables and between them; the last as a default of its voice, at a frequency that the voice says.
    let cases = [
        (0, 40.0, 12.0),
        (0, 100.0, 20.0),
        (0, 180.0, 26.5),
        (0, 250.0, 20.0),
        (0, 400.0, -3.0),
        (1, 50.0, 6.0),
        (1, 120.0, 20.0),
        (1, 312.5, 31.0),
        (2, 60.0, 8.0),
        (2, 300.0, 20.0),
        (2, 700.0, 10.0),
        (3, 125.0, 20.0),
        (3, 500.0, 12.0),
    ];
    let mut events = String::new();
    for (n, (tactor, hertz, felt)) in cases.iter().enumerate() {
        events += &format!(
            "{{ at = {n}, voice = \"v\", felt = {felt}, frequency = {hertz}, duration = 0.8, place = \"{}\" }},\n",
            names[*tactor]
        );
    }
    let last = cases.len();
    events += &format!("{{ at = {last}, voice = \"own\", duration = 0.8, place = \"whole\" }},\n");
    let own = "[voice.own]\noutput = \"s\"\nfelt_at = 90\ndefaults = { felt = 15 }\nnodes.s = { type = \"sine\", frequency = 90 }\n";
    let text = format!("{own}[pattern.p]\nevents = [\n{events}]\n");
    let (code, said) = scratch.check(&text);
    assert!(code == Some(0) && !said.contains("warning") && said.contains("calibrated 2026-03-15"), "{said}");
    let output = scratch.pacinian(&["render", "patch.toml", "--rig", "rig.toml", "-o", "out.wav"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let frames = read(&scratch.0.join("out.wav"));
    for (n, &(tactor, hertz, felt)) in cases.iter().chain([&(3, 90.0, 15.0)]).enumerate() {
        let signal = channel(&frames, 5, tactor);
        let steady = &signal[((n as f64 + 0.3) * RATE) as usize..((n as f64 + 0.75) * RATE) as usize];
        let displacement = amplitude(steady, hertz) * metres(tactor, hertz);
        let above = 20.0 * (displacement / threshold(hertz, AREAS[tactor])).log10();
        assert!((above - felt).abs() < 0.01, "{} at {hertz} Hz: {above} dB, not {felt}", names[tactor]);
    }
}

fn plan(scratch: &Scratch, text: &str, live: bool) -> Plan {
    let bytes = format!("format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}{text}");
    let patch = Patch::parse("p.toml", bytes.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live, ..Options::default() };
    scene(&patch, &scratch.rig(), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Amplitudes of displacement over the threshold, of the channels that are calibrated.
fn over(frames: &[f32], hertz: f64) -> [f64; 4] {
    [0, 1, 2, 3].map(|c| {
        let signal = channel(frames, 5, c);
        amplitude(&signal[(0.2 * RATE) as usize..(0.75 * RATE) as usize], hertz) * metres(c, hertz)
            / threshold(hertz, AREAS[c])
    })
}

/// Between two unequal tactors the law shares out what is felt: by energy the sum of squares stays, and at a place each has the share of the published law.
#[test]
fn a_place_between_unequal_tactors_keeps_what_is_felt() {
    let scratch = Scratch::new("place");
    for (law, share) in [
        ("energy", (|w: f64| w.sqrt()) as fn(f64) -> f64),
        ("linear", |w| w),
        ("logarithmic", |w| (1.0 + w).log2()),
    ] {
        let text = format!(
            "[voice.w]\noutput = \"s\"\nlaw = \"{law}\"\nnodes.s = {{ type = \"sine\", frequency = \"event.frequency\" }}\n"
        );
        let plan = plan(&scratch, &text, true);
        for (hertz, felt) in [(60.0, 8.0), (250.0, 25.0)] {
            for part in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let fields = [("felt", felt), ("frequency", hertz)];
                let place = Spot::Point([0.04 * part, 0.0, 0.0]);
                let play = Play { place, id: 1, duration: 0.8, ..plan.play("w", &fields).unwrap() };
                let is = over(&rendered(&plan, &[(0.0, play)], 0.0).1, hertz);
                let full = 10f64.powf(felt / 20.0);
                for (is, weight) in is.iter().zip([1.0 - part, part]) {
                    assert!((is / full - share(weight)).abs() < 1e-3, "{law} {part}: {is} of {full}");
                }
                if law == "energy" {
                    let power = 10.0 * (is[0] * is[0] + is[1] * is[1]).log10();
                    assert!((power - felt).abs() < 0.01, "{part} {hertz}: {power}");
                }
                assert!(is[2] < 1e-9 && is[3] < 1e-9);
            }
        }
    }
}

/// A voice on its way is felt, on every tactor that it passes, as strongly as one that stays there: where it comes to rest by the published law, and
/// all the way as its reference has it, which works its gains out half a million times a second.
#[test]
fn what_moves_is_felt_as_strongly_as_what_stays() {
    let scratch = Scratch::new("moving");
    let way = |path: &str, times: &str| {
        let nodes = "tone = { type = \"sine\", frequency = \"event.frequency\" }\nedge = { type = \"envelope\", attack = 0.02, release = 0.02 }\n\
                     s = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }";
        format!(
            "[voice.w]\noutput = \"s\"\nplace = {{ path = [{path}], times = [{times}] }}\n[voice.w.nodes]\n{nodes}\n"
        )
    };
    for (hertz, felt) in [(60.0, 8.0), (250.0, 25.0)] {
        let fields = [("felt", felt), ("frequency", hertz)];
        let rests = plan(&scratch, &way("[-0.02, 0], [0.016, 0], [0.016, 0]", "0, 0.15, 0.8"), true);
        let play = Play { id: 1, duration: 0.8, ..rests.play("w", &fields).unwrap() };
        let is = over(&rendered(&rests, &[(0.0, play)], 0.0).1, hertz);
        let full = 10f64.powf(felt / 20.0);
        for (is, weight) in is.iter().zip([0.6_f64, 0.4]) {
            assert!((is / full - weight.sqrt()).abs() < 1e-3, "{hertz}: {is} of {full}");
        }
        for speed in [0.2, 5.0] {
            let leg = 0.06 / speed;
            let there = |n: usize| if n.is_multiple_of(2) { "[-0.01, 0]" } else { "[0.05, 0]" };
            let points: Vec<_> = (0..=(0.3 / leg) as usize + 1).map(there).collect();
            let times: Vec<String> = (0..points.len()).map(|n| (leg * n as f64).to_string()).collect();
            let plan = plan(&scratch, &way(&points.join(", "), &times.join(", ")), true);
            let play = Play { id: 1, duration: 0.25, ..plan.play("w", &fields).unwrap() };
            let error = measure(&plan, &[(0.0123, play)], 0.3).unwrap().comparison.error_db;
            assert!(error < -80.0, "{hertz} Hz at {speed} m/s: {error} dB");
        }
    }
}

/// A level beside it scales it, as the gain of a pattern does; what is beyond a limit is capped; motions of time do not matter.
#[test]
fn levels_scale_and_limits_cap() {
    let scratch = Scratch::new("levels");
    let plan = plan(&scratch, "", true);
    let at = |fields: &[(&str, f64)]| {
        let play = Play { place: Spot::Row(0), id: 1, duration: 0.8, ..plan.play("v", fields).unwrap() };
        over(&rendered(&plan, &[(0.0, play)], 0.0).1, 100.0)[0]
    };
    let whole = at(&[("frequency", 100.0), ("felt", 20.0)]);
    let half = at(&[("frequency", 100.0), ("felt", 20.0), ("level", 0.5)]);
    assert!((whole / half - 2.0).abs() < 1e-4 && (whole - 10.0).abs() < 0.01, "{whole} {half}");
    // What the limiter lets pass as it is, and no more.
    let most = 0.9 * metres(0, 100.0) / threshold(100.0, AREAS[0]);
    // The onset still keeps the limiter a little.
    for felt in [60.0, 120.0] {
        let capped = at(&[("frequency", 100.0), ("felt", felt)]);
        assert!((20.0 * (capped / most).log10()).abs() < 0.1, "{capped} {most}");
    }
    // Above 475 Hz that is less; `whole` was measured from the card on.
    for (hertz, share) in [(600.0, 0.85), (700.0, 0.765), (800.0, 0.688), (850.0, 0.67)] {
        let fields = [("frequency", hertz), ("felt", 120.0)];
        let play = Play { place: Spot::Row(3), id: 1, duration: 0.8, ..plan.play("v", &fields).unwrap() };
        let signal = channel(&rendered(&plan, &[(0.0, play)], 0.0).1, 5, 3);
        let own = metres(3, hertz) / threshold(hertz, AREAS[3]);
        let capped = amplitude(&signal[(0.2 * RATE) as usize..(0.75 * RATE) as usize], hertz) * own;
        let most = share * own;
        assert!((20.0 * (capped / most).log10()).abs() < 0.1, "{hertz}: {capped} {most}");
        let told = plan.gauges[3].as_ref().unwrap().most(hertz);
        assert!((20.0 * most.log10() - told).abs() < 0.01, "{hertz}: {told}");
    }
    let by_level = plan.play("v", &[("level", 0.3)]).unwrap();
    assert_eq!((by_level.felt, by_level.level), (None, 0.3));
}

#[test]
fn any_cut_gives_the_same_bits() {
    let scratch = Scratch::new("cuts");
    let plan = plan(&scratch, "", true);
    let rendered = |calls: &[usize]| {
        let mut engine = Engine::new(&plan).unwrap();
        let one = |n: u32| {
            let fields = [("felt", f64::from(n % 30) - 5.0), ("frequency", 40.0 + 7.0 * f64::from(n))];
            let place = if n.is_multiple_of(3) {
                Spot::Point([0.001 * f64::from(n), 0.0, 0.0])
            } else {
                Spot::Row(n % 5)
            };
            (
                f64::from(n) * 61.37,
                Play { place, id: u64::from(n), duration: 0.03, ..plan.play("v", &fields).unwrap() },
            )
        };
        let events: Vec<(f64, Play)> = (0..40).map(one).collect();
        schedule(&mut engine, &events);
        run(&mut engine, 24_000, calls).iter().map(|x| x.to_bits()).collect::<Vec<u32>>()
    };
    let whole = rendered(&[24_000]);
    for calls in [&[1][..], &[7], &[64], &[3, 1000, 1, 17, 250]] {
        assert!(rendered(calls) == whole, "in calls of {calls:?}");
    }
}

/// Programs and messages are refused what nobody can know.
#[test]
fn what_cannot_be_known_is_refused_when_it_is_played() {
    let scratch = Scratch::new("refused");
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[voice.fixed]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 80 }}\n"
    );
    let patch = Patch::parse("p", text.as_bytes()).unwrap().value;
    let options = Options { live: true, ..Options::default() };
    let mut player = Player::new(&patch, &scratch.rig(), &options, &NoAssets).unwrap();
    let note = |hertz: f64| Note::default().felt(20.0).frequency(hertz).at_place("finger");
    assert!(player.play("v", &note(100.0)).is_ok());
    let mut told = |voice: &str, note: &Note| player.play(voice, note).unwrap_err().to_string();
    let high = told("v", &note(401.0));
    assert!(high.contains("`finger` at 401 Hz: its calibration goes from 40 to 400 Hz"), "{high}");
    assert!(told("v", &note(100.0).level(0.5)).contains("`level` and `felt` at once"));
    assert!(told("fixed", &note(100.0)).contains("felt_at"));
    assert!(told("v", &Note::default().felt(f64::NAN)).contains("not a number"));
    let point = told("v", &Note { place: Some(pacinian::Place::Position([0.0; 3])), ..note(30.0) });
    assert!(point.contains("nothing is extrapolated"), "{point}");
}

#[test]
fn every_mistake_is_told_at_its_line() {
    let scratch = Scratch::new("mistakes");
    let event = |keys: &str| format!("[pattern.p]\nevents = [{{ at = 0, voice = \"v\", {keys} }}]\n");
    let fixed = "[voice.f]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 80 }\n";
    let cases = [
        (event("felt = 20, level = 0.5"), 7, "has `level` and `felt` at once"),
        (event("felt = 500"), 7, "a number from -60 to 120"),
        (event("felt = nan"), 7, "a number from -60 to 120"),
        (event("felt = 20, frequency = 39.9, place = \"finger\""), 7, "its calibration goes from 40 to 400 Hz"),
        (event("felt = 20, frequency = 1500, place = \"nobody\""), 7, "thresholds are given from 10 to 1000 Hz"),
        (event("felt = 20, frequency = -3, place = \"nobody\""), 7, "thresholds are given"),
        (format!("{fixed}[pattern.p]\nevents = [{{ at = 0, voice = \"f\", felt = 3 }}]\n"), 10, "felt_at = 80"),
        (format!("{fixed}defaults = {{ felt = 3 }}\n"), 9, "felt_at = 80"),
        ("[voice.d]\noutput = \"s\"\ndefaults = { felt = 3, level = 1 }\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n".into(), 8, "at once"),
        ("[[trigger]]\non = \"osc./x\"\nplay = \"v\"\nset = { felt = \"value\", level = 1 }\n".into(), 9, "at once"),
        ("[[trigger]]\non = \"start\"\nplay = \"v\"\nset = { felt = 400 }\n".into(), 9, "from -60 to 120"),
        (format!("{fixed}[[trigger]]\non = \"osc./x\"\nplay = \"f\"\nset = {{ felt = \"value\" }}\n"), 12, "felt_at = 80"),
        (event("felt = 20").replace("voice = \"v\"", "marker = \"m\""), 7, "a marker has no `felt`"),
        ("[voice.d]\noutput = \"s\"\ndefaults = { felt = 3 }\nfelt_at = 2000\nnodes.s = { type = \"white\" }\n".into(), 9, "a number from 10 to 1000"),
    ];
    for (text, line, wanted) in cases {
        let (code, said) = scratch.check(&text);
        assert!(
            code == Some(65) && said.contains(&format!("patch.toml:{line}:")) && said.contains(wanted),
            "{text}: {said}"
        );
    }
    std::fs::write(
        scratch.0.join("e.csv"),
        "at,voice,felt,frequency,place\n0,v,20,100,finger\n1,v,20,30,finger\n2,v,,30,finger\n",
    )
    .unwrap();
    let (code, said) = scratch.check("[pattern.p]\nevents = \"e.csv\"\n");
    assert!(code == Some(65) && said.contains("e.csv:3:5") && said.contains("from 40 to 400 Hz"), "{said}");
    std::fs::write(scratch.0.join("e.csv"), "at,voice,felt,level\n0,v,20,1\n").unwrap();
    assert!(scratch.check("[pattern.p]\nevents = \"e.csv\"\n").1.contains("e.csv:2:5"));
}

#[test]
fn rigs_that_cannot_be_are_told_at_their_line() {
    let head = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n";
    let of = |keys: &str| {
        format!(
            "{head}full_scale_volts = 1\n[calibration.c]\n{keys}\n[[tactor]]\nname = \"t\"\nchannel = 1\ncalibration = \"c\"\n"
        )
    };
    let good = "date = 2026-03-14\nmethod = \"laser\"\narea = 2e-5\nunit = \"um/V\"\n";
    let table = "table = [[50, 1], [60, 2]]";
    let cases = [
        (of(&format!("{good}table = []")), 10, "without points"),
        (of(&format!("{good}table = [[50, 1]]")), 10, "1 point says nothing"),
        (of(&format!("{good}table = [[50, 1], [40, 1]]")), 10, "sort the points"),
        (of(&format!("{good}table = [[50, 1], [50, 1]]")), 10, "twice"),
        (of(&format!("{good}table = [[50, nan], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[nan, 1], [60, 1]]")), 10, "is no frequency"),
        (of(&format!("{good}table = [[50, 1e300], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[50, 0], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[50, 1, 2], [60, 1]]")), 10, "it must be a pair"),
        (of(&format!("{good}table = [[50, \"1\"], [60, 1]]")), 10, "it must be a pair"),
        (of(&format!("{good}table = 5")), 10, "a list of pairs"),
        (of(good), 5, "lacks `table`"),
        (of(&format!("{table}\n{}", good.replace("date = 2026-03-14\n", ""))), 5, "lacks `date`"),
        (
            of(&format!("{table}\n{}", good.replace("2026-03-14", "\"last week\""))),
            7,
            "it must be a day: 2026-03-14",
        ),
        (
            of(&format!("{table}\n{}", good.replace("2026-03-14", "2026-03-14T10:00:00"))),
            7,
            "it must be a day",
        ),
        (of(&format!("{table}\n{}", good.replace("laser", " "))), 8, "says nothing"),
        (of(&format!("{table}\n{}", good.replace("um/V", "um"))), 10, "`unit`"),
        (of(&format!("{table}\n{}", good.replace("2e-5", "20"))), 9, "`area`"),
        (
            of(&format!("{good}{table}")).replace("calibration = \"c\"", "calibration = \"d\""),
            11,
            "did you mean `c`?",
        ),
        (of(&format!("{good}{table}")).replace("full_scale_volts = 1\n", ""), 10, "full_scale_volts"),
        (of(&format!("{good}{table}").replace("um/V", "um/A")), 11, "does not impose"),
        (of(&format!("{good}{table}\nsite = \"nose\"")), 11, "`site`"),
    ];
    for (text, line, wanted) in cases {
        let problems = Rig::parse("r.toml", text.as_bytes()).map(|_| ()).unwrap_err().to_string();
        assert!(
            problems.contains(&format!("r.toml:{line}:")) && problems.contains(wanted),
            "{text}\n{problems}"
        );
    }
    // Over full scale nothing else need be known; and a rig whose table was not read is refused where it is needed, and only there.
    let whole = of(&format!("{good}{table}").replace("um/V", "um/FS")).replace("full_scale_volts = 1\n", "");
    assert!(Rig::parse("r.toml", whole.as_bytes()).is_ok());
    let unread = Rig::parse("r.toml", RIG.as_bytes()).unwrap().value;
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[pattern.p]\nevents = [{{ at = 0, voice = \"v\" }}]\n"
    );
    let patch = |text: &str| Patch::parse("p", text.as_bytes()).unwrap().value;
    let options = Options::default();
    assert!(scene(&patch(&text), &unread, &options, &NoAssets).is_ok());
    let felt = text.replace("voice = \"v\" }", "voice = \"v\", felt = 3, place = \"palm\" }");
    let told = scene(&patch(&felt), &unread, &options, &NoAssets).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`palm.csv` was not read"), "{told}");
}

/// A table that is not there, or cannot be, is told where the rig names it, or at its line.
#[test]
fn files_of_tables_are_checked_with_the_rig() {
    let scratch = Scratch::new("tables");
    let event = "[pattern.p]\nevents = [{ at = 0, voice = \"v\", felt = 10, place = \"palm\" }]\n";
    std::fs::write(scratch.0.join("palm.csv"), "frequency,output\n30,1\n20,1\n").unwrap();
    let (code, said) = scratch.check(event);
    assert!(code == Some(78) && said.contains("palm.csv:3:1") && said.contains("sort the points"), "{said}");
    std::fs::remove_file(scratch.0.join("palm.csv")).unwrap();
    let (code, said) = scratch.check(event);
    assert!(
        code == Some(78) && said.contains("rig.toml:26:9") && said.contains("`palm.csv` is not there"),
        "{said}"
    );
}

#[test]
fn check_tells_what_is_capped_and_who_was_not_measured() {
    let scratch = Scratch::new("told");
    let (code, said) =
        scratch.check("[pattern.p]\nevents = [{ at = 0, voice = \"v\", felt = 60, place = \"finger\" }]\n");
    let most = 20.0 * (0.9 * metres(0, 250.0) / threshold(250.0, AREAS[0])).log10();
    let wanted = format!(
        "60 dB of voice `v` at 250 Hz is {:.1} dB more than `finger` can give: it gives {most:.1} dB at most",
        60.0 - most
    );
    assert!(
        code == Some(0) && said.contains(&wanted) && said.contains("patch.toml:7:41"),
        "{wanted}: {said}"
    );
    assert!(!said.contains("is relative there"), "{said}");
    let (_, said) = scratch.check(
        "[pattern.p]\nevents = [{ at = 0, voice = \"v\", felt = 20, place = [\"finger\", \"nobody\"] }]\n",
    );
    assert!(
        said.contains("`nobody` is not calibrated: `felt` is relative there, and not to be compared"),
        "{said}"
    );
    // So it is where only whoever sets it off knows how strong it is.
    let (_, said) = scratch
        .check("[[trigger]]\non = \"midi.note\"\nplay = \"v\"\nplace = \"nobody\"\nset = { felt = \"10 + 20 * velocity\" }\n");
    assert!(said.contains("`nobody` is not calibrated") && !said.contains("more than"), "{said}");
    std::fs::write(
        scratch.0.join("e.csv"),
        "at,voice,felt,place\n0,v,20,finger\n1,v,70,finger\n2,v,80,finger\n",
    )
    .unwrap();
    let (_, said) = scratch.check("[pattern.p]\nevents = \"e.csv\"\n");
    assert!(
        said.contains("e.csv:3:5") && said.contains("70 dB of voice `v`") && !said.contains("80 dB"),
        "{said}"
    );
    let (_, said) = scratch.check("[pattern.p]\nevents = [{ at = 0, voice = \"v\" }]\n");
    assert!(!said.contains("warning"), "{said}");
}

/// Three in a row, 40 mm apart, of which the middle one is weak.
fn weak_in_the_middle(middle: &str) -> String {
    let mut rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\n".to_string();
    for (name, micrometres) in [("strong", 1000), ("weak", 1)] {
        rig += &format!(
            "[calibration.{name}]\ndate = 2026-03-14\nmethod = \"laser\"\narea = 1e-4\nunit = \"um/FS\"\ntable = [[20, {micrometres}], [1000, {micrometres}]]\n"
        );
    }
    for (n, (name, calibration)) in [("a", "strong"), ("b", middle), ("c", "strong")].into_iter().enumerate()
    {
        let calibration =
            if calibration.is_empty() { String::new() } else { format!("calibration = \"{calibration}\"\n") };
        rig += &format!(
            "[[tactor]]\nname = \"{name}\"\nchannel = {}\nposition = [{}, 0]\n{calibration}",
            n + 1,
            0.04 * n as f64
        );
    }
    rig
}

/// Along a path, and in the bursts of a stroke, a tactor that is passed counts with the share that it has there, not with that of the ends.
#[test]
fn check_tells_what_is_capped_on_the_way() {
    let scratch = Scratch::new("way");
    std::fs::write(scratch.0.join("rig.toml"), weak_in_the_middle("weak")).unwrap();
    let most = 20.0 * (0.9e-6 / threshold(250.0, 1e-4)).log10();
    // At the ends it has half the power, 3 dB less.
    let event = |felt: f64, keys: &str| {
        format!("[pattern.p]\nevents = [{{ at = 0, voice = \"v\", felt = {felt:.3}, {keys} }}]\n")
    };
    for (keys, share) in [
        ("duration = 1, place = { path = [[0.02, 0], [0.06, 0]] }", "share of the path"),
        ("stroke = { path = [[0.02, 0], [0.06, 0]], over = 2.0 }", "share of the place"),
        ("apparent = { places = [\"a\", \"b\"], burst = 0.6 }", "dB more than `b` can give:"),
        ("saltation = { places = [\"a\", \"b\"] }", "dB more than `b` can give:"),
    ] {
        let (code, said) = scratch.check(&event(most + 2.0, keys));
        let wanted = format!("it gives {most:.1} dB at most");
        assert!(code == Some(0) && said.contains("2.0 dB more than `b` can give"), "{keys}: {said}");
        assert!(said.contains(&wanted) && said.contains(share), "{keys}: {said}");
        assert_eq!(said.matches("can give").count(), 1, "once for an event: {said}");
        let (_, said) = scratch.check(&event(most - 0.2, keys));
        assert!(!said.contains("can give"), "{keys}: {said}");
    }
    // Who is passed and was not measured is told.
    std::fs::write(scratch.0.join("rig.toml"), weak_in_the_middle("")).unwrap();
    for keys in [
        "duration = 1, place = { path = [[0.02, 0], [0.06, 0]] }",
        "stroke = { path = [[0.02, 0], [0.06, 0]], over = 2.0 }",
    ] {
        let (_, said) = scratch.check(&event(10.0, keys));
        assert!(
            said.contains("b is not calibrated") || said.contains("`b` is not calibrated"),
            "{keys}: {said}"
        );
    }
}

/// Short events above 60 Hz are told in one line, with what they are likely felt weaker by: 10 log10 of 1 s over their duration at most.
#[test]
fn check_tells_once_that_short_events_are_felt_weaker() {
    let scratch = Scratch::new("short");
    let event = |at: u32, seconds: f64, hertz: u32| {
        format!(
            "{{ at = {at}, voice = \"v\", felt = 10, duration = {seconds}, frequency = {hertz}, place = \"finger\" }},\n"
        )
    };
    let long = format!("[pattern.p]\nevents = [\n{}{}]\n", event(0, 0.1, 60), event(1, 0.5, 250));
    let (code, said) = scratch.check(&long);
    assert!(code == Some(0) && !said.contains("warning"), "{said}");
    let events: String = [(0.1, 250), (0.3, 250), (0.1, 50), (0.9, 250)]
        .iter()
        .zip(0..)
        .map(|(&(seconds, hertz), at)| event(at, seconds, hertz))
        .collect();
    let (code, said) = scratch.check(&format!("[pattern.p]\nevents = [\n{events}]\n"));
    assert!(code == Some(0) && said.matches("felt weaker than said").count() == 1, "{said}");
    assert!(
        said.contains("2 events with `felt` above 60 Hz, shorter than 0.5 s")
            && said.contains("by 4 to 10 dB at the shortest (voice `v`, 0.100 s at 250 Hz)"),
        "{said}"
    );
    // In beats, and in a file: 0.2 beats at 120 a minute.
    std::fs::write(
        scratch.0.join("e.csv"),
        "at,voice,felt,duration,place\n0,v,10,0.2,finger\n1,v,10,2,finger\n",
    )
    .unwrap();
    let (_, said) = scratch.check("[pattern.p]\ntime = \"beats\"\ntempo = 120\nevents = \"e.csv\"\n");
    assert!(said.contains("1 event with `felt` above 60 Hz") && said.contains("0.100 s at 250 Hz"), "{said}");
}

/// What nothing comes through to is not felt, calibrated or not.
#[test]
fn an_output_without_gain_is_refused() {
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[pattern.p]\nevents = [{{ at = 0, voice = \"v\", felt = 10 }}]\n"
    );
    let patch = Patch::parse("p", text.as_bytes()).unwrap().value;
    let mut rig = Rig::default_for(2);
    rig.outputs[1].gain = 0.0;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let said = scene(&patch, &rig, &options, &NoAssets)
        .err()
        .map(|problems| problems.to_string())
        .unwrap_or_default();
    assert!(said.contains("output `t2` has a `gain` of 0"), "{said}");
}

/// Without any calibration it is relative: a level of 1 at 250 Hz counts for 40 dB.
#[test]
fn without_a_calibration_it_keeps_the_shape_alone() {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}");
    let patch = Patch::parse("p", text.as_bytes()).unwrap().value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let plan = scene(&patch, &Rig::default_for(5), &options, &NoAssets).unwrap().plan;
    let at = |felt: f64, hertz: f64| {
        let play =
            Play { id: 1, duration: 0.8, ..plan.play("v", &[("felt", felt), ("frequency", hertz)]).unwrap() };
        let signal = channel(&rendered(&plan, &[(0.0, play)], 0.0).1, 5, 0);
        amplitude(&signal[(0.2 * RATE) as usize..(0.75 * RATE) as usize], hertz)
    };
    assert!((at(34.0, 250.0) - 10f64.powf(-0.3)).abs() < 1e-3 && (at(20.0, 250.0) - 0.1).abs() < 2e-4);
    let due = threshold(500.0, 2.9e-4) * 500f64.powi(2) / (threshold(250.0, 2.9e-4) * 250f64.powi(2));
    assert!((at(10.0, 500.0) / at(10.0, 250.0) / due - 1.0).abs() < 1e-3, "{due}");
}

/// Events that are over before their actuator has risen are told once for each voice and actuator, at the shortest.
#[test]
fn check_tells_of_events_that_are_too_short_to_rise() {
    let scratch = Scratch::new("rise");
    let lra = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 2.0\n[actuator.lra]\nmodel = \"lra\"\nresonance = 175.0\nq = 15.0\n\
        rated_volts = 2.0\nrated_acceleration = 12.0\ntest_mass = 0.1\ndevice_mass = 2.5e-3\nslug_mass = 1.5e-3\nresistance = 25.0\n\
        [[tactor]]\nname = \"a\"\nchannel = 1\nactuator = \"lra\"\n[[tactor]]\nname = \"b\"\nchannel = 2\nactuator = \"lra\"\n";
    std::fs::write(scratch.0.join("rig.toml"), lra).unwrap();
    // 2.303 · 15 / (π · 175 Hz) = 62.8 ms.
    let events = "[pattern.p]\ntime = \"beats\"\ntempo = 120\nevents = [\n{ at = 0, voice = \"v\", duration = 0.1 },\n{ at = 1, voice = \"v\", duration = 0.04, place = \"b\" },\n\
        { at = 2, voice = \"v\", duration = 1 },\n]\n";
    let (code, said) = scratch.check(events);
    let wanted =
        "the shortest event of voice `v` on `b` lasts 20.0 ms; its actuator `lra` takes 63 ms to 90 %";
    assert!(code == Some(0) && said.contains(wanted) && said.contains("patch.toml:11:"), "{said}");
    assert!(said.matches("takes 63 ms").count() == 1 && said.contains("even_out = {}"), "{said}");
    let long = events.replace("0.04", "0.13").replace("0.1 }", "0.2 }");
    assert!(!scratch.check(&long).1.contains("takes"), "long enough");
    // Of an events file, at its first line that is too short.
    std::fs::write(scratch.0.join("e.csv"), "at,voice,duration\n0,v,0.2\n1,v,0.1\n2,v,0.05\n").unwrap();
    let (code, said) = scratch.check("[pattern.p]\ntime = \"beats\"\ntempo = 120\nevents = \"e.csv\"\n");
    let wanted = "an event of voice `v` on `a` lasts 50.0 ms; its actuator `lra` takes 63 ms";
    assert!(code == Some(0) && said.contains(wanted) && said.contains("e.csv:3:"), "{said}");
    assert_eq!(said.matches("takes 63 ms").count(), 1, "{said}");
    std::fs::write(
        scratch.0.join("rig.toml"),
        lra.replace("resistance = 25.0\n", "resistance = 25.0\neven_out = {}\n"),
    )
    .unwrap();
    let said = scratch.check(events).1;
    assert!(!said.contains("even_out = {}"), "{said}");
}
