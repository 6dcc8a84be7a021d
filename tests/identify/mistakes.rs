//! Recordings that are no good, and command lines that leave something open.

use super::program::Scratch;
use super::{Noise, RIG, TACTOR, WRIST, coin, driven, record, turn};
use pacinian::actuator::identify::stimulus::steps;
use pacinian::io::wav::Encoding;

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
    put("steady.wav", &vec![0.3; good.len()], rate);
    let mut bytes = std::fs::read(scratch.0.join("steady.wav")).unwrap();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&1e30_f32.to_le_bytes());
    scratch.write("vast.wav", bytes);
    record(&scratch, "many.wav", rate, Encoding::F32, &vec![(&good[..100], 100.0); 100]);
    record(&scratch, "two.wav", rate, Encoding::F32, &[(&good, 100.0), (&good, 100.0)]);
    scratch.write("no.wav", "no wave at all");
    let mut bytes = std::fs::read(scratch.0.join("good.wav")).unwrap();
    let end = bytes.len();
    bytes[end - 400..end - 396].copy_from_slice(&f32::NAN.to_le_bytes());
    scratch.write("nan.wav", bytes);
    // The rate of its header, and the bytes a second that go with it.
    let mut bytes = std::fs::read(scratch.0.join("good.wav")).unwrap();
    let at = bytes.windows(4).position(|four| four == 4000_u32.to_le_bytes()).unwrap();
    bytes[at..at + 4].copy_from_slice(&4_000_000_000_u32.to_le_bytes());
    scratch.write("fast.wav", bytes);
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
            &["good.wav", "--drive", "steady.wav"],
            65,
            &["`steady.wav`: `drive` is ", " all the time, but must change"],
        ),
        (&["good.wav", "--drive", "vast.wav"], 65, &["`vast.wav`: `drive` is no number at sample "]),
        (
            &["many.wav", "--drive", "d.wav"],
            2,
            &["has 100 channels", "acceleration,-,-,-,-,-,-,-,-,-,-,-,-,-,-,-,-,..., say"],
        ),
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
        (&["good.wav", "--drive", "d.wav", "--mass", "-1"], 2, &["from 1e-9 to 1e6 kg: weigh it"]),
        (&["good.wav", "--drive", "d.wav", "--mass", "1e-300"], 2, &["from 1e-9 to 1e6 kg: weigh it"]),
        (
            &["good.wav", "--drive", "d.wav", "--share", "1"],
            2,
            &["--share is for coils", "leave --share out"],
        ),
        (
            &["fast.wav", "--drive", "d.wav"],
            65,
            &[
                "`fast.wav` has 4,000,000,000 Hz by its header",
                "from 10 Hz to 10,000,000 Hz",
                "write the file anew",
            ],
        ),
        (&["good.wav", "--drive", "fast.wav"], 65, &["`fast.wav` has 4,000,000,000 Hz by its header"]),
        (&["good.wav", "--drive", "d.wav", "--acceleration-scale", "0"], 2, &["from 1e-9 to 1e9"]),
        (&["good.wav", "--drive", "d.wav", "--model", "lra"], 2, &["is of model rumble-motor, not lra"]),
        (
            &["--stimulus", "x.wav", "--volts", "1e-300"],
            2,
            &["1e-300 V are less than a card can give", "--volts V"],
        ),
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

/// A recording that ends before its drive has done much: neither the drive nor the accelerometer is to blame.
#[test]
fn what_ends_too_soon_is_too_short() {
    let scratch = Scratch::new("identify-soon");
    let rate = 8000.0;
    let p = coin();
    let volts = steps(3.0, p.mechanical_time(), rate).unwrap();
    let first = volts.iter().position(|v| *v != 0.0).unwrap();
    record(&scratch, "d.wav", rate, Encoding::F32, &[(&volts, 10.0)]);
    let [x, i] = turn(&p, rate, &volts);
    let (hiss, x) = (Noise(3).on(&vec![1.0; x.len()], 40.0), Noise(4).on(&x, 40.0));
    let whole = format!("is {:.3} s long", volts.len() as f64 / rate);
    let rests = format!("rests until {:.3} s", first as f64 / rate);
    for length in [0, 1, 63, 80, first - 1, first, first + 1, first + 80] {
        // A take of silence alone, of noise, and of what was to be recorded.
        let silent = vec![0.0; length];
        for x in [&silent[..], &hiss[..length], &x[..length]] {
            record(
                &scratch,
                "t.wav",
                rate,
                Encoding::F32,
                &[(x, 40.0), (&i[..length], 1.0), (&volts[..length], 10.0)],
            );
            for channels in ["acceleration,-,-", "acceleration,current,-", "acceleration,current,drive"] {
                let words = [
                    "identify",
                    "t.wav",
                    "--drive",
                    "d.wav",
                    "--channels",
                    channels,
                    "--part",
                    "coin-10mm",
                    "--drive-scale",
                    "10",
                    "--acceleration-scale",
                    "40",
                    "--current-scale",
                    "1",
                ];
                let said = ["`t.wav`: the recording is too short", &rests, &whole, "record all of the drive"];
                let none = ["`t.wav`", "it holds no samples at all", "record it again"];
                scratch.run(&words).fails(65, if length == 0 { &none[..] } else { &said[..] });
            }
        }
    }
}
