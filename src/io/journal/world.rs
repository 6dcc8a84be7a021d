//! A world that a slow thread has sent to a knob, as fields of a line.

use std::collections::BTreeMap;

use crate::knob::local_model::model::{Contact, LocalModel};
use crate::knob::local_model::pending::Message;

/// A model that cannot be, for all that are refused.
const REFUSED: LocalModel = LocalModel { stiffness: -1.0, ..LocalModel::FREE };

/// Its figures. What they are where nothing is said is left out: no contact, and a model that holds everywhere.
pub(super) fn fields(message: &Message) -> BTreeMap<String, f64> {
    let Message { model, impulse, stands_for } = message;
    let mut fields: Vec<(&str, f64)> = vec![("stands_for", f64::from(*stands_for))];
    match impulse.is_finite() {
        true => fields.push(("impulse", *impulse)),
        false => fields.push(("impulse_is_none", 1.0)),
    }
    if model.check().is_err() {
        fields.push(("refused", 1.0));
    } else {
        let LocalModel { stamp, torque, stiffness, centre, contact, range: (low, high) } = *model;
        fields.extend([
            ("stamp", stamp as f64),
            ("torque", torque),
            ("stiffness", stiffness),
            ("centre", centre),
        ]);
        fields.extend(contact.iter().flat_map(|contact| {
            let side = if contact.below { "contact_below" } else { "contact_above" };
            [(side, contact.angle), ("contact_stiffness", contact.stiffness)]
        }));
        let ends = [("low", low, f64::MIN), ("high", high, f64::MAX)];
        fields.extend(ends.iter().filter(|(_, end, none)| end != none).map(|(name, end, _)| (*name, *end)));
    }
    fields.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// The same, read.
///
/// # Errors
/// The figure that is missing.
pub(super) fn message(fields: &BTreeMap<String, f64>) -> Result<Message, String> {
    let of = |name: &str| fields.get(name).copied();
    let must = |name: &str| of(name).ok_or_else(|| format!("a model must have `{name}` in its fields"));
    let model = match of("refused") {
        Some(_) => REFUSED,
        None => LocalModel {
            // Ticks of a run are far fewer than a number holds exactly.
            stamp: must("stamp")? as u64,
            torque: must("torque")?,
            stiffness: must("stiffness")?,
            centre: must("centre")?,
            contact: match (of("contact_below"), of("contact_above")) {
                (None, None) => None,
                (Some(angle), _) => Some((angle, true)),
                (None, Some(angle)) => Some((angle, false)),
            }
            .map(|(angle, below)| {
                Ok::<_, String>(Contact { angle, below, stiffness: must("contact_stiffness")? })
            })
            .transpose()?,
            range: (of("low").unwrap_or(f64::MIN), of("high").unwrap_or(f64::MAX)),
        },
    };
    let impulse = if of("impulse_is_none").is_some() { f64::NAN } else { must("impulse")? };
    Ok(Message { model, impulse, stands_for: of("stands_for").unwrap_or(1.0) as u32 })
}

#[cfg(test)]
mod tests {
    use super::{Contact, LocalModel, Message, fields, message};

    #[test]
    fn what_is_written_is_read() {
        let contact = Some(Contact { angle: 0.1, below: false, stiffness: 0.3 });
        let model =
            LocalModel { stamp: 77, torque: 0.01, stiffness: 1.0 / 3.0, centre: -0.2, ..LocalModel::FREE };
        for model in [
            LocalModel::FREE,
            model,
            LocalModel { contact, ..model },
            LocalModel {
                contact: contact.map(|c| Contact { below: true, ..c }),
                range: (-1.0, 2.5),
                ..model
            },
        ] {
            let sent = Message { model, impulse: 1e-6, stands_for: 3 };
            assert_eq!(message(&fields(&sent)), Ok(sent));
        }
        // What the servo refuses is refused again, and what is no number is none.
        let bad = Message::new(LocalModel { torque: f64::NAN, ..model }, f64::INFINITY);
        assert!(fields(&bad).values().all(|value| value.is_finite()));
        let again = message(&fields(&bad)).unwrap();
        assert!(again.model.check().is_err() && again.impulse.is_nan());
        let mut part = fields(&Message::new(model, 0.0));
        part.remove("centre");
        assert_eq!(message(&part), Err("a model must have `centre` in its fields".into()));
    }
}
