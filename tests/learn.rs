//! Learning what moves a control, over real UDP.
#![cfg(feature = "cli")]

mod program;
#[cfg(target_os = "linux")]
mod seat;

use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::process::{Child, ChildStderr, Stdio};

use program::Scratch;
use rosc::{OscMessage, OscPacket, OscType, encoder};

const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"   # a title\n[control.depth]\ndefault = 0.5\n\
    [control.rate]\ndefault = 3\nrange = [1, 10]\nunit = \"Hz\"\n\n# By hand.\n[[bind]]\nfrom = \"osc./old\" # for now\ncontrol = \"rate\"\n\
    pickup = false\n\n[voice.hum]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"100 * rate\", amplitude = \"depth\" } # last\n";

/// Somebody with an OSC surface.
struct Surface(UdpSocket, String);

impl Surface {
    fn at(address: &str) -> Self {
        Self(UdpSocket::bind("127.0.0.1:0").unwrap(), address.into())
    }

    fn say(&self, addr: &str, value: impl Into<OscType>) {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args: vec![value.into()] });
        self.0.send_to(&encoder::encode(&packet).unwrap(), &self.1).unwrap();
    }

    fn move_fader(&self, addr: &str) {
        (0..50).for_each(|n| self.say(addr, n as f32 / 50.0));
    }
}

/// Waits for a line that contains this; gives it.
fn hears(lines: &mut BufReader<ChildStderr>, what: &str) -> String {
    let mut all = String::new();
    loop {
        let mut line = String::new();
        assert!(lines.read_line(&mut line).unwrap() > 0, "no `{what}` in\n{all}");
        if line.contains(what) {
            return line;
        }
        all += &line;
    }
}

fn start(scratch: &Scratch, more: &[&str]) -> (Child, BufReader<ChildStderr>, Surface) {
    // One that hears nothing ends, and so does a test that waits for what it does not say.
    let wait: &[&str] = if more.contains(&"--wait") { &[] } else { &["--wait", "60"] };
    let arguments = [&["learn", "p.toml", "--midi-in", "none", "--osc", "0"], more, wait].concat();
    let command = &mut scratch.command(&arguments);
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let line = hears(&mut lines, "OSC is heard on ");
    let surface = Surface::at(line.trim().trim_start_matches("OSC is heard on "));
    (child, lines, surface)
}

#[test]
fn what_is_moved_is_bound_and_the_rest_of_the_patch_stays() {
    let scratch = Scratch::new("learn-osc");
    let path = scratch.write("p.toml", PATCH);
    let (mut child, mut lines, surface) = start(&scratch, &[]);
    hears(&mut lines, "rate   1 to 10 Hz  osc./old");
    // What is noisy, what is no position, what is pacinian's own; then a fader, and what it says on its way back.
    (0..50).for_each(|n| surface.say("/noisy", 0.5 + 0.02 * (n % 2) as f32));
    (0..50).for_each(|n| surface.say("/midi/7", n));
    (0..50).for_each(|n| surface.say("/control/depth", n as f32 / 50.0));
    surface.move_fader("/fader 1");
    surface.move_fader(&format!("/{}", "x".repeat(256)));
    surface.move_fader("/fader/1");
    surface.move_fader("/fader/1");
    hears(&mut lines, "/midi/7 says 2: what is learnt goes from 0 to 1");
    hears(&mut lines, "/control/depth is an address of pacinian's own");
    hears(&mut lines, "/fader 1 has a blank in it");
    hears(&mut lines, "xxx... is longer than the 256 bytes");
    hears(&mut lines, "OSC /fader/1");
    // A button: twice.
    [1, 0, 1, 0].iter().for_each(|on| surface.say("/button", *on));
    hears(&mut lines, "OSC /button, instead of osc./old");
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    assert!(child.wait().unwrap().success());
    assert!(out.contains("p.toml: 2 bindings") && out.contains("OSC /button   instead of osc./old"), "{out}");
    let text = std::fs::read_to_string(&path).unwrap();
    let bound = "from = \"osc./button\" # for now\ncontrol = \"rate\"\npickup = false\n";
    let mended = PATCH.replace("from = \"osc./old\" # for now\ncontrol = \"rate\"\npickup = false\n", bound);
    let new = "[[bind]]\nfrom = \"osc./fader/1\"\ncontrol = \"depth\"\n";
    assert!(text.contains(new), "{text}");
    assert_eq!(text.replacen(new, "", 1).replace("\n\n\n", "\n\n"), mended);
    scratch.run(&["check", "p.toml"]).succeeds();
}

#[test]
fn few_steps_are_bound_and_what_is_not_enough_is_told() {
    let scratch = Scratch::new("learn-few");
    scratch.write("p.toml", PATCH);
    let (mut child, mut lines, surface) =
        start(&scratch, &["--control", "depth", "--control", "rate", "--wait", "20"]);
    hears(&mut lines, "not bound");
    // What is pacinian's own is none to bind.
    [0.0, 0.5, 1.0].iter().for_each(|position| surface.say("/torque", *position as f32));
    hears(&mut lines, "/torque is an address of pacinian's own");
    for position in [0.125, 0.375, 0.75] {
        surface.say("/selector", position as f32);
        // No hand is faster.
        std::thread::sleep(std::time::Duration::from_millis(60));
    }
    hears(&mut lines, "OSC /selector");
    [0.12, 0.13, 0.14].iter().for_each(|position| surface.say("/small", *position as f32));
    surface.say("/still", 0.5_f32);
    let told = hears(&mut lines, "OSC /small moved from 12 % to 14 %");
    assert!(told.contains("by a tenth of its way or more; another moved less"), "{told}");
    let _ = child.kill();
    let _ = child.wait();
    let (mut child, mut lines, surface) = start(&scratch, &["--control", "rate", "--wait", "3"]);
    [0.0, 1.0].iter().for_each(|position| surface.say("/once", *position as f32));
    hears(&mut lines, "nothing moved; it is left as it is");
    hears(&mut lines, "OSC /once went from 0 % to 100 % at once");
    assert!(child.wait().unwrap().success());
}

#[test]
fn whoever_waits_in_vain_or_stops_leaves_the_patch_as_it_was() {
    let scratch = Scratch::new("learn-vain");
    let path = scratch.write("p.toml", PATCH);
    let (mut child, mut lines, _) = start(&scratch, &["--control", "rate", "--wait", "0.2"]);
    hears(&mut lines, "nothing moved; it is left as it is");
    assert!(child.wait().unwrap().success());
    let (mut child, mut lines, surface) = start(&scratch, &[]);
    surface.move_fader("/a");
    hears(&mut lines, "OSC /a");
    #[cfg(unix)]
    {
        let kill = std::process::Command::new("kill").args(["-s", "INT", &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        hears(&mut lines, "nothing was written");
        assert_eq!(child.wait().unwrap().code(), Some(130));
    }
    let _ = child.kill();
    let _ = child.wait();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), PATCH);
    // Somebody else has saved it meanwhile.
    let (mut child, mut lines, surface) = start(&scratch, &["--control", "rate"]);
    hears(&mut lines, "not bound");
    scratch.write("p.toml", PATCH.replace("a title", "another"));
    surface.move_fader("/a");
    hears(&mut lines, "was written by somebody else meanwhile");
    hears(&mut lines, "write the bindings by hand: rate from osc./a");
    assert_eq!(child.wait().unwrap().code(), Some(74));
    assert!(std::fs::read_to_string(&path).unwrap().contains("another"));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let scratch = Scratch::new("learn-refused");
    scratch.write("p.toml", PATCH);
    let refused = |arguments: &[&str], code, words: &[&str]| {
        scratch.run(&[&["learn"], arguments].concat()).fails(code, words);
    };
    refused(&["p.toml", "--midi-in", "none"], 2, &["nothing to learn from", "leave --midi-in none out"]);
    refused(&["p.toml", "--control", "dept", "--osc", "0"], 2, &["no control `dept`", "`depth`"]);
    let twice = ["p.toml", "--control", "depth", "--control", "depth", "--osc", "0"];
    refused(&twice, 2, &["`depth` is asked for twice"]);
    refused(&["good.toml", "--osc", "0"], 65, &["the patch has no controls"]);
    refused(&["-", "--osc", "0"], 2, &["comes through a pipe"]);
    refused(&["none.toml"], 66, &["`none.toml` is not there"]);
    scratch.write("bad.toml", PATCH.replace("default = 3", "default = 30"));
    refused(&["bad.toml", "--osc", "0"], 65, &["bad.toml:6:"]);
}

#[cfg(target_os = "linux")]
#[test]
fn keys_leave_a_control_go_back_and_end() {
    let scratch = Scratch::new("learn-keys");
    let path = scratch.write("p.toml", PATCH);
    let command = scratch.command(&["learn", "p.toml", "--midi-in", "none", "--osc", "0"]);
    let Some(mut seat) = seat::Seat::new(&command) else { return };
    let shown = seat.shows("1/2  depth (0 to 1): move something");
    let address =
        shown.lines().find_map(|line| line.strip_prefix("OSC is heard on ")).unwrap().trim().to_string();
    let surface = Surface::at(&address);
    surface.move_fader("/first");
    seat.shows("2/2  rate (1 to 10 Hz): move something");
    // A key that moves a cursor says nothing, and Enter behind it does not either.
    seat.press("\x1b[C");
    std::thread::sleep(std::time::Duration::from_millis(100));
    seat.press("\r");
    seat.see("the question again", |text| text.matches("2/2  rate").count() == 2);
    seat.press("b");
    seat.shows("2/2  rate (1 to 10 Hz): move something back\n1/2  depth");
    surface.move_fader("/second");
    seat.shows("OSC /second\n2/2");
    seat.press("s");
    seat.shows("left as it is\np.toml: 1 binding");
    assert_eq!(seat.end().code(), Some(0));
    assert!(seat.is_given_back());
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains("osc./second") && !text.contains("/first") && text.contains("osc./old"), "{text}");
}

#[test]
fn what_comes_from_the_network_moves_no_cursor() {
    let scratch = Scratch::new("learn-escapes");
    scratch.write("p.toml", PATCH);
    let (mut child, mut lines, surface) = start(&scratch, &[]);
    let address = "/control/\x1b]0;gone\x07\x1b[2J\nMIDI from nowhere\u{202e}";
    surface.say(address, 0.5_f32);
    surface.say(&"/control/".chars().chain(std::iter::repeat_n('x', 5000)).collect::<String>(), 0.5_f32);
    let line = hears(&mut lines, "is an address of pacinian's own");
    assert!(
        line.contains("/control/\\u{1b}]0;gone\\u{7}\\u{1b}[2J\\nMIDI from nowhere\\u{202e} is an"),
        "{line:?}"
    );
    assert!(!line.trim_end().contains(char::is_control), "{line:?}");
    let line = hears(&mut lines, "is an address of pacinian's own");
    assert!(line.len() < 250, "{}", line.len());
    surface.say("/far\x1b[1A\x08", 3.0_f32);
    let line = hears(&mut lines, "what is learnt goes from 0 to 1");
    assert!(line.contains("/far\\u{1b}[1A\\u{8} says 3"), "{line:?}");
    let _ = child.kill();
    let _ = child.wait();
}
