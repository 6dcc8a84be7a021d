//! What `check` tells of what is felt less than was said.

use crate::{AREAS, Scratch, metres, threshold};

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
