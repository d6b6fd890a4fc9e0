//! An equilibrium that follows its parameters.

use std::sync::Arc;

use pennate_solver::base::{self, Judges};
use pennate_solver::compliance;
use pennate_solver::continuation::{self, OutOfPlane, Passage, Ramp, Tuning};
use pennate_solver::history::{Equilibrium, Growth};
use pennate_solver::joints::Held;
use pennate_solver::newton::{Convergence, Newton, Start};
use pennate_solver::results;
use pennate_solver::structure::{Change, Dimension, Member, Step, Structure};
use pennate_solver::system::{Answer, State, System};

use super::{Control, neighbour};
use crate::together::{self, Kind};

/// An iteration that takes more than this, or whose first move is larger (radians, or lengths of a member), may lead anywhere.
const FEW: usize = 8;
const FAR: f64 = 0.5;

/// A system at an equilibrium, with the numbers that it belongs to.
pub(super) struct Track<const D: usize> {
    kind: Kind<D>,
    system: System<D>,
    /// The state before a step that is tried.
    last: State,
    lateral: Option<Box<dyn OutOfPlane<D> + Send>>,
    /// Those of the present state.
    steps: Vec<Step>,
    verdict: Verdict,
    /// How the network answers there, where that is asked.
    answer: Option<Answer>,
    /// Whether the present state is stable where more than its tangent tells (small vibrations, spins of bars), once that was asked for.
    looked: Option<Option<bool>>,
}

/// How stable a state is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Verdict {
    /// Directions in which it is unstable.
    negative: usize,
    /// Whether loads have a potential, so that the count means something.
    potential: bool,
    /// Sign of the determinant, which changes with the stability where they have none.
    odd: bool,
    /// Whether a moment is taken by nothing: what is in no balance has no stability.
    unbalanced: bool,
}

impl<const D: usize> Track<D> {
    /// Takes over a system at the end of its steps.
    pub(super) fn new(kind: Kind<D>, system: System<D>, sideways: bool, steps: Vec<Step>) -> Self {
        let kind = Kind { lateral: kind.lateral.filter(|_| sideways), ..kind };
        let lateral = kind.lateral.map(|build| build(&system));
        let (last, verdict) = (State::default(), Verdict::default());
        let mut track = Self { kind, system, last, lateral, steps, verdict, answer: None, looked: None };
        // Nobody waits for what led here any more.
        track.system.stop = None;
        track.system.assemble(false);
        track.answer = track.system.answer_of_hinged();
        track.verdict = track.judge();
        track
    }

    /// Another system in the same state.
    pub(super) fn another(&self) -> Self {
        let structure = (*self.system.structure).clone();
        let mut system = together::system(&self.system, self.kind.packs, structure, &self.steps);
        system.adopt(&self.system);
        system.stand_at_end(&self.system, self.system.held(), &self.system.loading.drives);
        let looked = self.looked;
        Self { looked, ..Self::new(self.kind, system, self.lateral.is_some(), self.steps.clone()) }
    }

    /// Goes to the equilibrium for other numbers; false, with nothing changed, where that is not the one next to it, or where
    /// nobody waits any longer.
    pub(super) fn step(&mut self, structure: Structure, steps: Vec<Step>, control: &Control) -> bool {
        let held = neighbour::rows(&self.held(&steps), &structure);
        let mut drives = vec![0.0; structure.drives.len()];
        for &(drive, value) in steps.iter().flat_map(|step| &step.targets) {
            drives[drive] = value;
        }
        if !same_geometry(&self.system.structure, &structure) {
            return self.step_anew(structure, steps, (held, &drives), control);
        }
        let before = (Arc::clone(&self.system.structure), self.system.loading.drives.clone(), self.system.held());
        let is_ramp = loads_alone((&before.0, &before.1), (&structure, &drives));
        self.system.save(&mut self.last);
        self.take(Arc::new(structure), held, &drives);
        if self.settle(is_ramp.then_some(&before.1), control) {
            self.steps = steps;
            return true;
        }
        let (structure, drives, held) = before;
        self.system.restore(&self.last);
        self.take(structure, held, &drives);
        self.system.place_ends();
        self.system.assemble(false);
        false
    }

    /// The same with another geometry: in another system, which takes the place of the present one where it gets there.
    fn step_anew(
        &mut self,
        structure: Structure,
        steps: Vec<Step>,
        (held, drives): (Vec<Held>, &[f64]),
        control: &Control,
    ) -> bool {
        let mut system = together::system(&self.system, self.kind.packs, structure, &steps);
        system.adopt(&self.system);
        system.stand_at_end(&self.system, held, drives);
        let lateral = self.kind.lateral.map(|build| build(&system));
        let old = std::mem::replace(&mut self.system, system);
        let old_lateral = std::mem::replace(&mut self.lateral, lateral);
        self.system.save(&mut self.last);
        let reached = self.settle(None, control);
        if reached {
            self.steps = steps;
        } else {
            (self.system, self.lateral) = (old, old_lateral);
        }
        reached
    }

    /// Numbers that leave the geometry as it is.
    fn take(&mut self, structure: Arc<Structure>, held: Vec<Held>, drives: &[f64]) {
        let laws = structure.laws.clone();
        self.system.structure = structure;
        self.system.set_laws(laws);
        self.system.hold(held);
        self.system.loading.drives.copy_from_slice(drives);
        self.system.apply_drives();
    }

    /// Iterates from the last state; true where that led to the equilibrium next to it, of the same stability. `from` are the drives
    /// there, where nothing but them and what is held is another now.
    fn settle(&mut self, from: Option<&Vec<f64>>, control: &Control) -> bool {
        let newton = Newton::default();
        let start = Start { predicted: false, may_wander: false, ..Start::nearby() };
        self.system.stop.clone_from(&control.stop);
        let found = newton.solve(&mut self.system, start);
        self.system.stop = None;
        let Ok(found) = found else { return false };
        if found.iterations > FEW || self.system.moves.first_own > FAR {
            return false;
        }
        let Ok(answer) = self.judge_passage(found, from, &newton.tuning) else { return false };
        let verdict = self.judge();
        let same = if verdict.potential && self.verdict.potential {
            verdict.negative == self.verdict.negative
        } else {
            verdict.odd == self.verdict.odd
        };
        if same {
            (self.verdict, self.answer, self.looked) = (verdict, answer, None);
        }
        same
    }

    /// Whether the present state lies on the path from the last one, as for an increment of a step. Where more than loads and what is held
    /// has changed, or loads have no potential, nothing tells what lies between, and few iterations have to do.
    fn judge_passage(&mut self, found: Convergence, from: Option<&Vec<f64>>, tuning: &Tuning) -> continuation::Verdict {
        let (moved, foreseen) = (self.system.distances(&self.last), self.system.moves.first_by_part.clone());
        let from = from.filter(|_| self.verdict.potential);
        let ramp = from.map(|from| Ramp::of_drives(from.clone(), self.system.loading.drives.clone()));
        let negative = self.verdict.negative;
        // Whether it softens is not known.
        let passage = Passage {
            last: &self.last,
            before: None,
            ramp: ramp.as_ref(),
            ends: [0.0, 1.0],
            from_rest: false,
            negative,
            softens: false,
            found,
            moved: &moved,
            foreseen: &foreseen,
        };
        let lateral = &mut self.lateral;
        let mut lost_aside = |system: &mut System<D>| {
            let found = lateral.as_mut().map(|lateral| lateral.inertia(system)).filter(|(_, potential)| *potential);
            found.map_or(0, |(inertia, _)| inertia.negative.saturating_sub(negative))
        };
        passage.judge(&mut self.system, self.answer.as_ref(), &mut lost_aside, tuning)
    }

    /// The stability of the state of the last assembly.
    fn judge(&mut self) -> Verdict {
        let inertia = self.system.tangent.inertia();
        let mut verdict = Verdict {
            negative: inertia.negative,
            potential: self.system.tangent.has_potential(),
            odd: inertia.is_odd(),
            unbalanced: self.system.leaves_moments(),
        };
        if verdict.negative > 0 {
            verdict.negative = verdict.negative.min(self.system.certain_negative());
        }
        if let Some(lateral) = &mut self.lateral {
            let (inertia, potential) = lateral.confirmed(&mut self.system, 0);
            if potential {
                verdict.negative += inertia.negative;
            }
        }
        verdict
    }

    /// Whether the present state is stable, where that is known already: inside, `None` where nobody can say.
    pub(super) fn judged(&self) -> Option<Option<bool>> {
        if self.looked.is_some() {
            return self.looked;
        }
        if self.verdict.unbalanced {
            return Some(None);
        }
        if self.verdict.potential {
            let stands = self.verdict.negative == 0;
            return (!stands || !self.system.may_spin()).then_some(Some(stands));
        }
        (!base::vibrations_tell(&self.system)).then_some(None)
    }

    /// Whether the present state is stable; `None` where loads have no potential and vibrations do not tell either.
    pub(super) fn stable(&mut self) -> Option<bool> {
        self.judged().unwrap_or_else(|| {
            let space = if self.lateral.is_some() || D == 6 { Dimension::Space } else { Dimension::Plane };
            let Judges { vibration, spins } = self.kind.judges;
            let found = if self.verdict.potential {
                spins(&self.system, space).map(|spins| spins.motions == 0)
            } else {
                vibration(&self.system, space).map(|vibration| vibration.growth == Growth::None)
            };
            *self.looked.insert(found)
        })
    }

    /// What a user may ask of the present state.
    pub(super) fn read(&mut self) -> Equilibrium {
        let state = results::equilibrium(&mut self.system);
        if self.system.structure.compliances.is_empty() {
            return state;
        }
        Equilibrium { compliances: compliance::of_nodes(&mut self.system), ..state }
    }

    /// What is held, with the values of other steps: what was held where it was stays there.
    fn held(&self, steps: &[Step]) -> Vec<Held> {
        let row = |row: &Held| {
            let to = row.to + (value(steps, row) - value(&self.steps, row));
            Held { from: row.to, to, ..*row }
        };
        self.system.held().iter().map(row).collect()
    }
}

/// What the changes of a held component make of it: its place, or how far it is from where it was when it was held first.
fn value(steps: &[Step], row: &Held) -> f64 {
    let own = (row.node, row.component);
    steps.iter().flat_map(|step| &step.changes).fold(0.0, |here, change| match *change {
        Change::Prescribe { node, component, to } if (node, component) == own => to,
        Change::MoveBy { node, component, by } if (node, component) == own => here + by,
        Change::Free { node, component } if (node, component) == own => 0.0,
        _ => here,
    })
}

/// Whether two structures of the same unloaded shape, each with its drives, differ in nothing that a step does not change.
fn loads_alone((a, from): (&Structure, &[f64]), (b, to): (&Structure, &[f64])) -> bool {
    let member = |(one, other): (&Member, &Member)| {
        let controls = one.control.map_or([0.0; 2], |control| [from[control], to[control]]);
        let mut segments = one.segments.iter().zip(&other.segments);
        segments.all(|(one, other)| controls.iter().all(|&at| a.laws[one.law].at(at) == b.laws[other.law].at(at)))
    };
    a.springs == b.springs && a.drives == b.drives && a.members.iter().zip(&b.members).all(member)
}

/// Whether two structures of one topology have the same unloaded shape: springs and masses are no part of it.
fn same_geometry(a: &Structure, b: &Structure) -> bool {
    let member = |(a, b): (&Member, &Member)| {
        let mut segments = a.segments.iter().zip(&b.segments);
        a.axes == b.axes
            && a.releases == b.releases
            && segments.all(|(a, b)| (a.length, a.initial_curvature) == (b.length, b.initial_curvature))
    };
    a.nodes == b.nodes
        && a.members.iter().zip(&b.members).all(member)
        && a.supports.iter().zip(&b.supports).all(|(a, b)| a.axes == b.axes)
}
