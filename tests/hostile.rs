//! Networks of `examples/hostile` that once ended elsewhere than in small increments, without a word.

#[path = "../examples/hostile/case.rs"]
mod case;
#[path = "../examples/hostile/random.rs"]
mod random;
#[path = "../examples/hostile/shapes.rs"]
mod shapes;

use case::case;
use pennate_solver::history::{Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Method, Step};
use random::{LENGTH, Vector};

/// Nodes of a network at most.
const MOST: usize = 16;

/// The last step that was begun.
fn last(seed: u64, increments: Option<usize>) -> StepHistory {
    let (_, network, steps) = case(seed, MOST);
    let count = |step: &Step| increments.filter(|_| step.method != Method::ArcLength);
    let steps: Vec<_> = steps.iter().map(|step| Step { min_increments: count(step), ..step.clone() }).collect();
    let history = pennate_solver::solve(&network.structure, &steps, &Options::default(), &mut |_| true).unwrap();
    let begun = history.steps.into_iter().rfind(|step| step.status != Status::NotReached);
    begun.unwrap_or_else(|| panic!("seed {seed}: no step was begun"))
}

#[track_caller]
fn ends_where_small_increments_do(seed: u64) {
    let [a, b] = [None, Some(100)].map(|increments| last(seed, increments));
    assert_eq!(a.status, b.status, "seed {seed}");
    assert!((a.fraction - b.fraction).abs() < 1e-6, "seed {seed}: {} {}", a.fraction, b.fraction);
    let [a, b] = [a, b].map(|step| step.increments.last().unwrap().state.clone());
    for (a, b) in a.nodes.iter().zip(&b.nodes) {
        let apart = (Vector::from(a.displacement) - Vector::from(b.displacement)).norm() / LENGTH;
        assert!(apart < 1e-5, "seed {seed}: {apart:.1e}");
    }
}

/// The count of negative pivots rises by two to eight within one increment that hardly moves: members of the state that it found
/// have buckled, and those of the path have not.
#[test]
fn increments_without_a_potential_do_not_buckle_what_small_ones_do_not() {
    for seed in [1178, 2306, 2696, 3098] {
        ends_where_small_increments_do(seed);
    }
}

/// The state turns quickly aside where it nearly meets another path; an increment of a thousandth of the ramp leaps there, over a
/// change of sign that lies on neither.
#[test]
fn a_change_of_sign_that_is_nowhere_zero_is_another_path() {
    for seed in [1716, 2954] {
        ends_where_small_increments_do(seed);
    }
}

/// Two limit points within one increment leave no trace in the pivots; the iteration needs long to get there.
#[test]
fn increments_that_need_many_iterations_are_made_in_parts() {
    for seed in [356, 3292] {
        ends_where_small_increments_do(seed);
    }
}
