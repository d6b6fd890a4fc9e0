//! Joints: what is left of the nodes once rigid bodies are merged, what holds them, and their equations.
//!
//! A joint is a node, or a rigid body, with the six components of its reference node. What holds it is a list of
//! [`Held`] rows; the free motions of a joint are the basis of the null space of its rows, so that supports in turned
//! axes, supports on points of a body and partly held rotations are met exactly, by transformation.

use pennate_elements::beam::Placement;
use pennate_elements::rotation::{self, compose, exp, inverse, log, second_variation, tangent_map, turn};
use pennate_elements::small::{M3, V3, add, cross, dot, norm, scale, sub, zeros};

use crate::structure::{NodeId, Release, Spring, Structure};

/// Where a node sits: its joint, and its unloaded position against the joint's reference node.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub joint: usize,
    pub arm: V3<f64>,
}

impl Link {
    pub fn has_arm(&self) -> bool {
        self.arm != [0.0; 3]
    }
}

/// Connection of a member's end, motions that no force belongs to taken out.
#[derive(Clone, Debug, PartialEq)]
pub enum EndKind {
    Welded,
    /// The end turns freely; with `spin_removed` not about the member itself.
    Free {
        spin_removed: bool,
    },
    /// Free about axes that turn with the joint.
    Axes(Vec<V3<f64>>),
}

/// The network as joints and member ends.
#[derive(Clone, Debug)]
pub struct Topology {
    pub links: Vec<Link>,
    /// Reference node of every joint.
    pub references: Vec<NodeId>,
    pub ends: Vec<[EndKind; 2]>,
    /// Motions of joints that no force belongs to: rotation as a whole, or spin about one axis.
    pub idle: Vec<Idle>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Idle {
    None,
    /// The joint has no rotation of its own.
    Rotation,
    /// It does not turn about this axis (global, unloaded, carried along).
    Spin(V3<f64>),
}

const PARALLEL: f64 = 1e-9;

fn parallel(a: V3<f64>, b: V3<f64>) -> bool {
    norm(cross(a, b)) < PARALLEL * norm(a) * norm(b)
}

impl Topology {
    /// `turned` tells of nodes whose rotation is held, loaded or prescribed at any time.
    pub fn new(structure: &Structure, turned: &[bool]) -> Self {
        let count = structure.nodes.len();
        let mut reference: Vec<NodeId> = (0..count).collect();
        for body in &structure.bodies {
            for &node in &body.nodes {
                reference[node] = body.reference;
            }
            reference[body.reference] = body.reference;
        }
        let mut references = Vec::new();
        let mut joint_of = vec![usize::MAX; count];
        for node in 0..count {
            if reference[node] == node {
                joint_of[node] = references.len();
                references.push(node);
            }
        }
        let links: Vec<Link> = (0..count)
            .map(|node| {
                let home = reference[node];
                Link { joint: joint_of[home], arm: sub(structure.nodes[node], structure.nodes[home]) }
            })
            .collect();

        let ends: Vec<[EndKind; 2]> = structure
            .members
            .iter()
            .map(|member| {
                std::array::from_fn(|end| match &member.releases[end] {
                    Release::Welded => EndKind::Welded,
                    Release::Pin => EndKind::Free { spin_removed: false },
                    Release::Axes(axes) if axes.len() >= 3 => EndKind::Free { spin_removed: false },
                    Release::Axes(axes) => EndKind::Axes(axes.clone()),
                })
            })
            .collect();
        let mut topology = Self { idle: vec![Idle::None; references.len()], links, references, ends };
        topology.remove_idle_joints(structure, turned);
        topology.remove_idle_spins(structure, turned);
        topology
    }

    /// Whether a node's rotation is engaged by anything but member ends.
    fn rotation_engaged(&self, structure: &Structure, turned: &[bool]) -> Vec<bool> {
        let mut engaged = vec![false; self.references.len()];
        for (node, link) in self.links.iter().enumerate() {
            engaged[link.joint] |= turned[node];
        }
        for body in &structure.bodies {
            engaged[self.links[body.reference].joint] |= body.nodes.len() > 1;
        }
        for spring in &structure.springs {
            match spring {
                Spring::Ground { node, stiffness } => {
                    engaged[self.links[*node].joint] |= stiffness[3..].iter().any(|&k| k != 0.0);
                }
                Spring::Coupling { nodes, .. } => nodes.iter().for_each(|&n| engaged[self.links[n].joint] = true),
                Spring::Axial { .. } => {}
            }
        }
        engaged
    }

    fn remove_idle_joints(&mut self, structure: &Structure, turned: &[bool]) {
        let engaged = self.rotation_engaged(structure, turned);
        for joint in 0..self.references.len() {
            if engaged[joint] {
                continue;
            }
            let mut axis: Option<V3<f64>> = None;
            let mut common = true;
            let mut welded = false;
            for (member, ends) in structure.members.iter().zip(&self.ends) {
                for end in 0..2 {
                    if self.links[member.nodes[end]].joint != joint {
                        continue;
                    }
                    match &ends[end] {
                        EndKind::Welded => welded = true,
                        EndKind::Free { .. } => {}
                        EndKind::Axes(axes) if axes.len() == 1 => match axis {
                            None => axis = Some(axes[0]),
                            Some(other) => common &= parallel(other, axes[0]),
                        },
                        EndKind::Axes(_) => common = false,
                    }
                }
            }
            self.idle[joint] = match (welded, common, axis) {
                (true, ..) | (_, false, _) => Idle::None,
                (false, true, None) => Idle::Rotation,
                (false, true, Some(axis)) => Idle::Spin(axis),
            };
        }
    }

    /// A straight bar that may spin about itself at both ends keeps one of them from it.
    fn remove_idle_spins(&mut self, structure: &Structure, turned: &[bool]) {
        let engaged = self.rotation_engaged(structure, turned);
        let mut attached = vec![0; self.references.len()];
        for member in &structure.members {
            for node in member.nodes {
                attached[self.links[node].joint] += 1;
            }
        }
        for (index, member) in structure.members.iter().enumerate() {
            if member.segments.iter().any(|s| s.initial_curvature != [0.0; 3]) {
                continue;
            }
            let axis = member.axes[0];
            let joints = member.nodes.map(|n| self.links[n].joint);
            let lone = joints.map(|j| attached[j] == 1 && !engaged[j] && self.idle[j] == Idle::None);
            let spins: [bool; 2] = std::array::from_fn(|end| match &self.ends[index][end] {
                EndKind::Welded => lone[end],
                EndKind::Free { .. } => true,
                EndKind::Axes(axes) => axes.iter().any(|a| parallel(*a, axis)) || lone[end],
            });
            if !(spins[0] && spins[1]) {
                continue;
            }
            for end in 0..2 {
                match &mut self.ends[index][end] {
                    EndKind::Free { spin_removed } => *spin_removed = true,
                    EndKind::Axes(axes) if axes.iter().any(|a| parallel(*a, axis)) => {
                        axes.retain(|a| !parallel(*a, axis));
                        if axes.is_empty() {
                            self.ends[index][end] = EndKind::Welded;
                        }
                    }
                    _ if lone[end] => self.idle[joints[end]] = Idle::Spin(axis),
                    _ => continue,
                }
                break;
            }
        }
    }
}

/// Position and rotation of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    pub place: Placement,
    /// Rotation vector with whole turns, kept where a rotation is partly held.
    pub theta: V3<f64>,
}

impl JointState {
    /// Displacement of a point of the joint.
    pub fn point(&self, arm: V3<f64>) -> V3<f64> {
        add(self.place.displacement, rotation::turn_less_identity(self.place.rotation, arm))
    }

    /// Adds a displacement and a spin.
    pub fn advance(&mut self, change: &[f64; 6]) {
        let spin = [change[3], change[4], change[5]];
        for (u, d) in self.place.displacement.iter_mut().zip(change) {
            *u += d;
        }
        if spin != [0.0; 3] {
            let guess = add(self.theta, spin);
            self.place.rotation = rotation::normalize(compose(exp(spin), self.place.rotation));
            self.place.angle += spin[2];
            self.theta = whole_turns(log(self.place.rotation), guess);
        }
    }
}

/// The rotation vector of the same rotation as `theta` that is nearest to `guess`.
fn whole_turns(theta: V3<f64>, guess: V3<f64>) -> V3<f64> {
    use std::f64::consts::TAU;
    let length = norm(theta);
    let axis = if length > 1e-12 {
        scale(1.0 / length, theta)
    } else if norm(guess) > 1.0 {
        scale(1.0 / norm(guess), guess)
    } else {
        return theta;
    };
    let turns = ((dot(guess, axis) - length) / TAU).round();
    scale(length + turns * TAU, axis)
}

/// What a row holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeldKind {
    /// Displacement of a node along a direction.
    Translation { direction: V3<f64> },
    /// Component of the rotation vector along an axis.
    Rotation { axis: V3<f64> },
}

/// One held component, and the values it has at the beginning and at the end of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    pub node: NodeId,
    /// 0 to 5, in the axes of the node's support.
    pub component: usize,
    pub kind: HeldKind,
    pub from: f64,
    pub to: f64,
}

impl Held {
    pub fn at(&self, fraction: f64) -> f64 {
        if fraction == 1.0 { self.to } else { self.from + fraction * (self.to - self.from) }
    }
}

/// A row of constraint on the spatial motion of a joint: value to be zero, gradient, Hessian of spins.
struct Row {
    value: f64,
    gradient: [f64; 6],
    hessian: M3<f64>,
}

fn row(held: &Held, fraction: f64, state: &JointState, arm: V3<f64>) -> Row {
    let target = held.at(fraction);
    match held.kind {
        HeldKind::Translation { direction: d } => {
            let arm_now = turn(state.place.rotation, arm);
            let lever = cross(arm_now, d);
            Row {
                value: dot(d, state.point(arm)) - target,
                gradient: [d[0], d[1], d[2], lever[0], lever[1], lever[2]],
                hessian: second_variation(d, arm_now),
            }
        }
        HeldKind::Rotation { axis } => {
            let gradient = rotation_row(state.theta, axis);
            let step = 1e-5;
            let mut slopes: M3<f64> = zeros();
            for i in 0..3 {
                let mut spin = [0.0; 3];
                spin[i] = step;
                let ahead = rotation_row(spun(state.theta, spin), axis);
                let behind = rotation_row(spun(state.theta, scale(-1.0, spin)), axis);
                slopes[i] = scale(0.5 / step, sub(ahead, behind));
            }
            Row {
                value: dot(axis, state.theta) - target,
                gradient: [0.0, 0.0, 0.0, gradient[0], gradient[1], gradient[2]],
                hessian: std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (slopes[i][j] + slopes[j][i]))),
            }
        }
    }
}

fn spun(theta: V3<f64>, spin: V3<f64>) -> V3<f64> {
    whole_turns(log(compose(exp(spin), exp(theta))), theta)
}

/// T⁻ᵀ axis: derivative of a component of the rotation vector with respect to spins.
fn rotation_row(theta: V3<f64>, axis: V3<f64>) -> V3<f64> {
    let t = tangent_map(theta);
    let m = nalgebra::Matrix3::from_fn(|i, j| t[i][j]).transpose();
    match m.lu().solve(&nalgebra::Vector3::from(axis)) {
        Some(x) => [x[0], x[1], x[2]],
        None => axis,
    }
}

/// The equations of one joint.
#[derive(Clone, Debug)]
pub struct JointEquations {
    /// First equation and number of equations.
    pub first: usize,
    pub count: usize,
    pub basis: Basis,
    /// Indices of the rows that hold the joint.
    rows: Vec<usize>,
}

#[derive(Clone, Debug)]
pub enum Basis {
    /// Each component is an equation of its own, or held.
    Components([Option<usize>; 6]),
    /// Free motions as columns; the first `count` are in use.
    Columns(Box<[[f64; 6]; 6]>),
}

/// Which components are solved for: all in space; ux, uy, rz in the plane; uz, rx, ry out of it.
pub type Active<const D: usize> = [usize; D];

/// Equations of all joints for one set of components.
#[derive(Clone, Debug)]
pub struct Equations<const D: usize> {
    pub active: Active<D>,
    pub joints: Vec<JointEquations>,
    pub size: usize,
    pub held: Vec<Held>,
    /// Motion of held components still to be made, per joint.
    pub pending: Vec<[f64; 6]>,
    /// Reaction along every held row.
    pub multipliers: Vec<f64>,
}

impl<const D: usize> Equations<D> {
    pub fn new(topology: &Topology, active: Active<D>, held: Vec<Held>) -> Self {
        let joints = topology.references.len();
        let mut rows = vec![Vec::new(); joints];
        for (index, row) in held.iter().enumerate() {
            rows[topology.links[row.node].joint].push(index);
        }
        let mut equations = Self {
            active,
            joints: Vec::with_capacity(joints),
            size: 0,
            pending: vec![[0.0; 6]; joints],
            multipliers: vec![0.0; held.len()],
            held,
        };
        for (joint, rows) in rows.into_iter().enumerate() {
            let idle = topology.idle[joint];
            let (count, basis) = equations.basis_of(topology, &rows, idle);
            equations.joints.push(JointEquations { first: equations.size, count, basis, rows });
            equations.size += count;
        }
        equations
    }

    fn basis_of(&self, topology: &Topology, rows: &[usize], idle: Idle) -> (usize, Basis) {
        let mut free = [false; 6];
        for &component in &self.active {
            free[component] = component < 3 || idle != Idle::Rotation;
        }
        let rotations = self.active.iter().filter(|&&c| c >= 3).count();
        let mut simple = !matches!(idle, Idle::Spin(axis) if self.spin_matters(axis));
        let mut held_rotations = 0;
        for &index in rows {
            let held = &self.held[index];
            let (vector, offset) = match held.kind {
                HeldKind::Translation { direction } => {
                    simple &= !topology.links[held.node].has_arm();
                    (direction, 0)
                }
                HeldKind::Rotation { axis } => (axis, 3),
            };
            match (0..3).find(|&i| vector[i].abs() == 1.0) {
                Some(i) if free[offset + i] || self.active.contains(&(offset + i)) => {
                    held_rotations += usize::from(offset == 3 && free[offset + i]);
                    free[offset + i] = false;
                }
                Some(_) => {}
                None => simple = false,
            }
        }
        let free_rotations = self.active.iter().filter(|&&c| c >= 3 && free[c]).count();
        // Rotations do not add up: a spatial joint is simple where all of them are held, or none.
        simple &= rotations <= 1 || held_rotations == 0 || free_rotations == 0;
        if simple {
            let mut next = 0;
            let mut components = [None; 6];
            for &component in &self.active {
                if free[component] {
                    components[component] = Some(next);
                    next += 1;
                }
            }
            return (next, Basis::Components(components));
        }
        let mut columns = Box::new([[0.0; 6]; 6]);
        let state = JointState::default();
        let found = self.columns(topology, rows, idle, &state, 0.0, &mut columns).0;
        (found, Basis::Columns(columns))
    }

    fn spin_matters(&self, axis: V3<f64>) -> bool {
        self.active.iter().any(|&c| c >= 3 && axis[c - 3].abs() > PARALLEL)
    }

    /// Null space of the rows of a joint, and the motion that still has to be made along them.
    fn columns(
        &self,
        topology: &Topology,
        rows: &[usize],
        idle: Idle,
        state: &JointState,
        fraction: f64,
        columns: &mut [[f64; 6]; 6],
    ) -> (usize, [f64; 6]) {
        let mut basis = [[0.0; 6]; 6];
        let mut rank = 0;
        let mut pending = [0.0; 6];
        let mut include = |mut gradient: [f64; 6], mut value: f64| {
            for c in 0..6 {
                if !self.active.contains(&c) {
                    gradient[c] = 0.0;
                }
            }
            let before = dot6(&gradient, &gradient).sqrt();
            for q in &basis[..rank] {
                let along = dot6(&gradient, q);
                value += along * dot6(&pending, q);
                for c in 0..6 {
                    gradient[c] -= along * q[c];
                }
            }
            let length = dot6(&gradient, &gradient).sqrt();
            if rank < D && length > 1e-8 * before && length > 0.0 {
                for c in 0..6 {
                    basis[rank][c] = gradient[c] / length;
                    pending[c] -= value / length * gradient[c] / length;
                }
                rank += 1;
            }
        };
        for &index in rows {
            let held = &self.held[index];
            let row = row(held, fraction, state, topology.links[held.node].arm);
            include(row.gradient, row.value);
        }
        match idle {
            Idle::None => {}
            Idle::Rotation => {
                for c in 3..6 {
                    let mut unit = [0.0; 6];
                    unit[c] = 1.0;
                    include(unit, 0.0);
                }
            }
            Idle::Spin(axis) => {
                let a = turn(state.place.rotation, axis);
                include([0.0, 0.0, 0.0, a[0], a[1], a[2]], 0.0);
            }
        }
        // Complete the rows to a basis of the active components, the most independent unit vector first.
        let fixed = rank;
        while rank < D {
            let mut best = (0.0, [0.0; 6]);
            for &c in &self.active {
                let mut unit = [0.0; 6];
                unit[c] = 1.0;
                for _ in 0..2 {
                    for q in &basis[..rank] {
                        let along = dot6(&unit, q);
                        for d in 0..6 {
                            unit[d] -= along * q[d];
                        }
                    }
                }
                let length = dot6(&unit, &unit).sqrt();
                if length > best.0 + 1e-9 {
                    best = (length, unit.map(|x| x / length));
                }
            }
            basis[rank] = best.1;
            rank += 1;
        }
        for (target, q) in columns.iter_mut().zip(&basis[fixed..rank]) {
            *target = *q;
        }
        (rank - fixed, pending)
    }

    /// Brings bases and pending motions up to date with the state.
    pub fn update(&mut self, topology: &Topology, states: &[JointState], fraction: f64) {
        for joint in 0..self.joints.len() {
            let mut equations = std::mem::replace(
                &mut self.joints[joint],
                JointEquations { first: 0, count: 0, basis: Basis::Components([None; 6]), rows: Vec::new() },
            );
            let state = &states[joint];
            self.pending[joint] = match &mut equations.basis {
                Basis::Components(_) => self.pending_components(&equations.rows, state, fraction),
                Basis::Columns(columns) => {
                    let idle = topology.idle[joint];
                    self.columns(topology, &equations.rows, idle, state, fraction, columns).1
                }
            };
            self.joints[joint] = equations;
        }
    }

    fn pending_components(&self, rows: &[usize], state: &JointState, fraction: f64) -> [f64; 6] {
        let mut pending = [0.0; 6];
        let mut theta = [0.0; 3];
        let mut turned = false;
        for &index in rows {
            let held = &self.held[index];
            let target = held.at(fraction);
            match held.kind {
                HeldKind::Translation { direction } => {
                    for c in 0..3 {
                        if direction[c].abs() == 1.0 && self.active.contains(&c) {
                            pending[c] = direction[c] * target - state.place.displacement[c];
                        }
                    }
                }
                HeldKind::Rotation { axis } => {
                    turned = true;
                    theta = add(theta, scale(target, axis));
                }
            }
        }
        if turned {
            if D == 3 {
                if self.active.contains(&5) {
                    pending[5] = theta[2] - state.place.angle;
                }
            } else {
                let spin = log(compose(exp(theta), inverse(state.place.rotation)));
                pending[3..].copy_from_slice(&spin);
            }
        }
        pending
    }

    /// Sets held components to their values exactly.
    pub fn enforce(&self, states: &mut [JointState], fraction: f64) {
        for (equations, state) in self.joints.iter().zip(states) {
            let Basis::Components(_) = equations.basis else { continue };
            let mut theta = [0.0; 3];
            let mut turned = false;
            for &index in &equations.rows {
                let held = &self.held[index];
                let target = held.at(fraction);
                match held.kind {
                    HeldKind::Translation { direction } => {
                        for c in 0..3 {
                            if direction[c].abs() == 1.0 && self.active.contains(&c) {
                                state.place.displacement[c] = direction[c] * target;
                            }
                        }
                    }
                    HeldKind::Rotation { axis } => {
                        turned = true;
                        theta = add(theta, scale(target, axis));
                    }
                }
            }
            if turned && (D == 6 || self.active.contains(&5)) {
                state.theta = theta;
                state.place.rotation = exp(theta);
                state.place.angle = theta[2];
            }
        }
    }

    /// The part of a joint's force that its free motions feel: zero along everything held.
    pub fn unbalanced(&self, joint: usize, force: &[f64; 6]) -> [f64; 6] {
        let equations = &self.joints[joint];
        match &equations.basis {
            Basis::Components(components) => {
                std::array::from_fn(|c| if components[c].is_some() { force[c] } else { 0.0 })
            }
            Basis::Columns(columns) => {
                let mut free = [0.0; 6];
                for column in &columns[..equations.count] {
                    let along = dot6(column, force);
                    for c in 0..6 {
                        free[c] += along * column[c];
                    }
                }
                free
            }
        }
    }

    /// Force of a joint in its equations.
    pub fn project(&self, joint: usize, force: &[f64; 6], out: &mut [f64]) {
        let equations = &self.joints[joint];
        match &equations.basis {
            Basis::Components(components) => {
                for (c, equation) in components.iter().enumerate() {
                    if let Some(e) = equation {
                        out[equations.first + e] = force[c];
                    }
                }
            }
            Basis::Columns(columns) => {
                for (e, column) in columns[..equations.count].iter().enumerate() {
                    out[equations.first + e] = dot6(column, force);
                }
            }
        }
    }

    /// Motion of a joint: its equations' part plus what is pending.
    pub fn motion(&self, joint: usize, solution: &[f64], pending: bool) -> [f64; 6] {
        let equations = &self.joints[joint];
        let mut motion = if pending { self.pending[joint] } else { [0.0; 6] };
        match &equations.basis {
            Basis::Components(components) => {
                for (c, equation) in components.iter().enumerate() {
                    if let Some(e) = equation {
                        motion[c] += solution[equations.first + e];
                    }
                }
            }
            Basis::Columns(columns) => {
                for (e, column) in columns[..equations.count].iter().enumerate() {
                    for c in 0..6 {
                        motion[c] += solution[equations.first + e] * column[c];
                    }
                }
            }
        }
        motion
    }

    /// Splits the held part of every joint's force among its rows: the reactions.
    pub fn find_multipliers(&mut self, topology: &Topology, states: &[JointState], forces: &[[f64; 6]], fraction: f64) {
        for (joint, equations) in self.joints.iter().enumerate() {
            match &equations.basis {
                Basis::Components(_) => {
                    for &index in &equations.rows {
                        let (vector, offset) = match self.held[index].kind {
                            HeldKind::Translation { direction } => (direction, 0),
                            HeldKind::Rotation { axis } => (axis, 3),
                        };
                        let force = &forces[joint];
                        self.multipliers[index] = dot(vector, [force[offset], force[offset + 1], force[offset + 2]]);
                    }
                }
                Basis::Columns(_) if equations.rows.is_empty() => {}
                Basis::Columns(_) => {
                    let count = equations.rows.len();
                    let gradients: Vec<[f64; 6]> = equations
                        .rows
                        .iter()
                        .map(|&index| {
                            let held = &self.held[index];
                            row(held, fraction, &states[joint], topology.links[held.node].arm).gradient
                        })
                        .collect();
                    let matrix = nalgebra::DMatrix::from_fn(6, count, |c, r| {
                        if self.active.contains(&c) { gradients[r][c] } else { 0.0 }
                    });
                    let force = nalgebra::DVector::from_fn(6, |c, _| forces[joint][c]);
                    let svd = matrix.svd(true, true);
                    if let Ok(solution) = svd.solve(&force, 1e-10) {
                        for (r, &index) in equations.rows.iter().enumerate() {
                            self.multipliers[index] = solution[r];
                        }
                    }
                }
            }
        }
    }

    /// Stiffness that the curvature of the constraints takes from a joint with general rows: −Σ λ ∇²g on its spins.
    pub fn constraint_stiffness(
        &self,
        topology: &Topology,
        joint: usize,
        state: &JointState,
        fraction: f64,
    ) -> M3<f64> {
        let mut stiffness = zeros();
        let equations = &self.joints[joint];
        if let Basis::Columns(_) = equations.basis {
            for &index in &equations.rows {
                let held = &self.held[index];
                let row = row(held, fraction, state, topology.links[held.node].arm);
                for i in 0..3 {
                    for j in 0..3 {
                        stiffness[i][j] -= self.multipliers[index] * row.hessian[i][j];
                    }
                }
            }
        }
        stiffness
    }

    pub fn is_general(&self, joint: usize) -> bool {
        matches!(self.joints[joint].basis, Basis::Columns(_))
    }

    pub fn has_general(&self) -> bool {
        (0..self.joints.len()).any(|j| self.is_general(j))
    }
}

pub fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
