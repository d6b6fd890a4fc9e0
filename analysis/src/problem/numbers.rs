//! The numbers of a design, part by part, and which of them a parameter reaches.

use pennate_models::Model;
use pennate_solver::structure::{Change, Drive, Release, SectionLaw, Step, Structure};

/// A second difference larger than this part of the first one is a corner: over so short a distance no curve bends so much.
const CORNER: f64 = 0.05;
/// Part of the numbers of a part that rounding may change.
const ROUNDING: f64 = 1e-11;

/// The numbers of a design by its parts: nodes, members, supports, springs, bodies, targets and changes of the steps, probes.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    values: Vec<f64>,
    /// Where the numbers of every part end.
    ends: Vec<usize>,
}

/// Where the parts of each kind begin among all parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Places {
    pub members: usize,
    pub supports: usize,
    pub springs: usize,
    pub bodies: usize,
    pub targets: usize,
    pub changes: usize,
    pub probes: usize,
}

impl Places {
    pub(super) fn of(structure: &Structure, steps: &[Step]) -> Self {
        let members = structure.nodes.len();
        let supports = members + structure.members.len();
        let springs = supports + structure.supports.len();
        let bodies = springs + structure.springs.len();
        let targets = bodies + structure.bodies.len();
        let changes = targets + steps.iter().map(|step| step.targets.len()).sum::<usize>();
        let probes = changes + steps.iter().map(|step| step.changes.len()).sum::<usize>();
        Self { members, supports, springs, bodies, targets, changes, probes }
    }
}

/// Values of controls at which sections are looked at: all that these steps set.
pub(super) fn controls(structure: &Structure, steps: &[Step]) -> Vec<f64> {
    let targets = steps.iter().flat_map(|step| &step.targets);
    let set = targets.filter(|(drive, _)| structure.drives[*drive] == Drive::Control);
    let mut all: Vec<f64> = set.map(|&(_, value)| value).chain([0.0]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

impl Numbers {
    /// Those of a design; sections at these values of their control.
    pub(super) fn of(model: &Model, structure: &Structure, steps: &[Step], controls: &[f64]) -> Self {
        let mut numbers = Self::default();
        for node in &structure.nodes {
            numbers.part(node.iter().copied());
        }
        let laws: Vec<Vec<f64>> = structure.laws.iter().map(|law| section_numbers(law.as_ref(), controls)).collect();
        for member in &structure.members {
            numbers.values.extend(member.axes.as_flattened());
            let mut last = usize::MAX;
            for segment in &member.segments {
                numbers.values.push(segment.length);
                numbers.values.extend(segment.initial_curvature);
                if segment.law != last {
                    numbers.values.extend(&laws[segment.law]);
                    last = segment.law;
                }
            }
            for release in &member.releases {
                if let Release::Axes(axes) = release {
                    numbers.values.extend(axes.as_flattened());
                }
            }
            numbers.part([]);
        }
        for support in &structure.supports {
            numbers.part(support.axes.as_flattened().iter().copied());
        }
        for spring in &structure.springs {
            numbers.part(spring.numbers());
        }
        for body in &structure.bodies {
            numbers.part([body.mass]);
        }
        for (_, value) in steps.iter().flat_map(|step| &step.targets) {
            numbers.part([*value]);
        }
        for change in steps.iter().flat_map(|step| &step.changes) {
            numbers.part([change_value(change)]);
        }
        numbers.probes(model);
        numbers
    }

    fn probes(&mut self, model: &Model) {
        for probe in 0..model.probes.len() {
            self.part(model.probes.numbers(probe));
        }
    }

    fn part(&mut self, values: impl IntoIterator<Item = f64>) {
        self.values.extend(values);
        self.ends.push(self.values.len());
    }

    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The numbers of a part.
    fn of_part(&self, part: usize) -> &[f64] {
        let start = if part == 0 { 0 } else { self.ends[part - 1] };
        &self.values[start..self.ends[part]]
    }

    /// Whether a part of another design is another one.
    pub(super) fn differs(&self, other: &Self, part: usize) -> bool {
        let (a, b) = (self.of_part(part), other.of_part(part));
        a.len() != b.len() || a.iter().zip(b).any(|(a, b)| !same(*a, *b))
    }

    /// Whether a part changes as smoothly as a curve does over designs on both sides and those twice as far away: second differences of a
    /// curve go with the square of the distance, those over a corner with the distance.
    pub(super) fn is_smooth(&self, near: [&Self; 2], far: [&Self; 2], part: usize) -> bool {
        let middle = self.of_part(part);
        let [low, high, lower, higher] = [near[0], near[1], far[0], far[1]].map(|numbers| numbers.of_part(part));
        if [low.len(), high.len(), lower.len(), higher.len()] != [middle.len(); 4] {
            return false;
        }
        let rounding = ROUNDING * largest(middle);
        let smooth = |n: usize| {
            let bend = |low: f64, high: f64| high - 2.0 * middle[n] + low;
            let stays = low[n] == high[n] && low[n] == middle[n];
            let corner = bend(lower[n], higher[n]) - 4.0 * bend(low[n], high[n]);
            stays || corner.abs() <= CORNER * (high[n] - low[n]).abs() + rounding
        };
        (0..middle.len()).all(smooth)
    }

    /// Whether a part of another design is where `times` the way from the lower to the upper one leads to.
    pub(super) fn foretells(&self, low: &Self, high: &Self, other: &Self, part: usize, times: f64) -> bool {
        let [low, middle, high, other] = [low, self, high, other].map(|numbers| numbers.of_part(part));
        if [low.len(), high.len(), other.len()] != [middle.len(); 3] {
            return false;
        }
        let rounding = ROUNDING * largest(middle);
        (0..middle.len()).all(|n| {
            let (way, bend) = (0.5 * (high[n] - low[n]), high[n] - 2.0 * middle[n] + low[n]);
            let stays = same(low[n], high[n]) && same(other[n], middle[n]);
            let foretold = middle[n] + times * (way + 0.5 * times * bend);
            stays || (foretold - other[n]).abs() <= CORNER * way.abs() + rounding
        })
    }
}

/// Numbers that are not there are the same too.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().filter(|number| number.is_finite()).fold(0.0, |largest: f64, number| largest.max(number.abs()))
}

/// What a change of a step moves to or by.
pub(super) fn change_value(change: &Change) -> f64 {
    match *change {
        Change::Prescribe { to, .. } => to,
        Change::MoveBy { by, .. } => by,
        Change::Hold { .. } | Change::Free { .. } => 0.0,
    }
}

fn section_numbers(law: &dyn SectionLaw, controls: &[f64]) -> Vec<f64> {
    controls.iter().flat_map(|&control| law.at(control).numbers()).collect()
}
