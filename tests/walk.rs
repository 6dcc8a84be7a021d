//! A walk over the channels, piped and with somebody who says what is felt.
#![cfg(feature = "cli")]

mod program;
#[cfg(target_os = "linux")]
mod seat;

use program::Scratch;

const RIG: &str = "format = \"pacinian-rig/1\"\n[device]\nname = \"virtual\"\nchannels = 6  # three jacks\n\
    [actuator.slow]\nresonance = 65\n\
    # On the white jack.\n[[tactor]]\nname = \"left\"\nchannel = 1     # by the seam\nactuator = \"slow\"\n\
    [[tactor]]\nname = \"right\"\nchannel = 2\n[[tactor]]\nname = \"back\"\nchannel = 4\n\
    [[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 3\n";

#[test]
fn a_pipe_gets_a_line_for_each_channel() {
    let scratch = Scratch::new("walk-pipe");
    scratch.write("r.toml", RIG);
    let run = scratch.run(&["walk", "--rig", "r.toml", "--seconds", "0.1"]);
    run.succeeds();
    let lines: Vec<&str> = run.err.lines().filter(|line| line.starts_with("channel")).collect();
    let expected = [
        "channel 1: `left`, 65 Hz at level 0.25",
        "channel 2: `right`, 200 Hz at level 0.25",
        "channel 4: `back`, 200 Hz at level 0.25",
    ];
    assert_eq!(lines, expected, "{}", run.err);
    for told in [
        "walking over 3 channels of virtual card",
        "left out: `knob` on channel 3, a torque",
        "unplug what turns",
    ] {
        assert!(run.err.contains(told), "{told}: {}", run.err);
    }
    let run = scratch.run(&[
        "walk",
        "--rig",
        "r.toml",
        "--seconds",
        "0.1",
        "--only",
        "5",
        "--only",
        "back",
        "--level",
        "0.1",
    ]);
    let lines: Vec<&str> = run.succeeds().err.lines().filter(|line| line.starts_with("channel")).collect();
    assert_eq!(
        lines,
        ["channel 5: nothing in the rig, 200 Hz at level 0.10", "channel 4: `back`, 200 Hz at level 0.10"]
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let scratch = Scratch::new("walk-refused");
    scratch.write("r.toml", RIG);
    let refused = |more: &[&str], code, words: &[&str]| {
        scratch.run(&[&["walk", "--rig", "r.toml"], more].concat()).fails(code, words);
    };
    refused(&["--only", "knob"], 2, &["`knob` is no tactor but a torque, and is never buzzed"]);
    refused(&["--only", "3"], 2, &["`knob` is no tactor but a torque"]);
    refused(&["--only", "rihgt"], 2, &["no tactor `rihgt`", "`right`"]);
    refused(&["--only", "9"], 2, &["no channel 9: the device has 6"]);
    refused(&["--write"], 2, &["--write needs somebody who says what is felt"]);
    refused(&["--level", "2"], 2, &["above 0, and 1 at most"]);
    scratch.run(&["walk", "--write"]).fails(2, &["--rig"]);
    scratch.write("bad.toml", RIG.replace("channel = 2", "channel = 20"));
    scratch.run(&["walk", "--rig", "bad.toml"]).fails(78, &["bad.toml:14:11", "channel 20"]);
    scratch.run(&["walk", "--rig", "none.toml"]).fails(66, &["`none.toml` is not there"]);
}

#[cfg(target_os = "linux")]
#[test]
fn what_was_felt_goes_into_the_rig_and_nothing_else_of_it_changes() {
    let scratch = Scratch::new("walk-write");
    let path = scratch.write("r.toml", RIG);
    let command = scratch.command(&["walk", "--rig", "r.toml", "--seconds", "0.1", "--write"]);
    let Some(mut seat) = seat::Seat::new(&command) else { return };
    seat.shows("1/3  channel 1: `left`, 65 Hz at level 0.25? ");
    // A key that moves a cursor and Enter agree to nothing.
    seat.press("\x1b[C");
    std::thread::sleep(std::time::Duration::from_millis(100));
    seat.press("\r");
    seat.shows("that was not understood");
    seat.press("t");
    seat.shows("? it was");
    seat.press("rj\x7fitgh\r");
    seat.shows("? it was ritgh\n     no tactor is called `ritgh`");
    // It is still a name that is wanted, in which an `n` says nothing.
    seat.shows("Enter alone leads back\n     it was ");
    seat.press("nobody\r");
    seat.shows("it was nobody\n     no tactor is called `nobody`");
    seat.press("\r");
    seat.shows("no name, no channel");
    seat.press("tright\r");
    seat.shows("it was right\n2/3  channel 2: `right`");
    seat.press("b");
    seat.shows("? back\n1/3  channel 1");
    std::thread::sleep(std::time::Duration::from_millis(300));
    seat.press("t2\r");
    std::thread::sleep(std::time::Duration::from_millis(300));
    // It felt the first on the third channel of the walk, and nothing on the second.
    seat.press("n");
    seat.shows("? nothing\n3/3  channel 4: `back`");
    std::thread::sleep(std::time::Duration::from_millis(300));
    seat.press("y");
    // Nobody has felt where the first one hangs.
    seat.shows("write that into r.toml? y: yes   n: no ");
    seat.press("x\ry");
    seat.shows("r.toml: 2 tactors on other channels now");
    assert_eq!(seat.end().code(), Some(0));
    assert!(seat.is_given_back());
    let shown = seat.contents();
    assert!(
        shown.contains("`left` was felt nowhere, and its channel is another's: it is put on channel 2"),
        "{shown}"
    );
    let expected = RIG
        .replace("channel = 1     #", "channel = 2     #")
        .replace("\"right\"\nchannel = 2", "\"right\"\nchannel = 1");
    assert_eq!(std::fs::read_to_string(path).unwrap(), expected);
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_it_at_once_and_writes_nothing() {
    let scratch = Scratch::new("walk-stop");
    let path = scratch.write("r.toml", RIG);
    let command = scratch.command(&["walk", "--rig", "r.toml", "--seconds", "10", "--write"]);
    let Some(mut seat) = seat::Seat::new(&command) else { return };
    seat.shows("1/3  channel 1");
    seat.press("\x03");
    assert_eq!(seat.end().code(), Some(130));
    assert!(seat.is_given_back());
    assert_eq!(std::fs::read_to_string(path).unwrap(), RIG);
}

#[cfg(target_os = "linux")]
#[test]
fn a_guess_is_written_when_somebody_agrees() {
    let scratch = Scratch::new("walk-guess");
    let path = scratch.write("r.toml", RIG);
    for (key, code) in [("n", 0), ("\x03", 130)] {
        let command = scratch.command(&["walk", "--rig", "r.toml", "--seconds", "0.1", "--write"]);
        let Some(mut seat) = seat::Seat::new(&command) else { return };
        seat.shows("1/3  channel 1: `left`, 65 Hz at level 0.25? ");
        seat.press("t2\r");
        seat.shows("2/3  channel 2");
        seat.press("q");
        seat.shows("write that into r.toml? y: yes   n: no ");
        seat.press(key);
        assert_eq!(seat.end().code(), Some(code));
        assert!(seat.is_given_back());
        assert!(seat.contents().contains("`r.toml` was left alone") == (key == "n"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), RIG);
    }
}

/// Answers that are piped in, a line each.
#[cfg(unix)]
fn piped(scratch: &Scratch, answers: impl AsRef<[u8]>) -> program::Run {
    use std::io::Write;
    use std::process::Stdio;
    let mut command = scratch.command(&["walk", "--rig", "r.toml", "--seconds", "0.1", "--write"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(answers.as_ref()).unwrap();
    program::Run::of(child.wait_with_output().unwrap())
}

#[cfg(unix)]
#[test]
fn lines_are_answers_and_what_is_not_understood_is_asked_again() {
    let scratch = Scratch::new("walk-lines");
    let path = scratch.write("r.toml", RIG);
    let run = piped(&scratch, "right\nlfet\nleft\n\x1b[C\nback\x1b[D\n");
    assert!(run.succeeds().out.contains("r.toml: 2 tactors on other channels now"), "{}", run.out);
    assert!(
        run.err.contains("no tactor is called `lfet`") && run.err.contains("that was not understood"),
        "{}",
        run.err
    );
    assert!(std::fs::read_to_string(path).unwrap().contains("channel = 2     # by the seam"));
}

/// An empty pipe, bytes that are no text, a line that nobody can have typed: nothing is written, and that is told.
#[cfg(unix)]
#[test]
fn where_nothing_is_said_nothing_is_written() {
    let scratch = Scratch::new("walk-nothing");
    let path = scratch.write("r.toml", RIG);
    let long = "left".repeat(1 << 20) + "\n";
    for answers in [&b""[..], b"\xff\xfe\x00\n", long.as_bytes()] {
        let run = piped(&scratch, answers);
        assert!(run.err.len() < 4_000, "{}", run.err.len());
        run.fails(
            65,
            &["nothing was said of any channel, so `r.toml` was left alone", "pipe a line for each"],
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), RIG);
    }
}

#[cfg(unix)]
#[test]
fn what_is_not_known_is_not_said_to_be_right() {
    let scratch = Scratch::new("walk-open");
    let path = scratch.write("r.toml", RIG);
    for (answers, told) in [
        ("\n\n\n", "the rig is as it was felt"),
        (
            "y\nn\ns\n",
            "no tactor was felt elsewhere than the rig says; nothing was felt on channel 2; nothing was said of channel 4",
        ),
        ("\nq\n", "no tactor was felt elsewhere than the rig says; nothing was said of channels 2, 4"),
        // Nobody says anything any more, and an arrow is no answer.
        ("\n\x1b[A\n", "no tactor was felt elsewhere than the rig says; nothing was said of channels 2, 4"),
    ] {
        let run = piped(&scratch, answers);
        assert!(run.succeeds().out.ends_with(&format!("{told}\n")), "{answers:?}: {}", run.out);
        assert_eq!(run.err.contains("that was not understood"), answers.contains('\x1b'), "{}", run.err);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), RIG);
    }
}

#[cfg(unix)]
#[test]
fn a_tactor_that_is_felt_twice_has_the_first_channel_asked_again() {
    let scratch = Scratch::new("walk-twice");
    let path = scratch.write("r.toml", RIG);
    let run = piped(&scratch, "right\nright\n\nleft\n");
    assert!(run.succeeds().out.ends_with("the rig is as it was felt\n"), "{}", run.out);
    let told = "`right` was felt on channel 1 before, which comes again";
    assert!(run.err.contains(told) && run.err.contains("4/4  channel 1: `left`"), "{}", run.err);
    // One that was on two channels at the end is on the later one, and what is not known is not written.
    let run = piped(&scratch, "right\nleft\nright\n");
    run.fails(65, &["`r.toml` was left alone: where `back` hangs is not known", "walk over all of them"]);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), RIG);
    let run = piped(&scratch, "right\nleft\nright\nback\n");
    assert!(run.succeeds().out.ends_with("r.toml: 3 tactors on other channels now\n"), "{}", run.out);
}

/// Whoever has the rig from somebody else learns where the name is from.
#[test]
fn a_device_that_a_rig_names_and_that_is_not_there_is_told_with_the_rig() {
    let scratch = Scratch::new("walk-elsewhere");
    let rig = "format = \"pacinian-rig/1\"\n[device]\nname = \"No such card\"\nchannels = 2\n[[output]]\nname = \"t1\"\nkind = \"vibration\"\nchannel = 1\n[[output]]\nname = \"t2\"\nkind = \"vibration\"\nchannel = 2\n";
    scratch.write("rig.toml", rig);
    let words = ["no device `No such card`", "`name` under [device] in rig.toml", "--device names another"];
    for command in [&["walk"][..], &["play", "good.toml"], &["latency", "--out", "1", "--in", "1"]] {
        scratch.run(&[command, &["--rig", "rig.toml"]].concat()).fails(69, &words);
        let run = scratch.run(&[command, &["--rig", "rig.toml", "--device", "Nor such one"]].concat());
        run.fails(69, &["no device `Nor such one`"]);
        assert!(!run.err.contains("rig.toml"), "{}", run.err);
    }
}
