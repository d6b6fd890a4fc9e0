//! Structures as network files, as far as the format can say what they are.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use pennate_solver::structure::{
    Branch, Change, Dimension, Drive, Formulation, Member, Method, Release, SectionState, Spring, Stability, Step,
    Stop, Structure, Support,
};
use serde_json::{Map, Value, json};

use crate::tree::number;

/// Directions that differ by less are one.
const SAME: f64 = 1e-9;

/// Names of the components of a node.
const COMPONENTS: [&str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];

/// The network file of a structure with its steps, as a tree, and what of it the format cannot say.
///
/// Nodes are called N0, N1 …, members M0 …, sections S0 … after the laws; meshes are written out, so that the file solves on the
/// same elements. The format knows no passive section whose stiffness follows an actuation, and of two free axes at an end only
/// the member's own.
pub fn write(structure: &Structure, steps: &[Step]) -> (Value, Vec<String>) {
    let mut writer = Writer { structure, unsaid: Vec::new(), laws: Vec::new() };
    let mut top = Map::new();
    top.insert("format".to_owned(), json!("pennate/1"));
    match (structure.dimension, structure.stability) {
        (Dimension::Space, _) => _ = top.insert("dimension".to_owned(), json!("space")),
        (Dimension::Plane, Stability::Plane) => _ = top.insert("dimension".to_owned(), json!("plane")),
        // The file is solved in the plane by itself.
        (Dimension::Plane, Stability::Space) => {}
    }
    for (key, table) in [
        ("nodes", writer.nodes()),
        ("sections", writer.sections()),
        ("members", writer.members()),
        ("supports", writer.supports()),
        ("rigid_bodies", writer.bodies()),
        ("springs", writer.springs()),
        ("probes", writer.probes()),
    ] {
        if !table.is_empty() {
            top.insert(key.to_owned(), Value::Object(table));
        }
    }
    let steps = writer.steps(steps);
    if !steps.is_empty() {
        top.insert("steps".to_owned(), Value::Array(steps));
    }
    (Value::Object(top), writer.unsaid)
}

struct Writer<'a> {
    structure: &'a Structure,
    unsaid: Vec<String>,
    /// What each law is at a control of one.
    laws: Vec<SectionState>,
}

impl Writer<'_> {
    fn in_plane(&self) -> bool {
        self.structure.dimension == Dimension::Plane
    }

    fn nodes(&self) -> Map<String, Value> {
        let place = |at: &[f64; 3]| if self.in_plane() { vector(&at[..2]) } else { vector(at) };
        self.structure.nodes.iter().enumerate().map(|(index, at)| (node(index), place(at))).collect()
    }

    fn sections(&mut self) -> Map<String, Value> {
        let mut table = Map::new();
        for (index, law) in self.structure.laws.iter().enumerate() {
            let [rest, half, full] = [0.0, 0.5, 1.0].map(|control| law.at(control));
            if [half, full].iter().any(|state| state.section != rest.section) {
                self.unsaid.push(format!("the stiffness of section S{index} follows the control"));
            }
            let proportional = |a: f64, b: f64, c: f64| a == 0.0 && (2.0 * b - c).abs() <= 1e-12 * c.abs();
            if !proportional(rest.strain, half.strain, full.strain)
                || (0..3).any(|i| !proportional(rest.curvature[i], half.curvature[i], full.curvature[i]))
            {
                self.unsaid.push(format!("the strain of section S{index} is not in proportion to the control"));
            }
            let section = rest.section;
            if section.rotary_inertia != [0.0; 2] {
                self.unsaid.push(format!("section S{index} has a rotary inertia"));
            }
            let plane = self.in_plane() && self.structure.stability == Stability::Plane;
            let values = [
                ("EA", section.ea, false),
                ("GA2", section.ga2, false),
                ("GA3", section.ga3, plane),
                ("GJ", section.gj, plane),
                ("EI2", section.ei2, plane),
                ("EI3", section.ei3, false),
                ("mass_per_length", section.mass_per_length, section.mass_per_length == 0.0),
            ];
            let given = values.into_iter().filter(|(_, value, left_out)| value.is_finite() && !left_out);
            let stiffness: Map<_, _> = given.map(|(key, value, _)| (key.to_owned(), number(value))).collect();
            let mut entry = Map::from_iter([("stiffness".to_owned(), Value::Object(stiffness))]);
            if section.ea.is_infinite() {
                entry.insert("stretch".to_owned(), json!(false));
            }
            table.insert(format!("S{index}"), Value::Object(entry));
            self.laws.push(SectionState { section, ..full });
        }
        table
    }

    fn is_actuated(&self, member: &Member) -> bool {
        member.segments.iter().any(|segment| {
            let law = &self.laws[segment.law];
            law.strain != 0.0 || law.curvature != [0.0; 3]
        })
    }

    fn members(&mut self) -> Map<String, Value> {
        let mut table = Map::new();
        for (index, member) in self.structure.members.iter().enumerate() {
            let mut entry = Map::from_iter([("nodes".to_owned(), json!(member.nodes.map(node)))]);
            let curved = member.segments.iter().any(|segment| segment.initial_curvature != [0.0; 3]);
            let [tangent, second, _] = member.axes.map(Vector3::from);
            if curved {
                entry.insert("length".to_owned(), number(member.length()));
                entry.insert("tangent".to_owned(), self.vector(tangent));
            }
            if (second - default_axis(&tangent)).norm() > SAME {
                entry.insert("orientation".to_owned(), vector(second.as_slice()));
            }
            match member.segments.as_slice() {
                [only] if !curved && !self.is_actuated(member) => {
                    entry.insert("section".to_owned(), json!(format!("S{}", only.law)));
                    entry.insert("elements".to_owned(), json!(only.elements));
                }
                segments => {
                    let segments = segments.iter().map(|segment| self.segment(segment)).collect();
                    entry.insert("segments".to_owned(), Value::Array(segments));
                }
            }
            if member.formulation != Formulation::default() {
                entry.insert("formulation".to_owned(), json!(member.formulation.about().word));
            }
            if member.formulation.has_higher_orders() {
                entry.insert("order".to_owned(), json!(member.order));
            }
            let mut releases = Map::new();
            for (end, name) in ["start", "end"].into_iter().enumerate() {
                let straight = !curved || end == 0;
                match release(&member.releases[end], straight.then_some(&member.axes)) {
                    Ok(None) => {}
                    Ok(Some(release)) => _ = releases.insert(name.to_owned(), release),
                    Err(()) => self.unsaid.push(format!("the axes that the {name} of M{index} is free about")),
                }
            }
            if !releases.is_empty() {
                entry.insert("release".to_owned(), Value::Object(releases));
            }
            table.insert(format!("M{index}"), Value::Object(entry));
        }
        table
    }

    fn segment(&self, segment: &pennate_solver::structure::Segment) -> Value {
        let law = &self.laws[segment.law];
        let mut entry = Map::new();
        entry.insert("length".to_owned(), number(segment.length));
        entry.insert("section".to_owned(), json!(format!("S{}", segment.law)));
        if segment.initial_curvature != [0.0; 3] {
            entry.insert("initial_curvature".to_owned(), vector(&segment.initial_curvature));
        }
        if law.strain != 0.0 {
            entry.insert("strain".to_owned(), number(law.strain));
        }
        if law.curvature != [0.0; 3] {
            entry.insert("curvature".to_owned(), vector(&law.curvature));
        }
        entry.insert("elements".to_owned(), json!(segment.elements));
        Value::Object(entry)
    }

    fn vector(&self, of: Vector3<f64>) -> Value {
        if self.in_plane() { vector(&of.as_slice()[..2]) } else { vector(of.as_slice()) }
    }

    fn supports(&mut self) -> Map<String, Value> {
        let mut table = Map::new();
        for support in &self.structure.supports {
            match held(support) {
                Some(value) => _ = table.insert(node(support.node), value),
                None => self.unsaid.push(format!("the axes of the support of N{}", support.node)),
            }
        }
        table
    }

    fn bodies(&self) -> Map<String, Value> {
        let entry = |body: &pennate_solver::structure::RigidBody| {
            let nodes: Vec<_> = body.nodes.iter().map(|&index| node(index)).collect();
            let mut entry = json!({ "nodes": nodes, "reference": node(body.reference) });
            if body.mass != 0.0 {
                entry["mass"] = number(body.mass);
            }
            entry
        };
        self.structure.bodies.iter().enumerate().map(|(index, body)| (format!("B{index}"), entry(body))).collect()
    }

    fn springs(&self) -> Map<String, Value> {
        let components = |stiffness: &[f64; 6]| {
            let acts = |&c: &usize| !self.in_plane() || matches!(c, 0 | 1 | 5);
            let given = (0..6).filter(acts).filter(|&c| stiffness[c] != 0.0);
            Value::Object(given.map(|c| (COMPONENTS[c].to_owned(), number(stiffness[c]))).collect())
        };
        let entry = |spring: &Spring| match spring {
            Spring::Ground { node: at, stiffness } => {
                json!({ "node": node(*at), "stiffness": components(stiffness) })
            }
            Spring::Axial { nodes, stiffness, natural_length } => {
                json!({ "nodes": nodes.map(node), "stiffness": number(*stiffness), "natural_length": number(*natural_length) })
            }
            Spring::Coupling { nodes, stiffness } => {
                json!({ "nodes": nodes.map(node), "stiffness": components(stiffness) })
            }
        };
        let springs = self.structure.springs.iter().enumerate();
        springs.map(|(index, spring)| (format!("K{index}"), entry(spring))).collect()
    }

    fn probes(&mut self) -> Map<String, Value> {
        let mut table = Map::new();
        for (index, wanted) in self.structure.compliances.iter().enumerate() {
            let [moves, turns] = [&wanted.along[..3], &wanted.along[3..]];
            let along = (0..6)
                .find(|&c| wanted.along[c] == 1.0)
                .filter(|&one| (0..6).all(|c| c == one || wanted.along[c] == 0.0));
            let direction = match along {
                Some(c) => json!(COMPONENTS[c]),
                None if turns.iter().all(|&x| x == 0.0) => vector(moves),
                None => {
                    self.unsaid.push(format!("the compliance of N{} about an axis", wanted.node));
                    continue;
                }
            };
            table.insert(format!("k{index}"), json!({ "node": node(wanted.node), "stiffness": direction }));
        }
        for &member in &self.structure.sections {
            table.insert(format!("m{member}"), json!({ "member": format!("M{member}"), "moment": "max" }));
        }
        table
    }

    fn steps(&mut self, steps: &[Step]) -> Vec<Value> {
        let mut values = vec![0.0; self.structure.drives.len()];
        let mut written = Vec::new();
        for step in steps {
            step.targets.iter().for_each(|&(drive, target)| values[drive] = target);
            let mut entry = Map::new();
            self.targets(step, &values, &mut entry);
            step.changes.iter().for_each(|change| insert_change(change, &mut entry));
            match step.method {
                Method::Newton => {}
                Method::ArcLength => _ = entry.insert("method".to_owned(), json!("arc_length")),
                Method::Jump => _ = entry.insert("method".to_owned(), json!("jump")),
            }
            if step.branch == Branch::Primary {
                entry.insert("branch".to_owned(), json!("primary"));
            }
            if let Some(count) = step.min_increments {
                entry.insert("increments".to_owned(), json!(count));
            }
            if let Some(stop) = step.stop {
                entry.insert("stop".to_owned(), stopped(stop));
            }
            written.push(Value::Object(entry));
        }
        written
    }

    /// The loads that a step moves, with the values of all their components.
    fn targets(&self, step: &Step, values: &[f64], entry: &mut Map<String, Value>) {
        let mut sums: BTreeMap<(&str, String), ([f64; 3], bool)> = BTreeMap::new();
        for (drive, (&of, &value)) in self.structure.drives.iter().zip(values).enumerate() {
            let moved = step.targets.iter().any(|&(target, _)| target == drive);
            let (key, name, component) = match of {
                Drive::Control => {
                    for (index, member) in self.structure.members.iter().enumerate() {
                        if moved && member.control == Some(drive) && self.is_actuated(member) {
                            let actuation = entry.entry("actuation").or_insert_with(|| json!({}));
                            actuation[format!("M{index}")] = number(value);
                        }
                    }
                    continue;
                }
                Drive::Force(at, c) => ("force", node(at), c),
                Drive::Moment(at, c) => ("moment", node(at), c),
                Drive::FollowerForce(at, c) => ("follower_force", node(at), c),
                Drive::FollowerMoment(at, c) => ("follower_moment", node(at), c),
                Drive::Gravity(c) => ("gravity", String::new(), c),
                Drive::Distributed(member, c) => ("distributed", format!("M{member}"), c),
            };
            let sum = sums.entry((key, name)).or_default();
            sum.0[component] += value;
            sum.1 |= moved;
        }
        for ((key, name), (value, moved)) in sums {
            if !moved {
                continue;
            }
            if name.is_empty() {
                entry.insert(key.to_owned(), vector(&value));
            } else {
                entry.entry(key).or_insert_with(|| json!({}))[name] = vector(&value);
            }
        }
    }
}

fn node(index: usize) -> String {
    format!("N{index}")
}

fn vector(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|&value| number(value)).collect())
}

/// Axis 2 of a straight member that says nothing of it.
fn default_axis(tangent: &Vector3<f64>) -> Vector3<f64> {
    let across = Vector3::z().cross(tangent);
    if across.norm() > 1e-6 { across.normalize() } else { (Vector3::y() - tangent.y * tangent).normalize() }
}

/// How a release is written, given the member's own axes where they are the same at this end; none of a welded end.
fn release(release: &Release, own: Option<&[[f64; 3]; 3]>) -> Result<Option<Value>, ()> {
    let axes = match release {
        Release::Welded => return Ok(None),
        Release::Pin => return Ok(Some(json!("pin"))),
        Release::Axes(axes) => axes,
    };
    if let [axis] = axes.as_slice() {
        return Ok(Some(json!({ "hinge": vector(axis) })));
    }
    let name = |axis: &[f64; 3]| {
        let same = |own: &[f64; 3]| Vector3::from(*own).cross(&Vector3::from(*axis)).norm() < SAME;
        own?.iter().position(same).map(|index| COMPONENTS[3 + index])
    };
    let names: Option<Vec<_>> = axes.iter().map(name).collect();
    names.map(|names| Some(json!(names))).ok_or(())
}

/// How a support is written; none where its axes are not those of an x axis alone.
fn held(support: &Support) -> Option<Value> {
    let fixed: Vec<&str> = (0..6).filter(|&c| support.fixed[c]).map(|c| COMPONENTS[c]).collect();
    let fix = match support.fixed {
        [true, true, true, true, true, true] => json!("clamped"),
        [true, true, true, false, false, false] => json!("pinned"),
        _ => json!(fixed),
    };
    let [x, y, _] = support.axes.map(Vector3::from);
    if (x - Vector3::x()).norm() < SAME && (y - Vector3::y()).norm() < SAME {
        return Some(fix);
    }
    let all = fixed.len() == 6;
    match (y - default_axis(&x)).norm() < SAME {
        true => Some(json!({ "fix": fix, "x_axis": vector(x.as_slice()) })),
        false => all.then_some(fix),
    }
}

fn insert_change(change: &Change, entry: &mut Map<String, Value>) {
    let degrees = |component: usize, value: f64| number(if component < 3 { value } else { value.to_degrees() });
    let mut moved = |key: &str, at: usize, component: usize, value: f64| {
        let motions = entry.entry(key).or_insert_with(|| json!({}));
        motions[node(at)][COMPONENTS[component]] = degrees(component, value);
    };
    match *change {
        Change::Prescribe { node, component, to } if component < 3 => moved("displacement", node, component, to),
        Change::Prescribe { node, component, to } => moved("rotation", node, component, to),
        Change::MoveBy { node, component, by } => moved("displace_by", node, component, by),
        Change::Hold { node: at, component } | Change::Free { node: at, component } => {
            let key = if matches!(change, Change::Hold { .. }) { "hold" } else { "free" };
            let fixes = entry.entry(key).or_insert_with(|| json!({}));
            if fixes[node(at)].is_null() {
                fixes[node(at)] = json!([]);
            }
            fixes[node(at)].as_array_mut().into_iter().for_each(|list| list.push(json!(COMPONENTS[component])));
        }
    }
}

fn stopped(stop: Stop) -> Value {
    match stop {
        Stop::At { node: at, component, value } => {
            let value = if component < 3 { value } else { value.to_degrees() };
            json!({ "node": node(at), "displacement": COMPONENTS[component], "at": number(value) })
        }
        Stop::Fraction(fraction) => json!({ "fraction": number(fraction) }),
        Stop::Increments(count) => json!({ "increments": count }),
    }
}
