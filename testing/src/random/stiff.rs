//! Cases with members that cannot be stretched or sheared, or hardly.

use pennate_solver::structure::Step;

use super::case::case;
use super::network::{LENGTH, Network, Recipe};

/// The network and the steps of a seed, every other one with such members.
pub fn stiff_case(seed: u64, most: usize) -> (Recipe, Network, Vec<Step>) {
    let (recipe, mut network, steps) = case(seed, most);
    let mut random = fastrand::Rng::with_seed(seed.rotate_left(32));
    if random.bool() {
        stiffen(&mut network, &mut random);
    }
    (recipe, network, steps)
}

/// Makes sections that cannot be sheared, that are up to 10⁴ times as long as their radius of gyration, or, in the tree that
/// holds the network, that cannot be stretched.
///
/// What closes a loop can be stretched, and what cannot does not contract: rigid triangles have forces that nothing
/// determines, and one whose sides are to shorten has no equilibrium at all.
fn stiffen(network: &mut Network, random: &mut fastrand::Rng) {
    let tree = network.structure.nodes.len() - 1;
    for (index, law) in network.laws.iter_mut().enumerate() {
        let section = &mut law.section;
        let kind = random.u8(0..3);
        if kind == 0 && index < tree {
            (section.ea, law.strain) = (f64::INFINITY, 0.0);
        } else if kind == 1 {
            section.ea = section.ei3 * (10f64.powf(2.0 + 2.0 * random.f64()) / LENGTH).powi(2);
        }
        if random.bool() {
            (section.ga2, section.ga3) = (f64::INFINITY, f64::INFINITY);
        }
    }
    network.adopt_laws();
}
