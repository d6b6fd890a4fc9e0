//! Cantilevers with known answers.

use crate::common::{cantilever, elastic, solve_one};
use pennate_solver::history::Status;
use pennate_solver::structure::{Dimension, Drive};
use std::f64::consts::{PI, TAU};

/// Pure bending: the moment 2π EI/L closes a cantilever into a circle, whatever the mesh.
#[test]
fn end_moment_rolls_a_cantilever_into_a_circle() {
    for dimension in [Dimension::Plane, Dimension::Space] {
        let beam = cantilever(dimension, 10.0, elastic(1e4, 5e3, 100.0, 100.0), 8, 3);
        let (step, history) = solve_one(beam, &[(Drive::Moment(1, 2), TAU * 100.0 / 10.0)]);
        assert_eq!(step.status, Status::Converged);
        let tip = &step.increments.last().unwrap().state.nodes[1];
        let off = [tip.displacement[0] + 10.0, tip.displacement[1], tip.displacement[2]];
        println!("{dimension:?} {off:?} {} factorizations, {:?}", step.factorizations, history.mesh);
        assert!(off.iter().all(|x| x.abs() < 1e-3));
        // In space the moment has no potential, and the increment is made again in two parts.
        assert!(step.factorizations <= if dimension == Dimension::Plane { 9 } else { 15 });
        let root = &step.increments.last().unwrap().state.nodes[0];
        assert!((root.reaction_moment[2] + TAU * 10.0).abs() < 1e-6, "{:?}", root.reaction_moment);
    }
}

/// Mattiasson's elastica, k = P L²/EI = 10, with a rigid section.
#[test]
fn elastica_under_a_tip_load() {
    for dimension in [Dimension::Plane, Dimension::Space] {
        for (order, tolerance) in [(2, 1e-5), (3, 1e-7), (4, 1e-8)] {
            let beam = cantilever(dimension, 1.0, elastic(f64::INFINITY, f64::INFINITY, 1.0, 1.0), 16, order);
            let (step, _) = solve_one(beam, &[(Drive::Force(1, 1), -10.0)]);
            assert_eq!(step.status, Status::Converged, "{:?}", step.failure);
            let state = &step.increments.last().unwrap().state;
            let tip = state.nodes[1].displacement;
            let errors = [tip[0] + 0.55499559775375126957, tip[1] + 0.81060902488029645323];
            let turn = state.nodes[1].rotation[2] + 1.430285538803857529;
            let root = state.nodes[0];
            println!(
                "{dimension:?} p{order} {errors:?} {turn:e} factorizations {} residual {:e} stable {:?} {:?}",
                step.factorizations, state.residual, step.stable, root.reaction_moment
            );
            assert!(errors.iter().all(|x| x.abs() < tolerance));
            assert!((root.reaction_force[1] - 10.0).abs() < 1e-8);
            assert!(step.factorizations <= 35);
        }
    }
}

/// The count of iterations does not depend on slenderness.
#[test]
fn slender_elastica_takes_no_more_iterations() {
    for ea in [1e4, 1e6, 1e8] {
        let beam = cantilever(Dimension::Plane, 1.0, elastic(ea, ea / 2.5, 1.0, 1.0), 8, 3);
        let (step, _) = solve_one(beam, &[(Drive::Force(1, 1), -10.0)]);
        println!("EA {ea:e}: {} factorizations, {} increments", step.factorizations, step.increments.len());
        assert_eq!(step.status, Status::Converged);
        assert!(step.factorizations <= 35);
    }
}

/// Axial stretch is exact on one element.
#[test]
fn a_bar_stretches_by_force_over_stiffness() {
    let beam = cantilever(Dimension::Plane, 4.0, elastic(200.0, 50.0, 3.0, 3.0), 1, 1);
    let (step, _) = solve_one(beam, &[(Drive::Force(1, 0), 20.0)]);
    let state = &step.increments.last().unwrap().state;
    assert!((state.nodes[1].displacement[0] - 0.4).abs() < 1e-13);
    assert!((state.members[0].axial_force - 20.0).abs() < 1e-11);
    assert!((state.members[0].length - 4.4).abs() < 1e-13);
    let _ = PI;
}
