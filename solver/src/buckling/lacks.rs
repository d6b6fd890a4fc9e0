//! What elements of one order less would lack of what a critical motion bends and twists.
//!
//! Nodes of an element of order P tell the spins φ as polynomials of degree P of −1 ≤ ξ ≤ 1, and curvatures κ = (2/h) dφ/dξ as ones
//! of degree P − 1. The highest Legendre component of these is what elements of the next lower order do not have. Of a motion
//! with xᵀ K x = 1 its energy is the part by which a critical factor is larger there (Rayleigh's principle).

use pennate_elements::rotation::{inverse, turn};
use pennate_elements::small::apply;

use crate::chain::ElementState;
use crate::spectral::shape::Shape;
use crate::system::System;

/// The part of a factor that belongs to the highest components of the curvatures of all elements.
pub(super) fn lacking(system: &System<6>, shape: &Shape) -> f64 {
    let member = |(index, points): (usize, &Vec<[f64; 6]>)| -> f64 {
        let slot = &system.members.slots[index];
        let pack = &system.members.packs[slot.pack];
        let order = pack.order();
        let of = |e: usize| highest(&pack.element(slot.lane, e), &points[e * order..=(e + 1) * order]);
        (0..pack.elements()).map(of).sum()
    };
    shape.members.iter().enumerate().map(member).sum()
}

/// Energy of the highest Legendre component of the curvatures of an element, whose nodes have these motions.
fn highest(state: &ElementState<6>, nodes: &[[f64; 6]]) -> f64 {
    let order = nodes.len() - 1;
    let length = state.piece.length;
    let place = |i: usize| 2.0 * i as f64 / order as f64 - 1.0;
    // The coefficient of ξᴾ of a spin is its divided difference; that of the curvature is P (2/h) times as large.
    let weight = |i: usize| -> f64 {
        let others = (0..=order).filter(|&j| j != i);
        others.map(|j| 1.0 / (place(i) - place(j))).product()
    };
    let weights: Vec<f64> = (0..=order).map(weight).collect();
    // A Legendre polynomial of degree n = P − 1 has (2n)! / 2ⁿ n!² of ξⁿ, and the square 2 / (2n + 1).
    let leading = (1..order).fold(1.0, |c, i| c * (2.0 * i as f64 - 1.0) / i as f64);
    let square = (2.0 * order as f64 / length / leading).powi(2) * length / (2.0 * order as f64 - 1.0);
    let axis = |c: usize| -> f64 { weights.iter().zip(nodes).map(|(weight, node)| weight * node[3 + c]).sum() };
    let spin = apply(&state.piece.axes, &turn(inverse(state.ends[0].rotation), [axis(0), axis(1), axis(2)]));
    let is_free = |c: &usize| state.moduli.held[3 + c] == 0.0;
    (0..3).filter(is_free).map(|c| state.moduli.stiffness[3 + c] * square * spin[c] * spin[c]).sum()
}
