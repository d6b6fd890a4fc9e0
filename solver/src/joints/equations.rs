//! Equations of the joints: which components, or combinations of them, are free.
//!
//! Theory: docs/theory/joints.md, Eq. 5.7.

use std::ops::Range;

use pennate_elements::rotation::{compose, exp, inverse, log, tangent_map, turn};
use pennate_elements::small::{M3, V3, add, apply, dot, norm, scale, sub, zeros};

use super::gradients::{Gradient, Gradients};
use super::held::{Held, HeldKind, JointState, rotation_row, row, whole_turns};
use super::topology::Topology;
use super::{Idle, PARALLEL};

/// The equations of one joint.
#[derive(Clone, Debug)]
pub struct JointEquations {
    /// First equation and number of equations.
    pub first: usize,
    /// How many equations the joint has.
    pub count: usize,
    /// The motions that these are of.
    pub basis: Basis,
    /// Where the rows that hold it are among those of all joints.
    rows: Range<usize>,
}

/// Free motions of a joint.
#[derive(Clone, Debug)]
pub enum Basis {
    /// Each component is an equation of its own, or held.
    Components([Option<usize>; 6]),
    /// Free motions as columns; the first `count` are in use.
    Columns(Box<[[f64; 6]; 6]>),
}

/// Number of free motions of a joint, the motion its rows still ask for, and what they ask beyond that.
struct Motions {
    count: usize,
    pending: [f64; 6],
    missed: [f64; 2],
}

/// Which components are solved for: all in space; ux, uy, rz in the plane; uz, rx, ry out of it.
pub type Active<const D: usize> = [usize; D];

/// Equations of all joints for one set of components.
#[derive(Clone, Debug)]
pub struct Equations<const D: usize> {
    /// Components that are solved for.
    pub active: Active<D>,
    /// By index of the joint.
    pub joints: Vec<JointEquations>,
    /// Number of equations of all joints.
    pub size: usize,
    /// Rows that hold components, one after the other.
    pub held: Vec<Held>,
    /// Their indices, joint after joint.
    rows: Vec<usize>,
    /// Motion of held components still to be made, per joint.
    pub pending: Vec<[f64; 6]>,
    /// Reaction along every held row.
    pub multipliers: Vec<f64>,
    /// By how much, per joint, rows are missed that depend on others: a displacement, and an angle.
    pub missed: Vec<[f64; 2]>,
}

impl<const D: usize> Equations<D> {
    /// Numbers the free components of all joints.
    pub(crate) fn new(topology: &Topology, active: Active<D>, held: Vec<Held>) -> Self {
        let joints = topology.references.len();
        let joint_of = |index: usize| topology.links[held[index].node].joint;
        let mut rows: Vec<usize> = (0..held.len()).collect();
        // Most are in this order already; those of one joint keep theirs.
        rows.sort_by_key(|&index| joint_of(index));
        let mut ends = Vec::with_capacity(joints);
        let mut next = 0;
        for joint in 0..joints {
            next += rows[next..].iter().take_while(|&&index| joint_of(index) == joint).count();
            ends.push(next);
        }
        let mut equations = Self {
            active,
            joints: Vec::with_capacity(joints),
            size: 0,
            pending: vec![[0.0; 6]; joints],
            multipliers: vec![0.0; held.len()],
            missed: vec![[0.0; 2]; joints],
            held,
            rows,
        };
        let mut start = 0;
        for (joint, end) in ends.into_iter().enumerate() {
            let rows = start..end;
            let (count, basis) = equations.basis_of(topology, &equations.rows[rows.clone()], topology.idle[joint]);
            equations.joints.push(JointEquations { first: equations.size, count, basis, rows });
            equations.size += count;
            start = end;
        }
        equations
    }

    /// Forgets what belongs to a state.
    pub(crate) fn unload(&mut self) {
        self.pending.fill([0.0; 6]);
        self.multipliers.fill(0.0);
        self.missed.fill([0.0; 2]);
    }

    /// Whether the joints of others have as many free motions each, components of their own or none.
    pub(crate) fn are_like(&self, other: &Self) -> bool {
        let same = |(a, b): (&JointEquations, &JointEquations)| match (&a.basis, &b.basis) {
            (Basis::Components(own), Basis::Components(theirs)) => own == theirs,
            (Basis::Columns(_), Basis::Columns(_)) => a.count == b.count,
            _ => false,
        };
        self.joints.len() == other.joints.len() && self.joints.iter().zip(&other.joints).all(same)
    }

    fn basis_of(&self, topology: &Topology, rows: &[usize], idle: Idle) -> (usize, Basis) {
        let mut free = [false; 6];
        for &component in &self.active {
            free[component] = component < 3 || idle != Idle::Rotation;
        }
        let rotations = self.active.iter().filter(|&&c| c >= 3).count();
        let mut simple = !idle.axes().iter().any(|axis| self.spin_matters(axis));
        let mut held_rotations = 0;
        let mut taken = [false; 6];
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
                    // Two nodes of a body at one place may hold the same component.
                    simple &= !std::mem::replace(&mut taken[offset + i], true);
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
        let found = self.columns(topology, rows, idle, &state, 0.0, 0, &mut columns).count;
        (found, Basis::Columns(columns))
    }

    fn spin_matters(&self, axis: &V3<f64>) -> bool {
        self.active.iter().any(|&c| c >= 3 && axis[c - 3].abs() > PARALLEL)
    }

    /// Null space of the rows of a joint, of `count` motions at least, and the motion still to be made along the rows.
    #[expect(clippy::too_many_arguments, reason = "a joint with all that acts on it")]
    fn columns(
        &self,
        topology: &Topology,
        rows: &[usize],
        idle: Idle,
        state: &JointState,
        fraction: f64,
        count: usize,
        columns: &mut [[f64; 6]; 6],
    ) -> Motions {
        let mut basis = [[0.0; 6]; 6];
        let mut rank = 0;
        let mut pending = [0.0; 6];
        let mut missed = [0.0; 2];
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
            if rank < D - count && length > 1e-8 * before && length > 0.0 {
                for c in 0..6 {
                    basis[rank][c] = gradient[c] / length;
                    pending[c] -= value / length * gradient[c] / length;
                }
                rank += 1;
                return 0.0;
            }
            value.abs()
        };
        for &index in rows {
            let held = &self.held[index];
            let row = row(held, fraction, state, topology.links[held.node].arm);
            let left = include(row.gradient, row.value);
            let kind = usize::from(matches!(held.kind, HeldKind::Rotation { .. }));
            missed[kind] = f64::max(missed[kind], left);
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
            Idle::Spin(_) | Idle::Spins(_) => {
                for axis in idle.axes() {
                    let a = turn(state.place.rotation, *axis);
                    include([0.0, 0.0, 0.0, a[0], a[1], a[2]], 0.0);
                }
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
        Motions { count: rank - fixed, pending, missed }
    }

    /// Brings bases and pending motions up to date with the state; what joints miss whose components are held each by itself only where
    /// it is `asked` for.
    pub(crate) fn update(&mut self, topology: &Topology, states: &[JointState], fraction: f64, asked: bool) {
        let active: [bool; 6] = std::array::from_fn(|component| self.active.contains(&component));
        for joint in 0..self.joints.len() {
            if let Basis::Components(_) = self.joints[joint].basis {
                // Of joints that nothing holds, none is ever pending.
                if !asked || self.joints[joint].rows.is_empty() {
                    continue;
                }
                self.pending[joint] = self.pending_components(self.rows_of(joint), &states[joint], fraction, &active);
                continue;
            }
            let mut equations = std::mem::replace(
                &mut self.joints[joint],
                JointEquations { first: 0, count: 0, basis: Basis::Components([None; 6]), rows: 0..0 },
            );
            if let Basis::Columns(columns) = &mut equations.basis {
                let (idle, count, state) = (topology.idle[joint], equations.count, &states[joint]);
                let rows = &self.rows[equations.rows.clone()];
                let motions = self.columns(topology, rows, idle, state, fraction, count, columns);
                self.missed[joint] = motions.missed;
                self.pending[joint] = motions.pending;
            }
            self.joints[joint] = equations;
        }
    }

    fn pending_components(&self, rows: &[usize], state: &JointState, fraction: f64, active: &[bool; 6]) -> [f64; 6] {
        let mut pending = [0.0; 6];
        let mut theta = [0.0; 3];
        let mut turned = false;
        for &index in rows {
            let held = &self.held[index];
            let target = held.at(fraction);
            match held.kind {
                HeldKind::Translation { direction } => {
                    for c in 0..3 {
                        if active[c] && direction[c].abs() == 1.0 {
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
                if active[5] {
                    pending[5] = theta[2] - state.place.angle;
                }
            } else {
                // The way there may be longer than half a turn.
                let way = apply(&tangent_map(state.theta), &sub(theta, state.theta));
                let spin = whole_turns(log(compose(exp(theta), inverse(state.place.rotation))), way);
                pending[3..].copy_from_slice(&spin);
            }
        }
        pending
    }

    /// Indices of the rows that hold a joint.
    fn rows_of(&self, joint: usize) -> &[usize] {
        &self.rows[self.joints[joint].rows.clone()]
    }

    /// Whether no row holds a joint.
    pub fn holds_nothing(&self, joint: usize) -> bool {
        self.joints[joint].rows.is_empty()
    }

    /// Whether rows hold all motions of a joint.
    pub(crate) fn holds_all(&self, joint: usize) -> bool {
        self.joints[joint].count == 0
    }

    /// Sets held components to their values exactly.
    pub(crate) fn enforce(&self, states: &mut [JointState], fraction: f64) {
        for (equations, state) in self.joints.iter().zip(states) {
            let Basis::Components(_) = equations.basis else { continue };
            let mut theta = [0.0; 3];
            let mut turned = false;
            for &index in &self.rows[equations.rows.clone()] {
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
    #[inline(always)]
    pub(crate) fn unbalanced(&self, joint: usize, force: &[f64; 6]) -> [f64; 6] {
        let equations = &self.joints[joint];
        match &equations.basis {
            Basis::Components(components) => {
                let mut free = [0.0; 6];
                for &c in &self.active {
                    if components[c].is_some() {
                        free[c] = force[c];
                    }
                }
                free
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
    #[inline]
    pub fn project(&self, joint: usize, force: &[f64; 6], out: &mut [f64]) {
        let equations = &self.joints[joint];
        match &equations.basis {
            Basis::Components(components) => {
                for &c in &self.active {
                    if let Some(e) = components[c] {
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
    #[inline]
    pub fn motion(&self, joint: usize, solution: &[f64], pending: bool) -> [f64; 6] {
        let equations = &self.joints[joint];
        let mut motion = if pending { self.pending[joint] } else { [0.0; 6] };
        match &equations.basis {
            Basis::Components(components) => {
                for &c in &self.active {
                    if let Some(e) = components[c] {
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
    pub(crate) fn find_multipliers(
        &mut self,
        topology: &Topology,
        states: &[JointState],
        forces: &[[f64; 6]],
        fraction: f64,
    ) {
        for (joint, equations) in self.joints.iter().enumerate() {
            match &equations.basis {
                Basis::Components(_) => {
                    for &index in &self.rows[equations.rows.clone()] {
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
                    let rows = &self.rows[equations.rows.clone()];
                    let count = rows.len();
                    // Rows beyond six depend on each other: rare, and worth an allocation.
                    let (mut few, mut many) = ([Gradient::default(); 6], Vec::new());
                    let own = few.get_mut(..count).unwrap_or_else(|| {
                        many.resize(count, Gradient::default());
                        &mut many
                    });
                    for (own, &index) in own.iter_mut().zip(rows) {
                        let held = &self.held[index];
                        let gradient = row(held, fraction, &states[joint], topology.links[held.node].arm).gradient;
                        self.active.iter().for_each(|&c| own.by_motion[c] = gradient[c]);
                    }
                    for (&index, share) in rows.iter().zip(Gradients::of(own).shares(&forces[joint])) {
                        self.multipliers[index] = share;
                    }
                }
            }
        }
    }

    /// The value of a row less its target at the end of the step, and its derivatives by the motion of the joint, where the node
    /// is at this arm from its joint.
    pub(crate) fn row_at(&self, held: &Held, state: &JointState, arm: V3<f64>) -> (f64, [f64; 6]) {
        let mut row = row(held, 1.0, state, arm);
        for (c, slope) in row.gradient.iter_mut().enumerate() {
            if !self.active.contains(&c) {
                *slope = 0.0;
            }
        }
        (row.value, row.gradient)
    }

    /// The smallest motion of a joint by which its rows, by their indices, change so much each and the others not at all. The
    /// same numbers are the weights of the joint's force in the sum of the reactions along rows, each so many times.
    ///
    /// With the gradients of the rows as columns of A, force = A λ and Aᵀ motion = changes: both need the pseudo-inverse of A.
    pub(crate) fn along_rows(
        &self,
        topology: &Topology,
        joint: usize,
        state: &JointState,
        shares: &[(usize, f64)],
    ) -> [f64; 6] {
        let rows = self.rows_of(joint);
        let gradient = |&index: &usize| {
            let held = &self.held[index];
            let (_, by_motion) = self.row_at(held, state, topology.links[held.node].arm);
            Gradient::new(by_motion)
        };
        let mut own: Vec<Gradient> = rows.iter().map(gradient).collect();
        let wanted =
            rows.iter().map(|index| shares.iter().filter(|(own, _)| own == index).map(|&(_, share)| share).sum());
        Gradients::of(&mut own).motion(wanted)
    }

    /// Force on the node, and moment about it, by which a row acts on the structure.
    ///
    /// A row that holds one component of a rotation vector acts about its gradient, which is its axis only while the
    /// rotation is small; where all three are held, their moments are taken along the axes.
    pub(crate) fn reaction(&self, index: usize, topology: &Topology, states: &[JointState]) -> (V3<f64>, V3<f64>) {
        let (held, value) = (&self.held[index], self.multipliers[index]);
        let joint = topology.links[held.node].joint;
        match held.kind {
            HeldKind::Translation { direction } => (scale(value, direction), [0.0; 3]),
            HeldKind::Rotation { axis } if self.is_general(joint) => {
                ([0.0; 3], scale(value, rotation_row(states[joint].theta, axis)))
            }
            HeldKind::Rotation { axis } => ([0.0; 3], scale(value, axis)),
        }
    }

    /// What takes the place of a row that is set free: the reaction, such that the other rows keep theirs.
    pub(crate) fn released(&self, index: usize, topology: &Topology, states: &[JointState]) -> (V3<f64>, V3<f64>) {
        let held = &self.held[index];
        let joint = topology.links[held.node].joint;
        let HeldKind::Rotation { axis } = held.kind else { return self.reaction(index, topology, states) };
        let theta = states[joint].theta;
        // Where the rotation is a whole turn, components of the rotation vector say little about the rotation.
        if self.is_general(joint) || D == 3 || (0.5 * norm(theta)).sin().abs() < 1e-3 && norm(theta) > 1.0 {
            return self.reaction(index, topology, states);
        }
        let mut moment = [0.0; 3];
        for &other in self.rows_of(joint) {
            moment = add(moment, self.reaction(other, topology, states).1);
        }
        // M = Σ λ T⁻ᵀ axis, so λ = T axis · M.
        let along = apply(&tangent_map(theta), &axis);
        ([0.0; 3], scale(dot(along, moment), rotation_row(theta, axis)))
    }

    /// Stiffness that the curvature of the constraints takes from a joint with general rows: −Σ λ ∇²g on its spins.
    pub(crate) fn constraint_stiffness(
        &self,
        topology: &Topology,
        joint: usize,
        state: &JointState,
        fraction: f64,
    ) -> M3<f64> {
        let mut stiffness = zeros();
        for &index in self.rows_of(joint) {
            let held = &self.held[index];
            let row = row(held, fraction, state, topology.links[held.node].arm);
            for i in 0..3 {
                for j in 0..3 {
                    stiffness[i][j] -= self.multipliers[index] * row.hessian[i][j];
                }
            }
        }
        stiffness
    }

    /// Whether a rotation of a joint is held.
    pub(crate) fn holds_a_rotation(&self, joint: usize) -> bool {
        self.rows_of(joint).iter().any(|&index| matches!(self.held[index].kind, HeldKind::Rotation { .. }))
    }

    /// Whether the free motions of a joint are no components of their own.
    pub fn is_general(&self, joint: usize) -> bool {
        matches!(self.joints[joint].basis, Basis::Columns(_))
    }

    /// Whether there is such a joint.
    pub fn has_general(&self) -> bool {
        (0..self.joints.len()).any(|j| self.is_general(j))
    }
}

/// Scalar product of a motion and an action on it.
pub fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
