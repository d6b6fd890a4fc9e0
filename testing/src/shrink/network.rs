//! What is known of network files when they are made smaller: who refers to whom, and what makes a member simpler.

use serde_json::{Map, Value};

use crate::tree::number;

/// A tree in which one member is simpler; none where there is nothing to do.
pub(super) type Simpler = fn(&Value, &str) -> Option<Value>;

/// What is tried on each member.
pub(super) const SIMPLER: [Simpler; 3] = [straight, of_one_segment, of_one_section];

/// The tree without some entries of a table at the top, and without what refers to them.
pub(super) fn without(tree: &Value, table: &str, names: &[String]) -> Value {
    let mut tree = tree.clone();
    match tree.get_mut(table) {
        Some(Value::Object(map)) => names.iter().for_each(|name| _ = map.shift_remove(name)),
        Some(Value::Array(items)) => {
            let mut index = 0;
            items.retain(|_| {
                index += 1;
                !names.contains(&(index - 1).to_string())
            });
            return tree;
        }
        _ => return tree,
    }
    let gone = |name: &str| names.iter().any(|gone| gone == name);
    if table == "nodes" {
        let mut members = Vec::new();
        for holder in ["members", "springs", "rigid_bodies", "probes"] {
            let entries = tree[holder].as_object().into_iter().flatten();
            let lost: Vec<String> =
                entries.filter(|(_, value)| mentions(value, &gone)).map(|(name, _)| name.clone()).collect();
            if let Some(map) = table_of(&mut tree, holder) {
                lost.iter().for_each(|name| _ = map.shift_remove(name));
            }
            if holder == "members" {
                members = lost;
            }
        }
        if let Some(supports) = table_of(&mut tree, "supports") {
            supports.retain(|name, _| !gone(name));
        }
        forget(&mut tree, &gone);
        return if members.is_empty() { tree } else { without(&tree, "members", &members) };
    }
    if table == "members" {
        if let Some(probes) = table_of(&mut tree, "probes") {
            probes.retain(|_, probe| !mentions(probe, &gone));
        }
        forget(&mut tree, &gone);
    }
    tree
}

/// A table at the top.
fn table_of<'a>(tree: &'a mut Value, name: &str) -> Option<&'a mut Map<String, Value>> {
    tree.get_mut(name)?.as_object_mut()
}

/// Whether a text that stands somewhere in a value is one of those.
fn mentions(value: &Value, gone: &impl Fn(&str) -> bool) -> bool {
    match value {
        Value::String(text) => gone(text),
        Value::Array(items) => items.iter().any(|item| mentions(item, gone)),
        Value::Object(map) => map.values().any(|value| mentions(value, gone)),
        _ => false,
    }
}

/// Takes names out of the steps.
fn forget(tree: &mut Value, gone: &impl Fn(&str) -> bool) {
    for step in tree.get_mut("steps").and_then(Value::as_array_mut).into_iter().flatten() {
        let Some(step) = step.as_object_mut() else { continue };
        let is_table = |value: &Value| value.is_object();
        for (_, loads) in step.iter_mut().filter(|(key, value)| *key != "stop" && is_table(value)) {
            loads.as_object_mut().into_iter().for_each(|loads| loads.retain(|name, _| !gone(name)));
        }
        step.retain(|_, value| value.as_object().is_none_or(|loads| !loads.is_empty()));
    }
}

/// A member without its curvature.
fn straight(tree: &Value, name: &str) -> Option<Value> {
    let mut changed = tree.clone();
    let member = table_of(&mut changed, "members")?.get_mut(name)?.as_object_mut()?;
    ["arc", "tangent", "length", "initial_curvature"].iter().for_each(|key| _ = member.shift_remove(*key));
    for segment in member.get_mut("segments").and_then(Value::as_array_mut).into_iter().flatten() {
        segment.as_object_mut()?.shift_remove("initial_curvature");
    }
    scale(&mut changed, name);
    Some(changed)
}

/// A straight member of its first segment alone.
fn of_one_segment(tree: &Value, name: &str) -> Option<Value> {
    let mut changed = tree.clone();
    let segments = table_of(&mut changed, "members")?.get_mut(name)?.get_mut("segments")?.as_array_mut()?;
    segments.truncate(1);
    scale(&mut changed, name);
    Some(changed)
}

/// A member of the section of its first segment.
fn of_one_section(tree: &Value, name: &str) -> Option<Value> {
    let mut changed = tree.clone();
    let member = table_of(&mut changed, "members")?.get_mut(name)?.as_object_mut()?;
    let segments = member.shift_remove("segments")?;
    for key in ["section", "material", "elements"] {
        if let Some(value) = segments[0].get(key) {
            member.insert(key.to_owned(), value.clone());
        }
    }
    Some(changed)
}

/// Makes the segments of straight members as long as their members again, where nodes have moved.
pub(super) fn fit(tree: &mut Value, before: &Value) {
    if tree["nodes"] == before["nodes"] {
        return;
    }
    let names: Vec<String> = tree["members"].as_object().map_or(Vec::new(), |map| map.keys().cloned().collect());
    for name in names {
        scale(tree, &name);
    }
}

/// Scales the segments of a straight member to the distance of its nodes.
fn scale(tree: &mut Value, name: &str) {
    let Some(distance) = distance(tree, name) else { return };
    let member = table_of(tree, "members").and_then(|members| members.get_mut(name)?.as_object_mut());
    let Some(member) = member else { return };
    if ["arc", "tangent", "length", "initial_curvature"].iter().any(|key| member.contains_key(*key)) {
        return;
    }
    let Some(segments) = member.get_mut("segments").and_then(Value::as_array_mut) else { return };
    let lengths: Option<Vec<f64>> = segments.iter().map(|segment| segment["length"].as_f64()).collect();
    let Some(lengths) = lengths else { return };
    let total: f64 = lengths.iter().sum();
    // Lengths that fit within what a file may miss them by stay as they are.
    if (total - distance).abs() > 1e-7 * distance {
        for (segment, length) in segments.iter_mut().zip(lengths) {
            segment["length"] = number(length * distance / total);
        }
    }
}

/// Distance of the nodes of a member, where they are written as numbers.
fn distance(tree: &Value, name: &str) -> Option<f64> {
    let nodes: Vec<&str> = tree["members"][name]["nodes"].as_array()?.iter().filter_map(Value::as_str).collect();
    let place = |name: &str| -> Option<Vec<f64>> {
        tree["nodes"]
            .as_object()
            .and_then(|nodes: &Map<String, Value>| nodes.get(name))?
            .as_array()?
            .iter()
            .map(Value::as_f64)
            .collect()
    };
    let (a, b) = (place(nodes.first()?)?, place(nodes.get(1)?)?);
    let square = |k: usize| (a.get(k).unwrap_or(&0.0) - b.get(k).unwrap_or(&0.0)).powi(2);
    Some((square(0) + square(1) + square(2)).sqrt())
}
