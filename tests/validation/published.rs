//! Every folder of `validation/` against its reference, with default settings and on a fine mesh.

use std::path::Path;

use serde_json::Value;

use pennate_testing::comparison::{Case, Setting};
use pennate_testing::program::{results, settings};

/// Largest factor between an estimated error and the true one.
const ESTIMATE_FACTOR: f64 = 10.0;

macro_rules! cases {
    ($($test:ident: $folder:literal,)*) => {
        $(
            #[test]
            fn $test() {
                validate($folder);
            }
        )*

        /// A folder that no test names would be validated by nobody.
        #[test]
        fn every_folder_is_tested() {
            assert_eq!(Case::names(), [$($folder),*]);
        }
    };
}

cases! {
    roll_up: "01_roll_up",
    elastica_tip_load: "02_elastica_tip_load",
    follower_tip_load: "03_follower_tip_load",
    bathe_bolourchi_bend: "04_bathe_bolourchi_bend",
    williams_toggle: "06_williams_toggle",
    helical_roll_up: "09_helical_roll_up",
    euler_post_buckling: "10_euler_post_buckling",
    hsim_member: "12_hsim_member",
    pennate_dyad: "13_pennate_dyad",
    dyad_asymmetric: "14_dyad_asymmetric",
    tripod: "15_tripod",
    soft_stiff_series: "16_soft_stiff_series",
    extreme_slenderness: "17_extreme_slenderness",
    helix_actuated: "18_helix_actuated",
    boundary_layers: "20_boundary_layers",
    peers: "peers",
}

#[test]
fn every_result_of_the_references_is_checked() {
    for name in Case::names() {
        assert_eq!(Case::open(&name).unchecked(), Vec::<String>::new(), "{name}");
    }
}

/// Runs all network files of a folder; fails with everything that is wrong, not with the first.
fn validate(folder: &str) {
    let case = Case::open(folder);
    let mut failures = Vec::new();
    for run in case.runs() {
        for setting in [Setting::Default, Setting::Fine] {
            let outcome = case.compare(run, setting, solve);
            let title = format!("{} ({setting:?})", outcome.label);
            if let Some(worst) = outcome.worst() {
                println!("{title}: worst {:.1e}, {}, {}", worst.relative(), worst.step, worst.quantity);
            }
            failures.extend(outcome.failures().into_iter().map(|failure| format!("{title}: {failure}")));
            if let Some((factor, row)) = outcome.worst_estimate() {
                println!("  estimate: true error {factor:.2e} times the estimate, {}, {}", row.step, row.quantity);
                if !(1.0 / ESTIMATE_FACTOR..=ESTIMATE_FACTOR).contains(&factor) {
                    failures.push(format!(
                        "{title}: {}, {}: the error is {factor:.1e} times its estimate (relative error {:.1e})",
                        row.step,
                        row.quantity,
                        row.relative()
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The results of the command line.
fn solve(network: &Path, set: &[(String, String)], accuracy: Option<&str>) -> Result<Value, String> {
    let mut more = settings(set);
    more.extend(accuracy.map(|accuracy| format!("--accuracy={accuracy}")));
    results(env!("CARGO_BIN_EXE_pennate"), "solve", network, &more)
}
