//! Networks that once ended elsewhere than in small increments, without a word: files of `tests/cases/increments/`, and seeds
//! of random networks whose sections the format cannot say, since their stiffness follows the actuation.

use pennate_solver::options::Options;
use pennate_testing::increments::{apart, apart_from_small};
use pennate_testing::random::case::case;
use pennate_testing::random::check::residual;
use pennate_testing::random::network::LENGTH;
use pennate_testing::random::stiff::stiff_case;
use pennate_testing::repository;

/// Nodes of a random network at most.
const MOST: usize = 16;
/// The same of those with stiff and slender parts.
const MOST_STIFF: usize = 110;

/// What each file once broke stands in its first line.
#[test]
fn networks_that_once_ended_elsewhere_end_where_small_increments_do() {
    let folder = repository("tests/cases/increments");
    let entries = std::fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("a file").path());
    let mut files: Vec<_> = entries.collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a network file");
        assert!(text.starts_with("# "), "{}: what did it break?", file.display());
        assert_eq!(apart(&text), Ok(None), "{}", file.display());
    }
}

#[track_caller]
fn ends_where_small_increments_do(seed: u64) {
    let (_, network, steps) = case(seed, MOST);
    assert_eq!(apart_from_small(&network.structure, &steps, LENGTH), Ok(None), "seed {seed}");
}

#[track_caller]
fn stiff_ends_where_small_increments_do(seed: u64) {
    let (_, network, steps) = stiff_case(seed, MOST_STIFF);
    assert_eq!(apart_from_small(&network.structure, &steps, LENGTH), Ok(None), "seed {seed}");
}

/// The count of negative pivots rises within one increment that hardly moves: members of the state that it found have buckled, and
/// those of the path have not.
#[test]
fn increments_without_a_potential_do_not_buckle_what_small_ones_do_not() {
    for seed in [1178, 3098] {
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
    ends_where_small_increments_do(356);
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

/// Increments of less than a thousandth of the ramp leapt too, and stable states lie on more than one path.
#[test]
fn short_increments_and_those_with_a_potential_are_held_against_their_parts_too() {
    for seed in [2479, 7418, 739, 1509, 5355, 6507, 7687, 8067] {
        ends_where_small_increments_do(seed);
    }
}

/// A slender member bows to the other side of a bifurcation that is not quite perfect, by a hundredth of a radian or less; what
/// foresees another way is made again in two parts.
#[test]
fn increments_end_on_their_side_of_a_bifurcation_that_is_not_quite_perfect() {
    for seed in [325_113, 332_867, 200_852] {
        stiff_ends_where_small_increments_do(seed);
    }
}

/// A moment in space that fades while its rotation is let go has a potential at the end of the ramp, and none on the way.
#[test]
fn what_fades_without_a_potential_is_followed_as_such() {
    stiff_ends_where_small_increments_do(331_351);
}

/// A moment and a follower force on a joint that is held about some axes have a potential until the joint has turned: one increment led to a
/// state of five negative pivots.
#[test]
fn a_potential_that_is_lost_on_the_way_is_noticed() {
    stiff_ends_where_small_increments_do(340_346);
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
