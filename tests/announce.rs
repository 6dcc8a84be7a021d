//! What a session plays is told over OSC, over real UDP.
#![cfg(feature = "live")]

mod common;

use std::net::UdpSocket;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use pacinian::Note;
use pacinian::engine::event::Event;
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::osc::announce::Announcer;
use pacinian::io::osc::server::Server;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use rosc::{OscMessage, OscPacket, OscType, encoder};

const PATCH: &str = "[voice.hum]\nvoices = 16\noutput = \"o\"\n[voice.hum.nodes]\ns = { type = \"sine\", frequency = 200 }\n\
    e = { type = \"envelope\", attack = 0.005, release = 0.02 }\no = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n\
    [pattern.trial]\nrepeat = { every = 0.1 }\nevents = [{ at = 0, marker = \"begin\" }, \
    { at = 0.0301, voice = \"hum\", duration = 0.02, place = 2, level = 0.25 }, { at = 0.0502, marker = \"end\" }]\n";

fn reload(text: &str) -> Reload {
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(common::patch(text), Rig::default_for(2), &options, &NoAssets).unwrap()
}

fn client() -> UdpSocket {
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    client.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    client
}

/// What comes next but for what the gate does, with its time tag in seconds since 1970; none for what comes outside of a bundle.
#[track_caller]
fn hear(client: &UdpSocket) -> (Option<f64>, OscMessage) {
    loop {
        let heard = hear_all(client);
        if heard.1.addr != "/gate" {
            return heard;
        }
    }
}

#[track_caller]
fn hear_all(client: &UdpSocket) -> (Option<f64>, OscMessage) {
    let mut bytes = [0; 65_536];
    let (length, _) = client.recv_from(&mut bytes).unwrap();
    match rosc::decoder::decode_udp(&bytes[..length]).unwrap().1 {
        OscPacket::Message(message) => (None, message),
        OscPacket::Bundle(bundle) => {
            let tag = f64::from(bundle.timetag.seconds) - 2_208_988_800.0
                + f64::from(bundle.timetag.fractional) / 4_294_967_296.0;
            let Some(OscPacket::Message(message)) = bundle.content.into_iter().next() else { panic!() };
            (Some(tag), message)
        }
    }
}

fn say(client: &UdpSocket, to: &Server, addr: &str) {
    say_with(client, to, addr, &[]);
}

fn say_with(client: &UdpSocket, to: &Server, addr: &str, args: &[OscType]) {
    let packet = OscPacket::Message(OscMessage { addr: addr.into(), args: args.to_vec() });
    client.send_to(&encoder::encode(&packet).unwrap(), to.address()).unwrap();
}

#[track_caller]
fn marker(client: &UdpSocket) -> (f64, String, i64, f64) {
    let (tag, message) = hear(client);
    assert_eq!(message.addr, "/marker");
    let [
        OscType::String(name),
        OscType::Long(sample),
        OscType::Double(seconds),
        OscType::String(pattern),
        OscType::Long(event),
        OscType::Long(_),
        OscType::Long(0),
    ] = &message.args[..]
    else {
        panic!("{message:?}")
    };
    assert_eq!((pattern.as_str(), *event), ("trial", if name == "begin" { 1 } else { 3 }));
    (tag.unwrap(), name.clone(), *sample, *seconds)
}

#[test]
fn markers_and_voices_are_told_with_the_time_at_which_they_leave() {
    let first = reload(PATCH);
    let announcer = Announcer::new(&first.scene.plan).unwrap();
    let logger = client();
    announcer.always(logger.local_addr().unwrap()).unwrap();
    let (hears, told) = (announcer.clone(), announcer.clone());
    let played = Arc::new(Mutex::new(Vec::new()));
    let plays = Arc::clone(&played);
    let session = Session::start(Beginning {
        block: Some(64),
        listener: Some(Box::new(move |heard| hears.hear(heard))),
        audience: Box::new(move |what| {
            if let Told::Report(Report { deed: Deed::Event { at, event: Event::Marker(..), .. }, .. }, _) =
                what
            {
                plays.lock().unwrap().push(at.sample as i64);
            }
            told.told(&what);
        }),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let patch = common::patch(PATCH);
    let server =
        Server::start("0".parse().unwrap(), session.handle().clone(), &patch, Some(announcer.clone()))
            .unwrap();

    // Whoever was named hears all markers, in order, at the samples at which they were played.
    let heard: Vec<_> = (0..8).map(|_| marker(&logger)).collect();
    let names: Vec<_> = heard.iter().map(|(_, name, ..)| name.as_str()).collect();
    assert_eq!(names, ["begin", "end", "begin", "end", "begin", "end", "begin", "end"]);
    let samples: Vec<i64> = heard.iter().map(|(_, _, sample, _)| *sample).collect();
    assert_eq!(samples, played.lock().unwrap()[..8]);
    // From one to the next as much time passes by the tags as by the samples, on a card that keeps real time, and it is now.
    let (begin, end) = (&heard[2], &heard[7]);
    let by_samples = (end.2 - begin.2) as f64 / 8_000.0;
    assert!((by_samples - 0.2502).abs() < 1e-3, "{by_samples}");
    for by in [end.0 - begin.0, end.3 - begin.3] {
        assert!((by - by_samples).abs() < 0.05, "{by} where there are {by_samples} s");
    }
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
    assert!((now - end.0).abs() < 5.0, "{} at {now}", end.0);

    // Whoever asks for markers hears markers, whoever asks for all hears voices too.
    let (some, all) = (client(), client());
    say(&some, &server, "/marker/subscribe");
    assert_eq!(hear(&some).1, OscMessage { addr: "/marker/subscribed".into(), args: vec![60.into()] });
    say(&all, &server, "/event/subscribe");
    assert_eq!(hear(&all).1.addr, "/event/subscribed");
    // Who asks for markers besides still hears voices.
    say(&all, &server, "/marker/subscribe");
    while hear(&all).1.addr != "/marker/subscribed" {}
    (0..4).for_each(|_| drop(marker(&some)));
    let voice = |name: &str| loop {
        let (tag, message) = hear(&all);
        if message.addr == "/event/voice" && message.args[0] == OscType::String(name.into()) {
            assert!(tag.is_some());
            break message.args;
        }
    };
    let args = voice("hum");
    assert_eq!(args[4..7], [OscType::String("t2".into()), OscType::Double(0.25), OscType::Double(0.02)]);
    let text = |text: &str| OscType::String(text.into());
    assert_eq!(args[7..10], [text("trial"), OscType::Long(2), text("2=1")]);
    // It says nothing of a threshold, nobody's message asked for it, and it has no id of anybody's.
    assert!(
        matches!(args[10..], [OscType::Double(felt), OscType::Long(0), OscType::Long(0)] if felt.is_nan())
    );
    let number = session
        .handle()
        .play("hum", Note { level: Some(0.5), duration: Some(f64::INFINITY), ..Note::default() })
        .unwrap();
    let args = loop {
        let args = voice("hum");
        if args[5] == OscType::Double(0.5) {
            break args;
        }
    };
    assert_eq!(args[6], OscType::Double(f64::INFINITY), "until it is released");
    session.handle().send(Signal::Release(number)).unwrap();
    let released = loop {
        let (_, message) = hear(&all);
        if message.addr == "/event/release" {
            break message.args;
        }
    };
    assert_eq!(released[0], args[1], "the same id");
    session.handle().send(Signal::ReleaseAll).unwrap();
    while hear(&all).1.addr != "/event/release-all" {}

    // Whoever plays under an id learns by it what became of that, also where it is one of several by one message.
    let played = |id: i32| {
        let args = [text("level"), OscType::Float(0.5), text("id"), id.into(), text("place"), 1.into()];
        say_with(&all, &server, "/voice/h*/play", &args);
        loop {
            let args = voice("hum");
            if args[5] == OscType::Double(0.5) {
                break args;
            }
        }
    };
    let (one, other) = (played(-7), played(8));
    assert_eq!((&one[9], &one[12], &other[12]), (&text("1=1"), &OscType::Long(-7), &OscType::Long(8)));
    let (OscType::Long(first), OscType::Long(then)) = (&one[11], &other[11]) else { panic!("{one:?}") };
    assert!(0 < *first && first < then, "{first} {then}");
    say(&all, &server, "/release");

    // The words are those of the patch that plays.
    session.handle().send(Signal::Reload(Box::new(reload(&PATCH.replace("hum", "buzz"))))).unwrap();
    voice("buzz");

    // Whoever wants no more hears no more; who is told for good still does.
    say(&some, &server, "/marker/unsubscribe");
    say(&some, &server, "/ping");
    while hear(&some).1.addr != "/pong" {}
    some.set_read_timeout(Some(Duration::from_millis(300))).unwrap();
    // One may have been on its way.
    let _ = some.recv_from(&mut [0; 999]);
    assert!(some.recv_from(&mut [0; 999]).is_err());
    logger.set_nonblocking(true).unwrap();
    while logger.recv_from(&mut [0; 999]).is_ok() {}
    logger.set_nonblocking(false).unwrap();
    marker(&logger);
    drop(session);
    assert_eq!(announcer.finish(), 0);
    assert_eq!(server.counts().trouble(), None);
}

/// A marker whose stimulus did not leave can be told from one that was felt: whoever hears of markers hears of the gate as well.
#[test]
fn what_the_gate_does_is_told_beside_the_markers() {
    let first = reload(PATCH);
    let announcer = Announcer::new(&first.scene.plan).unwrap();
    let logger = client();
    announcer.always(logger.local_addr().unwrap()).unwrap();
    let (hears, told) = (announcer.clone(), announcer.clone());
    let session = Session::start(Beginning {
        block: Some(64),
        listener: Some(Box::new(move |heard| hears.hear(heard))),
        audience: Box::new(move |what| told.told(&what)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let gate = || loop {
        let (tag, message) = hear_all(&logger);
        if message.addr == "/gate" {
            let [OscType::String(what), OscType::Long(frame), OscType::Double(seconds), OscType::Long(cause)] =
                &message.args[..]
            else {
                panic!("{message:?}")
            };
            assert!(tag.is_some());
            break (what.clone(), *frame, *seconds, *cause);
        }
    };
    let opened = gate();
    assert_eq!((opened.0.as_str(), opened.1, opened.3), ("open", 0, 0));
    let mut before = (opened.1, opened.2);
    let mut next = |signal: Signal, word: &str, by: i64| {
        // A panic calls off what was told ahead.
        while hear(&logger).1.addr != "/marker" {}
        session.handle().send(signal).unwrap();
        let (what, frame, seconds, cause) = gate();
        assert_eq!((what.as_str(), cause), (word, by));
        assert!(frame > before.0 && seconds > before.1, "{what} at {frame}, {seconds} s");
        let by_frames = (frame - before.0) as f64 / 48_000.0;
        assert!(
            (seconds - before.1 - by_frames).abs() < 0.05,
            "{by_frames} s of frames in {} s",
            seconds - before.1
        );
        before = (frame, seconds);
    };
    next(Signal::Panic, "latch", 1);
    session.handle().start("trial").unwrap();
    next(Signal::Calm, "release", 3);
}

/// Whoever reads that the gate was latched finds what had asked for it, by whichever way.
#[test]
fn the_gate_tells_which_signal_asked_for_what_it_does() {
    type Asked = Arc<Mutex<Vec<(String, u64)>>>;
    let (came, orders) = (Asked::default(), Asked::default());
    let (comes, ordered) = (Arc::clone(&came), Arc::clone(&orders));
    let audience = move |what: Told<'_>| match what {
        Told::Came(stamped) => {
            comes.lock().unwrap().push((format!("{:?}", stamped.signal), stamped.id));
        }
        Told::Report(Report { deed: Deed::Order(order, cause), .. }, _) => {
            ordered.lock().unwrap().push((format!("{order:?}"), *cause));
        }
        _ => {}
    };
    let session = Session::start(Beginning {
        block: Some(64),
        audience: Box::new(audience),
        ..Beginning::of(reload(PATCH), Chosen::Virtual(None))
    })
    .unwrap();
    let handle = session.handle().clone();
    let patch = common::patch(PATCH);
    let server = Server::start("0".parse().unwrap(), handle.clone(), &patch, None).unwrap();
    let client = client();
    let last = |of: &Asked| of.lock().unwrap().last().cloned();
    let expect = |signal: &str, order: &str| {
        let begin = std::time::Instant::now();
        let found =
            || last(&came).zip(last(&orders)).filter(|(came, told)| came.0 == signal && told.0 == order);
        let (asked, told) = loop {
            if let Some(found) = found() {
                break found;
            }
            assert!(
                begin.elapsed() < Duration::from_secs(20),
                "{signal} {:?}, {order} {:?}",
                last(&came),
                last(&orders)
            );
            std::thread::sleep(Duration::from_millis(1));
        };
        assert_eq!(asked.1, told.1, "{signal}: {order}");
        assert!(asked.1 > 0);
    };
    // It may be latched with the same block with which it opens, and opens behind that.
    while last(&orders).is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    // With others in between.
    let talk = || (0..5).for_each(|_| handle.note("talk").unwrap());
    for way in ["a signal", "a handle", "OSC"] {
        talk();
        match way {
            "a signal" => handle.send(Signal::Panic).unwrap(),
            "a handle" => handle.panic(),
            _ => say(&client, &server, "/panic"),
        }
        expect("Panic", "Latch");
        talk();
        match way {
            "OSC" => say(&client, &server, "/calm"),
            _ => handle.calm().unwrap(),
        }
        expect("Calm", "Release");
        handle.arm(way != "a handle").unwrap();
        expect(
            &format!("Arm({})", way != "a handle"),
            &format!("Gain({:?})", if way == "a handle" { 0.1 } else { 1.0 }),
        );
    }
    talk();
    handle.end();
    expect("End", "Close");
}

/// Some 50 ms ahead are five of these markers.
const DENSE: &str = "[pattern.p]\nrepeat = { every = 0.01 }\nevents = [{ at = 0, marker = \"m\" }]\n";

#[test]
fn what_was_told_ahead_and_is_called_off_is_told_to_be() {
    let first = reload(DENSE);
    let announcer = Announcer::new(&first.scene.plan).unwrap();
    let logger = client();
    announcer.always(logger.local_addr().unwrap()).unwrap();
    let (hears, told) = (announcer.clone(), announcer.clone());
    let session = Session::start(Beginning {
        block: Some(64),
        listener: Some(Box::new(move |heard| hears.hear(heard))),
        audience: Box::new(move |what| told.told(&what)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let number = session.handle().start("p").unwrap();
    let long = |message: &OscMessage, at: usize| match message.args[at] {
        OscType::Long(number) => number,
        _ => panic!("{message:?}"),
    };
    // Of the pattern that plays from the beginning, and of this one.
    let mut told: Vec<(i64, i64)> = Vec::new();
    let mut wait = 40;
    let (id, bits, from) = loop {
        let (tag, message) = hear(&logger);
        assert!(tag.is_some());
        match &*message.addr {
            "/marker" => told.push((long(&message, 5), long(&message, 1))),
            "/cancel" => {
                let OscType::Int(bits) = message.args[1] else { panic!("{message:?}") };
                break (long(&message, 0), bits, long(&message, 2));
            }
            other => panic!("{other}"),
        }
        wait -= 1;
        if wait == 0 {
            session.handle().stop(number).unwrap();
        }
    };
    let is_of = |id_of: i64| (id_of ^ id) >> bits == 0;
    let ours: Vec<i64> = told.iter().filter(|(id, _)| is_of(*id)).map(|(_, sample)| *sample).collect();
    // Those of the other stay; some of its own had begun, and some had not.
    assert!(ours.len() < told.len() && ours.len() > 10, "{} of {}", ours.len(), told.len());
    let off = ours.iter().filter(|sample| **sample >= from).count();
    assert!((1..=8).contains(&off), "{off} of {ours:?} from {from} on");
    assert!(ours.is_sorted() && ours[0] < from);
    // Nothing more comes of it, while the other goes on.
    for _ in 0..20 {
        let (_, message) = hear(&logger);
        assert!(message.addr == "/marker" && !is_of(long(&message, 5)), "{message:?}");
    }
}

/// Of two voices of which one may sound, the first makes room for the second.
#[test]
fn who_makes_room_is_told() {
    let patch = "[voice.hum]\nvoices = 1\noutput = \"s\"\n[voice.hum.nodes]\ns = { type = \"sine\", frequency = 200 }\n";
    let first = reload(patch);
    let announcer = Announcer::new(&first.scene.plan).unwrap();
    let told = announcer.clone();
    let session = Session::start(Beginning {
        block: Some(64),
        audience: Box::new(move |what| told.told(&what)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let server = Server::start(
        "0".parse().unwrap(),
        session.handle().clone(),
        &common::patch(patch),
        Some(announcer.clone()),
    )
    .unwrap();
    let all = client();
    say(&all, &server, "/event/subscribe");
    while hear(&all).1.addr != "/event/subscribed" {}
    let next = |addr: &str| loop {
        let (_, message) = hear(&all);
        if message.addr == addr {
            break message.args;
        }
    };
    let id = |args: &[OscType]| if let OscType::Long(id) = args[1] { id } else { panic!("{args:?}") };
    session.handle().play("hum", Note::default()).unwrap();
    let early = next("/event/voice");
    session.handle().play("hum", Note::default()).unwrap();
    let late = next("/event/voice");
    let stolen = next("/event/stolen");
    assert_eq!(stolen[0], OscType::Long(id(&early)));
    assert_eq!(stolen[1..3], late[2..4], "when the other begins");
    assert_eq!(stolen[3], OscType::String((id(&late) as u64).to_string()));
}
