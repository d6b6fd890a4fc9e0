//! States as values: kept, extrapolated, compared, and taken over by another system.

use pennate_elements::small::{V3, add, dot, norm, scale, sub};

use super::{Places, System};
use crate::chain::Size;
use crate::continuation::Tuning;
use crate::joints::{EndKind, JointState};
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

impl<const D: usize> System<D> {
    /// The present state as a value.
    pub fn snapshot(&self) -> State {
        let mut state = State::default();
        self.save(&mut state);
        state
    }

    /// Puts the present state in a value, without allocation where that has held one of this system.
    pub fn save(&self, into: &mut State) {
        into.places.clone_from(&self.state);
        into.chains.resize_with(self.packs.len(), Vec::new);
        for (pack, row) in self.packs.iter().zip(&mut into.chains) {
            pack.save(row);
        }
    }

    /// Goes back to a state.
    pub fn restore(&mut self, from: &State) {
        self.state.copy_from(&from.places);
        for (pack, row) in self.packs.iter_mut().zip(&from.chains) {
            pack.restore(row);
        }
    }

    /// Takes the shape of a state, and a part of the change of the mixed stresses since.
    pub fn restore_shape(&mut self, from: &State, part: f64) {
        self.state.copy_from(&from.places);
        for (pack, row) in self.packs.iter_mut().zip(&from.chains) {
            pack.restore_shape(row, part);
        }
    }

    /// Geometric stiffness by the stresses of the present strains instead of mixed ones.
    pub fn set_plain(&mut self, plain: bool) {
        self.packs.iter_mut().for_each(|pack| pack.set_plain(plain));
    }

    /// How far the present state is from another one.
    pub fn distance(&self, other: &State) -> Size {
        self.distances(other).into_iter().fold(Size::default(), Size::join)
    }

    /// The same of every part of the network that nothing connects to others.
    pub fn distances(&self, other: &State) -> Vec<Size> {
        let mut all = vec![Size::default(); self.parts.count];
        let joints = self.state.joints.iter().zip(&other.places.joints).zip(&self.parts.joints);
        for ((a, b), &part) in joints {
            let [now, then] = [a, b].map(|joint| joint.place);
            all[part] = all[part].join(Size {
                rotation: if D == 3 {
                    (now.angle - then.angle).abs()
                } else {
                    between_angle(then.rotation, now.rotation)
                },
                displacement: norm(sub(a.place.displacement, b.place.displacement)) / self.size,
            });
        }
        for (pack, row) in self.packs.iter().zip(&other.chains) {
            for (&member, size) in pack.members().iter().zip(pack.distances(row)) {
                let part = self.parts.members[member];
                all[part] = all[part].join(size);
            }
        }
        all
    }

    /// Whether the present state is much farther from the last one than that was from the one before, if there is one.
    pub(crate) fn jumped(&self, last: &State, before: Option<&State>, tuning: &Tuning) -> bool {
        let far = |a: &Places, b: &Places| {
            a.joints
                .iter()
                .zip(&b.joints)
                .fold(0.0f64, |far, (a, b)| far.max(norm(sub(a.place.displacement, b.place.displacement)) / self.size))
        };
        let now = far(&self.state, &last.places);
        let then = before.map_or(0.0, |before| far(&last.places, &before.places));
        now > (tuning.longer * then).max(tuning.miss)
    }

    /// Present displacement (length) or rotation (radians) of a node in its component, 0 to 5, along the unit vector `axis` in global
    /// axes; in the plane rotations have whole turns.
    pub fn present(&self, node: NodeId, component: usize, axis: V3<f64>) -> f64 {
        let link = &self.topology.links[node];
        let joint = &self.state.joints[link.joint];
        if component < 3 {
            dot(axis, joint.point(link.arm))
        } else if D == 3 {
            axis[2] * joint.place.angle
        } else {
            dot(axis, joint.theta)
        }
    }

    /// Motion of every joint since another state.
    pub fn motions_since(&self, then: &State) -> Vec<[f64; 6]> {
        self.motions_between(&then.places.joints)
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

    fn extrapolate(&mut self, [before, last]: [&State; 2], ratio: f64, bend: Option<(&State, f64)>) {
        for (index, pack) in self.packs.iter_mut().enumerate() {
            let bend = bend.map(|(earlier, times)| (&*earlier.chains[index], times));
            pack.predict([&before.chains[index], &last.chains[index]], ratio, bend);
        }
        let way = |a: &JointState, b: &JointState| {
            let spin = match D {
                3 => [0.0, 0.0, b.place.angle - a.place.angle],
                _ => between(a.place.rotation, b.place.rotation),
            };
            (sub(b.place.displacement, a.place.displacement), spin)
        };
        let mut motions = std::mem::take(&mut self.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            let (a, b) = (&before.places.joints[joint], &last.places.joints[joint]);
            self.state.joints[joint] = *b;
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
        self.motions = motions;
        for (index, kinds) in self.topology.ends.iter().enumerate() {
            for (end, kind) in kinds.iter().enumerate() {
                if *kind == EndKind::Welded {
                    continue;
                }
                let (a, b) = (&before.places.releases[index][end], &last.places.releases[index][end]);
                let mut spin = scale(ratio, between(a.rotation, b.rotation));
                let mut turns: [f64; 2] = std::array::from_fn(|t| ratio * (b.turns[t] - a.turns[t]));
                let mut angle = ratio * (b.angle - a.angle);
                if let Some((earlier, times)) = bend {
                    let z = &earlier.places.releases[index][end];
                    spin = add(spin, scale(times, between(z.rotation, a.rotation)));
                    turns = std::array::from_fn(|t| turns[t] + times * (a.turns[t] - z.turns[t]));
                    angle += times * (a.angle - z.angle);
                }
                let target = &mut self.state.releases[index][end];
                *target = *b;
                for t in 0..2 {
                    target.turns[t] += turns[t];
                }
                target.angle += angle;
                target.rotation =
                    pennate_elements::rotation::compose(pennate_elements::rotation::exp(spin), b.rotation);
                if let EndKind::Axes(axes) = kind {
                    let node = self.structure.members[index].nodes[end];
                    let joint = self.state.joints[self.topology.links[node].joint].place;
                    let turned = axes.iter().zip(target.turns).fold([0.0; 3], |s, (a, t)| add(s, scale(t, *a)));
                    target.rotation =
                        pennate_elements::rotation::compose(joint.rotation, pennate_elements::rotation::exp(turned));
                    target.angle = joint.angle + turned[2];
                }
            }
        }
        self.place_ends();
        self.packs.iter_mut().for_each(|pack| pack.unroll());
    }

    /// Takes over the state of a system of the same members on another mesh.
    pub fn prolong(&mut self, coarse: &Self) {
        self.state.copy_from(&coarse.state);
        self.drives.copy_from_slice(&coarse.drives);
        self.prestress = coarse.prestress;
        self.fraction = coarse.fraction;
        for pack in &mut self.packs {
            let source = |&member: &usize| {
                let slot = &coarse.members[member];
                (coarse.packs[slot.pack].as_ref(), slot.lane)
            };
            let sources: Vec<_> = pack.members().iter().map(source).collect();
            pack.prolong(&sources);
        }
        self.apply_drives();
        self.place_ends();
    }
}

impl System<6> {
    /// Takes over the state of the same network solved in the plane.
    pub fn lift(&mut self, plane: &System<3>) {
        self.state.copy_from(&plane.state);
        for joint in &mut self.state.joints {
            joint.theta = [0.0, 0.0, joint.place.angle];
        }
        self.drives.copy_from_slice(&plane.drives);
        self.prestress = plane.prestress;
        self.fraction = plane.fraction;
        for (space, plane) in self.packs.iter_mut().zip(&plane.packs) {
            space.lift(plane.as_ref());
        }
        self.apply_drives();
        self.place_ends();
    }
}

/// Angle of the same, without its axis.
fn between_angle(a: [f64; 4], b: [f64; 4]) -> f64 {
    use pennate_elements::rotation::{angle, compose, inverse};
    angle(compose(b, inverse(a)))
}

fn between(a: [f64; 4], b: [f64; 4]) -> V3<f64> {
    use pennate_elements::rotation::{compose, inverse, log};
    log(compose(b, inverse(a)))
}
