//! From a vector of unknowns to the motion of nodes and members.

use pennate_elements::small::norm;

use super::unknowns::{Unknowns, motion, network_node};
use crate::structure::{MemberId, NodeId};
use crate::system::System;

/// Motion of every point of a network: displacement, then spin (radians), in global axes.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// In the order of the nodes of the network.
    pub nodes: Vec<[f64; 6]>,
    /// Of every member, all nodes of its elements from start to end.
    pub members: Vec<Vec<[f64; 6]>>,
}

/// A point of a network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spot {
    /// A node.
    Node(NodeId),
    /// At a part of the way between the ends of a member, counted in nodes of its elements.
    Member(MemberId, f64),
}

/// The largest component of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Largest {
    /// Where it is.
    pub spot: Spot,
    /// 0, 1, 2 displacement along x, y, z; 3, 4, 5 spin about them, only where nothing is displaced.
    pub component: usize,
    /// How large it is.
    pub value: f64,
}

impl Shape {
    /// The shape of an eigenvector.
    pub(crate) fn new(system: &System<6>, unknowns: &Unknowns, x: &[f64]) -> Self {
        let nodes = (0..system.structure.nodes.len()).map(|node| motion(&network_node(system, node), x)).collect();
        let member = |index: usize| {
            let pack = &system.members.packs[system.members.slots[index].pack];
            let points = 0..=pack.mesh().elements() * pack.mesh().order;
            points.map(|point| motion(&unknowns.member_node(system, index, point), x)).collect()
        };
        Self { nodes, members: (0..system.members.count()).map(member).collect() }
    }

    /// All points with their motions.
    fn spots(&self) -> impl Iterator<Item = (Spot, &[f64; 6])> {
        let nodes = self.nodes.iter().enumerate().map(|(node, motion)| (Spot::Node(node), motion));
        let members = self.members.iter().enumerate().flat_map(|(member, points)| {
            let last = points.len().saturating_sub(1).max(1) as f64;
            points.iter().enumerate().map(move |(k, motion)| (Spot::Member(member, k as f64 / last), motion))
        });
        nodes.chain(members)
    }

    /// Largest displacement of any point.
    pub fn displacement(&self) -> f64 {
        self.spots().map(|(_, m)| norm([m[0], m[1], m[2]])).fold(0.0, f64::max)
    }

    /// Largest component; at a node rather than within a member where both move alike.
    pub fn largest(&self, size: f64) -> Largest {
        let spin = self.spots().map(|(_, m)| norm([m[3], m[4], m[5]])).fold(0.0, f64::max);
        let turns = self.displacement() < 1e-9 * spin * size;
        let components = if turns { 3..6 } else { 0..3 };
        let mut largest = Largest { spot: Spot::Node(0), component: components.start, value: 0.0 };
        for (spot, motion) in self.spots() {
            for component in components.clone() {
                if motion[component].abs() > largest.value.abs() * (1.0 + 1e-9) {
                    largest = Largest { spot, component, value: motion[component] };
                }
            }
        }
        largest
    }

    /// The shape times a factor.
    #[must_use]
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        for motion in self.nodes.iter_mut().chain(self.members.iter_mut().flatten()) {
            motion.iter_mut().for_each(|x| *x *= factor);
        }
        self
    }
}
