//! Derivatives with respect to sections, against differences of whole solves.

use std::sync::Arc;

use crate::common::{AXES, Fixed, cantilever, elastic};
use pennate_solver::continuation;
use pennate_solver::newton::{Newton, Start};
use pennate_solver::structure::{Dimension, Drive, SectionState, Segment, Structure};
use pennate_solver::system::System;
use pennate_solver::{joints::Active, joints::Held, joints::HeldKind, packs};

const PLANE: Active<3> = [0, 1, 5];
const SPACE: Active<6> = [0, 1, 2, 3, 4, 5];
const FORCES: [f64; 3] = [0.3, 1.1, 0.4];

/// A rod of two different segments, the second contracted, under a force that bends it far.
fn rod(dimension: Dimension, factors: [[f64; 6]; 2], strains: [f64; 2], shear_rigid: bool) -> Structure {
    let mut structure = cantilever(dimension, 10.0, elastic(1.0, 1.0, 1.0, 1.0), 2, 4);
    structure.members[0].segments = vec![
        Segment { length: 3.0, elements: 2, law: 0, initial_curvature: [0.0; 3] },
        Segment { length: 7.0, elements: 4, law: 1, initial_curvature: [0.0; 3] },
    ];
    structure.laws = (0..2)
        .map(|i| {
            let mut section = elastic(40.0 + 20.0 * i as f64, 30.0, 50.0, 60.0 - 15.0 * i as f64);
            let [a, b, c, d, e, f] = factors[i];
            section.ea *= a;
            section.ga2 *= if shear_rigid { f64::INFINITY } else { b };
            section.ga3 *= if shear_rigid { f64::INFINITY } else { c };
            section.gj *= d;
            section.ei2 *= e;
            section.ei3 *= f;
            Arc::new(Fixed(SectionState { section, strain: strains[i], curvature: [0.0; 3] })) as _
        })
        .collect();
    structure.drives = vec![Drive::Control, Drive::Force(1, 0), Drive::Force(1, 1), Drive::Force(1, 2)];
    structure.members[0].control = Some(0);
    structure
}

fn solved<const D: usize>(structure: Structure, active: Active<D>) -> System<D>
where
    System<D>: Packed<D>,
{
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, &[]);
    let chains = <System<D> as Packed<D>>::chains(&structure);
    let mut system = System::new(Arc::clone(&structure), topology, chains, active, false);
    let held = (0..6).map(|component| {
        let axis = AXES[component % 3];
        let kind = HeldKind::of(component, axis);
        Held { node: 0, component, kind, from: 0.0, to: 0.0 }
    });
    system.hold(held.collect());
    let drives = [1.0, FORCES[0], FORCES[1], if D == 6 { FORCES[2] } else { 0.0 }];
    for part in [0.25, 0.5, 0.75, 1.0] {
        system.loading.drives = drives.map(|drive| part * drive).to_vec();
        system.apply_drives();
        Newton::default().solve(&mut system, Start::nearby()).unwrap();
    }
    // Mixed stresses are one iteration behind the state.
    system.advance(false);
    system.assemble(false);
    system
}

trait Packed<const D: usize> {
    fn chains(structure: &Structure) -> Vec<Box<dyn pennate_solver::chain::Pack<D>>>;
}

impl Packed<3> for System<3> {
    fn chains(structure: &Structure) -> Vec<Box<dyn pennate_solver::chain::Pack<3>>> {
        packs::plane(structure, 0)
    }
}

impl Packed<6> for System<6> {
    fn chains(structure: &Structure) -> Vec<Box<dyn pennate_solver::chain::Pack<6>>> {
        packs::space(structure, 0)
    }
}

fn tip<const D: usize>(system: &System<D>, component: usize) -> f64 {
    system.places.component::<D>(&system.topology.links[1], component)
}

fn compare<const D: usize>(dimension: Dimension, active: Active<D>, shear_rigid: bool)
where
    System<D>: Packed<D>,
{
    let base = ([[1.0; 6]; 2], [-0.05, -0.15]);
    let mut system = solved(rod(dimension, base.0, base.1, shear_rigid), active);
    let step: f64 = 1e-5;
    // A held strain leaves the tangent its auxiliary stiffness, 1e8 times that of bending.
    let tolerance = if shear_rigid { 1e-7 } else { 1e-8 };
    // Rotations in space add as spins only about small ones; displacements say all there is to say.
    let outputs: Vec<usize> = active.iter().copied().filter(|&c| c < 3 || D == 3).collect();
    for output in outputs {
        let found = system.sensitivities(1, output).unwrap();
        for segment in 0..2 {
            for component in active {
                let at = |sign: f64| {
                    let mut factors = base.0;
                    factors[segment][component] = (sign * step).exp();
                    tip(&solved(rod(dimension, factors, base.1, shear_rigid), active), output)
                };
                let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
                let exact = found[0][segment].stiffness[component];
                assert!(
                    (difference - exact).abs() < tolerance * (1.0 + exact.abs()),
                    "{output} {segment} {component}: {exact} {difference}"
                );
            }
            let at = |sign: f64| {
                let mut strains = base.1;
                strains[segment] += sign * step;
                tip(&solved(rod(dimension, base.0, strains, shear_rigid), active), output)
            };
            let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
            let exact = found[0][segment].strain[0];
            assert!(
                (difference - exact).abs() < tolerance * (1.0 + exact.abs()),
                "{output} {segment} strain: {exact} {difference}"
            );
        }
    }
}

#[test]
fn derivatives_by_stiffness_and_strain_are_those_of_the_solution() {
    for shear_rigid in [false, true] {
        compare::<3>(Dimension::Plane, PLANE, shear_rigid);
        compare::<6>(Dimension::Space, SPACE, shear_rigid);
    }
}

/// A straight bar: u = F L/EA + ε* L.
#[test]
fn a_straight_bar_has_the_derivatives_of_its_formula() {
    let mut structure = rod(Dimension::Plane, [[1.0; 6]; 2], [0.0, -0.2], true);
    structure.drives.truncate(2);
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, &[]);
    let mut system = System::new(Arc::clone(&structure), topology, packs::plane(&structure, 0), PLANE, false);
    let held = [0, 1, 5].map(|component| {
        let axis = AXES[component % 3];
        let kind = HeldKind::of(component, axis);
        Held { node: 0, component, kind, from: 0.0, to: 0.0 }
    });
    system.hold(held.to_vec());
    system.loading.drives = vec![1.0, 6.0];
    system.apply_drives();
    Newton::default().solve(&mut system, Start::nearby()).unwrap();
    let [first, second] = system.sensitivities(1, 0).unwrap()[0][..] else { panic!("two segments") };
    assert!((first.stiffness[0] + 6.0 * 3.0 / 40.0).abs() < 1e-12);
    assert!((second.stiffness[0] + 6.0 * 7.0 / 60.0).abs() < 1e-12);
    assert!((first.strain[0] - 3.0).abs() < 1e-12 && (second.strain[0] - 7.0).abs() < 1e-12);
    assert!(first.stiffness[5].abs() < 1e-12);
}
