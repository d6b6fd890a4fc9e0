//! Derivatives of expressions of probes, by those of what they refer to.

use std::collections::BTreeSet;

use pennate_models::Model;
use pennate_models::expression::Expression;
use pennate_models::probes::Operand;
use pennate_solver::history::Equilibrium;

use super::estimate::{Estimate, Greatest, WITHIN};
use super::nearby::{self, Nearby, apart, size};
use super::numbers::Places;
use super::slopes::{Slopes, Stage};
use super::{Output, Reason};

/// Part of an expression that rounding moves it by.
const ROUNDING: f64 = 1e-12;

/// What an expression refers to.
#[derive(Clone, Copy)]
enum Referred {
    /// A number that parameters may set.
    Number(f64),
    /// A probe at the end of a step.
    Probe { step: usize, probe: usize },
}

/// An expression with the values of what it refers to, and its derivatives by them.
struct Referring<'a> {
    expression: &'a Expression,
    all: Vec<Referred>,
    values: Vec<f64>,
    partials: Vec<f64>,
}

/// How all that an expression refers to follows one parameter.
struct Moved {
    rates: Vec<Estimate>,
    /// Its numbers on both sides, then twice as far away.
    numbers: Option<[Vec<f64>; 4]>,
}

impl Referred {
    /// What an expression at the end of a step refers to.
    fn of(operand: &Operand, step: usize) -> Self {
        match *operand {
            Operand::Parameter(value) => Self::Number(value),
            Operand::Probe(probe) => Self::Probe { step, probe },
            Operand::After { probe, step } => Self::Probe { step, probe },
        }
    }
}

impl Referring<'_> {
    /// What the expression follows, each with the derivative by it.
    fn follows(&self) -> impl Iterator<Item = (usize, Referred, f64)> {
        let both = self.all.iter().zip(&self.partials).enumerate();
        both.map(|(place, (&referred, &partial))| (place, referred, partial)).filter(|(.., partial)| *partial != 0.0)
    }

    /// The derivative, by those of what it refers to.
    fn slope(&self, rates: &[Estimate]) -> Estimate {
        let mut sum = Estimate { slope: 0.0, error: 0.0 };
        for (place, _, partial) in self.follows() {
            sum.slope += partial * rates[place].slope;
            sum.error += (partial * rates[place].error).abs();
        }
        if sum.slope.is_finite() { sum } else { Estimate::NONE }
    }

    /// Whether the expression turns sharply here, by a change of its derivative that `counts`, where what it refers to changes at these
    /// rates; numbers have values of their own on both sides, and twice as far away.
    fn has_corner(&self, rates: &[Estimate], numbers: Option<&[Vec<f64>; 4]>, by: f64, counts: f64) -> bool {
        let at = |side: usize| {
            let times = [-1.0, 1.0, -2.0, 2.0][side];
            let value = |(place, referred): (usize, &Referred)| match (referred, numbers) {
                (Referred::Number(_), Some(numbers)) => numbers[side][place],
                // What the expression does not follow may not be known.
                _ if !rates[place].slope.is_finite() => self.values[place],
                _ => self.values[place] + times * by * rates[place].slope,
            };
            let moved: Vec<f64> = self.all.iter().enumerate().map(value).collect();
            self.expression.value(&moved)
        };
        let here = self.expression.value(&self.values);
        nearby::corner(here, [0, 1, 2, 3].map(at), by) > counts.max(ROUNDING * here.abs() / by)
    }
}

impl Slopes<'_> {
    /// The probes whose derivatives are asked for in a state, or go into others that are.
    pub(super) fn needed(&self, stage: Stage) -> BTreeSet<usize> {
        let all = self.behind(&self.problem.outputs);
        all.into_iter().filter_map(|(step, probe)| (stage == Stage::End(step)).then_some(probe)).collect()
    }

    /// The output that a quantity is at the end of a step, or else the first one that is made of it, or is read no earlier.
    pub(super) fn output_of(&self, index: usize, quantity: usize) -> usize {
        let outputs = &self.problem.outputs;
        let own = outputs.iter().position(|output| output.probe == quantity && output.step == index);
        let of_it = |output: &Output| self.behind(std::slice::from_ref(output)).contains(&(index, quantity));
        own.or_else(|| outputs.iter().position(of_it)).unwrap_or_else(|| self.output_after(index))
    }

    /// The first output that is read at the end of a step or later.
    pub(super) fn output_after(&self, index: usize) -> usize {
        self.problem.outputs.iter().position(|output| output.step >= index).unwrap_or_default()
    }

    /// Steps and probes of what outputs are, and of what goes into them.
    fn behind(&self, outputs: &[Output]) -> BTreeSet<(usize, usize)> {
        let probes = &self.design.model.probes;
        let mut open: Vec<(usize, usize)> = outputs.iter().map(|output| (output.step, output.probe)).collect();
        let mut seen = BTreeSet::new();
        while let Some((step, probe)) = open.pop() {
            if !seen.insert((step, probe)) {
                continue;
            }
            for operand in probes.operands(probe).into_iter().flatten() {
                if let Referred::Probe { step, probe } = Referred::of(operand, step) {
                    open.push((step, probe));
                }
            }
        }
        seen
    }

    /// Puts the derivatives of the expressions that are needed at the end of a step beside those of what they refer to; with the reason
    /// where one has a corner.
    ///
    /// Errors go through an expression as derivatives do: what is nothing beside the largest reaction may be all of a sum.
    pub(super) fn combine(&mut self, index: usize, state: &Equilibrium, found: &mut [Estimate]) -> Option<Reason> {
        let (design, inputs) = (self.design, self.row.len());
        let (greatest, needed) = (Greatest::of(state), self.needed(Stage::End(index)));
        self.floors[index] =
            (0..design.model.probes.len()).map(|probe| self.floor(Stage::End(index), &greatest, probe)).collect();
        let mut reason = None;
        for &probe in design.model.probes.order().iter().filter(|&probe| needed.contains(probe)) {
            let Some(referring) = self.referring(&design.model, index, probe) else { continue };
            self.floors[index][probe] = self.floor_by_operands(&referring, (index, probe), found);
            let moved: Vec<Moved> =
                (0..inputs).map(|input| self.moved_operands(&referring, (index, probe, input), found)).collect();
            let mut column: Vec<Estimate> = moved.iter().map(|moved| referring.slope(&moved.rates)).collect();
            let counts = WITHIN * self.measure(&column, self.floors[index][probe]);
            for ((estimate, Moved { rates, numbers }), &value) in column.iter_mut().zip(&moved).zip(self.row) {
                // Of a probe whose derivative is not known the reason is given already.
                let misses = |(place, referred, _): (usize, Referred, f64)| {
                    matches!(referred, Referred::Probe { .. }) && !rates[place].slope.is_finite()
                };
                let is_told = referring.follows().any(misses);
                let is_smooth = estimate.slope.is_finite()
                    && !referring.has_corner(rates, numbers.as_ref(), apart(value), counts / size(value));
                if !is_told && !is_smooth {
                    *estimate = Estimate::NONE;
                    reason = reason.or(Some(Reason::NoDerivative { output: self.output_of(index, probe) }));
                }
            }
            found[probe * inputs..][..inputs].copy_from_slice(&column);
        }
        reason
    }

    /// An expression at the end of a step; `None` for any other probe.
    fn referring<'a>(&self, model: &'a Model, index: usize, probe: usize) -> Option<Referring<'a>> {
        let (expression, operands) = model.probes.expression(probe)?;
        let all: Vec<Referred> = operands.iter().map(|operand| Referred::of(operand, index)).collect();
        let value = |referred: &Referred| match *referred {
            Referred::Number(value) => value,
            Referred::Probe { step, probe } => self.after.get(step).map_or(f64::NAN, |values| values[probe]),
        };
        let values: Vec<f64> = all.iter().map(value).collect();
        let partials = expression.partials(&values);
        Some(Referring { expression, all, values, partials })
    }

    /// What derivatives of an expression are measured by at least: a part of its value, and where all that counts of what it follows
    /// vanishes, by what derivatives of that are.
    fn floor_by_operands(&self, referring: &Referring<'_>, (index, own): (usize, usize), found: &[Estimate]) -> f64 {
        let (mut floor, mut counts): (f64, f64) = (0.0, 0.0);
        for (place, referred, partial) in referring.follows() {
            let (least, measure) = match referred {
                Referred::Number(_) => (0.0, referring.values[place].abs()),
                Referred::Probe { step, probe } => {
                    let least = self.floors.get(step).and_then(|floors| floors.get(probe)).copied().unwrap_or(0.0);
                    (least, self.measure(self.column(step, probe, (index, found)), least))
                }
            };
            let largest = if measure > least { &mut counts } else { &mut floor };
            *largest = largest.max((partial * measure).abs());
        }
        let own = self.floors[index][own];
        if counts <= ROUNDING * floor { own.max(floor) } else { own }
    }

    /// The derivatives of a probe at the end of a step: those at hand are of the present one.
    fn column<'f>(&'f self, step: usize, probe: usize, (index, found): (usize, &'f [Estimate])) -> &'f [Estimate] {
        let inputs = self.row.len();
        let all = if step == index { found } else { self.slopes.get(step).map_or(&[][..], Vec::as_slice) };
        all.get(probe * inputs..(probe + 1) * inputs).unwrap_or_default()
    }

    /// How all that an expression refers to follows one parameter.
    fn moved_operands(
        &self,
        referring: &Referring<'_>,
        (index, own, input): (usize, usize, usize),
        found: &[Estimate],
    ) -> Moved {
        let has_numbers = referring.all.iter().any(|referred| matches!(referred, Referred::Number(_)));
        let numbers = if has_numbers { self.numbers_around(own, input) } else { None };
        let rate = |(place, referred): (usize, &Referred)| match *referred {
            Referred::Probe { step, probe } => {
                self.column(step, probe, (index, found)).get(input).copied().unwrap_or(Estimate::NONE)
            }
            Referred::Number(_) => numbers.as_ref().map_or(Estimate::NONE, |numbers| {
                let change = nearby::change(numbers.each_ref().map(|numbers| numbers[place]));
                Estimate { slope: change / (2.0 * apart(self.row[input])), error: 0.0 }
            }),
        };
        Moved { rates: referring.all.iter().enumerate().map(rate).collect(), numbers }
    }

    /// The numbers of an expression in designs on both sides along one parameter, and in those twice as far away; `None` where there are none.
    fn numbers_around(&self, probe: usize, input: usize) -> Option<[Vec<f64>; 4]> {
        let place = Places::of(&self.design.structure, &self.design.steps).probes + probe;
        let nearby = self.nearby.iter().flatten().flatten().find(|nearby: &&Nearby| nearby.inputs.contains(&input));
        if let Some(nearby) = nearby {
            // Numbers that other parameters set are those of the design.
            let designs = if nearby.is_owned(place, input) { nearby.around() } else { [self.design; 4] };
            return Some(designs.map(|design| design.model.probes.numbers(probe)));
        }
        let by = apart(self.row[input]);
        let numbers = |by: f64| {
            let mut row = self.row.to_vec();
            row[input] += by;
            self.problem.model_beside(&row).ok().map(|model| model.probes.numbers(probe))
        };
        Some([numbers(-by)?, numbers(by)?, numbers(-2.0 * by)?, numbers(2.0 * by)?])
    }
}
