//! Motions that need no force: the null space of the unloaded stiffness.

use pennate_elements::small::{norm, scale};

use crate::error::{FreeMotion, Place};
use crate::system::System;

/// Stiffness of a motion over that of its components one by one, below which it is free.
const FREE: f64 = 1e-12;
/// At most so many motions are looked for.
const MANY: usize = 12;

/// Free motions of the system at its last assembly.
pub fn free_motions<const D: usize>(system: &mut System<D>) -> Vec<FreeMotion> {
    let mut motions = released(system);
    let size = system.linear.size();
    let original = system.linear.values.clone();
    let diagonal: Vec<f64> = (0..size).map(|i| system.linear.diagonal(i).abs()).collect();
    let largest = diagonal.iter().fold(0.0f64, |a, &b| a.max(b));
    let weight: Vec<f64> = diagonal.iter().map(|d| d.max(1e-14 * largest).max(f64::MIN_POSITIVE)).collect();
    system.linear.shift(1e-9, &weight);
    system.linear.factorize();
    let mut found: Vec<Vec<f64>> = Vec::new();
    while found.len() < MANY.min(size) {
        let seed = found.len() as f64;
        let mut x: Vec<f64> = (0..size).map(|i| (1.3 * i as f64 + 0.7 + seed).sin() / weight[i].sqrt()).collect();
        for _ in 0..4 {
            // The iteration is K⁻¹ W, so that motions are orthogonal by the weights W.
            for (x, w) in x.iter_mut().zip(&weight) {
                *x *= w;
            }
            system.linear.solve(&mut x, 1);
            orthogonalize(&mut x, &found, &weight);
        }
        let mut kx = vec![0.0; size];
        let shifted = std::mem::replace(&mut system.linear.values, original.clone());
        system.linear.apply(&x, &mut kx);
        system.linear.values = shifted;
        let stiffness: f64 = x.iter().zip(&kx).map(|(a, b)| a * b).sum();
        let norm: f64 = x.iter().zip(&weight).map(|(a, w)| a * a * w).sum();
        if !(stiffness.abs() <= FREE * norm) {
            break;
        }
        motions.push(describe(system, &x));
        found.push(x);
    }
    system.linear.values = original;
    motions
}

fn orthogonalize(x: &mut [f64], found: &[Vec<f64>], weight: &[f64]) {
    let inner = |a: &[f64], b: &[f64]| -> f64 { (0..a.len()).map(|i| a[i] * b[i] * weight[i]).sum() };
    for other in found {
        let along = inner(x, other);
        x.iter_mut().zip(other).for_each(|(x, o)| *x -= along * o);
    }
    let length = inner(x, x).sqrt();
    if length > 0.0 {
        x.iter_mut().for_each(|x| *x /= length);
    }
}

/// Members with a released rotation that nothing resists.
fn released<const D: usize>(system: &System<D>) -> Vec<FreeMotion> {
    system
        .idle_members
        .iter()
        .map(|&member| FreeMotion {
            place: Place::Member(member),
            direction: system.structure.members[member].axes[0],
            turns: true,
            nodes: system.structure.members[member].nodes.to_vec(),
        })
        .collect()
}

fn describe<const D: usize>(system: &System<D>, x: &[f64]) -> FreeMotion {
    let motions: Vec<[f64; 6]> =
        (0..system.forces.len()).map(|joint| system.equations.motion(joint, x, false)).collect();
    let shift = |m: &[f64; 6]| norm([m[0], m[1], m[2]]) / system.size;
    let spin = |m: &[f64; 6]| norm([m[3], m[4], m[5]]);
    let largest = |of: &dyn Fn(&[f64; 6]) -> f64| {
        let mut best = (0, 0.0);
        for (joint, motion) in motions.iter().enumerate() {
            if of(motion) > best.1 * (1.0 + 1e-9) {
                best = (joint, of(motion));
            }
        }
        best
    };
    let (shifted, by) = largest(&shift);
    let (turned, angle) = largest(&spin);
    // A turn in place moves nothing else; where nodes move, that is what a person sees first.
    let turns = by < 1e-6 * angle;
    let joint = if turns { turned } else { shifted };
    let m = motions[joint];
    let direction = if turns { [m[3], m[4], m[5]] } else { [m[0], m[1], m[2]] };
    let length = norm(direction);
    let size = |m: &[f64; 6]| shift(m).max(spin(m));
    let threshold = 1e-3 * by.max(angle);
    FreeMotion {
        place: Place::Node(system.topology.references[joint]),
        direction: if length > 0.0 { scale(1.0 / length, direction) } else { direction },
        turns,
        nodes: (0..motions.len())
            .filter(|&j| size(&motions[j]) > threshold)
            .map(|j| system.topology.references[j])
            .collect(),
    }
}
