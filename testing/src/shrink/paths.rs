//! Places in a tree.

use serde_json::Value;

/// Keys of tables and places in lists, from the top.
pub(super) type Path = Vec<String>;

/// All places below the top, the last ones first and what is inside others after them.
pub(super) fn paths(tree: &Value) -> Vec<Path> {
    let mut all = Vec::new();
    gather(tree, &mut Vec::new(), &mut all);
    all.sort_by_key(Vec::len);
    all
}

fn gather(tree: &Value, path: &mut Path, all: &mut Vec<Path>) {
    let mut visit = |key: String, value: &Value| {
        path.push(key);
        all.push(path.clone());
        gather(value, path, all);
        path.pop();
    };
    match tree {
        Value::Object(map) => map.iter().rev().for_each(|(key, value)| visit(key.clone(), value)),
        Value::Array(items) => items.iter().enumerate().rev().for_each(|(at, value)| visit(at.to_string(), value)),
        _ => {}
    }
}

pub(super) fn at<'a>(tree: &'a Value, path: &[String]) -> Option<&'a Value> {
    path.iter().try_fold(tree, |tree, key| match tree {
        Value::Object(map) => map.get(key),
        Value::Array(items) => items.get(key.parse::<usize>().ok()?),
        _ => None,
    })
}

pub(super) fn at_mut<'a>(tree: &'a mut Value, path: &[String]) -> Option<&'a mut Value> {
    path.iter().try_fold(tree, |tree, key| match tree {
        Value::Object(map) => map.get_mut(key),
        Value::Array(items) => items.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })
}

pub(super) fn has(tree: &Value, path: &[String]) -> bool {
    at(tree, path).is_some()
}

/// Takes away what is at a place.
pub(super) fn remove(tree: &mut Value, path: &[String]) {
    let Some((last, above)) = path.split_last() else { return };
    match at_mut(tree, above) {
        Some(Value::Object(map)) => _ = map.shift_remove(last),
        Some(Value::Array(items)) => {
            if let Some(at) = last.parse::<usize>().ok().filter(|&at| at < items.len()) {
                items.remove(at);
            }
        }
        _ => {}
    }
}
