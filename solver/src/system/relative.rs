//! How members deform: the motion of their ends as it is seen from their starts.
//!
//! What carries a member along has no part in it: a long chain that swings around deforms the same way all along.

use pennate_elements::rotation::{Quaternion, angle, compose, inverse, log, turn};
use pennate_elements::small::{V3, cross, norm, sub};

use super::places::Places;
use super::{State, System};
use crate::joints::EndKind;
use crate::structure::MemberId;

/// Displacement, over the length of a member, and spin of its end, in the frame of its start.
pub(crate) type Relative = [f64; 6];

/// The end of a member as it is seen from its start.
struct Seen {
    chord: V3<f64>,
    rotation: Quaternion<f64>,
    /// Angle about z with whole turns, in the plane alone.
    angle: f64,
}

impl<const D: usize> System<D> {
    /// How every member deformed from one state to another.
    pub(crate) fn relative_between(&self, from: &State, to: &State) -> Vec<Relative> {
        self.relative(&from.places, &to.places)
    }

    /// How every member deformed from a state to the present one.
    pub(crate) fn relative_since(&self, from: &State) -> Vec<Relative> {
        self.relative(&from.places, &self.places)
    }

    /// How every member deforms by small motions of the joints.
    pub(crate) fn relative_rates(&self, motions: &[[f64; 6]]) -> Vec<Relative> {
        let of = |member: MemberId| {
            let links = self.structure.members[member].nodes.map(|node| &self.topology.links[node]);
            let [start, end] = links.map(|link| self.places.motion_of(link, motions));
            let (by, spin) = (sub(end, start), [start[3], start[4], start[5]]);
            let carried = cross(spin, self.chord(member, &self.places));
            let back = inverse(self.places.pose(links[0]).rotation);
            let displacement = turn(back, sub([by[0], by[1], by[2]], carried));
            self.over_length(member, displacement, turn(back, [by[3], by[4], by[5]]))
        };
        (0..self.structure.members.len()).map(of).collect()
    }

    /// The largest angle by which a released end of a member has turned against its joint since another state.
    pub(crate) fn hinges_turned(&self, since: &State) -> f64 {
        let of = |(member, kinds): (MemberId, &[EndKind; 2])| {
            let turned = |end: usize| {
                let joint = self.topology.links[self.structure.members[member].nodes[end]].joint;
                let angles = |places: &Places| places.releases[member][end].angle - places.joints[joint].place.angle;
                let turns = |places: &Places| {
                    let [own, carried] = [places.releases[member][end].rotation, places.joints[joint].place.rotation];
                    compose(inverse(carried), own)
                };
                match D {
                    _ if kinds[end] == EndKind::Welded => 0.0,
                    3 => (angles(&self.places) - angles(&since.places)).abs(),
                    _ => angle(compose(turns(&self.places), inverse(turns(&since.places)))),
                }
            };
            turned(0).max(turned(1))
        };
        self.topology.ends.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    /// Squares of two such motions and, between them, their product, of every part of the network that nothing connects to others.
    pub(crate) fn products_by_part(&self, a: &[Relative], b: &[Relative]) -> Vec<[f64; 3]> {
        let product = |a: &Relative, b: &Relative| (0..6).map(|c| a[c] * b[c]).sum::<f64>();
        let mut all = vec![[0.0; 3]; self.pattern.parts.count];
        for ((a, b), &part) in a.iter().zip(b).zip(&self.pattern.parts.members) {
            let products = [product(a, a), product(a, b), product(b, b)];
            all[part].iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
        all
    }

    fn relative(&self, from: &Places, to: &Places) -> Vec<Relative> {
        let of = |member: MemberId| {
            let [from, to] = [from, to].map(|places| self.seen(member, places));
            let spin = if D == 3 {
                [0.0, 0.0, to.angle - from.angle]
            } else {
                log(compose(to.rotation, inverse(from.rotation)))
            };
            self.over_length(member, sub(to.chord, from.chord), spin)
        };
        (0..self.structure.members.len()).map(of).collect()
    }

    fn seen(&self, member: MemberId, places: &Places) -> Seen {
        let links = self.structure.members[member].nodes.map(|node| &self.topology.links[node]);
        let [start, end] = links.map(|link| &places.joints[link.joint].place);
        let back = inverse(start.rotation);
        Seen {
            chord: turn(back, self.chord(member, places)),
            rotation: compose(back, end.rotation),
            angle: end.angle - start.angle,
        }
    }

    /// From the start of a member to its end.
    fn chord(&self, member: MemberId, places: &Places) -> V3<f64> {
        let ends = self.structure.members[member].nodes;
        let [start, end] = ends.map(|node| places.pose(&self.topology.links[node]).displacement);
        let unloaded = sub(self.structure.nodes[ends[1]], self.structure.nodes[ends[0]]);
        std::array::from_fn(|c| unloaded[c] + end[c] - start[c])
    }

    fn over_length(&self, member: MemberId, by: V3<f64>, spin: V3<f64>) -> Relative {
        let ends = self.structure.members[member].nodes.map(|node| self.structure.nodes[node]);
        let chord = norm(sub(ends[1], ends[0]));
        // A ring has no chord.
        let length = if chord > 0.0 { chord } else { self.size };
        [by[0] / length, by[1] / length, by[2] / length, spin[0], spin[1], spin[2]]
    }
}
