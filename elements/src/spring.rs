//! Springs: to the ground, along a line, and with six components between two nodes.
//!
//! ```text
//! ground     ½ Σ k u² + ½ Σ k θ²                θ the rotation vector of the node
//! axial      ½ k (l − l₀)²
//! coupling   ½ Σ k d² + ½ Σ k ϑ²                d = R₁ᵀ (x₂ − x₁) − (X₂ − X₁),  exp ϑ = R₁ᵀ R₂
//! ```
//! Gradient and Hessian are taken in the chart exp(φ) R by second-order differentiation of the energy itself.

use std::f64::consts::TAU;

use crate::jet::Jet;
use crate::rotation::Quaternion;
use crate::small::{V3, add, dot, norm, outer, scale, sub};
use crate::space::Pose;

/// Energy, gradient and Hessian of a spring on one or two nodes (12 components; the second six are unused on one).
#[derive(Clone, Copy, Debug)]
pub struct SpringResponse {
    /// Energy.
    pub energy: f64,
    /// Its derivative by displacements and spins of the first node, then of the second.
    pub gradient: [f64; 12],
    /// Second derivatives by the same.
    pub tangent: [[f64; 12]; 12],
}

impl SpringResponse {
    fn of(jet: &Jet<12>) -> Self {
        Self { energy: jet.value, gradient: jet.gradient, tangent: jet.hessian }
    }
}

type Spin = [Jet<12>; 4];

/// exp(φ) as a quaternion, exact to second order in the three variables that start at `first`.
fn small_spin(first: usize) -> Spin {
    let phi: [Jet<12>; 3] = std::array::from_fn(|i| Jet::variable(0.0, first + i));
    let square = phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2];
    let [x, y, z] = phi.map(|p| p.scaled(0.5));
    [Jet::constant(1.0) - square.scaled(0.125), x, y, z]
}

fn product(a: Spin, b: Spin) -> Spin {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]
}

fn conjugate(a: Spin) -> Spin {
    [a[0], a[1].scaled(-1.0), a[2].scaled(-1.0), a[3].scaled(-1.0)]
}

/// Rotation vector (2 atan(|c|) + 2πn)/|c| c with the Gibbs vector c = v/w: of all that belong to the rotation the one
/// nearest to `near`.
fn rotation_vector(q: Spin, near: V3<f64>) -> [Jet<12>; 3] {
    let inverse = q[0].recip();
    let c = [q[1] * inverse, q[2] * inverse, q[3] * inverse];
    let square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    let y = square.value;
    let root = y.sqrt();
    let along = dot(near, c.map(|c| c.value)) / root;
    let turns = if y > 0.0 { ((along - 2.0 * root.atan()) / TAU).round() } else { 0.0 };
    // f(y) = (2 atan(√y) + 2πn)/√y and its derivatives, from y f′ = 1/(1 + y) − f/2; by series where that cancels.
    let (f, f1, f2) = if y < 0.02 && turns == 0.0 {
        let (mut f, mut f1, mut f2) = (0.0, 0.0, 0.0);
        for k in (0..12).rev() {
            let a = if k % 2 == 0 { 2.0 } else { -2.0 } / (2 * k + 1) as f64;
            f2 = f2 * y + 2.0 * f1;
            f1 = f1 * y + f;
            f = f * y + a;
        }
        (f, f1, f2)
    } else {
        let f = (2.0 * root.atan() + TAU * turns) / root;
        let f1 = (1.0 / (1.0 + y) - 0.5 * f) / y;
        (f, f1, (-1.0 / ((1.0 + y) * (1.0 + y)) - 1.5 * f1) / y)
    };
    let f = square.mapped(f, f1, f2);
    c.map(|c| f * c)
}

fn constant(q: Quaternion<f64>) -> Spin {
    let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
    q.map(|x| Jet::constant(sign * x))
}

fn quadratic(energy: Jet<12>, stiffness: f64, component: Jet<12>) -> Jet<12> {
    if stiffness == 0.0 { energy } else { energy + (component * component).scaled(0.5 * stiffness) }
}

/// Half the stiffness times the square of every strain, added up.
fn respond(stiffness: &[f64; 6], strains: &[Jet<12>; 6]) -> SpringResponse {
    let parts = stiffness.iter().zip(strains);
    SpringResponse::of(&parts.fold(Jet::constant(0.0), |energy, (&k, &strain)| quadratic(energy, k, strain)))
}

/// One of the strains q of a spring, whose energy is the sum of ½ k q².
#[derive(Clone, Copy, Debug)]
pub struct SpringStrain {
    /// k
    pub stiffness: f64,
    /// The force that works on the strain, k q.
    pub force: f64,
    /// The derivatives of q by displacements and spins of the first node, then of the second; by those of the only one first.
    pub gradient: [f64; 12],
    /// Its second derivatives by the same.
    pub curvature: [[f64; 12]; 12],
}

/// Strains that there is a stiffness against.
fn resisted(stiffness: &[f64; 6], strains: &[Jet<12>; 6]) -> Vec<SpringStrain> {
    let parts = stiffness.iter().zip(strains).filter(|(k, _)| **k != 0.0);
    let strain = |(&stiffness, strain): (&f64, &Jet<12>)| SpringStrain {
        stiffness,
        force: stiffness * strain.value,
        gradient: strain.gradient,
        curvature: strain.hessian,
    };
    parts.map(strain).collect()
}

/// Displacement and rotation vector of the node.
fn ground_jets(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>) -> [Jet<12>; 6] {
    let [x, y, z] = std::array::from_fn(|i| Jet::variable(pose.displacement[i], i));
    // Where no rotation is resisted none has to be known.
    let turns = stiffness[3..].iter().any(|&k| k != 0.0);
    let theta = || rotation_vector(product(small_spin(3), constant(pose.rotation)), theta);
    let [a, b, c] = if turns { theta() } else { [Jet::constant(0.0); 3] };
    [x, y, z, a, b, c]
}

/// Six components from a node to the ground; `theta` is the node's rotation vector, whole turns included.
pub fn ground(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>) -> SpringResponse {
    respond(stiffness, &ground_jets(stiffness, pose, theta))
}

/// The strains of the same.
pub fn ground_strains(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>) -> Vec<SpringStrain> {
    resisted(stiffness, &ground_jets(stiffness, pose, theta))
}

/// Six components between two nodes, in axes that turn with the first; `arm` is X₂ − X₁ unloaded.
pub fn coupling(stiffness: &[f64; 6], arm: V3<f64>, poses: [&Pose<f64>; 2]) -> SpringResponse {
    respond(stiffness, &coupling_jets(arm, poses))
}

/// The strains of the same.
pub fn coupling_strains(stiffness: &[f64; 6], arm: V3<f64>, poses: [&Pose<f64>; 2]) -> Vec<SpringStrain> {
    resisted(stiffness, &coupling_jets(arm, poses))
}

/// d and ϑ of the second node seen from the first.
fn coupling_jets(arm: V3<f64>, poses: [&Pose<f64>; 2]) -> [Jet<12>; 6] {
    let first = product(small_spin(3), constant(poses[0].rotation));
    let back = conjugate(first);
    let apart = sub(poses[1].displacement, poses[0].displacement);
    let chord: [Jet<12>; 3] = std::array::from_fn(|i| Jet::variable(apart[i] + arm[i], 6 + i) - Jet::variable(0.0, i));
    let turned = product(product(back, [Jet::constant(0.0), chord[0], chord[1], chord[2]]), first);
    let theta = rotation_vector(product(back, product(small_spin(9), constant(poses[1].rotation))), [0.0; 3]);
    let [x, y, z] = std::array::from_fn(|i| turned[1 + i] - Jet::constant(arm[i]));
    [x, y, z, theta[0], theta[1], theta[2]]
}

/// Along the line between two nodes; also gives the force, positive in tension.
pub fn axial(stiffness: f64, natural_length: f64, arm: V3<f64>, poses: [&Pose<f64>; 2]) -> (SpringResponse, f64) {
    let chord = add(arm, sub(poses[1].displacement, poses[0].displacement));
    let length = norm(chord);
    let force = stiffness * (length - natural_length);
    let axis = scale(1.0 / length, chord);
    let mut response = SpringResponse {
        energy: 0.5 * force * (length - natural_length),
        gradient: [0.0; 12],
        tangent: [[0.0; 12]; 12],
    };
    let along = outer(axis, axis);
    for i in 0..3 {
        response.gradient[i] = -force * axis[i];
        response.gradient[6 + i] = force * axis[i];
        for j in 0..3 {
            let identity = if i == j { 1.0 } else { 0.0 };
            let k = stiffness * along[i][j] + force / length * (identity - along[i][j]);
            response.tangent[i][j] = k;
            response.tangent[6 + i][6 + j] = k;
            response.tangent[i][6 + j] = -k;
            response.tangent[6 + i][j] = -k;
        }
    }
    (response, force)
}

/// The strain of the same.
pub fn axial_strain(stiffness: f64, natural_length: f64, arm: V3<f64>, poses: [&Pose<f64>; 2]) -> SpringStrain {
    let apart = add(arm, sub(poses[1].displacement, poses[0].displacement));
    let chord: [Jet<12>; 3] = std::array::from_fn(|i| Jet::variable(apart[i], 6 + i) - Jet::variable(0.0, i));
    let square = chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2];
    let length = norm(apart);
    let strain = square.mapped(length, 0.5 / length, -0.25 / (length * square.value));
    let force = stiffness * (length - natural_length);
    SpringStrain { stiffness, force, gradient: strain.gradient, curvature: strain.hessian }
}
