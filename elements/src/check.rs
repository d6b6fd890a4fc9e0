//! The contract that every element must pass, for tests.
//!
//! The force is the gradient of the energy, the tangent its derivative, and a rigid motion changes neither energy nor,
//! seen from the structure, force.

use crate::rotation::{self, Quaternion, compose};
use crate::small::{add, cross, norm, scale, sub};
use crate::space::Pose;

/// Energy, gradient (force, then moment about the node, in global axes) and Hessian in the chart exp(φ) R.
pub struct Answer {
    /// Strain energy.
    pub energy: f64,
    /// Its derivative by displacements and spins of each node, in global axes.
    pub gradient: Vec<[f64; 6]>,
    /// Second derivatives, six rows and columns a node.
    pub tangent: Vec<Vec<f64>>,
}

/// Checks an element of several nodes at the given poses; `positions` are the unloaded positions of the nodes.
///
/// # Panics
/// Where the element breaks the contract, with what breaks it.
pub fn contract(positions: &[[f64; 3]], poses: &[Pose<f64>], respond: &dyn Fn(&[Pose<f64>]) -> Answer) {
    let answer = respond(poses);
    let size = 6 * poses.len();
    let scale_force = answer.gradient.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs())).max(1e-30);
    let scale_tangent = answer.tangent.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
    let h = 1e-5;
    for i in 0..size {
        let [ahead, behind] = [h, -h].map(|h| respond(&moved(poses, i, h)));
        let slope = (ahead.energy - behind.energy) / (2.0 * h);
        let force = answer.gradient[i / 6][i % 6];
        assert!((slope - force).abs() < 2e-7 * scale_force.max(answer.energy.abs()), "gradient {i}: {force} {slope}");
        for j in 0..size {
            let mut slope = (ahead.gradient[j / 6][j % 6] - behind.gradient[j / 6][j % 6]) / (2.0 * h);
            // The moment follows the turned node: ∂m/∂φ = H − ½ skew(m).
            if i / 6 == j / 6 && i % 6 >= 3 && j % 6 >= 3 {
                let g = answer.gradient[i / 6];
                let mut axis = [0.0; 3];
                axis[i % 3] = 1.0;
                slope += 0.5 * cross([g[3], g[4], g[5]], axis)[j % 3];
            }
            let entry = answer.tangent[j][i];
            assert!((slope - entry).abs() < 1e-7 * scale_tangent, "tangent {j}, {i}: {entry}, by differences {slope}");
            assert!((entry - answer.tangent[i][j]).abs() < 1e-13 * scale_tangent, "tangent {j}, {i} not symmetric");
        }
    }
    rigid_motion(positions, poses, respond, &answer, scale_force);
}

fn rigid_motion(
    positions: &[[f64; 3]],
    poses: &[Pose<f64>],
    respond: &dyn Fn(&[Pose<f64>]) -> Answer,
    answer: &Answer,
    scale_force: f64,
) {
    let turn: Quaternion<f64> = rotation::exp([2.1, -0.8, 1.9]);
    let shift = [3.0, -20.0, 7.0];
    let carried: Vec<_> = poses
        .iter()
        .zip(positions)
        .map(|(pose, &x)| {
            let moved = add(shift, rotation::turn(turn, add(x, pose.displacement)));
            Pose { displacement: sub(moved, x), rotation: compose(turn, pose.rotation) }
        })
        .collect();
    let after = respond(&carried);
    assert!((after.energy - answer.energy).abs() < 1e-10 * answer.energy.abs(), "energy changed by a rigid motion");
    for (a, b) in after.gradient.iter().zip(&answer.gradient) {
        for half in [0, 3] {
            let before = [b[half], b[half + 1], b[half + 2]];
            let turned = rotation::turn(turn, before);
            let now = [a[half], a[half + 1], a[half + 2]];
            assert!(norm(sub(now, turned)) < 1e-9 * scale_force, "force changed by a rigid motion");
        }
    }
}

fn moved(poses: &[Pose<f64>], component: usize, by: f64) -> Vec<Pose<f64>> {
    let mut poses = poses.to_vec();
    let pose = &mut poses[component / 6];
    let mut axis = [0.0; 3];
    axis[component % 3] = 1.0;
    if component % 6 < 3 {
        pose.displacement = add(pose.displacement, scale(by, axis));
    } else {
        pose.rotation = compose(rotation::exp(scale(by, axis)), pose.rotation);
    }
    poses
}
