use super::follower::Follower;
use super::model::{Contact, LocalModel};
use super::pending::{Message, Pending};
use crate::dsp::random::uniform;
use crate::knob::passivity::Observer;
use crate::knob::test_plant::Plant;

fn spring(stiffness: f64, centre: f64) -> LocalModel {
    LocalModel { stiffness, centre, ..LocalModel::FREE }
}

fn any(n: u64) -> LocalModel {
    let u = |k: u64| uniform(k, n);
    LocalModel {
        stamp: n,
        torque: 0.01 * u(1),
        stiffness: 0.1 * u(2).abs(),
        centre: u(3),
        contact: (u(4) > 0.0).then(|| Contact { angle: u(5), below: u(6) > 0.0, stiffness: u(7).abs() }),
        range: (-0.5 + 0.4 * u(8), 0.5 + 0.4 * u(9)),
    }
}

#[test]
fn torque_is_the_slope_of_energy() {
    for n in 0..200 {
        let m = any(n);
        m.check().unwrap();
        for k in 0..100 {
            let (angle, h) = (1.5 * uniform(n + 1, k), 1e-5);
            let slope = (m.energy(angle + h) - m.energy(angle - h)) / (2.0 * h);
            assert!((m.torque(angle) + slope).abs() < 2e-5 * (1.0 + m.most_stiffness()), "{m:?} {angle}");
        }
        // Beyond its range it stays what it was at the end.
        assert_eq!(m.torque(m.range.1 + 3.0), m.torque(m.range.1));
    }
}

/// However models follow one another, torque changes by no more than the knob's motion and the remainder's step explain.
#[test]
fn torque_never_jumps() {
    let over = 20;
    let mut f = Follower::new(over, u64::MAX).unwrap();
    let (mut angle, mut last, mut biggest) = (0.0, 0.0, 0.0f64);
    for n in 0..20_000u64 {
        let step = 1e-4 * uniform(3, n);
        angle += step;
        let model = any(n);
        let new = (uniform(11, n) > 0.9).then_some(&model);
        let stiffest = f.model().most_stiffness().max(model.most_stiffness());
        let torque = f.tick(n, angle, new).torque;
        // A remainder is at most the largest difference of two such models.
        let bound = stiffest * step.abs() + 6.0 / f64::from(over);
        assert!((torque - last).abs() <= bound + 1e-12, "{n}: {torque} {last}");
        biggest = biggest.max((torque - last).abs());
        last = torque;
    }
    assert!(biggest < 0.3);
    // In the tick of a change, a knob that stands feels nothing.
    for n in 0..1000 {
        let mut f = Follower::new(over, u64::MAX).unwrap();
        f.tick(0, 0.3, Some(&any(n)));
        (0..7).for_each(|k| _ = f.tick(k, 0.3, None));
        let before = f.clone();
        let changed = f.tick(8, 0.3, Some(&any(n + 5000))).torque;
        assert!((changed - before.clone().tick(8, 0.3, None).torque).abs() < 1e-12);
    }
    // And after all its ticks it is the model.
    let mut f = Follower::new(over, u64::MAX).unwrap();
    f.tick(0, 0.3, Some(&spring(0.2, 0.0)));
    (0..over).for_each(|k| _ = f.tick(u64::from(k), 0.3, None));
    assert_eq!(f.tick(99, 0.3, None).torque, -0.2 * 0.3);
}

/// Stiffened in place by ΔK at a stretch p: ½ ΔK p², over all ticks of the change.
#[test]
fn a_change_injects_what_the_closed_form_says() {
    let mut f = Follower::new(50, u64::MAX).unwrap();
    let (k, more, p) = (0.4, 0.3, 0.05);
    f.tick(0, 0.0, Some(&spring(k, 0.0)));
    (0..100).for_each(|n| _ = f.tick(n, 0.0, None));
    let mut sum = f.tick(0, p, Some(&spring(k + more, 0.0))).injected;
    (0..100).for_each(|n| sum += f.tick(n, p, None).injected);
    assert!((sum - 0.5 * more * p * p).abs() < 1e-15, "{sum}");
    // With the books: for a knob that swings without losses while models change, what may still come out is what the last model
    // holds, but for what the hold creates, which is of the order of the tick.
    let missing = |finer: u64| {
        let (t, every) = (1e-5 / finer as f64, 1000 * finer);
        let mut f = Follower::new(100 * finer as u32, u64::MAX).unwrap();
        let mut observer = Observer::default();
        let mut plant = Plant::new(6e-6, 0.0, 0.0, t);
        plant.angle = 0.1;
        let mut held = 0.0;
        for n in 0..20 * every {
            observer.observe(plant.angle, held);
            let model = spring(0.4 + 0.2 * uniform(2, n / every), 0.05 * uniform(4, n / every));
            let followed = f.tick(n, plant.angle, (n % every == 0).then_some(&model));
            observer.book(followed.injected);
            held = followed.torque;
            plant.step(held);
        }
        observer.observe(plant.angle, held);
        assert!((observer.absorbed() + plant.energy()).abs() < 1e-12 && observer.booked() > 1e-3);
        f.model().energy(plant.angle) - observer.balance()
    };
    let (coarse, fine) = (missing(1), missing(8));
    assert!(fine > 0.0 && (coarse / fine / 8.0 - 1.0).abs() < 0.1, "{coarse:e} {fine:e}");
}

#[test]
fn old_models_and_wrong_ones_go() {
    let mut f = Follower::new(10, 100).unwrap();
    f.tick(0, 0.2, Some(&LocalModel { stamp: 0, ..spring(0.1, 0.0) }));
    (1..=100).for_each(|n| _ = f.tick(n, 0.2, None));
    assert_eq!((f.tick(100, 0.2, None).torque, f.expired()), (-0.1 * 0.2, 0));
    (101..=112).for_each(|n| _ = f.tick(n, 0.2, None));
    assert_eq!((f.tick(113, 0.2, None).torque, f.expired()), (0.0, 1));
    let good = LocalModel { range: (0.0, 1.0), stamp: 200, ..spring(0.1, 0.0) };
    for (wrong, field) in [
        (LocalModel { torque: f64::NAN, ..good }, "torque"),
        (LocalModel { stiffness: -1.0, ..good }, "stiffness"),
        (LocalModel { centre: f64::INFINITY, ..good }, "centre"),
        (LocalModel { range: (1.0, 1.0), ..good }, "range"),
        (
            LocalModel { contact: Some(Contact { angle: 0.0, below: true, stiffness: f64::NAN }), ..good },
            "contact_stiffness",
        ),
    ] {
        assert_eq!(wrong.check().unwrap_err().field, field);
        assert_eq!(f.tick(200, 0.2, Some(&wrong)).torque, 0.0);
    }
    assert_eq!(f.refused(), 5);
    f.tick(200, 0.2, Some(&good));
    f.tick(201, 1.5, None);
    assert_eq!((f.outside(), f.tick(202, f64::NAN, None).torque), (1, 0.0));
    assert!(Follower::new(0, 1).is_err());
}

/// Against an endless queue: the same impulses, the same last model, and every message accounted for.
#[test]
fn a_full_queue_joins_and_loses_nothing() {
    let mut queue = Pending::<4>::default();
    let (mut sent, mut got, mut impulse) = (0u32, 0u32, 0.0);
    let mut newest = None;
    for n in 0..5000u64 {
        for _ in 0..((uniform(1, n) + 1.0) * 4.0) as usize {
            let message = Message::new(any(n), uniform(2, u64::from(sent)));
            impulse += message.impulse;
            newest = Some(message.model);
            sent += 1;
            queue.push(message);
            assert!(queue.len() <= 4);
        }
        if uniform(3, n) > 0.0 {
            let before = newest.take();
            let all = queue.drain();
            assert_eq!(all.map(|m| m.model), before);
            if let Some(all) = all {
                got += all.stands_for;
                impulse -= all.impulse;
                assert!(impulse.abs() < 1e-9);
            }
            assert!(queue.is_empty());
        }
    }
    got += queue.drain().map_or(0, |m| m.stands_for);
    assert!(got == sent && queue.coalesced() > 0);
    // In order while there is room.
    (0..3).for_each(|n| _ = queue.push(Message::new(any(n), 0.0)));
    (0..3).for_each(|n| assert_eq!(queue.pop().map(|m| m.model.stamp), Some(n)));
}
