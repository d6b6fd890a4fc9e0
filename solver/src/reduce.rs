//! From the ends of a member to its joints: released rotations eliminated, levers of rigid bodies applied.
//!
//! Theory: docs/theory/joints.md, Eq. 5.1 to 5.4.

use pennate_elements::beam::{Ends, Placement};
use pennate_elements::rotation::{self, Quaternion, second_variation, tangent_map, tangent_slope, turn};
use pennate_elements::small::{V3, add, apply, cross, dot, norm, scale, sub};

use crate::joints::{Active, EndKind};
use crate::linear::PIVOT_NOISE;

/// Rotation of a released end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReleaseState {
    /// Rotation of the member's end, and its angle about z with whole turns.
    pub rotation: Quaternion<f64>,
    pub angle: f64,
    /// Turns about the free axes.
    pub turns: [f64; 2],
}

impl Default for ReleaseState {
    fn default() -> Self {
        Self { rotation: rotation::IDENTITY, angle: 0.0, turns: [0.0; 2] }
    }
}

/// One end of a member as the reduction sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End<'a> {
    pub kind: &'a EndKind,
    pub release: &'a ReleaseState,
    /// Rotation of the joint, and the lever from its reference to the node, turned.
    pub joint_rotation: Quaternion<f64>,
    pub lever: V3<f64>,
    /// Unloaded tangent of the member at this end.
    pub tangent: V3<f64>,
    /// Force and moment on the end, all components.
    pub force: V3<f64>,
    pub moment: V3<f64>,
}

pub(crate) const MAX_FREE: usize = 6;
/// A turn by a radian that the active components see less of than this (radians) is none of theirs: in the plane, of an axis in it, they see
/// what rounding turned it out of there.
const SEEN: f64 = 1e-9;

/// Factors of the released rotations of a member.
#[derive(Clone, Copy, Debug)]
pub struct ReleaseFactor {
    /// Number of free rotations of the start and of both ends.
    counts: [usize; 2],
    /// Spins of the end, or added to the joint's, that belong to the free rotations.
    spins: [V3<f64>; MAX_FREE],
    solved: [[f64; 12]; MAX_FREE],
    rest: [f64; MAX_FREE],
}

impl ReleaseFactor {
    /// Forgets what is left to turn: the forces on the ends are those after it.
    pub(crate) fn settle(&mut self) {
        self.rest = [0.0; MAX_FREE];
    }
}

impl Default for ReleaseFactor {
    fn default() -> Self {
        Self { counts: [0; 2], spins: [[0.0; 3]; MAX_FREE], solved: [[0.0; 12]; MAX_FREE], rest: [0.0; MAX_FREE] }
    }
}

/// Stiffness and force of a member in the components of its joints: those of the start, then those of the end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reduced {
    pub stiffness: [[f64; 12]; 12],
    pub force: [f64; 12],
    pub negative: usize,
    pub neutral: usize,
}

/// Reduces the ends of a member to its joints in D active components an end; one that is released needs a factor.
pub(crate) fn reduce<const D: usize>(
    ends: &Ends<f64, D>,
    active: &Active<D>,
    info: &[End<'_>; 2],
    factor: Option<&mut ReleaseFactor>,
) -> Reduced {
    // Filled where it stays: a copy costs as much.
    let mut reduced = Reduced { stiffness: [[0.0; 12]; 12], force: [0.0; 12], negative: 0, neutral: 0 };
    let k = &mut reduced.stiffness;
    for i in 0..D {
        for j in 0..D {
            k[i][j] = ends.k00[i][j];
            k[i][D + j] = ends.k01[i][j];
            k[D + j][i] = ends.k01[i][j];
            k[D + i][D + j] = ends.k11[i][j];
        }
        reduced.force[i] = ends.r0[i];
        reduced.force[D + i] = ends.r1[i];
    }
    if let Some(factor) = factor
        && info.iter().any(|end| *end.kind != EndKind::Welded)
    {
        eliminate_releases(&mut reduced, active, info, factor);
    }
    for (end, info) in info.iter().enumerate() {
        if info.lever != [0.0; 3] {
            apply_lever(&mut reduced, active, end, info);
        }
    }
    reduced
}

/// Component of a vector of spins in the active components, or nothing where the component is no rotation.
fn spin_component(component: usize, spin: V3<f64>) -> Option<f64> {
    (component >= 3).then(|| spin[component - 3])
}

/// Free spins of a released end, and their number.
pub(crate) fn free_spins<const D: usize>(active: &Active<D>, end: &End<'_>, spins: &mut [V3<f64>]) -> usize {
    let mut count = 0;
    match end.kind {
        EndKind::Welded => {}
        EndKind::Free { spin_removed } => {
            let tangent = turn(end.release.rotation, end.tangent);
            let mut found: [V3<f64>; 3] = [[0.0; 3]; 3];
            for &component in active.iter().filter(|&&c| c >= 3) {
                let mut spin = [0.0; 3];
                spin[component - 3] = 1.0;
                if *spin_removed {
                    spin = sub(spin, scale(dot(spin, tangent), tangent));
                }
                for other in &found[..count] {
                    spin = sub(spin, scale(dot(spin, *other), *other));
                }
                // What the removal of the spin leaves of the third axis is rounding.
                if norm(spin) > 1e-2 {
                    found[count] = scale(1.0 / norm(spin), spin);
                    count += 1;
                }
            }
            if *spin_removed && active.contains(&5) && active.len() == 6 {
                count = count.min(2);
            }
            spins[..count].copy_from_slice(&found[..count]);
        }
        EndKind::Axes { axes, kept } => {
            let turned = axes_rotation_vector(axes, end.release);
            let map = tangent_map(turned);
            for (_, axis) in free_axes(axes, *kept) {
                let spin = turn(end.joint_rotation, apply(&map, axis));
                let seen: f64 = active.iter().filter_map(|&c| spin_component(c, spin)).map(|x| x * x).sum();
                if seen.sqrt() > SEEN {
                    spins[count] = spin;
                    count += 1;
                }
            }
        }
    }
    count
}

/// The spin that a released end is kept from, for no force belongs to it: a unit vector where the end is free, else the axis as it is
/// turned by the other one.
pub(crate) fn kept_spin(end: &End<'_>) -> Option<V3<f64>> {
    match end.kind {
        EndKind::Free { spin_removed: true } => Some(turn(end.release.rotation, end.tangent)),
        EndKind::Axes { axes, kept: Some(kept) } => {
            let map = tangent_map(axes_rotation_vector(axes, end.release));
            Some(turn(end.joint_rotation, apply(&map, &axes[*kept])))
        }
        _ => None,
    }
}

impl ReleaseState {
    /// Turns the end about its free axes, from a joint of this rotation and angle.
    pub(crate) fn turn_from(&mut self, axes: &[V3<f64>], (rotation, angle): (Quaternion<f64>, f64)) {
        let turned = axes_rotation_vector(axes, self);
        self.rotation = rotation::compose(rotation, rotation::exp(turned));
        self.angle = angle + turned[2];
    }
}

/// Axes about which an end turns, and which of all its axes they are.
fn free_axes(axes: &[V3<f64>], kept: Option<usize>) -> impl DoubleEndedIterator<Item = (usize, &V3<f64>)> {
    axes.iter().enumerate().filter(move |(index, _)| Some(*index) != kept)
}

fn axes_rotation_vector(axes: &[V3<f64>], release: &ReleaseState) -> V3<f64> {
    axes.iter().zip(release.turns).fold([0.0; 3], |sum, (axis, by)| add(sum, scale(by, *axis)))
}

fn eliminate_releases<const D: usize>(
    reduced: &mut Reduced,
    active: &Active<D>,
    info: &[End<'_>; 2],
    factor: &mut ReleaseFactor,
) {
    let n = 2 * D;
    let first = free_spins(active, &info[0], &mut factor.spins[..3]);
    let second = free_spins(active, &info[1], &mut factor.spins[first..]);
    factor.counts = [first, second];
    let count = first + second;
    let end_of = |a: usize| usize::from(a >= first);

    let k = &mut reduced.stiffness;
    let force = &mut reduced.force;
    let before: [f64; 12] = std::array::from_fn(|i| k[i][i].abs());
    let mut coupling = [[0.0; 12]; MAX_FREE];
    let mut own = [[0.0; MAX_FREE]; MAX_FREE];
    for a in 0..count {
        let offset = end_of(a) * D;
        factor.rest[a] = 0.0;
        for (i, &component) in active.iter().enumerate() {
            if let Some(s) = spin_component(component, factor.spins[a]) {
                factor.rest[a] += s * force[offset + i];
                for j in 0..n {
                    coupling[a][j] += s * k[offset + i][j];
                }
            }
        }
    }
    for a in 0..count {
        for b in 0..count {
            let offset = end_of(b) * D;
            for (i, &component) in active.iter().enumerate() {
                if let Some(s) = spin_component(component, factor.spins[b]) {
                    own[a][b] += s * coupling[a][offset + i];
                }
            }
        }
    }
    // Second variation of exp(φ) R exp(α): ½ α a × m against the joint's spin, and of two axes against each other.
    for a in 0..count {
        let end = &info[end_of(a)];
        if !matches!(end.kind, EndKind::Axes { .. }) {
            continue;
        }
        let offset = end_of(a) * D;
        let twist = scale(0.5, cross(factor.spins[a], end.moment));
        for (i, &component) in active.iter().enumerate() {
            if let Some(t) = spin_component(component, twist) {
                coupling[a][offset + i] += t;
            }
        }
        let base = if end_of(a) == 0 { 0 } else { first };
        let free = factor.counts[end_of(a)];
        for b in base..base + free {
            own[a][b] += axes_curvature(end, free, [a - base, b - base]);
        }
    }
    for (end, info) in info.iter().enumerate() {
        if let EndKind::Free { .. } = info.kind {
            for (i, &component) in active.iter().enumerate() {
                if component >= 3 {
                    let row = end * D + i;
                    force[row] = 0.0;
                    for j in 0..n {
                        k[row][j] = 0.0;
                        k[j][row] = 0.0;
                    }
                    coupling.iter_mut().for_each(|c| c[row] = 0.0);
                }
            }
        }
    }
    factor.solved = coupling;
    let (negative, neutral) = solve_small(&mut own, count, n, &mut factor.solved, &mut factor.rest);
    reduced.negative += negative;
    reduced.neutral += neutral;
    for a in 0..count {
        for i in 0..n {
            force[i] -= coupling[a][i] * factor.rest[a];
            for j in 0..n {
                k[i][j] -= coupling[a][i] * factor.solved[a][j];
            }
        }
    }
    // A hinge about a global axis leaves nothing of the stiffness about it but rounding, which would pass for a small one.
    for i in 0..n {
        if k[i][i].abs() <= PIVOT_NOISE * before[i] {
            k[i] = [0.0; 12];
            k.iter_mut().for_each(|row| row[i] = 0.0);
        }
    }
}

/// Second variation of the end's rotation in two of its free turns, about axes of one rotation vector, against the moment.
pub(crate) fn axes_curvature(end: &End<'_>, free: usize, turns: [usize; 2]) -> f64 {
    // A single axis turns the same however far it has turned.
    let EndKind::Axes { axes, kept } = end.kind else { return 0.0 };
    if axes.len() < 2 {
        return 0.0;
    }
    let at = axes_rotation_vector(axes, end.release);
    // Axes without a turn of their own, in the plane, come first.
    let axis = |turn: usize| free_axes(axes, *kept).rev().nth(free - 1 - turn).map_or([0.0; 3], |(_, axis)| *axis);
    let [a, b] = turns.map(axis);
    let sum = add(tangent_slope(at, a, b), tangent_slope(at, b, a));
    0.5 * dot(end.moment, turn(end.joint_rotation, sum))
}

/// L D Lᵀ without pivoting of the leading `count` rows; a pivot at noise level leaves its unknown at zero.
fn solve_small(
    own: &mut [[f64; MAX_FREE]; MAX_FREE],
    count: usize,
    columns: usize,
    rhs: &mut [[f64; 12]; MAX_FREE],
    rest: &mut [f64; MAX_FREE],
) -> (usize, usize) {
    let original: [f64; MAX_FREE] = std::array::from_fn(|i| own[i][i]);
    let (mut negative, mut neutral) = (0, 0);
    let mut inverse = [0.0; MAX_FREE];
    for j in 0..count {
        let pivot = own[j][j];
        if pivot.abs() <= PIVOT_NOISE * original[j].abs() || !pivot.is_finite() {
            neutral += 1;
        } else {
            negative += usize::from(pivot < 0.0);
            inverse[j] = 1.0 / pivot;
        }
        for i in j + 1..count {
            let f = own[i][j] * inverse[j];
            for l in j + 1..count {
                own[i][l] -= f * own[j][l];
            }
            for c in 0..columns {
                rhs[i][c] -= f * rhs[j][c];
            }
            rest[i] -= f * rest[j];
            own[i][j] = f;
        }
    }
    for j in (0..count).rev() {
        for c in 0..columns {
            rhs[j][c] *= inverse[j];
        }
        rest[j] *= inverse[j];
        for i in j + 1..count {
            let f = own[i][j];
            for c in 0..columns {
                rhs[j][c] -= f * rhs[i][c];
            }
            rest[j] -= f * rest[i];
        }
    }
    (negative, neutral)
}

/// The stiffness of a member with a welded end at a lever from its joint, on which the mixed stresses make this force: what
/// [`apply_lever`] makes of all of it, block by block.
#[inline(always)]
pub(crate) fn carry<const D: usize>(
    ends: &mut Ends<f64, D>,
    active: &Active<D>,
    end: usize,
    lever: V3<f64>,
    force: &[f64; D],
) {
    let own = if end == 0 { &mut ends.k00 } else { &mut ends.k11 };
    own.iter_mut().for_each(|row| carry_columns(active, lever, row));
    carry_rows(active, lever, own);
    let mut pull = [0.0; 3];
    for (component, force) in active.iter().zip(force).filter(|(component, _)| **component < 3) {
        pull[*component] = *force;
    }
    add_swing(active, [pull, lever], own, 0);
    // Rows are those of the start, columns those of the end.
    if end == 0 {
        carry_rows(active, lever, &mut ends.k01);
    } else {
        ends.k01.iter_mut().for_each(|row| carry_columns(active, lever, row));
    }
}

/// Force and moment of a welded end, as its joint at the other end of a lever feels them: u = u_joint + φ × lever, so that a force f on
/// the end has the moment lever × f about the joint.
#[inline(always)]
pub(crate) fn on_joint<const D: usize>(active: &Active<D>, lever: V3<f64>, mut force: [f64; D]) -> [f64; D] {
    if D == 6 {
        let [x, y, z] = lever;
        force[3] += y * force[2] - z * force[1];
        force[4] += z * force[0] - x * force[2];
        force[5] += x * force[1] - y * force[0];
    } else if lever != [0.0; 3] {
        let mut full = [0.0; 6];
        for (&component, force) in active.iter().zip(force) {
            full[component] = force;
        }
        let moment = cross(lever, [full[0], full[1], full[2]]);
        for (&component, force) in active.iter().zip(&mut force).filter(|(component, _)| **component >= 3) {
            *force += moment[component - 3];
        }
    }
    force
}

/// The same for every column of the rows of an end.
#[inline(always)]
fn carry_rows<const D: usize, const N: usize>(active: &Active<D>, lever: V3<f64>, rows: &mut [[f64; N]; D]) {
    for column in 0..N {
        let carried = on_joint(active, lever, std::array::from_fn(|row| rows[row][column]));
        for row in 0..D {
            rows[row][column] = carried[row];
        }
    }
}

/// The same for the columns of an end in one row.
#[inline(always)]
fn carry_columns<const D: usize>(active: &Active<D>, lever: V3<f64>, row: &mut [f64; D]) {
    *row = on_joint(active, lever, *row);
}

/// Adds what a force on the end of a lever resists turning by to the rows of its end, whose own columns begin at `first`.
#[inline(always)]
fn add_swing<const D: usize, const N: usize>(
    active: &Active<D>,
    [force, lever]: [V3<f64>; 2],
    rows: &mut [[f64; N]; D],
    first: usize,
) {
    let swing = second_variation(force, lever);
    for (i, &row) in active.iter().enumerate().filter(|(_, row)| **row >= 3) {
        for (j, &column) in active.iter().enumerate().filter(|(_, column)| **column >= 3) {
            rows[i][first + j] += swing[row - 3][column - 3];
        }
    }
}

/// What belongs to one end, of what belongs to both.
fn of_end<V, const D: usize>(both: &mut [V; 12], offset: usize) -> &mut [V; D] {
    both[offset..].first_chunk_mut().expect("two ends have no more than twelve components")
}

pub(crate) fn apply_lever<const D: usize>(reduced: &mut Reduced, active: &Active<D>, end: usize, info: &End<'_>) {
    let n = 2 * D;
    let offset = end * D;
    let k = &mut reduced.stiffness;
    for row in &mut k[..n] {
        carry_columns(active, info.lever, of_end(row, offset));
    }
    let rows: &mut [[f64; 12]; D] = of_end(k, offset);
    carry_rows(active, info.lever, rows);
    add_swing(active, [info.force, info.lever], rows, offset);
    carry_columns(active, info.lever, of_end(&mut reduced.force, offset));
}

/// Moves of the free rotations of a member, and of its ends, for moves of its nodes (all six components).
pub(crate) fn recover<const D: usize>(
    active: &Active<D>,
    info: [&EndKind; 2],
    factor: &ReleaseFactor,
    nodes: &[[f64; 6]; 2],
) -> ([[f64; D]; 2], [f64; MAX_FREE]) {
    let mut ends = [[0.0; D]; 2];
    for (end, node) in ends.iter_mut().zip(nodes) {
        for i in 0..D {
            end[i] = node[active[i]];
        }
    }
    let mut moves = [0.0; MAX_FREE];
    let count = factor.counts[0] + factor.counts[1];
    for a in 0..count {
        let mut x = -factor.rest[a];
        for (e, node) in nodes.iter().enumerate() {
            for (i, &component) in active.iter().enumerate() {
                x -= factor.solved[a][e * D + i] * node[component];
            }
        }
        moves[a] = x;
    }
    for (e, kind) in info.into_iter().enumerate() {
        if *kind == EndKind::Welded {
            continue;
        }
        let base = if e == 0 { 0 } else { factor.counts[0] };
        for (i, &component) in active.iter().enumerate() {
            if component < 3 {
                continue;
            }
            if let EndKind::Free { .. } = kind {
                ends[e][i] = 0.0;
            }
            for a in base..base + factor.counts[e] {
                ends[e][i] += factor.spins[a][component - 3] * moves[a];
            }
        }
    }
    (ends, moves)
}

/// Moves the rotation of a released end: `joint` is the joint's rotation after its own move.
pub(crate) fn move_release(
    kind: &EndKind,
    end: usize,
    factor: &ReleaseFactor,
    moves: &[f64; MAX_FREE],
    joint: (Quaternion<f64>, f64),
    state: &mut ReleaseState,
) {
    let base = if end == 0 { 0 } else { factor.counts[0] };
    let range = base..base + factor.counts[end];
    match kind {
        EndKind::Welded => (state.rotation, state.angle) = joint,
        EndKind::Free { .. } => {
            let spin = range.fold([0.0; 3], |sum, a| add(sum, scale(moves[a], factor.spins[a])));
            state.rotation = rotation::normalize(rotation::compose(rotation::exp(spin), state.rotation));
            state.angle += spin[2];
        }
        EndKind::Axes { axes, kept } => {
            // In the plane axes in it have no move of their own: those that have come last.
            for ((index, _), a) in free_axes(axes, *kept).rev().zip(range.rev()) {
                state.turns[index] += moves[a];
            }
            state.turn_from(axes, joint);
        }
    }
}

/// The rotations of an end by so many times what led from one to the next, and by what is said to be added of an earlier one:
/// free ends on their own, ends with axes as their joint turned.
pub(crate) fn extrapolate_release(
    kind: &EndKind,
    [before, last]: [ReleaseState; 2],
    ratio: f64,
    bend: Option<(ReleaseState, f64)>,
    joint: &Placement,
) -> ReleaseState {
    let between = |a: &ReleaseState, b: &ReleaseState| {
        rotation::log(rotation::compose(b.rotation, rotation::inverse(a.rotation)))
    };
    let mut spin = scale(ratio, between(&before, &last));
    let mut turns: [f64; 2] = std::array::from_fn(|t| ratio * (last.turns[t] - before.turns[t]));
    let mut angle = ratio * (last.angle - before.angle);
    if let Some((earlier, times)) = bend {
        spin = add(spin, scale(times, between(&earlier, &before)));
        turns = std::array::from_fn(|t| turns[t] + times * (before.turns[t] - earlier.turns[t]));
        angle += times * (before.angle - earlier.angle);
    }
    let mut after = last;
    for t in 0..2 {
        after.turns[t] += turns[t];
    }
    if let EndKind::Axes { axes, .. } = kind {
        after.turn_from(axes, (joint.rotation, joint.angle));
    } else {
        after.rotation = rotation::compose(rotation::exp(spin), last.rotation);
        after.angle += angle;
    }
    after
}
