//! Springs between nodes keep the element contract; ground springs have the right gradient and Hessian.

use pennate_elements::check::{Answer, contract};
use pennate_elements::rotation;
use pennate_elements::small::{add, scale};
use pennate_elements::space::Pose;
use pennate_elements::spring::{self, SpringResponse};

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
