//! What the solver asks of the chains of members that lie side by side, whatever their order and number of lanes.

use std::any::Any;

use pennate_elements::beam::{Beam, Ends, Moduli, Placement};
use pennate_elements::real::Real;
use pennate_elements::small::{V3, zeros};

use crate::ahead::Task;
use crate::element::{SegmentState, Unloaded};
use crate::lateral::LateralEnds;
use crate::measures::Measures;
use crate::mesh::{ChainMesh, PackMesh};
use crate::rows::{AddEnds, EndPlaces, EndRows, TakePoses};
use crate::size::Size;
use crate::transfer::NewState;
use crate::variation::SegmentVariation;
use crate::{Chain, KeptFactors, MOST_LANES, MOST_NODES, condense, lanes, state, unroll};

/// What is left of a member after elimination: stiffness and residual of its two ends in global axes.
pub type MemberEnds<const D: usize> = Ends<f64, D>;

/// What elimination finds between the ends of a member.
#[derive(Clone, Copy, Debug)]
pub struct Interior {
    /// Strain energy.
    pub energy: f64,
    /// Number of negative pivots.
    pub negative: usize,
    /// The smallest pivot over the diagonal entry that elimination left it of.
    pub smallest: f64,
}

/// What an elimination does besides.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Whether the geometric stiffness uses the stresses of the present strains, without mixed integration points.
    pub plain: bool,
    /// Whether all factors are kept, which [`Pack::refresh`] needs: half as much again as the way back to the interior.
    pub keeps_factors: bool,
    /// Stiffness, for a unit of mass, of dashpots that tie every node between the ends to where it is in a saved state; zero where
    /// there are none.
    pub dashpots: f64,
    /// That state.
    pub anchor: Vec<f64>,
    /// Force on every node between the ends for a unit of mass, in a direction that singles out no motion; zero where there is none.
    pub push: f64,
    /// What draws nodes between the ends to places.
    pub drawn: Vec<Drawn>,
}

impl Settings {
    /// Whether dashpots, forces or springs act on nodes between the ends.
    pub(crate) fn acts_on_nodes(&self) -> bool {
        self.dashpots > 0.0 || self.push != 0.0 || !self.drawn.is_empty()
    }
}

/// A node between the ends of a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InnerNode {
    /// The end of an element, by index among them.
    Between(usize),
    /// A node within an element, by both indices; its place is that in the frame of the element.
    Within(usize, usize),
}

/// Springs that draw a node between the ends to a place.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// Lane of the member.
    pub lane: usize,
    /// The node.
    pub node: InnerNode,
    /// Stiffness (force per length).
    pub stiffness: f64,
    /// The displacement (length) that it is drawn to in every component; where there is none it is left alone.
    pub to: [Option<f64>; 3],
}

/// A number between -1 and 1, another one for each component: forces that go with it single out no motion.
pub fn any(component: usize) -> f64 {
    (1.3 * component as f64 + 0.7).sin()
}

/// How the nodes between the ends of members are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodesBy {
    /// One after the other by the local unknowns of the elements; what these miss the ends by is shared.
    Elements,
    /// By their increments, each on its own.
    Increments,
}

/// The chains of the members that lie side by side in one `T`, whatever their order.
pub trait Pack<const D: usize>: Any + Send {
    // What it is made of.

    /// How the members are divided into elements.
    fn mesh(&self) -> &PackMesh;
    /// Unloaded geometry of an element.
    fn unloaded(&self, lane: usize, element: usize) -> Unloaded;
    /// Section and load of a segment.
    fn segment(&self, lane: usize, segment: usize) -> SegmentState<D>;
    /// Sets them: stiffness and induced strains, and the dead force per unloaded length.
    fn set_segment(&mut self, lane: usize, segment: usize, moduli: &Moduli<f64, 6>, load: V3<f64>);
    /// What the next eliminations do besides.
    fn settings(&mut self) -> &mut Settings;
    /// Begins anew with other members of the same mesh, unloaded and at rest; false, with nothing changed, where their mesh is
    /// another one or they are more than the lanes hold.
    fn renew(&mut self, meshes: &[ChainMesh]) -> bool;
    /// Chains of the same kind for other members of the same mesh, no more than there are lanes: they have no factors of their
    /// own before a [`Pack::condense`], and serve [`Pack::refresh`] by those of this pack.
    fn like(&self, meshes: &[ChainMesh]) -> Box<dyn Pack<D>>;
    /// Gives back what only a solve needs: what is left can be taken over by another pack, and not be solved any more.
    fn shed(&mut self);

    // What is done pack by pack: where there is one that does the same next, it is told what will be asked of it.

    /// Asks for the memory that an element needs for a task; no element is too far.
    fn prefetch(&self, task: Task, element: usize);
    /// Linearizes every element and eliminates everything between the ends.
    fn condense(&mut self, next: Option<&dyn Pack<D>>);
    /// Back-substitution for motions of the ends, displacements, then spins, from rows of joints: new local unknowns of every
    /// element. Nodes follow with [`Pack::set_ends`] and [`Pack::place_nodes`].
    fn advance(&mut self, motions: &[f64], joints: [usize; 2], next: Option<&dyn Pack<D>>);
    /// Places the nodes between the ends.
    fn place_nodes(&mut self, by: NodesBy, next: Option<&dyn Pack<D>>);

    // What is left of it at its ends.

    /// Takes the forces of the present state in place of those that the last [`Pack::condense`] found: what is left inside is
    /// brought to the ends by the factors of then, which is right to second order in what was moved since. Where factors are kept
    /// the next [`Pack::advance`] goes on with them; that is said. With a source, which [`Pack::like`] made this pack from, by the
    /// factors of that one, whose stiffness and ends become those of this one.
    fn refresh(&mut self, source: Option<&dyn Pack<D>>) -> bool;
    /// Stiffness and forces of the ends after elimination of what is between them.
    fn condensed(&self, lane: usize) -> MemberEnds<D>;
    /// Forces on the ends that the mixed stresses make, with the loads along the member: what turns with an arm in the tangent. Of
    /// the components the translations alone.
    fn mixed_forces(&self, lane: usize) -> [[f64; D]; 2];
    /// Puts the forces of these alone, which are all that [`Pack::refresh`] changes, into those of all members, by index in the
    /// structure, in these components; others stay.
    fn put_end_forces(&self, components: &[usize; D], forces: &mut [[[f64; 6]; 2]]);
    /// Adds the forces of the ends of all members to rows of joints, whose lanes are theirs, and with places the stiffness too:
    /// start and end of each are at the joints of these rows. The squares of the largest force and moment.
    fn add_ends(&self, rows: &mut EndRows, joints: [usize; 2], places: Option<&EndPlaces>) -> [f64; 2];
    /// What the last [`Pack::condense`] found between the ends; the energy is that of the last [`Pack::refresh`] too.
    fn interior(&self, lane: usize) -> Interior;
    /// Stiffness of the first element at the start and of the last one at the end in global axes, where all other nodes
    /// are held, those within the elements too: the terms that elimination subtracts from. For every member of the pack.
    fn bare_stiffness(&self) -> Vec<[[[f64; D]; D]; 2]>;
    /// What a small motion of the ends does in every segment; the last [`Pack::condense`] must be that of an equilibrium.
    fn variation(&self, lane: usize, ends: &[[f64; D]; 2]) -> Vec<SegmentVariation<D>>;
    /// Eliminates everything between the ends from the lateral stiffness of plane chains at their present state, with these spatial
    /// moduli of all segments, by lane. What that leaves, by lane.
    fn condense_lateral(&self, moduli: &[Vec<Moduli<f64, 6>>]) -> Vec<LateralEnds>;

    // How it moves.

    /// Puts the ends of all members where joints are, from rows of poses: displacements, and the angle in the plane or the rotation
    /// in space. Start and end of each are at the joints of these rows.
    fn set_ends(&mut self, poses: &[f64], joints: [usize; 2]);
    /// Where an end is carried to by the local unknowns of the elements, if the other end is at `from`.
    fn carried(&self, lane: usize, end: usize, from: &Placement) -> Placement;
    /// Size of the last increment, and of what it is without the motion that the member makes as a whole with its start.
    fn sizes(&self, lane: usize) -> [Size; 2];

    // Its state as numbers.

    /// Puts the present state in a row of numbers, as long as it needs: poses of the element ends, local unknowns, stresses.
    fn save(&self, row: &mut Vec<f64>);
    /// Takes the state in a row: poses, local unknowns, and the mixed stresses but for a part of their change since.
    fn restore(&mut self, row: &[f64], part: f64);
    /// Takes the state that a pack of the same members and elements, of another order, put in a row.
    fn enrich(&mut self, row: &[f64], from: &PackMesh);
    /// How far the element ends of every member are from the state in a row, by lane.
    fn distances(&self, row: &[f64]) -> [Size; MOST_LANES];
    /// Extrapolation of the local unknowns and stresses from two states, by so many times what led from one to the other, and by
    /// so many times what led to them from a state before; nodes follow as after [`Pack::advance`].
    fn predict(&mut self, states: [&[f64]; 2], ratio: f64, bend: Option<(&[f64], f64)>);
    /// Where the node before an element is, and after the last one.
    fn node(&self, lane: usize, index: usize) -> Placement;
    /// Local unknowns of nodes 1…P of an element, the last node's by where the ends are.
    fn local(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES];
    /// Mixed stresses at the Gauss points of an element.
    fn stress(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES];
    /// Puts an element of a member into a state.
    fn set_element(&mut self, lane: usize, element: usize, state: &NewState<'_, D>);

    // What is measured in the lanes.

    /// Strains at the Gauss points of an element.
    fn strains(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES];
    /// Present length and largest strains of every member.
    fn measures(&self) -> Vec<Measures>;
    /// Largest strain that a held (rigid) component still has.
    fn violation(&self) -> f64;
    /// Largest tangent of the angle by which bending within an element that cannot be stretched lets its chord lean against the
    /// rotation of its middle; zero for elements that are not sheared by bending.
    fn lean(&self) -> f64;
    /// The largest force that a section of a member carries, along its axis and across, by lane.
    fn carried_forces(&self) -> [f64; MOST_LANES];
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Pack<D> for Chain<T, B, D, P> {
    fn mesh(&self) -> &PackMesh {
        &self.mesh
    }

    fn unloaded(&self, lane: usize, element: usize) -> Unloaded {
        self.unloaded_impl(lane, element)
    }

    fn segment(&self, lane: usize, segment: usize) -> SegmentState<D> {
        self.segment_impl(lane, segment)
    }

    fn set_segment(&mut self, lane: usize, segment: usize, moduli: &Moduli<f64, 6>, load: V3<f64>) {
        let target = &mut self.moduli[segment];
        for d in 0..D {
            let from = if D == 6 { d } else { [0, 1, 5][d] };
            target.stiffness[d].set_lane(lane, moduli.stiffness[from]);
            target.rest[d].set_lane(lane, moduli.rest[from]);
            target.held[d].set_lane(lane, moduli.held[from]);
        }
        for (target, value) in target.softening.iter_mut().zip(moduli.softening) {
            target.set_lane(lane, value);
        }
        for (target, value) in self.loads[segment].iter_mut().zip(load) {
            target.set_lane(lane, value);
        }
        // Looking at all segments for each of them would take long.
        if load != [0.0; 3] {
            self.loaded = true;
            self.inner_turn.resize(self.frames.len() * Self::INNER_NODES, zeros());
        } else if self.loaded {
            self.loaded = self.loads.iter().flatten().any(|q| (0..T::LANES).any(|l| q.lane(l) != 0.0));
        }
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.settings
    }

    fn renew(&mut self, meshes: &[ChainMesh]) -> bool {
        self.renew_impl(meshes)
    }

    fn like(&self, meshes: &[ChainMesh]) -> Box<dyn Pack<D>> {
        Box::new(Self::without_factors(meshes))
    }

    fn shed(&mut self) {
        self.inner = Vec::new();
        self.inner_rest = Vec::new();
        self.inner_turn = Vec::new();
        self.factors = Vec::new();
        self.kept = KeptFactors::default();
        self.increments = Vec::new();
    }

    fn condense(&mut self, next: Option<&dyn Pack<D>>) {
        if self.settings.keeps_factors {
            self.keep_factors();
        }
        if self.settings.acts_on_nodes() {
            self.load_dashpots();
        }
        T::run(condense::Condense { chain: self, next });
    }

    fn refresh(&mut self, source: Option<&dyn Pack<D>>) -> bool {
        if let Some(source) = source {
            let any: &dyn Any = source;
            let Some(source) = any.downcast_ref::<Self>() else { return false };
            self.ends = source.ends;
            T::run(condense::Refresh::<T, B, D, P, false>(self, Some(source)));
            return false;
        }
        if self.settings.acts_on_nodes() {
            self.load_dashpots();
        }
        let keeps = self.kept.own.len() + 1 == self.frames.len() && self.kept.inner_own.len() == self.inner_rest.len();
        match keeps {
            true => T::run(condense::Refresh::<T, B, D, P, true>(self, None)),
            false => T::run(condense::Refresh::<T, B, D, P, false>(self, None)),
        }
        keeps
    }

    fn condensed(&self, lane: usize) -> MemberEnds<D> {
        Ends {
            k00: lanes::lanes(&self.ends.k00, lane),
            k01: lanes::lanes(&self.ends.k01, lane),
            k11: lanes::lanes(&self.ends.k11, lane),
            r0: lanes::lane(&self.ends.r0, lane),
            r1: lanes::lane(&self.ends.r1, lane),
        }
    }

    fn mixed_forces(&self, lane: usize) -> [[f64; D]; 2] {
        self.mixed.each_ref().map(|force| lanes::lane(force, lane))
    }

    fn put_end_forces(&self, components: &[usize; D], forces: &mut [[[f64; 6]; 2]]) {
        for (lane, &member) in self.mesh.members.iter().enumerate() {
            for (target, force) in forces[member].iter_mut().zip([&self.ends.r0, &self.ends.r1]) {
                for d in 0..D {
                    target[components[d]] = force[d].lane(lane);
                }
            }
        }
    }

    fn add_ends(&self, rows: &mut EndRows, joints: [usize; 2], places: Option<&EndPlaces>) -> [f64; 2] {
        T::run(AddEnds { chain: self, rows, joints, places })
    }

    fn interior(&self, lane: usize) -> Interior {
        Interior {
            energy: self.energy.lane(lane),
            negative: self.negative.lane(lane) as usize,
            smallest: 1.0 / self.softest.lane(lane),
        }
    }

    fn bare_stiffness(&self) -> Vec<[[[f64; D]; D]; 2]> {
        let [start, end] = T::run(condense::Bare(self));
        (0..self.mesh.members.len()).map(|lane| [lanes::lanes(&start, lane), lanes::lanes(&end, lane)]).collect()
    }

    fn variation(&self, lane: usize, ends: &[[f64; D]; 2]) -> Vec<SegmentVariation<D>> {
        self.variation_impl(lane, ends)
    }

    fn condense_lateral(&self, moduli: &[Vec<Moduli<f64, 6>>]) -> Vec<LateralEnds> {
        self.condense_lateral_impl(moduli)
    }

    fn set_ends(&mut self, poses: &[f64], joints: [usize; 2]) {
        T::run(TakePoses { chain: self, poses, joints });
    }

    fn advance(&mut self, motions: &[f64], joints: [usize; 2], next: Option<&dyn Pack<D>>) {
        T::run(condense::Advance { chain: self, motions, joints, next });
    }

    fn carried(&self, lane: usize, end: usize, from: &Placement) -> Placement {
        self.carried_impl(lane, end, from)
    }

    fn place_nodes(&mut self, by: NodesBy, next: Option<&dyn Pack<D>>) {
        match by {
            NodesBy::Elements => T::run(unroll::Unroll { chain: self, next }),
            NodesBy::Increments => {
                let inner = 1..self.frames.len();
                for (node, increment) in self.state.nodes[inner.clone()].iter_mut().zip(&self.increments[inner]) {
                    B::advance(node, increment);
                }
            }
        }
    }

    fn sizes(&self, lane: usize) -> [Size; 2] {
        self.sizes.of(lane)
    }

    fn prefetch(&self, task: Task, element: usize) {
        self.prefetch_impl(task, element);
    }

    fn save(&self, row: &mut Vec<f64>) {
        self.save_impl(row);
    }

    fn restore(&mut self, row: &[f64], part: f64) {
        T::run(state::Restore { chain: self, row, part });
    }

    fn enrich(&mut self, row: &[f64], from: &PackMesh) {
        self.enrich_impl(row, from);
    }

    fn distances(&self, row: &[f64]) -> [Size; MOST_LANES] {
        self.distances_impl(row)
    }

    fn predict(&mut self, [before, last]: [&[f64]; 2], ratio: f64, bend: Option<(&[f64], f64)>) {
        T::run(state::Predict { chain: self, before, last, ratio, bend });
    }

    fn node(&self, lane: usize, index: usize) -> Placement {
        B::pose(&self.state.nodes[index], lane)
    }

    fn local(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES] {
        self.local_impl(lane, element)
    }

    fn stress(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES] {
        self.stress_impl(lane, element)
    }

    fn set_element(&mut self, lane: usize, element: usize, state: &NewState<'_, D>) {
        self.set_element_impl(lane, element, state);
    }

    fn strains(&self, lane: usize, element: usize) -> [[f64; D]; MOST_NODES] {
        self.strains_impl(lane, element)
    }

    fn measures(&self) -> Vec<Measures> {
        self.measures_impl()
    }

    fn violation(&self) -> f64 {
        self.violation_impl()
    }

    fn lean(&self) -> f64 {
        self.lean_impl()
    }

    fn carried_forces(&self) -> [f64; MOST_LANES] {
        self.carried_forces_impl()
    }
}
