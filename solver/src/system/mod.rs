//! Residual and tangent of the joints; owns every large buffer.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pennate_elements::small::norm;

use crate::chain::Pack;
use crate::held::HeldForces;
use crate::joints::{Active, Held, Kept, Topology};
use crate::linear::Symmetric;
use crate::structure::{MemberId, SectionLaw, SectionState, Structure};

mod adopt;
mod advance;
mod after;
mod answer;
mod assembly;
mod beside;
mod carriers;
mod certain;
mod dashpots;
mod explicit;
mod linearized;
mod loading;
mod loads;
mod members;
mod middles;
mod moves;
mod parts;
mod pattern;
mod places;
mod posture;
mod relative;
mod remainder;
mod renew;
mod scatter;
mod side;
mod skew;
mod spins;
mod springs;
mod states;
mod strains;
mod symmetry;
mod tangent;
mod turning;
mod untaken;

pub use answer::Answer;
use dashpots::Dashpots;
pub(crate) use dashpots::Inner;
pub use linearized::Linearized;
pub use loading::{Fading, Loading, NodeLoad};
pub use members::{MemberSlot, Members};
pub(crate) use middles::between;
pub use moves::Moves;
pub use pattern::Pattern;
pub use places::Places;
use side::{Rows, Side};
use spins::Spinning;
pub use spins::Spins;
pub(crate) use spins::spins_of;
pub use states::State;
pub(crate) use symmetry::{Holds, Turning};
pub use tangent::{Inertia, Residual, Tangent};
pub(crate) use untaken::Untaken;

/// The equations of a structure in D components a joint, split by what lives how long.
pub struct System<const D: usize> {
    /// For ever; section laws are replaced by [`System::set_laws`] alone: members that are as they were keep their stiffness.
    pub structure: Arc<Structure>,
    /// For ever: the structure as joints and member ends.
    pub topology: Arc<Topology>,
    /// For ever: largest extent of the unloaded structure along an axis.
    pub size: f64,
    /// As long as the same rows are held: which motions are free, and where everything goes in the matrix.
    pub pattern: Pattern<D>,
    /// The state, where members meet: where joints and released ends are.
    pub places: Places,
    /// The state, between the ends of members; and what every member is eliminated to.
    pub members: Members<D>,
    /// The state of the drives, and what they make of sections and loads.
    pub loading: Loading,
    /// An assembly: residual and factors at the state it was made at.
    pub tangent: Tangent<D>,
    /// An increment of an iteration: what it moved.
    pub moves: Moves,
    /// Memory of the last solve, of forces that held rows bear.
    pub held_forces: HeldForces,
    dashpots: Dashpots,
    /// The parts that may be turned in the present step without anything changing.
    pub(crate) turning: Vec<Turning>,
    /// Lines of bars that are let spin about themselves against a weak spring, where it is asked whether they would: else none.
    spinning: BTreeMap<Kept, Spinning>,
    /// Memory of what lies in rows.
    side_rows: Rows,
    /// Memory of a state that an iteration comes back to.
    pub(crate) aside: State,
    /// See [`crate::options::Options::stop`].
    pub stop: Option<Arc<AtomicBool>>,
    /// Whether nodes move straight along a solution, each on its own, instead of being carried by their members.
    pub straight: bool,
}

impl<const D: usize> System<D> {
    /// A structure at rest, with the chains of its members.
    pub fn new(
        structure: Arc<Structure>,
        topology: Arc<Topology>,
        packs: Vec<Box<dyn Pack<D>>>,
        active: Active<D>,
        parallel: bool,
    ) -> Self {
        let (joints, members) = (topology.references.len(), structure.members.len());
        let pattern = Pattern::new(&structure, &topology, active);
        let mut system = Self {
            size: extent(&structure.nodes),
            places: Places::unloaded(joints, members),
            members: Members::new(&structure, &topology, packs, parallel),
            loading: Loading::new(&structure, &topology),
            tangent: Tangent::new(joints, members, structure.springs.len()),
            moves: Moves::new(joints, members, pattern.parts.count),
            held_forces: HeldForces::default(),
            dashpots: Dashpots::default(),
            turning: Vec::new(),
            spinning: BTreeMap::new(),
            side_rows: Rows::default(),
            aside: State::default(),
            stop: None,
            straight: false,
            pattern,
            topology,
            structure,
        };
        system.apply_drives();
        system
    }

    /// Whether nobody wants to wait any longer.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Sets what is held; analyses the equations anew where that is not the same as before.
    pub fn hold(&mut self, held: Vec<Held>) {
        let moved = self.find_idle(&held);
        self.pattern.find_loaded_nodes(&self.structure, &self.loading.fading);
        if self.pattern.hold(&self.topology, held, moved) {
            self.analyse();
        } else {
            self.renew_carriers();
        }
    }

    /// The same by the analysis of another system of the same joints, where the equations of both are alike.
    pub fn hold_by(&mut self, held: Vec<Held>, other: &Self) {
        let moved = self.find_idle(&held);
        self.pattern.find_loaded_nodes(&self.structure, &self.loading.fading);
        if !self.pattern.hold(&self.topology, held, moved) {
            self.renew_carriers();
        } else if self.pattern.equations.are_like(&other.pattern.equations) {
            self.take_analysis(other);
        } else {
            self.analyse();
        }
    }

    /// Everything that is held, what no motion of these elements concerns too: of plane ones what is held out of the plane.
    pub fn held(&self) -> Vec<Held> {
        self.pattern.equations.held.iter().chain(&self.pattern.aside).copied().collect()
    }

    /// Holds what another system of the same joints holds; its analysis, which no number depends on, serves both.
    pub fn hold_like(&mut self, other: &Self) {
        self.pattern.find_loaded_nodes(&self.structure, &self.loading.fading);
        let held = other.held();
        let moved = self.find_idle(&held);
        if self.pattern.hold(&self.topology, held, moved) {
            self.take_analysis(other);
        } else {
            self.renew_carriers();
        }
    }

    /// Finds which motions no force belongs to where these rows are held; true where joints have others than before.
    fn find_idle(&mut self, rows: &[Held]) -> bool {
        let Some(topology) = self.topology.held_by(&self.structure, rows) else { return false };
        let before = std::mem::replace(&mut self.topology, Arc::new(topology));
        before.idle != self.topology.idle
    }

    /// Finds where everything goes in the matrix of the equations.
    fn analyse(&mut self) {
        let linear = self.pattern.analyse(&self.structure, &self.topology);
        let side = |entries| {
            Side::of(&self.structure, &self.topology, &self.members, &self.pattern.scatters, entries).map(Arc::new)
        };
        self.pattern.side = if self.pattern.in_blocks { side(linear.values.len()) } else { None };
        self.resize(linear);
    }

    /// The same as another system found it for equations like these.
    fn take_analysis(&mut self, other: &Self) {
        self.pattern.scatters = Arc::clone(&other.pattern.scatters);
        self.pattern.layout = other.pattern.layout.clone();
        self.pattern.side = other.pattern.side.clone().filter(|_| self.members.lie_as(&other.members));
        self.check_side();
        self.resize(other.tangent.linear.alike());
    }

    /// Lets members go one by one where those beside each other do not meet their joints as they did where that was found out.
    fn check_side(&mut self) {
        let serves = |side: &Arc<Side>| side.serves(&self.structure, &self.topology, &self.members);
        self.pattern.side = self.pattern.side.take().filter(serves);
    }

    fn resize(&mut self, linear: Symmetric) {
        self.tangent.resize(linear, &self.pattern);
        self.pattern.forget_carriers();
        self.renew_carriers();
    }

    /// Replaces the section laws; they count from the next [`System::apply_drives`].
    pub fn set_laws(&mut self, laws: Vec<Arc<dyn SectionLaw>>) {
        Arc::make_mut(&mut self.structure).laws = laws;
        self.loading.forget_sections();
    }

    /// Brings sections, loads along members and loads on nodes up to date with the drives.
    pub fn apply_drives(&mut self) {
        self.loading.apply(&self.structure, &mut self.members, &self.pattern.parts, self.size);
    }

    /// Eases stiff strains from here on, where there are any: see [`crate::packs::Auxiliary::easing`].
    pub(crate) fn ease(&mut self) {
        if self.loading.is_stiff() {
            self.loading.auxiliary = self.loading.auxiliary.easing();
            self.apply_drives();
        }
    }

    /// Looks at the present state with strains as stiff as they are; it is linearized as it was again afterwards.
    pub(crate) fn uneased<R>(&mut self, look: impl FnOnce(&mut Self) -> R) -> R {
        let auxiliary = self.loading.auxiliary;
        if !auxiliary.eases() {
            return look(self);
        }
        self.loading.auxiliary.eased_from = f64::INFINITY;
        self.apply_drives();
        self.assemble(false);
        let seen = look(self);
        self.loading.auxiliary = auxiliary;
        self.apply_drives();
        self.assemble(false);
        seen
    }

    /// Brings the auxiliary stiffness of held strains up to date with the forces that members carry now; whether that changed
    /// any.
    pub fn follow_carried_forces(&mut self) -> bool {
        let changes = self.loading.is_outgrown(&self.members);
        if changes {
            self.apply_drives();
        }
        changes
    }

    /// Section of a segment at the present control.
    pub(crate) fn section(&self, member: MemberId, segment: usize) -> SectionState {
        self.loading.section(&self.structure, member, segment)
    }

    /// Puts the ends of all chains where their joints are.
    pub fn place_ends(&mut self) {
        let side = self.pattern.side.clone();
        if let Some(side) = &side {
            self.place_side(side);
        }
        let rest = |pack: usize| side.as_ref().is_none_or(|side| !side.has(pack));
        self.members.place_ends(&self.structure, &self.topology, &self.places, rest);
    }
}

/// Largest extent of the network.
fn extent(nodes: &[[f64; 3]]) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in nodes {
        for c in 0..3 {
            low[c] = low[c].min(node[c]);
            high[c] = high[c].max(node[c]);
        }
    }
    let size = norm(std::array::from_fn(|c| if high[c] > low[c] { high[c] - low[c] } else { 0.0 }));
    if size > 0.0 { size } else { 1.0 }
}
