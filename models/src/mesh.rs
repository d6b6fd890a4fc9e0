//! How finely each segment of each member is divided.

use std::collections::BTreeMap;

use crate::input::read::Count;
use crate::model::{Member, MemberId, MemberKind, Model, Segment};
use pennate_solver::history::{Equilibrium, History};
use pennate_solver::structure::Dimension;

/// Order of the elements and their number in every stretch of every member.
///
/// A stretch has elements of one length. It is a whole segment, unless the member is graded.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Order of members that do not ask for one, 1 to 4.
    pub order: usize,
    /// Elements of each stretch of each member.
    pub refinement: Vec<Vec<usize>>,
    /// Stretches of graded members, see [`Mesh::graded`].
    pub grading: BTreeMap<MemberId, Vec<Stretch>>,
}

/// A part of a segment with elements of one length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Index among the segments of its member.
    pub segment: usize,
    /// Unloaded length.
    pub length: f64,
}

impl Mesh {
    /// A mesh with so many elements in each segment of each member, equally long.
    pub fn new(order: usize, refinement: Vec<Vec<usize>>) -> Self {
        Self { order, refinement, grading: BTreeMap::new() }
    }

    /// Elements that a file may ask for: they take up to 5 kB each, and a short file a gigabyte at most.
    pub const FORCED_LIMIT: usize = 200_000;

    /// The mesh to begin with for a relative accuracy.
    ///
    /// Members of small networks bend more than those of large ones, which share the motion: a few of them get elements of
    /// a higher order, or twice as short, or both, which saves most of them a second mesh.
    pub fn initial(model: &Model, accuracy: f64) -> Self {
        let few = model.members.len() <= 8;
        let order = match accuracy {
            accuracy if accuracy >= 1e-5 => 2,
            accuracy if accuracy >= 1e-9 && !few => 3,
            _ => 4,
        };
        let short = few && (order == 2 || accuracy < 1e-9 || model.dimension == Dimension::Space);
        let mut lengths: Vec<f64> = model.members.iter().map(|member| member.length).collect();
        lengths.sort_by(f64::total_cmp);
        let typical = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
        let elements = |member: &Member| {
            let long = few && model.members.len() > 1 && member.length > 2.0 * typical;
            member.segments.iter().map(|segment| initial_elements(member, segment, long, short)).collect()
        };
        let mut mesh = Self::new(order, model.members.iter().map(elements).collect());
        mesh.limit(model);
        mesh
    }

    /// The mesh on elements of order 2 that finds the way of a large network; another follows it for the accuracy, see
    /// [`Mesh::raised`].
    pub fn of_the_way(&self, model: &Model, accuracy: f64) -> Option<Self> {
        let large = model.members.len() > LARGE && self.order == 3 && accuracy < 1e-5;
        (large && model.members.iter().all(is_plain)).then(|| Self { order: 2, ..self.clone() })
    }

    /// Whether this found the way of a large network alone.
    pub fn is_of_the_way(&self, accuracy: f64) -> bool {
        self.order == 2 && accuracy < 1e-5
    }

    /// The order that follows on a mesh of the way for an accuracy, and the error that is expected to be left by it; where its
    /// error is not known, the way was short.
    pub fn raised(&self, accuracy: f64, error: Option<f64>) -> (usize, f64) {
        // Twice the order squares an error, times a factor that was a hundredth or less.
        error.map_or((3, accuracy), |error| (4, 0.01 * error * error))
    }

    /// The same for a mesh of order 2 whose error is too large; nothing where the file asks for elements.
    pub fn higher(&self, model: &Model, accuracy: f64, error: Option<f64>) -> Option<(usize, f64)> {
        let error = error.filter(|error| self.order == 2 && *error > accuracy)?;
        // Half as much order again has the root of what twice of it has.
        model.members.iter().all(is_plain).then_some((3, 0.1 * error.powf(1.5)))
    }

    /// The mesh with the elements of each member multiplied by its factor; counts forced by the file stay.
    #[must_use]
    pub fn refined(&self, model: &Model, factors: &[usize]) -> Self {
        let mut mesh = self.clone();
        for (member, (counts, &factor)) in mesh.refinement.iter_mut().zip(factors).enumerate() {
            for (index, count) in counts.iter_mut().enumerate() {
                if self.is_free_at(model, member, index) {
                    *count = count.saturating_mul(factor.max(1));
                }
            }
        }
        mesh.limit(model);
        mesh
    }

    /// A stretch of a member.
    pub fn stretch(&self, model: &Model, member: MemberId, index: usize) -> Stretch {
        match self.grading.get(&member) {
            Some(stretches) => stretches[index],
            None => Stretch { segment: index, length: model.members[member].segments[index].length },
        }
    }

    /// Whether the file leaves the elements of a stretch to choose.
    pub fn is_free_at(&self, model: &Model, member: MemberId, index: usize) -> bool {
        model.members[member].segments[self.stretch(model, member, index).segment].elements.is_none()
    }

    /// Gives the section forces of a state the segments of the model, where those of the solver are stretches.
    pub fn name_sections(&self, model: &Model, state: &mut Equilibrium) {
        for (member, along) in model.probes.sections().iter().zip(&mut state.sections) {
            let Some(stretches) = self.grading.get(member) else { continue };
            along.iter_mut().for_each(|at| at.segment = stretches[at.segment].segment);
        }
    }

    /// The same of a history, and of its shapes.
    pub fn name_segments(&self, model: &Model, history: &mut History) {
        let name = |state: &mut Equilibrium| self.name_sections(model, state);
        for step in &mut history.steps {
            step.refined.iter_mut().for_each(name);
            for increment in &mut step.increments {
                name(&mut increment.state);
                for (member, stretches) in &self.grading {
                    for cell in increment.shapes.get_mut(*member).into_iter().flat_map(|shape| &mut shape.cells) {
                        cell.segment = stretches[cell.segment].segment;
                    }
                }
            }
        }
    }

    /// The lowest order of any element that the file leaves to choose: errors fall as slowly as its do.
    pub fn lowest_order(&self, model: &Model) -> usize {
        let free = model.members.iter().filter(|member| member.has_free_elements());
        free.map(|member| member.order(self.order)).min().unwrap_or(self.order)
    }

    /// Number of elements in all.
    pub fn elements(&self) -> usize {
        self.refinement.iter().flatten().fold(0, |sum, &count| sum.saturating_add(count))
    }

    /// Whether the file says of any segment how many elements it has.
    pub fn is_forced(model: &Model) -> bool {
        model.members.iter().flat_map(|member| &member.segments).any(|segment| segment.elements.is_some())
    }

    /// Keeps what is free within reason: a rod of a million turns cannot be resolved.
    fn limit(&mut self, model: &Model) {
        if self.elements() <= Count::LIMIT {
            return;
        }
        let stretches: usize = self.refinement.iter().map(Vec::len).sum();
        let most = (Count::LIMIT / stretches.max(1)).max(1);
        for member in 0..self.refinement.len() {
            for index in 0..self.refinement[member].len() {
                if self.is_free_at(model, member, index) {
                    self.refinement[member][index] = self.refinement[member][index].min(most);
                }
            }
        }
    }
}

/// Whether the file leaves order and number of the elements of a member to choose.
fn is_plain(member: &Member) -> bool {
    member.segments.iter().all(|segment| segment.elements.is_none()) && member.order(2) == 2 && member.order(4) == 4
}

/// Members that a network may have to count as small.
const LARGE: usize = 100;
/// Elements of a curved segment to begin with, at most: hundreds of turns.
const CURVED: usize = 10_000;

fn initial_elements(member: &Member, segment: &Segment, long: bool, short: bool) -> usize {
    if let Some(elements) = segment.elements {
        return elements;
    }
    let part = segment.length / member.length;
    let straight = match member.kind {
        MemberKind::Muscle(_) if part > 0.5 => 2,
        MemberKind::Muscle(_) => 1,
        _ if long => 4,
        _ if part < 0.25 => 1,
        _ => 2,
    };
    let straight = if short && part > 0.25 { 2 * straight } else { straight };
    let straight = member.formulation.about().elements * straight;
    let curvature = segment.initial_curvature.iter().map(|curvature| curvature * curvature).sum::<f64>().sqrt();
    // At most 30 degrees an element.
    let turns = (curvature * segment.length / 30.0_f64.to_radians() - 1e-9).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, and is limited later")]
    straight.max((turns.max(0.0) as usize).min(CURVED))
}
