//! How members deform: the motion of their ends as it is seen from their starts. Springs that push or pull along a line are bars with
//! two hinges.
//!
//! What carries a member along has no part in it: a long chain that swings around deforms the same way all along.

use pennate_elements::rotation::{Quaternion, angle, compose, inverse, log, turn};
use pennate_elements::small::{V3, cross, dot, norm, sub};

use super::places::Places;
use super::{State, System};
use crate::joints::EndKind;
use crate::structure::{MemberId, NodeId};

/// Displacement, over the length of a member, and spin of its end, in the frame of its start.
pub(crate) type Relative = [f64; 6];

/// The end of a member, or of a bar, as it is seen from its start.
struct Seen {
    chord: V3<f64>,
    rotation: Quaternion<f64>,
    /// Angle about z with whole turns, in the plane alone.
    angle: f64,
}

impl<const D: usize> System<D> {
    /// How every member, and after these every bar, deformed from one state to another.
    pub(crate) fn relative_between(&self, from: &State, to: &State) -> Vec<Relative> {
        self.relative(&from.places, &to.places)
    }

    /// The same from a state to the present one.
    pub(crate) fn relative_since(&self, from: &State) -> Vec<Relative> {
        self.relative(&from.places, &self.places)
    }

    /// How they deform by small motions of the joints.
    pub(crate) fn relative_rates(&self, motions: &[[f64; 6]]) -> Vec<Relative> {
        let of = |nodes: [NodeId; 2], is_welded: bool| {
            let links = nodes.map(|node| &self.topology.links[node]);
            let [start, end] = links.map(|link| self.places.motion_of(link, motions));
            let (by, spin) = (sub(end, start), [start[3], start[4], start[5]]);
            let carried = cross(spin, self.chord(nodes, &self.places));
            let back = inverse(self.places.pose(links[0]).rotation);
            let displacement = turn(back, sub([by[0], by[1], by[2]], carried));
            let spin = if is_welded { turn(back, [by[3], by[4], by[5]]) } else { [0.0; 3] };
            self.over_length(nodes, displacement, spin)
        };
        self.of_all(of)
    }

    /// Something of all members and bars by their nodes, and whether their ends turn with these.
    fn of_all<R>(&self, of: impl Fn([NodeId; 2], bool) -> R) -> Vec<R> {
        let members = self.structure.members.iter().map(|member| of(member.nodes, true));
        members.chain(self.bars().map(|(_, nodes)| of(nodes, false))).collect()
    }

    /// The springs that are bars, with their nodes.
    pub(super) fn bars(&self) -> impl Iterator<Item = (usize, [NodeId; 2])> {
        let springs = self.structure.springs.iter().enumerate();
        springs.filter_map(|(index, spring)| spring.bar().map(|nodes| (index, nodes)))
    }

    /// The largest angle by which a released end of a member, or a bar, has turned against its joint since another state, of every part
    /// of the network.
    pub(crate) fn hinges_turned(&self, since: &State) -> Vec<f64> {
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
        let of_bar = |(_, nodes): (usize, [NodeId; 2])| {
            let [now, then] = [&self.places, &since.places].map(|places| self.chord(nodes, places));
            let turned = |node: NodeId| {
                let joint = self.topology.links[node].joint;
                let [a, b] = [(&self.places, now), (&since.places, then)]
                    .map(|(places, chord)| turn(inverse(places.joints[joint].place.rotation), chord));
                norm(cross(a, b)).atan2(dot(a, b))
            };
            turned(nodes[0]).max(turned(nodes[1]))
        };
        let mut most = vec![0.0; self.pattern.parts.count];
        let members = self.topology.ends.iter().enumerate().map(of);
        for (turned, part) in members.chain(self.bars().map(of_bar)).zip(self.parts_of_all()) {
            most[part] = f64::max(most[part], turned);
        }
        most
    }

    /// Squares of two such motions and, between them, their product, of every part of the network that nothing connects to others.
    pub(crate) fn products_by_part(&self, a: &[Relative], b: &[Relative]) -> Vec<[f64; 3]> {
        let product = |a: &Relative, b: &Relative| (0..6).map(|c| a[c] * b[c]).sum::<f64>();
        let mut all = vec![[0.0; 3]; self.pattern.parts.count];
        for ((a, b), part) in a.iter().zip(b).zip(self.parts_of_all()) {
            let products = [product(a, a), product(a, b), product(b, b)];
            all[part].iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
        all
    }

    /// The part that every member belongs to, and then every bar.
    pub(super) fn parts_of_all(&self) -> impl Iterator<Item = usize> {
        let parts = &self.pattern.parts;
        let of_bars = self.bars().map(|(index, _)| parts.springs[index]);
        parts.members.iter().copied().chain(of_bars)
    }

    fn relative(&self, from: &Places, to: &Places) -> Vec<Relative> {
        let of = |nodes: [NodeId; 2], is_welded: bool| {
            let [from, to] = [from, to].map(|places| self.seen(nodes, places));
            let spin = match D {
                _ if !is_welded => [0.0; 3],
                3 => [0.0, 0.0, to.angle - from.angle],
                _ => log(compose(to.rotation, inverse(from.rotation))),
            };
            self.over_length(nodes, sub(to.chord, from.chord), spin)
        };
        self.of_all(of)
    }

    fn seen(&self, nodes: [NodeId; 2], places: &Places) -> Seen {
        let links = nodes.map(|node| &self.topology.links[node]);
        let [start, end] = links.map(|link| &places.joints[link.joint].place);
        let back = inverse(start.rotation);
        Seen {
            chord: turn(back, self.chord(nodes, places)),
            rotation: compose(back, end.rotation),
            angle: end.angle - start.angle,
        }
    }

    /// From one node to another.
    pub(super) fn chord(&self, ends: [NodeId; 2], places: &Places) -> V3<f64> {
        let [start, end] = ends.map(|node| places.pose(&self.topology.links[node]).displacement);
        let unloaded = sub(self.structure.nodes[ends[1]], self.structure.nodes[ends[0]]);
        std::array::from_fn(|c| unloaded[c] + end[c] - start[c])
    }

    fn over_length(&self, nodes: [NodeId; 2], by: V3<f64>, spin: V3<f64>) -> Relative {
        let ends = nodes.map(|node| self.structure.nodes[node]);
        let chord = norm(sub(ends[1], ends[0]));
        // A ring has no chord.
        let length = if chord > 0.0 { chord } else { self.size };
        [by[0] / length, by[1] / length, by[2] / length, spin[0], spin[1], spin[2]]
    }
}
