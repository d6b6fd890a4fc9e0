//! Steps and their paths: what moves, how far at once, and what is believed.
//!
//! A step is a ramp of loads, and its equilibria are a path. The loop in `follow.rs` goes along it: **predictor** and
//! **corrector** by the fraction of the ramp (`fraction.rs`) or by the length of the arc (`arc.rs`), both with the Newton
//! iteration of `newton.rs`; **acceptance** (`passage.rs`, `acceptance.rs`); **events** on the way (`events.rs`), **located** as roots of test
//! functions (`locate.rs`); the way on along a **branch** (`branch.rs`) or by a **release** of energy (`release.rs`).
//! All numbers that steer it stand in `tuning.rs`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::base::Judges;
use crate::chain;
use crate::compliance;
use crate::error::{FreeMotion, NearMotion};
use crate::history::{Equilibrium, History, MeshSize, Note, Status, StepHistory, Variation};
use crate::joints::Held;
use crate::newton::{Aim, Newton, Start};
use crate::options::{Options, Progress};
use crate::results;
use crate::structure::{Dimension, NodeId, Step};
use crate::system::{Answer, Inertia, State, System};

mod acceptance;
mod arc;
mod beginning;
mod between;
mod branch;
mod coarse;
mod crowded;
mod direction;
mod distance;
mod events;
mod follow;
mod foretold;
mod fraction;
mod held;
mod inside;
mod locate;
mod meeting;
mod passage;
mod ramp;
mod record;
mod release;
mod taut;
mod touching;
mod tuning;
mod verdict;

pub use beginning::Beginning;
pub use coarse::Coarse;
use coarse::End;
use follow::{Effort, Request, Run};
pub use held::{first_rows, topology};
pub use passage::{Passage, Verdict};
pub use ramp::Ramp;
pub use taut::STRAIGHT;
pub use tuning::Tuning;

/// Which rows are held, by node and component.
pub(crate) type HeldRows = BTreeMap<(NodeId, usize), Held>;

/// What a plane system asks about its stability out of the plane.
pub trait OutOfPlane<const D: usize> {
    /// Pivots at the last assembly, and whether the loads have a potential there; a count above `known` is looked at
    /// twice.
    fn confirmed(&mut self, plane: &mut System<D>, known: usize) -> (Inertia, bool);
    /// The same without a second look.
    fn inertia(&mut self, plane: &mut System<D>) -> (Inertia, bool);
    /// Whether all motions out of the plane have a stiffness at the last assembly, and more than rounding explains.
    fn is_held(&mut self, plane: &mut System<D>) -> bool;
    /// Motions of the network, free to leave its plane, of which rounding hides the sign of the stiffness.
    fn hidden_signs(&mut self, plane: &mut System<D>) -> usize;
    /// The overall stiffness out of the plane at the last of these, times the part that elimination left of the softest pivot.
    fn overall_stiffness(&mut self) -> Option<f64>;
    /// The softest motion of the last of these.
    fn softest(&mut self) -> Vec<f64>;
    /// A number that passes zero where the tangent out of the plane is singular.
    fn singular_test(&mut self, b: &[f64]) -> Option<f64>;
    /// Motions of all joints that a solution of the equations out of the plane means.
    fn motions_of(&self, solution: &[f64]) -> Vec<[f64; 6]>;
    /// Begins anew with another network of the same topology; false where it cannot, and is of no use any more.
    fn renew(&mut self, plane: &System<D>) -> bool;
}

/// The most that an increment turns what is held (radians). Rotations are the same after a whole turn: what is turned by more than
/// half a one may come to where it should by the other way round, an element as well as a crank, which has two dead centres a turn.
pub const QUARTER_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Follows the steps of a structure.
pub struct Continuation<'a, const D: usize> {
    /// The structure in its present state.
    pub system: System<D>,
    /// The last accepted state, the one before it, and one ahead that is looked at.
    last: State,
    before: State,
    next: State,
    /// The tangent out of the plane, where stability is judged there.
    pub lateral: Option<Box<dyn OutOfPlane<D> + 'a>>,
    /// Judges states that the tangent does not tell the stability of, where verdicts are asked for.
    pub judges: Option<Judges<D>>,
    /// The same structure with elements of the next order.
    pub refined: Option<System<D>>,
    /// Whether that stands at the end of the last step, and how far what it holds there is from what these elements hold.
    refined_stands: bool,
    refined_held: BTreeMap<(NodeId, usize), f64>,
    /// Makes it when it is first needed.
    pub make_refined: Option<Box<dyn Fn() -> System<D> + 'a>>,
    /// The same structure on a coarser mesh, and what became of it.
    pub coarse: Option<(Coarse<D>, &'a [StepHistory])>,
    /// Whether a step was followed on this mesh, and the state at its end may be another than that of the coarser one.
    is_apart: bool,
    /// See [`History::near_motion`].
    pub near: Option<NearMotion>,
    /// Whether ends of steps are kept for a finer mesh.
    pub keeps: bool,
    /// See [`Coarse::ends`].
    pub ends: Vec<End>,
    /// Whether increments of each step so far were cut short.
    cut: Vec<bool>,
    /// See [`Coarse::refined_ends`].
    pub refined_ends: Vec<End>,
    /// What was asked for.
    pub options: Options,
    /// What is to be said of the solve.
    pub notes: Vec<Note>,
    /// Where stability is judged.
    pub stability: Dimension,
    held: HeldRows,
    /// Axes of the supports, by node.
    axes: HashMap<NodeId, [[f64; 3]; 3]>,
    tuning: Tuning,
    newton: Newton,
    base: Count,
    /// Where the first step began, if it holds a component where that is, or moves it on from there.
    pub beginning: Option<Beginning>,
    /// Whether the unloaded structure has motions that nothing resists but, perhaps, its prestress.
    is_loose: bool,
    /// Motions that the prestress does not resist either: nothing is followed where there are any.
    pub free: Vec<FreeMotion>,
    /// Pivots of the unloaded structure, as long as its assembly is the last one.
    at_rest: Option<Inertia>,
    /// How far the network was from where it is unloaded when the step began, as `Places::moved`.
    moved_at_start: f64,
    /// How the network answers where a step begins, as long as nothing was followed from there.
    first_answer: Option<Answer>,
    /// The largest overall stiffness out of the plane of all states that were looked at.
    stiffest_aside: f64,
    /// How the overall stiffness went along the present step.
    way: coarse::Way,
    /// Whether rounding hides the sign of the lowest stiffness at the end of the last step.
    undecided: bool,
    /// Whether so many motions were unstable that singular points were counted alone.
    is_crowded: bool,
}

/// How far a run has come.
struct SoFar {
    /// Whether all steps reached their ends.
    going: bool,
    /// Whether the pivots of the state that a step begins with are known; a step whose end is known from a coarser mesh does
    /// not ask.
    counted: bool,
    /// Whether a step needed more than one increment.
    winding: bool,
}

/// Negative pivots in the equations and out of the plane, and the sign of the full determinant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Count {
    own: usize,
    lateral: usize,
    odd: bool,
    potential: bool,
    lateral_potential: bool,
    /// The overall stiffness out of the plane; nothing without one.
    lateral_stiffness: f64,
    smallest: f64,
    neutral: bool,
}

impl Count {
    /// Negative pivots where they say whether a state is stable: those out of the plane only under loads that have a
    /// potential there.
    fn negative(&self) -> usize {
        self.own + if self.lateral_potential { self.lateral } else { 0 }
    }
}

impl<'a, const D: usize> Continuation<'a, D> {
    /// A path from the present state of a system.
    pub fn new(mut system: System<D>, options: Options) -> Self {
        system.ease();
        let structure = Arc::clone(&system.structure);
        let tuning = options.tuning;
        let mut path = Self {
            system,
            last: State::default(),
            before: State::default(),
            next: State::default(),
            lateral: None,
            judges: None,
            refined: None,
            make_refined: None,
            coarse: None,
            is_apart: false,
            near: None,
            keeps: false,
            ends: Vec::new(),
            cut: Vec::new(),
            refined_ends: Vec::new(),
            options,
            notes: Vec::new(),
            stability: structure.dimension,
            held: HeldRows::new(),
            axes: structure.supports.iter().map(|support| (support.node, support.axes)).collect(),
            newton: Newton::new(tuning),
            tuning,
            base: Count::default(),
            beginning: None,
            is_loose: false,
            refined_stands: false,
            refined_held: BTreeMap::new(),
            free: Vec::new(),
            at_rest: None,
            moved_at_start: 0.0,
            first_answer: None,
            stiffest_aside: 0.0,
            way: coarse::Way::default(),
            undecided: false,
            is_crowded: false,
        };
        for support in &structure.supports {
            for component in 0..6 {
                if support.fixed[component] {
                    path.insert(support.node, component, 0.0, 0.0);
                }
            }
        }
        path
    }

    /// Follows all steps; `observe` may stop the solve by returning false.
    pub fn run(&mut self, steps: &[Step], observe: &mut dyn FnMut(&Progress) -> bool) -> History {
        let mut history = History { mesh: self.mesh_size(), near_motion: self.near.take(), ..History::default() };
        let total = steps.len().max(1);
        let mut so_far = SoFar { going: true, counted: false, winding: false };
        for index in 0..total {
            let notes = std::mem::take(&mut self.notes);
            let mut record = StepHistory { notes, ..StepHistory::empty(self.stability) };
            if !so_far.going {
                record.status = Status::NotReached;
                record.stable = None;
                history.steps.push(record);
                continue;
            }
            let mut watch = |fraction: f64| observe(&Progress { step: index, steps: total, fraction });
            if index == 0 {
                let brings_prestress = self.is_prestressed() && self.system.loading.prestress < 1.0;
                self.begin_first(steps, &mut record, &mut watch, &mut so_far);
                // Elements of the next order come somewhere else by the prestress than these, and are held there.
                if brings_prestress && self.beginning.is_some() && self.options.estimate && !self.options.rough {
                    let start = (self.options.clock)();
                    self.refined_stands = self.refine().is_some();
                    history.estimate += (self.options.clock)().saturating_sub(start);
                }
            }
            if let Some(step) = steps.get(index).filter(|_| so_far.going) {
                self.follow_step(index, steps, step, &mut record, &mut watch, &mut so_far);
            }
            let is_last = index + 1 == total;
            self.note_end(&mut record, is_last);
            so_far.winding |= record.increments.len() > 1;
            let mut refined_end = End::Unfit;
            self.refined_stands = false;
            if so_far.going && self.options.estimate && (so_far.winding || !self.options.rough) {
                let start = (self.options.clock)();
                if let Some((state, missing, negative)) = self.refine() {
                    self.note_other_verdict(&mut record, negative);
                    record.refined = Some(state);
                    record.missing = missing;
                    self.refined_stands = true;
                    refined_end = self.refined_end(is_last);
                }
                history.estimate += (self.options.clock)().saturating_sub(start);
            }
            self.refined_ends.push(refined_end);
            history.steps.push(record);
        }
        self.let_turn();
        history
    }

    /// Leaves the end of the last step as it is: with nothing that resists turning.
    fn let_turn(&mut self) {
        for system in [Some(&mut self.system), self.refined.as_mut()].into_iter().flatten() {
            if !std::mem::take(&mut system.turning).is_empty() {
                system.assemble(false);
            }
        }
    }

    /// Follows a step of the user's.
    fn follow_step(
        &mut self,
        index: usize,
        steps: &[Step],
        step: &Step,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        so_far: &mut SoFar,
    ) {
        let prestressed = self.is_prestressed();
        let held_before: Vec<_> = self.held.keys().copied().collect();
        if index > 0 || !step.changes.is_empty() || prestressed {
            self.take_over_errors(&step.changes);
            self.change(&step.changes);
        }
        if !self.held.keys().eq(&held_before) {
            self.start_count(record);
            so_far.counted = true;
        }
        self.moved_at_start = self.system.places.moved::<D>(self.system.size);
        let from = self.system.loading.drives.clone();
        let mut to = from.clone();
        for &(drive, value) in &step.targets {
            to[drive] = value;
        }
        let longest = longest_asked(step).min(self.longest_turn());
        let ramp = Ramp::of_drives(from, to);
        let mut run = Run {
            ramp: &ramp,
            longest,
            record: &mut *record,
            watch,
            request: Request { method: step.method, branch: step.branch, stop: step.stop },
            is_step: true,
            conservative: true,
            landmarks: self.landmarks_of_coarse(index),
            is_nearly_symmetric: false,
            turns: Vec::new(),
            firmest: Vec::new(),
            effort: Effort::default(),
        };
        self.way = self.way_on_this_mesh(index);
        let turned = std::mem::take(&mut self.system.turning);
        self.system.turning = self.system.may_be_turned([&ramp.drives[0], &ramp.drives[1]]);
        run.turns = turned;
        run.turns.retain(|part| !self.system.turning.contains(part) && self.system.has_left(part));
        let known = !prestressed && !self.is_apart && self.end_from_coarse(&mut run, index, step);
        self.is_apart |= !known;
        if index + 1 == steps.len() {
            self.coarse = None; // what follows needs its memory
        }
        if !known {
            if !so_far.counted {
                self.start_count(run.record);
            }
            run.conservative = self.is_conservative(&ramp);
        }
        so_far.counted = true;
        so_far.going = known || self.follow(&mut run);
        self.first_answer = None;
        self.judge_end(&ramp, record);
        self.judge_spins(record);
    }

    /// The part of a ramp that turns nothing that is held by more than a quarter turn; equal ones make the whole.
    fn longest_turn(&self) -> f64 {
        let turns = self.held.values().filter(|held| held.component > 2).map(|held| (held.to - held.from).abs());
        1.0 / (turns.fold(0.0, f64::max) / QUARTER_TURN).ceil().max(1.0)
    }

    /// Whether the present step began at the unloaded network.
    fn began_at_rest(&self) -> bool {
        self.moved_at_start == 0.0
    }

    /// Whether the loads have a potential along the whole of a ramp; the state is left at its beginning.
    ///
    /// Loads that lack one on the way lack it at an end: at the last where they grow, at the first where they fade.
    fn is_conservative(&mut self, ramp: &Ramp) -> bool {
        let mut has_potential = |fraction: f64| {
            ramp.apply(&mut self.system, fraction);
            self.system.loads_have_potential()
        };
        let conservative = has_potential(1.0);
        has_potential(0.0) && conservative
    }

    /// Notes what is to be said of the end of a step, and keeps the state for a finer mesh.
    fn note_end(&mut self, record: &mut StepHistory, is_last: bool) {
        if let Some(node) = self.system.endless_moment() {
            record.notes.push(Note::EndlessMoment { node });
        }
        self.note_whole_turns(record);
        self.keep_end(record, is_last);
        self.note_undetermined(record);
        self.note_turned(record);
        if record.stability != self.stability {
            record.notes.push(Note::NoPotentialOutOfPlane);
        }
    }

    fn mesh_size(&self) -> MeshSize {
        mesh_size(&self.system)
    }

    /// How fast the present state may vary along the elements of every member.
    fn variations(&self) -> Vec<Vec<Variation>> {
        self.system.members.chains().map(|(pack, lane)| chain::variations(pack, lane)).collect()
    }

    /// Notes where elements of the next order, whose state has just been found with so many negative pivots, have another verdict, or
    /// would have if what they change once more is taken away. What a plane network does out of its plane is not asked.
    fn note_other_verdict(&mut self, record: &mut StepHistory, other: usize) {
        let own = self.base.own;
        let Some(refined) = self.refined.as_mut().filter(|_| record.stable.is_some() && self.base.potential) else {
            return;
        };
        let differs = own != other && (other < own || refined.certain_negative() > own);
        if crowded::is_crowd(own.min(other))
            && let Some(crowd) = crowded::noted(record)
        {
            // Both have far more than one: the verdict is the same, and how many there are is said of both.
            crowd.other = differs.then_some(other);
            return;
        }
        // A step that ends at a singular point says so.
        let near = !differs && own == other && record.stable == Some(true) && record.status == Status::Converged;
        if differs || near && self.system.is_far_stiffer(refined) {
            record.stable = None;
            record.notes.push(Note::TooCoarse);
        }
    }

    /// The present equilibrium on elements of the next order, what the members lack for it, and its negative pivots.
    fn refine(&mut self) -> Option<(Equilibrium, Vec<f64>, usize)> {
        if self.refined.is_none() {
            self.refined = self.make_refined.take().map(|make| make());
        }
        let refined = self.refined.as_mut()?;
        refined.loading.fading.clone_from(&self.system.loading.fading);
        refined.loading.auxiliary = self.system.loading.auxiliary;
        refined.turning.clone_from(&self.system.turning);
        refined.hold_like(&self.system);
        if !self.refined_held.is_empty() {
            let apart = |held: &Held| self.refined_held.get(&(held.node, held.component)).copied().unwrap_or(0.0);
            refined.hold(self.held.values().map(|held| held.shifted(apart(held))).collect());
        }
        refined.prolong(&self.system);
        // Compliances are those of the equilibrium itself, and so are pivots where any of them is small for the loads.
        let firm = self.base.own == 0 && self.system.tangent.is_firm() && refined.structure.compliances.is_empty();
        let start = Start { aim: Aim::Comparison, reuses_factors: firm.then_some(0.0), ..Start::nearby() };
        let found = self.newton.solve(refined, start).ok()?;
        let mut state = results::equilibrium(refined);
        state.compliances = compliance::of_nodes(refined);
        let missing = state.members.iter().map(|member| member.top_energy).collect();
        Some((state, missing, found.inertia.negative))
    }
}

/// The longest part of a ramp that a step asks for; its prestress comes in by as many increments.
fn longest_asked(step: &Step) -> f64 {
    step.min_increments.map_or(1.0, |count| 1.0 / count.max(1) as f64)
}

/// How large the mesh of a system is.
pub(crate) fn mesh_size<const D: usize>(system: &System<D>) -> MeshSize {
    let structure = &system.structure;
    let per_node = if D == 3 { 3 } else { 6 };
    let mut elements = 0;
    let mut interior = 0;
    for member in &structure.members {
        let count: usize = member.segments.iter().map(|s| s.elements.max(1)).sum();
        elements += count;
        interior += count * member.order - 1;
    }
    MeshSize {
        nodes: structure.nodes.len() + interior,
        elements,
        unknowns: system.pattern.equations.size + per_node * interior,
    }
}
