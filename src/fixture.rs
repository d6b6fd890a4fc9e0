//! A small solution made by hand, with the names that writers find hardest.

use pennate_analysis::accuracy::{Accuracy, Verdict};
use pennate_analysis::solution::{NodeError, ProbeTable, Solution, Timing, last_state};
use pennate_models::error::Span;
use pennate_models::model::{Body, FixedLaw, Member, MemberKind, Node, Segment, SegmentLaw, Spring, Units};
use pennate_models::{Mesh, Model};
use pennate_solver::history::{
    CriticalKind, CriticalPoint, Equilibrium, History, Increment, MemberShape, MemberState, MeshSize, NodeState, Note,
    Rounding, ShapeCell, ShapePoint, Status, StepHistory,
};
use pennate_solver::structure::{self, Dimension, Release, Stability};

/// Names of the three nodes.
pub(crate) const NODES: [&str; 3] = ["A \"quoted\" <&>", "line\nbreak", "Knoten ä ∂, x"];

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// One member of two segments, a rigid body and a spring; one step with two increments, one that is not reached.
pub(crate) fn solution() -> Solution {
    let model = model();
    let history = history();
    let probes = ProbeTable::new(&model, &history);
    let accuracy = Accuracy { asked: 1e-6, estimated: Some(3e-8), verdict: Verdict::Met, rounds: 1 };
    let mesh = Mesh::new(3, vec![vec![2, 1]]);
    let errors = history.steps.iter().map(|step| errors(step, model.dimension)).collect();
    Solution { model, mesh, history, probes, errors, accuracy, timing: Timing::default() }
}

/// What the nodes of a step differ by on its refined mesh.
fn errors(step: &StepHistory, dimension: Dimension) -> Vec<NodeError> {
    let (Some(last), Some(refined)) = (last_state(step), &step.refined) else { return Vec::new() };
    last.nodes.iter().zip(&refined.nodes).map(|(a, b)| NodeError::between(a, b, dimension)).collect()
}

pub(crate) fn model() -> Model {
    let span = Span::default();
    let node = |index: usize| Node { name: NODES[index].to_owned(), position: [10.0 * index as f64, 0.0, 0.0], span };
    let segment = |radius: f64| Segment {
        length: 5.0,
        material: SegmentLaw::Fixed(FixedLaw {
            section: section(),
            radius,
            shape: None,
            strain: 0.0,
            curvature: [0.0; 3],
        }),
        initial_curvature: [0.0; 3],
        elements: None,
    };
    let member = Member {
        name: "strut,3".to_owned(),
        span,
        nodes: [0, 1],
        group: None,
        kind: MemberKind::Actuated,
        length: 10.0,
        axes: AXES,
        segments: vec![segment(1.0), segment(2.0)],
        releases: [Release::Welded, Release::Welded],
        formulation: structure::Formulation::Exact,
        order: None,
    };
    let step = |name: &str| pennate_models::model::Step {
        name: name.to_owned(),
        span,
        targets: Vec::new(),
        changes: Vec::new(),
        increments: None,
        method: structure::Method::Newton,
        branch: structure::Branch::Stable,
        stop: None,
    };
    let spring = structure::Spring::Axial { nodes: [0, 2], stiffness: 1.0, natural_length: 20.0 };
    Model {
        title: "hand \"made\"".to_owned(),
        units: Units::MmNMpa,
        dimension: Dimension::Plane,
        why_space: None,
        stability: Stability::Space,
        strain_limit: 0.1,
        parameters: Vec::new(),
        settings: Vec::new(),
        nodes: (0..3).map(node).collect(),
        muscles: Vec::new(),
        members: vec![member],
        supports: Vec::new(),
        let_go: Vec::new(),
        bodies: vec![Body { name: "stage".to_owned(), span, nodes: vec![1, 2], reference: 1, mass: 0.0 }],
        springs: vec![Spring { name: "k, 1".to_owned(), span, spring }],
        steps: vec![step("push; \"hard\""), step("later")],
        probes: pennate_models::probes::Probes::default(),
        load_flow: None,
        warnings: Vec::new(),
        sources: Vec::new(),
    }
}

fn section() -> pennate_elements::section::Section {
    pennate_elements::section::Section {
        ea: 1e3,
        ga2: 1e3,
        ga3: 1e3,
        gj: 1.0,
        ei2: 1.0,
        ei3: 1.0,
        mass_per_length: 0.0,
        rotary_inertia: [0.0; 2],
    }
}

fn history() -> History {
    let done = StepHistory {
        status: Status::LimitPoint,
        fraction: 0.75,
        prestress: None,
        iterations: 9,
        factorizations: 10,
        increments: vec![increment(0.5), increment(0.75)],
        refined: Some(state(0.75 + 1e-9)),
        missing: Vec::new(),
        variations: Vec::new(),
        stable: Some(false),
        vibration: None,
        stability: Dimension::Space,
        negative_pivots: 1,
        critical_points: vec![CriticalPoint {
            kind: CriticalKind::LimitPoint,
            fraction: 0.76,
            in_prestress: false,
            increments_before: 2,
            error: None,
            located: None,
            node: 1,
            member: None,
            sideways: false,
            mode: vec![[0.0; 6], [0.0, 0.5, 0.0, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]],
            middles: Vec::new(),
        }],
        jumps: Vec::new(),
        notes: vec![Note::TouchedSingular { fraction: 0.25 }],
        failure: None,
    };
    let missing = StepHistory { status: Status::NotReached, ..StepHistory::empty(Dimension::Space) };
    let mesh = MeshSize { nodes: 4, elements: 3, unknowns: 9 };
    History { steps: vec![done, missing], mesh, ..History::default() }
}

fn increment(fraction: f64) -> Increment {
    let point = |x: f64| ShapePoint {
        reference: [x, 0.0, 0.0],
        displacement: [0.0, -fraction * x, 0.0],
        rotation: [0.0; 3],
        axes: AXES,
    };
    let cell = |segment: usize| ShapeCell { segment, force: [2.0, 0.5, 0.0], ..ShapeCell::default() };
    let shape =
        MemberShape { points: [0.0, 2.5, 5.0, 10.0].map(point).to_vec(), cells: vec![cell(0), cell(0), cell(1)] };
    Increment { fraction, state: state(fraction), shapes: vec![shape] }
}

fn state(fraction: f64) -> Equilibrium {
    let node = |index: usize| NodeState {
        displacement: [0.0, -fraction * index as f64, 0.0],
        rotation_total: 7.0 * fraction,
        rotation: [0.0, 0.0, 7.0 * fraction - std::f64::consts::TAU],
        reaction_force: [f64::NAN, 1.0, -0.0],
        ..NodeState::default()
    };
    Equilibrium {
        nodes: (0..3).map(node).collect(),
        members: vec![MemberState { length: 10.5, axial_force: 2.0, control: 0.3, ..MemberState::default() }],
        springs: vec![0.125],
        compliances: Vec::new(),
        sections: Vec::new(),
        energy: 1.0 / 3.0,
        residual: 1e-13,
        balance: 1e-14,
        joint_balance: 1e-14,
        rounding: Some(Rounding { errors: [Some(1e-12), Some(2e-12), Some(5e-9), None], nodes: [1, 1, 0, 0] }),
    }
}
