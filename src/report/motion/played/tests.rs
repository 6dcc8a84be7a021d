//! What is read off what an actuator did.

use super::Played;

/// A wish of 100 rad/s from 0.1 s to 0.4 s, and a motor that has that speed from `from` on, if ever, until the wish ends.
fn late(from: Option<f64>) -> Played {
    let rate = 1000.0;
    let of = |begin: f64| {
        (0..600).map(move |n| if (begin..0.4).contains(&(n as f64 / rate)) { 100.0 } else { 0.0 })
    };
    let speeds: Vec<f64> = of(from.unwrap_or(1.0)).collect();
    Played {
        rate,
        drives: speeds.iter().map(|speed| 0.01 * speed).collect(),
        felt: speeds.iter().map(|speed| 1e-3 * speed * speed).collect(),
        energy: vec![0.0; 600],
        turned: vec![0.0; 600],
        wished: of(0.1).collect(),
        voices: vec![(0.1, "v".into())],
        speeds,
        ..Played::default()
    }
}

/// A rise counts from the wish, and what was missed before anything moved counts as well.
#[test]
fn what_begins_late_has_risen_late() {
    let stretches = late(Some(0.25)).stretches();
    assert_eq!(stretches.len(), 1);
    let [half, most] = stretches[0].rise.map(Option::unwrap);
    assert!((half - 0.151).abs() < 1e-9 && half == most, "{half} {most}");
    assert_eq!(stretches[0].voices, ["v"]);
    // All of it is missed for half of the time.
    assert!((stretches[0].error.unwrap() - 0.5_f64.sqrt()).abs() < 1e-9);
}

/// What was wished for and never moved was played none the less.
#[test]
fn what_never_moves_is_told() {
    let stretches = late(None).stretches();
    assert_eq!(stretches.len(), 1);
    assert_eq!((stretches[0].rise, stretches[0].error), ([None; 2], Some(1.0)));
    assert!((stretches[0].from, stretches[0].to) == (0.1, 0.4) && stretches[0].peak == 0.0);
}

/// Sent 50 ms late and 200 ms late, with 20 ms before its time that coupling asked for: side by side each stands where the patch has it, none of what was sent
/// is lost, and what is read off is what it was.
#[test]
fn what_is_late_stands_where_the_patch_has_it() {
    let sent = |late: f64, lead: usize| {
        let Played { drives, felt, speeds, wished, energy, turned, .. } = late_by_none();
        let silence = vec![0.0; (late * 1000.0) as usize];
        let of = |values: Vec<f64>| [silence.clone(), values].concat();
        let mut drives = of(drives);
        let first = drives.iter().position(|drive| *drive != 0.0).unwrap();
        drives[first - lead..first].fill(0.1);
        let [felt, speeds, wished] = [felt, speeds, wished].map(of);
        let [energy, turned] = [energy, turned].map(of);
        Played {
            late,
            before: late,
            drives,
            felt,
            speeds,
            wished,
            energy,
            turned,
            voices: vec![(0.0, "v".into())],
            ..Played { rate: 1000.0, ..Played::default() }
        }
    };
    for lead in [0, 20] {
        let alone = [sent(0.05, 0), sent(0.2, lead)];
        let mut both = alone.clone();
        Played::align(&mut both);
        let [first, second] = &both;
        assert_eq!((first.before, second.before), (1e-3 * lead as f64, 1e-3 * lead as f64));
        assert_eq!((first.late, second.late), (0.05, 0.2));
        assert_eq!(first.wished, second.wished);
        assert_eq!(first.speeds, second.speeds);
        let total = |played: &Played| played.drives.iter().sum::<f64>();
        assert_eq!(both.each_ref().map(total), alone.each_ref().map(total));
        for (aligned, alone) in both.iter().zip(&alone) {
            let (is, was) = (&aligned.stretches()[0], &alone.stretches()[0]);
            assert!((is.from - was.from).abs() < 1e-9 && (is.peak_at - was.peak_at).abs() < 1e-9);
            assert_eq!((&is.voices, is.error), (&was.voices, was.error));
            let rises = is.rise.iter().flatten().zip(was.rise.iter().flatten());
            assert!(is.rise[1].is_some() && rises.into_iter().all(|(is, was)| (is - was).abs() < 1e-9));
            assert!((is.peak_at - 0.0).abs() < 1e-9, "{is:?}");
        }
    }
}

/// A wish of 100 rad/s from the beginning, for 0.3 s, and a motor that has that speed at once.
fn late_by_none() -> Played {
    let mut played = late(Some(0.1));
    for values in [
        &mut played.drives,
        &mut played.speeds,
        &mut played.wished,
        &mut played.felt,
        &mut played.energy,
        &mut played.turned,
    ] {
        values.drain(..100);
    }
    played
}
