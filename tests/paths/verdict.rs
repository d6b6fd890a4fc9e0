//! The verdict on stability agrees with the lowest mode of vibration, wherever there are both.

use std::path::{Path, PathBuf};

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::scenes::SCENES;
use pennate_models::{Model, read, read_text};
use pennate_solver::options::Options;
use pennate_testing::verdict::verdicts;

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Network files below a folder.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if path.is_dir() && !name.starts_with('.') && name != "out" {
            files(&path, found);
        } else if name.ends_with(".toml") {
            let is_network = std::fs::read_to_string(&path).is_ok_and(|text| text.contains("pennate/1"));
            found.extend(is_network.then_some(path));
        }
    }
}

/// Number of verdicts that were confirmed; those that were contradicted, with the name of the network.
fn judge(model: Model, name: &str) -> (usize, Vec<String>) {
    let found = verdicts(model);
    (found.confirmed, found.contradicted.iter().map(|wrong| format!("{name}: {wrong:?}")).collect())
}

#[test]
fn every_network_of_the_project_has_the_verdict_of_its_modes() {
    let mut found = Vec::new();
    ["models/networks", "validation", "tests/cases"].iter().for_each(|folder| files(&root(folder), &mut found));
    let (mut confirmed, mut contradicted) = (0, Vec::new());
    for file in &found {
        let Ok(model) = read(file, &[]) else { continue };
        let (good, bad) = judge(model, &file.display().to_string());
        confirmed += good;
        contradicted.extend(bad);
    }
    assert!(contradicted.is_empty(), "{contradicted:#?}");
    assert!(confirmed >= 40, "only {confirmed} of {} files", found.len());
}

#[test]
fn every_scene_has_the_verdict_of_its_modes() {
    let (mut confirmed, mut contradicted) = (0, Vec::new());
    for scene in SCENES {
        let text = scene.write(&[]).expect("a scene");
        let Ok(model) = read_text("scene.toml", &text, &[]) else { continue };
        let (good, bad) = judge(model, scene.name);
        confirmed += good;
        contradicted.extend(bad);
    }
    assert!(contradicted.is_empty(), "{contradicted:#?}");
    assert!(confirmed >= SCENES.len() / 2, "only {confirmed} of {} scenes", SCENES.len());
}

/// The soft arm near the load at which it buckles sideways; `examples/arms.rs` tries a thousand states.
#[test]
fn the_soft_arm_has_the_verdict_of_its_modes() {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut contradicted = Vec::new();
    for case in 0..30 {
        let bending = 120.0 + 52.36 * rng.f64();
        let rotating = if case % 2 == 0 { 0.0 } else { 2.0 * rng.f64() };
        let load = 14.0 + 6.0 * rng.f64();
        let settings = [("Pb", bending), ("Pr", rotating), ("load", load)];
        let settings: Vec<_> = settings.map(|(key, value)| (key.to_owned(), format!("{value}"))).to_vec();
        let model = read(&root("tests/cases/soft_arm.toml"), &settings).expect("a network");
        contradicted.extend(judge(model, &format!("{settings:?}")).1);
    }
    assert!(contradicted.is_empty(), "{contradicted:#?}");
}

/// At 18 g and full bending pressure the arm leaves its plane, from any number of increments to the same side.
#[test]
fn the_loaded_arm_buckles_sideways_from_any_number_of_increments() {
    let text = std::fs::read_to_string(root("tests/cases/soft_arm.toml")).expect("a network");
    let settings = [("Pr", "0.1"), ("Pb", "172.36"), ("load", "18")].map(|(a, b)| (a.to_owned(), b.to_owned()));
    for increments in ["", "increments = 3\n", "increments = 20\n"] {
        let text = text.replace("name = \"inflate\"\n", &format!("name = \"inflate\"\n{increments}"));
        let model = read_text("arm.toml", &text, &settings).expect("a network");
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("a solution");
        let y = solution.probes.steps[1].increments.last().expect("a state")[1];
        assert!((y + 51.9679).abs() < 1e-3, "{increments}: y = {y}");
    }
}
