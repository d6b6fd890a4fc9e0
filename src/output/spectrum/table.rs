//! The short table of modes that a person reads.

use std::fmt::Write;

use pennate_analysis::spectrum::{Entry, Question, Spectrum};
use pennate_solver::spectral::shape::Spot;
use pennate_solver::spectral::unknowns::Family;

use super::frequency;
use crate::output::text::{Align, columns, estimate, number, percent, shown};
use crate::spectrum::note;

const COMPONENTS: [&str; 6] = ["x", "y", "z", "about x", "about y", "about z"];

/// The whole report.
pub fn report(spectrum: &Spectrum) -> String {
    let mut out = format!("{}\n\n", headline(spectrum));
    let families = spectrum.entries.iter().any(|entry| entry.family != Family::Space);
    let mut head = vec!["mode".to_owned()];
    head.extend(match spectrum.question {
        Question::Modes => vec!["frequency, Hz".to_owned(), "angular, rad/s".to_owned()],
        Question::Buckling => vec!["factor".to_owned()],
    });
    head.push("error".to_owned());
    let values = head.len();
    if families {
        head.push("motion".to_owned());
    }
    head.push("moves most".to_owned());
    let mut align = vec![Align::Right; values];
    align.resize(head.len(), Align::Left);
    let mut rows = vec![head];
    for (index, entry) in spectrum.entries.iter().enumerate() {
        let mut row = vec![(index + 1).to_string()];
        row.extend(value(spectrum.question, entry));
        row.push(entry.error.map_or_else(|| "-".to_owned(), estimate));
        if families {
            row.push(family(entry.family).to_owned());
        }
        row.push(moves_most(spectrum, entry));
        rows.push(row);
    }
    if !spectrum.entries.is_empty() {
        out += &columns(&align, &rows);
        out.push('\n');
    }
    if let Some(reversed) = spectrum.reversed {
        let error = reversed.error.map_or_else(
            || "without an estimate of its error".to_owned(),
            |error| format!("error {}", estimate(error)),
        );
        let _ = writeln!(out, "The other way the nearest factor is {} ({error}).", number(reversed.value));
    }
    for each in &spectrum.notes {
        let _ = writeln!(out, "Note: {}.", note(each));
    }
    let scaled = match spectrum.question {
        Question::Modes => "Modes have the modal mass 1 in the file's units; errors are relative to the frequency.",
        Question::Buckling => "Modes have a largest component of 1; errors are relative to the factor.",
    };
    let _ = writeln!(out, "{scaled}");
    let time = spectrum.timing.solve.as_secs_f64();
    let _ = writeln!(out, "Took {:.3} s with {} unknowns.", time, spectrum.unknowns);
    out
}

fn headline(spectrum: &Spectrum) -> String {
    let title = match spectrum.model.title.is_empty() {
        true => String::new(),
        false => format!("{}: ", shown(&spectrum.model.title)),
    };
    let state = match &spectrum.step {
        Some(step) => format!("the state after '{}'", shown(step)),
        None => "the unloaded state".to_owned(),
    };
    match (spectrum.question, &spectrum.along) {
        (Question::Modes, _) => format!("{title}natural modes about {state}"),
        (Question::Buckling, Some(step)) => {
            format!(
                "{title}linear buckling about {state}; the factor multiplies the ramp of '{}' (1 is its end)",
                shown(step)
            )
        }
        (Question::Buckling, None) => format!(
            "{title}linear buckling about {state}; the factor multiplies all its loads, pressures and prescribed motions"
        ),
    }
}

fn value(question: Question, entry: &Entry) -> Vec<String> {
    match (question, frequency(entry.value)) {
        (Question::Buckling, _) => vec![number(entry.value)],
        (Question::Modes, Some(hertz)) => vec![number(hertz), number(entry.value.sqrt())],
        (Question::Modes, None) => {
            vec!["unstable".to_owned(), format!("grows as e^({} t)", number((-entry.value).sqrt()))]
        }
    }
}

fn family(family: Family) -> &'static str {
    match family {
        Family::Space => "in space",
        Family::InPlane => "in the plane",
        Family::OutOfPlane => "out of the plane",
    }
}

fn moves_most(spectrum: &Spectrum, entry: &Entry) -> String {
    let model = &spectrum.model;
    let place = match entry.largest.spot {
        Spot::Node(node) => format!("node {}", shown(&model.nodes[node].name)),
        Spot::Member(member, part) => {
            format!("member {} at {} of its length", shown(&model.members[member].name), percent(part))
        }
    };
    format!("{place}, {} {}", COMPONENTS[entry.largest.component], number(entry.largest.value))
}
