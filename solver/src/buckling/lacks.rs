//! What elements of lower orders would lack of what a critical motion bends and twists.
//!
//! Nodes of an element of order P tell the spins φ as polynomials of degree P of −1 ≤ ξ ≤ 1, and curvatures κ = (2/h) dφ/dξ as ones
//! of degree P − 1. The highest Legendre component of these is what elements of the next lower order do not have, the one below
//! what those of the order below that do not have either. Of a motion with xᵀ K x = 1 their energies are the parts by which a critical
//! factor is larger there (Rayleigh's principle).

use pennate_elements::rotation::{inverse, turn};
use pennate_elements::small::apply;

use crate::chain::{self, ElementState};
use crate::spectral::shape::Shape;
use crate::system::System;

/// The parts of a factor that belong to the highest components of the curvatures of all elements, and to those below.
pub(super) fn lacking(system: &System<6>, shape: &Shape) -> [f64; 2] {
    let part =
        |below| shape.members.iter().enumerate().map(|(index, points)| of_member(system, index, points, below)).sum();
    [part(0), part(1)]
}

/// Energy of the Legendre component so far below the highest one in the curvatures of a member, whose nodes have these motions.
fn of_member(system: &System<6>, index: usize, points: &[[f64; 6]], below: usize) -> f64 {
    let (pack, lane) = system.members.chain(index);
    let order = pack.mesh().order;
    let of = |e: usize| of_element(&chain::element(pack, lane, e), &points[e * order..=(e + 1) * order], below);
    (0..pack.mesh().elements()).map(of).sum()
}

/// The same of an element.
fn of_element(state: &ElementState<6>, nodes: &[[f64; 6]], below: usize) -> f64 {
    let order = nodes.len() - 1;
    // Of the spin, by ξ: the curvature has one less.
    let power = order - below;
    if power == 0 {
        return 0.0;
    }
    let length = state.piece.length;
    let place = |i: usize| 2.0 * i as f64 / order as f64 - 1.0;
    // The coefficient of ξᴾ of a spin is its divided difference, and that of the power below, since the places add up to zero, the
    // divided difference of ξ times the spin. That of ξⁿ makes n (2/h) times as much in the curvature.
    let weight = |i: usize| -> f64 {
        let others = (0..=order).filter(|&j| j != i);
        let divided: f64 = others.map(|j| 1.0 / (place(i) - place(j))).product();
        if below == 0 { divided } else { divided * place(i) }
    };
    let weights: Vec<f64> = (0..=order).map(weight).collect();
    // A Legendre polynomial of degree n has (2n)! / 2ⁿ n!² of ξⁿ, and the square 2 / (2n + 1).
    let leading = (1..power).fold(1.0, |c, i| c * (2.0 * i as f64 - 1.0) / i as f64);
    let square = (2.0 * power as f64 / length / leading).powi(2) * length / (2.0 * power as f64 - 1.0);
    let axis = |c: usize| -> f64 { weights.iter().zip(nodes).map(|(weight, node)| weight * node[3 + c]).sum() };
    let spin = apply(&state.piece.axes, &turn(inverse(state.ends[0].rotation), [axis(0), axis(1), axis(2)]));
    let is_free = |c: &usize| state.moduli.held[3 + c] == 0.0;
    (0..3).filter(is_free).map(|c| state.moduli.stiffness[3 + c] * square * spin[c] * spin[c]).sum()
}
