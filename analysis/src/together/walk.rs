//! Designs that go the plain way, side by side: every step in one increment, from one stable equilibrium to the next.
//!
//! What the ordinary solver does besides iterating (shorter increments, singular points, records of every state) is left to
//! it: a design for which any of its doubts arises is solved by it alone.

use std::rc::Rc;
use std::sync::Arc;

use pennate_solver::chain::variations;
use pennate_solver::compliance;
use pennate_solver::continuation::{self, OutOfPlane, Passage, QUARTER_TURN, Ramp};
use pennate_solver::history::{Equilibrium, Variation};
use pennate_solver::joints::{Held, HeldKind};
use pennate_solver::newton::{Aim, Lost, Newton, Start, Why};
use pennate_solver::results;
use pennate_solver::structure::{Change, Dimension, Drive, Member, Method, Segment, Stability, Step, Structure};
use pennate_solver::system::{Answer, State, System};

use super::Asked;
use super::kept::{Kept, Memory};
use super::kind::{self, Kind};

/// How many times as far as the step before a step may go to be foretold, and by what part the directions of their loads may
/// differ.
const FARTHEST: f64 = 2.0;
const PARALLEL: f64 = 1e-12;
/// A pivot that is smaller than this part of the smallest of the unloaded structure may soon be none: its factors serve for
/// one state alone.
const WEAK: f64 = 0.05;
/// An increment (radians, or lengths of a member) after which the factors of the state before are as good as those of the state: what
/// they leave is smaller by this part, and their own increment by its square.
const SAME: f64 = 1e-5;
/// Ends of steps are passed where all pivots keep this part of the smallest of the unloaded structure, and of that where the
/// increment began.
const FIRM: f64 = 0.5;
/// Steps of which none is ever passed: those that are have two before them, and one behind.
const FEW: usize = 3;
/// How many times as far as the increment before several steps at once may go.
const AT_ONCE: f64 = 3.0;
/// Steps with the factors at hand before a state is read, at most, and one (radians, or lengths of a member) after which what is
/// left is rounding: every step is a tenth of the one before, or less.
const MORE: usize = 4;
const SETTLED: f64 = 1e-11;
/// What an iteration may leave for the first of them (radians, or lengths of a member), and what is left, of increments and of forces,
/// where there need be none.
const LEFT: f64 = 1e-10;
const EXACT: f64 = 1e-12;

/// Whether a design may be solved at all in this way.
pub(crate) fn is_plain(structure: &Structure, steps: &[Step]) -> bool {
    let plain = |step: &Step| step.method == Method::Newton && step.stop.is_none() && step.min_increments.is_none();
    // The moment of a rotation in space that is let go has no potential while it fades.
    let fades = |change: &Change| matches!(change, Change::Free { component: 3.., .. });
    let fading = structure.dimension == Dimension::Space && steps.iter().flat_map(|step| &step.changes).any(fades);
    !structure.is_prestressed() && !fading && !steps.is_empty() && steps.iter().all(plain)
}

/// Whether designs may share one structure: gravity would be that of all of them.
pub(crate) fn joins(structure: &Structure) -> bool {
    !structure.drives.iter().any(|drive| matches!(drive, Drive::Gravity(_)))
}

/// What is wanted of the end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// It is gone on from.
    Not,
    /// Its state but for what is measured along members.
    Nodes,
    /// Its state.
    State,
    /// Its state, and the system there.
    System,
    /// Its state on elements of the next order too.
    Error,
}

/// The end of a step.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub state: Equilibrium,
    pub finer: Option<Finer>,
}

/// What elements of the next order say of an end.
#[derive(Clone, Debug)]
pub(crate) struct Finer {
    pub state: Equilibrium,
    /// See [`StepHistory::missing`](pennate_solver::history::StepHistory::missing).
    pub missing: Vec<f64>,
    /// How fast the state may vary along the elements in use.
    pub variations: Vec<Vec<Variation>>,
}

/// The ends of the steps that are looked at, and the systems there of those whose system is asked for.
pub(super) type Ends<const D: usize> = (Vec<Option<End>>, Vec<Option<Rc<System<D>>>>);

/// Designs of a group whose way is not plain, as far as they are known: none where nothing tells them from the others.
pub(super) type InDoubt = Vec<usize>;

/// The ends of the steps, or whose way is not plain; that, too, where nobody waits for them any longer.
pub(super) fn ends<const D: usize>(
    structure: Structure,
    steps: &[Step],
    kind: &Kind<D>,
    mut kept: Option<&mut Kept<D>>,
    asked: &Asked<'_>,
) -> Result<Ends<D>, InDoubt> {
    let structure = Arc::new(structure);
    let (found, trusted) = walk(Arc::clone(&structure), steps, kind, kept.as_deref_mut(), asked, true);
    // What is doubtful over several steps at once need not be so one by one, and what is not stable out of the plane need not be held
    // there.
    if found.is_ok() || !trusted { found } else { walk(structure, steps, kind, kept, asked, false).0 }
}

/// The same, and whether it went by what was taken for granted, as may be with `trusts`: that ends of steps may be passed, or that the
/// unloaded network is held out of the plane.
fn walk<const D: usize>(
    structure: Arc<Structure>,
    steps: &[Step],
    kind: &Kind<D>,
    mut kept: Option<&mut Kept<D>>,
    asked: &Asked<'_>,
    trusts: bool,
) -> (Result<Ends<D>, InDoubt>, bool) {
    let looks_aside = kept.as_ref().is_some_and(|kept| kept.looks_aside);
    let topology = continuation::topology(&structure, steps);
    let memory = kept.as_deref_mut().map(|kept| std::mem::take(&mut kept.memory)).unwrap_or_default();
    let Memory { system, lateral: spare, states } = memory;
    let renewed =
        system.and_then(|mut system| system.renew(Arc::clone(&structure), Arc::clone(&topology)).then_some(system));
    let mut system = renewed.unwrap_or_else(|| kind.build(structure, topology, 0));
    system.members.keep_factors();
    let (finer, lateral, held) = (None, None, Vec::new());
    let (way, times, missed) = (None, None, None);
    let (rest, here) = (Firmness::default(), Firmness::default());
    let (begins, trusted, polished) = (false, false, None);
    // Of so few steps none is passed, for which the unloaded network would have to be known.
    let may_pass = steps.len() > FEW;
    let (passes, defers) = (trusts && may_pass, trusts && !may_pass && !looks_aside);
    let mut walk = Walk {
        system,
        finer,
        held,
        lateral,
        spare,
        states,
        way,
        times,
        missed,
        rest,
        here,
        answer: None,
        begins,
        passes,
        defers,
        trusted,
        polished,
        was_read: false,
        suspects: Vec::new(),
    };
    let found = walk.ends(steps, kind, kept.as_deref_mut(), asked);
    let mut found = found.ok_or_else(|| walk.in_doubt(kind.designs));
    let Walk { system, lateral, spare, states, defers, trusted, .. } = walk;
    let mut system = Some(system);
    if let Ok((_, systems)) = &mut found {
        let looks = (asked.look)(steps.len() - 1) == Look::System;
        systems.push(system.take_if(|_| looks).map(Rc::new));
    }
    if let Some(kept) = kept {
        kept.memory = Memory { system, lateral: lateral.or(spare), states };
        kept.looks_aside |= defers && trusted;
    }
    (found, trusted)
}

/// The smallest pivots, in the plane or in space and out of the plane, over the diagonal entries that they came from.
#[derive(Clone, Copy, Default)]
struct Firmness {
    own: f64,
    lateral: f64,
}

impl Firmness {
    /// Whether it keeps a good part of another one.
    fn keeps(self, of: Self) -> bool {
        self.own >= FIRM * of.own && self.lateral >= FIRM * of.lateral
    }
}

struct Walk<const D: usize> {
    system: System<D>,
    /// The same on elements of the next order, once it was looked at.
    finer: Option<System<D>>,
    /// What is held, by node and component.
    held: Vec<Held>,
    lateral: Option<Box<dyn OutOfPlane<D> + Send>>,
    /// Memory of what judged the group before.
    spare: Option<Box<dyn OutOfPlane<D> + Send>>,
    /// The last equilibrium, and the two before it.
    states: [State; 3],
    /// By how much the last step moved the drives, where it moved nothing else.
    way: Option<Vec<f64>>,
    /// How many times that is the step before it, where both went one way.
    times: Option<f64>,
    /// By how much the last state that was foretold missed the equilibrium (radians, or lengths).
    missed: Option<f64>,
    /// The pivots of the unloaded structure, and those of the last equilibrium.
    rest: Firmness,
    here: Firmness,
    /// How the network answers at the last equilibrium, with the rows that are held, where that is asked.
    answer: Option<Answer>,
    /// Whether the unloaded structure is still to be looked at, as the first linearization of the first step.
    begins: bool,
    /// Whether ends of steps may be passed.
    passes: bool,
    /// Whether the unloaded network is not looked at out of the plane, as long as states are stable there: these say of one that
    /// nothing holds there what it says itself, that nothing can be said against it.
    defers: bool,
    /// Whether any ends were passed, or a state is not stable out of the plane where the unloaded network was not looked at.
    trusted: bool,
    /// What one more step with the factors at hand moved a state that is to be read, if there was one, what the increment before it
    /// did, and the number of the linearization before.
    polished: Option<(Option<f64>, f64, u64)>,
    /// Whether the state is one that was read.
    was_read: bool,
    /// Parts of the network that an increment may have led to another path, or that its iteration was lost in.
    suspects: Vec<usize>,
}

impl<const D: usize> Walk<D> {
    /// The ends of all steps, and copies of the system at those whose system is asked for but the last.
    fn ends(
        &mut self,
        steps: &[Step],
        kind: &Kind<D>,
        mut kept: Option<&mut Kept<D>>,
        asked: &Asked<'_>,
    ) -> Option<Ends<D>> {
        self.begin(steps, kind, kept.as_deref_mut())?;
        let mut ends = Vec::with_capacity(steps.len());
        let mut systems = Vec::with_capacity(steps.len());
        let mut holds = 1;
        while ends.len() < steps.len() {
            if !(asked.wanted)() {
                return None;
            }
            let first = ends.len();
            let changes = &steps[first].changes;
            // Before the first step, rows beside the supports may be held.
            if !self.begins && (first == 0 || !changes.is_empty()) {
                self.change(changes)?;
                self.hold(kind, kept.as_deref_mut(), holds);
                self.answer_anew();
                holds += 1;
            } else if self.leave_rows() {
                self.system.hold(self.held.clone());
            }
            let index = self.last_at_once(steps, first, asked);
            for _ in first..index {
                ends.push(None);
                systems.push(None);
            }
            let look = (asked.look)(index);
            // What is only gone on from need not be exact, unless the next step holds it where it is.
            let goes_on = steps.get(index + 1).is_some_and(|next| next.changes.is_empty());
            let aim = if look == Look::Not && goes_on { Aim::Rough } else { Aim::Result };
            self.step(&steps[first..=index], kind, aim, look)?;
            ends.push(match look {
                Look::Not => None,
                Look::Nodes | Look::State | Look::System => Some(End { state: self.read(look, kind), finer: None }),
                Look::Error => Some(End { state: self.read(look, kind), finer: Some(self.refine(kind)?) }),
            });
            if index + 1 < steps.len() {
                systems.push((look == Look::System).then(|| Rc::new(self.copy(kind))));
            }
        }
        Some((ends, systems))
    }

    /// Holds what the first step begins with, and looks at the unloaded structure; or leaves that to the first step.
    fn begin(&mut self, steps: &[Step], kind: &Kind<D>, kept: Option<&mut Kept<D>>) -> Option<()> {
        let structure = Arc::clone(&self.system.structure);
        for support in &structure.supports {
            for component in (0..6).filter(|&component| support.fixed[component]) {
                self.insert_along(support.node, component, [0.0; 2], support.axes[component % 3]);
            }
        }
        let mut rows = continuation::first_rows(&structure, steps);
        rows.retain(|&(node, component)| self.place_of(node, component).is_err());
        let supports = (!rows.is_empty()).then(|| self.held.clone());
        for &(node, component) in &rows {
            self.insert(node, component, [0.0; 2]);
        }
        self.hold(kind, kept, 0);
        let beside = supports.is_some();
        if let Some(supports) = supports {
            self.held = supports;
        }
        self.system.loading.prestress = 1.0;
        // Loads of the first step that bring no stiffness leave that of the unloaded structure to its first linearization.
        self.begins = !beside && steps[0].changes.is_empty() && brings_no_stiffness(&self.system);
        if self.begins {
            return Some(());
        }
        self.system.apply_drives();
        self.system.assemble(false);
        self.look_at_rest(kind)
    }

    /// Looks at the linearization of the unloaded structure.
    fn look_at_rest(&mut self, kind: &Kind<D>) -> Option<()> {
        let structure = Arc::clone(&self.system.structure);
        let inertia = self.system.tangent.inertia();
        if inertia.idle + inertia.negative > 0 {
            return None;
        }
        if self.system.hides_signs_at_rest(&inertia) {
            return None;
        }
        self.system.tangent.note_rest(&self.system.pattern);
        self.answer = self.system.answer_of_hinged();
        self.rest = Firmness { own: inertia.smallest, lateral: 0.0 };
        self.here = self.rest;
        let judged = structure.dimension == Dimension::Plane && structure.stability == Stability::Space;
        if let Some(build) = kind.lateral.filter(|_| judged) {
            let spare = self.spare.take().and_then(|mut spare| spare.renew(&self.system).then_some(spare));
            let mut lateral = spare.unwrap_or_else(|| build(&self.system));
            if self.defers {
                self.lateral = Some(lateral);
                return Some(());
            }
            let (inertia, _) = lateral.inertia(&mut self.system);
            self.lateral = lateral.is_held(&mut self.system).then_some(lateral);
            self.rest.lateral = self.lateral.as_ref().map_or(0.0, |_| inertia.smallest);
        }
        Some(())
    }

    /// Asks how the network answers at the last equilibrium with what is held now.
    fn answer_anew(&mut self) {
        self.answer = None;
        if self.system.may_turn_over() {
            self.system.assemble(false);
            self.answer = self.system.answer_of_hinged();
        }
    }

    fn insert(&mut self, node: usize, component: usize, way: [f64; 2]) {
        self.insert_along(node, component, way, kind::axis(&self.system.structure, node, component));
    }

    fn insert_along(&mut self, node: usize, component: usize, [from, to]: [f64; 2], axis: [f64; 3]) {
        let kind = HeldKind::of(component, axis);
        let row = Held { node, component, kind, from, to };
        match self.place_of(node, component) {
            Ok(known) => self.held[known] = row,
            Err(place) => self.held.insert(place, row),
        }
    }

    /// Where the row of a component is among those that are held, or would be.
    fn place_of(&self, node: usize, component: usize) -> Result<usize, usize> {
        self.held.binary_search_by_key(&(node, component), |held| (held.node, held.component))
    }

    /// Leaves what is held where the last step brought it, and lets go what faded over it; whether there was any.
    fn leave_rows(&mut self) -> bool {
        let mut moved = !self.system.loading.fading.is_empty();
        self.system.loading.fading.clear();
        for held in &mut self.held {
            moved |= held.from != held.to;
            held.from = held.to;
        }
        moved
    }

    /// Takes what a step changes of what is held; nothing where that turns anything by more than one increment does.
    fn change(&mut self, changes: &[Change]) -> Option<()> {
        let turns_far = |component: usize, by: f64| component > 2 && by.abs() > QUARTER_TURN;
        self.leave_rows();
        for change in changes {
            let (node, component) = change.place();
            let known = self.place_of(node, component);
            let present = kind::present(&self.system, node, component);
            match *change {
                Change::Prescribe { to, .. } => {
                    let from = known.map_or(present, |known| self.held[known].to);
                    if turns_far(component, to - from) {
                        return None;
                    }
                    self.insert(node, component, [from, to]);
                }
                Change::Hold { .. } => self.insert(node, component, [present; 2]),
                Change::MoveBy { by, .. } if turns_far(component, by) => return None,
                Change::MoveBy { by, .. } => self.insert(node, component, [present, present + by]),
                Change::Free { .. } => {
                    let reaction = self.system.fading_reaction(node, component);
                    self.system.loading.fading.push(reaction);
                    if let Ok(known) = known {
                        self.held.remove(known);
                    }
                }
            }
        }
        Some(())
    }

    /// Sets what is held, by the analysis of a design before where there is one, and keeps that of this one where they are kept.
    fn hold(&mut self, kind: &Kind<D>, kept: Option<&mut Kept<D>>, index: usize) {
        let rows = self.held.clone();
        let Some(Kept { systems: analysed, .. }) = kept else {
            self.system.hold(rows);
            return;
        };
        if let Some(known) = analysed.get(index) {
            self.system.hold_by(rows, known);
            return;
        }
        self.system.hold(rows);
        let system = &self.system;
        let mut known = kind.build(Arc::clone(&system.structure), Arc::clone(&system.topology), 0);
        known.hold_like(system);
        analysed.push(known);
    }

    /// The last of the steps from one on that are gone in one increment: those whose ends nobody looks at are passed where loads
    /// go on as before, states were foretold well, and no pivot has become much smaller.
    fn last_at_once(&self, steps: &[Step], first: usize, asked: &Asked<'_>) -> usize {
        let known = self.way.as_ref().zip(self.missed).filter(|_| self.passes && self.here.keeps(self.rest));
        let Some((last, missed)) = known else { return first };
        // What the parabola through three states misses goes with the cube of the way.
        let foretells = |times: f64| missed * times.powi(3) <= Newton::default().tuning.miss;
        let from = &self.system.loading.drives;
        let mut drives = from.clone();
        let mut index = first;
        for (at, step) in steps.iter().enumerate().skip(first) {
            step.targets.iter().for_each(|&(drive, value)| drives[drive] = value);
            let way: Vec<f64> = drives.iter().zip(from).map(|(to, from)| to - from).collect();
            if !step.changes.is_empty() || !times(last, &way, AT_ONCE).is_some_and(foretells) {
                break;
            }
            index = at;
            if (asked.look)(at) != Look::Not {
                break;
            }
        }
        index
    }

    /// Goes to the end of the last of some steps in one increment; where loads go on as in the steps before, from what their ends
    /// foretell.
    fn step(&mut self, steps: &[Step], kind: &Kind<D>, aim: Aim, look: Look) -> Option<()> {
        self.trusted |= steps.len() > 1;
        let system = &mut self.system;
        let from = system.loading.drives.clone();
        let mut to = from.clone();
        for &(drive, value) in steps.iter().flat_map(|step| &step.targets) {
            to[drive] = value;
        }
        let loads_stay = from == to;
        let way = steps[0].changes.is_empty().then(|| from.iter().zip(&to).map(|(from, to)| to - from).collect());
        let last = std::mem::replace(&mut self.way, way);
        let times = last
            .zip(self.way.as_ref())
            .and_then(|(last, way)| times(&last, way, if steps.len() > 1 { AT_ONCE } else { FARTHEST }));
        let ramp = Ramp::of_drives(from, to);
        ramp.apply(system, 1.0);
        if !system.loads_have_potential() {
            return None;
        }
        let begins = std::mem::take(&mut self.begins);
        // What was read has its forces, and factors of a state beside it: where nothing but what is held is another now, members stay.
        let stays = std::mem::take(&mut self.was_read)
            && D == 3
            && self.way.is_none()
            && loads_stay
            && !system.loading.holds_strains();
        if begins {
            system.assemble(true);
            self.look_at_rest(kind)?;
        } else if stays {
            system.assemble_joints(true);
        }
        let linearized = begins || stays;
        // A system that is asked for has the factors of its state. In the plane new ones cost little more than the steps that do without
        // them, which a state that is read has to make up for in the end: there they serve on only where none is made for that.
        let serve = aim != Aim::Result || matches!(look, Look::Nodes | Look::State);
        let reuses_factors = serve.then_some(WEAK * self.rest.own);
        let reuses_within = if D == 3 && aim == Aim::Result { SAME } else { f64::INFINITY };
        let system = &mut self.system;
        self.states.rotate_right(1);
        let [last, before, earlier] = &mut self.states;
        system.save(last);
        let mut foreseen = None;
        if let Some(times) = times {
            match self.times {
                Some(before_that) => system.predict_bent([earlier, before, last], [1.0 / before_that, 1.0, times]),
                None => system.predict(before, last, times),
            }
            foreseen = Some(system.distances(last));
        }
        self.times = times;
        let (predicted, rest) = (times.is_some(), times.is_none().then_some(&*last));
        let (negative_limit, may_wander) = (0, false);
        // States that are read get one more step.
        let is_read = matches!(look, Look::Nodes | Look::State);
        let leaves = if is_read && aim == Aim::Result { LEFT } else { 0.0 };
        let start = Start {
            predicted,
            rest,
            negative_limit,
            aim,
            may_wander,
            linearized,
            reuses_factors,
            reuses_within,
            leaves,
        };
        let newton = Newton::default();
        let (aside, mut lost) = (&mut self.lateral, false);
        let mut lost_aside = |system: &mut System<D>| {
            let Some(lateral) = aside else { return 0 };
            let (inertia, potential) = lateral.inertia(system);
            lost |= potential && inertia.negative > 0;
            if potential { inertia.negative } else { 0 }
        };
        let found = newton.solve_beside(system, start, &mut lost_aside);
        let found = match found {
            Ok(found) => found,
            Err(why) => {
                self.trusted |= self.defers && lost;
                self.suspects = suspects(system, &why);
                return None;
            }
        };
        // What makes sure of the way finds the forces of the state anew, which a state that is read needs after one more step.
        if is_read {
            // Where the iteration foresees nothing but rounding there is nothing to gain.
            let still = found.residual.force.max(found.residual.moment) <= EXACT;
            let is_exact = still && found.left <= EXACT;
            let pending = system.pattern.equations.has_general();
            let size = if is_exact { None } else { system.advance(pending).map(|size| size.largest()) };
            self.polished = Some((size, found.last, system.tangent.linearizations()));
        }
        let (moved, before) = (system.distances(last), times.map(|times| (&*before, times)));
        let foreseen = foreseen.unwrap_or_else(|| system.moves.first_by_part.clone());
        let (moved, foreseen) = (moved.as_slice(), foreseen.as_slice());
        let ends = [0.0, 1.0];
        // Whether the network softens is not known.
        let passage = Passage {
            last,
            before,
            ramp: Some(&ramp),
            ends,
            from_rest: last.is_unloaded::<D>(),
            negative: 0,
            softens: false,
            found,
            moved,
            foreseen,
        };
        let judged = passage.judge(system, self.answer.as_ref(), &mut lost_aside, &newton.tuning);
        self.trusted |= self.defers && lost;
        self.answer = judged.map_err(|parts| self.suspects = parts).ok()?;
        let inertia = found.inertia;
        if inertia.negative + inertia.neutral > 0 || !system.tangent.has_potential() {
            return None;
        }
        // Whether a bar turns about itself is judged out of the plane, by the ordinary solver.
        if (D == 6 || self.lateral.is_some()) && system.may_spin() || system.leaves_moments() {
            return None;
        }
        self.missed = predicted.then_some(system.moves.first_own);
        let before = std::mem::replace(&mut self.here, Firmness { own: inertia.smallest, lateral: self.rest.lateral });
        if let Some(lateral) = &mut self.lateral {
            if self.defers {
                let (inertia, potential) = lateral.inertia(system);
                if !potential || inertia.negative + inertia.neutral + inertia.idle > 0 {
                    self.trusted = true;
                    return None;
                }
            }
            let (inertia, potential) = lateral.confirmed(system, 0);
            if !potential || inertia.negative > 0 || inertia.neutral > 0 {
                return None;
            }
            self.here.lateral = inertia.smallest;
        }
        // What lies between was not looked at.
        (steps.len() == 1 || self.here.keeps(before)).then_some(())
    }

    /// What a user may ask of the present state, after one more step with the factors at hand, which bring what is left inside
    /// members to their ends, too: it costs little, and leaves rounding alone. Where it still moves anything there are more.
    fn read(&mut self, look: Look, kind: &Kind<D>) -> Equilibrium {
        let pending = self.system.pattern.equations.has_general();
        // In the plane factors are those of the state, or of one as good: a step leaves a thousandth of the one before, or less.
        let settled = if D == 3 { 100.0 * SETTLED } else { SETTLED };
        let mut polished = self.polished.take();
        let mut last = 0.0;
        for _ in 0..MORE {
            let (size, before, linearization) = polished.take().unwrap_or_else(|| {
                (self.system.advance(pending).map(|size| size.largest()), last, self.system.tangent.linearizations())
            });
            let Some(size) = size else { break };
            let is_fresh = self.system.tangent.linearizations() > linearization;
            // A step leaves as small a part of itself as it is of the one before.
            let is_last = size <= settled || size * size <= 0.1 * EXACT * before;
            if !(is_fresh || self.system.refresh(pending)) || is_last {
                break;
            }
            last = size;
        }
        self.was_read = true;
        let state = match look {
            Look::Nodes => results::motions_and_forces(&mut self.system),
            _ => results::equilibrium(&mut self.system),
        };
        if self.system.structure.compliances.is_empty() {
            return state;
        }
        // A tangent is off by as much as its state is, where forces are off by the square of that.
        self.system.assemble(pending);
        if self.system.advance(pending).is_some() {
            self.system.assemble(pending);
        }
        Equilibrium { compliances: compliance::of_designs(&mut self.system, kind.designs), ..state }
    }

    /// The designs that are in doubt of so many, which have equal numbers of parts.
    fn in_doubt(&self, designs: usize) -> InDoubt {
        let parts = self.system.moves.parts() / designs;
        let mut found: InDoubt = self.suspects.iter().map(|part| part / parts).collect();
        found.dedup();
        found
    }

    /// A system that stays where the present one is.
    fn copy(&self, kind: &Kind<D>) -> System<D> {
        let system = &self.system;
        let mut copy = kind.build(Arc::clone(&system.structure), Arc::clone(&system.topology), 0);
        copy.adopt(system);
        copy.hold_like(system);
        copy.loading.drives.copy_from_slice(&system.loading.drives);
        copy
    }

    /// The present state on elements of the next order.
    fn refine(&mut self, kind: &Kind<D>) -> Option<Finer> {
        let system = &self.system;
        let build = || kind.build(Arc::clone(&system.structure), Arc::clone(&system.topology), 1);
        let finer = self.finer.get_or_insert_with(build);
        finer.hold_like(system);
        finer.prolong(system);
        let found = Newton::default().solve(finer, Start { aim: Aim::Comparison, ..Start::nearby() }).ok()?;
        if found.inertia.negative > 0 {
            return None;
        }
        let mut state = results::equilibrium(finer);
        if !finer.structure.compliances.is_empty() {
            finer.assemble(false);
            state.compliances = compliance::of_designs(finer, kind.designs);
        }
        let missing = state.members.iter().map(|member| member.top_energy).collect();
        let variations = system.members.chains().map(|(pack, lane)| variations(pack, lane)).collect();
        Some(Finer { state, missing, variations })
    }
}

/// The parts that an iteration was lost in: the one that moved farthest at last, where increments tell.
fn suspects<const D: usize>(system: &System<D>, lost: &Lost) -> Vec<usize> {
    match lost.why {
        Why::Astray | Why::Wandered | Why::Slow => system.moves.farthest_part().into_iter().collect(),
        _ => Vec::new(),
    }
}

/// Whether the loads that the steps bring leave the stiffness of the structure at rest alone: dead forces on joints, and controls
/// of members that are stiff without them.
fn brings_no_stiffness<const D: usize>(system: &System<D>) -> bool {
    let structure = &system.structure;
    let brings_none = |drive: &Drive| match *drive {
        Drive::Control => true,
        Drive::Force(node, _) => !system.topology.links[node].has_arm(),
        _ => false,
    };
    let is_stiff = |member: &Member| {
        let stiff = |segment: &Segment| {
            let section = structure.laws[segment.law].at(0.0).section;
            [section.ea, section.ei2, section.ei3].iter().all(|&stiffness| stiffness > 0.0)
        };
        member.control.is_none() || member.segments.iter().all(stiff)
    };
    structure.springs.is_empty() && structure.drives.iter().all(brings_none) && structure.members.iter().all(is_stiff)
}

/// How many times one way another one goes; nothing where it goes elsewhere, back, or farther than so many times.
fn times(way: &[f64], other: &[f64], farthest: f64) -> Option<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (own, times) = (dot(way, way), dot(way, other) / dot(way, way));
    let off = way.iter().zip(other).fold(0.0, |off: f64, (way, other)| off.max((other - times * way).abs()));
    (own > 0.0 && times > 0.0 && times <= farthest && off <= PARALLEL * own.sqrt()).then_some(times)
}
