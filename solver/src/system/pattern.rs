//! What stays as it is while the same rows are held: which motions are free, and where everything goes in the matrix.

use std::sync::Arc;

use super::carriers::Carrier;
use super::loading::{Fading, loaded_nodes};
use super::parts::Parts;
use super::posture::Layout;
use super::scatter::{Scatters, unit_motion};
use super::side::Side;
use crate::joints::{Active, Equations, Held, HeldKind, Topology};
use crate::linear::Symmetric;
use crate::structure::{NodeId, Structure};

/// The equations of the joints as long as the same rows are held.
///
/// Their numbers move with a state (axes of supports turn), and the analysis of the matrix does not.
pub struct Pattern<const D: usize> {
    /// Free and held components of the joints.
    pub equations: Equations<D>,
    /// What is held and concerns none of these: out of the plane, in one.
    pub aside: Vec<Held>,
    /// Whether the structure is that of designs side by side, one or many: their joints are eliminated block by block. Counts from
    /// the next [`super::System::hold`].
    pub in_blocks: bool,
    /// Where everything goes in the matrix.
    pub(super) scatters: Arc<Scatters>,
    /// Members that lie beside their likes of other parts, if any do.
    pub(super) side: Option<Arc<Side>>,
    /// Nodes that any load may act on.
    pub(super) loaded_nodes: Vec<NodeId>,
    /// Joints that a member carries, in the order in which they move.
    pub(super) carriers: Arc<Vec<Carrier>>,
    /// By joint, whether a member carries it.
    pub(super) carried: Vec<bool>,
    /// Whether both are those of the structure and the rows that are held.
    pub(super) has_carriers: bool,
    /// Parts of the network that nothing connects.
    pub(super) parts: Parts,
    /// Where its equations are in the matrices of postures, once one was asked for.
    pub(super) layout: Option<Arc<Layout>>,
}

impl<const D: usize> Pattern<D> {
    /// Nothing is held yet, and nothing analysed.
    pub(super) fn new(structure: &Structure, topology: &Topology, active: Active<D>) -> Self {
        Self {
            equations: Equations::new(topology, active, Vec::new()),
            aside: Vec::new(),
            in_blocks: false,
            scatters: Arc::default(),
            side: None,
            loaded_nodes: Vec::new(),
            carriers: Arc::default(),
            carried: vec![false; topology.references.len()],
            has_carriers: false,
            parts: Parts::of(structure, topology),
            layout: None,
        }
    }

    /// Takes the joints of another structure, held as those of the one `before`; false, with nothing changed, where they have other
    /// equations.
    pub(super) fn renew(&mut self, before: &Topology, topology: &Topology) -> bool {
        if !self.equations.has_general() && topology.moves_like(before) {
            self.equations.unload();
            return true;
        }
        let equations = Equations::new(topology, self.equations.active, self.equations.held.clone());
        let alike = equations.are_like(&self.equations);
        if alike {
            self.equations = equations;
        }
        alike
    }

    /// Sets what is held; true where that, or what is idle, is not the same as before, and the equations have to be analysed.
    pub(super) fn hold(&mut self, topology: &Topology, mut held: Vec<Held>, idle_moved: bool) -> bool {
        let mut aside = std::mem::take(&mut self.aside);
        aside.clear();
        held.retain(|row| {
            let concerns = self.concerns(row);
            if !concerns {
                aside.push(*row);
            }
            concerns
        });
        self.aside = aside;
        let same = |a: &Held, b: &Held| (a.node, a.component, a.kind) == (b.node, b.component, b.kind);
        let known = &self.equations.held;
        let analysed = self.scatters.joints.len() == self.equations.joints.len();
        let unchanged = known.len() == held.len() && known.iter().zip(&held).all(|(a, b)| same(a, b));
        if analysed && unchanged && !idle_moved {
            self.equations.held = held;
            return false;
        }
        self.equations = Equations::new(topology, self.equations.active, held);
        self.layout = None;
        true
    }

    /// The matrix of the equations: where its entries are, and in which order it is eliminated.
    pub(super) fn analyse(&mut self, structure: &Structure, topology: &Topology) -> Symmetric {
        let joints = |nodes: &[NodeId]| nodes.iter().map(|&n| topology.links[n].joint).collect::<Vec<_>>();
        let members: Vec<_> = structure.members.iter().map(|member| joints(&member.nodes)).collect();
        let springs: Vec<_> = structure.springs.iter().map(|spring| joints(spring.nodes())).collect();
        let (linear, scatters) = Scatters::analyse(&self.equations, &members, &springs, self.in_blocks);
        self.scatters = Arc::new(scatters);
        linear
    }

    /// Finds the nodes that drives, weights and fading forces may load.
    pub(super) fn find_loaded_nodes(&mut self, structure: &Structure, fading: &[Fading]) {
        self.loaded_nodes = loaded_nodes(structure);
        self.loaded_nodes.extend(fading.iter().map(|f| f.node));
        self.loaded_nodes.sort_unstable();
        self.loaded_nodes.dedup();
    }

    /// Whether a row holds any of the active components.
    fn concerns(&self, held: &Held) -> bool {
        let (vector, offset) = match held.kind {
            HeldKind::Translation { direction } => (direction, 0),
            HeldKind::Rotation { axis } => (axis, 3),
        };
        (0..3).any(|i| vector[i] != 0.0 && self.equations.active.contains(&(offset + i)))
    }

    /// Motions of all joints that a solution of their equations means.
    pub fn motions_of(&self, solution: &[f64]) -> Vec<[f64; 6]> {
        (0..self.equations.joints.len()).map(|joint| self.equations.motion(joint, solution, false)).collect()
    }

    /// Forces and moments on the joints, or motions of these, along the motions that their equations stand for.
    pub(crate) fn along_equations(&self, of_joints: &[[f64; 6]]) -> Vec<f64> {
        let equations = &self.equations.joints;
        let mut along = vec![0.0; equations.iter().map(|own| own.count).sum()];
        for (joint, (own, of)) in equations.iter().zip(of_joints).enumerate() {
            for (value, motion) in along[own.first..].iter_mut().zip(self.joint_motions(joint)) {
                *value = motion.iter().zip(of).map(|(a, b)| a * b).sum();
            }
        }
        along
    }

    /// The motions of a joint that its equations stand for, one after the other.
    pub(crate) fn joint_motions(&self, joint: usize) -> Vec<[f64; 6]> {
        let count = self.equations.joints[joint].count;
        let unit = |e: usize| -> [f64; 6] { std::array::from_fn(|i| if i == e { 1.0 } else { 0.0 }) };
        (0..count).map(|e| unit_motion(&self.equations, joint, &unit(e)[..count])).collect()
    }
}
