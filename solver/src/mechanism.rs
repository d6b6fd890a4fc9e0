//! Motions that need no force: the null space of the unloaded stiffness.
//!
//! Iteration finds any basis of it. What is reported are the motions of whole parts as rigid bodies, and beside these motions
//! of as few nodes as elimination leaves.

use pennate_elements::small::{add, axpy, cross, dot, norm, scale, sub};

use crate::error::{Extent, FreeMotion, NearMotion, Place};
use crate::joints::Idle;
use crate::structure::{NodeId, Spring};
use crate::system::System;

/// Stiffness of a motion over that of its components one by one, below which it is free.
const FREE: f64 = 1e-12;
/// The same below which a motion is nearly free: of sixteen digits fewer than seven are left.
pub(crate) const NEAR: f64 = 1e-9;
/// At most so many motions are looked for.
const MANY: usize = 60;
/// Part of a motion outside of the free ones up to which it is one of them.
const OUTSIDE: f64 = 1e-5;
/// Joints of a part about which it is tried to turn.
const CENTRES: usize = 20;

/// Free motions of the system at its last assembly.
pub(crate) fn free_motions<const D: usize>(system: &mut System<D>) -> Vec<FreeMotion> {
    let found = null_space(system);
    let mut motions = released(system);
    motions.extend(readable(system, &found));
    motions
}

/// The free motions, at the last assembly, of single joints about what they hang on: however far they go they move no end of a member
/// and no node of a spring, so that no prestress resists them.
pub(crate) fn free_in_place<const D: usize>(system: &mut System<D>) -> Vec<FreeMotion> {
    let candidates = turns_in_place(system);
    if candidates.is_empty() {
        return Vec::new();
    }
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for x in null_space(system) {
        basis.extend(beside(&flat(system, &system.pattern.motions_of(&x)), &basis, 0.0));
    }
    let is_free = |row: &Vec<f64>| beside(row, &basis, OUTSIDE).is_none();
    candidates.into_iter().filter(|(row, _)| is_free(row)).map(|(_, motion)| motion).collect()
}

/// Turns of single joints, in the order of [`flat`], that move nothing that members and springs hang on: about the only place where any
/// of them do, or about the line through all of these.
fn turns_in_place<const D: usize>(system: &System<D>) -> Vec<(Vec<f64>, FreeMotion)> {
    let (structure, topology) = (&system.structure, &system.topology);
    let members = structure.members.iter().flat_map(|member| member.nodes);
    let springs = structure.springs.iter().flat_map(|spring| spring.nodes().iter().copied());
    let mut hung: Vec<Vec<NodeId>> = vec![Vec::new(); topology.references.len()];
    members.chain(springs).for_each(|node| hung[topology.links[node].joint].push(node));
    let near = 1e-9 * system.size;
    let mut turns = Vec::new();
    for (joint, nodes) in hung.iter().enumerate() {
        // What has no spin of its own makes none.
        let (Some(&first), Idle::None) = (nodes.first(), topology.idle[joint]) else { continue };
        let centre = structure.nodes[first];
        let arms: Vec<[f64; 3]> = nodes.iter().map(|&node| sub(structure.nodes[node], centre)).collect();
        let longest = arms.iter().copied().fold([0.0; 3], |a, b| if norm(b) > norm(a) { b } else { a });
        let axes = if norm(longest) <= near {
            vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        } else {
            vec![scale(1.0 / norm(longest), longest)]
        };
        for axis in axes {
            let in_plane = D != 3 || norm(sub(axis, [0.0, 0.0, 1.0])) == 0.0;
            if !in_plane || arms.iter().any(|&arm| norm(cross(axis, arm)) > near) {
                continue;
            }
            let reference = topology.references[joint];
            let shift = scale(1.0 / system.size, cross(axis, sub(structure.nodes[reference], centre)));
            let mut row = vec![0.0; 6 * hung.len()];
            row[6 * joint..6 * joint + 6].copy_from_slice(&[shift, axis].concat());
            let place = Place::Node(first);
            let nodes = vec![reference];
            let motion =
                FreeMotion { place, direction: axis, turns: true, nodes, extent: Extent::Local, about: Some(first) };
            turns.push((row, motion));
        }
    }
    turns
}

/// A basis of the motions of the equations that need no force at the last assembly.
fn null_space<const D: usize>(system: &mut System<D>) -> Vec<Vec<f64>> {
    let size = system.tangent.linear.size();
    let original = system.tangent.linear.values.clone();
    let doubt = system.rounded_stiffness();
    let diagonal: Vec<f64> = (0..size).map(|i| system.tangent.linear.diagonal(i).abs()).collect();
    let largest = diagonal.iter().fold(0.0f64, |a, &b| a.max(b));
    let weight: Vec<f64> = diagonal.iter().map(|d| d.max(1e-14 * largest).max(f64::MIN_POSITIVE)).collect();
    system.tangent.linear.shift(1e-9, &weight);
    system.tangent.linear.factorize();
    let mut found: Vec<Vec<f64>> = Vec::new();
    while found.len() < MANY.min(size) {
        let seed = found.len() as f64;
        let mut x: Vec<f64> = (0..size).map(|i| (1.3 * i as f64 + 0.7 + seed).sin() / weight[i].sqrt()).collect();
        for _ in 0..4 {
            // The iteration is K⁻¹ W, so that motions are orthogonal by the weights W.
            for (x, w) in x.iter_mut().zip(&weight) {
                *x *= w;
            }
            system.tangent.linear.solve(&mut x, 1);
            orthogonalize(&mut x, &found, &weight);
        }
        let linear = &system.tangent.linear;
        let (stiffness, rounding) = (linear.energy(&original, &x), energy_in_doubt(system, &doubt, &x));
        let norm: f64 = x.iter().zip(&weight).map(|(a, w)| a * a * w).sum();
        let components = if linear.is_wide() { rounding / f64::EPSILON } else { norm };
        if !(stiffness.abs() <= (FREE * components).max(rounding)) {
            break;
        }
        found.push(x);
    }
    system.tangent.linear.values = original;
    found
}

/// What rounding may have taken from the stiffness of a motion.
fn energy_in_doubt<const D: usize>(system: &System<D>, doubt: &[f64], x: &[f64]) -> f64 {
    let mut product = vec![0.0; x.len()];
    system.tangent.linear.apply_values(doubt, x, &mut product);
    x.iter().zip(&product).map(|(a, b)| a * b).sum()
}

/// The softest motion at the last assembly and factorization, where it is nearly free.
pub(crate) fn near_motion<const D: usize>(system: &mut System<D>) -> Option<NearMotion> {
    let mut stiffness = system.tangent.softest_stiffness(&system.pattern, system.size);
    if stiffness.abs() >= NEAR {
        return None;
    }
    let softest = system.tangent.softest_motion(&system.pattern, system.size);
    // In twice the digits what members are as a whole is not lost in their sum: what counts is how much of each is left.
    if system.tangent.linear.is_wide() {
        let doubt = system.rounded_stiffness();
        let linear = &system.tangent.linear;
        let rounding = energy_in_doubt(system, &doubt, &softest);
        stiffness = f64::EPSILON * linear.energy(&linear.values, &softest) / rounding.max(f64::MIN_POSITIVE);
        if stiffness.abs() >= NEAR {
            return None;
        }
    }
    let motion = describe(system, &flat(system, &system.pattern.motions_of(&softest)));
    Some(NearMotion { motion, stiffness })
}

fn orthogonalize(x: &mut [f64], found: &[Vec<f64>], weight: &[f64]) {
    let inner = |a: &[f64], b: &[f64]| -> f64 { (0..a.len()).map(|i| a[i] * b[i] * weight[i]).sum() };
    for other in found {
        let along = inner(x, other);
        x.iter_mut().zip(other).for_each(|(x, o)| *x -= along * o);
    }
    let length = inner(x, x).sqrt();
    if length > 0.0 {
        x.iter_mut().for_each(|x| *x /= length);
    }
}

/// Members with a released rotation that nothing resists.
fn released<const D: usize>(system: &System<D>) -> Vec<FreeMotion> {
    system
        .tangent
        .idle_members
        .iter()
        .map(|&member| FreeMotion {
            place: Place::Member(member),
            direction: system.structure.members[member].axes[0],
            turns: true,
            nodes: system.structure.members[member].nodes.to_vec(),
            extent: Extent::Local,
            about: None,
        })
        .collect()
}

/// A basis of the motions that iteration found, made to be read.
fn readable<const D: usize>(system: &System<D>, found: &[Vec<f64>]) -> Vec<FreeMotion> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for x in found {
        let row = flat(system, &system.pattern.motions_of(x));
        basis.extend(beside(&row, &basis, 0.0));
        rows.push(row);
    }
    let mut motions = Vec::new();
    let mut taken: Vec<Vec<f64>> = Vec::new();
    let parts = parts(system);
    for part in &parts {
        let extent = match part.len() {
            1 => Extent::Local,
            all if all == system.tangent.forces.len() => Extent::Whole,
            _ => Extent::Part,
        };
        if taken.len() == basis.len() {
            break;
        }
        for (own, axis, turns, about) in rigid(system, part, &rows) {
            // Among many parts most move as no one else does: their own joints tell, and are few.
            if taken.len() == basis.len() || !within(part, &own, &basis) {
                continue;
            }
            let mut row = vec![0.0; 6 * system.tangent.forces.len()];
            part.iter().zip(&own).for_each(|(&joint, own)| row[6 * joint..6 * joint + 6].copy_from_slice(own));
            if beside(&row, &basis, OUTSIDE).is_none()
                && let Some(new) = beside(&row, &taken, OUTSIDE)
            {
                taken.push(new);
                let motion = describe(system, &row);
                // What a single node does, or a part of which no more than one moves, is said of that node.
                motions.push(match motion.nodes.len() {
                    0 | 1 => motion,
                    _ => FreeMotion { direction: axis, turns, extent, about, ..motion },
                });
            }
        }
    }
    eliminate(&mut rows);
    let mut local: Vec<(usize, Vec<f64>)> =
        rows.into_iter().map(|row| (describe(system, &row).nodes.len(), row)).collect();
    local.sort_by_key(|entry| entry.0);
    for (_, row) in local {
        if taken.len() < basis.len()
            && let Some(new) = beside(&row, &taken, OUTSIDE)
        {
            taken.push(new);
            motions.push(describe(system, &row));
        }
    }
    motions
}

/// Motions of all joints one after the other, displacements over the size of the network.
fn flat<const D: usize>(system: &System<D>, motions: &[[f64; 6]]) -> Vec<f64> {
    let part = |motion: &[f64; 6]| -> [f64; 6] {
        std::array::from_fn(|c| if c < 3 { motion[c] / system.size } else { motion[c] })
    };
    motions.iter().flat_map(part).collect()
}

/// The unit vector of what is left of one beside orthonormal others; `None` where that is no more than a part of it.
fn beside(row: &[f64], others: &[Vec<f64>], least: f64) -> Option<Vec<f64>> {
    let inner = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let whole = inner(row, row).sqrt();
    let mut left = row.to_vec();
    for _ in 0..2 {
        for other in others {
            let along = inner(&left, other);
            left.iter_mut().zip(other).for_each(|(x, o)| *x -= along * o);
        }
    }
    let length = inner(&left, &left).sqrt();
    (length > least * whole).then(|| left.iter().map(|x| x / length).collect())
}

/// Whether what a part does may be a combination of orthonormal motions: by the share of it that lies along them.
fn within(part: &[usize], own: &[[f64; 6]], basis: &[Vec<f64>]) -> bool {
    let whole: f64 = own.iter().flatten().map(|x| x * x).sum();
    let along = |motion: &Vec<f64>| -> f64 {
        let at = |joint: usize| &motion[6 * joint..6 * joint + 6];
        part.iter().zip(own).map(|(&joint, own)| own.iter().zip(at(joint)).map(|(a, b)| a * b).sum::<f64>()).sum()
    };
    let inside: f64 = basis.iter().map(|motion| along(motion).powi(2)).sum();
    // No more than a sieve: the part outside has to be far larger than OUTSIDE allows.
    inside > (1.0 - 10.0 * OUTSIDE) * whole
}

/// Gauss-Jordan elimination with the largest pivot of all: every motion has one component that no other one has.
fn eliminate(rows: &mut [Vec<f64>]) {
    for done in 0..rows.len() {
        let mut pivot = (done, 0, 0.0f64);
        for (r, row) in rows.iter().enumerate().skip(done) {
            for (c, value) in row.iter().enumerate() {
                if value.abs() > pivot.2.abs() * (1.0 + 1e-6) {
                    pivot = (r, c, *value);
                }
            }
        }
        if pivot.2 == 0.0 {
            return;
        }
        rows.swap(done, pivot.0);
        rows[done].iter_mut().for_each(|x| *x /= pivot.2);
        let row = rows[done].clone();
        for (_, other) in rows.iter_mut().enumerate().filter(|(r, _)| *r != done) {
            let factor = other[pivot.1];
            other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
        }
    }
}

/// Joints that members and springs connect.
fn parts<const D: usize>(system: &System<D>) -> Vec<Vec<usize>> {
    let structure = &system.structure;
    let pairs = structure.members.iter().map(|member| member.nodes);
    let springs = structure.springs.iter().filter_map(Spring::pair);
    let mut root: Vec<usize> = (0..system.places.joints.len()).collect();
    let find = |root: &mut Vec<usize>, mut joint: usize| {
        while root[joint] != joint {
            root[joint] = root[root[joint]];
            joint = root[joint];
        }
        joint
    };
    for pair in pairs.chain(springs) {
        let [a, b] = pair.map(|node| find(&mut root, system.topology.links[node].joint));
        root[a.max(b)] = a.min(b);
    }
    let mut parts = vec![Vec::new(); root.len()];
    for joint in 0..root.len() {
        let first = find(&mut root, joint);
        parts[first].push(joint);
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// A motion of a part as a rigid body: what its joints do in the order of [`flat`], its axis, whether it turns, and a node
/// on the axis.
type Rigid = (Vec<[f64; 6]>, [f64; 3], bool, Option<usize>);

/// Motions of a part as a rigid body: along the axes, about them through its middle, then about joints and lines between them.
fn rigid<const D: usize>(system: &System<D>, part: &[usize], rows: &[Vec<f64>]) -> Vec<Rigid> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let place = |joint: usize| system.structure.nodes[system.topology.references[joint]];
    let mut middle = [0.0; 3];
    for &joint in part {
        axpy(&mut middle, 1.0 / part.len() as f64, place(joint));
    }
    let moved = |shift: [f64; 3], spin: [f64; 3], centre: [f64; 3]| {
        let motion = |&joint: &usize| {
            let u = add(shift, cross(spin, sub(place(joint), centre)));
            // Joints may have no rotation of their own, or no spin about an axis.
            let spin = match system.topology.idle[joint] {
                Idle::None => spin,
                Idle::Rotation => [0.0; 3],
                Idle::Spin(axis) => sub(spin, scale(dot(spin, axis) / dot(axis, axis), axis)),
                Idle::Spins([a, b]) => {
                    let left = cross(a, b);
                    scale(dot(spin, left) / dot(left, left), left)
                }
            };
            let u = u.map(|x| x / system.size);
            [u[0], u[1], u[2], spin[0], spin[1], spin[2]]
        };
        part.iter().map(motion).collect::<Vec<_>>()
    };
    let (shifts, turns) = if D == 3 { (&axes[..2], &axes[2..]) } else { (&axes[..], &axes[..]) };
    let mut candidates: Vec<Rigid> = Vec::new();
    candidates
        .extend(shifts.iter().map(|&axis| (moved(scale(system.size, axis), [0.0; 3], middle), axis, false, None)));
    candidates.extend(turns.iter().map(|&axis| (moved([0.0; 3], axis, middle), axis, true, None)));
    // An axis passes through joints that are held, at least along some direction.
    let moving = |joint: &usize| {
        let moves = |c: usize| rows.iter().any(|row| row[6 * joint + c].abs() > 1e-6);
        (0..3).filter(|&c| moves(c)).count()
    };
    let mut centres = part.to_vec();
    centres.sort_by_key(moving);
    centres.truncate(CENTRES);
    for &centre in &centres {
        let node = Some(system.topology.references[centre]);
        candidates.extend(turns.iter().map(|&axis| (moved([0.0; 3], axis, place(centre)), axis, true, node)));
    }
    for (k, &centre) in centres.iter().enumerate() {
        for &other in &centres[k + 1..] {
            let line = sub(place(other), place(centre));
            if D != 3 && norm(line) > 0.0 {
                let axis = scale(1.0 / norm(line), line);
                let node = Some(system.topology.references[centre]);
                candidates.push((moved([0.0; 3], axis, place(centre)), axis, true, node));
            }
        }
    }
    candidates.retain(|candidate| candidate.0.iter().flatten().any(|x| x.abs() > 1e-9));
    candidates
}

/// A motion in the order of [`flat`], where it is largest.
fn describe<const D: usize>(system: &System<D>, row: &[f64]) -> FreeMotion {
    let joint = |m: &[f64]| -> [f64; 6] { std::array::from_fn(|c| if c < 3 { m[c] * system.size } else { m[c] }) };
    let motions: Vec<[f64; 6]> = row.chunks(6).map(joint).collect();
    let shift = |m: &[f64; 6]| norm([m[0], m[1], m[2]]) / system.size;
    let spin = |m: &[f64; 6]| norm([m[3], m[4], m[5]]);
    let largest = |of: &dyn Fn(&[f64; 6]) -> f64| {
        let mut best = (0, 0.0);
        for (joint, motion) in motions.iter().enumerate() {
            if of(motion) > best.1 * (1.0 + 1e-9) {
                best = (joint, of(motion));
            }
        }
        best
    };
    let (shifted, by) = largest(&shift);
    let (turned, angle) = largest(&spin);
    // A turn in place moves nothing else; where nodes move, that is what a person sees first.
    let turns = by < 1e-6 * angle;
    let joint = if turns { turned } else { shifted };
    let m = motions[joint];
    let direction = if turns { [m[3], m[4], m[5]] } else { [m[0], m[1], m[2]] };
    let length = norm(direction);
    let size = |m: &[f64; 6]| shift(m).max(spin(m));
    let threshold = 1e-3 * by.max(angle);
    FreeMotion {
        place: Place::Node(system.topology.references[joint]),
        direction: if length > 0.0 { scale(1.0 / length, direction) } else { direction },
        turns,
        nodes: (0..motions.len())
            .filter(|&j| size(&motions[j]) > threshold)
            .map(|j| system.topology.references[j])
            .collect(),
        extent: Extent::Local,
        about: None,
    }
}
