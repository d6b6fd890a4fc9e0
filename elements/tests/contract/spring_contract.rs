//! Springs between nodes keep the element contract; ground springs have the right gradient and Hessian.

use pennate_elements::check::{Answer, contract};
use pennate_elements::rotation;
use pennate_elements::small::{add, scale};
use pennate_elements::space::Pose;
use pennate_elements::spring::{self, SpringResponse, SpringStrain};

fn answer(response: &SpringResponse) -> Answer {
    let g = response.gradient;
    Answer {
        energy: response.energy,
        gradient: vec![std::array::from_fn(|i| g[i]), std::array::from_fn(|i| g[6 + i])],
        tangent: response.tangent.iter().map(|row| row.to_vec()).collect(),
    }
}

fn poses(large: f64) -> [Pose<f64>; 2] {
    [
        Pose { displacement: [0.3, -0.4, 0.2], rotation: rotation::exp(scale(large, [0.2, 0.7, -0.3])) },
        Pose { displacement: [-0.6, 0.9, 1.1], rotation: rotation::exp(scale(large, [0.5, 0.1, 0.9])) },
    ]
}

#[test]
fn springs_between_nodes_keep_the_contract() {
    let arm = [4.0, 1.0, -2.0];
    for large in [0.0, 0.05, 1.0, 2.5] {
        let poses = poses(large);
        contract(&[[0.0; 3], arm], &poses, &|p| {
            answer(&spring::coupling(&[3.0, 2.0, 1.0, 5.0, 7.0, 11.0], arm, [&p[0], &p[1]]))
        });
        contract(&[[0.0; 3], arm], &poses, &|p| answer(&spring::axial(3.0, 2.0, arm, [&p[0], &p[1]]).0));
    }
}

#[test]
fn a_ground_spring_pulls_along_its_rotation_vector() {
    let theta = [0.4, -1.1, 0.7];
    let pose = Pose { displacement: [1.0, 2.0, 3.0], rotation: rotation::exp(theta) };
    let isotropic = spring::ground(&[1.0, 1.0, 1.0, 4.0, 4.0, 4.0], &pose, [0.0; 3]);
    // An isotropic rotational spring has the moment k θ.
    for i in 0..3 {
        assert!((isotropic.gradient[3 + i] - 4.0 * theta[i]).abs() < 1e-13);
        assert!((isotropic.gradient[i] - (i + 1) as f64).abs() < 1e-15);
    }
    let k = [0.0, 0.0, 0.0, 1.0, 3.0, 9.0];
    let at = spring::ground(&k, &pose, [0.0; 3]);
    let h = 1e-5;
    for i in 0..3 {
        let turned = |by: f64| {
            let mut axis = [0.0; 3];
            axis[i] = by;
            let rotation = rotation::compose(rotation::exp(axis), pose.rotation);
            spring::ground(&k, &Pose { rotation, displacement: add(pose.displacement, [0.0; 3]) }, [0.0; 3])
        };
        let (ahead, behind) = (turned(h), turned(-h));
        assert!(((ahead.energy - behind.energy) / (2.0 * h) - at.gradient[3 + i]).abs() < 1e-8);
        let second = (ahead.energy - 2.0 * at.energy + behind.energy) / (h * h);
        assert!((second - at.tangent[3 + i][3 + i]).abs() < 1e-3);
    }
}

/// A pose that is moved by displacement and spin.
fn moved(pose: &Pose<f64>, by: &[f64]) -> Pose<f64> {
    Pose {
        displacement: add(pose.displacement, [by[0], by[1], by[2]]),
        rotation: rotation::compose(rotation::exp([by[3], by[4], by[5]]), pose.rotation),
    }
}

/// Of every strain q the energy is ½ k q², so that its root tells q, along a way, up to the sign.
#[test]
fn strains_have_the_derivatives_that_energies_have() {
    type Respond<'a> = Box<dyn Fn(&[Pose<f64>; 2]) -> SpringResponse + 'a>;
    let (arm, k) = ([4.0, 1.0, -2.0], 3.0);
    let way: [f64; 12] = [-0.4, 0.1, 0.2, 0.6, -0.2, 0.3, 0.5, 0.9, -0.1, 0.2, 0.4, -0.5];
    let start = poses(1.0);
    let along = |direction: &[f64; 12], h: f64| {
        let by = direction.map(|x| h * x);
        [moved(&start[0], &by[..6]), moved(&start[1], &by[6..])]
    };
    let mut springs: Vec<(Respond<'_>, SpringStrain)> = Vec::new();
    for component in 0..6 {
        let mut stiffness = [0.0; 6];
        stiffness[component] = k;
        let theta = rotation::log(start[0].rotation);
        springs.push((
            Box::new(move |p| spring::ground(&stiffness, &p[0], theta)),
            spring::ground_strains(&stiffness, &start[0], theta)[0],
        ));
        springs.push((
            Box::new(move |p| spring::coupling(&stiffness, arm, [&p[0], &p[1]])),
            spring::coupling_strains(&stiffness, arm, [&start[0], &start[1]])[0],
        ));
    }
    springs.push((
        Box::new(|p| spring::axial(k, 0.0, arm, [&p[0], &p[1]]).0),
        spring::axial_strain(k, 0.0, arm, [&start[0], &start[1]]),
    ));
    let h = 1e-4;
    for (index, (respond, found)) in springs.iter().enumerate() {
        // The strain without its sign.
        let strain = |h: f64| (2.0 * respond(&along(&way, h)).energy / k).sqrt();
        let slope = (strain(h) - strain(-h)) / (2.0 * h);
        let bend = (strain(h) - 2.0 * strain(0.0) + strain(-h)) / (h * h);
        let sign = found.force.signum();
        let gradient: f64 = (0..12).map(|i| found.gradient[i] * way[i]).sum();
        let curvature: f64 = (0..144).map(|i| way[i / 12] * found.curvature[i / 12][i % 12] * way[i % 12]).sum();
        assert!((found.force - sign * k * strain(0.0)).abs() < 1e-12, "{index}: {}", found.force);
        assert!((gradient - sign * slope).abs() < 1e-6, "{index}: {gradient} instead of {slope}");
        assert!((curvature - sign * bend).abs() < 1e-6, "{index}: {curvature} instead of {bend}");
    }
}
