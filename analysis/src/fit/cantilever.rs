//! The forward model of the fit: one HSIM member, clamped at its start, under loads on its tip.
//!
//! The solver's own rod, elements and iteration; left out is what a single chain does not need: no steps, no estimate,
//! no look out of the plane. The mesh stays while sections change with the parameters.
//!
//! It is not a [`crate::problem::Problem`], which would find the same muscles: that takes fifteen times as long for a load case with
//! derivatives (375 µs against 25 µs of a processor, in one run; values alone take 115 µs; 130 mm at 20 psi). Load cases go on from each other here, and a table has three unknowns that
//! are sections alone: the theorem of the unit load gives their derivatives without any force of moved members. Nor would there be less
//! to read, since a network, its loads and probes would have to be written instead. `docs/tutorials/python/muscle.py` fits by a problem.

use std::sync::Arc;

use pennate_models::hsim::{Muscle, MuscleLaw, Part};
use pennate_solver::joints::{Held, HeldKind};
use pennate_solver::newton::{Newton, Start};
use pennate_solver::sensitivity::SegmentSensitivity;
use pennate_solver::structure::{
    Dimension, Drive, Formulation, Member, Release, SectionLaw, Segment, Stability, Structure,
};
use pennate_solver::system::{State, System};
use pennate_solver::{continuation, packs};

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TIP: usize = 1;
/// Components of the tip in the plane: x, y, angle.
pub const OUTPUTS: [usize; 3] = [0, 1, 5];
/// Order of the elements, and how many the ends and the middle are divided into: tips within 1e-6 of the length.
const ORDER: usize = 3;
const ELEMENTS: [usize; 3] = [1, 2, 1];
/// A load is halved so often before its equilibrium is given up.
const HALVINGS: u32 = 8;

/// Dead loads on the tip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Along x and y, N.
    pub force: [f64; 2],
    /// About z, N mm.
    pub moment: f64,
}

/// Where a load puts the tip.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// Position x, y and slope (radians).
    pub tip: [f64; 3],
    /// Derivatives of the three by the sections of end, middle, end; empty unless asked for.
    pub sensitivities: Vec<[SegmentSensitivity; 3]>,
}

/// A load that no stable equilibrium was found for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoEquilibrium(pub Load);

/// A clamped muscle at one pressure.
pub struct Cantilever {
    system: System<3>,
    /// The equilibrium without a load, and that under the last part of one.
    inflated: State,
    last: State,
    newton: Newton,
    length: f64,
    /// Factorizations so far.
    pub factorizations: usize,
}

impl Cantilever {
    /// A muscle of a length; its first row is that of the pressure.
    pub fn new(muscle: &Muscle, length: f64) -> Self {
        let ends = muscle.end_length;
        let lengths = [ends, length - 2.0 * ends, ends];
        let segment = |i: usize| Segment {
            length: lengths[i],
            elements: ELEMENTS[i],
            law: usize::from(i == 1),
            initial_curvature: [0.0; 3],
        };
        let structure = Arc::new(Structure {
            dimension: Dimension::Plane,
            stability: Stability::Plane,
            nodes: vec![[0.0; 3], [length, 0.0, 0.0]],
            members: vec![Member {
                nodes: [0, TIP],
                axes: AXES,
                segments: (0..3).map(segment).collect(),
                releases: [Release::Welded, Release::Welded],
                control: Some(0),
                formulation: Formulation::Exact,
                order: ORDER,
            }],
            laws: laws(muscle),
            supports: Vec::new(),
            bodies: Vec::new(),
            springs: Vec::new(),
            drives: vec![Drive::Control, Drive::Force(TIP, 0), Drive::Force(TIP, 1), Drive::Moment(TIP, 2)],
            compliances: Vec::new(),
            sections: Vec::new(),
        });
        let topology = continuation::topology(&structure, &[]);
        let chains = packs::plane(&structure, 0);
        let mut system = System::new(structure, topology, chains, OUTPUTS, false);
        let held = OUTPUTS.map(|component| {
            let axis = AXES[component % 3];
            let kind = HeldKind::of(component, axis);
            Held { node: 0, component, kind, from: 0.0, to: 0.0 }
        });
        system.hold(held.to_vec());
        let (inflated, last) = (system.snapshot(), system.snapshot());
        let mut cantilever = Self { system, inflated, last, newton: Newton::default(), length, factorizations: 0 };
        cantilever.set(muscle);
        cantilever
    }

    /// Takes other parameters, with the same end length.
    pub fn set(&mut self, muscle: &Muscle) {
        self.system.set_laws(laws(muscle));
        self.system.loading.drives[0] = muscle.rows[0].pressure;
    }

    /// Finds the equilibria of loads, each from the one before where that is nearer than no load.
    ///
    /// # Errors
    /// The first load without an equilibrium that is stable in the plane.
    pub fn solve(&mut self, loads: &[Load], derivatives: bool) -> Result<Vec<Response>, NoEquilibrium> {
        self.system.restore(&self.inflated);
        self.reach(Load::default(), Load::default())?;
        self.system.save(&mut self.inflated);
        let mut last = Load::default();
        let mut responses = Vec::with_capacity(loads.len());
        for &load in loads {
            if self.distance(load, last) > self.distance(load, Load::default()) {
                self.system.restore(&self.inflated);
                last = Load::default();
            }
            self.reach(last, load)?;
            last = load;
            responses.push(self.response(derivatives).ok_or(NoEquilibrium(load))?);
        }
        Ok(responses)
    }

    /// How far one load is from another: forces, and moments over the length.
    fn distance(&self, a: Load, b: Load) -> f64 {
        let [x, y] = [a.force[0] - b.force[0], a.force[1] - b.force[1]];
        x.hypot(y).hypot((a.moment - b.moment) / self.length)
    }

    /// Goes from one load to another, at once or in halves.
    fn reach(&mut self, from: Load, to: Load) -> Result<(), NoEquilibrium> {
        let mut reached = 0.0;
        let mut part: f64 = 1.0;
        let shortest = 0.5_f64.powi(HALVINGS as i32);
        self.system.save(&mut self.last);
        while reached < 1.0 {
            let target = (reached + part).min(1.0);
            let between = |a: f64, b: f64| if target == 1.0 { b } else { a + target * (b - a) };
            self.system.loading.drives[1] = between(from.force[0], to.force[0]);
            self.system.loading.drives[2] = between(from.force[1], to.force[1]);
            self.system.loading.drives[3] = between(from.moment, to.moment);
            self.system.apply_drives();
            match self.newton.solve(&mut self.system, Start::nearby()) {
                Ok(found) if found.inertia.negative == 0 => {
                    self.factorizations += found.iterations;
                    reached = target;
                    if reached < 1.0 {
                        self.system.save(&mut self.last);
                    }
                }
                lost => {
                    self.factorizations += lost.map_or_else(|lost| lost.iterations, |found| found.iterations);
                    self.system.restore(&self.last);
                    part *= 0.5;
                    if part < shortest {
                        return Err(NoEquilibrium(to));
                    }
                }
            }
        }
        Ok(())
    }

    fn response(&mut self, derivatives: bool) -> Option<Response> {
        let link = self.system.topology.links[TIP];
        let moved = OUTPUTS.map(|component| self.system.places.component::<3>(&link, component));
        let mut response = Response { tip: [self.length + moved[0], moved[1], moved[2]], sensitivities: Vec::new() };
        if derivatives {
            for component in OUTPUTS {
                let members = self.system.sensitivities(TIP, component)?;
                let segments: &[SegmentSensitivity] = members.first()?;
                response.sensitivities.push(segments.try_into().ok()?);
            }
        }
        Some(response)
    }
}

fn laws(muscle: &Muscle) -> Vec<Arc<dyn SectionLaw>> {
    let muscle = Arc::new(muscle.clone());
    [Part::End, Part::Middle].map(|part| Arc::new(MuscleLaw { muscle: Arc::clone(&muscle), part }) as _).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::muscle;

    /// Planar extensible elastica by shooting, all digits: L = 130, 1.22 N at the tip.
    #[test]
    fn the_tip_is_that_of_the_elastica() {
        let rows = [
            (10.0, 3.60, -9.135e-3, 6.80, 7.90, [90.311_476_6, 73.900_759_7, 55.203_897_6]),
            (25.0, 4.25, -6.885e-3, 7.15, 8.90, [97.905_997_3, 51.064_778_0, 38.845_514_3]),
        ];
        for (pressure, youngs_modulus, alpha, end_radius, middle_radius, expected) in rows {
            let muscle = muscle::tube(
                13.0,
                2.0,
                13.0,
                false,
                muscle::row(pressure, alpha, [end_radius, middle_radius], [youngs_modulus; 2]),
            );
            let mut cantilever = Cantilever::new(&muscle, 130.0);
            let load = Load { force: [0.0, 1.22], moment: 0.0 };
            let tip = cantilever.solve(&[load], false).unwrap()[0].tip;
            for (found, expected) in [tip[0], tip[1], tip[2].to_degrees()].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-5 * expected, "{found} {expected}");
            }
        }
    }

    /// A contracted muscle that is pushed by more than its Euler load has no stable straight equilibrium.
    #[test]
    fn a_state_beyond_buckling_is_refused() {
        let row = muscle::row(10.0, -5e-3, [6.5; 2], [1.0; 2]);
        let mut cantilever = Cantilever::new(&muscle::tube(13.0, 2.0, 13.0, false, row), 130.0);
        let push = Load { force: [-1.0, 0.0], moment: 0.0 };
        assert!(cantilever.solve(&[push], false).is_err());
    }
}
