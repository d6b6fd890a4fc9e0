//! Transferred loads against a frame of straight bars that is written down here: minus what a clamp at the point receives.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};
use pennate_models::Model;
use pennate_models::model::{LoadFlow, SegmentLaw};
use pennate_solver::structure::{Dimension, Spring};

use crate::{of, of_text, text};

/// The stiffness of a bar that does not shear, ends at p and q: 12 × 12, displacement and rotation of each end in turn.
fn bar(model: &Model, member: usize, p: Vector3<f64>, q: Vector3<f64>) -> SMatrix<f64, 12, 12> {
    let data = &model.members[member];
    let SegmentLaw::Fixed(law) = &data.segments[0].material else { panic!("a wire expected") };
    let section = &law.section;
    let length = (q - p).norm();
    let mut stiffness = SMatrix::<f64, 12, 12>::zeros();
    let mut pair = |i: usize, j: usize, value: f64| {
        stiffness[(i, j)] += value;
        if i != j {
            stiffness[(j, i)] += value;
        }
    };
    for (component, value) in [(0, section.ea / length), (3, section.gj / length)] {
        pair(component, component, value);
        pair(component + 6, component + 6, value);
        pair(component, component + 6, -value);
    }
    // Bending along axis 2 turns about axis 3, along axis 3 about axis 2 the other way.
    for (across, about, sign, flexural) in [(1, 5, 1.0, section.ei3), (2, 4, -1.0, section.ei2)] {
        let k = flexural / length.powi(3);
        pair(across, across, 12.0 * k);
        pair(across + 6, across + 6, 12.0 * k);
        pair(across, across + 6, -12.0 * k);
        for end in [about, about + 6] {
            pair(across, end, sign * 6.0 * length * k);
            pair(across + 6, end, -sign * 6.0 * length * k);
            pair(end, end, 4.0 * length * length * k);
        }
        pair(about, about + 6, 2.0 * length * length * k);
    }
    let axes = Matrix3::from_columns(&data.axes.map(Vector3::from)).transpose();
    let mut turn = SMatrix::<f64, 12, 12>::zeros();
    (0..4).for_each(|block| turn.fixed_view_mut::<3, 3>(3 * block, 3 * block).copy_from(&axes));
    turn.transpose() * stiffness * turn
}

/// What a clamp at a part of a member receives under the loads of the inputs, which are guided along global axes.
fn reaction(model: &Model, request: &LoadFlow, cut: usize, part: f64) -> [f64; 6] {
    let places: Vec<Vector3<f64>> = model.nodes.iter().map(|node| Vector3::from(node.position)).collect();
    let clamp = places.len();
    let size = 6 * (clamp + 1);
    let mut stiffness = DMatrix::<f64>::zeros(size, size);
    let mut add = |[a, b]: [usize; 2], block: &SMatrix<f64, 12, 12>| {
        for i in 0..12 {
            for j in 0..12 {
                let of = |k: usize| if k < 6 { 6 * a + k } else { 6 * b + k - 6 };
                stiffness[(of(i), of(j))] += block[(i, j)];
            }
        }
    };
    let mut held = vec![false; size];
    let mut used = vec![false; places.len()];
    for &member in &request.members {
        let [a, b] = model.members[member].nodes;
        (used[a], used[b]) = (true, true);
        if member == cut {
            let middle = places[a] + part * (places[b] - places[a]);
            add([a, clamp], &bar(model, member, places[a], middle));
            add([clamp, b], &bar(model, member, middle, places[b]));
        } else {
            add([a, b], &bar(model, member, places[a], places[b]));
        }
    }
    for spring in &model.springs {
        let Spring::Ground { node, stiffness: values } = &spring.spring else {
            panic!("a spring to the ground expected")
        };
        (0..6).for_each(|c| stiffness[(6 * node + c, 6 * node + c)] += values[c]);
    }
    for support in &model.supports {
        (0..6).for_each(|c| held[6 * support.node + c] |= support.fixed[c]);
    }
    let mut load = DVector::<f64>::zeros(size);
    for input in &request.inputs {
        for c in 0..6 {
            if input.guided {
                held[6 * input.node + c] = input.load[c] == 0.0;
            }
            load[6 * input.node + c] = input.load[c];
        }
    }
    for node in 0..=clamp {
        for c in 0..6 {
            let flat = model.dimension == Dimension::Plane && matches!(c, 2..=4);
            held[6 * node + c] |= flat || node == clamp || !used[node];
        }
    }
    let free: Vec<usize> = (0..size).filter(|&k| !held[k]).collect();
    let inner = DMatrix::from_fn(free.len(), free.len(), |i, j| stiffness[(free[i], free[j])]);
    let moved = inner.cholesky().unwrap().solve(&DVector::from_fn(free.len(), |i, _| load[free[i]]));
    std::array::from_fn(|c| (0..free.len()).map(|i| stiffness[(6 * clamp + c, free[i])] * moved[i]).sum())
}

/// Mechanisms of straight bars without rigid bodies.
const CASES: [&str; 9] = [
    "inverter",
    "gripper",
    "morphing",
    "pushed_chain",
    "pulled_chain",
    "lever",
    "two_paths",
    "chain_in_space",
    "tripod",
];

/// A transferred load is minus what a clamp at its point receives, to ten digits of the input's load or of itself where it is
/// larger; moments are compared with forces by the length of the member.
#[test]
fn transferred_loads_are_what_a_clamp_receives() {
    let mut worst = (0.0, String::new());
    for name in CASES {
        let flow = of(name);
        for (index, member) in flow.members.iter().enumerate() {
            let number = flow.request.members[index];
            let length = flow.model.members[number].length;
            let size = |load: &[f64; 6]| {
                (0..6).map(|c| if c < 3 { load[c].abs() } else { load[c].abs() / length }).fold(0.0, f64::max)
            };
            for (k, point) in member.points.iter().enumerate().step_by(3) {
                let clamp = reaction(&flow.model, &flow.request, number, (k + 1) as f64 / 8.0);
                let difference: [f64; 6] = std::array::from_fn(|c| point.load[c] + clamp[c]);
                // The input has a unit load: far less is what rounding leaves of the motion across a slender member.
                let error = size(&difference) / size(&clamp).max(1.0);
                if error > worst.0 {
                    worst = (error, format!("{name}, {} at {k}", flow.model.members[number].name));
                }
            }
        }
    }
    println!("worst: {:.1e} in {}", worst.0, worst.1);
    assert!(worst.0 < 1e-10, "{:.1e} in {}", worst.0, worst.1);
}

/// What is attached behind a point does not change the load transferred to it.
#[test]
fn transferred_loads_do_not_depend_on_what_follows() {
    let plain = of("gripper");
    for stiffness in ["0.05", "1e6"] {
        let spring =
            format!("\n[springs]\nheld = {{ node = \"O\", stiffness = {{ ux = {stiffness}, uy = {stiffness} }} }}\n");
        let held = of_text(&(text("gripper") + &spring), &[]);
        for name in ["T1", "T2", "T3", "T4"] {
            let at = plain.model.members.iter().position(|member| member.name == name).unwrap();
            for (a, b) in plain.members[at].points.iter().zip(&held.members[at].points) {
                let [x, y, ..] = a.load;
                let difference = (0..2).map(|c| (a.load[c] - b.load[c]).abs()).fold(0.0, f64::max);
                assert!(difference < 1e-8 * x.hypot(y), "{name}: {:?} {:?}", a.load, b.load);
            }
        }
    }
}
