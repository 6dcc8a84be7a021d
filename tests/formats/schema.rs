//! The schemas under `schema/` are those that the program makes. `UPDATE_SCHEMA=1 cargo test --test formats schema` writes them.

use std::path::Path;

use serde_json::Value;

fn keep(file: &str, schema: &Value) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema").join(file);
    if std::env::var_os("UPDATE_SCHEMA").is_some_and(|v| v == "1") {
        std::fs::write(&path, format!("{schema:#}\n")).unwrap();
    }
    let kept: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(
        kept == *schema,
        "schema/{file} is out of date: UPDATE_SCHEMA=1 cargo test --test formats schema"
    );
}

#[test]
fn patches() {
    keep("patch.json", &pacinian::patch::schema());
}

#[test]
fn rigs() {
    keep("rig.json", &pacinian::rig::schema());
}

/// Every `$ref` leads somewhere, and every `$defs` entry is used.
#[test]
fn references_hold() {
    fn refs(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(object) => {
                found.extend(object.get("$ref").and_then(Value::as_str).map(str::to_string));
                object.values().for_each(|v| refs(v, found));
            }
            Value::Array(list) => list.iter().for_each(|v| refs(v, found)),
            _ => {}
        }
    }
    for schema in [pacinian::patch::schema(), pacinian::rig::schema()] {
        let mut found = Vec::new();
        refs(&schema, &mut found);
        for name in &found {
            assert!(schema.pointer(name.trim_start_matches('#')).is_some_and(Value::is_object), "{name}");
        }
        for name in schema["$defs"].as_object().unwrap().keys() {
            assert!(found.contains(&format!("#/$defs/{name}")), "nothing refers to {name}");
        }
    }
}

/// Every node of the registry has its branch.
#[test]
fn every_node_is_in_it() {
    let schema = pacinian::patch::schema();
    for spec in pacinian::node::REGISTRY {
        let node = &schema["$defs"][format!("node-{}", spec.name)];
        assert_eq!(node["properties"]["type"]["const"], spec.name);
        assert_eq!(node["properties"].as_object().unwrap().len(), spec.params.len() + 1);
    }
    assert_eq!(schema["$defs"]["node"]["oneOf"].as_array().unwrap().len(), pacinian::node::REGISTRY.len());
}
