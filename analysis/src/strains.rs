//! Strains beyond what the mechanics of small strains holds for, and rods that shear makes unstable in tension.

use pennate_models::Model;
use pennate_models::model::{Member, MemberId, SegmentLaw, Target};
use pennate_solver::continuation::STRAIGHT;
use pennate_solver::history::{MemberState, Peak, StepHistory};

use crate::solution::{Solution, last_state};

/// Part of the strain, or of the force, at which a rod becomes unstable in tension from which on that is said.
const CLOSE: f64 = 0.9;

/// The largest strain that a member had in a run, and when.
#[derive(Clone, Copy, Debug)]
pub struct Strain {
    /// Index of the member.
    pub member: MemberId,
    /// The strain, and where on the member it is.
    pub peak: Peak,
    /// Index of the step.
    pub step: usize,
    /// Part of the step's ramp, 0 to 1.
    pub fraction: f64,
}

/// Members with strains beyond what holds for them, in each list the worst first.
#[derive(Clone, Debug, Default)]
pub struct Excess {
    /// Bars with a solid section that are bent beyond the model's limit of strains.
    pub bent: Vec<Strain>,
    /// Members that are stretched or compressed beyond it, muscles and those that are sheared apart.
    pub stretched: Vec<Strain>,
    /// Shear-flexible rods stretched to where they become unstable in tension, or nearly so.
    pub sheared: Vec<Strain>,
    /// The same of rods that cannot be stretched.
    pub pulled: Vec<GreatestPull>,
}

/// A rod that cannot be stretched, but sheared, pulled by what makes it unstable in tension, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Index of the member.
    pub member: MemberId,
    /// Its greatest axial force, in the model's unit of forces.
    pub force: f64,
    /// That at which it becomes unstable: its shear stiffness, in the same unit.
    pub limit: f64,
}

/// The greatest pull of a member in a run, and when.
#[derive(Clone, Copy, Debug)]
pub struct GreatestPull {
    /// The pull.
    pub pull: Pull,
    /// Index of the step.
    pub step: usize,
    /// Part of the step's ramp, 0 to 1.
    pub fraction: f64,
}

/// Looks for strains beyond what holds in all increments of a run.
pub fn excess(solution: &Solution) -> Excess {
    let model = &solution.model;
    let sheared = strains(solution, |member, state| {
        let limit = model.tensile_limit(member, state.control)?;
        (state.stretch.value >= CLOSE * limit).then_some(state.stretch)
    });
    let limit = model.strain_limit;
    let over = |peak: Peak| (peak.value.abs() > limit).then_some(peak);
    let bent = strains(solution, |member, state| {
        let member = &model.members[member];
        over(state.bending).filter(|_| !member.is_muscle() && is_solid(member))
    });
    let mut stretched =
        strains(solution, |member, state| over(state.stretch).filter(|_| !model.members[member].is_muscle()));
    stretched.retain(|found| sheared.iter().all(|other| other.member != found.member));
    Excess { bent, stretched, sheared, pulled: pulls(solution) }
}

/// Whether a bar has a solid section somewhere. Tubes are what muscles are made of, and bend by more.
fn is_solid(member: &Member) -> bool {
    member.segments.iter().any(|segment| match &segment.material {
        SegmentLaw::Fixed(law) => law.shape.is_some_and(|shape| shape.is_solid),
        SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => false,
    })
}

/// The greatest of what `of` takes of every member in a run, by `size`, with its step and part of the ramp; the greatest of all first.
fn greatest<T: Copy>(
    solution: &Solution,
    of: impl Fn(MemberId, &MemberState) -> Option<T>,
    size: impl Fn(&T) -> f64,
) -> Vec<(MemberId, T, usize, f64)> {
    let members = solution.model.members.len();
    let mut worst: Vec<Option<(MemberId, T, usize, f64)>> = vec![None; members];
    for (step, record) in solution.history.steps.iter().enumerate() {
        for increment in &record.increments {
            for (member, state) in increment.state.members.iter().take(members).enumerate() {
                let Some(found) = of(member, state) else { continue };
                if worst[member].as_ref().is_none_or(|(_, before, ..)| size(&found) > size(before)) {
                    worst[member] = Some((member, found, step, increment.fraction));
                }
            }
        }
    }
    let mut all: Vec<_> = worst.into_iter().flatten().collect();
    all.sort_by(|(_, a, ..), (_, b, ..)| size(b).total_cmp(&size(a)));
    all
}

/// The greatest strain of every member that `of` takes, the greatest of all first.
fn strains(solution: &Solution, of: impl Fn(MemberId, &MemberState) -> Option<Peak>) -> Vec<Strain> {
    let found = greatest(solution, of, |peak| peak.value.abs()).into_iter();
    found.map(|(member, peak, step, fraction)| Strain { member, peak, step, fraction }).collect()
}

/// The pull of a member in a state, where it is near or beyond what shear lets it carry.
fn pull(model: &Model, member: MemberId, now: &MemberState) -> Option<Pull> {
    let limit = model.tensile_force(member, now.control)?;
    let [start, end] = now.axial_force_ends;
    let force = now.axial_force.max(start).max(end);
    (force >= CLOSE * limit).then_some(Pull { member, force, limit })
}

/// A pull as a part of what it may be.
fn part(pull: &Pull) -> f64 {
    pull.force / pull.limit
}

/// The greatest pull of every member that is pulled too much, the worst first.
fn pulls(solution: &Solution) -> Vec<GreatestPull> {
    let found = greatest(solution, |member, now| pull(&solution.model, member, now), part).into_iter();
    found.map(|(_, pull, step, fraction)| GreatestPull { pull, step, fraction }).collect()
}

/// The worst pull in the last state of a step, where one is near or beyond what shear lets a member carry.
pub fn last_pull(model: &Model, step: &StepHistory) -> Option<Pull> {
    let members = last_state(step)?.members.iter().take(model.members.len()).enumerate();
    members.filter_map(|(member, now)| pull(model, member, now)).max_by(|a, b| part(a).total_cmp(&part(b)))
}

/// A member stretched to where shear makes it unstable, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tension {
    /// Index of the member.
    pub member: MemberId,
    /// Axial strain, positive in tension.
    pub stretch: f64,
    /// The strain 1/(EA/GA − 1) at which the rod becomes unstable.
    pub limit: f64,
}

/// The first member that is in the last state of a step near or beyond the strain that its shear stiffness lets it be
/// stretched to.
pub fn tension(model: &Model, step: &StepHistory) -> Option<Tension> {
    let members = last_state(step)?.members.iter().take(model.members.len()).enumerate();
    members.into_iter().find_map(|(member, now)| {
        let limit = model.tensile_limit(member, now.control)?;
        (now.stretch.value >= CLOSE * limit).then_some(Tension { member, stretch: now.stretch.value, limit })
    })
}

/// A member that cannot be stretched, pulled straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taut {
    /// Index of the member.
    pub member: MemberId,
    /// Axial force, in the model's unit of forces.
    pub force: f64,
}

/// The tautest member of the last state of a step among those that cannot be stretched, where its force leaves it no bend to be
/// pulled out of.
pub fn taut(model: &Model, step: &StepHistory) -> Option<Taut> {
    let times = |member: usize, force: f64| {
        let laws = model.members[member].segments.iter().map(|segment| match &segment.material {
            SegmentLaw::Fixed(law) if !law.section.ea.is_finite() => Some(law.section.ei2.min(law.section.ei3)),
            _ => None,
        });
        let stiffness = laws.reduce(|a, b| Some(a?.max(b?)))??;
        Some(force * model.members[member].length.powi(2) / stiffness)
    };
    let members = last_state(step)?.members.iter().take(model.members.len()).enumerate();
    let taut = members.filter_map(|(member, now)| Some((times(member, now.axial_force)?, member, now.axial_force)));
    let (.., member, force) = taut.filter(|taut| taut.0 >= STRAIGHT).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Taut { member, force })
}

/// What the largest load would do to the bar that it could bend most, if that one carried it alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overload {
    /// Index of the bar.
    pub member: MemberId,
    /// The largest load, in the model's unit of forces.
    pub force: f64,
    /// The load over that which bends the bar by about its length, F L²/EI.
    pub times: f64,
}

/// What the loads of a step that got nowhere would do, where it is more than any bar is meant to carry.
pub fn overload(model: &Model, index: usize, step: &StepHistory) -> Option<Overload> {
    /// Beyond this many times the load that would bend a bar by about its length, no bar is meant to carry it.
    const ABSURD: f64 = 1e4;
    if step.fraction > 0.01 {
        return None;
    }
    let targets = model.steps.get(..=index)?.iter().flat_map(|step| &step.targets);
    let force = targets.filter_map(|(target, value)| match target {
        Target::Force(..) | Target::FollowerForce(..) => Some(value.abs()),
        _ => None,
    });
    let force = force.fold(0.0, f64::max);
    let bends = |member: &Member| {
        let stiffness = member.segments.iter().filter_map(|segment| match &segment.material {
            SegmentLaw::Fixed(law) => Some(law.section.ei2.min(law.section.ei3)),
            SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => None,
        });
        Some(force * member.length.powi(2) / stiffness.reduce(f64::min)?)
    };
    let all = model.members.iter().enumerate();
    let all = all.filter_map(|(member, bar)| Some(Overload { member, force, times: bends(bar)? }));
    all.max_by(|a, b| a.times.total_cmp(&b.times)).filter(|worst| worst.times > ABSURD)
}
