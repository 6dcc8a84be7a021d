//! The JSON Schema of patches, from the same tables by which they are read and from the node registry.

use serde_json::{Map, Value, json};

use super::node::{MOST_SHAPE, POINT, SHAPES};
use super::{event, way};
use crate::node::REGISTRY;
use crate::node::spec::{Kind, NodeSpec, Numeric, Param};
use crate::text::schema::{number, of_file, refer};

/// The JSON Schema (draft 2020-12) of patches.
pub fn schema() -> Value {
    let mut defs = Map::new();
    defs.insert("format".into(), json!({ "type": "string", "pattern": "^pacinian-patch/1(\\.[0-9]+)?$" }));
    let path = refer(&way::TABLE, &mut defs);
    defs.insert("place".into(), place(path));
    let point = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 3 });
    defs.insert("points".into(), json!({ "type": "array", "items": point, "minItems": 2 }));
    defs.insert(
        "times".into(),
        json!({ "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 2 }),
    );
    let places = json!({ "type": "array", "items": { "$ref": "#/$defs/place" }, "minItems": 2 });
    defs.insert("places".into(), places);
    defs.insert(
        "range".into(),
        json!({
            "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2,
        }),
    );
    let note = json!({
        "oneOf": [
            { "type": "integer", "minimum": 0, "maximum": 127 },
            { "type": "string", "pattern": "^[A-Ga-g][#b]?-?[0-9]$", "description": "Name of a note; C4 is 60." },
        ],
    });
    defs.insert("notes".into(), json!({ "type": "array", "items": note, "minItems": 2, "maxItems": 2 }));
    defs.insert("expression".into(), json!({
        "type": "string",
        "minLength": 1,
        "description": "The name of a node or a control, or an expression: + - * /, parentheses, numbers, names, event.NAME, min, max, abs, clamp, sqrt, exp, log, sin, pow, floor.",
    }));
    defs.insert(
        "set".into(),
        json!({
            "type": "object",
            "additionalProperties": { "oneOf": [{ "type": "number" }, { "$ref": "#/$defs/expression" }] },
        }),
    );
    defs.insert(
        "signal".into(),
        json!({ "oneOf": [{ "type": "number" }, { "$ref": "#/$defs/expression" }] }),
    );
    defs.insert("numbers".into(), json!({ "type": "array", "items": { "type": "number" }, "minItems": 2 }));
    let pair = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 });
    defs.insert("curve".into(), json!({ "type": "array", "items": pair, "minItems": 2 }));
    let events = refer(&event::TABLE, &mut defs);
    defs.insert("events".into(), json!({
        "oneOf": [{ "type": "array", "items": events, "minItems": 1 }, { "type": "string", "minLength": 1 }],
    }));
    let mut branches = Vec::new();
    for spec in REGISTRY {
        let name = format!("node-{}", spec.name);
        let schema = node(spec, &mut defs);
        defs.insert(name.clone(), schema);
        branches.push(json!({ "$ref": format!("#/$defs/{name}") }));
    }
    defs.insert("node".into(), json!({ "oneOf": branches }));
    defs.insert(
        "nodes".into(),
        json!({
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" },
            "additionalProperties": { "$ref": "#/$defs/node" },
        }),
    );
    of_file("A pacinian patch", &super::TABLE, defs)
}

/// A place.
fn place(path: Value) -> Value {
    json!({
        "oneOf": [
            path,
            { "type": "string", "minLength": 1, "description": "Name of a tactor or a group." },
            { "type": "integer", "minimum": 1, "maximum": super::place::MAX_CHANNELS, "description": "Channel, from 1." },
            { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 3, "description": "Position in metres." },
            { "type": "array", "items": { "type": "string", "minLength": 1 }, "minItems": 1, "description": "Names of tactors or groups." },
        ],
    })
}

fn node(spec: &NodeSpec, defs: &mut Map<String, Value>) -> Value {
    let mut properties = Map::new();
    let mut required = vec!["type"];
    properties.insert("type".into(), json!({ "const": spec.name, "description": spec.summary }));
    for param in spec.params {
        let (mut schema, needed) = parameter(param, defs);
        let doc = if param.unit.is_empty() {
            param.doc.to_string()
        } else {
            format!("{} [{}]", param.doc, param.unit)
        };
        schema["description"] = json!(doc);
        properties.insert(param.name.into(), schema);
        if needed {
            required.push(param.name);
        }
    }
    json!({
        "type": "object",
        "description": format!("{} {}", spec.summary, spec.detail),
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn parameter(param: &Param, defs: &mut Map<String, Value>) -> (Value, bool) {
    let numeric = |n: Numeric| {
        let schema =
            json!({ "oneOf": [number(n.default, n.least, n.most), { "$ref": "#/$defs/expression" }] });
        (schema, n.default.is_none())
    };
    match param.kind {
        Kind::Signal(n) | Kind::Frequency(n) | Kind::Start(n) | Kind::Constant(n) => numeric(n),
        Kind::Signals => {
            let item = json!({ "oneOf": [{ "type": "number" }, { "$ref": "#/$defs/expression" }] });
            (json!({ "type": "array", "items": item, "minItems": 1 }), true)
        }
        Kind::Choice(words, default) => (json!({ "enum": words, "default": words.get(default) }), false),
        Kind::Points => {
            let words: Vec<&str> = SHAPES.iter().map(|(w, _)| *w).collect();
            let strength = number(None, -MOST_SHAPE, MOST_SHAPE);
            defs.insert(
                "shape".into(),
                json!({ "oneOf": [{ "enum": words }, strength], "default": "linear" }),
            );
            (json!({ "type": "array", "items": refer(&POINT, defs), "minItems": 1 }), true)
        }
        Kind::File => (json!({ "type": "string", "minLength": 1 }), true),
        Kind::Flag(default) => (json!({ "type": "boolean", "default": default }), false),
    }
}
