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
    seat.see("1/3  channel 1: `left`, 65 Hz at level 0.25? ");
    seat.press("ritgh\n");
    seat.see("no tactor is called `ritgh`");
    seat.press("right\n");
    seat.see("2/3  channel 2: `right`");
    seat.press("b\n");
    seat.see("? b\n1/3  channel 1");
    std::thread::sleep(std::time::Duration::from_millis(300));
    seat.press("2\n");
    std::thread::sleep(std::time::Duration::from_millis(300));
    // It felt the first on the third channel of the walk, and nothing on the second.
    seat.press("n\n");
    seat.see("3/3  channel 4: `back`");
    std::thread::sleep(std::time::Duration::from_millis(300));
    seat.press("\n");
    seat.see("r.toml: 2 tactors on other channels now");
    assert_eq!(seat.end(), Some(0));
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
    seat.see("1/3  channel 1");
    seat.press("\x03");
    assert_eq!(seat.end(), Some(130));
    assert_eq!(std::fs::read_to_string(path).unwrap(), RIG);
}
