use super::budget::Budget;
use super::chain::{Chain, Input, Limits, Stage, Trip};
use crate::dsp::random::uniform;
use proptest::prelude::{ProptestConfig, prop_assert, proptest};

const T: f64 = 1e-3;

fn limits() -> Limits {
    Limits {
        period: T,
        slew: 1e9,
        low_pass: None,
        continuous: 0.023,
        winding: 12.0,
        peak: 0.175,
        soft_start: 0.0,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    }
}

fn ask(torque: f64) -> Input {
    Input { torque, angle: 0.1, velocity: 0.0, fresh: true, in_time: true, governed: false }
}

fn armed(limits: &Limits) -> Chain {
    let mut chain = Chain::new(limits).unwrap();
    assert!(chain.arm());
    chain
}

/// A winding of 12 s, 23 mN m: from cold, times until the continuous load.
#[test]
fn an_overload_lasts_as_long_as_the_winding_is_cool() {
    let budget = Budget::new(0.023, 12.0, 0.24, T).unwrap();
    for (times, seconds) in [(0.175 / 0.023, 0.21), (2.0, 3.45), (3.0, 1.41), (5.0, 0.49)] {
        let got = budget.time_to_limit(times * 0.023);
        assert!((got - seconds).abs() < 0.005, "{times}: {got}");
        let mut b = budget;
        let mut ticks = 0;
        while b.load() < 1.0 {
            b.spend(times * 0.023);
            ticks += 1;
        }
        assert!((f64::from(ticks) * T - got).abs() < 2.0 * T, "{times}: {ticks}");
    }
    assert!(budget.time_to_limit(0.023).is_infinite());
}

#[test]
fn the_budget_ends_at_the_continuous_torque() {
    let mut chain = armed(&limits());
    let (mut last, mut most) = (f64::INFINITY, 0.0f64);
    for tick in 0..60_000 {
        let out = chain.tick(&ask(1.0));
        most = most.max(chain.load());
        assert!(out.torque <= last + 1e-15 && out.torque <= 0.175);
        last = out.torque;
        assert!(tick > 1 || out.acted(Stage::Peak));
    }
    assert!((last / 0.023 - 1.0).abs() < 1e-6 && most <= 1.0 + 1e-12, "{last} {most}");
    assert!(chain.count(Stage::Budget) > 50_000 && chain.count(Stage::Peak) > 50);
    // At the peak for the half of the 0.21 s that a winding bears: 12 s ln(1 / (1 − 0.5 / 57.9)).
    let mut chain = armed(&limits());
    let at_peak = (0..1000).take_while(|_| chain.tick(&ask(1.0)).torque == 0.175).count();
    assert!((103..=105).contains(&at_peak), "{at_peak}");
}

#[test]
fn nothing_flows_until_it_is_armed_and_then_it_rises() {
    let mut chain = Chain::new(&Limits { soft_start: 0.1, ..limits() }).unwrap();
    assert_eq!(chain.tick(&ask(0.01)).torque, 0.0);
    chain.arm();
    for k in 1..=100 {
        let out = chain.tick(&ask(0.01));
        assert!((out.torque - 1e-4 * f64::from(k)).abs() < 1e-15, "{k}");
    }
    assert_eq!((chain.tick(&ask(0.01)).torque, chain.count(Stage::SoftStart)), (0.01, 99));
    chain.disarm();
    assert_eq!(chain.tick(&ask(0.01)).torque, 0.0);
}

#[test]
fn torque_changes_no_faster_than_it_may() {
    let mut chain = armed(&Limits { slew: 1.0, ..limits() });
    let mut last = 0.0;
    for n in 0..5000 {
        let torque = chain.tick(&ask(0.02 * uniform(1, n / 40))).torque;
        assert!((torque - last).abs() <= 1e-3 + 1e-15);
        last = torque;
    }
    assert!(chain.count(Stage::Slew) > 100);
    (0..100).for_each(|_| last = chain.tick(&ask(0.0)).torque);
    assert_eq!(last, 0.0);
}

#[test]
fn a_torque_that_ends_ends_at_zero() {
    let mut chain = armed(&Limits { low_pass: Some(20.0), ..limits() });
    (0..100).for_each(|_| _ = chain.tick(&ask(0.02)));
    (0..400).for_each(|_| _ = chain.tick(&ask(0.0)));
    assert_eq!(chain.tick(&ask(0.0)).torque, 0.0);
}

/// Faults that demand it: exactly 0 in the tick that brings them, and until they are acknowledged and the chain is armed again.
#[test]
fn a_fault_ends_torque_within_its_tick() {
    let bad: [(Input, Trip, Stage); 4] = [
        (Input { angle: f64::NAN, ..ask(0.01) }, Trip::Reading, Stage::NonFinite),
        (Input { velocity: f64::INFINITY, ..ask(0.01) }, Trip::Reading, Stage::NonFinite),
        (Input { velocity: 60.1, ..ask(0.01) }, Trip::OverSpeed, Stage::OverSpeed),
        (Input { velocity: -1e9, ..ask(0.01) }, Trip::OverSpeed, Stage::OverSpeed),
    ];
    for (input, trip, stage) in bad {
        let mut chain = armed(&Limits { slew: 1e-3, low_pass: Some(50.0), ..limits() });
        (0..100).for_each(|_| _ = chain.tick(&ask(0.01)));
        assert!(chain.tick(&ask(0.01)).torque > 0.0);
        let out = chain.tick(&input);
        assert!(
            out.torque == 0.0 && out.acted(stage) && out.acted(Stage::Latch) && chain.trip() == Some(trip)
        );
        for _ in 0..10 {
            assert!(!chain.arm());
            assert_eq!(chain.tick(&ask(0.01)).torque, 0.0);
        }
        chain.acknowledge();
        assert_eq!(chain.tick(&ask(0.01)).torque, 0.0);
        assert!(chain.arm());
        // What was under way in slew and filter is forgotten.
        assert!(chain.tick(&ask(0.01)).torque < 1e-6);
    }
    let mut chain = armed(&limits());
    assert_eq!(chain.tick(&ask(0.01)).torque, 0.01);
    chain.panic();
    assert_eq!((chain.tick(&ask(0.01)).torque, chain.trip()), (0.0, Some(Trip::Panic)));
    // One sum that is no number is no fault of the knob's: 0 for its tick.
    let mut chain = armed(&limits());
    assert_eq!(chain.tick(&ask(f64::NAN)).torque, 0.0);
    assert_eq!((chain.tick(&ask(0.01)).torque, chain.count(Stage::NonFinite)), (0.01, 1));
}

#[test]
fn a_lost_sensor_or_deadline_lets_torque_fall() {
    for (input, wait) in
        [(Input { fresh: false, ..ask(0.02) }, 3), (Input { in_time: false, ..ask(0.02) }, 0)]
    {
        let mut chain = armed(&limits());
        assert_eq!(chain.tick(&ask(0.02)).torque, 0.02);
        for _ in 0..wait {
            assert_eq!(chain.tick(&input).torque, 0.02);
        }
        for k in 1..20 {
            let torque = chain.tick(&input).torque;
            assert!((torque - 1e-3 * f64::from(20 - k)).abs() < 1e-12, "{k}: {torque}");
        }
        chain.tick(&input);
        assert_eq!((chain.tick(&input).torque, chain.trip()), (0.0, Some(Trip::Lost)));
        assert!(chain.count(Stage::Stale) >= 20);
        // At once, where no time is given.
        let mut chain = armed(&Limits { release: 0.0, stale: 0, ..limits() });
        chain.tick(&ask(0.02));
        assert_eq!(chain.tick(&input).torque, 0.0);
    }
    // One that comes back in time is forgiven.
    let mut chain = armed(&limits());
    (0..10).for_each(|_| _ = chain.tick(&Input { fresh: false, ..ask(0.02) }));
    (0..10).for_each(|_| _ = chain.tick(&ask(0.02)));
    assert_eq!((chain.tick(&ask(0.02)).torque, chain.trip()), (0.02, None));
}

#[test]
fn limits_that_cannot_be_are_refused() {
    for (l, field) in [
        (Limits { period: 0.0, ..limits() }, "period"),
        (Limits { slew: 0.0, ..limits() }, "slew"),
        (Limits { low_pass: Some(499.0), ..limits() }, "low_pass"),
        (Limits { continuous: 0.2, ..limits() }, "continuous"),
        (Limits { continuous: 0.0, ..limits() }, "continuous"),
        (Limits { peak: f64::NAN, ..limits() }, "peak"),
        (Limits { winding: 0.0, ..limits() }, "winding"),
        (Limits { soft_start: -1.0, ..limits() }, "soft_start"),
        (Limits { release: f64::INFINITY, ..limits() }, "release"),
        (Limits { over_speed: 0.0, ..limits() }, "over_speed"),
    ] {
        assert_eq!(Chain::new(&l).unwrap_err().field, field);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever comes in: a number within the peak, 0 unless armed, and the winding never beyond its load.
    #[test]
    fn nothing_gets_past_it(seed in 0u64..10_000, low_pass in proptest::option::of(1.0f64..400.0)) {
        let mut chain = armed(&Limits { low_pass, slew: 10.0, soft_start: 0.01, ..limits() });
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0, 70.0, -0.01];
        for n in 0..3000u64 {
            let pick = |k: u64, usual: f64| {
                let at = ((uniform(seed + k, n) + 1.0) * 400.0) as usize;
                if at < wild.len() { wild[at] } else { usual }
            };
            let input = Input {
                torque: pick(1, uniform(seed + 4, n)),
                angle: pick(2, 0.3),
                velocity: pick(3, 5.0),
                fresh: uniform(seed + 5, n) < 0.9,
                in_time: uniform(seed + 6, n) < 0.98,
                governed: false,
            };
            let was = chain.armed();
            let out = chain.tick(&input);
            prop_assert!(out.torque.abs() <= 0.175 && (was || out.torque == 0.0));
            prop_assert!(chain.trip().is_none() || out.torque == 0.0);
            prop_assert!(chain.load() <= 1.0 + 1e-9);
            if n % 50 == 49 {
                chain.acknowledge();
                chain.arm();
            }
        }
    }
}
