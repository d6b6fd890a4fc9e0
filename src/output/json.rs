//! `results.json`: everything about the converged states of a run, for programs.

use std::io::{self, Write};

use pennate_analysis::accuracy::Accuracy;
use pennate_analysis::solution::{NodeError, ProbeSteps, Solution, Timing, last_state, status_name};
use pennate_models::Model;
use pennate_solver::history::{CriticalKind, Equilibrium, Growth, MemberState, MeshSize, Rounding, StepHistory};
use pennate_solver::structure::Dimension;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::layout::write_json;
use super::origin::Origin;
use super::table::notes_in_words;
use super::text::undecided;

/// Writes the results of a run; `pictures` are the names of those that were written beside it.
///
/// # Errors
/// Those of the writer.
pub fn write(solution: &Solution, pictures: &[String], writer: &mut dyn Write) -> io::Result<()> {
    write_json(&Results::new(solution, pictures), writer)
}

#[derive(Serialize)]
struct Results<'a> {
    format: &'static str,
    title: &'a str,
    dimension: &'static str,
    units: &'static str,
    /// Of pressures in pictures; nothing where there are no muscles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pressure_unit: Option<&'a str>,
    status: &'static str,
    mesh: Mesh,
    accuracy: Reached,
    steps: Vec<Step<'a>>,
    input: Origin<'a>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    pictures: &'a [String],
    timing: Seconds,
}

/// The discretization error asked for and the one reached, relative to the largest value of its kind.
#[derive(Serialize)]
struct Reached {
    asked: f64,
    /// Null where there is no estimate.
    reached: Option<f64>,
    met: bool,
    verdict: &'static str,
}

#[derive(Serialize)]
struct Mesh {
    nodes: usize,
    elements: usize,
    unknowns: usize,
}

/// Small vibrations about a state: all mass that moves, and the motion that grows fastest.
#[derive(Serialize)]
struct Vibration {
    mass: f64,
    growth: &'static str,
    /// 1/time
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    /// Cycles over time.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency: Option<f64>,
    /// Of both, over the root of the sum of the squares of rate and angular frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<f64>,
}

impl From<&pennate_solver::history::Vibration> for Vibration {
    fn from(found: &pennate_solver::history::Vibration) -> Self {
        let (growth, rate, frequency) = match found.growth {
            Growth::None => ("none", None, None),
            Growth::Divergence { rate } => ("divergence", Some(rate), None),
            Growth::Flutter { frequency, rate } => ("flutter", Some(rate), Some(frequency / std::f64::consts::TAU)),
        };
        Self { mass: found.mass, growth, rate, frequency, error: rate.map(|_| found.error) }
    }
}

#[derive(Serialize)]
struct Step<'a> {
    name: &'a str,
    status: &'static str,
    fraction: f64,
    /// The part of the prestress at which the way to the first step ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    prestress: Option<f64>,
    increments: usize,
    iterations: usize,
    factorizations: usize,
    stable: Option<bool>,
    /// Why there is no verdict where loads have a potential.
    #[serde(skip_serializing_if = "Option::is_none")]
    undecided: Option<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
    /// What the verdict follows from where loads have no potential.
    #[serde(skip_serializing_if = "Option::is_none")]
    vibration: Option<Vibration>,
    stability: &'static str,
    negative_pivots: Option<usize>,
    residual: Option<f64>,
    energy: Option<f64>,
    balance: Option<f64>,
    joint_balance: Option<f64>,
    digits: Option<Digits>,
    critical_points: Vec<CriticalPoint<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    jumps: Vec<Jump<'a>>,
    nodes: Map<'a, Node>,
    bodies: Map<'a, Body>,
    members: Map<'a, Member>,
    springs: Map<'a, Spring>,
    probes: Map<'a, f64>,
    probe_errors: Map<'a, f64>,
    /// Of the probes of stiffness: displacement and rotation for unit forces and moments, by columns.
    #[serde(skip_serializing_if = "Map::is_empty")]
    compliances: Map<'a, [[f64; 6]; 6]>,
}

/// Decimal digits that rounding leaves of the largest values; null for a kind that is rounding alone.
#[derive(Serialize)]
struct Digits {
    displacement: Option<f64>,
    rotation: Option<f64>,
    force: Option<f64>,
    moment: Option<f64>,
}

/// A snap at constant loads to another equilibrium.
#[derive(Serialize)]
struct Jump<'a> {
    fraction: f64,
    energy_released: f64,
    moved: f64,
    node: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    member: Option<&'a str>,
}

#[derive(Serialize)]
struct CriticalPoint<'a> {
    kind: &'static str,
    fraction: f64,
    /// Whether the fraction is a part of the prestress.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    prestress: bool,
    error: Option<f64>,
    node: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    member: Option<&'a str>,
}

#[derive(Serialize)]
struct Node {
    position: [f64; 3],
    displacement: [f64; 3],
    rotation_vector: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation_total: Option<f64>,
    reaction_force: [f64; 3],
    reaction_moment: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<Errors>,
}

#[derive(Serialize)]
struct Errors {
    displacement: f64,
    rotation: f64,
    reaction_force: f64,
    reaction_moment: f64,
}

#[derive(Serialize)]
struct Body {
    displacement: [f64; 3],
    rotation_vector: [f64; 3],
}

#[derive(Serialize)]
struct Member {
    length: f64,
    /// Of a muscle, in its own unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pressure: Option<f64>,
    axial_force: f64,
    start: End,
    end: End,
}

#[derive(Serialize)]
struct End {
    force: [f64; 3],
    moment: [f64; 3],
}

#[derive(Serialize)]
struct Spring {
    force: f64,
}

#[derive(Serialize)]
struct Seconds {
    read_s: f64,
    mesh_s: f64,
    solve_s: f64,
    estimate_s: f64,
    write_s: f64,
}

/// Named values in the order of the input file.
pub(super) struct Map<'a, T>(pub(super) Vec<(&'a str, T)>);

impl<T> Map<'_, T> {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: Serialize> Serialize for Map<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'a> Results<'a> {
    fn new(solution: &'a Solution, pictures: &'a [String]) -> Self {
        let model = &solution.model;
        let steps = solution.steps().zip(&solution.probes.steps).zip(&solution.errors);
        Self {
            format: "pennate-results/1",
            title: &model.title,
            dimension: dimension_name(model.dimension),
            units: model.units.name(),
            pressure_unit: model.pressure_unit(),
            status: status_name(solution.status()),
            mesh: Mesh::from(solution.history.mesh),
            accuracy: Reached::from(solution.accuracy),
            steps: steps
                .map(|(((name, step), probes), errors)| Step::new(model, name, (step, probes, errors)))
                .collect(),
            input: Origin::of(model),
            pictures,
            timing: Seconds::from(solution.timing),
        }
    }
}

impl<'a> Step<'a> {
    fn new(model: &'a Model, name: &'a str, (step, probes, errors): (&StepHistory, &ProbeSteps, &[NodeError])) -> Self {
        let state = last_state(step);
        let named = |values: Option<Vec<f64>>| {
            Map(model.probes.names.iter().map(String::as_str).zip(values.unwrap_or_default()).collect())
        };
        Self {
            name,
            status: status_name(step.status),
            fraction: step.fraction,
            prestress: step.prestress,
            increments: step.increments.len(),
            iterations: step.iterations,
            factorizations: step.factorizations,
            stable: step.stable,
            undecided: undecided(step),
            notes: notes_in_words(model, &step.notes),
            stability: dimension_name(step.stability),
            vibration: step.vibration.as_ref().map(Vibration::from),
            negative_pivots: step.stable.filter(|_| step.vibration.is_none()).map(|_| step.negative_pivots),
            residual: state.map(|state| state.residual),
            energy: state.map(|state| state.energy),
            balance: state.map(|state| state.balance),
            joint_balance: state.map(|state| state.joint_balance),
            digits: state.and_then(|state| state.rounding.as_ref()).map(Digits::from),
            critical_points: critical_points(model, step),
            jumps: jumps(model, step),
            nodes: Map(state.map_or_else(Vec::new, |state| nodes(model, state, errors))),
            bodies: Map(state.map_or_else(Vec::new, |state| bodies(model, state))),
            members: Map(state.map_or_else(Vec::new, |state| members(model, state))),
            springs: Map(state.map_or_else(Vec::new, |state| springs(model, state))),
            probes: named(probes.last().map(<[f64]>::to_vec)),
            probe_errors: named(probes.errors()),
            compliances: Map(state.map_or_else(Vec::new, |state| compliances(model, state))),
        }
    }
}

fn critical_points<'a>(model: &'a Model, step: &StepHistory) -> Vec<CriticalPoint<'a>> {
    let entry = |point: &pennate_solver::history::CriticalPoint| CriticalPoint {
        kind: match point.kind {
            CriticalKind::LimitPoint => "limit_point",
            CriticalKind::Bifurcation => "bifurcation",
        },
        fraction: point.fraction,
        prestress: point.in_prestress,
        error: point.error,
        node: &model.nodes[point.node].name,
        member: point.member.map(|member| model.members[member].name.as_str()),
    };
    step.critical_points.iter().map(entry).collect()
}

fn compliances<'a>(model: &'a Model, state: &Equilibrium) -> Vec<(&'a str, [[f64; 6]; 6])> {
    let names = (0..model.probes.len()).filter(|&probe| model.probes.is_stiffness(probe));
    names.map(|probe| model.probes.names[probe].as_str()).zip(state.compliances.iter().copied()).collect()
}

fn jumps<'a>(model: &'a Model, step: &StepHistory) -> Vec<Jump<'a>> {
    let entry = |jump: &pennate_solver::history::Jump| Jump {
        fraction: jump.fraction,
        energy_released: jump.released,
        moved: jump.moved,
        node: &model.nodes[jump.node].name,
        member: jump.member.map(|member| model.members[member].name.as_str()),
    };
    step.jumps.iter().map(entry).collect()
}

fn nodes<'a>(model: &'a Model, state: &Equilibrium, errors: &[NodeError]) -> Vec<(&'a str, Node)> {
    let entry = |(index, node): (usize, &'a pennate_models::model::Node)| {
        let now = &state.nodes[index];
        let entry = Node {
            position: std::array::from_fn(|axis| node.position[axis] + now.displacement[axis]),
            displacement: now.displacement,
            rotation_vector: now.rotation,
            rotation_total: (model.dimension == Dimension::Plane).then_some(now.rotation_total),
            reaction_force: now.reaction_force,
            reaction_moment: now.reaction_moment,
            errors: errors.get(index).copied().map(Errors::from),
        };
        (node.name.as_str(), entry)
    };
    model.nodes.iter().enumerate().map(entry).collect()
}

fn bodies<'a>(model: &'a Model, state: &Equilibrium) -> Vec<(&'a str, Body)> {
    let entry = |body: &'a pennate_models::model::Body| {
        let reference = &state.nodes[body.reference];
        let entry = Body { displacement: reference.displacement, rotation_vector: reference.rotation };
        (body.name.as_str(), entry)
    };
    model.bodies.iter().map(entry).collect()
}

fn members<'a>(model: &'a Model, state: &Equilibrium) -> Vec<(&'a str, Member)> {
    let end = |now: &MemberState, end: usize| End { force: now.end_forces[end], moment: now.end_moments[end] };
    let entry = |(member, now): (&'a pennate_models::model::Member, &MemberState)| {
        let entry = Member {
            length: now.length,
            pressure: member.is_muscle().then_some(now.control),
            axial_force: now.axial_force,
            start: end(now, 0),
            end: end(now, 1),
        };
        (member.name.as_str(), entry)
    };
    model.members.iter().zip(&state.members).map(entry).collect()
}

fn springs<'a>(model: &'a Model, state: &Equilibrium) -> Vec<(&'a str, Spring)> {
    let entries = model.springs.iter().zip(&state.springs);
    entries.map(|(spring, &force)| (spring.name.as_str(), Spring { force })).collect()
}

fn dimension_name(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Plane => "plane",
        Dimension::Space => "space",
    }
}

impl From<MeshSize> for Mesh {
    fn from(mesh: MeshSize) -> Self {
        Self { nodes: mesh.nodes, elements: mesh.elements, unknowns: mesh.unknowns }
    }
}

impl From<Accuracy> for Reached {
    fn from(accuracy: Accuracy) -> Self {
        Self {
            asked: accuracy.asked,
            reached: accuracy.estimated,
            met: accuracy.is_met(),
            verdict: accuracy.verdict.name(),
        }
    }
}

impl From<&Rounding> for Digits {
    fn from(rounding: &Rounding) -> Self {
        // A tenth of a digit is all that the estimate is worth.
        let [displacement, rotation, force, moment] =
            std::array::from_fn(|kind| rounding.digits(kind).map(|digits| (10.0 * digits).round() / 10.0));
        Self { displacement, rotation, force, moment }
    }
}

impl From<NodeError> for Errors {
    fn from(error: NodeError) -> Self {
        let NodeError { displacement, rotation, reaction_force, reaction_moment } = error;
        Self { displacement, rotation, reaction_force, reaction_moment }
    }
}

impl From<Timing> for Seconds {
    fn from(timing: Timing) -> Self {
        Self {
            read_s: timing.read.as_secs_f64(),
            mesh_s: timing.mesh.as_secs_f64(),
            solve_s: timing.solve.as_secs_f64(),
            estimate_s: timing.estimate.as_secs_f64(),
            write_s: timing.write.as_secs_f64(),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::fixture;
    use pennate_analysis::accuracy::{Accuracy, Verdict};
    use pennate_analysis::solution::Solution;
    use pennate_solver::history::Note;

    fn written() -> (String, Value) {
        let mut out = Vec::new();
        super::write(&fixture::solution(), &["a.pvd".to_owned()], &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let value = serde_json::from_str(&text).unwrap();
        (text, value)
    }

    #[test]
    fn names_and_numbers_survive() {
        let (text, results) = written();
        let step = &results["steps"][0];
        assert_eq!(step["name"], "push; \"hard\"");
        for name in fixture::NODES {
            assert!(step["nodes"][name].is_object(), "{name}");
        }
        assert_eq!(step["energy"].as_f64(), Some(1.0 / 3.0));
        assert_eq!(step["nodes"][fixture::NODES[1]]["reaction_force"], json!([null, 1.0, 0.0]));
        assert!(!text.contains("NaN") && !text.contains("-0.0"));
    }

    #[test]
    fn results_have_the_documented_keys_in_their_order() {
        let (text, results) = written();
        assert_eq!(results["status"], "limit_point");
        let keys = [
            "format",
            "title",
            "dimension",
            "units",
            "status",
            "mesh",
            "accuracy",
            "asked",
            "reached",
            "met",
            "verdict",
            "steps",
            "name",
            "fraction",
            "increments",
            "iterations",
            "factorizations",
            "stable",
            "stability",
            "negative_pivots",
            "residual",
            "energy",
            "balance",
            "joint_balance",
            "digits",
            "critical_points",
            "nodes",
            "position",
            "displacement",
            "rotation_vector",
            "rotation_total",
            "reaction_force",
            "reaction_moment",
            "errors",
            "bodies",
            "members",
            "length",
            "axial_force",
            "start",
            "moment",
            "end",
            "springs",
            "probes",
            "probe_errors",
            "input",
            "version",
            "files",
            "parameters",
            "set",
            "pictures",
            "timing",
            "read_s",
            "mesh_s",
            "solve_s",
            "estimate_s",
            "write_s",
        ];
        let mut rest = text.as_str();
        for key in keys {
            let at = rest.find(&format!("\"{key}\": ")).unwrap_or_else(|| panic!("{key} is missing or out of order"));
            rest = &rest[at..];
        }
    }

    #[test]
    fn what_was_reached_stands_beside_what_was_asked() {
        let (_, results) = written();
        assert_eq!(results["accuracy"], json!({ "asked": 1e-6, "reached": 3e-8, "met": true, "verdict": "met" }));
        let mut solution = fixture::solution();
        solution.accuracy = Accuracy { estimated: None, verdict: Verdict::NotEstimated, ..solution.accuracy };
        let mut out = Vec::new();
        super::write(&solution, &[], &mut out).unwrap();
        let results: Value = serde_json::from_slice(&out).unwrap();
        let expected = json!({ "asked": 1e-6, "reached": null, "met": false, "verdict": "no_estimate" });
        assert_eq!(results["accuracy"], expected);
    }

    #[test]
    fn many_singular_states_that_were_touched_are_one_note() {
        let mut solution = fixture::solution();
        let touched = |fraction| Note::TouchedSingular { fraction };
        let notes = |solution: &Solution| {
            let mut out = Vec::new();
            super::write(solution, &[], &mut out).unwrap();
            let results: Value = serde_json::from_slice(&out).unwrap();
            results["steps"][0]["notes"].as_array().unwrap().clone()
        };
        solution.history.steps[0].notes = vec![touched(0.25), touched(0.5), Note::EndlessMoment { node: 0 }];
        assert_eq!(notes(&solution).len(), 3);
        solution.history.steps[0].notes.extend([touched(0.75), touched(0.8)]);
        let [first, second] = &notes(&solution)[..] else { panic!("{:?}", notes(&solution)) };
        assert!(first.as_str().is_some_and(|text| text.contains("4 times, between 25 % and 80 %")), "{first}");
        assert!(second.as_str().is_some_and(|text| text.contains("moment")), "{second}");
    }

    #[test]
    fn digits_are_those_that_rounding_leaves() {
        let (_, results) = written();
        let digits = &results["steps"][0]["digits"];
        assert_eq!(*digits, json!({ "displacement": 12.0, "rotation": 11.7, "force": 8.3, "moment": null }));
        assert_eq!(results["steps"][1]["digits"], Value::Null);
    }

    #[test]
    fn a_step_that_was_not_reached_holds_no_numbers() {
        let (_, results) = written();
        let step = &results["steps"][1];
        assert_eq!(step["status"], "not_reached");
        assert_eq!(step["nodes"], json!({}));
        assert_eq!(step["energy"], Value::Null);
    }
}
