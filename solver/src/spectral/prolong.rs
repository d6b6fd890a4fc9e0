//! Motions of a network put on other elements of it.

use super::shape::Shape;
use super::unknowns::Unknowns;
use crate::system::System;

/// Elements along the members of a network.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    members: Vec<Elements>,
}

/// Elements of one member.
#[derive(Clone, Debug)]
struct Elements {
    order: usize,
    /// Where they begin and end, in parts of the unloaded length: one more than there are elements.
    ends: Vec<f64>,
}

/// A motion with the elements that it is known on.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// Unknowns of joints and released ends, which all elements share.
    shared: Vec<f64>,
    /// Of every member, the motions of all nodes of its elements.
    members: Vec<Vec<[f64; 6]>>,
}

impl Grid {
    /// The elements of a system.
    pub(crate) fn of(system: &System<6>) -> Self {
        let elements = |index: usize| {
            let slot = &system.members.slots[index];
            let pack = &system.members.packs[slot.pack];
            let mut ends = pack.mesh().spans(slot.lane);
            let whole = ends[ends.len() - 1];
            ends.iter_mut().for_each(|end| *end /= whole);
            Elements { order: pack.mesh().order, ends }
        };
        Self { members: (0..system.members.count()).map(elements).collect() }
    }
}

impl Elements {
    fn nodes(&self) -> usize {
        (self.ends.len() - 1) * self.order + 1
    }

    /// Where a node is, in parts of the unloaded length.
    fn place(&self, node: usize) -> f64 {
        let element = (node / self.order).min(self.ends.len() - 2);
        let part = (node - element * self.order) as f64 / self.order as f64;
        self.ends[element] + part * (self.ends[element + 1] - self.ends[element])
    }

    /// What is known at the nodes, between them.
    fn interpolate(&self, nodes: &[[f64; 6]], place: f64) -> [f64; 6] {
        let element = self.ends.partition_point(|end| *end <= place).clamp(1, self.ends.len() - 1) - 1;
        let [from, to] = [self.ends[element], self.ends[element + 1]];
        let at = (place - from) / (to - from) * self.order as f64;
        let mut value = [0.0; 6];
        for (i, node) in nodes[element * self.order..=(element + 1) * self.order].iter().enumerate() {
            let others = (0..=self.order).filter(|&j| j != i);
            let weight: f64 = others.map(|j| (at - j as f64) / (i as f64 - j as f64)).product();
            value.iter_mut().zip(node).for_each(|(value, node)| *value += weight * node);
        }
        value
    }
}

impl Motion {
    /// The motion of a vector of unknowns, whose shape is known.
    pub(crate) fn new(unknowns: &Unknowns, x: &[f64], shape: &Shape) -> Self {
        Self { shared: x[..unknowns.shared()].to_vec(), members: shape.members.clone() }
    }

    /// Its unknowns on other elements of the same network; nothing where that has other joints.
    pub(crate) fn onto(&self, from: &Grid, unknowns: &Unknowns, to: &Grid) -> Option<Vec<f64>> {
        if self.shared.len() != unknowns.shared() || self.members.len() != to.members.len() {
            return None;
        }
        let mut x = self.shared.clone();
        x.resize(unknowns.size, 0.0);
        for (member, (from, to)) in from.members.iter().zip(&to.members).enumerate() {
            for node in 1..to.nodes() - 1 {
                let first = unknowns.inner(member, node);
                let motion = from.interpolate(&self.members[member], to.place(node));
                x[first..first + 6].copy_from_slice(&motion);
            }
        }
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quintic on elements of order 5 is the same on any others.
    #[test]
    fn a_polynomial_of_the_order_of_its_elements_is_the_same_on_others() {
        let value = |s: f64| std::array::from_fn(|c| (s - 0.1 * c as f64).powi(5) - s);
        let from = Elements { order: 5, ends: vec![0.0, 0.3, 1.0] };
        let nodes: Vec<[f64; 6]> = (0..from.nodes()).map(|node| value(from.place(node))).collect();
        let to = Elements { order: 3, ends: vec![0.0, 0.15, 0.3, 0.8, 1.0] };
        for node in 0..to.nodes() {
            let place = to.place(node);
            for (found, exact) in from.interpolate(&nodes, place).iter().zip(value(place)) {
                assert!((found - exact).abs() < 1e-14, "{node}: {found} {exact}");
            }
        }
    }
}
