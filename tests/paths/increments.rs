//! Networks that once ended elsewhere than in small increments, or out of balance, without a word: files of
//! `tests/cases/increments/` and `tests/cases/arcs/`. What each once broke stands in its first line.

use std::path::PathBuf;

use pennate_solver::options::Options;
use pennate_testing::increments::{apart, read};
use pennate_testing::random::check::unbalanced;
use pennate_testing::repository;

/// What is left at joints that are in balance, over the largest force.
const BALANCED: f64 = 1e-9;

/// The network files of a folder of `tests/cases/`, each of which says in its first line what it once broke.
fn files(folder: &str) -> Vec<(PathBuf, String)> {
    let folder = repository("tests/cases").join(folder);
    let entries = std::fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("a file").path());
    let mut files: Vec<PathBuf> = entries.collect();
    files.sort();
    assert!(!files.is_empty());
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a network file");
        assert!(text.starts_with("# "), "{}: what did it break?", file.display());
        (file, text)
    };
    files.into_iter().map(read).collect()
}

#[test]
fn networks_that_once_ended_elsewhere_end_where_small_increments_do() {
    for (file, text) in files("increments") {
        assert_eq!(apart(&text), Ok(None), "{}", file.display());
    }
}

#[test]
fn states_along_an_arc_are_in_balance() {
    for (file, text) in files("arcs") {
        let (structure, steps) = read(&text).expect("a network");
        let history = pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true).unwrap();
        let mut values = vec![0.0; structure.drives.len()];
        for (step, result) in steps.iter().zip(&history.steps).take_while(|(step, _)| step.changes.is_empty()) {
            let end = result.increments.last().unwrap();
            for &(drive, target) in &step.targets {
                values[drive] += end.fraction * (target - values[drive]);
            }
            let left = unbalanced(&structure, &end.state, &values, &[]);
            assert!(left < BALANCED, "{}, {:?}: {left:.1e}", file.display(), step.method);
        }
    }
}
