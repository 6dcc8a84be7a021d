//! Clicks through a card that lets nothing steady through: what it takes of them is given beforehand.

use super::common::scenes::{MOTORS, MOVES};
use super::common::{channel, patch, run};
use super::{CLICK, COIN, PAD, RATE, SPIN, STOP, SWELL, SWITCH, THUMP, largest, play, speeds};
use pacinian::actuator::link::coupling::{Corners, HighPass};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::graph::plan::{self, Why};
use pacinian::graph::scene::{Options, Scene, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::{Rig, Terminals};
use pacinian::schedule::Instant;

/// The motors of the other tests, there for clicks alone, behind these corners of card and amplifier, hertz; 0: none.
fn coupled(card: f64, amplifier: f64) -> String {
    let of = |hertz: f64| match hertz {
        0.0 => "coupling = \"dc\"".to_string(),
        hertz => format!("coupling = {{ high_pass = {hertz:?} }}"),
    };
    let rig = MOTORS
        .replace("amplifier = \"bridge\"\n", "amplifier = \"bridge\"\nshaping = \"clicks\"\n")
        .replace("overdrive", "clicks");
    let (before, behind) = rig.split_once("[amplifier.bridge]").unwrap();
    let before = before.replace("coupling = \"dc\"", &of(card));
    format!("{before}[amplifier.bridge]{}", behind.replace("coupling = \"dc\"", &of(amplifier)))
}

fn planned(rig: &str) -> Scene {
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch(MOVES), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

/// Samples of a motor's channel.
fn sent(plan: &plan::Plan, drive: usize, events: &[(f64, Event)], seconds: f64, calls: &[usize]) -> Vec<f64> {
    let mut engine = Engine::new(plan).unwrap();
    for (at, event) in events {
        let at = Instant::of_samples(at * plan.engine_rate());
        assert!(engine.schedule(at, Source::Program, *event));
    }
    let frames = run(&mut engine, (seconds * RATE) as usize, calls);
    channel(&frames, plan.channels, plan.drives[drive].channel as usize)
}

/// What arrives of samples behind corners, volts.
fn through(drive: &plan::Drive, corners: &Corners, samples: &[f64]) -> Vec<f64> {
    let mut filter = HighPass::new(corners, RATE).unwrap();
    samples.iter().map(|x| filter.step(*x) * drive.per_sample).collect()
}

fn clicks(place: u32) -> [(f64, Event); 3] {
    [(0.01, CLICK, 1.0), (0.09, CLICK, -0.5), (0.16, THUMP, 0.7)]
        .map(|(at, instrument, level)| (at, Event::Play(play(instrument, place, level, 0.01))))
}

/// A quarter of a turn, a weaker one back before the coupling has forgotten the first, and a thump: each turns the mass as far as it does where
/// everything passes, and ends at rest; sent as they are, they do not. Of the pad's thump the higher corners keep something off.
#[test]
fn clicks_arrive_through_coupling() {
    let mut short = 0;
    for (corners, card, amplifier) in [
        (Corners::one(2.0), 2.0, 0.0),
        (Corners::one(10.0), 0.0, 10.0),
        (Corners::one(20.0), 20.0, 0.0),
        (Corners::two(6.0, 8.0), 6.0, 8.0),
    ] {
        let plan = planned(&coupled(card, amplifier)).plan;
        for (n, place) in [(0, COIN), (1, PAD)] {
            let drive = &plan.drives[n];
            assert_eq!(drive.terminals, Terminals::Coupled(corners));
            for (at, event) in clicks(place) {
                let Event::Play(one) = event else { panic!() };
                let far = if one.instrument == CLICK { 0.25 } else { -1.5 };
                let known = plan.clicks.iter().find(|clicks| clicks.drive == n && clicks.turns == far);
                let arriving = known.unwrap().arriving;
                if arriving != far {
                    // The strongest turns it as far as is told.
                    short += 1;
                    let strongest = Event::Play(play(one.instrument, place, 1.0, 0.01));
                    let samples = sent(&plan, n, &[(0.01, strongest)], 1.5, &[480]);
                    let turned = speeds(&drive.setup.parameters, &through(drive, &corners, &samples));
                    let turns = turned.iter().sum::<f64>() / RATE / std::f64::consts::TAU;
                    assert!(
                        (turns - arriving).abs() < 0.01 * far.abs(),
                        "{corners:?} {place}: {turns} {arriving}"
                    );
                    assert!(arriving / far > 0.5 && arriving / far < 0.999, "{arriving}");
                    continue;
                }
                let samples = sent(&plan, n, &[(at, event)], 1.5, &[480]);
                let parameters = &drive.setup.parameters;
                let volts = through(drive, &corners, &samples);
                let turned = speeds(parameters, &volts);
                // Over with the last that is more than what does not matter.
                let quiet = 0.5 * parameters.start_volts() * (1.0 + 1e-6);
                let end = volts.iter().rposition(|volts| volts.abs() > quiet).unwrap() + 1;
                let peak = largest(&turned);
                assert!(turned[end].abs() < 0.005 * peak, "{corners:?} {place} {at}: {}", turned[end] / peak);
                let turns: f64 = turned.iter().sum::<f64>() / RATE / std::f64::consts::TAU;
                let due = far * one.level.signum();
                assert!((turns / due - 1.0).abs() < 0.02, "{corners:?} {place} {at}: {turns}");
                assert!(samples[samples.len() - 480..].iter().all(|x| *x == 0.0), "it is over");
                // Sent as it is where all passes, it turns it elsewhere.
                let first = volts.iter().position(|volts| volts.abs() > quiet).unwrap();
                let plain: Vec<f64> = volts[first..end]
                    .iter()
                    .map(|volts| volts / drive.per_sample)
                    .chain([0.0; 4800])
                    .collect();
                let plainly = speeds(parameters, &through(drive, &corners, &plain));
                let plain_turns: f64 = plainly.iter().sum::<f64>() / RATE / std::f64::consts::TAU;
                let least = if card == 2.0 { 0.002 } else { 0.02 };
                assert!((plain_turns / due - 1.0).abs() > least, "{corners:?} {place} {at}: {plain_turns}");
            }
        }
    }
    assert!((1..=2).contains(&short), "{short}");
}

/// Three in a row before the coupling is empty: what arrives is what arrives where everything passes, of the same volts, frame by frame.
#[test]
fn clicks_in_a_row_arrive_as_if_there_were_no_coupling() {
    let corners = Corners::two(5.0, 10.0);
    let rig = coupled(5.0, 10.0);
    let plan = planned(&rig).plan;
    // The same clicks, as strong as they are behind the coupling.
    let mut free = planned(&coupled(0.0, 0.0)).plan;
    assert!(free.drives.iter().all(|drive| drive.terminals == Terminals::Straight));
    free.clicks.clone_from(&plan.clicks);
    let rows = |place: u32| {
        [(0.01, 1.0), (0.06, -0.5), (0.1, 0.7)]
            .map(|(at, level)| (at, Event::Play(play(CLICK, place, level, 0.01))))
    };
    for (n, place) in [(0, COIN), (1, PAD)] {
        let drive = &plan.drives[n];
        let samples = sent(&plan, n, &rows(place), 0.5, &[480]);
        assert_eq!(samples, sent(&plan, n, &rows(place), 0.5, &[1, 7, 64, 333]), "cut otherwise, otherwise");
        let volts = through(drive, &corners, &samples);
        let wanted: Vec<f64> =
            sent(&free, n, &rows(place), 0.5, &[480]).iter().map(|x| x * drive.per_sample).collect();
        let quiet = 0.5 * drive.setup.parameters.start_volts();
        for (frame, (got, wanted)) in volts.iter().zip(&wanted).enumerate() {
            // Samples are of single precision, also those that the coupling has seen so far.
            let within = if *wanted == 0.0 { quiet } else { 1e-4 * drive.setup.limit };
            assert!((got - wanted).abs() <= within * (1.0 + 1e-5), "{place} {frame}: {got} {wanted}");
        }
        assert!(samples.iter().all(|x| x.abs() < 1.0));
    }
    // So soon behind one another that there is no room: less arrives, and that is counted.
    let mut engine = Engine::new(&plan).unwrap();
    for n in 0..4 {
        let at = Instant::of_samples((0.01 + 0.04 * f64::from(n)) * plan.engine_rate());
        assert!(engine.schedule(at, Source::Program, Event::Play(play(THUMP, PAD, 1.0, 0.01))));
    }
    let frames = run(&mut engine, (0.4 * RATE) as usize, &[480]);
    assert!(engine.stage().counts().clamped > 0 && frames.iter().all(|x| x.abs() <= 1.0));
}

/// Faster than the coupling bears: each turns the mass less far than it should, which is counted; but none is driven backward, as it would be by the
/// whole of what brakes a whole one, and the model knows where the mass is, so that all ends at rest.
#[test]
fn what_lost_its_beginning_is_not_driven_backward() {
    let corners = Corners::one(20.0);
    let plan = planned(&coupled(20.0, 0.0)).plan;
    for (n, place) in [(0, COIN), (1, PAD)] {
        let drive = &plan.drives[n];
        let every = 0.02;
        let rows: Vec<(f64, Event)> = (0..16)
            .map(|k| (0.01 + every * f64::from(k), Event::Play(play(CLICK, place, 1.0, 0.01))))
            .collect();
        let mut engine = Engine::new(&plan).unwrap();
        for (at, event) in &rows {
            assert!(engine.schedule(Instant::of_samples(at * plan.engine_rate()), Source::Program, *event));
        }
        let frames = run(&mut engine, (0.8 * RATE) as usize, &[480]);
        let samples = channel(&frames, plan.channels, drive.channel as usize);
        let turned = speeds(&drive.setup.parameters, &through(drive, &corners, &samples));
        let counts = engine.stage().drives().counts_of(drive.channel as usize).unwrap();
        let (peak, least) = (largest(&turned), turned.iter().copied().fold(0.0, f64::min));
        let turns: f64 = turned.iter().sum::<f64>() / RATE / std::f64::consts::TAU;
        assert!(least > -0.002 * peak, "{place}: backward, {}", least / peak);
        assert!(turned.last().unwrap().abs() < 1e-3 * peak);
        // The coin's find room, the pad's ask for more than there is.
        let (cut, most) = if place == COIN { (0..=2, 4.01) } else { (10..=16, 3.0) };
        assert!(cut.contains(&counts.cut), "{place}: {counts:?}");
        assert!(turns > if place == COIN { 3.98 } else { 1.2 } && turns < most, "{place}: {turns}");
    }
}

/// Neither levels nor anything that lasts is sent; that orders are left out is said.
#[test]
fn only_clicks_are_played() {
    let scene = planned(&coupled(10.0, 0.0));
    let told: Vec<&str> = scene
        .plan
        .left_out
        .iter()
        .filter(|left| left.why == Why::ClicksAlone)
        .map(|left| left.what.as_str())
        .collect();
    assert!(told.len() == 2 && told.iter().all(|what| what.contains("on `coin`, `pad`")), "{told:?}");
    for instrument in [SPIN, SWITCH, SWELL] {
        let mut engine = Engine::new(&scene.plan).unwrap();
        let at = Instant::of_samples(0.01 * scene.plan.engine_rate());
        let event = Event::Play(play(instrument, COIN, 1.0, 0.2));
        assert!(engine.schedule(at, Source::Program, event));
        let frames = run(&mut engine, (0.4 * RATE) as usize, &[480]);
        assert!(frames.iter().all(|x| *x == 0.0), "{instrument}");
        let counts = engine.stage().drives().counts_of(scene.plan.drives[0].channel as usize).unwrap();
        assert_eq!(counts.unplayed > 1000, instrument == SWELL, "{instrument}: {counts:?}");
        assert!(counts.unplayed > 0, "{instrument}");
    }
    // A brake ends a thump on its way.
    let thump = Event::Play(play(THUMP, COIN, 0.5, 0.01));
    let stop = Event::Play(play(STOP, COIN, 1.0, 0.01));
    let turns = |events: &[(f64, Event)]| {
        let drive = &scene.plan.drives[0];
        let volts = through(drive, &Corners::one(10.0), &sent(&scene.plan, 0, events, 0.5, &[480]));
        speeds(&drive.setup.parameters, &volts).iter().sum::<f64>() / RATE / std::f64::consts::TAU
    };
    let [whole, braked] = [turns(&[(0.01, thump)]), turns(&[(0.01, thump), (0.018, stop)])];
    assert!(whole < -1.4 && braked > -1.0 && braked < -0.02, "{whole} {braked}");
}

/// The strongest click is one that arrives whole; where none does, what is missing is told.
#[test]
fn the_strongest_click_is_one_that_can_be_made_up_for() {
    let strongest = |rig: &str| {
        let plan = planned(rig).plan;
        let of = |n: usize| {
            let clicks =
                plan.clicks.iter().find(|clicks| clicks.drive == 0 && clicks.turns == [0.25, -1.5][n]);
            let clicks = clicks.unwrap();
            (clicks.book.strongest().list[0].1.abs(), clicks.arriving)
        };
        [of(0), of(1)]
    };
    let [whole, thump] = strongest(&coupled(0.0, 0.0));
    assert_eq!((whole.1, thump.1), (0.25, -1.5));
    let [ten, long] = strongest(&coupled(10.0, 0.0));
    let [twenty, longer] = strongest(&coupled(20.0, 0.0));
    assert!(twenty.0 <= ten.0 && ten.0 <= whole.0 && longer.0 <= long.0 && long.0 <= thump.0);
    assert_eq!((ten.1, twenty.1), (0.25, 0.25));
    // So little room that next to nothing of it gets through.
    let short =
        coupled(200.0, 0.0).replace("shaping = \"clicks\"\n", "shaping = \"clicks\"\nmax_level = 0.3\n");
    let short = Rig::parse("rig.toml", short.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let told = scene(&patch(MOVES), &short, &options, &NoAssets).unwrap_err().to_string();
    assert!(told.contains("of which the coupling to the motor of `coin` lets no more than"), "{told}");
}

#[test]
fn what_is_not_known_to_pass_clicks_is_refused() {
    let of = |rig: &str| Rig::parse("rig.toml", rig.as_bytes()).map(|_| ()).unwrap_err().to_string();
    let rig = coupled(10.0, 0.0);
    let told = of(&rig.replace("coupling = { high_pass = 10.0 }\n", ""));
    assert!(told.contains("not known to let a steady voltage through"), "{told}");
    let free = rig.replace("part = \"coin-10mm\"", "part = \"coin-10mm\"\ncoulomb_friction = 0.0");
    assert!(of(&free).contains("nothing holds the motor of `coin`"), "{}", of(&free));
    let told = of(&rig.replace("shaping = \"clicks\"\n", ""));
    assert!(told.contains("high-pass at 10 Hz") && told.contains("shaping = \"clicks\""), "{told}");
}
