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

mod tags;

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
    assert!((256..total * 200).contains(&written), "{written} written");
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
