//! The JSON Schema of rigs, from the same tables by which they are read.

use serde_json::{Map, Value, json};

use super::device::COUPLING;
use super::knob::table::{HARMONIC, OUTPUT};
use crate::perception::site;
use crate::text::schema::{of_file, refer};

/// The JSON Schema (draft 2020-12) of rigs.
pub fn schema() -> Value {
    let mut defs = Map::new();
    defs.insert("format".into(), json!({ "type": "string", "pattern": "^pacinian-rig/1(\\.[0-9]+)?$" }));
    defs.insert(
        "position".into(),
        json!({
            "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 3,
        }),
    );
    defs.insert("names".into(), json!({ "type": "array", "items": { "type": "string" }, "minItems": 1 }));
    defs.insert("site".into(), json!({ "enum": site::WORDS }));
    defs.insert("date".into(), json!({ "type": "string", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$" }));
    let pair = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 });
    defs.insert(
        "table".into(),
        json!({ "oneOf": [{ "type": "array", "items": pair, "minItems": 2 }, { "type": "string", "minLength": 1 }] }),
    );
    defs.insert("polarity".into(), json!({ "enum": [1, -1, "invert"], "default": 1 }));
    let coupling = refer(&COUPLING, &mut defs);
    defs.insert("coupling".into(), json!({ "oneOf": [{ "const": "dc" }, coupling] }));
    let harmonic = refer(&HARMONIC, &mut defs);
    defs.insert("harmonics".into(), json!({ "type": "array", "items": harmonic }));
    let output = refer(&OUTPUT, &mut defs);
    defs.insert("torque output".into(), output);
    of_file("A pacinian rig", &super::TABLE, defs)
}
