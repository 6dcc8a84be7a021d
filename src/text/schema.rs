//! JSON Schema (draft 2020-12) from the descriptions of tables.

use serde_json::{Map, Value, json};

use super::field::{Field, Form, Table};

/// The schema of a file whose root is `root`; `defined` holds what the forms [`Form::Defined`] refer to.
pub fn of_file(title: &str, root: &'static Table, defined: Map<String, Value>) -> Value {
    let mut defs = defined;
    let mut schema = of_table(root, &mut defs);
    if let Value::Object(object) = &mut schema {
        object.insert("$schema".into(), json!("https://json-schema.org/draft/2020-12/schema"));
        object.insert("title".into(), json!(title));
        object.insert("$defs".into(), Value::Object(defs));
    }
    schema
}

/// The schema of a table; tables within it go to `defs`.
pub fn of_table(table: &'static Table, defs: &mut Map<String, Value>) -> Value {
    let mut properties = Map::new();
    for field in table.fields {
        properties.insert(field.key.into(), of_field(field, defs));
    }
    let others = table.others.map_or(Value::Bool(false), |field| of_field(field, defs));
    let required: Vec<&str> = table.fields.iter().filter(|f| f.required).map(|f| f.key).collect();
    json!({
        "type": "object",
        "description": table.doc,
        "properties": properties,
        "required": required,
        "additionalProperties": others,
    })
}

/// The schema of what stands at a key.
pub fn of_field(field: &'static Field, defs: &mut Map<String, Value>) -> Value {
    let mut schema = of_form(&field.form, defs);
    if let Value::Object(object) = &mut schema {
        let doc =
            if field.unit.is_empty() { field.doc.into() } else { format!("{} [{}]", field.doc, field.unit) };
        object.insert("description".into(), Value::String(doc));
    }
    schema
}

fn of_form(form: &'static Form, defs: &mut Map<String, Value>) -> Value {
    match form {
        Form::Text => json!({ "type": "string" }),
        Form::Number { default, least, most } => number(*default, *least, *most),
        Form::Count { default, least, most } => {
            let mut schema = json!({ "type": "integer", "minimum": least });
            if *most < u64::MAX {
                schema["maximum"] = json!(most);
            }
            if let Some(default) = default {
                schema["default"] = json!(default);
            }
            schema
        }
        Form::Flag(default) => json!({ "type": "boolean", "default": default }),
        Form::Word(words) => json!({ "enum": words, "default": words.first() }),
        Form::One(table) => refer(table, defs),
        Form::Many(table) => json!({ "type": "array", "items": refer(table, defs) }),
        Form::Named(table) => json!({
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_-]*$" },
            "additionalProperties": refer(table, defs),
        }),
        Form::Defined(name) => json!({ "$ref": format!("#/$defs/{name}") }),
    }
}

/// A number within limits; whole ones without a decimal point.
pub fn number(default: Option<f64>, least: f64, most: f64) -> Value {
    let mut schema = json!({ "type": "number" });
    for (key, value) in [("minimum", Some(least)), ("maximum", Some(most)), ("default", default)] {
        if let Some(value) = value.filter(|v| v.is_finite()) {
            schema[key] =
                if value.fract() == 0.0 && value.abs() < 1e15 { json!(value as i64) } else { json!(value) };
        }
    }
    schema
}

/// A reference to a table, whose schema goes to `defs`.
pub fn refer(table: &'static Table, defs: &mut Map<String, Value>) -> Value {
    if !defs.contains_key(table.name) {
        defs.insert(table.name.into(), Value::Null);
        let schema = of_table(table, defs);
        defs.insert(table.name.into(), schema);
    }
    json!({ "$ref": format!("#/$defs/{}", table.name) })
}
