//! What of a click arrives behind coupling that keeps steady voltages off.

use super::bench::{Bench, Given, Run};
use crate::actuator::fault::Fault;
use crate::actuator::link::Chain;
use crate::actuator::link::coupling::Corners;
use crate::actuator::link::pulse::{Allowance, Shortfall, compensate, plain};
use crate::actuator::motor::Parameters;
use crate::actuator::shape::Clicked;

/// A click behind coupling, as it is sent and as it can be compensated.
#[derive(Debug, Clone)]
pub struct Behind {
    /// The corners that it passes.
    pub corners: Corners,
    /// Sent as it is.
    pub plain: Arrival,
    /// Compensated within the limits.
    pub compensated: Arrival,
    /// Seconds before and after the click that the compensation takes.
    pub lead: f64,
    /// See `lead`.
    pub tail: f64,
}

/// What arrives, and what the motor does of it.
#[derive(Debug, Clone)]
pub struct Arrival {
    /// Volts that are missing, and those that are there outside of the click.
    pub shortfall: Shortfall,
    /// Turns of the mass altogether.
    pub turns: f64,
    /// Speed when the click is over, as a share of the largest.
    pub left: f64,
    /// From the end of the click until the rotor stands, s; `None`: it still moved when it was given up.
    pub stop: Option<f64>,
    /// What the motor did.
    pub run: Run,
}

/// Seconds of lead-in and discharge that a click is given.
const LEAD: f64 = 0.5;
const TAIL: f64 = 4.0;
/// Share of what starts the motor that does not matter before and after; of full scale where everything starts it.
const QUIET: f64 = 0.5;
const NONE: f64 = 0.01;
/// Seconds behind a click in which what the coupling does to it is of note.
const AFTER: f64 = 0.2;

/// A click behind `corners` in place of those of the chain, which drives the motor by voltage.
///
/// # Errors
/// A figure of chain or corners that cannot be.
pub fn behind(bench: &Bench, clicked: &Clicked, chain: &Chain, corners: Corners) -> Result<Behind, Fault> {
    let chain = Chain { corners, ..*chain };
    let rate = bench.rate;
    let wanted = clicked.course.means(rate).unwrap_or_default();
    let starts = |p: &Parameters| QUIET * p.stiction * p.resistance / p.gain;
    let quiet = Some(starts(&bench.parameters)).filter(|v| *v > 0.0).unwrap_or(NONE * chain.most());
    let allowance = Allowance { quiet, lead: LEAD, tail: TAIL };
    let shaped = compensate(&chain, rate, &wanted, &allowance)?;
    let alone = plain(&chain, rate, &wanted)?;
    // What comes behind it is no part of what is missing, and moves the motor all the same.
    let mut followed = wanted.clone();
    followed.resize(wanted.len() + (AFTER * rate) as usize, 0.0);
    let outlived = plain(&chain, rate, &followed)?;
    let mut shortfall = alone.shortfall;
    let after = outlived.given.get(wanted.len()..).unwrap_or_default();
    shortfall.outside = after.iter().fold(0.0, |most: f64, volts| most.max(volts.abs() - quiet)).max(0.0);
    let behind = shaped.samples.len().saturating_sub(shaped.lead + wanted.len());
    Ok(Behind {
        corners,
        plain: Arrival::new(bench, outlived.given, wanted.len(), shortfall)?,
        lead: shaped.lead as f64 / rate,
        tail: behind as f64 / rate,
        compensated: Arrival::new(bench, shaped.given, shaped.lead + wanted.len(), shaped.shortfall)?,
    })
}

impl Arrival {
    /// Of volts, a step each, with a click that is over after so many of them.
    fn new(bench: &Bench, volts: Vec<f64>, over: usize, shortfall: Shortfall) -> Result<Self, Fault> {
        let run = bench.run(&Given::Samples(volts), 0.0)?;
        let speeds = &run.traces.speeds;
        let most = speeds.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
        let last = speeds.get(over.saturating_sub(1)).copied().unwrap_or(0.0);
        let end = over as f64 / bench.rate;
        Ok(Self {
            shortfall,
            turns: run.turns,
            left: if most > 0.0 { last / most } else { 0.0 },
            stop: run.stands.map(|stands| (stands - end).max(0.0)),
            run,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::behind;
    use crate::actuator::drive::Drive;
    use crate::actuator::link::Chain;
    use crate::actuator::link::amplifier::Amplifier;
    use crate::actuator::link::coupling::Corners;
    use crate::actuator::motor::{self, Level, Parameters, Plan};
    use crate::actuator::shape::{Click, Ending};
    use crate::report::motion::Bench;

    /// A click, and a chain with so much more than it needs.
    fn set(room: f64) -> (Bench, crate::actuator::shape::Clicked, Chain) {
        let coin = Parameters { gravity: 0.0, ..Parameters::COIN };
        let bench = Bench::new(&coin, Plan::whole(Level::Fine), 48_000.0, 0.0).unwrap();
        let click =
            Click { turns: 0.25, drive: motor::Drive::Voltage(3.0), angle: 0.0, ending: Ending::Settled };
        let amplifier = Amplifier {
            gain: 3.0 * room,
            inverted: false,
            drive: Drive::Voltage,
            volts: None,
            amperes: None,
        };
        (bench, click.solve(&coin).unwrap(), Chain { full_scale: 1.0, corners: Corners::none(), amplifier })
    }

    /// With room above it, a click arrives behind any of these as if nothing were in its way; without compensation it does not stop.
    #[test]
    fn a_click_with_room_arrives_whole() {
        let (bench, click, chain) = set(2.0);
        for corners in [Corners::one(2.0), Corners::one(10.0), Corners::one(20.0), Corners::two(20.0, 10.0)] {
            let behind = behind(&bench, &click, &chain, corners).unwrap();
            let [plain, whole] = [&behind.plain, &behind.compensated];
            assert_eq!((whole.shortfall.share, whole.shortfall.missing), (0.0, 0.0), "{corners:?}");
            assert!((whole.turns - 0.25).abs() < 2e-3, "{corners:?}: {}", whole.turns);
            assert!(whole.left.abs() < 2e-3, "{corners:?}: {}", whole.left);
            assert!(plain.shortfall.share > 0.02 && plain.left.abs() > 5.0 * whole.left.abs(), "{corners:?}");
        }
    }

    /// V exp(−ωt) of the forward drive arrives; backward, the capacitor's charge adds to it at first: V (2 − exp(−ωt1)) exp(−ωs).
    #[test]
    fn what_is_missing_of_a_plain_click_is_that_of_its_closed_form() {
        let (bench, click, chain) = set(1.0);
        let share = |corners| behind(&bench, &click, &chain, corners).unwrap().plain.shortfall.share;
        let [forward, backward, _] = click.seconds;
        for hertz in [0.5, 2.0, 10.0, 20.0] {
            let omega = std::f64::consts::TAU * hertz;
            let first = (-omega * forward).exp();
            let ahead = forward - (1.0 - first) / omega;
            let beyond = |s: f64| (2.0 - first) * -(-omega * s).exp_m1() / omega - s;
            let even = ((2.0 - first).ln() / omega).min(backward);
            let due = (ahead + 2.0 * beyond(even) - beyond(backward)) / (forward + backward);
            let is = share(Corners::one(hertz));
            assert!((is / due - 1.0).abs() < 0.01, "{hertz} Hz: {is} {due}");
            // Another one in series takes more.
            assert!(share(Corners::two(hertz, 2.0)) > 1.05 * is, "{hertz} Hz");
        }
    }

    /// Without room a lead-in makes some; the click ends so much later, and stands then.
    #[test]
    fn a_click_ends_behind_its_lead_in() {
        let (bench, click, chain) = set(1.0);
        let behind = behind(&bench, &click, &chain, Corners::one(2.0)).unwrap();
        let whole = &behind.compensated;
        assert!(behind.lead > 0.01 && whole.left.abs() < 2e-3, "{} {}", behind.lead, whole.left);
        assert!(whole.stop.unwrap() < 1e-3, "{:?}", whole.stop);
    }

    #[test]
    fn without_coupling_nothing_is_missing() {
        let (bench, click, chain) = set(1.0);
        let behind = behind(&bench, &click, &chain, Corners::none()).unwrap();
        for arrival in [&behind.plain, &behind.compensated] {
            assert!(arrival.shortfall.share < 1e-9 && arrival.shortfall.outside == 0.0);
            assert!((arrival.turns - 0.25).abs() < 1e-3, "{}", arrival.turns);
        }
        assert_eq!((behind.lead, behind.tail), (0.0, 0.0));
        assert_eq!(super::behind(&bench, &click, &chain, Corners::one(-1.0)).unwrap_err().field, "high_pass");
    }
}
