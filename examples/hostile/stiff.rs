//! Cases with members that cannot be stretched or sheared, or hardly.

use pennate_solver::structure::Step;

use crate::case::case;
use crate::random::{LENGTH, Network, Recipe};

/// The network and the steps of a seed, every other one with such members.
pub fn stiff_case(seed: u64, most: usize) -> (Recipe, Network, Vec<Step>) {
    let (recipe, mut network, steps) = case(seed, most);
    let mut random = fastrand::Rng::with_seed(seed.rotate_left(32));
    if random.bool() {
        stiffen(&mut network, &mut random);
    }
    (recipe, network, steps)
}

/// Makes sections that cannot be stretched or sheared, or that are up to 10⁴ times as long as their radius of gyration.
fn stiffen(network: &mut Network, random: &mut fastrand::Rng) {
    for law in &mut network.laws {
        let section = &mut law.section;
        match random.u8(0..4) {
            0 => section.ea = f64::INFINITY,
            1 => section.ea = section.ei3 * (10f64.powf(2.0 + 2.0 * random.f64()) / LENGTH).powi(2),
            2 => (section.ea, section.ga2, section.ga3) = (f64::INFINITY, f64::INFINITY, f64::INFINITY),
            _ => {}
        }
        if random.bool() {
            (section.ga2, section.ga3) = (f64::INFINITY, f64::INFINITY);
        }
    }
    network.adopt_laws();
}
