//! The elements of one member in a row, and the elimination of its interior.
//!
//! A [`Chain`] owns what belongs to its members alone: geometry, section stiffness, the state of interior nodes and the
//! factors of their elimination. Inside an element the nodes between its ends are eliminated first, block by block,
//! then the element ends from the start of the member to its end. What is left is a stiffness between the two ends of
//! the member. Members of equal mesh may lie side by side in the lanes of `T`.

use pennate_elements::beam::{At, Beam, Ends, Moduli, Piece};
use pennate_elements::interpolation::{Table, node};
use pennate_elements::laws::LocalLaw;
use pennate_elements::real::Real;
use pennate_elements::small::{Ldl, M3, V3, scale, zeros};

mod ahead;
mod condense;
mod dashpots;
mod element;
mod fibres;
mod geometry;
mod held;
mod lanes;
mod lateral;
mod layers;
mod measures;
pub mod member;
mod mesh;
mod pack;
mod rows;
mod scratch;
mod sections;
mod shape;
mod side;
mod size;
mod state;
mod strains;
mod transfer;
mod unroll;
mod variation;
mod work;

pub use ahead::Task;
pub use condense::ROUNDING;
use dashpots::Dashpots;
pub use element::{ElementState, SegmentState, Unloaded, element, place, sample};
pub use fibres::Fibres;
pub use geometry::Bent;
use geometry::{Curve, Geometry};
pub use held::{HeldForce, add_held_force, held_force};
pub use lateral::LateralEnds;
pub use layers::variations;
pub use measures::Measures;
pub use mesh::{ChainMesh, PackMesh, SegmentMesh};
pub use pack::{Drawn, InnerNode, Interior, MemberEnds, NodesBy, Pack, Settings, any};
pub use rows::{EndPlaces, EndRows, OwnRows};
pub use sections::sections;
pub use shape::{Middle, middle, shape};
pub use side::{Part, Side};
pub use size::Size;
use size::Sizes;
pub use transfer::{NewNodes, NewState, adopt, lift, prolong};
pub use variation::SegmentVariation;
pub use work::{load_work, total_load};

/// No number has more lanes.
pub const MOST_LANES: usize = 8;
/// No element has more nodes after its first one.
pub const MOST_NODES: usize = 5;

/// What changes in a chain during a solve.
#[derive(Clone, Debug, Default)]
struct ChainState<Pose, T, const D: usize> {
    /// Element ends.
    nodes: Vec<Pose>,
    /// Local unknowns, P an element; the last, those of the element's end, say where that goes to in a move.
    local: Vec<[T; D]>,
    /// Mixed stresses at the Gauss points, P an element.
    stress: Vec<[T; D]>,
}

/// How an element end that was eliminated follows the start of the member and the end after it.
#[derive(Clone, Copy, Debug)]
struct NodeFactor<T, const D: usize> {
    left: [[T; D]; D],
    next: [[T; D]; D],
    rest: [T; D],
}

/// Factors of the blocks themselves, which only forces that come later need; empty unless they are to be kept.
#[derive(Clone, Debug)]
struct KeptFactors<T, const D: usize> {
    /// Of element ends.
    own: Vec<Ldl<T, D>>,
    /// Of the nodes inside the elements.
    inner_own: Vec<Ldl<T, D>>,
}

impl<T, const D: usize> Default for KeptFactors<T, D> {
    fn default() -> Self {
        Self { own: Vec::new(), inner_own: Vec::new() }
    }
}

/// Chains of equal mesh with elements of order P.
#[derive(Debug)]
pub struct Chain<T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    mesh: PackMesh,
    table: Table<P>,
    /// One a segment of straight members, whose elements are all alike there, one an element of curved ones.
    pieces: Vec<Piece<T>>,
    /// Gauss frames and unloaded local positions of nodes 1…P; empty for straight members.
    curves: Vec<Curve<T, P>>,
    /// Distances of the outermost fibres along axes 2 and 3 in every segment, and one where it has corners.
    fibres: Vec<[T; 3]>,
    moduli: Vec<Moduli<T, D>>,
    loads: Vec<V3<T>>,
    loaded: bool,
    settings: Settings,
    state: ChainState<B::Pose, T, D>,
    frames: Vec<B::Frame>,
    /// Elimination inside the elements: blocks x_ij, j > i, right-hand sides, and turn columns where there are loads along the
    /// member. None of an element before its first elimination.
    inner: Vec<[[T; D]; D]>,
    inner_rest: Vec<[T; D]>,
    inner_turn: Vec<[[T; 3]; D]>,
    factors: Vec<NodeFactor<T, D>>,
    kept: KeptFactors<T, D>,
    ends: Ends<T, D>,
    /// Forces on the ends that the mixed stresses make, with the loads along the first element and the last one.
    mixed: [[T; D]; 2],
    increments: Vec<[T; D]>,
    negative: T,
    /// The largest diagonal entry over the pivot that elimination left of it.
    softest: T,
    /// Diagonals of the tangents of the outermost elements at their last node, in local axes.
    bare: [[T; D]; 2],
    energy: T,
    total_length: T,
    /// From the start of the member to its end where it is unloaded, in global axes.
    chord: V3<T>,
    /// Where the local unknowns of the elements carry the end, if the start is where it was unloaded.
    reach: B::Pose,
    sizes: Sizes<T>,
    dashpots: Dashpots<T, D>,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    const INNER_BLOCKS: usize = P * (P - 1) / 2;
    const INNER_NODES: usize = P - 1;
    /// Translations of a node.
    const TRANSLATIONS: usize = if D == 6 { 3 } else { 2 };

    /// Chains of as many members as `T` has lanes (the last is repeated where there are fewer), all of equal mesh.
    pub fn new(meshes: &[ChainMesh]) -> Self {
        let mut chain = Self::without_factors(meshes);
        let elements = chain.frames.len();
        chain.inner = Vec::with_capacity(elements * Self::INNER_BLOCKS);
        chain.inner_rest = Vec::with_capacity(elements * Self::INNER_NODES);
        chain.factors = Vec::with_capacity(elements - 1);
        chain
    }

    /// The same without what elimination fills.
    fn without_factors(meshes: &[ChainMesh]) -> Self {
        let table = Table::new();
        let mesh = PackMesh::new(T::LANES, B::Law::FORMULATION, &table, meshes);
        let Geometry { pieces, curves, fibres, total_length, chord } = Geometry::<T, P>::new(meshes, &mesh);
        let (elements, segments) = (mesh.elements(), mesh.segments());
        let state = ChainState {
            nodes: vec![B::Pose::default(); elements + 1],
            local: vec![[T::zero(); D]; elements * P],
            stress: vec![[T::zero(); D]; elements * P],
        };
        let frame = B::frame(&pieces[0], &state.nodes[0], &state.nodes[1]);
        let o = T::zero();
        Self {
            mesh,
            table,
            pieces,
            curves,
            fibres,
            moduli: vec![Moduli::default(); segments],
            loads: vec![[o; 3]; segments],
            loaded: false,
            settings: Settings::default(),
            state,
            frames: vec![frame; elements],
            inner: Vec::new(),
            inner_rest: Vec::new(),
            inner_turn: Vec::new(),
            factors: Vec::new(),
            kept: KeptFactors::default(),
            ends: Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [o; D], r1: [o; D] },
            mixed: [[o; D]; 2],
            increments: vec![[o; D]; elements + 1],
            negative: o,
            softest: T::one(),
            bare: [[o; D]; 2],
            energy: o,
            total_length,
            chord,
            reach: B::Pose::default(),
            sizes: Sizes::default(),
            dashpots: Dashpots::default(),
        }
    }

    /// See [`Pack::renew`]: what the elimination writes before it is read stays where it is.
    fn renew_impl(&mut self, meshes: &[ChainMesh]) -> bool {
        let segments = &meshes[0].segments;
        let elements: usize = segments.iter().map(|segment| segment.elements).sum();
        if meshes.len() > T::LANES || segments.len() != self.mesh.segments() || elements != self.frames.len() {
            return false;
        }
        self.mesh = PackMesh::new(T::LANES, B::Law::FORMULATION, &self.table, meshes);
        let Geometry { pieces, curves, fibres, total_length, chord } = Geometry::<T, P>::new(meshes, &self.mesh);
        let o = T::zero();
        (self.pieces, self.curves, self.fibres) = (pieces, curves, fibres);
        (self.total_length, self.chord, self.reach) = (total_length, chord, B::Pose::default());
        self.moduli.fill(Moduli::default());
        self.loads.fill([o; 3]);
        self.loaded = false;
        self.settings = Settings { keeps_factors: self.settings.keeps_factors, ..Settings::default() };
        self.inner_turn.clear();
        self.state.nodes.fill(B::Pose::default());
        self.state.local.fill([o; D]);
        self.state.stress.fill([o; D]);
        self.increments.fill([o; D]);
        (self.negative, self.softest, self.energy) = (o, T::one(), o);
        self.bare = [[o; D]; 2];
        self.sizes = Sizes::default();
        self.dashpots = Dashpots::default();
        true
    }

    /// Unloaded geometry of an element.
    #[inline(always)]
    fn piece(&self, element: usize) -> &Piece<T> {
        let index = if self.curves.is_empty() { self.mesh.segment_of[element] } else { element };
        &self.pieces[index]
    }

    #[inline(always)]
    fn curved(&self, element: usize) -> Option<&[M3<T>; P]> {
        self.curves.get(element).map(|curve| &curve.frames)
    }

    /// Unloaded local position of node i + 1 of an element.
    #[inline(always)]
    fn reference(&self, element: usize, i: usize) -> V3<T> {
        match self.curves.get(element) {
            Some(curve) => curve.nodes[i],
            None => scale(T::splat(node(i + 1, P)), self.piece(element).chord),
        }
    }

    /// Local unknowns of an element, the last node's from its frame.
    #[inline(always)]
    fn local_of(&self, element: usize, frame: &B::Frame) -> [[T; D]; P] {
        let mut local = [[T::zero(); D]; P];
        let all: &[[T; D]; P] = &self.state.local.as_chunks().0[element];
        local[..P - 1].copy_from_slice(&all[..P - 1]);
        local[P - 1] = B::last_local(frame);
        local
    }

    #[inline(always)]
    fn stress_of(&self, element: usize) -> &[[T; D]; P] {
        &self.state.stress.as_chunks().0[element]
    }

    /// What an element is evaluated at, with these local unknowns.
    #[inline(always)]
    fn at<'a>(&'a self, element: usize, local: &'a [[T; D]; P]) -> At<'a, T, D, P> {
        At {
            table: &self.table,
            piece: self.piece(element),
            curved: self.curved(element),
            moduli: &self.moduli[self.mesh.segment_of[element]],
            local,
            stress: self.stress_of(element),
        }
    }
}
