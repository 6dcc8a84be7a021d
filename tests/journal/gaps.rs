use pacinian::io::device::choose::Chosen;
use pacinian::io::device::keeper::Fate;
use pacinian::io::journal::reader::{Item, Reader};
use pacinian::io::journal::{Journal, Kind};
use pacinian::io::session::{Beginning, Session};

use super::{PATCH, folder, lines, reload, replayed, setting, until};

/// Each time that blocks came too late stands in the journal once, with the frame at which it was told; a replay passes over it.
#[test]
fn where_blocks_came_too_late_is_written_down() {
    let folder = folder("gaps");
    let path = folder.join("s.csv");
    let first = reload(PATCH);
    let journal = Journal::create(&path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
    let (hears, is_told) = (journal.clone(), journal.clone());
    let mut session = Session::start(Beginning {
        block: Some(64),
        listener: Some(Box::new(move |event| hears.hear(event))),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    until(&session, 4_800);
    let board = std::sync::Arc::clone(session.board());
    let own = board.xruns.get();
    board.gap();
    board.gap();
    let at = board.xrun_at.get();
    journal.gaps();
    journal.gaps();
    until(&session, 9_600);
    board.gap_of_input();
    until(&session, 12_000);
    session.stop();
    assert_eq!(journal.finish().unwrap(), 0);
    let lines = lines(&path);
    let gaps: Vec<_> = lines.iter().filter(|line| line.kind == Kind::Xrun).collect();
    // The virtual card may have had some of its own.
    let first = gaps.iter().find(|line| line.name.is_none()).unwrap();
    assert!(first.value.unwrap() >= 2.0 && first.frame.unwrap() >= at && at >= 4_800, "{first:?}");
    let all: f64 = gaps.iter().filter(|line| line.name.is_none()).map(|line| line.value.unwrap()).sum();
    assert!(all >= own as f64 + 2.0, "{all} of {own}");
    assert_eq!(all, board.xruns.get() as f64);
    let input: Vec<_> = gaps.iter().filter(|line| line.name.as_deref() == Some("input")).collect();
    assert_eq!(input.len(), 1);
    assert!(input[0].value == Some(1.0) && input[0].frame.unwrap() >= 9_600 && input[0].seconds.is_some());
    let (_, met) = replayed(&path);
    assert!(met.ended && met.lost == 0, "{met:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A device that is listened to may say something before the session has begun: it stands behind what tells of that.
#[test]
fn what_a_device_says_too_soon_stands_behind_the_head() {
    let folder = folder("soon");
    let path = folder.join("s.jsonl");
    let first = reload(PATCH);
    let journal = Journal::create(&path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
    journal.input_fate(&Fate::Said("early".into()));
    let is_told = journal.clone();
    let mut session = Session::start(Beginning {
        block: Some(64),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    until(&session, 2_400);
    session.stop();
    assert_eq!(journal.finish().unwrap(), 0);
    let head = Reader::open(&path).unwrap().read().unwrap();
    assert!(matches!(head, Some(Item::Session(_))), "{head:?}");
    let all = lines(&path);
    let said: Vec<_> = all.iter().filter(|line| line.kind == Kind::Device).collect();
    assert!(matches!(said[..], [line] if line.message.as_deref() == Some("early")), "{said:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}
