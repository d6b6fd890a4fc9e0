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

/// What changes of the forces of a spring add to its gradient and Hessian at a fixed shape: those of Σ f q, q its strains and
/// f = k ∂q·m the changes that a motion m of its nodes makes. The energy is none.
fn change<'a>(strains: impl Iterator<Item = (f64, &'a Jet<12>)>, motion: &[f64; 12]) -> SpringResponse {
    let force = |k: f64, strain: &Jet<12>| k * strain.gradient.iter().zip(motion).map(|(g, m)| g * m).sum::<f64>();
    let sum = strains.fold(Jet::constant(0.0), |sum, (k, strain)| sum + strain.scaled(force(k, strain)));
    SpringResponse { energy: 0.0, ..SpringResponse::of(&sum) }
}

/// Displacement and rotation vector of the node.
fn ground_strains(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>) -> [Jet<12>; 6] {
    let [x, y, z] = std::array::from_fn(|i| Jet::variable(pose.displacement[i], i));
    // Where no rotation is resisted none has to be known.
    let turns = stiffness[3..].iter().any(|&k| k != 0.0);
    let theta = || rotation_vector(product(small_spin(3), constant(pose.rotation)), theta);
    let [a, b, c] = if turns { theta() } else { [Jet::constant(0.0); 3] };
    [x, y, z, a, b, c]
}

/// Six components from a node to the ground; `theta` is the node's rotation vector, whole turns included.
pub fn ground(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>) -> SpringResponse {
    respond(stiffness, &ground_strains(stiffness, pose, theta))
}

/// What the changes of its forces by a motion add to gradient and Hessian of a spring to the ground at a fixed shape; `motion` is
/// the displacement and the spin of the node, and six unused components.
pub fn ground_change(stiffness: &[f64; 6], pose: &Pose<f64>, theta: V3<f64>, motion: &[f64; 12]) -> SpringResponse {
    let strains = ground_strains(stiffness, pose, theta);
    change(stiffness.iter().copied().zip(&strains), motion)
}

/// Six components between two nodes, in axes that turn with the first; `arm` is X₂ − X₁ unloaded.
pub fn coupling(stiffness: &[f64; 6], arm: V3<f64>, poses: [&Pose<f64>; 2]) -> SpringResponse {
    respond(stiffness, &coupling_strains(arm, poses))
}

/// What the changes of its forces by a motion add to gradient and Hessian of a spring of six components at a fixed shape; `motion`
/// is the displacement and the spin of the first node, then of the second.
pub fn coupling_change(
    stiffness: &[f64; 6],
    arm: V3<f64>,
    poses: [&Pose<f64>; 2],
    motion: &[f64; 12],
) -> SpringResponse {
    let strains = coupling_strains(arm, poses);
    change(stiffness.iter().copied().zip(&strains), motion)
}

/// d and ϑ of the second node seen from the first.
fn coupling_strains(arm: V3<f64>, poses: [&Pose<f64>; 2]) -> [Jet<12>; 6] {
    let first = product(small_spin(3), constant(poses[0].rotation));
    let back = conjugate(first);
    let apart = sub(poses[1].displacement, poses[0].displacement);
    let chord: [Jet<12>; 3] = std::array::from_fn(|i| Jet::variable(apart[i] + arm[i], 6 + i) - Jet::variable(0.0, i));
    let turned = product(product(back, [Jet::constant(0.0), chord[0], chord[1], chord[2]]), first);
    let theta = rotation_vector(product(back, product(small_spin(9), constant(poses[1].rotation))), [0.0; 3]);
    let [x, y, z] = std::array::from_fn(|i| turned[1 + i] - Jet::constant(arm[i]));
    [x, y, z, theta[0], theta[1], theta[2]]
}

/// What the change of its force by a motion adds to gradient and Hessian of a spring along a line at a fixed shape; `motion` as in
/// [`coupling_change`].
pub fn axial_change(stiffness: f64, arm: V3<f64>, poses: [&Pose<f64>; 2], motion: &[f64; 12]) -> SpringResponse {
    let apart = add(arm, sub(poses[1].displacement, poses[0].displacement));
    let chord: [Jet<12>; 3] = std::array::from_fn(|i| Jet::variable(apart[i], 6 + i) - Jet::variable(0.0, i));
    let square = chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2];
    let length = square.value.sqrt();
    let strain = square.mapped(length, 0.5 / length, -0.25 / (length * square.value));
    change(std::iter::once((stiffness, &strain)), motion)
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
