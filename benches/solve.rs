//! Whole solves, from the file to the equilibrium, with the error that comes with the time.

use std::path::{Path, PathBuf};

use criterion::{Criterion, criterion_group, criterion_main};
use pennate::{Input, Job};
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::discretize;
use pennate_solver::history::History;
use pennate_solver::options::Options;
use pennate_solver::structure::{Step, Structure};
use serde_json::Value;

/// A network, the steps of it that are solved, and where a reference gives a displacement at their end.
struct Case {
    name: &'static str,
    file: &'static str,
    settings: &'static [(&'static str, &'static str)],
    /// One step alone; all of them without.
    step: Option<&'static str>,
    accuracy: f64,
    reference: Option<Reference>,
}

struct Reference {
    file: &'static str,
    at: &'static str,
    node: &'static str,
}

const PEERS: &str = "validation/peers/reference.json";

const CASES: [Case; 6] = [
    Case {
        name: "dyad",
        file: "models/networks/dyad.toml",
        settings: &[],
        step: None,
        accuracy: 1e-6,
        reference: None,
    },
    Case {
        name: "elastica, k = 10, slenderness 1e4",
        file: "validation/02_elastica_tip_load/reissner.toml",
        settings: &[("EA", "1e8")],
        step: Some("k = 10"),
        accuracy: 1e-6,
        reference: Some(Reference {
            file: "validation/02_elastica_tip_load/reference.json",
            at: "/results_reissner/13/quantities/tip/displacement",
            node: "T",
        }),
    },
    Case {
        name: "45-degree bend",
        file: "validation/04_bathe_bolourchi_bend/one_step.toml",
        settings: &[],
        step: None,
        accuracy: 1e-6,
        reference: Some(Reference {
            file: "validation/04_bathe_bolourchi_bend/reference.json",
            at: "/results/2/quantities/tip/displacement",
            node: "T",
        }),
    },
    Case {
        name: "P6-4",
        file: "validation/peers/p6_4.toml",
        settings: &[],
        step: None,
        accuracy: 1e-4,
        reference: Some(Reference { file: PEERS, at: "/results/0/quantities/top/displacement", node: "r4n0" }),
    },
    Case {
        name: "P6-16",
        file: "validation/peers/p6_16.toml",
        settings: &[],
        step: None,
        accuracy: 1e-4,
        reference: Some(Reference { file: PEERS, at: "/results/1/quantities/top/displacement", node: "r16n0" }),
    },
    Case {
        name: "P6-36",
        file: "validation/peers/p6_36.toml",
        settings: &[],
        step: None,
        accuracy: 1e-4,
        reference: Some(Reference { file: PEERS, at: "/results/2/quantities/top/displacement", node: "r36n0" }),
    },
];

impl Case {
    fn input(&self) -> Input {
        let settings = self.settings.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        Input { file: path(self.file), settings }
    }
}

impl Reference {
    /// Distance of the last displacement to this one, over its norm.
    fn error(&self, names: &[String], history: &History) -> Option<f64> {
        let text = std::fs::read_to_string(path(self.file)).ok()?;
        let document: Value = serde_json::from_str(&text).ok()?;
        let expected: [f64; 3] = serde_json::from_value(document.pointer(self.at)?.clone()).ok()?;
        let state = &history.steps.last()?.increments.last()?.state;
        let found = state.nodes[names.iter().position(|name| name == self.node)?].displacement;
        let norm = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        Some(norm(std::array::from_fn(|axis| found[axis] - expected[axis])) / norm(expected))
    }
}

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn solve(structure: &Structure, steps: &[Step], options: &Options) -> History {
    pennate_solver::solve(structure, steps, options, &mut |_| true).expect("no mechanism")
}

fn whole(criterion: &mut Criterion) {
    for case in &CASES {
        let name = case.name;
        let input = case.input();
        let plain = Options::default();
        let estimate = Options { estimate: true, ..Options::default() };
        let model = pennate::read(&input).expect("a network of the repository");
        let names: Vec<String> = model.nodes.iter().map(|node| node.name.clone()).collect();
        let only = case.step.map(|name| model.step_names().iter().position(|step| *step == name).expect("a step"));

        // The mesh that the accuracy needs, found as the program finds it.
        let solution = solve_to_accuracy(model, case.accuracy, &estimate, &mut |_| true).expect("no mechanism");
        let (structure, mut steps) = discretize(&solution.model, &solution.mesh);
        if let Some(step) = only {
            steps = vec![steps.swap_remove(step)];
        }
        let history = solve(&structure, &steps, &plain);
        let factorizations: usize = history.steps.iter().map(|step| step.factorizations).sum();
        print!("{name}: order {}, {} unknowns, ", solution.mesh.order, history.mesh.unknowns);
        print!("{} meshes tried, {factorizations} factorizations", solution.accuracy.rounds);
        let error = case.reference.as_ref().and_then(|reference| reference.error(&names, &history));
        println!("{}", error.map(|error| format!(", error {error:.1e}")).unwrap_or_default());

        criterion.bench_function(&format!("{name}: reading"), |bencher| bencher.iter(|| pennate::read(&input)));
        criterion.bench_function(&format!("{name}: solve"), |bencher| {
            bencher.iter(|| solve(&structure, &steps, &plain));
        });
        criterion.bench_function(&format!("{name}: solve and estimate"), |bencher| {
            bencher.iter(|| solve(&structure, &steps, &estimate));
        });
        if only.is_none() {
            let job = Job { input, accuracy: case.accuracy, threads: None, shapes: false };
            criterion.bench_function(&format!("{name}: read, meshed, solved and estimated"), |bencher| {
                bencher.iter(|| pennate::run(&job, &mut |_| true));
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = whole
}
criterion_main!(benches);
