//! Sweeps as a user meets them: the table, what failed in it, and going on later.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use pennate_models::scenes;

fn sweep(file: &Path, out: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
    command.stdin(Stdio::null()).arg("sweep").arg(file).arg("-o").arg(out).args(arguments);
    command.output().unwrap()
}

fn dyad(directory: &Path) -> std::path::PathBuf {
    let file = directory.join("dyad.toml");
    fs::write(&file, scenes::write("dyad", &[]).unwrap()).unwrap();
    file
}

#[test]
fn what_cannot_be_solved_is_a_row_with_its_reason() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    let run = sweep(&file, &out, &["--vary", "chi=30:60:15 deg", "--vary", "pressure=10,30"]);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let table = fs::read_to_string(out.join("sweep.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 7);
    assert_eq!(rows[0], "chi (deg),pressure,status,stable,stroke (mm),foot (N),error,reason");
    assert!(rows[1].starts_with("30,10,converged,yes,20.4"), "{table}");
    assert!(rows[2].starts_with("30,30,wrong_input,,,,,"), "{table}");
    assert!(rows[2].contains("beyond the table of muscle 'silicone'"), "{table}");
    assert!(rows[5].starts_with("60,10,converged,yes,"), "{table}");
    let printed = String::from_utf8(run.stdout).unwrap();
    assert!(printed.starts_with("3 solved, 3 not solved. Took"), "{printed}");
    assert!(fs::read_to_string(out.join("sweep.svg")).unwrap().contains("chi (deg)"));
}

#[test]
fn a_sweep_goes_on_where_it_was_stopped() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    let vary = ["--vary", "chi=20:60:5"];
    assert_eq!(sweep(&file, &out, &vary).status.code(), Some(0));
    let whole = fs::read_to_string(out.join("sweep.csv")).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    // As if it had been cut off after three of nine, in the middle of a row.
    fs::write(out.join("sweep.csv"), format!("{}\n35,conv", lines[..4].join("\n"))).unwrap();
    let again = sweep(&file, &out, &vary);
    let printed = String::from_utf8(again.stdout).unwrap();
    assert!(printed.starts_with("9 solved, 0 not solved; 3 of them taken from an earlier run."), "{printed}");
    assert_eq!(fs::read_to_string(out.join("sweep.csv")).unwrap(), whole);
    // Another network: nothing of the table holds.
    fs::write(&file, scenes::write("dyad", &[("pressure".into(), "15".into())]).unwrap()).unwrap();
    let refused = |arguments: &[&str], why: &str| {
        let run = sweep(&file, &out, arguments);
        assert_eq!(run.status.code(), Some(2), "{run:?}");
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(said.contains(why) && said.contains("--overwrite"), "{said}");
        assert_eq!(fs::read_to_string(out.join("sweep.csv")).unwrap(), whole);
    };
    refused(&vary, "its network or what was set in it was different");
    let over = sweep(&file, &out, &["--vary", "chi=20:60:5", "--overwrite"]);
    let other = String::from_utf8(over.stdout).unwrap();
    assert!(other.starts_with("9 solved, 0 not solved. Took"), "{other}");
}

/// Values that are not asked for, another accuracy or other parameters: the table stays.
#[test]
fn the_table_of_another_sweep_is_not_overwritten() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    assert_eq!(sweep(&file, &out, &["--vary", "chi=30,40"]).status.code(), Some(0));
    let table = fs::read(out.join("sweep.csv")).unwrap();
    for (arguments, why) in [
        (["--vary", "chi=30,50"].as_slice(), "it holds a row that this sweep does not ask for"),
        (&["--vary", "L=100,130"], "its columns are different"),
        (&["--vary", "chi=30,40", "--accuracy", "1e-8"], "its accuracy was different"),
        (&["--vary", "chi=30,40", "--set", "L=100"], "its network or what was set"),
    ] {
        let run = sweep(&file, &out, arguments);
        assert_eq!(run.status.code(), Some(2), "{run:?}");
        assert!(String::from_utf8(run.stderr).unwrap().contains(why), "{why}");
        assert_eq!(fs::read(out.join("sweep.csv")).unwrap(), table);
    }
    let more = sweep(&file, &out, &["--vary", "chi=30,40,50"]);
    let printed = String::from_utf8(more.stdout).unwrap();
    assert!(printed.starts_with("3 solved, 0 not solved; 2 of them taken from an earlier run."), "{printed}");
}

#[test]
fn a_list_of_designs_is_solved_row_by_row() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    let list = directory.path().join("designs.csv");
    fs::write(&list, "chi (deg),L\n30,130\n40,100\n30,130\n").unwrap();
    let run = sweep(&file, &out, &["--designs", list.to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let table = fs::read_to_string(out.join("sweep.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows[0], "design,chi (deg),L,status,stable,stroke (mm),foot (N),error,reason");
    assert!(
        rows[1].starts_with("1,30,130,converged,yes,") && rows[2].starts_with("2,40,100,converged,yes,"),
        "{table}"
    );
    assert_eq!(
        rows[1].split_once(',').unwrap().1.split(',').nth(4),
        rows[3].split_once(',').unwrap().1.split(',').nth(4)
    );
    fs::write(&list, "beta\n30\n").unwrap();
    let run = sweep(&file, &out, &["--designs", list.to_str().unwrap(), "--overwrite"]);
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    assert!(String::from_utf8(run.stderr).unwrap().contains("has no parameter 'beta'"));
}

/// A strut pushed on straight beyond its critical load converges, and is no answer.
#[test]
fn what_ends_unstable_counts_as_not_solved() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (directory.path().join("strut.toml"), directory.path().join("out"));
    let text = "format = \"pennate/1\"\nparameters = { P = 1 }\nnodes = { A = [0, 0], B = [100, 0] }\n\
                materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3 }\nsections.s = { rectangle = { width = 4, height = 1 } }\n\
                members.m = { nodes = [\"A\", \"B\"], section = \"s\", material = \"m\" }\nsupports.A = \"clamped\"\n\
                steps = [{ force = { B = [\"= -P\", 0] }, branch = \"primary\" }]\nprobes.u = { node = \"B\", displacement = \"ux\" }\n";
    fs::write(&file, text).unwrap();
    let run = sweep(&file, &out, &["--vary", "P=0.1,0.5"]);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let table = fs::read_to_string(out.join("sweep.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[1].starts_with("0.1,converged,yes,"), "{table}");
    assert!(rows[2].starts_with("0.5,converged,no,") && rows[2].ends_with("ends in an unstable state"), "{table}");
    assert!(String::from_utf8(run.stdout).unwrap().starts_with("1 solved, 1 not solved."));
}

#[test]
fn one_thread_and_many_write_the_same_table() {
    let directory = tempfile::tempdir().unwrap();
    let file = dyad(directory.path());
    let table = |threads: &str| {
        let out = directory.path().join(threads);
        let run = sweep(&file, &out, &["--vary", "chi=20:60:4", "--vary", "L=100,130", "--threads", threads]);
        assert_eq!(run.status.code(), Some(0), "{run:?}");
        fs::read(out.join("sweep.csv")).unwrap()
    };
    assert_eq!(table("1"), table("4"));
}

#[test]
fn parameters_that_are_not_there_are_refused_before_anything_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    for (arguments, message) in [
        (["--vary", "beta=10:60:5"].as_slice(), "has no parameter 'beta' to vary"),
        (&["--vary", "chi=10:60:5", "--set", "chi=20"], "'chi' is given values twice"),
        (&["--vary", "chi=10,20,10.0"], "'chi' has the value 10 twice"),
        (&["--vary", "chi=1:10000:1", "--vary", "L=1:10000:1"], "more than 1000000 combinations"),
        (&["--vary", "chi=10:60"], "expected, such as beta=10:60:2"),
    ] {
        let run = sweep(&file, &out, arguments);
        assert_eq!(run.status.code(), Some(2), "{run:?}");
        let shown = String::from_utf8(run.stderr).unwrap();
        assert!(shown.contains(message), "{shown}");
        assert!(!out.exists());
    }
}

/// Rows that are solved together, as many as there are, are those of the network solved alone.
#[test]
fn rows_are_those_of_networks_solved_alone() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (dyad(directory.path()), directory.path().join("out"));
    assert_eq!(sweep(&file, &out, &["--vary", "chi=20:60:5", "--vary", "pressure=5,20"]).status.code(), Some(0));
    let mut table = csv::Reader::from_path(out.join("sweep.csv")).unwrap();
    let mut rows = 0;
    for row in table.records().map(Result::unwrap) {
        let settings = [("chi", 0), ("pressure", 1)].map(|(name, column)| (name.to_owned(), row[column].to_owned()));
        let model = pennate_models::read(&file, &settings).unwrap();
        let options = pennate_solver::options::Options { estimate: true, ..Default::default() };
        let solution = pennate_analysis::accuracy::solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap();
        let alone = solution.probes.steps[0].last().unwrap();
        for (probe, alone) in alone.iter().enumerate() {
            let swept: f64 = row[4 + probe].parse().unwrap();
            assert!((swept - alone).abs() <= 1e-8 * alone.abs().max(1e-3), "{row:?}: {alone}");
        }
        assert!(row[6].parse::<f64>().unwrap() <= 1e-6, "{row:?}");
        rows += 1;
    }
    assert_eq!(rows, 18);
}
