//! What names a time: it waits for that, or was sampled then.

use std::sync::Arc;
use std::time::Duration;

use rosc::{OscPacket, OscType};

use super::{PATCH, Scene, bundle, f, message};
use crate::live::signal::{Origin, Signal, Stamped};
use crate::patch::Patch;

#[test]
fn bundles_are_played_at_their_time() {
    let scene = Scene::new();
    let epoch = scene.handle.epoch();
    let start = epoch.now();
    let inner = bundle(400, vec![message("/pattern/walk/stop", &[])]);
    scene.send(&bundle(
        200,
        vec![inner, message("/control/depth", &[f(2.0)]), message("/pattern/walk/play", &[])],
    ));
    // Until shortly before, a control is where it was.
    scene.say("/control/depth/get", &[]);
    assert_eq!(scene.settle(), [("/control/depth".into(), vec![f(0.5)])]);
    let mut heard: Vec<Stamped> = Vec::new();
    while heard.len() < 3 {
        heard.extend(scene.heard());
        std::thread::sleep(Duration::from_millis(1));
        assert!(epoch.now().since(start) < 20.0, "{heard:?}");
    }
    let kinds: Vec<&str> = heard
        .iter()
        .map(|h| match h.signal {
            Signal::Set(..) => "set",
            Signal::Start(..) => "start",
            Signal::StopNamed(_) => "stop",
            _ => "other",
        })
        .collect();
    assert_eq!(kinds, ["set", "start", "stop"]);
    assert_eq!(heard[0].stamp, heard[1].stamp);
    let peer = scene.client.local_addr().unwrap().to_string();
    assert!(heard.iter().all(|heard| heard.peer.as_deref() == Some(&*peer)), "{heard:?}");
    // Each says by which message it came, also where others came in between.
    let said = |address: &str, arguments: &str| Origin::Osc(address.into(), arguments.into());
    let origins: Vec<_> = heard.iter().map(|heard| heard.origin.clone()).collect();
    let walk = ["/pattern/walk/play", "/pattern/walk/stop"].map(|address| said(address, ""));
    assert_eq!(origins, [&[said("/control/depth", "2")][..], &walk].concat());
    for (heard, due) in heard.iter().zip([0.2, 0.2, 0.4]) {
        assert!((heard.stamp.since(start) - due).abs() < 0.05, "{heard:?}");
    }
    scene.say("/control/depth/get", &[]);
    assert_eq!(scene.settle(), [("/control/depth".into(), vec![f(2.0)])]);
    assert_eq!(scene.counts().trouble(), None);
}

/// A patch that is saved meanwhile has other controls, in another order.
#[test]
fn what_waits_for_its_time_means_the_control_of_that_name() {
    let scene = Scene::new();
    let sets = [message("/control/depth", &[f(2.0)]), message("/control/tempo", &[f(120.0)])];
    scene.send(&bundle(2500, sets.to_vec()));
    scene.settle();
    let other = PATCH
        .replace("[control.depth]", "[control.aaa]\ndefault = 0\n[control.rest]")
        .replace("\"depth\"", "\"aaa\"");
    scene.server.follow(&Patch::parse("p", other.as_bytes()).unwrap().value);
    scene.settle();
    let (epoch, mut heard) = (scene.handle.epoch(), Vec::new());
    let begin = epoch.now();
    while heard.is_empty() {
        heard.extend(scene.heard());
        std::thread::sleep(Duration::from_millis(1));
        assert!(epoch.now().since(begin) < 20.0);
    }
    scene.settle();
    heard.extend(scene.heard());
    let set: Vec<_> = heard.into_iter().map(|heard| heard.signal).collect();
    assert!(matches!(&set[..], [Signal::Set(name, value)] if name == "tempo" && *value == 120.0), "{set:?}");
    assert_eq!(scene.counts().unknown.get(), 1, "the other is none any more");
    scene.vain(&[("/control/depth", "a patch took over before its time that has no such control")]);
}

#[test]
fn late_far_and_cancelled() {
    let scene = Scene::new();
    let play = || message("/voice/low/play", &[]);
    scene.send(&bundle(-5000, vec![play(), play()]));
    scene.send(&bundle(70_000, vec![play()]));
    scene.settle();
    let late = scene.heard();
    assert_eq!(late.len(), 2);
    assert!(late.iter().all(|s| s.ahead.is_some_and(|ahead| (-5.5..=-5.0).contains(&ahead))), "{late:?}");
    assert_eq!((scene.counts().late.get(), scene.counts().far.get()), (2, 1));
    // What waits for its time has come so long before it; what names none has not.
    scene.send(&bundle(200, vec![play()]));
    scene.say("/arm", &[0.into()]);
    scene.settle();
    let until = std::time::Instant::now() + Duration::from_secs(5);
    let mut heard = scene.heard();
    while heard.len() < 2 && std::time::Instant::now() < until {
        std::thread::sleep(Duration::from_millis(10));
        heard.extend(scene.heard());
    }
    assert!(
        matches!(heard[..], [Stamped { ahead: None, .. }, Stamped { ahead: Some(0.0..=0.2), .. }]),
        "{heard:?}"
    );
    scene.send(&bundle(30_000, vec![play(), message("/calm", &[])]));
    scene.settle();
    assert_eq!((scene.heard().len(), scene.counts().cancelled.get()), (0, 0));
    // A panic waits for no time, however far, and nothing survives it.
    scene.send(&bundle(70_000, vec![message("/panic", &[])]));
    scene.settle();
    assert!(matches!(scene.heard()[..], [Stamped { signal: Signal::Panic, .. }]));
    assert!(scene.handle.board().is_panicked());
    assert_eq!((scene.counts().cancelled.get(), scene.counts().far.get()), (2, 1));
    let (far, panic) = ("for more than 60 s ahead is not played", "a panic came before its time");
    scene.vain(&[("/voice/low/play", far), ("/voice/low/play", panic), ("/calm", panic)]);
    // Nor one that came another way.
    scene.handle.board().calm();
    // The brake is looked at after an answer, so only the second is sure to come after that.
    (0..2).for_each(|_| drop(scene.settle()));
    scene.send(&bundle(30_000, vec![play()]));
    scene.settle();
    scene.handle.board().panic();
    (0..2).for_each(|_| drop(scene.settle()));
    assert_eq!(scene.counts().cancelled.get(), 3);
    scene.heard();
    scene.vain(&[("/voice/low/play", panic)]);
    // What else a message asks for that is a panic is still by that message.
    scene.handle.board().calm();
    (0..2).for_each(|_| drop(scene.settle()));
    scene.send(&bundle(30_000, vec![play()]));
    scene.settle();
    let both = "/{panic,arm}";
    scene.say(both, &[1.into()]);
    scene.settle();
    let heard = scene.heard();
    assert!(matches!(
        heard[..],
        [Stamped { signal: Signal::Panic, .. }, Stamped { signal: Signal::Arm(true), .. }]
    ));
    assert!(heard.iter().all(|s| s.origin == Origin::Osc(both.into(), "1".into())), "{heard:?}");
    scene.vain(&[("/voice/low/play", panic)]);
}

/// The tag of a value for a stream is when it was sampled, as far back as the stream can make up for it. All else is done when it comes.
#[test]
fn a_stream_has_its_values_as_of_their_tags() {
    let scene = Scene::new();
    let set = |addr: &str| message(addr, &[OscType::Float(100.0)]);
    let stamps = |ms: i64, content: Vec<OscPacket>| {
        let before = scene.handle.epoch().now().0;
        scene.send(&bundle(ms, content));
        scene.settle();
        let stamps: Vec<u64> = scene.heard().iter().map(|stamped| stamped.stamp.0).collect();
        (before, stamps, scene.handle.epoch().now().0)
    };
    // A session that has lasted for longer than that.
    std::thread::sleep(Duration::from_millis(400));
    let (before, of, after) = stamps(-300, vec![set("/input/tempo"), set("/control/tempo")]);
    assert_eq!((of.len(), scene.counts().late.get()), (2, 0));
    for stamp in of {
        // Two clocks of the system, one of which may be set right meanwhile.
        let came = stamp + 300_000_000;
        assert!(came + 1_000_000 > before && came < after + 1_000_000, "{before} {came} {after}");
    }
    let (before, of, _) = stamps(-300, vec![set("/control/depth"), message("/voice/low/play", &[])]);
    assert!(of.len() == 2 && of.iter().all(|stamp| *stamp >= before), "{before} {of:?}");
    assert_eq!(scene.counts().late.get(), 2);
    let (before, of, _) = stamps(-1100, vec![set("/input/tempo")]);
    assert!(of.len() == 1 && of[0] >= before, "{before} {of:?}");
    assert_eq!(scene.counts().late.get(), 3);
    // What goes to a stream and to another control is late for that one.
    let (_, of, _) = stamps(-300, vec![set("/control/{depth,tempo}")]);
    assert!(of.len() == 2 && of[0] > of[1], "{of:?}");
    assert_eq!(scene.counts().late.get(), 4);
}

/// A tracker's numbers in one message: by names in the address, or by bindings; and as of when they were sampled.
#[test]
fn streams_take_the_numbers_of_one_message() {
    let text = "[control.x]\ndefault = 0\nrange = [-2, 2]\nstream = 0.5\n[control.y]\ndefault = 0\nstream = 0.4\n[control.z]\ndefault = 0\n\
        [[bind]]\nfrom = \"osc./hand\"\ncontrol = \"x\"\n[[bind]]\nfrom = \"osc./hand 2\"\ncontrol = \"y\"\n\
        [[bind]]\nfrom = \"osc./head\"\ncontrol = \"x\"\n[[bind]]\nfrom = \"osc./head 2\"\ncontrol = \"z\"\n";
    let patch = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{text}");
    let patch = Patch::parse("p", patch.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let scene = Scene::of(&patch);
    std::thread::sleep(Duration::from_millis(700));
    let float = |x: f32| OscType::Float(x);
    let heard = |content: OscPacket| {
        scene.send(&content);
        scene.settle();
        scene.heard()
    };
    let told = |heard: &[Stamped]| -> Vec<(String, f64)> {
        let of = |stamped: &Stamped| match &stamped.signal {
            Signal::Set(name, value) => (name.clone(), *value),
            other => panic!("{other:?}"),
        };
        heard.iter().map(of).collect()
    };
    let set = heard(message("/input/y/x", &[float(0.25), float(-9.0)]));
    assert_eq!(told(&set), [("y".to_string(), 0.25), ("x".to_string(), -2.0)]);
    // In a journal, each has its own line.
    let ways = [("/input/y", "0.25"), ("/input/x", "-9")].map(|(a, b)| Origin::Osc(a.into(), b.into()));
    assert!(set.iter().map(|stamped| &stamped.origin).eq(&ways), "{set:?}");
    // As many numbers as names, and streams alone.
    for (address, args) in [
        ("/input/x/y", vec![float(0.1)]),
        ("/input/x/y", vec![float(0.1), float(f32::NAN)]),
        ("/input/x/y/z", vec![float(0.1); 3]),
        ("/input/x/", vec![float(0.1); 2]),
    ] {
        assert!(heard(message(address, &args)).is_empty(), "{address} {args:?}");
    }
    assert_eq!((scene.counts().wrong.get(), scene.counts().unknown.get()), (2, 2));
    // 300 ms late: within what the least of them is later, so it is as of then.
    for (address, ms, as_of_then) in [
        ("/input/x/y", 300, true),
        ("/input/x/y", 450, false),
        ("/hand", 300, true),
        ("/hand", 450, false),
        ("/head", 300, false),
    ] {
        let (before, late) = (scene.handle.epoch().now().0, scene.counts().late.get());
        let heard = heard(bundle(-ms, vec![message(address, &[float(0.5), float(0.5)])]));
        assert!(!heard.is_empty());
        assert!(heard.iter().all(|s| (s.stamp.0 < before) == as_of_then), "{address} {ms}");
        assert_eq!(scene.counts().late.get() - late, u64::from(!as_of_then), "{address} {ms}");
    }
}

/// What waits for its time when the session ends comes to nothing, and is counted.
#[test]
fn what_still_waits_at_the_end_is_counted() {
    let mut scene = Scene::new();
    scene.send(&bundle(30_000, vec![message("/voice/low/play", &[]), message("/calm", &[])]));
    scene.settle();
    let counts = Arc::clone(scene.server.counts());
    assert_eq!(counts.cancelled.get(), 0);
    // Another takes its place, so that it ends.
    let other = Patch::parse("p", super::PATCH.as_bytes()).unwrap().value;
    scene.server = super::Server::start("0".parse().unwrap(), scene.handle.clone(), &other, None).unwrap();
    assert_eq!(counts.cancelled.get(), 2);
    assert_eq!(scene.heard().len(), 0);
}
