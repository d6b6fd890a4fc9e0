//! A state on elements of the next order, which says what a mesh is wrong by.

use std::sync::Arc;

use pennate_solver::continuation;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::{Held, HeldKind};
use pennate_solver::newton::{Aim, Newton, Start};
use pennate_solver::packs;
use pennate_solver::results;
use pennate_solver::structure::{Dimension, Drive};
use pennate_solver::system::System;

use crate::common::{AXES, cantilever, elastic};

/// From an equilibrium one increment leads to that of the next order, and forces by the factors at hand tell that it is one: to linearize
/// there once more, where elements keep no factors to go on with, would double what an estimate takes.
#[test]
fn a_comparison_linearizes_once() {
    let mut structure = cantilever(Dimension::Plane, 10.0, elastic(1e4, 5e3, 100.0, 100.0), 6, 2);
    structure.drives = vec![Drive::Force(1, 1)];
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, &[]);
    let build = |enrich| {
        let chains = packs::plane(&structure, enrich);
        let mut system = System::new(Arc::clone(&structure), Arc::clone(&topology), chains, [0, 1, 5], false);
        let row = |component: usize| Held {
            node: 0,
            component,
            kind: HeldKind::of(component, AXES[component % 3]),
            from: 0.0,
            to: 0.0,
        };
        system.hold([0, 1, 5].map(row).to_vec());
        system.loading.drives = vec![-0.5];
        system.apply_drives();
        system
    };
    let mut system = build(0);
    Newton::default().solve(&mut system, Start::nearby()).unwrap();

    let refined = |start: Start<'_>| {
        let mut finer = build(1);
        finer.prolong(&system);
        let found = Newton::default().solve(&mut finer, start).unwrap();
        (found.factorizations, results::equilibrium(&mut finer))
    };
    let compared = Start { aim: Aim::Comparison, reuses_factors: Some(0.0), ..Start::nearby() };
    let ((once, state), (often, exact)) = (refined(compared), refined(Start::nearby()));
    assert_eq!(once, 1);
    assert!(often > 1);
    // Forces may be left by a hundredth of what they were at first.
    let tip = |state: &Equilibrium| state.nodes[1].displacement[1];
    let of_mesh = (tip(&results::equilibrium(&mut system)) - tip(&exact)).abs();
    assert!((tip(&state) - tip(&exact)).abs() < 1e-2 * of_mesh, "{of_mesh:e}");
}
