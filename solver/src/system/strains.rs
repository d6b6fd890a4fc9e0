//! How a member, or a spring, is strained by motions of its nodes: rows whose squares are its energy.
//!
//! A member is taken for a uniform beam as soft as it in all, straight from one end to the other: only which motions strain it
//! matters here, and roughly how much. In its own axes (1 along the chord) the second end moves by d and turns by s against where
//! the first carries it, and has the energy ½ (d, s)ᵀ C (d, s), less what releases take away.

use pennate_elements::rotation::turn;
use pennate_elements::small::{V3, cross, dot, norm, scale, sub};

use super::System;
use crate::joints::EndKind;
use crate::structure::{MemberId, NodeId, Spring};

/// Part of the softness in bending that a member has along or about itself at least: what cannot be stretched counts as much stiffer.
const STIFFEST: f64 = 1e-9;
/// Part of a stiffness that is rounding once something is released.
const ROUNDED: f64 = 1e-10;

/// What strains one member or spring by one row: forces on its nodes, and moments.
pub(super) type Straining = [[f64; 6]; 2];

impl<const D: usize> System<D> {
    /// Calls with every row of a member by which it is strained.
    pub(super) fn strains_of_member(&self, index: MemberId, mut take: impl FnMut(Straining)) {
        let chord = self.chord(self.structure.members[index].nodes, &self.places);
        let axes = self.axes_of_chord(index, chord);
        for own in self.root_of_stiffness(index) {
            let in_space = |part: usize| -> V3<f64> {
                std::array::from_fn(|c| (0..3).map(|axis| own[3 * part + axis] * axes[axis][c]).sum())
            };
            take(apart(chord, in_space(0), in_space(1)));
        }
    }

    /// The same for a spring.
    pub(super) fn strains_of_spring(&self, spring: &Spring, mut take: impl FnMut(Straining)) {
        let unit = |c: usize| -> V3<f64> { std::array::from_fn(|i| if i == c % 3 { 1.0 } else { 0.0 }) };
        match spring {
            Spring::Axial { nodes, stiffness, .. } => {
                let Some(along) = self.along(*nodes) else { return };
                let along = scale(stiffness.max(0.0).sqrt(), along);
                take(apart([0.0; 3], along, [0.0; 3]));
            }
            Spring::Ground { stiffness, .. } => {
                for (c, &k) in stiffness.iter().enumerate().filter(|(_, k)| **k > 0.0) {
                    take([std::array::from_fn(|i| if i == c { k.sqrt() } else { 0.0 }), [0.0; 6]]);
                }
            }
            Spring::Coupling { nodes, stiffness } => {
                let rotation = self.places.joints[self.topology.links[nodes[0]].joint].place.rotation;
                let chord = self.chord(*nodes, &self.places);
                for (c, &k) in stiffness.iter().enumerate().filter(|(_, k)| **k > 0.0) {
                    let axis = scale(k.sqrt(), turn(rotation, unit(c)));
                    let [force, moment] = if c < 3 { [axis, [0.0; 3]] } else { [[0.0; 3], axis] };
                    take(apart(chord, force, moment));
                }
            }
        }
    }

    /// The direction from one node to another, where they are apart.
    fn along(&self, nodes: [NodeId; 2]) -> Option<V3<f64>> {
        let chord = self.chord(nodes, &self.places);
        let length = norm(chord);
        (length > 0.0).then(|| scale(1.0 / length, chord))
    }

    /// The axes of a member, 1 along the chord: those of an end that turns with its joint, turned from its tangent the shortest way.
    fn axes_of_chord(&self, index: MemberId, chord: V3<f64>) -> [V3<f64>; 3] {
        let member = &self.structure.members[index];
        let unloaded = self.unloaded_axes(index);
        let length = norm(chord);
        if length == 0.0 {
            return unloaded;
        }
        let ends = &self.topology.ends[index];
        let end = usize::from(ends[0] != EndKind::Welded && ends[1] == EndKind::Welded);
        let rotation = self.places.joints[self.topology.links[member.nodes[end]].joint].place.rotation;
        let [from, to] = [turn(rotation, unloaded[0]), scale(1.0 / length, chord)];
        let (normal, cosine) = (cross(from, to), dot(from, to));
        let shortest = |v: V3<f64>| -> V3<f64> {
            let (once, along) = (cross(normal, v), dot(normal, v) / (1.0 + cosine).max(f64::EPSILON));
            std::array::from_fn(|c| cosine * v[c] + once[c] + along * normal[c])
        };
        unloaded.map(|axis| shortest(turn(rotation, axis)))
    }

    /// The same of the unloaded member.
    fn unloaded_axes(&self, index: MemberId) -> [V3<f64>; 3] {
        let member = &self.structure.members[index];
        let chord = sub(self.structure.nodes[member.nodes[1]], self.structure.nodes[member.nodes[0]]);
        let first = scale(1.0 / norm(chord), chord);
        // A rod that begins curved has an axis 2 that is not across the chord, and may lie along it.
        let across = |axis: usize| cross(first, member.axes[axis]);
        let third = if norm(across(1)) >= norm(across(2)) { across(1) } else { cross(across(2), first) };
        let third = scale(1.0 / norm(third), third);
        [first, cross(third, first), third]
    }

    /// Rows r with C = Σ r rᵀ, of a member in its own axes: of displacements, and of rotations.
    fn root_of_stiffness(&self, index: MemberId) -> Vec<[f64; 6]> {
        let member = &self.structure.members[index];
        let length = norm(sub(self.structure.nodes[member.nodes[1]], self.structure.nodes[member.nodes[0]]));
        let mut softness = [0.0; 4];
        for (number, segment) in member.segments.iter().enumerate() {
            let own = self.section(index, number).section;
            for (sum, stiffness) in softness.iter_mut().zip([own.ea, own.gj, own.ei2, own.ei3]) {
                *sum += segment.length / stiffness;
            }
        }
        let softest = softness[2].max(softness[3]);
        let softest = if softest > 0.0 { softest } else { 1.0 };
        softness[0] = softness[0].max(STIFFEST * length * length * softest);
        softness[1..].iter_mut().for_each(|own| *own = own.max(STIFFEST * softest));
        let mut stiffness = uniform_beam(length, softness);
        let largest: [f64; 6] = std::array::from_fn(|i| stiffness[i][i]);
        for (end, kind) in self.topology.ends[index].iter().enumerate() {
            for axis in self.released_axes(index, kind) {
                // A turn of the first end carries the second one along.
                let carried = if end == 0 { cross(axis, [length, 0.0, 0.0]) } else { [0.0; 3] };
                release(&mut stiffness, [carried, axis].as_flattened(), &largest);
            }
        }
        root(stiffness, &largest)
    }

    /// The axes, among those of the member, about which an end of this kind is free to turn.
    fn released_axes(&self, index: MemberId, kind: &EndKind) -> Vec<V3<f64>> {
        match kind {
            EndKind::Welded => Vec::new(),
            EndKind::Free { .. } => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            EndKind::Axes { axes, .. } => {
                let own = self.unloaded_axes(index);
                axes.iter().map(|axis| own.map(|own| dot(own, *axis))).collect()
            }
        }
    }
}

/// What a force and a moment on the second of two nodes are on both, where the first carries the second at the end of an arm.
fn apart(arm: V3<f64>, force: V3<f64>, moment: V3<f64>) -> Straining {
    let about = cross(arm, force);
    let both = |sign: f64, about: V3<f64>| -> [f64; 6] {
        std::array::from_fn(|c| if c < 3 { sign * force[c] } else { sign * (moment[c - 3] + about[c - 3]) })
    };
    [both(-1.0, about), both(1.0, [0.0; 3])]
}

/// The stiffness of the second end of a clamped beam, by its softness in tension, torsion, and bending about axes 2 and 3 (length over
/// stiffness).
fn uniform_beam(length: f64, [tension, torsion, bending2, bending3]: [f64; 4]) -> [[f64; 6]; 6] {
    let mut stiffness = [[0.0; 6]; 6];
    stiffness[0][0] = 1.0 / tension;
    stiffness[3][3] = 1.0 / torsion;
    for (softness, shift, spin, sign) in [(bending3, 1, 5, -1.0), (bending2, 2, 4, 1.0)] {
        stiffness[shift][shift] = 12.0 / (softness * length * length);
        stiffness[shift][spin] = sign * 6.0 / (softness * length);
        stiffness[spin][shift] = stiffness[shift][spin];
        stiffness[spin][spin] = 4.0 / softness;
    }
    stiffness
}

/// Takes from a stiffness what it has against one motion.
fn release(stiffness: &mut [[f64; 6]; 6], motion: &[f64], largest: &[f64; 6]) {
    let force: [f64; 6] = std::array::from_fn(|i| (0..6).map(|j| stiffness[i][j] * motion[j]).sum());
    let own: f64 = (0..6).map(|i| motion[i] * force[i]).sum();
    let most: f64 = (0..6).map(|i| motion[i] * motion[i] * largest[i]).sum();
    if own <= ROUNDED * most {
        return;
    }
    for i in 0..6 {
        for j in 0..6 {
            stiffness[i][j] -= force[i] * force[j] / own;
        }
    }
}

/// Rows whose products make up a stiffness.
fn root(mut stiffness: [[f64; 6]; 6], largest: &[f64; 6]) -> Vec<[f64; 6]> {
    let mut rows = Vec::with_capacity(6);
    for k in 0..6 {
        let own = stiffness[k][k];
        if own <= ROUNDED * largest[k] {
            continue;
        }
        let row: [f64; 6] = std::array::from_fn(|i| stiffness[k][i] / own.sqrt());
        for i in 0..6 {
            for j in 0..6 {
                stiffness[i][j] -= row[i] * row[j];
            }
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows make up the stiffness of a clamped beam, and what two pins leave of it is tension alone.
    #[test]
    fn rows_make_up_the_stiffness_of_a_beam() {
        let (length, softness) = (3.0, [2.0, 0.7, 0.4, 0.9]);
        let whole = uniform_beam(length, softness);
        let largest: [f64; 6] = std::array::from_fn(|i| whole[i][i]);
        let rows = root(whole, &largest);
        assert_eq!(rows.len(), 6);
        for i in 0..6 {
            for j in 0..6 {
                let sum: f64 = rows.iter().map(|row| row[i] * row[j]).sum();
                assert!((sum - whole[i][j]).abs() < 1e-14 * largest[i].max(largest[j]), "{i} {j}");
            }
        }
        // A unit force across the end of a cantilever moves it by L³/(3 EI), with L/(EI) = 0.9.
        let [shift, spin] = [1, 5];
        let stiffness = whole[shift][shift] - whole[shift][spin] * whole[spin][shift] / whole[spin][spin];
        assert!((stiffness * 0.9 * length * length / 3.0 - 1.0).abs() < 1e-14);
        let mut pinned = whole;
        for axis in 0..3 {
            let turn: V3<f64> = std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
            for carried in [cross(turn, [length, 0.0, 0.0]), [0.0; 3]] {
                release(&mut pinned, [carried, turn].as_flattened(), &largest);
            }
        }
        let left = root(pinned, &largest);
        assert_eq!(left.len(), 1);
        assert!((left[0][0] * left[0][0] * softness[0] - 1.0).abs() < 1e-14, "{left:?}");
    }

    /// Motions of both nodes as one body strain nothing.
    #[test]
    fn a_body_is_not_strained() {
        let (arm, spin, shift) = ([0.3, -1.2, 0.7], [0.2, 0.5, -0.4], [1.0, 2.0, 3.0]);
        let forces = apart(arm, [0.6, -0.1, 0.9], [0.4, 0.8, -0.5]);
        let carried = cross(spin, arm);
        let motions = [shift, std::array::from_fn(|c| shift[c] + carried[c])].map(|u: V3<f64>| [u, spin]);
        let work: f64 = forces
            .iter()
            .zip(&motions)
            .map(|(f, m)| f.iter().zip(m.as_flattened()).map(|(f, m)| f * m).sum::<f64>())
            .sum();
        assert!(work.abs() < 1e-14, "{work}");
    }
}
