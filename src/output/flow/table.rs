//! The short table of a load flow that a person reads.

use std::fmt::Write;

use pennate_analysis::flow::{Flow, Replacement};
use pennate_analysis::solution::status_name;
use pennate_solver::structure::Dimension;

use super::{level, path, role, sense};
use crate::flow::end;
use crate::output::table::summary;
use crate::output::text::{Align, columns, list, number, shown};

/// Paths that are listed before the rest is counted.
const PATHS: usize = 8;
/// Names in a line before the rest is counted.
const NAMES: usize = 8;

/// The whole report.
pub fn report(flow: &Flow) -> String {
    let mut out = String::new();
    if !flow.model.title.is_empty() {
        let _ = writeln!(out, "{}", shown(&flow.model.title));
    }
    let _ = writeln!(out, "{}\n", summary(&flow.model));
    out += &members(flow);
    out.push('\n');
    out += &paths(flow);
    out.push('\n');
    out += &steps(flow);
    let end = end(flow);
    let mut letters = end.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default();
    let _ = writeln!(out, "{first}{}.", letters.as_str());
    out
}

fn members(flow: &Flow) -> String {
    let head = ["member", "role", "sense", "axial", "transverse", "moment", "passed", "level"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for (index, member) in flow.members.iter().enumerate() {
        let name = &flow.model.members[flow.request.members[index]].name;
        let mut row = vec![shown(name), role(member).to_owned(), sense(member).unwrap_or("-").to_owned()];
        // No minus before a zero.
        row.extend(member.shares.map(|share| format!("{:.3}", (share * 1e3).round() / 1e3 + 0.0)));
        row.push(format!("{:.3}", member.passed));
        row.push(level(flow, index).map_or_else(|| "-".to_owned(), |level| level.to_string()));
        rows.push(row);
    }
    use Align::{Left, Right};
    columns(&[Left, Left, Left, Right, Right, Right, Right, Right], &rows)
}

fn paths(flow: &Flow) -> String {
    let mut out = String::new();
    for each in flow.graph.paths.iter().take(PATHS) {
        let names: Vec<String> = path(flow, each).iter().map(|name| shown(name)).collect();
        let _ = writeln!(out, "path {}", names.join(" - "));
    }
    match flow.graph.paths.len() {
        0 => out += "No path leads from the input to an output.\n",
        many if many > PATHS => {
            let _ = writeln!(out, "and {} more", many - PATHS);
        }
        _ => {}
    }
    out
}

/// The networks with muscles: what was replaced, and how the outputs move.
fn steps(flow: &Flow) -> String {
    if flow.steps.is_empty() {
        return String::new();
    }
    let components: &[(usize, &str)] = match flow.model.dimension {
        Dimension::Plane => &[(0, "ux"), (1, "uy")],
        Dimension::Space => &[(0, "ux"), (1, "uy"), (2, "uz")],
    };
    let mut head: Vec<String> = ["level", "muscles", "status", "stable"].map(String::from).to_vec();
    for &output in &flow.request.outputs {
        let name = shown(&flow.model.nodes[output].name);
        head.extend(components.iter().map(|(_, word)| format!("{name} {word}")));
    }
    let [_, _, stress] = flow.model.units.symbols();
    let stressed = flow.steps.iter().any(|step| step.stress.is_some());
    if stressed {
        head.push(format!("stress, {stress}"));
    }
    head.extend(flow.request.requirements.iter().map(|limits| shown(&flow.model.probes.names[limits.probe])));
    let mut align = vec![Align::Right, Align::Left, Align::Left, Align::Left];
    align.resize(head.len(), Align::Right);
    let mut rows = vec![head];
    for step in &flow.steps {
        let mut row = vec![
            step.level.to_string(),
            muscles(flow, step),
            status_name(step.status).replace('_', " "),
            match step.stable {
                Some(true) => "yes",
                Some(false) => "NO",
                None => "not known",
            }
            .to_owned(),
        ];
        for output in &step.outputs {
            row.extend(components.iter().map(|&(component, _)| number(output[component])));
        }
        if stressed {
            row.push(number(step.stress.unwrap_or(f64::NAN)));
        }
        row.extend(step.required.iter().map(|&value| number(value)));
        rows.push(row);
    }
    columns(&align, &rows) + "\n"
}

fn muscles(flow: &Flow, step: &Replacement) -> String {
    let names: Vec<String> = step.muscles.iter().map(|&member| shown(&flow.model.members[member].name)).collect();
    list(&names, NAMES)
}
