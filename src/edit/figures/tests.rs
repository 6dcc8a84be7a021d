//! What is written into a rig's text, and what stays.

use super::{EditError, Entry, Given, changed, figures, keys, short};

fn entry(key: &'static str, value: f64, from: &str) -> Entry {
    let comment = format!("pacinian identify {from}: 1 to 2 (95 %)");
    Entry { key, value: Given::Number(value), comment }
}

const RIG: &str = "#:schema x\nformat = \"pacinian-rig/1\"  # mine\n[device]\nchannels = 1\n\n# The wrist.\n[actuator.coin]\npart = 'coin-10mm' # bought\n  \
    resonance   =  0xC8     # Hz; where it moves most\nq = 3.0\n\n# Others.\n[actuator.other]\nmodel = \"lra\"\n";

#[test]
fn figures_come_in_and_everything_else_stays() {
    let text = changed(
        RIG,
        "coin",
        &[entry("resonance", 201.5, "a.wav"), entry("inertia", 1.8e-9, "a.wav"), entry("q", 4.0, "a.wav")],
    )
    .unwrap();
    let due = RIG
        .replace("=  0xC8     # Hz; where it moves most", "=  201.5     # Hz; where it moves most; pacinian identify a.wav: 1 to 2 (95 %)")
        .replace("q = 3.0\n", "q = 4.0  # pacinian identify a.wav: 1 to 2 (95 %)\ninertia = 1.8e-9  # pacinian identify a.wav: 1 to 2 (95 %)\n");
    assert_eq!(text, due);
    // Another run takes the place of the last.
    let again =
        changed(&text, "coin", &[entry("resonance", 199.0, "b.wav"), entry("q", 5.0, "b.wav")]).unwrap();
    let due = due.replace(
        "201.5     # Hz; where it moves most; pacinian identify a.wav",
        "199.0     # Hz; where it moves most; pacinian identify b.wav",
    );
    assert_eq!(
        again,
        due.replace("q = 4.0  # pacinian identify a.wav", "q = 5.0  # pacinian identify b.wav")
    );
    assert_eq!(keys(text.as_bytes(), "coin"), ["part", "resonance", "q", "inertia"]);
}

/// What ends a line, what stands before all, what somebody wrote: a comment is this command's where it has all that this command writes.
#[test]
fn what_is_not_its_own_stays_to_the_byte() {
    let rig = "\u{feff}format = 1\r\n[actuator.coin] # mixed\nq = 3.0 # identified from my notes: 2 to 4\r\nresonance = 150.0\r\n\r\n# End.";
    let text = changed(rig, "coin", &[entry("q", 4.0, "a"), entry("inertia", 1e-9, "a")]).unwrap();
    let due = rig
        .replace(
            "q = 3.0 # identified from my notes: 2 to 4",
            "q = 4.0 # identified from my notes: 2 to 4; pacinian identify a: 1 to 2 (95 %)",
        )
        .replace("150.0\r\n", "150.0\r\ninertia = 1e-9  # pacinian identify a: 1 to 2 (95 %)\r\n");
    assert_eq!(text, due);
    assert_eq!(keys(text.as_bytes(), "coin"), ["q", "resonance", "inertia"]);
    // A last line that nothing ends.
    for end in ["\n", "\r\n"] {
        let rig = format!("[actuator.coin]{end}q = 3");
        let text = changed(&rig, "coin", &[entry("q", 4.0, "a"), entry("resonance", 9.0, "a")]);
        let due = format!(
            "[actuator.coin]{end}q = 4.0  # pacinian identify a: 1 to 2 (95 %){end}resonance = 9.0  # pacinian identify a: 1 to 2 (95 %)"
        );
        assert_eq!(text.unwrap(), due);
    }
    let own = "pacinian identify b.wav: 1 to 2 (95 %)";
    for (behind, due) in [
        ("#", format!("# {own}")),
        ("# pacinian identify: see notes", format!("# pacinian identify: see notes; {own}")),
        ("# pacinian identify says 3: 1 to 2", format!("# pacinian identify says 3: 1 to 2; {own}")),
        ("# pacinian identify a: b to c (95 %)", format!("# pacinian identify a: b to c (95 %); {own}")),
        (
            "# ran pacinian identify a: 1 to 2 (95 %)",
            format!("# ran pacinian identify a: 1 to 2 (95 %); {own}"),
        ),
        ("# x; pacinian identify a: 1e-9 to -2 N m/A (95 %)", format!("# x; {own}")),
        ("# pacinian identify a: b.wav: 1 to 2 Hz (95 %); a good take", format!("# {own}; a good take")),
    ] {
        let rig = format!("[actuator.coin]\nq = 3 {behind}\n");
        let text = changed(&rig, "coin", &[entry("q", 5.0, "b.wav")]).unwrap();
        assert_eq!(text, format!("[actuator.coin]\nq = 5.0 {due}\n"));
    }
}

#[test]
fn what_the_command_line_says_is_written_too() {
    let given = [Entry::given("model", Given::Word("lra")), Entry::given("mass", Given::Number(0.1))];
    assert_eq!(
        changed("[actuator.coin]\nq = 3\n", "coin", &given).unwrap(),
        "[actuator.coin]\nq = 3\nmodel = \"lra\"  # given to pacinian identify\nmass = 0.1  # given to pacinian identify\n"
    );
}

#[test]
fn tables_of_one_line_get_figures_alone() {
    let rig = "actuator = { coin = { part = \"x\", q = 3 } } # here\n";
    let text = changed(rig, "coin", &[entry("q", 4.5, "a"), entry("resonance", 150.0, "a")]).unwrap();
    assert_eq!(text, "actuator = { coin = { part = \"x\", q = 4.5, resonance = 150.0 } } # here\n");
    let dotted = "actuator.coin.q = 3\n";
    assert_eq!(
        changed(dotted, "coin", &[entry("q", 4.0, "a")]).unwrap(),
        "actuator.coin.q = 4.0  # pacinian identify a: 1 to 2 (95 %)\n"
    );
}

#[test]
fn what_cannot_be_done_is_said() {
    assert!(changed("[", "coin", &[entry("q", 1.0, "a")]).unwrap_err().to_string().contains("read again"));
    assert!(
        changed(RIG, "none", &[entry("q", 1.0, "a")]).unwrap_err().to_string().contains("[actuator.none]")
    );
    assert!(changed("actuator.coin = 3\n", "coin", &[entry("q", 1.0, "a")]).is_err());
    assert_eq!([short(1e-9), short(200.0), short(0.0), short(2e7)], ["1e-9", "200.0", "0.0", "2e7"]);
}

#[test]
fn what_would_be_no_rig_is_refused() {
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\n[actuator.coin]\nmodel = \"lra\"\nresonance = 200\nq = 3\n\
        rated_volts = 2\nrated_acceleration = 10\n";
    let good = figures(rig, "coin", &[entry("q", 4.0, "a")]).unwrap();
    assert_eq!(good, changed(rig, "coin", &[entry("q", 4.0, "a")]).unwrap());
    let broken = figures(rig, "coin", &[entry("q", -1.0, "a")]);
    assert!(matches!(broken, Err(EditError::Broken(_))), "{broken:?}");
    assert_eq!(figures(rig, "coin", &[entry("q", f64::NAN, "a")]), Err(EditError::Form("`q`".into())));
}
