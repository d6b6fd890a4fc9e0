//! What the arithmetic leaves of an equilibrium: how far rounding may move it, estimated from the factors in hand.
//!
//! Rounding shows in two ways. What is left of the residual when the iteration ends is the part that is seen. The part
//! that is not seen lies in the forces themselves: an element knows the place of its end against that of its start to a
//! unit in the last place of its length, of its displacement and of a turn, and its forces to a unit of their own. Both
//! are brought to the joints, those unseen with signs drawn by lot, and one back-substitution tells what they move:
//! the backward error of the elements times the condition of the structure, as in Higham, Accuracy and Stability of
//! Numerical Algorithms (2002), sections 7.1 and 7.7, without the bound over all signs.
//!
//! Theory: docs/theory/rounding.md, Eq. 10.1 to 10.3.

use pennate_elements::beam::Ends;
use pennate_elements::rotation::{log, turn};
use pennate_elements::small::{V3, add, cross, norm, scale, sub};

use crate::history::Rounding;
use crate::joints::Link;
use crate::reduce;
use crate::structure::{MemberId, NodeId};
use crate::system::System;

/// A unit in the last place of one.
const UNIT: f64 = f64::EPSILON;
/// Part of what displacements (rotations, forces, moments) suggest below which the largest rotation (displacement,
/// moment, force) is itself rounding, and no digits of it are counted.
const IDLE: f64 = 1e-6;
/// The same where less than a digit would be left.
const MINOR: f64 = 1e-3;
/// The same for displacements over the size of the network and for rotations, whatever else there is, and for forces over
/// those of rounding alone: a network that was brought back to where it was, and one that nothing loads.
const NOTHING: f64 = 1e-9;
const RESTING: f64 = 10.0;
/// A direction is no nearer to an axis than that where its cosine is less.
const OBLIQUE: f64 = 0.9;
/// What an iteration leaves is nothing below this part of displacements and rotations, or below so many times what
/// rounding moves.
const SETTLED: f64 = 1e-12;
const MUCH: f64 = 10.0;

/// Signs without a pattern, the same in every run.
struct Lots(u64);

impl Lots {
    /// One with either sign: the generator of Steele, Lea and Flood (2014).
    fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
    }

    fn draw_three(&mut self, size: f64) -> V3<f64> {
        std::array::from_fn(|_| size * self.draw())
    }

    /// The same in axes of which one is the unit vector `along`: a member is far stiffer there than across, and components in other
    /// axes might draw what cancels just there.
    fn draw_along(&mut self, size: f64, along: V3<f64>) -> V3<f64> {
        let aside = if along[2].abs() < OBLIQUE { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let across = cross(aside, along);
        let across = scale(1.0 / norm(across), across);
        let [a, b, c] = self.draw_three(size);
        add(scale(a, along), add(scale(b, across), scale(c, cross(along, across))))
    }
}

/// What rounding does to an equilibrium, and what the iteration left of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub rounding: Rounding,
    /// Largest rotation (or displacement over the size of the network) that another iteration would make.
    pub left: f64,
    /// Whether that is nothing against what there is, or against rounding.
    pub settled: bool,
}

/// Estimates what rounding moves at the state of the last assembly; `None` where a motion needs no force at all.
pub(crate) fn estimate<const D: usize>(system: &mut System<D>) -> Option<Estimate> {
    // Where loads have no potential, pivots are those of a part of the tangent, and the whole may be regular.
    if system.tangent.inertia().neutral > 0 && system.tangent.has_potential() {
        return None;
    }
    let mut lots = Lots(0);
    let mut joints = vec![[0.0; 6]; system.tangent.forces.len()];
    let mut members = Vec::with_capacity(system.members.count());
    for index in 0..system.members.count() {
        let force = disturbed(system, index, &mut lots);
        for (end, joint) in joints_of(system, index).into_iter().enumerate() {
            for (i, &component) in system.pattern.equations.active.iter().enumerate() {
                joints[joint][component] += force[end * D + i];
            }
        }
        members.push(force);
    }
    for index in 0..system.structure.springs.len() {
        disturb_spring(system, index, &mut lots, &mut joints);
    }
    let mut noise = vec![0.0; system.tangent.rhs.len()];
    for (joint, force) in joints.iter().enumerate() {
        system.pattern.equations.project(joint, force, &mut noise);
    }
    let mut left = system.tangent.rhs.clone();
    if !system.tangent.solve(&mut noise) || !system.tangent.solve(&mut left) {
        return None;
    }
    let [mut motions, left] = [noise, left].map(|solution| system.pattern.motions_of(&solution));
    if !motions.iter().chain(&left).flatten().all(|motion| motion.is_finite()) {
        return None;
    }
    let [moved, remaining] = [&motions, &left].map(|motions| size_of(motions, system.size));
    for (sum, left) in motions.iter_mut().zip(&left) {
        *sum = std::array::from_fn(|c| -(sum[c] + left[c]));
    }
    let mut largest = Largest::default();
    let mut units = Vec::with_capacity(system.topology.links.len());
    for (node, link) in system.topology.links.iter().enumerate() {
        let joint = &system.places.joints[link.joint];
        let moved = system.places.motion_of(link, &motions);
        let angle = if D == 3 { joint.place.angle.abs() } else { norm(log(joint.place.rotation)) };
        let far = norm(joint.point(link.arm));
        largest.take(0, far, norm([moved[0], moved[1], moved[2]]), node);
        largest.take(1, angle, norm([moved[3], moved[4], moved[5]]), node);
        units.push([UNIT * far, UNIT * angle]);
    }
    for (index, force) in members.iter().enumerate() {
        let shaken = shaken(system, index, &units, &mut lots);
        take_member(system, index, force, &motions, &shaken, &mut largest);
    }
    let there = (largest.values[0] / system.size).max(largest.values[1]);
    let settled = remaining <= SETTLED * there || remaining <= MUCH * moved;
    Some(Estimate { rounding: largest.relative(system.size, system.loading.rounding()), left: remaining, settled })
}

/// The largest residual, over the scale of its kind, that rounding alone makes of an equilibrium.
///
/// Places that are kept to a unit of their own leave no less between stiff members.
pub(crate) fn floor<const D: usize>(system: &mut System<D>) -> f64 {
    let mut lots = Lots(0);
    let unit = |link: &Link| {
        let joint = &system.places.joints[link.joint];
        [norm(joint.point(link.arm)), norm(log(joint.place.rotation))].map(|size| UNIT * size)
    };
    let units: Vec<[f64; 2]> = system.topology.links.iter().map(unit).collect();
    let mut joints = vec![[0.0; 6]; system.tangent.forces.len()];
    for index in 0..system.members.count() {
        let force = disturbed(system, index, &mut lots);
        let shaken = resisted(system, index, &shaken(system, index, &units, &mut lots));
        for (end, joint) in joints_of(system, index).into_iter().enumerate() {
            for (i, &component) in system.pattern.equations.active.iter().enumerate() {
                joints[joint][component] += (force[end * D + i] + shaken[end * D + i]).abs();
            }
        }
    }
    std::mem::swap(&mut system.tangent.forces, &mut joints);
    let residual = system.residual().largest();
    std::mem::swap(&mut system.tangent.forces, &mut joints);
    residual
}

/// The largest of some motions: rotation, or displacement over a length.
fn size_of(motions: &[[f64; 6]], length: f64) -> f64 {
    let of = |m: &[f64; 6]| (norm([m[0], m[1], m[2]]) / length).max(norm([m[3], m[4], m[5]]));
    motions.iter().map(of).fold(0.0, f64::max)
}

fn joints_of<const D: usize>(system: &System<D>, index: MemberId) -> [usize; 2] {
    system.structure.members[index].nodes.map(|node| system.topology.links[node].joint)
}

/// The forces that rounding makes in a member, brought to its joints.
fn disturbed<const D: usize>(system: &System<D>, index: MemberId, lots: &mut Lots) -> [f64; 12] {
    let member = &system.structure.members[index];
    let slot = &system.members.slots[index];
    let pack = &system.members.packs[slot.pack];
    let length: f64 = member.segments.iter().map(|segment| segment.length).sum();
    let arms: f64 = member.nodes.iter().map(|&node| norm(system.topology.links[node].arm)).sum();
    let turned = [0, pack.mesh().elements()].map(|end| norm(log(pack.node(slot.lane, end).rotation)));
    let turned = UNIT * turned[0].max(turned[1]).min(1.0);
    // Errors of elements in a row add up like steps of either sign.
    let steps = (pack.mesh().elements() as f64).sqrt();
    let moves = lots.draw_along(turned * (steps * length + arms), direction(system, index));
    let turns = lots.draw_three(turned * steps);
    let shift = [moves[0], moves[1], moves[2], turns[0], turns[1], turns[2]];
    let condensed: Ends<f64, D> = pack.condensed(slot.lane);
    let active = system.pattern.equations.active;
    let mut ends = Ends { r0: [0.0; D], r1: [0.0; D], ..condensed };
    for i in 0..D {
        for (j, &component) in active.iter().enumerate() {
            ends.r0[i] += condensed.k01[i][j] * shift[component];
            ends.r1[i] += condensed.k11[i][j] * shift[component];
        }
    }
    for (end, target) in [&mut ends.r0, &mut ends.r1].into_iter().enumerate() {
        let f = system.tangent.ends[index][end];
        let (force, moment) = (norm([f[0], f[1], f[2]]), norm([f[3], f[4], f[5]]));
        for (i, &component) in active.iter().enumerate() {
            let size = if component < 3 { force } else { moment + force * length };
            target[i] += UNIT * size * lots.draw();
        }
    }
    let info = system.end_info(index, &system.tangent.ends[index]);
    reduce::reduce(&ends, &active, &info, Some(&mut system.tangent.releases[index].clone())).force
}

/// Adds the forces that rounding makes in a spring to its joints.
fn disturb_spring<const D: usize>(system: &System<D>, index: usize, lots: &mut Lots, joints: &mut [[f64; 6]]) {
    let spring = &system.structure.springs[index];
    let mut draw = || UNIT * lots.draw();
    let forces = spring.rounded(&system.placed(index), system.tangent.spring_forces[index], &mut draw);
    for (&node, [force, moment]) in spring.nodes().iter().zip(forces) {
        let link = &system.topology.links[node];
        let lever = turn(system.places.joints[link.joint].place.rotation, link.arm);
        let moment = add(moment, cross(lever, force));
        for c in 0..3 {
            joints[link.joint][c] += force[c];
            joints[link.joint][3 + c] += moment[c];
        }
    }
}

/// The axis of a member at its end.
fn direction<const D: usize>(system: &System<D>, index: MemberId) -> V3<f64> {
    let (pack, lane) = system.members.chain(index);
    let end = pack.node(lane, pack.mesh().elements());
    turn(end.rotation, system.members.slots[index].tangents[1])
}

/// What places that are kept to units of their own may move the ends of a member against one another by; `units` are those of the
/// displacement and the rotation of every node.
///
/// Of two ends that are displaced by as much, equal signs would cancel, and leave nothing of a stretch. So the last end is moved
/// by the units of both.
fn shaken<const D: usize>(system: &System<D>, index: MemberId, units: &[[f64; 2]], lots: &mut Lots) -> [[f64; 6]; 2] {
    let [first, last] = system.structure.members[index].nodes.map(|node| units[node]);
    let shift = lots.draw_along(first[0].hypot(last[0]), direction(system, index));
    let spins = [first[1], last[1]].map(|size| lots.draw_three(size));
    [[[0.0; 3], spins[0]], [shift, spins[1]]].map(|[u, spin]| [u[0], u[1], u[2], spin[0], spin[1], spin[2]])
}

/// The forces with which a member answers a motion of its joints.
fn resisted<const D: usize>(system: &System<D>, index: MemberId, motions: &[[f64; 6]; 2]) -> [f64; 12] {
    let (pack, lane) = system.members.chain(index);
    let condensed: Ends<f64, D> = pack.condensed(lane);
    let active = system.pattern.equations.active;
    let info = system.end_info(index, &system.tangent.ends[index]);
    let stiffness =
        reduce::reduce(&condensed, &active, &info, Some(&mut system.tangent.releases[index].clone())).stiffness;
    let mut force = [0.0; 12];
    for row in 0..2 * D {
        for (end, motion) in motions.iter().enumerate() {
            for (j, &component) in active.iter().enumerate() {
                force[row] += stiffness[row][end * D + j] * motion[component];
            }
        }
    }
    force
}

/// Takes the forces of a member's ends: what they are, and how far the motions of its joints move them.
///
/// Places are kept to a unit of their own, which moves the ends by `shaken`: no place farther, but forces by the stiffness
/// between them.
fn take_member<const D: usize>(
    system: &System<D>,
    index: MemberId,
    force: &[f64; 12],
    motions: &[[f64; 6]],
    shaken: &[[f64; 6]; 2],
    largest: &mut Largest,
) {
    let nodes = system.structure.members[index].nodes;
    let moved = [0, 1].map(|end| add(motions[system.topology.links[nodes[end]].joint], shaken[end]));
    let answer = resisted(system, index, &moved);
    let active = system.pattern.equations.active;
    let info = system.end_info(index, &system.tangent.ends[index]);
    for (end, info) in info.iter().enumerate() {
        let mut change = [0.0; 6];
        for (i, &component) in active.iter().enumerate() {
            change[component] = force[end * D + i] + answer[end * D + i];
        }
        let pull = [change[0], change[1], change[2]];
        // About the end of the member, not the reference of its body.
        let moment = sub([change[3], change[4], change[5]], cross(info.lever, pull));
        largest.take(2, norm(info.force), norm(pull), nodes[end]);
        largest.take(3, norm(info.moment), norm(moment), nodes[end]);
    }
}

/// Largest displacement, rotation, force and moment, and how far rounding moves any of their kind.
#[derive(Default)]
struct Largest {
    values: [f64; 4],
    errors: [f64; 4],
    nodes: [NodeId; 4],
}

impl Largest {
    fn take(&mut self, kind: usize, value: f64, error: f64, node: NodeId) {
        self.values[kind] = self.values[kind].max(value);
        if error > self.errors[kind] {
            self.errors[kind] = error;
            self.nodes[kind] = node;
        }
    }

    /// Errors over values, in a network of this size whose stiffness makes this force of rounding alone.
    fn relative(&self, size: f64, force: f64) -> Rounding {
        let [u, theta, pull, moment] = self.values;
        let suggested = [theta * size, u / size, moment / size, pull * size];
        let nothing = [NOTHING * size, NOTHING, RESTING * force, RESTING * force * size];
        let of = |kind: usize| {
            let (value, error) = (self.values[kind], self.errors[kind]);
            let small = value <= nothing[kind].max(MINOR * suggested[kind]) && error > 0.1 * value;
            let counts = value > IDLE * suggested[kind] && !small && value > 0.0;
            counts.then(|| (error / value).max(UNIT))
        };
        Rounding { errors: std::array::from_fn(of), nodes: self.nodes }
    }
}
