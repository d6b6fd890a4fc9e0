//! Networks of `examples/hostile` that once ended elsewhere than in small increments, without a word.

use pennate_solver::history::{Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Method, Step};
use pennate_testing::random::case::case;
use pennate_testing::random::check::residual;
use pennate_testing::random::network::{LENGTH, Vector};

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

/// Two members buckle one after the other: within one increment the determinant changes its sign twice.
#[test]
fn two_singular_points_within_one_increment_are_both_found() {
    for seed in [5237, 5385] {
        ends_where_small_increments_do(seed);
    }
}

/// A member without load across it nearly buckles: the path turns aside within a ten-thousandth of the ramp, and a stride beyond
/// that finds the straight member, unstable, on a path of its own.
#[test]
fn a_path_that_nearly_bifurcates_is_followed_where_it_turns() {
    for seed in [98, 9482] {
        ends_where_small_increments_do(seed);
    }
}

/// What is lost lies within a member, and the softest motion of the joints is another.
#[test]
fn a_member_that_buckles_between_its_ends_is_found_by_its_pivots() {
    ends_where_small_increments_do(4949);
}

/// Increments of less than a thousandth of the ramp leapt too, and stable states lie on more than one path.
#[test]
fn short_increments_and_those_with_a_potential_are_held_against_their_parts_too() {
    for seed in [2479, 7418, 739, 1509, 5355, 6507, 7687, 8067] {
        ends_where_small_increments_do(seed);
    }
}

/// The last change of the fraction moves the load along members, which their ends feel an iteration later.
#[test]
fn states_along_an_arc_are_in_balance() {
    for seed in [384, 2687, 4408, 7307, 7605] {
        let (_, network, steps) = case(seed, MOST);
        let history = pennate_solver::solve(&network.structure, &steps, &Options::default(), &mut |_| true).unwrap();
        let mut values = vec![0.0; network.structure.drives.len()];
        for (step, result) in steps.iter().zip(&history.steps).take_while(|(step, _)| step.changes.is_empty()) {
            let end = result.increments.last().unwrap();
            for &(drive, target) in &step.targets {
                values[drive] += end.fraction * (target - values[drive]);
            }
            let left = residual(&network, &end.state, &values, &[]).joints;
            assert!(left < 1e-9, "seed {seed}, {:?}: {left:.1e}", step.method);
        }
    }
}
