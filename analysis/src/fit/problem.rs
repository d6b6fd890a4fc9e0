//! Differences between the forward model and the load cases of one pressure.
//!
//! Eq. 11 of the dissertation: the differences of axial motion, deflection and slope, each over a size of its kind, so that
//! none outweighs the others. A case that is loaded along the axis alone tells of the axial motion, any other of deflection
//! and slope.

use pennate_models::hsim::Row;

use super::cantilever::{Cantilever, Load};
use super::data::Case;
use super::muscle;
use super::parameters::Space;

/// The undeformed tube, and the rod it is taken for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Outer diameter, mm.
    pub diameter: f64,
    /// Thickness of the wall, mm.
    pub wall: f64,
    /// Length of each of the ends that do not contract, mm.
    pub end_length: f64,
    /// Shear-flexible (Timoshenko).
    pub shear: bool,
}

/// Sizes that differences are measured by: axial motion, deflection, slope.
pub type Scales = [f64; 3];

/// Largest of each kind among cases, which is what their differences are measured by.
pub fn scales<'a>(cases: impl Iterator<Item = &'a Case>) -> Scales {
    let mut scales = [0.0_f64; 3];
    for case in cases {
        if case.is_axial() {
            scales[0] = scales[0].max((case.length - case.tip[0]).abs());
        } else {
            scales[1] = scales[1].max(case.tip[1].abs());
            scales[2] = scales[2].max(case.slope.abs());
        }
    }
    scales.map(|scale| if scale > 0.0 { scale } else { 1.0 })
}

/// Cases of one pressure, with a rod for every length.
pub struct Problem {
    tube: Tube,
    /// In the unit of the data.
    pub pressure: f64,
    /// Contraction coefficient, one over the unit of the pressure.
    pub alpha: f64,
    /// What is fitted, and its bounds.
    pub space: Space,
    scales: Scales,
    lengths: Vec<Rod>,
    /// How often the load cases were solved.
    pub evaluations: usize,
}

struct Rod {
    cantilever: Cantilever,
    loads: Vec<Load>,
    cases: Vec<Case>,
}

/// Differences over their scales, and their derivatives by the logarithms of the parameters, row by row.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// One a difference.
    pub residuals: Vec<f64>,
    /// For each difference one a parameter; empty unless asked for.
    pub derivatives: Vec<Vec<f64>>,
}

/// Difference of a load case: axial motion alone, or deflection and slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Difference {
    /// Of the position of the tip along the axis, mm.
    Axial(f64),
    /// Of a load across the axis.
    Lateral {
        /// Across the axis, mm.
        deflection: f64,
        /// Radians.
        slope: f64,
    },
}

impl Problem {
    /// All cases must be of one pressure.
    pub fn new(tube: Tube, space: Space, alpha: f64, scales: Scales, cases: &[Case]) -> Self {
        let pressure = cases.first().map_or(0.0, |case| case.pressure);
        let mut lengths: Vec<Rod> = Vec::new();
        let start = start(&tube, &space, pressure, alpha);
        for case in cases {
            let load = Load { force: case.force, moment: case.moment };
            match lengths.iter_mut().find(|rod| rod.cases[0].length == case.length) {
                Some(rod) => {
                    rod.loads.push(load);
                    rod.cases.push(case.clone());
                }
                None => lengths.push(Rod {
                    cantilever: Cantilever::new(&tube.muscle(start), case.length),
                    loads: vec![load],
                    cases: vec![case.clone()],
                }),
            }
        }
        Self { tube, pressure, alpha, space, scales, lengths, evaluations: 0 }
    }

    /// Number of differences.
    pub fn len(&self) -> usize {
        self.lengths.iter().flat_map(|rod| &rod.cases).map(|case| if case.is_axial() { 1 } else { 2 }).sum()
    }

    /// Whether there are no differences.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of load cases.
    pub fn cases(&self) -> usize {
        self.lengths.iter().map(|rod| rod.cases.len()).sum()
    }

    /// Factorizations of the tangent so far.
    pub fn factorizations(&self) -> usize {
        self.lengths.iter().map(|rod| rod.cantilever.factorizations).sum()
    }

    /// The undeformed geometry and 1 MPa.
    pub fn start(&self) -> Vec<f64> {
        self.space.parameters.iter().map(|&parameter| undeformed(parameter, self.tube.diameter)).collect()
    }

    /// The row of a muscle's table with these parameters.
    pub fn row(&self, values: &[f64]) -> Row {
        self.space.row(values, self.pressure, self.alpha)
    }

    /// Differences over their scales; `None` where some load has no stable equilibrium.
    pub fn differences(&mut self, values: &[f64], derivatives: bool) -> Option<Differences> {
        self.evaluations += 1;
        let muscle = self.tube.muscle(self.row(values));
        let mut differences = Differences::default();
        for rod in &mut self.lengths {
            rod.cantilever.set(&muscle);
            let responses = rod.cantilever.solve(&rod.loads, derivatives).ok()?;
            for (case, response) in rod.cases.iter().zip(&responses) {
                let mut add = |output: usize, measured: f64, scale: f64| {
                    differences.residuals.push((response.tip[output] - measured) / scale);
                    if derivatives {
                        let by_sections = &response.sensitivities[output];
                        let row = self.space.derivatives(values, by_sections);
                        differences.derivatives.push(row.iter().map(|slope| slope / scale).collect());
                    }
                };
                if case.is_axial() {
                    add(0, case.tip[0], self.scales[0]);
                } else {
                    add(1, case.tip[1], self.scales[1]);
                    add(2, case.slope, self.scales[2]);
                }
            }
        }
        Some(differences)
    }
}

impl Tube {
    /// The muscle with one row of parameters.
    pub fn muscle(&self, row: Row) -> pennate_models::hsim::Muscle {
        muscle::tube(self.diameter, self.wall, self.end_length, self.shear, row)
    }

    /// Differences of load cases of one pressure, in their order; `None` for those without a stable equilibrium.
    pub fn compare(&self, row: Row, cases: &[Case]) -> Vec<Option<Difference>> {
        let muscle = self.muscle(row);
        let mut rods: Vec<(f64, Cantilever)> = Vec::new();
        let one = |case: &Case| {
            let index = rods.iter().position(|(length, _)| *length == case.length).unwrap_or_else(|| {
                rods.push((case.length, Cantilever::new(&muscle, case.length)));
                rods.len() - 1
            });
            let load = Load { force: case.force, moment: case.moment };
            let [x, y, slope] = rods[index].1.solve(&[load], false).ok()?[0].tip;
            Some(match case.is_axial() {
                true => Difference::Axial(x - case.tip[0]),
                false => Difference::Lateral { deflection: y - case.tip[1], slope: slope - case.slope },
            })
        };
        cases.iter().map(one).collect()
    }
}

fn undeformed(parameter: super::parameters::Parameter, diameter: f64) -> f64 {
    use super::parameters::Parameter::{EndModulus, EndRadius, MiddleRadius, Modulus};
    match parameter {
        EndRadius | MiddleRadius => 0.5 * diameter,
        Modulus | EndModulus => 1.0,
    }
}

fn start(tube: &Tube, space: &Space, pressure: f64, alpha: f64) -> Row {
    let values: Vec<f64> = space.parameters.iter().map(|&parameter| undeformed(parameter, tube.diameter)).collect();
    space.row(&values, pressure, alpha)
}
