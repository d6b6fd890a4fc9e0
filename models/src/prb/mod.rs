//! Pseudo-rigid-body model of a muscle: three rigid links, two torsion springs, two springs in parallel along the middle.
//!
//! A muscle of length L whose free stroke is s, clamped at its start: links of length l_o = (1 − γ) L/2 at both ends, and
//! between them one that is γ L − s long without load. With the angles θ₁, θ₂ of the joints and the elongation δ of the
//! middle link (Eq. 1, 2 of the dissertation)
//! ```text
//! tip      x = l_o + (γL − s + δ) cos θ₁ + l_o cos(θ₁ + θ₂)
//!          y =       (γL − s + δ) sin θ₁ + l_o sin(θ₁ + θ₂),     slope θ₁ + θ₂
//! springs  (K_th θ₁, K_th θ₂, 2 K_ex δ) = Jᵀ (Fx, Fy, M)
//! ```
//! K_ex counts twice, once for each of the two springs. l_o is inferred: the text does not give it. Mechanisms follow from
//! loop closure and virtual work (Eq. 16–19): what is stationary is energy, work and closure, each closure with the force
//! that keeps it.

mod mechanisms;
pub mod published;

pub use mechanisms::{Gripper, Joint};
use nalgebra::{DMatrix, DVector};
use pennate_elements::jet::Jet;

/// A muscle at one pressure: mm and N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prb {
    /// Unloaded, unpressurized length.
    pub length: f64,
    /// Free stroke at the pressure.
    pub stroke: f64,
    /// Part of the length between the joints.
    pub gamma: f64,
    /// Stiffness of a torsion spring, N mm/rad.
    pub torsion: f64,
    /// Stiffness of one of the two springs along the middle, N/mm.
    pub extension: f64,
}

/// The dissertation's unit of K_th, which its text does not name: 0.1 N m/rad, by the size of its numbers.
pub const TORSION_UNIT: f64 = 100.0;

/// An iteration that came to no equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoEquilibrium;

const ITERATIONS: usize = 60;
/// Largest change of an unknown over its size in an iteration.
const LONGEST: f64 = 0.3;
impl Prb {
    /// A uniform strip: γ = 1/√3, K_th = 2 EI/L, 2 K_ex = EA/L.
    ///
    /// With these the end of a clamped strip has the three compliances of the beam, for small motions exactly: the two
    /// joints stand at the Gauss points of its length.
    pub fn strip(length: f64, axial_stiffness: f64, bending_stiffness: f64) -> Self {
        Self {
            length,
            stroke: 0.0,
            gamma: 1.0 / 3.0_f64.sqrt(),
            torsion: 2.0 * bending_stiffness / length,
            extension: 0.5 * axial_stiffness / length,
        }
    }

    fn ends(&self) -> f64 {
        0.5 * (1.0 - self.gamma) * self.length
    }

    fn middle(&self) -> f64 {
        self.gamma * self.length - self.stroke
    }

    /// Strain energy of angles and elongation.
    fn energy<const N: usize>(&self, [first, second, elongation]: [Jet<N>; 3]) -> Jet<N> {
        (first * first + second * second).scaled(0.5 * self.torsion) + (elongation * elongation).scaled(self.extension)
    }

    /// Position of the tip from the clamp, along and across the muscle.
    fn tip<const N: usize>(&self, [first, second, elongation]: [Jet<N>; 3]) -> [Jet<N>; 2] {
        let middle = elongation + Jet::constant(self.middle());
        let slope = first + second;
        [
            Jet::constant(self.ends()) + middle * cos(first) + cos(slope).scaled(self.ends()),
            middle * sin(first) + sin(slope).scaled(self.ends()),
        ]
    }

    /// Position x, y and slope (radians) of the tip under dead loads on it.
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the iteration finds none.
    pub fn under_load(&self, force: [f64; 2], moment: f64) -> Result<[f64; 3], NoEquilibrium> {
        // The stiffness of the springs alone is a start good enough for any load of a muscle.
        let start = [0.0, 0.0, force[0] / (2.0 * self.extension)];
        let state = stationary(start, [1.0, 1.0, self.length], |v: [Jet<3>; 3]| {
            let [x, y] = self.tip(v);
            self.energy(v) - x.scaled(force[0]) - y.scaled(force[1]) - (v[0] + v[1]).scaled(moment)
        })?;
        let [x, y] = self.tip(state.map(Jet::<0>::constant)).map(|position| position.value);
        Ok([x, y, state[0] + state[1]])
    }
}

fn sin<const N: usize>(x: Jet<N>) -> Jet<N> {
    let (sin, cos) = x.value.sin_cos();
    x.mapped(sin, cos, -sin)
}

fn cos<const N: usize>(x: Jet<N>) -> Jet<N> {
    let (sin, cos) = x.value.sin_cos();
    x.mapped(cos, -sin, -cos)
}

/// The state in which a function is stationary, by Newton's iteration.
///
/// `sizes` are those that changes of the unknowns are measured by: one radian, the length of a member, and infinity for the
/// force of a closure, which follows from the others.
fn stationary<const N: usize>(
    start: [f64; N],
    sizes: [f64; N],
    function: impl Fn([Jet<N>; N]) -> Jet<N>,
) -> Result<[f64; N], NoEquilibrium> {
    let mut state = start;
    for _ in 0..ITERATIONS {
        let found = function(std::array::from_fn(|i| Jet::variable(state[i], i)));
        let gradient = DVector::from_fn(N, |i, _| found.gradient[i]);
        let hessian = DMatrix::from_fn(N, N, |i, j| found.hessian[i][j]);
        let change = hessian.lu().solve(&gradient).ok_or(NoEquilibrium)?;
        let size = change.iter().zip(sizes).map(|(change, size)| change.abs() / size).fold(0.0, f64::max);
        if change.iter().any(|change| !change.is_finite()) {
            return Err(NoEquilibrium);
        }
        let part = if size > LONGEST { LONGEST / size } else { 1.0 };
        for i in 0..N {
            state[i] -= part * change[i];
        }
        if size < 1e-11 {
            return Ok(state);
        }
    }
    Err(NoEquilibrium)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MUSCLE: Prb = Prb { length: 130.0, stroke: 14.5, gamma: 0.65, torsion: 170.0, extension: 1.2 };

    /// (K_th θ₁, K_th θ₂, 2 K_ex δ) = Jᵀ F, with J by differences of the tip.
    #[test]
    fn springs_balance_the_load_by_virtual_work() {
        let (force, moment) = ([3.0, 1.4], 12.0);
        let [x, y, slope] = MUSCLE.under_load(force, moment).unwrap();
        // Joints from the tip, by geometry.
        let ends = MUSCLE.ends();
        let joint = [x - ends * slope.cos() - ends, y - ends * slope.sin()];
        let first = joint[1].atan2(joint[0]);
        let elongation = joint[0].hypot(joint[1]) - MUSCLE.middle();
        let [lever_x, lever_y] = [ends * slope.cos(), ends * slope.sin()];
        let about_second = lever_x * force[1] - lever_y * force[0] + moment;
        let about_first = (x - ends) * force[1] - y * force[0] + moment;
        assert!((MUSCLE.torsion * (slope - first) - about_second).abs() < 1e-8);
        assert!((MUSCLE.torsion * first - about_first).abs() < 1e-8);
        let along = force[0] * first.cos() + force[1] * first.sin();
        assert!((2.0 * MUSCLE.extension * elongation - along).abs() < 1e-8);
    }

    #[test]
    fn the_axis_has_twice_the_stiffness_of_one_spring() {
        let [x, y, slope] = MUSCLE.under_load([6.0, 0.0], 0.0).unwrap();
        assert!((x - (130.0 - 14.5 + 6.0 / 2.4)).abs() < 1e-9 && y.abs() < 1e-9 && slope.abs() < 1e-9);
    }

    /// L³/3EI and L²/2EI under a force, L²/2EI and L/EI under a moment, L/EA along the axis.
    #[test]
    fn a_strip_has_the_compliances_of_a_beam() {
        let strip = Prb::strip(80.0, 3e4, 3800.0);
        let small = 1e-6;
        let [_, deflection, slope] = strip.under_load([0.0, small], 0.0).unwrap();
        assert!((deflection / small / (80.0_f64.powi(3) / (3.0 * 3800.0)) - 1.0).abs() < 1e-8);
        assert!((slope / small / (80.0_f64.powi(2) / (2.0 * 3800.0)) - 1.0).abs() < 1e-8);
        let [_, deflection, slope] = strip.under_load([0.0; 2], small).unwrap();
        assert!((deflection / small / (80.0_f64.powi(2) / (2.0 * 3800.0)) - 1.0).abs() < 1e-8);
        assert!((slope / small / (80.0 / 3800.0) - 1.0).abs() < 1e-8);
        let [x, ..] = strip.under_load([3.0, 0.0], 0.0).unwrap();
        assert!((x - 80.0 - 3.0 * 80.0 / 3e4).abs() < 1e-10);
    }
}
