//! States as values: kept, extrapolated, compared, and taken over by another system.

use pennate_elements::rotation::{angle, compose, inverse};
use pennate_elements::small::{V3, norm, sub};

use super::places::spin_between;
use super::{Fading, Places, System};
use crate::chain::{self, NodesBy, Size};
use crate::continuation::Tuning;
use crate::joints::{EndKind, JointState};
use crate::reduce;
use crate::structure::NodeId;

/// A state of a system as a value: all that an increment changes, but for the loads.
///
/// It belongs to systems of one structure and mesh; [`System::prolong`] takes a state over to another mesh.
#[derive(Debug, Default)]
pub struct State {
    pub(super) places: Places,
    /// The interior of the members, by pack.
    pub(super) chains: Vec<Vec<f64>>,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self { places: self.places.clone(), chains: self.chains.clone() }
    }

    /// Without allocation, where both are of one system.
    fn clone_from(&mut self, from: &Self) {
        self.places.clone_from(&from.places);
        self.chains.clone_from(&from.chains);
    }
}

impl State {
    /// Whether no joint is anywhere else than in the unloaded network.
    pub fn is_unloaded<const D: usize>(&self) -> bool {
        self.places.moved::<D>(1.0) == 0.0
    }
}

impl<const D: usize> System<D> {
    /// The present state as a value.
    pub fn snapshot(&self) -> State {
        let mut state = State::default();
        self.save(&mut state);
        state
    }

    /// Puts the present state in a value, without allocation where that has held one of this system.
    pub fn save(&self, into: &mut State) {
        into.places.clone_from(&self.places);
        self.members.save(&mut into.chains);
    }

    /// Goes back to a state.
    pub fn restore(&mut self, from: &State) {
        self.places.copy_from(&from.places);
        self.members.restore(from);
    }

    /// Takes the shape of a state, and a part of the change of the mixed stresses since.
    pub(crate) fn restore_shape(&mut self, from: &State, part: f64) {
        self.places.copy_from(&from.places);
        for (pack, row) in self.members.packs.iter_mut().zip(&from.chains) {
            pack.restore(row, part);
        }
    }

    /// How far the present state is from another one.
    pub(crate) fn distance(&self, other: &State) -> Size {
        self.distances(other).into_iter().fold(Size::default(), Size::join)
    }

    /// The same of every part of the network that nothing connects to others.
    pub fn distances(&self, other: &State) -> Vec<Size> {
        let parts = &self.pattern.parts;
        let mut all = vec![Size::default(); parts.count];
        let joints = self.places.joints.iter().zip(&other.places.joints).zip(&parts.joints);
        for ((a, b), &part) in joints {
            all[part] = all[part].join(Size {
                rotation: angle_between::<D>(b, a),
                displacement: norm(sub(a.place.displacement, b.place.displacement)) / self.size,
            });
        }
        for (pack, row) in self.members.packs.iter().zip(&other.chains) {
            for (&member, size) in pack.mesh().members.iter().zip(pack.distances(row)) {
                let part = parts.members[member];
                all[part] = all[part].join(size);
            }
        }
        all
    }

    /// Whether the present state is much farther from the last one than that was from the one before, if there is one.
    pub(crate) fn jumped(&self, last: &State, before: Option<&State>, tuning: &Tuning) -> bool {
        let now = self.places.farthest(&last.places) / self.size;
        let then = before.map_or(0.0, |before| last.places.farthest(&before.places) / self.size);
        now > (tuning.longer * then).max(tuning.miss)
    }

    /// Present displacement (length) or rotation (radians) of a node in its component, 0 to 5, along the unit vector `axis` in global
    /// axes; in the plane rotations have whole turns.
    pub fn present(&self, node: NodeId, component: usize, axis: V3<f64>) -> f64 {
        self.places.along::<D>(&self.topology.links[node], component, axis)
    }

    /// What takes the place of a row that is set free, and fades; nothing where no motion of these elements concerns it.
    pub fn fading_reaction(&self, node: NodeId, component: usize) -> Fading {
        let equations = &self.pattern.equations;
        let mut fading = Fading { node, force: [0.0; 3], moment: [0.0; 3] };
        if let Ok(index) = equations.held.binary_search_by_key(&(node, component), |held| (held.node, held.component)) {
            (fading.force, fading.moment) = equations.released(index, &self.topology, &self.places.joints);
        }
        fading
    }

    /// Motion of every joint since another state.
    pub(crate) fn motions_since(&self, then: &State) -> Vec<[f64; 6]> {
        self.places.motions_since::<D>(&then.places)
    }

    /// Extrapolates linearly from two states: from the last one, by so many times what led there from the one before.
    pub fn predict(&mut self, before: &State, last: &State, ratio: f64) {
        self.extrapolate([before, last], ratio, None);
    }

    /// Extrapolates by the parabola through three states, at distances along the path: from the first to the second, from there to
    /// the last, and from there on.
    pub fn predict_bent(&mut self, [earlier, before, last]: [&State; 3], [first, second, ahead]: [f64; 3]) {
        // Newton's divided differences.
        let bend = ahead * (ahead + second) / (first + second);
        self.extrapolate([before, last], (ahead + bend) / second, Some((earlier, -bend / first)));
    }

    /// Goes from the third of these states by multiples of the ways to it from the second, to the second from the first, and on from it to
    /// the fourth.
    pub(crate) fn combine(&mut self, [first, second, third, fourth]: [&State; 4], [last, before, ahead]: [f64; 3]) {
        self.extrapolate([second, third], last, Some((first, before)));
        let bent = self.snapshot();
        self.extrapolate([fourth, &bent], 0.0, Some((third, ahead)));
    }

    fn extrapolate(&mut self, [before, last]: [&State; 2], ratio: f64, bend: Option<(&State, f64)>) {
        for (index, pack) in self.members.packs.iter_mut().enumerate() {
            let bend = bend.map(|(earlier, times)| (&*earlier.chains[index], times));
            pack.predict([&before.chains[index], &last.chains[index]], ratio, bend);
        }
        let way =
            |a: &JointState, b: &JointState| (sub(b.place.displacement, a.place.displacement), spin_between::<D>(a, b));
        let mut motions = std::mem::take(&mut self.moves.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            let (a, b) = (&before.places.joints[joint], &last.places.joints[joint]);
            self.places.joints[joint] = *b;
            let (step, spin) = way(a, b);
            for c in 0..3 {
                motion[c] = ratio * step[c];
                motion[3 + c] = ratio * spin[c];
            }
            if let Some((earlier, times)) = bend {
                let (step, spin) = way(&earlier.places.joints[joint], a);
                for c in 0..3 {
                    motion[c] += times * step[c];
                    motion[3 + c] += times * spin[c];
                }
            }
        }
        self.move_joints(&motions, true);
        self.moves.motions = motions;
        for (index, kinds) in self.topology.ends.iter().enumerate() {
            for (end, kind) in kinds.iter().enumerate().filter(|(_, kind)| **kind != EndKind::Welded) {
                let release = |state: &State| state.places.releases[index][end];
                let bend = bend.map(|(earlier, times)| (release(earlier), times));
                let node = self.structure.members[index].nodes[end];
                let joint = &self.places.joints[self.topology.links[node].joint].place;
                let target = &mut self.places.releases[index][end];
                *target = reduce::extrapolate_release(kind, [release(before), release(last)], ratio, bend, joint);
            }
        }
        self.place_ends();
        self.members.place_nodes(NodesBy::Elements);
    }

    /// Takes over the state of a system of the same members on another mesh.
    pub fn prolong(&mut self, coarse: &Self) {
        self.places.copy_from(&coarse.places);
        self.loading.follow(&coarse.loading);
        for pack in &mut self.members.packs {
            let source = |&member: &usize| coarse.members.chain(member);
            let sources: Vec<_> = pack.mesh().members.iter().map(source).collect();
            chain::prolong(pack.as_mut(), &sources);
        }
        self.apply_drives();
        self.place_ends();
    }
}

impl System<6> {
    /// Takes over the state of the same network solved in the plane.
    pub(crate) fn lift(&mut self, plane: &System<3>) {
        self.places.copy_from(&plane.places);
        for joint in &mut self.places.joints {
            joint.theta = [0.0, 0.0, joint.place.angle];
        }
        self.loading.follow(&plane.loading);
        for (space, plane) in self.members.packs.iter_mut().zip(&plane.members.packs) {
            chain::lift(space.as_mut(), plane.as_ref());
        }
        self.apply_drives();
        self.place_ends();
    }
}

/// Angle between two rotations of a joint, whole turns included in the plane.
fn angle_between<const D: usize>(from: &JointState, to: &JointState) -> f64 {
    if D == 3 {
        (to.place.angle - from.place.angle).abs()
    } else {
        angle(compose(to.place.rotation, inverse(from.place.rotation)))
    }
}
