use std::sync::Arc;

use super::{Bench, compiled_with, reload, reload_with};
use crate::engine::event::Event;
use crate::live::callback::Deed;
use crate::live::signal::{Origin, Signal};
use crate::live::stamp::Stamp;
use crate::live::way::Way;
use crate::midi::{Channel, Message};

const FADER: &str = "[control.depth]\ndefault = 0.5\nrange = [0, 2]\n[[bind]]\nfrom = \"osc./1/fader1\"\ncontrol = \"depth\"\n\
    [voice.r]\noutput = \"o\"\n[voice.r.nodes]\ns = { type = \"sine\", frequency = 100 }\n\
    o = { type = \"multiply\", inputs = [\"s\", \"depth\"] }\n";

/// Whoever asks where a control stands hears of those who moved it otherwise.
#[test]
fn where_a_control_stands_is_shown_whoever_moved_it() {
    let mut bench = Bench::of(compiled_with(&["a"], FADER));
    let board = Arc::clone(&bench.conductor.board);
    assert_eq!(board.values.get("depth"), Some(0.5));
    bench.handle.set("depth", 1.25).unwrap();
    bench.conductor.listen();
    assert_eq!(board.values.get("depth"), Some(1.25));
    // It takes hold as it passes where the control stands.
    for position in [0.5, 0.75] {
        bench.handle.send(Signal::Osc("/1/fader1".into(), vec![position])).unwrap();
    }
    bench.conductor.listen();
    assert_eq!((board.values.get("depth"), board.values.get("width")), (Some(1.5), None));
    // What is asked of a session that has not come to one's own signal yet is not known.
    assert_eq!(board.values.since("depth", Way::Osc, 3), Some(1.5));
    assert_eq!(board.values.since("depth", Way::Osc, 4), None);
    // A brake is pulled with a number before what moves the control is sent, and is sent behind it.
    let brake = bench.handle.brake();
    bench.handle.send(Signal::Osc("/1/fader1".into(), vec![0.5])).unwrap();
    bench.handle.from(Origin::Osc("/panic".into(), "".into())).send_panic(Stamp(0), brake).unwrap();
    bench.conductor.listen();
    assert_eq!((brake, board.values.since("depth", Way::Osc, 5)), (4, Some(1.0)));
    // Another patch has others.
    bench.handle.send(Signal::Reload(reload(&["a"]))).unwrap();
    bench.conductor.listen();
    assert_eq!(board.values.get("depth"), None);
}

/// It is no less a control for that: a fader may move it, and whoever asks hears where it stands. A patch that reads it has it there.
#[test]
fn a_control_that_nothing_reads_stands_where_it_was_sent() {
    let unread = "[control.depth]\ndefault = 0.5\nrange = [0, 2]\n";
    let mut bench = Bench::of(compiled_with(&["a"], unread));
    let board = Arc::clone(&bench.conductor.board);
    bench.handle.set("depth", 1.25).unwrap();
    bench.conductor.listen();
    assert_eq!((board.undone.get(), board.values.get("depth")), (0, Some(1.25)));
    // As by a fader and an encoder that are bound to it.
    let bound = "[[bind]]\nfrom = \"osc./f\"\ncontrol = \"depth\"\npickup = false\n\
                 [[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"depth\"\nencoder = \"twos-complement\"\n";
    bench.handle.send(Signal::Reload(reload_with(&["a"], &format!("{unread}{bound}")))).unwrap();
    bench.conductor.listen();
    bench.turn(60);
    bench.handle.send(Signal::Osc("/f".into(), vec![0.25])).unwrap();
    bench.conductor.listen();
    assert_eq!((board.undone.get(), board.values.get("depth")), (0, Some(0.5)));
    let turned = Message::Controller { channel: Channel::new(0).unwrap(), number: 7, value: 1 };
    bench.handle.send(Signal::Midi(0, turned)).unwrap();
    bench.conductor.listen();
    assert!(board.undone.get() == 0 && board.values.get("depth").is_some_and(|value| value > 0.5));
    bench.handle.set("depth", 1.25).unwrap();
    bench.conductor.listen();
    bench.handle.set("width", 1.0).unwrap();
    bench.conductor.listen();
    assert_eq!(board.undone.get(), 1, "there is no such control");
    for (rest, told) in [(FADER, Some(1.25)), (unread, None), (FADER, Some(1.25))] {
        bench.reports.lock().unwrap().clear();
        bench.handle.send(Signal::Reload(reload_with(&["a"], rest))).unwrap();
        bench.conductor.listen();
        bench.turn(60);
        let mut swapped = false;
        let mut sent = Vec::new();
        for report in bench.reports.lock().unwrap().iter() {
            match report.deed {
                Deed::Swap => swapped = true,
                Deed::Event { event: Event::Glide(0, value, 0.0), .. } if swapped => sent.push(value),
                _ => {}
            }
        }
        assert_eq!((swapped, sent), (true, told.into_iter().collect()), "{rest}");
        assert_eq!(board.values.get("depth"), Some(1.25));
    }
}
