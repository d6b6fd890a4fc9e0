//! Steps and increments: what moves, how far at once, and when an increment is taken back.
//!
//! A step starts with its whole ramp and a linear prediction; an increment is doubled after at most five iterations,
//! shortened after more than seven or a failure. A converged increment with more negative pivots than before is taken
//! back and shortened until it is a small part of the ramp: only then is the loss of stability real, and not a long
//! step onto another branch.

use std::collections::BTreeMap;
use std::sync::Arc;

use pennate_elements::small::{dot, scale};

use crate::chain::Size;
use crate::error::FreeMotion;
use crate::history::{
    Cause, CriticalKind, CriticalPoint, Equilibrium, Failure, History, Increment, MeshSize, Note, Status, StepHistory,
};
use crate::joints::{Held, HeldKind, Topology};
use crate::mechanism;
use crate::newton::{Convergence, Lost, Newton, Start, Why};
use crate::options::{Options, Progress};
use crate::results;
use crate::structure::{Change, Dimension, NodeId, Spring, Step, Structure};
use crate::system::{Fading, Inertia, System};

/// Saved states: the last accepted one, and the one before it.
const LAST: usize = 0;
const BEFORE: usize = 1;

/// A rise of the count of negative pivots within less of the ramp than this is a critical point.
const BRACKET: f64 = 2e-3;
/// Increments are not shortened below this part of the ramp.
const SHORTEST: f64 = 1e-4;

/// Near a fold the state moves ever faster with the loads: by so much more than at first.
const FOLD: f64 = 4.0;

/// Which rows are held, by node and component.
pub type HeldRows = BTreeMap<(NodeId, usize), Held>;

/// Pivots out of the plane at the last assembly of a plane system, and whether its loads have a potential there; takes
/// the number of negative ones that is known already.
pub type LateralInertia<'a, const D: usize> = Box<dyn FnMut(&mut System<D>, usize) -> (Inertia, bool) + 'a>;

/// Follows the steps of a structure.
pub struct Path<'a, const D: usize> {
    pub system: System<D>,
    pub lateral: Option<LateralInertia<'a, D>>,
    /// The same structure with elements of the next order.
    pub refined: Option<System<D>>,
    pub options: Options,
    pub notes: Vec<Note>,
    pub stability: Dimension,
    held: HeldRows,
    newton: Newton,
    base: Count,
    /// Pivots of the unloaded structure, as long as its assembly is the last one.
    at_rest: Option<Inertia>,
}

/// Negative pivots in the equations and out of the plane, and the sign of the full determinant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Count {
    own: usize,
    lateral: usize,
    odd: bool,
    potential: bool,
    lateral_potential: bool,
    smallest: f64,
    neutral: bool,
}

/// The values that a ramp moves.
struct Ramp {
    drives: [Vec<f64>; 2],
    prestress: [f64; 2],
    longest: f64,
}

impl Ramp {
    fn apply<const D: usize>(&self, system: &mut System<D>, fraction: f64) {
        let [from, to] = &self.drives;
        system.fraction = fraction;
        for (value, (from, to)) in system.drives.iter_mut().zip(from.iter().zip(to)) {
            *value = if fraction == 1.0 { *to } else { from + fraction * (to - from) };
        }
        system.prestress = self.prestress[0] + fraction * (self.prestress[1] - self.prestress[0]);
        system.apply_drives();
    }
}

/// Progress of one ramp.
struct Tally {
    iterations: usize,
    factorizations: usize,
    accepted: usize,
}

impl<'a, const D: usize> Path<'a, D> {
    pub fn new(system: System<D>, options: Options) -> Self {
        let structure = Arc::clone(&system.structure);
        let mut path = Self {
            system,
            lateral: None,
            refined: None,
            options,
            notes: Vec::new(),
            stability: structure.dimension,
            held: HeldRows::new(),
            newton: Newton::default(),
            base: Count::default(),
            at_rest: None,
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

    /// Axes in which a node's components are measured.
    fn axes(&self, node: NodeId) -> [[f64; 3]; 3] {
        const GLOBAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.system.structure.supports.iter().find(|s| s.node == node).map_or(GLOBAL, |s| s.axes)
    }

    fn insert(&mut self, node: NodeId, component: usize, from: f64, to: f64) {
        let axis = self.axes(node)[component % 3];
        let kind = if component < 3 { HeldKind::Translation { direction: axis } } else { HeldKind::Rotation { axis } };
        self.held.insert((node, component), Held { node, component, kind, from, to });
    }

    /// Present value of a component.
    fn present(&self, node: NodeId, component: usize) -> f64 {
        let link = &self.system.topology.links[node];
        let joint = &self.system.state.joints[link.joint];
        let axis = self.axes(node)[component % 3];
        if component < 3 {
            dot(axis, joint.point(link.arm))
        } else if D == 3 {
            axis[2] * joint.place.angle
        } else {
            dot(axis, joint.theta)
        }
    }

    /// Applies the changes that a step makes to what is held; gives the reactions that fade.
    fn change(&mut self, changes: &[Change]) {
        for held in self.held.values_mut() {
            held.from = held.to;
        }
        self.system.fading.clear();
        for change in changes {
            match *change {
                Change::Prescribe { node, component, to } => {
                    let from =
                        self.held.get(&(node, component)).map_or_else(|| self.present(node, component), |h| h.to);
                    self.insert(node, component, from, to);
                }
                Change::Hold { node, component } => {
                    let value = self.present(node, component);
                    self.insert(node, component, value, value);
                }
                Change::MoveBy { node, component, by } => {
                    let from = self.present(node, component);
                    self.insert(node, component, from, from + by);
                }
                Change::Free { node, component } => {
                    self.held.remove(&(node, component));
                    let reaction = self.reaction(node, component);
                    self.system.fading.push(reaction);
                }
            }
        }
        self.system.hold(self.held.values().copied().collect());
    }

    fn reaction(&self, node: NodeId, component: usize) -> Fading {
        let equations = &self.system.equations;
        let mut fading = Fading { node, force: [0.0; 3], moment: [0.0; 3] };
        let row = equations.held.iter().position(|h| h.node == node && h.component == component);
        if let Some(index) = row {
            let value = equations.multipliers[index];
            match equations.held[index].kind {
                HeldKind::Translation { direction } => fading.force = scale(value, direction),
                HeldKind::Rotation { axis } => fading.moment = scale(value, axis),
            }
        }
        fading
    }

    /// Follows all steps; `observe` may stop the solve by returning false.
    pub fn run(&mut self, steps: &[Step], observe: &mut dyn FnMut(&Progress) -> bool) -> History {
        let mesh = self.mesh_size();
        let mut history = History { steps: Vec::new(), mesh };
        let rest = self.system.drives.clone();
        let total = steps.len().max(1);
        let prestressed = self.is_prestressed();
        let mut going = true;
        for index in 0..total {
            let mut record = empty_step(self.stability, std::mem::take(&mut self.notes));
            if !going {
                record.status = Status::NotReached;
                record.stable = None;
                history.steps.push(record);
                continue;
            }
            let mut watch = |fraction: f64| observe(&Progress { step: index, steps: total, fraction });
            if index == 0 {
                self.change(&[]);
                self.start_count(&mut record);
                if prestressed {
                    let longest = 1.0;
                    let ramp = Ramp { drives: [rest.clone(), rest.clone()], prestress: [0.0, 1.0], longest };
                    going = self.follow(&ramp, &mut record, &mut watch, steps.is_empty());
                }
            }
            if let (Some(step), true) = (steps.get(index), going) {
                let held_before: Vec<_> = self.held.keys().copied().collect();
                if index > 0 || !step.changes.is_empty() || prestressed {
                    self.change(&step.changes);
                }
                if !self.held.keys().eq(&held_before) {
                    self.start_count(&mut record);
                }
                let from = self.system.drives.clone();
                let mut to = from.clone();
                for &(drive, value) in &step.targets {
                    to[drive] = value;
                }
                let longest = step.min_increments.map_or(1.0, |n| 1.0 / n.max(1) as f64);
                let ramp = Ramp { drives: [from, to], prestress: [1.0, 1.0], longest };
                going = self.follow(&ramp, &mut record, &mut watch, true);
            } else if steps.is_empty() && !prestressed {
                let ramp = Ramp { drives: [rest.clone(), rest.clone()], prestress: [0.0, 1.0], longest: 1.0 };
                going = self.follow(&ramp, &mut record, &mut watch, true);
            }
            if going && self.options.estimate {
                record.refined = self.refine();
            }
            history.steps.push(record);
        }
        history
    }

    /// Motions that the unloaded structure can make without force, with what the first step holds in place.
    ///
    /// Springs that are stretched or compressed from the start may hold a network that is loose without them; such a
    /// network is left to the iteration.
    pub fn free_motions(&mut self, steps: &[Step]) -> Vec<FreeMotion> {
        let mut held = self.held.clone();
        for (node, component) in first_rows(&self.system.structure, steps) {
            self.insert(node, component, 0.0, 0.0);
        }
        self.system.hold(self.held.values().copied().collect());
        std::mem::swap(&mut self.held, &mut held);
        // The system is assembled with the rows of the first step; `held` has them, `self.held` those of the supports.
        let inertia = self.system.assemble(false);
        self.system.note_rest();
        let motions = if inertia.neutral > 0 && !self.is_prestressed() {
            mechanism::free_motions(&mut self.system)
        } else {
            Vec::new()
        };
        let same = held.len() == self.held.len();
        self.system.hold(self.held.values().copied().collect());
        self.at_rest = Some(if same { inertia } else { self.system.assemble(false) });
        motions
    }

    fn is_prestressed(&self) -> bool {
        let structure = &self.system.structure;
        structure.springs.iter().any(|spring| match spring {
            Spring::Axial { nodes, natural_length, .. } => {
                let [a, b] = nodes.map(|n| structure.nodes[n]);
                let length = (0..3).map(|c| (b[c] - a[c]) * (b[c] - a[c])).sum::<f64>().sqrt();
                (length - natural_length).abs() > 1e-12 * length
            }
            _ => false,
        })
    }

    fn mesh_size(&self) -> MeshSize {
        let structure = &self.system.structure;
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
            unknowns: self.system.equations.size + per_node * interior,
        }
    }

    /// Counts pivots at the present state, before a step moves it.
    fn start_count(&mut self, record: &mut StepHistory) {
        self.system.fraction = 0.0;
        self.system.apply_drives();
        let inertia = self.at_rest.take().unwrap_or_else(|| self.system.assemble(false));
        record.factorizations += 1;
        self.base = self.count(&inertia);
    }

    fn count(&mut self, inertia: &Inertia) -> Count {
        let known = self.base.lateral;
        let potential = self.system.has_potential();
        let mut count = Count {
            own: inertia.negative,
            lateral: 0,
            odd: (inertia.negative % 2 == 1) != inertia.skew_negative,
            potential,
            lateral_potential: true,
            smallest: inertia.smallest,
            neutral: inertia.neutral > 0,
        };
        if let Some(lateral) = &mut self.lateral {
            let (inertia, potential) = lateral(&mut self.system, known);
            count.lateral = inertia.negative;
            count.lateral_potential = potential;
            count.neutral |= inertia.neutral > 0;
        }
        count
    }

    /// Follows a ramp to its end; false where it stopped short.
    fn follow(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        is_step: bool,
    ) -> bool {
        let mut tally = Tally { iterations: 0, factorizations: 0, accepted: 0 };
        let mut fraction = 0.0;
        let mut increment = self.options.first_increment.min(ramp.longest).clamp(SHORTEST, 1.0);
        let mut last_increment = 0.0;
        let (mut first_rate, mut last_rate) = (0.0, 0.0);
        self.system.save(LAST);
        // Loads that lack a potential at the end of the ramp lack it on the way.
        ramp.apply(&mut self.system, 1.0);
        let conservative = self.system.loads_have_potential();
        let mut retries = 0;
        loop {
            let step = if fraction + increment * 1.0001 >= 1.0 { 1.0 - fraction } else { increment };
            let target = if fraction + step >= 1.0 - 1e-12 { 1.0 } else { fraction + step };
            ramp.apply(&mut self.system, target);
            let predicted = tally.accepted > 0;
            if predicted {
                self.system.predict(BEFORE, LAST, step / last_increment);
            }
            let foreseen = if predicted { self.system.distance(LAST) } else { Size::default() };
            let doubt = conservative && step > BRACKET;
            let negative_limit = if doubt { self.base.own } else { usize::MAX };
            let start = Start { predicted, rest: Some(LAST), negative_limit, passing: target < 1.0 };
            let mut outcome = self.newton.solve(&mut self.system, start);
            if let (Err(lost), true) = (&outcome, retries > 0)
                && lost.why != Why::Unstable
            {
                // Mixed stresses of a far iterate can mislead where stresses change sign: try without them.
                tally.iterations += lost.iterations;
                tally.factorizations += lost.iterations;
                self.system.restore(LAST);
                self.system.set_plain(true);
                outcome = self.newton.solve(&mut self.system, Start { predicted: false, ..start });
                self.system.set_plain(false);
            }
            match outcome {
                Ok(found) => {
                    tally.iterations += found.iterations - 1;
                    tally.factorizations += found.iterations;
                    let count = self.count(&found.inertia);
                    let rose = count.own > self.base.own || count.lateral > self.base.lateral;
                    let guarded = rose && self.guards(&count);
                    let foreseen = if predicted { foreseen } else { found.first };
                    let doubtful = conservative && leapt(self.system.distance(LAST), foreseen);
                    if (guarded || doubtful) && step > BRACKET {
                        self.system.restore(LAST);
                        increment = (0.4 * step).max(0.9 * BRACKET);
                        continue;
                    }
                    if guarded || doubtful && self.system.jumped(LAST, BEFORE, tally.accepted > 0) {
                        let sideways = guarded && count.own <= self.base.own;
                        self.stop_at_critical(record, target, sideways);
                        self.system.restore(LAST);
                        ramp.apply(&mut self.system, fraction);
                        self.settle(record, fraction, &tally);
                        return false;
                    }
                    self.note_changes(record, &count, target);
                    self.base = count;
                    last_rate = self.system.distance(LAST).largest() / step;
                    if tally.accepted == 0 {
                        first_rate = last_rate;
                    }
                    self.system.save_as(LAST, BEFORE);
                    fraction = target;
                    last_increment = step;
                    retries = 0;
                    tally.accepted += 1;
                    if is_step {
                        self.accept(record, fraction, &found, &tally);
                    }
                    if !watch(fraction) && fraction < 1.0 {
                        record.status = Status::Interrupted;
                        self.settle(record, fraction, &tally);
                        return false;
                    }
                    if fraction >= 1.0 {
                        record.iterations += tally.iterations;
                        record.factorizations += tally.factorizations;
                        record.fraction = 1.0;
                        record.status = Status::Converged;
                        return true;
                    }
                    increment = match found.iterations {
                        0..=6 => 2.0 * step,
                        7..=8 => step,
                        _ => 0.6 * step,
                    }
                    .min(ramp.longest);
                }
                Err(lost) => {
                    tally.iterations += lost.iterations;
                    tally.factorizations += lost.iterations;
                    self.system.restore(LAST);
                    increment = 0.4 * step;
                    if lost.why == Why::Unstable {
                        // Past a limit point the extrapolation is unstable: go nearer before believing what comes.
                        increment = increment.max(0.9 * BRACKET);
                        continue;
                    }
                    retries += 1;
                    if increment < SHORTEST || retries > 14 {
                        self.give_up(record, target, &lost, last_rate > FOLD * first_rate && tally.accepted > 1);
                        ramp.apply(&mut self.system, fraction);
                        self.settle(record, fraction, &tally);
                        return false;
                    }
                    if !watch(fraction) {
                        record.status = Status::Interrupted;
                        self.settle(record, fraction, &tally);
                        return false;
                    }
                }
            }
        }
    }

    /// Whether a rise of the count is to be trusted as a loss of stability.
    fn guards(&self, count: &Count) -> bool {
        let own = count.own > self.base.own && count.potential;
        let lateral = count.lateral > self.base.lateral && count.lateral_potential;
        own || lateral
    }

    /// Singular points that the accepted increment has passed.
    fn note_changes(&mut self, record: &mut StepHistory, count: &Count, fraction: f64) {
        let fell = count.own < self.base.own || count.lateral < self.base.lateral;
        let conservative = count.potential && self.base.potential;
        let flipped = !conservative && count.odd != self.base.odd && self.base.potential == count.potential;
        if (fell && conservative) || flipped {
            let node = self.mode_node();
            let sideways = count.own == self.base.own;
            record.critical_points.push(CriticalPoint { kind: CriticalKind::Bifurcation, fraction, node, sideways });
        }
        if count.neutral && !self.base.neutral {
            record.notes.push(Note::TouchedSingular { fraction });
        }
    }

    fn stop_at_critical(&mut self, record: &mut StepHistory, target: f64, sideways: bool) {
        let jumped = self.system.jumped(LAST, BEFORE, record.increments.len() > 1);
        let kind = if jumped { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
        let node = self.mode_node();
        record.critical_points.push(CriticalPoint { kind, fraction: target, node, sideways });
        record.status = match kind {
            CriticalKind::LimitPoint => Status::LimitPoint,
            CriticalKind::Bifurcation => Status::Bifurcation,
        };
        let residual = self.system.residual();
        record.failure = Some(Failure {
            tried: target,
            worst_node: Some(node),
            worst_component: residual.worst_component,
            worst_residual: residual.largest(),
            cause: match (kind, sideways) {
                (CriticalKind::LimitPoint, _) => Cause::LimitPoint,
                (CriticalKind::Bifurcation, false) => Cause::Bifurcation,
                (CriticalKind::Bifurcation, true) => Cause::SidewaysBifurcation,
            },
        });
    }

    fn give_up(&mut self, record: &mut StepHistory, target: f64, lost: &Lost, fold: bool) {
        let node = self.system.topology.references.get(lost.residual.worst_joint).copied();
        let cause = if fold {
            Cause::LimitPoint
        } else if lost.why == Why::Singular {
            Cause::IllConditioned
        } else {
            Cause::StepTooSmall
        };
        record.status = if fold { Status::LimitPoint } else { Status::NotConverged };
        if fold {
            let node = self.mode_node();
            let kind = CriticalKind::LimitPoint;
            record.critical_points.push(CriticalPoint { kind, fraction: target, node, sideways: false });
        }
        record.failure = Some(Failure {
            tried: target,
            worst_node: node,
            worst_component: lost.residual.worst_component,
            worst_residual: lost.residual.largest(),
            cause,
        });
    }

    fn mode_node(&mut self) -> NodeId {
        let joint = self.system.softest_joint();
        self.system.topology.references.get(joint).copied().unwrap_or(0)
    }

    /// Ends a step at the state it is in.
    fn settle(&mut self, record: &mut StepHistory, fraction: f64, tally: &Tally) {
        record.iterations += tally.iterations;
        record.factorizations += tally.factorizations;
        record.fraction = fraction;
    }

    /// Records an accepted increment.
    fn accept(&mut self, record: &mut StepHistory, fraction: f64, found: &Convergence, _tally: &Tally) {
        let mut state = results::equilibrium(&mut self.system);
        state.residual = found.residual.largest();
        let shapes = if self.options.shapes { results::shapes(&self.system) } else { Vec::new() };
        record.increments.push(Increment { fraction, state, shapes });
        record.negative_pivots = self.base.own + self.base.lateral;
        let potential = self.base.potential && self.base.lateral_potential;
        record.stable = potential.then_some(record.negative_pivots == 0);
        record.stability = self.stability;
    }

    /// The present equilibrium on elements of the next order.
    fn refine(&mut self) -> Option<Equilibrium> {
        let refined = self.refined.as_mut()?;
        refined.fading.clone_from(&self.system.fading);
        refined.hold(self.system.equations.held.clone());
        refined.prolong(&self.system);
        self.newton.solve(refined, Start::nearby()).ok()?;
        Some(results::equilibrium(refined))
    }
}

/// Whether a state moved much farther than its linear extrapolation: over a limit point, perhaps.
fn leapt(moved: Size, foreseen: Size) -> bool {
    const FARTHER: f64 = 4.0;
    const FAR: f64 = 0.01;
    let leap = |moved: f64, foreseen: f64| moved > FAR && moved > FARTHER * foreseen;
    leap(moved.displacement, foreseen.displacement.max(foreseen.rotation))
        || leap(moved.rotation, foreseen.rotation.max(foreseen.displacement))
}

fn empty_step(stability: Dimension, notes: Vec<Note>) -> StepHistory {
    StepHistory {
        status: Status::NotConverged,
        fraction: 0.0,
        iterations: 0,
        factorizations: 0,
        increments: Vec::new(),
        refined: None,
        stable: None,
        stability,
        negative_pivots: 0,
        critical_points: Vec::new(),
        notes,
        failure: None,
    }
}

/// Nodes whose rotation supports, steps or loads engage.
pub fn turned_nodes(structure: &Structure, steps: &[Step]) -> Vec<bool> {
    let mut turned = vec![false; structure.nodes.len()];
    for support in &structure.supports {
        turned[support.node] |= support.fixed[3..].iter().any(|&f| f);
    }
    for drive in &structure.drives {
        if let crate::structure::Drive::Moment(node, _) | crate::structure::Drive::FollowerMoment(node, _) = *drive {
            turned[node] = true;
        }
    }
    for step in steps {
        for change in &step.changes {
            let (Change::Prescribe { node, component, .. }
            | Change::Hold { node, component }
            | Change::MoveBy { node, component, .. }
            | Change::Free { node, component }) = *change;
            turned[node] |= component >= 3;
        }
    }
    turned
}

/// Rows that supports and the first step hold, at rest.
pub fn first_rows(structure: &Structure, steps: &[Step]) -> Vec<(NodeId, usize)> {
    let mut rows: Vec<_> =
        structure.supports.iter().flat_map(|s| (0..6).filter(|&c| s.fixed[c]).map(|c| (s.node, c))).collect();
    for change in steps.first().map_or(&[][..], |s| &s.changes) {
        match *change {
            Change::Prescribe { node, component, .. }
            | Change::Hold { node, component }
            | Change::MoveBy { node, component, .. } => rows.push((node, component)),
            Change::Free { .. } => {}
        }
    }
    rows
}

/// Builds the topology of a structure for its steps.
pub fn topology(structure: &Structure, steps: &[Step]) -> Arc<Topology> {
    Arc::new(Topology::new(structure, &turned_nodes(structure, steps)))
}
