//! What every member transmits: transferred loads at its inner points, and the parts of their energy.

use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use pennate_models::Model;
use pennate_models::model::LoadFlow;
use pennate_solver::error::FreeMotion;
use pennate_solver::options::Options;
use pennate_solver::structure::Dimension;
use pennate_solver::structure::NodeId;

use super::base::{self, Points};
use super::compliance::{Linear, linear};
use super::graph::Graph;

/// Axial part of the transferred energy from which on a member is a transmitter. Mechanisms of the dissertation have 0.96 and
/// more in transmitters and 0.02 and less elsewhere (docs/synthesis.md).
const AXIAL: f64 = 0.5;
/// Part of the energy of the input below which what a member passes on is rounding.
const NOTHING: f64 = 1e-18;
/// Compliances below this part of the largest are rounding; forces times the length of the member are compared with moments.
const RIGID: f64 = 1e-15;
/// Steps at most towards the eigenvalues of six rows, which take a few for each: the library sets no limit of its own.
const STEPS: usize = 1000;

/// What a member is in the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It passes load on along its axis.
    Transmitter,
    /// It holds other members where they are.
    Constraint,
    /// The input does not move it.
    Idle,
}

/// The load transferred to a point of a member.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Its place, unloaded.
    pub position: [f64; 3],
    /// Unit tangent from the start of the member to its end.
    pub tangent: [f64; 3],
    /// Force and moment: what a clamp there would receive, with the other sign.
    pub load: [f64; 6],
    /// Displacement and rotation under the load of the input.
    pub motion: [f64; 6],
}

/// A member in the flow.
#[derive(Clone, Debug)]
pub struct MemberFlow {
    /// What it is.
    pub role: Role,
    /// Parts of the transferred energy: axial, transverse, moment. Their sum is one; of an idle member they are zero.
    pub shares: [f64; 3],
    /// Mean axial load, positive in tension, seen from the input.
    pub axial: f64,
    /// Mean transferred energy over that of the input.
    pub passed: f64,
    /// Whether one of its ends is held by the ground: it lies on no path.
    pub grounded: bool,
    /// Inner points, evenly from the start to the end.
    pub points: Vec<Point>,
}

impl MemberFlow {
    /// Whether a muscle that contracts, or one that extends, may take its place.
    pub fn is_replaceable(&self, contracts: bool) -> bool {
        self.role == Role::Transmitter && (self.axial > 0.0) == contracts && !self.grounded
    }
}

/// Why there is nothing to say of the members.
pub(super) enum Nothing {
    Mechanism(Vec<FreeMotion>),
    Held(NodeId),
}

/// The members of a mechanism in the order of the file, and the motions of its outputs.
pub(super) fn members(
    base: &Model,
    request: &LoadFlow,
    graph: &Graph,
    options: &Options,
) -> Result<(Vec<MemberFlow>, Vec<[f64; 6]>), Nothing> {
    let (whole, _) = pennate_models::discretize(base, &pennate_models::Mesh::initial(base, 1e-3));
    let motions = pennate_solver::free_motions(&whole, &[]);
    if !motions.is_empty() {
        return Err(Nothing::Mechanism(motions));
    }
    let (structure, points) = base::cut(base);
    let work = |linear: &mut dyn Linear| -> Result<(Vec<MemberFlow>, Vec<[f64; 6]>), Nothing> {
        let all: Vec<NodeId> = (0..structure.nodes.len()).collect();
        let mut moved = vec![Vector6::zeros(); all.len()];
        for input in &request.inputs {
            let motions = linear.motions(input.node, &input.load, &all);
            moved.iter_mut().zip(motions).for_each(|(sum, motion)| *sum += Vector6::from(motion));
        }
        let energy: f64 = request.inputs.iter().map(|input| Vector6::from(input.load).dot(&moved[input.node])).sum();
        // Not a number is no energy either.
        if !(energy > 0.0) {
            return Err(Nothing::Held(request.inputs[0].node));
        }
        let mut found = Vec::with_capacity(points.len());
        for (index, points) in points.iter().enumerate() {
            let scale = base.members[index].length;
            let flow = member(linear, base, &structure.nodes, points, &moved, scale, energy);
            let sign = if graph.edges[index].forward { 1.0 } else { -1.0 };
            found.push(MemberFlow { axial: sign * flow.axial, grounded: graph.edges[index].grounded, ..flow });
        }
        Ok((found, request.outputs.iter().map(|&output| moved[output].into()).collect()))
    };
    // Motions of the pieces have no names.
    linear(&structure, options, work).map_err(|_| Nothing::Mechanism(Vec::new()))?
}

fn member(
    linear: &mut dyn Linear,
    base: &Model,
    places: &[[f64; 3]],
    points: &Points,
    moved: &[Vector6<f64>],
    scale: f64,
    energy: f64,
) -> MemberFlow {
    let inner = 1..points.nodes.len() - 1;
    let count = inner.len() as f64;
    let (mut parts, mut axial) = ([0.0; 3], 0.0);
    let mut all = Vec::with_capacity(inner.len());
    for k in inner {
        let (node, tangent) = (points.nodes[k], points.tangents[k]);
        let motion = moved[node];
        let load = transferred(linear, node, &motion, scale, base.dimension);
        let [force, moment] = [0, 3].map(|first| load.fixed_rows::<3>(first).into_owned());
        let [moves, turns] = [0, 3].map(|first| motion.fixed_rows::<3>(first).into_owned());
        let along = force.dot(&tangent) * moves.dot(&tangent);
        parts[0] += along;
        parts[1] += force.dot(&moves) - along;
        parts[2] += moment.dot(&turns);
        axial -= force.dot(&tangent) / count;
        all.push(Point { position: places[node], tangent: tangent.into(), load: load.into(), motion: motion.into() });
    }
    let total: f64 = parts.iter().sum();
    let passed = total / count / energy;
    if !(passed > NOTHING) {
        return MemberFlow {
            role: Role::Idle,
            shares: [0.0; 3],
            axial: 0.0,
            passed: 0.0,
            grounded: false,
            points: all,
        };
    }
    let shares = parts.map(|part| part / total);
    let role = if shares[0] >= AXIAL { Role::Transmitter } else { Role::Constraint };
    MemberFlow { role, shares, axial, passed, grounded: false, points: all }
}

/// fₜ = Cₚₚ⁻¹ uₚ; moments are measured by the length of the member, and what cannot move has no load.
fn transferred(
    linear: &mut dyn Linear,
    node: NodeId,
    motion: &Vector6<f64>,
    scale: f64,
    dimension: Dimension,
) -> Vector6<f64> {
    let active: &[usize] = if dimension == Dimension::Plane { &[0, 1, 5] } else { &[0, 1, 2, 3, 4, 5] };
    let mut compliance = Matrix6::zeros();
    for &component in active {
        let mut load = [0.0; 6];
        load[component] = 1.0;
        let column = linear.motions(node, &load, &[node])[0];
        active.iter().for_each(|&row| compliance[(row, component)] = column[row]);
    }
    let sizes = Vector6::new(1.0, 1.0, 1.0, scale, scale, scale);
    let scaled = Matrix6::from_fn(|i, j| (compliance[(i, j)] + compliance[(j, i)]) / 2.0 * sizes[i] * sizes[j]);
    let wanted = motion.component_mul(&sizes);
    // A tangent that cannot be solved tells nothing.
    if !scaled.iter().all(|value| value.is_finite()) {
        return Vector6::zeros();
    }
    let Some(SymmetricEigen { eigenvectors, eigenvalues }) = SymmetricEigen::try_new(scaled, f64::EPSILON, STEPS)
    else {
        return Vector6::zeros();
    };
    let least = RIGID * eigenvalues.amax();
    let mut load = Vector6::zeros();
    for (vector, &value) in eigenvectors.column_iter().zip(eigenvalues.iter()) {
        if value > least {
            load += vector * (vector.dot(&wanted) / value);
        }
    }
    load.component_mul(&sizes)
}
