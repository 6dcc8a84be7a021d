//! What is said over UDP, and what a session would hear of it.

/// A patch with something of everything.
pub(super) const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n\
    [control.depth]\ndefault = 0.5\nrange = [0, 2]\nunit = \"mm\"\n[control.tempo]\ndefault = 90\nrange = [30, 240]\nstream = 1.0\n\
    [voice.low]\noutput = \"s\"\n[voice.low.nodes]\ns = { type = \"sine\", frequency = 80 }\n\
    [voice.high]\noutput = \"s\"\n[voice.high.nodes]\ns = { type = \"sine\", frequency = 200 }\n\
    [voice.release]\noutput = \"s\"\n[voice.release.nodes]\ns = { type = \"sine\", frequency = 200 }\n\
    [pattern.walk]\nevents = [{ at = 0, voice = \"low\" }]\n\
    [[trigger]]\non = \"osc./hit/left\"\nplay = \"low\"\n[[trigger]]\non = \"osc./ping\"\nplay = \"low\"\n\
    [[bind]]\nfrom = \"osc./1/fader1\"\ncontrol = \"depth\"\n";

use std::cell::RefCell;
use std::net::UdpSocket;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use proptest::prelude::{ProptestConfig, any, prop, proptest};
use rosc::{OscArray, OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

use super::counts::Counts;
use super::peers::MOST_PEERS;
use super::server::Server;
use super::time::Tag;
use crate::live::board::Board;
use crate::live::queues::{Inbox, queues};
use crate::live::signal::{Handle, Origin, Signal, Stamped};
use crate::live::stamp::Epoch;
use crate::live::way::Way;
use crate::patch::Patch;
use crate::performer::Touch;

/// A server, someone who sends to it, and what a session would hear.
struct Scene {
    server: Server,
    client: UdpSocket,
    heard: RefCell<Inbox>,
    /// What a journal would say of what came to nothing: the address, and why.
    vain: RefCell<Vec<(String, String)>>,
    handle: Handle,
}

fn client() -> UdpSocket {
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    client
}

fn message(addr: &str, args: &[OscType]) -> OscPacket {
    OscPacket::Message(OscMessage { addr: addr.into(), args: args.to_vec() })
}

/// A bundle whose time comes in so many milliseconds.
fn bundle(ms: i64, content: Vec<OscPacket>) -> OscPacket {
    let now = SystemTime::now();
    let time = match u64::try_from(ms) {
        Ok(ms) => now + Duration::from_millis(ms),
        Err(_) => now - Duration::from_millis(ms.unsigned_abs()),
    };
    let Tag(tag) = Tag::of(time);
    let timetag = OscTime { seconds: (tag >> 32) as u32, fractional: tag as u32 };
    OscPacket::Bundle(OscBundle { timetag, content })
}

/// The next message to a client.
fn receive(client: &UdpSocket) -> (String, Vec<OscType>) {
    let mut bytes = [0; 65_536];
    let (length, _) = client.recv_from(&mut bytes).unwrap();
    match rosc::decoder::decode_udp(&bytes[..length]) {
        Ok(([], OscPacket::Message(message))) => (message.addr, message.args),
        other => panic!("{other:?}"),
    }
}

impl Scene {
    fn new() -> Self {
        Self::of(&Patch::parse("p", PATCH.as_bytes()).unwrap().value)
    }

    fn of(patch: &Patch) -> Self {
        let (inlet, heard) = queues();
        let handle = Handle::new(inlet, Epoch::begin(), Arc::new(Board::new(3)));
        let server = Server::start("0".parse().unwrap(), handle.clone(), patch, None).unwrap();
        Self { server, client: client(), heard: RefCell::new(heard), vain: RefCell::default(), handle }
    }

    fn send(&self, packet: &OscPacket) {
        self.send_bytes(&encoder::encode(packet).unwrap());
    }

    fn send_bytes(&self, bytes: &[u8]) {
        self.client.send_to(bytes, self.server.address()).unwrap();
    }

    fn say(&self, addr: &str, args: &[OscType]) {
        self.send(&message(addr, args));
    }

    /// Waits until everything that was sent so far is done; gives what was answered.
    fn settle(&self) -> Vec<(String, Vec<OscType>)> {
        self.say("/ping", &[]);
        std::iter::from_fn(|| Some(receive(&self.client)).filter(|(addr, _)| addr != "/pong")).collect()
    }

    /// What a session would hear of what is said.
    fn hears(&self, addr: &str, args: &[OscType]) -> Vec<Signal> {
        self.say(addr, args);
        assert_eq!(self.settle(), [], "{addr}");
        self.heard().into_iter().map(|stamped| stamped.signal).collect()
    }

    /// All that a session would hear now, but for what is for its journal alone.
    fn heard(&self) -> Vec<Stamped> {
        let mut heard = self.heard.borrow_mut();
        let mut all = Vec::new();
        loop {
            heard.begin();
            let before = all.len();
            all.extend(std::iter::from_fn(|| heard.next()));
            if all.len() == before {
                break;
            }
        }
        let (vain, all) = all.into_iter().partition(|stamped| matches!(stamped.signal, Signal::Vain(..)));
        self.vain.borrow_mut().extend(<Vec<Stamped> as IntoIterator>::into_iter(vain).map(|stamped| match (
            stamped.origin,
            stamped.signal,
        ) {
            (Origin::Osc(address, _), Signal::Vain(_, why)) => (address.to_string(), why),
            other => panic!("{other:?}"),
        }));
        all
    }

    /// What came to nothing since this was asked last, and that the reason has these words.
    fn vain(&self, wanted: &[(&str, &str)]) {
        let vain = std::mem::take(&mut *self.vain.borrow_mut());
        let fits = |((address, why), (at, says)): (&(String, String), &(&str, &str))| {
            address == at && why.contains(says)
        };
        assert!(vain.len() == wanted.len() && vain.iter().zip(wanted).all(fits), "{vain:?}");
    }

    fn counts(&self) -> &Counts {
        self.server.counts()
    }
}

fn f(x: f32) -> OscType {
    OscType::Float(x)
}

fn s(text: &str) -> OscType {
    OscType::String(text.into())
}

/// Each address and the signal it makes.
#[test]
fn what_is_said_is_heard() {
    let scene = Scene::new();
    let Signal::Play(_, voice, note) = &scene.hears("/voice/low/play", &[f(0.5), 2.into()])[0] else {
        panic!()
    };
    assert_eq!((voice.as_str(), note.level, note.duration), ("low", Some(0.5), Some(2.0)));
    let one = |addr: &str, args: &[OscType]| {
        let mut heard = scene.hears(addr, args);
        assert_eq!(heard.len(), 1, "{addr} {heard:?}");
        heard.remove(0)
    };
    assert!(matches!(one("/pattern/walk/play", &[]), Signal::Start(_, name) if name == "walk"));
    assert!(matches!(one("/pattern/walk/stop", &[]), Signal::StopNamed(name) if name == "walk"));
    assert!(matches!(one("/control/depth", &[1.into()]), Signal::Set(name, 1.0) if name == "depth"));
    assert!(
        matches!(one("/journal/note", &[s("trial"), 7.into()]), Signal::Note(text) if text == "\"trial\" 7")
    );
    assert!(matches!(one("/calm", &[]), Signal::Calm));
    assert!(matches!(one("/arm", &[true.into()]), Signal::Arm(true)));
    assert!(matches!(one("/arm", &[0.into()]), Signal::Arm(false)));
    let Signal::Osc(address, numbers) = one("/hit/*", &[f(0.25), 3.into()]) else { panic!() };
    assert_eq!((address.as_str(), numbers.as_slice()), ("/hit/left", &[0.25, 3.0][..]));
    assert!(!scene.handle.board().is_panicked());
    assert!(matches!(one("/panic", &[]), Signal::Panic));
    assert!(scene.handle.board().is_panicked());
    assert_eq!(scene.hears("/voice/*/play", &[]).len(), 3);
    assert_eq!(scene.hears("/control/*", &[f(1.0)]).len(), 2);
    assert_eq!(scene.counts().trouble(), None);
    assert_eq!(scene.counts().taken.get(), 15);
}

#[test]
fn ids_release_what_they_played() {
    let scene = Scene::new();
    let numbers = |heard: Vec<Signal>| -> Vec<u64> {
        heard.iter().map(|signal| if let Signal::Play(n, ..) = signal { *n } else { panic!() }).collect()
    };
    let released = |id: i32| -> Vec<u64> {
        let heard = scene.hears("/voice/release", &[id.into()]);
        heard.iter().map(|signal| if let Signal::Release(n) = signal { *n } else { panic!() }).collect()
    };
    let seven = numbers(scene.hears("/voice/low/play", &[f(0.5), s("id"), 7.into()]));
    let eight = numbers(scene.hears("/voice/{low,high}/play", &[s("id"), 8.into()]));
    assert_eq!((seven.len(), eight.len()), (1, 2));
    let touched: Vec<(u64, Touch)> = scene
        .hears("/voice/bend", &[8.into(), f(-1.5)])
        .into_iter()
        .map(|signal| if let Signal::Touch(n, touch) = signal { (n, touch) } else { panic!() })
        .collect();
    assert_eq!(touched, eight.iter().map(|n| (*n, Touch::Bend(-1.5))).collect::<Vec<_>>());
    assert!(matches!(
        scene.hears("/voice/timbre", &[7.into(), 1.into()])[..],
        [Signal::Touch(_, Touch::Timbre(1.0))]
    ));
    assert_eq!(released(8), eight);
    assert_eq!(released(7), seven);
    assert_eq!(scene.counts().unknown.get(), 0);
    assert!(released(7).is_empty() && scene.hears("/voice/bend", &[7.into(), 1.into()]).is_empty());
    assert_eq!(scene.counts().unknown.get(), 2);
    let known = "nothing that was played under the id 7 is known any more";
    scene.vain(&[("/voice/release", known), ("/voice/bend", known)]);
}

#[test]
fn controls_are_told_as_they_were_sent_and_voices_and_patterns_by_name() {
    let scene = Scene::new();
    let told = |addr: &str, args: &[OscType]| {
        scene.say(addr, args);
        scene.settle()
    };
    assert_eq!(told("/control/depth/get", &[]), [("/control/depth".into(), vec![f(0.5)])]);
    for (value, kept) in
        [(OscType::Double(1.5), 1.5), (1.into(), 1.0), (OscType::Long(9), 2.0), (false.into(), 0.0)]
    {
        assert_eq!(told("/control/depth", &[value]), []);
        assert_eq!(told("/control/d*/get", &[]), [("/control/depth".into(), vec![f(kept)])]);
    }
    let list = [
        ("/controls".into(), vec![s("depth"), f(0.0), f(0.0), f(2.0), f(0.5), s("mm")]),
        ("/controls".into(), vec![s("tempo"), f(90.0), f(30.0), f(240.0), f(90.0), s("")]),
        ("/controls/end".into(), vec![2.into()]),
    ];
    assert_eq!(told("/controls", &[]), list);
    let names = |kind: &str, names: &[&str]| {
        let mut all: Vec<_> = names.iter().map(|name| (format!("/{kind}"), vec![s(name)])).collect();
        all.push((format!("/{kind}/end"), vec![(names.len() as i32).into()]));
        all
    };
    assert_eq!(told("/voices", &[]), names("voices", &["low", "high", "release"]));
    assert_eq!(told("/patterns", &[]), names("patterns", &["walk"]));
    assert_eq!(told("/patterns", &[0.into()]), []);
    // Another patch: what it still has is where it was.
    let other = PATCH.replace("control.tempo", "control.rest").replace("default = 0.5", "default = 1");
    scene.server.follow(&Patch::parse("p", other.as_bytes()).unwrap().value);
    scene.settle();
    let told = told("/control/*/get", &[]);
    assert_eq!(told, [("/control/depth".into(), vec![f(0.0)]), ("/control/rest".into(), vec![f(90.0)])]);
}

#[test]
fn answers() {
    let scene = Scene::new();
    let told = |addr: &str, args: &[OscType]| {
        scene.say(addr, args);
        scene.settle()
    };
    let board = scene.handle.board();
    board.frames.set(5_000_000_000);
    board.refused.of(Way::Key).set(7);
    let figures = [&board.voices, &board.xruns, &board.late, &board.dropped, board.refused.of(Way::Midi)];
    figures.iter().zip([3, 2, 4, 5, 6]).for_each(|(figure, value)| figure.set(value));
    let status = vec![OscType::Long(5_000_000_000), 3.into(), f(0.0), 2.into(), 4.into(), 18.into()];
    let by_source = [6, 0, 7, 0, 0].map(OscType::Int);
    let status: Vec<OscType> = status.into_iter().chain(by_source).collect();
    assert_eq!(told("/status", &[]), [("/status".into(), status)]);
}

/// Not what was last said here, but where it stands, whoever moved it.
#[test]
fn a_control_is_where_the_session_has_it() {
    let scene = Scene::new();
    let get = || {
        scene.say("/control/depth/get", &[]);
        scene.settle().remove(0).1[0].clone()
    };
    let values = &scene.handle.board().values;
    assert_eq!(get(), f(0.5));
    values.show([("depth", 1.25)].into_iter());
    assert_eq!(get(), f(1.25), "moved by another");
    scene.say("/control/depth", &[f(0.75)]);
    assert_eq!(get(), f(0.75), "the session has not come to it yet");
    let id = scene.heard().last().unwrap().id;
    values.show([("depth", 0.75)].into_iter());
    values.done([0, id, 0, 0]);
    values.show([("depth", 2.0)].into_iter());
    assert_eq!(get(), f(2.0), "moved again by another");
    scene.say("/controls", &[]);
    assert_eq!(scene.settle()[0].1[1], f(2.0));
}

/// Two servers that were made to talk to each other, by a sender that says it is another, would go on for ever.
#[test]
fn no_answer_is_answered() {
    let scene = Scene::new();
    scene.say("/control/*/get", &[]);
    scene.say("/controls", &[]);
    scene.say("/voices", &[]);
    scene.say("/patterns", &[]);
    scene.say("/status", &[]);
    scene.say("/meter/subscribe", &[10_000.into()]);
    let mut answers = scene.settle();
    assert_eq!(answers.len(), 13);
    answers.extend([("/pong".into(), vec![]), ("/meter".into(), vec![f(0.5); 3]), ("/meter".into(), vec![])]);
    answers.iter().for_each(|(addr, args)| scene.say(addr, args));
    assert_eq!(scene.settle(), []);
}

#[test]
fn reports_come_again_and_again_until_nobody_wants_them() {
    let scene = Scene::new();
    let next = || receive(&scene.client);
    scene.say("/meter/subscribe", &[10.into()]);
    assert_eq!(next(), ("/meter/subscribed".into(), vec![10.into(), 60.into()]));
    for _ in 0..3 {
        assert_eq!(next(), ("/meter".into(), vec![f(0.0); 3]));
    }
    scene.say("/meter/unsubscribe", &[]);
    scene.settle();
    scene.say("/control/tempo/get", &[10.into()]);
    for _ in 0..3 {
        assert_eq!(next(), ("/control/tempo".into(), vec![f(90.0)]));
    }
    scene.say("/control/tempo/get", &[0.into()]);
    scene.settle();
    scene.client.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    assert!(scene.client.recv_from(&mut [0; 99]).is_err(), "nobody wants it any more");
    // As many peers as there is room for.
    let crowd: Vec<UdpSocket> = (0..MOST_PEERS).map(|_| client()).collect();
    let subscribe = encoder::encode(&message("/meter/subscribe", &[10_000.into()])).unwrap();
    for peer in &crowd {
        peer.send_to(&subscribe, scene.server.address()).unwrap();
        assert_eq!(receive(peer).0, "/meter/subscribed");
    }
    scene.client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    scene.say("/meter/subscribe", &[]);
    assert_eq!(scene.settle(), []);
    assert_eq!(scene.counts().crowded.get(), 1);
}

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

/// Whoever pulls the brake waits for nothing that came before, and nothing that came before lets it go.
#[test]
fn a_brake_is_pulled_before_what_waits_is_done() {
    let scene = Scene::new();
    // Each of these takes all the steps that a datagram may take.
    let costly = message(&format!("/control/{}0", "*{a,}".repeat(48)), &[f(1.0)]);
    let costly = encoder::encode(&bundle(0, vec![costly; 200])).unwrap();
    let total = 40;
    (0..total).for_each(|_| scene.send_bytes(&costly));
    scene.say("/calm", &[]);
    scene.say("/voice/low/play", &[]);
    scene.say("/panic", &[]);
    let board = scene.handle.board();
    while !board.is_panicked() {
        std::thread::sleep(Duration::from_micros(100));
    }
    let done = scene.counts().messages.get();
    assert!(done < total * 200, "{done} messages were read before");
    scene.settle();
    assert!(board.is_panicked() && board.lever.pulls() == 1);
    let heard: Vec<_> = scene.heard().into_iter().map(|stamped| stamped.signal).collect();
    assert!(matches!(&heard[..], [Signal::Play(..), Signal::Panic]), "{} heard", heard.len());
    assert_eq!((scene.counts().messages.get(), scene.counts().cancelled.get()), (total * 200 + 4, 1));
    // A journal has some of it, and the rest is counted.
    let written = scene.vain.take().len() as u64;
    assert!((256..1500).contains(&written), "{written} written");
    assert_eq!(scene.counts().unwritten.get() + written, total * 200 + 1);
    // Behind it, even in the same datagram, it is let go.
    scene.send(&bundle(0, vec![message("/panic", &[]), message("/calm", &[])]));
    scene.settle();
    let heard = scene.heard();
    assert!(matches!(
        &heard[..],
        [Stamped { signal: Signal::Panic, .. }, Stamped { signal: Signal::Calm, .. }]
    ));
    assert_eq!(heard[1].pulls, board.lever.pulls());
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

#[test]
fn what_cannot_be_done_is_counted_by_kind() {
    let scene = Scene::new();
    scene.say("/voice/none/play", &[]);
    scene.say("/nothing", &[]);
    scene.say("/control/depth", &[s("high")]);
    scene.say("/control/*", &[f(f32::NAN)]);
    scene.say("/voice/[low/play", &[]);
    scene.send_bytes(b"");
    scene.send_bytes(b"hello");
    scene.send(&(0..20).fold(message("/ping", &[]), |inner, _| bundle(0, vec![inner])));
    scene.say("/voice/low/play", &[s("place"), OscType::Array(OscArray { content: vec![] })]);
    assert_eq!(scene.settle(), []);
    let c = scene.counts();
    assert_eq!((c.unknown.get(), c.wrong.get(), c.malformed.get(), c.deep.get()), (2, 4, 3, 1));
    assert_eq!((c.datagrams.get(), c.messages.get(), c.taken.get()), (10, 7, 0));
    assert_eq!(scene.heard().len(), 0);
    scene.vain(&[
        ("/voice/none/play", "nothing is at `/voice/none/play`: did you mean"),
        ("/nothing", "nothing is at `/nothing`"),
        ("/control/depth", "`/control/depth` takes a number, and was sent \"high\""),
        ("/control/*", "`/control/*` takes a number, and was sent NaN"),
        ("/control/*", "`/control/*` takes a number"),
        ("/voice/[low/play", "its address is too long, or no pattern"),
        ("/voice/low/play", "takes a level, a duration"),
    ]);
    assert_eq!((c.unwritten.get(), scene.handle.board().refused.get()), (0, 0));
}

/// Nobody takes the signals: as many as may wait are taken, the rest is counted, and the server goes on.
#[test]
fn what_the_session_refuses_is_counted() {
    let scene = Scene::new();
    let play = encoder::encode(&message("/voice/low/play", &[])).unwrap();
    for _ in 0..50 {
        (0..100).for_each(|_| scene.send_bytes(&play));
        scene.settle();
    }
    let c = scene.counts();
    assert_eq!(
        (c.taken.get(), c.refused.get()),
        (Way::Osc.capacity() as u64, 5000 - Way::Osc.capacity() as u64)
    );
    assert_eq!(scene.handle.board().refused.get(), c.refused.get());
    // The brake works all the same.
    scene.say("/panic", &[]);
    scene.settle();
    assert!(scene.handle.board().is_panicked());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    /// Whatever comes, the server answers afterwards, and every datagram is accounted for.
    #[test]
    fn nothing_stops_the_server(
        datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..60), 0..30),
        addresses in prop::collection::vec("/(voice|control|pattern|\\*|[a-z{}\\[*?]{0,5})/[a-z{},*?]{0,6}(/play|/get|/stop)?", 0..30),
        numbers in prop::collection::vec(any::<f32>(), 0..3),
    ) {
        let scene = Scene::new();
        let args: Vec<OscType> = numbers.into_iter().map(OscType::Float).collect();
        datagrams.iter().for_each(|bytes| scene.send_bytes(bytes));
        addresses.iter().for_each(|addr| scene.say(addr, &args));
        scene.settle();
        let c = scene.counts();
        assert_eq!(c.datagrams.get(), (datagrams.len() + addresses.len() + 1) as u64);
        assert_eq!(c.taken.get(), scene.heard().len() as u64);
    }
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
