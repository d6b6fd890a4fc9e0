//! Designs next to one: how its numbers follow the parameters.
//!
//! Parameters that reach no number in common are moved at once (Curtis, Powell & Reid, IMA J. Appl. Math. 13, 1974): two
//! designs tell the derivatives of all of them. What reaches what is found out once for a problem; a third design, moved by
//! other distances, tells whether it holds here too.

use super::Problem;
use super::design::Design;
use super::numbers::{Numbers, Places, controls};

/// Parts of a parameter by which it is moved to see what it reaches.
const MOVES: [f64; 4] = [1e-3, -1e-3, 0.03, -0.05];
/// Part of a parameter by which designs on both sides are apart; others are twice as far. Places and lengths have to follow a
/// parameter alike to many digits: what they differ by strains a member as if it were stretched, and joints follow that by the square of
/// its slenderness. Differences at both distances, extrapolated to none, leave 10⁻¹² of rounding; at five times the distance curvature
/// counted where a coordinate is some lengths of a member.
const APART: f64 = 4e-5;
/// Part of the bend over twice the distance below which a corner may be rounding, or a curve.
const CORNER: f64 = 0.05;
/// Differences at that distance and at twice as much, extrapolated to none.
const EXTRAPOLATED: [f64; 2] = [4.0 / 3.0, -1.0 / 6.0];

/// What each parameter of a problem reaches, and which of them are moved at once.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// By parameter and part of a design.
    reached: Vec<Vec<bool>>,
    groups: Vec<Vec<usize>>,
}

/// Designs on both sides of one, moved by some of the parameters.
pub(super) struct Nearby {
    pub inputs: Vec<usize>,
    pub low: Design,
    pub high: Design,
    /// Those twice as far away: lower, then higher.
    beyond: [Design; 2],
    /// The parameter that every part of the design follows, if any does.
    pub owners: Vec<Option<usize>>,
}

fn numbers_of(design: &Design, controls: &[f64]) -> Numbers {
    Numbers::of(&design.model, &design.structure, &design.steps, controls)
}

/// By how much a parameter of this value is moved.
pub(super) fn apart(value: f64) -> f64 {
    APART * size(value)
}

/// The change of a number from the lower to the upper design by its derivative, from what it is in the lower and the upper one, and
/// in those twice as far away.
pub(super) fn change([low, high, lower, higher]: [f64; 4]) -> f64 {
    let [near, far] = EXTRAPOLATED;
    near * (high - low) + far * (higher - lower)
}

/// The same of vectors.
pub(super) fn changes<const N: usize>(all: [[f64; N]; 4]) -> [f64; N] {
    std::array::from_fn(|n| change(all.map(|vector| vector[n])))
}

/// By how much a derivative jumps where its function has this value `here`, and these in the lower and the upper design, `by` away, and
/// in those twice as far away; nothing where it is a curve.
///
/// Over twice the distance the bend of a curve is four times as large or more, that of a corner twice.
pub(super) fn corner(here: f64, [low, high, lower, higher]: [f64; 4], by: f64) -> f64 {
    jump(high - 2.0 * here + low, higher - 2.0 * here + lower, by)
}

/// The same by how much both sides together change over a distance, and over twice as much.
pub(super) fn jump(near: f64, far: f64, by: f64) -> f64 {
    let sharp = (4.0 * near - far) * near.signum();
    if sharp > CORNER * far.abs() { sharp / (2.0 * by) } else { 0.0 }
}

/// What a parameter is measured by.
pub(super) fn size(value: f64) -> f64 {
    if value == 0.0 { 1.0 } else { value.abs() }
}

impl Reach {
    pub(super) fn of(problem: &Problem) -> Option<Self> {
        let row = problem.middle();
        let design = problem.design(&row).ok()?;
        let controls = controls(&design.structure, &design.steps);
        let numbers = numbers_of(&design, &controls);
        let reached: Vec<Vec<bool>> =
            (0..row.len()).map(|input| reached_by(problem, &row, input, &numbers, &controls)).collect();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for input in 0..row.len() {
            let apart = |group: &&mut Vec<usize>| {
                let shares = |&other: &usize| reached[other].iter().zip(&reached[input]).any(|(a, b)| *a && *b);
                !group.iter().any(shares)
            };
            match groups.iter_mut().find(apart) {
                Some(group) => group.push(input),
                None => groups.push(vec![input]),
            }
        }
        Some(Self { reached, groups })
    }
}

fn reached_by(problem: &Problem, row: &[f64], input: usize, numbers: &Numbers, controls: &[f64]) -> Vec<bool> {
    let mut reached = vec![false; numbers.len()];
    for part in MOVES {
        let mut moved = row.to_vec();
        moved[input] += part * size(row[input]);
        let Ok(design) = problem.design_beside(&moved) else { continue };
        let other = numbers_of(&design, controls);
        for (place, reached) in reached.iter_mut().enumerate() {
            *reached |= numbers.differs(&other, place);
        }
    }
    reached
}

impl Problem {
    /// Designs on both sides of one by every parameter; `None` where its numbers have no derivatives, or where it is at the
    /// edge of what makes a network.
    pub(super) fn nearby(&self, row: &[f64], design: &Design) -> Option<Vec<Nearby>> {
        let reach = self.reach.get_or_init(|| Reach::of(self)).as_ref()?;
        let controls = controls(&design.structure, &design.steps);
        let numbers = numbers_of(design, &controls);
        let around = Around { problem: self, row, controls: &controls, numbers: &numbers };
        let mut all = Vec::with_capacity(reach.groups.len());
        for group in &reach.groups {
            match around.moved(group, Some(&reach.reached))? {
                Some(nearby) => all.push(nearby),
                // They have something in common here: each by itself.
                None => {
                    for &input in group {
                        all.push(around.moved(&[input], None)??);
                    }
                }
            }
        }
        Some(all)
    }
}

/// A design with its numbers.
struct Around<'a> {
    problem: &'a Problem,
    row: &'a [f64],
    controls: &'a [f64],
    numbers: &'a Numbers,
}

impl Around<'_> {
    /// Designs on both sides by some parameters at once; `Some(None)` where these have something in common.
    fn moved(&self, inputs: &[usize], reached: Option<&[Vec<bool>]>) -> Option<Option<Nearby>> {
        let [low, high] = [-1.0, 1.0].map(|times| self.design(inputs, |_| times));
        let ((low, below), (high, above)) = (low?, high?);
        let [lower, higher] = [-2.0, 2.0].map(|times| self.design(inputs, |_| times));
        let ((lower, far_below), (higher, far_above)) = (lower?, higher?);
        let mut owners = vec![None; self.numbers.len()];
        for (part, owner) in owners.iter_mut().enumerate() {
            if !below.differs(&above, part) && !below.differs(self.numbers, part) {
                continue;
            }
            if !self.numbers.is_smooth([&below, &above], [&far_below, &far_above], part) {
                return None;
            }
            let Some(reached) = reached.filter(|_| inputs.len() > 1) else {
                *owner = Some(inputs[0]);
                continue;
            };
            *owner = inputs.iter().copied().find(|&input| reached[input][part]);
            if owner.is_none() {
                return Some(None);
            }
        }
        if inputs.len() > 1 {
            let times = |input: usize| 0.4 + 0.5 * (input as f64 * 0.618_033_988_749_895).fract();
            let (_, other) = self.design(inputs, times)?;
            for (part, owner) in owners.iter().enumerate() {
                let foretold = match owner {
                    Some(input) => self.numbers.foretells(&below, &above, &other, part, times(*input)),
                    None => !self.numbers.differs(&other, part),
                };
                if !foretold {
                    return Some(None);
                }
            }
        }
        Some(Some(Nearby { inputs: inputs.to_vec(), low, high, beyond: [lower, higher], owners }))
    }

    fn design(&self, inputs: &[usize], times: impl Fn(usize) -> f64) -> Option<(Design, Numbers)> {
        let mut row = self.row.to_vec();
        for &input in inputs {
            row[input] += times(input) * apart(self.row[input]);
        }
        let design = self.problem.design_beside(&row).ok()?;
        let numbers = numbers_of(&design, self.controls);
        (numbers.len() == self.numbers.len()).then_some((design, numbers))
    }
}

impl Nearby {
    /// The lower and the upper design, and those twice as far away.
    pub(super) fn around(&self) -> [&Design; 4] {
        let [lower, higher] = &self.beyond;
        [&self.low, &self.high, lower, higher]
    }

    /// Whether a part of the design follows this parameter.
    pub(super) fn is_owned(&self, part: usize, input: usize) -> bool {
        self.owners[part] == Some(input)
    }

    /// By how much every drive changes from the lower to the upper design when so many steps are behind.
    pub(super) fn drives(&self, input: usize, behind: usize, places: &Places, count: usize) -> Vec<f64> {
        let mut rates = vec![0.0; count];
        let mut part = places.targets;
        for (step, own) in self.low.steps.iter().enumerate().take(behind) {
            for (place, &(drive, _)) in own.targets.iter().enumerate() {
                let change = || change(self.around().map(|design| design.steps[step].targets[place].1));
                rates[drive] = if self.is_owned(part, input) { change() } else { 0.0 };
                part += 1;
            }
        }
        rates
    }
}
