//! The pseudo-rigid-body model against the high-fidelity data, and against itself.

use pennate_analysis::fit::data::{self, Case};
use pennate_analysis::fit::{TESTS, prb};
use pennate_models::prb::{Prb, TORSION_UNIT};
use pennate_testing::muscle as hifi;

/// The free stroke, and the cases that are fitted.
fn cases(length: f64, pressure: f64) -> (f64, Vec<Case>) {
    let mut all = data::read(&hifi::load_cases()).unwrap().cases;
    all.retain(|case| case.variant == "A");
    (hifi::stroke(&all, length, pressure), hifi::cases(&all, length, pressure, &TESTS))
}

#[test]
fn every_start_comes_to_one_model_of_the_data() {
    for (pressure, gamma) in [(10.0, 0.654), (25.0, 0.701)] {
        let (stroke, cases) = cases(130.0, pressure);
        let fitted = prb::fit(stroke, &cases).unwrap();
        assert_eq!(fitted.agreeing, [5, 5]);
        assert!(fitted.on_bounds.is_empty());
        assert!((fitted.model.gamma - gamma).abs() < 2e-3, "{}", fitted.model.gamma);
        let [axial, bending, slope] = fitted.errors.mean;
        assert!(axial < 0.6 && bending < 2.3 && slope < 1.2, "{:?}", fitted.errors);
    }
}

/// The two springs along the middle share the measured axial stiffness: K_ex is half of it.
#[test]
fn the_extension_springs_are_two() {
    let (stroke, cases) = cases(130.0, 20.0);
    let fitted = prb::fit(stroke, &cases).unwrap();
    let axial = cases.iter().filter(|case| case.is_axial());
    let (mut forces, mut strokes) = (0.0, 0.0);
    for case in axial {
        let stretched = case.tip[0] - (case.length - stroke);
        forces += case.force[0] * stretched;
        strokes += case.force[0] * case.force[0];
    }
    // Least squares of the motion by the force, which is what the fit does.
    let compliance = forces / strokes;
    assert!((2.0 * fitted.model.extension * compliance - 1.0).abs() < 1e-4, "{}", fitted.model.extension);
}

#[test]
fn a_known_model_is_found_again() {
    let known = Prb { length: 130.0, stroke: 14.0, gamma: 0.55, torsion: 2.2 * TORSION_UNIT, extension: 0.9 };
    let (_, mut cases) = cases(130.0, 20.0);
    for case in &mut cases {
        let [x, y, slope] = known.under_load(case.force, case.moment).unwrap();
        (case.tip, case.slope) = ([x, y], slope);
    }
    let fitted = prb::fit(known.stroke, &cases).unwrap();
    for (found, expected) in fitted.parameters().into_iter().zip([0.55, 2.2, 0.9]) {
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}

/// A muscle stiffer in bending than the bounds allow ends on one, and the fit says on which.
#[test]
fn a_stiffness_beyond_its_bound_is_named() {
    let stiff = Prb { length: 130.0, stroke: 14.0, gamma: 0.55, torsion: 14.0 * TORSION_UNIT, extension: 0.9 };
    let (_, mut cases) = cases(130.0, 20.0);
    for case in &mut cases {
        let [x, y, slope] = stiff.under_load(case.force, case.moment).unwrap();
        (case.tip, case.slope) = ([x, y], slope);
    }
    let fitted = prb::fit(stiff.stroke, &cases).unwrap();
    assert!(fitted.on_bounds.contains(&"K_th"), "{:?}", fitted.parameters());
}
