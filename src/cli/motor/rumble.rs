//! `pacinian motor` of a rumble motor.

use super::super::check::json;
use super::super::failure::Failure;
use super::super::problems;
use super::super::terminal::Terminal;
use super::report::{About, Answer, Computed, CouplingReport, Figures, WayReport, Wished};
use super::subject::Subject;
use super::{Form, Motor, picture, usage, written};
use pacinian::actuator::motor::{self, GRAVITY, Level, Parameters, Plan};
use pacinian::actuator::shape::Clicked;
use pacinian::io::out;
use pacinian::report::motion::{Behind, Bench, Envelope, Wish, behind, bursts, clicks, own};
use pacinian::rig::Terminals;
use pacinian::text::Problem;

/// As in a rig, rad.
const MOST_TILT: f64 = 4.0;

/// Computes and says it.
pub fn run(asked: &Motor, subject: &Subject, terminal: &Terminal) -> Result<(), Failure> {
    if asked.response.is_some() {
        let what = format!(
            "--response is of voice coils, inertial and resonant actuators, and {} is a rumble motor, whose frequency is its speed",
            subject.name
        );
        return Err(Failure::usage(what, "leave it out; --plot draws what the motor does over time"));
    }
    let tilt = asked.tilt.or(subject.tilt);
    if let Some(tilt) = tilt.filter(|tilt| !(-MOST_TILT..=MOST_TILT).contains(tilt)) {
        let what =
            format!("a tilt of {tilt:?} rad is none: it must be within -{MOST_TILT} and {MOST_TILT} rad");
        return Err(Failure::usage(what, "0 is upright, 1.5708 level: give another --tilt"));
    }
    let parameters = subject.motor(tilt)?;
    let (limit, rate) = (asked.limit(subject)?, asked.rate(subject));
    let error = asked.error.unwrap_or(1e-4);
    if !(error > 0.0 && error < 1.0) {
        let what = format!("an error of {error} is none that one could wish for");
        return Err(Failure::usage(
            what,
            "it is a share of the rated speed, above 0 and below 1: --error 0.001",
        ));
    }
    // Where nobody says how it is held, or what its mass weighs, there is gravity all the same, and it is left out for that.
    let posture = tilt.is_some() && subject.actuator.has_torques();
    let wanted = motor::Wish { error, posture, casing: true };
    let held = Parameters { gravity: if posture { parameters.gravity } else { GRAVITY }, ..parameters };
    let mut plan = Plan::choose(&held, rate, &wanted);
    if tilt.is_some() && !posture {
        plan = plan.of_unknown_weight();
    }
    let bench = Bench::new(&parameters, plan, rate, asked.angle.unwrap_or(0.0)).map_err(|f| usage(&f))?;
    let reaches = plan.error(&parameters, rate);
    let wish = Wish {
        level: asked.level.unwrap_or(1.0),
        seconds: asked.seconds,
        envelope: asked.envelope.map_or(Envelope::Rectangle, Form::envelope),
    };
    let turns = asked.turns.unwrap_or(0.25);
    let mut warnings: Vec<String> = asked.beyond(subject).into_iter().collect();
    if reaches > error {
        warnings.push(format!(
            "an error of {error:e} is not reached: gravity leaves up to {reaches:.1e} of the rated speed at {} steps a second, at the finest level",
            rate
        ));
    }
    match subject.terminals {
        Terminals::Carrier(_) => {
            let what = format!(
                "{} is behind a rectifier, which lets it go one way alone, and brake by nothing: no drive that is compared here gets through",
                subject.name
            );
            let help = "name its part to see what it would do at a steady voltage, or play on the rig: pacinian render PATCH --rig RIG -o out.wav --feel felt.wav";
            return Err(Failure::usage(what, help));
        }
        Terminals::Coupled(_) => warnings.push(
            "of all that is compared here, clicks alone get through the coupling of the rig; `pacinian check` says how strong they may be"
                .to_string(),
        ),
        Terminals::Straight | Terminals::Bridge(_) => {}
    }
    let rows = match &asked.drive {
        Some(written) => {
            let (most, unit) = subject.current.map_or((limit, "V"), |[amperes, _]| (amperes, "A"));
            if written.most() > most {
                warnings.push(format!(
                    "the course has {} {unit}, which is more than the {most} {unit} that reach or bear it",
                    written.most()
                ));
            }
            let clashing = [
                (asked.turns.is_some(), "--turns"),
                (asked.level.is_some(), "--level"),
                (asked.envelope.is_some(), "--envelope"),
            ];
            if let Some((_, option)) = clashing.into_iter().find(|(given, _)| *given) {
                let what = format!("{option} is of the comparison, which --drive takes the place of");
                return Err(Failure::usage(what, format!("leave {option} or --drive out")));
            }
            let course = written.course(subject.current.map(|[_, volts]| volts)).map_err(|what| {
                let help = match subject.current {
                    Some(_) => "write amperes: --drive \"0.02:0.1A, 0.01:-0.1A, short\"",
                    None => "write volts: --drive \"0.02:3V, 0.01:-3V, short\"; amperes are for an amplifier of drive = \"current\" in a rig",
                };
                Failure::usage(what, help)
            })?;
            vec![own(&bench, &course)]
        }
        None => {
            if subject.current.is_some() {
                warnings.push(
                    "the amplifier imposes a current; the bursts that are compared here are driven by voltage".to_string(),
                );
            }
            let mut rows = bursts(&bench, &wish, limit).map_err(|f| usage(&f))?;
            let drive = subject.current.map_or(motor::Drive::Voltage(limit), |[amperes, limit]| {
                motor::Drive::Current { amperes, limit }
            });
            rows.extend(clicks(&bench, turns, drive).map_err(|f| usage(&f))?);
            rows
        }
    };
    let torques = subject.actuator.has_torques();
    let behind = coupled(asked, subject, &bench, turns, limit)?;
    for what in warnings {
        terminal.note(&problems::sentence(&Problem::warning(&(0..0), what), terminal));
    }
    if let Some(path) = &asked.plot {
        let title = format!("{}: {}", subject.name, subject.title);
        let wish = asked.drive.is_none().then_some(&wish);
        out::write(path, picture::strips(&title, &bench, wish, &rows, turns).svg().as_bytes())?;
    }
    if let Some(path) = &asked.csv {
        let wish = asked.drive.is_none().then_some(&wish);
        out::write(path, picture::csv(&bench, wish, &rows, torques).as_bytes())?;
    }
    let answer = Answer {
        name: subject.name.clone(),
        title: subject.title.clone(),
        model: subject.actuator.model.word(),
        motor: About::new(subject, &bench, limit, posture),
        figures: Figures {
            origins: subject.known.origins.clone(),
            from_the_rig: subject.known.by_rig,
            assumed: subject.known.assumed.clone(),
        },
        computed: Computed {
            level: level(plan.level),
            rate,
            wished_error: error,
            error: reaches,
            reached: reaches <= error,
            left_out: plan.left_out.iter().flatten().map(ToString::to_string).collect(),
        },
        wish: Wished {
            level: wish.level,
            seconds: wish.seconds,
            envelope: wish.envelope.word(),
            turns,
            angle: bench.angle,
            drive: asked.drive.is_some(),
        },
        ways: rows.iter().map(|row| WayReport::new(row, torques)).collect(),
        coupling: behind.iter().map(CouplingReport::new).collect(),
    };
    let text = if asked.json { json(&answer) } else { answer.text(subject, &behind, terminal.out) };
    terminal.print(&text)
}

/// What of a click arrives behind each of the corners.
fn coupled(
    asked: &Motor,
    subject: &Subject,
    bench: &Bench,
    turns: f64,
    limit: f64,
) -> Result<Vec<Behind>, Failure> {
    if asked.coupling.is_empty() {
        return Ok(Vec::new());
    }
    if asked.drive.is_some() {
        return Err(Failure::usage(
            "--coupling is for the click, which --drive takes the place of",
            "leave one of them out",
        ));
    }
    let Some(mut chain) = subject.chain else {
        let what = "what a card's coupling does to a click is only told of amplifiers that impose a voltage";
        return Err(Failure::usage(what, "leave --coupling out"));
    };
    if asked.volts.is_some() && subject.files.is_empty() {
        (chain.amplifier.gain, chain.amplifier.volts) = (limit, Some(limit));
    }
    let rows = clicks(bench, turns, motor::Drive::Voltage(limit)).map_err(|f| usage(&f))?;
    let clicked: Option<&Clicked> = rows.iter().find_map(|row| row.done.as_ref().ok()?.click.as_ref());
    // Why there is none stands in its row.
    let Some(clicked) = clicked else { return Ok(Vec::new()) };
    let one = |through: &written::Through| behind(bench, clicked, &chain, through.0).map_err(|f| usage(&f));
    asked.coupling.iter().map(one).collect()
}

/// The word for a level.
pub(super) fn level(level: Level) -> &'static str {
    match level {
        Level::Economy => "economy",
        Level::Default => "default",
        Level::Fine => "fine",
    }
}
