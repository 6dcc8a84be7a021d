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

#[cfg(feature = "fundsp-nodes")]
#[test]
fn patches() {
    keep("patch.json", &pacinian::patch::schema());
}

/// The schema that is kept is that of the default features; without the nodes of fundsp it is the same less those.
#[cfg(not(feature = "fundsp-nodes"))]
#[test]
fn patches_without_the_nodes_of_fundsp() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/patch.json");
    let mut kept: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for name in pacinian::node::OF_FUNDSP {
        let node = format!("node-{name}");
        assert!(kept["$defs"].as_object_mut().unwrap().remove(&node).is_some(), "no {node} is kept");
        let link = Value::String(format!("#/$defs/{node}"));
        kept["$defs"]["node"]["oneOf"].as_array_mut().unwrap().retain(|branch| branch["$ref"] != link);
    }
    assert!(
        kept == pacinian::patch::schema(),
        "schema/patch.json differs by more than the nodes of fundsp: with default features, UPDATE_SCHEMA=1 cargo test --test formats schema"
    );
}

/// Which nodes the feature `fundsp-nodes` brings.
#[test]
fn the_nodes_of_fundsp_come_with_their_feature() {
    for name in pacinian::node::OF_FUNDSP {
        assert_eq!(pacinian::node::NodeKind::find(name).is_some(), cfg!(feature = "fundsp-nodes"), "{name}");
    }
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
