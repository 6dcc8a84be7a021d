//! What a message asks for.

use std::time::Duration;

use rosc::OscType;

use super::announce::Wants;
use super::names::{Kind, Method};
use super::said;
use crate::patch::Place;
use crate::patch::place::{channel, position};
use crate::performer::{Note, Touch};

/// What a message asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Play a voice, perhaps under an id.
    Play(String, Note, Option<i64>),
    /// Release what was played under an id.
    Release(i64),
    /// Release all that sounds.
    ReleaseAll,
    /// Move the hand that holds what was played under an id.
    Touch(i64, Touch),
    /// Start a pattern.
    Start(String),
    /// Stop a pattern.
    Stop(String),
    /// Send a control to a value.
    Set(usize, f64),
    /// Send several to theirs.
    Feed(Vec<(usize, f64)>),
    /// Tell the value of a control.
    Get(usize),
    /// Tell it again and again; `None`: no more.
    Report(usize, Option<Duration>),
    /// Tell all that there is of a kind.
    List(Kind),
    /// Close the gate.
    Panic,
    /// Take a panic back.
    Calm,
    /// Full level, or that for headphones.
    Arm(bool),
    /// Torque of a knob that is there, or none.
    Torque(bool),
    /// Tell peaks again and again.
    Subscribe(Duration),
    /// No more.
    Unsubscribe,
    /// Tell what is played, as it is played.
    Invite(Wants),
    /// No more.
    Dismiss,
    /// Tell how the session stands.
    Status,
    /// Answer.
    Ping,
    /// For the patch's triggers.
    Trigger(String, Vec<f64>),
    /// Put that into the journal.
    Note(String),
    /// A button was let go: nothing.
    Nothing,
}

impl Ask {
    /// Names the controls that it is about anew, by their numbers. Says whether anything is left of it.
    pub(super) fn renumber(&mut self, new: impl Fn(usize) -> Option<usize>) -> bool {
        match self {
            Self::Set(control, _) | Self::Get(control) | Self::Report(control, _) => {
                new(*control).map(|new| *control = new).is_some()
            }
            Self::Feed(values) => {
                values.retain_mut(|(control, _)| new(*control).map(|new| *control = new).is_some());
                !values.is_empty()
            }
            _ => true,
        }
    }
}

/// Arguments that do not fit: their types, number or range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wrong;

/// How often something is reported, at most and at least, in milliseconds.
pub const EVERY: [f64; 2] = [10.0, 10_000.0];

/// How often peaks are, where nobody says, in milliseconds.
const METER: f64 = 50.0;

/// What a method is asked for with these arguments.
///
/// # Errors
/// Arguments that do not fit.
pub fn ask(method: &Method, args: &[OscType]) -> Result<Ask, Wrong> {
    Ok(match method {
        Method::Play(voice) => return play(voice, args),
        Method::Release => match args {
            [id] => Ask::Release(whole(id)?),
            _ => return Err(Wrong),
        },
        Method::Touch(what) => match args {
            [id, value] => Ask::Touch(whole(id)?, Touch::of(*what, finite(value)?)),
            _ => return Err(Wrong),
        },
        Method::Start(name) => button(args, Ask::Start(name.clone()))?,
        Method::Stop(name) => button(args, Ask::Stop(name.clone()))?,
        Method::Set(control) => match args {
            [value] => Ask::Set(*control, finite(value)?),
            _ => return Err(Wrong),
        },
        Method::Feed(controls) if controls.len() == args.len() => {
            let values = args.iter().map(finite).collect::<Result<Vec<_>, _>>()?;
            Ask::Feed(controls.iter().copied().zip(values).collect())
        }
        Method::Feed(_) => return Err(Wrong),
        Method::Get(control) => match args {
            [] => Ask::Get(*control),
            [every] if finite(every)? == 0.0 => Ask::Report(*control, None),
            [every] => Ask::Report(*control, Some(often(every)?)),
            _ => return Err(Wrong),
        },
        Method::List(kind) => button(args, Ask::List(*kind))?,
        Method::ReleaseAll => button(args, Ask::ReleaseAll)?,
        Method::Panic => button(args, Ask::Panic)?,
        Method::Calm => button(args, Ask::Calm)?,
        Method::Arm => match args {
            [armed] => Ask::Arm(finite(armed)? != 0.0),
            _ => return Err(Wrong),
        },
        Method::Torque => match args {
            [on] => Ask::Torque(finite(on)? != 0.0),
            _ => return Err(Wrong),
        },
        Method::Subscribe => match args {
            [] => Ask::Subscribe(milliseconds(METER)),
            [every] => Ask::Subscribe(often(every)?),
            _ => return Err(Wrong),
        },
        Method::Unsubscribe => button(args, Ask::Unsubscribe)?,
        Method::Invite(wants) => button(args, Ask::Invite(*wants))?,
        Method::Dismiss => button(args, Ask::Dismiss)?,
        Method::Status => button(args, Ask::Status)?,
        Method::Ping => button(args, Ask::Ping)?,
        Method::Note => Ask::Note(said::listed(args)),
        Method::Trigger(address) => {
            let place = |arg| number(arg).map_or(Ok(f64::NAN), |_| finite(arg));
            let numbers: Vec<f64> = args.iter().map(place).collect::<Result<_, _>>()?;
            // Some name what the numbers are of; what only names is meant for something else.
            if !numbers.is_empty() && numbers.iter().all(|number| number.is_nan()) {
                return Err(Wrong);
            }
            Ask::Trigger(address.clone(), numbers)
        }
    })
}

/// Surfaces with buttons send 1 when one is pressed and 0 when it is let go. More than that is no question: it may be another's
/// answer to one, which must not be answered.
fn button(args: &[OscType], pressed: Ask) -> Result<Ask, Wrong> {
    match args {
        [] => Ok(pressed),
        [value] => Ok(if finite(value)? == 0.0 { Ask::Nothing } else { pressed }),
        _ => Err(Wrong),
    }
}

/// `[level] [duration] [frequency]`, then pairs of a name and a value.
fn play(voice: &str, args: &[OscType]) -> Result<Ask, Wrong> {
    let (mut note, mut id) = (Note::default(), None);
    let mut rest = args;
    let mut numbers = ["level", "duration", "frequency"].into_iter();
    while let [value, after @ ..] = rest {
        let (name, value, after) = match (value, after) {
            (OscType::String(name), [value, after @ ..]) => {
                // Numbers behind a name would be hard to tell apart.
                numbers.by_ref().for_each(drop);
                (name.as_str(), value, after)
            }
            (OscType::String(_), []) => return Err(Wrong),
            _ => (numbers.next().ok_or(Wrong)?, value, after),
        };
        match name {
            "level" => note.level = Some(finite(value)?),
            "felt" => note.felt = Some(finite(value)?),
            "duration" => note.duration = Some(number(value).filter(|x| !x.is_nan()).ok_or(Wrong)?),
            "place" => note.place = Some(place(value)?),
            "id" => id = Some(whole(value)?),
            _ => note.fields.push((name.into(), finite(value)?)),
        }
        rest = after;
    }
    Ok(Ask::Play(voice.into(), note, id))
}

/// A tactor's name, a channel from 1, or an array of two or three metres.
fn place(value: &OscType) -> Result<Place, Wrong> {
    match value {
        OscType::String(name) if !name.is_empty() => Ok(Place::Name(name.clone())),
        OscType::Array(array) => {
            let numbers: Vec<f64> = array.content.iter().map(finite).collect::<Result<_, _>>()?;
            position(&numbers).map(Place::Position).ok_or(Wrong)
        }
        _ => u64::try_from(whole(value)?).ok().and_then(channel).map(Place::Channel).ok_or(Wrong),
    }
}

fn often(value: &OscType) -> Result<Duration, Wrong> {
    let every = finite(value)?;
    // Whoever asks for more than there is gets what there is.
    if every > 0.0 { Ok(milliseconds(every.clamp(EVERY[0], EVERY[1]))) } else { Err(Wrong) }
}

fn milliseconds(ms: f64) -> Duration {
    Duration::from_secs_f64(ms * 1e-3)
}

/// Whatever may stand for a number.
pub(in crate::io) fn number(value: &OscType) -> Option<f64> {
    match value {
        OscType::Int(x) => Some(f64::from(*x)),
        OscType::Long(x) => Some(*x as f64),
        OscType::Float(x) => Some(f64::from(*x)),
        OscType::Double(x) => Some(*x),
        OscType::Bool(x) => Some(f64::from(u8::from(*x))),
        OscType::Inf => Some(f64::INFINITY),
        _ => None,
    }
}

fn finite(value: &OscType) -> Result<f64, Wrong> {
    number(value).filter(|x| x.is_finite()).ok_or(Wrong)
}

/// A whole number, of whatever type.
fn whole(value: &OscType) -> Result<i64, Wrong> {
    match value {
        OscType::Int(x) => Ok(i64::from(*x)),
        OscType::Long(x) => Ok(*x),
        // As far as a double counts without gaps.
        OscType::Float(_) | OscType::Double(_) => match finite(value)? {
            x if x.fract() == 0.0 && x.abs() <= 9e15 => Ok(x as i64),
            _ => Err(Wrong),
        },
        _ => Err(Wrong),
    }
}

#[cfg(test)]
mod tests {
    use super::{Ask, Method, Wrong, ask};
    use crate::midi::What;
    use crate::patch::Place;
    use crate::performer::{Note, Touch};
    use rosc::{OscArray, OscType};
    use std::time::Duration;

    fn s(text: &str) -> OscType {
        OscType::String(text.into())
    }

    fn f(x: f32) -> OscType {
        OscType::Float(x)
    }

    fn play(args: &[OscType]) -> Result<(Note, Option<i64>), Wrong> {
        match ask(&Method::Play("v".into()), args)? {
            Ask::Play(voice, note, id) if voice == "v" => Ok((note, id)),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_voice_in_order_and_by_name() {
        assert_eq!(play(&[]), Ok((Note::default(), None)));
        let note = Note {
            level: Some(0.5),
            duration: Some(2.0),
            fields: vec![("frequency".into(), 80.0)],
            ..Note::default()
        };
        assert_eq!(play(&[f(0.5), OscType::Int(2), OscType::Double(80.0)]), Ok((note.clone(), None)));
        let named =
            [s("frequency"), f(80.0), s("level"), f(0.5), s("duration"), OscType::Long(2), s("id"), 7.into()];
        assert_eq!(play(&named), Ok((note.clone(), Some(7))));
        let mixed = [f(0.5), s("duration"), f(2.0), s("frequency"), f(80.0), s("place"), s("t3")];
        let there = Note { place: Some(Place::Name("t3".into())), ..note };
        assert_eq!(play(&mixed), Ok((there, None)));
        let place = |value: OscType| play(&[s("place"), value]).map(|(note, _)| note.place);
        assert_eq!(place(3.into()), Ok(Some(Place::Channel(3))));
        assert_eq!(place(f(3.0)), Ok(Some(Place::Channel(3))));
        let array = |content: Vec<OscType>| OscType::Array(OscArray { content });
        assert_eq!(place(array(vec![f(0.5), 1.into()])), Ok(Some(Place::Position([0.5, 1.0, 0.0]))));
        for wrong in
            [0.into(), (-1).into(), f(1.5), s(""), array(vec![]), array(vec![f(1e9); 2]), true.into()]
        {
            assert_eq!(place(wrong), Err(Wrong));
        }
        assert_eq!(play(&[s("duration"), OscType::Inf]).unwrap().0.duration, Some(f64::INFINITY));
        for wrong in [
            vec![f(1.0); 4],
            vec![s("level")],
            vec![s("level"), s("x")],
            vec![s("level"), f(0.1), f(0.2)],
            vec![f(f32::NAN)],
            vec![f(f32::INFINITY)],
            vec![f(1.0), f(f32::NAN)],
            vec![s("id"), f(0.5)],
            vec![OscType::Nil],
        ] {
            assert_eq!(play(&wrong), Err(Wrong), "{wrong:?}");
        }
    }

    #[test]
    fn numbers_of_any_type() {
        let set = |args: &[OscType]| ask(&Method::Set(3), args);
        for one in [f(1.0), OscType::Double(1.0), 1.into(), OscType::Long(1), true.into()] {
            assert_eq!(set(&[one]), Ok(Ask::Set(3, 1.0)));
        }
        assert_eq!(set(&[false.into()]), Ok(Ask::Set(3, 0.0)));
        for wrong in [&[][..], &[s("1")], &[f(1.0), f(1.0)], &[f(f32::NAN)], &[OscType::Inf], &[OscType::Nil]]
        {
            assert_eq!(set(wrong), Err(Wrong), "{wrong:?}");
        }
        assert_eq!(ask(&Method::Release, &[OscType::Double(5.0)]), Ok(Ask::Release(5)));
        let bend = |args: &[OscType]| ask(&Method::Touch(What::Bend), args);
        assert_eq!(bend(&[5.into(), f(1.5)]), Ok(Ask::Touch(5, Touch::Bend(1.5))));
        for wrong in [
            &[][..],
            &[5.into()],
            &[5.into(), OscType::Inf],
            &[f(0.5), f(1.0)],
            &[1.into(), 2.into(), 3.into()],
        ] {
            assert_eq!(bend(wrong), Err(Wrong), "{wrong:?}");
        }
        assert_eq!(ask(&Method::Release, &[]), Err(Wrong));
        assert_eq!(ask(&Method::Release, &[f(1e30)]), Err(Wrong));
    }

    #[test]
    fn buttons_that_are_let_go_do_nothing() {
        for (method, done) in [
            (Method::ReleaseAll, Ask::ReleaseAll),
            (Method::Panic, Ask::Panic),
            (Method::Calm, Ask::Calm),
            (Method::Start("p".into()), Ask::Start("p".into())),
            (Method::Stop("p".into()), Ask::Stop("p".into())),
        ] {
            assert_eq!(ask(&method, &[]), Ok(done.clone()));
            assert_eq!(ask(&method, &[f(1.0)]), Ok(done));
            assert_eq!(ask(&method, &[f(0.0)]), Ok(Ask::Nothing));
            assert_eq!(ask(&method, &[s("x")]), Err(Wrong));
        }
        assert_eq!(ask(&Method::Arm, &[1.into()]), Ok(Ask::Arm(true)));
        assert_eq!(ask(&Method::Arm, &[false.into()]), Ok(Ask::Arm(false)));
        assert_eq!(ask(&Method::Arm, &[]), Err(Wrong));
    }

    #[test]
    fn how_often() {
        let get = |args: &[OscType]| ask(&Method::Get(0), args);
        assert_eq!(get(&[]), Ok(Ask::Get(0)));
        assert_eq!(get(&[0.into()]), Ok(Ask::Report(0, None)));
        assert_eq!(get(&[f(100.0)]), Ok(Ask::Report(0, Some(Duration::from_millis(100)))));
        assert_eq!(get(&[1.into()]), Ok(Ask::Report(0, Some(Duration::from_millis(10)))));
        assert_eq!(get(&[(-5).into()]), Err(Wrong));
        assert_eq!(ask(&Method::Subscribe, &[]), Ok(Ask::Subscribe(Duration::from_millis(50))));
        assert_eq!(ask(&Method::Subscribe, &[i32::MAX.into()]), Ok(Ask::Subscribe(Duration::from_secs(10))));
        assert_eq!(ask(&Method::Subscribe, &[0.into()]), Err(Wrong));
    }

    #[test]
    fn triggers_hear_numbers() {
        let hear = |args: &[OscType]| ask(&Method::Trigger("/hit".into()), args);
        assert_eq!(hear(&[]), Ok(Ask::Trigger("/hit".into(), vec![])));
        assert_eq!(
            hear(&[2.into(), f(0.5), true.into()]),
            Ok(Ask::Trigger("/hit".into(), vec![2.0, 0.5, 1.0]))
        );
        assert_eq!(hear(&[s("hard")]), Err(Wrong));
        assert_eq!(hear(&[f(f32::NAN), 1.into()]), Err(Wrong));
        // A tracker that says which hand it is.
        let Ok(Ask::Trigger(_, numbers)) = hear(&[s("left"), f(0.5)]) else { panic!() };
        assert!(numbers[0].is_nan() && numbers[1] == 0.5 && numbers.len() == 2);
    }

    #[test]
    fn a_note_takes_anything() {
        let note = |args: &[OscType]| ask(&Method::Note, args);
        assert_eq!(note(&[]), Ok(Ask::Note(String::new())));
        assert_eq!(note(&[s("trial"), 7.into(), OscType::Nil]), Ok(Ask::Note("\"trial\" 7 nil".into())));
    }
}
