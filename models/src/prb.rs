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

/// How the apex of a dyad is joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    Fixed,
    Pinned,
}

/// An iteration that came to no equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoEquilibrium;

const ITERATIONS: usize = 60;
/// Largest change of an angle (radians) or, over the length, of an elongation in an iteration.
const LONGEST: f64 = 0.3;
/// Parts that a mechanism's ramp of the stroke is divided into.
const RAMP: usize = 20;

impl Prb {
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
        let state = stationary([0.0, 0.0, force[0] / (2.0 * self.extension)], self.length, |v: [Jet<3>; 3]| {
            let [x, y] = self.tip(v);
            self.energy(v) - x.scaled(force[0]) - y.scaled(force[1]) - (v[0] + v[1]).scaled(moment)
        })?;
        let [x, y] = self.tip(state.map(Jet::<0>::constant)).map(|position| position.value);
        Ok([x, y, state[0] + state[1]])
    }

    /// Stroke of a dyad of two such muscles at an angle (radians) to the line of their anchors, its apex free along the axis
    /// of symmetry; the anchors joined as the apex.
    ///
    /// Anchors at (∓L cos χ, 0), apex at (0, L sin χ). With fixed joints two closures hold the apex on the axis and keep its
    /// slope. With pins nothing bends the muscles: they are as long as they are free, or flat, where that is too short.
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the ramp of the stroke is not followed to its end.
    pub fn dyad_stroke(&self, angle: f64, joint: Joint) -> Result<f64, NoEquilibrium> {
        let (sin_angle, cos_angle) = angle.sin_cos();
        let width = self.length * cos_angle;
        if joint == Joint::Pinned {
            let free = self.length - self.stroke;
            return Ok(self.length * sin_angle - (free * free - width * width).max(0.0).sqrt());
        }
        let follow = |part: f64, start: [f64; 5]| {
            let muscle = Self { stroke: part * self.stroke, ..*self };
            stationary(start, self.length, |[first, second, elongation, hold, turn]: [Jet<5>; 5]| {
                let v = [first, second, elongation];
                let [x, y] = muscle.tip(v);
                let across = x.scaled(cos_angle) - y.scaled(sin_angle) - Jet::constant(width);
                muscle.energy(v) + hold * across + turn * (first + second)
            })
        };
        let mut state = [0.0; 5];
        for step in 1..=RAMP {
            state = follow(step as f64 / RAMP as f64, state)?;
        }
        let [first, second, elongation, ..] = state;
        let [x, y] = self.tip([first, second, elongation].map(Jet::<0>::constant)).map(|position| position.value);
        Ok(self.length * sin_angle - (x * sin_angle + y * cos_angle))
    }

    /// Rotation (radians) of a rotary motor of equal muscles, each clamped outside and pinned to a rotor of this radius.
    ///
    /// For the arm direction u and the tangent v of a muscle its clamp is at r u + L (u sin ζ + v cos ζ).
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the ramp of the stroke is not followed to its end.
    pub fn motor_rotation(&self, radius: f64, angle: f64) -> Result<f64, NoEquilibrium> {
        // u = e₁, v = e₂; the muscle runs from its clamp back to the pin, along a = −(sin ζ, cos ζ).
        let along = [-angle.sin(), -angle.cos()];
        let clamp = [radius - self.length * along[0], -self.length * along[1]];
        let follow = |part: f64, start: [f64; 6]| {
            let muscle = Self { stroke: part * self.stroke, ..*self };
            stationary(start, self.length, |[first, second, elongation, rotor, hold_x, hold_y]: [Jet<6>; 6]| {
                let v = [first, second, elongation];
                let [x, y] = muscle.tip(v);
                let pin = [
                    Jet::constant(clamp[0]) + x.scaled(along[0]) - y.scaled(along[1]),
                    Jet::constant(clamp[1]) + x.scaled(along[1]) + y.scaled(along[0]),
                ];
                let gap = [pin[0] - cos(rotor).scaled(radius), pin[1] - sin(rotor).scaled(radius)];
                muscle.energy(v) + hold_x * gap[0] + hold_y * gap[1]
            })
        };
        let mut state = [0.0; 6];
        for step in 1..=RAMP {
            state = follow(step as f64 / RAMP as f64, state)?;
        }
        Ok(state[3])
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

/// The state in which a function is stationary, by Newton's iteration; the third unknown is a length, the others angles or
/// forces.
fn stationary<const N: usize>(
    start: [f64; N],
    length: f64,
    function: impl Fn([Jet<N>; N]) -> Jet<N>,
) -> Result<[f64; N], NoEquilibrium> {
    let mut state = start;
    for _ in 0..ITERATIONS {
        let found = function(std::array::from_fn(|i| Jet::variable(state[i], i)));
        let gradient = DVector::from_fn(N, |i, _| found.gradient[i]);
        let hessian = DMatrix::from_fn(N, N, |i, j| found.hessian[i][j]);
        let change = hessian.lu().solve(&gradient).ok_or(NoEquilibrium)?;
        let size = (0..N.min(3)).map(|i| change[i].abs() / if i == 2 { length } else { 1.0 }).fold(0.0, f64::max);
        if !size.is_finite() {
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

    /// With pins the stroke is geometry alone: both muscles as long as they are free.
    #[test]
    fn a_pinned_dyad_closes_its_triangle() {
        let angle = 45.0_f64.to_radians();
        let free: f64 = 130.0 - 14.5;
        let width = 130.0 * angle.cos();
        let expected = 130.0 * angle.sin() - (free * free - width * width).sqrt();
        let pinned = MUSCLE.dyad_stroke(angle, Joint::Pinned).unwrap();
        let fixed = MUSCLE.dyad_stroke(angle, Joint::Fixed).unwrap();
        assert!((pinned - expected).abs() < 1e-8, "{pinned} {expected}");
        assert!(fixed < pinned && fixed > 0.5 * pinned, "{fixed} {pinned}");
    }

    /// A muscle along the tangent turns the rotor by its stroke over the radius, less what its bending costs.
    #[test]
    fn a_motor_turns_by_about_its_stroke_over_the_radius() {
        let soft = Prb { torsion: 1e-3, stroke: 3.0, ..MUSCLE };
        let rotation = soft.motor_rotation(32.0, 0.0).unwrap();
        assert!((rotation - 3.0 / 32.0).abs() < 2e-3, "{rotation}");
        let stiff = MUSCLE.motor_rotation(32.0, 0.0).unwrap();
        assert!(stiff > 0.0 && stiff < 14.5 / 32.0 * 1.3, "{stiff}");
    }
}
