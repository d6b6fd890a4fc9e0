//! States put aside, extrapolated, compared, and taken over by another system.

use pennate_elements::small::{V3, add, norm, scale, sub};

use super::{State, System};
use crate::chain::Size;
use crate::joints::EndKind;

impl<const D: usize> System<D> {
    /// Geometric stiffness by the stresses of the present strains instead of mixed ones.
    pub fn set_plain(&mut self, plain: bool) {
        self.packs.iter_mut().for_each(|pack| pack.set_plain(plain));
    }

    /// Takes the shape of a saved state, and a part of the change of the mixed stresses since.
    pub fn restore_shape(&mut self, slot: usize, part: f64) {
        copy_state(&self.saved[slot], &mut self.state);
        self.packs.iter_mut().for_each(|pack| pack.restore_shape(slot, part));
    }

    /// How far the present state is from a saved one.
    pub fn distance(&self, slot: usize) -> Size {
        self.distances(slot).into_iter().fold(Size::default(), Size::join)
    }

    /// The same of every part of the network that nothing connects to others.
    pub fn distances(&self, slot: usize) -> Vec<Size> {
        let mut all = vec![Size::default(); self.parts.count];
        let joints = self.state.joints.iter().zip(&self.saved[slot].joints).zip(&self.parts.joints);
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
        for pack in &self.packs {
            for (&member, size) in pack.members().iter().zip(pack.distances(slot)) {
                let part = self.parts.members[member];
                all[part] = all[part].join(size);
            }
        }
        all
    }

    /// Keeps the present state in a slot.
    pub fn save(&mut self, slot: usize) {
        copy_state(&self.state, &mut self.saved[slot]);
        self.packs.iter_mut().for_each(|pack| pack.save(slot));
    }

    /// Goes back to the state in a slot.
    pub fn restore(&mut self, slot: usize) {
        copy_state(&self.saved[slot], &mut self.state);
        self.packs.iter_mut().for_each(|pack| pack.restore(slot));
    }

    /// Keeps the state put aside in `last` as `before`, and puts aside the present one.
    pub fn save_as(&mut self, last: usize, before: usize) {
        let state = std::mem::take(&mut self.saved[last]);
        self.saved[last] = std::mem::replace(&mut self.saved[before], state);
        self.packs.iter_mut().for_each(|pack| pack.swap(last, before));
        self.save(last);
    }

    /// Whether the present state is much farther from the last saved one than that was from the one before.
    pub fn jumped(&self, last: usize, before: usize, has_before: bool) -> bool {
        let far = |a: &State, b: &State| {
            a.joints
                .iter()
                .zip(&b.joints)
                .fold(0.0f64, |far, (a, b)| far.max(norm(sub(a.place.displacement, b.place.displacement)) / self.size))
        };
        let now = far(&self.state, &self.saved[last]);
        let then = if has_before { far(&self.saved[last], &self.saved[before]) } else { 0.0 };
        now > (10.0 * then).max(0.05)
    }

    /// Extrapolates linearly from two saved states.
    pub fn predict(&mut self, before: usize, last: usize, ratio: f64) {
        self.packs.iter_mut().for_each(|pack| pack.predict(before, last, ratio));
        let mut motions = std::mem::take(&mut self.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            let (a, b) = (self.saved[before].joints[joint], self.saved[last].joints[joint]);
            self.state.joints[joint] = b;
            let spin = between(a.place.rotation, b.place.rotation);
            let spin = if D == 3 { [0.0, 0.0, b.place.angle - a.place.angle] } else { spin };
            let step = sub(b.place.displacement, a.place.displacement);
            for c in 0..3 {
                motion[c] = ratio * step[c];
                motion[3 + c] = ratio * spin[c];
            }
        }
        self.move_joints(&motions, true);
        self.motions = motions;
        for (index, kinds) in self.topology.ends.iter().enumerate() {
            for (end, kind) in kinds.iter().enumerate() {
                if *kind == EndKind::Welded {
                    continue;
                }
                let (a, b) = (self.saved[before].releases[index][end], self.saved[last].releases[index][end]);
                let target = &mut self.state.releases[index][end];
                *target = b;
                let spin = scale(ratio, between(a.rotation, b.rotation));
                for t in 0..2 {
                    target.turns[t] += ratio * (b.turns[t] - a.turns[t]);
                }
                target.angle += ratio * (b.angle - a.angle);
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
        copy_state(&coarse.state, &mut self.state);
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

    /// Keeps the present state for good, as the next of those that [`System::recall`] knows.
    pub fn keep(&mut self) {
        self.kept.push(self.state.clone());
        self.packs.iter_mut().for_each(|pack| pack.keep());
    }

    /// Goes back to a kept state.
    pub fn recall(&mut self, index: usize) {
        copy_state(&self.kept[index], &mut self.state);
        self.packs.iter_mut().for_each(|pack| pack.recall(index));
    }
}

impl System<6> {
    /// Takes over the state of the same network solved in the plane.
    pub fn lift(&mut self, plane: &System<3>) {
        copy_state(&plane.state, &mut self.state);
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

pub(super) fn copy_state(from: &State, to: &mut State) {
    to.joints.copy_from_slice(&from.joints);
    to.releases.copy_from_slice(&from.releases);
}
